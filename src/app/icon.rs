//! The program's icon, drawn here as in `assets/icon.svg`: three frames shifted over one another, and the blob on which
//! they agree.

use egui::{Color32, IconData};

/// Side of the drawing's own unit square, in which all places are given.
const UNITS: f32 = 64.0;

/// Distance to the outline of a square with rounded corners, from `from` to `from + side`; negative inside.
fn square(u: f32, v: f32, from: [f32; 2], side: f32, radius: f32) -> f32 {
    let half = 0.5 * side - radius;
    let du = ((u - from[0] - 0.5 * side).abs() - half).max(0.0);
    let dv = ((v - from[1] - 0.5 * side).abs() - half).max(0.0);
    let inner = ((u - from[0] - 0.5 * side).abs() - half).max((v - from[1] - 0.5 * side).abs() - half).min(0.0);
    du.hypot(dv) + inner - radius
}

/// Distance to the line from (42.5, 32) to (54, 32).
fn arrow(u: f32, v: f32) -> f32 {
    (u - u.clamp(42.5, 54.0)).hypot(v - 32.0)
}

/// The icon with `side` pixels on each side.
pub fn icon(side: u32) -> IconData {
    const BLUE: Color32 = Color32::from_rgb(0x2f, 0x7f, 0xd6);
    const YELLOW: Color32 = Color32::from_rgb(0xff, 0xc8, 0x3c);
    let pixel = UNITS / side as f32;
    let mut rgba = Vec::with_capacity((side * side * 4) as usize);
    for row in 0..side {
        for column in 0..side {
            let (u, v) = ((column as f32 + 0.5) * pixel, (row as f32 + 0.5) * pixel);
            // Covered fraction of the pixel at this distance from the outline.
            let cover = |distance: f32| (0.5 - distance / pixel).clamp(0.0, 1.0);
            let stroke = |distance: f32, width: f32| cover(distance.abs() - 0.5 * width);
            let centre = (u - 32.0).hypot(v - 32.0);
            let mut colour = [0.0f32; 4];
            let mut paint = |over: Color32, alpha: f32| {
                let over = [over.r(), over.g(), over.b()].map(f32::from);
                let all = alpha + colour[3] * (1.0 - alpha);
                for (channel, value) in over.into_iter().enumerate() {
                    let below = colour[channel] * colour[3] * (1.0 - alpha);
                    colour[channel] = if all > 0.0 { (value * alpha + below) / all } else { 0.0 };
                }
                colour[3] = all;
            };
            paint(Color32::from_rgb(0x15, 0x18, 0x1f), cover(square(u, v, [2.0, 2.0], 60.0, 13.0)));
            for (from, alpha) in [([8.0, 12.0], 0.45), ([15.0, 15.0], 0.7), ([22.0, 18.0], 1.0)] {
                paint(BLUE, alpha * stroke(square(u, v, from, 34.0, 4.0), 2.5));
            }
            paint(YELLOW, stroke(centre - 10.5, 3.0));
            paint(YELLOW, cover(arrow(u, v) - 1.5));
            paint(Color32::from_rgb(0xff, 0xf3, 0xc4), cover(centre - 4.5));
            rgba.extend(colour[..3].iter().map(|x| x.round() as u8));
            rgba.push((255.0 * colour[3]).round() as u8);
        }
    }
    IconData { rgba, width: side, height: side }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_corners_are_clear_its_ground_dark_and_its_middle_bright() {
        for side in [16, 64, 256] {
            let icon = icon(side);
            assert_eq!(icon.rgba.len(), (4 * side * side) as usize);
            let at = |u: u32, v: u32| {
                let start = (4 * (v * side / 64 * side + u * side / 64)) as usize;
                icon.rgba[start..start + 4].to_vec()
            };
            assert_eq!(at(0, 0)[3], 0);
            assert!(at(32, 6)[..3].iter().all(|x| *x < 60) && at(32, 6)[3] == 255);
            assert!(at(32, 32)[..3].iter().all(|x| *x > 150));
        }
    }
}
