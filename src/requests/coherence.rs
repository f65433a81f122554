//! Coherence of each feature of a detection (how evenly the frames contribute to it), and the verdict that follows.

use super::error::JobError;
use super::request::{Request, Work};
use super::trail::{DetectionSource, trail_and_rest};
use crate::detector::Detection;
use crate::inspect::verdict::{Judged, judged};
use std::convert::Infallible;
use std::sync::Arc;

#[derive(Debug, Clone)]
pub struct CoherenceRequest {
    pub of: DetectionSource,
    pub detection: Arc<Detection>,
}

#[derive(Debug, Clone)]
pub struct Coherences {
    pub detection: Arc<Detection>,
    pub values: Arc<Vec<Judged>>,
}

impl PartialEq for CoherenceRequest {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.detection, &other.detection)
    }
}

impl Request for CoherenceRequest {
    type Answer = Coherences;
    type Partial = Infallible;

    fn compute(self, work: &Work<'_, Infallible>) -> Result<Coherences, JobError> {
        let (cache, rest) = trail_and_rest(work.caches.trails, &self.of, work.monitor)?;
        let values = Arc::new(judged(&cache.trail, &rest)?);
        Ok(Coherences { detection: self.detection, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::{DetectorParams, SlopeGrid};
    use crate::inspect::probe::Wanted;
    use crate::inspect::{ProbeOptions, probe};
    use crate::monitor::Monitor;
    use crate::requests::{BurstSource, DetectRequest, OpenBurst};
    use crate::synth::Example;

    #[test]
    fn the_verdicts_on_all_features_are_those_that_the_probe_says_of_each() {
        let burst = OpenBurst::new(Example::Depths.burst(), BurstSource::Example(Example::Depths));
        let slopes = SlopeGrid::line(-3.0..=3.0, 7);
        let params = DetectorParams { slopes, octaves: 2, ..DetectorParams::default() };
        let of = DetectionSource { burst: burst.clone(), asked: params.clone().into(), params, finding: None };
        let monitor = Monitor::default();
        let detect = DetectRequest { burst, params: of.asked.clone() };
        let detection = detect.compute(&Work::alone(&monitor)).expect("valid").detection;
        let request = CoherenceRequest { of: of.clone(), detection };
        let Coherences { detection, values } = request.compute(&Work::alone(&monitor)).expect("valid");
        assert_eq!(values.len(), detection.features.len());
        assert!(values.iter().filter_map(|j| j.coherence).all(|c| (0.0..=1.0).contains(&c)));
        let cache = of.trail(&monitor).expect("valid");
        let (mut told, step) = (0, (values.len() / 25).max(1));
        for index in (0..values.len()).step_by(step) {
            let options = ProbeOptions { wanted: Wanted::Feature(index), ..ProbeOptions::default() };
            let probed = probe(&cache, [0.0, 0.0], &options, &monitor).expect("a feature");
            assert_eq!(probed.judged.as_ref(), Some(&values[index]), "feature {index}");
            told += usize::from(values[index].coherence.is_some());
        }
        assert!(told > 10, "only {told} were told");
    }
}
