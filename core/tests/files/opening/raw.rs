//! Raw frames: DNG files written here, and files of a real camera.

use super::{dng::Dng, dng::sensor_values, support::*};

/// Red 164, green 264 and 364, blue 564, in every square.
fn colours(u: usize, v: usize) -> u16 {
    [164, 264, 364, 564][u % 2 + v % 2 * 2]
}

#[test]
fn squares_are_binned_and_colours_are_kept_apart_and_without_colours_nothing_is_binned() {
    let (_folder, path) = folder_with("a.dng");
    fs::write(&path, Dng::new((8, 6), colours).bytes()).expect("written");
    let range = 1023.0 - 64.0;
    for (colour, expected) in [
        (RawColour::Luma, (100.0 + 200.0 + 300.0 + 500.0) / 4.0 / range),
        (RawColour::Green, 250.0 / range),
        (RawColour::Red, 100.0 / range),
        (RawColour::Blue, 500.0 / range),
    ] {
        let options = OpenOptions { raw_colour: colour, ..OpenOptions::default() };
        let burst = open_with(&path, &options).unwrap_or_else(|e| panic!("{colour:?}: {e}"));
        assert_eq!((burst.size(), burst.binning, burst.encoding), ((4, 3), 2, Encoding::Linear));
        assert_eq!(burst.full_scale, 1023.0);
        for value in burst.frames[0].data() {
            assert!((value - expected).abs() < 1e-6, "{colour:?}: {value} instead of {expected}");
        }
    }
    fs::write(&path, Dng { mosaic: None, ..Dng::new((5, 3), |u, v| 64 + (10 * v + u) as u16) }.bytes())
        .expect("written");
    let burst = Burst::open(&path).expect("opens");
    assert_eq!((burst.size(), burst.binning), ((5, 3), 1));
    assert!((burst.frames[0].at(4, 2) - 24.0 / 959.0).abs() < 1e-6);
}

#[test]
fn colours_columns_and_rows_have_black_levels_of_their_own_and_below_them_is_negative() {
    let (_folder, path) = folder_with("a.dng");
    let dng = Dng {
        black: [64, 70, 80, 100],
        ..Dng::new((4, 2), |u, v| if u < 2 { [54, 60, 70, 90][u % 2 + v * 2] } else { 1023 })
    };
    fs::write(&path, dng.bytes()).expect("written");
    let burst = Burst::open(&path).expect("opens");
    let dark = -10.0 * [64.0, 70.0, 80.0, 100.0].map(|black: f32| 1.0 / (1023.0 - black)).iter().sum::<f32>() / 4.0;
    assert!((burst.frames[0].at(0, 0) - dark).abs() < 1e-6, "{}", burst.frames[0].at(0, 0));
    assert!((burst.frames[0].at(1, 0) - 1.0).abs() < 1e-6);
    let own = OpenOptions { black_level: Some(0.0), full_scale: Some(2046.0), ..OpenOptions::default() };
    let burst = open_with(&path, &own).expect("opens");
    assert!((burst.frames[0].at(1, 0) - 0.5).abs() < 1e-6 && burst.full_scale == 2046.0);
    assert!(open_with(&path, &OpenOptions { black_level: Some(5000.0), ..OpenOptions::default() }).is_err());
    // One masked column at the left: the black steps are counted from the active area on.
    let (columns, rows) = (vec![0, 3, -2, 5], vec![-4, 1]);
    let value = |u: usize, v: usize| match u {
        0 => 64,
        _ => (64 + 500 + columns[u - 1] + rows[v]) as u16,
    };
    let dng = Dng { active: Some([0, 1, 2, 5]), ..Dng::new((5, 2), value) };
    let dng = Dng { black_steps: [columns.clone(), rows.clone()], mosaic: None, ..dng };
    fs::write(&path, dng.bytes()).expect("written");
    let burst = Burst::open(&path).expect("opens");
    for (v, row) in rows.iter().enumerate() {
        for (u, column) in columns.iter().enumerate() {
            let black = f32::from(64 + column + row);
            let expected = 500.0 / (1023.0 - black);
            assert!((burst.frames[0].at(u, v) - expected).abs() < 1e-6, "{u}, {v}");
        }
    }
    let own = OpenOptions { black_level: Some(0.0), ..OpenOptions::default() };
    let value = f32::from(64 + 500 + columns[1] + rows[0]) / 1023.0;
    assert!((open_with(&path, &own).expect("opens").frames[0].at(1, 0) - value).abs() < 1e-6);
    fs::write(&path, Dng { black_steps: [vec![1; 3], Vec::new()], ..dng }.bytes()).expect("written");
    says(Burst::open(&path).expect_err("a column has none"), &["black levels of columns and rows", "4×2"]);
}

