//! A long-lived window: hundreds of bursts of one dataset go through its engine, and at the end it holds no more memory
//! than soon after the beginning.
//!
//! The same of its pictures ([`zooming`]). The tests run one after the other, alone in their program, so that nothing
//! else is counted: the engine's own account, the graphics device's, and all allocations of the program.

use burstscope::dataset::DatasetSource;
use burstscope::detector::{DetectorParams, SearchParams, Slope, SlopeGrid};
use burstscope::engine::{Engine, Held, Wanted};
use burstscope::requests::{
    BurstSource, Bursts, DatasetAnswer, DatasetEvent, DatasetRequest, DetectRequest, Keeping, OpenBurst, OpenRequest,
    PictureKind, PictureRequest, Request, ThumbnailsRequest,
};
use peak_alloc::PeakAlloc;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

#[cfg(feature = "app")]
#[path = "soak/zooming.rs"]
mod zooming;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const BURSTS: usize = 500;
const FRAMES: usize = 3;
const SIDE: usize = 24;
/// Number of bursts after which nothing grows: one-time allocations are made, and budgets are used up.
const SETTLED: usize = 100;
/// Size of the picture cache: it is full before the hundredth burst.
const CACHE_BYTES: usize = 64 << 10;
const TRAIL_BYTES: usize = 64 << 10;
/// Maximum growth of the program's memory from the hundred bursts after [`SETTLED`] to the last hundred: their names.
/// 300 bursts with their frames, pictures and trails are 4 MB.
const GROWTH_BYTES: u64 = 256 << 10;

static ALONE: Mutex<()> = Mutex::new(());

const PATIENCE: Duration = Duration::from_secs(120);

/// Writes a long sequence of small frames: a blob that moves to and fro over noise.
fn write_frames(folder: &Path) {
    let mut state = 7u32;
    for t in 0..BURSTS * FRAMES {
        let (burst, dt) = (t / FRAMES, (t % FRAMES) as f32 - 1.0);
        let (u0, v0) = (8.0 + (burst % 8) as f32 + dt, 8.0 + (burst / 8 % 8) as f32);
        let pixels: Vec<u8> = (0..SIDE * SIDE)
            .map(|at| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let (u, v) = ((at % SIDE) as f32, (at / SIDE) as f32);
                let blob = 160.0 * (-((u - u0).powi(2) + (v - v0).powi(2)) / 12.0).exp();
                (40.0 + blob + (state >> 28) as f32) as u8
            })
            .collect();
        let frame = image::GrayImage::from_raw(SIDE as u32, SIDE as u32, pixels).expect("so many pixels");
        frame.save(folder.join(format!("{t:04}.png"))).expect("written");
    }
}

