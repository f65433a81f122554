//! Parameters from keywords, whose values are texts as on the command line.

use crate::failure::raised;
use burstscope::cli::Failure;
use burstscope::cli::matching_args::parse_camera;
use burstscope::cli::search_options::read_params;
use burstscope::detector::params::doc;
use burstscope::detector::{Param, SearchParams};
use burstscope::matching::MatchParams;
use burstscope::matching::params::doc as matching_doc;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::path::Path;

/// Names of parameters and the texts of their values.
pub(crate) type Given = Vec<(String, String)>;

/// Name of a parameter as a keyword.
pub(crate) fn keyword(name: &str) -> String {
    name.replace('-', "_")
}

/// The search parameters: those of the parameter file, if one is given, with the given values.
pub(crate) fn search_params(file: Option<&Path>, given: &Given) -> PyResult<SearchParams> {
    let base = file.map_or(Ok(SearchParams::default()), read_params).map_err(|failure| raised(&failure))?;
    let given = records(&doc::ALL, given)?;
    base.with_texts(given).map_err(|error| raised(&Failure::from(error)))
}

/// The parameters of matching with no camera, one of both images or one of each, as texts or paths of TOML files, and
/// the given values.
pub(crate) fn match_params(cameras: &[String], given: &Given) -> PyResult<MatchParams> {
    let cameras: Result<Vec<_>, String> = cameras.iter().map(|camera| parse_camera(camera)).collect();
    let cameras = cameras.map_err(|error| PyValueError::new_err(format!("camera: {error}")))?;
    let given = records(&matching_doc::ALL, given)?;
    let params = MatchParams::of_texts(Default::default(), cameras.first().cloned(), given);
    let params = params.map_err(|error| raised(&Failure::from(error)))?;
    Ok(if let [a, b] = &cameras[..] { params.with_cameras(Some(a), Some(b)) } else { params })
}

fn records<'a, P>(records: &[Param<P>], given: &'a Given) -> PyResult<Vec<(Param<P>, &'a str)>> {
    let record = |(name, text): &'a (String, String)| {
        let record = records.iter().find(|record| keyword(record.name) == *name).ok_or_else(|| {
            let names: Vec<String> = records.iter().map(|record| keyword(record.name)).collect();
            PyTypeError::new_err(format!("there is no keyword '{name}'; there are {}", names.join(", ")))
        })?;
        Ok((*record, text.as_str()))
    };
    given.iter().map(record).collect()
}
