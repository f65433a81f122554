//! Options of opening: bias and flat frames of every kind of file, a given black level and full scale, masks; progress
//! and cancellation.

use super::support::*;
use burstscope_core::export::write_tiff;
use std::sync::Mutex;

fn with_bias(bias: PathBuf) -> OpenOptions {
    OpenOptions { bias: Some(bias), ..OpenOptions::default() }
}

fn with_scale(full_scale: f32) -> OpenOptions {
    OpenOptions { full_scale: Some(full_scale), ..OpenOptions::default() }
}

fn with_mask(mask: PathBuf) -> OpenOptions {
    OpenOptions { mask: Some(mask), ..OpenOptions::default() }
}

fn deep(path: &Path, size: (u32, u32), frames: &[Vec<u16>]) {
    tiff_pages::<colortype::Gray16>(path, size, frames);
}

#[track_caller]
fn assert_near(found: &[f32], expected: &[f32], what: &str) {
    let is_near = |(found, expected): (&f32, &f32)| (found - expected).abs() < 1e-7;
    assert!(found.len() == expected.len() && found.iter().zip(expected).all(is_near), "{what}: {found:?}");
}

#[test]
fn a_bias_of_any_kind_of_file_is_subtracted_in_file_units_and_negative_values_stay() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    deep(&at("burst.tif"), (2, 1), &[vec![256, 250], vec![1256, 65535]]);
    // One frame of 16 bit, a stack with the same mean, a mean of floats.
    deep(&at("bias.tif"), (2, 1), &[vec![256, 256]]);
    deep(&at("stack.tif"), (2, 1), &[vec![250, 256], vec![262, 256]]);
    write_npy(at("mean.npy"), &Array2::from_elem((1, 2), 256.0f32)).expect("written");
    for bias in ["bias.tif", "stack.tif", "mean.npy"] {
        let burst = open_with(&at("burst.tif"), &with_bias(at(bias))).expect(bias);
        assert_near(burst.frames[0].data(), &[0.0, -6.0 / 65535.0], bias);
        assert_near(burst.frames[1].data(), &[1000.0 / 65535.0, 65279.0 / 65535.0], bias);
        assert_eq!((burst.len(), burst.full_scale), (2, 65535.0));
    }
    write_npy(at("a.npy"), &ndarray::array![[[100.0f32, 500.0]]]).expect("written");
    write_npy(at("bias.npy"), &Array2::from_elem((1, 2), 100.0f32)).expect("written");
    let burst = open_with(&at("a.npy"), &with_bias(at("bias.npy"))).expect("opens");
    assert_eq!(burst.full_scale, 500.0);
    assert_close(burst.frames[0].data(), &[0.0, 0.8]);
    let burst = at("burst.tif");
    deep(&burst, (2, 2), &[vec![2570, 3570, 30_000, 65_535]]);
    let expected: Vec<f32> = [0.0, 1000.0, 27_430.0, 62_965.0].map(|v| v / 65_535.0).to_vec();
    // The same bias as 16 bit, as a fraction of full scale (as `stack` writes it), as a mean, and as 8 bit.
    deep(&at("bias16.tif"), (2, 2), &[vec![2570; 4]]);
    write_tiff(&at("fraction.tif"), &Plane::from_fn(2, 2, |_, _| 2570.0 / 65_535.0)).expect("written");
    write_npy(at("mean.npy"), &Array2::from_elem((2, 2), 2570.0f64)).expect("written");
    tiff_pages::<colortype::Gray8>(&at("bias8.tif"), (2, 2), &[vec![10; 4]]);
    for name in ["bias16.tif", "fraction.tif", "mean.npy", "bias8.tif"] {
        let found = open_with(&burst, &with_bias(at(name))).expect(name);
        for (found, expected) in found.frames[0].data().iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-6, "{name}: {found} instead of {expected}");
        }
    }
    let options = OpenOptions { full_scale: Some(4095.0), ..with_bias(at("fraction.tif")) };
    let found = open_with(&burst, &options).expect("opens").frames[0].at(0, 0);
    assert!((found - (2570.0 / 4095.0 - 2570.0 / 65_535.0)).abs() < 1e-6, "{found}");
}

