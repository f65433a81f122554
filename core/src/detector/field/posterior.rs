//! Posterior of the motion of each cell, given the evidence of all cells.
//!
//! Neighbouring cells mostly move alike: from cell to cell a motion wanders a little ([`WANDER`]) around the
//! [`drift`](Posterior::drift) of the whole picture, and seldom, at the border of a thing, it becomes any other
//! ([`BORDER`]). Between the cells of a tree such a model is solved exactly, by passing messages along its branches
//! (Pearl, "Probabilistic Reasoning in Intelligent Systems", 1988). Each cell has two trees, which hold all cells: its
//! column with the rows as branches, and its row with the columns (Bleyer and Gelautz, "Simple but effective tree
//! structures for dynamic programming-based stereo matching", 2008). Their geometric mean has no preferred direction.
//!
//! So there is no window in which everything moves alike: evidence reaches as far as nothing speaks against it.

use super::evidence::summed;
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use multiversion::multiversion;
use rayon::prelude::*;

/// Probability that a motion goes to the next candidate on one side, from cell to cell.
const WANDER: f32 = 0.05;
/// Probability that the next cell moves in any other way.
const BORDER: f32 = 0.02;
/// Largest evidence against a motion in a single cell, nats.
const MOST_AGAINST: f32 = 30.0;
/// Cells on a side of the blocks whose motions give the drift.
const BLOCK_CELLS: usize = 4;
/// [`WANDER`] between such blocks.
const BLOCK_WANDER: f32 = 0.2;
/// Number of blocks over which their motions are compared.
const BLOCKS_APART: usize = 2;
/// Change of the motion over these blocks from which it is a border, steps of the sweep.
const BORDER_STEPS: f32 = 1.5;
/// Variance of such a change besides those of the motions, squared steps.
const CHANGE_VARIANCE: f32 = 0.25;

/// Possible motions of a cell: the slopes of a sweep, and on a line the slopes between.
#[derive(Clone, Copy)]
pub(super) struct Candidates {
    /// Number along u and v.
    pub count: [usize; 2],
    /// Number for each step of the sweep.
    pub per_step: usize,
}

/// Motion of a cell in coordinates of the sweep's grid, steps, and its covariance (of u, of u with v, of v).
#[derive(Clone, Copy)]
pub(super) struct MotionEstimate {
    pub at: [f32; 2],
    pub covariance: [f32; 3],
}

pub(super) struct Posterior {
    candidates: Candidates,
    /// Cell by cell, row by row.
    probabilities: Vec<f32>,
}

impl Candidates {
    fn len(&self) -> usize {
        self.count[0] * self.count[1]
    }

    /// Likelihoods of the candidates, cell by cell, from the evidence of each swept slope.
    fn likelihoods(&self, nats: &[Plane]) -> Vec<f32> {
        let (width, height) = nats[0].size();
        let (count, [columns, _]) = (self.len(), self.count);
        let swept = (columns - 1) / self.per_step + 1;
        let mut all = vec![0.0f32; width * height * count];
        all.par_chunks_mut(width * count).enumerate().for_each(|(v, row)| {
            for candidate in 0..count {
                let (i, j) = (candidate % columns, candidate / columns);
                let nearest = |x: usize| [x / self.per_step, x.div_ceil(self.per_step)];
                let [[i, i_next], [j, j_next]] = [nearest(i), nearest(j)];
                let (below, above) = (nats[j * swept + i].row(v), nats[j_next * swept + i_next].row(v));
                let between = below.iter().zip(above).map(|(a, b)| 0.5 * (a + b));
                row[candidate..].iter_mut().step_by(count).zip(between).for_each(|(out, nats)| *out = nats);
            }
            for cell in row.chunks_mut(count) {
                // Only ratios count; relative to the largest no exponential overflows.
                let most = cell.iter().fold(f32::NEG_INFINITY, |most, &x| if x > most { x } else { most });
                cell.iter_mut().for_each(|x| *x = (*x - most).max(-MOST_AGAINST).exp());
            }
        });
        all
    }

    /// Replaces the likelihoods of each chain of `length` cells by the posteriors given all cells of the chain.
    fn along_chains(&self, all: &mut [f32], length: usize, model: &Model, monitor: &Monitor) -> Result<(), Cancelled> {
        let (count, taps) = (self.len(), [model.taps(1.0), model.taps(-1.0)]);
        let messages = || vec![0.0; (length + 3) * count];
        all.par_chunks_mut(length * count).try_for_each_init(messages, |messages, chain| {
            monitor.check()?;
            along_chain(chain, messages, self.count, &taps);
            Ok(())
        })
    }

