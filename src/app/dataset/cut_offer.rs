//! Offer to cut a film that was opened as one burst.

use crate::inspect::words::counted;
use egui::{RichText, Ui};

/// Choice of the user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutChoice {
    /// Cut it into bursts of the offered length.
    Cut,
    /// Ask how it is cut.
    Ask,
    /// Leave it as it is.
    Keep,
}

/// Draws the offer to cut a film of `frames` frames into bursts of `length`.
pub fn cut_offer_ui(ui: &mut Ui, frames: usize, length: usize) -> Option<CutChoice> {
    let mut choice = None;
    ui.horizontal_wrapped(|ui| {
        let text = format!("{} are long for one burst: nothing moves evenly for so long.", counted(frames, "frame"));
        ui.label(RichText::new(text).color(crate::app::style::warning(ui)));
        let cut = ui.button(format!("Cut into bursts of {length}"));
        if cut.on_hover_text("Open them as a dataset, one burst after another").clicked() {
            choice = Some(CutChoice::Cut);
        }
        if ui.button("Cut…").on_hover_text("Choose length and step of the bursts first").clicked() {
            choice = Some(CutChoice::Ask);
        }
        if ui.button("Keep as one").on_hover_text("Look at all frames as one burst").clicked() {
            choice = Some(CutChoice::Keep);
        }
    });
    choice
}
