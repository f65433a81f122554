//! From a file's samples to one float value a pixel.
//!
//! Colour becomes luma: Y' = 0.2126 R' + 0.7152 G' + 0.0722 B', the weights of Rec. ITU-R BT.709, applied to the values
//! as they are stored, that is, to gamma-encoded values without decoding them. Alpha is ignored.

/// Weights of Rec. 709 for red, green and blue. They sum to 1.
pub const LUMA_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A number that a file can hold.
pub(super) trait Sample: Copy {
    /// The nearest `f32`.
    fn to_f32(self) -> f32;
}

macro_rules! sample {
    ($($type:ty)*) => { $(impl Sample for $type {
        #[inline]
        fn to_f32(self) -> f32 {
            self as f32
        }
    })* };
}
sample!(u8 u16 u32 u64 i8 i16 i32 i64 f32 f64);

/// Luma of a colour. Grey (r = g = b) comes out exactly, because only differences are weighted.
#[inline]
fn luma(r: f32, g: f32, b: f32) -> f32 {
    g + LUMA_WEIGHTS[0] * (r - g) + LUMA_WEIGHTS[2] * (b - g)
}

/// One value for each pixel of `samples` (interleaved, `channels` of them: grey, grey + alpha, RGB or RGB + alpha),
/// divided by `divisor`.
pub(super) fn grey_from_interleaved<T: Sample>(samples: &[T], channels: usize, divisor: f32) -> Vec<f32> {
    match channels {
        1 => samples.iter().map(|s| s.to_f32() / divisor).collect(),
        2 => samples.chunks_exact(2).map(|s| s[0].to_f32() / divisor).collect(),
        _ => samples
            .chunks_exact(channels)
            .map(|s| luma(s[0].to_f32(), s[1].to_f32(), s[2].to_f32()) / divisor)
            .collect(),
    }
}

/// One value for each pixel of three planes of colour, divided by `divisor`.
pub(super) fn grey_from_planes<T: Sample>(red: &[T], green: &[T], blue: &[T], divisor: f32) -> Vec<f32> {
    red.iter().zip(green).zip(blue).map(|((r, g), b)| luma(r.to_f32(), g.to_f32(), b.to_f32()) / divisor).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_stays_exact_and_colours_have_their_weights() {
        for n in 0..=255u8 {
            let expected = vec![f32::from(n) / 255.0];
            assert_eq!(grey_from_interleaved(&[n], 1, 255.0), expected);
            assert_eq!(grey_from_interleaved(&[n, 7], 2, 255.0), expected);
            assert_eq!(grey_from_interleaved(&[n, n, n], 3, 255.0), expected);
            assert_eq!(grey_from_interleaved(&[n, n, n, 0], 4, 255.0), expected);
        }
        let primaries = grey_from_interleaved(&[1.0f32, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], 3, 1.0);
        for (y, weight) in primaries.iter().zip(LUMA_WEIGHTS) {
            assert!((y - weight).abs() < 1e-6, "{y} is not {weight}");
        }
        assert_eq!(grey_from_planes(&[3u16], &[3], &[3], 3.0), vec![1.0]);
    }
}
