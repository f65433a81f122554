//! VLFeat's results (by pycolmap) on pictures of our own: numbers in `own/`, made by `own/make.py`, so that the
//! agreement is tested wherever the tests run. These tests are never skipped.

use super::published::as_published;
use crate::prelude::*;

struct Theirs {
    u: f32,
    v: f32,
    sigma: f32,
    orientation: f32,
    descriptor: [u8; 128],
}

/// Parses the lines of `own/NAME_OCTAVE.txt`.
fn theirs(name: &str, first_octave: i32) -> Vec<Theirs> {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/detection/goldens/own/{name}_{first_octave}.txt"));
    let text = fs::read_to_string(&file).expect("the answers are kept with the tests");
    let line = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let number = |i: usize| words[i].parse::<f32>().expect("a number");
        let byte = |i: usize| u8::from_str_radix(&words[4][2 * i..2 * i + 2], 16).expect("two hexadecimal digits");
        Theirs {
            u: number(0) - 0.5,
            v: number(1) - 0.5,
            sigma: number(2),
            orientation: number(3),
            descriptor: std::array::from_fn(byte),
        }
    };
    text.lines().map(line).collect()
}

/// The picture that `own/make.py` used: the first frame without noise, in 8 bit.
fn picture(width: usize, height: usize, seed: u64) -> Burst {
    let params = SceneParams { width, height, frames: 1, snr: f64::INFINITY, seed, ..SceneParams::default() };
    let (burst, _) = synth_scene(&params, &quiet()).expect("a scene");
    let eight_bit = |value: f32| {
        let word = (f64::from(value) * 65_535.0).round();
        ((word / 257.0 + 0.5).floor() / 255.0) as f32
    };
    let frame = &burst.frames[0];
    Burst::from_planes("picture", vec![Plane::from_fn(width, height, |u, v| eight_bit(frame.at(u, v)))])
}

fn is_there(theirs: &Theirs, ours: &Feature) -> bool {
    (theirs.u - ours.u).hypot(theirs.v - ours.v) <= 0.05 && (theirs.sigma / ours.sigma - 1.0).abs() <= 0.01
}

fn agree(theirs: &Theirs, ours: &Feature) -> bool {
    let turn = (theirs.orientation - ours.orientation).rem_euclid(std::f32::consts::TAU);
    is_there(theirs, ours) && turn.min(std::f32::consts::TAU - turn) <= 0.03
}

/// Checks agreement: at most 2 % of the positions and scales of either side are missing on the other. Blobs of a
/// picture without noise are round and have no clear direction, so that orientations are sensitive: at least half of
/// them agree (55 to 82 % do within 0.03 rad).
fn check(name: &str, burst: &Burst, first_octave: i32) {
    let theirs = theirs(name, first_octave);
    let params = DetectorParams {
        method: Method::Sift,
        first_octave,
        octaves: 16,
        levels: 3,
        peak_threshold: 0.02 / 3.0,
        noise_gate: NoiseGate::Factor(0.0),
        rules: Rules::VLFEAT,
        max_orientations: 4,
        ..as_published()
    };
    let ours = detect(burst, &params, &quiet()).expect("valid parameters");
    let missed = theirs.iter().filter(|one| !ours.features.iter().any(|feature| is_there(one, feature))).count();
    let extra = ours.features.iter().filter(|feature| !theirs.iter().any(|one| is_there(one, feature))).count();
    let mut pairs = Vec::new();
    for one in &theirs {
        pairs.extend(ours.features.iter().position(|feature| agree(one, feature)).map(|index| (one, index)));
    }
    let (total, own) = (theirs.len(), ours.features.len());
    println!(
        "{name} from octave {first_octave}: theirs {total}, missed {missed}, ours {own}, extra {extra}, {} alike",
        pairs.len()
    );
    assert!(total >= 20, "{total} features say little");
    assert!(missed * 50 <= total, "{missed} of {total} missed");
    assert!(extra * 50 <= own, "{extra} of {own} extra");
    assert!(pairs.len() * 2 >= total, "{} of {total} orientations agree", pairs.len());
    let differences = pairs.iter().flat_map(|(one, index)| one.descriptor.iter().zip(&ours.descriptors[*index]));
    let sum: f64 = differences.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs()).sum();
    let mean = sum / (128.0 * pairs.len() as f64);
    println!("{name} from octave {first_octave}: descriptors differ by {mean:.3} of 255 in the mean");
    assert!(mean <= 3.0, "{mean}");
}

#[test]
fn vlfeat_on_two_scenes() {
    let scene = picture(320, 240, 20);
    check("scene", &scene, 0);
    check("scene", &scene, -1);
    let fields = picture(300, 260, 33);
    check("fields", &fields, 0);
    check("fields", &fields, -1);
}
