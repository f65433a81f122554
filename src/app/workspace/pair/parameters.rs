//! Parameters of matching: all of them, with unit, default, effect of raising it, and error.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::document::{Action, Side};
use crate::app::panel::widgets::{error_ui, name_field, section_ui};
use crate::app::results::Read;
use crate::app::{panel::parameter_rows::ParamTable, panel::parameters::fold_ui};
use crate::dataset::CameraChoice;
use crate::detector::params::Param;
use crate::matching::params::doc;
use crate::matching::{Camera, CameraModel, Geometry, MatchParams};
use egui::{Align, Id, Layout, RichText, Ui};

const ADVANCED: [Param<MatchParams>; 5] =
    [doc::MIN_INLIERS, doc::CONFIDENCE, doc::MAX_ITERATIONS, doc::SEED, doc::CAMERA];

#[derive(Debug, Clone, Default)]
struct CameraText {
    text: String,
    /// Camera of the text, to notice a camera set elsewhere.
    camera: Option<Camera>,
    problem: Option<String>,
}

impl CameraText {
    /// Shows the camera of the document, unless the user is typing.
    fn follow(&mut self, camera: Option<&Camera>) {
        if self.camera.as_ref() != camera {
            self.camera = camera.cloned();
            self.text = camera.map_or_else(String::new, ToString::to_string);
            self.problem = None;
        }
    }

    /// Reads the typed text. While it is invalid the camera stays as it is.
    fn read(&mut self) {
        let typed = Some(self.text.as_str()).filter(|text| !text.trim().is_empty());
        match typed.map(str::parse).transpose() {
            Ok(camera) => (self.camera, self.problem) = (camera, None),
            Err(problem) => self.problem = Some(problem),
        }
    }
}

pub fn parameters_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Matching", |ui| {
        if model.document.workspace.shows_pair() {
            ui.horizontal(|ui| {
                button_ui(ui, model, queue, ActionId::Match, None);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    button_ui(ui, model, queue, ActionId::ResetMatching, Some("Reset all"));
                });
            });
        } else {
            button_ui(ui, model, queue, ActionId::ResetMatching, Some("Reset all"));
        }
        ui.add_space(4.0);
        all_rows_ui(ui, model, queue);
    });
}

fn all_rows_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let error = model.results.pair.param_error.as_ref();
    let mut params = model.document.matching.clone();
    let p = &mut params;
    offered_camera_ui(ui, model, p);
    let table = ParamTable { error, defaults: MatchParams::default(), frame_count: 0, note: None };
    let is_advanced = |record: &&Param<MatchParams>| ADVANCED.contains(record);
    let is_needed = |record: &&Param<MatchParams>| {
        error.is_some_and(|error| error.subject == record.name)
            || crate::app::parts::is_wanted(ui.ctx(), crate::teach::Part::parameter(record))
            || (**record == doc::CAMERA && p.camera.is_some())
    };
    let needed = ADVANCED.iter().any(|record| is_needed(&record)) || p.geometry == Geometry::Essential;
    let changed = ADVANCED.iter().filter(|record| record.text(p) != record.text(&table.defaults)).count();
    let mut row = |ui: &mut Ui, record: &Param<MatchParams>| {
        ui.add_enabled_ui((record.in_use)(p), |ui| {
            if *record == doc::CAMERA {
                camera_ui(ui, model, &table, p);
            } else {
                table.row(ui, record, p);
            }
        });
    };
    doc::ALL.iter().filter(|record| !is_advanced(record)).for_each(|record| row(ui, record));
    if fold_ui(ui, model, needed, changed, queue) {
        ADVANCED.iter().for_each(|record| row(ui, record));
    }
    queue.edit(model.document, Action::SetMatching(Box::new(params)));
}

/// Offers the cameras of files beside the bursts, which the commands take unasked, unless another one is given.
fn offered_camera_ui(ui: &mut Ui, model: Read<'_>, p: &mut MatchParams) {
    let of = |side| model.burst_of(side).and_then(|open| open.camera.as_ref()).filter(|_| p.camera.is_none());
    let (a, b) = (of(Side::A), if model.burst_of(Side::B).is_some() { of(Side::B) } else { of(Side::A) });
    match (a, b) {
        (Some(Err(why)), _) | (_, Some(Err(why))) => _ = error_ui(ui, RichText::new(why.to_string()).small()),
        (Some(Ok(a)), Some(Ok(b))) => {
            let tip = format!("{a}, of the file beside the frames: matches are then verified by the essential matrix");
            if ui.button("Use camera.toml").on_hover_text(tip).clicked() {
                *p = MatchParams { geometry: Geometry::Essential, ..p.with_cameras(Some(a), Some(b)) };
            }
        }
        _ => {}
    }
}

fn camera_ui(ui: &mut Ui, model: Read<'_>, table: &ParamTable<'_, MatchParams>, p: &mut MatchParams) {
    let size = model.burst_of(Side::A).map(|open| open.burst.size());
    // A lesson has a text of its own, as it has a project.
    let id = Id::unique(("typed camera", model.is_in_lesson()));
    let mut typed: CameraText = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    typed.follow(p.camera.as_ref());
    let reset = (p.camera.is_some(), |camera: &mut Option<Camera>| *camera = None);
    table.row_with(ui, &doc::CAMERA, &mut p.camera, reset, |ui, camera, _| {
        let tip = "Focal length 1.2 times the larger side, principal point at the image centre: COLMAP's guess where nothing is known";
        if ui.add_enabled(size.is_some(), egui::Button::new("Guess")).on_hover_text(tip).clicked() {
            *camera = size.and_then(|s| CameraChoice::Guessed(CameraModel::SimplePinhole).for_images(s).ok());
        }
    });
    let hint = "PINHOLE 640 480 500 500 320 240";
    let field = egui::TextEdit::singleline(&mut typed.text).hint_text(hint).desired_width(f32::INFINITY);
    let response = ui.add(field).on_hover_text(doc::CAMERA.help());
    name_field(&response, "Camera", &typed.text);
    if response.changed() {
        typed.read();
        if typed.problem.is_none() {
            (p.camera, p.camera_b) = (typed.camera.clone(), None);
        }
    }
    if let Some(problem) = &typed.problem {
        error_ui(ui, RichText::new(problem).small());
    }
    ui.data_mut(|data| data.insert_temp(id, typed));
}
