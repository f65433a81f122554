//! Searches in groups of slopes, cut first or continued from another have the bits of the whole search.

use super::*;
use crate::detector::feature::Feature;
use crate::detector::memory::{Plan, SearchSize, estimate, on_threads};
use crate::detector::params::{
    Distinct, FrameRange, Localisation, Method, NoiseGate, NoiseModelKind, Rules, SlopeAxis, SlopeExtrema,
    SlopeNeighbours,
};
use crate::detector::scale_space::octave_pixel;
use crate::detector::{Slope, SlopeGrid, Test};
use crate::error::Result;
use crate::plane::tile::Region;
use crate::synth::chart::draw_disc;
use crate::synth::random::Stream;
use crate::synth::{SceneParams, synth_scene};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::sync::Mutex;

fn scene(seed: u64, size: (usize, usize)) -> Burst {
    let (width, height) = size;
    let params = SceneParams { width, height, frames: 5, layers: 2, snr: 6.0, seed, ..SceneParams::default() };
    synth_scene(&params, &Monitor::default()).expect("valid parameters").0
}

/// Budget within which no more than `slopes` slopes of a search are held at once.
fn budget_for(burst: &Burst, params: &DetectorParams, slopes: usize) -> u64 {
    let slopes = if slopes == 1 { SlopeGrid::single(Slope::default()) } else { SlopeGrid::line(0.0..=1.0, slopes) };
    estimate(&DetectorParams { slopes, ..params.clone() }, burst.len(), burst.size())
}

/// Searches with all of `budget` bytes, whatever other tests of this process take at the same time.
fn search_within(burst: &Burst, params: &DetectorParams, budget: Option<u64>) -> Result<Trail> {
    search_all(burst, params, &Account::new(), budget, Some(Keeping::ANEW), &Monitor::default())
}

/// Searches in all kinds of groups, and compares each result with the whole search's. Returns the numbers of groups.
fn assert_same_in_groups(burst: &Burst, params: &DetectorParams) -> Vec<usize> {
    let whole = search_within(burst, params, None).expect("valid").ready();
    let count = params.used_slopes().len();
    let mut counts = Vec::new();
    for slopes in 1..count {
        let budget = budget_for(burst, params, slopes);
        let wanted = SearchSize { params, frames: burst.len(), size: burst.size() };
        let Ok(plan) = Plan::new(wanted, Some(budget)) else { continue };
        // With fewer threads the whole may fit, so that nothing is divided.
        if plan.threads < rayon::current_num_threads() || counts.contains(&plan.describe.len()) {
            continue;
        }
        assert!(plan.search.len() > 1 && plan.search.iter().all(|group| group.visited.len() <= slopes), "{plan:?}");
        counts.push(plan.describe.len());
        let found = search_within(burst, params, Some(budget)).expect("it fits").ready();
        assert!(found.outcome.bases.is_none() && whole.outcome.bases.is_some());
        assert_eq!(found.keypoints(), whole.keypoints(), "{plan:?}");
        let covered = |trail: &Trail| (0..trail.keypoints().len()).map(|k| trail.covered_by(k)).collect::<Vec<_>>();
        assert_eq!(covered(&found), covered(&whole));
        let without_times = |detection: &Detection| Detection { times: StageTimes::default(), ..detection.clone() };
        assert!(without_times(found.detection()) == without_times(whole.detection()), "{plan:?}");
        let count = whole.detection().features.len();
        assert_eq!(of_features(&found, count), of_features(&whole, count));
        assert_same_answers(&found, &whole);
    }
    counts
}

fn of_features(trail: &Trail, count: usize) -> Vec<usize> {
    (0..count).map(|index| trail.keypoint_of_feature(index)).collect()
}

