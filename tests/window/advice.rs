//! Law of every *Apply* of the slopes: it changes the parameters and says so, the advice is computed again by what it
//! found, advice never leads back to where it came from, and steps back lead to what was set before.

use crate::support::*;

/// Steps after which advice must have come to an end: range, step and cost can each need one, and the range two.
const LONGEST: usize = 4;

fn searched(window: &Window) -> SearchParams {
    window.document().params.clone()
}

/// Applies advice on slopes until none is left; what was set at each step, the first as it was begun.
fn apply_all(window: &mut Window, what: &str) -> Vec<SearchParams> {
    let mut set = vec![searched(window)];
    while window.shows("Apply slopes") {
        let sentence = window.read().slope_judgement().expect("shown").sentence.clone();
        window.click("Apply slopes").settle();
        let now = searched(window);
        let messages = window.errors();
        assert!(messages.is_empty(), "{what}: {sentence}: {messages:?}");
        assert!(!set.contains(&now), "{what}: {sentence}: leads back to {:?}", now.slopes);
        assert!(window.read().features_are_current(burstscope::app::document::side::Side::A), "{what}");
        set.push(now);
        assert!(set.len() <= LONGEST + 1, "{what}: no end of advice: {:?}", window.read().slope_judgement());
    }
    set
}

fn check(source: BurstSource, grids: &[SlopeGrid]) -> usize {
    let mut applied = 0;
    let mut start = Start { size: [1280.0, 800.0], ..Start::automatic() };
    start.startup.source = Some(source.clone());
    start.startup.params.slopes = Slopes::from(grids[0]);
    let mut window = start.open();
    for grid in grids {
        window.change(|document| document.params.slopes = (*grid).into()).settle();
        let what = format!("{source:?} at {grid:?}");
        let set = apply_all(&mut window, &what);
        applied += set.len() - 1;
        for before in set.iter().rev().skip(1) {
            window.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
            window.settle();
            assert_eq!(&searched(&window), before, "{what}: a step back");
        }
    }
    applied
}

fn unsuitable() -> [SlopeGrid; 5] {
    [
        SlopeGrid::line(-0.4..=0.4, 3),
        SlopeGrid::line(-9.0..=9.0, 7),
        SlopeGrid::line(3.0..=8.0, 11),
        SlopeGrid::line(-6.0..=6.0, 61),
        SlopeGrid::single(Slope::new(0.0, 2.0)),
    ]
}

#[test]
fn advice_on_the_slopes_of_the_demo_and_of_examples_comes_to_an_end_and_is_taken_back() {
    let applied = check(BurstSource::Demo, &unsuitable());
    assert!(applied >= 4, "{applied} of 5 unsuitable grids");
    let applied: usize = [Example::Street, Example::Depths, Example::Tripod, Example::Crossing]
        .map(|example| check(BurstSource::Example(example), &unsuitable()))
        .iter()
        .sum();
    assert!(applied >= 8, "{applied} of 20 unsuitable grids");
}
