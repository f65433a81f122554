//! Source of `burstscope/_keywords.py`: the keywords of Python's functions with their types, made from the records of
//! the parameters and from the options of the commands.

use crate::parameters::keyword;
use burstscope::cli::commands::Cli;
use burstscope::detector::params::{Field, Param, doc};
use burstscope::detector::{SearchParams, SlopeGrid};
use burstscope::matching::MatchParams;
use burstscope::matching::params::doc as matching_doc;
use clap::{Arg, ArgAction, Command, CommandFactory};
use pyo3::prelude::*;
use std::any::TypeId;
use std::fmt::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;

const HEAD: &str = r#""""Keywords of the functions, with their types: made from the program's table of parameters and its options.

`make keywords` writes this file; a test compares it with the program.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, TypedDict, Union

from numpy.typing import NDArray

Path = Union[str, "os.PathLike[str]"]
Axis = Union[str, float, tuple[float, float, int], Sequence[float], NDArray[Any]]
Frames = Union[str, tuple[int, int], slice, range]
"#;

/// Options of commands that Python's functions set themselves, or that make no sense there.
const NOT_KEYWORDS: [&str; 8] = ["help", "version", "out", "json", "quiet", "plot", "table", "force"];

/// The source of the module with the keywords.
#[pyfunction]
pub(crate) fn keywords_source() -> String {
    let mut text = HEAD.to_owned();
    let detector = doc::ALL.iter().map(|record| (record.name, of_record(record), lines_of(record)));
    class(&mut text, "DetectorKeywords", "Parameters of the detector: see `burstscope.detect`.", detector);
    let matching = matching_doc::ALL.iter().filter(|record| **record != matching_doc::CAMERA);
    let matching = matching.map(|record| (record.name, of_match_record(record), lines_of(record)));
    class(&mut text, "MatchKeywords", "Parameters of matching: see `burstscope.match`.", matching);
    let cli = Cli::command();
    for (path, name) in [
        (["synth", "chart"], "ChartKeywords"),
        (["synth", "scene"], "SceneKeywords"),
        (["synth", "trajectory"], "TrajectoryKeywords"),
        (["synth", "noisy"], "NoisyKeywords"),
        (["evaluate", "chart"], "EvaluateChartKeywords"),
        (["evaluate", "frames"], "EvaluateFramesKeywords"),
        (["evaluate", "accuracy"], "EvaluateAccuracyKeywords"),
        (["evaluate", "noise"], "EvaluateNoiseKeywords"),
        (["evaluate", "matches"], "EvaluateMatchesKeywords"),
        (["evaluate", "poses"], "EvaluatePosesKeywords"),
    ] {
        let command = path.iter().try_fold(&cli, |command, name| command.find_subcommand(name));
        let Some(command) = command else { continue };
        class(&mut text, name, &format!("Options of `burstscope {}`.", path.join(" ")), options(command));
    }
    // Commands on a burst in memory: their own options, and the detector's.
    for (path, name) in [("recover", "RecoverKeywords(DetectorKeywords"), ("film", "FilmKeywords(DetectorKeywords")] {
        let Some(command) = cli.find_subcommand(path) else { continue };
        let of_file = cli.find_subcommand("case").map(|case| options(case).map(|(name, ..)| name).collect());
        let of_file: Vec<&str> = of_file.unwrap_or_default();
        let own =
            options(command).filter(|(name, ..)| !of_file.contains(name) && !["case", "scale", "slope"].contains(name));
        let about = format!("Options of `burstscope {path}`; those of `burstscope.detect` are taken too.");
        class(&mut text, name, &about, own);
    }
    let names = cli.get_subcommands().filter(|command| !command.is_hide_set()).map(|command| command.get_name());
    // Writing into a string cannot fail.
    let _ = writeln!(text, "\n\nCOMMANDS = (\n{})", names.map(|name| format!("    \"{name}\",\n")).collect::<String>());
    text
}

/// A class with the fields (name, type, description). Its documentation lists them as numpy's does.
fn class<'a>(text: &mut String, name: &str, about: &str, fields: impl Iterator<Item = (&'a str, String, String)>) {
    let fields: Vec<_> = fields.collect();
    let name = if name.contains('(') { format!("{name}, ") } else { format!("{name}(TypedDict, ") };
    // Writing into a string cannot fail.
    let _ = write!(
        text,
        "\n\nclass {name}total=False):\n    \"\"\"{about}\n\n    Other Parameters\n    ----------------\n"
    );
    for (name, kind, about) in &fields {
        let _ = write!(text, "    {} : {}\n{}", keyword(name), of_numpydoc(kind), wrapped(about));
    }
    text.push_str("    \"\"\"\n\n");
    for (name, kind, _) in &fields {
        let _ = writeln!(text, "    {}: {kind}", keyword(name));
    }
}

