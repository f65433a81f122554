//! Malicious files: short ones that announce huge contents.

/// A directory of a TIFF, least significant byte first, whose entries have a tag, a type, a count and a value or its
/// position; no other follows it.
pub fn entries(entries: &[(u16, u16, u32, u32)]) -> Vec<u8> {
    let mut bytes = (entries.len() as u16).to_le_bytes().to_vec();
    for (tag, kind, count, value) in entries {
        bytes
            .extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    bytes.extend([0; 4]);
    bytes
}

/// A TIFF of such a directory alone, with zeros up to a length.
pub fn directory(list: &[(u16, u16, u32, u32)], length: usize) -> Vec<u8> {
    let mut bytes = [b"II*\0\x08\0\0\0", &entries(list)[..]].concat();
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
        let body = [&name[..], data].concat();
        [&(data.len() as u32).to_be_bytes(), &body[..], &crc(&body).to_be_bytes()].concat()
    };
    let packed = read(flate2::read::ZlibEncoder::new(zeros(unpacked as u64), flate2::Compression::best()));
    let profile = chunk(b"iCCP", &[b"ICC\0\0", &packed[..]].concat());
    let text = chunk(b"zTXt", &[b"Comment\0\0", &packed[..]].concat());
    let other = chunk(b"iTXt", &[b"Comment\0\x01\0\0\0", &packed[..]].concat());
    // After the signature and the header.
    const AFTER_HEADER: usize = 33;
    [&sound[..AFTER_HEADER], &profile, &text, &other, &sound[AFTER_HEADER..]].concat()
}

pub fn gzip_of_zeros(count: u64) -> Vec<u8> {
    read(flate2::read::GzEncoder::new(zeros(count), flate2::Compression::best()))
}

fn zeros(count: u64) -> impl std::io::Read {
    std::io::Read::take(std::io::repeat(0), count)
}

fn read(mut from: impl std::io::Read) -> Vec<u8> {
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes).expect("memory takes everything");
    bytes
}

/// A FITS image of 8×8 in one tile, which unpacks to `unpacked` zeros.
pub fn packed_tile_fits(unpacked: u64) -> Vec<u8> {
    tile_fits(&[], &[], &gzip_of_zeros(unpacked))
}

/// A FITS image of 8×8 bytes in one tile of gzip data. `changes` are other values of its keywords, or further ones, and
/// `rest` follows the reference of its row to the bytes `packed`.
pub fn tile_fits(changes: &[(&str, &str)], rest: &[u8], packed: &[u8]) -> Vec<u8> {
    let unit = |cards: &[(&str, &str)]| {
        let cards: String =
            cards.iter().map(|(name, value)| format!("{:<80}", format!("{name:<8}= {value}"))).collect();
        format!("{:<2880}", cards + "END")
    };
    let (length, row_bytes) = (packed.len().to_string(), (8 + rest.len()).to_string());
    let image = [("ZIMAGE", "T"), ("ZBITPIX", "8"), ("ZNAXIS", "2"), ("ZNAXIS1", "8"), ("ZNAXIS2", "8")];
    let tile = [("ZTILE1", "8"), ("ZTILE2", "8"), ("ZCMPTYPE", "'GZIP_1'"), ("TFIELDS", "1")];
    let column = [("TTYPE1", "'COMPRESSED_DATA'"), ("TFORM1", "'1PB'"), ("PCOUNT", &*length), ("GCOUNT", "1")];
    let table = [("XTENSION", "'BINTABLE'"), ("BITPIX", "8"), ("NAXIS", "2"), ("NAXIS1", &*row_bytes), ("NAXIS2", "1")];
    let mut cards = [&table[..], &column, &image, &tile].concat();
    for change in changes {
        match cards.iter_mut().find(|card| card.0 == change.0) {
            Some(card) => *card = *change,
            None => cards.push(*change),
        }
    }
    let header = unit(&[("SIMPLE", "T"), ("BITPIX", "8"), ("NAXIS", "0")]);
    let row = [&(packed.len() as u32).to_be_bytes()[..], &[0; 4], rest].concat();
    [header.as_bytes(), unit(&cards).as_bytes(), &row, packed].concat()
}

/// An archive with the member `frames.npy`, which announces `announced` bytes and has the given checksum; without one,
/// the right one. It is stored unless `packed` has its deflated bytes.
pub fn npz(member: &[u8], announced: u32, checksum: Option<u32>, packed: Option<&[u8]>) -> Vec<u8> {
    const NAME: &[u8] = b"frames.npy";
    let (data, method) = packed.map_or((member, 0u16), |packed| (packed, 8));
    let fields = [
        &20u16.to_le_bytes()[..],
        &[0; 2],
        &method.to_le_bytes(),
        &[0; 4],
        &checksum.unwrap_or(crc(member)).to_le_bytes(),
        &(data.len() as u32).to_le_bytes(),
        &announced.to_le_bytes(),
        &(NAME.len() as u16).to_le_bytes(),
        &[0; 2],
    ]
    .concat();
    let local = [b"PK\x03\x04", &fields[..], NAME, data].concat();
    let central = [b"PK\x01\x02\x14\0", &fields[..], &[0; 14], NAME].concat();
    let sizes = [central.len() as u32, local.len() as u32].map(u32::to_le_bytes).concat();
    [&local[..], &central, b"PK\x05\x06\0\0\0\0\x01\0\x01\0", &sizes, &[0; 2]].concat()
}

/// An array of bytes of this shape, as Python writes it, with the given values.
pub fn npy(shape: &str, values: &[u8]) -> Vec<u8> {
    npy_of("'|u1'", "False", shape, values)
}

pub fn npy_of(kind: &str, is_fortran: &str, shape: &str, values: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': {kind}, 'fortran_order': {is_fortran}, 'shape': ({shape}), }}");
    let header = format!("{header:<117}\n");
    [b"\x93NUMPY\x01\0", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), values].concat()
}

/// The checksum of PNG, gzip and ZIP.
pub fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}
