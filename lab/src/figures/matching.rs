//! Fig. 1: two neighbouring bursts of a dark scene, matched by SIFT on one frame and by burst features.

use super::{FigureSize, Made, MakeFigure, Panel, RIGHT, WRONG, record::Pieces};
use crate::evaluate::curves::lettered;
use burstscope_core::dataset::{DetectedBurst, match_bursts};
use burstscope_core::detector::{Detection, DetectorParams, Method, SlopeGrid};
use burstscope_core::export::sheet::{Anchor, Sheet};
use burstscope_core::matching::MatchParams;
use burstscope_core::monitor::{Monitor, Stage};
use burstscope_core::plane::{Plane, display::Display};
use burstscope_core::{burst::Burst, detect::detect, error::Result, export::FigureStroke};

use crate::synth::trajectory::world::nearest_point;
use crate::synth::{Light, Trajectory, TrajectoryParams};

/// Largest distance of a right match from the true position of its scene point, pixels.
const RIGHT_PX: f64 = 4.0;
const WIDTH: f64 = 960.0;
const GAP: f64 = 12.0;

#[derive(Debug)]
pub(super) struct MatchingInTheDark {
    way: TrajectoryParams,
    /// Indices of the two bursts of the trajectory.
    bursts: [usize; 2],
    slopes: SlopeGrid,
    matching: MatchParams,
}

impl MatchingInTheDark {
    pub fn new(size: FigureSize) -> Self {
        let (width, height) = size.pick((480, 360), (240, 180));
        let light = Light::Snr(size.pick(0.35, 0.6));
        let way = TrajectoryParams { width, height, bursts: 8, light, ..TrajectoryParams::default() };
        // As the paper matches.
        let matching = MatchParams { predict: false, align: false, ..MatchParams::default() };
        Self { way, bursts: [3, 4], slopes: SlopeGrid::line(-3.0..=3.0, 13), matching }
    }
}

struct Matched {
    label: &'static str,
    word: &'static str,
    keypoints: [usize; 2],
    /// For each match: positions in the two views, distance of the second from its true position (infinite where the
    /// scene has none), and whether it is an inlier of the common geometry.
    matches: Vec<([f64; 2], [f64; 2], f64, bool)>,
}

impl Matched {
    fn right(&self) -> usize {
        self.matches.iter().filter(|m| m.2 <= RIGHT_PX).count()
    }
}

/// The true position, in another view, of the scene point seen at a position of one view.
fn true_place(way: &Trajectory, [from, to]: [usize; 2], [u, v]: [f64; 2]) -> Option<[f64; 2]> {
    let point = nearest_point(&way.planes, &way.lens, &way.cameras[from].world_from_camera, u, v)?;
    way.cameras[to].pixel_of(&way.lens, &point, 0.0)
}

impl MakeFigure for MatchingInTheDark {
    fn make(&self, _: &Pieces, monitor: &Monitor) -> Result<Made> {
        let silent = monitor.silent();
        let way = Trajectory::new(&self.way, &silent)?;
        monitor.report(Stage::Synth, 0.3);
        let bursts = [way.burst(self.bursts[0], &silent)?, way.burst(self.bursts[1], &silent)?];
        let gold = way.gold(self.bursts[0], &silent)?;
        monitor.report(Stage::Evaluate, 0.6);
        let sift = DetectorParams { method: Method::Sift, ..DetectorParams::default() };
        let buff = DetectorParams { slopes: self.slopes, ..DetectorParams::default() };
        let (frame, of_frame) = self.matched(("SIFT, one frame", "sift"), &way, &bursts, &sift, &silent)?;
        monitor.report(Stage::Evaluate, 0.8);
        let (buff, of_burst) = self.matched(("BuFF", "buff"), &way, &bursts, &buff, &silent)?;
        monitor.report(Stage::Evaluate, 1.0);
        let svg = draw(&bursts, &gold, [&frame, &buff], [&of_frame, &of_burst], way.snr);
        Ok(Made { svg, csv: csv(&[frame, buff]), notes: Vec::new() })
    }
}

