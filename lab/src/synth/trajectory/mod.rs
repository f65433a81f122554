//! Trajectories: bursts of a camera that moves past a scene, with the complete truth for a reconstruction.
//!
//! The scene is a wall and, before it at several depths, boards: [planes](ScenePlane) with textures that have structure
//! at every scale. A pinhole camera ([`Lens`]) takes a burst at each of its stations while it moves on at constant
//! speed. Every frame is drawn from the camera's pose in it, so that apparent motion follows from depth alone. Then a
//! [`Camera`] captures the frames in the requested light.
//!
//! The truth is the lens, each mid-burst's pose, each burst's motion, the planes, and the noise-free view at mid-burst,
//! the gold standard. [`write_trajectory`] writes it beside the bursts, completely or not at all.

mod leaves;
pub mod world;

pub use world::{BurstCamera, Lens, ScenePlane, Shake};

use super::noisy::{CLEARANCE_SIGMAS, FrameLevels, NoisyExposure};
use crate::synth::write::{frame_name, io, write_file, write_folder, write_frame, write_json};
use burstscope_core::error::{Error, Result};
use burstscope_core::monitor::{Cancelled, Monitor, Stage};
use burstscope_core::synth::noise::{Camera, quantisation_step};
#[cfg(feature = "cli")]
use burstscope_core::synth::options::motions;
use burstscope_core::synth::{Motion, check_common, truth::NoiseTruth};
use burstscope_core::{burst::Burst, files::mark::OutputKind, plane::Plane};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Amount of light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Per-pixel signal-to-noise ratio of a frame: the standard deviation of all pixels of the scene over that of the
    /// noise at their mean, as [`super::noisy`] defines it; infinite for no noise.
    Snr(f64),
    /// Electrons at scene white, the brightest painted value; infinite for no noise.
    Electrons(f64),
}

impl Default for Light {
    fn default() -> Self {
        Self::Snr(0.3)
    }
}

/// Parameters of a trajectory.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct TrajectoryParams {
    /// Columns.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().width))]
    pub width: usize,
    /// Rows.
    #[cfg_attr(feature = "cli", arg(long, value_name = "PIXELS", default_value_t = Self::default().height))]
    pub height: usize,
    /// Number of bursts.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().bursts))]
    pub bursts: usize,
    /// Number of frames of each burst.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().frames))]
    pub frames: usize,
    /// Number of planes; the farthest fills the frame.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().planes))]
    pub planes: usize,
    /// How the camera goes: 1d is sideways, so that everything moves horizontally; 2d is forward and sideways.
    #[cfg_attr(feature = "cli", arg(long, value_name = "DIRECTIONS", default_value = "1d", value_parser = motions()))]
    pub motion: Motion,
    /// Largest apparent motion on an axis, pixels per frame; the camera's speed is chosen for it.
    #[cfg_attr(feature = "cli", arg(long, value_name = "SLOPE", default_value_t = Self::default().max_slope))]
    pub max_slope: f64,
    /// Degrees by which the camera turns during a burst, about, unevenly and about all axes; its orientation in each
    /// frame is then in the burst's rotations.txt.
    #[cfg_attr(feature = "cli", arg(long = "shake", value_name = "DEGREES", default_value_t = Self::default().shake_deg))]
    pub shake_deg: f64,
    /// Amount of light.
    #[cfg_attr(feature = "cli", arg(skip))]
    pub light: Light,
    /// Standard deviation of the read noise, electrons.
    #[cfg_attr(feature = "cli", arg(long, value_name = "ELECTRONS", default_value_t = Self::default().read_noise))]
    pub read_noise: f64,
    /// Bits of the camera's converter.
    #[cfg_attr(feature = "cli", arg(long, value_name = "BITS", default_value_t = Self::default().bits))]
    pub bits: u32,
    /// Seed: the same seed makes the same scene, way and noise on every machine.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = Self::default().seed))]
    pub seed: u64,
}

impl Default for TrajectoryParams {
    /// Eight bursts of ten 640×480 frames, a wall and boards at three depths, sideways up to 3 px/frame, SNR 0.3.
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            bursts: 8,
            frames: 10,
            planes: 4,
            motion: Motion::OneD,
            max_slope: 3.0,
            shake_deg: 0.0,
            light: Light::default(),
            read_noise: 2.0,
            bits: 12,
            seed: 1,
        }
    }
}

const FOCAL_SHARE: f64 = 0.9;
/// Electrons at full scale at the highest gain, in the dark: 8 levels of 12 bits an electron; more light, less gain.
const DARK_FULL_SCALE_ELECTRONS: f64 = 512.0;
/// Signal of scene white in the noise-free views at mid-burst, fraction of full scale.
pub const GOLD_WHITE: f64 = 0.9;

