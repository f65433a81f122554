//! A table of Huffman codes of a JPEG (ITU-T T.81, annexes C and F.2.2.3), used to find the lengths of codes.

/// Length of code, bits, up to which one table look-up is enough.
const LOOK_BITS: u32 = 10;

/// The codes of one table.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// For each value of the next [`LOOK_BITS`] bits: the code's length times 256, plus its value; 0 for longer codes.
    short: Vec<u16>,
    /// For each length from 1 to 16: one more than the largest code of that length, aligned to the top of 16 bits.
    ends: [u32; 17],
    /// For each length: offset from a code to the index of its value.
    offsets: [i32; 17],
    values: Vec<u8>,
}

impl Table {
    /// Table with `counts[l − 1]` codes of length l for `values`; `None` where there are more codes than the length
    /// allows, or fewer values.
    pub(super) fn new(counts: &[u8; 16], values: &[u8]) -> Option<Self> {
        let mut table =
            Self { short: vec![0; 1 << LOOK_BITS], ends: [0; 17], offsets: [0; 17], values: values.to_vec() };
        let (mut code, mut place) = (0u32, 0usize);
        for length in 1..=16u32 {
            let count = usize::from(counts[length as usize - 1]);
            if code + count as u32 > 1 << length {
                return None;
            }
            table.offsets[length as usize] = place as i32 - code as i32;
            for value in values.get(place..place + count)? {
                if length <= LOOK_BITS {
                    let start = (code << (LOOK_BITS - length)) as usize;
                    table.short[start..start + (1 << (LOOK_BITS - length))]
                        .fill((length as u16) << 8 | u16::from(*value));
                }
                code += 1;
            }
            place += count;
            table.ends[length as usize] = code << (16 - length);
            code <<= 1;
        }
        Some(table)
    }

    /// Length and value of the code at the top of the 16 bits `next`; `None` where there is no such code.
    #[inline]
    pub(super) fn code(&self, next: u32) -> Option<(u32, u8)> {
        let short = self.short[(next >> (16 - LOOK_BITS)) as usize];
        if short != 0 {
            return Some((u32::from(short >> 8), short as u8));
        }
        let length = (LOOK_BITS as usize + 1..=16).find(|length| next < self.ends[*length])?;
        let place = (next >> (16 - length)) as i32 + self.offsets[length];
        Some((length as u32, *self.values.get(usize::try_from(place).ok()?)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_every_length_are_found() {
        // The table of T.81, K.3.1 has codes of 2 to 9 bits; this one goes on to 12.
        let mut counts = [0; 16];
        counts[1] = 1; // 00
        counts[2] = 2; // 010, 011
        counts[11] = 2; // 100000000000, 100000000001
        let table = Table::new(&counts, &[7, 8, 9, 10, 11]).expect("a table");
        assert_eq!(table.code(0b0011_1111_1111_1111), Some((2, 7)));
        assert_eq!(table.code(0b0100_0000_0000_0000), Some((3, 8)));
        assert_eq!(table.code(0b0111_1111_1111_1111), Some((3, 9)));
        assert_eq!(table.code(0b1000_0000_0000_1111), Some((12, 10)));
        assert_eq!(table.code(0b1000_0000_0001_0000), Some((12, 11)));
        assert_eq!(table.code(0b1000_0000_0010_0000), None);
        assert_eq!(table.code(0xffff), None);
        assert!(Table::new(&[3; 16], &[0; 48]).is_none(), "three codes of one bit");
    }
}
