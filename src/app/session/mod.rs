//! A session: everything needed to restore a view of a burst, as a TOML file. Pixels and features are not stored: the
//! burst is opened again, and the features are detected again, which gives the same bits.

mod restoring;

pub use restoring::Restoring;

use super::document::{Document, Steps};
use crate::app::project::comparison::{Comparison, Reference};
use crate::app::project::datasets::Dataset;
use crate::app::project::pair::{SavedMatch, Side};
use crate::app::project::probe::Probe;
use crate::app::project::trajectories::{SavedTrajectories, Trajectories};
use crate::app::project::workspace::Workspace;
use crate::app::project::{Model, SavedSelection};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::export::case::read_session;
use crate::matching::MatchParams;
use crate::matching::params::doc;
use crate::requests::BurstSource;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::Display;
use std::path::{Path, PathBuf};

const VERSION: u32 = 4;

/// The document, the sources of what is open, and what its answers are found again by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    version: u32,
    /// Last steps before it was saved automatically; none in a session that the user saved.
    #[serde(default, skip_serializing_if = "Steps::is_empty")]
    pub did: Steps,
    pub burst: BurstSource,
    #[serde(default = "Document::of_new_window")]
    pub document: Document,
    #[serde(default)]
    pub detected: bool,
    pub selection: Option<SavedSelection>,
    pub gold: Option<BurstSource>,
    #[serde(default)]
    pub second: SecondBurst,
    pub dataset: Option<SavedDataset>,
    pub trajectories: Option<SavedTrajectories>,
}

/// Burst that is open as B, with what was asked about it. Panes of both bursts wait for it in the document while there
/// is none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SecondBurst {
    pub burst: Option<BurstSource>,
    pub gold: Option<BurstSource>,
    pub selection: Option<SavedMatch>,
}

impl Session {
    pub fn of(model: &Model) -> Option<Self> {
        let burst = absolute(&model.slots.a.burst.as_ref()?.source);
        let second = SecondBurst {
            burst: model.slots.b.burst.as_ref().map(|open| absolute(&open.source)),
            gold: gold_source(model, Side::B),
            selection: model.pair.saved_match(),
        };
        Some(Self {
            version: VERSION,
            did: Steps::new(),
            burst,
            document: sound(model),
            detected: model.slots.a.found.is_some(),
            selection: model.saved_selection(),
            gold: gold_source(model, Side::A),
            second,
            dataset: model.datasets.open.as_ref().map(saved_dataset),
            trajectories: saved_trajectories(&model.trajectories),
        })
    }

    /// The session for a case: of its frames alone, without what lies in other files.
    pub fn for_case(mut self) -> Self {
        let workspace = self.document.workspace;
        if !matches!(workspace, Workspace::Inspect | Workspace::Methods | Workspace::Lab) {
            self.document.workspace = Workspace::Inspect;
        }
        self.document.calibration = OpenOptions::default();
        if self.document.probe.side == Side::B {
            self.document.probe = Probe::default();
        }
        let comparisons = &mut self.document.comparisons;
        comparisons.b = Comparison::default();
        (comparisons.a.with, comparisons.a.file) = (comparisons.a.with.filter(|with| *with != Reference::File), None);
        Self {
            burst: BurstSource::Paths(Vec::new()),
            gold: None,
            second: SecondBurst::default(),
            dataset: None,
            trajectories: None,
            ..self
        }
    }

    pub fn in_case(path: &Path) -> Result<Option<Self>, String> {
        let Some(text) = read_session(path).map_err(|error| error.to_string())? else { return Ok(None) };
        let session = Self::from_toml(&text).map_err(|error| format!("{error}: {}", path.display()))?;
        Ok(Some(Self { burst: BurstSource::Paths(vec![path.to_owned()]), ..session.for_case() }))
    }

    pub fn to_toml(&self) -> String {
        let body = toml::to_string(self).expect("a session is plain values, which TOML can always hold");
        format!("# A Burstscope session: open it with File > Open session.\n{body}")
    }

    pub fn from_toml(text: &str) -> Result<Self, String> {
        // The version is checked first: the other contents of another version are unknown here.
        #[derive(Deserialize)]
        struct Head {
            version: u32,
        }
        if let Ok(Head { version }) = toml::from_str(text)
            && version != VERSION
        {
            let which = if version > VERSION { "a newer Burstscope" } else { "the Burstscope that wrote it" };
            return Err(format!(
                "the session file has version {version}, this program reads {VERSION}; open it with {which}"
            ));
        }
        let (mut session, unknown) =
            read_noting_unknown_keys::<Self>(text).map_err(|error| format!("this is not a session file: {error}"))?;
        if !unknown.is_empty() {
            return Err(format!("the session file has unknown keys: {}; remove or correct them", unknown.join(", ")));
        }
        session.check().map_err(|error| format!("the session file cannot be used: {error}"))?;
        let document = &mut session.document;
        document.look.ranges = document.look.ranges.sanitised();
        document.match_look = document.match_look.sanitised();
        document.methods = std::mem::take(&mut document.methods).sanitised();
        Ok(session)
    }

