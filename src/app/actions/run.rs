//! What each action does.

use super::ActionId;
use crate::app::canvas::View;
use crate::app::canvas::overlay::ColourBy;
use crate::app::clipboard;
use crate::app::dialogs::{ExportKind, Purpose};
use crate::app::inspector::Change;
use crate::app::measure::Tool;
use crate::app::pane::{Content, Direction, Link, Preset};
use crate::app::project::against::With;
use crate::app::project::cursor::{ViewKind, play_step_of, snapped, stepped};
use crate::app::project::pair::Side;
use crate::app::project::workspace::Workspace;
use crate::app::project::{BottomTab, Model};
use crate::app::window::BurstscopeApp;
use crate::detector::{Method, SearchParams, Slope, SlopeChoice, SlopeGrid};
use crate::engine::{BurstSource, MapKind, ProbeQuestion};
use crate::synth::Example;

impl BurstscopeApp {
    /// Does an action, as if it had been chosen from a menu. One that cannot be done now does nothing.
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
            A::OpenAliasing => self.open(BurstSource::Example(Example::Aliasing)),
            A::OpenLowContrast => self.open(BurstSource::Example(Example::LowContrast)),
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
                self.start_detection();
                if self.model.workspace == Workspace::Pair && self.model.pair.b.param_error.is_none() {
                    self.start_second_detection();
                }
            }
            A::DetectAll => self.ask_and_detect_all(),
            A::CancelDataset => self.engine.datasets.cancel(),
            A::PreviousBurst => self.step_burst(-1),
            A::NextBurst => self.step_burst(1),
            A::BurstAsA => self.choose_open_burst(0),
            A::BurstAsB => self.choose_open_burst(1),
            A::MatchPairs => self.match_pairs(),
            A::MatchSelected => self.match_selected(),
            A::ShowPair => self.show_selected_pair(),
            A::ExportDatabase => self.ask(Purpose::ExportDatabase),
            A::OpenEstimate => self.ask(Purpose::OpenEstimate),
            A::OpenTruth => self.ask(Purpose::OpenTruth),
            A::CloseTrajectories => self.model.trajectories.clear(),
            A::CutSequence => self.ask_for_cut(),
            A::FeatureFolder => self.ask(Purpose::FeatureFolder),
            A::UseFolderParams => self.use_folder_params(),
            A::CloseDataset => self.close_dataset(),
            A::Cancel => self.cancel_all(),
            A::GoToFeature if self.model.workspace == Workspace::Pair => self.go_to_match(),
            A::GoToFeature => self.go_to_selected(),
            A::OpenFolderB => self.ask(Purpose::OpenFolderB),
            A::OpenFilesB => self.ask(Purpose::OpenFilesB),
            A::OpenPathB => self.open_path_field(Purpose::OpenPathB, false),
            A::OpenDemoB => self.open_second(BurstSource::DemoLater),
            A::OpenGoldA => self.ask(Purpose::OpenGold(Side::A)),
            A::OpenGoldB => self.ask(Purpose::OpenGold(Side::B)),
            A::CloseB => self.close_second(),
            A::SwapSides => self.swap_sides(),
            A::Match => self.start_matching(),
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
                // Every pane goes to where it was, and none follows another.
                (self.cursors_set, self.history_set) = (true, true);
            }
            A::ProbePlace => self.probe_here(),
            A::ProbeFeature => self.model.selected.into_iter().for_each(|index| self.model.probe_feature(index)),
            A::ProbeStrongest => self.model.ask_probe(ProbeQuestion::Strongest),
            A::ProbeFollow => self.follow_with_probe(),
            A::CloseProbe => {
                self.forget_probe();
                self.model.probe.clear();
            }
            A::CopyRow => self.copy_row(ctx),
            A::PinResult => {
                self.model.pin_result();
                self.model.bottom_tab = BottomTab::Compared;
                self.model.messages.note("Pinned: later detections are shown against these features");
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

    /// Lays out a preset, made from the pane in focus.
    fn lay_out(&mut self, preset: Preset) {
        self.change_panes(Change::LayOut(self.model.focus(), preset));
    }

    /// Changes the view of the pane in focus, and of those that are linked to it.
    fn change_views(&mut self, change: impl Fn(&mut View)) {
        let linked = match self.model.workspace {
            Workspace::Pair | Workspace::Methods if self.model.pair.links.views => self.model.visible_panes(),
            Workspace::Inspect if self.model.focused().links.has(Link::View) => self.model.visible_panes(),
            _ => Vec::new(),
        };
        let (focus, in_burst) = (self.model.focus(), self.model.workspace == Workspace::Inspect);
        for (id, pane) in self.model.panes.iter_mut() {
            if id == focus || (linked.contains(&id) && (!in_burst || pane.links.has(Link::View))) {
                change(&mut pane.view);
            }
        }
    }
}

