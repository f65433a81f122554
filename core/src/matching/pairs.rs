//! Selection of the pairs of images that are matched.

use std::fmt;
use std::str::FromStr;

/// A choice of pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PairSelection {
    /// Each image with every other one: N·(N − 1)/2 pairs.
    #[default]
    All,
    /// Each image with the next few after it, for a camera path that does not return: about N times as many pairs.
    Sequential(usize),
}

impl PairSelection {
    /// The pairs of `count` images, the earlier one first, in order.
    pub fn pairs(self, count: usize) -> Vec<(usize, usize)> {
        let reach = match self {
            Self::All => count,
            Self::Sequential(reach) => reach,
        };
        (0..count)
            .flat_map(|a| (a + 1..count.min(a.saturating_add(reach).saturating_add(1))).map(move |b| (a, b)))
            .collect()
    }
}

impl fmt::Display for PairSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Sequential(reach) => write!(f, "sequential:{reach}"),
        }
    }
}

impl FromStr for PairSelection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let reach = text.strip_prefix("sequential:").and_then(|reach| reach.parse().ok());
        match (text, reach) {
            ("all", _) => Ok(Self::All),
            (_, Some(reach)) if reach > 0 => Ok(Self::Sequential(reach)),
            _ => Err(format!("'{text}' is neither 'all' nor 'sequential:K' with K of 1 or more, such as sequential:5")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_in_order_and_each_is_there_once() {
        assert_eq!(PairSelection::All.pairs(4), [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]);
        assert_eq!(PairSelection::Sequential(2).pairs(4), [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]);
        assert_eq!(PairSelection::Sequential(usize::MAX).pairs(3).len(), 3);
        assert!(PairSelection::All.pairs(1).is_empty() && PairSelection::Sequential(3).pairs(0).is_empty());
    }

    #[test]
    fn choices_are_read_as_they_are_shown() {
        for choice in [PairSelection::All, PairSelection::Sequential(7)] {
            assert_eq!(choice.to_string().parse(), Ok(choice));
        }
        for bad in ["", "some", "sequential", "sequential:0", "sequential:-1", "sequential:x"] {
            assert!(bad.parse::<PairSelection>().is_err(), "{bad}");
        }
    }
}
