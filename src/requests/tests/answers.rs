//! Tests that a request's answer equals the result of the library's functions for the same values.

use super::{detected, empty, open, params, source, write_chart};
use crate::baseline;
use crate::burst::OpenOptions;
use crate::detect;
use crate::detector::DetectorParams;
use crate::detector::view::{dog_view, stack_view};
use crate::detector::{Method, SearchParams, Slope};
use crate::evaluate::poses::PoseStudy;
use crate::inspect::ProbeCache;
use crate::inspect::candidates::{SurveyOptions, survey};
use crate::inspect::changes::Spot;
use crate::inspect::probe::Wanted;
use crate::inspect::spectrum::{Spectrum, spectrum};
use crate::inspect::{ProbeOptions, probe};
use crate::matching::match_detections;
use crate::monitor::Monitor;
use crate::plane::display::Display;
use crate::requests::{
    Against, AgainstRequest, BurstSource, CompareRequest, Compared, DetectRequest, DetectionSource, ExplainQuestion,
    ExplainRequest, Explanation, JobError, LossesRequest, MatchRequest, NothingKept, OpenBurst, OpenRequest,
    PictureKind, PictureRequest, PosesRequest, ProbeQuestion, ProbeRequest, Reference, StudyRequest, Traced,
    TrailStore, TrajectorySource, ViewKind,
};
use crate::requests::{Request, Work};
use crate::study::Study;
use crate::synth::FeatureTruth;
use std::cell::{Cell, RefCell};
use std::sync::Arc;

fn no_monitor() -> Monitor {
    Monitor::default()
}

#[test]
fn features_are_those_of_the_detector() {
    let expected = detect(&open().burst, &params(), &no_monitor()).expect("valid parameters");
    let found = detected();
    assert!(expected.features.len() >= 4, "{} features", expected.features.len());
    assert_eq!(found.detection.features, expected.features);
    assert_eq!(found.detection.descriptors, expected.descriptors);
    assert_eq!((found.burst, found.params, found.finding.is_none()), (open().id, params(), true));
}

#[test]
fn the_comparison_of_methods_searches_as_each_method_does() {
    for method in Method::ALL {
        let asked: SearchParams = DetectorParams { method, ..params() }.into();
        let request = CompareRequest::Detect(DetectRequest { burst: open(), params: asked.clone() });
        let Ok(Compared::Detected(found)) = request.compute(&Work::alone(&no_monitor())) else { panic!("{method:?}") };
        let expected = detect::search(&open().burst, &asked, &no_monitor()).expect("valid parameters");
        assert_eq!(found.detection.features, expected.detection.features, "{method:?}");
        assert_eq!((found.params, found.asked), (expected.params, asked), "{method:?}");
    }
}

/// Store that keeps the last trail, and counts the calls.
#[derive(Default)]
struct OneKept {
    kept: RefCell<Option<Arc<ProbeCache>>>,
    made: Cell<usize>,
    room: Cell<usize>,
}

impl TrailStore for OneKept {
    fn put(&self, _: &OpenBurst, trail: &Arc<ProbeCache>) {
        *self.kept.borrow_mut() = Some(trail.clone());
    }

    fn make_room(&self) {
        self.room.set(self.room.get() + 1);
    }

    fn asked(&self, _: &OpenBurst, asked: &SearchParams) -> Option<Arc<ProbeCache>> {
        self.kept.borrow().clone().filter(|kept| SearchParams::from(kept.made_with()) == *asked)
    }

    fn rejudged(&self, _: &OpenBurst, _: &SearchParams, _: &Monitor) -> Result<Option<Arc<ProbeCache>>, JobError> {
        Ok(None)
    }

    fn get(&self, source: &DetectionSource) -> Option<Arc<ProbeCache>> {
        self.asked(&source.burst, &source.asked)
    }

    fn get_or_make(&self, source: &DetectionSource, monitor: &Monitor) -> Result<Arc<ProbeCache>, JobError> {
        self.made.set(self.made.get() + 1);
        NothingKept.get_or_make(source, monitor)
    }

    fn get_or_make_for(
        &self,
        burst: &OpenBurst,
        params: &DetectorParams,
        monitor: &Monitor,
    ) -> Result<Arc<ProbeCache>, JobError> {
        NothingKept.get_or_make_for(burst, params, monitor)
    }
}

/// A spectrum as text, without how long it took.
fn without_times(of: &Spectrum) -> String {
    format!("{:?}", (&of.grid, &of.bars, of.features, of.at_limit, &of.finding, &of.evidence, &of.aliases, &of.advice))
}

