//! Small dialogs: the calibration of files, the choice of one burst of several, and the box about the program.

use crate::app::actions::{ActionId, Queue};
use crate::app::document::{Action, Purpose};
use crate::app::panel::widgets::{close_ui, modal_ui, named, only_ui};
use crate::app::settings::Settings;
use crate::burst::{FrameRange, OpenOptions, RawColour, Tiling, TimesChoice, ViewGrid, ViewsChoice};
use crate::engine::Engine;
use crate::requests::BurstSource;
use egui::{DragValue, RichText, ScrollArea, TextEdit, Ui, vec2};

const COLOURS: [(RawColour, &str, &str); 4] = [
    (RawColour::Luma, "Luma", "Mean of each 2 × 2 square of pixels: all the light"),
    (RawColour::Green, "Green", "Mean of the two green pixels of each 2 × 2 square"),
    (RawColour::Red, "Red", "Red pixel of each 2 × 2 square"),
    (RawColour::Blue, "Blue", "Blue pixel of each 2 × 2 square"),
];

const TIMES: [(TimesChoice, &str, &str); 4] = [
    (TimesChoice::Even, "Even", "Frames are evenly spaced, whatever their files say"),
    (TimesChoice::Names, "Names", "Stamps in the names of the files: dates, seconds, nanoseconds, running numbers"),
    (TimesChoice::Header, "Files", "Times that the files hold: EXIF, the date of a TIFF, FITS, SER, films, bags"),
    (
        TimesChoice::Found,
        "Found",
        "Order and times in which the motion is uniform: of frames exchanged, missing, late or copied",
    ),
];

/// Draws the widgets beside the name of a row, and ends it.
fn row_of(ui: &mut Ui, name: &egui::Response, widgets: impl FnOnce(&mut Ui)) {
    ui.horizontal(widgets).response.labelled_by(name.id);
    ui.end_row();
}

/// Returns whether a list of times is to be chosen.
fn times_ui(ui: &mut Ui, times: &mut Option<TimesChoice>) -> bool {
    let (name, mut asks) = (ui.label("Times").on_hover_text("When the frames were taken"), false);
    row_of(ui, &name, |ui| {
        let chosen = times.clone().unwrap_or_default();
        for (choice, label, tip) in TIMES {
            if ui.radio(choice == chosen, label).on_hover_text(tip).clicked() {
                *times = Some(choice).filter(|choice| *choice != TimesChoice::Even);
            }
        }
        if let TimesChoice::List(path) = &chosen {
            let label = path.file_name().unwrap_or_default().to_string_lossy();
            ui.radio(true, label).on_hover_text(path.display().to_string());
        }
        asks = ui.button("List…").on_hover_text(Purpose::OpenTimes.hint()).clicked();
    });
    asks
}

fn take_ui(ui: &mut Ui, take: &mut Option<FrameRange>) {
    let mut own = take.is_some();
    ui.checkbox(&mut own, "Take frames").on_hover_text("Frames of a long recording that are opened, counted from 0");
    let FrameRange { mut start, mut end } = take.unwrap_or(FrameRange { start: 0, end: 10 });
    ui.horizontal(|ui| {
        if own {
            ui.add(DragValue::new(&mut start).range(0..=usize::MAX - 1)).on_hover_text("First frame");
            ui.label("…");
            end = end.max(start + 1) - 1;
            ui.add(DragValue::new(&mut end).range(start..=usize::MAX - 1)).on_hover_text("Last frame");
            end += 1;
        } else {
            ui.weak("all");
        }
    });
    *take = own.then_some(FrameRange { start, end });
    ui.end_row();
}

fn topic_ui(ui: &mut Ui, topic: &mut Option<String>) {
    let tip = "Topic of a ROS bag or MCAP file that holds the frames, where several have pictures";
    let name = ui.label("Topic").on_hover_text(tip);
    let text = topic.get_or_insert_default();
    ui.add(TextEdit::singleline(text).hint_text("of a bag with several")).labelled_by(name.id);
    *topic = topic.take().filter(|text| !text.is_empty());
    ui.end_row();
}

