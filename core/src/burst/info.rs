//! Description of a burst by what its files declare, before any pixel is read: what the command `info` prints.

use super::layout::{TimesChoice, ViewsChoice};
use super::options::{Limits, OpenOptions};
use super::stamps::{SHORTEST_S, Timing, of_headers};
use super::times::{Times, time_text};
use super::views::{placed, size_of_view};
use super::{Burst, formats, positions::Positions, reading::Declared, source::only_burst};
use crate::error::{Error, Result};
use crate::monitor::Monitor;
use serde::Serialize;
use std::path::PathBuf;

/// Description of a burst, with the options applied.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Info {
    /// Name of the burst.
    pub name: String,
    /// Kind of its (first) file, such as "PNG" or "FITS".
    pub kind: String,
    /// Number of files; 0 for a burst in memory.
    pub files: usize,
    /// Number of frames, at least 1.
    pub frames: usize,
    /// Columns of a frame as it is opened.
    pub width: usize,
    /// Rows of a frame as it is opened.
    pub height: usize,
    /// Samples of the first file, such as "16 bit".
    pub samples: String,
    /// Whether the file has colours for each pixel, whose luma is taken.
    pub is_colour: bool,
    /// Sensor pixels along a side of one pixel of the frames: 1 unless a mosaic of colours is binned.
    pub binning: usize,
    /// Time of each frame from the first one, seconds; empty where the files do not say it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub times_s: Vec<f64>,
    /// Time of the first frame (UTC), where the files say it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub begins: Option<String>,
    /// Time of each frame from the first one, frame intervals; empty where nothing says it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub positions: Vec<f64>,
    /// Whether frames are taken at these positions; otherwise they are taken as even.
    pub are_times_used: bool,
    /// Rows and columns of the grid that the frames fill, where they are views of a light field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<[usize; 2]>,
    /// Seconds of a frame interval, where they are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_s: Option<f64>,
    /// Guesses and choices about the files, as sentences.
    pub taken: Vec<String>,
}

/// Largest number of frames whose times are listed.
const MOST_FRAMES: usize = 1 << 20;

