//! How pictures and features look: value ranges, colour maps, and what is drawn over the picture.
//!
//! Ranges are fixed for each class of picture, so that two slopes or two frames can be compared: frames and motion-stack images share one,
//! DoG responses have another, symmetric about zero. A range is set once, from the first picture of its class; after that only by hand.

use crate::engine::{Picture, PictureKind};
use crate::plane::display::Display;
use crate::plane::statistics::{Region, percentiles};
use serde::{Deserialize, Serialize};

/// The classes of picture that share a value range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RangeClass {
    /// Frames and motion-stack images.
    Intensity,
    /// DoG responses.
    Response,
}

impl RangeClass {
    /// The class of a picture.
    pub fn of(kind: PictureKind) -> Self {
        match kind {
            PictureKind::Frame(_) | PictureKind::Stack { .. } => Self::Intensity,
            PictureKind::Dog { .. } => Self::Response,
        }
    }

    /// Its name within a sentence.
    pub fn label(self) -> &'static str {
        match self {
            Self::Intensity => "frames and motion stacks",
            Self::Response => "DoG responses",
        }
    }
}

/// How pictures and features look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Look {
    /// For frames and motion-stack images.
    pub intensity: Display,
    /// For DoG responses.
    pub response: Display,
    /// Whether the two ranges were set since the burst was opened.
    pub intensity_fixed: bool,
    /// See [`Look::intensity_fixed`].
    pub response_fixed: bool,
    /// Whether features are drawn over the picture.
    pub overlay: bool,
    /// Whether each feature's motion over the burst is drawn.
    pub motion_vectors: bool,
    /// Whether each feature's orientation is drawn.
    pub orientations: bool,
    /// Whether the legend is drawn.
    pub legend: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            intensity: Display::default(),
            response: Display::symmetric(0.02),
            intensity_fixed: false,
            response_fixed: false,
            overlay: true,
            motion_vectors: true,
            orientations: true,
            legend: true,
        }
    }
}

impl Look {
    /// The display of a class.
    pub fn display(&self, class: RangeClass) -> Display {
        match class {
            RangeClass::Intensity => self.intensity,
            RangeClass::Response => self.response,
        }
    }

    /// The display of a class, to be changed by hand.
    pub fn display_mut(&mut self, class: RangeClass) -> &mut Display {
        match class {
            RangeClass::Intensity => &mut self.intensity,
            RangeClass::Response => &mut self.response,
        }
    }

    /// Lets the next picture of each class set its range.
    pub fn forget_ranges(&mut self) {
        (self.intensity_fixed, self.response_fixed) = (false, false);
    }

    /// Sets the range of the picture's class from its percentiles, unless it was set since the burst was opened.
    pub fn fix_range_once(&mut self, picture: &Picture) {
        let class = RangeClass::of(picture.request.kind);
        let fixed = match class {
            RangeClass::Intensity => &mut self.intensity_fixed,
            RangeClass::Response => &mut self.response_fixed,
        };
        if std::mem::replace(fixed, true) {
            return;
        }
        if let Some(range) = percentiles(&picture.plane, &Region::whole(&picture.plane), &[0.1, 99.9]) {
            let display = self.display_mut(class);
            *display = display.with_range(range[0], range[1]);
        }
    }
}
