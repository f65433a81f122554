//! Laws of actions: any list of them leaves a valid document, which is the same after it was written and read, and
//! undo and redo return to what was.

use crate::app::actions::registry::{ACTIONS, ActionId, Menu};
use crate::app::apply::bench::{Bench, open};
use crate::app::apply::{apply, methods, opening, pair, params, staged};
use crate::app::document::{Action, Destination, Document, Journal, Pointed, Side};
use crate::app::pane::{Direction, Link, PaneId, Preset};
use crate::app::results::Read;
use crate::app::view::{View, Zoom};
use crate::app::{document::journal::read_steps, document::panes::Change};
use crate::detector::params::doc;
use crate::detector::{DetectorParams, ParamChange, SearchParams, Slope, SlopeAxis, SlopeGrid, Slopes};
use crate::matching::MatchParams;
use crate::requests::ViewKind;
use proptest::prelude::*;

fn bench() -> Bench {
    let mut bench = Bench::new();
    opening::take_burst(&mut bench.model, open((64, 48), 5));
    pair::take_second_burst(&mut bench.model, open((48, 64), 3));
    bench
}

fn pass(bench: &mut Bench, action: Action) {
    let _ = apply(action, &mut bench.model, &bench.engine);
    methods::refresh_workspace(&mut bench.model);
    params::check_params(&mut bench.model);
    bench.model.shell.history.close_step(&bench.model.document, false);
}

fn search(params: DetectorParams) -> Action {
    Action::SetSearch(Box::new(params.into()))
}

fn of_settings() -> impl Strategy<Value = Action> {
    let pane = (0..2u32).prop_map(PaneId);
    let slope = (-9.0f32..9.0, -9.0f32..9.0).prop_map(|(u, v)| Slope::new(u, v));
    prop_oneof![
        (1.0f32..30.0).prop_map(|edge_threshold| search(DetectorParams { edge_threshold, ..Default::default() })),
        (-20.0f32..20.0, 0..doc::ALL.len()).prop_map(|(x, k)| Action::Change(vec![ParamChange::new(doc::ALL[k], x)])),
        (1.0f32..6.0, 2..9usize).prop_map(|(end, count)| {
            search(DetectorParams { slopes: SlopeGrid::line(-end..=end, count), ..Default::default() })
        }),
        (0.5f32..0.95).prop_map(|ratio| Action::SetMatching(Box::new(MatchParams { ratio, ..Default::default() }))),
        (pane, slope).prop_map(|(pane, slope)| Action::SetSlope(pane, slope)),
        Just(ActionId::ResetParams.into()),
        Just(ActionId::Preset2d.into()),
        Just(ActionId::SlopeUMore.into()),
    ]
}