fn assert_same_answers(found: &Trail, whole: &Trail) {
    let monitor = Monitor::default();
    for octave in whole.octaves() {
        let (width, height) = whole.octave_size(octave);
        let region = Region { columns: width / 3..width / 3 + 4, rows: height / 2..height / 2 + 3 };
        let around = |trail: &Trail| trail.neighbourhood(octave, &region, &monitor).expect("not cancelled");
        let (a, b) = (around(found), around(whole));
        assert_eq!(a.tiles.len(), b.tiles.len());
        let samples: Vec<Sample> = (0..a.tiles.len())
            .flat_map(|slope_index| region.columns.clone().map(move |x| (slope_index, x)))
            .map(|(slope_index, x)| Sample { octave, level: 1, slope_index, x, y: height / 2 })
            .collect();
        assert_eq!(found.judge(&a, &samples), whole.judge(&b, &samples));
    }
}

fn grids() -> impl Strategy<Value = SlopeGrid> {
    let line = |(count, direction): (usize, f32)| SlopeGrid::line_along(direction.round(), -1.5..=1.5, count);
    prop_oneof![
        (2usize..10, -90f32..90.0).prop_map(line),
        (2usize..5, 2usize..5).prop_map(|(u, v)| SlopeGrid::plane(-1.0..=1.0, u, -1.0..=0.5, v)),
        (2usize..7).prop_map(|v| SlopeGrid::plane(0.5..=0.5, 1, -1.0..=1.0, v)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, rng_seed: RngSeed::Fixed(15), ..ProptestConfig::default() })]

    #[test]
    fn groups_of_slopes_find_what_the_whole_search_finds(
        grid in grids(),
        joint in any::<bool>(),
        all in any::<bool>(),
        continuous in any::<bool>(),
        distinct in any::<bool>(),
        field in any::<bool>(),
        first_octave in -1i32..2,
        max_features in prop_oneof![Just(0usize), Just(9)],
        seed in 1u64..500,
    ) {
        let burst = scene(seed, (75, 66));
        let params = DetectorParams {
            slopes: grid,
            search: if field { SearchSlopes::Field } else { SearchSlopes::All },
            slope_extrema: if joint { SlopeExtrema::Joint } else { SlopeExtrema::Each },
            rules: Rules {
                slope_neighbours: if all { SlopeNeighbours::All } else { SlopeNeighbours::Adjacent },
                localisation: if continuous { Localisation::Continuous } else { Localisation::Quadratic },
                ..Rules::default()
            },
            distinct: if distinct { Distinct::default() } else { Distinct::Off },
            first_octave,
            octaves: 3,
            levels: 3,
            max_features,
            ..DetectorParams::default()
        };
        let counts = assert_same_in_groups(&burst, &params);
        prop_assert!(!(joint && all) || counts.is_empty(), "all slopes are needed at once");
    }
}

