//! Changes beyond the project: values that its parts return, and that the window applies, with the purposes for which
//! the user is asked for files.

use super::side::Side;
use crate::dataset::DatasetSource;
use crate::engine::Ended;
use crate::export::case::CASE_EXTENSION;
use crate::requests::{BurstSource, OpenRequest, PossibleShape};
use crate::teach::Lesson;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug)]
pub enum Effect {
    /// Opening a burst for a side ended, with or without success; a session may have waited for it.
    Opened(Side, Ended<OpenRequest>),
    Recent(BurstSource),
    RecentDataset(DatasetSource),
    Choose(Side, Vec<BurstSource>),
    /// Asks for the shape of a file without header, which may be one of these.
    AskShape(Side, BurstSource, Vec<PossibleShape>),
    Cut {
        paths: Vec<PathBuf>,
        frames: usize,
    },
    ReplaceFeatures,
    /// The thumbnails are of another dataset, or were made with another calibration.
    ForgetThumbnails,
    Ask(Purpose),
    UseFiles(Purpose, Vec<PathBuf>),
    /// A file is written. The user agreed that it may replace one that is there.
    Write(Purpose, PathBuf),
    StartLesson(Arc<Lesson>),
    ForgetWidgets,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    OpenFolder,
    OpenFiles,
    OpenDataset,
    FeatureFolder,
    PaperFigures,
    ExportDatabase,
    OpenEstimate,
    OpenTruth,
    OpenPath,
    OpenFolderB,
    OpenFilesB,
    OpenPathB,
    /// A sharp image of the view of a side, used as its gold standard.
    OpenGold(Side),
    OpenFeatures(Side),
    OpenBias,
    OpenFlat,
    OpenMask,
    OpenMasks,
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
    FilmGif,
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

    pub fn label(self) -> &'static str {
        self.words().1
    }

    fn words(self) -> (&'static [&'static str], &'static str) {
        match self {
            Self::Csv => (&["csv"], "Export features as CSV"),
            Self::Colmap => (&["txt"], "Export features for COLMAP"),
            Self::Npz => (&["npz"], "Export features as NPZ"),
            Self::Tiff => (&["tiff"], "Export picture as TIFF"),
            Self::Png => (&["png"], "Export picture as PNG"),
            Self::Figure => (&["pdf", "svg", "png"], "Export figure as PDF, SVG or PNG"),
            Self::Matches => (&["csv"], "Export matches as CSV"),
            Self::Methods => (&["csv", "tex"], "Export table of methods as CSV or LaTeX"),
            Self::Profile => (&["csv"], "Export line profile as CSV"),
            Self::CurvesCsv => (&["csv"], "Export curves as CSV"),
            Self::CurvesSvg => (&["svg"], "Export curves as SVG"),
            Self::Case => (&[CASE_EXTENSION], "Save case"),
            Self::FilmGif => (&["gif"], "Export film as GIF"),
            Self::Mask => (&["png"], "Save the mask"),
            Self::Sheet => (&["md"], "Export lesson sheet as Markdown"),
        }
    }
}

impl Purpose {
    pub fn title(self) -> &'static str {
        match self {
            Self::OpenFolder => "Open a folder of frames",
            Self::OpenFiles => "Open image files",
            Self::OpenDataset => "Open a folder of bursts, or a long sequence",
            Self::FeatureFolder => "Choose a folder for the dataset's features",
            Self::PaperFigures => "Choose a folder for the figures of the paper",
            Self::ExportDatabase => "Choose a folder for COLMAP's database",
            Self::OpenEstimate => "Open an estimated trajectory",
            Self::OpenTruth => "Open a true trajectory",
            Self::OpenPath => "Open a path",
            Self::OpenFolderB => "Open a folder of frames as B",
            Self::OpenFilesB => "Open image files as B",
            Self::OpenPathB => "Open a path as B",
            Self::OpenGold(Side::A) => "Open the gold standard of A",
            Self::OpenGold(Side::B) => "Open the gold standard of B",
            Self::OpenFeatures(_) => "Open features",
            Self::OpenBias => "Choose a bias frame",
            Self::OpenFlat => "Choose a flat frame",
            Self::OpenMask => "Choose a mask",
            Self::OpenMasks => "Choose a folder of masks",
            Self::OpenLessons => "Open lessons",
            Self::RestoreSession => "Open a session",
            Self::SaveSession => "Save the session",
            Self::LoadParams => "Load parameters",
            Self::SaveParams => "Save parameters",
            Self::Export(kind) => kind.label(),
        }
    }

    pub fn saves(self) -> bool {
        matches!(self, Self::SaveSession | Self::SaveParams | Self::Export(_))
    }

    pub fn hint(self) -> &'static str {
        match self {
            Self::OpenDataset => "A folder of bursts (each a folder of frames), or one long sequence of frames",
            Self::OpenEstimate | Self::OpenTruth => {
                "A sparse model (its folder, or a file of it), or a file of lines: timestamp tx ty tz qx qy qz qw"
            }
            Self::ExportDatabase => {
                "A new or an empty folder, or one that was written so before: its features are not found again"
            }
            Self::PaperFigures => "A new or an empty folder, or one with figures: finished ones are kept",
            Self::FeatureFolder => "A new or an empty folder, or one that burstscope colmap wrote",
            Self::OpenMasks => "A folder with a mask for each file of frames: NAME.EXT.png, or the frame's own name",
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
            Self::OpenFiles | Self::OpenFilesB => [crate::burst::supported_extensions(), vec![CASE_EXTENSION]].concat(),
            Self::OpenBias | Self::OpenFlat | Self::OpenMask | Self::OpenGold(_) => {
                crate::burst::supported_extensions()
            }
            Self::RestoreSession | Self::SaveSession | Self::LoadParams | Self::SaveParams => vec!["toml"],
            Self::OpenFeatures(_) => vec!["csv", "txt"],
            Self::Export(kind) => kind.extensions().to_vec(),
            _ => Vec::new(),
        }
    }
}
