//! Options made from the records of parameters: name, help, value names and parsing are the record's.

use crate::detector::params::{Field, Param};
use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgMatches};

/// Values that options give for parameters of `P`; each can be read by its record.
#[derive(Debug, Clone)]
pub(super) struct Given<P: 'static>(Vec<(Param<P>, String)>);

impl<P> Default for Given<P> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<P: Default + 'static> Given<P> {
    pub(super) fn among(records: &[Param<P>], matches: &ArgMatches) -> Self {
        let value = |record: &Param<P>| Some((*record, matches.get_one::<String>(record.name)?.clone()));
        Self(records.iter().filter_map(value).collect())
    }

    pub(super) fn has(&self, record: &Param<P>) -> bool {
        self.0.iter().any(|(given, _)| given == record)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &(Param<P>, String)> {
        self.0.iter()
    }
}

pub(super) fn option<P: Default + 'static>(record: Param<P>) -> Arg {
    let arg = Arg::new(record.name)
        .long(record.name)
        .value_name(record.placeholder)
        .help(record.short_help())
        .long_help(record.long_help());
    // A value that may begin with a minus would be taken for an option.
    let negative = record.bounds.is_some_and(|bounds| *bounds.span().start() < 0.0);
    let mut default = P::default();
    let field = (record.field)(&mut default);
    let hyphens = negative || matches!(field, Field::Axis(_) | Field::Slopes(..));
    match field.words() {
        Some(words) => arg.value_parser(PossibleValuesParser::new(words.iter().map(|(word, _)| *word))),
        None => arg
            .allow_hyphen_values(hyphens)
            .value_parser(move |text: &str| record.read(&mut P::default(), text).map(|()| text.to_owned())),
    }
}
