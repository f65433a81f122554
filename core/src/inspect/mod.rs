//! Explanations of a detection, a folder or file for each question.
//!
//! - [`place`]: What happened at this place, and what would keep a feature there?
//! - [`slopes`]: Which slopes does this burst need?
//! - [`pair`]: Why is this feature of a pair not matched?
//! - [`result`]: How good is the result as a whole: false rate, truth, the effect of a change?
//! - [`report`]: How is an answer written down? [`words`] has its numbers.
//!
//! Nothing is decided here: a verdict about a sample is the search's own ([`crate::detector::Trail`]). Where a setting
//! would help, an explanation ends with it. `slopes` and `result` use `place`, and `report` uses all of them.

pub mod pair;
pub mod place;
pub mod report;
pub mod result;
pub mod slopes;
pub mod words;

use crate::detect::{PreparedSearch, Searched};
use crate::detector::pipeline::{FirstFeatures, Keeping, search_with_trail};
use crate::detector::{Detection, DetectorParams, SearchParams, SlopeFinding, Slopes, Trail, find_slopes};
use crate::monitor::{Cancelled, Monitor};
use crate::{burst::Burst, error::Result};
use std::sync::{Arc, OnceLock};

/// A burst, its detection, and the parameters of the detection.
#[derive(Debug)]
pub struct ProbeCache {
    /// The burst that was searched: for [`Merge`](crate::detector::Method::Merge) the merged frame.
    pub burst: Burst,
    /// The detection and its trail. Shared: it is large, and may have been requested in several forms.
    pub trail: Arc<Trail>,
    /// The result of finding the slopes, if they were to be found.
    pub finding: Option<SlopeFinding>,
    /// The parameters as requested.
    pub asked: SearchParams,
    /// What the frames show of slopes, once it is asked for.
    shown: OnceLock<SlopeFinding>,
}

impl ProbeCache {
    /// Detects the features of `burst`, finding its slopes first if requested, and keeps the data that questions need.
    pub fn new(burst: &Burst, params: &SearchParams, monitor: &Monitor) -> Result<Self> {
        Self::after(&[], burst, params, &|_| {}, monitor)
    }

    /// As [`Self::new`], but what the one of the `earlier` searches that knows most of the slopes left is not searched
    /// again. The features are the same to the bit. A long search that begins anew gives the features of its first
    /// slope to `first` before it searches the others.
    pub fn after(
        earlier: &[Arc<Self>],
        burst: &Burst,
        params: &SearchParams,
        first: FirstFeatures<'_>,
        monitor: &Monitor,
    ) -> Result<Self> {
        let mut search = PreparedSearch::new(burst, params, monitor)?;
        let known = |cache: &&Arc<Self>| cache.trail.known_slopes(&search.burst, &search.params);
        let earlier = earlier.iter().filter(|cache| known(cache) > 0).max_by_key(known).map(|cache| &*cache.trail);
        let mut trail = search_with_trail(&search.burst, &search.params, Keeping { earlier, first }, &search.rest)?;
        while search.is_widened(trail.detection())? {
            let keeping = Keeping { earlier: Some(&trail), first: &|_| {} };
            trail = search_with_trail(&search.burst, &search.params, keeping, &search.rest)?;
        }
        let (burst, trail, finding, asked) = (search.burst, Arc::new(trail), search.finding, params.clone());
        Ok(Self { burst, trail, finding, asked, shown: OnceLock::new() })
    }

    /// What the frames show of slopes, whichever were searched.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` was cancelled.
    pub fn shown(&self, monitor: &Monitor) -> Result<&SlopeFinding, Cancelled> {
        if let Some(shown) = self.shown.get() {
            return Ok(shown);
        }
        let shown = match &self.finding {
            // A finding for a line has no evidence for the rest of the plane.
            Some(finding) if self.asked.slopes == Slopes::AUTO => finding.clone(),
            _ => find_slopes(&self.burst, self.params(), None, monitor)?,
        };
        Ok(self.shown.get_or_init(|| shown))
    }

    /// Result of another request from what this search left; `None` where it needs a new one: [`Trail::rejudged`].
    pub fn rejudged(&self, asked: &SearchParams, monitor: &Monitor) -> Result<Option<Self>, Cancelled> {
        if *asked != self.asked.judged_as(asked) {
            return Ok(None);
        }
        let trail = self.trail.rejudged(&self.params().judged_as(asked), monitor)?;
        let (burst, finding, asked) = (self.burst.clone(), self.finding.clone(), asked.clone());
        Ok(trail.map(|trail| Self { burst, trail: Arc::new(trail), finding, asked, shown: self.shown.clone() }))
    }

    /// This detection as the result of another request, `asked`, with its own finding of slopes.
    pub fn asked_as(&self, asked: &SearchParams, finding: Option<&SlopeFinding>) -> Self {
        let (burst, trail) = (self.burst.clone(), self.trail.clone());
        Self { burst, trail, finding: finding.cloned(), asked: asked.clone(), shown: OnceLock::new() }
    }

    /// The parameters of the whole detection: the requested ones, with the slopes that were searched.
    pub fn made_with(&self) -> DetectorParams {
        // A merged frame is searched as one frame, whichever frames were requested.
        DetectorParams { frames: self.asked.frames, ..self.params().clone() }
    }

    /// The detection as [`search`](crate::detect::search) gives it, without the time that finding the slopes took.
    pub fn searched(&self) -> Searched {
        let (detection, finding) = (self.detection().clone(), self.finding.clone());
        Searched { detection, params: self.made_with(), finding, slopes_secs: 0.0 }
    }

    /// Approximate bytes that it takes now beside `open`, the burst that was searched; the first question adds some.
    pub fn bytes_beside(&self, open: &Burst) -> usize {
        self.trail.bytes_beside(&open.frames)
    }

    /// The detection.
    pub fn detection(&self) -> &Detection {
        self.trail.detection()
    }

    /// The parameters of the search, including its slopes.
    pub fn params(&self) -> &DetectorParams {
        self.trail.params()
    }
}
