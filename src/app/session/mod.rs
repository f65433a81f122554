//! A session: everything needed to restore a view of a burst, as a TOML file. Pixels and features are not stored: the
//! burst is opened again, and the features are detected again, which gives the same bits.

mod restoring;
mod saved;

pub use restoring::Restoring;
pub use saved::{PairSession, SavedDataset, SavedTrajectories};

use super::canvas::View;
use super::canvas::overlay::ColourBy;
use super::document::Steps;
use super::pane::{Content, PaneId, SavedPanes, SavedWorkspaces};
use crate::app::project::against::{SavedAgainst, With};
use crate::app::project::compare::CompareLook;
use crate::app::project::cursor::Cursor;
use crate::app::project::filter::{Filter, Order};
use crate::app::project::lab::Lab;
use crate::app::project::look::Look;
use crate::app::project::pair::Side;
use crate::app::project::probe::SavedProbe;
use crate::app::project::workspace::Workspace;
use crate::app::project::{BottomTab, Model, SavedSelection};
use crate::burst::OpenOptions;
use crate::detector::{Quantity, SearchParams};
use crate::export::case::read_session;
use crate::inspect::set_up::SetUp;
use crate::matching::params::doc;
use crate::recover::RecoverStudy;
use crate::requests::BurstSource;
use saved::{absolute, absolute_calibration, gold_source, saved_against, saved_dataset, saved_trajectories};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::Display;
use std::path::Path;

const VERSION: u32 = 3;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    version: u32,
    /// What was done last, in a session that was saved automatically.
    #[serde(default, skip_serializing_if = "Steps::is_empty")]
    pub did: Steps,
    pub burst: BurstSource,
    #[serde(default, skip_serializing_if = "OpenOptions::is_plain")]
    pub calibration: OpenOptions,
    #[serde(default)]
    pub colour_by: ColourBy,
    pub depths_by: Option<SetUp>,
    #[serde(default)]
    pub bottom_tab: BottomTab,
    #[serde(default)]
    pub detected: bool,
    #[serde(default)]
    pub params: SearchParams,
    #[serde(default)]
    pub scrub: Cursor,
    #[serde(default)]
    pub view: View,
    pub panes: Option<SavedPanes>,
    pub pair_panes: Option<SavedPanes>,
    pub methods_panes: Option<SavedPanes>,
    #[serde(default)]
    pub look: Look,
    #[serde(default)]
    pub filter: Filter,
    #[serde(default)]
    pub order: Order<Quantity>,
    pub selection: Option<SavedSelection>,
    pub probe: Option<SavedProbe>,
    pub against: Option<SavedAgainst>,
    pub dataset: Option<SavedDataset>,
    pub trajectories: Option<SavedTrajectories>,
    #[serde(default)]
    pub workspace: Workspace,
    #[serde(default)]
    pub pair: PairSession,
    #[serde(default)]
    pub methods: CompareLook,
    pub gold: Option<BurstSource>,
    pub planted: Option<RecoverStudy>,
}

impl Session {
    pub fn of(model: &Model) -> Option<Self> {
        let (burst, pane) = (model.slots.a.burst.as_ref()?, model.panes.of(Side::A));
        let [panes, pair_panes, methods_panes] = SavedWorkspaces::of(&model.panes).placed;
        Some(Self {
            version: VERSION,
            did: Steps::new(),
            burst: absolute(&burst.source),
            calibration: absolute_calibration(&model.calibration),
            colour_by: model.colour_by,
            depths_by: model.set_up.depths_by().copied(),
            bottom_tab: model.bottom_tab,
            detected: model.slots.a.found.is_some(),
            params: sound_search(model),
            scrub: pane.cursor,
            view: pane.view,
            panes,
            pair_panes,
            methods_panes,
            look: model.look.clone(),
            filter: model.filter.clone(),
            order: model.order,
            selection: model.saved_selection(),
            probe: model.probe.saved(Side::A),
            against: saved_against(model, Side::A),
            workspace: model.workspace,
            pair: PairSession::of(model),
            methods: model.compare.look.clone(),
            gold: gold_source(model, Side::A),
            dataset: model.datasets.open.as_ref().map(saved_dataset),
            trajectories: saved_trajectories(&model.trajectories),
            planted: Some(model.lab.planted.clone()).filter(|study| *study != Lab::default().planted),
        })
    }

