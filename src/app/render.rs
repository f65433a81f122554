//! The window, drawn into a PNG without a display: for papers, documentation, and machines without a screen.

use super::offscreen::render_offscreen;
use super::settings::Settings;
use super::startup::Startup;
use super::window::BurstscopeApp;
use crate::app::document::cursor::ViewKind;
use crate::app::{apply::params, defaults::with_defaults, document::Panels};
use crate::burst::Burst;
use crate::detector::view::check_level;
use crate::detector::{Slope, SlopeGrid};
use crate::error::{Error, ErrorKind};
use crate::export::{Bitmap, OutputRules, write_png};
use crate::monitor::Monitor;
use std::cell::RefCell;
use std::path::Path;
use std::time::Duration;

with_defaults! {
    #[derive(Clone)]
    pub struct RenderOptions {
        /// Bursts, parameters or steps with which the window begins, its settings aside. A session, a lesson and steps
        /// are drawn as they end; the cursor of these options then has no effect.
        pub startup: Startup,
        pub size_points: (f32, f32) = (1280.0, 800.0),
        /// Pixels for each point: 2 for a HiDPI screen.
        pub scale: f32 = 1.0,
        pub light: bool,
        pub kind: ViewKind = ViewKind::Stack,
        pub slope: Option<Slope>,
        pub frame: Option<usize>,
        /// Octave of the DoG response; `None` takes the finest.
        pub octave: Option<i32>,
        pub level: i32,
        pub detect: bool = true,
        pub select_strongest: bool,
        pub max_duration: Duration = Duration::from_secs(600),
        /// Rules for replacing a file by the picture. Files that the window opens are never replaced.
        pub rules: OutputRules,
        pub monitor: Monitor,
    }
}

pub fn render_to_png(options: &RenderOptions, path: &Path) -> Result<(), Error> {
    options.rules.check(path)?;
    let settings = Settings {
        theme: if options.light { egui::ThemePreference::Light } else { egui::ThemePreference::Dark },
        auto_detect: options.detect,
        // A picture has no use for buttons.
        panels: Panels { welcome: false, ..Panels::default() },
        ..Settings::default()
    };
    let begin = &options.startup;
    let startup = match begin.play {
        // They set it up from a window of the defaults.
        Some(_) => begin.clone(),
        None => Startup { settings, ..begin.clone() },
    };
    let (mut placed, mut opened) = (false, Vec::new());
    let (mut problem, unfit) = (None, RefCell::new(None));
    let rendered = render_offscreen(
        options.size_points.into(),
        options.scale,
        options.max_duration,
        &options.monitor,
        // The offscreen window has its pictures' renderer already.
        |ctx, _| BurstscopeApp::new(ctx, None, startup),
        |app, ui| {
            app.show(ui);
            let is_open = app.model.results.slots.a.burst.is_some()
                && (begin.second.is_none() || app.model.results.slots.b.burst.is_some());
            if is_open && !placed {
                if begin.session.is_none() && begin.lesson.is_none() && begin.play.is_none() {
                    place(app, options);
                    let burst = app.model.results.slots.a.burst.as_ref();
                    unfit.replace(burst.and_then(|open| check_cursor(&open.burst, options).err()));
                }
                placed = true;
            }
            if is_open && path.exists() {
                opened = app.read().opened_files();
            }
            if options.select_strongest {
                let (document, results) = (&mut app.model.document, &app.model.results);
                document.selected_match = document.selected_match.or(results.pair.listed.first().copied());
                document.selected = document.selected.or(results.listed.first().copied());
            }
            problem = app.model.shell.messages.errors.first().map(|m| m.text.clone()).or_else(|| {
                app.model.results.slots.a.param_error.as_ref().filter(|_| options.detect).map(ToString::to_string)
            });
        },
        |app| {
            let failed = !app.model.shell.messages.errors.is_empty() || !app.choice().is_empty();
            let answered = app.model.results.slots.a.burst.is_some() || failed || begin.play.is_some();
            if app.asks_for_shape() {
                unfit.replace(Some(no_shape(options)));
            }
            let second = begin.second.is_none() || app.model.results.slots.b.burst.is_some() || failed;
            unfit.borrow().is_some() || (app.is_settled() && answered && second)
        },
    )?;
    options.monitor.check()?;
    let problem = problem.map(|problem| Error::new(ErrorKind::Failed, problem, ""));
    if let Some(error) = unfit.into_inner().or(problem) {
        return Err(error);
    }
    if !rendered.settled {
        let problem = format!("the window was not ready after {} seconds", options.max_duration.as_secs());
        return Err(Error::new(ErrorKind::Failed, problem, "allow more time, or search fewer slopes"));
    }
    options.rules.clone().and_opened(opened).check(path)?;
    let (width, height) = rendered.image.dimensions();
    write_png(path, Bitmap::rgba(width as usize, height as usize, rendered.image.as_raw()))?;
    Ok(())
}

/// Error of the file whose shape the window would ask for.
fn no_shape(options: &RenderOptions) -> Error {
    let Startup { source, second, calibration, .. } = &options.startup;
    let mut sources = [source, second].into_iter().flatten();
    let error = sources.find_map(|source| source.info(calibration, &options.monitor).err());
    let (problem, remedy) = ("the shape of a file without header is not said", "give it in the calibration (raw)");
    error.unwrap_or_else(|| Error::new(ErrorKind::NoShape, problem, remedy))
}

/// The burst has the frame, octave and level, and the slope stays within it; worded as by `stack`.
fn check_cursor(burst: &Burst, options: &RenderOptions) -> Result<(), Error> {
    if let Some(frame) = options.frame.filter(|frame| *frame >= burst.len()) {
        let problem = format!("there is no frame {frame} in a burst of {}", burst.len());
        return Err(Error::param("frame", problem, format!("give 0 to {}", burst.len() - 1)));
    }
    let params = options.startup.params.at(SlopeGrid::single(options.slope.unwrap_or_default()));
    params.validate_for(&burst.positions, burst.size())?;
    if options.kind == ViewKind::Dog || options.octave.is_some() {
        check_level(&params, burst.size(), options.octave.unwrap_or(params.first_octave), options.level)?;
    }
    Ok(())
}

fn place(app: &mut BurstscopeApp, options: &RenderOptions) {
    let model = &mut app.model;
    let pane = model.document.focused_mut();
    pane.show(options.kind);
    if let Some(slope) = options.slope {
        (pane.cursor.slope, pane.slope_chosen) = (slope, true);
    }
    pane.cursor.frame = options.frame.unwrap_or(pane.cursor.frame);
    pane.cursor.octave = options.octave.unwrap_or(options.startup.params.first_octave);
    pane.cursor.level = options.level;
    params::check_params(model);
    if model.results.slots.b.burst.is_some() {
        model.document.bring_cursors_together();
    }
}
