//! Export of a film: the dialog that chooses its contents and says its size and rate.

use super::export_row_ui;
use crate::app::actions::{ActionId, Queue};
use crate::app::document::{Action, FilmChoice, FilmContent};
use crate::app::memo::{Itself, kept};
use crate::app::panel::widgets::modal_ui;
use crate::app::results::Read;
use crate::export::film::{FILM_RATES, estimated_film_bytes};
use crate::inspect::words::counted;
use crate::plane::display::to_rgba8;
use egui::{DragValue, Grid, Ui};
use image::imageops::{FilterType, resize};

/// Longest side, pixels, of the picture in which the bytes of a pixel are measured.
const MEASURED_PX: u32 = 320;

pub fn film_ui(ctx: &egui::Context, is_open: &mut bool, model: Read<'_>, queue: &mut Queue) {
    modal_ui(ctx, is_open, ("film", 380.0, "Film"), |ui| {
        ui.weak("Each picture with its features, numbers, colours, and the response over all of them");
        ui.add_space(6.0);
        let mut film = model.document.film;
        choice_ui(ui, &mut film);
        queue.edit(model.document, Action::SetFilm(film));
        ui.add_space(4.0);
        let picture = model.picture().map(|picture| Itself::from(&picture.plane));
        let found = model.found_of(model.active_side()).map(|found| Itself::from(&found.detection));
        ui.label(kept(ctx, "words of a film", (model.document.film, picture, found), || tell(model)));
        ui.weak("GIF has 256 colours; MP4 is made by the ffmpeg in PATH; PNG is a file for each picture");
        export_row_ui(ui, ActionId::ExportFilmGif, queue, |_| {});
    });
}

fn tell(model: Read<'_>) -> String {
    let Some(film) = model.film_to_export() else {
        return "There is nothing to film: open a burst".to_owned();
    };
    let (count, (width, height)) = (film.steps().len(), film.size());
    let rate = model.document.film.rate;
    let bytes = bytes_per_pixel(model) * count as f64 * f64::from(width * height);
    format!(
        "{} of {width} × {height}, {rate} a second: {:.1} s; about {:.1} MB as GIF",
        counted(count, "picture"),
        count as f64 / f64::from(rate),
        1e-6 * bytes
    )
}

fn bytes_per_pixel(model: Read<'_>) -> f64 {
    let Some(picture) = model.picture() else { return 0.5 };
    let rgba = to_rgba8(&picture.plane, &model.display_of(model.document.focus()));
    let (width, height) = rgba.dimensions();
    let shrink = width.max(height).div_ceil(MEASURED_PX).max(1);
    let small = resize(&rgba, (width / shrink).max(1), (height / shrink).max(1), FilterType::Nearest);
    let bytes = estimated_film_bytes("a.gif".as_ref(), [&small, &small], 1).unwrap_or_default();
    bytes as f64 / f64::from(small.width() * small.height())
}

fn choice_ui(ui: &mut Ui, choice: &mut FilmChoice) {
    for content in FilmContent::ALL {
        let [label, help] = content.words();
        ui.radio_value(&mut choice.content, content, label).on_hover_text(help);
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
