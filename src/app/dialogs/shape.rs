//! Question for the shape of a file without header: the first frame in each likely shape, or a shape that is typed.

use crate::app::document::{Pointed, Queue, Side};
use crate::app::memo::{Itself, kept};
use crate::app::panel::widgets::{accept_ui, error_ui, modal_ui, named, weak_ui};
use crate::app::results::Read;
use crate::burst::Dump;
use crate::requests::{BurstSource, PossibleShape, ShapeRequest};
use egui::{
    Button, ColorImage, Context, Image, Key, Role, ScrollArea, TextEdit, TextureHandle, TextureOptions, Ui, vec2,
};

const COLUMNS: usize = 4;
const CELL_POINTS: egui::Vec2 = vec2(150.0, 112.0);

/// The dialog; closed while there is no source.
#[derive(Default)]
pub struct ShapeDialog {
    asked: Option<(Side, BurstSource)>,
    shapes: Vec<(PossibleShape, Option<TextureHandle>)>,
    /// The shape that is chosen, as text that can be edited.
    text: String,
}

fn texture(ui: &Ui, name: &str, shape: &PossibleShape) -> TextureHandle {
    let image = ColorImage::from_rgb(shape.picture.size.into(), &shape.picture.rgb);
    ui.ctx().load_texture(name, image, TextureOptions::LINEAR)
}

fn picture(texture: &TextureHandle) -> Image<'_> {
    Image::new(texture).fit_to_exact_size(CELL_POINTS).maintain_aspect_ratio(true)
}

fn words(shape: &PossibleShape) -> String {
    format!("{}, {}", shape.dump, crate::inspect::words::counted(shape.frames as usize, "frame"))
}

fn preview_ui(ui: &mut Ui, made: &std::sync::Arc<PossibleShape>) {
    let words = words(made);
    let texture = kept(ui.ctx(), "first frame in a shape", Itself::from(made), || texture(ui, &words, made));
    ui.add(picture(&texture).alt_text(format!("First frame in {words}")));
    weak_ui(ui, words);
}

impl ShapeDialog {
    /// Asks for the shape of `source`. The first of `shapes` is taken to be the right one.
    pub fn ask(&mut self, side: Side, source: BurstSource, shapes: Vec<PossibleShape>) {
        self.text = shapes.first().map_or_else(String::new, |first| first.dump.to_string());
        self.shapes = shapes.into_iter().map(|shape| (shape, None)).collect();
        self.asked = Some((side, source));
    }

    pub fn is_open(&self) -> bool {
        self.asked.is_some()
    }

    /// Draws the dialog, if it is open. Returns what is opened in which shape, once that was chosen.
    pub fn ui(&mut self, ctx: &Context, model: Read<'_>, queue: &mut Queue) -> Option<(Side, BurstSource, Dump)> {
        let path = self.asked.as_ref().map(|(_, source)| source.paths().first().cloned().unwrap_or_default());
        let limits = model.document.calibration.limits;
        let parsed = |path| self.text.trim().parse().map(|dump| ShapeRequest { path, dump, limits });
        let chosen: Option<Result<ShapeRequest, String>> = path.clone().map(parsed);
        let asked = chosen.as_ref().and_then(|chosen| chosen.clone().ok());
        queue.set(&model.results.shape.asked, asked, |asked| Pointed::Shape(asked).into());
        let (path, chosen) = path.zip(chosen)?;
        let on_show = model.results.shape.on_show(&chosen);
        let (mut accepts, mut stays) = (false, true);
        let width = COLUMNS as f32 * (CELL_POINTS.x + 18.0);
        modal_ui(ctx, &mut stays, ("shape of file", width, "Shape of a file without header"), |ui| {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            weak_ui(ui, name).on_hover_text(path.display().to_string());
            ui.add_space(6.0);
            accepts |= self.pictures_ui(ui);
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                let tip = "Columns, rows and type of the numbers, with the bytes before the first frame";
                let label = ui.label("Shape").on_hover_text(tip);
                let field =
                    TextEdit::singleline(&mut self.text).hint_text("1600x1200:u16le+BYTES").desired_width(220.0);
                ui.add(field).labelled_by(label.id);
            });
            ui.vertical(|ui| {
                // The preview's own height from the first, so that no button moves when it comes.
                ui.set_min_height(CELL_POINTS.y);
                match &on_show {
                    Err(_) if self.text.trim().is_empty() => {}
                    Err(why) => _ = error_ui(ui, why),
                    Ok(None) => _ = weak_ui(ui, "Reading…"),
                    Ok(Some(made)) => _ = ui.horizontal(|ui| preview_ui(ui, made)),
                }
            });
            ui.add_space(6.0);
            let tip = "Open the file in this shape, and later files without header too";
            accepts |= accept_ui(ui, "Open", on_show.is_ok()).on_hover_text(tip).clicked()
                || ui.input(|i| i.key_pressed(Key::Enter));
        });
        if let (true, Ok(_), Ok(ShapeRequest { dump, .. })) = (accepts, on_show, chosen) {
            let (side, source) = std::mem::take(self).asked?;
            return Some((side, source, dump));
        }
        if !stays {
            *self = Self::default();
        }
        None
    }

    /// Returns whether a shape was chosen for good, by a double click.
    fn pictures_ui(&mut self, ui: &mut Ui) -> bool {
        let Self { shapes, text, .. } = self;
        if shapes.is_empty() {
            weak_ui(ui, "No usual size fills this file. Type the shape: it is in the recording program's settings.");
            return false;
        }
        weak_ui(ui, "The first frame in each shape that fills the file, the most likely one first");
        let mut accepts = false;
        // The rest of the dialog has room in a small window too.
        let height = (ui.ctx().content_rect().height() - 360.0).clamp(CELL_POINTS.y, 2.6 * (CELL_POINTS.y + 30.0));
        ScrollArea::vertical().max_height(height).show(ui, |ui| {
            egui::Grid::new("shapes").num_columns(COLUMNS).spacing([12.0, 8.0]).show(ui, |ui| {
                for (place, (shape, made)) in shapes.iter_mut().enumerate() {
                    let (name, said) = (shape.dump.to_string(), words(shape));
                    let made = made.get_or_insert_with(|| texture(ui, &name, shape));
                    ui.vertical(|ui| {
                        let response = ui.add(Button::image(picture(made)).selected(*text == name));
                        named(&response, Role::RadioButton, &said);
                        ui.label(said);
                        if response.clicked() {
                            *text = name;
                        }
                        accepts |= response.double_clicked();
                    });
                    if (place + 1) % COLUMNS == 0 {
                        ui.end_row();
                    }
                }
            });
        });
        accepts
    }
}
