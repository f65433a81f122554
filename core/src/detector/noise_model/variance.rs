//! Variance of the noise over brightness, and by place where it differs from that.
//!
//! Photon transfer: variance = a·I + b, since the number of photons varies by its square root; reading out adds b. The
//! quiet part of each group of equally bright squares gives a point. The line is fitted by the median slope between any
//! two (Theil–Sen), then by iteratively reweighted least squares, in which groups far from the line do not count. By
//! place: the excess is the median, over the nine squares around, of the variance over the predicted one. Squares that
//! differ from a steady rise by more than noise have texture or lie across a border: they take the largest excess of
//! trusted neighbours. Without the map `varying-6` has 734 false features a megapixel at the strict gate, not 6.

use super::high_pass::{Lattice, around, median, quiet_variance, sorted, spread};
use super::reading::sample_at;
use crate::plane::Plane;
use crate::plane::blur::{GaussianKernel, gaussian_blur};
use serde::{Serialize, Serializer};
use std::f64::consts::TAU;

/// Variance of one frame's noise over brightness: a line, or the parabola of bits.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PhotonTransfer {
    /// a: variance per brightness, fraction of full scale: one over the electrons at full scale. At least 0.
    pub slope: f32,
    /// b: variance at brightness 0, in (fraction of full scale)²; negative where black is lifted by more.
    pub dark: f32,
    /// Lower bound of the variance, in (fraction of full scale)².
    pub min: f32,
    /// Value of a set pixel, where pixels are 0 or that value: the variance at I is then I·(value − I).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bit: Option<f32>,
    /// Points to which the line was fitted, from dark to bright.
    pub points: Vec<TransferPoint>,
}

/// Group of squares of about equal brightness.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TransferPoint {
    /// Mean brightness, fraction of full scale.
    pub brightness: f32,
    /// Variance of the noise of one frame, in (fraction of full scale)².
    pub variance: f32,
    /// Number of squares in the group, its weight in the fit.
    pub squares: usize,
}

/// Squares of a group at least, and groups at most.
const MIN_SQUARES: usize = 24;
const MAX_GROUPS: usize = 16;
const FAR: f64 = 0.4;
/// Minimum span of the groups, in standard deviations of a square's brightness: equal brightnesses span four.
const MIN_SPAN: f64 = 7.0;
const FITS: usize = 12;

impl PhotonTransfer {
    /// Fits squares of brightness and variance, of `pixels` values, `free` of them independent. All 0 without squares.
    pub(super) fn fit(squares: &[(f32, f32)], pixels: usize, free: f32) -> Self {
        let mut sorted = squares.to_vec();
        sorted.sort_by(|x, y| x.0.total_cmp(&y.0));
        let groups = (sorted.len() / MIN_SQUARES).clamp(1, MAX_GROUPS);
        let points: Vec<TransferPoint> = (0..groups)
            .map(|g| &sorted[g * sorted.len() / groups..(g + 1) * sorted.len() / groups])
            .filter(|group| !group.is_empty())
            .map(|group| {
                let mean = |of: fn(&(f32, f32)) -> f32| group.iter().map(of).sum::<f32>() / group.len() as f32;
                let quiet = quiet_variance(group.iter().map(|s| s.1).collect(), free);
                // Files may round the quiet part away nearly everywhere.
                let variance = if quiet > 0.0 { quiet } else { mean(|s| s.1) };
                TransferPoint { brightness: mean(|s| s.0), variance, squares: group.len() }
            })
            .collect();
        let (slope, dark) = line(&points, pixels, free);
        let min = 0.5 * points.iter().map(|p| p.variance).reduce(f32::min).unwrap_or(0.0);
        Self { slope, dark, min, bit: None, points }
    }

    /// Curve of pixels that are 0 or `bit`: a pixel is set with probability I/bit, so the variance is I·(bit − I). Only
    /// the darkest groups show how small it becomes.
    pub(super) fn of_bits(self, bit: f32) -> Self {
        let of_bits = Self { slope: bit, dark: 0.0, min: 0.0, bit: Some(bit), points: self.points };
        let least = of_bits.points.iter().map(|p| of_bits.variance(p.brightness)).reduce(f32::min);
        Self { min: 0.5 * least.unwrap_or(0.0), ..of_bits }
    }

