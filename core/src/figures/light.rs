//! Fig. 7: a view in good light, without noise, and in the dark.

use super::drawing::{Panel, stretched};
use super::record::Pieces;
use super::{FigureSize, FiguresError, Made, MakeFigure};
use crate::burst::Burst;
use crate::export::sheet::{Anchor, Sheet};
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use crate::plane::display::Display;
use crate::plane::statistics::{Region, summary};
use crate::synth::{FrameLevels, Trajectory, TrajectoryParams};
use std::fmt::Write;

const WIDTH: f64 = 900.0;
const GAP: f64 = 16.0;

/// Parameters of the scene in two lights.
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
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made, FiguresError> {
        let silent = monitor.silent();
        let dark = Trajectory::new(&self.dark, &silent)?;
        monitor.report(Stage::Synth, 0.4);
        let light = crate::synth::Light::Electrons(self.bright_electrons);
        let bright = Trajectory::new(&TrajectoryParams { light, ..self.dark.clone() }, &silent)?;
        monitor.report(Stage::Synth, 0.8);
        let middle = |way: &Trajectory| -> Result<Plane, FiguresError> {
            let burst = way.burst(self.burst, &silent)?;
            Ok((*burst.frames[burst.len() / 2]).clone())
        };
        let (frame, lit, gold) = (middle(&dark)?, middle(&bright)?, dark.gold(self.burst, &silent)?);
        let mut sheet = Sheet::new(WIDTH, "Bright, gold and dark frames");
        let mut csv = String::from("picture,electrons_at_white,snr,mean,standard_deviation,min,max\n");
        let half = (WIDTH - 3.0 * GAP) / 2.0;
        let rows: [(&str, &str, &Plane, Display, Option<&Trajectory>); 4] = [
            ("bright", "a frame in good light", &lit, stretched(&lit), Some(&bright)),
            ("gold", "the gold standard: no noise", &gold, Display::default(), None),
            ("dark", "a frame in the dark, as it is recorded", &frame, Display::default(), Some(&dark)),
            ("dark-stretched", "the same, stretched", &frame, stretched(&frame), Some(&dark)),
        ];
        let mut end = 0.0;
        let mut y = 34.0;
        for (index, (word, title, plane, display, way)) in rows.into_iter().enumerate() {
            if index == 2 {
                y = end + 60.0;
            }
            let at = (GAP + (half + GAP) * (index % 2) as f64, y);
            let panel = Panel::draw(&mut sheet, at, half, plane, &display, title);
            end = panel.area.bottom();
            let range = summary(plane, &Region::whole(plane)).range();
            let mut levels = FrameLevels::default();
            levels.add(&Burst::from_planes(word, vec![plane.clone()]));
            let light = way.map_or("no noise".to_owned(), |way| {
                format!("{:.1} electrons at scene white, SNR {:.2} of a pixel", way.electrons, way.snr)
            });
            sheet.text((at.0, end + 16.0), 12.0, Anchor::Start, &light);
            let known = |value: fn(&Trajectory) -> f64| way.map_or(String::new(), |way| format!("{:.4}", value(way)));
            let (min, max) = range.unwrap_or_default();
            // Writing into a string cannot fail.
            let _ = writeln!(
                csv,
                "{word},{},{},{:.6},{:.6},{min:.6},{max:.6}",
                known(|way| way.electrons),
                known(|way| way.snr),
                levels.mean(),
                levels.standard_deviation()
            );
        }
        Ok(Made { svg: sheet.finish(end + 30.0), csv, notes: Vec::new() })
    }
}