    /// Motion that `probabilities` favour: the mean around the largest one, with a covariance over all of them.
    pub fn found(&self, probabilities: &[f32]) -> MotionEstimate {
        let columns = self.count[0];
        let larger = |best: usize, (index, x): (usize, &f32)| if *x > probabilities[best] { index } else { best };
        let best = probabilities.iter().enumerate().fold(0, larger);
        let (best_i, best_j) = ((best % columns) as f32, (best / columns) as f32);
        let reach = self.per_step as f32;
        let (mut near, mut all) = ([[0.0f32; 3]; 2], [0.0f32; 6]);
        for (j, row) in probabilities.chunks(columns).enumerate() {
            let dj = j as f32 - best_j;
            let mut moments = [0.0f32; 3];
            for (i, &x) in row.iter().enumerate() {
                let di = i as f32 - best_i;
                moments.iter_mut().zip([x, x * di, x * di * di]).for_each(|(sum, x)| *sum += x);
                if di.abs() <= 1.0 && dj.abs() <= 1.0 {
                    near[0][(di + 1.0) as usize] += x;
                    near[1][(dj + 1.0) as usize] += x;
                }
            }
            let [x, u, uu] = moments;
            all.iter_mut().zip([x, u, dj * x, uu, dj * u, dj * dj * x]).for_each(|(sum, x)| *sum += x);
        }
        let [du, dv] = near.map(|[a, b, c]| {
            // At an end of the range, or where a neighbour underflows, only the mean remains.
            if a <= 0.0 || c <= 0.0 {
                return (c - a) / (a + b + c);
            }
            // The peak of a Gaussian is a parabola in the logarithm.
            let [a, b, c] = [a, b, c].map(f32::ln);
            (0.5 * (c - a) / (2.0 * b - a - c).max(1e-6)).clamp(-0.6, 0.6)
        });
        // Moments are about the largest candidate; the covariance is about the refined motion.
        let [u, v, uu, uv, vv] = [1, 2, 3, 4, 5].map(|index| all[index] / all[0]);
        let step = 1.0 / reach;
        let covariance = [uu - du * (2.0 * u - du), uv - du * v - dv * u + du * dv, vv - dv * (2.0 * v - dv)];
        MotionEstimate {
            at: [step * (best_i + du), step * (best_j + dv)],
            covariance: covariance.map(|x| step * step * x),
        }
    }
}

/// Replaces the likelihoods of a chain's cells, `counts` values each, by their posteriors given all of them, with the
/// weights `taps` from each cell to the next and back. `messages` holds one more for each cell, and three.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2+fma", "aarch64+neon"))]
fn along_chain(chain: &mut [f32], messages: &mut [f32], counts: [usize; 2], [forth, back]: &[[[f32; 3]; 2]; 2]) {
    let count = counts[0] * counts[1];
    let (before, rest) = messages.split_at_mut(chain.len());
    let (belief, rest) = rest.split_at_mut(count);
    let (after, scratch) = rest.split_at_mut(count);
    // Messages to each cell from the cells before.
    before[..count].fill(1.0 / count as f32);
    for (cell, likelihood) in chain.chunks(count).enumerate().take(chain.len() / count - 1) {
        let (said, next) = before[cell * count..].split_at_mut(count);
        belief.iter_mut().zip(likelihood).zip(said).for_each(|((belief, l), said)| *belief = l * *said);
        pass(belief, scratch, &mut next[..count], counts, forth);
    }
    // Backwards, each cell's posterior is complete as soon as the message from behind has come.
    after.fill(1.0 / count as f32);
    for (cell, before) in chain.chunks_mut(count).zip(before.chunks(count)).rev() {
        belief.iter_mut().zip(&*cell).zip(&*after).for_each(|((belief, l), after)| *belief = l * after);
        cell.iter_mut().zip(&*belief).zip(before).for_each(|((cell, belief), before)| *cell = belief * before);
        let scale = 1.0 / sum(cell);
        cell.iter_mut().for_each(|x| *x *= scale);
        pass(belief, scratch, after, counts, back);
    }
}

