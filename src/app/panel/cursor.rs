//! Cursor: frame, slope, octave and level, with the grid's slopes marked, and the buttons that move it.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::panel::slope_pad::slope_pad_ui;
use crate::app::panel::slopes::strip_ui;
use crate::app::panel::widgets::{CursorRow, section_ui};
use crate::app::project::Model;
use crate::app::project::cursor::{ViewKind, level_range, octave_range, slope_limit};
use crate::detector::localise::place::rim_radius;
use crate::detector::scale_space::levels::ScaleSpace;
use egui::Ui;

/// Draws the section.
pub fn cursor_ui(ui: &mut Ui, model: &mut Model, queue: &mut Queue) {
    section_ui(ui, "Cursor", |ui| {
        frame_row(ui, model);
        slope_rows(ui, model);
        buttons_ui(ui, model, queue);
        if model.cursor_params().slopes.is_plane() {
            slope_pad_ui(ui, model);
        }
        scale_rows(ui, model);
    });
}

fn frame_row(ui: &mut Ui, model: &mut Model) {
    let last = model.focused_frame_count().saturating_sub(1) as f32;
    let mut frame = model.cursor().frame as f32;
    let row = CursorRow {
        label: "Frame",
        help: "Index of the shown frame, from 0. Moving it shows the frame.",
        range: 0.0..=last,
        marks: &[],
        whole: true,
        suffix: "",
    };
    if row.ui(ui, &mut frame) {
        let pane = model.focused_mut();
        pane.cursor.frame = frame.max(0.0) as usize;
        pane.show(ViewKind::Frame);
    }
}

fn slope_rows(ui: &mut Ui, model: &mut Model) {
    let grid = model.cursor_params().slopes;
    let limit = slope_limit(&grid);
    // The slopes of a rotated grid are marked by their components on each axis.
    let marks = |of: fn(crate::detector::Slope) -> f32| {
        let mut marks: Vec<f32> = grid.slopes().map(of).collect();
        marks.sort_by(f32::total_cmp);
        marks.dedup();
        marks
    };
    let before = model.cursor().slope;
    let mut slope = before;
    let (marks_u, marks_v) = (marks(|s| s.u), marks(|s| s.v));
    fn row<'a>(label: &'a str, help: &'a str, limit: f32, marks: &'a [f32]) -> CursorRow<'a> {
        CursorRow { label, help, range: -limit..=limit, marks, whole: false, suffix: "" }
    }
    row(
        "Slope u",
        "Apparent motion to the right, px/frame. Marks: slopes of the grid; any slope between them can be shown.",
        limit,
        &marks_u,
    )
    .ui(ui, &mut slope.u);
    strip_ui(ui, model, false);
    row(
        "Slope v",
        "Apparent motion downwards, px/frame. Marks: slopes of the grid; any slope between them can be shown.",
        limit,
        &marks_v,
    )
    .ui(ui, &mut slope.v);
    strip_ui(ui, model, true);
    if slope != before {
        model.playing = false;
        let pane = model.focused_mut();
        pane.cursor.slope = slope;
        pane.show_slope();
    }
}

fn buttons_ui(ui: &mut Ui, model: &Model, queue: &mut Queue) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let play = if model.playing { "⏸ Pause" } else { "▶ Play" };
        button_ui(ui, model, queue, ActionId::Play, Some(play));
        button_ui(ui, model, queue, ActionId::SnapSlope, Some("Snap"));
        button_ui(ui, model, queue, ActionId::SlopeZero, Some("Zero"));
        button_ui(ui, model, queue, ActionId::BusiestSlope, Some("Most features"));
    });
}

fn scale_rows(ui: &mut Ui, model: &mut Model) {
    let octaves = octave_range(model.cursor_params(), model.focused_size());
    let levels = level_range(model.cursor_params());
    let (mut octave, mut level) = (model.cursor().octave as f32, model.cursor().level as f32);
    let row = |label, help, range: std::ops::RangeInclusive<i32>| CursorRow {
        label,
        help,
        range: *range.start() as f32..=*range.end() as f32,
        marks: &[],
        whole: true,
        suffix: "",
    };
    let a = row(
        "Octave",
        "Octave of the DoG: each is twice as coarse as the one before. Moving it shows the DoG, unless the pane shows a map at this octave.",
        octaves,
    )
    .ui(ui, &mut octave);
    let b = row(
        "Level",
        "Level within the octave. Features lie at levels 0 and up; the two outermost levels are only compared with. Moving it shows the DoG, unless the pane shows a map at this level.",
        levels,
    )
    .ui(ui, &mut level);
    if a || b {
        let pane = model.focused_mut();
        (pane.cursor.octave, pane.cursor.level) = (octave as i32, level as i32);
        pane.show_scale();
    }
    let space = ScaleSpace::of(model.cursor_params());
    let sigma = space.sigma_image(model.cursor().octave, f64::from(model.cursor().level));
    let rim = rim_radius(sigma, space.levels);
    ui.weak(format!("Scale σ = {sigma:.2} px")).on_hover_text(format!(
        "In pixels of the input image. Discs with a radius of {rim:.1} px respond most strongly at this scale."
    ));
}