/// A scene, the camera's path past it, and its exposure.
#[derive(Debug, Clone)]
pub struct Trajectory {
    params: TrajectoryParams,
    /// The lens.
    pub lens: Lens,
    /// The planes of the scene, far to near.
    pub planes: Vec<ScenePlane>,
    /// Camera of each burst.
    pub cameras: Vec<BurstCamera>,
    /// Minimum and maximum apparent motion of each burst on the axes u and v, pixels per frame.
    pub slopes: Vec<[[f64; 2]; 2]>,
    /// Sensor of the camera, and the signal of scene white.
    pub exposure: NoisyExposure,
    /// Per-pixel signal-to-noise ratio as [`Light::Snr`] defines it; infinite for no noise.
    pub snr: f64,
    /// Electrons at scene white; infinite for no noise.
    pub electrons: f64,
}

impl TrajectoryParams {
    fn check(&self) -> Result<()> {
        check_common(
            self.width,
            self.height,
            (self.frames, self.frames as f64 - 1.0),
            self.max_slope,
            self.read_noise,
            self.bits,
        )?;
        if !(1..=1000).contains(&self.bursts) {
            return Err(Error::param("bursts", format!("{} bursts", self.bursts), "give 1 to 1000"));
        }
        if !(1..=16).contains(&self.planes) {
            return Err(Error::param("planes", format!("{} planes", self.planes), "give 1 to 16"));
        }
        if !(0.0..=10.0).contains(&self.shake_deg) {
            return Err(Error::param("shake", format!("{} degrees", self.shake_deg), "give 0 to 10"));
        }
        let (name, value) = match self.light {
            Light::Snr(snr) => ("snr", snr),
            Light::Electrons(electrons) => ("electrons", electrons),
        };
        if value.is_nan() || value <= 0.0 {
            return Err(Error::param(name, format!("{value}"), "give a number above 0, or inf for no noise"));
        }
        Ok(())
    }

    /// Variance of the read noise and of rounding at the highest gain, electrons².
    fn dark_variance(&self) -> f64 {
        self.read_noise.powi(2) + (DARK_FULL_SCALE_ELECTRONS * quantisation_step(self.bits)).powi(2) / 12.0
    }

    /// Electrons at scene white, and the signal-to-noise ratio, for a scene of these levels.
    fn light(&self, levels: &FrameLevels) -> (f64, f64) {
        let (mean, contrast, dark) = (levels.mean(), levels.standard_deviation(), self.dark_variance());
        match self.light {
            Light::Electrons(e) if e.is_infinite() => (e, f64::INFINITY),
            Light::Snr(snr) if snr.is_infinite() => (f64::INFINITY, snr),
            Light::Electrons(e) => (e, contrast * e / (mean * e + dark).sqrt()),
            // The positive solution e of contrast²·e² = snr²·(mean·e + dark).
            Light::Snr(snr) => {
                let (a, b, c) = (contrast.powi(2), snr.powi(2) * mean, snr.powi(2) * dark);
                ((b + (b * b + 4.0 * a * c).sqrt()) / (2.0 * a), snr)
            }
        }
    }

    fn exposure(&self, electrons: f64, levels: &FrameLevels) -> NoisyExposure {
        let min_black = 1.0 / 64.0;
        if electrons.is_infinite() {
            let gain = GOLD_WHITE;
            return NoisyExposure { gain, camera: Camera::noiseless(min_black), mean_signal: gain * levels.mean() };
        }
        let brightest = levels.max() * electrons;
        let sigmas = (brightest + self.read_noise.powi(2)).sqrt() + self.read_noise;
        // Both ends need room for the noise: the brightest pixel below white, and black above 0.
        let needed = (brightest + CLEARANCE_SIGMAS * sigmas) / (1.0 - min_black);
        let full_scale_electrons = needed.max(DARK_FULL_SCALE_ELECTRONS);
        let (read_noise_electrons, bits) = (self.read_noise, Some(self.bits));
        let mut camera = Camera { full_scale_electrons, read_noise_electrons, black_level: 0.0, bits };
        camera.black_level = (CLEARANCE_SIGMAS * camera.sigma(0.0)).max(min_black);
        // In the dark scene white stays far below full scale: the gain rises no further.
        let gain = electrons / full_scale_electrons;
        NoisyExposure { gain, camera, mean_signal: gain * levels.mean() }
    }
}

