//! A session: what is needed to come back to the same view of the same burst, as a TOML file.
//!
//! Pixels and features are not kept: the burst is opened again from where it was, and the features are found again,
//! which gives the same bits. The selected feature is then found again by its place.

use super::canvas::{View, overlay::ColourBy};
use super::dataset::{Dataset, Trajectories};
use super::pane::{Content, PaneId, SavedPanes};
use crate::app::project::compare::CompareLook;
use crate::app::project::cursor::Cursor;
use crate::app::project::filter::{Column, Filter};
use crate::app::project::look::Look;
use crate::app::project::order::Order;
use crate::app::project::pair::{Links, MatchColumn, MatchLook, SavedMatch, Side};
use crate::app::project::probe::SavedProbe;
use crate::app::project::workspace::Workspace;
use crate::app::project::{BottomTab, Model, SavedSelection};
use crate::dataset::DatasetSource;
use crate::detector::SearchParams;
use crate::engine::BurstSource;
use crate::evaluate::poses::Projection;
use crate::matching::MatchParams;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The version that this program writes; it reads this and older ones.
const VERSION: u32 = 2;

/// The dataset of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedDataset {
    /// Where its bursts come from.
    pub source: DatasetSource,
    /// Where its features are kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub folder: Option<PathBuf>,
    /// The places of the bursts that were A and B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a: Option<usize>,
    #[allow(missing_docs)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub b: Option<usize>,
}

/// The trajectories of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedTrajectories {
    /// Where the estimate is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimate: Option<PathBuf>,
    /// Where the truth is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<PathBuf>,
    /// From which side they were seen.
    #[serde(default)]
    pub projection: Projection,
}

/// What a session file holds. A missing field has its default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    /// Version of the file's form.
    version: u32,
    /// Where the burst comes from.
    pub burst: BurstSource,
    /// By what features are coloured.
    #[serde(default)]
    pub colour_by: ColourBy,
    /// The tab below the picture.
    #[serde(default)]
    pub bottom_tab: BottomTab,
    /// Whether features were there, so that they are to be found again.
    #[serde(default)]
    pub detected: bool,
    /// The detector's parameters, and how the slopes are chosen; older files give them.
    #[serde(default)]
    pub params: SearchParams,
    /// Where the cursor of A's own pane was.
    #[serde(default)]
    pub scrub: Cursor,
    /// Its pan and zoom.
    #[serde(default)]
    pub view: View,
    /// The panes of the inspector, since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub panes: Option<SavedPanes>,
    /// Ranges, maps and overlay.
    #[serde(default)]
    pub look: Look,
    /// Which features were shown.
    #[serde(default)]
    pub filter: Filter,
    /// The table's order.
    #[serde(default)]
    pub order: Order<Column>,
    /// The selected feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub selection: Option<SavedSelection>,
    /// The place that is probed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe: Option<SavedProbe>,
    /// The dataset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dataset: Option<SavedDataset>,
    /// The trajectories.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectories: Option<SavedTrajectories>,
    /// The workspace that was open.
    #[serde(default, alias = "room")]
    pub workspace: Workspace,
    /// The second burst and the matches.
    #[serde(default)]
    pub pair: PairSession,
    /// Which methods were compared, and how.
    #[serde(default)]
    pub methods: CompareLook,
    /// Where the gold standard comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gold: Option<BurstSource>,
}

/// What a session file holds of the second burst and the matches.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PairSession {
    /// Where the second burst comes from, if one was open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<BurstSource>,
    /// Where its gold standard comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gold: Option<BurstSource>,
    /// Whose cursor moved.
    pub active: Side,
    /// What moved together.
    pub links: Links,
    /// The parameters of matching.
    pub params: MatchParams,
    /// Where B's cursor was.
    pub scrub: Cursor,
    /// B's pan and zoom.
    pub view: View,
    /// B's ranges and maps, where they were its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look: Option<Look>,
    /// How matches looked.
    pub match_look: MatchLook,
    /// The table's order.
    pub order: Order<MatchColumn>,
    /// The selected match.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub selection: Option<SavedMatch>,
}

impl PairSession {
    fn of(model: &Model) -> Self {
        let (pair, pane) = (&model.pair, model.panes.of(Side::B));
        Self {
            burst: pair.b.burst.as_ref().map(|open| absolute(&open.source)),
            gold: gold_source(model, Side::B),
            active: pair.active,
            links: pair.links,
            params: pair.params.clone(),
            scrub: pane.cursor,
            view: pane.view,
            look: pane.own_ranges.map(|ranges| Look { ranges, ..Look::default() }),
            match_look: pair.look,
            order: pair.order,
            selection: pair.saved_match(),
        }
    }

    /// Puts what it holds into the model, whose second burst (if there was one) was just opened.
    pub fn apply(&self, model: &mut Model) {
        let pair = &mut model.pair;
        (pair.active, pair.links, pair.params) = (self.active, self.links, self.params.clone());
        (pair.look, pair.order, pair.reselect) = (self.match_look.sanitised(), self.order, self.selection);
        model.link_ranges(self.links.ranges);
        let pane = model.panes.of_mut(Side::B);
        (pane.cursor, pane.slope_chosen, pane.view) = (self.scrub, true, self.view);
        if let (Some(own), Some(look)) = (&mut pane.own_ranges, &self.look) {
            *own = look.ranges;
        }
        model.check_pair();
    }
}

