//! Restoring of a session: its bursts are opened first, then everything else follows.

use super::Session;
use crate::app::project::Model;
use crate::app::project::datasets::DatasetChoice;
use crate::app::project::effect::Effect;
use crate::app::project::side::Side;
use crate::app::project::workspace::Workspace;
use crate::dataset::DatasetSource;
use crate::engine::{Ended, Engine};
use crate::export::case::{is_case, read_about};
use crate::requests::{BurstSource, JobError, JobId, OpenRequest};

const TITLE: &str = "Open session";

#[derive(Debug, Default)]
pub struct Restoring {
    session: Option<(JobId, Box<Session>)>,
    second: Option<(JobId, Box<Session>)>,
}

impl Restoring {
    /// Everything else is restored once the burst was opened, or could not be; until then nothing changes.
    pub fn begin(&mut self, session: Session, model: &mut Model, engine: &Engine) {
        let (source, options) = (session.burst.clone(), session.document.calibration.clone());
        let id = model.slots.a.opening.ask(engine, OpenRequest { source, options });
        self.session = Some((id, Box::new(session)));
    }

    /// A case is shown as it was saved: with its session, or else with its search and the place asked about.
    pub fn open(&mut self, source: BurstSource, model: &mut Model, engine: &Engine) {
        let case = match source.paths() {
            [path] if is_case(path) => Some(path),
            _ => None,
        };
        // A case that cannot be read is reported when it is opened.
        if let Some((path, Ok(about))) = case.map(|path| (path, read_about(path))) {
            match Session::in_case(path) {
                Ok(Some(session)) => {
                    self.begin(session, model, engine);
                    return;
                }
                Ok(None) => {}
                Err(why) => model.messages.error(TITLE, why),
            }
            model.set_search(about.search);
            model.studies.probe_when_open = about.place.map(|place| (source.clone(), place));
        }
        model.open(Side::A, source, engine);
    }

    /// A session whose request was superseded or forgotten, because something else is opened, is given up.
    pub fn waits_for(&mut self, model: &Model) -> Option<JobId> {
        let [of_a, of_b] = model.slots.both().map(|slot| slot.opening.pending_id());
        self.session.take_if(|(id, _)| Some(*id) != of_a);
        self.second.take_if(|(id, _)| Some(*id) != of_b);
        of_a.filter(|_| self.session.is_some())
    }

    pub fn take_opened(
        &mut self,
        side: Side,
        ended: Ended<OpenRequest>,
        model: &mut Model,
        engine: &Engine,
    ) -> Vec<Effect> {
        match side {
            Side::A => self.take_first(ended, model, engine),
            Side::B => self.take_second(ended, model, engine),
        }
    }

    fn take_first(&mut self, ended: Ended<OpenRequest>, model: &mut Model, engine: &Engine) -> Vec<Effect> {
        let session = self.session.take_if(|(id, _)| *id == ended.id).map(|(_, session)| session);
        let mut effects = Vec::new();
        match ended.result {
            Ok(burst) => {
                effects.extend(model.take_opened(Side::A, burst, engine));
                if let Some(session) = session {
                    session.apply(model);
                    effects.extend(self.restore_others(*session, true, model, engine));
                }
            }
            Err(JobError::Cancelled) => model.messages.note("Opening cancelled"),
            Err(JobError::Several(_)) if session.is_none() => {
                if let BurstSource::Paths(paths) = ended.request.source {
                    model.look_at_dataset(DatasetSource::of_bursts(paths), None, engine);
                }
            }
            Err(error) => {
                model.messages.error(Side::A.opening(), error.to_string());
                if let Some(session) = session {
                    // The open burst stays.
                    session.apply_without_burst(model);
                    effects.extend(self.restore_others(*session, false, model, engine));
                    model.messages.note("The session was restored without its burst");
                }
            }
        }
        effects
    }

    fn restore_others(
        &mut self,
        session: Session,
        with_burst: bool,
        model: &mut Model,
        engine: &Engine,
    ) -> Option<Effect> {
        let closed = match session.document.dataset.clone() {
            Some(DatasetChoice { source, folder, .. }) => {
                model.look_at_dataset(source, folder, engine);
                None
            }
            None => Some(model.close_dataset()),
        };
        model.read_trajectories(engine);
        if with_burst {
            if session.detected && model.needs_detection(Side::A) {
                model.start_detection(Side::A, engine);
            }
            if let Some(gold) = session.document.gold.a.clone() {
                model.open_gold(Side::A, gold, engine);
            }
        }
        match session.second.clone() {
            Some(source) => {
                let id = model.open(Side::B, source, engine);
                self.second = Some((id, Box::new(session)));
            }
            None => {
                model.close_second();
                model.forget_closed_trails(engine);
                session.apply_second(model);
            }
        }
        closed
    }

