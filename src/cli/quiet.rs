//! Drawing without a display, without the messages of libraries about the missing display.
//!
//! Mesa's Vulkan driver asks a Wayland display which graphics adapter is the first one, whenever it lists them. Where
//! there is none, and no folder in which it could be, Wayland's library writes "XDG_RUNTIME_DIR is invalid" each time
//! to the standard error. An environment variable, which is read when the driver is loaded, turns this question off.

use super::commands::{Cli, Command};
use super::window;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command as Program;

/// Variable that turns off Mesa's choice of the first adapter.
const NO_CHOICE: &str = "NODEVICE_SELECT";
/// Variables by which the user has chosen an adapter, or none.
const CHOICES: [&str; 3] = [NO_CHOICE, "MESA_VK_DEVICE_SELECT", "DRI_PRIME"];

/// Starts this program anew, in this process, if `cli` draws a window and there is no folder of displays.
pub(super) fn without_display(cli: &Cli) {
    let draws = match &cli.command {
        None => !window::has_display(),
        Some(command) => matches!(command, Command::Render(_)),
    };
    let has_folder = std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    let chooses = CHOICES.into_iter().any(|name| std::env::var_os(name).is_some());
    if draws
        && !has_folder
        && !chooses
        && let Ok(program) = std::env::current_exe()
    {
        let mut arguments = std::env::args_os();
        let name = arguments.next().unwrap_or_default();
        // Only returns where it fails: then the messages come.
        let _ = Program::new(program).arg0(name).args(arguments).env(NO_CHOICE, "1").exec();
    }
}
