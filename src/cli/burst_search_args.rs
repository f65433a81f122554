//! Arguments of every command that opens and searches bursts: the search, the calibration and the output.

use super::calibration_args::CalibrationArgs;
use super::output_args::OutputArgs;
use super::search_options::SearchArgs;
use clap::Args;

/// How bursts are searched and opened, and what is said of it.
#[derive(Debug, Clone, Args)]
pub struct BurstSearchArgs {
    #[allow(missing_docs)]
    #[command(flatten)]
    pub search: SearchArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub calibration: CalibrationArgs,
    #[allow(missing_docs)]
    #[command(flatten)]
    pub output: OutputArgs,
}
