//! Turning of photographs: cameras store pixels as the sensor has them, and note which way is up.

use crate::plane::Plane;
use image::metadata::Orientation;

/// Size (columns, rows) of a picture of `size` after turning.
pub(super) fn turned_size((width, height): (usize, usize), orientation: Orientation) -> (usize, usize) {
    match orientation {
        Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH => {
            (height, width)
        }
        _ => (width, height),
    }
}

/// Function from a place of the turned picture, and the last column and row of the stored one, to the stored place.
type PlaceOf = fn((usize, usize), (usize, usize)) -> (usize, usize);

/// The picture turned upright.
pub(super) fn turned(plane: Plane, orientation: Orientation) -> Plane {
    let (width, height) = plane.size();
    let (right, bottom) = (width - 1, height - 1);
    let (new_width, new_height) = turned_size((width, height), orientation);
    let from = |at: PlaceOf| {
        Plane::from_fn(new_width, new_height, |u, v| {
            let (u, v) = at((u, v), (right, bottom));
            plane.at(u, v)
        })
    };
    match orientation {
        Orientation::NoTransforms => plane,
        Orientation::FlipHorizontal => from(|(u, v), (right, _)| (right - u, v)),
        Orientation::FlipVertical => from(|(u, v), (_, bottom)| (u, bottom - v)),
        Orientation::Rotate180 => from(|(u, v), (right, bottom)| (right - u, bottom - v)),
        Orientation::Rotate90 => from(|(u, v), (_, bottom)| (v, bottom - u)),
        Orientation::Rotate270 => from(|(u, v), (right, _)| (right - v, u)),
        // First turned, then flipped from left to right.
        Orientation::Rotate90FlipH => from(|(u, v), _| (v, u)),
        Orientation::Rotate270FlipH => from(|(u, v), (right, bottom)| (right - v, bottom - u)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_orientation_is_that_of_the_picture_library() {
        let picture = image::GrayImage::from_fn(3, 2, |u, v| image::Luma([(10 * v + u) as u8]));
        for exif in 1..=8 {
            let orientation = Orientation::from_exif(exif).expect("one of eight");
            let mut expected = image::DynamicImage::ImageLuma8(picture.clone());
            expected.apply_orientation(orientation);
            let expected = expected.into_luma8();
            let found = turned(Plane::from_fn(3, 2, |u, v| (10 * v + u) as f32), orientation);
            let size = (expected.width() as usize, expected.height() as usize);
            assert_eq!((found.size(), turned_size((3, 2), orientation)), (size, size), "{exif}");
            let found: Vec<u8> = found.data().iter().map(|&v| v as u8).collect();
            assert_eq!(found, expected.into_raw(), "{exif}");
        }
    }
}
