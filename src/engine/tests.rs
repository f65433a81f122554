//! The engine's promises: latest wins, cancel, a panic becomes a message, the cache keeps its budget.

use super::*;
use crate::burst::Burst;
use crate::detector::Slope;
use crate::monitor::Stage;
use crate::plane::Plane;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

const PATIENCE: Duration = Duration::from_secs(20);

fn nobody() -> OnUpdate {
    Arc::new(|| {})
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

/// Work that runs until it is cancelled or let go.
fn stubborn(go: mpsc::Receiver<()>) -> impl Fn(u32, &Monitor) -> Result<u32, JobError> + Send + Sync {
    let go = Mutex::new(go);
    move |request, monitor| {
        loop {
            monitor.check()?;
            if go.lock().expect("not poisoned").try_recv().is_ok() {
                return Ok(request);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

fn queue() -> Arc<JobQueue> {
    Arc::new(JobQueue::new(nobody()))
}

/// Jobs that run until they are cancelled or let go, and the sender of the words that let one go.
fn stubborn_jobs(grace: Duration) -> (Jobs<u32, u32>, mpsc::Sender<()>) {
    let (go, gone) = mpsc::channel();
    (Jobs::new(&queue(), Priority::Search, grace, stubborn(gone)), go)
}

/// Waits for `count` answers: their slots, ids and results.
fn answers_of(jobs: &Jobs<u32, u32>, count: usize) -> Vec<(u32, JobId, Result<u32, JobError>)> {
    let mut taken = Vec::new();
    wait_for(|| {
        taken.extend(jobs.take_answers_for().into_iter().map(|(slot, answer)| (slot, answer.id, answer.result)));
        (taken.len() >= count).then_some(())
    });
    assert_eq!(taken.len(), count, "{taken:?}");
    taken
}

#[test]
fn the_latest_request_wins_and_every_request_has_one_answer() {
    let (jobs, go) = stubborn_jobs(Duration::ZERO);
    let ids: Vec<JobId> = (0..50).map(|i| jobs.submit(i)).collect();
    wait_for(|| jobs.running().filter(|r| r.id == ids[49]));
    go.send(()).expect("the work listens");
    let mut answers = answers_of(&jobs, 50);
    wait_for(|| jobs.is_idle().then_some(()));
    answers.sort_by_key(|(_, id, _)| *id);
    assert!(answers.iter().map(|(_, id, _)| *id).eq(ids), "each once");
    assert_eq!(answers.pop().map(|(.., result)| result), Some(Ok(49)));
    assert!(answers.iter().all(|(.., result)| *result == Err(JobError::Superseded)), "{answers:?}");
    assert!(jobs.take_answers().next().is_none());
}

#[test]
fn within_its_grace_a_superseded_request_is_still_answered() {
    let (jobs, go) = stubborn_jobs(Duration::from_secs(60));
    let first = jobs.submit(1);
    // One that has a progress or a time of its own runs; one that waits has begun just now.
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let second = jobs.submit(2);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(0, first, Ok(1))]);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(0, second, Ok(2))]);
}

#[test]
fn after_its_grace_a_superseded_request_is_cancelled() {
    let queue = queue();
    let (go, gone) = mpsc::channel();
    let jobs = Jobs::new(&queue, Priority::Search, Duration::from_millis(30), stubborn(gone));
    let first = jobs.submit(1);
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let second = jobs.submit(2);
    wait_for(|| {
        queue.enforce_grace();
        jobs.running().filter(|r| r.id == second)
    });
    assert_eq!(answers_of(&jobs, 1), [(0, first, Err(JobError::Superseded))]);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(0, second, Ok(2))]);
}

