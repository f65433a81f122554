//! The canvas and the histogram, driven as a user would: by labels, pointer and wheel.

use crate::support::*;
use crate::{harness as common, pictures};
use burstscope::app::canvas::overlay::{self, ColourBy, ColourScale, OverlayStyle};
use burstscope::app::canvas::{Canvas, Picture, RectTransform, View};
use burstscope::app::gpu::PictureRenderer;
use burstscope::app::histogram::HistogramPanel;
use burstscope::detector::params::slope_grid::{Slope, SlopeAxis, SlopeGrid};
use burstscope::plane::display::{ColourMap, Display};
use egui::{Event, MouseWheelUnit, TouchPhase};

const SLOPES: SlopeGrid = SlopeGrid {
    u: SlopeAxis { min: -3.0, max: 3.0, count: 7 },
    v: SlopeAxis { min: -3.0, max: 3.0, count: 7 },
    direction_deg: 0.0,
};

struct Window {
    picture: Option<Picture>,
    features: Vec<Feature>,
    display: Display,
    view: View,
    histogram: HistogramPanel,
    colour_by: ColourBy,
    selected: Option<usize>,
    hovered: Option<usize>,
    stale: bool,
    full_scale: f32,
    changes: usize,
    canvas_rect: Rect,
    visible: Option<Rect>,
    hover_image: Option<Pos2>,
    ui_from_image: Option<RectTransform>,
}

fn blobs() -> (Plane, Vec<Feature>) {
    const BLOBS: [(f32, f32, f32, f32, f32); 7] = [
        (60.0, 50.0, 4.0, 2.0, 0.0),
        (140.0, 80.0, 9.0, 0.0, -2.0),
        (230.0, 60.0, 14.0, -1.5, 1.0),
        (80.0, 150.0, 6.0, 3.0, 0.5),
        (180.0, 170.0, 20.0, 1.0, 1.0),
        (270.0, 190.0, 3.0, -3.0, 0.0),
        (250.0, 130.0, 5.0, 0.0, 0.0),
    ];
    let plane = Plane::from_fn(320, 240, |u, v| {
        let (x, y) = (u as f32, v as f32);
        let light: f32 = BLOBS
            .iter()
            .map(|&(bu, bv, sigma, ..)| 0.05 * (-((x - bu).powi(2) + (y - bv).powi(2)) / (2.0 * sigma * sigma)).exp())
            .sum();
        0.02 + 0.00004 * x + light
    });
    let features = BLOBS.iter().enumerate().map(|(i, &(u, v, sigma, slope_u, slope_v))| Feature {
        u,
        v,
        sigma,
        orientation: i as f32,
        slope: Slope::new(slope_u, slope_v),
        response: -0.05 + 0.015 * i as f32,
        snr: 6.0,
        octave: 0,
        level: 1,
        slope_index: i,
        at_slope_limit: slope_u.abs() >= 3.0,
        ..Feature::default()
    });
    (plane, features.collect())
}

fn window() -> Window {
    let (plane, features) = blobs();
    Window {
        picture: Some(Picture::new(Arc::new(plane), "Motion-stack image")),
        features,
        display: Display { max: 0.1, ..Display::default() },
        view: View::fit(),
        histogram: HistogramPanel::default(),
        colour_by: ColourBy::SlopeDirection,
        selected: None,
        hovered: None,
        stale: false,
        full_scale: 255.0,
        changes: 0,
        canvas_rect: Rect::NOTHING,
        visible: None,
        hover_image: None,
        ui_from_image: None,
    }
}

