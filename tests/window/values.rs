//! The values that the user sets and the answers about them, as plain values: without a window.

use crate::support::*;
use burstscope::app::dataset::pairs::{CountColours, matrix_ui};
use burstscope::app::document::{cursor::*, filter::near_slope, lab::*};
use burstscope::app::measure::{Hidden, mask_of};
use burstscope::app::pane::{Pane, Preset};
use burstscope::app::results::{Dataset, datasets::pairs::PairTable, datasets::pairs::lost_text, studies::*};
use burstscope::app::view::{KnownOfFeature, MAX_POINTS_PER_PIXEL, RectTransform, View, quantity_text};
use burstscope::evaluate::BurstMethod;
use burstscope::evaluate::poses::{
    DEMO_ESTIMATE, DEMO_TRUTH, Pose, PoseStudy, Projection, Trajectory, read_trajectory,
};
use burstscope::inspect::{pair::Lost, slopes::SetUp};
use burstscope::matching::Refusal;
use burstscope::plane::Mask;
use burstscope::study::Study;
use egui::Color32;
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

#[test]
fn playing_and_steps_go_along_the_grid_and_a_cursor_is_brought_into_range() {
    let plane = SlopeGrid::plane(-1.0..=1.0, 3, 0.0..=1.0, 2);
    let (row, at) = row_of(&plane, Slope::new(0.9, 0.8));
    assert_eq!((row, at), (vec![Slope::new(-1.0, 1.0), Slope::new(0.0, 1.0), Slope::new(1.0, 1.0)], 2));
    let column = SlopeGrid { u: SlopeGrid::single(Slope::default()).u, ..plane };
    assert_eq!(row_of(&column, Slope::new(3.0, 0.1)), (vec![Slope::new(0.0, 0.0), Slope::new(0.0, 1.0)], 0));
    for count in [1, 2, 7] {
        let places: Vec<usize> = (0..=2 * count).map(|step| back_and_forth(step, count)).collect();
        assert!((0..count).all(|place| places[place] == place), "{places:?}");
        assert!(places.windows(2).all(|two| two[0].abs_diff(two[1]) == usize::from(count > 1)), "{places:?}");
    }
    let params = DetectorParams::default();
    let wild = Cursor { kind: ViewKind::Dog, frame: 99, slope: Slope::new(f32::NAN, 1e9), octave: 77, level: -9 };
    let tame = wild.within(&params, 10, (640, 480));
    assert_eq!((tame.frame, tame.level), (9, -1));
    assert_eq!(tame.slope, Slope::new(0.0, slope_limit(&params.slopes)));
    assert!(octave_range(&params, (640, 480)).contains(&tame.octave));
    let grid = SlopeGrid::line(-3.0..=3.0, 7);
    assert_eq!(stepped(&grid, Slope::new(0.2, 0.0), false, true), Slope::new(1.0, 0.0));
    assert_eq!(stepped(&grid, Slope::new(3.0, 0.0), false, true), Slope::new(3.0, 0.0));
    assert_eq!(stepped(&grid, Slope::new(1.0, 0.0), true, true), Slope::new(1.0, 0.25));
    assert_eq!(snapped(&grid, Slope::new(1.4, 0.6)), Slope::new(1.0, 0.0));
}

#[test]
fn each_method_takes_the_edited_parameters_in_its_own_way() {
    let line = DetectorParams { slopes: SlopeGrid::line(-2.0..=2.0, 5), ..DetectorParams::default() };
    assert_eq!(MethodId::Buff1d.params(&line), line);
    assert_eq!(MethodId::Buff2d.params(&line).slopes, SlopeGrid::plane(-2.0..=2.0, 5, -2.0..=2.0, 5));
    let plane = DetectorParams { slopes: SlopeGrid::plane(-3.0..=3.0, 7, -1.0..=1.0, 3), ..line.clone() };
    assert_eq!(MethodId::Buff2d.params(&plane), plane);
    let forwards = DetectorParams { slopes: SlopeGrid::line(-6.0..=-3.0, 4), ..line.clone() };
    let around_zero = SlopeGrid::plane(-6.0..=-3.0, 4, -2.0..=2.0, 5);
    assert_eq!(MethodId::Buff2d.params(&forwards).slopes, around_zero, "v has no slopes of u's range");
    assert_eq!(MethodId::Buff1d.params(&plane).slopes, SlopeGrid::line(-3.0..=3.0, 7));
    let sift = DetectorParams { method: Method::Sift, peak_threshold: 0.01, ..line };
    assert_eq!(MethodId::Sift.params(&sift), sift);
    assert_eq!(MethodId::Buff1d.params(&sift).peak_threshold, 0.01);
    for method in MethodId::ALL {
        assert!(!method.words()[1].is_empty());
        assert_eq!(method.params(&plane).validate(), Ok(()));
    }
}

