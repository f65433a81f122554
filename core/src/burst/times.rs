//! Times as files, robots and people write them: dates, times of day, and numbers with a unit.
//!
//! The unit of a number stands in the heading of its column (`timestamp [ns]`, `time_s`, `MJD`), or is guessed: from
//! the size of a number that counts from 1970, and else from its digits and the distance of the frames.

use chrono::{DateTime, NaiveDateTime, SecondsFormat};
use std::{collections::HashMap, ops::Range};

#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Times {
    /// Time of each frame, seconds since 1970 (UTC) where `is_absolute`, else from the first frame; empty if unknown.
    pub seconds: Vec<f64>,
    pub is_absolute: bool,
}

/// Seconds since 1970 of `YYYY-MM-DD`, `YYYY-MM-DDThh:mm` or `YYYY-MM-DDThh:mm:ss.sss`, in UTC; `None` for other texts.
pub(super) fn seconds_of(text: &str) -> Option<f64> {
    let text = text.trim().trim_end_matches('Z').replace(' ', "T");
    let text = if text.contains('T') { text } else { text + "T0:0" };
    let read = |form| NaiveDateTime::parse_from_str(&text, form).ok();
    let time = read("%Y-%m-%dT%H:%M:%S%.f").or_else(|| read("%Y-%m-%dT%H:%M"))?.and_utc();
    Some(time.timestamp() as f64 + f64::from(time.timestamp_subsec_nanos()) * 1e-9)
}

/// The time `seconds` since 1970, in UTC, to a millisecond.
pub(super) fn time_text(seconds: f64) -> String {
    let time = DateTime::from_timestamp_millis((seconds * 1000.0).round() as i64);
    time.map_or_else(|| format!("{seconds} s"), |time| time.to_rfc3339_opts(SecondsFormat::Millis, true))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamp {
    /// In [`PARTS`] of its unit, so that the nanoseconds of 1970 on and the digits of Julian dates are kept.
    pub value: i128,
    pub written: Written,
}

/// Forms of a stamp. The unit of all but numbers is a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Written {
    /// With so many digits after the point.
    Number(usize),
    Date,
    /// A time of day, or since the start of a recording.
    Clock,
}

/// Parts of a unit in a [`Stamp`]: 15 decimal digits.
pub(super) const PARTS: i128 = 1_000_000_000_000_000;
/// Largest magnitude of a number that is read as a stamp, and its digits.
const LARGEST: f64 = 1e22;
const MOST_DIGITS: usize = 22;

