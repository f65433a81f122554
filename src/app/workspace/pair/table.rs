//! Tables of two bursts: the matches, and where the other features of A were lost; and the numbers of the pair.

use crate::app::actions::Queue;
use crate::app::document::{Action, MatchColumn, PairTab, Side};
use crate::app::inspector::match_menu_ui;
use crate::app::panel::table::{Heading, Listed, SortedColumn, rows_ui, sorted_table_ui, texts};
use crate::app::panel::widgets::{named, only_ui, progress_text, text_width};
use crate::app::results::{Matches, PAIR_NUMBERS, Read, lost_words};
use crate::app::view::{fixed, signed_slope};
use crate::inspect::pair::Lost;
use crate::matching::Geometry;
use egui::{Label, RichText, Ui};

impl SortedColumn for MatchColumn {
    fn look(self) -> Heading {
        let term = match self {
            Self::Number | Self::UA | Self::VA | Self::UB | Self::VB => None,
            Self::SigmaA | Self::SigmaB => Some("scale"),
            Self::SlopeA | Self::SlopeB | Self::Motion => Some("slope"),
            Self::Distance => Some("descriptor"),
            Self::Ratio => Some("ratio-test"),
            Self::Error => Some("epipolar-line"),
            Self::Inlier => Some("inlier"),
        };
        let (width, [text, help]) = (if self == Self::Number { 36.0 } else { 47.0 }, self.words());
        Heading { text, help, term, width, ..Heading::default() }
    }
}

pub fn table_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) -> Option<usize> {
    let pair = &model.results.pair;
    let matches = pair.matches.as_ref()?;
    let listed = Listed { items: &pair.listed, selected: model.document.selected_match, hovered: pair.hovered };
    let text = |column: MatchColumn, index: usize| matches.row(index).map_or_else(String::new, |row| column.text(&row));
    let menu = |ui: &mut Ui, index| matches.row(index).into_iter().for_each(|row| match_menu_ui(ui, &row, queue));
    let name = |index: usize| format!("Match {index}");
    let pointed = sorted_table_ui(ui, &MatchColumn::ALL, model.document.match_order, &listed, text, name, menu);
    queue.edit(model.document, Action::SetMatchOrder(pointed.order));
    queue.set(&model.document.selected_match, pointed.selected, Action::SelectMatch);
    pointed.hovered
}

/// Draws the tabs, of which the open one closes the panel and any other opens it, and the numbers of the pair.
pub fn tabs_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let row = |ui: &mut Ui| {
        (ui.spacing_mut().button_padding.x, ui.spacing_mut().item_spacing.x) = (6.0, 3.0);
        let is_compared = model.document.comparisons.both().into_iter().any(|set| set.with.is_some());
        for tab in PairTab::ALL {
            let ([name, help], is_open) = (tab.words(), model.document.pair_tab == tab && model.shows_bottom());
            let is_there = tab != PairTab::Compared || is_compared || is_open;
            let is_clicked = is_there && ui.selectable_label(is_open, name).on_hover_text(help).clicked();
            queue.push_if(is_clicked, Action::SetPairTab(tab));
        }
        ui.separator();
        numbers_ui(ui, model);
    };
    // Only above the table is there room for a second line: the pictures stay where they are.
    let _ = if model.shows_bottom() { ui.horizontal_wrapped(row) } else { ui.horizontal(row) };
}

/// Draws the steps at which features of A were lost, each with its count and its switch.
pub fn steps_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    ui.horizontal_wrapped(|ui| {
        if let Some(running) = &model.results.pair.lost.wanted.running {
            ui.weak(progress_text(running));
            return;
        }
        if model.losses().is_none() {
            return;
        }
        ui.label(RichText::new("Lost to").small().weak());
        for lost in Lost::ALL.into_iter().filter(|lost| *lost != Lost::Not) {
            let [label, help] = lost_words(lost);
            let text = format!("{label} {}", model.results.pair.lost.count(lost));
            let mut on = !model.document.hidden_losses.contains(&lost);
            queue.push_if(ui.checkbox(&mut on, text).on_hover_text(help).changed(), Action::ShowLost(lost, on));
        }
    });
}

/// Headings of the features without a match, and their widths, points.
const LOST_COLUMNS: [(&str, f32); 7] =
    [("#", 50.0), ("Lost to", 120.0), ("u", 60.0), ("v", 60.0), ("σ", 50.0), ("Slope", 100.0), ("SNR", 0.0)];

