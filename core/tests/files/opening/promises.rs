//! The table of formats of `docs/PROMISES.md`, line by line: sizes that are promised, lengths and checksums.

use super::crafted::{crc, directory, gzip_of_zeros, npy, npz, tile_fits};
use super::fuzz::samples;
use super::plain::unpacked;
use super::support::*;

fn options_for(name: &str) -> OpenOptions {
    let raw = name.ends_with(".raw").then(|| "3x2:u8".parse().expect("a shape"));
    // Three pictures of a FITS image may be colours.
    let axis = name.ends_with(".fits").then(|| "last".parse().expect("an axis"));
    OpenOptions { raw, axis, ..OpenOptions::default() }
}

fn taking(options: &OpenOptions) -> OpenOptions {
    OpenOptions { take: Some("0..2".parse().expect("a range")), ..options.clone() }
}

fn opened(name: &str, bytes: &[u8]) -> Result<Burst, Error> {
    let folder = folder();
    let path = folder.join(name);
    fs::write(&path, bytes).expect("written");
    open_with(&path, &options_for(name))
}

/// Samples whose readers are of this program or of a library in it; bags have tests of their own.
fn formats() -> impl Iterator<Item = &'static (&'static str, Vec<u8>)> {
    samples().iter().filter(|(name, _)| ![".bag", ".mcap", ".db3"].iter().any(|end| name.ends_with(end)))
}

#[track_caller]
fn refused(name: &str, bytes: &[u8], words: &str) {
    let error = opened(name, bytes).expect_err(name);
    let told = error.to_string();
    assert!(told.contains(name) && told.contains(words) && !told.contains("unexpectedly"), "{words}: {told}");
    assert_eq!(error.kind, ErrorKind::Damaged, "{told}");
}

/// A file that is cut is refused, unless nothing but bytes that are no frame's is missing.
#[test]
fn a_cut_file_is_refused_or_all_its_frames_are_there_and_a_film_that_is_cut_within_its_times_says_so() {
    // Frames without a header end anywhere.
    for (name, bytes) in formats().filter(|(name, _)| *name != "dump.raw") {
        let whole = opened(name, bytes).expect(name);
        let parts = (1..40).map(|part| bytes.len() * part / 40);
        for cut in parts.chain(bytes.len().saturating_sub(40)..bytes.len()) {
            if let Ok(burst) = opened(name, &bytes[..cut]) {
                assert!(burst.frames == whole.frames, "{name} cut to {cut} of {} opens as another", bytes.len());
                assert_eq!(burst.full_scale, whole.full_scale, "{name}");
            }
        }
    }
    let film = samples().iter().find(|(name, _)| *name == "mono12.ser").expect("a film").1.clone();
    let whole = opened("film.ser", &film).expect("whole");
    let (_folder, path) = folder_with("film.ser");
    let info = || Info::of(from_ref(&path), &OpenOptions::default(), &quiet()).expect("described");
    fs::write(&path, &film).expect("written");
    assert!(info().times_s.len() == whole.len() && !info().taken.iter().any(|note| note.contains("cut")));
    fs::write(&path, &film[..film.len() - 1]).expect("written");
    let told = info();
    assert!(told.times_s.is_empty() && told.taken.iter().any(|note| note.contains("may be cut")), "{told:?}");
    assert!(opened("film.ser", &film[..film.len() - 1]).expect("its frames are whole").frames == whole.frames);
}

