//! The compared methods: SIFT on one frame, two merges or a sharp image; BuFF over a line, a plane or slopes found.

use burstscope_core::detect::{Searched, search};
use burstscope_core::detector::{DetectorParams, Method, SearchParams, SlopeAxis, SlopeGrid, Slopes};
use burstscope_core::export::sheet::{BLUE, Colour, Dashes, GREEN, RED, SOLID};
use burstscope_core::{baseline::plain_mean, burst::Burst, error::Result, monitor::Monitor};
use serde::{Deserialize, Serialize};

/// Method from the frames of a view to features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BurstMethod {
    /// SIFT on the middle frame.
    SiftFrame,
    /// SIFT on the plain mean of all frames.
    SiftMean,
    /// SIFT on the aligned and merged burst.
    SiftMerge,
    /// The burst search over a line of slopes.
    #[serde(rename = "buff-1d")]
    Buff1d,
    /// The burst search over a plane of slopes.
    #[serde(rename = "buff-2d")]
    Buff2d,
    /// The burst search over the slopes that are found from each burst.
    BuffAuto,
    /// SIFT on a sharp image of the same view, the gold standard.
    Gold,
}

impl BurstMethod {
    /// All methods that take a burst, in the order of tables.
    pub const ALL: [Self; 6] =
        [Self::SiftFrame, Self::SiftMean, Self::SiftMerge, Self::Buff1d, Self::Buff2d, Self::BuffAuto];
    /// All of these but those that find slopes by themselves, in the order of tables.
    pub const WITH_GIVEN_SLOPES: [Self; 5] =
        [Self::SiftFrame, Self::SiftMean, Self::SiftMerge, Self::Buff1d, Self::Buff2d];

    /// Name on the command line, label, and colour and dashes of the line.
    const fn row(self) -> (&'static str, &'static str, (Colour, Dashes)) {
        match self {
            // The palette of M. Okabe and K. Ito, which colour-blind readers can tell apart; dashes differ too.
            Self::SiftFrame => ("sift-frame", "SIFT, one frame", ([0x66, 0x66, 0x66], [1.5, 4.0, 0.0, 0.0])),
            Self::SiftMean => ("sift-mean", "SIFT, plain mean", (RED, [9.0, 3.0, 2.0, 3.0])),
            Self::SiftMerge => ("sift-merge", "SIFT, merge", ([0xcc, 0x79, 0xa7], [5.0, 3.0, 0.0, 0.0])),
            Self::Buff1d => ("buff-1d", "BuFF 1D", (BLUE, SOLID)),
            Self::Buff2d => ("buff-2d", "BuFF 2D", (GREEN, [7.0, 4.0, 0.0, 0.0])),
            Self::BuffAuto => ("buff-auto", "BuFF, slopes found", ([0x5b, 0x4b, 0xb5], [10.0, 3.0, 0.0, 0.0])),
            Self::Gold => ("gold", "gold standard", ([0xe6, 0x9f, 0x00], [2.0, 2.0, 0.0, 0.0])),
        }
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Name in a table or figure.
    pub fn label(self) -> &'static str {
        self.row().1
    }

    /// Colour and dashes of its line.
    pub fn line(self) -> (Colour, Dashes) {
        self.row().2
    }
}

impl std::str::FromStr for BurstMethod {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|method| method.name() == text).ok_or_else(|| {
            format!("'{text}' is not a method; give sift-frame, sift-mean, sift-merge, buff-1d, buff-2d or buff-auto")
        })
    }
}

/// The slopes of BuFF 1D and 2D: of a plane its u axis and the plane; of a line the line, and its axis on both axes.
pub fn slopes_of(slopes: SlopeGrid) -> (SlopeGrid, SlopeGrid) {
    if slopes.is_plane() {
        return (SlopeGrid { v: SlopeAxis::ZERO, ..slopes }, slopes);
    }
    let axis = if slopes.u.count > 1 { slopes.u } else { slopes.v };
    (slopes, SlopeGrid { u: axis, v: axis, ..slopes })
}

/// Parameters of the methods' searches.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Searches {
    /// The detector's parameters, for all methods; method and slopes are set by each of them.
    pub detector: DetectorParams,
    /// Slopes of BuFF 1D.
    pub slopes_1d: SlopeGrid,
    /// Slopes of BuFF 2D.
    pub slopes_2d: SlopeGrid,
    /// Direction in which slopes are found, degrees from +u towards +v; `None`: anywhere in the plane.
    #[serde(skip)]
    pub direction_deg: Option<f32>,
}

impl Default for Searches {
    /// 13 slopes in 1D and 7×7 in 2D over the ±3 px/frame of the published charts.
    fn default() -> Self {
        Self {
            detector: DetectorParams::default(),
            slopes_1d: SlopeGrid::line(-3.0..=3.0, 13),
            slopes_2d: SlopeGrid::plane(-3.0..=3.0, 7, -3.0..=3.0, 7),
            direction_deg: None,
        }
    }
}

impl Searches {
    /// Searches of charts: a `given` plane counts as in [`slopes_of`], a line is BuFF 1D's; the rest is as published.
    pub fn of_charts(detector: DetectorParams, given: Option<SlopeGrid>) -> Self {
        let default = Self::default();
        let (slopes_1d, slopes_2d) = match given {
            Some(plane) if plane.is_plane() => slopes_of(plane),
            Some(line) => (line, default.slopes_2d),
            None => (default.slopes_1d, default.slopes_2d),
        };
        Self { detector, slopes_1d, slopes_2d, ..default }
    }

    /// The search parameters of `method`.
    pub fn params(&self, method: BurstMethod) -> SearchParams {
        let given = self.detector.slopes.into();
        let (method, slopes) = match method {
            BurstMethod::SiftFrame | BurstMethod::SiftMean | BurstMethod::Gold => (Method::Sift, given),
            BurstMethod::SiftMerge => (Method::Merge, given),
            BurstMethod::Buff1d => (Method::Buff, self.slopes_1d.into()),
            BurstMethod::Buff2d => (Method::Buff, self.slopes_2d.into()),
            BurstMethod::BuffAuto => (Method::Buff, Slopes::Auto { direction_deg: self.direction_deg }),
        };
        SearchParams { method, ..self.detector.clone().with_slopes(slopes) }
    }

    /// Runs `method` on `burst`.
    ///
    /// # Errors
    /// Parameters that make no sense, or cancellation.
    pub fn search(&self, method: BurstMethod, burst: &Burst, monitor: &Monitor) -> Result<Searched> {
        let (burst, params) = self.input(method, burst, monitor)?;
        search(&burst, &params, monitor)
    }

    /// The burst that `method` searches in place of `burst`, and the parameters; errors as of [`Self::search`].
    pub fn input(&self, method: BurstMethod, burst: &Burst, monitor: &Monitor) -> Result<(Burst, SearchParams)> {
        let params = self.params(method);
        if method != BurstMethod::SiftMean {
            return Ok((burst.clone(), params));
        }
        // SIFT uses one frame; the mean is of all frames that the burst search would use.
        params.at_given().validate_for(&burst.positions, burst.size())?;
        let all = SearchParams { method: Method::Buff, ..params.clone() }.used_frames(burst.len());
        let positions = burst.positions.part(all.clone());
        let used = Burst { frames: burst.frames[all].to_vec(), positions, ..burst.clone() };
        Ok((plain_mean(&used, monitor)?, SearchParams { frames: None, ..params }))
    }
}
