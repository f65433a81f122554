//! Bursts: opened from files, made of arrays, and their frames as arrays.

use crate::failure::raised;
use crate::lent::LentArray;
use crate::work::run;
use burstscope::burst::{ArrayFrame, Arrays, Burst, Limits, OpenOptions, Positions, ViewsChoice};
use burstscope::cli::Failure;
use burstscope::plane::Plane;
use burstscope::requests::BurstSource;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Frames of one size, calibrated, in time order.
#[pyclass(frozen, module = "burstscope._burstscope")]
pub(crate) struct RawBurst {
    pub(crate) burst: Burst,
}

/// Options for opening a burst from their fields as JSON.
fn options_of(calibration: &str) -> PyResult<OpenOptions> {
    let wrong = |name: &str, error: serde_json::Error| PyValueError::new_err(format!("{name}: {error}"));
    let given: Map<String, Value> = serde_json::from_str(calibration).map_err(|error| wrong("calibration", error))?;
    for (name, value) in &given {
        // Alone, so that the error names it.
        let alone = Value::Object([(name.clone(), value.clone())].into_iter().collect());
        serde_json::from_value::<OpenOptions>(alone).map_err(|error| wrong(name, error))?;
    }
    serde_json::from_value(Value::Object(given)).map_err(|error| wrong("calibration", error))
}

fn views_choice(views: Option<String>) -> PyResult<Option<ViewsChoice>> {
    let read = |views: String| views.parse().map_err(|e| PyValueError::new_err(format!("views: {e}")));
    views.map(read).transpose()
}

/// Name, names of the frames, full scale, quantisation step, suggested full scale, encoding, binning, notes, sources,
/// and the positions of uneven frames, or places of views, with the frame interval.
type About = (
    String,
    Vec<String>,
    (f32, f32, Option<f32>),
    String,
    usize,
    Vec<String>,
    Vec<PathBuf>,
    (Vec<f64>, Vec<[f64; 2]>, Option<f64>),
);

impl RawBurst {
    /// Adds a note where the values are floats above 1, whose full scale nobody named.
    fn with_note_of_scale(mut self, is_given: bool) -> Self {
        let Burst { full_scale, quantisation_step, .. } = self.burst;
        if !is_given && quantisation_step == 0.0 && full_scale != 1.0 {
            self.burst.taken.push(format!("floats above 1: the largest, {full_scale}, was taken for full scale"));
        }
        self
    }
}

#[pymethods]
impl RawBurst {
    /// Opens a burst.
    #[staticmethod]
    fn open(py: Python<'_>, paths: Vec<PathBuf>, calibration: String, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        let options = options_of(&calibration)?;
        let built_in = match &paths[..] {
            [one] => one.to_str().and_then(BurstSource::named),
            _ => None,
        };
        if built_in.is_some() && !options.is_plain() {
            return Err(PyValueError::new_err("built-in bursts need no calibration; leave its keywords out"));
        }
        let source = built_in.unwrap_or(BurstSource::Paths(paths));
        let is_given = options.full_scale.is_some();
        run(py, progress, move |monitor| source.burst(&options, monitor).map_err(Failure::from))
            .map(|burst| Self { burst }.with_note_of_scale(is_given))
    }

