//! Selected match, and the reason why a feature of A has this match or none: its candidates in B, its expected place.

use crate::app::actions::{ActionId, Queue, button_ui};
use crate::app::canvas::number;
use crate::app::document::{Action, Side};
use crate::app::panel::selection::{PatchView, descriptor_ui, walk_ui};
use crate::app::panel::widgets::{named, number_row_ui, only_ui, section_ui, warning_ui, weak_ui};
use crate::app::results::{MatchRow, Matches, PATCHES, Read, lost_words};
use crate::app::view::{fixed, signed, signed_slope};
use crate::app::workspace::pair::lines::CANDIDATE_COLOURS;
use crate::detector::Feature;
use crate::export::MatchKind;
use crate::inspect::pair::{Lost, Rivalry, Unmatched};
use crate::inspect::words::{counted, sentence};
use crate::matching::TwoViewModel;
use crate::requests::{FoundLosses, MatchRequest};
use egui::{Color32, Grid, Label, RichText, Ui};

pub fn detail_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Selected match", |ui| {
        walk_ui(ui, model, queue);
        ui.add_space(4.0);
        let Some(matches) = &model.results.pair.matches else { return only_ui(ui, "There are no matches yet.") };
        let Some(row) = model.match_in_focus().and_then(|index| matches.row(index)) else {
            return only_ui(ui, "Point at a line or a row of the table; click to keep it.");
        };
        let word = match MatchKind::of(row.inlier) {
            MatchKind::Inlier => "inlier",
            MatchKind::Outlier => "outlier",
            MatchKind::Unverified => "not verified",
        };
        ui.horizontal(|ui| {
            ui.label(RichText::new(format!("Match {}: {word}", row.index)).strong());
            ui.weak(if model.document.selected_match.is_none() { "  (click to keep)" } else { "" });
        });
        if let Some(limit) = matches.passed_limit(&row) {
            weak_ui(ui, limit);
        }
        if let Some(stale) = model.stale_matches() {
            ui.label(RichText::new(stale).color(crate::app::style::warning(ui)));
        }
        ui.add_space(4.0);
        let width_of = |count: f32| ((ui.available_width() - 8.0 * (count - 1.0)) / count).clamp(60.0, 150.0);
        let [of_two, of_three] = [2.0, 3.0].map(width_of);
        patches_ui(ui, model, &row, if row.aligned.is_some() { of_three } else { of_two });
        descriptors_ui(ui, matches, &row, of_two);
        ui.add_space(4.0);
        numbers_ui(ui, matches, &row);
    });
}

fn patches_ui(ui: &mut Ui, model: Read<'_>, row: &MatchRow<'_>, width: f32) {
    let slope = |feature: &Feature| format!(": slope {}", signed_slope(feature.slope, 2));
    let stack = "From the motion stack at the feature's own slope, in pixels per frame";
    let aligned = "Where the picture of A's place is found in B, turned and scaled as it is there";
    let found = [("A", Side::A, *row.a, slope(row.a), stack), ("B", Side::B, *row.b, slope(row.b), stack)];
    let aligned = row.aligned.map(|found| ("B, aligned", Side::B, found.b, String::new(), aligned));
    ui.horizontal(|ui| {
        for (label, side, feature, slope, help) in found.into_iter().chain(aligned) {
            let (name, display) = (&format!("Patch in {label}"), model.document.ranges_of_side(side).intensity);
            let view = PatchView { name, feature, turned: true, display };
            let caption = RichText::new(format!("{label}{slope}")).small().weak();
            view.ui(ui, model.stack_at(side, feature.slope), width, caption).on_hover_text(help);
        }
    });
}

fn descriptors_ui(ui: &mut Ui, matches: &Matches, row: &MatchRow<'_>, width: f32) {
    ui.horizontal(|ui| {
        for (side, index) in [(Side::A, row.found.a), (Side::B, row.found.b)] {
            if let Some(descriptor) = matches.detection(side).descriptors.get(index) {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    descriptor_ui(ui, &format!("Descriptor in {}", side.name()), descriptor, width);
                });
            }
        }
    });
}