fn are_digits(text: &str) -> bool {
    text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Digits after a point as [`PARTS`].
pub(super) fn parts(fraction: &str) -> i128 {
    let digits = fraction.bytes().chain(std::iter::repeat(b'0')).take(15);
    digits.fold(0, |sum, digit| 10 * sum + i128::from(digit.wrapping_sub(b'0')))
}

impl Stamp {
    pub fn number(text: &str) -> Option<Self> {
        let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        if !are_digits(whole) || !are_digits(fraction) || whole.len() > MOST_DIGITS {
            // Powers of ten, such as 1.036224e-01.
            let value: f64 = text.parse().ok().filter(|value: &f64| value.abs() <= LARGEST)?;
            let decimals = usize::from(value.fract() != 0.0 || text.contains('.'));
            return Some(Self { value: (value * PARTS as f64).round() as i128, written: Written::Number(decimals) });
        }
        let whole: i128 = whole.parse().ok()?;
        Some(Self { value: sign * (whole * PARTS + parts(fraction)), written: Written::Number(fraction.len()) })
    }

    /// A date with time: `2011-09-26 13:02:25.96`, `2011-09-26T13:02:25Z`, `2011:09:26 13:02:25`, `…T15:02:25+02:00`.
    pub fn date(text: &str) -> Option<Self> {
        // A sign behind the time of day begins the zone; those before part the date.
        let zone_at = text.rfind(['+', '-']).filter(|at| text[..*at].contains(':')).unwrap_or(text.len());
        let (text, zone) = text.split_at(zone_at);
        let hours_and_minutes = format!("{:0<4}", zone.get(1..).unwrap_or_default().replace(':', ""));
        let number = hours_and_minutes.parse::<i128>().ok().filter(|_| hours_and_minutes.len() == 4)?;
        let zone_minutes = (number / 100 * 60 + number % 100) * if zone.starts_with('-') { -1 } else { 1 };
        let (text, fraction) = text.trim_end_matches('Z').split_once('.').unwrap_or((text.trim_end_matches('Z'), ""));
        let (date, time) = text.split_once(['T', ' '])?;
        let seconds = seconds_of(&format!("{}T{time}", date.replace([':', '/'], "-")))? as i128 - 60 * zone_minutes;
        are_digits(fraction).then_some(Self { value: seconds * PARTS + parts(fraction), written: Written::Date })
    }

    /// A time such as `22:00:00.880`, or minutes and seconds with a fraction, `05:00.5`.
    fn clock(text: &str) -> Option<Self> {
        let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
        let part = |part: &str| part.parse::<i128>().ok().filter(|_| are_digits(part) && part.len() <= 2);
        let seconds = match whole.split(':').map(part).collect::<Option<Vec<i128>>>()?[..] {
            [hours, minutes, seconds] if minutes < 60 && seconds < 60 => 3600 * hours + 60 * minutes + seconds,
            [minutes, seconds] if seconds < 60 && !fraction.is_empty() => 60 * minutes + seconds,
            _ => return None,
        };
        are_digits(fraction).then_some(Self { value: seconds * PARTS + parts(fraction), written: Written::Clock })
    }

    fn is_number(&self) -> bool {
        matches!(self.written, Written::Number(_))
    }

    /// A number, date or time of day, with a point or a comma before its fraction.
    pub fn of(text: &str) -> Option<Self> {
        let pointed = text.contains(',').then(|| text.replacen(',', ".", 1));
        let text = pointed.as_deref().unwrap_or(text);
        Self::number(text).or_else(|| Self::date(text)).or_else(|| Self::clock(text))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    Days,
    Hours,
    Minutes,
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
    /// Positions in frame intervals, or numbers of frames.
    Frames,
}

/// Units with their names, a billionth of each in seconds, or in frame intervals, and their words in headings.
const UNITS: [(Unit, &str, f64, &[&str]); 8] = [
    (Unit::Days, "days", 8.64e-5, &["d", "days", "jd", "mjd", "bjd", "hjd"]),
    (Unit::Hours, "hours", 3.6e-6, &["h", "hr", "hrs", "hours"]),
    (Unit::Minutes, "minutes", 6e-8, &["min", "mins", "minutes"]),
    (Unit::Seconds, "seconds", 1e-9, &["s", "sec", "secs", "seconds"]),
    (Unit::Milliseconds, "milliseconds", 1e-12, &["ms", "msec", "msecs", "millisec", "milliseconds"]),
    (Unit::Microseconds, "microseconds", 1e-15, &["us", "µs", "usec", "usecs", "microsec", "microseconds"]),
    (Unit::Nanoseconds, "nanoseconds", 1e-18, &["ns", "nsec", "nsecs", "nanosec", "nanoseconds"]),
    (Unit::Frames, "numbers of frames", 1e-9, &["frames", "intervals", "position"]),
];

impl Unit {
    fn record(self) -> (&'static str, f64) {
        UNITS.iter().find(|(unit, ..)| *unit == self).map_or(("", 0.0), |(_, name, billionth, _)| (*name, *billionth))
    }

    pub fn name(self) -> &'static str {
        self.record().0
    }

    fn of(heading: &str) -> Option<Self> {
        let named = |word: String| UNITS.iter().find(|(.., words)| words.contains(&&*word)).map(|found| found.0);
        words(heading).find_map(named)
    }
}

fn words(heading: &str) -> impl Iterator<Item = String> {
    heading.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase)
}

/// How surely a heading is that of times: 0 not; 1 by a word like h or min; 2 by a unit; 3 by a word for times.
fn time_heading(heading: &str) -> u8 {
    let has = |known: &[&str]| words(heading).any(|word| known.contains(&&*word));
    match Unit::of(heading) {
        _ if has(&["exposure", "exptime", "duration", "delta", "dt"]) => 0,
        _ if has(&["time", "times", "timestamp", "timestamps", "stamp", "date", "t", "jd", "mjd", "bjd", "hjd"]) => 3,
        Some(_) if has(&["h", "d", "min"]) => 1,
        Some(_) => 2,
        None => 0,
    }
}

