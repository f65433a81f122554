//! Values along a line, as CSV: one row for each sample of each picture.

use super::atomic::write_whole;
use super::error::ExportError;
use crate::plane::sample::ProfileSample;
use std::io::Write;
use std::path::Path;

/// Columns of the file.
pub const PROFILE_COLUMNS: &str = "picture,distance_px,u,v,value";

/// Profile of one picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureProfile {
    /// Name of the picture; commas and quotes are allowed.
    pub picture: String,
    /// Samples; positions in pixels of the input image, values as fractions of full scale.
    pub samples: Vec<ProfileSample>,
}

/// Writes the profiles, one after the other. A sample outside its picture has an empty value.
///
/// # Errors
/// [`ExportError`] when the file cannot be written; an older one is then unchanged.
pub fn write_profiles_csv(path: &Path, profiles: &[PictureProfile]) -> Result<(), ExportError> {
    write_whole(path, |out| {
        writeln!(out, "{PROFILE_COLUMNS}")?;
        for profile in profiles {
            let name = format!("\"{}\"", profile.picture.replace('"', "\"\""));
            for sample in &profile.samples {
                let value = if sample.value.is_finite() { sample.value.to_string() } else { String::new() };
                writeln!(out, "{name},{},{},{},{value}", sample.distance_px, sample.u, sample.v)?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_has_a_row_and_names_may_hold_anything() {
        let home = tempfile::tempdir().expect("a folder");
        let path = home.path().join("p.csv");
        let sample = |distance_px, value| ProfileSample { distance_px, u: 1.5, v: 2.0, value };
        let profiles = [
            PictureProfile { picture: "Stack (1.00, 0.00)".into(), samples: vec![sample(0.0, 0.25), sample(1.0, 0.5)] },
            PictureProfile { picture: "a \"b\"".into(), samples: vec![sample(0.0, f32::NAN)] },
        ];
        write_profiles_csv(&path, &profiles).expect("written");
        let text = std::fs::read_to_string(&path).expect("there");
        let expected = "picture,distance_px,u,v,value\n\"Stack (1.00, 0.00)\",0,1.5,2,0.25\n\"Stack (1.00, 0.00)\",1,1.5,2,0.5\n\"a \"\"b\"\"\",0,1.5,2,\n";
        assert_eq!(text, expected);
    }
}