    fn take_second(&mut self, ended: Ended<OpenRequest>, model: &mut Model, engine: &Engine) -> Vec<Effect> {
        let session = self.second.take_if(|(id, _)| *id == ended.id).map(|(_, session)| session);
        let mut effects = Vec::new();
        match ended.result {
            Ok(burst) => {
                effects.extend(model.take_opened(Side::B, burst, engine));
                match session {
                    Some(session) => {
                        session.apply_second(model);
                        if let Some(gold) = session.document.gold.b {
                            model.open_gold(Side::B, gold, engine);
                        }
                    }
                    None => model.workspace = Workspace::Pair,
                }
            }
            Err(JobError::Cancelled) => model.messages.note("Opening B cancelled"),
            Err(JobError::Several(bursts)) if session.is_none() => effects.push(Effect::Choose(Side::B, bursts)),
            Err(error) => {
                if model.slots.b.burst.is_none() {
                    // Panes of a session that wait for it would wait for ever.
                    model.panes.close_side(Side::B);
                }
                model.messages.error(Side::B.opening(), error.to_string());
            }
        }
        effects
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::project::tests::{Bench, open};

    fn opened(bench: &mut Bench, restoring: &mut Restoring, side: Side) -> Vec<Effect> {
        let is_end = |effect: &Effect| matches!(effect, Effect::Opened(of, _) if *of == side);
        let effects = bench.run_until(|_, effects| effects.iter().any(is_end));
        let apply = |effect| match effect {
            Effect::Opened(side, ended) => restoring.take_opened(side, ended, &mut bench.model, &bench.engine),
            other => vec![other],
        };
        effects.into_iter().flat_map(apply).collect()
    }

    fn session(burst: BurstSource) -> Session {
        let mut model = Model::default();
        let mut a = open((64, 48), 5);
        a.source = burst;
        model.take_burst(a);
        model.take_second_burst(open((64, 48), 5));
        model.params.levels = 3;
        Session::of(&model).expect("a burst is open")
    }

    #[test]
    fn a_session_is_given_up_when_something_else_is_opened() {
        let (mut bench, mut restoring) = (Bench::new(), Restoring::default());
        restoring.begin(session(BurstSource::Demo), &mut bench.model, &bench.engine);
        assert!(restoring.waits_for(&bench.model).is_some());
        bench.model.open(Side::A, BurstSource::DemoLater, &bench.engine);
        assert_eq!(restoring.waits_for(&bench.model), None);
        opened(&mut bench, &mut restoring, Side::A);
        let source = bench.model.slots.a.burst.as_ref().map(|burst| burst.source.clone());
        assert_eq!((source, bench.model.slots.b.opening.is_pending()), (Some(BurstSource::DemoLater), false));
        assert_ne!(bench.model.params.levels, 3);
    }

    #[test]
    fn a_folder_of_bursts_is_a_dataset_for_a_and_a_choice_for_b() {
        let home = tempfile::tempdir().expect("a folder");
        for name in ["one", "two"] {
            let folder = home.path().join(name);
            std::fs::create_dir(&folder).expect("made");
            for frame in 0..2 {
                let gray = image::GrayImage::from_pixel(16, 12, image::Luma([frame]));
                gray.save(folder.join(format!("{frame}.png"))).expect("written");
            }
        }
        let (mut bench, mut restoring) = (Bench::new(), Restoring::default());
        let source = BurstSource::Paths(vec![home.path().to_owned()]);
        bench.model.open(Side::B, source.clone(), &bench.engine);
        let effects = opened(&mut bench, &mut restoring, Side::B);
        assert!(matches!(&effects[..], [Effect::Choose(Side::B, bursts)] if bursts.len() == 2), "{effects:?}");
        bench.model.open(Side::A, source, &bench.engine);
        assert!(opened(&mut bench, &mut restoring, Side::A).is_empty());
        assert!(bench.model.datasets.wanted.is_pending());
    }
}
