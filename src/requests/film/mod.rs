//! A sweep over slope, scale or frames as a film: the pictures of its steps, with the features of each step and a scale
//! that says which step it is.

use super::open::OpenBurst;
use crate::detector::view::{dog_view, stack_view};
use crate::detector::{DetectError, Detection, DetectorParams, Feature, FrameRange, Slope};
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use crate::plane::display::{ColourMap, Display, direction_colour, to_rgba8};
use crate::plane::statistics::{Region, percentiles};
use image::{Rgba, RgbaImage};
use std::str::FromStr;

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
    /// Middle frame and motion stack in turn.
    Flip,
}

/// Largest number of pictures of a film.
pub const MAX_FILM_PICTURES: usize = 1000;

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || {
            format!("'{text}' is no sweep; give slope-u=MIN:MAX:COUNT, slope-v=MIN:MAX:COUNT, scale, frames or flip")
        };
        match text {
            "scale" => return Ok(Self::Scale),
            "frames" => return Ok(Self::Frames),
            "flip" => return Ok(Self::Flip),
            _ => {}
        }
        let (what, range) = text.split_once('=').ok_or_else(bad)?;
        let parts: Vec<&str> = range.split(':').collect();
        let [first, last, count] = parts[..] else { return Err(bad()) };
        let number = |s: &str| s.trim().parse::<f32>().ok().filter(|x| x.is_finite()).ok_or_else(bad);
        let count: usize = count.trim().parse().map_err(|_| bad())?;
        if !(1..=MAX_FILM_PICTURES).contains(&count) {
            return Err(format!("{count} pictures; give 1 to {MAX_FILM_PICTURES}"));
        }
        match what {
            "slope-u" => Ok(Self::SlopeU(number(first)?, number(last)?, count)),
            "slope-v" => Ok(Self::SlopeV(number(first)?, number(last)?, count)),
            _ => Err(bad()),
        }
    }
}

/// One step of a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmStep {
    /// Slope, px/frame.
    pub slope: Slope,
    /// Octave and level of the DoG; `None` for the motion stack.
    pub scale: Option<(i32, i32)>,
    /// Number of frames from the first; `None` for all, 0 for the middle frame alone.
    pub frames: Option<usize>,
}

/// A film of a burst.
#[derive(Debug, Clone)]
pub struct Film {
    /// The burst.
    pub burst: OpenBurst,
    /// The parameters of its search, with slopes.
    pub params: DetectorParams,
    /// The quantity that is swept.
    pub sweep: Sweep,
    /// Slope of the steps, where that is not swept.
    pub slope: Slope,
    /// The features to draw, if any.
    pub detection: Option<Detection>,
    /// Longest side of a picture, pixels; larger pictures are made smaller by a whole number.
    pub max_side_px: usize,
}

/// Percentiles of all pictures that are black and white.
const RANGE: [f32; 2] = [0.1, 99.9];
/// Height of the scale below the pictures, pixels.
const SCALE_PX: u32 = 10;
const BACKGROUND: Rgba<u8> = Rgba([32, 32, 32, 255]);
const MARK: Rgba<u8> = Rgba([240, 228, 66, 255]);

impl Film {
    /// The steps.
    pub fn steps(&self) -> Vec<FilmStep> {
        let still = FilmStep { slope: self.slope, scale: None, frames: None };
        let along = |first: f32, last: f32, count: usize, i: usize| {
            first + (last - first) * i as f32 / (count.max(2) - 1) as f32
        };
        match self.sweep {
            Sweep::SlopeU(first, last, count) => (0..count)
                .map(|i| FilmStep { slope: Slope::new(along(first, last, count, i), self.slope.v), ..still })
                .collect(),
            Sweep::SlopeV(first, last, count) => (0..count)
                .map(|i| FilmStep { slope: Slope::new(self.slope.u, along(first, last, count, i)), ..still })
                .collect(),
            Sweep::Scale => {
                let octaves = crate::detector::scale_space::searched_octaves(&self.params, self.burst.burst.size());
                let levels = self.params.levels as i32;
                let scales = octaves.flat_map(|octave| (0..levels).map(move |level| (octave, level)));
                scales.map(|scale| FilmStep { scale: Some(scale), ..still }).collect()
            }
            Sweep::Frames => {
                let all = self.params.used_frames(self.burst.burst.len()).len();
                (1..=all.min(MAX_FILM_PICTURES)).map(|frames| FilmStep { frames: Some(frames), ..still }).collect()
            }
            Sweep::Flip => vec![FilmStep { frames: Some(0), ..still }, still],
        }
    }

