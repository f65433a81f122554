//! MCAP: records of a kind, a length and fields. Messages stand alone or in chunks, each of which is followed by the
//! lists of its messages; schemas and channels, which say type and topic, are repeated at the end.
//!
//! Format: <https://mcap.dev/spec>.

use super::records::{Channel, Checksum, Chunk, Contents, List, Message, Scan, Wire, corrupt};
use std::io::{self, Read, Seek};

/// Bytes before the first record, and after the last.
const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
pub(super) const START: u64 = 8;
const FOOTER: u8 = 2;
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const LIST: u8 = 7;
const DATA_END: u8 = 15;
/// Bytes of a message's record before the message: channel, number, and two times.
const BEFORE_MESSAGE: u64 = 22;
/// Bytes of a chunk's record before the name of its compression: two times, a size and a checksum.
const BEFORE_PACKING: u64 = 28;

pub(super) fn walk<R: Read + Seek>(mut scan: Scan<'_, R>, chunk: usize, found: &mut Contents) -> io::Result<()> {
    found.is_open |= chunk == 0 && !scan.ends_with(MAGIC)?;
    while scan.goes_on()? {
        let at = scan.at;
        let [kind] = scan.array()?;
        let bytes = scan.u64()?;
        // Of a chunk that was being written the whole messages are taken, where it is not packed.
        if kind == CHUNK && chunk == 0 && found.is_open && scan.after(bytes).is_err() {
            scan.skip_to(scan.at + BEFORE_PACKING)?;
            if scan.text()?.is_empty() {
                scan.u64()?;
                continue;
            }
        }
        let end = scan.after(bytes)?;
        match kind {
            // Without a footer the loop ends, and the file is reported as cut off.
            FOOTER if chunk == 0 => {
                let (from, _offsets, crc) = (scan.u64()?, scan.u64()?, scan.u32()?);
                let checksum = Checksum { from, to: scan.at - 4, crc };
                // The format writes 0 for a checksum that was not computed, and for the start of a missing summary.
                found.summary_checksum = Some(checksum).filter(|sum| sum.crc != 0 && (1..=at).contains(&sum.from));
                scan.skip_to(end)?;
                return if &scan.array()? == MAGIC {
                    Ok(())
                } else {
                    Err(corrupt("it does not end as such a file does"))
                };
            }
            DATA_END if chunk == 0 => {
                let checksum = Checksum { from: 0, to: at, crc: scan.u32()? };
                found.data_checksum = Some(checksum).filter(|sum| sum.crc != 0);
            }
            SCHEMA => {
                let id = scan.u16()?;
                let name = scan.text()?;
                // The summary repeats schemas and channels: the first of each counts.
                found.schemas.entry(id).or_insert(name);
            }
            CHANNEL => {
                let (id, schema) = (scan.u16()?, scan.u16()?);
                let (topic, encoding) = (scan.text()?, scan.text()?);
                let wire = [("ros1", Wire::Ros1), ("cdr", Wire::Cdr)].into_iter().find(|(name, _)| *name == encoding);
                let of = found.schemas.get(&schema).map_or("", |name| name);
                let channel = Channel::new(topic, of, wire.map(|(_, wire)| wire));
                found.channels.entry(id.into()).or_insert(channel);
            }
            MESSAGE => {
                let (channel, _number, recorded_ns) = (scan.u16()?, scan.u32()?, scan.u64()?);
                found.add(channel.into(), Message { recorded_ns, chunk, at });
            }
            CHUNK if chunk == 0 => {
                let (_begins, _ends, size, crc) = (scan.u64()?, scan.u64()?, scan.u64()?, scan.u32()?);
                let packed_by = scan.text()?;
                let bytes = scan.u64()?;
                if scan.after(bytes)? > end {
                    return Err(corrupt("a chunk (the field 'records') is longer than its record"));
                }
                found.chunks.push(Chunk { at: scan.at, bytes, size, packed_by, crc });
            }
            LIST if chunk == 0 => {
                let (channel, bytes) = (scan.u16()?.into(), scan.u32()?.into());
                if scan.after(bytes)? > end {
                    return Err(corrupt("a list of messages (the field 'records') is longer than its record"));
                }
                // An entry is a time and an offset of 8 bytes each.
                found.lists.push(List { channel, chunk: found.chunks.len() - 1, at: scan.at, count: bytes / 16 });
            }
            _ => {}
        }
        scan.skip_to(end)?;
    }
    if chunk > 0 { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

/// Time (ns) and offset of the next entry of a list of messages.
pub(super) fn entry(scan: &mut Scan<'_, impl Read + Seek>) -> io::Result<(u64, u64)> {
    Ok((scan.u64()?, scan.u64()?))
}

/// Length of the next record's message, bytes; moves `scan` to the message's first byte.
pub(super) fn message(scan: &mut Scan<'_, impl Read + Seek>) -> io::Result<u64> {
    let [kind] = scan.array()?;
    let bytes = scan.u64()?.checked_sub(BEFORE_MESSAGE).filter(|_| kind == MESSAGE);
    let bytes = bytes.ok_or_else(|| corrupt("a list of messages names a place where there is none"))?;
    scan.skip_to(scan.at + BEFORE_MESSAGE)?;
    Ok(bytes)
}
