//! Parameters of the detector and choices of how files are opened: what is read comes back, and nonsense is named.

use crate::prelude::*;
use burstscope_core::detector::params::{Stage, doc};

#[test]
fn a_file_may_fix_gate_frames_slopes_and_rules_and_brings_what_it_does_not_say() {
    let text =
        "noise_gate = 4.5\nframes = { start = 2, end = 9 }\n[slopes]\nv = { min = -1.0, max = 1.0, count = 3 }\n";
    let params = SearchParams::from_toml(text).expect("valid");
    assert_eq!(params.noise_gate, NoiseGate::Factor(4.5));
    assert_eq!(params.used_frames(20), 2..9);
    assert!(params.at_given().slopes.is_plane());
    assert_eq!(SearchParams::from_toml(&params.to_toml()), Ok(params));
    assert_eq!(SearchParams::from_toml(""), Ok(SearchParams::default()));
    assert_eq!(SearchParams::from_toml("slopes = \"auto\""), Ok(SearchParams::default()));
    let given = SearchParams::from_toml("[slopes]\nu = { min = -1.0, max = 1.0, count = 3 }\n").expect("valid");
    assert_eq!(given.slopes, Slopes::Given(SlopeGrid::line(-1.0..=1.0, 3)));
    assert_eq!(given.at_given().slopes, SlopeGrid::line(-1.0..=1.0, 3));
    let params = SearchParams::from_toml("rules = \"buff\"\nlevels = 5\n").expect("valid");
    assert_eq!(params, SearchParams { levels: 5, ..SearchParams::default().under(Rules::BUFF) });
    assert_eq!(SearchParams::from_toml(&params.to_toml()), Ok(params.clone()));
    let search = SearchParams::from_toml("rules = \"buff\"").expect("valid");
    assert_eq!(search, SearchParams::default().under(Rules::BUFF));
    let given = [(doc::LEVELS, "5"), (doc::RULES, "buff")];
    assert_eq!(SearchParams::default().with_texts(given).expect("valid"), params);
}

#[test]
fn nonsense_is_named_with_its_remedy_and_nonsense_in_a_search_says_what_would_be_right() {
    let good = DetectorParams::default;
    let cases: [(DetectorParams, &str); 9] = [
        (DetectorParams { slopes: SlopeGrid::line(3.0..=-3.0, 7), ..good() }, "slopes-u"),
        (DetectorParams { slopes: SlopeGrid::line(0.0..=0.0, 2), ..good() }, "slopes-u"),
        (DetectorParams { slopes: SlopeGrid::plane(0.0..=1.0, 100, 0.0..=1.0, 100), ..good() }, "slopes-v"),
        (DetectorParams { frames: Some(FrameRange { start: 3, end: 3 }), ..good() }, "frames"),
        (DetectorParams { octaves: 0, ..good() }, "octaves"),
        (DetectorParams { levels: 11, ..good() }, "levels"),
        (DetectorParams { peak_threshold: f32::NAN, ..good() }, "peak-threshold"),
        (DetectorParams { edge_threshold: 0.5, ..good() }, "edge-threshold"),
        (DetectorParams { noise_gate: NoiseGate::Factor(-1.0), ..good() }, "noise-gate"),
    ];
    cases.into_iter().for_each(|(params, name)| assert_eq!(params.validate().expect_err(name).subject, name));
    let one_frame = DetectorParams::default().validate_for(&Positions::even(1), (100, 100)).expect_err("one frame");
    assert_eq!(one_frame.subject, "frames");
    let sift = DetectorParams { method: Method::Sift, ..good() };
    assert_eq!(sift.validate_for(&Positions::even(1), (64, 64)), Ok(()));
    let too_fast = DetectorParams { slopes: SlopeGrid::line(-99.0..=99.0, 3), ..good() };
    assert_eq!(too_fast.validate_for(&Positions::even(10), (100, 100)).expect_err("too fast").subject, "slopes-u");
    for (text, words) in [
        ("slopes = \"all\"", "give \"auto\""),
        ("[slopes]\nauto = true\nu = { min = 0.0, max = 1.0, count = 2 }", "stands alone"),
        ("[slopes]\nauto = 3", "stands alone"),
        ("[slopes]\nauto = true\ndirection_deg = \"up\"", "give degrees"),
        ("[slopes]\nauto = true\ndirection_deg = nan", "slope-direction"),
        ("slopes = \"auto\"\npeak_treshold = 1.0", "peak_treshold"),
        ("slopes = \"auto\"\nlevels = 0", "give 1 to 10"),
        ("levels = ", "TOML"),
        ("[slopes]\ndirection = 90.0", "direction_deg"),
        ("[slopes]\nu = { min = 0.0, max = 1.0, count = 2, step = 1.0 }", "step"),
    ] {
        says(SearchParams::from_toml(text).expect_err(text), &[words]);
    }
}

