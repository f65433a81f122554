//! Automatic slopes on real bursts, and on scenes and noise that were made.

use super::found_slopes::{find, holds, moved};
use crate::prelude::*;
use burstscope_core::detect::Searched;
use burstscope_core::detector::slopes::MotionWarningKind;
use burstscope_core::inspect::slopes::{AdviceSubject, judgement};

fn open(files: &[PathBuf]) -> Burst {
    Burst::open_with(files, &OpenOptions::default(), &quiet()).expect("a burst")
}

/// Half the right step of the search for `burst` at the default levels, pixels per frame.
fn half_step(burst: &Burst) -> f32 {
    1.6 * 2f32.powf(0.25) / (burst.len() - 1) as f32
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "png"));
    files.sort();
    files
}

/// Whether `axis` ends one to two steps beyond `range`, with a tolerance of `around`, pixels per frame.
fn ends_beyond(axis: SlopeAxis, range: [f32; 2], around: f32) -> bool {
    let beyond = [range[0] - axis.min, axis.max - range[1]];
    beyond.iter().all(|x| (axis.step() - around..=2.0 * axis.step() + around).contains(x))
}

fn fits(grid: &SlopeGrid, range: [f32; 2], around: f32) -> bool {
    !grid.is_plane() && ends_beyond(grid.u, range, around)
}

#[needs::shared("data/buff-demo-1d")]
#[test]
fn graffiti_moves_uniformly_in_one_order_and_not_in_the_other() {
    let folder = shared("data/buff-demo-1d");
    let burst = open(&[5, 1, 2, 4, 3].map(|k| folder.join(format!("{k}.png"))));
    let finding = find(&burst);
    assert_eq!(finding.verdict, SlopeVerdict::Found);
    assert_eq!(finding.grid.direction_deg, 0.0);
    assert!(fits(&finding.grid, [1.0, 1.0], half_step(&burst)), "{:?}", finding.grid);
    assert_eq!(find(&open(&files(&folder))).verdict, SlopeVerdict::NotStraight);
}

#[needs::shared("data/buff-demo-2d")]
#[test]
fn eight_discs_need_a_plane() {
    let folder = shared("data/buff-demo-2d");
    let burst = open(&files(&folder));
    let grid = find(&burst).grid;
    assert!(grid.is_plane() && grid.direction_deg == 0.0, "{grid:?}");
    // The discs' slopes are -1 … 2 on both axes.
    for axis in [grid.u, grid.v] {
        assert!(ends_beyond(axis, [-1.0, 2.0], half_step(&burst)), "{grid:?}");
    }
}

#[needs::shared("data/slider-far")]
#[test]
fn a_slider_moves_along_rows_and_is_a_film_as_a_whole() {
    let folder = shared("data/slider-far");
    let frames = files(&folder);
    for ten in frames.chunks_exact(10) {
        let burst = open(ten);
        let finding = find(&burst);
        assert_eq!((finding.verdict, finding.grid.direction_deg), (SlopeVerdict::Found, 0.0));
        // 90 % of the picture moves by -4.25 to -3.95; its corners, which lens distortion shifts, by -4.44 to -3.65.
        assert!(fits(&finding.grid, [-4.25, -3.95], half_step(&burst)), "{:?}", finding.grid);
        assert!(finding.grid.u.min <= -4.44 && finding.grid.u.max >= -3.65, "{:?}", finding.grid);
        assert!(finding.confidence > 0.9);
    }
    let film = find(&open(&frames));
    assert_eq!(film.verdict, SlopeVerdict::Film);
    assert!((film.moved_px - 245.0).abs() < 10.0, "{}", film.moved_px);
}

#[needs::shared("data/visp-cube")]
#[test]
fn a_robots_camera_turns_slowly_and_its_way_points_to_148_degrees() {
    let folder = shared("data/visp-cube");
    let frames = files(&folder);
    let eight: Vec<SlopeFinding> = frames.chunks_exact(8).map(|frames| find(&open(frames))).collect();
    assert!(eight.iter().all(|f| f.verdict == SlopeVerdict::Found && f.confidence > 0.9));
    let middle = eight[2].direction_deg.expect("it moves");
    assert!((middle - 148.0).abs() < 5.0, "{middle}");
    let whole = find(&open(&frames));
    assert_eq!(whole.verdict, SlopeVerdict::NotStraight);
    assert!((whole.direction_deg.expect("it moves") - 148.0).abs() < 5.0);
}

