//! The parameters of the detector: defined, described and checked here and nowhere else.
//!
//! The command line, the window and the parameter file use these names, and their help texts come from [`ParamDoc`].
//! A parameter file is TOML with the fields of [`DetectorParams`]; a missing field has its default.

use super::slope_grid::SlopeGrid;
use serde::{Deserialize, Serialize};

/// Which detector runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The burst feature finder: joint extrema over place, scale and slope. One line of slopes is BuFF 1D, a plane of slopes BuFF 2D.
    #[default]
    Buff,
    /// SIFT on the middle frame of those used: the same detector with one frame and slope 0.
    Sift,
}

impl Method {
    /// All methods, in the order in which they are offered.
    pub const ALL: [Self; 2] = [Self::Buff, Self::Sift];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Buff => "buff",
            Self::Sift => "sift",
        }
    }
}

/// With which slopes a candidate is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SlopeNeighbours {
    /// The neighbouring slopes of the grid: 2 on a line (as LiFF does), 8 in a plane.
    #[default]
    Adjacent,
    /// Every slope of the grid, as the authors' code does.
    All,
}

/// How frames are sampled between pixels when they are shifted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Bilinear.
    #[default]
    Linear,
    /// The nearest pixel, as LiFF and the authors' code do.
    Nearest,
}

/// How the place and slope of an extremum between the samples are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Localisation {
    /// On the continuous D (see [`super::locate`]).
    #[default]
    Continuous,
    /// By a quadratic fit to the samples around it, as VLFeat and LiFF do.
    Quadratic,
}

/// The noise gate: how many standard deviations of the noise in D a response must reach.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum NoiseGate {
    /// The factor is derived from the size of the search so that pure noise gives at most about one false feature per megapixel.
    #[default]
    Auto,
    /// This factor; 0 switches the gate off.
    Factor(f32),
}

impl std::fmt::Display for NoiseGate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Factor(k) => write!(f, "{k}"),
        }
    }
}

impl std::str::FromStr for NoiseGate {
    type Err = String;

    /// Reads `auto` or a number.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "auto" => Ok(Self::Auto),
            number => number
                .parse()
                .map(Self::Factor)
                .map_err(|_| format!("'{text}' is neither 'auto' nor a number of standard deviations")),
        }
    }
}

impl Serialize for NoiseGate {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Factor(k) => serializer.serialize_f32(*k),
        }
    }
}

impl<'de> Deserialize<'de> for NoiseGate {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Either {
            Number(f32),
            Word(String),
        }
        match Either::deserialize(deserializer)? {
            Either::Number(k) => Ok(Self::Factor(k)),
            Either::Word(word) => word.parse().map_err(serde::de::Error::custom),
        }
    }
}

/// Frames `start..end` of the burst (`end` excluded), as `--frames A..B` names them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameRange {
    /// First frame used, counted from 0.
    pub start: usize,
    /// One past the last frame used.
    pub end: usize,
}

impl std::fmt::Display for FrameRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}..{}", self.start, self.end)
    }
}

impl std::str::FromStr for FrameRange {
    type Err = String;

    /// Reads `A..B`, the frames A … B−1.
    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || format!("'{text}' is not A..B, such as 0..10 for the first ten frames");
        let (start, end) = text.split_once("..").ok_or_else(bad)?;
        Ok(Self { start: start.trim().parse().map_err(|_| bad())?, end: end.trim().parse().map_err(|_| bad())? })
    }
}

/// Everything that decides what the detector finds. The same burst and the same parameters give the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectorParams {
    /// See [`doc::METHOD`].
    pub method: Method,
    /// See [`doc::FRAMES`]; `None` uses all frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameRange>,
    /// See [`doc::OCTAVES`].
    pub octaves: u32,
    /// See [`doc::LEVELS`].
    pub levels: u32,
    /// See [`doc::FIRST_OCTAVE`].
    pub first_octave: i32,
    /// See [`doc::PEAK_THRESHOLD`].
    pub peak_threshold: f32,
    /// See [`doc::NOISE_GATE`].
    pub noise_gate: NoiseGate,
    /// See [`doc::EDGE_THRESHOLD`].
    pub edge_threshold: f32,
    /// See [`doc::SLOPE_NEIGHBOURS`].
    pub slope_neighbours: SlopeNeighbours,
    /// See [`doc::INTERPOLATION`].
    pub interpolation: Interpolation,
    /// See [`doc::KERNEL_CUT`].
    pub kernel_cut: f32,
    /// See [`doc::LOCALISATION`].
    pub localisation: Localisation,
    /// See [`doc::MAX_FEATURES`]; 0 keeps all.
    pub max_features: usize,
    /// See [`doc::MAX_ORIENTATIONS`].
    pub max_orientations: usize,
    /// See [`doc::SLOPES_U`], [`doc::SLOPES_V`] and [`doc::SLOPE_DIRECTION`].
    pub slopes: SlopeGrid,
}

