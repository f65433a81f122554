//! Preset arrangements of *Two bursts*.

use super::set::place_of;
use super::{Arrangement, Content, Pane, PaneId, Panes};
use crate::app::document::cursor::ViewKind;
use crate::app::document::side::Side;
use crate::teach::Workspace;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SidesPreset {
    SideBySide,
    Stacked,
    StackAndDog,
    Difference,
}

impl SidesPreset {
    pub const ALL: [Self; 4] = [Self::SideBySide, Self::Stacked, Self::StackAndDog, Self::Difference];

    pub fn label(self) -> &'static str {
        match self {
            Self::SideBySide => "A beside B",
            Self::Stacked => "A above B",
            Self::StackAndDog => "Stack and DoG of both",
            Self::Difference => "A, B and their difference",
        }
    }

    pub fn help(self) -> &'static str {
        match self {
            Self::SideBySide => "One picture of each burst, A on the left",
            Self::Stacked => "One picture of each burst, A on top: for wide frames",
            Self::StackAndDog => "The motion stacks of both bursts above their DoG responses",
            Self::Difference => "Both pictures, and below them A less B, pixel by pixel",
        }
    }
}

impl Panes {
    pub fn lay_out_sides(&mut self, preset: SidesPreset) {
        let own = Side::BOTH.map(PaneId::of);
        let mut made = BTreeMap::new();
        for (id, pane) in own.into_iter().zip(&self.sides) {
            made.insert(id, Pane { over: None, content: Content::Cursor, ..pane.clone() });
        }
        let rows = match preset {
            SidesPreset::SideBySide => vec![own.to_vec()],
            SidesPreset::Stacked => own.map(|id| vec![id]).to_vec(),
            SidesPreset::StackAndDog => {
                let dogs = own.map(|id| {
                    let mut dog = made[&id].clone();
                    dog.show(ViewKind::Dog);
                    let new = self.fresh();
                    made.insert(new, dog);
                    new
                });
                made.iter_mut().filter(|(id, _)| own.contains(id)).for_each(|(_, pane)| pane.show(ViewKind::Stack));
                vec![own.to_vec(), dogs.to_vec()]
            }
            SidesPreset::Difference => {
                let difference = Pane { content: Content::Difference(own[0], own[1]), ..made[&own[0]].clone() };
                let new = self.fresh();
                made.insert(new, difference);
                vec![own.to_vec(), vec![new]]
            }
        };
        let focus = self.placed_in(Workspace::Pair).1;
        self.replace(place_of(Workspace::Pair), Arrangement::rows(&rows), made, focus);
    }
}
