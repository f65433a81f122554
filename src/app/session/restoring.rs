//! Restoring of a session: its bursts are opened first, then everything else follows.

use super::Session;
use crate::app::actions::ActionId;
use crate::app::document::{Action, Document, Reselect, Side, Sides, Staged};
use crate::app::results::Read;
use crate::export::case::{is_case, read_about};
use crate::requests::{BurstSource, JobId, OpenRequest};

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

impl Session {
    pub fn opening(&self) -> OpenRequest {
        OpenRequest { source: self.burst.clone(), options: self.document.calibration.clone() }
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
