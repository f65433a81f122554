//! Times of frames, as files give them.

/// Times of the frames of a file or burst.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Times {
    /// Time of each frame, seconds: since 1970 (UTC) where `is_absolute`, or else from the first frame. Empty where the
    /// files do not say it.
    pub seconds: Vec<f64>,
    pub is_absolute: bool,
}

const DAY_S: f64 = 86400.0;
/// Days from 1 March of the year 0 to 1 January 1970 of the Gregorian calendar.
const DAYS_TO_1970: i64 = 719_468;
/// Days of 400 years.
const ERA_DAYS: i64 = 146_097;

/// Seconds since 1970 of `YYYY-MM-DD`, `YYYY-MM-DDThh:mm` or `YYYY-MM-DDThh:mm:ss.sss`, in UTC; `None` for other texts.
pub(super) fn seconds_of(text: &str) -> Option<f64> {
    let text = text.trim().trim_end_matches('Z');
    let (date, time) = text.split_once(['T', ' ']).unwrap_or((text, "0:0:0"));
    let number = |text: &str, most: i64| text.parse::<i64>().ok().filter(|number| (0..=most).contains(number));
    let mut date = date.splitn(3, '-');
    let (year, month, day) = (number(date.next()?, 9999)?, number(date.next()?, 12)?, number(date.next()?, 31)?);
    if month == 0 || day == 0 {
        return None;
    }
    let mut time = time.splitn(3, ':');
    let (hour, minute) = (number(time.next()?, 23)?, number(time.next()?, 59)?);
    let second: f64 = time.next().unwrap_or("0").parse().ok().filter(|second| (0.0..61.0).contains(second))?;
    // Years begin in March, so that a leap day ends one.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let of_era = year.rem_euclid(400);
    let days =
        year.div_euclid(400) * ERA_DAYS + of_era * 365 + of_era / 4 - of_era / 100 + (153 * month + 2) / 5 + day - 1;
    Some((days - DAYS_TO_1970) as f64 * DAY_S + (hour * 3600 + minute * 60) as f64 + second)
}

/// The time `seconds` since 1970, in UTC, to a millisecond.
pub(super) fn time_text(seconds: f64) -> String {
    let milliseconds = (seconds * 1000.0).round() as i64;
    let (days, in_day) = (milliseconds.div_euclid(86_400_000) + DAYS_TO_1970, milliseconds.rem_euclid(86_400_000));
    let (era, of_era) = (days.div_euclid(ERA_DAYS), days.rem_euclid(ERA_DAYS));
    let year = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = year + era * 400 + i64::from(month <= 2);
    let (hour, minute, second) = (in_day / 3_600_000, in_day / 60_000 % 60, in_day % 60_000);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{:02}.{:03}Z", second / 1000, second % 1000)
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