fn window_ui(ui: &mut egui::Ui, w: &mut Window) {
    let scale = ColourScale::of(w.colour_by, &w.features, &SLOPES);
    egui::Panel::right("side").exact_size(290.0).show(ui, |ui| {
        ui.heading("Display");
        if w.histogram.ui(ui, w.picture.as_ref(), w.visible, &mut w.display) {
            w.changes += 1;
        }
        ui.separator();
        ui.heading("Legend");
        ui.label(w.colour_by.name());
        scale.legend_ui(ui);
    });
    egui::CentralPanel::no_frame().show(ui, |ui| {
        let (picture, display, dim, full_scale) = (w.picture.as_ref(), w.display, w.stale, w.full_scale);
        let canvas = Canvas { picture, display, dim, full_scale, ..Canvas::new("Picture") };
        let output = canvas.show(ui, &mut w.view);
        w.hovered = output.pointer_ui.and_then(|p| overlay::feature_at(&w.features, None, output.ui_from_image, p));
        if output.response.clicked() {
            w.selected = w.hovered;
        }
        let positions = burstscope::burst::Positions::even(10);
        let style = OverlayStyle {
            selected: w.selected,
            hovered: w.hovered,
            stale: w.stale,
            ..OverlayStyle::new(&scale, &positions)
        };
        overlay::draw_features(&output, &w.features, &style);
        w.canvas_rect = output.response.rect;
        w.visible = Some(output.visible_image);
        w.hover_image = output.hover_image;
        w.ui_from_image = Some(output.ui_from_image);
    });
}

fn harness(theme: egui::Theme, window: Window) -> Harness<'static, Window> {
    let builder = common::with_pictures(common::builder([900.0, 560.0])).with_theme(theme).with_step_dt(1.0 / 60.0);
    let mut harness = builder.build_ui_state(window_ui, window);
    harness.run();
    harness
}

fn wheel(harness: &mut Harness<'_, Window>, pos: Pos2, notches: f32, modifiers: Modifiers) {
    harness.hover_at(pos);
    harness.step();
    harness.event(Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, notches),
        phase: TouchPhase::Move,
        modifiers,
        source: egui::MouseWheelSource::Wheel,
    });
    harness.run();
}

fn drag(harness: &mut Harness<'_, Window>, from: Pos2, to: Pos2) {
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for i in 1..=4 {
        harness.hover_at(from + (to - from) * (i as f32 / 4.0));
        harness.step();
    }
    harness.drop_at(to);
    harness.run();
}

#[test]
fn the_canvas_has_a_name_a_click_selects_and_a_drag_moves_the_picture() {
    let mut harness = harness(egui::Theme::Dark, window());
    let node = harness.get_by_label("Picture").rect();
    assert_eq!(node, harness.state().canvas_rect);
    assert!(harness.state().view.is_fit());
    harness.hover_at(node.center());
    harness.run();
    let hover = harness.state().hover_image.expect("the pointer is over the picture");
    assert!((hover - pos2(159.5, 119.5)).length() < 1.0, "{hover:?}");
    let place = harness.state().ui_from_image.unwrap().pos(pos2(140.0, 80.0));
    harness.hover_at(place);
    harness.run();
    assert_eq!(harness.state().hovered, Some(1));
    harness.drag_at(place);
    harness.drop_at(place);
    harness.run();
    assert_eq!(harness.state().selected, Some(1));
    harness.state_mut().view = View::new(Zoom::PointsPerPixel(4.0), [160.0, 120.0]);
    harness.run();
    let centre = harness.state().canvas_rect.center();
    drag(&mut harness, centre, centre + vec2(40.0, -20.0));
    let [u, v] = harness.state().view.centre_image;
    assert!((u - 150.0).abs() < 0.3 && (v - 125.0).abs() < 0.3, "({u}, {v})");
    assert_eq!(harness.state().view.zoom, Zoom::PointsPerPixel(4.0));
}

#[test]
fn the_wheel_zooms_at_the_pointer_and_a_double_click_fits_again() {
    for modifiers in [Modifiers::NONE, Modifiers::COMMAND] {
        let mut harness = harness(egui::Theme::Dark, window());
        let pointer = harness.state().canvas_rect.lerp_inside(vec2(0.3, 0.6));
        let under = |h: &Harness<'_, Window>| h.state().ui_from_image.unwrap().inverse().pos(pointer);
        let (place, zoom) = (under(&harness), harness.state().view.points_per_pixel());
        wheel(&mut harness, pointer, 6.0, modifiers);
        assert!(harness.state().view.points_per_pixel() > 1.5 * zoom, "{modifiers:?}");
        // At whole multiples pixels are aligned with the screen's, which may move them by half a pixel.
        assert!((under(&harness) - place).length() < 0.5, "{modifiers:?}: {:?} became {:?}", place, under(&harness));
        for _ in 0..2 {
            harness.drag_at(pointer);
            harness.drop_at(pointer);
        }
        harness.run();
        assert!(harness.state().view.is_fit());
    }
}

