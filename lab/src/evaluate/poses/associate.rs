//! Pairing of the poses of the estimate with those of the truth.
//!
//! - **By name**: both are of the same image. Names are compared as they are; if no two agree, without their folders
//!   and endings.
//! - **By time**: the time stamps are nearest and not too far apart. A sparse model has no times; there the last number
//!   in the image's name is used, such as 23 of `image.0023.png` or 1305031102.175304 of `1305031102.175304.png`.
//! - **By order**: both have the same position in their sequence. For a model that is the image's id, so that images
//!   which were not registered leave gaps.
//!
//! Without a given rule: names if both sides have them, else times if every estimated pose finds one, else the order.

use super::Pose;
use burstscope_core::error::{Error, ErrorKind, Result};
use serde::{Deserialize, Serialize};
use std::{collections::HashMap, path::Path};

/// A rule by which poses are paired.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)] // where a name says it
pub enum Association {
    Name,
    Time,
    Order,
}

impl Association {
    /// The rule as a phrase of a sentence.
    pub fn phrase(self) -> &'static str {
        match self {
            Self::Name => "by name",
            Self::Time => "by time",
            Self::Order => "by order",
        }
    }
}

/// Pairs of poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairing {
    /// Rule that was used.
    pub by: Association,
    /// Indices of poses, (estimate, truth), in the truth's order. No pose is in two pairs.
    pub pairs: Vec<(usize, usize)>,
}

/// Pairs poses by the rule `by`, or the one that fits; never where times differ by more than `max_time_difference`.
///
/// # Errors
/// No pair is found.
pub fn associate(
    estimate: &[Pose],
    truth: &[Pose],
    by: Option<Association>,
    max_time_difference: f64,
) -> Result<Pairing> {
    let by_time = || pairs_by_time(estimate, truth, max_time_difference);
    // Sparse models, and files that name images, have no time stamps.
    let named = |poses: &[Pose]| poses.iter().all(|p| p.time.is_none());
    let (by, mut pairs) = match by {
        Some(Association::Name) => (Association::Name, pairs_by_name(estimate, truth)),
        Some(Association::Time) => (Association::Time, by_time()),
        Some(Association::Order) => (Association::Order, pairs_by_order(estimate, truth)),
        None if named(estimate) && named(truth) => (Association::Name, pairs_by_name(estimate, truth)),
        None => match by_time() {
            pairs if pairs.len() == estimate.len() => (Association::Time, pairs),
            pairs => order_or_times(estimate, truth, pairs)?,
        },
    };
    // Hash maps give their pairs in any order, and the same input has to give the same report.
    pairs.sort_unstable_by_key(|&(e, t)| (truth[t].order, e));
    if pairs.is_empty() {
        let first = |poses: &[Pose]| poses.first().map_or("none".to_owned(), |p| format!("'{}'", p.label));
        let problem = format!(
            "none belong together; the estimate has {} poses, the first of {}, the truth {}, the first of {}; \
             choose another rule with --associate name|time|order",
            estimate.len(),
            first(estimate),
            truth.len(),
            first(truth)
        );
        return Err(unpaired(by.phrase(), &problem));
    }
    Ok(Pairing { by, pairs })
}

/// Error for poses that the rule `by` does not pair; `problem` says what would help.
fn unpaired(by: &str, problem: &str) -> Error {
    let problem = format!("the poses of estimate and truth cannot be paired {by}: {problem}");
    Error::new(ErrorKind::Failed, problem, "")
}

/// Pairs by time where both sides have times; otherwise by order, if every pose of the estimate finds a partner.
fn order_or_times(
    estimate: &[Pose],
    truth: &[Pose],
    times: Vec<(usize, usize)>,
) -> Result<(Association, Vec<(usize, usize)>)> {
    let timed = |poses: &[Pose]| poses.iter().all(|p| p.time.is_some());
    // Two recordings with times of their own need not overlap entirely, so that unpaired poses are no failure.
    if timed(estimate) && timed(truth) {
        return Ok((Association::Time, times));
    }
    let pairs = pairs_by_order(estimate, truth);
    if pairs.len() == estimate.len() {
        return Ok((Association::Order, pairs));
    }
    let problem = format!(
        "times fit for {} and places in the sequence for {} of the estimate's {} poses; choose a rule with --associate time|order, \
         or write the truth with the images' names in place of times",
        times.len(),
        pairs.len(),
        estimate.len()
    );
    Err(unpaired("by time or order", &problem))
}

