//! Ticks of plots: round values, each far enough from the next for its label, and at least two of them.
//!
//! The toolkit's own ticks are powers of ten. Where only one of them has room for its label, an axis shows a lone "0".

use egui_plot::{GridInput, GridMark};

/// Distance between ticks of a vertical axis where there is room, and the distance below which the toolkit leaves out
/// labels, in the toolkit's smallest distances between grid lines: 8 points.
const HIGH: [f64; 2] = [4.0, 2.6];
/// Both distances for a horizontal axis, in the same unit: its labels are wider than high.
const WIDE: [f64; 2] = [10.0, 7.6];

/// Ticks of a vertical axis, for [`egui_plot::Plot::y_grid_spacer`]: multiples of 1, 2 or 5 times a power of ten.
pub fn of_height(input: GridInput) -> Vec<GridMark> {
    ticks(input, HIGH)
}

pub fn of_width(input: GridInput) -> Vec<GridMark> {
    ticks(input, WIDE)
}

fn ticks(input: GridInput, distances: [f64; 2]) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let count = |step: f64| (high / step).floor() - (low / step).ceil() + 1.0;
    // In a low plot labels may be closer, so that there are two.
    let steps = distances.map(|distance| round_up(distance * input.base_step_size));
    let step = steps.into_iter().find(|step| count(*step) >= 2.0).unwrap_or(steps[1]);
    let first = (low / step).ceil();
    (0..count(step) as u32).map(|k| GridMark { value: (first + f64::from(k)) * step, step_size: step }).collect()
}

/// Smallest number of the form 1, 2 or 5 times a power of ten that is not below `x` > 0.
fn round_up(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|round| *round >= x * (1.0 - 1e-9)).unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_axis(low: f64, high: f64, height: f64) -> Vec<f64> {
        let base_step_size = 8.0 * (high - low) / height;
        of_height(GridInput { bounds: (low, high), base_step_size }).iter().map(|mark| mark.value).collect()
    }

    #[test]
    fn every_axis_has_at_least_two_round_ticks() {
        let close = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(close(&of_axis(-0.05, 0.66, 120.0), &[0.0, 0.2, 0.4, 0.6]), "{:?}", of_axis(-0.05, 0.66, 120.0));
        assert!(close(&of_axis(0.0, 8.4, 90.0), &[0.0, 5.0]));
        for height in [110.0, 150.0, 400.0] {
            for scale in [1e-6, 0.013, 0.7, 3.0, 4000.0] {
                for (low, high) in [(0.0, 1.0), (-0.3, 0.9), (0.21, 0.83), (-1.0, -0.2)] {
                    let found = of_axis(low * scale, high * scale, height);
                    assert!(found.len() >= 2 && found.len() as f64 <= height / 20.0, "{found:?} {scale} {height}");
                    // Multiples of a step are rounded.
                    let slack = 1e-9 * scale;
                    assert!(found.iter().all(|x| (low * scale - slack..=high * scale + slack).contains(x)));
                }
            }
        }
        assert!(of_axis(0.0, f64::NAN, 100.0).is_empty());
        let wide = of_width(GridInput { bounds: (0.0, 1.9), base_step_size: 8.0 * 1.9 / 230.0 });
        assert!(wide.len() >= 2, "{wide:?}");
    }
}
