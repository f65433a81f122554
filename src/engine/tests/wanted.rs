//! Tests of `Wanted`: which requests are submitted, which are not repeated, and how requests end.

use super::{end_of, engine, wait_for};
use crate::engine::{Engine, Want, Wanted};
use crate::requests::{JobError, Request, Urgency, Work};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Request for half of a number; odd numbers fail, and 0 runs until it is cancelled.
#[derive(Debug, Clone)]
struct Half {
    of: u32,
    computed: Arc<AtomicU32>,
}

impl PartialEq for Half {
    fn eq(&self, other: &Self) -> bool {
        self.of == other.of
    }
}

impl Request for Half {
    type Answer = u32;
    type Partial = u32;

    fn compute(self, work: &Work<'_, u32>) -> Result<u32, JobError> {
        (work.tell)(self.of);
        self.computed.fetch_add(1, Ordering::SeqCst);
        if self.of == 0 {
            super::until_cancelled(work.monitor)?;
        }
        if self.of % 2 == 1 { Err(JobError::Failed(format!("{} is odd", self.of))) } else { Ok(self.of / 2) }
    }
}

struct Halves {
    engine: Engine,
    wanted: Wanted<Half>,
    computed: Arc<AtomicU32>,
}

impl Halves {
    fn new() -> Self {
        Self { engine: engine(), wanted: Wanted::default(), computed: Arc::default() }
    }

    fn of(&self, of: u32) -> Option<Half> {
        Some(Half { of, computed: self.computed.clone() })
    }

    fn want(&mut self, of: u32) {
        let wanted = self.of(of);
        self.wanted.want(&self.engine, wanted);
    }

    fn computed(&self) -> u32 {
        self.computed.load(Ordering::SeqCst)
    }
}

#[test]
fn a_request_runs_once_however_often_it_is_wanted_and_again_if_its_answer_is_still_missing() {
    let mut halves = Halves::new();
    assert!(halves.wanted.is_settled() && halves.wanted.running.is_none());
    for _ in 0..5 {
        halves.want(8);
    }
    assert!(!halves.wanted.is_settled() && halves.wanted.pending().is_some_and(|pending| pending.of == 8));
    let ended = end_of(&mut halves.wanted);
    assert_eq!((ended.request.of, ended.result, halves.computed()), (8, Ok(4), 1));
    assert!(halves.wanted.is_settled() && halves.wanted.take().is_empty());
    assert_eq!(halves.wanted.take_partial(), [8]);
    // The answer is still missing.
    halves.want(8);
    assert_eq!((end_of(&mut halves.wanted).result, halves.computed()), (Ok(4), 2));
}

#[test]
fn what_failed_is_not_repeated_until_something_else_was_wanted() {
    let mut halves = Halves::new();
    halves.want(7);
    assert_eq!(end_of(&mut halves.wanted).result, Err(JobError::Failed("7 is odd".to_owned())));
    let seven = halves.of(7).expect("a request");
    assert!(halves.wanted.has_failed(&seven) && halves.wanted.failure().is_some_and(|(half, _)| half.of == 7));
    halves.want(7);
    assert!(halves.wanted.is_settled() && halves.computed() == 1);
    halves.want(6);
    assert_eq!(end_of(&mut halves.wanted).result, Ok(3));
    assert!(halves.wanted.failure().is_none());
    halves.want(7);
    end_of(&mut halves.wanted);
    // Asked for, it is repeated in any case; forgotten, it may be wanted again.
    halves.wanted.ask(&halves.engine, seven);
    end_of(&mut halves.wanted);
    halves.wanted.forget();
    halves.want(7);
    end_of(&mut halves.wanted);
    assert_eq!(halves.computed(), 5);
}

#[test]
fn a_newer_request_supersedes_the_running_one_whose_end_is_not_told() {
    let mut halves = Halves::new();
    halves.want(0);
    wait_for(|| (halves.computed() == 1).then_some(()));
    halves.want(4);
    let ended = end_of(&mut halves.wanted);
    assert_eq!((ended.request.of, ended.result), (4, Ok(2)));
    assert!(halves.wanted.is_settled() && halves.wanted.take().is_empty());
}

#[test]
fn nothing_wanted_cancels_what_runs_and_cancelling_by_hand_is_an_end() {
    let mut halves = Halves::new();
    halves.want(0);
    halves.wanted.want(&halves.engine, None);
    assert!(halves.wanted.is_settled() && halves.wanted.failure().is_none());
    wait_for(|| halves.engine.is_idle().then_some(()));
    assert!(halves.wanted.take().is_empty());

    halves.want(0);
    assert_eq!(Want::urgency(&halves.wanted), Some(Urgency::Search));
    Want::cancel(&halves.wanted);
    assert_eq!(end_of(&mut halves.wanted).result, Err(JobError::Cancelled));
    halves.want(0);
    assert!(halves.wanted.is_settled(), "somebody did not want it");
}

#[test]
fn dropping_it_cancels_the_request() {
    let mut halves = Halves::new();
    halves.want(0);
    wait_for(|| (halves.computed() == 1).then_some(()));
    drop(halves.wanted);
    wait_for(|| halves.engine.is_idle().then_some(()));
}