fn pairs_by_name(estimate: &[Pose], truth: &[Pose]) -> Vec<(usize, usize)> {
    let exact = pairs_by_key(estimate, truth, |label| label.to_owned());
    if exact.is_empty() { pairs_by_key(estimate, truth, stem) } else { exact }
}

fn stem(label: &str) -> String {
    // Both kinds of slashes, because a model may come from another system.
    let name = label.rsplit(['/', '\\']).next().unwrap_or(label);
    Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Pairs of poses with the same key; keys that occur twice on one side are left out.
fn pairs_by_key(estimate: &[Pose], truth: &[Pose], key: impl Fn(&str) -> String) -> Vec<(usize, usize)> {
    let unique = |poses: &[Pose]| {
        let mut places: HashMap<String, Option<usize>> = HashMap::new();
        for (index, pose) in poses.iter().enumerate() {
            places.entry(key(&pose.label)).and_modify(|place| *place = None).or_insert(Some(index));
        }
        places
    };
    let truths = unique(truth);
    let found = |(key, e): (String, Option<usize>)| Some((e?, (*truths.get(&key)?)?));
    unique(estimate).into_iter().filter_map(found).collect()
}

fn pairs_by_order(estimate: &[Pose], truth: &[Pose]) -> Vec<(usize, usize)> {
    let places: HashMap<u32, usize> = truth.iter().enumerate().map(|(index, pose)| (pose.order, index)).collect();
    estimate.iter().enumerate().filter_map(|(e, pose)| Some((e, *places.get(&pose.order)?))).collect()
}

/// Pairs of nearest times. Where several poses are nearest to the same one, the nearest of them is paired.
fn pairs_by_time(estimate: &[Pose], truth: &[Pose], max_time_difference: f64) -> Vec<(usize, usize)> {
    let times = |poses: &[Pose]| {
        let timed = poses.iter().enumerate().filter_map(|(index, pose)| Some((time_of(pose)?, index)));
        let mut times: Vec<(f64, usize)> = timed.collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        times
    };
    let truths = times(truth);
    let mut nearest: HashMap<usize, (f64, usize)> = HashMap::new();
    for (time, e) in times(estimate) {
        // In sorted times the nearest is the last one before or the first one after.
        let after = truths.partition_point(|&(t, _)| t < time);
        let around = truths[after.saturating_sub(1)..truths.len().min(after + 1)].iter();
        let Some((difference, t)) =
            around.map(|&(t, index)| ((t - time).abs(), index)).min_by(|a, b| a.0.total_cmp(&b.0))
        else {
            continue;
        };
        if difference <= max_time_difference && nearest.get(&t).is_none_or(|&(other, _)| difference < other) {
            nearest.insert(t, (difference, e));
        }
    }
    nearest.into_iter().map(|(t, (_, e))| (e, t)).collect()
}

/// The pose's time stamp, or the last number in the image's name.
fn time_of(pose: &Pose) -> Option<f64> {
    pose.time.or_else(|| last_number(&stem(&pose.label)))
}

fn last_number(text: &str) -> Option<f64> {
    let digits_from = |text: &str| text.len() - text.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let end = text.rfind(|c: char| c.is_ascii_digit())? + 1;
    let text = &text[..end];
    let mut start = end - digits_from(text);
    // Digits before a point belong to the number: 12.5 is one, but the point of `image.0023` is not a decimal one.
    if let Some(before) = text[..start].strip_suffix('.') {
        start = if digits_from(before) > 0 { before.len() - digits_from(before) } else { start };
    }
    text[start..].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;
    use proptest::prelude::*;

    fn pose(label: &str, order: u32, time: Option<f64>) -> Pose {
        Pose { label: label.to_owned(), order, time, world_from_camera: Isometry3::identity() }
    }

    fn named(names: &[&str]) -> Vec<Pose> {
        names.iter().enumerate().map(|(k, name)| pose(name, k as u32, None)).collect()
    }

    fn timed(times: &[f64]) -> Vec<Pose> {
        times.iter().enumerate().map(|(k, &time)| pose(&time.to_string(), k as u32, Some(time))).collect()
    }

    fn paired(estimate: &[Pose], truth: &[Pose]) -> Pairing {
        associate(estimate, truth, None, 0.02).expect("paired")
    }

    #[test]
    fn images_of_one_name_belong_together() {
        let pairing = paired(&named(&["c.png", "a.png", "x.png"]), &named(&["a.png", "b.png", "c.png"]));
        assert_eq!(pairing, Pairing { by: Association::Name, pairs: vec![(1, 0), (0, 2)] });
        // Folders and endings count only as long as some whole names agree.
        let pairing = paired(&named(&["gold/a.png", "gold/b.png"]), &named(&["b.tiff", "a.tiff"]));
        assert_eq!(pairing.pairs, [(1, 0), (0, 1)]);
        let pairing = paired(&named(&["a.png", "b.png"]), &named(&["a.png", "b.tiff"]));
        assert_eq!(pairing.pairs, [(0, 0)]);
        // A name that could be either of two is left out.
        let pairing = paired(&named(&["a.png", "b.png"]), &named(&["1/a.jpg", "2/a.jpg", "b.jpg"]));
        assert_eq!(pairing.pairs, [(1, 2)]);
        let error = associate(&named(&["a.png"]), &named(&["b.png"]), None, 0.02).expect_err("none").to_string();
        assert!(error.contains("by name") && error.contains("'a.png'") && error.contains("--associate"), "{error}");
    }

    #[test]
    fn nearest_times_belong_together_once() {
        let pairing = paired(&timed(&[0.011, 1.0, 1.004, 2.5]), &timed(&[0.0, 1.003, 3.0]));
        assert_eq!(pairing, Pairing { by: Association::Time, pairs: vec![(0, 0), (2, 1)] });
        // The numbers in the names of a model's images are times.
        let model = [pose("i/image.0023.png", 2, None), pose("i/image.0030.png", 3, None)];
        let pairing = paired(&model, &timed(&[16.0, 23.0, 30.0]));
        assert_eq!(pairing, Pairing { by: Association::Time, pairs: vec![(0, 1), (1, 2)] });
    }

    #[test]
    fn places_count_where_times_say_nothing() {
        let model = [pose("a.png", 0, None), pose("c.png", 2, None)];
        let truth = timed(&[100.5, 101.5, 102.5]);
        assert_eq!(paired(&model, &truth), Pairing { by: Association::Order, pairs: vec![(0, 0), (1, 2)] });
        // An image beyond the truth shows that the order was not meant.
        let model = [pose("a.png", 0, None), pose("z.png", 7, None)];
        let error = associate(&model, &truth, None, 0.02).expect_err("unclear").to_string();
        assert!(error.contains("0 and places in the sequence for 1 of the estimate's 2"), "{error}");
        assert_eq!(associate(&model, &truth, Some(Association::Order), 0.02).expect("forced").pairs, [(0, 0)]);
    }

    #[test]
    fn the_last_number_of_a_name_is_read() {
        let cases = [
            ("image.0023", Some(23.0)),
            ("1305031102.175304", Some(1305031102.175304)),
            ("frame_007_left", Some(7.0)),
            ("v2.5", Some(2.5)),
            ("7", Some(7.0)),
            (".5", Some(5.0)),
            ("left", None),
            ("", None),
        ];
        for (name, number) in cases {
            assert_eq!(last_number(name), number, "{name}");
        }
    }

    proptest! {
        #[test]
        fn no_pose_is_in_two_pairs(
            estimate in prop::collection::vec((0u32..6, prop::option::of(0.0f64..3.0)), 0..8),
            truth in prop::collection::vec((0u32..6, prop::option::of(0.0f64..3.0)), 0..8),
            by in prop::option::of(prop::sample::select(vec![Association::Name, Association::Time])),
        ) {
            let poses = |v: &[(u32, Option<f64>)]| -> Vec<Pose> {
                v.iter().enumerate().map(|(k, &(name, time))| pose(&format!("é{name}"), k as u32, time)).collect()
            };
            if let Ok(Pairing { pairs, .. }) = associate(&poses(&estimate), &poses(&truth), by, 0.5) {
                for (k, a) in pairs.iter().enumerate() {
                    prop_assert!(a.0 < estimate.len() && a.1 < truth.len());
                    prop_assert!(pairs[..k].iter().all(|b| a.0 != b.0 && a.1 > b.1));
                }
            }
        }
    }
}
