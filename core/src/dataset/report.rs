//! Report of an export to COLMAP: what the database holds, and whether a mapper can start from it.

use crate::files::{serialize_path, serialize_paths};
use crate::matching::{Camera, MatchCounts, Refusal, aligned::Moved};
use serde::Serialize;
use std::{cmp::Reverse, collections::BTreeMap, path::PathBuf};

/// Report of one camera of the database.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraReport {
    /// Its intrinsics.
    #[serde(flatten)]
    pub camera: Camera,
    /// Whether the focal length is known.
    pub known: bool,
    /// Files, or words, that the camera of single bursts is from; empty for that of all others.
    #[serde(serialize_with = "serialize_paths")]
    pub from: Vec<PathBuf>,
    /// Ids of its images, in ascending order.
    pub images: Vec<u32>,
}

/// Report of one image of the database.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct ImageReport {
    /// Id in the database.
    pub id: u32,
    pub burst: String,
    /// File below the folder of images.
    pub image: String,
    pub frames: usize,
    pub features: usize,
    /// Whether an earlier run had found the features.
    pub resumed: bool,
}

/// Report of one matched pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairReport {
    /// Ids of the images, the smaller one first.
    pub ids: [u32; 2],
    /// Whether an earlier run had matched it.
    pub resumed: bool,
    /// Counts of the match.
    #[serde(flatten)]
    pub counts: MatchCounts,
}

/// Images that verified pairs join.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Joined {
    /// Bursts of each part that verified pairs join, the largest first. A mapper makes a model of one part.
    pub parts: Vec<Vec<String>>,
    /// Bursts without a verified pair.
    pub alone: Vec<String>,
    /// Number of pairs refused because of their motions.
    pub refused_by_motions: usize,
    /// Number of pairs refused because of their pictures.
    pub refused_by_pictures: usize,
    /// Number of pairs refused because of the tracks of other pairs.
    pub refused_by_tracks: usize,
}

impl Joined {
    /// Images, of `images`, that the verified ones of `pairs`, of no other images, join.
    pub fn of(images: &[ImageReport], pairs: &[PairReport]) -> Self {
        let mut part_of: BTreeMap<u32, u32> = images.iter().map(|image| (image.id, image.id)).collect();
        for PairReport { ids, .. } in pairs.iter().filter(|pair| pair.counts.inliers > Some(0)) {
            let [a, b] = ids.map(|id| part_of[&id]);
            part_of.values_mut().filter(|part| **part == b).for_each(|part| *part = a);
        }
        let mut parts: BTreeMap<u32, Vec<String>> = BTreeMap::new();
        for image in images {
            parts.entry(part_of[&image.id]).or_default().push(image.burst.clone());
        }
        let (alone, mut parts): (Vec<_>, Vec<_>) = parts.into_values().partition(|part| part.len() == 1);
        parts.sort_by_key(|part| Reverse(part.len()));
        let [refused_by_motions, refused_by_pictures, refused_by_tracks] =
            Refusal::ALL.map(|why| pairs.iter().filter(|pair| pair.counts.refused == Some(why)).count());
        Self { parts, alone: alone.concat(), refused_by_motions, refused_by_pictures, refused_by_tracks }
    }
}

/// Report of an export.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct ColmapReport {
    #[serde(serialize_with = "serialize_path")]
    pub database: PathBuf,
    #[serde(serialize_with = "serialize_path")]
    pub images_folder: PathBuf,
    /// Cameras, in ascending id: the known ones, and a guessed one for each size of image.
    pub cameras: Vec<CameraReport>,
    /// Whether the focal lengths of all cameras are known.
    pub known_camera: bool,
    /// Images, in ascending id.
    pub images: Vec<ImageReport>,
    pub pairs: Vec<PairReport>,
    /// Images that verified pairs join.
    pub joined: Joined,
    /// Distances by which the database's keypoints moved from those in the files; `None` if they were not aligned.
    pub moved: Option<Moved>,
    /// Number of inliers, of all pairs, that lie beside measured ones, and that no descriptor found.
    pub beside: usize,
    /// Number of inliers, of all pairs, that the matches of other pairs imply.
    pub implied: usize,
    /// Says why COLMAP's mapper will not be able to start from the database; `None` where a pair has enough inliers.
    pub no_start: Option<String>,
}

/// Inliers with which COLMAP's mapper begins, nearly: it asks for 100, 50, 25, and for 30 places of each further image.
pub const INLIERS_TO_START: usize = 30;

impl ColmapReport {
    /// Name of the burst of an image; empty where there is no such image.
    pub fn burst(&self, id: u32) -> &str {
        self.images.iter().find(|image| image.id == id).map_or("", |image| &image.burst)
    }

    /// Number of verified pairs of a burst; `None` where it has no image.
    pub fn verified_pairs(&self, burst: &str) -> Option<usize> {
        let id = self.images.iter().find(|image| image.burst == burst)?.id;
        Some(self.pairs.iter().filter(|pair| pair.counts.inliers > Some(0) && pair.ids.contains(&id)).count())
    }

    /// Says why a mapper will not be able to start from these pairs.
    pub fn why_no_start(&self) -> Option<String> {
        let Some(best) = self.pairs.iter().max_by_key(|pair| pair.counts.inliers) else {
            return Some("a mapper will not be able to start from it: there is no pair of bursts".to_owned());
        };
        let most = best.counts.inliers.unwrap_or(0);
        if most >= INLIERS_TO_START {
            return None;
        }
        let why = if most > 0 {
            let [a, b] = best.ids.map(|id| self.burst(id));
            format!("the most inliers of a pair are {most}, of {a} and {b}")
        } else {
            // The three causes have different remedies.
            let no_match = self.pairs.iter().filter(|pair| pair.counts.putative == 0).count();
            let refused = self.joined.refused_by_motions + self.joined.refused_by_pictures;
            let all = self.pairs.len();
            let none = if all == 1 { "the one pair is not".into() } else { format!("none of {all} pairs is") };
            format!("{none} verified ({no_match} without a match, {refused} refused, in the others too few agree)")
        };
        let needed = format!("a pair with about {INLIERS_TO_START} inliers");
        Some(format!("a mapper will not be able to start from it: {why}, and it needs {needed}"))
    }
}
