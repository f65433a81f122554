//! The studies of the detector, on small inputs with numbers that must be plausible: charts, accuracy, planted things,
//! advice, and matches along a trajectory.

#[path = "../../../core/tests/common/prelude.rs"]
mod prelude;
#[path = "../../../core/tests/common/shared.rs"]
mod shared;

mod accuracy;
mod advice;
mod curves;
mod evaluate;
mod pose_errors;
mod poses;
mod reconstruction;
mod recover;
mod trajectory;
