//! Requests for background work and their answers. A request is an immutable snapshot of all that decides its answer;
//! `compute` makes it on the calling thread and its pool, and stops with [`JobError::Cancelled`] once its
//! [`Monitor`](crate::monitor::Monitor) is cancelled. [`crate::engine`] decides when, where, and which of several wins.

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
mod pictures;
mod request;
mod source;
mod study;
mod trail;

pub use comparison::{ComparedWith, ComparisonRequest, Differences, OthersSource, ReferenceSource};
pub use dataset::{
    Bursts, DatasetAnswer, DatasetEvent, DatasetRequest, Keeping, OpenDataset, ThumbnailsRequest, next_commands,
};
#[cfg(feature = "colmap")]
pub use dataset::{ColmapDone, ColmapRequest};
pub use detect::{
    CompareRequest, Compared, DetectRequest, Detected, MatchRequest, Matched, OpenRequest, detect_line, window_line,
};
pub use explain::{
    CoherenceRequest, Coherences, ExplainQuestion, ExplainRequest, Explained, Explanation, FoundLosses, LossesRequest,
    ProbeQuestion, ProbeRequest, Probed, Traced,
};
pub use figure::{
    FigurePicture, FigurePreview, FigureRequest, MatchFigure, MatchPictures, are_stacked, page_drawing, titled,
};
pub use film::{Film, FilmStep, MAX_FILM_PICTURES, Rasteriser, Sweep, slope_legend};
pub use kind::{AboutView, PictureKind, RangeClass, ViewKind};
pub use map::{MotionMap, SlopeColours, line_of};
pub use open::{BurstId, OpenBurst, PREVIEW_OCTAVES};
pub(crate) use picture::PictureKey;
pub use picture::{PictureAnswer, PictureRequest};
pub use pictures::PicturesRequest;
pub use request::{Caches, JobError, JobId, PictureStore, PossibleShape, Request, Running, Urgency, Work, time_left};
pub use source::BurstSource;
pub use study::{ComparedPoses, PosesRequest, ReadTrajectory, StudyRequest, TrajectorySource, Which};
pub(crate) use trail::trail_of;
pub use trail::{DetectionSource, NothingKept, TrailStore};