#[test]
fn buttons_set_the_range_and_say_so() {
    let mut harness = harness(egui::Theme::Dark, window());
    harness.get_by_label("Full range").click();
    harness.run();
    let full = harness.state().display;
    assert!(harness.state().changes > 0 && full.min < 0.021 && full.max > 0.07, "{full:?}");
    harness.get_by_label("Percentiles").click();
    harness.run();
    let percentiles = harness.state().display;
    assert!(percentiles.min >= full.min && percentiles.max < full.max, "{percentiles:?}");
    // A corner without blobs: the visible region is much darker.
    harness.state_mut().view = View::new(Zoom::PointsPerPixel(40.0), [6.0, 232.0]);
    harness.run();
    harness.get_by_label("Visible region").click();
    harness.run();
    assert!(harness.state().display.max < 0.6 * percentiles.max, "{:?}", harness.state().display);
    let changes = harness.state().changes;
    harness.run_steps(3);
    assert_eq!(harness.state().changes, changes, "a display that nobody touches must not report changes");
}

#[test]
fn a_symmetric_display_stays_symmetric_whatever_is_pressed() {
    let mut w = window();
    w.picture = Some(Picture::new(Arc::new(Plane::from_fn(64, 48, |u, v| 0.03 * ((u + v) % 7) as f32 - 0.05)), "DoG"));
    w.features.clear();
    w.display = Display::symmetric(0.02);
    let mut harness = harness(egui::Theme::Dark, w);
    assert!(harness.query_by_label("0 – 1").is_none());
    for button in ["Full range", "Percentiles", "Visible region"] {
        harness.get_by_label(button).click();
        harness.run();
        let display = harness.state().display;
        assert_eq!(display.min, -display.max, "{button}");
        assert!((display.max - 0.13).abs() < 1e-3, "{button}: {display:?}");
    }
}

#[test]
fn the_handle_of_the_histogram_is_dragged_and_a_colour_map_picked() {
    let mut harness = harness(egui::Theme::Dark, window());
    let plot = harness.get_by_label("Histogram").rect();
    let before = harness.state().display;
    // The upper end lies near the right edge of the plot.
    let handle = pos2(plot.right() - 6.0 - (plot.width() - 12.0) * 0.04 / 1.08, plot.center().y);
    drag(&mut harness, handle, pos2(plot.center().x, plot.center().y));
    let after = harness.state().display;
    assert_eq!(after.min, before.min);
    assert!((after.max - 0.05).abs() < 0.004, "{after:?}");
    harness.get_by_role_and_label(egui::accesskit::Role::ComboBox, "Colour map").click();
    harness.run();
    for map in ColourMap::ALL.into_iter().filter(|&map| map != ColourMap::Grey) {
        harness.get_by_label(map.name());
    }
    harness.get_by_label("Cividis").click();
    harness.run();
    assert_eq!(harness.state().display.map, ColourMap::Cividis);
}

#[test]
fn exposure_changes_the_picture_without_an_upload() {
    let (plane, _) = blobs();
    let mut window = burstscope::app::offscreen::Offscreen::new(
        vec2(200.0, 150.0),
        1.0,
        burstscope::app::gpu::AdapterChoice::Software,
    )
    .expect("tests need mesa-vulkan-drivers");
    let picture = Picture::new(Arc::new(plane), "frame");
    let mut images = Vec::new();
    for max in [1.0, 0.1, 0.05] {
        let display = Display { max, ..Display::default() };
        window.frame(Vec::new(), |ui| {
            Canvas { picture: Some(&picture), display, ..Canvas::new("Picture") }.show(ui, &mut View::fit());
        });
        images.push(window.image().unwrap());
    }
    assert!(images[0] != images[1] && images[1] != images[2]);
    let renderer = window.render_state.renderer.read();
    assert_eq!(renderer.callback_resources.get::<PictureRenderer>().unwrap().uploads, 1);
}

