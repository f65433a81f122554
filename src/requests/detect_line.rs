//! Command line that finds a burst's features with given parameters: the window copies it, and a test holds that the
//! command understands it.

use crate::burst::{OpenOptions, RawColour};
use crate::detector::params::doc;
use crate::detector::{DetectorParams, SearchParams, SlopeAxis, SlopeChoice};
use serde::Serialize;
use std::path::PathBuf;

const OUT: &str = "features";

/// `inputs` are paths, or names of built-in bursts. Quoted for a shell; values that are the default are left out.
pub fn detect_line(inputs: &[String], params: &SearchParams, calibration: &OpenOptions) -> String {
    let mut words = vec!["burstscope".to_owned(), "detect".to_owned()];
    // A path that begins with a dash would be read as an option.
    let path = |input: &String| if input.starts_with('-') { format!("./{input}") } else { input.clone() };
    words.extend(inputs.iter().map(|input| quoted(&path(input))));
    words.extend(["--out".to_owned(), OUT.to_owned()]);
    for (name, value) in options(params).into_iter().chain(calibration_options(calibration)) {
        words.push(format!("--{name}"));
        words.extend(value.map(|value| quoted(&value)));
    }
    words.join(" ")
}

fn calibration_options(calibration: &OpenOptions) -> Vec<(&'static str, Option<String>)> {
    let OpenOptions {
        bias,
        flat,
        full_scale,
        black_level,
        linearise,
        accept_damaged,
        mask,
        mask_saturated,
        raw_colour,
        mosaic,
        raw,
        axis,
        array,
        topic,
        take,
        times,
        views,
        limits: _,
    } = calibration;
    let path = |path: &Option<PathBuf>| path.as_ref().map(|path| Some(path.display().to_string()));
    let number = |level: &Option<f32>| level.map(|level| Some(level.to_string()));
    let colour = Some(raw_colour).filter(|colour| **colour != RawColour::default()).and_then(word);
    let all = [
        ("bias", path(bias)),
        ("flat", path(flat)),
        ("full-scale", number(full_scale)),
        ("black-level", number(black_level)),
        ("linearise", linearise.then_some(None)),
        ("accept-damaged", accept_damaged.then_some(None)),
        ("mask", path(mask)),
        ("mask-saturated", mask_saturated.then_some(None)),
        ("raw-colour", colour.map(Some)),
        ("mosaic", mosaic.as_ref().and_then(word).map(Some)),
        ("raw", raw.map(|raw| Some(raw.to_string()))),
        ("axis", axis.as_ref().map(|axis| Some(axis.to_string()))),
        ("array", array.clone().map(Some)),
        ("topic", topic.clone().map(Some)),
        ("take", take.map(|range| Some(range.to_string()))),
        ("times", times.as_ref().map(|times| Some(times.to_string()))),
        ("views", views.map(|views| Some(views.to_string()))),
    ];
    all.into_iter().filter_map(|(name, value)| value.map(|value| (name, value))).collect()
}

/// Word of a value that is one of a few.
fn word(value: &impl Serialize) -> Option<String> {
    Some(serde_json::to_value(value).ok()?.as_str()?.to_owned())
}

fn options(params: &SearchParams) -> Vec<(&'static str, Option<String>)> {
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
    options.into_iter().map(|(name, value)| (name, Some(value))).collect()
}

fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-:+,=@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}
