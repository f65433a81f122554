//! Resolves typed arguments to bursts, and gives the rules for overwriting files beside them.
//!
//! Each folder is resolved on its own, so that an unreadable one does not stop the others. Files are resolved together:
//! several pictures are the frames of one burst.

use super::search_options::defaults_file;
use super::{BurstSearchArgs, BurstsArgs, Console, Failure, Outcome, OverwriteArgs, SequenceArgs};
use crate::burst::{
    Burst, BurstFiles, Entries, OpenOptions, SequenceCut, cut_sequence, find_bursts, find_entries, name_among_several,
};
use crate::detect::check_memory;
use crate::detector::SearchParams;
use crate::error::Error;
use crate::export::case::is_case;
use crate::export::{OpenedFiles, OutputRules, Overwrite, make_file_names_unique};
use crate::files::path_text;
use crate::monitor::Monitor;
use crate::requests::BurstSource;
use std::path::{Path, PathBuf};

/// Name of the built-in burst; a folder of that name is given as `./demo`.
#[cfg(any(test, feature = "app"))]
pub(super) const DEMO: &str = "demo";

#[derive(Debug)]
pub(super) struct Input {
    /// Name of the burst, after which its files are named; unique among the inputs.
    pub name: String,
    pub source: Result<BurstSource, Error>,
}

impl Input {
    fn built_in(word: &Path) -> Option<Self> {
        let source = BurstSource::named(word.to_str()?)?;
        Some(Self { name: word.display().to_string(), source: Ok(source) })
    }

    /// Name, to be changed, and first path of the burst; `None` for a built-in burst, which has no path.
    fn name_and_path(&mut self) -> (&mut String, Option<PathBuf>) {
        let path = self.paths().first().cloned();
        (&mut self.name, path)
    }

    pub fn is_built_in(&self) -> bool {
        self.source.as_ref().is_ok_and(|source| source.name().is_some())
    }

    pub fn open(&self, options: &OpenOptions, monitor: &Monitor) -> Outcome<Burst> {
        Ok(self.source.clone()?.burst(options, monitor)?)
    }

    /// A search that needs more memory than there is, is refused before any pixel is read.
    pub fn open_to_search(&self, options: &OpenOptions, params: &SearchParams, monitor: &Monitor) -> Outcome<Burst> {
        if let Ok(BurstSource::Paths(paths)) = &self.source {
            check_memory(paths, options, params, monitor)?;
        }
        self.open(options, monitor)
    }

    pub fn paths(&self) -> &[PathBuf] {
        self.source.as_ref().map_or(&[], BurstSource::paths)
    }

    pub fn path_texts(&self) -> Vec<String> {
        self.paths().iter().map(|path| path_text(path)).collect()
    }
}

/// Resolves `arguments` to bursts opened with `options`, in order; all files come where the first file stands.
pub(super) fn resolve(arguments: &[PathBuf], options: &OpenOptions) -> Vec<Input> {
    let mut inputs = Vec::new();
    let mut files_done = false;
    for argument in arguments {
        if let Some(input) = Input::built_in(argument) {
            inputs.push(input);
        } else if is_case(argument) {
            let name = path_text(Path::new(argument.file_stem().unwrap_or(argument.as_os_str())));
            inputs.push(Input { name, source: Ok(BurstSource::Paths(vec![argument.clone()])) });
        } else if argument.is_dir() {
            inputs.extend(look(std::slice::from_ref(argument), options));
        } else if !files_done {
            files_done = true;
            let is_file = |path: &&PathBuf| Input::built_in(path).is_none() && !path.is_dir() && !is_case(path);
            let files: Vec<PathBuf> = arguments.iter().filter(is_file).cloned().collect();
            inputs.extend(resolve_files(&files, options));
        }
    }
    make_file_names_unique(inputs.iter_mut().map(Input::name_and_path));
    inputs
}

/// Resolves `paths` to bursts; with `sequence`, to the bursts into which their sequences are cut.
pub(super) fn resolve_bursts(paths: &[PathBuf], sequence: SequenceArgs, options: &OpenOptions) -> Outcome<Vec<Input>> {
    let inputs = resolve(paths, options);
    let Some(length) = sequence.burst_length else { return Ok(inputs) };
    let cut =
        SequenceCut::new(length, sequence.burst_step).map_err(|e| Failure::usage(format!("--burst-length: {e}")))?;
    if inputs.iter().any(Input::is_built_in) {
        return Err(Failure::usage("--burst-length: built-in bursts cannot be cut into bursts; leave the option out"));
    }
    // Bursts are named after their frames: of several inputs these may have the same names.
    let several = inputs.len() > 1;
    let mut bursts = Vec::new();
    for input in inputs {
        let Ok(BurstSource::Paths(paths)) = input.source else {
            bursts.push(input);
            continue;
        };
        match cut_sequence(&BurstFiles { name: input.name.clone(), paths }, cut, options) {
            Err(error) => bursts.push(Input { name: input.name, source: Err(error) }),
            Ok(sources) => bursts.extend(sources.into_iter().map(found).map(|burst| {
                let name = if several { name_among_several(&input.name, &burst.name) } else { burst.name };
                Input { name, ..burst }
            })),
        }
    }
    make_file_names_unique(bursts.iter_mut().map(Input::name_and_path));
    Ok(bursts)
}

