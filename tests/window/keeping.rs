//! Saving and loading parameters and sessions, exporting, settings.

use crate::{flat, support::*};
use burstscope::app::{canvas::View, settings::MAX_RECENT, settings::STORAGE_KEY};
use eframe::Storage;

#[test]
fn parameters_are_saved_and_loaded_and_a_parameter_file_with_a_mistake_is_named_and_changes_nothing() {
    let (_folder, file) = folder_with("params.toml");
    let mut window = Start::without_auto_detect().open();
    window.change(|document| document.params.peak_threshold = 0.0125).will_choose(&file);
    window.run_action("save parameters").settle();
    let saved = DetectorParams::from_toml(&fs::read_to_string(&file).unwrap()).unwrap();
    assert_eq!(saved.peak_threshold, 0.0125);
    window.click("Reset all");
    assert_eq!(window.document().params, DetectorParams::default());
    window.will_choose(&file).run_action("load parameters").settle();
    assert_eq!(window.document().params, saved);
    let (_folder, file) = folder_with("wrong.toml");
    fs::write(&file, "peak_treshold = 0.1\n").unwrap();
    let mut window = Start::without_auto_detect().open();
    let before = window.document().params.clone();
    window.will_choose(&file).run_action("load parameters").wait_for_error();
    assert!(window.shows("peak_treshold") && window.shows("wrong.toml"));
    assert_eq!(window.document().params, before);
}

#[test]
fn a_session_brings_everything_back() {
    let folder = folder();
    let stack = noisy_stack(&folder, 7, 96, 128);
    let file = folder.join("night.burstscope.toml");
    let mut window = Start::of(&stack).open();
    window.click("Detect").settle();
    let features = window.read().features().to_vec();
    assert!(features.len() >= 2, "{features:?}");
    window.slide("Slope u", 1.25).change(|document| document.selected = Some(1)).run_action("zoom in");
    window.run_action("motion vectors").settle();
    let (view, scrub) = (window.document().focused().view, *window.document().cursor());
    let other = window.kept_and_opened_in_another(&file);
    assert_eq!(other.read().focused_size(), (128, 96));
    assert_eq!(*other.document().cursor(), scrub);
    assert_eq!(other.document().cursor().slope, Slope::new(1.25, 0.0));
    assert_eq!(other.read().features(), features, "the same burst and parameters give the same bits");
    assert_eq!(other.document().selected, Some(1));
    assert!(!other.document().look.motion_vectors);
    assert_eq!(other.document().focused().view, view, "also beside the panel of the selection");
}

#[test]
fn a_session_keeps_the_panes_and_a_start_with_its_file_opens_it() {
    let (_folder, file) = folder_with("panes.burstscope.toml");
    let mut window = Start::without_auto_detect().open();
    window.run_action("later demo burst as b").settle().click("One burst").key(Key::Num9).key(Key::S);
    window.set().focused_mut().side = Side::B;
    window.settle().click("Link view of pane 1").will_choose(&file).run_action("save session").settle();
    let startup = Startup { source: None, session: Some(file), ..Start::without_auto_detect().startup };
    let mut other = Start { startup, ..Start::default() }.open();
    other.settle();
    let saved = |window: &Window| {
        let mut panes = window.document().panes.clone();
        // The centre of a fitted view is computed anew.
        panes.iter_mut().for_each(|(_, pane)| pane.view = View::default());
        panes
    };
    assert_eq!(saved(&other), saved(&window));
    let sides: Vec<Side> =
        other.document().panes.shown().iter().map(|id| other.document().panes.get(*id).unwrap().side).collect();
    assert_eq!(sides.iter().filter(|side| **side == Side::B).count(), 1);
    assert!(other.read().pictures_are_current() && other.read().burst_of(Side::B).is_some());
}

#[test]
fn sessions_without_panes_begin_as_bursts_do_and_one_of_a_newer_version_says_so() {
    let (_folder, file) = folder_with("handed_over.burstscope.toml");
    let mut window = Start::default().open();
    window.settle();
    let pane = |window: &Window| window.document().focused().clone();
    let opened = pane(&window);
    let truth = "[document.comparisons.a]\nwith = \"truth\"\n[document.look]\noverlay = \"this_slope\"\n";
    let text = format!("version = 4\nburst = \"demo\"\ndetected = true\n{truth}");
    fs::write(&file, text).unwrap();
    window.will_choose(&file).run_action("open session").settle();
    assert!(window.errors().is_empty(), "{:?}", window.errors());
    let cursor = pane(&window).cursor;
    assert_eq!((cursor.frame, opened.cursor.frame), (5, 5));
    assert_ne!(cursor.slope, Slope::default(), "that with most features");
    // Of the comparison it shows what is at the slope of the picture, and how many that are.
    let is_part = |text: &str| text.starts_with("Found ") && text.contains(" of ");
    let by = egui_kittest::kittest::by().predicate(move |node| node.value().is_some_and(|text| is_part(&text)));
    assert!(window.harness.query_all(by).next().is_some());
    let (_folder, file) = folder_with("new.burstscope.toml");
    fs::write(&file, "version = 77\nburst = \"demo\"\nsomething_new = true\n").unwrap();
    let mut window = Start::without_auto_detect().open();
    window.will_choose(&file).run_action("open session").wait_for_error();
    assert!(window.shows("version 77") && window.shows("open it with a newer Burstscope"));
}