/// A changed bit of what a checksum claims never gives other pixels.
#[test]
fn a_changed_bit_is_noticed_where_there_is_a_checksum() {
    let values: Vec<u8> = (0..600u32).map(|i| (i * i % 251) as u8).collect();
    let array = npy("3, 10, 20", &values);
    let mut packed = Vec::new();
    let mut encoder = flate2::read::DeflateEncoder::new(&array[..], flate2::Compression::best());
    std::io::Read::read_to_end(&mut encoder, &mut packed).expect("packed");
    let length = array.len() as u32;
    let mut gzip = Vec::new();
    let mut encoder = flate2::read::GzEncoder::new(&values[..64], flate2::Compression::best());
    std::io::Read::read_to_end(&mut encoder, &mut gzip).expect("packed");
    let tile = tile_fits(&[], &[], &gzip);
    let sample = |name: &str| samples().iter().find(|(own, _)| *own == name).expect(name).1.clone();
    let (png, (tiff, strip)) = (sample("16.png"), deflated_tiff());
    let pixels_at = tiff.len() - strip;
    for (name, bytes, from) in [
        ("stored.npz", npz(&array, length, None, None), 0),
        ("deflated.npz", npz(&array, length, None, Some(&packed)), 0),
        ("tile.fits", tile.clone(), tile.len() - gzip.len()),
        ("16.png", png, 0),
        ("deflate.tif", tiff, pixels_at),
        ("summed.fits", unpacked(include_bytes!("samples/summed.fits.gz")), 2880),
    ] {
        let whole = opened(name, &bytes).expect(name);
        let (step, mut noticed) = (((bytes.len() - from) / 400).max(1), 0);
        for at in (from..bytes.len()).step_by(step) {
            for bit in [0, 3, 7] {
                let mut changed = bytes.clone();
                changed[at] ^= 1 << bit;
                match opened(name, &changed) {
                    Ok(burst) => assert!(burst.frames == whole.frames, "{name}: bit {bit} of byte {at} is not noticed"),
                    Err(_) => noticed += 1,
                }
            }
        }
        assert!(noticed > 20, "{name}: {noticed} changes are noticed");
    }
    // Also where a part is taken, whose pixels are read before the end.
    let (_folder, path) = folder_with("part.npz");
    let mut changed = npz(&array, length, None, None);
    changed[400] ^= 1;
    fs::write(&path, &changed).expect("written");
    says(open_with(&path, &taking(&OpenOptions::default())).expect_err("a changed bit"), &["checksum"]);
}

#[test]
fn fits_images_that_do_not_add_up_open_on_demand_and_pictures_of_this_program_are_known() {
    let mut changed = unpacked(include_bytes!("samples/summed.fits.gz"));
    opened("summed.fits", &changed).expect("as astropy wrote it");
    changed[2880 + 5] ^= 1;
    refused("summed.fits", &changed, "DATASUM");
    let (_folder, path) = folder_with("summed.fits");
    fs::write(&path, &changed).expect("written");
    let part = open_with(&path, &taking(&options_for("summed.fits"))).expect_err("also of a part");
    assert!(part.remedy.contains("--accept-damaged"), "{part}");
    let accepted = OpenOptions { accept_damaged: true, ..options_for("summed.fits") };
    assert_eq!(open_with(&path, &accepted).expect("accepted").len(), 2);
    use burstscope_core::export::{Bitmap, is_ours, write_png};
    let (_folder, path) = folder_with("a.png");
    let mut braces = 0;
    for seed in 0..400u32 {
        let pixels: Vec<u8> = (0..48u32).map(|i| (i * 31 + seed * 77) as u8 ^ (seed >> 2) as u8).collect();
        write_png(&path, Bitmap::rgb(4, 4, &pixels)).expect("written");
        let bytes = fs::read(&path).expect("read");
        let checksum = &bytes[bytes.len() - 16..bytes.len() - 12];
        braces += u32::from(checksum.contains(&b'}'));
        assert!(is_ours(&path), "picture {seed}, whose checksum is {checksum:x?}");
    }
    assert!(braces > 0, "no checksum had a brace");
    assert_eq!(crc(b"IEND"), 0xae42_6082);
}

#[test]
fn an_archive_has_the_bytes_that_it_says() {
    let array = npy("3, 10, 20", &[7; 600]);
    let length = array.len() as u32;
    opened("right.npz", &npz(&array, length, None, None)).expect("right");
    refused("checksum.npz", &npz(&array, length, Some(1), None), "checksum");
    refused("stored.npz", &npz(&npy("4294967000, 1, 1", &[7; 600]), 4_294_967_290, None, None), "announces 4294967290");
    let mut packed = Vec::new();
    let mut encoder = flate2::read::DeflateEncoder::new(&array[..], flate2::Compression::best());
    std::io::Read::read_to_end(&mut encoder, &mut packed).expect("packed");
    refused("deflated.npz", &npz(&array, 4_294_967_290, None, Some(&packed)), "announces 4294967290");
    // Unpacked bytes beyond those that are announced, and too few.
    refused("more.npz", &npz(&array, length - 1, None, Some(&packed)), "NPZ");
    refused("less.npz", &npz(&array, length + 1, None, Some(&packed)), "NPZ");
}

