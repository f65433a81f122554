//! Plots and tables: every ending gives a file of its kind, with the numbers of the report.

use crate::support::*;

const FORMATS: [(&str, &[u8]); 5] =
    [("svg", b"<svg "), ("pdf", b"%PDF-1.7"), ("png", b"\x89PNG\r\n"), ("csv", b""), ("tex", b"% ")];

/// Runs the command with each ending at `option`; returns the rows of its CSV, the header first, and its LaTeX.
fn written(home: &Path, command: &[&str], option: &str) -> (Vec<Vec<String>>, String) {
    for (ending, start) in FORMATS {
        let file = format!("x.{ending}");
        let said = home.run_well(&[command, &[option, &file]].concat());
        let bytes = fs::read(home.join(&file)).expect("written");
        assert!(said.contains(&format!("wrote {file}")) && bytes.starts_with(start), "{command:?} {file}");
        // A table has no mark, and is known by its header; what is not the program's stays.
        if ending == "csv" {
            home.run_well(&[command, &[option, &file]].concat());
        }
        home.write(&format!("mine.{ending}"), "mine\n");
        home.run_badly(&[command, &[option, &format!("mine.{ending}")]].concat(), 1);
    }
    for wrong in ["x.gif", "x"] {
        let error = home.run_badly(&[command, &[option, wrong]].concat(), 2);
        assert!(error.contains("end the name in .pdf, .svg, .png, .csv or .tex"), "{error}");
        assert!(!names(home).contains(&wrong.to_owned()));
    }
    let read = |file: &str| fs::read_to_string(home.join(file)).expect("text");
    let svg = read("x.svg");
    roxmltree::Document::parse(&svg).expect("sound XML");
    let cells = |line: &str| {
        let parts = line.split('"').enumerate();
        let masked = parts.map(|(i, part)| if i % 2 == 0 { part.replace(',', "\u{1}") } else { part.to_owned() });
        masked.collect::<String>().split('\u{1}').map(str::to_owned).collect()
    };
    (read("x.csv").lines().map(cells).collect(), read("x.tex"))
}

fn column(rows: &[Vec<String>], name: &str) -> Vec<f64> {
    let at = rows[0].iter().position(|head| head == name).unwrap_or_else(|| panic!("{name} of {:?}", rows[0]));
    rows[1..].iter().map(|row| row[at].parse().unwrap_or(f64::NAN)).collect()
}

fn numbers(rows: &Value, of: impl Fn(&Value) -> &Value) -> Vec<f64> {
    rows.as_array().expect("rows").iter().map(|row| of(row).as_f64().unwrap_or(f64::NAN)).collect()
}