#[test]
fn a_session_whose_burst_is_gone_says_so_and_keeps_what_is_open() {
    let folder = folder();
    let stack = noisy_stack(&folder, 3, 48, 48);
    let file = folder.join("night.burstscope.toml");
    let mut window = Start::of(&stack).open();
    window.will_choose(&file).run_action("save session").settle();
    fs::remove_file(&stack).unwrap();
    let mut other = Start::without_auto_detect().open();
    let before = (other.opened().id, other.document().params.clone());
    other.will_choose(&file).run_action("open session").wait_for_error();
    assert!(other.shows("noisy.npy"));
    assert_eq!((other.opened().id, other.document().params.clone()), before);
}

#[cfg(feature = "raw")]
fn harmful_files() -> [(&'static str, Vec<u8>); 3] {
    let png = crate::crafted::packed_chunks_png(1 << 16);
    [
        ("b.dng", crate::crafted::huge_count_dng(5)),
        ("b.raf", crate::crafted::huge_count_raf()),
        ("b.png", png[..png.len() / 2].to_vec()),
    ]
}

#[cfg(feature = "raw")]
#[test]
fn a_session_that_names_a_harmful_file_loses_that_burst_alone() {
    let folder = folder();
    let (dng, file) = (folder.join("a.dng"), folder.join("night.burstscope.toml"));
    fs::write(&dng, crate::dng::Dng::new((96, 80), |u, v| (64 + (u * 37 + v * 91) % 400) as u16).bytes()).unwrap();
    let mut window = Start::of(&dng).open();
    assert_eq!(window.read().focused_size(), (48, 40));
    window.run_action("later demo burst as b").settle();
    window.change(|document| document.params.peak_threshold = 0.0125).will_choose(&file);
    window.run_action("save session").settle();
    let session = fs::read_to_string(&file).unwrap();
    for (name, bytes) in harmful_files() {
        fs::write(folder.join(name), bytes).unwrap();
        assert!(session.contains("a.dng"));
        fs::write(&file, session.replace("a.dng", name)).unwrap();
        let mut other = Start::without_auto_detect().open();
        let before = other.opened().id;
        other.will_choose(&file).run_action("open session").wait_for_error().settle();
        assert!(other.shows(name), "{name} is not named");
        assert_eq!(other.opened().id, before, "what was open stays");
        assert_eq!(other.document().params.peak_threshold, 0.0125, "the rest of the session is there");
        assert!(other.read().burst_of(Side::B).is_some());
    }
}

#[test]
fn features_pictures_and_figures_are_exported_and_a_file_that_cannot_be_written_is_named() {
    let folder = folder();
    let mut window = Start::default().open();
    window.set().look.overlay = FeaturesShown::All;
    window.set().figure.features = burstscope::export::FigureAmount::All;
    let count = window.read().features().len();
    let exports = [
        ("features as csv", "f.csv"),
        ("features for colmap", "f.txt"),
        ("features as npz", "f.npz"),
        ("32-bit tiff", "p.tiff"),
        ("picture as png", "p.png"),
        ("figure as before", "p.svg"),
    ];
    for (action, name) in exports {
        window.will_choose(folder.join(name)).run_action(action).settle();
        assert!(window.shows(&format!("Wrote {}", folder.join(name).display())), "{action}");
    }
    assert_eq!(fs::read_to_string(folder.join("f.csv")).unwrap().lines().count(), count + 1);
    assert!(fs::read_to_string(folder.join("f.txt")).unwrap().starts_with(&format!("{count} 128\n")));
    let tiff = Burst::open(folder.join("p.tiff")).unwrap();
    assert_eq!(tiff.frames[0].data(), window.read().picture().unwrap().plane.data());
    assert_eq!(Burst::open(folder.join("p.png")).unwrap().size(), (480, 360));
    let svg = fs::read_to_string(folder.join("p.svg")).unwrap();
    assert_eq!(svg.matches("<circle").count(), count, "a circle for each feature");
    assert!(svg.contains("px/frame") && svg.contains("of full scale") && svg.contains("50 px"));
    window.will_choose(&*folder).run_action("features as csv").wait_for_error();
    assert!(window.shows(&folder.display().to_string()));
}

#[test]
fn figures_show_what_the_panes_show() {
    let folder = folder();
    let (svg, png) = (folder.join("f.svg"), folder.join("f.png"));
    let mut window = Start { size: [1280.0, 800.0], ..Start::default() }.open();
    window.key(Key::Num6).click_on(Role::CheckBox, "At this slope").settle();
    let listed = window.results().listed.len();
    assert!(listed > 0 && listed < window.read().features().len());
    window.run_action("zoom in").run_action("zoom in").settle().run_action("export figure…").click("Pixels").steps(2);
    window.slide("Width", 3.0);
    window.click_on(Role::CheckBox, "Colour bar").steps(2).will_choose(&svg).click("Export…").settle();
    let text = fs::read_to_string(&svg).unwrap();
    assert_eq!(text.matches("<image").count(), 2);
    let all = text.matches("<circle").count();
    assert!(0 < all && all < 2 * listed, "{all} are drawn in full of twice {listed}");
    assert!(text.contains("(a) Frame 5") && text.contains("(b) Motion stack") && !text.contains("of full scale"));
    window.will_choose(&png).run_action("figure as before").settle();
    window.set().figure.features = burstscope::export::FigureAmount::All;
    let of_all = folder.join("all.svg");
    window.will_choose(&of_all).run_action("figure as before").settle();
    let text = fs::read_to_string(&of_all).unwrap();
    assert_eq!(text.matches("<circle").count(), 2 * listed, "the filter holds in both pictures");
    let image = image::open(&png).unwrap().to_rgb8();
    let seen = window.app().widgets.get(window.document().focus()).unwrap().picture.visible_image.unwrap();
    // Two pictures of the visible part, three pixels for each of its pixels, and their margins.
    let wide = 2.0 * 3.0 * seen.width();
    assert!((wide..wide + 60.0).contains(&(image.width() as f32)), "{} {wide}", image.width());
    let coloured = image.pixels().filter(|p| p.0.iter().max().unwrap() - p.0.iter().min().unwrap() > 60).count();
    assert!(coloured > 500, "{coloured} pixels of features");
}

/// The preview in the form of a figure; its label says what is drawn.
fn previewed(window: &mut Window) -> RgbaImage {
    window.settle();
    let made = window.results().preview.made.as_ref().expect("a preview").1.clone();
    let shown = window.rect(Role::Image, &made.words);
    assert!(window.harness.ctx.content_rect().contains_rect(shown), "{shown:?} is in the window");
    let size = Vec2::from([made.image.width(), made.image.height()].map(|side| side as f32));
    assert!((shown.size() - size * (400.0 / size.max_elem()).min(1.0)).length() < 1.0, "{shown:?} of {size:?}");
    made.image.clone()
}

#[test]
fn the_form_of_a_figure_shows_what_it_would_write() {
    let (_folder, png) = folder_with("f.png");
    let mut window = flat::with_features(flat::open([960.0, 640.0]));
    window.run_action("export figure…");
    let on_paper = previewed(&mut window);
    assert!(window.shows("Preview of 1 picture on 181 × "));
    assert_eq!(on_paper.width().max(on_paper.height()), 800, "enough for a sharp screen");
    window.click("PNG").click("Pixels").steps(2).slide("Width", 0.5).steps(2);
    let with_legend = previewed(&mut window);
    assert!(!window.shows(" mm. ") && window.shows(" px. ") && with_legend != on_paper);
    window.click_on(Role::CheckBox, "Legend of features").steps(2);
    let without = previewed(&mut window);
    assert!(without.height() < with_legend.height(), "the legend is gone");
    window.will_choose(&png).click("Export…").settle();
    assert!(image::open(&png).unwrap().to_rgba8() == without, "each pixel of the file");
    assert!(window.results().preview.made.is_none(), "nothing is drawn without the form");
    // Why nothing could be written is said in the place of the preview.
    window.key(Key::Num6).settle().run_action("export figure…");
    assert!(previewed(&mut window).width() > without.width(), "two pictures");
    window.slide("Width", 32.0).steps(2).settle();
    assert!(window.shows("choose a smaller scale") && !window.shows("Preview of"));
    window.click("PDF");
    assert!(previewed(&mut window).width() <= 800, "vectors have any size");
}

#[test]
fn theme_and_recent_bursts_are_remembered_and_typing_gives_a_file_another_name() {
    let folder = folder();
    let mut window = Start::of(&noisy_stack(&folder, 3, 48, 48)).open();
    window.run_action("light theme").settle();
    let mut memory = Memory::default();
    eframe::App::save(window.app_mut(), &mut memory);
    let settings = Settings::load(&memory);
    assert_eq!(settings.theme, egui::ThemePreference::Light);
    assert_eq!(settings.recent.len(), 1);
    assert!(!settings.auto_detect);
    let mut window = Start::default().open();
    // The system shows no dialog, so the field opens with a name whose first part is selected.
    window.run_action("export features as csv");
    window.wait("the field opens", |app| !app.choice().is_empty() || app.is_settled()).steps(3);
    let wanted = folder.join("new").join("mine");
    window.harness.get_by_role_and_label(Role::TextInput, "Path").type_text(wanted.to_str().unwrap());
    window.steps(3);
    assert!(window.shows(&format!("The folder {} will be made", wanted.parent().unwrap().display())));
    window.key(Key::Enter).settle();
    assert!(wanted.with_extension("csv").is_file(), "the kind of file stays");
}

#[test]
fn a_typed_name_of_a_file_that_is_there_is_asked_about() {
    let (folder, file) = folder_with("params.toml");
    let mut window = Start::without_auto_detect().open();
    let type_name = |window: &mut Window, file: &Path| {
        // The system shows no dialog, so the field opens.
        window.run_action("save parameters").wait("the field opens", |app| app.is_settled()).steps(3);
        let field = window.harness.get_by_role_and_label(Role::TextInput, "Path");
        field.type_text(file.with_extension("").to_str().unwrap());
        window.steps(3).key(Key::Enter).steps(3);
    };
    let text = || fs::read_to_string(&file).unwrap();
    type_name(&mut window, &file);
    window.settle();
    assert!(text().starts_with("# Written by Burstscope"), "nothing was there, so nothing is asked");
    fs::write(&file, "precious").unwrap();
    type_name(&mut window, &file);
    assert!(window.shows("Replace this file?") && window.shows("Burstscope did not write it"));
    window.click("Cancel").settle();
    assert!(!window.shows("Replace this file?") && text() == "precious");
    type_name(&mut window, &file);
    window.click("Replace").settle();
    assert!(text().starts_with("# Written by Burstscope"));
    type_name(&mut window, &file);
    assert!(window.shows("Burstscope wrote it"));
    window.key(Key::Escape).steps(3);
    assert!(!window.shows("Replace this file?"));

    #[cfg(unix)]
    {
        let thesis = folder.join("thesis.txt");
        fs::write(&thesis, "precious").unwrap();
        fs::remove_file(&file).unwrap();
        std::os::unix::fs::symlink(&thesis, &file).unwrap();
        type_name(&mut window, &file);
        assert!(window.shows("It is a link"));
        window.click("Replace").settle();
        assert_eq!(fs::read_to_string(&thesis).unwrap(), "precious");
        assert!(!fs::symlink_metadata(&file).unwrap().is_symlink() && text().contains("Burstscope"));
    }
}

#[test]
fn what_is_open_is_never_written_over() {
    let folder = folder();
    let stack = noisy_stack(&folder, 3, 48, 48);
    let gold = folder.join("bias.npy");
    fs::copy(&stack, &gold).unwrap();
    let mut start = Start::of(&stack);
    start.startup.calibration.bias = Some(gold.clone());
    let mut window = start.open();
    for file in [&stack, &gold] {
        let before = fs::read(file).unwrap();
        // The system's dialog has asked whether the file may be replaced, and the user agreed.
        window.will_choose(file).run_action("picture as png").wait_for_error();
        assert!(window.shows("files that were opened are never written to"));
        assert!(fs::read(file).unwrap() == before);
        let id = window.errors()[0].id;
        window.app_mut().model.shell.messages.dismiss(id);
    }
    let png = folder.join("p.png");
    window.will_choose(&png).run_action("picture as png").settle();
    assert!(burstscope::export::is_ours(&png));
}

#[test]
fn settings_come_back_rubbish_gives_defaults_and_recent_bursts_are_listed_once() {
    let mut memory = Memory::default();
    let mut settings = Settings { auto_detect: false, ..Settings::default() };
    settings.remember(&BurstSource::Paths(vec!["/a".into()]));
    settings.store(&mut memory);
    assert_eq!(Settings::load(&memory), settings);
    memory.set_string(STORAGE_KEY, "[[[".to_owned());
    assert_eq!(Settings::load(&memory), Settings::default());
    let source = |i: usize| BurstSource::Paths(vec![format!("/burst{i}").into()]);
    let mut settings = Settings::default();
    (0..20).for_each(|i| settings.remember(&source(i)));
    settings.remember(&source(15));
    settings.remember(&BurstSource::Demo);
    assert_eq!(settings.recent.len(), MAX_RECENT);
    assert_eq!((&settings.recent[0], &settings.recent[1]), (&source(15), &source(19)));
}
