//! The source of a dataset: its paths, and the cutting of long sequences.

use crate::burst::{BurstFiles, Entries, OpenOptions, SequenceCut, cut_sequence, find_entries, name_among_several};
use crate::error::Result;
use crate::export::{make_file_names_unique, safe_file_name};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Source of the bursts of a dataset.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetSource {
    /// A folder of bursts, or several of them, or stacks; or long sequences of frames, if they are cut.
    pub paths: Vec<PathBuf>,
    /// Number of frames of each burst that a sequence is cut into; `None` for no cutting.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub burst_length: Option<usize>,
    /// Number of frames from the start of a burst to the start of the next; `None` for as many as a burst has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub burst_step: Option<usize>,
}

impl DatasetSource {
    /// Source of separate bursts, without cutting.
    pub fn of_bursts(paths: Vec<PathBuf>) -> Self {
        Self { paths, burst_length: None, burst_step: None }
    }

    /// Lists the bursts as `options` open them, in order, each with a unique name. No pixel is read.
    ///
    /// # Errors
    /// A path that is missing or without pictures, a cut that makes no sense, a sequence too short for it.
    pub fn bursts(&self, options: &OpenOptions) -> Result<Vec<BurstFiles>> {
        self.entries(options).map(|found| found.bursts)
    }

    /// As [`Self::bursts`], with the pictures beside them that belong to none.
    pub fn entries(&self, options: &OpenOptions) -> Result<Entries> {
        let Entries { bursts: sequences, strays } = find_entries(&self.paths, options)?;
        let Some(length) = self.burst_length else {
            return Ok(Entries { bursts: with_unique_names(sequences), strays });
        };
        let cut = SequenceCut::new(length, self.burst_step)?;
        // Names of frames may repeat from sequence to sequence.
        let several = sequences.len() > 1;
        let mut bursts = Vec::new();
        for sequence in &sequences {
            bursts.extend(cut_sequence(sequence, cut, options)?.into_iter().map(|burst| match several {
                true => BurstFiles { name: name_among_several(&sequence.name, &burst.name), ..burst },
                false => burst,
            }));
        }
        Ok(Entries { bursts: with_unique_names(bursts), strays })
    }

    /// Label for the user: the last part of its (first) path.
    pub fn label(&self) -> String {
        let name = self.paths.first().and_then(|p| {
            let whole = std::path::absolute(p).unwrap_or_else(|_| p.clone());
            whole.file_name().map(|name| name.to_string_lossy().into_owned())
        });
        name.unwrap_or_else(|| "dataset".to_owned())
    }

    /// The default folder for its features: beside its (first) path, with a different name for each way to cut it.
    pub fn default_folder(&self) -> Option<PathBuf> {
        let first = std::path::absolute(self.paths.first()?).ok()?;
        let mut name = format!("{}-burstscope", safe_file_name(&self.label()));
        for number in self.burst_length.into_iter().chain(self.burst_length.and(self.burst_step)) {
            name = format!("{name}-{number}");
        }
        Some(first.parent()?.join(name))
    }
}

fn with_unique_names(mut bursts: Vec<BurstFiles>) -> Vec<BurstFiles> {
    make_file_names_unique(bursts.iter_mut().map(|b| (&mut b.name, b.paths.first().cloned())));
    bursts
}
