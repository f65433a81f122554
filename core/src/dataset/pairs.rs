//! The matching of pairs of bursts, with the features of a few bursts in memory at a time, however many there are.

use super::{BurstFeatures, FeatureStore};
use crate::burst::{Burst, BurstFiles, supported_extensions};
use crate::detector::{Descriptor, Detection, DetectorParams, Feature};
use crate::error::{Error, Result};
use crate::export::{ColmapKeypoint, MatchRow, safe_file_name};
use crate::files::{MAX_TABLE_BYTES, read_text};
use crate::matching::{
    Blob, Match, MatchParams, MatchResult, MatchSide, PairSelection, Pictures, Unaligned, match_features, match_pair,
};
use crate::monitor::{Monitor, Stage};
use crate::{detect::prepare, matching::aligned::Seen};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// Maximum number of pairs that are matched before their results are passed on.
const PAIRS_AT_ONCE: usize = 16;
/// Number of first bursts that stay in memory while the second bursts of their pairs are loaded one after the other.
const FIRST_AT_ONCE: usize = 8;
/// Maximum number of bursts whose features are in memory.
const BURSTS_AT_ONCE: usize = FIRST_AT_ONCE + PAIRS_AT_ONCE / FIRST_AT_ONCE;

/// Features of a burst as matching needs them.
#[derive(Debug, Clone, PartialEq)]
pub struct BurstSide {
    /// Position of each feature (u, v), pixels.
    pub places: Vec<[f64; 2]>,
    /// Descriptor of each feature.
    pub descriptors: Vec<Descriptor>,
    /// Shape and motion of each feature.
    pub blobs: Vec<Blob>,
    /// Pictures of their places, where matches are to be measured.
    pub pictures: Option<Pictures>,
}

impl BurstSide {
    /// The features of these keypoints, their descriptors, shapes and motions.
    pub fn new(keypoints: &[ColmapKeypoint], descriptors: Vec<Descriptor>, blobs: Vec<Blob>) -> Self {
        let places = keypoints.iter().map(ColmapKeypoint::pos_image).collect();
        Self { places, descriptors, blobs, pictures: None }
    }

    /// These features with the pictures of their places, in the frames of `burst` in which `params` search.
    pub fn with_pictures(self, burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Self> {
        let (burst, params) = prepare(burst, params, monitor)?;
        Ok(Self { pictures: Some(Pictures::of(&burst, &params, &self.places, &self.blobs)), ..self })
    }

    /// These features as [`match_features`] takes them.
    pub fn side(&self) -> MatchSide<'_> {
        let Self { places, descriptors, blobs, pictures } = self;
        MatchSide { places, descriptors, blobs, pictures: pictures.as_ref() }
    }
}

impl From<BurstFeatures> for BurstSide {
    fn from(burst: BurstFeatures) -> Self {
        Self::new(&burst.keypoints, burst.descriptors, burst.blobs)
    }
}

/// Part of the image of `burst` that is seen, in the frames in which `params` search.
pub(super) fn seen_part(burst: &Burst, params: &DetectorParams, monitor: &Monitor) -> Result<Seen> {
    let (burst, params) = prepare(burst, params, monitor)?;
    Ok(Seen::in_burst(&burst, &params))
}

/// A burst with the result of a search.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)] // where a name says it
pub struct DetectedBurst<'a> {
    pub burst: &'a Burst,
    pub params: &'a DetectorParams,
    pub detection: &'a Detection,
}

impl From<&Detection> for BurstSide {
    /// Places are rounded as in the files of a dataset, so that both give the same bits.
    fn from(Detection { features, descriptors, .. }: &Detection) -> Self {
        let keypoints: Vec<ColmapKeypoint> = features.iter().map(ColmapKeypoint::from).collect();
        Self::new(&keypoints, descriptors.clone(), features.iter().map(Blob::from).collect())
    }
}

