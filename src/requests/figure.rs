//! Figures for print: of the panes of the window, with a preview of what is written, and of the matches of two bursts,
//! with both pictures, lines between them, and the numbers of inliers and outliers.

use super::{JobError, PictureAnswer};
use crate::dataset::{DetectedBurst, ImageKind, burst_plane};
use crate::detector::view::stack_view;
use crate::detector::{Feature, Method};
use crate::error::Error;
use crate::export::{
    ColourBar, Drawing, FigureAmount, FigureFormat, FigureLink, FigureMatches, FigureOptions, FigurePanel, FigureUnit,
    FigureWidth, MatchKind, lay_out, rasterise_preview, write_drawing, write_text,
};
use crate::files::mark::OutputKind;
use crate::inspect::report::BurstPage;
use crate::inspect::slopes::{features_at_slopes, slope_with_most_features};
use crate::inspect::words::{counted, number, slope_text};
use crate::matching::MatchResult;
use crate::monitor::Monitor;
use crate::plane::Plane;
use crate::plane::display::{Display, to_rgba8};
use crate::plane::statistics::Region;
use image::RgbaImage;
use image::imageops::crop_imm;
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

/// Most columns and rows of a preview: those of its place on a screen with two pixels a point.
const PREVIEW_PX: [u32; 2] = [800; 2];

#[derive(Debug, Clone, PartialEq)]
pub struct FigurePicture {
    pub picture: PictureAnswer,
    /// Part that is drawn, in the picture's pixels.
    pub region: Region,
    pub display: Display,
    /// Features with whose motions a picture of motions shares its colours.
    pub features: Vec<Feature>,
    /// All but the pixels.
    pub panel: FigurePanel,
}

