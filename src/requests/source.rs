//! Source of a burst.

use crate::synth::{ChartParams, Example, NoisyParams};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Source of a burst.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BurstSource {
    /// The demo burst that is built into the program.
    Demo,
    /// The second built-in demo burst: the same street a little later.
    DemoLater,
    /// A built-in example of a failure.
    Example(Example),
    /// A chart of discs whose truth is known.
    Chart(Box<ChartParams>),
    /// A copy of another burst with the noise of less light.
    DarkCopy {
        /// The burst that is copied.
        of: Box<BurstSource>,
        /// Light and noise of the copy.
        noise: NoisyParams,
    },
    /// A folder of frames, image files, a multi-page TIFF, or a `.npy` stack.
    Paths(Vec<PathBuf>),
}

impl BurstSource {
    /// The bursts that are built into the program.
    pub fn built_in() -> Vec<Self> {
        [Self::Demo, Self::DemoLater].into_iter().chain(Example::ALL.map(Self::Example)).collect()
    }

    /// Name on the command line and in lessons; `None` for bursts that are not built in.
    pub fn name(&self) -> Option<&'static str> {
        match self {
            Self::Demo => Some("demo"),
            Self::DemoLater => Some("demo-later"),
            Self::Example(example) => Some(example.name()),
            Self::Chart(_) | Self::DarkCopy { .. } | Self::Paths(_) => None,
        }
    }

    /// The burst that is built into the program under this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::built_in().into_iter().find(|source| source.name() == Some(name))
    }

    /// A name for menus and messages: the last part of the (first) path.
    pub fn label(&self) -> String {
        match self {
            Self::Demo => "Demo burst".to_owned(),
            Self::DemoLater => "Later demo burst".to_owned(),
            Self::Example(example) => example.label().to_owned(),
            Self::Chart(chart) => format!("Chart, SNR {}, seed {}", chart.snr, chart.seed),
            Self::DarkCopy { of, noise } => format!("{}, dark copy at SNR {}", of.label(), noise.snr),
            Self::Paths(paths) => match paths.as_slice() {
                [] => "nothing".to_owned(),
                [one] => one.file_name().unwrap_or(one.as_os_str()).to_string_lossy().into_owned(),
                [first, rest @ ..] => {
                    let name = first.file_name().unwrap_or(first.as_os_str()).to_string_lossy();
                    format!("{name} and {} more", rest.len())
                }
            },
        }
    }
}