/// Actions of all kinds; many of them on panes, and some on panes that are not there.
fn any_action() -> impl Strategy<Value = Action> {
    let pane = || (0..6u32).prop_map(PaneId);
    let directions = prop::sample::select(vec![Direction::Right, Direction::Down]);
    let ids: Vec<ActionId> = ACTIONS.iter().map(|row| row.id).filter(|id| !opens(*id)).collect();
    prop_oneof![
        of_settings(),
        prop::sample::select(ids).prop_map(Action::Do),
        pane().prop_map(Action::Focus),
        (pane(), directions).prop_map(|(pane, to)| Action::ChangePanes(Change::Split(pane, to))),
        pane().prop_map(|pane| Action::ChangePanes(Change::Close(pane))),
        (pane(), prop::sample::select(Preset::ALL.map(|(preset, ..)| preset).to_vec()))
            .prop_map(|(pane, preset)| Action::ChangePanes(Change::LayOut(pane, preset))),
        (pane(), prop::sample::select(ViewKind::ALL.to_vec())).prop_map(|(pane, kind)| Action::Show(pane, kind)),
        (pane(), 0..9usize).prop_map(|(pane, frame)| Action::SetFrame(pane, frame)),
        (pane(), -3..9i32, -3..9i32).prop_map(|(pane, octave, level)| Action::SetScale(pane, octave, level)),
        (pane(), prop::sample::select(Link::ALL.to_vec()), any::<bool>())
            .prop_map(|(pane, link, on)| Action::SetLink(pane, link, on)),
        (pane(), prop::sample::select(Side::BOTH.to_vec())).prop_map(|(pane, side)| Action::SetSide(pane, side)),
        (pane(), 0.1f32..50.0, -99.0f32..99.0).prop_map(|(pane, zoom, u)| {
            let after = View::new(Zoom::PointsPerPixel(zoom), [u, -u]);
            Action::MoveView { pane, before: View::fit(), after }
        }),
        (0..9usize, -9.0f32..9.0).prop_map(|(frame, u)| {
            let to = Destination { frame: Some(frame), slope: Some(Slope::new(u, 0.0)), ..Default::default() };
            Action::GoTo(Side::B, to)
        }),
        prop::option::of(0..9usize).prop_map(Action::Select),
        prop::option::of(0..9usize).prop_map(Action::AskFeature),
        (0..9usize).prop_map(Action::ForgetKept),
        (0..9usize).prop_map(Action::UseFrames),
        (0..3usize).prop_map(|place| Action::NamePlace(place, "a \"mast\"".to_owned())),
        (0..3usize).prop_map(Action::ForgetPlace),
    ]
}

/// Whether the action opens something, or asks the engine for work.
fn opens(id: ActionId) -> bool {
    let action = id.action();
    action.label.ends_with('…') || matches!(action.menu, Menu::File | Menu::Help | Menu::Dataset)
}

