//! Menu of a pane; it is also part of the menu that the secondary button opens on its picture.

use crate::app::actions::{ActionId, Queue, menu::item_ui, shown_by};
use crate::app::pane::{Content, Direction, Link, MethodsPreset, Over, Pane, PaneId, Preset, SidesPreset, SliceAxis};
use crate::app::project::Model;
use crate::app::project::cursor::ViewKind;
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::words::{explained, picture_word};
use crate::requests::MapKind;
use egui::{Button, Ui};

/// Request of a pane that changes the set of panes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// Add a second pane beside this one.
    Split(PaneId, Direction),
    /// Close this pane.
    Close(PaneId),
    /// Lay all panes out anew, from this one.
    LayOut(PaneId, Preset),
    /// Lay out *Two bursts* anew.
    LayOutSides(SidesPreset),
    /// Lay out *Methods* anew.
    LayOutMethods(MethodsPreset),
}

/// Draws the menu of pane `id`.
pub(super) fn pane_menu_ui(ui: &mut Ui, model: &mut Model, id: PaneId, changes: &mut Vec<Change>, queue: &mut Queue) {
    ui.set_min_width(190.0);
    content_ui(ui, model, id);
    ui.separator();
    over_ui(ui, model, id);
    links_ui(ui, model, id);
    ui.separator();
    for action in [ActionId::Fit, ActionId::OneToOne] {
        item_ui(ui, model, queue, action);
    }
    ui.separator();
    for (label, direction) in [("Split right", Direction::Right), ("Split down", Direction::Down)] {
        if ui.button(label).clicked() {
            changes.push(Change::Split(id, direction));
        }
    }
    if ui.add_enabled(model.panes.are_many(), Button::new("Close pane")).clicked() {
        changes.push(Change::Close(id));
    }
    ui.menu_button("Layout", |ui| {
        let layouts: Vec<(&str, &str, Change)> = match model.workspace {
            Workspace::Pair => {
                SidesPreset::ALL.map(|preset| (preset.label(), preset.help(), Change::LayOutSides(preset))).to_vec()
            }
            Workspace::Methods => {
                MethodsPreset::ALL.map(|preset| (preset.label(), preset.help(), Change::LayOutMethods(preset))).to_vec()
            }
            _ => Preset::ALL.map(|preset| (preset.label(), preset.help(), Change::LayOut(id, preset))).to_vec(),
        };
        for (label, help, change) in layouts {
            if ui.button(label).on_hover_text(help).clicked() {
                changes.push(change);
            }
        }
    });
}

/// Draws the choice of content and burst.
fn content_ui(ui: &mut Ui, model: &mut Model, id: PaneId) {
    let others: Vec<(PaneId, usize)> = other_panes(model, id);
    let both = model.burst_of(Side::B).is_some();
    let methods = model.contenders();
    let Some(pane) = model.panes.get_mut(id) else { return };
    for kind in ViewKind::ALL {
        let radio = ui.radio(pane.shows(kind), kind.label());
        if explained(radio, shown_by(kind.shown()).action().help, picture_word(Content::Cursor, kind)).clicked() {
            pane.show(kind);
        }
    }
    let choice_ui = |ui: &mut Ui, pane: &Pane, content: Content, label: &str, help: &str| {
        let radio = ui.radio(pane.content == content, label);
        explained(radio, help, picture_word(content, pane.cursor.kind)).clicked()
    };
    if choice_ui(ui, pane, Content::Merge, "Merged frames", ActionId::ShowMerge.action().help) {
        pane.content = Content::Merge;
    }
    for map in MapKind::ALL {
        if choice_ui(ui, pane, Content::Map(map), map.about().label, map.about().help) {
            pane.content = Content::Map(map);
        }
    }
    for axis in SliceAxis::ALL {
        if choice_ui(ui, pane, Content::Slice(axis), axis.label(), axis.help()) {
            pane.show_slice(axis);
        }
    }
    ui.add_enabled_ui(others.len() > 1, |ui| {
        let menu = ui.menu_button("Difference", |ui| {
            for &(a, number_a) in &others {
                ui.menu_button(format!("{number_a} minus"), |ui| {
                    for &(b, number_b) in others.iter().filter(|(b, _)| *b != a) {
                        if ui.button(format!("{number_a} − {number_b}")).clicked() {
                            pane.content = Content::Difference(a, b);
                        }
                    }
                });
            }
        });
        menu.response.on_disabled_hover_text("A difference needs two other panes: split this one first");
    });
    let (mut side, mut method) = (pane.side, pane.method);
    if let Some(chosen) = &mut method {
        ui.menu_button(format!("Method: {}", chosen.label()), |ui| {
            for one in methods {
                ui.radio_value(chosen, one, one.label()).on_hover_text(one.help());
            }
        });
        pane.show_method(method);
    }
    if both {
        ui.horizontal(|ui| {
            ui.label("Burst");
            for one in Side::BOTH {
                ui.radio_value(&mut side, one, one.name());
            }
        });
        model.panes.show_side(id, side);
    }
}

/// Other panes that show pictures of their own, with their numbers.
fn other_panes(model: &Model, id: PaneId) -> Vec<(PaneId, usize)> {
    let own = |other: &PaneId| {
        let pane = model.panes.get(*other);
        *other != id && pane.is_some_and(|pane| !matches!(pane.content, Content::Difference(..) | Content::Slice(_)))
    };
    model.panes.shown().into_iter().filter(own).filter_map(|other| Some((other, model.panes.number(other)?))).collect()
}

/// Draws the choice of a picture laid over the pane's own.
fn over_ui(ui: &mut Ui, model: &mut Model, id: PaneId) {
    let others: Vec<(PaneId, usize)> = model
        .panes
        .shown()
        .into_iter()
        .filter(|other| *other != id)
        .filter_map(|other| Some((other, model.panes.number(other)?)))
        .collect();
    let Some(pane) = model.panes.get_mut(id) else { return };
    ui.add_enabled_ui(!others.is_empty(), |ui| {
        let wipe = |other| Over::Wipe { other, at: 0.5 };
        let flip = |other| Over::Flip { other, flipped: false };
        let ways: [(&str, &dyn Fn(PaneId) -> Over); 2] = [("Wipe with", &wipe), ("Flip with", &flip)];
        for (label, over) in ways {
            ui.menu_button(label, |ui| {
                for &(other, number) in &others {
                    if ui.button(format!("Pane {number}")).clicked() {
                        pane.over = Some(over(other));
                    }
                }
            });
        }
    });
    if pane.over.is_some() && ui.button("Nothing over it").clicked() {
        pane.over = None;
    }
}

fn links_ui(ui: &mut Ui, model: &mut Model, id: PaneId) {
    let many = model.panes.are_many();
    ui.add_enabled_ui(many, |ui| {
        ui.menu_button("Links", |ui| {
            for link in Link::ALL {
                let mut on = model.panes.get(id).is_some_and(|pane| pane.links.has(link));
                if ui.checkbox(&mut on, link.label()).on_hover_text(link.help()).changed() {
                    model.set_link(id, link, on);
                }
            }
        });
    });
}
