//! Positions of the frames of a burst: when each was taken, or from where.
//!
//! Something of slope s is displaced in a frame by s times the frame's position from mid-burst. Everything that moves
//! with the frames takes this position from [`Positions::offset`], and the displacement from [`Offset::displacement`].
//! A frame of a burst has one coordinate, its time. A view of a light field has two, column and row in the grid of
//! views; mid-burst is the mean view then, and a slope is the disparity between neighbouring views.

use std::ops::{Add, Mul, Range, Sub};
use std::sync::Arc;

/// Positions of frames, in frame intervals (even ones exactly 0, 1, 2, …), or of views, in steps of their grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Positions {
    /// Position of each frame from the mean of all.
    offsets: Arc<[Offset]>,
    /// Seconds of a frame interval, where they are known.
    interval_s: Option<f64>,
}

/// Position of a frame from the mean of all: frame intervals, or columns and rows of the grid of views.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Offset<T = f64> {
    /// Time, or columns to the right.
    pub u: T,
    /// 0 for a frame of a burst, or rows downwards.
    pub v: T,
}

impl<T: Copy + Default + PartialEq + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Offset<T> {
    /// Displacement (u, v), pixels, at this position of what has a slope (u, v), pixels per frame or view: their
    /// product as complex numbers. So a disparity, a slope along u, displaces along the columns and rows of the views
    /// alike, and a slope along v is that of a grid of views turned against the picture.
    pub fn displacement(self, (u, v): (T, T)) -> (T, T) {
        if self.v == T::default() {
            return (self.u * u, self.u * v);
        }
        (self.u * u - self.v * v, self.u * v + self.v * u)
    }
}

impl Offset {
    /// The position in single precision.
    pub fn to_f32(self) -> Offset<f32> {
        Offset { u: self.u as f32, v: self.v as f32 }
    }

    /// Distance from the mean of all positions.
    pub fn length(self) -> f64 {
        self.u.hypot(self.v)
    }
}

impl From<f64> for Offset {
    /// Position of a frame of a burst at a time from mid-burst, frame intervals.
    fn from(time: f64) -> Self {
        Self { u: time, v: 0.0 }
    }
}

impl<T: Sub<Output = T>> Sub for Offset<T> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { u: self.u - other.u, v: self.v - other.v }
    }
}

/// Distance of a position from a whole number of intervals up to which it is one: what the digits of times leave.
const ROUNDING: f64 = 1e-4;

impl Positions {
    /// Positions of `count` frames at even distances.
    pub fn even(count: usize) -> Self {
        Self::about_mean((0..count).map(|t| Offset::from(t as f64)))
    }

    /// Positions in frame intervals, of which only differences matter; `None` unless all are finite and increasing.
    pub fn new(positions: &[f64]) -> Option<Self> {
        let first = positions.first().copied().unwrap_or_default();
        let made = Self::about_mean(positions.iter().map(|x| Offset::from(near_whole(x - first))));
        let increase = made.offsets.iter().all(|at| at.u.is_finite()) && made.gaps().all(|gap| gap > 0.0);
        increase.then_some(made)
    }

    /// Positions of a light field's views at places (column, row) in their grid, of which only the differences matter;
    /// `None` unless all are finite and no two are equal. Views in one row that follow one another are as frames.
    pub fn of_views(places: &[[f64; 2]]) -> Option<Self> {
        let [first_u, first_v] = places.first().copied().unwrap_or_default();
        let place = |[u, v]: &[f64; 2]| Offset { u: near_whole(u - first_u), v: near_whole(v - first_v) };
        let places: Vec<Offset> = places.iter().map(place).collect();
        let mut sorted: Vec<[f64; 2]> = places.iter().map(|at| [at.v, at.u]).collect();
        // Once sorted, equal places are neighbours.
        sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let differ = sorted.iter().flatten().all(|x| x.is_finite()) && sorted.windows(2).all(|two| two[0] != two[1]);
        let is_row = places.iter().all(|at| at.v == 0.0);
        let follow = !is_row || places.windows(2).all(|two| two[0].u < two[1].u);
        (differ && follow).then(|| Self::about_mean(places.iter().copied()))
    }

    /// Positions of a full grid of views, row by row; those of one row are [even](Self::even).
    pub fn grid(rows: usize, columns: usize) -> Self {
        let place = |k: usize| Offset { u: (k % columns) as f64, v: (k / columns) as f64 };
        Self::about_mean((0..rows * columns).map(place))
    }