#[test]
fn every_field_has_a_record_with_the_words_of_files_and_a_default_within_bounds() {
    // The reader's error names all fields, those that are left out of files too.
    let error = SearchParams::from_toml("nonsense = 1").expect_err("no such field");
    let (_, expected) = error.split_once("expected one of").expect("the names of the fields");
    let fields: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    assert!(fields.len() > 15 && fields.contains(&"frames"), "{error}");
    for field in fields.iter().filter(|field| **field != "slopes") {
        assert!(doc::ALL.iter().any(|d| d.name.replace('-', "_") == *field), "{field} has no record");
    }
    for record in doc::ALL.iter().filter(|record| !record.name.starts_with("slopes")) {
        let field = record.name.replace('-', "_");
        assert!(fields.contains(&field.as_str()) || *record == doc::SLOPE_DIRECTION, "{field} is no field");
    }
    for record in doc::ALL {
        assert_eq!(record.check(&SearchParams::default()), Ok(()), "{}", record.name);
        let mut params = SearchParams::default();
        for (word, _) in (record.field)(&mut params).words().unwrap_or_default() {
            record.read(&mut params, word).expect(word);
            let table = toml::Table::try_from(&params).expect("plain values");
            assert_eq!(table[&record.name.replace('-', "_")].as_str(), Some(*word));
        }
    }
}

#[test]
fn stages_are_decided_by_parameters_up_to_theirs_and_every_choice_survives_a_file() {
    let before = DetectorParams::default();
    let after = DetectorParams { levels: 3, ..before.clone() };
    assert_eq!(before.deciding(Stage::Stack), after.deciding(Stage::Stack));
    assert_ne!(before.deciding(Stage::Response), after.deciding(Stage::Response));
    assert_ne!(before.deciding(Stage::Search), after.deciding(Stage::Search));
    assert_eq!(before.deciding(Stage::Matching).len(), doc::ALL.len());
    let plane = SlopeGrid::plane(-0.3..=0.3, 7, -1.0..=1.0, 3);
    for slopes in [Slopes::Given(plane), Slopes::AUTO, Slopes::Auto { direction_deg: Some(-30.5) }] {
        let params = SearchParams { peak_threshold: 0.0003, levels: 3, slopes, ..SearchParams::default() };
        let text = params.to_toml();
        assert_eq!(SearchParams::from_toml(&text).as_ref(), Ok(&params), "{text}");
        let json = serde_json::to_string(&params).expect("written");
        assert_eq!(serde_json::from_str::<SearchParams>(&json).expect("read"), params, "{json}");
        assert!(json.contains("\"peak_threshold\":0.0003,"), "{json}");
    }
}

#[test]
fn dumps_axes_times_views_ranges_and_slopes_are_read_and_written_and_nonsense_refused() {
    for text in ["1600x1200:u16le", "3x2:mono12packed+16", "640x480:f32be"] {
        assert_eq!(text.parse::<Dump>().map(|dump| dump.to_string()), Ok(text.to_owned()));
    }
    let bad = "1600x1200 0x2:u8 3x2:u12 3x2:u8+ -3x2:u8 3x2:u8+-1 3:u8 99999999999999999999x2:u8";
    bad.split(' ').chain([""]).for_each(|bad| assert!(bad.parse::<Dump>().is_err(), "{bad}"));
    for text in ["T", "Z,C=1", "T,C=0,Z=12", "last"] {
        assert_eq!(text.parse::<AxisChoice>().map(|axis| axis.to_string()), Ok(text.to_owned()));
    }
    for text in ["even", "names", "header", "found", "logs/rgb.txt"] {
        assert_eq!(text.parse::<TimesChoice>().map(|times| times.to_string()), Ok(text.to_owned()));
    }
    assert_eq!(("exif".parse(), "".parse::<TimesChoice>().is_err()), (Ok(TimesChoice::Header), true));
    for bad in ["", "X", "T,", "T,C", "T,C=x", "T,last=1"] {
        assert!(bad.parse::<AxisChoice>().is_err(), "{bad}");
    }
    for text in ["names", "9x9", "1x27", "14x14:eslf", "3x5:tiled"] {
        assert_eq!(text.parse::<ViewsChoice>().map(|views| views.to_string()), Ok(text.to_owned()));
    }
    for bad in ["", "9", "0x9", "9x", "x9", "9x9:", "9x9:grid", "-1x3", "99999x2", "9x9x9", "names:tiled", "9X9"] {
        assert!(bad.parse::<ViewsChoice>().is_err(), "{bad}");
    }
    assert_eq!("3x5".parse(), ViewGrid::new(3, 5).ok_or_else(String::new));
    assert_eq!("0..9223372036854775807".parse(), Ok(FrameRange { start: 0, end: i64::MAX as usize }));
    for (text, words) in
        [("0..9223372036854775808", "9223372036854775807"), ("5", "A..B"), ("a..2", "A..B"), ("-1..2", "A..B")]
    {
        assert!(text.parse::<FrameRange>().is_err_and(|fault| fault.contains(words)), "{text}");
    }
    let axis: SlopeAxis = "-3:3:7".parse().expect("valid");
    assert_eq!(axis.to_string().parse(), Ok(axis));
    assert_eq!("2.5".parse::<SlopeAxis>().expect("valid").value(0.0), 2.5);
    for bad in ["", "1:2", "a:b:c", "1:2:3:4", "1:2:-3", "nan:1:2"] {
        assert!(bad.parse::<SlopeAxis>().is_err(), "{bad}");
    }
}

