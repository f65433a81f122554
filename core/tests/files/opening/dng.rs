//! A small writer of DNG files: one uncompressed mosaic of 16 bit, with the tags that a camera writes.

use burstscope_core::plane::Plane;

/// Contents of the file.
pub struct Dng {
    /// (columns, rows) of the whole sensor.
    pub size: (usize, usize),
    /// Value of each pixel, row by row.
    pub values: Vec<u16>,
    /// Colours of the square of 2×2 at the start of the active area: 0 red, 1 green, 2 blue. `None` for a sensor
    /// without colours.
    pub mosaic: Option<[u8; 4]>,
    /// Black levels of the square of 2×2 at the start of the active area.
    pub black: [u16; 4],
    /// Black level of each column and of each row of the active area, relative to that; empty for none.
    pub black_steps: [Vec<i16>; 2],
    pub white: u16,
    /// Top, left, bottom, right of the pixels that are exposed to light.
    pub active: Option<[u32; 4]>,
    pub orientation: u16,
}

impl Dng {
    /// A sensor of `size` whose pixel (u, v) has `value(u, v)`; red first, ten bits, black at 64.
    pub fn new(size: (usize, usize), value: impl Fn(usize, usize) -> u16) -> Self {
        let values = (0..size.0 * size.1).map(|i| value(i % size.0, i / size.0)).collect();
        let mosaic = Some([0, 1, 1, 2]);
        Self {
            size,
            values,
            mosaic,
            black: [64; 4],
            black_steps: [const { Vec::new() }; 2],
            white: 1023,
            active: None,
            orientation: 1,
        }
    }

    pub fn bytes(&self) -> Vec<u8> {
        const BYTE: u16 = 1;
        const ASCII: u16 = 2;
        const SHORT: u16 = 3;
        const LONG: u16 = 4;
        const SIGNED_RATIONAL: u16 = 10;
        let shorts = |values: &[u16]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let longs = |values: &[u32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let mut bytes = b"II*\0\0\0\0\0".to_vec();
        let strip = bytes.len() as u32;
        bytes.extend(shorts(&self.values));
        let (width, height) = (self.size.0 as u32, self.size.1 as u32);
        let mut entries: Vec<(u16, u16, u32, Vec<u8>)> = vec![
            (254, LONG, 1, longs(&[0])),
            (256, LONG, 1, longs(&[width])),
            (257, LONG, 1, longs(&[height])),
            (258, SHORT, 1, shorts(&[16])),
            (259, SHORT, 1, shorts(&[1])),
            (262, SHORT, 1, shorts(&[if self.mosaic.is_some() { 32803 } else { 34892 }])),
            (271, ASCII, 5, b"None\0".to_vec()),
            (272, ASCII, 5, b"Test\0".to_vec()),
            (273, LONG, 1, longs(&[strip])),
            (274, SHORT, 1, shorts(&[self.orientation])),
            (277, SHORT, 1, shorts(&[1])),
            (278, LONG, 1, longs(&[height])),
            (279, LONG, 1, longs(&[2 * width * height])),
            (50706, BYTE, 4, vec![1, 4, 0, 0]),
            (50713, SHORT, 2, shorts(&[2, 2])),
            (50714, SHORT, 4, shorts(&self.black)),
            (50717, SHORT, 1, shorts(&[self.white])),
        ];
        if let Some(mosaic) = self.mosaic {
            entries.push((33421, SHORT, 2, shorts(&[2, 2])));
            entries.push((33422, BYTE, 4, mosaic.to_vec()));
        }
        for (tag, steps) in [50715, 50716].into_iter().zip(&self.black_steps) {
            // Halves, as signed fractions.
            let halves = steps.iter().flat_map(|step| [(2 * i32::from(*step)).to_le_bytes(), 2i32.to_le_bytes()]);
            let halves: Vec<u8> = halves.flatten().collect();
            if !halves.is_empty() {
                entries.push((tag, SIGNED_RATIONAL, steps.len() as u32, halves));
            }
        }
        if let Some(active) = self.active {
            entries.push((50829, LONG, 4, longs(&active)));
        }
        entries.sort_by_key(|entry| entry.0);
        // Data that does not fit into a directory's four bytes is stored before it.
        for entry in entries.iter_mut().filter(|entry| entry.3.len() > 4) {
            bytes.extend(std::mem::replace(&mut entry.3, longs(&[bytes.len() as u32])));
            bytes.resize(bytes.len().next_multiple_of(2), 0);
        }
        let directory = (bytes.len() as u32).to_le_bytes();
        bytes[4..8].copy_from_slice(&directory);
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, count, mut value) in entries {
            value.resize(4, 0);
            bytes.extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value].concat());
        }
        bytes.extend([0; 4]);
        bytes
    }
}

/// The values of a plane as such a sensor would record them: `black` + plane · (white − black).
pub fn sensor_values(plane: &Plane, black: f32, white: f32) -> impl Fn(usize, usize) -> u16 + '_ {
    // A square of the mosaic records one pixel of the plane.
    move |u, v| (black + plane.at(u / 2, v / 2) * (white - black)).round() as u16
}
