//! Randomly damaged files: opening them gives a burst or an error, never a panic, and never takes much time or memory.

use super::{crafted, damaged::PROGRESSIVE, support::*};
use std::sync::OnceLock;
use tiff::encoder::{Compression, DeflateLevel};

/// One valid file of each kind and type: (name, bytes).
pub fn samples() -> &'static [(&'static str, Vec<u8>)] {
    static SAMPLES: OnceLock<Vec<(&'static str, Vec<u8>)>> = OnceLock::new();
    SAMPLES.get_or_init(|| {
        let folder = folder();
        let at = |name: &str| folder.join(name);
        let deep: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_fn(9, 7, |u, v| Luma([(u * 5000 + v * 977) as u16]));
        let colour = ImageBuffer::from_fn(9, 7, |u, v| Rgb([(u * 20) as u8, (v * 30) as u8, (u * v) as u8]));
        let names = ["8.png", "8.jpg", "8.bmp", "8.pgm", "8.tif"];
        names.iter().for_each(|name| save(&at(name), &grey8(9, 7, 3)));
        ["16.png", "16.pgm"].iter().for_each(|name| save(&at(name), &deep));
        ["c.png", "c.jpg", "c.bmp", "c.ppm", "c.webp"].iter().for_each(|name| save(&at(name), &colour));
        fs::write(at("ascii.pnm"), "P2\n# words\n3 2\n15\n0 1 2\n13 14 15\n").expect("written");
        tiff_pages::<colortype::Gray16>(&at("16.tif"), (4, 3), &[vec![1; 12], vec![2; 12], vec![3; 12]]);
        tiff_pages::<colortype::Gray32Float>(&at("f.tif"), (4, 3), &[vec![0.5; 12], vec![0.25; 12]]);
        tiff_pages::<colortype::RGB8>(&at("c.tif"), (4, 3), &[vec![9; 36]]);
        for (name, compression) in [
            ("lzw.tif", Compression::Lzw),
            ("deflate.tif", Compression::Deflate(DeflateLevel::Fast)),
            ("packbits.tif", Compression::Packbits),
        ] {
            let file = fs::File::create(at(name)).expect("created");
            let mut encoder = TiffEncoder::new(file).expect("begins").with_compression(compression);
            encoder.write_image::<colortype::Gray16>(4, 3, &[500; 12]).expect("page");
        }
        write_npy(at("u2.npy"), &Array3::<u16>::ones((2, 3, 4))).expect("written");
        write_npy(at("f8.npy"), &Array2::<f64>::ones((3, 4))).expect("written");
        let all = names.iter().chain(&["16.png", "16.pgm", "c.png", "c.jpg", "c.bmp", "c.ppm", "c.webp", "ascii.pnm"]);
        let all =
            all.chain(&["16.tif", "f.tif", "c.tif", "lzw.tif", "deflate.tif", "packbits.tif", "u2.npy", "f8.npy"]);
        let mut samples: Vec<_> = all.map(|name| (*name, fs::read(at(name)).expect("read"))).collect();
        let planes: [&[u8]; 3] = [&[1; 12], &[2; 12], &[3; 12]];
        #[cfg(feature = "raw")]
        samples.push(("raw.dng", super::dng::Dng::new((12, 10), |u, v| (64 + 31 * u + 7 * v) as u16).bytes()));
        samples.push(("planar.tif", raw_tiff(false, (4, 3), &[8, 8, 8], &[(262, 2), (284, 2)], &planes)));
        samples.push(("big_endian.tif", raw_tiff(true, (4, 3), &[32], &[(262, 1), (339, 3)], &[&[0; 48]])));
        samples.extend(super::plain::samples());
        #[cfg(feature = "bags")]
        samples.extend(super::bags::samples());
        samples
    })
}

fn seeds() -> &'static [(&'static str, Vec<u8>)] {
    static SEEDS: OnceLock<Vec<(&'static str, Vec<u8>)>> = OnceLock::new();
    SEEDS.get_or_init(|| {
        let mut seeds = samples().to_vec();
        let progressive = PROGRESSIVE.to_vec();
        seeds.push(("cut.jpg", [&progressive[..progressive.len() * 2 / 3], &[0xff, 0xd9]].concat()));
        seeds.push(("progressive.jpg", progressive));
        seeds.push(("packed.png", crafted::packed_chunks_png(1 << 16)));
        seeds.push(("packed.fits", crafted::packed_tile_fits(1 << 22)));
        let packed = crafted::gzip_of_zeros(64);
        let scaled =
            [("TFIELDS", "2"), ("TTYPE2", "'ZSCALE'"), ("TFORM2", "'1D'"), ("ZZERO", "1.5"), ("ZBITPIX", "-32")];
        seeds.push(("scaled.fits", crafted::tile_fits(&scaled, &[0; 8], &crafted::gzip_of_zeros(256))));
        seeds.push(("wide.fits", crafted::tile_fits(&[("TFORM1", "'1QB'")], &[0; 8], &packed)));
        seeds.push(("many.npz", crafted::npz(&crafted::npy("4, 3, 2", &[7; 24]), 152, None, None)));
        seeds.push(("text.tif", crafted::huge_description_tiff()));
        seeds.push(("count5.tif", crafted::huge_count_dng(5)));
        #[cfg(feature = "bags")]
        seeds.push(super::bags::stereo());
        #[cfg(feature = "raw")]
        seeds.extend([("count10.dng", crafted::huge_count_dng(10)), ("count12.dng", crafted::huge_count_dng(12))]);
        seeds
    })
}

/// Opens the bytes as a file; limits are small, so that a wrong size cannot slow the test down.
fn open(name: &str, bytes: &[u8]) -> Result<Burst, Error> {
    let folder = folder();
    let path = folder.join(name);
    fs::write(&path, bytes).expect("written");
    let limits = Limits { max_side_px: 512, max_pixels: 1 << 16, max_frames: 16, max_bytes: 1 << 22 };
    Burst::open_with(&[path], &OpenOptions { limits, ..needed(name) }, &quiet())
}

/// Options without which a sample does not open: what its file does not say.
fn needed(name: &str) -> OpenOptions {
    let raw = name.ends_with(".raw").then(|| "3x2:u16le".parse().expect("a shape"));
    let axis = name.ends_with(".fits").then(|| "last".parse().expect("an axis"));
    OpenOptions { raw, axis, ..OpenOptions::default() }
}

fn check(name: &str, answer: Result<Burst, Error>) {
    match answer {
        Ok(burst) => {
            assert!(burst.frames.iter().all(|f| f.size() == burst.size() && f.data().iter().all(|v| v.is_finite())));
            assert!(burst.size().0 * burst.size().1 <= 1 << 16 && burst.len() <= 16);
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains(name) || error.kind == ErrorKind::SeveralBursts, "{message}");
            // The decoders of raw files and of JPEGs panic over some, which is caught and reported; all other decoders
            // must not panic.
            let may_panic = name.ends_with(".dng") || name.ends_with(".jpg");
            let panicked = message.contains("failed unexpectedly") && !may_panic;
            assert!(!panicked, "a decoder panicked over {name}");
        }
    }
}

