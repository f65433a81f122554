//! A sweep over slope, scale or frames as a film: each step as a figure with its features and its numbers.

use super::{OpenBurst, SlopeColours};
use crate::detector::scale_space::{ScaleSpace, searched_octaves};
use crate::detector::view::{dog_view, stack_view};
use crate::detector::{Detection, DetectorParams, Feature, FrameRange, Scale, Slope, memory};
use crate::error::{Error, ErrorKind};
use crate::export::film::{check_film, write_film};
use crate::export::{
    Cells, ColourBar, Drawing, FigureMark, FigureMatches, FigureOptions, FigurePanel, FigureWidth, IN_A_CELL, lay_out,
};
use crate::inspect::slopes::is_at_slope;
use crate::inspect::words::{counted, number, slope_text};
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::statistics::{Region, percentiles_until};
use image::RgbaImage;
use rayon::prelude::*;
use std::io;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

pub const MAX_FILM_PICTURES: usize = 1000;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sweep {
    /// Slope along u, px/frame: first, last, number of steps.
    SlopeU(f32, f32, usize),
    /// Slope along v, px/frame: first, last, number of steps.
    SlopeV(f32, f32, usize),
    /// DoG of all octaves and levels of the search, from fine to coarse.
    Scale,
    Frames,
}

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORMS: &str = "slope-u=MIN:MAX:COUNT, slope-v=MIN:MAX:COUNT, scale, or frames";
        let bad = || format!("'{text}' is no sweep; give {FORMS}");
        let parts: Vec<&str> = text.split(['=', ':']).collect();
        let (slopes, [first, last, count]): (fn(f32, f32, usize) -> Self, _) = match parts[..] {
            ["scale"] => return Ok(Self::Scale),
            ["frames"] => return Ok(Self::Frames),
            ["slope-u", first, last, count] => (Self::SlopeU, [first, last, count]),
            ["slope-v", first, last, count] => (Self::SlopeV, [first, last, count]),
            _ => return Err(bad()),
        };
        let finite = |text: &str| text.trim().parse::<f32>().ok().filter(|x| x.is_finite());
        let count: usize = count.trim().parse().map_err(|_| bad())?;
        if !(1..=MAX_FILM_PICTURES).contains(&count) {
            return Err(format!("{count} pictures; give 1 to {MAX_FILM_PICTURES}"));
        }
        let (first, last) = finite(first).zip(finite(last)).ok_or_else(bad)?;
        Ok(slopes(first, last, count))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmStep {
    pub slope: Slope,
    /// Scale of the DoG that is shown; `None` for the motion stack.
    pub scale: Option<Scale>,
    /// Number of frames around the middle; `None` for all.
    pub frames: Option<usize>,
}

#[derive(Debug, Clone)]
pub struct Film {
    pub burst: OpenBurst,
    /// Those of its search, with slopes.
    pub params: DetectorParams,
    pub sweep: Sweep,
    /// Slope of the steps, where that is not swept.
    pub slope: Slope,
    pub detection: Option<Arc<Detection>>,
    /// Longest side of a burst's picture, pixels; larger ones are made smaller by a whole number.
    pub max_side_px: usize,
}

/// Makes pixels of a drawing; the error says what went wrong.
pub type Rasteriser<'a> = dyn Fn(&Drawing) -> Result<RgbaImage, String> + Sync + 'a;

fn undrawn(problem: String) -> Error {
    Error::new(ErrorKind::Failed, problem, "")
}

/// Percentiles of all pictures that are black and white.
const RANGE: [f32; 2] = [0.1, 99.9];
const FONT_PX: f32 = 12.0;

/// Steps, display and size that the pictures of a film share, and the values that were kept of them.
struct Prepared {
    steps: Vec<FilmStep>,
    planes: Vec<Option<Plane>>,
    /// Value range of all pictures, for comparison.
    display: Display,
    sheet: [f32; 2],
}

/// Bytes that the values kept for a film may take, and its pictures as well: a part of what searches may.
fn part_of_memory() -> u64 {
    memory::budget().unwrap_or(4 << 30) / 4
}

