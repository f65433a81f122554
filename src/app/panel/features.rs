//! Features over the picture: drawing, hovering, selection, and the legend.

use crate::app::canvas::{CanvasOutput, RectTransform, overlay, signed_number};
use crate::app::document::filter::moves_by;
use crate::app::document::{Action, FeaturesShown, MethodId, Pointed, Queue, Side};
use crate::app::panel::against::{RowsInPane, marks_ui};
use crate::app::panel::picture::{PictureState, at_time};
use crate::app::panel::widgets::tip_ui;
use crate::app::panel::{against, display};
use crate::app::results::comparison::Row;
use crate::app::results::{Read, coherence_words, verdict_words};
use crate::app::view::{KnownOfFeature, depth_text, motion_text};
use crate::app::{measure::Tool, pane::PaneId};
use crate::detector::{Detection, Feature, Quantity, Slope};
use crate::inspect::slopes::{at_slope, is_at_slope};
use egui::{Align2, Label, Pos2, RichText, Ui, vec2};

#[derive(Debug, Clone)]
pub struct FeatureLayer {
    pub detection: std::sync::Arc<Detection>,
    /// Features at their places in the picture where that is a frame: at its time.
    in_frame: Option<Vec<Feature>>,
    pub shown: Vec<bool>,
    /// For each feature, whether its motion is another than [`Self::slope`]; empty without a slope.
    elsewhere: Vec<bool>,
    /// Slope by which the picture was shifted; `None` if by none or several, or if other features are not fainter.
    pub slope: Option<Slope>,
    pub selected: Option<usize>,
    pub hovered: Option<usize>,
    /// Whether the features belong to other parameters than the present ones.
    pub stale: bool,
    pub orientations: bool,
    pub motions: bool,
    pub is_listed: bool,
    pub method: Option<MethodId>,
    /// Whether only features at `slope` are drawn, if there is one.
    pub only_slope: bool,
    draws_all: bool,
}

impl FeatureLayer {
    /// Features of pane `id`; `None` while none are drawn. In *Inspect* the table, the filter and the selection are
    /// A's; where two bursts or methods are compared, all features are drawn and none are listed.
    pub fn of(model: Read<'_>, id: PaneId) -> Option<Self> {
        let are_drawn = (model.document.workspace.record().draws_features)(model.document);
        let pane = model.pane(id).filter(|_| are_drawn)?;
        let inspected = model.document.workspace.inspects() && pane.method.is_none();
        let detection = model.detection_in(pane)?.clone();
        let is_listed = inspected && pane.side == Side::A;
        let is_stale = pane.method.is_none() && !model.features_are_current(pane.side);
        let dt = model.frames_from_middle(id, &detection);
        let slope = model.slope_in_picture(id).filter(|_| inspected);
        let near = model.document.filter.near_slope.filter(|_| is_listed);
        let elsewhere = slope.map_or_else(Vec::new, |slope| {
            let (grid, is_at) = (&detection.slopes, at_slope(&detection.slopes, slope));
            let moves = |f: &Feature| near.map_or_else(|| is_at(f), |limit| moves_by(grid, f, slope, limit));
            detection.features.iter().map(|feature| !moves(feature)).collect()
        });
        let shown = if is_listed { model.listed_flags() } else { vec![true; detection.features.len()] };
        let mut layer = Self {
            in_frame: dt.map(|dt| detection.features.iter().map(|f| at_time(f, dt)).collect()),
            shown,
            elsewhere,
            slope,
            selected: model.document.selected.filter(|_| is_listed),
            hovered: model.results.hovered.filter(|_| is_listed),
            stale: is_stale,
            orientations: model.document.look.orientations && inspected,
            motions: model.document.look.motion_vectors
                && (inspected || matches!(pane.method, Some(MethodId::Buff1d | MethodId::Buff2d))),
            is_listed,
            method: pane.method,
            only_slope: model.document.look.overlay == FeaturesShown::ThisSlope,
            draws_all: model.document.look.draws_all && inspected,
            detection,
        };
        if layer.slope.is_some() && layer.only_slope {
            (0..layer.shown.len()).for_each(|index| layer.shown[index] &= !layer.is_faint(index));
        }
        Some(layer)
    }

