//! The feature table as CSV: a header line, then one line for each feature, in the detection's order.
//!
//! Numbers have the fewest digits that read back to the same `f32`. `at_slope_limit` is 1 or 0, so that every cell is a
//! number. An infinite `snr` (a noiseless burst) is written `inf`, which numpy, pandas and R read.

use super::atomic::write_whole;
use super::columns::{COLUMNS, FeatureRow};
use super::error::ExportError;
use crate::detector::Feature;
use crate::files::{MAX_TABLE_BYTES, read_bytes};
use std::io::Write;
use std::path::Path;

/// Writes the features as CSV.
///
/// # Errors
/// [`ExportError`] when the file cannot be written; an older one is then unchanged.
pub fn write_csv(path: &Path, features: &[Feature]) -> Result<(), ExportError> {
    write_whole(path, |out| {
        writeln!(out, "{}", COLUMNS.join(","))?;
        for feature in features {
            let r = FeatureRow::from(feature);
            writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{},{}",
                r.u,
                r.v,
                r.sigma,
                r.orientation,
                r.slope_u,
                r.slope_v,
                r.response,
                r.snr,
                r.octave,
                r.level,
                u8::from(r.at_slope_limit)
            )?;
        }
        Ok(())
    })
}

/// Reads a table that [`write_csv`] wrote. Strict: the header must be exact and every line complete.
///
/// # Errors
/// [`ExportError::Read`], or [`ExportError::Text`] with the line and the problem in it.
pub fn read_features_csv(path: &Path) -> Result<Vec<FeatureRow>, ExportError> {
    let bytes = read_bytes(path, MAX_TABLE_BYTES)
        .map_err(|e| ExportError::Read { path: path.into(), reason: e.to_string() })?;
    let text = std::str::from_utf8(&bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        ExportError::Text { path: path.into(), line, problem: "this is not text; save it as UTF-8".into() }
    })?;
    parse(text).map_err(|(line, problem)| ExportError::Text { path: path.into(), line, problem })
}

/// Parses the rows; the error is the number of the wrong line and its problem.
fn parse(text: &str) -> Result<Vec<FeatureRow>, (usize, String)> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    let header = COLUMNS.join(",");
    if lines.next().is_none_or(|(_, first)| first != header) {
        return Err((1, format!("the header must be {header}")));
    }
    lines.map(|(number, line)| row(line).map_err(|problem| (number, problem))).collect()
}

fn row(line: &str) -> Result<FeatureRow, String> {
    let cells: Vec<&str> = line.split(',').collect();
    if cells.len() != COLUMNS.len() {
        return Err(format!("there must be {} cells, not {}", COLUMNS.len(), cells.len()));
    }
    let wrong = |i: usize, right: &str| format!("{} must be {right}, not '{}'", COLUMNS[i], cells[i]);
    let float = |i: usize| cells[i].parse::<f32>().map_err(|_| wrong(i, "a number"));
    let integer = |i: usize| cells[i].parse::<i32>().map_err(|_| wrong(i, "a whole number"));
    Ok(FeatureRow {
        u: float(0)?,
        v: float(1)?,
        sigma: float(2)?,
        orientation: float(3)?,
        slope_u: float(4)?,
        slope_v: float(5)?,
        response: float(6)?,
        snr: float(7)?,
        octave: integer(8)?,
        level: integer(9)?,
        at_slope_limit: match cells[10] {
            "0" => false,
            "1" => true,
            _ => return Err(wrong(10, "0 or 1")),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GOOD: &str = "u,v,sigma,orientation,slope_u,slope_v,response,snr,octave,level,at_slope_limit\n\
                        1.5,2,3,-0.5,1,0,-0.01,inf,-1,2,1\n4,5,6,0,0,0,0.25,9.5,0,0,0\n";

    #[test]
    fn errors_name_the_line_and_the_column() {
        assert_eq!(parse(GOOD).expect("good").len(), 2);
        assert_eq!(parse(GOOD).expect("good")[0].snr, f32::INFINITY);
        assert_eq!(parse(&GOOD.replace('\n', "\r\n")), parse(GOOD));
        let cases = [
            ("", 1, "header"),
            (&GOOD.replace("sigma", "scale"), 1, "header"),
            (&GOOD.replace("1.5,", "one,"), 2, "u must be a number, not 'one'"),
            (&GOOD.replace(",0,0,0\n", ",0,0\n"), 3, "11 cells, not 10"),
            (&GOOD.replace(",0,0,0\n", ",0,0,yes\n"), 3, "at_slope_limit must be 0 or 1"),
            (&GOOD.replace(",-1,2,", ",-1.5,2,"), 2, "octave must be a whole number"),
            (&format!("{GOOD}\n"), 4, "11 cells, not 1"),
        ];
        for (text, line, problem) in cases {
            let (found, message) = parse(text).expect_err(problem);
            assert!(found == line && message.contains(problem), "{found}: {message}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC*", cut in 0..GOOD.len(), insert in "[0-9,.\\-einf\\n]{0,8}") {
            let _ = parse(&text);
            let _ = parse(&format!("{}{insert}{}", &GOOD[..cut], &GOOD[cut..]));
        }
    }
}
