//! Matches of two detections.

use crate::burst::RawBurst;
use crate::detection::RawDetection;
use crate::failure::raised;
use crate::parameters::{Given, match_params};
use crate::work::run;
use burstscope::burst::OpenOptions;
use burstscope::dataset::{
    BurstCameras, CameraChoice, ColmapJob, DetectedBurst, FeatureJob, export_detections, match_bursts, match_rows,
};
use burstscope::detect::Searched;
use burstscope::detector::SearchParams;
use burstscope::export::write_drawing;
use burstscope::export::{FigureAmount, MatchRow};
use burstscope::matching::{MatchResult, Refusal, TwoViewModel};
use burstscope::requests::{MatchFigure, MatchPictures};
use burstscope::{Burst, Plane};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Name of a geometry and its 3×3 matrix.
type NamedMatrix<'py> = (&'static str, Bound<'py, PyArray2<f64>>);

/// Matches of two bursts.
#[pyclass(frozen, module = "burstscope._burstscope")]
pub(crate) struct RawMatches {
    result: MatchResult,
    rows: Vec<MatchRow>,
    params: String,
}

impl RawMatches {
    /// A number of each match, NaN where there is none.
    fn numbers<'py>(&self, py: Python<'py>, of: impl Fn(&MatchRow) -> Option<f32>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_vec(py, self.rows.iter().map(|row| of(row).unwrap_or(f32::NAN)).collect())
    }
}

#[pymethods]
impl RawMatches {
    fn __len__(&self) -> usize {
        self.result.matches.len()
    }

    fn pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let flat: Vec<i64> = self.result.matches.iter().flat_map(|m| [m.a as i64, m.b as i64]).collect();
        PyArray1::from_vec(py, flat).reshape([self.result.matches.len(), 2])
    }

    fn distance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_vec(py, self.result.matches.iter().map(|m| m.distance).collect())
    }

    fn ratio<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.numbers(py, |row| row.ratio)
    }

    fn ratio_among_all<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.numbers(py, |row| row.predicted?.1)
    }

    fn among<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.numbers(py, |row| row.predicted.map(|(among, _)| among as f32))
    }

    /// `sure` or `predicted`, of each match.
    fn how(&self) -> Vec<&'static str> {
        self.rows.iter().map(|row| row.how()).collect()
    }

    /// Places in A and in B after the alignment [m, 2, 2].
    fn aligned<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let flat: Vec<f32> = self.rows.iter().flat_map(|row| row.aligned).flatten().collect();
        PyArray1::from_vec(py, flat).reshape([self.rows.len(), 2, 2])
    }

    /// Shift (u, v) in B and correlation of the pictures [m, 3], NaN where they do not tell.
    fn measured<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let numbers = |row: &MatchRow| row.measured.map_or([f64::NAN; 3], |([u, v], correlation)| [u, v, correlation]);
        PyArray1::from_vec(py, self.rows.iter().flat_map(numbers).collect()).reshape([self.rows.len(), 3])
    }

    /// Why there are no inliers although enough matches agreed.
    fn refused(&self) -> Option<&'static str> {
        self.result.counts.refused.map(Refusal::words)
    }

    /// Whether each match is an inlier; `None` where matches were not verified.
    fn inliers<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<bool>>> {
        self.result.verification.as_ref().map(|v| PyArray1::from_vec(py, v.inlier.clone()))
    }

    /// Errors at the aligned places, or at those found; `None` where matches were not verified.
    fn error_px<'py>(&self, py: Python<'py>, as_found: bool) -> Option<Bound<'py, PyArray1<f32>>> {
        self.result.verification.as_ref().map(|_| self.numbers(py, |row| row.error_px[usize::from(as_found)]))
    }

    /// Name and 3×3 matrix of the geometry.
    fn geometry<'py>(&self, py: Python<'py>) -> PyResult<Option<NamedMatrix<'py>>> {
        let Some(model) = self.result.verification.as_ref().and_then(|v| v.model.as_ref()) else { return Ok(None) };
        let (kind, matrix) = match model {
            TwoViewModel::Fundamental { fundamental } => ("fundamental", fundamental),
            TwoViewModel::Essential { essential, .. } => ("essential", essential),
            TwoViewModel::Homography { forward, .. } => ("homography", forward),
        };
        let rows: Vec<f64> = matrix.transpose().iter().copied().collect();
        Ok(Some((kind, PyArray1::from_vec(py, rows).reshape([3, 3])?)))
    }

    /// Counts of keypoints, putative matches and inliers, with the ratios of `match --json`.
    fn counts(&self) -> String {
        let counts = self.result.counts;
        serde_json::json!({
            "keypoints_a": counts.keypoints_a,
            "keypoints_b": counts.keypoints_b,
            "putative": counts.putative,
            "inliers": counts.inliers,
            "refused": counts.refused,
            "match_ratio": counts.match_ratio(),
            "match_score": counts.match_score(),
            "inlier_ratio": counts.inlier_ratio(),
        })
        .to_string()
    }

    /// Parameters of matching (JSON).
    fn params(&self) -> &str {
        &self.params
    }

    /// The figure of both bursts with the matches between them, as PNG.
    fn picture(
        &self,
        py: Python<'_>,
        a: (PyRef<'_, RawBurst>, PyRef<'_, RawDetection>),
        b: (PyRef<'_, RawBurst>, PyRef<'_, RawDetection>),
    ) -> PyResult<Vec<u8>> {
        let side = |(burst, detection): &(PyRef<'_, RawBurst>, PyRef<'_, RawDetection>)| {
            (burst.burst.clone(), detection.searched.clone())
        };
        let pair = [side(&a), side(&b)];
        run(py, None, |monitor| {
            let figure =
                MatchFigure { pictures: MatchPictures::Stack, matches: FigureAmount::Strongest(100), width_mm: 181.0 };
            let pair = pair.each_ref().map(|(burst, searched)| DetectedBurst {
                burst,
                params: &searched.params,
                detection: &searched.detection,
            });
            let drawing = figure.drawing(pair, &self.result, monitor)?;
            let failed = burstscope::cli::Failure::Failed;
            let folder = tempfile::tempdir().map_err(|error| failed(error.into()))?;
            let file = folder.path().join("matches.png");
            write_drawing(&file, &drawing)?;
            std::fs::read(&file).map_err(|error| failed(error.into()))
        })
    }
}