/// Matches the features of two bursts, verifies the matches, and aligns them, by the frames, where `params` ask for it.
///
/// ```
/// use burstscope_core::dataset::{DetectedBurst, match_bursts};
/// use burstscope_core::{DetectorParams, Monitor, SlopeGrid, detect, matching::MatchParams, synth};
/// let params = DetectorParams { slopes: SlopeGrid::line(-2.5..=1.5, 9), ..DetectorParams::default() };
/// let monitor = Monitor::default();
/// let bursts = [synth::demo_burst(), synth::later_demo_burst()];
/// let found = [detect(&bursts[0], &params, &monitor)?, detect(&bursts[1], &params, &monitor)?];
/// let sides = [0, 1].map(|k| DetectedBurst { burst: &bursts[k], params: &params, detection: &found[k] });
/// let counts = match_bursts(sides, &MatchParams::default(), &monitor)?.counts;
/// assert!(counts.inliers.is_some_and(|inliers| inliers > 100), "{counts:?}");
/// # Ok::<(), burstscope_core::Error>(())
/// ```
pub fn match_bursts(bursts: [DetectedBurst<'_>; 2], params: &MatchParams, monitor: &Monitor) -> Result<MatchResult> {
    let [mut a, mut b] = bursts.map(|of| BurstSide::from(of.detection));
    if params.aligns() {
        a = a.with_pictures(bursts[0].burst, bursts[0].params, monitor)?;
        b = b.with_pictures(bursts[1].burst, bursts[1].params, monitor)?;
    }
    match_pair([a.side(), b.side()], params, monitor)
}

/// Rows of the table of the matches of `a` and `b`.
pub fn match_rows(a: &[Feature], b: &[Feature], result: &MatchResult) -> Vec<MatchRow> {
    let verified = result.verification.as_ref();
    let model = verified.and_then(|verified| verified.model.as_ref());
    let row = |(index, m): (usize, &Match)| {
        let places = [&a[m.a], &b[m.b]].map(|feature| [feature.u, feature.v]);
        let aligned = result.alignment.as_ref().map(|alignment| {
            let [of_a, of_b] = &alignment.places;
            [of_a[m.a], of_b[m.b]].map(|place| place.map(|x| x as f32))
        });
        let [of_a, of_b] = places.map(|place| place.map(f64::from));
        // Without a model no match has an error, and the column stays empty.
        let as_found = model.map(|model| model.error_px(of_a, of_b) as f32);
        let error_px = verified.filter(|_| model.is_some()).map(|verified| verified.error_px[index]);
        MatchRow {
            features: [m.a, m.b],
            places,
            aligned: aligned.unwrap_or(places),
            distance: m.distance,
            ratio: m.ratio,
            predicted: m.predicted.map(|predicted| (predicted.among, predicted.ratio_among_all)),
            error_px: [error_px, as_found].map(|error| error.filter(|error| error.is_finite())),
            inlier: verified.map(|verified| verified.inlier[index]),
            measured: result.alignment.as_ref().and_then(|alignment| alignment.shift_in_b(index)),
        }
    };
    result.matches.iter().enumerate().map(row).collect()
}

/// A pair of bursts and its matches.
#[derive(Debug, Clone, Copy)]
pub struct MatchedPair<'a> {
    /// Indices of the bursts.
    pub indices: (usize, usize),
    /// Their features.
    pub sides: [&'a BurstSide; 2],
    /// Matches of the first burst's features with those of the second, before an alignment.
    pub found: &'a Unaligned,
}

impl MatchedPair<'_> {
    /// The result after an alignment of this pair alone, as [`match_bursts`] gives it.
    pub fn aligned(&self, params: &MatchParams, monitor: &Monitor) -> Result<MatchResult> {
        self.found.clone().aligned(self.sides.map(BurstSide::side), params, monitor)
    }
}

/// Source of the bursts of a dataset for [`match_pairs`], by their indices.
pub trait PairSource<E> {
    /// Features of a burst; `None` where there are none.
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>, E>;

    /// A burst with the parameters of its search; needed only where matches are aligned.
    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams), E>;
}

