//! Positions of frames by their times: by stamps in lists and in names of files, or by what the files hold.
//!
//! A name has a date or the seconds since 1970, which digits behind may part further: a fraction, or whole milli-,
//! micro- or nanoseconds with or without leading zeros. Numbers that count up by one are counters, never fractions.

use super::positions::{Positions, unevenness};
use super::times::{
    HEADED, List, PARTS, Stamp, Stamps, Times, Unit, Written, base_name, digit_runs, likeness, parts, seconds_of, stem,
};
use super::{formats, layout::TimesChoice, options::OpenOptions};
use crate::error::{Error, ErrorKind, Result};
use crate::files::{of_utf16, read_bytes};
use crate::monitor::Monitor;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::{cmp::Ordering, ops::Range};

#[derive(Debug, Clone, Copy)]
struct Run<'a> {
    before: &'a str,
    digits: &'a str,
    after: &'a str,
}

fn runs(name: &str) -> Vec<Run<'_>> {
    let runs = digit_runs(name);
    let run = |at: usize| {
        let Range { start, end } = runs[at];
        let from = if at > 0 { runs[at - 1].end } else { 0 };
        let to = runs.get(at + 1).map_or(name.len(), |next| next.start);
        Run { before: &name[from..start], digits: &name[start..end], after: &name[end..to] }
    };
    (0..runs.len()).map(run).collect()
}

/// The whole seconds of a name.
#[derive(Debug, Clone, Copy)]
struct Seconds<'a> {
    /// Since 1970.
    value: i128,
    is_date: bool,
    /// Digits that follow at once.
    rest: &'a str,
    /// Numbers of the first run with a part of them, and of the one behind the last.
    runs: (usize, usize),
}

/// Date in the digits of a name: year, month, day, hour, minute, second; or the ten digits of the seconds since 1970.
fn seconds_in<'a>(runs: &[Run<'a>]) -> Option<Seconds<'a>> {
    const DATE_DIGITS: usize = 14;
    let from = |first: usize| {
        // Joined or parted: 20210301220000, 20210301_220000, 2021-03-01-22-00-00.
        let lengths: Vec<usize> = runs[first..].iter().map(|run| run.digits.len()).collect();
        let (day_runs, in_day) = match lengths[..] {
            [length, ..] if length >= DATE_DIGITS => (0, 0),
            [8, ..] => (1, 8),
            [4, 2, 2, ..] => (3, 8),
            _ => return None,
        };
        let time_runs = match lengths[day_runs..] {
            [length, ..] if length + in_day >= DATE_DIGITS => 1,
            [2, 2, length, ..] if length >= 2 && in_day > 0 => 3,
            _ => return None,
        };
        let next = first + day_runs + time_runs;
        let digits: String = runs[first..next].iter().map(|run| run.digits).collect();
        let last = runs[next - 1].digits;
        let part = |range: Range<usize>| &digits[range];
        let [year, month, day, hour, minute, second] = [0..4, 4..6, 6..8, 8..10, 10..12, 12..14].map(part);
        let value = seconds_of(&format!("{year}-{month}-{day}T{hour}:{minute}:{second}"))? as i128;
        let rest = &last[last.len() - (digits.len() - DATE_DIGITS)..];
        // Other centuries, and more than nine digits behind, have another meaning.
        let is_usual = (year.starts_with("19") || year.starts_with("20")) && rest.len() <= 9;
        is_usual.then_some(Seconds { value, is_date: true, rest, runs: (first, next) })
    };
    let since_1970 = |at: usize| {
        // Ten digits: from 2001 to 2286.
        let digits = runs[at].digits;
        let value = digits.parse().ok().filter(|_| digits.len() == 10 && !digits.starts_with('0'))?;
        Some(Seconds { value, is_date: false, rest: "", runs: (at, at + 1) })
    };
    (0..runs.len()).find_map(from).or_else(|| (0..runs.len()).find_map(since_1970))
}

/// Whether `numbers` beside whole `seconds` count up by one: from name to name, or in each second from 0 or 1 on.
fn are_counters(seconds: &[i128], numbers: &[i128]) -> bool {
    let mut each: BTreeMap<i128, Vec<i128>> = BTreeMap::new();
    seconds.iter().zip(numbers).for_each(|(second, number)| each.entry(*second).or_default().push(*number));
    each.values_mut().for_each(|numbers| numbers.sort_unstable());
    let counts = |numbers: &[i128]| numbers.windows(2).all(|two| two[1] == two[0] + 1);
    let all: Vec<i128> = each.values().flatten().copied().collect();
    numbers.len() > 1 && (counts(&all) || each.values().all(|of| of[0] <= 1 && counts(of)))
}

