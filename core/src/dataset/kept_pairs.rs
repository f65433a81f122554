//! Pairs of an export that are matched, kept so that another run solves for the places of all images alone.
//!
//! `records/pairs/A.png/B.png.pair` holds what the database and the joint solution need of a pair ([`PairFound`]): the
//! mark and a line of JSON with what it was made from (program, options of matching, cameras, checksums of features and
//! frames), then 32-bit words, little end first, and the CRC-32 of all before. A file that is not whole, or was made
//! from anything else, counts as none. Bursts in memory have no files, and their pairs stay there too.

use super::{features::FeatureStore, kept::pairs_folder};
use crate::error::{Error, Result};
use crate::export::{MadeFrom, write_whole};
use crate::files::{MAX_TABLE_BYTES, lock::FolderLock, read_bytes};
use crate::matching::{Camera, MatchParams, Refusal, TwoViewModel, Unaligned, align::Measured, aligned::Inlier};
use nalgebra::Matrix3;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::{collections::BTreeMap, io::Write};

/// First line of a file, with the number of its form.
const PAIR_MARK: &[u8] = b"Burstscope pair 2\n";
/// Words of a matrix of nine `f64`, and of an inlier: its features, its rank, and seven numbers of its measurement.
const MATRIX_WORDS: usize = 18;
const INLIER_WORDS: usize = 10;

/// Parts of a matched pair that a database and the joint solution need.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PairFound {
    pub matches: Vec<[u32; 2]>,
    /// With what the pictures say of each, where it is known.
    pub inliers: Vec<(Inlier, Option<Measured>)>,
    /// Matches beside the inliers, which other pairs must not contradict.
    pub beside: Vec<(Inlier, Option<Measured>)>,
    pub model: Option<TwoViewModel>,
    /// Before the joint solution only motions can refuse a pair.
    pub refused: Option<Refusal>,
}

impl PairFound {
    pub fn of(Unaligned { result, measured, .. }: &Unaligned, beside: Vec<(Inlier, Measured)>) -> Self {
        let verified = result.verification.as_ref();
        let agreed = |index: &usize| verified.is_some_and(|verified| verified.inlier[*index]);
        let inlier = |index: usize| (Inlier::from(&result.matches[index]), measured[index]);
        Self {
            matches: result.matches.iter().map(|m| [m.a as u32, m.b as u32]).collect(),
            inliers: (0..result.matches.len()).filter(agreed).map(inlier).collect(),
            beside: beside.into_iter().map(|(inlier, measured)| (inlier, Some(measured))).collect(),
            model: verified.and_then(|verified| verified.model.clone()),
            refused: result.counts.refused,
        }
    }

    fn words(&self) -> Vec<u32> {
        let number = |x: &f64| [x.to_bits() as u32, (x.to_bits() >> 32) as u32];
        let matrix = self.model.as_ref().map(TwoViewModel::matrix);
        let matrix: Vec<u32> = matrix.iter().flat_map(|matrix| matrix.iter()).flat_map(number).collect();
        let [matches, inliers] = [self.matches.len(), self.inliers.len()].map(|count| count as u32);
        let head = [u32::from(self.refused.is_some()), u32::from(self.model.is_some()), matches, inliers];
        let inlier = |(Inlier { a, b, rank }, measured): &(Inlier, Option<Measured>)| {
            let measured = measured.map_or([f32::NAN; 7], |Measured { shift_px: [u, v], jacobian, correlation }| {
                let [[uu, uv], [vu, vv]] = jacobian;
                // They were computed as `f32`.
                [u, v, uu, uv, vu, vv, correlation].map(|x| x as f32)
            });
            [&[*a, *b, rank.to_bits()][..], &measured.map(f32::to_bits)].concat()
        };
        let inliers = self.inliers.iter().chain(&self.beside).flat_map(inlier);
        head.into_iter().chain(matrix).chain(self.matches.as_flattened().iter().copied()).chain(inliers).collect()
    }