#[test]
fn what_a_detection_leaves_behind_is_kept_and_serves_the_next() {
    let store = OneKept::default();
    let request = DetectRequest { burst: open(), params: params().into() };
    let first = request.clone().compute(&Work::alone(&no_monitor()).with_trails(&store)).expect("valid");
    let trail = store.kept.borrow().clone().expect("it was put there");
    let second = request.compute(&Work::alone(&no_monitor()).with_trails(&store)).expect("valid");
    assert!(Arc::ptr_eq(&trail, &store.kept.borrow().clone().expect("kept")), "nothing was searched again");
    assert_eq!((store.room.get(), first.detection.features == second.detection.features), (1, true));
    let explain = |of| ExplainRequest { of, question: ExplainQuestion::Slopes };
    let kept = explain(source()).compute(&Work::alone(&no_monitor()).with_trails(&store)).expect("valid").explanation;
    assert_eq!(store.made.get(), 0);
    let made = explain(source()).compute(&Work::alone(&no_monitor())).expect("valid").explanation;
    let (Explanation::Slopes(kept), Explanation::Slopes(made)) = (kept, made) else { panic!("slopes were asked for") };
    assert_eq!(without_times(&kept), without_times(&made));
}

#[test]
fn pictures_are_those_of_the_detectors_view() {
    let slope = Slope::new(0.5, 0.0);
    let of =
        |kind| PictureRequest::new(open(), kind, params()).compute(&Work::alone(&no_monitor())).expect("a picture");
    let frame = of(PictureKind::Frame(2));
    assert!(Arc::ptr_eq(&frame.plane, &open().burst.frames[2]), "a frame is not copied");
    let stack = of(PictureKind::Stack { slope });
    assert_eq!(*stack.plane, stack_view(&open().burst, &params(), slope, &no_monitor()).expect("not cancelled"));
    let dog = of(PictureKind::Dog { octave: 1, level: 1, slope });
    assert_eq!(*dog.plane, dog_view(&open().burst, &params(), slope, 1, 1, &no_monitor()).expect("not cancelled"));
    assert_eq!((dog.request.kind.input_px_per_pixel(), stack.request.kind.input_px_per_pixel()), (2.0, 1.0));
    let merged = baseline::merge_burst(&open().burst, 0..4, &no_monitor()).expect("not cancelled");
    assert_eq!(of(PictureKind::Merge).plane, merged.frames[0]);
}

#[test]
fn a_difference_is_of_the_pixels_of_the_first() {
    let stack = PictureRequest::new(open(), PictureKind::Stack { slope: Slope::default() }, params());
    let frame = PictureRequest::new(open(), PictureKind::Frame(0), params());
    let difference = stack.clone().less(&frame).compute(&Work::alone(&no_monitor())).expect("pictures");
    let (a, b) = (stack.compute(&Work::alone(&no_monitor())).expect("a picture"), &open().burst.frames[0]);
    let expected = |at: usize| a.plane.data()[at] - b.data()[at];
    assert!(difference.plane.data().iter().enumerate().all(|(at, x)| (x - expected(at)).abs() < 1e-6));
    // The octave's pixels are twice as large: the frame is taken at every second place.
    let dog = PictureKind::Dog { octave: 1, level: 1, slope: Slope::default() };
    let coarse =
        PictureRequest::new(open(), dog, params()).less(&frame).compute(&Work::alone(&no_monitor())).expect("pictures");
    assert_eq!(coarse.plane.size(), (48, 36));
    assert_eq!(coarse.request.minus().map(|minus| minus.kind), Some(PictureKind::Frame(0)));
}

#[test]
fn maps_have_the_pixels_of_their_octave_and_their_own_colours() {
    let of = |map| {
        let kind = PictureKind::Map { map, octave: 1, level: 1, slope: Slope::default() };
        PictureRequest::new(open(), kind, params()).compute(&Work::alone(&no_monitor())).expect("a map")
    };
    let [noise, coverage, motion] = [ViewKind::Noise, ViewKind::Coverage, ViewKind::Motion].map(of);
    assert_eq!((noise.plane.size(), coverage.plane.size(), motion.plane.size()), ((48, 36), (96, 72), (48, 36)));
    assert!(noise.plane.data().iter().all(|&sigma| sigma > 0.0), "noise is everywhere");
    let covers = coverage.plane.data().iter().all(|&share| (share - 1.0).abs() < 1e-6);
    assert!(covers, "at slope 0 all frames see all places");
    let colours = motion.motion.clone().expect("winning slopes have colours");
    assert_eq!(motion.rgba(&Display::default()), colours.colours);
    // At the middle of a disc its slope wins.
    let feature =
        *detected().detection.features.iter().find(|f| f.octave == 1).unwrap_or(&detected().detection.features[0]);
    let (slope, sure) = colours.at(((feature.u / 2.0) as usize, (feature.v / 2.0) as usize));
    assert!((0.0..=1.0).contains(&sure) && params().slopes.slopes().any(|of_grid| of_grid == slope), "{slope:?}");
    assert_eq!((noise.bytes(), motion.bytes()), (4 * 48 * 36, 5 * 4 * 48 * 36));
}

