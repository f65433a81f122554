//! The study as Tables 1 to 3, means over the trajectories of each motion, and as Fig. 8, true and estimated paths.

use super::mapper::{Matched, Reconstructed, Run};
use super::study::Study;
use crate::evaluate::{BurstMethod, curves::LINE, motion_name, poses::Projection};
use crate::figures::Made;
use crate::synth::{Light, Motion};
use burstscope_core::export::sheet::{Area, INK, SOLID, Sheet};
use burstscope_core::export::{Cell, Plot, Series, SeriesPoint, Table};
use burstscope_core::matching::MatchParams;

/// Minimum number of images with a pose of a reconstruction that converged.
const MIN_REGISTERED: usize = 3;

type Group<'a> = Vec<&'a Run>;

fn groups(runs: &[Run]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for run in runs {
        match groups.iter_mut().find(|g| (g[0].motion, g[0].method) == (run.motion, run.method)) {
            Some(group) => group.push(run),
            None => groups.push(vec![run]),
        }
    }
    groups
}

fn mean(group: &Group<'_>, value: impl Fn(&Run) -> Option<f64>) -> Option<f64> {
    let known: Vec<f64> = group.iter().filter_map(|run| value(run)).collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

fn of_model(group: &Group<'_>, value: impl Fn(&Reconstructed, &Run) -> Option<f64>) -> Option<f64> {
    mean(group, |run| run.reconstructed.as_ref().and_then(|model| value(model, run)))
}

fn material(study: &Study) -> String {
    let way = &study.way;
    let light = match way.light {
        Light::Snr(snr) => format!("SNR {snr} of a pixel"),
        Light::Electrons(electrons) => format!("{electrons} electrons at scene white"),
    };
    format!(
        "{} of each motion, {} bursts of {} frames of {}×{}, {light}, motion up to {} px/frame.",
        if study.seeds == 1 { "One trajectory".to_owned() } else { format!("{} trajectories", study.seeds) },
        way.bursts,
        way.frames,
        way.width,
        way.height,
        way.max_slope
    )
}

/// Column of numbers: the lines of its head, its name in CSV, its decimals, and its value for a group.
type Column<'a> = ([&'static str; 2], &'static str, usize, &'a dyn Fn(&Group<'_>) -> Option<f64>);

fn made(title: &str, columns: &[Column<'_>], groups: &[Group<'_>], notes: Vec<String>) -> Made {
    let row = |group: &Group<'_>| {
        let names = [motion_name(group[0].motion).to_uppercase(), group[0].method.label().to_owned()];
        let number = |(_, _, decimals, value): &Column<'_>| Cell::of(value(group), *decimals);
        names.map(Cell::Text).into_iter().chain(columns.iter().map(number)).collect()
    };
    let names = [(["motion", ""], "motion"), (["method", ""], "method")];
    let heads = names.into_iter().chain(columns.iter().map(|(head, name, ..)| (*head, *name)));
    let table = Table {
        title: title.to_owned(),
        columns: heads.map(|(head, name)| (head.map(str::to_owned), name.to_owned())).collect(),
        rows: groups.iter().map(row).collect(),
        notes,
    };
    Made { svg: table.drawing().svg(), csv: table.csv(), notes: table.notes }
}

/// Notes under every table: the material, and what is missing in the table and why.
fn notes(study: &Study, runs: &[Run], missing: Option<&str>) -> Vec<String> {
    std::iter::once(material(study)).chain(missing.map(str::to_owned)).chain(without_model(runs)).collect()
}

/// The number of runs in which COLMAP gave up, with its message in the first of them.
pub(super) fn without_model<'a>(runs: &'a [Run]) -> Option<String> {
    let said = |run: &'a Run| Some((run, run.reconstructed.as_ref()?.gave_up.as_deref()?));
    let mut gave_up = runs.iter().filter_map(said);
    let (first, words) = gave_up.next()?;
    let count = 1 + gave_up.count();
    let name = format!("{} on motion in {}", first.method.label(), motion_name(first.motion).to_uppercase());
    Some(format!("COLMAP gave up without a model in {count} of {} runs, first with {name}: “{words}”.", runs.len()))
}

