//! Corresponding places of a scene in two panes.

use crate::app::document::Cursor;
use crate::burst::{Offset, Positions};
use crate::requests::PictureKind;
use egui::{Pos2, vec2};
use std::ops::Range;

/// Maps a place of one pane to another, in image pixels; the frames `used` of those at `positions` are searched.
/// Pictures of many frames show it where it is at mid-burst, a frame shows it moved along its slope: that of the pane
/// that shows no frame, or that of the pane under the pointer if both show frames.
pub fn place_in(
    pos_image: Pos2,
    from_kind: PictureKind,
    from: &Cursor,
    to_kind: PictureKind,
    to: &Cursor,
    (positions, used): (&Positions, Range<usize>),
) -> Pos2 {
    // From mid-burst; 0 for pictures of the whole burst.
    let after = |kind: PictureKind| match kind {
        PictureKind::Frame(t) => positions.offset_from(used.clone(), t).to_f32(),
        _ => Offset::default(),
    };
    let slope = match (from_kind, to_kind) {
        (
            PictureKind::Frame(_),
            PictureKind::Stack { slope } | PictureKind::Dog { slope, .. } | PictureKind::Map { slope, .. },
        )
        | (PictureKind::Stack { slope } | PictureKind::Dog { slope, .. } | PictureKind::Map { slope, .. }, _) => slope,
        (PictureKind::Frame(_), _) => from.slope,
        (PictureKind::Merge, _) => to.slope,
    };
    let (u, v) = slope.displacement(after(to_kind) - after(from_kind));
    pos_image + vec2(u, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Slope;
    use egui::pos2;
    use proptest::prelude::*;

    const SLOPE: Slope = Slope { u: 2.0, v: -1.0 };

    proptest! {
        #[test]
        fn there_and_back_is_the_same_place(u in 0f32..500.0, v in 0f32..500.0, t in 0usize..12, s in -3f32..3.0) {
            let cursor = Cursor { slope: Slope::new(s, -s), ..Cursor::default() };
            let kinds = [
                PictureKind::Frame(t),
                PictureKind::Stack { slope: SLOPE },
                PictureKind::Merge,
                PictureKind::Dog { octave: 1, level: 0, slope: SLOPE },
            ];
            for a in kinds {
                for b in kinds {
                    let there = place_in(pos2(u, v), a, &cursor, b, &cursor, (&Positions::even(12), 0..12));
                    let back = place_in(there, b, &cursor, a, &cursor, (&Positions::even(12), 0..12));
                    prop_assert!((back - pos2(u, v)).length() < 1e-3, "{a:?} {b:?}");
                }
            }
        }
    }
}
