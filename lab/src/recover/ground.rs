//! A burst before anything is planted: its own search, its noise and brightness by place, and the free places.

use super::{Planted, RecoverStudy, thing::LightNoise};
use crate::synth::random::Stream;
use burstscope_core::burst::{Burst, Offset};
use burstscope_core::detector::noise_model::{ForSearch, NoiseModel, examine};
use burstscope_core::detector::scale_space::{ScaleSpace, searched_octaves};
use burstscope_core::detector::{Feature, Method, SearchParams, Slope};
use burstscope_core::error::{Error, Result};
use burstscope_core::inspect::{ProbeCache, result::finds};
use burstscope_core::monitor::{Cancelled, Monitor};
use burstscope_core::plane::{Plane, blur::smoothed, sample::bilinear};
use burstscope_core::synth::outermost;
use std::ops::Range;

/// Side of a cell of the map of noise, pixels.
const CELL_PX: f32 = 16.0;
const BRIGHTNESS_SIGMA_PX: f64 = 6.0;
/// SNR of a feature, in noise gates, from which it is strong.
const STRONG_GATES: f32 = 1.5;
const ATTEMPTS: usize = 60;

#[derive(Debug)]
pub struct Ground {
    pub cache: ProbeCache,
    /// Parameters of the search of a copy: those that were asked for, with the slopes that were searched.
    pub params: SearchParams,
    pub used: Range<usize>,
    pub light: LightNoise,
    /// Brightness of each used frame relative to the others.
    pub gains: Vec<f64>,
    /// σ of one frame's noise, in cells.
    sigma: Plane,
    /// Brightness of the scene, fraction of full scale.
    pub brightness: Plane,
}

impl Ground {
    /// Searches `burst` and measures its noise; a burst without noise is an error.
    pub fn new(study: &RecoverStudy, burst: &Burst, monitor: &Monitor) -> Result<Self> {
        let params = &study.search;
        if params.method == Method::Merge {
            let problem = "planted things are not searched for in a merged frame";
            return Err(Error::param("method", problem, "give buff or sift"));
        }
        // Slopes that are to be found are found here once; every copy is searched with the same grid.
        let cache = ProbeCache::new(burst, params, monitor)?;
        let params = SearchParams::from(cache.made_with());
        let used = params.used_frames(burst.len());
        let noise = Self::noise(&cache, burst, monitor)?;
        let brightness = smoothed(&burst.frames[used.start + used.len() / 2], BRIGHTNESS_SIGMA_PX, monitor)?;
        let sigma = noise.sigma_map(burst.size(), CELL_PX);
        if noise.frame_noise <= 0.0 {
            let remedy = "take frames of a camera, or add noise with 'burstscope synth noisy'";
            return Err(Error::param("snr", "the burst has no noise, so that no ratio to it can be planted", remedy));
        }
        let gains = (0..used.len()).map(|t| noise.frames.get(t).map_or(1.0, |facts| f64::from(facts.gain))).collect();
        let light = LightNoise {
            per_brightness: f64::from(noise.transfer.slope),
            dark: f64::from(noise.transfer.dark).max(0.0),
            step: f64::from(burst.quantisation_step),
        };
        Ok(Self { cache, params, used, light, gains, sigma, brightness })
    }

    /// Noise model by place: that of the search if it is local, otherwise from an examination of the burst.
    fn noise(cache: &ProbeCache, burst: &Burst, monitor: &Monitor) -> Result<NoiseModel> {
        let of_search = cache.trail.noise();
        if of_search.is_local {
            return Ok((**of_search).clone());
        }
        let params = cache.params();
        let slopes: Vec<Slope> = params.used_slopes().slopes().collect();
        let space = ScaleSpace::of(params);
        let (octaves, flicker) = (searched_octaves(params, burst.size()), params.flicker);
        let search = ForSearch { space: &space, octaves, slopes: &slopes, flicker, positions: &burst.positions };
        let examined = examine(&burst.frames, burst.quantisation_step, &search, monitor)?;
        Ok(examined.map_or_else(|| (**of_search).clone(), |examined| examined.model))
    }

