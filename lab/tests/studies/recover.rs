//! Laws of planted things: they are found where charts of the same things are, at the SNR that noise and gate say, and
//! between the slopes of a coarse grid as much less as the step makes them weaker.

use crate::prelude::*;
use burstscope_lab::evaluate::{BurstMethod, ChartStudy, RowStudy, Searches};
use burstscope_lab::recover::plots::{recover_figure, recover_plots};
use burstscope_lab::recover::report::planted_table;
use burstscope_lab::recover::{Contrast, RecoverReport, RecoverStudy, Shape, Varied};
use std::sync::Mutex;

fn chart(discs: usize, snr: f64) -> ChartParams {
    let rest = ChartParams { width: 320, height: 240, discs, radius: 5.0..=5.0001, ..ChartParams::default() };
    ChartParams { frames: 8, snr, max_slope: 2.0, ..rest }
}

fn made(params: &ChartParams) -> (Burst, Truth) {
    synth_chart(params, &quiet()).expect("a chart")
}

fn search(slopes: SlopeGrid) -> SearchParams {
    SearchParams::from(DetectorParams { slopes, noise_gate: NoiseGate::Factor(5.0), ..DetectorParams::default() })
}

fn run(study: &RecoverStudy, burst: &Burst) -> RecoverReport {
    study.run(burst, &quiet()).expect("a report")
}

#[test]
fn half_are_found_at_the_snr_that_noise_gate_and_step_say() {
    let (burst, _) = made(&chart(0, 0.5));
    for (shape, contrast) in [(Shape::Disc, Contrast::Bright), (Shape::Blob, Contrast::Dark)] {
        let study = RecoverStudy { search: search(SlopeGrid::line(-2.0..=2.0, 9)), shape, ..RecoverStudy::default() };
        let study = RecoverStudy { contrast, copies: 10, inside: true, ..study };
        let report = run(&study, &burst);
        let half = report.half.expect("within the levels");
        let ratio = half.snr / report.levels.expected_half;
        // Noise also lifts the strongest of several samples: half are found a little earlier.
        assert!((0.75..1.15).contains(&ratio), "{shape:?}: {ratio}, {half:?}");
        assert!(half.error < 0.15 * half.snr, "{half:?}");
        let [first, .., last] = report.over_snr[..] else { panic!("levels") };
        assert!(first.share() < 0.3 && last.share() > 0.85, "{first:?} {last:?}");
    }
    // Outermost frames are misplaced by 3.5 · 1.5 px half-way between: a disc of 4 px loses much.
    // At the SNR at which nearly all of those on the grid are found.
    let grid = SlopeGrid::line(-3.0..=3.0, 3);
    let at = |slope: f32| {
        let study = RecoverStudy {
            search: search(grid),
            slopes: Some(SlopeAxis { min: slope, max: slope, count: 1 }),
            at_radius: 4.0,
            copies: 8,
            per_copy: Some(24),
            inside: true,
            ..RecoverStudy::default()
        };
        run(&study, &burst).over_slope[0]
    };
    let (on, between) = (at(3.0), at(1.5));
    // Expected is a loss of nearly a half. What is found is more: the search takes the largest of many noisy values.
    assert!(on.share() - between.share() > 0.2, "{on:?} {between:?}");
    [on, between].into_iter().for_each(|share| assert!((share.share() - share.expected).abs() < 0.25, "{share:?}"));
}

#[test]
fn planted_discs_are_found_as_those_of_a_chart() {
    // The same camera, exposure, radius, slopes and search: once the discs are part of the chart, once they are
    // planted.
    let with_discs = chart(9, 0.27);
    let grid = SlopeGrid::line(-2.0..=2.0, 9);
    let study = ChartStudy {
        chart: with_discs.clone(),
        snrs: vec![0.27],
        seeds: 12,
        methods: vec![BurstMethod::Buff1d],
        searches: Searches::of_charts(search(grid).at_given(), Some(grid)),
        ..ChartStudy::default()
    };
    let of_chart = &study.run(&quiet()).expect("a report").rows[0].methods[0].default_true_positives;
    let (share, error) = (of_chart.mean / 9.0, of_chart.standard_error.expect("several") / 9.0);
    let (burst, _) = made(&ChartParams { discs: 0, ..with_discs });
    let study = RecoverStudy { search: search(grid), snrs: vec![0.27], at_snr: Some(0.27), ..RecoverStudy::default() };
    let study = RecoverStudy { copies: 12, per_copy: Some(27), inside: true, ..study };
    let planted = run(&study, &burst).over_snr[0];
    let p = planted.share();
    let error = error.hypot((p * (1.0 - p) / planted.planted as f64).sqrt()).max(0.03);
    assert!((p - share).abs() < 3.0 * error, "planted {planted:?}, of charts {share}, error {error}");
    assert!((0.2..0.98).contains(&share), "neither all nor none, so that the comparison says something: {share}");
}