const TILINGS: [(Option<Tiling>, &str, &str); 3] = [
    (None, "Files", "Each frame is a view, row by row"),
    (Some(Tiling::Tiled), "Tiled", "One picture holds all views, side by side"),
    (Some(Tiling::Eslf), "ESLF", "One picture holds all views, interleaved, as those of Lytro cameras"),
];

fn views_ui(ui: &mut Ui, views: &mut Option<ViewsChoice>) {
    const MAX_SIDE: usize = 4096;
    let name = ui.label("Views").on_hover_text("Frames that are the views of a light field");
    row_of(ui, &name, |ui| {
        let usual =
            "Views where the names of all of a grid have rows and columns (view_03_07.png), otherwise frames in time";
        ui.radio_value(views, None, "Usual").on_hover_text(usual);
        ui.radio_value(views, Some(ViewsChoice::Names), "Names")
            .on_hover_text("Rows and columns in the names of the files");
        let grid = match *views {
            Some(ViewsChoice::Grid(grid)) => Some((grid, None)),
            Some(ViewsChoice::Picture(grid, tiling)) => Some((grid, Some(tiling))),
            Some(ViewsChoice::Names) | None => None,
        };
        if ui.radio(grid.is_some(), "Grid").on_hover_text("Rows and columns of views").clicked() && grid.is_none() {
            *views = ViewGrid::new(9, 9).map(ViewsChoice::Grid);
        }
        let Some((grid, mut tiling)) = grid else { return };
        let (mut rows, mut columns) = (grid.rows(), grid.columns());
        ui.add(DragValue::new(&mut rows).range(1..=MAX_SIDE)).on_hover_text("Rows of views");
        ui.label("×");
        ui.add(DragValue::new(&mut columns).range(1..=MAX_SIDE)).on_hover_text("Columns of views");
        for (own, label, tip) in TILINGS {
            ui.radio_value(&mut tiling, own, label).on_hover_text(tip);
        }
        let grid = ViewGrid::new(rows, columns).unwrap_or(grid);
        *views = Some(tiling.map_or(ViewsChoice::Grid(grid), |tiling| ViewsChoice::Picture(grid, tiling)));
    });
}

/// Draws the dialog if there is a draft; closing it drops the draft. Returns the purpose of a file to be chosen.
pub fn calibration_ui(ctx: &egui::Context, draft: &mut Option<OpenOptions>, queue: &mut Queue) -> Option<Purpose> {
    let options = draft.as_mut()?;
    let (mut choice, mut stays) = (None, true);
    modal_ui(ctx, &mut stays, ("calibration", 520.0, "Calibration"), |ui| {
        ui.weak("How values in files become intensities. A calibration frame can be dropped here.");
        ui.add_space(6.0);
        egui::Grid::new("calibration").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
            let bias = "Dark frame, or a stack or folder of dark frames, that is subtracted from each frame";
            let flat = "Picture of an evenly lit bright surface, by which each frame is divided";
            let mask = "Picture of the frames' size, white where they are seen: what it hides is in no mean and gives no features";
            let turns = "Orientations of the camera in the frames, by which these are turned to mid-burst: slopes are then of its way alone";
            let lens = "File of the camera that took the frames; camera.toml beside or above them is found";
            let is_turned = options.rotations.is_some();
            let frames = [
                ("Bias frame", &mut options.bias, bias, &[Purpose::OpenBias][..]),
                ("Flat frame", &mut options.flat, flat, &[Purpose::OpenFlat]),
                ("Mask", &mut options.mask, mask, &[Purpose::OpenMask, Purpose::OpenMasks]),
                ("Rotations", &mut options.rotations, turns, &[Purpose::OpenRotations]),
                ("Camera", &mut options.lens, lens, &[Purpose::OpenLens]),
            ];
            let shown = if is_turned { frames.len() } else { frames.len() - 1 };
            for (label, path, tip, purposes) in frames.into_iter().take(shown) {
                ui.label(label).on_hover_text(tip);
                file_ui(ui, label, path, purposes, &mut choice, queue);
                ui.end_row();
            }
            let full = "Value in the files that becomes intensity 1, such as 4095 for 12 bits in 16-bit files";
            let black = "Value in the files that becomes intensity 0; values below it become negative";
            level_ui(ui, "Full scale", &mut options.full_scale, 65535.0, full);
            level_ui(ui, "Black level", &mut options.black_level, 0.0, black);
            let name = ui.label("Raw colour");
            row_of(ui, &name, |ui| {
                for (colour, label, tip) in COLOURS {
                    ui.radio_value(&mut options.raw_colour, colour, label).on_hover_text(tip);
                }
            });
            take_ui(ui, &mut options.take);
            if times_ui(ui, &mut options.times) {
                choice = Some(Purpose::OpenTimes);
            }
            views_ui(ui, &mut options.views);
            topic_ui(ui, &mut options.topic);
        });
        ui.checkbox(&mut options.linearise, "Linear light")
            .on_hover_text("Undo the sRGB encoding of 8-bit and 16-bit pictures");
        ui.checkbox(&mut options.accept_damaged, "Accept damaged frames")
            .on_hover_text("Decode them as far as possible; the rest of the frame is grey");
        ui.checkbox(&mut options.mask_saturated, "Mask saturated pixels")
            .on_hover_text("Pixels at or above the full scale are in no mean and give no features");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let tip = "Open the present bursts again with these options. Mask, part, times and views are theirs; the rest is used for later bursts too";
            if ui.button("Apply").on_hover_text(tip).clicked() {
                queue.push(Action::Calibrate(options.clone()));
                ui.close();
            }
            if ui.button("Reset").on_hover_text("Use the values of the files as they are").clicked() {
                *options = OpenOptions::default();
            }
            close_ui(ui, "Cancel");
        });
    });
    draft.take_if(|_| !stays);
    choice
}

