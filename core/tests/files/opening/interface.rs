//! Parts of the interface beside files: arrays in memory, positions, statements about files, and descriptions.

use super::support::*;

fn of_u16(values: &[u16]) -> Arrays {
    let frames = values.chunks(320).map(|frame| ArrayFrame::of_u16(20, 16, frame.iter().copied())).collect();
    Arrays { frames, ..Arrays::default() }
}

#[test]
fn an_array_gives_the_bits_of_its_file_and_floats_in_fractions_of_full_scale_are_not_copied() {
    let folder = folder();
    let path = |name: &str| folder.join(name);
    let values: Vec<u16> = (0..3 * 20 * 16).map(|k| ((k * 7919) % 4096) as u16).collect();
    let stack = Array3::from_shape_vec((3, 16, 20), values.clone()).expect("the shape");
    let bias = Array2::<u16>::from_elem((16, 20), 40);
    let flat = Array2::<u16>::from_shape_fn((16, 20), |(v, u)| (3000 + 10 * v + u) as u16);
    write_npy(path("frames.npy"), &stack).expect("written");
    write_npy(path("bias.npy"), &bias).expect("written");
    write_npy(path("flat.npy"), &flat).expect("written");
    let plain = OpenOptions { full_scale: Some(4095.0), ..OpenOptions::default() };
    let files = OpenOptions { bias: Some(path("bias.npy")), flat: Some(path("flat.npy")), ..plain.clone() };
    let one = |array: &Array2<u16>| vec![ArrayFrame::of_u16(20, 16, array.iter().copied())];
    let arrays = Arrays { bias: one(&bias), flat: one(&flat), ..of_u16(&values) };
    let monitor = Monitor::default();
    let opened = Burst::open_with(&[path("frames.npy")], &files, &monitor).expect("opened");
    let made = Burst::from_arrays("made", arrays, &plain, &monitor).expect("made");
    assert_eq!(made.frames, opened.frames);
    assert_eq!((made.full_scale, made.quantisation_step), (opened.full_scale, opened.quantisation_step));
    let suggested = Burst::from_arrays("made", of_u16(&values), &OpenOptions::default(), &monitor).expect("made");
    assert_eq!(suggested.suggested_full_scale, Some(4095.0));
    struct Owner(Vec<f32>);
    impl PixelOwner for Owner {
        fn pixels(&self) -> &[f32] {
            &self.0
        }
    }
    let owner: Arc<dyn PixelOwner> = Arc::new(Owner(vec![0.25; 320]));
    let frame = || ArrayFrame::Floats(Plane::from_shared(20, 16, owner.clone()));
    let arrays = Arrays { frames: vec![frame(), frame()], ..Arrays::default() };
    let burst = Burst::from_arrays("shared", arrays, &OpenOptions::default(), &quiet()).expect("made");
    assert!(burst.frames.iter().all(|plane| std::ptr::eq(plane.data(), owner.pixels())));
    let mut changed = Plane::clone(&burst.frames[0]);
    (changed.data_mut()[3], changed.row_mut(1)[0]) = (9.0, 7.0);
    assert_eq!((changed.at(3, 0), changed.at(0, 1), owner.pixels()[3]), (9.0, 7.0, 0.25), "copied before a change");
}

#[test]
fn frames_and_size_are_those_of_the_opened_burst_and_faults_name_the_array() {
    let home = folder();
    for t in 0..3 {
        let path = home.join(format!("{t}.png"));
        image::GrayImage::from_pixel(9, 7, image::Luma([9])).save(path).expect("written");
    }
    let of = |path: PathBuf| Info::of(&[path], &OpenOptions::default(), &quiet());
    let shape = |info: &Info| (info.frames, info.width, info.height);
    let whole = of(home.to_path_buf()).expect("described");
    assert_eq!((shape(&whole), whole.files, &*whole.kind, &*whole.samples), ((3, 9, 7), 3, "PNG", "8 bit"));
    assert!(whole.text().contains("3 frames of 9 × 7 in 3 files"), "{}", whole.text());
    assert_eq!(shape(&of(home.join("1.png")).expect("described")), (1, 9, 7));
    assert!(of(home.join("gone.png")).is_err());
    let plane = |width, value| ArrayFrame::Floats(Plane::from_vec(width, 16, vec![value; width * 16]));
    let error = |arrays| {
        let made = Burst::from_arrays("bad", arrays, &OpenOptions::default(), &quiet());
        made.expect_err("refused").to_string()
    };
    let with = |frames| Arrays { frames, ..Arrays::default() };
    assert!(error(with(vec![plane(20, 0.5), plane(20, f32::INFINITY)])).contains("frames"));
    let mask = |width| Arrays { mask: vec![plane(width, 1.0)], ..with(vec![plane(20, 0.5)]) };
    assert!(error(mask(21)).contains("this mask is 21×16, but the frames are 20×16"));
    assert!(error(with(vec![plane(20, 0.5), plane(21, 0.5)])).contains("frames (frame 1)"));
    assert!(error(Arrays { flat: vec![plane(20, 0.0)], ..with(vec![plane(20, 0.5)]) }).contains("flat"));
    assert!(error(Arrays::default()).contains("nothing to open"));
}

