//! Tests of `plane::memory`.
#![allow(unused_imports)]

use burstscope_core::error::*;
use burstscope_core::plane::*;
use burstscope_core::plane::memory::*;
use bytemuck::Zeroable;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::OnceLock;
use burstscope_core::plane::Plane;
use rayon::prelude::*;

#[test]
fn what_is_refused_is_an_error_with_its_size() {
    // 2^40 pixels of 4 bytes are more than a process may address on any machine of today; so is what overflows.
    let side = 1 << 30;
    assert_eq!(refusable(|| Plane::zeros(side, side)), Err(no_memory(1 << 62)));
    assert!(refusable(|| Plane::from_fn(side, side, |_, _| 0.0)).is_err());
    assert_eq!(refusable(|| Plane::zeros(usize::MAX, usize::MAX)), Err(no_memory(u64::MAX)));
    assert!(refusable(|| with_capacity::<u64>(usize::MAX)).is_err());
    assert_eq!(refusable(|| zeroed::<f32>(3)), Ok(vec![0.0; 3]));
    assert!(refusable(|| with_capacity::<u8>(9)).is_ok_and(|room| room.capacity() >= 9));
    let words = no_memory(3 << 20).to_string();
    assert!(words.contains("3 MiB"), "{words}");
}

#[test]
fn the_system_says_how_much_there_is_where_it_can() {
    assert!(machine_bytes().is_none_or(|bytes| bytes > 1 << 28));
    assert_eq!(machine_bytes_of("MemTotal:       2048 kB\nMemFree: 1 kB\n"), Some(2 << 20));
    let limits = |soft: &str| {
        format!("Limit   Soft Limit  Hard Limit  Units\nMax address space   {soft}   unlimited   bytes\n")
    };
    assert_eq!(address_space_of(&limits("4294967296")), Some(1 << 32));
    assert_eq!((address_space_of(&limits("unlimited")), address_space_of("")), (None, None));
}

#[test]
fn it_comes_through_parallel_loops_and_panics_stay_panics() {
    let work = || (0..64usize).into_par_iter().map(|i| zeroed::<u8>(if i == 40 { 1 << 62 } else { i }).len()).sum();
    assert_eq!(refusable::<usize>(work), Err(no_memory(1 << 62)));
    let panic = catch_unwind(|| refusable(|| panic!("a mistake")));
    assert_eq!(panic.expect_err("a panic").downcast_ref::<&str>(), Some(&"a mistake"));
}