    pub fn placed(&self) -> &[Feature] {
        self.in_frame.as_deref().unwrap_or(&self.detection.features)
    }

    pub fn scale(&self, model: Read<'_>) -> overlay::ColourScale {
        let (features, grid) = (&self.detection.features, &self.detection.slopes);
        let scale = overlay::ColourScale::of(model.document.colour_by, features, grid);
        scale
            .with_coherences(model.results.coherence.of(&self.detection))
            .with_set_up(model.document.set_up.depths_by())
    }

    /// Features that are drawn in full where `view_image` is in view: the strongest of each part of it, and
    /// those selected or pointed at. Features of other slopes than the picture's take no place from its own.
    pub fn in_full(&self, ui_from_image: RectTransform, view_image: egui::Rect) -> overlay::Drawn {
        let group = |i: usize| {
            self.shown[i].then(|| if self.is_faint(i) { overlay::Group::Faint } else { overlay::Group::Own })
        };
        let always = |i: usize| self.draws_all || self.selected == Some(i) || self.hovered == Some(i);
        overlay::drawn(self.placed(), group, ui_from_image, view_image, always)
    }

    /// The feature at `pos_ui`: one that is drawn in full, otherwise one whose dot lies there.
    fn at(&self, output: &CanvasOutput, in_full: &overlay::Drawn, pos_ui: Pos2) -> Option<usize> {
        let drawn = overlay::feature_at(self.placed(), Some(&in_full.flags), output.ui_from_image, pos_ui);
        drawn.or_else(|| overlay::dot_at(self.placed(), &in_full.dots, output.ui_from_image, pos_ui))
    }

    /// Whether a row of a comparison is drawn: where only this slope is shown, what is at it, by the motion of our
    /// feature or by the row's own slope.
    pub fn draws(&self, row: &Row) -> bool {
        let Some(slope) = self.slope.filter(|_| self.only_slope) else { return true };
        let is_at = |own| is_at_slope(&self.detection.slopes, &Feature { slope: own, ..Feature::default() }, slope);
        let elsewhere = row.feature.and_then(|feature| self.elsewhere.get(feature));
        elsewhere.map_or_else(|| row.slope.is_none_or(is_at), |elsewhere| !elsewhere)
    }

    /// Whether the feature moves by another slope than that of the picture, in which it is blurred then.
    pub fn is_faint(&self, index: usize) -> bool {
        let elsewhere = self.elsewhere.get(index).is_some_and(|elsewhere| *elsewhere);
        elsewhere && self.selected != Some(index) && self.hovered != Some(index)
    }
}

