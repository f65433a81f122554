//! Figs. 5 and 6: curves over many charts, measured and drawn by [`crate::evaluate`].

use super::record::Pieces;
use super::{FigureSize, FiguresError, Made, MakeFigure};
use crate::detector::{DetectorParams, NoiseGate, SlopeGrid};
use crate::evaluate::figure::roc_svg;
use crate::evaluate::frames_figure::frames_svg;
use crate::evaluate::statistics::Mean;
use crate::evaluate::{BurstMethod, ChartReport, ChartStudy, FramesStudy, motion_name};
use crate::export::sheet::stacked;
use crate::monitor::Monitor;
use crate::synth::{ChartParams, Motion};
use std::fmt::Write;

/// A study of charts of this size.
fn study(size: FigureSize, snrs: Vec<f64>) -> ChartStudy {
    let small =
        ChartParams { width: 260, height: 200, discs: 9, radius: 3.6..=12.0, max_slope: 2.0, ..ChartParams::default() };
    let full = ChartStudy::default();
    let quick = ChartStudy {
        chart: small,
        slopes_1d: SlopeGrid::line(-2.0..=2.0, 9),
        slopes_2d: SlopeGrid::plane(-2.0..=2.0, 5, -2.0..=2.0, 5),
        ..ChartStudy::default()
    };
    // As on the charts of docs/MEASUREMENTS.md: at most one false feature in a megapixel of noise.
    let detector = DetectorParams { noise_gate: NoiseGate::Strict, ..DetectorParams::default() };
    ChartStudy { snrs, detector, seeds: size.pick(3, 1), ..size.pick(full, quick) }
}

/// Discs found against false features, for motion in one dimension and in two.
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
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made, FiguresError> {
        let mut csv = String::from("motion,snr,method,false_features,discs_found\n");
        let mut drawn = Vec::with_capacity(2);
        let mut notes = Vec::new();
        for (index, study) in self.studies.iter().enumerate() {
            let report = study.run(&monitor.part(0.5 * index as f32, 0.5))?;
            let motion = motion_name(study.chart.motion);
            write_curves(&mut csv, motion, &report);
            notes.push(format!("Motion in {}: {}.", motion.to_uppercase(), counts(&report)));
            drawn.push(roc_svg(&report));
        }
        Ok(Made { svg: stacked("Discs found against false features", &drawn), csv, notes })
    }
}

fn write_curves(csv: &mut String, motion: &str, report: &ChartReport) {
    for row in &report.rows {
        for method in &row.methods {
            for (count, found) in method.roc.iter().enumerate() {
                // Writing into a string cannot fail.
                let _ = writeln!(csv, "{motion},{},{},{count},{found}", row.snr, method.method.name());
            }
        }
    }
}

/// The discs found where a tenth is false, as a sentence without its end.
fn counts(report: &ChartReport) -> String {
    let of_row = |row: &crate::evaluate::chart::ChartRow| {
        let of_method =
            |m: &crate::evaluate::chart::MethodReport| format!("{} {:.1}", m.method.label(), m.true_positives.mean);
        format!("at SNR {} {}", row.snr, row.methods.iter().map(of_method).collect::<Vec<_>>().join(", "))
    };
    let rows: Vec<String> = report.rows.iter().map(of_row).collect();
    format!(
        "discs of {} found where {} % are false, {}",
        report.chart.discs,
        report.setup.false_fraction * 100.0,
        rows.join("; ")
    )
}

/// Discs found over the number of frames.
#[derive(Debug)]
pub(super) struct FramesFigure {
    study: FramesStudy,
}

impl FramesFigure {
    pub fn new(size: FigureSize) -> Self {
        let charts = study(size, vec![size.pick(0.35, 0.6)]);
        let methods =
            [BurstMethod::SiftFrame, BurstMethod::SiftMerge, BurstMethod::Buff1d, BurstMethod::Buff2d].to_vec();
        let frame_counts = size.pick(crate::evaluate::frames::FRAME_COUNTS.to_vec(), vec![2, 5, 10]);
        Self { study: FramesStudy { charts: ChartStudy { methods, ..charts }, frame_counts } }
    }
}

impl MakeFigure for FramesFigure {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made, FiguresError> {
        let report = self.study.run(monitor)?;
        let mut csv = String::from(
            "frames,method,discs_found,discs_found_error,default_discs_found,default_discs_found_error,default_false,default_false_error\n",
        );
        for row in &report.rows {
            for method in &row.methods {
                let pair = |mean: Mean| {
                    let error = mean.standard_error.map_or(String::new(), |error| format!("{error:.4}"));
                    format!("{:.4},{error}", mean.mean)
                };
                // Writing into a string cannot fail.
                let _ = writeln!(
                    csv,
                    "{},{},{},{},{}",
                    row.frames,
                    method.method.name(),
                    pair(method.true_positives),
                    pair(method.default_true_positives),
                    pair(method.default_false_features)
                );
            }
        }
        Ok(Made { svg: frames_svg(&report), csv, notes: Vec::new() })
    }
}