#[test]
fn the_canvas_stands_without_a_picture_or_a_card_and_on_a_hidpi_screen() {
    let mut w = window();
    w.picture = None;
    let mut empty = harness(egui::Theme::Light, w);
    empty.run();
    assert!(empty.get_by_label("Picture").rect().width() > 100.0);
    // Without `install` the window still runs.
    let mut bare = common::builder([900.0, 560.0]).build_ui_state(window_ui, window());
    bare.run();
    let mut w = window();
    w.view.set_one_to_one(2.0);
    let builder = common::with_pictures(common::builder([900.0, 560.0])).with_pixels_per_point(2.0);
    let mut harness = builder.build_ui_state(window_ui, w);
    harness.run();
    let two_pixels = harness.state().ui_from_image.unwrap().scale() * vec2(2.0, 0.0);
    assert!((two_pixels.x - 1.0).abs() < 1e-6, "two image pixels are one point: {two_pixels:?}");
}

#[test]
fn features_values_responses_and_what_is_stale_are_drawn() {
    let compare = |theme: egui::Theme, name: &str, change: &dyn Fn(&mut Window)| {
        let mut w = window();
        change(&mut w);
        let mut harness = harness(theme, w);
        harness.run_steps(4);
        pictures::compare(&mut harness, name);
    };
    compare(egui::Theme::Dark, "flat/canvas_features_dark", &|w| w.selected = Some(4));
    compare(egui::Theme::Light, "flat/canvas_values_light", &|w| {
        w.view = View::new(Zoom::PointsPerPixel(48.0), [60.2, 50.4]);
        w.display = Display { max: 0.09, gamma: 1.4, map: ColourMap::Viridis, ..Display::default() };
        w.colour_by = ColourBy::Of(Quantity::Sigma);
    });
    compare(egui::Theme::Light, "flat/canvas_response_light", &|w| {
        let (plane, _) = blobs();
        let signed = Plane::from_fn(160, 120, |u, v| plane.at(2 * u, 2 * v) - plane.at((2 * u + 14).min(319), 2 * v));
        w.picture = Some(Picture::of_octave(Arc::new(signed), 1, (320, 240), "DoG response"));
        (w.display, w.colour_by) = (Display::symmetric(0.04), ColourBy::Of(Quantity::Response));
    });
    compare(egui::Theme::Dark, "flat/canvas_stale_dark", &|w| {
        (w.stale, w.colour_by) = (true, ColourBy::Of(Quantity::SlopeU));
        w.display = Display { max: 0.09, map: ColourMap::Magma, ..Display::default() };
    });
}

#[test]
fn thousands_of_features_draw_with_few_triangles() {
    // As many features as in a real picture, in a widget without a card, so that only the overlay is measured.
    let (_, template) = blobs();
    let features: Vec<Feature> = (0..5000)
        .map(|i| Feature {
            u: (i * 7919 % 1600) as f32,
            v: (i * 104_729 % 1200) as f32,
            sigma: 1.6 + (i % 11) as f32,
            ..template[i % template.len()]
        })
        .collect();
    let picture = Picture::new(Arc::new(Plane::zeros(1600, 1200)), "frame");
    let scale = ColourScale::of(ColourBy::SlopeDirection, &features, &SLOPES);
    let ctx = egui::Context::default();
    let input = || egui::RawInput {
        screen_rect: Some(Rect::from_min_size(Pos2::ZERO, Vec2::new(1600.0, 1000.0))),
        ..Default::default()
    };
    let mut triangles = 0;
    // In the second pass the layout is complete.
    for _ in 0..2 {
        let mut output = ctx.run_ui(input(), |ui| {
            let canvas = Canvas { picture: Some(&picture), ..Canvas::new("Picture") };
            let output = canvas.show(ui, &mut View::fit());
            overlay::draw_features(
                &output,
                &features,
                &OverlayStyle::new(&scale, &burstscope::burst::Positions::even(10)),
            );
        });
        output.textures_delta.clear();
        let primitives = ctx.tessellate(output.shapes, 1.0);
        triangles = primitives
            .iter()
            .map(|p| match &p.primitive {
                egui::epaint::Primitive::Mesh(mesh) => mesh.indices.len() / 3,
                egui::epaint::Primitive::Callback(_) => 0,
            })
            .sum();
    }
    // The time of drawing grows with the triangles, of which a feature has fewer than 100.
    assert!((100_000..500_000).contains(&triangles), "{triangles} triangles");
}
