//! The tab of the noise.

use crate::{maps::lamp, support::*};
use burstscope::synth::NoiseCase;

fn open(path: &Path) -> Window {
    let mut window = Start::at_slopes(path, SlopeGrid::line(-2.0..=2.0, 5)).open();
    window.run_action("detect").settle().open_tab("Noise").settle();
    window
}

fn open_case(case: NoiseCase, folder: &Path) -> Window {
    let burst = case.burst((200, 150), 8, 0.02, 3, &Monitor::default()).unwrap();
    open(&stack(folder, "case.npy", (burst.len(), 150, 200), |(t, v, u)| burst.frames[t].at(u, v)))
}

#[test]
fn the_curve_and_the_map_are_shown_and_opened_in_the_picture_and_assumptions_that_fail_are_said() {
    let home = folder();
    let mut window = open(&lamp(&home));
    let noise = window.found().detection.noise.clone();
    assert!(noise.is_local && noise.transfer.slope > 0.0005, "{:?}", noise.transfer);
    assert!(window.shows("σ of a frame over brightness") && window.shows("σ² = a·I + b"));
    window.click("Show σ in the picture").settle();
    assert_eq!(window.document().focused().content, Content::Map(ViewKind::Noise));
    window.snapshot("noise_tab");
    for (case, word) in [(NoiseCase::Doubled, "repeat"), (NoiseCase::HotPixels, "pixels")] {
        let folder = folder();
        let mut window = open_case(case, &folder);
        let warnings = window.found().detection.noise.warnings.clone();
        assert!(!warnings.is_empty(), "{case:?}");
        for warning in &warnings {
            assert!(window.shows(&format!("Noise: {}.", warning.text)), "{case:?}: {}", warning.text);
        }
        assert!(warnings.iter().any(|w| w.text.contains(word)), "{case:?}: {warnings:?}");
        if case == NoiseCase::HotPixels {
            window.snapshot("noise_warnings");
        }
    }
}
