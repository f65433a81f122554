//! Matching options, shared by the commands that match: raw arguments and the parameters checked from them.
//!
//! Names and help texts are those of [`crate::matching::params::doc`].

use super::choices::{GEOMETRIES, words};
use super::failure::Failure;
use crate::dataset::camera::read_camera;
use crate::detector::ParamDoc;
use crate::matching::params::doc;
use crate::matching::{Camera, Geometry, MatchParams};
use clap::Args;
use std::path::Path;

/// The options of matching as they are written.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Matching options")]
#[allow(missing_docs)] // each is described by its `doc` constant
pub struct MatchingArgs {
    #[arg(long = doc::RATIO.name, value_name = "R", help = short_help(doc::RATIO), long_help = long_help(doc::RATIO))]
    pub ratio: Option<f32>,
    #[arg(long = doc::MUTUAL.name, value_name = "BOOL", help = short_help(doc::MUTUAL), long_help = long_help(doc::MUTUAL))]
    pub mutual: Option<bool>,
    #[arg(long = doc::GEOMETRY.name, value_name = "WHICH", help = geometry_help(), long_help = long_help(doc::GEOMETRY),
        value_parser = words::<Geometry>(GEOMETRIES))]
    pub geometry: Option<Geometry>,
    #[arg(long = doc::MAX_ERROR_PX.name, value_name = "PX", help = short_help(doc::MAX_ERROR_PX), long_help = long_help(doc::MAX_ERROR_PX))]
    pub max_error_px: Option<f32>,
    #[arg(long = doc::MIN_INLIERS.name, value_name = "N", help = short_help(doc::MIN_INLIERS), long_help = long_help(doc::MIN_INLIERS))]
    pub min_inliers: Option<usize>,
    #[arg(long = doc::CONFIDENCE.name, value_name = "P", help = short_help(doc::CONFIDENCE), long_help = long_help(doc::CONFIDENCE))]
    pub confidence: Option<f32>,
    #[arg(long = doc::MAX_ITERATIONS.name, value_name = "N", help = short_help(doc::MAX_ITERATIONS), long_help = long_help(doc::MAX_ITERATIONS))]
    pub max_iterations: Option<usize>,
    #[arg(long = doc::SEED.name, value_name = "N", help = short_help(doc::SEED), long_help = long_help(doc::SEED))]
    pub seed: Option<u64>,
    #[arg(long = doc::CAMERA.name, value_name = "CAMERA", help = camera_help(), long_help = long_camera_help(), value_parser = parse_camera)]
    pub camera: Option<Camera>,
}

impl MatchingArgs {
    /// Parameters, checked. With a camera and no geometry, matches are verified by the essential matrix.
    ///
    /// # Errors
    /// When a parameter makes no sense.
    pub fn params(&self) -> Result<MatchParams, Failure> {
        let default = MatchParams::default();
        let geometry = if self.camera.is_some() { Geometry::Essential } else { default.geometry };
        let params = MatchParams {
            ratio: self.ratio.unwrap_or(default.ratio),
            mutual: self.mutual.unwrap_or(default.mutual),
            geometry: self.geometry.unwrap_or(geometry),
            max_error_px: self.max_error_px.unwrap_or(default.max_error_px),
            min_inliers: self.min_inliers.unwrap_or(default.min_inliers),
            confidence: self.confidence.unwrap_or(default.confidence),
            max_iterations: self.max_iterations.unwrap_or(default.max_iterations),
            seed: self.seed.unwrap_or(default.seed),
            camera: self.camera.clone(),
        };
        params.validate()?;
        Ok(params)
    }
}

/// Text of `-h` for a parameter: its meaning and default.
fn short_help(doc: ParamDoc) -> String {
    format!("{} [default: {}]", doc.meaning.trim_end_matches('.'), default_of(doc))
}

/// Text of `--help` for a parameter: all of its description, and its default.
fn long_help(doc: ParamDoc) -> String {
    format!("{} [default: {}]", doc.help(), default_of(doc))
}

