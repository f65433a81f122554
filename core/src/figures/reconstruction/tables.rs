//! The study's tables: means over the trajectories of each motion.

use super::run::{Reconstructed, Run};
use super::study::Study;
use crate::evaluate::{MatchMethod, motion_name};
use crate::figures::Made;
use crate::figures::table::{Cell, Table};
use crate::synth::Light;

/// Minimum number of images with a pose of a reconstruction that converged.
const MIN_REGISTERED: usize = 3;

/// The runs of one method and motion.
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

/// The mean of the known values; `None` without any.
fn mean(group: &Group<'_>, value: impl Fn(&Run) -> Option<f64>) -> Option<f64> {
    let known: Vec<f64> = group.iter().filter_map(|run| value(run)).collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

fn of_model(group: &Group<'_>, value: impl Fn(&Reconstructed, &Run) -> Option<f64>) -> Option<f64> {
    mean(group, |run| run.reconstructed.as_ref().and_then(|model| value(model, run)))
}

fn names(group: &Group<'_>) -> [Cell; 2] {
    [motion_name(group[0].motion).to_uppercase(), group[0].method.label().to_owned()].map(Cell::Text)
}

/// Description of the trajectories, as a sentence.
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

fn made(table: Table) -> Made {
    Made { svg: table.svg(), csv: table.csv(), notes: table.notes }
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

/// Table 1.
pub(super) fn matching(study: &Study, runs: &[Run], missing: Option<&str>) -> Made {
    let row = |group: &Group<'_>| {
        let matched = |value: fn(&super::run::Matched) -> f64| mean(group, |run| Some(value(&run.matched)));
        let [motion, method] = names(group);
        vec![
            motion,
            method,
            Cell::of(of_model(group, |m, _| Some(f64::from(u8::from(m.registered >= MIN_REGISTERED)))), 2),
            Cell::of(of_model(group, |m, run| Some(100.0 * m.registered as f64 / run.bursts as f64)), 0),
            Cell::of(matched(|m| m.keypoints), 0),
            Cell::of(matched(|m| m.putative), 1),
            Cell::of(matched(|m| m.inliers), 1),
            Cell::of(matched(|m| m.match_ratio), 3),
            Cell::of(matched(|m| m.match_score), 3),
            Cell::of(mean(group, |run| run.matched.precision), 3),
            Cell::of(of_model(group, |m, _| m.points_per_image), 1),
        ]
    };
    made(Table {
        title: "Matching and reconstruction of dark bursts".into(),
        columns: vec![
            (["motion", ""], "motion"),
            (["method", ""], "method"),
            (["conver-", "gence"], "convergence_rate"),
            (["images", "pass, %"], "images_pass_percent"),
            (["keypoints", "/image"], "keypoints_per_image"),
            (["putative", "/image"], "putative_per_image"),
            (["inliers", "/image"], "inliers_per_image"),
            (["match", "ratio"], "match_ratio"),
            (["match", "score"], "match_score"),
            (["precision", ""], "precision"),
            (["3D points", "/image"], "points_per_image"),
        ],
        rows: groups(runs).iter().map(row).collect(),
        notes: notes(study, runs, missing),
    })
}

/// Table 2.
pub(super) fn poses(study: &Study, runs: &[Run], missing: Option<&str>) -> Made {
    let row = |group: &Group<'_>| {
        let [motion, method] = names(group);
        let error = |errors: fn(&Reconstructed) -> Option<[f64; 2]>, part: usize, factor: f64| {
            of_model(group, |m, _| errors(m).map(|e| factor * e[part]))
        };
        vec![
            motion,
            method,
            Cell::of(error(|m| m.absolute, 0, 100.0), 2),
            Cell::of(error(|m| m.absolute, 1, 1.0), 3),
            Cell::of(error(|m| m.relative, 0, 100.0), 2),
            Cell::of(error(|m| m.relative, 1, 1.0), 3),
        ]
    };
    made(Table {
        title: "Mean errors of the camera poses against the true ones".into(),
        columns: vec![
            (["motion", ""], "motion"),
            (["method", ""], "method"),
            (["absolute", "place, cm"], "absolute_translation_cm"),
            (["absolute", "rotation, °"], "absolute_rotation_deg"),
            (["relative", "place, cm"], "relative_translation_cm"),
            (["relative", "rotation, °"], "relative_rotation_deg"),
        ],
        rows: groups(runs).iter().map(row).collect(),
        notes: notes(study, runs, missing),
    })
}

