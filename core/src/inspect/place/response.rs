//! The response at one place over slope and scale, finer than the grid: D in units of its noise, with its sign. It is
//! computed from the frames, and equals the search's up to interpolation.

use super::order::PlaceMotion;
use crate::detector::{Scale, Slope, SlopeAxis, Trail};
use crate::monitor::{Cancelled, Monitor};
use crate::plane::Plane;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;

/// One scale of the search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MapScale {
    /// Octave.
    pub octave: i32,
    /// DoG level, 0 … S−1.
    pub level: i32,
    /// σ, input pixels.
    pub sigma: f32,
}

/// The slopes of one axis of the grid and those between them, a step beyond both ends.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FineAxis {
    /// Slopes along the axis, px/frame, from the smallest to the largest.
    pub values: Vec<f32>,
    /// The grid's own slopes on this axis, px/frame.
    pub grid: Vec<f32>,
}

impl FineAxis {
    /// Number of slopes for each step of `axis`, up to `wanted`.
    fn per_step(axis: &SlopeAxis, wanted: usize) -> usize {
        (MOST / (axis.count + 2)).clamp(1, wanted)
    }

    /// `finer` slopes for each step, and as many beyond both ends; a single slope stays alone.
    fn of(axis: &SlopeAxis, finer: usize) -> Self {
        let grid: Vec<f32> = (0..axis.count).map(|i| axis.value(i as f32)).collect();
        if axis.count == 1 {
            return Self { values: grid.clone(), grid };
        }
        let finer = finer as i64;
        let values = (-finer..=(axis.count as i64) * finer).map(|k| axis.value(k as f32 / finer as f32)).collect();
        Self { values, grid }
    }

    /// The column of a slope; fractions lie between columns.
    pub fn column_of(&self, slope: f32) -> f32 {
        if let [first, second, ..] = self.values[..] { (slope - first) / (second - first) } else { 0.0 }
    }
}

/// Response over slope and scale.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResponseMap {
    /// Place, input pixels at mid-burst.
    pub pos_image: [f32; 2],
    /// Scales, from fine to coarse: the rows.
    pub scales: Vec<MapScale>,
    /// Slopes: the columns, along the first axis with several slopes, through the subject's slope on the other.
    pub slopes: FineAxis,
    /// Whether the columns are slopes of the second axis, v.
    pub along_v: bool,
    /// Slope of each column, px/frame.
    pub columns: Vec<Slope>,
    /// D over its noise; columns × scales. In a burst without noise D itself.
    #[serde(serialize_with = "rows")]
    pub snr: Plane,
    /// Response over both slopes at the subject's scale, for two axes.
    pub plane: Option<SlopePlane>,
    /// Factor of the noise gate: the contour that separates noise from possible features.
    pub gate: f32,
    /// Whether the values are D itself, because the burst has no noise.
    pub is_noiseless: bool,
}

/// Response over both axes of slopes at one scale.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlopePlane {
    /// The scale.
    pub scale: MapScale,
    /// Slopes of the first axis: the columns.
    pub u: FineAxis,
    /// Slopes of the second axis: the rows.
    pub v: FineAxis,
    /// D over its noise; columns × rows.
    #[serde(serialize_with = "rows")]
    pub snr: Plane,
}

fn rows<S: serde::Serializer>(plane: &Plane, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq((0..plane.height()).map(|v| plane.row(v)))
}

impl ResponseMap {
    /// The row of a scale; `None` for a scale that is not in the map.
    pub fn row_of(&self, octave: i32, level: i32) -> Option<usize> {
        self.scales.iter().position(|s| (s.octave, s.level) == (octave, level))
    }

    /// The row of a scale; fractions lie between rows, which are uniform in the logarithm of σ.
    pub fn row_at(&self, sigma: f32) -> f32 {
        let Some(next) = self.scales.iter().position(|scale| scale.sigma >= sigma) else {
            return self.scales.len() as f32 - 1.0;
        };
        let Some(before) = next.checked_sub(1) else { return 0.0 };
        let (a, b) = (self.scales[before].sigma, self.scales[next].sigma);
        before as f32 + (sigma / a).ln() / (b / a).ln()
    }

    /// The column of a slope: the nearest one, plus the slope's distance from it along the axis.
    pub fn column_of(&self, slope: Slope) -> f32 {
        let apart = |other: &Slope| (other.u - slope.u).hypot(other.v - slope.v);
        let nearest =
            (0..self.columns.len()).min_by(|&a, &b| apart(&self.columns[a]).total_cmp(&apart(&self.columns[b])));
        let (Some(nearest), [first, .., last]) = (nearest, &self.columns[..]) else { return 0.0 };
        let (du, dv) = (last.u - first.u, last.v - first.v);
        let length = du.hypot(dv);
        let on = self.columns[nearest];
        let more = if length > 0.0 { ((slope.u - on.u) * du + (slope.v - on.v) * dv) / length } else { 0.0 };
        self.slopes.column_of(self.slopes.values[nearest] + more)
    }

    /// The columns, fractions between them, one standard deviation to each side of a motion.
    pub fn band_of(&self, motion: &PlaceMotion) -> [f32; 2] {
        let at = self.column_of(motion.slope);
        let part = match self.slopes.values[..] {
            [first, second, ..] => motion.sigma / (second - first).abs(),
            _ => 0.0,
        };
        [at - part, at + part]
    }

    /// The strongest response: (column, row, value).
    pub fn strongest(&self) -> (usize, usize, f32) {
        let width = self.snr.width();
        let best = self.snr.data().iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        best.map_or((0, 0, 0.0), |(index, &value)| (index % width, index / width, value))
    }
}

