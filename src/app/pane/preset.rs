//! Presets of *One burst*, of its methods, and of *Two bursts*; panes of methods come and go as these are switched.

use super::set::{PanesById, Placed};
use super::{Arrangement, Content, Link, MAX_PANES, Over, Pane, PaneGroup, PaneId, Panes, SliceAxis};
use crate::app::document::cursor::{ViewKind, level_range, nearest_on_grid, stepped};
use crate::app::document::{MethodId, Ranges, Side};
use crate::app::words::choices;
use crate::detector::{DetectorParams, Slope};

pub use crate::teach::Layout as Preset;

#[derive(Debug, Clone)]
pub struct Laid {
    pub rows: Vec<Vec<Pane>>,
    /// Index of the pane, in reading order, that continues the focused one.
    pub focus: usize,
}

impl Preset {
    pub const ALL: [(Self, &'static str, &'static str); 11] = {
        const NEIGHBOURS: &str = "Neighbouring slopes of the grid, which move together";
        [
            (Self::Single, "Single pane", "The pane in focus alone"),
            (Self::FrameAndStack, "Frame and motion stack", "One frame beside the motion stack"),
            (Self::TwoSlopes, "Two slopes", "The slope beside the grid's next one, each moved on its own"),
            (Self::ThreeSlopes, "3 neighbouring slopes", NEIGHBOURS),
            (Self::FiveSlopes, "5 neighbouring slopes", NEIGHBOURS),
            (Self::SevenSlopes, "7 neighbouring slopes", NEIGHBOURS),
            (Self::NineSlopes, "9 neighbouring slopes", NEIGHBOURS),
            (Self::Scales, "Scales of the octave", "The DoG responses of all levels of the octave"),
            (
                Self::TwoByTwo,
                "2 × 2: frame, stack, DoG, merge",
                "Frame, motion stack, DoG response and merged frames of the same place",
            ),
            (Self::Slice, "Stack and slice", "The motion stack above a slice through all frames at the probed place"),
            (Self::Methods, "Methods", "A picture for each of several methods, with a table of their numbers"),
        ]
    };

    pub fn lay_out(self, base: &Pane, params: &DetectorParams) -> Laid {
        // A preset starts from the focused pane: burst, view and slope go on.
        let base = Pane { over: None, content: Content::Cursor, ..base.clone() };
        let at = |change: &dyn Fn(&mut Pane)| {
            let mut pane = base.clone();
            change(&mut pane);
            pane
        };
        // A frame does not depend on the slope.
        let moving = if base.cursor.kind == ViewKind::Frame { ViewKind::Stack } else { base.cursor.kind };
        let at_slope = |slope: Slope, is_linked: bool| {
            at(&|p| {
                p.show(moving);
                (p.cursor.slope, p.slope_chosen, p.links.cursor) = (slope, true, is_linked);
            })
        };
        let neighbours = |count: usize| {
            let (slopes, focus) = neighbouring_slopes(base.cursor.slope, params, count);
            // With a link, so that neighbours keep their distance as one is moved.
            Laid { rows: in_rows(slopes.into_iter().map(|slope| at_slope(slope, true)).collect()), focus }
        };
        match self {
            // Methods have panes of their own.
            Self::Single | Self::Methods => Laid { rows: vec![vec![base]], focus: 0 },
            Self::FrameAndStack => {
                let (frame, stack) = (at(&|p| p.show(ViewKind::Frame)), at(&|p| p.show(moving)));
                let focus = usize::from(base.cursor.kind != ViewKind::Frame);
                Laid { rows: vec![vec![frame, stack]], focus }
            }
            Self::TwoSlopes => {
                // Without a link, because the two slopes are to be moved on their own.
                let two = two_slopes(base.cursor.slope, params).map(|slope| at_slope(slope, false));
                Laid { rows: vec![two.to_vec()], focus: 0 }
            }
            Self::ThreeSlopes => neighbours(3),
            Self::FiveSlopes => neighbours(5),
            Self::SevenSlopes => neighbours(7),
            Self::NineSlopes => neighbours(9),
            Self::Scales => {
                let levels = level_range(params);
                let focus = (base.cursor.level - levels.start()).max(0) as usize;
                let show = |p: &mut Pane, level: i32| {
                    p.show(ViewKind::Dog);
                    (p.cursor.level, p.links.cursor) = (level, true);
                };
                let panes: Vec<Pane> = levels.map(|level| at(&|p| show(p, level))).collect();
                let focus = focus.min(panes.len() - 1);
                Laid { rows: in_rows(panes), focus }
            }
            Self::Slice => {
                // On a line of slopes nothing moves across the line: that slice would show nothing slanted.
                let axes = if params.used_slopes().is_plane() { &SliceAxis::ALL[..] } else { &SliceAxis::ALL[..1] };
                let slices = axes.iter().map(|&axis| at(&|p| p.show_slice(axis))).collect();
                Laid { rows: vec![vec![at(&|p| p.show(moving))], slices], focus: 0 }
            }
            Self::TwoByTwo => {
                let [frame, stack, dog] = ViewKind::OF_CURSOR.map(|kind| at(&|p| p.show(kind)));
                let focus = ViewKind::OF_CURSOR.iter().position(|kind| *kind == base.cursor.kind).unwrap_or(1);
                Laid { rows: vec![vec![frame, stack], vec![dog, at(&|p| p.show(ViewKind::Merge))]], focus }
            }
        }
    }
}

