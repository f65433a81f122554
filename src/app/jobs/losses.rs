//! Where the features of a pair were lost: asked for once there are matches, and with it the patches of what they
//! were compared with.

use crate::app::project::workspace::Workspace;
use crate::app::window::BurstscopeApp;
use crate::requests::{LossesRequest, PictureRequest};
use std::sync::Arc;

/// What was asked for last.
#[derive(Default)]
pub(in crate::app) struct LossesAsked {
    losses: Option<LossesRequest>,
    pictures: Vec<PictureRequest>,
}

fn same_pictures(a: &[PictureRequest], b: &[PictureRequest]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.same_picture(b))
}

impl BurstscopeApp {
    /// Takes what the workers published.
    pub(in crate::app) fn take_losses(&mut self) {
        // What was cancelled or failed is asked for again with the next matches.
        for found in self.engine.losses.poll().filter_map(|answer| answer.result.ok()) {
            self.model.pair.lost.found = Some(Arc::new(found));
        }
        for pictures in self.engine.losses.poll_pictures().filter_map(|answer| answer.result.ok()) {
            self.model.pair.lost.pictures = pictures;
        }
        self.model.pair.lost.busy = self.engine.losses.running();
    }

    /// Asks for what is wanted and not there.
    pub(in crate::app) fn request_losses(&mut self) {
        if self.model.workspace != Workspace::Pair {
            return;
        }
        if let Some(wanted) = self.model.wanted_losses()
            && !self.losses_asked.losses.as_ref().is_some_and(|asked| asked.same_pair(&wanted))
        {
            self.engine.losses.start(wanted.clone());
            self.losses_asked.losses = Some(wanted);
        }
        self.model.refresh_why();
        let wanted = self.model.wanted_candidate_pictures();
        if !wanted.is_empty() && !same_pictures(&self.losses_asked.pictures, &wanted) {
            self.engine.losses.request_pictures(wanted.clone());
            self.losses_asked.pictures = wanted;
        }
    }
}
