//! Fixed pattern of a sensor: [hot pixels](super::hot_pixels), and [columns and rows](super::stripes) with an offset of
//! their own.
//!
//! A fixed pattern stays where it is while the scene moves, and it is sharper than any image through a lens. So it is
//! detected in the mean of the frames at slope 0, separately in the first and the second half of the burst, and must be
//! in both. On a tripod the scene stays as well; then the two cannot be told apart, and nothing is changed.

use super::high_pass::{FREE_VALUES, HighPass, quiet_variance};
use super::hot_pixels;
use super::pyramid::BoxPyramid;
use super::reading::Reading;
use super::stripes::{REACH, Stripes};
use crate::plane::Plane;
use serde::Serialize;

/// The pattern of a sensor, in the units of the frames.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct FixedPattern {
    /// Columns and rows of pixels that are far brighter or darker than all pixels around them, in every frame; row by
    /// row.
    pub hot_pixels: Vec<(usize, usize)>,
    /// Offset of each column.
    pub columns: Option<Stripes>,
    /// Offset of each row.
    pub rows: Option<Stripes>,
    /// Number of pixels that would be hot, but cannot be told from the scene because it stays in place too.
    pub inseparable: usize,
}

/// Share of hot pixels above which they are taken for texture.
const MAX_HOT: f32 = 0.005;

impl FixedPattern {
    /// Contrast with its row above which a pixel stands out, when `frames` frames of `size` are [read](Reading::new)
    /// for [`Self::find`]; `variance` is that of the noise of one frame. `None` where no pattern can be found: in fewer
    /// than four frames, in tiny ones, or without noise.
    pub fn stands_out(frames: usize, (width, height): (usize, usize), variance: f32) -> Option<f32> {
        let can_be_found = frames >= 4 && width >= 2 * REACH && height >= 2 * REACH && variance > 0.0;
        can_be_found.then(|| hot_pixels::limit_of_first_look(frames, variance))
    }

    /// Whether there is nothing to remove.
    pub fn is_empty(&self) -> bool {
        self.hot_pixels.is_empty() && self.columns.is_none() && self.rows.is_none()
    }

    /// Finds the pattern of frames of equal brightness from their `reading`; `variance` is that of the noise of one
    /// frame. Empty where only their pyramids were read.
    pub fn find(frames: &[&Plane], reading: &Reading, variance: f32) -> Self {
        if reading.columns.iter().any(Vec::is_empty) {
            return Self::default();
        }
        let (width, height) = frames[0].size();
        let mut hot_pixels = hot_pixels::find(&reading.standing_out, frames, variance);
        let mut inseparable = 0;
        let are_texture = hot_pixels.len() as f32 > MAX_HOT * (width * height) as f32;
        if !hot_pixels.is_empty() && (are_texture || stays(&reading.pyramids, &hot_pixels)) {
            inseparable = hot_pixels.len();
            hot_pixels.clear();
        }
        let columns = Stripes::find(&reading.columns);
        let rows = Stripes::find(&reading.rows);
        Self { hot_pixels, columns, rows, inseparable }
    }

    /// Removes the pattern from a frame.
    pub fn remove_from(&self, frame: &mut Plane) {
        hot_pixels::mask(frame, &self.hot_pixels);
        let rows = self.rows.as_ref().map(|rows| &rows.offsets);
        for v in 0..frame.height() {
            let of_row = rows.map_or(0.0, |rows| rows[v]);
            let row = frame.row_mut(v);
            match &self.columns {
                Some(columns) => row.iter_mut().zip(&columns.offsets).for_each(|(x, offset)| *x -= offset + of_row),
                None => row.iter_mut().for_each(|x| *x -= of_row),
            }
        }
    }
}