#[test]
fn the_active_area_is_taken_wherever_it_begins_and_damaged_and_huge_files_are_errors() {
    let (_folder, path) = folder_with("a.dng");
    // Two masked rows above and three masked columns at the left: the mosaic begins after them.
    let masked = |u: usize, v: usize| if u < 3 || v < 2 { 64 } else { colours(u - 3, v - 2) };
    let dng = Dng { active: Some([2, 3, 8, 11]), ..Dng::new((12, 9), masked) };
    fs::write(&path, dng.bytes()).expect("written");
    let burst =
        open_with(&path, &OpenOptions { raw_colour: RawColour::Blue, ..OpenOptions::default() }).expect("opens");
    assert_eq!(burst.size(), (4, 3));
    assert!(burst.frames[0].data().iter().all(|v| (v - 500.0 / 959.0).abs() < 1e-6), "{:?}", burst.frames[0].data());
    // With a camera held upright, columns and rows are exchanged.
    fs::write(&path, Dng { orientation: 6, ..dng }.bytes()).expect("written");
    assert_eq!(Burst::open(&path).expect("opens").size(), (3, 4));
    let single = OpenOptions { mosaic: Some(Mosaic::None), ..OpenOptions::default() };
    assert_eq!(open_with(&path, &single).expect("opens").size(), (6, 8));
    let whole = Dng::new((16, 12), colours).bytes();
    let small = Limits { max_side_px: 8, ..Limits::default() };
    fs::write(&path, &whole).expect("written");
    let error = open_with(&path, &OpenOptions { limits: small, ..OpenOptions::default() }).expect_err("too large");
    assert_eq!(error.kind, ErrorKind::TooLarge, "{error}");
    for length in [0, 4, 9, 60, 200, 300, whole.len() - 30, whole.len() - 1] {
        fs::write(&path, &whole[..length]).expect("written");
        if let Err(error) = Burst::open(&path) {
            assert!(error.to_string().contains("a.dng"), "{error}");
        } else {
            assert_eq!(length, whole.len() - 1, "only the padding may be missing");
        }
    }
}

#[test]
fn a_folder_of_raw_frames_is_a_burst_with_bias_and_features() {
    let folder = folder();
    let params =
        ChartParams { width: 96, height: 72, discs: 4, frames: 5, snr: 6.0, seed: 3, ..ChartParams::default() };
    let params = ChartParams { radius: 3.0..=6.0, max_slope: 1.0, ..params };
    let (chart, _) = synth_chart(&params, &quiet()).expect("a chart");
    let night = folder.join("night");
    fs::create_dir(&night).expect("made");
    for (t, frame) in chart.frames.iter().enumerate() {
        let dng = Dng { white: 16_383, ..Dng::new((192, 144), sensor_values(frame, 64.0, 16_383.0)) };
        fs::write(night.join(format!("payload_N{t:03}.dng")), dng.bytes()).expect("written");
    }
    let burst = Burst::open(&night).expect("opens");
    assert_eq!((burst.len(), burst.size(), burst.binning), (5, (96, 72), 2));
    for (found, made) in burst.frames.iter().flat_map(|f| f.data()).zip(chart.frames.iter().flat_map(|f| f.data())) {
        assert!((found - made.max(-64.0 / 16_319.0)).abs() < 1.0 / 16_319.0, "{found} instead of {made}");
    }
    let search = DetectorParams { slopes: SlopeGrid::line(-1.0..=1.0, 5), ..DetectorParams::default() };
    let found = detect(&burst, &search, &quiet()).expect("searched");
    assert!(found.features.len() >= 3, "{} features", found.features.len());
    // A bias frame of the same camera; one of another kind is refused.
    let bias = folder.join("bias.dng");
    fs::write(&bias, Dng { white: 16_383, ..Dng::new((192, 144), |_, _| 164) }.bytes()).expect("written");
    let with = OpenOptions { bias: Some(bias.clone()), ..OpenOptions::default() };
    let less = open_with(&night, &with).expect("opens");
    let difference = burst.frames[0].at(9, 9) - less.frames[0].at(9, 9);
    assert!((difference - 100.0 / 16_319.0).abs() < 1e-6, "{difference}");
    let png = folder.join("bias.png");
    image::ImageBuffer::<image::Luma<u16>, _>::from_pixel(96, 72, image::Luma([100u16])).save(&png).expect("written");
    let error =
        open_with(&night, &OpenOptions { bias: Some(png), ..OpenOptions::default() }).expect_err("another kind");
    assert!(error.problem.contains("the bias frame does not fit"), "{error}");
}
