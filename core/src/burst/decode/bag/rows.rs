//! ROS 2 bags in SQLite (`.db3`): a table of topics, and one of messages. The file is taken as one that nobody writes.

use super::records::{Channel, Message, Wire};
use rusqlite::{Connection, OpenFlags};
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Largest number of topics that are looked at, and of characters of a name.
const MAX_TOPICS: usize = 4096;
const MAX_NAME: usize = 4096;

fn connection(path: &Path) -> rusqlite::Result<Connection> {
    let kept = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-:".contains(&byte);
    let path = path.as_os_str().as_encoded_bytes();
    let escaped = |byte: &u8| if kept(*byte) { char::from(*byte).to_string() } else { format!("%{byte:02x}") };
    let path: String = path.iter().map(escaped).collect();
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(format!("file:{path}?immutable=1"), flags)?;
    connection.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;")?;
    Ok(connection)
}

/// Checks that a database of `length` bytes that begins with `start` is whole: what is missing would be read as zeros.
pub(super) fn check_length(start: &[u8], length: u64) -> io::Result<()> {
    let page = start.get(16..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| u64::from(u16::from_be_bytes(*bytes)));
    let pages = start.get(28..).and_then(<[u8]>::first_chunk).map_or(1, |bytes| u64::from(u32::from_be_bytes(*bytes)));
    // The size 65536 is written as 1.
    if length < pages * if page == 1 { 1 << 16 } else { page } {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(())
}

/// The topics by their numbers.
pub(super) fn channels(path: &Path) -> io::Result<BTreeMap<u32, Channel>> {
    let connection = connection(path).map_err(io::Error::other)?;
    // A view could compute for ever.
    let tables = "SELECT count(*) FROM sqlite_schema WHERE name IN ('topics', 'messages') AND type = 'table'";
    let tables: i64 = connection.query_row(tables, [], |row| row.get(0)).map_err(io::Error::other)?;
    if tables != 2 {
        let reason = "it has no tables 'topics' and 'messages', as ROS 2 records them";
        return Err(io::Error::new(io::ErrorKind::Unsupported, reason));
    }
    let read = || {
        let mut topics = connection.prepare(&format!(
            "SELECT id, substr(name, 1, {MAX_NAME}), substr(type, 1, {MAX_NAME}), serialization_format = 'cdr' \
             FROM topics ORDER BY id LIMIT {MAX_TOPICS}"
        ))?;
        let topics = topics.query_map([], |row| {
            let (name, of): (String, String) = (row.get(1)?, row.get(2)?);
            Ok((row.get(0)?, Channel::new(name, &of, row.get::<_, bool>(3)?.then_some(Wire::Cdr))))
        })?;
        let mut channels: BTreeMap<u32, Channel> = topics.collect::<rusqlite::Result<_>>()?;
        let mut counts = connection.prepare("SELECT topic_id, count(*) FROM messages GROUP BY topic_id")?;
        for count in counts.query_map([], |row| Ok((row.get::<_, u32>(0)?, row.get::<_, i64>(1)?)))? {
            let (id, count) = count?;
            if let Some(channel) = channels.get_mut(&id) {
                channel.count = count.unsigned_abs();
            }
        }
        Ok(channels)
    };
    read().map_err(|e: rusqlite::Error| io::Error::other(e))
}

/// The first `most` messages of the topic with the number `id`.
pub(super) fn messages(path: &Path, id: u32, most: u64) -> io::Result<Vec<Message>> {
    let read = || {
        let connection = connection(path)?;
        let mut rows =
            connection.prepare("SELECT id, timestamp FROM messages WHERE topic_id = ?1 ORDER BY timestamp LIMIT ?2")?;
        let message = |row: &rusqlite::Row<'_>| {
            let (at, recorded): (i64, i64) = (row.get(0)?, row.get(1)?);
            Ok(Message { recorded_ns: recorded.max(0).unsigned_abs(), chunk: 0, at: at.cast_unsigned() })
        };
        rows.query_map((id, most.cast_signed()), message)?.collect::<rusqlite::Result<_>>()
    };
    read().map_err(|e: rusqlite::Error| io::Error::other(e))
}

/// The first bytes of the message in the row `row`, at most `most`.
pub(super) fn bytes(path: &Path, row: u64, most: u64) -> io::Result<Vec<u8>> {
    let read = || {
        let message = "SELECT substr(data, 1, ?2) FROM messages WHERE id = ?1";
        connection(path)?.query_row(message, (row.cast_signed(), most.cast_signed()), |row| row.get(0))
    };
    read().map_err(|e: rusqlite::Error| io::Error::other(e))
}
