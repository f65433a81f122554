//! The automatically saved session, and the offer after an unexpected end.

use crate::support::*;
use burstscope::app::{BurstscopeApp, EndRequest, gpu, offscreen::Offscreen, recovery::KeptIn, recovery::Record};
use std::time::SystemTime;

const OFFER: &str = "was not closed";

fn keeping(folder: &Path, start: Start) -> Start {
    let kept = Some(KeptIn { folder: folder.to_owned(), every: Duration::ZERO });
    Start { startup: Startup { kept, ..start.startup }, ..start }
}

fn sessions(folder: &Path) -> Vec<Session> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let texts = files.filter(|path| path.extension().is_some_and(|e| e == "toml"));
    texts.map(|path| Session::from_toml(&fs::read_to_string(path).unwrap()).unwrap()).collect()
}

fn end_in_the_ordinary_way(mut window: Window) {
    eframe::App::on_exit(window.app_mut());
}

#[test]
fn what_was_open_is_offered_after_a_crash_and_never_restored_unasked() {
    let (home, folder) = folder_with("running");
    let stack = noisy_stack(&home, 5, 96, 128);
    let mut window = keeping(&folder, Start::of(&stack)).open();
    assert!(!window.shows(OFFER));
    window.slide("Slope u", 1.25);
    let kept_slope = || {
        sessions(&folder).iter().any(|session| session.document.panes.of(Side::A).cursor.slope == Slope::new(1.25, 0.0))
    };
    window.wait("the session is kept", |_| kept_slope()).settle();
    let other = keeping(&folder, Start::nothing_open()).open();
    assert!(!other.shows(OFFER));
    end_in_the_ordinary_way(other);
    // The first window ends unexpectedly.
    drop(window);
    let mut next = keeping(&folder, Start::without_auto_detect()).open();
    assert!(next.shows(OFFER) && next.shows("noisy.npy"));
    assert_ne!(next.read().focused_size(), (128, 96), "not unasked");
    next.click("Restore").settle();
    assert!(!next.shows(OFFER));
    assert_eq!(next.read().focused_size(), (128, 96));
    assert_eq!(next.document().cursor().slope, Slope::new(1.25, 0.0));
    // The session now belongs to this window: a crash right after loses nothing.
    assert!(kept_slope());
    drop(next);
    let next = keeping(&folder, Start::nothing_open()).open();
    assert!(next.shows(OFFER));
    end_in_the_ordinary_way(next);
    let mut later = keeping(&folder, Start::nothing_open()).open();
    later.click("Later").settle();
    assert!(!later.shows(OFFER) && sessions(&folder).len() == 1);
    end_in_the_ordinary_way(later);
    let mut last = keeping(&folder, Start::nothing_open()).open();
    last.click("Discard…").settle();
    assert!(last.shows(OFFER) && last.shows("Delete the saved session?"), "nothing is deleted unasked");
    last.click("Delete");
    assert!(!last.shows(OFFER));
    end_in_the_ordinary_way(last);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "nothing is left");
    assert!(stack.is_file());
}

#[test]
fn an_offer_that_cannot_be_restored_stays_and_where_nothing_can_be_kept_that_is_said() {
    let (_home, folder) = folder_with("running");
    let record = Record::new(&folder).unwrap();
    record.write("version = 4\nburst = { paths = [\"/nowhere/frames\"] }\n").unwrap();
    drop(record);
    let mut window = keeping(&folder, Start::nothing_open()).open();
    window.click("Restore").wait_for_error();
    assert!(window.shows("/nowhere/frames") && window.shows(OFFER));
    assert_eq!(sessions(&folder).len(), 1);
    let (_home, file) = folder_with("file");
    fs::write(&file, "").unwrap();
    assert!(keeping(&file.join("running"), Start::nothing_open()).open().shows("Save the session by itself"));
}

#[test]
fn the_offer_looks_like_this() {
    let home = folder();
    for (name, minutes) in [("lanterns", 90), ("harbour", 150)] {
        let record = Record::new(&home).unwrap();
        record.write(&format!("version = 4\nburst = {{ paths = [\"/data/{name}\"] }}\n")).unwrap();
        let then = SystemTime::now() - Duration::from_secs(60 * minutes + 20);
        fs::File::options().write(true).open(&record.session).unwrap().set_modified(then).unwrap();
    }
    let mut window = keeping(&home, Start::nothing_open()).open();
    window.harness.get_by_role_and_label(Role::Button, "Restore");
    window.snapshot("flat/recovery_offer");
}

