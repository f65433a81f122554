//! Detections: the features of a burst as arrays, and the pictures of the search's steps.

use crate::burst::{RawBurst, array_of};
use crate::failure::raised;
use crate::parameters::{Given, search_params};
use crate::work::run;
use burstscope::baseline::merge_burst;
use burstscope::burst::Positions;
use burstscope::cli::{Failure, burst_document};
use burstscope::detect::{Searched, prepare, search};
use burstscope::detector::quantity::FeatureField;
use burstscope::detector::slopes::resolve;
use burstscope::detector::view::{coverage_view, dog_view, field_view, noise_map, stack_view};
use burstscope::detector::{
    Descriptor, Feature, Method, Moves, Quantity, SearchParams, Slope, SlopeGrid, StageTimes, Tally,
};
use burstscope::error::Error;
use burstscope::export::ExportFormat;
use burstscope::{Burst, Detection, DetectorParams, Monitor, Plane};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyList;
use std::path::PathBuf;
use std::sync::Arc;

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
            FeatureField::Real(_) => PyArray1::from_iter(py, features.filter_map(|f| quantity.of(&f))).into_any(),
            FeatureField::Whole(at) => PyArray1::from_iter(py, features.map(|mut f| *at(&mut f))).into_any(),
            FeatureField::Flag(at) => PyArray1::from_iter(py, features.map(|mut f| *at(&mut f))).into_any(),
            FeatureField::Moves(at) => PyList::new(py, features.map(|mut f| at(&mut f).key()))?.into_any(),
            FeatureField::Beside => return Err(PyValueError::new_err(format!("no feature holds '{key}'"))),
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

    /// The columns of the feature files [n, 17], in their order.
    fn rows<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let values = |f| Quantity::STORED.into_iter().filter_map(move |quantity| quantity.of(f));
        let flat: Vec<f32> = self.features().iter().flat_map(values).collect();
        PyArray1::from_vec(py, flat).reshape([self.features().len(), Quantity::STORED.len()])
    }

    /// A detection of these columns, indices of slopes and descriptors: one that was taken apart, or of a feature file,
    /// whose slopes, parameters and document are unknown. Files of earlier versions have fewer columns.
    #[staticmethod]
    fn of_rows(
        rows: PyReadonlyArray2<'_, f32>,
        slope_index: PyReadonlyArray1<'_, i64>,
        descriptors: PyReadonlyArray2<'_, u8>,
        params_toml: &str,
        document: String,
    ) -> PyResult<Self> {
        let wrong = || PyValueError::new_err("these are no features of Burstscope: arrays of other shapes");
        let (rows, descriptors) = (rows.as_array(), descriptors.as_array());
        let is_known = rows.ncols() == Quantity::STORED.len() || Quantity::STORED_EARLIER.contains(&rows.ncols());
        if !is_known || slope_index.len()? != rows.nrows() {
            return Err(wrong());
        }
        let indices = slope_index.as_array();
        let features = rows.outer_iter().zip(indices).map(|(row, &index)| {
            let slope_index = usize::try_from(index).unwrap_or_default();
            let mut feature = Feature { field_sigma: f32::INFINITY, slope_index, ..Feature::default() };
            for (quantity, &value) in Quantity::STORED.into_iter().zip(row) {
                match quantity.record().place {
                    FeatureField::Real(at) => *at(&mut feature) = value,
                    FeatureField::Whole(at) => *at(&mut feature) = value as i32,
                    FeatureField::Flag(at) => *at(&mut feature) = value != 0.0,
                    FeatureField::Moves(at) => {
                        *at(&mut feature) = Moves::ALL.get(value as usize).copied().unwrap_or_default();
                    }
                    FeatureField::Beside => {}
                }
            }
            if feature.field_sigma.is_infinite() {
                feature.field = Slope::default();
            }
            if rows.ncols() < Quantity::STORED.len() {
                feature.moves = Moves::by_numbers(&feature);
            }
            feature
        });
        let features: Vec<Feature> = features.collect();
        let of_row = |row: numpy::ndarray::ArrayView1<'_, u8>| Descriptor::try_from(row.to_vec()).map_err(|_| wrong());
        let descriptors: Vec<Descriptor> = descriptors.outer_iter().map(of_row).collect::<PyResult<_>>()?;
        if descriptors.len() != features.len() {
            return Err(wrong());
        }
        let params = SearchParams::from_toml(params_toml).map_err(PyValueError::new_err)?.at_given();
        let detection = Detection {
            features,
            descriptors,
            tally: Tally::default(),
            frame_noise: 0.0,
            noise: Arc::default(),
            field: None,
            noise_gate_factor: 0.0,
            slopes: params.used_slopes(),
            frames_used: 0..0,
            positions: Positions::even(0),
            octaves: 0..0,
            times: StageTimes::default(),
        };
        Ok(Self { searched: Searched { detection, params, finding: None, slopes_secs: 0.0 }, document })
    }

    /// The parameters of the search as a parameter file (TOML), with the slopes that were searched.
    fn params_toml(&self) -> String {
        SearchParams::from(self.searched.params.clone()).to_toml()
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
        format.write(&path, &self.searched.detection, None).map_err(|error| raised(&error.into()))
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
        let document = burst_document(&burst, &searched, monitor)?;
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
    let params = search_params(None, &given)?;
    let burst = burst.burst.clone();
    let plane = run(py, progress, move |monitor| picture(&burst, params, &asked, monitor))?;
    array_of(py, plane)
}

