//! Matches of a pair of images that their matches with other images imply.
//!
//! If a place of A matches one of C, and that one a place of B, then A's place matches B's, however little they look
//! alike: cameras in between bridge a wide angle. One wrong match on the way makes a wrong end, so two ways must have
//! the same end, or one of which a match is itself implied by others; and no other way from or to its ends has another.

use super::aligned::Inlier;
use std::collections::{BTreeMap, HashMap};

/// A match as one of its images sees it.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// Place in the other image.
    to: u32,
    /// Feature of the own place, and of the other one.
    features: [u32; 2],
    rank: f32,
}

/// Matches of all images by their places: features of several orientations share one.
#[derive(Debug, Default)]
pub struct Tracks {
    /// For each image, and each that it has matches with, the match of each place.
    links: Vec<BTreeMap<usize, HashMap<u32, Link>>>,
}

impl Tracks {
    /// Tracks of the inliers of pairs of images, whose features have these places: numbers by image and feature.
    pub fn of<'a>(places: &[Vec<u32>], pairs: impl IntoIterator<Item = ((usize, usize), &'a [Inlier])>) -> Self {
        let mut links = vec![BTreeMap::<usize, HashMap<u32, Link>>::new(); places.len()];
        for ((i, j), inliers) in pairs {
            for &Inlier { a, b, rank } in inliers {
                let (of_a, of_b) = (places[i][a as usize], places[j][b as usize]);
                // The first match of a place stands for those of its other orientations.
                let mut link = |image: usize, other, place, link| {
                    links[image].entry(other).or_default().entry(place).or_insert(link);
                };
                link(i, j, of_a, Link { to: of_b, features: [a, b], rank });
                link(j, i, of_b, Link { to: of_a, features: [b, a], rank });
            }
        }
        Self { links }
    }

    fn link(&self, image: usize, other: usize, place: u32) -> Option<&Link> {
        self.links[image].get(&other)?.get(&place)
    }

    /// Whether ways through other images imply the match of `place` of `image` with `to` of `other`.
    fn is_implied(&self, (image, other): (usize, usize), (place, to): (u32, u32)) -> bool {
        let end = |&third: &usize| self.link(third, other, self.link(image, third, place)?.to);
        self.links[image].keys().filter_map(end).any(|end| end.to == to)
    }

    /// Matches of the images `i` and `j` that others imply, of places without a match of their own, by features.
    pub fn implied(&self, (i, j): (usize, usize)) -> Vec<Inlier> {
        // By both ends the number of ways, and the last one's third image and place there.
        type Ways = (usize, (usize, u32), Inlier);
        let mut ends = HashMap::<(u32, u32), Ways>::new();
        for (&third, of_i) in &self.links[i] {
            let Some(onwards) = self.links[third].get(&j) else { continue };
            for (&place, first) in of_i {
                let Some(second) = onwards.get(&first.to) else { continue };
                if self.link(i, j, place).is_some() || self.link(j, i, second.to).is_some() {
                    continue;
                }
                let rank = first.rank.max(second.rank);
                let implied = Inlier { a: first.features[0], b: second.features[1], rank };
                let (ways, last, _) = ends.entry((place, second.to)).or_insert((0, (0, 0), implied));
                (*ways, *last) = (*ways + 1, (third, first.to));
            }
        }
        ends.retain(|&(place, to), (ways, (third, on_way), _)| {
            let halves = [((i, *third), (place, *on_way)), ((*third, j), (*on_way, to))];
            *ways > 1 || halves.into_iter().any(|(images, places)| self.is_implied(images, places))
        });
        let mut ways_of: [HashMap<u32, usize>; 2] = Default::default();
        for (place, to) in ends.keys() {
            *ways_of[0].entry(*place).or_default() += 1;
            *ways_of[1].entry(*to).or_default() += 1;
        }
        // A place with two ends has a wrong match on one of the ways.
        let is_sole = |(place, to): &(u32, u32)| ways_of[0][place] == 1 && ways_of[1][to] == 1;
        let sole = ends.iter().filter(|(ends, _)| is_sole(ends));
        let mut implied: Vec<Inlier> = sole.map(|(_, (.., inlier))| *inlier).collect();
        implied.sort_unstable_by_key(|inlier| (inlier.a, inlier.b));
        implied
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two images and their matches, feature by feature.
    type Matched = ((usize, usize), &'static [[u32; 2]]);

    /// Matches of pairs of images with eight places each.
    fn tracks(pairs: &[Matched]) -> Tracks {
        let inlier = |&[a, b]: &[u32; 2]| Inlier { a, b, rank: 0.1 * a as f32 };
        let pairs: Vec<((usize, usize), Vec<Inlier>)> =
            pairs.iter().map(|(images, of)| (*images, of.iter().map(inlier).collect())).collect();
        // Features 6 and 7 share a place.
        let places = vec![vec![0, 1, 2, 3, 4, 5, 6, 6]; 5];
        Tracks::of(&places, pairs.iter().map(|(images, of)| (*images, &of[..])))
    }

    fn implied(tracks: &Tracks, images: (usize, usize)) -> Vec<[u32; 2]> {
        tracks.implied(images).iter().map(|inlier| [inlier.a, inlier.b]).collect()
    }

    #[test]
    fn two_ways_or_one_that_others_imply_make_a_match() {
        // Place 1 goes from image 0 to 1 by images 2 and 3; place 2 by image 2 alone, where nothing else confirms it.
        let two = tracks(&[
            ((0, 2), &[[1, 1], [2, 2]]),
            ((0, 3), &[[1, 1]]),
            ((1, 2), &[[1, 1], [2, 2]]),
            ((1, 3), &[[1, 1]]),
        ]);
        assert_eq!(implied(&two, (0, 1)), [[1, 1]]);
        assert_eq!(implied(&two, (1, 0)), [[1, 1]]);
        // Image 4 confirms that place 2 of image 0 is place 2 of image 2.
        let confirmed = tracks(&[((0, 2), &[[2, 2]]), ((1, 2), &[[2, 2]]), ((0, 4), &[[2, 5]]), ((2, 4), &[[2, 5]])]);
        assert_eq!(implied(&confirmed, (0, 1)), [[2, 2]]);
        assert_eq!(confirmed.implied((0, 1))[0].rank, 0.2);
    }

    #[test]
    fn ways_that_contradict_one_another_or_a_match_imply_nothing() {
        let both: [Matched; 4] = [((0, 2), &[[1, 1]]), ((1, 2), &[[1, 1]]), ((0, 3), &[[1, 1]]), ((1, 3), &[[1, 1]])];
        let matched = tracks(&[&both[..], &[((0, 1), &[[1, 4]])]].concat());
        assert!(implied(&matched, (0, 1)).is_empty(), "place 1 has a match of its own");
        // Two ways lead to place 5 too: one of image 4, which others imply.
        let elsewhere = tracks(&[&both[..], &[((0, 4), &[[1, 0]]), ((1, 4), &[[5, 0]]), ((2, 4), &[[1, 0]])]].concat());
        assert!(implied(&elsewhere, (0, 1)).is_empty());
    }

    #[test]
    fn features_of_one_place_continue_a_way_for_each_other() {
        let turned = tracks(&[((0, 2), &[[1, 6]]), ((1, 2), &[[1, 7]]), ((0, 3), &[[1, 6]]), ((1, 3), &[[1, 6]])]);
        assert_eq!(implied(&turned, (0, 1)), [[1, 1]]);
    }
}
