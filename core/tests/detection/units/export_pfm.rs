//! Tests of `export::pfm`.

use burstscope_core::detector::*;
use burstscope_core::detector::{Motion, Slope};
use burstscope_core::export::write_field_tiff;
use burstscope_core::export::*;

#[test]
fn a_field_is_read_back_from_pfm_and_tiff_with_its_motions_in_their_places() {
    let motion = |u: f32, v: f32, uu: f32| Motion { slope: Slope::new(u, v), covariance: [uu, 0.0, 0.01] };
    let field = MotionField {
        size: (2, 2),
        cell_px: 8,
        motions: vec![motion(1.5, -2.0, 0.04), motion(0.0, 3.0, 0.25), motion(-1.0, 0.5, 4.0), motion(2.0, 0.0, 0.01)],
        unknown_sigma: 1.0,
        layers: Vec::new(),
        layer: vec![0; 4],
    };
    // The last cells are cut by the border.
    let size = (15, 11);
    let folder = tempfile::tempdir().expect("a folder");
    let (pfm, tiff) = (folder.path().join("field.pfm"), folder.path().join("field.tiff"));
    write_field_pfm(&pfm, &field, size).expect("written");
    write_field_tiff(&tiff, &field, size).expect("written");
    let bytes = std::fs::read(&pfm).expect("read");
    let samples = bytes.strip_prefix(b"PF\n15 11\n-1.0\n").expect("the header of three lines");
    let read: Vec<f32> = samples.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(read.len(), 3 * 15 * 11, "and nothing after the samples");
    for (row, column) in [(0, 0), (0, 14), (10, 3), (7, 8), (8, 7)] {
        let there = field.at(column as f32, row as f32);
        let start = 3 * ((10 - row) * 15 + column);
        let wanted = [there.slope.u, there.slope.v, there.ellipse().0[0]];
        assert_eq!(read[start..start + 3], wanted, "row {row}, column {column}");
    }
    let mut decoder = tiff::decoder::Decoder::new(std::fs::File::open(&tiff).expect("opens")).expect("a TIFF");
    let tiff::decoder::DecodingResult::F32(page) = decoder.read_image().expect("an image") else { panic!("no f32") };
    let upside_down: Vec<f32> = read.chunks(3 * 15).rev().flatten().copied().collect();
    assert_eq!(page, upside_down, "the same samples, the first row first");
}
