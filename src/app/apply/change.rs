//! What rows of the action table do, where that takes more than an expression.

use crate::app::actions::when;
use crate::app::apply::{comparison, detection, explained, opening, pair, panes, probe};
use crate::app::document::method::plane_of;
use crate::app::document::{Destination, Document, Reference, Side, Visibility};
use crate::app::results::{Model, Read};
use crate::app::{canvas::overlay::ColourBy, document::filter::neighbour};
use crate::detector::{Feature, Method};
use crate::engine::Engine;
use crate::requests::BurstSource;
use crate::teach::{BottomTab, Workspace};

pub fn detect(model: &mut Model, engine: &Engine) {
    model.document.workspace.detects().iter().for_each(|side| detection::start_detection(model, *side, engine));
}

pub fn match_pair(model: &mut Model, engine: &Engine) {
    if let Some(wanted) = Read::of(model).wanted_matches() {
        model.results.pair.matching.ask(engine, wanted);
    }
}

pub fn open_chart(model: &mut Model, engine: &Engine) {
    if let Some(chart) = Read::of(model).selected_chart().and_then(|chart| chart.params()) {
        model.document.open_workspace(Workspace::Inspect);
        opening::open(model, Side::A, BurstSource::Chart(Box::new(chart)), engine);
    }
}

pub fn open_dark_copy(model: &mut Model, engine: &Engine) {
    if let Some(burst) = &model.results.slots.a.burst {
        let of = Box::new(burst.source.clone());
        opening::open(model, Side::A, BurstSource::DarkCopy { of, noise: model.document.lab.dark_copy }, engine);
    }
}

pub fn go_to_selection(model: &mut Model, _: &Engine) {
    if when::in_pair(Read::of(model)) {
        pair::go_to_match(model);
    } else if let Some(&Feature { u, v, sigma, slope, .. }) = Read::of(model).selected_feature() {
        let at = Some(([u, v], 60.0 / sigma.max(1.0)));
        model.document.go_to(Side::A, &Destination { slope: Some(slope), at, ..Destination::default() });
    }
}

pub fn probe_selection(model: &mut Model, _: &Engine) {
    if let Some((side, index)) = Read::of(model).feature_to_probe() {
        probe::probe_feature(model, side, index);
    }
}

pub fn pin_result(model: &mut Model, _: &Engine) {
    comparison::pin_result(model, Read::of(model).active_side());
    model.document.bottom_tab = BottomTab::Compared;
    model.shell.messages.note("Pinned: later detections are compared with these features");
}

pub fn show_truth(model: &mut Model, _: &Engine) {
    let on = when::shows_truth(Read::of(model));
    comparison::show_comparison(model, Read::of(model).active_side(), (!on).then_some(Reference::Truth));
    model.document.bottom_tab = BottomTab::Compared;
}

pub fn toggle_left(model: &mut Model, _: &Engine) {
    match Read::of(model).shows_left() {
        true => model.document.panels.left = Visibility::Closed,
        false => panes::open_left(model),
    }
}

pub fn select_next(model: &mut Model, forward: bool) {
    explained::refresh_listed(model);
    pair::refresh_listed_matches(model);
    let listed = Read::of(model).listed();
    model.document.select_row(neighbour(listed, model.document.selected_row(), forward));
}

pub fn select_first(model: &mut Model, _: &Engine) {
    let first = Read::of(model).listed().first().copied();
    model.document.select_row(first);
}

pub fn probe_expected(model: &mut Model, _: &Engine) {
    if let Some(place) = Read::of(model).expected_place() {
        probe::probe_place(model, Side::B, place);
    }
}

pub fn go_to_busiest_slope(model: &mut Model, _: &Engine) {
    let focus = model.document.focus();
    model.document.playing = false;
    let note = detection::go_to_busiest_slope(model, focus);
    note.into_iter().for_each(|note| model.shell.messages.note(note));
    model.document.lead(focus, crate::app::pane::Pane::show_slope);
}

pub fn colour_next(document: &mut Document) {
    let mut later = ColourBy::choices(document.set_up.reads_depths).skip_while(|by| *by != document.colour_by);
    document.colour_by = later.nth(1).unwrap_or_default();
}

pub fn search_plane(model: &mut Model, _: &Engine) {
    let slopes = plane_of(Read::of(model).grid_of(Side::A)).into();
    (model.document.params.method, model.document.params.slopes) = (Method::Buff, slopes);
}