pub fn features_ui(
    ui: &mut Ui,
    model: Read<'_>,
    id: PaneId,
    state: &mut PictureState,
    output: &CanvasOutput,
    has_legend: bool,
    queue: &mut Queue,
) {
    (state.drawn_of, state.pointed) = (None, None);
    let is_probed = id == model.probed_pane_id();
    queue.push_if(is_probed && !model.results.probed.as_dots.is_empty(), Pointed::Dots(Vec::new()));
    let Some(mut layer) = FeatureLayer::of(model, id) else { return };
    let Some(pane) = model.pane(id) else { return };
    let (side, is_of_burst) = (pane.side, model.document.workspace.probes() && pane.method.is_none());
    if let Some(shown) = model.shown_comparison(side).filter(|_| is_of_burst) {
        // The colours now show the comparison's outcome.
        let drawn = shown.rows.iter().map(|row| layer.draws(row)).collect();
        let place = RowsInPane { id, side, shown, drawn };
        marks_ui(ui, model, &place, output, queue);
        if has_legend {
            against::legend_ui(ui, model, &place, output, queue);
        }
        return;
    }
    let scale = state.colour_scale(model, &layer.detection);
    // Candidates lie above features.
    let on_top = layer.is_listed && model.results.explained.pointed.is_none();
    // What is drawn for a mask is drawn past features.
    let can_be_pointed_at = (on_top || layer.method.is_some()) && model.document.measure.tool != Tool::Mask;
    let pointer = output.pointer_ui.filter(|pos| can_be_pointed_at && output.painter.clip_rect().contains(*pos));
    let mut in_full = layer.in_full(output.ui_from_image, output.visible_image);
    if is_probed && layer.method.is_none() {
        let here = model.results.probed.features_here();
        let dots: Vec<usize> = here.into_iter().filter(|feature| in_full.dots.contains(feature)).collect();
        queue.push_if(!dots.is_empty(), Pointed::Dots(dots));
    }
    let pointed = pointer.and_then(|pos| layer.at(output, &in_full, pos));
    if pointer.is_some() {
        layer.hovered = pointed;
        // One that was a dot is drawn in full from now on.
        if let Some(i) = pointed {
            in_full.flags[i] = true;
            in_full.dots.retain(|dot| *dot != i);
        }
        if on_top {
            queue.push(Pointed::Feature(pointed));
            state.pointed = pointed;
        }
    }
    state.drawn_of = Some((in_full.drawn, in_full.in_view));
    draw(&layer, &scale, output, &in_full);
    queue.push_if(on_top && can_be_pointed_at && output.clicked_in_sight(), Action::Select(pointed));
    if let Some(i) = pointed
        && !output.response.dragged()
        && !model.document.playing
        && model.results.patches.loupe.is_none()
    {
        let name = layer.method.map_or_else(|| format!("#{i}"), |method| method.label().to_owned());
        let judged = model.results.coherence.of(&layer.detection).and_then(|values| values.get(i));
        let feature = &layer.placed()[i];
        feature_tip_ui(ui, &name, feature, model.document.set_up.known(feature, judged));
    }
    // Where one slope was searched, as by SIFT on a frame, no colour of a slope means anything.
    let has_meaning = !scale.by.is_of_slope() || layer.detection.slopes.len() > 1;
    if has_legend && has_meaning && !layer.placed().is_empty() {
        let has_faint = layer.slope.is_some() && model.document.look.overlay == FeaturesShown::All;
        let notes = [has_faint.then(|| "Faint: found at other slopes".to_owned()), grey_text(model, &layer, &scale)];
        let notes: Vec<String> = notes.into_iter().flatten().collect();
        let rect_ui = output.response.rect;
        // The colour bar of a map lies in the lower right corner.
        let corner = if model.has_colour_bar(id) { Align2::LEFT_BOTTOM } else { Align2::RIGHT_BOTTOM };
        let key = display::motion_key(model, id, rect_ui);
        let says_the_same = |key: &overlay::ColourScale| scale.has_wheel() && scale.limit_text() == key.limit_text();
        // One is enough where the colours of the picture and of the features mean the same.
        if !(notes.is_empty() && key.as_ref().is_some_and(says_the_same)) {
            // Beside the key of the picture's motions it has to say what it is of.
            let roomy = key.is_some() || rect_ui.height() > 340.0 && rect_ui.width() > 480.0;
            let texts = if roomy { 1 + notes.len() } else { 0 };
            let size = vec2(if scale.has_wheel() { 160.0 } else { 196.0 }, scale.height() + 12.0 + 18.0 * texts as f32);
            display::legend_ui(ui, model, (corner, rect_ui, size), queue, |ui| {
                if roomy {
                    ui.label(RichText::new(scale.name()).small());
                }
                scale.legend_ui(ui);
                for note in notes.iter().filter(|_| roomy) {
                    ui.label(RichText::new(note).small().weak());
                }
            });
        }
    }
}

