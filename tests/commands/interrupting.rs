//! Ctrl-C: exit code 130, and nothing half-written.
#![cfg(unix)]

use super::support::{at_work, ended, names, program, run_well};
use std::path::Path;
use std::process::{Command, Stdio};

/// Starts a command whose work takes many minutes, interrupts it while it is at work, and returns its exit code.
fn interrupt(home: &Path, arguments: &[&str]) -> Option<i32> {
    let mut child =
        program(home, arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    at_work(&child);
    assert!(child.try_wait().expect("a state").is_none(), "{arguments:?} ended before it could be interrupted");
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(killed.success());
    ended(child).status.code()
}

#[test]
fn making_a_large_burst_stops_and_leaves_nothing() {
    let home = tempfile::tempdir().expect("a folder");
    let arguments =
        ["synth", "chart", "--out", "big", "--width", "3000", "--height", "2000", "--frames", "400", "--threads", "1"];
    assert_eq!(interrupt(home.path(), &arguments), Some(130));
    assert_eq!(names(home.path()), Vec::<String>::new());
}

#[test]
fn a_long_search_stops_and_leaves_nothing() {
    let home = tempfile::tempdir().expect("a folder");
    run_well(home.path(), &["synth", "chart", "--out", "chart", "--frames", "8", "--quiet"]);
    let arguments = [
        "detect",
        "chart",
        "--slopes-u",
        "-3:3:61",
        "--slopes-v",
        "-3:3:61",
        "--first-octave",
        "-1",
        "--threads",
        "1",
        "--out",
        "found",
    ];
    assert_eq!(interrupt(home.path(), &arguments), Some(130));
    assert_eq!(names(home.path()), ["chart"]);
}

#[test]
fn a_study_stops_and_leaves_no_figure() {
    let home = tempfile::tempdir().expect("a folder");
    let arguments =
        ["evaluate", "chart", "--motion", "2d", "--seeds", "500", "--threads", "1", "--plot", "roc.svg", "--json"];
    assert_eq!(interrupt(home.path(), &arguments), Some(130));
    assert_eq!(names(home.path()), Vec::<String>::new());
}

#[test]
fn figures_stop_and_leave_none_half_made() {
    let home = tempfile::tempdir().expect("a folder");
    let arguments = ["figures", "--out", "paper", "--only", "fig5", "--no-colmap", "--threads", "1"];
    assert_eq!(interrupt(home.path(), &arguments), Some(130));
    let left = names(&home.path().join("paper"));
    assert!(left.iter().all(|name| name == "records" || name.starts_with('.')), "{left:?}");
}
