//! Explanations: the slopes that a burst needs, the fate of a place, and the noise.

use crate::burst::RawBurst;
use crate::parameters::{Given, search_params};
use crate::work::run;
use burstscope::Burst;
use burstscope::cli::{Failure, probe_document, slopes_document};
use burstscope::inspect::ProbeCache;
use burstscope::inspect::place::{ProbeOptions, ProbeSubject, check_place, probe};
use burstscope::inspect::report::{probe_figure, probe_text, spectrum_figure, spectrum_text};
use burstscope::inspect::slopes::spectrum;
use pyo3::prelude::*;
use std::path::PathBuf;

/// A search with all that questions about it need.
#[pyclass(frozen, module = "burstscope._burstscope")]
pub(crate) struct RawInspection {
    burst: Burst,
    cache: ProbeCache,
}

/// An answer as numbers (JSON), as text and as a figure (SVG).
type Answer = (String, String, String);

fn unwritten(error: serde_json::Error) -> Failure {
    Failure::Failed(error.into())
}

#[pymethods]
impl RawInspection {
    /// The spectrum of the slopes.
    fn slopes(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Answer> {
        run(py, progress, |monitor| {
            let answer = spectrum(&self.cache, monitor)?;
            let document = serde_json::to_string(&slopes_document(&self.cache, &answer)).map_err(unwritten)?;
            let name = &self.burst.name;
            Ok((document, spectrum_text(&answer, name), spectrum_figure(&answer, name).drawing.svg()))
        })
    }

    /// The fate of a place, or of a feature.
    fn probe(
        &self,
        py: Python<'_>,
        at: Option<(f32, f32)>,
        feature: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Answer> {
        run(py, progress, |monitor| {
            if let Some((u, v)) = at {
                check_place([u, v], self.burst.size())?;
            }
            let wanted = feature.map_or(ProbeSubject::Best, ProbeSubject::Feature);
            let options = ProbeOptions { wanted, ..ProbeOptions::default() };
            let place = at.map_or([0.0; 2], |(u, v)| [u, v]);
            let answer = probe(&self.cache, place, &options, monitor)?;
            let document = serde_json::to_string(&probe_document(&self.cache, &answer)).map_err(unwritten)?;
            let name = &self.burst.name;
            Ok((document, probe_text(&answer, name), probe_figure(&answer, name).drawing.svg()))
        })
    }

    /// The noise model of the search, as `detect --json` has it.
    fn noise(&self) -> PyResult<String> {
        let noise = &self.cache.detection().noise;
        serde_json::to_string(&**noise).map_err(|error| crate::failure::raised(&unwritten(error)))
    }
}

/// Searches a burst, and keeps what questions need.
#[pyfunction]
pub(crate) fn inspect(
    py: Python<'_>,
    burst: &RawBurst,
    file: Option<PathBuf>,
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<RawInspection> {
    let params = search_params(file.as_deref(), &given)?;
    let burst = burst.burst.clone();
    let cache = run(py, progress, |monitor| Ok(ProbeCache::new(&burst, &params, monitor)?))?;
    Ok(RawInspection { burst, cache })
}
