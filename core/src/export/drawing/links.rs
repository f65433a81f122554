//! Lines from a place of one panel to a place of another: matches.
//!
//! Inliers are solid yellow, outliers dashed vermilion: colours (Okabe and Ito's) and dashes both tell them apart.

use super::panel::{FigurePanel, LegendEntry, LegendMark};
use super::shape::{Colour, DASH, FigureRect, FigureShape, FigureStroke};
use serde::{Deserialize, Serialize};

/// Radius of the ring at an end, as a multiple of the stroke's width.
const RING: f32 = 2.0;

/// How the geometry of two views judged a match.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatchKind {
    /// It agrees with the geometry.
    Inlier,
    /// It does not agree.
    Outlier,
    /// No geometry was looked for.
    Unverified,
}

impl MatchKind {
    /// Opacity of the lines of matches, 0 … 1.
    pub const OPACITY: f32 = 0.7;
    /// All kinds, in the order of legends.
    pub const ALL: [Self; 3] = [Self::Inlier, Self::Outlier, Self::Unverified];

    /// Kind of a match that is (or is not) an inlier; `None` means not verified.
    pub fn of(inlier: Option<bool>) -> Self {
        match inlier {
            Some(true) => Self::Inlier,
            Some(false) => Self::Outlier,
            None => Self::Unverified,
        }
    }

    /// Plural for legends, such as `inliers`.
    pub fn label(self) -> &'static str {
        match self {
            Self::Inlier => "inliers",
            Self::Outlier => "outliers",
            Self::Unverified => "matches, not verified",
        }
    }

    /// Colour of the line.
    pub fn color(self) -> Colour {
        match self {
            Self::Inlier => [240, 228, 66],
            Self::Outlier => [213, 94, 0],
            Self::Unverified => [226, 150, 200],
        }
    }

    /// Whether the line is dashed.
    pub fn is_dashed(self) -> bool {
        self == Self::Outlier
    }

    /// Entries of the kinds of `drawn` matches, with `label` of each kind, its number there, and its number in `all`.
    pub fn legend(drawn: &[Self], all: &[Self], label: impl Fn(Self, usize, usize) -> String) -> Vec<LegendEntry> {
        let count = |of: &[Self], kind| of.iter().filter(|other| **other == kind).count();
        let entry = |kind: Self| {
            let mark = if kind.is_dashed() { LegendMark::Dashes } else { LegendMark::Line };
            let (drawn, all) = (count(drawn, kind), count(all, kind));
            (drawn > 0).then(|| LegendEntry { mark, color: kind.color(), label: label(kind, drawn, all) })
        };
        Self::ALL.into_iter().filter_map(entry).collect()
    }

    /// Label with the number of those `drawn`, of `all` where that is more.
    pub fn counted(self, drawn: usize, all: usize) -> String {
        let of = if drawn < all { format!("{drawn} of ") } else { String::new() };
        format!("{of}{all} {}", self.label())
    }
}

/// Part of the features or matches that a figure shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FigureAmount {
    /// All that are shown.
    #[default]
    All,
    /// Features that the window draws in full: as many of the strongest as each part of the view can bear.
    Drawn,
    /// So many of the strongest.
    Strongest(u32),
    /// One of so many, evenly along the order of strength.
    OneOf(u32),
}

impl FigureAmount {
    /// Those shown of `all`, the strongest first.
    pub fn of<T>(self, all: Vec<T>) -> Vec<T> {
        match self {
            Self::All | Self::Drawn => all,
            Self::Strongest(count) => all.into_iter().take(count as usize).collect(),
            Self::OneOf(every) => all.into_iter().step_by(every.max(1) as usize).collect(),
        }
    }
}

/// A line between two panels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureLink {
    /// Indices of the panels at its start and end, in reading order.
    pub panels: [usize; 2],
    /// Ends, one in each panel, (u, v) in image pixels.
    pub ends_image: [[f32; 2]; 2],
    /// Colour of the line.
    pub color: Colour,
    /// Opacity, 0 … 1.
    pub opacity: f32,
    /// Width as a multiple of the figure's stroke width.
    pub weight: f32,
    /// Whether the line is dashed.
    pub dashed: bool,
}

impl FigureLink {
    /// The line of a match of this kind between two panels, from end to end in image pixels.
    pub fn of_match(panels: [usize; 2], ends_image: [[f32; 2]; 2], kind: MatchKind) -> Self {
        let (color, opacity, dashed) = (kind.color(), MatchKind::OPACITY, kind.is_dashed());
        Self { panels, ends_image, color, opacity, weight: 0.8, dashed }
    }
}

/// Matches of a figure: the lines between its panels, and what these mean.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FigureMatches {
    /// The lines. Those to missing panels, and those with invalid numbers, are left out.
    pub links: Vec<FigureLink>,
    /// Entries below all panels.
    pub legend: Vec<LegendEntry>,
}

/// Lines between panels with pictures in these rectangles, where both ends are visible; a single end is a small ring.
pub(super) fn lines_of(
    panels: &[(FigureRect, &FigurePanel)],
    links: &[FigureLink],
    stroke_width: f32,
) -> Vec<FigureShape> {
    let mut shapes = Vec::new();
    for link in links {
        let width = stroke_width * link.weight;
        let stroke = FigureStroke { opacity: link.opacity.clamp(0.0, 1.0), ..FigureStroke::new(link.color, width) };
        let ends = [0, 1].map(|i| {
            let (rect, panel) = panels.get(link.panels[i])?;
            seen(rect, panel, link.ends_image[i])
        });
        if let [Some(from), Some(to)] = ends {
            let style = if link.dashed { stroke.dashed([DASH * width; 2]) } else { stroke }.into();
            shapes.push(FigureShape::Line { points: vec![Some(from), Some(to)], style, class: "match" });
        }
        // A single ring shows that a match exists whose other end is out of sight.
        let ring = |centre| FigureShape::Circle { centre, radius: RING * width, style: stroke.into() };
        shapes.extend(ends.into_iter().flatten().map(ring));
    }
    shapes
}

/// The position on the sheet of a place of a panel; `None` if it is outside the panel's picture.
fn seen(rect: &FigureRect, panel: &FigurePanel, at_image: [f32; 2]) -> Option<[f32; 2]> {
    let scale = rect.size[0] / (panel.size.0 as f32 * panel.image_px_per_px);
    let at = [0, 1].map(|i| rect.min[i] + (at_image[i] - panel.origin_image[i]) * scale);
    // NaN is inside of nothing.
    let inside = (0..2).all(|i| (rect.min[i]..=rect.min[i] + rect.size[i]).contains(&at[i]));
    inside.then_some(at)
}
