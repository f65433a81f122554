//! Studies: the Lab's, with the curves so far and the chart on show, and that of estimated and true trajectories.

use crate::app::document::{LabSet, Side, Trajectories};
use crate::app::{memo::Memo, results::Read, view::View};
use crate::engine::Wanted;
use crate::evaluate::poses::{PairReport, PoseReport, PoseStudy, Projection, SparseModel, Trajectory};
use crate::recover::{Planted, RecoverReport, RecoverStudy};
use crate::requests::{
    BurstSource, ComparedPoses, PosesRequest, ReadTrajectory, StudyRequest, TrajectorySource, Which,
};
use crate::study::{BurstsOfStudy, ChartOfStudy, ShownChart, Study, StudyReport};
use nalgebra::{Isometry3, Vector3};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// The plane is mapped to this many units along its longer side, so that pan and zoom work as they do over a picture.
const PLANE_UNITS: f64 = 1000.0;

/// Points that are drawn of a larger model, evenly spread over its list.
const MOST_POINTS: usize = 20_000;

/// Share of the points beyond each side that the section shown leaves out: those far off are often wrong.
const POINTS_OUTSIDE: f64 = 0.02;

/// Margin around the cameras, as a fraction of the longer side.
const MARGIN: f64 = 0.06;

/// Degrees around and above from which a free view is first seen, so that it shows depth.
pub const ORBIT_BEGINS: [f32; 2] = [30.0, 20.0];

/// Corners of a 4:3 picture of 62° before a camera, in parts of the section shown: models are read without angles.
const FRUSTUM: [[f64; 3]; 4] =
    [[-0.024, -0.018, 0.04], [0.024, -0.018, 0.04], [0.024, 0.018, 0.04], [-0.024, 0.018, 0.04]];

/// A camera as it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    /// Position in plane units, positive downwards.
    pub pos: egui::Pos2,
    /// Corners of a picture before the camera, in its order around, in plane units.
    pub frustum: [egui::Pos2; 4],
    /// Place among the poses of its trajectory.
    pub index: usize,
    /// Place of the true camera, which an estimate without a pair has not.
    pub camera: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaneScene {
    /// Cameras in the order of [`Which::ALL`].
    pub cameras: [Vec<Spot>; 3],
    /// Points of the estimate by their places in the model, in plane units: all, or at most 20 000 of them.
    pub points: Vec<(usize, egui::Pos2)>,
    pub size: (usize, usize),
    /// Plane units for one unit of the truth.
    pub scale: f64,
}

#[derive(Debug, Default)]
pub struct TrajectoryResults {
    pub compared: ComparedPoses,
    /// Camera of the truth, by its place.
    pub hovered: Option<usize>,
    pub reading: Wanted<PosesRequest>,
    /// The scene last drawn, and what it was drawn by.
    pub kept: RefCell<Memo<Trajectories, Arc<PlaneScene>>>,
}

impl TrajectoryResults {
    pub fn request(&self, study: PoseStudy) -> PosesRequest {
        let known = |(path, read)| TrajectorySource { path, read: Some(read) };
        let source = |read: &ReadTrajectory| read.clone().map(known);
        let asked = self.reading.pending().map(|asked| asked.sources.clone());
        PosesRequest { sources: asked.unwrap_or_else(|| self.compared.read.each_ref().map(source)), study }
    }

    pub fn is_empty(&self) -> bool {
        self.compared.read.iter().all(Option::is_none)
    }

    pub fn read(&self, which: Which) -> Option<&Arc<Trajectory>> {
        self.compared.read[which as usize].as_ref().map(|(_, trajectory)| trajectory)
    }

    pub fn report(&self, which: Which) -> Option<&Arc<PoseReport>> {
        self.compared.reports.get(which as usize)?.as_ref()?.as_ref().ok()
    }

    pub fn reports(&self) -> impl Iterator<Item = (Which, &Arc<PoseReport>)> {
        Which::ESTIMATES.into_iter().filter_map(|which| Some((which, self.report(which)?)))
    }

    pub fn pair(&self, which: Which, camera: usize) -> Option<&PairReport> {
        let index = *self.compared.pairs.get(camera)?.get(which as usize)?;
        self.report(which)?.pairs.get(index?)
    }

    pub fn problems(&self) -> impl Iterator<Item = (Which, &String)> {
        let reports = Which::ESTIMATES.into_iter().zip(&self.compared.reports);
        reports.filter_map(|(which, report)| Some((which, report.as_ref()?.as_ref().err()?)))
    }

