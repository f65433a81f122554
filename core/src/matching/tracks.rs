//! Matches of a pair of images that their matches with other images imply, or contradict.
//!
//! If a place of A matches one of C, and that one a place of B, then A's place matches B's, however little they look
//! alike: cameras in between bridge a wide angle. One wrong match on the way makes a wrong end, so two ways must have
//! the same end, or one of which a match is itself implied by others; and no other way from or to its ends has another.
//! Nor may a way come back to an image at another place: then one of its matches is wrong, most likely of the pair with
//! the fewest ([`consistent`]).

use super::aligned::{AlignedImages, Inlier};
use crate::monitor::{Cancelled, Monitor};
use std::cmp::Reverse;
use std::collections::{BTreeSet, HashMap};

/// Largest distance of places of one image that may belong to one track, pixels.
const NEAR_PX: f64 = 6.0;
/// Number of a pair's matches that others confirm or contradict, from which these decide on the whole pair.
const FEWEST_VOTES: usize = 10;

/// A match as the place of one of its images sees it.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// The other image, and the place there.
    image: u32,
    to: u32,
    /// Feature of the own place, and of the other one.
    features: [u32; 2],
    rank: f32,
}

/// Matches of all images by their places: features of several orientations share one.
#[derive(Debug, Default)]
pub struct Tracks {
    /// Matches of each place, in the order of the other images: one for each.
    links: Vec<Vec<Link>>,
    places: Vec<BTreeSet<u32>>,
}