impl Film {
    pub fn steps(&self) -> Vec<FilmStep> {
        let still = FilmStep { slope: self.slope, scale: None, frames: None };
        let along = |first: f32, last: f32, count: usize| {
            (0..count).map(move |i| first + (last - first) * i as f32 / (count.max(2) - 1) as f32)
        };
        let at = |u: f32, v: f32| FilmStep { slope: Slope::new(u, v), ..still };
        match self.sweep {
            Sweep::SlopeU(first, last, count) => along(first, last, count).map(|u| at(u, self.slope.v)).collect(),
            Sweep::SlopeV(first, last, count) => along(first, last, count).map(|v| at(self.slope.u, v)).collect(),
            Sweep::Scale => {
                let octaves = searched_octaves(&self.params, self.burst.burst.size());
                let levels = self.params.levels as i32;
                let scales = octaves.flat_map(|octave| (0..levels).map(move |level| Scale { octave, level }));
                scales.map(|scale| FilmStep { scale: Some(scale), ..still }).collect()
            }
            Sweep::Frames => {
                let all = self.frame_count().min(MAX_FILM_PICTURES);
                (1..=all).map(|frames| FilmStep { frames: Some(frames), ..still }).collect()
            }
        }
    }

    fn frame_count(&self) -> usize {
        self.params.used_frames(self.burst.burst.len()).len()
    }

    pub fn size(&self) -> (u32, u32) {
        self.sheet().map(|side| side as u32).into()
    }

    /// Only as many pictures are in memory at a time as there are threads, and fewer where memory is small. `may_write`
    /// is asked once more before the file is begun.
    pub fn write(
        &self,
        path: &Path,
        rate: u16,
        draw: &Rasteriser<'_>,
        may_write: &dyn Fn() -> Result<(), Error>,
        monitor: &Monitor,
    ) -> Result<(), Error> {
        check_film(path)?;
        let room = part_of_memory();
        let prepared = self.prepared(&self.steps(), room, &monitor.part(0.0, 0.5))?;
        may_write()?;
        let (count, mut failed) = (prepared.steps.len(), None);
        let silent = monitor.silent();
        let pictures = self.pictures(prepared, room, draw, &silent).map(|picture| {
            picture.map_err(|error| {
                failed = Some(error);
                io::Error::other("a picture was not made")
            })
        });
        let written = write_film(path, (count, pictures), rate, &monitor.part(0.5, 0.5));
        failed.map_or(Ok(()), Err)?;
        monitor.check()?;
        written
    }

    /// The first and the middle picture, from which the size of the file can be estimated.
    pub fn samples(&self, draw: &Rasteriser<'_>, monitor: &Monitor) -> Result<[RgbaImage; 2], Error> {
        let steps = self.steps();
        let room = part_of_memory();
        let prepared = self.prepared(&[steps[0], steps[steps.len() / 2]], room, monitor)?;
        let pictures = self.pictures(prepared, room, draw, monitor).collect::<Result<Vec<_>, Error>>()?;
        pictures.try_into().map_err(|_| undrawn("a film has at least one picture".to_owned()))
    }

    /// Computes the values of all `steps` for what the pictures share, and keeps as many as `room` bytes hold.
    fn prepared(&self, steps: &[FilmStep], mut room: u64, monitor: &Monitor) -> Result<Prepared, Error> {
        let mut planes = Vec::with_capacity(steps.len());
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for (index, step) in steps.iter().enumerate() {
            monitor.check()?;
            monitor.report(Stage::Search { octave: 0 }, index as f32 / steps.len() as f32);
            let silent = monitor.silent();
            let plane = self.plane(step, &silent)?;
            let found = percentiles_until(&plane, &Region::whole(&plane), &RANGE, &silent)?;
            if let Some(found) = found {
                (low, high) = (low.min(found[0]), high.max(found[1]));
            }
            let bytes = size_of_val(plane.data()) as u64;
            planes.push((bytes <= room).then_some(plane));
            room = room.saturating_sub(bytes);
        }
        let display = match self.sweep {
            _ if low > high => Display::default(),
            Sweep::Scale => Display::symmetric(low.abs().max(high.abs()).max(f32::MIN_POSITIVE)),
            _ => Display::default().with_range(low, high),
        };
        Ok(Prepared { steps: steps.to_vec(), planes, display, sheet: self.sheet() })
    }

