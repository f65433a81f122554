//! The walls of the house: which part of the crate may use which, read from the code itself, and what the pure library
//! depends on.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The rooms from the bottom up. A room uses those of lower numbers; those of one number do not know one another.
const FLOORS: [(&str, u32); 15] = [
    ("monitor", 0),
    ("plane", 1),
    ("kernel", 2),
    ("burst", 2),
    ("detector", 3),
    ("synth", 3),
    ("export", 4),
    ("matching", 5),
    ("baseline", 5),
    ("evaluate", 6),
    ("dataset", 7),
    ("inspect", 8),
    ("engine", 9),
    ("cli", 10),
    ("app", 11),
];

/// What a room above is used for all the same: the commands that open the window or draw it.
const DOORS: [(&str, &str); 5] = [
    ("cli/mod.rs", "app"),
    ("cli/window.rs", "app"),
    ("cli/render.rs", "app"),
    ("cli/render_args.rs", "app"),
    ("cli/choices.rs", "app"),
];

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// The code of a file without comments and without its tests, which may use anything.
fn code(text: &str) -> String {
    let tests = text.find("#[cfg(test)]\nmod tests {").unwrap_or(text.len());
    text[..tests].lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The rooms that follow `crate::` in `code`, also those in braces.
fn rooms_used(code: &str) -> BTreeSet<String> {
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

fn floor(room: &str) -> Option<u32> {
    FLOORS.iter().find(|(name, _)| *name == room).map(|(_, floor)| *floor)
}

#[test]
fn no_room_reaches_up() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let (mut uses, mut doors) = (0, 0);
    for path in files {
        let name = path.strip_prefix(&root).expect("below").to_string_lossy().replace('\\', "/");
        let room = name.split(['/', '.']).next().expect("a name").to_owned();
        if matches!(room.as_str(), "lib" | "main") || name.ends_with("/tests.rs") || name.contains("/tests/") {
            continue;
        }
        let own = floor(&room).unwrap_or_else(|| panic!("src/{room} has no floor; give it one in tests/house.rs"));
        for used in rooms_used(&code(&std::fs::read_to_string(&path).expect("text"))) {
            let Some(other) = floor(&used) else { continue };
            uses += 1;
            if DOORS.contains(&(name.as_str(), used.as_str())) {
                doors += 1;
                continue;
            }
            assert!(used == room || other < own, "src/{name} uses crate::{used}, which does not stand below {room}");
        }
    }
    assert!(uses > 300 && doors >= 3, "{uses} uses were read, {doors} of them doors: too few to be all");
}

#[test]
fn uses_are_read_in_every_way_they_are_written() {
    let text = "use crate::plane::{Plane, x};\nuse crate::{burst::{Burst, Open}, monitor::Monitor, Plane};\nfn f(x: crate::detector::Slope) {}\n\
        // crate::app is a comment\n#[cfg(test)]\nmod tests {\n    use crate::synth::chart;\n}\n";
    let rooms: Vec<String> = rooms_used(&code(text)).into_iter().collect();
    assert_eq!(rooms, ["Plane", "burst", "detector", "monitor", "plane"]);
}

#[test]
fn the_pure_library_holds_no_window_no_command_line_and_no_database() {
    let tree = |features: &[&str]| -> BTreeSet<String> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let output = Command::new(cargo)
            .args(["tree", "--locked", "--offline", "-e", "normal", "--prefix", "none", "--format", "{lib}"])
            .args(["--no-default-features", "--features", &features.join(",")])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("cargo runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text").lines().map(str::to_owned).collect()
    };
    let window = ["egui", "eframe", "egui_wgpu", "wgpu", "winit", "rfd", "pollster"];
    let commands = ["clap", "indicatif", "ctrlc", "anyhow"];
    let database = ["rusqlite", "libsqlite3_sys"];
    let has = |tree: &BTreeSet<String>, names: &[&str]| names.iter().any(|name| tree.contains(*name));
    let pure = tree(&[]);
    assert!(pure.contains("burstscope") && pure.contains("rayon"), "{pure:?}");
    assert!(!has(&pure, &window) && !has(&pure, &commands) && !has(&pure, &database), "{pure:?}");
    let colmap = tree(&["colmap"]);
    assert!(has(&colmap, &database) && !has(&colmap, &window) && !has(&colmap, &commands));
    let cli = tree(&["cli"]);
    assert!(has(&cli, &commands) && !has(&cli, &window) && !has(&cli, &database));
    let all = tree(&["app", "cli", "colmap"]);
    assert!(has(&all, &window) && has(&all, &commands) && has(&all, &database));
    println!("packages in the tree: {} pure, {} with everything", pure.len(), all.len());
}

fn manifest(name: &str) -> toml::Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    std::fs::read_to_string(path).expect("a file").parse().expect("TOML")
}

#[test]
fn every_dependency_is_used() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text_of = |folders: &[&str]| {
        let mut files = Vec::new();
        folders.iter().for_each(|folder| sources(&root.join(folder), &mut files));
        files.iter().map(|path| std::fs::read_to_string(path).expect("text")).collect::<String>()
    };
    let manifest = manifest("Cargo.toml");
    for (table, folders) in [("dependencies", &["src"][..]), ("dev-dependencies", &["src", "tests", "benches"])] {
        let text = text_of(folders);
        for name in manifest[table].as_table().expect("a table").keys() {
            let word = name.replace('-', "_");
            let used = [format!("{word}::"), format!("use {word}"), format!("{word}!")];
            assert!(used.iter().any(|way| text.contains(way)), "{name} is in [{table}] and not used in {folders:?}");
        }
    }
}

