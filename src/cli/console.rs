//! Terminal of a command: results on the standard output, progress on the standard error, signals cancel the work.

use super::failure::{complain, print, print_json, printable};
use super::{Failure, Outcome, OutputArgs, signals};
use crate::detector::{REVISION, memory};
use crate::monitor::{Monitor, Progress};
use crate::requests::{locked, time_left};
use anyhow::Context;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::IsTerminal;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A value with these fields, for [`Console::say_document`]. Each is written as its own type is: `json!` would make an
/// `f32` an `f64`, which has digits that nobody measured.
macro_rules! document {
    ($($name:ident $(: $value:expr)?),+ $(,)?) => {{
        // Each type has the name of its field.
        #[allow(non_camel_case_types)]
        mod of_fields {
            #[derive(serde::Serialize)]
            pub(super) struct Document<$($name),+> {
                $(pub(super) $name: $name),+
            }
        }
        of_fields::Document { $($name $(: $value)?),+ }
    }};
}
pub(super) use document;

/// The fields of two documents in one.
#[derive(Serialize)]
pub(super) struct Both<A, B> {
    #[serde(flatten)]
    pub one: A,
    #[serde(flatten)]
    pub other: B,
}

pub(super) struct Console {
    /// Carries progress to the bar, and Ctrl-C to the work.
    pub monitor: Monitor,
    bar: ProgressBar,
    lines: Arc<Mutex<Lines>>,
    began: Instant,
    pub output: OutputArgs,
}

/// Steps of the progress bar: a tenth of a percent each.
const STEPS: u64 = 1000;

impl Console {
    /// The first signal that asks the program to end cancels the work, the second ends the program at once.
    pub fn new(output: &OutputArgs) -> Outcome<Self> {
        if let Some(threads) = output.threads {
            let started = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global();
            started.context("cannot start the threads").map_err(Failure::Failed)?;
        }
        memory::set_budget(output.memory);
        let is_terminal = std::io::stderr().is_terminal();
        let visible = !output.quiet && is_terminal;
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{prefix}{msg:22} {bar:30} {percent:>3} %")
            .expect("the template is a constant that parses");
        let bar = ProgressBar::with_draw_target(Some(STEPS), target).with_style(style);
        let (shown, lines, began) = (bar.clone(), Arc::new(Mutex::new(Lines::default())), Instant::now());
        let printed = (!output.quiet && !is_terminal).then(|| lines.clone());
        let monitor = Monitor::with_listener(move |progress| {
            shown.set_message(progress.stage.to_string());
            shown.set_position((progress.fraction * STEPS as f32) as u64);
            let line = printed.as_ref().and_then(|lines| locked(lines).due(began.elapsed(), progress));
            line.into_iter().for_each(|line| complain(&line));
        });
        let cancelled = monitor.clone();
        signals::on_end(move || cancelled.cancel())?;
        Ok(Self { monitor, bar, lines, began, output: *output })
    }

    pub fn begin(&self, prefix: String) {
        self.bar.set_prefix(printable(&prefix).into_owned());
        self.bar.set_position(0);
        locked(&self.lines).begin(self.began.elapsed(), prefix);
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
        self.bar.set_prefix(prefix.clone());
        locked(&self.lines).prefix = prefix;
    }

    /// Prints text for people, unless JSON or quiet was asked for.
    pub fn say(&self, text: &str) -> Outcome {
        if self.output.json || self.output.quiet {
            Ok(())
        } else {
            // The bar would be drawn into the text.
            self.bar.suspend(|| print(text)).map_err(Failure::output)
        }
    }

    /// Prints the JSON document of `command`: its version, its name, and the fields of `report`, if JSON was asked for.
    pub fn say_document(&self, command: &str, report: &impl Serialize) -> Outcome {
        if !self.output.json {
            return Ok(());
        }
        let (version, commit, detector_revision) = (env!("CARGO_PKG_VERSION"), burstscope_core::COMMIT, REVISION);
        let document = Both { one: document! { version, commit, detector_revision, command }, other: report };
        let text = serde_json::to_string_pretty(&document).context("cannot put the results into JSON");
        let text = text.map_err(Failure::Failed)?;
        self.bar.suspend(|| print_json(&(text + "\n"))).map_err(Failure::output)
    }

    pub fn complain(&self, text: &str) {
        self.bar.suspend(|| complain(&format!("error: {text}")));
    }

    #[cfg(feature = "colmap")]
    pub fn note(&self, text: &str) {
        self.bar.suspend(|| complain(&format!("note: {text}")));
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Lines in place of the bar, for a standard error that is no terminal. Times are from the start of the command.
#[derive(Debug, Default)]
struct Lines {
    /// Name of the present piece of work, and when it began.
    prefix: String,
    began: Duration,
    printed: Duration,
}

/// Time without a line, at first and after each.
const SILENCE: Duration = Duration::from_secs(60);

impl Lines {
    fn begin(&mut self, now: Duration, prefix: String) {
        (self.prefix, self.began) = (prefix, now);
    }

    /// The line that is printed `now`, if any.
    fn due(&mut self, now: Duration, Progress { stage, fraction }: Progress) -> Option<String> {
        // Threads report in any order.
        if now.saturating_sub(self.printed) < SILENCE {
            return None;
        }
        self.printed = now;
        let left = time_left(now.saturating_sub(self.began), fraction);
        let left = left.map_or_else(String::new, |left| match (left.as_secs_f32() / 60.0).ceil().max(1.0) {
            minutes @ ..120.0 => format!(", {minutes} min left"),
            minutes => format!(", {:.0} h left", minutes / 60.0),
        });
        Some(format!("{}{stage}, {:.0} %{left}", self.prefix, 100.0 * fraction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Stage;

    #[test]
    fn a_line_comes_after_a_minute_and_says_what_is_done_and_how_long_the_rest_takes_at_this_pace() {
        let mut lines = Lines::default();
        let mut due = |seconds: f32, fraction| {
            lines.due(Duration::from_secs_f32(seconds), Progress { stage: Stage::Noise, fraction })
        };
        let times = [0.0, 1.0, 59.5, 60.0, 60.5, 119.5, 125.0, 124.0, 180.0, 184.5, 185.0];
        let printed: Vec<f32> = times.into_iter().filter(|time| due(*time, 0.5).is_some()).collect();
        assert_eq!(printed, [60.0, 125.0, 185.0]);
        let said = |began: u64, now: u64, fraction| {
            let mut lines = Lines::default();
            lines.begin(Duration::from_secs(began), "[3/12] night: ".to_owned());
            let progress = Progress { stage: Stage::Search { octave: 1 }, fraction };
            lines.due(Duration::from_secs(now), progress).expect("it is due")
        };
        assert_eq!(said(40, 100, 0.25), "[3/12] night: Searching octave 1, 25 %, 3 min left");
        assert_eq!(said(0, 60, 0.999), "[3/12] night: Searching octave 1, 100 %, 1 min left");
        assert_eq!(said(0, 3600, 0.2), "[3/12] night: Searching octave 1, 20 %, 4 h left");
        // Of a piece that has just begun nothing is known.
        assert_eq!(said(100, 100, 0.0), "[3/12] night: Searching octave 1, 0 %");
    }
}
