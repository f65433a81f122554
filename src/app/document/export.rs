//! What is exported: contents and style of a figure, the film, and the purposes for which the user is asked for files.

use crate::app::{defaults::with_defaults, document::Side, words::choices};
use crate::evaluate::poses::{DEMO_ESTIMATE, DEMO_TRUTH};
use crate::export::case::CASE_EXTENSION;
use crate::export::{FigureAmount, FigureFormat, FigureOptions, FigureWidth};
use crate::requests::{BurstSource, Which};
use serde::{Deserialize, Serialize};

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct FigureChoice {
        pub format: FigureFormat = FigureFormat::Pdf,
        pub all_panes: bool = true,
        pub whole_picture: bool,
        pub width: FigureWidth = FigureWidth::Millimetres(TWO_COLUMNS_MM),
        /// In the unit of the width, as the height of letters.
        pub stroke_width: f32 = 0.75,
        pub font_size: f32 = 8.0,
        pub features: FigureAmount = FigureAmount::Drawn,
        pub matches: FigureAmount = FigureAmount::Drawn,
        pub titles: bool = true,
        pub letters: bool = true,
        pub legend: bool = true,
        pub colour_bar: bool = true,
        pub scale_bar: bool = true,
    }
}

/// Widths of one column and of two in journals.
pub const ONE_COLUMN_MM: f32 = 88.0;

pub const TWO_COLUMNS_MM: f32 = 181.0;

impl FigureChoice {
    pub fn options(&self) -> FigureOptions {
        let Self { width, stroke_width, font_size, letters, scale_bar, .. } = *self;
        FigureOptions { width, stroke_width, font_size, letters, scale_bar }
    }

    /// Choice with another width, its letters and lines in the new unit.
    #[must_use]
    pub fn with_width(self, width: FigureWidth) -> Self {
        if width.unit() == self.width.unit() {
            return Self { width, ..self };
        }
        match width {
            FigureWidth::PxPerPx(_) => Self { width, stroke_width: 1.5, font_size: 14.0, ..self },
            FigureWidth::Millimetres(_) => Self { width, stroke_width: 0.75, font_size: 8.0, ..self },
        }
    }
}

choices! {
    #[derive(Default)]
    FilmContent {
        /// Slopes of the grid and half-way between, along its first axis that has several.
        #[default]
        Slopes: "Slopes", "The motion stack at the slopes of the search and half-way between";
        Scales: "Scales", "D at the slope of the cursor, from the finest octave and level to the coarsest";
        Frames: "Frames added", "The motion stack at the slope of the cursor, of one frame to all";
    }
}

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    pub struct FilmChoice {
        pub content: FilmContent,
        pub rate: u16 = 10,
        pub max_side_px: usize = 640,
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    OpenFolder(Side),
    OpenFiles(Side),
    OpenPath(Side),
    OpenDataset,
    FeatureFolder,
    PaperFigures,
    ExportDatabase,
    OpenTrajectory(Which),
    /// A sharp image of the view of a side, used as its gold standard.
    OpenGold(Side),
    OpenFeatures(Side),
    OpenBias,
    OpenFlat,
    OpenMask,
    OpenMasks,
    OpenTimes,
    OpenRotations,
    OpenLens,
    OpenLessons,
    RestoreSession,
    SaveSession,
    LoadParams,
    SaveParams,
    Export(ExportKind),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExportKind {
    Csv,
    Colmap,
    Npz,
    Tiff,
    Png,
    Figure,
    Matches,
    Methods,
    Profile,
    CurvesCsv,
    CurvesSvg,
    Case,
    /// The burst of the pane in focus on one page.
    Report,
    Film,
    /// Mask of the outlines that were drawn.
    Mask,
    /// The open lesson's tasks, questions and answers.
    Sheet,
}

impl ExportKind {
    /// Extensions of the files that are written, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        self.words().0
    }

    /// Word for the content in suggested names of files; `None` for a picture, which has that of its kind.
    pub fn content(self) -> Option<&'static str> {
        Some(self.words().2).filter(|content| !content.is_empty())
    }

    fn words(self) -> (&'static [&'static str], &'static str, &'static str) {
        match self {
            Self::Csv => (&["csv"], "Export features as CSV", "features"),
            Self::Colmap => (&["txt"], "Export features for COLMAP", "features"),
            Self::Npz => (&["npz"], "Export features as NPZ", "features"),
            Self::Tiff => (&["tiff"], "Export picture as TIFF", ""),
            Self::Png => (&["png"], "Export picture as PNG", ""),
            Self::Figure => (&["pdf", "svg", "png"], "Export figure as PDF, SVG or PNG", "figure"),
            Self::Matches => (&["csv"], "Export matches as CSV", "matches"),
            Self::Methods => (&["csv", "tex", "pdf", "svg", "png"], "Export table of methods", "methods"),
            Self::Profile => (&["csv", "tex", "pdf", "svg", "png"], "Export line profile", "profile"),
            Self::CurvesCsv => (&["csv", "tex"], "Export curves as CSV", "curves"),
            Self::CurvesSvg => (&["svg", "pdf", "png"], "Export curves as SVG", "curves"),
            Self::Case => (&[CASE_EXTENSION], "Save case", "case"),
            Self::Report => (&["pdf", "svg", "png", "md", "html"], "Write a report as a drawing or a page", "report"),
            Self::Film => (&["gif", "mp4", "png"], "Export film as GIF, MP4 or PNG pictures", "film"),
            Self::Mask => (&["png"], "Save the mask", "mask"),
            Self::Sheet => (&["md"], "Export lesson sheet as Markdown", "lesson"),
        }
    }
}