    /// Columns and rows of a picture.
    pub fn size(&self) -> (u32, u32) {
        let (columns, rows, _) = self.picture_size();
        (columns, rows + SCALE_PX)
    }

    /// Columns and rows of the burst in a picture, and the number of its pixels for one of these.
    fn picture_size(&self) -> (u32, u32, usize) {
        let (width, height) = self.burst.burst.size();
        let shrink = width.max(height).div_ceil(self.max_side_px.max(16)).max(1);
        ((width / shrink).max(1) as u32, (height / shrink).max(1) as u32, shrink)
    }

    /// The pictures of all steps.
    ///
    /// # Errors
    /// As [`dog_view`].
    pub fn pictures(&self, monitor: &Monitor) -> Result<Vec<RgbaImage>, DetectError> {
        let steps = self.steps();
        let plane = |(index, step): (usize, &FilmStep)| {
            monitor.check()?;
            monitor.report(
                Stage::Search { octave: step.scale.map_or(0, |(octave, _)| octave) },
                index as f32 / steps.len() as f32,
            );
            self.plane(step, &monitor.silent())
        };
        let planes = steps.iter().enumerate().map(plane).collect::<Result<Vec<Plane>, DetectError>>()?;
        let display = display_of(&planes, matches!(self.sweep, Sweep::Scale));
        let pictures = planes.iter().zip(&steps).enumerate();
        Ok(pictures.map(|(index, (plane, step))| self.picture(plane, step, (index, steps.len()), &display)).collect())
    }

    fn plane(&self, step: &FilmStep, monitor: &Monitor) -> Result<Plane, DetectError> {
        let burst = &self.burst.burst;
        let used = self.params.used_frames(burst.len());
        match (step.scale, step.frames) {
            (Some((octave, level)), _) => dog_view(burst, &self.params, step.slope, octave, level, monitor),
            (None, Some(0)) => Ok((*burst.frames[used.start + used.len() / 2]).clone()),
            (None, Some(count)) => {
                // Around the middle, so that the picture stays in place.
                let start = used.start + (used.len() - count) / 2;
                let frames = Some(FrameRange { start, end: start + count });
                Ok(stack_view(burst, &DetectorParams { frames, ..self.params.clone() }, step.slope, monitor)?)
            }
            (None, None) => Ok(stack_view(burst, &self.params, step.slope, monitor)?),
        }
    }

    /// Draws one step: its pixels, its features, and the scale.
    fn picture(&self, plane: &Plane, step: &FilmStep, (index, count): (usize, usize), display: &Display) -> RgbaImage {
        let (columns, rows, shrink) = self.picture_size();
        let pixels = to_rgba8(plane, display);
        let per_pixel = step.scale.map_or(1.0, |(octave, _)| 2f32.powi(-octave));
        let mut out = RgbaImage::from_pixel(columns, rows + SCALE_PX, BACKGROUND);
        for y in 0..rows {
            for x in 0..columns {
                let at = |x: u32, n: u32| ((x as f32 * shrink as f32 * per_pixel) as u32).min(n - 1);
                out.put_pixel(x, y, *pixels.get_pixel(at(x, pixels.width()), at(y, pixels.height())));
            }
        }
        let max = self.params.used_slopes().max_magnitude().max(1e-3);
        for feature in self.detection.iter().flat_map(|d| &d.features).filter(|f| self.shows(step, f)) {
            let [r, g, b] = direction_colour(feature.slope.v.atan2(feature.slope.u), feature.slope.magnitude() / max);
            let scale = 1.0 / shrink as f32;
            let radius = (feature.sigma * std::f32::consts::SQRT_2 * scale).max(2.0);
            ring(&mut out, (feature.u * scale, feature.v * scale), radius, rows, Rgba([r, g, b, 255]));
        }
        // The scale: a line with a mark at the step.
        let at = if count > 1 { index as f32 / (count - 1) as f32 } else { 0.5 } * (columns - 1) as f32;
        for y in 0..SCALE_PX {
            for x in 0..columns {
                let is_mark = (x as f32 - at).abs() <= 2.0;
                let is_line = y == SCALE_PX / 2;
                if is_mark || is_line {
                    out.put_pixel(x, rows + y, if is_mark { MARK } else { Rgba([140, 140, 140, 255]) });
                }
            }
        }
        out
    }

