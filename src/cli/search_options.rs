//! Search options, shared by the commands: raw arguments and the parameters checked from them.
//!
//! Names and help texts are those of [`crate::detector::params::doc`]. The user's defaults are read first, then a
//! parameter file, whose values override them, as each given option does after that.

use super::failure::complain;
use super::{Failure, Outcome};
use crate::detector::SearchParams;
use crate::detector::params::{AUTO, Field, Param, doc};
use crate::export::case::{is_case, read_about};
use crate::files::{MAX_SETTINGS_BYTES, explained, read_text};
use crate::matching::MatchParams;
use anyhow::Context;
use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use std::path::{Path, PathBuf};

/// The parameter file.
#[derive(Debug, Clone, Default, Args)]
pub struct ParamsFileArg {
    /// Parameter file (TOML), as the window saves it, or a case, whose search is taken; its table 'matching' has
    /// options of matching.
    #[arg(long, value_name = "FILE.toml")]
    pub params: Option<PathBuf>,
    /// The user's defaults, which come before. The window has none.
    #[arg(skip)]
    defaults: Option<PathBuf>,
}

const HEADING: &str = "Search options";

/// The search options as they are written: one for each record of a parameter.
#[derive(Debug, Clone, Default)]
pub struct SearchArgs {
    pub file: ParamsFileArg,
    given: Given<SearchParams>,
}

impl Args for SearchArgs {
    fn augment_args(command: Command) -> Command {
        let command = ParamsFileArg::augment_args(command.allow_negative_numbers(true));
        let options = doc::ALL.map(|record| {
            // `auto` is the only word for slopes, and a range beside it would contradict it.
            if record == doc::SLOPES {
                option(record).value_parser([AUTO]).conflicts_with_all([doc::SLOPES_U.name, doc::SLOPES_V.name])
            } else {
                option(record)
            }
        });
        let command = command.mut_arg("params", |arg| arg.help_heading(HEADING));
        command.args(options.map(|option| option.help_heading(HEADING)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SearchArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let file = ParamsFileArg { defaults: defaults_file(), ..ParamsFileArg::from_arg_matches(matches)? };
        Ok(Self { file, given: Given::among(&doc::ALL, matches) })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        Self::from_arg_matches(matches).map(|args| *self = args)
    }
}

impl ParamsFileArg {
    /// Parameters of the file of the option, without the user's defaults.
    pub fn read(&self) -> Outcome<SearchParams> {
        self.params.as_deref().map_or(Ok(SearchParams::default()), read_params)
    }

    /// Options in the tables `[matching]` of the files. A case has none.
    pub fn matching(&self) -> Outcome<toml::Table> {
        let mut table = toml::Table::new();
        for path in self.files().filter(|path| !is_case(path)) {
            let text = text_of(path)?;
            table.extend(MatchParams::table_of(&text).map_err(|why| nonsense(path, &text, &why))?);
        }
        Ok(table)
    }

    fn read_or(&self, built_in: SearchParams) -> Outcome<SearchParams> {
        // What a parameter file leaves out is as everywhere, whichever command reads it.
        let base = if self.params.is_some() { SearchParams::default() } else { built_in };
        self.files().try_fold(base, |base, path| read_over(base, path))
    }

    /// Each over those before it.
    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.defaults.iter().chain(&self.params)
    }
}

/// Variable that names the file of the user's defaults, which is read before all others; an empty one names none.
const VARIABLE: &str = "BURSTSCOPE_DEFAULTS";

/// Where the file is, unless the variable names another.
#[cfg(windows)]
pub(super) const DEFAULTS_PLACE: &str = r"%APPDATA%\burstscope\defaults.toml";
#[cfg(target_os = "macos")]
pub(super) const DEFAULTS_PLACE: &str = "~/Library/Application Support/burstscope/defaults.toml";
#[cfg(not(any(windows, target_os = "macos")))]
pub(super) const DEFAULTS_PLACE: &str = "~/.config/burstscope/defaults.toml (or below $XDG_CONFIG_HOME)";

/// The file that the variable names, or the one at its usual place, if there is one.
pub(super) fn defaults_file() -> Option<PathBuf> {
    // Results of unit tests do not depend on the files of whoever runs them.
    if cfg!(test) {
        return None;
    }
    match std::env::var_os(VARIABLE) {
        Some(named) => Some(PathBuf::from(named)).filter(|named| !named.as_os_str().is_empty()),
        None => usual_file().filter(|usual| usual.exists()),
    }
}

fn usual_file() -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|folder| folder.is_absolute());
    let below_home = |folder: &str| std::env::home_dir().map(|home| home.join(folder));
    let folder = if cfg!(windows) {
        variable("APPDATA")
    } else if cfg!(target_os = "macos") {
        below_home("Library/Application Support")
    } else {
        variable("XDG_CONFIG_HOME").or_else(|| below_home(".config"))
    };
    Some(folder?.join("burstscope").join("defaults.toml"))
}

fn text_of(path: &Path) -> Outcome<String> {
    let text = read_text(path, MAX_SETTINGS_BYTES);
    text.with_context(|| format!("cannot read the parameter file {}", path.display())).map_err(Failure::Failed)
}

fn nonsense(path: &Path, text: &str, why: &str) -> Failure {
    let why = explained(text, why.trim_end());
    Failure::usage(format!("the parameter file {} makes no sense: {why}", path.display()))
}

/// Parameters in the file at `path`; those of a case, if it is one.
pub fn read_params(path: &Path) -> Outcome<SearchParams> {
    read_over(SearchParams::default(), path)
}

fn read_over(base: SearchParams, path: &Path) -> Outcome<SearchParams> {
    if is_case(path) {
        return read_about(path).map(|case| case.search).map_err(|error| Failure::usage(error.to_string()));
    }
    let text = text_of(path)?;
    base.with_toml(&text).map_err(|why| nonsense(path, &text, &why))
}

impl SearchArgs {
    /// The given options replace the values of the files: see [`SearchParams::with_texts`].
    pub fn params(&self) -> Outcome<SearchParams> {
        self.params_over(SearchParams::default())
    }

    /// As [`Self::params`], for a command with other `defaults`; those of a parameter file are the usual ones.
    pub fn params_over(&self, defaults: SearchParams) -> Outcome<SearchParams> {
        let params = self.file.read_or(defaults)?.with_texts(self.given.iter())?;
        if let Some(path) = &self.file.defaults {
            complain(&format!("note: took defaults from {}", path.display()));
        }
        Ok(params)
    }

    /// As [`Self::params`] without the user's defaults, as in the window.
    pub fn params_of_window(&self) -> Outcome<SearchParams> {
        Ok(self.file.read()?.with_texts(self.given.iter())?)
    }

    pub fn gives(&self, record: &Param<SearchParams>) -> bool {
        self.given.0.iter().any(|(given, _)| given == record)
    }
}

/// Values that options give for parameters of `P`; each can be read by its record.
#[derive(Debug, Clone, Default)]
pub(super) struct Given<P: 'static>(Vec<(Param<P>, String)>);

impl<P: Default + 'static> Given<P> {
    pub(super) fn among(records: &[Param<P>], matches: &ArgMatches) -> Self {
        let value = |record: &Param<P>| Some((*record, matches.get_one::<String>(record.name)?.clone()));
        Self(records.iter().filter_map(value).collect())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (Param<P>, &str)> {
        self.0.iter().map(|(record, text)| (*record, text.as_str()))
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

#[cfg(test)]
pub(super) mod tests;
