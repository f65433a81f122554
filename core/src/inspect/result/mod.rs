//! How good is the result of a search as a whole?
//!
//! With the truth of a synthetic burst, `score` decides which feature finds which disc and draws the curve over the
//! threshold, and `truth` gives the reason of each miss. Without a truth, `decoys` estimates from the burst itself how
//! many features are false. `changes` compares two results: before and after a change, or with another program's.

mod changes;
mod decoys;
mod score;
mod too_few;
mod truth;

pub use changes::{Changes, ForeignFeature, Same, Spot, compare, read_features};
pub use decoys::{DecoyReport, DecoyStudy, Decoys, FalseRate, SNRS, decoys};
pub use score::{Curve, CurvePoint, Ranking, Scored, finds, judge, judge_by_discs, mean_curve};
pub use too_few::{TooFew, has_too_few, too_few};
pub use truth::{AgainstTruth, Miss, against_truth, has_truth, miss, read_truth, truth_of};
