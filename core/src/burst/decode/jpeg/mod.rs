//! Check of whether the picture data of a JPEG is complete.
//!
//! The decoder fills in missing data without an error. So the file is read here once more, without computing a pixel:
//! its markers are followed to the end of the picture (EOI), and every Huffman code of every scan is read. Data that
//! ends before its last block, that holds a code of no table, or that lacks a scan, is damage. Bytes after the end of
//! the picture are allowed: cameras put films and second pictures there.

mod scan;

use scan::{Component, Frame, Scan, Table};

/// Result of reading a JPEG without decoding it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Soundness {
    /// All data is there.
    Whole,
    /// The decoder would make up a part of the picture; the reason.
    Damaged(String),
    /// Of a kind that is not read here (arithmetic coding, lossless, 12 bit): left to the decoder.
    Unknown,
}

/// Reads the JPEG `bytes`, which begin with its start marker. `tables` are the segments of a file that stores them
/// separately, as TIFF does; usually empty.
pub(super) fn soundness(bytes: &[u8], tables: &[u8]) -> Soundness {
    let mut reader = Reader::default();
    if !tables.is_empty() {
        // Tables alone have no picture and may lack their end marker.
        let _ = reader.read(tables);
    }
    match reader.read(bytes) {
        Ok(()) if reader.unknown => Soundness::Unknown,
        Ok(()) => Soundness::Whole,
        Err(_) if reader.unknown => Soundness::Unknown,
        Err(reason) => Soundness::Damaged(reason),
    }
}

/// State of the reading: the segments so far.
#[derive(Debug, Default)]
struct Reader {
    dc_tables: [Option<Table>; 4],
    ac_tables: [Option<Table>; 4],
    /// Number of minimum coded units between restart markers; 0 for none.
    restart_interval: usize,
    frame: Option<Frame>,
    scans: usize,
    /// Whether the file uses a feature that is not read here.
    unknown: bool,
}

/// Number of scans above which a file is left to the decoder, which refuses it: many scans of few bytes would take
/// long.
const MAX_SCANS: usize = 100;
const TOO_EARLY: &str = "it ends too early";

impl Reader {
    /// Follows the markers to the end of the picture.
    fn read(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut at = 2; // the start marker
        loop {
            let (marker, next) = marker_from(bytes, at).ok_or("its end marker is missing: it is cut off")?;
            at = next;
            match marker {
                0xd9 => break,
                0x01 | 0xd0..=0xd8 => continue, // no segment follows
                _ => {}
            }
            let length = bytes.get(at..at + 2).map(|b| usize::from(u16::from_be_bytes([b[0], b[1]])));
            let end = at + length.ok_or(TOO_EARLY)?.max(2);
            let segment = bytes.get(at + 2..end).ok_or(TOO_EARLY)?;
            at = end;
            match marker {
                0xc4 => self.read_huffman_tables(segment)?,
                0xc0..=0xc2 => self.read_frame(segment, marker == 0xc2)?,
                // Lossless, differential and arithmetic kinds; a number of lines that follows the scan.
                0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf | 0xdc => self.unknown = true,
                0xdd => {
                    let interval = segment.first_chunk::<2>().ok_or(TOO_EARLY)?;
                    self.restart_interval = usize::from(u16::from_be_bytes(*interval));
                }
                0xda => at = self.read_scan(segment, bytes, at)?,
                _ => {}
            }
            if self.unknown {
                return Ok(());
            }
        }
        match &self.frame {
            Some(frame) => frame.check_complete(),
            None => Err("it holds no picture".to_owned()),
        }
    }

    fn read_huffman_tables(&mut self, mut segment: &[u8]) -> Result<(), String> {
        while let [class_and_slot, rest @ ..] = segment {
            let counts = rest.first_chunk::<16>().ok_or("a table of codes is cut off")?;
            let total = counts.iter().map(|&n| usize::from(n)).sum::<usize>();
            let values = rest.get(16..16 + total).ok_or("a table of codes is cut off")?;
            let table = Table::new(counts, values).ok_or("a table of codes is damaged")?;
            let tables = if class_and_slot >> 4 == 0 { &mut self.dc_tables } else { &mut self.ac_tables };
            let slot = tables.get_mut(usize::from(class_and_slot & 15)).ok_or("a table of codes is damaged")?;
            *slot = Some(table);
            segment = &rest[16 + total..];
        }
        Ok(())
    }

    fn read_frame(&mut self, segment: &[u8], progressive: bool) -> Result<(), String> {
        let [bits, h1, h0, w1, w0, count, components @ ..] = segment else { return Err(TOO_EARLY.to_owned()) };
        let (width, height) = (u16::from_be_bytes([*w1, *w0]), u16::from_be_bytes([*h1, *h0]));
        let (components, _) = components.as_chunks::<3>();
        let components = components.iter().take(usize::from(*count));
        let components: Vec<Component> =
            components.map(|[id, sampling, _]| Component::new(*id, sampling >> 4, sampling & 15)).collect();
        // A height of 0 means that it follows the scan. Files that the decoder refuses are left to its own error.
        let read_here = *bits == 8
            && width > 0
            && height > 0
            && self.frame.is_none()
            && components.len() == usize::from(*count)
            && (1..=4).contains(&components.len())
            && components.iter().all(Component::is_possible);
        if !read_here {
            self.unknown = true;
            return Ok(());
        }
        self.frame = Some(Frame::new((width.into(), height.into()), components, progressive));
        Ok(())
    }

    /// Reads the scan whose header is `segment` and whose data begins at `start`; returns the position of its end.
    fn read_scan(&mut self, segment: &[u8], bytes: &[u8], start: usize) -> Result<usize, String> {
        self.scans += 1;
        if self.scans > MAX_SCANS {
            self.unknown = true;
            return Ok(start);
        }
        let frame = self.frame.as_mut().ok_or("its picture data comes before its size")?;
        let [count, rest @ ..] = segment else { return Err(TOO_EARLY.to_owned()) };
        let count = usize::from(*count);
        let (Some(selectors), Some([first, last, precision])) =
            (rest.get(..2 * count), rest.get(2 * count..2 * count + 3))
        else {
            return Err(TOO_EARLY.to_owned());
        };
        let mut chosen = Vec::with_capacity(count);
        for pair in selectors.chunks_exact(2) {
            let index = frame.components.iter().position(|c| c.id == pair[0]);
            let index = index.ok_or("a scan is of a component that it does not have")?;
            chosen.push((index, usize::from(pair[1] >> 4 & 3), usize::from(pair[1] & 3)));
        }
        let scan = Scan {
            components: chosen,
            first: usize::from(*first),
            last: usize::from(*last),
            high: precision >> 4,
            low: precision & 15,
            restart_interval: self.restart_interval,
        };
        frame.read_scan(&scan, [&self.dc_tables, &self.ac_tables], bytes, start)
    }
}

/// Next marker from `at` on, and the position after it. Other bytes between segments are skipped, as the decoder does.
fn marker_from(bytes: &[u8], at: usize) -> Option<(u8, usize)> {
    let mut at = at;
    loop {
        at += bytes.get(at..)?.iter().position(|b| *b == 0xff)?;
        at += bytes[at..].iter().take_while(|b| **b == 0xff).count();
        match *bytes.get(at)? {
            0 => at += 1,
            marker => return Some((marker, at + 1)),
        }
    }
}

#[cfg(test)]
mod tests {
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
            // With an end marker added at the cut. The last two bytes are that marker itself. An end within the header
            // of the picture gives a kind that is left to the decoder, which finds no data.
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
}
