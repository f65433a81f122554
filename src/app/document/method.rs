//! Methods that are compared: the same detector on different inputs made from a burst; and their comparison as it is
//! set.

use crate::app::{defaults::with_defaults, words::choices};
use crate::detector::{DetectorParams, Method, SlopeAxis, SlopeGrid};
use crate::evaluate::{BurstMethod, Searches};
use crate::study::SameFalseRate;
use serde::{Deserialize, Serialize};

choices! {
    #[derive(PartialOrd, Ord)]
    MethodId {
        Sift: "SIFT, one frame", "SIFT on the middle frame only, without the rest of the burst";
        Merge: "SIFT, merged", "SIFT on the frames aligned tile by tile and merged robustly into one";
        Buff1d: "BuFF 1D", "Burst features, joint over place, scale and slope, on one line of slopes";
        Buff2d: "BuFF 2D", "Burst features, joint over place, scale and slope, on a plane of slopes";
        Gold: "Gold standard", "SIFT on an image of the same view that was taken with enough light";
    }
}

/// Range (±, pixels per frame) and number of slopes of an axis where the edited grid has none to take over.
const USUAL: (f32, usize) = (3.0, 7);

impl MethodId {
    pub fn of_search(params: &DetectorParams) -> Self {
        match params.method {
            Method::Sift => Self::Sift,
            Method::Merge => Self::Merge,
            Method::Buff if params.slopes.is_plane() => Self::Buff2d,
            Method::Buff => Self::Buff1d,
        }
    }

    pub fn of_studies(self) -> BurstMethod {
        match self {
            Self::Sift => BurstMethod::SiftFrame,
            Self::Merge => BurstMethod::SiftMerge,
            Self::Buff1d => BurstMethod::Buff1d,
            Self::Buff2d => BurstMethod::Buff2d,
            Self::Gold => BurstMethod::Gold,
        }
    }

    pub fn label(self) -> &'static str {
        self.words()[0]
    }

    /// Everything but the method and, for BuFF, the shape of the grid of slopes stays.
    pub fn params(self, edited: &DetectorParams) -> DetectorParams {
        let (slopes_1d, slopes_2d) = (line_of(edited.slopes), plane_of(edited.slopes));
        let searches = Searches { detector: edited.clone(), slopes_1d, slopes_2d, direction_deg: None };
        let mut params = searches.params(self.of_studies()).at_given();
        if self == Self::Gold {
            params.frames = None;
        }
        params
    }
}

/// A single slope gets the usual range.
fn line_of(grid: SlopeGrid) -> SlopeGrid {
    match grid {
        plane if plane.is_plane() => SlopeGrid { v: SlopeAxis::ZERO, ..plane },
        line if line.len() > 1 => line,
        one => SlopeGrid { u: SlopeAxis::new(-USUAL.0..=USUAL.0, USUAL.1), v: SlopeAxis::ZERO, ..one },
    }
}

/// An axis with a single slope gets a range around it, as fine as the other axis, of at most the usual count.
pub fn plane_of(grid: SlopeGrid) -> SlopeGrid {
    let usual = SlopeAxis::new(-USUAL.0..=USUAL.0, USUAL.1);
    let around = |middle: f32, other: &SlopeAxis| {
        let steps = other.count.min(USUAL.1) / 2;
        let reach = steps as f32 * other.step();
        SlopeAxis::new(middle - reach..=middle + reach, 2 * steps + 1)
    };
    let (u, v) = match (grid.u.count > 1, grid.v.count > 1) {
        (true, true) => (grid.u, grid.v),
        (true, false) => (grid.u, around(grid.v.min, &grid.u)),
        (false, true) => (around(grid.u.min, &grid.v), grid.v),
        (false, false) => (around(grid.u.min, &usual), around(grid.v.min, &usual)),
    };
    SlopeGrid { u, v, ..grid }
}

with_defaults! {
    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct CompareLook {
        pub methods: Vec<MethodId> = MethodId::ALL.to_vec(),
        /// Peak thresholds of the methods, from charts; each method has that of the search where there is none.
        pub same_false_rate: Option<SameFalseRate>,
    }
}

impl CompareLook {
    /// `params` of a method with its peak threshold of the same false rate, if charts gave it one.
    pub(in crate::app) fn at_same_false_rate(&self, method: MethodId, params: DetectorParams) -> DetectorParams {
        let threshold = self.same_false_rate.as_ref().and_then(|rate| rate.of(method.of_studies()));
        DetectorParams { peak_threshold: threshold.unwrap_or(params.peak_threshold), ..params }
    }

    pub fn shows(&self, method: MethodId) -> bool {
        self.methods.contains(&method)
    }

    pub fn show(&mut self, method: MethodId, shown: bool) {
        self.methods.retain(|m| *m != method);
        self.methods.extend(shown.then_some(method));
        self.methods.sort_unstable();
    }

    /// Copy with the methods sorted, each once: a file may contain any values.
    #[must_use]
    pub fn sanitised(mut self) -> Self {
        self.methods.sort_unstable();
        self.methods.dedup();
        self
    }
}
