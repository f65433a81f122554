//! Curves of the Lab: one large plot, smaller ones beside it. Clicking a point shows its chart.

use super::curve_colour;
use crate::app::document::{Action, CompareLook, LabSet, MethodId, Queue, Side};
use crate::app::panel::widgets::{named, still_plot};
use crate::app::results::{LabResult, Read};
use crate::detector::ParamChange;
use crate::detector::params::doc;
use crate::evaluate::BurstMethod;
use crate::evaluate::curves::{StudyCurve, StudyPlot, percent};
use crate::export::SeriesPoint;
use crate::inspect::words::number;
use crate::study::{SameFalseRate, StudyPoint};
use egui::{Color32, Label, RichText, Role, Sense, Shape, Stroke, Ui, WidgetInfo, vec2};
use egui_plot::{Line, LineStyle, PlotPoint, PlotPoints, PlotUi, Points};
use std::collections::BTreeSet;

/// Maximum distance of the pointer from a point, in points of the window.
const REACH_UI: f32 = 14.0;

struct Drawn {
    set: LabSet,
    name: String,
    curve: StudyCurve,
}

pub fn curves_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let mut lab = model.document.lab.clone();
    let results = model.lab_results();
    let Some((.., first)) = results.first() else { return empty_ui(ui) };
    let (summary, is_whole) = (first.report.summary(), first.is_whole);
    let rows = first.report.roc_rows();
    let row_label = rows.get(lab.roc_row).or(rows.last()).cloned();
    let mut plots = merged(model);
    let mut chosen_row = None;
    ui.horizontal(|ui| {
        ui.label(RichText::new(if is_whole { "Curves" } else { "Curves so far" }).strong());
        ui.add(egui::Label::new(RichText::new(summary).weak()).truncate());
    });
    if !rows.is_empty() {
        ui.horizontal(|ui| {
            ui.label(RichText::new("ROC at").weak());
            for (index, label) in rows.iter().enumerate() {
                let is_shown = row_label.as_ref() == Some(label);
                if ui.selectable_label(is_shown, label).on_hover_text("Show the ROC curves at this ratio").clicked() {
                    chosen_row = Some(index);
                }
            }
        });
    }
    if let Some(rate) = first.report.same_false_rate(lab.roc_row).filter(|_| is_whole) {
        same_false_rate_ui(ui, model, rate, queue);
    }
    let hidden = &mut lab.hidden;
    legend_ui(ui, &plots, hidden);
    plots.iter_mut().for_each(|(_, curves)| curves.retain(|one| !hidden.contains(&one.name)));
    let mut pointed = None;
    let (width, height) = (ui.available_width(), ui.available_height());
    ui.horizontal_top(|ui| {
        let beside = plots.len().saturating_sub(1);
        let large = if beside == 0 { width } else { 0.56 * width };
        for (index, group) in [&plots[..plots.len().min(1)], &plots[plots.len().min(1)..]].into_iter().enumerate() {
            let column = if index == 0 { large } else { width - large - ui.spacing().item_spacing.x };
            ui.vertical(|ui| {
                ui.set_width(column);
                let each = height / group.len().max(1) as f32;
                for (plot, curves) in group {
                    let size = vec2(column, (each - 26.0).max(80.0));
                    pointed = plot_ui(ui, model, plot, curves, size).or(pointed);
                }
            });
        }
    });
    lab.roc_row = chosen_row.unwrap_or(lab.roc_row);
    let has_charts = |set| model.results.studies.result(set).is_some_and(|result| result.study.seeds().is_some());
    if let Some((set, point, true)) = pointed.filter(|(set, ..)| has_charts(*set)) {
        (lab.selected, lab.selected_chart) = (Some((set, point)), 0);
    }
    queue.edit(model.document, Action::SetLab(Box::new(lab)));
}

