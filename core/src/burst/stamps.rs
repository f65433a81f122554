//! Positions of frames by their times: by stamps in lists, as robots and people write them, and in the names of files,
//! or by what the files hold.
//!
//! A stamp is a number or a date. Its unit stands in the heading of its column (`timestamp [ns]`, `time_s`), or is
//! guessed: from the size of a number that counts from 1970, and else from the distance of the frames.

use super::formats;
use super::layout::TimesChoice;
use super::options::OpenOptions;
use super::positions::Positions;
use super::times::{Times, seconds_of};
use crate::error::{Error, ErrorKind, Result};
use crate::files::read_bytes;
use crate::monitor::Monitor;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Value of a stamp in billionths of its unit, so that the nanoseconds of 1970 on keep their digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Stamp {
    value: i128,
    /// Whether it was a date, whose unit is a second.
    is_date: bool,
    /// Whether it was written without a fraction.
    is_whole: bool,
}

const BILLION: i128 = 1_000_000_000;
/// Largest magnitude of a number that is read as a stamp.
const LARGEST: f64 = 1e25;

impl Stamp {
    fn number(text: &str) -> Option<Self> {
        let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        if !is_digits(whole) || !is_digits(fraction) || whole.len() > 25 {
            // Powers of ten, such as 1.036224e-01.
            let value: f64 = text.parse().ok().filter(|value: &f64| value.abs() <= LARGEST)?;
            let is_whole = value.fract() == 0.0 && !text.contains('.');
            return Some(Self { value: (value * BILLION as f64).round() as i128, is_date: false, is_whole });
        }
        let whole: i128 = whole.parse().ok()?;
        let value = sign * (whole * BILLION + billionths(fraction));
        Some(Self { value, is_date: false, is_whole: fraction.is_empty() })
    }

    /// A date with its time, such as `2011-09-26 13:02:25.964389445`, `2011-09-26T13:02:25Z` or `2011:09:26 13:02:25`.
    fn date(text: &str) -> Option<Self> {
        let (text, fraction) = text.trim_end_matches('Z').split_once('.').unwrap_or((text, ""));
        let (date, time) = text.split_once(['T', ' '])?;
        let seconds = seconds_of(&format!("{}T{time}", date.replace([':', '/'], "-")))?;
        let is_digits = fraction.bytes().all(|byte| byte.is_ascii_digit());
        let value = seconds as i128 * BILLION + billionths(fraction);
        is_digits.then_some(Self { value, is_date: true, is_whole: fraction.is_empty() })
    }

    fn of(text: &str) -> Option<Self> {
        Self::number(text).or_else(|| Self::date(text))
    }
}

/// The first nine digits after a point.
fn billionths(fraction: &str) -> i128 {
    format!("{fraction:0<9}")[..9].parse().unwrap_or(0)
}

/// Unit of stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
    /// Positions in frame intervals, or numbers of frames.
    Frames,
}

impl Unit {
    /// Its name, and a billionth of it in seconds, or in frame intervals.
    fn record(self) -> (&'static str, f64) {
        match self {
            Self::Seconds => ("seconds", 1e-9),
            Self::Milliseconds => ("milliseconds", 1e-12),
            Self::Microseconds => ("microseconds", 1e-15),
            Self::Nanoseconds => ("nanoseconds", 1e-18),
            Self::Frames => ("numbers of frames", 1e-9),
        }
    }
}

/// Words of a heading of a column of times, besides those of units.
const TIME_WORDS: [&str; 6] = ["time", "times", "timestamp", "timestamps", "stamp", "date"];

fn words(heading: &str) -> impl Iterator<Item = String> {
    heading.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase)
}

fn unit_of(heading: &str) -> Option<Unit> {
    words(heading).find_map(|word| match &*word {
        "ns" | "nsec" | "nanoseconds" => Some(Unit::Nanoseconds),
        "us" | "µs" | "usec" | "microseconds" => Some(Unit::Microseconds),
        "ms" | "msec" | "milliseconds" => Some(Unit::Milliseconds),
        "s" | "sec" | "secs" | "seconds" => Some(Unit::Seconds),
        "frames" | "intervals" | "position" => Some(Unit::Frames),
        _ => None,
    })
}