impl Trajectory {
    /// Lays out and paints the scene, computes the camera's path and its exposure.
    ///
    /// # Errors
    /// A parameter that makes no sense, or cancellation.
    pub fn new(params: &TrajectoryParams, monitor: &Monitor) -> Result<Self> {
        params.check()?;
        monitor.report(Stage::Synth, 0.0);
        let lens = Lens { width: params.width, height: params.height, focal_px: FOCAL_SHARE * params.width as f64 };
        // In this order: sheets have to be large enough for the path, and speeds follow from the depths in view.
        let stations = world::stations(params);
        let planes = world::planes(params, &lens, &stations, monitor)?;
        let camera = |station| world::burst_camera(params, &lens, &planes, station, monitor);
        let (mut cameras, slopes): (Vec<_>, Vec<_>) = stations.iter().map(camera).collect::<Result<_, Cancelled>>()?;
        // Slopes are those of the way alone.
        for (index, camera) in cameras.iter_mut().enumerate() {
            camera.shake = world::Shake::of(params, index);
        }
        let mut levels = FrameLevels::default();
        // The light is set from all views together, so that one exposure serves the whole trajectory.
        for camera in &cameras {
            let view = world::render(&planes, &lens, &camera.world_from_camera, monitor)?;
            levels.add(&Burst::from_planes("view", vec![view]), monitor)?;
        }
        let (electrons, snr) = params.light(&levels);
        let exposure = params.exposure(electrons, &levels);
        Ok(Self { params: params.clone(), lens, planes, cameras, slopes, exposure, snr, electrons })
    }

    /// The name of burst `index`, for its folder and its views.
    pub fn name(index: usize) -> String {
        format!("burst_{index:03}")
    }

    /// The view of burst `index` at mid-burst without noise; scene white is [`GOLD_WHITE`] of full scale.
    ///
    /// # Panics
    /// When there are not that many bursts.
    pub fn gold(&self, index: usize, monitor: &Monitor) -> Result<Plane, Cancelled> {
        let mut view = world::render(&self.planes, &self.lens, &self.cameras[index].world_from_camera, monitor)?;
        view.data_mut().iter_mut().for_each(|x| *x = (GOLD_WHITE * f64::from(*x)).clamp(0.0, 1.0) as f32);
        Ok(view)
    }

    /// Burst `index` as the camera captures it; each frame has its own random stream, whatever the threads.
    ///
    /// # Panics
    /// When there are not that many bursts.
    pub fn burst(&self, index: usize, monitor: &Monitor) -> Result<Burst, Cancelled> {
        let (frames, camera) = (self.params.frames, self.cameras[index]);
        let t0 = (frames as f64 - 1.0) / 2.0;
        let drawn: Vec<Plane> = (0..frames)
            .into_par_iter()
            .map(|t| world::render(&self.planes, &self.lens, &camera.at(t as f64 - t0), monitor))
            .collect::<Result<_, Cancelled>>()?;
        let signal = Burst::from_planes(Self::name(index), drawn);
        self.exposure.capture(&signal, self.params.seed, 1 + (index * frames) as u64, monitor)
    }

    /// The truth, without pictures, poses and lens.
    pub fn truth(&self) -> TrajectoryTruth {
        let params = &self.params;
        let bursts = self.cameras.iter().zip(&self.slopes).enumerate().map(|(index, (camera, [u, v]))| BurstTruth {
            name: Self::name(index),
            world_from_camera: camera.tum(),
            step: camera.step.into(),
            slope_u: *u,
            slope_v: *v,
        });
        let planes = self.planes.iter().map(|plane| PlaneTruth {
            name: plane.name.clone(),
            origin: plane.origin.coords.into(),
            right: plane.right.into(),
            down: plane.down.into(),
        });
        let NoisyExposure { gain, camera, mean_signal } = &self.exposure;
        TrajectoryTruth {
            width: params.width,
            height: params.height,
            frames: params.frames,
            t0: (params.frames as f64 - 1.0) / 2.0,
            seed: params.seed,
            max_slope: params.max_slope,
            camera_params: self.lens.colmap_params(),
            electrons_at_white: self.electrons.is_finite().then_some(self.electrons),
            noise: NoiseTruth::of(camera, *mean_signal, Some(self.snr)),
            black_level: camera.black_level,
            white: *gain,
            gold_white: GOLD_WHITE,
            planes: planes.collect(),
            bursts: bursts.collect(),
        }
    }
}

