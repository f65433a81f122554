//! A reconstruction that is built in, for lessons: eight dark bursts of a way forward and to the side, past 4 planes.
//!
//! Made by the program from the 300 strongest features of each burst, and by COLMAP's mapper (pycolmap 4.2.1). Stored
//! as that wrote it, in text, but without the keypoints that became no points and with fewer digits:
//!
//! ```sh
//! burstscope synth trajectory --motion 2d --bursts 8 --read-noise 80 --out way
//! burstscope colmap way/bursts --out rec --camera way/lens.toml --max-features 300
//! python3 -c "import pycolmap; pycolmap.incremental_mapping('rec/database.db', 'rec/images', 'rec/sparse')"
//! ```

use super::{SparseModel, Trajectory, tum::parse_tum};
use burstscope_core::error::Result;
use std::path::Path;

/// Name of the built-in estimate; a folder of that name is given as `./demo-cameras`.
pub const DEMO_ESTIMATE: &str = "demo-cameras";
/// Name of the true poses.
pub const DEMO_TRUTH: &str = "demo-cameras-truth";

/// Whether `path` is the name of a built-in trajectory.
pub fn is_built_in(path: &Path) -> bool {
    [DEMO_ESTIMATE, DEMO_TRUTH].iter().any(|name| path.as_os_str() == *name)
}

pub(super) fn built_in(path: &Path) -> Option<Result<Trajectory>> {
    let truth = || Ok(Trajectory { poses: parse_tum(include_str!("demo/truth.txt"), path)?, model: None });
    let estimate = || {
        let model = SparseModel::of_text(include_str!("demo/images.txt"), include_str!("demo/points3D.txt"), path)?;
        Ok(Trajectory { poses: model.poses(), model: Some(model) })
    };
    match path.to_str()? {
        DEMO_ESTIMATE => Some(estimate()),
        DEMO_TRUTH => Some(truth()),
        _ => None,
    }
}