fn assert_valid(model: Read<'_>) {
    let Document { panes, .. } = &model.document;
    let shown = panes.shown();
    assert!(!shown.is_empty() && shown.contains(&panes.focus()), "{:?} of {shown:?}", panes.focus());
    let followers = panes.followers();
    for (id, pane) in panes.iter() {
        let slot = &model.results.slots[pane.side];
        if let Some(burst) = slot.burst.as_ref().filter(|_| !followers.contains(&id)) {
            let mut within = pane.cursor_within(burst, &slot.usable_params);
            if !model.knows_slopes(pane.side) {
                within.slope = pane.cursor.slope;
            }
            assert_eq!(pane.cursor, within, "the cursor of pane {id:?}");
        }
        assert!(pane.others().iter().all(|other| panes.get(*other).is_some()), "{pane:?} shows a pane that is closed");
    }
    assert!(model.document.matching.ratio > 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn any_list_of_actions_leaves_a_valid_document(actions in prop::collection::vec(any_action(), 1..1000)) {
        let mut bench = bench();
        for action in actions {
            pass(&mut bench, action);
            assert_valid(bench.read());
        }
        // What is still asked for ends, and is not asked for again; studies take long.
        for id in [ActionId::CancelStudy, ActionId::Cancel, ActionId::AutoDetect] {
            if id != ActionId::AutoDetect || bench.model.document.auto_detect {
                pass(&mut bench, id.into());
            }
        }
        bench.settle();
        assert_valid(bench.read());
        let text = toml::to_string(&bench.model.document).expect("plain values");
        let read: Document = toml::from_str(&text).expect("it was written so");
        prop_assert_eq!(&read, &bench.model.document, "{}", text);
    }

    #[test]
    fn actions_are_written_and_read(actions in prop::collection::vec(any_action(), 1..40)) {
        let mut journal = Journal::default();
        for action in &actions {
            journal.take(action, false);
            journal.close(false);
        }
        let read = read_steps(&journal.to_toml()).expect("it was written so");
        // Of dialogs, copies and moves to where a view is nothing is taken down.
        let there: Vec<&Action> = actions.iter().filter(|action| read.iter().flatten().any(|r| r == *action)).collect();
        prop_assert_eq!(read.iter().flatten().collect::<Vec<_>>(), there);
    }

    #[test]
    fn undo_and_redo_return_to_what_was(actions in prop::collection::vec(of_settings(), 1..160)) {
        let mut bench = bench();
        let before = bench.model.document.clone();
        for action in actions {
            pass(&mut bench, action);
        }
        let after = bench.model.document.clone();
        while bench.model.shell.history.can_undo() {
            pass(&mut bench, ActionId::Undo.into());
        }
        let undone = &bench.model.document;
        prop_assert_eq!(&undone.params, &before.params);
        prop_assert_eq!(&undone.matching, &MatchParams::default());
        let slopes = |document: &Document| -> Vec<_> { document.panes.iter().map(|(_, p)| p.cursor.slope).collect() };
        prop_assert_eq!(slopes(undone), slopes(&before));
        while bench.model.shell.history.can_redo() {
            pass(&mut bench, ActionId::Redo.into());
        }
        prop_assert_eq!(&bench.model.document, &after);
    }
}

/// Two panels that are drawn in one pass know nothing of one another.
#[test]
fn two_changes_in_one_pass_are_both_made() {
    let mut bench = bench();
    let before = bench.model.document.params.clone();
    let with = |parameter, value: &str| {
        let after = before.clone().with_texts([(parameter, value)]).expect("valid");
        bench.model.document.action_to(after).expect("another")
    };
    for action in [with(doc::LEVELS, "4"), with(doc::EDGE_THRESHOLD, "13.5"), with(doc::SLOPES_V, "-1:1:3")] {
        pass(&mut bench, action);
    }
    let params = bench.model.document.params.clone();
    let was = before.slopes.given().expect("a line");
    let grid = SlopeGrid { v: SlopeAxis::new(-1.0..=1.0, 3), ..was };
    assert_eq!((params.levels, params.edge_threshold, params.slopes), (4, 13.5, grid.into()));
    // To slopes that are found, and back to the ranges, which stay as they are.
    for slopes in [Slopes::Auto { direction_deg: Some(30.0) }, grid.into()] {
        let after = SearchParams { slopes, ..params.clone() };
        let action = bench.model.document.action_to(after.clone()).expect("another");
        pass(&mut bench, action);
        assert_eq!(bench.model.document.params, after);
        assert!(bench.model.document.action_to(after).is_none());
    }
}

#[test]
fn what_is_pointed_at_is_no_step_and_leaves_the_document_as_it_is() {
    let Bench { mut model, engine } = Bench::new();
    let before = model.document.clone();
    for pointed in [Pointed::Feature(Some(3)), Pointed::Row(Side::B, Some(1)), Pointed::Place(None)] {
        apply(Action::Point(pointed), &mut model, &engine);
    }
    model.shell.history.close_step(&model.document, false);
    assert!(model.document == before && !model.shell.history.can_undo());
    assert_eq!((model.results.hovered, model.results.slots.b.comparison.hovered), (Some(3), Some(1)));
}

#[test]
fn a_plane_keeps_the_slopes_that_were_found_and_one_step_back_returns_to_them() {
    let Bench { mut model, engine } = Bench::new();
    model.document.params.slopes = Slopes::AUTO;
    model.results.slots.a.usable_params.slopes = SlopeGrid::line(-6.0..=-3.0, 4);
    let asked = model.document.params.clone();
    assert!(apply(ActionId::Preset2d.into(), &mut model, &engine).is_empty());
    model.shell.history.close_step(&model.document, false);
    assert_eq!(model.document.params.slopes, SlopeGrid::plane(-6.0..=-3.0, 4, -2.0..=2.0, 5).into());
    staged::take_step(&mut model, true, &engine);
    assert!(model.document.params == asked && !model.shell.history.can_undo());
    staged::take_step(&mut model, false, &engine);
    assert!(model.document.params.slopes.given().is_some_and(|grid| grid.is_plane()));
}
