//! Thumbnails of a dataset's bursts: requested as they come into view, and kept on the card up to a number.

use crate::burst::{BurstFiles, OpenOptions};
use crate::dataset::Thumbnail;
use crate::engine::{Engine, Wanted};
use crate::requests::ThumbnailsRequest;
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use std::collections::HashMap;

/// Maximum side of a thumbnail, pixels.
pub const SIDE_PX: usize = 160;
/// Maximum number of thumbnails kept.
const MOST_KEPT: usize = 400;
/// Maximum number of thumbnails in a request, so that those that come into view soon need not wait long.
const MOST_ASKED: usize = 8;

/// State of a thumbnail.
pub enum Shown {
    /// Requested.
    Asked,
    /// Available.
    Picture(TextureHandle),
    /// Failed, with the reason.
    Failed(String),
}

/// Thumbnails of one dataset, by the bursts' names.
#[derive(Default)]
pub struct Thumbnails {
    shown: HashMap<String, Shown>,
    /// Bursts that came into view in this pass.
    in_view: Vec<BurstFiles>,
    wanted: Wanted<ThumbnailsRequest>,
}

impl Thumbnails {
    /// Removes all thumbnails: another dataset was opened.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// State of the thumbnail of `burst`; an unknown one is requested next.
    pub fn get(&mut self, burst: &BurstFiles) -> Option<&Shown> {
        if !self.shown.contains_key(&burst.name) {
            self.in_view.push(burst.clone());
        }
        self.shown.get(&burst.name)
    }

    /// Whether some thumbnails that came into view are still missing.
    pub fn is_waiting(&self) -> bool {
        !self.in_view.is_empty() || self.shown.values().any(|s| matches!(s, Shown::Asked))
    }

    /// Requests the thumbnails that came into view in this pass from the workers; bursts are opened with `open`.
    pub fn request(&mut self, engine: &Engine, open: &OpenOptions) {
        let mut bursts = std::mem::take(&mut self.in_view);
        if bursts.is_empty() || self.wanted.is_pending() {
            return;
        }
        if self.shown.len() + bursts.len() > MOST_KEPT {
            // Those in view are made again soon; this is simpler than tracking which were seen last.
            self.shown.clear();
        }
        bursts.truncate(MOST_ASKED);
        self.shown.extend(bursts.iter().map(|b| (b.name.clone(), Shown::Asked)));
        self.wanted.ask(engine, ThumbnailsRequest { bursts, max_side_px: SIDE_PX, open: open.clone() });
    }

    /// Takes the pictures that were made of `bursts`.
    pub fn take_made(&mut self, ctx: &Context, bursts: &[BurstFiles]) {
        for (source, picture) in self.wanted.take_told().into_iter().filter(|(source, _)| bursts.contains(source)) {
            let shown = match picture {
                Ok(Thumbnail { width, height, rgb }) => {
                    let image = ColorImage::from_rgb([width, height], &rgb);
                    Shown::Picture(ctx.load_texture(&source.name, image, TextureOptions::LINEAR))
                }
                Err(error) => Shown::Failed(error),
            };
            self.shown.insert(source.name.clone(), shown);
        }
        self.wanted.take();
    }
}