#[test]
fn slots_do_not_disturb_one_another() {
    let (jobs, go) = stubborn_jobs(Duration::ZERO);
    let old = jobs.submit_for(7, 1);
    wait_for(|| (!jobs.is_idle()).then_some(()));
    let (other, new) = (jobs.submit_for(8, 2), jobs.submit_for(7, 3));
    let superseded = answers_of(&jobs, 1);
    assert_eq!(superseded, [(7, old, Err(JobError::Superseded))]);
    go.send(()).expect("the work listens");
    go.send(()).expect("the work listens");
    let mut answers = answers_of(&jobs, 2);
    answers.sort_by_key(|(slot, ..)| *slot);
    assert_eq!(answers, [(7, new, Ok(3)), (8, other, Ok(2))]);
}

#[test]
fn what_is_there_already_comes_at_once_and_the_older_one_never() {
    let (jobs, _go) = stubborn_jobs(Duration::from_secs(60));
    let old = jobs.submit(1);
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let new = jobs.publish_for(0, 5);
    let answers = answers_of(&jobs, 2);
    assert_eq!(answers, [(0, new, Ok(5)), (0, old, Err(JobError::Superseded))]);
}

#[test]
fn a_picture_goes_before_a_dataset_and_beside_it() {
    let queue = queue();
    let (go, gone) = mpsc::channel::<()>();
    let gone = Arc::new(Mutex::new(gone));
    let long = |priority| {
        let gone = gone.clone();
        Jobs::new(&queue, priority, Duration::ZERO, move |request: u32, monitor: &Monitor| {
            while gone.lock().expect("not poisoned").try_recv().is_err() {
                monitor.check()?;
                std::thread::sleep(Duration::from_millis(1));
            }
            Ok(request)
        })
    };
    let (datasets, searches) = (long(Priority::Dataset), long(Priority::Search));
    for slot in 0..10 {
        datasets.submit_for(slot, slot);
        searches.submit_for(slot, slot);
    }
    // More work than threads, and none of it ends: yet a picture is made.
    let pictures = Jobs::new(&queue, Priority::Picture, Duration::ZERO, |request: u32, _: &Monitor| Ok(request));
    pictures.submit(3);
    assert_eq!(wait_for(|| pictures.take_answers().next()).result, Ok(3));
    drop(go);
}

#[test]
fn cancelling_answers_cancelled_also_what_waits_behind_a_superseded_one() {
    let (jobs, go) = stubborn_jobs(Duration::from_secs(60));
    let first = jobs.submit(1);
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let second = jobs.submit(2);
    jobs.cancel();
    let mut answers = answers_of(&jobs, 2);
    answers.sort_by_key(|(_, id, _)| *id);
    assert_eq!(answers, [(0, first, Err(JobError::Superseded)), (0, second, Err(JobError::Cancelled))]);
    let next = jobs.submit(3);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(0, next, Ok(3))]);
}

#[test]
fn work_tells_on_the_way_and_what_was_superseded_tells_nothing_more() {
    let queue = queue();
    let work = |request: u32, tell: &dyn Fn(u32), monitor: &Monitor| {
        tell(10 * request);
        if request == 1 {
            while !monitor.is_cancelled() {
                std::thread::sleep(Duration::from_millis(1));
            }
            tell(99);
            monitor.check()?;
        }
        tell(10 * request + 1);
        Ok(request)
    };
    let jobs: Jobs<u32, u32, u32> = Jobs::telling(&queue, Priority::Dataset, Duration::ZERO, work);
    jobs.submit(1);
    let mut told = Vec::new();
    wait_for(|| {
        told.extend(jobs.take_news().0);
        (told == [10]).then_some(())
    });
    jobs.submit(2);
    let (mut told, mut answers) = (Vec::new(), Vec::new());
    wait_for(|| {
        let (more, ended) = jobs.take_news();
        told.extend(more);
        answers.extend(ended);
        (answers.len() == 2).then_some(())
    });
    assert_eq!(told, [20, 21]);
    assert!(answers[0].is_superseded() && answers[1].result == Ok(2));
}

/// A kind of work of one's own takes these few lines.
#[test]
fn a_new_kind_of_work_is_a_function_on_the_queue_of_an_engine() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let doubling = Jobs::new(engine.queue(), Priority::Search, Duration::ZERO, |x: u32, _: &Monitor| Ok(2 * x));
    doubling.submit(21);
    assert_eq!(wait_for(|| doubling.take_answers().next()).result, Ok(42));
    assert!(engine.wait_idle(PATIENCE));
}

