//! Tests of `detector::field::posterior`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::detector::field::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use multiversion::multiversion;
use rayon::prelude::*;

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
        let close = cell.iter().zip(sums).all(|(x, sum)| (x / sum_of(cell) - sum / total).abs() < 0.01);
        assert!(close, "{cell:?} {:?}", sums.map(|sum| sum / total));
    }
}

fn sum_of(cell: &[f32]) -> f32 {
    cell.iter().sum()
}