/// Files of a few bytes on the disk that are as long as they say: nothing is made for each of their frames.
#[test]
fn any_number_of_frames_is_described_at_once_and_taken_in_part() {
    let home = folder();
    const MANY: u64 = 1 << 40;
    let card = |name: &str, value: u64| format!("{:<80}", format!("{name:<8}= {value:>20}"));
    let cards = [("BITPIX", 8), ("NAXIS", 3), ("NAXIS1", 1), ("NAXIS2", 1), ("NAXIS3", MANY)];
    let cards: String = cards.iter().map(|(name, value)| card(name, *value)).collect();
    let simple = format!("{:<80}", "SIMPLE  =                    T");
    let fits = format!("{:<2880}", simple + &cards + "END").into_bytes();
    let header = npy(&format!("{MANY}, 1, 1"), &[]);
    let mut ser = [&b"LUCAM-RECORDER"[..], &[0; 164]].concat();
    for (index, value) in [0, 0, 1, 1, 8, u32::MAX].into_iter().enumerate() {
        ser[18 + 4 * index..22 + 4 * index].copy_from_slice(&value.to_le_bytes());
    }
    let files = [
        ("dump.raw", Vec::new(), 6 * MANY, MANY as usize),
        ("stack.npy", header.clone(), header.len() as u64 + MANY, MANY as usize),
        ("film.ser", ser, 178 + 9 * u64::from(u32::MAX), u32::MAX as usize),
        ("cube.fits", fits, 2880 + MANY, MANY as usize),
    ];
    let mut paths = Vec::new();
    for (name, start, length, frames) in files {
        let path = home.join(name);
        fs::write(&path, start).expect("written");
        fs::File::options().write(true).open(&path).expect("opened").set_len(length).expect("a long file");
        let options = options_for(name);
        let info = Info::of(from_ref(&path), &options, &quiet());
        match info {
            Ok(info) => assert_eq!(info.frames, frames, "{name}"),
            // Without a part it is refused for its number of frames.
            Err(error) => assert!(error.to_string().contains(&format!("{frames} frames")), "{error}"),
        }
        assert_eq!(Info::of(from_ref(&path), &taking(&options), &quiet()).expect(name).frames, 2, "{name}");
        assert!(open_with(&path, &options).expect_err("too many").to_string().contains("4096 frames"), "{name}");
        assert_eq!(open_with(&path, &taking(&options)).expect(name).len(), 2, "{name}");
        let cut = SequenceCut::new(5, None).expect("a cut");
        let sequence = BurstFiles { name: "long".to_owned(), paths: vec![path.clone()] };
        says(cut_sequence(&sequence, cut, &options).expect_err("one file"), &["this one file holds"]);
        paths.push(path);
    }
    assert_eq!(find_bursts(&paths[1..], &OpenOptions::default()).expect("found").len(), 3);
}

/// Cards of a table whose numbers lead a decoder astray.
#[test]
fn tables_of_tiles_that_announce_the_impossible_are_refused() {
    let packed = gzip_of_zeros(64);
    opened("right.fits", &tile_fits(&[], &[], &packed)).expect("right");
    for (changes, words) in [
        (&[("NAXIS", "0"), ("NAXIS1", "4611686018427387904")][..], "0 axes (NAXIS)"),
        (&[("NAXIS", "3"), ("NAXIS3", "0"), ("NAXIS1", "4611686018427387904")], "3 axes (NAXIS)"),
        (&[("NAXIS1", "-8")], "NAXIS1"),
        (&[("NAXIS1", "4611686018427387904")], "NAXIS1"),
        (&[("NAXIS2", "1152921504606846976")], "NAXIS2"),
        (&[("NAXIS2", "0")], "0 in "),
        (&[("PCOUNT", "9223372036854775807")], "are there"),
        (&[("THEAP", "9223372036854775807")], "from byte 0 of 0"),
        (&[("TFORM1", "'0PB'")], "another type (TFORM)"),
        (&[("TFORM1", "'2PB'")], "another type (TFORM)"),
        (&[("TTYPE1", "'PACKED'")], "COMPRESSED_DATA"),
        (&[("ZNAXIS", "3"), ("ZNAXIS3", "1099511627776"), ("NAXIS2", "1099511627776")], "1099511627776 frames"),
    ] {
        says(opened("bad.fits", &tile_fits(changes, &[], &packed)).expect_err(words), &["bad.fits", words]);
    }
    let scale = [("TFIELDS", "2"), ("TTYPE2", "'ZSCALE'"), ("TFORM2", "'1B'"), ("ZZERO", "0"), ("ZBITPIX", "-32")];
    refused("scale.fits", &tile_fits(&scale, &[0], &gzip_of_zeros(256)), "ZSCALE");
}

