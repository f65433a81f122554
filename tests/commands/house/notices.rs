//! Checks the notices of other projects' software, which the packages carry and the window lists, against what the
//! program and the module for Python are made of. `BURSTSCOPE_UPDATE_DOCS=1` writes them anew, below their first part.

use super::dependencies::cargo;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const NOTICES: &str = "assets/THIRD-PARTY.txt";
/// System for which the packages are made.
const TARGET: &str = "x86_64-unknown-linux-gnu";
/// Line above the list of packages. What stands before it is written by hand.
const LIST: &str = "name | version | licence | source\n";
const RULE: &str = "================================================================================";

struct Package {
    name: String,
    version: String,
    licence: String,
    repository: String,
    folder: PathBuf,
}

impl Package {
    fn label(&self) -> String {
        format!("{} {}", self.name, self.version)
    }

    fn texts(&self) -> Vec<(String, String)> {
        let mut texts = Vec::new();
        let files = |folder: &Path| {
            let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
            entries.map(|entry| entry.expect("an entry").path()).collect::<BTreeSet<_>>()
        };
        let name = |path: &Path| path.file_name().expect("a name").to_string_lossy().into_owned();
        let marks = ["LICEN", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE"];
        let mut add = |path: PathBuf, is_text: bool| {
            if path.is_file() && (is_text || marks.iter().any(|mark| name(&path).to_uppercase().starts_with(mark))) {
                let text = String::from_utf8_lossy(&std::fs::read(&path).expect("read")).replace('\r', "");
                texts.push((path.strip_prefix(&self.folder).expect("below").display().to_string(), text));
            }
        };
        for path in files(&self.folder) {
            if path.is_dir() && name(&path) != "tests" {
                // Each font has a text with its own name.
                let is_fonts = name(&path) == "fonts";
                files(&path).into_iter().for_each(|path| {
                    let is_text = is_fonts && path.extension().is_some_and(|extension| extension == "txt");
                    add(path, is_text);
                });
            } else {
                add(path, false);
            }
        }
        texts
    }
}

/// Packages of others of which the program and the module for Python are made.
fn packages() -> Vec<Package> {
    let metadata = cargo("metadata", &["--format-version", "1", "--filter-platform", TARGET]);
    let metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    // Cargo's metadata name what is locked; the tree has only what these features need.
    let of_features = ["--package", "burstscope", "--package", "burstscope-python", "--target", TARGET];
    let tree = cargo("tree", &[&of_features[..], &["-e", "normal", "--prefix", "none", "--format", "{p}"]].concat());
    let needed: BTreeSet<String> =
        tree.lines().map(|line| line.split(' ').take(2).collect::<Vec<_>>().join(" ").replace(" v", " ")).collect();
    let mut packages: Vec<Package> = metadata["packages"]
        .as_array()
        .expect("a list")
        .iter()
        .filter(|package| !package["source"].is_null())
        .map(|package| Package {
            name: text(&package["name"]),
            version: text(&package["version"]),
            licence: text(&package["license"]),
            repository: text(&package["repository"]),
            folder: Path::new(&text(&package["manifest_path"])).parent().expect("a folder").to_owned(),
        })
        .filter(|package| needed.contains(&package.label()))
        .collect();
    packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    packages
}

/// Licences under which a package is taken: of each choice Apache-2.0, else MIT, else the first.
fn taken(expression: &str) -> BTreeSet<String> {
    let choice = |part: &str| {
        let choices: Vec<&str> = part.split(" OR ").map(str::trim).collect();
        let wanted = ["Apache-2.0", "MIT"].into_iter().find(|licence| choices.contains(licence));
        wanted.unwrap_or(choices[0]).to_owned()
    };
    expression.replace(['(', ')'], " ").replace('/', " OR ").split(" AND ").map(choice).collect()
}

/// Holders of the copyright, which stand above a text that many packages share, and the text.
fn holders(text: &str) -> (String, &str) {
    const SHARED: &str = "Permission is hereby granted, free of charge";
    let Some((head, _)) = text.split_once(SHARED) else { return (String::new(), text) };
    let lines: Vec<&str> =
        head.lines().map(str::trim).filter(|line| !line.is_empty() && !line.contains("MIT License")).collect();
    // Other lines belong to a text of its own.
    if !lines.iter().all(|line| ["copyright", "all rights"].iter().any(|start| line.to_lowercase().starts_with(start)))
    {
        return (String::new(), text);
    }
    (lines.join("; "), &text[head.len()..])
}

/// Texts of the licences, each once, below the packages that have it.
fn texts(packages: &[Package]) -> String {
    let mut groups: BTreeMap<String, (Vec<String>, String)> = BTreeMap::new();
    for package in packages {
        let mut found = package.texts();
        if taken(&package.licence).iter().any(|licence| licence != "Apache-2.0") {
            // A part of a project may leave the text to another one.
            let mut others = packages.iter().filter(|other| other.repository == package.repository);
            while found.is_empty() {
                let other = others.next();
                found = other.unwrap_or_else(|| panic!("{} has no text of its licence", package.label())).texts();
            }
        } else {
            found.retain(|(file, _)| file.to_uppercase().starts_with("NOTICE"));
        }
        // The text of Apache-2.0 comes once, from this project's own file.
        found.retain(|(_, text)| !text.chars().take(400).collect::<String>().contains("Apache License"));
        for (file, text) in found {
            let (holders, text) = holders(text.trim_end());
            let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
            let mut key = words.collect::<Vec<_>>().join(" ").to_lowercase();
            // Its copies differ in the address of its publisher.
            if key.starts_with("gnu lesser general public license version 2 1") {
                key.truncate(30);
            }
            let (users, _) = groups.entry(key).or_insert_with(|| (Vec::new(), text.trim_matches('\n').to_owned()));
            let after = if holders.is_empty() { String::new() } else { format!(": {holders}") };
            users.push(format!("{} ({file}){after}", package.label()));
        }
    }
    let apache = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("LICENSE-APACHE")).expect("text");
    let only = |package: &&Package| taken(&package.licence).contains("Apache-2.0");
    let users = packages.iter().filter(only).count();
    let under_apache = (vec![format!("Burstscope, and {users} packages of the list above")], apache);
    let mut groups: Vec<_> = groups.into_values().collect();
    groups.sort_by_key(|(users, _)| std::cmp::Reverse(users.len()));
    let tidy = |text: &str| text.trim_end().lines().map(|line| format!("{}\n", line.trim_end())).collect::<String>();
    std::iter::once(&under_apache)
        .chain(&groups)
        .map(|(users, text)| format!("\n{RULE}\n{}\n{RULE}\n\n{}", users.join("\n"), tidy(text)))
        .collect()
}

