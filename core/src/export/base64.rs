//! Base64 (RFC 4648), for pictures inside SVG. Fifteen lines, so no library.

use super::png::Picture;
use std::io::{self, Write};

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Writes `bytes` as Base64 with padding, without line breaks.
pub(super) fn write_base64(bytes: &[u8], out: &mut impl Write) -> io::Result<()> {
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        let digit = |i: usize| ALPHABET[(bits >> (18 - 6 * i) & 63) as usize];
        let mut text = [digit(0), digit(1), digit(2), digit(3)];
        text[chunk.len() + 1..].fill(b'=');
        out.write_all(&text)?;
    }
    Ok(())
}

/// A picture of three bytes for each pixel (red, green, blue) as a PNG inside a URL, for figures.
///
/// # Panics
/// When `rgb` does not hold `width × height × 3` bytes, or the picture is empty: mistakes of the caller.
pub fn picture_as_data_url(width: usize, height: usize, rgb: &[u8]) -> String {
    let mut png = Vec::new();
    Picture::rgb(width, height, rgb).encode_png(&mut png).expect("a picture with pixels is encoded in memory");
    let mut url = b"data:image/png;base64,".to_vec();
    write_base64(&png, &mut url).expect("memory can be written");
    String::from_utf8(url).expect("Base64 is text")
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_examples_of_rfc_4648_hold() {
        let cases =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in cases {
            let mut out = Vec::new();
            super::write_base64(plain.as_bytes(), &mut out).expect("memory takes everything");
            assert_eq!(out, coded.as_bytes());
        }
    }
}
