//! Memory budget of a search: fewer threads where that fits, and a refusal before reading where nothing does.

use crate::support::*;

/// Writes a `.npy` stack of frames of `size` (columns, rows) that cannot be opened: its first value is infinite.
fn write_infinite_stack(path: &Path, frames: usize, (width, height): (usize, usize)) {
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({frames}, {height}, {width}), }}");
    let header = format!("{header:117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(f32::INFINITY.to_le_bytes());
    fs::write(path, &bytes).expect("written");
    let file = fs::OpenOptions::new().write(true).open(path).expect("there");
    file.set_len((10 + header.len() + 4 * frames * width * height) as u64).expect("sparse");
}

#[test]
fn a_small_budget_is_kept_with_the_same_features_or_refused_before_a_pixel_is_read() {
    let home = folder();
    home.run_well("synth chart --out a --quiet");
    let detect = |out: &str, more: &[&str]| {
        let search = ["detect", "a", "--slopes-u", "-1:1:5", "--out", out];
        home.run_well(&[&search[..], more].concat());
        fs::read_to_string(home.join(out).join("a.csv")).expect("features")
    };
    let whole = detect("whole", &[]);
    // Frames and three slopes take about 47 MB, and each thread's window of slopes 6 MB.
    assert_eq!(detect("seven", &["--threads", "7", "--memory", "60M"]), whole);
    assert_eq!(detect("one", &["--threads", "1", "--memory", "60M"]), whole);
    assert!(whole.lines().count() > 1);
    let home = folder();
    write_infinite_stack(&home.join("large.npy"), 10, (2000, 1000));
    let found = ["detect", "large.npy", "--out", "found"];
    let opened = home.run_badly(&found, 1);
    assert!(opened.contains("large.npy") && !opened.contains("--memory"), "{opened}");
    for (search, code) in [(&found[..], 1), (&["probe", "large.npy", "--at", "9,9"], 2), (&["slopes", "large.npy"], 2)]
    {
        for slopes in [&[][..], &["--slopes-u", "-1:1:3"]] {
            let words = home.run_badly(&[search, slopes, &["--memory", "50M"]].concat(), code);
            assert!(words.contains("--memory") && words.contains("10 frames of 2000×1000"), "{words}");
        }
    }
}
