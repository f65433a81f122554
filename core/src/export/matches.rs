//! Matches of two images as CSV: a header line, then one line for each match.
//!
//! `a` and `b` are the indices of the features in each image, from 0, in the order of its feature file. `error_px` is
//! the distance from the geometry that the matches agree on, `inf` where they agree on none; `inlier` is 1 or 0. Where
//! no geometry was requested both are `nan`, so that every cell is a number.

use super::atomic::write_whole;
use super::error::ExportError;
use std::io::Write;
use std::path::Path;

/// Row of the table of matches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchRow {
    /// Indices of the features in images A and B.
    pub features: [usize; 2],
    /// (u, v) in A, pixels.
    pub a: [f64; 2],
    /// (u, v) in B, pixels.
    pub b: [f64; 2],
    /// Distance of the descriptors.
    pub distance: f32,
    /// Ratio of the distances to the nearest and the second nearest.
    pub ratio: f32,
    /// Error in pixels and whether it is an inlier; `None` where no geometry was requested.
    pub verified: Option<(f32, bool)>,
}

/// Names of the columns, in order.
pub const MATCH_COLUMNS: [&str; 10] = ["a", "b", "u_a", "v_a", "u_b", "v_b", "distance", "ratio", "error_px", "inlier"];

/// Writes the matches as CSV.
///
/// # Errors
/// [`ExportError`] when the file cannot be written; an older one is then unchanged.
pub fn write_matches_csv(path: &Path, matches: &[MatchRow]) -> Result<(), ExportError> {
    write_whole(path, |out| {
        writeln!(out, "{}", MATCH_COLUMNS.join(","))?;
        for MatchRow { features, a, b, distance, ratio, verified } in matches {
            // As f32, since the positions are those of the feature files.
            let [u_a, v_a, u_b, v_b] = [a[0], a[1], b[0], b[1]].map(|x| x as f32);
            write!(out, "{},{},{u_a},{v_a},{u_b},{v_b},{distance},{ratio},", features[0], features[1])?;
            match verified {
                Some((error, inlier)) => writeln!(out, "{error},{}", u8::from(*inlier))?,
                None => writeln!(out, "nan,nan")?,
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_a_number() {
        let row = MatchRow {
            features: [3, 0],
            a: [1.5, 2.25],
            b: [f64::from(0.1f32), 7.0],
            distance: 120.5,
            ratio: 0.5,
            verified: Some((0.25, true)),
        };
        let rows =
            [row, MatchRow { verified: Some((f32::INFINITY, false)), ..row }, MatchRow { verified: None, ..row }];
        let home = tempfile::tempdir().expect("a folder");
        let path = home.path().join("m.csv");
        write_matches_csv(&path, &rows).expect("written");
        let text = std::fs::read_to_string(&path).expect("a file");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "a,b,u_a,v_a,u_b,v_b,distance,ratio,error_px,inlier");
        assert_eq!(lines[1], "3,0,1.5,2.25,0.1,7,120.5,0.5,0.25,1");
        assert!(lines[2].ends_with(",inf,0") && lines[3].ends_with(",nan,nan"));
        assert!(lines[1..].iter().all(|l| l.split(',').all(|cell| cell.parse::<f64>().is_ok())));
    }
}
