//! The commands and the window in Python's process, and the synthetic bursts that commands make.

use crate::burst::RawBurst;
use crate::parameters::{Given, search_params};
use crate::work::run;
use burstscope::burst::DecodeWorker;
use burstscope::cli::{self, Host};
use burstscope::export::case::{Case, Enclosed};
use burstscope::inspect::place::check_place;
use burstscope::inspect::result::truth_of;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;

/// Sets the command that decodes files for this process: `program` with `arguments` and the path of a file.
#[pyfunction]
pub(crate) fn install_decode_worker(program: PathBuf, arguments: Vec<OsString>) -> bool {
    DecodeWorker { program, arguments }.install()
}

/// Runs a command, or opens the window: `arguments` are the program's name and what follows it. Returns the exit code.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cli::run_in(&arguments, None, Host::Other))
}

/// Makes the burst of `synth` with these arguments; with its truth (JSON).
#[pyfunction]
pub(crate) fn synthesise(
    py: Python<'_>,
    arguments: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(RawBurst, String)> {
    let (burst, truth) = run(py, progress, move |monitor| {
        let (burst, truth) = cli::synthetic_burst(&arguments, monitor)?;
        let truth = serde_json::to_string(&truth).map_err(|error| cli::Failure::Failed(error.into()))?;
        Ok((burst, truth))
    })?;
    Ok((RawBurst { burst }, truth))
}

/// Writes a burst, the settings of its search, a place and a note as a case.
#[pyfunction]
pub(crate) fn write_case(
    py: Python<'_>,
    burst: &RawBurst,
    path: PathBuf,
    asked: (Option<[f32; 2]>, Option<usize>, String),
    file: Option<PathBuf>,
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let search = search_params(file.as_deref(), &given)?;
    let burst = burst.burst.clone();
    let (place, around, note) = asked;
    run(py, progress, move |monitor| {
        place.map_or(Ok(()), |place| check_place(place, burst.size()))?;
        let (case, part) = Case::of(&burst, &search, (place, around), &note, monitor)?;
        // A truth that is damaged, or of other pictures, is none.
        let enclosed = Enclosed { session: None, truth: truth_of(&burst).unwrap_or_default() };
        Ok(burstscope::export::case::write_case(&path, (&case, &part), &enclosed, monitor)?)
    })
}