fn is_of_times(heading: &str) -> bool {
    unit_of(heading).is_some() || words(heading).any(|word| TIME_WORDS.contains(&&*word))
}

const HEADED: &str = "as their heading says";

/// Stamps with their unit.
#[derive(Debug, Clone, PartialEq)]
struct Stamps {
    pub values: Vec<Stamp>,
    pub unit: Unit,
    /// How the unit is known, as a part of a sentence.
    pub known_by: &'static str,
}

impl Stamps {
    fn new(values: Vec<Stamp>, unit: Option<Unit>) -> Self {
        if let Some(unit) = unit.filter(|_| values.iter().all(|one| !one.is_date)) {
            return Self { values, unit, known_by: HEADED };
        }
        let (unit, known_by) = Self::guess(&values);
        Self { values, unit, known_by }
    }

    fn guess(values: &[Stamp]) -> (Unit, &'static str) {
        if values.iter().all(|one| one.is_date) {
            return (Unit::Seconds, "as dates");
        }
        let mut sizes: Vec<f64> = values.iter().map(|one| one.value as f64 / BILLION as f64).collect();
        sizes.sort_by(f64::total_cmp);
        let (least, most) = (sizes[0], sizes[sizes.len() - 1]);
        // Numbers that count from 1970, from about 1973 to 2286.
        let units = [Unit::Seconds, Unit::Milliseconds, Unit::Microseconds, Unit::Nanoseconds];
        let since_1970 = |from: f64| least >= from && most < 100.0 * from;
        if let Some((unit, _)) = units.iter().zip([1e8, 1e11, 1e14, 1e17]).find(|(_, from)| since_1970(*from)) {
            return (*unit, "by their size");
        }
        if values.iter().any(|one| !one.is_whole) {
            return (Unit::Seconds, "by their fractions");
        }
        let mut gaps: Vec<f64> = sizes.windows(2).map(|two| two[1] - two[0]).collect();
        gaps.sort_by(f64::total_cmp);
        let unit = match gaps.get(gaps.len() / 2).copied().unwrap_or(0.0) {
            2e6.. => Unit::Nanoseconds,
            2000.0.. => Unit::Microseconds,
            5.0.. => Unit::Milliseconds,
            _ => Unit::Frames,
        };
        (unit, "by the distance of the frames")
    }

    /// Times from the first stamp on: in seconds, or in frame intervals for [`Unit::Frames`].
    pub fn since_first(&self) -> Vec<f64> {
        let (_, unit) = self.unit.record();
        let first = self.values.first().map_or(0, |one| one.value);
        // Differences are exact; the one multiplication rounds.
        self.values.iter().map(|one| (one.value - first) as f64 * unit).collect()
    }
}

/// A list of times.
#[derive(Debug, Clone, PartialEq)]
struct List {
    /// The stamps, in the order of the list.
    pub stamps: Stamps,
    /// Line of each stamp, from 1.
    pub lines: Vec<usize>,
    /// Name of each frame, as the list writes it; empty for a list without names.
    pub names: Vec<String>,
}

/// Largest number of lines that are read.
const MAX_LINES: usize = 10_000_000;

fn fields(line: &str) -> Vec<&str> {
    let separated = |by: char| line.split(by).map(|field| field.trim().trim_matches('"')).collect();
    match [',', ';', '\t'].into_iter().find(|by| line.contains(*by)) {
        Some(by) => separated(by),
        // A date has a space within.
        None if Stamp::date(line).is_some() => vec![line],
        None => line.split_whitespace().map(|field| field.trim_matches('"')).collect(),
    }
}

