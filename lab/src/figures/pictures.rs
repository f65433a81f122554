//! Figs. 7 and 9: a view in good light, without noise and in the dark; aliasing and low contrast on two examples.

use super::{FigureSize, Made, MakeFigure, Panel, RIGHT, WRONG, record::Pieces};
use crate::evaluate::curves::lettered;
use crate::synth::examples::{ALIASING_SLOPE, GARLAND_PERIOD, disc_place};
use crate::synth::{Example, FrameLevels, Trajectory, TrajectoryParams};
use burstscope_core::detector::{DetectorParams, Feature, Slope, SlopeGrid, view::stack_view};
use burstscope_core::export::sheet::{Anchor, Sheet};
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::plane::statistics::{Region, summary};
use burstscope_core::plane::{Plane, display::Display};
use burstscope_core::{burst::Burst, detect::detect, error::Result, export::FigureStroke};

const WIDTH: f64 = 900.0;
const GAP: f64 = 16.0;
const HALF: f64 = (WIDTH - 3.0 * GAP) / 2.0;
const DISCS: usize = 9;
/// Distance to a disc within which a feature finds it, pixels.
const NEAR_PX: f32 = 4.0;

/// The two examples, which bring their own search parameters.
#[derive(Debug)]
pub(super) struct Failures;

impl MakeFigure for Failures {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let mut sheet = Sheet::new(WIDTH, "Failure cases");
        let mut csv = String::from("case,u,v,sigma,slope_u,response,snr,is\n");
        let end = aliasing(&mut sheet, &mut csv, monitor)?;
        monitor.report(Stage::Evaluate, 0.5);
        let end = low_contrast(&mut sheet, &mut csv, end + 52.0, monitor)?;
        Ok(Made { svg: sheet.finish(end + 40.0).svg(), csv, notes: Vec::new() })
    }
}

fn write_feature(csv: &mut String, case: &str, f: &Feature, is: &str) {
    *csv += &format!("{case},{},{},{},{},{},{},{is}\n", f.u, f.v, f.sigma, f.slope.u, f.response, f.snr);
}

/// Draws a frame of an example, and beside it its motion stack at `slope`; returns its features and the stack's panel.
fn searched(
    sheet: &mut Sheet,
    example: Example,
    y: f64,
    slope: Slope,
    titles: [&str; 2],
    monitor: &Monitor,
) -> Result<(Vec<Feature>, Panel)> {
    let (burst, silent, (range, count)) = (example.burst(), monitor.silent(), example.slopes_u());
    let params = DetectorParams { slopes: SlopeGrid::line(range, count), ..DetectorParams::default() };
    let features = detect(&burst, &params, &silent)?.features;
    let (frame, stack) = (&burst.frames[burst.len() / 2], stack_view(&burst, &params, slope, &silent)?);
    Panel::draw(sheet, (GAP, y), HALF, frame, &Display::stretched(frame), titles[0]);
    let beside = (2.0 * GAP + HALF, y);
    Ok((features, Panel::draw(sheet, beside, HALF, &stack, &Display::stretched(&stack), titles[1])))
}

fn aliasing(sheet: &mut Sheet, csv: &mut String, monitor: &Monitor) -> Result<f64> {
    // One period per frame too slow: each lamp lies on its neighbour.
    let wrong = Slope::new(ALIASING_SLOPE - GARLAND_PERIOD, 0.0);
    let title = format!("the motion stack at −{:.0} px/frame, at which nothing moves", wrong.u.abs());
    let titles = ["(a) one frame: small lamps every 8 px, larger ones apart", &title];
    let (features, panel) = searched(sheet, Example::Aliasing, 34.0, wrong, titles, monitor)?;
    let is_false = |f: &&Feature| (f.slope.u - wrong.u).abs() < 0.5;
    sheet.clipped(panel.area, |sheet| features.iter().filter(is_false).for_each(|f| panel.feature(sheet, f, WRONG)));
    for f in &features {
        let is = match f.slope.u {
            u if (u - ALIASING_SLOPE).abs() < 0.5 => "true slope",
            u if (u - wrong.u).abs() < 0.5 => "alias",
            _ => "other slope",
        };
        write_feature(csv, "aliasing", f, is);
    }
    let count = features.iter().filter(is_false).count();
    // Bright blobs are minima of D: what is positive is darker than what lies around it.
    let dark = features.iter().filter(is_false).filter(|f| f.response > 0.0).count();
    let text = format!(
        "orange: {count} features at that slope, {dark} of them dark gaps; all moves by {ALIASING_SLOPE} px/frame"
    );
    sheet.text((2.0 * GAP + HALF, panel.area.bottom() + 16.0), 12.0, Anchor::Start, &text);
    Ok(panel.area.bottom())
}