impl Default for DetectorParams {
    fn default() -> Self {
        Self {
            method: Method::Buff,
            frames: None,
            octaves: 6,
            levels: 3,
            first_octave: 0,
            peak_threshold: 0.0003,
            noise_gate: NoiseGate::Auto,
            edge_threshold: 10.0,
            slope_neighbours: SlopeNeighbours::Adjacent,
            interpolation: Interpolation::Linear,
            kernel_cut: 4.0,
            localisation: Localisation::Continuous,
            max_features: 0,
            max_orientations: 1,
            slopes: SlopeGrid::default(),
        }
    }
}

/// What a person needs to know about one parameter, in the words that every surface shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParamDoc {
    /// Name on the command line, without dashes in front; the file's field has `_` for `-`.
    pub name: &'static str,
    /// Name in the window, in sentence case.
    pub label: &'static str,
    /// Unit of its value; empty when it has none.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// What raising (or changing) it does.
    pub effect: &'static str,
}

impl ParamDoc {
    /// Meaning, unit and effect as running text, for help pages and tooltips.
    pub fn help(&self) -> String {
        if self.unit.is_empty() {
            format!("{} {}", self.meaning, self.effect)
        } else {
            format!("{} Unit: {}. {}", self.meaning, self.unit, self.effect)
        }
    }
}

/// The descriptions of all parameters.
pub mod doc {
    use super::ParamDoc;

    macro_rules! doc {
        ($id:ident, $name:literal, $label:literal, $unit:literal, $meaning:literal, $effect:literal) => {
            #[doc = concat!($meaning, " ", $effect)]
            pub const $id: ParamDoc =
                ParamDoc { name: $name, label: $label, unit: $unit, meaning: $meaning, effect: $effect };
        };
    }
    doc!(
        METHOD,
        "method",
        "Method",
        "",
        "The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame.",
        "Sift is the baseline that the burst has to beat."
    );
    doc!(
        SLOPES_U,
        "slopes-u",
        "Slopes u",
        "px/frame",
        "The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT.",
        "A wider range finds faster motion; a step much above 2σ/(N−1) misses features between slopes, a finer one only costs time."
    );
    doc!(
        SLOPES_V,
        "slopes-v",
        "Slopes v",
        "px/frame",
        "The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT.",
        "More than one makes the search two-dimensional (BuFF 2D) and multiplies its time."
    );
    doc!(
        SLOPE_DIRECTION,
        "slope-direction",
        "Direction",
        "degrees",
        "Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point anywhere.",
        "Set it to the direction in which the camera moves; 90 searches vertical motion."
    );
    doc!(
        FRAMES,
        "frames",
        "Frames used",
        "frames",
        "The frames A … B−1 that are searched; all of them if absent.",
        "More frames lower the noise, as long as the motion stays straight; features are reported at the middle of those used."
    );
    doc!(
        OCTAVES,
        "octaves",
        "Octaves",
        "",
        "How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image gets too small.",
        "More octaves find larger blobs, at little cost."
    );
    doc!(
        LEVELS,
        "levels",
        "Levels",
        "per octave",
        "Scales per octave.",
        "More levels sample scale more finely and cost time in proportion."
    );
    doc!(
        FIRST_OCTAVE,
        "first-octave",
        "First octave",
        "",
        "The finest octave: 0 starts at the image's own resolution, −1 at the doubled image.",
        "−1 finds smaller features, of which noise has many, for about four times the time; 1 and above skip fine scales."
    );
    doc!(
        PEAK_THRESHOLD,
        "peak-threshold",
        "Peak threshold",
        "of full scale",
        "The least |DoG| of a feature, after interpolation, as a fraction of full scale.",
        "Raise it to keep only features of higher contrast; it knows nothing of the noise."
    );
    doc!(
        NOISE_GATE,
        "noise-gate",
        "Noise gate",
        "σ of the noise in D",
        "The least |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and level; auto derives it from the size of the search, 0 switches it off.",
        "Raise it to eliminate more noise; lower it to see fainter features among more false ones."
    );
    doc!(
        EDGE_THRESHOLD,
        "edge-threshold",
        "Edge threshold",
        "",
        "The largest ratio of the principal curvatures of D.",
        "Raise it to keep more features on edges, which are poorly localised along the edge."
    );
    doc!(
        SLOPE_NEIGHBOURS,
        "slope-neighbours",
        "Slope neighbours",
        "",
        "The slopes that a feature must beat: adjacent ones of the grid, or all.",
        "All keeps at most one slope per place and scale and needs more memory; adjacent lets two motions share a place."
    );
    doc!(
        INTERPOLATION,
        "interpolation",
        "Interpolation",
        "",
        "How frames are sampled between pixels when they are shifted: linear or nearest.",
        "Nearest reproduces the published implementations; linear is more accurate."
    );
    doc!(
        KERNEL_CUT,
        "kernel-cut",
        "Kernel cut",
        "σ",
        "Where the Gaussian kernels end, in standard deviations.",
        "4 is exact to a thousandth; 2 reproduces the authors' code, which misses some sizes of blobs by it."
    );
    doc!(
        LOCALISATION,
        "localisation",
        "Localisation",
        "",
        "How the place and slope between the samples are found: continuous or quadratic.",
        "Continuous follows D itself to its extremum and is about twice as exact; quadratic reproduces VLFeat and LiFF."
    );
    doc!(
        MAX_FEATURES,
        "max-features",
        "Max features",
        "features",
        "Keep only this many features, the strongest by response times the square root of the signal-to-noise ratio; 0 keeps all.",
        "Lower it to keep only the most reliable."
    );
    doc!(
        MAX_ORIENTATIONS,
        "max-orientations",
        "Max orientations",
        "per keypoint",
        "How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own.",
        "Raise it to match ambiguous places under rotation (VLFeat and LiFF use 4), for more features at one place."
    );

