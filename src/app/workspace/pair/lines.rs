//! Lines of the matches between panes of A and of B, and the marks of an unmatched feature and its candidates.

use crate::app::canvas::overlay::{CircleMark, MatchLine, MatchLineStyle, Pane, draw_circles};
use crate::app::canvas::{CanvasOutput, overlay};
use crate::app::document::{Action, MatchesAs, MethodId, Pointed, Queue, Side};
use crate::app::inspector::{Drawn, chip_ui, is_with_shift, joined_panes, side_of};
use crate::app::results::{MatchRow, Matches, PATCHES, Read};
use crate::app::{pane::PaneId, panel::picture::at_time, panel::widgets::tip_ui};
use crate::burst::Offset;
use crate::detector::Feature;
use crate::export::MatchKind;
use egui::{Align2, Color32, Painter, Pos2, Rect, RichText, Stroke, Ui, pos2, vec2};

/// Colours of candidates in B, from the nearest descriptor on.
pub(super) const CANDIDATE_COLOURS: [Color32; PATCHES] =
    [Color32::from_rgb(0xff, 0xd2, 0x4a), Color32::from_rgb(0xff, 0x8a, 0x3d), Color32::from_rgb(0xff, 0x6b, 0xb5)];

/// Colour of a difference of motions that is this part of the largest one: also colour-blind people see the ends apart.
pub(super) fn motion_colour(part: f32) -> Color32 {
    overlay::rgb(MatchKind::Inlier.color()).lerp_to_gamma(Color32::from_rgb(230, 60, 170), part.clamp(0.0, 1.0))
}

/// Draws the matches over the drawn panes of A and B and lets the pointer choose among them. Returns the hovered match;
/// the outer `None` while the pointer is over no picture.
pub fn lines_ui(ui: &Ui, model: Read<'_>, drawn: &[Drawn], queue: &mut Queue) -> Option<Option<usize>> {
    let views = MatchViews::of(model, drawn, None);
    let pointer = views.pointed();
    let Some(matches) = &model.results.pair.matches else {
        return pointer.map(|_| None);
    };
    let look = model.document.match_look;
    let are_vectors = look.drawn_as == MatchesAs::Vectors;
    let largest = look.by_motion.then(|| model.largest_motion().max(f32::MIN_POSITIVE));
    let rows: Vec<MatchRow<'_>> = model.drawn_matches().into_iter().filter_map(|index| matches.row(index)).collect();
    let lines_on = |canvases: Canvases| {
        let lines = rows.iter().map(|row| line_of(row, canvases.shifts, largest));
        let is_on = |line: &MatchLine| {
            let is_near = || pointer.is_some_and(|(_, pos)| line.is_near(&canvases.panes, pos));
            let is_marked = [model.document.selected_match, model.results.pair.hovered].contains(&Some(line.index));
            look.drawn_as != MatchesAs::Near || is_marked || is_near()
        };
        let lines = lines.filter(is_on).collect();
        (canvases, lines)
    };
    let lines: Vec<(Canvases, Vec<MatchLine>)> = views.canvases(are_vectors).into_iter().map(lines_on).collect();
    let at = |pos| lines.iter().rev().find_map(|(canvases, lines)| overlay::match_at(lines, &canvases.panes, pos));
    let pointed = pointer.and_then(|(_, pos)| at(pos));
    let dragged = views.views.iter().any(|view| view.output.response.dragged());
    let hovered = if pointer.is_some() { pointed } else { model.results.pair.hovered };
    let focus = model.document.selected_match.or(hovered);
    if look.geometry
        && let Some(row) = focus.and_then(|index| matches.row(index))
    {
        locus_ui(model, matches, &row, &views);
    }
    let (opacity, selected, others_faint) = (MatchKind::OPACITY, model.document.selected_match, focus.is_some());
    let style = MatchLineStyle { opacity, selected, hovered, others_faint, are_vectors };
    let always = |index| [model.document.selected_match, hovered].contains(&Some(index));
    // An unmatched feature that is asked about stands alone.
    let lines: Vec<_> = if model.document.asked_about.is_some() { Vec::new() } else { lines };
    let mut numbers = (0, 0);
    for (canvases, lines) in &lines {
        let drawn = overlay::drawn_lines(lines, &canvases.panes[0], (are_vectors, look.most), always);
        overlay::draw_match_lines(&painter_over(ui, &views, canvases), &canvases.panes, &drawn, &style);
        numbers = (numbers.0 + drawn.len(), numbers.1 + lines.len());
    }
    queue.set(&model.results.pair.lines_drawn, numbers, |(drawn, all)| Action::Point(Pointed::Lines(drawn, all)));
    if let Some(row) = focus.and_then(|index| matches.row(index)) {
        for view in &views.views {
            let feature = if view.side == Side::A { row.a } else { row.b };
            circle_ui(model, matches, view.side, at_time(feature, view.shift), view.output);
        }
    }
    // A click with Shift probes the place, and selects nothing.
    let selects = |view: &&MatchView<'_>| view.output.response.clicked() && !is_with_shift(ui);
    for view in views.views.iter().filter(selects) {
        // Where there is no line, a click on a feature of A asks why it has no match.
        let pos = view.output.response.interact_pointer_pos().filter(|_| view.side == Side::A);
        queue.push(match pointed {
            Some(_) => Action::SelectMatch(pointed),
            None => Action::AskFeature(pos.and_then(|pos| {
                let placed = matches.detection(Side::A).features.iter().map(|f| at_time(f, view.shift));
                overlay::feature_at(&placed.collect::<Vec<_>>(), None, view.output.ui_from_image, pos)
            })),
        });
    }
    unmatched_marks_ui(model, &views);
    if let Some(row) = pointed.filter(|_| !dragged).and_then(|index| matches.row(index)) {
        match_tip_ui(ui, &row, matches.passed_limit(&row));
    }
    pointer.map(|_| pointed)
}

