//! Settings of one burst alone: its mask, times, views and part, its slopes and frames used, and the filter of its
//! features. Another burst begins without them, and the line that says so offers them to it.

use crate::app::document::{Filter, Side};
use crate::app::results::Read;
use crate::burst::OpenOptions;
use crate::detector::{FrameRange, SlopeGrid, Slopes};
use crate::requests::BurstSource;

#[derive(Debug, Clone, PartialEq)]
pub struct Own {
    /// Name of the burst that it was set for.
    pub of: String,
    /// Side of the burst that began without these settings.
    pub side: Side,
    pub calibration: OpenOptions,
    pub frames: Option<FrameRange>,
    /// `None` for slopes that are found.
    pub slopes: Option<Slopes>,
    pub filter: Filter,
}

impl Own {
    pub fn words(&self) -> Vec<&'static str> {
        let OpenOptions { mask, take, times, views, axis, array, topic, .. } = &self.calibration;
        let words = [
            (mask.is_some(), "mask"),
            (take.is_some(), "part taken"),
            (times.is_some(), "times"),
            (views.is_some(), "views"),
            (axis.is_some(), "axis"),
            (array.is_some(), "array"),
            (topic.is_some(), "topic"),
            (self.frames.is_some(), "frames used"),
            (self.slopes.is_some(), "slopes"),
            (!self.filter.is_open(), "filter"),
        ];
        words.into_iter().filter(|(is_set, _)| *is_set).map(|(_, word)| word).collect()
    }

    /// Sentence about the unused settings, and the words of the button that uses them.
    pub fn offer(&self) -> (String, &'static str) {
        let words = self.words();
        let in_b = if self.side == Side::B { "in B" } else { "here" };
        let (is, use_it) = match words[..] {
            ["mask" | "part taken" | "axis" | "array" | "topic" | "filter"] => ("is", "Use it"),
            _ => ("are", "Use them"),
        };
        let listed = match &words[..] {
            [before @ .., last] if !before.is_empty() => format!("{} and {last}", before.join(", ")),
            words => words.join(""),
        };
        (format!("The {listed} of {} {is} not used {in_b}.", self.of), use_it)
    }
}

/// The burst that a dark copy or one with things planted is made of.
pub(super) fn origin(source: &BurstSource) -> BurstSource {
    match source {
        BurstSource::DarkCopy { of, .. } | BurstSource::Planted { of, .. } => origin(of),
        source => source.absolute(),
    }
}

impl<'a> Read<'a> {
    pub fn calibration_of(self, side: Side) -> &'a OpenOptions {
        self.document.calibration_of_b.as_ref().filter(|_| side == Side::B).unwrap_or(&self.document.calibration)
    }

    /// Whether what is set for one burst holds for the other: copies of one burst, and those of the open dataset.
    pub fn are_one(self, a: &BurstSource, b: &BurstSource) -> bool {
        let in_dataset =
            |source| self.results.datasets.open.as_ref().is_some_and(|dataset| dataset.place_of(source).is_some());
        origin(a) == origin(b) || in_dataset(a) && in_dataset(b)
    }

    /// Burst whose settings a side has: open, being opened, or refused.
    pub fn settings_are_of(self, side: Side) -> Option<&'a BurstSource> {
        let slot = &self.results.slots[side];
        let open = slot.burst.as_ref().map(|open| &open.source);
        let of_side = open.or_else(|| slot.opening.pending().map(|request| &request.source));
        match side {
            Side::A => of_side.or(slot.refused.as_ref()),
            // B begins with the settings of A, unless both are opened together.
            Side::B => of_side.or_else(|| self.burst_of(Side::A).map(|open| &open.source)),
        }
    }

    pub fn own(self, of: &BurstSource, side: Side) -> Own {
        let slopes = self.document.params.slopes;
        let usual = match of {
            BurstSource::Example(example) => SlopeGrid::line(example.slopes_u().0, example.slopes_u().1).into(),
            _ => Slopes::AUTO,
        };
        let own = Own {
            of: of.label(),
            side,
            calibration: OpenOptions::default().with_burst_of(self.calibration_of(side)),
            frames: self.document.params.frames,
            slopes: Some(slopes).filter(|slopes| ![Slopes::AUTO, usual].contains(slopes)),
            filter: self.document.filter.clone(),
        };
        match side {
            Side::A => own,
            // The search is that of A.
            Side::B => Own { frames: None, slopes: None, filter: Filter::default(), ..own },
        }
    }
}