/// Bursts whose features are in the files of a store; those that are not finished are left out.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)] // where a name says it
pub struct KeptBursts<'a> {
    pub store: &'a FeatureStore,
    pub bursts: &'a [BurstFiles],
    pub monitor: &'a Monitor,
}

impl KeptBursts<'_> {
    /// The pairs of a `selection`. In [`PairSelection::Near`] bursts that are not finished have no votes.
    ///
    /// # Errors
    /// Cancellation.
    pub fn pairs(&self, selection: &PairSelection) -> Result<Vec<(usize, usize)>> {
        let silent = self.monitor.silent();
        let kept = |index: usize| self.store.kept(&self.bursts[index], &silent);
        let descriptors = |index| Ok(kept(index).map_or_else(|_| Vec::new(), |kept| kept.descriptors));
        selection.pairs_by(self.bursts.len(), descriptors, &silent)
    }
}

impl<E: From<Error>> PairSource<E> for KeptBursts<'_> {
    fn features(&mut self, index: usize) -> Result<Option<BurstSide>, E> {
        let kept = self.bursts.get(index).and_then(|burst| self.store.kept(burst, self.monitor).ok());
        Ok(kept.map(BurstSide::from))
    }

    fn burst(&mut self, index: usize) -> Result<(Burst, DetectorParams), E> {
        Ok(self.store.open_burst(&self.bursts[index], &self.monitor.silent())?)
    }
}

/// Matches the bursts of each of `pairs`, in an order in which `source` is rarely asked for one again; `on` receives
/// each result. Pairs with a burst that has no features are left out. Returns their number.
///
/// # Errors
/// Parameters that make no sense, and errors of `source` and `on`.
pub fn match_pairs<E: From<Error>>(
    pairs: &[(usize, usize)],
    params: &MatchParams,
    source: &mut dyn PairSource<E>,
    on: &mut dyn FnMut(MatchedPair<'_>) -> Result<(), E>,
    monitor: &Monitor,
) -> Result<usize, E> {
    let mut on = |(indices, sides, found): MadePair<'_, Unaligned>| on(MatchedPair { indices, sides, found: &found });
    let matched = |_, sides: [MatchSide<'_>; 2]| match_features(sides, params, &monitor.silent());
    for_pairs(pairs, params, source, (&matched, &mut on), monitor)
}

type MadePair<'a, T> = ((usize, usize), [&'a BurstSide; 2], T);

