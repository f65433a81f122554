//! Selection of the pairs of images that are matched: by a rule, by a list, or by votes of their strongest features.

use super::putative::{Nearest, nearest_two_both_ways};
use crate::detector::Descriptor;
use crate::monitor::{Cancelled, Monitor, Stage};
use rayon::prelude::*;
use std::{cmp::Reverse, collections::BTreeSet, fmt, str::FromStr};

/// A choice of pairs.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum PairSelection {
    /// Each image with every other one: N·(N − 1)/2 pairs.
    #[default]
    All,
    /// Each image with the next few after it, for a camera path that does not return: about N times as many pairs.
    Sequential(usize),
    /// Each image with the few for which most of its strongest features vote: by what they show, not by their order.
    Near(usize),
    /// These pairs of images, by their indices, the earlier one first; taken once each, in order.
    Listed(Vec<(usize, usize)>),
}

impl PairSelection {
    /// The pairs of `count` images, the earlier one first, in order; of [`Self::Near`] all from which features choose.
    pub fn pairs(&self, count: usize) -> Vec<(usize, usize)> {
        let reach = match self {
            Self::All | Self::Near(_) => count,
            Self::Sequential(reach) => *reach,
            Self::Listed(pairs) => {
                let pairs = pairs.iter().copied().filter(|&(a, b)| a < b && b < count);
                return pairs.collect::<BTreeSet<_>>().into_iter().collect();
            }
        };
        (0..count)
            .flat_map(|a| (a + 1..count.min(a.saturating_add(reach).saturating_add(1))).map(move |b| (a, b)))
            .collect()
    }

    /// [`Self::pairs`], those of [`Self::Near`] chosen by [`near_pairs`]: `descriptors` returns those of an image,
    /// strongest first, and is called only for them. In memory are [`VOTERS`] of each image.
    ///
    /// # Errors
    /// Those of `descriptors`, and cancellation.
    pub fn pairs_by<E: From<Cancelled>>(
        &self,
        count: usize,
        descriptors: impl Fn(usize) -> Result<Vec<Descriptor>, E>,
        monitor: &Monitor,
    ) -> Result<Vec<(usize, usize)>, E> {
        let Self::Near(partners) = self else { return Ok(self.pairs(count)) };
        let voters = |image: usize| -> Result<Vec<Descriptor>, E> {
            monitor.check()?;
            Ok(descriptors(image)?.into_iter().take(VOTERS).collect())
        };
        let strongest = (0..count).map(voters).collect::<Result<Vec<_>, E>>()?;
        Ok(near_pairs(&strongest, *partners, monitor)?)
    }
}

/// Largest number of features of an image that vote: 40 kB of memory, and where images have 3000 features a hundredth
/// of the comparisons of all pairs.
pub const VOTERS: usize = 300;

/// Pairs of each image with the `partners` others, or all if there are fewer, that get most of its votes; of equals the
/// first. Each of its `strongest` descriptors votes for the image with the nearest one in all others. Pairs are in
/// order, the earlier image first.
///
/// # Errors
/// Cancellation.
pub fn near_pairs(
    strongest: &[Vec<Descriptor>],
    partners: usize,
    monitor: &Monitor,
) -> Result<Vec<(usize, usize)>, Cancelled> {
    let count = strongest.len();
    // No image has the last index, so the start of a feature without any other is no vote.
    let mut nearest: Vec<Vec<(u32, usize)>> =
        strongest.iter().map(|of| vec![(u32::MAX, usize::MAX); of.len()]).collect();
    let vote = |votes: &mut [(u32, usize)], image: usize, found: &[Nearest]| {
        votes.iter_mut().zip(found).for_each(|(vote, found)| *vote = (*vote).min((found.distance_squared, image)));
    };
    for a in 0..count {
        monitor.report(Stage::Match, a as f32 / count as f32);
        let search = |b: usize| nearest_two_both_ways(&strongest[a], &strongest[b], &monitor.silent());
        let found: Vec<_> = (a + 1..count).into_par_iter().map(search).collect::<Result<_, _>>()?;
        for (b, (of_a, of_b)) in (a + 1..).zip(found) {
            vote(&mut nearest[a], b, &of_a);
            vote(&mut nearest[b], a, &of_b);
        }
    }
    let mut pairs = BTreeSet::new();
    for (a, voted) in nearest.iter().enumerate() {
        let mut votes = vec![0; count];
        for (_, image) in voted.iter().filter(|(_, image)| *image < count) {
            votes[*image] += 1;
        }
        let mut others: Vec<usize> = (0..count).filter(|b| *b != a).collect();
        others.sort_by_key(|b| Reverse(votes[*b]));
        pairs.extend(others.into_iter().take(partners).map(|b| (a.min(b), a.max(b))));
    }
    Ok(pairs.into_iter().collect())
}

impl fmt::Display for PairSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Sequential(reach) => write!(f, "sequential:{reach}"),
            Self::Near(partners) => write!(f, "near:{partners}"),
            Self::Listed(pairs) => write!(f, "{} listed", pairs.len()),
        }
    }
}

impl FromStr for PairSelection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (rule, number) = text.split_once(':').unwrap_or((text, ""));
        match (rule, number.parse()) {
            _ if text == "all" => Ok(Self::All),
            ("sequential", Ok(reach)) if reach > 0 => Ok(Self::Sequential(reach)),
            ("near", Ok(partners)) if partners > 0 => Ok(Self::Near(partners)),
            _ => Err(format!(
                "'{text}' is neither 'all', 'sequential:K' nor 'near:K' with K of 1 or more, such as sequential:5"
            )),
        }
    }
}
