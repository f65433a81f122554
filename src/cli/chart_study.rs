//! Parts that `evaluate chart` and `evaluate frames` share: the study of charts and its figure.

use super::charts_args::{ChartsArgs, ComparedArgs};
use super::console::Console;
use super::failure::Failure;
use super::search_options::SearchArgs;
use super::study::{Searched, once_each, searched_by};
use crate::evaluate::ChartStudy;
use crate::export::{OutputRules, write_whole};
use std::io::Write;
use std::path::Path;

/// Makes a study of charts at the signal-to-noise ratios `snrs`.
pub(super) fn chart_study(
    (charts, compared): (&ChartsArgs, &ComparedArgs),
    search: &SearchArgs,
    snrs: Vec<f64>,
) -> Result<ChartStudy, Failure> {
    if search.gives(&crate::detector::params::doc::METHOD) {
        return Err(Failure::usage("--method: this command compares several; name them with --methods"));
    }
    let Searched { detector, slopes, direction_deg } = searched_by(search, &compared.methods)?;
    let (slopes_1d, slopes_2d) = ChartStudy::slopes_for(slopes);
    Ok(ChartStudy {
        chart: charts.params(compared.max_slope),
        snrs,
        first_seed: charts.seed,
        seeds: charts.seeds,
        methods: once_each(&compared.methods),
        detector,
        slopes_1d,
        slopes_2d,
        direction_deg,
        ranking: compared.ranking,
        false_fraction: compared.false_fraction,
    })
}

/// Writes the figure, if a path is given.
pub(super) fn write_plot(
    console: &Console,
    path: Option<&Path>,
    rules: &OutputRules,
    svg: impl FnOnce() -> String,
) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    rules.check(path)?;
    write_whole(path, |out| out.write_all(svg().as_bytes()))?;
    console.say(&format!("\nwrote {}\n", path.display()))
}

/// Checks that `path` can name an SVG figure: no folder, and an ending of `.svg`.
pub(super) fn check_plot(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::usage(format!(
            "--plot: this is a folder; name a file such as roc.svg: {}",
            path.display()
        )));
    }
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        return Err(Failure::usage(format!(
            "--plot: the figure is drawn as SVG, which browsers, editors and papers take; name a file that ends in .svg: {}",
            path.display()
        )));
    }
    Ok(())
}
