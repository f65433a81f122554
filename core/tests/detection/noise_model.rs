//! The noise model in whole detections: bursts whose noise is not white, and a chart under a lamp.

use crate::prelude::*;
use burstscope_core::{
    detector::noise_model::{LeftOut, WarningKind},
    synth::Camera,
    synth::Example,
};

fn params(noise_model: NoiseModelKind) -> DetectorParams {
    let noise_gate = "strict".parse().expect("a gate");
    DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 13), noise_model, noise_gate, ..DetectorParams::default() }
}

fn found(burst: &Burst, noise_model: NoiseModelKind) -> Detection {
    detect(burst, &params(noise_model), &quiet()).expect("detected")
}

/// Detections in two bursts of a kind of noise, given with its σ and its level, fractions of full scale.
fn of_noise((kind, sigma, level): (&str, f64, f64), size: (usize, usize)) -> [Detection; 2] {
    [31, 32].map(|seed| {
        let kind: NoiseKind = kind.parse().expect("a kind");
        let burst = kind.burst_at(level, size, 10, sigma, seed, &quiet()).expect("a burst");
        let detection = found(&burst, NoiseModelKind::Local);
        println!("{} at {level}, seed {seed}: {}", kind.name(), detection.features.len());
        detection
    })
}

/// Number of features in two bursts of each of `kinds`.
fn count_in_noise(kinds: &[(&str, f64, f64)], size: (usize, usize)) -> usize {
    kinds.iter().flat_map(|kind| of_noise(*kind, size)).map(|found| found.features.len()).sum()
}

#[test]
fn noise_as_cameras_make_it_gives_next_to_nothing() {
    // The white model finds tens to hundreds of features in each of these.
    for (case, white_finds) in [
        (NoiseCase::Doubled, 100),
        (NoiseCase::Jpeg(60), 20),
        (NoiseCase::Correlated, 100),
        (NoiseCase::BlackFrame, 5),
        (NoiseCase::NoisyFrame, 5),
        (NoiseCase::NoisyHalf, 5),
        (NoiseCase::ColumnStripes, 20),
        (NoiseCase::GrowingStripes, 20),
        (NoiseCase::GainFlicker, 1),
        (NoiseCase::DriftingStripes(3), 20),
        (NoiseCase::Varying(6), 5),
        (NoiseCase::Varying(2), 0),
        (NoiseCase::Banding, 5),
        (NoiseCase::StillBanding, 0),
        (NoiseCase::Smoothed, 20),
        (NoiseCase::FlickeringPixels, 1),
        (NoiseCase::NoisyColumns, 0),
        (NoiseCase::Negative, 0),
        (NoiseCase::DriftingStripes(15), 20),
        (NoiseCase::DriftingStripes(26), 20),
        (NoiseCase::DriftingStripes(40), 5),
        (NoiseCase::Fading(20), 5),
        (NoiseCase::CosmicStreaks, 5),
        (NoiseCase::FixedPattern(30), 1),
    ] {
        let burst = case.burst((480, 360), 10, 0.02, 11, &quiet()).expect("a burst");
        let [white, local] =
            [NoiseModelKind::White, NoiseModelKind::Local].map(|kind| found(&burst, kind).features.len());
        println!("{}: white {white}, local {local}", case.name());
        assert!(white >= white_finds, "{}: {white}", case.name());
        assert!(local <= 2, "{}: {local}", case.name());
    }
}

#[test]
fn frames_of_bits_have_the_noise_of_bits() {
    let mut all = 0;
    for (percent, frames) in [(3u8, 20), (3, 10), (10, 20), (30, 10), (60, 20), (97, 20)] {
        for seed in [31, 32, 33] {
            let case = NoiseCase::Bits(percent);
            let burst = case.burst((480, 360), frames, 0.02, seed, &quiet()).expect("a burst");
            let detection = found(&burst, NoiseModelKind::Local);
            println!("{} in {frames} frames, seed {seed}: {}", case.name(), detection.features.len());
            all += detection.features.len();
            let (noise, share) = (detection.noise, f32::from(percent) / 100.0);
            assert_eq!(noise.warnings, [], "{} seed {seed}", case.name());
            assert!((noise.frame_noise.powi(2) / (share * (1.0 - share)) - 1.0).abs() < 0.1, "{noise:?}");
        }
    }
    // Six a megapixel of 3.1 would be 19.
    assert!(all <= 8, "{all}");
}