/// Compares a search for at most `max_features` features with the search for all, cut afterwards.
fn assert_cut_first_is_cut_afterwards(burst: &Burst, params: &DetectorParams, max_features: usize) {
    let all = search_within(burst, &DetectorParams { max_features: 0, ..params.clone() }, None).expect("fits").ready();
    let cut = search_within(burst, &DetectorParams { max_features, ..params.clone() }, None).expect("fits").ready();
    let (expected, found) = (all.detection(), cut.detection());
    let count = max_features.min(expected.features.len());
    assert_eq!(found.features, expected.features[..count], "{params:?}");
    assert!(found.descriptors == expected.descriptors[..count], "{params:?}");
    assert_eq!(of_features(&cut, cut.ranked()), of_features(&all, expected.features.len()));
    for index in 0..all.keypoints().len() {
        if cut.is_cut(index) {
            assert!(cut.rank_uncut(index) >= count);
            assert_eq!(cut.fails_uncut(index), all.covered_by(index).map(|_| Test::Duplicate));
        } else {
            assert_eq!(cut.covered_by(index), all.covered_by(index));
        }
    }
    // The tally counts each sample once, and those that reach the choice as the search for all does.
    let (before, after) = (expected.tally, found.tally);
    assert_eq!(after.samples, after.rejected.iter().sum::<u64>() + after.kept);
    for test in Test::ALL.into_iter().filter(|test| ![Test::Duplicate, Test::MaxFeatures].contains(test)) {
        assert_eq!(after.rejected_by(test), before.rejected_by(test));
    }
    assert!(after.kept as usize <= count && (count == 0 || after.kept > 0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: RngSeed::Fixed(16), ..ProptestConfig::default() })]

    #[test]
    fn what_is_cut_first_is_what_is_cut_afterwards(
        grid in grids(),
        joint in any::<bool>(),
        distinct in prop_oneof![Just(None), (0.5f32..3.0).prop_map(Some)],
        max_orientations in 1usize..5,
        max_features in prop_oneof![Just(1usize), 2usize..40, 40usize..400],
        noiseless in any::<bool>(),
        seed in 1u64..500,
    ) {
        let mut burst = scene(seed, (150, 130));
        if noiseless {
            // Two halves alike, so that many keypoints are equally strong.
            for frame in &mut burst.frames {
                let half = frame.clone();
                *frame = std::sync::Arc::new(Plane::from_fn(150, 130, |u, v| half.row(v)[u % 75]));
            }
        }
        let params = DetectorParams {
            slopes: grid,
            slope_extrema: if joint { SlopeExtrema::Joint } else { SlopeExtrema::Each },
            distinct: distinct.map_or(Distinct::Off, Distinct::Radius),
            max_orientations,
            noise_gate: NoiseGate::Factor(3.0),
            octaves: 3,
            levels: 3,
            ..DetectorParams::default()
        };
        assert_cut_first_is_cut_afterwards(&burst, &params, max_features);
    }
}

#[test]
fn where_thousands_are_cut_the_strongest_are_the_same_and_the_rest_is_not_compared() {
    let burst = scene(5, (400, 300));
    let slopes = SlopeGrid::plane(-1.0..=1.0, 3, -1.0..=1.0, 3);
    let params = DetectorParams { slopes, noise_gate: NoiseGate::Factor(2.5), ..DetectorParams::default() };
    for max_features in [20, 300, 1000] {
        assert_cut_first_is_cut_afterwards(&burst, &params, max_features);
    }
    let tally = |max_features| {
        search_within(&burst, &DetectorParams { max_features, ..params.clone() }, None).expect("fits").detection.tally
    };
    let (few, all) = (tally(20), tally(0));
    assert!(10 * few.rejected_by(Test::Duplicate) < all.rejected_by(Test::Duplicate), "{few:?} {all:?}");
    assert_eq!(all.rejected_by(Test::MaxFeatures), 0);
}

#[test]
fn one_slope_has_no_others_to_compare_with() {
    let burst = scene(3, (120, 90));
    for method in [Method::Buff, Method::Sift] {
        let [each, joint] = [SlopeExtrema::Each, SlopeExtrema::Joint].map(|slope_extrema| {
            let slopes = SlopeGrid::single(Slope::default());
            let params = DetectorParams { method, slopes, slope_extrema, octaves: 3, ..DetectorParams::default() };
            search_within(&burst, &params, None).expect("fits").detection
        });
        assert!(!each.features.is_empty());
        assert_eq!((&each.features, &each.descriptors), (&joint.features, &joint.descriptors), "{method:?}");
        assert_eq!((each.noise_gate_factor, &each.tally), (joint.noise_gate_factor, &joint.tally));
    }
}

/// Motions of the left and of the right half of [`two_motions`].
const MOTIONS: [Slope; 2] = [Slope::new(2.0, 0.0), Slope::new(-1.0, -2.0)];

