//! Checks the crate's dependencies: their features, their use, and their licences.

use super::reading::sources;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Answer of a `command` of cargo about the workspace as it is locked, without any download.
pub fn cargo(command: &str, arguments: &[&str]) -> String {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args([command, "--locked", "--offline"])
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// Libraries in the tree of `package` with only `features`.
fn tree(package: &str, features: &[&str]) -> BTreeSet<String> {
    let features = features.join(",");
    let of_package = ["--package", package, "--no-default-features", "--features", &features];
    let tree = cargo("tree", &[&["-e", "normal", "--prefix", "none", "--format", "{lib}"], &of_package[..]].concat());
    tree.lines().map(str::to_owned).collect()
}

#[test]
fn the_library_holds_no_window_and_no_command_line() {
    let window = [
        "accesskit",
        "accesskit_winit",
        "arboard",
        "ash",
        "eframe",
        "egui",
        "egui_extras",
        "egui_plot",
        "egui_tiles",
        "egui_wgpu",
        "epaint",
        "glow",
        "naga",
        "pollster",
        "rfd",
        "smithay_client_toolkit",
        "wayland_client",
        "wgpu",
        "wgpu_core",
        "wgpu_hal",
        "winit",
        "x11rb",
        "zbus",
    ];
    let commands = ["anyhow", "clap", "clap_builder", "clap_complete", "clap_mangen", "indicatif", "signal_hook"];
    let database = ["rusqlite", "libsqlite3_sys"];
    let has = |tree: &BTreeSet<String>, names: &[&str]| names.iter().any(|name| tree.contains(*name));
    let core = tree("burstscope-core", &["bags", "colmap", "raw"]);
    assert!(core.contains("burstscope_core") && core.contains("rayon"), "{core:?}");
    assert!(has(&core, &database) && core.contains("rawler"), "{core:?}");
    assert!(!has(&core, &window) && !has(&core, &commands), "{core:?}");
    let pure = tree("burstscope-core", &[]);
    assert!(!pure.contains("rawler"), "the library without features is under MIT or Apache-2.0 alone");
    assert!(!has(&pure, &database), "{pure:?}");
    // The program passes its features on.
    let none = tree("burstscope", &[]);
    assert!(!has(&none, &window) && !has(&none, &commands) && !has(&none, &database) && !none.contains("rawler"));
    let cli = tree("burstscope", &["cli"]);
    assert!(has(&cli, &commands) && !has(&cli, &window) && !has(&cli, &database) && !cli.contains("rawler"));
    let all = tree("burstscope", &["app", "bags", "cli", "colmap", "raw"]);
    for name in commands.iter().chain(&database).chain(&["rawler", "egui", "eframe", "wgpu", "winit", "rfd"]) {
        assert!(all.contains(*name), "{name} is not in the program's tree, so that it proves nothing elsewhere");
    }
    println!("libraries in the tree: {} pure, {} in the library, {} in the program", pure.len(), core.len(), all.len());
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
    for (package, table, folders) in [
        ("Cargo.toml", "dependencies", &["src"][..]),
        ("Cargo.toml", "dev-dependencies", &["src", "tests", "benches", "core/tests", "lab/tests"]),
        ("core/Cargo.toml", "dependencies", &["core/src"]),
        ("core/Cargo.toml", "dev-dependencies", &["core/src", "core/tests"]),
        ("lab/Cargo.toml", "dependencies", &["lab/src"]),
        ("lab/Cargo.toml", "dev-dependencies", &["lab/src", "lab/tests"]),
        ("python/Cargo.toml", "dependencies", &["python/src"]),
    ] {
        let manifest = manifest(package);
        let text = text_of(folders);
        for name in manifest[table].as_table().expect("a table").keys() {
            let word = name.replace('-', "_");
            let used = [format!("{word}::"), format!("use {word}"), format!("{word}!")];
            assert!(
                used.iter().any(|way| text.contains(way)),
                "{name} is in [{table}] of {package} and not used in {folders:?}"
            );
        }
    }
}

/// Whether the `allowed` licences satisfy an expression: one of its alternatives, and all parts joined by AND.
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
    // `cargo tree` needs only this system's packages, and so no download.
    let every = ["--workspace", "-e", "normal,build,dev", "--prefix", "none", "--no-dedupe", "--format", "{p}\t{l}"];
    let packages: BTreeSet<(String, String)> = cargo("tree", &every)
        .lines()
        // A blank line stands between the trees of two packages.
        .filter(|line| !line.is_empty())
        .map(|line| {
            let (package, licence) = line.split_once('\t').expect("two columns");
            let name_version: Vec<&str> = package.split_whitespace().take(2).collect();
            // A circle of dev-dependencies is cut with a mark.
            (name_version.join(" "), licence.trim_end_matches(" (*)").to_owned())
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
