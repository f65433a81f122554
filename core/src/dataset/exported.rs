//! Report of an export, read from its folder: from the database, but for features, and from the files of refused pairs.

use super::report::{ColmapReport, ImageReport, Joined, PairReport};
use super::{colmap::DATABASE_FILE, kept::pairs_folder, kept_pairs::why_refused};
use crate::error::{Error, Result};
use crate::export::{GeometryKind, safe_file_name};
use crate::files::{mark::has_mark, open_database};
use crate::matching::{MatchCounts, Refusal};
use rusqlite::Row;
use std::{collections::HashMap, path::Path};

/// Reads images, pairs with a match, and what they join from `folder`, which an export of some of `bursts` wrote.
/// Numbers of frames are 0; a burst that is not among `bursts` has the name of its picture.
///
/// # Errors
/// One of the parameter `pairs-of`: a folder that no export wrote, a damaged database, or one of other bursts alone.
pub fn read_exported(folder: &Path, bursts: &[&str]) -> Result<ColmapReport> {
    let strange = |why: &str| {
        let problem = format!("{} is no folder that colmap wrote from these bursts: {why}", folder.display());
        Error::param("pairs-of", problem, "give the --out of a `burstscope colmap` of them")
    };
    if !has_mark(&folder.join(DATABASE_FILE), false) {
        return Err(strange("it has no database.db of Burstscope's"));
    }
    let known: HashMap<String, &str> = bursts.iter().map(|name| (safe_file_name(name) + ".png", *name)).collect();
    let report = read(folder, &known).map_err(|error| strange(&format!("its database.db is damaged ({error})")))?;
    let is_of_them = report.images.iter().any(|image| known.contains_key(&image.image));
    if is_of_them { Ok(report) } else { Err(strange("it holds none of them")) }
}

fn read(folder: &Path, known: &HashMap<String, &str>) -> rusqlite::Result<ColmapReport> {
    let database = folder.join(DATABASE_FILE);
    let connection = open_database(&database)?;
    let image = |row: &Row<'_>| {
        let (id, image, features): (u32, String, u32) = row.try_into()?;
        let burst = known.get(&image).copied().unwrap_or(image.trim_end_matches(".png")).to_owned();
        Ok(ImageReport { id, burst, image, frames: 0, features: features as usize, resumed: true })
    };
    let images = "SELECT image_id, name, rows FROM images JOIN keypoints USING (image_id) ORDER BY image_id";
    let images: Vec<_> = connection.prepare(images)?.query_map([], image)?.collect::<rusqlite::Result<_>>()?;
    let pair = |row: &Row<'_>| {
        let (a, b): (String, String) = row.try_into()?;
        let count = |column: usize| row.get::<_, u32>(column).map(|count| count as usize);
        let (putative, inliers) = (count(6)?, count(7)?);
        let file = || pairs_folder(folder).join(a).join(format!("{b}.pair"));
        let refused = match (inliers, row.get::<_, u32>(8)?) {
            (1.., _) => None,
            // A geometry without inliers.
            (0, kind) if kind > GeometryKind::Degenerate as u32 => Some(Refusal::Tracks),
            _ => why_refused(&file(), putative),
        };
        let (keypoints_a, keypoints_b, inliers) = (count(4)?, count(5)?, Some(inliers));
        let counts = MatchCounts { keypoints_a, keypoints_b, putative, inliers, refused, not_mutual: None };
        Ok(PairReport { ids: [row.get(2)?, row.get(3)?], resumed: true, counts })
    };
    let pairs =
        "SELECT a.name, b.name, a.image_id, b.image_id, in_a.rows, in_b.rows, matches.rows, coalesce(found.rows, 0),
        coalesce(found.config, 0)
        FROM matches LEFT JOIN two_view_geometries AS found USING (pair_id)
        JOIN images AS a ON a.image_id = pair_id / 2147483647 JOIN keypoints AS in_a ON in_a.image_id = a.image_id
        JOIN images AS b ON b.image_id = pair_id % 2147483647 JOIN keypoints AS in_b ON in_b.image_id = b.image_id
        ORDER BY pair_id";
    let pairs: Vec<_> = connection.prepare(pairs)?.query_map([], pair)?.collect::<rusqlite::Result<_>>()?;
    Ok(ColmapReport { joined: Joined::of(&images, &pairs), database, images, pairs, ..ColmapReport::default() })
}
