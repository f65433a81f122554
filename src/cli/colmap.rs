//! `colmap`: writes the input of COLMAP's mapper from a dataset of bursts.

use super::colmap_args::ColmapArgs;
use super::console::Console;
use super::failure::Failure;
use super::inputs::{open_options, resolve_bursts};
use super::report::FailureReport;
use crate::burst::BurstFiles;
use crate::dataset::{
    CameraChoice, ColmapJob, ColmapReport, Comparison, Event, FeatureJob, FeatureStore, GatherReport, LeftOut,
    export_colmap_from, gather,
};
use crate::detector::SearchParams;
use crate::matching::MatchParams;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// JSON document of `colmap`.
#[derive(Serialize)]
struct ColmapDocument<'a> {
    version: &'static str,
    command: &'static str,
    params: &'a SearchParams,
    matching: &'a MatchParams,
    #[serde(flatten)]
    report: &'a ColmapReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    gathered: Option<GatherReport>,
    failures: &'a [FailureReport],
    next: [String; 2],
}

/// Maximum number of bursts that one line names.
const NAMED: usize = 3;

pub(super) fn run(args: &ColmapArgs) -> Result<(), Failure> {
    let detector = args.run.search.params()?;
    let matching = args.matching.params()?;
    let camera = matching.camera.clone().map_or(CameraChoice::Guessed(args.camera_model), CameraChoice::Known);
    let inputs = resolve_bursts(&args.inputs, args.sequence)?;
    if inputs.iter().any(super::inputs::Input::is_built_in) {
        return Err(Failure::usage(
            "colmap: a reconstruction needs bursts from several places, and the demo is one burst",
        ));
    }
    let open = open_options(&inputs, &args.run.calibration)?;
    let job =
        ColmapJob { features: FeatureJob { detector, open, images: args.images }, matching, pairs: args.pairs, camera };
    let console = Console::new(&args.run.output)?;
    let mut failures: Vec<FailureReport> = Vec::new();
    let mut fail = |name: &str, error: String| {
        console.complain(&format!("{name}: {error}"));
        failures.push(FailureReport { name: name.to_owned(), error });
    };
    let mut bursts: Vec<BurstFiles> = Vec::new();
    for input in inputs {
        match input.source {
            Ok(source) => bursts.push(BurstFiles { name: input.name, paths: source.paths().to_vec() }),
            Err(error) => fail(&input.name, error.to_string()),
        }
    }
    let comparison = if args.check_content { Comparison::Content } else { Comparison::Times };
    let mut store = FeatureStore::open(&args.out, &job.features)?.comparing(comparison);
    let mut gathered = None;
    if !args.gather.is_empty() {
        let report = gather(&mut store, &bursts, &args.gather, &console.monitor)?;
        console.say(&format!("gathered the features of {} of {} bursts\n", report.brought.len(), bursts.len()))?;
        tell_what_was_left(&report).iter().for_each(|line| console.note(line));
        gathered = Some(report);
    }
    let mut said = Ok(());
    let mut on = |event: Event<'_>| match event {
        Event::Begin { index, count, name } => console.begin(format!("[{}/{count}] {name}: ", index + 1)),
        Event::Done(burst) => {
            let from = if burst.resumed { ", from an earlier run" } else { "" };
            let slopes = burst.slopes.as_ref().map_or(String::new(), |found| format!("; slopes {}", found.summary()));
            let line = format!("{}: {} features{from}{slopes}\n", burst.name, burst.keypoints.len());
            said = std::mem::replace(&mut said, Ok(())).and_then(|()| console.say(&line));
        }
        Event::Failed { name, error } => fail(name, error.to_string()),
        Event::Matching { pairs } => console.begin(format!("{pairs} pairs: ")),
    };
    let report = export_colmap_from(&mut store, &bursts, &job, &mut on, &console.monitor)?;
    said?;
    let next = next_commands(&args.out);
    console.say(&summary(&report, &next))?;
    console.say_json(&ColmapDocument {
        version: env!("CARGO_PKG_VERSION"),
        command: "colmap",
        params: &job.features.detector,
        matching: &job.matching,
        report: &report,
        gathered,
        failures: &failures,
        next,
    })?;
    if failures.is_empty() { Ok(()) } else { Err(Failure::Reported) }
}

/// Lists what was not gathered and why: one line for each folder and reason.
fn tell_what_was_left(report: &GatherReport) -> Vec<String> {
    let mut lines: Vec<(&Path, String, Vec<&str>)> = Vec::new();
    for LeftOut { folder, burst, reason } in &report.left_out {
        let reason = reason.to_string();
        match lines.iter_mut().find(|(of, why, _)| *of == folder && *why == reason) {
            Some((.., bursts)) => bursts.push(burst),
            None => lines.push((folder, reason, vec![burst])),
        }
    }
    let left = lines.into_iter().map(|(folder, reason, bursts)| {
        let more = bursts.len().saturating_sub(NAMED);
        let more = if more == 0 { String::new() } else { format!(" and {more} more") };
        let names = bursts[..bursts.len().min(NAMED)].join(", ");
        format!("--gather {}: {names}{more} not taken: {reason}", folder.display())
    });
    let strange = report.strange_folders.iter();
    left.chain(strange.map(|folder| format!("--gather {}: it holds none of these bursts", folder.display()))).collect()
}

/// Commands that continue the reconstruction, as typed in a shell.
fn next_commands(out: &Path) -> [String; 2] {
    let at = |name: &str| {
        let path = out.join(name).display().to_string();
        let plain = |c: char| c.is_alphanumeric() || "/\\._-:".contains(c);
        if path.chars().all(plain) { path } else { format!("'{path}'") }
    };
    [
        format!("mkdir -p {}", at("sparse")),
        format!(
            "colmap mapper --database_path {} --image_path {} --output_path {}",
            at("database.db"),
            at("images"),
            at("sparse")
        ),
    ]
}

fn summary(report: &ColmapReport, next: &[String]) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = write_summary(&mut text, report, next);
    text
}

fn write_summary(out: &mut String, report: &ColmapReport, next: &[String]) -> std::fmt::Result {
    for camera in &report.cameras {
        let guessed = if report.known_camera { "" } else { " (guessed: give --camera if you know it)" };
        writeln!(out, "camera {camera}{guessed}")?;
    }
    let putative: usize = report.pairs.iter().map(|p| p.counts.putative).sum();
    let inliers: usize = report.pairs.iter().filter_map(|p| p.counts.inliers).sum();
    let verified = report.pairs.iter().filter(|p| p.counts.inliers.is_some_and(|n| n > 0)).count();
    writeln!(
        out,
        "{} images, {} pairs: {putative} matches, {inliers} inliers in {verified} verified pairs",
        report.images.len(),
        report.pairs.len()
    )?;
    writeln!(out, "wrote {}\n\nNext:", report.database.display())?;
    next.iter().try_for_each(|command| writeln!(out, "  {command}"))
}