    /// Curve with one `variance`, squared fractions of full scale, at all brightnesses.
    pub(super) fn even(variance: f32) -> Self {
        Self { dark: variance, ..Self::default() }
    }

    /// Relative growth of a gate of `gate` standard deviations by the skewness of the mean of `frames` frames of bits,
    /// in the darkest or brightest group, behind the difference of two Gaussians of `variances`, pixels²: the first
    /// term of the Cornish–Fisher expansion. 0 for noise that is not of bits.
    pub(super) fn skewed(&self, [low, high]: [f64; 2], frames: usize, gate: f32) -> f32 {
        let Some(bit) = self.bit else { return 0.0 };
        let of_pixel = |p: &TransferPoint| (bit - 2.0 * p.brightness).abs() / self.variance(p.brightness).sqrt();
        let skewness = self.points.iter().map(of_pixel).fold(0.0, f32::max) / (frames as f32).sqrt();
        // Σh³ and Σh², as integrals of products of Gaussians.
        let three = |a: f64, b: f64, c: f64| 1.0 / (TAU * TAU * (a * b + b * c + c * a));
        let two = |a: f64, b: f64| 1.0 / (TAU * (a + b));
        let third =
            three(low, low, low) - 3.0 * three(low, low, high) + 3.0 * three(low, high, high) - three(high, high, high);
        let left = third / (two(low, low) - 2.0 * two(low, high) + two(high, high)).powf(1.5);
        skewness * left as f32 * (gate * gate - 1.0).max(0.0) / (6.0 * gate.max(1.0))
    }

    /// Variance of the noise of one frame at `brightness`, both as fractions of full scale; at least `min`.
    pub fn variance(&self, brightness: f32) -> f32 {
        let variance = self.bit.map_or(self.slope * brightness + self.dark, |bit| brightness * (bit - brightness));
        variance.max(self.min)
    }
}

/// Slope and offset; the slope is 0 below three times its error, or where the brightness hardly differs.
fn line(points: &[TransferPoint], pixels: usize, free: f32) -> (f32, f32) {
    let total = points.iter().map(|p| p.squares).sum::<usize>() as f64;
    let mean = points.iter().map(|p| f64::from(p.variance) * p.squares as f64).sum::<f64>() / total.max(1.0);
    if mean <= 0.0 {
        return (0.0, 0.0);
    }
    let floor = 1e-3 * mean;
    let span = points[points.len() - 1].brightness - points[0].brightness;
    if f64::from(span) < MIN_SPAN * (mean / pixels as f64).sqrt() {
        return (0.0, mean as f32);
    }
    // Started from medians: least squares alone would follow groups of texture and stay there.
    let (mut a, mut b) = median_line(points);
    let mut error = f64::INFINITY;
    for _ in 0..FITS {
        let mut sums = [0.0f64; 5];
        for p in points {
            let (x, y) = (f64::from(p.brightness), f64::from(p.variance));
            let expected = (a * x + b).max(floor);
            let off = ((y / expected - 1.0) / FAR).abs().min(1.0);
            // In relative errors; that of a group of n squares is √(2/(free·n)).
            let weight = p.squares as f64 / (expected * expected) * (1.0 - off * off).powi(2);
            sums.iter_mut().zip([1.0, x, x * x, y, x * y]).for_each(|(sum, term)| *sum += weight * term);
        }
        let [n, x, xx, y, xy] = sums;
        if n <= 0.0 {
            break;
        }
        // One brightness alone determines no slope.
        let across = xx - x * x / n;
        if across <= 1e-12 * xx {
            return (0.0, (y / n) as f32);
        }
        a = (xy - x * y / n) / across;
        b = (y - a * x) / n;
        // More photons never lower the noise: a falling line has no meaning as a slope.
        if a < 0.0 {
            (a, b) = (0.0, y / n);
        }
        let off = |p: &TransferPoint| {
            let expected = (a * f64::from(p.brightness) + b).max(floor);
            p.squares as f64 * (f64::from(p.variance) / expected - 1.0).powi(2).min(FAR * FAR)
        };
        // The residual expected of noise alone, or the measured one if larger.
        let noise = 2.0 / (0.7 * f64::from(free));
        let left = points.iter().map(off).sum::<f64>() / (points.len() as f64 - 2.0).max(1.0);
        error = (noise.max(left) / across).sqrt();
    }
    if a < 3.0 * error { (0.0, mean as f32) } else { (a as f32, b as f32) }
}

