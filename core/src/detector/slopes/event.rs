//! Events that happen to the frames of a burst between the camera and the file, and the sentences that report them.

use super::{MotionWarning, MotionWarningKind};
use crate::plane::Plane;
use serde::Serialize;

/// Least number of frames for which an event is reported: any three frames lie on a line at some times.
pub(super) const MIN_FRAMES: usize = 4;
/// Largest number of frames examined for events, whose number grows with its square.
pub(super) const MAX_FRAMES: usize = 64;
/// Largest number of frames of which every order is tried; for more, one frame is moved or two are exchanged.
pub(super) const MAX_SCRAMBLED: usize = 7;
/// Largest number of frames missing at one place.
pub(super) const MAX_MISSING: usize = 3;
/// Distances of a frame from its even time, frame intervals.
const LATE: [f64; 4] = [-0.75, -0.5, 0.5, 0.75];
/// Largest difference between the times of events that are alike, frame intervals.
const LIKE: f64 = 0.25;

/// Event that may have happened to frames that were even once.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Event {
    Nothing,
    Order(Vec<usize>),
    /// `count` frames are missing after frame `after`.
    Missing {
        after: usize,
        count: usize,
    },
    /// Frame `frame` was taken `by` frame intervals late.
    Late {
        frame: usize,
        by: f64,
    },
    /// Times that follow no pattern, frame intervals.
    Free(Vec<f64>),
}

/// Frames and times in which the motion is uniform.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UniformTimes {
    /// Frames in their order, counted from the first one used. Copies of others are left out.
    pub frames: Vec<usize>,
    /// Time of each of `frames` from the first one on, frame intervals.
    pub times: Vec<f64>,
}

impl Event {
    /// Time of each of `frames` frames, frame intervals.
    pub fn times(&self, frames: usize) -> Vec<f64> {
        let mut times: Vec<f64> = (0..frames).map(|t| t as f64).collect();
        match self {
            Self::Nothing => {}
            Self::Order(order) => order.iter().zip(0..).for_each(|(frame, at)| times[*frame] = f64::from(at)),
            Self::Missing { after, count } => times[after + 1..].iter_mut().for_each(|time| *time += *count as f64),
            Self::Late { frame, by } => times[*frame] += by,
            Self::Free(free) => times.clone_from(free),
        }
        times
    }

    pub fn is_order(&self) -> bool {
        matches!(self, Self::Order(_))
    }

    /// Whether both events give `frames` frames nearly the same times. A gap after the first frame (or before the last)
    /// is like that frame taken early (or late): either correction mends the burst, and the likelier is reported.
    pub fn is_like(&self, other: &Self, frames: usize) -> bool {
        let apart = self.times(frames).into_iter().zip(other.times(frames)).map(|(a, b)| a - b);
        let (least, most) = apart.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        most - least <= LIKE
    }

    pub fn all(frames: usize) -> Vec<Self> {
        let orders = if frames <= MAX_SCRAMBLED { permutations(frames) } else { single_moves(frames) };
        let orders = orders.into_iter().map(Self::Order);
        let missing =
            (1..frames).flat_map(|t| (1..=MAX_MISSING).map(move |count| Self::Missing { after: t - 1, count }));
        let late = (0..frames).flat_map(|frame| LATE.map(|by| Self::Late { frame, by }));
        orders.chain(missing).chain(late).collect()
    }

    /// Warning of the event, with its frames `kept` numbered among all; `None` for no event and for free times.
    pub fn warning_of(&self, kept: &[usize]) -> Option<MotionWarning> {
        let (kind, frames, number, text) = match self {
            Self::Nothing | Self::Free(_) => return None,
            Self::Order(order) => {
                let order: Vec<usize> = order.iter().map(|t| kept[*t]).collect();
                let wrong: Vec<usize> = kept.iter().zip(&order).filter(|(a, b)| a != b).map(|(t, _)| *t).collect();
                (MotionWarningKind::OutOfOrder, wrong.clone(), wrong.len() as f32, order_text(&wrong, &order))
            }
            Self::Missing { after, count } => {
                let are = if *count == 1 { "frame is" } else { "frames are" };
                let [after, next] = [kept[*after], kept[after + 1]];
                let text = format!(
                    "{count} {are} missing between frames {after} and {next}, counted from 0: the picture moves there by as many \
                     more steps"
                );
                (MotionWarningKind::MissingFrames, vec![after], *count as f32, text)
            }
            Self::Late { frame, by } => {
                let (frame, which) = (kept[*frame], if *by > 0.0 { "late" } else { "early" });
                let text =
                    format!("frame {frame}, counted from 0, was taken about {} frame intervals {which}", by.abs());
                (MotionWarningKind::Late, vec![frame], *by as f32, text)
            }
        };
        Some(MotionWarning { kind, frames, number, text })
    }
}

impl UniformTimes {
    pub(super) fn of(event: &Event, kept: &[usize]) -> Self {
        let mut taken: Vec<(f64, usize)> = event.times(kept.len()).into_iter().zip(kept.iter().copied()).collect();
        taken.sort_by(|a, b| a.0.total_cmp(&b.0));
        let first = taken.first().map_or(0.0, |first| first.0);
        Self {
            frames: taken.iter().map(|taken| taken.1).collect(),
            times: taken.iter().map(|taken| taken.0 - first).collect(),
        }
    }
}

