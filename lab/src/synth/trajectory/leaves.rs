//! Dead leaves: the texture of the planes of a trajectory's scene.
//!
//! Shapes of random size, grey value and orientation fall on a sheet, later ones over earlier ones. Sizes follow the
//! law 1/r³, by which every octave of sizes covers the same area. Such pictures have the statistics of natural ones (A.
//! B. Lee, D. Mumford and J. Huang, "Occlusion models for natural images", International Journal of Computer Vision 41
//! (2001), 35–59), so that a detector finds features at all its scales.

use burstscope_core::synth::paint::{Area, Sheet};
use burstscope_core::synth::random::Stream;
use std::ops::RangeInclusive;

/// Mean number of times that the leaves cover the sheet; exp(−3) or 5 % of the previous content remains.
const COVERAGE: f64 = 3.0;

/// Covers the whole of `sheet` with leaves of radii in `radii` (pixels, above 0) and values in `values`.
pub(super) fn paint_leaves(
    sheet: &mut Sheet,
    radii: &RangeInclusive<f64>,
    values: &RangeInclusive<f64>,
    stream: &mut Stream,
) {
    let area = sheet.area();
    let middle = 0.5 * (values.start() + values.end());
    sheet.fill(|_, _| middle as f32);
    let (width, height) = (f64::from(area.u1 - area.u0), f64::from(area.v1 - area.v0));
    let count = (COVERAGE * width * height / mean_area(radii)).ceil() as usize;
    for _ in 0..count {
        let radius = leaf_radius(radii, stream);
        let u = f64::from(area.u0) + width * stream.uniform();
        let v = f64::from(area.v0) + height * stream.uniform();
        let value = stream.within(*values.start(), *values.end()) as f32;
        if stream.uniform() < 0.5 {
            sheet.disc(u as f32, v as f32, radius as f32, value);
        } else {
            let aspect = stream.within(0.4, 1.0);
            turned_rectangle(sheet, (u, v), (radius, aspect * radius), direction(stream), value);
        }
    }
}

/// A random radius whose density falls like 1/r³ over the range.
fn leaf_radius(radii: &RangeInclusive<f64>, stream: &mut Stream) -> f64 {
    let (fine, coarse) = (1.0 / radii.start().powi(2), 1.0 / radii.end().powi(2));
    1.0 / (fine - stream.uniform() * (fine - coarse)).sqrt()
}

/// Mean area of a leaf, pixels: that of discs, π·E(r²), and of rectangles, E(4·r²·aspect), in equal shares.
fn mean_area(radii: &RangeInclusive<f64>) -> f64 {
    let (a, b) = (*radii.start(), *radii.end());
    let mean_square = if b - a < 1e-6 * a { a * a } else { 2.0 * libm::log(b / a) / (a.powi(-2) - b.powi(-2)) };
    // 0.7 is the mean aspect of the rectangles that `paint_leaves` draws.
    mean_square * 0.5 * (std::f64::consts::PI + 4.0 * 0.7)
}

/// A random direction, uniform by rejection: unlike square roots, sine and cosine round differently by machine.
fn direction(stream: &mut Stream) -> (f64, f64) {
    loop {
        let (x, y) = (stream.within(-1.0, 1.0), stream.within(-1.0, 1.0));
        let square = x * x + y * y;
        if (0.01..=1.0).contains(&square) {
            return (x / square.sqrt(), y / square.sqrt());
        }
    }
}

/// Paints a filled rectangle around `centre` with half sides `half`, the first of them along `direction`.
fn turned_rectangle(sheet: &mut Sheet, centre: (f64, f64), half: (f64, f64), direction: (f64, f64), value: f32) {
    let (u, v) = (centre.0 as f32, centre.1 as f32);
    let (cos, sin) = (direction.0 as f32, direction.1 as f32);
    let level = Area::new(-half.0 as f32, -half.1 as f32, half.0 as f32, half.1 as f32);
    let reach = (half.0 * half.0 + half.1 * half.1).sqrt() as f32;
    let distance = |x: f32, y: f32| {
        let (du, dv) = (x - u, y - v);
        level.distance(cos * du + sin * dv, cos * dv - sin * du)
    };
    sheet.shape(Area::around(u, v, reach), distance, |_, _| value);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_octave_of_sizes_covers_the_same_area() {
        let (mut stream, radii) = (Stream::new(5, 0), 1.5..=24.0);
        let (mut areas, mut total) = ([0.0f64; 4], 0.0);
        const COUNT: usize = 400_000;
        for _ in 0..COUNT {
            let radius = leaf_radius(&radii, &mut stream);
            assert!((1.5 - 1e-9..=24.0 + 1e-9).contains(&radius), "{radius}");
            areas[((radius / 1.5).log2() as usize).min(3)] += radius * radius;
            total += radius * radius;
        }
        // Few leaves, each of much area, lie in the coarsest octave: one in 340, so its share is known to about 6 %.
        assert!(areas.iter().all(|area| (area / total - 0.25).abs() < 0.02), "{areas:?}");
        let predicted = mean_area(&radii) / (0.5 * (std::f64::consts::PI + 2.8));
        assert!((total / COUNT as f64 / predicted - 1.0).abs() < 0.03, "{predicted}");
    }

    #[test]
    fn the_sheet_is_covered_with_values_in_the_range_and_follows_from_the_stream() {
        let painted = |seed: u64| {
            let mut sheet = Sheet::new(60, 50, 2, 2);
            paint_leaves(&mut sheet, &(1.5..=12.0), &(0.1..=0.9), &mut Stream::new(seed, 4));
            sheet
        };
        let sheet = painted(1);
        let rows = (0..sheet.size().1).map(|row| sheet.row(row));
        let (mut sum, mut squares, mut count) = (0.0f64, 0.0, 0.0);
        for (values, alphas) in rows {
            assert!(alphas.iter().all(|&alpha| (alpha - 1.0).abs() < 1e-6));
            for &value in values {
                assert!((0.1 - 1e-6..=0.9 + 1e-6).contains(&value));
                sum += f64::from(value);
                squares += f64::from(value).powi(2);
                count += 1.0;
            }
        }
        let spread = (squares / count - (sum / count).powi(2)).sqrt();
        // Values uniform from 0.1 to 0.9 have a standard deviation of 0.23.
        assert!((0.15..0.28).contains(&spread), "{spread}");
        assert_eq!(sheet, painted(1));
        assert_ne!(sheet, painted(2));
    }

    #[test]
    fn a_turned_rectangle_has_its_area_and_its_direction() {
        let mut sheet = Sheet::new(60, 60, 0, 0);
        turned_rectangle(&mut sheet, (30.0, 30.0), (16.0, 6.0), (0.8, 0.6), 1.0);
        let covered: f32 = (0..sheet.size().1).map(|row| sheet.row(row).1.iter().sum::<f32>()).sum();
        assert!((covered / 4.0 - 32.0 * 12.0).abs() < 3.0, "{covered}");
        // Painted 14 px along its long side, unpainted 14 px across it.
        assert_eq!(sheet.alpha_at(30.0 + 14.0 * 0.8, 30.0 + 14.0 * 0.6), 1.0);
        assert_eq!(sheet.alpha_at(30.0 - 14.0 * 0.6, 30.0 + 14.0 * 0.8), 0.0);
    }
}