/// Writes the `message` of a cell of this `belief` to the next one.
#[inline(always)]
fn pass(belief: &[f32], scratch: &mut [f32], message: &mut [f32], [columns, rows]: [usize; 2], taps: &[[f32; 3]; 2]) {
    // Normalised at each cell: products along a chain would underflow.
    let kept = (1.0 - BORDER) / sum(belief);
    let any = BORDER / belief.len() as f32;
    let scaled = taps.map(|taps| taps.map(|tap| kept * tap));
    match (columns > 1, rows > 1) {
        (true, true) => {
            moved(belief, scratch, (1, columns), taps[0], 0.0);
            moved(scratch, message, (columns, belief.len()), scaled[1], any);
        }
        (_, false) => moved(belief, message, (1, columns), scaled[0], any),
        (false, true) => moved(belief, message, (1, rows), scaled[1], any),
    }
}

/// Change of motions from cell to cell along a chain, in candidates.
struct Model {
    drift: [f32; 2],
    wander: f32,
}

impl Model {
    /// Weights, along u and v, of the candidate before, the same and the next, in the cell before; for `sign` −1 after.
    fn taps(&self, sign: f32) -> [[f32; 3]; 2] {
        self.drift.map(|drift| {
            let drift = sign * drift.clamp(-0.9, 0.9);
            let half = self.wander.max(0.5 * drift.abs());
            [half + 0.5 * drift, 1.0 - 2.0 * half, half - 0.5 * drift]
        })
    }
}

impl Posterior {
    /// The posterior from the evidence for each swept slope, `swept` of them along u and v.
    pub fn new(nats: &[Plane], swept: [usize; 2], monitor: &Monitor) -> Result<Self, Cancelled> {
        // On a line there is also a candidate between each two slopes.
        let per_step = if swept[0] > 1 && swept[1] > 1 { 1 } else { 2 };
        let candidates = Candidates { count: swept.map(|count| (count - 1) * per_step + 1), per_step };
        // Drift is found on blocks first: single cells know their motion too badly to show a small change.
        let blocks: Vec<Plane> = nats.par_iter().map(|nats| summed(nats, BLOCK_CELLS)).collect();
        let still = ([[0.0; 2]; 2], BLOCK_WANDER);
        let drift = Self::with(&blocks, candidates, still, monitor)?.drift(blocks[0].size());
        Self::with(nats, candidates, (drift, WANDER), monitor)
    }

    /// The posterior where motions change by `drift`, candidates along u and v, for each cell to the right and down.
    fn with(
        nats: &[Plane],
        candidates: Candidates,
        (drift, wander): ([[f32; 2]; 2], f32),
        monitor: &Monitor,
    ) -> Result<Self, Cancelled> {
        let (width, height) = nats[0].size();
        let count = candidates.len();
        let [right, down] = drift.map(|drift| Model { drift, wander });
        // Both trees of each cell: its row with columns as branches, and its column with rows.
        let mut rows_first = candidates.likelihoods(nats);
        let mut columns_first = transposed(&rows_first, (width, height), count);
        candidates.along_chains(&mut rows_first, width, &right, monitor)?;
        rows_first = transposed(&rows_first, (width, height), count);
        candidates.along_chains(&mut rows_first, height, &down, monitor)?;
        candidates.along_chains(&mut columns_first, height, &down, monitor)?;
        columns_first = transposed(&columns_first, (height, width), count);
        candidates.along_chains(&mut columns_first, width, &right, monitor)?;
        let mut probabilities = transposed(&rows_first, (height, width), count);
        let pairs = probabilities.par_chunks_mut(width * count).zip(columns_first.par_chunks(width * count));
        pairs.for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| *a = (*a * b).sqrt()));
        Ok(Self { candidates, probabilities })
    }

    pub fn found(&self) -> Vec<MotionEstimate> {
        self.probabilities.par_chunks(self.candidates.len()).map(|cell| self.candidates.found(cell)).collect()
    }

    /// Mean change of the motion, candidates, for each cell to the right and down, from blocks that move nearly alike.
    fn drift(&self, (width, height): (usize, usize)) -> [[f32; 2]; 2] {
        let found = self.found();
        let variance = |found: &MotionEstimate| found.covariance[0] + found.covariance[2];
        [(BLOCKS_APART, 0), (0, BLOCKS_APART)].map(|(right, down)| {
            let mut sums = [0.0f64; 3];
            for j in 0..height.saturating_sub(down) {
                for i in 0..width.saturating_sub(right) {
                    let (one, other) = (&found[j * width + i], &found[(j + down) * width + i + right]);
                    let change = [0, 1].map(|axis| other.at[axis] - one.at[axis]);
                    // A larger change is a border, which is no drift.
                    if change[0].hypot(change[1]) < BORDER_STEPS {
                        let weight = 1.0 / (CHANGE_VARIANCE + variance(one) + variance(other));
                        let of = [weight, weight * change[0], weight * change[1]];
                        sums.iter_mut().zip(of).for_each(|(sum, x)| *sum += f64::from(x));
                    }
                }
            }
            let candidates_per_cell = self.candidates.per_step as f64 / (BLOCKS_APART * BLOCK_CELLS) as f64;
            [1, 2].map(|axis| (candidates_per_cell * sums[axis] / sums[0].max(f64::MIN_POSITIVE)) as f32)
        })
    }
}