/// Discs in noise, which move otherwise on the left than on the right.
fn two_motions(frames: usize) -> Burst {
    let mut stream = Stream::new(7, 0);
    let mut at = |size: f64| size * stream.uniform();
    let discs: Vec<[f64; 3]> = (0..400).map(|_| [at(400.0), at(300.0), 2.0 + at(4.0)]).collect();
    let frame = |t: usize| {
        let mut stream = Stream::new(8, t as u64);
        let mut frame = Plane::from_fn(400, 300, |_, _| 0.3 + 0.02 * stream.normal() as f32);
        let time = t as f64 - 0.5 * (frames as f64 - 1.0);
        for [u, v, radius] in &discs {
            let slope = MOTIONS[usize::from(*u > 200.0)];
            let (u, v) = (u + time * f64::from(slope.u), v + time * f64::from(slope.v));
            draw_disc(&mut frame, u, v, *radius, 0.08);
        }
        frame
    };
    Burst::from_planes("two motions", (0..frames).map(frame).collect())
}

fn around(search: SearchSlopes, slope_extrema: SlopeExtrema) -> DetectorParams {
    let slopes = SlopeGrid::plane(-4.0..=4.0, 9, -4.0..=4.0, 9);
    DetectorParams { search, slope_extrema, slopes, distinct: Distinct::Off, octaves: 4, ..DetectorParams::default() }
}

#[test]
fn around_the_field_is_found_what_all_slopes_find_there() {
    let burst = two_motions(9);
    for extrema in [SlopeExtrema::Each, SlopeExtrema::Joint] {
        let of = |search| search_within(&burst, &around(search, extrema), None).expect("fits").ready();
        let (all, field) = (of(SearchSlopes::All), of(SearchSlopes::Field));
        let place = |k: &Keypoint| k.sample.map(|at| at as f32 * octave_pixel(k.octave));
        let sorted = |mut keypoints: Vec<Keypoint>| {
            keypoints.sort_by_key(|k| (k.octave, k.level, k.slope_index, k.sample));
            keypoints
        };
        let there = all.keypoints().iter().filter(|k| field.searches(place(k), k.slope_index));
        let found = sorted(field.keypoints().to_vec());
        assert_eq!(found, sorted(there.copied().collect()), "{extrema:?}");
        assert!(5 * found.len() < 4 * all.keypoints().len(), "{} of {}", found.len(), all.keypoints().len());
        let (whole, part) = (all.detection(), field.detection());
        assert!(part.features.iter().all(|feature| whole.features.contains(feature)), "{extrema:?}");
        assert_eq!(part.tally.samples + part.tally.not_searched, whole.tally.samples);
        assert!(4 * part.tally.samples < 3 * whole.tally.samples, "{:?}", part.tally);
        for (motion, columns) in MOTIONS.into_iter().zip([20.0..170.0, 230.0..380.0]) {
            let count = |detection: &Detection| {
                let moves = |f: &&Feature| (f.slope.u - motion.u).hypot(f.slope.v - motion.v) < 0.5;
                detection.features.iter().filter(|f| columns.contains(&f.u)).filter(moves).count()
            };
            assert!(count(whole) > 20 && count(part) == count(whole), "{motion:?}: {}", count(part));
        }
    }
}

#[test]
fn what_is_not_searched_is_not_judged_and_its_samples_are_those_of_the_whole_search() {
    let burst = two_motions(9);
    let of = |search| search_within(&burst, &around(search, SlopeExtrema::Each), None).expect("fits").ready();
    let (all, field) = (of(SearchSlopes::All), of(SearchSlopes::Field));
    for octave in 0..3 {
        let (x, y) = (60 >> octave, 150 >> octave);
        let region = Region { columns: x..x + 1, rows: y..y + 1 };
        let samples = |trail: &Trail| trail.neighbourhood(octave, &region, &Monitor::default()).expect("not cancelled");
        let (whole, part) = (samples(&all), samples(&field));
        let mut left_out = 0;
        for slope_index in 0..part.tiles.len() {
            let of = |around: &Neighbourhood| (0..3).map(|s| around.tiles[slope_index].at(s, x, y)).collect::<Vec<_>>();
            assert_eq!(of(&whole), of(&part), "octave {octave}, slope {slope_index}");
            let sample = Sample { octave, level: 1, slope_index, x, y };
            let searched = field.searches([60.0, 150.0], slope_index);
            assert_eq!(field.judge(&part, &[sample])[0].is_some(), searched);
            left_out += usize::from(!searched);
        }
        assert!(left_out > 20, "{left_out}");
    }
}