pub fn lost_table_ui(ui: &mut Ui, model: Read<'_>, queue: &mut Queue) {
    let Some(found) = model.losses() else { return only_ui(ui, "There are no matches yet.") };
    let hidden = &model.document.hidden_losses;
    let is_listed = |(index, lost): &(usize, &Lost)| {
        **lost != Lost::Not && !hidden.contains(lost) && model.results.pair.lost.twin(*index).is_none()
    };
    let items: Vec<usize> = found.lost.iter().enumerate().filter(is_listed).map(|(index, _)| index).collect();
    let listed = Listed { items: &items, selected: model.asked_feature(), hovered: None };
    let text = |column: usize, index: usize| {
        let f = &found.request.request.a.features[index];
        match column {
            0 if model.results.pair.lost.others(index) == 0 => index.to_string(),
            0 => format!("{index} +{}", model.results.pair.lost.others(index)),
            1 => lost_words(found.lost[index])[0].to_owned(),
            2 => fixed(f.u, 1),
            3 => fixed(f.v, 1),
            4 => format!("{:.2}", f.sigma),
            5 => signed_slope(f.slope, 2),
            _ => format!("{:.1}", f.snr),
        }
    };
    let heading = |(text, width)| Heading { text, width, is_exact: text != "SNR", is_left: true, ..Heading::default() };
    let (headings, name) = (LOST_COLUMNS.map(heading), |index| format!("Unmatched feature {index}"));
    rows_ui(ui, &headings, None, &listed, texts(&headings, text), name, |row, index| {
        queue.push_if(row.clicked(), Action::AskFeature(Some(index)));
    });
}

const NAME_GAP: f32 = 4.0;

fn numbers_ui(ui: &mut Ui, model: Read<'_>) {
    let Some(matches) = &model.results.pair.matches else {
        ui.add(Label::new(RichText::new(missing(model)).weak()).truncate());
        return;
    };
    ui.spacing_mut().item_spacing.x = 10.0;
    let counts = &matches.result.counts;
    let keypoints = format!("{} + {}", counts.keypoints_a, counts.keypoints_b);
    let numbers = PAIR_NUMBERS.map(|(name, help, of)| (name, help, of.text(counts)));
    for (name, help, value) in [("Keypoints", "Features of A and of B", keypoints)].into_iter().chain(numbers) {
        let text = format!("{name} {value}");
        let (name, value) = (RichText::new(name).small().weak(), RichText::new(value).strong().monospace());
        // A number that the line would cut stands on the next one.
        let width = text_width(ui, name.clone()) + NAME_GAP + text_width(ui, value.clone());
        if model.shows_bottom() && ui.available_size_before_wrap().x < width {
            ui.end_row();
        }
        let number_ui = |ui: &mut Ui| {
            ui.spacing_mut().item_spacing.x = NAME_GAP;
            ui.add(Label::new(name).selectable(false));
            ui.add(Label::new(value));
        };
        let response = ui.horizontal(number_ui).response;
        named(&response, egui::Role::Label, text);
        response.on_hover_text(help);
    }
    if let Some(problem) = model.stale_matches().map(str::to_owned).or_else(|| without_geometry(matches)) {
        ui.add(Label::new(RichText::new(problem).color(crate::app::style::warning(ui))).truncate());
        return;
    }
    let (drawn, lines) = model.results.pair.lines_drawn;
    if drawn < lines {
        let tip = "Inliers first: a few for each part of A's picture (zoom in for more), or as many as At most says";
        ui.add(Label::new(RichText::new(format!("{drawn} of {lines} drawn")).weak()).truncate()).on_hover_text(tip);
    }
}

fn without_geometry(matches: &Matches) -> Option<String> {
    let params = &matches.request.params;
    (params.geometry != Geometry::None && matches.model().is_none()).then(|| match matches.result.counts.refused {
        Some(reason) => format!("Refused: {}", reason.words()),
        None => format!("No geometry: fewer than {} matches agree on one", params.min_inliers),
    })
}

fn missing(model: Read<'_>) -> String {
    let without = Side::BOTH.into_iter().filter(|side| model.found_of(*side).is_none());
    let without = without.map(Side::name).collect::<Vec<_>>().join(" and ");
    match &model.results.pair.param_error {
        _ if model.burst_of(Side::B).is_none() => "Open a second burst to match it with the first".to_owned(),
        Some(error) => format!("No matches: {error}"),
        None if model.results.pair.matching.is_pending() => "Matching…".to_owned(),
        None if model.results.slots.both().iter().any(|slot| slot.detecting.is_pending()) => "Detecting…".to_owned(),
        None if without.is_empty() => "No matches yet".to_owned(),
        None => format!("No features yet in {without}: press Detect"),
    }
}
