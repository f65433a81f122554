//! Comparisons with a reference: which one is on show, what is pinned, and the answers.

use crate::app::document::{Compared, FeaturesShown, PairTab, Reference, Side};
use crate::app::results::{ComparisonResults, Model, Read};
use crate::engine::Ended;
use crate::requests::ComparisonRequest;

pub(super) fn compare_with(model: &mut Model, side: Side, with: Option<Reference>) {
    let (set, results) = (&mut model.document.comparisons[side], &mut model.results.slots[side].comparison);
    if set.with != with {
        // Unchanged features are hidden, so that the changes stand out.
        let hidden = if with == Some(Reference::Pinned) { vec![Compared::Same] } else { Vec::new() };
        (set.with, set.selected, set.hidden) = (with, None, hidden);
        (results.shown, results.hovered) = (None, None);
        results.wanted.forget();
        // What is compared is of all slopes, until one is asked for.
        let overlay = &mut model.document.look.overlay;
        if *overlay != FeaturesShown::None {
            *overlay = if with.is_some() { FeaturesShown::All } else { FeaturesShown::ThisSlope };
        }
    }
}

pub fn pin_result(model: &mut Model, side: Side) {
    let slot = &mut model.results.slots[side];
    if let Some(found) = &slot.found {
        slot.comparison.pinned = Some((found.asked.clone(), found.detection.clone()));
        model.document.comparisons[side].pinned = Some(found.asked.clone());
        // The comparison with an earlier pin is dropped.
        compare_with(model, side, None);
        show_comparison(model, side, Some(Reference::Pinned));
    }
}

pub fn lay_over(model: &mut Model, side: Side, path: std::path::PathBuf) {
    if model.results.slots[side].burst.is_some() {
        model.results.slots[side].comparison.file = None;
        model.document.comparisons[side].file = Some(path);
        compare_with(model, side, None);
        show_comparison(model, side, Some(Reference::File));
    }
}

pub fn forget_reference(model: &mut Model, side: Side, with: Reference) {
    let set = &mut model.document.comparisons[side];
    match with {
        Reference::Pinned => set.pinned = None,
        Reference::File => set.file = None,
        Reference::Truth => {}
    }
    if set.with == Some(with) {
        compare_with(model, side, None);
    }
}

pub fn select_row(model: &mut Model, side: Side, row: Option<usize>) {
    model.document.comparisons[side].selected = row;
    if side == Side::A {
        let shown = &model.results.slots.a.comparison.shown;
        model.document.selected = row.and_then(|row| shown.as_ref()?.rows.get(row)?.feature);
    }
}

pub(super) fn take_comparison(model: &mut Model, side: Side, ended: Ended<ComparisonRequest>) {
    let is_wanted = Read::of(model).wanted_comparison(side).is_some_and(|wanted| wanted == ended.request);
    if let Some(compared) = ended.result.ok().filter(|_| is_wanted) {
        model.results.slots[side].comparison.take(compared, &mut model.document.comparisons[side]);
    }
}

pub(super) fn check_references(model: &mut Model) {
    for side in Side::BOTH {
        let slot = &mut model.results.slots[side];
        let (open, comparison) = (slot.burst.as_ref(), &mut slot.comparison);
        if comparison.truth.map(|(burst, _)| burst) != open.map(|open| open.id) {
            comparison.truth = open.map(|open| (open.id, open.has_truth()));
        }
        if model.document.comparisons[side].with.is_some_and(|with| !Read::of(model).has_reference(side, with)) {
            compare_with(model, side, None);
        }
    }
}

pub(in crate::app) fn begin_comparison(model: &mut Model, side: Side) {
    model.results.slots[side].comparison = ComparisonResults::default();
    model.document.comparisons[side] = model.document.comparisons[side].of_next_burst();
}

/// Of two bursts, the features are drawn too, as the comparison is drawn in their place.
pub fn show_comparison(model: &mut Model, side: Side, with: Option<Reference>) {
    compare_with(model, side, with);
    if model.document.workspace.shows_pair() && with.is_some() {
        (model.document.match_look.features, model.document.pair_tab) = (true, PairTab::Compared);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn either_burst_is_compared_with_its_own_truth_and_takes_the_comparison_along() {
        let mut bench = crate::app::apply::bench::Bench::with_two_charts();
        show_comparison(&mut bench.model, Side::B, Some(Reference::Truth));
        assert!(bench.model.document.match_look.features, "the comparison is seen");
        bench.run_until(|model, _| model.shown_comparison(Side::B).is_some());
        assert!(bench.read().shown_comparison(Side::A).is_none());
        show_comparison(&mut bench.model, Side::A, Some(Reference::Truth));
        bench.run_until(|model, _| model.shown_comparison(Side::A).is_some());
        let shown = |model: Read<'_>| Side::BOTH.map(|side| model.shown_comparison(side).expect("there").clone());
        let [of_a, of_b] = shown(bench.read());
        for (side, shown) in [(Side::A, &of_a), (Side::B, &of_b)] {
            let slot = &bench.model.results.slots[side];
            assert!(std::sync::Arc::ptr_eq(&shown.detection, &slot.found.as_ref().expect("found").detection));
            // All discs of the side's own chart are found or missed.
            let discs = shown.count(Compared::Same) + shown.count(Compared::Theirs);
            let truth = slot.burst.as_ref().expect("open").truth(&crate::Monitor::default()).expect("valid");
            assert_eq!(discs, truth.expect("a chart").features.len());
            assert!(shown.count(Compared::Same) > 0, "{}", shown.summary);
        }
        crate::app::apply::pair::swap_sides(&mut bench.model);
        bench.settle();
        let [a, b] = shown(bench.read());
        assert_eq!((&b.summary, &a.summary), (&of_a.summary, &of_b.summary));
    }
}
