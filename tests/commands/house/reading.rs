//! Reads the workspace's own code: its files, and the modules that each of them uses.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

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
    let tests = ["mod", "pub(super) mod", "pub(in crate::app) mod"]
        .map(|word| text.find(&format!("#[cfg(test)]\n{word} tests {{")));
    let tests = tests.into_iter().flatten().next().unwrap_or(text.len());
    text[..tests].lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Beginnings of paths into the own packages.
const ROOTS: [&str; 3] = ["crate::", "burstscope_core::", "burstscope_lab::"];

/// Top-level modules ("rooms") that follow one of [`ROOTS`] in `code`, also those in braces.
pub fn rooms_used(code: &str) -> BTreeSet<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut rooms = BTreeSet::new();
    for (place, root) in ROOTS.iter().flat_map(|root| code.match_indices(root)) {
        let rest = &code[place + root.len()..];
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

pub const PACKAGES: [&str; 3] = ["src", "core/src", "lab/src"];

/// Rust files of the [`PACKAGES`], each with its path below its package's `src`. Of the top-level modules only `synth`
/// is in two of them: the bench hands on the library's.
pub fn files() -> Vec<(PathBuf, PathBuf)> {
    let mut all = Vec::new();
    for folder in PACKAGES {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let mut files = Vec::new();
        sources(&root, &mut files);
        all.extend(files.into_iter().map(|path| (path.strip_prefix(&root).expect("below").to_owned(), path)));
    }
    all
}

/// Files of all packages by their module's path, without their tests. The program re-exports the modules of the others,
/// so `crate::` leads to a module of any.
pub fn modules() -> BTreeMap<Vec<String>, String> {
    let mut modules = BTreeMap::<_, String>::new();
    for (name, path) in files() {
        let name = name.with_extension("");
        let mut parts: Vec<String> = name.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        match parts.last().map(String::as_str) {
            Some("tests" | "lib" | "main") => continue,
            Some("mod") => drop(parts.pop()),
            _ => {}
        }
        modules.entry(parts).or_default().push_str(&code(&std::fs::read_to_string(&path).expect("text")));
    }
    modules
}

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
