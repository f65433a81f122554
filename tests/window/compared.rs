//! Comparison with earlier features and with those of others, and the command that finds the present ones.

use crate::support::*;
use burstscope::export::{write_colmap, write_csv};
use burstscope::inspect::result::{Spot, compare};

#[test]
fn what_a_change_gained_lost_and_moved_is_marked_counted_and_listed() {
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let before: Vec<Spot> = window.read().features().iter().map(Spot::from).collect();
    window.run_action("pin this result").change(|document| document.params.edge_threshold = 8.0);
    window.set().params.noise_gate = NoiseGate::Factor(5.5);
    window.change(|document| document.params.levels = 4).settle();
    let after: Vec<Spot> = window.read().features().iter().map(Spot::from).collect();
    let expected = compare(&before, &after);
    assert!(!expected.lost.is_empty() && !expected.same.is_empty());
    let shown = window.read().shown_comparison(Side::A).expect("a comparison");
    assert_eq!((shown.with, shown.count(Compared::Theirs)), (Reference::Pinned, expected.lost.len()));
    assert_eq!(shown.count(Compared::Ours), expected.gained.len());
    assert_eq!(shown.count(Compared::Moved), expected.moved().count());
    assert!(window.shows(&expected.summary()), "the counts in a line");
    window.click_on(Role::Row, "Lost 0").settle();
    assert_eq!(window.document().comparisons.a.selected, Some(0));
    assert_eq!(window.document().selected, None, "what is lost is none of ours");
    window.snapshot("compared_with_pinned").key(Key::Escape);
    assert_eq!(window.document().comparisons.a.selected, None);
    window.run_action("unpin").settle();
    assert!(window.read().shown_comparison(Side::A).is_none() && !window.shows("as before"));
}

#[test]
fn pinning_and_changing_nothing_shows_no_change_and_what_is_seen_is_copied_as_a_command() {
    let mut window = Start::default().open();
    let count = window.read().features().len();
    window.harness.key_press_modifiers(Modifiers::SHIFT, Key::D);
    window.settle();
    let shown = window.read().shown_comparison(Side::A).expect("a comparison");
    assert!([Compared::Theirs, Compared::Ours, Compared::Moved].into_iter().all(|kind| shown.count(kind) == 0));
    // All orientations of one keypoint count as one.
    assert!(shown.count(Compared::Same) > 0 && shown.count(Compared::Same) <= count);
    window.change(|document| document.params.max_features = 25).settle();
    window.harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::K);
    window.steps(1);
    let line = burstscope::requests::detect_line(&["demo".to_owned()], &window.read().asked(), &Default::default());
    assert!(line.starts_with("burstscope detect demo --out ") && line.contains("--max-features 25"), "{line}");
    window.steps(1);
    assert!(window.shows(&format!("Copied {line}")));
    let (_folder, path) = folder_with("notes.txt");
    fs::write(&path, "nothing of the kind\n").unwrap();
    let mut window = Start::default().open();
    window.will_choose(&path).run_action("open features").settle();
    assert!(window.shows("is neither the header of a feature table"));
}

#[test]
fn features_of_others_are_laid_over_the_burst_and_told_apart() {
    let folder = folder();
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    let mut detection = (*window.found().detection).clone();
    // The other features lack our strongest one, and have one where we have none.
    let lonely = burstscope::Feature { u: 5.0, v: 352.0, sigma: 1.7, ..detection.features[0] };
    detection.features.remove(0);
    detection.descriptors.remove(0);
    detection.features.push(lonely);
    detection.descriptors.push([0; 128]);
    let (csv, txt) = (folder.join("theirs.csv"), folder.join("theirs.txt"));
    write_csv(&csv, &detection.features, None).unwrap();
    write_colmap(&txt, &detection.features, &detection.descriptors).unwrap();
    for path in [csv, txt] {
        window.will_choose(&path).run_action("open features").settle();
        let shown = window.read().shown_comparison(Side::A).expect("a comparison");
        assert_eq!((shown.with, shown.count(Compared::Theirs)), (Reference::File, 1), "{}", path.display());
        let row = &shown.rows[0];
        assert!((row.pos_image[0] - 5.0).abs() < 0.01 && row.feature.is_none(), "{row:?}");
        assert!(window.shows("1 only theirs"));
    }
    window.snapshot("compared_with_theirs").run_action("close opened features").settle();
    assert!(window.read().shown_comparison(Side::A).is_none());
}

#[test]
fn a_session_comes_back_with_what_the_features_are_compared_with() {
    let folder = folder();
    let (session, theirs) = (folder.join("compared.burstscope.toml"), folder.join("theirs.csv"));
    let mut window = Start::default().open();
    write_csv(&theirs, &window.read().features()[5..], None).unwrap();
    window.run_action("pin this result");
    window.change(|document| document.params.noise_gate = NoiseGate::Factor(6.0)).settle();
    let pinned = window.read().shown_comparison(Side::A).expect("a comparison").clone();
    assert!(pinned.count(Compared::Theirs) > 0);
    window.will_choose(&theirs).run_action("open features").settle();
    let laid_over = window.read().shown_comparison(Side::A).expect("a comparison").summary.clone();
    window.will_choose(&session).run_action("save session").settle();
    let reopen = || {
        let mut window = Start::default().open();
        window.will_choose(&session).run_action("open session").settle();
        window
    };
    let shows_pinned = |window: &mut Window| {
        window.click("Pinned result").settle();
        let shown = window.read().shown_comparison(Side::A).expect("a comparison");
        assert_eq!((&shown.rows, &shown.summary), (&pinned.rows, &pinned.summary));
    };
    let mut window = reopen();
    let shown = window.read().shown_comparison(Side::A).expect("a comparison");
    assert_eq!((shown.with, &shown.summary), (Reference::File, &laid_over));
    shows_pinned(&mut window);
    // A missing file is reported where it belongs, and nothing else is lost.
    fs::remove_file(&theirs).unwrap();
    let mut window = reopen();
    assert!(window.read().shown_comparison(Side::A).is_none() && window.shows("theirs.csv"));
    assert_eq!(window.document().params.noise_gate, NoiseGate::Factor(6.0));
    shows_pinned(&mut window);
}
