//! By which column a table is sorted.

use serde::{Deserialize, Serialize};

/// A column of type `C`, and which way round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, bound(deserialize = "C: Default + Deserialize<'de>"))]
pub struct Order<C> {
    /// The column.
    pub column: C,
    /// Largest first.
    pub descending: bool,
}

impl<C: PartialEq> Order<C> {
    /// What a click on `column`'s heading does: sort by it, or turn the order round.
    #[must_use]
    pub fn clicked(self, column: C) -> Self {
        Self { descending: self.column == column && !self.descending, column }
    }
}