/// Slope and offset by the median slope between any two points, and the median offset for that slope.
fn median_line(points: &[TransferPoint]) -> (f64, f64) {
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let at: Vec<(f64, f64)> = points.iter().map(|p| (f64::from(p.brightness), f64::from(p.variance))).collect();
    let pairs = at.iter().enumerate().flat_map(|(i, p)| at[..i].iter().map(move |q| (p, q)));
    let slopes = pairs.filter(|(p, q)| p.0 > q.0).map(|(p, q)| (p.1 - q.1) / (p.0 - q.0));
    let a = middle(slopes.collect()).max(0.0);
    (a, middle(at.iter().map(|(x, y)| y - a * x).collect()))
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Centre, image pixels.
    pub place: (f32, f32),
    /// Brightness, fraction of full scale.
    pub brightness: f32,
    /// Variance of the noise of one frame there, in (fraction of full scale)².
    pub variance: f32,
}

/// Variance relative to the prediction by brightness, by place: for noise that differs by place more than by light.
#[derive(Debug, Clone, PartialEq)]
pub struct ExcessMap {
    /// As measured.
    cells: Plane,
    /// Values as the filters of octaves 0, 1, … collect them; cells beside a border are raised to the larger side.
    by_octave: Vec<Plane>,
    cell_px: f32,
    /// First pixel of the first cell, which has its square in the middle.
    first_px: f32,
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

const MIN_EXCESS: f32 = 0.2;
/// Roughness of the logarithm of the excess around a square, relative to noise's, up to which it is trusted.
const TRUSTED_ROUGHNESS: f32 = 1.8;
/// Difference from 1, in units of its error, above which an excess is significant.
const SURE: f32 = 4.0;
/// Ratio of a neighbour's excess to its own above which a cell is at a border and takes the neighbour's.
const BORDER: f32 = 1.4;
/// Spread of the squares' excess, relative to that of noise, up to which no map is needed.
const EVEN_SPREAD: f32 = 1.25;
/// Reach of the noise that a filter collects, as the standard deviation of its square, in pixels of its octave.
const COLLECTED: f32 = 2.0;
const OCTAVES: i32 = 6;

pub fn differ_by_place(squares: &[Square], transfer: &PhotonTransfer, free: f32) -> bool {
    let ratios = sorted(squares.iter().map(|square| square.excess(transfer)).collect());
    ratios.len() >= 16 && spread(&ratios) > EVEN_SPREAD * (2.0 / free).sqrt()
}

impl Square {
    /// Variance relative to the predicted one; 1 where that is 0.
    fn excess(&self, transfer: &PhotonTransfer) -> f32 {
        let predicted = transfer.variance(self.brightness);
        if predicted > 0.0 { self.variance / predicted } else { 1.0 }
    }
}

impl ExcessMap {
    /// Excess of the squares of a `lattice`, each of `free` independent values; `None` where none is significant.
    pub(super) fn find(squares: &[Square], lattice: Lattice, transfer: &PhotonTransfer, free: f32) -> Option<Self> {
        let Lattice { columns, rows, pitch } = lattice;
        if columns < 4 || rows < 4 {
            return None;
        }
        let ratios = Plane::from_vec(columns, rows, squares.iter().map(|square| square.excess(transfer)).collect());
        let own: Vec<Option<f32>> = (0..columns * rows)
            .map(|i| {
                let (x, y) = (i % columns, i / columns);
                let expected = (2.0 / free).sqrt();
                (roughness(&ratios, (x, y)) <= TRUSTED_ROUGHNESS * expected).then(|| {
                    // The median of a mean of squares lies below its mean.
                    median(around((x, y), (columns, rows)).map(|(x, y)| ratios.at(x, y)).collect())
                        / (1.0 - 2.0 / (3.0 * free))
                })
            })
            .collect();
        let known: Vec<f32> = own.iter().copied().flatten().collect();
        // Where squares mostly disagree, as under texture or the few coefficients of a file, nothing is known.
        if 2 * known.len() < own.len() {
            return None;
        }
        let error = 1.25 * (2.0 / free).sqrt() / 3.0;
        let differing = known.iter().filter(|e| (**e - 1.0).abs() > MIN_EXCESS.max(SURE * error)).count();
        // Single cells exceed any limit by chance, so a twentieth of them must.
        if differing * 20 < known.len() {
            return None;
        }
        let cells = filled(&own, columns, rows);
        let cell_px = pitch as f32;
        let raised = with_borders(&cells);
        let collected = |octave: i32| {
            let reach = COLLECTED * (octave as f32).exp2() / cell_px;
            if reach < 0.4 { raised.clone() } else { gaussian_blur(&raised, &GaussianKernel::new(f64::from(reach))) }
        };
        Some(Self { by_octave: (0..OCTAVES).map(collected).collect(), cells, cell_px, first_px: lattice.first_px() })
    }

