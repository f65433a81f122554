//! Drawing a disc.

use crate::plane::Plane;

/// Blends a disc of level `value` into `plane`, weighting each pixel by the share of its area that the disc covers.
/// The area is exact along rows and taken from 16 thin strips across them.
pub fn draw_disc(plane: &mut Plane, u: f64, v: f64, radius: f64, value: f32) {
    const STRIPS: usize = 16;
    let clip = |x: f64, size: usize| x.clamp(0.0, size as f64) as usize;
    let rows = clip((v - radius + 0.5).floor(), plane.height())..clip((v + radius + 0.5).floor() + 1.0, plane.height());
    let columns =
        clip((u - radius + 0.5).floor(), plane.width())..clip((u + radius + 0.5).floor() + 1.0, plane.width());
    for row in rows {
        let mut chords = [0.0f64; STRIPS];
        for (k, half_chord) in chords.iter_mut().enumerate() {
            let dv = row as f64 - 0.5 + (k as f64 + 0.5) / STRIPS as f64 - v;
            *half_chord = (radius * radius - dv * dv).max(0.0).sqrt();
        }
        for column in columns.clone() {
            let (left, right) = (column as f64 - 0.5 - u, column as f64 + 0.5 - u);
            let covered: f64 = chords.iter().map(|&c| (right.min(c) - left.max(-c)).max(0.0)).sum();
            let share = (covered / STRIPS as f64) as f32;
            if share > 0.0 {
                let pixel = &mut plane.row_mut(row)[column];
                *pixel += share * (value - *pixel);
            }
        }
    }
}
