//! Marks with content, not the names of files, tell what the program wrote: nothing of others is lost.

use crate::support::*;

/// Writes files of somebody else, with these names and contents.
fn put(home: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        let path = home.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, text).expect("written");
    }
}

fn refused(home: &Path, arguments: &[&str], words: &[&str]) {
    let before = contents(home);
    says(home.run_badly(arguments, 1), words);
    assert!(contents(home) == before, "{arguments:?} changed something");
}

#[test]
fn folders_with_the_names_of_synthetic_bursts_are_not_replaced() {
    let home = folder();
    put(&home, &[("mine/frame_000.png", "mine"), ("mine/frame_001.png", "mine"), ("mine/truth.json", "{}")]);
    let way = ["bursts/burst_000/frame_000.png", "gold/burst_000.png", "poses.txt", "lens.toml", "trajectory.json"];
    way.iter().for_each(|name| put(&home, &[(&format!("way/{name}"), "{}")]));
    put(&home, &[("copies/noise.json", "{\"frames\": [\"a.png\"]}"), ("copies/a.png", "mine")]);
    chart(&home, "ours");
    for kind in ["chart", "scene"] {
        refused(&home, &["synth", kind, "--out", "mine"], &["did not write there", "mine"]);
    }
    refused(&home, &["synth", "trajectory", "--out", "way"], &["did not write there", "way"]);
    refused(&home, &["synth", "noisy", "ours", "--out", "copies"], &["did not write there", "copies"]);
    // Nor is one of ours in which somebody replaced a file, added one, or made a folder, or of another kind.
    let frame = fs::read(home.join("ours/frame_002.png")).expect("a frame");
    put(&home, &[("ours/frame_002.png", "mine")]);
    refused(&home, &["synth", "chart", "--out", "ours"], &["changed since", "ours"]);
    home.write("ours/frame_002.png", frame);
    put(&home, &[("ours/frame_009.png", "mine")]);
    refused(&home, &["synth", "chart", "--out", "ours"], &["changed since", "ours"]);
    fs::remove_file(home.join("ours/frame_009.png")).expect("removed");
    refused(&home, &["synth", "trajectory", "--out", "ours"], &["did not write there", "ours"]);
    chart(&home, "ours");
}

#[cfg(feature = "colmap")]
#[test]
fn a_manifest_makes_no_dataset() {
    let home = home_with(&["nights/a", "nights/b"]);
    put(
        &home,
        &[
            ("page/manifest.json", r#"{"name": "my page", "version": "1", "settings": {}}"#),
            ("page/database.db", "mine"),
            ("page/images/a.png", "mine"),
            ("page/features/a.png.txt", "1 128\nmine"),
            ("params/manifest.json", "levels = 4\n"),
        ],
    );
    let colmap = |out: &'static str| [&["colmap", "nights", "--out", out][..], &SEARCH].concat();
    refused(&home, &colmap("page"), &["this folder holds files", "page"]);
    let over = [&colmap("params")[..], &["--params", "params/manifest.json"]].concat();
    refused(&home, &over, &["this folder holds files", "params"]);
}

#[cfg(feature = "colmap")]
#[test]
fn files_of_others_in_a_dataset_of_ours_stay() {
    let home = home_with(&["nights/a", "nights/b"]);
    let at = |name: &str| home.join(name);
    let colmap = [&["colmap", "nights", "--out", "rec"][..], &SEARCH].concat();
    home.run_well(&colmap);
    let gray = image::GrayImage::from_pixel(8, 8, image::Luma([9]));
    gray.save(at("theirs.png")).expect("written");
    let database = rusqlite::Connection::open(at("theirs.db")).expect("a database");
    database.execute_batch("CREATE TABLE notes (text TEXT);").expect("made");
    drop(database);
    put(&home, &[("theirs.txt", "mine"), ("theirs.json", "{\"version\": \"1\"}")]);
    for (theirs, ours) in [
        ("theirs.png", "rec/images/a.png"),
        ("theirs.txt", "rec/features/b.png.txt"),
        ("theirs.db", "rec/database.db"),
        ("theirs.json", "rec/records/a.png.json"),
        ("theirs.txt", "rec/records/pairs/a.png/b.png.pair"),
    ] {
        let whole = fs::read(at(ours)).expect("there");
        fs::copy(at(theirs), at(ours)).expect("copied");
        says(home.run_badly(&colmap, 1), &["did not write this file", ours]);
        assert!(fs::read(at(ours)).expect("there") == fs::read(at(theirs)).expect("there"), "{ours}");
        fs::write(at(ours), whole).expect("put back");
    }
    // What COLMAP adds to our database makes it nobody else's.
    let database = rusqlite::Connection::open(at("rec/database.db")).expect("a database");
    database.execute_batch("CREATE TABLE added (id INTEGER); PRAGMA user_version = 3120;").expect("added");
    drop(database);
    home.run_well(&colmap);
    for part in ["images", "features", "records", "records/pairs", "records/pairs/a.png"] {
        let (inside, outside) = (at(&format!("rec/{part}")), at(&format!("elsewhere {}", part.replace('/', " "))));
        fs::rename(&inside, &outside).expect("moved");
        std::os::unix::fs::symlink(&outside, &inside).expect("linked");
        let other = [&colmap[..], &["--edge-threshold", "5"]].concat();
        refused(&home, &other, &["links are not followed", part]);
        fs::remove_file(&inside).and_then(|()| fs::rename(&outside, &inside)).expect("put back");
    }
    home.run_well(&colmap);
}

#[test]
fn records_make_no_folder_of_figures_and_cameras_and_files_beside_a_series_stay() {
    let home = folder();
    put(&home, &[("mine/records/pieces/a.json", "{}"), ("mine/fig9.svg", "mine"), ("mine/index.html", "mine")]);
    let figures = |out: &'static str| ["figures", "--out", out, "--quick", "--no-colmap", "--only", "fig9"];
    refused(&home, &figures("mine"), &["this folder holds files", "mine"]);
    home.run_well(&figures("ours"));
    put(&home, &[("ours/index.html", "<p>mine</p>")]);
    says(home.run_badly(&figures("ours"), 1), &["did not write this file", "index.html"]);
    assert_eq!(home.text("ours/index.html"), "<p>mine</p>");
    fs::remove_file(home.join("ours/index.html")).expect("removed");
    fs::rename(home.join("ours/records"), home.join("elsewhere")).expect("moved");
    std::os::unix::fs::symlink(home.join("elsewhere"), home.join("ours/records")).expect("linked");
    refused(&home, &figures("ours"), &["links are not followed", "records"]);
    let home = home_with(&["a", "b"]);
    let camera = "model = \"SIMPLE_PINHOLE\"\nwidth = 96\nheight = 72\nparams = [100.0, 48.0, 36.0]\n";
    put(&home, &[("camera.toml", camera)]);
    home.make_dir("out");
    fs::hard_link(home.join("camera.toml"), home.join("out/a.csv")).expect("linked");
    let matching = ["match", "a", "b", "--camera", "camera.toml", "--out", "out", "--force"];
    refused(&home, &[&matching[..], &SEARCH].concat(), &["files that were opened are never written to"]);
    let home = home_with(&["a"]);
    put(&home, &[("y.png", "a picture of somebody")]);
    let film = "film a --sweep frames --no-features --out y.png";
    home.run_well(&format!("{film} --force"));
    home.run_well(film);
    assert!(home.join("y-000.png").is_file());
    assert_eq!(fs::read(home.join("y.png")).expect("there"), b"a picture of somebody");
}

/// A TIFF with the name of the program in the field for it.
fn tiff_of_others(path: &Path) {
    let mut file = fs::File::create(path).expect("made");
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut file).expect("a TIFF");
    let mut page = encoder.new_image::<tiff::encoder::colortype::Gray8>(8, 8).expect("a page");
    page.encoder().write_tag(tiff::tags::Tag::Software, "Burstscope 0.1.0").expect("written");
    page.write_data(&[9; 64]).expect("written");
}

