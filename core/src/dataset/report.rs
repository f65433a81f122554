//! Report of an export to COLMAP: what the database holds, and whether a mapper can start from it.

use crate::files::serialize_path;
use crate::matching::aligned::Moved;
use crate::matching::{Camera, MatchCounts};
use serde::Serialize;
use std::path::PathBuf;

/// Report of one image of the database.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImageReport {
    /// Id in the database.
    pub id: u32,
    /// Name of the burst.
    pub burst: String,
    /// File below the folder of images.
    pub image: String,
    /// Number of features.
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

/// Report of an export.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColmapReport {
    /// Path of the database.
    #[serde(serialize_with = "serialize_path")]
    pub database: PathBuf,
    /// Folder of images.
    #[serde(serialize_with = "serialize_path")]
    pub images_folder: PathBuf,
    /// Cameras, one for each size of image.
    pub cameras: Vec<Camera>,
    /// Whether the focal length is known.
    pub known_camera: bool,
    /// Images, in ascending id.
    pub images: Vec<ImageReport>,
    /// Pairs, in order.
    pub pairs: Vec<PairReport>,
    /// Distances by which the database's keypoints moved from those in the files; `None` if they were not aligned.
    pub moved: Option<Moved>,
    /// Says why COLMAP's mapper will not be able to start from the database; `None` where a pair has enough inliers.
    pub no_start: Option<String>,
}

/// Inliers with which COLMAP's mapper begins, nearly: it asks for 100, 50, 25, and for 30 places of each further image.
const INLIERS_TO_START: usize = 30;

impl ColmapReport {
    /// Says why a mapper will not be able to start from these pairs.
    pub(super) fn why_no_start(&self) -> Option<String> {
        let best = self.pairs.iter().max_by_key(|pair| pair.counts.inliers)?;
        let most = best.counts.inliers.unwrap_or(0);
        if most >= INLIERS_TO_START {
            return None;
        }
        let name = |id: u32| self.images.iter().find(|image| image.id == id).map_or("", |image| &image.burst);
        let pairs_with = |has: fn(&MatchCounts) -> bool| self.pairs.iter().filter(|pair| has(&pair.counts)).count();
        let why = if most > 0 {
            let [a, b] = best.ids.map(name);
            format!("the most inliers of a pair are {most}, of {a} and {b}")
        } else {
            // The three causes have different remedies.
            let no_match = pairs_with(|counts| counts.putative == 0);
            let refused = pairs_with(|counts| counts.refused.is_some());
            let all = self.pairs.len();
            format!(
                "none of {all} pairs is verified ({no_match} without a match, {refused} refused, in the others too few agree)"
            )
        };
        let needed = format!("and it needs a pair with about {INLIERS_TO_START} inliers");
        Some(format!("a mapper will not be able to start from it: {why}, {needed}"))
    }
}
