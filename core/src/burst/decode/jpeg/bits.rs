//! The bits of a scan of a JPEG: bytes up to a marker, in which 0xFF is followed by 0x00.

/// Reader of bits. After the last one it returns zeros without end, and counts them.
#[derive(Debug)]
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    /// Index of the next byte; at the marker once there are no more.
    at: usize,
    /// Next bits, the first one at the top.
    buffer: u64,
    /// Number of bits in the buffer, padding included.
    held: u32,
    /// Number of padding bits; more than `held` once one was used.
    made_up: u32,
    ended: bool,
}

impl<'a> Bits<'a> {
    /// The bits of `bytes` from `at` on.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, buffer: 0, held: 0, made_up: 0, ended: false }
    }

    /// Whether padding bits were used.
    #[inline]
    pub(super) fn overran(&self) -> bool {
        self.made_up > self.held
    }

    /// Position at or before the marker that ends the data, and after all markers before it.
    pub(super) fn place(&self) -> usize {
        self.at
    }

    /// Starts again at `at`, as after a restart marker.
    pub(super) fn restart_at(&mut self, at: usize) {
        *self = Self::new(self.bytes, at);
    }

    /// Fills the buffer with at least 32 bits.
    #[inline]
    fn fill(&mut self) {
        if self.held > 32 {
            return;
        }
        if let Some(next) = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<4>()) {
            let word = u32::from_be_bytes(*next);
            // No byte of the word is 0xFF: none of the complement is 0.
            let complement = !word;
            let has_ff = complement.wrapping_sub(0x0101_0101) & !complement & 0x8080_8080 != 0;
            if !has_ff && !self.ended {
                self.buffer |= u64::from(word) << (32 - self.held);
                (self.held, self.at) = (self.held + 32, self.at + 4);
                return;
            }
        }
        self.fill_slowly();
    }

    #[cold]
    fn fill_slowly(&mut self) {
        while self.held <= 32 {
            let byte = match self.bytes.get(self.at) {
                _ if self.ended => None,
                Some(0xff) if self.bytes.get(self.at + 1) == Some(&0) => Some((0xff, 2)),
                Some(0xff) | None => None, // a marker, or the end of the file
                Some(byte) => Some((*byte, 1)),
            };
            match byte {
                Some((byte, length)) => {
                    self.buffer |= u64::from(byte) << (56 - self.held);
                    (self.held, self.at) = (self.held + 8, self.at + length);
                }
                None => {
                    self.ended = true;
                    self.made_up = self.made_up.saturating_add(32);
                    self.held += 32;
                }
            }
        }
    }

    /// Next 16 bits, without consuming them.
    #[inline]
    pub(super) fn peek16(&mut self) -> u32 {
        self.fill();
        (self.buffer >> 48) as u32
    }

    /// Skips `count` bits, at most 32 (after a peek: 16 of the code and 16 of its value).
    #[inline]
    pub(super) fn skip(&mut self, count: u32) {
        self.fill();
        self.buffer <<= count;
        self.held -= count;
    }

    /// Consumes and returns the next `count` bits, at most 16.
    #[inline]
    pub(super) fn take(&mut self, count: u32) -> u32 {
        let value = self.peek16() >> (16 - count);
        self.skip(count);
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stuffed_bytes_and_the_end_are_seen() {
        let bytes = [0x12, 0xff, 0x00, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xff, 0xd9, 0x11];
        let mut bits = Bits::new(&bytes, 0);
        assert_eq!([4, 4, 8, 16].map(|count| bits.take(count)), [1, 2, 0xff, 0x3456]);
        bits.skip(20);
        assert_eq!((bits.take(4), bits.overran(), bits.place()), (0xc, false, 8));
        assert_eq!((bits.take(1), bits.overran()), (0, true));
        let mut bits = Bits::new(&bytes[..2], 0);
        // A lone 0xFF at the end of a file is no data.
        bits.skip(8);
        assert!(!bits.overran());
        bits.skip(1);
        assert!(bits.overran());
    }
}
