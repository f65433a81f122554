//! A model with its engine for tests, and guarantees of it: stale features are marked, answers for other bursts are
//! dropped, a feature found again stays selected.

use crate::app::apply::{asking, change, detection, opening, pair, panes, params};
use crate::app::document::{Document, Ranges, Side};
use crate::app::pane::{PaneId, Preset};
use crate::app::results::{Effect, Model, Read};
use crate::burst::Burst;
use crate::detector::{Detection, DetectorParams, Feature, SearchParams, Slope, SlopeGrid, StageTimes, Tally};
use crate::engine::{DEFAULT_CACHE_BYTES, Engine};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::requests::{BurstSource, Detected, OpenBurst, PictureAnswer, PictureKind, PictureRequest, Request, Work};
use crate::synth::ChartParams;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub(crate) struct Bench {
    pub model: Model,
    pub engine: Engine,
}

impl Bench {
    pub fn new() -> Self {
        let slopes = SlopeGrid::line(-1.0..=1.0, 3).into();
        let params = SearchParams { slopes, octaves: 2, ..Default::default() };
        let document = Document { params, auto_detect: true, ..Document::default() };
        Self { model: Model::from(document), engine: Engine::new(Arc::new(|| {}), DEFAULT_CACHE_BYTES) }
    }

