//! Bias and flat frames, levels, linear light and masks on the command line.

use crate::support::*;
use image::{ImageBuffer, Luma};

/// A folder with ten-bit frames of noise with strong fixed spots, and the spots alone.
fn spotted() -> Folder {
    let home = folder();
    home.make_dir("night");
    let spot = |u: u32, v: u32| {
        let (du, dv) = ((u % 20).abs_diff(10), (v % 20).abs_diff(10));
        if du * du + dv * dv < 10 { 900u16 } else { 300 }
    };
    let picture = |noise: &mut dyn FnMut() -> u16| {
        ImageBuffer::<Luma<u16>, _>::from_fn(160, 120, |u, v| Luma([spot(u, v) + noise()]))
    };
    let mut state = 0x1234_5678u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 26) as u16
    };
    (0..6).for_each(|t| picture(&mut noise).save(home.join(format!("night/{t}.png"))).expect("written"));
    picture(&mut || 32).save(home.join("bias.png")).expect("written");
    home
}

fn features(home: &Path, options: &[&str]) -> (u64, Value) {
    let search = "detect night --out found --json --slopes-u -1:1:3 --noise-model white --noise-gate 4".words();
    let json = home.run_json(&[&search, options].concat());
    (json["bursts"][0]["features"].as_u64().expect("a number"), json["bursts"][0].clone())
}

#[test]
fn a_bias_counts_in_whatever_file_it_comes() {
    let home = spotted();
    let (without, burst) = features(&home, &[]);
    assert_eq!((&burst["encoding"], &burst["binning"]), (&"linear".into(), &1.into()));
    assert_eq!(burst["suggested_full_scale"], 1023.0, "{burst}");
    let (with, _) = features(&home, &["--bias", "bias.png"]);
    assert!(without > 20 && with < without / 10, "{with} of {without} spots are left");
    // The bias as written by `stack`: fractions of full scale, as float.
    home.run_well("stack bias.png --method sift --slope 0,0 --out bias.tiff");
    let (float, _) = features(&home, &["--bias", "bias.tiff"]);
    assert_eq!(float, with);
    // A black level moves all values alike, so the spots stay; a full scale makes them larger.
    let (levels, burst) = features(&home, &["--black-level", "300", "--full-scale", "1023"]);
    assert!(levels > 20 && burst["full_scale"] == 1023.0 && burst.get("suggested_full_scale").is_none(), "{burst}");
    says(home.run_badly("detect night --out found --black-level 70000", 1), &["black level"]);
    says(home.run_badly("detect demo --out found --flat bias.png", 2), &["--flat"]);
}

fn half(home: &Path) {
    let mask = image::GrayImage::from_fn(160, 120, |u, _| Luma([if u < 80 { 255 } else { 0 }]));
    mask.save(home.join("half.png")).expect("written");
}

#[test]
fn masks_hide_features_and_tally_probe_and_info_say_so() {
    let home = spotted();
    half(&home);
    let (all, burst) = features(&home, &[]);
    assert_eq!(burst["tally"]["rejected"]["seen"], 0);
    let (left, burst) = features(&home, &["--mask", "half.png"]);
    assert!(3 * left > all && 5 * left < 3 * all, "{left} of {all}");
    assert!(burst["tally"]["rejected"]["seen"].as_u64() > Some(0), "{burst}");
    let told = home.run_well("detect night --out found --slopes-u -1:1:3 --mask half.png");
    assert!(told.contains("50.0 % of the pixels are masked by half.png"), "{told}");
    let search = ["--slopes-u", "-1:1:3", "--noise-gate", "4", "--mask", "half.png"];
    let place = |at: &str| home.run_well(&[&["probe", "night", "--at", at][..], &search].concat());
    assert!(place("70,50").contains("seen, share of its disc"), "{}", place("70,50"));
    assert!(place("90,50").contains("frame   0  does not show the place"), "{}", place("90,50"));
    assert!(home.run_well("info night --mask half.png").contains("masked by half.png"));
    image::GrayImage::new(16, 12).save(home.join("small.png")).expect("written");
    says(home.run_badly("detect night --out found --mask small.png", 1), &["small.png", "16×12", "160×120"]);
    says(home.run_badly("detect demo --out found --mask-saturated", 2), &["--mask-saturated"]);
}

