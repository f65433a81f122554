//! Matches of two detections.

use crate::burst::RawBurst;
use crate::detection::RawDetection;
use crate::failure::raised;
use crate::parameters::{Given, match_params};
use crate::work::run;
use burstscope::dataset::{DetectedBurst, ImageKind, burst_picture, match_bursts};
use burstscope::export::{MatchLine, write_match_picture};
use burstscope::matching::{MatchResult, TwoViewModel};
use burstscope::{Burst, Plane};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Name of a geometry and its 3×3 matrix.
type NamedMatrix<'py> = (&'static str, Bound<'py, PyArray2<f64>>);

/// Matches of two bursts.
#[pyclass(frozen, module = "burstscope._burstscope")]
pub(crate) struct RawMatches {
    result: MatchResult,
    params: String,
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
        PyArray1::from_vec(py, self.result.matches.iter().map(|m| m.ratio).collect())
    }

    /// Whether each match is an inlier; `None` where matches were not verified.
    fn inliers<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<bool>>> {
        self.result.verification.as_ref().map(|v| PyArray1::from_vec(py, v.inlier.clone()))
    }

    fn error_px<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        self.result.verification.as_ref().map(|v| PyArray1::from_vec(py, v.error_px.clone()))
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
            "match_ratio": counts.match_ratio(),
            "match_score": counts.match_score(),
            "precision": counts.precision(),
        })
        .to_string()
    }

    /// Parameters of matching (JSON).
    fn params(&self) -> &str {
        &self.params
    }

    /// The picture of both bursts with the matches between them, as PNG.
    fn picture(
        &self,
        py: Python<'_>,
        a: (PyRef<'_, RawBurst>, PyRef<'_, RawDetection>),
        b: (PyRef<'_, RawBurst>, PyRef<'_, RawDetection>),
    ) -> PyResult<Vec<u8>> {
        let place = |detection: &RawDetection, index: usize| {
            let feature = &detection.searched.detection.features[index];
            [f64::from(feature.u), f64::from(feature.v)]
        };
        let inlier = |k: usize| self.result.verification.as_ref().is_none_or(|v| v.inlier[k]);
        let matches = self.result.matches.iter().enumerate();
        let lines: Vec<MatchLine> =
            matches.map(|(k, m)| MatchLine { a: place(&a.1, m.a), b: place(&b.1, m.b), inlier: inlier(k) }).collect();
        let side = |(burst, detection): &(PyRef<'_, RawBurst>, PyRef<'_, RawDetection>)| {
            (burst.burst.clone(), detection.searched.params.clone())
        };
        let (a, b) = (side(&a), side(&b));
        run(py, None, move |monitor| {
            let picture = |(burst, params): &(_, _)| burst_picture(burst, ImageKind::Middle, params, monitor);
            let (a, b) = (picture(&a)?, picture(&b)?);
            let folder = tempfile::tempdir().map_err(|e| burstscope::cli::Failure::Failed(e.into()))?;
            let file = folder.path().join("matches.png");
            write_match_picture(&file, a.picture(), b.picture(), &lines)?;
            std::fs::read(&file).map_err(|e| burstscope::cli::Failure::Failed(e.into()))
        })
    }
}

/// Matches the features of two detections and verifies the matches.
#[pyfunction]
pub(crate) fn match_features(
    py: Python<'_>,
    a: (Option<PyRef<'_, RawBurst>>, PyRef<'_, RawDetection>),
    b: (Option<PyRef<'_, RawBurst>>, PyRef<'_, RawDetection>),
    camera: Option<String>,
    given: Given,
    progress: Option<Py<PyAny>>,
) -> PyResult<RawMatches> {
    let params = match_params(camera.as_deref(), &given)?;
    let text =
        serde_json::to_string(&params).map_err(|error| raised(&burstscope::cli::Failure::Failed(error.into())))?;
    if params.align && (a.0.is_none() || b.0.is_none()) {
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
    Ok(RawMatches { result, params: text })
}