/// Times in [`PARTS`] of a second: `digits` as a fraction, or as milli-, micro- or nanoseconds; `None` for counters.
fn with_fractions(seconds: &[i128], digits: &[&str], separator: &str) -> Option<Vec<i128>> {
    let longest = digits.iter().map(|digits| digits.len()).max().filter(|longest| (1..=15).contains(longest))?;
    let is_point = is_point(separator);
    let numbers: Vec<i128> = digits.iter().map(|digits| digits.parse().unwrap_or(0)).collect();
    let range = numbers.iter().max()? - numbers.iter().min()?;
    // Behind _ or -, few digits or numbers close together are counters, not fractions.
    let is_short = longest < 3 || range <= 2 * numbers.len() as i128 + 8;
    if are_counters(seconds, &numbers) || (!is_point && !separator.is_empty() && is_short) {
        return None;
    }
    let unit = match longest {
        ..=3 => PARTS / 1000,
        4..=6 => PARTS / 1_000_000,
        _ => PARTS / 1_000_000_000,
    };
    let times = |part: &dyn Fn(usize) -> i128| (0..digits.len()).map(|t| seconds[t] * PARTS + part(t)).collect();
    let (fractions, wholes): (Vec<i128>, Vec<i128>) = (times(&|t| parts(digits[t])), times(&|t| numbers[t] * unit));
    let are_of_one_length = digits.iter().all(|digits| digits.len() == longest);
    let any = |is: fn(&str) -> bool| digits.iter().any(|digits| digits.len() > 1 && is(digits));
    let (is_padded, ends_with_0) = (any(|digits| digits.starts_with('0')), any(|digits| digits.ends_with('0')));
    // Leading zeros are those of fractions; else length, point and last digits decide.
    let are_fractions = match () {
        () if longest > 9 || is_padded => true,
        () if are_of_one_length => is_point || longest % 3 == 0,
        // Printed fractions do not end with a zero.
        () if !is_point || ends_with_0 => false,
        () => unevenness(fractions.clone()) <= unevenness(wholes.clone()),
    };
    Some(if are_fractions { fractions } else { wholes })
}

