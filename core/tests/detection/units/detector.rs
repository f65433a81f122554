//! Tests of the public functions of `detector`.

use crate::prelude::*;
use burstscope_core::detect::search;
use burstscope_core::detector::coherence::*;
use burstscope_core::detector::memory;
use burstscope_core::detector::noise::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::stack::*;
use burstscope_core::detector::view::*;
use burstscope_core::inspect::result::*;
use burstscope_core::inspect::words::grouped;

#[test]
fn few_features_are_explained_and_a_setting_is_offered_only_if_it_finds_more_than_noise() {
    let few = |burst: &Burst, params: &SearchParams| {
        let searched = search(burst, params, &quiet()).expect("a detection");
        too_few(burst, &searched, &quiet()).expect("not cancelled")
    };
    let chart =
        ChartParams { width: 240, height: 180, discs: 24, snr: 8.0, radius: 3.6..=9.0, ..ChartParams::default() };
    let clear = synth_chart(&chart, &quiet()).expect("a chart").0;
    // Faint blobs that move by 4 px/frame, slower than the slopes that are searched.
    let fast = |seed: u64| {
        let frame = |t: u64| {
            let mut noise = Stream::new(seed, t);
            Plane::from_fn(240, 180, |u, v| {
                let (x, y) = ((u as f32 - 4.0 * t as f32).rem_euclid(30.0) - 15.0, (v % 30) as f32 - 15.0);
                0.3 + 0.013 * (-(x * x + y * y) / 12.5).exp() + 0.02 * noise.normal() as f32
            })
        };
        Burst::from_planes("fast", (0..8).map(frame).collect())
    };
    let gate = |k| SearchParams { noise_gate: NoiseGate::Factor(k), ..SearchParams::default() };
    let at = |grid: SlopeGrid| SearchParams { slopes: grid.into(), ..SearchParams::default() };
    // On noise alone nothing helps, whatever is tried.
    let noises = [NoiseCase::White, NoiseCase::Correlated, NoiseCase::HotPixels, NoiseCase::Jpeg(60)];
    for burst in noises.map(|case| case.burst((240, 180), 6, 0.02, 4, &quiet()).expect("noise")) {
        for params in [gate(5.5), at(SlopeGrid::default()), at(SlopeGrid::single(Slope::default()))] {
            let found = few(&burst, &params).expect("noise has few");
            assert!(found.change.is_none() && !found.for_command().contains("try"), "{}: {found:?}", burst.name);
        }
        let found = few(&burst, &at(SlopeGrid::default())).expect("noise has few").for_command();
        assert!(found.ends_with("there is no more than noise alone gives"), "{found}");
    }
    // What is offered finds as many as it says, at a lower gate and over wider slopes.
    let too_fast = SearchParams { slopes: SlopeGrid::line(6.0..=9.0, 4).into(), ..gate(4.0) };
    let fast = (1..9).map(fast).find(|burst| few(burst, &too_fast).is_some()).expect("few are found in some");
    let peak = SearchParams { peak_threshold: 0.5, ..SearchParams::default() };
    for (burst, params, option) in [
        (&clear, gate(1000.0), "--noise-gate 4"),
        (&clear, peak, "--peak-threshold 0"),
        (&fast, too_fast, "--slopes-u 4:11:8"),
    ] {
        let found = few(burst, &params).expect("few");
        assert!(found.for_command().contains(&format!("; try {option}, which finds ")), "{found:?}");
        let (change, then) = found.change.expect("a setting that helps");
        let searched = search(burst, &params, &quiet()).expect("a detection");
        let again = detect(burst, &change.applied(&searched.params).expect("valid"), &quiet()).expect("a detection");
        assert_eq!((change.option().as_str(), then), (option, again.features.len()));
    }
    // An even picture has no remedy, and nothing breaks.
    let even = Burst::from_planes("even", vec![Plane::zeros(64, 48); 4]);
    assert!(few(&even, &SearchParams::default()).is_none_or(|found| found.change.is_none()));
    // A search that finds enough, or asks for few, needs no advice.
    assert_eq!(few(&clear, &SearchParams::default()), None);
    assert_eq!(few(&clear, &SearchParams { max_features: 2, ..SearchParams::default() }), None);
    assert_eq!([0, 7, 999, 1000, 12_345_678].map(grouped), ["0", "7", "999", "1 000", "12 345 678"]);
}