#[test]
fn times_and_rates_are_said_in_words() {
    let mut info = Info::of_burst(&Burst::from_planes("night", vec![Plane::zeros(2, 2)]), "made");
    assert!(info.text().contains("not in the file"));
    (info.times_s, info.begins) = (vec![0.0, 0.5, 1.5], Some("2021-03-01T22:00:00.000Z".to_owned()));
    says(
        info.text(),
        &["from 2021-03-01T22:00:00.000Z, 1.500 s in all, 0.750000 s between frames (0.500000 … 1.000000)"],
    );
    let text = |interval_s| Positions::even(3).with_interval(interval_s).rate_text();
    assert_eq!(text(Some(0.04)), Some("1 px/frame is 25.0 px/s".to_owned()));
    assert_eq!(text(Some(60.0)), Some("1 px/frame is 60.0 px/h".to_owned()));
    assert_eq!(text(None), None);
}

#[test]
fn views_are_about_their_mean_displaced_along_both_axes_and_refused_in_equal_places() {
    let grid = Positions::grid(3, 4);
    assert_eq!((grid.len(), grid.rows_and_columns(), grid.are_views()), (12, Some((3, 4)), true));
    assert_eq!((grid.offset(0), grid.offset(11)), (Offset { u: -1.5, v: -1.0 }, Offset { u: 1.5, v: 1.0 }));
    assert_eq!((grid.reach(), grid.span()), (1.5f64.hypot(1.0), 2.0 * 1.5f64.hypot(1.0)));
    assert_eq!(Positions::of_lists(12, &grid.list(), &grid.views()), Some(grid.clone()));
    assert!(!grid.is_even() && grid.unevenness().contains("3 rows and 4 columns"));
    assert_eq!(Positions::grid(1, 5), Positions::even(5));
    assert_eq!(grid.part(4..8), Positions::even(4));
    let column = Positions::grid(5, 1);
    assert_eq!((column.rows_and_columns(), column.span()), (Some((5, 1)), 4.0));
    assert_eq!(grid.of(&[0, 2, 5]).rows_and_columns(), None);
    let grid = Positions::grid(3, 3);
    assert_eq!(grid.displacement(0, (0.5, 0.0)), (-0.5, -0.5));
    assert_eq!(grid.displacement(2, (0.5, 0.0)), (0.5, -0.5));
    // A quarter turn of the grid.
    assert_eq!(grid.displacement(2, (0.0, 0.5)), (0.5, 0.5));
    assert_eq!(Offset::from(-2.0).displacement((0.3, -0.7)), (-2.0 * 0.3, -2.0 * -0.7));
    assert_eq!(grid.offset_from(0..3, 5), Offset { u: 1.0, v: 1.0 });
    assert!(Positions::of_views(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]).is_none());
    assert!(Positions::of_views(&[[0.0, 0.0], [f64::NAN, 1.0]]).is_none());
    assert!(Positions::of_views(&[[1.0, 0.0], [0.0, 0.0]]).is_none(), "a row goes to the right");
    assert!(Positions::of_views(&[[1.0, 0.0], [0.0, 2.5]]).is_some());
    assert!(Positions::of_lists(3, &[0.0, 1.0], &[]).is_none());
}

/// Frames of u16 with a few soft lamps under noise, as bytes.
fn dark(frames: u32, (width, height): (u32, u32)) -> Vec<u8> {
    let value = |t: u32, u: u32, v: u32| {
        let hash = (u + width * (v + height * t)).wrapping_mul(0x9E37_79B9) ^ 0x5bd1_e995;
        let noise = (hash.wrapping_mul(0x85eb_ca6b) >> 22) as f32 / 8.0;
        let light: f32 = [(60.0, 80.0), (200.0, 150.0), (260.0, 40.0)]
            .map(|(x, y): (f32, f32)| 90.0 * (-((u as f32 - x).powi(2) + (v as f32 - y).powi(2)) / 300.0).exp())
            .iter()
            .sum();
        (256.0 + noise + light) as u16
    };
    let frame = |t| (0..height).flat_map(move |v| (0..width).flat_map(move |u| value(t, u, v).to_le_bytes()));
    (0..frames).flat_map(frame).collect()
}

#[test]
fn the_right_shape_of_a_dark_dump_comes_first() {
    let (home, path) = folder_with("night.bin");
    fs::write(&path, dark(20, (320, 240))).expect("written");
    let shapes = likely_shapes(&path, &Limits::default(), &quiet()).expect("read");
    let names: Vec<String> = shapes.iter().map(|shape| format!("{} {}", shape.dump, shape.likeness)).collect();
    assert!(shapes.len() > 3 && names[0].starts_with("320x240:u16le"), "{names:?}");
    assert_eq!((shapes[0].frames, shapes[0].first.size()), (20, (320, 240)));
    // Three rows side by side are the rows of a picture too, which repeats.
    fs::write(&path, dark(9, (240, 180))).expect("written");
    let shapes = likely_shapes(&path, &Limits::default(), &quiet()).expect("read");
    let names: Vec<String> = shapes.iter().map(|shape| format!("{} {}", shape.dump, shape.likeness)).collect();
    assert!(names[0].starts_with("240x180:u16le") && names[1].starts_with("720x540:u16le"), "{names:?}");
    fs::write(&path, [7; 999]).expect("written");
    assert!(likely_shapes(&path, &Limits::default(), &quiet()).expect("read").is_empty());
    assert!(likely_shapes(home.join("none").as_path(), &Limits::default(), &quiet()).is_err());
}
