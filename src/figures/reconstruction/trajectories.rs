//! Fig. 8: the cameras' places, true and estimated, for the first trajectory of each motion.

use super::run::Run;
use super::tables::without_model;
use crate::evaluate::figure::method_line;
use crate::evaluate::poses::Projection;
use crate::evaluate::{MatchMethod, motion_name};
use crate::export::sheet::{Anchor, Area, Sheet};
use crate::export::{Plot, Series};
use crate::figures::Made;
use crate::synth::Motion;
use std::fmt::Write;

const WIDTH: f64 = 960.0;

/// Draws the trajectories; `missing` says why there are no estimates.
pub(super) fn figure(runs: &[Run], missing: Option<&str>) -> Made {
    let mut sheet = Sheet::new(WIDTH, "Trajectories");
    let mut csv = String::from("motion,method,index,x,y,z\n");
    let title = "The camera's way past the scene: true places, and those that COLMAP found";
    sheet.styled_text((20.0, 28.0), 15.0, Anchor::Start, r#"font-weight="bold""#, title);
    let mut legend: Vec<Series> = Vec::new();
    for (column, motion) in [Motion::OneD, Motion::TwoD].into_iter().enumerate() {
        let of_way: Vec<&Run> = runs.iter().filter(|run| run.motion == motion && run.seed == 1).collect();
        let Some(truth) = of_way.first().map(|run| &run.true_centres) else { continue };
        let axes = Projection::Principal.axes(truth);
        write_centres(&mut csv, motion, "truth", truth);
        let series = |label: &str, (colour, dashes, width), centres: &[[f64; 3]]| Series {
            label: label.to_owned(),
            colour,
            dashes,
            width,
            points: centres.iter().map(|&c| axes.project(c)).map(|[x, y]| (x, y, None)).collect(),
        };
        let mut all = vec![series("true places", ("#24292f", "", 1.6), truth)];
        for run in &of_way {
            let Some(model) = run.reconstructed.as_ref().filter(|model| !model.centres.is_empty()) else { continue };
            let style = match run.method {
                MatchMethod::Burst(method) => method_line(method),
                MatchMethod::Gold => ("#e69f00", "2 2", 2.0),
            };
            write_centres(&mut csv, motion, run.method.name(), &model.centres);
            all.push(series(run.method.label(), style, &model.centres));
        }
        let area = Area { x: 76.0 + 480.0 * column as f64, y: 110.0, width: 380.0, height: 300.0 };
        let (range_x, range_y) = ranges(&all, area.width / area.height);
        let name = match motion {
            Motion::OneD => "sideways (1D)",
            Motion::TwoD => "forward (2D)",
        };
        let plot = Plot {
            title: name,
            label_x: "along the way, m",
            label_y: "across it, m",
            range_x,
            range_y,
            has_dots: true,
            series: &all,
        };
        sheet.plot(area, &plot);
        for one in all {
            if legend.iter().all(|known| known.label != one.label) {
                legend.push(one);
            }
        }
    }
    sheet.legend((20.0, 54.0), WIDTH - 40.0, &legend);
    let mut end = 470.0;
    let notes: Vec<String> = missing.map(str::to_owned).into_iter().chain(without_model(runs)).collect();
    for note in &notes {
        end = sheet.paragraph((20.0, end), 12.0, WIDTH - 40.0, note) + 4.0;
    }
    Made { svg: sheet.finish(end), csv, notes }
}

fn write_centres(csv: &mut String, motion: Motion, method: &str, centres: &[[f64; 3]]) {
    for (index, [x, y, z]) in centres.iter().enumerate() {
        // Writing into a string cannot fail.
        let _ = writeln!(csv, "{},{method},{index},{x:.6},{y:.6},{z:.6}", motion_name(motion));
    }
}

/// Ranges of the axes that hold all points with a margin and have one scale, for an area of this shape.
fn ranges(all: &[Series], width_over_height: f64) -> ((f64, f64), (f64, f64)) {
    let range = |value: fn(&(f64, f64, Option<f64>)) -> f64| {
        let values = all.iter().flat_map(|series| &series.points).map(value);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (x, y) = (range(|p| p.0), range(|p| p.1));
    let half = (0.55 * (x.1 - x.0)).max(0.55 * (y.1 - y.0) * width_over_height).max(1e-3);
    let around = |range: (f64, f64), half: f64| (0.5 * (range.0 + range.1) - half, 0.5 * (range.0 + range.1) + half);
    (around(x, half), around(y, half / width_over_height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_axes_have_one_scale_and_hold_all_points() {
        let points = vec![(0.0, 0.0, None), (4.0, 1.0, None)];
        let series = Series { label: "a".into(), colour: "#000000", dashes: "", width: 1.0, points };
        let (x, y) = ranges(&[series], 2.0);
        assert!(((x.1 - x.0) / (y.1 - y.0) - 2.0).abs() < 1e-12);
        assert!(x.0 < 0.0 && x.1 > 4.0 && y.0 < 0.0 && y.1 > 1.0);
    }
}