#[test]
fn level_answers_are_coherent_a_bump_is_its_part_and_noise_alone_says_nothing() {
    let level = evenness(&[(-0.1, 0.0); 10]);
    assert_eq!((level.coherence, level.shape), (Some(1.0), Shape::Level));
    // Three of ten respond: the coherence is 0.3.
    let bump: Vec<(f32, f32)> = (0..10).map(|t| (if (4..7).contains(&t) { 0.2 } else { 0.0 }, 0.005)).collect();
    let seen = evenness(&bump);
    assert!((seen.coherence.expect("clear") - 0.3).abs() < 0.02, "{seen:?}");
    assert_eq!(seen.shape, Shape::Bump);
    // Equal responses that are not side by side.
    let apart: Vec<(f32, f32)> = (0..10).map(|t| (if t % 4 == 1 { 0.2 } else { 0.0 }, 0.005)).collect();
    assert_eq!(evenness(&apart).shape, Shape::Uneven);
    let mut noise = Stream::new(4, 0);
    let (mut unclear, mut level) = (0, 0);
    for _ in 0..200 {
        let nothing: Vec<(f32, f32)> = (0..10).map(|_| (noise.normal() as f32, 1.0)).collect();
        unclear += usize::from(evenness(&nothing).shape == Shape::Unclear);
        let there: Vec<(f32, f32)> = (0..10).map(|_| (4.0 + noise.normal() as f32, 1.0)).collect();
        level += usize::from(evenness(&there).shape == Shape::Level);
    }
    assert!(unclear > 180 && level > 190, "{unclear} {level}");
}

proptest! {
    #[test]
    fn coherence_is_a_part_and_does_not_depend_on_sign_or_unit(
        values in prop::collection::vec(-1.0f32..1.0, 0..20), noise in 0.0f32..0.5, gain in 0.1f32..10.0,
    ) {
        let answers = |gain: f32| values.iter().map(|v| (gain * v, gain.abs() * noise)).collect::<Vec<_>>();
        let (a, b) = (evenness(&answers(1.0)), evenness(&answers(-gain)));
        prop_assert!(a.coherence.is_none_or(|c| (0.0..=1.0).contains(&c)));
        if let (Some(a), Some(b)) = (a.coherence, b.coherence) {
            prop_assert!((a - b).abs() < 1e-3);
        }
        prop_assert!(a.mean.is_finite() && a.unevenness.is_finite());
    }
}

#[test]
fn the_motion_said_is_that_of_the_place_unless_it_moves_otherwise() {
    let known = Feature { field: Slope::new(2.0, 0.5), field_sigma: 0.05, slope_sigma: 0.2, ..Feature::default() };
    let of = |u: f32, slope_sigma: f32, field_sigma: f32| {
        let feature = Feature { slope: Slope::new(u, 0.5), slope_sigma, field_sigma, ..known };
        let moves = Moves::by_numbers(&feature);
        (moves, Feature { moves, ..feature }.motion())
    };
    let own = Slope::new(-1.0, 0.5);
    assert_eq!(of(2.3, 0.2, 0.05), (Moves::WithSurroundings, (known.field, 0.05)));
    assert_eq!(of(-1.0, 0.2, 0.05), (Moves::ByItself, (own, 0.2)));
    assert_eq!(of(-1.0, 2.0, 0.05), (Moves::WithSurroundings, (known.field, 0.05)), "too faint to tell otherwise");
    assert_eq!(of(2.3, 0.05, 0.57), (Moves::WithSurroundings, (Slope::new(2.3, 0.5), 0.05)), "its own is surer");
    assert_eq!(of(2.8, 0.05, 0.57), (Moves::WithSurroundings, (known.field, 0.57)), "but does not quite agree");
    assert_eq!(of(-1.0, 0.9, f32::INFINITY), (Moves::Unknown, (own, 0.9)));
    for moves in [Moves::Edge, Moves::Ghost] {
        let feature = Feature { slope: own, slope_sigma: 0.2, moves, ..known };
        assert_eq!(feature.motion(), (known.field, 0.05));
        assert_eq!(Feature { field_sigma: f32::INFINITY, ..feature }.motion(), (own, 0.2));
    }
}

