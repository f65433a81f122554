//! Colours by coherence: how evenly the frames respond along each feature's motion.

use crate::support::{Start, Window};
use burstscope::Monitor;
use burstscope::app::project::side::Side;
use burstscope::inspect::ProbeCache;
use burstscope::inspect::shares::coherences;
use egui::accesskit::Role;
use egui::pos2;
use egui_kittest::kittest::Queryable;

fn colour_by_coherence(window: &mut Window) {
    window.harness.get_by_role_and_label(Role::ComboBox, "Colour by").click();
    window.harness.run_steps(4);
    window.click("Coherence");
}

#[test]
fn colours_tell_the_coherence_and_features_are_grey_until_it_is_known() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::without_auto_detect() }.open();
    window.run_action("detect");
    window.settle();
    colour_by_coherence(&mut window);
    window.settle();
    // The values are those of the library.
    let model = &window.app().model;
    let detection = model.slots.a.found.as_ref().unwrap().detection.clone();
    let values = model.coherence.of(&detection).unwrap().clone();
    let cache =
        ProbeCache::new(&model.slots.a.burst.as_ref().unwrap().burst, &model.asked(), &Monitor::default()).unwrap();
    assert_eq!(*values, coherences(&cache.trail, &Monitor::default()).unwrap());
    assert!(window.shows("Legend: coherence from 0 to 1") && !window.shows("Grey: not known yet"));
    assert_eq!(window.shows("Grey: too noisy to tell"), values.iter().any(Option::is_none));
    // The selected feature and the one under the pointer show their values.
    let index = (0..values.len()).find(|&i| values[i].is_some_and(|c| c < 0.995)).expect("one is not quite even");
    let text = format!("{:.2}", values[index].unwrap());
    window.app_mut().model.selected = Some(index);
    window.harness.run_steps(2);
    window.settle();
    assert!(window.shows("Coherence") && window.shows(&text));
    let feature = detection.features[index];
    let at = window.app().ui_from_image(pos2(feature.u, feature.v)).unwrap();
    window.harness.hover_at(at);
    window.harness.run_steps(3);
    assert!(window.shows("\ncoherence "), "the pointer says it");
    window.snapshot("coherence");
    // The figure has these colours too, with a legend.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coherence.svg");
    window.app_mut().model.figure.legend = true;
    window.dialogs.will_choose(&path);
    window.run_action("figure as svg");
    window.settle();
    let svg = std::fs::read_to_string(&path).unwrap();
    let colours: std::collections::BTreeSet<&str> = svg
        .lines()
        .filter(|line| line.contains("<circle"))
        .filter_map(|line| line.split("stroke=\"").nth(1)?.split('"').next())
        .collect();
    assert!(colours.len() > 5 && svg.contains(">0.75"), "{colours:?}");
    // Another detection has other values; unknown ones are grey, and choosing the quantity again restarts a cancelled
    // computation.
    window.app_mut().model.params.octaves = 2;
    window.run_action("detect");
    window.settle();
    let now = window.app().model.slots.a.found.as_ref().unwrap().detection.clone();
    let model = &mut window.app_mut().model;
    assert!(model.coherence.of(&detection).is_none() && model.coherence.of(&now).is_some());
    model.coherence = Default::default();
    let missing = model.missing_coherence(Side::A).expect("it is shown, and was forgotten");
    let app = window.app_mut();
    app.model.coherence.wanted.a.ask(&app.engine, missing);
    app.model.coherence.wanted.a.cancel();
    window.settle();
    assert!(window.shows("Grey: cancelled"));
    colour_by_coherence(&mut window);
    window.settle();
    assert!(window.app().model.coherence.of(&now).is_some() && !window.shows("Grey: cancelled"));
}
