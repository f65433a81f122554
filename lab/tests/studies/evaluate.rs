//! The studies that measure the detector: small ones, with numbers that must be plausible.

use crate::prelude::*;
use burstscope_lab::evaluate::RowAt;
use burstscope_lab::evaluate::curves::{burst_frames_figure, frames_figure, roc_figure};
use burstscope_lab::evaluate::pure_noise::NoiseLevel;
use burstscope_lab::evaluate::{
    BurstFramesStudy, BurstMethod, ChartReport, ChartStudy, NoiseStudy, RowStudy, Searches,
};
use burstscope_lab::study::StudyReport;
use std::{ops::RangeInclusive, sync::Arc, sync::Mutex};

fn chart(size: (usize, usize), discs: usize, radius: RangeInclusive<f64>, max_slope: f64) -> ChartParams {
    ChartParams { width: size.0, height: size.1, discs, radius, max_slope, ..ChartParams::default() }
}

/// A chart a sixth of the published one, with slopes up to ±2 px/frame.
fn small_study() -> ChartStudy {
    ChartStudy {
        chart: ChartParams {
            width: 300,
            height: 220,
            discs: 14,
            radius: 3.6..=14.0,
            max_slope: 2.0,
            ..ChartParams::default()
        },
        snrs: vec![0.6],
        seeds: 2,
        first_seed: 11,
        searches: Searches {
            slopes_1d: SlopeGrid::line(-2.0..=2.0, 9),
            slopes_2d: SlopeGrid::plane(-2.0..=2.0, 5, -2.0..=2.0, 5),
            ..Searches::default()
        },
        ..ChartStudy::default()
    }
}

fn found(report: &ChartReport, method: BurstMethod) -> f64 {
    let row = &report.rows[0];
    row.methods.iter().find(|m| m.method == method).expect("it took part").true_positives.mean
}

#[test]
fn the_burst_search_finds_in_the_dark_what_one_frame_does_not_show() {
    let report = small_study().run(&quiet()).expect("a report");
    let [frame, mean, merge, one_d, two_d] = BurstMethod::WITH_GIVEN_SLOPES.map(|method| found(&report, method));
    println!(
        "of 14 discs at SNR 0.6: one frame {frame}, plain mean {mean}, merge {merge}, BuFF 1D {one_d}, BuFF 2D {two_d}"
    );
    assert!(one_d >= 12.0 && two_d >= 10.0, "{one_d} {two_d}");
    assert!(frame + 4.0 <= one_d && frame < mean && mean < one_d, "{frame} {mean}");
    for method in &report.rows[0].methods {
        assert_eq!(method.charts.len(), 2);
        assert_eq!(method.charts.iter().map(|c| c.seed).collect::<Vec<_>>(), [11, 12]);
        assert!(method.roc.windows(2).all(|w| w[0] <= w[1]), "{:?}", method.roc);
        assert!(method.true_positives.mean <= method.default_true_positives.mean);
        if let Some(ratio) = method.noise_estimate_ratio {
            assert!((ratio.mean - 1.0).abs() < 0.1, "{ratio}");
        }
    }
}

#[test]
fn motion_across_the_line_needs_the_plane_and_slopes_that_are_found_serve_as_well() {
    let study = ChartStudy { methods: vec![BurstMethod::Buff1d, BurstMethod::Buff2d], ..small_study() };
    let chart = ChartParams { motion: Motion::TwoD, ..study.chart.clone() };
    let report = ChartStudy { chart, ..study }.run(&quiet()).expect("a report");
    let (one_d, two_d) = (found(&report, BurstMethod::Buff1d), found(&report, BurstMethod::Buff2d));
    println!("of 14 discs with 2D motion at SNR 0.6: BuFF 1D {one_d}, BuFF 2D {two_d}");
    assert!(two_d >= 10.0 && two_d > one_d, "{one_d} {two_d}");
    let study = ChartStudy { methods: vec![BurstMethod::Buff1d, BurstMethod::BuffAuto], ..small_study() };
    let report = study.run(&quiet()).expect("a report");
    let (known, auto) = (found(&report, BurstMethod::Buff1d), found(&report, BurstMethod::BuffAuto));
    println!("of 14 discs at SNR 0.6: known slopes {known}, slopes found {auto}");
    assert!(auto + 1.5 >= known, "{auto} {known}");
}

