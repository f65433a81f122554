//! Requests for background work and their answers. A request is an immutable snapshot of all that decides its answer;
//! `compute` makes it on the calling thread and its pool, and stops with [`JobError::Cancelled`] once its
//! [`Monitor`](crate::monitor::Monitor) is cancelled. [`crate::engine`] decides when, where, and which of several wins.

#[macro_use]
mod request;

mod caches;
mod comparison;
pub mod dataset;
mod detect;
mod explain;
mod figure;
mod film;
mod kind;
mod map;
mod open;
mod picture;
mod source;
mod study;

#[cfg(test)]
pub(crate) use caches::PictureCache;
pub(crate) use caches::locked;
pub use caches::{Caches, DetectionSource, Trails};
pub use comparison::{ComparedWith, ComparisonRequest, Differences, ReferenceSource};
pub use dataset::{
    Bursts, DatasetAnswer, DatasetEvent, DatasetRequest, Keeping, OpenDataset, ThumbnailsRequest, next_commands,
    old_model,
};
#[cfg(feature = "colmap")]
pub use dataset::{ColmapDone, ColmapRequest};
pub use detect::{
    CompareRequest, Compared, DetectRequest, Detected, MatchRequest, Matched, OpenRequest, detect_line, window_line,
};
pub use explain::{
    CoherenceRequest, Coherences, ExplainQuestion, ExplainRequest, Explanation, FoundLosses, LossesRequest,
    ProbeQuestion, ProbeRequest, Probed, Traced,
};
pub use figure::{
    FigurePicture, FigurePreview, FigureRequest, MatchFigure, MatchPictures, are_stacked, titled, write_page,
};
pub use film::{Film, FilmStep, MAX_FILM_PICTURES, Rasteriser, Sweep};
pub use kind::{AboutView, PictureKind, RangeClass, ViewKind};
pub use map::{MotionMap, SlopeColours, line_of};
pub use open::{BurstId, FolderRequest, OpenBurst, PREVIEW_OCTAVES, ShapeRequest};
pub(crate) use picture::PictureKey;
pub use picture::{PictureAnswer, PictureRequest, Preview};
pub use request::{JobError, JobId, PossibleShape, Request, Running, Urgency, Work, time_left};
pub use source::{BurstSource, make_absolute};
pub use study::{ComparedPoses, PosesRequest, ReadTrajectory, StudyRequest, TrajectorySource, Which};

use std::sync::Arc;

macro_rules! equal_if {
    ($($of:ty: |$a:ident, $b:ident| $same:expr;)*) => {
        $(impl PartialEq for $of {
            fn eq(&self, other: &Self) -> bool {
                let ($a, $b) = (self, other);
                $same
            }
        })*
    };
}

// What decides an answer, where the whole is large or follows from that.
equal_if! {
    OpenBurst: |a, b| a.id == b.id;
    DetectionSource: |a, b| (&a.burst, &a.asked, &a.params) == (&b.burst, &b.asked, &b.params);
    Traced: |a, b| Arc::ptr_eq(&a.cache, &b.cache);
    CoherenceRequest: |a, b| Arc::ptr_eq(&a.detection, &b.detection);
    ComparisonRequest: |a, b| a.with == b.with && Arc::ptr_eq(&a.detection, &b.detection);
    MatchRequest: |a, b| Arc::ptr_eq(&a.a, &b.a) && Arc::ptr_eq(&a.b, &b.b) && a.params == b.params;
    LossesRequest: |a, b| Arc::ptr_eq(&a.result, &b.result);
    TrajectorySource: |a, b| a.path == b.path;
    PictureRequest: |a, b| a.key() == b.key();
    PictureAnswer: |a, b| a.request == b.request;
}
