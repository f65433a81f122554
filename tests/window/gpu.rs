//! Tests that compare the card's pictures with the CPU's.

use crate::support::*;
use burstscope::app::canvas::{Canvas, Picture, View};
use burstscope::app::gpu::{AdapterChoice, DeviceLimits, Gpu, PictureRenderer};
use burstscope::app::offscreen::Offscreen;
use burstscope::error::Error;
use burstscope::plane::display::{ColourMap, Display, NAN_COLOUR};
use std::{io::Read, io::Write, process::Stdio};

/// Tolerance of a colour: the card may round differently once on the way to 8 bits and once in the gamma.
const TOLERANCE: i32 = 2;

fn offscreen(size: Vec2, pixels_per_point: f32) -> Offscreen {
    Offscreen::new(size, pixels_per_point, AdapterChoice::Software).expect("tests need mesa-vulkan-drivers")
}

fn draw(window: &mut Offscreen, picture: &Picture, display: &Display, view: &mut View, dim: bool) -> RgbaImage {
    try_draw(window, picture, display, view, dim).expect("the card draws")
}

fn try_draw(
    window: &mut Offscreen,
    picture: &Picture,
    display: &Display,
    view: &mut View,
    dim: bool,
) -> Result<RgbaImage, Error> {
    for _ in 0..2 {
        window.frame(Vec::new(), |ui| {
            ui.scope_builder(egui::UiBuilder::new().max_rect(ui.ctx().content_rect()), |ui| {
                let picture = Some(picture);
                let canvas = Canvas { picture, display: *display, dim, values: false, ..Canvas::new("Picture") };
                canvas.show(ui, view);
            });
        });
    }
    window.image()
}

fn one_to_one(picture: &Picture, pixels_per_point: f32) -> View {
    let (width, height) = picture.plane.size();
    let centre = [0.5 * (width as f32 - 1.0), 0.5 * (height as f32 - 1.0)];
    View::new(Zoom::PointsPerPixel(1.0 / pixels_per_point), centre)
}

fn assert_close(found: [u8; 4], wanted: [u8; 3], place: &str) {
    for c in 0..3 {
        let difference = (i32::from(found[c]) - i32::from(wanted[c])).abs();
        assert!(difference <= TOLERANCE, "{place}: the card shows {found:?}, the CPU {wanted:?}");
    }
}

#[test]
fn the_card_shows_the_colours_of_the_cpu() {
    let plane = Plane::from_fn(64, 48, |u, v| match (u, v) {
        (3, 4) => f32::NAN,
        (5, 6) => f32::INFINITY,
        (7, 8) => f32::NEG_INFINITY,
        _ => (u + 64 * v) as f32 / (64.0 * 48.0) * 1.3 - 0.15,
    });
    let picture = Picture::new(Arc::new(plane), "ramp");
    let mut window = offscreen(vec2(64.0, 48.0), 1.0);
    let mut uploads = 0;
    for map in ColourMap::ALL {
        for gamma in [0.45, 1.0, 2.2] {
            for (min, max) in [(0.0, 1.0), (0.2, 0.6), (-0.4, 0.4)] {
                let display = Display { min, max, gamma, map, symmetric: false };
                let image = draw(&mut window, &picture, &display, &mut one_to_one(&picture, 1.0), false);
                for (u, v, pixel) in image.enumerate_pixels() {
                    let wanted = display.colour(picture.plane.at(u as usize, v as usize));
                    assert_close(pixel.0, wanted, &format!("{display:?} at ({u}, {v})"));
                }
                assert_eq!(image.get_pixel(3, 4).0[..3], NAN_COLOUR);
                let renderer = window.render_state.renderer.read();
                uploads = renderer.callback_resources.get::<PictureRenderer>().unwrap().uploads;
            }
        }
    }
    assert_eq!(uploads, 1, "changing the exposure must upload nothing");
}

