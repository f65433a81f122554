//! The two bursts, A and B.

use serde::{Deserialize, Serialize};
use std::ops::{Index, IndexMut};

/// One of the two bursts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The first, on the left.
    #[default]
    A,
    /// The second, on the right.
    B,
}

impl Side {
    /// Both sides, from left to right.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];

    /// Name in the window: A or B.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
        }
    }

    /// The other side.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// One value for each of the two bursts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sides<T> {
    /// Value for the first burst.
    pub a: T,
    /// Value for the second burst.
    pub b: T,
}

impl<T> Sides<T> {
    /// Both values, A's first.
    pub fn both(&self) -> [&T; 2] {
        [&self.a, &self.b]
    }

    /// Exchanges the two values.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.a, &mut self.b);
    }
}

impl<T> Index<Side> for Sides<T> {
    type Output = T;

    fn index(&self, side: Side) -> &T {
        match side {
            Side::A => &self.a,
            Side::B => &self.b,
        }
    }
}

impl<T> IndexMut<Side> for Sides<T> {
    fn index_mut(&mut self, side: Side) -> &mut T {
        match side {
            Side::A => &mut self.a,
            Side::B => &mut self.b,
        }
    }
}
