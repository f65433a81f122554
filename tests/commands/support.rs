//! Helpers that run the program.

// Names that most tests of the commands use.
pub use crate::shared::{Folder, folder, folder_with, names, says, shared};
pub use burstscope::burst::OpenOptions;
pub use burstscope::detector::{SearchParams, Slope};
pub use burstscope::matching::{MatchParams, PairSelection};
pub use burstscope::requests::{BurstSource, DetectRequest, JobError, OpenBurst, Request, Work};
pub use burstscope::synth::ChartParams;
pub use burstscope::{Burst, DetectorParams, Monitor, Plane, SlopeGrid};
pub use serde_json::Value;
pub use std::collections::{BTreeMap, BTreeSet};
pub use std::fs;
pub use std::path::{Path, PathBuf};
pub use std::process::{Command, Output, Stdio};
pub use std::sync::{Mutex, OnceLock};
pub use std::time::{Duration, Instant};

use std::{process::Child, sync::mpsc};

const GUARD: Duration = Duration::from_secs(120);

/// Words of a command line: a list, or a text that is split at its blanks.
pub trait Line {
    fn words(&self) -> Vec<&str>;
}

impl Line for str {
    fn words(&self) -> Vec<&str> {
        self.split_whitespace().collect()
    }
}

impl Line for String {
    fn words(&self) -> Vec<&str> {
        self.as_str().words()
    }
}

impl Line for [&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl<const N: usize> Line for [&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl Line for Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.clone()
    }
}

/// Folder with files that are written and read, in which the program runs.
pub trait Home {
    fn folder(&self) -> &Path;

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.folder().join(name), content).expect("written");
    }

    fn make_dir(&self, name: &str) {
        fs::create_dir_all(self.folder().join(name)).expect("made");
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.folder().join(name)).expect("a file of text")
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.text(name)).expect("JSON")
    }

    /// Command that runs the program in this folder, without a display and the user's defaults.
    fn program(&self, line: &(impl Line + ?Sized)) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_burstscope"));
        command.current_dir(self.folder()).args(line.words()).env("BURSTSCOPE_DEFAULTS", "");
        for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(name);
        }
        command
    }

    /// Starts the program; it is ended by [`ended`] or otherwise.
    fn start(&self, line: &(impl Line + ?Sized)) -> Child {
        self.program(line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts")
    }

    fn run(&self, line: &(impl Line + ?Sized)) -> Output {
        self.program(line).output().expect("the program starts")
    }

    /// Runs the program and expects exit code 0; returns the standard output.
    fn run_well(&self, line: &(impl Line + ?Sized)) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(0), "{:?}: {}", line.words(), stderr(&output));
        String::from_utf8(output.stdout).expect("text")
    }

    /// Runs the program and expects exit code 0; returns the document on the standard output.
    fn run_json(&self, line: &(impl Line + ?Sized)) -> Value {
        serde_json::from_str(&self.run_well(line)).expect("JSON")
    }

    /// Runs the program and expects exit code `code`; returns the standard error.
    fn run_badly(&self, line: &(impl Line + ?Sized), code: i32) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(code), "{:?}: {}", line.words(), stderr(&output));
        stderr(&output)
    }
}

impl Home for Path {
    fn folder(&self) -> &Path {
        self
    }
}

/// When the process did not end; it is killed then.
pub fn ended(running: Child) -> Output {
    let id = running.id().to_string();
    let (ending, end) = mpsc::channel();
    std::thread::spawn(move || ending.send(running.wait_with_output()));
    let Ok(output) = end.recv_timeout(GUARD) else {
        let killed = Command::new("kill").args(["-KILL", &id]).status();
        panic!("process {id} did not end within {GUARD:?} and was killed: {killed:?}");
    };
    output.expect("an end")
}

/// Waits until a process that was just started has its handler of Ctrl-C, and then a short time more.
pub fn at_work(running: &Child) {
    let status = format!("/proc/{}/status", running.id());
    // Bit 1 of the mask stands for SIGINT, which is signal 2.
    let catches = |status: String| {
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        Some(u64::from_str_radix(caught.trim(), 16).ok()? & 0b10 != 0)
    };
    if cfg!(target_os = "linux") {
        while fs::read_to_string(&status).ok().and_then(catches) == Some(false) {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(300));
    } else {
        std::thread::sleep(Duration::from_millis(1500));
    }
}

#[cfg(unix)]
pub fn shell(home: &Path, script: &str) -> Command {
    let mut command = Command::new("sh");
    command.current_dir(home).env("BURSTSCOPE_DEFAULTS", "").args(["-c", script]);
    command
}

/// Makes a chart of four small frames in the folder `home/name`.
#[cfg(unix)]
pub fn chart(home: &Path, name: impl AsRef<std::ffi::OsStr>) {
    let size = ["--width", "96", "--height", "72", "--frames", "4", "--discs", "3", "--radius", "3:6", "--snr", "5"];
    let mut making = home.program("synth chart --quiet --out");
    let output = making.arg(name).args(size).output().expect("it starts");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[cfg(unix)]
pub fn home_with(charts: &[&str]) -> Folder {
    let home = folder();
    charts.iter().for_each(|name| chart(&home, name));
    home
}

#[cfg(unix)]
pub const SEARCH: [&str; 4] = ["--slopes-u", "-1:1:3", "--octaves", "2"];

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Lines of a CSV file of features as numbers, without the header and the words of the last column; NaN for empty
/// cells.
pub fn features(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).expect("a file");
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some(
            "u,v,sigma,orientation,slope_u,slope_v,response,snr,octave,level,at_slope_limit,slope_sigma,field_u,field_v,field_sigma,layer,motion"
        )
    );
    let number = |cell: &str| if cell.is_empty() { f64::NAN } else { cell.parse().expect("a number") };
    let numbers = |line: &str| line.split(',').take(16).map(number).collect();
    lines.map(numbers).collect()
}

pub fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for name in names(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            found.extend(contents(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            // A link may lead nowhere.
            let content =
                fs::read(&path).or_else(|_| fs::read_link(&path).map(|to| to.as_os_str().as_encoded_bytes().to_vec()));
            found.push((name, content.expect("a file or a link")));
        }
    }
    found
}

/// Leaves a hidden folder in `folder` as a run does that is killed while it writes.
pub fn leave_unfinished(folder: &Path) {
    use burstscope::files::mark::{OutputKind, claiming};
    let hidden = folder.join(".burstscope-abc.tmp");
    fs::create_dir(&hidden).expect("made");
    let mark = claiming(OutputKind::Unfinished, &serde_json::json!({ "target": "x.tiff" }));
    fs::write(hidden.join(OutputKind::Unfinished.file()), mark).expect("written");
    fs::write(hidden.join("new"), "half").expect("written");
}