/// `from` with a part of each value moved `stride` places before and after in its line of `line` values, and `more`
/// added everywhere. Beyond the ends values repeat: motions that drift neither gather there nor are kept away.
#[inline(always)]
fn moved(from: &[f32], to: &mut [f32], (stride, line): (usize, usize), [before, same, after]: [f32; 3], more: f32) {
    let count = from.len();
    let around = from.iter().zip(&from[stride..]).zip(&from[2 * stride..]);
    for (to, ((a, b), c)) in to[stride..count - stride].iter_mut().zip(around) {
        *to = more + before * a + same * b + after * c;
    }
    for start in (0..count).step_by(line) {
        for (first, last) in (start..start + stride).zip(start + line - stride..start + line) {
            to[first] = more + (before + same) * from[first] + after * from[first + stride];
            to[last] = more + before * from[last - stride] + (same + after) * from[last];
        }
    }
}

/// Sum in sixteen partial sums, for vector lanes.
#[inline(always)]
fn sum(values: &[f32]) -> f32 {
    let mut lanes = [0.0f32; 16];
    let chunks = values.chunks_exact(16);
    let rest: f32 = chunks.remainder().iter().sum();
    chunks.for_each(|chunk| lanes.iter_mut().zip(chunk).for_each(|(lane, x)| *lane += x));
    lanes.iter().sum::<f32>() + rest
}

/// `cells` of `count` values each, `width` × `height` of them row by row, column by column.
fn transposed(cells: &[f32], (width, height): (usize, usize), count: usize) -> Vec<f32> {
    let mut columns = vec![0.0f32; cells.len()];
    columns.par_chunks_mut(height * count).enumerate().for_each(|(i, column)| {
        for (j, cell) in column.chunks_mut(count).enumerate() {
            cell.copy_from_slice(&cells[(j * width + i) * count..][..count]);
        }
    });
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_the_posterior_of_all_its_assignments() {
        let nats = [[0.3, 1.2, 0.0, 0.4], [0.9, 0.1, 0.2, 1.5], [0.0, 0.7, 2.0, 0.1]];
        let planes: Vec<Plane> = nats.iter().map(|row| Plane::from_vec(4, 1, row.to_vec())).collect();
        let wander = 0.2;
        let candidates = Candidates { count: [3, 1], per_step: 1 };
        let posterior =
            Posterior::with(&planes, candidates, ([[0.0; 2]; 2], wander), &Monitor::default()).expect("not cancelled");
        // Probability of a motion beside another; what would leave the candidates stays.
        let beside = |one: usize, other: usize| {
            let stays = if one == 1 { 1.0 - 2.0 * wander } else { 1.0 - wander };
            let near = [stays, wander, 0.0][one.abs_diff(other)];
            (1.0 - BORDER) * near + BORDER / 3.0
        };
        let mut sums = [[0.0f32; 3]; 4];
        for assignment in 0..81usize {
            let motions = [assignment % 3, assignment / 3 % 3, assignment / 9 % 3, assignment / 27];
            let evidence: f32 = motions.iter().enumerate().map(|(cell, motion)| nats[*motion][cell]).sum();
            let weight = motions.windows(2).map(|pair| beside(pair[0], pair[1])).product::<f32>() * evidence.exp();
            motions.iter().zip(&mut sums).for_each(|(motion, sums)| sums[*motion] += weight);
        }
        for (cell, sums) in posterior.probabilities.chunks(3).zip(sums) {
            let total: f32 = sums.iter().sum();
            let close = cell.iter().zip(sums).all(|(x, sum)| (x / super::sum(cell) - sum / total).abs() < 0.01);
            assert!(close, "{cell:?} {:?}", sums.map(|sum| sum / total));
        }
    }
}
