//! Links from tooltips to the glossary: a tooltip says in a line what a thing is, its link says what the word means.

use crate::app::pane::{Content, KindOfPicture};
use crate::app::project::cursor::ViewKind;
use crate::teach::glossary::{Word, glossary};
use egui::{Context, Id, Label, Response, Ui, WidgetText};

/// Gives a widget a tooltip of a text and, where the glossary has a word for it, a link to that.
pub fn explained(response: Response, text: impl Into<WidgetText>, word: Option<&'static Word>) -> Response {
    response.on_hover_ui(|ui| {
        ui.add(Label::new(text).wrap());
        if let Some(word) = word {
            word_link_ui(ui, word);
        }
    })
}

/// A link to a word, for the tooltip of what it names.
pub fn word_link_ui(ui: &mut Ui, word: &Word) {
    if ui.link(format!("Glossary: {}", word.word)).clicked() {
        ui.ctx().data_mut(|data| data.insert_temp(asked_id(), word.name.clone()));
    }
}

/// The word that a tooltip's link asked for, once.
pub fn asked_for(ctx: &Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(asked_id()))
}

/// The word of this name.
pub fn word(name: &str) -> Option<&'static Word> {
    glossary().find(name)
}

/// The word for a kind of picture.
pub fn picture_word(content: Content, kind: ViewKind) -> Option<&'static Word> {
    glossary().of_picture(KindOfPicture::of_content(content, kind).word)
}

fn asked_id() -> Id {
    Id::unique("glossary word")
}