pub(in crate::app::workspace) fn painter_over(ui: &Ui, views: &MatchViews<'_>, canvases: &Canvases) -> Painter {
    let rects = canvases.places.iter().flatten().map(|place| views.views[*place].output.response.rect);
    ui.painter_at(rects.fold(egui::Rect::NOTHING, egui::Rect::union))
}

/// `shifts` are positions from mid-burst. The colour is that of its kind, or of how far motions differ of `largest`.
pub fn line_of(row: &MatchRow<'_>, shifts: [Offset<f32>; 2], largest: Option<f32>) -> MatchLine {
    let kind = MatchKind::of(row.inlier);
    let colour = largest.map_or(overlay::rgb(kind.color()), |largest| motion_colour(row.motion_apart() / largest));
    let [a, b] = [at_time(row.a, shifts[0]), at_time(row.b, shifts[1])].map(|f| pos2(f.u, f.v));
    MatchLine { index: row.index, a, b, kind, colour }
}

fn circle_ui(model: Read<'_>, matches: &Matches, side: Side, feature: Feature, output: &CanvasOutput) {
    let detection = matches.detection(side);
    let coherence = model.found_of(side).and_then(|found| {
        // Its position is that at another time.
        let same = |f: &Feature| Feature { u: feature.u, v: feature.v, ..*f } == feature;
        let index = found.detection.features.iter().position(same)?;
        model.results.coherence.of(&found.detection)?.get(index).cloned()
    });
    let scale = overlay::ColourScale::of(model.document.colour_by, &detection.features, &detection.slopes)
        .with_coherences(coherence.map(|value| std::sync::Arc::new(vec![value])).as_ref())
        .with_set_up(model.document.set_up.depths_by());
    let style = overlay::OverlayStyle {
        selected: Some(0),
        motion: model.document.look.motion_vectors,
        ..overlay::OverlayStyle::new(&scale, &detection.positions)
    };
    overlay::draw_features(output, &[feature], &style);
}

fn locus_ui(model: Read<'_>, matches: &Matches, row: &MatchRow<'_>, views: &MatchViews<'_>) {
    let Some(geometry) = matches.model() else { return };
    let place = |f: &Feature| [f64::from(f.u), f64::from(f.v)];
    for MatchView { side, output, .. } in &views.views {
        let Some(size) = model.burst_of(*side).map(|open| open.burst.size()) else { continue };
        let locus = match side {
            Side::A => geometry.locus(0, place(row.b), size),
            Side::B => geometry.locus(1, place(row.a), size),
        };
        expected_ui(output, &points_ui(output, &locus));
        let expected = matches.result.prediction.as_ref().filter(|_| *side == Side::B);
        if let Some(expected) = expected.and_then(|prediction| prediction.in_b[row.found.a]) {
            expected_ui(output, &points_ui(output, &expected.outline(geometry)));
        }
    }
}