impl Session {
    /// The session of what is on show; `None` without a burst.
    pub fn of(model: &Model) -> Option<Self> {
        let (burst, pane) = (model.burst.as_ref()?, model.panes.of(Side::A));
        Some(Self {
            version: VERSION,
            burst: absolute(&burst.source),
            colour_by: model.colour_by,
            bottom_tab: model.bottom_tab,
            detected: model.found.is_some(),
            params: model.asked(),
            scrub: pane.cursor,
            view: pane.view,
            panes: Some(SavedPanes::of(&model.panes)),
            look: model.look.clone(),
            filter: model.filter,
            order: model.order,
            selection: model.saved_selection(),
            probe: model.probe.saved(),
            workspace: model.workspace,
            pair: PairSession::of(model),
            methods: model.compare.look.clone(),
            gold: gold_source(model, Side::A),
            dataset: model.datasets.open.as_ref().map(saved_dataset),
            trajectories: saved_trajectories(&model.trajectories),
        })
    }

    /// The file's text, which [`Session::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        let body = toml::to_string(self).expect("a session is plain values, which TOML can always hold");
        format!("# A Burstscope session: open it with File > Open session.\n{body}")
    }

    /// Reads a session file's text.
    ///
    /// # Errors
    /// What is wrong and where, as TOML's reader says it, or that the file is from a newer version.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        // The version comes first: what a newer file holds besides cannot be known here.
        #[derive(Deserialize)]
        struct Head {
            version: u32,
        }
        if let Ok(Head { version }) = toml::from_str(text)
            && version > VERSION
        {
            return Err(format!(
                "the session file has version {version}, this program reads up to {VERSION}; open it with a newer Burstscope"
            ));
        }
        let mut session: Self = toml::from_str(text).map_err(|e| format!("this is not a session file: {e}"))?;
        session.look.ranges = session.look.ranges.sanitised();
        if let Some(look) = &mut session.pair.look {
            look.ranges = look.ranges.sanitised();
        }
        Ok(session)
    }

    /// Puts what the session holds into the model, whose burst was just opened.
    pub fn apply(&self, model: &mut Model) {
        model.set_search(self.params.clone());
        let pane = model.panes.of_mut(Side::A);
        (pane.cursor, pane.slope_chosen, pane.view, pane.content) = (self.scrub, true, self.view, Content::Cursor);
        match &self.panes {
            Some(panes) => panes.apply(&mut model.panes),
            None => model.panes.show_alone(PaneId::of(Side::A)),
        }
        model.look = self.look.clone();
        model.filter = self.filter;
        model.order = self.order;
        model.colour_by = self.colour_by;
        model.bottom_tab = self.bottom_tab;
        model.reselect = self.selection;
        model.workspace = self.workspace;
        model.compare.look = self.methods.clone().sanitised();
        model.restore_probe(self.probe);
        model.check_params();
    }
}

fn gold_source(model: &Model, side: Side) -> Option<BurstSource> {
    model.compare.gold[side as usize].as_ref().map(|gold| absolute(&gold.open.source))
}

/// The same source with absolute paths, so that the session can be opened from any folder.
fn absolute(source: &BurstSource) -> BurstSource {
    match source {
        BurstSource::Demo | BurstSource::DemoLater | BurstSource::Example(_) => source.clone(),
        BurstSource::Paths(paths) => BurstSource::Paths(paths.iter().map(|p| absolute_path(p)).collect()),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Burst;
    use crate::detector::Slope;
    use crate::engine::OpenBurst;
    use crate::plane::Plane;
    use proptest::prelude::*;

    fn model() -> Model {
        let mut model = Model::default();
        let burst = Burst::from_planes("test", vec![Plane::zeros(64, 48), Plane::zeros(64, 48)]);
        model.take_burst(OpenBurst::new(burst, BurstSource::Paths(vec!["frames".into()])));
        model.params.peak_threshold = 0.01;
        model.focused_mut().cursor.slope = Slope::new(1.25, -0.5);
        model.filter.hide_slope_limit = true;
        model.look.motion_vectors = false;
        model
    }

    #[test]
    fn a_session_comes_back_as_it_was() {
        let session = Session::of(&model()).expect("a burst is open");
        let text = session.to_toml();
        assert_eq!(Session::from_toml(&text).as_ref(), Ok(&session), "{text}");
        assert!(matches!(&session.burst, BurstSource::Paths(paths) if paths[0].is_absolute()));
        let mut restored = Model::default();
        session.apply(&mut restored);
        assert_eq!(restored.params.peak_threshold, 0.01);
        assert_eq!(restored.cursor().slope, Slope::new(1.25, -0.5));
        assert!(!restored.look.motion_vectors && restored.filter.hide_slope_limit);
    }

    #[test]
    fn without_a_burst_there_is_no_session() {
        assert!(Session::of(&Model::default()).is_none());
    }

    #[test]
    fn what_is_not_a_session_is_said() {
        for text in ["", "hello", "version = 1", "peak_threshold = 0.1", "version = 99\nburst = \"demo\""] {
            let error = Session::from_toml(text).expect_err(text);
            assert!(error.contains("session"), "{error}");
        }
        assert!(Session::from_toml("version = 1\nburst = \"demo\"").is_ok());
    }

    proptest! {
        #[test]
        fn no_text_makes_it_panic(text in ".{0,400}") {
            let _ = Session::from_toml(&text);
        }

        #[test]
        fn no_damaged_session_makes_it_panic(at in 0usize..2000, junk in "[a-z0-9=\\[\\]\"{}.\\-]{0,6}") {
            let mut text = Session::of(&model()).expect("a burst is open").to_toml();
            let mut at = at.min(text.len());
            while !text.is_char_boundary(at) { at -= 1; }
            text.insert_str(at, &junk);
            if let Ok(session) = Session::from_toml(&text) {
                let mut model = model();
                session.apply(&mut model);
                prop_assert!(model.cursor().slope.u.is_finite());
            }
        }
    }
}