fn numbers_ui(ui: &mut Ui, matches: &Matches, row: &MatchRow<'_>) {
    let grid = egui::Grid::new("match numbers").num_columns(2).spacing([12.0, 2.0]).striped(true).min_col_width(96.0);
    grid.show(ui, |ui| {
        let mut line = |name: &str, help: &str, value: String| number_row_ui(ui, name, help, &value);
        line("Distance", "Euclidean distance of the two descriptors", format!("{:.1}", row.found.distance));
        let predicted = row.found.predicted;
        let how = if predicted.is_some() { "predicted by its motion" } else { "sure, by descriptors alone" };
        let help = "Among all of B by descriptors alone, or among the places where its motion puts it";
        line("Found", help, how.to_owned());
        let ratio = |ratio: Option<f32>| ratio.map_or_else(|| "no other".to_owned(), |ratio| format!("{ratio:.3}"));
        let among = predicted.map_or_else(String::new, |predicted| format!(" among {}", predicted.among));
        let help = "Distance over that to the second nearest; with the mutual check, the larger of both directions";
        line("Ratio", help, ratio(row.found.ratio) + &among);
        if let Some(predicted) = predicted {
            let help = "Distance over that to the nearest other in all of B; above 1 where another is nearer";
            line("Ratio among all", help, ratio(predicted.ratio_among_all));
        }
        let (name, help) = error_words(matches.model());
        let px = |error: Option<f32>| error.map_or_else(|| "–".to_owned(), |e| format!("{} px", number(e, 3)));
        line(name, help, px(row.error_px) + if row.aligned.is_some() { " aligned" } else { "" });
        if let Some(aligned) = row.aligned {
            line("Error as found", "The same before the alignment has moved both places", px(row.error_found_px));
            let help = "Agreement of the pictures of both places after they are laid over one another, −1 … 1";
            line("Correlation", help, format!("{:.2}", aligned.correlation));
            let help = "Distance of the measured place from where the keypoint's other matches put it";
            line("Contradiction", help, format!("{} px", number(aligned.residual_px as f32, 2)));
        }
        let help = "Number in the order of strength, from 0, as in files";
        let place_in = |i: usize, side| format!("{i} of {}", matches.detection(side).features.len());
        line("Feature in A", help, place_in(row.found.a, Side::A));
        line("Feature in B", help, place_in(row.found.b, Side::B));
        let place = |f: &Feature| format!("{}, {} px", fixed(f.u, 2), fixed(f.v, 2));
        line("Place in A", "(u, v) at mid-burst", place(row.a));
        line("Place in B", "(u, v) at mid-burst", place(row.b));
        let (du, dv) = (row.b.u - row.a.u, row.b.v - row.a.v);
        line("Shift A to B", "Difference of the places", format!("{}, {} px", signed(du, 2), signed(dv, 2)));
        line("Scale A, B", "σ, in pixels", format!("{:.2}, {:.2} px", row.a.sigma, row.b.sigma));
        let slope = |f: &Feature| format!("{} px/frame", signed_slope(f.slope, 3));
        line("Slope in A", "Apparent motion", slope(row.a));
        line("Slope in B", "Apparent motion", slope(row.b));
        let turn = (row.b.orientation - row.a.orientation).to_degrees();
        let turn = (turn + 180.0).rem_euclid(360.0) - 180.0;
        line("Rotation A to B", "Difference of the orientations", format!("{}°", signed(turn, 1)));
        let help = "|response| over the noise of the DoG at its scale";
        line("SNR A, B", help, format!("{:.1}, {:.1}", row.a.snr, row.b.snr));
    });
}

fn error_words(model: Option<&TwoViewModel>) -> (&'static str, &'static str) {
    match model {
        Some(TwoViewModel::Homography { .. }) => (
            "Homography error",
            "Root mean square of the distances, in both pictures, between a point and its partner mapped by the homography",
        ),
        Some(_) => {
            ("Epipolar error", "Sampson distance: about how far both points must move to fit the epipolar geometry")
        }
        None => ("Error", "There is no geometry that enough matches agree on"),
    }
}

