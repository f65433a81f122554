//! `recover`, `film`, `case`, `stack --combine`, and `slopes` from the set-up.

use crate::support::*;
use burstscope::{export::case::read_session, export::case::read_truth, synth::TruthKind};

const SEARCH: [&str; 3] = ["demo-low-contrast", "--slopes-u", "-2:2:9"];

#[test]
fn recover_says_what_would_be_found_and_draws_it() {
    let home = folder();
    let few = ["--copies", "2", "--plot", "seen.svg", "--table", "planted.csv", "--json"];
    let found = home.run_json(&[&["recover"], &SEARCH[..], &few].concat());
    assert_eq!((&found["command"], &found["copies_done"]), (&Value::from("recover"), &Value::from(2)));
    let planted = found["planted"].as_array().expect("things");
    assert!(planted.len() > 10, "{}", planted.len());
    for one in planted {
        let is_found = one["found"].is_object();
        assert_eq!(is_found, one["why"].as_str().is_some_and(str::is_empty), "{one:#}");
    }
    let svg = home.text("seen.svg");
    roxmltree::Document::parse(&svg).expect("sound XML");
    assert_eq!(home.text("planted.csv").lines().count(), 1 + planted.len());
    assert_eq!(found["planted"], home.run_json(&[&["recover"], &SEARCH[..], &few].concat())["planted"]);
    // A copy is kept as a case, with the truth of what is planted in it.
    home.run_json(&[&["recover"], &SEARCH[..], &["--copies", "1", "--case", "a.burstcase", "--json"]].concat());
    let truth = read_truth(&home.join("a.burstcase")).expect("read").expect("a truth");
    let of_first: Vec<&Value> = planted.iter().filter(|one| one["seed"] == 1).collect();
    assert_eq!((truth.kind, truth.features.len()), (TruthKind::Planted, of_first.len()));
    assert!(truth.features.iter().zip(&of_first).all(|(disc, one)| one["truth"]["u"] == disc.u));
    let line = "detect a.burstcase --params a.burstcase --out found --json";
    assert!(home.run_json(line)["bursts"][0]["features"].as_u64().is_some_and(|n| n > 0));
    assert!(home.run_badly("recover demo --case a.zip", 2).contains(".burstcase"));
    assert!(home.run_badly("recover demo --copies 0", 2).contains("copies"));
    assert!(home.run_badly("recover demo --csv a.txt", 2).contains(".csv"));
    for (option, words) in [
        ("--planted-slopes=-3:3:1000000000", "planted-slopes: 1000000000 slopes; at most 4096"),
        ("--planted-slopes=3:-3:5", "planted-slopes: 3 is above -3"),
        ("--at-radius=1e9", "at-radius: 1000000000; give 0.5 to 500 pixels"),
        ("--radius=2,nan", "radius: NaN; give 0.5 to 500 pixels"),
        ("--snr=1e300", "snr: "),
        ("--copies=18446744073709551615", "copies: "),
        ("--per-copy=1000000000", "per-copy: 1000000000; give 1 to 10000"),
    ] {
        says(home.run_badly(&["recover", "demo", option], 2), &[words]);
    }
    let absurd = [&["recover"], &SEARCH[..], &["--copies", "1", "--noise-gate", "1e20"]].concat();
    says(home.run_badly(&absurd, 2), &["noise-gate: ", "lower the gate"]);
    // With given ratios the study runs, and finds nothing.
    let given = home.run_json(&[&absurd[..], &["--snr", "1,2", "--at-snr", "1", "--json"]].concat());
    assert!(given["planted"].as_array().is_some_and(|all| all.iter().all(|one| one["found"].is_null())));
}

