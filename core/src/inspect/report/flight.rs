//! Many bursts on one page: those that need somebody first, with the reasons, and a row for each.

use super::page::{HEADING, Page, Part, TEXT, TITLE};
use crate::dataset::{ColmapReport, Joined, PairReport};
use crate::detect::{Searched, search};
use crate::detector::{Method, SearchParams, find_slopes};
use crate::export::{Cell, FLIGHT_COLUMNS, Table};
use crate::inspect::slopes::{AdviceSubject, SlopeJudgement, judgement};
use crate::inspect::words::{capitalised, counted, number, some_of};
use crate::plane::statistics::upper_median as median;
use crate::{burst::Burst, error::Result, matching::Refusal, monitor::Monitor};
use serde::Serialize;
use std::cmp::Reverse;

/// Health of a burst, as a search shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BurstHealth {
    /// Number of frames.
    pub frames: usize,
    /// Size of a frame (columns, rows).
    pub size: (usize, usize),
    /// Noise of a frame, fraction of full scale.
    pub frame_noise: f32,
    /// Judgement of the slopes; `None` for a method without slopes and for a single frame.
    pub slopes_judged: Option<SlopeJudgement>,
    /// Number of features.
    pub features: usize,
    /// Median of the features' motions, pixels per frame; `None` without features, and where none is judged.
    pub motion: Option<f32>,
    /// Evenness of the frames' times: `even`, or a clause.
    pub times: String,
}

impl BurstHealth {
    /// Searches `burst` with `params`, and judges its slopes.
    ///
    /// # Errors
    /// As [`search`].
    pub fn of(burst: &Burst, params: &SearchParams, monitor: &Monitor) -> Result<Self> {
        let Searched { detection, params, finding, .. } = search(burst, params, monitor)?;
        // Given slopes are compared with those that the frames show.
        let shown = match finding {
            None if params.method == Method::Buff => Some(find_slopes(burst, &params, None, &monitor.silent())?),
            found => found,
        };
        let slopes_judged = judgement(&detection, &params, shown.as_ref(), burst, &monitor.silent())?;
        let motions = detection.features.iter().filter(|_| slopes_judged.is_some()).map(|feature| feature.motion().0);
        Ok(Self {
            frames: burst.len(),
            size: burst.size(),
            frame_noise: detection.frame_noise,
            motion: median(motions.map(|slope| slope.u.hypot(slope.v)).collect()),
            slopes_judged,
            features: detection.features.len(),
            times: if burst.positions.is_even() { "even".to_owned() } else { burst.positions.unevenness() },
        })
    }
}

/// A burst of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct FlightRow {
    /// Name of the burst.
    pub name: String,
    /// Command that opens it.
    pub open: String,
    /// Its health, or the reason why there is none.
    pub health: Result<BurstHealth, String>,
    /// Number of its verified pairs; `None` where its pairs are not known.
    pub verified_pairs: Option<usize>,
}

/// Largest number of bursts that are named before the table.
const WORST: usize = 5;
/// Largest number of pairs on the page.
const WEAKEST: usize = 20;
/// Part of the median number of features that is few, and multiple of the median noise that is much: chosen, not tuned.
const FEW: f32 = 0.25;
const NOISY: f32 = 2.0;

