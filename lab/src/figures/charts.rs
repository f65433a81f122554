//! Figs. 4 to 6: a chart with what each method finds on it, and curves over many charts from [`crate::evaluate`].

use super::{FigureSize, Made, MakeFigure, Panel, RIGHT, WRONG, record::Pieces};
use crate::evaluate::curves::{frames_figure, lettered, roc_figure};
use crate::evaluate::statistics::Mean;
use crate::evaluate::{BurstMethod, ChartReport, ChartStudy, Ranking, RowStudy, Searches, motion_name};
use crate::synth::{ChartParams, Motion, synth_chart};
use burstscope_core::detector::{Detection, DetectorParams, NoiseGate, SlopeGrid};
use burstscope_core::error::Result;
use burstscope_core::export::sheet::{Sheet, stacked};
use burstscope_core::inspect::result::{Curve, Scored, judge};
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::plane::{Plane, display::Display};
use std::sync::Arc;

fn study(size: FigureSize, snrs: Vec<f64>) -> ChartStudy {
    let small =
        ChartParams { width: 260, height: 200, discs: 9, radius: 3.6..=12.0, max_slope: 2.0, ..ChartParams::default() };
    let full = ChartStudy { searches: strict(), ..ChartStudy::default() };
    let quick = ChartStudy {
        chart: small,
        searches: Searches {
            slopes_1d: SlopeGrid::line(-2.0..=2.0, 9),
            slopes_2d: SlopeGrid::plane(-2.0..=2.0, 5, -2.0..=2.0, 5),
            ..strict()
        },
        ..ChartStudy::default()
    };
    ChartStudy { snrs, seeds: size.pick(3, 1), ..size.pick(full, quick) }
}

/// As on the charts of docs/MEASUREMENTS.md: at most one false feature in a megapixel of noise.
fn strict() -> Searches {
    let detector = DetectorParams { noise_gate: NoiseGate::Strict, ..DetectorParams::default() };
    Searches { detector, ..Searches::default() }
}

#[derive(Debug)]
pub(super) struct RocFigure {
    studies: [ChartStudy; 2],
}

impl RocFigure {
    pub fn new(size: FigureSize) -> Self {
        let study = study(size, size.pick(vec![0.2, 0.35, 0.6], vec![0.6]));
        let moving = |motion| ChartStudy { chart: ChartParams { motion, ..study.chart.clone() }, ..study.clone() };
        Self { studies: [moving(Motion::OneD), moving(Motion::TwoD)] }
    }
}

impl MakeFigure for RocFigure {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let mut csv = String::from("motion,snr,method,false_features,discs_found\n");
        let mut drawn = Vec::with_capacity(2);
        let mut notes = Vec::new();
        for (index, study) in self.studies.iter().enumerate() {
            let report = study.run(&monitor.part(0.5 * index as f32, 0.5))?;
            let motion = motion_name(study.chart.motion);
            write_curves(&mut csv, motion, &report);
            notes.push(format!("Motion in {}: {}.", motion.to_uppercase(), counts(&report)));
            drawn.push(roc_figure(&report, index * study.snrs.len()).drawing);
        }
        Ok(Made { svg: stacked("Discs found against false features", drawn).svg(), csv, notes })
    }
}

fn write_curves(csv: &mut String, motion: &str, report: &ChartReport) {
    for row in &report.rows {
        for method in &row.methods {
            for (count, found) in method.roc.iter().enumerate() {
                *csv += &format!("{motion},{},{},{count},{found}\n", row.at, method.method.name());
            }
        }
    }
}

/// The discs found where a tenth is false, as a sentence without its end.
fn counts(report: &ChartReport) -> String {
    let of_row = |row: &crate::evaluate::chart::ChartRow| {
        let of_method =
            |m: &crate::evaluate::chart::MethodReport| format!("{} {:.1}", m.method.label(), m.true_positives.mean);
        format!("at {} {}", row.at.label(), row.methods.iter().map(of_method).collect::<Vec<_>>().join(", "))
    };
    let rows: Vec<String> = report.rows.iter().map(of_row).collect();
    format!(
        "discs of {} found where {} % are false, {}",
        report.chart.discs,
        report.setup.false_fraction * 100.0,
        rows.join("; ")
    )
}

#[derive(Debug)]
pub(super) struct FramesFigure {
    study: ChartStudy,
}

impl FramesFigure {
    pub fn new(size: FigureSize) -> Self {
        let methods =
            [BurstMethod::SiftFrame, BurstMethod::SiftMerge, BurstMethod::Buff1d, BurstMethod::Buff2d].to_vec();
        let frame_counts = size.pick(crate::evaluate::chart::FRAME_COUNTS.to_vec(), vec![2, 5, 10]);
        Self { study: ChartStudy { methods, frame_counts, ..study(size, vec![size.pick(0.35, 0.6)]) } }
    }
}

impl MakeFigure for FramesFigure {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let mut csv = String::from(
            "frames,method,discs_found,discs_found_error,default_discs_found,default_discs_found_error,default_false,default_false_error\n",
        );
        let report = self.study.run(monitor)?;
        for (row, method) in report.rows.iter().flat_map(|row| row.methods.iter().map(move |method| (row, method))) {
            let pair = |mean: Mean| {
                let error = mean.standard_error.map_or(String::new(), |error| format!("{error:.4}"));
                format!("{:.4},{error}", mean.mean)
            };
            let means = [method.true_positives, method.default_true_positives, method.default_false_features].map(pair);
            csv += &format!("{},{},{}\n", row.at, method.method.name(), means.join(","));
        }
        Ok(Made { svg: frames_figure(&report).drawing.svg(), csv, notes: Vec::new() })
    }
}