    /// Excess that the filters of `octave` collect around the image's place (u, v); `None`: as measured.
    pub(super) fn at(&self, octave: Option<i32>, u: f32, v: f32) -> f32 {
        let map = octave.map_or(&self.cells, |octave| &self.by_octave[octave.clamp(0, OCTAVES - 1) as usize]);
        sample_at(map, self.cell_px, u - self.first_px, v - self.first_px)
    }

    pub(super) fn range(&self) -> (f32, f32) {
        let fold = |f: fn(f32, f32) -> f32| self.cells.data().iter().copied().reduce(f).unwrap_or(1.0);
        (fold(f32::min), fold(f32::max))
    }
}

/// Deviation of the logarithm of a ratio that explains the second differences around it: a steady rise has none.
fn roughness(ratios: &Plane, (x, y): (usize, usize)) -> f32 {
    let (columns, rows) = ratios.size();
    let log = |x: usize, y: usize| ratios.at(x, y).max(1e-6).ln();
    let second = |a: f32, b: f32, c: f32| (a - 2.0 * b + c).powi(2) / 6.0;
    let (x, y) = (x.clamp(1, columns - 2), y.clamp(1, rows - 2));
    let rows = (y - 1..y + 2).map(|y| second(log(x - 1, y), log(x, y), log(x + 1, y)));
    let columns = (x - 1..x + 2).map(|x| second(log(x, y - 1), log(x, y), log(x, y + 1)));
    ((rows.sum::<f32>() + columns.sum::<f32>()) / 6.0).sqrt()
}

/// All cells; those without an own value take the largest of their neighbours' values, step by step.
fn filled(own: &[Option<f32>], columns: usize, rows: usize) -> Plane {
    let mut cells = own.to_vec();
    while cells.iter().any(Option::is_none) && cells.iter().any(Option::is_some) {
        let before = cells.clone();
        for (index, cell) in cells.iter_mut().enumerate().filter(|(_, cell)| cell.is_none()) {
            let (x, y) = (index % columns, index / columns);
            *cell = around((x, y), (columns, rows)).filter_map(|(x, y)| before[y * columns + x]).reduce(f32::max);
        }
    }
    Plane::from_vec(columns, rows, cells.into_iter().map(|cell| cell.unwrap_or(1.0)).collect())
}

/// Cells, raised to a much larger excess beside them: a border between two excesses may lie anywhere in them.
fn with_borders(cells: &Plane) -> Plane {
    let (columns, rows) = cells.size();
    Plane::from_fn(columns, rows, |x, y| {
        let largest = around((x, y), (columns, rows)).map(|(x, y)| cells.at(x, y)).fold(0.0, f32::max);
        if largest > BORDER * cells.at(x, y) { largest } else { cells.at(x, y) }
    })
}

#[cfg(test)]
mod tests {
    use super::super::high_pass::{FREE_VALUES, HighPass};
    use super::*;
    use crate::monitor::Monitor;
    use crate::synth::Camera;
    use crate::synth::random::Stream;

