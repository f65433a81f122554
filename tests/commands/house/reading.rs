//! Reads the workspace's own code: its files, and the modules that each of them uses.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Finds the Rust files below `folder`.
pub fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// Code of a file without comments and without its tests, which may use anything.
pub fn code(text: &str) -> String {
    let tests = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
    text[..tests].lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Top-level modules ("rooms") that follow `crate::` in `code`, also those in braces.
pub fn rooms_used(code: &str) -> BTreeSet<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut rooms = BTreeSet::new();
    for (place, _) in code.match_indices("crate::") {
        let rest = &code[place + "crate::".len()..];
        match rest.strip_prefix('{') {
            // Only the outer names of a group matter.
            Some(group) => {
                let mut depth = 0;
                let mut start = true;
                for (at, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => start = true,
                        c if start && !c.is_whitespace() => {
                            rooms.insert(word(&group[at..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
            None => {
                rooms.insert(word(rest));
            }
        }
    }
    rooms
}

/// Rust files of both packages, each with its path below its package's `src`. No top-level module is in both.
pub fn files() -> Vec<(PathBuf, PathBuf)> {
    let mut both = Vec::new();
    for folder in ["src", "core/src"] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let mut files = Vec::new();
        sources(&root, &mut files);
        both.extend(files.into_iter().map(|path| (path.strip_prefix(&root).expect("below").to_owned(), path)));
    }
    both
}

/// Files of both packages by their module's path, without their tests. The program re-exports the library's modules, so
/// `crate::` leads to a module of either.
pub fn modules() -> BTreeMap<Vec<String>, String> {
    let mut modules = BTreeMap::new();
    for (name, path) in files() {
        let name = name.with_extension("");
        let mut parts: Vec<String> = name.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        match parts.last().map(String::as_str) {
            Some("tests" | "lib" | "main") => continue,
            Some("mod") => drop(parts.pop()),
            _ => {}
        }
        modules.insert(parts, code(&std::fs::read_to_string(&path).expect("text")));
    }
    modules
}

/// Paths of a `use` tree, written out.
pub fn paths_of(tree: &str, before: &[&str], into: &mut Vec<Vec<String>>) {
    let (mut depth, mut start) = (0, 0);
    let mut branches = Vec::new();
    for (at, c) in tree.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                branches.push(&tree[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    branches.push(&tree[start..]);
    for branch in branches.into_iter().map(str::trim).filter(|branch| !branch.is_empty()) {
        let (path, group) = branch.split_once('{').map_or((branch, None), |(path, group)| (path, Some(group)));
        let path = path.split(" as ").next().expect("a path");
        let parts: Vec<&str> =
            before.iter().copied().chain(path.split("::").map(str::trim)).filter(|p| !p.is_empty()).collect();
        match group {
            Some(group) => paths_of(&group[..group.rfind('}').unwrap_or(group.len())], &parts, into),
            None => into.push(parts.into_iter().map(str::to_owned).collect()),
        }
    }
}

#[test]
fn uses_are_read_in_every_way_they_are_written() {
    let text = "use crate::plane::{Plane, x};\nuse crate::{burst::{Burst, Open}, monitor::Monitor, Plane};\nfn f(x: crate::detector::Slope) {}\n\
        // crate::app is a comment\n#[cfg(test)]\nmod tests {\n    use crate::synth::chart;\n}\n";
    let rooms: Vec<String> = rooms_used(&code(text)).into_iter().collect();
    assert_eq!(rooms, ["Plane", "burst", "detector", "monitor", "plane"]);
}
