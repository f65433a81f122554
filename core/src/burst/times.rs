//! Times of frames, as files give them.

use chrono::{DateTime, NaiveDateTime, SecondsFormat};

/// Times of the frames of a file or burst.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Times {
    /// Time of each frame, seconds: since 1970 (UTC) where `is_absolute`, or else from the first frame. Empty where the
    /// files do not say it.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_go_there_and_back() {
        for (text, seconds) in [
            ("1970-01-01T00:00:00.000Z", 0.0),
            ("2000-02-29T12:30:01.250Z", 951_827_401.25),
            ("2026-11-24T20:31:07.000Z", 1_795_552_267.0),
            ("1969-12-31T23:59:59.500Z", -0.5),
        ] {
            assert_eq!(seconds_of(text), Some(seconds), "{text}");
            assert_eq!(time_text(seconds), text);
        }
        assert_eq!(seconds_of("2021-03-01"), seconds_of("2021-03-01T00:00"));
        let bad = "2021 2021-13-01 2021-01-00 2021-01-01T24:00 2021-01-01T10:61 2021-01-01T10:10:x 99999999-1-1";
        for bad in bad.split(' ').chain([""]) {
            assert_eq!(seconds_of(bad), None, "{bad}");
        }
    }
}
