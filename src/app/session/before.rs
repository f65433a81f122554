//! Layout of *Methods* in sessions before version 3, in which it had no panes.

use crate::app::pane::{MethodsPreset, Over};
use crate::app::project::Model;
use crate::app::project::method::Contender;
use crate::app::project::workspace::Workspace;
use serde::Deserialize;

/// Arrangement of the methods.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default)]
pub struct MethodsBefore {
    layout: MethodsPreset,
    two: [Contender; 2],
    wipe: f32,
    flipped: bool,
}

impl Default for MethodsBefore {
    fn default() -> Self {
        let two = [Contender::Sift, Contender::Buff1d];
        Self { layout: MethodsPreset::default(), two, wipe: 0.5, flipped: false }
    }
}

impl MethodsBefore {
    /// Reads the arrangement from the text of such a session; the default if it has none that can be read.
    pub fn from_toml(text: &str) -> Self {
        #[derive(Deserialize, Default)]
        #[serde(default)]
        struct Whole {
            methods: MethodsBefore,
        }
        toml::from_str::<Whole>(text).unwrap_or_default().methods
    }

    /// Arranges the methods of `model` accordingly; with `both`, with pictures of B too.
    pub fn apply(&self, model: &mut Model, both: bool) {
        model.panes.lay_out_methods(self.layout, &model.contenders(), both);
        let shown = model.panes.shown_in(Workspace::Methods);
        let Some(over) = shown.first().and_then(|id| model.panes.get(*id)?.over) else { return };
        for (id, method) in shown.iter().zip(self.two) {
            model.panes.get_mut(*id).into_iter().for_each(|pane| pane.show_method(Some(method)));
        }
        let at = if self.wipe.is_finite() { self.wipe.clamp(0.0, 1.0) } else { 0.5 };
        let over = match over {
            Over::Wipe { other, .. } => Over::Wipe { other, at },
            Over::Flip { other, .. } => Over::Flip { other, flipped: self.flipped },
        };
        model.panes.get_mut(shown[0]).into_iter().for_each(|pane| pane.over = Some(over));
    }
}