#[test]
fn masked_bits_are_bits_and_two_neighbouring_values_of_a_converter_are_not() {
    let bits = NoiseCase::Bits(20).burst((240, 180), 8, 0.02, 5, &quiet()).expect("a burst");
    let with = |change: &dyn Fn(&Plane) -> Plane, step: f32| {
        let frames = bits.frames.iter().map(|frame| change(frame)).collect();
        let mut burst = Burst::from_planes("changed", frames);
        burst.quantisation_step = step;
        found(&burst, NoiseModelKind::Local).noise.transfer.bit
    };
    let from = |value: fn(f32, usize) -> f32| {
        move |frame: &Plane| Plane::from_fn(240, 180, |u, v| value(frame.at(u, v), u)).with_nan_masked()
    };
    assert_eq!(with(&from(|x, u| if u < 50 { f32::NAN } else { x }), 1.0), Some(1.0));
    assert_eq!(with(&from(|x, _| x * 200.0 / 255.0), 1.0 / 255.0), Some(200.0 / 255.0));
    assert_eq!(with(&from(|x, _| x / 255.0), 1.0 / 255.0), None);
}

#[test]
fn blocks_that_a_codec_flattened_are_no_evidence_of_low_noise() {
    let mut all = 0;
    for (case, level) in [("colour-jpeg-30", 0.2), ("colour-jpeg-30", 0.35), ("colour-jpeg-20", 0.2), ("jpeg-20", 0.2)]
    {
        for detection in of_noise((case, 0.02, level), (480, 360)) {
            all += detection.features.len();
            assert!(detection.noise.warnings.iter().any(|w| w.kind == WarningKind::FlattenedByCodec));
        }
    }
    // Six a megapixel; before, single bursts had thousands.
    assert!(all <= 8, "{all}");
}

#[test]
fn noise_that_a_codec_or_a_filter_spreads_over_pixels_gives_next_to_nothing() {
    let kinds = [
        // Weak noise is rounded to few coarse coefficients, strong noise stays as it is.
        ("colour-jpeg-60+noisy-half:strength=0.5", 0.02, 0.5),
        ("jpeg-90+noisy-half", 0.005, 0.5),
        ("colour-jpeg-90+noisy-half", 0.005, 0.15),
        ("varying-2+jpeg-30:period=90:phase=0.75", 0.02, 0.7),
        // The blocks that the border cuts have more noise than whole ones.
        ("colour-jpeg-30", 0.02, 0.3),
        ("colour-jpeg-30:phase=0.5", 0.02, 0.7),
        // A camera that smooths spreads a hot pixel over nine.
        ("hot-pixels+correlated", 0.02, 0.3),
    ];
    // Before, single bursts had hundreds.
    let all = count_in_noise(&kinds, (484, 364));
    assert!(all <= 20, "{all}");
}

#[test]
fn lines_of_any_period_are_taken_off_and_what_is_not_a_whole_line_stays() {
    let mut all = 0;
    for (kind, sigma, level) in [
        ("still-banding:strength=2:period=7:phase=0.25", 0.005, 0.15),
        ("still-banding:period=16", 0.02, 0.5),
        ("breathing-10+still-banding:strength=0.5:period=40", 0.005, 0.15),
        ("still-banding:strength=2:period=90", 0.02, 0.15),
        ("banding:strength=0.5:period=16", 0.01, 0.5),
        ("drifting-stripes-1.5+correlated", 0.02, 0.5),
    ] {
        for detection in of_noise((kind, sigma, level), (480, 360)) {
            all += detection.features.len();
            let lines = [WarningKind::ChangingLines, WarningKind::Stripes];
            assert!(detection.noise.warnings.iter().any(|warning| lines.contains(&warning.kind)));
        }
    }
    // Six a megapixel of 2.4 would be 14; before, single bursts had hundreds.
    assert!(all <= 6, "{all}");
    // Bars that end within the image, or lean, are a scene.
    let with = |bars: &dyn Fn(usize, usize) -> f32| {
        let frames = NoiseCase::White.burst((480, 360), 10, 0.02, 5, &quiet()).expect("a burst").frames;
        let with_bars = |frame: &std::sync::Arc<Plane>| Plane::from_fn(480, 360, |u, v| frame.at(u, v) + bars(u, v));
        let burst = Burst::from_planes("bars", frames.iter().map(with_bars).collect());
        let pattern = &found(&burst, NoiseModelKind::Local).noise.pattern;
        pattern.changing_columns.or(pattern.changing_rows)
    };
    let bar = |x: f32| 0.02 * (0.4 * x).sin();
    assert_eq!(with(&|u, v| if v < 150 { bar(u as f32) } else { 0.0 }), None);
    assert_eq!(with(&|u, v| bar(u as f32 + 0.05 * v as f32)), None);
    assert!(with(&|u, _| bar(u as f32)).is_some());
}