#[test]
fn studies_ask_as_commands_by_default_and_ratios_and_numbers_of_frames_are_read_as_typed() {
    let with = |snrs: &str, counts: &str| {
        let question = LabQuestion::Frames;
        let (snrs_text, counts_text) = (snrs.to_owned(), counts.to_owned());
        Lab { question, snrs_text, counts_text, ..Lab::default() }.study(&SearchParams::default(), None)
    };
    let Ok(Study::Chart(study)) = with("0.6", "2, 10") else { panic!("a study of frames") };
    assert_eq!((study.frame_counts, study.snrs), (vec![2, 10], vec![0.6]));
    assert!(with("0.6, 1", "2").expect_err("two ratios").contains("one SNR"));
    assert!(with("0.6", " ,").expect_err("no number").contains("such as 2, 5, 10"));
    assert!(with("0.6", "2, ten").expect_err("a word").contains("'ten'"));
    let lab = Lab { question: LabQuestion::BurstFrames, ..Lab::default() };
    assert!(lab.study(&SearchParams::default(), None).expect_err("no burst").contains("open a burst"));
    let read = |text: &str| Lab { snrs_text: text.to_owned(), ..Lab::default() }.snrs();
    assert_eq!(read(" 0.2,0.35 , 0.2,"), Ok(vec![0.2, 0.35]));
    for (text, says) in [("0.2; 1", "'0.2; 1'"), ("-1", "'-1'"), ("NaN", "'NaN'"), (" ,", "no ratio")] {
        assert!(read(text).expect_err(text).contains(says), "{text}");
    }
    let lab = Lab { methods: BurstMethod::WITH_GIVEN_SLOPES.to_vec(), ..Lab::default() };
    let study = lab.study(&SearchParams::default(), None).expect("sound");
    assert_eq!(study, Study::Chart(Box::default()));
    let given = SearchParams { slopes: SlopeGrid::default().into(), ..SearchParams::default() };
    let Study::Chart(study) = lab.study(&given, None).expect("sound") else { panic!("a study of charts") };
    assert_eq!(study.searches.slopes_1d, given.at_given().slopes);
}

fn compared(read: [ReadTrajectory; 3]) -> ComparedPoses {
    ComparedPoses::of(read, &PoseStudy::default())
}

fn scene(compared: &ComparedPoses, projection: Projection, points: bool) -> PlaneScene {
    PlaneScene::of(compared, &Trajectories { projection, points, ..Trajectories::default() })
}

fn trajectory(centres: &[[f64; 3]]) -> Arc<Trajectory> {
    let pose = |(k, c): (usize, &[f64; 3])| Pose {
        label: format!("{k}.png"),
        order: k as u32,
        time: None,
        world_from_camera: Isometry3::new(Vector3::from(*c), Vector3::zeros()),
    };
    Arc::new(Trajectory { poses: centres.iter().enumerate().map(pose).collect(), model: None })
}