    /// Positions of frames taken at `seconds`; `None` unless these increase.
    ///
    /// The frame interval is the camera's: the time from the first to the last frame over the number of intervals,
    /// where a gap counts as many as it has median gaps. So dropped frames do not change the slopes of those that stay.
    pub fn of_seconds(seconds: &[f64]) -> Option<Self> {
        let mut gaps: Vec<f64> = seconds.windows(2).map(|two| two[1] - two[0]).collect();
        let span = seconds.last().zip(seconds.first()).map_or(0.0, |(last, first)| last - first);
        if !gaps.iter().all(|gap| gap.is_finite() && *gap > 0.0) {
            return None;
        }
        gaps.sort_by(f64::total_cmp);
        // The lower middle gap: gaps where frames are missing are the longer ones.
        let Some(median) = gaps.get(gaps.len().saturating_sub(1) / 2) else {
            return Self::new(&[0.0][..seconds.len()]);
        };
        let interval_s = span / gaps.iter().map(|gap| (gap / median).round().max(1.0)).sum::<f64>();
        let positions: Vec<f64> = seconds.iter().map(|time| (time - seconds[0]) / interval_s).collect();
        Some(Self { interval_s: Some(interval_s), ..Self::new(&positions)? })
    }

    fn about_mean(positions: impl ExactSizeIterator<Item = Offset> + Clone) -> Self {
        let mean = mean(positions.clone());
        Self { offsets: positions.map(|at| at - mean).collect(), interval_s: None }
    }

    /// Positions of the frames `range` alone; their mean is that of these frames.
    ///
    /// # Panics
    /// If the range reaches past the frames.
    pub fn part(&self, range: Range<usize>) -> Self {
        self.of(&range.collect::<Vec<_>>())
    }