#[test]
fn a_fault_that_hides_another_is_no_excuse() {
    for kind in [
        // Hot pixels raise the means of their lines, and strong lines hide the hot pixels in them.
        ("growing-stripes+hot-pixels:strength=2:period=90:phase=0.25", 0.005, 0.15),
        ("drifting-stripes-1.5+flickering-pixels:strength=2:period=40:phase=0.75", 0.05, 0.5),
        // Lines with more noise have larger measured offsets, and vary more along themselves: they are no things in a row.
        ("drifting-stripes-0.3+noisy-half:strength=0.25:period=90", 0.005, 0.3),
        // Frames of different noise: their contrasts differ, and what a few of them show beside the border.
        ("smoothed+noisy-frame", 0.05, 0.3),
        ("gain-flicker+saturated:strength=0.25", 0.005, 0.7),
    ] {
        let all = count_in_noise(&[kind], (480, 360));
        assert!(all <= 2, "{kind:?}: {all}");
    }
}

#[test]
fn no_part_of_a_scene_is_taken_for_lines_and_a_weak_pattern_is_measured_in_the_mean_of_the_frames() {
    for example in Example::ALL {
        let noise = found(&example.burst(), NoiseModelKind::Local).noise;
        let pattern = &noise.pattern;
        println!("{example:?}: {:?} {:?} {:?}", pattern.changing_columns, pattern.changing_rows, noise.correlations);
        assert!(pattern.columns.is_none() && pattern.rows.is_none(), "{example:?}");
        assert_eq!((pattern.changing_columns, pattern.changing_rows), (None, None), "{example:?}");
    }
    let share = |case: NoiseCase| {
        let burst = case.burst((480, 360), 10, 0.02, 3, &quiet()).expect("a burst");
        found(&burst, NoiseModelKind::Local).noise.pattern_share
    };
    for (percent, expected) in [(20u8, 0.038), (40, 0.138)] {
        let found = share(NoiseCase::FixedPattern(percent));
        assert!((found / expected - 1.0).abs() < 0.35, "{percent}: {found}");
    }
    for noise in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::NoisyHalf, NoiseCase::Jpeg(60)] {
        assert_eq!(share(noise), 0.0, "{noise:?}");
    }
}

#[test]
fn a_filter_over_time_is_seen_where_the_noise_differs_by_place_and_a_scene_that_stays_is_none() {
    let correlation = |found: &Detection| found.noise.correlations.first().copied().unwrap_or(0.0);
    let mut all = 0;
    for (kind, sigma, level) in [
        ("smoothed+varying-6:strength=0.25", 0.02, 0.7),
        ("varying-6+smoothed:strength=0.25:period=90:phase=0.25", 0.05, 0.5),
        ("jpeg-60+smoothed:phase=0.75", 0.005, 0.3),
    ] {
        for detection in of_noise((kind, sigma, level), (480, 360)) {
            let correlation = correlation(&detection);
            assert!(correlation > 0.5, "{kind}: {correlation}");
            all += detection.features.len();
        }
    }
    // Before, each of the six bursts had thousands.
    assert!(all <= 30, "{all}");
    // A still scene under even noise: all its squares have something in common, but not the same share.
    let scene = SceneParams { width: 480, height: 360, max_slope: 0.0, snr: 20.0, ..SceneParams::default() };
    let (still, _) = synth_scene(&scene, &quiet()).expect("a scene");
    assert_eq!(correlation(&found(&still, NoiseModelKind::Local)), 0.0);
}

