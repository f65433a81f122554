//! Fig. 3: the steps from frames to features, with pictures of the detector's own intermediate results.

use super::{FigureSize, Made, MakeFigure, Panel, record::Pieces};
use crate::{evaluate::curves::lettered, synth::demo_burst};
use burstscope_core::detector::view::{dog_view, stack_view};
use burstscope_core::detector::{DetectorParams, Feature, Scale, Slope, SlopeGrid};
use burstscope_core::export::sheet::{Anchor, Area, INK, RED, Sheet, short};
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::plane::{Plane, display::Display, sample::bilinear};
use burstscope_core::{burst::Burst, detect::detect, error::Result, export::FigureStroke};
use std::sync::Arc;

const WIDTH: f64 = 1240.0;
/// Width of a small picture on the sheet, and distance of the columns.
const SMALL: f64 = 144.0;
const STEP: f64 = 194.0;
const TOP: f64 = 92.0;
const HEIGHT: f64 = 486.0;

#[derive(Debug)]
pub(super) struct Architecture {
    detector: DetectorParams,
    /// Slopes whose motion-stack images are shown, as indices of the grid.
    shown: [usize; 3],
    octave: i32,
    levels: [i32; 3],
}

impl Architecture {
    pub fn new(_: FigureSize) -> Self {
        let detector = DetectorParams { slopes: SlopeGrid::line(-4.0..=4.0, 17), ..DetectorParams::default() };
        Self { detector, shown: [2, 8, 14], octave: 1, levels: [0, 2, 4] }
    }
}

/// D at one position, over slope (to the right) and scale (downwards, from fine to coarse).
struct Response {
    /// Slopes, px/frame.
    slopes: Vec<f32>,
    scales: Vec<Scale>,
    values: Plane,
}

impl MakeFigure for Architecture {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let silent = monitor.silent();
        let burst = demo_burst();
        let detection = detect(&burst, &self.detector, &silent)?;
        monitor.report(Stage::Evaluate, 0.4);
        let grid = self.detector.slopes;
        let slope_of = |index: usize| Slope::new(grid.u.value(index as f32), 0.0);
        // A feature of medium size that moves, off the rim of the slopes, so that its response shows a whole peak.
        let is_middling =
            |f: &&Feature| f.octave == self.octave && !f.is_on_rim(&self.detector) && f.slope.u.abs() > 1.0;
        let subject = detection.features.iter().find(is_middling).or(detection.features.first()).copied();
        let Some(subject) = subject else {
            let svg = Sheet::new(WIDTH, "The architecture").finish(HEIGHT).svg();
            return Ok(Made { svg, csv: String::new(), notes: vec!["The demo burst shows no feature.".into()] });
        };
        let response = self.response(&burst, &subject, &silent)?;
        monitor.report(Stage::Evaluate, 0.8);
        let mut sheet = Sheet::new(WIDTH, "The architecture");
        let title = "From the frames of a burst to features: the detector's intermediate results on the demo burst";
        sheet.heading((20.0, 30.0), 15.0, title);
        let column = |index: usize| 20.0 + STEP * index as f64;
        let heading = |sheet: &mut Sheet, index: usize, text: &str, below: &str| {
            sheet.heading((column(index), 58.0), 13.0, &lettered(index, text));
            sheet.text((column(index), 74.0), 11.0, Anchor::Start, below);
        };
        let frames = [0, burst.len() / 2, burst.len() - 1];
        heading(&mut sheet, 0, "frames", &format!("{} of them, each dark", burst.len()));
        // Pictures of a column share a range, which makes brightnesses comparable.
        let range = Display::stretched(&burst.frames[frames[1]]);
        self.column(&mut sheet, column(0), frames.map(|t| (format!("t = {t}"), burst.frames[t].clone(), range)));
        heading(&mut sheet, 1, "motion stack", &format!("shift and mean, {} slopes", grid.len()));
        let stack = |index| {
            let slope = slope_of(index);
            let plane = stack_view(&burst, &self.detector, slope, &silent)?;
            Ok((format!("slope {} px/frame", short(f64::from(slope.u))), Arc::new(plane)))
        };
        let stacks = self.shown.into_iter().map(stack).collect::<Result<Vec<_>>>()?;
        let range = Display::stretched(&stacks[1].1);
        self.column(&mut sheet, column(1), stacks.into_iter().map(|(text, plane)| (text, plane, range)));
        heading(&mut sheet, 2, "differences of Gaussians", "over octaves and levels");
        let nearest = slope_of(subject.slope_index);
        let dog = |level| {
            let plane = dog_view(&burst, &self.detector, nearest, self.octave, level, &silent)?;
            Ok((format!("octave {}, level {level}", self.octave), Arc::new(plane)))
        };
        let dogs = self.levels.into_iter().map(dog).collect::<Result<Vec<_>>>()?;
        let limit = dogs.iter().flat_map(|(_, plane)| plane.data()).fold(0f32, |max, x| max.max(x.abs()));
        let range = Display::symmetric(0.5 * limit);
        self.column(&mut sheet, column(2), dogs.into_iter().map(|(text, plane)| (text, plane, range)));
        heading(&mut sheet, 3, "extrema", "over place, scale and slope");
        draw_response(&mut sheet, column(3) + 44.0, &response, &subject);
        heading(&mut sheet, 4, "features", "place, scale, orientation, motion");
        // Features are drawn on the stack of the subject's slope, in which the subject is sharp.
        let stack = stack_view(&burst, &self.detector, nearest, &silent)?;
        let (at, width) = ((column(4), TOP + 16.0), WIDTH - column(4) - 16.0);
        let panel = Panel::draw(&mut sheet, at, width, &stack, &Display::stretched(&stack), "");
        // Features are reported at mid-burst: half of their way lies before it.
        let half = (burst.len() as f64 - 1.0) / 2.0;
        sheet.clipped(panel.area, |sheet| {
            for feature in detection.features.iter().take(120) {
                panel.feature(sheet, feature, [0xf0, 0xe4, 0x42]);
                let (u, v) = (f64::from(feature.u), f64::from(feature.v));
                let way = [half * f64::from(feature.slope.u), half * f64::from(feature.slope.v)];
                let (from, to) = (panel.at([u - way[0], v - way[1]]), panel.at([u + way[0], v + way[1]]));
                sheet.line(from, to, FigureStroke::new([0x56, 0xb4, 0xe9], 1.2));
            }
            let pos_image = [f64::from(subject.u), f64::from(subject.v)];
            panel.circle(sheet, pos_image, 4.0 * f64::from(subject.sigma), FigureStroke::new(RED, 2.0));
        });
        let text = format!(
            "the {} strongest of {}; blue: their way during the burst; red: the one whose response is shown",
            detection.features.len().min(120),
            detection.features.len()
        );
        sheet.paragraph((column(4), panel.area.bottom() + 20.0), 11.0, panel.area.width, &text);
        for index in 0..4 {
            let (x, y) = (column(index + 1) - 38.0, TOP + 150.0);
            sheet.line((x, y), (x + 18.0, y), FigureStroke::new(INK, 2.0));
            sheet.polyline(
                [Some((x + 12.0, y - 6.0)), Some((x + 18.0, y)), Some((x + 12.0, y + 6.0))],
                FigureStroke::new(INK, 2.0),
            );
        }
        Ok(Made { svg: sheet.finish(HEIGHT).svg(), csv: response.csv(), notes: Vec::new() })
    }
}

