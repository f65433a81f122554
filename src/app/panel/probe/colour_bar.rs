//! Colour bar beside a map: the colours, the values that they stand for, the gate, and the value under the pointer.

use crate::app::canvas::overlay::rgb;
use crate::inspect::words::number;
use crate::plane::display::Display;
use egui::{Align2, Color32, Painter, Pos2, Rect, Stroke, StrokeKind, TextStyle, Ui, pos2};

/// Space for the bar with its numbers, right of a map, points.
pub(super) const WIDTH: f32 = 46.0;
/// Width of the bar, and its distance from the map, points.
const BAR: f32 = 9.0;
const GAP: f32 = 5.0;
const STEPS: usize = 48;
const APART: f32 = 11.0;

pub(super) struct ColourBar {
    pub(super) range: f32,
    /// Factor of the noise gate, where the values are in its unit.
    pub(super) gate: Option<f32>,
    pub(super) pointed: Option<f32>,
}

/// Largest magnitude that the colours of `values` span: at least the gate, so that mere noise stays pale.
pub(super) fn range_of<'v>(values: impl IntoIterator<Item = &'v f32>, gate: Option<f32>) -> f32 {
    let finite = values.into_iter().filter(|x| x.is_finite());
    finite.fold(gate.unwrap_or_default().max(1e-12), |max, x| max.max(x.abs()))
}

/// A value of a map as short text: in σ of its noise, or D itself where there is no gate.
fn text(value: f32, gate: Option<f32>) -> String {
    match gate {
        Some(_) => number(value, if value.abs() < 9.95 { 1 } else { 0 }),
        None if value == 0.0 => "0".to_owned(),
        None => format!("{value:.0e}").replace('-', "−"),
    }
}

impl ColourBar {
    /// Values with a number, each far enough from those before it: 0 and the ends first.
    fn ticks(&self, height: f32) -> Vec<f32> {
        let mut ticks: Vec<f32> = Vec::new();
        let gates = self.gate.into_iter().flat_map(|gate| [gate, -gate]);
        for value in [self.range, -self.range, 0.0].into_iter().chain(gates) {
            let apart = |other: &f32| (other - value).abs() / (2.0 * self.range) * height;
            if value.abs() <= self.range && ticks.iter().all(|other| apart(other) >= APART) {
                ticks.push(value);
            }
        }
        ticks
    }

    pub(super) fn draw(&self, ui: &Ui, map: Rect) {
        let painter: &Painter = ui.painter();
        let left = map.right() + GAP;
        let rect = Rect::from_min_max(pos2(left, map.top()), pos2(left + BAR, map.bottom()));
        let at = |value: f32| rect.bottom() - (0.5 + 0.5 * value / self.range) * rect.height();
        let colours = Display::symmetric(1.0).colours();
        for row in 0..STEPS {
            let edge = |row: usize| rect.top() + row as f32 / STEPS as f32 * rect.height();
            let colour = rgb(colours.colour(1.0 - 2.0 * (row as f32 + 0.5) / STEPS as f32));
            painter.rect_filled(Rect::from_x_y_ranges(rect.x_range(), edge(row)..=edge(row + 1)), 0.0, colour);
        }
        let (weak, strong) = (ui.visuals().weak_text_color(), ui.visuals().strong_text_color());
        painter.rect_stroke(rect, 0.0, Stroke::new(1.0, weak), StrokeKind::Outside);
        let font = TextStyle::Small.resolve(ui.style());
        let beside = |value: f32| -> Pos2 {
            let y = at(value).clamp(rect.top() + 5.0, rect.bottom() - 5.0);
            pos2(rect.right() + 4.0, y)
        };
        for gate in self.gate.into_iter().flat_map(|gate| [gate, -gate]).filter(|gate| gate.abs() <= self.range) {
            painter.hline(rect.x_range(), at(gate), Stroke::new(1.2, Color32::BLACK));
        }
        let pointed = self.pointed.filter(|value| value.is_finite());
        let is_free = |value: &f32| pointed.is_none_or(|other| (at(other) - at(*value)).abs() >= APART);
        for value in self.ticks(rect.height()).into_iter().filter(is_free) {
            painter.text(beside(value), Align2::LEFT_CENTER, text(value, self.gate), font.clone(), weak);
        }
        if let Some(value) = pointed {
            let y = at(value.clamp(-self.range, self.range));
            painter.hline(rect.left() - 3.0..=rect.right() + 3.0, y, Stroke::new(2.0, strong));
            painter.text(beside(value), Align2::LEFT_CENTER, text(value, self.gate), font, strong);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_holds_the_gate_and_all_finite_values_and_its_numbers_are_apart() {
        assert_eq!(range_of(&[-0.5, f32::NAN, 0.2], Some(0.1)), 0.5);
        assert_eq!(range_of(&[-0.5, f32::NAN, 0.2], Some(0.9)), 0.9);
        assert_eq!(range_of(&[2e-3, -3e-3], None), 3e-3, "without noise there is no gate");
        let bar = |range, gate| ColourBar { range, gate: Some(gate), pointed: None };
        assert_eq!(bar(10.0, 4.6).ticks(150.0), [10.0, -10.0, 0.0, 4.6, -4.6]);
        assert_eq!(bar(5.0, 4.6).ticks(150.0), [5.0, -5.0, 0.0], "the gate is too near to the ends");
        assert_eq!(
            (text(-0.04, Some(4.6)), text(-12.34, Some(4.6)), text(-0.0123, None)),
            ("0".into(), "−12".into(), "−1e−2".into())
        );
    }
}