/// Bursts that need somebody, the worst first, at most five, each with the reason: one that failed, a fault of the
/// slopes, few features beside the others, no verified pair, slopes that cannot be judged, much noise beside the
/// others, or more slopes than needed.
pub fn worst_bursts(rows: &[FlightRow]) -> Vec<(&FlightRow, String)> {
    let known =
        |of: fn(&BurstHealth) -> f32| median(rows.iter().filter_map(|row| row.health.as_ref().ok().map(of)).collect());
    let features = known(|health| health.features as f32).unwrap_or(0.0);
    let noise = known(|health| health.frame_noise).unwrap_or(0.0);
    // The first fault of a burst is told, and its place in the list is its rank.
    let faults = |row: &FlightRow| -> [Option<String>; 7] {
        let health = row.health.as_ref().ok();
        let judged = health.and_then(|health| health.slopes_judged.as_ref());
        let advised = |is_cost: bool| {
            let advice = judged?.advice.as_ref().filter(|advice| (advice.subject == AdviceSubject::Cost) == is_cost)?;
            let options = advice.options();
            let how = if options.is_empty() { options } else { format!(": try {options}") };
            Some(advice.sentence.clone() + &how)
        };
        let few = health.filter(|health| (health.features as f32) < FEW * features).map(|health| health.features);
        let much = health.map(|health| health.frame_noise).filter(|found| *found > NOISY * noise);
        [
            row.health.as_ref().err().cloned(),
            advised(false),
            few.map(|n| format!("{}, and {} in the median of all", counted(n, "feature"), number(features, 0))),
            (row.verified_pairs == Some(0)).then(|| "no verified pair with another burst".to_owned()),
            judged.filter(|judged| judged.holds().is_none()).map(|judged| judged.sentence.clone()),
            much.map(|found| format!("noise of {found:.5} of full scale, and {noise:.5} in the median of all")),
            // Slopes that are more than needed cost time alone.
            advised(true),
        ]
    };
    let ranked = rows.iter().filter_map(|row| {
        let (rank, why) = faults(row).into_iter().enumerate().find_map(|(rank, why)| Some((rank, why?)))?;
        Some((rank, row.health.as_ref().map_or(0, |health| health.features), row, why))
    });
    let mut worst: Vec<_> = ranked.collect();
    worst.sort_by_key(|(rank, features, ..)| (*rank, *features));
    worst.into_iter().take(WORST).map(|(.., row, why)| (row, why)).collect()
}

/// The bursts as a table, in their order.
pub fn flight_table(rows: &[FlightRow]) -> Table {
    let text = |text: Option<&str>| text.map_or(Cell::Missing, Cell::from);
    let row = |row: &FlightRow| {
        let health = row.health.as_ref().ok();
        let judged = health.and_then(|health| health.slopes_judged.as_ref());
        let fit = judged.map(|judged| judged.holds().map_or("unknown", |holds| if holds { "yes" } else { "no" }));
        let count = |of: fn(&BurstHealth) -> usize| Cell::of(health.map(|health| of(health) as f64), 0);
        let single = |value: Option<f32>, digits| value.map_or(Cell::Missing, |value| Cell::single(value, digits));
        vec![
            text(Some(&row.name)),
            count(|health| health.frames),
            count(|health| health.size.0),
            count(|health| health.size.1),
            single(health.map(|health| health.frame_noise), 5),
            text(fit),
            text(judged.map(|judged| &*judged.sentence)),
            count(|health| health.features),
            single(health.and_then(|health| health.motion), 2),
            text(health.map(|health| &*health.times)),
            text(row.health.as_ref().err().map(String::as_str)),
            Cell::of(row.verified_pairs.map(|pairs| pairs as f64), 0),
        ]
    };
    Table::new("Bursts", FLIGHT_COLUMNS, rows.iter().map(row).collect())
}

/// Lines on the images that verified pairs join, and on the number of refused pairs with their reasons.
pub fn joined_text(joined: &Joined) -> String {
    let Joined { parts, alone, refused_by_motions, refused_by_pictures, refused_by_tracks } = joined;
    let mut text = String::new();
    if let Some((largest, others)) = parts.split_first() {
        let all = alone.len() + parts.iter().map(Vec::len).sum::<usize>();
        let of = if largest.len() == all { "all ".to_owned() } else { format!("{} of ", largest.len()) };
        text += &format!("verified pairs join {of}{all} images");
        others.iter().for_each(|part| text += &format!(", and apart from them {} others", part.len()));
        text += &if alone.is_empty() { String::new() } else { format!("; none is of {}", some_of(alone)) };
        text += "\n";
    }
    let refused = [refused_by_motions, refused_by_pictures, refused_by_tracks].into_iter().zip(Refusal::ALL);
    for (pairs, why) in refused.filter(|(pairs, _)| **pairs > 0) {
        text += &format!("{} refused: {}\n", counted(*pairs, "pair"), why.words());
    }
    text
}

