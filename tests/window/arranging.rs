//! Tests of panes: each workspace has its own, linked panes follow, and a closed pane's picture disappears from others.

use crate::support::*;
use burstscope::app::pane::{Direction, MAX_PANES, PaneGroup, Panes, Preset};

const A: PaneId = PaneId::of(Side::A);
const B: PaneId = PaneId::of(Side::B);

fn open_beside(panes: &mut Panes) {
    let new = panes.split(panes.focus(), Direction::Right).expect("there is room");
    panes.get_mut(new).expect("there").side = Side::B;
}

#[test]
fn panes_are_numbered_closed_and_limited_and_what_is_shown_of_one_goes_with_it() {
    let mut panes = Panes::default();
    let right = panes.split(A, Direction::Right).expect("there is room");
    assert_eq!((panes.number(right), panes.number(B)), (Some(2), None));
    panes.focus_next(true);
    assert_eq!(panes.focus(), A);
    panes.close(A);
    assert_eq!((panes.shown(), panes.focus()), (vec![right], right));
    assert_eq!(panes.of(Side::A).side, Side::A, "the pane of A is still there for the other workspaces");
    for _ in 0..2 * MAX_PANES {
        panes.split(panes.focus(), Direction::Right);
    }
    assert_eq!(panes.shown().len(), MAX_PANES);
    let mut panes = Panes::default();
    let second = panes.split(A, Direction::Right).expect("there is room");
    let third = panes.split(panes.focus(), Direction::Down).expect("there is room");
    panes.get_mut(third).expect("there").content = Content::Difference(A, second);
    panes.set_focus(A);
    panes.next_over();
    assert_eq!(panes.get(A).and_then(|pane| pane.over), Some(Over::Wipe { other: second, at: 0.5 }));
    panes.next_over();
    panes.flip();
    assert_eq!(panes.get(A).and_then(|pane| pane.over), Some(Over::Flip { other: second, flipped: true }));
    panes.close(second);
    assert_eq!(panes.get(A).and_then(|pane| pane.over), None);
    assert_eq!(panes.get(third).map(|pane| pane.content), Some(Content::Cursor));
}

#[test]
fn linked_cursors_keep_their_distance_and_b_follows_a_also_out_of_sight() {
    let mut panes = Panes::default();
    panes.lay_out(Preset::ThreeSlopes, &DetectorParams::default());
    let slopes = |panes: &Panes| -> Vec<f32> {
        panes.shown().iter().map(|id| panes.get(*id).expect("shown").cursor.slope.u).collect()
    };
    assert_eq!(slopes(&panes), [-1.0, 0.0, 1.0]);
    let focus = panes.focus();
    panes.get_mut(panes.shown()[2]).expect("shown").links.cursor = false;
    let before = panes.get(focus).expect("shown").cursor;
    panes.get_mut(focus).expect("shown").cursor.slope = Slope::new(1.5, 0.0);
    panes.follow_cursor(focus, before);
    assert_eq!(slopes(&panes), [0.5, 1.5, 1.0]);
    let (first, before) = (panes.shown()[0], panes.get(focus).expect("shown").view);
    panes.get_mut(focus).expect("shown").view.zoom = Zoom::PointsPerPixel(3.0);
    panes.follow_view(focus, &before);
    assert_eq!(panes.get(first).expect("shown").view.zoom, Zoom::PointsPerPixel(3.0));
    let mut panes = Panes::default();
    let second = panes.split(A, Direction::Right).expect("there is room");
    let before = panes.of(Side::A).cursor;
    let pane = panes.get_mut(second).expect("there");
    pane.cursor.slope = Slope::new(1.0, 0.0);
    pane.show(ViewKind::Dog);
    panes.follow_cursor(second, before);
    let cursors = Side::BOTH.map(|side| panes.of(side).cursor);
    assert_eq!(cursors.map(|cursor| cursor.slope.u), [1.0, 1.0]);
    assert_eq!(cursors.map(|cursor| cursor.kind), [ViewKind::Stack, ViewKind::Dog], "panes of one burst may differ");
    panes.of_mut(Side::B).links.cursor = false;
    let before = panes.of(Side::A).cursor;
    panes.of_mut(Side::A).cursor.level = 2;
    panes.follow_cursor(A, before);
    assert_eq!(panes.of(Side::B).cursor.level, 0);
}

#[test]
fn panes_that_are_always_there_stay_on_their_bursts_and_a_closed_burst_takes_its_own_with_it() {
    let mut panes = Panes::default();
    let right = panes.split(A, Direction::Right).expect("there is room");
    panes.next_over();
    assert_eq!(panes.get(right).and_then(|pane| pane.over).map(Over::other), Some(A));
    panes.show_side(A, Side::B);
    assert_eq!(panes.of(Side::A).side, Side::A);
    let first = panes.shown()[0];
    assert!(first != A && panes.get(first).is_some_and(|pane| pane.side == Side::B));
    assert_eq!(panes.get(right).and_then(|pane| pane.over).map(Over::other), Some(first));
    panes.show_side(right, Side::B);
    assert_eq!(panes.shown(), [first, right]);
    let mut panes = Panes::default();
    open_beside(&mut panes);
    panes.close_side(Side::B);
    assert_eq!((panes.shown(), panes.focus()), (vec![A], A));
    open_beside(&mut panes);
    panes.close(A);
    panes.close_side(Side::B);
    assert_eq!((panes.shown(), panes.focus()), (vec![A], A));
}

#[test]
fn each_workspace_has_its_own_panes_and_what_is_in_two_is_the_same() {
    let mut panes = Panes::default();
    let right = panes.split(A, Direction::Right).expect("there is room");
    panes.turn_to(Workspace::Pair);
    assert_eq!((panes.shown(), panes.focus()), (vec![A, B], A));
    let below = panes.split(A, Direction::Down).expect("there is room");
    panes.close(A);
    assert_eq!(panes.shown(), [below, B]);
    panes.turn_to(Workspace::Inspect);
    assert_eq!(panes.shown(), [A, right]);
    assert!(panes.get(below).is_some(), "the other workspace has it");
    // Closing a burst removes its panes from all workspaces.
    panes.close_side(Side::B);
    assert_eq!((panes.shown_in(PaneGroup::Pair), panes.get(below).is_none()), (vec![A, B], true));
}