pub(super) fn matching(study: &Study, runs: &[Run], missing: Option<&str>) -> Made {
    let converged = |m: &Reconstructed, _: &Run| Some(f64::from(u8::from(m.registered >= MIN_REGISTERED)));
    let passed = |m: &Reconstructed, run: &Run| Some(100.0 * m.registered as f64 / run.bursts as f64);
    let matched = |value: fn(&Matched) -> Option<f64>| move |g: &Group<'_>| mean(g, |run| value(&run.matched));
    let columns: [Column<'_>; 9] = [
        (["conver-", "gence"], "convergence_rate", 2, &|g| of_model(g, converged)),
        (["images", "pass, %"], "images_pass_percent", 0, &|g| of_model(g, passed)),
        (["keypoints", "/image"], "keypoints_per_image", 0, &matched(|m| Some(m.keypoints))),
        (["putative", "/image"], "putative_per_image", 1, &matched(|m| Some(m.putative))),
        (["inliers", "/image"], "inliers_per_image", 1, &matched(|m| Some(m.inliers))),
        (["match", "ratio"], "match_ratio", 3, &matched(|m| Some(m.match_ratio))),
        (["match", "score"], "match_score", 3, &matched(|m| Some(m.match_score))),
        (["inlier", "ratio"], "inlier_ratio", 3, &matched(|m| m.inlier_ratio)),
        (["3D points", "/image"], "points_per_image", 1, &|g| of_model(g, |m, _| m.points_per_image)),
    ];
    let MatchParams { predict, align, .. } = study.matching;
    let how = format!("Matched by --predict {predict} --align {align}; each match counts for both of its images.");
    let notes = std::iter::once(how).chain(notes(study, runs, missing)).collect();
    made("Matching and reconstruction of dark bursts", &columns, &groups(runs), notes)
}

pub(super) fn poses(study: &Study, runs: &[Run], missing: Option<&str>) -> Made {
    let error = |errors: fn(&Reconstructed) -> Option<[f64; 2]>, part: usize, factor: f64| {
        move |g: &Group<'_>| of_model(g, |m, _| errors(m).map(|e| factor * e[part]))
    };
    let columns: [Column<'_>; 4] = [
        (["absolute", "place, cm"], "absolute_translation_cm", 2, &error(|m| m.absolute, 0, 100.0)),
        (["absolute", "rotation, °"], "absolute_rotation_deg", 3, &error(|m| m.absolute, 1, 1.0)),
        (["relative", "place, cm"], "relative_translation_cm", 2, &error(|m| m.relative, 0, 100.0)),
        (["relative", "rotation, °"], "relative_rotation_deg", 3, &error(|m| m.relative, 1, 1.0)),
    ];
    let title = "Mean errors of the camera poses against the true ones";
    made(title, &columns, &groups(runs), notes(study, runs, missing))
}

pub(super) fn time(study: &Study, runs: &[Run], missing: Option<&str>) -> Made {
    let features = |g: &Group<'_>| mean(g, |run| Some(run.matched.seconds));
    let mapper = |g: &Group<'_>| of_model(g, |m, _| Some(m.mapper_secs));
    let columns: [Column<'_>; 3] = [
        (["features and", "matches"], "features_and_matches_secs", 2, &features),
        (["COLMAP's", "mapper"], "mapper_secs", 2, &mapper),
        (["together", ""], "together_secs", 2, &|g| Some(features(g)? + mapper(g)?)),
    ];
    let mut groups = groups(runs);
    // Sharp images are no input of a method for bursts, so that their time compares with nothing.
    groups.retain(|group| group[0].method != BurstMethod::Gold);
    let mut notes = notes(study, runs, missing);
    let threads = rayon::current_num_threads();
    notes.push(format!(
        "Seconds for one trajectory with {}, finding and matching features from frames in memory; times of a machine that does other things too are longer.",
        if threads == 1 { "one thread".to_owned() } else { format!("{threads} threads") }
    ));
    made("Time for one trajectory, seconds", &columns, &groups, notes)
}

const WIDTH: f64 = 960.0;

const ENLARGEMENTS: [u32; 7] = [2, 5, 10, 20, 50, 100, 200];
/// Maximum distance of an enlarged error from its true position, as a share of the trajectory's length.
const FARTHEST: f64 = 0.1;
const ENLARGED: &str = "Estimated places are drawn farther from the true ones than they are, as the titles say, so that \
                        they can be told apart; the table of numbers has them as they are.";

