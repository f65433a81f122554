//! The figure of the panes of the window: all that decides it, the drawing that is written, and a preview of that.

use super::{JobError, PictureAnswer, Request, Urgency, Work};
use crate::detector::Feature;
use crate::export::{
    Drawing, FigureFormat, FigureMatches, FigureOptions, FigurePanel, FigureUnit, lay_out, rasterise_preview,
};
use crate::inspect::words::counted;
use crate::plane::display::Display;
use crate::plane::statistics::Region;
use image::RgbaImage;
use image::imageops::crop_imm;
use std::convert::Infallible;
use std::sync::Arc;

/// Most columns and rows of a preview: those of its place on a screen with two pixels a point.
const PREVIEW_PX: [u32; 2] = [800; 2];

/// Picture of a pane in a figure.
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

impl Request for FigureRequest {
    type Answer = FigurePreview;
    type Partial = Infallible;
    const URGENCY: Urgency = Urgency::Picture;

    fn compute(self, work: &Work<'_, Infallible>) -> Result<FigurePreview, JobError> {
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