/// Lines between cells that reach the gate and cells that do not: both ends as (column, row) from the first's centre.
pub fn outline(map: &Plane, gate: f32) -> Vec<[(f32, f32); 2]> {
    let reaches = |column: usize, row: usize| map.at(column, row).abs() >= gate;
    let (columns, rows) = map.size();
    let mut lines = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let (right, below) = (column as f32 + 0.5, row as f32 + 0.5);
        if column + 1 < columns && reaches(column, row) != reaches(column + 1, row) {
            lines.push([(right, below - 1.0), (right, below)]);
        }
        if row + 1 < rows && reaches(column, row) != reaches(column, row + 1) {
            lines.push([(right - 1.0, below), (right, below)]);
        }
    }
    lines
}

/// Number of slopes for each step of a line of slopes, and of a plane.
const FINER: usize = 4;
const FINER_IN_PLANE: usize = 3;
/// Maximum number of columns and rows of a map: a probe should not take long on a grid of thousands of slopes.
const MOST: usize = 121;

/// The response at `place` (input pixels) around `through` (coordinates in the grid); in a plane at `scale` over both.
pub fn response_map(
    trail: &Trail,
    place: [f32; 2],
    through: (usize, usize),
    scale: Scale,
    monitor: &Monitor,
) -> Result<ResponseMap, Cancelled> {
    let grid = trail.params().used_slopes();
    let along_v = grid.u.count == 1 && grid.v.count > 1;
    let axis = if along_v { grid.v } else { grid.u };
    let per_step = FineAxis::per_step(&axis, FINER);
    let slopes = FineAxis::of(&axis, per_step);
    let coordinate = |k: usize| if axis.count == 1 { 0.0 } else { k as f32 / per_step as f32 - 1.0 };
    let (i, j) = (through.0 as f32, through.1 as f32);
    let columns: Vec<Slope> = (0..slopes.values.len())
        .map(|k| if along_v { grid.at(i, coordinate(k)) } else { grid.at(coordinate(k), j) })
        .collect();
    let levels = trail.space().levels as i32;
    let scales =
        trail.octaves().flat_map(|octave| (0..levels).map(move |level| scale_of(trail, Scale { octave, level })));
    let octaves: Vec<i32> = trail.octaves().collect();
    // One patch is used for all levels of an octave.
    let jobs: Vec<(usize, i32)> =
        (0..columns.len()).flat_map(|column| octaves.iter().map(move |&octave| (column, octave))).collect();
    let values = |&(column, octave): &(usize, i32)| {
        monitor.check()?;
        Ok(snr_at(trail, (octave, 0..levels), place, columns[column]))
    };
    let values = jobs.par_iter().map(values).collect::<Result<Vec<Vec<f32>>, Cancelled>>()?;
    let (scales, of_levels) = (scales.collect::<Vec<_>>(), levels as usize);
    let snr = Plane::from_fn(columns.len(), scales.len(), |column, row| {
        values[column * octaves.len() + row / of_levels][row % of_levels]
    });
    let plane = if grid.is_plane() { Some(slope_plane(trail, place, scale, monitor)?) } else { None };
    let (pos_image, detection) = (place, trail.detection());
    let (gate, is_noiseless) = (detection.noise_gate_factor, detection.frame_noise <= 0.0);
    Ok(ResponseMap { pos_image, scales, slopes, along_v, columns, snr, plane, gate, is_noiseless })
}

fn scale_of(trail: &Trail, Scale { octave, level }: Scale) -> MapScale {
    MapScale { octave, level, sigma: trail.space().sigma_image(octave, f64::from(level)) as f32 }
}

fn slope_plane(trail: &Trail, place: [f32; 2], scale: Scale, monitor: &Monitor) -> Result<SlopePlane, Cancelled> {
    let grid = trail.params().used_slopes();
    let steps = [grid.u, grid.v].map(|axis| FineAxis::per_step(&axis, FINER_IN_PLANE));
    let (u, v) = (FineAxis::of(&grid.u, steps[0]), FineAxis::of(&grid.v, steps[1]));
    let at = |k: usize, steps: usize| k as f32 / steps as f32 - 1.0;
    let (columns, rows) = (u.values.len(), v.values.len());
    let value = |cell: usize| {
        monitor.check()?;
        let slope = grid.at(at(cell % columns, steps[0]), at(cell / columns, steps[1]));
        Ok(snr_at(trail, (scale.octave, scale.level..scale.level + 1), place, slope)[0])
    };
    let values = (0..columns * rows).into_par_iter().map(value).collect::<Result<Vec<f32>, Cancelled>>()?;
    Ok(SlopePlane { scale: scale_of(trail, scale), u, v, snr: Plane::from_vec(columns, rows, values) })
}

/// D over its noise at each of the levels; D itself where there is no noise.
pub(super) fn snr_at(trail: &Trail, (octave, levels): (i32, Range<i32>), [u, v]: [f32; 2], slope: Slope) -> Vec<f32> {
    let covering = covering(trail, [u, v], slope);
    let values = trail.along().response(octave, levels.clone(), (u, v), slope, &covering);
    let of_noise = |(level, value): (i32, f32)| {
        let sigma_d = trail.sigma_d_at(Scale { octave, level }, ((u, v), slope), &covering);
        if sigma_d > 0.0 { value / sigma_d } else { value }
    };
    levels.zip(values).map(of_noise).collect()
}

/// The frames (as indices among those used) that show the place at a slope; all of them where none does.
pub(super) fn covering(trail: &Trail, place: [f32; 2], slope: Slope) -> Vec<usize> {
    let showing = trail.showing((place[0], place[1]), slope);
    if showing.is_empty() { (0..trail.offsets(slope).len()).collect() } else { showing }
}
