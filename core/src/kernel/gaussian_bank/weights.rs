//! Weights of the levels of a chain of blurs: their kernels inside an image, and the chain's own weights near a border.
//!
//! Inside, a level's kernel is the convolution of the chain's kernels. Near a border each blur of the chain repeats the
//! nearest pixel of its input: a clamped convolution, a matrix. Rows of the product of these matrices are the weights.

use crate::kernel::machine::WIDEST_VECTOR as VECTOR;
use crate::{kernel::gaussian_bank::FilterBank, plane::blur::GaussianKernel};
use std::ops::Range;

/// Weights of one level for outputs near a border: `weights[(input − ins.start)·stride + output − outs.start]`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Dense {
    pub outs: Range<usize>,
    pub ins: Range<usize>,
    pub stride: usize,
    pub weights: Vec<f32>,
    /// Inputs farther than this from an output have no weight.
    pub radius: usize,
}

impl Dense {
    /// The weights with which input `input` enters the outputs, from output `outs.start` on.
    #[inline(always)]
    pub fn row(&self, input: usize) -> &[f32] {
        &self.weights[(input - self.ins.start) * self.stride..][..self.stride]
    }

    #[inline(always)]
    pub fn inputs(&self, outs: &Range<usize>) -> Range<usize> {
        outs.start.saturating_sub(self.radius).max(self.ins.start)..(outs.end + self.radius).min(self.ins.end)
    }

    fn mirrored(&self, n: usize) -> Self {
        let flip = |range: &Range<usize>| n - range.end..n - range.start;
        let mut out =
            Self { outs: flip(&self.outs), ins: flip(&self.ins), weights: vec![0.0; self.weights.len()], ..*self };
        let (inputs, outputs) = (self.ins.len(), self.outs.len());
        for input in 0..inputs {
            for output in 0..outputs {
                out.weights[(inputs - 1 - input) * self.stride + outputs - 1 - output] =
                    self.weights[input * self.stride + output];
            }
        }
        out
    }
}

/// Weights of all levels near the first border of a line: up to the level's radius from it.
#[derive(Debug, Clone)]
pub(crate) struct Edges {
    levels: Vec<Dense>,
    /// Minimum number of pixels of a line for which the other border has no effect.
    far: usize,
}

impl Edges {
    pub fn far_apart(chain: &[GaussianKernel], wanted: &Range<usize>, kernels: &[GaussianKernel]) -> Self {
        let radius = kernels.iter().map(GaussianKernel::radius).max().unwrap_or(0);
        let chain_radius: usize = chain[..wanted.end].iter().map(GaussianKernel::radius).sum();
        Self::of_line(chain, wanted, kernels, 2 * radius + chain_radius + 1)
    }

    /// Weights for a line of `n` pixels; a level that reaches from border to border gets those of all its outputs.
    fn of_line(chain: &[GaussianKernel], wanted: &Range<usize>, kernels: &[GaussianKernel], n: usize) -> Self {
        let mut levels: Vec<Dense> = kernels
            .iter()
            .map(|kernel| {
                let radius = kernel.radius();
                let outs = if n <= 2 * radius { n } else { radius };
                let (inputs, stride) = ((outs + radius).min(n), outs.next_multiple_of(VECTOR));
                Dense { outs: 0..outs, ins: 0..inputs, stride, weights: vec![0.0; inputs * stride], radius }
            })
            .collect();
        let inputs = levels.iter().map(|level| level.ins.end).max().unwrap_or(0);
        let steps: Vec<Vec<f64>> = chain[..wanted.end].iter().map(|step| all_taps(step.half())).collect();
        // The response of the chain to one pixel is that pixel's column of the matrix.
        for input in 0..inputs {
            let mut signal = vec![0.0; n];
            signal[input] = 1.0;
            let mut support = input..input + 1;
            for (index, taps) in steps.iter().enumerate() {
                (signal, support) = blurred(&signal, support, taps);
                let Some(level) = index.checked_sub(wanted.start).map(|at| &mut levels[at]) else { continue };
                if input >= level.ins.end {
                    continue;
                }
                let made = support.start..support.end.min(level.outs.end).max(support.start);
                for (output, &weight) in made.clone().zip(&signal[made]) {
                    if output.abs_diff(input) <= level.radius {
                        level.weights[input * level.stride + output] = weight as f32;
                    }
                }
            }
        }
        // The cut at the radius loses a little weight; flat areas must stay flat.
        for level in &mut levels {
            for output in level.outs.clone() {
                let column = || (0..level.ins.end).map(|input| input * level.stride + output);
                let sum: f64 = column().map(|at| f64::from(level.weights[at])).sum();
                let places: Vec<usize> = column().collect();
                places.into_iter().for_each(|at| level.weights[at] = (f64::from(level.weights[at]) / sum) as f32);
            }
        }
        Self { levels, far: n }
    }
}

