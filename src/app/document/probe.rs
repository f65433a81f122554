//! The probe as it is set, and the set-up of camera and scene as the user typed it.

use crate::app::{document::Side, view::KnownOfFeature};
use crate::detector::{Feature, Slope};
use crate::inspect::{place::Judged, slopes::SetUp};
use crate::requests::{BurstSource, ProbeQuestion};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Probe {
    pub side: Side,
    pub is_open: bool,
    pub follows: bool,
    pub question: Option<ProbeQuestion>,
    /// Scale σ near which candidates come first, input pixels: that of the DoG in view; `None` for all alike.
    pub near_sigma: Option<f32>,
    /// Slope by which candidates come first: that of the picture in view; `None` for a picture of no slope.
    pub in_view: Option<Slope>,
}

impl Probe {
    pub fn is_on(&self) -> bool {
        self.follows || self.question.is_some()
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinnedPlace {
    pub name: String,
    /// Pixels at mid-burst.
    pub at: [f32; 2],
    /// The burst, or the burst that a copy is made of.
    pub of: BurstSource,
}

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SetUpState {
    pub values: SetUp,
    pub reads_depths: bool,
    pub is_open: bool,
}

impl SetUpState {
    pub fn depths_by(&self) -> Option<&SetUp> {
        (self.reads_depths && self.values.check().is_ok()).then_some(&self.values)
    }

    pub fn known<'a>(&self, feature: &Feature, judged: Option<&'a Judged>) -> KnownOfFeature<'a> {
        let (motion, sigma) = feature.motion();
        KnownOfFeature { judged, depth_m: self.depths_by().and_then(|values| values.depth_with_error(motion, sigma)) }
    }
}
