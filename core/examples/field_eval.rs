use burstscope_core::{
    Monitor, Plane,
    detector::{SlopeGrid, field::motion_field},
};
use std::io::Write;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let burst = burstscope_core::Burst::open(&a[1]).expect("burst");
    let ax = |s: &str| s.parse().expect("axis");
    let grid = SlopeGrid { u: ax(&a[2]), v: ax(&a[3]), direction_deg: 0.0 };
    let frames: Vec<&Plane> = burst.frames.iter().map(|f| &**f).collect();
    let t = std::time::Instant::now();
    let f = motion_field(&frames, &grid, &Monitor::default()).expect("ok").expect("field");
    eprintln!("{:?} cells {} px {:.2} s", f.size, f.cell_px, t.elapsed().as_secs_f32());
    let mut out = std::fs::File::create(&a[4]).expect("file");
    let mut w = |x: f32| out.write_all(&x.to_le_bytes()).expect("write");
    w(f.size.0 as f32);
    w(f.size.1 as f32);
    w(f.cell_px as f32);
    w(f.unknown_sigma);
    for (m, win) in f.motions.iter().zip(&f.window_px) {
        for x in [m.slope.u, m.slope.v, m.covariance[0], m.covariance[1], m.covariance[2], *win] {
            w(x);
        }
    }
}