    /// Whether a step shows a feature: of its scale, or moving as its slope.
    fn shows(&self, step: &FilmStep, feature: &Feature) -> bool {
        if let Some(scale) = step.scale {
            return (feature.octave, feature.level) == scale;
        }
        let grid = self.params.used_slopes();
        let near = grid.u.step().max(grid.v.step()).max(0.1);
        (feature.slope.u - step.slope.u).hypot(feature.slope.v - step.slope.v) <= 0.75 * near
    }
}

/// One display for all pictures, so that they can be compared.
fn display_of(planes: &[Plane], is_response: bool) -> Display {
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for plane in planes {
        if let Some(range) = percentiles(plane, &Region::whole(plane), &RANGE) {
            (low, high) = (low.min(range[0]), high.max(range[1]));
        }
    }
    if low > high {
        return Display::default();
    }
    if is_response {
        return Display::symmetric(low.abs().max(high.abs()).max(f32::MIN_POSITIVE));
    }
    Display { map: ColourMap::default(), ..Display::default() }.with_range(low, high.max(low + f32::MIN_POSITIVE))
}

fn ring(out: &mut RgbaImage, centre: (f32, f32), radius: f32, rows: u32, colour: Rgba<u8>) {
    let steps = (8.0 * radius).ceil().max(16.0) as usize;
    for i in 0..steps {
        let angle = i as f32 / steps as f32 * std::f32::consts::TAU;
        let (x, y) = ((centre.0 + radius * angle.cos()).round(), (centre.1 + radius * angle.sin()).round());
        if x >= 0.0 && y >= 0.0 && x < out.width() as f32 && y < rows as f32 {
            out.put_pixel(x as u32, y as u32, colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requests::BurstSource;

    fn film(sweep: Sweep) -> Film {
        let chart = crate::synth::ChartParams { width: 96, height: 64, discs: 2, frames: 4, ..Default::default() };
        let source = BurstSource::Chart(Box::new(chart));
        let burst = source.open(&crate::burst::OpenOptions::default(), &Monitor::default()).expect("a chart");
        Film {
            burst,
            params: DetectorParams::default(),
            sweep,
            slope: Slope::default(),
            detection: None,
            max_side_px: 48,
        }
    }

    #[test]
    fn every_sweep_has_its_steps_in_pictures_of_one_size() {
        // Three octaves of five levels.
        let counts = [("slope-u=-2:2:5", 5), ("slope-v=0:1:2", 2), ("frames", 4), ("flip", 2), ("scale", 15)];
        for (text, count) in counts {
            let film = film(text.parse().expect(text));
            let pictures = film.pictures(&Monitor::default()).expect("made");
            assert_eq!(pictures.len(), count, "{text}");
            assert!(pictures.iter().all(|picture| picture.dimensions() == (48, 32 + SCALE_PX)), "{text}");
            assert_ne!(pictures[0], pictures[1], "{text}");
        }
        let steps = film(Sweep::SlopeU(-2.0, 2.0, 5)).steps();
        assert_eq!(steps.iter().map(|step| step.slope.u).collect::<Vec<_>>(), [-2.0, -1.0, 0.0, 1.0, 2.0]);
        for bad in ["", "slope-u", "slope-u=1:2", "slope-u=a:b:c", "slope-w=1:2:3", "slope-u=0:1:0", "slope-v=0:1:9999"]
        {
            assert!(bad.parse::<Sweep>().is_err(), "{bad}");
        }
    }
}
