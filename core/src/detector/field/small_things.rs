//! Small things: a window around each cell overrules the posterior where another motion has much more evidence in it.
//!
//! A row of cells on a thing of a few cells seldom has enough evidence to pay for two borders, and the posterior does not
//! see that the rows beside it have it too.

use super::evidence::Evidence;
use super::posterior::{Candidates, Found};
use super::refine::{nats_at, window_sums};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use rayon::prelude::*;

/// Standard deviation of the window, cells.
const WINDOW_CELLS: f64 = 1.75;
/// Evidence that another motion needs in it, nats.
const OVERRULING_NATS: f32 = 3.0;
/// Steps of the sweep between two motions that differ.
const OTHER_STEPS: f32 = 1.0;

/// Gives cells the motion of the window around them where it overrules what was `found`.
pub(super) fn overrule(found: &mut [Found], evidence: &Evidence, monitor: &Monitor) -> Result<(), Cancelled> {
    let (width, height) = evidence.size;
    let grid = &evidence.grid;
    let sums = evidence.nats.par_iter().map(|nats| window_sums(nats, WINDOW_CELLS, monitor));
    let sums: Vec<Plane> = sums.collect::<Result<_, _>>()?;
    let own = (0..found.len()).map(|place| nats_at(evidence, place, found[place].at));
    let own = window_sums(&Plane::from_vec(width, height, own.collect()), WINDOW_CELLS, monitor)?;
    let candidates = Candidates { count: [grid.u.count, grid.v.count], per_step: 1 };
    let cells = found.par_iter_mut().zip(own.data()).enumerate();
    cells.for_each_init(Vec::new, |in_window, (place, (found, own))| {
        in_window.clear();
        in_window.extend(sums.iter().map(|sums| sums.data()[place]));
        let larger = |best: usize, (index, x): (usize, &f32)| if *x > in_window[best] { index } else { best };
        let best = in_window.iter().enumerate().fold(0, larger);
        let (i, j) = grid.coordinates(best);
        let apart = (i as f32 - found.at[0]).hypot(j as f32 - found.at[1]);
        let most = in_window[best];
        if apart > OTHER_STEPS && most - own > OVERRULING_NATS {
            in_window.iter_mut().for_each(|x| *x = (*x - most).exp());
            *found = candidates.found(in_window);
        }
    });
    Ok(())
}
