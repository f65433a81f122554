//! Keys that nobody knows, wherever in a file they are.
//!
//! Many values of a session are also kept in the window's settings, where what a newer program has added must not make
//! all the rest unreadable. So it is whoever reads a file that says whether an unknown key is a mistake, not the
//! values.

use serde::de::DeserializeOwned;

/// Reads TOML, and tells the unknown keys beside what was read: each as the path to it, `pair.links.vews`. Values that
/// refuse unknown keys by themselves fail at once, and name the key and its place.
pub(super) fn read_noting_unknown_keys<T: DeserializeOwned>(text: &str) -> Result<(T, Vec<String>), toml::de::Error> {
    let mut unknown = Vec::new();
    let value = serde_ignored::deserialize(toml::Deserializer::parse(text)?, |path| unknown.push(path.to_string()))?;
    Ok((value, unknown))
}