/// A line that is 0 outside `support`, convolved with `taps`, its nearest pixel repeated; and the new support.
fn blurred(signal: &[f64], support: Range<usize>, taps: &[f64]) -> (Vec<f64>, Range<usize>) {
    let (n, radius) = (signal.len(), taps.len() / 2);
    let mut out = vec![0.0; n];
    let reached = support.start.saturating_sub(radius)..(support.end + radius).min(n);
    for at in reached.clone() {
        // Tap k reads place at + k − radius; taps before the first place or behind the last read the first or last.
        let first = (support.start + radius).saturating_sub(at);
        let last = (support.end + radius - at).min(taps.len());
        let inside = first.max(radius.saturating_sub(at))..last.min(n + radius - at);
        let mut sum = 0.0;
        if !inside.is_empty() {
            let from = at + inside.start - radius;
            sum = taps[inside.clone()].iter().zip(&signal[from..]).map(|(tap, value)| tap * value).sum();
        }
        if support.start == 0 && at < radius {
            sum += signal[0] * taps[..radius - at].iter().sum::<f64>();
        }
        if support.end == n && at + radius >= n {
            sum += signal[n - 1] * taps[n + radius - at..].iter().sum::<f64>();
        }
        out[at] = sum;
    }
    (out, reached)
}

#[derive(Debug)]
pub(crate) struct Weights {
    /// The centre tap and those to one side, where no border is near.
    pub half: Vec<f32>,
    /// Weights of the first outputs, or of all of them.
    pub head: Dense,
    pub tail: Dense,
}

impl Weights {
    /// Parts of `range` of a line of `n` pixels, by the weights that apply to each.
    pub fn sections(&self, range: &Range<usize>, n: usize) -> [(Section, Range<usize>); 3] {
        let inner = self.head.outs.end..n - self.tail.outs.len();
        let part = |section: Range<usize>| {
            let start = range.start.max(section.start);
            start..range.end.min(section.end).max(start)
        };
        [
            (Section::Head, part(0..inner.start)),
            (Section::Inner, part(inner.clone())),
            (Section::Tail, part(inner.end..n)),
        ]
    }
}

/// A bank's weights along a line of pixels: plain kernels inside, the chain's own weights near the ends.
#[derive(Debug)]
pub struct Axis {
    pub(crate) n: usize,
    /// Pixels to each side that a value depends on.
    pub(crate) radius: usize,
    pub(crate) levels: Vec<Weights>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Section {
    Head,
    Inner,
    Tail,
}

impl FilterBank {
    pub fn axis(&self, n: usize) -> Axis {
        let own;
        // In a short line both borders reach the same pixels, so that the weights depend on its length.
        let edges = if n < self.edges.far {
            own = Edges::of_line(&self.chain, &self.wanted, &self.kernels, n);
            &own
        } else {
            &self.edges
        };
        let weights = |(kernel, head): (&GaussianKernel, &Dense)| Weights {
            half: kernel.half().to_vec(),
            head: head.clone(),
            tail: if head.outs.len() < n { head.mirrored(n) } else { Dense::default() },
        };
        Axis { n, radius: self.radius(), levels: self.kernels.iter().zip(&edges.levels).map(weights).collect() }
    }
}

impl Axis {
    /// `range` widened by the radius, inside the line.
    pub fn inputs(&self, range: &Range<usize>) -> Range<usize> {
        range.start.saturating_sub(self.radius)..(range.end + self.radius).min(self.n)
    }
}

pub(crate) fn all_taps(half: &[f32]) -> Vec<f64> {
    half.iter().skip(1).rev().chain(half).map(|&tap| f64::from(tap)).collect()
}

/// Kernels of all levels of `chain`, each cut at `cut` of its standard deviations. Radii never decrease.
pub(crate) fn composed(chain: &[GaussianKernel], cut: f64) -> Vec<GaussianKernel> {
    let mut taps = vec![1.0f64];
    let mut radius = 0;
    chain
        .iter()
        .map(|step| {
            taps = convolved(&taps, &all_taps(step.half()));
            let middle = taps.len() / 2;
            let variance: f64 = taps.iter().enumerate().map(|(i, tap)| tap * (i as f64 - middle as f64).powi(2)).sum();
            // Never below the radius before: passes rely on radii that rise with the level.
            radius = ((cut * variance.sqrt()).ceil() as usize).clamp(radius, middle.max(radius));
            let half = &taps[middle..=(middle + radius).min(taps.len() - 1)];
            let sum = half[0] + 2.0 * half[1..].iter().sum::<f64>();
            GaussianKernel::of_half(half.iter().map(|tap| (tap / sum) as f32).collect())
        })
        .collect()
}

fn convolved(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; a.len() + b.len() - 1];
    for (i, a) in a.iter().enumerate() {
        b.iter().enumerate().for_each(|(j, b)| out[i + j] += a * b);
    }
    out
}