/// Index of a camera on the trajectory, and its centre, metres.
type Centre = (usize, [f64; 3]);

fn centres_of(run: &Run) -> Option<Vec<Centre>> {
    let centres = run.reconstructed.as_ref()?.centres.iter().copied();
    let known: Vec<Centre> = centres.filter(|centre| centre.0 < run.true_centres.len()).collect();
    (!known.is_empty()).then_some(known)
}

/// Draws the trajectories; `missing` is the reason why there are no estimates.
pub(super) fn trajectories(runs: &[Run], missing: Option<&str>) -> Made {
    let mut sheet = Sheet::new(WIDTH, "Trajectories");
    let mut csv = String::from("motion,method,index,x,y,z\n");
    let title = "The camera's way past the scene: true places, and those that COLMAP found";
    sheet.heading((20.0, 28.0), 15.0, title);
    let mut legend: Vec<Series> = Vec::new();
    let mut enlarged = false;
    for (column, motion) in [Motion::OneD, Motion::TwoD].into_iter().enumerate() {
        // The first trajectory of a motion stands for all: a mean of paths would be none of them.
        let of_way: Vec<&Run> = runs.iter().filter(|run| run.motion == motion && run.seed == 1).collect();
        let Some(truth) = of_way.first().map(|run| &run.true_centres) else { continue };
        // Axes of the true path, so that all methods are seen from the same side.
        let cameras: Vec<_> = truth.iter().map(|&[x, y, z]| nalgebra::Isometry3::translation(x, y, z)).collect();
        let axes = Projection::Principal.axes(&cameras);
        let numbered: Vec<Centre> = truth.iter().copied().enumerate().collect();
        write_centres(&mut csv, motion, "truth", &numbered);
        let project = |&(_, centre): &Centre| axes.project(centre);
        let places: Vec<[f64; 2]> = numbered.iter().map(project).collect();
        let estimates: Vec<(BurstMethod, Vec<Centre>)> =
            of_way.iter().filter_map(|run| Some((run.method, centres_of(run)?))).collect();
        let all_centres = estimates.iter().flat_map(|(_, centres)| centres);
        // One factor for all methods of a plot keeps their errors comparable.
        let factor = enlargement(&places, all_centres.map(|centre| (centre.0, project(centre))));
        enlarged |= factor > 1;
        let drawn = |centre: &Centre| {
            let ([x, y], [true_x, true_y]) = (project(centre), places[centre.0]);
            let factor = f64::from(factor);
            SeriesPoint { x: true_x + factor * (x - true_x), y: true_y + factor * (y - true_y), spread: None }
        };
        let series = |label: &str, style, centres: &[Centre]| {
            Series::new(label, style, LINE, centres.iter().map(drawn).collect())
        };
        let mut all = vec![series("true places", (INK, SOLID), &numbered)];
        for (method, centres) in &estimates {
            // The table has the places as they are; only the picture enlarges errors.
            write_centres(&mut csv, motion, method.name(), centres);
            all.push(series(method.label(), method.line(), centres));
        }
        let area = Area { x: 76.0 + 480.0 * column as f64, y: 110.0, width: 380.0, height: 300.0 };
        let (range_x, range_y) = ranges(&all, area.width / area.height);
        let name = if motion == Motion::OneD { "sideways (1D)" } else { "forward (2D)" };
        let title = if factor == 1 { name.to_owned() } else { format!("{name}, errors {factor} times as large") };
        let (label_x, label_y) = ("along the way, m", "across it, m");
        let plot = Plot { title: &title, label_x, label_y, range_x, range_y, has_dots: true, series: &all };
        sheet.plot(area, &plot);
        // The plots share a legend, in which a method stands once.
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
    Made { svg: sheet.finish(end).svg(), csv, notes }
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
        *csv += &format!("{},{method},{index},{x:.6},{y:.6},{z:.6}\n", motion_name(motion));
    }
}

