//! Sort order of a table.

use serde::{Deserialize, Serialize};

/// Sort order: a column of type `C` and a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, bound(deserialize = "C: Default + Deserialize<'de>"))]
pub struct Order<C> {
    /// The column.
    pub column: C,
    /// Whether the largest value comes first.
    pub descending: bool,
}

impl<C: PartialEq> Order<C> {
    /// Order after a click on the heading of `column`: ascending by it, or reversed if the table is sorted by it
    /// already.
    #[must_use]
    pub fn clicked(self, column: C) -> Self {
        Self { descending: self.column == column && !self.descending, column }
    }
}
