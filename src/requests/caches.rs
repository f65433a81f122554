//! Results of earlier requests that later ones share: pictures, and trails of detections. A trail is all that the
//! search of an open burst left behind, for requests that explain it. The detection makes its trail in the same search.
//! A trail that was not kept is made again once for all askers: judged from a kept one where only thresholds differ,
//! continued from one of other slopes.

use super::{BurstId, JobError, OpenBurst, PictureAnswer, PictureKey, PictureKind, PictureRequest};
use crate::detector::{DetectorParams, SearchParams, SlopeFinding, memory};
use crate::inspect::ProbeCache;
use crate::monitor::Monitor;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Results of earlier requests; clones share them.
#[derive(Debug, Clone)]
pub struct Caches {
    pub(crate) trails: Trails,
    pub(crate) pictures: Arc<Mutex<PictureCache>>,
}

impl Caches {
    /// Caches without results, with memory for pictures that are not on show, bytes.
    pub fn new(picture_bytes: usize) -> Self {
        Self { trails: Trails::default(), pictures: Arc::new(Mutex::new(PictureCache::new(picture_bytes))) }
    }
}

/// Changes of what threads share are whole values, and work runs outside the locks with its panics caught: the data are
/// valid even if the lock is poisoned.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[derive(Debug)]
pub struct PictureCache {
    budget_bytes: usize,
    /// Least recently used first.
    entries: Vec<(PictureKey, PictureAnswer)>,
}

impl PictureCache {
    pub fn new(budget_bytes: usize) -> Self {
        Self { budget_bytes, entries: Vec::new() }
    }

    pub fn bytes(&self) -> usize {
        self.entries.iter().map(|(_, picture)| picture.bytes()).sum()
    }

    pub fn get(&mut self, request: &PictureRequest) -> Option<PictureAnswer> {
        let key = request.key();
        let entry = self.entries.remove(self.entries.iter().position(|(of, _)| *of == key)?);
        self.entries.push(entry.clone());
        Some(entry.1)
    }

    /// Frames are not kept: the burst holds them. Nor is a picture that exceeds the budget.
    pub fn insert(&mut self, picture: &PictureAnswer) {
        let is_frame = matches!(picture.request.kind, PictureKind::Frame(_)) && picture.request.minus().is_none();
        if is_frame || picture.bytes() > self.budget_bytes {
            return;
        }
        // Two requests may compute the same picture at once.
        let key = picture.request.key();
        self.entries.retain(|(of, _)| *of != key);
        self.entries.push((key, picture.clone()));
        self.set_budget(self.budget_bytes);
    }

    /// Drops pictures beyond the budget, those first that were unused for longest.
    pub fn set_budget(&mut self, budget_bytes: usize) {
        self.budget_bytes = budget_bytes;
        while self.bytes() > self.budget_bytes {
            self.entries.remove(0);
        }
    }
}

/// Source of a detection: its burst, and the parameters that were asked for and used.
#[derive(Debug, Clone)]
pub struct DetectionSource {
    pub burst: OpenBurst,
    pub asked: SearchParams,
    pub params: DetectorParams,
    pub finding: Option<SlopeFinding>,
}

impl DetectionSource {
    /// The slopes are known: they are not searched for again.
    pub fn trail(&self, monitor: &Monitor) -> Result<ProbeCache, JobError> {
        Ok(trail_of(&self.burst, &self.params, monitor)?.asked_as(&self.asked, self.finding.as_ref()))
    }
}

fn trail_of(burst: &OpenBurst, params: &DetectorParams, monitor: &Monitor) -> Result<ProbeCache, JobError> {
    Ok(ProbeCache::new(&burst.burst, &params.clone().into(), monitor)?)
}

/// Store of trails, shared by clones. Any budget gives the same answers, but not tallies of work done again or resumed.
#[derive(Debug, Clone, Default)]
pub struct Trails {
    state: Arc<Mutex<State>>,
    /// Budget in bytes; `None` for the trails' part of the memory that searches may take.
    budget_bytes: Option<usize>,
}

#[derive(Debug, Default)]
struct State {
    /// Least recently used first.
    kept: Vec<StoredTrail>,
    /// Keys of the trails that are being made, so that none is made twice.
    making: Vec<Key>,
    repeated: usize,
}

