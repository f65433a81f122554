//! Runs actions; those that only change the project are in [`super::change`].

use super::ActionId;
use super::change::change_model;
use crate::app::canvas::View;
use crate::app::clipboard;
use crate::app::dialogs::{ExportKind, Purpose};
use crate::app::inspector::Change;
use crate::app::pane::{Direction, Preset};
use crate::app::project::BottomTab;
use crate::app::project::against::With;
use crate::app::project::cursor::play_step_of;
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::window::BurstscopeApp;
use crate::requests::{BurstSource, ProbeQuestion};
use crate::synth::Example;

impl BurstscopeApp {
    /// Runs an action, as if it had been chosen from a menu. A disabled action does nothing.
    pub fn run_action(&mut self, ctx: &egui::Context, id: ActionId) {
        use ActionId as A;
        if !super::enabled(id, &self.model) {
            return;
        }
        match id {
            A::OpenFolder => self.ask(Purpose::OpenFolder),
            A::OpenFiles => self.ask(Purpose::OpenFiles),
            A::OpenDataset => self.ask(Purpose::OpenDataset),
            A::OpenPath => self.open_path_field(Purpose::OpenPath, false),
            A::OpenDemo => self.open(BurstSource::Demo),
            A::OpenDepths => self.open(BurstSource::Example(Example::Depths)),
            A::OpenStreet => self.open(BurstSource::Example(Example::Street)),
            A::OpenStreetLater => self.open(BurstSource::Example(Example::StreetLater)),
            A::OpenAliasing => self.open(BurstSource::Example(Example::Aliasing)),
            A::OpenLowContrast => self.open(BurstSource::Example(Example::LowContrast)),
            A::OpenTripod => self.open(BurstSource::Example(Example::Tripod)),
            A::OpenHotPixels => self.open(BurstSource::Example(Example::HotPixels)),
            A::Lessons => self.lessons.list_is_open = true,
            A::LeaveLesson => self.leave_lesson(),
            A::OpenLessons => self.ask(Purpose::OpenLessons),
            A::Glossary => self.overlays.glossary.open(None),
            A::RestoreSession => self.ask(Purpose::RestoreSession),
            A::SaveSession => self.ask(Purpose::SaveSession),
            A::LoadParams => self.ask(Purpose::LoadParams),
            A::SaveParams => self.ask(Purpose::SaveParams),
            A::ExportCsv => self.ask(Purpose::Export(ExportKind::Csv)),
            A::ExportColmap => self.ask(Purpose::Export(ExportKind::Colmap)),
            A::ExportNpz => self.ask(Purpose::Export(ExportKind::Npz)),
            A::ExportTiff => self.ask(Purpose::Export(ExportKind::Tiff)),
            A::ExportPng => self.ask(Purpose::Export(ExportKind::Png)),
            A::ExportSvg => self.ask(Purpose::Export(ExportKind::Svg)),
            A::ExportFigurePng => self.ask(Purpose::Export(ExportKind::FigurePng)),
            A::FigureOptions => self.overlays.figure_open = true,
            A::Calibration => {
                self.overlays.calibration_draft(&self.model.calibration);
            }
            A::ExportMatches => self.ask(Purpose::Export(ExportKind::Matches)),
            A::ExportMatchPicture => self.ask(Purpose::Export(ExportKind::MatchPicture)),
            A::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            A::Fit => self.change_views(View::set_fit),
            A::OneToOne => self.change_views(|view| view.set_one_to_one(ctx.pixels_per_point())),
            A::ZoomIn => self.change_views(|view| view.zoom_by(1.25)),
            A::ZoomOut => self.change_views(|view| view.zoom_by(0.8)),
            A::Play => {
                self.model.playing = !self.model.playing;
                self.play.step = play_step_of(&self.model.cursor_params().slopes, self.model.cursor().slope);
                self.play.due = None;
            }
            A::Detect => {
                self.model.start_detection(Side::A, &self.engine);
                if self.model.workspace == Workspace::Pair && self.model.slots.b.param_error.is_none() {
                    self.model.start_detection(Side::B, &self.engine);
                }
            }
            A::DetectAll => self.ask_and_detect_all(),
            A::CancelDataset => self.model.datasets.wanted.cancel(),
            A::RunStudy => self.model.run_study(&self.engine),
            A::CancelStudy => self.model.lab.wanted.cancel(),
            A::OpenChart => {
                if let Some(chart) = self.model.lab.selected_chart().and_then(|chart| chart.params()) {
                    self.model.workspace = Workspace::Inspect;
                    self.open(BurstSource::Chart(Box::new(chart)));
                }
            }
            A::OpenDarkCopy => {
                if let Some(burst) = &self.model.slots.a.burst {
                    let of = Box::new(burst.source.clone());
                    self.open(BurstSource::DarkCopy { of, noise: self.model.lab.dark_copy });
                }
            }
            A::ExportCurvesCsv => self.ask(Purpose::Export(ExportKind::CurvesCsv)),
            A::ExportCurvesSvg => self.ask(Purpose::Export(ExportKind::CurvesSvg)),
            A::PreviousBurst => self.step_burst(-1),
            A::NextBurst => self.step_burst(1),
            A::BurstAsA => self.choose_open_burst(0),
            A::BurstAsB => self.choose_open_burst(1),
            A::MatchPairs => self.match_pairs(),
            A::MatchSelected => self.match_selected(),
            A::ShowPair => self.show_selected_pair(),
            A::ExportDatabase => self.ask(Purpose::ExportDatabase),
            A::PaperFigures => self.ask(Purpose::PaperFigures),
            A::CancelFigures => self.model.figures.cancel(),
            A::OpenEstimate => self.ask(Purpose::OpenEstimate),
            A::OpenTruth => self.ask(Purpose::OpenTruth),
            A::CloseTrajectories => self.model.trajectories.clear(),
            A::CutSequence => self.ask_for_cut(),
            A::FeatureFolder => self.ask(Purpose::FeatureFolder),
            A::UseFolderParams => self.use_folder_params(),
            A::CloseDataset => self.close_dataset(),
            A::Cancel => self.model.cancel_searches(),
            A::GoToFeature if self.model.workspace == Workspace::Pair => {
                self.model.go_to_match();
                self.cursors_set = true;
            }
            A::GoToFeature => self.go_to_selected(),
            A::OpenFolderB => self.ask(Purpose::OpenFolderB),
            A::OpenFilesB => self.ask(Purpose::OpenFilesB),
            A::OpenPathB => self.open_path_field(Purpose::OpenPathB, false),
            A::OpenDemoB => self.open_second(BurstSource::DemoLater),
            A::OpenGoldA => self.ask(Purpose::OpenGold(Side::A)),
            A::OpenGoldB => self.ask(Purpose::OpenGold(Side::B)),
            A::CloseB => self.close_second(),
            A::SwapSides => self.swap_sides(),
            A::ProbeExpected => self.probe_expected(),
            A::Match => self.model.start_matching(&self.engine),
            A::SplitRight => self.change_panes(Change::Split(self.model.focus(), Direction::Right)),
            A::SplitDown => self.change_panes(Change::Split(self.model.focus(), Direction::Down)),
            A::ClosePane => self.change_panes(Change::Close(self.model.focus())),
            A::LayoutSingle => self.lay_out(Preset::Single),
            A::LayoutFrameAndStack => self.lay_out(Preset::FrameAndStack),
            A::LayoutTwoSlopes => self.lay_out(Preset::TwoSlopes),
            A::LayoutThreeSlopes => self.lay_out(Preset::Slopes(3)),
            A::LayoutFiveSlopes => self.lay_out(Preset::Slopes(5)),
            A::LayoutSevenSlopes => self.lay_out(Preset::Slopes(7)),
            A::LayoutNineSlopes => self.lay_out(Preset::Slopes(9)),
            A::LayoutSlice => self.lay_out(Preset::Slice),
            A::LayoutScales => self.lay_out(Preset::Scales),
            A::LayoutTwoByTwo => self.lay_out(Preset::TwoByTwo),
            A::Undo | A::Redo => {
                let mut history = std::mem::take(&mut self.model.history);
                if id == A::Undo {
                    history.undo(&mut self.model);
                } else {
                    history.redo(&mut self.model);
                }
                self.model.history = history;
                // Every pane goes to its earlier place, and none follows another.
                (self.cursors_set, self.history_set) = (true, true);
            }
            A::ProbePlace => self.probe_here(),
            A::ProbeFeature => self.model.selected.into_iter().for_each(|index| self.model.probe_feature(index)),
            A::ProbeStrongest => self.model.ask_probe(ProbeQuestion::Strongest),
            A::ProbeFollow => self.model.follow_with_probe(),
            A::CloseProbe => {
                self.model.probe.clear();
            }
            A::CopyRow => self.copy_row(ctx),
            A::PinResult => {
                self.model.pin_result();
                self.model.bottom_tab = BottomTab::Compared;
                self.model.messages.note("Pinned: later detections are compared with these features");
            }
            A::UnpinResult => self.model.unpin_result(),
            A::OpenFeatures => self.ask(Purpose::OpenFeatures),
            A::CloseFeatures => self.model.forget_foreign(),
            A::ShowTruth => {
                let on = self.model.against.with == Some(With::Truth);
                self.model.against.show((!on).then_some(With::Truth));
                self.model.bottom_tab = BottomTab::Compared;
            }
            A::CopyCommand => self.copy_command(ctx),
            A::CopyPicture => {
                if let Some(image) = clipboard::picture_of(&self.model, self.model.focus()) {
                    ctx.copy_image(image);
                    self.model.messages.note("Copied the picture");
                }
            }
            A::ExportProfile => self.ask(Purpose::Export(ExportKind::Profile)),
            A::Palette => self.overlays.palette.open(),
            A::Shortcuts => self.overlays.sheet_open = !self.overlays.sheet_open,
            A::About => self.overlays.about_open = true,
            _ => change_model(&mut self.model, id),
        }
    }

    /// Probes the place under the pointer, or the middle of what is seen.
    fn probe_here(&mut self) {
        let middle = || {
            let visible = self.widgets.get(self.model.focus())?.picture.visible_image?.center();
            let (width, height) = self.model.size();
            let within = |x: f32, n: usize| x.clamp(0.0, n.saturating_sub(1) as f32);
            Some([within(visible.x, width), within(visible.y, height)])
        };
        if let Some(place) = self.model.probe.pointer.or_else(middle) {
            self.model.probe.follows = false;
            self.model.probe_place(place);
        }
    }

    /// Lays out a preset, made from the focused pane.
    fn lay_out(&mut self, preset: Preset) {
        self.change_panes(Change::LayOut(self.model.focus(), preset));
    }

    /// Changes the view of the focused pane, and of those linked to it.
    fn change_views(&mut self, change: impl Fn(&mut View)) {
        let (focus, shown) = (self.model.focus(), self.model.visible_panes());
        let is_linked = self.model.focused().links.view;
        for (id, pane) in self.model.panes.iter_mut() {
            if id == focus || (is_linked && pane.links.view && shown.contains(&id)) {
                change(&mut pane.view);
            }
        }
    }
}