#[test]
fn a_bias_must_fit_and_have_a_known_unit_and_its_errors_name_it() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    save(&at("a.png"), &grey8(3, 2, 0));
    save(&at("bias.png"), &grey8(2, 3, 0));
    let error = open_with(&at("a.png"), &with_bias(at("bias.png"))).expect_err("another size");
    assert!(error.problem == "the bias frame is 2×3, but the frames are 3×2", "{error}");
    assert!(error.to_string().contains("bias.png"), "{error}");
    let error = open_with(&at("a.png"), &with_bias(at("missing.png"))).expect_err("missing");
    assert!(error.kind == ErrorKind::NotFound && error.subject.ends_with("missing.png"), "{error}");
    let at = |name: &str| folder.join(name);
    let (sixteen, fractions) = (at("burst.tif"), at("burst.npy"));
    deep(&sixteen, (2, 1), &[vec![256, 900]]);
    write_npy(&fractions, &Array2::from_elem((1, 2), 0.25f32)).expect("written");
    write_npy(at("huge.npy"), &Array2::from_elem((1, 2), 1e6f32)).expect("written");
    write_npy(at("values.npy"), &Array2::from_elem((1, 2), 256.0f32)).expect("written");
    tiff_pages::<colortype::Gray8>(&at("bias8.tif"), (2, 1), &[vec![1, 1]]);
    // As a fraction of its range it would be brighter than the maximum.
    tiff_pages::<colortype::Gray8>(&at("bright.tif"), (2, 1), &[vec![40, 40]]);
    let own_scale = OpenOptions { full_scale: Some(4095.0), ..with_bias(at("bias8.tif")) };
    for (burst, options) in [
        (&sixteen, with_bias(at("huge.npy"))),
        (&fractions, with_bias(at("values.npy"))),
        (&sixteen, own_scale),
        (&sixteen, with_bias(at("bright.tif"))),
    ] {
        let error = open_with(burst, &options).expect_err("no unit in common");
        assert!(error.problem.contains("the bias frame does not fit"), "{error}");
        says(error, &[&options.bias.expect("given").display().to_string()]);
    }
}

fn seen(burst: &Burst) -> Vec<Vec<bool>> {
    let of = |frame: &Plane, i: usize| frame.weight_at(i % frame.width(), i / frame.width()) > 0.5;
    burst.frames.iter().map(|frame| (0..frame.data().len()).map(|i| of(frame, i)).collect()).collect()
}

#[test]
fn converters_are_suggested_by_what_the_values_need_and_no_option_makes_values_that_are_not_finite() {
    let folder = folder();
    for (values, expected) in [
        (&[0, 1001][..], Some(1023.0)),
        (&[0, 1024, 3], Some(4095.0)),
        (&[7, 16383], Some(16383.0)),
        (&[7, 16384], None),
        // Twelve bits at the top of the word: all values are multiples of 16.
        (&[0, 16, 1600], None),
        (&[0, 0], None),
    ] {
        let path = folder.join("a.tif");
        let size = (values.len() as u32, 1);
        let bright = values.iter().map(|value| value * 2 + 1).collect();
        deep(&path, size, &[values.to_vec()]);
        assert_eq!(Burst::open(&path).expect("opens").suggested_full_scale, expected, "{values:?}");
        // One bright frame among dark ones is enough.
        deep(&path, size, &[values.to_vec(), vec![40_001; values.len()], bright]);
        assert_eq!(Burst::open(&path).expect("opens").suggested_full_scale, None, "{values:?}");
    }
    let (path, bias) = (folder.join("a.npy"), folder.join("bias.npy"));
    write_npy(&path, &ndarray::array![[[-1e38f32, -3e38, 1e38]]]).expect("written");
    write_npy(&bias, &Array2::from_elem((1, 3), 3e38f32)).expect("written");
    for (options, column) in [(with_scale(0.5), 1), (OpenOptions { full_scale: Some(1.0), ..with_bias(bias) }, 0)] {
        let error = open_with(&path, &options).expect_err("beyond the range of 32-bit float");
        assert!(error.problem.contains(&format!("at pixel ({column}, 0)")), "{error}");
    }
}

