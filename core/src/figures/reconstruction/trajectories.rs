//! Fig. 8: the cameras' positions, true and estimated, for the first trajectory of each motion.

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

/// Factors by which errors can be enlarged.
const ENLARGEMENTS: [u32; 7] = [2, 5, 10, 20, 50, 100, 200];
/// Maximum distance of an enlarged error from its true position, as a share of the trajectory's length.
const FARTHEST: f64 = 0.1;
/// Note where errors are enlarged.
const ENLARGED: &str = "Estimated places are drawn farther from the true ones than they are, as the titles say, so that \
                        they can be told apart; the table of numbers has them as they are.";

/// Index of a camera on the trajectory, and its centre, metres.
type Centre = (usize, [f64; 3]);

/// The estimated cameras of a run, if there are any.
fn centres_of(run: &Run) -> Option<Vec<Centre>> {
    let centres = run.reconstructed.as_ref()?.centres.iter().copied();
    let known: Vec<Centre> = centres.filter(|centre| centre.0 < run.true_centres.len()).collect();
    (!known.is_empty()).then_some(known)
}

/// Draws the trajectories; `missing` is the reason why there are no estimates.
pub(super) fn figure(runs: &[Run], missing: Option<&str>) -> Made {
    let mut sheet = Sheet::new(WIDTH, "Trajectories");
    let mut csv = String::from("motion,method,index,x,y,z\n");
    let title = "The camera's way past the scene: true places, and those that COLMAP found";
    sheet.styled_text((20.0, 28.0), 15.0, Anchor::Start, r#"font-weight="bold""#, title);
    let mut legend: Vec<Series> = Vec::new();
    let mut enlarged = false;
    for (column, motion) in [Motion::OneD, Motion::TwoD].into_iter().enumerate() {
        let of_way: Vec<&Run> = runs.iter().filter(|run| run.motion == motion && run.seed == 1).collect();
        let Some(truth) = of_way.first().map(|run| &run.true_centres) else { continue };
        let axes = Projection::Principal.axes(truth);
        let numbered: Vec<Centre> = truth.iter().copied().enumerate().collect();
        write_centres(&mut csv, motion, "truth", &numbered);
        let project = |&(_, centre): &Centre| axes.project(centre);
        let places: Vec<[f64; 2]> = numbered.iter().map(project).collect();
        let estimates: Vec<(MatchMethod, Vec<Centre>)> =
            of_way.iter().filter_map(|run| Some((run.method, centres_of(run)?))).collect();
        let all_centres = estimates.iter().flat_map(|(_, centres)| centres);
        let factor = enlargement(&places, all_centres.map(|centre| (centre.0, project(centre))));
        enlarged |= factor > 1;
        let drawn = |centre: &Centre| {
            let ([x, y], [true_x, true_y]) = (project(centre), places[centre.0]);
            let factor = f64::from(factor);
            (true_x + factor * (x - true_x), true_y + factor * (y - true_y), None)
        };
        let series = |label: &str, (colour, dashes, width), centres: &[Centre]| Series {
            label: label.to_owned(),
            colour,
            dashes,
            width,
            points: centres.iter().map(drawn).collect(),
        };
        let mut all = vec![series("true places", ("#24292f", "", 1.6), &numbered)];
        for (method, centres) in &estimates {
            let style = match method {
                MatchMethod::Burst(method) => method_line(*method),
                MatchMethod::Gold => ("#e69f00", "2 2", 2.0),
            };
            write_centres(&mut csv, motion, method.name(), centres);
            all.push(series(method.label(), style, centres));
        }
        let area = Area { x: 76.0 + 480.0 * column as f64, y: 110.0, width: 380.0, height: 300.0 };
        let (range_x, range_y) = ranges(&all, area.width / area.height);
        let name = match motion {
            Motion::OneD => "sideways (1D)",
            Motion::TwoD => "forward (2D)",
        };
        let title = match factor {
            1 => name.to_owned(),
            _ => format!("{name}, errors {factor} times as large"),
        };
        let plot = Plot {
            title: &title,
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
    let enlarged = enlarged.then(|| ENLARGED.to_owned());
    let notes: Vec<String> =
        enlarged.into_iter().chain(missing.map(str::to_owned)).chain(without_model(runs)).collect();
    for note in &notes {
        end = sheet.paragraph((20.0, end), 12.0, WIDTH - 40.0, note) + 4.0;
    }
    Made { svg: sheet.finish(end), csv, notes }
}

/// Factor by which errors are enlarged, so that good estimates can be told apart: the largest of [`ENLARGEMENTS`] with
/// which none exceeds [`FARTHEST`] of the trajectory's length; 1 if there is none. `places` are the true positions.
fn enlargement(places: &[[f64; 2]], estimates: impl Iterator<Item = (usize, [f64; 2])>) -> u32 {
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let farthest = estimates.map(|(k, at)| distance(at, places[k])).fold(0.0, f64::max);
    let (Some(&first), Some(&last)) = (places.first(), places.last()) else { return 1 };
    let room = FARTHEST * distance(first, last);
    let fits = |factor: &&u32| f64::from(**factor) * farthest <= room;
    ENLARGEMENTS.iter().filter(|_| farthest > 0.0).rfind(fits).copied().unwrap_or(1)
}

fn write_centres(csv: &mut String, motion: Motion, method: &str, centres: &[Centre]) {
    for (index, [x, y, z]) in centres {
        // Writing into a string cannot fail.
        let _ = writeln!(csv, "{},{method},{index},{x:.6},{y:.6},{z:.6}", motion_name(motion));
    }
}

/// Ranges of the axes that contain all points with a margin and have one scale, for an area of this shape.
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
    use super::super::run::{Matched, Reconstructed};
    use super::*;

    #[test]
    fn errors_are_enlarged_until_they_are_seen_and_no_farther() {
        let places = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        let of = |error: f64| enlargement(&places, [(1, [1.0, error]), (2, [2.0, 0.0])].into_iter());
        assert_eq!((of(0.003), of(0.02), of(0.5), of(0.0), of(1e-9)), (50, 10, 1, 1, 200));
    }

    #[test]
    fn cameras_that_are_not_registered_leave_the_others_at_their_numbers() {
        let model = Reconstructed {
            registered: 2,
            centres: vec![(0, [0.0, 0.0, 0.0]), (2, [2.0, 0.01, 0.0])],
            ..Reconstructed::default()
        };
        let run = Run {
            motion: Motion::OneD,
            seed: 1,
            method: MatchMethod::Gold,
            bursts: 3,
            matched: Matched::default(),
            reconstructed: Some(model),
            true_centres: vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        };
        let made = figure(&[run], None);
        let rows: Vec<&str> = made.csv.lines().filter(|line| line.starts_with("1d,gold")).collect();
        assert_eq!(rows, ["1d,gold,0,0.000000,0.000000,0.000000", "1d,gold,2,2.000000,0.010000,0.000000"]);
        assert!(made.svg.contains("errors 20 times as large") && made.notes == [ENLARGED]);
    }

    #[test]
    fn both_axes_have_one_scale_and_hold_all_points() {
        let points = vec![(0.0, 0.0, None), (4.0, 1.0, None)];
        let series = Series { label: "a".into(), colour: "#000000", dashes: "", width: 1.0, points };
        let (x, y) = ranges(&[series], 2.0);
        assert!(((x.1 - x.0) / (y.1 - y.0) - 2.0).abs() < 1e-12);
        assert!(x.0 < 0.0 && x.1 > 4.0 && y.0 < 0.0 && y.1 > 1.0);
    }
}