#[test]
fn on_bands_as_much_is_found_as_without_them_and_under_a_lamp_more_is_found_in_the_dark() {
    let chart = ChartParams { snr: 0.5, ..ChartParams::default() };
    let (burst, truth) = synth_chart(&chart, &quiet()).expect("a chart");
    let band = |v: usize| 0.01 * (std::f32::consts::TAU * v as f32 / 16.0).sin();
    let banded = |frame: &std::sync::Arc<Plane>| {
        let (width, height) = frame.size();
        Plane::from_fn(width, height, |u, v| frame.at(u, v) + band(v))
    };
    let with_bands = Burst::from_planes("banded", burst.frames.iter().map(banded).collect());
    let of = |burst: &Burst| {
        let features = found(burst, NoiseModelKind::Local).features;
        truth.features.iter().filter(|disc| features.iter().any(|feature| finds(feature, disc))).count()
    };
    let (without, with) = (of(&burst), of(&with_bands));
    println!("discs {without} without bands, {with} with");
    assert!(without > 60 && with + 3 >= without, "{without} {with}");
    let (mut white_found, mut local_found) = (0, 0);
    for seed in [1, 2] {
        let (burst, discs) = lit_chart(seed);
        let in_dark: Vec<&FeatureTruth> = discs.iter().filter(|d| d.u < 320.0).collect();
        let count = |kind| {
            let features = found(&burst, kind).features;
            in_dark.iter().filter(|disc| features.iter().any(|f| finds(f, disc))).count()
        };
        white_found += count(NoiseModelKind::White);
        local_found += count(NoiseModelKind::Local);
    }
    println!("in the dark: white {white_found}, local {local_found}");
    assert!(local_found > white_found, "{local_found} {white_found}");
}

#[test]
fn noise_is_warned_of_by_its_kind_alone_and_scenes_for_nothing_that_they_do_not_have() {
    use WarningKind::*;
    for (case, kinds) in [
        (NoiseCase::White, &[][..]),
        (NoiseCase::Doubled, &[DuplicateFrames]),
        (NoiseCase::Jpeg(30), &[LongTails, SharedByNeighbours, FlattenedByCodec]),
        (NoiseCase::Correlated, &[SharedByNeighbours]),
        (NoiseCase::BlackFrame, &[OutlierFrames]),
        (NoiseCase::NoisyFrame, &[OutlierFrames]),
        (NoiseCase::NoisyHalf, &[DiffersByPlace, LongTails]),
        (NoiseCase::ColumnStripes, &[Stripes]),
        (NoiseCase::HotPixels, &[HotPixels]),
        (NoiseCase::GainFlicker, &[GainFlicker]),
        (NoiseCase::ClippedBlack, &[CutOff, LongTails]),
        (NoiseCase::Saturated, &[CutOff, LongTails]),
        (NoiseCase::ConstantFrame, &[OutlierFrames]),
        (NoiseCase::DriftingStripes(3), &[ChangingLines]),
        (NoiseCase::Varying(2), &[DiffersByPlace, LongTails]),
        (NoiseCase::Varying(6), &[DiffersByPlace, LongTails]),
        (NoiseCase::Banding, &[ChangingLines]),
        (NoiseCase::StillBanding, &[Stripes]),
        (NoiseCase::Smoothed, &[SmoothedOverTime]),
        (NoiseCase::FixedPattern(30), &[FixedPattern]),
        (NoiseCase::FlickeringPixels, &[HotPixels]),
        (NoiseCase::NoisyColumns, &[ChangingLines]),
        (NoiseCase::Fading(10), &[GainFlicker]),
        (NoiseCase::CosmicStreaks, &[Struck]),
        (NoiseCase::ColourJpeg(30), &[FlattenedByCodec, SharedByNeighbours, LongTails]),
        (NoiseCase::Jpeg(90), &[]),
        (NoiseCase::ColourJpeg(90), &[]),
        (NoiseCase::Constant, &[]),
        (NoiseCase::Negative, &[]),
    ] {
        for (size, frames, seed) in [((480, 360), 10, 3), ((500, 300), 8, 5), ((240, 180), 5, 6)] {
            let mut burst = case.burst(size, frames, 0.02, seed, &quiet()).expect("a burst");
            // Rows are told as columns are.
            if case == NoiseCase::ColumnStripes && frames == 8 {
                let turned = |frame: &Plane| Plane::from_fn(size.1, size.0, |u, v| frame.at(v, u));
                burst = Burst::from_planes("rows", burst.frames.iter().map(|frame| turned(frame)).collect());
            }
            let noise = found(&burst, NoiseModelKind::Local).noise;
            let warnings = &noise.warnings;
            if case == NoiseCase::ColumnStripes {
                let stripes = if frames == 8 { &noise.pattern.rows } else { &noise.pattern.columns };
                assert!(stripes.as_ref().is_some_and(|stripes| (stripes.deviation / 0.02 - 1.0).abs() < 0.15));
            }
            let said: Vec<WarningKind> = warnings.iter().map(|warning| warning.kind).collect();
            assert!(said.iter().all(|kind| kinds.contains(kind)), "{case:?}, {frames} frames: {warnings:?}");
            assert!(frames < 8 || kinds.first().is_none_or(|first| said.contains(first)), "{case:?}: {warnings:?}");
        }
    }
    let of_scene = |layers: usize| {
        let scene = SceneParams { width: 320, height: 240, layers, ..SceneParams::default() };
        synth_scene(&scene, &quiet()).expect("a scene").0
    };
    let lines = [ChangingLines, Stripes, DiffersByPlace];
    for (burst, kinds) in
        [(of_scene(1), &[Stripes, HotPixels, DiffersByPlace][..]), (of_scene(2), &lines), (demo_burst(), &lines)]
    {
        let warnings = &found(&burst, NoiseModelKind::Local).noise.warnings;
        assert!(warnings.iter().all(|warning| !kinds.contains(&warning.kind)), "{}: {warnings:?}", burst.name);
    }
}

