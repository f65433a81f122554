//! `stack`, `render`, and the program without a display.

use crate::support::*;
use burstscope::app::document::{Action, journal::Journal, side::Side};
use burstscope::detector::{Interpolation, stack::motion_stack};
use burstscope::synth::demo_burst;
use std::path::Component;

fn read_tiff(path: &Path) -> ((u32, u32), Vec<f32>) {
    let file = std::io::BufReader::new(fs::File::open(path).expect("a file"));
    let mut decoder = tiff::decoder::Decoder::new(file).expect("a TIFF");
    let size = decoder.dimensions().expect("a size");
    match decoder.read_image().expect("an image") {
        tiff::decoder::DecodingResult::F32(values) => (size, values),
        other => panic!("not 32-bit float: {other:?}"),
    }
}

#[test]
fn stack_writes_the_very_values_of_the_library_and_stack_writes_a_response_on_the_octaves_pixels() {
    let home = folder();
    says(home.run_well("stack demo --slope -2.1,0 --out deep/sign.tiff"), &["480×360"]);
    let (size, values) = read_tiff(&home.join("deep/sign.tiff"));
    let burst = demo_burst();
    let frames: Vec<&Plane> = burst.frames.iter().map(|f| &**f).collect();
    let stack =
        motion_stack(&frames, &burst.positions, Slope::new(-2.1, 0.0), Interpolation::Linear, &Monitor::default())
            .expect("done");
    assert_eq!((size, values.as_slice()), ((480, 360), stack.data()));
    let mean = |x: &[f32]| x.iter().map(|&x| f64::from(x)).sum::<f64>() / x.len() as f64;
    let of_frames = burst.frames.iter().map(|f| mean(f.data())).sum::<f64>() / 10.0;
    assert!((mean(&values) - of_frames).abs() < 5e-4, "{} {of_frames}", mean(&values));
    let json = home.run_json("stack demo --slope 0.95,0 --octave 1 --level 0 --levels 3 --out d.tif --json");
    let (size, values) = read_tiff(&home.join("d.tif"));
    assert_eq!(size, (240, 180));
    assert_eq!((&json["width"], &json["octave"]), (&240.into(), &1.into()));
    assert!(values.iter().any(|&x| x > 1e-3) && values.iter().any(|&x| x < -1e-3), "a response has both signs");
    says(home.run_badly("stack demo --slope 0,0 --octave 9 --level 0 --out e.tif", 2), &["octave"]);
    assert_eq!(names(&home), ["d.tif", "deep"]);
}

#[test]
fn the_field_of_motion_as_pfm_is_replaced_only_on_request() {
    let home = folder();
    let line = "stack demo --slopes-u=-3:3:7 --field --out field.pfm";
    home.run_well(line);
    let bytes = fs::read(home.join("field.pfm")).expect("written");
    let samples = bytes.strip_prefix(b"PF\n480 360\n-1.0\n").expect("a header");
    assert_eq!(samples.len(), 480 * 360 * 3 * 4);
    // The street moves to the left and the moon to the right; the last row comes first.
    let at = |u: usize, v: usize| {
        let start = 12 * ((359 - v) * 480 + u);
        f32::from_le_bytes(samples[start..start + 4].try_into().expect("four bytes"))
    };
    assert!(at(250, 340) < -1.5 && at(100, 50) > 0.5, "{} and {}", at(250, 340), at(100, 50));
    says(home.run_badly(line, 1), &["field.pfm", "--force"]);
    home.run_well(&format!("{line} --force"));
    says(home.run_badly("stack demo --field --out field.png", 2), &[".pfm"]);
}

