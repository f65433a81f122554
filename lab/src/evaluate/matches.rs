//! Matching between the bursts of a dataset: the columns of the paper's Table 1 that need no reconstruction.
//!
//! Every method finds the features of every burst, with the same parameters and a noise gate of the same rate of false
//! features; the features of chosen pairs of bursts are matched, verified and aligned as usual. As in the paper, an
//! image's matches with all others are added up: each counts for both of its images, and ratios may exceed 1.
//!
//! # The gold standard
//! Where sharp images of the same views are given, SIFT on them is a row of its own, and all rows get a further column:
//! putative matches, at the places where they were found, on the geometry of the *sharp* images' matches. Inliers are
//! counted against a geometry found with the same matches, which favours a method with few matches, because some
//! always agree on some geometry. The further column does not.

use super::methods::{BurstMethod, Searches};
use burstscope_core::burst::Burst;
use burstscope_core::dataset::{BurstSide, MatchedPair, PairSource, match_pairs};
use burstscope_core::detect::{Searched, search};
use burstscope_core::detector::{DetectorParams, SearchParams, SlopeGrid};
use burstscope_core::error::{Error, Result};
use burstscope_core::matching::{
    Geometry, ImageCounts, Match, MatchCounts, MatchParams, MatchResult, PairSelection, TwoViewModel,
};
use burstscope_core::monitor::{Monitor, Stage};
use serde::Serialize;

/// Kind of pictures of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shot {
    /// Burst whose features are compared.
    Burst,
    /// Sharp image; of several the middle one is used.
    Gold,
}

/// Methods to be compared, with the parameters of search and matching.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // where a name says it
pub struct MatchStudy {
    /// The rows, each at most once.
    pub methods: Vec<BurstMethod>,
    pub has_gold: bool,
    pub searches: Searches,
    pub matching: MatchParams,
    pub pairs: PairSelection,
}

/// Features of a burst by one method, with the parameters of their search and the slopes found.
struct FoundInBurst {
    side: BurstSide,
    params: DetectorParams,
    slopes: Option<SlopeGrid>,
}

/// A method's features, and its bursts, opened again where their pictures are needed.
struct Source<'a, F> {
    study: &'a MatchStudy,
    method: BurstMethod,
    found: &'a [FoundInBurst],
    open: &'a mut F,
    monitor: &'a Monitor,
}

impl<E: From<Error>, F: FnMut(usize, Shot) -> Result<Burst, E>> PairSource<E> for Source<'_, F> {
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>, E> {
        Ok(Some(self.found[index].side.clone()))
    }

    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams), E> {
        let (burst, _) = self.study.input(self.method, index, self.open, self.monitor)?;
        Ok((burst, self.found[index].params.clone()))
    }
}

impl MatchStudy {
    fn check(&self, bursts: usize) -> Result<()> {
        self.matching.validate()?;
        if self.methods.is_empty() {
            let remedy = "give one or more, such as sift-merge,buff-1d";
            return Err(Error::param("methods", "none is given", remedy));
        }
        if self.methods.contains(&BurstMethod::Gold) && !self.has_gold {
            let remedy = "give --gold, or --snr to make noisy bursts of sharp ones; or leave it out";
            return Err(Error::param("methods", "the gold standard needs sharp images", remedy));
        }
        if self.matching.geometry == Geometry::None {
            let remedy = "give fundamental, essential or homography";
            return Err(Error::param("geometry", "inliers are those of a geometry", remedy));
        }
        if matches!(self.pairs, PairSelection::Near(_)) {
            let problem = format!("{} is chosen by features, and each method has its own", self.pairs);
            return Err(Error::param("pairs", problem, "give all or sequential:K"));
        }
        if bursts < 2 {
            let remedy = "name a folder of bursts, or cut a long sequence with --burst-length";
            return Err(Error::param("pairs", format!("{bursts} bursts make no pair"), remedy));
        }
        Ok(())
    }

