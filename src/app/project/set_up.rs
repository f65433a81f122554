//! Set-up of camera and scene: what the user typed, and slopes read as depths by it.

use super::Model;
use crate::app::view::Known;
use crate::detector::{DetectorParams, Feature, SearchParams, SlopeChoice};
use crate::inspect::set_up::SetUp;
use crate::inspect::verdict::Judged;
use serde::{Deserialize, Serialize};

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

    pub fn known<'a>(&self, feature: &Feature, judged: Option<&'a Judged>) -> Known<'a> {
        let (motion, sigma) = feature.motion();
        Known { judged, depth_m: self.depths_by().and_then(|values| values.depth_with_error(motion, sigma)) }
    }
}

impl Model {
    pub fn apply_set_up(&mut self) {
        let slopes = self.document.set_up.values.slopes(&self.used_positions(), &self.document.params);
        if let Ok((slopes, options)) = slopes.map(|slopes| (slopes.grid, slopes.options())) {
            let detector = DetectorParams { slopes, ..self.document.params.clone() };
            self.document.set_search(SearchParams { detector, slopes: SlopeChoice::Given });
            self.messages.note(format!("Set {options}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{Moves, Slope};

    #[test]
    fn only_a_sound_set_up_gives_depths() {
        let state = SetUpState::default();
        let alone = Feature { slope: Slope::new(-2.5, 0.0), slope_sigma: 0.25, ..Feature::default() };
        assert_eq!(state.known(&alone, None).depth_m, None);
        let read = SetUpState { reads_depths: true, ..state };
        assert_eq!(read.known(&alone, None).depth_m, Some([8.0, 0.8]), "by itself");
        let field = Slope::new(-5.0, 0.0);
        let edge = Feature { field, slope_sigma: 1.0, field_sigma: 0.25, moves: Moves::Edge, ..alone };
        assert_eq!(read.known(&edge, None).depth_m, Some([4.0, 0.2]), "as its surroundings");
        let typed = SetUpState { values: SetUp { speed_m_s: -1.0, ..SetUp::default() }, ..read };
        assert_eq!(typed.depths_by(), None);
    }
}
