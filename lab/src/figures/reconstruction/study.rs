//! The trajectories, the methods, and their runs.

use super::mapper::{self, Matched, Reconstructed, Run};
use crate::evaluate::{BurstMethod, MatchStudy, Searches, Shot, motion_name};
use crate::figures::{FigureSize, record::Pieces};
use crate::synth::{Light, Motion, Trajectory, TrajectoryParams};
use burstscope_core::matching::{MatchParams, PairSelection};
use burstscope_core::monitor::{Cancelled, Monitor, Stage};
use burstscope_core::{burst::Burst, error::Result, plane::Plane};
use std::path::Path;
use std::time::{Duration, Instant};

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Study {
    /// Parameters of the trajectories; motion and seed are set by the study.
    pub way: TrajectoryParams,
    /// Number of trajectories of each motion, with seeds from 1.
    pub seeds: u64,
    pub searches: Searches,
    pub matching: MatchParams,
}

/// A trajectory with its pictures, drawn once for all methods.
struct Drawn {
    way: Trajectory,
    bursts: Vec<Burst>,
    gold: Vec<Plane>,
}

impl Study {
    pub fn new(size: FigureSize) -> Self {
        let full = TrajectoryParams { light: Light::Snr(0.3), ..TrajectoryParams::default() };
        let quick =
            TrajectoryParams { width: 200, height: 150, bursts: 3, frames: 6, light: Light::Snr(0.8), ..full.clone() };
        Self {
            way: size.pick(full, quick),
            seeds: size.pick(2, 1),
            searches: Searches::default(),
            // As the paper matches.
            matching: MatchParams { predict: false, align: false, ..MatchParams::default() },
        }
    }

    /// The methods for a motion, in the order of the tables; BuFF 1D searches one direction, so for motion in one only.
    pub fn methods(motion: Motion) -> Vec<BurstMethod> {
        let burst = [BurstMethod::SiftFrame, BurstMethod::SiftMerge, BurstMethod::Buff1d, BurstMethod::Buff2d];
        let is_meant = |method: &BurstMethod| motion == Motion::OneD || *method != BurstMethod::Buff1d;
        let of_bursts = burst.into_iter().filter(is_meant).chain([BurstMethod::BuffAuto]);
        std::iter::once(BurstMethod::Gold).chain(of_bursts).collect()
    }

    fn way(&self, motion: Motion, seed: u64) -> TrajectoryParams {
        TrajectoryParams { motion, seed, ..self.way.clone() }
    }

    /// The runs: stored ones unchanged, the others made now and stored.
    pub fn runs(&self, pieces: &Pieces, colmap: Option<&Path>, monitor: &Monitor) -> Result<Vec<Run>> {
        let ways: Vec<(Motion, u64)> = [Motion::OneD, Motion::TwoD]
            .into_iter()
            .flat_map(|m| (1..=self.seeds).map(move |seed| (m, seed)))
            .collect();
        let total: usize = ways.iter().map(|(motion, _)| Self::methods(*motion).len()).sum();
        let mut runs = Vec::with_capacity(total);
        for (motion, seed) in ways {
            let params = self.way(motion, seed);
            let truth_piece = format!("way-{}-{seed}", motion_name(motion));
            // Drawing takes long and serves all methods: it waits until a result is missing.
            let mut drawn: Option<Drawn> = None;
            let true_centres: Vec<[f64; 3]> = pieces.kept_or(&truth_piece, &format!("{params:?}"), || {
                let way = &Drawn::of(&mut drawn, &params, monitor)?.way;
                Ok(way.cameras.iter().map(|camera| camera.world_from_camera.translation.vector.into()).collect())
            })?;
            for method in Self::methods(motion) {
                monitor.report(Stage::Evaluate, runs.len() as f32 / total as f32);
                let name = format!("{}-{}-{seed}", method.name(), motion_name(motion));
                // A piece counts only for the settings that made it.
                let settings = format!("{method:?} {params:?} {self:?}");
                let matched: Matched = pieces.kept_or(&name, &settings, || {
                    self.matched(method, Drawn::of(&mut drawn, &params, monitor)?, monitor)
                })?;
                // Apart from the matches, so that these stay when COLMAP is installed later.
                let reconstruct = |program: &Path| {
                    pieces.kept_or(&format!("colmap-{name}"), &settings, || {
                        let way = &Drawn::of(&mut drawn, &params, monitor)?.way;
                        let folder = pieces.temporary()?;
                        let how = (&self.searches, &self.matching, method);
                        mapper::reconstruct(program, how, way, &folder.new_path(), monitor)
                    })
                };
                let reconstructed: Option<Reconstructed> = colmap.map(reconstruct).transpose()?;
                let bursts = params.bursts;
                let true_centres = true_centres.clone();
                runs.push(Run { motion, seed, method, bursts, matched, reconstructed, true_centres });
            }
        }
        Ok(runs)
    }

    /// Finds the features of all bursts by `method` and matches every pair.
    fn matched(&self, method: BurstMethod, drawn: &Drawn, monitor: &Monitor) -> Result<Matched> {
        let (methods, has_gold, pairs) = (vec![method], method == BurstMethod::Gold, PairSelection::default());
        let (searches, matching) = (self.searches.clone(), self.matching.clone());
        let study = MatchStudy { methods, has_gold, searches, matching, pairs, truth: None };
        let names: Vec<String> = (0..drawn.bursts.len()).map(Trajectory::name).collect();
        // The frames are drawn already: only finding and matching features is timed.
        let started = Instant::now();
        let open = |k: usize, shot: Shot| -> Result<Burst> {
            Ok(match shot {
                Shot::Burst => drawn.bursts[k].clone(),
                Shot::Gold => Burst::from_planes("gold", vec![drawn.gold[k].clone()]),
            })
        };
        let report = study.run(&names, open, &monitor.silent())?;
        let seconds = started.elapsed().max(Duration::from_millis(1)).as_secs_f64();
        let counts = &report.methods[0].counts;
        Ok(Matched {
            keypoints: counts.keypoints_per_image,
            putative: counts.putative_per_image,
            inliers: counts.inliers_per_image,
            match_ratio: counts.match_ratio,
            match_score: counts.match_score,
            inlier_ratio: counts.inlier_ratio,
            seconds,
        })
    }
}

impl Drawn {
    fn new(params: &TrajectoryParams, monitor: &Monitor) -> Result<Self> {
        let silent = monitor.silent();
        let way = Trajectory::new(params, &silent)?;
        let bursts = (0..params.bursts).map(|k| way.burst(k, &silent)).collect::<Result<_, Cancelled>>()?;
        let gold = (0..params.bursts).map(|k| way.gold(k, &silent)).collect::<Result<_, Cancelled>>()?;
        Ok(Self { way, bursts, gold })
    }

    /// The trajectory, drawn at the first call.
    fn of<'a>(drawn: &'a mut Option<Self>, params: &TrajectoryParams, monitor: &Monitor) -> Result<&'a Self> {
        if drawn.is_none() {
            *drawn = Some(Self::new(params, monitor)?);
        }
        Ok(drawn.as_ref().expect("it was drawn just now"))
    }
}
