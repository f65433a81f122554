//! Quantities that a film sweeps over, and its steps.

use crate::detector::{Combine, Method, Slope, memory};
use crate::plane::Plane;
use crate::plane::display::{ColourMap, Display};
use std::str::FromStr;

/// Largest number of pictures of a film.
pub const MAX_FILM_PICTURES: usize = 1000;

/// What a picture of a film shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FilmView {
    /// The middle frame.
    Frame,
    /// The frames, aligned and merged into one.
    Merged,
    /// The shifted frames, combined.
    Stack(Combine),
    /// The DoG of an octave and a level.
    Dog(i32, i32),
}

impl FilmView {
    /// The method whose features belong to it.
    pub fn method(self) -> Method {
        match self {
            Self::Frame => Method::Sift,
            Self::Merged => Method::Merge,
            Self::Stack(_) | Self::Dog(..) => Method::Buff,
        }
    }

    /// Whether it is shown at a slope.
    pub(super) fn has_slope(self) -> bool {
        self.method() == Method::Buff
    }

    /// View by its name on the command line.
    fn named(name: &str) -> Option<Self> {
        match name {
            "frame" => Some(Self::Frame),
            "merged" => Some(Self::Merged),
            _ => Combine::ALL.into_iter().find(|combine| combine.name() == name).map(Self::Stack),
        }
    }
}

/// Kinds of values; those of one kind share a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ValueKind {
    Brightness,
    Deviation,
    Signed,
}

impl FilmView {
    /// Kind of its values.
    pub(super) fn values(self) -> ValueKind {
        match self {
            Self::Dog(..) | Self::Stack(Combine::MeanMinusMedian) => ValueKind::Signed,
            Self::Stack(Combine::Deviation) => ValueKind::Deviation,
            Self::Frame | Self::Merged | Self::Stack(_) => ValueKind::Brightness,
        }
    }
}

/// One of the pictures that are flipped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flipped {
    /// What it shows.
    pub view: FilmView,
    /// Its slope, px/frame; `None` for that of the film.
    pub slope: Option<Slope>,
}

/// Quantity that a film sweeps over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sweep {
    /// Slope along u, px/frame: first, last, number of steps.
    SlopeU(f32, f32, usize),
    /// Slope along v, px/frame: first, last, number of steps.
    SlopeV(f32, f32, usize),
    /// DoG of all octaves and levels of the search, from fine to coarse.
    Scale,
    /// Frames added one by one.
    Frames,
    /// Two pictures in turn.
    Flip([Flipped; 2]),
}

impl Sweep {
    /// Name of the quantity with its unit, for the axis of a curve.
    pub(super) fn label(self) -> &'static str {
        match self {
            Self::SlopeU(..) => "slope u, px/frame",
            Self::SlopeV(..) => "slope v, px/frame",
            Self::Scale => "σ, px",
            Self::Frames | Self::Flip(_) => "frames",
        }
    }

    /// Whether the response at a place is drawn over the steps.
    pub(super) fn has_curve(self) -> bool {
        !matches!(self, Self::Flip(_))
    }
}

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || {
            format!(
                "'{text}' is no sweep; give slope-u=MIN:MAX:COUNT, slope-v=MIN:MAX:COUNT, scale, frames, or flip=A,B"
            )
        };
        match text {
            "scale" => return Ok(Self::Scale),
            "frames" => return Ok(Self::Frames),
            "flip" => return "flip=frame,mean".parse(),
            _ => {}
        }
        let (what, rest) = text.split_once('=').ok_or_else(bad)?;
        if what == "flip" {
            let (first, second) = rest.split_once(',').ok_or_else(bad)?;
            return Ok(Self::Flip([first.parse()?, second.parse()?]));
        }
        let parts: Vec<&str> = rest.split(':').collect();
        let [first, last, count] = parts[..] else { return Err(bad()) };
        let count: usize = count.trim().parse().map_err(|_| bad())?;
        if !(1..=MAX_FILM_PICTURES).contains(&count) {
            return Err(format!("{count} pictures; give 1 to {MAX_FILM_PICTURES}"));
        }
        let (first, last) = finite(first).zip(finite(last)).ok_or_else(bad)?;
        match what {
            "slope-u" => Ok(Self::SlopeU(first, last, count)),
            "slope-v" => Ok(Self::SlopeV(first, last, count)),
            _ => Err(bad()),
        }
    }
}