fn points_ui(output: &CanvasOutput, places: &[[f64; 2]]) -> Vec<Pos2> {
    places.iter().map(|place| output.ui_from_image.pos(pos2(place[0] as f32, place[1] as f32))).collect()
}

fn match_tip_ui(ui: &Ui, row: &MatchRow<'_>, passed_limit: Option<String>) {
    let verdict = match row.inlier {
        Some(true) => "  inlier",
        Some(false) => "  outlier",
        None => "",
    };
    let error = row.error_px.map_or_else(String::new, |_| format!("\nerror {}", row.error_words()));
    let [a, b] = [row.a, row.b].map(|feature| crate::app::view::signed_slope(feature.slope, 2));
    let limit = passed_limit.map_or_else(String::new, |limit| format!("\n{limit}"));
    let (index, how, distance) = (row.index, row.how_words(), row.found.distance);
    let text = format!("Match {index}{verdict}\n{how}  distance {distance:.1}{error}\n")
        + &format!("slopes ({a}) and ({b}) px/frame{limit}");
    tip_ui(ui, "match tip", |ui| _ = ui.label(RichText::new(text).monospace()));
}

/// Draws the matches of each method between its panes of A and of B, with a count.
pub(in crate::app::workspace) fn method_lines_ui(ui: &Ui, model: Read<'_>, drawn: &[Drawn]) {
    let look = &model.document.match_look;
    let style = MatchLineStyle { opacity: MatchKind::OPACITY, ..MatchLineStyle::default() };
    for method in MethodId::ALL {
        let Some(matches) = model.method_matches(method) else { continue };
        let views = MatchViews::of(model, drawn, Some(method));
        for canvases in views.canvases(false).iter().filter(|canvases| canvases.places.iter().all(Option::is_some)) {
            let rows = matches.rows().filter(|row| row.is_shown(look));
            let lines: Vec<MatchLine> = rows.map(|row| line_of(&row, canvases.shifts, None)).collect();
            let most = model.most_lines(Some(method));
            let lines = overlay::drawn_lines(&lines, &canvases.panes[0], (false, most), |_| false);
            overlay::draw_match_lines(&painter_over(ui, &views, canvases), &canvases.panes, &lines, &style);
            let counts = matches.result.counts;
            let text = match counts.inliers {
                Some(inliers) => format!("{inliers} of {} matches are inliers", counts.putative),
                None => crate::inspect::words::counted(counts.putative, "match"),
            };
            if let [_, Some(b)] = canvases.places {
                chip_ui(ui, views.views[b].output, Align2::RIGHT_BOTTOM, &text, (method, "matches", canvases.places));
            }
        }
    }
}

pub struct MatchView<'a> {
    pub side: Side,
    pub output: &'a CanvasOutput,
    /// Time of its picture, frames after mid-burst; 0 if it shows no frame.
    pub shift: Offset<f32>,
}

/// Panes of one method, or of none where no methods are compared.
pub struct MatchViews<'a> {
    pub views: Vec<MatchView<'a>>,
    /// Pairs between which lines go: indices of a pane of A and of one of B.
    pub pairs: Vec<(usize, usize)>,
}

impl<'a> MatchViews<'a> {
    pub fn of(model: Read<'_>, drawn: &'a [Drawn], method: Option<MethodId>) -> Self {
        let places: Vec<_> = drawn.iter().map(|drawn| (drawn.shown, drawn.output.response.rect)).collect();
        let shift = |id: PaneId| model.frames_from_middle(id, model.detection_in(model.pane(id)?)?);
        let view = |(place, drawn): (usize, &'a Drawn)| {
            let (side, shift) = (side_of(model, drawn.shown, method)?, shift(drawn.shown).unwrap_or_default());
            Some((place, MatchView { side, output: &drawn.output, shift }))
        };
        let (of_drawn, views): (Vec<usize>, Vec<_>) = drawn.iter().enumerate().filter_map(view).unzip();
        let place = |of: usize| of_drawn.iter().position(|place| *place == of);
        let pairs = joined_panes(model, &places, method).into_iter();
        Self { views, pairs: pairs.filter_map(|(a, b)| Some((place(a)?, place(b)?))).collect() }
    }