    /// All of them, in the order in which surfaces show them.
    pub const ALL: [ParamDoc; 17] = [
        METHOD,
        SLOPES_U,
        SLOPES_V,
        SLOPE_DIRECTION,
        FRAMES,
        OCTAVES,
        LEVELS,
        FIRST_OCTAVE,
        PEAK_THRESHOLD,
        NOISE_GATE,
        EDGE_THRESHOLD,
        SLOPE_NEIGHBOURS,
        INTERPOLATION,
        KERNEL_CUT,
        LOCALISATION,
        MAX_FEATURES,
        MAX_ORIENTATIONS,
    ];
}

/// A parameter, or a combination of them, that makes no sense: which, why, and what would.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{parameter}: {problem}; {remedy}")]
pub struct ParamError {
    /// [`ParamDoc::name`] of the parameter to change.
    pub parameter: &'static str,
    /// What is wrong.
    pub problem: String,
    /// What would be right.
    pub remedy: String,
}

/// The most slopes that a grid may have.
pub const MAX_SLOPES: usize = 4096;

impl DetectorParams {
    /// Checks the parameters alone, without a burst.
    ///
    /// # Errors
    /// The first parameter that makes no sense.
    pub fn validate(&self) -> Result<(), ParamError> {
        let fail = |parameter: ParamDoc, problem: String, remedy: &str| {
            Err(ParamError { parameter: parameter.name, problem, remedy: remedy.to_owned() })
        };
        for (axis, parameter) in [(&self.slopes.u, doc::SLOPES_U), (&self.slopes.v, doc::SLOPES_V)] {
            if !(axis.min.is_finite() && axis.max.is_finite()) {
                return fail(parameter, "the range is not finite".into(), "give two numbers of pixels per frame");
            }
            if axis.count == 0 {
                return fail(parameter, "the count is 0".into(), "give at least 1 slope");
            }
            if axis.min > axis.max {
                return fail(parameter, format!("{} is above {}", axis.min, axis.max), "give the smaller slope first");
            }
            if axis.count > 1 && axis.min == axis.max {
                return fail(
                    parameter,
                    format!("{} slopes on an empty range", axis.count),
                    "widen the range, or ask for 1 slope",
                );
            }
            if axis.count > MAX_SLOPES {
                return fail(
                    parameter,
                    format!("{} slopes", axis.count),
                    "at most 4096 slopes are searched; use a coarser step",
                );
            }
        }
        if self.slopes.len() > MAX_SLOPES {
            return fail(
                doc::SLOPES_V,
                format!("the grid has {} slopes", self.slopes.len()),
                "at most 4096 slopes are searched; use coarser steps",
            );
        }
        if !self.slopes.direction_deg.is_finite() {
            return fail(doc::SLOPE_DIRECTION, "it is not finite".into(), "give degrees");
        }
        if let Some(range) = self.frames
            && range.start >= range.end
        {
            return fail(doc::FRAMES, format!("{range} holds no frame"), "give A..B with A below B");
        }
        if !(1..=16).contains(&self.octaves) {
            return fail(doc::OCTAVES, format!("{} octaves", self.octaves), "give 1 to 16");
        }
        if !(1..=10).contains(&self.levels) {
            return fail(doc::LEVELS, format!("{} levels", self.levels), "give 1 to 10");
        }
        if !(-1..=8).contains(&self.first_octave) {
            return fail(doc::FIRST_OCTAVE, format!("{}", self.first_octave), "give -1 to 8");
        }
        if !(self.peak_threshold.is_finite() && self.peak_threshold >= 0.0) {
            return fail(
                doc::PEAK_THRESHOLD,
                format!("{}", self.peak_threshold),
                "give 0 or more, as a fraction of full scale",
            );
        }
        if let NoiseGate::Factor(k) = self.noise_gate
            && !(k.is_finite() && k >= 0.0)
        {
            return fail(doc::NOISE_GATE, format!("{k}"), "give auto, or 0 or more standard deviations");
        }
        if !(self.edge_threshold.is_finite() && self.edge_threshold >= 1.0) {
            return fail(doc::EDGE_THRESHOLD, format!("{}", self.edge_threshold), "give 1 or more (10 is usual)");
        }
        if !(self.kernel_cut.is_finite() && (1.0..=8.0).contains(&self.kernel_cut)) {
            return fail(
                doc::KERNEL_CUT,
                format!("{}", self.kernel_cut),
                "give 1 to 8 standard deviations (4 is usual)",
            );
        }
        if !(1..=4).contains(&self.max_orientations) {
            return fail(doc::MAX_ORIENTATIONS, format!("{}", self.max_orientations), "give 1 to 4");
        }
        Ok(())
    }

