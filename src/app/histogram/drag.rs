//! Dragging of the range's ends, or of the whole range.

use super::plot::{Grip, PlotGeometry};
use crate::plane::display::Display;
use egui::Pos2;

/// Distance within which the pointer grabs a handle, in points.
const GRAB_POINTS: f32 = 9.0;

/// Drag in progress: the dragged part, and the range and pointer value at its start.
#[derive(Debug, Clone, Copy)]
pub struct Drag {
    /// Dragged part of the range.
    pub grip: Grip,
    /// The display when the drag began.
    pub start: Display,
    /// Value under the pointer when the drag began.
    pub start_value: f32,
}

/// Display range after the pointer of `drag` has moved to `value`.
pub fn dragged(drag: Drag, value: f32, axis: (f32, f32)) -> Display {
    let Drag { grip, start, start_value } = drag;
    let value = value.clamp(axis.0, axis.1);
    let moved = value - start_value;
    // An end never passes the other one.
    let least = (axis.1 - axis.0) * 1e-3;
    let narrower = |limit: f32| start.with_range(-limit.max(least), limit.max(least));
    match (grip, start.symmetric) {
        (Grip::Min, true) => narrower(-value),
        (Grip::Max, true) => narrower(value),
        // Moving a symmetric range as a whole would break its symmetry: it is widened or narrowed instead.
        (Grip::Both, true) => narrower(start.max + if start_value < 0.0 { -moved } else { moved }),
        (Grip::Min, false) => start.with_range(value.min(start.max - least), start.max),
        (Grip::Max, false) => start.with_range(start.min, value.max(start.min + least)),
        (Grip::Both, false) => start.with_range(start.min + moved, start.max + moved),
    }
}

/// Part of the range that the pointer would grab.
pub fn grip_at(pointer: Pos2, geometry: &PlotGeometry, display: &Display) -> Option<Grip> {
    let (low, high) = (geometry.x_of(display.min), geometry.x_of(display.max));
    let (to_low, to_high) = ((pointer.x - low).abs(), (pointer.x - high).abs());
    // In a narrow range the middle third still grabs the whole range.
    let reach = GRAB_POINTS.min(0.34 * (high - low).max(3.0));
    let outside = pointer.x < low || pointer.x > high;
    let reach = if outside { GRAB_POINTS } else { reach };
    if to_low.min(to_high) <= reach {
        Some(if to_low < to_high { Grip::Min } else { Grip::Max })
    } else {
        (!outside).then_some(Grip::Both)
    }
}

/// End of the range that a press outside it moves.
pub fn nearest_end(pointer: Pos2, geometry: &PlotGeometry, display: &Display) -> Grip {
    if pointer.x < geometry.x_of(display.min) { Grip::Min } else { Grip::Max }
}

#[cfg(test)]
mod tests {
    use super::super::axis::axis_for;
    use super::*;
    use proptest::prelude::*;

    fn drag(grip: Grip, start: Display, start_value: f32) -> Drag {
        Drag { grip, start, start_value }
    }

    #[test]
    fn handles_move_their_end_and_the_middle_moves_both() {
        let start = Display { min: 0.2, max: 0.6, ..Display::default() };
        let axis = (0.0, 1.0);
        let range = |grip, from, to| {
            let d = dragged(drag(grip, start, from), to, axis);
            ((d.min * 1e4).round() / 1e4, (d.max * 1e4).round() / 1e4)
        };
        assert_eq!(range(Grip::Min, 0.2, 0.3), (0.3, 0.6));
        assert_eq!(range(Grip::Max, 0.6, 0.9), (0.2, 0.9));
        assert_eq!(range(Grip::Both, 0.4, 0.5), (0.3, 0.7));
        assert_eq!(range(Grip::Min, 0.2, 0.9), (0.599, 0.6));
    }

    #[test]
    fn a_symmetric_range_stays_symmetric() {
        let start = Display::symmetric(0.1);
        for (grip, from, to) in [(Grip::Min, -0.1, -0.05), (Grip::Max, 0.1, 0.05), (Grip::Both, 0.06, 0.01)] {
            let d = dragged(drag(grip, start, from), to, (-0.2, 0.2));
            assert_eq!(d.min, -d.max);
            assert!((d.max - 0.05).abs() < 1e-6, "{grip:?}: {d:?}");
        }
    }

    proptest! {
        #[test]
        fn dragging_anywhere_keeps_a_usable_range(
            min in -1f32..1.0, width in 0.001f32..2.0, symmetric in any::<bool>(), from in -2f32..2.0, to in -5f32..5.0, which in 0..3
        ) {
            let start = Display { symmetric, ..Display::default() }.with_range(min, min + width);
            let grip = [Grip::Min, Grip::Max, Grip::Both][which as usize];
            let axis = axis_for(None, &start);
            let end = dragged(drag(grip, start, from), to, axis);
            prop_assert!(end.min < end.max && end.min.is_finite() && end.max.is_finite(), "{end:?}");
            prop_assert!(!symmetric || end.min == -end.max);
        }
    }
}
