//! Export to COLMAP, and evaluation of its models.

use crate::support::*;

/// Writes a reconstruction of four of five images: twice as large as the truth and shifted, with one camera 0.1 (of the
/// truth's unit) too high.
fn model(folder: &Path) {
    fs::create_dir_all(folder).expect("made");
    let mut images = String::from("# images\n");
    for (id, centre) in [(1, [0.0, 0.0, 5.0]), (2, [2.0, 0.0, 5.0]), (4, [2.0, 2.0, 5.2]), (5, [0.0, 2.0, 5.0])] {
        // Cameras without rotation: the translation is the negative of the centre.
        let [x, y, z] = centre;
        images += &format!("{id} 1 0 0 0 {} {} {} 1 image.{:04}.png\n1 1 1 2 2 -1 3 3 2\n", -x, -y, -z, 10 * id);
    }
    fs::write(folder.join("images.txt"), images).expect("written");
    fs::write(folder.join("points3D.txt"), "1 0 0 9 0 0 0 0.4 1 0 2 0 4 0 5 0\n2 0 0 9 0 0 0 0.6 1 2 2 2 4 2 5 2\n")
        .expect("written");
    fs::write(folder.join("cameras.txt"), "1 PINHOLE 640 480 500 500 320 240\n").expect("written");
}

const TRUTH: &str =
    "# t x y z qx qy qz qw\n10 0 0 0 0 0 0 1\n20 1 0 0 0 0 0 1\n30 2 0 0 0 0 0 1\n40 1 1 0 0 0 0 1\n50 0 1 0 0 0 0 1\n";

#[test]
fn a_models_poses_are_compared_with_the_truth_and_poses_that_cannot_be_compared_say_why() {
    let home = folder();
    model(&home.join("sparse/0"));
    home.write("truth.txt", TRUTH);
    let arguments = "evaluate poses --estimate sparse --truth truth.txt";
    let text = home.run_well(arguments);
    assert!(text.contains("4 of 5 images registered (80 %), 3 cameras right"), "{text}");
    assert!(
        text.contains("2 3D points, 2.0 an image, seen in 4.00 images each, mean reprojection error 0.500 px"),
        "{text}"
    );
    assert!(text.contains("4 poses paired by time"), "{text}");
    let json = home.run_json(&format!("{arguments} --json --step 2"));
    let number = |path: &str| json.pointer(path).and_then(Value::as_f64).expect(path);
    assert!((number("/scale") - 0.5).abs() < 0.01 && number("/images_pass_percent") == 80.0);
    // A plane through four corners of which one is 0.1 too high misses each by 0.025.
    let rmse = number("/absolute/translation/rmse");
    assert!((rmse - 0.025).abs() < 0.001, "{rmse}");
    assert_eq!((number("/relative/count"), json["pairs"][2]["label"].as_str()), (2.0, Some("image.0040.png")));
    // A model can be the truth too: the gold standard. Against itself there are no errors.
    let json = home.run_json("evaluate poses --estimate sparse --truth sparse/0 --json");
    assert_eq!(json["associated"], "name");
    assert!(json["absolute"]["translation"]["max"].as_f64().is_some_and(|x| x < 1e-12), "{json}");
    let home = folder();
    model(&home.join("0"));
    let words = |arguments: &[&str], code| {
        home.run_badly(&[&["evaluate", "poses", "--estimate", "0", "--truth", "truth.txt"], arguments].concat(), code)
    };
    assert!(words(&[], 1).contains("truth.txt"));
    home.write("truth.txt", "1 2 3\n");
    assert!(words(&[], 1).contains("line 1"));
    home.write("truth.txt", TRUTH);
    assert!(words(&["--step", "0"], 2).contains("--step"));
    assert!(words(&["--associate", "luck"], 2).contains("name, time, order"));
    assert!(words(&["--associate", "name"], 1).contains("by name"));
    home.write("truth.txt", "10 1 1 1 0 0 0 1\n20 1 1 1 0 0 0 1\n40 1 1 1 0 0 0 1\n50 1 1 1 0 0 0 1\n");
    assert!(words(&[], 1).contains("all stand in one place"));
}

