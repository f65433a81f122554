//! Ghosts of crossing motions, aliases of a periodic texture, and duplicates: the verdict on each feature.

use super::probing::{blobs, cache, slopes_of};
use crate::prelude::*;
use burstscope_core::inspect::place::{
    Judged, ProbeOptions, ProbeSubject, SuspicionKind, Verdict, fate_of, judged, probe,
};

/// Two groups of blobs that move to the right and to the left, with a ghost wherever two paths cross. In each row one
/// of each meets another.
fn crossing() -> (Burst, Vec<(f32, f32, Slope)>) {
    let mut all = Vec::new();
    for (row, v) in [16.0f32, 40.0, 64.0].into_iter().enumerate() {
        let shift = 4.0 * row as f32;
        for (u, slope) in [(40.0 + shift, 2.0), (80.0 + shift, -2.0), (100.0 - shift, 2.0), (24.0 - shift, -2.0)] {
            all.push((u, v + 4.0 * slope, Slope::new(slope, 0.0)));
        }
    }
    let drawn: Vec<(f32, f32, f32, f32, Slope)> = all.iter().map(|&(u, v, slope)| (u, v, 2.5, 0.25, slope)).collect();
    (blobs(11, 0.004, &drawn), all)
}

/// A search in which ghosts stay: at each slope for itself.
fn params() -> DetectorParams {
    DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 13), octaves: 2, ..DetectorParams::default() }
}

fn is_true(feature: &Feature, truth: &[(f32, f32, Slope)]) -> bool {
    let near = |(u, v, slope): &(f32, f32, Slope)| {
        (feature.u - u).hypot(feature.v - v) < 2.0 && (feature.slope.u - slope.u).abs() < 0.5
    };
    feature.response < 0.0 && truth.iter().any(near)
}

fn judge(cache: &ProbeCache) -> Vec<Judged> {
    judged(&cache.trail, &quiet()).expect("not cancelled")
}

/// Numbers of features by verdict, in the order of [`Verdict::ALL`].
fn counts<'j>(judged: impl Iterator<Item = &'j Judged>) -> [usize; 5] {
    let mut counts = [0; 5];
    judged.for_each(|judged| counts[judged.verdict as usize] += 1);
    counts
}

#[test]
fn blobs_of_two_crossing_motions_are_real_and_what_lies_between_their_slopes_is_a_ghost() {
    let (burst, truth) = crossing();
    let cache = cache(&burst, &params());
    let (features, judged) = (&cache.detection().features, judge(&cache));
    // The search looks at the frames alone, and not at the picture around.
    let is_by_frames =
        |judged: &Judged| judged.verdict == Verdict::Ghost && !judged.why.contains("the picture around it");
    let is_said_alike = |(f, judged): (&Feature, &Judged)| (f.moves == Moves::Ghost) == is_by_frames(judged);
    assert!(features.iter().zip(&judged).all(is_said_alike), "the search names the same ones");
    let (mut of_true, mut of_others) = (Vec::new(), Vec::new());
    for (feature, judged) in features.iter().zip(&judged) {
        // Hollows between blobs of one motion move with it. What moves by neither is a ghost.
        let is_between = feature.slope.u.abs() < 1.4;
        match () {
            () if is_true(feature, &truth) => of_true.push(judged),
            () if is_between => of_others.push(judged),
            () => {}
        }
    }
    let found = truth.iter().filter(|&one| features.iter().any(|f| is_true(f, std::slice::from_ref(one)))).count();
    assert_eq!(found, truth.len(), "all are found");
    let [true_ones, others] = [of_true, of_others].map(|judged| counts(judged.into_iter()));
    let [real, ghosts, ..] = true_ones;
    assert!(10 * real >= 9 * true_ones.iter().sum::<usize>() && ghosts == 0, "{true_ones:?}");
    // The others lie at wrong slopes.
    let [real, ghosts, ..] = others;
    assert!(ghosts >= 6 && 5 * real <= others.iter().sum::<usize>(), "{others:?}");
    let ghost = judged.iter().find(|judged| judged.verdict == Verdict::Ghost).expect("one");
    assert!(ghost.coherence.is_some_and(|c| c < 0.6) && ghost.why.contains("crosses its path"), "{ghost:?}");
}