#[test]
fn closing_cancels_what_runs_and_finishes_what_is_written() {
    let written = Arc::new(AtomicUsize::new(0));
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let endless = Jobs::new(engine.queue(), Priority::Search, Duration::ZERO, |(): (), monitor: &Monitor| {
        loop {
            monitor.check()?;
            std::thread::sleep(Duration::from_millis(1));
            if false {
                return Ok(());
            }
        }
    });
    endless.submit(());
    for _ in 0..20 {
        let written = written.clone();
        engine.task("Write", move || {
            std::thread::sleep(Duration::from_millis(5));
            written.fetch_add(1, Ordering::SeqCst);
            Ok(String::new())
        });
    }
    drop((engine, endless));
    assert_eq!(written.load(Ordering::SeqCst), 20, "all files are whole when the window is gone");
}

#[test]
fn a_panic_becomes_a_message_with_its_place_and_the_queue_works_on() {
    let jobs = Jobs::new(&queue(), Priority::Search, Duration::ZERO, |request: u32, _: &Monitor| {
        use rayon::prelude::*;
        // Deep inside a parallel loop, where the panic happens on another thread than the queue's.
        let sum: u32 =
            (0..1000u32).into_par_iter().map(|i| if i == request { panic!("no {request}") } else { 1 }).sum();
        Ok(sum)
    });
    jobs.submit(7);
    match wait_for(|| jobs.take_answers().next()).result {
        Err(JobError::Panicked { message, place }) => {
            assert_eq!(message, "no 7");
            assert!(place.contains("tests.rs:"), "{place}");
        }
        other => panic!("expected a panic's message, got {other:?}"),
    }
    jobs.submit(5000);
    assert_eq!(wait_for(|| jobs.take_answers().next()).result, Ok(1000));
}

#[test]
fn an_answer_is_published_before_the_listener_hears_of_it() {
    let heard = Arc::new(AtomicUsize::new(0));
    let jobs: Arc<Mutex<Option<Jobs<u32, u32>>>> = Arc::default();
    let (count, its) = (heard.clone(), jobs.clone());
    let on_update: OnUpdate = Arc::new(move || {
        if let Some(jobs) = &*its.lock().expect("not poisoned")
            && jobs.take_answers().next().is_some()
        {
            count.fetch_add(1, Ordering::SeqCst);
        }
    });
    let queue = Arc::new(JobQueue::new(on_update));
    let work = |request: u32, _: &Monitor| Ok(request);
    *jobs.lock().expect("not poisoned") = Some(Jobs::new(&queue, Priority::Search, Duration::ZERO, work));
    jobs.lock().expect("not poisoned").as_ref().expect("just put there").submit(3);
    wait_for(|| (heard.load(Ordering::SeqCst) == 1).then_some(()));
    jobs.lock().expect("not poisoned").take();
}

#[test]
fn progress_can_be_read_while_it_runs() {
    let work = |(): (), monitor: &Monitor| -> Result<(), JobError> {
        monitor.report(Stage::Search { octave: 2 }, 0.25);
        loop {
            monitor.check()?;
            std::thread::sleep(Duration::from_millis(1));
        }
    };
    let jobs = Jobs::new(&queue(), Priority::Search, Duration::ZERO, work);
    jobs.submit(());
    let progress = wait_for(|| jobs.running().and_then(|r| r.progress));
    assert_eq!((progress.stage, progress.fraction), (Stage::Search { octave: 2 }, 0.25));
    jobs.cancel();
}

fn small_burst() -> OpenBurst {
    let frame = |t: usize| Plane::from_fn(40, 32, |u, v| ((u * 7 + v * 3 + t) % 11) as f32 / 11.0);
    OpenBurst::new(Burst::from_planes("test", (0..3).map(frame).collect()), BurstSource::Demo)
}

