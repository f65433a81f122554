//! Overwriting rules of a command: see [`OutputRules`].

use super::failure::Failure;
use super::inputs::{Input, Place};
use super::output_args::OverwriteArgs;
use crate::burst::{BurstSource, OpenOptions};
use crate::export::{Inputs, OutputRules, Overwrite};
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
pub(super) fn opened(inputs: &[Input], calibration: &OpenOptions, settings: &[Option<&PathBuf>]) -> Inputs {
    let of_burst = |paths: Vec<PathBuf>| {
        let source = BurstSource { name: String::new(), paths };
        // Paths that cannot be listed cannot be opened either.
        source.files().unwrap_or(source.paths)
    };
    let bursts = inputs.iter().flat_map(|input| match &input.place {
        Place::Paths(paths) => of_burst(paths.clone()),
        Place::Demo { .. } | Place::Example(_) | Place::Broken(_) => Vec::new(),
    });
    let frames =
        [&calibration.bias, &calibration.flat].into_iter().flatten().flat_map(|path| of_burst(vec![path.clone()]));
    let settings = settings.iter().flatten().map(|path| (*path).clone());
    Inputs::of(bursts.chain(frames).chain(settings))
}

/// Checks that `path`, if there is one, may be written.
///
/// # Errors
/// When it must not be overwritten.
pub(super) fn check(rules: &OutputRules, path: Option<&Path>) -> Result<(), Failure> {
    Ok(path.map_or(Ok(()), |path| rules.check(path))?)
}
