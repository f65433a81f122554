//! Changes that the user asks for, as values that can be written and read. Panels and panes push them while they are
//! drawn; they are applied after the drawing, by one function (`apply::apply`).

use crate::app::document::{
    BurstPair, CompareLook, Compared, Destination, Document, FigureChoice, FilmChoice, Filter, Lab, Look, MatchColumn,
    MatchLook, Measure, MethodId, Order, PairChoice, PairColumn, PairTab, Panels, Playing, RangeClass, Reference,
    SavedMatch, SavedSelection, SetUpState, Side, Sides, Visibility,
};
use crate::app::pane::{Arrangement, Content, Link, Over, PaneId, PaneLinks, Preset};
use crate::app::session::Session;
use crate::app::view::{ColourBy, View};
use crate::app::{actions::registry::ActionId, document::panes::Change};
use crate::burst::OpenOptions;
use crate::dataset::DatasetSource;
use crate::detector::{ParamChange, Quantity, SearchParams, Slope, Test};
use crate::evaluate::poses::{PoseStudy, Projection};
use crate::inspect::{pair::Lost, place::ProbeSubject};
use crate::matching::MatchParams;
use crate::plane::display::Display;
use crate::requests::{
    BurstSource, FigureRequest, FolderRequest, ProbeQuestion, ShapeRequest, ViewKind, Which, make_absolute,
};
use crate::teach::BottomTab;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Declares [`Action`], with what each changes of the document in the same place: a field that it sets and that nothing
/// else follows from, whose comparison is made from the same line, or `changes`, which take an expression. What needs
/// results, the engine or the shell is one of the `others`, which `apply` and the window carry out.
macro_rules! actions {
    (
        fields { $($(#[$doc:meta])* $set:ident($(#[$written:meta])* $value:ty) => $($field:ident).+;)* }
        large { $($(#[$about:meta])* $replace:ident($large:ty) => $($place:ident).+;)* }
        changes {
            $($(#[$what:meta])* $change:ident($($(#[$how:meta])* $part:ty),*)
                => |$document:ident $(, $given:ident)*| $does:expr;)*
        }
        others { $($others:tt)* }
    ) => {
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Action {
            $($(#[$doc])* $set($(#[$written])* $value),)*
            $($(#[$about])* $replace(Box<$large>),)*
            $($(#[$what])* $change($($(#[$how])* $part),*),)*
            $($others)*
        }

        impl Action {
            pub fn change(self, of: &mut Document) {
                match self {
                    $(Self::$set(value) => of.$($field).+ = value,)*
                    $(Self::$replace(value) => of.$($place).+ = *value,)*
                    $(Self::$change($($given),*) => {
                        let $document = of;
                        $does;
                    })*
                    _ => {}
                }
            }

            pub fn sets_field(&self) -> bool {
                matches!(self, $(Self::$set(_))|* $(| Self::$replace(_))*)
            }

            pub fn changes_nothing(&self, document: &Document) -> bool {
                match self {
                    $(Self::$set(value) => document.$($field).+ == *value,)*
                    $(Self::$replace(value) => document.$($place).+ == **value,)*
                    _ => false,
                }
            }
        }
    };
}

actions! {
fields {
    SetMeasure(Measure) => measure;
    SetPanels(Panels) => panels;
    SetFigure(FigureChoice) => figure;
    SetFilm(FilmChoice) => film;
    SetSetUp(SetUpState) => set_up;
    Select(#[serde(with = "or_none")] Option<usize>) => selected;
    SetFilter(Filter) => filter;
    SetOrder(Order<Quantity>) => order;
    SelectCandidate(#[serde(with = "or_none")] Option<usize>) => selected_candidate;
    /// Scale σ near which candidates come first, input pixels.
    ProbeNear(#[serde(with = "or_none")] Option<f32>) => probe.near_sigma;
    OpenProbe(bool) => probe.is_open;
    SetPlay(Playing) => play;
    SetMatchLook(MatchLook) => match_look;
    SetMatchOrder(Order<MatchColumn>) => match_order;
    SetMethods(CompareLook) => methods;
    SetPairChoice(PairChoice) => pairs;
    SetProjection(Projection) => trajectories.projection;
    MoveCameras(View) => trajectories.view;
    Orbit([f32; 2]) => trajectories.orbit;
}
large {
    /// All parameters, as a file has them.
    SetSearch(SearchParams) => params;
    SetMatching(MatchParams) => matching;
    SetLab(Lab) => lab;
}
changes {
    Focus(PaneId) => |document, id| document.panes.set_focus(id);
    Rearrange(Arrangement) => |document, arrangement| document.panes.rearrange(arrangement);
    GoTo(Side, Destination) => |document, side, destination| document.go_to(side, &destination);
    SetFrame(PaneId, usize) => |document, id, frame| document.paused().show_frame(id, frame);
    SetSlope(PaneId, Slope) => |document, id, slope| document.paused().show_slope(id, slope);
    SetScale(PaneId, i32, i32) => |document, id, octave, level| document.paused().show_scale(id, octave, level);
    /// The next frame, slope, or octave and level, while these are played.
    PlayFrame(PaneId, usize) => |document, id, frame| document.show_frame(id, frame);
    PlaySlope(PaneId, Slope) => |document, id, slope| document.show_slope(id, slope);
    PlayScale(PaneId, i32, i32) => |document, id, octave, level| document.show_scale(id, octave, level);
    Show(PaneId, ViewKind) => |document, id, kind| document.lead(id, |pane| pane.show(kind));
    SetContent(PaneId, Content) => |document, id, content| document.lead(id, |pane| match content {
        Content::Slice(axis) => pane.show_slice(axis),
        content => pane.content = content,
    });
    SetOver(PaneId, #[serde(with = "or_none")] Option<Over>) => |document, id, over|
        document.lead(id, |pane| pane.over = over);
    SetLink(PaneId, Link, bool) => |document, id, link, on| document.set_link(id, link, on);
    SetMethod(PaneId, MethodId) => |document, id, method| document.lead(id, |pane| pane.method = Some(method));
    SetSide(PaneId, Side) => |document, id, side| document.panes.show_side(id, side);

    /// Of the pane in focus, or of all that share its display.
    SetDisplay(RangeClass, Display) => |document, class, display|
        *document.focused_ranges_mut().display_mut(class) = display;
    /// All but its value ranges.
    SetLook(Look) => |document, look| document.set_look(look);
    NamePlace(usize, String) => |document, index, name| if let Some(place) = document.places.get_mut(index) {
        place.name = name;
    };
    ForgetPlace(usize) => |document, index| if index < document.places.len() {
        document.places.remove(index);
    };
    OpenTab(BottomTab) => |document, tab| (document.bottom_tab, document.panels.bottom) = (tab, Visibility::Open);

    Change(Vec<ParamChange>) => |document, changes| document.change(&changes);
    ReadDepths(bool) => |document, reads| document.read_depths(reads);
    ShowTest(#[serde(with = "or_none")] Option<Test>) => |document, test|
        (document.shown_test, document.selected_candidate) = (test, None);

    ShowKind(Side, Compared, bool) => |document, side, kind, shown|
        show(&mut document.comparisons[side].hidden, kind, shown);
    SetPairLinks(PaneLinks) => |document, links| for link in [Link::View, Link::Cursor, Link::Display] {
        document.link_pair(link, links.has(link));
    };
    SelectMatch(#[serde(with = "or_none")] Option<usize>) => |document, index|
        (document.selected_match, document.asked_about) = (index, None);
    ShowLost(Lost, bool) => |document, lost, shown| {
        show(&mut document.hidden_losses, lost, shown);
        document.pair_tab = PairTab::Unmatched;
    };

    /// A burst of the open dataset, by its place, as A or B of a pair.
    ChooseBurst(Side, usize) => |document, side, place|
        document.dataset.iter_mut().for_each(|set| set.choose(side, place));
    SelectPair(BurstPair) => |document, pair| document.dataset.iter_mut().for_each(|set| set.select(pair));
    SelectCamera(#[serde(with = "or_none")] Option<usize>) => |document, camera|
        (document.trajectories.selected, document.trajectories.point) = (camera, None);
    SelectPoint(usize) => |document, point|
        (document.trajectories.selected, document.trajectories.point) = (None, Some(point));
    /// With other points the section shown is another one.
    ShowPoints(bool) => |document, points|
        (document.trajectories.points, document.trajectories.view) = (points, View::fit());
}
others {
    /// A row of the action table: what menus, keys and buttons do.
    Do(ActionId),
    Open(Side, BurstSource),
    /// The whole session: doing this again needs no file.
    Restore(Box<Session>),
    OpenDataset(DatasetSource),
    UseFeatureFolder(PathBuf),
    OpenGold(Side, BurstSource),
    OpenFeatures(Side, PathBuf),
    OpenTrajectory(Which, PathBuf),
    CloseTrajectory(Which),
    OpenBurstAt(usize),
    /// The open burst as a dataset of bursts of this many frames.
    CutOpenBurst(usize),
    Calibrate(OpenOptions),
    /// Uses what was set for the burst before, or drops it for good.
    TakeLeftBehind(bool),
    /// Also where features of other parameters are replaced.
    DetectAllAnyway,

    ChangePanes(Change),
    MoveView {
        pane: PaneId,
        before: View,
        after: View,
    },
    ColourBy(ColourBy),
    ToggleTab(BottomTab),

    /// The first `n` frames, added up along the slope; of one its frame.
    UseFrames(usize),
    ApplyChanges(Side, Vec<ParamChange>),
    ApplySetUp,
    ExamineSlopes,
    SearchDecoys,

    Probe(Side, ProbeQuestion),
    ProbeFeature(Side, usize),
    ProbeSubject(ProbeSubject),
    StopFollowing,

    CompareWith(Side, #[serde(with = "or_none")] Option<Reference>),
    SelectRow(Side, #[serde(with = "or_none")] Option<usize>),

    SetPairTab(PairTab),
    /// Why a feature of A has no match.
    AskFeature(#[serde(with = "or_none")] Option<usize>),

    ShowKept(usize, bool),
    NameKept(usize, String),
    ForgetKept(usize),

    SortPairs(PairColumn),
    SetPoseStudy(PoseStudy),
    OpenCamera(String),
    /// The burst of a camera, with the feature of an index.
    OpenFeature(String, usize),

    Note(String),
    DismissMessage(u64),
    #[serde(skip)]
    Point(Pointed),
    #[serde(skip)]
    Stage(Staged),
}
}

/// Hides or shows one of the kinds of which `hidden` are not drawn.
fn show<T: PartialEq>(hidden: &mut Vec<T>, kind: T, shown: bool) {
    hidden.retain(|other| *other != kind);
    hidden.extend((!shown).then_some(kind));
}

/// Thing under the pointer, or as last drawn: of no lasting effect.
#[derive(Debug, Clone, PartialEq)]
pub enum Pointed {
    Feature(Option<usize>),
    Candidate(Option<usize>),
    Row(Side, Option<usize>),
    Match(Option<usize>),
    Camera(Option<usize>),
    /// Its burst, and pixels at mid-burst.
    Place(Option<(Side, [f32; 2])>),
    /// Features at the probed place that are drawn as dots.
    Dots(Vec<usize>),
    /// Numbers of match lines that are drawn, and of those that could be.
    Lines(usize, usize),
    /// The figure that its form would write; `None` without a form.
    Figure(Option<Box<FigureRequest>>),
    /// Burst and motion of the place in the loupe; `None` without a loupe.
    Loupe(Option<(Side, Slope)>),
    /// The shape that is typed for a file without header.
    Shape(Option<ShapeRequest>),
    Folder(Option<FolderRequest>),
}

macro_rules! become_actions {
    ($($of:ty => $action:ident),+) => {
        $(impl From<$of> for Action {
            fn from(value: $of) -> Self {
                Self::$action(value)
            }
        })+
    };
}
become_actions!(ActionId => Do, Pointed => Point, Staged => Stage);

/// An absent value is written as the word `none`: a list of TOML has no other word for it.
mod or_none {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Absent {
        None,
    }

    #[derive(Deserialize)]
    #[serde(untagged, expecting = "give a value of this action's kind, or \"none\"")]
    enum Written<T> {
        Absent(Absent),
        There(T),
    }

    pub fn serialize<T: Serialize, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        match value {
            Some(value) => value.serialize(serializer),
            None => serializer.serialize_str("none"),
        }
    }

    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(from: D) -> Result<Option<T>, D::Error> {
        Ok(match Written::deserialize(from)? {
            Written::Absent(Absent::None) => None,
            Written::There(value) => Some(value),
        })
    }
}

/// Actions of a pass, in the order in which they were asked for.
#[derive(Debug, Default)]
pub struct Queue(pub Vec<Action>);

impl Queue {
    pub fn push(&mut self, action: impl Into<Action>) {
        self.0.push(action.into());
    }

    pub fn push_if(&mut self, is_asked_for: bool, action: impl Into<Action>) {
        self.0.extend(is_asked_for.then(|| action.into()));
    }

    /// Pushes an action that sets a field of the document, unless the field has that value.
    pub fn edit(&mut self, document: &Document, action: Action) {
        if !action.changes_nothing(document) {
            self.0.push(action);
        }
    }

    /// Pushes the action that sets a value, if `after` is another one.
    pub fn set<T: PartialEq>(&mut self, before: &T, after: T, action: impl FnOnce(T) -> Action) {
        if *before != after {
            self.0.push(action(after));
        }
    }

    pub fn point(&mut self, before: &Option<usize>, after: Option<usize>, to: impl FnOnce(Option<usize>) -> Pointed) {
        self.set(before, after, |after| Action::Point(to(after)));
    }

    pub fn replace(&mut self, action: impl Into<Action>) {
        self.0 = vec![action.into()];
    }

    pub fn asked(&self) -> impl Iterator<Item = ActionId> {
        self.0.iter().filter_map(|action| if let Action::Do(id) = action { Some(*id) } else { None })
    }
}

impl Action {
    #[must_use]
    pub fn with_absolute_paths(mut self) -> Self {
        match &mut self {
            Self::Open(_, source) | Self::OpenGold(_, source) => *source = source.absolute(),
            Self::OpenDataset(DatasetSource { paths, .. }) => paths.iter_mut().for_each(make_absolute),
            Self::UseFeatureFolder(path) | Self::OpenFeatures(_, path) | Self::OpenTrajectory(_, path) => {
                make_absolute(path);
            }
            Self::Calibrate(options) => options.paths_mut().for_each(make_absolute),
            _ => {}
        }
        self
    }
}

/// Changes that a session or a lesson asks for, of values that are not written.
#[derive(Debug, Clone, PartialEq)]
pub enum Staged {
    /// Puts the project aside, and shows an empty one.
    BeginLesson,
    /// Shows the project that was put aside; a burst that is being opened is opened in it, if it `keeps_opening`.
    EndLesson { keeps_opening: bool },
    /// Opens the second burst of a session, with the options of the document.
    Reopen(Side, BurstSource),
    /// Opens the bursts of a lesson's step unless they are open, and the cameras that it speaks of.
    Open { bursts: Sides<Option<BurstSource>>, cameras: bool },
    /// Shows the document of a lesson's step as if nothing had been done before.
    Begin {
        document: Box<Document>,
        layout: Option<Preset>,
        /// Place in A that is probed, pixels at mid-burst.
        probe: Option<[f32; 2]>,
    },
    /// Selects the first of the listed features or matches.
    SelectFirst,
    /// Shows a document of the bursts that are open.
    Show(Box<Document>, Reselect),
    /// Opens the dataset and the trajectories that the document names.
    ReadNamed,
    /// Probes a place as soon as this burst is open.
    ProbeWhenOpen(BurstSource, [f32; 2]),
}

/// Feature or match that is selected as soon as it is found again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reselect {
    Feature(Option<SavedSelection>),
    Match(Option<SavedMatch>),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::document::{DatasetChoice, Journal};

    #[test]
    fn what_was_done_and_what_is_set_name_files_from_any_folder() {
        let file = || PathBuf::from("here");
        let source = || BurstSource::Paths(vec![file()]);
        let actions = [
            Action::Open(Side::A, source()),
            Action::OpenGold(Side::B, BurstSource::DarkCopy { of: Box::new(source()), noise: Default::default() }),
            Action::OpenDataset(DatasetSource::of_bursts(vec![file()])),
            Action::UseFeatureFolder(file()),
            Action::OpenFeatures(Side::A, file()),
            Action::OpenTrajectory(Which::Truth, file()),
            Action::Calibrate(OpenOptions { bias: Some(file()), flat: Some(file()), ..OpenOptions::default() }),
        ];
        let here = std::path::absolute("here").expect("a folder").display().to_string();
        for action in actions {
            let mut journal = Journal::default();
            journal.take(&action, false);
            assert!(journal.to_toml().contains(&here), "{action:?}");
        }
        let mut document = Document { gold: Default::default(), ..Document::of_new_window() };
        document.gold.b = Some(source());
        (document.comparisons.a.file, document.trajectories.truth) = (Some(file()), Some(file()));
        let dataset = DatasetSource::of_bursts(vec![file()]);
        document.dataset = Some(DatasetChoice { source: dataset, folder: Some(file()), pair: Default::default() });
        let text = toml::to_string(&document.with_absolute_paths()).expect("plain values");
        assert_eq!(text.matches(&here).count(), 5, "{text}");
    }
}