fn stack_request(burst: &OpenBurst, slope_u: f32) -> PictureRequest {
    let kind = PictureKind::Stack { slope: Slope::new(slope_u, 0.0) };
    PictureRequest::new(burst.clone(), kind, DetectorParams::default())
}

#[test]
fn the_cache_keeps_its_budget_and_drops_the_least_recently_used() {
    let burst = small_burst();
    let one = 40 * 32 * 4;
    let mut cache = PictureCache::new(3 * one);
    let requests: Vec<_> = (0..4).map(|i| stack_request(&burst, i as f32)).collect();
    let monitor = Monitor::default();
    for request in &requests[..3] {
        cache.insert(&request.compute(&monitor).expect("not cancelled"));
    }
    assert_eq!(cache.bytes(), 3 * one);
    assert!(cache.get(&requests[0]).is_some());
    cache.insert(&requests[3].compute(&monitor).expect("not cancelled"));
    assert_eq!((cache.len(), cache.bytes()), (3, 3 * one));
    assert!(cache.get(&requests[1]).is_none(), "the one not used for longest went");
    assert!(cache.get(&requests[0]).is_some() && cache.get(&requests[3]).is_some());
    let mut tiny = PictureCache::new(one - 1);
    tiny.insert(&requests[0].compute(&monitor).expect("not cancelled"));
    assert!(tiny.is_empty());
}

#[test]
fn only_what_decides_a_picture_makes_it_another() {
    let burst = small_burst();
    let request = stack_request(&burst, 1.0);
    let mut other = request.clone();
    other.params.peak_threshold = 0.5;
    other.params.levels = 5;
    assert!(request.same_picture(&other));
    other.params.frames = Some(crate::detector::FrameRange { start: 0, end: 2 });
    assert!(!request.same_picture(&other));
    let reopened = PictureRequest::new(small_burst(), request.kind, request.params.clone());
    assert!(!request.same_picture(&reopened), "another opening may have other pixels");
}

#[test]
fn a_picture_asked_for_again_comes_from_the_cache() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let burst = small_burst();
    let picture = |engine: &Engine| {
        wait_for(|| {
            engine.poll().into_iter().find_map(|u| match u {
                Update::Picture(PictureSlot(3), answer) => Some(answer),
                _ => None,
            })
        })
    };
    engine.request_picture(PictureSlot(3), stack_request(&burst, 0.5));
    let first = picture(&engine).result.expect("valid");
    engine.request_picture(PictureSlot(3), stack_request(&burst, 0.5));
    let second = picture(&engine);
    assert_eq!(second.elapsed, Duration::ZERO);
    assert!(Arc::ptr_eq(&first.plane, &second.result.expect("valid").plane));
    assert!(engine.wait_idle(PATIENCE));
}

#[test]
fn a_difference_is_one_picture_less_the_other_on_the_pixels_of_the_first() {
    let (burst, monitor) = (small_burst(), Monitor::default());
    let (a, b) = (stack_request(&burst, 0.5), stack_request(&burst, -1.0));
    let wanted = a.clone().less(&b);
    assert!(!wanted.same_picture(&a) && !wanted.same_picture(&b.clone().less(&a)));
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    engine.request_picture(PictureSlot(9), wanted.clone());
    let answer = wait_for(|| {
        engine.poll().into_iter().find_map(|u| match u {
            Update::Picture(PictureSlot(9), answer) => Some(answer.result.expect("valid")),
            _ => None,
        })
    });
    assert!(answer.request.same_picture(&wanted));
    let planes = [&a, &b].map(|request| request.compute(&monitor).expect("not cancelled").plane);
    for (i, value) in answer.plane.data().iter().enumerate() {
        assert_eq!(*value, planes[0].data()[i] - planes[1].data()[i]);
    }
    // Half the pixels: the first picture's, whichever it is.
    let dog = PictureKind::Dog { octave: 1, level: 0, slope: Slope::new(0.5, 0.0) };
    let coarse = PictureRequest::new(burst, dog, DetectorParams::default());
    let size = coarse.compute(&monitor).expect("not cancelled").plane.size();
    assert_eq!(coarse.less(&a).compute(&monitor).expect("not cancelled").plane.size(), size);
}

