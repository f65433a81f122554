//! A session restores a view of a burst, from a TOML file: its bursts are opened first, then everything else follows.
//! Pixels are read and features detected again, bit by bit.

use crate::app::document::{
    Action, Comparison, Document, Probe, Reference, Reselect, SavedMatch, SavedSelection, Side, Sides, Staged, Steps,
};
use crate::app::pane::{PaneGroup, Panes};
use crate::app::results::Read;
use crate::app::{actions::ActionId, document::look::SMOOTHING_PX};
use crate::detector::params::AUTO;
use crate::detector::{SearchParams, Slopes};
use crate::export::case::{is_case, read_about, read_session};
use crate::matching::MatchParams;
use crate::matching::params::doc;
use crate::requests::{BurstSource, JobId};
use crate::teach::Workspace;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt::Display;
use std::path::Path;
use toml::Table;

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
    /// Burst that is open as B. Panes of both bursts wait for it in the document.
    pub second: Option<BurstSource>,
    pub selected_match: Option<SavedMatch>,
}

impl Session {
    pub fn of(project: Read<'_>) -> Option<Self> {
        let burst = project.results.slots.a.burst.as_ref()?.source.absolute();
        Some(Self {
            version: VERSION,
            did: Steps::new(),
            burst,
            document: sound(project),
            detected: project.results.slots.a.found.is_some(),
            selection: project.saved_selection(),
            second: project.results.slots.b.burst.as_ref().map(|open| open.source.absolute()),
            selected_match: project.saved_match(),
        })
    }

