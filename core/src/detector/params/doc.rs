//! The parameters of the detector: their fields, their defaults, and the record of each.
//!
//! A new parameter is a field of [`DetectorParams`], its default and its record; tests fail for a field without a
//! record. Options, files, the window, checks and documents follow from these.

use super::choices::number_or_word;
use super::record::{Field, Param, ParamDoc, Stage, params};
use super::{
    Distinct, Flicker, FrameRange, Method, NoiseGate, NoiseModelKind, Rules, SearchSlopes, SlopeExtrema, SlopeGrid,
    Slopes, SlopesPart,
};
use serde::{Deserialize, Serialize};
use std::ops::Bound::{Excluded, Included, Unbounded};

/// Parameters of the detector. The same burst and the same parameters give bitwise equal results.
///
/// A search has a grid of slopes; [`SearchParams`], which ask for one, may leave them to be found from the burst.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)] // each is described by the record of its name
pub struct DetectorParams<S = SlopeGrid> {
    pub method: Method,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameRange>,
    pub octaves: u32,
    pub levels: u32,
    pub first_octave: i32,
    pub peak_threshold: f32,
    #[serde(with = "number_or_word")]
    pub noise_gate: NoiseGate,
    pub noise_model: NoiseModelKind,
    pub flicker: Flicker,
    pub edge_threshold: f32,
    pub search: SearchSlopes,
    pub slope_extrema: SlopeExtrema,
    #[serde(with = "number_or_word")]
    pub distinct: Distinct,
    pub distinct_scale: f32,
    pub rules: Rules,
    pub max_features: usize,
    pub max_orientations: usize,
    pub describe_scales: u32,
    pub slopes: S,
}

/// The parameters of a search as it is asked for. By default the slopes are found from each burst.
pub type SearchParams = DetectorParams<Slopes>;

impl<S: Default> Default for DetectorParams<S> {
    fn default() -> Self {
        Self {
            method: Method::Buff,
            frames: None,
            octaves: 6,
            // In the dark five levels with an edge threshold of 12 gave 5 to 7 % more inliers than the paper's four
            // with 10, for 4 % more time; six gave another 3 to 4 % for 7 to 12 % more time (docs/MEASUREMENTS.md).
            levels: 5,
            first_octave: 0,
            // An absolute threshold removes everything in the dark; the noise gate replaces it.
            peak_threshold: 0.0,
            noise_gate: NoiseGate::Auto,
            noise_model: NoiseModelKind::Local,
            flicker: Flicker::Auto,
            edge_threshold: 12.0,
            search: SearchSlopes::All,
            slope_extrema: SlopeExtrema::Each,
            distinct: Distinct::default(),
            distinct_scale: 1.75,
            rules: Rules::BURSTSCOPE,
            max_features: 0,
            max_orientations: 2,
            // Inliers in the dark: two scales 1.15–1.5 times those of one, three 1.0–1.1 of two (docs/MEASUREMENTS.md).
            describe_scales: 2,
            slopes: S::default(),
        }
    }
}

