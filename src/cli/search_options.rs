//! Search options, shared by the commands: raw arguments and the parameters checked from them.
//!
//! Names and help texts are those of [`crate::detector::params::doc`]. A parameter file is read first, then each given
//! option overrides its value; the result is checked once.

use super::choices::{
    AUTO_WORDS, AutoWord, DESCRIBE_SLOPES, FLICKERS, INTERPOLATIONS, LOCALISATIONS, METHODS, NOISE_MODELS,
    SLOPE_EXTREMA, SLOPE_NEIGHBOURS, words,
};
use super::failure::Failure;
use crate::detector::params::doc;
use crate::detector::{
    DescribeSlope, DetectorParams, Distinct, Flicker, FrameRange, Interpolation, Localisation, Method, NoiseGate,
    NoiseModelKind, ParamDoc, SearchParams, Slope, SlopeAxis, SlopeChoice, SlopeExtrema, SlopeGrid, SlopeNeighbours,
};
use crate::files::{MAX_SETTINGS_BYTES, explained, read_text};
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Ids of the options that give ranges of slopes.
const AXIS_U: &str = "slopes_u";
const AXIS_V: &str = "slopes_v";

/// The parameter file.
#[derive(Debug, Clone, Default, Args)]
pub struct ParamsFileArg {
    /// Parameter file (TOML), as the window saves it.
    #[arg(long, value_name = "FILE.toml")]
    pub params: Option<PathBuf>,
}