#[test]
fn magnified_pixels_are_crisp_and_where_the_transform_says() {
    let picture = Picture::new(Arc::new(Plane::from_fn(16, 12, |u, v| ((u * 7 + v * 5) % 11) as f32 / 10.0)), "blocks");
    let pixels_per_point = 1.5;
    let mut window = offscreen(vec2(120.0, 90.0), pixels_per_point);
    let mut view = View::fit();
    let display = Display::default();
    let image = draw(&mut window, &picture, &display, &mut view, false);
    let rect = Rect::from_min_size(Pos2::ZERO, vec2(120.0, 90.0));
    let ui_from_image = view.settle(rect, picture.image_size, pixels_per_point);
    let image_from_ui = ui_from_image.inverse();
    let mut inside = 0;
    for (x, y, pixel) in image.enumerate_pixels() {
        let pos_ui = (vec2(x as f32 + 0.5, y as f32 + 0.5) / pixels_per_point).to_pos2();
        let pos_image = image_from_ui.pos(pos_ui);
        let from_border = |p: f32| ((p + 0.5) - (p + 0.5).round()).abs();
        if from_border(pos_image.x).min(from_border(pos_image.y)) < 1e-3 {
            continue; // Rounding decides there.
        }
        if let Some((u, v)) = picture.pixel_at(pos_image) {
            assert_close(pixel.0, display.colour(picture.plane.at(u, v)), &format!("({x}, {y})"));
            inside += 1;
        }
    }
    assert!(inside > 10_000, "{inside}");
}

#[test]
fn small_pictures_are_averaged_not_thinned_out() {
    // Bright single pixels: subsampling would lose or exaggerate them.
    let plane = Plane::from_fn(256, 192, |u, v| if u % 8 == 3 && v % 8 == 5 { 1.0 } else { 0.0 });
    let picture = Picture::new(Arc::new(plane), "dots");
    for factor in [2usize, 4, 8] {
        let mut window = offscreen(vec2(256.0, 192.0) / factor as f32, 1.0);
        let mut view = one_to_one(&picture, 1.0);
        view.zoom = Zoom::PointsPerPixel(1.0 / factor as f32);
        let display = Display { max: 1.0 / 8.0, ..Display::default() };
        let image = draw(&mut window, &picture, &display, &mut view, false);
        for (x, y, pixel) in image.enumerate_pixels() {
            let mut sum = 0.0;
            for v in 0..factor {
                for u in 0..factor {
                    sum += picture.plane.at(x as usize * factor + u, y as usize * factor + v);
                }
            }
            let mean = sum / (factor * factor) as f32;
            assert_close(pixel.0, display.colour(mean), &format!("1:{factor} at ({x}, {y})"));
        }
    }
}

#[test]
fn any_reduction_keeps_the_mean_of_a_noisy_picture() {
    let noise = |u: usize, v: usize| ((u * 7919 + v * 104_729 + u * v * 31) % 1000) as f32 / 1000.0;
    let plane = Plane::from_fn(301, 203, noise);
    let mean = plane.data().iter().sum::<f32>() / plane.data().len() as f32;
    let picture = Picture::new(Arc::new(plane), "noise");
    for size in [vec2(190.0, 130.0), vec2(77.0, 60.0), vec2(40.0, 30.0)] {
        let mut window = offscreen(size, 1.0);
        let mut view = View::fit();
        let image = draw(&mut window, &picture, &Display::default(), &mut view, false);
        let rect = Rect::from_min_size(Pos2::ZERO, size);
        let shown = view.settle(rect, picture.image_size, 1.0).rect(picture.rect_image()).shrink(1.0);
        let (mut sum, mut count) = (0.0, 0.0);
        for (x, y, pixel) in image.enumerate_pixels() {
            if shown.contains(pos2(x as f32 + 0.5, y as f32 + 0.5)) {
                sum += f32::from(pixel.0[0]) / 255.0;
                count += 1.0;
            }
        }
        assert!((sum / count - mean).abs() < 0.01, "{size:?}: {} instead of {mean}", sum / count);
    }
}

#[test]
fn pictures_beyond_one_texture_are_tiled_without_a_seam() {
    let mut window = offscreen(vec2(64.0, 48.0), 1.0);
    // A renderer with a small limit of a texture's side.
    let limits = DeviceLimits { max_side: 128, max_layers: 64 };
    {
        let state = &window.render_state;
        let small = PictureRenderer::new(state, limits, Default::default());
        state.renderer.write().callback_resources.insert(small);
    }
    let plane = Plane::from_fn(400, 300, |u, v| ((u * 3 + v * 2) % 256) as f32 / 255.0);
    let picture = Picture::new(Arc::new(plane), "large");
    let display = Display::default();
    for centre in [(128usize, 128usize), (200, 150), (350, 260)] {
        let mut view = View::new(Zoom::PointsPerPixel(1.0), [centre.0 as f32 - 0.5, centre.1 as f32 - 0.5]);
        let image = draw(&mut window, &picture, &display, &mut view, false);
        for (x, y, pixel) in image.enumerate_pixels() {
            let (u, v) = (centre.0 - 32 + x as usize, centre.1 - 24 + y as usize);
            assert_close(pixel.0, display.colour(picture.plane.at(u, v)), &format!("pixel ({u}, {v})"));
        }
    }
    // The coarser levels must find their tiles too.
    let mut view = View::new(Zoom::PointsPerPixel(0.25), [199.5, 149.5]);
    let flat = Picture::new(Arc::new(Plane::from_fn(400, 300, |_, _| 0.5)), "flat");
    let image = draw(&mut window, &flat, &display, &mut view, false);
    for (_, _, pixel) in image.enumerate_pixels() {
        assert_close(pixel.0, display.colour(0.5), "1:4");
    }
}