impl Purpose {
    pub fn title(self) -> &'static str {
        match self {
            Self::OpenFolder(Side::A) => "Open a folder of frames",
            Self::OpenFiles(Side::A) => "Open image files",
            Self::OpenDataset => "Open a folder of bursts, or a long sequence",
            Self::FeatureFolder => "Choose a folder for the dataset's features",
            Self::PaperFigures => "Choose a folder for the figures of the paper",
            Self::ExportDatabase => "Choose a folder for COLMAP's database",
            Self::OpenTrajectory(Which::Estimate) => "Open an estimated trajectory",
            Self::OpenTrajectory(Which::Second) => "Open a second estimated trajectory",
            Self::OpenTrajectory(Which::Truth) => "Open a true trajectory",
            Self::OpenPath(Side::A) => "Open a path",
            Self::OpenFolder(Side::B) => "Open a folder of frames as B",
            Self::OpenFiles(Side::B) => "Open image files as B",
            Self::OpenPath(Side::B) => "Open a path as B",
            Self::OpenGold(Side::A) => "Open the gold standard of A",
            Self::OpenGold(Side::B) => "Open the gold standard of B",
            Self::OpenFeatures(_) => "Open features",
            Self::OpenBias => "Choose a bias frame",
            Self::OpenFlat => "Choose a flat frame",
            Self::OpenMask => "Choose a mask",
            Self::OpenMasks => "Choose a folder of masks",
            Self::OpenTimes => "Choose a list of times",
            Self::OpenRotations => "Choose rotations",
            Self::OpenLens => "Choose a camera",
            Self::OpenLessons => "Open lessons",
            Self::RestoreSession => "Open a session",
            Self::SaveSession => "Save the session",
            Self::LoadParams => "Load parameters",
            Self::SaveParams => "Save parameters",
            Self::Export(kind) => kind.words().1,
        }
    }

    pub fn saves(self) -> bool {
        matches!(self, Self::SaveSession | Self::SaveParams | Self::Export(_))
    }

    pub fn opens_burst(self) -> bool {
        matches!(self, Self::OpenFolder(_) | Self::OpenFiles(_) | Self::OpenPath(_))
    }

    /// Names that stand for something that is built in, where a path is typed.
    pub fn built_in(self) -> Vec<String> {
        let names = match self {
            _ if self.opens_burst() => BurstSource::built_in().iter().filter_map(BurstSource::name).collect(),
            Self::OpenTrajectory(Which::Truth) => vec![DEMO_TRUTH],
            Self::OpenTrajectory(_) => vec![DEMO_ESTIMATE],
            _ => Vec::new(),
        };
        names.into_iter().map(str::to_owned).collect()
    }

    pub fn hint(self) -> &'static str {
        match self {
            Self::OpenDataset => "A folder of bursts (each a folder of frames), or one long sequence of frames",
            Self::OpenTrajectory(_) => {
                "A sparse model (its folder, or a file of it), or a file of lines: timestamp tx ty tz qx qy qz qw"
            }
            Self::ExportDatabase => {
                "A new or an empty folder, or one that was written so before: its features are not found again"
            }
            Self::PaperFigures => "A new or an empty folder, or one with figures: finished ones are kept",
            Self::FeatureFolder => "A new or an empty folder, or one that burstscope colmap wrote",
            Self::OpenMasks => "A folder with a mask for each file of frames: NAME.EXT.png, or the frame's own name",
            Self::OpenRotations => {
                "Orientations of the camera: qx qy qz qw a line, or lines as of TUM or EuRoC with stamps"
            }
            Self::OpenLens => "A camera file, such as camera.toml",
            Self::OpenTimes => "A time a line, in the order of the frames, or lines with a name and a time",
            Self::OpenFeatures(_) => "A table of features (CSV), or the text that COLMAP imports",
            Self::OpenLessons => "A folder of lessons (TOML files), or one of them",
            Self::RestoreSession | Self::SaveSession => "A session file, such as night.burstscope.toml",
            Self::LoadParams | Self::SaveParams => "A parameter file, such as params.toml",
            Self::Export(_) => "The file to write",
            _ => "A folder of frames, an image, a multi-page TIFF or a .npy stack",
        }
    }

    pub fn extensions(self) -> Vec<&'static str> {
        match self {
            Self::OpenFiles(_) => [crate::burst::supported_extensions(), vec![CASE_EXTENSION]].concat(),
            Self::OpenBias | Self::OpenFlat | Self::OpenMask | Self::OpenGold(_) => {
                crate::burst::supported_extensions()
            }
            Self::RestoreSession | Self::SaveSession | Self::LoadParams | Self::SaveParams => vec!["toml"],
            Self::OpenFeatures(_) | Self::OpenTimes => vec!["csv", "txt"],
            Self::Export(kind) => kind.extensions().to_vec(),
            _ => Vec::new(),
        }
    }
}