#[test]
fn the_report_does_not_depend_on_the_threads_and_without_the_gate_the_study_sees_below_it() {
    let study = ChartStudy { seeds: 3, methods: vec![BurstMethod::SiftMean, BurstMethod::Buff1d], ..small_study() };
    let with = |threads| on_threads(threads, || study.run(&quiet()).expect("a report"));
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
    let with = |gate: &str| {
        let mut study = ChartStudy { seeds: 1, methods: vec![BurstMethod::Buff1d], ..small_study() };
        study.searches.detector.noise_gate = gate.parse().expect("a gate");
        study.run(&quiet()).expect("a report").rows[0].methods[0].default_false_features.mean
    };
    assert!(with("3.5") > with("auto") + 5.0);
}

#[test]
fn at_the_threshold_of_the_same_false_rate_a_tenth_is_false() {
    let mut study = small_study();
    study.methods = vec![BurstMethod::SiftFrame, BurstMethod::SiftMerge, BurstMethod::Buff1d];
    (study.snrs, study.searches.detector.noise_gate) = (vec![1.2], NoiseGate::Factor(3.5));
    study.seeds = 4;
    let run = |study: &ChartStudy| StudyReport::Chart(Box::new(study.run(&quiet()).expect("a report")));
    let (plain, row) = (run(&study), study.snrs.len() - 1);
    let rate = plain.same_false_rate(row).expect("a rate");
    assert_eq!((rate.snr, rate.false_fraction, rate.peak_thresholds.len()), (study.snrs[row], 0.1, 3));
    let share_false = |report: &StudyReport, method| {
        let StudyReport::Chart(report) = report else { panic!("not of charts") };
        let of = report.rows[row].methods.iter().find(|one| one.method == method).expect("the method");
        of.default_false_features.mean / (of.default_false_features.mean + of.default_true_positives.mean)
    };
    for (method, threshold) in rate.peak_thresholds {
        assert!(share_false(&plain, method) > 0.25, "{method:?} has too few false features to show it");
        let mut strict = study.clone();
        (strict.methods, strict.searches.detector.peak_threshold) = (vec![method], threshold);
        let share = share_false(&run(&strict), method);
        // What is distinct of fewer keypoints differs a little.
        assert!(share < 0.12, "{method:?}: {share}");
    }
}

#[test]
fn figures_of_methods_and_over_the_number_of_frames_are_valid_pictures() {
    let methods = BurstMethod::ALL.to_vec();
    let study = ChartStudy { snrs: vec![0.3, 0.6, f64::INFINITY], methods, ..small_study() };
    let report = study.run(&quiet());
    let svg = roc_figure(&report.expect("a report"), 0).drawing.svg();
    let document = roxmltree::Document::parse(&svg).expect("valid XML");
    let count = |tag: &str| document.descendants().filter(|n| n.has_tag_name(tag)).count();
    assert_eq!(count("path"), 3 * (BurstMethod::ALL.len() + 1), "and the line of the share");
    says(&svg, &["SNR 0.3", "SNR 0.6", "no noise", "false features", "discs found, of 14", "10 % false"]);
    assert!(BurstMethod::ALL.iter().all(|m| svg.contains(m.label())));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    let size = |name| document.root_element().attribute(name).and_then(|x| x.parse::<f64>().ok()).expect("a number");
    let (width, height) = (size("width"), size("height"));
    for line in document.descendants().filter(|n| n.has_tag_name("path")) {
        for point in line.attribute("d").expect("points").split(['M', 'L']).skip(1) {
            let (x, y) = point.split_once(' ').expect("a pair");
            let (x, y): (f64, f64) = (x.parse().expect("x"), y.parse().expect("y"));
            assert!(x > 0.0 && x < width && y > 0.0 && y < height, "{point}");
        }
    }
    let methods = vec![BurstMethod::SiftMean, BurstMethod::Buff1d];
    let charts = ChartStudy { methods, ..small_study() };
    let report = ChartStudy { frame_counts: vec![2, 5], ..charts }.run(&quiet()).expect("a report");
    let svg = frames_figure(&report).drawing.svg();
    let document = roxmltree::Document::parse(&svg).expect("valid XML");
    let dots = document.descendants().filter(|n| n.has_tag_name("circle")).count();
    assert_eq!(dots, 8, "two plots, two methods, two numbers of frames");
    assert!(svg.contains("SIFT, plain mean") && svg.contains("14 discs"), "{svg}");
    assert!(!svg.contains("NaN"));
    let chart = ChartParams { frames: 4, snr: 1.0, ..small_study().chart };
    let (burst, truth) = burstscope_core::synth::synth_chart(&chart, &quiet()).expect("a chart");
    let report = BurstFramesStudy::default().run(&burst, None, Some(&truth), &quiet()).expect("a report");
    let svg = burst_frames_figure(&report).drawing.svg();
    roxmltree::Document::parse(&svg).expect("valid XML");
    assert!(svg.contains("confirmed by all frames") && svg.contains("discs found") && !svg.contains("inliers"));
}

