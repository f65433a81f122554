//! Actions of the user and effects of the window's parts: applied here, and only here, to the part that they concern.

use super::actions::{ActionId, Queue};
use super::dataset::CutDialog;
use super::dialogs::Question;
use super::files::{drop_places, purpose_of_dropped};
use super::session::{OfCase, Session, of_case};
use super::window::BurstscopeApp;
use super::{actions, apply, clipboard, files};
use crate::app::apply::{methods, opening, studies};
use crate::app::document::{Action, ExportKind, Purpose, Side};
use crate::app::results::{Effect, Read};
use crate::burst::TimesChoice;
use crate::engine::Ended;
use crate::inspect::place::ProbeSubject;
use crate::requests::{OpenRequest, ProbeQuestion};
use crate::teach::Lesson;
use std::path::PathBuf;
use std::sync::Arc;

impl BurstscopeApp {
    /// Applies the actions of this pass. What they change is drawn in the next one.
    pub(super) fn act(&mut self, ctx: &egui::Context, queue: Queue) {
        let pointed = self.model.results.pointed();
        let is_changed = queue.0.iter().any(|action| !matches!(action, Action::Point(_)));
        for action in queue.0 {
            self.run(ctx, action);
            methods::refresh_workspace(&mut self.model);
        }
        if is_changed || pointed != self.model.results.pointed() {
            ctx.request_repaint();
        }
    }

    /// Does the next action again of those that are played; whether its step goes on.
    pub(super) fn play_step(&mut self, ctx: &egui::Context) -> bool {
        let rests = self.rests();
        let Some(playback) = &mut self.playback else { return false };
        let (action, goes_on) = (playback.next(rests), playback.goes_on);
        if let Some(action) = action {
            self.run(ctx, action);
            methods::refresh_workspace(&mut self.model);
            ctx.request_repaint();
        }
        goes_on
    }

