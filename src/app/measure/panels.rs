//! Panels of the values along the line, as curves, and of the statistics in the rectangle, for each pane.

use super::{PaneRegion, measured_panes, profiles_of, region_in};
use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::panel::widgets::{named, only_ui, still_plot};
use crate::app::{canvas::number, inspector::PaneWidgets};
use crate::app::{results::Read, view::fixed};
use crate::plane::sample::{RegionStatistics, region_statistics};
use crate::plane::statistics::{Histogram, histogram};
use egui::{Color32, RichText, ScrollArea, Ui};
use egui_plot::{Bar, BarChart, Corner, Legend, Line, PlotPoints};

const BINS: usize = 64;

fn values(ui: &Ui, of: &PaneRegion) -> (Option<RegionStatistics>, Option<Histogram>) {
    crate::app::memo::kept(ui.ctx(), ("values of the region", of.id), (of.picture.id, of.region.clone()), || {
        let statistics = region_statistics(&of.picture.plane, &of.region);
        // A region of one value has no histogram.
        let range = statistics.map(|s| (s.min, s.max)).filter(|(min, max)| min < max);
        (statistics, range.map(|(min, max)| histogram(&of.picture.plane, &of.region, min, max, BINS)))
    })
}

const COLUMNS: [(&str, &str); 7] = [
    ("Picture", "The pane's number and what it shows"),
    ("Pixels", "Pixels of the picture in the rectangle that have a value"),
    ("Mean", "As a fraction of full scale"),
    ("Deviation", "Standard deviation about the mean"),
    ("Min", "The smallest value"),
    ("Max", "The largest value"),
    (
        "Noise",
        "Standard deviation of the noise, from differences of neighbouring pixels, which a smooth picture does not have",
    ),
];

pub fn region_ui(ui: &mut Ui, model: Read<'_>, widgets: &PaneWidgets, queue: &mut Queue) {
    let Some(region) = model.document.measure.region else {
        ui.horizontal(|ui| {
            ui.weak("Drag a rectangle on a picture to measure the values in it.");
            button_ui(ui, model, queue, ActionId::MeasureRegion, Some("Draw a rectangle"));
        });
        return;
    };
    // Nothing is measured during the drag, so that dragging stays smooth.
    if model.document.measure.drag.is_some() {
        return only_ui(ui, "Let go to measure");
    }
    let panes = measured_panes(model, region.pane).into_iter();
    let regions: Vec<PaneRegion> = panes.filter_map(|id| region_in(model, widgets, &region, id)).collect();
    let rows: Vec<[String; COLUMNS.len()]> = regions.iter().map(|of| row(of, values(ui, of).0)).collect();
    ui.horizontal(|ui| {
        button_ui(ui, model, queue, ActionId::MeasureRegion, Some("Draw a rectangle"));
        if ui.button("Copy numbers").on_hover_text("Copy the table, tabs between the columns").clicked() {
            let headings = COLUMNS.map(|(heading, _)| heading).join("\t");
            ui.ctx().copy_text(rows.iter().fold(headings, |text, row| text + "\n" + &row.join("\t")));
        }
        button_ui(ui, model, queue, ActionId::ClearMeasure, Some("Clear rectangle"));
        let rect = region.rect_image;
        let (from, to) = (place_text(rect.min), place_text(rect.max));
        ui.weak(format!("{from} to {to}: {:.1} × {:.1} px", rect.width(), rect.height()));
    });
    let focused = regions.iter().find(|of| of.id == model.document.focus()).or(regions.first());
    let histogram = focused.and_then(|of| Some((of.number, values(ui, of).1?)));
    ui.horizontal_top(|ui| {
        let width = (0.72 * ui.available_width()).max(300.0);
        ui.allocate_ui(egui::vec2(width, ui.available_height()), |ui| {
            ScrollArea::both().auto_shrink(false).show(ui, |ui| table_ui(ui, &rows));
        });
        if let Some((number, histogram)) = histogram {
            histogram_ui(ui, number, &histogram);
        }
    });
}

fn place_text(at: egui::Pos2) -> String {
    format!("({}, {})", fixed(at.x, 1), fixed(at.y, 1))
}