    /// Makes a burst of arrays [H, W], one a frame, at `times` of any unit, which increase, or of `views` in a grid.
    #[staticmethod]
    fn of_arrays(
        py: Python<'_>,
        name: String,
        frames: Bound<'_, PyAny>,
        times: Option<Vec<f64>>,
        views: Option<String>,
        bias: Bound<'_, PyAny>,
        flat: Bound<'_, PyAny>,
        mask: Bound<'_, PyAny>,
        mask_saturated: bool,
        full_scale: Option<f32>,
        black_level: Option<f32>,
    ) -> PyResult<Self> {
        let all = |arrays: &Bound<'_, PyAny>| {
            arrays.try_iter()?.map(|array| array_frame(&array?)).collect::<PyResult<Vec<_>>>()
        };
        let arrays = Arrays { frames: all(&frames)?, bias: all(&bias)?, flat: all(&flat)?, mask: all(&mask)? };
        let views = views_choice(views)?;
        let options = OpenOptions { full_scale, black_level, mask_saturated, views, ..OpenOptions::default() };
        let mut burst =
            run(py, None, move |monitor| Burst::from_arrays(name, arrays, &options, monitor).map_err(Failure::from))?;
        if let Some(times) = times {
            let positions = Positions::of_seconds(&times).filter(|positions| positions.len() == burst.len());
            let positions =
                positions.ok_or_else(|| PyValueError::new_err("times: they do not rise, one for each frame"));
            burst.positions = positions?.with_interval(None);
        }
        Ok(Self { burst }.with_note_of_scale(full_scale.is_some()))
    }

    /// All of the burst but its frames.
    fn about(&self) -> About {
        let burst = &self.burst;
        let notes = burst.notes().into_iter().filter(|note| note.option.is_none()).map(|note| note.text).collect();
        (
            burst.name.clone(),
            burst.frame_names.clone(),
            (burst.full_scale, burst.quantisation_step, burst.suggested_full_scale),
            self.encoding(),
            burst.binning,
            notes,
            burst.sources.clone(),
            (burst.positions.list(), burst.positions.views(), burst.positions.interval_s()),
        )
    }

    /// The burst of these frames, fractions of full scale and NaN where they are masked, and of what `about` gave.
    #[staticmethod]
    fn of_parts(frames: Vec<Bound<'_, PyAny>>, about: About) -> PyResult<Self> {
        let plane = |array: &Bound<'_, PyAny>| match array_frame(array)? {
            ArrayFrame::Floats(plane) => Ok(Arc::new(plane.with_nan_masked())),
            ArrayFrame::Integers { .. } => Err(PyTypeError::new_err("the frames of a burst are float32")),
        };
        let frames = frames.iter().map(plane).collect::<PyResult<Vec<_>>>()?;
        let (
            name,
            frame_names,
            (full_scale, quantisation_step, suggested),
            encoding,
            binning,
            taken,
            sources,
            (times, views, interval_s),
        ) = about;
        let positions = Positions::of_lists(frames.len(), &times, &views);
        let positions = positions.unwrap_or_else(|| Positions::even(frames.len())).with_interval(interval_s);
        let encoding = serde_json::from_value(encoding.into()).unwrap_or_default();
        let burst = Burst {
            name,
            frames,
            frame_names,
            positions,
            full_scale,
            quantisation_step,
            encoding,
            binning,
            suggested_full_scale: suggested,
            remarks: Vec::new(),
            taken,
            sources,
        };
        Ok(Self { burst })
    }

    /// Rows and columns of the grid that the views of a light field fill.
    #[getter]
    fn views(&self) -> Option<(usize, usize)> {
        self.burst.positions.rows_and_columns()
    }

    /// Positions of the frames from the first, frame intervals, and the interval in seconds, where it is known.
    fn positions(&self) -> (Vec<f64>, Option<f64>) {
        (self.burst.positions.since_first(), self.burst.positions.interval_s())
    }

    #[getter]
    fn name(&self) -> &str {
        &self.burst.name
    }

    #[getter]
    fn frame_names(&self) -> Vec<String> {
        self.burst.frame_names.clone()
    }

    /// (frames, rows, columns).
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let (width, height) = self.burst.size();
        (self.burst.len(), height, width)
    }

    #[getter]
    fn full_scale(&self) -> f32 {
        self.burst.full_scale
    }

    #[getter]
    fn quantisation_step(&self) -> f32 {
        self.burst.quantisation_step
    }

    #[getter]
    fn encoding(&self) -> String {
        serde_json::to_value(self.burst.encoding).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
    }

    #[getter]
    fn binning(&self) -> usize {
        self.burst.binning
    }

    #[getter]
    fn suggested_full_scale(&self) -> Option<f32> {
        self.burst.suggested_full_scale
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.burst.notes().into_iter().map(|note| note.text).collect()
    }

    #[getter]
    fn sources(&self) -> Vec<PathBuf> {
        self.burst.sources.clone()
    }

    /// Frame `t` as a new array.
    fn frame<'py>(&self, py: Python<'py>, t: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let frame = self.burst.frames.get(t).ok_or_else(|| {
            PyIndexError::new_err(format!("there is no frame {t}: the burst has {}", self.burst.len()))
        })?;
        array_of(py, Plane::clone(frame))
    }

    /// Frame `t` as a new array, NaN where it is masked.
    fn seen<'py>(&self, py: Python<'py>, t: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let frame = &self.burst.frames[t];
        array_of(py, Plane::from_vec(frame.width(), frame.height(), frame.seen_values().into_owned()))
    }

    /// Addresses of the frames' pixels in memory.
    fn addresses(&self) -> Vec<usize> {
        self.burst.frames.iter().map(|frame| frame.data().as_ptr() as usize).collect()
    }
}

/// Fails where the planes of `count` frames would need more memory than there is.
#[pyfunction]
pub(crate) fn check_size(name: &str, count: u64, width: u64, height: u64) -> PyResult<()> {
    let checked = Limits::default().check_burst(Path::new(name), count, width, height);
    checked.map_err(|error| raised(&Failure::from(error)))
}

/// The frame of an array [H, W] of uint8, uint16 or float32.
fn array_frame(array: &Bound<'_, PyAny>) -> PyResult<ArrayFrame> {
    macro_rules! integers {
        ($type:ty, $make:ident) => {
            if let Ok(array) = array.cast::<PyArray2<$type>>() {
                let (height, width) = (array.shape()[0], array.shape()[1]);
                let readonly = array.readonly();
                let values = readonly.as_slice().map_err(|_| not_contiguous())?;
                return Ok(ArrayFrame::$make(width, height, values.iter().copied()));
            }
        };
    }
    integers!(u8, of_u8);
    integers!(u16, of_u16);
    let array = array
        .cast::<PyArray2<f32>>()
        .map_err(|_| PyTypeError::new_err("a frame is an array [rows, columns] of uint8, uint16 or float32"))?;
    let (height, width) = (array.shape()[0], array.shape()[1]);
    let lent = LentArray::of(array).ok_or_else(not_contiguous)?;
    Ok(ArrayFrame::Floats(Plane::from_shared(width, height, Arc::new(lent))))
}

fn not_contiguous() -> PyErr {
    PyValueError::new_err("the array is not contiguous; give numpy.ascontiguousarray of it")
}

/// The plane as an array [H, W].
pub(crate) fn array_of(py: Python<'_>, plane: Plane) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let (width, height) = plane.size();
    PyArray1::from_vec(py, plane.into_vec()).reshape([height, width])
}

/// The plane of an array [H, W].
pub(crate) fn plane_of(array: &Bound<'_, PyArray2<f32>>) -> PyResult<Plane> {
    let (height, width) = (array.shape()[0], array.shape()[1]);
    let readonly = array.readonly();
    let values = readonly.as_slice().map_err(|_| not_contiguous())?;
    Ok(Plane::from_vec(width, height, values.to_vec()))
}