/// Stamps in `names`: dates or seconds with fractions, or the longest numbers that differ; an error names one name.
fn in_names(names: &[String]) -> Result<Stamps, String> {
    let found: Vec<Vec<Run<'_>>> = names.iter().map(|name| runs(stem(name))).collect();
    let stamps = |values: Vec<i128>, known_by| {
        let stamp = |value| Stamp { value, written: Written::Number(0) };
        Stamps { values: values.into_iter().map(stamp).collect(), unit: Unit::Seconds, known_by }
    };
    let are_different = |values: &[i128]| values.iter().collect::<HashSet<_>>().len() == values.len();
    let seconds: Vec<Seconds<'_>> = found.iter().map_while(|runs| seconds_in(runs)).collect();
    let are_dates = seconds.iter().all(|one| one.is_date);
    if seconds.len() == names.len() && !names.is_empty() && seconds.iter().all(|one| one.is_date == are_dates) {
        let whole: Vec<i128> = seconds.iter().map(|one| one.value).collect();
        let known_by = if are_dates { "as dates" } else { "since 1970" };
        let next = |t: usize| found[t].get(seconds[t].runs.1);
        // The runs behind, which some names may lack, and what parts them from the seconds.
        let separator = (0..names.len()).find_map(next).map_or("", |run| run.before);
        let behind: Vec<&str> = (0..names.len()).map(|t| next(t).map_or("", |run| run.digits)).collect();
        let are_joined = (0..names.len()).all(|t| next(t).is_none_or(|run| run.before == separator));
        let are_behind = are_joined
            && match separator {
                "." | "," => true,
                "_" | "-" => behind.iter().all(|digits| !digits.is_empty()),
                _ => false,
            };
        let rests: Vec<&str> = seconds.iter().map(|one| one.rest).collect();
        let times = match rests.iter().any(|rest| !rest.is_empty()) {
            true => with_fractions(&whole, &rests, ""),
            false => are_behind.then(|| with_fractions(&whole, &behind, separator)).flatten(),
        };
        let clock = |second: &i128| {
            let of_day = second % 86_400;
            of_day / 3600 * 10_000 + of_day % 3600 / 60 * 100 + of_day % 60
        };
        let clocks: Vec<i128> = whole.iter().map(clock).collect();
        // Times of day that count from the first second on are counters of six digits.
        let is_early = clocks.iter().all(|clock| *clock <= names.len() as i128);
        let is_counted = are_dates && times.is_none() && is_early && are_counters(&vec![0; names.len()], &clocks);
        // Stamps must tell all frames apart: fractions, then whole seconds, then counters are tried.
        match times {
            Some(times) if are_different(&times) => return Ok(stamps(times, known_by)),
            _ if are_different(&whole) && are_dates && !is_counted => {
                return Ok(stamps(whole.iter().map(|second| second * PARTS).collect(), known_by));
            }
            _ if are_dates => return counters(names, &found, &seconds, is_counted),
            _ => {}
        }
    }
    let found = with_whole_numbers(found);
    if let Some(times) = small_seconds(&found).filter(|times| are_different(times)) {
        return Ok(stamps(times, "and fractions of them"));
    }
    let count = found.iter().map(Vec::len).min().unwrap_or(0);
    // Counted from the end: what stands before may have more numbers in some names.
    let at = |runs: &[Run<'_>], from_end: usize| runs[runs.len() - 1 - from_end].digits.to_owned();
    let differs = |from_end: &usize| {
        names.len() == 1 || found.windows(2).all(|two| at(&two[0], *from_end) != at(&two[1], *from_end))
    };
    let longest = |from_end: &usize| found.iter().map(|runs| at(runs, *from_end).len()).max();
    // Of the numbers that differ from name to name the longest; of equally long ones the last.
    let chosen = (0..count).rev().filter(differs).max_by_key(longest);
    let Some(chosen) = chosen else {
        let odd = found.iter().position(|runs| runs.len() == count).unwrap_or(0);
        let name = names.get(odd).map_or("", |name| name);
        return Err(format!(
            "the name '{name}' has no time of its own; names such as 1305031102.175304.png or 20210301_220000_123.jpg have one"
        ));
    };
    let is_decimal = chosen + 1 < count && found.iter().all(|runs| is_point(runs[runs.len() - 1 - chosen].before));
    if is_decimal && found.windows(2).any(|two| at(&two[0], chosen + 1) != at(&two[1], chosen + 1)) {
        let problem = "numbers with a point in names, such as '{}', may be seconds and fractions, or two counters; seconds end with an s, as 0.2s.png, or are in a list";
        return Err(problem.replace("{}", &names[0]));
    }
    let stamps = found.iter().map(|runs| Stamp::number(&at(runs, chosen)));
    Stamps::new(stamps.collect::<Option<Vec<Stamp>>>().ok_or("a number in a name is too long to be a time")?, None)
}

fn is_point(separator: &str) -> bool {
    separator == "." || separator == ","
}

/// Runs of names; where the others end with a fraction, names without one get an empty fraction.
fn with_whole_numbers(mut found: Vec<Vec<Run<'_>>>) -> Vec<Vec<Run<'_>>> {
    let most = found.iter().map(Vec::len).max().unwrap_or(0);
    let has_fraction = |runs: &Vec<Run<'_>>| runs.len() == most && most > 1 && is_point(runs[most - 1].before);
    if found.iter().all(|runs| has_fraction(runs) || runs.len() + 1 == most) {
        let short = found.iter_mut().filter(|runs| runs.len() < most);
        short.for_each(|runs| runs.push(Run { before: ".", digits: "", after: "" }));
    }
    found
}

/// Times of names with seconds from an own start and fractions, such as `12_9658000`; `None` if not surely so.
fn small_seconds(found: &[Vec<Run<'_>>]) -> Option<Vec<i128>> {
    let count = found.iter().map(Vec::len).min().unwrap_or(0);
    let of = |from_end: usize| {
        let run = |runs: &Vec<Run<'_>>, back: usize| runs.get(runs.len() - 1 - back).map(|run| run.digits.to_owned());
        let separator = found[0][found[0].len() - 1 - from_end].before;
        let is_joined = found.iter().all(|runs| runs[runs.len() - 1 - from_end].before == separator);
        let digits: Vec<String> = found.iter().map(|runs| run(runs, from_end)).collect::<Option<_>>()?;
        let digits: Vec<&str> = digits.iter().map(String::as_str).collect();
        let short = |digits: String| digits.parse::<i128>().ok().filter(|_| digits.len() <= 10);
        let seconds: Vec<i128> = found.iter().map(|runs| short(run(runs, from_end + 1)?)).collect::<Option<_>>()?;
        let ends_with_s = |runs: &Vec<Run<'_>>| {
            let after = runs[runs.len() - 1 - from_end].after;
            matches!(after.split(|c: char| !c.is_alphabetic()).next(), Some("s" | "sec"))
        };
        let printed = || seconds.iter().zip(&digits).map(|(second, digits)| second * PARTS + parts(digits)).collect();
        let are_printed = is_point(separator) && found.iter().all(ends_with_s);
        let times = if are_printed { Some(printed()) } else { with_fractions(&seconds, &digits, separator) };
        let times: Vec<i128> = times.filter(|_| is_joined)?;
        let mut sorted: Vec<(i128, i128)> = seconds.iter().zip(&times).map(|(second, time)| (*second, *time)).collect();
        sorted.sort_unstable();
        let turns = |two: &[(i128, i128)]| two[0].0 < two[1].0 && two[1].1 % PARTS < two[0].1 % PARTS;
        let different = seconds.iter().collect::<HashSet<_>>().len();
        let is_shared = different > 1 && different < seconds.len();
        let are_seconds = match separator {
            "." | "," => true,
            // A number that turns over where the other one rises.
            "_" | "-" => is_shared && digits.iter().any(|digits| digits.len() > 6) && sorted.windows(2).any(turns),
            _ => false,
        };
        // Times closer than the frames of any camera are none.
        let gap = sorted.windows(2).map(|two| two[1].1 - two[0].1).min().unwrap_or(0);
        (are_seconds && gap as f64 >= SHORTEST_S * PARTS as f64).then_some(times)
    };
    (0..count.saturating_sub(1)).find_map(of)
}

/// Counters of names with equal dates, as numbers of frames. `is_in_day` where they look like times of day.
fn counters(names: &[String], runs: &[Vec<Run<'_>>], dates: &[Seconds<'_>], is_in_day: bool) -> Result<Stamps, String> {
    let count =
        |t: usize, at: isize| runs[t].get(usize::try_from(dates[t].runs.1 as isize + at).ok()?)?.digits.parse().ok();
    let most = runs.iter().map(Vec::len).max().unwrap_or(0) as isize;
    let places = (0..most).rev().chain((-most..0).filter(|at| !is_in_day || *at == -1));
    let numbers = |at: isize| (0..names.len()).map(|t| count(t, at)).collect::<Option<Vec<i128>>>();
    let is_in_order = |numbers: &Vec<i128>| {
        let mut order: Vec<usize> = (0..names.len()).collect();
        order.sort_by_key(|t| numbers[*t]);
        let gaps: Vec<i128> = order.windows(2).map(|two| numbers[two[1]] - numbers[two[0]]).collect();
        let is_late = order.windows(2).any(|two| dates[two[1]].value < dates[two[0]].value);
        // Counters rise by about one a frame, and never against the dates.
        gaps.iter().all(|gap| *gap > 0) && gaps.iter().sum::<i128>() <= 2 * names.len() as i128 + 8 && !is_late
    };
    let numbers = places.filter_map(numbers).find(is_in_order).ok_or(
        "names have the same time, to the digits that they have, and no counter tells them apart in the order of their times",
    )?;
    let values = numbers.into_iter().map(|number| Stamp { value: number * PARTS, written: Written::Number(0) });
    Ok(Stamps { values: values.collect(), unit: Unit::Frames, known_by: "by their counters" })
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Timing {
    pub positions: Positions,
    /// Time of each frame on the clock of its stamps, seconds; empty where only intervals or nothing is known.
    pub seconds: Vec<f64>,
    /// Source of the times and what was guessed; `None` for even ones.
    pub said: Option<String>,
    /// A note that the order of even frames contradicts the times that their names or files have.
    pub doubt: Option<String>,
}

const MAX_LIST_BYTES: u64 = 64 << 20;
/// Shortest frame interval that is taken for one, seconds. Cameras of more frames a second are triggered by a list.
pub(super) const SHORTEST_S: f64 = 5e-6;

struct FoundTimes {
    times: Source,
    /// Line of the list for each frame; empty for other sources.
    lines: Vec<usize>,
    file: PathBuf,
    said: String,
}

enum Source {
    Stamps(Stamps),
    Headers(Vec<f64>),
}

impl Source {
    /// Times of some frames from the first of these on: seconds or frame intervals.
    fn since_first(&self, frames: &[usize]) -> Vec<f64> {
        match self {
            Self::Stamps(stamps) => stamps.since_first(frames),
            Self::Headers(seconds) => frames.iter().map(|t| seconds[*t] - seconds[frames[0]]).collect(),
        }
    }

    fn seconds(&self, frames: &[usize]) -> Vec<f64> {
        let second = |t: &usize| match self {
            Self::Stamps(stamps) => stamps.seconds(*t),
            Self::Headers(seconds) => seconds[*t],
        };
        frames.iter().map(second).collect()
    }

    fn order(&self) -> Vec<usize> {
        match self {
            Self::Stamps(stamps) => {
                sorted(stamps.values.len(), |a, b| stamps.values[a].value.cmp(&stamps.values[b].value))
            }
            Self::Headers(seconds) => sorted(seconds.len(), |a, b| seconds[a].total_cmp(&seconds[b])),
        }
    }
}

fn sorted(count: usize, compared: impl Fn(usize, usize) -> Ordering) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| compared(*a, *b));
    order
}

/// The choice of times in `options` that names, files or lists say.
fn choice_of(options: &OpenOptions) -> Option<&TimesChoice> {
    options.times.as_ref().filter(|choice| !matches!(choice, TimesChoice::Even | TimesChoice::Found))
}

impl Timing {
    pub fn even(frames: usize) -> Self {
        Self::at(Positions::even(frames))
    }

    pub fn at(positions: Positions) -> Self {
        Self { positions, seconds: Vec::new(), said: None, doubt: None }
    }

    /// Positions of the frames of `files`, by the choice in `options`: one each, of which those to be taken stay, in
    /// the order of their times, or `in_one` file, taken already. An error if a time is missing, equal or too near.
    pub fn of(
        files: &mut Vec<PathBuf>,
        in_one: Option<usize>,
        options: &OpenOptions,
        monitor: &Monitor,
    ) -> Result<Self> {
        let frames = in_one.unwrap_or(files.len());
        let folder = files.first().and_then(|file| file.parent()).unwrap_or(Path::new("")).to_owned();
        let part = options.take.filter(|_| in_one.is_none());
        let Some(choice) = choice_of(options).filter(|_| frames > 1) else {
            if part.is_some() {
                *files = options.taken(&folder, std::mem::take(files), (1, 1))?;
            }
            let doubt = in_one.is_none().then(|| doubt(files, options, monitor)).flatten();
            return Ok(Self { doubt, ..Self::even(files.len().max(in_one.unwrap_or(0))) });
        };
        let found = match FoundTimes::of(choice, files, frames, options, monitor) {
            // Only the part has times.
            Err(_) if part.is_some() => {
                *files = options.taken(&folder, std::mem::take(files), (1, 1))?;
                return Self::of(files, None, &OpenOptions { take: None, ..options.clone() }, monitor);
            }
            found => found?,
        };
        // A part is counted in the order of the times, not of the names.
        let whole = if in_one.is_some() { (0..frames).collect() } else { found.times.order() };
        let order = if part.is_some() { &whole[options.taken_of(&folder, frames, (1, 1))?] } else { &whole[..] };
        let times = found.times.since_first(order);
        let are_frames = matches!(&found.times, Source::Stamps(stamps) if stamps.unit == Unit::Frames);
        let are_positions = matches!(&found.times, Source::Stamps(stamps) if are_frames && stamps.known_by == HEADED);
        let positions = if are_positions { Positions::new(&times) } else { Positions::of_seconds(&times) };
        let Some(positions) = positions else {
            let gap = |t: &usize| times[t + 1] - times[*t];
            let wrong = (0..times.len() - 1).min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(0);
            let frames = [order[wrong], order[wrong + 1]];
            return Err(found.not_increasing(frames, gap(&wrong), if in_one.is_some() { &[] } else { files }));
        };
        let interval_s = positions.interval_s().filter(|_| !are_frames);
        if let Some(interval) = interval_s.filter(|interval| *interval < SHORTEST_S) {
            let problem = format!("times: frames would be {interval:e} s apart; {}", found.said);
            let remedy = "give a list whose heading names their unit, such as time_ms, or frames for numbers of frames";
            return Err(Error::new(ErrorKind::Mismatch, problem, remedy).about(&found.file));
        }
        let positions = positions.with_interval(interval_s);
        let mut said = format!("{}; {}", found.said, positions.unevenness());
        if in_one.is_none() {
            if !whole.is_sorted() {
                said += "; the frames are in the order of their times, which is not that of their names";
            }
            *files = order.iter().map(|t| files[*t].clone()).collect();
        }
        let seconds = if are_frames { Vec::new() } else { found.times.seconds(order) };
        Ok(Self { positions, seconds, said: Some(said), doubt: None })
    }
}

pub(super) fn in_order_of_times(files: Vec<PathBuf>, options: &OpenOptions) -> Vec<PathBuf> {
    let found = choice_of(options)
        .and_then(|choice| FoundTimes::of(choice, &files, files.len(), options, &Monitor::default()).ok());
    match found {
        Some(found) => found.times.order().into_iter().map(|t| files[t].clone()).collect(),
        None => files,
    }
}

/// A note on `files`, one a frame, that are taken as even, and whose names or headers have times in another order.
fn doubt(files: &[PathBuf], options: &OpenOptions, monitor: &Monitor) -> Option<String> {
    if options.times.is_some() || options.views.is_some() || files.len() < 2 {
        return None;
    }
    let said = |order: Vec<usize>, of: &str, choice: &str| {
        let at = order.windows(2).position(|two| two[1] < two[0])?;
        let [later, earlier] = [order[at], order[at + 1]].map(|t| base_name(&files[t].to_string_lossy()).to_owned());
        Some(format!(
            "the order of the frames is not that of the times in their {of}: {earlier} stands before {later} and is later; \
             --times {choice} takes them in the order of their times"
        ))
    };
    let names: Vec<String> = files.iter().map(|file| base_name(&file.to_string_lossy()).to_owned()).collect();
    let of_names = in_names(&names).ok().filter(Stamps::are_sure).map(Source::Stamps);
    of_names.and_then(|times| said(times.order(), "names", "names")).or_else(|| {
        let seconds = of_headers(files, options, monitor).ok()?.seconds;
        (seconds.len() == files.len()).then(|| said(Source::Headers(seconds).order(), "headers", "header")).flatten()
    })
}

impl FoundTimes {
    fn of(
        choice: &TimesChoice,
        files: &[PathBuf],
        frames: usize,
        options: &OpenOptions,
        monitor: &Monitor,
    ) -> Result<Self> {
        let absolute = |file: &PathBuf| std::path::absolute(file).unwrap_or_else(|_| file.clone());
        let paths: Vec<String> = files.iter().map(|file| absolute(file).to_string_lossy().into_owned()).collect();
        let first = files.first().cloned().unwrap_or_default();
        let wrong = |problem: String, remedy: &str, file: &Path| {
            Error::new(ErrorKind::Mismatch, format!("times: {problem}"), remedy).about(file)
        };
        let of_stamps = |stamps: Stamps, lines, source: String, file| {
            let said = format!("the times are those {source}, {} {}", stamps.unit.name(), stamps.known_by);
            Self { times: Source::Stamps(stamps), lines, file, said }
        };
        match choice {
            TimesChoice::List(path) => {
                let path = options.list_of_times(files).unwrap_or_else(|| path.clone());
                let list = read_list(&path, &paths)?;
                // In one file the part is taken already, and the list may be that of the whole.
                let part = options.take.filter(|_| files.len() != frames);
                let rows = rows_of(&list, &paths, (frames, part.map(|part| part.start..part.end)));
                let rows = rows.map_err(|(problem, remedy)| wrong(problem, remedy, &path))?;
                let values = rows.iter().map(|row| list.stamps.values[*row]).collect();
                let lines = rows.iter().map(|row| list.lines[*row]).collect();
                let source = format!("of {}", base_name(&path.to_string_lossy()));
                Ok(of_stamps(Stamps { values, ..list.stamps }, lines, source, path))
            }
            TimesChoice::Names if files.len() == frames => {
                let names: Vec<String> = paths.iter().map(|path| base_name(path).to_owned()).collect();
                let stamps = in_names(&names).map_err(|problem| wrong(problem, "give a list of times", &first))?;
                Ok(of_stamps(stamps, Vec::new(), "in the names".to_owned(), first))
            }
            TimesChoice::Names => {
                let problem = format!("this one file holds all {frames} frames, so its name says no times");
                Err(wrong(problem, "give a list of times", &first))
            }
            // Even and found times never come here: `choice_of` leaves them out.
            TimesChoice::Header | TimesChoice::Even | TimesChoice::Found => {
                let seconds = of_headers(files, options, monitor)?.seconds;
                if seconds.len() != frames {
                    let problem = match files.get(seconds.len()).filter(|_| files.len() == frames) {
                        Some(file) => format!("{} does not say when it was taken", file.display()),
                        None => format!("this file holds {} times for its {frames} frames", seconds.len()),
                    };
                    return Err(wrong(problem, "give a list of times, or names where these have stamps", &first));
                }
                let said = "the times are those that the files hold".to_owned();
                Ok(Self { times: Source::Headers(seconds), lines: Vec::new(), file: first, said })
            }
        }
    }

    fn not_increasing(&self, [a, b]: [usize; 2], gap: f64, files: &[PathBuf]) -> Error {
        let frame = |t: usize| match files.get(t) {
            Some(file) => base_name(&file.to_string_lossy()).to_owned(),
            None => format!("frame {t}"),
        };
        let lines = self.lines.get(a).zip(self.lines.get(b));
        let lines = lines.map_or(String::new(), |(a, b)| format!("lines {a} and {b}: "));
        let relation = match gap {
            0.0 => "have the same time",
            0.0.. => "have nearly the same time",
            _ => "are not in the order of their times",
        };
        let problem = format!("times: {lines}{} and {} {relation}", frame(a), frame(b));
        let remedy = "each frame needs a later time than the frame before, to a fraction of the frame interval";
        Error::new(ErrorKind::Mismatch, problem, remedy).about(&self.file)
    }
}

fn read_list(path: &Path, frames: &[String]) -> Result<List> {
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
    let text = of_utf16(&bytes).unwrap_or_else(|| String::from_utf8_lossy(&bytes).into_owned());
    List::read(&text, frames).map_err(wrong)
}

/// Row of `list` for each of the `count` frames: by folder and name, or in order, from the start of `part` on.
fn rows_of(
    list: &List,
    paths: &[String],
    (count, part): (usize, Option<Range<usize>>),
) -> Result<Vec<usize>, (String, &'static str)> {
    if list.names.is_empty() || paths.len() != count {
        let rows = match part.filter(|part| count == part.len() && part.end <= list.lines.len()) {
            Some(part) if count != list.lines.len() => part,
            _ => 0..list.lines.len(),
        };
        let problem = || format!("the list has {} times for {count} frames", list.lines.len());
        let remedy = "give one line for each frame, or lines 'name,time' that name the frames";
        return if rows.len() == count { Ok(rows.collect()) } else { Err((problem(), remedy)) };
    }
    let mut by_name: HashMap<&str, Vec<usize>> = HashMap::new();
    for (row, name) in list.names.iter().enumerate() {
        by_name.entry(stem(name)).or_default().push(row);
        // A name without extension, which may have points within.
        if base_name(name) != stem(name) {
            by_name.entry(base_name(name)).or_default().push(row);
        }
    }
    let row = |path: &String| {
        let rows = || [base_name(path), stem(path)].into_iter().filter_map(|name| by_name.get(name)).flatten().copied();
        let missing = || (format!("the list has no line for {}", base_name(path)), "add one, or open other frames");
        let alike = |row: usize| likeness(path, &list.names[row]);
        // A list of several folders repeats names: the row whose folders agree best counts.
        let best = rows().map(alike).max().ok_or_else(missing)?;
        let mut found = rows().filter(|row| alike(*row) == best);
        let first = found.next().ok_or_else(missing)?;
        match found.find(|row| list.stamps.values[*row] != list.stamps.values[first]) {
            None => Ok(first),
            Some(other) => {
                let [first, other] = [first, other].map(|row| list.lines[row]);
                let problem = format!("lines {first} and {other} of the list are both of {}", base_name(path));
                Err((problem, "write names with the folders of the frames, or give the lines of these frames alone"))
            }
        }
    };
    paths.iter().map(row).collect()
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
