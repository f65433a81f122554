//! Opening bursts, and failures of it.

use crate::support::*;

#[test]
fn the_demo_opens_at_the_slope_that_reveals_most_and_the_first_page_leads_on() {
    let window = Start::default().open();
    assert_eq!(window.read().frame_count(), 10);
    assert!(window.read().features().len() > 5, "{}", window.read().features().len());
    let shown = window.document().cursor().slope;
    assert!(shown.magnitude() > 0.5, "the slope with the most features is shown: {shown:?}");
    assert!(window.shows("features in") && window.shows("10 frames"));
    let mut window = Start::nothing_open().open();
    assert!(window.results().slots.a.burst.is_none());
    assert!(window.shows("or drop a folder"));
    window.click("Open demo burst").settle();
    assert_eq!(window.read().frame_count(), 10);
}

#[test]
fn a_stack_is_opened_with_the_dialog_and_is_then_a_recent_one_or_dropped() {
    let folder = folder();
    let path = noisy_stack(&folder, 4, 48, 64);
    let mut window = Start::without_auto_detect().open();
    window.will_choose(&path).click("Open…").settle();
    assert_eq!((window.read().frame_count(), window.read().focused_size()), (4, (64, 48)));
    assert_eq!(window.app().settings.recent, [BurstSource::Paths(vec![path])]);
    window.drop_file(noisy_stack(&folder, 5, 40, 40)).settle();
    assert_eq!(window.read().frame_count(), 5);
}

#[test]
fn a_broken_file_is_named_and_the_burst_that_was_open_stays() {
    let (_folder, path) = folder_with("broken-frame.png");
    fs::write(&path, "this is no picture").unwrap();
    let mut window = Start::without_auto_detect().open();
    let before = window.opened().id;
    let plane = window.read().picture().cloned().unwrap().plane;
    window.will_choose(&path).click("Open…").wait_for_error();
    assert!(window.shows("broken-frame.png"));
    assert_eq!(window.opened().id, before);
    assert_eq!(window.read().picture().unwrap().plane, plane);
    window.click("Dismiss: Open");
    assert!(!window.shows("broken-frame.png"));
}

#[test]
fn where_the_system_has_no_dialog_a_path_can_be_typed() {
    let folder = folder();
    let path = noisy_stack(&folder, 3, 40, 40);
    let mut window = Start::without_auto_detect().open();
    window.click("Open…").wait("the dialog's answer", |app| app.is_settled());
    assert!(window.shows("This system shows no file dialog"));
    type_path(&mut window, &path.display().to_string());
    window.settle();
    assert_eq!(window.read().frame_count(), 3);
    // So can the name of a built-in burst, as on the command line.
    window.click("Open…").wait("the dialog's answer", |app| app.is_settled());
    type_path(&mut window, "demo-later");
    assert_eq!(window.settle().opened().source, BurstSource::DemoLater);
}

#[test]
fn a_dialog_that_ends_without_an_answer_is_said_and_the_path_can_be_typed() {
    let folder = folder();
    let mut window = Start::without_auto_detect().open();
    window.dialogs.will_end();
    window.run_action("Save parameters…").wait("the dialog's answer", |app| app.is_settled());
    assert!(window.shows("Save parameters: the dialog ended without a file"));
    assert!(!window.shows("This system shows no file dialog"));
    window.click("Type the path…");
    // The field has the suggested name, which the path replaces.
    window.harness.get_by_role_and_label(Role::TextInput, "Path").focus();
    window.steps(1);
    window.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.steps(1);
    let path = folder.join("typed.toml");
    type_path(&mut window, &path.display().to_string());
    window.settle();
    assert!(path.is_file(), "the parameters are in the file");
    assert!(!window.shows("Type the path…"), "the note is another one");
}

#[test]
fn what_was_taken_is_a_note_and_what_may_be_wrong_a_warning() {
    let folder = folder();
    let picture = |t: u8| image::RgbImage::from_fn(64, 48, |u, v| image::Rgb([(u * 3) as u8, (v * 4) as u8, 40 * t]));
    (0..3).for_each(|t| picture(t).save(folder.join(format!("{t}.jpg"))).unwrap());
    let mut window = Start::without_auto_detect().open();
    window.drop_file(folder.to_owned()).settle();
    let burst = window.opened().burst.clone();
    let notes: Vec<String> = burst.notes().iter().map(|note| note.for_window()).collect();
    assert!(notes.len() > burst.taken.len(), "pictures of screens are no measurements");
    let words = if notes.len() == 1 { "1 warning".to_owned() } else { format!("{} warnings", notes.len()) };
    window.click(&words).settle();
    notes.iter().for_each(|note| assert!(window.shows(note), "not only the last one: {note}"));
    // The axes of an array are only taken for something.
    let array = ndarray::Array4::from_shape_fn((5, 5, 40, 48), |(j, i, v, u)| ((i + 2 * j + u * v) % 17) as f32 / 17.0);
    let views = folder.join("views.npy");
    ndarray_npy::write_npy(&views, &array).unwrap();
    window.drop_file(views).settle();
    assert!(window.shows("1 note") && !window.shows("warning"));
}

pub fn type_path(window: &mut Window, text: &str) {
    let field = window.harness.get_by_role_and_label(Role::TextInput, "Path");
    field.focus();
    field.type_text(text);
    window.steps(2).key(Key::Enter);
}