/// Name of a file without its folder.
pub(super) fn base_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// Name of a file without folder and extension.
pub(super) fn stem(path: &str) -> &str {
    let name = base_name(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

impl List {
    /// Reads a list of one time a line, or of columns of which one has the times and one may have `frames`' names, with
    /// or without extension and folders. Lines that begin with `#` are comments; the last one before the first row,
    /// and a first line without a time, are headings if they have as many fields.
    ///
    /// # Errors
    /// The line, what is wrong in it and what would be right.
    pub fn read(text: &str, frames: &[String]) -> Result<Self, String> {
        let mut heading: Vec<&str> = Vec::new();
        let mut rows: Vec<(usize, Vec<&str>)> = Vec::new();
        for (line, text) in (1..).zip(text.trim_start_matches('\u{feff}').lines().take(MAX_LINES)) {
            let text = text.trim();
            let comment = text.strip_prefix('#');
            if text.is_empty() || (comment.is_some() && !rows.is_empty()) {
                continue;
            }
            let of_line = fields(comment.unwrap_or(text).trim());
            if comment.is_some() || (rows.is_empty() && !of_line.iter().any(|field| Stamp::of(field).is_some())) {
                heading = of_line;
            } else {
                rows.push((line, of_line));
            }
        }
        let Some((line, first)) = rows.first() else {
            return Err("it has no line with a time; write one time a line, or 'name,time'".to_owned());
        };
        if heading.len() != first.len() {
            heading.clear();
        }
        let known: HashSet<&str> = frames.iter().flat_map(|name| [base_name(name), stem(name)]).collect();
        let is_name = |field: &str| known.contains(base_name(field)) || known.contains(stem(field));
        let column = |is: &dyn Fn(&str) -> bool| {
            (0..first.len()).find(|at| rows.iter().any(|(_, row)| row.get(*at).is_some_and(|field| is(field))))
        };
        // Where the times are the names of the files, the column with an extension has the names.
        let looks_like_file = |field: &str| is_name(field) && Stamp::of(field).is_none();
        let names = column(&looks_like_file).or_else(|| (first.len() > 1).then(|| column(&is_name)).flatten());
        let stamped: Vec<usize> =
            (0..first.len()).filter(|at| Some(*at) != names && Stamp::of(first[*at]).is_some()).collect();
        let headed = stamped.iter().copied().find(|at| heading.get(*at).is_some_and(|heading| is_of_times(heading)));
        let times = match (headed, &stamped[..]) {
            (Some(at), _) => at,
            (None, [at]) => *at,
            (None, []) => return Err(format!("line {line} has no time; write one time a line, or 'name,time'")),
            (None, _) => {
                return Err(format!(
                    "line {line} has several numbers, and nothing says which is the time; write a heading such as 'name,time_s'"
                ));
            }
        };
        let (mut values, mut lines, mut of_rows) = (Vec::new(), Vec::new(), Vec::new());
        for (line, row) in &rows {
            let field = row.get(times).copied().unwrap_or_default();
            let stamp = Stamp::of(field).ok_or_else(|| {
                format!("line {line}: '{field}' is no time; write a number or a date such as 2021-03-01T22:00:00.5")
            })?;
            values.push(stamp);
            lines.push(*line);
            of_rows.extend(names.map(|at| row.get(at).copied().unwrap_or_default().to_owned()));
        }
        let unit = heading.get(times).and_then(|heading| unit_of(heading));
        Ok(Self { stamps: Stamps::new(values, unit), lines, names: of_rows })
    }
}

/// A run of digits in a name, with what follows a point where the whole part is long.
fn runs(name: &str) -> Vec<&str> {
    let mut runs: Vec<&str> = Vec::new();
    let mut rest = name;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        let whole = digits(&rest[start..]);
        let after = &rest[start + whole..];
        let fraction = after.strip_prefix('.').map_or(0, digits);
        let length = if fraction > 0 && whole > 4 { whole + 1 + fraction } else { whole };
        runs.push(&rest[start..start + length]);
        rest = &rest[start + length..];
    }
    runs
}

/// Date in the digits of a name: year, month, day, hour, minute, second, and what is left as a fraction.
fn date_in(runs: &[&str]) -> Option<Stamp> {
    const DATE_DIGITS: usize = 14;
    let from = runs.iter().position(|run| run.starts_with("19") || run.starts_with("20"))?;
    let lengths: Vec<usize> = runs[from..].iter().map(|run| run.len()).collect();
    let is_one = lengths[0] >= DATE_DIGITS;
    let is_parted = lengths[0] == 8 && lengths.get(1).is_some_and(|length| *length >= 6);
    let is_spelled = lengths[0] == 4 && lengths.len() >= 6 && lengths[1..5].iter().all(|length| *length == 2);
    if !(is_one || is_parted || is_spelled) {
        return None;
    }
    let digits: String = runs[from..].concat().chars().filter(char::is_ascii_digit).take(DATE_DIGITS + 9).collect();
    if digits.len() < DATE_DIGITS {
        return None;
    }
    let part = |range: std::ops::Range<usize>| &digits[range];
    let [year, month, day, hour, minute, second] = [0..4, 4..6, 6..8, 8..10, 10..12, 12..14].map(part);
    let fraction = part(DATE_DIGITS..digits.len());
    let text = format!("{year}-{month}-{day}T{hour}:{minute}:{second}.{fraction}");
    Stamp::date(&text)
}

/// Stamps in the `names` of frames: dates, or the numbers that differ from name to name, of several the longest ones.
///
/// # Errors
/// The first name without a stamp, and what would be right.
fn in_names(names: &[String]) -> Result<Stamps, String> {
    let found: Vec<Vec<&str>> = names.iter().map(|name| runs(stem(name))).collect();
    let dates: Option<Vec<Stamp>> = found.iter().map(|runs| date_in(runs)).collect();
    if let Some(dates) = dates.filter(|dates| !dates.is_empty()) {
        return Ok(Stamps::new(dates, None));
    }
    let count = found.iter().map(Vec::len).min().unwrap_or(0);
    // Counted from the end: what stands before may have more numbers in some names.
    let at = |runs: &[&str], from_end: usize| runs[runs.len() - 1 - from_end].to_owned();
    let differs = |from_end: &usize| {
        names.len() == 1 || found.windows(2).all(|two| at(&two[0], *from_end) != at(&two[1], *from_end))
    };
    let longest = |from_end: &usize| found.iter().map(|runs| at(runs, *from_end).len()).max();
    let chosen = (0..count).rev().filter(differs).max_by_key(longest);
    let Some(chosen) = chosen else {
        let odd = found.iter().position(|runs| runs.len() == count).unwrap_or(0);
        let name = names.get(odd).map_or("", |name| name);
        return Err(format!(
            "the name '{name}' has no time of its own; names such as 1305031102.175304.png or 20210301_220000_123.jpg have one"
        ));
    };
    let stamps = found.iter().map(|runs| Stamp::number(&at(runs, chosen)));
    let stamps = stamps.collect::<Option<Vec<Stamp>>>().ok_or("a number in a name is too long to be a time")?;
    Ok(Stamps::new(stamps, None))
}

/// Positions of frames, and what is to be said of them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Timing {
    pub positions: Positions,
    /// Source of the times and what was guessed; `None` for even ones.
    pub said: Option<String>,
}

