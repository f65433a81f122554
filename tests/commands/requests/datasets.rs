//! Tests of work on a dataset: the events before the answer, and the finished results.

use super::{params, write_chart};
use crate::support::*;
use burstscope::dataset::DatasetSource;
use burstscope::requests::{Bursts, DatasetAnswer, DatasetEvent, DatasetRequest, Keeping, OpenDataset};
#[cfg(feature = "colmap")]
use burstscope::{
    dataset::{ColmapJob, FeatureJob},
    requests::ColmapRequest,
};

/// Three charts in `home`, the second of them broken.
fn nights(home: &Path) -> DatasetSource {
    for (name, seed) in [("a", 1), ("b", 2), ("c", 1)] {
        write_chart(&home.join("nights").join(name), seed);
    }
    home.write("nights/b/frame_001.png", "broken");
    DatasetSource::of_bursts(vec![home.join("nights")])
}

fn look(home: &Path, source: DatasetSource, params: DetectorParams) -> OpenDataset {
    let request = DatasetRequest::Open {
        source,
        folder: Some(home.join("kept")),
        params: params.into(),
        open: Default::default(),
    };
    match request.compute(&Work::alone(&Monitor::default())) {
        Ok(DatasetAnswer::Opened(open)) => *open,
        other => panic!("{other:?}"),
    }
}

fn keeping(home: &Path, params: SearchParams) -> Keeping {
    Keeping { folder: home.join("kept"), params, open: Default::default() }
}

/// Finds the features of all bursts; returns the result and the events.
fn detect(bursts: &Bursts, keeping: &Keeping, monitor: &Monitor) -> (Result<(), JobError>, Vec<DatasetEvent>) {
    let told = Mutex::new(Vec::new());
    let request = DatasetRequest::Detect { bursts: bursts.clone(), keeping: keeping.clone() };
    let tell = |event| told.lock().expect("no panic").push(event);
    let end = request.compute(&Work { tell: &tell, ..Work::alone(monitor) }).map(drop);
    (end, told.into_inner().expect("no panic"))
}

#[test]
fn each_burst_is_told_of_and_what_is_finished_stays_finished() {
    let home = folder();
    let source = nights(&home);
    let dataset = look(&home, source.clone(), params());
    assert_eq!((dataset.bursts.len(), dataset.folder_error.as_deref(), &dataset.other_params), (3, None, &None));
    assert!(dataset.finished.iter().all(Option::is_none));
    let keeping = keeping(&home, params().into());
    let (end, told) = detect(&dataset.bursts, &keeping, &Monitor::default());
    assert_eq!(end, Ok(()), "the others go on");
    let (mut done, mut failed) = (Vec::new(), Vec::new());
    for event in &told {
        match event {
            DatasetEvent::Done { index, finished } => done.push((*index, finished.features)),
            DatasetEvent::Failed { index, error } => failed.push((*index, error.contains("frame_001.png"))),
            DatasetEvent::Begun { .. } | DatasetEvent::Matched { .. } => {}
        }
    }
    assert_eq!((done.iter().map(|(index, _)| *index).collect::<Vec<_>>(), failed), (vec![0, 2], vec![(1, true)]));
    assert!(done[0].1 >= 4 && done[0].1 == done[1].1, "{done:?}: both are the same chart");
    let again = look(&home, source.clone(), params());
    let counts: Vec<Option<usize>> = again.finished.iter().map(|f| f.as_ref().map(|f| f.features)).collect();
    assert_eq!(counts, [Some(done[0].1), None, Some(done[1].1)]);
    // With other parameters nothing is finished, and the answer holds the parameters of the features in the folder.
    let other = look(&home, source, DetectorParams { levels: 3, ..params() });
    assert!(other.finished.iter().all(Option::is_none));
    assert_eq!(other.other_params, Some(params().into()));
    // The two finished bursts are matched; pairs with the broken one are left out.
    // So are those that are to look most alike: the broken one looks like none.
    for (pairs, without) in [(PairSelection::All, 2), (PairSelection::Near(1), 1)] {
        let matched = Mutex::new(Vec::new());
        let (bursts, keeping) = (dataset.bursts.clone(), keeping.clone());
        let request = DatasetRequest::Match { bursts, keeping, pairs, matching: Default::default() };
        let tell = |event| {
            if let DatasetEvent::Matched { pair, counts } = event {
                matched.lock().expect("no panic").push((pair, counts.putative));
            }
        };
        let answer = request.compute(&Work { tell: &tell, ..Work::alone(&Monitor::default()) });
        assert!(matches!(answer, Ok(DatasetAnswer::Matched { left_out }) if left_out == without), "{answer:?}");
        let matched = matched.into_inner().expect("no panic");
        assert!(matched.len() == 1 && matched[0].0 == (0, 2) && matched[0].1 > 0, "{matched:?}");
    }
}

