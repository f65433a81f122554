//! Tests of the queue: the latest request of a kind wins, each has one answer, urgent work goes first.

use super::{queue, until_cancelled, wait_for};
use crate::engine::JobQueue;
use crate::engine::jobs::Jobs;
use crate::engine::queue::THREADS;
use crate::monitor::Monitor;
use crate::requests::{JobError, JobId, Urgency};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

/// Jobs that run until cancelled; a message ends one job.
fn stubborn_jobs(queue: &Arc<JobQueue>, grace: Duration) -> (Jobs<u32, u32>, mpsc::Sender<()>) {
    let (go, gone) = mpsc::channel();
    let gone = Mutex::new(gone);
    let work = move |request: u32, monitor: &Monitor| {
        while gone.lock().expect("not poisoned").try_recv().is_err() {
            monitor.check()?;
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(request)
    };
    (Jobs::new(queue, Urgency::Search, grace, work), go)
}

fn answers_of(jobs: &Jobs<u32, u32>, count: usize) -> Vec<(JobId, Result<u32, JobError>)> {
    let mut taken = Vec::new();
    wait_for(|| {
        taken.extend(jobs.take_answers().into_iter().map(|answer| (answer.id, answer.result)));
        (taken.len() >= count).then_some(())
    });
    assert_eq!(taken.len(), count, "{taken:?}");
    taken
}

#[test]
fn the_latest_request_wins_and_every_request_has_one_answer() {
    let (jobs, go) = stubborn_jobs(&queue(), Duration::ZERO);
    let ids: Vec<JobId> = (0..50).map(|i| jobs.submit_as(jobs.manner, i)).collect();
    wait_for(|| jobs.running().filter(|r| r.id == ids[49]));
    go.send(()).expect("the work listens");
    let mut answers = answers_of(&jobs, 50);
    wait_for(|| jobs.running().is_none().then_some(()));
    answers.sort_by_key(|(id, _)| *id);
    assert!(answers.iter().map(|(id, _)| *id).eq(ids), "each once");
    assert_eq!(answers.pop().map(|(_, result)| result), Some(Ok(49)));
    assert!(answers.iter().all(|(_, result)| *result == Err(JobError::Superseded)), "{answers:?}");
    assert!(jobs.take_answers().is_empty());
}

#[test]
fn within_its_grace_a_superseded_request_is_still_answered() {
    let (jobs, go) = stubborn_jobs(&queue(), Duration::from_secs(60));
    let first = jobs.submit_as(jobs.manner, 1);
    // One that has a progress or a time of its own runs; one that waits has begun just now.
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let second = jobs.submit_as(jobs.manner, 2);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(first, Ok(1))]);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(second, Ok(2))]);
}

#[test]
fn after_its_grace_a_superseded_request_is_cancelled() {
    let queue = queue();
    let (jobs, go) = stubborn_jobs(&queue, Duration::from_millis(30));
    let first = jobs.submit_as(jobs.manner, 1);
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let second = jobs.submit_as(jobs.manner, 2);
    wait_for(|| {
        queue.enforce_grace();
        jobs.running().filter(|r| r.id == second)
    });
    assert_eq!(answers_of(&jobs, 1), [(first, Err(JobError::Superseded))]);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(second, Ok(2))]);
}

#[test]
fn what_is_there_already_comes_at_once_and_the_older_one_never() {
    let (jobs, _go) = stubborn_jobs(&queue(), Duration::from_secs(60));
    let old = jobs.submit_as(jobs.manner, 1);
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let new = jobs.publish(5);
    assert_eq!(answers_of(&jobs, 2), [(new, Ok(5)), (old, Err(JobError::Superseded))]);
}

/// All threads for searches and datasets do work that ends only when it is cancelled, each of another kind: one runs.
struct BusyQueue {
    queue: Arc<JobQueue>,
    going: mpsc::Sender<&'static str>,
    begun: mpsc::Receiver<&'static str>,
    datasets: Vec<Jobs<(), ()>>,
    searches: Vec<Jobs<(), ()>>,
}

impl BusyQueue {
    fn new() -> Self {
        let (going, begun) = mpsc::channel();
        let mut busy = Self { queue: queue(), going, begun, datasets: Vec::new(), searches: Vec::new() };
        let threads = |limit| THREADS.into_iter().filter(|of| *of == limit).count();
        // Datasets first: their threads take searches too.
        busy.datasets = busy.begin(Urgency::Dataset, threads(Urgency::Dataset));
        busy.searches = busy.begin(Urgency::Search, threads(Urgency::Search));
        assert!(busy.datasets.len() > 1 && busy.searches.len() > 1);
        busy
    }

    fn begin(&self, priority: Urgency, count: usize) -> Vec<Jobs<(), ()>> {
        let kinds: Vec<_> = (0..count).map(|_| self.endless(priority, "busy")).collect();
        kinds.iter().for_each(|_| assert_eq!(self.next_begun(), "busy"));
        kinds
    }

    fn endless(&self, priority: Urgency, name: &'static str) -> Jobs<(), ()> {
        let going = Mutex::new(self.going.clone());
        let jobs = Jobs::new(&self.queue, priority, Duration::ZERO, move |(): (), monitor: &Monitor| {
            going.lock().expect("not poisoned").send(name).expect("the test listens");
            until_cancelled(monitor)
        });
        jobs.submit_as(jobs.manner, ());
        jobs
    }

    fn next_begun(&self) -> &'static str {
        wait_for(|| self.begun.try_recv().ok())
    }
}

#[test]
fn a_picture_is_made_while_searches_and_datasets_keep_all_their_threads_busy() {
    let busy = BusyQueue::new();
    let more = busy.endless(Urgency::Search, "more");
    let pictures = Jobs::new(&busy.queue, Urgency::Picture, Duration::ZERO, |request: u32, _: &Monitor| Ok(request));
    pictures.submit_as(pictures.manner, 3);
    assert_eq!(wait_for(|| pictures.take_answers().pop()).result, Ok(3));
    assert!(busy.begun.try_recv().is_err(), "no thread was left for one more search");
    for jobs in busy.datasets.iter().chain(&busy.searches).chain([&more]) {
        assert!(jobs.running().is_some() && jobs.take_answers().is_empty(), "nothing had to end for it");
    }
}

#[test]
fn a_search_goes_before_a_dataset_that_was_asked_for_earlier() {
    let busy = BusyQueue::new();
    let _later = busy.endless(Urgency::Dataset, "dataset");
    let search = busy.endless(Urgency::Search, "search");
    // A thread that takes both.
    busy.datasets[0].cancel();
    assert_eq!(busy.next_begun(), "search");
    search.cancel();
    assert_eq!(busy.next_begun(), "dataset");
}

#[test]
fn cancelling_answers_cancelled_also_what_waits_behind_a_superseded_one() {
    let (jobs, go) = stubborn_jobs(&queue(), Duration::from_secs(60));
    let first = jobs.submit_as(jobs.manner, 1);
    wait_for(|| jobs.running().filter(|r| r.started.elapsed() > Duration::from_millis(1)));
    let second = jobs.submit_as(jobs.manner, 2);
    jobs.cancel();
    let mut answers = answers_of(&jobs, 2);
    answers.sort_by_key(|(id, _)| *id);
    assert_eq!(answers, [(first, Err(JobError::Superseded)), (second, Err(JobError::Cancelled))]);
    let next = jobs.submit_as(jobs.manner, 3);
    go.send(()).expect("the work listens");
    assert_eq!(answers_of(&jobs, 1), [(next, Ok(3))]);
}