#[test]
fn each_missed_thing_has_a_fate_and_the_map_shows_where_the_noise_is() {
    // The right half has three times the noise.
    let params = ChartParams { discs: 0, ..chart(0, 0.5) };
    let (burst, _) = made(&params);
    let (second, _) = made(&ChartParams { seed: 9, ..params });
    let mut noisy: Vec<Plane> = burst.frames.iter().map(|frame| (**frame).clone()).collect();
    for (frame, more) in noisy.iter_mut().zip(&second.frames) {
        let level = 0.1 + f64::from(frame.data().iter().sum::<f32>()) / frame.data().len() as f64 - 0.1;
        for v in 0..240 {
            for u in 160..320 {
                frame.row_mut(v)[u] += 2.8 * (more.at(u, v) - level as f32);
            }
        }
    }
    let burst = Burst::from_planes("two halves", noisy);
    let study = RecoverStudy { search: search(SlopeGrid::line(-1.0..=1.0, 5)), copies: 12, ..RecoverStudy::default() };
    let told = Mutex::new(Vec::new());
    let tell = |report: RecoverReport| told.lock().expect("not poisoned").push(report.copies_done);
    let report = study.run_telling(&burst, &quiet(), &tell).expect("a report");
    assert_eq!(told.into_inner().expect("not poisoned"), (1..=12).collect::<Vec<u64>>());
    let missed: Vec<_> = report.planted.iter().filter(|one| one.found.is_none()).collect();
    assert!(missed.len() > 10 && missed.iter().all(|one| !one.why.is_empty()));
    assert!(report.fates.iter().any(|fate| fate.reason == "below the noise gate"), "{:?}", report.fates);
    assert_eq!(report.fates.iter().map(|fate| fate.count).sum::<usize>(), missed.len());
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for row in &report.map.rows {
        let middle = row.len() / 2;
        left.extend(row[..middle / 2].iter().flatten());
        right.extend(row[middle + middle / 2..].iter().flatten());
    }
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    assert!(mean(&right) > 1.25 * mean(&left), "{left:?} {right:?}");
    let svg = recover_figure(&report).drawing.svg();
    roxmltree::Document::parse(&svg).expect("sound XML");
    let table = planted_table(&report.planted);
    assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
    assert_eq!(table.csv().lines().count(), 1 + report.planted.len());
    assert_eq!(recover_plots(&report).len(), 3);
    assert!(report.text().contains("noise and gate let expect"), "{}", report.text());
}

#[test]
fn the_same_seeds_give_the_same_things_and_nonsense_is_named() {
    let (burst, _) = made(&chart(6, 0.6));
    let study = RecoverStudy { search: search(SlopeGrid::line(-2.0..=2.0, 5)), copies: 2, ..RecoverStudy::default() };
    let (one, two) = (on_threads(1, || run(&study, &burst)), on_threads(3, || run(&study, &burst)));
    assert_eq!(one.planted, two.planted);
    let (copy, planted) = study.planted_copy(&burst, 2, &quiet()).expect("made again");
    assert_eq!((planted.width, planted.height, planted.frames), (burst.size().0, burst.size().1, burst.len()));
    assert_eq!(planted.t0, 0.5 * (burst.len() as f64 - 1.0));
    let of_copy: Vec<_> = one.planted.iter().filter(|thing| thing.seed == 2).map(|thing| thing.truth).collect();
    assert_eq!(planted.features, of_copy);
    assert_ne!(copy.frames, burst.frames);
    // Strong features of the burst are left alone: every disc that was found is found again in the same place.
    let away = |thing: &burstscope_core::synth::FeatureTruth| {
        planted.features.iter().all(|one| (one.u - thing.u).hypot(one.v - thing.v) > thing.radius)
    };
    let (_, truth) = made(&chart(6, 0.6));
    assert!(truth.features.iter().filter(|disc| away(disc)).count() >= 5);
    assert!(one.planted.iter().any(|thing| thing.varied == Varied::Size));
    let (burst, _) = made(&chart(0, 0.5));
    let good = || RecoverStudy { search: search(SlopeGrid::line(-2.0..=2.0, 3)), copies: 2, ..RecoverStudy::default() };
    for (study, start) in [
        (RecoverStudy { snrs: vec![0.0], ..good() }, "snr: "),
        (RecoverStudy { radii: vec![f64::NAN], ..good() }, "radius: "),
        (RecoverStudy { at_radius: 300.0, ..good() }, "at-radius: "),
        (RecoverStudy { copies: 0, ..good() }, "copies: "),
        (RecoverStudy { per_copy: Some(0), ..good() }, "per-copy: "),
    ] {
        let error = study.run(&burst, &quiet()).expect_err(start).to_string();
        assert!(error.starts_with(start), "{error}");
    }
    let still = Burst::from_planes("still", vec![Plane::from_fn(64, 64, |_, _| 0.25); 4]);
    says(good().run(&still, &quiet()).expect_err("no noise"), &["no noise"]);
    let monitor = Monitor::default();
    let cancel = |_| monitor.cancel();
    assert!(good().run_telling(&burst, &monitor, &cancel).is_err());
}
