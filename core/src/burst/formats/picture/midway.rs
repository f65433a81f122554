//! Pictures whose decoding is cancelled midway.

use super::*;
use crate::{burst::reading::Ticker, monitor::Monitor};
use image::RgbImage;
use std::cell::Cell;

/// Bytes that cancel the work once half of them are read; `read` is how many were.
struct Cancelling<'a> {
    bytes: Cursor<&'a [u8]>,
    monitor: &'a Monitor,
    read: &'a Cell<usize>,
}

impl Read for Cancelling<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = buffer.len().min(512);
        let count = self.bytes.read(&mut buffer[..most])?;
        self.read.set(self.bytes.position() as usize);
        if 2 * self.read.get() > self.bytes.get_ref().len() {
            self.monitor.cancel();
        }
        Ok(count)
    }
}

impl Seek for Cancelling<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.bytes.seek(to)
    }
}

/// A picture that cannot be packed.
fn noise(format: ImageFormat) -> Vec<u8> {
    let mut state = 5u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let picture = RgbImage::from_fn(160, 120, |_, _| image::Rgb([(); 3].map(|()| next())));
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("written");
    bytes.into_inner()
}

#[test]
fn decoders_of_others_stop_where_they_read() {
    for format in [ImageFormat::Png, ImageFormat::Pnm, ImageFormat::Bmp, ImageFormat::WebP] {
        let (bytes, monitor, read) = (noise(format), Monitor::default(), Cell::new(0));
        let (options, ticker) = (OpenOptions::default(), Ticker::new(&monitor, 1));
        let reading = Reading::new(Path::new("noise"), &options, &ticker);
        let cancelling = Cancelling { bytes: Cursor::new(&bytes), monitor: &monitor, read: &read };
        let reader = BufReader::with_capacity(512, cancelling);
        let source = Source { reader, bytes: &[], length: bytes.len() as u64, format, part: Part::Only };
        let error = decoded(reading, source).expect_err("it is cancelled");
        assert!(error.is_cancelled(), "{format:?}: {error}");
        assert!((bytes.len() / 2..bytes.len() / 2 + 2048).contains(&read.get()), "{format:?}: {read:?} bytes");
    }
    let bytes = noise(ImageFormat::Jpeg);
    assert!(jpeg::samples(&bytes, true, &Monitor::default()).is_ok());
    assert!(jpeg::samples(&bytes, true, &Monitor::cancelled()).is_err());
}
