//! Notes to the user on how a burst's values were interpreted, and on settings that may suit it better.

use super::Burst;
use super::options::{Encoding, OpenOptions};
use super::reading::{FileScale, RawFrame};
use rayon::prelude::*;

/// A note on a burst's values, and the option that changes them.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The note, as a clause.
    pub text: String,
    /// Name of the option, as on the command line without the dashes; `None` where only other files would help.
    pub option: Option<&'static str>,
    /// Suggested value of the option; `None` for a switch.
    pub value: Option<f32>,
}

impl Note {
    /// Text for the command line, with the option.
    pub fn for_command(&self) -> String {
        let Some(option) = self.option else { return self.text.clone() };
        let value = self.value.map_or(String::new(), |value| format!(" {value}"));
        format!("{}; --{option}{value} changes that", self.text)
    }

    /// Text for the window, with the menu item.
    pub fn for_window(&self) -> String {
        format!("{}{}", self.text, self.option.map_or("", |_| "; see File > Calibration"))
    }
}

/// A remark on the file of one frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Index of the frame in the burst.
    pub frame: usize,
    /// Damage, or a wrong extension.
    pub kind: RemarkKind,
}

/// Kinds of [`Remark`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RemarkKind {
    /// The data is damaged, which was accepted, and a part of the frame is made up; the reason.
    Damaged(String),
    /// The file is of this kind, such as "JPEG", and its extension names another.
    Misnamed(&'static str),
}

impl Remark {
    /// Remarks on `frames`, whose damage is taken out of them.
    pub(super) fn of(frames: &mut [RawFrame]) -> Vec<Self> {
        let of_frame = |(frame, raw): (usize, &mut RawFrame)| {
            let kinds = [raw.damage.take().map(RemarkKind::Damaged), raw.misnamed.map(RemarkKind::Misnamed)];
            kinds.into_iter().flatten().map(move |kind| Self { frame, kind })
        };
        frames.iter_mut().enumerate().flat_map(of_frame).collect()
    }
}

const CONVERTERS: [(u32, f32); 3] = [(10, 1023.0), (12, 4095.0), (14, 16383.0)];

/// Number of values between two checks of whether all converters are ruled out.
const CHUNK: usize = 4096;
/// Adding a float of this size (to its double) rounds a small number to a whole one, in the lower bits; far faster.
const INTEGERS: f32 = (1 << 23) as f32;
const MANTISSA: u32 = (1 << 23) - 1;

/// Largest value of the smallest usual converter that could have made these 16-bit frames. `None` where values need 16
/// bits, are all even (aligned to the top of the word), or were scaled or linearised by an option.
pub(super) fn suggested_full_scale(frames: &[RawFrame], options: &OpenOptions) -> Option<f32> {
    const WORD: f32 = 65535.0;
    let is_of_words = frames.iter().all(|f| f.scale == FileScale::Range(WORD));
    if options.full_scale.is_some() || options.linearise || !is_of_words {
        return None;
    }
    let beyond = CONVERTERS[CONVERTERS.len() - 1].1 as u32;
    let of_frame = |frame: &RawFrame| {
        let mut seen = (0, 0);
        for values in frame.plane.data().chunks(CHUNK) {
            seen = values.iter().fold(seen, |(largest, bits), v| {
                // The luma of colours is no whole number; rounding keeps enough of it.
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
    CONVERTERS.iter().map(|(_, value)| *value).find(|value| bits & 1 == 1 && largest as f32 <= *value)
}

impl Burst {
    /// Notes for the user on how the values were interpreted.
    pub fn notes(&self) -> Vec<Note> {
        let mut notes = Vec::new();
        if self.encoding == Encoding::Srgb {
            let text = "these pictures are encoded for screens (sRGB): their values, and their noise, are not in proportion to light";
            notes.push(Note { text: text.to_owned(), option: Some("linearise"), value: None });
        }
        let suggested = CONVERTERS.iter().find(|(_, value)| Some(*value) == self.suggested_full_scale);
        if let Some((bits, value)) = suggested {
            let text = format!("no value of these 16-bit files is above {value}, as of a camera of {bits} bits");
            notes.push(Note { text, option: Some("full-scale"), value: Some(*value) });
        }
        notes.extend(self.taken.iter().map(|text| Note { text: text.clone(), option: None, value: None }));
        let damaged: Vec<String> = self.damaged_frames().map(|(name, reason)| format!("{name} ({reason})")).collect();
        let misnamed = self.remarks.iter().filter_map(|remark| match remark.kind {
            RemarkKind::Misnamed(kind) => Some(format!("{} is {kind}", self.frame_names[remark.frame])),
            RemarkKind::Damaged(_) => None,
        });
        for (frames, remark) in [
            (damaged, "damaged, and a part of each is made up"),
            (misnamed.collect(), "of another kind than their names say"),
        ] {
            if !frames.is_empty() {
                let text = format!("{} of {} frames are {remark}: {}", frames.len(), self.len(), list(&frames));
                notes.push(Note { text, option: None, value: None });
            }
        }
        notes
    }

    /// Name and damage of each damaged frame that was accepted.
    pub fn damaged_frames(&self) -> impl Iterator<Item = (&str, &str)> {
        self.remarks.iter().filter_map(|remark| match &remark.kind {
            RemarkKind::Damaged(reason) => Some((&*self.frame_names[remark.frame], &**reason)),
            RemarkKind::Misnamed(_) => None,
        })
    }
}

fn list(items: &[String]) -> String {
    const FEW: usize = 3;
    let more = if items.len() > FEW { ", …" } else { "" };
    format!("{}{more}", items[..items.len().min(FEW)].join(", "))
}