pub(super) fn in_rows<T: Clone>(panes: Vec<T>) -> Vec<Vec<T>> {
    let rows = match panes.len() {
        0..=3 => 1,
        4..=8 => 2,
        _ => 3,
    };
    panes.chunks(panes.len().div_ceil(rows).max(1)).map(<[T]>::to_vec).collect()
}

/// The slope itself and the grid's next one, or the previous one where it is the last.
fn two_slopes(slope: Slope, params: &DetectorParams) -> [Slope; 2] {
    let grid = &params.slopes;
    let along_v = grid.u.count <= 1 && grid.v.count > 1;
    let next = stepped(grid, slope, along_v, true);
    [slope, if next == slope { stepped(grid, slope, along_v, false) } else { next }]
}

/// Along the grid's first axis with several, the nearest to `slope` in the middle as far as the grid reaches; and the
/// index of that one. On a grid of one slope the neighbours are 0.25 px/frame apart.
fn neighbouring_slopes(slope: Slope, params: &DetectorParams, count: usize) -> (Vec<Slope>, usize) {
    let grid = &params.slopes;
    let along_v = grid.u.count <= 1 && grid.v.count > 1;
    let has = if along_v { grid.v.count } else { grid.u.count };
    if has <= 1 {
        let middle = (count / 2) as f32;
        let at = |i: usize| Slope::new(slope.u + 0.25 * (i as f32 - middle), slope.v);
        return ((0..count).map(at).collect(), count / 2);
    }
    let count = count.min(has);
    let (i, j) = nearest_on_grid(grid, slope);
    let here = if along_v { j } else { i };
    let first = here.saturating_sub(count / 2).min(has - count);
    let at = |k: usize| if along_v { grid.at(i as f32, k as f32) } else { grid.at(k as f32, j as f32) };
    ((first..first + count).map(at).collect(), here - first)
}

choices! {
    SidesPreset {
        SideBySide: "A beside B", "One picture of each burst, A on the left";
        Stacked: "A above B", "One picture of each burst, A on top: for wide frames";
        StackAndDog: "Stack and DoG of both", "The motion stacks of both bursts above their DoG responses";
        Difference: "A, B and their difference", "Both pictures, and below them A less B, pixel by pixel";
    }
}

choices! {
    #[derive(Default)]
    MethodsPreset {
        #[default]
        Panes: "Panes", "A picture for each method, side by side";
        Wipe: "Wipe", "Two methods in one picture, with a line between them that can be dragged";
        Flip: "Flip", "Two methods in one place: Y flips from one to the other";
        Matches: "Match lines", "A row for each method: its matches between A and B";
    }
}

impl Panes {
    pub fn lay_out_sides(&mut self, preset: SidesPreset) {
        let own = Side::BOTH.map(PaneId::of);
        let plain = |pane: &Pane| Pane { over: None, content: Content::Cursor, ..pane.clone() };
        let mut made: PanesById = own.into_iter().zip(self.sides.iter().map(plain)).collect();
        let rows = match preset {
            SidesPreset::SideBySide => vec![own.to_vec()],
            SidesPreset::Stacked => own.map(|id| vec![id]).to_vec(),
            SidesPreset::StackAndDog => {
                let dogs = own.map(|id| {
                    let mut dog = made[&id].clone();
                    dog.show(ViewKind::Dog);
                    let new = self.fresh();
                    made.insert(new, dog);
                    new
                });
                // After the DoG panes, which copy the panes before this change.
                made.iter_mut().filter(|(id, _)| own.contains(id)).for_each(|(_, pane)| pane.show(ViewKind::Stack));
                vec![own.to_vec(), dogs.to_vec()]
            }
            SidesPreset::Difference => {
                let new = self.fresh();
                made.insert(new, Pane { content: Content::Difference(own[0], own[1]), ..made[&own[0]].clone() });
                vec![own.to_vec(), vec![new]]
            }
        };
        let focus = self.placed[PaneGroup::Pair as usize].focus;
        self.replace(PaneGroup::Pair, Placed { arrangement: Arrangement::rows(&rows), focus }, made);
    }