fn geometry_help() -> String {
    format!("{}, or essential with a camera]", short_help(doc::GEOMETRY).trim_end_matches(']'))
}

fn camera_help() -> String {
    format!("{}; or a TOML file", doc::CAMERA.meaning.trim_end_matches('.'))
}

fn long_camera_help() -> String {
    format!("{} Or a TOML file with model, width, height and params.", doc::CAMERA.help())
}

/// Default of a parameter, as written on the command line.
fn default_of(doc: ParamDoc) -> String {
    let params = serde_json::to_value(MatchParams::default()).ok();
    match params.as_ref().and_then(|v| v.get(doc.name.replace('-', "_"))) {
        None => "none".to_owned(),
        Some(serde_json::Value::String(word)) => word.clone(),
        // By way of f32, so that 0.8 is not shown with the digits of a double.
        Some(serde_json::Value::Number(n)) if n.is_f64() => (n.as_f64().unwrap_or_default() as f32).to_string(),
        Some(value) => value.to_string(),
    }
}

/// Reads a camera from words, or from a file whose name ends in `.toml`.
fn parse_camera(text: &str) -> Result<Camera, String> {
    if text.to_lowercase().ends_with(".toml") {
        return read_camera(Path::new(text)).map_err(|e| format!("{}; {}", e.problem, e.remedy));
    }
    text.parse()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{CommandFactory, Parser};

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        matching: MatchingArgs,
    }

    fn params(arguments: &[&str]) -> Result<MatchParams, String> {
        let only = Only::try_parse_from([&["x"], arguments].concat()).map_err(|e| e.to_string())?;
        only.matching.params().map_err(|f| format!("{f:?}"))
    }

    #[test]
    fn every_parameter_is_an_option_whose_default_can_be_typed() {
        let command = Only::command();
        for doc in doc::ALL {
            let arg = command.get_arguments().find(|a| a.get_long() == Some(doc.name));
            let arg = arg.unwrap_or_else(|| panic!("--{} is missing", doc.name));
            let help = arg.get_help().expect("it has help").to_string();
            assert!(help.starts_with(doc.meaning.trim_end_matches('.')), "{help}");
            if doc.name != doc::CAMERA.name {
                let typed = params(&[&format!("--{}", doc.name), &default_of(doc)]);
                assert_eq!(typed, Ok(MatchParams::default()), "{}", doc.name);
            }
        }
        assert_eq!(params(&[]), Ok(MatchParams::default()));
    }

    #[test]
    fn every_option_reaches_its_parameter() {
        let camera = "SIMPLE_PINHOLE,64,48,50,32,24";
        let got = params(&[
            "--ratio",
            "0.7",
            "--mutual",
            "false",
            "--geometry",
            "homography",
            "--max-error-px",
            "2",
            "--min-inliers",
            "9",
            "--confidence",
            "0.99",
            "--max-iterations",
            "77",
            "--seed",
            "5",
            "--camera",
            camera,
        ]);
        let expected = MatchParams {
            ratio: 0.7,
            mutual: false,
            geometry: Geometry::Homography,
            max_error_px: 2.0,
            min_inliers: 9,
            confidence: 0.99,
            max_iterations: 77,
            seed: 5,
            camera: Some(camera.parse().expect("a camera")),
        };
        assert_eq!(got, Ok(expected));
        assert_eq!(params(&["--camera", camera]).map(|p| p.geometry), Ok(Geometry::Essential));
    }

    #[test]
    fn nonsense_says_what_would_be_right() {
        for (arguments, words) in [
            (["--ratio", "0"], "0.8 is usual"),
            (["--geometry", "affine"], "none, fundamental, essential, homography"),
            (["--geometry", "essential"], "intrinsics"),
            (["--camera", "FISHEYE,1,2,3"], "SIMPLE_PINHOLE"),
            (["--camera", "gone.toml"], "gone.toml"),
        ] {
            let error = params(&arguments).expect_err(words);
            assert!(error.contains(words), "{error}");
        }
    }
}
