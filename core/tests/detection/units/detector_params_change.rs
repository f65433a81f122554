//! Tests of `detector::params::change`.

use burstscope_core::detector::params::*;

#[test]
fn every_parameter_of_the_detector_can_be_changed_alone() {
    let before = DetectorParams::default();
    for record in doc::ALL.into_iter().filter(|record| *record != doc::SLOPES) {
        let mut sample = DetectorParams::default();
        let words = (record.field)(&mut sample).words().unwrap_or_default().iter().map(|(word, _)| *word);
        let others = words.chain(["-1:2:5", "1..4", "0.5", "4.25", "3"]).filter(|text| *text != record.text(&before));
        let changed = others.filter_map(|text| Some((text, ParamChange::new(record, text).applied(&before).ok()?)));
        let mut changed = changed.filter(|(text, after)| record.text(after) == **text);
        let (text, after) = changed.next_back().unwrap_or_else(|| panic!("{}: no other value", record.name));
        for other in doc::ALL.into_iter().filter(|_| record != doc::RULES) {
            let expected = if other == record { text.to_owned() } else { other.text(&before) };
            assert_eq!(other.text(&after), expected, "{} changed to {text}: {}", record.name, other.name);
        }
        let error = ParamChange::new(record, "nonsense").applied(&before).expect_err(record.name);
        assert_eq!(error.subject, record.name);
    }
    assert!(ParamChange::new(doc::SLOPES, "auto").applied(&before).is_err());
    assert!(ParamChange::new(doc::LEVELS, 0).applied(&before).is_err(), "checked");
    assert_eq!(ParamChange::new(doc::NOISE_GATE, "strict").option(), "--noise-gate strict");
}