    pub fn model(&self) -> Option<&SparseModel> {
        self.read(Which::Estimate)?.model.as_ref()
    }

    pub fn scene(&self, set: &Trajectories) -> Arc<PlaneScene> {
        let by = Trajectories { view: View::fit(), selected: None, point: None, ..set.clone() };
        self.kept.borrow_mut().get(by, || Arc::new(PlaneScene::of(&self.compared, set))).clone()
    }
}

impl PlaneScene {
    /// An estimate that cannot be aligned is drawn only without a truth, because its coordinates are different ones; of
    /// two without a truth the first.
    pub fn of(compared: &ComparedPoses, set: &Trajectories) -> Self {
        let [first, _, truth] = compared.read.each_ref().map(|read| read.as_ref().map(|(_, read)| read));
        let report = |of: usize| compared.reports.get(of)?.as_ref()?.as_ref().ok();
        let cameras = [0, 1, 2].map(|of| -> Vec<Isometry3<f64>> {
            let poses = compared.read[of].iter().flat_map(|(_, read)| &read.poses).map(|pose| pose.world_from_camera);
            match report(of) {
                Some(report) => poses.map(|pose| report.truth_from_estimate.apply(&pose)).collect(),
                None if of == 2 || of == 0 && truth.is_none() => poses.collect(),
                None => Vec::new(),
            }
        });
        let model = first.and_then(|estimate| estimate.model.as_ref()).filter(|_| set.points);
        let every = model.map_or(1, |model| model.points.len().div_ceil(MOST_POINTS).max(1));
        let of_model = model.iter().flat_map(|model| model.points.iter().step_by(every).map(|p| p.position));
        let points: Vec<Vector3<f64>> = match report(0) {
            Some(r) => of_model.map(|p| r.truth_from_estimate.place(p)).collect(),
            None if truth.is_none() => of_model.map(Vector3::from).collect(),
            None => Vec::new(),
        };
        // The truth determines the section shown, so that a diverging estimate does not shrink the truth to a point.
        let framed = if truth.is_some() { &cameras[2] } else { &cameras[0] };
        let begin = set.projection.axes(framed);
        let sides = [begin.right, begin.up, begin.ahead()];
        let [across, up, deep] = sides.map(|axis| {
            let mut along: Vec<f64> = points.iter().map(|p| axis.dot(p)).filter(|x| x.is_finite()).collect();
            along.sort_by(f64::total_cmp);
            let outside = (POINTS_OUTSIDE * along.len() as f64) as usize;
            let most = along.into_iter().rev().skip(outside).rev().skip(outside);
            let of_cameras = framed.iter().map(|pose| axis.dot(&pose.translation.vector));
            let finite = of_cameras.filter(|x| x.is_finite()).chain(most);
            finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        });
        let middle = |(low, high): (f64, f64)| if (low + high).is_finite() { 0.5 * (low + high) } else { 0.0 };
        let middle = sides[0] * middle(across) + sides[1] * middle(up) + sides[2] * middle(deep);
        let [across, up, deep] = [across, up, deep].map(|(low, high)| high - low);
        // A free view has the same size and middle from wherever it is seen.
        let (axes, across, up) = if set.projection == Projection::Free {
            let [around, above] = [0, 1].map(|k| f64::from(set.orbit[k] + ORBIT_BEGINS[k]));
            let all = Vector3::new(across, up, deep).norm();
            (begin.turned(around, above), all, all)
        } else {
            (begin, across, up)
        };
        let extent = across.max(up);
        let scale = if extent.is_finite() && extent > 0.0 { PLANE_UNITS / extent } else { 1.0 };
        // Cameras on a line or in one place still get a plane around them.
        let side = |extent: f64| if extent.is_finite() { (extent * scale).max(0.3 * PLANE_UNITS) } else { PLANE_UNITS };
        let margin = 2.0 * MARGIN * PLANE_UNITS;
        let (width, height) = (side(across) + margin, side(up) + margin);
        let place = |p: &Vector3<f64>| {
            let [right, up] = axes.project((p - middle).into());
            egui::pos2((0.5 * width + right * scale) as f32, (0.5 * height - up * scale) as f32)
        };
        let spots = |of: usize| {
            let pairs = report(of).map_or(&[][..], |report| &report.pairs);
            let paired: HashMap<usize, usize> = pairs.iter().map(|pair| (pair.estimate, pair.truth)).collect();
            let spot = |(index, pose): (usize, &Isometry3<f64>)| Spot {
                pos: place(&pose.translation.vector),
                frustum: FRUSTUM.map(|corner| {
                    let corner = pose.rotation * Vector3::from(corner) * (PLANE_UNITS / scale);
                    place(&(pose.translation.vector + corner))
                }),
                index,
                camera: if of == 2 { Some(index) } else { paired.get(&index).copied() },
            };
            cameras[of].iter().enumerate().map(spot).collect()
        };
        Self {
            cameras: [spots(0), spots(1), spots(2)],
            points: (0..).step_by(every).zip(points.iter().map(place)).filter(|(_, p)| p.is_finite()).collect(),
            size: (width.ceil() as usize, height.ceil() as usize),
            scale,
        }
    }
}

