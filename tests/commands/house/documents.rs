//! Checks that the documents agree with the program, and that their links lead to files.

use crate::support::*;
use burstscope::detector::params::Param;
use burstscope::{detector, matching};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const REFERENCE: &str = "docs/REFERENCE.md";

/// Row of the table in the page of reference: option, label, values and unit, default, help.
fn row<P: Default>(of: &Param<P>) -> String {
    let mut params = P::default();
    let values = match (of.field)(&mut params).words() {
        Some(words) => words.iter().map(|(word, _)| format!("`{word}`")).collect::<Vec<_>>().join(", "),
        None => format!("{} {}", of.placeholder, of.bounds.map_or_else(String::new, |b| b.to_string())),
    };
    let cells = [
        format!("`--{}`", of.name),
        of.label.to_owned(),
        format!("{} {}", values.trim(), of.unit).trim().to_owned(),
        of.default_text(),
        format!("{} {}", of.meaning, of.effect),
    ];
    format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | "))
}

fn table<P: Default>(records: &[Param<P>]) -> String {
    let rows: String = records.iter().map(row).collect();
    format!("| option | in the window | values | default | meaning |\n| --- | --- | --- | --- | --- |\n{rows}")
}

fn table_of_formats() -> String {
    let row = |of: burstscope::burst::FormatRecord| {
        let extensions: Vec<String> = of.extensions.iter().map(|extension| format!("`.{extension}`")).collect();
        format!("| {} ({}) | {} | {} |\n", of.name, extensions.join(", "), of.opens, of.options)
    };
    let rows: String = burstscope::burst::file_formats().map(row).collect();
    format!("| format | taken as frames | say |\n| --- | --- | --- |\n{rows}")
}

fn list_of_formats() -> String {
    let names: Vec<&str> = burstscope::burst::file_formats().map(|of| of.name).collect();
    format!("{}\n", names.join(", "))
}

#[test]
fn documents_have_the_records_of_all_parameters_and_formats() {
    for (document, part, made) in [
        (REFERENCE, "parameters", table(&detector::params::doc::ALL)),
        (REFERENCE, "parameters of matching", table(&matching::params::doc::ALL)),
        ("docs/GUIDE.md", "formats", table_of_formats()),
        ("README.md", "formats", list_of_formats()),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(document);
        let text = fs::read_to_string(&path).expect("a document");
        let (start, end) = (format!("<!-- {part} -->\n"), format!("<!-- end of {part} -->"));
        let (before, rest) = text.split_once(&start).unwrap_or_else(|| panic!("no start of the table of {part}"));
        let (_, after) = rest.split_once(&end).unwrap_or_else(|| panic!("no end of the table of {part}"));
        let made = format!("{before}{start}{made}{end}{after}");
        if std::env::var_os("BURSTSCOPE_UPDATE_DOCS").is_some() {
            fs::write(&path, made).expect("written");
        } else {
            assert!(made == text, "{document} is not what the program says; BURSTSCOPE_UPDATE_DOCS=1 writes it anew");
        }
    }
}

/// Adds the keys of a document, and of all that it has in it.
fn add_keys(value: &Value, keys: &mut BTreeSet<String>) {
    value.as_array().into_iter().flatten().for_each(|each| add_keys(each, keys));
    for (key, each) in value.as_object().into_iter().flatten() {
        keys.insert(key.clone());
        add_keys(each, keys);
    }
}

#[test]
fn every_key_that_a_command_prints_is_explained_in_its_help_or_the_reference() {
    let home = folder();
    let reference = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(REFERENCE)).expect("a document");
    let mut unexplained = Vec::new();
    for (help, line) in [
        ("synth chart", "synth chart --out c --width 240 --height 180 --frames 5 --discs 9"),
        ("synth scene", "synth scene --out d --width 240 --height 180 --frames 5 --snr 8"),
        ("synth noise", "synth noise --out n --width 100 --height 80 --frames 4"),
        ("info", "info c"),
        ("detect", "detect c --slopes-u -1:1:3 --out found"),
        ("stack", "stack c --slope 1,0 --out stack.tiff"),
        ("merge", "merge c --out merged.tiff"),
        ("slopes", "slopes d"),
        ("probe", "probe d --at 50,50"),
        ("decoys", "decoys d --slopes-u -1:1:3"),
        ("match", "match d d --slopes-u -1:1:3 --out matched"),
        // A report has the parts of others.
        ("report, info, detect, slopes, decoys, probe", "report d --slopes-u -1:1:3 --out page.md"),
    ] {
        let mut keys = BTreeSet::new();
        add_keys(&home.run_json(&format!("{line} --json")), &mut keys);
        let helps: String = help.split(", ").map(|help| home.run_well(&format!("{help} --help"))).collect();
        let text = helps + &reference;
        let words: BTreeSet<&str> = text.split(|c: char| !(c.is_alphanumeric() || "_-".contains(c))).collect();
        // Parameters have the names of their options.
        let is_option = |key: &str| words.contains(format!("--{}", key.replace('_', "-")).as_str());
        keys.retain(|key| !words.contains(key.as_str()) && !is_option(key));
        unexplained.extend(keys.into_iter().map(|key| format!("{help}: {key}")));
    }
    assert!(unexplained.is_empty(), "{unexplained:#?}");
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

/// Values of a key of the citation, in the order of their lines.
fn cited<'a>(part: &'a str, key: &'a str) -> impl Iterator<Item = &'a str> {
    let of_line = move |line: &'a str| line.trim_start_matches([' ', '-']).strip_prefix(key)?.strip_prefix(": ");
    part.lines().filter_map(of_line).map(|value| value.trim_matches('"'))
}

/// The program, in its version, and the paper as BibTeX.
fn bibtex(citation: &str) -> String {
    let (program, paper) = citation.split_once("\nreferences:").expect("references");
    let first = |part, key| cited(part, key).next().unwrap_or_else(|| panic!("the citation has no {key}"));
    let names = cited(paper, "family-names").zip(cited(paper, "given-names"));
    let authors: Vec<String> = names.map(|(family, given)| format!("{family}, {given}")).collect();
    let (title, name, version) = (first(program, "title"), first(program, "name"), first(program, "version"));
    let (of_paper, authors, year) = (first(paper, "title"), authors.join(" and "), first(paper, "year"));
    let (eprint, url) = (first(paper, "value").trim_start_matches("arXiv:"), first(paper, "url"));
    format!(
        "@software{{burstscope,\n  title = {{{title}}},\n  author = {{{{{name}}}}},\n  version = {{{version}}}\n}}\n\n\
         @misc{{buff,\n  title = {{{{{of_paper}}}}},\n  author = {{{authors}}},\n  year = {{{year}}},\n  \
         eprint = {{{eprint}}},\n  archiveprefix = {{arXiv}},\n  url = {{{url}}}\n}}\n"
    )
}

#[test]
fn the_citation_names_this_version_in_both_of_its_forms() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("CITATION.cff")).expect("the citation");
    assert_eq!(cited(&text, "version").next(), Some(env!("CARGO_PKG_VERSION")));
    let (made, path) = (bibtex(&text), root.join("assets/burstscope.bib"));
    if std::env::var_os("BURSTSCOPE_UPDATE_DOCS").is_some() {
        fs::write(&path, &made).expect("written");
    }
    let kept = fs::read_to_string(path).expect("the entries");
    assert_eq!(
        kept, made,
        "assets/burstscope.bib is not what CITATION.cff says; BURSTSCOPE_UPDATE_DOCS=1 writes it anew"
    );
}
