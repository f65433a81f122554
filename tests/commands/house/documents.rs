//! Checks that the documents agree with the program, and that their links lead to files.

use burstscope::detector::params::Param;
use burstscope::{detector, matching};
use std::fs;
use std::path::{Path, PathBuf};

const REFERENCE: &str = "docs/REFERENCE.md";

/// Table of parameters, made from their records.
fn table<P: Default>(records: &[Param<P>]) -> String {
    let rows: String = records.iter().map(Param::reference_row).collect();
    format!("| option | in the window | values | default | meaning |\n| --- | --- | --- | --- | --- |\n{rows}")
}

#[test]
fn the_reference_has_the_records_of_all_parameters() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(REFERENCE);
    let text = fs::read_to_string(&path).expect("the reference");
    let mut made = text.clone();
    let parts = [
        ("parameters", table(&detector::params::doc::ALL)),
        ("parameters of matching", table(&matching::params::doc::ALL)),
    ];
    for (part, table) in parts {
        let (start, end) = (format!("<!-- {part} -->\n"), format!("<!-- end of {part} -->"));
        let (before, rest) = made.split_once(&start).unwrap_or_else(|| panic!("no start of the table of {part}"));
        let (_, after) = rest.split_once(&end).unwrap_or_else(|| panic!("no end of the table of {part}"));
        made = format!("{before}{start}{table}{end}{after}");
    }
    if std::env::var_os("BURSTSCOPE_UPDATE_DOCS").is_some() {
        fs::write(&path, made).expect("written");
        return;
    }
    assert!(made == text, "{REFERENCE} is not what the program says; BURSTSCOPE_UPDATE_DOCS=1 writes it anew");
}

/// Targets of links and pictures in a Markdown text that are files.
pub(super) fn targets(text: &str) -> impl Iterator<Item = &str> {
    text.match_indices("](").filter_map(|(at, _)| {
        let target = text[at + 2..].split_once(')')?.0;
        let file = target.split_once('#').map_or(target, |(file, _)| file);
        // Skips addresses elsewhere and links to the glossary.
        (!file.is_empty() && !file.contains(':')).then_some(file)
    })
}

/// Documents of the project, with their texts.
pub fn documents() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let in_docs = fs::read_dir(root.join("docs")).expect("a folder").map(|entry| entry.expect("an entry").path());
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        (path, text)
    };
    ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "core/README.md"]
        .iter()
        .map(|name| root.join(name))
        .chain(in_docs.filter(|path| path.extension().is_some_and(|extension| extension == "md")))
        .map(read)
        .collect()
}

#[test]
fn every_link_between_documents_leads_to_a_file() {
    let mut links = 0;
    for (document, text) in documents() {
        for target in targets(&text) {
            let path = document.parent().expect("a folder").join(target);
            assert!(path.exists(), "{} links to {target}, which is not there", document.display());
            links += 1;
        }
    }
    assert!(links > 30, "{links} links were found");
}

#[test]
fn the_citation_names_this_version() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CITATION.cff")).expect("the citation");
    let version = text.lines().find_map(|line| line.strip_prefix("version: "));
    assert_eq!(version, Some(env!("CARGO_PKG_VERSION")));
}
