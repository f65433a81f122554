//! Overwriting rules of a command: see [`OutputRules`].

use super::failure::Failure;
use super::inputs::Input;
use super::output_args::OverwriteArgs;
use crate::burst::OpenOptions;
use crate::export::{OpenedFiles, OutputRules, Overwrite};
use crate::requests::BurstSource;
use std::path::{Path, PathBuf};

impl OverwriteArgs {
    /// Rules of a command that opens `inputs` with this calibration and reads these `settings` (a parameter file, a
    /// session).
    pub(super) fn rules(
        &self,
        inputs: &[Input],
        calibration: &OpenOptions,
        settings: &[Option<&PathBuf>],
    ) -> OutputRules {
        let overwrite = if self.force { Overwrite::Force } else { Overwrite::Refuse };
        OutputRules::new(opened(inputs, calibration, settings), overwrite)
    }
}

/// All files that the command opens.
pub(super) fn opened(inputs: &[Input], calibration: &OpenOptions, settings: &[Option<&PathBuf>]) -> OpenedFiles {
    let bursts = inputs.iter().filter_map(|input| input.source.as_ref().ok()).flat_map(BurstSource::files);
    let frames = [&calibration.bias, &calibration.flat]
        .into_iter()
        .flatten()
        .flat_map(|path| BurstSource::Paths(vec![path.clone()]).files());
    let settings = settings.iter().flatten().map(|path| (*path).clone());
    OpenedFiles::of(bursts.chain(frames).chain(settings))
}

/// Checks that `path`, if there is one, may be written.
///
/// # Errors
/// When it must not be overwritten.
pub(super) fn check(rules: &OutputRules, path: Option<&Path>) -> Result<(), Failure> {
    Ok(path.map_or(Ok(()), |path| rules.check(path))?)
}
