//! Fig. 4: a chart of discs, and the features that each method finds on it.

use super::drawing::{Panel, RIGHT, WRONG, stretched};
use super::record::Pieces;
use super::{FigureSize, FiguresError, Made, MakeFigure};
use crate::burst::Burst;
use crate::detector::{Detection, DetectorParams, NoiseGate};
use crate::evaluate::score::{Curve, Judged, judge};
use crate::evaluate::{BurstMethod, ChartStudy, Ranking, Searches};
use crate::export::sheet::Sheet;
use crate::monitor::{Monitor, Stage};
use crate::plane::Plane;
use crate::synth::{ChartParams, synth_chart};
use std::fmt::Write;

const WIDTH: f64 = 1080.0;
const GAP: f64 = 14.0;

/// Parameters of the chart in good light and in the dark, and the methods.
#[derive(Debug)]
pub(super) struct TestTarget {
    chart: ChartParams,
    /// Signal-to-noise ratio of the bright copy.
    bright_snr: f64,
    methods: Vec<BurstMethod>,
    detector: DetectorParams,
    false_fraction: f64,
    /// Columns and rows that are drawn; the numbers are of the whole chart.
    part: (usize, usize),
}

impl TestTarget {
    pub fn new(size: FigureSize) -> Self {
        let small = ChartParams { width: 300, height: 220, discs: 14, radius: 3.6..=14.0, ..ChartParams::default() };
        Self {
            chart: ChartParams { snr: 0.35, ..size.pick(ChartParams::default(), small) },
            bright_snr: 20.0,
            methods: BurstMethod::WITH_GIVEN_SLOPES.to_vec(),
            detector: DetectorParams { noise_gate: NoiseGate::Strict, ..DetectorParams::default() },
            false_fraction: 0.1,
            part: size.pick((420, 315), (300, 220)),
        }
    }
}

/// A method's features at the threshold.
struct FoundOnTarget {
    label: String,
    word: String,
    /// Features at the threshold, strongest first.
    kept: Vec<Judged>,
    /// Whether there is a threshold with so few false features; otherwise all features that pass the gate are kept.
    has_threshold: bool,
    detection: Detection,
}

impl MakeFigure for TestTarget {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made, FiguresError> {
        let silent = monitor.silent();
        let (dark, truth) = synth_chart(&self.chart, &silent)?;
        // The same discs: noise comes from separate random streams.
        let (bright, _) = synth_chart(&ChartParams { snr: self.bright_snr, ..self.chart.clone() }, &silent)?;
        let study = ChartStudy::default();
        let searches = Searches {
            detector: &self.detector,
            slopes_1d: study.slopes_1d,
            slopes_2d: study.slopes_2d,
            direction_deg: None,
        };
        let mut all: Vec<(FoundOnTarget, Burst)> = Vec::new();
        let jobs = std::iter::once((BurstMethod::SiftFrame, true)).chain(self.methods.iter().map(|&m| (m, false)));
        for (index, (method, is_bright)) in jobs.enumerate() {
            monitor.report(Stage::Evaluate, index as f32 / (self.methods.len() + 1) as f32);
            let burst = if is_bright { &bright } else { &dark };
            let detection = searches.search(method, burst, &silent)?.detection;
            let judged = judge(&detection.features, &truth, Ranking::Strength);
            let point = Curve::of(&judged).at_false_fraction(self.false_fraction);
            let has_threshold = point.true_positives > 0;
            let kept = judged.into_iter().filter(|one| !has_threshold || one.worth >= point.threshold).collect();
            let (label, word) = match is_bright {
                true => ("SIFT in good light".to_owned(), "sift-bright".to_owned()),
                false => (method.label().to_owned(), method.name().to_owned()),
            };
            all.push((FoundOnTarget { label, word, kept, has_threshold, detection }, burst.clone()));
        }
        let found: Vec<(&FoundOnTarget, &Burst)> = all.iter().map(|(found, burst)| (found, burst)).collect();
        let svg = self.draw(&found, truth.features.len());
        Ok(Made { svg, csv: csv(&found), notes: Vec::new() })
    }
}

impl TestTarget {
    fn draw(&self, all: &[(&FoundOnTarget, &Burst)], discs: usize) -> String {
        let mut sheet = Sheet::new(WIDTH, "The test target");
        let third = (WIDTH - 4.0 * GAP) / 3.0;
        let (mut y, mut end) = (34.0, 0.0);
        for (row, found) in all.chunks(3).enumerate() {
            if row > 0 {
                y = end + 34.0;
            }
            for (column, (found, burst)) in found.iter().enumerate() {
                let frame: &Plane = &burst.frames[burst.len() / 2];
                let right = found.kept.iter().filter(|one| one.disc.is_some()).count();
                let mark = if found.has_threshold { "" } else { "*" };
                let wrong = found.kept.len() - right;
                let title = format!("{}: {right} of {discs} discs, {wrong} false{mark}", found.label);
                let at = (GAP + (third + GAP) * column as f64, y);
                let panel =
                    Panel::draw_part(&mut sheet, at, third, (frame, [0, 0], self.part), &stretched(frame), &title);
                sheet.clipped(panel.area, |sheet| {
                    for one in &found.kept {
                        let colour = if one.disc.is_some() { RIGHT } else { WRONG };
                        panel.feature(sheet, &found.detection.features[one.feature], colour);
                    }
                });
                end = panel.area.bottom();
            }
        }
        let text = format!(
            "The middle frame, SNR {} (stretched), its upper left {}×{} of {}×{} pixels; numbers are of the whole chart, at the threshold where {} % are false (*: there is none, so at the default)",
            self.chart.snr,
            self.part.0.min(self.chart.width),
            self.part.1.min(self.chart.height),
            self.chart.width,
            self.chart.height,
            self.false_fraction * 100.0
        );
        let end = sheet.paragraph((GAP, end + 20.0), 12.0, WIDTH - 2.0 * GAP, &text);
        sheet.finish(end)
    }
}

fn csv(all: &[(&FoundOnTarget, &Burst)]) -> String {
    let mut csv = String::from("method,u,v,sigma,slope_u,slope_v,strength,disc\n");
    for (found, _) in all {
        for one in &found.kept {
            let f = &found.detection.features[one.feature];
            let disc = one.disc.map_or(String::new(), |disc| disc.to_string());
            // Writing into a string cannot fail.
            let _ = writeln!(
                csv,
                "{},{},{},{},{},{},{},{disc}",
                found.word,
                f.u,
                f.v,
                f.sigma,
                f.slope.u,
                f.slope.v,
                f.strength()
            );
        }
    }
    csv
}