const WIDTH: f64 = 1080.0;
const GAP: f64 = 14.0;

#[derive(Debug)]
pub(super) struct TestTarget {
    chart: ChartParams,
    bright_snr: f64,
    methods: Vec<BurstMethod>,
    searches: Searches,
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
            searches: strict(),
            false_fraction: 0.1,
            part: size.pick((420, 315), (300, 220)),
        }
    }
}

struct FoundOnTarget {
    label: String,
    word: String,
    frame: Arc<Plane>,
    /// Features at the threshold, strongest first.
    kept: Vec<Scored>,
    /// Whether there is a threshold with so few false features; otherwise all features that pass the gate are kept.
    has_threshold: bool,
    detection: Detection,
}

impl MakeFigure for TestTarget {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let silent = monitor.silent();
        let (dark, truth) = synth_chart(&self.chart, &silent)?;
        // Discs stay the same, because noise has random streams of its own.
        let (bright, _) = synth_chart(&ChartParams { snr: self.bright_snr, ..self.chart.clone() }, &silent)?;
        let mut all: Vec<FoundOnTarget> = Vec::new();
        // SIFT in good light comes first, and shows what there is to find.
        let jobs = std::iter::once((BurstMethod::SiftFrame, true)).chain(self.methods.iter().map(|&m| (m, false)));
        for (index, (method, is_bright)) in jobs.enumerate() {
            monitor.report(Stage::Evaluate, index as f32 / (self.methods.len() + 1) as f32);
            let burst = if is_bright { &bright } else { &dark };
            let detection = self.searches.search(method, burst, &silent)?.detection;
            let judged = judge(&detection.features, &truth, Ranking::Strength);
            let point = Curve::of(&judged).at_false_fraction(self.false_fraction);
            let has_threshold = point.true_positives > 0;
            let kept = judged.into_iter().filter(|one| !has_threshold || one.worth >= point.threshold).collect();
            let (label, word) = match is_bright {
                true => ("SIFT in good light".to_owned(), "sift-bright".to_owned()),
                false => (method.label().to_owned(), method.name().to_owned()),
            };
            let frame = burst.frames[burst.len() / 2].clone();
            all.push(FoundOnTarget { label, word, frame, kept, has_threshold, detection });
        }
        Ok(Made { svg: self.draw(&all, truth.features.len()), csv: found_csv(&all), notes: Vec::new() })
    }
}

impl TestTarget {
    fn draw(&self, all: &[FoundOnTarget], discs: usize) -> String {
        let mut sheet = Sheet::new(WIDTH, "The test target");
        let (width, height) = (self.part.0.min(self.chart.width), self.part.1.min(self.chart.height));
        let third = (WIDTH - 4.0 * GAP) / 3.0;
        let (mut y, mut end) = (34.0, 0.0);
        for (row, found) in all.chunks(3).enumerate() {
            if row > 0 {
                y = end + 34.0;
            }
            for (column, found) in found.iter().enumerate() {
                let right = found.kept.iter().filter(|one| one.disc.is_some()).count();
                let mark = if found.has_threshold { "" } else { "*" };
                let wrong = found.kept.len() - right;
                let title = format!("{}: {right} of {discs} discs, {wrong} false{mark}", found.label);
                let title = lettered(3 * row + column, &title);
                let at = (GAP + (third + GAP) * column as f64, y);
                let part = Plane::from_fn(width, height, |u, v| found.frame.at(u, v));
                let panel = Panel::draw(&mut sheet, at, third, &part, &Display::stretched(&found.frame), &title);
                // Clipped, so that circles at the rim do not reach into the next picture.
                sheet.clipped(panel.area, |sheet| {
                    for one in &found.kept {
                        let colour = if one.disc.is_some() { RIGHT } else { WRONG };
                        panel.feature(sheet, &found.detection.features[one.feature], colour);
                    }
                });
                end = panel.area.bottom();
            }
        }
        let is_marked = all.iter().any(|found| !found.has_threshold);
        let mark = if is_marked { " (*: there is none, so at the default)" } else { "" };
        let text = format!(
            "The middle frame, SNR {} (stretched), its upper left {width}×{height} of {}×{} pixels; numbers are of the whole chart, at the threshold where {} % are false{mark}",
            self.chart.snr,
            self.chart.width,
            self.chart.height,
            self.false_fraction * 100.0
        );
        let end = sheet.paragraph((GAP, end + 20.0), 12.0, WIDTH - 2.0 * GAP, &text);
        sheet.finish(end).svg()
    }
}

fn found_csv(all: &[FoundOnTarget]) -> String {
    let mut csv = String::from("method,u,v,sigma,slope_u,slope_v,strength,disc\n");
    for found in all {
        for one in &found.kept {
            let f = &found.detection.features[one.feature];
            let disc = one.disc.map_or(String::new(), |disc| disc.to_string());
            let (place, slope) = (format!("{},{},{}", f.u, f.v, f.sigma), format!("{},{}", f.slope.u, f.slope.v));
            csv += &format!("{},{place},{slope},{},{disc}\n", found.word, f.strength());
        }
    }
    csv
}
