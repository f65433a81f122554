//! How to cite the program and the method's paper: `CITATION.cff` as BibTeX.

const CITATION: &str = include_str!("../../CITATION.cff");

/// Values of a key, in the order of their lines.
fn values<'a>(part: &'a str, key: &'a str) -> impl Iterator<Item = &'a str> {
    let of_line = move |line: &'a str| line.trim_start_matches([' ', '-']).strip_prefix(key)?.strip_prefix(": ");
    part.lines().filter_map(of_line).map(|value| value.trim_matches('"'))
}

/// Entries of the program, in this version, and of the paper.
pub fn bibtex() -> String {
    let (program, paper) = CITATION.split_once("\nreferences:").unwrap_or((CITATION, ""));
    let first = |part, key| values(part, key).next().unwrap_or_default();
    let names = values(paper, "family-names").zip(values(paper, "given-names"));
    let authors: Vec<String> = names.map(|(family, given)| format!("{family}, {given}")).collect();
    let eprint = first(paper, "value").trim_start_matches("arXiv:");
    format!(
        "@software{{burstscope,\n  title = {{{}}},\n  author = {{{{{}}}}},\n  version = {{{}}}\n}}\n\n\
         @article{{buff,\n  title = {{{{{}}}}},\n  author = {{{}}},\n  journal = {{{}}},\n  year = {{{}}},\n  \
         eprint = {{{eprint}}},\n  archiveprefix = {{arXiv}},\n  url = {{{}}}\n}}\n",
        first(program, "title"),
        first(program, "name"),
        first(program, "version"),
        first(paper, "title"),
        authors.join(" and "),
        first(paper, "journal"),
        first(paper, "year"),
        first(paper, "url"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_entries_have_all_that_the_citation_says() {
        let text = bibtex();
        assert!(!text.contains("{}") && !text.contains("{{}}"), "{text}");
        assert_eq!(text.matches(['{']).count(), text.matches(['}']).count());
        for part in [
            "author = {{Burstscope contributors}}",
            concat!("version = {", env!("CARGO_PKG_VERSION"), "}"),
            "title = {{BuFF: Burst Feature Finder for Light-Constrained 3D Reconstruction}}",
            "author = {Ravendran, Ahalya and Bryson, Mitch and Dansereau, Donald G.}",
            "year = {2022}",
            "eprint = {2209.09470}",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
    }
}