#[derive(Debug, Clone)]
pub struct LabResult {
    pub study: Study,
    pub report: StudyReport,
    pub is_whole: bool,
}

#[derive(Debug, Clone)]
pub struct KeptCurves {
    pub name: String,
    pub is_shown: bool,
    pub result: LabResult,
}

#[derive(Debug, Default)]
pub struct Studies {
    pub current: Option<LabResult>,
    pub kept: Vec<KeptCurves>,
    pub shown: Option<ShownChart>,
    pub wanted: Wanted<StudyRequest>,
    pub wanted_chart: Wanted<ChartOfStudy>,
    pub problem: Option<String>,
    pub probe_when_open: Option<(BurstSource, [f32; 2])>,
}

impl Studies {
    pub fn result(&self, set: LabSet) -> Option<&LabResult> {
        match set {
            LabSet::Current => self.current.as_ref(),
            LabSet::Kept(index) => self.kept.get(index).map(|kept| &kept.result),
        }
    }

    pub fn keep_current(&mut self) {
        if let Some(result) = self.current.clone() {
            let name = format!("Kept {}", self.kept.len() + 1);
            self.kept.push(KeptCurves { name, is_shown: true, result });
        }
    }

    pub fn recovered(&self) -> Option<(&RecoverStudy, &RecoverReport)> {
        match (&self.current.as_ref()?.study, &self.current.as_ref()?.report) {
            (Study::Recover(study, _), StudyReport::Recover(report)) => Some((study, report)),
            _ => None,
        }
    }
}

impl<'a> Read<'a> {
    /// The results that are drawn, the newest first, each with the name that its curves have beside their method's.
    pub fn lab_results(self) -> Vec<(LabSet, Option<&'a str>, &'a LabResult)> {
        let Studies { current, kept, .. } = &self.results.studies;
        let current = current.iter().map(|result| (LabSet::Current, None, result));
        let kept = kept.iter().enumerate().filter(|(_, kept)| kept.is_shown);
        let kept = kept.map(|(index, kept)| (LabSet::Kept(index), Some(kept.name.as_str()), &kept.result));
        current.chain(kept).filter(|(.., result)| self.document.lab.question.asks_for(&result.report)).collect()
    }

    pub fn selected_chart(self) -> Option<ChartOfStudy> {
        let (set, point) = self.document.lab.selected?;
        let study = self.results.studies.result(set)?.study.clone();
        let (first, count) = study.seeds()?;
        let seed = first.saturating_add(self.document.lab.selected_chart.min(count.saturating_sub(1)));
        Some(ChartOfStudy { study, point, seed })
    }

    pub fn selected_thing(self) -> Option<&'a Planted> {
        let (seed, id) = self.document.lab.selected_thing?;
        self.results.studies.recovered()?.1.planted.iter().find(|one| (one.seed, one.truth.id) == (seed, id))
    }

    pub fn current_chart(self) -> Option<&'a ShownChart> {
        let wanted = self.selected_chart()?;
        self.results.studies.shown.as_ref().filter(|shown| shown.of == wanted)
    }

    pub fn missing_chart(self) -> Option<ChartOfStudy> {
        self.selected_chart().filter(|_| self.current_chart().is_none())
    }

    pub fn lab_study(self) -> Result<Study, String> {
        let bursts = self.burst_of(Side::A).map(|open| BurstsOfStudy {
            burst: open.burst.clone(),
            second: self.burst_of(Side::B).map(|second| second.burst.clone()),
            truth: None,
        });
        self.document.lab.study(&self.asked(), bursts.as_ref())
    }
}
