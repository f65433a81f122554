//! Matching options, shared by the commands that match: raw arguments and the parameters checked from them.
//!
//! Names and help texts are those of [`crate::matching::params::doc`].

use super::Failure;
use super::search_options::{Given, ParamsFileArg, option};
use crate::dataset::camera::read_camera;
use crate::matching::params::doc;
use crate::matching::{Camera, MatchParams};
use clap::{ArgMatches, Args, Command, FromArgMatches};
use std::path::{Path, PathBuf};

/// The options of matching as they are written: one for each record of a parameter.
#[derive(Debug, Clone, Default)]
pub struct MatchingArgs {
    given: Given<MatchParams>,
    camera: Option<Camera>,
    camera_file: Option<PathBuf>,
}

impl Args for MatchingArgs {
    fn augment_args(command: Command) -> Command {
        let options = doc::ALL.map(|record| {
            let arg = option(record);
            // In the help only: the default geometry depends on whether a camera is given.
            if record == doc::GEOMETRY {
                arg.help(format!("{}, or essential with a camera]", record.short_help().trim_end_matches(']')))
            } else if record == doc::CAMERA {
                arg.help(format!("{}; or a TOML file", record.meaning.trim_end_matches('.')))
                    .long_help(format!("{} Or a TOML file with model, width, height and params.", record.help()))
                    .value_parser(parse_camera)
            } else {
                arg
            }
        });
        command.args(options.map(|option| option.help_heading("Matching options")))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for MatchingArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let others: Vec<_> = doc::ALL.into_iter().filter(|record| *record != doc::CAMERA).collect();
        let camera_file = matches.get_raw(doc::CAMERA.name).and_then(|mut raw| raw.next()).map(PathBuf::from);
        Ok(Self {
            given: Given::among(&others, matches),
            camera: matches.get_one::<Camera>(doc::CAMERA.name).cloned(),
            // A camera may be given in words, which name no file.
            camera_file: camera_file.filter(|path| path.is_file()),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl MatchingArgs {
    pub fn camera_file(&self) -> Option<&PathBuf> {
        self.camera_file.as_ref()
    }

    /// Parameters, checked: these over those of `file`. With a camera and no geometry, matches are verified by the
    /// essential matrix.
    pub fn params(&self, file: &ParamsFileArg) -> Result<MatchParams, Failure> {
        Ok(MatchParams::of_texts(file.matching()?, self.camera.clone(), self.given.iter())?)
    }
}

pub fn parse_camera(text: &str) -> Result<Camera, String> {
    if text.to_lowercase().ends_with(".toml") {
        return read_camera(Path::new(text)).map_err(|e| format!("{}; {}", e.problem, e.remedy));
    }
    text.parse()
}
