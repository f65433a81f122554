//! Contents that a small window still shows.

use crate::support::{Start, Window};
use burstscope::app::project::pair::Side;
use burstscope::requests::BurstSource;
use egui::accesskit::Role;
use egui::{Key, Rect};
use egui_kittest::kittest::{NodeT, Queryable};

fn rect_of(window: &Window, role: Role, label: &str) -> Rect {
    window.harness.get_by_role_and_label(role, label).rect()
}

#[test]
fn at_1024_by_700_the_picture_and_the_columns_that_matter_are_seen() {
    let mut window = Start { size: [1024.0, 700.0], ..Start::default() }.open();
    window.key(Key::Home);
    window.settle();
    window.snapshot("small_window");
    // The panel on the right ends where the table does.
    let right = rect_of(&window, Role::Button, "Why?").left();
    for heading in ["#", "u", "v", "σ", "Slope u", "Slope v", "SNR"] {
        let rect = rect_of(&window, Role::Button, &format!("Sort by {heading}"));
        assert!(rect.right() < right && rect.bottom() < 700.0, "{heading}: {rect:?}, but {right}");
    }
    let visible = window.app().widgets.get(window.app().model.focus()).and_then(|w| w.picture.visible_image).unwrap();
    let (width, height) = window.app().model.size();
    assert!(visible.width() >= width as f32 && visible.height() >= height as f32, "the whole picture: {visible:?}");
}

#[test]
fn the_numbers_of_two_bursts_fit_at_960_points() {
    let mut start = Start { size: [960.0, 640.0], ..Start::default() };
    start.startup.second = Some(BurstSource::DemoLater);
    let mut window = start.open();
    assert!(window.app().model.found_of(Side::B).is_some());
    window.snapshot("two_bursts_narrow");
    // Between the two panels on the sides.
    let left = rect_of(&window, Role::Slider, "Slope v").right();
    let right = window.harness.get_by_label("Selected match").rect().left();
    let wide = |role: Role, name: &str| {
        let named = window.harness.query_all_by_label_contains(name);
        let rects = named.filter(|node| node.accesskit_node().role() == role).map(|node| node.rect());
        // The numbers' line contains the name alone too, and the name with its value.
        rects.max_by(|a, b| a.width().total_cmp(&b.width())).unwrap_or_else(|| panic!("{name} is missing"))
    };
    let numbers = ["Keypoints", "Putative", "Inliers", "Match ratio", "Match score", "Precision"];
    let lost = ["no keypoint", "ratio test", "mutual check", "geometry"];
    let rects: Vec<Rect> = numbers
        .map(|name| wide(Role::Label, name))
        .into_iter()
        .chain(lost.map(|name| wide(Role::CheckBox, name)))
        .collect();
    for (index, rect) in rects.iter().enumerate() {
        assert!(rect.left() > left && rect.right() < right && rect.bottom() < 640.0, "{index}: {rect:?}");
        assert!(rects[..index].iter().all(|other| !other.shrink(1.0).intersects(*rect)), "{rects:?}");
    }
}
