//! Copies of the toolkit's own textures in main memory: letters, icons, small pictures.
//!
//! The toolkit hands each texture to the card once and forgets it. When the card's device is lost, a new one must get
//! them all again; so they are kept here too (a whole image shares its pixels with its creator). The pictures of bursts
//! are not among them: they come with each frame, and are uploaded where they are missing.

use egui::epaint::{ColorImage, ImageData, ImageDelta, TextureId};
use egui::{Context, FullOutput, TextureOptions};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Plugin that keeps the textures of its context.
#[derive(Default)]
pub(super) struct TextureMirror {
    textures: BTreeMap<u64, (Arc<ColorImage>, TextureOptions)>,
    /// Whether a new device needs all of them.
    wanted: bool,
}

/// Number of a texture that the toolkit manages; textures of others are not kept.
fn managed(id: TextureId) -> Option<u64> {
    match id {
        TextureId::Managed(number) => Some(number),
        TextureId::User(_) => None,
    }
}

impl TextureMirror {
    /// Keeps the textures of `ctx` from now on; if they are kept already, the next frame uploads all of them again.
    pub(super) fn install(ctx: &Context) {
        if ctx.with_plugin(|mirror: &mut Self| mirror.wanted = true).is_none() {
            ctx.add_plugin(Self::default());
        }
    }

    fn take(&mut self, id: TextureId, delta: &ImageDelta) {
        let Some(number) = managed(id) else { return };
        let ImageData::Color(image) = &delta.image;
        match (delta.pos, self.textures.get_mut(&number)) {
            (None, _) => {
                self.textures.insert(number, (image.clone(), delta.options));
            }
            (Some([left, top]), Some((whole, options))) => {
                *options = delta.options;
                let whole = Arc::make_mut(whole);
                let (width, whole_width) = (image.width(), whole.width());
                for (row, pixels) in image.pixels.chunks_exact(width.max(1)).enumerate() {
                    let start = (top + row) * whole_width + left;
                    if let Some(place) = whole.pixels.get_mut(start..start + width) {
                        place.copy_from_slice(pixels);
                    }
                }
            }
            // Part of a texture that was never set whole.
            (Some(_), None) => {}
        }
    }

    fn all(&self) -> impl Iterator<Item = (TextureId, ImageDelta)> {
        let whole = |(image, options): &(Arc<ColorImage>, TextureOptions)| ImageDelta::full(image.clone(), *options);
        self.textures.iter().map(move |(number, texture)| (TextureId::Managed(*number), whole(texture)))
    }
}

impl egui::Plugin for TextureMirror {
    fn debug_name(&self) -> &'static str {
        "burstscope textures"
    }

    fn output_hook(&mut self, _ctx: &Context, output: &mut FullOutput) {
        let delta = &mut output.textures_delta;
        for (id, deltas) in &delta.set {
            deltas.iter().for_each(|delta| self.take(*id, delta));
        }
        if std::mem::take(&mut self.wanted) {
            self.all().for_each(|(id, whole)| delta.push(id, whole));
        }
        self.textures.retain(|number, _| !delta.free.contains(&TextureId::Managed(*number)));
    }
}

/// All textures of `ctx` that the toolkit manages, whole. Empty before [`super::install`].
pub fn textures_of(ctx: &Context) -> Vec<(TextureId, ImageDelta)> {
    ctx.with_plugin(|mirror: &mut TextureMirror| mirror.all().collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Color32;

    /// Ids of the textures that a pass sets whole.
    fn pass(ctx: &Context, draw: impl FnMut(&mut egui::Ui)) -> Vec<TextureId> {
        let output = ctx.run_ui(egui::RawInput::default(), draw);
        let whole = output.textures_delta.set.iter().filter(|(_, deltas)| deltas.iter().any(ImageDelta::is_whole));
        let ids = whole.map(|(id, _)| *id).collect();
        output.textures_delta.clear_on_drop();
        ids
    }

    trait ClearOnDrop {
        fn clear_on_drop(self);
    }

    impl ClearOnDrop for egui::TexturesDelta {
        fn clear_on_drop(mut self) {
            self.set.clear();
            self.free.clear();
        }
    }

    #[test]
    fn textures_are_kept_as_the_card_has_them_and_come_again_once() {
        let ctx = Context::default();
        TextureMirror::install(&ctx);
        let image = ColorImage::filled([4, 3], Color32::RED);
        let mut texture = ctx.load_texture("test", image, TextureOptions::NEAREST);
        pass(&ctx, |_| {});
        texture.set_partial([1, 2], ColorImage::filled([2, 1], Color32::BLUE), TextureOptions::NEAREST);
        let changed = pass(&ctx, |_| {});
        assert!(!changed.contains(&texture.id()), "only a part is sent");
        let kept = textures_of(&ctx);
        let (_, delta) = kept.iter().find(|(id, _)| *id == texture.id()).expect("it is kept");
        let ImageData::Color(pixels) = &delta.image;
        let blue: Vec<usize> = (0..12).filter(|i| pixels.pixels[*i] == Color32::BLUE).collect();
        assert_eq!(blue, [9, 10]);
        // A new device gets all of them, once.
        TextureMirror::install(&ctx);
        let again = pass(&ctx, |_| {});
        assert!(again.contains(&texture.id()) && again.contains(&TextureId::default()));
        assert!(pass(&ctx, |_| {}).is_empty());
        // Freed textures are not kept.
        let id = texture.id();
        drop(texture);
        pass(&ctx, |_| {});
        assert!(textures_of(&ctx).iter().all(|(kept, _)| *kept != id));
    }
}
