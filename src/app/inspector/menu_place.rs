//! What a menu on a picture is about.

use crate::app::canvas::Readout;

/// What was under the pointer when the menu was opened.
#[derive(Debug, Clone, Copy, Default)]
pub struct MenuPlace {
    pub(super) feature: Option<usize>,
    pub(super) matched: Option<usize>,
    pub(super) readout: Option<Readout>,
    /// The place at mid-burst.
    pub(super) mid_burst: Option<[f32; 2]>,
}
