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