#[test]
fn a_mask_is_one_for_all_frames_or_one_for_each() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    ["night", "masks/night", "flat masks", "own"].iter().for_each(|name| fs::create_dir_all(at(name)).expect("made"));
    for t in 0..3 {
        save(&at(&format!("night/{t}.png")), &grey8(3, 2, 40 * t));
        let one = image::GrayImage::from_fn(3, 2, |u, _| image::Luma([if u == u32::from(t) { 0 } else { 255 }]));
        ["masks/night/", "flat masks/"].into_iter().for_each(|name| save(&at(&format!("{name}{t}.png.png")), &one));
        save(&at(&format!("own/{t}.png")), &one);
    }
    write_npy(at("stack.npy"), &Array3::from_shape_fn((3, 2, 3), |(t, _, u)| u8::from(u != t))).expect("written");
    save(&at("half.png"), &image::GrayImage::from_fn(3, 2, |u, _| image::Luma([[0u8, 127, 128][u as usize]])));
    save(&at("white.png"), &image::GrayImage::from_pixel(3, 2, image::Luma([255])));
    let with = |mask: &str| open_with(&at("night"), &with_mask(at(mask)));
    let each: Vec<Vec<bool>> = (0..3).map(|t| (0..6).map(|i| i % 3 != t).collect()).collect();
    for mask in ["masks", "flat masks", "own", "stack.npy"] {
        assert_eq!(seen(&with(mask).expect(mask)), each, "{mask}");
    }
    let half = with("half.png").expect("opens");
    assert_eq!(seen(&half), vec![vec![false, true, true, false, true, true]; 3]);
    assert!(half.taken.contains(&"33.3 % of the pixels are masked by half.png".to_owned()), "{:?}", half.taken);
    assert_eq!(with("white.png").expect("opens").frames, Burst::open(at("night")).expect("opens").frames);
}

#[test]
fn a_mask_hides_0_alone_and_greys_and_labels_are_told() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    fs::create_dir(at("night")).expect("made");
    (0..2).for_each(|t| save(&at(&format!("night/{t}.png")), &grey8(40, 2, 40 * t)));
    let opened = |name: &str| {
        let burst = open_with(&at("night"), &with_mask(at(name))).expect(name);
        let hidden = seen(&burst)[0].iter().filter(|seen| !**seen).count();
        (hidden, burst.taken.iter().filter(|note| note.contains("0 alone is hidden")).cloned().collect::<Vec<_>>())
    };
    let of = |name: &str, value: fn(u32) -> u8| {
        save(&at(name), &image::GrayImage::from_fn(40, 2, |u, _| image::Luma([value(u)])));
        opened(name)
    };
    // Two values, of which one is 0, and one value: nothing to say.
    for (name, value, hidden) in [
        ("white.png", (|u| if u < 8 { 0 } else { 255 }) as fn(u32) -> u8, 16),
        ("one.png", |u| u8::from(u >= 8), 16),
        ("dark.png", |u| if u < 8 { 0 } else { 60 }, 16),
        ("bright.png", |_| 200, 0),
    ] {
        assert_eq!(of(name, value), (hidden, vec![]), "{name}");
    }
    for (name, value, hidden, says) in [
        ("labels.png", (|u| [0, 1, 3][u as usize % 3]) as fn(u32) -> u8, 28, "has the values 0, 1, 3"),
        ("grey.png", |u| [0, 60, 255][u as usize / 14], 28, "35.0 % of it"),
        ("none.png", |u| if u < 8 { 60 } else { 255 }, 0, "has the values 60, 255"),
        ("soft.png", |u| (u * 6) as u8, 2, "is grey, of more than 8 values"),
    ] {
        let (found, notes) = of(name, value);
        assert_eq!(found, hidden, "{name}");
        assert!(notes.len() == 1 && notes[0].contains(says) && notes[0].contains(name), "{notes:?}");
    }
    let soft = Array3::from_shape_fn((1, 2, 40), |(_, _, u)| if u < 8 { 0.0f32 } else { 0.2 + 0.02 * u as f32 });
    write_npy(at("soft.npy"), &soft).expect("written");
    assert_eq!((opened("soft.npy").0, opened("soft.npy").1.len()), (16, 1));
    fs::create_dir(at("masks")).expect("made");
    for t in 0..2 {
        fs::copy(at("labels.png"), at(&format!("masks/{t}.png"))).expect("copied");
    }
    assert_eq!((opened("masks").0, opened("masks").1.len()), (28, 1));
}

