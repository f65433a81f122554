//! Films: pictures of one size one after the other, for ever, as GIF or animated PNG.
//!
//! A GIF has 256 colours a picture and is shown everywhere; an animated PNG has all of them, is two to four times as
//! large, and is shown by browsers; other programs show its first picture.

use super::atomic::write_whole;
use super::error::ExportError;
use super::mark::SOFTWARE;
use crate::monitor::{Monitor, Stage};
use image::RgbaImage;
use std::io::{self, Write};
use std::path::Path;

/// Format of a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilmFormat {
    /// GIF.
    Gif,
    /// Animated PNG.
    Apng,
}

impl FilmFormat {
    /// Format by the ending of a file's name: gif, apng or png.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "gif" => Some(Self::Gif),
            "apng" | "png" => Some(Self::Apng),
            _ => None,
        }
    }
}

/// Pictures per second that a film may have.
pub const FILM_RATES: std::ops::RangeInclusive<u16> = 1..=50;
/// Speed of the choice of a GIF's colours: 1 is best, 30 fastest.
const GIF_SPEED: i32 = 10;

/// Encodes `pictures` of one size, `per_second` of them a second.
///
/// # Errors
/// Pictures of no size, of several sizes or too large for the format, and errors of `out`.
pub fn encode_film(
    out: &mut dyn Write,
    format: FilmFormat,
    pictures: &[RgbaImage],
    per_second: u16,
    monitor: &Monitor,
) -> io::Result<()> {
    let Some((width, height)) = pictures.first().map(RgbaImage::dimensions) else {
        return Err(io::Error::other("a film has at least one picture"));
    };
    if width == 0 || height == 0 || pictures.iter().any(|picture| picture.dimensions() != (width, height)) {
        return Err(io::Error::other("all pictures of a film have one size, of at least one pixel"));
    }
    let report = |index: usize| -> io::Result<()> {
        monitor.check().map_err(io::Error::other)?;
        monitor.report(Stage::Write, index as f32 / pictures.len() as f32);
        Ok(())
    };
    match format {
        FilmFormat::Gif => {
            let [Ok(width), Ok(height)] = [width, height].map(u16::try_from) else {
                return Err(io::Error::other("a GIF has at most 65535 columns and rows"));
            };
            let mut encoder = gif::Encoder::new(out, width, height, &[]).map_err(io::Error::other)?;
            encoder.set_repeat(gif::Repeat::Infinite).map_err(io::Error::other)?;
            encoder
                .write_raw_extension(gif::AnyExtension(gif::Extension::Comment as u8), &[SOFTWARE.as_bytes()])
                .map_err(io::Error::other)?;
            for (index, picture) in pictures.iter().enumerate() {
                report(index)?;
                let mut pixels = picture.as_raw().clone();
                let mut frame = gif::Frame::from_rgba_speed(width, height, &mut pixels, GIF_SPEED);
                // Hundredths of a second.
                frame.delay = 100 / per_second.max(1);
                encoder.write_frame(&frame).map_err(io::Error::other)?;
            }
            Ok(())
        }
        FilmFormat::Apng => {
            let mut encoder = png::Encoder::new(out, width, height);
            encoder.set_color(png::ColorType::Rgba);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_compression(png::Compression::Balanced);
            encoder.set_animated(pictures.len() as u32, 0).map_err(io::Error::other)?;
            encoder.set_frame_delay(1, per_second.max(1)).map_err(io::Error::other)?;
            encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned()).map_err(io::Error::other)?;
            let mut writer = encoder.write_header().map_err(io::Error::other)?;
            for (index, picture) in pictures.iter().enumerate() {
                report(index)?;
                writer.write_image_data(picture.as_raw()).map_err(io::Error::other)?;
            }
            writer.finish().map_err(io::Error::other)
        }
    }
}

/// Bytes of a film, about, before all of it is made: the sizes of its `first` and `middle` picture, times their number.
pub fn estimated_film_bytes(format: FilmFormat, pictures: [&RgbaImage; 2], count: usize) -> u64 {
    let of_one = |picture: &RgbaImage| {
        let mut bytes = Vec::new();
        let encoded = encode_film(&mut bytes, format, std::slice::from_ref(picture), 10, &Monitor::default());
        encoded.map_or(0, |()| bytes.len() as u64)
    };
    (of_one(pictures[0]) + of_one(pictures[1])) / 2 * count as u64
}

/// Writes a film.
///
/// # Errors
/// As [`encode_film`], and when the file cannot be written; an older one is then unchanged.
pub fn write_film(
    path: &Path,
    format: FilmFormat,
    pictures: &[RgbaImage],
    per_second: u16,
    monitor: &Monitor,
) -> Result<(), ExportError> {
    write_whole(path, |mut out| encode_film(&mut out, format, pictures, per_second, monitor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;

    fn pictures() -> Vec<RgbaImage> {
        (0..3u8).map(|t| RgbaImage::from_fn(20, 10, |x, _| Rgba([80 * t, (12 * x) as u8, 9, 255]))).collect()
    }

    #[test]
    fn films_come_back_picture_by_picture() {
        let mut bytes = Vec::new();
        encode_film(&mut bytes, FilmFormat::Gif, &pictures(), 10, &Monitor::default()).expect("encoded");
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(&bytes[..]).expect("a GIF");
        let mut count = 0;
        while let Some(frame) = decoder.read_next_frame().expect("a picture") {
            assert_eq!(frame.delay, 10);
            let of_truth = pictures()[count].as_raw().clone();
            let off = frame.buffer.iter().zip(&of_truth).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(off.is_some_and(|off| off <= 4), "{off:?}");
            count += 1;
        }
        assert_eq!(count, 3);
        let mut bytes = Vec::new();
        encode_film(&mut bytes, FilmFormat::Apng, &pictures(), 10, &Monitor::default()).expect("encoded");
        let mut reader = png::Decoder::new(io::Cursor::new(&bytes)).read_info().expect("a PNG");
        assert_eq!(reader.info().animation_control.map(|control| control.num_frames), Some(3));
        for picture in pictures() {
            let mut pixels = vec![0; 20 * 10 * 4];
            reader.next_frame(&mut pixels).expect("a picture");
            assert_eq!(&pixels, picture.as_raw());
        }
        let estimate = estimated_film_bytes(FilmFormat::Apng, [&pictures()[0], &pictures()[1]], 3) as f64;
        assert!((0.4..3.0).contains(&(estimate / bytes.len() as f64)));
    }

    #[test]
    fn wrong_pictures_are_refused_and_cancelling_ends_it() {
        let mut sizes = pictures();
        sizes.push(RgbaImage::new(3, 3));
        for pictures in [Vec::new(), vec![RgbaImage::new(0, 5)], sizes] {
            for format in [FilmFormat::Gif, FilmFormat::Apng] {
                assert!(encode_film(&mut Vec::new(), format, &pictures, 10, &Monitor::default()).is_err());
            }
        }
        let monitor = Monitor::default();
        monitor.cancel();
        assert!(encode_film(&mut Vec::new(), FilmFormat::Gif, &pictures(), 10, &monitor).is_err());
        assert_eq!(FilmFormat::of(Path::new("a/b.GIF")), Some(FilmFormat::Gif));
        assert_eq!(
            (FilmFormat::of(Path::new("a.apng")), FilmFormat::of(Path::new("gif"))),
            (Some(FilmFormat::Apng), None)
        );
    }
}