#[test]
fn a_case_is_searched_like_the_burst_with_its_own_settings() {
    let home = folder();
    let features = |input: &[&str]| {
        home.run_json(&[&["detect"], input, &["--out", "found", "--force", "--json"]].concat())["bursts"][0]["features"]
            .clone()
    };
    let made = home.run_json(
        &[&["case"], &SEARCH[..], &["--at", "160,120", "--note", "why?", "--out", "a.burstcase", "--json"]].concat(),
    );
    assert_eq!(made["case"]["note"], "why?");
    assert_eq!(features(&["a.burstcase", "--params", "a.burstcase"]), features(&SEARCH));
    let part = home.run_json(
        &[&["case"], &SEARCH[..], &["--at", "160,120", "--around", "40", "--out", "b.burstcase", "--json"]].concat(),
    );
    assert_eq!(part["case"]["size"], serde_json::json!([81, 81]));
    let [whole, part] = ["a", "b"].map(|name| {
        let path = home.join(format!("{name}.burstcase"));
        assert!(read_session(&path).expect("read").is_none(), "only the window has one");
        read_truth(&path).expect("read").expect("a truth")
    });
    assert!(part.features.len() < whole.features.len());
    assert_eq!((part.width, part.height), (81, 81));
    home.write("c.burstcase", b"PK\x03\x04 and no more");
    assert!(home.run_badly("detect c.burstcase --out found", 1).contains("not a case"));
    assert!(home.run_badly("case demo --out a.zip", 2).contains(".burstcase"));
}

#[test]
fn a_sweep_is_a_film_and_frames_are_combined_and_the_set_up_gives_slopes_and_slopes_give_depths() {
    let home = folder();
    let line = ["--sweep", "slope-u=-2:2:5", "--max-side", "160", "--out", "a.gif", "--json"];
    let made = home.run_json(&[&["film"], &SEARCH[..], &line].concat());
    assert_eq!(made["pictures"], 5);
    let bytes = fs::read(home.join("a.gif")).expect("a file");
    let estimated = made["estimated_bytes"].as_u64().expect("a number") as usize;
    assert!((bytes.len() / 3..3 * bytes.len()).contains(&estimated), "{estimated} of {}", bytes.len());
    let size = [6, 8].map(|at| u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    assert_eq!(&bytes[..6], b"GIF89a");
    assert_eq!(size.map(|n| Some(u64::from(n))), [made["width"].as_u64(), made["height"].as_u64()]);
    let said = home.run_well(&[&["film"], &SEARCH[..], &["--sweep", "slope-u=0:1:2", "--out", "b.gif"]].concat());
    assert!(said.contains("2 pictures of") && said.contains("10 a second, about"), "{said}");
    assert!(home.run_badly("film demo --sweep up --out a.gif", 2).contains("no sweep"));
    assert!(home.run_badly("film demo --sweep scale --out a.apng", 2).contains("GIF"));
    let mean = |how: &str| {
        let line = ["stack", "demo", "--slope", "1,0", "--combine", how, "--out", "a.tiff", "--force", "--json"];
        home.run_json(&line)["mean"].as_f64().expect("a number")
    };
    assert!(mean("min") < mean("median") && mean("median") < mean("max"));
    assert!((mean("mean") - mean("median") - mean("mean-minus-median")).abs() < 1e-5);
    let home = folder();
    let set_up = ["--speed", "0.5", "--fps", "30", "--focal-px", "240", "--depth", "1:8"];
    let alone = home.run_json(&[&["slopes", "--json"], &set_up[..]].concat());
    let nearest = alone["slopes"]["nearest"]["u"].as_f64().expect("a number");
    assert!((nearest + 4.0).abs() < 1e-4, "{nearest}");
    assert!(alone["options"].as_str().is_some_and(|options| options.starts_with("--slopes-u -")));
    let with = home.run_json(&[&["slopes", "demo", "--json"], &set_up[..]].concat());
    let depths = with["depths"].as_array().expect("depths");
    assert!(depths.iter().any(|one| one["depth_m"].is_number()), "{depths:?}");
    assert!(home.run_badly("slopes", 2).contains("--speed"));
    assert!(home.run_badly("slopes --speed 1", 2).contains("--fps"));
}
