//! Source of a burst, and how the burst is read or made from it: the same for the window and the commands.

use crate::burst::{Burst, Info, OpenOptions, files_at};
use crate::detector::open_burst;
use crate::error::Error;
use crate::export::case::{is_case, read_case};
use crate::monitor::Monitor;
use crate::recover::RecoverStudy;
use crate::synth::{ChartParams, Example, FrameLevels, NoisyParams, Truth, demo_burst, later_demo_burst, synth_chart};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BurstSource {
    Demo,
    DemoLater,
    Example(Example),
    Chart(Box<ChartParams>),
    DarkCopy { of: Box<BurstSource>, noise: NoisyParams },
    Planted { of: Box<BurstSource>, study: Box<RecoverStudy>, seed: u64 },
    Paths(Vec<PathBuf>),
}

pub fn make_absolute(path: &mut PathBuf) {
    if let Ok(absolute) = std::path::absolute(&*path) {
        *path = absolute;
    }
}

impl BurstSource {
    /// The same with absolute paths, so that it can be opened from any folder.
    #[must_use]
    pub fn absolute(&self) -> Self {
        let mut source = self.clone();
        let mut inner = &mut source;
        // A copy may be made of a copy: the paths lie innermost.
        while let Self::DarkCopy { of, .. } | Self::Planted { of, .. } = inner {
            inner = of;
        }
        if let Self::Paths(paths) = inner {
            paths.iter_mut().for_each(make_absolute);
        }
        source
    }

    pub fn built_in() -> Vec<Self> {
        [Self::Demo, Self::DemoLater].into_iter().chain(Example::ALL.map(Self::Example)).collect()
    }

    /// Name on the command line and in lessons; `None` for bursts that are not built in.
    pub fn name(&self) -> Option<&'static str> {
        match self {
            Self::Demo => Some("demo"),
            Self::DemoLater => Some("demo-later"),
            Self::Example(example) => Some(example.name()),
            Self::Chart(_) | Self::DarkCopy { .. } | Self::Planted { .. } | Self::Paths(_) => None,
        }
    }

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
            Self::Planted { of, seed, .. } => format!("{} with things planted, {seed}", of.label()),
            Self::Paths(paths) => {
                let Some((first, rest)) = paths.split_first() else { return "nothing".to_owned() };
                let name = first.file_name().unwrap_or(first.as_os_str()).to_string_lossy();
                if rest.is_empty() { name.into_owned() } else { format!("{name} and {} more", rest.len()) }
            }
        }
    }

    /// Paths that the burst is read from; none for a burst that is made.
    pub fn paths(&self) -> &[PathBuf] {
        match self {
            Self::Paths(paths) => paths,
            Self::DarkCopy { of, .. } | Self::Planted { of, .. } => of.paths(),
            Self::Demo | Self::DemoLater | Self::Example(_) | Self::Chart(_) => &[],
        }
    }

    /// Files that the burst is read from. Paths that cannot be listed are given as they are.
    pub fn files(&self) -> Vec<PathBuf> {
        files_at(self.paths()).unwrap_or_else(|_| self.paths().to_vec())
    }

    /// Arguments that name the burst on the command line; `None` for a burst that lies in no file.
    pub fn arguments(&self) -> Option<Vec<String>> {
        match self {
            Self::Paths(paths) => Some(paths.iter().map(|path| path.display().to_string()).collect()),
            _ => self.name().map(|name| vec![name.to_owned()]),
        }
    }

    pub fn check(&self) -> Result<(), Error> {
        match self {
            Self::Demo | Self::DemoLater | Self::Example(_) | Self::Paths(_) => Ok(()),
            Self::Chart(chart) => chart.check(),
            Self::DarkCopy { of, noise } => noise.check().and_then(|()| of.check()),
            Self::Planted { of, study, .. } => study.check().and_then(|()| of.check()),
        }
    }

    /// Describes the burst; one that is built in or lies in a case is made or read for that.
    pub fn info(&self, options: &OpenOptions, monitor: &Monitor) -> Result<Info, Error> {
        let kind = match self {
            Self::Paths(paths) if matches!(&paths[..], [path] if is_case(path)) => "case",
            Self::Paths(paths) => return Info::of(paths, options, monitor),
            _ => "made by Burstscope",
        };
        Ok(Info::of_burst(&self.burst(options, monitor)?, kind))
    }

    /// Reads or makes the burst on the calling thread, with the calibration in `options`; built-in bursts need none.
    pub fn burst(&self, options: &OpenOptions, monitor: &Monitor) -> Result<Burst, Error> {
        Ok(self.burst_and_planted(options, monitor)?.0)
    }

    pub(super) fn burst_and_planted(
        &self,
        options: &OpenOptions,
        monitor: &Monitor,
    ) -> Result<(Burst, Option<Truth>), Error> {
        let mut planted = None;
        let burst = match self {
            Self::Demo => demo_burst(),
            Self::DemoLater => later_demo_burst(),
            Self::Example(example) => example.burst(),
            Self::Chart(chart) => Burst { name: self.label(), ..synth_chart(chart, monitor)?.0 },
            Self::DarkCopy { of, noise } => {
                let clear = of.burst(options, monitor)?;
                let mut levels = FrameLevels::default();
                levels.add(&clear, monitor)?;
                let copy = noise.exposure(&levels)?.capture(&clear, noise.seed, 0, monitor)?;
                // The copy is none of the files that the original was read from.
                Burst { name: self.label(), sources: Vec::new(), ..copy }
            }
            Self::Planted { of, study, seed } => {
                let whole = of.burst(options, &monitor.part(0.0, 0.3))?;
                let (copy, truth) = study.planted_copy(&whole, *seed, &monitor.part(0.3, 0.7))?;
                planted = Some(truth);
                Burst { name: self.label(), ..copy }
            }
            Self::Paths(paths) => match paths.as_slice() {
                [path] if is_case(path) => read_case(path, &options.limits, monitor)?.1,
                paths => open_burst(paths, options, monitor)?,
            },
        };
        monitor.check()?;
        Ok((burst, planted))
    }
}
