//! Bias frames, a given full scale, progress and cancellation.

use super::support::{assert_close, folder, grey8, save, tiff_pages};
use burstscope_core::Monitor;
use burstscope_core::burst::{Burst, OpenError, OpenOptions};
use ndarray::{Array2, Array3};
use ndarray_npy::write_npy;
use std::path::Path;
use std::sync::{Arc, Mutex};
use tiff::encoder::colortype;

fn open(path: &Path, options: &OpenOptions) -> Result<Burst, OpenError> {
    Burst::open_with(&[path.into()], options, &Monitor::default())
}

#[test]
fn a_bias_is_subtracted_in_file_units_and_negative_values_stay() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    tiff_pages::<colortype::Gray16>(&at("burst.tif"), (2, 1), &[vec![256, 250], vec![1256, 65535]]);
    let expected = [[0.0, -6.0 / 65535.0], [1000.0 / 65535.0, 65279.0 / 65535.0]];
    // One frame of 16 bit, a stack with the same mean, a mean of floats.
    tiff_pages::<colortype::Gray16>(&at("bias.tif"), (2, 1), &[vec![256, 256]]);
    tiff_pages::<colortype::Gray16>(&at("stack.tif"), (2, 1), &[vec![250, 256], vec![262, 256]]);
    write_npy(at("mean.npy"), &Array2::from_elem((1, 2), 256.0f32)).expect("written");
    for bias in ["bias.tif", "stack.tif", "mean.npy"] {
        let options = OpenOptions { bias: Some(at(bias)), ..OpenOptions::default() };
        let burst = open(&at("burst.tif"), &options).expect(bias);
        for (frame, expected) in burst.frames.iter().zip(expected) {
            for (found, expected) in frame.data().iter().zip(expected) {
                assert!((found - expected).abs() < 1e-7, "{bias}: {found} instead of {expected}");
            }
        }
        assert_eq!(burst.full_scale, 65535.0);
    }
}

#[test]
fn a_bias_of_float_files_is_in_their_unit() {
    let folder = folder();
    let (path, bias) = (folder.path().join("a.npy"), folder.path().join("bias.npy"));
    write_npy(&path, &Array3::from_shape_vec((1, 1, 2), vec![100.0f32, 500.0]).expect("two values")).expect("written");
    write_npy(&bias, &Array2::from_elem((1, 2), 100.0f32)).expect("written");
    let burst = open(&path, &OpenOptions { bias: Some(bias), ..OpenOptions::default() }).expect("opens");
    assert_eq!(burst.full_scale, 500.0);
    assert_close(burst.frames[0].data(), &[0.0, 0.8]);
}

#[test]
fn a_bias_must_fit_and_its_errors_name_it() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    save(&at("a.png"), &grey8(3, 2, 0));
    save(&at("bias.png"), &grey8(2, 3, 0));
    let options = |name: &str| OpenOptions { bias: Some(at(name)), ..OpenOptions::default() };
    let error = open(&at("a.png"), &options("bias.png")).expect_err("another size");
    assert!(
        matches!(error, OpenError::CalibrationSize { kind: "bias", size: (2, 3), frame_size: (3, 2), .. }),
        "{error}"
    );
    assert!(error.to_string().contains("bias.png"), "{error}");
    let error = open(&at("a.png"), &options("missing.png")).expect_err("missing");
    assert!(matches!(error, OpenError::NotFound { ref path } if path.ends_with("missing.png")), "{error}");
}

#[test]
fn a_full_scale_of_ones_own() {
    let folder = folder();
    let path = folder.path().join("twelve_bit.tif");
    tiff_pages::<colortype::Gray16>(&path, (2, 1), &[vec![0, 4095]]);
    let burst = open(&path, &OpenOptions { full_scale: Some(4095.0), ..OpenOptions::default() }).expect("opens");
    assert_close(burst.frames[0].data(), &[0.0, 1.0]);
    assert_eq!((burst.full_scale, burst.quantisation_step), (4095.0, 1.0 / 4095.0));
    for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = open(&path, &OpenOptions { full_scale: Some(value), ..OpenOptions::default() });
        assert!(matches!(error, Err(OpenError::FullScale { .. })), "{value}");
    }
}

#[test]
fn no_option_makes_values_that_are_not_finite() {
    let folder = folder();
    let (path, bias) = (folder.path().join("a.npy"), folder.path().join("bias.npy"));
    write_npy(&path, &Array3::from_shape_vec((1, 1, 2), vec![-1e38f32, -3e38]).expect("two values")).expect("written");
    write_npy(&bias, &Array2::from_elem((1, 2), 3e38f32)).expect("written");
    let located = |options: OpenOptions, column: usize| {
        let error = open(&path, &options).expect_err("beyond the range of 32-bit float");
        assert!(matches!(error, OpenError::NotFinite { u, v: 0, .. } if u == column), "{error}");
    };
    located(OpenOptions { full_scale: Some(0.5), ..OpenOptions::default() }, 1);
    located(OpenOptions { full_scale: Some(1.0), bias: Some(bias), ..OpenOptions::default() }, 0);
}

#[test]
fn progress_counts_frames() {
    let folder = folder();
    for t in 0..8 {
        save(&folder.path().join(format!("{t}.png")), &grey8(3, 2, t));
    }
    let heard = Arc::new(Mutex::new(Vec::new()));
    let sink = heard.clone();
    let monitor = Monitor::with_listener(move |p| sink.lock().expect("not poisoned").push(p.fraction));
    Burst::open_with(&[folder.path().into()], &OpenOptions::default(), &monitor).expect("opens");
    let mut heard = heard.lock().expect("not poisoned").clone();
    heard.sort_by(f32::total_cmp); // threads may report in any order
    let expected: Vec<f32> = (0..=8).map(|n| n as f32 / 8.0).collect();
    assert_eq!(heard, expected);
}

#[test]
fn cancelling_stops_between_frames_of_folders_and_of_stacks() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("frames")).expect("made");
    for t in 0..100 {
        save(&folder.path().join(format!("frames/{t}.png")), &grey8(3, 2, t));
    }
    tiff_pages::<colortype::Gray8>(&folder.path().join("a.tif"), (3, 2), &vec![vec![0; 6]; 100]);
    write_npy(folder.path().join("a.npy"), &Array3::<u8>::zeros((100, 2, 3))).expect("written");
    for name in ["frames", "a.tif", "a.npy"] {
        let handle: Arc<Mutex<Option<Monitor>>> = Arc::default();
        let frames = Arc::new(Mutex::new(0));
        let (inner, count) = (handle.clone(), frames.clone());
        let monitor = Monitor::with_listener(move |p| {
            if p.fraction > 0.0 {
                *count.lock().expect("not poisoned") += 1;
                inner.lock().expect("not poisoned").as_ref().expect("set").cancel();
            }
        });
        *handle.lock().expect("not poisoned") = Some(monitor.clone());
        let answer = Burst::open_with(&[folder.path().join(name)], &OpenOptions::default(), &monitor);
        assert!(answer.as_ref().is_err_and(OpenError::is_cancelled), "{name}: {answer:?}");
        // Each thread may have been reading one frame.
        let frames = *frames.lock().expect("not poisoned");
        assert!(frames <= 2 * rayon::current_num_threads() + 1, "{name}: {frames} frames after the cancel");
    }
}