#[test]
fn matches_and_losses_are_those_of_the_library() {
    let (a, b) = (detected().detection, detected().detection);
    let request = MatchRequest { a: a.clone(), b: b.clone(), params: Default::default() };
    let matched = request.compute(&Work::alone(&no_monitor())).expect("valid");
    assert_eq!(Ok(&*matched.result), match_detections(&a, &b, &Default::default(), &no_monitor()).as_ref());
    // In a burst matched with itself each feature is its own nearest neighbour.
    assert!(matched.result.matches.iter().all(|m| m.a == m.b) && !matched.result.matches.is_empty());
    let losses = LossesRequest { request: matched.request, result: matched.result, size_b: (96, 72) };
    let found = losses.compute(&Work::alone(&no_monitor())).expect("not cancelled");
    assert_eq!(found.lost.len(), a.features.len());
    for (lost, count) in found.counts {
        assert_eq!(found.lost.iter().filter(|&&of| of == lost).count(), count, "{lost:?}");
    }
}

#[test]
fn questions_about_a_detection_are_answered_by_inspect() {
    let cache = NothingKept.get_or_make(&source(), &no_monitor()).expect("valid");
    let traced = Traced { burst: open().id, cache: cache.clone() };
    let ask = |question| {
        ProbeRequest { traced: traced.clone(), question, near_sigma: None }
            .compute(&Work::alone(&no_monitor()))
            .expect("an answer")
    };
    let wanted = Wanted::Feature(0);
    let answer = ask(ProbeQuestion::At { place: [0.0, 0.0], wanted });
    let options = ProbeOptions { wanted, ..ProbeOptions::default() };
    let expected = probe(&cache, [0.0, 0.0], &options, &no_monitor()).expect("an answer");
    assert_eq!(format!("{:?}", answer.probe), format!("{expected:?}"));
    // The strongest candidate of a clear chart was kept.
    let strongest = ask(ProbeQuestion::Strongest);
    assert!(strongest.probe.subject_fate().is_some_and(|fate| fate.is_kept()));

    let explain = |question| {
        let request = ExplainRequest { of: source(), question };
        request.compute(&Work::alone(&no_monitor())).expect("an explanation").explanation
    };
    let Explanation::Slopes(slopes) = explain(ExplainQuestion::Slopes) else { panic!("slopes were asked for") };
    assert_eq!(without_times(&slopes), without_times(&spectrum(&cache, &no_monitor()).expect("not cancelled")));
    let options = SurveyOptions::default();
    let Explanation::Candidates(found) = explain(ExplainQuestion::Candidates(options)) else { panic!("candidates") };
    let expected = survey(&cache.trail, &options, &no_monitor()).expect("not cancelled");
    assert_eq!((found.marks.len(), found.kept), (expected.marks.len(), expected.kept));
}

#[test]
fn features_are_compared_with_what_is_really_there_and_with_earlier_ones() {
    let detection = detected().detection;
    let of = |with| {
        AgainstRequest { detection: detection.clone(), with }.compute(&Work::alone(&no_monitor())).expect("compared")
    };
    let Against::Truth { against, truth } = of(Reference::Truth { burst: open(), params: params() }).against else {
        panic!("the truth was asked for")
    };
    assert_eq!(truth.features.len(), 4);
    assert_eq!(against.found.len() + against.missed.len(), 4);
    assert!(against.found.len() >= 3 && against.is_whole_truth, "{}", against.summary());
    // An earlier result that is not kept any more is detected again, without a change.
    let earlier = Reference::Earlier { burst: open(), asked: params().into(), detection: None };
    let against = of(earlier).against;
    let Against::Changes { changes, before, .. } = &against else { panic!("changes were asked for") };
    assert_eq!((changes.gained.len(), changes.lost.len()), (0, 0));
    assert_eq!(before.len(), detection.features.len());
    assert_eq!(against.found_again().map(|found| &found.features), Some(&detection.features));
    assert!(against.read().is_none());
    // A file of the same features, too.
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("others.csv");
    crate::export::write_csv(&path, &detection.features).expect("written");
    let against = of(Reference::File { path, features: None }).against;
    assert_eq!(against.read().map(|read| read.len()), Some(detection.features.len()));
    let Against::Changes { changes, .. } = &against else { panic!("changes were asked for") };
    assert_eq!((changes.gained.len(), changes.lost.len()), (0, 0));
    assert_eq!(Spot::from(&detection.features[0]).pos_image, [detection.features[0].u, detection.features[0].v]);
}

