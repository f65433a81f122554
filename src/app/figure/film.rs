//! Export of a film: the dialog that chooses its contents and says its size and rate.

use crate::app::actions::{ActionId, Queue};
use crate::app::project::Model;
use crate::app::project::film::{FilmChoice, FilmContent};
use crate::detector::Detection;
use crate::export::film::{FILM_RATES, estimated_film_bytes};
use crate::plane::Plane;
use crate::plane::display::to_rgba8;
use egui::{DragValue, Grid, Ui};
use image::imageops::{FilterType, resize};
use std::sync::Arc;

/// The dialog.
#[derive(Debug, Default)]
pub struct FilmDialog {
    /// Whether it is open.
    pub is_open: bool,
    /// Bytes of a pixel, and the picture in which they were measured.
    measured: Option<(Arc<Plane>, f64)>,
    /// What is said of the film, and of which one.
    told: Option<(Told, String)>,
}

/// What decides number, size and bytes of a film.
#[derive(Debug, Clone)]
struct Told {
    choice: FilmChoice,
    picture: Option<Arc<Plane>>,
    found: Option<Arc<Detection>>,
}

impl Told {
    fn of(model: &Model) -> Self {
        let found = model.found_of(model.active_side());
        Self {
            choice: model.film,
            picture: model.picture().map(|picture| picture.plane.clone()),
            found: found.map(|found| found.detection.clone()),
        }
    }

    fn is_same(&self, other: &Self) -> bool {
        same(self.found.as_ref(), other.found.as_ref())
            && same(self.picture.as_ref(), other.picture.as_ref())
            && self.choice == other.choice
    }
}

/// Longest side, pixels, of the picture in which the bytes of a pixel are measured.
const MEASURED_PX: u32 = 320;

/// Whether both are the same value in memory, or both are missing.
fn same<T>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
    a.map(Arc::as_ptr) == b.map(Arc::as_ptr)
}

impl FilmDialog {
    /// Draws the dialog if it is open.
    pub fn ui(&mut self, ctx: &egui::Context, model: &mut Model, queue: &mut Queue) {
        if !self.is_open {
            return;
        }
        let mut close = false;
        let modal = egui::Modal::new(egui::Id::unique("film")).show(ctx, |ui| {
            ui.set_width(380.0);
            ui.heading("Film");
            ui.weak("Each picture with its features, numbers, colours, and the response over all of them");
            ui.add_space(6.0);
            choice_ui(ui, &mut model.film);
            ui.add_space(4.0);
            ui.label(self.told(model));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                let export = ActionId::ExportFilmGif;
                if ui.button("GIF…").on_hover_text(export.action().help).clicked() {
                    queue.push(export);
                    close = true;
                }
                close |= ui.button("Close").clicked();
            });
        });
        self.is_open &= !(close || modal.should_close());
    }

    /// Number, size, rate and bytes of the film that would be written, computed where something has changed.
    fn told(&mut self, model: &Model) -> String {
        let now = Told::of(model);
        if let Some((_, text)) = self.told.as_ref().filter(|(told, _)| told.is_same(&now)) {
            return text.clone();
        }
        let text = self.tell(model);
        self.told = Some((now, text.clone()));
        text
    }

    fn tell(&mut self, model: &Model) -> String {
        let Some(film) = model.film_to_export() else {
            return "There is nothing to film: open a burst".to_owned();
        };
        let (count, (width, height)) = (film.steps().len(), film.size());
        let rate = model.film.rate;
        let bytes = self.bytes_per_pixel(model) * count as f64 * f64::from(width * height);
        format!(
            "{count} pictures of {width} × {height}, {rate} a second: {:.1} s; about {:.1} MB",
            count as f64 / f64::from(rate),
            1e-6 * bytes
        )
    }

    /// Bytes of a pixel, measured in the picture that is shown.
    fn bytes_per_pixel(&mut self, model: &Model) -> f64 {
        let Some(picture) = model.picture() else { return 0.5 };
        if let Some((_, bytes)) = self.measured.as_ref().filter(|(of, _)| Arc::ptr_eq(of, &picture.plane)) {
            return *bytes;
        }
        let rgba = to_rgba8(&picture.plane, &model.display_of(model.focus()));
        let (width, height) = rgba.dimensions();
        let shrink = width.max(height).div_ceil(MEASURED_PX).max(1);
        let small = resize(&rgba, (width / shrink).max(1), (height / shrink).max(1), FilterType::Nearest);
        let pixels = f64::from(small.width() * small.height());
        let bytes = estimated_film_bytes([&small, &small], 1) as f64 / pixels;
        self.measured = Some((picture.plane.clone(), bytes));
        bytes
    }
}

fn choice_ui(ui: &mut Ui, choice: &mut FilmChoice) {
    for content in FilmContent::ALL {
        ui.radio_value(&mut choice.content, content, content.label()).on_hover_text(content.help());
    }
    Grid::new("film numbers").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let name = ui.label("Rate");
        ui.add(DragValue::new(&mut choice.rate).range(FILM_RATES).suffix(" a second")).labelled_by(name.id);
        ui.end_row();
        let name = ui.label("Longest side");
        let side = DragValue::new(&mut choice.max_side_px).range(64..=8192).suffix(" px");
        ui.add(side).on_hover_text("Larger pictures are made smaller by a whole number").labelled_by(name.id);
        ui.end_row();
    });
}
