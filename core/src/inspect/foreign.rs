//! Features of other programs, as an overlay of a burst and for comparison: from our own CSV table or COLMAP's text.

use crate::detector::Slope;
use crate::export::{COLUMNS, ExportError, read_colmap, read_features_csv};
use std::io::Read;
use std::path::Path;

/// A feature from a file, with the values that the file has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForeignFeature {
    /// (u, v), input pixels; the centre of the first pixel is (0, 0).
    pub pos_image: [f32; 2],
    /// Scale σ, input pixels.
    pub sigma: f32,
    /// Orientation, radians, from +u towards +v.
    pub orientation: f32,
    /// Slope, px/frame.
    pub slope: Option<Slope>,
    /// D with its sign.
    pub response: Option<f32>,
    /// Ratio of |D| to its noise.
    pub snr: Option<f32>,
}

/// Reads features from a file: CSV if it begins like our table, otherwise COLMAP's text.
///
/// # Errors
/// [`ExportError::Read`] when the file cannot be read, [`ExportError::Text`] with the line that has a wrong form; for a
/// file of neither kind the error describes both. Features with a position or a scale that is no number, or without a
/// size, are also refused.
pub fn read_features(path: &Path) -> Result<Vec<ForeignFeature>, ExportError> {
    let features: Vec<ForeignFeature> = match kind(path)? {
        Kind::Csv => read_features_csv(path)?
            .into_iter()
            .map(|row| ForeignFeature {
                pos_image: [row.u, row.v],
                sigma: row.sigma,
                orientation: row.orientation,
                slope: Some(Slope::new(row.slope_u, row.slope_v)),
                response: Some(row.response),
                snr: Some(row.snr),
            })
            .collect(),
        Kind::Colmap => read_colmap(path)?
            .0
            .into_iter()
            .map(|k| ForeignFeature {
                pos_image: k.pos_image().map(|x| x as f32),
                sigma: k.scale,
                orientation: k.orientation,
                slope: None,
                response: None,
                snr: None,
            })
            .collect(),
    };
    let usable = |f: &ForeignFeature| f.pos_image.iter().all(|x| x.is_finite()) && f.sigma.is_finite() && f.sigma > 0.0;
    match features.iter().position(|f| !usable(f)) {
        None => Ok(features),
        Some(index) => Err(ExportError::Text {
            path: path.into(),
            line: index + 2,
            problem: "the place must be two numbers and the scale a number above 0".to_owned(),
        }),
    }
}

enum Kind {
    Csv,
    Colmap,
}

/// The kind of a file, from its beginning.
fn kind(path: &Path) -> Result<Kind, ExportError> {
    let read = |e: std::io::Error| ExportError::Read { path: path.into(), reason: e.to_string() };
    let mut start = Vec::new();
    std::fs::File::open(path).map_err(read)?.take(256).read_to_end(&mut start).map_err(read)?;
    let start = String::from_utf8_lossy(&start);
    let first = start.lines().next().unwrap_or_default();
    let header = COLUMNS.join(",");
    if first.starts_with(&header[..header.len().min(12)]) {
        return Ok(Kind::Csv);
    }
    let words: Vec<&str> = first.split_whitespace().collect();
    if matches!(words[..], [count, size] if count.parse::<u64>().is_ok() && size.parse::<u64>().is_ok()) {
        return Ok(Kind::Colmap);
    }
    Err(ExportError::Text {
        path: path.into(),
        line: 1,
        problem: format!(
            "the first line '{first:.40}' is neither the header of a feature table ({header}) nor that of COLMAP's text (a count and 128)"
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::Feature;
    use crate::export::{write_colmap, write_csv};
    use proptest::prelude::*;

    fn feature(u: f32, v: f32) -> Feature {
        Feature {
            u,
            v,
            sigma: 2.5,
            orientation: 0.5,
            slope: Slope::new(1.0, -0.5),
            response: -0.01,
            snr: 7.0,
            octave: 0,
            level: 1,
            slope_index: 3,
            at_slope_limit: false,
        }
    }

    #[test]
    fn both_formats_come_back_with_the_same_places() {
        let home = tempfile::tempdir().expect("a folder");
        let features = [feature(10.25, 20.5), feature(0.0, 3.0)];
        let (csv, text) = (home.path().join("a.csv"), home.path().join("a.txt"));
        write_csv(&csv, &features).expect("written");
        write_colmap(&text, &features, &[[7; 128]; 2]).expect("written");
        let (a, b) = (read_features(&csv).expect("ours"), read_features(&text).expect("COLMAP's"));
        assert_eq!(a.len(), 2);
        for (a, b) in a.iter().zip(&b) {
            assert_eq!((a.pos_image, a.sigma, a.orientation), (b.pos_image, b.sigma, b.orientation));
        }
        assert_eq!((a[0].slope, b[0].slope), (Some(Slope::new(1.0, -0.5)), None));
    }

    fn error_of(text: &str) -> String {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), text).expect("written");
        read_features(file.path()).expect_err("refused").to_string()
    }

    #[test]
    fn what_is_neither_is_refused_with_what_would_be_right() {
        let error = error_of("x;y;z\n1;2;3\n");
        assert!(error.contains("x;y;z") && error.contains("u,v,sigma") && error.contains("COLMAP"), "{error}");
        assert!(error_of("").contains("neither"));
        let header = COLUMNS.join(",");
        assert!(error_of(&format!("{header}\nnan,2,3,0,0,0,0.1,5,0,0,0\n")).contains("two numbers"));
        assert!(error_of(&format!("{header}\n1,2,0,0,0,0,0.1,5,0,0,0\n")).contains("above 0"));
        assert!(
            read_features(Path::new("/nowhere/at.all")).expect_err("missing").to_string().contains("/nowhere/at.all")
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        #[test]
        fn no_text_panics(start in prop_oneof![Just("2 128\n".to_owned()), Just(COLUMNS.join(",") + "\n"), Just(String::new())], rest in "[0-9 .,eE+\\-\\n]{0,200}|\\PC{0,80}") {
            let file = tempfile::NamedTempFile::new().expect("a file");
            std::fs::write(file.path(), start + &rest).expect("written");
            let _ = read_features(file.path());
        }
    }
}