/// Draws the button that makes all methods comparable, as the paper does: each at the peak threshold where the same
/// share of its detections on the charts is false.
fn same_false_rate_ui(ui: &mut Ui, model: Read<'_>, rate: SameFalseRate, queue: &mut Queue) {
    let method = MethodId::of_search(&model.params_of(Side::A));
    let own = rate.of(method.of_studies());
    let (share, snr) = (percent(rate.false_fraction), rate.snr);
    let line = |(method, threshold): &(_, _)| format!("{}  {}\n", BurstMethod::label(*method), number(*threshold, 3));
    let lines: String = rate.peak_thresholds.iter().map(line).collect();
    let mut tip = format!(
        "Peak thresholds at which {share} of the detections on charts of SNR {snr} is false, as the paper compares methods:\n{lines}"
    );
    tip += "Methods compares at these; the search takes that of its own method. They hold for bursts as dark as the charts.";
    ui.horizontal(|ui| {
        if ui.button(format!("Search at {share} false")).on_hover_text(tip).clicked() {
            if let Some(threshold) = own {
                queue.push(Action::Change(vec![ParamChange::new(doc::PEAK_THRESHOLD, threshold)]));
            }
            let same_false_rate = Some(rate);
            queue.push(Action::SetMethods(CompareLook { same_false_rate, ..model.document.methods.clone() }));
        }
        if own.is_none() {
            ui.weak(format!("for Methods alone: the study has no {}", method.label()));
        }
    });
}

/// Draws the legend of all plots above them, where it covers no curve; a click hides or shows the curves of a name.
fn legend_ui(ui: &mut Ui, plots: &[(StudyPlot, Vec<Drawn>)], hidden: &mut BTreeSet<String>) {
    let mut shown = BTreeSet::new();
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for one in plots.iter().flat_map(|(_, curves)| curves).filter(|one| shown.insert(&one.name)) {
            let (is_hidden, colour) = (hidden.contains(&one.name), curve_colour(ui, one.curve.line.colour));
            let colour = if is_hidden { colour.gamma_multiply(0.3) } else { colour };
            let (rect, _) = ui.allocate_exact_size(vec2(20.0, 12.0), Sense::hover());
            let ends = [rect.left_center(), rect.right_center()];
            let stroke = Stroke::new(2.0, colour);
            ui.painter().extend(match one.set {
                LabSet::Current => vec![Shape::line_segment(ends, stroke)],
                LabSet::Kept(_) => Shape::dashed_line(&ends, stroke, 4.0, 3.0),
            });
            let text = RichText::new(&one.name).small();
            let text = if is_hidden { text.weak() } else { text };
            let entry = ui.add(Label::new(text).selectable(false).sense(Sense::click()));
            let help = if is_hidden { "Show this curve" } else { "Hide this curve" };
            entry.widget_info(|| WidgetInfo::labeled(Role::CheckBox, true, format!("Curve {}", one.name)));
            if entry.on_hover_text(help).clicked() && !hidden.remove(&one.name) {
                hidden.insert(one.name.clone());
            }
            ui.add_space(8.0);
        }
    });
}

fn empty_ui(ui: &mut Ui) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.3).max(12.0));
        ui.label(RichText::new("Measure the detector").size(18.0).strong());
        ui.weak("Charts of discs whose places, sizes and motions are known, at several ratios of signal to noise:");
        ui.weak("choose them on the left and press Run study. The curves grow while charts are finished.");
    });
}

/// The plots of all results that are drawn, each with its name; ROC curves are those of one row, where a result has it.
pub fn shown_plots(model: Read<'_>) -> Vec<(String, Vec<StudyPlot>)> {
    let results = model.lab_results();
    let rows = results.first().map(|(.., first)| first.report.roc_rows()).unwrap_or_default();
    let row_label = rows.get(model.document.lab.roc_row).or(rows.last());
    let set = |(_, name, result): &(LabSet, Option<&str>, &LabResult)| {
        let row = row_label.and_then(|label| result.report.roc_rows().iter().position(|row| row == label));
        (name.unwrap_or("This study").to_owned(), result.report.plots(row.unwrap_or(usize::MAX)))
    };
    results.iter().map(set).collect()
}