/// Draws the choice of an optional file, and of a folder or a drawing in its place where there are `purposes` for them.
fn file_ui(
    ui: &mut Ui,
    label: &str,
    path: &mut Option<std::path::PathBuf>,
    purposes: &[Purpose],
    choice: &mut Option<Purpose>,
    queue: &mut Queue,
) {
    ui.horizontal(|ui| {
        let words = [format!("Choose {}…", label.to_lowercase()), "Folder…".to_owned()];
        for (word, purpose) in words.into_iter().zip(purposes) {
            if ui.button(word).on_hover_text(purpose.hint()).clicked() {
                *choice = Some(*purpose);
            }
        }
        if purposes.len() > 1 && ui.button("Draw").on_hover_text(ActionId::DrawMask.action().help).clicked() {
            queue.push(ActionId::WorkspaceInspect);
            queue.push(ActionId::DrawMask);
            ui.close();
        }
        let Some(chosen) = path.clone() else { return only_ui(ui, "none") };
        path.take_if(|_| ui.button(format!("Remove {}", label.to_lowercase())).clicked());
        let name = chosen.file_name().unwrap_or(chosen.as_os_str()).to_string_lossy();
        ui.add(egui::Label::new(name).truncate()).on_hover_text(chosen.display().to_string());
    });
}

fn level_ui(ui: &mut Ui, label: &str, level: &mut Option<f32>, default: f32, tip: &str) {
    let mut own = level.is_some();
    ui.checkbox(&mut own, label).on_hover_text(tip);
    *level = own.then_some(level.unwrap_or(default));
    match level {
        Some(value) => {
            let field = DragValue::new(value).range(-1e9..=1e9).speed(1.0).max_decimals(3);
            ui.add(field).on_hover_text(format!("{label}: {tip}"))
        }
        None => ui.weak("from the files"),
    };
    ui.end_row();
}

/// Notices of software and fonts of others in the program: a list of packages, then the texts of their licences.
const NOTICES: &str = include_str!("../../../assets/THIRD-PARTY.txt");

fn packages() -> Vec<[&'static str; 4]> {
    let heading = NOTICES.lines().skip_while(|line| *line != "name | version | licence | source");
    let rows = heading.skip(1).take_while(|line| !line.is_empty());
    rows.filter_map(|row| row.split(" | ").collect::<Vec<_>>().try_into().ok()).collect()
}

