//! Export of a film: the dialog that chooses its contents and says its size and rate, and its pictures.

use super::{drawing_of_panes, rasterise};
use crate::app::actions::{ActionId, Queue};
use crate::app::inspector::PaneWidgets;
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::figure::FigureChoice;
use crate::app::project::film::{FilmChoice, FilmContent};
use crate::detector::Detection;
use crate::export::Drawing;
use crate::export::film::{FILM_RATES, FilmFormat, estimated_film_bytes, write_film};
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::to_rgba8;
use crate::requests::Film;
use egui::{DragValue, Grid, Ui};
use image::imageops::{FilterType, resize};
use std::path::Path;
use std::sync::Arc;

/// The dialog.
#[derive(Debug, Default)]
pub struct FilmDialog {
    /// Whether it is open.
    pub is_open: bool,
    /// Bytes of a pixel as GIF and as animated PNG, and the picture in which they were measured.
    measured: Option<(Arc<Plane>, [f64; 2])>,
    /// What is said of the film, and of which one.
    told: Option<(Told, String)>,
}

/// What decides number, size and bytes of a film.
#[derive(Debug, Clone)]
struct Told {
    choice: FilmChoice,
    panes: Vec<PaneId>,
    picture: Option<Arc<Plane>>,
    found: Option<Arc<Detection>>,
}

impl Told {
    fn of(model: &Model) -> Self {
        let found = model.found_of(model.active_side());
        Self {
            choice: model.film,
            panes: flipped_panes(model),
            picture: model.picture().map(|picture| picture.plane.clone()),
            found: found.map(|found| found.detection.clone()),
        }
    }

    fn is_same(&self, other: &Self) -> bool {
        same(self.found.as_ref(), other.found.as_ref())
            && same(self.picture.as_ref(), other.picture.as_ref())
            && (self.choice, &self.panes) == (other.choice, &other.panes)
    }
}

/// Longest side, pixels, of the picture in which the bytes of a pixel are measured.
const MEASURED_PX: u32 = 320;

/// Number of pictures, their columns and rows.
type Extent = (usize, [u32; 2]);

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
            let panes = flipped_panes(model).len();
            choice_ui(ui, &mut model.film, panes);
            ui.add_space(4.0);
            ui.label(self.told(model));
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                for (label, action) in [("GIF…", ActionId::ExportFilmGif), ("Animated PNG…", ActionId::ExportFilmApng)]
                {
                    if ui.button(label).on_hover_text(action.action().help).clicked() {
                        queue.push(action);
                        close = true;
                    }
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
        let Some((count, [width, height])) = extent(model) else {
            return "There is nothing to film: open a burst, and for two panes a second one".to_owned();
        };
        let rate = model.film.rate;
        let bytes = self.bytes_per_pixel(model).map(|bytes| bytes * count as f64 * f64::from(width * height));
        let [gif, apng] = bytes.map(|bytes| format!("{:.1} MB", 1e-6 * bytes));
        format!(
            "{count} pictures of {width} × {height}, {rate} a second: {:.1} s; about {gif} as GIF, {apng} as animated PNG",
            count as f64 / f64::from(rate)
        )
    }

    /// Bytes of a pixel in each format, measured in the picture that is shown.
    fn bytes_per_pixel(&mut self, model: &Model) -> [f64; 2] {
        let Some(picture) = model.picture() else { return [0.5, 1.0] };
        if let Some((_, bytes)) = self.measured.as_ref().filter(|(of, _)| Arc::ptr_eq(of, &picture.plane)) {
            return *bytes;
        }
        let rgba = to_rgba8(&picture.plane, &model.display_of(model.focus()));
        let (width, height) = rgba.dimensions();
        let shrink = width.max(height).div_ceil(MEASURED_PX).max(1);
        let small = resize(&rgba, (width / shrink).max(1), (height / shrink).max(1), FilterType::Nearest);
        let pixels = f64::from(small.width() * small.height());
        let bytes = [FilmFormat::Gif, FilmFormat::Apng]
            .map(|format| estimated_film_bytes(format, [&small, &small], 1) as f64 / pixels);
        self.measured = Some((picture.plane.clone(), bytes));
        bytes
    }
}

