//! `evaluate`: tables, JSON, the figure, and wrong use.

use crate::support::*;

/// Options that make a chart small enough for a test.
const SMALL: [&str; 10] = ["--width", "260", "--height", "200", "--discs", "8", "--max-slope", "1", "--seeds", "1"];

#[test]
fn charts_give_a_table_and_a_figure_and_advice_is_counted_against_the_truth() {
    let home = folder();
    let few = ["--snr", "0.8,2", "--methods", "sift-frame,buff-1d", "--plot", "figures/roc.svg"];
    let arguments = [&["evaluate", "chart"], &SMALL[..], &few].concat();
    let table = home.run_well(&arguments);
    let radii = "8 discs of radius 3.6 to 19 px";
    says(&table, &[radii, "10 % of the detections are false", "BuFF 1D", "wrote figures/roc.svg"]);
    assert!(!table.contains("BuFF 2D"));
    let svg = home.text("figures/roc.svg");
    assert!(svg.contains("SNR 0.8") && svg.contains("SNR 2"));
    assert_eq!(names(&home.join("figures")), ["roc.svg"]);
    let line = "evaluate advice --snr 2 --seeds 1";
    let report = home.run_json(&format!("{line} --json"));
    let said = report["said"].as_object().expect("a table").values();
    let counts = said.flat_map(|truths| truths.as_object().expect("counts").values());
    let bursts = report["bursts"].as_array().expect("bursts");
    assert_eq!(counts.filter_map(Value::as_u64).sum::<u64>(), bursts.len() as u64);
    let narrow = bursts.iter().find(|burst| burst["kind"] == "narrow").expect("a burst of each kind");
    let sentence = narrow["sentence"].as_str().expect("words");
    assert!(narrow["said"] == "range" && sentence.contains("beyond the range"), "{narrow}");
    says(home.run_well(&format!("{line} --threads 1")), &["said \\ true", "exchanged"]);
    assert!(home.run_badly("evaluate advice --seeds 0", 2).contains("--seeds"));
}

#[test]
fn json_has_everything_and_does_not_depend_on_the_threads() {
    let home = folder();
    let with = |threads: &str| {
        let few = ["--snr", "2", "--slopes-u", "-1:1:5", "--seed", "7", "--json", "--threads", threads];
        let methods = ["--methods", "sift-mean,buff-1d,buff-1d", "--radius", "4:12", "--radius-law", "log"];
        home.run_well(&[&["evaluate", "chart"], &SMALL[..], &few, &methods].concat())
    };
    let text = with("1");
    assert_eq!(text, with("3"));
    let report: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!((report["command"].as_str(), report["first_seed"].as_u64()), (Some("evaluate chart"), Some(7)));
    assert_eq!(report["slopes_1d"]["u"]["count"], 5);
    assert_eq!(report["chart"]["radius"], serde_json::json!([4.0, 12.0]));
    assert_eq!(report["chart"]["radius_law"], "log");
    let methods = report["rows"][0]["methods"].as_array().expect("methods");
    assert_eq!(methods.len(), 2, "a method named twice runs once");
    assert_eq!(methods[1]["method"], "buff-1d");
    assert!(methods[1]["true_positives"]["mean"].as_f64().expect("a number") >= 6.0, "{text}");
    assert_eq!(methods[1]["charts"][0]["seed"], 7);
}

#[test]
fn accuracy_and_noise_give_tables_and_json() {
    let home = folder();
    let accuracy = [&["evaluate", "accuracy", "--snr", "inf"], &SMALL[..], &["--slopes-u", "-1:1:5"]].concat();
    let table = home.run_well(&accuracy);
    says(table, &["slope u, px/frame", "discs beyond the range", "Crowded charts", "stand apart in all frames"]);
    let alone = home.run_well(&[&accuracy[..], &["--apart-discs", "0"]].concat());
    assert!(!alone.contains("stand apart in all frames"), "{alone}");
    let report = home.run_json(&[&accuracy[..], &["--json"]].concat());
    assert_eq!(report["rows"][0]["within"]["discs"], 8);
    assert!(report["rows"][0]["u"]["median_magnitude"].as_f64().expect("a number") < 0.5);
    assert_eq!(report["apart"]["chart"]["discs"], 2);
    assert_eq!(report["apart"]["rows"][0]["apart"], report["apart"]["rows"][0]["u"]["count"]);
    let blind = home.run_well(&[&accuracy[..], &["--peak-threshold", "9"]].concat());
    let place = blind.lines().find(|line| line.contains("place u, px")).expect("a line");
    assert_eq!(place.split_whitespace().skip(3).collect::<Vec<_>>(), ["–", "–", "–"], "{blind}");
    assert!(!blind.contains("NaN"), "{blind}");
    let noise = ["evaluate", "noise", "--megapixels", "0.05", "--width", "200", "--height", "150", "--sigma", "0.02"];
    let table = home.run_well(&[&noise[..], &["--bits", "none,12", "--noise-gate", "3"]].concat());
    assert!(table.contains("BuFF 2D, 49 slopes") && table.contains("3.00 σ"), "{table}");
    let report = home.run_json(&[&noise[..], &["--method", "sift", "--json"]].concat());
    assert_eq!((report["bursts"].as_u64(), report["rows"].as_array().map(Vec::len)), (Some(2), Some(38)));
    assert_eq!(report["rows"][0]["searches"][0]["slopes"], 1);
}

