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
    /// A path that is missing or holds no pictures, a cut that makes no sense, a sequence that is
    /// too short for it.
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
    make_file_names_unique(bursts.iter_mut().map(|b| &mut b.name));
    bursts
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn film(folder: &Path, frames: usize) {
        std::fs::create_dir_all(folder).expect("made");
        let frame = image::GrayImage::from_pixel(4, 4, image::Luma([9]));
        (0..frames).for_each(|t| frame.save(folder.join(format!("f{t}.png"))).expect("written"));
    }

    fn names(source: &DatasetSource) -> Vec<String> {
        source.bursts(&OpenOptions::default()).expect("bursts").into_iter().map(|b| b.name).collect()
    }

    #[test]
    fn folders_of_bursts_and_cut_sequences() {
        let home = tempfile::tempdir().expect("a folder");
        film(&home.path().join("nights/a"), 2);
        film(&home.path().join("nights/b"), 5);
        let nights = DatasetSource::of_bursts(vec![home.path().join("nights")]);
        assert_eq!(names(&nights), ["a", "b"]);
        let one = DatasetSource { paths: vec![home.path().join("nights/b")], burst_length: Some(2), burst_step: None };
        assert_eq!(names(&one), ["f1", "f3"]);
        let overlapping = DatasetSource { burst_step: Some(1), ..one.clone() };
        assert_eq!(names(&overlapping), ["f1", "f2", "f3", "f4"]);
        let both = DatasetSource { burst_length: Some(2), ..nights.clone() };
        assert_eq!(names(&both), ["a_f1", "b_f1", "b_f3"]);
        for (wrong, words) in [
            (DatasetSource { burst_length: Some(3), ..nights.clone() }, "2 frames"),
            (DatasetSource { burst_length: Some(0), ..nights.clone() }, "1"),
            (DatasetSource::of_bursts(vec![home.path().join("gone")]), "gone"),
            (DatasetSource::of_bursts(Vec::new()), "nothing"),
        ] {
            let error = wrong.bursts(&OpenOptions::default()).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
        assert_eq!(nights.default_folder(), Some(home.path().join("nights-burstscope")));
        assert_eq!(one.default_folder(), Some(home.path().join("nights/b-burstscope-2")));
        assert_eq!(overlapping.default_folder(), Some(home.path().join("nights/b-burstscope-2-1")));
        assert_eq!(nights.label(), "nights");
    }
}
