//! Detections: the features of a burst as arrays, and the pictures of the search's steps.

use crate::burst::{RawBurst, array_of};
use crate::failure::raised;
use crate::parameters::{Given, search_params};
use crate::work::run;
use burstscope::baseline::merge_burst;
use burstscope::cli::{Failure, burst_document};
use burstscope::detect::{Searched, prepare, search};
use burstscope::detector::quantity::Place;
use burstscope::detector::view::{coverage_view, dog_view, noise_map, stack_view};
use burstscope::detector::{Feature, Method, Quantity, Slope, SlopeGrid};
use burstscope::error::Error;
use burstscope::export::ExportFormat;
use burstscope::{Burst, Detection, DetectorParams, Monitor, Plane};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyList;
use std::path::PathBuf;

/// Features of a burst.
#[pyclass(frozen, module = "burstscope._burstscope")]
pub(crate) struct RawDetection {
    pub(crate) searched: Searched,
    document: String,
}

impl RawDetection {
    fn features(&self) -> &[Feature] {
        &self.searched.detection.features
    }

    fn pairs<'py>(
        &self,
        py: Python<'py>,
        values: impl Fn(&Feature) -> [f32; 2],
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let flat: Vec<f32> = self.features().iter().flat_map(values).collect();
        PyArray1::from_vec(py, flat).reshape([self.features().len(), 2])
    }
}

#[pymethods]
impl RawDetection {
    fn __len__(&self) -> usize {
        self.features().len()
    }

    fn xy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.pairs(py, |f| [f.u, f.v])
    }

    fn slope<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.pairs(py, |f| [f.slope.u, f.slope.v])
    }

    /// The values of a column of the feature files.
    fn column<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let quantity = Quantity::STORED.into_iter().find(|quantity| quantity.record().key == key);
        let quantity = quantity.ok_or_else(|| PyValueError::new_err(format!("there is no column '{key}'")))?;
        let features = self.features().iter().copied();
        Ok(match quantity.record().place {
            Place::Real(_) => PyArray1::from_iter(py, features.filter_map(|f| quantity.of(&f))).into_any(),
            Place::Whole(at) => PyArray1::from_iter(py, features.map(|mut f| *at(&mut f))).into_any(),
            Place::Flag(at) => PyArray1::from_iter(py, features.map(|mut f| *at(&mut f))).into_any(),
            Place::Moves(at) => PyList::new(py, features.map(|mut f| at(&mut f).key()))?.into_any(),
            Place::Beside => return Err(PyValueError::new_err(format!("no feature holds '{key}'"))),
        })
    }

    fn slope_index<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_iter(py, self.features().iter().map(|f| f.slope_index as i64))
    }

    fn descriptors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let flat: Vec<u8> = self.searched.detection.descriptors.iter().flatten().copied().collect();
        PyArray1::from_vec(py, flat).reshape([self.features().len(), 128])
    }

    /// Document of a burst, as `detect --json` writes it (JSON).
    fn document(&self) -> &str {
        &self.document
    }

    /// The parameters of the search as a parameter file (TOML), with the slopes that were searched.
    fn params_toml(&self) -> String {
        self.searched.params.to_toml()
    }

    /// Slopes that were searched, in the grid's order.
    fn slopes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let slopes: Vec<f32> = self.searched.detection.slopes.slopes().flat_map(|s| [s.u, s.v]).collect();
        let count = slopes.len() / 2;
        PyArray1::from_vec(py, slopes).reshape([count, 2])
    }

    /// The features with these numbers, which are below the number of features, in this order.
    fn subset(&self, numbers: Vec<usize>) -> Self {
        let mut searched = self.searched.clone();
        let Detection { features, descriptors, .. } = &self.searched.detection;
        searched.detection.features = numbers.iter().map(|&number| features[number]).collect();
        searched.detection.descriptors = numbers.iter().map(|&number| descriptors[number]).collect();
        Self { searched, document: self.document.clone() }
    }

    /// Writes the features to a file.
    fn write(&self, path: PathBuf, format: &str) -> PyResult<()> {
        let format: ExportFormat = format.parse().map_err(|error| PyValueError::new_err(format!("format: {error}")))?;
        format.write(&path, &self.searched.detection).map_err(|error| raised(&error.into()))
    }
}

/// Finds the features of a burst.
#[pyfunction]
pub(crate) fn detect(
    py: Python<'_>,
    burst: &RawBurst,
    file: Option<PathBuf>,
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<RawDetection> {
    let params = search_params(file.as_deref(), &given)?;
    let burst = burst.burst.clone();
    let (searched, document) = run(py, progress, move |monitor| {
        let searched = search(&burst, &params, monitor)?;
        let document = burst_document(&burst, &searched);
        Ok((searched, document))
    })?;
    let document = document.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    Ok(RawDetection { searched, document })
}

/// Kind of a picture of the search.
#[derive(FromPyObject)]
pub(crate) struct StepPicture {
    #[pyo3(item)]
    kind: String,
    #[pyo3(item)]
    slope: (f32, f32),
    #[pyo3(item)]
    octave: i32,
    #[pyo3(item)]
    level: i32,
}

/// A picture of a step of the search: `stack`, `dog`, `merge`, `noise` or `coverage`.
#[pyfunction]
pub(crate) fn step_picture<'py>(
    py: Python<'py>,
    burst: &RawBurst,
    asked: StepPicture,
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let params = search_params(None, &given)?.detector;
    let burst = burst.burst.clone();
    let plane = run(py, progress, move |monitor| picture(&burst, params, &asked, monitor))?;
    array_of(py, plane)
}

fn picture(
    burst: &Burst,
    mut params: DetectorParams,
    asked: &StepPicture,
    monitor: &Monitor,
) -> Result<Plane, Failure> {
    let slope = Slope::new(asked.slope.0, asked.slope.1);
    if !(slope.u.is_finite() && slope.v.is_finite()) {
        return Err(Failure::usage("slope: it is not finite; give pixels per frame to the right and down"));
    }
    // Only this slope is computed, so only this slope is checked.
    params.slopes = SlopeGrid::single(slope);
    if asked.kind == "merge" {
        params.validate_frames(burst.len())?;
        let merge = DetectorParams { method: Method::Merge, ..params };
        let merged = merge_burst(burst, merge.used_frames(burst.len()), monitor)?;
        return Ok(Plane::clone(&merged.frames[0]));
    }
    let (burst, params) = prepare(burst, &params, monitor)?;
    let found = |plane: Result<Plane, Error>| plane.map_err(Failure::from);
    match asked.kind.as_str() {
        "dog" => found(dog_view(&burst, &params, slope, asked.octave, asked.level, monitor)),
        "noise" => found(noise_map(&burst, &params, monitor)),
        "coverage" => found(coverage_view(&burst, &params, slope, monitor)),
        _ => Ok(stack_view(&burst, &params, slope, monitor)?),
    }
}
