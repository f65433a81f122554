//! A part of the work in the background: what it wants, how its answers are taken, and whether all is there.

use crate::app::results::{Effect, Model, Read, Results};
use crate::engine::{Engine, Want};

/// Pass of the window. While the pointer drags a value, long work waits for the final one.
pub(super) struct Pass<'a> {
    pub model: &'a mut Model,
    pub engine: &'a Engine,
    pub dragging: bool,
}

pub(super) trait Part {
    fn wants<'m>(&self, results: &'m Results) -> Vec<&'m dyn Want>;

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect>;

    fn ask(&self, pass: &mut Pass<'_>);

    /// Whether all that this part wants is there, or failed.
    fn is_there(&self, model: Read<'_>) -> bool;
}
