//! The cursor of a pane: kind of picture, frame, slope, octave and level.

use crate::app::defaults::with_defaults;
use crate::detector::scale_space::searched_octaves;
use crate::detector::{DetectorParams, Slope, SlopeGrid};
use crate::requests::PictureKind;
pub use crate::requests::ViewKind;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Position of a pane's cursor. The slope may lie between the grid's slopes.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Cursor {
    /// Kind of picture that was shown last of those of [`ViewKind::OF_CURSOR`].
    pub kind: ViewKind,
    pub frame: usize,
    pub slope: Slope,
    /// Octave; −1 is the doubled image.
    pub octave: i32,
    pub level: i32,
}

impl Cursor {
    pub fn picture(&self, kind: ViewKind) -> PictureKind {
        let Self { slope, octave, level, .. } = *self;
        match kind {
            ViewKind::Frame => PictureKind::Frame(self.frame),
            ViewKind::Stack => PictureKind::Stack { slope },
            ViewKind::Dog => PictureKind::Dog { octave, level, slope },
            ViewKind::Merge => PictureKind::Merge,
            map => PictureKind::Map { map, octave, level, slope },
        }
    }

    /// The cursor moved by as much as another one moved from `before` to `after`. The kind of picture stays.
    #[must_use]
    pub fn moved_as(self, before: &Self, after: &Self) -> Self {
        let moved = |mine: f32, before: f32, after: f32| if before == after { mine } else { mine + (after - before) };
        Self {
            kind: self.kind,
            frame: self.frame.saturating_add_signed(after.frame as isize - before.frame as isize),
            slope: Slope::new(
                moved(self.slope.u, before.slope.u, after.slope.u),
                moved(self.slope.v, before.slope.v, after.slope.v),
            ),
            octave: self.octave.saturating_add(after.octave.saturating_sub(before.octave)),
            level: self.level.saturating_add(after.level.saturating_sub(before.level)),
        }
    }

    /// All values clamped to the range of the burst and the parameters; slopes that are not finite become 0.
    #[must_use]
    pub fn within(self, params: &DetectorParams, frame_count: usize, size: (usize, usize)) -> Self {
        let (octaves, levels) = (octave_range(params, size), level_range(params));
        let limit = slope_limit(&params.slopes);
        let clamp = |x: f32| if x.is_finite() { x.clamp(-limit, limit) } else { 0.0 };
        Self {
            frame: self.frame.min(frame_count.saturating_sub(1)),
            slope: Slope::new(clamp(self.slope.u), clamp(self.slope.v)),
            octave: self.octave.clamp(*octaves.start(), *octaves.end()),
            level: self.level.clamp(*levels.start(), *levels.end()),
            ..self
        }
    }
}

pub fn octave_range(params: &DetectorParams, size: (usize, usize)) -> RangeInclusive<i32> {
    let octaves = searched_octaves(params, size);
    octaves.start..=(octaves.end - 1).max(octaves.start)
}

/// Levels of features, and a further level on each side for the comparison.
pub fn level_range(params: &DetectorParams) -> RangeInclusive<i32> {
    -1..=params.levels as i32
}

/// Pixels per frame: a little beyond the grid, so that slopes past its edge can be seen.
pub fn slope_limit(grid: &SlopeGrid) -> f32 {
    (grid.max_magnitude() * 1.25).clamp(1.0, 1e4).ceil()
}

pub fn nearest_on_grid(grid: &SlopeGrid, slope: Slope) -> (usize, usize) {
    let distance = |s: Slope| Slope::new(s.u - slope.u, s.v - slope.v).magnitude();
    let nearest = (0..grid.len()).min_by(|&a, &b| distance(grid.slope(a)).total_cmp(&distance(grid.slope(b))));
    grid.coordinates(nearest.unwrap_or(0))
}

pub fn snapped(grid: &SlopeGrid, slope: Slope) -> Slope {
    let (i, j) = nearest_on_grid(grid, slope);
    grid.at(i as f32, j as f32)
}

/// The grid's next slope along its first or second axis; 0.25 px/frame further where that has a single slope.
pub fn stepped(grid: &SlopeGrid, slope: Slope, along_second: bool, forward: bool) -> Slope {
    let step = if forward { 0.25 } else { -0.25 };
    let (i, j) = nearest_on_grid(grid, slope);
    let moved = |x: usize, count: usize| if forward { (x + 1).min(count - 1) } else { x.saturating_sub(1) };
    match along_second {
        false if grid.u.count <= 1 => Slope::new(slope.u + step, slope.v),
        true if grid.v.count <= 1 => Slope::new(slope.u, slope.v + step),
        false => grid.at(moved(i, grid.u.count) as f32, j as f32),
        true => grid.at(i as f32, moved(j, grid.v.count) as f32),
    }
}

/// Pictures that playing steps through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlayOver {
    /// Frames if the pane in focus shows one, else slopes.
    #[default]
    Shown,
    Frames,
    /// Those of the row of the grid that the cursor is in.
    Slopes,
    Scales,
}

with_defaults! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(default)]
    pub struct Playing {
        pub over: PlayOver,
        /// Pictures a second, at most.
        pub rate: u8 = 5,
    }
}

/// Slopes of the grid's row nearest to `slope`, or of its column where rows have one; and the place of the nearest.
pub fn row_of(grid: &SlopeGrid, slope: Slope) -> (Vec<Slope>, usize) {
    let (i, j) = nearest_on_grid(grid, slope);
    if grid.u.count > 1 {
        ((0..grid.u.count).map(|i| grid.at(i as f32, j as f32)).collect(), i)
    } else {
        ((0..grid.v.count).map(|j| grid.at(i as f32, j as f32)).collect(), j)
    }
}

/// Place after so many steps from 0 through `count` places, forwards and backwards in turn.
pub fn back_and_forth(step: usize, count: usize) -> usize {
    let period = (2 * count).saturating_sub(2).max(1);
    let place = step % period;
    if place < count { place } else { period - place }
}
