//! Automatic slopes on real bursts.

use crate::shared::shared;
use burstscope_core::burst::{Burst, OpenOptions};
use burstscope_core::detect::{Searched, search};
use burstscope_core::detector::{
    DetectorParams, ParamChange, SearchParams, Slope, SlopeAxis, SlopeFinding, SlopeVerdict, find_slopes,
};
use burstscope_core::inspect::spectrum::{Subject, judgement};
use burstscope_core::{Monitor, SlopeGrid};
use std::path::{Path, PathBuf};

fn open(files: &[PathBuf]) -> Burst {
    Burst::open_with(files, &OpenOptions::default(), &Monitor::default()).expect("a burst")
}

fn find(burst: &Burst) -> SlopeFinding {
    find_slopes(burst, &DetectorParams::default(), None, &Monitor::default()).expect("not cancelled")
}

/// Half the right step of the search for `burst` at the default levels, pixels per frame.
fn half_step(burst: &Burst) -> f32 {
    1.6 * 2f32.powf(0.25) / (burst.len() - 1) as f32
}

/// The files of a folder, in the order of their names.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "png"));
    files.sort();
    files
}

/// Whether `axis` ends one to two steps beyond `range`, with a tolerance of `around`, pixels per frame.
fn ends_beyond(axis: SlopeAxis, range: [f32; 2], around: f32) -> bool {
    let beyond = [range[0] - axis.min, axis.max - range[1]];
    beyond.iter().all(|x| (axis.step() - around..=2.0 * axis.step() + around).contains(x))
}

/// Whether a line fits slopes in `range` so.
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
    let natural = find(&open(&files(&folder)));
    assert_eq!(natural.verdict, SlopeVerdict::NotStraight);
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
fn a_row_of_rendered_views_is_a_line_of_many_depths() {
    let folder = shared("data/light-field-shop");
    let views: Vec<PathBuf> = (0..9).map(|k| folder.join(format!("view_{k:02}.jpg"))).collect();
    let finding = find(&open(&views));
    assert_eq!((finding.verdict, finding.grid.direction_deg), (SlopeVerdict::Found, 0.0));
    let range = finding.grid.u;
    assert!(!finding.grid.is_plane() && range.min < 0.9 && range.max > 4.9 && range.max < 6.5, "{range:?}");
    assert_eq!(finding.grid.slope(0).v, Slope::default().v);
}

#[needs::shared("data/light-field-shop")]
#[test]
fn a_floor_that_is_sharpest_beyond_the_range_is_no_fit_and_one_change_widens_it() {
    let folder = shared("data/light-field-shop");
    let burst = open(&(0..27).map(|k| folder.join(format!("view_{k:02}.jpg"))).collect::<Vec<_>>());
    let monitor = Monitor::default();
    let params = SearchParams { detector: DetectorParams { octaves: 2, ..Default::default() }, ..Default::default() };
    let judged = |params: &SearchParams| {
        let Searched { detection, params, finding, .. } = search(&burst, params, &monitor).expect("valid");
        let finding = finding.map_or_else(|| find_slopes(&burst, &params, None, &monitor), Ok).expect("not cancelled");
        (judgement(&detection, &params, Some(&finding), &burst).expect("it has slopes"), params)
    };
    let (found, params) = judged(&params);
    assert!(params.slopes.u.max < 5.3, "the middle of the picture alone decides: {:?}", params.slopes);
    let advice = found.advice.expect("the floor moves by up to 6.5");
    assert!(advice.subject == Subject::Range && advice.sentence.contains("beyond u 4.86 px/frame"), "{advice:?}");
    let wider = ParamChange::all_applied(&advice.changes, &params).expect("valid");
    assert!(wider.slopes.u.max > 6.5 && wider.slopes.u.min == params.slopes.u.min, "{:?}", wider.slopes);
    let (mended, _) = judged(&wider.into());
    assert_eq!(mended.advice.filter(|advice| advice.subject == Subject::Range), None);
}
