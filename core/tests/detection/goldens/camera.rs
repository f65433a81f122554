//! A real camera's noise.

use super::published::open;
use crate::shared::shared;
use burstscope_core::Monitor;

// Where no pixel is black, and wherever a band of brightness is taken, second differences of this camera's frames and
// of their differences show a noise of 2.3 to 3.1 grey values; the median over the image is 2.7. Half of each frame is
// black, which must not count.
#[needs::shared("data/slider-far")]
#[test]
fn noise_of_a_real_dim_camera() {
    let burst = open(&[shared("data/slider-far")]);
    let noise =
        burstscope_core::detector::noise::frame_noise(&burst, 20..29, &Monitor::default()).expect("not cancelled");
    println!("slider-far: noise of a frame {:.2} grey values", 255.0 * noise);
    assert!((255.0 * noise / 2.7 - 1.0).abs() < 0.15, "{}", 255.0 * noise);
}