const SIZE: (usize, usize) = (1600, 1200);

fn plane(side: usize) -> DetectorParams {
    let slopes = SlopeGrid::plane(-3.0..=3.0, side, -3.0..=3.0, side);
    DetectorParams { slopes, ..DetectorParams::default() }
}

fn noisy_burst(sigma: f32, n: usize, scene: impl Fn(usize, usize) -> f32, round_to: f32) -> Burst {
    let mut noise = Stream::new(7, 0);
    let mut value = |u, v| {
        let value = scene(u, v) + sigma * noise.normal() as f32;
        if round_to > 0.0 { (value / round_to).round() * round_to } else { value }
    };
    let frames = (0..n).map(|_| Plane::from_fn(300, 200, &mut value)).collect();
    Burst { quantisation_step: round_to, ..Burst::from_planes("noise", frames) }
}

fn estimate(burst: &Burst) -> f32 {
    frame_noise(burst, 0..burst.len(), &quiet()).expect("not cancelled")
}

#[test]
fn the_noise_is_estimated_beside_edges_of_coarse_numbers_in_tiny_images_and_not_in_black_parts() {
    for sigma in [0.002f32, 0.01, 0.1] {
        let burst = noisy_burst(sigma, 4, |u, v| if (u / 40 + v / 50) % 2 == 0 { 0.2 } else { 0.6 }, 0.0);
        assert!((estimate(&burst) / sigma - 1.0).abs() < 0.03, "{sigma}: {}", estimate(&burst));
    }
    // 8-bit frames whose noise is none, half, one and two grey values; rounding adds a twelfth of a step².
    for grey_values in [0.0, 0.5f32, 1.0, 2.0] {
        let step = 1.0 / 255.0;
        let burst = noisy_burst(grey_values * step, 3, |u, _| 0.3 + u as f32 * 1e-4, step);
        let expected = (grey_values * grey_values + 1.0 / 12.0).sqrt() * step;
        assert!((estimate(&burst) / expected - 1.0).abs() < 0.05, "{grey_values}: {}", estimate(&burst));
    }
    let flat = |n: usize, size: usize| {
        estimate(&Burst::from_planes("flat", (0..n).map(|_| Plane::from_fn(size, size, |_, _| 0.3)).collect()))
    };
    assert_eq!((flat(3, 2), flat(1, 3), flat(2, 9)), (0.0, 0.0, 0.0));
    // Two thirds of the image are so dark that nearly all of their noise is cut off at zero.
    let (sigma, step) = (3.0 / 255.0, 1.0 / 255.0);
    let mut burst = noisy_burst(sigma, 3, |u, _| if u < 200 { -0.03 } else { 0.4 }, step);
    let cut = |frame: &Arc<Plane>| Arc::new(Plane::from_fn(300, 200, |u, v| frame.at(u, v).max(0.0)));
    burst.frames = burst.frames.iter().map(cut).collect();
    assert!((estimate(&burst) / sigma - 1.0).abs() < 0.06, "{}", estimate(&burst) / sigma);
}

#[test]
fn larger_searches_have_higher_gates_and_estimates_and_white_noise_the_bits_of_one_sigma() {
    let line = SlopeGrid::line(-3.0..=3.0, 7);
    let gate = |slopes, noise_gate| gate_factor(&DetectorParams { slopes, noise_gate, ..DetectorParams::default() });
    let one = gate(line, NoiseGate::Auto);
    assert!(gate(SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7), NoiseGate::Auto) > one + 0.2);
    // A tenth of the false alarms is about ln 10 / k more.
    assert!((gate(line, NoiseGate::Strict) - one - 10f32.ln() / one).abs() < 0.1);
    assert!((0.8..1.1).contains(&(one - gate(line, NoiseGate::Matching))));
    assert_eq!(gate(line, NoiseGate::Factor(4.5)), 4.5);
    let space = ScaleSpace::new(4, 0, 4.0);
    let slope = Slope::new(1.3, 0.2);
    let offsets = frame_offsets(&Positions::even(10), slope, Interpolation::Linear);
    let model = NoiseModel::white(0.0123);
    for (octave, level) in [(0, 0), (2, 3)] {
        let expected = 0.0123 * dog_noise_variance(&space, octave, f64::from(level), &offsets).sqrt() as f32;
        assert_eq!(model.sigma_d(&space, Scale { octave, level }, (slope, &offsets), 5.0), expected);
    }
    assert_eq!(model.place_factor(0, &offsets, (3, 4), (100, 80)), 1.0);
    let plane = plane(64);
    let fine = DetectorParams { first_octave: -1, ..plane.clone() };
    let of = |params: &DetectorParams| memory::estimate(params, 10, SIZE) as f64 / 1e9;
    assert!((8.0..13.0).contains(&of(&plane)) && (32.0..45.0).contains(&of(&fine)));
    assert!(of(&DetectorParams::default()) < 0.5);
    assert!(memory::estimate(&plane, usize::MAX >> 8, (1 << 30, 1 << 30)) > 1 << 60, "huge, and no overflow");
}

