//! The kinds of picture: one record each, which the window, lessons, the glossary and files read.

use crate::detector::params::Stage;
use crate::detector::{Combine, Scale, Slope};
use serde::{Deserialize, Serialize};
use strum::{EnumCount, IntoStaticStr, VariantArray};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RangeClass {
    /// Brightnesses of frames, with all their noise.
    Frame,
    /// Brightnesses of what is made of several frames.
    Intensity,
    Response,
    Difference,
    /// σ of the noise.
    Noise,
    /// Shares, 0 … 1.
    Share,
    /// Winning slopes, which have colours of their own.
    Motion,
}

impl RangeClass {
    pub fn label(self) -> &'static str {
        match self {
            Self::Frame => "frames",
            Self::Intensity => "motion stacks and merged frames",
            Self::Response => "DoG responses",
            Self::Difference => "differences",
            Self::Noise => "noise maps",
            Self::Share => "coverage maps",
            Self::Motion => "maps of motion",
        }
    }
}

/// Kind of picture, by its name in sessions, lessons and on the command line.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, EnumCount, VariantArray, IntoStaticStr,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum ViewKind {
    Frame,
    #[default]
    Stack,
    Dog,
    Merge,
    Noise,
    Coverage,
    Motion,
    Field,
    InFocus,
    Median,
    ClippedMean,
    Max,
    Min,
    Deviation,
    MeanMinusMedian,
}

#[derive(Debug, Clone, Copy)]
pub struct AboutView {
    pub label: &'static str,
    pub help: &'static str,
    /// Last stage whose parameters decide the picture; `None` where no parameter does.
    pub stage: Option<Stage>,
    pub of_slope: bool,
    /// Whether it depends on octave and level, and has the octave's pixels.
    pub of_scale: bool,
    pub range: RangeClass,
    /// Needs a search or all frames, which takes too long to repeat at every step of a slider.
    pub is_slow: bool,
    /// The way to combine the shifted frames, for pictures that are made by one.
    pub combine: Option<Combine>,
}

const FRAME: AboutView = AboutView {
    label: "Frame",
    help: "One frame as it was taken",
    stage: None,
    of_slope: false,
    of_scale: false,
    range: RangeClass::Frame,
    is_slow: false,
    combine: None,
};

const MAP: AboutView =
    AboutView { stage: Some(Stage::Search), of_slope: true, range: RangeClass::Intensity, is_slow: true, ..FRAME };

const fn combined(combine: Combine, range: RangeClass) -> AboutView {
    AboutView { stage: Some(Stage::Stack), of_slope: true, range, combine: Some(combine), ..FRAME }
}

impl AboutView {
    const fn named(self, label: &'static str, help: &'static str) -> Self {
        Self { label, help, ..self }
    }
}

impl ViewKind {
    /// All kinds, in the order of menus.
    pub const ALL: [Self; Self::COUNT] = *Self::VARIANTS.first_chunk().expect("as many");

    /// Kinds that the canvas switches between; a cursor remembers the last one that was shown.
    pub const OF_CURSOR: [Self; 3] = [Self::Frame, Self::Stack, Self::Dog];

