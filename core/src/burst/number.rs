//! Types of the numbers in files that hold pixels without compression, and their conversion to floats.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    /// A byte: 0, or anything else for 1.
    Bool,
    /// Eight numbers of 0 or 1 in a byte, the highest bit first, as `numpy.packbits` writes them.
    U1,
    U8,
    U16,
    U32,
    U64,
    I8,
    I16,
    I32,
    I64,
    F16,
    F32,
    F64,
    /// Four numbers of 10 bits in five bytes, lowest bits first (GenICam `Mono10p`).
    U10p,
    /// Two numbers of 12 bits in three bytes, lowest bits first (GenICam `Mono12p`).
    U12p,
    /// Two numbers of 10 bits in three bytes, the lowest bits of both in the middle one (GigE Vision `Mono10Packed`).
    U10Packed,
    /// Two numbers of 12 bits in three bytes, the lowest bits of both in the middle one (GigE Vision `Mono12Packed`).
    U12Packed,
}

/// Values of numbers: `offset + factor × number`; NaN for the number `blank`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scaling {
    pub factor: f64,
    pub offset: f64,
    pub blank: Option<i64>,
}

impl Scaling {
    fn value(self, number: f64) -> f32 {
        if self.blank.is_some_and(|blank| blank as f64 == number) {
            return f32::NAN;
        }
        (self.factor * number + self.offset) as f32
    }
}

impl Number {
    /// Bits of a number in the file, those of its share of a padding included.
    fn bits(self) -> usize {
        match self {
            Self::U1 => 1,
            Self::Bool | Self::U8 | Self::I8 => 8,
            Self::U10p => 10,
            Self::U12p | Self::U10Packed | Self::U12Packed => 12,
            Self::U16 | Self::I16 | Self::F16 => 16,
            Self::U32 | Self::I32 | Self::F32 => 32,
            Self::U64 | Self::I64 | Self::F64 => 64,
        }
    }

    /// Bytes of `count` numbers; packed ones begin and end with a whole byte.
    pub(super) fn bytes(self, count: u64) -> u64 {
        count.saturating_mul(self.bits() as u64).div_ceil(8)
    }

    /// Largest number, where that is the full scale: of types of up to 16 bits, whose range sensors fill.
    pub(super) fn range(self) -> Option<f32> {
        match self {
            Self::Bool | Self::U1 => Some(1.0),
            Self::U8 => Some(255.0),
            Self::U16 => Some(65535.0),
            Self::I8 => Some(127.0),
            Self::I16 => Some(32767.0),
            Self::U10p | Self::U10Packed => Some(1023.0),
            Self::U12p | Self::U12Packed => Some(4095.0),
            Self::U32 | Self::U64 | Self::I32 | Self::I64 | Self::F16 | Self::F32 | Self::F64 => None,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    /// Name of the type for the user, such as "16 bit".
    pub(super) fn words(self) -> String {
        match self {
            Self::Bool | Self::U1 => "1 bit".to_owned(),
            Self::U10p | Self::U10Packed => "10 bit".to_owned(),
            Self::I8 | Self::I16 => format!("{} bit with a sign", self.bits()),
            Self::U32 | Self::U64 | Self::I32 | Self::I64 => format!("integers of {} bit", self.bits()),
            Self::F16 | Self::F32 | Self::F64 => format!("floats of {} bit", self.bits()),
            Self::U8 | Self::U16 | Self::U12p | Self::U12Packed => format!("{} bit", self.bits()),
        }
    }

    /// Appends the values of `bytes`, scaled and divided by `unit`. Packed numbers begin with a whole group.
    pub(super) fn convert(self, bytes: &[u8], big_endian: bool, scale: Option<Scaling>, unit: f32, out: &mut Vec<f32>) {
        macro_rules! from {
            ($type:ty) => {{
                const SIZE: usize = size_of::<$type>();
                let (chunks, _) = bytes.as_chunks::<SIZE>();
                // The conversion is chosen here, not for each number, so that the loops are vectorised.
                match (scale, big_endian) {
                    (None, true) => out.extend(chunks.iter().map(|c| <$type>::from_be_bytes(*c) as f32 / unit)),
                    (None, false) => out.extend(chunks.iter().map(|c| <$type>::from_le_bytes(*c) as f32 / unit)),
                    (Some(s), true) => {
                        out.extend(chunks.iter().map(|c| s.value(<$type>::from_be_bytes(*c) as f64) / unit))
                    }
                    (Some(s), false) => {
                        out.extend(chunks.iter().map(|c| s.value(<$type>::from_le_bytes(*c) as f64) / unit))
                    }
                }
            }};
        }
        let mut packed = |group: usize, numbers: fn([u64; 5]) -> [u64; 4]| {
            let count = if group == 5 { 4 } else { 2 };
            for chunk in bytes.chunks(group) {
                // Missing bytes of a last group count as 0: its whole numbers are still right.
                let byte = std::array::from_fn(|i| chunk.get(i).copied().map_or(0, u64::from));
                out.extend(numbers(byte)[..count].iter().map(|number| *number as f32 / unit));
            }
        };
        match self {
            Self::Bool => out.extend(bytes.iter().map(|b| f32::from(u8::from(*b != 0)) / unit)),
            Self::U1 => {
                let bits = bytes.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1));
                out.extend(bits.map(|bit| f32::from(bit) / unit));
            }
            Self::U8 => from!(u8),
            Self::U16 => from!(u16),
            Self::U32 => from!(u32),
            Self::U64 => from!(u64),
            Self::I8 => from!(i8),
            Self::I16 => from!(i16),
            Self::I32 => from!(i32),
            Self::I64 => from!(i64),
            Self::F32 => from!(f32),
            Self::F64 => from!(f64),
            Self::F16 => {
                let (chunks, _) = bytes.as_chunks::<2>();
                let bits = |c: &[u8; 2]| if big_endian { u16::from_be_bytes(*c) } else { u16::from_le_bytes(*c) };
                out.extend(chunks.iter().map(|c| half::f16::from_bits(bits(c)).to_f32() / unit));
            }
            Self::U10p => packed(5, |b| {
                let all = b[0] | b[1] << 8 | b[2] << 16 | b[3] << 24 | b[4] << 32;
                std::array::from_fn(|i| all >> (10 * i) & 0x3ff)
            }),
            Self::U12p => packed(3, |b| [b[0] | (b[1] & 15) << 8, b[1] >> 4 | b[2] << 4, 0, 0]),
            Self::U10Packed => packed(3, |b| [b[0] << 2 | b[1] & 3, b[2] << 2 | b[1] >> 4 & 3, 0, 0]),
            Self::U12Packed => packed(3, |b| [b[0] << 4 | b[1] & 15, b[2] << 4 | b[1] >> 4, 0, 0]),
        }
    }
}