#[test]
fn sources_open_as_what_they_name() {
    let of = |source: BurstSource| {
        OpenRequest { source, options: OpenOptions::default() }.compute(&Work::alone(&no_monitor())).expect("it opens")
    };
    for source in BurstSource::built_in() {
        let name = source.name().expect("what is built in has a name");
        assert_eq!(BurstSource::named(name), Some(source));
    }
    assert_eq!(BurstSource::named("no such burst"), None);
    let chart = of(open().source);
    assert!(chart.has_truth() && chart.burst.name == "Chart, SNR 20, seed 1");
    let truth = chart.truth(&no_monitor()).expect("it is known").expect("it is known");
    assert_eq!(truth.features.len(), 4);
    let home = tempfile::tempdir().expect("a folder");
    let folder = home.path().join("night");
    write_chart(&folder, 1);
    let read = of(BurstSource::Paths(vec![folder.clone()]));
    assert_eq!((read.burst.len(), read.burst.size(), read.has_truth()), (4, (96, 72), true));
    let written = read.truth(&no_monitor()).expect("it is known").expect("it is known");
    let rounded = |truth: &[FeatureTruth]| -> Vec<String> {
        truth.iter().map(|f| format!("{} {:.9} {:.9} {:.9} {:.9}", f.id, f.u, f.v, f.radius, f.slope_u)).collect()
    };
    assert_eq!(rounded(&written.features), rounded(&truth.features));
    let nothing_known = empty((8, 8), 2);
    assert!(!nothing_known.has_truth() && nothing_known.truth(&no_monitor()).expect("none").is_none());
    let label = |names: &[&str]| BurstSource::Paths(names.iter().map(Into::into).collect()).label();
    assert_eq!(
        (label(&[]), label(&["a/b"]), label(&["a/b", "a/c", "d"])),
        ("nothing".into(), "b".into(), "b and 2 more".into())
    );
}

#[test]
fn trajectories_are_read_and_compared_when_both_are_there() {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("poses.txt");
    let lines: Vec<String> = (0..8).map(|t| format!("{t} {} {} 0 0 0 0 1", t * t, (t * 7) % 5)).collect();
    std::fs::write(&path, lines.join("\n")).expect("written");
    let at = Some(TrajectorySource::Path(path.clone()));
    let ask = |estimate, truth| {
        PosesRequest { estimate, truth, study: PoseStudy::default() }.compute(&Work::alone(&no_monitor()))
    };
    let one = ask(at.clone(), None).expect("it is read");
    assert!(one.report.is_none() && one.truth.is_none());
    let (read_from, trajectory) = one.estimate.expect("it was read");
    assert_eq!((&read_from, trajectory.poses.len()), (&path, 8));
    // Features that were read are passed in, so the file is not read again.
    std::fs::remove_file(&path).expect("removed");
    let again = Some(TrajectorySource::Read(path.clone(), trajectory));
    let both = ask(again.clone(), again).expect("nothing is to be read");
    assert!(both.report.expect("both are there").is_ok());
    assert!(matches!(ask(at, None), Err(JobError::Failed(why)) if why.contains("poses.txt")));
}

#[test]
fn a_study_grows_up_to_its_report() {
    let chart = crate::evaluate::ChartStudy { chart: super::chart(1), seeds: 2, ..Default::default() };
    let heard = std::sync::Mutex::new(0usize);
    let tell = |_: crate::study::StudyReport| *heard.lock().expect("no panic") += 1;
    let request = StudyRequest { study: Study::Chart(Box::new(chart.clone())), open: None };
    let report = request.compute(&Work::alone(&no_monitor()).telling(&tell)).expect("valid");
    let expected = Study::Chart(Box::new(chart)).run_telling(&no_monitor(), &|_| {}).expect("valid");
    assert_eq!(format!("{report:?}"), format!("{expected:?}"));
    assert!(*heard.lock().expect("no panic") > 0);
}