#[test]
fn the_failures_to_look_at_open_from_the_help_menu_and_are_kept_in_sessions() {
    for example in Example::ALL {
        let mut window = Start::without_auto_detect().open();
        window.run_action(example.label()).settle();
        let source = BurstSource::Example(example);
        assert_eq!(window.opened().source, source);
        let frames = if example == Example::Views { 25 } else { burstscope::synth::examples::EXAMPLE_FRAMES };
        assert_eq!(window.read().frame_count(), frames);
        assert!(window.shows(example.name()), "the status line names it");
        let text = toml::to_string(&std::collections::BTreeMap::from([("source", &source)])).expect("TOML");
        let read: std::collections::BTreeMap<String, BurstSource> = toml::from_str(&text).expect("the same");
        assert_eq!(read["source"], source);
    }
}

#[test]
fn a_file_without_header_is_opened_in_the_shape_that_is_chosen_from_pictures() {
    let folder = folder();
    let frames: Array3<f32> = ndarray_npy::read_npy(noisy_stack(&folder, 20, 240, 320)).unwrap();
    let path = folder.join("night.bin");
    let bytes: Vec<u8> = frames.iter().flat_map(|x| ((9000.0 * (x + 0.1)) as u16).to_le_bytes()).collect();
    fs::write(&path, bytes).unwrap();
    let mut window = Start::without_auto_detect().open();
    window.will_choose(&path).click("Open…").wait("the question", |app| app.asks_for_shape()).steps(3);
    let shape = |window: &Window, name: &str| window.has(Role::RadioButton, name);
    assert!(window.shows("Shape of a file without header"), "no error, but a question");
    assert!(shape(&window, "320x240:u16le, 20 frames") && shape(&window, "320x240:u8, 40 frames"));
    window.snapshot("shape_of_a_dump");
    let field = |window: &Window| window.rect(Role::TextInput, "Shape").center();
    window.click_on(Role::RadioButton, "320x240:u8, 40 frames").steps(3);
    window.click_at(field(&window)).type_into("Shape", ":").steps(3);
    assert!(window.shows("is not WIDTHxHEIGHT:TYPE"));
    window.click_on(Role::RadioButton, "320x240:u16le, 20 frames").steps(3).click("Open").settle();
    assert_eq!((window.read().frame_count(), window.read().focused_size()), (20, (320, 240)));
    assert_eq!(window.document().calibration.raw.map(|raw| raw.to_string()).as_deref(), Some("320x240:u16le"));
    assert!(window.errors().is_empty());
}

#[test]
fn the_shape_that_is_typed_is_previewed_and_one_that_does_not_fit_says_which_would() {
    let folder = folder();
    let frames: Array3<f32> = ndarray_npy::read_npy(noisy_stack(&folder, 20, 240, 320)).unwrap();
    let path = folder.join("night.bin");
    let values = frames.iter().flat_map(|x| ((9000.0 * (x + 0.1)) as u16).to_le_bytes());
    fs::write(&path, [7; 5].into_iter().chain(values).collect::<Vec<u8>>()).unwrap();
    let mut window = Start::without_auto_detect().open();
    window.will_choose(&path).click("Open…").wait("the question", |app| app.asks_for_shape()).steps(3);
    assert!(window.shows("No usual size fills this file"), "it has a header of five bytes");
    let field = |window: &Window| window.rect(Role::TextInput, "Shape").center();
    window.click_at(field(&window)).type_into("Shape", "320x240:u16le").settle();
    assert!(window.shows("no whole number of frames of 320x240:u16le"));
    assert!(window.shows("320x240:u16le+5 (20 frames)"), "behind the header it fits");
    window.type_into("Shape", "+5").settle();
    assert!(!window.shows("no whole number"));
    assert!(window.has(Role::Image, "First frame in 320x240:u16le+5, 20 frames"));
    window.click("Open").settle();
    assert_eq!((window.read().frame_count(), window.read().focused_size()), (20, (320, 240)));
    assert!(window.results().shape.asked.is_none(), "nothing is read for a form that is closed");
    let burst = &window.opened().burst;
    assert!(burst.notes().iter().any(|note| note.text.contains("no black level")), "{:?}", burst.notes());
}

#[test]
fn tab_completes_a_path_and_arrows_choose_among_names_and_paths_of_before() {
    let folder = folder();
    ["night-one", "night-two"].into_iter().for_each(|name| fs::create_dir(folder.join(name)).unwrap());
    let path = noisy_stack(&folder.join("night-two"), 3, 40, 40);
    let mut window = Start::without_auto_detect().open();
    let begin = |window: &mut Window| {
        window.harness.key_press_modifiers(Modifiers::COMMAND, Key::L);
        window.steps(3);
    };
    let write = |window: &mut Window, text: &str| {
        window.type_into("Path", text).settle();
    };
    begin(&mut window);
    write(&mut window, &format!("{}/ni", folder.display()));
    assert!(window.shows("night-one/") && window.shows("night-two/"), "what begins so is offered");
    // To where the two names part, and then to the second.
    window.key(Key::Tab);
    write(&mut window, "t");
    assert!(!window.shows("night-one/") && window.shows("night-two/"));
    window.key(Key::Backspace).settle().key(Key::ArrowDown).key(Key::Enter);
    assert!(window.shows("Open a path"), "the name is chosen, and nothing is opened yet");
    window.settle().key(Key::Tab).key(Key::Enter).settle();
    assert_eq!(window.app().settings.recent, [BurstSource::Paths(vec![path.clone()])]);
    begin(&mut window);
    write(&mut window, "demo-al");
    window.key(Key::Tab).key(Key::Enter).settle();
    let source = |window: &Window| window.results().slots.a.burst.as_ref().map(|open| open.source.clone());
    assert_eq!(source(&window), BurstSource::named("demo-aliasing"));
    begin(&mut window);
    window.key(Key::ArrowDown).key(Key::Enter).key(Key::Enter).settle();
    assert_eq!(source(&window), Some(BurstSource::Paths(vec![path])));
}
