//! Colours of features, and their legend. All features get their colours here.

use crate::app::panel::widgets::{named, small_text, strip_of_colours};
use crate::app::view::{ColourBy, KnownOfFeature, number, quantity_value};
use crate::detector::quantity::{Colours, Span};
use crate::detector::{Feature, Moves, Quantity, Slope, SlopeGrid};
use crate::inspect::{place::Judged, slopes::SetUp};
use crate::plane::display::direction_colour;
use crate::requests::line_of;
use egui::{Align2, Color32, Label, Rect, Response, RichText, Sense, Shape, Stroke, StrokeKind, Ui, Vec2, pos2, vec2};
use std::sync::Arc;

/// The range stays until the next detection, so that a colour keeps its meaning.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourScale {
    pub by: ColourBy,
    /// Value of the first colour, in the quantity's unit; unused (0) for the directions of a plane of slopes.
    pub min: f32,
    /// Value of the last colour; the magnitude of full saturation for the directions of a plane of slopes.
    pub max: f32,
    /// Direction of slopes on a line, degrees from +u towards +v: colours then run along the line, not around a wheel.
    pub line_deg: Option<f32>,
    table: Vec<Color32>,
    coherences: Option<Arc<Vec<Judged>>>,
    set_up: Option<SetUp>,
    lacks_some: bool,
}

pub const UNKNOWN: Color32 = Color32::from_gray(150);

impl ColourScale {
    /// Over the searched range for slopes on a line, over all features for σ and SNR, ± the largest |response|.
    pub fn of(by: ColourBy, features: &[Feature], grid: &SlopeGrid) -> Self {
        if by == ColourBy::SlopeDirection && line_of(grid, features).is_some() {
            return Self::of_slopes(grid, features);
        }
        let stored = |f: &Feature| by.quantity().and_then(|by| quantity_value(by, 0, f, KnownOfFeature::default()));
        let of = |value: &dyn Fn(&Feature) -> Option<f32>| {
            let values = features.iter().filter_map(value).filter(|x| x.is_finite());
            values.map(|x| (x, x)).reduce(|(low, high), (x, _)| (low.min(x), high.max(x)))
        };
        let (min, max) = match (by.quantity(), by.colours().span) {
            (None, _) => (0.0, of(&|f| Some(f.motion().0.magnitude())).map_or(1.0, |range| range.1)),
            (_, Span::Always(min, max)) => (min, max),
            (_, Span::Found(min, max)) => of(&stored).unwrap_or((min, max)),
            (_, Span::Around(limit)) => {
                let limit = of(&|f| stored(f).map(f32::abs)).map_or(limit, |range| range.1);
                (-limit, limit)
            }
        };
        // Features without the quantity are grey, which the legend has to explain.
        let lacks_some = by.quantity().is_some_and(|quantity| features.iter().any(|f| quantity.is_empty(f)));
        Self { lacks_some, ..Self::with_range(by, min, max) }
    }

    /// The slopes of `grid`, by direction and length; where they or those of `features` lie on a line, along it.
    pub fn of_slopes(grid: &SlopeGrid, features: &[Feature]) -> Self {
        let Some((line_deg, axis)) = line_of(grid, features) else {
            return Self::with_range(ColourBy::SlopeDirection, 0.0, grid.max_magnitude());
        };
        let along = Self::with_range(ColourBy::Of(Quantity::SlopeU), axis.min, axis.max);
        Self { by: ColourBy::SlopeDirection, line_deg: Some(line_deg), ..along }
    }

    /// Creates a scale over a given range; an empty range is widened.
    pub fn with_range(by: ColourBy, min: f32, max: f32) -> Self {
        let Colours { map, part: [first, last], is_log, .. } = by.colours();
        let (min, max) = match by {
            // A logarithm needs positive ends, and more than one value between them.
            _ if is_log => (min.max(1e-3), max.max(min.max(1e-3) * 1.01)),
            ColourBy::SlopeDirection => (0.0, if max > 0.0 { max } else { 1.0 }),
            // A single slope gets half a pixel per frame to each side, so that its colour lies mid-scale.
            ColourBy::Of(_) if max <= min && by.unit() == "px/frame" => (min - 0.5, min + 0.5),
            _ => (min, if max > min { max } else { min + 1e-6 }),
        };
        let (lut, t) = (map.lut(), |i: u8| first + (last - first) * f32::from(i) / 255.0);
        let table = (0..=255).map(|i| rgb(lut[(t(i) * 255.0).round() as usize])).collect();
        Self { by, min, max, line_deg: None, table, coherences: None, set_up: None, lacks_some: false }
    }