fn address_space() -> u64 {
    let status = fs::read_to_string("/proc/self/status").expect("Linux has it");
    let line = status.lines().find_map(|line| line.strip_prefix("VmSize:")).expect("its size");
    line.trim().trim_end_matches(" kB").parse::<u64>().expect("a number") << 10
}

/// Another process sets the limit: with too little address space left this process could not start a process.
struct Limiter(std::process::Child);

impl Limiter {
    fn start() -> Self {
        let script = format!("while read n; do prlimit --pid {} --as=$n: && echo set; done", std::process::id());
        let mut shell = std::process::Command::new("sh");
        let shell = shell.args(["-c", &script]).stdin(Stdio::piped()).stdout(Stdio::piped());
        Self(shell.spawn().expect("it starts"))
    }

    fn set(&mut self, limit: &str) {
        let Self(shell) = self;
        let (to, from) = (shell.stdin.as_mut().expect("piped"), shell.stdout.as_mut().expect("piped"));
        to.write_all(format!("{limit}\n").as_bytes()).expect("it listens");
        let mut answer = [0; 4];
        from.read_exact(&mut answer).expect("it answers");
        assert_eq!(&answer, b"set\n");
    }
}

fn draw_with_little_memory() {
    let small = Picture::new(Arc::new(Plane::from_fn(64, 48, |u, v| ((u * 5 + v * 3) % 64) as f32 / 64.0)), "ramp");
    let display = Display::default();
    let mut window = offscreen(vec2(64.0, 48.0), 1.0);
    let before = draw(&mut window, &small, &display, &mut View::fit(), false);
    let large = Arc::new(Plane::zeros(5472, 3648));
    let mut limiter = Limiter::start();
    let (mut refused, mut drawn) = (0, 0);
    for megabytes in (16..=256).step_by(16) {
        let picture = Picture::new(large.clone(), "large");
        limiter.set(&(address_space() + (megabytes << 20)).to_string());
        let result = try_draw(&mut window, &picture, &display, &mut View::fit(), false);
        limiter.set("unlimited");
        println!("{megabytes} MB: {:?}", result.as_ref().map(|_| ()));
        match result {
            Ok(_) => drawn += 1,
            Err(error) => {
                let why = error.to_string();
                assert!(why.contains("5472 × 3648"), "{why}");
                let gpu = Gpu::of(&window.context).expect("installed");
                assert_eq!(gpu.obstacle(picture.id, (5472, 3648)), Some(why), "the window says it in its next pass");
                refused += 1;
            }
        }
        assert!(Gpu::of(&window.context).is_some_and(|gpu| gpu.lost().is_none()));
        assert_eq!(draw(&mut window, &small, &display, &mut View::fit(), false), before, "{megabytes} MB");
    }
    assert!(refused > 0 && drawn > 0, "{refused} refused, {drawn} drawn");
}

#[needs::program("prlimit")]
#[test]
fn a_picture_for_which_there_is_no_memory_is_refused_and_the_window_goes_on() {
    // In a process of its own, whose limits are those of no other test.
    const ALONE: &str = "BURSTSCOPE_TEST_ALONE";
    if std::env::var_os(ALONE).is_some() {
        return draw_with_little_memory();
    }
    let name = "gpu::a_picture_for_which_there_is_no_memory_is_refused_and_the_window_goes_on";
    let mut alone = std::process::Command::new(std::env::current_exe().expect("this program"));
    let output = alone.args(["--exact", name, "--nocapture"]).env(ALONE, "1").output().expect("it starts");
    let words = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(output.status.success() && words.contains("1 passed"), "{}: {words}", output.status);
}