#[test]
fn noise_of_which_the_strict_gate_promises_nothing_is_refused_and_the_others_are_searched() {
    let home = folder();
    let study = "evaluate noise --case jpeg-30,white --case-sigma 0.01 --noise-gate strict \
        --megapixels 0.1 --width 320 --height 240 --table noise.csv";
    let text = home.run_well(study);
    let row = text.lines().find(|line| line.starts_with("jpeg-30")).expect("a row");
    assert_eq!(row.matches("refused").count(), 2, "{text}");
    assert!(text.lines().any(|line| line.starts_with("white") && line.contains('±')), "{text}");
    // A rate of no pixels is empty, and not 0.
    let table = home.text("noise.csv");
    assert!(table.lines().any(|line| line.starts_with("jpeg-30") && line.ends_with(",,,0,0")), "{table}");
}

#[test]
fn frames_are_counted_on_charts_and_in_a_burst() {
    let home = folder();
    let few = ["--snr", "2", "--methods", "sift-frame,buff-1d", "--frame-counts", "4,2", "--plot", "charts.svg"];
    let charts = [&["evaluate", "frames"], &SMALL[..], &few].concat();
    let table = home.run_well(&charts);
    says(table, &["in 2 to 4 frames of 260×200", "one chart for each number of frames", "BuFF 1D", "wrote charts.svg"]);
    let report = home.run_json(&[&charts[..], &["--json"]].concat());
    let counts: Vec<_> = report["rows"].as_array().expect("rows").iter().map(|row| row["frames"].as_u64()).collect();
    assert_eq!((report["command"].as_str(), counts), (Some("evaluate frames"), vec![Some(2), Some(4)]));
    let svg = home.text("charts.svg");
    assert!(svg.contains("number of frames") && svg.contains("SIFT, one frame"), "{svg}");
    let made = "synth chart --width 200 --height 150 --discs 6 --max-slope 1 --frames 5";
    home.run_well(&format!("{made} --snr 2 --out night"));
    let slopes = ["--slopes-u", "-1:1:5", "--plot", "burst.svg"];
    let burst = [&["evaluate", "frames", "night", "night"], &slopes[..]].concat();
    says(home.run_well(&burst), &["confirmed", "discs known: 6", "inliers"]);
    let report = home.run_json(&[&burst[..], &["--json"]].concat());
    let rows = report["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 4, "2, 3, 4 and 5 frames");
    assert_eq!(rows[3]["confirmed"], report["features"]);
    assert!(rows[3]["discs_found"].as_u64() >= Some(5), "{report}");
    says(home.text("burst.svg"), &["confirmed by all frames", "Matches with as many frames"]);
}

#[test]
fn wrong_use_says_what_would_be_right() {
    let home = folder();
    for (arguments, words) in [
        ("evaluate", "accuracy"),
        ("evaluate chart --plot roc.gif", "end the name in .pdf, .svg, .png, .csv or .tex"),
        ("evaluate chart --method sift", "name them with --methods"),
        ("evaluate chart --methods surf", "sift-frame, sift-mean, sift-merge, buff-1d, buff-2d or buff-auto"),
        ("evaluate chart --snr -1", "--snr"),
        ("evaluate chart --discs 9000 --snr 1", "--discs: only"),
        ("evaluate chart --false-fraction 2", "--false-fraction: 2; give a share"),
        ("evaluate chart --seeds 0", "--seeds"),
        ("evaluate chart --radius 9:4 --snr 1", "--radius: 9:4; give MIN:MAX in pixels"),
        ("evaluate chart --radius-law even", "uniform, log"),
        ("evaluate frames --frame-counts 1", "--frames: a single frame shows no motion"),
        ("evaluate frames --frames 0..3", "--frame-counts"),
        ("evaluate frames demo --seeds 3", "cannot be used with"),
        ("evaluate frames demo --motion 2d", "cannot be used with"),
        ("evaluate frames demo --discs 9", "cannot be used with"),
        ("evaluate frames demo --frame-counts 99", "--frame-counts: 99 of"),
        ("evaluate frames --plot frames", "end the name in .pdf, .svg, .png, .csv or .tex"),
        ("evaluate accuracy --levels 0", "--levels: "),
        ("evaluate noise --sigma 0.5", "--sigma: 0.5; give standard deviations"),
        ("evaluate noise --bits many", "neither 'none' nor a number of bits"),
        ("evaluate noise --megapixels 0", "--megapixels: 0"),
    ] {
        says(home.run_badly(arguments, 2), &[words]);
    }
    assert!(names(&home).is_empty());
}