impl Architecture {
    fn column(&self, sheet: &mut Sheet, x: f64, pictures: impl IntoIterator<Item = (String, Arc<Plane>, Display)>) {
        let mut y = TOP + 16.0;
        for (text, plane, display) in pictures {
            // At this size every other pixel is enough; a mean of them would hide the noise.
            let half = Plane::from_fn(plane.width() / 2, plane.height() / 2, |u, v| plane.at(2 * u, 2 * v));
            y = Panel::draw(sheet, (x, y), SMALL, &half, &display, &text).area.bottom() + 20.0;
        }
    }

    /// D at the position of `feature`, which at mid-burst is the same for all slopes.
    fn response(&self, burst: &Burst, feature: &Feature, monitor: &Monitor) -> Result<Response> {
        let grid = self.detector.slopes;
        let slopes: Vec<f32> = (0..grid.u.count).map(|index| grid.u.value(index as f32)).collect();
        let levels = self.detector.levels as i32;
        let scales: Vec<Scale> =
            (0..=self.octave + 1).flat_map(|octave| (0..levels).map(move |level| Scale { octave, level })).collect();
        let mut values = Plane::zeros(slopes.len(), scales.len());
        for (column, &slope) in slopes.iter().enumerate() {
            for (row, &Scale { octave, level }) in scales.iter().enumerate() {
                let dog = dog_view(burst, &self.detector, Slope::new(slope, 0.0), octave, level, monitor)?;
                let pixel = 2f32.powi(octave);
                values.row_mut(row)[column] = bilinear(&dog, feature.u / pixel, feature.v / pixel).unwrap_or(0.0);
            }
        }
        Ok(Response { slopes, scales, values })
    }
}

impl Response {
    fn csv(&self) -> String {
        let mut csv = String::from("slope_u,octave,level,response\n");
        for (row, Scale { octave, level }) in self.scales.iter().enumerate() {
            for (column, slope) in self.slopes.iter().enumerate() {
                csv += &format!("{slope},{octave},{level},{}\n", self.values.at(column, row));
            }
        }
        csv
    }
}

fn draw_response(sheet: &mut Sheet, x: f64, response: &Response, subject: &Feature) {
    let values = &response.values;
    let limit = values.data().iter().fold(1e-9f32, |max, value| max.max(value.abs()));
    let area = Area { x, y: TOP + 16.0, width: SMALL - 44.0, height: 250.0 };
    sheet.picture(area, values, &Display::symmetric(limit));
    let cell = (area.width / values.width() as f64, area.height / values.height() as f64);
    let row = response.scales.iter().position(|scale| *scale == subject.scale()).unwrap_or(0);
    let marked = Area {
        x: area.x + subject.slope_index as f64 * cell.0,
        y: area.y + row as f64 * cell.1,
        width: cell.0,
        height: cell.1,
    };
    sheet.rectangle(marked, FigureStroke::new(RED, 2.0));
    // A cell is one slope wide: the axis ends half a step beyond the outermost slopes.
    let step = response.slopes.get(1).map_or(1.0, |s| s - response.slopes[0]);
    let range = (response.slopes[0] - 0.5 * step, response.slopes[response.slopes.len() - 1] + 0.5 * step);
    sheet.axis_below(area, (f64::from(range.0), f64::from(range.1)), "slope, px/frame");
    for (row, Scale { octave, level }) in response.scales.iter().enumerate() {
        let y = area.y + (row as f64 + 0.5) * cell.1 + 4.0;
        sheet.text((area.x - 5.0, y), 9.5, Anchor::End, &format!("{octave}/{level}"));
    }
    sheet.text((area.x - 38.0, area.y - 6.0), 10.0, Anchor::Start, "octave/level");
    let text = "D at one place: a bright blob is a minimum (blue); the box is where it was found";
    sheet.paragraph((area.x - 40.0, area.bottom() + 56.0), 11.0, SMALL + 6.0, text);
}
