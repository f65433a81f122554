//! The probe: what is asked of a place, the trail and the answers that come, and what a new burst leaves of it.

use crate::app::apply::{panes, params};
use crate::app::document::{Probe, Side};
use crate::app::results::{Model, ProbeResults, Read};
use crate::detector::{Slope, SlopeGrid, Slopes};
use crate::engine::Ended;
use crate::inspect::place::{ProbeSubject, check_place};
use crate::requests::{BurstSource, DetectionSource, JobError, OpenBurst, ProbeQuestion, ProbeRequest, Probed, Traced};
use crate::synth::Example;

pub fn clear_probe(model: &mut Model) {
    (model.document.probe, model.results.probed) = Default::default();
}

/// A question about a feature, or a sample on another grid, becomes one about the best candidate at its place.
fn take_trail(model: &mut Model, traced: Traced) {
    let slopes = |traced: &Traced| traced.cache.params().used_slopes();
    if let (Some(ProbeQuestion::At { wanted, .. }), Some(before)) =
        (model.document.probe.question, &model.results.probed.traced)
        && !(matches!(wanted, ProbeSubject::Candidate(_)) && slopes(before) == slopes(&traced))
    {
        look_at(model, ProbeSubject::Best);
    }
    (model.results.probed.traced, model.results.probed.problem) = (Some(traced), None);
}

/// Takes an answer. The question for the strongest candidate then becomes one for its place.
fn take_probe(model: &mut Model, mut answer: Probed) {
    let is_asked = model.document.probe.question == Some(answer.request.question);
    if answer.request.question == ProbeQuestion::Strongest {
        let wanted = answer.probe.subject_fate().map_or(ProbeSubject::Best, |f| ProbeSubject::Candidate(f.of_sample()));
        answer.request.question = ProbeQuestion::At { place: answer.probe.pos_image, wanted };
        if is_asked {
            model.document.probe.question = Some(answer.request.question);
        }
    }
    (model.results.probed.answer, model.results.probed.problem) = (Some(answer), None);
}

pub fn look_at(model: &mut Model, wanted: ProbeSubject) {
    if let Some(place) = Read::of(model).probed_place() {
        model.document.probe.question = Some(ProbeQuestion::At { place, wanted });
    }
}

pub(super) fn take_probed_trail(model: &mut Model, ended: Ended<DetectionSource>) {
    let open = Read::of(model).burst_of(model.document.probe.side).map(|burst| burst.id);
    match ended.result {
        Ok(traced) if Some(traced.burst) == open => take_trail(model, traced),
        Ok(_) => {}
        Err(JobError::Cancelled) => model.results.probed.problem = Some("Cancelled; probe the place again".to_owned()),
        Err(error) => model.results.probed.problem = Some(error.to_string()),
    }
}

pub(super) fn take_probed(model: &mut Model, ended: Ended<ProbeRequest>) {
    let open = Read::of(model).burst_of(model.document.probe.side).map(|burst| burst.id);
    match ended.result {
        Ok(probed) if Some(probed.request.traced.burst) == open => take_probe(model, probed),
        Ok(_) => {}
        Err(JobError::Cancelled) => model.results.probed.wanted_answer.forget(),
        Err(error) => model.results.probed.problem = Some(error.to_string()),
    }
}

pub(super) fn follow_pointer(model: &mut Model) {
    if let Some((side, place)) = model.results.probed.pointer.filter(|_| model.document.probe.follows) {
        set_question(model, side, ProbeQuestion::At { place, wanted: ProbeSubject::Best });
    }
}

pub(in crate::app) fn follow_with_probe(model: &mut Model) {
    let probe = &mut model.document.probe;
    probe.follows ^= true;
    if probe.follows {
        panes::open_probe(model);
    }
}

/// A place outside the picture only gives a note.
pub fn ask_probe(model: &mut Model, side: Side, question: ProbeQuestion) {
    let Some(size) = Read::of(model).burst_of(side).map(|open| open.burst.size()) else { return };
    if matches!(question, ProbeQuestion::At { place, .. } if check_place(place, size).is_err()) {
        model.shell.messages.note("That place lies outside the picture at mid-burst");
        return;
    }
    set_question(model, side, question);
    panes::open_probe(model);
}