fn row(of: &PaneRegion, statistics: Option<RegionStatistics>) -> [String; COLUMNS.len()] {
    let Some(s) = statistics else {
        return std::array::from_fn(|i| if i == 0 { of.name.clone() } else { "–".to_owned() });
    };
    [
        of.name.clone(),
        s.count.to_string(),
        number(s.mean as f32, 5),
        number(s.deviation as f32, 4),
        number(s.min, 4),
        number(s.max, 4),
        s.noise.map_or_else(|| "–".to_owned(), |noise| number(noise as f32, 4)),
    ]
}

fn table_ui(ui: &mut Ui, rows: &[[String; COLUMNS.len()]]) {
    egui::Grid::new("region").num_columns(COLUMNS.len()).spacing([10.0, 2.0]).striped(true).show(ui, |ui| {
        for (heading, help) in COLUMNS {
            ui.label(RichText::new(heading).small().strong()).on_hover_text(help);
        }
        ui.end_row();
        for row in rows {
            for (place, text) in row.iter().enumerate() {
                let text = RichText::new(text);
                ui.label(if place == 0 { text } else { text.monospace() });
            }
            ui.end_row();
        }
    });
}

fn histogram_ui(ui: &mut Ui, pane: usize, histogram: &Histogram) {
    let bar = |(i, &count): (usize, &u64)| {
        let (from, to) = histogram.bin_range(i);
        Bar::new(0.5 * f64::from(from + to), count as f64).width(f64::from(to - from))
    };
    let bars: Vec<Bar> = histogram.counts.iter().enumerate().map(bar).collect();
    let colour = ui.visuals().hyperlink_color;
    let drawn = still_plot("region histogram")
        .x_axis_label(format!("Values of picture {pane}"))
        .x_axis_formatter(|mark, _| number(mark.value as f32, 3))
        .height(ui.available_height().max(60.0))
        .show(ui, |plot| plot.bar_chart(BarChart::new("Pixels", bars).color(colour)));
    named(&drawn.response, egui::Role::Image, "Histogram of the region");
}

/// The palette of M. Okabe and K. Ito, which colour-blind readers can tell apart.
const CURVES: [Color32; 8] = [
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(0, 158, 115),
    Color32::from_rgb(204, 121, 167),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(213, 94, 0),
    Color32::from_rgb(0, 114, 178),
    Color32::from_rgb(150, 150, 150),
];

pub fn profile_ui(ui: &mut Ui, model: Read<'_>, widgets: &PaneWidgets, queue: &mut Queue) {
    let Some(line) = model.document.measure.line else {
        ui.horizontal(|ui| {
            ui.weak("Drag a line on a picture to see the values along it.");
            button_ui(ui, model, queue, ActionId::MeasureLine, Some("Draw a line"));
        });
        return;
    };
    let profiles = profiles_of(model, widgets, &line);
    let (from, to) = (line.from_image, line.to_image);
    ui.horizontal(|ui| {
        button_ui(ui, model, queue, ActionId::MeasureLine, Some("Draw a line"));
        button_ui(ui, model, queue, ActionId::ExportProfile, Some("Export as CSV…"));
        button_ui(ui, model, queue, ActionId::ClearMeasure, Some("Clear line"));
        ui.weak(format!("{} to {}, {:.1} px", place_text(from), place_text(to), from.distance(to)));
    });
    let plot = still_plot("profile")
        .legend(Legend::default().position(Corner::RightTop))
        .x_axis_label("Distance along the line, px")
        .y_grid_spacer(crate::app::ticks::of_height)
        .y_axis_formatter(|mark, _| number(mark.value as f32, 3))
        .height(ui.available_height().max(60.0));
    let drawn = plot.show(ui, |plot| {
        for (number, name, samples) in &profiles {
            // The line may leave the picture, or cross what has no value.
            let known = samples.iter().filter(|sample| sample.value.is_finite());
            let points: PlotPoints<'_> =
                known.map(|sample| [f64::from(sample.distance_px), f64::from(sample.value)]).collect();
            let colour = CURVES[(number - 1) % CURVES.len()];
            plot.line(Line::new(name, points).color(colour).width(1.5));
        }
    });
    named(&drawn.response, egui::Role::Image, format!("Profile of {} pictures", profiles.len()));
}