#[test]
fn pure_noise_passes_the_gate_about_as_seldom_as_promised() {
    let levels = vec![NoiseLevel::white(0.02, None), NoiseLevel::white(0.002, Some(8))];
    let strict =
        DetectorParams { noise_gate: burstscope_core::detector::NoiseGate::Strict, ..DetectorParams::default() };
    let searches = NoiseStudy::searches(&strict);
    let study =
        NoiseStudy { levels, searches, width: 500, height: 400, frames: 6, megapixels: 1.0, ..NoiseStudy::default() };
    let report = study.run(&quiet()).expect("a report");
    assert_eq!(report.bursts, 5);
    assert!((report.megapixels - 1.0).abs() < 1e-9);
    for row in &report.rows {
        for search in &row.searches {
            println!("{:?} {}: {} in {} Mpx", row.level, search.label, search.false_features, report.megapixels);
            // At most one per megapixel is promised; more than five of one would occur once in 1700 runs, and the seed
            // is fixed.
            assert!(search.false_features <= 5, "{search:?}");
            assert!((search.noise_estimate_ratio.expect("it is white") - 1.0).abs() < 0.05, "{search:?}");
        }
    }
    // The count responds to the gate: a low gate gives many features.
    let detector = DetectorParams { noise_gate: "3".parse().expect("a gate"), ..DetectorParams::default() };
    let searches = NoiseStudy::searches(&detector)[..1].to_vec();
    let report = NoiseStudy { searches, ..study }.run(&quiet()).expect("a report");
    assert!(report.rows[0].searches[0].per_megapixel > 20.0, "{report:?}");
}

mod methods {
    use super::*;

    #[test]
    fn methods_and_their_names_agree() {
        BurstMethod::ALL.into_iter().for_each(|method| assert_eq!(method.name().parse(), Ok(method)));
        let all = || BurstMethod::ALL.into_iter().chain([BurstMethod::Gold]);
        for method in all() {
            assert_eq!(serde_json::to_value(method).expect("a word"), method.name());
            // No two lines look alike, even without colour.
            let alike = all().filter(|one| one.line().0 == method.line().0 || one.line().1 == method.line().1);
            assert_eq!(alike.count(), 1, "{method:?}");
        }
        assert!("surf".parse::<BurstMethod>().expect_err("unknown").contains("sift-frame"));
    }

    #[test]
    fn the_means_are_of_all_frames_and_one_frame_is_one() {
        let chart = ChartParams { snr: 2.0, ..chart((200, 150), 8, 4.0..=9.0, 0.0) };
        let (burst, _) = synth_chart(&chart, &Monitor::default()).expect("a chart");
        let noise = |method, frames: Option<&str>| {
            let frames = frames.map(|f| f.parse().expect("a range"));
            let detector = DetectorParams { frames, ..DetectorParams::default() };
            let found = Searches { detector, ..Searches::default() };
            let found = found.search(method, &burst, &Monitor::default()).expect("searched");
            f64::from(found.detection.frame_noise)
        };
        let one = noise(BurstMethod::SiftFrame, None);
        // Ten frames have a √10 lower noise, four of them half of it. The merge keeps slightly more of the middle
        // frame's noise.
        for (method, tolerance) in [(BurstMethod::SiftMean, 0.05), (BurstMethod::SiftMerge, 0.1)] {
            assert!((noise(method, None) * 10f64.sqrt() / one - 1.0).abs() < tolerance, "{method:?}");
            assert!((noise(method, Some("3..7")) * 2.0 / one - 1.0).abs() < tolerance, "{method:?}");
        }
    }
}

