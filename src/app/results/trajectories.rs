//! Estimated and true trajectory, as plain values.

use crate::app::document::datasets::{Trajectories, Which};
use crate::app::results::{Effect, Model};
use crate::app::view::View;
use crate::engine::{Ended, Engine, Wanted};
use crate::evaluate::poses::{DEMO_ESTIMATE, DEMO_TRUTH, PoseReport, PoseStudy, Projection, Trajectory};
use crate::requests::{ComparedPoses, PosesRequest, TrajectorySource};
use crate::teach::Workspace;
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
    scenes: [OnceCell<[Arc<PlaneScene>; Projection::ALL.len()]>; 2],
}

impl TrajectoryResults {
    fn request(&self, study: PoseStudy) -> PosesRequest {
        let source = |read: &Read| read.clone().map(|(path, trajectory)| TrajectorySource::Read(path, trajectory));
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

impl Model {
    pub fn open_trajectory(&mut self, which: Which, path: PathBuf, engine: &Engine) {
        let (set, poses) = (&mut self.document.trajectories, &mut self.results.poses);
        let mut request = poses.request(set.study);
        let (of_set, of_request) = match which {
            Which::Estimate => (&mut set.estimate, &mut request.estimate),
            Which::Truth => (&mut set.truth, &mut request.truth),
        };
        *of_request = Some(TrajectorySource::Path(path.clone()));
        *of_set = Some(path);
        poses.reading.ask(engine, request);
        self.document.workspace = Workspace::Trajectories;
    }

    pub(in crate::app) fn set_pose_study(&mut self, study: PoseStudy, engine: &Engine) {
        self.document.trajectories.study = study;
        let request = self.results.poses.request(study);
        self.results.poses.reading.ask(engine, request);
    }

    pub fn close_trajectories(&mut self) {
        let Trajectories { study, projection, points, .. } = self.document.trajectories;
        self.document.trajectories = Trajectories { study, projection, points, ..Trajectories::default() };
        self.results.poses = TrajectoryResults::default();
    }

    /// Takes the answers. Other trajectories than before reset pan and zoom; where one cannot be read, those that are
    /// open stay.
    pub(super) fn take_trajectories(&mut self, ended: Ended<PosesRequest>) -> Vec<Effect> {
        const TITLE: &str = "Trajectories";
        let (set, before) = (&mut self.document.trajectories, &self.results.poses.compared);
        match ended.result {
            Ok(compared) => {
                self.messages.resolved(TITLE);
                let is_other = |before: &Read, now: &Read| match (before, now) {
                    (Some((_, before)), Some((_, now))) => !Arc::ptr_eq(before, now),
                    (before, now) => before.is_some() && now.is_none(),
                };
                if is_other(&before.estimate, &compared.estimate) || is_other(&before.truth, &compared.truth) {
                    set.view = View::fit();
                }
                set.selected = None;
                let reading = std::mem::take(&mut self.results.poses.reading);
                self.results.poses = TrajectoryResults { compared, reading, ..TrajectoryResults::default() };
            }
            Err(error) => {
                let path = |read: &Read| read.as_ref().map(|(path, _)| path.clone());
                (set.estimate, set.truth) = (path(&before.estimate), path(&before.truth));
                self.messages.error(TITLE, error.to_string());
            }
        }
        Vec::new()
    }

    /// Shows the built-in cameras and points beside the true cameras.
    pub(in crate::app) fn show_demo_cameras(&mut self, engine: &Engine) {
        let [estimate, truth] = [DEMO_ESTIMATE, DEMO_TRUTH].map(|name| Some(PathBuf::from(name)));
        let (points, projection) = (true, Projection::Xz);
        self.document.trajectories = Trajectories { estimate, truth, points, projection, ..Trajectories::default() };
        self.read_trajectories(engine);
    }

    /// Reads the trajectories of the document.
    pub(in crate::app) fn read_trajectories(&mut self, engine: &Engine) {
        self.results.poses = TrajectoryResults::default();
        let Trajectories { estimate, truth, study, .. } = self.document.trajectories.clone();
        let [estimate, truth] = [estimate, truth].map(|path| path.map(TrajectorySource::Path));
        if estimate.is_some() || truth.is_some() {
            self.results.poses.reading.ask(engine, PosesRequest { estimate, truth, study });
        }
    }
}

type Read = Option<(PathBuf, Arc<Trajectory>)>;

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
