//! Resolves typed arguments to what the window opens: one burst, two side by side, a dataset, or a session.

use super::failure::complain;
use super::{Failure, Input, Outcome, SequenceArgs, resolve, resolve_one};
use crate::burst::{OpenOptions, SequenceCut};
use crate::dataset::DatasetSource;
use crate::error::ErrorKind;
use std::path::PathBuf;

/// `None` where they are not two bursts: two files may be frames of one, and a folder of bursts is a dataset.
pub(super) fn two_of(arguments: &[PathBuf], options: &OpenOptions) -> Option<[Input; 2]> {
    let [first, second] = arguments else { return None };
    let each = |argument: &PathBuf| resolve(std::slice::from_ref(argument), options).len() == 1;
    let two: [Input; 2] = resolve(arguments, options).try_into().ok()?;
    (each(first) && each(second)).then_some(two)
}

#[derive(Debug)]
pub(super) enum Opening {
    Burst(Input),
    Two([Input; 2]),
    Dataset(DatasetSource),
    Session(PathBuf),
}

/// A session file, one burst, two bursts if each argument is one, or a dataset if there are more or it is cut.
pub(super) fn what_to_open(arguments: &[PathBuf], sequence: SequenceArgs, options: &OpenOptions) -> Outcome<Opening> {
    let SequenceArgs { burst_length, burst_step } = sequence;
    if let [one] = arguments
        && one.is_file()
        && one.extension().is_some_and(|extension| extension == "toml")
    {
        return Ok(Opening::Session(one.clone()));
    }
    let inputs = resolve(arguments, options);
    if inputs.len() < 2 && burst_length.is_none() {
        return Ok(Opening::Burst(resolve_one(arguments, "the window", options)?));
    }
    if let Some(two) = two_of(arguments, options).filter(|_| burst_length.is_none()) {
        return Ok(Opening::Two(two));
    }
    if let Some(length) = burst_length {
        SequenceCut::new(length, burst_step).map_err(|e| Failure::usage(format!("--burst-length: {e}")))?;
    }
    for input in inputs {
        match input.source {
            Ok(source) if source.name().is_some() => {
                return Err(Failure::usage(
                    "a built-in burst can be opened alone or with one other burst, and cannot be cut; leave the other inputs or --burst-length out",
                ));
            }
            Ok(_) => {}
            // A stray picture does not keep the bursts from opening.
            Err(error) if error.kind == ErrorKind::Stray => complain(&error.to_string()),
            Err(error) => return Err(error.into()),
        }
    }
    Ok(Opening::Dataset(DatasetSource { paths: arguments.to_vec(), burst_length, burst_step }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::inputs::DEMO;

    #[test]
    fn two_arguments_are_two_bursts_if_each_is_one_and_several_bursts_are_a_dataset() {
        let home = tempfile::tempdir().expect("a folder");
        let film = |name: &str| home.path().join(name);
        let frame = |name: &str, t: usize| film(name).join(format!("{t}.png"));
        for name in ["a", "b"] {
            std::fs::create_dir(film(name)).expect("made");
            (0..4).for_each(|t| image::GrayImage::new(8, 8).save(frame(name, t)).expect("written"));
        }
        let two = |paths: &[PathBuf]| two_of(paths, &OpenOptions::default()).map(|two| two.map(|input| input.name));
        assert_eq!(two(&[film("a"), "demo-later".into()]), Some(["a".into(), "demo-later".into()]));
        assert_eq!(two(&[frame("a", 0), frame("a", 1)]), None, "two pictures are frames of one burst");
        assert_eq!(two(&[film("a")]), None);
        let open = |paths: &[PathBuf], burst_length| {
            what_to_open(paths, SequenceArgs { burst_length, burst_step: None }, &OpenOptions::default())
        };
        let dataset = |opening: Outcome<Opening>| match opening.expect("found") {
            Opening::Dataset(source) => {
                source.bursts(&OpenOptions::default()).expect("bursts").into_iter().map(|b| b.name).collect()
            }
            Opening::Burst(_) | Opening::Two(_) | Opening::Session(_) => Vec::new(),
        };
        assert!(matches!(open(&[film("a")], None), Ok(Opening::Burst(_))));
        assert!(matches!(open(&[DEMO.into()], None), Ok(Opening::Burst(_))));
        assert_eq!(dataset(open(&[home.path().into()], None)), ["a", "b"]);
        assert_eq!(dataset(open(&[film("a")], Some(2))), ["1", "3"]);
        assert_eq!(dataset(open(&[home.path().into()], Some(4))), ["a_2", "b_2"]);
        assert!(matches!(open(&[DEMO.into(), film("a")], None), Ok(Opening::Two(_))));
        assert!(open(&[DEMO.into(), home.path().into()], None).is_err() && open(&[DEMO.into()], Some(2)).is_err());
        assert!(open(&[film("a"), film("b"), film("gone")], None).is_err() && open(&[film("a")], Some(0)).is_err());
    }
}
