//! Fig. 2: features tracked through a burst, frame by frame, and the straight lines that approximate their motion.
//!
//! Each frame, in good light, is searched by itself: the burst search would assume the uniform motion in question.

use super::{FigureSize, Made, MakeFigure, Panel, record::Pieces};
use crate::evaluate::statistics::quantiles;
use crate::synth::{Light, Motion, Trajectory, TrajectoryParams};
use burstscope_core::dataset::{DetectedBurst, match_bursts};
use burstscope_core::detector::{Detection, DetectorParams, FrameRange, Method};
use burstscope_core::export::sheet::{Anchor, Colour, Sheet};
use burstscope_core::matching::{Geometry, MatchParams};
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::plane::{Plane, display::Display};
use burstscope_core::{burst::Burst, detect::detect, error::Result, export::FigureStroke};

const WIDTH: f64 = 960.0;
const GAP: f64 = 14.0;
/// Okabe and Ito's yellow, visible on grey.
const TRACK: Colour = [0xf0, 0xe4, 0x42];
const FITTED: Colour = [0x56, 0xb4, 0xe9];
/// Maximum number of tracks drawn, evenly over the picture.
const MAX_DRAWN: usize = 150;

#[derive(Debug)]
pub(super) struct ApparentMotion {
    ways: [TrajectoryParams; 2],
    burst: usize,
    /// Largest step of a feature from one frame to the next, as a multiple of the largest apparent motion.
    reach: f64,
    detector: DetectorParams,
    matching: MatchParams,
}