    /// Positions of some `frames` alone, in their order; their mean is that of these frames.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn of(&self, frames: &[usize]) -> Self {
        let first = frames.first().map_or(Offset::default(), |t| self.offsets[*t]);
        // Differences of even positions are whole numbers, and stay so.
        Self { interval_s: self.interval_s, ..Self::about_mean(frames.iter().map(|t| self.offsets[*t] - first)) }
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.offsets.is_empty()
    }

    /// Position of frame `t` from mid-burst, the mean of all positions.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn offset(&self, t: usize) -> Offset {
        self.offsets[t]
    }

    /// Positions of all frames from mid-burst, in their order.
    pub fn offsets(&self) -> &[Offset] {
        &self.offsets
    }

    /// Position of frame `t`, one of these or not, from the mean of the frames `used`.
    ///
    /// # Panics
    /// If there are no such frames.
    pub fn offset_from(&self, used: Range<usize>, t: usize) -> Offset {
        self.offset(t) - mean(self.offsets[used].iter().copied())
    }

    /// Displacement (u, v) in frame `t`, pixels, of what moves by a slope (u, v), pixels per frame.
    pub fn displacement(&self, t: usize, slope_px_per_frame: (f64, f64)) -> (f64, f64) {
        self.offset(t).displacement(slope_px_per_frame)
    }

    /// Time from the first to the last frame, frame intervals: N − 1 for even ones; of a light field, its diameter.
    pub fn span(&self) -> f64 {
        match &*self.offsets {
            _ if self.are_views() => 2.0 * self.reach(),
            [first, .., last] => last.u - first.u,
            _ => 0.0,
        }
    }

    /// Largest distance of a frame from mid-burst, frame intervals: (N − 1)/2 for even ones.
    pub fn reach(&self) -> f64 {
        self.offsets.iter().fold(0.0, |reach, offset| f64::max(reach, offset.length()))
    }

    /// Whether they are places in a grid of views; those in one row are as times.
    pub fn are_views(&self) -> bool {
        self.offsets.iter().any(|offset| offset.v != 0.0)
    }

    /// Rows and columns of the grid that views fill, row by row; `None` for frames of a burst, and for other places.
    pub fn rows_and_columns(&self) -> Option<(usize, usize)> {
        let columns = self.offsets.iter().take_while(|offset| offset.v == self.offsets[0].v).count();
        let rows = self.len() / columns.max(1);
        (self.are_views() && *self == Self::grid(rows, columns)).then_some((rows, columns))
    }

    /// Whether all frames are at even distances of one interval, in time.
    pub fn is_even(&self) -> bool {
        !self.are_views() && self.gaps().all(|gap| gap == 1.0)
    }

    fn gaps(&self) -> impl Iterator<Item = f64> {
        self.offsets.windows(2).map(|two| two[1].u - two[0].u)
    }

    /// Longest time between two frames, frame intervals, and the frame after which it is; `None` for a single frame.
    pub fn longest_gap(&self) -> Option<(f64, usize)> {
        self.gaps().zip(0..).max_by(|(a, i), (b, j)| a.total_cmp(b).then(j.cmp(i)))
    }

    /// How even they are, a clause.
    pub fn unevenness(&self) -> String {
        match self.longest_gap() {
            _ if self.are_views() => match self.rows_and_columns() {
                Some((rows, columns)) => format!("they are views in {rows} rows and {columns} columns"),
                None => format!("they are {} places in a grid of views", self.len()),
            },
            Some(_) if self.is_even() => "they are even".to_owned(),
            Some((gap, after)) => {
                let [a, b] = [after, after + 1];
                format!("the longest gap is {gap:.2} frame intervals, between frames {a} and {b}, counted from 0")
            }
            None => "there is one frame".to_owned(),
        }
    }

    /// Slopes in pixels per second or per hour, a clause; `None` where the frame interval is not known.
    pub fn rate_text(&self) -> Option<String> {
        let per_second = 1.0 / self.interval_s?;
        // Between exposures of minutes things among the stars move by pixels an hour.
        let (rate, unit) = if per_second < 0.1 { (3600.0 * per_second, "px/h") } else { (per_second, "px/s") };
        let digits = (2 - rate.log10().floor() as i32).clamp(0, 9) as usize;
        Some(format!("1 px/frame is {rate:.digits$} {unit}"))
    }

    /// Seconds of a frame interval, where they are known.
    pub fn interval_s(&self) -> Option<f64> {
        self.interval_s
    }

    /// Positions as these, of a frame interval of `interval_s` seconds.
    pub fn with_interval(self, interval_s: Option<f64>) -> Self {
        Self { interval_s, ..self }
    }

    /// Times from the first frame on, frame intervals; empty for even ones, and for views.
    pub fn list(&self) -> Vec<f64> {
        if self.is_even() || self.are_views() { Vec::new() } else { self.since_first() }
    }

    /// Times from the first frame on, frame intervals: 0, 1, 2, … for even ones. Columns of views.
    pub fn since_first(&self) -> Vec<f64> {
        self.places().map(|offset| offset.u).collect()
    }

    /// Places (column, row) of views from the first one on; empty for frames of a burst.
    pub fn views(&self) -> Vec<[f64; 2]> {
        if self.are_views() { self.places().map(|offset| [offset.u, offset.v]).collect() } else { Vec::new() }
    }

    fn places(&self) -> impl Iterator<Item = Offset> {
        let first = self.offsets.first().copied().unwrap_or_default();
        self.offsets.iter().map(move |offset| *offset - first)
    }

    /// Positions of `count` frames from [`Self::list`] and [`Self::views`]; `None` for other lengths or orders.
    pub fn of_lists(count: usize, times: &[f64], views: &[[f64; 2]]) -> Option<Self> {
        match (times.len(), views.len()) {
            (0, 0) => Some(Self::even(count)),
            (n, 0) if n == count => Self::new(times),
            (0, n) if n == count => Self::of_views(views),
            _ => None,
        }
    }
}

fn near_whole(x: f64) -> f64 {
    if (x - x.round()).abs() <= ROUNDING { x.round() } else { x }
}

fn mean(positions: impl ExactSizeIterator<Item = Offset> + Clone) -> Offset {
    let count = positions.len().max(1) as f64;
    let mean = |of: fn(Offset) -> f64| positions.clone().map(of).sum::<f64>() / count;
    Offset { u: mean(|at| at.u), v: mean(|at| at.v) }
}
/// How uneven times are: the variance of the logarithms of their distances.
pub(super) fn unevenness(mut times: Vec<i128>) -> f64 {
    times.sort_unstable();
    let gaps: Vec<f64> = times.windows(2).map(|two| ((two[1] - two[0]) as f64).ln()).collect();
    let mean = gaps.iter().sum::<f64>() / gaps.len().max(1) as f64;
    let variance = gaps.iter().map(|gap| (gap - mean).powi(2)).sum::<f64>();
    if variance.is_nan() { f64::INFINITY } else { variance }
}