#[test]
fn parameters_that_make_no_sense_and_a_cancel_end_it_before_a_burst_is_begun() {
    let home = folder();
    let bursts = look(&home, nights(&home), params()).bursts;
    let wrong = DetectorParams { levels: 0, ..params() };
    let (end, told) = detect(&bursts, &keeping(&home, wrong.into()), &Monitor::default());
    assert!(matches!(end, Err(JobError::Failed(why)) if why.contains("levels")) && told.is_empty());
    let cancelled = Monitor::default();
    cancelled.cancel();
    let (end, told) = detect(&bursts, &keeping(&home, params().into()), &cancelled);
    assert_eq!(end, Err(JobError::Cancelled));
    assert!(!told.iter().any(|event| matches!(event, DatasetEvent::Done { .. })));
}

#[cfg(feature = "colmap")]
#[test]
fn an_export_to_a_new_folder_takes_the_features_that_are_kept() {
    let home = folder();
    let bursts = look(&home, nights(&home), params()).bursts;
    let keeping = keeping(&home, params().into());
    assert_eq!(detect(&bursts, &keeping, &Monitor::default()).0, Ok(()));
    let report = |out: &str, params: DetectorParams| {
        let request = ColmapRequest {
            out: home.join(out),
            inputs: vec![home.join("nights")],
            kept: Some(keeping.folder.clone()),
            job: ColmapJob {
                features: FeatureJob { detector: params.into(), open: Default::default(), images: Default::default() },
                matching: Default::default(),
                pairs: PairSelection::All,
                cameras: Default::default(),
            },
        };
        let request = DatasetRequest::Colmap { bursts: bursts.clone(), request: Box::new(request) };
        match request.compute(&Work::alone(&Monitor::default())) {
            Ok(DatasetAnswer::Colmap(done)) => done.report,
            other => panic!("{other:?}"),
        }
    };
    let exported = |out, params| report(out, params).images.iter().map(|image| image.resumed).collect::<Vec<_>>();
    assert_eq!(exported("new", params()), [true, true], "the broken burst is left out");
    assert!(home.join("new/features/a.png.txt").is_file() && home.join("new/images/c.png").is_file());
    assert_eq!(exported("other", DetectorParams { levels: 3, ..params() }), [false, false]);
    assert_eq!(exported("kept", params()), [true, true]);
    let (width, height) = image::image_dimensions(home.join("nights/c/frame_000.png")).expect("a picture");
    let text = format!("model = \"SIMPLE_PINHOLE\"\nwidth = {width}\nheight = {height}\nparams = [300, 60, 40]\n");
    let file = home.join("nights/c/camera.toml");
    fs::write(&file, text).expect("written");
    let cameras = report("new", params()).cameras;
    let known: Vec<_> = cameras.iter().map(|of| (of.known, of.from.clone(), of.images.clone())).collect();
    assert_eq!(known, [(false, vec![], vec![1]), (true, vec![file], vec![2])]);
}