    /// Checks the parameters against a burst of `frame_count` frames of `size` = (columns, rows).
    ///
    /// # Errors
    /// The first parameter that makes no sense for it.
    pub fn validate_for(&self, frame_count: usize, size: (usize, usize)) -> Result<(), ParamError> {
        self.validate()?;
        let fail = |parameter: ParamDoc, problem: String, remedy: String| {
            Err(ParamError { parameter: parameter.name, problem, remedy })
        };
        if let Some(range) = self.frames
            && range.end > frame_count
        {
            return fail(
                doc::FRAMES,
                format!("{range} reaches past the burst's {frame_count} frames"),
                format!("give A..B with B at most {frame_count}"),
            );
        }
        let shift = self.first_octave;
        let side = |pixels: usize| if shift < 0 { pixels * 2 } else { pixels >> shift };
        if side(size.0.min(size.1)) < MIN_OCTAVE_SIDE {
            return fail(
                doc::FIRST_OCTAVE,
                format!(
                    "octave {shift} of a {}×{} image is under {MIN_OCTAVE_SIDE} pixels wide or high",
                    size.0, size.1
                ),
                "start at a finer octave, or use a larger image".into(),
            );
        }
        if self.method == Method::Buff && self.used_frames(frame_count).len() == 1 && self.slopes.len() > 1 {
            return fail(
                doc::FRAMES,
                "a single frame shows no motion, so its slopes are all the same".into(),
                "use 2 frames or more, or the method sift".into(),
            );
        }
        let span = (self.used_frames(frame_count).len() - 1) as f32 * 0.5 * self.slopes.max_magnitude();
        let diagonal = (size.0 as f32).hypot(size.1 as f32);
        if self.method == Method::Buff && span >= diagonal {
            return fail(
                doc::SLOPES_U,
                format!(
                    "the largest slope moves a point {span:.0} px from mid-burst to its end, out of the {}×{} image",
                    size.0, size.1
                ),
                "give smaller slopes or fewer frames".into(),
            );
        }
        Ok(())
    }

    /// The frames that take part, as indices into the burst: the whole range for BuFF, its middle frame for SIFT.
    pub fn used_frames(&self, frame_count: usize) -> std::ops::Range<usize> {
        let range = self.frames.map_or(0..frame_count, |r| r.start..r.end.min(frame_count));
        match self.method {
            Method::Buff => range,
            Method::Sift => {
                let middle = range.start + range.len() / 2;
                middle..middle + 1
            }
        }
    }

