//! Open bursts, and how they are opened.

use super::{BurstSource, JobError, PossibleShape};
use crate::burst::{Burst, Dump, LikelyShape, Limits, OpenOptions, find_bursts, likely_shapes, shape_of};
use crate::dataset::{BurstPicture, camera::read_camera};
use crate::detector::view::coarse_frames;
use crate::error::{Error, ErrorKind};
use crate::inspect::result::{has_truth, truth_of};
use crate::inspect::words::counted;
use crate::matching::Camera;
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::synth::{Truth, synth_chart};
use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// Identifies one opening of a burst: opening the same files again gives another id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BurstId(u64);

/// A burst that is open. Cheap to clone.
#[derive(Debug, Clone)]
pub struct OpenBurst {
    pub id: BurstId,
    pub burst: Arc<Burst>,
    pub source: BurstSource,
    /// Camera of a file beside the frames or above them, or what is wrong with it.
    pub camera: Option<Result<Camera, Error>>,
    planted: Option<Arc<Truth>>,
    coarse: Arc<[OnceLock<Vec<Plane>>; PREVIEW_OCTAVES.len()]>,
}

/// Octaves on whose pixels motion stacks are previewed, beside that of the frames: a finer one would cost memory.
pub const PREVIEW_OCTAVES: [i32; 3] = [2, 3, 4];

impl OpenBurst {
    pub fn new(burst: Burst, source: BurstSource) -> Self {
        static COUNTER: AtomicU64 = AtomicU64::new(1);
        let id = BurstId(COUNTER.fetch_add(1, Ordering::Relaxed));
        Self { id, burst: Arc::new(burst), source, camera: None, planted: None, coarse: Arc::default() }
    }

    /// Frames on the pixels of `octave`: of one with previews made once, else the frames themselves.
    pub(super) fn frames_on(&self, octave: i32) -> Vec<&Plane> {
        let Some((_, kept)) = PREVIEW_OCTAVES.iter().zip(&*self.coarse).find(|(of, _)| **of == octave) else {
            return self.burst.frames.iter().map(|frame| &**frame).collect();
        };
        // Not cancelled: while a slope is dragged, no request lasts long enough to make them.
        let make = || coarse_frames(&self.burst, octave, &Monitor::default()).expect("not cancelled");
        kept.get_or_init(make).iter().collect()
    }

    pub fn truth(&self, monitor: &Monitor) -> Result<Option<Truth>, Error> {
        if let Some(truth) = &self.planted {
            return Ok(Some(Truth::clone(truth)));
        }
        match &self.source {
            // The chart was made once, so making it again fails only when cancelled; then the truth is not needed.
            BurstSource::Chart(chart) => Ok(synth_chart(chart, monitor).ok().map(|(_, truth)| truth)),
            _ => truth_of(&self.burst),
        }
    }

    /// Whether the burst may have a truth: a cheap check that reads no file.
    pub fn has_truth(&self) -> bool {
        self.planted.is_some() || matches!(self.source, BurstSource::Chart(_)) || has_truth(&self.burst)
    }

    pub fn describe(&self) -> String {
        let (width, height) = self.burst.size();
        format!("{}: {} of {width} × {height}", self.burst.name, counted(self.burst.len(), "frame"))
    }
}

impl BurstSource {
    /// Opens the burst on the calling thread, with the calibration in `options`; built-in bursts need none.
    pub fn open(&self, options: &OpenOptions, monitor: &Monitor) -> Result<OpenBurst, JobError> {
        match self.burst_and_planted(options, monitor) {
            Ok((burst, planted)) => {
                let camera = Some(options.file_of_camera(self.paths())).filter(|file| file.is_file());
                let (camera, planted) = (camera.map(|file| read_camera(&file)), planted.map(Arc::new));
                Ok(OpenBurst { planted, camera, ..OpenBurst::new(burst, self.clone()) })
            }
            // A cancelled read may fail in any other way.
            Err(error) if error.is_cancelled() || monitor.is_cancelled() => Err(JobError::Cancelled),
            Err(error) if error.kind == ErrorKind::SeveralBursts => {
                // The bursts come with the error, so that the window can offer them.
                let found = find_bursts(self.paths(), options).unwrap_or_default();
                Err(JobError::Several(found.into_iter().map(|found| BurstSource::Paths(found.paths)).collect()))
            }
            Err(error) if error.kind == ErrorKind::NoShape => Err(self.without_shape(&error, options, monitor)),
            Err(error) => Err(error.into()),
        }
    }

    fn without_shape(&self, error: &Error, options: &OpenOptions, monitor: &Monitor) -> JobError {
        let [path] = self.paths() else { return JobError::failed(error) };
        // The shapes come with the error, for a choice by their pictures.
        match likely_shapes(path, &options.limits, monitor) {
            Ok(shapes) => JobError::NoShape(error.to_string(), shapes.into_iter().map(PossibleShape::from).collect()),
            Err(error) => error.into(),
        }
    }
}

impl From<LikelyShape> for PossibleShape {
    fn from(LikelyShape { dump, frames, first, .. }: LikelyShape) -> Self {
        const MAX_SIDE_PX: usize = 200;
        Self { dump, frames, picture: BurstPicture::small(&first, MAX_SIDE_PX) }
    }
}

/// The first frame of a file without header in the shape that is typed.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeRequest {
    pub path: PathBuf,
    pub dump: Dump,
    pub limits: Limits,
}

request! {
    ShapeRequest => PossibleShape, Picture: |self, work| {
        Ok(shape_of(&self.path, self.dump, &self.limits, work.monitor)?.into())
    }
}

/// Names in a folder, in order, those of folders with a slash.
#[derive(Debug, Clone, PartialEq)]
pub struct FolderRequest(pub PathBuf);

request! {
    FolderRequest => Vec<String>, Picture: |self, work| {
        const MOST: usize = 20_000;
        let mut names = Vec::new();
        for entry in std::fs::read_dir(&self.0).map_err(JobError::failed)?.take(MOST) {
            work.monitor.check()?;
            let path = entry.map_err(JobError::failed)?.path();
            let name = path.file_name().and_then(OsStr::to_str);
            names.extend(name.map(|name| format!("{name}{}", if path.is_dir() { "/" } else { "" })));
        }
        names.sort();
        Ok(names)
    }
}