fn wait_for<T>(mut poll: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = poll() {
            return found;
        }
        assert!(Instant::now() < end, "nothing happened in {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn answer_of<R: Request>(engine: &Engine, wanted: &mut Wanted<R>, request: R) -> R::Answer {
    wanted.ask(engine, request);
    wait_for(|| wanted.take().into_iter().next()).result.expect("there is an answer")
}

/// Memory held by the engine and by the program, after each burst.
#[derive(Default)]
struct Soak {
    held: Vec<Held>,
    allocated: Vec<u64>,
}

impl Soak {
    fn note(&mut self, engine: &Engine) {
        self.held.push(engine.held());
        self.allocated.push(ALLOCATOR.current_usage() as u64);
    }

    /// Compares the end with the state at [`SETTLED`].
    fn assert_does_not_grow(&self, what: &str) {
        assert_eq!(self.held.len(), BURSTS, "{what}");
        let most = |held: &[Held], of: fn(&Held) -> usize| held.iter().map(of).max().unwrap_or(0);
        let (before, after) = self.held.split_at(SETTLED);
        for of in [|h: &Held| h.trails, |h: &Held| h.requests] {
            assert!(most(after, of) <= most(before, of), "{what}: {:?} and then {:?}", before.last(), after.last());
        }
        assert!(most(after, |h| h.picture_bytes) <= CACHE_BYTES, "{what}");
        assert!(most(after, |h| h.trail_bytes) <= TRAIL_BYTES, "{what}");
        // The least of a hundred: more than that is a search at work at that moment.
        let least = |range: std::ops::Range<usize>| self.allocated[range].iter().copied().min().unwrap_or(0);
        let (soon, late) = (least(SETTLED..2 * SETTLED), least(BURSTS - SETTLED..BURSTS));
        println!("{what}: {} kB after burst {SETTLED}, {} kB at the end", soon >> 10, late >> 10);
        assert!(late < soon + GROWTH_BYTES, "{what}: {soon} and then {late}");
    }
}

/// Finds the features of all bursts, as the workspace *Matches* does.
fn find_all(engine: &Engine, bursts: &Bursts, keeping: &Keeping) -> Soak {
    let mut soak = Soak::default();
    let (mut thumbnails, mut detecting) = (Wanted::default(), Wanted::default());
    let open = burstscope::burst::OpenOptions::default();
    thumbnails.ask(engine, ThumbnailsRequest { bursts: bursts.to_vec(), max_side_px: 16, open });
    detecting.ask(engine, DatasetRequest::Detect { bursts: bursts.clone(), keeping: keeping.clone() });
    let mut found = 0;
    let ended = wait_for(|| {
        thumbnails.take_partial();
        thumbnails.take();
        let ended = detecting.take().into_iter().next();
        for event in detecting.take_partial() {
            match event {
                DatasetEvent::Done { finished, .. } => {
                    found += finished.features;
                    soak.note(engine);
                }
                DatasetEvent::Failed { error, .. } => panic!("{error}"),
                _ => {}
            }
        }
        ended
    });
    ended.result.expect("all are found");
    assert!(found >= BURSTS / 2, "{found} features: blobs that are seen by nobody test nothing");
    soak
}

/// Opens, searches and shows one burst after the other, as a user going through a filmstrip does.
fn look_at_each(engine: &Engine, bursts: &Bursts, params: &SearchParams) -> Soak {
    let mut soak = Soak::default();
    let (mut opening, mut detecting) = (Wanted::default(), Wanted::default());
    let mut pictures: [Wanted<PictureRequest>; 2] = Default::default();
    for source in bursts.iter() {
        let source = BurstSource::Paths(source.paths.clone());
        let burst: OpenBurst = answer_of(engine, &mut opening, OpenRequest { source, options: Default::default() });
        engine.keep_trails_of(&[burst.id]);
        let params = params.clone();
        answer_of(engine, &mut detecting, DetectRequest { burst: burst.clone(), params: params.clone() });
        for (wanted, u) in pictures.iter_mut().zip([0.0, 1.0]) {
            let kind = PictureKind::Stack { slope: Slope::new(u, 0.0) };
            answer_of(engine, wanted, PictureRequest::new(burst.clone(), kind, params.at_given()));
        }
        wait_for(|| engine.is_idle().then_some(()));
        soak.note(engine);
        assert_eq!(engine.held().trails, 1, "that of the burst that is open");
    }
    soak
}

#[test]
fn five_hundred_bursts_leave_no_more_behind_than_one_hundred() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let home = tempfile::tempdir().expect("a folder");
    let frames = home.path().join("frames");
    std::fs::create_dir(&frames).expect("a folder");
    write_frames(&frames);
    let source = DatasetSource { paths: vec![frames], burst_length: Some(FRAMES), burst_step: None };
    let slopes = SlopeGrid::line(-1.0..=1.0, 3);
    let params: SearchParams = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() }.into();
    let folder = home.path().join("kept");
    let keeping = Keeping { folder: folder.clone(), params: params.clone(), open: Default::default() };
    let engine = Engine::new(Arc::new(|| {}), CACHE_BYTES);
    let request = DatasetRequest::Open {
        source,
        folder: Some(folder.clone()),
        params: params.clone(),
        open: keeping.open.clone(),
    };
    let dataset = match answer_of(&engine, &mut Wanted::default(), request) {
        DatasetAnswer::Opened(dataset) => dataset,
        other => panic!("{other:?}"),
    };
    assert_eq!(dataset.bursts.len(), BURSTS);
    find_all(&engine, &dataset.bursts, &keeping).assert_does_not_grow("a dataset");
    look_at_each(&engine, &dataset.bursts, &params).assert_does_not_grow("bursts one by one");
    wait_for(|| engine.is_idle().then_some(()));
    engine.keep_trails_of(&[]);
    let left = engine.held();
    assert_eq!((left.trails, left.trail_bytes, left.requests), (0, 0, 0));
    // All records of bursts are equally large but for the blobs of their features: none lists all bursts.
    let without_blobs = |text: String| {
        let record: serde_json::Value = serde_json::from_str(&text).expect("a record");
        (text.len() - record["blobs"].as_str().expect("digits").len()) as u64
    };
    let sizes: Vec<u64> = std::fs::read_dir(folder.join("records"))
        .expect("records")
        .map(|entry| without_blobs(std::fs::read_to_string(entry.expect("an entry").path()).expect("a file")))
        .collect();
    assert_eq!(sizes.len(), BURSTS);
    let (min, max) = (sizes.iter().min().expect("some"), sizes.iter().max().expect("some"));
    assert!(max - min < 64, "records of {min} to {max} bytes");
    let manifest = std::fs::metadata(folder.join("manifest.json")).expect("a manifest").len();
    assert!(manifest < 2 * max, "a manifest of {manifest} bytes");
}