impl ApparentMotion {
    pub fn new(size: FigureSize) -> Self {
        let ((width, height), light) = (size.pick((480, 360), (240, 180)), Light::Electrons(8000.0));
        let way = |motion| TrajectoryParams { width, height, bursts: 4, motion, light, ..TrajectoryParams::default() };
        Self {
            ways: [way(Motion::TwoD), way(Motion::OneD)],
            burst: 1,
            reach: 1.5,
            // With one orientation a keypoint belongs to one track.
            detector: DetectorParams { method: Method::Sift, max_orientations: 1, ..DetectorParams::default() },
            matching: MatchParams { geometry: Geometry::None, ..MatchParams::default() },
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Track {
    places: Vec<[f64; 2]>,
    /// Position (u, v) at mid-burst and slope of the best-fitting uniform motion.
    place: [f64; 2],
    slope: [f64; 2],
    /// Root mean square distance of the positions from that motion, pixels.
    deviation_px: f64,
}

impl Track {
    fn of(places: Vec<[f64; 2]>) -> Self {
        let n = places.len() as f64;
        let t0 = (n - 1.0) / 2.0;
        let times = || (0..places.len()).map(|t| t as f64 - t0);
        // Least squares over times that are symmetric about 0: place and slope do not depend on each other.
        let spread: f64 = times().map(|t| t * t).sum();
        let mean = |axis: usize| places.iter().map(|p| p[axis]).sum::<f64>() / n;
        let rate = |axis: usize| times().zip(&places).map(|(t, p)| t * p[axis]).sum::<f64>() / spread;
        let (place, slope) = ([mean(0), mean(1)], [rate(0), rate(1)]);
        let off = times()
            .zip(&places)
            .map(|(t, p)| (0..2).map(|axis| (p[axis] - place[axis] - t * slope[axis]).powi(2)).sum::<f64>());
        let deviation_px = (off.sum::<f64>() / n).sqrt();
        Self { places, place, slope, deviation_px }
    }

    fn ends(&self) -> [[f64; 2]; 2] {
        let half = (self.places.len() as f64 - 1.0) / 2.0;
        [-half, half].map(|t| [0, 1].map(|axis| self.place[axis] + t * self.slope[axis]))
    }
}

impl ApparentMotion {
    /// Tracks of features that are found in every frame and linked from each to the next.
    fn tracks(&self, burst: &Burst, max_step: f64, monitor: &Monitor) -> Result<Vec<Track>> {
        let found: Vec<Detection> = (0..burst.len())
            .map(|t| {
                let frames = Some(FrameRange { start: t, end: t + 1 });
                detect(burst, &DetectorParams { frames, ..self.detector.clone() }, monitor)
            })
            .collect::<Result<_, _>>()?;
        let place = |t: usize, index: usize| {
            let feature = &found[t].features[index];
            [f64::from(feature.u), f64::from(feature.v)]
        };
        let mut chains: Vec<Vec<usize>> = (0..found[0].features.len()).map(|index| vec![index]).collect();
        for t in 1..burst.len() {
            let of = |t: usize| DetectedBurst { burst, params: &self.detector, detection: &found[t] };
            let linked = match_bursts([of(t - 1), of(t)], &self.matching, monitor)?;
            let mut next = vec![None; found[t - 1].features.len()];
            // Descriptors alone also link features from far apart, which no motion of the scene does.
            for m in &linked.matches {
                let (from, to) = (place(t - 1, m.a), place(t, m.b));
                if (from[0] - to[0]).hypot(from[1] - to[1]) <= max_step {
                    next[m.a] = Some(m.b);
                }
            }
            chains.retain_mut(|chain| {
                let linked = next[chain[t - 1]];
                chain.extend(linked);
                linked.is_some()
            });
        }
        let track =
            |chain: Vec<usize>| Track::of(chain.into_iter().enumerate().map(|(t, index)| place(t, index)).collect());
        Ok(chains.into_iter().map(track).collect())
    }
}

impl MakeFigure for ApparentMotion {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let silent = monitor.silent();
        let mut sheet = Sheet::new(WIDTH, "Apparent motion");
        let mut csv = String::from("motion,track,frame,u,v,line_u,line_v,slope_u,slope_v,deviation_px\n");
        let half = (WIDTH - 3.0 * GAP) / 2.0;
        let mut end: f64 = 0.0;
        for (column, way) in self.ways.iter().enumerate() {
            monitor.report(Stage::Synth, 0.5 * column as f32);
            let burst = Trajectory::new(way, &silent)?.burst(self.burst, &silent)?;
            monitor.report(Stage::Evaluate, 0.5 * column as f32 + 0.25);
            // √2, because the largest motion may act on both axes at once.
            let tracks = self.tracks(&burst, self.reach * way.max_slope * 2f64.sqrt(), &silent)?;
            let (word, name) = match way.motion {
                Motion::TwoD => ("2d", "forward: in all directions (2D)"),
                Motion::OneD => ("1d", "sideways: parallel (1D)"),
            };
            write_csv(&mut csv, word, &tracks);
            let at = (GAP + (half + GAP) * column as f64, 34.0);
            let middle: &Plane = &burst.frames[burst.len() / 2];
            let panel = draw(&mut sheet, at, half, middle, &tracks, name);
            end = end.max(panel.area.bottom());
            let [median, most] = quantiles(tracks.iter().map(|track| track.deviation_px), [0.5, 0.95]);
            let (count, frames) = (tracks.len(), burst.len());
            let text = format!(
                "{count} features followed through {frames} frames; off a straight line at constant speed: median {median:.2} px, 95 % below {most:.2} px"
            );
            sheet.paragraph((at.0, panel.area.bottom() + 20.0), 12.0, half, &text);
        }
        let key = "yellow: where each frame by itself shows it; blue: the uniform motion that fits, with its direction";
        sheet.text((GAP, end + 62.0), 12.0, Anchor::Start, key);
        Ok(Made { svg: sheet.finish(end + 74.0).svg(), csv, notes: Vec::new() })
    }
}

fn write_csv(csv: &mut String, motion: &str, tracks: &[Track]) {
    for (index, track) in tracks.iter().enumerate() {
        let t0 = (track.places.len() as f64 - 1.0) / 2.0;
        for (t, [u, v]) in track.places.iter().enumerate() {
            let line = [0, 1].map(|axis| track.place[axis] + (t as f64 - t0) * track.slope[axis]);
            *csv += &format!(
                "{motion},{index},{t},{u:.3},{v:.3},{:.3},{:.3},{:.4},{:.4},{:.4}\n",
                line[0], line[1], track.slope[0], track.slope[1], track.deviation_px
            );
        }
    }
}

fn draw(sheet: &mut Sheet, at: (f64, f64), width: f64, frame: &Plane, tracks: &[Track], title: &str) -> Panel {
    // Dimmed, so that lines stand out.
    let dim = Display { max: 1.8, ..Display::default() };
    let panel = Panel::draw(sheet, at, width, frame, &dim, title);
    let step = tracks.len().div_ceil(MAX_DRAWN).max(1);
    sheet.clipped(panel.area, |sheet| {
        for track in tracks.iter().step_by(step) {
            let [from, to] = track.ends().map(|place| panel.at(place));
            sheet.line(from, to, FigureStroke { opacity: 0.75, ..FigureStroke::new(FITTED, 3.5) });
            let (du, dv) = (to.0 - from.0, to.1 - from.1);
            let length = du.hypot(dv);
            // A shorter line has no room for barbs.
            if length > 4.0 {
                let (x, y) = (du / length, dv / length);
                for side in [-1.0, 1.0] {
                    let barb = (to.0 - 6.0 * x + 3.5 * side * y, to.1 - 6.0 * y - 3.5 * side * x);
                    sheet.line(to, barb, FigureStroke::new(FITTED, 2.0));
                }
            }
            let points = track.places.iter().map(|&place| Some(panel.at(place)));
            sheet.polyline(points, FigureStroke::new(TRACK, 1.3));
        }
    });
    panel
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_fitted_and_what_is_off_it_is_measured() {
        let straight = Track::of((0..5).map(|t| [3.0 + 2.0 * f64::from(t), 10.0 - f64::from(t)]).collect());
        assert_eq!((straight.place, straight.slope), ([7.0, 8.0], [2.0, -1.0]));
        assert!(straight.deviation_px < 1e-12);
        assert_eq!(straight.ends(), [[3.0, 10.0], [11.0, 6.0]]);
        // A bump of 1 at the middle of five: the mean takes a fifth of it.
        let bent = Track::of([0.0, 0.0, 1.0, 0.0, 0.0].map(|v| [0.0, v]).to_vec());
        assert!((bent.deviation_px - (0.8f64 / 5.0).sqrt()).abs() < 1e-12, "{}", bent.deviation_px);
    }
}
