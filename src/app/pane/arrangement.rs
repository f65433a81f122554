//! Arrangement of panes in nested rows, columns and tabs, as plain values; [`super::tiles`] makes widgets of them.

use super::PaneId;
use serde::{Deserialize, Serialize};

/// Maximum number of open panes: more than the largest preset needs, and few enough that each can still be seen.
pub const MAX_PANES: usize = 16;

/// Maximum depth of an arrangement; those read from files are cut off there.
const MAX_DEPTH: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    Right,
    Down,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    pub share: f32,
    pub inner: Arrangement,
}

impl Part {
    pub(super) fn even(inner: Arrangement) -> Self {
        Self { share: 1.0, inner }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Arrangement {
    Pane(PaneId),
    Row(Vec<Part>),
    Column(Vec<Part>),
    Tabs { parts: Vec<Arrangement>, active: usize },
}

impl Arrangement {
    /// Rows of panes below one another, all panes of one size where the rows have equally many; at least one pane.
    pub fn rows(rows: &[Vec<PaneId>]) -> Self {
        let row = |row: &Vec<PaneId>| match row.as_slice() {
            [one] => Self::Pane(*one),
            many => Self::Row(many.iter().map(|id| Part::even(Self::Pane(*id))).collect()),
        };
        match rows {
            [one] => row(one),
            many => Self::Column(many.iter().map(|r| Part::even(row(r))).collect()),
        }
    }

    pub fn panes(&self) -> Vec<PaneId> {
        match self {
            Self::Pane(id) => vec![*id],
            Self::Row(parts) | Self::Column(parts) => parts.iter().flat_map(|part| part.inner.panes()).collect(),
            Self::Tabs { parts, .. } => parts.iter().flat_map(Self::panes).collect(),
        }
    }

    pub fn in_rows(&self) -> Vec<Vec<PaneId>> {
        match self {
            Self::Column(parts) => parts.iter().map(|part| part.inner.panes()).collect(),
            _ => vec![self.panes()],
        }
    }

    /// Puts `new` beside `id`, which gives half of its space to it. Returns whether `id` was found.
    pub fn split(&mut self, id: PaneId, direction: Direction, new: PaneId) -> bool {
        let along = |arrangement: &Self| match direction {
            Direction::Right => matches!(arrangement, Self::Row(_)),
            Direction::Down => matches!(arrangement, Self::Column(_)),
        };
        // In a row, a pane that is split to the right becomes two parts of that row; likewise downwards in a column.
        if along(self)
            && let Self::Row(parts) | Self::Column(parts) = self
            && let Some(place) = parts.iter().position(|part| part.inner == Self::Pane(id))
        {
            parts[place].share *= 0.5;
            let share = parts[place].share;
            parts.insert(place + 1, Part { share, inner: Self::Pane(new) });
            return true;
        }
        match self {
            Self::Pane(own) if *own == id => {
                let parts = [id, new].map(|id| Part::even(Self::Pane(id))).to_vec();
                *self = if direction == Direction::Right { Self::Row(parts) } else { Self::Column(parts) };
                true
            }
            Self::Pane(_) => false,
            Self::Row(parts) | Self::Column(parts) => parts.iter_mut().any(|part| part.inner.split(id, direction, new)),
            Self::Tabs { parts, .. } => parts.iter_mut().any(|part| part.split(id, direction, new)),
        }
    }

    /// Adds panes at the end: a single one to the last row while that is short, several as a row of their own.
    pub fn append(&mut self, new: &[PaneId]) {
        const LONG: usize = 3;
        // Moved out, because each arm puts the parts into another container.
        let whole = std::mem::replace(self, Self::Row(Vec::new()));
        let share = |parts: &[Part]| parts.iter().map(|part| part.share).sum::<f32>() / parts.len().max(1) as f32;
        let added = Self::rows(&[new.to_vec()]);
        *self = match (whole, new) {
            (Self::Tabs { mut parts, active }, _) => {
                parts.extend(new.iter().copied().map(Self::Pane));
                Self::Tabs { parts, active }
            }
            (Self::Column(mut rows), _) => {
                let room = rows.iter().map(|row| row.inner.panes().len()).max().unwrap_or(0).max(LONG);
                match rows.last_mut() {
                    Some(last) if new.len() == 1 && last.inner.panes().len() < room => last.inner.append(new),
                    _ => rows.push(Part { share: share(&rows), inner: added }),
                }
                Self::Column(rows)
            }
            (Self::Row(mut parts), [one]) if parts.len() < LONG => {
                parts.push(Part { share: share(&parts), inner: Self::Pane(*one) });
                Self::Row(parts)
            }
            (Self::Pane(first), [one]) => Self::rows(&[vec![first, *one]]),
            (other, _) => Self::Column(vec![Part::even(other), Part::even(added)]),
        };
    }

    pub fn replace(&mut self, id: PaneId, new: PaneId) {
        match self {
            Self::Pane(own) if *own == id => *own = new,
            Self::Pane(_) => {}
            Self::Row(parts) | Self::Column(parts) => parts.iter_mut().for_each(|part| part.inner.replace(id, new)),
            Self::Tabs { parts, .. } => parts.iter_mut().for_each(|part| part.replace(id, new)),
        }
    }

    /// Removes `id`; the others get its space. The only pane stays.
    pub fn remove(&mut self, id: PaneId) {
        if let Some(rest) = self.clone().filtered(&mut |pane| pane != id, MAX_DEPTH) {
            *self = rest;
        }
    }

    /// Keeps each pane that `keep` accepts once, makes shares finite, limits number and depth. `None` if none is left.
    #[must_use]
    pub fn sanitised(self, mut keep: impl FnMut(PaneId) -> bool) -> Option<Self> {
        let mut seen = Vec::new();
        let mut keep_once = |id| {
            let is_kept = !seen.contains(&id) && seen.len() < MAX_PANES && keep(id);
            seen.extend(is_kept.then_some(id));
            is_kept
        };
        self.filtered(&mut keep_once, MAX_DEPTH)
    }

    fn filtered(self, keep: &mut impl FnMut(PaneId) -> bool, depth: usize) -> Option<Self> {
        fn parts(parts: Vec<Part>, keep: &mut impl FnMut(PaneId) -> bool, depth: usize) -> Vec<Part> {
            let part = |Part { share, inner }: Part| {
                // A file may hold any share, and a part that is too small could not be grasped.
                let share = if share.is_finite() { share.clamp(0.05, 20.0) } else { 1.0 };
                Some(Part { share, inner: inner.filtered(keep, depth - 1)? })
            };
            parts.into_iter().filter_map(part).collect()
        }
        fn alone(mut many: Vec<Part>, container: impl FnOnce(Vec<Part>) -> Arrangement) -> Option<Arrangement> {
            match many.len() {
                0 => None,
                1 => many.pop().map(|part| part.inner),
                _ => Some(container(many)),
            }
        }
        // A file may nest deeper than anything that can be seen.
        if depth == 0 {
            return None;
        }
        match self {
            Self::Pane(id) => keep(id).then_some(Self::Pane(id)),
            Self::Row(row) => alone(parts(row, keep, depth), Self::Row),
            Self::Column(column) => alone(parts(column, keep, depth), Self::Column),
            Self::Tabs { parts: tabs, active } => {
                let all = tabs.into_iter().map(Part::even).collect();
                alone(parts(all, keep, depth), |many| {
                    let active = active.min(many.len() - 1);
                    Self::Tabs { parts: many.into_iter().map(|part| part.inner).collect(), active }
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pane(n: u32) -> Arrangement {
        Arrangement::Pane(PaneId(n))
    }

    #[test]
    fn panes_are_split_to_the_right_and_down_and_closed_again() {
        let mut arrangement = pane(0);
        assert!(arrangement.split(PaneId(0), Direction::Right, PaneId(2)));
        assert!(arrangement.split(PaneId(2), Direction::Right, PaneId(3)));
        let Arrangement::Row(parts) = &arrangement else { panic!("one row: {arrangement:?}") };
        assert_eq!(parts.iter().map(|part| part.share).collect::<Vec<_>>(), [1.0, 0.5, 0.5]);
        assert!(arrangement.split(PaneId(2), Direction::Down, PaneId(4)));
        assert_eq!(arrangement.panes(), [0, 2, 4, 3].map(PaneId));
        assert!(!arrangement.split(PaneId(9), Direction::Down, PaneId(5)));
        for closed in [0, 4, 3] {
            arrangement.remove(PaneId(closed));
        }
        assert_eq!(arrangement, pane(2));
        arrangement.remove(PaneId(2));
        assert_eq!(arrangement, pane(2), "the only pane stays");
    }

    fn any_arrangement() -> impl Strategy<Value = Arrangement> {
        let leaf = (0u32..6).prop_map(pane);
        leaf.prop_recursive(12, 40, 4, |inner| {
            let part = (any::<f32>(), inner.clone()).prop_map(|(share, inner)| Part { share, inner });
            let parts = prop::collection::vec(part, 0..4);
            prop_oneof![
                parts.clone().prop_map(Arrangement::Row),
                parts.prop_map(Arrangement::Column),
                (prop::collection::vec(inner, 0..4), any::<usize>())
                    .prop_map(|(parts, active)| Arrangement::Tabs { parts, active }),
            ]
        })
    }

    proptest! {
        #[test]
        fn whatever_a_file_holds_each_known_pane_is_there_at_most_once(arrangement in any_arrangement()) {
            if let Some(sane) = arrangement.sanitised(|id| id != PaneId(5)) {
                let mut panes = sane.panes();
                prop_assert!(!panes.is_empty() && !panes.contains(&PaneId(5)));
                panes.sort_unstable();
                panes.dedup();
                prop_assert_eq!(panes.len(), sane.panes().len());
                prop_assert_eq!(sane.clone().sanitised(|_| true), Some(sane));
            }
        }
    }
}
