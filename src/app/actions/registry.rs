//! Registry of the actions: a row each, with label, menu, key, help, what it does, when it is possible and whether it
//! is on.

use super::when;
use crate::app::apply::{change, comparison, datasets, opening, pair, panes, probe, studies};
use crate::app::document::cursor::{snapped, stepped};
use crate::app::document::{Cursor, Document, ExportKind, Purpose, Reference, Side, Visibility};
use crate::app::measure::Tool;
use crate::app::pane::{Direction, Link, Preset};
use crate::app::results::{Effect, Model, Read};
use crate::app::view::View;
use crate::detector::{Method, SearchParams, Slope, SlopeGrid};
use crate::engine::Engine;
use crate::inspect::place::Verdict;
use crate::matching::MatchParams;
use crate::requests::{BurstSource, ProbeQuestion, ViewKind, Which};
use crate::synth::Example;
use crate::teach::Workspace;
use crate::teach::glossary::{Word, glossary};
use egui::{Key, KeyboardShortcut, Modifiers, ThemePreference};
use serde::{Deserialize, Serialize};
use strum::{EnumCount, IntoStaticStr, VariantArray};

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, EnumCount, IntoStaticStr, VariantArray)]
pub enum Menu {
    File,
    Edit,
    View,
    Panes,
    #[strum(serialize = "Slope and frame")]
    Cursor,
    #[strum(serialize = "Detection")]
    Detect,
    Features,
    Pair,
    Dataset,
    Help,
}

impl Menu {
    pub const ALL: [Self; Self::COUNT] = *Self::VARIANTS.first_chunk().expect("as many");

