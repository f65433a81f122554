//! Tests of `export::case`.
#![allow(unused_imports)]

use burstscope_core::burst::*;
use burstscope_core::detector::*;
use burstscope_core::error::*;
use burstscope_core::export::*;
use burstscope_core::export::case::*;
use burstscope_core::files::*;
use burstscope_core::files::mark::*;
use burstscope_core::monitor::*;
use burstscope_core::plane::*;
use burstscope_core::synth::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Write};
use std::path::Path;
use std::sync::Arc;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};
use burstscope_core::synth::random::Stream;
use burstscope_core::synth::{ChartParams, synth_chart};
use std::path::PathBuf;

fn chart() -> (Burst, Truth) {
    let chart =
        ChartParams { width: 96, height: 64, discs: 3, frames: 4, radius: 3.6..=8.0, ..ChartParams::default() };
    synth_chart(&chart, &Monitor::default()).expect("a chart")
}

fn written(case: &Case, burst: &Burst, enclosed: &Enclosed) -> (tempfile::TempDir, PathBuf) {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("a.burstcase");
    write_case(&path, (case, burst), enclosed, &Monitor::default()).expect("written");
    (home, path)
}

#[test]
fn damaged_and_hostile_cases_are_refused_and_never_panic() {
    let (burst, truth) = chart();
    let (case, part) =
        Case::of(&burst, &SearchParams::default(), (None, None), "", &Monitor::default()).expect("nobody cancels");
    let enclosed = Enclosed { session: Some("version = 3\n".repeat(20)), truth: Some(truth) };
    let (_home, path) = written(&case, &part, &enclosed);
    let good = std::fs::read(&path).expect("read");
    let mut stream = Stream::new(11, 0);
    let mut refused = 0;
    for round in 0..300 {
        let mut bytes = good.clone();
        match round % 3 {
            0 => bytes.truncate(stream.below(bytes.len())),
            1 => (0..1 + stream.below(8)).for_each(|_| {
                let at = stream.below(bytes.len());
                bytes[at] = stream.below(256) as u8;
            }),
            _ => {
                // The texts at the beginning: settings, session and truth.
                let at = stream.below(2400);
                bytes[at] = b"0123456789.-[]={}\"\n"[stream.below(19)];
            }
        }
        std::fs::write(&path, &bytes).expect("written");
        let others = [read_session(&path).err(), read_truth(&path).err()];
        assert!(others.iter().flatten().all(|error| error.to_string().contains("a.burstcase")), "{others:?}");
        match read_case(&path, &Limits::default(), &Monitor::default()) {
            Ok((read, burst)) => assert_eq!(burst.len(), read.frames),
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains("a.burstcase"), "{error}");
            }
        }
    }
    assert!(refused > 150, "{refused}");
    // Declared sizes beyond the limits are refused before anything of that size is made.
    for (size, frames) in [([1 << 40, 1 << 40], 4), ([96, 64], 1 << 40), ([0, 64], 4), ([97, 64], 4), ([96, 64], 5)]
    {
        let lying = Case { size, frames, ..case.clone() };
        let about = Ok((ABOUT.to_owned(), toml::to_string(&lying).expect("plain values").into_bytes()));
        let encoded = |frame| encoded(frame, &case, &Monitor::default());
        let frames = part.frames.iter().enumerate().map(|(t, frame)| Ok((frame_name(t), encoded(frame)?)));
        let zip = zipped(std::iter::once(about).chain(frames)).expect("zipped");
        std::fs::write(&path, zip).expect("written");
        let error = read_case(&path, &Limits::default(), &Monitor::default()).expect_err("a lie");
        assert_eq!(error.kind, ErrorKind::Content, "{error}");
    }
    // Texts beyond their limits are not read to their end, whatever they unpack to.
    let long = Ok((SESSION.to_owned(), vec![b'#'; MAX_SESSION_BYTES as usize + 1]));
    std::fs::write(&path, zipped(std::iter::once(long)).expect("zipped")).expect("written");
    let error = read_session(&path).expect_err("too long").to_string();
    assert!(error.contains("session.toml") && error.contains("larger"), "{error}");
}