#[test]
fn a_film_becomes_what_colmaps_mapper_takes() {
    let home = folder();
    home.run_well("synth scene --out film --width 240 --height 180 --frames 12 --max-slope 1.5 --snr 10");
    let arguments = ["colmap", "film", "--burst-length", "4", "--slopes-u", "-2:2:5", "--out", "my rec"];
    let text = home.run_well(&arguments);
    says(
        &text,
        &["camera SIMPLE_RADIAL 240 180 288 120 90 0 (guessed: give --camera if you know it)", "3 images, 3 pairs: "],
    );
    let next =
        "colmap mapper --database_path 'my rec/database.db' --image_path 'my rec/images' --output_path 'my rec/sparse'";
    says(&text, &[&format!("{next}\n"), "half a frame after mid-burst"]);
    assert!(!text.contains("earlier database"), "{text}");
    home.make_dir("my rec/sparse");
    let text = home.run_well(&[&arguments[..], &["--images", "stack"]].concat());
    assert!(!text.contains("mid-burst") && text.contains("3 pairs, 3 from an earlier run: "), "{text}");
    assert!(text.contains("sparse is of an earlier database"), "{text}");
    fs::remove_dir(home.join("my rec/sparse")).expect("removed");
    // Of few features few match: no pair from which a mapper can start, and the command ends with that.
    let few = ["colmap", "film", "--burst-length", "4", "--slopes-u", "-2:2:5", "--max-features", "20", "--out", "few"];
    let output = home.run(&few);
    let (text, note) = (String::from_utf8_lossy(&output.stdout).into_owned(), stderr(&output));
    let why = "a mapper will not be able to start from it: none of 3 pairs is verified (0 without a match, 0 refused, in the \
               others too few agree), and it needs a pair with about 30 inliers";
    assert!(note.trim_end().ends_with(&format!("note: {why}; `burstscope match` shows what a pair lacks")), "{note}");
    assert!(text.ends_with("database.db\n") && !text.contains("Next:") && output.status.success(), "{text}");
    let json = home.run_json(&[&few[..], &["--json"]].concat());
    assert_eq!(json["no_start"], why);
    let some = ["--max-features", "45", "--align", "false", "--out", "some", "--json"];
    let json = home.run_json(&[&few[..6], &some].concat());
    assert!(json["no_start"].as_str().is_some_and(|why| why.contains("the most inliers of a pair are ")), "{json}");
    assert_eq!(names(&home.join("my rec")), ["database.db", "features", "images", "manifest.json", "records"]);
    // With a camera from a file, and as JSON; the features are there already.
    home.write("lens.toml", "model = \"PINHOLE\"\nwidth = 240\nheight = 180\nparams = [250, 250, 120, 90]\n");
    let json =
        home.run_json(&[&arguments[..], &["--camera", "lens.toml", "--pairs", "sequential:1", "--json"]].concat());
    assert_eq!((&json["known_camera"], &json["cameras"][0]["model"]), (&true.into(), &"PINHOLE".into()));
    assert_eq!((json["pairs"].as_array().map(Vec::len), &json["matching"]["geometry"]), (Some(2), &"essential".into()));
    assert_eq!(json["detector_revision"], burstscope::detector::REVISION);
    let manifest = home.json("my rec/manifest.json");
    let made = &manifest["claims"]["settings"]["export"];
    assert_eq!(made["images"], "middle");
    assert_eq!((&made["pairs"], &made["camera"]), (&"sequential:1".into(), &"PINHOLE 240 180 250 250 120 90".into()));
    let matching: burstscope::matching::MatchParams =
        toml::from_str(made["matching"].as_str().expect("text")).expect("TOML");
    let matching: Value = serde_json::from_str(&serde_json::to_string(&matching).expect("plain values")).expect("JSON");
    assert_eq!(matching, json["matching"]);
    let held =
        "--Mapper.ba_refine_focal_length 0 --Mapper.ba_refine_principal_point 0 --Mapper.ba_refine_extra_params 0";
    assert!(json["next"][1].as_str().is_some_and(|line| line.ends_with(held)), "{}", json["next"]);
    assert_eq!(json["images"][0]["frames"], 4);
    assert!(json["images"].as_array().is_some_and(|all| all.len() == 3 && all.iter().all(|i| i["resumed"] == true)));
    // Features of another revision of the detector are not mixed with those of this one.
    for name in names(&home.join("my rec/records")).into_iter().filter(|name| name.ends_with(".json")) {
        let record = home.join("my rec/records").join(name);
        let mut kept: Value = serde_json::from_str(&fs::read_to_string(&record).expect("a file")).expect("JSON");
        kept["detector_revision"] = 0.into();
        fs::write(&record, kept.to_string()).expect("written");
    }
    let again = home.run_json(&[&arguments[..], &["--json"]].concat());
    assert!(again["images"].as_array().is_some_and(|all| all.len() == 3 && all.iter().all(|i| i["resumed"] == false)));
    home.write("film/frame_001.png", "broken");
    let output = home.run(&arguments);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("2 images, 1 pair, 1 from an earlier run: "));
    assert!(stderr(&output).contains("frame_001.png"));
}