impl Tracks {
    /// Tracks of the inliers of pairs of images, whose features have these places, counted over all images.
    pub fn of<'a>(places: &[Vec<u32>], pairs: impl IntoIterator<Item = ((usize, usize), &'a [Inlier])>) -> Self {
        let mut links = vec![Vec::<Link>::new(); count_of(places)];
        for ((i, j), inliers) in pairs {
            for &Inlier { a, b, rank } in inliers {
                let (of_a, of_b) = (places[i][a as usize], places[j][b as usize]);
                // The first match of a place stands for those of its other orientations.
                let mut link = |place: u32, link: Link| {
                    let of_place = &mut links[place as usize];
                    if of_place.last().is_none_or(|last| last.image != link.image) {
                        of_place.push(link);
                    }
                };
                link(of_a, Link { image: j as u32, to: of_b, features: [a, b], rank });
                link(of_b, Link { image: i as u32, to: of_a, features: [b, a], rank });
            }
        }
        links.iter_mut().for_each(|of_place| of_place.sort_unstable_by_key(|link| link.image));
        Self { links, places: places.iter().map(|of_image| of_image.iter().copied().collect()).collect() }
    }

    fn link(&self, place: u32, image: usize) -> Option<&Link> {
        let links = &self.links[place as usize];
        Some(&links[links.binary_search_by_key(&(image as u32), |link| link.image).ok()?])
    }

    /// Whether ways through other images imply the match of `place` with `to` of `image`.
    fn is_implied(&self, place: u32, image: usize, to: u32) -> bool {
        self.links[place as usize].iter().filter_map(|on_way| self.link(on_way.to, image)).any(|end| end.to == to)
    }

    /// Matches of the images `i` and `j` that others imply, of places without a match of their own, by features.
    pub fn implied(&self, (i, j): (usize, usize)) -> Vec<Inlier> {
        // By both ends the number of ways, and the last one's third image and place there.
        type Ways = (usize, (usize, u32), Inlier);
        let mut ends = HashMap::<(u32, u32), Ways>::new();
        for &place in self.places[i].iter().filter(|place| self.link(**place, j).is_none()) {
            for first in &self.links[place as usize] {
                let Some(second) = self.link(first.to, j).filter(|second| self.link(second.to, i).is_none()) else {
                    continue;
                };
                let implied = Inlier { a: first.features[0], b: second.features[1], rank: first.rank.max(second.rank) };
                let (ways, last, _) = ends.entry((place, second.to)).or_insert((0, (0, 0), implied));
                (*ways, *last) = (*ways + 1, (first.image as usize, first.to));
            }
        }
        ends.retain(|&(place, to), &mut (ways, (third, on_way), _)| {
            ways > 1 || self.is_implied(place, third, on_way) || self.is_implied(on_way, j, to)
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

fn count_of(places: &[Vec<u32>]) -> usize {
    places.iter().flatten().max().map_or(0, |last| *last as usize + 1)
}

/// Tracks to which the matches of one pair after another are added.
struct Growing {
    /// Image of each place, and where it is, pixels.
    at: Vec<(u32, [f64; 2])>,
    /// Next place of the same track, in a ring.
    next: Vec<u32>,
}

impl Growing {
    fn of(AlignedImages { places, place_of, .. }: &AlignedImages) -> Self {
        let count = count_of(place_of);
        let mut at = vec![(0, [0.0; 2]); count];
        for (image, (of_image, places)) in (0..).zip(place_of.iter().zip(places)) {
            of_image.iter().zip(places).for_each(|(&place, &pos_image)| at[place as usize] = (image, pos_image));
        }
        Self { at, next: (0..count as u32).collect() }
    }

    fn track(&self, place: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(place), move |at| Some(self.next[*at as usize]).filter(|next| *next != place))
    }

    fn is_one(&self, [a, b]: [u32; 2]) -> bool {
        self.track(a).any(|place| place == b)
    }

    /// Whether the tracks of two places agree in the images that both are in; `None` where there is none.
    fn agree(&self, [a, b]: [u32; 2]) -> Option<bool> {
        if self.is_one([a, b]) {
            return Some(true);
        }
        let both = self.track(a).flat_map(|of_a| self.track(b).map(move |of_b| [of_a, of_b]));
        let at = both.map(|both| both.map(|place| self.at[place as usize])).filter(|[one, other]| one.0 == other.0);
        at.map(|[(_, [u, v]), (_, [x, y])]| (u - x).hypot(v - y) <= NEAR_PX).reduce(|all, near| all && near)
    }

    /// Makes the tracks of two places one, unless they contradict each other.
    fn join(&mut self, ends: [u32; 2]) {
        if self.agree(ends) != Some(false) && !self.is_one(ends) {
            let [a, b] = ends.map(|place| place as usize);
            // Two rings become one.
            self.next.swap(a, b);
        }
    }
}

/// Inliers of pairs of images that fit the tracks of the pairs with more; none of a pair that most of them contradict.
///
/// On a façade the matches of equal windows agree with one another and in their pictures, so a wrong pair looks like a
/// right one. But then a track comes back to an image at another place, and pairs that see little of the same have
/// fewer inliers.
///
/// # Errors
/// Cancellation once `monitor` was cancelled.
pub fn consistent(
    images: &AlignedImages,
    pairs: &[((usize, usize), &[Inlier])],
    monitor: &Monitor,
) -> Result<Vec<Vec<Inlier>>, Cancelled> {
    let mut tracks = Growing::of(images);
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    order.sort_by_key(|pair| Reverse(pairs[*pair].1.len()));
    let mut consistent = vec![Vec::new(); pairs.len()];
    for pair in order {
        monitor.check()?;
        let ((i, j), inliers) = pairs[pair];
        let ends = |inlier: &Inlier| [images.place_of[i][inlier.a as usize], images.place_of[j][inlier.b as usize]];
        // Before any of its own: a pair alone is as it was matched.
        let votes: Vec<Option<bool>> = inliers.iter().map(|inlier| tracks.agree(ends(inlier))).collect();
        let known = votes.iter().flatten().count();
        let against = votes.iter().filter(|vote| **vote == Some(false)).count();
        if known >= FEWEST_VOTES && 2 * against > known {
            continue;
        }
        for (inlier, _) in inliers.iter().zip(votes).filter(|(_, vote)| *vote != Some(false)) {
            tracks.join(ends(inlier));
            consistent[pair].push(*inlier);
        }
    }
    Ok(consistent)
}

#[cfg(test)]
mod tests {
    use super::super::aligned::Moved;
    use super::*;

    /// Two images and their matches, feature by feature.
    type Matched = ((usize, usize), &'static [[u32; 2]]);

    /// Matches of pairs of images with eight places each.
    fn tracks(pairs: &[Matched]) -> Tracks {
        let inlier = |&[a, b]: &[u32; 2]| Inlier { a, b, rank: 0.1 * a as f32 };
        let pairs: Vec<((usize, usize), Vec<Inlier>)> =
            pairs.iter().map(|(images, of)| (*images, of.iter().map(inlier).collect())).collect();
        // Features 6 and 7 share a place.
        let places: Vec<Vec<_>> = (0..5).map(|k| [0, 1, 2, 3, 4, 5, 6, 6].map(|x| 7 * k + x).to_vec()).collect();
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
    fn of_matches_that_bring_a_track_back_to_an_image_those_of_fewer_go() {
        // Twelve windows, 40 px apart, which the four images see from the first, second, and so on.
        let window = |image: usize, feature: usize| [40.0 * (feature as f64 - image as f64), 100.0];
        let places: Vec<Vec<[f64; 2]>> = (0..4).map(|k| (0..12).map(|x| window(k, x)).collect()).collect();
        let place_of: Vec<Vec<u32>> = (0..4).map(|k| (12 * k..12 * (k + 1)).collect()).collect();
        let moved = Moved { share: 0.0, median_px: None, max_px: None, refused: 0 };
        let images = AlignedImages { places, place_of, residuals_px: Vec::new(), moved };
        let inliers = |count: u32, step: u32| (0..count).map(move |a| Inlier { a, b: a + step, rank: 0.5 });
        let right: Vec<Inlier> = inliers(12, 0).collect();
        let one_wrong: Vec<Inlier> = inliers(11, 0).chain([Inlier { a: 11, b: 3, rank: 0.1 }]).collect();
        let shifted: Vec<Inlier> = inliers(11, 1).collect();
        let pairs: [((usize, usize), &[Inlier]); 5] =
            [((0, 3), &shifted), ((0, 1), &right), ((1, 2), &right), ((0, 2), &one_wrong), ((2, 3), &right)];
        let consistent = |pairs| consistent(&images, pairs, &Monitor::default()).expect("not cancelled");
        let [of_shifted, .., of_one_wrong, of_right] = &consistent(&pairs)[..] else { panic!("one each") };
        assert!(of_shifted.is_empty());
        assert_eq!((&of_one_wrong[..], &of_right[..]), (&one_wrong[..11], &right[..]));
        let alone = [((0, 3), &shifted[..]), ((1, 3), &right)];
        assert_eq!(consistent(&alone)[0], shifted, "no third pair says anything of them");
    }

    #[test]
    fn features_of_one_place_continue_a_way_for_each_other() {
        let turned = tracks(&[((0, 2), &[[1, 6]]), ((1, 2), &[[1, 7]]), ((0, 3), &[[1, 6]]), ((1, 3), &[[1, 6]])]);
        assert_eq!(implied(&turned, (0, 1)), [[1, 1]]);
    }
}