pub(super) const HEADED: &str = "as their heading says";
const BY_DISTANCE: &str = "by the distance of the frames";

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stamps {
    pub values: Vec<Stamp>,
    pub unit: Unit,
    /// How the unit is known, as a part of a sentence.
    pub known_by: &'static str,
}

impl Stamps {
    /// Stamps in their order, of the `unit` that their heading names, else a guess; an error where two are as likely.
    pub fn new(mut values: Vec<Stamp>, unit: Option<Unit>) -> Result<Self, String> {
        let form = |one: &Stamp| (one.is_number(), one.written == Written::Clock);
        if values.windows(2).any(|two| form(&two[0]) != form(&two[1])) {
            return Err("numbers, dates and times of day are mixed; write all alike".to_owned());
        }
        if values.iter().all(|one| one.written == Written::Clock) {
            const DAY: i128 = 86_400 * PARTS;
            for t in 1..values.len() {
                // A list that goes on behind midnight.
                values[t].value += (values[t - 1].value - values[t].value + DAY / 2).div_euclid(DAY).max(0) * DAY;
            }
        }
        let (unit, known_by) = match unit.filter(|_| values.iter().all(Stamp::is_number)) {
            Some(unit) => (unit, HEADED),
            None => Self::guess(&values)?,
        };
        Ok(Self { values, unit, known_by })
    }

    fn guess(values: &[Stamp]) -> Result<(Unit, &'static str), String> {
        // Dates and clocks are sure; then sizes since 1970 count, then the distance of the frames.
        let decimals = match values.first().map(|one| one.written) {
            Some(Written::Date) => return Ok((Unit::Seconds, "as dates")),
            Some(Written::Clock) => return Ok((Unit::Seconds, "as times of day")),
            _ => values.iter().map(|one| if let Written::Number(digits) = one.written { digits } else { 0 }).max(),
        };
        let mut sizes: Vec<f64> = values.iter().map(|one| one.value as f64 / PARTS as f64).collect();
        sizes.sort_by(f64::total_cmp);
        let mut gaps: Vec<f64> = sizes.windows(2).map(|two| two[1] - two[0]).collect();
        gaps.sort_by(f64::total_cmp);
        let gap = gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
        let are_within = |from: f64, to: f64| sizes.iter().all(|size| (from..to).contains(size));
        // Numbers that count from 1970, from about 1973 to 2286.
        let units = [Unit::Seconds, Unit::Milliseconds, Unit::Microseconds, Unit::Nanoseconds];
        let since_1970 = |from: &f64| are_within(*from, 100.0 * from);
        if let Some((unit, _)) = units.iter().zip([1e8, 1e11, 1e14, 1e17]).find(|(_, from)| since_1970(from)) {
            return Ok((*unit, "by their size"));
        }
        // Whole numbers: the unit in which the usual gap is that of a camera.
        let Some(decimals) = decimals.filter(|decimals| *decimals > 0) else {
            let unit = match gap {
                2e6.. => Unit::Nanoseconds,
                2000.0.. => Unit::Microseconds,
                5.0.. => Unit::Milliseconds,
                _ => Unit::Frames,
            };
            return Ok((unit, BY_DISTANCE));
        };
        // Days from 1968 to 2050. As seconds, these would be half a day or a month after a start.
        if are_within(40_000.0, 70_000.0) || are_within(2_440_000.5, 2_470_000.5) {
            match gap {
                // No camera takes 2000 frames a second for half a day, and none one an hour with times to a second.
                ..5e-4 => return Ok((Unit::Days, "by their size, as Julian dates")),
                ..0.02 if decimals > 3 => {
                    let problem = "the numbers may be seconds or (modified) Julian dates, which are days";
                    return Err(format!("{problem}; write a heading, such as time_s or MJD"));
                }
                _ => {}
            }
        }
        Ok((Unit::Seconds, "by their fractions"))
    }

    /// Whether they are times for sure, and no numbers of another meaning.
    pub fn are_sure(&self) -> bool {
        self.unit != Unit::Frames && self.known_by != BY_DISTANCE
    }

