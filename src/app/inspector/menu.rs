//! Menus of a pane: of its header, and of its picture, with items for the feature or match and the place there.

use super::marks::mid_burst;
use super::widgets::MenuPlace;
use super::{Drawn, PaneWidgets};
use crate::app::actions::menu::item_ui;
use crate::app::actions::{ActionId, Queue};
use crate::app::document::{Action, Side};
use crate::app::pane::{Content, Direction, Link, Over, PaneId, SliceAxis};
use crate::app::results::{MatchRow, Read};
use crate::app::words::explained;
use crate::app::{canvas::number, clipboard, document::panes::Change};
use crate::detector::Feature;
use crate::inspect::place::ProbeSubject;
use crate::requests::{ProbeQuestion, ViewKind};
use crate::teach::glossary::glossary;
use egui::{Button, RichText, ScrollArea, Ui};

pub(super) fn pane_menu_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, queue: &mut Queue) {
    whole_menu_ui(ui, |ui| {
        content_ui(ui, model, id, queue);
        ui.separator();
        view_ui(ui, model, id, queue);
    });
}

/// Draws a menu that can be scrolled where it is higher than the window.
fn whole_menu_ui(ui: &mut Ui, add_contents: impl FnOnce(&mut Ui)) {
    ui.set_min_width(190.0);
    let room = ui.ctx().content_rect().height() - 2.0 * MENU_MARGIN;
    ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, add_contents);
}

const MENU_MARGIN: f32 = 12.0;

fn view_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, queue: &mut Queue) {
    over_ui(ui, model, id, queue);
    links_ui(ui, model, id, queue);
    ui.separator();
    item_ui(ui, model, queue, ActionId::Fit);
    item_ui(ui, model, queue, ActionId::OneToOne);
    ui.separator();
    for (label, direction) in [("Split right", Direction::Right), ("Split down", Direction::Down)] {
        queue.push_if(ui.button(label).clicked(), Action::ChangePanes(Change::Split(id, direction)));
    }
    let close = ui.add_enabled(model.document.panes.are_many(), Button::new("Close pane"));
    queue.push_if(close.clicked(), Action::ChangePanes(Change::Close(id)));
    ui.menu_button("Layout", |ui| {
        for (label, help, change) in (model.document.workspace.record().layouts)(id) {
            queue.push_if(ui.button(label).on_hover_text(help).clicked(), Action::ChangePanes(change));
        }
    });
}

fn content_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, queue: &mut Queue) {
    let mut others = other_panes(model, id);
    // A difference is made of panes that show pictures of their own.
    others.retain(|(other, _)| model.pane(*other).is_some_and(|pane| pane.shown().is_some()));
    let Some(pane) = model.pane(id) else { return };
    for kind in ViewKind::ALL {
        let radio = ui.radio(pane.shows(kind), kind.about().label);
        let radio = explained(radio, kind.about().help, glossary().of_picture(kind.key()));
        queue.push_if(radio.clicked(), Action::Show(id, kind));
    }
    for axis in SliceAxis::ALL {
        let ([label, help], slice) = (axis.words(), Content::Slice(axis));
        let radio = explained(ui.radio(pane.content == slice, label), help, glossary().of_picture("slice"));
        queue.push_if(radio.clicked(), Action::SetContent(id, slice));
    }
    ui.add_enabled_ui(others.len() > 1, |ui| {
        // Nested by the first pane: a flat list of all ordered pairs would be long.
        let menu = ui.menu_button("Difference", |ui| {
            for &(a, number_a) in &others {
                ui.menu_button(format!("{number_a} minus"), |ui| {
                    for &(b, number_b) in others.iter().filter(|(b, _)| *b != a) {
                        let button = ui.button(format!("{number_a} − {number_b}"));
                        queue.push_if(button.clicked(), Action::SetContent(id, Content::Difference(a, b)));
                    }
                });
            }
        });
        menu.response.on_disabled_hover_text("A difference needs two other panes: split this one first");
    });
    if let Some(before) = pane.method {
        ui.menu_button(format!("Method: {}", before.label()), |ui| {
            for one in model.methods_shown() {
                let radio = ui.radio(one == before, one.label()).on_hover_text(one.words()[1]);
                queue.push_if(radio.clicked() && one != before, Action::SetMethod(id, one));
            }
        });
    }
    if model.burst_of(Side::B).is_some() {
        ui.horizontal(|ui| {
            ui.label("Burst");
            for one in Side::BOTH {
                let radio = ui.radio(one == pane.side, one.name());
                queue.push_if(radio.clicked() && one != pane.side, Action::SetSide(id, one));
            }
        });
    }
}

fn other_panes(model: Read<'_>, id: PaneId) -> Vec<(PaneId, usize)> {
    let others = model.document.panes.shown().into_iter().filter(|other| *other != id);
    others.filter_map(|other| Some((other, model.document.panes.number(other)?))).collect()
}