fn low_contrast(sheet: &mut Sheet, csv: &mut String, y: f64, monitor: &Monitor) -> Result<f64> {
    let titles = [
        "(b) one frame: nine discs, each fainter than the one before",
        "the motion stack at their slope, and what is found",
    ];
    let (features, panel) = searched(sheet, Example::LowContrast, y, Slope::new(1.0, 0.0), titles, monitor)?;
    let finds = |f: &Feature, index: usize| {
        let [u, v] = disc_place(index);
        (f.u - u).hypot(f.v - v) <= NEAR_PX
    };
    let mut found = 0;
    // Every disc is marked at its true place, so that the missed ones show too.
    for index in 0..DISCS {
        let [u, v] = disc_place(index);
        let is_found = features.iter().any(|f| finds(f, index));
        found += usize::from(is_found);
        let missed = FigureStroke::new(WRONG, 1.8).dashed([4.0, 3.0]);
        let stroke = if is_found { FigureStroke::new(RIGHT, 1.8) } else { missed };
        panel.circle(sheet, [f64::from(u), f64::from(v)], 10.0, stroke);
    }
    for f in &features {
        let disc = (0..DISCS).find(|&index| finds(f, index));
        write_feature(csv, "low-contrast", f, &disc.map_or("false".to_owned(), |disc| format!("disc {disc}")));
    }
    let text = format!("blue: found ({found} of {DISCS}); orange, dashed: missed");
    sheet.text((2.0 * GAP + HALF, panel.area.bottom() + 16.0), 12.0, Anchor::Start, &text);
    Ok(panel.area.bottom())
}

#[derive(Debug)]
pub(super) struct Light {
    dark: TrajectoryParams,
    /// Electrons at scene white in good light.
    bright_electrons: f64,
    burst: usize,
}

impl Light {
    pub fn new(size: FigureSize) -> Self {
        let (width, height) = size.pick((480, 360), (240, 180));
        let light = crate::synth::Light::Snr(0.35);
        let dark = TrajectoryParams { width, height, light, ..TrajectoryParams::default() };
        Self { dark, bright_electrons: 2000.0, burst: 3 }
    }
}

impl MakeFigure for Light {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let silent = monitor.silent();
        let dark = Trajectory::new(&self.dark, &silent)?;
        monitor.report(Stage::Synth, 0.4);
        let light = crate::synth::Light::Electrons(self.bright_electrons);
        // Only the light differs, so that both show the same view.
        let bright = Trajectory::new(&TrajectoryParams { light, ..self.dark.clone() }, &silent)?;
        monitor.report(Stage::Synth, 0.8);
        let middle = |way: &Trajectory| -> Result<Plane> {
            let burst = way.burst(self.burst, &silent)?;
            Ok((*burst.frames[burst.len() / 2]).clone())
        };
        let (frame, lit, gold) = (middle(&dark)?, middle(&bright)?, dark.gold(self.burst, &silent)?);
        let mut sheet = Sheet::new(WIDTH, "Bright, gold and dark frames");
        let mut csv = String::from("picture,electrons_at_white,snr,mean,standard_deviation,min,max\n");
        let rows: [(&str, &str, &Plane, Display, Option<&Trajectory>); 4] = [
            ("bright", "a frame in good light", &lit, Display::stretched(&lit), Some(&bright)),
            ("gold", "the gold standard: no noise", &gold, Display::default(), None),
            ("dark", "a frame in the dark, as it is recorded", &frame, Display::default(), Some(&dark)),
            ("dark-stretched", "the same, stretched", &frame, Display::stretched(&frame), Some(&dark)),
        ];
        let mut end = 0.0;
        let mut y = 34.0;
        for (index, (word, title, plane, display, way)) in rows.into_iter().enumerate() {
            if index == 2 {
                y = end + 60.0;
            }
            let at = (GAP + (HALF + GAP) * (index % 2) as f64, y);
            end = Panel::draw(&mut sheet, at, HALF, plane, &display, &lettered(index, title)).area.bottom();
            let range = summary(plane, &Region::whole(plane)).range();
            let mut levels = FrameLevels::default();
            levels.add(&Burst::from_planes(word, vec![plane.clone()]), &silent)?;
            let light = way.map_or("no noise".to_owned(), |way| {
                format!("{:.1} electrons at scene white, SNR {:.2} of a pixel", way.electrons, way.snr)
            });
            sheet.text((at.0, end + 16.0), 12.0, Anchor::Start, &light);
            let known = |value: fn(&Trajectory) -> f64| way.map_or(String::new(), |way| format!("{:.4}", value(way)));
            let (min, max) = range.unwrap_or_default();
            csv += &format!(
                "{word},{},{},{:.6},{:.6},{min:.6},{max:.6}\n",
                known(|way| way.electrons),
                known(|way| way.snr),
                levels.mean(),
                levels.standard_deviation()
            );
        }
        Ok(Made { svg: sheet.finish(end + 30.0).svg(), csv, notes: Vec::new() })
    }
}