#[test]
fn a_window_whose_device_is_lost_closes_to_go_on_and_is_kept() {
    let home = folder();
    let mut start = keeping(&home, Start::without_auto_detect());
    // No automatic saving in this test.
    start.startup.kept.as_mut().unwrap().every = Duration::from_secs(3600);
    let mut device = None;
    let builder = crate::harness::builder(start.size).wgpu_setup(crate::harness::wgpu_setup());
    let harness = builder.build_eframe(|cc| {
        device = cc.wgpu_render_state.as_ref().map(|state| state.device.clone());
        BurstscopeApp::new(&cc.egui_ctx, cc.wgpu_render_state.as_ref(), start.startup)
    });
    let mut window = Window { harness, dialogs: Default::default() };
    window.settle().slide("Slope u", -1.5);
    let commands = |window: &Window| window.harness.output().viewport_output[&egui::ViewportId::ROOT].commands.clone();
    assert!(!commands(&window).contains(&egui::ViewportCommand::Close));
    let device = device.unwrap();
    device.destroy();
    device.poll(wgpu::PollType::Poll).unwrap();
    window.harness.step();
    assert!(commands(&window).contains(&egui::ViewportCommand::Close));
    assert!(
        sessions(&home).iter().any(|session| session.document.panes.of(Side::A).cursor.slope == Slope::new(-1.5, 0.0))
    );
    // The drawing ends; if no other device is found, the session is offered at the next start.
    end_in_the_ordinary_way(window);
    assert!(keeping(&home, Start::nothing_open()).open().shows(OFFER));
}

#[test]
fn a_window_that_is_asked_to_end_from_outside_finishes_its_files_and_keeps_its_session() {
    let (home, folder) = folder_with("running");
    let end = EndRequest::default();
    let mut start = keeping(&folder, Start::without_auto_detect());
    // No automatic saving in this test.
    start.startup.kept.as_mut().unwrap().every = Duration::from_secs(3600);
    start.startup.end = end.clone();
    let mut window = start.open();
    window.slide("Slope u", -1.5);
    let commands = |window: &Window| window.harness.output().viewport_output[&egui::ViewportId::ROOT].commands.clone();
    assert!(!commands(&window).contains(&egui::ViewportCommand::Close));
    let file = home.join("params.toml");
    window.will_choose(&file).run_action("save parameters").wait("the file is chosen", |app| !app.is_asking());
    std::thread::scope(|scope| {
        scope.spawn(|| end.make());
    });
    window.harness.step();
    assert!(commands(&window).contains(&egui::ViewportCommand::Close));
    let is_kept = || {
        sessions(&folder).iter().any(|session| session.document.panes.of(Side::A).cursor.slope == Slope::new(-1.5, 0.0))
    };
    assert!(is_kept());
    // The window closes in the ordinary way; but no user closed it.
    end_in_the_ordinary_way(window);
    assert!(is_kept() && file.is_file());
    assert!(keeping(&folder, Start::nothing_open()).open().shows(OFFER));
}

#[cfg(unix)]
#[test]
fn a_session_that_could_not_be_written_is_written_later() {
    let home = folder();
    let (folder, aside) = (home.join("running"), home.join("aside"));
    let mut window = keeping(&folder, Start::without_auto_detect()).open();
    window.wait("the session is kept", |_| !sessions(&folder).is_empty()).settle();
    // A file in the place of the folder: nothing can be written there.
    fs::rename(&folder, &aside).unwrap();
    fs::write(&folder, "").unwrap();
    window.slide("Slope u", 0.75).wait("that is said", |app| !app.model.shell.messages.errors.is_empty());
    assert!(window.shows("Save the session by itself"));
    fs::remove_file(&folder).unwrap();
    // The next attempt may have made a new folder just now.
    while fs::rename(&aside, &folder).is_err() {
        let _ = fs::remove_dir_all(&folder);
    }
    let is_kept = |_: &BurstscopeApp| {
        sessions(&folder).iter().any(|session| session.document.panes.of(Side::A).cursor.slope == Slope::new(0.75, 0.0))
    };
    window.wait("it is written though nothing has changed since", is_kept);
    window.wait("the message goes", |app| app.model.shell.messages.errors.is_empty());
    end_in_the_ordinary_way(window);
}

#[test]
fn the_window_is_the_same_on_a_new_device() {
    let mut offscreen = Offscreen::new(vec2(1000.0, 640.0), 1.0, gpu::AdapterChoice::Software).unwrap();
    let startup = Start::without_auto_detect().startup;
    let mut app = BurstscopeApp::new(&offscreen.context, None, startup);
    let mut settled = 0;
    while settled < 5 {
        offscreen.frame(Vec::new(), |ui| app.show(ui));
        settled = if app.is_settled() && app.model.results.slots.a.burst.is_some() { settled + 1 } else { 0 };
        std::thread::sleep(Duration::from_millis(2));
    }
    let before = offscreen.image().unwrap();
    offscreen.render_state.device.destroy();
    assert_eq!(offscreen.image().unwrap(), before);
    offscreen.frame(Vec::new(), |ui| app.show(ui));
    assert_eq!(offscreen.image().unwrap(), before);
}
