//! Lists of pairs to match, as hloc and COLMAP have them: the names of two images a line.

use crate::burst::BurstFiles;
use crate::error::{Error, Result};
use crate::export::safe_file_name;
use crate::files::{MAX_TABLE_BYTES, read_text};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

/// Reads the pairs that the list at `path` names, by the indices in `bursts`: the earlier burst first, each
/// pair once, in order. A name may have the extension of a picture, and spaces; blank lines and those that begin with
/// `#` are skipped.
///
/// # Errors
/// A list that cannot be read or names no pair; a line that does not name two of the bursts, with its number.
pub fn read_pairs(path: &Path, bursts: &[BurstFiles]) -> Result<Vec<(usize, usize)>> {
    let text = read_text(path, MAX_TABLE_BYTES).map_err(|error| Error::unread_file(path, error))?;
    // As they are, and as their pictures are called.
    let forms = |of: &BurstFiles| [safe_file_name(&of.name), of.name.clone()];
    let known = bursts.iter().enumerate().flat_map(|(index, burst)| forms(burst).map(|name| (name, index)));
    let known: HashMap<String, usize> = known.collect();
    let named = |word: &str| known.get(word).or_else(|| known.get(word.rsplit_once('.')?.0)).copied();
    let mut pairs = BTreeSet::new();
    let lines = text.lines().map(str::trim).enumerate();
    for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let at = |(at, _)| Some((named(line[..at].trim_end())?, named(line[at..].trim_start())?));
        let (a, b) = line.match_indices(char::is_whitespace).find_map(at).filter(|(a, b)| a != b).ok_or_else(|| {
            let unknown = line.split_whitespace().find(|word| named(word).is_none()).unwrap_or(line);
            let right: Vec<&str> = bursts.iter().take(2).map(|burst| burst.name.as_str()).collect();
            let problem = format!("this does not name two bursts ({unknown}); right is such as: {}", right.join(" "));
            Error::in_line(path, number + 1, &problem)
        })?;
        pairs.insert((a.min(b), a.max(b)));
    }
    if pairs.is_empty() { Err(Error::unread_file(path, "it names no pair")) } else { Ok(pairs.into_iter().collect()) }
}
