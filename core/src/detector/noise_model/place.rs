//! Noise by place, where it differs from the brightness's prediction, as on a side of the sensor that is amplified
//! more.
//!
//! The picture is divided into cells; the quiet part of a cell's squares over the variance that their brightness
//! predicts is the cell's excess. A cell whose squares differ among themselves more than noise does has texture, or
//! lies across a border, and is not trusted: it takes the largest excess of its trusted neighbours.

use super::frames::median;
use super::high_pass::quiet_variance;
use super::photon_transfer::PhotonTransfer;
use super::pyramid::sample_at;
use crate::plane::Plane;
use serde::{Serialize, Serializer};

/// Noise of one square of the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Centre, image pixels.
    pub place: (f32, f32),
    /// Brightness, fraction of full scale.
    pub brightness: f32,
    /// Variance of the noise of one frame there, in (fraction of full scale)².
    pub variance: f32,
}

/// Variance relative to that predicted by the brightness, by place.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcessMap {
    /// One value a cell, as measured.
    pub cells: Plane,
    /// Values as the gate uses them: cells beside a border are raised to the larger side.
    pub raised: Plane,
    /// Side of a cell, image pixels.
    pub cell_px: f32,
}

impl Serialize for ExcessMap {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Cells<'a> {
            cell_px: f32,
            columns: usize,
            rows: usize,
            variance_ratios: &'a [f32],
        }
        let (columns, rows) = self.cells.size();
        Cells { cell_px: self.cell_px, columns, rows, variance_ratios: self.cells.data() }.serialize(serializer)
    }
}

/// Number of squares that a cell should have.
const SQUARES_A_CELL: usize = 14;
/// Difference from 1 below which an excess is taken for 1.
const LEAST_EXCESS: f32 = 0.2;
/// Spread of a cell's squares, relative to that of noise, up to which the cell is trusted.
const TRUSTED_SPREAD: f32 = 1.8;
/// Difference from 1, in units of its error, above which an excess is significant.
const SURE: f32 = 4.0;
/// Ratio of a neighbour's excess to its own above which a cell is at a border, and takes the neighbour's.
const BORDER: f32 = 1.4;

impl ExcessMap {
    /// Finds the excess in an image of `size`, from squares that each have `free` independent values; `None` where the
    /// noise is everywhere as the brightness predicts, or unknown.
    pub fn find(squares: &[Square], transfer: &PhotonTransfer, size: (usize, usize), free: f32) -> Option<Self> {
        let wanted = squares.len() / SQUARES_A_CELL;
        if wanted < 4 {
            return None;
        }
        let cell_px = ((size.0 * size.1) as f32 / wanted as f32).sqrt().ceil();
        let (columns, rows) = ((size.0 as f32 / cell_px).ceil() as usize, (size.1 as f32 / cell_px).ceil() as usize);
        let mut members: Vec<Vec<f32>> = vec![Vec::new(); columns * rows];
        for square in squares {
            let predicted = transfer.variance(square.brightness);
            if predicted > 0.0 {
                let at = |x: f32, n: usize| ((x / cell_px) as usize).min(n - 1);
                members[at(square.place.1, rows) * columns + at(square.place.0, columns)]
                    .push(square.variance / predicted);
            }
        }
        members.iter_mut().for_each(|ratios| ratios.sort_by(f32::total_cmp));
        let full: Vec<&Vec<f32>> = members.iter().filter(|ratios| ratios.len() >= SQUARES_A_CELL / 2).collect();
        let usual_spread = median(full.iter().map(|ratios| spread(ratios)).collect());
        let own: Vec<Option<f32>> = members.iter().map(|ratios| trusted_excess(ratios, free)).collect();
        let known: Vec<f32> = own.iter().copied().flatten().collect();
        // Where squares mostly disagree, as under texture or the few coefficients of a file, nothing is known.
        if 2 * known.len() < full.len() {
            return None;
        }
        let error = usual_spread.max((2.0 / free).sqrt()) / (0.7 * SQUARES_A_CELL as f32).sqrt();
        let differing = known.iter().filter(|e| (**e - 1.0).abs() > LEAST_EXCESS.max(SURE * error)).count();
        if known.len() < 4 || differing * 20 < known.len() {
            return None;
        }
        let cells = filled(&own, columns, rows);
        Some(Self { raised: with_borders(&cells), cells, cell_px })
    }

    /// Excess at the image's place (u, v), or that of a border beside it if that is larger.
    pub fn at(&self, u: f32, v: f32) -> f32 {
        sample_at(&self.raised, self.cell_px, u, v)
    }

    /// Excess at the image's place (u, v) as measured.
    pub fn measured_at(&self, u: f32, v: f32) -> f32 {
        sample_at(&self.cells, self.cell_px, u, v)
    }

    /// Smallest and largest measured excess.
    pub fn range(&self) -> (f32, f32) {
        let fold = |f: fn(f32, f32) -> f32| self.cells.data().iter().copied().reduce(f).unwrap_or(1.0);
        (fold(f32::min), fold(f32::max))
    }
}

