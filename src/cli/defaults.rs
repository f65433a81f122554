//! The user's own defaults: a parameter file that every command with options of the search reads before all others.

use std::path::PathBuf;

/// Variable that names the file; an empty one stands for none.
const VARIABLE: &str = "BURSTSCOPE_DEFAULTS";

/// Where the file is, unless the variable names another.
#[cfg(windows)]
pub(super) const PLACE: &str = r"%APPDATA%\burstscope\defaults.toml";
#[cfg(target_os = "macos")]
pub(super) const PLACE: &str = "~/Library/Application Support/burstscope/defaults.toml";
#[cfg(not(any(windows, target_os = "macos")))]
pub(super) const PLACE: &str = "~/.config/burstscope/defaults.toml (or below $XDG_CONFIG_HOME)";

/// The file that the variable names, or the one at its usual place, if there is one.
pub(super) fn defaults_file() -> Option<PathBuf> {
    // Results of unit tests do not depend on the files of whoever runs them.
    if cfg!(test) {
        return None;
    }
    match std::env::var_os(VARIABLE) {
        Some(named) => Some(PathBuf::from(named)).filter(|named| !named.as_os_str().is_empty()),
        None => usual_file().filter(|usual| usual.exists()),
    }
}

fn usual_file() -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|folder| folder.is_absolute());
    let below_home = |folder: &str| std::env::home_dir().map(|home| home.join(folder));
    let folder = if cfg!(windows) {
        variable("APPDATA")
    } else if cfg!(target_os = "macos") {
        below_home("Library/Application Support")
    } else {
        variable("XDG_CONFIG_HOME").or_else(|| below_home(".config"))
    };
    Some(folder?.join("burstscope").join("defaults.toml"))
}
