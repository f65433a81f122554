//! Shapes and motions of a burst's features, stored in its record: what matching needs beyond COLMAP's files.
//!
//! One text of hexadecimal digits: a checksum, and for each feature in order seven `f32`, little end first: scale σ,
//! orientation, slope (u, v), motion of its place (u, v) and standard deviation of that motion, infinite where unknown.

use crate::{detector::Slope, matching::Blob};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use std::fmt::Write;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct StoredBlobs(pub Vec<Blob>);

const NUMBERS: usize = 7;

impl StoredBlobs {
    fn text(&self) -> String {
        let numbers = |&Blob { sigma, orientation, slope, motion, motion_sigma }: &Blob| {
            [sigma, orientation, slope.u, slope.v, motion.u, motion.v, motion_sigma]
        };
        let bytes: Vec<u8> = self.0.iter().flat_map(numbers).flat_map(f32::to_le_bytes).collect();
        let mut text = format!("{:08x}", crc32fast::hash(&bytes));
        bytes.iter().for_each(|byte| write!(text, "{byte:02x}").unwrap_or_default());
        text
    }

    fn from_text(text: &str) -> Option<Self> {
        let (digits, rest) = text.as_bytes().as_chunks::<2>();
        let byte = |[high, low]: &[u8; 2]| {
            let digit = |digit: &u8| char::from(*digit).to_digit(16);
            u8::try_from(16 * digit(high)? + digit(low)?).ok()
        };
        let bytes: Vec<u8> = digits.iter().map(byte).collect::<Option<_>>()?;
        let (checksum, bytes) = bytes.split_first_chunk::<4>()?;
        let (numbers, odd) = bytes.as_chunks::<4>();
        let numbers: Vec<f32> = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let (blobs, more) = numbers.as_chunks::<NUMBERS>();
        let is_whole = rest.is_empty() && odd.is_empty() && more.is_empty();
        let blob = |&[finite @ .., motion_sigma]: &[f32; NUMBERS]| {
            let [sigma, orientation, u, v, place_u, place_v] = finite;
            let (slope, motion) = (Slope::new(u, v), Slope::new(place_u, place_v));
            let is_blob = sigma > 0.0 && motion_sigma >= 0.0 && finite.iter().all(|x| x.is_finite());
            is_blob.then_some(Blob { sigma, orientation, slope, motion, motion_sigma })
        };
        // A record that a person edited is no error: the features are found again.
        let is_unchanged = u32::from_be_bytes(*checksum) == crc32fast::hash(bytes);
        if is_whole && is_unchanged { blobs.iter().map(blob).collect::<Option<_>>().map(Self) } else { None }
    }
}

impl Serialize for StoredBlobs {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text())
    }
}

impl<'de> Deserialize<'de> for StoredBlobs {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::from_text(&text).ok_or_else(|| D::Error::custom("altered shapes and motions"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn blobs_survive_a_file_and_altered_ones_are_refused() {
        let (slope, motion) = (Slope::new(2.0, 0.5), Slope::new(-1.5, 0.25));
        let blob = |sigma, motion_sigma| Blob { sigma, orientation: 1.0, slope, motion, motion_sigma };
        let blobs = StoredBlobs(vec![blob(2.5, 0.1), blob(7.0, f32::INFINITY)]);
        let json = serde_json::to_string(&blobs).expect("plain text");
        assert_eq!(serde_json::from_str::<StoredBlobs>(&json).ok(), Some(blobs.clone()));
        assert_eq!(StoredBlobs::from_text(&StoredBlobs(Vec::new()).text()), Some(StoredBlobs(Vec::new())));
        let text = blobs.text();
        for wrong in [&text[1..], &text[..text.len() - 2], &text.replace('c', "d"), "", "xy", "é"] {
            assert_eq!(StoredBlobs::from_text(wrong), None, "{wrong}");
        }
        for wrong in [blob(f32::NAN, 0.1), blob(1.0, -0.1)] {
            assert_eq!(StoredBlobs::from_text(&StoredBlobs(vec![wrong]).text()), None);
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in ".{0,80}", digits in "[0-9a-f]{0,80}") {
            for text in [text, digits] {
                prop_assert!(StoredBlobs::from_text(&text).is_none_or(|blobs| blobs.text() == text.to_lowercase()));
            }
        }
    }
}