#[cfg(feature = "colmap")]
#[test]
fn colmap_gets_the_masks_and_a_changed_mask_changes_its_burst_alone() {
    let home = spotted();
    half(&home);
    let at = |name: &str| home.join(name);
    for burst in ["a", "b"] {
        home.make_dir(&format!("nights/{burst}"));
        home.make_dir(&format!("masks/{burst}"));
        for t in 0..6 {
            fs::copy(at(&format!("night/{t}.png")), at(&format!("nights/{burst}/{t}.png"))).expect("copied");
            fs::copy(at("half.png"), at(&format!("masks/{burst}/{t}.png.png"))).expect("copied");
        }
    }
    let search = ["--slopes-u", "-1:1:3", "--noise-gate", "4", "--octaves", "2", "--mask", "masks", "--json"];
    let export = || {
        let json = home.run_json(&[&["colmap", "nights", "--out", "rec"][..], &search].concat());
        [0, 1].map(|image| json["images"][image]["resumed"].as_bool().expect("told"))
    };
    assert_eq!(export(), [false; 2]);
    for name in ["a", "b"] {
        let mask = image::open(at(&format!("rec/masks/{name}.png.png"))).expect("written").into_luma8();
        assert_eq!((mask.dimensions(), mask[(79, 60)], mask[(80, 60)]), ((160, 120), Luma([255]), Luma([0])));
    }
    assert_eq!(export(), [true; 2]);
    image::GrayImage::from_pixel(160, 120, Luma([255])).save(at("masks/b/3.png.png")).expect("written");
    assert_eq!(export(), [true, false]);
}

#[test]
fn pictures_for_screens_are_said_to_be_so() {
    let home = folder();
    home.make_dir("night");
    for t in 0..3u8 {
        let picture =
            image::RgbImage::from_fn(64, 48, |u, v| image::Rgb([(3 * u + t as u32) as u8, (2 * v) as u8, 90]));
        picture.save(home.join(format!("night/{t}.png"))).expect("written");
    }
    let search = "detect night --out found --slopes-u -1:1:3";
    says(home.run_well(search), &["encoded for screens (sRGB)", "--linearise"]);
    let text = home.run_well(&format!("{search} --linearise"));
    assert!(!text.contains("sRGB"), "{text}");
    home.write("film.mp4", b"\0\0\0\x18ftypisom\0\0\x02\0isomiso2");
    let mut detect = home.program("detect film.mp4 --out found");
    let output = detect.env("PATH", &*home).output().expect("it starts");
    let words = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(1), "{words}");
    says(&words, &["ffmpeg -i film.mp4 -fps_mode passthrough -vf 'format=gray|", "' -strict -1 film.y4m"]);
}

#[test]
fn info_says_what_an_input_is_and_a_dump_is_searched_as_it_says() {
    let home = spotted();
    let mut dump = vec![7; 5];
    for t in 0..6 {
        let frame = image::open(home.join(format!("night/{t}.png"))).expect("opens").into_luma16();
        dump.extend(frame.as_raw().iter().flat_map(|value| value.to_be_bytes()));
    }
    home.write("night.raw", dump);
    says(home.run_badly("info night.raw", 1), &["--raw WIDTHxHEIGHT:TYPE", "night.raw"]);
    let shape = ["--raw", "160x120:u16be+5"];
    let document = home.run_json(&["info", "night", "night.raw", shape[0], shape[1], "--json"]);
    for (burst, kind) in document["bursts"].as_array().expect("two").iter().zip(["PNG", "headerless"]) {
        assert_eq!((burst["kind"].as_str(), burst["samples"].as_str()), (Some(kind), Some("16 bit")));
        assert_eq!([&burst["frames"], &burst["width"], &burst["height"]].map(|n| n.as_u64()), [6, 160, 120].map(Some));
    }
    assert!(home.run_well("info demo").contains("made by Burstscope"));
    let stack = |input: &str, options: &[&str]| {
        let arguments = ["stack", input, "--slope", "0,0", "--out", "stack.tiff", "--force", "--quiet"];
        home.run_well(&[&arguments, options].concat());
        fs::read(home.join("stack.tiff")).expect("written")
    };
    assert!(stack("night", &[]) == stack("night.raw", &shape), "the same frames have the same stack");
    let part = stack("night.raw", &[&shape[..], &["--take", "2..5"]].concat());
    assert!(part == stack("night", &["--frames", "2..5"]), "a part has the stack of its frames");
    home.write("long.raw", vec![9; 5000 * 400]);
    let long = ["long.raw", "--raw", "20x20:u8"];
    says(home.run_well(&[&["info"], &long[..]].concat()), &["5000 frames", "take a part, such as --take 0..10"]);
    says(home.run_badly(&[&["detect"], &long[..], &["--out", "long"]].concat(), 1), &["--take"]);
    assert!(home.run_well(&[&["info"], &long[..], &["--take", "4990..5000"]].concat()).contains("10 frames"));
    says(home.run_badly("info demo --raw 1x1:u8", 2), &["--raw: built-in bursts"]);
    assert!(home.run_badly("info night.raw --raw 1600", 2).contains("WIDTHxHEIGHT:TYPE"));
}
