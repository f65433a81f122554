//! Words of choices, and links to the glossary: from tooltips, which describe an item in a line, to what explains the
//! term, and from captions.

use crate::teach::glossary::{Word, glossary};
use egui::mutex::Mutex;
use egui::{Context, Id, Label, Response, Ui, WidgetText};
use egui_commonmark::{CommonMarkCache, CommonMarkViewer};
use std::sync::Arc;

/// Declares the choices of a menu or of a row of buttons: a type of their names, in the order in which they are
/// offered, each with its label and help.
macro_rules! choices {
    ($(#[$of:meta])* $name:ident { $($(#[$one:meta])* $choice:ident: $label:literal, $help:literal;)+ }) => {
        $(#[$of])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $($(#[$one])* $choice),+
        }

        impl $name {
            pub const ALL: [Self; [$(Self::$choice),+].len()] = [$(Self::$choice),+];

            pub fn words(self) -> [&'static str; 2] {
                match self {
                    $(Self::$choice => [$label, $help]),+
                }
            }
        }
    };
}
pub(in crate::app) use choices;

/// Adds a tooltip with `text` to a widget and, if `word` is given, a link to that glossary entry.
pub fn explained(response: Response, text: impl Into<WidgetText>, word: Option<&'static Word>) -> Response {
    response.on_hover_ui(|ui| {
        ui.add(Label::new(text).wrap());
        let Some(word) = word else { return };
        if ui.link(format!("Glossary: {}", word.word)).clicked() {
            ask_for(ui.ctx(), &word.name);
        }
        if let Some(origin) = word.origin {
            ui.add(Label::new(egui::RichText::new(origin.words()[1]).small().weak()).wrap());
        }
    })
}

const GLOSSARY: &str = "word:";

/// What the toolkit keeps of captions, with a hook for each entry of the glossary that they lead to.
#[derive(Clone)]
struct Captions(Arc<Mutex<CommonMarkCache>>);

impl Default for Captions {
    fn default() -> Self {
        let mut cache = CommonMarkCache::default();
        glossary().words.iter().for_each(|word| cache.add_link_hook(format!("{GLOSSARY}{}", word.name)));
        Self(Arc::new(Mutex::new(cache)))
    }
}

/// Draws a text. A click on a link asks for its entry of the glossary.
pub fn caption_ui(ui: &mut Ui, text: &str) {
    let captions: Captions = ui.data_mut(|data| data.get_temp_mut_or_default::<Captions>(Id::NULL).clone());
    let mut cache = captions.0.lock();
    CommonMarkViewer::new().indentation_spaces(2).show(ui, &mut cache, text);
    let clicked = cache.link_hooks().iter().find(|(_, clicked)| **clicked);
    if let Some(name) = clicked.and_then(|(link, _)| link.strip_prefix(GLOSSARY)) {
        ask_for(ui.ctx(), name);
    }
}

fn ask_for(ctx: &Context, name: &str) {
    ctx.data_mut(|data| data.insert_temp(asked_id(), name.to_owned()));
    ctx.request_repaint();
}

/// Name of the entry whose link was clicked; returned once.
pub fn asked_for(ctx: &Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(asked_id()))
}

pub fn word(name: &str) -> Option<&'static Word> {
    glossary().find(name)
}

fn asked_id() -> Id {
    Id::unique("glossary word")
}