fn tell_pairs(page: &mut Page, rows: &[FlightRow], report: &ColmapReport) {
    let Joined { parts, .. } = &report.joined;
    let mut text = joined_text(&report.joined) + if parts.is_empty() { "no pair is verified\n" } else { "" };
    let absent = rows.iter().filter(|row| row.verified_pairs.is_none()).map(|row| &*row.name).collect::<Vec<_>>();
    let apart = parts.iter().skip(1).map(|part| ("joined apart", part.join(", ")));
    for (what, names) in apart.chain([("not in the folder of the pairs", absent.join(", "))]) {
        text += &if names.is_empty() { names } else { format!("{what}: {names}\n") };
    }
    page.line(HEADING, "Pairs");
    page.items(text.lines().map(|line| (capitalised(line), String::new())));
    let mut weakest: Vec<&PairReport> = report.pairs.iter().collect();
    weakest.sort_by_key(|pair| (pair.counts.inliers, Reverse(pair.counts.putative)));
    let some = if weakest.len() > WEAKEST { format!("; the {WEAKEST} weakest") } else { String::new() };
    page.line(TEXT, format!("{} with a match{some}, the fewest inliers first.", counted(weakest.len(), "pair")));
    let row = |PairReport { ids, counts, .. }: &PairReport| {
        let [a, b] = ids.map(|id| report.burst(id).to_owned());
        let [putative, inliers] = [counts.putative, counts.inliers.unwrap_or(0)].map(|count| count.to_string());
        [a, b, putative, inliers, counts.refused.map_or("", Refusal::words).to_owned()]
    };
    let heads = ["burst a", "burst b", "putative matches", "inliers", "refused"];
    page.table(heads, weakest.into_iter().take(WEAKEST).map(row));
}

/// The bursts on a page, those first that need somebody, and what joins the images of `pairs`.
pub fn flight_page(rows: &[FlightRow], pairs: Option<&ColmapReport>) -> Page {
    let mut page = Page::default();
    let health = || rows.iter().filter_map(|row| row.health.as_ref().ok());
    let judged = health().filter_map(|health| health.slopes_judged.as_ref());
    let fit = judged.filter(|judged| judged.holds() == Some(true)).count();
    let [bursts, searched] = [rows.len(), health().count()].map(|count| counted(count, "burst"));
    let features = counted(health().map(|health| health.features).sum(), "feature");
    page.line(TITLE, bursts);
    page.line(TEXT, format!("{features} in {searched}; the slopes fit in {fit}."));
    page.line(HEADING, "To look at first");
    let worst = worst_bursts(rows);
    if worst.is_empty() {
        page.line(TEXT, "None stands out.");
    }
    let told = |row: &FlightRow, why: &str| format!("{}: {}", row.name, capitalised(why));
    page.0.extend(worst.iter().map(|(row, why)| Part::Item(told(row, why), row.open.clone())));
    page.line(HEADING, "All bursts");
    page.line(TEXT, "Noise is of full scale, motion the features' median in px/frame.");
    // The last column is of pairs alone.
    let columns = FLIGHT_COLUMNS.split(',').count() - usize::from(pairs.is_none());
    let (heads, table) = (FLIGHT_COLUMNS.split(',').take(columns), flight_table(rows));
    page.table(heads, table.shown().map(|cells| cells.into_iter().take(columns)));
    if let Some(pairs) = pairs {
        tell_pairs(&mut page, rows, pairs);
    }
    page
}