#[test]
fn estimates_of_other_scales_lie_on_the_truth_and_cameras_in_one_place_or_on_a_line_have_a_plane() {
    let truth = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 2.0, 0.0], [0.0, 2.0, 1.0]];
    let estimate = truth.map(|c| c.map(|x| 10.0 * x + 3.0));
    let second = truth.map(|c| c.map(|x| 0.1 * x - 7.0));
    let read = |name: &str, centres: &[[f64; 3]]| Some((PathBuf::from(name), trajectory(centres)));
    let [first, second, truth] = [read("e", &estimate[..3]), read("s", &second[..3]), read("t", &truth)];
    let both = compared([first.clone(), second.clone(), truth.clone()]);
    assert_eq!(both.pairs, [[Some(0); 2], [Some(1); 2], [Some(2); 2], [None; 2]]);
    let drawn = scene(&both, Projection::Xy, false);
    assert_eq!((drawn.cameras.each_ref().map(Vec::len), drawn.size), ([3, 3, 4], (1120, 620)));
    let [of_first, of_second, of_truth] = &drawn.cameras;
    for spot in of_first.iter().chain(of_second) {
        let there = &of_truth[spot.index];
        assert!((spot.pos - there.pos).length() < 1e-2, "{spot:?} {there:?}");
        assert_eq!((spot.camera, there.camera), (Some(spot.index), Some(spot.index)));
    }
    assert_eq!(of_truth[0].pos, pos2(60.0, 560.0), "up is up");
    // Alone, the first is drawn in its own coordinates; without a comparison only the truth is drawn.
    let drawn = |read| scene(&compared(read), Projection::Xy, true).cameras.map(|cameras| cameras.len());
    assert_eq!(drawn([first, second.clone(), None]), [3, 0, 0]);
    assert_eq!(drawn([read("one", &[[0.0; 3]]), second, truth]), [0, 3, 4]);
    for centres in [&[][..], &[[1.0, 1.0, 1.0]; 2], &[[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]] {
        let truth = Some(("t".into(), trajectory(centres)));
        let drawn = scene(&compared([None, None, truth]), Projection::Principal, false);
        assert!(drawn.size.0 >= 300 && drawn.size.1 >= 300, "{:?}", drawn.size);
        assert!(drawn.cameras[2].iter().all(|s| s.pos.is_finite()));
    }
}

#[test]
fn points_lie_where_their_cameras_saw_them_and_are_in_the_section_shown() {
    let [estimate, truth] = [DEMO_ESTIMATE, DEMO_TRUTH].map(|name| {
        let path = PathBuf::from(name);
        (path.clone(), Arc::new(read_trajectory(&path).expect("built in")))
    });
    let points = estimate.1.model.as_ref().expect("a model").points.len();
    let both = compared([Some(estimate), None, Some(truth)]);
    let drawn = scene(&both, Projection::Xz, true);
    let (width, height) = (drawn.size.0 as f32, drawn.size.1 as f32);
    let section = Rect::from_min_size(Pos2::ZERO, vec2(width, height));
    let inside = drawn.points.iter().filter(|(_, p)| section.contains(*p)).count();
    assert!(drawn.points.len() == points && inside > points * 9 / 10, "{inside} of {points}");
    // Ahead is up, and the cameras look ahead.
    let nearest = drawn.points.iter().map(|(_, p)| p.y).fold(0.0, f32::max);
    assert!(drawn.cameras[2].iter().all(|camera| camera.pos.y > nearest && section.contains(camera.pos)));
    assert_eq!(scene(&both, Projection::Xz, false).points, []);
    // Not aligned, the points have no place beside the truth.
    let apart = ComparedPoses { reports: [Some(Err("no".into())), None], ..both };
    assert_eq!(scene(&apart, Projection::Xz, true).points, []);
}

fn feature(u: f32, sigma: f32, slope_u: f32) -> Feature {
    let (slope, response, at_slope_limit) = (Slope::new(slope_u, 0.0), -0.1 * sigma, slope_u.abs() >= 3.0);
    Feature { u, sigma, slope, response, at_slope_limit, ..Feature::default() }
}

#[test]
fn filters_add_up_and_the_order_turns_round() {
    let features = [feature(5.0, 2.0, 1.0), feature(1.0, 4.0, -2.0), feature(3.0, 8.0, 3.0)];
    let (slope, grid) = (Slope::new(1.0, 0.0), SlopeGrid::line(-3.0..=3.0, 7));
    let listed = |filter: &Filter, order| {
        let document = Document { filter: filter.clone(), order, ..Document::default() };
        document.listed(&features, &[], &grid, slope)
    };
    let mut filter = Filter::default();
    assert!(filter.is_open());
    let order = Order::default().clicked(Quantity::U);
    assert_eq!(listed(&filter, order), [1, 2, 0]);
    assert_eq!(listed(&filter, order.clicked(Quantity::U)), [0, 2, 1]);
    filter.ranges.insert(Quantity::Sigma, Interval { min: 3.0, max: 9.0 });
    // Sessions of before had a field for each range.
    let old: Filter = toml::from_str("[sigma]\nmin = 3.0\nmax = 9.0\n").expect("read");
    assert_eq!((&old, toml::from_str(&toml::to_string(&old).expect("written"))), (&filter, Ok(filter.clone())));
    assert!(toml::from_str::<Filter>("[size]\nmin = 1.0\nmax = 2.0\n").is_err());
    assert_eq!(listed(&filter, Order::default()), [1, 2]);
    filter.hide_slope_limit = true;
    assert_eq!(listed(&filter, Order::default()), [1]);
    assert_eq!(listed(&Filter { near_slope: Some(0.5), ..Filter::default() }, Order::default()), [0]);
}