#[test]
fn a_search_around_the_field_is_the_same_on_any_threads_and_all_slopes_where_there_is_no_field() {
    let on = |threads: usize, burst: &Burst, search: SearchSlopes| {
        let found = on_threads(threads, || search_within(burst, &around(search, SlopeExtrema::Each), None));
        Detection { times: StageTimes::default(), ..found.expect("fits").detection }
    };
    let burst = two_motions(9);
    assert!(on(1, &burst, SearchSlopes::Field) == on(3, &burst, SearchSlopes::Field));
    let short = two_motions(2);
    assert!(on(2, &short, SearchSlopes::Field) == on(2, &short, SearchSlopes::All));
}

/// Another range with steps of `step`: moved by whole steps, and perhaps with half of the step, or fewer slopes.
fn axis_near(step: f32, ends: (i32, i32), is_finer: bool) -> SlopeAxis {
    let (first, last) = (ends.0.min(ends.1), ends.0.max(ends.1) + 1);
    let count = (last - first) as usize * if is_finer { 2 } else { 1 } + 1;
    SlopeAxis::new(first as f32 * step..=last as f32 * step, count)
}

fn axes() -> impl Strategy<Value = (SlopeAxis, SlopeAxis)> {
    let ends = || (-3i32..3, -3i32..3);
    (prop_oneof![Just(0.54f32), Just(1.0 / 3.0), Just(0.7)], ends(), ends(), any::<bool>())
        .prop_map(|(step, one, other, is_finer)| (axis_near(step, one, false), axis_near(step, other, is_finer)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: RngSeed::Fixed(39), ..ProptestConfig::default() })]

    #[test]
    fn a_search_that_goes_on_from_another_is_a_new_search(
        (u, then_u) in axes(),
        (v, then_v) in axes(),
        (was_plane, is_plane) in any::<(bool, bool)>(),
        turned in any::<bool>(),
        gates in prop_oneof![
            Just([NoiseGate::Auto; 2]),
            Just([NoiseGate::Factor(4.0); 2]),
            Just([NoiseGate::Factor(4.0), NoiseGate::Factor(5.0)])
        ],
        white in any::<bool>(),
        max_features in prop_oneof![Just(0usize), Just(9)],
        seed in 1u64..500,
    ) {
        let burst = scene(seed, (150, 110));
        let grid = |u: SlopeAxis, v: SlopeAxis, is_plane: bool| SlopeGrid {
            u,
            v: if is_plane { v } else { SlopeAxis::ZERO },
            direction_deg: if turned { 30.0 } else { 0.0 },
        };
        let noise_model = if white { NoiseModelKind::White } else { NoiseModelKind::Local };
        let was = DetectorParams {
            slopes: grid(u, v, was_plane), noise_gate: gates[0], noise_model, max_features, ..DetectorParams::default()
        };
        let then = DetectorParams { slopes: grid(then_u, then_v, is_plane), noise_gate: gates[1], ..was.clone() };
        let quiet = Monitor::default();
        let search = |earlier: Option<&Trail>, params: &DetectorParams| {
            let keeping = Keeping { earlier, ..Keeping::ANEW };
            search_all(&burst, params, &Account::new(), None, Some(keeping), &quiet).expect("valid").ready()
        };
        let (earlier, whole) = (search(None, &was), search(None, &then));
        let found = search(Some(&earlier), &then);
        prop_assert_eq!(found.keypoints(), whole.keypoints());
        let (a, b) = (found.detection(), whole.detection());
        prop_assert!(a.features == b.features && a.descriptors == b.descriptors && a.field == b.field);
        prop_assert!(a.noise == b.noise && a.noise_gate_factor == b.noise_gate_factor);
        prop_assert_eq!((a.tally.samples, a.tally.kept), (b.tally.samples, b.tally.kept));
        prop_assert_eq!(of_features(&found, a.features.len()), of_features(&whole, a.features.len()));
        assert_same_answers(&found, &whole);
        // A chain of searches is no different.
        let back = search(Some(&found), &was);
        prop_assert_eq!(back.keypoints(), earlier.keypoints());
    }
}