fn over_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, queue: &mut Queue) {
    let others = other_panes(model, id);
    let Some(pane) = model.pane(id) else { return };
    ui.add_enabled_ui(!others.is_empty(), |ui| {
        let wipe: fn(PaneId) -> Over = |other| Over::Wipe { other, at: 0.5 };
        for (label, over) in [("Wipe with", wipe), ("Flip with", |other| Over::Flip { other, flipped: false })] {
            ui.menu_button(label, |ui| {
                for &(other, number) in &others {
                    let button = ui.button(format!("Pane {number}"));
                    queue.push_if(button.clicked(), Action::SetOver(id, Some(over(other))));
                }
            });
        }
    });
    queue.push_if(pane.over.is_some() && ui.button("Nothing over it").clicked(), Action::SetOver(id, None));
}

fn links_ui(ui: &mut Ui, model: Read<'_>, id: PaneId, queue: &mut Queue) {
    ui.add_enabled_ui(model.document.panes.are_many(), |ui| {
        ui.menu_button("Links", |ui| {
            for link in Link::ALL {
                let mut on = model.document.panes.has_link(id, link);
                let [label, help] = link.words();
                queue.push_if(ui.checkbox(&mut on, label).on_hover_text(help).changed(), Action::SetLink(id, link, on));
            }
        });
    });
}

pub(super) fn picture_menu_ui(drawn: &Drawn, model: Read<'_>, widgets: &mut PaneWidgets, queue: &mut Queue) {
    let (id, response) = (drawn.pane, &drawn.output.response);
    // The subject is the one at the click: over the menu the pointer is on something else.
    if response.secondary_clicked() {
        let shown = widgets.get(drawn.shown).map(|widget| &widget.picture);
        let (readout, feature) = shown.map_or((None, None), |shown| (shown.readout, shown.pointed));
        let mid_burst = drawn.output.hover_image.and_then(|pos| mid_burst(model, drawn.shown, pos));
        widgets.of(id).menu = MenuPlace {
            feature: feature.filter(|_| model.document.workspace.inspects()),
            matched: model.results.pair.hovered.filter(|_| model.document.workspace.shows_pair()),
            readout,
            mid_burst: mid_burst.filter(|_| model.document.workspace.probes()),
        };
    }
    let place = widgets.get(id).map(|widget| widget.menu).unwrap_or_default();
    response.context_menu(|ui| {
        whole_menu_ui(ui, |ui| {
            // From the particular to the general: feature, match, place, picture, pane.
            if let Some(index) = place.feature {
                if let Some(feature) = model.features().get(index) {
                    ui.label(RichText::new(format!("Feature {index}")).small().weak());
                    queue.push_if(ui.button("Select").clicked(), Action::Select(Some(index)));
                    feature_items_ui(ui, feature, index, queue);
                }
                ui.separator();
            }
            if let Some(matches) = &model.results.pair.matches
                && let Some(row) = place.matched.and_then(|index| matches.row(index))
            {
                match_menu_ui(ui, &row, queue);
                ui.separator();
            }
            if let Some((side, place)) = place.mid_burst {
                let probe = ui.button("Probe this place").on_hover_text(ActionId::ProbePlace.action().help);
                let question = ProbeQuestion::At { place, wanted: ProbeSubject::Best };
                queue.push_if(probe.clicked(), Action::Probe(side, question));
            }
            if let Some(readout) = &place.readout {
                let value = format!("Copy value {}", number(readout.value, 4));
                copy_ui(ui, &value, || readout.value.to_string());
                let at = format!("Copy place ({})", clipboard::place_text(readout));
                copy_ui(ui, &at, || clipboard::place_text(readout));
            }
            if ui.button("Copy picture").on_hover_text("As it is shown, in its range and colours").clicked() {
                queue.0.extend(clipboard::copy_picture(ui.ctx(), model, drawn.shown).map(Action::Note));
            }
            ui.separator();
            ui.menu_button("Show", |ui| whole_menu_ui(ui, |ui| content_ui(ui, model, id, queue)));
            view_ui(ui, model, id, queue);
        });
    });
}

pub(in crate::app) fn feature_items_ui(ui: &mut Ui, feature: &Feature, index: usize, queue: &mut Queue) {
    if ui.button("Go to feature").on_hover_text("Show the motion stack at its slope, with it in the middle").clicked() {
        queue.push(Action::Select(Some(index)));
        queue.push(ActionId::GoToFeature);
    }
    let why = ui.button("Why this feature?").on_hover_text(ActionId::ProbeFeature.action().help);
    queue.push_if(why.clicked(), Action::ProbeFeature(Side::A, index));
    copy_ui(ui, "Copy row", || clipboard::feature_text(feature));
}

pub(in crate::app) fn copy_ui(ui: &mut Ui, label: &str, text: impl FnOnce() -> String) {
    if ui.button(label).clicked() {
        ui.ctx().copy_text(text());
    }
}

pub(in crate::app) fn match_menu_ui(ui: &mut Ui, row: &MatchRow<'_>, queue: &mut Queue) {
    ui.set_min_width(150.0);
    ui.label(RichText::new(format!("Match {}", row.index)).small().weak());
    let go = ui.button("Go to match").on_hover_text("Show both features, each in the motion stack at its own slope");
    if go.clicked() {
        queue.push(Action::SelectMatch(Some(row.index)));
        queue.push(ActionId::GoToFeature);
    }
    copy_ui(ui, "Copy row", || clipboard::match_text(row));
}