#[derive(Debug, Clone, PartialEq)]
struct Key {
    burst: BurstId,
    params: DetectorParams,
}

#[derive(Debug)]
struct StoredTrail {
    key: Key,
    open: OpenBurst,
    cache: Arc<ProbeCache>,
}

const WAIT: Duration = Duration::from_millis(5);

impl Trails {
    #[cfg(test)]
    pub(crate) fn new(budget_bytes: usize) -> Self {
        Self { state: Arc::default(), budget_bytes: Some(budget_bytes) }
    }

    pub(crate) fn budget_bytes(&self) -> usize {
        self.budget_bytes.unwrap_or_else(|| usize::try_from(memory::kept_bytes()).unwrap_or(usize::MAX))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        locked(&self.state)
    }

    pub(crate) fn keep_only(&self, bursts: &[BurstId]) {
        self.lock().kept.retain(|kept| bursts.contains(&kept.key.burst));
    }

    #[cfg(test)]
    pub(crate) fn repeated(&self) -> usize {
        self.lock().repeated
    }

    pub(crate) fn held(&self) -> (usize, usize) {
        let state = self.lock();
        (state.kept.len(), state.kept.iter().map(StoredTrail::bytes).sum())
    }

    fn judged(
        &self,
        open: &OpenBurst,
        asked: &SearchParams,
        monitor: &Monitor,
    ) -> Result<Option<ProbeCache>, JobError> {
        let judged = self.of_burst(open).iter().find_map(|cache| cache.rejudged(asked, monitor).transpose());
        Ok(judged.transpose()?)
    }

    /// Waits if another thread is making it. A new trail stays at least until the next one is made: most ask again.
    fn find_or_make(
        &self,
        open: &OpenBurst,
        key: &Key,
        monitor: &Monitor,
        find: impl Fn() -> Option<Arc<ProbeCache>>,
        make: impl FnOnce() -> Result<ProbeCache, JobError>,
    ) -> Result<Arc<ProbeCache>, JobError> {
        let making = loop {
            if let Some(cache) = find() {
                return Ok(cache);
            }
            monitor.check()?;
            if let Some(making) = Making::begin(self, key) {
                break making;
            }
            std::thread::sleep(WAIT);
        };
        // Another thread may have finished it between the look and `begin`.
        if let Some(cache) = find() {
            return Ok(cache);
        }
        self.lock().repeated += 1;
        self.make_room();
        let cache = Arc::new(make()?);
        let kept = StoredTrail { key: key.clone(), open: open.clone(), cache: cache.clone() };
        self.lock().keep(kept, self.budget_bytes());
        drop(making);
        Ok(cache)
    }

    pub(crate) fn put(&self, open: &OpenBurst, cache: &Arc<ProbeCache>) {
        let key = Key { burst: open.id, params: cache.made_with() };
        let kept = StoredTrail { key, open: open.clone(), cache: cache.clone() };
        // A trail beyond the budget would push out all others.
        if kept.bytes() <= self.budget_bytes() {
            self.lock().keep(kept, self.budget_bytes());
        }
    }

    /// Drops trails above the budget, before another one is made.
    pub(crate) fn make_room(&self) {
        self.lock().drop_to(self.budget_bytes(), 0);
    }

    pub(crate) fn asked(&self, open: &OpenBurst, asked: &SearchParams) -> Option<Arc<ProbeCache>> {
        self.lock().used(|kept| kept.key.burst == open.id && kept.cache.asked == *asked)
    }

    /// Trails of a burst, from which searches may [go on](ProbeCache::after), last used first.
    pub(crate) fn of_burst(&self, open: &OpenBurst) -> Vec<Arc<ProbeCache>> {
        let is_of_burst = |kept: &&StoredTrail| kept.key.burst == open.id;
        self.lock().kept.iter().rev().filter(is_of_burst).map(|kept| kept.cache.clone()).collect()
    }

    /// Trail judged again from a kept search, see [`ProbeCache::rejudged`]; replaces the kept trail.
    pub(crate) fn rejudged(
        &self,
        open: &OpenBurst,
        asked: &SearchParams,
        monitor: &Monitor,
    ) -> Result<Option<Arc<ProbeCache>>, JobError> {
        let judged = self.judged(open, asked, monitor)?.map(Arc::new);
        judged.iter().for_each(|judged| self.put(open, judged));
        Ok(judged)
    }

