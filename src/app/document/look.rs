//! Look of pictures and features: value ranges, colour maps, and drawings over the picture. A class of pictures shares
//! a range, so that slopes, or frames, can be compared. It is set once, from the first picture of its class (of several
//! panes, that in focus), and again when the window goes to the first slope with features; after that only by the user.

use crate::app::{defaults::with_defaults, words::choices};
use crate::detector::params::Bounds;
use crate::plane::display::{ColourMap, Display};
use crate::requests::PictureAnswer;
pub use crate::requests::RangeClass;
use serde::{Deserialize, Serialize};
use std::ops::Bound;

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Ranges {
        pub frame: Display,
        pub intensity: Display,
        pub response: Display = Display::symmetric(0.02),
        pub difference: Display = Display::symmetric(0.05),
        pub noise: Display = Display { map: ColourMap::Viridis, ..Display::default() }.with_range(0.0, 0.01),
        pub share: Display = Display { map: ColourMap::Cividis, ..Display::default() },
        /// Whether the range was set since the burst was opened.
        pub frame_fixed: bool,
        pub intensity_fixed: bool,
        pub response_fixed: bool,
        pub difference_fixed: bool,
        pub noise_fixed: bool,
    }
}

/// Percentiles of a picture that are black and white.
const PERCENTILES: [f32; 2] = [0.1, 99.9];

const CLASSES: [RangeClass; 6] = {
    use RangeClass::*;
    [Frame, Intensity, Response, Difference, Noise, Share]
};

impl Ranges {
    /// Range of a class, and whether it was set; that is no question where the range is known beforehand.
    fn of(&mut self, class: RangeClass) -> (&mut Display, Option<&mut bool>) {
        match class {
            RangeClass::Frame => (&mut self.frame, Some(&mut self.frame_fixed)),
            RangeClass::Intensity => (&mut self.intensity, Some(&mut self.intensity_fixed)),
            RangeClass::Response => (&mut self.response, Some(&mut self.response_fixed)),
            RangeClass::Difference => (&mut self.difference, Some(&mut self.difference_fixed)),
            RangeClass::Noise => (&mut self.noise, Some(&mut self.noise_fixed)),
            RangeClass::Share | RangeClass::Motion => (&mut self.share, None),
        }
    }

    pub fn display(mut self, class: RangeClass) -> Display {
        *self.of(class).0
    }

    pub fn display_mut(&mut self, class: RangeClass) -> &mut Display {
        self.of(class).0
    }

    pub fn forget(&mut self) {
        CLASSES.into_iter().for_each(|class| self.set_fixed(class, false));
    }

    fn set_fixed(&mut self, class: RangeClass, is_fixed: bool) {
        self.of(class).1.into_iter().for_each(|fixed| *fixed = is_fixed);
    }

    /// Sets the range of the picture's class from its percentiles, unless it was set since the burst was opened.
    pub fn fix_once(&mut self, picture: &PictureAnswer) {
        self.propose(picture);
        self.set_fixed(RangeClass::of(&picture.request), true);
    }

    /// Sets the range of the picture's class from its percentiles, but lets another picture set it again.
    pub fn propose(&mut self, picture: &PictureAnswer) {
        if self.of(RangeClass::of(&picture.request)).1.is_some_and(|fixed| !*fixed) {
            self.take_percentiles(picture);
        }
    }

    /// Sets the range of the picture's class from its percentiles, also where the user chose another.
    pub fn take_percentiles(&mut self, picture: &PictureAnswer) {
        let display = self.display_mut(RangeClass::of(&picture.request));
        *display = display.over_percentiles(&picture.drawn, PERCENTILES);
    }

    /// Lets another picture set the range if this one did: not where the user chose another.
    pub fn forget_that_of(&mut self, picture: &PictureAnswer) {
        let class = RangeClass::of(&picture.request);
        let display = self.display(class);
        if display == display.over_percentiles(&picture.drawn, PERCENTILES) {
            self.set_fixed(class, false);
        }
    }

    /// The ranges with all displays made valid: a file may contain any values.
    #[must_use]
    pub fn sanitised(mut self) -> Self {
        for class in CLASSES {
            *self.display_mut(class) = self.display(class).sanitised();
        }
        self
    }
}

choices! {
    #[derive(Default)]
    FeaturesShown {
        /// Those that move by the picture's slope. All, over a picture that belongs to no slope.
        #[default]
        ThisSlope: "This slope",
        "Features that move by the slope of the picture, by themselves or with their surroundings";
        All: "All", "Features of all slopes; other slopes are drawn fainter";
        None: "None", "No features";
    }
}

impl FeaturesShown {
    pub fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % Self::ALL.len()]
    }
}

/// In input pixels: up to more than any scale at which one looks at single features.
pub const SMOOTHING_PX: Bounds =
    Bounds::new((Bound::Included(0.0), Bound::Included(8.0)), "give 0 to 8 pixels; 0 smooths nothing");

with_defaults! {
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Look {
        #[serde(flatten)]
        pub ranges: Ranges,
        pub overlay: FeaturesShown,
        /// Whether all features are drawn in full, however close they lie.
        pub draws_all: bool,
        pub motion_vectors: bool = true,
        pub orientations: bool = true,
        pub legend: bool = true,
        /// σ of the Gaussian by which pictures are smoothed for looking at them, input pixels; 0 for none.
        pub smoothing_px: f32,
    }
}
