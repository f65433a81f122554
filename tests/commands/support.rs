//! Running the program.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program with `arguments`, in the folder `home`, without a display.
pub fn program(home: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_burstscope"));
    command.current_dir(home).args(arguments);
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    command
}

/// Runs it to its end.
pub fn run(home: &Path, arguments: &[&str]) -> Output {
    program(home, arguments).output().expect("the program starts")
}

/// Runs it and expects exit code 0; answers the standard output.
pub fn run_well(home: &Path, arguments: &[&str]) -> String {
    let output = run(home, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
    String::from_utf8(output.stdout).expect("text")
}

/// Runs it and expects exit code `code`; answers the standard error.
pub fn run_badly(home: &Path, arguments: &[&str], code: i32) -> String {
    let output = run(home, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
    stderr(&output)
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Names in a folder, sorted, hidden ones too.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// The folder of real data, if it is there; a printed line if not.
pub fn shared_data() -> Option<PathBuf> {
    crate::shared::shared("data")
}

/// The lines of a CSV file of features as numbers, without the header.
pub fn features(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("a file");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("u,v,sigma,orientation,slope_u,slope_v,response,snr,octave,level,at_slope_limit"));
    lines.map(|line| line.split(',').map(|x| x.parse().expect("a number")).collect()).collect()
}