impl FromStr for Flipped {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || {
            let names: Vec<&str> = Combine::ALL.map(Combine::name).into();
            format!("'{text}' is no picture to flip; give frame, merged, {}, or one of these @U:V", names.join(", "))
        };
        let (name, slope) = text.split_once('@').map_or((text, None), |(name, slope)| (name, Some(slope)));
        let view = FilmView::named(name.trim()).ok_or_else(bad)?;
        let slope = match slope {
            None => None,
            Some(_) if !view.has_slope() => return Err(bad()),
            Some(slope) => {
                let (u, v) = slope.split_once(':').ok_or_else(bad)?;
                let (u, v) = finite(u).zip(finite(v)).ok_or_else(bad)?;
                Some(Slope::new(u, v))
            }
        };
        Ok(Self { view, slope })
    }
}

fn finite(text: &str) -> Option<f32> {
    text.trim().parse::<f32>().ok().filter(|x| x.is_finite())
}

/// One step of a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmStep {
    /// Slope, px/frame.
    pub slope: Slope,
    /// What is shown.
    pub view: FilmView,
    /// Number of frames around the middle; `None` for all.
    pub frames: Option<usize>,
}

/// Steps, ranges and size that the pictures of a film share, and the values that were kept of them.
pub(super) struct Prepared {
    pub steps: Vec<FilmStep>,
    pub planes: Vec<Option<Plane>>,
    pub responses: Vec<f32>,
    /// Kinds of values, each with the percentiles of all its pictures.
    pub ranges: Vec<(ValueKind, f32, f32)>,
    /// Columns and rows of a picture.
    pub sheet: [f32; 2],
}

impl Prepared {
    /// The display of a step: one for all pictures of a kind, so that they can be compared.
    pub fn display(&self, step: &FilmStep) -> Display {
        let kind = step.view.values();
        let range = self.ranges.iter().find(|(of, low, high)| *of == kind && low <= high);
        let Some(&(_, low, high)) = range else { return Display::default() };
        if kind == ValueKind::Signed {
            return Display::symmetric(low.abs().max(high.abs()).max(f32::MIN_POSITIVE));
        }
        Display { map: ColourMap::default(), ..Display::default() }.with_range(low, high.max(low + f32::MIN_POSITIVE))
    }
}

/// Bytes that the values kept for a film may take, and its pictures as well: a part of what searches may.
pub(super) fn part_of_memory() -> u64 {
    memory::budget().unwrap_or(4 << 30) / 4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_are_read_as_they_are_typed_and_others_are_refused() {
        let flip = "flip=median@1:-0.5,merged".parse();
        let [median, merged] =
            [(FilmView::Stack(Combine::Median), Some(Slope::new(1.0, -0.5))), (FilmView::Merged, None)]
                .map(|(view, slope)| Flipped { view, slope });
        assert_eq!(flip, Ok(Sweep::Flip([median, merged])));
        assert_eq!("slope-u=-3:3:7".parse(), Ok(Sweep::SlopeU(-3.0, 3.0, 7)));
        assert_eq!("flip".parse::<Sweep>(), "flip=frame,mean".parse());
        for bad in [
            "",
            "slope-u",
            "slope-u=1:2",
            "slope-u=a:b:c",
            "slope-u=0:inf:3",
            "slope-w=1:2:3",
            "slope-u=0:1:0",
            "slope-v=0:1:9999",
            "flip=mean",
            "flip=mean,mode",
            "flip=frame@1:0,mean",
            "flip=mean@1,mean@2:0",
            "flip=mean@NaN:0,mean",
        ] {
            assert!(bad.parse::<Sweep>().is_err_and(|why| why.contains("give")), "{bad}");
        }
    }
}