    pub fn read(&self) -> Read<'_> {
        Read::of(&self.model)
    }

    pub fn run_until(&mut self, done: impl Fn(Read<'_>, &[Effect]) -> bool) -> Vec<Effect> {
        let (end, mut effects) = (Instant::now() + Duration::from_secs(60), Vec::new());
        loop {
            effects.extend(asking::take_answers(&mut self.model, &self.engine));
            params::check_params(&mut self.model);
            asking::ask(&mut self.model, &self.engine, false);
            if done(Read::of(&self.model), &effects) {
                return effects;
            }
            assert!(Instant::now() < end, "it does not come to rest");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    pub fn settle(&mut self) {
        self.run_until(|model, _| model.is_settled());
    }

    /// A bench with a chart as A and another one, of another size, as B, both searched; *Two bursts* is open.
    pub fn with_two_charts() -> Self {
        let chart = |width, seed| {
            let discs = ChartParams { width, height: 72, discs: 5, radius: 3.0..=5.0, ..ChartParams::default() };
            let chart = ChartParams { frames: 5, max_slope: 1.0, snr: 20.0, seed, ..discs };
            let source = BurstSource::Chart(Box::new(chart));
            source.open(&Default::default(), &Monitor::default()).expect("valid")
        };
        let mut bench = Self::new();
        opening::take_burst(&mut bench.model, chart(120, 1));
        pair::take_second_burst(&mut bench.model, chart(96, 2));
        bench.model.document.open_workspace(crate::teach::Workspace::Pair);
        bench.settle();
        bench
    }
}

pub(crate) fn open(size: (usize, usize), frames: usize) -> OpenBurst {
    let frame = |t: usize| Plane::from_fn(size.0, size.1, |u, v| ((u + 3 * v + t) % 7) as f32 / 10.0);
    OpenBurst::new(Burst::from_planes("test", (0..frames).map(frame).collect()), BurstSource::Demo)
}

pub(crate) fn feature(u: f32, v: f32, slope_index: usize, grid: &SlopeGrid) -> Feature {
    let here = Feature { u, v, slope: grid.slope(slope_index), slope_index, ..Feature::default() };
    Feature { sigma: 3.0, orientation: 0.5, response: -0.05, snr: 12.0, level: 1, ..here }
}

pub(crate) fn detected(burst: &OpenBurst, asked: &SearchParams, features: Vec<Feature>) -> Detected {
    let params = asked.at(asked.slopes.given().unwrap_or_default());
    let descriptors = vec![[0; 128]; features.len()];
    let detection = Detection {
        features,
        descriptors,
        tally: Tally::default(),
        frame_noise: 0.01,
        noise: std::sync::Arc::default(),
        field: None,
        noise_gate_factor: 4.5,
        slopes: params.slopes,
        frames_used: 0..burst.burst.len(),
        positions: burst.burst.positions.clone(),
        octaves: 0..1,
        times: StageTimes::default(),
    };
    let (asked, searched) = (asked.clone(), params.clone());
    let (search_secs, detection) = (0.1, Arc::new(detection));
    Detected { burst: burst.id, asked, params, searched, search_secs, finding: None, detection, judgement: None }
}

fn find(model: &mut Model, places: &[(f32, f32, usize)]) {
    let (burst, grid) = (model.results.slots.a.burst.clone().expect("open"), Read::of(model).grid_of(Side::A));
    let features = places.iter().map(|&(u, v, slope_index)| feature(u, v, slope_index, &grid)).collect();
    let detected = detected(&burst, &model.document.params, features);
    detection::take_detection(model, Side::A, detected, Duration::from_millis(10));
}

fn with_features() -> Model {
    let mut model = Model::default();
    model.document.params.slopes = SlopeGrid::default().into();
    opening::take_burst(&mut model, open((64, 48), 5));
    find(&mut model, &[(10.0, 10.0, 4), (30.0, 20.0, 4), (50.0, 30.0, 2)]);
    model
}

#[test]
fn answers_of_another_burst_are_dropped() {
    let mut model = with_features();
    let other = open((64, 48), 5);
    let request = PictureRequest::new(other.clone(), PictureKind::Frame(0), DetectorParams::default());
    let id = model.document.focus();
    panes::take_picture(&mut model, id, request.compute(&Work::alone(&Monitor::default())).expect("frame 0 is there"));
    assert!(Read::of(&model).picture().is_none());
    let before = Read::of(&model).features().len();
    let detected = detected(&other, &SearchParams::default(), Vec::new());
    detection::take_detection(&mut model, Side::A, detected, Duration::ZERO);
    assert_eq!(Read::of(&model).features().len(), before);
}

#[test]
fn the_busiest_slope_is_shown_until_a_hand_chooses() {
    let mut model = with_features();
    assert_eq!(model.document.cursor().slope, Slope::new(1.0, 0.0));
    let pane = model.document.focused_mut();
    (pane.cursor.slope, pane.slope_chosen) = (Slope::new(0.25, 0.0), true);
    find(&mut model, &[(1.0, 1.0, 0)]);
    assert_eq!(model.document.cursor().slope, Slope::new(0.25, 0.0));
}

#[test]
fn a_feature_that_is_found_again_stays_selected() {
    let mut model = with_features();
    model.document.selected = Some(1);
    find(&mut model, &[(30.3, 20.2, 4), (10.0, 10.0, 4)]);
    assert_eq!(model.document.selected, Some(0));
    find(&mut model, &[(5.0, 40.0, 4)]);
    assert_eq!(model.document.selected, None, "another feature is not the same one");
}

#[test]
fn next_and_previous_walk_the_table_and_stop_at_its_ends() {
    let mut model = with_features();
    change::select_next(&mut model, true);
    assert_eq!(model.document.selected, Some(0));
    (0..3).for_each(|_| change::select_next(&mut model, true));
    assert_eq!(model.document.selected, Some(2));
    let range = crate::app::document::filter::Interval { min: 0.5, max: 1.5 };
    model.document.filter.ranges.insert(crate::detector::Quantity::SlopeU, range);
    change::select_next(&mut model, false);
    assert_eq!(model.document.selected, Some(1), "the selected one was filtered out: the last listed is taken");
}

#[test]
fn a_new_burst_forgets_the_old_one_and_a_single_frame_still_shows() {
    let mut model = with_features();
    model.document.selected = Some(0);
    opening::take_burst(&mut model, open((40, 40), 1));
    let read = Read::of(&model);
    assert!(read.found_of(Side::A).is_none() && read.document.selected.is_none() && read.picture().is_none());
    assert_eq!(model.results.slots.a.param_error.as_ref().map(|e| e.subject.as_str()), Some("frames"));
    let wanted = Read::of(&model).wanted(model.document.focus()).expect("open");
    assert!(wanted.compute(&Work::alone(&Monitor::default())).is_ok());
}

#[test]
fn the_pane_in_focus_sets_the_range_whichever_picture_comes_first() {
    let ranges = |order: &dyn Fn(&mut Vec<PaneId>)| {
        let mut model = with_features();
        panes::lay_out(&mut model, Preset::FrameAndStack);
        let mut ids = model.document.panes.shown();
        assert_eq!(ids.len(), 2);
        order(&mut ids);
        for id in ids {
            let wanted = Read::of(&model).wanted(id).expect("its burst is open");
            let picture = wanted.compute(&Work::alone(&Monitor::default())).expect("not cancelled");
            panes::take_picture(&mut model, id, picture);
            let seen = Read::of(&model).display_of(id);
            assert_ne!((seen.min, seen.max), (0.0, 1.0), "what is seen first is seen in a range of its own");
        }
        model.document.look.ranges
    };
    assert_eq!(ranges(&|_| {}), ranges(&|ids| ids.reverse()));
}

#[test]
fn frames_and_stacks_have_ranges_of_their_own_and_a_range_is_set_again_unless_it_was_chosen() {
    let mut model = with_features();
    panes::lay_out(&mut model, Preset::FrameAndStack);
    let mut pictures = Vec::new();
    for id in model.document.panes.shown() {
        let wanted = Read::of(&model).wanted(id).expect("its burst is open");
        let picture = wanted.compute(&Work::alone(&Monitor::default())).expect("not cancelled");
        panes::take_picture(&mut model, id, picture.clone());
        pictures.push((id, picture));
    }
    for (id, picture) in &pictures {
        let (display, values) = (Read::of(&model).display_of(*id), picture.plane.data());
        let clipped = values.iter().filter(|value| !(display.min..=display.max).contains(*value)).count();
        assert!(clipped * 100 <= values.len(), "{clipped} of {} are black or white", values.len());
    }
    let [(_, frame), (_, stack)] = &pictures[..] else { panic!("two panes") };
    let mut ranges = model.document.look.ranges;
    assert_ne!(ranges.frame, ranges.intensity);
    // The first slope with features is shown: its stack may set the range, the frame's stays.
    let brighter = PictureAnswer { drawn: Arc::new(Plane::from_fn(8, 8, |u, v| (8 * v + u) as f32)), ..stack.clone() };
    ranges.forget_that_of(stack);
    ranges.fix_once(&brighter);
    assert!(ranges.intensity.max > 60.0 && ranges.frame == model.document.look.ranges.frame);
    let mut chosen = Ranges { intensity: ranges.intensity.with_range(0.1, 0.2), ..ranges };
    chosen.forget_that_of(&brighter);
    chosen.fix_once(stack);
    assert_eq!((chosen.intensity.min, chosen.intensity.max), (0.1, 0.2), "a hand chose it");
    assert!(frame.request.minus().is_none());
}

#[test]
fn a_strip_stays_a_strip_when_a_new_burst_is_opened_and_at_the_rim_of_the_range() {
    let mut model = with_features();
    panes::lay_out(&mut model, Preset::ThreeSlopes);
    let slopes = |model: &Model| -> Vec<f32> { model.document.panes.each_shown().map(|p| p.cursor.slope.u).collect() };
    assert_eq!(slopes(&model), [0.0, 1.0, 2.0]);
    opening::take_burst(&mut model, open((40, 30), 3));
    assert_eq!(slopes(&model), [-1.0, 0.0, 1.0], "the one in focus begins anew, the others beside it");
    model.document.show_slope(model.document.focus(), Slope::new(100.0, 0.0));
    params::check_params(&mut model);
    let limit = crate::app::document::cursor::slope_limit(&model.results.slots.a.usable_params.slopes);
    assert_eq!(slopes(&model), [limit - 1.0, limit, limit + 1.0]);
    let last = model.document.panes.shown()[2];
    let PictureKind::Stack { slope } = Read::of(&model).wanted(last).expect("open").kind else { panic!("a stack") };
    assert_eq!(slope.u, limit, "what is beyond is shown at the rim");
}
