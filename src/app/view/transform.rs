//! Transforms between coordinate systems: a uniform scale and a shift.

use egui::{Pos2, Rect, Vec2};

/// A uniform scale and shift, as `ui_from_image` or its inverse: names say "to from".
///
/// It is stored as a pair of corresponding points and a scale, not as an offset: positions near the anchor, where the
/// user looks, stay exact even at 128-fold zoom in the corner of a huge picture, where an offset would lose its
/// fraction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectTransform {
    anchor_from: Pos2,
    anchor_to: Pos2,
    scale: f32,
}

impl RectTransform {
    /// Creates the transform that maps `anchor_from` to `anchor_to` and multiplies lengths by `scale`, which must be
    /// finite and positive.
    pub fn new(anchor_from: Pos2, anchor_to: Pos2, scale: f32) -> Self {
        debug_assert!(scale.is_finite() && scale > 0.0, "a scale is positive, not {scale}");
        Self { anchor_from, anchor_to, scale }
    }

    /// Factor by which lengths grow.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Anchor before the transform; positions near it are the most exact.
    pub fn anchor_from(&self) -> Pos2 {
        self.anchor_from
    }

    /// Anchor after the transform.
    pub fn anchor_to(&self) -> Pos2 {
        self.anchor_to
    }

    /// Transforms a position.
    pub fn pos(&self, from: Pos2) -> Pos2 {
        self.anchor_to + self.scale * (from - self.anchor_from)
    }

    /// Transforms a vector.
    pub fn vec(&self, from: Vec2) -> Vec2 {
        self.scale * from
    }

    /// Transforms a rectangle.
    pub fn rect(&self, from: Rect) -> Rect {
        Rect::from_min_max(self.pos(from.min), self.pos(from.max))
    }

    /// Inverse transform.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { anchor_from: self.anchor_to, anchor_to: self.anchor_from, scale: 1.0 / self.scale }
    }

    /// Returns the transform for source coordinates that are `factor` times smaller: with `ui_from_image` and a picture
    /// whose pixels are `factor` image pixels apart, this is `ui_from_picture`.
    #[must_use]
    pub fn from_scaled(&self, factor: f32) -> Self {
        Self {
            anchor_from: (self.anchor_from.to_vec2() / factor).to_pos2(),
            anchor_to: self.anchor_to,
            scale: self.scale * factor,
        }
    }

    /// Returns the transform shifted by `delta`, in target coordinates.
    #[must_use]
    pub fn shifted(&self, delta: Vec2) -> Self {
        Self { anchor_to: self.anchor_to + delta, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};
    use proptest::prelude::*;

    #[test]
    fn anchor_scale_and_rectangle() {
        let t = RectTransform::new(pos2(10.0, 20.0), pos2(100.0, 50.0), 2.0);
        assert_eq!(t.pos(pos2(10.0, 20.0)), pos2(100.0, 50.0));
        assert_eq!(t.pos(pos2(11.0, 18.0)), pos2(102.0, 46.0));
        assert_eq!(t.vec(vec2(3.0, -1.0)), vec2(6.0, -2.0));
        let rect = t.rect(Rect::from_min_max(pos2(10.0, 20.0), pos2(12.0, 21.0)));
        assert_eq!(rect, Rect::from_min_max(pos2(100.0, 50.0), pos2(104.0, 52.0)));
        let octave = t.from_scaled(4.0);
        assert!((octave.pos(pos2(3.0, 5.0)) - t.pos(pos2(12.0, 20.0))).length() < 1e-4);
    }

    #[test]
    fn positions_stay_exact_far_out_at_high_zoom() {
        let t = RectTransform::new(pos2(16000.0, 16000.0), pos2(500.0, 400.0), 128.0);
        let moved = t.pos(pos2(16000.0 + 1.0 / 64.0, 16000.0)) - t.pos(pos2(16000.0, 16000.0));
        assert!((moved.x - 2.0).abs() < 1e-3, "{moved:?}");
    }

    proptest! {
        #[test]
        fn there_and_back(
            x in -100f32..20_000.0, y in -100f32..20_000.0, cx in 0f32..16_000.0, cy in 0f32..16_000.0, scale in 0.01f32..128.0
        ) {
            let t = RectTransform::new(pos2(cx, cy), pos2(640.0, 360.0), scale);
            let back = t.inverse().pos(t.pos(pos2(x, y)));
            prop_assert!((back - pos2(x, y)).length() < 0.02, "{back:?}");
        }
    }
}