#[test]
fn the_merged_frames_are_those_of_the_baseline() {
    let burst = small_burst();
    let request = PictureRequest::new(burst.clone(), PictureKind::Merge, DetectorParams::default());
    let merged = crate::baseline::merge_burst(&burst.burst, 0..3, &Monitor::default()).expect("merged");
    assert_eq!(request.compute(&Monitor::default()).expect("merged").plane, merged.frames[0]);
}

#[test]
fn a_missing_file_is_a_message_that_names_it() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    engine.open(BurstSource::Paths(vec!["/no/such/folder-of-frames".into()]));
    let answer = wait_for(|| {
        engine.poll().into_iter().find_map(|u| match u {
            Update::Opened(answer) => Some(answer),
            _ => None,
        })
    });
    match answer.result {
        Err(JobError::Failed(message)) => assert!(message.contains("folder-of-frames"), "{message}"),
        other => panic!("expected a message, got {other:?}"),
    }
}

#[test]
fn a_detection_can_be_cancelled_while_pictures_go_on() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let frame = |t: usize| Plane::from_fn(512, 384, |u, v| ((u * 7919 + v * 104_729 + t * 31) % 997) as f32 / 997.0);
    let burst = OpenBurst::new(Burst::from_planes("large", (0..9).map(frame).collect()), BurstSource::Demo);
    let slopes = crate::detector::SlopeGrid::plane(-3.0..=3.0, 9, -3.0..=3.0, 9);
    let params = DetectorParams { slopes, ..DetectorParams::default() };
    engine.detect(DetectRequest { burst: burst.clone(), params: params.into() });
    wait_for(|| engine.running(BurstJobs::Detect));
    engine.request_picture(PictureSlot(3), stack_request(&burst, 0.25));
    wait_for(|| engine.poll().into_iter().find(|u| matches!(u, Update::Picture(_, a) if a.result.is_ok())));
    engine.cancel(BurstJobs::Detect);
    let answer = wait_for(|| {
        engine.poll().into_iter().find_map(|u| match u {
            Update::Detected(answer) => Some(answer),
            _ => None,
        })
    });
    assert!(matches!(answer.result, Err(JobError::Cancelled)), "{:?}", answer.result.map(|d| d.detection.times));
}

#[test]
fn a_task_says_what_it_did_or_why_not() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    engine.task("Good", || Ok("written".into()));
    engine.task("Bad", || Err("disk full".into()));
    engine.task("Ugly", || panic!("oh"));
    assert!(engine.wait_idle(PATIENCE));
    let mut done: Vec<TaskDone> = engine
        .poll()
        .into_iter()
        .filter_map(|u| match u {
            Update::Task(done) => Some(done),
            _ => None,
        })
        .collect();
    done.sort_by(|a, b| a.label.cmp(&b.label));
    assert_eq!(done[0].result, Err(JobError::Failed("disk full".into())));
    assert_eq!(done[1].result, Ok("written".into()));
    assert!(matches!(&done[2].result, Err(JobError::Panicked { message, .. }) if message == "oh"));
}

/// A detection of `count` features with descriptors that are all different.
fn detection(count: usize, moved: f32) -> Arc<Detection> {
    let slopes = crate::detector::SlopeGrid::line(-1.0..=1.0, 3);
    let feature = |i: usize| crate::detector::Feature {
        u: (37 * i % 101) as f32 + moved,
        v: (53 * i % 89) as f32,
        sigma: 2.0,
        orientation: 0.0,
        slope: slopes.slope(1),
        response: 0.1,
        snr: 9.0,
        octave: 0,
        level: 0,
        slope_index: 1,
        at_slope_limit: false,
    };
    let mut descriptors = vec![[0u8; 128]; count];
    for (i, descriptor) in descriptors.iter_mut().enumerate() {
        for (j, element) in descriptor.iter_mut().enumerate() {
            *element = ((i * 7919 + j * 104_729) % 251) as u8;
        }
    }
    Arc::new(Detection {
        features: (0..count).map(feature).collect(),
        descriptors,
        tally: Default::default(),
        frame_noise: 0.01,
        noise: std::sync::Arc::default(),
        noise_gate_factor: 4.5,
        slopes,
        frames_used: 0..3,
        octaves: 0..1,
        times: Default::default(),
    })
}