#[test]
fn a_change_that_all_places_share_is_an_exposure() {
    for (case, range) in [(NoiseCase::Fading(10), 0.1), (NoiseCase::Breathing(3), 0.03)] {
        let burst = case.burst((320, 240), 10, 0.02, 5, &quiet()).expect("a burst");
        let gains = found(&burst, NoiseModelKind::Local).noise.frames.clone().into_iter().map(|frame| frame.gain);
        let (min, max) = gains.fold((f32::INFINITY, 0.0f32), |(a, b), gain| (a.min(gain), b.max(gain)));
        assert!(((max / min).ln() / range - 1.0).abs() < 0.15, "{case:?}: {min} {max}");
    }
    // A lit and a dark half, and a border between them that moves: places change, but each in its own way.
    let mut noise = Stream::new(5, 0);
    let mut halves = |t: usize| {
        Plane::from_fn(320, 240, |u, _| if u < 40 + 40 * t { 0.6 } else { 0.3 } + 0.002 * noise.normal() as f32)
    };
    let halves = Burst::from_planes("halves", (0..6).map(&mut halves).collect());
    let warnings = &found(&halves, NoiseModelKind::Local).noise.warnings;
    assert!(warnings.iter().all(|warning| !warning.text.contains("over the burst")), "{warnings:?}");
}

#[test]
fn a_blurred_frame_is_left_out_where_its_texture_can_be_seen() {
    let scene = SceneParams { width: 320, height: 240, frames: 8, snr: f64::INFINITY, ..SceneParams::default() };
    let (mut burst, _) = synth_scene(&scene, &quiet()).expect("a scene");
    burst.frames[3] = Arc::new(blur::gaussian_blur(&burst.frames[3], &blur::GaussianKernel::new(2.0)));
    for (sigma, is_seen) in [(0.01, true), (0.5, false)] {
        let mut noise = Stream::new(3, 0);
        let mut noisy = |f: &Plane| Plane::from_fn(320, 240, |u, v| f.at(u, v) + sigma * noise.normal() as f32);
        let noisy = Burst::from_planes("noisy", burst.frames.iter().map(|frame| noisy(frame)).collect());
        let frames = &found(&noisy, NoiseModelKind::Local).noise.frames;
        let left_out: Vec<usize> = (0..8).filter(|&t| frames[t].left_out.is_some()).collect();
        assert_eq!(left_out, if is_seen { vec![3] } else { vec![] }, "{frames:?}");
        assert!(!is_seen || matches!(frames[3].left_out, Some(LeftOut::Blurred(share)) if share < 0.4));
    }
}

