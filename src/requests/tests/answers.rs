//! Tests that a request's answer equals the result of the library's functions for the same values.

use super::{answer, open, params};
use crate::detector::Slope;
use crate::requests::{PictureKind, PictureRequest};

#[test]
fn a_difference_is_of_the_pixels_of_the_first() {
    let stack = PictureRequest::new(open(), PictureKind::Stack { slope: Slope::default() }, params());
    let frame = PictureRequest::new(open(), PictureKind::Frame(0), params());
    let difference = answer(stack.clone().less(&frame)).expect("pictures");
    let (a, b) = (answer(stack).expect("a picture"), &open().burst.frames[0]);
    let expected = |at: usize| a.plane.data()[at] - b.data()[at];
    assert!(difference.plane.data().iter().enumerate().all(|(at, x)| (x - expected(at)).abs() < 1e-6));
    // The octave's pixels are twice as large: the frame is taken at every second place.
    let dog = PictureKind::Dog { octave: 1, level: 1, slope: Slope::default() };
    let coarse = answer(PictureRequest::new(open(), dog, params()).less(&frame)).expect("pictures");
    assert_eq!(coarse.plane.size(), (48, 36));
    assert_eq!(coarse.request.minus().map(|minus| minus.kind), Some(PictureKind::Frame(0)));
}