#[test]
fn files_that_speak_of_the_program_are_not_its_own() {
    let home = home_with(&["a"]);
    let at = |name: &str| home.join(name);
    tiff_of_others(&at("x.tiff"));
    home.make_dir("out");
    let mut npz = ndarray_npy::NpzWriter::new(fs::File::create(at("out/a.npz")).expect("made"));
    npz.add_array("features", &ndarray::Array2::<f32>::zeros((3, 11))).expect("written");
    npz.finish().expect("written");
    put(
        &home,
        &[
            ("y-003.png", "a picture of somebody"),
            ("x.gif", "GIF89a, a film about Burstscope "),
            ("x.svg", "<svg><!-- Written by Burstscope 0.1.0 --></svg>"),
        ],
    );
    let detect = [&["detect", "a", "--out", "out", "--format", "npz"][..], &SEARCH].concat();
    let probe = [&["probe", "a", "--at", "40,40", "--plot", "x.svg"][..], &SEARCH].concat();
    for (command, file) in [
        (&["stack", "a", "--slope", "0,0", "--out", "x.tiff"][..], "x.tiff"),
        (&["film", "a", "--sweep", "frames", "--no-features", "--out", "x.gif"], "x.gif"),
        (&["film", "a", "--sweep", "frames", "--no-features", "--out", "y.png"], "y-003.png"),
        (&detect, "out/a.npz"),
        (&probe, "x.svg"),
    ] {
        refused(&home, command, &["did not write this file", file, "--force"]);
        home.run_well(&[command, &["--force"]].concat());
        home.run_well(command);
        // As a picture that somebody has drawn over, in a program that keeps comments.
        let mut bytes = fs::read(at(file)).expect("read");
        let place = bytes.len() / 3;
        bytes[place] ^= 1;
        fs::write(at(file), bytes).expect("written");
        refused(&home, command, &["not as it is now", file]);
    }
    assert_eq!(names(&at("out")), ["a.npz"]);
}

#[needs::program("ffmpeg")]
#[test]
fn an_mp4_replaces_no_film_of_others() {
    let home = home_with(&["a"]);
    put(&home, &[("x.mp4", "\0\0\0\x18ftypisom a film about Burstscope")]);
    let film = ["film", "a", "--sweep", "frames", "--no-features", "--out", "x.mp4"];
    refused(&home, &film, &["did not write this file", "x.mp4", "--force"]);
    home.run_well(&[&film[..], &["--force"]].concat());
    let said = home.run_well(&film);
    assert!(said.contains("4 pictures of ") && !said.contains("about"), "{said}");
    let path = home.join("x.mp4");
    let mut bytes = fs::read(&path).expect("read");
    let place = bytes.len() / 3;
    bytes[place] ^= 1;
    fs::write(path, bytes).expect("written");
    refused(&home, &film, &["not as it is now", "x.mp4"]);
}
