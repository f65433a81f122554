//! Tests of `monitor`.

use burstscope_core::monitor::*;
use std::sync::Arc;

#[test]
fn clones_and_silent_monitors_share_the_cancel_flag() {
    let monitor = Monitor::with_listener(|_| panic!("nobody is to hear of this"));
    let silent = monitor.clone().silent();
    silent.report(Stage::Evaluate, 0.5);
    assert_eq!(monitor.check(), Ok(()));
    silent.cancel();
    assert_eq!(monitor.check(), Err(Cancelled));
}

#[test]
fn a_part_tells_its_progress_as_a_part_of_the_whole() {
    let heard = Arc::new(std::sync::Mutex::new(Vec::new()));
    let sink = heard.clone();
    let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
    let second_of_four = monitor.part(0.25, 0.25);
    second_of_four.report(Stage::Noise, 0.0);
    second_of_four.part(0.5, 0.5).report(Stage::Noise, 1.5);
    second_of_four.cancel();
    assert!(monitor.is_cancelled());
    assert_eq!(*heard.lock().expect("not poisoned"), [0.25, 0.5]);
}