fn draw(layer: &FeatureLayer, scale: &overlay::ColourScale, output: &CanvasOutput, in_full: &overlay::Drawn) {
    let style = overlay::OverlayStyle {
        shown: Some(&in_full.flags),
        selected: layer.selected,
        hovered: layer.hovered,
        stale: layer.stale,
        orientations: layer.orientations,
        motion: layer.motions,
        ..overlay::OverlayStyle::new(scale, &layer.detection.positions)
    };
    overlay::draw_dots(output, layer.placed(), &style, &in_full.dots);
    if layer.in_frame.is_some() {
        // The motion over the whole burst stays; the circles move along it.
        let ways = overlay::OverlayStyle { circles: false, orientations: false, ..style };
        overlay::draw_features(output, &layer.detection.features, &ways);
        overlay::draw_features(output, layer.placed(), &overlay::OverlayStyle { motion: false, ..style });
        return;
    }
    if layer.elsewhere.is_empty() {
        return overlay::draw_features(output, layer.placed(), &style);
    }
    let flags = |faint: bool| -> Vec<bool> {
        in_full.flags.iter().enumerate().map(|(i, shown)| *shown && layer.is_faint(i) == faint).collect()
    };
    let (faint, full) = (flags(true), flags(false));
    let plain = overlay::OverlayStyle { orientations: false, motion: false, selected: None, hovered: None, ..style };
    let below = overlay::OverlayStyle { shown: Some(&faint), stale: true, ..plain };
    overlay::draw_features(output, layer.placed(), &below);
    overlay::draw_features(output, layer.placed(), &overlay::OverlayStyle { shown: Some(&full), ..style });
}

fn feature_tip_ui(ui: &Ui, name: &str, f: &Feature, known: KnownOfFeature<'_>) {
    let KnownOfFeature { judged, depth_m } = known;
    let depth = depth_m.map_or_else(String::new, |depth| format!("  depth {}", depth_text(depth)));
    let coherence = judged.map_or_else(String::new, |j| format!("\ncoherence {}", coherence_words(j.coherence)));
    let layer = if f.layer > 0 { format!(", layer {}", f.layer) } else { String::new() };
    let field = f.known_field().map(|field| format!("\nfield {}", motion_text(field, f.field_sigma, 2)));
    let field = field.unwrap_or_default();
    let (slope, response) = (motion_text(f.slope, f.slope_sigma, 2), signed_number(f.response, 3));
    let text = format!("{name}  σ {:.2} px{depth}\n{}{layer}\nslope {slope}{field}\n", f.sigma, f.moves.words())
        + &format!("response {response}  SNR {:.1}{coherence}", f.snr);
    tip_ui(ui, "feature tip", |ui| {
        ui.label(RichText::new(text).monospace());
        if let Some(judged) = judged {
            ui.set_max_width(TIP_WIDTH);
            ui.add(Label::new(verdict_words(Some(f), judged)).wrap());
        }
    });
}

/// Width of the sentence in a feature's tip, points.
const TIP_WIDTH: f32 = 320.0;

fn grey_text(model: Read<'_>, layer: &FeatureLayer, scale: &overlay::ColourScale) -> Option<String> {
    use Quantity::{Depth, FieldSigma, FieldU, FieldV, Layer};
    let (coherence, detection) = (&model.results.coherence, &layer.detection);
    let why = match (scale.by.quantity(), coherence.of(detection), coherence.failure_of(detection)) {
        (Some(Depth), ..) => "Slopes, Slopes from the set-up gives depths",
        (Some(Layer), ..) => "in no layer",
        (Some(FieldU | FieldV | FieldSigma), ..) => "motion of the place unknown",
        (_, Some(_), _) => "too noisy to tell",
        (_, None, Some(why)) => &why.to_string(),
        (_, None, None) if layer.method.is_some() => "not computed for methods; see One burst",
        (_, None, None) => match coherence.running().and_then(|running| running.progress) {
            Some(progress) => &format!("being computed, {:.0} %", 100.0 * progress.fraction),
            None => "not computed yet",
        },
    };
    scale.has_unknown().then(|| format!("Grey: {why}"))
}
