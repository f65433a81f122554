//! Complete pictures are recognised, and cut ones are not, wherever they are cut.

use super::*;
use proptest::prelude::*;

/// Colour pictures of 45×37: progressive and not, halved colours, restart markers, a scan for each component.
const SAMPLES: [(&str, &[u8]); 4] = [
    ("progressive", include_bytes!("samples/progressive.jpg")),
    ("restarts", include_bytes!("samples/restarts.jpg")),
    ("progressive with restarts", include_bytes!("samples/progressive_restarts.jpg")),
    ("a scan for each component", include_bytes!("samples/one_scan_each.jpg")),
];
const END: [u8; 2] = [0xff, 0xd9];

fn is_damaged(bytes: &[u8]) -> bool {
    matches!(soundness(bytes, &[]), Soundness::Damaged(_))
}

#[test]
fn sound_pictures_are_whole_and_cut_ones_damaged_wherever_they_are_cut() {
    for (name, bytes) in SAMPLES {
        assert_eq!(soundness(bytes, &[]), Soundness::Whole, "{name}");
        for cut in 2..bytes.len() {
            assert!(is_damaged(&bytes[..cut]), "{name} cut at {cut} of {}", bytes.len());
        }
        // With an end marker added at the cut. The last two bytes are that marker itself. An end within the header of
        // the picture gives a kind that is left to the decoder, which finds no data.
        for cut in 2..bytes.len() - 3 {
            let cut_and_ended = [&bytes[..cut], &END].concat();
            let is_left = matches!(soundness(&cut_and_ended, &[]), Soundness::Unknown);
            assert!(
                is_damaged(&cut_and_ended) || is_left && cut < 200,
                "{name} cut at {cut} of {} and ended",
                bytes.len()
            );
        }
    }
}

#[test]
fn what_follows_the_end_is_nobodys() {
    let (_, bytes) = SAMPLES[0];
    let two = [bytes, bytes, b"film"].concat();
    assert_eq!(soundness(&two, &[]), Soundness::Whole);
}

#[test]
fn a_part_that_is_missing_between_two_restart_markers_is_damage() {
    let (_, bytes) = SAMPLES[1];
    let is_restart = |at: &usize| bytes[*at] == 0xff && (0xd0..=0xd7).contains(&bytes[at + 1]);
    let places: Vec<usize> = (0..bytes.len() - 1).filter(is_restart).collect();
    assert!(places.len() > 4, "{places:?}");
    // The decoder would fill in from the next marker on.
    let shorter = [&bytes[..places[1]], &bytes[places[2]..]].concat();
    assert!(is_damaged(&shorter));
    let emptied = [&bytes[..places[1] + 4], &bytes[places[2]..]].concat();
    assert!(is_damaged(&emptied));
}

#[test]
fn scans_that_are_missing_are_damage() {
    let (_, bytes) = SAMPLES[3];
    let scans: Vec<usize> = (0..bytes.len() - 1).filter(|at| bytes[*at..].starts_with(&[0xff, 0xda])).collect();
    assert_eq!(scans.len(), 3);
    let Soundness::Damaged(reason) = soundness(&[&bytes[..scans[2]], &END].concat(), &[]) else {
        panic!("two of three components are no picture");
    };
    assert_eq!(reason, "a scan is missing");
}

#[test]
fn kinds_that_are_not_read_here_are_left_to_the_decoder() {
    let arithmetic: &[u8] = include_bytes!("samples/arithmetic.jpg");
    assert_eq!(soundness(arithmetic, &[]), Soundness::Unknown);
    // Twelve bits.
    let (_, bytes) = SAMPLES[1];
    let mut twelve = bytes.to_vec();
    let frame = (0..bytes.len()).find(|at| bytes[*at..].starts_with(&[0xff, 0xc0])).expect("a frame");
    twelve[frame + 4] = 12;
    assert_eq!(soundness(&twelve, &[]), Soundness::Unknown);
}

#[test]
fn tables_may_stand_apart() {
    let (_, bytes) = SAMPLES[1];
    let is_table = |marker: u8| matches!(marker, 0xc4 | 0xdb);
    let (mut tables, mut rest, mut at) = (bytes[..2].to_vec(), bytes[..2].to_vec(), 2);
    while bytes[at + 1] != 0xda {
        let end = at + 2 + usize::from(u16::from_be_bytes([bytes[at + 2], bytes[at + 3]]));
        let to = if is_table(bytes[at + 1]) { &mut tables } else { &mut rest };
        to.extend(&bytes[at..end]);
        at = end;
    }
    rest.extend(&bytes[at..]);
    tables.extend(END);
    assert!(is_damaged(&rest));
    assert_eq!(soundness(&rest, &tables), Soundness::Whole);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.max(400), ..ProptestConfig::default() })]

    /// Any answer will do; a panic, a loop without end and memory beyond the file's own measure will not.
    #[test]
    fn damaged_jpegs_are_looked_through(
        sample in 0..SAMPLES.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<Option<prop::sample::Index>>(),
    ) {
        let mut bytes = SAMPLES[sample].1.to_vec();
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        soundness(&bytes, &[]);
        soundness(&bytes, SAMPLES[0].1);
    }
}