fn picture(burst: &Burst, params: SearchParams, asked: &StepPicture, monitor: &Monitor) -> Result<Plane, Failure> {
    let slope = Slope::new(asked.slope.0, asked.slope.1);
    if !(slope.u.is_finite() && slope.v.is_finite()) {
        return Err(Failure::usage("slope: it is not finite; give pixels per frame to the right and down"));
    }
    // Only this slope is computed, so only this slope is checked.
    let params = params.at(SlopeGrid::single(slope));
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

/// The field of motion of a burst: the motion and its covariance (of u, of u with v, of v) of each cell
/// [rows, columns, 2 and 3], its layer and whether it is known [rows, columns], the layers' motions, spreads and shares
/// [n, 4], and the pixels on a side of a cell.
type FieldArrays<'py> = (
    Bound<'py, PyArray3<f32>>,
    Bound<'py, PyArray3<f32>>,
    Bound<'py, PyArray2<u8>>,
    Bound<'py, PyArray2<bool>>,
    Bound<'py, PyArray2<f32>>,
    usize,
);

/// Finds the field of motion of a burst; `None` where it shows none.
#[pyfunction]
pub(crate) fn motion_field<'py>(
    py: Python<'py>,
    burst: &RawBurst,
    file: Option<PathBuf>,
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<Option<FieldArrays<'py>>> {
    let params = search_params(file.as_deref(), &given)?;
    let burst = burst.burst.clone();
    let field = run(py, progress, move |monitor| {
        let (params, _) = resolve(&burst, &params, monitor)?;
        Ok(field_view(&burst, &params, monitor)?)
    })?;
    let Some(field) = field else { return Ok(None) };
    let (columns, rows) = field.size;
    let floats = |values: Vec<f32>, last: usize| PyArray1::from_vec(py, values).reshape([rows, columns, last]);
    let motions = field.motions.iter();
    let layers = field.layers.iter().flat_map(|layer| [layer.slope.u, layer.slope.v, layer.spread, layer.share]);
    Ok(Some((
        floats(motions.clone().flat_map(|motion| [motion.slope.u, motion.slope.v]).collect(), 2)?,
        floats(motions.clone().flat_map(|motion| motion.covariance).collect(), 3)?,
        PyArray1::from_slice(py, &field.layer).reshape([rows, columns])?,
        PyArray1::from_vec(py, motions.map(|motion| field.is_known(motion)).collect()).reshape([rows, columns])?,
        PyArray1::from_vec(py, layers.collect()).reshape([field.layers.len(), 4])?,
        field.cell_px,
    )))
}
