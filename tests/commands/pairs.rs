//! Pairs of a dataset are matched once: kept, they give the same database as if they were matched again.

use crate::support::*;

const SEARCH: [&str; 4] = ["--slopes-u", "-2:2:5", "--octaves", "2"];

fn way() -> Folder {
    let home = folder();
    home.run_well("synth trajectory --out way --width 240 --height 180 --bursts 4 --frames 5 --max-slope 2 --snr 5");
    home
}

fn bursts(numbers: std::ops::Range<usize>) -> Vec<String> {
    numbers.map(|k| format!("way/bursts/burst_{k:03}")).collect()
}

fn reconstruct(home: &Path, bursts: &[String], out: &str, more: &[&str]) -> (Value, Vec<u8>) {
    let bursts: Vec<&str> = bursts.iter().map(String::as_str).collect();
    let json = home.run_json(&[&["colmap"], &bursts[..], &SEARCH, &["--out", out, "--json"], more].concat());
    (json, fs::read(home.join(out).join("database.db")).expect("a database"))
}

fn resumed(json: &Value) -> Vec<[u64; 2]> {
    let number = |id: &Value| id.as_u64().expect("an id");
    let pairs = json["pairs"].as_array().expect("pairs").iter().filter(|pair| pair["resumed"] == true);
    pairs.map(|pair| [number(&pair["ids"][0]), number(&pair["ids"][1])]).collect()
}

fn pair_file(home: &Path, a: usize, b: usize) -> PathBuf {
    home.join(format!("rec/records/pairs/burst_{a:03}.png/burst_{b:03}.png.pair"))
}

#[test]
fn pairs_are_kept_and_a_burst_more_costs_its_own() {
    let home = &way();
    let all = [[1, 2], [1, 3], [2, 3]];
    let (first, of_three) = reconstruct(home, &bursts(0..3), "rec", &[]);
    assert_eq!(resumed(&first), [[0; 2]; 0]);
    let inliers = |pair: &Value| pair["inliers"].as_u64().expect("verified");
    assert!(first["pairs"].as_array().expect("pairs").iter().all(|pair| inliers(pair) >= 30), "{first}");
    let (again, database) = reconstruct(home, &bursts(0..3), "rec", &[]);
    assert_eq!(resumed(&again), all);
    assert!(database == of_three, "kept pairs give another database");
    let without_resumed = |json: &Value| {
        let mut json = json.clone();
        for part in ["images", "pairs"] {
            json[part].as_array_mut().expect("a list").iter_mut().for_each(|one| one["resumed"] = Value::Null);
        }
        json
    };
    assert_eq!(without_resumed(&first), without_resumed(&again));
    let three = "colmap way/bursts/burst_000 way/bursts/burst_001 way/bursts/burst_002 --out rec";
    says(home.run_well(&[&three.words()[..], &SEARCH].concat()), &["3 images, 3 pairs, 3 from an earlier run: "]);
    let (more, of_four) = reconstruct(home, &bursts(0..4), "rec", &[]);
    assert_eq!(resumed(&more), all);
    let (_, whole) = reconstruct(home, &bursts(0..4), "whole", &[]);
    assert!(of_four == whole, "three pairs kept and three matched give another database than six matched");
    let (less, database) = reconstruct(home, &bursts(0..3), "rec", &[]);
    assert!(resumed(&less) == all && database == of_three);
}

#[test]
fn pairs_of_other_options_or_features_are_matched_again() {
    let home = &way();
    let pairs = |more: &[&str]| resumed(&reconstruct(home, &bursts(0..3), "rec", more).0).len();
    for options in [
        &[][..],
        &["--ratio", "0.7"],
        &["--align", "false"],
        &["--predict", "false", "--min-inliers", "20"],
        &["--align", "false", "--geometry", "homography"],
        &["--align", "false", "--camera", "way/lens.toml"],
        &["--camera", "way/lens.toml"],
        &["--edge-threshold", "9"],
    ] {
        let (json, first) = reconstruct(home, &bursts(0..3), "rec", options);
        assert_eq!(resumed(&json).len(), 0, "{options:?}");
        let (json, again) = reconstruct(home, &bursts(0..3), "rec", options);
        assert_eq!(resumed(&json).len(), 3, "{options:?}");
        assert!(first == again, "{options:?}: kept pairs give another database");
    }
    assert_eq!(pairs(&[]), 0, "those of the last options replaced them");
    assert_eq!(pairs(&["--pairs", "sequential:1"]), 2);
    assert_eq!(pairs(&["--pairs", "near:1"]), 2);
    assert_eq!(pairs(&[]), 3);
    // Of a burst whose frames change, the other pairs stay.
    let frame = home.join("way/bursts/burst_002/frame_002.png");
    fs::copy(home.join("way/bursts/burst_002/frame_001.png"), frame).expect("copied");
    assert_eq!(resumed(&reconstruct(home, &bursts(0..3), "rec", &["--check-content"]).0), [[1, 2]]);
}

