//! Stripes: columns and rows with an offset of their own, as from converters that serve one column each.

use serde::Serialize;

/// Offsets of columns or rows, as far as they change within [`REACH`] of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stripes {
    /// Offset of each column or row, fraction of full scale.
    pub offsets: Vec<f32>,
    /// Standard deviation of the offsets.
    pub deviation: f32,
}

/// Number of columns to each side from whose mean an offset is measured: slower changes may be the scene.
pub const REACH: usize = 16;
/// Number of standard errors above which the stripes that both halves share are significant.
const STRIPES: f32 = 6.0;

impl Stripes {
    /// Finds the stripes that the means over [bands](super::reading::BANDS) of both halves of a burst share; `None` if
    /// there are none, or they are smooth as a scene is.
    pub fn find(halves: &[Vec<Vec<f32>>; 2]) -> Option<Self> {
        let [first, second] = halves.each_ref().map(|bands| offsets(bands));
        let n = first.len() as f32;
        let product = |shift: usize| first.iter().zip(&second[shift..]).map(|(a, b)| a * b).sum::<f32>() / n;
        let power = |x: &[f32]| x.iter().map(|x| x * x).sum::<f32>() / n;
        let common = product(0);
        let error = (power(&first) * power(&second) / n).sqrt();
        if common <= STRIPES * error || product(1) > 0.4 * common || product(2) > 0.4 * common {
            return None;
        }
        let both: Vec<f32> = first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b)).collect();
        Some(Self { offsets: both, deviation: common.sqrt() })
    }
}

/// Difference of each column from those around it: the median over the bands.
fn offsets(bands: &[Vec<f32>]) -> Vec<f32> {
    let sharp: Vec<Vec<f32>> = bands.iter().map(|band| less_local_mean(band)).collect();
    (0..bands[0].len())
        .map(|u| {
            let mut values: Vec<f32> = sharp.iter().map(|band| band[u]).collect();
            values.sort_by(f32::total_cmp);
            0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
        })
        .collect()
}

/// Subtracts from each value the mean of those within [`REACH`].
fn less_local_mean(values: &[f32]) -> Vec<f32> {
    let mut sums = vec![0.0f64];
    for x in values {
        sums.push(sums[sums.len() - 1] + f64::from(*x));
    }
    (0..values.len())
        .map(|u| {
            let (start, end) = (u.saturating_sub(REACH), (u + REACH + 1).min(values.len()));
            values[u] - ((sums[end] - sums[start]) / (end - start) as f64) as f32
        })
        .collect()
}