/// Largest list of times, bytes.
const MAX_LIST_BYTES: u64 = 64 << 20;

/// Times that were found for frames, before it is known that they increase.
struct FoundTimes {
    /// From the first on, seconds or frame intervals.
    times: Vec<f64>,
    /// Whether they are positions as they are, in frame intervals.
    are_positions: bool,
    /// Whether their unit is a second.
    are_seconds: bool,
    /// Line of the list for each frame; empty for other sources.
    lines: Vec<usize>,
    /// File that an error is about.
    file: PathBuf,
    said: String,
}

impl Timing {
    pub fn even(frames: usize) -> Self {
        Self { positions: Positions::even(frames), said: None }
    }

    /// Positions of the `frames` frames of `files`, which are one file each or all in one, by the choice in `options`.
    /// Several files are brought into the order of their times.
    ///
    /// # Errors
    /// There is no such list, it has no time for a frame, files or names have none, or two are equal.
    pub fn of(files: &mut [PathBuf], frames: usize, options: &OpenOptions, monitor: &Monitor) -> Result<Self> {
        let choice = options.times.as_ref().filter(|choice| !matches!(choice, TimesChoice::Even | TimesChoice::Found));
        let Some(choice) = choice.filter(|_| frames > 1) else { return Ok(Self::even(frames)) };
        let found = FoundTimes::of(choice, files, frames, options, monitor)?;
        let mut order: Vec<usize> = (0..frames).collect();
        if files.len() == frames {
            order.sort_by(|a, b| found.times[*a].total_cmp(&found.times[*b]));
        }
        let times: Vec<f64> = order.iter().map(|t| found.times[*t]).collect();
        let positions = if found.are_positions { Positions::new(&times) } else { Positions::of_seconds(&times) };
        let Some(positions) = positions else {
            let wrong = times.windows(2).position(|two| two[1].total_cmp(&two[0]).is_le()).unwrap_or(0);
            return Err(found.not_increasing(
                [order[wrong], order[wrong + 1]],
                times[wrong + 1] == times[wrong],
                files,
            ));
        };
        let interval_s = positions.interval_s().filter(|_| found.are_seconds);
        let positions = positions.with_interval(interval_s);
        let mut said = format!("{}; {}", found.said, positions.unevenness());
        if !order.is_sorted() {
            let sorted: Vec<PathBuf> = order.iter().map(|t| files[*t].clone()).collect();
            files.clone_from_slice(&sorted);
            said += "; the frames are in the order of their times, which is not that of their names";
        }
        Ok(Self { positions, said: Some(said) })
    }
}

