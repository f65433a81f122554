//! Glossary: the terms that the window uses, each with an explanation in a sentence or two and the paper's symbol.

use super::part::parameters;
use super::values::text;
use crate::requests::ViewKind;
use serde::Deserialize;
use std::sync::OnceLock;

const TEXT: &str = include_str!("../../assets/glossary.toml");

/// Contents of a pane by their names in the glossary: the kinds of picture, and what is made of several.
fn pictures() -> impl Iterator<Item = &'static str> {
    ViewKind::ALL.into_iter().map(|kind| kind.key()).chain(["slice", "difference"])
}

/// Source of a notion, so that nobody cites the paper for what is not in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    Buff,
    Liff,
    Sift,
    Ours,
}

impl Origin {
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Self::Buff => ["BuFF paper", "Of the BuFF paper: Ravendran, Bryson, Dansereau, arXiv 2209.09470"],
            Self::Liff => ["LiFF", "Of LiFF, which the BuFF paper follows: Dansereau, Girod, Wetzstein, CVPR 2019"],
            Self::Sift => ["SIFT", "Of SIFT, which BuFF and LiFF follow: Lowe, IJCV 60, 2004"],
            Self::Ours => ["ours", "Of this program, not of the paper; docs/METHOD.md says why, and what it measured"],
        }
    }
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Word {
    /// Name in links: lower-case letters, digits and dashes.
    #[serde(deserialize_with = "text")]
    pub name: String,
    /// Term, as the window writes it.
    #[serde(deserialize_with = "text")]
    pub word: String,
    pub symbol: Option<String>,
    /// Source of the notion; none for terms of everybody.
    pub origin: Option<Origin>,
    /// Explanation, in CommonMark.
    #[serde(deserialize_with = "text")]
    pub text: String,
    #[serde(default)]
    pub pictures: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Glossary {
    pub words: Vec<Word>,
}

pub fn glossary() -> &'static Glossary {
    static GLOSSARY: OnceLock<Glossary> = OnceLock::new();
    GLOSSARY.get_or_init(|| match Glossary::read(TEXT) {
        Ok(glossary) => glossary,
        Err(error) => unreachable!("a test reads the glossary: {error}"),
    })
}

impl Glossary {
    pub fn read(text: &str) -> Result<Self, String> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct File {
            word: Vec<Word>,
        }
        let File { word: mut words } = toml::from_str(text).map_err(|error| error.to_string())?;
        // A kind of picture that gets another name must not lose its entry unnoticed.
        for Word { word, pictures: explained, .. } in &words {
            if let Some(name) = explained.iter().find(|name| !pictures().any(|picture| picture == **name)) {
                return Err(format!("{word}: there is no kind of picture '{name}'"));
            }
        }
        words.sort_by_key(|word| word.word.to_lowercase());
        Ok(Self { words })
    }

    pub fn find(&self, name: &str) -> Option<&Word> {
        self.words.iter().find(|word| word.name == name)
    }

    /// Finds the entry that explains a parameter, by the parameter's name on the command line.
    pub fn of_parameter(&self, name: &str) -> Option<&Word> {
        self.find(parameters().find(|doc| doc.name == name)?.term)
    }

    pub fn of_picture(&self, name: &str) -> Option<&Word> {
        self.words.iter().find(|word| word.pictures.iter().any(|picture| picture == name))
    }

    /// Entries that match `text`: term begins with it or symbol is it, then term contains it, then explanation does.
    pub fn search(&self, text: &str) -> Vec<&Word> {
        let text = text.trim().to_lowercase();
        let rank = |word: &Word| {
            let title = word.word.to_lowercase();
            let symbol = word.symbol.as_ref().is_some_and(|symbol| symbol.to_lowercase() == text);
            if title.starts_with(&text) || symbol {
                Some(0)
            } else if title.contains(&text) {
                Some(1)
            } else {
                word.text.to_lowercase().contains(&text).then_some(2)
            }
        };
        let mut found: Vec<_> = self.words.iter().filter_map(|word| Some((rank(word)?, word))).collect();
        // Within a rank they stay in alphabetical order.
        found.sort_by_key(|(rank, _)| *rank);
        found.into_iter().map(|(_, word)| word).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_and_every_kind_of_picture_has_its_word() {
        let glossary = Glossary::read(TEXT).expect("good");
        for doc in parameters() {
            assert!(glossary.of_parameter(doc.name).is_some(), "{} is not explained", doc.name);
        }
        // Nobody is to cite the paper for a parameter of ours.
        for doc in crate::detector::params::doc::ALL.iter().filter(|doc| doc.name != "frames") {
            let word = glossary.of_parameter(doc.name).expect("explained");
            assert!(word.origin.is_some(), "{}: nobody knows whose '{}' is", doc.name, word.word);
        }
        for picture in pictures() {
            assert!(glossary.of_picture(picture).is_some(), "the picture {picture} is not explained");
        }
    }

    #[test]
    fn words_are_short_have_names_of_their_own_and_link_to_one_another() {
        let glossary = glossary();
        let mut names: Vec<&str> = glossary.words.iter().map(|word| word.name.as_str()).collect();
        let count = names.len();
        assert!(count >= 50, "{count} words");
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "two words have one name");
        for word in &glossary.words {
            let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            assert!(word.name.chars().all(is_name), "{}", word.name);
            let length = word.text.split_whitespace().count();
            assert!((6..=75).contains(&length), "{}: {length} words", word.word);
            for link in word.text.split("](word:").skip(1) {
                let name = link.split(')').next().expect("a part");
                assert!(glossary.find(name).is_some(), "{}: no word is called '{name}'", word.word);
            }
        }
    }

    #[test]
    fn words_are_found_by_their_beginnings_parts_symbols_and_explanations() {
        for (text, first) in
            [("slope", Some("slope")), ("λ", Some("slope")), ("gate", Some("noise-gate")), ("qqqq", None)]
        {
            assert_eq!(glossary().search(text).first().map(|word| word.name.as_str()), first);
        }
        assert_eq!(glossary().search(" ").len(), glossary().words.len());
    }

    #[test]
    fn a_glossary_with_a_mistake_is_refused() {
        for text in [
            "",
            "[[word]]\nname = 'a'",
            "[[word]]\nname='a'\nword='A'\ntext='x'\nparameters=['gate']",
            "[[word]]\nname='a'\nword='A'\ntext='x'\npictures=['photo']",
        ] {
            assert!(Glossary::read(text).is_err(), "{text}");
        }
    }
}