    /// On B as well where the preset shows matches. A wipe or flip takes SIFT and BuFF 1D where these are compared.
    pub fn lay_out_methods(&mut self, preset: MethodsPreset, methods: &[MethodId], both: bool) {
        let usual = [MethodId::Sift, MethodId::Buff1d];
        let mut two = usual.into_iter().chain(methods.iter().copied()).filter(|method| methods.contains(method));
        let first = two.next();
        let second = two.find(|method| Some(*method) != first);
        let two: Vec<MethodId> = first.into_iter().chain(second).collect();
        let mut made = PanesById::new();
        let mut make = |panes: &mut Self, method: MethodId, side: Side| {
            let id = panes.fresh();
            made.insert(id, panes.of_method(method, side));
            id
        };
        let arrangement = match preset {
            // A single method has nothing to lie over, and gets a pane as below.
            MethodsPreset::Wipe | MethodsPreset::Flip if two.len() > 1 => {
                let ids: Vec<PaneId> = two.into_iter().map(|method| make(self, method, Side::A)).collect();
                let other = ids[1];
                let over = match preset {
                    MethodsPreset::Wipe => Over::Wipe { other, at: 0.5 },
                    _ => Over::Flip { other, flipped: false },
                };
                made.entry(ids[0]).and_modify(|pane| pane.over = Some(over));
                // The second picture is drawn over the first, and needs no place of its own on screen.
                Arrangement::Tabs { parts: ids.into_iter().map(Arrangement::Pane).collect(), active: 0 }
            }
            MethodsPreset::Matches if both => {
                let row = |method: &MethodId| Side::BOTH.map(|side| make(self, *method, side)).to_vec();
                Arrangement::rows(&methods.iter().map(row).collect::<Vec<_>>())
            }
            _ => Arrangement::rows(&in_rows(methods.iter().map(|method| make(self, *method, Side::A)).collect())),
        };
        let Some(focus) = arrangement.panes().first().copied() else { return };
        self.replace(PaneGroup::Methods, Placed { arrangement, focus }, made);
    }

    /// Adds a pane of A, and a row with B where the other methods have rows, unless there is one.
    pub fn add_method(&mut self, method: MethodId, both: bool) {
        let shown = self.shown_in(PaneGroup::Methods);
        let panes = || shown.iter().filter_map(|id| self.get(*id));
        if panes().any(|pane| pane.method == Some(method)) || shown.len() + 2 > MAX_PANES {
            return;
        }
        let sides = if both && panes().any(|pane| pane.side == Side::B) { &Side::BOTH[..] } else { &Side::BOTH[..1] };
        let mut ids = Vec::new();
        for side in sides {
            let id = self.fresh();
            self.more.insert(id, self.of_method(method, *side));
            ids.push(id);
        }
        self.placed[PaneGroup::Methods as usize].arrangement.append(&ids);
    }

    pub fn remove_method(&mut self, method: MethodId) {
        for id in self.shown_in(PaneGroup::Methods) {
            if self.get(id).is_some_and(|pane| pane.method == Some(method)) {
                self.close_in(PaneGroup::Methods, id);
            }
        }
    }

    fn of_method(&self, method: MethodId, side: Side) -> Pane {
        let shown = self.shown_in(PaneGroup::Methods);
        // As the panes of other methods, so that all show one place; a gold standard has a view of its own.
        let alike = |pane: &&Pane| pane.method.is_some() && pane.method != Some(MethodId::Gold) && pane.side == side;
        let base = shown.iter().filter_map(|id| self.get(*id)).find(alike).unwrap_or_else(|| self.of(side));
        let Pane { cursor, view, .. } = *base;
        let content = Content::Cursor;
        let mut pane = Pane { method: Some(method), content, slope_chosen: true, cursor, view, ..Pane::new(side) };
        if method == MethodId::Gold {
            // A gold standard is taken in more light, so that a shared range would not fit.
            pane.links.set(Link::Display, false);
            pane.own_ranges = Some(Ranges::default());
        }
        pane
    }
}