#[test]
fn features_are_at_a_slope_by_their_motion_half_way_to_the_next_and_filtered_by_layer() {
    let placed = Feature { field: Slope::new(2.0, 0.0), field_sigma: 0.05, slope_sigma: 0.2, ..feature(5.0, 2.0, 2.2) };
    let placed = Feature { moves: Moves::WithSurroundings, ..placed };
    let by_itself = Feature { slope: Slope::new(-1.0, 0.0), layer: 0, moves: Moves::ByItself, ..placed };
    let edge = Feature { slope: Slope::new(0.0, 0.5), slope_sigma: 0.9, moves: Moves::Edge, ..placed };
    let unknown = Feature { field_sigma: f32::INFINITY, layer: 2, moves: Moves::Unknown, ..placed };
    let features = [Feature { layer: 1, ..placed }, by_itself, Feature { layer: 1, ..edge }, unknown];
    let passing = |filter: Filter| {
        let (grid, slope) = (SlopeGrid::line(-3.0..=3.0, 7), Slope::new(2.0, 0.0));
        Document { filter, ..Document::default() }.listed(&features, &[], &grid, slope)
    };
    let open = Filter::default;
    let near = |limit| passing(Filter { near_slope: Some(limit), ..open() });
    assert_eq!(near(0.1), [0, 2], "an edge moves as its surroundings");
    let usual = near_slope(&SlopeGrid::line(-3.0..=3.0, 7));
    assert_eq!(near(usual), [0, 2, 3], "without a field by its own slope, which is nearest to 2");
    let hidden = |layers: &[i32], solo_layer| {
        passing(Filter { hidden_layers: layers.iter().copied().collect(), solo_layer, ..open() })
    };
    assert_eq!([1, 2, 0].map(|n| hidden(&[], Some(n))), [vec![0, 2], vec![3], vec![1]]);
    assert_eq!((hidden(&[1], None), hidden(&[0, 2], None)), (vec![1, 3], vec![0, 2]));
    assert_eq!(hidden(&[1, 2], Some(1)), [0, 2], "alone, whatever is switched off");
    let moving = Moves::ALL.map(|moves| passing(Filter { moves: Some(moves), ..open() }));
    assert_eq!(moving, [vec![3], vec![0], vec![1], vec![2], vec![]]);
    let filter = Filter { hidden_layers: [2].into(), solo_layer: Some(1), moves: Some(Moves::ByItself), ..open() };
    let text = toml::to_string(&filter).expect("text");
    assert!(text.contains("solo_layer = 1") && text.contains("hidden_layers = [2]"), "{text}");
    assert_eq!(toml::from_str::<Filter>(&text).expect("a filter"), filter);
    assert!((near_slope(&SlopeGrid::line(-2.0..=2.0, 5)) - 0.55).abs() < 1e-6);
    assert!((near_slope(&SlopeGrid::plane(-1.0..=1.0, 5, -2.0..=2.0, 3)) - 1.1).abs() < 1e-6);
    assert_eq!(near_slope(&SlopeGrid::line(0.0..=0.0, 1)), 0.1, "of a single slope those that are nearly there");
}

#[test]
fn every_quantity_has_a_record_and_a_text_and_a_response_of_a_dark_burst_is_not_nought() {
    let feature = feature(5.0, 2.0, 3.0);
    for quantity in Quantity::ALL {
        let record = quantity.record();
        assert!(!record.heading.is_empty() && !record.help.is_empty());
        assert_eq!(serde_json::to_string(&quantity).ok(), Some(format!("\"{}\"", record.key)), "as sessions name it");
        assert!(!quantity_text(quantity, 0, &feature, KnownOfFeature::default()).is_empty(), "{quantity:?}");
        assert!(record.term.is_none_or(|term| burstscope::teach::glossary::glossary().find(term).is_some()));
    }
    let dark = Feature { response: -0.000_021_7, ..feature };
    assert_eq!(quantity_text(Quantity::Response, 0, &dark, KnownOfFeature::default()), "−2.17e−5");
}

const SIZE: (usize, usize) = (1600, 1200);