/// A missing file makes the burst of single pictures fail, whose frame it may be, but not stacks.
fn resolve_files(files: &[PathBuf], options: &OpenOptions) -> Vec<Input> {
    let (present, missing): (Vec<PathBuf>, Vec<PathBuf>) = files.iter().cloned().partition(|f| f.exists());
    if missing.is_empty() {
        return look(files, options);
    }
    let alone = missing.iter().flat_map(|file| look(std::slice::from_ref(file), options));
    if present.is_empty() {
        return alone.collect();
    }
    match find_bursts(&present, options) {
        // Each file is a burst: a missing file fails alone.
        Ok(sources) if present.len() > 1 && sources.len() == present.len() => {
            sources.into_iter().map(found).chain(alone).collect()
        }
        _ => look(files, options),
    }
}

fn found(burst: BurstFiles) -> Input {
    Input { name: burst.name, source: Ok(BurstSource::Paths(burst.paths)) }
}

fn look(paths: &[PathBuf], options: &OpenOptions) -> Vec<Input> {
    match find_entries(paths, options) {
        Ok(Entries { bursts, strays }) => {
            let stray = |path: PathBuf| Input { name: name_of(&path), source: Err(Error::stray(&path)) };
            bursts.into_iter().map(found).chain(strays.into_iter().map(stray)).collect()
        }
        Err(error) => vec![Input { name: name_of(&paths[0]), source: Err(error) }],
    }
}

fn name_of(path: &Path) -> String {
    path_text(Path::new(path.file_name().unwrap_or(path.as_os_str())))
}

pub(super) fn resolve_one(arguments: &[PathBuf], command: &str, options: &OpenOptions) -> Outcome<Input> {
    let mut inputs = resolve(arguments, options);
    match (inputs.pop(), inputs.is_empty()) {
        (Some(input), true) => Ok(input),
        (last, _) => {
            let names: Vec<String> = inputs.into_iter().chain(last).map(|i| i.name).take(8).collect();
            Err(Failure::usage(format!(
                "{command} takes one burst, but the input names several: {}, …; name one of them",
                names.join(", ")
            )))
        }
    }
}

pub(super) fn resolve_pair(a: &Path, b: &Path, options: &OpenOptions) -> Outcome<Vec<Input>> {
    let one = |path: &Path| resolve_one(&[path.to_owned()], "each side of a match", options);
    let mut inputs = vec![one(a)?, one(b)?];
    make_file_names_unique(inputs.iter_mut().map(Input::name_and_path));
    Ok(inputs)
}

pub(super) fn open_options(inputs: &[Input], calibration: &OpenOptions) -> Outcome<OpenOptions> {
    match calibration.given().first() {
        Some((name, _)) if inputs.iter().any(Input::is_built_in) => {
            Err(Failure::usage(format!("--{name}: built-in bursts need no calibration; leave the option out")))
        }
        _ => Ok(calibration.clone()),
    }
}

impl OverwriteArgs {
    /// `settings` are files that the command reads: a parameter file, a session.
    pub(super) fn rules(&self, inputs: &[Input], open: &OpenOptions, settings: &[Option<&PathBuf>]) -> OutputRules {
        let overwrite = if self.force { Overwrite::Force } else { Overwrite::Refuse };
        OutputRules::new(opened(inputs, open, settings), overwrite)
    }
}

pub(super) fn opened(inputs: &[Input], calibration: &OpenOptions, settings: &[Option<&PathBuf>]) -> OpenedFiles {
    let bursts = inputs.iter().filter_map(|input| input.source.as_ref().ok()).flat_map(BurstSource::files);
    let frames = calibration.paths().into_iter().flat_map(|path| BurstSource::Paths(vec![path]).files());
    let settings = settings.iter().flatten().map(|path| (*path).clone());
    OpenedFiles::of(bursts.chain(frames).chain(settings).chain(defaults_file()))
}

/// A command on one burst, before a pixel is read.
pub(super) struct OneBurst {
    pub console: Console,
    pub input: Input,
    pub options: OpenOptions,
    pub rules: OutputRules,
}

impl BurstsArgs {
    /// Begins `command` on the one burst that the inputs name; `outputs` may be written.
    pub(super) fn begin(&self, command: &str, outputs: &[Option<&PathBuf>]) -> Outcome<OneBurst> {
        let Self { inputs, run: BurstSearchArgs { search, calibration, output }, overwrite } = self;
        let console = Console::new(output)?;
        let input = resolve_one(inputs, command, calibration)?;
        let options = open_options(std::slice::from_ref(&input), calibration)?;
        let rules = overwrite.rules(std::slice::from_ref(&input), &options, &[search.file.params.as_ref()]);
        // Refused before anything is computed.
        outputs.iter().flatten().try_for_each(|path| rules.check(path))?;
        console.begin(format!("{}: ", input.name));
        Ok(OneBurst { console, input, options, rules })
    }
}

/// Checks that the name of `path` has one of `endings`; `problem` says why and what to do.
pub(super) fn check_ending(path: &Path, endings: &[&str], problem: &str) -> Outcome {
    let has = |ending: &&str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending));
    if endings.iter().any(has) { Ok(()) } else { Err(Failure::usage(format!("{problem}: {}", path.display()))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_files_are_frames_of_one_burst_and_in_a_pair_a_burst_each() {
        let home = tempfile::tempdir().expect("a folder");
        let [a, b, gone] = ["a.png", "b.png", "gone.png"].map(|name| home.path().join(name));
        [&a, &b].into_iter().for_each(|path| image::GrayImage::new(8, 8).save(path).expect("written"));
        let plain = OpenOptions::default();
        let frames = resolve(&[b.clone(), a.clone(), gone], &plain);
        assert!(frames.len() == 1 && frames[0].source.is_err(), "what is not there may be one of the frames");
        let pair = resolve_pair(&a, &b, &plain).expect("two bursts");
        assert_eq!((pair[0].name.as_str(), pair[1].name.as_str()), ("a", "b"));
    }
}
