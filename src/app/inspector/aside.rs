//! A picture that stays where it is while a panel comes beside it, so that what was clicked stays under the pointer.

use crate::app::view::{View, Zoom};
use egui::Rect;

/// Canvas of the last pass, and its view before the panel came.
#[derive(Debug, Default)]
pub struct HeldPlace {
    last: Option<(Rect, bool)>,
    moved: Option<(View, View)>,
    left: Option<View>,
}

impl HeldPlace {
    /// Adapts `view` to the canvas `rect_ui` of this pass, beside which a panel came by itself (`is_beside`) or not.
    /// When the panel comes, the picture keeps its place and size; when it goes, an untouched view is as before. A
    /// view that was set as the panel came, such as that of a session, is one beside it.
    pub fn keep(&mut self, view: &mut View, rect_ui: Rect, is_beside: bool) {
        let Some((before, was_beside)) = self.last.replace((rect_ui, is_beside)) else { return };
        let untouched = self.moved.filter(|(after, _)| after == view).map(|(_, original)| original);
        // A panel finds its width in its first passes.
        let is_growing = is_beside && untouched.is_some();
        if before == rect_ui || (was_beside == is_beside && !is_growing) {
            return;
        }
        let is_set = self.left.is_some_and(|left| left != *view);
        match untouched.filter(|_| !is_beside) {
            Some(original) => *view = original,
            None if is_beside && is_set => self.moved = None,
            // A picture fitted beside the panel is fitted again without the panel.
            None if !is_beside && !matches!(view.zoom, Zoom::PointsPerPixel(_)) => self.moved = None,
            None => {
                let original = untouched.unwrap_or(*view);
                view.keep_place(before, rect_ui);
                self.moved = is_beside.then_some((*view, original));
            }
        }
    }

    pub fn leave(&mut self, view: View) {
        self.left = Some(view);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Vec2, pos2};

    const SIZE: (usize, usize) = (480, 360);

    fn rect(width: f32) -> Rect {
        Rect::from_min_size(pos2(240.0, 84.0), Vec2::new(width, 600.0))
    }

    #[test]
    fn a_view_that_was_changed_meanwhile_stays_as_it_is_and_a_resized_window_fits_anew() {
        let (mut aside, mut view) = (HeldPlace::default(), View::fit());
        aside.keep(&mut view, rect(1040.0), false);
        view.settle(rect(1040.0), SIZE, 1.0);
        aside.keep(&mut view, rect(780.0), true);
        view.zoom_by(1.5);
        let place = pos2(200.0, 150.0);
        let before = view.settle(rect(780.0), SIZE, 1.0).pos(place);
        aside.keep(&mut view, rect(1040.0), false);
        let after = view.settle(rect(1040.0), SIZE, 1.0).pos(place);
        assert!((after - before).length() < 0.6 && !view.is_fit());
        let (mut aside, mut view) = (HeldPlace::default(), View::fit());
        aside.keep(&mut view, rect(1040.0), false);
        aside.keep(&mut view, rect(600.0), false);
        assert!(view.is_fit());
    }
}
