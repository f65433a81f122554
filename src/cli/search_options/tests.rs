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

#[test]
fn options_come_before_their_file_before_the_users_defaults_before_what_is_built_in() {
    let home = tempfile::tempdir().expect("a folder");
    let written = |name: &str, text: &str| {
        let path = home.path().join(name);
        std::fs::write(&path, text).expect("written");
        Some(path)
    };
    let defaults = written("defaults.toml", "levels = 4\nmax_features = 70\nedge_threshold = 8.0\n");
    let file = written("mine.toml", "levels = 5\nmax_features = 80\n");
    let search = |params, more: &[&str]| {
        let only = Only::try_parse_from([&["x"], more].concat()).expect("options");
        SearchArgs { file: ParamsFileArg { params, defaults: defaults.clone() }, ..only.search }
    };
    let built_in = SearchParams { levels: 2, octaves: 2, ..SearchParams::default() };
    let read = |params, more: &[&str]| search(params, more).params_over(built_in.clone()).expect("valid");
    let own = SearchParams { levels: 4, max_features: 70, edge_threshold: 8.0, ..built_in.clone() };
    assert_eq!(read(None, &[]), own);
    assert_eq!(read(None, &["--levels", "6"]), SearchParams { levels: 6, ..own.clone() });
    // A file replaces what this command alone has built in, too.
    let of_file = SearchParams { levels: 5, max_features: 80, octaves: SearchParams::default().octaves, ..own.clone() };
    assert_eq!(read(file.clone(), &[]), of_file);
    assert_eq!(read(file.clone(), &["--max-features", "90"]), SearchParams { max_features: 90, ..of_file });
    let of_window = search(file, &[]).params_of_window().expect("valid");
    assert_eq!(of_window, SearchParams { levels: 5, max_features: 80, ..SearchParams::default() });
    // Rules bring what goes with them, as on the command line, and leave what does not.
    let rules = read(written("rules.toml", "rules = \"vlfeat\"\nlevels = 6\n"), &[]);
    let expected = SearchParams { max_features: 70, ..SearchParams::default() }.under(crate::detector::Rules::VLFEAT);
    assert_eq!(rules, SearchParams { levels: 6, ..expected });
}

#[test]
fn tables_of_matching_are_laid_over_one_another() {
    let home = tempfile::tempdir().expect("a folder");
    let [defaults, params] = [("d.toml", "ratio = 0.6\nseed = 7"), ("p.toml", "ratio = 0.7\nmutual = false")]
        .map(|(name, table)| (home.path().join(name), format!("levels = 4\n[matching]\n{table}\n")))
        .map(|(path, text)| std::fs::write(&path, text).map(|()| Some(path)).expect("written"));
    let read = |file: &ParamsFileArg| {
        let table = file.matching().expect("a table");
        MatchParams::of_texts(table, None, []).expect("valid")
    };
    let own = MatchParams { ratio: 0.6, seed: 7, ..MatchParams::default() };
    assert_eq!(read(&ParamsFileArg { params: None, defaults: defaults.clone() }), own);
    assert_eq!(read(&ParamsFileArg { params, defaults }), MatchParams { ratio: 0.7, mutual: false, ..own });
}