#[needs::shared("data/light-field-shop")]
#[test]
fn a_row_of_rendered_views_is_a_line_of_many_depths_and_a_narrow_range_is_widened() {
    let folder = shared("data/light-field-shop");
    let views: Vec<PathBuf> = (0..9).map(|k| folder.join(format!("view_{k:02}.jpg"))).collect();
    let finding = find(&open(&views));
    assert_eq!((finding.verdict, finding.grid.direction_deg), (SlopeVerdict::Found, 0.0));
    let range = finding.grid.u;
    assert!(!finding.grid.is_plane() && range.min < 0.9 && range.max > 4.9 && range.max < 6.5, "{range:?}");
    assert_eq!(finding.grid.slope(0).v, Slope::default().v);
    let folder = shared("data/light-field-shop");
    let burst = open(&(0..27).map(|k| folder.join(format!("view_{k:02}.jpg"))).collect::<Vec<_>>());
    let monitor = Monitor::default();
    let params = SearchParams { octaves: 2, ..Default::default() };
    assert!(find(&burst).grid.u.max < 5.3, "the middle of the picture alone decides");
    let Searched { detection, params, finding, .. } = search(&burst, &params, &monitor).expect("valid");
    assert!(params.slopes.u.max > 6.5 && params.slopes.u.min < 0.9, "{:?}", params.slopes);
    assert_eq!(finding.as_ref().map(|finding| finding.grid), Some(params.slopes));
    let judged = judgement(&detection, &params, finding.as_ref(), &burst, &monitor).expect("not cancelled");
    assert_eq!(judged.expect("it has slopes").advice.filter(|advice| advice.subject == AdviceSubject::Range), None);
}

#[needs::shared("data/light-field-shop")]
#[test]
fn a_coarse_range_that_is_far_too_wide_gets_that_of_the_motion() {
    let folder = shared("data/light-field-shop");
    let burst = open(&(0..27).map(|k| folder.join(format!("view_{k:02}.jpg"))).collect::<Vec<_>>());
    let monitor = Monitor::default();
    let slopes = SlopeGrid::line(-40.0..=40.0, 5);
    let given = SearchParams::from(DetectorParams { octaves: 2, slopes, ..Default::default() });
    let Searched { detection, params, .. } = search(&burst, &given, &monitor).expect("valid");
    let judged = judgement(&detection, &params, Some(&find(&burst)), &burst, &monitor).expect("not cancelled");
    let advice = judged.expect("it has slopes").advice.expect("a step of 20 px/frame is too coarse");
    let after = ParamChange::all_applied(&advice.changes, &params).expect("possible");
    let SlopeAxis { min, max, .. } = after.slopes.u;
    // The floor's own motion included, which only a search over the motion's range finds.
    assert!(advice.subject == AdviceSubject::Step && min > 0.0 && (6.5..8.0).contains(&max), "{advice:?}");
    let Searched { detection, params, .. } = search(&burst, &after.into(), &monitor).expect("valid");
    let judged = judgement(&detection, &params, Some(&find(&burst)), &burst, &monitor).expect("not cancelled");
    assert_eq!(judged.expect("it has slopes").advice, None);
}

fn noise(seed: u64, size: (usize, usize)) -> Plane {
    let mut stream = Stream::new(seed, 9);
    Plane::from_fn(size.0, size.1, |_, _| 0.5 + 0.05 * stream.normal() as f32)
}