#[test]
fn near_pairs_are_those_of_the_way_in_whatever_order_the_bursts_are_given() {
    let home = &way();
    let mixed = [0, 2, 1].map(|k| format!("way/bursts/burst_{k:03}"));
    let line = |threads| ["--pairs", "near:1", "--threads", threads];
    let (json, database) = reconstruct(home, &mixed, "rec", &line("1"));
    let ids: Vec<&Value> = json["pairs"].as_array().expect("pairs").iter().map(|pair| &pair["ids"]).collect();
    assert_eq!(ids, [&serde_json::json!([1, 3]), &serde_json::json!([2, 3])], "the second burst is between the others");
    assert_eq!(home.json("rec/manifest.json")["claims"]["settings"]["export"]["pairs"], "near:1");
    let (_, again) = reconstruct(home, &mixed, "two", &line("2"));
    assert!(again == database, "two threads give another database");
    let study = "evaluate matches way/bursts --pairs near:1";
    assert!(home.run_badly(study, 2).contains("near:1 is chosen by features"));
}

#[test]
fn a_pair_that_is_not_whole_or_of_other_bursts_is_matched_again() {
    let home = &way();
    let (_, first) = reconstruct(home, &bursts(0..3), "rec", &[]);
    let file = pair_file(home, 0, 2);
    let whole = fs::read(&file).expect("a pair");
    assert!(whole.starts_with(b"Burstscope pair 2\n{"));
    let changed = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        bytes
    };
    let of_others = fs::read(pair_file(home, 0, 1)).expect("a pair");
    let wrong = [
        Vec::new(),
        whole[..20].to_vec(),
        whole[..whole.len() / 2].to_vec(),
        whole[..whole.len() - 1].to_vec(),
        [&whole[..], b"\n"].concat(),
        changed(60),
        changed(whole.len() / 2),
        changed(whole.len() - 1),
        of_others,
        // As an earlier program wrote it.
        [b"Burstscope pair 1\n", &whole[18..]].concat(),
    ];
    for (index, bytes) in wrong.iter().enumerate() {
        fs::write(&file, bytes).expect("written");
        let (json, database) = reconstruct(home, &bursts(0..3), "rec", &[]);
        assert_eq!(resumed(&json), [[1, 2], [2, 3]], "{index}");
        assert!(database == first && fs::read(&file).expect("a pair") == whole, "{index}");
    }
    fs::remove_file(&file).expect("removed");
    assert_eq!(resumed(&reconstruct(home, &bursts(0..3), "rec", &[]).0), [[1, 2], [2, 3]]);
    fs::write(&file, "mine").expect("written");
    let line = [&["colmap", "way/bursts", "--out", "rec"][..], &SEARCH].concat();
    says(home.run_badly(&line, 1), &["did not write this file", "burst_002.png.pair"]);
    assert_eq!(fs::read(&file).expect("there"), b"mine");
}