    /// The session for a case: of its frames alone, without what lies in other files.
    pub fn for_case(mut self) -> Self {
        let workspace = self.document.workspace;
        if workspace.shows_pair() || workspace.record().is_of_dataset {
            self.document.workspace = Workspace::Inspect;
        }
        // Settings that name other files, which a case does not hold.
        let document = &mut self.document;
        (document.calibration, document.calibration_of_b) = Default::default();
        (document.gold, document.dataset, document.trajectories, document.places) = Default::default();
        if self.document.probe.side == Side::B {
            self.document.probe = Probe::default();
        }
        let comparisons = &mut self.document.comparisons;
        comparisons.b = Comparison::default();
        (comparisons.a.with, comparisons.a.file) = (comparisons.a.with.filter(|with| *with != Reference::File), None);
        Self { burst: BurstSource::Paths(Vec::new()), second: None, selected_match: None, ..self }
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
            document: Option<toml::Table>,
        }
        let head = toml::from_str(text);
        if let Ok(Head { version, .. }) = head
            && version != VERSION
        {
            let which = if version > VERSION { "a newer Burstscope" } else { "the Burstscope that wrote it" };
            return Err(format!(
                "the session file has version {version}, this program reads {VERSION}; open it with {which}"
            ));
        }
        let (mut session, unknown): (Self, _) = match text.parse().ok().and_then(brought_up_to_date) {
            Some(table) => noting_unknown_keys(table),
            None => toml::Deserializer::parse(text).and_then(noting_unknown_keys),
        }
        .map_err(|error| format!("this is not a session file: {error}"))?;
        if !unknown.is_empty() {
            return Err(format!("the session file has unknown keys: {}; remove or correct them", unknown.join(", ")));
        }
        session.check().map_err(|error| format!("the session file cannot be used: {error}"))?;
        let document = &mut session.document;
        document.look.ranges = document.look.ranges.sanitised();
        document.match_look = document.match_look.sanitised();
        document.methods = std::mem::take(&mut document.methods).sanitised();
        // A file may name *Methods* as a workspace of its own.
        let of_head = head.ok().and_then(|head| head.document);
        if of_head.is_some_and(|head| head.get("workspace").and_then(toml::Value::as_str) == Some("methods")) {
            document.compare_methods();
        }
        Ok(session)
    }

    /// Numbers that decide what is computed. Those of panes, views and ranges are brought into range where used.
    pub fn check(&self) -> Result<(), String> {
        fn named<E: Display>(key: &str, checked: Result<(), E>) -> Result<(), String> {
            checked.map_err(|error| format!("{key}: {error}"))
        }
        let document = &self.document;
        named("burst", self.burst.check())?;
        named("second", self.second.iter().try_for_each(BurstSource::check))?;
        named("document.gold.a", document.gold.a.iter().try_for_each(BurstSource::check))?;
        named("document.gold.b", document.gold.b.iter().try_for_each(BurstSource::check))?;
        let [of_a, of_b] = document.comparisons.both().map(|of| of.pinned.iter().try_for_each(SearchParams::validate));
        named("document.params", document.params.validate())?;
        named("document.comparisons.a.pinned", of_a)?;
        named("document.comparisons.b.pinned", of_b)?;
        named("document.matching", doc::ALL.iter().try_for_each(|record| record.check(&document.matching)))?;
        named("document.look", SMOOTHING_PX.check("smoothing_px", document.look.smoothing_px.into()))?;
        // A set-up that is not read may have any values.
        let set_up = document.set_up;
        named("document.set_up", if set_up.reads_depths { set_up.values.check() } else { Ok(()) })?;
        named("document.lab.planted", document.lab.planted.check())
    }

    fn has_panes(&self) -> bool {
        self.document.panes != Panes::default()
    }

    /// The document on show with all but what waits for the second burst; A was opened in it.
    pub fn over_first(&self, now: &Document) -> Document {
        let mut document = self.over_none(now);
        // A session without panes shows the middle frame, as a newly opened burst does.
        if self.has_panes() {
            document.panes = self.document.panes.clone();
        }
        document.comparisons.a = self.document.comparisons.a.clone();
        Document { probe: self.probe_over(Side::A, now), ..document }
    }

    /// The document on show with all that needs neither burst. Panes, and the colours of the window, stay.
    fn over_none(&self, now: &Document) -> Document {
        let Document { panes, theme, probe, comparisons, gold, .. } = now.clone();
        let (selected, selected_match, playing) = (None, None, false);
        let kept = Document { panes, theme, probe, comparisons, gold, ..self.document.clone() };
        Document { selected, selected_match, playing, ..kept }
    }

    /// The document on show with what waits for the second burst, which is open now, or closed for good.
    pub fn over_second(&self, now: &Document) -> Document {
        let mut document = Document { probe: self.probe_over(Side::B, now), ..now.clone() };
        if self.has_panes() {
            document.panes = self.document.panes.clone();
        }
        if self.second.is_none() {
            document.gold.b = None;
            // No second burst will come, for which panes of B could wait.
            document.panes.close_side(Side::B);
            if self.has_panes() {
                document.panes.take_placed(PaneGroup::Pair, &self.document.panes);
            }
        }
        document.comparisons.b = self.document.comparisons.b.clone();
        document
    }

    fn probe_over(&self, side: Side, now: &Document) -> Probe {
        match (self.document.probe, now.probe) {
            (saved, _) if saved.side == side => saved,
            (_, shown) if shown.side == side => Probe::default(),
            (_, shown) => shown,
        }
    }

    /// Actions that follow once the burst of `side` `is_open`, or could not be opened: the one on show stays then.
    pub fn after(&self, side: Side, is_open: bool, now: &Document) -> Vec<Action> {
        match side {
            Side::A => self.after_first(is_open, now),
            Side::B if is_open => self.after_second(now),
            Side::B => Vec::new(),
        }
    }

    fn after_first(&self, is_open: bool, now: &Document) -> Vec<Action> {
        let document = if is_open { self.over_first(now) } else { self.over_none(now) };
        let selection = self.selection.filter(|_| is_open);
        // With automatic detection the document itself leads to the request.
        let detects = self.detected && is_open && !document.auto_detect;
        let mut actions: Vec<Action> = vec![
            Staged::Show(Box::new(document.clone()), Reselect::Feature(selection)).into(),
            Staged::ReadNamed.into(),
        ];
        actions.extend(detects.then(|| ActionId::Detect.into()));
        actions.extend(self.document.gold.a.clone().filter(|_| is_open).map(|gold| Action::OpenGold(Side::A, gold)));
        match self.second.clone() {
            Some(source) => actions.push(Staged::Reopen(Side::B, source).into()),
            None => {
                // A burst that is open as B does not belong to the session.
                actions.push(ActionId::CloseB.into());
                actions.extend(self.after_second(&document));
            }
        }
        if !is_open {
            actions.push(Action::Note("The session was restored without its burst".to_owned()));
        }
        actions
    }

    fn after_second(&self, now: &Document) -> Vec<Action> {
        let gold = self.document.gold.b.clone().filter(|_| self.second.is_some());
        let shown = Staged::Show(Box::new(self.over_second(now)), Reselect::Match(self.selected_match));
        [shown.into()].into_iter().chain(gold.map(|gold| Action::OpenGold(Side::B, gold))).collect()
    }
}

