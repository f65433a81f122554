//! Files of plots and tables: the options that name them, and how they are written.

use super::args::OverwriteArgs;
use super::console::Console;
use super::failure::Failure;
use super::search_options::SearchArgs;
use crate::burst::OpenOptions;
use crate::export::{Figure, FigureFormat, OutputRules};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::{Path, PathBuf};

/// Name of the file in help texts: its ending says what is written.
pub(super) const FIGURE_FILE: &str = "FILE.svg|pdf|png|csv|tex";

/// The name of a figure's file. Other endings are refused before anything is opened.
pub(super) fn figure_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| FigureFormat::of(&path, &FigureFormat::ALL).map(|_| path))
}

/// The file of a command's table.
#[derive(Debug, Clone, Args)]
pub struct TableArgs {
    /// Write the table as CSV or LaTeX (.tex), or drawn as SVG, PDF or PNG.
    #[arg(long, value_name = FIGURE_FILE, value_parser = figure_file())]
    pub table: Option<PathBuf>,
    #[command(flatten)]
    pub overwrite: OverwriteArgs,
}

impl TableArgs {
    /// The rules for overwriting of a command that opens no burst, once they let the table be written.
    pub(super) fn checked(&self, search: &SearchArgs) -> Result<OutputRules, Failure> {
        let rules = self.overwrite.rules(&[], &OpenOptions::default(), &[search.file.params.as_ref()]);
        self.table.iter().try_for_each(|path| rules.check(path))?;
        Ok(rules)
    }
}

/// Writes a figure that was asked for, and says so.
pub(super) fn write_figure(
    console: &Console,
    path: Option<&Path>,
    rules: &OutputRules,
    figure: impl FnOnce() -> Figure,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    rules.check(path)?;
    figure().write(path)?;
    console.say(&format!("\nwrote {}\n", path.display()))
}
