//! Zooms, pans, slopes and layouts of a window: after thousands of them the program, its graphics device and the driver
//! hold no more than after some hundreds.

use crate::{ALLOCATOR, ALONE, PATIENCE};
use burstscope::app::{BurstscopeApp, Startup, gpu::AdapterChoice, gpu::wgpu_setup, settings::Settings};
use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, TouchPhase, pos2, vec2};
use egui_kittest::Harness;
use std::{cell::OnceCell, rc::Rc, sync::PoisonError, time::Instant};

const STEPS: usize = 2000;
/// Number of steps after which nothing grows: caches and budgets are full.
const SETTLED: usize = 1000;
/// Memory of pictures that the window may keep, MB: full before [`SETTLED`].
const CACHE_MB: usize = 16;
/// Maximum growth of what our allocator and the device hold, bytes.
const GROWTH_BYTES: u64 = 8 << 20;
/// Maximum growth of the resident memory, in which the driver's is, bytes. With a shader whose branches depended on the
/// zoom, a software driver kept machine code of 1.7 MB for each zoom: more than 2 GB in all.
const RESIDENT_GROWTH_BYTES: u64 = 48 << 20;
const SIZE: [f32; 2] = [640.0, 420.0];

/// Bytes that the program's allocator, the graphics device and the whole process hold; 0 where nothing tells.
#[derive(Debug, Clone, Copy)]
struct Memory {
    allocated: u64,
    device: u64,
    resident: u64,
}

impl Memory {
    fn now(device: &wgpu::Device) -> Self {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let resident =
            status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.split_whitespace().next()?.parse().ok());
        Self {
            allocated: ALLOCATOR.current_usage() as u64,
            device: device.generate_allocator_report().map_or(0, |report| report.total_reserved_bytes),
            resident: resident.map_or(0, |kilobytes: u64| kilobytes << 10),
        }
    }
}

/// One thing that a user does: mostly a zoom, at a place and by an amount that no other step has.
fn step(harness: &mut Harness<'_, BurstscopeApp>, number: usize) {
    let turn = (number as f32 * 0.618_034).fract();
    let place = pos2(SIZE[0] * (0.55 + 0.3 * turn), SIZE[1] * (0.4 + 0.2 * turn));
    harness.event(Event::PointerMoved(place));
    let press = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    match number % 10 {
        // Frame, motion stack, DoG; frame beside stack and back; slopes.
        7 => {
            let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num2, Key::Num6, Key::Num2];
            harness.key_press(keys[number / 10 % keys.len()]);
        }
        3 | 8 => harness.key_press(if number / 10 % 8 < 4 { Key::ArrowRight } else { Key::ArrowLeft }),
        9 => {
            let end = place + vec2(17.0 * turn - 8.0, 9.0 * turn - 4.0);
            for event in [press(place, true), Event::PointerMoved(end), press(end, false)] {
                harness.event(event);
                harness.step();
            }
        }
        _ => {
            let way = if (number / 20).is_multiple_of(2) { 1.0 } else { -1.0 };
            let (unit, modifiers, phase) = (MouseWheelUnit::Point, Modifiers::NONE, TouchPhase::Move);
            let delta = vec2(0.0, way * (20.0 + 20.0 * turn));
            harness.event(Event::MouseWheel { unit, delta, modifiers, phase, source: MouseWheelSource::Wheel });
        }
    }
    harness.step();
    harness.render().expect("drawn");
}

#[test]
fn thousands_of_zooms_pans_slopes_and_layouts_leave_no_more_behind_than_hundreds() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let device: Rc<OnceCell<wgpu::Device>> = Rc::default();
    let kept = device.clone();
    let settings = Settings { cache_mb: CACHE_MB, auto_detect: false, ..Settings::default() };
    let startup = Startup { settings, ..Startup::default() };
    let mut harness =
        Harness::builder().with_size(SIZE).wgpu_setup(wgpu_setup(AdapterChoice::Software)).build_eframe(|cc| {
            let state = cc.wgpu_render_state.as_ref().expect("a device");
            kept.set(state.device.clone()).expect("the first");
            BurstscopeApp::new(&cc.egui_ctx, Some(state), startup)
        });
    let device = device.get().expect("made");
    let rest = |harness: &mut Harness<'_, BurstscopeApp>| {
        let end = Instant::now() + PATIENCE;
        while !harness.state().is_settled() {
            assert!(Instant::now() < end, "the window does not come to rest");
            harness.step();
        }
    };
    rest(&mut harness);
    let mut held = Vec::new();
    for number in 0..STEPS {
        step(&mut harness, number);
        if number % 100 == 99 {
            rest(&mut harness);
            held.push(Memory::now(device));
            println!("{:4} steps: {:?}", number + 1, held[held.len() - 1]);
        }
    }
    let soon = held[SETTLED / 100 - 1];
    let late = held[held.len() - 1];
    assert!(late.allocated < soon.allocated + GROWTH_BYTES, "{soon:?} and then {late:?}");
    assert!(late.device < soon.device + GROWTH_BYTES, "{soon:?} and then {late:?}");
    assert!(late.resident < soon.resident + RESIDENT_GROWTH_BYTES, "{soon:?} and then {late:?}");
}
