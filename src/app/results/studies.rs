//! Studies: the Lab's, with the curves so far and the chart on show, and that of estimated and true trajectories.

use crate::app::document::{LabQuestion, LabSet, Side};
use crate::app::results::Read;
use crate::engine::Wanted;
use crate::evaluate::poses::{PoseReport, PoseStudy, Projection, Trajectory};
use crate::recover::{Planted, RecoverReport, RecoverStudy};
use crate::requests::{BurstSource, ComparedPoses, PosesRequest, StudyRequest, TrajectorySource};
use crate::study::{BurstsOfStudy, ChartOfStudy, ShownChart, Study, StudyReport};
use std::cell::OnceCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The plane is mapped to this many units along its longer side, so that pan and zoom work as they do over a picture.
const PLANE_UNITS: f64 = 1000.0;

/// Points that are drawn of a larger model, evenly spread over its list.
const MOST_POINTS: usize = 20_000;

/// Share of the points beyond each side that the section shown leaves out: those far off are often wrong.
const POINTS_OUTSIDE: f64 = 0.02;

/// Margin around the cameras, as a fraction of the longer side.
const MARGIN: f64 = 0.06;

#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    /// Position in plane units, positive downwards.
    pub pos: egui::Pos2,
    pub index: usize,
    pub pair: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaneScene {
    pub truth: Vec<Spot>,
    pub estimate: Vec<Spot>,
    /// Points of the estimate, in plane units: all, or at most 20 000 of them.
    pub points: Vec<egui::Pos2>,
    pub size: (usize, usize),
    /// Plane units for one unit of the truth.
    pub scale: f64,
}

#[derive(Debug, Default)]
pub struct TrajectoryResults {
    pub compared: ComparedPoses,
    pub hovered: Option<usize>,
    pub reading: Wanted<PosesRequest>,
    /// Without and with points.
    pub scenes: [OnceCell<[Arc<PlaneScene>; Projection::ALL.len()]>; 2],
}

impl TrajectoryResults {
    pub fn request(&self, study: PoseStudy) -> PosesRequest {
        let source = |read: &ReadModel| read.clone().map(|(path, trajectory)| TrajectorySource::Read(path, trajectory));
        match self.reading.pending() {
            Some(asked) => PosesRequest { study, ..asked.clone() },
            None => {
                PosesRequest { estimate: source(&self.compared.estimate), truth: source(&self.compared.truth), study }
            }
        }
    }

    pub fn is_empty(&self) -> bool {
        self.compared.estimate.is_none() && self.compared.truth.is_none()
    }

    pub fn report(&self) -> Option<&Arc<PoseReport>> {
        self.compared.report.as_ref()?.as_ref().ok()
    }

    pub fn problem(&self) -> Option<&str> {
        self.compared.report.as_ref()?.as_ref().err().map(String::as_str)
    }

    /// Whether the estimate is a sparse model, which has points.
    pub fn has_points(&self) -> bool {
        self.compared.estimate.as_ref().is_some_and(|(_, estimate)| estimate.model.is_some())
    }

    pub fn scene(&self, projection: Projection, points: bool) -> Arc<PlaneScene> {
        let made = || Projection::ALL.map(|projection| Arc::new(PlaneScene::of(&self.compared, projection, points)));
        self.scenes[usize::from(points)].get_or_init(made)[projection as usize].clone()
    }
}

pub type ReadModel = Option<(PathBuf, Arc<Trajectory>)>;

