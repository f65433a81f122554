//! Pictures of a burst: a frame, a motion-stack image, a DoG response, a map, the merged frames, or the difference of
//! two of these.

use super::map::{MapKind, MotionMap};
use super::open::{BurstId, OpenBurst};
use crate::detector::{DetectorParams, Interpolation, Method, Slope};
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::sample::difference;
use image::RgbaImage;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// Kind of a picture, with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PictureKind {
    /// One frame, counted from 0.
    Frame(usize),
    /// The motion-stack image at a slope, on the grid or between.
    Stack {
        /// Pixels per frame.
        slope: Slope,
    },
    /// The DoG response of the motion-stack image at a slope.
    Dog {
        /// Octave; −1 is the doubled image.
        octave: i32,
        /// Level within the octave.
        level: i32,
        /// Pixels per frame.
        slope: Slope,
    },
    /// The frames that are used, aligned tile by tile and merged into one.
    Merge,
    /// Map of a quantity that decides in the search, by place.
    Map {
        /// Kind of the map.
        map: MapKind,
        /// Octave; −1 is the doubled image.
        octave: i32,
        /// Level within the octave.
        level: i32,
        /// Pixels per frame.
        slope: Slope,
    },
}

impl PictureKind {
    /// Whether it needs a search of the burst or all of its frames, which takes too long to repeat at every step of a
    /// slider.
    pub fn is_slow(self) -> bool {
        matches!(self, Self::Map { .. } | Self::Merge)
    }

    /// Input pixels for one pixel of this picture: 2^octave for a DoG response, else 1.
    pub fn input_px_per_pixel(self) -> f32 {
        match self {
            Self::Dog { octave, .. } => (octave as f32).exp2(),
            Self::Map { map, octave, .. } if map.is_of_octave() => (octave as f32).exp2(),
            Self::Frame(_) | Self::Stack { .. } | Self::Merge | Self::Map { .. } => 1.0,
        }
    }
}

/// Request for a picture of a burst: an immutable snapshot.
#[derive(Debug, Clone)]
pub struct PictureRequest {
    /// The burst.
    pub burst: OpenBurst,
    /// Kind of the picture.
    pub kind: PictureKind,
    /// The parameters; only those that decide the picture make two requests differ.
    pub params: DetectorParams,
    minus: Option<Box<PictureRequest>>,
}

/// Key of a picture: two requests with equal keys give the same picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PictureKey {
    burst: BurstId,
    kind: KindKey,
    minus: Option<(BurstId, KindKey)>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum KindKey {
    Frame(usize),
    Stack(StackKey),
    Dog {
        stack: StackKey,
        octave: i32,
        level: i32,
        levels: u32,
        first_octave: i32,
        kernel_cut_bits: u32,
    },
    Merge {
        frames: (usize, usize),
    },
    /// Nearly all parameters decide a map, those of the noise among them: a hash of their text stands for them.
    Map {
        map: MapKind,
        at: Option<(i32, i32)>,
        stack: StackKey,
        params: u64,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct StackKey {
    slope_bits: (u32, u32),
    frames: (usize, usize),
    interpolation: Interpolation,
    merged: bool,
}

impl PictureRequest {
    /// Picture `kind` of `burst`, made with `params`.
    pub fn new(burst: OpenBurst, kind: PictureKind, params: DetectorParams) -> Self {
        Self { burst, kind, params, minus: None }
    }

    /// The difference: this picture minus `other`, on this picture's pixels. Differences of differences are not made:
    /// of each request its first picture counts.
    #[must_use]
    pub fn less(self, other: &Self) -> Self {
        Self { minus: Some(Box::new(other.alone())), ..self }
    }

    /// Picture that is subtracted, if this is a difference.
    pub fn minus(&self) -> Option<&Self> {
        self.minus.as_deref()
    }

    /// The picture without what is subtracted from it.
    #[must_use]
    pub fn alone(&self) -> Self {
        Self { minus: None, ..self.clone() }
    }

    pub(crate) fn key(&self) -> PictureKey {
        let minus = self.minus().map(|minus| (minus.burst.id, minus.kind_key()));
        PictureKey { burst: self.burst.id, kind: self.kind_key(), minus }
    }

    fn kind_key(&self) -> KindKey {
        let used = self.params.used_frames(self.burst.burst.len());
        let stack = |slope: Slope| {
            // Adding 0 makes −0 and 0 one slope.
            let slope_bits = ((slope.u + 0.0).to_bits(), (slope.v + 0.0).to_bits());
            StackKey {
                slope_bits,
                frames: (used.start, used.end),
                interpolation: self.params.interpolation,
                merged: self.params.method == Method::Merge,
            }
        };
        match self.kind {
            PictureKind::Frame(index) => KindKey::Frame(index),
            PictureKind::Stack { slope } => KindKey::Stack(stack(slope)),
            PictureKind::Dog { octave, level, slope } => KindKey::Dog {
                stack: stack(slope),
                octave,
                level,
                levels: self.params.levels,
                first_octave: self.params.first_octave,
                kernel_cut_bits: self.params.kernel_cut.to_bits(),
            },
            PictureKind::Merge => KindKey::Merge { frames: (used.start, used.end) },
            PictureKind::Map { map, octave, level, slope } => KindKey::Map {
                map,
                at: map.is_of_octave().then_some((octave, level)),
                stack: stack(if map.is_of_slope() { slope } else { Slope::default() }),
                params: hash_of(&self.params),
            },
        }
    }
}

/// Hash of the parameters, different for different parameters for all practical purposes.
fn hash_of(params: &DetectorParams) -> u64 {
    let mut hasher = DefaultHasher::new();
    format!("{params:?}").hash(&mut hasher);
    hasher.finish()
}

/// Picture with its request. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Request that it answers.
    pub request: PictureRequest,
    /// Its pixels; fraction of full scale.
    pub plane: Arc<Plane>,
    /// The winning slopes and their colours, for a map of winning slopes.
    pub motion: Option<Arc<MotionMap>>,
}

impl Picture {
    /// Bytes of its pixels.
    pub fn bytes(&self) -> usize {
        let pixels = std::mem::size_of_val(self.plane.data());
        // Three planes and the colours, a number for each pixel.
        if self.motion.is_some() { 5 * pixels } else { pixels }
    }

    /// Renders the picture: one opaque pixel for each value, in `display`'s range and colours unless it has its own
    /// colours.
    pub fn rgba(&self, display: &Display) -> RgbaImage {
        self.motion.as_ref().map_or_else(|| to_rgba8(&self.plane, display), |motion| motion.colours.clone())
    }

    /// This picture minus `other`, on this picture's pixels: between its pixels `other` is taken linearly; beside it
    /// the difference is NaN.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        let (step, step_other) = (self.request.kind.input_px_per_pixel(), other.request.kind.input_px_per_pixel());
        Self {
            request: self.request.alone().less(&other.request),
            plane: Arc::new(difference(&self.plane, &other.plane, step / step_other)),
            motion: None,
        }
    }

    pub(crate) fn is_frame(&self) -> bool {
        matches!(self.request.kind, PictureKind::Frame(_)) && self.request.minus.is_none()
    }
}