mod chart {
    use super::*;

    fn small(frame_counts: Vec<usize>) -> ChartStudy {
        ChartStudy {
            chart: chart((200, 150), 8, 4.0..=9.0, 1.0),
            snrs: vec![0.8],
            frame_counts,
            seeds: 2,
            methods: vec![BurstMethod::SiftMean, BurstMethod::Buff1d],
            searches: Searches { slopes_1d: SlopeGrid::line(-1.0..=1.0, 5), ..Searches::default() },
            ..ChartStudy::default()
        }
    }

    #[test]
    fn a_row_is_what_the_study_of_ratios_says_of_charts_of_so_many_frames() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let sink = heard.clone();
        let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
        let report = small(vec![6, 2, 6]).run(&monitor).expect("a report");
        assert_eq!(report.rows.iter().map(|row| row.at).collect::<Vec<_>>(), [2, 6].map(RowAt::Frames));
        assert_eq!((report.chart.frames, report.snr), (6, Some(0.8)));
        let ratios = small(Vec::new());
        let alone = ChartStudy { chart: ChartParams { frames: 6, ..ratios.chart.clone() }, ..ratios };
        let alone = alone.run(&Monitor::default()).expect("a report");
        assert_eq!((alone.chart.frames, alone.snr), (6, None));
        assert_eq!(report.rows[1].methods, alone.rows[0].methods);
        let json = serde_json::to_value(&report).expect("JSON");
        assert_eq!((&json["rows"][0]["frames"], &json["rows"][0]["snr"]), (&2.into(), &serde_json::Value::Null));
        let buff = |row: usize| report.rows[row].methods[1].true_positives.mean;
        assert!(buff(1) > buff(0), "{} {}", buff(0), buff(1));
        let heard = heard.lock().expect("not poisoned");
        assert_eq!(heard.iter().copied().fold(0.0, f32::max), 1.0);
        assert!(heard.contains(&(2.0 / 32.0)) || heard.contains(&(6.0 / 32.0)), "a step is a frame: {heard:?}");
    }
}

mod frames_of_burst {
    use super::*;

    #[test]
    fn the_middle_frames_are_judged_by_all_of_them_and_by_the_truth() {
        let params = ChartParams { frames: 8, snr: 0.3, seed: 3, ..chart((240, 180), 10, 4.0..=9.0, 3.0) };
        let (burst, truth) = synth_chart(&params, &Monitor::default()).expect("a chart");
        let slopes = SlopeGrid::line(-3.0..=3.0, 13);
        let search = DetectorParams { slopes, ..DetectorParams::default() }.into();
        let study = BurstFramesStudy { search, ..BurstFramesStudy::default() };
        let report = study.run(&burst, Some(&burst), Some(&truth), &Monitor::default()).expect("a report");
        let counts: Vec<(usize, usize)> = report.rows.iter().map(|row| (row.frames, row.first_frame)).collect();
        assert_eq!(counts, [(2, 3), (3, 2), (4, 2), (5, 1), (6, 1), (7, 0), (8, 0)]);
        let last = report.rows[6];
        assert_eq!((last.features, last.confirmed, last.unconfirmed), (report.features, report.features, 0));
        for row in &report.rows {
            assert_eq!(row.features, row.confirmed + row.unconfirmed);
            let (found, wrong) = (row.discs_found.expect("known"), row.false_features.expect("a chart"));
            assert_eq!(row.features, found + wrong);
            let matches = row.matches.expect("the burst itself");
            assert_eq!(matches.keypoints_a, matches.keypoints_b);
            assert_eq!(matches.putative, matches.keypoints_a, "a burst matches itself");
        }
        assert!(last.discs_found >= Some(7) && report.rows[0].discs_found < last.discs_found, "{:?}", report.rows);
        // Seven frames have their middle half a frame before that of all: a disc of 3 px/frame is 1.5 px away.
        assert!(report.rows[5].features >= 7 && report.rows[5].unconfirmed <= 1, "{:?}", report.rows);
    }

