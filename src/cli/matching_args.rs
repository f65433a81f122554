//! Matching options, shared by the commands that match: raw arguments and the parameters checked from them.
//!
//! Names and help texts are those of [`crate::matching::params::doc`].

use super::Outcome;
use super::search_options::{Given, ParamsFileArg, option};
use crate::burst::BurstFiles;
use crate::dataset::camera::read_camera;
use crate::dataset::{BurstCameras, CameraChoice};
use crate::matching::params::doc;
use crate::matching::{Camera, MatchParams};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, error::ErrorKind};
use std::path::{Path, PathBuf};

/// The options of matching as they are written: one for each record of a parameter.
#[derive(Debug, Clone, Default)]
pub struct MatchingArgs {
    given: Given<MatchParams>,
    camera: Option<CameraChoice>,
    /// Cameras of the bursts of some folders, by the names of these.
    of_folders: Vec<FolderCamera>,
}

/// A camera, and the name of the folder or burst whose it is; empty for that of all others.
type FolderCamera = (String, CameraChoice);

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
                    .value_parser(|text: &str| own_camera("", text))
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
        let cameras = matches.get_many::<FolderCamera>(doc::CAMERA.name).into_iter().flatten().cloned();
        let (mut of_all, of_folders): (Vec<_>, Vec<_>) = cameras.partition(|(folder, _)| folder.is_empty());
        if of_all.len() > 1 {
            let problem = "--camera: two cameras are given for all bursts; give those of some as FOLDER=CAMERA\n";
            return Err(clap::Error::raw(ErrorKind::ArgumentConflict, problem));
        }
        let (given, camera) = (Given::among(&others, matches), of_all.pop().map(|(_, camera)| camera));
        Ok(Self { given, camera, of_folders })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        Self::from_arg_matches(matches).map(|args| *self = args)
    }
}

impl MatchingArgs {
    /// Files of the given cameras and of the bursts' own; a camera in words has none.
    pub fn camera_files<'a>(&'a self, of_bursts: &'a BurstCameras) -> impl Iterator<Item = &'a PathBuf> {
        let given = self.camera.iter().chain(self.of_folders.iter().map(|(_, camera)| camera));
        given.chain(of_bursts.own.values()).filter_map(CameraChoice::source).filter(|path| path.is_file())
    }

    /// Camera of all bursts but those of some folders, over that of `file`.
    fn camera(&self, file: &ParamsFileArg) -> Outcome<Option<Camera>> {
        let in_file = file.matching()?.remove(doc::CAMERA.name).and_then(|camera| camera.try_into().ok());
        Ok(self.camera.as_ref().and_then(CameraChoice::known).cloned().or(in_file))
    }

    /// Cameras of `bursts`, which were found in `inputs`; `guessed` is that of all others, unless one is given.
    pub fn cameras(
        &self,
        file: &ParamsFileArg,
        bursts: &[BurstFiles],
        inputs: &[PathBuf],
        guessed: CameraChoice,
    ) -> Outcome<BurstCameras> {
        let rest = self.camera(file)?.map_or(guessed, CameraChoice::Known);
        Ok(BurstCameras::of(bursts, inputs, &self.of_folders, rest)?)
    }

    /// Parameters, checked: these over those of `file`. With a camera, or one `of_bursts`, and no geometry, matches are
    /// verified by the essential matrix.
    pub fn params(&self, file: &ParamsFileArg, of_bursts: Option<&Camera>) -> Outcome<MatchParams> {
        let camera = self.camera(file)?;
        let some = camera.clone().or(of_bursts.cloned());
        Ok(MatchParams { camera, ..MatchParams::of_texts(file.matching()?, some, self.given.iter())? })
    }
}

const FOLDER_CAMERA: &str = "FOLDER=CAMERA, given once for each, is the camera of the burst, or of the bursts of the folder, of this name; \
    without an option a file camera.toml beside the frames of a burst, or in a folder above them in the input, is its camera";

/// The option of the cameras for a command whose bursts may have one each.
pub(super) fn cameras_help(arg: Arg) -> Arg {
    let [short, long] = [arg.get_help(), arg.get_long_help()].map(|help| help.cloned().unwrap_or_default());
    let arg = arg.action(ArgAction::Append).value_name("[FOLDER=]CAMERA").value_parser(parse_folder_camera);
    arg.help(format!("{short}; {FOLDER_CAMERA}")).long_help(format!("{long} {FOLDER_CAMERA}."))
}

fn own_camera(folder: &str, text: &str) -> Result<FolderCamera, String> {
    Ok((folder.to_owned(), CameraChoice::Own(parse_camera(text)?, text.into())))
}

/// Reads a camera, alone or after `FOLDER=`.
fn parse_folder_camera(text: &str) -> Result<FolderCamera, String> {
    // The name of a file may have the sign.
    let (folder, camera) = text.split_once('=').filter(|_| !Path::new(text).is_file()).unwrap_or(("", text));
    own_camera(folder, camera)
}

pub fn parse_camera(text: &str) -> Result<Camera, String> {
    if text.to_lowercase().ends_with(".toml") {
        return read_camera(Path::new(text)).map_err(|e| format!("{}; {}", e.problem, e.remedy));
    }
    text.parse()
}