    /// Times of some frames, in this order, from the first of them on: seconds, or intervals for [`Unit::Frames`].
    pub fn since_first(&self, frames: &[usize]) -> Vec<f64> {
        const BILLIONTH: i128 = PARTS / 1_000_000_000;
        let (_, unit) = self.unit.record();
        let first = frames.first().map_or(0, |t| self.values[*t].value);
        // Differences are exact; the one multiplication rounds.
        let time = |difference: i128| match self.unit {
            Unit::Days => difference as f64 * (unit / BILLIONTH as f64),
            _ => (difference + BILLIONTH / 2).div_euclid(BILLIONTH) as f64 * unit,
        };
        frames.iter().map(|t| time(self.values[*t].value - first)).collect()
    }

    /// Seconds of frame `t` on the clock of the stamps, to the digits of a double.
    pub fn seconds(&self, t: usize) -> f64 {
        self.values[t].value as f64 * (1e9 * self.unit.record().1 / PARTS as f64)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct List {
    pub stamps: Stamps,
    /// Line of each stamp, from 1.
    pub lines: Vec<usize>,
    /// Name of each frame, as the list writes it; empty for a list without names.
    pub names: Vec<String>,
}

const MAX_LINES: usize = 10_000_000;

/// Fields of a line, separated `by` a character outside of quotes, or by white space, which a date has within.
fn fields(line: &str, by: Option<char>) -> Vec<&str> {
    let mut is_quoted = false;
    let separated = line.split(|c: char| {
        is_quoted ^= c == '"';
        !is_quoted && by.map_or(c.is_whitespace(), |by| c == by)
    });
    if by.is_some() {
        return separated.map(|field| field.trim().trim_matches('"')).collect();
    }
    // White space parts a date from its time of day, too: such fields are joined again.
    let mut found: Vec<&str> = Vec::new();
    for field in separated.filter(|field| !field.is_empty()) {
        let from = found.last().map_or(field, |last| last).as_ptr().addr() - line.as_ptr().addr();
        let to = field.as_ptr().addr() + field.len() - line.as_ptr().addr();
        let [alone, with_last] =
            [field, &line[from..to]].map(|text| text.trim_matches(['"', '[', ']', '(', ')', ',', ';']));
        // A unit in brackets belongs to the word before.
        let is_unit = field.starts_with(['[', '(']) && Unit::of(field).is_some();
        let is_date =
            || found.last().is_some_and(|last| last.contains(['-', '/', ':'])) && Stamp::date(with_last).is_some();
        if is_unit || is_date() {
            found.pop();
            found.push(with_last);
        } else {
            found.push(alone);
        }
    }
    found
}

/// Text of a list with points for the commas in times such as `22:00:00,880`; of subtitles, the part before the arrow.
fn pointed(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for at in 3..bytes.len() {
        let behind = bytes[at..].iter().skip(1).take_while(|byte| byte.is_ascii_digit()).count();
        let is_second = bytes[at - 3] == b':' && bytes[at - 2..at].iter().all(u8::is_ascii_digit);
        if bytes[at] == b',' && is_second && [3, 6, 9].contains(&behind) {
            bytes[at] = b'.';
        }
    }
    let text = String::from_utf8_lossy(&bytes).into_owned();
    if !text.contains("-->") {
        return text;
    }
    text.lines().map(|line| line.split_once("-->").map_or("", |(begin, _)| begin).to_owned() + "\n").collect()
}

/// Whether a field is a number with a comma before its fraction.
fn is_decimal(field: &str) -> bool {
    field.trim_start_matches('-').split_once(',').is_some_and(|(whole, fraction)| {
        !whole.is_empty() && !fraction.is_empty() && are_digits(whole) && are_digits(fraction)
    })
}

/// Where the runs of digits of a name begin and end.
pub(super) fn digit_runs(name: &str) -> Vec<Range<usize>> {
    let mut end = 0;
    let runs = name.as_bytes().chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit()).map(|run| {
        end += run.len();
        end - run.len()..end
    });
    runs.filter(|run| name.as_bytes()[run.start].is_ascii_digit()).collect()
}

pub(super) fn base_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

pub(super) fn stem(path: &str) -> &str {
    let name = base_name(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// Folders at the ends of two paths, before their base names, that are the same; and whether the base names are.
pub(super) fn likeness(a: &str, b: &str) -> (usize, bool) {
    let folders = |path: &str| {
        let parts = path.rsplit(['/', '\\']).skip(1).map(str::to_owned);
        parts.filter(|part| !["", "."].contains(&&**part)).collect::<Vec<_>>()
    };
    let alike = folders(a).into_iter().zip(folders(b)).take_while(|(a, b)| a == b).count();
    (alike, base_name(a) == base_name(b))
}

impl List {
    /// Reads a list of one time a line, or of columns, one with times and perhaps one with `frames`' names, with or
    /// without extension and folders. Lines that begin with `#` are comments; the last one before the first row, and a
    /// first line without a time, are headings if they have as many fields. The error names the line and the remedy.
    pub fn read(text: &str, frames: &[String]) -> Result<Self, String> {
        let text = pointed(text.trim_start_matches('\u{feff}'));
        let lines: Vec<(usize, &str)> =
            (1..).zip(text.lines().take(MAX_LINES)).map(|(at, line)| (at, line.trim())).collect();
        let has_time = |line: &str, by| fields(line, by).iter().any(|field| Stamp::of(field).is_some());
        let begins = lines.iter().position(|(_, line)| {
            !line.starts_with('#') && [Some(','), Some(';'), None].into_iter().any(|by| has_time(line, by))
        });
        let Some(begins) = begins else {
            return Err("it has no line with a time; write one time a line, or 'name,time'".to_owned());
        };
        let is_row = |line: &&str| !line.is_empty() && !line.starts_with('#');
        let rows = || lines[begins..].iter().map(|(_, line)| *line).filter(is_row);
        let first = lines[begins].1;
        let heading = lines[..begins].iter().rfind(|(_, line)| !line.is_empty()).map_or("", |(_, line)| line);
        let has_commas = rows().any(|line| line.contains(','));
        // Commas are within the numbers where semicolons part the fields, or white space does, or nothing.
        let are_decimal = |line: &str| line.split_whitespace().all(|field| !field.contains(',') || is_decimal(field));
        let is_alone = has_commas && rows().all(|line| !line.contains(',') || is_decimal(line));
        let is_rising = |part: fn((&str, &str)) -> Option<i64>| {
            let numbers: Vec<i64> = rows().filter_map(|line| part(line.split_once(',')?)).collect();
            numbers.windows(2).all(|two| two[0] < two[1])
        };
        // Two columns of counters look like one column with decimal commas, but both rise.
        let are_pairs = || is_rising(|(left, _)| left.parse().ok()) && is_rising(|(_, right)| right.parse().ok());
        let is_one = is_alone && !heading.contains(',') && (time_heading(heading) > 0 || !are_pairs());
        let by = match () {
            () if rows().all(|line| line.contains(';')) => Some(';'),
            () if is_one => Some('\n'),
            () if has_commas && !is_alone && rows().all(are_decimal) => None,
            () => {
                let are_there = |by: &Option<char>| by.is_none_or(|by| first.contains(by));
                let mut separators = [Some(','), Some('\t'), None].into_iter().filter(are_there);
                separators.clone().find(|by| has_time(first, *by)).or_else(|| separators.next()).flatten()
            }
        };
        Self::of_lines(&lines, by, frames)
    }

    fn of_lines(lines: &[(usize, &str)], by: Option<char>, frames: &[String]) -> Result<Self, String> {
        let mut heading: Vec<&str> = Vec::new();
        let mut rows: Vec<(usize, Vec<&str>)> = Vec::new();
        for (line, text) in lines.iter().filter(|(_, text)| !text.is_empty()) {
            let comment = text.strip_prefix('#');
            let of_line = fields(comment.unwrap_or(text).trim(), by);
            match comment {
                Some(_) if !rows.is_empty() => {}
                None if !rows.is_empty() || of_line.iter().any(|field| Stamp::of(field).is_some()) => {
                    rows.push((*line, of_line));
                }
                _ => heading = of_line,
            }
        }
        let Some((line, first)) = rows.first() else {
            return Err("it has no line with a time; write one time a line, or 'name,time'".to_owned());
        };
        if heading.len() != first.len() {
            heading.clear();
        }
        let known: HashMap<&str, &str> =
            frames.iter().flat_map(|path| [(base_name(path), &**path), (stem(path), path)]).collect();
        let frame_of = |field: &str| known.get(base_name(field)).or_else(|| known.get(stem(field)));
        let columns = || (0..first.len()).rev();
        // Of the names of several cameras, those with the folder of the frames.
        let column = |is: &dyn Fn(&str) -> bool| {
            let is_like = |field: &str| frame_of(field).filter(|_| is(field)).map(|frame| likeness(frame, field));
            let best = |at: usize| rows.iter().filter_map(|(_, row)| is_like(row.get(at)?)).max();
            columns().filter_map(|at| Some((best(at)?, at))).max_by_key(|(like, _)| *like).map(|(_, at)| at)
        };
        // Where the times are the names of the files, the column with an extension has the names.
        let names = column(&|field| Stamp::of(field).is_none());
        let names = names.or_else(|| (first.len() > 1).then(|| column(&|_| true)).flatten());
        // A column may hold the folder alone, which tells equal names of several folders apart.
        let folder = frames.first().and_then(|path| path.rsplit(['/', '\\']).nth(1)).unwrap_or_default();
        let is_of_folder = |at: &usize| rows.iter().any(|(_, row)| row.get(*at) == Some(&folder));
        let folders = columns().filter(|at| Some(*at) != names && !folder.is_empty()).find(is_of_folder);
        let stamped: Vec<usize> =
            (0..first.len()).filter(|at| Some(*at) != names && Stamp::of(first[*at]).is_some()).collect();
        let sureness = |at: &usize| heading.get(*at).map_or(0, |heading| time_heading(heading));
        let headed = stamped.iter().rev().copied().filter(|at| sureness(at) > 1).max_by_key(sureness);
        let unit_of = |at: usize| heading.get(at).and_then(|heading| Unit::of(heading));
        let whole = |row: &[&str], at: usize| Stamp::number(row.get(at)?).filter(|of| of.written == Written::Number(0));
        // Whole seconds in a column, and their milli-, micro- or nanoseconds in another one, as stamps of ROS.
        let part = |at: usize, row: &[&str]| {
            let in_second = (1e-9 / unit_of(at)?.record().1).round() as i128;
            let value = whole(row, at).filter(|_| in_second > 1)?.value;
            Some(value / in_second).filter(|part| (0..PARTS).contains(part))
        };
        let alike = |of: usize| stamped.iter().copied().filter(move |at| sureness(at) == sureness(&of));
        let seconds = headed.and_then(|of| alike(of).find(|at| unit_of(*at) == Some(Unit::Seconds)));
        let seconds = seconds.filter(|at| rows.iter().all(|(_, row)| whole(row, *at).is_some()));
        let is_behind = |at: &usize| rows.iter().all(|(_, row)| part(*at, row).is_some());
        let split = seconds.and_then(|of| Some((of, alike(of).find(is_behind)?)));
        let headed = split.map(|(seconds, _)| seconds).or(headed);
        let is_dated = |at: &usize| Stamp::of(first[*at]).is_some_and(|stamp| !stamp.is_number());
        let dated: Vec<usize> = stamped.iter().copied().filter(is_dated).collect();
        // Without a heading, the only stamp of a row, or the only date among numbers, is the time.
        let times = match (headed, &stamped[..], &dated[..]) {
            (Some(at), ..) => at,
            (None, [at], _) | (None, _, [at]) => *at,
            (None, [], _) => return Err(format!("line {line} has no time; write one time a line, or 'name,time'")),
            (None, ..) => {
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
            let behind = split.and_then(|(_, at)| part(at, row)).unwrap_or(0);
            values.push(Stamp { value: stamp.value + behind, ..stamp });
            lines.push(*line);
            let field = |at: usize| row.get(at).copied().unwrap_or_default();
            of_rows.extend(names.map(|at| match folders {
                Some(folder) => format!("{}/{}", field(folder), field(at)),
                None => field(at).to_owned(),
            }));
        }
        let unit = heading.get(times).and_then(|heading| Unit::of(heading));
        Ok(Self { stamps: Stamps::new(values, unit)?, lines, names: of_rows })
    }
}