fn canvas() -> Rect {
    Rect::from_min_size(pos2(30.0, 40.0), Vec2::new(800.0, 600.0))
}

#[test]
fn a_view_follows_another_and_keeps_its_distance_and_the_pane_in_focus_goes_on_in_every_preset() {
    let mut other = View::new(Zoom::PointsPerPixel(2.0), [100.0, 80.0]);
    let mut mine = View::new(Zoom::PointsPerPixel(2.0), [110.0, 85.0]);
    let before = other;
    other.zoom_at(pos2(500.0, 300.0), 1.5, canvas());
    other.pan(Vec2::new(30.0, -12.0));
    mine.follow(&before, &other);
    assert_eq!(mine.zoom, other.zoom);
    let apart = pos2(mine.centre_image[0], mine.centre_image[1]) - Pos2::from(other.centre_image);
    assert!((apart - Vec2::new(10.0, 5.0)).length() < 1e-3);
    let before = other;
    other.set_fit();
    mine.follow(&before, &other);
    assert!(mine.is_fit());
    let params = DetectorParams { slopes: SlopeGrid::line(-3.0..=3.0, 7), ..DetectorParams::default() };
    for (preset, ..) in Preset::ALL {
        for kind in ViewKind::OF_CURSOR {
            let mut pane = Pane::new(Side::A);
            pane.cursor.slope = Slope::new(1.0, 0.0);
            pane.show(kind);
            let laid = preset.lay_out(&pane, &params);
            let panes: Vec<&Pane> = laid.rows.iter().flatten().collect();
            assert_eq!(panes[laid.focus].cursor.slope, Slope::new(1.0, 0.0), "{preset:?} {kind:?}");
            assert!(panes.iter().all(|pane| pane.side == Side::A));
        }
    }
}

#[test]
fn zoom_has_limits_the_image_stays_reachable_and_positions_exact_far_out() {
    let mut view = View::fit();
    view.settle(canvas(), SIZE, 1.0);
    (0..100).for_each(|_| view.zoom_at(canvas().center(), 2.0, canvas()));
    assert_eq!(view.points_per_pixel(), MAX_POINTS_PER_PIXEL);
    (0..100).for_each(|_| view.zoom_at(canvas().center(), 0.5, canvas()));
    let fit = View::fit().settle(canvas(), SIZE, 1.0).scale();
    assert!(view.points_per_pixel() <= fit && view.points_per_pixel() > 0.4 * fit);
    view.pan(Vec2::new(1e7, -1e7));
    view.settle(canvas(), SIZE, 1.0);
    assert_eq!(view.centre_image, [-0.5, 1199.5]);
    let t = RectTransform::new(pos2(16000.0, 16000.0), pos2(500.0, 400.0), 128.0);
    let moved = t.pos(pos2(16000.0 + 1.0 / 64.0, 16000.0)) - t.pos(pos2(16000.0, 16000.0));
    assert!((moved.x - 2.0).abs() < 1e-3, "{moved:?}");
    let back = t.inverse().pos(t.pos(pos2(-100.0, 20_000.0)));
    assert!((back - pos2(-100.0, 20_000.0)).length() < 0.02, "{back:?}");
}

proptest! {
    #[test]
    fn what_is_under_the_pointer_stays_there(
        x in 30f32..830.0, y in 40f32..640.0, factors in prop::collection::vec(0.7f32..1.5, 1..12)
    ) {
        let mut view = View::fit();
        view.settle(canvas(), SIZE, 1.0);
        let pointer = pos2(x, y);
        let unsnapped = |view: &View| {
            RectTransform::new(view.centre_image.into(), canvas().center(), view.points_per_pixel())
        };
        let before = unsnapped(&view).inverse().pos(pointer);
        factors.into_iter().for_each(|factor| view.zoom_at(pointer, factor, canvas()));
        let after = unsnapped(&view).pos(before);
        prop_assert!((after - pointer).length() < 0.05, "{after:?} instead of {pointer:?}");
    }
}