    /// `None` for words of another form, or of features that do not exist among so many.
    fn from_words(words: &[u32], matching: &MatchParams, features: [usize; 2]) -> Option<Self> {
        let (&[refused, model, matches, inliers], rest) = words.split_first_chunk()?;
        let (matrix, rest) = rest.split_at_checked(if model == 1 { MATRIX_WORDS } else { 0 })?;
        let (matches, rest) = rest.split_at_checked((matches as usize).checked_mul(2)?)?;
        let number = |[low, high]: &[u32; 2]| f64::from_bits(u64::from(*low) | (u64::from(*high) << 32));
        let matrix = Matrix3::from_iterator(matrix.as_chunks().0.iter().map(number).chain([f64::NAN; 9]));
        let found = if model == 1 { Some(TwoViewModel::of(matrix, matching)?) } else { None };
        let inlier = |&[a, b, rank, ref measured @ ..]: &[u32; INLIER_WORDS]| {
            let numbers @ [u, v, uu, uv, vu, vv, correlation] = measured.map(|bits| f64::from(f32::from_bits(bits)));
            let measured = Measured { shift_px: [u, v], jacobian: [[uu, uv], [vu, vv]], correlation };
            let is_measured = numbers.iter().all(|x| x.is_finite());
            (Inlier { a, b, rank: f32::from_bits(rank) }, is_measured.then_some(measured))
        };
        let (all, rest) = rest.as_chunks();
        let (own, beside) = all.split_at_checked(inliers as usize)?;
        let found = Self {
            matches: matches.as_chunks().0.to_vec(),
            inliers: own.iter().map(inlier).collect(),
            beside: beside.iter().map(inlier).collect(),
            model: found,
            refused: (refused == 1).then_some(Refusal::Motions),
        };
        let exists = |[a, b]: [u32; 2]| (a as usize) < features[0] && (b as usize) < features[1];
        let inliers = found.inliers.iter().chain(&found.beside).map(|(m, _)| [m.a, m.b]);
        let mut all = found.matches.iter().copied().chain(inliers);
        (rest.is_empty() && all.all(exists)).then_some(found)
    }
}

/// Reason why the pair in the file at `path`, with so many `matches`, is not verified; `None` where the file has none.
pub(super) fn why_refused(path: &Path, matches: usize) -> Option<Refusal> {
    let bytes = read_bytes(path, MAX_TABLE_BYTES).ok()?;
    let words = bytes.strip_prefix(PAIR_MARK)?.splitn(2, |byte| *byte == b'\n').nth(1)?;
    match words.as_chunks().0.first_chunk()?.map(u32::from_le_bytes) {
        [_, _, count] if count as usize != matches => None,
        [1, ..] => Some(Refusal::Motions),
        // It had a geometry before the places were aligned.
        [_, model, _] => (model == 1).then_some(Refusal::Pictures),
    }
}

pub(super) struct PairedImage {
    pub name: String,
    pub features: usize,
    pub camera: Option<Camera>,
    /// Source of its features: `None` for a burst in memory.
    pub key: Option<Value>,
}

/// The matched pairs of an export, by the indices of their images.
pub(super) struct KeptPairs<'a> {
    store: &'a FeatureStore,
    matching: &'a MatchParams,
    images: &'a [PairedImage],
    in_memory: Mutex<BTreeMap<(usize, usize), PairFound>>,
}

impl<'a> KeptPairs<'a> {
    pub fn of(store: &'a FeatureStore, matching: &'a MatchParams, images: &'a [PairedImage]) -> Self {
        Self { store, matching, images, in_memory: Mutex::default() }
    }

    /// Parameters with which a pair is matched: for its cameras.
    pub fn matching(&self, (a, b): (usize, usize)) -> MatchParams {
        self.matching.with_cameras(self.images[a].camera.as_ref(), self.images[b].camera.as_ref())
    }

    /// The file of a pair, and the bytes with which it begins; `None` for bursts in memory.
    fn file(&self, pair @ (a, b): (usize, usize)) -> Option<(PathBuf, Vec<u8>)> {
        let [a, b] = [&self.images[a], &self.images[b]];
        let (of_a, of_b) = (a.key.as_ref()?, b.key.as_ref()?);
        // Options as text, because a number may look different as a value.
        let matching = serde_json::to_string(&self.matching(pair)).expect("parameters are plain values");
        let made_from = MadeFrom::new(json!({ "matching": matching, "bursts": [of_a, of_b] }));
        let made_from = serde_json::to_vec(&made_from).expect("plain values");
        let path = pairs_folder(&self.store.folder).join(&a.name).join(format!("{}.pair", b.name));
        Some((path, [PAIR_MARK, &made_from, b"\n"].concat()))
    }

