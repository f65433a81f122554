//! Where the real input and the published implementations' answers are, if they are here at all.
//!
//! They are beside the checkout, in `../shared`, or where `BURSTSCOPE_SHARED` says. A test without its input prints
//! that it was skipped; with `BURSTSCOPE_REQUIRE_SHARED=1` it fails instead, so that none vanishes where all should
//! run.

use std::path::PathBuf;

/// The path `relative` below the folder of real input, or `None` (with a printed line) where it is absent.
///
/// # Panics
/// Where it is absent and must not be.
pub fn shared(relative: &str) -> Option<PathBuf> {
    let beside = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared"));
    let root = std::env::var_os("BURSTSCOPE_SHARED").map_or(beside, PathBuf::from);
    let path = root.join(relative);
    if path.exists() {
        return Some(path);
    }
    let required = std::env::var_os("BURSTSCOPE_REQUIRE_SHARED").is_some_and(|value| value != "0" && !value.is_empty());
    let place = path.display();
    assert!(
        !required,
        "{place} is not on this machine, and BURSTSCOPE_REQUIRE_SHARED says that no test may be skipped"
    );
    println!("skipped: {place} is not on this machine (set BURSTSCOPE_SHARED to the folder that holds {relative})");
    None
}