#[test]
fn what_is_in_one_frame_only_is_masked_and_what_moves_is_neither_a_strike_nor_noise() {
    let struck = |burst: &Burst| found(burst, NoiseModelKind::Local).noise.pattern.struck;
    let streaks = NoiseCase::CosmicStreaks.burst((320, 240), 10, 0.02, 5, &quiet()).expect("a burst");
    assert!(
        struck(&streaks) > 300
            && struck(&NoiseCase::White.burst((320, 240), 10, 0.02, 5, &quiet()).expect("a burst")) == 0
    );
    let scene = SceneParams { width: 320, height: 240, layers: 1, max_slope: 3.0, ..SceneParams::default() };
    // Where layers cover each other a few pixels do appear for a moment.
    assert!(struck(&synth_scene(&scene, &quiet()).expect("a scene").0) <= 5);
    // Fine texture that moves by 3 px/frame: noise at coarse levels where it is not followed.
    let mut drawn = Stream::new(6, 0);
    let grain = Plane::from_fn(460, 280, |_, _| 0.15 * drawn.normal() as f32);
    let texture = blur::gaussian_blur(&grain, &blur::GaussianKernel::new(1.5));
    let frame = |t: usize| {
        let mut noise = Stream::new(7, t as u64);
        Plane::from_fn(420, 280, |u, v| 0.5 + texture.at(u + 30 - 3 * t, v) + 0.02 * noise.normal() as f32)
    };
    let burst = Burst::from_planes("texture", (0..8).map(frame).collect());
    let largest = |slopes: SlopeGrid| {
        let params = DetectorParams { slopes, ..params(NoiseModelKind::Local) };
        let noise = &detect(&burst, &params, &quiet()).expect("detected").noise;
        noise.levels.iter().flatten().map(|level| level.over_white).fold(0.0, f32::max)
    };
    let (moved, still) = (largest(SlopeGrid::line(-3.0..=3.0, 13)), largest(SlopeGrid::single(Slope::default())));
    println!("texture {moved} {still}");
    assert!(moved < 1.2 && still > 2.0, "{moved} {still}");
}

/// Frames of 8 bits of `count` stars that drift to the right, over noise of one step around `level` steps.
fn star_field(count: usize, level: f64) -> Burst {
    let mut drawn = Stream::new(3, 0);
    let stars: Vec<[f64; 3]> =
        (0..count).map(|_| [drawn.within(20.0, 460.0), drawn.within(20.0, 340.0), drawn.within(30.0, 200.0)]).collect();
    let frame = |t: u64| {
        let mut noise = Stream::new(4, t);
        Plane::from_fn(480, 360, |u, v| {
            let light = |[x, y, peak]: &[f64; 3]| {
                let (du, dv) = (u as f64 - x - 1.3 * t as f64, v as f64 - y);
                peak * (-(du * du + dv * dv) / (2.0 * 1.4 * 1.4)).exp()
            };
            let steps = level + stars.iter().map(light).sum::<f64>() + noise.normal();
            (steps.round().clamp(0.0, 255.0) / 255.0) as f32
        })
    };
    let mut burst = Burst::from_planes("stars", (0..8).map(frame).collect());
    burst.quantisation_step = 1.0 / 255.0;
    burst
}

#[test]
fn stars_on_a_quiet_ground_are_no_fault_of_the_camera() {
    for count in [5, 10, 20] {
        for level in [-4.0, -2.0, 0.0, 8.0] {
            let warnings = &found(&star_field(count, level), NoiseModelKind::Local).noise.warnings;
            // Where black is cut off, what is left of the noise is rare.
            let may = if level > 0.0 { &[][..] } else { &[WarningKind::CutOff, WarningKind::LongTails] };
            assert!(warnings.iter().all(|warning| may.contains(&warning.kind)), "{count} at {level}: {warnings:?}");
        }
    }
}

