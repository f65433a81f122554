//! Layout of a chart: positions, radii and motions of the discs.

use super::ChartParams;
use crate::monitor::Monitor;
use crate::synth::random::Stream;
use crate::synth::truth::{FeatureTruth, disc_sigma};
use crate::synth::{Motion, SynthError};

/// Draws positions, radii and slopes at random; large discs first, because they are hardest to place.
pub(super) fn place_discs(params: &ChartParams, monitor: &Monitor) -> Result<Vec<FeatureTruth>, SynthError> {
    let mut stream = Stream::new(params.seed, 0);
    let mut radii: Vec<f64> = (0..params.discs).map(|_| params.radius_law.draw(&params.radius, &mut stream)).collect();
    radii.sort_by(|a, b| b.total_cmp(a));
    let half_span = 0.5 * (params.frames - 1) as f64;
    let mut placed: Vec<FeatureTruth> = Vec::with_capacity(params.discs);
    for (id, &radius) in radii.iter().enumerate() {
        monitor.check()?;
        let mut place = None;
        for _ in 0..2000 {
            let slope_u = stream.within(-params.max_slope, params.max_slope);
            let slope_v = match params.motion {
                Motion::OneD => 0.0,
                Motion::TwoD => stream.within(-params.max_slope, params.max_slope),
            };
            let (x, y) = (stream.uniform(), stream.uniform());
            let rim = radius + 2.0;
            let (du, dv) = (rim + half_span * slope_u.abs(), rim + half_span * slope_v.abs());
            let (room_u, room_v) = ((params.width - 1) as f64 - 2.0 * du, (params.height - 1) as f64 - 2.0 * dv);
            if room_u < 0.0 || room_v < 0.0 {
                continue;
            }
            let (u, v) = (du + x * room_u, dv + y * room_v);
            if placed.iter().all(|d| (d.u - u).hypot(d.v - v) >= d.radius + radius + params.gap) {
                place = Some((u, v, slope_u, slope_v));
                break;
            }
        }
        let Some((u, v, slope_u, slope_v)) = place else {
            return Err(SynthError::param(
                "discs",
                format!("only {id} of {} discs fit into {}×{} pixels", params.discs, params.width, params.height),
                "ask for fewer or smaller discs, smaller slopes or a larger image",
            ));
        };
        placed.push(FeatureTruth {
            id,
            layer: None,
            u,
            v,
            radius,
            sigma: disc_sigma(radius),
            slope_u,
            slope_v,
            contrast_sign: if params.contrast > 1.0 { 1 } else { -1 },
        });
    }
    Ok(placed)
}