params! {
    SearchParams;

    METHOD: "method", "Method", "", "method";
    "The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame; merge aligns the frames to the middle one, averages them robustly and searches that image.",
    "Sift and merge are the baselines that the burst search has to beat.",
    Param::<SearchParams>::new("METHOD", Stage::Frames, |p| Field::Word(&mut p.method));

    SLOPES: "slopes", "Slopes", "", "auto-slopes";
    "auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a direction, on the line in it.",
    "Give ranges instead to search what you know, or to search the same slopes in every burst.",
    Param::<SearchParams>::new("auto", Stage::Search, |p| p.slopes.field(SlopesPart::Auto))
        .by_default("auto, unless ranges are given")
        .used_if(|p| p.method == Method::Buff);

    SLOPES_U: "slopes-u", "Slopes u", "px/frame", "slope-grid";
    "The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT.",
    "A wider range finds faster motion; a step much above 2σ/(N−1) misses features between slopes, a finer one only costs time.",
    Param::<SearchParams>::new("MIN:MAX:COUNT", Stage::Search, |p| p.slopes.field(SlopesPart::U))
        .by_default("found; 0 if only the other one is given")
        .used_if(|p| p.method == Method::Buff);

    SLOPES_V: "slopes-v", "Slopes v", "px/frame", "slope-grid";
    "The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT.",
    "More than one makes the search two-dimensional (BuFF 2D) and multiplies its time.",
    Param::<SearchParams>::new("MIN:MAX:COUNT", Stage::Search, |p| p.slopes.field(SlopesPart::V))
        .by_default("found; 0 if only the other one is given")
        .used_if(|p| p.method == Method::Buff);

    SLOPE_DIRECTION: "slope-direction", "Direction", "degrees", "direction";
    "Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point anywhere.",
    "Set it to the direction in which the camera moves; 90 searches vertical motion.",
    Param::<SearchParams>::new("DEGREES", Stage::Search, |p| p.slopes.field(SlopesPart::Direction))
        .within((Unbounded, Unbounded), "give degrees")
        .dragged(0.5, 1)
        .followed_by("°")
        .by_default("found; 0 if ranges are given")
        .used_if(|p| p.method == Method::Buff);

    FRAMES: "frames", "Frames used", "frames", "frame";
    "The frames A … B−1 that are searched; all of them if absent.",
    "More frames lower the noise, as long as the motion stays straight; features are reported at the middle of those used.",
    Param::<SearchParams>::new("A..B", Stage::Frames, |p| Field::Frames(&mut p.frames));

    OCTAVES: "octaves", "Octaves", "", "octave";
    "How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image gets too small.",
    "More octaves find larger blobs, at little cost.",
    Param::<SearchParams>::new("N", Stage::Search, |p| Field::U32(&mut p.octaves))
        .within((Included(1.0), Included(16.0)), "give 1 to 16");

    LEVELS: "levels", "Levels", "per octave", "level";
    "Scales per octave.",
    "More levels sample scale more finely and cost time in proportion.",
    Param::<SearchParams>::new("N", Stage::Response, |p| Field::U32(&mut p.levels))
        .within((Included(1.0), Included(10.0)), "give 1 to 10");

    FIRST_OCTAVE: "first-octave", "First octave", "", "octave";
    "The finest octave: 0 starts at the image's own resolution, −1 at the doubled image.",
    "−1 finds smaller features, of which noise has many, for about four times the time; 1 and above bin the frames, skip fine scales and take a fraction of the time.",
    Param::<SearchParams>::new("O", Stage::Response, |p| Field::I32(&mut p.first_octave))
        .within((Included(-1.0), Included(8.0)), "give -1 to 8");

    PEAK_THRESHOLD: "peak-threshold", "Peak threshold", "of full scale", "peak-threshold";
    "Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate.",
    "Raise it to keep only features of higher contrast; it knows nothing of the noise and removes everything in the dark.",
    Param::<SearchParams>::new("T", Stage::Search, |p| Field::F32(&mut p.peak_threshold))
        .within((Included(0.0), Unbounded), "give 0 or more, as a fraction of full scale")
        .dragged(0.0001, 5);

    NOISE_GATE: "noise-gate", "Noise gate", "times the noise", "noise-gate";
    "Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and level; auto, matching and strict derive it from the size of the search, 0 switches it off.",
    "Raise it to eliminate more noise; lower it to see fainter features among more false ones. On noise alone strict gives at most one false feature a megapixel, auto about eight and matching, for COLMAP, about three hundred.",
    Param::<SearchParams>::new("K", Stage::Search, |p| Field::Gate(&mut p.noise_gate))
        .within((Included(0.0), Unbounded), "give auto, matching, strict, or 0 or more standard deviations")
        .dragged(0.02, 2)
        .followed_by(" σ");

    NOISE_MODEL: "noise-model", "Noise model", "", "noise";
    "What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard deviation for all.",
    "Local keeps the gate's promise for noise as cameras and files make it; white searches the frames as they are, for comparison.",
    Param::<SearchParams>::new("MODEL", Stage::Search, |p| Field::Word(&mut p.noise_model));

    FLICKER: "flicker", "Flicker", "", "flicker";
    "Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise model local finds that they flicker; off takes them as they are.",
    "Switch it off where the light itself changes and should stay in the pictures.",
    Param::<SearchParams>::new("WHAT", Stage::Search, |p| Field::Word(&mut p.flicker));

    EDGE_THRESHOLD: "edge-threshold", "Edge threshold", "", "edge-threshold";
    "Max ratio of the principal curvatures of D.",
    "Raise it to keep more features on edges, which are poorly localised along the edge.",
    Param::<SearchParams>::new("R", Stage::Search, |p| Field::F32(&mut p.edge_threshold))
        .within((Included(1.0), Unbounded), "give 1 or more (10 is usual)")
        .dragged(0.1, 2);

    SEARCH: "search", "Search", "", "field";
    "Which slopes are searched at a place: all, or those within two steps of the motions that the field of motion finds around it (of the whole picture where its motion is unknown).",
    "Field saves time where few motions fill a wide plane of slopes; it finds nothing that moves otherwise than the field says.",
    Param::<SearchParams>::new("SLOPES", Stage::Search, |p| Field::Word(&mut p.search))
        .used_if(|p| p.method == Method::Buff);

    SLOPE_EXTREMA: "slope-extrema", "Slope extrema", "", "joint-extremum";
    "Which samples are candidates: those that stand out in place and scale at each slope for itself, or jointly over the neighbouring slopes too.",
    "Each finds more in noise and leaves it to distinct keypoints to choose the slope; joint is the rule of the paper and of LiFF.",
    Param::<SearchParams>::new("WHICH", Stage::Search, |p| Field::Word(&mut p.slope_extrema))
        .used_if(|p| p.method == Method::Buff);

    DISTINCT: "distinct", "Distinct", "σ", "distinct";
    "One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the stronger one stays; off keeps all.",
    "Raise it to thin out keypoints that share a blob, which make matches ambiguous; lower it to keep neighbours in fine texture.",
    Param::<SearchParams>::new("RADIUS", Stage::Search, |p| Field::Distinct(&mut p.distinct))
        .within((Excluded(0.0), Included(10.0)), "give off, or a radius above 0 and up to 10 σ")
        .dragged(0.01, 2)
        .followed_by(" σ")
        .used_if(|p| p.method == Method::Buff);

    DISTINCT_SCALE: "distinct-scale", "Distinct scale", "", "distinct";
    "Max ratio of the scales of two keypoints that count as the same blob.",
    "Raise it to let a keypoint remove others of more different sizes at its place.",
    Param::<SearchParams>::new("RATIO", Stage::Search, |p| Field::F32(&mut p.distinct_scale))
        .within((Excluded(1.0), Included(8.0)), "give more than 1 and up to 8")
        .dragged(0.01, 2)
        .used_if(|p| p.method == Method::Buff);

    RULES: "rules", "Rules", "", "rules";
    "Whose detector it is: Burstscope's own; the paper's BuFF, joint extrema above a peak threshold with 4 levels, edge threshold 10 and one descriptor; LiFF; or VLFeat's SIFT. A choice sets levels, thresholds, gate, noise, extrema, distinct, orientations and describe scales; those given besides count.",
    "Burstscope's find most in the dark; the others show what the published methods find, down to how their codes shift frames, end kernels and place features.",
    Param::<SearchParams>::new("RULES", Stage::Stack, |p| Field::Word(p));

    MAX_FEATURES: "max-features", "Max features", "features", "feature";
    "Keep only this many features, the strongest by response times the square root of the signal-to-noise ratio; 0 keeps all.",
    "Lower it to keep only the most reliable.",
    Param::<SearchParams>::new("N", Stage::Description, |p| Field::Usize(&mut p.max_features))
        .dragged(5.0, 0)
        .zero_is("all");

    MAX_ORIENTATIONS: "max-orientations", "Max orientations", "per keypoint", "orientation";
    "How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own.",
    "Raise it to match ambiguous places under rotation (VLFeat and LiFF use 4), for more features at one place.",
    Param::<SearchParams>::new("N", Stage::Description, |p| Field::Usize(&mut p.max_orientations))
        .within((Included(1.0), Included(4.0)), "give 1 to 4")
        .dragged(0.02, 0);

    DESCRIBE_SCALES: "describe-scales", "Describe scales", "", "descriptor";
    "How many scales a descriptor is pooled over: the feature's own, and coarser ones by steps of 1.75.",
    "Pooled descriptors match more in the dark; 1 is what SIFT and the published codes do.",
    Param::<SearchParams>::new("N", Stage::Description, |p| Field::U32(&mut p.describe_scales))
        .within((Included(1.0), Included(4.0)), "give 1 to 4")
        .dragged(0.02, 0);
}