/// Whether the scene stays in place: the halves of the frames have more in common, outside `hot` pixels, than they
/// differ by.
fn stays(pyramids: &[BoxPyramid], hot: &[(usize, usize)]) -> bool {
    if pyramids.iter().any(BoxPyramid::is_empty) {
        return false;
    }
    let (first, second) = pyramids.split_at(pyramids.len() / 2);
    let mean = |half: &[BoxPyramid]| {
        let mut sum = half[0].level(1).clone();
        for pyramid in &half[1..] {
            sum.data_mut().iter_mut().zip(pyramid.level(1).data()).for_each(|(sum, x)| *sum += x);
        }
        let (width, height) = sum.size();
        let halved = hot.iter().map(|&(u, v)| (u / 2, v / 2)).filter(|&(u, v)| u < width && v < height);
        hot_pixels::mask(&mut sum, &halved.collect::<Vec<_>>());
        sum
    };
    let squares = HighPass::new(&[&mean(first), &mean(second)]);
    let of = |sign: f32| quiet_variance(squares.variances(&[(0, 1.0), (1, sign)]), FREE_VALUES);
    !squares.places.is_empty() && of(1.0) > 1.5 * of(-1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::Burst;
    use crate::monitor::Monitor;
    use crate::synth::random::Stream;
    use crate::synth::{NoiseCase, SceneParams, synth_scene};

    /// Plane with rows and columns exchanged.
    fn turned(plane: &Plane) -> Plane {
        Plane::from_fn(plane.height(), plane.width(), |u, v| plane.at(v, u))
    }

    fn planes(burst: &Burst) -> Vec<Plane> {
        burst.frames.iter().map(|f| (**f).clone()).collect()
    }

    fn find(frames: &[Plane], sigma: f32) -> FixedPattern {
        let frames: Vec<&Plane> = frames.iter().collect();
        let stands_out = FixedPattern::stands_out(frames.len(), frames[0].size(), sigma * sigma);
        let reading = Reading::new(&frames, 3, stands_out, &Monitor::default()).expect("not cancelled");
        FixedPattern::find(&frames, &reading, sigma * sigma)
    }

    fn case(case: NoiseCase) -> Vec<Plane> {
        planes(&case.burst((320, 240), 10, 0.02, 5, &Monitor::default()).expect("not cancelled"))
    }

    fn scene(max_slope: f64) -> Vec<Plane> {
        let scene = SceneParams { width: 320, height: 240, layers: 1, max_slope, ..SceneParams::default() };
        planes(&synth_scene(&scene, &Monitor::default()).expect("a scene").0)
    }

    fn deviation(plane: &Plane) -> f32 {
        let n = plane.data().len() as f32;
        let mean = plane.data().iter().sum::<f32>() / n;
        (plane.data().iter().map(|x| (x - mean).powi(2)).sum::<f32>() / n).sqrt()
    }

    #[test]
    fn nothing_is_found_where_there_is_no_pattern() {
        for noise in [NoiseCase::White, NoiseCase::Correlated, NoiseCase::NoisyFrame] {
            assert_eq!(find(&case(noise), 0.02), FixedPattern::default(), "{noise:?}");
        }
        assert_eq!(find(&scene(3.0), 0.04), FixedPattern::default());
    }

    #[test]
    fn hot_pixels_are_found_and_masked() {
        let frames = case(NoiseCase::HotPixels);
        let pattern = find(&frames, 0.02);
        assert!((190..=200).contains(&pattern.hot_pixels.len()), "{}", pattern.hot_pixels.len());
        let mut clean = frames[3].clone();
        pattern.remove_from(&mut clean);
        assert!(deviation(&frames[3]) > 0.021 && (deviation(&clean) / 0.02 - 1.0).abs() < 0.01);
        assert!(clean.data().iter().all(|x| (x - 0.5).abs() < 0.13));
    }

    #[test]
    fn columns_and_rows_are_taken_off() {
        let upright = case(NoiseCase::ColumnStripes);
        let lying: Vec<Plane> = upright.iter().map(turned).collect();
        for (frames, is_upright) in [(upright, true), (lying, false)] {
            let pattern = find(&frames, 0.02);
            assert_eq!((pattern.columns.is_some(), pattern.rows.is_some()), (is_upright, !is_upright));
            let stripes = pattern.columns.as_ref().or(pattern.rows.as_ref()).expect("found");
            assert!((stripes.deviation / 0.02 - 1.0).abs() < 0.15, "{}", stripes.deviation);
            let mut clean = frames[0].clone();
            pattern.remove_from(&mut clean);
            assert!(deviation(&frames[0]) > 0.026 && deviation(&clean) < 0.0215, "{}", deviation(&clean));
        }
    }

    #[test]
    fn a_pattern_is_found_under_a_moving_scene_and_not_on_a_tripod() {
        let mut chance = Stream::new(3, 0);
        let hot: Vec<(usize, usize)> = (0..40).map(|_| (chance.below(320), chance.below(240))).collect();
        let with_hot = |mut frames: Vec<Plane>| {
            frames.iter_mut().for_each(|f| hot.iter().for_each(|&(u, v)| f.row_mut(v)[u] += 0.5));
            frames
        };
        let moving = find(&with_hot(scene(3.0)), 0.04);
        assert!((36..=42).contains(&moving.hot_pixels.len()), "{}", moving.hot_pixels.len());
        assert_eq!(moving.inseparable, 0);
        // One scene with new noise in each frame: the pattern may be a part of the scene.
        let picture = scene(3.0).swap_remove(0);
        let still = (0..10)
            .map(|t| {
                let mut noise = Stream::new(4, t);
                Plane::from_fn(320, 240, |u, v| picture.at(u, v) + 0.01 * noise.normal() as f32)
            })
            .collect();
        let still = find(&with_hot(still), 0.01);
        assert!(still.hot_pixels.is_empty() && still.inseparable >= 30, "{still:?}");
    }
}