/// Excess from a cell's ratios, sorted from the smallest to the largest; `None` where they are few or disagree.
fn trusted_excess(ratios: &[f32], free: f32) -> Option<f32> {
    let trusted = ratios.len() >= SQUARES_A_CELL / 2 && spread(ratios) <= TRUSTED_SPREAD * (2.0 / free).sqrt();
    trusted.then(|| quiet_variance(ratios.to_vec(), free))
}

/// Relative standard deviation from the quartiles of values sorted from the smallest to the largest.
fn spread(sorted: &[f32]) -> f32 {
    let quantile = |part: f32| sorted[((sorted.len() - 1) as f32 * part).round() as usize];
    // The quartiles of a normal distribution are 1.35 standard deviations apart.
    (quantile(0.75) - quantile(0.25)) / (1.35 * quantile(0.5).max(f32::MIN_POSITIVE))
}

/// All cells; those without an own value take the largest of their neighbours' values, step by step.
fn filled(own: &[Option<f32>], columns: usize, rows: usize) -> Plane {
    let mut cells = own.to_vec();
    while cells.iter().any(Option::is_none) && cells.iter().any(Option::is_some) {
        let before = cells.clone();
        for (index, cell) in cells.iter_mut().enumerate().filter(|(_, cell)| cell.is_none()) {
            let (x, y) = (index % columns, index / columns);
            let around = (y.saturating_sub(1)..(y + 2).min(rows))
                .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(columns)).map(move |x| y * columns + x));
            *cell = around.filter_map(|i| before[i]).reduce(f32::max);
        }
    }
    Plane::from_vec(columns, rows, cells.into_iter().map(|cell| cell.unwrap_or(1.0)).collect())
}

/// Cells, raised to a much larger excess beside them: a border between two excesses may lie anywhere in them.
fn with_borders(cells: &Plane) -> Plane {
    let (columns, rows) = cells.size();
    Plane::from_fn(columns, rows, |x, y| {
        let around = (y.saturating_sub(1)..(y + 2).min(rows))
            .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(columns)).map(move |x| cells.at(x, y)));
        let largest = around.fold(0.0, f32::max);
        if largest > BORDER * cells.at(x, y) { largest } else { cells.at(x, y) }
    })
}

#[cfg(test)]
mod tests {
    use super::super::high_pass::{FREE_VALUES, HighPass};
    use super::*;
    use crate::monitor::Monitor;
    use crate::synth::NoiseCase;

    const SIZE: (usize, usize) = (480, 360);

    fn squares(case: NoiseCase) -> Vec<Square> {
        let burst = case.burst(SIZE, 9, 0.02, 5, &Monitor::default()).expect("not cancelled");
        let high_pass = HighPass::new(&burst.frames.iter().map(|f| &**f).collect::<Vec<_>>());
        let thirds: Vec<Vec<f32>> =
            [0, 3, 6].map(|t| high_pass.variances(&[(t, 1.0), (t + 1, -2.0), (t + 2, 1.0)])).to_vec();
        let variance = |i: usize| thirds.iter().map(|v| v[i]).sum::<f32>() / 3.0;
        let each = high_pass.places.iter().zip(&high_pass.brightness[1]).enumerate();
        each.map(|(i, (&place, &brightness))| Square { place, brightness, variance: variance(i) }).collect()
    }

    fn map(squares: &[Square]) -> Option<ExcessMap> {
        let pairs: Vec<(f32, f32)> = squares.iter().map(|s| (s.brightness, s.variance)).collect();
        let free = 3.0 * FREE_VALUES;
        ExcessMap::find(squares, &PhotonTransfer::fit(&pairs, 256, free), SIZE, free)
    }

    #[test]
    fn the_same_noise_everywhere_needs_no_map() {
        for case in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::ClippedBlack] {
            assert_eq!(map(&squares(case)), None, "{case:?}");
        }
    }

    #[test]
    fn a_noisier_half_is_found_with_its_border() {
        let map = map(&squares(NoiseCase::NoisyHalf)).expect("the halves differ");
        let (left, right) = (map.at(60.0, 180.0), map.at(420.0, 180.0));
        assert!((right / left / 9.0 - 1.0).abs() < 0.25, "{left} {right}");
        assert!(map.at(236.0, 100.0) > 0.4 * right, "{} {right}", map.at(236.0, 100.0));
        let (min, max) = map.range();
        assert!(min <= left && right <= max);
    }

    #[test]
    fn texture_is_no_noise() {
        let mut squares = squares(NoiseCase::White);
        // Texture of various strengths in a corner.
        let in_corner = squares.iter_mut().filter(|s| s.place.0 < 150.0 && s.place.1 < 150.0);
        in_corner.enumerate().for_each(|(i, s)| s.variance *= 1.0 + (i % 7) as f32);
        assert_eq!(map(&squares), None);
    }
}
