//! The small pictures of a dataset's bursts: asked for as they come into view, and kept on the card up to a number.

use crate::burst::{BurstSource, OpenOptions};
use crate::dataset::Thumbnail;
use crate::engine::DatasetWorkers;
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use std::collections::HashMap;

/// No side of a small picture is longer, in pixels.
pub const SIDE_PX: usize = 160;
/// At most this many are kept.
const MOST_KEPT: usize = 400;
/// At most this many are asked for at once, so that what comes into view soon has its turn.
const MOST_ASKED: usize = 8;

/// A small picture.
pub enum Shown {
    /// It was asked for.
    Asked,
    /// It is there.
    Picture(TextureHandle),
    /// There is none, and why.
    Failed(String),
}

/// The small pictures of one dataset, by the bursts' names.
#[derive(Default)]
pub struct Thumbnails {
    shown: HashMap<String, Shown>,
    wanted: Vec<BurstSource>,
}

impl Thumbnails {
    /// Forgets all pictures: another dataset was opened.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// The picture of `burst`, if it is there; otherwise it is wanted from now on.
    pub fn get(&mut self, burst: &BurstSource) -> Option<&Shown> {
        if !self.shown.contains_key(&burst.name) {
            self.wanted.push(burst.clone());
        }
        self.shown.get(&burst.name)
    }

    /// Whether some that came into view are not there yet.
    pub fn is_waiting(&self) -> bool {
        !self.wanted.is_empty() || self.shown.values().any(|s| matches!(s, Shown::Asked))
    }

    /// Asks the workers for what came into view in this pass, opened with `open`.
    pub fn request(&mut self, workers: &DatasetWorkers, open: &OpenOptions) {
        let mut wanted = std::mem::take(&mut self.wanted);
        if wanted.is_empty() || workers.makes_thumbnails() {
            return;
        }
        if self.shown.len() + wanted.len() > MOST_KEPT {
            // Those in view come back soon; that is simpler than knowing which were seen last.
            self.shown.clear();
        }
        wanted.truncate(MOST_ASKED);
        self.shown.extend(wanted.iter().map(|b| (b.name.clone(), Shown::Asked)));
        workers.request_thumbnails(wanted, SIDE_PX, open.clone());
    }

    /// Takes a picture that the workers made of `source`, if it is one of `bursts`.
    pub fn take(
        &mut self,
        ctx: &Context,
        bursts: &[BurstSource],
        source: &BurstSource,
        picture: Result<Thumbnail, String>,
    ) {
        if !bursts.contains(source) {
            return;
        }
        let shown = match picture {
            Ok(Thumbnail { width, height, rgb }) => {
                let image = ColorImage::from_rgb([width, height], &rgb);
                Shown::Picture(ctx.load_texture(&source.name, image, TextureOptions::LINEAR))
            }
            Err(error) => Shown::Failed(error),
        };
        self.shown.insert(source.name.clone(), shown);
    }
}