/// Matches the features of two detections and verifies the matches; of two `cameras` the first is A's.
#[pyfunction]
pub(crate) fn match_features(
    py: Python<'_>,
    a: (Option<PyRef<'_, RawBurst>>, PyRef<'_, RawDetection>),
    b: (Option<PyRef<'_, RawBurst>>, PyRef<'_, RawDetection>),
    cameras: Vec<String>,
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<RawMatches> {
    let params = match_params(&cameras, &given)?;
    let text =
        serde_json::to_string(&params).map_err(|error| raised(&burstscope::cli::Failure::Failed(error.into())))?;
    if params.aligns() && (a.0.is_none() || b.0.is_none()) {
        let message = "align: features of a file have no pictures; give load(path, burst=burst), or align=False";
        return Err(PyValueError::new_err(message));
    }
    // Only aligning looks at the frames.
    let none = Burst::from_planes("", vec![Plane::zeros(1, 1)]);
    let found = [&a, &b].map(|(burst, found)| DetectedBurst {
        burst: burst.as_ref().map_or(&none, |burst| &burst.burst),
        params: &found.searched.params,
        detection: &found.searched.detection,
    });
    let result = run(py, progress, |monitor| Ok(match_bursts(found, &params, monitor)?))?;
    let [a, b] = found.map(|of| &of.detection.features);
    let rows = match_rows(a, b, &result);
    Ok(RawMatches { result, rows, params: text })
}

/// Writes the input of COLMAP's mapper from detections with their bursts; `words` are the pairs, the kind of pictures
/// and the model of a guessed camera. Returns the report (JSON).
#[pyfunction]
pub(crate) fn export_colmap(
    py: Python<'_>,
    found: Vec<(PyRef<'_, RawBurst>, PyRef<'_, RawDetection>)>,
    out: PathBuf,
    camera: Option<String>,
    words: (String, String, String),
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let wrong = |name: &str, error: serde_json::Error| PyValueError::new_err(format!("{name}: {error}"));
    let matching = match_params(camera.as_slice(), &given)?;
    let (pairs, images, model) = words;
    let pairs = pairs.parse().map_err(|error| PyValueError::new_err(format!("pairs: {error}")))?;
    let guessed = CameraChoice::Guessed(serde_json::from_value(model.into()).map_err(|e| wrong("camera_model", e))?);
    let rest = matching.camera.clone().map_or(guessed, CameraChoice::Known);
    let cameras = BurstCameras { rest, ..BurstCameras::default() };
    let images = serde_json::from_value(images.into()).map_err(|error| wrong("images", error))?;
    let features = FeatureJob { detector: SearchParams::default(), open: OpenOptions::default(), images };
    let job = ColmapJob { features, matching, pairs, cameras };
    let found: Vec<(Burst, Searched)> =
        found.iter().map(|(burst, detection)| (burst.burst.clone(), detection.searched.clone())).collect();
    run(py, progress, |monitor| {
        let bursts: Vec<DetectedBurst<'_>> = found
            .iter()
            .map(|(burst, searched)| DetectedBurst { burst, params: &searched.params, detection: &searched.detection })
            .collect();
        let report = export_detections(&out, &bursts, &job, monitor)?;
        serde_json::to_string(&report).map_err(|error| burstscope::cli::Failure::Failed(error.into()))
    })
}