impl PlaneScene {
    /// An estimate that cannot be aligned is drawn only without a truth, because its coordinates are different ones.
    pub fn of(compared: &ComparedPoses, projection: Projection, with_points: bool) -> Self {
        let report = compared.report.as_ref().and_then(|r| r.as_ref().ok());
        let centres = |trajectory: &Trajectory, move_to: &dyn Fn(&nalgebra::Isometry3<f64>) -> [f64; 3]| {
            trajectory.poses.iter().map(|p| move_to(&p.world_from_camera)).collect::<Vec<_>>()
        };
        let as_it_is = |pose: &nalgebra::Isometry3<f64>| -> [f64; 3] { pose.translation.vector.into() };
        let truth = compared.truth.as_ref().map_or_else(Vec::new, |(_, t)| centres(t, &as_it_is));
        let estimate = match (&compared.estimate, report) {
            (Some((_, e)), Some(r)) => centres(e, &|pose| r.truth_from_estimate.apply(pose).translation.vector.into()),
            (Some((_, e)), None) if truth.is_empty() => centres(e, &as_it_is),
            _ => Vec::new(),
        };
        let model = compared.estimate.as_ref().and_then(|(_, e)| e.model.as_ref()).filter(|_| with_points);
        let every = model.map_or(1, |model| model.points.len().div_ceil(MOST_POINTS).max(1));
        let of_model = model.iter().flat_map(|model| model.points.iter().step_by(every).map(|p| p.position));
        let points: Vec<[f64; 3]> = match report {
            Some(r) => of_model.map(|p| r.truth_from_estimate.place(p).into()).collect(),
            None if truth.is_empty() => of_model.collect(),
            None => Vec::new(),
        };
        let axes = projection.axes(if truth.is_empty() { &estimate } else { &truth });
        let pairs = report.map_or(&[][..], |r| &r.pairs);
        let of_truth: HashMap<usize, usize> = pairs.iter().enumerate().map(|(k, p)| (p.truth, k)).collect();
        let of_estimate: HashMap<usize, usize> = pairs.iter().enumerate().map(|(k, p)| (p.estimate, k)).collect();
        let [truth, estimate, points] =
            [truth, estimate, points].map(|places| places.into_iter().map(|p| axes.project(p)).collect::<Vec<_>>());
        // The truth determines the section shown, so that a diverging estimate does not shrink the truth to a point.
        let framed = if truth.is_empty() { &estimate } else { &truth };
        let range = |k: usize| {
            let mut along: Vec<f64> = points.iter().map(|p| p[k]).filter(|x| x.is_finite()).collect();
            along.sort_by(f64::total_cmp);
            let outside = (POINTS_OUTSIDE * along.len() as f64) as usize;
            let most = along.into_iter().rev().skip(outside).rev().skip(outside);
            let finite = framed.iter().map(|p| p[k]).filter(|x| x.is_finite()).chain(most);
            finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let ((left, right), (down, up)) = (range(0), range(1));
        let extent = (right - left).max(up - down);
        let scale = if extent.is_finite() && extent > 0.0 { PLANE_UNITS / extent } else { 1.0 };
        // Cameras on a line or in one place still get a plane around them.
        let side = |extent: f64| if extent.is_finite() { (extent * scale).max(0.3 * PLANE_UNITS) } else { PLANE_UNITS };
        let margin = 2.0 * MARGIN * PLANE_UNITS;
        let (width, height) = (side(right - left) + margin, side(up - down) + margin);
        let middle = |low: f64, high: f64| if (low + high).is_finite() { 0.5 * (low + high) } else { 0.0 };
        let (mid_right, mid_up) = (middle(left, right), middle(down, up));
        let place = |p: &[f64; 2]| {
            let (x, y) = (0.5 * width + (p[0] - mid_right) * scale, 0.5 * height - (p[1] - mid_up) * scale);
            egui::pos2(x as f32, y as f32)
        };
        let spots = |flat: &[[f64; 2]], pair_of: &HashMap<usize, usize>| {
            let spot =
                |(index, p): (usize, &[f64; 2])| Spot { pos: place(p), index, pair: pair_of.get(&index).copied() };
            flat.iter().enumerate().map(spot).collect()
        };
        Self {
            truth: spots(&truth, &of_truth),
            estimate: spots(&estimate, &of_estimate),
            points: points.iter().filter(|p| p[0].is_finite() && p[1].is_finite()).map(place).collect(),
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

    /// The results that are drawn, the newest first, each with the name that its curves have beside their method's.
    pub fn shown_results(&self, question: LabQuestion) -> Vec<(LabSet, Option<&str>, &LabResult)> {
        let current = self.current.iter().map(|result| (LabSet::Current, None, result));
        let kept = self.kept.iter().enumerate().filter(|(_, kept)| kept.is_shown);
        let kept = kept.map(|(index, kept)| (LabSet::Kept(index), Some(kept.name.as_str()), &kept.result));
        current.chain(kept).filter(|(.., result)| question.asks_for(&result.report)).collect()
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
    pub fn lab_results(self) -> Vec<(LabSet, Option<&'a str>, &'a LabResult)> {
        self.results.studies.shown_results(self.document.lab.question)
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
