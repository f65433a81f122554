//! What happened at this place, and what would keep a feature there?
//!
//! The search takes the samples of D that are extrema in place and scale as *candidates*, applies its tests to each in
//! a fixed order, and keeps those that pass. [`probe()`] repeats this around a place and joins the answers of all:
//!
//! | File | Answers |
//! | --- | --- |
//! | `probe` | what is near the place, and which candidate is meant; a summary |
//! | `candidates`, `order` | which samples compete, there or in the whole picture; which come first |
//! | `fate`, `candidate_tests` | value, limit and rival of each test: the record, and how it is filled |
//! | `remedy` | the one setting that would keep a candidate |
//! | `needed` | the frames, exposure or speed with which it would pass the noise gate |
//! | `hidden_cause` | causes that no single candidate shows: too small, at another slope, a ghost |
//! | `response`, `shares` | the response over slope and scale; the response of each single frame |
//! | `suspicion` | what is wrong with a kept feature, and what it likely is |
//! | `pixels` | what the pixels show: a period, the SNR of a flat spot, whether the picture moves by the slope |

mod candidate_tests;
mod candidates;
mod fate;
mod hidden_cause;
mod needed;
mod order;
mod pixels;
mod probe;
mod remedy;
mod response;
mod shares;
mod suspicion;

pub use candidate_tests::fate;
pub use candidates::{CandidateMark, Survey, SurveyOptions, TestCount, WinningSlopes, survey, winning_slopes};
pub use fate::{Fate, OnEdge, Outcome, Remedy, Rival, TestReport};
pub use hidden_cause::{Cause, CauseKind};
pub use needed::{Needed, frames_needed, needed};
pub use order::{AT_PLACE_PX, MOTION_PX, PlaceMotion, motion_limit};
pub use pixels::{Period, SpotSnr, period_along, spot_snr};
pub use probe::{Probe, ProbeOptions, ProbeSubject, Subject, check_place, fate_of, outside, probe};
pub use remedy::{duplicate_remedy, time_factor};
pub use response::{FineAxis, MapScale, ResponseMap, SlopePlane, outline, response_map};
pub use shares::{Shares, Slice, across, direction_of, shares, slice};
pub use suspicion::{Judged, Suspicion, SuspicionKind, Verdict, judged, kept, suspicions, suspicions_of_feature};

pub(super) use hidden_cause::too_small;
pub(super) use order::is_same_motion;
pub(super) use probe::{Near, near, sorted_by_stage};