/// Probes the burst of `side` from now on: question and answer about the other burst are forgotten. A question about a
/// feature has its own scale and slope.
fn set_question(model: &mut Model, side: Side, question: ProbeQuestion) {
    if model.document.probe.side != side {
        let Probe { is_open, follows, .. } = model.document.probe;
        model.document.probe = Probe { side, is_open, follows, ..Probe::default() };
        model.results.probed = ProbeResults { pointer: model.results.probed.pointer, ..ProbeResults::default() };
    }
    model.document.probe.question = Some(question);
    let has_scale = matches!(question, ProbeQuestion::At { wanted: ProbeSubject::Feature(_), .. });
    model.document.probe.near_sigma = if has_scale { None } else { Read::of(model).sigma_in_view() };
    model.document.probe.in_view = if has_scale { None } else { Read::of(model).slope_in_view() };
}

pub fn probe_feature(model: &mut Model, side: Side, index: usize) {
    let feature = Read::of(model).found_of(side).and_then(|found| found.detection.features.get(index));
    if let Some(place) = feature.map(|feature| [feature.u, feature.v]) {
        if side == Side::A {
            model.document.selected = Some(index);
        }
        ask_probe(model, side, ProbeQuestion::At { place, wanted: ProbeSubject::Feature(index) });
    }
}

pub(in crate::app) fn clear_probe_of(model: &mut Model, side: Side) {
    if model.document.probe.side == side {
        clear_probe(model);
    }
}

/// An example opened as A gets its own grid of slopes if none was given, and is probed at its place of interest if
/// detections start automatically. The next burst, for which `before` is that example, drops the grid again.
pub fn start_probe(model: &mut Model, before: Option<&BurstSource>) {
    let grid = |example: Example| {
        let (range, count) = example.slopes_u();
        SlopeGrid::line(range, count)
    };
    clear_probe_of(model, Side::A);
    if let Some(BurstSource::Example(example)) = before
        && model.document.params.slopes == grid(*example).into()
    {
        model.document.params.slopes = Slopes::AUTO;
    }
    if let Some(OpenBurst { source: BurstSource::Example(example), .. }) = model.results.slots.a.burst {
        let grid = grid(example);
        if model.document.params.slopes.is_auto() {
            model.document.params.slopes = grid.into();
        }
        let has_its_slopes = model.document.params.slopes == grid.into();
        if has_its_slopes {
            let pane = model.document.panes.of_mut(Side::A);
            (pane.cursor.slope, pane.slope_chosen) = (Slope::new(example.slope_u(), 0.0), true);
        }
        if model.document.auto_detect {
            let wanted = match example.scale() {
                Some((octave, level)) if has_its_slopes && model.document.params.first_octave <= octave => {
                    let slope_index = grid.nearest(Slope::new(example.slope_u(), 0.0));
                    ProbeSubject::Scale { octave, level, slope_index }
                }
                _ => ProbeSubject::Best,
            };
            ask_probe(model, Side::A, ProbeQuestion::At { place: example.place(), wanted });
        }
    }
    params::check_params(model);
}