    /// Keeps a pair, as soon as it is matched.
    pub fn keep(&self, pair: (usize, usize), found: PairFound) -> Result<()> {
        let Some((path, mut bytes)) = self.file(pair) else {
            self.in_memory.lock().unwrap_or_else(PoisonError::into_inner).insert(pair, found);
            return Ok(());
        };
        bytes.extend(found.words().iter().flat_map(|word| word.to_le_bytes()));
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        // A folder that was removed meanwhile is not made anew.
        self.store.lock.as_ref().map_or(Ok(()), FolderLock::check)?;
        self.store.check_output(&path)?;
        write_whole(&path, |out| out.write_all(&bytes))
    }

    /// Whether the pair was matched before, from the same features and frames with the same options.
    pub fn has(&self, pair: (usize, usize)) -> bool {
        self.file(pair).and_then(|(path, head)| self.read(pair, &path, &head)).is_some()
    }

    /// A kept pair. From memory it is removed.
    pub fn take(&self, pair: (usize, usize)) -> Result<PairFound> {
        let Some((path, head)) = self.file(pair) else {
            let found = self.in_memory.lock().unwrap_or_else(PoisonError::into_inner).remove(&pair);
            return Ok(found.expect("each pair is matched before it is taken, once"));
        };
        let altered = || Error::unread_file(&path, "it was altered or removed while the command ran; run it again");
        self.read(pair, &path, &head).ok_or_else(altered)
    }

    fn read(&self, (a, b): (usize, usize), path: &Path, head: &[u8]) -> Option<PairFound> {
        let bytes = read_bytes(path, MAX_TABLE_BYTES).ok()?;
        let (content, checksum) = bytes.split_last_chunk()?;
        let (words, odd) = content.strip_prefix(head)?.as_chunks();
        let is_whole = odd.is_empty() && crc32fast::hash(content) == u32::from_le_bytes(*checksum);
        let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let features = [a, b].map(|image| self.images[image].features);
        is_whole.then(|| PairFound::from_words(&words, &self.matching((a, b)), features)).flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matching::Geometry;
    use proptest::prelude::*;

    fn params(geometry: Geometry) -> MatchParams {
        MatchParams { geometry, camera: Some(Camera::centred(640, 480, 600.0)), ..MatchParams::default() }
    }

    fn found(matching: &MatchParams) -> PairFound {
        let matrix = Matrix3::new(1.0, 0.1, 3.0, -0.2, 1.1, f64::MIN_POSITIVE, 1e-7, 0.3, 1.0 / 3.0);
        let jacobian = [[1.1f32, -0.3], [0.25, 0.9]].map(|row| row.map(f64::from));
        let measured = Measured { shift_px: [-0.5, f64::from(0.1f32)], jacobian, correlation: 0.75 };
        let inlier = |a, rank, measured| (Inlier { a, b: 2, rank }, measured);
        PairFound {
            matches: vec![[0, 2], [1, 0], [3, 1]],
            inliers: vec![inlier(0, 0.8, Some(measured)), inlier(3, 0.0, None)],
            beside: vec![inlier(1, 2.0, Some(measured))],
            model: TwoViewModel::of(matrix, matching),
            refused: None,
        }
    }

    #[test]
    fn a_pair_survives_its_words_to_the_bit() {
        for geometry in [Geometry::Fundamental, Geometry::Essential, Geometry::Homography] {
            let matching = params(geometry);
            let pair = found(&matching);
            assert!(pair.model.is_some());
            let read = |words: &[u32]| PairFound::from_words(words, &matching, [4, 3]);
            assert_eq!(read(&pair.words()), Some(pair.clone()));
            let none = PairFound {
                model: None,
                inliers: Vec::new(),
                beside: Vec::new(),
                refused: Some(Refusal::Motions),
                ..pair.clone()
            };
            assert_eq!(read(&none.words()), Some(none));
            // Features that do not exist, and words that are missing or too many.
            assert_eq!(PairFound::from_words(&pair.words(), &matching, [3, 3]), None);
            assert_eq!(PairFound::from_words(&pair.words(), &matching, [4, 2]), None);
            assert_eq!(read(&[&pair.words()[..], &[0]].concat()), None);
            for length in [0, 2, 3, 20, pair.words().len() - 1] {
                assert_eq!(read(&pair.words()[..length]), None, "{length}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_words_panic(words in prop::collection::vec(prop_oneof![0..4u32, any::<u32>()], 0..60)) {
            let read = PairFound::from_words(&words, &params(Geometry::Fundamental), [4, 3]);
            prop_assert!(read.is_none_or(|pair| pair.matches.iter().all(|[a, b]| *a < 4 && *b < 3)));
        }
    }
}