/// Gzip data that readers read differently, and tiles that are shorter or longer than their pixels.
#[test]
fn a_tile_has_the_bytes_of_its_pixels() {
    let packed = gzip_of_zeros(64);
    let changed = |flags: u8, insert: &[u8]| {
        let mut bytes = packed.clone();
        bytes[3] = flags;
        [&bytes[..10], insert, &bytes[10..]].concat()
    };
    refused("flag.fits", &tile_fits(&[], &[], &changed(0x80, &[])), "gzip");
    refused("header.fits", &tile_fits(&[], &[], &changed(2, &[1, 2])), "gzip");
    refused("none.fits", &tile_fits(&[], &[], &[9; 40]), "gzip");
    let two = [&packed[..], &packed].concat();
    refused("two.fits", &tile_fits(&[], &[], &two), "bytes follow its gzip data");
    let filled = [&packed[..], &[0; 9]].concat();
    opened("filled.fits", &tile_fits(&[], &[], &filled)).expect("zeros fill up");
    refused("half.fits", &tile_fits(&[], &[], &gzip_of_zeros(32)), "unpacks to 32 bytes");
    refused("more.fits", &tile_fits(&[], &[], &gzip_of_zeros(300)), "unpacks to more than its pixels");
    let mut sum = packed.clone();
    let at = sum.len() - 8;
    sum[at] ^= 1;
    refused("sum.fits", &tile_fits(&[], &[], &sum), "gzip");
    refused("cut.fits", &tile_fits(&[], &[], &packed[..packed.len() - 3]), "gzip");
    // A row without bytes, in all columns.
    refused("empty.fits", &tile_fits(&[], &[], &[]), "have 0 bytes");
    let of = |code: &str, bits: &str, bytes: &[u8]| tile_fits(&[("ZCMPTYPE", code), ("ZBITPIX", bits)], &[], bytes);
    opened("plain.fits", &of("'NOCOMPRESS'", "8", &[7; 64])).expect("as it is");
    refused("plain.fits", &of("'NOCOMPRESS'", "8", &[7; 63]), "have 63 bytes");
    let rice = |bytes: &[u8]| {
        let parameters = [("ZNAME1", "'BLOCKSIZE'"), ("ZVAL1", "32"), ("ZNAME2", "'BYTEPIX'"), ("ZVAL2", "2")];
        let cards = [&[("ZCMPTYPE", "'RICE_1'"), ("ZBITPIX", "16")][..], &parameters].concat();
        tile_fits(&cards, &[], bytes)
    };
    // The first pixel, and two blocks of equal ones.
    opened("rice.fits", &rice(&[0, 9, 0])).expect("whole");
    refused("rice.fits", &rice(&[0, 9]), "too few for 64 pixels");
    refused("rice.fits", &rice(&[0]), "too few for 64 pixels");
    // Bytes shuffled by their place in the pixel.
    let planes: Vec<u8> = [vec![1; 64], vec![2; 64]].concat();
    let mut shuffled = Vec::new();
    let mut encoder = flate2::read::GzEncoder::new(&planes[..], flate2::Compression::best());
    std::io::Read::read_to_end(&mut encoder, &mut shuffled).expect("packed");
    let burst = opened("turn.fits", &of("'GZIP_2'", "16", &shuffled)).expect("in turn");
    assert!(burst.frames[0].data().iter().all(|value| (value * burst.full_scale - 258.0).abs() < 1e-3));
}