    pub fn on(&self, side: Side) -> impl Iterator<Item = &MatchView<'a>> {
        self.views.iter().filter(move |view| view.side == side)
    }

    /// Index of the pane under the pointer, and the pointer's position, in points.
    pub fn pointed(&self) -> Option<(usize, Pos2)> {
        self.views.iter().enumerate().find_map(|(place, view)| Some((place, view.output.pointer_ui?)))
    }

    /// Canvases of each pair, A's first; for vectors each of A with itself. A pane without a partner is paired with an
    /// empty rectangle, so that the ends of its matches are marked. The pair under the pointer comes last.
    pub fn canvases(&self, are_vectors: bool) -> Vec<Canvases> {
        let canvases = |there: usize, places: [Option<usize>; 2]| {
            let pane = |place: Option<usize>| {
                let output = self.views[place.unwrap_or(there)].output;
                let rect_ui = if place.is_some() || are_vectors { output.response.rect } else { Rect::NOTHING };
                Pane { ui_from_image: output.ui_from_image, rect_ui }
            };
            let shifts = places.map(|place| self.views[place.unwrap_or(there)].shift);
            Canvases { panes: places.map(pane), shifts, places }
        };
        let is_paired = |place: usize| self.pairs.iter().any(|(a, b)| [*a, *b].contains(&place));
        let is_alone =
            |place: &usize| if are_vectors { self.views[*place].side == Side::A } else { !is_paired(*place) };
        let paired = self.pairs.iter().filter(|_| !are_vectors).map(|&(a, b)| canvases(a, [Some(a), Some(b)]));
        let alone = (0..self.views.len()).filter(is_alone).map(|place| match self.views[place].side {
            Side::A => canvases(place, [Some(place), None]),
            Side::B => canvases(place, [None, Some(place)]),
        });
        let mut all: Vec<Canvases> = paired.chain(alone).collect();
        let pointed = self.pointed().map(|(place, _)| place);
        all.sort_by_key(|canvases| pointed.is_some() && canvases.places.contains(&pointed));
        all
    }
}

pub struct Canvases {
    pub panes: [Pane; 2],
    /// Times of their pictures, frames after mid-burst.
    pub shifts: [Offset<f32>; 2],
    /// Indices of the views; `None` for a missing partner.
    pub places: [Option<usize>; 2],
}

fn unmatched_marks_ui(model: Read<'_>, views: &MatchViews<'_>) {
    let Some((why, found)) = model.results.pair.lost.why.as_ref().zip(model.losses()) else { return };
    // A selected match draws its own circles.
    if model.document.selected_match.is_some() {
        return;
    }
    let sides = &found.request.request;
    let Some(own) = sides.a.features.get(why.feature) else { return };
    let mark = |f: &Feature, colour: Color32, dashed: bool| {
        let (pos_image, sigma) = (pos2(f.u, f.v), f.sigma);
        CircleMark { pos_image, sigma, from_image: None, colour, dashed }
    };
    for view in views.on(Side::A) {
        draw_circles(view.output, &[mark(own, Color32::WHITE, false)], Some(0));
    }
    let candidates = why.unmatched.candidates.iter().zip(CANDIDATE_COLOURS);
    let marks: Vec<CircleMark> =
        candidates.filter_map(|(c, colour)| Some(mark(sides.b.features.get(c.feature)?, colour, true))).collect();
    for view in views.on(Side::B) {
        draw_circles(view.output, &marks, None);
        for places in [&why.unmatched.expected, &why.unmatched.predicted] {
            expected_ui(view.output, &points_ui(view.output, places));
        }
    }
}

/// Marks where the geometry expects a feature: a line or, by a homography, a point, drawn as a cross.
fn expected_ui(output: &CanvasOutput, points: &[egui::Pos2]) {
    let painter = output.painter.with_clip_rect(output.response.rect);
    for (width, colour) in [(3.0, Color32::from_black_alpha(130)), (1.2, Color32::from_white_alpha(210))] {
        let stroke = Stroke::new(width, colour);
        match points {
            [] => {}
            [one] => {
                for diagonal in [vec2(6.0, 6.0), vec2(6.0, -6.0)] {
                    painter.line_segment([*one - diagonal, *one + diagonal], stroke);
                }
            }
            _ => _ = painter.line(points.to_vec(), stroke),
        }
    }
}