    pub fn label(self) -> &'static str {
        self.into()
    }

    pub fn parent(self) -> Option<Self> {
        matches!(self, Self::Panes | Self::Cursor).then_some(Self::View)
    }

    pub fn submenu(self, group: u8) -> Option<&'static str> {
        Some(match (self, group) {
            (Self::File, 2) => "Parameters",
            (Self::File, 3) => "Export features",
            (Self::File, 4) => "Export pictures",
            (Self::File, 5) => "Export profile and matches",
            (Self::View, 0) => "Workspace",
            (Self::View, 1) => "Picture",
            (Self::View, 5) => "Theme",
            (Self::Panes, 1) => "Layout",
            (Self::Detect, 1) => "Preset",
            (Self::Detect, 4) => "Lab",
            (Self::Help, 1) => "Examples",
            _ => return None,
        })
    }

    /// Whether there is what the menu is about. Its actions are found by their names, or by their keys, in any case.
    pub fn has_content(self, model: Read<'_>) -> bool {
        match self {
            Self::Pair => model.document.workspace.shows_pair() || model.results.slots.b.burst.is_some(),
            Self::Dataset => model.results.datasets.open.is_some() || model.document.workspace.record().is_of_dataset,
            _ => true,
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct ActionRow {
    pub id: ActionId,
    /// Label; ends in `…` when the action first asks for something.
    pub label: &'static str,
    pub menu: Menu,
    /// Group within the menu; a line separates groups.
    pub group: u8,
    pub shortcut: Option<KeyboardShortcut>,
    pub help: &'static str,
    /// All that the action does, but for those of the shell: what needs the lesson, the screen or a dialog.
    pub does: Option<Does>,
    /// When the action is possible, where `does` does not decide it.
    when: Option<fn(Read<'_>) -> bool>,
    /// Whether it is on, of a switch or choice that does not follow from what it does.
    is_on: Option<fn(Read<'_>) -> bool>,
}

#[derive(Debug, Clone, Copy)]
pub enum Does {
    Ask(Purpose),
    Open(fn() -> BurstSource),
    Workspace(Workspace),
    LayOut(Preset),
    Show(ViewKind),
    Switch {
        is_on: fn(&Document) -> bool,
        turn: fn(&mut Document),
    },
    Set(fn(&mut Document)),
    Slope(fn(&SlopeGrid, Slope) -> Slope),
    /// Goes to another frame, and shows it.
    Frame(fn(&mut Cursor)),
    /// Goes to another octave or level, and shows a picture of a scale.
    Scale(fn(&mut Cursor)),
    Run(fn(&mut Model, &Engine)),
    /// Changes the project and things beyond, such as files.
    Change(fn(&mut Model, &Engine) -> Option<Effect>),
}

pub fn enabled(id: ActionId, model: Read<'_>) -> bool {
    let ActionRow { when, does, .. } = id.action();
    match (when, does) {
        (Some(when), _) => when(model),
        (None, Some(Does::LayOut(_))) => when::inspects_burst(model),
        (None, Some(Does::Show(_))) => when::has_burst(model),
        _ => true,
    }
}

/// Whether a switch is on, or a choice made; `None` of other actions.
pub fn checked(id: ActionId, model: Read<'_>) -> Option<bool> {
    let ActionRow { is_on, does, .. } = id.action();
    match (is_on, *does) {
        (Some(is_on), _) => Some(is_on(model)),
        (None, Some(Does::Workspace(workspace))) => Some(model.document.workspace == workspace),
        (None, Some(Does::Show(kind))) => Some(model.document.focused().shown() == Some(kind)),
        (None, Some(Does::Switch { is_on, .. })) => Some(is_on(model.document)),
        _ => None,
    }
}

impl ActionId {
    pub fn shown(self) -> Option<ViewKind> {
        if let Some(Does::Show(kind)) = self.action().does { Some(kind) } else { None }
    }

    pub fn action(self) -> &'static ActionRow {
        ACTIONS.iter().find(|a| a.id == self).expect("the macro below makes a row for each id")
    }

    pub fn word(self) -> Option<&'static Word> {
        glossary().of_picture(if self == Self::LayoutSlice { "slice" } else { self.shown()?.key() })
    }
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

macro_rules! actions {
    ($($id:ident, $menu:ident $group:literal, $label:literal, [$($modifiers:ident $key:ident)?], $help:literal $(=> $does:ident($($of:tt)*))? $(, when $when:expr)? $(, on $on:expr)?;)*) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum ActionId {
            $(#[doc = $help] $id,)*
        }

        pub const ACTIONS: &[ActionRow] = &[
            $(ActionRow {
                id: ActionId::$id,
                label: $label,
                menu: Menu::$menu,
                group: $group,
                shortcut: actions!(@shortcut $($modifiers $key)?),
                help: $help,
                does: actions!(@does $($does($($of)*))?),
                when: actions!(@some $($when)?),
                is_on: actions!(@some $($on)?),
            },)*
        ];
    };
    (@does) => { None };
    (@does Switch($($value:tt)*)) => {
        Some(Does::Switch { is_on: |document| document.$($value)*, turn: |document| document.$($value)* ^= true })
    };
    (@does $does:ident($($of:tt)*)) => { Some(Does::$does($($of)*)) };
    (@some) => { None };
    (@some $value:expr) => { Some($value) };
    (@shortcut) => { None };
    (@shortcut $modifiers:ident $key:ident) => { Some(KeyboardShortcut::new($modifiers, Key::$key)) };
}

actions! {
    OpenFolder, File 0, "Open folder…", [CTRL O], "Open a folder of frames" => Ask(Purpose::OpenFolder(Side::A));
    OpenFiles, File 0, "Open files…", [CTRL_SHIFT O], "Open image files, a multi-page TIFF or a .npy stack" => Ask(Purpose::OpenFiles(Side::A));
    OpenDataset, File 0, "Open dataset…", [CTRL_SHIFT D], "Open a folder of bursts, or a long sequence that is cut into bursts" => Ask(Purpose::OpenDataset);
    OpenPath, File 0, "Open path…", [CTRL L], "Type or paste the path of a burst";
    Calibration, File 0, "Calibration…", [], "Bias and flat frame, black level, full scale, linear light, colours of raw frames";
    OpenDemo, File 0, "Open demo burst", [], "Open the burst that is built into the program" => Open(|| BurstSource::Demo);
    RestoreSession, File 1, "Open session…", [], "Restore the burst, parameters, view and selection from a session file" => Ask(Purpose::RestoreSession);
    SaveSession, File 1, "Save session…", [CTRL S], "Write the burst's path, parameters, view and selection to a file" => Ask(Purpose::SaveSession), when when::has_burst;
    SaveCase, File 1, "Save case…", [], "Write the frames, the search, the panes, the pinned result and the probed place to one file, which opens like a burst on any machine" => Ask(Purpose::Export(ExportKind::Case)), when when::has_burst;
    Report, File 1, "Report…", [], "Write what this burst is, its slopes, noise, tests and false features, and what became of the pinned and the probed places, on one page" => Ask(Purpose::Export(ExportKind::Report)), when |model| when::active(model).found.is_some();
    LoadParams, File 2, "Load parameters…", [], "Read detector parameters from a TOML file" => Ask(Purpose::LoadParams);
    SaveParams, File 2, "Save parameters…", [CTRL_SHIFT S], "Write the detector parameters to a TOML file, as --params reads it" => Ask(Purpose::SaveParams);
    ExportCsv, File 3, "Export features as CSV…", [CTRL E], "Write one row for each feature, strongest first" => Ask(Purpose::Export(ExportKind::Csv)), when |model| when::active(model).found.is_some();
    ExportColmap, File 3, "Export features for COLMAP…", [], "Write features and descriptors as COLMAP imports them" => Ask(Purpose::Export(ExportKind::Colmap)), when |model| when::active(model).found.is_some();
    ExportNpz, File 3, "Export features as NPZ…", [], "Write features and descriptors as NumPy arrays" => Ask(Purpose::Export(ExportKind::Npz)), when |model| when::active(model).found.is_some();
    ExportTiff, File 4, "Export picture as 32-bit TIFF…", [], "Write the picture's values as they are" => Ask(Purpose::Export(ExportKind::Tiff)), when when::has_picture;
    ExportPng, File 4, "Export picture as PNG…", [CTRL_SHIFT E], "Write the picture as it is shown, in its range and colours" => Ask(Purpose::Export(ExportKind::Png)), when when::has_picture;
    FigureOptions, File 4, "Export figure…", [], "Write the panes with their overlays for a paper: choose PDF, SVG or PNG, width, letters, and what is shown", when when::has_picture;
    ExportFigure, File 4, "Export figure as before…", [], "Write the panes with their overlays with the choices of the last figure" => Ask(Purpose::Export(ExportKind::Figure)), when when::has_picture;
    FilmOptions, File 4, "Export film…", [], "Choose a sweep over slopes, scales or frames; its size and rate are said before it is written", when when::has_burst;
    ExportFilmGif, File 4, "Export film as before…", [], "Write the film of the last choice, a sweep over the slopes at first, as an animation (GIF, MP4) or as PNG pictures" => Ask(Purpose::Export(ExportKind::Film)), when when::has_burst;
    ExportProfile, File 5, "Export line profile as CSV…", [], "Write the values along the line in all linked panes" => Ask(Purpose::Export(ExportKind::Profile)), when |model| model.document.measure.line.is_some() && when::in_inspect(model);
    ExportMatches, File 5, "Export matches as CSV…", [], "Write one row for each match of two bursts" => Ask(Purpose::Export(ExportKind::Matches)), when |model| model.results.pair.matches.is_some();
    ExportMethods, File 5, "Export table of methods…", [], "Write the numbers of all methods as CSV, or as LaTeX to a name that ends in .tex" => Ask(Purpose::Export(ExportKind::Methods)), when |model| model.document.compares_methods() && !model.methods_shown().is_empty();
    Quit, File 6, "Quit", [CTRL Q], "Close the window";

    Undo, Edit 0, "Undo", [CTRL Z], "Undo the last change of a parameter or slope", when |model| model.shell.history.can_undo();
    Redo, Edit 0, "Redo", [CTRL_SHIFT Z], "Make the undone change again", when |model| model.shell.history.can_redo();
    CopyRow, Edit 1, "Copy row or value", [], "Copy the selected feature or match, or else the value under the pointer (also Ctrl+C)", when when::has_burst;
    CopyCommand, Edit 1, "Copy as command", [CTRL_SHIFT K], "Copy the command that finds the features of this burst with these parameters", when |model| when::has_burst(model) && when::active(model).param_error.is_none();
    CopyPicture, Edit 1, "Copy picture", [], "Copy the picture in focus as it is shown, in its range and colours", when when::has_picture;
    MeasureLine, Edit 2, "Line profile", [NONE Q], "Draw a line with the pointer, to see the values along it in all linked panes" => Set(|document| document.measure.toggle(Tool::Line)), when when::inspects_burst, on |model| model.document.measure.tool == Tool::Line;
    MeasureRegion, Edit 2, "Region statistics", [SHIFT Q], "Draw a rectangle with the pointer, to see mean, deviation, range and noise in it" => Set(|document| document.measure.toggle(Tool::Region)), when when::inspects_burst, on |model| model.document.measure.tool == Tool::Region;
    DrawMask, Edit 2, "Draw mask", [], "Drag around what the frames do not show, such as a robot's arm or a time stamp" => Set(|document| document.measure.toggle(Tool::Mask)), when when::inspects_burst, on |model| model.document.measure.tool == Tool::Mask;
    UseMask, Edit 2, "Save mask…", [], "Write what was drawn around, and what is masked in all frames, to a picture that masks the frames" => Ask(Purpose::Export(ExportKind::Mask)), when |model| !model.document.measure.hidden.is_empty() && when::in_inspect(model);
    ClearMeasure, Edit 2, "Clear line, region and outlines", [], "Remove what was drawn on the picture; the pointer pans again" => Set(|document| document.measure.clear()), when |model| !model.document.measure.is_empty();

    WorkspaceInspect, View 0, "One burst", [CTRL Num1], "One burst: its pictures and features" => Workspace(Workspace::Inspect), on |model| when::in_inspect(model) && !model.document.compares_methods();
    WorkspacePair, View 0, "Two bursts", [CTRL Num2], "Two bursts side by side, and the matches between them" => Workspace(Workspace::Pair);
    WorkspaceMethods, View 0, "Methods", [CTRL Num3], "Several methods on the same burst: their pictures, matches and numbers" => Set(Document::compare_methods), on |model| model.document.compares_methods();
    WorkspaceMatches, View 0, "Matches", [CTRL Num4], "Matches of all pairs of a dataset" => Workspace(Workspace::Matches);
    WorkspaceTrajectories, View 0, "Trajectories", [CTRL Num5], "An estimated trajectory against the true one" => Workspace(Workspace::Trajectories);
    WorkspaceLab, View 0, "Lab", [CTRL Num6], "Methods and parameters measured on charts with known truth" => Workspace(Workspace::Lab);
    ShowFrame, View 1, "Show frame", [NONE Num1], "Show one frame as it was taken" => Show(ViewKind::Frame);
    ShowStack, View 1, "Show motion stack", [NONE Num2], "Show the mean of the frames, shifted by the slope" => Show(ViewKind::Stack);
    ShowDog, View 1, "Show DoG", [NONE Num3], "Show the difference of Gaussians of the motion stack, which the detector searches" => Show(ViewKind::Dog);
    ShowMerge, View 1, "Show merged frames", [NONE Num4], "Show the frames aligned tile by tile and merged into one image" => Show(ViewKind::Merge);
    ShowNoise, View 1, "Show local noise", [SHIFT N], "Show the noise of the response at each place, at the slope, octave and level, as the noise gate uses it" => Show(ViewKind::Noise);
    ShowCoverage, View 1, "Show coverage", [SHIFT C], "Show the share of the frames that see each place, at the slope" => Show(ViewKind::Coverage);
    ShowMotion, View 1, "Show winning slope", [SHIFT V], "Show the slope of the strongest response at each place, at the octave and level: a picture of the motion" => Show(ViewKind::Motion);
    ShowField, View 1, "Show field of motion", [SHIFT U], "Show the motion of every place, from all that lies around it; grey where it is unknown" => Show(ViewKind::Field);
    ShowInFocus, View 1, "Show all in focus", [SHIFT I], "Show the mean of the frames, each place shifted by its own motion: near and far are sharp at once" => Show(ViewKind::InFocus);
    ShowMedian, View 1, "Show median", [], "Show the median of the frames, shifted by the slope" => Show(ViewKind::Median);
    ShowClippedMean, View 1, "Show clipped mean", [], "Show the mean of the frames, shifted by the slope, without values far from the median" => Show(ViewKind::ClippedMean);
    ShowMax, View 1, "Show maximum", [], "Show the largest value of the frames, shifted by the slope" => Show(ViewKind::Max);
    ShowMin, View 1, "Show minimum", [], "Show the smallest value of the frames, shifted by the slope" => Show(ViewKind::Min);
    ShowDeviation, View 1, "Show deviation", [], "Show the standard deviation of the frames, shifted by the slope" => Show(ViewKind::Deviation);
    ShowMeanMinusMedian, View 1, "Show mean minus median", [], "Show what is in some frames only, shifted by the slope: satellites, cars, lamps that switch, hot pixels" => Show(ViewKind::MeanMinusMedian);
    Fit, View 2, "Fit picture", [NONE F], "Show the whole picture" => Set(|document| document.change_views(View::set_fit)), when when::has_burst;
    OneToOne, View 2, "Zoom 1:1", [NONE Num0], "Show one picture pixel on one screen pixel", when when::has_burst;
    ZoomIn, View 2, "Zoom in", [NONE Plus], "Enlarge around the centre" => Set(|document| document.change_views(|view| view.zoom_by(1.25))), when when::has_burst;
    ZoomOut, View 2, "Zoom out", [NONE Minus], "Reduce around the centre" => Set(|document| document.change_views(|view| view.zoom_by(0.8))), when when::has_burst;
    ToggleOverlay, View 3, "Features over the picture", [NONE O], "Draw the features of this slope, all features, or none" => Set(|document| (document.workspace.record().toggle_features)(document)), on when::draws_features;
    DrawAll, View 3, "All circles", [SHIFT L], "Draw the circle of every feature, however close they lie, or of the strongest of each part of the view" => Switch(look.draws_all);
    ToggleMotion, View 3, "Motion vectors", [NONE M], "Show or hide each feature's motion over the burst" => Switch(look.motion_vectors);
    ToggleOrientation, View 3, "Orientation ticks", [NONE R], "Show or hide each feature's orientation" => Switch(look.orientations);
    ToggleLegend, View 3, "Legend", [NONE L], "Show or hide the legend of the features' colours" => Switch(look.legend);
    FocusUnderPointer, View 3, "Focus under the pointer", [SHIFT Z], "Show the place under the pointer at its own motion, as long as this is on, or while Ctrl is held" => Switch(follows_focus), when when::inspects_burst;
    FocusLoupe, View 3, "Focus in a loupe", [], "Show that place in a loupe beside the pointer, in one frame, the motion stack and all in focus, and leave the pane as it is; a click takes the slope" => Switch(panels.loupe), when when::inspects_burst;
    AutoContrast, View 3, "Auto contrast", [SHIFT A], "Set contrast and brightness so that all but the darkest and brightest 0.1 % of the values can be told apart" => Run(|model, _| panes::auto_contrast(model)), when when::has_picture;
    NextColouring, View 3, "Next feature colouring", [NONE C], "Colour features by slope, scale, response, SNR, slope limit or coherence in turn" => Set(change::colour_next);
    ToggleLeft, View 4, "Cursor and parameters", [CTRL B], "Show or hide the panel on the left" => Run(change::toggle_left), on |model| model.shows_left();
    ToggleRight, View 4, "Feature and display", [CTRL R], "Show or hide the panel on the right: the selected feature, contrast, brightness and colours" => Run(|model, _| model.document.panels.right = Visibility::from(!Read::of(model).shows_right())), on |model| model.shows_right();
    ToggleBottom, View 4, "Table and tally", [CTRL J], "Show or hide the panel below" => Run(|model, _| model.document.panels.bottom = Visibility::from(!Read::of(model).shows_bottom())), on |model| model.shows_bottom();
    ToggleFilmstrip, View 4, "Filmstrip", [CTRL K], "Show or hide the bursts of the dataset" => Switch(panels.filmstrip), when when::has_dataset;
    ThemeSystem, View 5, "Theme as the system", [], "Follow the system's light or dark theme" => Set(|document| document.theme = ThemePreference::System), on |model| model.document.theme == ThemePreference::System;
    ThemeLight, View 5, "Light theme", [], "Dark text on a light background" => Set(|document| document.theme = ThemePreference::Light), on |model| model.document.theme == ThemePreference::Light;
    ThemeDark, View 5, "Dark theme", [], "Light text on a dark background" => Set(|document| document.theme = ThemePreference::Dark), on |model| model.document.theme == ThemePreference::Dark;

    SplitRight, Panes 0, "Split right", [NONE S], "Open a second pane on the right of the one in focus" => Set(|document| _ = document.panes.split(document.focus(), Direction::Right)), when when::has_room;
    SplitDown, Panes 0, "Split down", [SHIFT S], "Open a second pane below the one in focus" => Set(|document| _ = document.panes.split(document.focus(), Direction::Down)), when when::has_room;
    ClosePane, Panes 0, "Close pane", [CTRL W], "Close the pane in focus" => Set(|document| document.panes.close(document.focus())), when |model| when::has_burst(model) && when::many_panes(model);
    NextPane, Panes 0, "Next pane", [NONE J], "Focus the next pane, which sliders and keys then move" => Set(|document| document.panes.focus_next(true)), when |model| when::has_burst(model) && when::many_panes(model);
    PreviousPane, Panes 0, "Previous pane", [SHIFT J], "Focus the previous pane, which sliders and keys then move" => Set(|document| document.panes.focus_next(false)), when |model| when::has_burst(model) && when::many_panes(model);
    LayoutSingle, Panes 1, "Layout: single pane", [NONE Num5], "Show the pane in focus alone" => LayOut(Preset::Single);
    LayoutFrameAndStack, Panes 1, "Layout: frame and motion stack", [NONE Num6], "Show one frame beside the motion stack" => LayOut(Preset::FrameAndStack);
    LayoutTwoSlopes, Panes 1, "Layout: two slopes", [NONE Num7], "Show the slope beside the grid's next one, each moved on its own" => LayOut(Preset::TwoSlopes);
    LayoutThreeSlopes, Panes 1, "Layout: 3 slopes", [], "Show three neighbouring slopes of the grid, which move together" => LayOut(Preset::ThreeSlopes);
    LayoutFiveSlopes, Panes 1, "Layout: 5 slopes", [NONE Num8], "Show five neighbouring slopes of the grid, which move together" => LayOut(Preset::FiveSlopes);
    LayoutSevenSlopes, Panes 1, "Layout: 7 slopes", [], "Show seven neighbouring slopes of the grid, which move together" => LayOut(Preset::SevenSlopes);
    LayoutNineSlopes, Panes 1, "Layout: 9 slopes", [], "Show nine neighbouring slopes of the grid, which move together" => LayOut(Preset::NineSlopes);
    LayoutSlice, Panes 1, "Layout: stack and slice", [], "Show the motion stack above the slice of the frames through the probed place, in which motion is a slanted line" => LayOut(Preset::Slice);
    LayoutScales, Panes 1, "Layout: scales of the octave", [], "Show the DoG responses of all levels of the octave" => LayOut(Preset::Scales);
    LayoutTwoByTwo, Panes 1, "Layout: 2 × 2", [NONE Num9], "Show frame, motion stack, DoG response and merged frames of the same place" => LayOut(Preset::TwoByTwo);
    NextLayout, Panes 2, "Next way to compare", [NONE W], "Lay the next pane over this one: as a wipe, as a flip, or not at all" => Set(|document| document.panes.next_over()), when when::many_panes;
    Flip, Panes 2, "Flip", [NONE Y], "Show the other of two pictures in the same place" => Set(|document| document.panes.flip()), when when::flips;

    SlopeULess, Cursor 0, "Previous slope along u", [NONE ArrowLeft], "Go to the grid's previous slope along the first axis" => Slope(|grid, slope| stepped(grid, slope, false, false)), when when::has_burst;
    SlopeUMore, Cursor 0, "Next slope along u", [NONE ArrowRight], "Go to the grid's next slope along the first axis" => Slope(|grid, slope| stepped(grid, slope, false, true)), when when::has_burst;
    SlopeVLess, Cursor 0, "Previous slope along v", [NONE ArrowUp], "Go to the grid's previous slope along the second axis" => Slope(|grid, slope| stepped(grid, slope, true, false)), when when::has_burst;
    SlopeVMore, Cursor 0, "Next slope along v", [NONE ArrowDown], "Go to the grid's next slope along the second axis" => Slope(|grid, slope| stepped(grid, slope, true, true)), when when::has_burst;
    SlopeZero, Cursor 0, "Slope to zero", [NONE Z], "Go to slope (0, 0): the plain mean of the frames" => Slope(|_, _| Slope::default()), when when::has_burst;
    SnapSlope, Cursor 0, "Snap slope to grid", [NONE G], "Go to the grid's nearest slope" => Slope(snapped), when when::has_burst;
    BusiestSlope, Cursor 0, "Slope with most features", [NONE B], "Go to the slope at which most features were found, not counting the ends of the range" => Run(change::go_to_busiest_slope), when |model| when::active(model).found.is_some();
    Play, Cursor 0, "Play", [NONE Space], "Step through what the picture shows: its frames, the slopes of its row, or scales" => Run(|model, _| panes::toggle_play(model)), when |model| when::has_burst(model) && model.sweep().0 > 1, on |model| model.document.playing;
    FramePrevious, Cursor 1, "Previous frame", [NONE Comma], "Go one frame back" => Frame(|cursor| cursor.frame = cursor.frame.saturating_sub(1)), when |model| when::has_burst(model) && model.focused_frame_count() > 1;
    FrameNext, Cursor 1, "Next frame", [NONE Period], "Go one frame on" => Frame(|cursor| cursor.frame += 1), when |model| when::has_burst(model) && model.focused_frame_count() > 1;
    OctaveFiner, Cursor 2, "Finer octave", [NONE OpenBracket], "Halve the scale of the DoG" => Scale(|cursor| cursor.octave -= 1), when when::has_burst;
    OctaveCoarser, Cursor 2, "Coarser octave", [NONE CloseBracket], "Double the scale of the DoG" => Scale(|cursor| cursor.octave += 1), when when::has_burst;
    LevelDown, Cursor 2, "Previous level", [NONE PageDown], "Go one level down in the octave" => Scale(|cursor| cursor.level -= 1), when when::has_burst;
    LevelUp, Cursor 2, "Next level", [NONE PageUp], "Go one level up in the octave" => Scale(|cursor| cursor.level += 1), when when::has_burst;

    Detect, Detect 0, "Detect", [NONE D], "Find features with these parameters" => Run(change::detect), when when::can_detect;
    Cancel, Detect 0, "Cancel", [NONE Escape], "Stop the detection or the opening" => Run(|model, _| Read::of(model).cancel_searches()), when |model| model.is_searching();
    AutoDetect, Detect 0, "Detect after each change", [NONE A], "Detect by itself whenever a parameter or the burst changes" => Switch(auto_detect);
    Preset1d, Detect 1, "Preset BuFF 1D", [], "Search seven horizontal slopes over ±3 px/frame" => Set(|document| (document.params.method, document.params.slopes) = (Method::Buff, SlopeGrid::default().into())), on when::searches_line;
    Preset2d, Detect 1, "Preset BuFF 2D", [], "Search slopes in both directions: the present ones, and some to both sides of them" => Run(change::search_plane), on when::searches_plane;
    PresetSift, Detect 1, "Preset SIFT on one frame", [], "Search the middle frame only: the baseline" => Set(|document| document.params.method = Method::Sift), on |model| model.document.params.method == Method::Sift;
    CompareAgain, Detect 2, "Compare again", [], "Run again the methods that failed or were cancelled" => Run(|model, _| model.results.compare.failed.clear()), when |model| model.document.compares_methods();
    OpenGoldA, Detect 2, "Gold standard of A…", [], "Open an image of A's view that was taken with enough light" => Ask(Purpose::OpenGold(Side::A)), when when::has_burst;
    OpenGoldB, Detect 2, "Gold standard of B…", [], "Open an image of B's view that was taken with enough light" => Ask(Purpose::OpenGold(Side::B)), when when::has_both;
    SlopesFromSetUp, Detect 3, "Slopes from the set-up", [], "Compute the slopes from speed, turning, frame rate, lens and depths, and read slopes as depths" => Set(|document| document.show_set_up());
    ResetParams, Detect 3, "Reset parameters", [], "Give every parameter its default" => Set(|document| document.params = SearchParams::default()), when |model| model.asked() != SearchParams::default();
    RunStudy, Detect 4, "Run study", [], "Make the Lab's charts, run the methods on them, and draw the curves as they grow" => Run(studies::run_study), when |model| !model.results.studies.wanted.is_pending() && model.lab_study().is_ok();
    CancelStudy, Detect 4, "Cancel study", [], "Stop the Lab's study; the curves so far stay" => Run(|model, _| model.results.studies.wanted.cancel()), when |model| model.results.studies.wanted.is_pending();
    KeepCurves, Detect 4, "Keep curves", [], "Keep the curves of this study beside those of the next ones" => Run(|model, _| model.results.studies.keep_current()), when |model| model.results.studies.current.is_some() && !model.results.studies.wanted.is_pending();
    OpenChart, Detect 4, "Look at chart as burst", [], "Open the Lab's chart as a burst, with its truth" => Run(change::open_chart), when |model| model.selected_chart().is_some();
    OpenPlanted, Detect 4, "Probe planted thing", [], "Open the copy of the burst with the selected planted thing, and say what became of it" => Run(studies::open_planted), when |model| model.selected_thing().is_some() && when::has_burst(model);
    OpenDarkCopy, Detect 4, "Dark copy of A", [], "Open a copy of the burst with less light; the Lab sets its SNR" => Run(change::open_dark_copy), when when::has_burst;
    ExportCurvesCsv, Detect 4, "Export curves as CSV…", [], "Write one row for each point of the Lab's curves" => Ask(Purpose::Export(ExportKind::CurvesCsv)), when |model| !model.lab_results().is_empty();
    ExportCurvesSvg, Detect 4, "Export curves as SVG…", [], "Write the Lab's plots as a figure" => Ask(Purpose::Export(ExportKind::CurvesSvg)), when |model| !model.lab_results().is_empty();

    NextFeature, Features 0, "Next feature or match", [NONE N], "Select the next feature (or match, with two bursts) of the table" => Run(|model, _| change::select_next(model, true)), when when::lists_any;
    PreviousFeature, Features 0, "Previous feature or match", [NONE P], "Select the previous feature (or match, with two bursts) of the table" => Run(|model, _| change::select_next(model, false)), when when::lists_any;
    StrongestFeature, Features 0, "First feature or match", [NONE Home], "Select the first feature (or match, with two bursts) of the table" => Run(change::select_first), when when::lists_any;
    GoToFeature, Features 0, "Go to the selection", [NONE Enter], "Show the motion stack at the slope of the selected feature or match, with it in the middle" => Run(change::go_to_selection), when when::has_place_to_go;
    ClearSelection, Features 0, "Clear selection", [NONE Escape], "Select no feature and no match" => Set(Document::clear_selection), when when::has_selection;
    ProbePlace, Features 1, "Probe this place", [SHIFT P], "Say why there is a feature at the place under the pointer, or why there is none (also Shift+click)", when when::can_probe;
    ProbeFeature, Features 1, "Why this feature?", [SHIFT W], "Probe the selected feature: its tests, its response, each frame's share, and what may be wrong with it" => Run(change::probe_selection), when |model| model.document.workspace.probes() && model.feature_to_probe().is_some();
    ProbeStrongest, Features 1, "Probe the strongest candidate", [], "Probe the strongest candidate of the whole picture, kept or not" => Run(|model, _| probe::ask_probe(model, Read::of(model).active_side(), ProbeQuestion::Strongest)), when when::can_probe;
    ProbeFollow, Features 1, "Probe follows the pointer", [SHIFT F], "Probe the place under the pointer as it moves, until a place is clicked" => Run(|model, _| probe::follow_with_probe(model)), when when::can_probe, on |model| model.document.probe.follows;
    PinPlace, Features 1, "Pin this place", [], "Keep the probed place with a name: pictures mark it, the probe lists it, and the report of the burst has it" => Run(|model, _| model.document.places.extend(Read::of(model).place_to_pin())), when |model| model.document.workspace.probes() && model.place_to_pin().is_some();
    CloseProbe, Features 1, "Clear probe", [], "Close the probe and free its memory" => Run(|model, _| probe::clear_probe(model)), when |model| model.document.probe.is_on() || model.results.probed.answer.is_some();
    OnlyReal, Features 2, "Only real ones", [SHIFT O], "Hide ghosts, aliases, duplicates and unclear features, here and in exported files" => Set(|document| document.filter.verdict = (document.filter.verdict != Some(Verdict::Real)).then_some(Verdict::Real)), when |model| when::active(model).found.is_some(), on |model| model.document.filter.verdict == Some(Verdict::Real);
    ClearFilter, Features 2, "Clear filter", [], "Show all features" => Set(|document| document.filter = Default::default()), when |model| !model.document.filter.is_open();
    PinResult, Features 3, "Pin this result", [SHIFT D], "Keep these features, to show which ones later detections gain, lose and move" => Run(change::pin_result), when |model| when::active(model).found.is_some();
    UnpinResult, Features 3, "Unpin", [], "Remove the pinned result" => Run(|model, _| comparison::forget_reference(model, Read::of(model).active_side(), Reference::Pinned)), when |model| when::refers_to(model, Reference::Pinned);
    OpenFeatures, Features 3, "Open features…", [], "Compare with features of a file: a CSV table as exported here, or COLMAP's text format" => Change(|model, _| Some(Effect::Ask(Purpose::OpenFeatures(Read::of(model).active_side())))), when when::has_burst;
    CloseFeatures, Features 3, "Close opened features", [], "Stop comparing with the features of the file" => Run(|model, _| comparison::forget_reference(model, Read::of(model).active_side(), Reference::File)), when |model| when::refers_to(model, Reference::File);
    ShowTruth, Features 3, "Compare with the truth", [], "Mark found, missed, repeated and false features, for bursts with known truth" => Run(change::show_truth), when |model| when::refers_to(model, Reference::Truth), on when::shows_truth;

    OpenFolderB, Pair 0, "Open B: folder…", [CTRL_SHIFT B], "Open a folder of frames as the second burst" => Ask(Purpose::OpenFolder(Side::B)), when when::has_burst;
    OpenFilesB, Pair 0, "Open B: files…", [], "Open image files, a multi-page TIFF or a .npy stack as the second burst" => Ask(Purpose::OpenFiles(Side::B)), when when::has_burst;
    OpenPathB, Pair 0, "Open B: path…", [], "Type or paste the path of the second burst", when when::has_burst;
    OpenDemoB, Pair 0, "Later demo burst as B", [], "Open the demo street a little later as the second burst" => Run(|model, engine| _ = opening::open(model, Side::B, BurstSource::DemoLater, engine)), when when::has_burst;
    CloseB, Pair 0, "Close B", [], "Close the second burst" => Run(pair::close_second), when when::has_both;
    SwapSides, Pair 1, "Swap A and B", [], "Exchange the first and the second burst" => Run(|model, _| pair::swap_sides(model)), when when::has_both;
    OtherSide, Pair 1, "Cursor of the other burst", [NONE T], "Focus a pane of the other burst, which sliders and keys then move" => Set(|document| document.focus_other_side()), when |model| when::in_pair(model) && model.results.slots.b.burst.is_some();
    LinkCursors, Pair 1, "Slope and scale together", [NONE K], "Move frame, slope, octave and level of all panes at once, and the kind of picture of both bursts" => Set(|document| document.toggle_link(Link::Cursor)), when |model| when::in_pair(model) || when::many_panes(model), on |model| model.document.panes.all_share(Link::Cursor);
    LinkViews, Pair 1, "Zoom and pan together", [NONE V], "Zoom and pan all panes at once" => Set(|document| document.toggle_link(Link::View)), when |model| when::in_pair(model) || when::many_panes(model), on |model| model.document.panes.all_share(Link::View);
    LinkRanges, Pair 1, "One value range", [], "Show all panes in the same range and colours, so that they can be compared" => Set(|document| document.toggle_link(Link::Display)), when |model| when::in_pair(model) || when::many_panes(model), on |model| model.document.panes.all_share(Link::Display);
    Match, Pair 2, "Match", [NONE H], "Match the features of both bursts with these parameters" => Run(change::match_pair), when when::can_match;
    ResetMatching, Pair 2, "Reset matching parameters", [], "Give every parameter of matching its default" => Set(|document| document.matching = Default::default()), when |model| model.document.matching != MatchParams::default();
    ProbeExpected, Pair 2, "Probe its place in B", [], "Probe B where the geometry puts the feature that is asked about" => Run(change::probe_expected), when |model| when::in_pair(model) && model.expected_place().is_some();
    ToggleInliers, Pair 3, "Inliers", [NONE I], "Show or hide the matches that agree with the geometry of the two views" => Switch(match_look.inliers), when when::in_pair;
    ToggleOutliers, Pair 3, "Outliers", [NONE U], "Show or hide the matches that do not agree with the geometry of the two views" => Switch(match_look.outliers), when when::in_pair;
    ToggleAlone, Pair 3, "Selected match alone", [NONE X], "Draw the selected match with or without the others" => Switch(match_look.alone), when when::in_pair;
    ToggleEpipolar, Pair 3, "Epipolar lines", [NONE E], "Show or hide the lines of the other picture on which the partners must lie" => Switch(match_look.geometry), when when::in_pair;

    DetectAll, Dataset 0, "Detect all", [CTRL D], "Find the features of all bursts that are not done yet, with these parameters" => Change(datasets::ask_and_detect_all), when |model| model.results.datasets.can_detect(model.asked().validate().is_ok());
    CancelDataset, Dataset 0, "Cancel work on the dataset", [], "Stop the work on all bursts; finished bursts and pairs are kept" => Run(|model, _| model.results.datasets.wanted.cancel()), when |model| model.results.datasets.work.is_some();
    PreviousBurst, Dataset 1, "Previous burst", [CTRL ArrowLeft], "Open the burst before this one" => Run(|model, engine| datasets::step_burst(model, -1, engine)), when when::has_dataset;
    NextBurst, Dataset 1, "Next burst", [CTRL ArrowRight], "Open the burst after this one" => Run(|model, engine| datasets::step_burst(model, 1, engine)), when when::has_dataset;
    BurstAsA, Dataset 1, "Use burst as A", [], "Make the open burst the first of a pair" => Run(|model, _| datasets::choose_open_burst(model, Side::A)), when when::is_in_dataset;
    BurstAsB, Dataset 1, "Use burst as B", [], "Make the open burst the second of a pair" => Run(|model, _| datasets::choose_open_burst(model, Side::B)), when when::is_in_dataset;
    MatchPairs, Dataset 2, "Match pairs", [CTRL M], "Match all pairs, or each burst with the next few, as chosen" => Run(datasets::match_pairs), when when::can_match_pairs;
    MatchSelected, Dataset 2, "Match A with B", [], "Match the two bursts chosen as A and B" => Run(datasets::match_selected), when |model| when::has_chosen(model) && when::can_match_pairs(model);
    ShowPair, Dataset 2, "A and B side by side", [CTRL_SHIFT M], "Show the two bursts chosen as A and B, with their matches" => Run(datasets::show_selected_pair), when when::has_chosen;
    ExportDatabase, Dataset 2, "Export COLMAP database…", [], "Write images, features, matches and verified geometries of all bursts as COLMAP's mapper takes them" => Ask(Purpose::ExportDatabase), when when::can_export_database;
    OpenEstimate, Dataset 3, "Open estimated trajectory…", [], "Open a sparse model of COLMAP (any file of it), or a trajectory file" => Ask(Purpose::OpenTrajectory(Which::Estimate));
    OpenSecond, Dataset 3, "Open second estimate…", [], "Open another estimated trajectory, such as that of another method, to compare it with the first and the truth" => Ask(Purpose::OpenTrajectory(Which::Second));
    OpenTruth, Dataset 3, "Open true trajectory…", [], "Open the true camera poses: a trajectory file, or a sparse model such as a gold standard's" => Ask(Purpose::OpenTrajectory(Which::Truth));
    CloseTrajectories, Dataset 3, "Close trajectories", [], "Close the estimated trajectories and the true one" => Run(|model, _| studies::close_trajectories(model)), when |model| !model.results.poses.is_empty();
    CutSequence, Dataset 4, "Cut into bursts…", [], "Cut the open burst into shorter ones, and open them as a dataset" => Change(|model, _| Read::of(model).cut_of_open_burst()), when when::can_be_cut;
    FeatureFolder, Dataset 4, "Choose feature folder…", [], "Keep the dataset's features in another folder, such as one that burstscope colmap wrote" => Ask(Purpose::FeatureFolder), when when::has_dataset;
    UseFolderParams, Dataset 4, "Use the folder's parameters", [], "Use the parameters of the features in the dataset's folder" => Run(datasets::use_folder_params), when |model| model.results.datasets.open.as_ref().is_some_and(|open| open.other_params.is_some());
    CloseDataset, Dataset 5, "Close dataset", [], "Close the dataset; its features stay in their folder" => Change(|model, _| Some(datasets::close_dataset(model))), when when::has_dataset;

    Palette, Help 0, "Command palette…", [CTRL P], "Find an action by typing part of its name";
    Shortcuts, Help 0, "Keyboard shortcuts", [NONE Questionmark], "Show the keys of all actions";
    Lessons, Help 0, "Lessons…", [NONE F1], "Learn how burst features are found, step by step, on live data";
    Hall, Help 0, "Show the lesson to a hall", [NONE F11], "Full screen, large pictures and letters; the page keys and the arrows go from step to step", when |model| model.is_in_lesson(), on |model| model.document.panels.hall;
    ExportSheet, Help 0, "Export lesson sheet…", [], "Write the lesson's tasks, questions and answers as Markdown, to be printed" => Ask(Purpose::Export(ExportKind::Sheet)), when |model| model.is_in_lesson();
    LeaveLesson, Help 0, "Leave the lesson", [], "Close the lesson and go back to what was open before it", when |model| model.is_in_lesson();
    Glossary, Help 0, "Glossary", [SHIFT F1], "Explanations of the terms in this window";
    OpenLessons, Help 0, "Open lessons…", [], "Open a folder of your own lessons (TOML files)" => Ask(Purpose::OpenLessons);
    OpenDepths, Help 1, "Example: many depths", [], "Open a burst of lamps at nine depths, each with a slope of its own" => Open(|| BurstSource::Example(Example::Depths));
    OpenViews, Help 1, "Example: light field", [], "Open 5 × 5 views of lamps at nine depths, each with a disparity of its own" => Open(|| BurstSource::Example(Example::Views));
    OpenCrossing, Help 1, "Example: two ways that cross", [], "Open a burst of lamps that pass to the right and to the left: features at other slopes are ghosts" => Open(|| BurstSource::Example(Example::Crossing));
    OpenStreet, Help 1, "Example: dark street", [], "Open a burst of textured walls that are too dark for one frame" => Open(|| BurstSource::Example(Example::Street));
    OpenStreetLater, Help 1, "Example: dark street, later", [], "Open the same walls a little later, to be matched with the first" => Open(|| BurstSource::Example(Example::StreetLater));
    OpenAliasing, Help 1, "Example: aliasing", [], "Open a burst of garlands with a lamp every 8 px: slopes 8 px/frame apart look alike" => Open(|| BurstSource::Example(Example::Aliasing));
    OpenLowContrast, Help 1, "Example: low contrast", [], "Open a burst of discs of falling contrast: the noise gate rejects the faintest, which noise could have made" => Open(|| BurstSource::Example(Example::LowContrast));
    OpenTripod, Help 1, "Example: still tripod", [], "Open a burst of a camera that does not move: less noise, but no depth" => Open(|| BurstSource::Example(Example::Tripod));
    OpenHotPixels, Help 1, "Example: hot pixels", [], "Open a burst with sixty pixels that are bright without light" => Open(|| BurstSource::Example(Example::HotPixels));
    PaperFigures, Help 2, "Figures of the paper…", [], "Remake every figure and table of the paper into a folder, in the background; finished ones are kept" => Ask(Purpose::PaperFigures), when |model| !model.results.figures.is_pending();
    CancelFigures, Help 2, "Cancel figures of the paper", [], "Stop remaking the figures; finished ones are kept" => Run(|model, _| model.results.figures.cancel()), when |model| model.results.figures.is_pending();
    Cite, Help 3, "How to cite", [], "Copy the program and the method's paper as BibTeX";
    CopyActions, Help 3, "Copy what I did", [], "Copy what you did since the window was opened, as a text for a report; 'burstscope render --play' repeats it";
    About, Help 3, "About Burstscope", [], "Version of this program, and the method's paper";
}

pub const PALETTE_ALSO: KeyboardShortcut = KeyboardShortcut::new(CTRL_SHIFT, Key::P);

/// The entries of the switch in their order, with the workspaces that they open: *Methods* is a layout of *One burst*.
pub fn workspaces() -> impl Iterator<Item = (ActionId, Workspace)> {
    ACTIONS.iter().filter(|row| (row.menu, row.group) == (Menu::View, 0)).map(|row| match row.does {
        Some(Does::Workspace(workspace)) => (row.id, workspace),
        _ => (row.id, Workspace::Inspect),
    })
}

/// # Panics
/// If no row shows such a picture; a test looks at all.
pub fn shown_by(kind: ViewKind) -> ActionId {
    ACTIONS.iter().find(|row| row.id.shown() == Some(kind)).expect("each kind has a row").id
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn labels_and_shortcuts_are_unique() {
        let (mut labels, mut shortcuts) = (HashSet::new(), HashSet::new());
        for action in ACTIONS {
            assert!(labels.insert(action.label), "{} twice", action.label);
            assert!(!action.help.is_empty() && !action.help.ends_with('.'), "{}", action.label);
            // Escape does the first of its actions that is possible: a selection is cleared before work is cancelled.
            if let Some(shortcut) = action.shortcut.filter(|_| action.id != ActionId::Cancel) {
                assert!(shortcuts.insert(format!("{shortcut:?}")), "{} has another's keys", action.label);
            }
            assert_eq!(action.id.action().label, action.label);
        }
        assert!(ViewKind::ALL.into_iter().all(|kind| shown_by(kind).shown() == Some(kind)));
        assert!(!shortcuts.contains(&format!("{PALETTE_ALSO:?}")));
    }

    #[test]
    fn every_menu_has_items_and_its_groups_are_in_order() {
        for menu in Menu::ALL {
            let groups: Vec<u8> = ACTIONS.iter().filter(|a| a.menu == menu).map(|a| a.group).collect();
            assert!(!groups.is_empty() && groups.is_sorted(), "{menu:?}");
        }
    }

    #[test]
    fn what_asks_first_ends_in_an_ellipsis() {
        use ActionId as A;
        use ActionId::{Calibration, FigureOptions, Lessons, OpenGoldA, OpenGoldB, Palette, PaperFigures, Report};
        let others = [Palette, Lessons, OpenGoldA, OpenGoldB, FigureOptions, Calibration, PaperFigures, Report];
        let beginnings = ["Open ", "Save ", "Load ", "Export ", "Choose ", "Cut "];
        for action in ACTIONS {
            let asks = beginnings.iter().any(|beginning| action.label.starts_with(beginning));
            let asks = (asks && action.id != A::OpenDemo) || others.contains(&action.id);
            assert_eq!(action.label.ends_with('…'), asks, "{}", action.label);
        }
    }
}