    /// The slopes that take part: the grid for BuFF, slope 0 for SIFT.
    pub fn used_slopes(&self) -> SlopeGrid {
        match self.method {
            Method::Buff => self.slopes,
            Method::Sift => SlopeGrid::single(super::slope_grid::Slope::default()),
        }
    }

    /// Reads a parameter file.
    ///
    /// # Errors
    /// What is wrong and where, as TOML's reader says it, or the first parameter that makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let params: Self = toml::from_str(text).map_err(|e| e.to_string())?;
        params.validate().map_err(|e| e.to_string())?;
        Ok(params)
    }

    /// The parameter file's text, which [`Self::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        let body = toml::to_string(self).expect("parameters are plain values, which TOML can always hold");
        format!("# Burstscope detector parameters. Slopes are in pixels of the input image per frame.\n{body}")
    }
}

/// Octaves with a side of fewer pixels than this are not searched.
pub const MIN_OCTAVE_SIDE: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_valid_and_survive_a_file() {
        let params = DetectorParams::default();
        assert_eq!(params.validate(), Ok(()));
        assert_eq!(DetectorParams::from_toml(&params.to_toml()), Ok(params));
        assert_eq!(DetectorParams::from_toml(""), Ok(DetectorParams::default()));
    }

    #[test]
    fn a_file_may_fix_the_gate_and_the_frames() {
        let text =
            "noise_gate = 4.5\nframes = { start = 2, end = 9 }\n[slopes]\nv = { min = -1.0, max = 1.0, count = 3 }\n";
        let params = DetectorParams::from_toml(text).expect("valid");
        assert_eq!(params.noise_gate, NoiseGate::Factor(4.5));
        assert_eq!(params.used_frames(20), 2..9);
        assert!(params.slopes.is_plane());
        assert_eq!(DetectorParams::from_toml(&params.to_toml()), Ok(params));
    }

    #[test]
    fn a_misspelt_field_is_an_error_that_names_it() {
        let error = DetectorParams::from_toml("peak_treshold = 1.0").expect_err("misspelt");
        assert!(error.contains("peak_treshold"), "{error}");
    }

    #[test]
    fn nonsense_is_named_with_its_remedy() {
        let good = DetectorParams::default;
        let cases: [(DetectorParams, &str); 9] = [
            (DetectorParams { slopes: SlopeGrid::line(3.0..=-3.0, 7), ..good() }, "slopes-u"),
            (DetectorParams { slopes: SlopeGrid::line(0.0..=0.0, 2), ..good() }, "slopes-u"),
            (DetectorParams { slopes: SlopeGrid::plane(0.0..=1.0, 100, 0.0..=1.0, 100), ..good() }, "slopes-v"),
            (DetectorParams { frames: Some(FrameRange { start: 3, end: 3 }), ..good() }, "frames"),
            (DetectorParams { octaves: 0, ..good() }, "octaves"),
            (DetectorParams { levels: 11, ..good() }, "levels"),
            (DetectorParams { peak_threshold: f32::NAN, ..good() }, "peak-threshold"),
            (DetectorParams { edge_threshold: 0.5, ..good() }, "edge-threshold"),
            (DetectorParams { noise_gate: NoiseGate::Factor(-1.0), ..good() }, "noise-gate"),
        ];
        for (params, name) in cases {
            assert_eq!(params.validate().expect_err(name).parameter, name);
        }
        let one_frame = DetectorParams::default().validate_for(1, (100, 100)).expect_err("one frame");
        assert_eq!(one_frame.parameter, "frames");
        let too_fast = DetectorParams { slopes: SlopeGrid::line(-99.0..=99.0, 3), ..good() };
        assert_eq!(too_fast.validate_for(10, (100, 100)).expect_err("too fast").parameter, "slopes-u");
    }

    #[test]
    fn sift_uses_the_middle_frame_and_slope_zero() {
        let params = DetectorParams { method: Method::Sift, ..DetectorParams::default() };
        assert_eq!(params.used_frames(5), 2..3);
        assert_eq!(params.used_slopes().len(), 1);
        assert_eq!(params.validate_for(1, (64, 64)), Ok(()));
    }

    #[test]
    fn every_field_has_a_description() {
        let text =
            DetectorParams { frames: Some(FrameRange { start: 0, end: 1 }), ..DetectorParams::default() }.to_toml();
        let table: toml::Table = text.parse().expect("valid");
        for field in table.keys().filter(|k| *k != "slopes") {
            assert!(doc::ALL.iter().any(|d| d.name.replace('-', "_") == *field), "{field} has no description");
        }
    }
}