/// Values that are unusual for counts, types, sizes and positions.
const EXTREMES: [u64; 14] =
    [0, 1, 5, 10, 12, 13, 16, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0xffff_ffff, 0x7fff_ffff_ffff_ffff, u64::MAX];

#[rustfmt::skip]
const WORDS: [&str; 22] = [
    "RICE_1", "RICE_ONE", "GZIP_1", "GZIP_2", "PLIO_1", "HCOMPRESS_1", "NOCOMPRESS", "1PB", "0PB",
    "2PB", "1QB", "1PI", "PJ(99)", "1B", "1D", "9999999999J", "NONE",
    "SUBTRACTIVE_DITHER_2", "COMPRESSED_DATA", "ZSCALE", "ZBLANK", "UNCOMPRESSED_DATA",
];

/// At least 400 cases for each test; more when PROPTEST_CASES asks for more.
fn config() -> ProptestConfig {
    let default = ProptestConfig::default();
    ProptestConfig { cases: default.cases.max(400), ..default }
}

#[test]
fn the_samples_are_valid() {
    for (name, bytes) in samples() {
        open(name, bytes).expect(name);
    }
}

#[test]
fn a_part_of_each_sample_is_that_of_the_whole_however_long_it_is() {
    let mut several = 0;
    for (name, bytes) in samples() {
        let folder = folder();
        let path = folder.join(name);
        fs::write(&path, bytes).expect("written");
        let opened = |take: &str, max_frames: usize| {
            let limits = Limits { max_frames, ..Limits::default() };
            let take = Some(take).filter(|take| !take.is_empty()).map(|take| take.parse().expect("a range"));
            // Where the file does not tell the range, it is that of the frames that are opened.
            let full_scale = Some(400.0).filter(|_| name.ends_with(".fits"));
            let options = OpenOptions { limits, take, full_scale, ..needed(name) };
            Burst::open_with(from_ref(&path), &options, &quiet())
        };
        let whole = opened("", 4096).expect(name);
        let beyond = opened(&format!("0..{}", whole.len() + 1), 4096).expect_err("there are not as many").to_string();
        assert!(whole.len() == 1 || beyond.contains(&format!("reaches beyond the {} frames", whole.len())), "{beyond}");
        if whole.len() < 2 || whole.positions.are_views() {
            continue;
        }
        let part = match opened("1..2", 1) {
            Err(error) if error.to_string().contains("not one after the other") => continue,
            part => part.expect(name),
        };
        several += 1;
        assert!(opened("", 1).expect_err(name).to_string().contains("--take"), "{name}");
        assert!(opened("1..1", 4096).expect_err(name).to_string().contains("take: 1..1 holds no frame"), "{name}");
        assert_eq!(part.len(), 1, "{name}");
        assert_eq!((&part.frames[0], &part.frame_names[0]), (&whole.frames[1], &whole.frame_names[1]), "{name}");
    }
    assert!(several > 12, "{several} samples hold several frames");
    // Of a folder it is a part of its files.
    let folder = folder();
    (0..5u8).for_each(|t| save(&folder.join(format!("{t}.png")), &grey8(9, 7, t)));
    let options = OpenOptions { take: "3..4".parse().ok(), ..OpenOptions::default() };
    let part = Burst::open_with(&[folder.to_path_buf()], &options, &quiet()).expect("a part");
    assert_eq!((part.len(), &*part.frame_names[0]), (1, "3.png"));
    // A bias frame is taken whole.
    let bias = super::support::folder();
    save(&bias.join("bias.png"), &grey8(9, 7, 0));
    let with_bias = OpenOptions { bias: Some(bias.join("bias.png")), ..options.clone() };
    Burst::open_with(&[folder.to_path_buf()], &with_bias, &quiet()).expect("a part with a bias frame");
    let info = Info::of(&[folder.to_path_buf()], &options, &quiet()).expect("described");
    assert!(info.frames == 1 && info.taken.contains(&"the frames 3..4 are taken".to_owned()), "{info:?}");
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn flipped_bits(sample in any::<prop::sample::Index>(), flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8u8), 1..6)) {
        let (name, bytes) = sample.get(seeds());
        let mut bytes = bytes.clone();
        for (place, bit) in flips {
            let place = place.index(bytes.len());
            bytes[place] ^= 1 << bit;
        }
        check(name, open(name, &bytes));
    }

    #[test]
    fn damaged_starts(sample in any::<prop::sample::Index>(), place in 0..200usize, noise in prop::collection::vec(any::<u8>(), 1..9)) {
        let (name, bytes) = sample.get(seeds());
        let mut bytes = bytes.clone();
        for (i, value) in noise.iter().enumerate() {
            let place = (place + i) % bytes.len();
            bytes[place] = *value;
        }
        check(name, open(name, &bytes));
    }

    /// Damages counts, types, sizes and positions: numbers of two, four or eight bytes at the ends of their ranges.
    #[test]
    fn numbers_at_the_ends_of_their_ranges(
        sample in any::<prop::sample::Index>(),
        numbers in prop::collection::vec((any::<prop::sample::Index>(), 1..4u32, 0..EXTREMES.len(), any::<bool>()), 1..4),
    ) {
        let (name, bytes) = sample.get(seeds());
        let mut bytes = bytes.clone();
        for (place, power, value, big_endian) in numbers {
            let width = 1 << power;
            let place = place.index(bytes.len());
            let value = if big_endian { EXTREMES[value].to_be_bytes() } else { EXTREMES[value].to_le_bytes() };
            let value = if big_endian { &value[8 - width..] } else { &value[..width] };
            let end = bytes.len().min(place + width);
            bytes[place..end].copy_from_slice(&value[..end - place]);
        }
        check(name, open(name, &bytes));
    }

    /// Damages the header of a FITS image: whole numbers, types of columns and compressions become others.
    #[test]
    fn values_of_cards(
        sample in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![
            any::<i64>(), -9..70i64, (0..63u32).prop_map(|power| 1 << power), (0..63u32).prop_map(|power| (1i64 << power).wrapping_neg()),
        ], 0..WORDS.len()), 1..4),
    ) {
        static FITS: OnceLock<Vec<(&'static str, Vec<u8>)>> = OnceLock::new();
        let fits = FITS.get_or_init(|| seeds().iter().filter(|(name, _)| name.ends_with(".fits")).cloned().collect());
        let (name, bytes) = sample.get(fits);
        let mut bytes = bytes.clone();
        for (place, number, word) in changes {
            let cards: Vec<usize> = (0..bytes.len() / 80 * 80).step_by(80).filter(|at| &bytes[at + 8..at + 10] == b"= ").collect();
            let at = cards[place.index(cards.len())] + 10;
            let value = if bytes[at] == b'\'' { format!("'{:<8}'", WORDS[word]) } else { format!("{number:>20}") };
            bytes[at..at + value.len()].copy_from_slice(value.as_bytes());
        }
        check(name, open(name, &bytes));
    }

    /// Directories of TIFFs and of raw files with any tags, types, counts and places.
    #[test]
    fn directories(
        entries in prop::collection::vec((prop_oneof![254..300u16, 320..335u16, Just(34665), Just(50706), any::<u16>()], 0..20u16, prop_oneof![0..9u32, any::<u32>()], prop_oneof![0..300u32, any::<u32>()]), 0..12),
        length in 0..400usize,
        is_raw in any::<bool>(),
    ) {
        let name = if is_raw && cfg!(feature = "raw") { "any.dng" } else { "any.tif" };
        check(name, open(name, &crafted::directory(&entries, length)));
    }

    #[test]
    fn truncations(sample in any::<prop::sample::Index>(), cut in any::<prop::sample::Index>()) {
        let (name, bytes) = sample.get(seeds());
        check(name, open(name, &bytes[..cut.index(bytes.len())]));
    }

    #[test]
    fn random_bytes_after_a_valid_start(sample in any::<prop::sample::Index>(), keep in 0..64usize, noise in prop::collection::vec(any::<u8>(), 0..300)) {
        let (name, bytes) = sample.get(seeds());
        let mut bytes = bytes[..keep.min(bytes.len())].to_vec();
        bytes.extend(noise);
        check(name, open(name, &bytes));
    }
}