#[test]
fn the_noise_is_measured_unless_it_is_said_otherwise_and_what_is_cleaned_is_said() {
    assert_eq!(burstscope_core::detector::SearchParams::default().noise_model, NoiseModelKind::Local);
    let burst = NoiseCase::White.burst((160, 120), 5, 0.02, 5, &quiet()).expect("a burst");
    let detection = detect(&burst, &DetectorParams::default(), &quiet()).expect("detected");
    assert!(detection.noise.is_local && detection.noise.warnings.is_empty(), "{:?}", detection.noise.warnings);
    assert!((detection.noise.frame_noise / 0.02 - 1.0).abs() < 0.02, "{}", detection.noise.frame_noise);
    // A file whose least value is 0 has negative values at the end of its range, where noise is cut off.
    let mut pedestal = NoiseCase::Negative.burst((480, 360), 10, 0.02, 3, &quiet()).expect("a burst");
    let lifted = |frame: &Plane| Plane::from_fn(480, 360, |u, v| frame.at(u, v).max(-0.01));
    pedestal.frames.iter_mut().for_each(|frame| *frame = Arc::new(lifted(frame)));
    let noise = found(&pedestal, NoiseModelKind::Local).noise;
    let cut_off = noise.warnings.iter().find(|warning| warning.kind == WarningKind::CutOff).expect("cut off");
    assert!((cut_off.number - 0.31).abs() < 0.03, "{cut_off:?}");
    let flickering = NoiseCase::GainFlicker.burst((320, 240), 8, 0.02, 3, &quiet()).expect("a burst");
    for (flicker, words) in [(Flicker::Auto, "were brought"), (Flicker::Off, "were left")] {
        let params = DetectorParams { flicker, ..params(NoiseModelKind::Local) };
        let noise = detect(&flickering, &params, &quiet()).expect("detected").noise;
        assert!(noise.warnings[0].text.contains(words), "{:?}", noise.warnings);
    }
    let burst = NoiseCase::HotPixels.burst((320, 240), 8, 0.02, 5, &quiet()).expect("a burst");
    let detection = found(&burst, NoiseModelKind::Local);
    let kinds: Vec<WarningKind> = detection.noise.warnings.iter().map(|w| w.kind).collect();
    assert_eq!(kinds, [WarningKind::HotPixels]);
    assert!(found(&burst, NoiseModelKind::White).noise.warnings.is_empty());
    let merge = DetectorParams { method: Method::Merge, ..params(NoiseModelKind::Local) };
    let merged = detect(&burst, &merge, &quiet()).expect("detected");
    let kinds: Vec<WarningKind> = merged.noise.warnings.iter().map(|w| w.kind).collect();
    assert_eq!(kinds, [WarningKind::KeptByMerge]);
}

/// A chart whose right half is lit by a lamp, so that its shot noise is several times that of the dark left.
fn lit_chart(seed: u64) -> (Burst, Vec<FeatureTruth>) {
    let chart = ChartParams { snr: f64::INFINITY, seed, ..ChartParams::default() };
    let (clean, truth) = synth_chart(&chart, &quiet()).expect("a chart");
    let (width, height) = clean.size();
    let camera = Camera { full_scale_electrons: 150.0, read_noise_electrons: 3.0, black_level: 0.02, bits: Some(12) };
    let lift = truth.black_level as f32;
    let frames = clean.frames.iter().zip(0..).map(|(frame, t)| {
        let lit = Plane::from_fn(width, height, |u, v| {
            let light = 1.0 + 30.0 / (1.0 + (6.0 - 12.0 * u as f32 / width as f32).exp());
            (0.25 * light * (frame.at(u, v) - lift)).min(0.9)
        });
        camera.capture(&lit, &mut Stream::new(seed + 1000, t), &quiet()).expect("not cancelled")
    });
    let mut burst = Burst::from_planes("lit", frames.collect());
    burst.quantisation_step = camera.quantisation_step() as f32;
    (burst, truth.features)
}

fn finds(feature: &Feature, disc: &FeatureTruth) -> bool {
    let distance = (f64::from(feature.u) - disc.u).hypot(f64::from(feature.v) - disc.v);
    distance < 0.5 * disc.radius + 1.5 && (0.5..2.0).contains(&(f64::from(feature.sigma) / disc.sigma))
}
