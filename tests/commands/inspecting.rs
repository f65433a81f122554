//! `probe`, `slopes` and `decoys`.

use crate::support::*;

const GARLANDS: [&str; 3] = ["demo-aliasing", "--slopes-u", "-9:9:37"];

#[test]
fn probe_says_what_became_of_a_place() {
    let home = folder();
    let line = "probe demo --at 92,58 --slopes-u -3:3:13";
    let alike = "likely a real blob: the frames respond alike (coherence ";
    says(home.run_well(line), &["demo at (92, 58)", "noise gate", "kept as", "frame   0", alike]);
    let found = home.run_json(&format!("{line} --json"));
    assert_eq!(found["command"], "probe");
    let fates = found["probe"]["fates"].as_array().expect("fates");
    assert!(fates.iter().any(|f| f["first_failed"].is_null()), "something was kept");
    for fate in fates {
        let tests = fate["tests"].as_array().expect("tests");
        assert_eq!(tests.len(), 12);
        let failed = tests.iter().find(|t| t["outcome"] == "fails").map_or(Value::Null, |t| t["test"].clone());
        assert_eq!(failed, fate["first_failed"], "{fate:#}");
    }
    assert_eq!(found["probe"]["shares"]["frames"].as_array().map(Vec::len), Some(10));
    assert_eq!(found["probe"]["judged"]["verdict"], "real", "the moon is no ghost");
    let rows = found["probe"]["response"]["snr"].as_array().expect("a map");
    assert_eq!(rows.len(), found["probe"]["response"]["scales"].as_array().map_or(0, Vec::len));
}

#[test]
fn probe_of_a_feature_is_that_of_its_place() {
    let home = folder();
    let line = ["--slopes-u", "-3:3:13", "--quiet"];
    home.run_well(&[&["probe", "demo", "--feature", "0", "--plot", "deep/why.svg"], &line[..]].concat());
    let svg = home.text("deep/why.svg");
    let document = roxmltree::Document::parse(&svg).expect("valid XML");
    let count = |tag: &str| document.descendants().filter(|n| n.has_tag_name(tag)).count();
    // The map, the slice, and a patch for each of ten frames.
    assert_eq!(count("image"), 12);
    assert!(count("circle") > 10 && count("text") > 30);
    assert!(svg.contains("Kept as"), "the tests are told");
    let found = home.run_json("probe demo --feature 0 --slopes-u -3:3:13 --json");
    let subject = found["probe"]["subject"]["fate"].as_u64().expect("a candidate") as usize;
    assert!(found["probe"]["fates"][subject]["features"].as_array().expect("indices").contains(&0.into()));
}

#[test]
fn an_option_that_probe_proposes_keeps_what_was_lost() {
    let home = folder();
    let place = ["demo-low-contrast", "--at", "160,120", "--slopes-u", "-2:2:9"];
    let asked = home.run_json(&[&["probe", "--json"], &place[..]].concat());
    let fates = asked["probe"]["fates"].as_array().expect("fates");
    let lost = fates
        .iter()
        .find(|f| f["first_failed"] == "noise_gate" && f["remedy"]["then_fails"].is_null() && f["remedy"].is_object())
        .unwrap_or_else(|| panic!("nothing was lost to the gate alone: {}", asked["probe"]["summary"]));
    let change = &lost["remedy"]["change"];
    let option = format!("--{}", change["parameter"].as_str().expect("a name"));
    let value = change["value"].as_str().expect("a value");
    let again = home.run_json(&[&["probe", "--json", &option, value], &place[..]].concat());
    let same = |f: &&Value| ["octave", "level", "slope_index", "sample"].iter().all(|key| f[*key] == lost[*key]);
    let now = again["probe"]["fates"].as_array().expect("fates").iter().find(same).expect("the same candidate");
    assert_ne!(now["first_failed"], "noise_gate", "{now:#}");
}

#[test]
fn slopes_tells_what_is_there_what_to_change_and_garlands_a_period_away() {
    let home = folder();
    // The sign moves by −2.1 px/frame, the lanterns by 1.6: a range of ±1 holds neither.
    says(home.run_well("slopes demo --slopes-u -1:1:5"), &["beyond", "try --slopes-u"]);
    let narrow = home.run_json("slopes demo --slopes-u -1:1:5 --json");
    let advice = narrow["spectrum"]["advice"].as_array().expect("advice");
    assert!(advice.iter().any(|a| a["subject"] == "range" || a["subject"] == "direction"), "{advice:#?}");
    let found = home.run_json("slopes demo --json");
    assert_eq!(found["spectrum"]["advice"], Value::Array(Vec::new()));
    let bars = found["spectrum"]["bars"].as_array().expect("bars");
    let features: u64 = bars.iter().map(|bar| bar["features"].as_u64().expect("a count")).sum();
    assert_eq!(Some(features), found["spectrum"]["features"].as_u64());
    let home = folder();
    let text = home.run_well(&[&["slopes", "--plot", "garlands.svg"], &GARLANDS[..]].concat());
    // The lamps move by 1 px/frame and stand 8 px apart.
    let at_alias = text.lines().find_map(|line| line.trim().strip_prefix("−7 ")).expect("a row of the slope");
    let features = at_alias.split_whitespace().next().and_then(|count| count.parse::<usize>().ok());
    assert!(features.is_some_and(|count| count >= 10), "{text}");
    let svg = home.text("garlands.svg");
    assert!(roxmltree::Document::parse(&svg).is_ok() && svg.contains("1 237 features at 37 slopes"), "{svg}");
}