#[test]
fn bursts_of_two_cameras_have_a_camera_each() {
    fn colmap<'a>(more: &[&'a str]) -> Vec<&'a str> {
        [&["colmap", "set", "--slopes-u", "-2:2:5", "--out", "rec"], more].concat()
    }
    let home = folder();
    home.make_dir("set");
    let scene = "synth scene --width 240 --height 180 --frames 4 --max-slope 1.5 --snr 10 --seed 3 --out";
    for name in ["set/left", "set/right"] {
        home.run_well(&scene.split(' ').chain([name]).collect::<Vec<_>>());
    }
    let lens =
        |focal: u32| format!("model = \"PINHOLE\"\nwidth = 240\nheight = 180\nparams = [{focal}, {focal}, 120, 90]\n");
    home.write("set/right/camera.toml", lens(240));
    home.write("lens.toml", lens(250));
    let text = home.run_well(&colmap(&["--camera", "left=lens.toml"]));
    for line in [
        "camera PINHOLE 240 180 250 250 120 90 of 1 image (from lens.toml)\n",
        "camera PINHOLE 240 180 240 240 120 90 of 1 image (from set/right/camera.toml)\n",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let json = |more: &[&str]| -> Value { home.run_json(&colmap(&[more, &["--json"]].concat())) };
    let both = json(&["--camera", "left=lens.toml"]);
    assert_eq!((&both["known_camera"], &both["matching"]["geometry"]), (&true.into(), &"essential".into()));
    assert!(both["matching"].get("camera").is_none() && both["pairs"][0]["resumed"] == true, "{both}");
    let camera = &both["cameras"][1];
    let expected = serde_json::json!({ "model": "PINHOLE", "width": 240, "height": 180, "params": [240.0, 240.0, 120.0, 90.0],
        "known": true, "from": ["set/right/camera.toml"], "images": [2] });
    assert_eq!(*camera, expected);
    assert_eq!(home.json("rec/manifest.json")["claims"]["settings"]["export"]["cameras"], both["cameras"]);
    let found = json(&[]);
    assert_eq!((&found["known_camera"], &found["cameras"][0]["known"]), (&false.into(), &false.into()));
    assert_eq!((&found["cameras"][1], &found["pairs"][0]["resumed"]), (camera, &false.into()));
    let all = json(&["--camera", "lens.toml"]);
    assert_eq!((all["cameras"].as_array().map(Vec::len), &all["known_camera"]), (Some(1), &true.into()));
    let unknown = home.run_badly(&colmap(&["--camera", "lef=lens.toml"]), 2);
    assert!(unknown.contains("'lef'") && unknown.contains("left, right"), "{unknown}");
    says(home.run_badly(&colmap(&["--camera", "lens.toml", "--camera", "lens.toml"]), 2), &["FOLDER=CAMERA"]);
    // A pair has them too, each side its own, and with one unknown the fundamental matrix.
    let pair = |more: &[&str]| -> Value {
        let line = ["match", "set/left", "set/right", "--slopes-u", "-2:2:5", "--out", "m", "--json"];
        home.run_json(&[&line, more].concat())
    };
    let (both, found) = (pair(&["--camera", "left=lens.toml"]), pair(&[]));
    let focal = |camera: &str| both["matching"][camera]["params"][0].clone();
    assert_eq!((focal("camera"), focal("camera_b")), (250.0.into(), 240.0.into()));
    assert_eq!([&both, &found].map(|one| one["matching"]["geometry"].clone()), ["essential", "fundamental"]);
    let small = ["--camera", "left=PINHOLE,9,9,5,5,4,4"];
    let line = [&["match", "set/left", "set/right", "--slopes-u", "-2:2:5", "--out", "m"], &small[..]].concat();
    assert!(home.run_badly(&line, 1).contains("240×180"));
}

#[test]
fn datasets_that_make_no_sense_say_what_would() {
    let home = folder();
    home.run_well("synth scene --out film --width 64 --height 48 --frames 2 --max-slope 1");
    let words =
        |arguments: &[&str], code| home.run_badly(&[&["colmap", "film", "--out", "rec"], arguments].concat(), code);
    assert!(words(&[], 1).contains("--burst-length"));
    assert!(words(&["--camera", "FISHEYE,1,2,3"], 2).contains("OPENCV"));
    assert!(words(&["--camera", "gone.toml"], 2).contains("gone.toml"));
    assert!(words(&["--camera", "PINHOLE,9,9,5,5,4,4", "--burst-length", "1"], 1).contains("64×48"));
    for wrong in ["some", "near:0", "near", "sequential:0", "all:2"] {
        says(words(&["--pairs", wrong], 2), &["sequential:K' nor 'near:K'", "--pairs"]);
    }
    assert!(words(&["--burst-length", "0"], 2).contains("--burst-length"));
    assert!(home.run_badly("colmap demo --out rec", 2).contains("demo"));
    assert!(!home.join("rec").exists());
}

