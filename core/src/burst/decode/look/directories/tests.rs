//! Directories as in real files, and damaged ones.

use super::*;
use proptest::prelude::*;
use std::io::Cursor;

const LONG: u16 = 4;

/// TIFF of one directory after `before` bytes of other data, with entries (tag, type, count, value).
fn tiff(entries: &[(u16, u16, u32, u32)], before: usize) -> Vec<u8> {
    let mut bytes = b"II*\0".to_vec();
    bytes.extend((8 + before as u32).to_le_bytes());
    bytes.resize(8 + before, 7);
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        bytes
            .extend([&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat());
    }
    bytes.extend([0; 4]);
    bytes
}

/// BigTIFF of one directory, most significant byte first.
fn big_tiff(entries: &[(u16, u16, u64, u64)], before: usize) -> Vec<u8> {
    let mut bytes = b"MM\0+\0\x08\0\0".to_vec();
    bytes.extend((16 + before as u64).to_be_bytes());
    bytes.resize(16 + before, 7);
    bytes.extend((entries.len() as u64).to_be_bytes());
    for (tag, kind, count, value) in entries {
        bytes
            .extend([&tag.to_be_bytes()[..], &kind.to_be_bytes(), &count.to_be_bytes(), &value.to_be_bytes()].concat());
    }
    bytes.extend([0; 8]);
    bytes
}

fn read(bytes: &[u8], raw: bool) -> Result<Directories, Refusal> {
    Directories::read(&mut Cursor::new(bytes), bytes.len() as u64, raw, usize::MAX)
}

/// Reason why a file is refused.
fn reason(bytes: &[u8], raw: bool) -> String {
    match read(bytes, raw) {
        Err(Refusal::Corrupt(reason)) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn sizes_and_descriptions_are_read_in_both_forms_and_byte_orders() {
    let little = tiff(&[(256, LONG, 1, 40), (257, LONG, 1, 30), (270, 2, 6, 8)], 6);
    let big = big_tiff(&[(256, LONG, 1, 40 << 32), (257, 3, 1, 30 << 48), (270, 2, 12, 16)], 12);
    for bytes in [little, big] {
        let found = read(&bytes, false).expect("sound");
        assert_eq!((found.pixels(), found.is_dng, found.list.len()), (1200, false, 1));
        let text = found.description(&mut Cursor::new(&bytes), 4);
        assert_eq!(text.as_deref(), Some("\x07\x07\x07\x07"));
    }
}

#[test]
fn counts_beyond_the_file_are_refused() {
    // A file of 226 bytes whose decoder asks for 34 GB.
    for kind in [1, 2, 5, 7, 10, 12, 99] {
        for raw in [true, false] {
            let bytes = tiff(&[(256, LONG, 1, 4), (33434, kind, u32::MAX, 8)], 180);
            let reason = reason(&bytes, raw);
            assert!(reason.contains("4294967295 values") && reason.contains("tag 33434"), "{reason}");
        }
    }
    let reason = reason(&big_tiff(&[(270, 2, 4 << 30, 16)], 10), false);
    assert!(reason.contains("tag 270"), "{reason}");
    // A text that is as long as a long file is too long as well.
    let bytes = tiff(&[(270, 2, 1 << 27, 8)], 0);
    let length = 1 << 30;
    let refused = Directories::read(&mut Cursor::new(&bytes), length, false, 1).expect_err("128 MiB of text");
    assert!(matches!(refused, Refusal::TooLarge { .. }), "{refused:?}");
}

#[test]
fn values_behind_the_end_are_refused_where_somebody_reads_them() {
    let beyond = |tag| tiff(&[(tag, LONG, 9, 100)], 90);
    assert!(reason(&beyond(273), false).contains("it ends before the values of tag 273"));
    // A damaged private tag does not spoil a TIFF; the decoder of raw files reads every tag.
    assert!(read(&beyond(50000), false).is_ok());
    assert!(reason(&beyond(50000), true).contains("tag 50000"));
    // So it is for a DNG, whatever its name.
    let dng = tiff(&[(50000, LONG, 9, 100), (50706, 1, 4, 1)], 60);
    assert!(reason(&dng, false).contains("tag 50000"));
}

#[test]
fn circles_and_places_behind_the_end_are_refused() {
    let mut bytes = tiff(&[(256, LONG, 1, 4)], 0);
    let next = bytes.len() - 4;
    bytes[next..].copy_from_slice(&8u32.to_le_bytes());
    assert!(reason(&bytes, false).contains("back to itself"));
    bytes[next..].copy_from_slice(&9999u32.to_le_bytes());
    assert!(reason(&bytes, false).contains("beyond its end"));
    for cut in 8..bytes.len() {
        assert!(read(&bytes[..cut], false).is_err(), "cut at {cut}");
    }
    // A directory that names itself as its part is read once.
    let own = tiff(&[(330, LONG, 1, 8)], 0);
    assert_eq!(read(&own, true).expect("no circle of pages").list.len(), 1);
    // Many entries that share a long place.
    let many = tiff(&vec![(50000, 1, 1 << 20, 8); 4000], 1 << 20);
    assert!(reason(&many, false).contains("far more than the file holds"));
}

#[test]
fn strips_lie_within_the_file() {
    let check = |offset: u32, length: u32| {
        let bytes = tiff(&[(273, LONG, 1, offset), (279, LONG, 1, length)], 50);
        let found = read(&bytes, true).expect("sound");
        found.check_chunks(&mut Cursor::new(&bytes), bytes.len() as u64)
    };
    assert!(check(8, 50).is_ok());
    assert!(check(8, 5000).is_err() && check(u32::MAX, u32::MAX).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.max(400), ..ProptestConfig::default() })]

    /// Any answer is right; the data that is read and kept is bounded by the file.
    #[test]
    fn damaged_directories_are_looked_through(
        entries in prop::collection::vec((prop_oneof![254..300u16, 320..335u16, Just(34665), Just(50706), any::<u16>()], 0..20u16, prop_oneof![0..9u32, any::<u32>()], prop_oneof![0..300u32, any::<u32>()]), 0..12),
        before in 0..64usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        is_big in any::<bool>(),
        raw in any::<bool>(),
        claimed in prop_oneof![Just(0u64), 0..1u64 << 40],
    ) {
        let mut bytes = if is_big {
            let wide: Vec<_> = entries.iter().map(|&(t, k, c, v)| (t, k, u64::from(c) << (v % 40), u64::from(v) << (c % 40))).collect();
            big_tiff(&wide, before)
        } else {
            tiff(&entries, before)
        };
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        // A file may become shorter between two reads.
        let length = (bytes.len() as u64).max(claimed.min(1 << 20));
        let mut file = Cursor::new(&bytes);
        if let Ok(found) = Directories::read(&mut file, length, raw, usize::MAX) {
            let _ = found.check_chunks(&mut file, length);
            let text = found.description(&mut file, 100);
            prop_assert!(text.is_none_or(|text| text.len() <= 300));
            prop_assert!(found.list.len() <= bytes.len());
        }
    }
}
