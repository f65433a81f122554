//! Pictures: which are the same, how they are made, and how many are kept.

use super::{PATIENCE, end_of, engine, small_burst, stack_request};
use crate::engine::{PictureCache, Wanted};
use crate::monitor::Monitor;
use crate::requests::{Request, Work};
use std::sync::Arc;
use std::time::Duration;

#[test]
fn the_cache_keeps_its_budget_and_drops_the_least_recently_used() {
    let burst = small_burst();
    let one = 40 * 32 * 4;
    let mut cache = PictureCache::new(3 * one);
    let requests: Vec<_> = (0..4).map(|i| stack_request(&burst, i as f32)).collect();
    let monitor = Monitor::default();
    for request in &requests[..3] {
        cache.insert(&request.clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    }
    assert_eq!(cache.bytes(), 3 * one);
    assert!(cache.get(&requests[0]).is_some());
    cache.insert(&requests[3].clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    assert_eq!((cache.len(), cache.bytes()), (3, 3 * one));
    assert!(cache.get(&requests[1]).is_none(), "the one not used for longest went");
    assert!(cache.get(&requests[0]).is_some() && cache.get(&requests[3]).is_some());
    cache.set_budget(one);
    assert!(cache.bytes() == one && cache.get(&requests[3]).is_some(), "a smaller budget holds at once");
    let mut tiny = PictureCache::new(one - 1);
    tiny.insert(&requests[0].clone().compute(&Work::alone(&monitor)).expect("not cancelled"));
    assert!(tiny.is_empty());
}

#[test]
fn a_picture_asked_for_again_comes_from_the_cache() {
    let (engine, burst, mut wanted) = (engine(), small_burst(), Wanted::default());
    wanted.ask(&engine, stack_request(&burst, 0.5));
    let first = end_of(&mut wanted).result.expect("valid");
    // Whoever asks for it.
    let mut other = Wanted::default();
    other.ask(&engine, stack_request(&burst, 0.5));
    let second = end_of(&mut other);
    assert_eq!(second.elapsed, Duration::ZERO);
    assert!(Arc::ptr_eq(&first.plane, &second.result.expect("valid").plane));
    assert!(engine.wait_idle(PATIENCE));
}