type Make<'a, T> = &'a (dyn Fn((usize, usize), [MatchSide<'_>; 2]) -> Result<T> + Sync);

/// Takes a pair, in their order.
type On<'a, T, E> = &'a mut dyn FnMut(MadePair<'_, T>) -> Result<(), E>;

/// Passes pairs on as [`match_pairs`] does, with what `make`, on one of several threads, makes of the features of each,
/// a few pairs at a time. Of `params` only the alignment counts, which needs pictures.
pub(super) fn for_pairs<E: From<Error>, T: Send>(
    pairs: &[(usize, usize)],
    params: &MatchParams,
    source: &mut dyn PairSource<E>,
    (make, on): (Make<'_, T>, On<'_, T, E>),
    monitor: &Monitor,
) -> Result<usize, E> {
    params.validate()?;
    let mut ordered = pairs.to_vec();
    // A block of first bursts stays while second bursts pass, so each is loaded about once a block.
    ordered.sort_by_key(|&(a, b)| (a / FIRST_AT_ONCE, b, a));
    let mut loaded: BTreeMap<usize, BurstSide> = BTreeMap::new();
    let mut missing = BTreeSet::new();
    let (mut done, mut left_out) = (0, 0);
    while done < ordered.len() {
        monitor.report(Stage::Match, done as f32 / ordered.len() as f32);
        let (count, needed) = next_together(&ordered[done..]);
        // Only features that the next pairs need stay in memory.
        loaded.retain(|index, _| needed.contains(index));
        for &index in &needed {
            monitor.check().map_err(Error::from)?;
            if loaded.contains_key(&index) || missing.contains(&index) {
                continue;
            }
            let Some(mut side) = source.features(index)? else {
                missing.insert(index);
                continue;
            };
            if params.aligns() {
                let (burst, of_search) = source.burst(index)?;
                side = side.with_pictures(&burst, &of_search, &monitor.silent())?;
            }
            loaded.insert(index, side);
        }
        let there = |&(a, b): &(usize, usize)| Some(((a, b), [loaded.get(&a)?, loaded.get(&b)?]));
        let some: Vec<_> = ordered[done..done + count].iter().filter_map(there).collect();
        left_out += count - some.len();
        let of_pair = |&(indices, sides): &(_, [&BurstSide; 2])| make(indices, sides.map(BurstSide::side));
        let made: Vec<T> = some.par_iter().map(of_pair).collect::<Result<_>>()?;
        for ((indices, sides), made) in some.into_iter().zip(made) {
            on((indices, sides, made))?;
        }
        done += count;
    }
    monitor.report(Stage::Match, 1.0);
    Ok(left_out)
}

fn next_together(pairs: &[(usize, usize)]) -> (usize, BTreeSet<usize>) {
    let mut needed = BTreeSet::new();
    for (count, &(a, b)) in pairs.iter().take(PAIRS_AT_ONCE).enumerate() {
        let more = [a, b].iter().filter(|index| !needed.contains(*index)).count();
        if count > 0 && needed.len() + more > BURSTS_AT_ONCE {
            return (count, needed);
        }
        needed.extend([a, b]);
    }
    (pairs.len().min(PAIRS_AT_ONCE), needed)
}

/// Reads the pairs that the list at `path` names, two images a line as in lists of hloc and COLMAP. Returns indices in
/// `bursts`, the earlier first, each pair once, in order. A name may have the extension of a picture, and spaces; blank
/// lines and those that begin with `#` are skipped.
///
/// # Errors
/// A list that cannot be read or names no pair; a line that does not name two of the bursts, with its number.
pub fn read_pairs(path: &Path, bursts: &[BurstFiles]) -> Result<Vec<(usize, usize)>> {
    let text = read_text(path, MAX_TABLE_BYTES).map_err(|error| Error::unread_file(path, error))?;
    // As they are, and as their pictures are called.
    let forms = |of: &BurstFiles| [safe_file_name(&of.name), of.name.clone()];
    let known = bursts.iter().enumerate().flat_map(|(index, burst)| forms(burst).map(|name| (name, index)));
    let known: HashMap<String, usize> = known.collect();
    let pictures = supported_extensions();
    let is_picture = |end: &str| pictures.iter().any(|of| of.eq_ignore_ascii_case(end));
    let bare = |word: &str| word.rsplit_once('.').filter(|(_, end)| is_picture(end)).and_then(|of| known.get(of.0));
    let named = |word: &str| known.get(word).or_else(|| bare(word)).copied();
    let mut pairs = BTreeSet::new();
    let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim).enumerate();
    for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let at = |(at, _)| Some((named(line[..at].trim_end())?, named(line[at..].trim_start())?));
        let spaces = || line.match_indices(char::is_whitespace).filter(|_| line.len() < 4096); // No two names are longer.
        let (a, b) = spaces().find_map(at).filter(|(a, b)| a != b).ok_or_else(|| {
            let unknown = line.split_whitespace().find(|word| named(word).is_none()).unwrap_or(line);
            let right = bursts.iter().take(2).map(|burst| burst.name.as_str()).collect::<Vec<_>>().join(" ");
            let problem = format!("this does not name two bursts ({unknown:.80}); right is such as: {right}");
            Error::in_line(path, number + 1, &problem)
        })?;
        pairs.insert((a.min(b), a.max(b)));
    }
    if pairs.is_empty() {
        Err(Error::unread_file(path, "it names no pair; write the names of two bursts in a line"))
    } else {
        Ok(pairs.into_iter().collect())
    }
}
