//! Tests that every parameter is an option, and that every option sets its parameter.

use super::*;
use crate::detector::{FrameRange, SlopeAxis, Slopes};
use clap::{CommandFactory, Parser};

#[derive(Parser)]
struct Only {
    #[command(flatten)]
    search: SearchArgs,
}

fn params(arguments: &[&str]) -> Result<SearchParams, String> {
    let only = Only::try_parse_from([&["x"], arguments].concat()).map_err(|e| e.to_string())?;
    only.search.params().map_err(|f| format!("{f:?}"))
}

#[test]
fn every_parameter_is_an_option_with_its_help() {
    let command = Only::command();
    for doc in doc::ALL {
        let arg = command.get_arguments().find(|a| a.get_long() == Some(doc.name));
        let arg = arg.unwrap_or_else(|| panic!("--{} is missing", doc.name));
        let text = |help: Option<&clap::builder::StyledStr>| help.expect("it has help").to_string();
        assert!(text(arg.get_help()).starts_with(doc.meaning.trim_end_matches('.')));
        assert!(text(arg.get_long_help()).starts_with(&doc.help()));
        // The shown default can be typed, or says how it is chosen.
        let default = doc.default_text();
        let option = format!("--{}", doc.name);
        if doc.default_words.is_none() {
            assert_eq!(params(&[option.as_str(), &default]), Ok(SearchParams::default()), "{}", doc.name);
        }
    }
}

/// Every option with a value that is not the default, and the parameters that follow.
pub(in crate::cli) fn everything() -> (Vec<String>, SearchParams) {
    let (mut arguments, mut expected) = (Vec::new(), SearchParams::default());
    let mut records: Vec<_> = doc::ALL.into_iter().filter(|record| *record != doc::SLOPES).collect();
    // Rules imply values of other parameters, which given options replace.
    records.sort_by_key(|record| *record != doc::RULES);
    for record in records {
        let mut sample = SearchParams::default();
        let default = record.text(&sample);
        let words = (record.field)(&mut sample).words().unwrap_or_default().iter().map(|(word, _)| *word);
        let mut others =
            words.chain(["-6:6:25", "2..9", "0.5", "2.5", "-1", "3", "off"]).filter(|text| *text != default);
        let valid = |text: &&str| record.read(&mut sample, text).is_ok() && record.check(&sample).is_ok();
        let text = others.rfind(valid).unwrap_or_else(|| panic!("{}: no other value", record.name));
        record.read(&mut expected, text).expect("read above");
        arguments.extend([format!("--{}", record.name), text.to_owned()]);
    }
    (arguments, expected)
}

#[test]
fn every_option_reaches_its_parameter() {
    let (arguments, expected) = everything();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let got = params(&arguments).expect("valid");
    assert_eq!(got, expected);
    assert_eq!(got.frames, Some(FrameRange { start: 2, end: 9 }));
    for record in doc::ALL.into_iter().filter(|record| *record != doc::SLOPES) {
        assert_ne!(record.text(&got), record.text(&SearchParams::default()), "{}", record.name);
    }
    assert_eq!(params(&["--frames", "all"]), Ok(SearchParams::default()));
}

#[test]
fn a_direction_alone_says_on_which_line_slopes_are_found() {
    let line = Slopes::Auto { direction_deg: Some(30.0) };
    assert_eq!(params(&["--slope-direction", "30"]).expect("valid").slopes, line);
    assert_eq!(params(&["--slopes", "auto", "--slope-direction", "30"]).expect("valid").slopes, line);
    let given = params(&["--slopes-u", "0:2:3", "--slope-direction", "30"]).expect("valid");
    assert_eq!(given.slopes.given().map(|grid| grid.direction_deg), Some(30.0));
    // One axis alone makes the other zero.
    let slopes = params(&["--slopes-v", "-2:2:5"]).expect("valid").at_given().slopes;
    assert_eq!((slopes.u, slopes.v.count), (SlopeAxis::ZERO, 5));
}
