//! Opening a burst and finding its features.

use super::{end_of, engine, stack_request, wait_for};
use crate::burst::{Burst, OpenOptions};
use crate::detector::{DetectorParams, SlopeGrid};
use crate::engine::Wanted;
use crate::plane::Plane;
use crate::requests::{BurstSource, DetectRequest, JobError, OpenBurst, OpenRequest};

#[test]
fn a_missing_file_is_a_message_that_names_it() {
    let (engine, mut opening) = (engine(), Wanted::default());
    let source = BurstSource::Paths(vec!["/no/such/folder-of-frames".into()]);
    opening.ask(&engine, OpenRequest { source, options: OpenOptions::default() });
    match end_of(&mut opening).result {
        Err(JobError::Failed(message)) => assert!(message.contains("folder-of-frames"), "{message}"),
        other => panic!("expected a message, got {other:?}"),
    }
}

#[test]
fn a_detection_can_be_cancelled_while_pictures_go_on() {
    let (engine, mut detecting, mut picture) = (engine(), Wanted::default(), Wanted::default());
    let frame = |t: usize| Plane::from_fn(512, 384, |u, v| ((u * 7919 + v * 104_729 + t * 31) % 997) as f32 / 997.0);
    let burst = OpenBurst::new(Burst::from_planes("large", (0..9).map(frame).collect()), BurstSource::Demo);
    let slopes = SlopeGrid::plane(-3.0..=3.0, 9, -3.0..=3.0, 9);
    let params = DetectorParams { slopes, ..DetectorParams::default() };
    detecting.ask(&engine, DetectRequest { burst: burst.clone(), params: params.into() });
    wait_for(|| {
        assert!(detecting.take().is_empty(), "it takes long");
        detecting.running().and_then(|running| running.progress)
    });
    picture.ask(&engine, stack_request(&burst, 0.25));
    assert!(end_of(&mut picture).result.is_ok());
    detecting.cancel();
    let ended = end_of(&mut detecting);
    assert!(matches!(ended.result, Err(JobError::Cancelled)), "{:?}", ended.result.map(|d| d.detection.times));
}