impl MatchingInTheDark {
    fn matched(
        &self,
        (label, word): (&'static str, &'static str),
        way: &Trajectory,
        bursts: &[Burst; 2],
        params: &DetectorParams,
        monitor: &Monitor,
    ) -> Result<(Matched, Detection)> {
        let a = detect(&bursts[0], params, monitor)?;
        let b = detect(&bursts[1], params, monitor)?;
        let of = |index: usize, detection| DetectedBurst { burst: &bursts[index], params, detection };
        let result = match_bursts([of(0, &a), of(1, &b)], &self.matching, monitor)?;
        let place = |detection: &Detection, index: usize| {
            let feature = &detection.features[index];
            [f64::from(feature.u), f64::from(feature.v)]
        };
        // Judged by the scene itself: wrong matches may agree on a geometry too.
        let matches = result.matches.iter().enumerate().map(|(index, m)| {
            let (from, to) = (place(&a, m.a), place(&b, m.b));
            let truth = true_place(way, self.bursts, from);
            let error = truth.map_or(f64::INFINITY, |truth| (truth[0] - to[0]).hypot(truth[1] - to[1]));
            (from, to, error, result.verification.as_ref().is_some_and(|v| v.inlier[index]))
        });
        let keypoints = [a.features.len(), b.features.len()];
        Ok((Matched { label, word, keypoints, matches: matches.collect() }, a))
    }
}

fn csv(all: &[Matched]) -> String {
    let mut csv = String::from("method,a_u,a_v,b_u,b_v,error_px,right,inlier\n");
    for matched in all {
        for ([au, av], [bu, bv], error, inlier) in &matched.matches {
            let error_px = if error.is_finite() { format!("{error:.3}") } else { String::new() };
            let (word, right, inlier) = (matched.word, u8::from(*error <= RIGHT_PX), u8::from(*inlier));
            csv += &format!("{word},{au:.3},{av:.3},{bu:.3},{bv:.3},{error_px},{right},{inlier}\n");
        }
    }
    csv
}

fn draw(bursts: &[Burst; 2], gold: &Plane, all: [&Matched; 2], found: [&Detection; 2], snr: f64) -> String {
    let mut sheet = Sheet::new(WIDTH, "Matching in the dark");
    let middle = |burst: &Burst| burst.frames[burst.len() / 2].clone();
    let frames = [middle(&bursts[0]), middle(&bursts[1])];
    let third = (WIDTH - 4.0 * GAP) / 3.0;
    let x = |column: usize| GAP + (third + GAP) * column as f64;
    let top = 30.0;
    let title = lettered(0, "the scene in good light");
    let seen = Panel::draw(&mut sheet, (x(0), top), third, gold, &Display::default(), &title);
    let title = lettered(1, &format!("one frame in the dark (SNR {snr:.2}, stretched)"));
    Panel::draw(&mut sheet, (x(1), top), third, &frames[0], &Display::stretched(&frames[0]), &title);
    let title = lettered(2, "SIFT (orange), BuFF (blue): 150 strongest");
    let both = Panel::draw(&mut sheet, (x(2), top), third, gold, &Display { max: 1.6, ..Display::default() }, &title);
    sheet.clipped(both.area, |sheet| {
        for (detection, colour) in found.into_iter().zip([WRONG, RIGHT]) {
            detection.features.iter().take(150).for_each(|feature| both.feature(sheet, feature, colour));
        }
    });
    let mut y = seen.area.bottom() + 40.0;
    for (index, matched) in all.into_iter().enumerate() {
        let half = (WIDTH - 3.0 * GAP) / 2.0;
        let (right, putative, [a, b]) = (matched.right(), matched.matches.len(), matched.keypoints);
        let counts = format!("{a} and {b} features, {putative} putative matches, {right} of them right");
        let title = lettered(3 + index, &format!("{}: {counts}", matched.label));
        let panels = [0, 1].map(|side| {
            let at = (GAP + (half + GAP) * side as f64, y);
            let title = if side == 0 { title.as_str() } else { "" };
            // Dimmed, so that lines stand out.
            let Display { min, max, .. } = Display::stretched(&frames[side]);
            let dim = Display::default().with_range(min, max + 0.8 * (max - min));
            Panel::draw(&mut sheet, at, half, &frames[side], &dim, title)
        });
        // Wrong matches first: right matches are drawn over them.
        for is_right in [false, true] {
            let colour = if is_right { RIGHT } else { WRONG };
            for (a, b, _, _) in matched.matches.iter().filter(|m| (m.2 <= RIGHT_PX) == is_right) {
                let (from, to) = (panels[0].at(*a), panels[1].at(*b));
                sheet.line(from, to, FigureStroke { opacity: 0.8, ..FigureStroke::new(colour, 0.9) });
                sheet.circle(from, 2.0, colour);
                sheet.circle(to, 2.0, colour);
            }
        }
        y = panels[0].area.bottom() + 34.0;
    }
    let text = format!("blue: right (within {RIGHT_PX} px of where the point is truly seen); orange: wrong");
    sheet.text((GAP, y - 12.0), 12.0, Anchor::Start, &text);
    sheet.finish(y + 4.0).svg()
}
