//! Tests of every kind of work: it reports progress, its panics become messages, and it ends with the engine.

use super::{engine, queue, until_cancelled, wait_for};
use crate::engine::jobs::Jobs;
use crate::engine::{JobQueue, OnUpdate, TaskDone};
use crate::monitor::{Monitor, Stage};
use crate::requests::{JobError, Urgency};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

#[test]
fn work_tells_on_the_way_and_what_was_superseded_tells_nothing_more() {
    let queue = queue();
    let work = |request: u32, tell: &(dyn Fn(u32) + Sync), monitor: &Monitor| {
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
    let jobs: Jobs<u32, u32, u32> = Jobs::telling(&queue, Urgency::Dataset, Duration::ZERO, work);
    jobs.submit_as(jobs.manner, 1);
    let mut told = Vec::new();
    wait_for(|| {
        told.extend(jobs.take_partial());
        (told == [10]).then_some(())
    });
    jobs.submit_as(jobs.manner, 2);
    let (mut told, mut answers) = (Vec::new(), Vec::new());
    wait_for(|| {
        answers.extend(jobs.take_answers());
        told.extend(jobs.take_partial());
        (answers.len() == 2).then_some(())
    });
    assert_eq!(told, [20, 21]);
    assert!(answers[0].result == Err(JobError::Superseded) && answers[1].result == Ok(2));
}

#[test]
fn closing_cancels_what_runs_and_finishes_what_is_written() {
    let written = Arc::new(AtomicUsize::new(0));
    let ends: Arc<Mutex<Option<Result<(), JobError>>>> = Arc::default();
    let engine = engine();
    let its = ends.clone();
    let endless = Jobs::new(&engine.queue, Urgency::Search, Duration::ZERO, move |(): (), monitor: &Monitor| {
        monitor.report(Stage::Noise, 0.0);
        let end = until_cancelled(monitor);
        *its.lock().expect("not poisoned") = Some(end.clone());
        end
    });
    endless.submit_as(endless.manner, ());
    wait_for(|| endless.running().and_then(|running| running.progress));
    for _ in 0..20 {
        let written = written.clone();
        engine.task("Write", move || {
            std::thread::sleep(Duration::from_millis(5));
            written.fetch_add(1, Ordering::SeqCst);
            Ok(String::new())
        });
    }
    drop((engine, endless));
    assert_eq!(*ends.lock().expect("not poisoned"), Some(Err(JobError::Cancelled)));
    assert_eq!(written.load(Ordering::SeqCst), 20, "all files are whole when the window is gone");
}

#[test]
fn a_panic_becomes_a_message_with_its_place_and_the_queue_works_on() {
    let jobs = Jobs::new(&queue(), Urgency::Search, Duration::ZERO, |request: u32, _: &Monitor| {
        use rayon::prelude::*;
        // Deep inside a parallel loop, where the panic happens on another thread than the queue's.
        let sum: u32 =
            (0..1000u32).into_par_iter().map(|i| if i == request { panic!("no {request}") } else { 1 }).sum();
        Ok(sum)
    });
    jobs.submit_as(jobs.manner, 7);
    match wait_for(|| jobs.take_answers().pop()).result {
        Err(JobError::Panicked { message, place }) => {
            assert_eq!(message, "no 7");
            assert!(place.contains("work.rs:"), "{place}");
        }
        other => panic!("expected a panic's message, got {other:?}"),
    }
    jobs.submit_as(jobs.manner, 5000);
    assert_eq!(wait_for(|| jobs.take_answers().pop()).result, Ok(1000));
}

#[test]
fn an_answer_is_published_before_the_listener_hears_of_it() {
    let heard = Arc::new(AtomicUsize::new(0));
    let jobs: Arc<Mutex<Option<Jobs<u32, u32>>>> = Arc::default();
    let (count, its) = (heard.clone(), jobs.clone());
    let on_update: OnUpdate = Arc::new(move || {
        if let Some(jobs) = &*its.lock().expect("not poisoned")
            && !jobs.take_answers().is_empty()
        {
            count.fetch_add(1, Ordering::SeqCst);
        }
    });
    let queue = Arc::new(JobQueue::new(on_update));
    let work = |request: u32, _: &Monitor| Ok(request);
    *jobs.lock().expect("not poisoned") = Some(Jobs::new(&queue, Urgency::Search, Duration::ZERO, work));
    let submitted = jobs.lock().expect("not poisoned").as_ref().map(|jobs| jobs.submit_as(jobs.manner, 3));
    assert!(submitted.is_some(), "they were just put there");
    wait_for(|| (heard.load(Ordering::SeqCst) == 1).then_some(()));
    jobs.lock().expect("not poisoned").take();
}

#[test]
fn a_task_says_what_it_did_or_why_not() {
    let engine = engine();
    engine.task("Good", || Ok("written".into()));
    engine.task("Bad", || Err("disk full".into()));
    engine.task("Ugly", || panic!("oh"));
    wait_for(|| engine.is_idle().then_some(()));
    let mut done: Vec<TaskDone> = engine.take_tasks();
    done.sort_by(|a, b| a.label.cmp(&b.label));
    assert_eq!(done[0].result, Err(JobError::Failed("disk full".into())));
    assert_eq!(done[1].result, Ok("written".into()));
    assert!(matches!(&done[2].result, Err(JobError::Panicked { message, .. }) if message == "oh"));
}