/// The actions that only change what is shown.
fn change_model(model: &mut Model, id: ActionId) {
    use ActionId as A;
    match id {
        A::WorkspaceInspect => model.workspace = Workspace::Inspect,
        A::WorkspacePair => model.workspace = Workspace::Pair,
        A::WorkspaceMatches => model.workspace = Workspace::Matches,
        A::WorkspaceTrajectories => model.workspace = Workspace::Trajectories,
        A::WorkspaceMethods => model.workspace = Workspace::Methods,
        A::MeasureLine => model.measure.toggle(Tool::Line),
        A::MeasureRegion => model.measure.toggle(Tool::Region),
        A::ClearMeasure => model.measure.clear(),
        A::ClearSelection if model.measure.tool != Tool::Pan => model.measure.toggle(model.measure.tool),
        A::NextPane => model.panes.focus_next(true),
        A::PreviousPane => model.panes.focus_next(false),
        A::NextLayout if model.workspace == Workspace::Inspect => model.panes.next_over(),
        A::Flip if model.workspace == Workspace::Inspect => model.panes.flip(),
        A::NextLayout => {
            model.compare.look.layout = model.compare.look.layout.next(model.burst_of(Side::B).is_some());
        }
        A::Flip => model.compare.look.flipped ^= true,
        A::CompareAgain => model.compare.forget_failures(),
        A::ToggleOverlay if model.workspace == Workspace::Methods => model.compare.look.features ^= true,
        A::ToggleOverlay if model.workspace == Workspace::Pair => model.pair.look.features ^= true,
        A::ToggleOverlay => model.look.overlay ^= true,
        A::ToggleMotion => model.look.motion_vectors ^= true,
        A::ToggleOrientation => model.look.orientations ^= true,
        A::ToggleLegend => model.look.legend ^= true,
        A::NextColouring => {
            let place = ColourBy::ALL.iter().position(|c| *c == model.colour_by).unwrap_or(0);
            model.colour_by = ColourBy::ALL[(place + 1) % ColourBy::ALL.len()];
        }
        A::ToggleLeft => model.panels.left ^= true,
        A::ToggleRight => model.panels.right ^= true,
        A::ToggleBottom => model.panels.bottom ^= true,
        A::ToggleFilmstrip => model.panels.filmstrip ^= true,
        A::ThemeSystem => model.theme = egui::ThemePreference::System,
        A::ThemeLight => model.theme = egui::ThemePreference::Light,
        A::ThemeDark => model.theme = egui::ThemePreference::Dark,
        A::AutoDetect => model.auto_detect ^= true,
        A::ResetParams => model.set_search(SearchParams::default()),
        A::Preset1d => {
            (model.params.method, model.slopes) = (Method::Buff, SlopeChoice::Given);
            model.params.slopes = SlopeGrid::line(-3.0..=3.0, 7);
        }
        A::Preset2d => {
            (model.params.method, model.slopes) = (Method::Buff, SlopeChoice::Given);
            model.params.slopes = SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7);
        }
        A::PresetSift => model.params.method = Method::Sift,
        A::NextFeature if model.workspace == Workspace::Pair => model.pair.select_neighbour(true),
        A::PreviousFeature if model.workspace == Workspace::Pair => model.pair.select_neighbour(false),
        A::StrongestFeature if model.workspace == Workspace::Pair => {
            model.pair.selected = model.pair.listed.first().copied();
        }
        A::ClearSelection if model.workspace == Workspace::Pair => model.ask_feature(None),
        A::NextFeature => model.select_neighbour(true),
        A::PreviousFeature => model.select_neighbour(false),
        A::StrongestFeature => model.selected = model.listed.first().copied(),
        A::ClearSelection => (model.selected, model.against.selected) = (None, None),
        A::ClearFilter => model.filter = Default::default(),
        A::OtherSide => model.pair.active = model.active_side().other(),
        A::LinkCursors => {
            model.pair.links.cursor ^= true;
            if model.pair.links.cursor {
                model.bring_hands_together();
            }
        }
        A::LinkViews => model.pair.links.views ^= true,
        A::LinkRanges => {
            model.link_ranges(!model.ranges_are_linked());
        }
        A::ResetMatching => model.pair.params = Default::default(),
        A::ToggleInliers => model.pair.look.inliers ^= true,
        A::ToggleOutliers => model.pair.look.outliers ^= true,
        A::ToggleAlone => model.pair.look.alone ^= true,
        A::ToggleEpipolar => model.pair.look.geometry ^= true,
        _ => move_hand(model, id),
    }
}