#[test]
fn a_bad_mask_is_an_error_with_its_name() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    ["night", "few", "empty"].into_iter().for_each(|name| fs::create_dir(at(name)).expect("made"));
    (0..3).for_each(|t| save(&at(&format!("night/{t}.png")), &grey8(3, 2, 40 * t)));
    save(&at("few/0.png.png"), &grey8(3, 2, 255));
    save(&at("wide.png"), &grey8(4, 2, 255));
    save(&at("black.png"), &image::GrayImage::new(3, 2));
    fs::write(at("text.png"), "no picture").expect("written");
    write_npy(at("two.npy"), &Array3::<u8>::ones((2, 2, 3))).expect("written");
    for (mask, words) in [
        ("wide.png", ["wide.png", "4×2", "3×2"]),
        ("text.png", ["text.png", "", ""]),
        ("gone.png", ["gone.png", "no such file", ""]),
        ("two.npy", ["two.npy", "2 masks", "3 frames"]),
        ("few", ["few", "1.png", "1.png.png"]),
        ("empty", ["empty", "0.png", "no mask"]),
        ("black.png", ["0.png", "every pixel of frame 0 is masked", ""]),
    ] {
        says(open_with(&at("night"), &with_mask(at(mask))).expect_err(mask), &words);
    }
}

#[test]
fn pixels_without_a_value_and_saturated_ones_are_masked() {
    let folder = folder();
    let (path, flat) = (folder.join("a.npy"), folder.join("flat.npy"));
    let mut stack = Array3::from_elem((2, 3, 4), 0.25f32);
    (stack[[0, 1, 2]], stack[[1, 0, 0]]) = (f32::NAN, 1.0);
    write_npy(&path, &stack).expect("written");
    let plain = Burst::open(&path).expect("opens");
    assert_eq!((seen(&plain)[0].iter().position(|seen| !seen), plain.frames[1].mask()), (Some(6), None));
    assert!(plain.frames[0].data().iter().all(|x| *x == 0.25), "filled from its surroundings");
    assert_eq!(plain.taken, ["pixels without a value (NaN) are masked: 1 in 1 of 2 frames"]);
    let saturated = open_with(&path, &OpenOptions { mask_saturated: true, ..OpenOptions::default() }).expect("opens");
    assert_eq!(seen(&saturated)[1].iter().position(|seen| !seen), Some(0));
    assert_eq!(saturated.taken[1], "saturated pixels are masked: 1 in 1 of 2 frames");
    // A pixel that the flat frame has no value for, and a full scale below that of the files.
    let mut of_flat = Array2::from_elem((3, 4), 0.5f32);
    of_flat[[2, 3]] = f32::NAN;
    write_npy(&flat, &of_flat).expect("written");
    let flattened = open_with(&path, &OpenOptions { flat: Some(flat), ..OpenOptions::default() }).expect("opens");
    assert_eq!(seen(&flattened)[1].iter().position(|seen| !seen), Some(11));
    tiff_pages::<colortype::Gray16>(&folder.join("a.tif"), (3, 1), &[vec![4094, 4095, 7]]);
    let options = OpenOptions { mask_saturated: true, full_scale: Some(4095.0), ..OpenOptions::default() };
    assert_eq!(seen(&open_with(&folder.join("a.tif"), &options).expect("opens")), [[true, false, true]]);
    // A frame of which nothing is left.
    stack.index_axis_mut(ndarray::Axis(0), 1).fill(f32::NAN);
    write_npy(&path, &stack).expect("written");
    says(Burst::open(&path).expect_err("nothing is seen"), &["no pixel of frame 1 has a value", "a.npy"]);
}