/// The search options as they are written.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Search options", allow_negative_numbers = true)]
#[allow(missing_docs)] // each is described by its `doc` constant
pub struct SearchArgs {
    #[command(flatten)]
    pub file: ParamsFileArg,
    #[arg(long = doc::METHOD.name, value_name = "METHOD", help = short_help(doc::METHOD), long_help = long_help(doc::METHOD),
        value_parser = words::<Method>(METHODS))]
    pub method: Option<Method>,
    #[arg(long = doc::SLOPES.name, value_name = "auto", help = short_help(doc::SLOPES), long_help = long_help(doc::SLOPES),
        value_parser = words::<AutoWord>(AUTO_WORDS), conflicts_with_all = [AXIS_U, AXIS_V])]
    pub slopes: Option<AutoWord>,
    #[arg(long = doc::SLOPES_U.name, value_name = "MIN:MAX:COUNT", help = short_help(doc::SLOPES_U), long_help = long_help(doc::SLOPES_U),
        allow_hyphen_values = true, value_parser = SlopeAxis::from_str)]
    pub slopes_u: Option<SlopeAxis>,
    #[arg(long = doc::SLOPES_V.name, value_name = "MIN:MAX:COUNT", help = short_help(doc::SLOPES_V), long_help = long_help(doc::SLOPES_V),
        allow_hyphen_values = true, value_parser = SlopeAxis::from_str)]
    pub slopes_v: Option<SlopeAxis>,
    #[arg(long = doc::SLOPE_DIRECTION.name, value_name = "DEGREES", help = short_help(doc::SLOPE_DIRECTION),
        long_help = long_help(doc::SLOPE_DIRECTION), allow_hyphen_values = true)]
    pub slope_direction: Option<f32>,
    #[arg(long = doc::FRAMES.name, value_name = "A..B", help = short_help(doc::FRAMES), long_help = long_help(doc::FRAMES),
        value_parser = FrameRange::from_str)]
    pub frames: Option<FrameRange>,
    #[arg(long = doc::OCTAVES.name, value_name = "N", help = short_help(doc::OCTAVES), long_help = long_help(doc::OCTAVES))]
    pub octaves: Option<u32>,
    #[arg(long = doc::LEVELS.name, value_name = "N", help = short_help(doc::LEVELS), long_help = long_help(doc::LEVELS))]
    pub levels: Option<u32>,
    #[arg(long = doc::FIRST_OCTAVE.name, value_name = "O", help = short_help(doc::FIRST_OCTAVE), long_help = long_help(doc::FIRST_OCTAVE),
        allow_hyphen_values = true)]
    pub first_octave: Option<i32>,
    #[arg(long = doc::PEAK_THRESHOLD.name, value_name = "T", help = short_help(doc::PEAK_THRESHOLD), long_help = long_help(doc::PEAK_THRESHOLD))]
    pub peak_threshold: Option<f32>,
    #[arg(long = doc::NOISE_GATE.name, value_name = "K", help = short_help(doc::NOISE_GATE), long_help = long_help(doc::NOISE_GATE),
        value_parser = NoiseGate::from_str)]
    pub noise_gate: Option<NoiseGate>,
    #[arg(long = doc::NOISE_MODEL.name, value_name = "MODEL", help = short_help(doc::NOISE_MODEL), long_help = long_help(doc::NOISE_MODEL),
        value_parser = words::<NoiseModelKind>(NOISE_MODELS))]
    pub noise_model: Option<NoiseModelKind>,
    #[arg(long = doc::FLICKER.name, value_name = "WHAT", help = short_help(doc::FLICKER), long_help = long_help(doc::FLICKER),
        value_parser = words::<Flicker>(FLICKERS))]
    pub flicker: Option<Flicker>,
    #[arg(long = doc::EDGE_THRESHOLD.name, value_name = "R", help = short_help(doc::EDGE_THRESHOLD), long_help = long_help(doc::EDGE_THRESHOLD))]
    pub edge_threshold: Option<f32>,
    #[arg(long = doc::SLOPE_EXTREMA.name, value_name = "WHICH", help = short_help(doc::SLOPE_EXTREMA),
        long_help = long_help(doc::SLOPE_EXTREMA), value_parser = words::<SlopeExtrema>(SLOPE_EXTREMA))]
    pub slope_extrema: Option<SlopeExtrema>,
    #[arg(long = doc::SLOPE_NEIGHBOURS.name, value_name = "WHICH", help = short_help(doc::SLOPE_NEIGHBOURS),
        long_help = long_help(doc::SLOPE_NEIGHBOURS), value_parser = words::<SlopeNeighbours>(SLOPE_NEIGHBOURS))]
    pub slope_neighbours: Option<SlopeNeighbours>,
    #[arg(long = doc::DISTINCT.name, value_name = "RADIUS", help = short_help(doc::DISTINCT), long_help = long_help(doc::DISTINCT),
        value_parser = Distinct::from_str)]
    pub distinct: Option<Distinct>,
    #[arg(long = doc::DISTINCT_SCALE.name, value_name = "RATIO", help = short_help(doc::DISTINCT_SCALE), long_help = long_help(doc::DISTINCT_SCALE))]
    pub distinct_scale: Option<f32>,
    #[arg(long = doc::INTERPOLATION.name, value_name = "HOW", help = short_help(doc::INTERPOLATION), long_help = long_help(doc::INTERPOLATION),
        value_parser = words::<Interpolation>(INTERPOLATIONS))]
    pub interpolation: Option<Interpolation>,
    #[arg(long = doc::KERNEL_CUT.name, value_name = "N", help = short_help(doc::KERNEL_CUT), long_help = long_help(doc::KERNEL_CUT))]
    pub kernel_cut: Option<f32>,
    #[arg(long = doc::LOCALISATION.name, value_name = "WORD", value_parser = words::<Localisation>(LOCALISATIONS), help = short_help(doc::LOCALISATION), long_help = long_help(doc::LOCALISATION))]
    pub localisation: Option<Localisation>,
    #[arg(long = doc::MAX_FEATURES.name, value_name = "N", help = short_help(doc::MAX_FEATURES), long_help = long_help(doc::MAX_FEATURES))]
    pub max_features: Option<usize>,
    #[arg(long = doc::MAX_ORIENTATIONS.name, value_name = "N", help = short_help(doc::MAX_ORIENTATIONS),
        long_help = long_help(doc::MAX_ORIENTATIONS))]
    pub max_orientations: Option<usize>,
    #[arg(long = doc::DESCRIBE_SLOPE.name, value_name = "WHICH", help = short_help(doc::DESCRIBE_SLOPE),
        long_help = long_help(doc::DESCRIBE_SLOPE), value_parser = words::<DescribeSlope>(DESCRIBE_SLOPES))]
    pub describe_slope: Option<DescribeSlope>,
}

/// Text of `-h` for a parameter: its meaning and default.
fn short_help(doc: ParamDoc) -> String {
    format!("{} [default: {}]", doc.meaning.trim_end_matches('.'), default_of(doc))
}

/// Text of `--help` for a parameter: all of its description, and its default.
fn long_help(doc: ParamDoc) -> String {
    format!("{} [default: {}]", doc.help(), default_of(doc))
}

