//! Terminal of a command: results on the standard output, progress on the standard error, signals cancel the work.

use super::failure::{complain, print, print_json, printable};
use super::{Failure, OutputArgs, signals};
use crate::detector::{REVISION, memory};
use crate::monitor::Monitor;
use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::IsTerminal;
use std::time::Duration;

pub(super) struct Console {
    /// Carries progress to the bar, and Ctrl-C to the work.
    pub monitor: Monitor,
    bar: ProgressBar,
    output: OutputArgs,
}

/// Steps of the progress bar: a tenth of a percent each.
const STEPS: u64 = 1000;

impl Console {
    /// The first signal that asks the program to end cancels the work, the second ends the program at once.
    pub fn new(output: &OutputArgs) -> Result<Self, Failure> {
        if let Some(threads) = output.threads {
            rayon::ThreadPoolBuilder::new()
                .num_threads(usize::from(threads))
                .build_global()
                .context("cannot start the threads")
                .map_err(Failure::Failed)?;
        }
        memory::set_budget(output.memory);
        let visible = !output.quiet && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{prefix}{msg:22} {bar:30} {percent:>3} %")
            .expect("the template is a constant that parses");
        let bar = ProgressBar::with_draw_target(Some(STEPS), target).with_style(style);
        let shown = bar.clone();
        let monitor = Monitor::with_listener(move |progress| {
            shown.set_message(progress.stage.to_string());
            shown.set_position((progress.fraction * STEPS as f32) as u64);
        });
        let cancelled = monitor.clone();
        signals::on_end(move || cancelled.cancel())?;
        Ok(Self { monitor, bar, output: *output })
    }

    pub fn begin(&self, prefix: String) {
        self.bar.set_prefix(printable(&prefix).into_owned());
        self.bar.set_position(0);
    }

    pub fn show_time_left(&self) {
        let style = ProgressStyle::with_template("{prefix}{msg:22} {bar:30} {percent:>3} %, {eta} left")
            .expect("the template is a constant that parses");
        self.bar.set_style(style);
        // Keeps the remaining time counting while a piece of work reports no progress.
        self.bar.enable_steady_tick(Duration::from_secs(1));
    }

    /// Names the present piece of work in front of the bar; the bar goes on.
    pub fn go_on(&self, prefix: String) {
        self.bar.set_prefix(prefix);
    }

    /// Prints text for people, unless JSON or quiet was asked for.
    pub fn say(&self, text: &str) -> Result<(), Failure> {
        if self.output.json || self.output.quiet {
            Ok(())
        } else {
            // The bar would be drawn into the text.
            self.bar.suspend(|| print(text)).map_err(Failure::output)
        }
    }

    pub fn writes_json(&self) -> bool {
        self.output.json
    }

    /// Prints the JSON document of `command`: its version, its name, and the fields of `report`, if JSON was asked for.
    pub fn say_document(&self, command: &str, report: &impl Serialize) -> Result<(), Failure> {
        #[derive(Serialize)]
        struct Document<'a, R> {
            version: &'a str,
            detector_revision: u32,
            command: &'a str,
            #[serde(flatten)]
            report: &'a R,
        }
        if !self.output.json {
            return Ok(());
        }
        let (version, detector_revision) = (env!("CARGO_PKG_VERSION"), REVISION);
        let document = Document { version, detector_revision, command, report };
        let text = serde_json::to_string_pretty(&document)
            .context("cannot put the results into JSON")
            .map_err(Failure::Failed)?;
        self.bar.suspend(|| print_json(&(text + "\n"))).map_err(Failure::output)
    }

    pub fn complain(&self, text: &str) {
        self.bar.suspend(|| complain(&format!("error: {text}")));
    }

    #[cfg(feature = "colmap")]
    pub fn note(&self, text: &str) {
        self.bar.suspend(|| complain(&format!("note: {text}")));
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.finish();
    }
}
