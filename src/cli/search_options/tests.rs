//! Tests that every parameter is an option, and that every option sets its parameter.

use super::*;
use clap::{CommandFactory, Parser};

#[derive(Parser)]
struct Only {
    #[command(flatten)]
    search: SearchArgs,
}

fn params(arguments: &[&str]) -> Result<SearchParams, String> {
    let only = Only::try_parse_from([&["x"], arguments].concat()).map_err(|e| e.to_string())?;
    only.search.params().map_err(|f| format!("{f:?}"))
}

#[test]
fn every_parameter_is_an_option_with_its_help() {
    let command = Only::command();
    for doc in doc::ALL {
        let arg = command.get_arguments().find(|a| a.get_long() == Some(doc.name));
        let arg = arg.unwrap_or_else(|| panic!("--{} is missing", doc.name));
        let text = |help: Option<&clap::builder::StyledStr>| help.expect("it has help").to_string();
        assert!(text(arg.get_help()).starts_with(doc.meaning.trim_end_matches('.')));
        assert!(text(arg.get_long_help()).starts_with(&doc.help()));
        // The shown default can be typed, or says how it is chosen.
        let default = default_of(doc);
        let option = format!("--{}", doc.name);
        if doc.name != doc::FRAMES.name && !doc.name.starts_with("slope") || doc.name == doc::SLOPE_NEIGHBOURS.name {
            assert_eq!(params(&[option.as_str(), &default]), Ok(SearchParams::default()), "{}", doc.name);
        }
    }
}

#[test]
fn nothing_given_is_the_default() {
    assert_eq!(params(&[]), Ok(SearchParams::default()));
    assert_eq!(params(&["--slopes", "auto"]), Ok(SearchParams::default()));
}

#[test]
fn every_option_reaches_its_parameter() {
    let got = params(&[
        "--method",
        "sift",
        "--slopes-u",
        "-6:6:25",
        "--slopes-v",
        "-1:1:3",
        "--slope-direction",
        "-30",
        "--frames",
        "2..9",
        "--octaves",
        "4",
        "--levels",
        "5",
        "--first-octave",
        "-1",
        "--peak-threshold",
        "0.002",
        "--noise-gate",
        "4.5",
        "--noise-model",
        "white",
        "--flicker",
        "off",
        "--edge-threshold",
        "12",
        "--slope-neighbours",
        "all",
        "--slope-extrema",
        "joint",
        "--distinct",
        "off",
        "--distinct-scale",
        "2",
        "--describe-slope",
        "grid",
        "--interpolation",
        "nearest",
        "--kernel-cut",
        "3",
        "--localisation",
        "quadratic",
        "--max-features",
        "100",
        "--max-orientations",
        "3",
    ])
    .expect("valid");
    let mut slopes = crate::SlopeGrid::plane(-6.0..=6.0, 25, -1.0..=1.0, 3);
    slopes.direction_deg = -30.0;
    let expected = DetectorParams {
        method: Method::Sift,
        frames: Some(FrameRange { start: 2, end: 9 }),
        octaves: 4,
        levels: 5,
        first_octave: -1,
        peak_threshold: 0.002,
        noise_gate: NoiseGate::Factor(4.5),
        noise_model: NoiseModelKind::White,
        flicker: Flicker::Off,
        edge_threshold: 12.0,
        slope_extrema: SlopeExtrema::Joint,
        slope_neighbours: SlopeNeighbours::All,
        distinct: Distinct::Off,
        distinct_scale: 2.0,
        describe_slope: DescribeSlope::Grid,
        interpolation: Interpolation::Nearest,
        kernel_cut: 3.0,
        localisation: Localisation::Quadratic,
        max_features: 100,
        max_orientations: 3,
        slopes,
    };
    assert_eq!(got, expected.into());
}

#[test]
fn one_axis_alone_makes_the_other_zero() {
    let got = params(&["--slopes-v", "-2:2:5"]).expect("valid").detector;
    assert_eq!((got.slopes.u, got.slopes.v.count), (SlopeAxis::ZERO, 5));
}

#[test]
fn options_override_the_file() {
    let file = tempfile::NamedTempFile::new().expect("a file");
    let path = file.path().to_str().expect("plain");
    std::fs::write(path, "octaves = 3\nlevels = 5\n[slopes]\nv = { min = -1.0, max = 1.0, count = 3 }\n")
        .expect("written");
    let got = params(&["--params", path, "--levels", "4", "--slopes-u", "0:2:3"]).expect("valid");
    assert_eq!(got.slopes, SlopeChoice::Given);
    let got = got.detector;
    assert_eq!((got.octaves, got.levels, got.slopes.u.count, got.slopes.v.count), (3, 4, 3, 3));
    let found = params(&["--params", path, "--slopes", "auto"]).expect("valid");
    assert_eq!((found.slopes, found.detector.octaves), (SlopeChoice::AUTO, 3));
}

#[test]
fn a_direction_alone_says_on_which_line_slopes_are_found() {
    let line = SlopeChoice::Auto { direction_deg: Some(30.0) };
    assert_eq!(params(&["--slope-direction", "30"]).expect("valid").slopes, line);
    assert_eq!(params(&["--slopes", "auto", "--slope-direction", "30"]).expect("valid").slopes, line);
    let given = params(&["--slopes-u", "0:2:3", "--slope-direction", "30"]).expect("valid");
    assert_eq!((given.slopes, given.detector.slopes.direction_deg), (SlopeChoice::Given, 30.0));
}

#[test]
fn nonsense_says_what_would_be_right() {
    for (arguments, words) in [
        (vec!["--slopes-u", "3:-3:7"], "give the smaller slope first"),
        (vec!["--slopes-u", "1:2"], "is not MIN:MAX:COUNT"),
        (vec!["--slopes", "auto", "--slopes-u", "0:2:3"], "cannot be used with"),
        (vec!["--slopes", "auto", "--slopes-v", "0:2:3"], "cannot be used with"),
        (vec!["--slopes", "all"], "possible values: auto"),
        (vec!["--method", "surf"], "possible values: buff, sift"),
        (vec!["--frames", "5"], "is not A..B"),
        (vec!["--noise-gate", "lots"], "neither 'auto' nor 'strict' nor a number"),
        (vec!["--levels", "0"], "give 1 to 10"),
        (vec!["--params", "/nowhere/p.toml"], "/nowhere/p.toml"),
    ] {
        let error = params(&arguments).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}