/// Whether a licence expression can be met by those in `allowed`: one of alternatives, all of what is joined by AND.
fn is_met(expression: &str, allowed: &[String]) -> bool {
    let plain = expression.replace(['(', ')'], " ").replace('/', " OR ");
    plain.split(" AND ").all(|part| part.split(" OR ").any(|licence| allowed.iter().any(|a| a == licence.trim())))
}

#[test]
fn dependencies_have_known_licences_and_known_duplicates() {
    let rules = manifest("deny.toml");
    let allowed: Vec<String> = rules["licenses"]["allow"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|licence| licence.as_str().expect("a word").to_owned())
        .collect();
    let skipped: BTreeSet<&str> =
        rules["bans"]["skip"].as_array().expect("a list").iter().filter_map(|skip| skip["name"].as_str()).collect();
    // `cargo tree` looks at this system's packages alone, and so needs nothing that is not here already.
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["tree", "--locked", "--offline", "-e", "normal,build,dev", "--prefix", "none", "--no-dedupe"])
        .args(["--format", "{p}\t{l}"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let packages: BTreeSet<(String, String)> = String::from_utf8(output.stdout)
        .expect("text")
        .lines()
        .map(|line| {
            let (package, licence) = line.split_once('\t').expect("two columns");
            let name_version: Vec<&str> = package.split_whitespace().take(2).collect();
            (name_version.join(" "), licence.to_owned())
        })
        .collect();
    assert!(packages.len() > 200, "{} packages are too few", packages.len());
    for (package, licence) in &packages {
        assert!(is_met(licence, &allowed), "{package}: the licence '{licence}' is not in deny.toml");
    }
    let names: Vec<&str> = packages.iter().filter_map(|(package, _)| package.split(' ').next()).collect();
    for two in names.windows(2).filter(|two| two[0] == two[1]) {
        assert!(skipped.contains(two[0]), "{} comes in two versions; see deny.toml", two[0]);
    }
}

#[test]
fn licence_expressions_are_read() {
    let allowed = ["MIT".to_owned(), "Zlib".to_owned()];
    for (expression, met) in [
        ("MIT", true),
        ("MIT OR Apache-2.0", true),
        ("Apache-2.0/MIT", true),
        ("(MIT OR Apache-2.0) AND Zlib", true),
        ("(MIT OR Apache-2.0) AND OFL-1.1", false),
        ("GPL-3.0", false),
        ("", false),
    ] {
        assert_eq!(is_met(expression, &allowed), met, "{expression}");
    }
}

/// The files of `src` by their module's path, without their tests.
fn modules() -> BTreeMap<Vec<String>, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut modules = BTreeMap::new();
    for path in files {
        let name = path.strip_prefix(&root).expect("below").with_extension("");
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

/// The paths of a `use` tree, written out.
fn paths_of(tree: &str, before: &[&str], into: &mut Vec<Vec<String>>) {
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

/// The modules that `code` of `module` uses, but for the folder that it is in and the files of its own folder: what a
/// folder's `mod.rs` hands on is no circle.
fn modules_used(module: &[String], code: &str, modules: &BTreeMap<Vec<String>, String>) -> BTreeSet<Vec<String>> {
    let mut paths = Vec::new();
    // A `use` begins its line, perhaps after its visibility; words of a string do not end in a path.
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
    for root in ["crate::", "super::"] {
        for (at, _) in code.match_indices(root) {
            let end =
                code[at..].find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(code.len() - at);
            paths.push(code[at..at + end].split("::").filter(|p| !p.is_empty()).map(str::to_owned).collect());
        }
    }
    let mut used = BTreeSet::new();
    for path in paths {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let absolute: Vec<String> = match path.first().map(String::as_str) {
            Some("crate") => path[1..].to_vec(),
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

/// A way from `start` back to it, if there is one.
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
fn no_files_use_one_another_in_a_circle() {
    let modules = modules();
    let uses: BTreeMap<_, _> =
        modules.iter().map(|(module, code)| (module.clone(), modules_used(module, code, &modules))).collect();
    assert!(uses.values().map(BTreeSet::len).sum::<usize>() > 1000, "too few uses were read to be all");
    // The shell owns the window, and what works for it is written as its methods.
    let of_the_shell = |module: &[String]| {
        let name = module.join("::");
        ["app::window", "app::shell", "app::overlays", "app::files"].contains(&name.as_str())
            || ["app::jobs", "app::workspace"].iter().any(|folder| name.starts_with(folder))
    };
    for start in uses.keys().filter(|module| !of_the_shell(module)) {
        if let Some(way) = circle(start, &uses) {
            let way: Vec<String> = way.iter().map(|module| module.join("::")).collect();
            panic!("a circle: {} → {}", way.join(" → "), way[0]);
        }
    }
}

#[test]
fn the_kernel_knows_no_detector() {
    for (module, code) in modules() {
        let name = module.join("::");
        let used = |path: &str| code.contains(&format!("crate::{path}"));
        if name.starts_with("kernel") {
            assert!(!used("detector"), "{name} uses the detector");
        }
    }
}

#[test]
fn circles_are_found() {
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

/// A name says which answer, which pair: these words alone say nothing.
#[test]
fn no_type_is_called_only_answer_found_pair_or_job() {
    for (module, code) in modules() {
        for line in code.lines() {
            let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
            let kind = words.find(|word| !["pub", "crate", "super", "in"].contains(word));
            let is_type = kind.is_some_and(|kind| ["struct", "enum", "type", "trait"].contains(&kind));
            let name = words.next().unwrap_or_default();
            assert!(
                !(is_type && ["Answer", "Found", "Pair", "Job"].contains(&name)),
                "{}: say which {name} it is: {line}",
                module.join("::")
            );
        }
    }
}
