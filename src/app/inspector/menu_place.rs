//! Target of a menu on a picture.

use crate::app::canvas::Readout;
use crate::app::project::side::Side;

/// Objects under the pointer when the menu was opened.
#[derive(Debug, Clone, Copy, Default)]
pub struct MenuPlace {
    pub(super) feature: Option<usize>,
    pub(super) matched: Option<usize>,
    pub(super) readout: Option<Readout>,
    /// Place at mid-burst of a burst, input pixels.
    pub(super) mid_burst: Option<(Side, [f32; 2])>,
}
