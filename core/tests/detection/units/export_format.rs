//! Tests of `export::format`.
#![allow(unused_imports)]

use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::export::*;
use std::collections::HashSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

#[test]
fn formats_are_read_as_they_are_shown() {
    for format in ExportFormat::ALL {
        assert_eq!(format.to_string().parse(), Ok(format));
        assert_eq!(format.to_string().to_uppercase().parse(), Ok(format));
    }
    let error = "xlsx".parse::<ExportFormat>().expect_err("unknown").to_string();
    assert!(ExportFormat::ALL.iter().all(|f| error.contains(&f.to_string())), "{error}");
}

#[test]
fn no_name_leaves_its_folder() {
    let paths = [("../../etc/passwd", "_.._etc_passwd"), ("..", "burst"), ("", "burst")];
    for (name, safe) in [("slider-far", "slider-far"), ("a:b?", "a_b_"), (" 夜 1. ", "夜 1")].into_iter().chain(paths)
    {
        assert_eq!(safe_file_name(name), safe);
    }
}

#[test]
fn names_that_would_share_a_file_are_numbered() {
    let mut names = ["a", "A", "a_2", "a:", "a?"].map(str::to_owned);
    make_file_names_unique(names.iter_mut());
    assert_eq!(names, ["a", "A_2", "a_2_2", "a:", "a?_2"]);
}