#[test]
fn every_parameter_of_the_detector_can_be_changed_alone() {
    let before = DetectorParams::default();
    let text_of = |record: Param<SearchParams>, params: &DetectorParams| record.text(&params.clone().into());
    for record in doc::ALL.into_iter().filter(|record| *record != doc::SLOPES) {
        let mut sample = SearchParams::default();
        let words = (record.field)(&mut sample).words().unwrap_or_default().iter().map(|(word, _)| *word);
        let others =
            words.chain(["-1:2:5", "1..4", "0.5", "4.25", "3"]).filter(|text| *text != text_of(record, &before));
        let changed = others.filter_map(|text| Some((text, ParamChange::new(record, text).applied(&before).ok()?)));
        let mut changed = changed.filter(|(text, after)| text_of(record, after) == **text);
        let (text, after) = changed.next_back().unwrap_or_else(|| panic!("{}: no other value", record.name));
        for other in doc::ALL.into_iter().filter(|_| record != doc::RULES) {
            let expected = if other == record { text.to_owned() } else { text_of(other, &before) };
            assert_eq!(text_of(other, &after), expected, "{} changed to {text}: {}", record.name, other.name);
        }
        let error = ParamChange::new(record, "nonsense").applied(&before).expect_err(record.name);
        assert_eq!(error.subject, record.name);
    }
    assert!(ParamChange::new(doc::SLOPES, "auto").applied(&before).is_err());
    assert!(ParamChange::new(doc::LEVELS, 0).applied(&before).is_err(), "checked");
    assert_eq!(ParamChange::new(doc::NOISE_GATE, "strict").option(), "--noise-gate strict");
}

#[test]
fn a_moving_point_is_where_it_was_at_mid_burst_and_a_map_of_the_noise_shows_where_it_is_stronger() {
    let frames: Vec<Plane> =
        (0..5).map(|t| Plane::from_fn(40, 20, |u, v| f32::from(u == 10 + 2 * t && v == 15 - t))).collect();
    let frames: Vec<&Plane> = frames.iter().collect();
    let (slope, monitor) = (Slope::new(2.0, -1.0), Monitor::default());
    let stack =
        motion_stack(&frames, &Positions::even(5), slope, Interpolation::Linear, &monitor).expect("not cancelled");
    assert_eq!(stack.at(14, 13), 1.0);
    assert_eq!(stack.data().iter().filter(|&&x| x != 0.0).count(), 1);
    let burst = NoiseCase::NoisyHalf.burst((640, 400), 6, 0.02, 7, &quiet()).expect("not cancelled");
    let map = |noise_model| {
        let params =
            DetectorParams { noise_model, slopes: SlopeGrid::line(-1.0..=1.0, 3), ..DetectorParams::default() };
        noise_map(&burst, &params, &quiet()).expect("a map")
    };
    let local = map(NoiseModelKind::Local);
    assert_eq!(local.size(), burst.size());
    for (u, sigma) in [(40, 0.02), (600, 0.06)] {
        assert!((local.at(u, 200) / sigma - 1.0).abs() < 0.2, "{u}: {}", local.at(u, 200));
    }
    let white = map(NoiseModelKind::White);
    assert!(white.data().iter().all(|x| *x == white.data()[0]) && white.at(0, 0) > 0.02);
}
