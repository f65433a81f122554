//! Changes beyond the project: values that its parts return, and that the window applies, with the purposes for which
//! the user is asked for files.

use super::side::Side;
use crate::dataset::DatasetSource;
use crate::engine::Ended;
use crate::export::case::CASE_EXTENSION;
use crate::requests::{BurstSource, OpenRequest};
use crate::teach::Lesson;
use std::path::PathBuf;
use std::sync::Arc;

/// Change beyond the part of the window that returns it.
#[derive(Debug)]
pub enum Effect {
    /// Opening a burst for a side ended, with or without success; a session may have waited for it.
    Opened(Side, Ended<OpenRequest>),
    /// A burst goes to the top of the recent list.
    Recent(BurstSource),
    /// A dataset goes to the top of the recent list.
    RecentDataset(DatasetSource),
    /// The user chooses which of several bursts is opened for a side.
    Choose(Side, Vec<BurstSource>),
    /// The user is asked how a sequence is cut into bursts.
    Cut {
        /// Files of the sequence.
        paths: Vec<PathBuf>,
        /// Number of its frames.
        frames: usize,
    },
    /// The user is asked whether features of other parameters may be replaced.
    ReplaceFeatures,
    /// The thumbnails are of another dataset, or were made with another calibration.
    ForgetThumbnails,
    /// The user is asked for files, or for a place to write to.
    Ask(Purpose),
    /// Files are used for a purpose.
    UseFiles(Purpose, Vec<PathBuf>),
    /// A file is written. The user agreed that it may replace one that is there.
    Write(Purpose, PathBuf),
    /// A lesson begins.
    StartLesson(Arc<Lesson>),
    /// Another project is on show: the state of all widgets belongs to the one before.
    ForgetWidgets,
}

/// Purpose of a file question.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A folder of frames.
    OpenFolder,
    /// Image files.
    OpenFiles,
    /// A folder of bursts, or a long sequence.
    OpenDataset,
    /// A folder that keeps a dataset's features.
    FeatureFolder,
    /// A folder for the figures of the paper.
    PaperFigures,
    /// A folder for the input of COLMAP's mapper.
    ExportDatabase,
    /// An estimated trajectory.
    OpenEstimate,
    /// A true trajectory.
    OpenTruth,
    /// Any path of a burst, typed.
    OpenPath,
    /// A folder of frames, for the second burst.
    OpenFolderB,
    /// Image files, for the second burst.
    OpenFilesB,
    /// Any path of a burst, typed, for the second burst.
    OpenPathB,
    /// A sharp image of the view of a side, used as its gold standard.
    OpenGold(Side),
    /// Features of another program, to be compared with those of a side.
    OpenFeatures(Side),
    /// A bias frame.
    OpenBias,
    /// A flat frame.
    OpenFlat,
    /// A folder of lessons, or one.
    OpenLessons,
    /// A session file to restore.
    RestoreSession,
    /// A session file to write.
    SaveSession,
    /// A parameter file to read.
    LoadParams,
    /// A parameter file to write.
    SaveParams,
    /// A file to export to.
    Export(ExportKind),
}

/// Kind of export.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportKind {
    /// Features as CSV.
    Csv,
    /// Features as COLMAP's text.
    Colmap,
    /// Features as NumPy arrays.
    Npz,
    /// The picture's values.
    Tiff,
    /// The picture as shown.
    Png,
    /// The panes with everything over them, as vectors.
    Svg,
    /// The matches as CSV.
    Matches,
    /// Both pictures with the matches between them.
    MatchPicture,
    /// The values along the line.
    Profile,
    /// The panes with everything over them, as pixels.
    FigurePng,
    /// The Lab's curves as a table.
    CurvesCsv,
    /// The Lab's plots as a figure.
    CurvesSvg,
    /// The burst with the search and the probed place, in one file.
    Case,
    /// A sweep over the slopes as a GIF.
    FilmGif,
}

