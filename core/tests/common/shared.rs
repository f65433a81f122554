//! Location of the real input and of the published implementations' results.
//!
//! They are in the folder that `BURSTSCOPE_SHARED` names, or else in `../shared` beside the checkout. A test that needs
//! one of them is marked with `#[needs::shared(…)]`, and is ignored where it is missing.

use std::path::{Path, PathBuf};

/// The path `relative` below the folder of real input.
///
/// # Panics
/// Where it is missing.
pub fn shared(relative: &str) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = package.ancestors().find(|folder| folder.join("Cargo.lock").exists()).unwrap_or(package);
    let root = std::env::var_os("BURSTSCOPE_SHARED").map_or_else(|| checkout.join("../shared"), PathBuf::from);
    let path = root.join(relative);
    assert!(path.exists(), "{} is missing; set BURSTSCOPE_SHARED to the folder that holds {relative}", path.display());
    path
}