impl Info {
    /// Describes the burst of `inputs`, as [`Burst::open_with`] takes them, by headers; a raw file's frame is decoded.
    pub fn of(inputs: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Result<Self> {
        let (source, range) = (only_burst(inputs, options)?, options.take);
        let mut files = source.files()?;
        let is_apart = files.len() > 1;
        let are_placed = is_apart && files.len() <= MOST_FRAMES;
        let of_files = are_placed.then(|| placed(&mut files, None, options, monitor)).transpose()?;
        // Of several files those that are taken are left.
        let options = &OpenOptions { take: range.filter(|_| !is_apart), ..options.clone() };
        let first = files.first().ok_or_else(Error::nothing_given)?;
        let declared = formats::declared(first, options, monitor)?;
        let Declared { kind, width, height, frames, samples, is_colour, mosaic, times, views, taken, first: decoded } =
            declared;
        let is_mosaic = decoded.is_none() && options.mosaic_of(mosaic).is_some();
        let binning = if is_mosaic { 2 } else { decoded.map_or(1, |frame| frame.binning) };
        // The frame of a raw file is binned already.
        let (width, height) = if is_mosaic { (width / 2, height / 2) } else { (width, height) };
        let frames = if is_apart { files.len() } else { frames };
        let mut taken = taken;
        taken.extend(range.map(|range| format!("the frames {range} are taken")));
        let most = Limits::default().max_frames;
        if frames > most {
            taken.push(format!("a burst has at most {most} frames; take a part, such as --take 0..10"));
        }
        let (width, height, frames) = match options.views.and_then(ViewsChoice::picture).filter(|_| !is_apart) {
            Some((grid, _)) => {
                let (width, height) = size_of_view(&files[0], (width, height), grid)?;
                (width, height, grid.count())
            }
            None => (width, height, frames),
        };
        // Files can announce any number of frames; beyond what a recording has, none are listed.
        let are_countable = frames <= MOST_FRAMES;
        // Files of one frame each: their times come from every file's header.
        let each = is_apart && times.seconds.len() != frames;
        let known = if each { of_headers(&files, options, monitor)? } else { times };
        let mut times = if known.seconds.len() == frames { known } else { Times::default() };
        let timing = match of_files {
            Some(timing) => timing,
            None if are_countable => placed(&mut files, Some((frames, views)), options, monitor)?,
            None => Timing::even(1),
        };
        let is_used = timing.said.is_some();
        // Times that cannot be those of frames are reported in words, and nothing is derived from them.
        let odd = times.seconds.windows(2).position(|two| two[1] - two[0] < SHORTEST_S).filter(|_| are_countable);
        let doubt = odd.filter(|_| !is_used).map(|at| {
            let relation = match times.seconds[at + 1] - times.seconds[at] {
                0.0 => "have the same time in the header",
                ..0.0 => "are not in the order of their times in the header",
                _ => "are nearer in time, by the header, than those of any camera",
            };
            times.seconds.truncate(1);
            format!("frames {at} and {}, counted from 0, {relation}; no time but the first is used", at + 1)
        });
        let begin = times.seconds.first().copied().unwrap_or_default();
        let is_begun = times.is_absolute && !times.seconds.is_empty();
        let times = if times.seconds.len() == frames { times } else { Times::default() };
        let times_s: Vec<f64> = times.seconds.iter().map(|time| time - begin).collect();
        let rows_and_columns = timing.positions.rows_and_columns();
        let are_views = timing.positions.are_views();
        // Times that nobody asked for are mentioned: from the files, or else from the files' names.
        let of_names = || {
            let options = OpenOptions { times: Some(TimesChoice::Names), ..options.clone() };
            Timing::of(&mut files.clone(), None, &options, monitor).ok()
        };
        let of_headers = Positions::of_seconds(&times_s).filter(|_| !times_s.is_empty());
        // Views have places instead of times; times that were asked for precede those of headers and names.
        let positions = match of_headers {
            _ if are_views || timing.doubt.is_some() => None,
            _ if is_used => Some(timing.positions),
            None if is_apart => {
                let named = of_names().map(|timing| timing.positions);
                named.filter(|positions| positions.interval_s().is_some() || !positions.is_even())
            }
            of_headers => of_headers,
        };
        let doubts: Vec<String> = timing.doubt.into_iter().chain(doubt).collect();
        taken.extend(timing.said.into_iter().chain(doubts));
        let name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        taken.extend(options.mask.as_ref().map(|mask| format!("masked by {}", name(mask))));
        if !is_used && positions.as_ref().is_some_and(|positions| !positions.is_even()) {
            let source = if times_s.is_empty() { "names" } else { "header" };
            taken.push(format!(
                "frames that are not even in time are taken as even; --times {source} takes their times"
            ));
        }
        Ok(Self {
            name: source.name,
            kind: kind.to_owned(),
            files: files.len(),
            frames,
            width,
            height,
            samples,
            is_colour,
            binning,
            begins: is_begun.then(|| time_text(begin)),
            times_s,
            positions: positions.as_ref().map_or_else(Vec::new, Positions::since_first),
            are_times_used: is_used && !are_views,
            views: rows_and_columns.map(|(rows, columns)| [rows, columns]),
            interval_s: positions.and_then(|positions| positions.interval_s()),
            taken,
        })
    }

    /// Describes a burst that is open, of which nothing but its frames is known.
    pub fn of_burst(burst: &Burst, kind: &str) -> Self {
        let (width, height) = burst.size();
        Self {
            name: burst.name.clone(),
            kind: kind.to_owned(),
            frames: burst.len(),
            width,
            height,
            samples: "floats of 32 bit".to_owned(),
            binning: burst.binning,
            positions: burst.positions.list(),
            are_times_used: !burst.positions.is_even() && !burst.positions.are_views(),
            views: burst.positions.rows_and_columns().map(|(rows, columns)| [rows, columns]),
            interval_s: burst.positions.interval_s(),
            ..Self::default()
        }
    }

    /// Description for people, a line for each subject.
    pub fn text(&self) -> String {
        let files = match self.files {
            0 | 1 => String::new(),
            files => format!(" in {files} files"),
        };
        let plural = if self.frames == 1 { "" } else { "s" };
        let Self { name, frames, width, height, kind, samples, .. } = self;
        let colours = if self.is_colour { ", colours (luma is taken)" } else { "" };
        let mut text = format!(
            "{name}: {frames} frame{plural} of {width} × {height}{files}\n  file    {kind}, {samples}{colours}\n"
        );
        if self.binning > 1 {
            text += &format!("  pixels  each of {0}×{0} of the mosaic of colours\n", self.binning);
        }
        match self.views {
            Some([rows, columns]) => text += &format!("  views   {rows} rows × {columns} columns\n"),
            None => text += &format!("  times   {}\n", self.times()),
        }
        if let Some(rate) = self.rate() {
            text += &format!("  rate    {rate}\n");
        }
        self.taken.iter().for_each(|taken| text += &format!("  note    {taken}\n"));
        text
    }

    fn rate(&self) -> Option<String> {
        Positions::even(self.frames.min(2)).with_interval(self.interval_s).rate_text()
    }

    fn times(&self) -> String {
        let found = Positions::new(&self.positions).filter(|_| !self.positions.is_empty());
        let in_all_s = found.as_ref().zip(self.interval_s).map(|(found, interval)| found.span() * interval);
        // Times of names or of a list that the user chose need not be those of the headers.
        let are_headers = self.times_s.last().is_some_and(|last| {
            !self.are_times_used || in_all_s.is_none_or(|in_all| (in_all - last).abs() <= 1e-3 * in_all)
        });
        let begins = self.begins.as_ref().filter(|_| are_headers || self.times_s.is_empty());
        let begins = begins.map(|begins| format!("from {begins}"));
        let steps: Vec<f64> = self.times_s.windows(2).map(|two| two[1] - two[0]).collect();
        let of_files = self.times_s.last().filter(|_| are_headers && !steps.is_empty()).map(|last| {
            let range = steps.iter().fold((f64::MAX, f64::MIN), |(min, max), step| (min.min(*step), max.max(*step)));
            let mean = last / steps.len() as f64;
            format!("{last:.3} s in all, {mean:.6} s between frames ({:.6} … {:.6})", range.0, range.1)
        });
        let elsewhere = in_all_s.zip(self.interval_s).filter(|_| !are_headers);
        let elsewhere =
            elsewhere.map(|(in_all, interval)| format!("{in_all:.3} s in all, an interval of {interval:.6} s"));
        let gap = found.filter(|found| !found.is_even()).map(|found| found.unevenness());
        let parts: Vec<String> = [begins, of_files, elsewhere, gap].into_iter().flatten().collect();
        if parts.is_empty() { "not in the file".to_owned() } else { parts.join(", ") }
    }
}