fn order_text(wrong: &[usize], order: &[usize]) -> String {
    let list = |frames: &[usize]| frames.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    match wrong {
        [a, b] => {
            format!("frames {a} and {b}, counted from 0, are exchanged: the other way round the motion is uniform")
        }
        _ => format!(
            "frames {} are out of order: the motion is uniform in the order {}, counted from 0",
            list(wrong),
            list(order)
        ),
    }
}

/// Orders in which one of `frames` frames is moved, or two are exchanged, each once.
fn single_moves(frames: usize) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..frames).collect();
    let moved = |from: usize, to: usize| {
        let mut order = all.clone();
        let frame = order.remove(from);
        order.insert(to, frame);
        order
    };
    let exchanged = |a: usize, b: usize| {
        let mut order = all.clone();
        order.swap(a, b);
        order
    };
    let pairs = || all.iter().flat_map(|a| all.iter().map(move |b| (*a, *b)));
    // One place back equals moving the neighbour one place forward: one of both is tried.
    let moves = pairs().filter(|(from, to)| from != to && to + 1 != *from).map(|(from, to)| moved(from, to));
    moves.chain(pairs().filter(|(a, b)| a + 1 < *b).map(|(a, b)| exchanged(a, b))).collect()
}

/// All orders of `frames` frames but the given one; of an order and its reverse, the one in which more frames ascend.
fn permutations(frames: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..frames {
        let longer = |start: &Vec<usize>| {
            let rest = (0..frames).filter(|frame| !start.contains(frame));
            rest.map(|frame| [&start[..], &[frame]].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    // Reversed frames have the same correlations at the opposite slope, so that one way stands for both.
    let is_own_way = |order: &Vec<usize>| {
        let follow = order.windows(2).filter(|two| two[0] < two[1]).count();
        let against = frames - 1 - follow;
        follow > against || (follow == against && order.first() < order.last())
    };
    all.retain(|order| is_own_way(order) && !order.is_sorted());
    all
}

/// Frames that are copies of the frame before, bit by bit, counted from 0; none where all frames are the same picture.
pub(super) fn copies(frames: &[&Plane]) -> Vec<usize> {
    let copies: Vec<usize> = (1..frames.len()).filter(|t| frames[*t].data() == frames[*t - 1].data()).collect();
    if frames.len() < copies.len() + 2 { Vec::new() } else { copies }
}

pub(super) fn copies_warning(copies: Vec<usize>) -> Option<MotionWarning> {
    let text = match copies[..] {
        [] => return None,
        [one] => format!("frame {one}, counted from 0, is a copy of the frame before, bit by bit"),
        _ => {
            let list: Vec<String> = copies.iter().map(usize::to_string).collect();
            format!("frames {}, counted from 0, are copies of the frames before, bit by bit", list.join(", "))
        }
    };
    Some(MotionWarning { kind: MotionWarningKind::Doubled, number: copies.len() as f32, frames: copies, text })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_told_with_their_frames() {
        let told = |event: Event| {
            event.warning_of(&[0, 1, 2, 3, 4, 5]).map(|w| (w.kind, w.frames, w.number, w.text)).expect("told")
        };
        let (kind, frames, number, text) = told(Event::Order(vec![0, 1, 2, 4, 3, 5]));
        assert_eq!((kind, frames, number), (MotionWarningKind::OutOfOrder, vec![3, 4], 2.0));
        assert!(text.starts_with("frames 3 and 4, counted from 0, are exchanged"), "{text}");
        let (_, frames, _, text) = told(Event::Order(vec![0, 2, 3, 1, 4]));
        assert!(frames == [1, 2, 3] && text.contains("in the order 0, 2, 3, 1, 4"), "{text}");
        let (kind, frames, number, text) = told(Event::Missing { after: 2, count: 1 });
        assert_eq!((kind, frames, number), (MotionWarningKind::MissingFrames, vec![2], 1.0));
        assert!(text.starts_with("1 frame is missing between frames 2 and 3"), "{text}");
        let (kind, frames, number, text) = told(Event::Late { frame: 3, by: -0.5 });
        assert_eq!((kind, frames, number), (MotionWarningKind::Late, vec![3], -0.5));
        assert!(text.ends_with("0.5 frame intervals early"), "{text}");
        assert_eq!(Event::Nothing.warning_of(&[0, 1]), None);
    }

    #[test]
    fn every_event_is_tried_once_and_has_times_of_its_own() {
        for frames in [4, 5, 7, 9, 12] {
            let all = Event::all(frames);
            let mut times: Vec<Vec<i64>> =
                all.iter().map(|event| event.times(frames).iter().map(|time| (4.0 * time) as i64).collect()).collect();
            times.sort();
            times.dedup();
            assert_eq!(times.len(), all.len(), "{frames}");
            assert!(!times.contains(&(0..frames as i64).map(|t| 4 * t).collect()), "{frames}");
        }
        // Of 24 orders of four frames half are the others the other way round, and one is their own.
        assert_eq!(Event::all(4).iter().filter(|event| event.is_order()).count(), 11);
    }
}
