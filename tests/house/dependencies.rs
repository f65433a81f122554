//! What the crate depends on: with which features, whether it is used, under which licence.

use crate::reading::sources;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

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
    assert!(!pure.contains("rawler"), "the pure library is under MIT or Apache-2.0 alone");
    let raw = tree(&["raw"]);
    assert!(raw.contains("rawler") && !has(&raw, &window) && !has(&raw, &commands) && !has(&raw, &database));
    let all = tree(&["app", "cli", "colmap", "raw"]);
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
