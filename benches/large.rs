//! Wait for the picture of another slope of ten frames of 12 megapixels, at several zooms: until a pass shows it as it
//! is seen and until one shows it whole, each also with the drawing by the graphics card, or by the software driver in
//! its place; and the longest pass of the window meanwhile.
//!
//!     cargo bench --bench large

use burstscope::app::apply::opening::take_burst;
use burstscope::app::document::panes::Panels;
use burstscope::app::gpu::AdapterChoice;
use burstscope::app::offscreen::Offscreen;
use burstscope::app::settings::Settings;
use burstscope::app::view::{View, Zoom};
use burstscope::app::{BurstscopeApp, Startup};
use burstscope::detector::Slope;
use burstscope::requests::{BurstSource, OpenBurst};
use burstscope::{Burst, Plane};
use std::time::{Duration, Instant};

const SIZE: (usize, usize) = (4000, 3000);
const TURNS: usize = 9;

/// Ten frames that move by one pixel a frame, with noise.
fn burst() -> Burst {
    let noise = |u: usize, v: usize, t: usize| {
        let x = (u as u64 ^ (v as u64) << 20 ^ (t as u64) << 40).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((x ^ x >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f32 / (1 << 24) as f32
    };
    let scene = |u: f32, v: f32| 0.4 + 0.2 * (0.05 * u).sin() * (0.04 * v).cos();
    let frame =
        |t: usize| Plane::from_fn(SIZE.0, SIZE.1, |u, v| scene(u as f32 - t as f32, v as f32) + 0.1 * noise(u, v, t));
    Burst::from_planes("large", (0..10).map(frame).collect())
}

struct Window {
    offscreen: Offscreen,
    app: BurstscopeApp,
    longest: f64,
}

impl Window {
    fn pass(&mut self) {
        let started = Instant::now();
        self.offscreen.frame(Vec::new(), |ui| self.app.show(ui));
        self.longest = self.longest.max(started.elapsed().as_secs_f64());
    }

    /// Passes as often as a screen shows them, until `done`; the seconds that it took.
    fn until(&mut self, done: impl Fn(&BurstscopeApp) -> bool) -> f64 {
        let started = Instant::now();
        loop {
            self.pass();
            if done(&self.app) {
                return started.elapsed().as_secs_f64();
            }
            assert!(started.elapsed() < Duration::from_secs(60), "no picture came");
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    1e3 * values[values.len() / 2]
}

fn main() {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(2);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("the pool is built once");
    let offscreen = Offscreen::new(egui::vec2(1600.0, 1000.0), 1.0, AdapterChoice::Fastest).expect("an adapter");
    let panels = Panels { welcome: false, ..Panels::default() };
    let settings = Settings { panels, auto_detect: false, ..Settings::default() };
    let app = BurstscopeApp::new(&offscreen.context, None, Startup { settings, ..Startup::default() });
    let mut window = Window { offscreen, app, longest: 0.0 };
    window.until(BurstscopeApp::is_settled);
    take_burst(&mut window.app.model, OpenBurst::new(burst(), BurstSource::Demo));
    println!("first picture: {:.0} ms", 1e3 * window.until(BurstscopeApp::is_settled));
    let (focus, mut slope) = (window.app.read().document.focus(), Slope::new(0.0, 0.0));
    println!("ms until it is | seen | and drawn | whole | and drawn | drawn once more | longest pass |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for zoom in [None, Some(0.3), Some(0.6), Some(1.0), Some(3.0)] {
        let centre = [0.4 * SIZE.0 as f32, 0.6 * SIZE.1 as f32];
        let view = zoom.map_or_else(View::fit, |zoom| View::new(Zoom::PointsPerPixel(zoom), centre));
        window.app.model.document.panes.get_mut(focus).expect("it is there").view = view;
        window.until(BurstscopeApp::is_settled);
        window.until(BurstscopeApp::is_settled);
        let mut turn = || {
            slope = Slope::new(slope.u + 0.13, slope.v - 0.07);
            window.longest = 0.0;
            window.app.model.document.panes.get_mut(focus).expect("it is there").cursor.slope = slope;
            let (started, mut times) = (Instant::now(), Vec::new());
            let done: [fn(&BurstscopeApp) -> bool; 2] =
                [|app| app.read().pictures_are_seen(), |app| app.read().pictures_are_current()];
            for done in done {
                window.until(done);
                times.push(started.elapsed().as_secs_f64());
                window.offscreen.image().expect("drawn");
                times.push(started.elapsed().as_secs_f64());
            }
            window.offscreen.image().expect("drawn");
            times.push(started.elapsed().as_secs_f64() - times[3]);
            window.until(BurstscopeApp::is_settled);
            times.push(window.longest);
            times
        };
        let turns: Vec<Vec<f64>> = (0..TURNS).map(|_| turn()).collect();
        let name = zoom.map_or_else(|| "fitted".to_owned(), |zoom| format!("at {zoom}"));
        let medians = (0..turns[0].len()).map(|i| median(turns.iter().map(|turn| turn[i]).collect()));
        let cells: Vec<String> = medians.map(|ms| format!("{ms:.0}")).collect();
        println!("| {name:<6} | {} | first: {:.0} |", cells.join(" | "), 1e3 * turns[0][0]);
    }
}
