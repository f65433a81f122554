//! Files of drawings and their numbers: the one list of endings, and what each means.

use super::{pdf::pdf, raster::rasterise, shape::Drawing, svg::write_svg, table::Table};
use crate::error::{Error, ErrorKind, Result};
use crate::export::atomic::{write_marked, write_text, write_whole};
use crate::export::png::{Bitmap, write_png};
use crate::files::mark::OutputKind;
use serde::{Deserialize, Serialize};
use std::{io::Write, path::Path};

/// Format of the file of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, strum::IntoStaticStr)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum FigureFormat {
    /// Vectors, with the font in the file.
    #[default]
    Pdf,
    /// Vectors.
    Svg,
    /// Pixels.
    Png,
    /// The numbers as CSV.
    #[serde(skip)]
    #[cfg_attr(feature = "cli", value(skip))]
    Csv,
    /// The numbers as a table for LaTeX.
    #[serde(skip)]
    #[cfg_attr(feature = "cli", value(skip))]
    Tex,
}

impl FigureFormat {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Pdf, Self::Svg, Self::Png, Self::Csv, Self::Tex];
    /// Those of a drawing without numbers.
    pub const DRAWN: [Self; 3] = [Self::Pdf, Self::Svg, Self::Png];

    /// Ending of the file's name.
    pub fn extension(self) -> &'static str {
        self.into()
    }

    /// The format in a few words.
    pub fn help(self) -> &'static str {
        match self {
            Self::Pdf => "Vectors, with the font in the file: as journals ask for it",
            Self::Svg => "Vectors that drawing programs edit",
            Self::Png => "Pixels, 300 an inch on paper",
            Self::Csv => "The numbers, comma-separated",
            Self::Tex => "The numbers as a table for LaTeX",
        }
    }

    /// The format, one of `formats`, that the ending of `path` names.
    ///
    /// # Errors
    /// Another ending, or none; the remedy names those of `formats`.
    pub fn of(path: &Path, formats: &[Self]) -> Result<Self> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        formats.iter().find(|format| format.extension() == ending).copied().ok_or_else(|| {
            let endings: Vec<String> = formats.iter().map(|format| format!(".{}", format.extension())).collect();
            let (last, others) = endings.split_last().expect("a file has a format");
            let remedy = format!("end the name in {} or {last}", others.join(", "));
            Error::new(ErrorKind::Request, "the ending says what is written", remedy).about(path)
        })
    }

    fn write(self, path: &Path, drawing: &Drawing, table: &dyn Fn() -> Table) -> Result<()> {
        let drawn = OutputKind::Drawing;
        match self {
            Self::Svg => write_marked(path, drawn, |out| write_svg(out, drawing)),
            Self::Pdf => write_marked(path, drawn, |out| out.write_all(&pdf(drawing)?)),
            Self::Png => {
                let too_large = |problem| Error::new(ErrorKind::TooLarge, problem, "").about(path);
                let picture = rasterise(drawing).map_err(too_large)?;
                let (width, height) = picture.dimensions();
                write_png(path, Bitmap::rgba(width as usize, height as usize, picture.as_raw()))
            }
            Self::Csv => write_whole(path, |out| out.write_all(table().csv().as_bytes())),
            Self::Tex => write_text(path, drawn, table().latex()),
        }
    }
}

/// A drawing with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// The drawing.
    pub drawing: Drawing,
    /// The numbers that it shows.
    pub table: Table,
}

/// A table is drawn as a sheet.
impl From<Table> for Figure {
    fn from(table: Table) -> Self {
        Self { drawing: table.drawing(), table }
    }
}

impl Figure {
    /// Writes the drawing, or its numbers, in the format that the ending of `path` names.
    ///
    /// # Errors
    /// An ending that names none, a drawing too large for pixels, or the system fails.
    pub fn write(&self, path: &Path) -> Result<()> {
        FigureFormat::of(path, &FigureFormat::ALL)?.write(path, &self.drawing, &|| self.table.clone())
    }
}

/// Writes a drawing without numbers, as [`Figure::write`] does.
pub fn write_drawing(path: &Path, drawing: &Drawing) -> Result<()> {
    let format = FigureFormat::of(path, &FigureFormat::DRAWN)?;
    format.write(path, drawing, &|| Table::new(&drawing.title, "", Vec::new()))
}