/// The keypoints of the image `name` in the database of `rec` (x, y, scale), pixels; the first centre is at 0.5.
fn keypoints(rec: &Path, name: &str) -> Vec<[f64; 3]> {
    let database = rusqlite::Connection::open(rec.join("database.db")).expect("a database");
    let sql = "SELECT data FROM keypoints JOIN images USING (image_id) WHERE name = ?";
    let data: Vec<u8> = database.query_row(sql, [name], |row| row.get(0)).expect("keypoints");
    let number = |row: &[u8], k: usize| f64::from(f32::from_le_bytes(std::array::from_fn(|i| row[4 * k + i])));
    data.chunks_exact(16).map(|row| [0, 1, 2].map(|k| number(row, k))).collect()
}

#[test]
fn the_databases_keypoints_lie_in_their_pictures_and_the_command_says_how_far_they_were_moved() {
    let home = folder();
    let at = |name: &str| home.join(name);
    let scene =
        "synth scene --out film --width 240 --height 180 --frames 21 --max-slope 1.5 --snr 0.7 --seed 2".words();
    home.run_well(&scene);
    // What is behind a post is not seen.
    let post = |u: u32, v: u32| image::Luma([if (110..140).contains(&u) && v > 60 { 0 } else { 255 }]);
    image::GrayImage::from_fn(240, 180, post).save(at("post.png")).expect("written");
    let arguments = "colmap film --burst-length 7 --slopes-u -2:2:9 --mask post.png --out rec".words();
    let json = home.run_json(&[&arguments[..], &["--json"]].concat());
    let (mut places, mut inside) = (Vec::new(), 0);
    for image in json["images"].as_array().expect("images") {
        let name = image["image"].as_str().expect("a name");
        let mask = image::open(at(&format!("rec/masks/{name}.png"))).expect("its mask").into_luma8();
        let is_seen = |x: f64, y: f64| {
            let in_picture = x > 0.0 && y > 0.0 && x < 240.0 && y < 180.0;
            in_picture && mask[(x as u32, y as u32)].0[0] > 127
        };
        let text = home.text(&format!("rec/features/{name}.txt"));
        let number = |x: &str| f64::from(x.parse::<f32>().expect("a number"));
        let numbers = |line: &str| line.split(' ').take(3).map(number).collect::<Vec<f64>>();
        let found: Vec<Vec<f64>> = text.lines().skip(1).map(numbers).collect();
        for (now, before) in keypoints(&at("rec"), name).iter().zip(&found) {
            let moved = (now[0] - before[0]).hypot(now[1] - before[1]);
            assert!(moved <= 20.001, "{moved} px");
            if moved > 0.0 {
                assert!(is_seen(now[0], now[1]), "{name}: {before:?} was moved to {now:?}");
                inside += 1;
            }
            places.push(([before[0], before[1], before[2]].map(f64::to_bits), name.to_owned(), moved));
        }
    }
    // The orientations of one keypoint count once.
    places.sort_by(|a, b| (&a.1, a.0).cmp(&(&b.1, b.0)));
    places.dedup_by(|a, b| (&a.1, a.0) == (&b.1, b.0));
    let mut moved: Vec<f64> = places.iter().map(|place| place.2).filter(|moved| *moved > 0.0).collect();
    moved.sort_by(f64::total_cmp);
    let told = |key: &str| json["moved"][key].as_f64().unwrap_or_else(|| panic!("{key}: {}", json["moved"]));
    assert!(inside > 50, "{inside} were moved");
    assert!((told("share") - moved.len() as f64 / places.len() as f64).abs() < 0.01, "{}", json["moved"]);
    assert!((told("median_px") - moved[moved.len() / 2]).abs() < 0.01);
    assert!((told("max_px") - moved.last().unwrap()).abs() < 0.01);
    let text = home.run_well(&arguments);
    let line = format!("by {:.1} px in the median and {:.1} px at most", told("median_px"), told("max_px"));
    assert!(text.contains(&line) && text.contains("as found, like all in features/"), "{text}");
    let text = home.run_well(&[&arguments[..], &["--align", "false"]].concat());
    assert!(!text.contains("moved"), "{text}");
    let name = json["images"][0]["image"].as_str().expect("a name");
    let text = home.text(&format!("rec/features/{name}.txt"));
    let first: Vec<f64> = text.lines().nth(1).expect("one").split(' ').take(3).map(|x| x.parse().unwrap()).collect();
    assert_eq!(keypoints(&at("rec"), name)[0].to_vec(), first.iter().map(|x| f64::from(*x as f32)).collect::<Vec<_>>());
}