    fn camera(full_scale_electrons: f64, read_noise_electrons: f64, black_level: f64) -> Camera {
        Camera { full_scale_electrons, read_noise_electrons, black_level, bits: Some(14) }
    }

    fn squares(camera: &Camera, signal: &Plane) -> Vec<(f32, f32)> {
        let frames: Vec<Plane> = (1..=3)
            .map(|t| camera.capture(signal, &mut Stream::new(9, t), &Monitor::default()).expect("not cancelled"))
            .collect();
        let squares = HighPass::new(&frames.iter().collect::<Vec<_>>());
        let variances = squares.variances(&[(0, 1.0), (1, -2.0), (2, 1.0)]);
        squares.brightness[1].iter().copied().zip(variances).collect()
    }

    #[test]
    fn sensors_of_known_slope_and_offset_are_found() {
        for (electrons, read_noise) in [(500.0, 4.0), (2000.0, 20.0), (15_000.0, 3.0)] {
            let camera = camera(electrons, read_noise, 0.0625);
            let signal = Plane::from_fn(640, 400, |u, _| 0.8 * (u as f32 / 640.0).powi(2));
            let fit = PhotonTransfer::fit(&squares(&camera, &signal), 256, FREE_VALUES);
            let a = 1.0 / electrons;
            let b = (read_noise * read_noise / electrons - camera.black_level) / electrons;
            assert!((f64::from(fit.slope) / a - 1.0).abs() < 0.08, "{electrons}: {fit:?}");
            for signal in [0.02, 0.2, 0.7] {
                let brightness = signal + camera.black_level;
                let expected = a * brightness + b;
                let got = f64::from(fit.variance(brightness as f32));
                assert!((got / expected - 1.0).abs() < 0.12, "{electrons} {signal}: {got} {expected}");
            }
        }
    }

    #[test]
    fn noise_that_knows_no_brightness_has_no_slope() {
        let mut stream = Stream::new(1, 0);
        let frame = Plane::from_fn(640, 400, |u, _| u as f32 / 640.0 + 0.01 * stream.normal() as f32);
        let squares = HighPass::new(&[&frame]);
        let pairs: Vec<(f32, f32)> =
            squares.brightness[0].iter().copied().zip(squares.variances(&[(0, 1.0)])).collect();
        let fit = PhotonTransfer::fit(&pairs, 256, FREE_VALUES);
        assert_eq!(fit.slope, 0.0);
        assert!((fit.dark / 1e-4 - 1.0).abs() < 0.05, "{fit:?}");
    }

    #[test]
    fn clipped_black_and_texture_bend_nothing() {
        // The darkest tenth is so dark that half of its noise is cut off, a seventh of all squares has texture.
        let camera = camera(1000.0, 20.0, 0.0);
        let signal = Plane::from_fn(640, 400, |u, _| (0.6 * (u as f32 - 64.0) / 576.0).max(0.0));
        let mut pairs = squares(&camera, &signal);
        pairs.iter_mut().step_by(7).for_each(|p| p.1 *= 8.0);
        let fit = PhotonTransfer::fit(&pairs, 256, FREE_VALUES);
        assert!((fit.slope / 1e-3 - 1.0).abs() < 0.3, "{fit:?}");
        assert!((fit.variance(0.3) / (0.3e-3 + 0.4e-3) - 1.0).abs() < 0.12, "{fit:?}");
    }
}