#[test]
#[cfg_attr(not(all(target_os = "linux", target_arch = "x86_64")), ignore = "needs the packages for Linux on x86-64")]
fn the_notices_are_those_of_what_is_shipped() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(NOTICES);
    let there = std::fs::read_to_string(&path).expect("the notices");
    let packages = packages();
    assert!(packages.len() > 300 && packages.iter().any(|package| package.name == "rawler"), "{}", packages.len());
    let row = |p: &Package| format!("{} | {} | {} | {}\n", p.name, p.version, p.licence, p.repository);
    let list: String = packages.iter().map(row).collect();
    let (by_hand, _) = there.split_once(LIST).expect("the heading of the list");
    let made = format!("{by_hand}{LIST}{list}{}", texts(&packages));
    if std::env::var_os("BURSTSCOPE_UPDATE_DOCS").is_some() {
        std::fs::write(&path, made).expect("written");
        return;
    }
    let differs = made.lines().zip(there.lines()).find(|(made, there)| made != there);
    assert!(made == there, "{NOTICES} is not up to date; BURSTSCOPE_UPDATE_DOCS=1 writes it anew: {differs:?}");
}

#[test]
fn of_licences_to_choose_from_one_is_taken_and_holders_of_the_copyright_stand_above_a_shared_text() {
    for (expression, licences) in [
        ("MIT OR Apache-2.0", &["Apache-2.0"][..]),
        ("Apache-2.0/MIT", &["Apache-2.0"]),
        ("Unlicense OR MIT", &["MIT"]),
        ("(MIT OR Apache-2.0) AND OFL-1.1", &["Apache-2.0", "OFL-1.1"]),
        ("LGPL-2.1", &["LGPL-2.1"]),
        ("Zlib", &["Zlib"]),
    ] {
        assert_eq!(taken(expression).into_iter().collect::<Vec<_>>(), licences, "{expression}");
    }
    let mit = "The MIT License (MIT)\n\nCopyright (c) 2015 A\nCopyright (c) 2016 B\n\nPermission is hereby granted, free of charge, to";
    let shared = "Permission is hereby granted, free of charge, to";
    assert_eq!(holders(mit), ("Copyright (c) 2015 A; Copyright (c) 2016 B".to_owned(), shared));
    for own in ["Copyright A\n\nRedistribution", "Parts are of others.\nPermission is hereby granted, free of charge"] {
        assert_eq!(holders(own), (String::new(), own));
    }
}