    /// σ of one frame's noise at (u, v), fraction of full scale.
    pub fn sigma_at(&self, u: f64, v: f64) -> f64 {
        // A cell's value stands for its middle, hence half a cell less.
        let cell = |x: f64| (x as f32 / CELL_PX - 0.5).max(0.0);
        let (width, height) = self.sigma.size();
        let at = (cell(u).min((width - 1) as f32), cell(v).min((height - 1) as f32));
        bilinear(&self.sigma, at.0, at.1).map_or(f64::from(self.cache.detection().frame_noise), f64::from)
    }

    /// Position of the used frame `t` from mid-burst.
    pub fn offset(&self, t: usize) -> Offset {
        self.cache.trail.frames().2.offset(t)
    }

    /// Draws a place for a thing of `radius` and `slope` that is away from the `others`; `None` where there is none.
    pub fn place(
        &self,
        study: &RecoverStudy,
        (radius, slope): (f64, Slope),
        others: &[Planted],
        stream: &mut Stream,
        monitor: &Monitor,
    ) -> Result<Option<(f64, f64)>, Cancelled> {
        let (width, height) = self.cache.trail.size_image();
        let (reach_u, reach_v) = outermost(self.cache.trail.frames().2.offsets(), (slope.u.into(), slope.v.into()));
        // Inside means the whole thing in all frames; otherwise its centre at mid-burst is enough.
        let rim = |outermost: f64| if study.inside { study.shape.reach(radius) + 2.0 + outermost } else { 1.0 };
        let (du, dv) = (rim(reach_u), rim(reach_v));
        let (room_u, room_v) = ((width - 1) as f64 - 2.0 * du, (height - 1) as f64 - 2.0 * dv);
        // Rejection keeps places uniform over the free area; in a crowded picture the attempts run out.
        for _ in 0..ATTEMPTS {
            monitor.check()?;
            let (x, y) = (stream.uniform(), stream.uniform());
            if room_u <= 0.0 || room_v <= 0.0 {
                return Ok(None);
            }
            let (u, v) = (du + x * room_u, dv + y * room_v);
            if self.is_free(study, (u, v), (radius, slope), others) {
                return Ok(Some((u, v)));
            }
        }
        Ok(None)
    }

    fn is_free(
        &self,
        study: &RecoverStudy,
        (u, v): (f64, f64),
        (radius, slope): (f64, Slope),
        others: &[Planted],
    ) -> bool {
        let thing = super::truth_of_thing(0, (u, v), radius, slope, 1);
        let gate = self.cache.detection().noise_gate_factor;
        let is_in_way = |feature: &Feature| {
            let away = (f64::from(feature.u) - u).hypot(f64::from(feature.v) - v);
            let is_strong = feature.snr >= STRONG_GATES * gate;
            // A feature of the burst itself must not count as a thing found.
            finds(feature, &thing)
                || (!study.on_features && is_strong && away < radius + 2.0 * f64::from(feature.sigma))
        };
        if self.cache.detection().features.iter().any(is_in_way) {
            return false;
        }
        others.iter().all(|other| {
            let (sigma, other_sigma) = (study.shape.sigma(radius), other.truth.sigma);
            let apart = radius + other.truth.radius + 2.0 * (sigma + other_sigma) + 3.0;
            // Things of different slopes may meet in any frame, so the gap has to hold in all of them.
            (0..self.used.len()).all(|t| {
                let at = self.offset(t);
                let ((own_u, own_v), (other_u, other_v)) = (thing.position(at), other.truth.position(at));
                (own_u - other_u).hypot(own_v - other_v) >= apart
            })
        })
    }

    /// Number of the used frames in which the centre of a thing is inside the image.
    pub fn frames_inside(&self, (u, v): (f64, f64), slope: Slope) -> usize {
        let (width, height) = self.cache.trail.size_image();
        let inside = |x: f64, n: usize| x >= 0.0 && x <= (n - 1) as f64;
        let shows = |t: &usize| {
            let (du, dv) = self.offset(*t).displacement((slope.u.into(), slope.v.into()));
            inside(u + du, width) && inside(v + dv, height)
        };
        (0..self.used.len()).filter(shows).count()
    }
}