#[test]
fn a_mask_hides_what_lies_inside_of_outlines_and_what_no_frame_shows() {
    let plain = Plane::zeros(12, 8);
    let burst = Burst::from_planes("plain", vec![plain.clone(); 2]);
    let square = Hidden::Outline(vec![pos2(1.5, 1.5), pos2(4.5, 1.5), pos2(4.5, 3.5), pos2(1.5, 3.5)]);
    let greys = mask_of(&burst, std::slice::from_ref(&square));
    let hidden: Vec<usize> = (0..96).filter(|k| greys[*k] == 0).collect();
    assert_eq!(hidden, [26, 27, 28, 38, 39, 40]);
    // A rectangle beyond the picture's rim, and an empty rectangle.
    let beyond = Hidden::Outline(vec![pos2(-9.0, -9.0), pos2(99.0, -9.0), pos2(99.0, 99.0), pos2(-9.0, 99.0)]);
    assert!(mask_of(&burst, &[beyond]).iter().all(|grey| *grey == 0));
    assert!(
        mask_of(&burst, &[Hidden::Outline(vec![pos2(3.0, 3.0)]), Hidden::Outline(Vec::new())])
            .iter()
            .all(|grey| *grey == 255)
    );
    // Twice around is hidden as once is; a stroke hides the discs along it.
    let twice = Hidden::Outline(
        [1.5, 4.5, 4.5, 1.5].iter().zip([1.5, 1.5, 3.5, 3.5]).cycle().take(8).map(|(u, v)| pos2(*u, v)).collect(),
    );
    assert_eq!(mask_of(&burst, &[twice]), greys);
    let stroke = Hidden::Stroke { path: vec![pos2(3.0, 3.0), pos2(8.0, 3.0)], radius_px: 1.0 };
    let hidden: Vec<usize> = (0..96).filter(|k| mask_of(&burst, std::slice::from_ref(&stroke))[*k] == 0).collect();
    let row = |v: usize, columns: std::ops::RangeInclusive<usize>| columns.map(move |u| 12 * v + u);
    let expected: Vec<usize> = row(2, 3..=8).chain(row(3, 2..=9)).chain(row(4, 3..=8)).collect();
    assert_eq!(hidden, expected);
    let mask = |column: usize| Mask::new(Plane::from_fn(12, 8, |u, _| f32::from(u != 0 && u != column)));
    let masked = [5, 6].map(|column| Arc::new(plain.clone().masked(mask(column)))).to_vec();
    let greys = mask_of(&Burst { frames: masked, ..burst }, &[]);
    assert!((0..96).all(|k| (greys[k] == 0) == (k % 12 == 0)), "what one frame shows is seen");
}

#[test]
fn only_a_sound_set_up_gives_depths_and_they_sort_the_features_unknown_ones_last() {
    let state = SetUpState::default();
    let alone = Feature { slope: Slope::new(-2.5, 0.0), slope_sigma: 0.25, ..Feature::default() };
    assert_eq!(state.known(&alone, None).depth_m, None);
    let read = SetUpState { reads_depths: true, ..state };
    assert_eq!(read.known(&alone, None).depth_m, Some([8.0, 0.8]), "by itself");
    let field = Slope::new(-5.0, 0.0);
    let edge = Feature { field, slope_sigma: 1.0, field_sigma: 0.25, moves: Moves::Edge, ..alone };
    assert_eq!(read.known(&edge, None).depth_m, Some([4.0, 0.2]), "as its surroundings");
    let typed = SetUpState { values: SetUp { speed_m_s: -1.0, ..SetUp::default() }, ..read };
    assert_eq!(typed.depths_by(), None);
    let features = [feature(5.0, 2.0, -2.5), feature(1.0, 4.0, 2.0), feature(3.0, 8.0, -20.0)];
    let order = Order::default().clicked(Quantity::Depth);
    let mut document = Document { order, ..Document::default() };
    let sorted = |by: &Document| by.listed(&features, &[], &SlopeGrid::default(), Slope::default());
    assert_eq!(sorted(&document), [0, 1, 2], "without a set-up no depth is known");
    document.set_up.reads_depths = true;
    assert_eq!(sorted(&document), [2, 0, 1]);
    assert_eq!(quantity_text(Quantity::Depth, 0, &features[0], document.set_up.known(&features[0], None)), "8");
}