#[test]
fn noise_that_frames_have_in_common_does_not_move() {
    let (width, height) = (320, 240);
    let check = |name: &str, frames: Vec<Plane>| {
        let finding = find(&Burst::from_planes(name, frames));
        let shows_motion = finding.verdict != SlopeVerdict::NothingSeen && finding.grid.len() > 1;
        assert!(!shows_motion, "{name}: {}", finding.summary());
    };
    let stripes = [NoiseCase::ColumnStripes, NoiseCase::GrowingStripes, NoiseCase::DriftingStripes(3)];
    for seed in 0..3 {
        for case in [NoiseCase::HotPixels, NoiseCase::FlickeringPixels] {
            let burst = case.burst((width, height), 8, 0.02, seed + 1, &quiet()).expect("not cancelled");
            check(&case.name(), burst.frames.iter().map(|f| (**f).clone()).collect());
        }
        // Of these nothing stays as a scene does, and what a codec leaves of noise is alike in two frames by chance.
        let codec = [NoiseCase::Jpeg(30), NoiseCase::ColourJpeg(30)];
        for case in [&stripes[..], &codec, &[NoiseCase::Smoothed, NoiseCase::Doubled]].concat() {
            for frames in [5, 10, 20].into_iter().filter(|frames| *frames > 5 || case != NoiseCase::Smoothed) {
                let burst = case.burst((width, height), frames, 0.01, seed + 1, &quiet()).expect("not cancelled");
                let finding = find(&burst);
                let is_blind = finding.verdict == SlopeVerdict::NothingSeen;
                assert!(is_blind, "{} {frames} {seed}: {}", case.name(), finding.summary());
            }
        }
        let some: Vec<Plane> = (0..9).map(|t| noise(10 * seed + t, (width, height))).collect();
        // Fields: each frame has every other row of the frame before, or rows that were interpolated.
        let fields = |t: usize| Plane::from_fn(width, height, |u, v| some[t + (v + t + 1) % 2].at(u, v));
        check("interlaced", (0..8).map(fields).collect());
        let interpolated = |t: usize| {
            let between =
                |u: usize, v: usize| some[t].at(u, v.saturating_sub(1)) + some[t].at(u, (v + 1).min(height - 1));
            Plane::from_fn(width, height, |u, v| if v % 2 == t % 2 { some[t].at(u, v) } else { 0.5 * between(u, v) })
        };
        check("interpolated", (0..8).map(interpolated).collect());
        // Copies: each frame twice, some in turn, and one that is turned by half a turn each time.
        check("doubled", (0..8).map(|t| some[t / 2].clone()).collect());
        check("in turn", (0..8).map(|t| some[t % 4].clone()).collect());
        let turned = Plane::from_fn(width, height, |u, v| some[0].at(width - 1 - u, height - 1 - v));
        check("turned", (0..8).map(|t| if t % 2 == 0 { some[0].clone() } else { turned.clone() }).collect());
    }
}

/// In the dark the stripes of a sensor, which stay, are stronger than the scene, and have no motion along themselves.
#[test]
fn stripes_hide_no_motion_of_the_scene_behind_them() {
    for (seed, u, v) in [(1, 1.2, 0.0), (2, 0.6, -0.8)] {
        let scene = moved((320, 240), 0.02, 10, |t| (u * t as f64, v * t as f64));
        for (strength, along) in [(0.01, 0), (0.03, 0), (0.1, 0), (0.03, 1), (0.1, 1)] {
            let mut stream = Stream::new(seed, 3);
            let stripes: Vec<f32> = (0..320).map(|_| strength * stream.normal() as f32).collect();
            let striped = |frame: &Plane| {
                // They grow along themselves, as those of a sensor that is read line by line.
                Plane::from_fn(320, 240, |u, v| {
                    frame.at(u, v) + stripes[[u, v][along]] * (1.0 + [v, u][along] as f32 / 640.0)
                })
            };
            let finding =
                find(&Burst::from_planes("striped", scene.frames.iter().map(|frame| striped(frame)).collect()));
            let holds = holds(&finding.grid, Slope::new(u as f32, v as f32), 0.0) && finding.grid.len() < 10;
            assert!(holds && finding.verdict == SlopeVerdict::Found, "{strength} {along}: {}", finding.summary());
        }
    }
}