/// Plots of all results; plots of one subject lie over one another.
fn merged(model: Read<'_>) -> Vec<(StudyPlot, Vec<Drawn>)> {
    let mut plots: Vec<(StudyPlot, Vec<Drawn>)> = Vec::new();
    for ((set, name, _), (_, of_set)) in model.lab_results().into_iter().zip(shown_plots(model)) {
        for plot in of_set {
            let drawn = |curve: &StudyCurve| {
                let label = &curve.line.label;
                let name = name.map_or_else(|| label.clone(), |name| format!("{label}  {name}"));
                Drawn { set, name, curve: curve.clone() }
            };
            let drawn: Vec<Drawn> = plot.curves.iter().map(drawn).collect();
            match plots.iter_mut().find(|(there, _)| there.title == plot.title) {
                Some((_, all)) => all.extend(drawn),
                None => plots.push((plot, drawn)),
            }
        }
    }
    plots
}

/// Draws one plot; returns the point under the pointer, and whether it was clicked.
fn plot_ui(
    ui: &mut Ui,
    model: Read<'_>,
    plot: &StudyPlot,
    curves: &[Drawn],
    size: egui::Vec2,
) -> Option<(LabSet, StudyPoint, bool)> {
    let title = plot.title.as_str();
    ui.horizontal(|ui| {
        ui.label(RichText::new(title).small().strong());
        ui.add(egui::Label::new(RichText::new(plot.spread).small().weak()).truncate());
    });
    let widget = still_plot(("lab", title))
        .width(size.x)
        .height(size.y)
        .allow_boxed_zoom(false)
        .show_x(false)
        .show_y(false)
        .include_y(0.0)
        .include_x(0.0)
        .x_grid_spacer(crate::app::ticks::of_width)
        .x_axis_label(plot.x_label)
        .y_axis_label(plot.y_label.as_str())
        .label_formatter(|_| None);
    let colours: Vec<Color32> = curves.iter().map(|one| curve_colour(ui, one.curve.line.colour)).collect();
    let drawn = widget.show(ui, |area| {
        for (one, &colour) in curves.iter().zip(&colours) {
            draw_curve(area, model, one, plot.marks_points, colour);
        }
    });
    named(&drawn.response, Role::Image, format!("Plot: {title}, {} curves", curves.len()));
    let pos = drawn.response.hover_pos()?;
    let at = |point: &SeriesPoint| drawn.transform.position_from_point(&PlotPoint::new(point.x, point.y));
    let points = curves.iter().flat_map(|one| one.curve.line.points.iter().map(move |point| (one, point)));
    let (one, point) = crate::app::view::nearest(points.map(|of| (at(of.1).distance(pos), of)), REACH_UI)?;
    let clicked = drawn.response.clicked();
    let value = |y: f64| number(y as f32, 2);
    let spread = point.spread.map_or_else(String::new, |[low, high]| format!(" ({} to {})", value(low), value(high)));
    let [x, y] = [value(point.x), value(point.y)];
    let text = format!("{}\n{}: {x}\n{}: {y}{spread}", one.name, plot.x_label, plot.y_label);
    drawn.response.on_hover_text_at_pointer(text);
    Some((one.set, StudyPoint { row_value: one.curve.row_value(point), method: one.curve.method }, clicked))
}

fn draw_curve(area: &mut PlotUi<'_>, model: Read<'_>, one: &Drawn, marks_points: bool, colour: Color32) {
    let points = &one.curve.line.points;
    let line: PlotPoints<'_> = points.iter().map(|point| [point.x, point.y]).collect();
    let style = if one.set == LabSet::Current { LineStyle::Solid } else { LineStyle::dashed_dense() };
    area.line(Line::new(one.name.clone(), line).color(colour).width(1.6).style(style));
    for point in points.iter().filter(|point| point.y.is_finite()) {
        if let Some([low, high]) = point.spread {
            let bar = PlotPoints::from(vec![[point.x, low], [point.x, high]]);
            area.line(Line::new("", bar).color(colour).width(1.0));
        }
        let of_point = StudyPoint { row_value: one.curve.row_value(point), method: one.curve.method };
        if marks_points {
            let radius = if model.document.lab.selected == Some((one.set, of_point)) { 5.0 } else { 2.8 };
            area.points(Points::new("", [point.x, point.y]).color(colour).radius(radius).filled(true));
        }
    }
}