#[test]
fn a_tiff_that_is_cut_within_its_description_is_refused_with_the_place() {
    let (_folder, path) = folder_with("axes.tif");
    let ome = "<?xml version=\"1.0\"?><OME><Image><Pixels DimensionOrder=\"XYCTZ\" SizeX=\"4\" SizeY=\"4\" SizeZ=\"1\" SizeC=\"2\" SizeT=\"2\"/></Image></OME>";
    let mut encoder = TiffEncoder::new(fs::File::create(&path).expect("made")).expect("begins");
    for page in 0..4u8 {
        let mut image = encoder.new_image::<colortype::Gray8>(4, 4).expect("a page");
        let description = if page == 0 { ome } else { "" };
        image.encoder().write_tag(Tag::ImageDescription, description).expect("a tag");
        image.write_data(&[page; 16]).expect("written");
    }
    drop(encoder);
    let mut bytes = fs::read(&path).expect("read");
    assert!(opened("axes.tif", &bytes).expect_err("two axes").to_string().contains("2 times (T) × 2 channels (C)"));
    // The text moves to the end, as programs write it that add it later.
    let at = bytes.windows(5).position(|part| part == b"<?xml").expect("the text") as u32;
    let entry = bytes.windows(4).position(|part| part == at.to_le_bytes()).expect("its place");
    let end = bytes.len() as u32;
    bytes[entry..entry + 4].copy_from_slice(&end.to_le_bytes());
    bytes.extend(ome.as_bytes());
    bytes.push(0);
    assert!(opened("axes.tif", &bytes).expect_err("two axes").to_string().contains("channels"));
    for cut in [1, 20, ome.len()] {
        refused("axes.tif", &bytes[..bytes.len() - cut], "tag 270");
    }
}

/// A TIFF of 40×30 whose deflated strip lies at its end, and the length of that.
fn deflated_tiff() -> (Vec<u8>, usize) {
    let (_folder, path) = folder_with("strip.tif");
    let file = fs::File::create(&path).expect("made");
    let deflate = tiff::encoder::Compression::Deflate(tiff::encoder::DeflateLevel::Best);
    let mut encoder = TiffEncoder::new(file).expect("begins").with_compression(deflate);
    let values: Vec<u8> = (0..1200u32).map(|i| (i * i % 253) as u8).collect();
    encoder.write_image::<colortype::Gray8>(40, 30, &values).expect("a page");
    drop(encoder);
    let mut bytes = fs::read(&path).expect("read");
    let tag = |tag: u16| {
        let head = [&tag.to_le_bytes()[..], &4u16.to_le_bytes(), &1u32.to_le_bytes()].concat();
        bytes.windows(8).position(|part| part == head).expect("an entry") + 8
    };
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    let (place, length) = (tag(273), number(tag(279)));
    let strip = bytes[number(place)..][..length].to_vec();
    let end = bytes.len() as u32;
    bytes[place..place + 4].copy_from_slice(&end.to_le_bytes());
    bytes.extend(&strip);
    (bytes, length)
}

#[test]
fn deflated_strips_of_a_tiff_are_whole_and_its_directories_lead_somewhere_or_are_refused() {
    let (bytes, _) = deflated_tiff();
    opened("strip.tif", &bytes).expect("whole");
    (1..7).for_each(|cut| refused("strip.tif", &bytes[..bytes.len() - cut], "ends before its picture data does"));
    let long = 4;
    let mut bytes = directory(&[(256, long, 1, 4)], 0);
    let next = bytes.len() - 4;
    bytes[next..].copy_from_slice(&8u32.to_le_bytes());
    refused("circle.tif", &bytes, "back to itself");
    bytes[next..].copy_from_slice(&9999u32.to_le_bytes());
    refused("beyond.tif", &bytes, "beyond its end");
    (8..bytes.len()).for_each(|cut| refused("cut.tif", &bytes[..cut], ""));
    // Many entries that share a long place.
    let many = vec![(50000, 1, 1 << 20, 8); 4000];
    refused("shared.tif", &directory(&many, 1 << 21), "far more than the file holds");
    refused("place.tif", &directory(&[(256, long, 1, 4), (50000, 1, 9, 500)], 400), "tag 50000 begin at byte 500");
}
