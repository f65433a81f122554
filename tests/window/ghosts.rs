//! Ghosts, aliases and duplicates: the verdict on each feature in table, filter and panel, and changes that are applied.

use crate::{probe::answer, support::*};
use burstscope::inspect::place::Judged;
use burstscope::inspect::result::{DecoyReport, DecoyStudy, decoys};

fn with_table() -> Window {
    let mut window = Start { size: [1400.0, 900.0], ..Start::default() }.open();
    let model = &mut window.app_mut().model;
    (model.document.panels.bottom, model.document.bottom_tab) = (Visibility::Open, BottomTab::Table);
    window.settle();
    window
}

#[test]
fn the_table_says_of_each_feature_what_it_likely_is_and_sorts_and_filters_by_it() {
    let mut window = with_table();
    let judged = window.read().judged().expect("computed for the table").clone();
    assert_eq!(judged.len(), window.read().features().len());
    let count = |verdict: Verdict| judged.iter().filter(|judged| judged.verdict == verdict).count();
    assert!(count(Verdict::Real) > 200 && count(Verdict::Ghost) > 10, "{}", count(Verdict::Ghost));
    assert!(window.shows("real"), "the first rows are seen");
    window.click("Sort by Coher.");
    assert_eq!(window.document().order, Order { column: Quantity::Coherence, descending: false });
    let coherence = |index: &usize| judged[*index].coherence.unwrap_or(f32::INFINITY);
    assert!(window.results().listed.iter().map(coherence).is_sorted());
    window.harness.query_all_by_label_contains("Filter").next().expect("the filter").click();
    window.steps(3);
    // The second is a way to move.
    window.harness.query_all_by_label("ghost").next().expect("a verdict").click();
    window.settle();
    assert_eq!(window.document().filter.verdict, Some(Verdict::Ghost));
    assert_eq!(window.results().listed.len(), count(Verdict::Ghost));
    assert!(window.results().listed.iter().all(|&index| judged[index].verdict == Verdict::Ghost));
    window.key(Key::Escape);
    let ghost = window.results().listed[0];
    window.change(|document| document.selected = Some(ghost)).settle();
    assert!(window.shows("Likely a ghost: only some of the frames respond"), "in the panel");
    window.snapshot("verdicts");
    let feature = window.read().features()[ghost];
    let at = window.ui_from_image(pos2(feature.u, feature.v)).expect("a picture");
    window.hover(at).steps(4);
    assert!(window.results().hovered.is_some());
}

#[test]
fn apply_says_how_long_a_search_takes_before_it_is_pressed_and_then_keeps_the_candidate() {
    let mut start = Start { size: [1280.0, 900.0], ..Start::automatic() };
    start.startup.source = Some(BurstSource::Example(Example::LowContrast));
    let mut window = start.open();
    let fate = answer(&window).probe.subject_fate().expect("a candidate").clone();
    assert_eq!(fate.first_failed, Some(Test::NoiseGate));
    let change = fate.remedy.as_ref().expect("a lower gate").change.clone();
    assert!(window.shows("A new search takes "));
    let before = window.read().features().len();
    window.snapshot("probe_change").click(&format!("Apply {}", change.label())).settle();
    assert!(window.read().features().len() > before);
    assert!(answer(&window).probe.subject_fate().is_some_and(|fate| fate.is_kept()));
}

#[test]
fn the_probe_of_a_ghost_tells_what_crosses_its_path_and_why_decoys_cannot_tell() {
    let mut window = with_table();
    let judged = window.read().judged().expect("computed").clone();
    let crosses = |judged: &Judged| judged.verdict == Verdict::Ghost && judged.why.contains("crosses its path");
    let ghost = judged.iter().position(crosses).expect("one");
    apply::probe::probe_feature(&mut window.app_mut().model, Side::A, ghost);
    window.settle();
    assert!(window.shows("Ghost?") && window.shows("crosses its path"));
    assert_eq!(answer(&window).probe.judged.as_ref(), Some(&judged[ghost]));
    window.snapshot("probe_ghost");
    window.change(|document| document.params.frames = Some(FrameRange { start: 0, end: 3 })).settle();
    window.run_action("Only real ones").settle();
    assert!(window.shows("Noise unknown: ") && window.shows("4 or more"));
    assert!(window.errors().is_empty(), "nobody pressed a button");
}

#[test]
fn the_number_of_listed_features_that_noise_explains_follows_the_filter() {
    let mut window = with_table();
    let known = |window: &Window| window.results().listed_decoys.clone();
    assert!(known(&window).is_none() && !window.shows("expected of noise"), "nobody asked");
    window.run_action("Only real ones").settle();
    let real = known(&window).expect("asked for by the filter");
    assert!(window.shows(" expected of noise"), "{}", real.expected_words());
    assert_eq!(real.rates[0].found, window.results().listed.len());
    window.run_action("Only real ones").settle();
    let burst = &window.opened().burst;
    let cache = ProbeCache::new(burst, &window.read().asked(), &Monitor::default()).unwrap();
    let report = decoys(&cache.trail, &DecoyStudy::default(), false, &Monitor::default()).unwrap().report;
    let all = known(&window).expect("found once for the detection");
    assert_eq!((&all.rates[0], all.still), (&report.rates[0], report.still));
    let number = |report: &DecoyReport| report.rates[0].mean_in_copies();
    assert!(number(&real) < number(&all), "{} {}", number(&real), number(&all));
    // A limit counts as it does in the table of the command.
    let at_8 = report.rates.iter().find(|rate| rate.snr == 8.0).expect("told");
    let strong = Interval { min: 8.0, max: f32::INFINITY };
    window.change(|document| document.filter.ranges.insert(Quantity::Snr, strong)).steps(3);
    let listed = known(&window).expect("no search is needed");
    assert_eq!((listed.rates[0].found, &listed.rates[0].in_copies), (at_8.found, &at_8.in_copies));
    // Other features, whose decoys nobody asked for.
    window.set().params.levels += 1;
    window.settle();
    assert!(known(&window).is_none() && window.shows("Expected of noise…"));
    window.click("Expected of noise…").settle();
    assert!(known(&window).is_some());
}
