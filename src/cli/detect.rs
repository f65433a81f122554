//! `detect`: features of one or many bursts.

use super::args::DetectArgs;
use super::report::{BurstReport, FailureReport, summary};
use super::{BurstsArgs, Console, Failure, Input, Outcome, document, open_options, resolve_bursts};
use crate::burst::{Burst, OpenOptions};
use crate::dataset::CameraChoice;
use crate::detect::{Searched, search};
use crate::detector::{Detection, Method, SearchParams, find_slopes};
use crate::export::{ExportFormat, OutputRules, detection_files, write_detection};
use crate::files::lock::FolderLock;
use crate::files::path_text;
use crate::inspect::ProbeCache;
use crate::inspect::place::{Verdict, judged, kept};
use crate::inspect::result::too_few;
use crate::inspect::slopes::{is_doubtful, judgement};
use crate::inspect::words::counted;
use crate::monitor::Stage;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Settings for all bursts of a run: how features are found, and which files are written.
pub(super) struct DetectJob<'a> {
    out: &'a Path,
    formats: Vec<ExportFormat>,
    params: &'a SearchParams,
    /// Camera that took the bursts, where known. Bursts of another size are refused.
    pub camera: CameraChoice,
    pub rules: OutputRules,
    /// Verdicts of features that are kept; empty where features are not judged.
    verdicts: Vec<Verdict>,
}

impl<'a> DetectJob<'a> {
    pub fn new(out: &'a Path, formats: &[ExportFormat], params: &'a SearchParams) -> Outcome<Self> {
        if out.exists() && !out.is_dir() {
            let problem = "--out: this is not a folder; name a folder for the features";
            return Err(Failure::usage(format!("{problem}: {}", out.display())));
        }
        let mut formats = formats.to_vec();
        formats.sort_unstable();
        formats.dedup();
        let (camera, rules) = (CameraChoice::default(), OutputRules::default());
        Ok(Self { out, formats, params, camera, rules, verdicts: Vec::new() })
    }

    /// After checking that the features of `inputs` and the files `others` may be written there.
    pub fn take_folder(&self, inputs: &[Input], others: &[PathBuf]) -> Outcome<FolderLock> {
        for file in inputs.iter().flat_map(|input| self.files(&input.name)).chain(others.iter().cloned()) {
            self.rules.check(&file)?;
        }
        Ok(FolderLock::take(self.out)?)
    }

    fn files(&self, name: &str) -> Vec<PathBuf> {
        detection_files(self.out, name, &self.formats)
    }
}

pub(super) fn run(args: &DetectArgs) -> Outcome {
    let params = args.bursts.run.search.params()?;
    let mut job = DetectJob::new(&args.out, &args.format, &params)?;
    let BurstsArgs { inputs, run, overwrite } = &args.bursts;
    let console = Console::new(&run.output)?;
    let inputs = resolve_bursts(inputs, args.sequence, &run.calibration)?;
    let options = open_options(&inputs, &run.calibration)?;
    job.verdicts = match args.verdict.contains(&None) {
        true => Verdict::ALL.to_vec(),
        false => args.verdict.iter().copied().flatten().collect(),
    };
    job.rules = overwrite.rules(&inputs, &options, &[run.search.file.params.as_ref()]);
    // All files are checked, and the folder is locked, before the first search.
    let folder = job.take_folder(&inputs, &[])?;
    let count = inputs.len();
    let (mut bursts, mut failures): (Vec<BurstReport>, Vec<FailureReport>) = Default::default();
    for (index, input) in inputs.into_iter().enumerate() {
        let name = input.name.clone();
        console.begin(if count > 1 { format!("[{}/{count}] {name}: ", index + 1) } else { format!("{name}: ") });
        match detect_burst(input, &options, &job, &folder, &console) {
            Ok((burst, ..)) => bursts.push(burst),
            // If the folder was removed during the run, the remaining bursts are not searched.
            Err(_) if folder.check().is_err() => break,
            Err(Failure::Interrupted) => return Err(Failure::Interrupted),
            Err(Failure::Failed(error) | Failure::Usage(error)) => {
                console.complain(&format!("{name}: {error:#}"));
                failures.push(FailureReport { name, error: format!("{error:#}") });
            }
            Err(Failure::Reported) => failures.push(FailureReport { name, error: String::new() }),
        }
    }
    folder.check()?;
    if count > 1 {
        let features = counted(bursts.iter().map(|burst| burst.features).sum(), "feature");
        let done = bursts.len();
        console.say(&format!("{done} of {count} bursts done, {features} in {}\n", args.out.display()))?;
    }
    console.say_document("detect", &document! { params: &params, bursts, failures: &failures })?;
    if failures.is_empty() { Ok(()) } else { Err(Failure::Reported) }
}

