//! What a pane can be told: its menu, which is also a part of what a click with the second button on its picture shows.

use crate::app::actions::{ActionId, Queue, menu::item_ui};
use crate::app::pane::{Content, Direction, Link, Over, PaneId, Preset, SliceAxis};
use crate::app::project::Model;
use crate::app::project::cursor::ViewKind;
use crate::app::project::pair::Side;
use crate::engine::MapKind;
use egui::{Button, Ui};

/// What a pane asks for that changes which panes there are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// A second pane beside this one.
    Split(PaneId, Direction),
    /// This pane away.
    Close(PaneId),
    /// All panes anew, from this one.
    LayOut(PaneId, Preset),
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
        for preset in Preset::ALL {
            if ui.button(preset.label()).on_hover_text(preset.help()).clicked() {
                changes.push(Change::LayOut(id, preset));
            }
        }
    });
}

/// What it shows, and of which burst.
fn content_ui(ui: &mut Ui, model: &mut Model, id: PaneId) {
    let others: Vec<(PaneId, usize)> = other_panes(model, id);
    let both = model.burst_of(Side::B).is_some();
    let Some(pane) = model.panes.get_mut(id) else { return };
    for kind in ViewKind::ALL {
        if ui.radio(pane.shows(kind), kind.label()).clicked() {
            pane.show(kind);
        }
    }
    if ui.radio(pane.content == Content::Merge, "Merged frames").clicked() {
        pane.content = Content::Merge;
    }
    for map in MapKind::ALL {
        if ui.radio(pane.content == Content::Map(map), map.label()).on_hover_text(map.help()).clicked() {
            pane.content = Content::Map(map);
        }
    }
    for axis in SliceAxis::ALL {
        if ui.radio(pane.content == Content::Slice(axis), axis.label()).on_hover_text(axis.help()).clicked() {
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
    let mut side = pane.side;
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

/// The panes but `id` that show pictures of their own, with their numbers.
fn other_panes(model: &Model, id: PaneId) -> Vec<(PaneId, usize)> {
    let own = |other: &PaneId| {
        let pane = model.panes.get(*other);
        *other != id && pane.is_some_and(|pane| !matches!(pane.content, Content::Difference(..) | Content::Slice(_)))
    };
    model.panes.shown().into_iter().filter(own).filter_map(|other| Some((other, model.panes.number(other)?))).collect()
}

/// Which other picture is laid over it.
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
