//! Opening a burst and finding its features.

use super::{nobody, stack_request, wait_for};
use crate::burst::Burst;
use crate::detector::{DetectorParams, SlopeGrid};
use crate::engine::{BurstJobs, DEFAULT_CACHE_BYTES, Engine, Update};
use crate::plane::Plane;
use crate::requests::{BurstSource, DetectRequest, JobError, OpenBurst, PictureSlot};

#[test]
fn a_missing_file_is_a_message_that_names_it() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    engine.open(BurstSource::Paths(vec!["/no/such/folder-of-frames".into()]));
    let answer = wait_for(|| {
        engine.poll().into_iter().find_map(|u| match u {
            Update::Opened(answer) => Some(answer),
            _ => None,
        })
    });
    match answer.result {
        Err(JobError::Failed(message)) => assert!(message.contains("folder-of-frames"), "{message}"),
        other => panic!("expected a message, got {other:?}"),
    }
}

#[test]
fn a_detection_can_be_cancelled_while_pictures_go_on() {
    let engine = Engine::new(nobody(), DEFAULT_CACHE_BYTES);
    let frame = |t: usize| Plane::from_fn(512, 384, |u, v| ((u * 7919 + v * 104_729 + t * 31) % 997) as f32 / 997.0);
    let burst = OpenBurst::new(Burst::from_planes("large", (0..9).map(frame).collect()), BurstSource::Demo);
    let slopes = SlopeGrid::plane(-3.0..=3.0, 9, -3.0..=3.0, 9);
    let params = DetectorParams { slopes, ..DetectorParams::default() };
    engine.detect(DetectRequest { burst: burst.clone(), params: params.into() });
    wait_for(|| engine.running(BurstJobs::Detect));
    engine.request_picture(PictureSlot(3), stack_request(&burst, 0.25));
    wait_for(|| engine.poll().into_iter().find(|u| matches!(u, Update::Picture(_, a) if a.result.is_ok())));
    engine.cancel(BurstJobs::Detect);
    let answer = wait_for(|| {
        engine.poll().into_iter().find_map(|u| match u {
            Update::Detected(answer) => Some(answer),
            _ => None,
        })
    });
    assert!(matches!(answer.result, Err(JobError::Cancelled)), "{:?}", answer.result.map(|d| d.detection.times));
}