    /// The session for a case: of its frames alone, without what lies in other files.
    pub fn for_case(self) -> Self {
        let of_burst = matches!(self.workspace, Workspace::Inspect | Workspace::Methods | Workspace::Lab);
        let against = self.against.map(|against| SavedAgainst {
            with: against.with.filter(|with| *with != With::File),
            file: None,
            ..against
        });
        Self {
            burst: BurstSource::Paths(Vec::new()),
            calibration: OpenOptions::default(),
            pair_panes: None,
            against: against.filter(|against| *against != SavedAgainst::default()),
            dataset: None,
            trajectories: None,
            workspace: if of_burst { self.workspace } else { Workspace::Inspect },
            pair: PairSession { burst: None, gold: None, probe: None, against: None, ..self.pair },
            gold: None,
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
        session.look.ranges = session.look.ranges.sanitised();
        if let Some(look) = &mut session.pair.look {
            look.ranges = look.ranges.sanitised();
        }
        Ok(session)
    }

    /// Numbers that decide what is computed. Those of panes, views and ranges are brought into range where used.
    pub fn check(&self) -> Result<(), String> {
        fn named<E: Display>(key: &str, checked: Result<(), E>) -> Result<(), String> {
            checked.map_err(|error| format!("{key}: {error}"))
        }
        let pinned = |against: &Option<SavedAgainst>| against.as_ref().and_then(|against| against.pinned.clone());
        let pair = &self.pair;
        for (key, source) in [
            ("burst", Some(&self.burst)),
            ("gold", self.gold.as_ref()),
            ("pair.burst", pair.burst.as_ref()),
            ("pair.gold", pair.gold.as_ref()),
        ] {
            named(key, source.map_or(Ok(()), BurstSource::check))?;
        }
        for (key, search) in [
            ("params", Some(self.params.clone())),
            ("against.pinned", pinned(&self.against)),
            ("pair.against.pinned", pinned(&pair.against)),
        ] {
            named(key, search.map_or(Ok(()), |search| search.validate()))?;
        }
        named("pair.params", doc::ALL.iter().try_for_each(|record| record.check(&pair.params)))?;
        named("look", self.look.check())?;
        named("pair.look", pair.look.as_ref().map_or(Ok(()), Look::check))?;
        named("depths_by", self.depths_by.as_ref().map_or(Ok(()), SetUp::check))?;
        named("planted", self.planted.as_ref().map_or(Ok(()), RecoverStudy::check))
    }

    pub fn workspaces(&self) -> SavedWorkspaces {
        SavedWorkspaces { placed: [self.panes.clone(), self.pair_panes.clone(), self.methods_panes.clone()] }
    }

    pub fn apply(&self, model: &mut Model) {
        self.apply_without_burst(model);
        let pane = model.panes.of_mut(Side::A);
        (pane.cursor, pane.slope_chosen, pane.view, pane.content) = (self.scrub, true, self.view, Content::Cursor);
        if self.panes.is_none() {
            model.panes.show_alone(PaneId::of(Side::A));
        }
        self.workspaces().apply(&mut model.panes);
        model.reselect = self.selection;
        model.keep_methods_arranged();
        model.restore_probe(Side::A, self.probe);
        model.restore_against(Side::A, self.against.clone());
        model.check_params();
    }

    pub fn apply_without_burst(&self, model: &mut Model) {
        model.set_search(self.params.clone());
        model.calibration = self.calibration.clone();
        model.look = self.look.clone();
        model.filter = self.filter.clone();
        model.order = self.order;
        model.colour_by = self.colour_by;
        model.set_up = model.set_up.reading_by(self.depths_by);
        model.bottom_tab = self.bottom_tab;
        model.workspace = self.workspace;
        model.compare.look = self.methods.clone().sanitised();
        model.lab.planted = self.planted.clone().unwrap_or_else(|| Lab::default().planted);
    }
}

/// Where what is typed makes no sense, the last that did: a session could not be opened again.
fn sound_search(model: &Model) -> SearchParams {
    let asked = model.asked();
    match asked.validate() {
        Ok(()) => asked,
        Err(_) => SearchParams { detector: model.slots.a.usable_params.clone(), ..asked },
    }
}

/// Unknown keys are paths: `pair.links.vews`. Types that deny unknown keys themselves fail at once.
fn read_noting_unknown_keys<T: DeserializeOwned>(text: &str) -> Result<(T, Vec<String>), toml::de::Error> {
    let mut unknown = Vec::new();
    let value = serde_ignored::deserialize(toml::Deserializer::parse(text)?, |path| unknown.push(path.to_string()))?;
    Ok((value, unknown))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::{Burst, OpenOptions};
    use crate::detector::Slope;
    use crate::plane::Plane;
    use crate::requests::OpenBurst;
    use proptest::prelude::*;

    fn model() -> Model {
        let mut model = Model::default();
        let burst = Burst::from_planes("test", vec![Plane::zeros(64, 48), Plane::zeros(64, 48)]);
        model.take_burst(OpenBurst::new(burst, BurstSource::Paths(vec!["frames".into()])));
        model.params.peak_threshold = 0.01;
        model.focused_mut().cursor.slope = Slope::new(1.25, -0.5);
        model.filter.hide_slope_limit = true;
        model.look.motion_vectors = false;
        let bias = Some("dark.tiff".into());
        model.calibration = OpenOptions { bias, black_level: Some(64.0), ..OpenOptions::default() };
        model
    }

    #[test]
    fn what_is_probed_and_compared_in_b_comes_back_with_b() {
        let mut model = model();
        let second = || {
            let burst = Burst::from_planes("second", vec![Plane::zeros(80, 48), Plane::zeros(80, 48)]);
            OpenBurst::new(burst, BurstSource::Paths(vec!["others".into()]))
        };
        model.take_second_burst(second());
        let before = Session::of(&model).expect("a burst is open");
        let text = before.to_toml();
        assert!(!text.contains("probe") && !text.contains("against"), "{text}");
        model.probe_place(Side::B, [70.0, 20.0]);
        model.lay_over(Side::B, "theirs.csv".into());
        let session = Session::of(&model).expect("a burst is open");
        assert!(session.probe.is_none() && session.against.is_none(), "they are of B");
        let text = session.to_toml();
        assert_eq!(Session::from_toml(&text).as_ref(), Ok(&session), "{text}");
        let mut restored = self::model();
        session.apply(&mut restored);
        restored.take_second_burst(second());
        session.pair.apply(&mut restored);
        assert_eq!((restored.probe.side, restored.probe.place()), (Side::B, Some([70.0, 20.0])));
        let file = restored.slots.b.against.file.as_ref().expect("it was opened").path.clone();
        assert!(file.is_absolute() && file.ends_with("theirs.csv"));
        assert_eq!(Session::of(&restored).expect("a burst is open").pair, session.pair);
        // The session of before says nothing of B's probe, and takes it away.
        before.pair.apply(&mut restored);
        assert!(!restored.probe.is_on() && restored.saved_against(Side::B).is_none());
    }

    #[test]
    fn what_is_not_a_session_is_said() {
        for text in [
            "",
            "hello",
            "version = 3",
            "version = 2\nburst = \"demo\"",
            "peak_threshold = 0.1",
            "version = 99\nburst = \"demo\"",
        ] {
            let error = Session::from_toml(text).expect_err(text);
            assert!(error.contains("session"), "{error}");
        }
        assert!(Session::from_toml("version = 3\nburst = \"demo\"").is_ok());
    }

    #[test]
    fn unknown_keys_are_named_wherever_they_are() {
        let text = Session::of(&model()).expect("a burst is open").to_toml();
        let tables: Vec<&str> = text.lines().filter(|line| line.starts_with('[')).collect();
        assert!(tables.len() > 20, "{tables:?}");
        let mut of_one_kinds = 0;
        for table in tables {
            let misspelt = text.replacen(table, &format!("{table}\nmisspelt = 1"), 1);
            let error = Session::from_toml(&misspelt).expect_err(table);
            // A value of an enum is a table with the variant as the only key.
            let of_one_kind = error.contains("wanted exactly 1 element");
            assert!(error.contains("misspelt") || (of_one_kind && error.contains(table)), "{table}: {error}");
            of_one_kinds += usize::from(of_one_kind);
            for (version, which) in [("version 4", "a newer Burstscope"), ("version 2", "the Burstscope that wrote it")]
            {
                let other = misspelt.replacen("version = 3", &version.replace(' ', " = "), 1);
                let error = Session::from_toml(&other).expect_err(table);
                assert!(error.contains(version) && error.ends_with(which), "{table}: {error}");
            }
        }
        assert!(of_one_kinds < 10, "{of_one_kinds}");
        let misspelt = text.replacen("[pair.links]", "[pair.links]\nmisspelt = 1", 1);
        let error = Session::from_toml(&misspelt).expect_err("unknown");
        assert!(error.contains("pair.links.misspelt"), "{error}");
        // Within a value of an enum.
        let inner = "version = 3\nburst = { dark_copy = { of = \"demo\", noise = 0.1, seed = 3 } }";
        let error = Session::from_toml(inner).expect_err("unknown");
        assert!(error.contains("seed"), "{error}");
    }

    proptest! {
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
