//! Descriptions of all parameters, in the words that help pages, tooltips and error messages show.

/// Description of one parameter, in the words that help pages, tooltips and error messages show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParamDoc {
    /// Name on the command line, without dashes in front; the file's field has `_` for `-`.
    pub name: &'static str,
    /// Name in the window, in sentence case.
    pub label: &'static str,
    /// Unit of its value; empty where it has none.
    pub unit: &'static str,
    /// Meaning, as a sentence.
    pub meaning: &'static str,
    /// Effect of raising (or changing) it.
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

/// Describes one parameter: its constant's name, then the fields of [`ParamDoc`] (which must be in scope) in order.
macro_rules! param_doc {
    ($id:ident, $name:literal, $label:literal, $unit:literal, $meaning:literal, $effect:literal) => {
        #[doc = concat!($meaning, " ", $effect)]
        pub const $id: ParamDoc =
            ParamDoc { name: $name, label: $label, unit: $unit, meaning: $meaning, effect: $effect };
    };
}
pub(crate) use param_doc;

param_doc!(
    METHOD,
    "method",
    "Method",
    "",
    "The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame; merge aligns the frames to the middle one, averages them robustly and searches that image.",
    "Sift and merge are the baselines that the burst search has to beat."
);
param_doc!(
    SLOPES_U,
    "slopes-u",
    "Slopes u",
    "px/frame",
    "The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT.",
    "A wider range finds faster motion; a step much above 2σ/(N−1) misses features between slopes, a finer one only costs time."
);
param_doc!(
    SLOPES_V,
    "slopes-v",
    "Slopes v",
    "px/frame",
    "The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT.",
    "More than one makes the search two-dimensional (BuFF 2D) and multiplies its time."
);
param_doc!(
    SLOPE_DIRECTION,
    "slope-direction",
    "Direction",
    "degrees",
    "Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point anywhere.",
    "Set it to the direction in which the camera moves; 90 searches vertical motion."
);
param_doc!(
    SLOPES,
    "slopes",
    "Slopes",
    "",
    "auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a direction, on the line in it.",
    "Give ranges instead to search what you know, or to search the same slopes in every burst."
);
param_doc!(
    FRAMES,
    "frames",
    "Frames used",
    "frames",
    "The frames A … B−1 that are searched; all of them if absent.",
    "More frames lower the noise, as long as the motion stays straight; features are reported at the middle of those used."
);
param_doc!(
    OCTAVES,
    "octaves",
    "Octaves",
    "",
    "How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image gets too small.",
    "More octaves find larger blobs, at little cost."
);
param_doc!(
    LEVELS,
    "levels",
    "Levels",
    "per octave",
    "Scales per octave.",
    "More levels sample scale more finely and cost time in proportion."
);
param_doc!(
    FIRST_OCTAVE,
    "first-octave",
    "First octave",
    "",
    "The finest octave: 0 starts at the image's own resolution, −1 at the doubled image.",
    "−1 finds smaller features, of which noise has many, for about four times the time; 1 and above skip fine scales."
);
param_doc!(
    PEAK_THRESHOLD,
    "peak-threshold",
    "Peak threshold",
    "of full scale",
    "Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate.",
    "Raise it to keep only features of higher contrast; it knows nothing of the noise and removes everything in the dark."
);
param_doc!(
    NOISE_GATE,
    "noise-gate",
    "Noise gate",
    "σ of the noise in D",
    "Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and level; strict and auto derive it from the size of the search, 0 switches it off.",
    "Raise it to eliminate more noise; lower it to see fainter features among more false ones. Strict gives at most one false feature a megapixel on noise alone; auto, for matching, lets through more of both."
);
param_doc!(
    NOISE_MODEL,
    "noise-model",
    "Noise model",
    "",
    "What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard deviation for all.",
    "Local keeps the gate's promise for noise as cameras and files make it; white searches the frames as they are, for comparison."
);
param_doc!(
    FLICKER,
    "flicker",
    "Flicker",
    "",
    "Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise model local finds that they flicker; off takes them as they are.",
    "Switch it off where the light itself changes and should stay in the pictures."
);
param_doc!(
    EDGE_THRESHOLD,
    "edge-threshold",
    "Edge threshold",
    "",
    "Max ratio of the principal curvatures of D.",
    "Raise it to keep more features on edges, which are poorly localised along the edge."
);
param_doc!(
    SLOPE_EXTREMA,
    "slope-extrema",
    "Slope extrema",
    "",
    "Which samples are candidates: those that stand out in place and scale at each slope for itself, or jointly over the neighbouring slopes too.",
    "Each finds more in noise and leaves it to distinct keypoints to choose the slope; joint is the rule of the paper and of LiFF."
);
param_doc!(
    DISTINCT,
    "distinct",
    "Distinct",
    "σ",
    "One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the stronger one stays; off keeps all.",
    "Raise it to thin out keypoints that share a blob, which make matches ambiguous; lower it to keep neighbours in fine texture."
);
param_doc!(
    DISTINCT_SCALE,
    "distinct-scale",
    "Distinct scale",
    "",
    "Max ratio of the scales of two keypoints that count as the same blob.",
    "Raise it to let a keypoint remove others of more different sizes at its place."
);
param_doc!(
    DESCRIBE_SLOPE,
    "describe-slope",
    "Describe slope",
    "",
    "The slope at which orientation and descriptor are taken: refined, the feature's own, or grid, the nearest one that was searched.",
    "Refined keeps features between two slopes of the grid sharp, so that they match; grid is what the published codes do."
);
param_doc!(
    SLOPE_NEIGHBOURS,
    "slope-neighbours",
    "Slope neighbours",
    "",
    "The slopes that a joint extremum must beat: adjacent ones of the grid, or all.",
    "All keeps at most one slope per place and scale and needs more memory; adjacent lets two motions share a place."
);
param_doc!(
    INTERPOLATION,
    "interpolation",
    "Interpolation",
    "",
    "How frames are sampled between pixels when they are shifted: linear, nearest or truncated.",
    "Linear is the most accurate; nearest reproduces the authors' code, and truncated LiFF, which also counts what lies up to 1.5 px before the first column and row."
);
param_doc!(
    KERNEL_CUT,
    "kernel-cut",
    "Kernel cut",
    "σ",
    "Where the kernel of each blur from level to level ends, in its standard deviations.",
    "4 is exact to a thousandth; what a level sums up ends at 4.5 of its own in any case. 2 reproduces the authors' code, which misses some sizes of blobs by it."
);
param_doc!(
    LOCALISATION,
    "localisation",
    "Localisation",
    "",
    "How the place, scale and slope between the samples are found: continuous or quadratic.",
    "Continuous is several times as exact: a small filter says where and how fast, D between its levels how large; quadratic reproduces VLFeat and LiFF."
);
param_doc!(
    MAX_FEATURES,
    "max-features",
    "Max features",
    "features",
    "Keep only this many features, the strongest by response times the square root of the signal-to-noise ratio; 0 keeps all.",
    "Lower it to keep only the most reliable."
);
param_doc!(
    MAX_ORIENTATIONS,
    "max-orientations",
    "Max orientations",
    "per keypoint",
    "How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own.",
    "Raise it to match ambiguous places under rotation (VLFeat and LiFF use 4), for more features at one place."
);

/// All parameters, in the order in which they are shown.
pub const ALL: [ParamDoc; 24] = [
    METHOD,
    SLOPES,
    SLOPES_U,
    SLOPES_V,
    SLOPE_DIRECTION,
    FRAMES,
    OCTAVES,
    LEVELS,
    FIRST_OCTAVE,
    PEAK_THRESHOLD,
    NOISE_GATE,
    NOISE_MODEL,
    FLICKER,
    EDGE_THRESHOLD,
    SLOPE_EXTREMA,
    SLOPE_NEIGHBOURS,
    DISTINCT,
    DISTINCT_SCALE,
    INTERPOLATION,
    KERNEL_CUT,
    LOCALISATION,
    MAX_FEATURES,
    MAX_ORIENTATIONS,
    DESCRIBE_SLOPE,
];