/// Minimum difference of slopes for a note, px/frame.
const SLOPES_APART: f32 = 0.5;

pub fn why_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    section_ui(ui, "Why this match, or none", |ui| {
        let Some(found) = model.losses() else { return only_ui(ui, "There are no matches yet.") };
        let Some(why) = &model.results.pair.lost.why else {
            return only_ui(ui, "Click a feature of A, a match, or a row of the unmatched features.");
        };
        let sides = &found.request.request;
        let Some(own) = sides.a.features.get(why.feature) else { return };
        let unmatched = &why.unmatched;
        let state = match unmatched.lost {
            Lost::Not => "matched".to_owned(),
            Lost::NoKeypoint => "no keypoint in B".to_owned(),
            Lost::Geometry => "lost to the geometry".to_owned(),
            lost => format!("lost to the {}", lost_words(lost)[0]),
        };
        ui.label(RichText::new(format!("Feature {} of A: {state}", why.feature)).strong());
        ui.add(Label::new(sentence(&unmatched.sentence)).wrap());
        for line in notes(own, unmatched, sides) {
            warning_ui(ui, line);
        }
        if let Some(twin) = model.results.pair.lost.twin(why.feature) {
            let fate = if found.lost[twin] == Lost::Not { ", which is matched" } else { "" };
            weak_ui(ui, format!("Another orientation of feature {}{fate}.", twin));
        }
        ui.add_space(4.0);
        candidate_patches_ui(ui, model, own, unmatched, sides);
        candidates_ui(ui, unmatched, found);
        weak_ui(ui, expected_words(unmatched, found));
        remedy_ui(ui, model, queue);
        if !unmatched.expected.is_empty() {
            button_ui(ui, model, queue, ActionId::ProbeExpected, None);
        }
        if model.document.selected_match.is_none() {
            button_ui(ui, model, queue, ActionId::ClearSelection, Some("Clear"));
        }
    });
}

/// Draws the change of the parameters that would match the feature, with what else it changes.
fn remedy_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(params) = model.remedy() else { return };
    let change = if params.ratio != model.document.matching.ratio {
        format!("Ratio test {:.2}", params.ratio)
    } else if params.mutual != model.document.matching.mutual {
        "Without the mutual check".to_owned()
    } else {
        format!("Max error {:.1} px", params.max_error_px)
    };
    let price = model.price_of_remedy(&params);
    ui.horizontal_wrapped(|ui| {
        if price.as_ref().is_some_and(|price| price.starts_with("matches")) {
            let response = ui.button("Apply").on_hover_text("Match again so; Undo reverts it");
            named(&response, egui::Role::Button, format!("Apply {change}"));
            queue.push_if(response.clicked(), Action::SetMatching(Box::new(params)));
        }
        ui.add(Label::new(format!("{change}: {}", price.as_deref().unwrap_or("trying it…"))).wrap());
    });
}

fn notes(own: &Feature, unmatched: &Unmatched, sides: &MatchRequest) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(second) = unmatched.candidates.get(1).filter(|second| second.is_same_blob) {
        let why = "is a duplicate: it lies on the same blob as the nearest.";
        notes.push(format!("The second nearest, feature {}, {why}", second.feature));
    }
    if let Some(nearest) = unmatched.candidates.first().map(|best| best.feature)
        && let Some(other) = sides.b.features.get(nearest)
    {
        let apart = (own.slope.u - other.slope.u).hypot(own.slope.v - other.slope.v);
        if apart > SLOPES_APART {
            notes.push(format!("The slope of the nearest, #{nearest}, differs by {apart:.2} px/frame."));
        }
    }
    notes
}