#[test]
fn slopes_and_detect_judge_the_slopes_in_the_same_words() {
    let home = folder();
    for (options, words) in [
        (&["demo", "--slopes-u", "-1:1:5"][..], "beyond the range u −1 to 1 px/frame"),
        (&["demo-tripod", "--slopes-u", "-2:2:9"][..], "one slope, 0, is enough"),
        (&["demo-depths"][..], "the slopes fit the burst; "),
    ] {
        let answer = home.run_json(&[&["slopes", "--json"], options].concat());
        let sentence = answer["spectrum"]["judgement"]["sentence"].as_str().expect("a sentence");
        assert!(sentence.contains(words), "{sentence}");
        assert!(home.run_well(&[&["slopes"], options].concat()).contains(sentence), "{sentence}");
        let found = home.run_json(&[&["detect", "--out", "found", "--json"], options].concat());
        assert_eq!(found["bursts"][0]["slopes_judged"]["sentence"], sentence);
        // Slopes that cost too much give the same features: for people they are not compared with the frames.
        let text = home.run_well(&[&["detect", "--out", "found"], options].concat());
        let said =
            if words.starts_with("one slope") { "the slopes were not compared with the frames" } else { sentence };
        assert!(text.contains(said), "{said}\n{text}");
    }
}

#[test]
fn decoys_says_how_much_is_found_in_other_orders_too() {
    let home = folder();
    let line = "decoys demo-crossing --slopes-u -2:2:5 --copies 2";
    let found = home.run_json(&format!("{line} --json"));
    assert_eq!((&found["command"], &found["decoys"]["copies"]), (&Value::from("decoys"), &Value::from(2)));
    let rates = found["decoys"]["rates"].as_array().expect("rates");
    assert!(rates.len() > 5 && rates[0]["found"].as_u64() > Some(10), "{rates:?}");
    for one in rates.iter().filter(|one| one["found"].as_u64() > Some(0)) {
        let counts = one["in_copies"].as_array().expect("counts");
        let mean = counts.iter().filter_map(Value::as_f64).sum::<f64>() / counts.len() as f64;
        let rate = mean / one["found"].as_f64().expect("a count");
        assert!(counts.len() == 2 && (one["rate"].as_f64().expect("a rate") - rate).abs() < 1e-9, "{one}");
    }
    // The text has the same numbers, and another number of threads finds the same.
    let text = home.run_well(&format!("{line} --threads 1"));
    let (rate, error) = (rates[0]["rate"].as_f64().expect("a rate"), rates[0]["error"].as_f64().expect("an error"));
    says(text, &["2 copies in other orders (seed 1)", &format!("{rate:.2} ± {error:.2}")]);
    assert_ne!(home.run_json(&format!("{line} --seed 2 --json"))["decoys"]["rates"], found["decoys"]["rates"]);
}

#[test]
fn wrong_use_says_what_would_be_right() {
    let home = folder();
    for (arguments, code, words) in [
        ("probe demo", 2, "--at"),
        ("probe demo --at 9", 2, "is not U,V"),
        ("probe demo --at 480,3", 2, "outside the 480×360 image"),
        ("probe demo --feature 99999 --slopes-u 0", 2, "there is no feature 99999"),
        ("probe demo --at 3,3 --plot x.txt", 2, "end the name in .pdf, .svg, .png, .csv or .tex"),
        ("probe gone --at 3,3", 1, "gone"),
        ("slopes demo --plot x", 2, "end the name in .pdf, .svg, .png, .csv or .tex"),
        ("slopes demo demo-later", 2, "takes one burst"),
        ("slopes gone", 1, "gone"),
        ("decoys demo --copies 0", 2, "--copies: 0; give 1 to 100"),
        ("decoys demo --frames 0..3", 2, "--frames: 3 frames taking part; decoys are"),
        ("decoys demo --frames 2..6 --copies 4", 2, "give at most 3"),
        ("decoys demo --method merge", 2, "which takes 4 or more of them, and a method that"),
        ("decoys demo demo-later", 2, "takes one burst"),
    ] {
        says(home.run_badly(arguments, code), &[words]);
    }
    assert_eq!(names(&home), Vec::<String>::new(), "nothing was written");
}

#[test]
fn the_examples_are_bursts_like_any_other_and_documents_have_the_digits_of_32_bit_numbers() {
    let home = folder();
    for name in ["demo-aliasing", "demo-low-contrast", "demo-crossing"] {
        home.run_well(&["detect", name, "--slopes-u", "-2:2:5", "--out", "found"]);
        assert!(home.join(format!("found/{name}.csv")).is_file());
    }
    home.run_well("render demo-aliasing --no-detect --out x.png");
    assert!(home.join("x.png").is_file(), "the window opens them too");
    let home = folder();
    let search = ["--octaves", "2", "--edge-threshold", "8.1", "--json"];
    for command in [&["probe", "demo", "--at", "92,58"][..], &["slopes", "demo"]] {
        says(home.run_well(&[command, &search].concat()), &["\"edge_threshold\": 8.1,"]);
    }
    let document = home.run_json("stack demo --slope -2.1,0.3 --out a.tiff --json");
    assert_eq!(document["slope"], serde_json::json!({ "u": -2.1, "v": 0.3 }));
    for key in ["min", "max"] {
        let number = document[key].as_f64().expect("a number");
        assert_eq!((number as f32).to_string().parse(), Ok(number), "{key}");
    }
}