    pub fn name(&self) -> String {
        match self.line_deg {
            Some(0.0) => ColourBy::Of(Quantity::SlopeU).name().to_owned(),
            Some(90.0) => ColourBy::Of(Quantity::SlopeV).name().to_owned(),
            Some(degrees) => format!("Slope along {degrees:.0}°"),
            None => self.by.name().to_owned(),
        }
    }

    /// In the order of the features. Without them all features are grey when their colour shows the coherence.
    #[must_use]
    pub fn with_coherences(self, coherences: Option<&Arc<Vec<Judged>>>) -> Self {
        Self { coherences: coherences.cloned(), ..self }
    }

    /// The colours then span its depths. Without it all features are grey when their colour shows the depth.
    #[must_use]
    pub fn with_set_up(self, set_up: Option<&SetUp>) -> Self {
        let Some(set_up) = set_up.filter(|_| self.by == ColourBy::Of(Quantity::Depth)) else { return self };
        let [near, far] = set_up.depth_m.map(|metres| metres as f32);
        Self { set_up: Some(*set_up), ..Self::with_range(self.by, near, far) }
    }

    pub fn has_unknown(&self) -> bool {
        let is_unknown = |values: &Arc<Vec<Judged>>| values.iter().any(|judged| judged.coherence.is_none());
        match self.by {
            ColourBy::Of(Quantity::Coherence) => self.coherences.as_ref().is_none_or(is_unknown),
            ColourBy::Of(Quantity::Depth) => self.set_up.is_none(),
            _ => self.lacks_some,
        }
    }

    pub fn colour(&self, index: usize, feature: &Feature) -> Color32 {
        let (motion, sigma) = feature.motion();
        let Some(quantity) = self.by.quantity() else { return self.of_slope(motion) };
        let judged = self.coherences.as_ref().and_then(|values| values.get(index));
        let depth_m = self.set_up.as_ref().and_then(|set_up| set_up.depth_with_error(motion, sigma));
        let value = quantity_value(quantity, index, feature, KnownOfFeature { judged, depth_m });
        value.filter(|value| value.is_finite()).map_or(UNKNOWN, |value| self.along(value))
    }

    pub fn of_slope(&self, slope: Slope) -> Color32 {
        if self.by == ColourBy::Speed {
            return self.along(slope.magnitude());
        }
        let Some(degrees) = self.line_deg else {
            return rgb(direction_colour(slope.v.atan2(slope.u), slope.magnitude() / self.max));
        };
        let (sin, cos) = degrees.to_radians().sin_cos();
        self.along(cos * slope.u + sin * slope.v)
    }

    pub fn along(&self, value: f32) -> Color32 {
        let t = if self.by.colours().is_log {
            (value.max(1e-6) / self.min).ln() / (self.max / self.min).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        };
        self.table[(t.clamp(0.0, 1.0) * 255.0).round() as usize]
    }

    pub fn has_wheel(&self) -> bool {
        self.by == ColourBy::SlopeDirection && self.line_deg.is_none()
    }

    /// Length of the slopes on the rim of the wheel.
    pub fn limit_text(&self) -> String {
        format!("{} px/frame", number(self.max, 3))
    }

    pub fn legend_ui(&self, ui: &mut Ui) -> Response {
        let response = match self.by {
            ColourBy::Of(Quantity::Moves) => self.words_ui(ui),
            _ if self.has_wheel() => self.wheel_ui(ui),
            _ => self.bar_ui(ui),
        };
        let text = match self.by {
            ColourBy::SlopeDirection if self.has_wheel() => format!("slope up to {}", self.limit_text()),
            ColourBy::Of(Quantity::AtSlopeLimit) => "inside the searched slopes, or at their limit".to_owned(),
            ColourBy::Of(Quantity::Moves) => Moves::ALL.map(Moves::words).join(", "),
            by => {
                let (name, [min, max]) = (self.name().to_lowercase(), [self.min, self.max].map(|end| number(end, 3)));
                format!("{name} from {min} to {max} {}", by.unit())
            }
        };
        let text = format!("Legend: {text}");
        // Screen readers read the text in place of the colours.
        named(&response, egui::Role::Image, &text);
        response.on_hover_text(text)
    }

