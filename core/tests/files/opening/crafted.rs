//! Malicious files: short ones that announce huge contents.

/// A TIFF of one directory, least significant byte first, whose entries have a tag, a type, a count and a value or its
/// position.
fn directory(entries: &[(u16, u16, u32, u32)], length: usize) -> Vec<u8> {
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        bytes
            .extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    bytes.extend([0; 4]);
    bytes.resize(length.max(bytes.len()), 0);
    bytes
}

/// A DNG of 226 bytes with an entry of 2³²−1 values of type `kind`: a decoder that trusts it allocates 34 GB.
pub fn huge_count_dng(kind: u16) -> Vec<u8> {
    let entries = [
        (254, 4, 1, 0),
        (256, 4, 1, 4),
        (257, 4, 1, 2),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 32803),
        (273, 4, 1, 210),
        (277, 3, 1, 1),
        (278, 4, 1, 2),
        (279, 4, 1, 16),
        (33434, kind, u32::MAX, 8),
        (50706, 1, 4, 0x0000_0401),
    ];
    directory(&entries, 226)
}

/// A raw file with such an entry whose structure only its decoder knows: only a memory limit stops it.
pub fn huge_count_raf() -> Vec<u8> {
    const AT: usize = 160;
    let mut bytes = b"FUJIFILMCCD-RAW 0201FF129502X-T1".to_vec();
    bytes.resize(AT, 0);
    // Position of the first directories, minus twelve.
    bytes[84..88].copy_from_slice(&(AT as u32 - 12).to_be_bytes());
    bytes.extend(directory(&[(271, 2, 4, 0x004a_5546), (33434, 5, u32::MAX, 8)], 64));
    bytes
}

/// A BigTIFF of one pixel with a description of 4 GiB.
pub fn huge_description_tiff() -> Vec<u8> {
    let entries: [(u16, u16, u64, u64); 10] = [
        (256, 4, 1, 1),
        (257, 4, 1, 1),
        (258, 3, 1, 8),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (270, 2, 4 << 30, 16),
        (273, 4, 1, 16),
        (277, 3, 1, 1),
        (278, 4, 1, 1),
        (279, 4, 1, 1),
    ];
    let mut bytes = b"II+\0\x08\0\0\0\x10\0\0\0\0\0\0\0".to_vec();
    bytes.extend((entries.len() as u64).to_le_bytes());
    for (tag, kind, count, value) in entries {
        bytes
            .extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    bytes.extend([0; 8]);
    bytes
}

/// A grey PNG of 8×8 with a colour profile, a compressed text and a text in another language of `unpacked` zeros each.
pub fn packed_chunks_png(unpacked: usize) -> Vec<u8> {
    let mut sound = Vec::new();
    let picture = image::GrayImage::from_fn(8, 8, |u, v| image::Luma([(u * 20 + v) as u8]));
    picture.write_to(&mut std::io::Cursor::new(&mut sound), image::ImageFormat::Png).expect("a PNG");
    let chunk = |name: &[u8; 4], data: &[u8]| {
        let mut bytes = (data.len() as u32).to_be_bytes().to_vec();
        let body = [&name[..], data].concat();
        bytes.extend(&body);
        bytes.extend(crc(&body).to_be_bytes());
        bytes
    };
    let packed = zlib_of_zeros(unpacked);
    let profile = chunk(b"iCCP", &[b"ICC\0\0", &packed[..]].concat());
    let text = chunk(b"zTXt", &[b"Comment\0\0", &packed[..]].concat());
    let other = chunk(b"iTXt", &[b"Comment\0\x01\0\0\0", &packed[..]].concat());
    // After the signature and the header.
    const AFTER_HEADER: usize = 33;
    [&sound[..AFTER_HEADER], &profile, &text, &other, &sound[AFTER_HEADER..]].concat()
}

/// A FITS image of 8×8 in one tile, which unpacks to `unpacked` zeros.
pub fn packed_tile_fits(unpacked: u64) -> Vec<u8> {
    let mut packed = Vec::new();
    let zeros = std::io::Read::take(std::io::repeat(0), unpacked);
    let mut encoder = flate2::read::GzEncoder::new(zeros, flate2::Compression::best());
    std::io::Read::read_to_end(&mut encoder, &mut packed).expect("memory takes everything");
    let unit = |cards: &[(&str, &str)]| {
        let cards: String =
            cards.iter().map(|(name, value)| format!("{:<80}", format!("{name:<8}= {value}"))).collect();
        format!("{:<2880}", cards + "END")
    };
    let length = packed.len().to_string();
    let image = [("ZIMAGE", "T"), ("ZBITPIX", "8"), ("ZNAXIS", "2"), ("ZNAXIS1", "8"), ("ZNAXIS2", "8")];
    let tile = [("ZTILE1", "8"), ("ZTILE2", "8"), ("ZCMPTYPE", "'GZIP_1'"), ("TFIELDS", "1")];
    let column = [("TTYPE1", "'COMPRESSED_DATA'"), ("TFORM1", "'1PB'"), ("PCOUNT", &*length), ("GCOUNT", "1")];
    let table = [("XTENSION", "'BINTABLE'"), ("BITPIX", "8"), ("NAXIS", "2"), ("NAXIS1", "8"), ("NAXIS2", "1")];
    let header = unit(&[("SIMPLE", "T"), ("BITPIX", "8"), ("NAXIS", "0")]);
    let row = [(packed.len() as u32).to_be_bytes(), [0; 4]].concat();
    [header.as_bytes(), unit(&[&table[..], &column, &image, &tile].concat()).as_bytes(), &row, &packed].concat()
}

/// Zeros as a zlib stream.
fn zlib_of_zeros(count: usize) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let block = vec![0; 1 << 16];
    for start in (0..count).step_by(block.len()) {
        encoder.write_all(&block[..block.len().min(count - start)]).expect("memory takes everything");
    }
    encoder.finish().expect("memory takes everything")
}

/// The checksum of a PNG's chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}
