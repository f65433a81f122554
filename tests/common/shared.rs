//! Where the real input and the published implementations' answers are, if they are here at all.

use std::path::PathBuf;

/// The path `relative` below the folder of real input, or `None` (with a printed line) where it is absent.
pub fn shared(relative: &str) -> Option<PathBuf> {
    let beside = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared"));
    let root = std::env::var_os("BURSTSCOPE_SHARED").map_or(beside, PathBuf::from);
    let path = root.join(relative);
    if path.exists() {
        Some(path)
    } else {
        println!("skipped: {relative} is not on this machine (set BURSTSCOPE_SHARED to the folder that holds it)");
        None
    }
}