/// Truth of a trajectory without pictures, poses and lens: its `trajectory.json`. Metres; slopes in px/frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // where a name says it
pub struct TrajectoryTruth {
    pub width: usize,
    pub height: usize,
    /// Number of frames of a burst, N.
    pub frames: usize,
    /// Reference time, (N − 1)/2, in frames.
    pub t0: f64,
    pub seed: u64,
    /// Largest apparent motion on an axis.
    pub max_slope: f64,
    /// fx, fy, cx, cy in COLMAP's convention: the centre of the first pixel is (0.5, 0.5).
    pub camera_params: [f64; 4],
    /// Electrons at scene white; `None` (null) for noiseless bursts.
    pub electrons_at_white: Option<f64>,
    /// The camera's noise, at the mean of the signal; `None` (null) for noiseless bursts.
    pub noise: Option<NoiseTruth>,
    /// Pedestal under all values, fraction of full scale.
    pub black_level: f64,
    /// Signal of scene white above black in the frames, fraction of full scale.
    pub white: f64,
    /// Signal of scene white in the views at mid-burst without noise, which have no pedestal.
    pub gold_white: f64,
    /// Planes of the scene, far to near.
    pub planes: Vec<PlaneTruth>,
    pub bursts: Vec<BurstTruth>,
}

/// Truth of a plane of the scene: its pixel (p, q) is at origin + p·right + q·down in the world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneTruth {
    /// Name of its content.
    pub name: String,
    /// Position of its pixel (0, 0).
    pub origin: [f64; 3],
    /// Step of one pixel to the right.
    pub right: [f64; 3],
    /// Step of one pixel down.
    pub down: [f64; 3],
}

/// Truth of a burst of a trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BurstTruth {
    /// Name of its folder.
    pub name: String,
    /// `tx ty tz qx qy qz qw` of the camera in the world at mid-burst.
    pub world_from_camera: [f64; 7],
    /// Motion of the camera from one frame to the next, in the world; it turns only where it shakes.
    pub step: [f64; 3],
    /// Minimum and maximum apparent motion to the right.
    pub slope_u: [f64; 2],
    /// Minimum and maximum apparent motion down.
    pub slope_v: [f64; 2],
}

/// Writes a trajectory into the folder `dir`, which is created: `bursts/NAME/frame_000.png` … (16 bit), `gold/NAME.png`
/// (the views at mid-burst without noise, 16 bit), `bursts/NAME/rotations.txt` of a camera that shakes, `poses.txt`
/// (lines `timestamp tx ty tz qx qy qz qw`: the burst's number, the camera in the world at mid-burst), `lens.toml` (the
/// camera) and `trajectory.json` (the truth). An earlier trajectory in `dir` is replaced as a whole; a folder that
/// holds anything else is left unchanged.
///
/// # Errors
/// The folder is a link, holds other files or cannot be written, or cancellation; it is then unchanged.
pub fn write_trajectory(dir: &Path, trajectory: &Trajectory, monitor: &Monitor) -> Result<()> {
    write_folder(dir, OutputKind::Trajectory, |fresh| {
        let make = |folder: &Path| std::fs::create_dir(folder).map_err(io(folder));
        let (bursts, gold) = (fresh.join("bursts"), fresh.join("gold"));
        make(&bursts)?;
        make(&gold)?;
        let count = trajectory.cameras.len();
        for index in 0..count {
            let name = Trajectory::name(index);
            let folder = bursts.join(&name);
            make(&folder)?;
            // One burst after the other: a dataset need not fit into memory.
            let burst = trajectory.burst(index, monitor)?;
            for (t, frame) in burst.frames.iter().enumerate() {
                monitor.check()?;
                write_frame(&folder.join(frame_name(t)), frame)?;
            }
            if trajectory.params.shake_deg > 0.0 {
                write_file(&folder.join("rotations.txt"), rotations(trajectory, index))?;
            }
            write_frame(&gold.join(format!("{name}.png")), &trajectory.gold(index, monitor)?)?;
            monitor.report(Stage::Write, (index + 1) as f32 / count as f32);
        }
        write_json(&fresh.join("trajectory.json"), &trajectory.truth())?;
        write_file(&fresh.join("poses.txt"), poses(trajectory))?;
        write_file(&fresh.join("lens.toml"), trajectory.lens.to_toml())?;
        Ok(monitor.check()?)
    })
}

fn rotations(trajectory: &Trajectory, burst: usize) -> String {
    let mut text = String::from("# qx qy qz qw: orientation of the camera in the world, a line a frame\n");
    let frames = trajectory.params.frames;
    for t in 0..frames {
        let turn = trajectory.cameras[burst].at(t as f64 - 0.5 * (frames as f64 - 1.0)).rotation;
        text += &format!("{} {} {} {}\n", turn.i, turn.j, turn.k, turn.w);
    }
    text
}

fn poses(trajectory: &Trajectory) -> String {
    let mut text = String::from(
        "# timestamp tx ty tz qx qy qz qw: the burst's number, the camera in the world at mid-burst, metres\n",
    );
    for (index, camera) in trajectory.cameras.iter().enumerate() {
        let [tx, ty, tz, qx, qy, qz, qw] = camera.tum();
        text += &format!("{index} {tx} {ty} {tz} {qx} {qy} {qz} {qw}\n");
    }
    text
}