/// Ranges of the axes that contain all points with a margin and have one scale, for an area of this shape.
fn ranges(all: &[Series], width_over_height: f64) -> ((f64, f64), (f64, f64)) {
    let range = |value: fn(&SeriesPoint) -> f64| {
        let values = all.iter().flat_map(|series| &series.points).map(value);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (x, y) = (range(|p| p.x), range(|p| p.y));
    // A tenth to spare around the points; the floor keeps a single place drawable.
    let half = (0.55 * (x.1 - x.0)).max(0.55 * (y.1 - y.0) * width_over_height).max(1e-3);
    let around = |range: (f64, f64), half: f64| (0.5 * (range.0 + range.1) - half, 0.5 * (range.0 + range.1) + half);
    (around(x, half), around(y, half / width_over_height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{evaluate::BurstMethod, figures::FigureSize};

    fn run(motion: Motion, seed: u64, method: BurstMethod, reconstructed: Option<Reconstructed>) -> Run {
        let k = seed as f64;
        let matched = Matched {
            keypoints: 100.0 * k,
            putative: 10.0 * k,
            inliers: 8.0 * k,
            match_ratio: 0.1,
            match_score: 0.08,
            inlier_ratio: (seed > 1).then_some(0.8),
            seconds: k,
        };
        Run { motion, seed, method, bursts: 8, matched, reconstructed, true_centres: Vec::new() }
    }

    #[test]
    fn trajectories_of_one_motion_are_averaged_and_what_is_missing_stays_missing() {
        let study = Study::new(FigureSize::Quick);
        let buff = BurstMethod::Buff1d;
        let model = Reconstructed {
            registered: 6,
            points_per_image: Some(50.0),
            absolute: Some([0.02, 1.0]),
            relative: Some([0.01, 0.5]),
            mapper_secs: 4.0,
            ..Reconstructed::default()
        };
        let none = Reconstructed { gave_up: Some("ERROR: no pair".into()), ..Reconstructed::default() };
        let runs = [
            run(Motion::OneD, 1, BurstMethod::Gold, None),
            run(Motion::OneD, 1, buff, Some(model.clone())),
            run(Motion::OneD, 2, buff, Some(none)),
        ];
        let table = matching(&study, &runs, Some("no COLMAP"));
        let lines: Vec<&str> = table.csv.lines().collect();
        assert_eq!(lines[1], "1D,gold standard,,,100,10,8,0.1,0.08,,");
        // One of two converged; six of eight images and none of eight; an inlier ratio where there is one.
        assert_eq!(lines[2], "1D,BuFF 1D,0.5,37.5,150,15,12,0.1,0.08,0.8,50");
        assert!(table.notes.iter().any(|note| note == "no COLMAP"));
        assert!(
            table.notes.iter().any(|note| note.contains("1 of 3 runs, first with BuFF 1D on motion in 1D: “ERROR"))
        );
        assert_eq!(poses(&study, &runs, None).csv.lines().nth(2), Some("1D,BuFF 1D,2,1,1,0.5"));
        let times = time(&study, &runs, None);
        assert_eq!(times.csv.lines().collect::<Vec<_>>()[1..], ["1D,BuFF 1D,1.5,2,3.5"]);
    }

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
        let true_centres = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let run = Run { true_centres, ..run(Motion::OneD, 1, BurstMethod::Gold, Some(model)) };
        let made = trajectories(&[run], None);
        let rows: Vec<&str> = made.csv.lines().filter(|line| line.starts_with("1d,gold")).collect();
        assert_eq!(rows, ["1d,gold,0,0.000000,0.000000,0.000000", "1d,gold,2,2.000000,0.010000,0.000000"]);
        assert!(made.svg.contains("errors 20 times as large") && made.notes == [ENLARGED]);
    }

    #[test]
    fn both_axes_have_one_scale_and_hold_all_points() {
        let points = [(0.0, 0.0), (4.0, 1.0)].map(|(x, y)| SeriesPoint { x, y, spread: None }).to_vec();
        let (x, y) = ranges(&[Series::new("a", (INK, SOLID), 1.0, points)], 2.0);
        assert!(((x.1 - x.0) / (y.1 - y.0) - 2.0).abs() < 1e-12);
        assert!(x.0 < 0.0 && x.1 > 4.0 && y.0 < 0.0 && y.1 > 1.0);
    }
}