    fn wheel_ui(&self, ui: &mut Ui) -> Response {
        const RADIUS_POINTS: f32 = 26.0;
        let small = egui::TextStyle::Small.resolve(ui.style());
        let colour = ui.visuals().text_color();
        let galley = ui.painter().layout_no_wrap(self.limit_text(), small.clone(), colour);
        let size = vec2(2.0 * RADIUS_POINTS + 8.0 + galley.size().x, 2.0 * RADIUS_POINTS + 2.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let centre = rect.left_center() + vec2(RADIUS_POINTS, 0.0);
        let mut mesh = egui::Mesh::default();
        const SECTORS: u32 = 72;
        const RINGS: u32 = 6;
        for ring in 0..=RINGS {
            let fraction = ring as f32 / RINGS as f32;
            for sector in 0..=SECTORS {
                let angle = sector as f32 * std::f32::consts::TAU / SECTORS as f32;
                let colour = rgb(direction_colour(angle, fraction));
                mesh.colored_vertex(centre + RADIUS_POINTS * fraction * Vec2::angled(angle), colour);
                if ring > 0 && sector > 0 {
                    let (outer, row) = (ring * (SECTORS + 1) + sector, SECTORS + 1);
                    mesh.add_triangle(outer - 1, outer, outer - row);
                    mesh.add_triangle(outer - 1, outer - row, outer - row - 1);
                }
            }
        }
        ui.painter().add(Shape::mesh(mesh));
        // Covers the polygon's jagged rim.
        ui.painter().circle_stroke(centre, RADIUS_POINTS, Stroke::new(1.5, ui.visuals().weak_text_color()));
        let arrow = Stroke::new(1.0, Color32::from_black_alpha(160));
        ui.painter().line_segment([centre, centre + vec2(RADIUS_POINTS - 1.0, 0.0)], arrow);
        ui.painter().galley(pos2(centre.x + RADIUS_POINTS + 7.0, centre.y - 0.5 * galley.size().y), galley, colour);
        response
    }

    fn words_ui(&self, ui: &mut Ui) -> Response {
        let words = Moves::ALL.map(|moves| {
            Label::new(RichText::new(moves.words()).small().color(self.along(f32::from(moves as u8)))).selectable(false)
        });
        ui.vertical(|ui| words.into_iter().for_each(|word| drop(ui.add(word)))).response
    }

    pub fn height(&self) -> f32 {
        match self.by {
            ColourBy::Of(Quantity::Moves) => 17.0 * Moves::ALL.len() as f32,
            _ if self.has_wheel() => 54.0,
            _ => 28.0,
        }
    }

    fn bar_ui(&self, ui: &mut Ui) -> Response {
        let small = egui::TextStyle::Small.resolve(ui.style());
        let colour = ui.visuals().text_color();
        let width = ui.available_width().clamp(90.0, 180.0);
        let text_height = ui.text_style_height(&egui::TextStyle::Small);
        let (rect, response) = ui.allocate_exact_size(vec2(width, 12.0 + text_height + 3.0), Sense::hover());
        let bar = Rect::from_min_size(rect.min, vec2(width, 11.0));
        strip_of_colours(ui.painter(), bar, self.table.len(), |i, _| self.table[i]);
        ui.painter().rect_stroke(bar, 2.0, Stroke::new(1.0, ui.visuals().weak_text_color()), StrokeKind::Outside);
        let y = bar.bottom() + 3.0;
        let end = |x| match self.by {
            ColourBy::Of(Quantity::AtSlopeLimit) if x == self.min => "inside".to_owned(),
            ColourBy::Of(Quantity::AtSlopeLimit) => "at the limit".to_owned(),
            _ => number(x, 3),
        };
        ui.painter().text(pos2(bar.left(), y), Align2::LEFT_TOP, end(self.min), small.clone(), colour);
        ui.painter().text(pos2(bar.right(), y), Align2::RIGHT_TOP, end(self.max), small, colour);
        small_text(ui, ui.painter(), pos2(bar.center().x, y), Align2::CENTER_TOP, self.by.unit());
        response
    }
}

pub fn rgb([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::super::tests::feature;
    use super::*;
    use crate::detector::SlopeAxis;

    const PLANE: SlopeGrid = SlopeGrid {
        u: SlopeAxis { min: -3.0, max: 3.0, count: 7 },
        v: SlopeAxis { min: -1.0, max: 1.0, count: 3 },
        direction_deg: 0.0,
    };

    #[test]
    fn scales_span_the_features() {
        let mut features = [feature(0.0, 0.0, 2.0, (-1.0, 0.5), -0.1), feature(5.0, 5.0, 8.0, (3.0, 0.5), 0.05)];
        (features[1].snr, features[1].at_slope_limit) = (10.0 * features[0].snr, true);
        assert_eq!(ColourScale::of(ColourBy::Of(Quantity::SlopeU), &features, &PLANE).max, 3.0);
        assert_eq!(ColourScale::of(ColourBy::Of(Quantity::Sigma), &features, &PLANE).min, 2.0);
        assert_eq!(ColourScale::of(ColourBy::Of(Quantity::Response), &features, &PLANE).min, -0.1);
        for by in ColourBy::all() {
            let scale = ColourScale::of(by, &features, &PLANE).with_set_up(Some(&SetUp::default()));
            // The two features have this quantity in common.
            use Quantity::{AtSlopeLimit, Depth, Response, Sigma, SlopeU, Snr};
            if by.quantity().is_some_and(|by| ![Response, Sigma, SlopeU, Snr, Depth, AtSlopeLimit].contains(&by)) {
                assert_eq!(scale.colour(0, &features[0]), scale.colour(1, &features[1]));
            } else {
                assert_ne!(scale.colour(0, &features[0]), scale.colour(1, &features[1]), "{by:?}");
            }
        }
    }

    #[test]
    fn places_of_unknown_motion_and_features_of_no_layer_are_grey_and_colours_follow_the_motion() {
        let own = feature(0.0, 0.0, 2.0, (1.0, 0.0), 0.1);
        let edge = Feature { field: Slope::new(-2.0, 0.5), field_sigma: 0.1, slope_sigma: 1.0, layer: 3, ..own };
        let edge = Feature { moves: Moves::Edge, ..edge };
        let unknown = Feature { field_sigma: f32::INFINITY, layer: 0, moves: Moves::Unknown, ..edge };
        let features = [edge, Feature { field: Slope::new(2.0, 0.0), layer: 1, ..edge }, unknown];
        for by in [ColourBy::Of(Quantity::FieldU), ColourBy::Of(Quantity::FieldV), ColourBy::Of(Quantity::Layer)] {
            let scale = ColourScale::of(by, &features, &PLANE);
            assert!(scale.has_unknown() && !ColourScale::of(by, &features[..2], &PLANE).has_unknown());
            let [first, second, third] = [0, 1, 2].map(|i| scale.colour(i, &features[i]));
            assert!(third == UNKNOWN && first != second && first != UNKNOWN && second != UNKNOWN, "{by:?}");
        }
        let scale = ColourScale::of(ColourBy::SlopeDirection, &features, &PLANE);
        assert_eq!(scale.colour(0, &edge), scale.of_slope(edge.field));
        assert_eq!(scale.colour(2, &unknown), scale.of_slope(unknown.slope));
    }

    #[test]
    fn speeds_have_no_direction_and_motions_rise_in_lightness_so_that_every_eye_tells_them_apart() {
        let at = |slope| feature(0.0, 0.0, 2.0, slope, 0.1);
        let features = [at((3.0, 0.0)), at((0.0, -3.0)), at((0.5, 0.0))];
        let speed = ColourScale::of(ColourBy::Speed, &features, &PLANE);
        let [right, up, slow] = [0, 1, 2].map(|i| speed.colour(i, &features[i]));
        assert!(right == up && up == speed.along(3.0) && slow != up && !speed.has_wheel());
        let quantities = [Quantity::SlopeU, Quantity::FieldV, Quantity::Coherence].map(ColourBy::Of);
        for by in [ColourBy::Speed].into_iter().chain(quantities) {
            let scale = ColourScale::with_range(by, 0.0, 1.0);
            // Uneven responses, the few, are light.
            let at = |i: u8| if by == ColourBy::Of(Quantity::Coherence) { 20 - i } else { i };
            // Of a grey of the same lightness, by the weights of sRGB.
            let lightness = |i: u8| {
                let [r, g, b, _] = egui::Rgba::from(scale.along(f32::from(at(i)) / 20.0)).to_array();
                0.2126 * r + 0.7152 * g + 0.0722 * b
            };
            assert!((0..20).all(|i| lightness(i + 1) > lightness(i)) && lightness(0) > 0.08, "{by:?}");
        }
    }
}
