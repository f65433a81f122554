//! Explanations of a detection and the list of its features: the answers, advice that is applied, and the neighbours in
//! the list.

use crate::app::results::{Model, Read};
use crate::app::{document::Side, memo::Itself};
use crate::detector::params::doc;
use crate::detector::{Detection, Feature, ParamChange, Slope};
use crate::engine::Ended;
use crate::requests::{CoherenceRequest, ExplainQuestion, ExplainRequest, Explanation};
use std::sync::Arc;

pub fn want_decoys(model: &mut Model) {
    model.results.explained.asked_decoys.forget();
    model.results.explained.wanted_decoys = Read::of(model).decoys_request();
}

pub(super) fn take_explained(model: &mut Model, Ended { request, result, .. }: Ended<ExplainRequest>) {
    let title = if matches!(request.question, ExplainQuestion::Decoys(_)) { "Decoys" } else { "Explanation" };
    // What no user asked for fails where it would stand.
    let is_quiet = title == "Decoys" && !Read::of(model).has_asked_for_decoys(&request);
    let answer = if is_quiet { result.ok() } else { model.shell.messages.answer(result, title) };
    match answer {
        None => {}
        Some(Explanation::Slopes(spectrum)) => model.results.explained.slopes = Some((request, spectrum)),
        Some(Explanation::TooFew(few)) => model.results.explained.too_few = Some((request, few)),
        Some(Explanation::Decoys(decoys)) => model.results.explained.decoys = Some((request, decoys)),
        Some(Explanation::Candidates(survey)) => {
            model.results.explained.candidates = Some((request, survey));
            (model.document.selected_candidate, model.results.explained.pointed) = (None, None);
        }
    }
}

/// If the changes concern the slopes, these count as given, and are those of the burst of `side`.
pub fn apply_advice(model: &mut Model, side: Side, changes: &[ParamChange]) {
    let grid = Read::of(model).grid_of(side);
    match ParamChange::all_applied(changes, &model.document.params.at(grid)) {
        Ok(changed) => {
            let of_slopes = [doc::SLOPES_U, doc::SLOPES_V, doc::SLOPE_DIRECTION];
            let changes_slopes = changes.iter().any(|change| of_slopes.contains(&change.parameter));
            let slopes = if changes_slopes { changed.slopes.into() } else { model.document.params.slopes };
            model.document.params = changed.with_slopes(slopes);
            let labels: Vec<String> = changes.iter().map(ParamChange::label).collect();
            model.shell.messages.note(format!("Set {}", labels.join(", ")));
        }
        Err(error) => model.shell.messages.error("Apply", error.to_string()),
    }
}

/// Those of detections that are not open any more are forgotten.
pub(super) fn take_coherences(model: &mut Model, ended: Ended<CoherenceRequest>) {
    let open = model.results.slots.both().map(|slot| slot.found.as_ref().map(|found| found.detection.clone()));
    let is_open = |of: &Arc<Detection>| open.iter().flatten().any(|open| Arc::ptr_eq(open, of));
    if let Some(coherences) = model.shell.messages.answer(ended.result, "Coherence") {
        let known = &mut model.results.coherence.known;
        known.retain(|known| is_open(&known.detection) && !Arc::ptr_eq(&known.detection, &coherences.detection));
        known.push(coherences);
    }
}

pub fn apply_set_up(model: &mut Model) {
    let params = Read::of(model).params_of(Side::A);
    let slopes = model.document.set_up.values.slopes(&Read::of(model).used_positions(), &params);
    if let Ok((slopes, options)) = slopes.map(|slopes| (slopes.grid, slopes.options())) {
        model.document.params.slopes = slopes.into();
        model.shell.messages.note(format!("Set {options}"));
    }
}

/// Updates [`Results::listed`](crate::app::results::Results::listed), and what decoys say of it. Cheap without changes.
pub fn refresh_listed(model: &mut Model) {
    let Some(found) = &model.results.slots.a.found else {
        model.results.listed.clear();
        (model.results.listed_for, model.results.listed_decoys) = (None, None);
        return;
    };
    let decoys = Read::of(model).decoys();
    // The slope on show matters only to the filter by slope.
    let slope = model.document.filter.near_slope.map_or_else(Slope::default, |_| model.document.cursor().slope);
    let judged = model.results.coherence.of(&found.detection);
    let (filter, order, set_up) = (&model.document.filter, model.document.order, model.document.set_up.depths_by());
    let known = [judged.map(Itself::from), decoys.map(Itself::from)];
    let now = ((&found.detection).into(), known, filter.clone(), order, slope, set_up.copied());
    if model.results.listed_for.as_ref() != Some(&now) {
        let (features, grid) = (&found.detection.features, &found.detection.slopes);
        let listed = model.document.listed(features, judged.map_or(&[], |judged| &judged[..]), grid, slope);
        let here: Vec<&Feature> = listed.iter().map(|&index| &features[index]).collect();
        let decoys = decoys.filter(|_| judged.is_some() || !filter.needs_verdicts());
        let among =
            decoys.map(|decoys| decoys.among(&here, |decoy, judged| filter.passes(decoy, Some(judged), grid, slope)));
        (model.results.listed, model.results.listed_decoys) = (listed, among);
        model.results.listed_for = Some(now);
    }
}
