//! Parts of a session: sources by absolute paths, the second burst and the matches.

use crate::app::canvas::View;
use crate::app::pane::PaneId;
use crate::app::project::Model;
use crate::app::project::against::SavedAgainst;
use crate::app::project::cursor::Cursor;
use crate::app::project::datasets::Dataset;
use crate::app::project::filter::Order;
use crate::app::project::look::Look;
use crate::app::project::pair::{Links, MatchColumn, MatchLook, SavedMatch, Side};
use crate::app::project::probe::SavedProbe;
use crate::app::project::trajectories::Trajectories;
use crate::app::project::workspace::Workspace;
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::evaluate::poses::Projection;
use crate::matching::MatchParams;
use crate::matching::params::doc;
use crate::requests::BurstSource;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedDataset {
    pub source: DatasetSource,
    pub folder: Option<PathBuf>,
    pub a: Option<usize>,
    pub b: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedTrajectories {
    pub estimate: Option<PathBuf>,
    pub truth: Option<PathBuf>,
    #[serde(default)]
    pub projection: Projection,
}

pub(super) fn gold_source(model: &Model, side: Side) -> Option<BurstSource> {
    model.compare.gold[side as usize].as_ref().map(|gold| absolute(&gold.source))
}

pub(super) fn saved_against(model: &Model, side: Side) -> Option<SavedAgainst> {
    let saved = model.saved_against(side)?;
    Some(SavedAgainst { file: saved.file.as_deref().map(absolute_path), ..saved })
}

/// `source` with absolute paths, so that the session can be opened from any folder.
pub(super) fn absolute(source: &BurstSource) -> BurstSource {
    match source {
        BurstSource::Demo | BurstSource::DemoLater | BurstSource::Example(_) | BurstSource::Chart(_) => source.clone(),
        BurstSource::DarkCopy { of, noise } => BurstSource::DarkCopy { of: Box::new(absolute(of)), noise: *noise },
        BurstSource::Planted { of, study, seed } => {
            BurstSource::Planted { of: Box::new(absolute(of)), study: study.clone(), seed: *seed }
        }
        BurstSource::Paths(paths) => BurstSource::Paths(paths.iter().map(|p| absolute_path(p)).collect()),
    }
}

pub(super) fn absolute_calibration(options: &OpenOptions) -> OpenOptions {
    let absolute = |path: &Option<PathBuf>| path.as_deref().map(absolute_path);
    OpenOptions { bias: absolute(&options.bias), flat: absolute(&options.flat), ..options.clone() }
}

pub(super) fn absolute_path(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

pub(super) fn saved_trajectories(trajectories: &Trajectories) -> Option<SavedTrajectories> {
    let compared = &trajectories.compared;
    let path = |read: &Option<(PathBuf, _)>| read.as_ref().map(|(path, _)| absolute_path(path));
    (!trajectories.is_empty()).then(|| SavedTrajectories {
        estimate: path(&compared.estimate),
        truth: path(&compared.truth),
        projection: trajectories.projection,
    })
}

pub(super) fn saved_dataset(dataset: &Dataset) -> SavedDataset {
    let mut source = dataset.source.clone();
    source.paths.iter_mut().for_each(|p| *p = absolute_path(p));
    let [a, b] = dataset.pair;
    SavedDataset { source, folder: dataset.folder.as_deref().map(absolute_path), a, b }
}

/// Parameters of matching with the default for each number that makes no sense: a session could not be opened again.
fn sound(mut params: MatchParams) -> MatchParams {
    for record in doc::ALL {
        if record.check(&params).is_err() {
            // The text of a value can be read.
            let _ = record.read(&mut params, &record.text(&MatchParams::default()));
        }
    }
    params
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PairSession {
    pub burst: Option<BurstSource>,
    pub gold: Option<BurstSource>,
    pub probe: Option<SavedProbe>,
    pub against: Option<SavedAgainst>,
    pub active: Side,
    pub links: Links,
    pub params: MatchParams,
    pub scrub: Cursor,
    pub view: View,
    pub look: Option<Look>,
    pub match_look: MatchLook,
    pub order: Order<MatchColumn>,
    pub selection: Option<SavedMatch>,
}

impl PairSession {
    pub(super) fn of(model: &Model) -> Self {
        let (pair, pane) = (&model.pair, model.panes.of(Side::B));
        Self {
            burst: model.slots.b.burst.as_ref().map(|open| absolute(&open.source)),
            gold: gold_source(model, Side::B),
            probe: model.probe.saved(Side::B),
            against: saved_against(model, Side::B),
            active: model.panes.get(model.panes.placed_in(Workspace::Pair).1).map_or(Side::A, |pane| pane.side),
            links: model.pair_links(),
            params: sound(pair.params.clone()),
            scrub: pane.cursor,
            view: pane.view,
            look: pane.own_ranges.map(|ranges| Look { ranges, ..Look::default() }),
            match_look: pair.look,
            order: pair.order,
            selection: pair.saved_match(),
        }
    }

    pub fn apply(&self, model: &mut Model) {
        let pair = &mut model.pair;
        pair.params = self.params.clone();
        (pair.look, pair.order, pair.reselect) = (self.match_look.sanitised(), self.order, self.selection);
        model.set_pair_links(self.links);
        model.panes.set_focus_in(Workspace::Pair, PaneId::of(self.active));
        let pane = model.panes.of_mut(Side::B);
        (pane.cursor, pane.slope_chosen, pane.view) = (self.scrub, true, self.view);
        if let (Some(own), Some(look)) = (&mut pane.own_ranges, &self.look) {
            *own = look.ranges;
        }
        model.restore_probe(Side::B, self.probe);
        model.restore_against(Side::B, self.against.clone());
        model.check_pair();
    }
}
