//! ROS 2 bags in SQLite (`.db3`): a table of topics, and one of messages. The file is taken as one that nobody writes.

use super::records::{Channel, Message, Wire, Work};
use crate::{error::one_line, files, plane::memory};
use rusqlite::{Connection, limits::Limit};
use std::io;
use std::path::{Path, PathBuf};
use std::{collections::BTreeMap, sync::Arc};

/// Largest number of topics that are looked at, and of characters of a name.
const MAX_TOPICS: usize = 4096;
const MAX_NAME: usize = 4096;
/// SQLite instructions between two checks of the budget.
const EACH: u64 = 1000;

fn connection(path: &Path, work: &Arc<Work>) -> rusqlite::Result<Connection> {
    // No value is longer than its file; the most is SQLite's own limit.
    let longest = std::fs::metadata(path).map_or(0, |file| file.len()).clamp(1 << 20, 1_000_000_000) as i32;
    let mut connection = files::open_database(path)?;
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, longest)?;
    let work = work.clone();
    connection.progress_handler(EACH as i32, Some(move || work.step(EACH).is_err()))?;
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

/// Note on a recorder that still writes, or was killed, beside the database; an error in the middle of a write.
pub(super) fn beside(path: &Path) -> io::Result<Option<String>> {
    let named = |ending: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    let start_of =
        |ending| files::open(&named(ending)).and_then(|file| files::next_bytes(file, 33)).unwrap_or_default();
    // A journal whose write was finished is empty, or begins with zeros.
    if start_of("-journal").starts_with(b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7") {
        let reason = "a write into it was not finished, as the journal beside it ('-journal') says; stop the recorder, or \
                      open and close the file once with sqlite3, which takes the write back";
        return Err(io::Error::new(io::ErrorKind::Unsupported, reason));
    }
    // The header alone has 32 bytes.
    let is_left = start_of("-wal").len() > 32;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(is_left.then(|| format!(
        "messages in '{name}-wal' beside it are not read; stop the recorder, or open and close '{name}' once with sqlite3, \
         which takes them in"
    )))
}

fn asked<T>(path: &Path, work: &Arc<Work>, ask: impl FnOnce(Connection) -> rusqlite::Result<T>) -> io::Result<T> {
    connection(path, work).and_then(ask).map_err(|e| match (work.step(EACH), e.sqlite_error_code()) {
        // An interrupted query is reported with the reason of the interruption.
        (Err(reason), _) => reason,
        (_, Some(rusqlite::ErrorCode::OutOfMemory)) => io::ErrorKind::OutOfMemory.into(),
        _ => io::Error::other(e),
    })
}

pub(super) fn channels(path: &Path, work: &Arc<Work>) -> io::Result<BTreeMap<u32, Channel>> {
    // Views and generated columns could compute for ever, so stored tables alone are accepted.
    let stored = "SELECT count(*), coalesce(sum((SELECT count(*) FROM pragma_table_xinfo(s.name) WHERE hidden > 0)), 0) \
                  FROM sqlite_schema AS s WHERE name IN ('topics', 'messages') AND type = 'table' AND rootpage > 0";
    let stored: (i64, i64) =
        asked(path, work, |connection| connection.query_row(stored, [], |row| Ok((row.get(0)?, row.get(1)?))))?;
    if stored != (2, 0) {
        let reason = "it has no tables 'topics' and 'messages' of stored columns alone, as ROS 2 records them";
        return Err(io::Error::new(io::ErrorKind::Unsupported, reason));
    }
    asked(path, work, |connection| {
        let mut topics = connection.prepare(&format!(
            "SELECT id, substr(name, 1, {MAX_NAME}), substr(type, 1, {MAX_NAME}), serialization_format = 'cdr' \
             FROM topics ORDER BY id LIMIT {MAX_TOPICS}"
        ))?;
        let topics = topics.query_map([], |row| {
            let (name, of): (String, String) = (row.get(1)?, row.get(2)?);
            Ok((
                row.get(0)?,
                Channel::new(one_line(&name), &one_line(&of), row.get::<_, bool>(3)?.then_some(Wire::Cdr)),
            ))
        })?;
        let mut channels: BTreeMap<u32, Channel> = topics.collect::<rusqlite::Result<_>>()?;
        // One pass over the messages for all topics.
        let mut counts = connection.prepare("SELECT topic_id, count(*) FROM messages GROUP BY topic_id")?;
        for count in counts.query_map([], |row| Ok((row.get::<_, u32>(0)?, row.get::<_, i64>(1)?)))? {
            let (id, count) = count?;
            if let Some(channel) = channels.get_mut(&id) {
                channel.count = count.unsigned_abs();
            }
        }
        Ok(channels)
    })
}

pub(super) fn messages(path: &Path, id: u32, most: u64, work: &Arc<Work>) -> io::Result<Vec<Message>> {
    asked(path, work, |connection| {
        let mut rows =
            connection.prepare("SELECT id, timestamp FROM messages WHERE topic_id = ?1 ORDER BY timestamp LIMIT ?2")?;
        let message = |row: &rusqlite::Row<'_>| {
            let (at, recorded): (i64, i64) = (row.get(0)?, row.get(1)?);
            Ok(Message { recorded_ns: recorded.max(0).unsigned_abs(), chunk: 0, at: at.cast_unsigned() })
        };
        rows.query_map((id, most.cast_signed()), message)?.collect::<rusqlite::Result<_>>()
    })
}

pub(super) fn bytes(path: &Path, row: u64, most: u64, work: &Arc<Work>) -> io::Result<Vec<u8>> {
    let message = "SELECT substr(data, 1, ?2) FROM messages WHERE id = ?1";
    asked(path, work, |connection| {
        connection.query_row(message, (row.cast_signed(), most.cast_signed()), |row| {
            let stored = row.get_ref(0)?.as_blob()?;
            // Room that the system may refuse.
            let mut bytes = memory::with_capacity(stored.len());
            bytes.extend_from_slice(stored);
            Ok(bytes)
        })
    })
}