    #[test]
    fn discs_are_looked_for_where_they_are_at_mid_burst_of_the_middle_frames() {
        // Two small fast discs: found only if the half frame is taken into account.
        let params = ChartParams { snr: f64::INFINITY, ..chart((200, 150), 4, 2.5..=2.6, 7.0) };
        let (burst, mut truth) = synth_chart(&params, &Monitor::default()).expect("a chart");
        let slopes = SlopeGrid::line(-7.0..=7.0, 57);
        let study = BurstFramesStudy {
            search: DetectorParams { slopes, ..DetectorParams::default() }.into(),
            frame_counts: vec![9, 10],
            ..BurstFramesStudy::default()
        };
        let found = |truth: &Truth| {
            let report = study.run(&burst, None, Some(truth), &Monitor::default()).expect("a report");
            [0, 1].map(|row| report.rows[row].discs_found.expect("known"))
        };
        let with = found(&truth);
        assert_eq!(with[0], with[1]);
        assert!(with[1] >= 3, "{with:?}");
        // With other slopes they are searched elsewhere, except for the whole burst, whose mid-burst is the truth's.
        truth.features.iter_mut().for_each(|disc| disc.slope_v = 20.0);
        assert_eq!(found(&truth)[1], with[1]);
        assert!(found(&truth)[0] < with[0]);
    }

    #[test]
    fn a_scene_knows_no_false_features_and_nonsense_is_named() {
        let params = SceneParams { width: 160, height: 120, frames: 4, ..SceneParams::default() };
        let (burst, truth) = synth_scene(&params, &Monitor::default()).expect("a scene");
        let study = BurstFramesStudy { frame_counts: vec![4], ..BurstFramesStudy::default() };
        let report = study.run(&burst, None, Some(&truth), &Monitor::default()).expect("a report");
        assert_eq!((report.rows.len(), report.rows[0].false_features), (1, None));
        assert_eq!(report.rows[0].matches, None);
        let other = Truth { frames: 5, ..truth };
        let error = study.run(&burst, None, Some(&other), &Monitor::default()).expect_err("nonsense").to_string();
        assert!(error.contains("truth.json is of 5 frames, but the burst has 4"));
        let monitor = Monitor::default();
        monitor.cancel();
        assert!(study.run(&burst, None, None, &monitor).is_err_and(|error| error.is_cancelled()));
    }
}

#[test]
fn nonsense_in_studies_of_noise_is_named_with_its_remedy() {
    let good = NoiseStudy::default;
    let with = |sigma, bits| vec![NoiseLevel::white(sigma, bits)];
    let cases = [
        (NoiseStudy { levels: with(0.2, None), ..good() }, "sigma: "),
        (NoiseStudy { levels: with(f64::NAN, None), ..good() }, "sigma: "),
        (NoiseStudy { levels: with(0.1, Some(2)), ..good() }, "bits: "),
        (NoiseStudy { levels: Vec::new(), ..good() }, "sigma: "),
        (
            NoiseStudy { levels: vec![NoiseLevel { mean: 1.0, ..NoiseLevel::white(0.02, None) }], ..good() },
            "case_level: ",
        ),
        (NoiseStudy { seeds: Some(0), ..good() }, "seeds: "),
        (NoiseStudy { width: 3, ..good() }, "width: "),
        (NoiseStudy { frames: 0, ..good() }, "frames: "),
        (NoiseStudy { megapixels: f64::NAN, ..good() }, "megapixels: "),
    ];
    for (study, start) in cases {
        let error = study.run(&Monitor::default()).expect_err(start).to_string();
        assert!(error.starts_with(start), "{error}");
    }
}