#[test]
fn a_list_names_the_pairs_and_the_summary_says_what_they_join() {
    let home = &way();
    home.write("list.txt", "# of a retrieval\n\nburst_001.png burst_000\nburst_002.png burst_003.png\n");
    let (json, of_list) = reconstruct(home, &bursts(0..4), "rec", &["--pairs", "list.txt"]);
    let ids: Vec<&Value> = json["pairs"].as_array().expect("pairs").iter().map(|pair| &pair["ids"]).collect();
    assert_eq!(ids, [&serde_json::json!([1, 2]), &serde_json::json!([3, 4])]);
    let parts = serde_json::json!([["burst_000", "burst_001"], ["burst_002", "burst_003"]]);
    assert_eq!((&json["joined"]["parts"], &json["joined"]["alone"]), (&parts, &serde_json::json!([])));
    assert_eq!((&json["beside"], &json["implied"]), (&0.into(), &0.into()), "no third burst sees what a pair sees");
    let line = [&["colmap", "way/bursts", "--out", "rec", "--pairs"][..], &["list.txt"], &SEARCH].concat();
    let text = home.run_well(&line);
    assert!(text.contains("4 images, 2 pairs, 2 from an earlier run: "), "{text}");
    assert!(text.contains("verified pairs join 2 of 4 images, and apart from them 2 others\n"), "{text}");
    let (json, _) = reconstruct(home, &bursts(0..4), "rec", &[]);
    assert_eq!(resumed(&json), [[1, 2], [3, 4]]);
    // Of four bursts some matches are known by pictures or by other bursts alone, and count among those of their pair.
    for how in ["beside", "implied"] {
        assert!(json[how].as_u64().is_some_and(|count| count > 0), "{how}: {}", json[how]);
    }
    let counts = |pair: &Value| ["inliers", "putative"].map(|key| pair[key].as_u64());
    assert!(json["pairs"].as_array().expect("pairs").iter().map(counts).all(|[inliers, all]| inliers <= all), "{json}");
    let text = home.run_well(&[&["colmap", "way/bursts", "--out", "rec"][..], &SEARCH].concat());
    assert!(text.contains("verified pairs join all 4 images\n"), "{text}");
    let (_, again) = reconstruct(home, &bursts(0..4), "rec", &["--pairs", "list.txt"]);
    assert!(again == of_list);
    home.write("list.txt", "burst_001 burst_003\n");
    let text = home.run_well(&line);
    assert!(text.contains("4 images, 1 pair, 1 from an earlier run: "), "{text}");
    says(&text, &["in 1 verified pair\n", "verified pairs join 2 of 4 images; none is of burst_000, burst_002\n"]);
    let report = |inputs: &[&'static str], more: &[&'static str]| {
        [&["report"], inputs, &["--out", "flight.md", "--json", "--pairs-of"], more, &SEARCH].concat()
    };
    let flight = home.run_json(&report(&["way/bursts"], &["rec"]));
    let json = home.run_json(&[&line[..], &["--json"]].concat());
    assert_eq!((&flight["joined"], flight["pairs"].as_array().map(Vec::len)), (&json["joined"], Some(1)));
    for key in ["ids", "keypoints_a", "keypoints_b", "putative", "inliers", "refused"] {
        assert_eq!(flight["pairs"][0][key], json["pairs"][0][key], "{key}");
    }
    assert_eq!(flight["pairs"][0]["bursts"], serde_json::json!(["burst_001", "burst_003"]));
    let rows = flight["bursts"].as_array().expect("rows").iter();
    assert_eq!(rows.map(|row| row["verified_pairs"].clone()).collect::<Vec<_>>(), [0, 1, 0, 1]);
    let page = home.text("flight.md");
    assert!(page.contains(r"- Verified pairs join 2 of 4 images; none is of burst\_000, burst\_002"), "{page}");
    assert!(page.contains("\n1 pair with a match, ") && page.contains(r"| burst\_001 | burst\_003 | "), "{page}");
    home.make_dir("broken");
    let database = fs::read(home.join("rec/database.db")).expect("a database");
    home.write("broken/database.db", &database[..512]);
    for (inputs, folder, words) in [
        ("way/bursts", "way", "way is no folder that colmap wrote from these bursts: it has no database.db"),
        ("way/bursts", "broken", "its database.db is damaged ("),
        ("demo demo-later", "rec", "it holds none of them; give the --out of a `burstscope colmap`"),
    ] {
        says(home.run_badly(&report(&inputs.words(), &[folder]), 2), &[words, "--pairs-of: "]);
    }
    // No inliers: nothing is joined, and nothing can be mapped.
    let none = [&line[..], &["--min-inliers", "100000", "--predict", "false", "--json"]].concat();
    let json = home.run_json(&none);
    assert_eq!(json["joined"]["alone"].as_array().map(Vec::len), Some(4), "{}", json["joined"]);
    let why = json["no_start"].as_str().expect("a reason");
    assert!(why.contains("the one pair is not verified (0 without a match, 0 refused"), "{why}");
    // Its file says why a pair is refused: by its motions, or, where it had a geometry, by its pictures.
    let file = pair_file(home, 1, 3);
    let whole = fs::read(&file).expect("a pair");
    let lines: usize = whole.split_inclusive(|byte| *byte == b'\n').take(2).map(<[u8]>::len).sum();
    let of_two = |word: Option<usize>| {
        let mut bytes = whole.clone();
        word.into_iter().for_each(|word| bytes[lines + 4 * word] = 1);
        fs::write(&file, bytes).expect("written");
        home.run_json(&report(&["way/bursts/burst_001", "demo"], &["rec"]))
    };
    assert_eq!(of_two(None)["pairs"][0]["refused"], Value::Null);
    for (word, by) in [(1, "pictures"), (0, "motions")] {
        let refused = of_two(Some(word));
        assert_eq!(refused["pairs"][0]["refused"], by);
        assert_eq!(refused["joined"][format!("refused_by_{by}")], 1);
    }
    // A geometry of which no match is left is refused by the tracks of other pairs.
    let refused = {
        let database = rusqlite::Connection::open(home.join("rec/database.db")).expect("a database");
        assert_eq!(database.execute("UPDATE two_view_geometries SET config = 3", []), Ok(1));
        of_two(None)
    };
    assert_eq!(refused["pairs"][0]["refused"], "tracks");
    assert_eq!(refused["joined"]["refused_by_tracks"], 1);
    let refused = of_two(Some(0));
    assert_eq!([0, 1].map(|row| refused["bursts"][row]["verified_pairs"].clone()), [0.into(), Value::Null]);
    says(home.text("flight.md"), &["- No pair is verified\n- Not in the folder of the pairs: demo\n"]);
    for (text, words) in [("burst_000 burst_001\nburst_000 night\n", "line 2: "), ("\nburst_000\n", "line 2: ")] {
        home.write("list.txt", text);
        says(home.run_badly(&line, 1), &[words, "list.txt", "burst_"]);
    }
    assert!(home.run_badly(&[&line[..4], &["--pairs", "gone.txt"]].concat(), 2).contains("two names a line"));
}
