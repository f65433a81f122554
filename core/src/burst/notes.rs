//! What a person should know of how a burst's values were taken, and could change: told, never done unasked.

use super::Burst;
use super::decode::{FileScale, RawFrame};
use super::encoding::Encoding;
use super::options::OpenOptions;
use rayon::prelude::*;

/// Something to know of a burst's values, and the option that changes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// What it is.
    pub text: String,
    /// The option's name, as on the command line without the dashes.
    pub option: &'static str,
    /// What it could be set to; none for a switch.
    pub value: Option<f32>,
}

impl Note {
    /// The sentence for somebody at a command line.
    pub fn for_command(&self) -> String {
        let value = self.value.map_or(String::new(), |value| format!(" {value}"));
        format!("{}; --{}{value} changes that", self.text, self.option)
    }
}

/// The largest values of converters of 10, 12 and 14 bit.
const CONVERTERS: [(u32, f32); 3] = [(10, 1023.0), (12, 4095.0), (14, 16383.0)];

/// Values between two looks at whether a converter is ruled out.
const CHUNK: usize = 4096;
/// From here to twice as much floats are whole numbers: a small number is rounded by being added to it, and then stands
/// in the sum's lower bits, which is far faster than rounding each by itself.
const INTEGERS: f32 = (1 << 23) as f32;
/// The bits of a float's fraction.
const MANTISSA: u32 = (1 << 23) - 1;

/// The largest value of the smallest usual converter that could have made these 16-bit frames: `None` where their
/// values need 16 bits, stand at the top of the word (all are multiples of 2), or a full scale was given.
pub(super) fn suggested_full_scale(frames: &[RawFrame], options: &OpenOptions) -> Option<f32> {
    const WORD: f32 = 65535.0;
    if options.full_scale.is_some() || options.linearise {
        return None;
    }
    if frames.iter().any(|f| f.scale != FileScale::Range(WORD)) {
        return None;
    }
    let beyond = CONVERTERS[CONVERTERS.len() - 1].1 as u32;
    let of_frame = |frame: &RawFrame| {
        let mut seen = (0, 0);
        for values in frame.plane.data().chunks(CHUNK) {
            seen = values.iter().fold(seen, |(largest, bits), v| {
                // Luma of colours is no whole number; rounding keeps what matters here.
                let value = (v * WORD + INTEGERS).to_bits() & MANTISSA;
                (value.max(largest), bits | value)
            });
            if seen.0 > beyond {
                break;
            }
        }
        seen
    };
    let (largest, bits) = frames.par_iter().map(of_frame).reduce(|| (0, 0), |a, b| (a.0.max(b.0), a.1 | b.1));
    if bits & 1 == 0 {
        return None;
    }
    CONVERTERS.iter().map(|(_, value)| *value).find(|value| largest as f32 <= *value)
}

impl Burst {
    /// What a person should know of how its values were taken.
    pub fn notes(&self) -> Vec<Note> {
        let mut notes = Vec::new();
        if self.encoding == Encoding::Srgb {
            let text = "these pictures are encoded for screens (sRGB): their values, and their noise, are not in proportion to light";
            notes.push(Note { text: text.to_owned(), option: "linearise", value: None });
        }
        let suggested = CONVERTERS.iter().find(|(_, value)| Some(*value) == self.suggested_full_scale);
        if let Some((bits, value)) = suggested {
            let text = format!("no value of these 16-bit files is above {value}, as of a camera of {bits} bits");
            notes.push(Note { text, option: "full-scale", value: Some(*value) });
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;

    #[test]
    fn converters_are_suggested_by_what_the_values_need() {
        let frame = |values: &[f32]| RawFrame {
            plane: Plane::from_vec(values.len(), 1, values.iter().map(|v| v / 65535.0).collect()),
            scale: FileScale::Range(65535.0),
            encoding: Encoding::Linear,
            binning: 1,
        };
        let options = OpenOptions::default();
        for (values, expected) in [
            (&[0.0, 1001.0][..], Some(1023.0)),
            (&[0.0, 1024.0, 3.0], Some(4095.0)),
            (&[7.0, 16383.0], Some(16383.0)),
            (&[7.0, 16384.0], None),
            // Twelve bits at the top of the word: all values are multiples of 16.
            (&[0.0, 16.0, 1600.0], None),
            (&[0.0, 0.0], None),
        ] {
            assert_eq!(suggested_full_scale(&[frame(values)], &options), expected, "{values:?}");
        }
        // One bright frame among dark ones tells.
        assert_eq!(suggested_full_scale(&[frame(&[3.0]), frame(&[40_001.0])], &options), None);
        let given = OpenOptions { full_scale: Some(4095.0), ..options };
        assert_eq!(suggested_full_scale(&[frame(&[3.0])], &given), None);
    }
}