fn candidate_patches_ui(ui: &mut Ui, model: Read<'_>, own: &Feature, unmatched: &Unmatched, sides: &MatchRequest) {
    let width = ((ui.available_width() - 3.0 * 6.0) / (PATCHES + 1) as f32).clamp(40.0, 90.0);
    let candidates = unmatched.candidates.iter().take(PATCHES);
    let others = candidates.filter_map(|c| Some((Side::B, *sides.b.features.get(c.feature)?)));
    let all = std::iter::once((Side::A, *own)).chain(others);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        for (place, (side, feature)) in all.enumerate() {
            let (name, caption) = match place.checked_sub(1) {
                None => ("Patch of the feature".to_owned(), RichText::new("A").weak()),
                Some(candidate) => {
                    let caption = RichText::new(place.to_string()).color(readable(ui, candidate));
                    (format!("Patch of candidate {place}"), caption)
                }
            };
            let display = model.document.ranges_of_side(side).intensity;
            let view = PatchView { name: &name, feature, turned: true, display };
            view.ui(ui, model.stack_at(side, feature.slope), width, caption.small());
        }
    });
}

/// Colour of candidate `place` that is readable on the window's background.
fn readable(ui: &Ui, place: usize) -> Color32 {
    let colour = CANDIDATE_COLOURS[place.min(PATCHES - 1)];
    if ui.visuals().dark_mode { colour } else { colour.lerp_to_gamma(Color32::BLACK, 0.45) }
}

fn candidates_ui(ui: &mut Ui, unmatched: &Unmatched, found: &FoundLosses) {
    Grid::new("candidates").num_columns(5).spacing([8.0, 2.0]).striped(true).show(ui, |ui| {
        let headings = [
            ("B", "Features of B with the nearest descriptors, nearest first, by their rank in strength; = lies on the same blob as the first"),
            ("Dist.", "Euclidean distance of the descriptors"),
            ("Ratio", "Distance over that of the next row"),
            ("Error", "Distance, as both were found, from where the geometry expects it, pixels"),
            ("Slope", "Apparent motion, px/frame"),
        ];
        for (heading, help) in headings {
            ui.label(RichText::new(heading).small().weak()).on_hover_text(help);
        }
        ui.end_row();
        for candidate in &unmatched.candidates {
            for (text, good) in cells(candidate, found.request.request.params.max_error_px) {
                let text = RichText::new(text).monospace();
                let text = if good { text.color(crate::app::style::good(ui)) } else { text };
                ui.add(Label::new(text).selectable(false));
            }
            ui.end_row();
        }
    });
}

fn cells(candidate: &Rivalry, max_error_px: f32) -> [(String, bool); 5] {
    let twin = if candidate.is_same_blob { "=" } else { "" };
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let error = candidate.error_px.map(|e| format!("{} px", number(e, 3)));
    [
        (format!("#{}{twin}", candidate.feature), false),
        (format!("{:.0}", candidate.distance), false),
        (or_dash(candidate.ratio.map(|ratio| format!("{ratio:.2}"))), false),
        (or_dash(error), candidate.error_px.is_some_and(|e| e <= max_error_px)),
        (signed_slope(candidate.slope, 1), false),
    ]
}

fn expected_words(unmatched: &Unmatched, found: &FoundLosses) -> String {
    if found.request.result.verification.as_ref().is_none_or(|v| v.model.is_none()) {
        return "No geometry is known, so its place in B is not either.".to_owned();
    }
    let place = match &unmatched.expected[..] {
        [] => return "The geometry puts it outside B.".to_owned(),
        [[u, v]] => format!("The geometry puts it at {}, {} in B", fixed(*u as f32, 1), fixed(*v as f32, 1)),
        _ => "The geometry puts it on the line drawn in B".to_owned(),
    };
    match unmatched.there.first() {
        None => format!("{place}; no keypoint of its size is there."),
        Some((feature, rank)) => {
            let (count, rank) = (counted(unmatched.there.len(), "keypoint"), rank + 1);
            format!("{place}; {count} of its size there, the nearest #{feature} (rank {rank} by descriptor).")
        }
    }
}