pub fn probe_place(model: &mut Model, side: Side, place: [f32; 2]) {
    ask_probe(model, side, ProbeQuestion::At { place, wanted: ProbeSubject::Best });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::Bench;
    use crate::app::apply::{explained, pair};
    use crate::detector::ParamChange;
    use crate::detector::params::doc;
    use crate::requests::ViewKind;

    fn answered(model: Read<'_>) -> (Side, crate::requests::BurstId, [f32; 2]) {
        let answer = model.results.probed.answer.as_ref().filter(|_| model.probe_is_current()).expect("answered");
        (model.document.probe.side, answer.request.traced.burst, answer.probe.pos_image)
    }

    #[test]
    fn the_scale_of_the_dog_in_view_comes_first_and_another_one_can_be_chosen() {
        let mut bench = Bench::with_two_charts();
        let place = [50.0, 30.0];
        probe_place(&mut bench.model, Side::A, place);
        assert_eq!(bench.model.document.probe.near_sigma, None, "a stack shows all scales");
        let pane = bench.model.document.panes.of_mut(Side::A);
        (pane.cursor.octave, pane.cursor.level) = (1, 2);
        pane.show(ViewKind::Dog);
        probe_place(&mut bench.model, Side::A, place);
        bench.settle();
        let scales = bench.model.results.probed.answer.as_ref().expect("answered").probe.response.scales.clone();
        let shown = scales.iter().find(|s| (s.octave, s.level) == (1, 2)).expect("searched");
        assert_eq!(bench.model.document.probe.near_sigma, Some(shown.sigma));
        bench.model.document.probe.near_sigma = Some(scales[0].sigma);
        assert!(!bench.read().probe_is_current(), "another scale is another question");
        bench.settle();
        assert!(bench.read().probe_is_current());
        let pane = bench.model.document.panes.of_mut(Side::A);
        (pane.cursor.slope, pane.cursor.kind) = (Slope::new(0.25, 0.0), ViewKind::Stack);
        probe_place(&mut bench.model, Side::A, place);
        assert_eq!(bench.model.document.probe.in_view, Some(Slope::new(0.25, 0.0)), "the slope in view comes first");
        bench.model.document.panes.of_mut(Side::A).show(ViewKind::Frame);
        probe_place(&mut bench.model, Side::A, place);
        assert_eq!(bench.model.document.probe.in_view, None, "a frame has no slope");
        probe_feature(&mut bench.model, Side::A, 0);
        let Probe { near_sigma, in_view, .. } = bench.model.document.probe;
        assert_eq!((near_sigma, in_view), (None, None), "a feature has its own scale and slope");
    }

    #[test]
    fn a_probe_stays_with_its_burst_and_ends_with_it() {
        let mut bench = Bench::with_two_charts();
        probe_place(&mut bench.model, Side::B, [20.0, 40.0]);
        bench.settle();
        let (_, burst, place) = answered(bench.read());
        pair::swap_sides(&mut bench.model);
        bench.settle();
        assert_eq!(answered(bench.read()), (Side::A, burst, place));
        pair::close_second(&mut bench.model, &bench.engine);
        bench.settle();
        assert_eq!(answered(bench.read()), (Side::A, burst, place), "another burst was closed");
        let mut bench = Bench::with_two_charts();
        probe_place(&mut bench.model, Side::B, [20.0, 40.0]);
        bench.settle();
        start_probe(&mut bench.model, None);
        assert_eq!(bench.read().probed_place(), Some([20.0, 40.0]), "another burst was opened as A");
        pair::close_second(&mut bench.model, &bench.engine);
        assert!(!bench.read().has_probe());
        bench.settle();
    }

    #[test]
    fn a_change_of_the_slopes_that_is_advised_for_b_begins_with_the_slopes_of_b() {
        let mut bench = Bench::with_two_charts();
        bench.model.document.params.slopes = Slopes::AUTO;
        let own = SlopeGrid::line(-4.0..=4.0, 9);
        bench.model.results.slots.b.found.as_mut().expect("found").detected.params.slopes = own;
        let change = |parameter, value: &str| ParamChange { parameter, value: value.to_owned() };
        bench.model.document.probe.side = Side::B;
        explained::apply_advice(&mut bench.model, Side::B, &[change(doc::EDGE_THRESHOLD, "7")]);
        assert_eq!(bench.model.document.params.edge_threshold, 7.0);
        assert_eq!(bench.model.document.params.slopes, Slopes::AUTO, "slopes were not touched");
        explained::apply_advice(&mut bench.model, Side::B, &[change(doc::SLOPE_DIRECTION, "90")]);
        let slopes = bench.model.document.params.slopes.given().expect("given");
        assert_eq!((slopes.u.count, slopes.u.max), (9, 4.0));
    }
}
