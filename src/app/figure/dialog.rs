//! Dialog that chooses the content of a figure.

use crate::app::actions::{ActionId, Queue};
use crate::app::project::figure::FigureChoice;
use egui::{DragValue, Ui};

/// Draws the dialog if it is open.
pub fn figure_dialog_ui(ctx: &egui::Context, open: &mut bool, choice: &mut FigureChoice, queue: &mut Queue) {
    if !*open {
        return;
    }
    let mut close = false;
    let modal = egui::Modal::new(egui::Id::unique("figure")).show(ctx, |ui| {
        ui.set_width(380.0);
        ui.heading("Figure of what is shown");
        ui.weak("Features, filter, colours and part of the picture as in the panes");
        ui.add_space(6.0);
        switches_ui(ui, choice);
        ui.add_space(4.0);
        numbers_ui(ui, choice);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (label, action) in [("Export SVG…", ActionId::ExportSvg), ("Export PNG…", ActionId::ExportFigurePng)]
            {
                if ui.button(label).on_hover_text(action.action().help).clicked() {
                    queue.push(action);
                    close = true;
                }
            }
            if ui.button("Reset").on_hover_text("Give every choice its default").clicked() {
                *choice = FigureChoice::default();
            }
            if ui.button("Close").clicked() {
                close = true;
            }
        });
    });
    if close || modal.should_close() {
        *open = false;
    }
}

fn switches_ui(ui: &mut Ui, choice: &mut FigureChoice) {
    let switches = [
        (&mut choice.all_panes, "All panes", "All panes on the screen, as they are arranged; else the one in focus"),
        (&mut choice.whole_picture, "Whole picture", "Else the part of it that can be seen"),
        (&mut choice.titles, "Titles", "What each picture is, above it"),
        (&mut choice.letters, "Letters", "(a), (b), … where there are several pictures"),
        (&mut choice.legend, "Legend of features", "What their colours mean, below the picture"),
        (&mut choice.colour_bar, "Colour bar", "The picture's colours and values, below it"),
        (&mut choice.scale_bar, "Scale bar", "A bar of a round number of pixels, in the picture's corner"),
    ];
    for (on, label, tip) in switches {
        ui.checkbox(on, label).on_hover_text(tip);
    }
}

fn numbers_ui(ui: &mut Ui, choice: &mut FigureChoice) {
    egui::Grid::new("figure numbers").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let rows = [
            (&mut choice.scale, "Scale", 0.1..=32.0, 0.02, " px per image pixel"),
            (&mut choice.stroke_width_px, "Line width", 0.1..=20.0, 0.02, " px"),
            (&mut choice.font_size_px, "Letter height", 4.0..=100.0, 0.1, " px"),
        ];
        for (value, label, range, speed, unit) in rows {
            let name = ui.label(label);
            ui.add(DragValue::new(value).range(range).speed(speed).suffix(unit).max_decimals(2)).labelled_by(name.id);
            ui.end_row();
        }
    });
}
