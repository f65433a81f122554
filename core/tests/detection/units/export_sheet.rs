//! Tests of `export::sheet`.

use burstscope_core::export::sheet::*;

#[test]
fn ticks_are_round_and_inside() {
    assert_eq!(ticks((-3.0, 3.0)), [-2.0, 0.0, 2.0]);
    assert_eq!(ticks((0.0, 45.0)), [0.0, 10.0, 20.0, 30.0, 40.0]);
    assert_eq!(ticks((2.0, 2.0)), [2.0]);
    for k in 1..400 {
        let range = (-0.013 * f64::from(k), 0.031 * f64::from(k));
        let ticks = ticks(range);
        assert!((2..=12).contains(&ticks.len()) && ticks.iter().all(|t| *t >= range.0 - 1e-9 && *t <= range.1 + 1e-9));
    }
    assert_eq!((short(-2.0), short(0.25), short(0.000_2)), ("−2".into(), "0.25".into(), "2e−4".into()));
}

#[test]
fn documents_stand_under_one_another() {
    let document = |height: f64| Sheet::new(120.0, "part").finish(height);
    let both = stacked("both", &[document(50.0), document(70.0)]);
    assert!(both.starts_with("<svg ") && both.contains(r#"width="120" height="120""#), "{both}");
    assert!(both.contains(r#"<svg y="50" "#) && both.matches("</svg>").count() == 3, "{both}");
}

#[test]
fn a_paragraph_is_broken_where_it_is_full() {
    let mut sheet = Sheet::new(200.0, "a < b");
    let next = sheet.paragraph((0.0, 10.0), 10.0, 60.0, "one two three four five six");
    assert!(next > 30.0);
    let text = sheet.finish(50.0);
    assert!(text.contains("<title>a &lt; b</title>") && text.matches("<text").count() >= 3, "{text}");
}