pub(super) fn detect_burst(
    input: Input,
    options: &OpenOptions,
    job: &DetectJob<'_>,
    folder: &FolderLock,
    console: &Console,
) -> Outcome<(BurstReport, Burst, Detection)> {
    let (name, inputs) = (input.name.clone(), input.path_texts());
    let start = Instant::now();
    let burst = input.open_to_search(options, job.params, &console.monitor)?;
    job.camera.for_images(burst.size())?;
    let open_secs = start.elapsed().as_secs_f32();
    let (mut searched, judged_by) = match &job.verdicts[..] {
        [] => (search(&burst, job.params, &console.monitor)?, None),
        // A search that leaves what verdicts are found from.
        _ => {
            let cache = ProbeCache::new(&burst, job.params, &console.monitor.part(0.0, 0.7))?;
            (cache.searched(), Some(cache.trail))
        }
    };
    // Comparing given slopes with those that the frames show takes as long as the noise and the field: only where it is
    // asked for, or the search makes them doubtful.
    let judging = Instant::now();
    let Searched { detection, params, finding, .. } = &searched;
    let is_asked = || console.output.json || is_doubtful(detection, params, &burst);
    let shown = match finding {
        None if params.method == Method::Buff && is_asked() => {
            Some(find_slopes(&burst, params, None, &console.monitor)?)
        }
        found => found.clone(),
    };
    let slopes_judged = judgement(detection, params, shown.as_ref(), &burst, &console.monitor)?;
    searched.slopes_secs += judging.elapsed().as_secs_f32();
    let mut verdicts = None;
    if let Some(trail) = judged_by {
        let judged = judged(&trail, &console.monitor.part(0.7, 0.3))?;
        let (detection, of_kept) = kept(trail.detection(), &judged, &job.verdicts);
        (searched.detection, verdicts) = (detection, Some(of_kept));
    }
    // Past this point the features are written; Ctrl-C then stops before the next burst.
    console.monitor.check()?;
    console.monitor.report(Stage::Write, 0.0);
    let start = Instant::now();
    // Checked again: the search took long, and the folder may have changed.
    folder.check()?;
    job.files(&name).iter().try_for_each(|file| job.rules.check(file))?;
    let files = write_detection(job.out, &name, &searched.detection, verdicts.as_deref(), &job.formats)?;
    let write_secs = start.elapsed().as_secs_f32();
    let files = job.formats.iter().map(ToString::to_string).zip(files.iter().map(|file| path_text(file))).collect();
    // The features are written: without advice, if that is interrupted.
    let tries = console.output.json || !console.output.quiet;
    let few = if tries { too_few(&burst, &searched, &console.monitor).unwrap_or_default() } else { None };
    let mut report = BurstReport::of(&burst, &searched, few);
    (report.name, report.inputs, report.files, report.slopes_judged) = (name, inputs, files, slopes_judged);
    (report.times.open_secs, report.times.write_secs) = (open_secs, write_secs);
    console.say(&summary(&report, &job.params.at_given()))?;
    Ok((report, burst, searched.detection))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::{Mosaic, RawColour};
    use crate::cli::commands::{Cli, Command};
    use crate::detector::{Distinct, NoiseGate, Rules, Slope, SlopeGrid, Slopes};
    use crate::requests::detect_line;
    use clap::Parser;

    #[test]
    fn the_command_understands_what_the_window_says() {
        let plain = SearchParams::default();
        let line = detect_line(&["demo".to_owned()], &plain, &OpenOptions::default());
        assert_eq!(line, "burstscope detect demo --out features");
        let (_, everything) = crate::cli::search_options::tests::everything();
        let along = SearchParams { slopes: Slopes::Auto { direction_deg: Some(-12.5) }, ..plain.clone() };
        let given = SearchParams { slopes: SlopeGrid::default().into(), ..plain.clone() };
        let strict = SearchParams { noise_gate: NoiseGate::Strict, ..given.clone() };
        let apart = SearchParams { distinct: Distinct::Radius(1.4), ..given.clone() };
        let still = SearchParams { slopes: SlopeGrid::single(Slope::default()).into(), ..given.clone() };
        let paper = SearchParams { levels: 5, ..given.under(Rules::BUFF) };
        let calibration = OpenOptions {
            bias: Some("dark frames/b.tiff".into()),
            full_scale: Some(4095.0),
            black_level: Some(-2.5),
            linearise: true,
            mask: Some("masks/night 1".into()),
            mask_saturated: true,
            raw_colour: RawColour::Green,
            mosaic: Some(Mosaic::Grbg),
            raw: "1600x1200:mono12p+16".parse().ok(),
            axis: "T,C=1".parse().ok(),
            array: Some("left eye".to_owned()),
            topic: Some("/left/image_raw".to_owned()),
            times: "logs/rgb.txt".parse().ok(),
            views: "9x9:eslf".parse().ok(),
            ..OpenOptions::default()
        };
        for params in [plain, everything, along, strict, apart, still, paper] {
            let line = detect_line(&["demo".to_owned()], &params, &calibration);
            let words = shlex::split(&line).expect("closed quotes");
            let cli = Cli::try_parse_from(words).unwrap_or_else(|e| panic!("{line}: {e}"));
            let Some(Command::Detect(args)) = cli.command else { panic!("{line} is another command") };
            let BurstsArgs { inputs, run, .. } = args.bursts;
            let read = run.search.params().unwrap_or_else(|e| panic!("{line}: {e:?}"));
            assert_eq!((inputs, read, &run.calibration), (vec![PathBuf::from("demo")], params, &calibration));
        }
    }
}
