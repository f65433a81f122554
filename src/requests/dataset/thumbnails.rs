//! Small pictures of a dataset's bursts.

use crate::burst::{BurstFiles, OpenOptions};
use crate::dataset::{Thumbnail, thumbnail};
use crate::requests::error::JobError;
use crate::requests::request::{Request, Urgency, Work};

/// Small pictures of some bursts.
#[derive(Debug, Clone, PartialEq)]
pub struct ThumbnailsRequest {
    /// The bursts, in the order in which their pictures are made.
    pub bursts: Vec<BurstFiles>,
    /// Maximum length of the longer side, pixels.
    pub max_side_px: usize,
    /// Options with which the bursts are opened.
    pub open: OpenOptions,
}

impl Request for ThumbnailsRequest {
    type Answer = ();
    /// A burst with its picture, or why there is none.
    type Told = (BurstFiles, Result<Thumbnail, String>);

    fn urgency(&self) -> Urgency {
        Urgency::Dataset
    }

    fn is_same(&self, other: &Self) -> bool {
        self == other
    }

    fn compute(self, work: &Work<'_, Self::Told>) -> Result<(), JobError> {
        for source in self.bursts {
            let silent = work.monitor.silent();
            let picture = thumbnail(&source, self.max_side_px, &self.open, &silent).map_err(|e| e.to_string());
            work.monitor.check()?;
            (work.tell)((source, picture));
        }
        Ok(())
    }
}