#[test]
fn render_draws_the_window_without_words_on_a_display_and_says_damaged_cases() {
    let home = folder();
    home.run_well("render --out window.png --size 900x600 --slope -2.1,0 --no-detect");
    let picture = image::open(home.join("window.png")).expect("a picture").into_rgba8();
    assert_eq!(picture.dimensions(), (900, 600));
    let colours: std::collections::HashSet<_> = picture.pixels().map(|p| p.0).collect();
    assert!(colours.len() > 50, "only {} colours", colours.len());
    says(home.run_badly("render gone --out x.png", 1), &["gone"]);
    for name in ["damaged.burstcase", "damaged.npy"] {
        fs::write(home.join(name), b"PK\x03\x04 and no more").expect("written");
        let output = home.program(&[name]).output().expect("it starts");
        says(String::from_utf8_lossy(&output.stdout), &["There is no display here"]);
        assert!(output.status.code() == Some(1) && stderr(&output).contains(name), "{name}: {}", stderr(&output));
    }
    let arguments = "render --out window.png --size 300x200 --no-detect --quiet";
    let drawn = home.program(arguments).env_remove("XDG_RUNTIME_DIR").output().expect("it starts");
    assert!(drawn.status.success());
    assert_eq!(stderr(&drawn), "");
}

#[test]
fn what_was_done_in_a_window_is_done_again_also_from_another_folder_and_drawn() {
    let home = folder();
    let play = |did: &str| home.write("did.toml", format!("version = 1\ndid = [\n{did}\n]\n"));
    let arguments = ["render", "--play", "did.toml", "--out", "x.png", "--size", "600x400"];
    play("[{ do = \"auto_detect\" }],\n[{ open = [\"a\", \"demo\"] }],\n[{ set_slope = [0, { u = 2.0, v = 0.0 }] }],");
    home.run_well(&arguments);
    let picture = || image::open(home.join("x.png")).expect("a picture").into_rgba8();
    let first = picture();
    assert_eq!(first.dimensions(), (600, 400));
    play("[{ do = \"auto_detect\" }],\n[{ open = [\"a\", \"demo\"] }],");
    home.run_well(&arguments);
    assert_ne!(picture(), first, "the slope is another one");
    play("[{ set_slop = [0, { u = 2.0, v = 0.0 }] }],");
    says(home.run_badly(&arguments, 2), &["--play", "did.toml", "line 3", "set_slope"]);
    play("[{ open = [\"a\", { paths = [\"gone\"] }] }],");
    assert!(home.run_badly(&arguments, 1).contains("gone"));
    for (more, word) in
        [(["--kind", "dog"], "--kind"), (["--levels", "4"], "parameters"), (["--black-level", "5"], "calib")]
    {
        says(home.run_badly(&[&arguments[..], &more].concat(), 2), &["--play", word]);
    }
    let home = folder();
    home.run_well("synth chart --out burst");
    // From the folder of this test up to the root, and down again.
    let names = |path: &Path| path.components().filter(|part| matches!(part, Component::Normal(_))).count();
    let up = vec![".."; names(&std::env::current_dir().expect("a folder"))];
    let down = home.components().filter(|part| matches!(part, Component::Normal(_)));
    let relative: PathBuf = up.iter().map(Path::new).chain(down.map(|part| Path::new(part.as_os_str()))).collect();
    let relative = relative.join("burst");
    assert!(relative.is_relative() && relative.is_dir(), "{relative:?}");
    let mut journal = Journal::default();
    journal.take(&Action::Open(Side::A, BurstSource::Paths(vec![relative])), false);
    let elsewhere = folder();
    elsewhere.write("did.toml", journal.to_toml());
    elsewhere.run_well("render --play did.toml --out x.png --size 600x400");
    assert_eq!(image::open(elsewhere.join("x.png")).expect("a picture").width(), 600);
}

#[test]
fn without_a_display_the_window_becomes_a_picture_and_a_table() {
    let home = folder();
    let text = home.run_well(&[]);
    assert!(text.contains("no display") && text.contains("DISPLAY"), "{text}");
    let header = text.lines().position(|l| l.contains("orientation")).expect("a table");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(header + 2)
        .map_while(|l| l.split_whitespace().map(|x| x.parse().ok()).collect::<Option<Vec<f64>>>())
        .filter(|row| !row.is_empty())
        .collect();
    assert_eq!(rows.len(), 20, "{text}");
    assert!(rows.iter().all(|r| r.len() == 10), "{text}");
    assert_eq!(names(&home), ["burstscope-demo.png"]);
    image::open(home.join("burstscope-demo.png")).expect("a picture");
}