#[test]
fn progress_counts_frames_and_cancelling_stops_between_them() {
    let folder = folder();
    (0..8).for_each(|t| save(&folder.join(format!("{t}.png")), &grey8(3, 2, t)));
    let heard = Arc::new(Mutex::new(Vec::new()));
    let sink = heard.clone();
    let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
    Burst::open_with(&[folder.to_path_buf()], &OpenOptions::default(), &monitor).expect("opens");
    let mut heard = heard.lock().expect("not poisoned").clone();
    heard.sort_by(f32::total_cmp); // threads may report in any order
    let expected: Vec<f32> = (0..=8).map(|n| n as f32 / 8.0).collect();
    assert_eq!(heard, expected);
    fs::create_dir(folder.join("frames")).expect("made");
    (0..100).for_each(|t| save(&folder.join(format!("frames/{t}.png")), &grey8(3, 2, t)));
    tiff_pages::<colortype::Gray8>(&folder.join("a.tif"), (3, 2), &vec![vec![0; 6]; 100]);
    write_npy(folder.join("a.npy"), &Array3::<u8>::zeros((100, 2, 3))).expect("written");
    for name in ["frames", "a.tif", "a.npy"] {
        let handle: Arc<Mutex<(Option<Monitor>, usize)>> = Arc::default();
        let inner = handle.clone();
        let monitor = Monitor::with_listener(move |p| {
            if p.fraction > 0.0 {
                let mut inner = inner.lock().expect("not poisoned");
                inner.1 += 1;
                inner.0.as_ref().expect("set").cancel();
            }
        });
        handle.lock().expect("not poisoned").0 = Some(monitor.clone());
        let answer = Burst::open_with(&[folder.join(name)], &OpenOptions::default(), &monitor);
        assert!(answer.as_ref().is_err_and(Error::is_cancelled), "{name}: {answer:?}");
        // Each thread may have been reading one frame.
        let frames = handle.lock().expect("not poisoned").1;
        assert!(frames <= 2 * rayon::current_num_threads() + 1, "{name}: {frames} frames after the cancel");
    }
}

#[test]
fn a_flat_frame_takes_off_falling_light() {
    let folder = folder();
    let at = |name: &str| folder.join(name);
    // An even scene of 0.5 behind a lens that lets half through at the right, on a bias of 1000.
    let light = [20_000u16, 20_000, 10_000, 10_000];
    deep(&at("burst.tif"), (4, 1), &[light.map(|v| v + 1000).to_vec()]);
    deep(&at("flat.tif"), (4, 1), &[light.map(|v| 2 * v + 1000).to_vec()]);
    deep(&at("bias.tif"), (4, 1), &[vec![1000; 4]]);
    let options = OpenOptions { flat: Some(at("flat.tif")), ..with_bias(at("bias.tif")) };
    let expected = [15_000.0 / 65_535.0; 4];
    assert_close(open_with(&at("burst.tif"), &options).expect("opens").frames[0].data(), &expected);
    // A black level is equivalent to an even bias.
    let black = OpenOptions { flat: Some(at("flat.tif")), black_level: Some(1000.0), ..OpenOptions::default() };
    let found = open_with(&at("burst.tif"), &black).expect("opens");
    assert_close(found.frames[0].data(), &[15_000.0 / 64_535.0; 4]);
    deep(&at("small.tif"), (2, 1), &[vec![1, 1]]);
    for (name, words) in [("small.tif", "the flat frame is"), ("bias.tif", "the flat frame does not fit")] {
        let wrong = OpenOptions { flat: Some(at(name)), ..options.clone() };
        says(open_with(&at("burst.tif"), &wrong).expect_err(name).problem, &[words]);
    }
}

#[test]
fn a_black_level_and_a_full_scale_of_ones_own() {
    let (_folder, path) = folder_with("twelve_bit.tif");
    deep(&path, (3, 1), &[vec![255, 4095, 155]]);
    let plain = Burst::open(&path).expect("opens");
    assert_eq!(plain.suggested_full_scale, Some(4095.0));
    assert_eq!(
        plain.notes()[0].for_command(),
        "no value of these 16-bit files is above 4095, as of a camera of 12 bits; --full-scale 4095 changes that"
    );
    let options = OpenOptions { full_scale: Some(4095.0), black_level: Some(255.0), ..OpenOptions::default() };
    let burst = open_with(&path, &options).expect("opens");
    // Values below black stay negative.
    assert_near(burst.frames[0].data(), &[0.0, 1.0, -100.0 / 3840.0], "");
    assert_eq!((burst.full_scale, burst.quantisation_step, burst.suggested_full_scale), (4095.0, 1.0 / 3840.0, None));
    assert_eq!(open_with(&path, &with_scale(4095.0)).expect("opens").quantisation_step, 1.0 / 4095.0);
    for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = open_with(&path, &with_scale(value));
        assert!(error.is_err_and(|error| error.problem.contains("full scale")), "{value}");
    }
    for black in [4095.0, 5000.0, f32::NAN] {
        let error = open_with(&path, &OpenOptions { black_level: Some(black), ..options.clone() });
        assert!(error.is_err_and(|error| error.problem.contains("black level")), "{black}");
    }
}