fn choice_ui(ui: &mut Ui, choice: &mut FilmChoice, panes: usize) {
    for content in FilmContent::ALL {
        let is_possible = content != FilmContent::Panes || panes == 2;
        ui.add_enabled_ui(is_possible, |ui| {
            ui.radio_value(&mut choice.content, content, content.label())
                .on_hover_text(content.help())
                .on_disabled_hover_text("Split the pane first, to show a second picture");
        });
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

/// The panes that are flipped: the first two with a picture, in reading order.
fn flipped_panes(model: &Model) -> Vec<PaneId> {
    let panes = model.panes.arrangement().in_rows().into_iter().flatten();
    let has_picture = |id: &PaneId| model.panes.get(*id).is_some_and(|pane| pane.picture.is_some());
    panes.filter(has_picture).take(2).collect()
}

/// Number and size of the pictures; `None` where there is nothing to film.
fn extent(model: &Model) -> Option<Extent> {
    match model.film_to_export() {
        Some(film) => {
            let (width, height) = film.size();
            Some((film.steps().len(), [width, height]))
        }
        None => {
            let panes = flipped_panes(model);
            let sizes: Vec<(usize, usize)> = panes
                .iter()
                .filter_map(|id| Some(model.panes.get(*id)?.picture.as_ref()?.request.burst.burst.size()))
                .collect();
            let [a, b] = sizes[..] else { return None };
            let scale = scale_of(a.0.max(a.1).max(b.0).max(b.1), model.film.max_side_px);
            let side = |x: usize, y: usize| (scale * x.max(y) as f32) as u32;
            Some((2, [side(a.0, b.0), side(a.1, b.1)]))
        }
    }
}

/// Figure pixels for a pixel of the image, so that `side` becomes at most `max`.
fn scale_of(side: usize, max: usize) -> f32 {
    1.0 / side.div_ceil(max.max(16)).max(1) as f32
}

/// The pictures of a film, not yet made.
#[derive(Debug)]
pub enum FilmPictures {
    /// A sweep.
    Sweep(Box<Film>),
    /// Panes as they are shown.
    Panes(Vec<Drawing>),
}

/// The film that was chosen, with its rate.
///
/// # Errors
/// Without a burst, or with fewer than two panes for a flip of two.
pub fn film_of(model: &Model, widgets: &PaneWidgets) -> Result<(FilmPictures, u16), String> {
    let FilmChoice { content, rate, max_side_px } = model.film;
    if let Some(film) = model.film_to_export() {
        return Ok((FilmPictures::Sweep(Box::new(film)), rate));
    }
    if content != FilmContent::Panes || model.slots.a.burst.is_none() {
        return Err("there is no burst; open one first".to_owned());
    }
    let panes = flipped_panes(model);
    if panes.len() < 2 {
        return Err("two panes are shown in turn; split the pane first".to_owned());
    }
    let (width, height) = model.size();
    let choice = FigureChoice {
        scale: scale_of(width.max(height), max_side_px),
        font_size_px: 12.0,
        letters: false,
        ..model.figure
    };
    let drawing = |id: &PaneId| drawing_of_panes(model, widgets, &[vec![*id]], &choice);
    let mut drawings = panes.iter().map(drawing).collect::<Result<Vec<Drawing>, String>>()?;
    let largest = drawings.iter().fold([0f32; 2], |a, b| [a[0].max(b.size[0]), a[1].max(b.size[1])]);
    drawings.iter_mut().for_each(|drawing| drawing.size = largest);
    Ok((FilmPictures::Panes(drawings), rate))
}

impl FilmPictures {
    /// Makes the pictures and writes them.
    ///
    /// # Errors
    /// When a picture cannot be made or the file cannot be written.
    pub fn write(&self, path: &Path, format: FilmFormat, rate: u16) -> Result<(), String> {
        let monitor = Monitor::default();
        let pictures = match self {
            Self::Sweep(film) => film.pictures(&rasterise, &monitor).map_err(|e| e.to_string())?,
            Self::Panes(drawings) => drawings.iter().map(rasterise).collect::<Result<_, String>>()?,
        };
        write_film(path, format, &pictures, rate, &monitor).map_err(|e| e.to_string())
    }
}
