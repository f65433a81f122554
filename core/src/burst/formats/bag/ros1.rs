//! ROS 1 bags: records of named fields and data. The lists of its messages follow each chunk; connections are repeated.
//!
//! Format: <http://wiki.ros.org/Bags/Format/2.0>.

use super::records::{Channel, Chunk, Contents, List, Message, Scan, Wire, corrupt};
use crate::error::one_line;
use std::io::{self, Read, Seek};

/// Bytes before the version.
pub(super) const START: u64 = 9;
const VERSION: &[u8] = b"2.0\n";

/// Value of a field of a header: its bytes, behind a length, the name and `=`.
fn field<'a>(header: &'a [u8], name: &str) -> Option<&'a [u8]> {
    let mut rest = header;
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let (field, behind) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        if let Some(value) = field.strip_prefix(name.as_bytes()).and_then(|value| value.strip_prefix(b"=")) {
            return Some(value);
        }
        rest = behind;
    }
    None
}

fn text(header: &[u8], name: &str) -> io::Result<String> {
    let value = field(header, name).ok_or_else(|| corrupt(format!("a record has no field '{name}'")))?;
    Ok(one_line(&String::from_utf8_lossy(value)))
}

fn number(header: &[u8], name: &str) -> io::Result<u32> {
    let value = field(header, name).and_then(|value| value.try_into().ok()).map(u32::from_le_bytes);
    value.ok_or_else(|| corrupt(format!("a record has no field '{name}' of four bytes")))
}

fn time_ns([s, ns]: [u32; 2]) -> u64 {
    u64::from(s) * 1_000_000_000 + u64::from(ns)
}

pub(super) fn walk<R: Read + Seek>(mut scan: Scan<'_, R>, chunk: usize, found: &mut Contents) -> io::Result<()> {
    if chunk == 0 && scan.array::<4>()? != VERSION {
        return Err(io::Error::new(io::ErrorKind::Unsupported, "its version is not 2.0; record it again"));
    }
    // Each chunk is named in a record at the end of a bag that was closed.
    let (mut announced, mut named) = (0, 0);
    while scan.goes_on()? {
        let at = scan.at;
        let header = scan.field()?;
        let bytes = scan.u32()?.into();
        let (data, end) = (scan.at, scan.after(bytes)?);
        // 2 message, 3 bag header, 4 list of a chunk's messages, 5 chunk, 6 summary of a chunk, 7 connection.
        match field(&header, "op") {
            Some([2]) => {
                let time = field(&header, "time").and_then(|time| time.first_chunk::<8>());
                let [a, b, c, d, e, f, g, h] = *time.ok_or_else(|| corrupt("a message has no field 'time'"))?;
                let recorded_ns = time_ns([[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes));
                found.add(number(&header, "conn")?, Message { recorded_ns, chunk, at });
            }
            Some([3]) => {
                announced = number(&header, "chunk_count")?;
                // The place of the index is written when a bag is closed.
                found.is_open |= announced == 0 && field(&header, "index_pos").is_some_and(|at| at == [0; 8]);
            }
            Some([4]) => {
                let (channel, count) = (number(&header, "conn")?, u64::from(number(&header, "count")?));
                // An entry is a time of 8 bytes and an offset of 4.
                if count * 12 > bytes {
                    return Err(corrupt("a list of messages (the field 'count') is longer than its record"));
                }
                found.lists.push(List { channel, chunk: found.chunks.len() - 1, at: data, count });
            }
            Some([5]) if chunk == 0 => {
                let packed_by = Some(text(&header, "compression")?).filter(|name| name != "none").unwrap_or_default();
                let size = number(&header, "size")?.into();
                // A chunk has its length when it is whole; until then its messages follow as they are, or packed.
                if found.is_open && bytes == 0 {
                    if packed_by.is_empty() {
                        continue;
                    }
                    break;
                }
                found.chunks.push(Chunk { at: data, bytes, size, packed_by, crc: 0 });
            }
            Some([6]) => named += 1,
            Some([7]) => {
                let topic = text(&header, "topic")?;
                let of = text(&scan.bytes(bytes)?, "type")?;
                let channel = || Channel::new(topic, &of, Some(Wire::Ros1));
                found.channels.entry(number(&header, "conn")?).or_insert_with(channel);
            }
            _ => {}
        }
        scan.skip_to(end)?;
    }
    if chunk == 0 && found.is_open {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    // A closed bag announces its chunks twice; `chunks` also holds the file itself.
    if chunk == 0 && (announced != named || found.chunks.len() as u64 != 1 + u64::from(named)) {
        return Err(corrupt("it was not closed, or its end is missing"));
    }
    Ok(())
}

/// Time (ns) and offset of the next entry of a list of messages.
pub(super) fn entry(scan: &mut Scan<'_, impl Read + Seek>) -> io::Result<(u64, u64)> {
    Ok((time_ns([scan.u32()?, scan.u32()?]), scan.u32()?.into()))
}

/// Length of the next record's message, bytes; moves `scan` to the message's first byte.
pub(super) fn message(scan: &mut Scan<'_, impl Read + Seek>) -> io::Result<u64> {
    if field(&scan.field()?, "op") != Some(&[2]) {
        return Err(corrupt("a list of messages names a place where there is none"));
    }
    scan.u32().map(u64::from)
}