    pub(super) fn take_dropped_files(&mut self, ctx: &egui::Context) {
        let paths: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_path_buf()).collect());
        if paths.is_empty() {
            return;
        }
        let pointer = ctx.input(|i| i.pointer.latest_pos());
        let is_there = |rect: &egui::Rect| pointer.is_some_and(|pos| rect.contains(pos));
        let places = drop_places(Read::of(&self.model), &self.widgets);
        let on_b = places.iter().any(|(rect, side)| *side == Side::B && is_there(rect));
        let side = if on_b { Side::B } else { Side::A };
        let purpose = purpose_of_dropped(&paths, side, self.overlays.calibration.as_ref(), Read::of(&self.model));
        self.apply([Effect::UseFiles(purpose, paths)]);
    }

    pub(super) fn run(&mut self, ctx: &egui::Context, action: Action) {
        match action {
            Action::Do(id) => self.run_action(ctx, id),
            action => self.change(action),
        }
    }

    /// Takes an action that is no row of the table.
    pub(super) fn change(&mut self, action: Action) {
        self.journal.take(&action, Read::of(&self.model).is_in_lesson());
        match action {
            Action::Open(Side::A, source) => match of_case(&source) {
                Some(OfCase::Session(session)) => self.restore(session),
                Some(OfCase::Search(actions, why)) => {
                    let messages = &mut self.model.shell.messages;
                    why.into_iter().for_each(|why| messages.error(Purpose::RestoreSession.title(), why));
                    // Settings made after the request belong to the new burst.
                    self.stage([Action::Open(Side::A, source)].into_iter().chain(actions));
                }
                None => self.stage([Action::Open(Side::A, source)]),
            },
            Action::Restore(session) => self.restore(session),
            action => self.stage([action]),
        }
    }

    /// Takes actions that are not taken down: what was done led to them.
    pub(super) fn stage<A: Into<Action>>(&mut self, staged: impl IntoIterator<Item = A>) {
        for action in staged {
            let effects = apply::apply(action.into(), &mut self.model, &self.engine);
            self.apply(effects);
        }
    }

    fn restore(&mut self, session: Box<Session>) {
        let request = OpenRequest { source: session.burst.clone(), options: session.document.calibration.clone() };
        let opening = self.model.results.slots.a.open(request, None, &self.engine);
        self.restoring.wait(Side::A, Some(opening), session);
    }

    fn take_opened(&mut self, side: Side, ended: Ended<OpenRequest>) {
        if let (Side::A, Some(recovery)) = (side, &mut self.recovery) {
            recovery.restored(ended.id, ended.result.is_ok());
        }
        let session = self.restoring.take(side, ended.id);
        let is_open = ended.result.is_ok();
        let effects = opening::take_opening(&mut self.model, side, ended, session.is_some(), &self.engine);
        self.apply(effects);
        let Some(session) = session else { return };
        self.stage(session.after(side, is_open, &self.model.document));
        if side == Side::A && session.second.is_some() {
            self.restoring.wait(Side::B, self.model.results.slots.b.opening.pending_id(), session);
        }
    }

    /// Runs an action, as if it had been chosen from a menu. A disabled action does nothing.
    pub fn run_action(&mut self, ctx: &egui::Context, id: ActionId) {
        if !actions::enabled(id, Read::of(&self.model)) || self.overlays.open(id, Read::of(&self.model)) {
            return;
        }
        let Self { model, widgets, journal, .. } = self;
        journal.take(&id.into(), Read::of(model).is_in_lesson());
        match id {
            ActionId::Lessons => self.lessons.list_is_open = true,
            ActionId::Hall => {
                let panels = self.lessons.panels_for_hall(&model.document.panels);
                self.stage(panels.map(Action::SetPanels));
            }
            ActionId::LeaveLesson => {
                let staged = self.lessons.end(false);
                self.stage(staged);
            }
            ActionId::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            ActionId::OneToOne => model.document.change_views(|view| view.set_one_to_one(ctx.pixels_per_point())),
            ActionId::ProbePlace => {
                if let Some((side, place)) = actions::when::place_to_probe(Read::of(model), widgets) {
                    self.change(Action::StopFollowing);
                    self.change(Action::Probe(side, ProbeQuestion::At { place, wanted: ProbeSubject::Best }));
                }
            }
            ActionId::CopyActions => {
                ctx.copy_text(journal.to_toml());
                model.shell.messages.note("Copied what you did");
            }
            ActionId::CopyRow => self.note(clipboard::copy_row(ctx, Read::of(&self.model), &self.widgets)),
            ActionId::CopyCommand => match clipboard::copy_command(ctx, Read::of(model)) {
                Some(Err(why)) => model.shell.messages.error("Copy as command", why),
                copied => self.note(copied.and_then(Result::ok)),
            },
            ActionId::Cite => {
                ctx.copy_text(include_str!("../../assets/burstscope.bib").to_owned());
                model.shell.messages.note("Copied the program and the paper as BibTeX");
            }
            ActionId::CopyPicture => self.note(clipboard::copy_picture(ctx, self.read(), self.model.document.focus())),
            _ => self.stage([id]),
        }
    }

    pub(super) fn note(&mut self, note: Option<String>) {
        note.into_iter().for_each(|note| self.model.shell.messages.note(note));
    }

    pub(super) fn apply(&mut self, effects: impl IntoIterator<Item = Effect>) {
        effects.into_iter().for_each(|effect| self.take_effect(effect));
    }

    fn take_effect(&mut self, effect: Effect) {
        let Self { model, engine, .. } = self;
        match effect {
            Effect::Opened(side, ended) => self.take_opened(side, ended),
            Effect::Recent(source) => self.settings.remember(&source),
            Effect::RecentDataset(source) => self.settings.remember_dataset(&source),
            Effect::Choose(side, bursts) => (self.overlays.choice, self.overlays.choice_side) = (bursts, side),
            Effect::AskShape(side, source, shapes) => self.overlays.shape.ask(side, source, shapes),
            Effect::Cut(paths, frames) => {
                self.overlays.cut = Some(CutDialog::new(paths, frames, self.settings.burst_length));
            }
            Effect::ReplaceFeatures => self.overlays.replace_features = true,
            Effect::ForgetThumbnails => self.thumbnails = Default::default(),
            Effect::Ask(purpose) => {
                if let Err(Question { purpose, suggested_name, .. }) =
                    self.chooser.ask(files::question(purpose, Read::of(model)))
                {
                    let why = "another dialog for files is not answered yet";
                    model.shell.messages.note_unanswered(purpose, suggested_name, why);
                }
            }
            Effect::UseFiles(purpose, paths) => self.use_files(purpose, paths),
            Effect::Write(purpose, path) => {
                let lesson = self.lessons.open.as_ref().map(|open| &*open.lesson);
                self.overlays.mask = (purpose == Purpose::Export(ExportKind::Mask)).then(|| path.clone());
                let begun = files::write(purpose, path, lesson, Read::of(model), &self.widgets, engine);
                model.shell.messages.settle(purpose.title(), begun);
            }
            Effect::StartLesson(lesson) => self.start_lesson(lesson),
            Effect::ForgetWidgets => self.widgets = Default::default(),
        }
    }

    fn use_files(&mut self, purpose: Purpose, paths: Vec<PathBuf>) {
        let Self { model, engine, overlays, .. } = self;
        let Some(first) = paths.first() else { return };
        let (now, file) = (&model.document.calibration, Some(first.clone()));
        match purpose {
            Purpose::OpenBias => overlays.calibration_draft(now).bias = file,
            Purpose::OpenFlat => overlays.calibration_draft(now).flat = file,
            Purpose::OpenMask | Purpose::OpenMasks => overlays.calibration_draft(now).mask = file,
            Purpose::OpenTimes => overlays.calibration_draft(now).times = file.map(TimesChoice::List),
            Purpose::OpenRotations => overlays.calibration_draft(now).rotations = file,
            Purpose::OpenLens => overlays.calibration_draft(now).lens = file,
            Purpose::OpenLessons => _ = model.shell.messages.settle(purpose.title(), self.lessons.open_at(first)),
            Purpose::PaperFigures => studies::make_figures(model, first.clone(), engine),
            #[cfg(feature = "colmap")]
            Purpose::ExportDatabase => crate::app::apply::datasets::export_database(model, first.clone(), engine),
            Purpose::SaveSession | Purpose::SaveParams | Purpose::Export(_) => {
                self.apply([Effect::Write(purpose, first.clone())]);
            }
            _ => {
                let action = files::action_of(purpose, paths, &mut model.shell.messages);
                action.into_iter().for_each(|action| self.change(action));
            }
        }
    }

    /// Opens a lesson at the step where it was left last. What is open is put aside until the lesson is left.
    pub fn start_lesson(&mut self, lesson: Arc<Lesson>) {
        let staged = self.lessons.start(lesson);
        self.stage(staged);
    }
}
