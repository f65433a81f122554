//! Comparison of the features of a burst with others: an earlier result, features of a file, or the truth.

use super::{JobError, OpenBurst, Request, Work};
use crate::detect::search;
use crate::detector::{Detection, DetectorParams, SearchParams};
use crate::inspect::result::{AgainstTruth, Changes, ForeignFeature, Spot, against_truth, compare, read_features};
use crate::synth::Truth;
use std::convert::Infallible;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(Debug, Clone)]
pub enum ReferenceSource {
    Earlier {
        burst: OpenBurst,
        asked: SearchParams,
        /// The result; if it is not kept any more, it is detected again.
        detection: Option<Arc<Detection>>,
    },
    File {
        path: PathBuf,
        features: Option<Arc<Vec<ForeignFeature>>>,
    },
    Truth {
        burst: OpenBurst,
        params: DetectorParams,
    },
}

#[derive(Debug, Clone)]
pub struct ComparisonRequest {
    pub detection: Arc<Detection>,
    pub with: ReferenceSource,
}

impl PartialEq for ReferenceSource {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Earlier { burst: a, asked: p, .. }, Self::Earlier { burst: b, asked: q, .. }) => (a, p) == (b, q),
            (Self::File { path: a, .. }, Self::File { path: b, .. }) => a == b,
            (Self::Truth { burst: a, params: p }, Self::Truth { burst: b, params: q }) => (a, p) == (b, q),
            _ => false,
        }
    }
}

impl Request for ComparisonRequest {
    type Answer = ComparedWith;
    type Partial = Infallible;

    fn compute(self, work: &Work<'_, Infallible>) -> Result<ComparedWith, JobError> {
        let (trails, monitor) = (&work.caches.trails, work.monitor);
        let spots: Vec<Spot> = self.detection.features.iter().map(Spot::from).collect();
        let differences = match &self.with {
            ReferenceSource::Earlier { burst, asked, detection } => {
                // From cheap to dear: the result itself, its kept search, a search.
                let earlier = match (detection, trails.asked(burst, asked)) {
                    (Some(earlier), _) => earlier.clone(),
                    (None, Some(kept)) => Arc::new(kept.detection().clone()),
                    (None, None) => Arc::new(search(&burst.burst, asked, monitor)?.detection),
                };
                let before: Vec<Spot> = earlier.features.iter().map(Spot::from).collect();
                changes_since(before, &spots, OthersSource::Earlier(earlier))
            }
            ReferenceSource::File { path, features } => {
                let read = features.clone().map_or_else(|| read_features(path).map(Arc::new), Ok)?;
                monitor.check()?;
                changes_since(read.iter().map(Spot::from).collect(), &spots, OthersSource::File(read))
            }
            ReferenceSource::Truth { burst, params } => {
                let truth = burst.truth(monitor)?;
                let truth =
                    truth.ok_or_else(|| JobError::Failed("nothing is known of what is really there".to_owned()))?;
                let cache = trails.get_or_make_for(burst, params, monitor)?;
                let against = against_truth(&cache, &truth, monitor)?;
                Differences::Truth { against: Box::new(against), truth: Arc::new(truth) }
            }
        };
        monitor.check()?;
        Ok(ComparedWith { request: self, differences })
    }
}

#[derive(Debug, Clone)]
pub enum Differences {
    Changes { changes: Changes, before: Arc<Vec<Spot>>, source: OthersSource },
    Truth { against: Box<AgainstTruth>, truth: Arc<Truth> },
}

#[derive(Debug, Clone)]
pub enum OthersSource {
    Earlier(Arc<Detection>),
    File(Arc<Vec<ForeignFeature>>),
}

#[derive(Debug, Clone)]
pub struct ComparedWith {
    pub request: ComparisonRequest,
    pub differences: Differences,
}

fn changes_since(before: Vec<Spot>, after: &[Spot], source: OthersSource) -> Differences {
    Differences::Changes { changes: compare(&before, after), before: Arc::new(before), source }
}