/// The actions that move the cursor of the pane in focus.
fn move_hand(model: &mut Model, id: ActionId) {
    use ActionId as A;
    let grid = model.cursor_params().slopes;
    let slope = model.cursor().slope;
    let slope = match id {
        A::SlopeULess => Some(stepped(&grid, slope, false, false)),
        A::SlopeUMore => Some(stepped(&grid, slope, false, true)),
        A::SlopeVLess => Some(stepped(&grid, slope, true, false)),
        A::SlopeVMore => Some(stepped(&grid, slope, true, true)),
        A::SlopeZero => Some(Slope::default()),
        A::SnapSlope => Some(snapped(&grid, slope)),
        _ => None,
    };
    if let Some(slope) = slope {
        model.playing = false;
        let pane = model.focused_mut();
        pane.cursor.slope = slope;
        pane.show_slope();
    }
    if id == A::BusiestSlope {
        model.playing = false;
        model.go_to_busiest_slope(model.focus());
        model.focused_mut().show_slope();
    }
    let pane = model.focused_mut();
    let cursor = &mut pane.cursor;
    match id {
        A::FramePrevious => cursor.frame = cursor.frame.saturating_sub(1),
        A::FrameNext => cursor.frame += 1,
        A::OctaveFiner => cursor.octave -= 1,
        A::OctaveCoarser => cursor.octave += 1,
        A::LevelDown => cursor.level -= 1,
        A::LevelUp => cursor.level += 1,
        _ => {}
    }
    // A key that moves through frames or scales is meant to be seen.
    match id {
        A::ShowFrame | A::FramePrevious | A::FrameNext => pane.show(ViewKind::Frame),
        A::ShowStack => pane.show(ViewKind::Stack),
        A::ShowDog => pane.show(ViewKind::Dog),
        A::OctaveFiner | A::OctaveCoarser | A::LevelDown | A::LevelUp => pane.show_scale(),
        A::ShowMerge => pane.content = Content::Merge,
        A::ShowNoise => pane.content = Content::Map(MapKind::Noise),
        A::ShowMotion => pane.content = Content::Map(MapKind::Motion),
        A::ShowCoverage => pane.content = Content::Map(MapKind::Coverage),
        _ => {}
    }
    model.check_params();
}