/// Table 3.
pub(super) fn time(study: &Study, runs: &[Run], missing: Option<&str>) -> Made {
    let row = |group: &Group<'_>| {
        let [motion, method] = names(group);
        let features = mean(group, |run| Some(run.matched.seconds));
        let mapper = of_model(group, |m, _| Some(m.mapper_secs));
        let whole = features.zip(mapper).map(|(a, b)| a + b);
        vec![motion, method, Cell::of(features, 2), Cell::of(mapper, 2), Cell::of(whole, 2)]
    };
    let is_timed = |group: &&Group<'_>| group[0].method != MatchMethod::Gold;
    let mut notes = notes(study, runs, missing);
    let threads = rayon::current_num_threads();
    notes.push(format!(
        "Seconds for one trajectory with {}, finding and matching features from frames in memory; times of a machine that does other things too are longer.",
        if threads == 1 { "one thread".to_owned() } else { format!("{threads} threads") }
    ));
    made(Table {
        title: "Time for one trajectory, seconds".into(),
        columns: vec![
            (["motion", ""], "motion"),
            (["method", ""], "method"),
            (["features and", "matches"], "features_and_matches_secs"),
            (["COLMAP's", "mapper"], "mapper_secs"),
            (["together", ""], "together_secs"),
        ],
        rows: groups(runs).iter().filter(is_timed).map(row).collect(),
        notes,
    })
}

#[cfg(test)]
mod tests {
    use super::super::run::Matched;
    use super::*;
    use crate::evaluate::BurstMethod;
    use crate::figures::FigureSize;
    use crate::synth::Motion;

    fn run(motion: Motion, seed: u64, method: MatchMethod, reconstructed: Option<Reconstructed>) -> Run {
        let k = seed as f64;
        let matched = Matched {
            keypoints: 100.0 * k,
            putative: 10.0 * k,
            inliers: 8.0 * k,
            match_ratio: 0.1,
            match_score: 0.08,
            precision: (seed > 1).then_some(0.8),
            seconds: k,
        };
        Run { motion, seed, method, bursts: 8, matched, reconstructed, true_centres: Vec::new() }
    }

    #[test]
    fn trajectories_of_one_motion_are_averaged_and_what_is_missing_stays_missing() {
        let study = Study::new(FigureSize::Quick);
        let buff = MatchMethod::Burst(BurstMethod::Buff1d);
        let model = Reconstructed {
            registered: 6,
            points_per_image: Some(50.0),
            absolute: Some([0.02, 1.0]),
            relative: Some([0.01, 0.5]),
            centres: Vec::new(),
            mapper_secs: 4.0,
            gave_up: None,
        };
        let none = Reconstructed { gave_up: Some("ERROR: no pair".into()), ..Reconstructed::default() };
        let runs = [
            run(Motion::OneD, 1, MatchMethod::Gold, None),
            run(Motion::OneD, 1, buff, Some(model.clone())),
            run(Motion::OneD, 2, buff, Some(none)),
        ];
        let table = matching(&study, &runs, Some("no COLMAP"));
        let lines: Vec<&str> = table.csv.lines().collect();
        assert_eq!(lines[1], "1D,gold standard,,,100,10,8,0.1,0.08,,");
        // One of two converged; six of eight images and none of eight; precision where there is one.
        assert_eq!(lines[2], "1D,BuFF 1D,0.5,37.5,150,15,12,0.1,0.08,0.8,50");
        assert!(table.notes.iter().any(|note| note == "no COLMAP"));
        assert!(
            table.notes.iter().any(|note| note.contains("1 of 3 runs, first with BuFF 1D on motion in 1D: “ERROR"))
        );
        let errors = poses(&study, &runs, None);
        assert_eq!(errors.csv.lines().nth(2), Some("1D,BuFF 1D,2,1,1,0.5"));
        let times = time(&study, &runs, None);
        assert_eq!(times.csv.lines().collect::<Vec<_>>()[1..], ["1D,BuFF 1D,1.5,2,3.5"]);
    }
}