    /// In order, made as they are taken: as many at a time as `room` bytes hold, at least one.
    fn pictures<'a>(
        &'a self,
        mut prepared: Prepared,
        room: u64,
        draw: &'a Rasteriser<'_>,
        monitor: &'a Monitor,
    ) -> impl Iterator<Item = Result<RgbaImage, Error>> + 'a {
        // Beside the picture its drawing has the panel's pixels.
        let [width, height] = prepared.sheet.map(|side| side as u64);
        let at_once = room / (8 * width * height).max(1);
        let at_once = (at_once as usize).clamp(1, rayon::current_num_threads());
        let count = prepared.steps.len();
        (0..count).step_by(at_once).flat_map(move |first| {
            let group = first..(first + at_once).min(count);
            match self.group(&mut prepared, group, draw, monitor) {
                Ok(pictures) => pictures.into_iter().map(Ok).collect::<Vec<_>>(),
                Err(error) => vec![Err(error)],
            }
        })
    }

    /// The pictures of a group of the prepared steps, whose values are then dropped.
    fn group(
        &self,
        prepared: &mut Prepared,
        group: Range<usize>,
        draw: &Rasteriser<'_>,
        monitor: &Monitor,
    ) -> Result<Vec<RgbaImage>, Error> {
        let mut planes = Vec::with_capacity(group.len());
        for index in group.clone() {
            monitor.check()?;
            let kept = prepared.planes[index].take().map(Ok);
            planes.push(kept.unwrap_or_else(|| self.plane(&prepared.steps[index], monitor))?);
        }
        let prepared = &*prepared;
        let picture = |(index, plane): (usize, &Plane)| -> Result<RgbaImage, Error> {
            monitor.check()?;
            let panel = self.panel(&prepared.steps[index], Some((plane, &prepared.display)));
            let mut drawing = lay_out(&[vec![panel]], &FigureMatches::default(), &self.options());
            drawing.size = prepared.sheet;
            draw(&drawing).map_err(undrawn)
        };
        group.zip(&planes).collect::<Vec<_>>().into_par_iter().map(picture).collect()
    }

    fn sheet(&self) -> [f32; 2] {
        let panel = |step: &FilmStep| vec![self.panel(step, None)];
        let size = |step: &FilmStep| lay_out(&[panel(step)], &FigureMatches::default(), &self.options()).size;
        self.steps().iter().map(size).fold([1f32; 2], |a, b| [a[0].max(b[0].ceil()), a[1].max(b[1].ceil())])
    }

    fn options(&self) -> FigureOptions {
        let width = FigureWidth::PxPerPx(1.0 / self.shrink() as f32);
        FigureOptions { width, font_size: FONT_PX, ..FigureOptions::default() }
    }

    /// Number of the burst's pixels along one of a picture.
    fn shrink(&self) -> usize {
        let (width, height) = self.burst.burst.size();
        width.max(height).div_ceil(self.max_side_px.max(16)).max(1)
    }

    fn plane(&self, step: &FilmStep, monitor: &Monitor) -> Result<Plane, Error> {
        let burst = &self.burst.burst;
        let params = self.params_of(step);
        let (plane, per_pixel) = match step.scale {
            None => (stack_view(burst, &params, step.slope, monitor)?, 1.0),
            Some(Scale { octave, level }) => {
                (dog_view(burst, &params, step.slope, octave, level, monitor)?, 2f32.powi(-octave))
            }
        };
        let (shrink, (width, height)) = (self.shrink(), burst.size());
        let at = |x: usize, n: usize| ((x as f32 * shrink as f32 * per_pixel) as usize).min(n - 1);
        let (columns, rows) = ((width / shrink).max(1), (height / shrink).max(1));
        Ok(Plane::from_fn(columns, rows, |u, v| plane.at(at(u, plane.width()), at(v, plane.height()))))
    }

    /// The parameters with the frames of a step: those around the middle, so that the picture stays in place.
    fn params_of(&self, step: &FilmStep) -> DetectorParams {
        let used = self.params.used_frames(self.burst.burst.len());
        let frames = step.frames.filter(|count| *count < used.len()).map(|count| {
            let start = used.start + (used.len() - count) / 2;
            FrameRange { start, end: start + count }
        });
        DetectorParams { frames: frames.or(self.params.frames), ..self.params.clone() }
    }

    /// The features drawn in the picture of a step: as in the window as many of the strongest as each part of it bears.
    fn drawn(&self, step: &FilmStep) -> Vec<&Feature> {
        let (width, height) = self.burst.burst.size();
        let rect = [[-0.5, -0.5], [width as f32 - 0.5, height as f32 - 0.5]];
        let mut cells = Cells::new(1.0 / self.shrink() as f32, rect);
        let mut is_drawn = |at: [f32; 2]| cells.add(at).is_some_and(|before| before < IN_A_CELL);
        self.features(step).filter(|feature| is_drawn([feature.u, feature.v])).collect()
    }

    /// A step as a panel of a figure; without values an empty one of the same size.
    fn panel(&self, step: &FilmStep, values: Option<(&Plane, &Display)>) -> FigurePanel {
        let (shrink, (width, height)) = (self.shrink(), self.burst.burst.size());
        let size = ((width / shrink).max(1), (height / shrink).max(1));
        let display = values.map_or_else(Display::default, |(_, display)| *display);
        let drawn = self.drawn(step);
        let (colours, burst) = (self.colours(), &self.burst.burst);
        let positions = burst.positions.part(self.params.used_frames(burst.len()));
        let mark = |feature: &&Feature| FigureMark::of(feature, &positions, colours.colour(feature.motion().0));
        let marks = drawn.iter().map(mark);
        let [low, high] = [display.min, display.max].map(|end| format!("{:>6}", number(100.0 * end, 2)));
        FigurePanel {
            size,
            rgba: Arc::new(values.map_or_else(Vec::new, |(plane, display)| to_rgba8(plane, display).into_raw())),
            origin_image: [-0.5, -0.5],
            image_px_per_px: shrink as f32,
            marks: if values.is_some() { marks.collect() } else { Vec::new() },
            title: Some(self.title(step, drawn.len(), self.features(step).count())),
            legend: Vec::new(),
            bar: Some(ColourBar::of(&display, low, format!("{high} % of full scale"))),
        }
    }

    fn colours(&self) -> SlopeColours {
        let features = self.detection.as_ref().map_or(&[][..], |found| &found.features);
        SlopeColours::of(&self.params.used_slopes(), features)
    }

    fn title(&self, step: &FilmStep, drawn: usize, features: usize) -> String {
        let frames = counted(step.frames.unwrap_or(self.frame_count()), "frame");
        let slope = format!("slope {} px/frame", slope_text(step.slope));
        let what = match step.scale {
            None => format!("mean of {frames}, {slope}"),
            Some(Scale { octave, level }) => {
                let sigma = ScaleSpace::of(&self.params).sigma_image(octave, f64::from(level)) as f32;
                format!("σ {} px (octave {octave}, level {level}), {slope}", number(sigma, 1))
            }
        };
        let of = if drawn < features { format!("{drawn} of ") } else { String::new() };
        if self.detection.is_some() { format!("{what}: {of}{}", counted(features, "feature")) } else { what }
    }

    /// The features of a step: of its scale, or moving as its slope.
    fn features(&self, step: &FilmStep) -> impl Iterator<Item = &Feature> {
        let grid = self.params.used_slopes();
        let all = self.detection.iter().flat_map(|detection| &detection.features);
        let (scale, slope) = (step.scale, step.slope);
        all.filter(move |feature| scale.map_or_else(|| is_at_slope(&grid, feature, slope), |at| feature.scale() == at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requests::BurstSource;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn film(sweep: Sweep) -> Film {
        let chart = crate::synth::ChartParams { width: 96, height: 64, discs: 2, frames: 4, ..Default::default() };
        let source = BurstSource::Chart(Box::new(chart));
        let burst = source.open(&crate::burst::OpenOptions::default(), &Monitor::default()).expect("a chart");
        let params = DetectorParams::default();
        Film { burst, params, sweep, slope: Slope::default(), detection: None, max_side_px: 48 }
    }

    fn digest(drawing: &Drawing) -> Result<RgbaImage, String> {
        let text = format!("{:?}", drawing.shapes);
        let sum = text.bytes().fold(0u32, |sum, byte| sum.wrapping_mul(31).wrapping_add(u32::from(byte)));
        let [width, height] = drawing.size.map(|x| x as u32);
        Ok(RgbaImage::from_pixel(width, height, image::Rgba(sum.to_le_bytes())))
    }

    fn all(film: &Film, room: u64, draw: &Rasteriser<'_>) -> Vec<RgbaImage> {
        let monitor = Monitor::default();
        let prepared = film.prepared(&film.steps(), room, &monitor).expect("prepared");
        film.pictures(prepared, room, draw, &monitor).collect::<Result<_, _>>().expect("made")
    }

    #[test]
    fn pictures_are_made_as_they_are_taken_and_are_the_same_in_any_memory() {
        let film = film(Sweep::SlopeU(-2.0, 2.0, 40));
        assert_eq!(all(&film, 0, &digest), all(&film, 1 << 40, &digest));
        let (drawn, monitor) = (AtomicUsize::new(0), Monitor::default());
        let counted = |drawing: &Drawing| {
            drawn.fetch_add(1, Ordering::Relaxed);
            digest(drawing)
        };
        for (room, most) in [(0, 1), (1 << 40, rayon::current_num_threads())] {
            drawn.store(0, Ordering::Relaxed);
            let prepared = film.prepared(&film.steps(), room, &monitor).expect("prepared");
            assert_eq!(prepared.planes.iter().filter(|plane| plane.is_some()).count(), if room == 0 { 0 } else { 40 });
            let mut pictures = film.pictures(prepared, room, &counted, &monitor);
            assert!(pictures.next().is_some_and(|picture| picture.is_ok()));
            assert_eq!(drawn.load(Ordering::Relaxed), most, "{room} bytes");
        }
        monitor.cancel();
        let error = film.prepared(&film.steps(), 0, &monitor).err();
        assert!(error.as_ref().is_some_and(Error::is_cancelled), "{error:?}");
    }
}