#[test]
fn pairs_are_listed_in_the_order_that_was_clicked_and_the_step_that_lost_most_is_said() {
    let mut table = PairTable::default();
    for (pair, putative, inliers) in [((0, 1), 30, 20), ((0, 2), 40, 0), ((1, 2), 30, 25)] {
        table.counts.insert(pair, MatchCounts { putative, inliers: Some(inliers), ..MatchCounts::default() });
    }
    let pairs = |table: &PairTable| table.listed().into_iter().map(|(p, _)| p).collect::<Vec<_>>();
    assert_eq!((pairs(&table), table.strongest()), (vec![(0, 1), (0, 2), (1, 2)], 25));
    table.sort_by(PairColumn::Inliers);
    assert_eq!(pairs(&table), [(1, 2), (0, 1), (0, 2)]);
    table.sort_by(PairColumn::Inliers);
    assert_eq!(pairs(&table), [(0, 2), (0, 1), (1, 2)]);
    table.sort_by(PairColumn::Putative);
    assert_eq!(pairs(&table), [(0, 2), (0, 1), (1, 2)], "equal ones stay in order");
    [PairColumn::Pair; 2].into_iter().for_each(|column| table.sort_by(column));
    assert_eq!(pairs(&table), [(1, 2), (0, 2), (0, 1)]);
    let of_burst = |strongest| table.of_burst(0, strongest).map(|(pair, _)| pair);
    assert_eq!([of_burst(true), of_burst(false)], [Some((0, 1)), Some((0, 2))]);
    assert_eq!(table.of_burst(3, true), None);
    let counts = MatchCounts { keypoints_a: 200, putative: 60, inliers: Some(12), ..MatchCounts::default() };
    let (text, lost) = lost_text(&counts, None);
    assert_eq!(text, "12 inliers of about 30 needed; 70 % of 200 keypoints lost: ratio test or mutual check");
    let known = MatchCounts { not_mutual: Some(20), ..counts };
    assert!(lost_text(&known, None).0.ends_with("60 % of 200 keypoints lost: ratio test"));
    let mut steps = Lost::ALL.map(|lost| (lost, 12));
    (steps[2].1, steps[3].1) = (18, 134);
    let exact = lost_text(&counts, Some(&steps));
    assert_eq!(exact.0, "12 inliers of about 30 needed; 67 % of 200 keypoints lost: mutual check");
    assert_eq!((lost, exact.1), (Lost::RatioTest, Lost::MutualCheck));
    let refused = MatchCounts { putative: 190, inliers: Some(0), refused: Some(Refusal::Motions), ..counts };
    assert!(lost_text(&refused, None).0.contains("refused: the motions"));
    assert!(lost_text(&refused, None).0.ends_with("geometry"));
}

#[test]
fn rows_and_columns_have_the_names_of_their_bursts_and_more_is_lighter() {
    let burst = |name: &str| burstscope::burst::BurstFiles { name: name.to_owned(), paths: Vec::new() };
    let dataset = Dataset::new(burstscope::requests::OpenDataset {
        strays: Vec::new(),
        source: burstscope::dataset::DatasetSource::of_bursts(Vec::new()),
        bursts: Arc::new(vec![burst("0"), burst("dusk")]),
        frames_of_one: None,
        folder: None,
        folder_error: None,
        params: Default::default(),
        open: Default::default(),
        finished: vec![None; 2],
        other_params: None,
    });
    let context = egui::Context::default();
    let screen = Rect::from_min_size(Pos2::ZERO, vec2(600.0, 500.0));
    let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
    let mut output =
        context.run_ui(input, |ui| assert_eq!(matrix_ui(ui, &dataset, &dataset.choice(), &mut Queue::default()), None));
    output.textures_delta.clear();
    let text = |shape: &egui::epaint::ClippedShape| match &shape.shape {
        egui::Shape::Text(text) => Some((text.galley.text().to_owned(), text.angle != 0.0)),
        _ => None,
    };
    let mut texts: Vec<(String, bool)> = output.shapes.iter().filter_map(text).collect();
    texts.sort();
    let both = |name: &str| [false, true].map(|upwards| (name.to_owned(), upwards));
    assert_eq!(texts, [both("0"), both("dusk")].concat());
    let colours = CountColours::new(400);
    let lightness = |c: Color32| 0.3 * f32::from(c.r()) + 0.59 * f32::from(c.g()) + 0.11 * f32::from(c.b());
    let mut before = -1.0;
    for count in [0, 1, 10, 50, 150, 300, 400] {
        let (fill, text) = colours.of(count);
        assert!(lightness(fill) > before, "{count}");
        before = lightness(fill);
        assert!((lightness(fill) - lightness(text)).abs() > 80.0, "{count}: {fill:?} {text:?}");
    }
    assert_eq!(CountColours::new(0).of(0).1, Color32::WHITE);
}