    pub(crate) fn get(&self, source: &DetectionSource) -> Option<Arc<ProbeCache>> {
        let DetectionSource { burst, asked, params, finding } = source;
        let key = Key { burst: burst.id, params: params.clone() };
        let mut state = self.lock();
        let cache = state.used(|kept| kept.key == key)?;
        if cache.asked == *asked {
            return Some(cache);
        }
        // The search is the same, asked for with other parameters.
        let cache = Arc::new(cache.asked_as(asked, finding.as_ref()));
        state.kept.last_mut().expect("just found").cache = cache.clone();
        Some(cache)
    }

    pub(crate) fn get_or_make_for(
        &self,
        burst: &OpenBurst,
        params: &DetectorParams,
        monitor: &Monitor,
    ) -> Result<Arc<ProbeCache>, JobError> {
        let key = Key { burst: burst.id, params: params.clone() };
        let kept = || self.lock().used(|kept| kept.key == key);
        self.find_or_make(burst, &key, monitor, kept, || trail_of(burst, params, monitor))
    }

    pub(crate) fn get_or_make(&self, source: &DetectionSource, monitor: &Monitor) -> Result<Arc<ProbeCache>, JobError> {
        let key = Key { burst: source.burst.id, params: source.params.clone() };
        // A kept search serves only if it leads to the very parameters of the source.
        let make = || match self.judged(&source.burst, &source.asked, monitor)? {
            Some(judged) if judged.made_with() == source.params => Ok(judged),
            _ => source.trail(monitor),
        };
        self.find_or_make(&source.burst, &key, monitor, || self.get(source), make)
    }
}

impl State {
    fn used(&mut self, is_it: impl Fn(&StoredTrail) -> bool) -> Option<Arc<ProbeCache>> {
        let kept = self.kept.remove(self.kept.iter().position(is_it)?);
        let cache = kept.cache.clone();
        self.kept.push(kept);
        Some(cache)
    }

    fn keep(&mut self, kept: StoredTrail, budget_bytes: usize) {
        // A search needs one trail only: the others are judged from it.
        let replaced =
            |other: &StoredTrail| other.key == kept.key || other.cache.trail.shares_search(&kept.cache.trail);
        self.kept.retain(|other| !replaced(other));
        self.kept.push(kept);
        self.drop_to(budget_bytes, 1);
    }

    /// Drops the least recently used until the others are within the budget, or only `rest` of them are left.
    fn drop_to(&mut self, budget_bytes: usize, rest: usize) {
        let bytes = |kept: &[StoredTrail]| kept.iter().map(StoredTrail::bytes).sum::<usize>();
        while self.kept.len() > rest && bytes(&self.kept) > budget_bytes {
            self.kept.remove(0);
        }
    }
}

impl StoredTrail {
    fn bytes(&self) -> usize {
        self.cache.bytes_beside(&self.open.burst)
    }
}

struct Making<'a> {
    trails: &'a Trails,
    key: &'a Key,
}

impl<'a> Making<'a> {
    fn begin(trails: &'a Trails, key: &'a Key) -> Option<Self> {
        let mut state = trails.lock();
        if state.making.contains(key) {
            return None;
        }
        state.making.push(key.clone());
        Some(Self { trails, key })
    }
}

impl Drop for Making<'_> {
    fn drop(&mut self) {
        self.trails.lock().making.retain(|other| other != self.key);
    }
}

/// Fraction of the progress that making a trail takes, where it is not kept.
const TRAIL_SHARE: f32 = 0.6;

pub(super) fn trail_and_rest(
    trails: &Trails,
    source: &DetectionSource,
    monitor: &Monitor,
) -> Result<(Arc<ProbeCache>, Monitor), JobError> {
    let (trail, share) = match trails.get(source) {
        Some(kept) => (kept, 0.0),
        None => (trails.get_or_make(source, &monitor.part(0.0, TRAIL_SHARE))?, TRAIL_SHARE),
    };
    Ok((trail, monitor.part(share, 1.0 - share)))
}