/// The document with absolute paths, and with usable values for invalid ones, with which no session opens again.
fn sound(project: Read<'_>) -> Document {
    let mut document = project.document.clone().with_absolute_paths();
    if document.params.validate().is_err() {
        let usable = project.results.slots.a.usable_params.clone();
        // Slopes that are to be found stay so: only given ones are replaced.
        let slopes = document.params.slopes.given().map_or(Slopes::AUTO, |_| usable.slopes.into());
        document.params = usable.with_slopes(slopes);
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
fn noting_unknown_keys<'de, T: DeserializeOwned, D: Deserializer<'de>>(text: D) -> Result<(T, Vec<String>), D::Error> {
    let mut unknown = Vec::new();
    let value = serde_ignored::deserialize(text, |path| unknown.push(path.to_string()))?;
    Ok((value, unknown))
}

/// Rewrites a session whose choice of slopes stands beside the ranges (those found last, where slopes are found), and
/// whose compared methods have a switch of their own for features; `None` for others.
fn brought_up_to_date(mut session: Table) -> Option<Table> {
    let document = session.get_mut("document")?.as_table_mut()?;
    let choice = document.remove("slopes");
    let methods = document.get_mut("methods").and_then(|methods| methods.as_table_mut());
    let switch = methods.and_then(|methods| methods.remove("features"));
    if let Some(line) = choice.as_ref().and_then(|choice| choice.get("auto")) {
        let mut auto = line.as_table()?.clone();
        auto.insert(AUTO.into(), true.into());
        let params = document.entry("params").or_insert_with(|| Table::new().into());
        params.as_table_mut()?.insert("slopes".into(), auto.into());
    }
    choice.or(switch).map(|_| session)
}

/// Sessions that wait for a burst; a session is given up when something else is opened in the burst's place.
#[derive(Debug, Default)]
pub struct Restoring(Sides<Option<(JobId, Box<Session>)>>);

impl Restoring {
    /// Everything else is restored once the burst of `side` was opened, or could not be; until then nothing changes.
    pub fn wait(&mut self, side: Side, opening: Option<JobId>, session: Box<Session>) {
        self.0[side] = opening.map(|id| (id, session));
    }

    pub fn waits_for(&mut self, model: Read<'_>) -> Option<JobId> {
        let [of_a, of_b] = model.results.slots.both().map(|slot| slot.opening.pending_id());
        self.0.a.take_if(|(id, _)| Some(*id) != of_a);
        self.0.b.take_if(|(id, _)| Some(*id) != of_b);
        of_a.filter(|_| self.0.a.is_some())
    }

    pub fn take(&mut self, side: Side, opening: JobId) -> Option<Box<Session>> {
        self.0[side].take_if(|(id, _)| *id == opening).map(|(_, session)| session)
    }
}

/// Content of a case that is opened first.
pub enum OfCase {
    Session(Box<Session>),
    /// Its search and the place asked about, and why there is no session, if that is an error.
    Search(Vec<Action>, Option<String>),
}

/// A case is shown as it was saved: with its session, or else with its search and the place asked about. `None` for
/// other files, and for a case that cannot be read, which is reported when it is opened.
pub fn of_case(source: &BurstSource) -> Option<OfCase> {
    let [path] = source.paths() else { return None };
    let about = is_case(path).then(|| read_about(path).ok()).flatten()?;
    let session = Session::in_case(path);
    if let Ok(Some(session)) = session {
        return Some(OfCase::Session(Box::new(session)));
    }
    let probe = about.place.map(|place| Staged::ProbeWhenOpen(source.clone(), place).into());
    let actions = [Action::SetSearch(Box::new(about.search))].into_iter().chain(probe).collect();
    Some(OfCase::Search(actions, session.err()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::{Bench, open};
    use crate::app::apply::opening;

    #[test]
    fn a_session_is_given_up_when_something_else_is_opened() {
        let (mut bench, mut restoring) = (Bench::new(), Restoring::default());
        opening::take_burst(&mut bench.model, open((64, 48), 5));
        let session = Session::of(bench.read()).expect("a burst is open");
        let first = opening::open(&mut bench.model, Side::A, BurstSource::Demo, &bench.engine);
        restoring.wait(Side::A, Some(first), Box::new(session));
        assert_eq!(restoring.waits_for(bench.read()), Some(first));
        let other = opening::open(&mut bench.model, Side::A, BurstSource::DemoLater, &bench.engine);
        assert_eq!(restoring.waits_for(bench.read()), None);
        assert!(restoring.take(Side::A, first).is_none() && restoring.take(Side::A, other).is_none());
    }
}
