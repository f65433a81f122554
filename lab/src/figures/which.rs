//! The figures and tables of the paper, by name.

use super::charts::{FramesFigure, RocFigure, TestTarget};
use super::matching::MatchingInTheDark;
use super::pictures::{Failures, Light};
use super::reconstruction::{ReconstructionFigure, Shown};
use super::{MakeFigure, apparent_motion::ApparentMotion, architecture::Architecture};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A figure or table of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)] // each is described by its title
pub enum PaperFigure {
    Fig1,
    Fig2,
    Fig3,
    Fig4,
    Fig5,
    Fig6,
    Fig7,
    Fig8,
    Fig9,
    Table1,
    Table2,
    Table3,
}

/// Size of the material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FigureSize {
    /// Charts and trajectories large enough for meaningful numbers.
    #[default]
    Full,
    /// Material so small that everything is made in a minute: for a preview, not for numbers.
    Quick,
}

impl FigureSize {
    pub(super) fn pick<T>(self, full: T, quick: T) -> T {
        if self == Self::Full { full } else { quick }
    }
}

impl PaperFigure {
    /// All figures, in the order in which they are made and shown.
    pub const ALL: [Self; 12] = {
        use PaperFigure::*;
        [Fig1, Fig2, Fig3, Fig4, Fig5, Fig6, Fig7, Fig9, Table1, Table2, Fig8, Table3]
    };

    /// Name on the command line, and of its files.
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// Title, with its number in the paper.
    pub fn title(self) -> &'static str {
        self.words().1
    }

    /// Name and title.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Fig1 => ("fig1", "Fig. 1: matching in the dark"),
            Self::Fig2 => ("fig2", "Fig. 2: apparent motion"),
            Self::Fig3 => ("fig3", "Fig. 3: the architecture"),
            Self::Fig4 => ("fig4", "Fig. 4: the test target"),
            Self::Fig5 => ("fig5", "Fig. 5: true against false features"),
            Self::Fig6 => ("fig6", "Fig. 6: the number of frames"),
            Self::Fig7 => ("fig7", "Fig. 7: bright, gold and dark frames"),
            Self::Fig8 => ("fig8", "Fig. 8: trajectories"),
            Self::Fig9 => ("fig9", "Fig. 9: failure cases"),
            Self::Table1 => ("table1", "Table 1: matching and reconstruction"),
            Self::Table2 => ("table2", "Table 2: errors of the camera poses"),
            Self::Table3 => ("table3", "Table 3: time"),
        }
    }

    /// Caption of the figure.
    pub fn caption(self) -> &'static str {
        match self {
            Self::Fig1 => {
                "Two neighbouring bursts of a dark scene. SIFT on one frame of each finds noise; the burst features match. \
                 A match is right (blue) when it lies within 4 px of where the point of the scene is truly seen in the other view."
            }
            Self::Fig2 => {
                "Features followed from frame to frame in a burst in good light, each frame searched by itself: what they go along is \
                 close to a line at constant speed, horizontal when the camera goes sideways, in all directions when it goes forward."
            }
            Self::Fig3 => {
                "The detector's own intermediate results on the demo burst: frames, the motion stack, its differences of Gaussians, the \
                 response over slope and scale at one place, the features."
            }
            Self::Fig4 => {
                "A chart of discs, the upper left part of it, with what each method finds at the threshold where a tenth of its detections is \
                 false: blue circles find a disc, orange ones do not."
            }
            Self::Fig5 => {
                "Discs found against false features as the threshold falls. The grey line is where a tenth of the detections is false, \
                 the dot what the method finds at its default threshold (noise gate strict)."
            }
            Self::Fig6 => "What more frames are worth, at one signal-to-noise ratio. Bars are standard errors.",
            Self::Fig7 => {
                "A view of the scene of Fig. 1 and the tables: a frame in good light, the gold standard (no noise), a frame in the dark as \
                 it is recorded, and the same with its contrast stretched."
            }
            Self::Fig8 => {
                "The camera's way, seen along the direction in which it spreads least: the true places and those that COLMAP found with the features of \
                 each method, after a similarity alignment."
            }
            Self::Fig9 => {
                "Top: periodic lamps answer at a slope at which nothing moves (aliasing). Bottom: discs of falling contrast; what is fainter \
                 than the noise allows is not found."
            }
            Self::Table1 => {
                "Features and their matches with all other images of a trajectory, as means over images and trajectories, and what COLMAP makes of them."
            }
            Self::Table2 => {
                "Mean errors of the reconstructed camera poses against the true ones, after a similarity alignment."
            }
            Self::Table3 => {
                "Time for one trajectory: finding the features, matching them, and COLMAP's mapper, on the machine at hand."
            }
        }
    }

    /// Approximate time, seconds on two idle cores, to weight the progress; shared material counts at its first figure.
    pub(super) fn cost_secs(self, size: FigureSize) -> f32 {
        let full = match self {
            Self::Fig1 => 6.0,
            Self::Fig2 => 6.0,
            Self::Fig3 => 2.0,
            Self::Fig4 => 5.0,
            Self::Fig5 => 60.0,
            Self::Fig6 => 50.0,
            Self::Fig7 => 4.0,
            Self::Fig9 => 2.0,
            Self::Table1 => 330.0,
            Self::Fig8 | Self::Table2 | Self::Table3 => 0.5,
        };
        size.pick(full, full.min(10.0))
    }

    pub(super) fn maker(self, size: FigureSize, colmap: Option<&Path>) -> Box<dyn MakeFigure> {
        let of = |shown| Box::new(ReconstructionFigure::new(shown, size, colmap));
        match self {
            Self::Fig1 => Box::new(MatchingInTheDark::new(size)),
            Self::Fig2 => Box::new(ApparentMotion::new(size)),
            Self::Fig3 => Box::new(Architecture::new(size)),
            Self::Fig4 => Box::new(TestTarget::new(size)),
            Self::Fig5 => Box::new(RocFigure::new(size)),
            Self::Fig6 => Box::new(FramesFigure::new(size)),
            Self::Fig7 => Box::new(Light::new(size)),
            Self::Fig9 => Box::new(Failures),
            Self::Fig8 => of(Shown::Trajectories),
            Self::Table1 => of(Shown::Matching),
            Self::Table2 => of(Shown::Poses),
            Self::Table3 => of(Shown::Time),
        }
    }
}

impl std::str::FromStr for PaperFigure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = text.trim().to_lowercase();
        Self::ALL
            .into_iter()
            .find(|figure| figure.name() == wanted)
            .ok_or_else(|| format!("'{text}' is none of them; give fig1 to fig9 or table1 to table3"))
    }
}
