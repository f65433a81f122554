//! Positions of the frames of a burst: when each was taken, or from where.
//!
//! A thing of slope s is displaced in a frame by s times the frame's position from mid-burst. Everything that moves
//! with the frames takes that distance from [`Positions::offset`], or the displacement from
//! [`Positions::displacement`]; nothing else knows where a frame lies. A frame has one coordinate, its time. Views of a
//! light field have two; these two functions are what differs for them.

use std::ops::Range;
use std::sync::Arc;

/// Positions of frames that follow one another, in frame intervals. Evenly spaced ones are 0, 1, 2, … to the bit.
/// Cheap to clone.
#[derive(Debug, Clone, PartialEq)]
pub struct Positions {
    /// Position of each frame from the mean of all.
    offsets: Arc<[f64]>,
    /// Seconds of a frame interval, where they are known.
    interval_s: Option<f64>,
}

/// Distance of a position from a whole number of intervals up to which it is one: what the digits of times leave.
const ROUNDING: f64 = 1e-4;

impl Positions {
    /// Positions of `count` frames at even distances.
    pub fn even(count: usize) -> Self {
        Self::about_mean((0..count).map(|t| t as f64))
    }

    /// Positions in frame intervals, of which only the differences matter; `None` unless all are finite and each lies
    /// after the one before.
    pub fn new(positions: &[f64]) -> Option<Self> {
        let increase = positions.iter().all(|x| x.is_finite()) && positions.windows(2).all(|two| two[0] < two[1]);
        let first = positions.first().copied().unwrap_or_default();
        let near_whole = |x: f64| if (x - x.round()).abs() <= ROUNDING { x.round() } else { x };
        increase.then(|| Self::about_mean(positions.iter().map(|x| near_whole(x - first))))
    }

    /// Positions of frames taken at `seconds`; `None` unless these increase.
    ///
    /// The frame interval is that of the camera, of which gaps where frames are missing are multiples: the time from
    /// the first to the last frame over the number of intervals, each gap being as many as it has of the median gap. So
    /// frames that are dropped change the slopes of those that stay by nothing.
    pub fn of_seconds(seconds: &[f64]) -> Option<Self> {
        let mut gaps: Vec<f64> = seconds.windows(2).map(|two| two[1] - two[0]).collect();
        let span = seconds.last().zip(seconds.first()).map_or(0.0, |(last, first)| last - first);
        if !gaps.iter().all(|gap| gap.is_finite() && *gap > 0.0) {
            return None;
        }
        gaps.sort_by(f64::total_cmp);
        let Some(median) = gaps.get(gaps.len().saturating_sub(1) / 2) else {
            return Self::new(&[0.0][..seconds.len()]);
        };
        let interval_s = span / gaps.iter().map(|gap| (gap / median).round().max(1.0)).sum::<f64>();
        let positions: Vec<f64> = seconds.iter().map(|time| (time - seconds[0]) / interval_s).collect();
        Some(Self { interval_s: Some(interval_s), ..Self::new(&positions)? })
    }

    fn about_mean(positions: impl ExactSizeIterator<Item = f64> + Clone) -> Self {
        let mean = positions.clone().sum::<f64>() / positions.len().max(1) as f64;
        Self { offsets: positions.map(|x| x - mean).collect(), interval_s: None }
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
        let first = frames.first().map_or(0.0, |t| self.offsets[*t]);
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

    /// Position of frame `t` from mid-burst, the mean of all positions, frame intervals.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn offset(&self, t: usize) -> f64 {
        self.offsets[t]
    }

    /// Positions of all frames from mid-burst, frame intervals, in their order.
    pub fn offsets(&self) -> &[f64] {
        &self.offsets
    }

    /// Position of frame `t`, one of these or not, from the mean of the frames `used`, frame intervals.
    ///
    /// # Panics
    /// If there are no such frames.
    pub fn offset_from(&self, used: Range<usize>, t: usize) -> f64 {
        let used = &self.offsets[used];
        self.offset(t) - used.iter().sum::<f64>() / used.len().max(1) as f64
    }

    /// Displacement (u, v) in frame `t`, pixels, of what moves by a slope (u, v), pixels per frame.
    pub fn displacement(&self, t: usize, slope_px_per_frame: (f64, f64)) -> (f64, f64) {
        let offset = self.offset(t);
        (offset * slope_px_per_frame.0, offset * slope_px_per_frame.1)
    }

    /// Distance of the last frame from the first, frame intervals: N − 1 for even ones.
    pub fn span(&self) -> f64 {
        match &*self.offsets {
            [first, .., last] => last - first,
            _ => 0.0,
        }
    }

    /// Largest distance of a frame from mid-burst, frame intervals: (N − 1)/2 for even ones.
    pub fn reach(&self) -> f64 {
        self.offsets.iter().fold(0.0, |reach, offset| f64::max(reach, offset.abs()))
    }

    /// Whether all frames are at even distances of one interval.
    pub fn is_even(&self) -> bool {
        self.offsets.windows(2).all(|two| two[1] - two[0] == 1.0)
    }

    /// Longest time between two frames, frame intervals, and the frame after which it is; `None` for a single frame.
    pub fn longest_gap(&self) -> Option<(f64, usize)> {
        let gaps = self.offsets.windows(2).map(|two| two[1] - two[0]);
        gaps.zip(0..).max_by(|(a, i), (b, j)| a.total_cmp(b).then(j.cmp(i)))
    }

    /// How even they are, a clause.
    pub fn unevenness(&self) -> String {
        match self.longest_gap() {
            Some(_) if self.is_even() => "they are even".to_owned(),
            Some((gap, after)) => {
                let [a, b] = [after, after + 1];
                format!("the longest gap is {gap:.2} frame intervals, between frames {a} and {b}, counted from 0")
            }
            None => "there is one frame".to_owned(),
        }
    }

    /// Slopes in pixels per second, a clause; `None` where the frame interval is not known.
    pub fn rate_text(&self) -> Option<String> {
        let rate = 1.0 / self.interval_s?;
        let digits = (2 - rate.log10().floor() as i32).clamp(0, 9) as usize;
        Some(format!("1 px/frame is {rate:.digits$} px/s"))
    }

    /// Seconds of a frame interval, where they are known.
    pub fn interval_s(&self) -> Option<f64> {
        self.interval_s
    }

    /// Positions as these, of a frame interval of `interval_s` seconds.
    pub fn with_interval(self, interval_s: Option<f64>) -> Self {
        Self { interval_s, ..self }
    }

    /// Positions from the first frame on, frame intervals; empty for even ones.
    pub fn list(&self) -> Vec<f64> {
        if self.is_even() { Vec::new() } else { self.since_first() }
    }

    /// Positions from the first frame on, frame intervals: 0, 1, 2, … for even ones.
    pub fn since_first(&self) -> Vec<f64> {
        let first = self.offsets.first().copied().unwrap_or_default();
        self.offsets.iter().map(|offset| offset - first).collect()
    }
}