impl FoundTimes {
    fn of(
        choice: &TimesChoice,
        files: &[PathBuf],
        frames: usize,
        options: &OpenOptions,
        monitor: &Monitor,
    ) -> Result<Self> {
        let names: Vec<String> = files.iter().map(|file| base_name(&file.to_string_lossy()).to_owned()).collect();
        let first = files.first().cloned().unwrap_or_default();
        let wrong = |problem: String, remedy: &str, file: &Path| {
            Error::new(ErrorKind::Mismatch, format!("times: {problem}"), remedy).about(file)
        };
        match choice {
            TimesChoice::List(path) => {
                let path = options.list_of_times(files).unwrap_or_else(|| path.clone());
                let list = read_list(&path, &names)?;
                let rows = rows_of(&list, &names, frames).map_err(|(problem, remedy)| wrong(problem, remedy, &path))?;
                let values = rows.iter().map(|row| list.stamps.values[*row]).collect();
                let lines = rows.iter().map(|row| list.lines[*row]).collect();
                let source = format!("of {}", base_name(&path.to_string_lossy()));
                Ok(Self::of_stamps(&Stamps { values, ..list.stamps }, lines, &source, path))
            }
            TimesChoice::Names if files.len() == frames => {
                let stamps = in_names(&names).map_err(|problem| wrong(problem, "give a list of times", &first))?;
                Ok(Self::of_stamps(&stamps, Vec::new(), "in the names", first))
            }
            TimesChoice::Names => {
                let problem = format!("this one file holds all {frames} frames, so its name says no times");
                Err(wrong(problem, "give a list of times", &first))
            }
            TimesChoice::Header | TimesChoice::Even | TimesChoice::Found => {
                let seconds = of_headers(files, options, monitor)?.seconds;
                if seconds.len() != frames {
                    let problem = match files.get(seconds.len()).filter(|_| files.len() == frames) {
                        Some(file) => format!("{} does not say when it was taken", file.display()),
                        None => format!("this file holds {} times for its {frames} frames", seconds.len()),
                    };
                    return Err(wrong(problem, "give a list of times, or names where these have stamps", &first));
                }
                let start = seconds.first().copied().unwrap_or_default();
                let times = seconds.iter().map(|time| time - start).collect();
                let (lines, said) = (Vec::new(), "the times are those that the files hold".to_owned());
                Ok(Self { times, are_positions: false, are_seconds: true, lines, file: first, said })
            }
        }
    }

