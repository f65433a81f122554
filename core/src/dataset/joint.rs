//! The places of all images on which the pairs of an export agree, and what is left of each pair.
//!
//! A pair that is right agrees with the pairs of other images, so all are solved for together, twice: at first with the
//! inliers alone, and where other images do not contradict these, with the matches beside them too.

use super::kept_pairs::KeptPairs;
use crate::error::Result;
use crate::matching::aligned::{AlignedImages, Alignment, Inlier};
use crate::matching::{TwoViewModel, Verification, align::Measured, tracks::consistent};
use crate::monitor::Monitor;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Least share of a pair's matches that the tracks of others leave, for those beside them to be believed. With half a
/// façade of equal windows has 83 % right matches in place of 88.
const LEAST_CONSISTENT: f64 = 0.85;

/// A verified pair that waits for the solution: indices of its images, geometry, inliers with their measurements, and
/// matches beside them.
pub(super) struct Waiting {
    pub images: (usize, usize),
    pub model: Option<TwoViewModel>,
    pub inliers: Vec<(Inlier, Option<Measured>)>,
    pub beside: Vec<(Inlier, Option<Measured>)>,
}

/// Places of all images on which the pairs agree, and what is left of each pair, by the indices of its images.
pub(super) struct Joint {
    pub aligned: AlignedImages,
    pub found: BTreeMap<(usize, usize), Agreed>,
}

pub(super) struct Agreed {
    pub model: Option<TwoViewModel>,
    /// Number of its inliers at the solved places.
    pub confirmed: usize,
    /// Confirmed inliers without a contradiction by the tracks of other pairs.
    pub inliers: Vec<Inlier>,
}

impl Joint {
    pub fn of(alignment: &mut Alignment, waiting: &[Waiting], kept: &KeptPairs<'_>, monitor: &Monitor) -> Result<Self> {
        // Links are numbered over all pairs, as the solution returns residuals by link.
        let mut linked: Vec<Vec<(Inlier, Option<usize>)>> = Vec::with_capacity(waiting.len());
        for Waiting { images, inliers, .. } in waiting {
            let mut link = |m: &Inlier, measured| alignment.add_match(*images, (m.a as usize, m.b as usize), measured);
            linked.push(inliers.iter().map(|(m, measured)| (*m, measured.map(|measured| link(m, measured)))).collect());
        }
        let aligned = alignment.solve(monitor)?;
        let confirmed = |(Waiting { images, model, .. }, inliers): (&Waiting, &Vec<_>)| {
            aligned.confirmed(*images, model.as_ref(), inliers, &kept.matching(*images), &monitor.silent())
        };
        let confirmed: Vec<_> = waiting.par_iter().zip(&linked).map(confirmed).collect::<Result<_>>()?;
        let agreed = |(Waiting { images, inliers, .. }, verified): (&Waiting, Option<Verification>)| {
            let Verification { model, inlier, .. } = verified?;
            let agreed = inliers.iter().zip(inlier).filter(|(_, inlier)| *inlier).map(|((m, _), _)| *m);
            let inliers: Vec<Inlier> = agreed.collect();
            Some((*images, Agreed { model, confirmed: inliers.len(), inliers }))
        };
        let mut found: BTreeMap<(usize, usize), Agreed> = waiting.iter().zip(confirmed).filter_map(agreed).collect();
        let pairs: Vec<_> = found.iter().map(|(images, of)| (*images, &of.inliers[..])).collect();
        let consistent = consistent(&aligned, &pairs, monitor)?;
        found.values_mut().zip(consistent).for_each(|(of, consistent)| of.inliers = consistent);
        Ok(Self { aligned, found })
    }

    /// Adds the matches beside inliers to pairs that other images could contradict and do not; whether there are any.
    pub fn add_beside(&self, waiting: &mut [Waiting]) -> bool {
        let mut joined = vec![BTreeSet::new(); self.aligned.places.len()];
        for (&(a, b), _) in self.found.iter().filter(|(_, of)| !of.inliers.is_empty()) {
            joined[a].insert(b);
            joined[b].insert(a);
        }
        let mut any = false;
        for of in waiting {
            let beside = std::mem::take(&mut of.beside);
            let Some(Agreed { confirmed, inliers, .. }) = self.found.get(&of.images) else { continue };
            let is_consistent = inliers.len() as f64 >= LEAST_CONSISTENT * *confirmed as f64;
            let (a, b) = of.images;
            // A third image that sees both: without one a wrong pair looks like a right one.
            let has_witness = !joined[a].is_disjoint(&joined[b]);
            if beside.is_empty() || inliers.is_empty() || !is_consistent || !has_witness {
                continue;
            }
            any = true;
            // Contradicted matches would draw places away from the new measurements.
            let left: HashSet<(u32, u32)> = inliers.iter().map(|m| (m.a, m.b)).collect();
            of.inliers.retain(|(m, _)| left.contains(&(m.a, m.b)));
            of.inliers.extend(beside);
        }
        any
    }
}