    /// Numbers that decide what is computed. Those of panes, views and ranges are brought into range where used.
    pub fn check(&self) -> Result<(), String> {
        fn named<E: Display>(key: &str, checked: Result<(), E>) -> Result<(), String> {
            checked.map_err(|error| format!("{key}: {error}"))
        }
        let (second, document) = (&self.second, &self.document);
        for (key, source) in [
            ("burst", Some(&self.burst)),
            ("gold", self.gold.as_ref()),
            ("second.burst", second.burst.as_ref()),
            ("second.gold", second.gold.as_ref()),
        ] {
            named(key, source.map_or(Ok(()), BurstSource::check))?;
        }
        for (key, search) in [
            ("document.params", Some(document.search())),
            ("document.comparisons.a.pinned", document.comparisons.a.pinned.clone()),
            ("document.comparisons.b.pinned", document.comparisons.b.pinned.clone()),
        ] {
            named(key, search.map_or(Ok(()), |search| search.validate()))?;
        }
        named("document.matching", doc::ALL.iter().try_for_each(|record| record.check(&document.matching)))?;
        named("document.look", document.look.check())?;
        let set_up = document.set_up;
        named("document.set_up", if set_up.reads_depths { set_up.values.check() } else { Ok(()) })?;
        named("document.lab.planted", document.lab.planted.check())
    }

    /// Takes all but what waits for the second burst.
    pub fn apply(&self, model: &mut Model) {
        self.apply_without_burst(model);
        model.panes = self.document.panes.clone();
        model.reselect = self.selection;
        model.keep_methods_arranged();
        self.restore_probe(Side::A, model);
        model.restore_comparison(Side::A, self.document.comparisons.a.clone());
        model.check_params();
    }

    /// The panes, and the colours of the window, stay.
    pub fn apply_without_burst(&self, model: &mut Model) {
        let now = std::mem::take(&mut model.document);
        let Document { panes, theme, probe, comparisons, .. } = now;
        let (selected, playing) = (None, false);
        model.document = Document { panes, theme, probe, comparisons, selected, playing, ..self.document.clone() };
    }

    fn restore_probe(&self, side: Side, model: &mut Model) {
        model.clear_probe_of(side);
        if self.document.probe.side == side {
            model.clear_probe();
            model.probe = self.document.probe;
        }
    }

    /// Takes what waits for the second burst, which is open now, or closed for good.
    pub fn apply_second(&self, model: &mut Model) {
        model.panes = self.document.panes.clone();
        if self.second.burst.is_none() {
            model.panes.close_side(Side::B);
            model.panes.take_placed(Workspace::Pair, &self.document.panes);
        }
        model.pair.reselect = self.second.selection;
        self.restore_probe(Side::B, model);
        model.restore_comparison(Side::B, self.document.comparisons.b.clone());
        model.check_params();
        model.check_pair();
    }
}

/// The document with absolute paths; where what is typed makes no sense, the last that did: a session could not be
/// opened again.
fn sound(model: &Model) -> Document {
    let mut document = model.document.clone();
    document.calibration = absolute_calibration(&document.calibration);
    for side in Side::BOTH {
        let file = &mut document.comparisons[side].file;
        *file = file.as_deref().map(absolute_path);
    }
    if document.search().validate().is_err() {
        document.params = model.slots.a.usable_params.clone();
    }
    document.set_up.reads_depths &= document.set_up.values.check().is_ok();
    for record in doc::ALL {
        if record.check(&document.matching).is_err() {
            // The text of a value can be read.
            let _ = record.read(&mut document.matching, &record.text(&MatchParams::default()));
        }
    }
    document
}

/// Unknown keys are paths: `pair.links.vews`. Types that deny unknown keys themselves fail at once.
fn read_noting_unknown_keys<T: DeserializeOwned>(text: &str) -> Result<(T, Vec<String>), toml::de::Error> {
    let mut unknown = Vec::new();
    let value = serde_ignored::deserialize(toml::Deserializer::parse(text)?, |path| unknown.push(path.to_string()))?;
    Ok((value, unknown))
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedDataset {
    pub source: DatasetSource,
    pub folder: Option<PathBuf>,
    pub a: Option<usize>,
    pub b: Option<usize>,
}

fn gold_source(model: &Model, side: Side) -> Option<BurstSource> {
    model.compare.gold[side as usize].as_ref().map(|gold| absolute(&gold.source))
}

/// `source` with absolute paths, so that the session can be opened from any folder.
pub fn absolute(source: &BurstSource) -> BurstSource {
    match source {
        BurstSource::Demo | BurstSource::DemoLater | BurstSource::Example(_) | BurstSource::Chart(_) => source.clone(),
        BurstSource::DarkCopy { of, noise } => BurstSource::DarkCopy { of: Box::new(absolute(of)), noise: *noise },
        BurstSource::Planted { of, study, seed } => {
            BurstSource::Planted { of: Box::new(absolute(of)), study: study.clone(), seed: *seed }
        }
        BurstSource::Paths(paths) => BurstSource::Paths(paths.iter().map(|p| absolute_path(p)).collect()),
    }
}

fn absolute_calibration(options: &OpenOptions) -> OpenOptions {
    let absolute = |path: &Option<PathBuf>| path.as_deref().map(absolute_path);
    OpenOptions { bias: absolute(&options.bias), flat: absolute(&options.flat), ..options.clone() }
}

fn absolute_path(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

fn saved_trajectories(trajectories: &Trajectories) -> Option<SavedTrajectories> {
    let compared = &trajectories.compared;
    let path = |read: &Option<(PathBuf, _)>| read.as_ref().map(|(path, _)| absolute_path(path));
    (!trajectories.is_empty()).then(|| SavedTrajectories {
        estimate: path(&compared.estimate),
        truth: path(&compared.truth),
        projection: trajectories.projection,
    })
}

fn saved_dataset(dataset: &Dataset) -> SavedDataset {
    let mut source = dataset.source.clone();
    source.paths.iter_mut().for_each(|p| *p = absolute_path(p));
    let [a, b] = dataset.pair;
    SavedDataset { source, folder: dataset.folder.as_deref().map(absolute_path), a, b }
}