#[test]
fn a_line_is_horizontal_a_plane_has_its_first_axis_fastest_and_positions_are_the_inverse_of_slopes() {
    let grid = SlopeGrid::line(-3.0..=3.0, 7);
    assert!(grid.slopes().eq((-3..=3).map(|u| Slope::new(u as f32, 0.0))));
    assert!(grid.on_rim(0, 0) && grid.on_rim(6, 0) && !grid.on_rim(3, 0));
    assert_eq!(SlopeGrid::line_along(90.0, -1.0..=1.0, 3).slope(2), Slope::new(0.0, 1.0));
    let plane = SlopeGrid::plane(-1.0..=1.0, 3, 0.0..=2.0, 2);
    assert!(plane.is_plane() && plane.coordinates(4) == (1, 1));
    assert_eq!((plane.slope(0), plane.slope(5)), (Slope::new(-1.0, 0.0), Slope::new(1.0, 2.0)));
    for grid in [
        SlopeGrid::line(-3.0..=3.0, 7),
        SlopeGrid::line_along(30.0, -2.0..=4.0, 5),
        SlopeGrid { direction_deg: -75.0, ..SlopeGrid::plane(-1.0..=1.5, 6, 0.0..=2.0, 5) },
    ] {
        for (i, j) in [(0.0, 0.0), (1.0, 0.0), (2.3, 0.0), (2.3, 2.4), (3.6, 1.6)] {
            let j = if grid.v.count > 1 { j } else { 0.0 };
            let (a, b) = grid.position(grid.at(i, j));
            assert!((a - i).abs() < 1e-4 && (b - j).abs() < 1e-4, "{grid:?}: {a} {b} for {i} {j}");
        }
    }
    let line = SlopeGrid::line(-3.0..=3.0, 7);
    for (slope_u, on_rim) in [(-5.0, true), (-2.6, true), (-2.4, false), (0.0, false), (2.4, false), (2.6, true)] {
        assert_eq!(line.nearest_on_rim(Slope::new(slope_u, 0.0)), on_rim, "{slope_u}");
    }
    assert!(!SlopeGrid::single(Slope::new(1.0, 0.0)).nearest_on_rim(Slope::new(1.0, 0.0)));
}

#[test]
fn rules_have_names_bring_their_parameters_and_leave_what_is_searched() {
    let mine = DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 5), first_octave: -1, ..DetectorParams::default() };
    let mine = DetectorParams { max_features: 7, levels: 6, ..mine };
    let paper = mine.clone().under(Rules::BUFF);
    assert_eq!((paper.slopes, paper.first_octave, paper.max_features), (mine.slopes, -1, 7));
    assert_eq!((paper.slope_extrema, paper.distinct, paper.levels), (SlopeExtrema::Joint, Distinct::Off, 4));
    assert_eq!((paper.noise_gate, paper.edge_threshold), (NoiseGate::Factor(0.0), 10.0));
    let back = paper.under(Rules::BURSTSCOPE);
    assert_eq!(back, DetectorParams { levels: SearchParams::default().levels, ..mine.clone() });
    let own = Rules { kernel_cut: 3.0, ..Rules::VLFEAT };
    assert_eq!(mine.clone().under(own), DetectorParams { rules: own, ..mine });
    for ((rules, name), (word, _)) in Rules::NAMED.into_iter().zip(Rules::default().words()) {
        assert_eq!((name, rules.word()), (*word, name));
        let mut read = Rules { kernel_cut: 3.0, ..Rules::default() };
        assert!(read.word() == "own" && read.set_word(name) && read == rules);
    }
    assert!(!Rules::default().set_word("own"));
    let error = serde_json::from_str::<Rules>("\"own\"").expect_err("no set of this name");
    assert!(error.to_string().contains("give one of burstscope, buff, liff, vlfeat"), "{error}");
}

proptest! {
    #[test]
    fn every_burst_is_whole_and_the_last_one_is_the_last_that_fits(frames in 0usize..200, length in 1usize..20, step in 1usize..20) {
        let cut = SequenceCut::new(length, Some(step)).expect("it can be cut like this");
        let ranges: Vec<_> = cut.ranges(frames).collect();
        prop_assert!(ranges.iter().enumerate().all(|(k, r)| r.start == k * step && r.len() == length && r.end <= frames));
        let next = ranges.len() * step + length;
        prop_assert!(next > frames);
    }
}
