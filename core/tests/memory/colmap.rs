//! Export to COLMAP holds the features of a few bursts, however many the dataset has; with the alignment, which is
//! solved for all images at once, also the places of the others.

use crate::peak_over;
use burstscope_core::Monitor;
use burstscope_core::burst::{OpenOptions, SequenceCut, cut_sequence, find_bursts};
use burstscope_core::dataset::{
    BurstCameras, ColmapJob, ColmapReport, FeatureJob, FeatureStore, ImageKind, export_colmap,
};
use burstscope_core::detector::{Method, NoiseGate, SearchParams};
use burstscope_core::matching::{MatchParams, PairSelection};
use burstscope_lab::synth::{SceneParams, synth_scene, write_burst};

/// Bytes of a feature in memory: four numbers and the descriptor.
const FEATURE_BYTES: u64 = 16 + 128;

#[test]
fn the_memory_of_an_export_does_not_grow_with_the_number_of_bursts() {
    let _alone = crate::alone();
    let home = tempfile::tempdir().expect("a folder");
    let most = 36;
    let scene = SceneParams { width: 400, height: 300, frames: most, snr: 4.0, seed: 5, ..SceneParams::default() };
    let (film, truth) = synth_scene(&scene, &Monitor::default()).expect("valid parameters");
    let folder = home.path().join("film");
    write_burst(&folder, &film, &truth, &Monitor::default()).expect("written");
    let sequence = &find_bursts(&[folder], &OpenOptions::default()).expect("one sequence")[0];
    // Bursts of one frame, in which noise gives many features.
    let bursts =
        cut_sequence(sequence, SequenceCut::new(1, None).expect("a cut"), &OpenOptions::default()).expect("bursts");
    let params = SearchParams {
        method: Method::Sift,
        noise_gate: NoiseGate::Factor(0.25),
        peak_threshold: 1e-4,
        ..SearchParams::default()
    };
    let aligned = ColmapJob {
        features: FeatureJob { detector: params, open: OpenOptions::default(), images: ImageKind::default() },
        matching: MatchParams::default(),
        pairs: PairSelection::Sequential(4),
        cameras: BurstCameras::default(),
    };
    let unaligned = ColmapJob { matching: MatchParams { align: false, ..MatchParams::default() }, ..aligned.clone() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let export = |count: usize, job: &ColmapJob| {
        let (out, mut report) = (home.path().join(format!("out-{count}")), None::<ColmapReport>);
        let mut store = FeatureStore::open(&out, &job.features).expect("a folder of its own");
        let bursts = &bursts[..count];
        let work = || report = export_colmap(&mut store, bursts, job, &mut |_| (), &Monitor::default()).ok();
        (peak_over(|| pool.install(work)), report.expect("exported"))
    };
    let few = 12;
    for (run, job, largest_share) in
        [("found", &unaligned, 0.25), ("read", &unaligned, 0.25), ("aligned", &aligned, 1.1)]
    {
        let [(small, _), (large, report)] = [few, most].map(|count| export(count, job));
        let features: usize = report.images.iter().map(|image| image.features).sum();
        let of_more = features as u64 / most as u64 * (most - few) as u64 * FEATURE_BYTES;
        println!(
            "features {run}: {} kB for {few} bursts, {} kB for {most}; the features of the others take {} kB",
            small / 1000,
            large / 1000,
            of_more / 1000
        );
        assert_eq!(report.pairs.len(), 4 * most - 10);
        assert!(of_more > 1_000_000, "few features say little: {features}");
        let bound = small + (of_more as f64 * largest_share) as u64;
        assert!(large < bound, "{run}: {small} and {large} bytes");
    }
}
