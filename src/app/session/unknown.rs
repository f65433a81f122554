//! Unknown keys, at any depth of a TOML file.
//!
//! Many values of a session are also part of the window's settings, where keys added by a newer version must not make
//! the rest unreadable. So the reader of a file decides whether an unknown key is an error, not the types of the
//! values.

use serde::de::DeserializeOwned;

/// Reads a value from TOML, and lists the unknown keys, each as a path: `pair.links.vews`. Types that deny unknown keys
/// themselves fail at once; the error names the key and its place.
pub(super) fn read_noting_unknown_keys<T: DeserializeOwned>(text: &str) -> Result<(T, Vec<String>), toml::de::Error> {
    let mut unknown = Vec::new();
    let value = serde_ignored::deserialize(toml::Deserializer::parse(text)?, |path| unknown.push(path.to_string()))?;
    Ok((value, unknown))
}