/// Frames of a scene in the dark at `quarters` of frame intervals; its layers move along a line or in the plane.
fn taken(quarters: &[usize], seed: u64) -> Burst {
    let frames = quarters.iter().max().map_or(0, |last| last + 1);
    let motion = if seed.is_multiple_of(2) { Motion::OneD } else { Motion::TwoD };
    let max_slope = SceneParams::default().max_slope / 4.0;
    let params = SceneParams {
        width: 480,
        height: 360,
        frames,
        snr: std::env::var("SNR").ok().and_then(|x| x.parse().ok()).unwrap_or(0.5),
        seed,
        motion,
        max_slope,
        ..Default::default()
    };
    let (burst, _) = synth_scene(&params, &quiet()).expect("a scene");
    Burst::from_planes("taken", quarters.iter().map(|t| (*burst.frames[*t]).clone()).collect())
}

/// Events that may happen to ten frames, and the quarters of frame intervals at which they were taken then.
fn happened(seed: u64) -> [(Option<MotionWarningKind>, Vec<usize>, Vec<usize>); 6] {
    use MotionWarningKind::*;
    const FRAMES: usize = 10;
    let mut stream = Stream::new(seed, 77);
    let mut any = |range: std::ops::Range<usize>| range.start + stream.below(range.len());
    let even = |frames: usize| (0..frames).map(|t| 4 * t).collect::<Vec<usize>>();
    let a = any(0..FRAMES);
    let b = (a + any(1..FRAMES)) % FRAMES;
    let mut exchanged = even(FRAMES);
    exchanged.swap(a, b);
    let (from, by) = (any(0..FRAMES - 3), any(2..4));
    let mut moved = even(FRAMES);
    let frame = moved.remove(from);
    moved.insert(from + by, frame);
    let (after, count) = (any(1..FRAMES - 2), any(1..4));
    let mut missing = even(FRAMES + count);
    missing.drain(after + 1..after + 1 + count);
    let (frame, is_early, quarters) = (any(1..FRAMES - 1), any(0..2) == 1, any(2..4));
    let mut late = even(FRAMES);
    late[frame] = if is_early { late[frame] - quarters } else { late[frame] + quarters };
    let speeds_up = (0..FRAMES).map(|t| 2 * t + 2 * t * t / (FRAMES - 1)).collect();
    [
        (None, vec![], even(FRAMES)),
        (None, vec![], speeds_up),
        (Some(OutOfOrder), vec![a.min(b), a.max(b)], exchanged),
        (Some(OutOfOrder), (from..=from + by).collect(), moved),
        (Some(MissingFrames), vec![after], missing),
        (Some(Late), vec![frame], late),
    ]
}

#[test]
fn what_happened_to_frames_in_the_dark_is_told_and_nothing_of_good_ones() {
    // More: `HAPPENED_BURSTS=100 cargo test -p burstscope-core --test detection what_happened -- --nocapture`.
    let bursts = std::env::var("HAPPENED_BURSTS").ok().map(|count| count.parse::<u64>().expect("a number"));
    let mut counts = [[0; 3]; 6];
    for seed in 0..bursts.unwrap_or(2) {
        for (case, (kind, frames, quarters)) in happened(seed).into_iter().enumerate() {
            let finding = find(&taken(&quarters, seed));
            let told = finding
                .warnings
                .iter()
                .find(|warning| !matches!(warning.kind, MotionWarningKind::Turns | MotionWarningKind::Grows));
            let is_right = told.map(|told| (told.kind, &told.frames)) == kind.map(|kind| (kind, &frames));
            // In order: right, nothing told, wrong.
            counts[case][if is_right { 0 } else { 1 + usize::from(told.is_some()) }] += 1;
            let is_uniform = finding.uniform.is_some();
            assert!(is_uniform == told.is_some() && (!is_uniform || finding.verdict == SlopeVerdict::NotStraight));
            if bursts.is_some() {
                println!("{seed} {kind:?} {frames:?}: {:?}", told.map(|told| &told.text));
            }
        }
    }
    println!("right, silent, wrong: {counts:?}");
    let [right, silent, wrong] = [0, 1, 2].map(|at| counts.iter().map(|count| count[at]).sum::<usize>());
    assert!(counts[0][2] == 0 && 20 * wrong <= right && 10 * silent <= right, "{counts:?}");
}
