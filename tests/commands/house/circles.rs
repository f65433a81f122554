//! Checks that no files use one another in a circle.

use super::reading::{modules, paths_of};
use std::collections::{BTreeMap, BTreeSet};

/// Modules that the code of `module` uses, except its own folder and the files in its own folder: re-exports of a
/// folder's `mod.rs` are no circle.
fn modules_used(module: &[String], code: &str, modules: &BTreeMap<Vec<String>, String>) -> BTreeSet<Vec<String>> {
    let mut paths = Vec::new();
    // A `use` begins its line, perhaps after its visibility; words in a string do not end in a path.
    let is_start = |at: usize| {
        let line = code[..at].rfind('\n').map_or(0, |end| end + 1);
        let before = code[line..at].trim();
        before.is_empty() || (before.starts_with("pub") && !before.contains(' '))
    };
    for (at, _) in code.match_indices("use ").filter(|(at, _)| is_start(*at)) {
        if let Some(end) = code[at..].find(';') {
            paths_of(&code[at + "use ".len()..at + end], &[], &mut paths);
        }
    }
    for root in ["crate::", "super::", "burstscope_core::", "burstscope_lab::"] {
        for (at, _) in code.match_indices(root) {
            let end =
                code[at..].find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(code.len() - at);
            // A group in braces was read above, name by name.
            if code[at + end..].starts_with('{') {
                continue;
            }
            paths.push(code[at..at + end].split("::").filter(|p| !p.is_empty()).map(str::to_owned).collect());
        }
    }
    let mut used = BTreeSet::new();
    for path in paths {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let absolute: Vec<String> = match path.first().map(String::as_str) {
            Some("crate" | "burstscope_core" | "burstscope_lab") => path[1..].to_vec(),
            Some("super") if supers <= module.len() => {
                module[..module.len() - supers].iter().chain(&path[supers..]).cloned().collect()
            }
            _ => continue,
        };
        let named = (1..=absolute.len()).rev().map(|n| &absolute[..n]).find(|path| modules.contains_key(*path));
        used.extend(
            named.filter(|path| !module.starts_with(path) && !path.starts_with(module)).map(<[String]>::to_vec),
        );
    }
    used
}

/// Finds a path from `start` back to it.
fn circle<'a>(
    start: &'a Vec<String>,
    uses: &'a BTreeMap<Vec<String>, BTreeSet<Vec<String>>>,
) -> Option<Vec<&'a Vec<String>>> {
    let mut ways = vec![vec![start]];
    let mut seen = BTreeSet::new();
    while let Some(way) = ways.pop() {
        for next in uses.get(*way.last().expect("not empty")).into_iter().flatten() {
            if next == start {
                return Some(way);
            }
            if seen.insert(next) {
                ways.push(way.iter().copied().chain([next]).collect());
            }
        }
    }
    None
}

#[test]
fn no_files_use_one_another_in_a_circle_and_circles_are_found() {
    let modules = modules();
    let uses: BTreeMap<_, _> =
        modules.iter().map(|(module, code)| (module.clone(), modules_used(module, code, &modules))).collect();
    assert!(uses.values().map(BTreeSet::len).sum::<usize>() > 1000, "too few uses were read to be all");
    for start in uses.keys() {
        if let Some(way) = circle(start, &uses) {
            let way: Vec<String> = way.iter().map(|module| module.join("::")).collect();
            panic!("a circle: {} → {}", way.join(" → "), way[0]);
        }
    }
    let modules: BTreeMap<Vec<String>, String> = [
        ("a", "use crate::b::{X, c::Y as Z};"),
        ("b", "pub use c::Y;"),
        ("b::c", "fn f() -> super::super::d::T { }"),
        ("d", "use crate::{a::{Q}, e};"),
        ("e", ""),
    ]
    .map(|(name, code)| (name.split("::").map(str::to_owned).collect(), code.to_owned()))
    .into();
    let uses: BTreeMap<_, _> =
        modules.iter().map(|(module, code)| (module.clone(), modules_used(module, code, &modules))).collect();
    let name = |name: &str| name.split("::").map(str::to_owned).collect::<Vec<_>>();
    assert!(circle(&name("a"), &uses).is_some_and(|way| way.len() == 3), "a → b::c → d → a");
    assert!(circle(&name("e"), &uses).is_none() && circle(&name("b"), &uses).is_none());
}