/// A type as numpydoc writes it: `Union[float, Literal["auto"]]` is `float or {'auto'}`.
fn of_numpydoc(kind: &str) -> String {
    if let Some(words) = kind.strip_prefix("Literal[").and_then(|rest| rest.strip_suffix(']')) {
        return format!("{{{}}}", words.replace('"', "'"));
    }
    let Some(parts) = kind.strip_prefix("Union[").and_then(|rest| rest.strip_suffix(']')) else {
        return kind.to_owned();
    };
    let mut depth = 0;
    let is_between = |c: char| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        c == ',' && depth == 0
    };
    let parts: Vec<String> = parts.split(is_between).map(|part| of_numpydoc(part.trim())).collect();
    parts.join(" or ")
}

/// The text in lines of at most 112 characters below a keyword.
fn wrapped(text: &str) -> String {
    const INDENT: &str = "        ";
    let (mut lines, mut line) = (String::new(), INDENT.to_owned());
    for word in text.split_whitespace() {
        if line.chars().count() + word.chars().count() > 112 {
            lines += line.trim_end();
            lines.push('\n');
            line.replace_range(.., INDENT);
        }
        line += word;
        line.push(' ');
    }
    lines + line.trim_end() + "\n"
}

/// Description of a parameter.
fn lines_of<P: Default>(record: &Param<P>) -> String {
    record.long_help().replace('\\', "\\\\")
}

fn words(words: impl Iterator<Item = impl AsRef<str>>) -> String {
    let words: Vec<String> = words.map(|word| format!("\"{}\"", word.as_ref())).collect();
    format!("Literal[{}]", words.join(", "))
}

fn of_record(record: &Param<SearchParams>) -> String {
    if *record == doc::SLOPES {
        return "Literal[\"auto\"]".to_owned();
    }
    // Slopes that are found have no fields.
    of_field((record.field)(&mut SearchParams { slopes: SlopeGrid::default().into(), ..SearchParams::default() }))
}

fn of_match_record(record: &Param<MatchParams>) -> String {
    of_field((record.field)(&mut MatchParams::default()))
}

fn of_field(field: Field<'_>) -> String {
    match &field {
        Field::F32(_) => "float".to_owned(),
        Field::U32(_) | Field::I32(_) | Field::Usize(_) | Field::U64(_) => "int".to_owned(),
        Field::Flag(_) => "bool".to_owned(),
        Field::Word(word) => words(word.words().iter().map(|(word, _)| *word)),
        Field::Axis(_) => "Axis".to_owned(),
        Field::Frames(_) => "Frames".to_owned(),
        Field::Gate(_) => "Union[float, Literal[\"auto\", \"matching\", \"strict\"]]".to_owned(),
        Field::Distinct(_) => "Union[float, Literal[\"off\"]]".to_owned(),
        Field::Text(_) | Field::Slopes(..) => "str".to_owned(),
    }
}

/// Name, type and description of each option that is a keyword.
fn options(command: &Command) -> impl Iterator<Item = (&str, String, String)> {
    let options = command.get_arguments().filter_map(|arg| Some((arg.get_long()?, arg)));
    options.filter(|(name, _)| !NOT_KEYWORDS.contains(name)).map(|(name, arg)| {
        let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
        let default = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect::<Vec<_>>();
        let default = if default.is_empty() { String::new() } else { format!(" [default: {}]", default.join(",")) };
        (name, of_option(name, arg), format!("{help}{default}").replace('\\', "\\\\"))
    })
}

fn of_option(name: &str, arg: &Arg) -> String {
    // Parameters have one type everywhere.
    let value_name = arg.get_value_names().and_then(|names| names.first()).map_or("", |name| name.as_str());
    if let Some(record) = doc::ALL.iter().find(|record| record.name == name && record.placeholder == value_name) {
        return of_record(record);
    }
    if let Some(record) =
        matching_doc::ALL.iter().find(|record| record.name == name && record.placeholder == value_name)
    {
        return if *record == matching_doc::CAMERA { "str".to_owned() } else { of_match_record(record) };
    }
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        return "bool".to_owned();
    }
    match value_name {
        "MIN:MAX:COUNT" => return "Axis".to_owned(),
        "MIN:MAX" => return "Union[str, tuple[float, float]]".to_owned(),
        // Such as 8G or 50%.
        "SIZE" => return "str".to_owned(),
        _ => {}
    }
    let possible: Vec<_> = arg.get_possible_values();
    let kind = arg.get_value_parser().type_id();
    let of = |ids: &[TypeId]| ids.iter().any(|id| kind == *id);
    let one = if !possible.is_empty() {
        words(possible.iter().map(|value| value.get_name()))
    } else if of(&[TypeId::of::<f64>(), TypeId::of::<f32>()]) {
        "float".to_owned()
    } else if of(&[TypeId::of::<usize>(), TypeId::of::<u64>(), TypeId::of::<u32>(), TypeId::of::<NonZeroUsize>()]) {
        "int".to_owned()
    } else if of(&[TypeId::of::<PathBuf>()]) {
        "Path".to_owned()
    } else {
        "Union[str, float]".to_owned()
    };
    let several = arg.get_value_delimiter().is_some() || matches!(arg.get_action(), ArgAction::Append);
    if several { format!("Union[{one}, Sequence[{one}]]") } else { one }
}
