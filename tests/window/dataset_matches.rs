//! Matches of all pairs of a dataset: the matrix, the list, one pair.

use crate::datasets::{chosen, click_burst, dataset, few_slopes, start, walk};
use crate::support::*;
use burstscope::dataset::{KeptBursts, MatchedPair, match_pairs};

fn detected() -> (Folder, Window) {
    let home = folder();
    let mut window = start(walk(&home)).open();
    window.click("Detect all").settle().click("Matches");
    (home, window)
}

fn expected(home: &Path, pair: (usize, usize)) -> MatchCounts {
    let job = FeatureJob { detector: few_slopes().into(), open: OpenOptions::default(), images: ImageKind::default() };
    let store = FeatureStore::open(&home.join("film-burstscope-5"), &job).unwrap();
    let monitor = Monitor::default();
    let bursts = walk_again(home);
    let mut kept = KeptBursts { store: &store, bursts: &bursts, monitor: &monitor };
    let mut counts = None;
    let params = MatchParams::default();
    let mut on = |matched: MatchedPair<'_>| {
        counts = Some(matched.aligned(&params, &monitor)?.counts);
        Ok(())
    };
    match_pairs::<burstscope::error::Error>(&[pair], &params, &mut kept, &mut on, &monitor).unwrap();
    counts.unwrap()
}

fn kept_of(home: &Path, place: usize) -> burstscope::error::Result<Vec<Descriptor>> {
    let job = FeatureJob { detector: few_slopes().into(), open: OpenOptions::default(), images: ImageKind::default() };
    let store = FeatureStore::open(&home.join("film-burstscope-5"), &job)?;
    Ok(store.kept(&walk_again(home)[place], &Monitor::default()).expect("kept").descriptors)
}

fn walk_again(home: &Path) -> Vec<burstscope::burst::BurstFiles> {
    let source =
        burstscope::dataset::DatasetSource { paths: vec![home.join("film")], burst_length: Some(5), burst_step: None };
    source.bursts(&OpenOptions::default()).unwrap()
}

#[test]
fn all_pairs_are_matched_as_the_library_matches_them_and_one_is_looked_at() {
    let (home, mut window) = detected();
    window.click("Match pairs").settle();
    for pair in [(0, 1), (0, 2), (1, 2)] {
        assert_eq!(dataset(&window).matches.counts.get(&pair), Some(&expected(&home, pair)), "{pair:?}");
    }
    assert!(window.shows("3 pairs matched"));
    window.click_on(Role::Row, "Pair frame_002 – frame_012").steps(3);
    assert_eq!(chosen(&window), [Some(0), Some(2)]);
    let counts = expected(&home, (0, 2));
    assert!(window.shows(&format!("{} putative matches, {} inliers", counts.putative, counts.inliers.unwrap())));
    let matrix = window.rect(Role::Image, "Match matrix");
    // Cells are 64 points large; the first row is 72 points below the top, the first column 96 to the right.
    window.click_at(matrix.min + vec2(96.0 + 1.5 * 64.0, 72.0 + 2.5 * 64.0));
    assert_eq!(chosen(&window), [Some(1), Some(2)]);
    window.key(Key::ArrowUp);
    assert_eq!(chosen(&window), [Some(0), Some(2)], "arrow keys move through the matrix");
    window.click("Side by side").settle();
    assert_eq!(window.document().workspace, Workspace::Pair);
    assert_eq!(window.read().place_of(Side::A), Some(0));
    assert_eq!(window.read().place_of(Side::B), Some(2));
    assert_eq!(window.results().slots.b.burst.as_ref().unwrap().burst.name, "frame_012");
}

#[test]
fn neighbours_alone_or_one_pair_can_be_matched() {
    let (home, mut window) = detected();
    window.click_on(Role::RadioButton, "Each with the next").steps(2);
    window.change(|document| document.pairs.overlap = 1).click("Match pairs").settle();
    let matched =
        |window: &Window| [(0, 1), (0, 2), (1, 2)].map(|pair| dataset(window).matches.counts.contains_key(&pair));
    assert_eq!(matched(&window), [true, false, true]);
    window.change(|document| document.matching.ratio = 0.7).steps(3);
    assert!(window.shows("The matching parameters changed; match again"));
    click_burst(&mut window, "Use frame_002 as A");
    click_burst(&mut window, "Use frame_012 as B");
    window.click("Match A with B").settle();
    assert_eq!(matched(&window), [false, true, false]);
    assert_eq!(dataset(&window).matches.params.ratio, 0.7);
    // Those that look most alike, chosen as the command does it.
    window.click_on(Role::RadioButton, "Each with the most alike").steps(2);
    assert_eq!(window.document().pairs.selection(), PairSelection::Near(1));
    window.change(|document| document.matching = MatchParams::default()).click("Match pairs").settle();
    let descriptors = |k: usize| kept_of(&home, k);
    let near = PairSelection::Near(1).pairs_by(3, descriptors, &Monitor::default()).unwrap();
    assert!((2..=3).contains(&near.len()), "each of three bursts has one: {near:?}");
    assert_eq!(matched(&window), [(0, 1), (0, 2), (1, 2)].map(|pair| near.contains(&pair)));
    fs::remove_file(home.join("film-burstscope-5/features/frame_012.png.txt")).unwrap();
    window.click_on(Role::RadioButton, "All pairs").click("Match pairs").settle();
    assert!(window.shows("2 left out, whose bursts have no features yet"));
}

#[test]
fn without_a_dataset_the_room_says_how_to_open_one() {
    let mut window = crate::support::Start::without_auto_detect().open();
    window.choose("One burst ⏷", "Matches");
    assert!(window.shows("a folder of bursts, or a long sequence"));
    window.will_choose("/no/such/dataset").click("Open dataset…").settle();
    assert!(window.shows("/no/such/dataset") && window.results().datasets.open.is_none());
}

#[test]
fn trajectory_matrix() {
    let (_home, mut window) = detected();
    window.click("Match pairs").settle();
    window.harness.get_by_role_and_label(Role::Row, "Pair frame_002 – frame_007").click();
    let model = &mut window.app_mut().model;
    let open = model.results.datasets.open.as_mut().unwrap();
    // More bursts than a test has time for: copies of one film, the more matches the nearer they are.
    let many = 20;
    let (bursts, states) = (open.bursts.clone(), open.states.clone());
    open.opened.bursts = Arc::new(
        (0..many)
            .map(|k| burstscope::burst::BurstFiles { name: format!("frame_{:03}", 2 + 5 * k), ..bursts[k % 3].clone() })
            .collect(),
    );
    open.states = (0..many).map(|k| states[k % 3].clone()).collect();
    for a in 0..many {
        for b in a + 1..many {
            let apart = b - a;
            let putative = 620 / (apart + 1) + 7 * (a % 4);
            let inliers = if apart > 12 { 0 } else { putative * (40 - apart) / 44 };
            let counts = MatchCounts {
                keypoints_a: 900,
                keypoints_b: 880,
                putative,
                inliers: Some(inliers),
                ..Default::default()
            };
            open.matches.counts.insert((a, b), counts);
        }
    }
    for state in &mut open.states {
        if let burstscope::app::results::datasets::BurstState::Done(finished) = state {
            finished.seconds = 0.3;
            finished.features *= 9;
        }
    }
    open.opened.folder = Some("/data/film-burstscope-5".into());
    model.shell.messages.note("190 pairs matched");
    window.snapshot("trajectory_matrix");
}