impl ExportKind {
    /// File name extension.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv | Self::Matches | Self::Profile | Self::CurvesCsv => "csv",
            Self::Colmap => "txt",
            Self::Npz => "npz",
            Self::Tiff => "tiff",
            Self::Png | Self::MatchPicture | Self::FigurePng => "png",
            Self::Svg | Self::CurvesSvg => "svg",
            Self::Case => CASE_EXTENSION,
            Self::FilmGif => "gif",
        }
    }

    /// Name of the export in messages.
    pub fn label(self) -> &'static str {
        match self {
            Self::Csv => "Export features as CSV",
            Self::Colmap => "Export features for COLMAP",
            Self::Npz => "Export features as NPZ",
            Self::Tiff => "Export picture as TIFF",
            Self::Png => "Export picture as PNG",
            Self::Svg => "Export figure as SVG",
            Self::Matches => "Export matches as CSV",
            Self::MatchPicture => "Export match picture as PNG",
            Self::Profile => "Export line profile as CSV",
            Self::FigurePng => "Export figure as PNG",
            Self::CurvesCsv => "Export curves as CSV",
            Self::CurvesSvg => "Export curves as SVG",
            Self::Case => "Save case",
            Self::FilmGif => "Export film as GIF",
        }
    }
}

impl Purpose {
    /// The dialog's title.
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
            Self::OpenLessons => "Open lessons",
            Self::RestoreSession => "Open a session",
            Self::SaveSession => "Save the session",
            Self::LoadParams => "Load parameters",
            Self::SaveParams => "Save parameters",
            Self::Export(kind) => kind.label(),
        }
    }

    /// Whether a file is to be written.
    pub fn saves(self) -> bool {
        matches!(self, Self::SaveSession | Self::SaveParams | Self::Export(_))
    }

    /// Hint of the path field.
    pub fn hint(self) -> &'static str {
        match self {
            Self::OpenFolder
            | Self::OpenFiles
            | Self::OpenPath
            | Self::OpenFolderB
            | Self::OpenFilesB
            | Self::OpenPathB
            | Self::OpenBias
            | Self::OpenFlat
            | Self::OpenGold(_) => "A folder of frames, an image, a multi-page TIFF or a .npy stack",
            Self::OpenDataset => "A folder of bursts (each a folder of frames), or one long sequence of frames",
            Self::OpenEstimate | Self::OpenTruth => {
                "A sparse model (its folder, or a file of it), or a file of lines: timestamp tx ty tz qx qy qz qw"
            }
            Self::ExportDatabase => {
                "A new or an empty folder, or one that was written so before: its features are not found again"
            }
            Self::PaperFigures => "A new or an empty folder, or one with figures: finished ones are kept",
            Self::FeatureFolder => "A new or an empty folder, or one that burstscope colmap wrote",
            Self::OpenFeatures(_) => "A table of features (CSV), or the text that COLMAP imports",
            Self::OpenLessons => "A folder of lessons (TOML files), or one of them",
            Self::RestoreSession | Self::SaveSession => "A session file, such as night.burstscope.toml",
            Self::LoadParams | Self::SaveParams => "A parameter file, such as params.toml",
            Self::Export(_) => "The file to write",
        }
    }

    /// The extensions that the dialog offers; empty for all files.
    pub fn extensions(self) -> Vec<&'static str> {
        match self {
            Self::OpenFolder
            | Self::OpenDataset
            | Self::OpenLessons
            | Self::FeatureFolder
            | Self::PaperFigures
            | Self::ExportDatabase
            | Self::OpenEstimate
            | Self::OpenTruth
            | Self::OpenPath
            | Self::OpenFolderB
            | Self::OpenPathB => Vec::new(),
            Self::OpenFiles | Self::OpenFilesB => [crate::burst::supported_extensions(), vec![CASE_EXTENSION]].concat(),
            Self::OpenBias | Self::OpenFlat | Self::OpenGold(_) => crate::burst::supported_extensions(),
            Self::RestoreSession | Self::SaveSession | Self::LoadParams | Self::SaveParams => vec!["toml"],
            Self::OpenFeatures(_) => vec!["csv", "txt"],
            Self::Export(kind) => vec![kind.extension()],
        }
    }
}