#[test]
fn the_probe_suspects_a_ghost_as_the_table_does_and_a_periodic_texture_has_aliases() {
    let (burst, _) = crossing();
    let open = cache(&burst, &params());
    let judged = judge(&open);
    let index = judged.iter().position(|judged| judged.verdict == Verdict::Ghost).expect("one");
    let options = ProbeOptions { wanted: ProbeSubject::Feature(index), ..ProbeOptions::default() };
    let probed = probe(&open, [0.0, 0.0], &options, &quiet()).expect("a feature");
    assert_eq!(probed.judged.as_ref(), Some(&judged[index]));
    let ghost = probed.suspicions.iter().find(|suspicion| suspicion.kind == SuspicionKind::Ghost).expect("suspected");
    assert_eq!(Some(ghost.number), judged[index].coherence);
    assert!(ghost.evidence.contains("crosses its path") && ghost.change.is_none(), "{ghost:?}");
    let example = Example::Aliasing;
    let cache = cache(&example.burst(), &DetectorParams { slopes: slopes_of(example), ..DetectorParams::default() });
    let judged = judge(&cache);
    let [_, _, aliases, ..] = counts(judged.iter());
    assert!(aliases > 4, "{:?}", counts(judged.iter()));
    let alias = judged.iter().find(|judged| judged.verdict == Verdict::Alias).expect("one");
    assert!(alias.why.starts_with("the texture repeats every"), "{alias:?}");
}

#[test]
fn a_blob_that_is_kept_twice_has_a_duplicate() {
    let all: Vec<(f32, f32, f32, f32, Slope)> =
        (0..8).map(|i| (20.0 + 12.0 * i as f32, 30.0 + 5.0 * i as f32, 2.5, 0.2, Slope::new(0.5, 0.0))).collect();
    let burst = blobs(9, 0.01, &all);
    let params = DetectorParams { distinct: Distinct::Radius(0.05), distinct_scale: 1.05, ..params() };
    let cache = cache(&burst, &params);
    let judged = judge(&cache);
    let [_, _, _, duplicates, _] = counts(judged.iter());
    assert!(duplicates >= 8, "{:?}", counts(judged.iter()));
    // One of them can be removed by the change that its suspicion proposes.
    let mut removed = 0;
    for index in (0..judged.len()).filter(|&index| judged[index].verdict == Verdict::Duplicate).take(6) {
        let options = ProbeOptions { wanted: ProbeSubject::Feature(index), ..ProbeOptions::default() };
        let probed = probe(&cache, [0.0, 0.0], &options, &quiet()).expect("a feature");
        let suspicion = probed.suspicions.iter().find(|s| s.kind == SuspicionKind::Duplicate).expect("suspected");
        let Some(change) = &suspicion.change else { continue };
        let sample = probed.subject_fate().expect("a feature").of_sample();
        let after = super::probing::cache(&burst, &change.applied(&params).expect("valid"));
        let fate = fate_of(&after.trail, &sample, &quiet()).expect("not cancelled").expect("examined");
        assert_eq!(fate.first_failed, Some(Test::Duplicate), "{change:?}");
        removed += 1;
    }
    assert!(removed > 0, "no change was proposed");
}

#[test]
fn what_noise_alone_gives_is_not_said_to_be_real_and_nothing_is_promised_to_it() {
    let (mut real, mut all) = ([0; 2], [0; 2]);
    for case in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::HotPixels, NoiseCase::Jpeg(60)] {
        for gate in [NoiseGate::Auto, NoiseGate::Matching] {
            let burst = case.burst((500, 400), 8, 0.02, 3, &quiet()).expect("noise");
            let params =
                DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 7), noise_gate: gate, ..Default::default() };
            let (cache, mut weak) = (cache(&burst, &params), 0);
            let verdicts = counts(judge(&cache).iter());
            println!("{case:?} {gate:?}: {verdicts:?}");
            let of_gate = usize::from(gate == NoiseGate::Matching);
            real[of_gate] += verdicts[Verdict::Real as usize];
            all[of_gate] += cache.detection().features.len();
            for place in (0..40).map(|i| [20.0 + 60.0 * (i % 8) as f32, 30.0 + 80.0 * (i / 8) as f32]) {
                let probe = probe(&cache, place, &ProbeOptions::default(), &quiet()).expect("inside");
                let Some(fate) = probe.subject_fate().filter(|fate| fate.snr < 2.4) else { continue };
                assert!(fate.remedy.is_none() && probe.outlook.is_none(), "{fate:?}");
                weak += 1;
            }
            assert!(weak > 2, "{case:?}: {weak}");
        }
    }
    // Chance lets few bursts have more keypoints than noise gives as a rule.
    assert!(real[0] <= 3 && 50 * real[1] <= all[1] && all[1] > 300, "{real:?} of {all:?}");
}