fn notices_ui(ui: &mut Ui) {
    egui::CollapsingHeader::new("Software of others").show(ui, |ui| {
        let packages = packages();
        ui.label(format!("{} packages, under licences of their own; fonts are in one of them.", packages.len()));
        let height = ui.text_style_height(&egui::TextStyle::Body);
        let area = ScrollArea::vertical().max_height(220.0).auto_shrink(false);
        area.show_rows(ui, height, packages.len(), |ui, shown| {
            egui::Grid::new("packages").num_columns(2).start_row(shown.start).striped(true).show(ui, |ui| {
                for [name, version, licence, source] in &packages[shown] {
                    ui.label(format!("{name} {version}")).on_hover_text(*source);
                    ui.add(egui::Label::new(*licence).truncate()).on_hover_text(*licence);
                    ui.end_row();
                }
            });
        });
        if ui.button("Copy licences").on_hover_text("Copy this list and the texts of all licences").clicked() {
            ui.copy_text(NOTICES.to_owned());
        }
    });
}

/// Draws the box about the program, in which the memory for pictures can be set.
pub fn about_ui(ctx: &egui::Context, open: &mut bool, engine: &Engine, settings: &mut Settings) {
    modal_ui(ctx, open, ("about", 420.0, concat!("Burstscope ", env!("CARGO_PKG_VERSION"))), |ui| {
        ui.label(env!("CARGO_PKG_DESCRIPTION"));
        ui.add_space(6.0);
        ui.label("The method is that of A. Ravendran, M. Bryson and D. G. Dansereau, “BuFF: Burst Feature Finder for Light-Constrained 3D Reconstruction”.");
        ui.hyperlink_to("arXiv 2209.09470", "https://arxiv.org/abs/2209.09470");
        if let Some(gpu) = crate::app::gpu::Gpu::of(ui.ctx()) {
            ui.add_space(6.0);
            ui.weak(format!("Graphics adapter: {}", gpu.adapter_name));
        }
        ui.horizontal(|ui| {
            let (held, mb) = (engine.held(), |bytes: usize| bytes >> 20);
            let words = format!("Memory: searches {} MB, pictures {} of", mb(held.trail_bytes), mb(held.picture_bytes));
            let label = ui.weak(words);
            let value = DragValue::new(&mut settings.cache_mb).range(Settings::CACHE_MB).suffix(" MB");
            let tip = "Largest memory of the pictures that are kept to be shown again at once";
            if ui.add(value).labelled_by(label.id).on_hover_text(tip).changed() {
                engine.set_cache_bytes(settings.cache_bytes());
            }
        });
        ui.add_space(6.0);
        ui.label("MIT or Apache-2.0, at your option.");
        notices_ui(ui);
        ui.add_space(6.0);
        close_ui(ui, "Close");
    });
}

/// Draws the choice among `bursts` if there are any; closing it empties them. Returns the chosen one.
pub fn chooser_ui(ctx: &egui::Context, bursts: &mut Vec<BurstSource>) -> Option<BurstSource> {
    let (mut chosen, mut is_open) = (None, !bursts.is_empty());
    modal_ui(ctx, &mut is_open, ("burst chooser", 360.0, &format!("{} bursts in this folder", bursts.len())), |ui| {
        ui.weak("Choose the burst to open.");
        ui.add_space(6.0);
        ScrollArea::vertical().max_height(320.0).min_scrolled_height(200.0).show(ui, |ui| {
            for burst in bursts.iter() {
                if row_ui(ui, burst).clicked() {
                    chosen = Some(burst.clone());
                    ui.close();
                }
            }
        });
        ui.add_space(6.0);
        close_ui(ui, "Cancel");
    });
    if !is_open {
        bursts.clear();
    }
    chosen
}

fn row_ui(ui: &mut Ui, burst: &BurstSource) -> egui::Response {
    // Stacks of one name in several folders are distinguished by their folders.
    let folder =
        burst.paths().first().and_then(|path| path.parent()?.file_name()).unwrap_or_default().to_string_lossy();
    let button = egui::Button::new(burst.label())
        .min_size(vec2(ui.available_width(), 24.0))
        .right_text(RichText::new(format!("in {folder}")).weak());
    let response = ui.add(button);
    named(&response, egui::Role::Button, format!("{} in {folder}", burst.label()));
    response
}