/// Default of a parameter, as written on the command line.
fn default_of(doc: ParamDoc) -> String {
    let params = DetectorParams::default();
    match doc.name {
        name if name == doc::SLOPES.name => "auto, unless ranges are given".to_owned(),
        name if name == doc::SLOPES_U.name || name == doc::SLOPES_V.name => {
            "found; 0 if only the other one is given".to_owned()
        }
        name if name == doc::SLOPE_DIRECTION.name => "found; 0 if ranges are given".to_owned(),
        name => match serde_json::to_value(params).ok().as_ref().and_then(|v| v.get(name.replace('-', "_"))) {
            None => "all".to_owned(),
            Some(serde_json::Value::String(word)) => word.clone(),
            // By way of f32, so that 0.001 is not shown with the digits of a double.
            Some(serde_json::Value::Number(n)) if n.is_f64() => (n.as_f64().unwrap_or_default() as f32).to_string(),
            Some(value) => value.to_string(),
        },
    }
}

impl ParamsFileArg {
    /// Parameters in the file, or the defaults without a file.
    ///
    /// # Errors
    /// When the file cannot be read (a failure) or makes no sense (wrong use). Both errors name the file.
    pub fn read(&self) -> Result<SearchParams, Failure> {
        self.params.as_deref().map_or_else(|| Ok(SearchParams::default()), read_params)
    }
}

fn read_params(path: &Path) -> Result<SearchParams, Failure> {
    let text = read_text(path, MAX_SETTINGS_BYTES)
        .with_context(|| format!("cannot read the parameter file {}", path.display()))
        .map_err(Failure::Failed)?;
    SearchParams::from_toml(&text).map_err(|e| {
        let why = explained(&text, e.trim_end());
        Failure::usage(format!("the parameter file {} makes no sense: {why}", path.display()))
    })
}

impl SearchArgs {
    /// Parameters, checked, with the choice of slopes.
    ///
    /// Slopes are found from each burst unless ranges are given here or in the file; a direction alone restricts the
    /// search to a line in that direction. An axis of slopes that is missing is the file's, or 0 where the file has no
    /// ranges.
    ///
    /// # Errors
    /// When the parameter file cannot be read or makes no sense, or a combination of options makes no sense.
    pub fn params(&self) -> Result<SearchParams, Failure> {
        let mut params = self.file.read()?;
        self.choose_slopes(&mut params);
        self.set_detector(&mut params.detector);
        params.validate()?;
        Ok(params)
    }

    fn choose_slopes(&self, params: &mut SearchParams) {
        let ranges = self.slopes_u.is_some() || self.slopes_v.is_some();
        if self.slopes.is_some() {
            params.slopes = SlopeChoice::AUTO;
        } else if ranges && params.slopes.is_auto() {
            params.detector.slopes = SlopeGrid::single(Slope::default());
            params.slopes = SlopeChoice::Given;
        }
        let grid = &mut params.detector.slopes;
        grid.u = self.slopes_u.unwrap_or(grid.u);
        grid.v = self.slopes_v.unwrap_or(grid.v);
        match &mut params.slopes {
            SlopeChoice::Given => grid.direction_deg = self.slope_direction.unwrap_or(grid.direction_deg),
            SlopeChoice::Auto { direction_deg } => *direction_deg = self.slope_direction.or(*direction_deg),
        }
    }

    fn set_detector(&self, params: &mut DetectorParams) {
        fn set<T: Copy>(field: &mut T, given: Option<T>) {
            if let Some(value) = given {
                *field = value;
            }
        }
        set(&mut params.method, self.method);
        params.frames = self.frames.or(params.frames);
        set(&mut params.octaves, self.octaves);
        set(&mut params.levels, self.levels);
        set(&mut params.first_octave, self.first_octave);
        set(&mut params.peak_threshold, self.peak_threshold);
        set(&mut params.noise_gate, self.noise_gate);
        set(&mut params.noise_model, self.noise_model);
        set(&mut params.flicker, self.flicker);
        set(&mut params.edge_threshold, self.edge_threshold);
        set(&mut params.slope_extrema, self.slope_extrema);
        set(&mut params.slope_neighbours, self.slope_neighbours);
        set(&mut params.distinct, self.distinct);
        set(&mut params.distinct_scale, self.distinct_scale);
        set(&mut params.interpolation, self.interpolation);
        set(&mut params.kernel_cut, self.kernel_cut);
        set(&mut params.localisation, self.localisation);
        set(&mut params.max_features, self.max_features);
        set(&mut params.max_orientations, self.max_orientations);
        set(&mut params.describe_slope, self.describe_slope);
    }
}

#[cfg(test)]
mod tests;