    fn of_stamps(stamps: &Stamps, lines: Vec<usize>, source: &str, file: PathBuf) -> Self {
        let are_frames = stamps.unit == Unit::Frames;
        let (times, are_positions) = (stamps.since_first(), are_frames && stamps.known_by == HEADED);
        let said = format!("the times are those {source}, {} {}", stamps.unit.record().0, stamps.known_by);
        Self { times, are_positions, are_seconds: !are_frames, lines, file, said }
    }

    fn not_increasing(&self, [a, b]: [usize; 2], are_equal: bool, files: &[PathBuf]) -> Error {
        let frame = |t: usize| match files.get(t).filter(|_| files.len() == self.times.len()) {
            Some(file) => base_name(&file.to_string_lossy()).to_owned(),
            None => format!("frame {t}"),
        };
        let lines = match (self.lines.get(a), self.lines.get(b)) {
            (Some(a), Some(b)) => format!("lines {a} and {b}: "),
            _ => String::new(),
        };
        let relation = if are_equal { "have the same time" } else { "are not in the order of their times" };
        let problem = format!("times: {lines}{} and {} {relation}", frame(a), frame(b));
        let remedy = "each frame needs a time after that of the one before, to a fraction of the frame interval";
        Error::new(ErrorKind::Mismatch, problem, remedy).about(&self.file)
    }
}

fn read_list(path: &Path, names: &[String]) -> Result<List> {
    let metadata = std::fs::metadata(path).map_err(|e| Error::from_io(path, &e))?;
    if !metadata.is_file() {
        return Err(Error::not_a_file(path));
    }
    if metadata.len() > MAX_LIST_BYTES {
        let found = format!("it has {} bytes", metadata.len());
        return Err(Error::too_large(path, found, format!("{MAX_LIST_BYTES} bytes"), "give the frames' lines alone"));
    }
    let bytes = read_bytes(path, MAX_LIST_BYTES).map_err(|e| Error::from_io(path, &e))?;
    let wrong = |problem| Error::new(ErrorKind::Unsupported, format!("times: {problem}"), "").about(path);
    List::read(&String::from_utf8_lossy(&bytes), names).map_err(wrong)
}

/// Row of `list` for each of the frames: that of its name, or in their order. The error has a remedy.
fn rows_of(list: &List, names: &[String], frames: usize) -> Result<Vec<usize>, (String, &'static str)> {
    if list.names.is_empty() || names.len() != frames {
        let count = list.lines.len();
        let problem = || format!("the list has {count} times for {frames} frames");
        let remedy = "give one line for each frame, or lines 'name,time', of which those of the frames are taken";
        return if count == frames { Ok((0..count).collect()) } else { Err((problem(), remedy)) };
    }
    let mut by_name: HashMap<&str, usize> = HashMap::new();
    for (row, name) in list.names.iter().enumerate() {
        by_name.entry(base_name(name)).or_insert(row);
        by_name.entry(stem(name)).or_insert(row);
    }
    let row = |name: &String| by_name.get(&**name).or_else(|| by_name.get(stem(name))).copied();
    let missing = |name: &String| (format!("the list has no line for {name}"), "add one, or open other frames");
    names.iter().map(|name| row(name).ok_or_else(|| missing(name))).collect()
}

/// Times that the files of frames hold; those before the first that holds none.
pub(super) fn of_headers(files: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Result<Times> {
    if let [file] = files {
        return formats::times(file, options, monitor);
    }
    let mut all = Times { seconds: Vec::with_capacity(files.len()), is_absolute: true };
    for file in files {
        monitor.check()?;
        let times = formats::times(file, options, monitor)?;
        let Some(time) = times.seconds.first().filter(|_| times.is_absolute) else { break };
        all.seconds.push(*time);
    }
    Ok(all)
}