    pub const fn about(self) -> AboutView {
        use RangeClass::{Difference, Intensity, Noise, Response, Share};
        match self {
            Self::Frame => FRAME,
            Self::Stack => AboutView { stage: Some(Stage::Stack), of_slope: true, range: Intensity, ..FRAME }
                .named("Motion stack", "The mean of the frames, shifted by the slope"),
            Self::Dog => {
                AboutView { stage: Some(Stage::Response), of_slope: true, of_scale: true, range: Response, ..FRAME }
                    .named("DoG", "The difference of Gaussians of the motion stack, which the detector searches")
            }
            Self::Merge => AboutView { stage: Some(Stage::Frames), range: Intensity, is_slow: true, ..FRAME }
                .named("Merged frames", "The frames aligned tile by tile and merged into one image"),
            Self::Noise => AboutView { of_scale: true, range: Noise, ..MAP }.named(
                "Local noise",
                "σ of the noise in the DoG at the slope, octave and level, by place, as the noise gate takes it: \
                 a candidate must be several times as large",
            ),
            Self::Coverage => AboutView { range: Share, ..MAP }.named(
                "Coverage",
                "The share of the frames that see each place at the slope: \
                 where it is small, fewer frames are averaged and the noise is stronger",
            ),
            Self::Motion => AboutView { of_slope: false, of_scale: true, range: RangeClass::Motion, ..MAP }.named(
                "Winning slope",
                "The slope that answers most strongly at each place, at the octave and level: it is the colour, \
                 the brighter the further all other slopes stay behind",
            ),
            Self::Field => AboutView { of_slope: false, range: RangeClass::Motion, ..MAP }.named(
                "Field of motion",
                "The motion of every place, from all that lies around it: its slope is the colour, the \
                 brighter the more certain it is; grey where it is unknown",
            ),
            Self::InFocus => AboutView { of_slope: false, ..MAP }.named(
                "All in focus",
                "The mean of the frames, each place shifted by its own motion: near and far are sharp at once",
            ),
            Self::Median => combined(Combine::Median, Intensity).named(
                "Median of the frames",
                "The median of the frames, shifted by the slope: what is in fewer than half of them is gone",
            ),
            Self::ClippedMean => combined(Combine::ClippedMean, Intensity).named(
                "Clipped mean",
                "The mean of the frames, shifted by the slope, without values far from the median",
            ),
            Self::Max => combined(Combine::Max, Intensity).named(
                "Maximum",
                "The largest value of the frames, shifted by the slope: what is bright in any of them",
            ),
            Self::Min => combined(Combine::Min, Intensity).named(
                "Minimum",
                "The smallest value of the frames, shifted by the slope: what is bright in all of them",
            ),
            Self::Deviation => combined(Combine::Deviation, Noise).named(
                "Deviation",
                "The standard deviation of the frames, shifted by the slope: noise, and what changes",
            ),
            Self::MeanMinusMedian => combined(Combine::MeanMinusMedian, Difference).named(
                "Mean minus median",
                "What is in some frames only stands out: satellites, cars, lamps that switch, hot pixels",
            ),
        }
    }

    /// Name in files, also that of the glossary's entries and at the end of exported files' names.
    pub fn key(self) -> &'static str {
        self.into()
    }

    pub fn label(self) -> &'static str {
        self.about().label
    }
}

/// Kind of a picture, with its parameters: slopes in pixels per frame; octave −1 is the doubled image. The frames that
/// are merged are those that are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PictureKind {
    Frame(usize),
    Stack { slope: Slope },
    Dog { octave: i32, level: i32, slope: Slope },
    Merge,
    Map { map: ViewKind, octave: i32, level: i32, slope: Slope },
}

impl PictureKind {
    pub fn about(self) -> AboutView {
        let kind = match self {
            Self::Frame(_) => ViewKind::Frame,
            Self::Stack { .. } => ViewKind::Stack,
            Self::Dog { .. } => ViewKind::Dog,
            Self::Merge => ViewKind::Merge,
            Self::Map { map, .. } => map,
        };
        kind.about()
    }

    pub fn slope(self) -> Option<Slope> {
        match self {
            Self::Stack { slope } | Self::Dog { slope, .. } => Some(slope),
            Self::Map { map, slope, .. } => map.about().of_slope.then_some(slope),
            Self::Frame(_) | Self::Merge => None,
        }
    }

    pub fn scale(self) -> Option<Scale> {
        match self {
            Self::Dog { octave, level, .. } => Some(Scale { octave, level }),
            Self::Map { map, octave, level, .. } => map.about().of_scale.then_some(Scale { octave, level }),
            Self::Frame(_) | Self::Stack { .. } | Self::Merge => None,
        }
    }

    /// Octave of its pixels: 0 for a picture without.
    pub fn octave(self) -> i32 {
        self.scale().map_or(0, |scale| scale.octave)
    }

    /// Input pixels for one pixel of this picture: 2^octave.
    pub fn input_px_per_pixel(self) -> f32 {
        (self.octave() as f32).exp2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_read_by_the_key_of_its_record() {
        for kind in ViewKind::ALL {
            let key = serde_json::Value::String(kind.key().to_owned());
            assert_eq!(serde_json::from_value::<ViewKind>(key).ok(), Some(kind));
        }
    }
}