/// Both are the same but for the digits of a 32-bit number.
#[track_caller]
fn assert_same(ours: &[f64], theirs: &[f64]) {
    let same = |(a, b): (&f64, &f64)| (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-6 * b.abs();
    assert!(ours.len() == theirs.len() && ours.iter().zip(theirs).all(same), "{ours:?} {theirs:?}");
}

/// Both as they are shown with so many decimals, where they are known.
fn has_all(latex: &str, numbers: &[f64], decimals: usize) -> bool {
    numbers.iter().filter(|x| x.is_finite()).all(|x| latex.contains(&format!("& {x:.decimals$} ")))
}

#[test]
fn a_plot_and_a_table_are_two_files() {
    let home = folder();
    for line in ["recover demo", "evaluate chart --slopes-u -1:1:3", "evaluate frames --slopes-u -1:1:3"] {
        says(home.run_badly(&format!("{line} --plot x.svg --table x.svg"), 2), &["--plot names this file too"]);
    }
    assert_eq!(names(&home), [""; 0]);
}

#[test]
fn the_figures_of_a_burst_are_of_every_kind_and_have_its_numbers() {
    let home = folder();
    let line = ["demo-low-contrast", "--slopes-u", "-2:2:5", "--octaves", "2"];
    let slopes = [&["slopes"][..], &line].concat();
    let (rows, latex) = written(&home, &slopes, "--plot");
    let bars = &home.run_json(&[&slopes[..], &["--json"]].concat())["spectrum"]["bars"];
    assert_same(&column(&rows, "slope_u"), &numbers(bars, |bar| &bar["slope"]["u"]));
    assert_same(&column(&rows, "features"), &numbers(bars, |bar| &bar["features"]));
    assert_same(&column(&rows, "evidence"), &numbers(bars, |bar| &bar["evidence"]));
    assert!(has_all(&latex, &column(&rows, "evidence")[..1], 3) || has_all(&latex, &column(&rows, "slope_v"), 3));
    let probe = [&["probe"][..], &line, &["--at", "160,120"]].concat();
    let (rows, latex) = written(&home, &probe, "--plot");
    let answer = &home.run_json(&[&probe[..], &["--json"]].concat())["probe"];
    let snr = answer["response"]["snr"].as_array().expect("rows").iter().flat_map(|row| numbers(row, |x| x));
    let frames = answer["shares"]["frames"].as_array().expect("frames").iter().filter(|frame| frame["covers"] == true);
    let values = frames.map(|frame| frame["value"].as_f64().expect("a number"));
    assert_same(&column(&rows, "y"), &snr.chain(values).collect::<Vec<_>>());
    assert!(latex.contains("response of each frame"), "{latex}");
    let recover = [&["recover"][..], &line, &["--copies", "1"]].concat();
    let (rows, _) = written(&home, &recover, "--plot");
    assert!(rows[0].join(",") == "set,plot,curve,x,y,low,high" && rows.len() > 5);
    let (rows, latex) = written(&home, &recover, "--table");
    let planted = &home.run_json(&[&recover[..], &["--json"]].concat())["planted"];
    assert_same(&column(&rows, "snr"), &numbers(planted, |one| &one["snr"]));
    assert_same(&column(&rows, "u"), &numbers(planted, |one| &one["truth"]["u"]));
    assert!(has_all(&latex, &column(&rows, "u"), 3));
}

#[test]
fn the_tables_of_studies_are_of_every_kind_and_have_their_numbers() {
    let home = folder();
    let small = ["--width", "260", "--height", "200", "--discs", "8", "--radius", "3.6:19", "--seeds", "1"];
    let methods = ["--methods", "sift-frame,buff-1d"];
    let chart = [&["evaluate", "chart", "--snr", "2"][..], &small, &methods].concat();
    let (rows, _) = written(&home, &chart, "--plot");
    let report = home.run_json(&[&chart[..], &["--json"]].concat());
    let roc = |of: usize| numbers(&report["rows"][0]["methods"][of]["roc"], |x| x);
    let y = column(&rows, "y");
    assert!(roc(0).starts_with(&y[..1]) && y.len() > 2, "{y:?}");
    let (rows, latex) = written(&home, &chart, "--table");
    let of_methods = &report["rows"][0]["methods"];
    let found = numbers(of_methods, |method| &method["true_positives"]["mean"]);
    assert_eq!((column(&rows, "found"), column(&rows, "snr")), (found.clone(), vec![2.0; 2]));
    assert!(has_all(&latex, &found, 1));
    let frames = [&["evaluate", "frames", "--snr", "2", "--frame-counts", "4,2"][..], &small, &methods].concat();
    let (rows, _) = written(&home, &frames, "--table");
    let report = home.run_json(&[&frames[..], &["--json"]].concat());
    let found = |row: usize| numbers(&report["rows"][row]["methods"], |method| &method["true_positives"]["mean"]);
    assert_same(&column(&rows, "found"), &[found(0), found(1)].concat());
    written(&home, &frames, "--plot");
    let burst = ["evaluate", "frames", "demo-low-contrast", "--frame-counts", "3,5", "--slopes-u", "-1:1:3"];
    let (rows, latex) = written(&home, &burst, "--table");
    let report = home.run_json(&[&burst[..], &["--json"]].concat());
    assert_same(&column(&rows, "confirmed"), &numbers(&report["rows"], |row| &row["confirmed"]));
    assert!(has_all(&latex, &column(&rows, "confirmed"), 0));
    written(&home, &burst, "--plot");
    let accuracy = [&["evaluate", "accuracy", "--snr", "5", "--apart-discs", "0"][..], &small].concat();
    let (rows, _) = written(&home, &accuracy, "--table");
    let report = home.run_json(&[&accuracy[..], &["--json"]].concat());
    let medians = ["u", "v", "scale", "slope_u", "slope_v"].map(|name| &report["rows"][0][name]["median_magnitude"]);
    let medians = medians.map(|median| median.as_f64().unwrap_or(f64::NAN));
    assert_same(&column(&rows, "median")[..5], &medians);
    let noise = ["evaluate", "noise", "--case", "white", "--megapixels", "0.1", "--method", "sift"];
    let (rows, _) = written(&home, &noise, "--table");
    let report = home.run_json(&[&noise[..], &["--json"]].concat());
    let search = &report["rows"][0]["searches"];
    assert_same(&column(&rows, "false_features"), &numbers(search, |search| &search["false_features"]));
    assert_same(&column(&rows, "per_megapixel"), &numbers(search, |search| &search["per_megapixel"]));
    // Kinds that are drawn: the worst are measured again, and the worst of them is made by the line that is told.
    let drawn = ["evaluate", "noise", "--cases", "3", "--megapixels", "0.01", "--method", "sift", "--width", "100"];
    let drawn = [&drawn[..], &["--height", "100"]].concat();
    let report = home.run_json(&[&drawn[..], &["--json"]].concat());
    assert_eq!(
        ["/rows", "/drawn/rows"].map(|rows| report.pointer(rows).map(|r| r.as_array().map(Vec::len))),
        [Some(Some(3)); 2]
    );
    let said = home.run_well(&drawn);
    let line = said.lines().find_map(|line| line.strip_prefix("burstscope ")).expect("a line that makes it");
    home.run_well(line);
    assert!(names(&home.join("noise")).contains(&"frame_009.png".to_owned()));
}

#[test]
fn the_tables_of_matches_and_poses_are_of_every_kind_and_have_their_numbers() {
    let home = folder();
    let way = ["synth", "trajectory", "--out", "way", "--bursts", "3", "--frames", "5", "--width", "240"];
    home.run_well(&[&way[..], &["--height", "180"]].concat());
    let matches = ["evaluate", "matches", "way/bursts", "--methods", "sift-frame,buff-1d", "--slopes-u", "-1:1:3"];
    let (rows, _) = written(&home, &matches, "--table");
    let report = home.run_json(&[&matches[..], &["--json"]].concat());
    for name in ["keypoints_per_image", "match_score", "verified_pairs"] {
        assert_eq!(column(&rows, name), numbers(&report["methods"], |method| &method[name]), "{name}");
    }
    // The true poses come with the way; three cameras near one another have small angles.
    let truth = ["--by", "angle", "--truth", "way/poses.txt", "--camera", "way/lens.toml"];
    let matches = [&matches[..], &truth].concat();
    let (rows, latex) = written(&home, &matches, "--table");
    let report = home.run_json(&[&matches[..], &["--json"]].concat());
    for name in ["matches", "right"] {
        let expected = numbers(&report["truth"]["by_angle"], |row| &row[name]);
        assert_eq!(column(&rows, name), expected, "{name}");
        assert!(has_all(&latex, &expected, 0));
    }
    let poses = "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0.5 0 0 0 0 1\n3 3 0 1 0 0 0 1\n";
    home.write("truth.txt", poses);
    home.write("found.txt", poses.replace("2 2 0.5", "2 2 0.4"));
    let poses = ["evaluate", "poses", "--estimate", "found.txt", "--truth", "truth.txt"];
    let (rows, latex) = written(&home, &poses, "--table");
    let report = home.run_json(&[&poses[..], &["--json"]].concat());
    let rmse = ["absolute", "relative"].map(|of| ["translation", "rotation_deg"].map(|e| &report[of][e]["rmse"]));
    let rmse: Vec<f64> = rmse.as_flattened().iter().map(|x| x.as_f64().expect("a number")).collect();
    assert_same(&column(&rows, "rmse"), &rmse);
    assert!(has_all(&latex, &rmse, 6));
}