#[test]
fn a_long_search_shows_its_first_slope_and_goes_on_from_it() {
    let burst = scene(4, (640, 500));
    let params = |slopes| DetectorParams { slopes, noise_gate: NoiseGate::Factor(4.0), ..DetectorParams::default() };
    let search = |params: &DetectorParams, first: FirstFeatures<'_>| {
        let keeping = Keeping { earlier: None, first };
        let quiet = Monitor::default();
        search_all(&burst, params, &Account::new(), None, Some(keeping), &quiet).expect("valid").ready()
    };
    let long = params(SlopeGrid::line(-3.0..=3.0, 25));
    let shown = Mutex::new(Vec::new());
    let found = search(&long, &|first| shown.lock().expect("no panic").push(first));
    let shown = shown.into_inner().expect("no panic");
    assert_eq!(shown.len(), 1, "the features of one slope, once");
    let (first, slope) = (&shown[0], shown[0].slopes.slope(0));
    assert_eq!(first.slopes, SlopeGrid::single(slope));
    assert!(!first.features.is_empty() && found.detection().slopes.slopes().any(|other| other == slope));
    // A search that is not kept shows nothing before, and finds the same.
    let whole = search_all(&burst, &long, &Account::new(), None, None, &Monitor::default()).expect("valid").detection;
    let found = found.detection();
    assert!(found.features == whole.features && found.descriptors == whole.descriptors && found.tally == whole.tally);
    let nothing = |_| panic!("a search that is short, or no sum of searches, shows nothing before its end");
    search(&params(SlopeGrid::line(-3.0..=3.0, 7)), &nothing);
    search(&DetectorParams { slope_extrema: SlopeExtrema::Joint, ..long }, &nothing);
}

#[test]
fn a_wider_range_searches_only_its_new_slopes() {
    let burst = scene(4, (200, 150));
    let params =
        |slopes: SlopeGrid| DetectorParams { slopes, noise_gate: NoiseGate::Factor(4.0), ..DetectorParams::default() };
    let was = search_within(&burst, &params(SlopeGrid::line(-3.0..=3.0, 7)), None).expect("valid").ready();
    let known = |params: &DetectorParams| was.known_slopes(&burst, params);
    assert_eq!(known(&params(SlopeGrid::line(-4.0..=4.0, 9))), 7);
    assert_eq!(known(&params(SlopeGrid::line(-3.0..=3.0, 13))), 7);
    assert_eq!(known(&params(SlopeGrid::line(-2.0..=4.0, 7))), 6);
    assert_eq!(known(&params(SlopeGrid::line(-2.5..=2.5, 6))), 0);
    let joint = DetectorParams { slope_extrema: SlopeExtrema::Joint, ..params(SlopeGrid::line(-4.0..=4.0, 9)) };
    assert_eq!(known(&joint), 0, "its slopes are compared");
    let fewer =
        DetectorParams { frames: Some(FrameRange { start: 0, end: 4 }), ..params(SlopeGrid::line(-4.0..=4.0, 9)) };
    assert_eq!(known(&fewer), 0, "other frames");
    let white =
        DetectorParams { noise_model: NoiseModelKind::White, ..params(SlopeGrid::plane(-3.0..=3.0, 7, -1.0..=1.0, 3)) };
    assert_eq!(known(&white), 0, "another noise model");
    assert_eq!(known(&params(SlopeGrid::line(-5.0..=5.0, 11))), 0, "its noise is measured anew");
}