    /// Finds the features of every burst by every method, matches the pairs, and counts. `open` opens the pictures of
    /// burst k; sharp ones are requested only if there are any. One burst is held in memory at a time.
    ///
    /// # Errors
    /// A parameter that makes no sense, an error of `open`, or cancellation.
    pub fn run<E: From<Error>>(
        &self,
        names: &[String],
        mut open: impl FnMut(usize, Shot) -> Result<Burst, E>,
        monitor: &Monitor,
    ) -> Result<MatchReport, E> {
        self.check(names.len())?;
        let pairs = self.pairs.pairs(names.len());
        // Sharp images come first, even without a row of their own: their geometry judges all rows.
        let others = self.methods.iter().copied().filter(|method| *method != BurstMethod::Gold);
        let methods: Vec<BurstMethod> = self.has_gold.then_some(BurstMethod::Gold).into_iter().chain(others).collect();
        let steps = (names.len() + 1) * methods.len();
        let mut done = 0;
        let mut step = || {
            done += 1;
            monitor.report(Stage::Evaluate, done as f32 / steps as f32);
        };
        let silent = monitor.silent();
        let first = open(0, Shot::Burst)?;
        let (frames, size) = (first.len(), first.size());
        // Filled by the row of the sharp images, which comes first.
        let mut judges: Vec<Option<TwoViewModel>> = vec![None; pairs.len()];
        let mut rows: Vec<MatchRow> = Vec::with_capacity(methods.len());
        for &method in &methods {
            let mut found = Vec::with_capacity(names.len());
            // One burst is open at a time.
            for k in 0..names.len() {
                let (burst, params) = self.input(method, k, &mut open, &silent)?;
                let Searched { detection, params, finding, .. } = search(&burst, &params, &silent)?;
                let (side, slopes) = (BurstSide::from(&detection), finding.map(|finding| finding.grid));
                found.push(FoundInBurst { side, params, slopes });
                step();
            }
            let mut counted = vec![None; pairs.len()];
            let mut models = Vec::new();
            let mut on = |pair: MatchedPair<'_>| {
                let result = pair.aligned(&self.matching, &silent)?;
                let index = pairs.binary_search(&pair.indices).expect("it is one of the pairs, which are in order");
                let model = result.verification.as_ref().and_then(|verified| verified.model.clone());
                let judge = if method == BurstMethod::Gold { model.as_ref() } else { judges[index].as_ref() };
                let on_gold_geometry = judge.map(|judge| self.agreeing(&result, pair.sides, judge));
                counted[index] = Some(PairCounts { counts: result.counts, on_gold_geometry });
                models.push((index, model));
                Ok(())
            };
            let mut source = Source { study: self, method, found: &found, open: &mut open, monitor: &silent };
            match_pairs(&pairs, &self.matching, &mut source, &mut on, &silent)?;
            if method == BurstMethod::Gold {
                models.into_iter().for_each(|(index, model)| judges[index] = model);
            }
            step();
            let keypoints: Vec<usize> = found.iter().map(|found| found.side.places.len()).collect();
            let by_pair = counted.into_iter().flatten().collect();
            rows.push(row(method, &keypoints, found.into_iter().map(|found| found.slopes).collect(), &pairs, by_pair));
        }
        // Sharp images that only served as judges leave the table; the other rows take the requested order.
        let place = |row: &MatchRow| self.methods.iter().position(|method| *method == row.method);
        rows.retain(|row| place(row).is_some());
        rows.sort_by_key(place);
        let (bursts, searches, matching) = (names.to_vec(), self.searches.clone(), self.matching.clone());
        Ok(MatchReport { methods: rows, bursts, frames, size, pairs, searches, matching })
    }

    /// The burst that `method` searches of the view `k`, and the parameters with which it is searched.
    fn input<E: From<Error>>(
        &self,
        method: BurstMethod,
        k: usize,
        open: &mut impl FnMut(usize, Shot) -> Result<Burst, E>,
        monitor: &Monitor,
    ) -> Result<(Burst, SearchParams), E> {
        let burst = open(k, Shot::Burst)?;
        if method != BurstMethod::Gold {
            return Ok(self.searches.input(method, &burst, monitor)?);
        }
        let (sharp, mut params) = (open(k, Shot::Gold)?, self.searches.params(method));
        if sharp.len() != burst.len() {
            // The requested frames are those of bursts; a sharp image may be the only one.
            params.frames = None;
        }
        Ok((sharp, params))
    }

    /// The number of putative matches within the error limit of `judge`, as they were found.
    fn agreeing(&self, result: &MatchResult, [a, b]: [&BurstSide; 2], judge: &TwoViewModel) -> usize {
        let max = f64::from(self.matching.max_error_px);
        let agrees = |m: &&Match| judge.error_px(a.places[m.a], b.places[m.b]) <= max;
        result.matches.iter().filter(agrees).count()
    }
}

/// Report of a study of matches.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)] // where a name says it
pub struct MatchReport {
    pub bursts: Vec<String>,
    /// Number of frames of the first burst.
    pub frames: usize,
    /// (columns, rows) of its frames.
    pub size: (usize, usize),
    /// Matched pairs, as indices of bursts.
    pub pairs: Vec<(usize, usize)>,
    #[serde(flatten)]
    pub searches: Searches,
    pub matching: MatchParams,
    pub methods: Vec<MatchRow>,
}

/// Results of one method. Numbers per image are means; an image's matches are those with all images paired with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MatchRow {
    /// The method.
    pub method: BurstMethod,
    /// Statistics, as in the paper's table.
    #[serde(flatten)]
    pub counts: ImageCounts,
    /// Putative matches of an image on the geometry of the sharp images; `None` without these.
    pub on_gold_geometry_per_image: Option<f64>,
    /// Slopes found and searched in each burst, where the method finds them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slopes_found: Option<Vec<SlopeGrid>>,
    /// Counts of each pair, in the report's order.
    pub by_pair: Vec<PairCounts>,
}

/// Counts of one pair by one method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairCounts {
    /// Counts of the match.
    #[serde(flatten)]
    pub counts: MatchCounts,
    /// Number of putative matches on the geometry of the sharp images; `None` where there is none.
    pub on_gold_geometry: Option<usize>,
}

fn row(
    method: BurstMethod,
    keypoints: &[usize],
    slopes_found: Option<Vec<SlopeGrid>>,
    pairs: &[(usize, usize)],
    by_pair: Vec<PairCounts>,
) -> MatchRow {
    let counts: Vec<_> = pairs.iter().zip(&by_pair).map(|(&pair, counted)| (pair, counted.counts)).collect();
    let judged = by_pair.iter().any(|pair| pair.on_gold_geometry.is_some());
    // Each match counts for both images.
    let on_gold = 2 * by_pair.iter().filter_map(|pair| pair.on_gold_geometry).sum::<usize>();
    MatchRow {
        method,
        counts: ImageCounts::of(keypoints, &counts).expect("pairs are matched of images that are there"),
        on_gold_geometry_per_image: judged.then(|| on_gold as f64 / keypoints.len() as f64),
        slopes_found,
        by_pair,
    }
}