fn pair_update<T>(engine: &Engine, pick: impl Fn(PairUpdate) -> Option<T>) -> T {
    wait_for(|| engine.pair().poll().into_iter().find_map(&pick))
}

#[test]
fn matches_are_those_of_the_matching_room() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let request = MatchRequest { a: detection(40, 0.0), b: detection(40, 3.0), params: Default::default() };
    engine.pair().match_features(request.clone());
    let matched = pair_update(&engine, |u| match u {
        PairUpdate::Matched(answer) => Some(answer.result.expect("valid")),
        _ => None,
    });
    let expected = crate::matching::match_detections(&request.a, &request.b, &request.params, &Monitor::default());
    assert_eq!(Ok(&*matched.result), expected.as_ref());
    assert!(matched.request.same_matches(&request));
    assert_eq!(matched.result.matches.len(), 40);
    assert!(!matched.request.same_matches(&MatchRequest { a: detection(40, 0.0), ..request }));
}

#[test]
fn a_long_matching_can_be_cancelled() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let request = MatchRequest { a: detection(60_000, 0.0), b: detection(60_000, 3.0), params: Default::default() };
    engine.pair().match_features(request);
    wait_for(|| engine.pair().running(PairJobs::Match).filter(|r| r.started.elapsed() > Duration::from_millis(20)));
    let cancelled = Instant::now();
    engine.pair().cancel(PairJobs::Match);
    let result = pair_update(&engine, |u| match u {
        PairUpdate::Matched(answer) => Some(answer.result),
        _ => None,
    });
    assert!(matches!(result, Err(JobError::Cancelled)), "{:?}", result.map(|m| m.result.counts));
    assert!(cancelled.elapsed() < Duration::from_secs(2), "{:?}", cancelled.elapsed());
}

#[test]
fn patches_come_together_and_from_the_cache() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let (a, b) = (small_burst(), small_burst());
    let request = PatchesRequest { a: stack_request(&a, 0.5), b: stack_request(&b, -0.5) };
    let patches = |engine: &Engine| {
        engine.pair().request_patches(request.clone());
        pair_update(engine, |u| match u {
            PairUpdate::Patches(answer) => Some(answer.result.expect("valid")),
            _ => None,
        })
    };
    let (first, second) = (patches(&engine), patches(&engine));
    assert!(Arc::ptr_eq(&first.a.plane, &second.a.plane) && Arc::ptr_eq(&first.b.plane, &second.b.plane));
    assert_eq!((first.a.request.burst.id, first.b.request.burst.id), (a.id, b.id));
    assert!(engine.wait_idle(PATIENCE));
}

#[test]
fn the_second_burst_is_opened_and_searched_beside_the_first() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    engine.pair().open(BurstSource::DemoLater);
    let burst = pair_update(&engine, |u| match u {
        PairUpdate::Opened(answer) => Some(answer.result.expect("built in")),
        _ => None,
    });
    assert_eq!(burst.burst.name, "demo-later");
    engine.pair().detect(DetectRequest { burst: burst.clone(), params: DetectorParams::default().into() });
    let detected = pair_update(&engine, |u| match u {
        PairUpdate::Detected(answer) => Some(answer.result.expect("valid")),
        _ => None,
    });
    let expected =
        crate::detector::detect(&burst.burst, &DetectorParams::default(), &Monitor::default()).expect("valid");
    assert_eq!(detected.detection.features, expected.features);
}
