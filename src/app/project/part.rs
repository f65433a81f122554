//! Part of the project with background work: what it wants of the engine, takes and asks for.

use super::{Effect, Model};
use crate::engine::{Ended, Engine, Want, Wanted};
use crate::requests::Request;

/// Pass of the window. While the pointer drags a value, long work waits for the final one.
pub(super) struct Pass<'a> {
    pub model: &'a mut Model,
    pub engine: &'a Engine,
    pub dragging: bool,
}

pub(super) trait Part {
    fn wants<'m>(&self, model: &'m Model) -> Vec<&'m dyn Want>;

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect>;

    fn ask(&self, pass: &mut Pass<'_>);

    /// Whether all that this part wants is there, or failed.
    fn is_there(&self, model: &Model) -> bool;
}

/// A part that wants one thing.
pub(super) struct One<R: Request> {
    pub wanted: fn(&Model) -> &Wanted<R>,
    pub wanted_mut: fn(&mut Model) -> &mut Wanted<R>,
    /// Request for what is missing now, with and without a drag.
    pub missing: fn(&Model, bool) -> Option<R>,
    /// Whether a request ends when nothing is missing any more.
    pub ends: bool,
    pub take: fn(&mut Model, Ended<R>, &Engine) -> Vec<Effect>,
    /// Takes what was done of a request that still runs.
    pub take_partial: fn(&mut Model, R::Partial),
}

impl<R: Request> Part for One<R> {
    fn wants<'m>(&self, model: &'m Model) -> Vec<&'m dyn Want> {
        vec![(self.wanted)(model)]
    }

    fn take(&self, pass: &mut Pass<'_>) -> Vec<Effect> {
        for partial in (self.wanted_mut)(pass.model).take_partial() {
            (self.take_partial)(pass.model, partial);
        }
        let ended = (self.wanted_mut)(pass.model).take();
        ended.into_iter().flat_map(|ended| (self.take)(pass.model, ended, pass.engine)).collect()
    }

    fn ask(&self, pass: &mut Pass<'_>) {
        let missing = (self.missing)(pass.model, pass.dragging);
        if self.ends || missing.is_some() {
            (self.wanted_mut)(pass.model).want(pass.engine, missing);
        }
    }

    fn is_there(&self, model: &Model) -> bool {
        (self.missing)(model, false).is_none_or(|missing| (self.wanted)(model).has_failed(&missing))
    }
}
