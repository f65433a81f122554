//! Tests of `export::csv`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::export::*;
use burstscope_core::files::*;
use burstscope_core::plane::sample::*;
use burstscope_core::plane::*;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
