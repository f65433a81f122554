//! Offer to restore the session after the program ended unexpectedly.

use crate::app::recovery::Offer;
use crate::inspect::words::counted;
use egui::{Button, RichText, Ui};
use std::time::Duration;

/// Choice of the user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecoveryChoice {
    /// Open it.
    Restore,
    /// Remove it.
    Forget,
}

/// Draws the offer. Returns the choice, once it is made.
pub fn recovery_ui(ui: &mut Ui, offer: &Offer) -> Option<RecoveryChoice> {
    let mut choice = None;
    ui.horizontal_wrapped(|ui| {
        let more = if offer.more == 0 { String::new() } else { format!(" ({} more)", offer.more) };
        let text =
            format!("Burstscope ended unexpectedly. Its session was saved {}: {}{more}.", ago(offer.age), offer.label);
        ui.label(RichText::new(text).color(crate::app::style::warning(ui)));
        let restore = ui.add_enabled(!offer.is_restoring, Button::new("Restore"));
        if restore.on_hover_text("Open the saved session in place of what is open now").clicked() {
            choice = Some(RecoveryChoice::Restore);
        }
        let forget = ui.add_enabled(!offer.is_restoring, Button::new("Discard"));
        if forget.on_hover_text("Delete the saved session; the files that it names stay").clicked() {
            choice = Some(RecoveryChoice::Forget);
        }
    });
    choice
}

/// Describes an age in the largest unit that fits.
fn ago(age: Duration) -> String {
    let minutes = age.as_secs() / 60;
    let (count, unit) = match minutes {
        0 => return "just now".to_owned(),
        1..60 => (minutes, "minute"),
        60..2880 => (minutes / 60, "hour"),
        _ => (minutes / 1440, "day"),
    };
    format!("{} ago", counted(count as usize, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_age_is_said_in_words() {
        let words = [(59, "just now"), (60, "1 minute ago"), (3 * 3600, "3 hours ago"), (50 * 3600, "2 days ago")];
        for (seconds, wanted) in words {
            assert_eq!(ago(Duration::from_secs(seconds)), wanted);
        }
    }
}
