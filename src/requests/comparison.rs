//! Comparison of the features of a burst with others: an earlier result, features of a file, or the truth.

use super::{JobError, OpenBurst};
use crate::detect::search;
use crate::detector::{Detection, DetectorParams, SearchParams};
use crate::inspect::result::{AgainstTruth, Changes, ForeignFeature, Spot, against_truth, compare, read_features};
use crate::synth::Truth;
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

request! {
    ComparisonRequest => ComparedWith: |self, work| {
        let (trails, monitor) = (&work.caches.trails, work.monitor);
        let spots: Vec<Spot> = self.detection.features.iter().map(Spot::from).collect();
        // What is searched or read stays in the request, which comes back with the answer.
        let Self { detection: ours, mut with } = self;
        let differences = match &mut with {
            ReferenceSource::Earlier { burst, asked, detection } => {
                // From cheap to dear: the result itself, its kept search, a search.
                let earlier = match (detection.take(), trails.asked(burst, asked)) {
                    (Some(earlier), _) => earlier,
                    (None, Some(kept)) => Arc::new(kept.detection().clone()),
                    (None, None) => Arc::new(search(&burst.burst, asked, monitor)?.detection),
                };
                changes_since(detection.insert(earlier).features.iter().map(Spot::from).collect(), &spots)
            }
            ReferenceSource::File { path, features } => {
                let read = features.take().map_or_else(|| read_features(path).map(Arc::new), Ok)?;
                monitor.check()?;
                changes_since(features.insert(read).iter().map(Spot::from).collect(), &spots)
            }
            ReferenceSource::Truth { burst, params } => {
                let unknown = || JobError::failed("nothing is known of what is really there");
                let truth = burst.truth(monitor)?.ok_or_else(unknown)?;
                let cache = trails.get_or_make_for(burst, params, monitor)?;
                let against = against_truth(&cache, &truth, monitor)?;
                Differences::Truth { against: Box::new(against), truth: Arc::new(truth) }
            }
        };
        monitor.check()?;
        Ok(ComparedWith { request: Self { detection: ours, with }, differences })
    }
}

#[derive(Debug, Clone)]
pub enum Differences {
    Changes { changes: Changes, before: Arc<Vec<Spot>> },
    Truth { against: Box<AgainstTruth>, truth: Arc<Truth> },
}

#[derive(Debug, Clone)]
pub struct ComparedWith {
    pub request: ComparisonRequest,
    pub differences: Differences,
}

fn changes_since(before: Vec<Spot>, after: &[Spot]) -> Differences {
    Differences::Changes { changes: compare(&before, after), before: Arc::new(before) }
}