impl FigurePicture {
    fn panel(&self) -> FigurePanel {
        let whole = self.picture.rgba(&self.display, &self.features);
        let Region { columns, rows } = &self.region;
        let [u, v, width, height] = [columns.start, rows.start, columns.len(), rows.len()].map(|px| px as u32);
        let rgba = crop_imm(&whole, u, v, width, height).to_image().into_raw();
        FigurePanel { rgba: Arc::new(rgba), ..self.panel.clone() }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct FigureRequest {
    pub rows: Vec<Vec<FigurePicture>>,
    pub matches: FigureMatches,
    pub options: FigureOptions,
    pub format: FigureFormat,
}

#[derive(Debug)]
pub struct FigurePreview {
    pub image: RgbaImage,
    /// Number of pictures, size of the figure, and titles.
    pub words: String,
}

impl FigureRequest {
    pub fn drawing(&self) -> Drawing {
        let rows = self.rows.iter().map(|row| row.iter().map(FigurePicture::panel).collect());
        lay_out(&rows.collect::<Vec<_>>(), &self.matches, &self.options)
    }
}

request! {
    FigureRequest => FigurePreview, Picture: |self, work| {
        let drawing = self.drawing();
        work.monitor.check()?;
        let to_pixels = self.format == FigureFormat::Png;
        let image = rasterise_preview(&drawing, PREVIEW_PX, to_pixels).map_err(JobError::Failed)?;
        let (scale, unit) = if drawing.unit == FigureUnit::Point { (25.4 / 72.0, "mm") } else { (1.0, "px") };
        let [width, height] = drawing.size.map(|side| scale * side);
        let pictures = counted(self.rows.iter().map(Vec::len).sum(), "picture");
        let words = format!("Preview of {pictures} on {width:.0} × {height:.0} {unit}. {}", drawing.title);
        Ok(FigurePreview { image, words })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum MatchPictures {
    /// Motion stack at the slope with most features; the middle frame of a burst without slopes.
    #[default]
    Stack,
    Middle,
    Merged,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchFigure {
    pub pictures: MatchPictures,
    /// Matches that are drawn, in the order of their distance.
    pub matches: FigureAmount,
    pub width_mm: f32,
}

impl MatchPictures {
    fn of(self, of: &DetectedBurst<'_>, monitor: &Monitor) -> Result<(Arc<Plane>, String), Error> {
        let DetectedBurst { burst, params, detection } = of;
        let slope = || {
            let grid = &detection.slopes;
            let most = slope_with_most_features(grid, &features_at_slopes(detection));
            most.filter(|_| params.method == Method::Buff).map(|(index, _)| grid.slope(index))
        };
        Ok(match (self, slope()) {
            (MatchPictures::Stack, Some(slope)) => {
                let shown = format!("motion stack, slope {} px/frame", slope_text(slope));
                (Arc::new(stack_view(burst, params, slope, monitor)?), shown)
            }
            (MatchPictures::Merged, _) => {
                (burst_plane(burst, ImageKind::Merged, params, monitor)?, "merged frames".to_owned())
            }
            _ => (burst_plane(burst, ImageKind::Middle, params, monitor)?, "middle frame".to_owned()),
        })
    }
}

/// Writes the page of a burst as text or, where the ending of `path` is not of one, as a drawing with the picture that
/// the figure of a match has of the burst.
pub fn write_page(path: &Path, page: &BurstPage<'_>, monitor: &Monitor) -> Result<(), Error> {
    if let Some(text) = page.page().text_for(path) {
        return write_text(path, OutputKind::Page, text);
    }
    let cache = page.cache;
    let of = DetectedBurst { burst: &cache.burst, params: cache.params(), detection: cache.detection() };
    let (picture, shown) = MatchPictures::default().of(&of, monitor)?;
    write_drawing(path, &page.drawing(&picture, &shown))
}

/// Width over height above which two pictures are larger one above the other.
const STACKED: f32 = 1.6;

/// Whether two pictures of these sizes (columns, rows) stand one above the other.
pub fn are_stacked(sizes: [(usize, usize); 2]) -> bool {
    sizes.into_iter().all(|(width, height)| width as f32 > STACKED * height as f32)
}

pub fn titled(side: &str, burst: &str, shown: &str) -> String {
    format!("{side}: {burst} · {shown}")
}

impl MatchFigure {
    pub fn drawing(
        &self,
        pair: [DetectedBurst<'_>; 2],
        result: &MatchResult,
        monitor: &Monitor,
    ) -> Result<Drawing, Error> {
        let inlier = |k: usize| result.verification.as_ref().map(|verification| verification.inlier[k]);
        let mut order: Vec<usize> = (0..result.matches.len()).collect();
        order.sort_by(|&i, &j| result.matches[i].distance.total_cmp(&result.matches[j].distance).then(i.cmp(&j)));
        let kind = |k: &usize| MatchKind::of(inlier(*k));
        // The legend counts each kind among those drawn and among all.
        let all: Vec<MatchKind> = order.iter().map(kind).collect();
        let mut drawn = self.matches.of(order);
        let kinds: Vec<MatchKind> = drawn.iter().map(kind).collect();
        // Outliers lie below: they matter less.
        drawn.sort_by_key(|k| inlier(*k) != Some(false));
        let link = |k: &usize| {
            let found = &result.matches[*k];
            let of = |side: usize, index: usize| &pair[side].detection.features[index];
            let ends = [of(0, found.a), of(1, found.b)].map(|feature| [feature.u, feature.v]);
            FigureLink::of_match([0, 1], ends, kind(k))
        };
        let matches = FigureMatches {
            links: drawn.iter().map(link).collect(),
            legend: MatchKind::legend(&kinds, &all, MatchKind::counted),
        };
        let [a, b] = [("A", &pair[0]), ("B", &pair[1])].map(|(side, burst)| self.panel(side, burst, monitor));
        let (a, b) = (a?, b?);
        let rows = if are_stacked([a.size, b.size]) { vec![vec![a], vec![b]] } else { vec![vec![a, b]] };
        let width = FigureWidth::Millimetres(self.width_mm);
        let options = FigureOptions { width, stroke_width: 0.75, font_size: 8.0, letters: true, scale_bar: true };
        Ok(lay_out(&rows, &matches, &options))
    }

    fn panel(&self, side: &str, of: &DetectedBurst<'_>, monitor: &Monitor) -> Result<FigurePanel, Error> {
        let (plane, shown) = self.pictures.of(of, monitor)?;
        // Dark frames would be black on paper.
        let display = Display::stretched(&plane);
        let (low, high) = (number(display.min, 3), format!("{} of full scale", number(display.max, 3)));
        Ok(FigurePanel {
            size: plane.size(),
            rgba: Arc::new(to_rgba8(&plane, &display).into_raw()),
            origin_image: [-0.5, -0.5],
            image_px_per_px: 1.0,
            marks: Vec::new(),
            title: Some(titled(side, &of.burst.name, &shown)),
            legend: Vec::new(),
            bar: Some(ColourBar::of(&display, low, high)),
        })
    }
}
