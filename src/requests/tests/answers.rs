//! Tests that a request's answer equals the result of the library's functions for the same values.

use super::{answer, detected, empty, open, params, write_chart};
use crate::burst::OpenOptions;
use crate::detector::Slope;
use crate::evaluate::poses::PoseStudy;
use crate::monitor::Monitor;
use crate::plane::display::Display;
use crate::requests::{
    Against, AgainstRequest, BurstSource, JobError, OpenRequest, PictureKind, PictureRequest, PosesRequest, Reference,
    TrajectorySource, ViewKind,
};
use crate::synth::FeatureTruth;

#[test]
fn a_difference_is_of_the_pixels_of_the_first() {
    let stack = PictureRequest::new(open(), PictureKind::Stack { slope: Slope::default() }, params());
    let frame = PictureRequest::new(open(), PictureKind::Frame(0), params());
    let difference = answer(stack.clone().less(&frame)).expect("pictures");
    let (a, b) = (answer(stack).expect("a picture"), &open().burst.frames[0]);
    let expected = |at: usize| a.plane.data()[at] - b.data()[at];
    assert!(difference.plane.data().iter().enumerate().all(|(at, x)| (x - expected(at)).abs() < 1e-6));
    // The octave's pixels are twice as large: the frame is taken at every second place.
    let dog = PictureKind::Dog { octave: 1, level: 1, slope: Slope::default() };
    let coarse = answer(PictureRequest::new(open(), dog, params()).less(&frame)).expect("pictures");
    assert_eq!(coarse.plane.size(), (48, 36));
    assert_eq!(coarse.request.minus().map(|minus| minus.kind), Some(PictureKind::Frame(0)));
}

#[test]
fn maps_have_the_pixels_of_their_octave_and_their_own_colours() {
    let of = |map| {
        let kind = PictureKind::Map { map, octave: 1, level: 1, slope: Slope::default() };
        answer(PictureRequest::new(open(), kind, params())).expect("a map")
    };
    let [noise, coverage, motion] = [ViewKind::Noise, ViewKind::Coverage, ViewKind::Motion].map(of);
    assert_eq!((noise.plane.size(), coverage.plane.size(), motion.plane.size()), ((48, 36), (96, 72), (48, 36)));
    let colours = motion.motion.clone().expect("winning slopes have colours");
    assert_eq!(motion.rgba(&Display::default()), colours.colours);
    assert_eq!((noise.bytes(), motion.bytes()), (4 * 48 * 36, 5 * 4 * 48 * 36));
}

#[test]
fn features_are_compared_with_earlier_ones_and_those_of_a_file() {
    let detection = detected().detection;
    let of = |with| answer(AgainstRequest { detection: detection.clone(), with }).expect("compared");
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
}

#[test]
fn sources_open_as_what_they_name() {
    let of = |source| answer(OpenRequest { source, options: OpenOptions::default() }).expect("it opens");
    for source in BurstSource::built_in() {
        let name = source.name().expect("what is built in has a name");
        assert_eq!(BurstSource::named(name), Some(source));
    }
    assert_eq!(BurstSource::named("no such burst"), None);
    let chart = of(open().source);
    assert!(chart.has_truth() && chart.burst.name == "Chart, SNR 20, seed 1");
    let truth = chart.truth(&Monitor::default()).expect("it is known").expect("it is known");
    assert_eq!(truth.features.len(), 4);
    let home = tempfile::tempdir().expect("a folder");
    let folder = home.path().join("night");
    write_chart(&folder, 1);
    let read = of(BurstSource::Paths(vec![folder.clone()]));
    assert_eq!((read.burst.len(), read.burst.size(), read.has_truth()), (4, (96, 72), true));
    let written = read.truth(&Monitor::default()).expect("it is known").expect("it is known");
    let rounded = |truth: &[FeatureTruth]| -> Vec<String> {
        truth.iter().map(|f| format!("{} {:.9} {:.9} {:.9} {:.9}", f.id, f.u, f.v, f.radius, f.slope_u)).collect()
    };
    assert_eq!(rounded(&written.features), rounded(&truth.features));
    let nothing_known = empty((8, 8), 2);
    assert!(!nothing_known.has_truth() && nothing_known.truth(&Monitor::default()).expect("none").is_none());
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
    let ask = |estimate, truth| answer(PosesRequest { estimate, truth, study: PoseStudy::default() });
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
