//! Scales and motions of a burst's features, stored beside its record: what matching needs beyond COLMAP's files.
//!
//! `records/NAME.png.blobs` holds a first line that names the format, and for each feature in order four `f32`, little
//! end first: scale σ, motion (u, v) and the motion's standard deviation, infinite where unknown.

use crate::detector::Slope;
use crate::matching::Blob;

const FIRST_LINE: &[u8] = b"burstscope blobs 1\n";
const NUMBERS: usize = 4;

/// The content of the file.
pub(super) fn to_bytes(blobs: &[Blob]) -> Vec<u8> {
    let numbers = |blob: &Blob| [blob.sigma, blob.motion.u, blob.motion.v, blob.motion_sigma];
    let values = blobs.iter().flat_map(numbers).flat_map(f32::to_le_bytes);
    FIRST_LINE.iter().copied().chain(values).collect()
}

/// The blobs of such a file; `None` for anything else.
pub(super) fn from_bytes(bytes: &[u8]) -> Option<Vec<Blob>> {
    let (numbers, rest) = bytes.strip_prefix(FIRST_LINE)?.as_chunks::<4>();
    let numbers: Vec<f32> = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let (blobs, more) = numbers.as_chunks::<NUMBERS>();
    let blob = |&[sigma, u, v, motion_sigma]: &[f32; NUMBERS]| {
        let is_blob = sigma > 0.0 && sigma.is_finite() && motion_sigma >= 0.0 && u.is_finite() && v.is_finite();
        is_blob.then_some(Blob { sigma, motion: Slope::new(u, v), motion_sigma })
    };
    if rest.is_empty() && more.is_empty() { blobs.iter().map(blob).collect() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn blobs_survive_a_file_and_others_are_none() {
        let blob = |sigma, motion_sigma| Blob { sigma, motion: Slope::new(-1.5, 0.25), motion_sigma };
        let blobs = [blob(2.5, 0.1), blob(7.0, f32::INFINITY)];
        let bytes = to_bytes(&blobs);
        assert_eq!(from_bytes(&bytes), Some(blobs.to_vec()));
        assert_eq!(from_bytes(&to_bytes(&[])), Some(Vec::new()));
        assert_eq!(from_bytes(&bytes[..bytes.len() - 1]), None);
        assert_eq!(from_bytes(&bytes[1..]), None);
        assert_eq!(from_bytes(&to_bytes(&[blob(f32::NAN, 0.1)])), None);
        assert_eq!(from_bytes(&to_bytes(&[blob(1.0, -0.1)])), None);
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            let with_line = [FIRST_LINE, &bytes].concat();
            for bytes in [bytes, with_line] {
                prop_assert!(from_bytes(&bytes).is_none_or(|blobs| to_bytes(&blobs) == bytes));
            }
        }
    }
}
