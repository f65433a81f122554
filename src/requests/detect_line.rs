//! Command line that finds a burst's features with given parameters: the window copies it, and a test holds that the
//! command understands it.

use crate::burst::OpenOptions;
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SearchParams, SlopeAxis, SlopeChoice};
use crate::files::shell_word;

const OUT: &str = "features";

/// `inputs` are paths, or names of built-in bursts. Quoted for a shell; values that are the default are left out.
pub fn detect_line(inputs: &[String], params: &SearchParams, calibration: &OpenOptions) -> String {
    let mut words = vec!["burstscope".to_owned(), "detect".to_owned()];
    // A path that begins with a dash would be read as an option.
    let path = |input: &String| if input.starts_with('-') { format!("./{input}") } else { input.clone() };
    words.extend(inputs.iter().map(|input| shell_word(&path(input))));
    words.extend(["--out".to_owned(), OUT.to_owned()]);
    for (name, value) in options(params).into_iter().chain(calibration.given()) {
        words.push(format!("--{name}"));
        words.extend(value.map(|value| shell_word(&value)));
    }
    words.join(" ")
}

fn options(params: &SearchParams) -> Vec<(String, Option<String>)> {
    let mut options = Vec::new();
    let grid = &params.detector.slopes;
    match params.slopes {
        SlopeChoice::Auto { direction_deg } => {
            options.extend(direction_deg.map(|degrees| (doc::SLOPE_DIRECTION.name, degrees.to_string())));
        }
        SlopeChoice::Given => {
            options.push((doc::SLOPES_U.name, grid.u.to_string()));
            if grid.v != SlopeAxis::ZERO {
                options.push((doc::SLOPES_V.name, grid.v.to_string()));
            }
            if grid.direction_deg != 0.0 {
                options.push((doc::SLOPE_DIRECTION.name, grid.direction_deg.to_string()));
            }
        }
    }
    let implied = DetectorParams::implied_by(params.detector.rules);
    let said = [doc::SLOPES, doc::SLOPES_U, doc::SLOPES_V, doc::SLOPE_DIRECTION];
    for record in doc::ALL.iter().filter(|record| !said.contains(record)) {
        let own = record.text(&params.detector);
        if own != record.text(&implied) {
            options.push((record.name, own));
        }
    }
    options.into_iter().map(|(name, value)| (name.to_owned(), Some(value))).collect()
}
