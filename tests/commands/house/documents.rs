//! Checks that the documents agree with the program, and that their links lead to files.

use burstscope::detector::params::doc;
use std::fs;
use std::path::{Path, PathBuf};

const REFERENCE: &str = "docs/REFERENCE.md";
const START: &str = "<!-- parameters -->\n";
const END: &str = "<!-- end of parameters -->";

/// Table of all search parameters, from their descriptions.
fn table() -> String {
    let row = |doc: &doc::ParamDoc| {
        let text = format!("{} {}", doc.meaning, doc.effect).replace('|', "\\|");
        format!("| `--{}` | {} | {} | {text} |\n", doc.name, doc.label, doc.unit)
    };
    let rows: String = doc::ALL.iter().map(row).collect();
    format!("| option | in the window | unit | meaning |\n| --- | --- | --- | --- |\n{rows}")
}

#[test]
fn the_reference_has_the_programs_own_words_for_each_parameter() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(REFERENCE);
    let text = fs::read_to_string(&path).expect("the reference");
    let (before, rest) = text.split_once(START).expect("the start of the table");
    let (written, after) = rest.split_once(END).expect("the end of the table");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(&path, format!("{before}{START}{}{END}{after}", table())).expect("written");
        return;
    }
    assert!(written == table(), "{REFERENCE} is not what the program says; UPDATE_DOCS=1 writes it anew");
}

/// Targets of links and pictures in a Markdown text that are files.
fn targets(text: &str) -> impl Iterator<Item = &str> {
    text.match_indices("](").filter_map(|(at, _)| {
        let target = text[at + 2..].split_once(')')?.0;
        let file = target.split_once('#').map_or(target, |(file, _)| file);
        // Skips addresses elsewhere and links to the glossary.
        (!file.is_empty() && !file.contains(':')).then_some(file)
    })
}

#[test]
fn every_link_between_documents_leads_to_a_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let in_docs = fs::read_dir(root.join("docs")).expect("a folder").map(|entry| entry.expect("an entry").path());
    let documents: Vec<PathBuf> = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "core/README.md"]
        .iter()
        .map(|name| root.join(name))
        .chain(in_docs.filter(|path| path.extension().is_some_and(|extension| extension == "md")))
        .collect();
    let mut links = 0;
    for document in documents {
        let text = fs::read_to_string(&document).unwrap_or_else(|e| panic!("{}: {e}", document.display()));
        for target in targets(&text) {
            let path = document.parent().expect("a folder").join(target);
            assert!(path.exists(), "{} links to {target}, which is not there", document.display());
            links += 1;
        }
    }
    assert!(links > 30, "{links} links were found");
}
