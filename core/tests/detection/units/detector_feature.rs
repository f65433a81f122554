//! Tests of `detector::feature`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::feature::*;
use burstscope_core::detector::field::*;
use burstscope_core::detector::noise_model::*;
use burstscope_core::detector::params::*;
use burstscope_core::detector::scale_space::*;
use burstscope_core::detector::*;
use burstscope_core::monitor::Monitor;
use burstscope_core::synth::{ChartParams, Motion, synth_chart};
use std::sync::Arc;
