//! Files of the window: what is asked for, and what chosen, dropped and written files mean to the project.
//!
//! A file that is written is prepared from the shown results, then written in the background, whole or not at all.

use super::dialogs::Question;
use super::session::Session;
use crate::app::document::{Action, ExportKind, Purpose, Side};
use crate::app::measure::{mask_of, profiles_of};
use crate::app::messages::Messages;
use crate::app::panel::lab::curves::shown_plots;
use crate::app::{figure::figure_of, inspector::PaneWidgets};
use crate::app::{panel::methods::methods_table, results::Read};
use crate::burst::{Info, OpenOptions};
use crate::dataset::{DatasetSource, match_rows};
use crate::detector::SearchParams;
use crate::engine::Engine;
use crate::evaluate::curves::curves_figure;
use crate::export::case::{CASE_EXTENSION, Case, Enclosed, write_case};
use crate::export::film::film_files;
use crate::export::{self, ExportFormat, OpenedFiles, OutputRules, Overwrite};
use crate::files::mark::OutputKind;
use crate::files::{MAX_SESSION_BYTES, MAX_SETTINGS_BYTES, explained, read_text, written_by};
use crate::inspect::{place::kept, report::BurstPage, result::DecoyStudy};
use crate::monitor::Monitor;
use crate::requests::{BurstSource, JobError, OpenBurst, Which, write_page};
use crate::teach::{Lesson, Workspace, sheet};
use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const NO_BURST: &str = "no burst is open; open one first";
const NO_MATCHES: &str = "there are no matches; open a second burst and press Match first";

pub(super) fn question(purpose: Purpose, model: Read<'_>) -> Question {
    let kept = feature_folder(model).filter(|folder| purpose == Purpose::ExportDatabase && folder.is_dir());
    let of_burst = || {
        let BurstSource::Paths(paths) = &model.burst_of(Side::A)?.source else { return None };
        paths.first()?.parent().map(PathBuf::from).filter(|folder| folder.is_dir())
    };
    let folder = kept.or_else(of_burst);
    Question { purpose, suggested_name: suggested_name(purpose, model), folder }
}

fn feature_folder(model: Read<'_>) -> Option<PathBuf> {
    model.results.datasets.open.as_ref()?.folder.clone()
}

fn suggested_name(purpose: Purpose, model: Read<'_>) -> String {
    // Features and pictures are those of the burst in focus.
    use ExportKind::{Colmap, Csv, Npz, Png, Report, Tiff};
    let is_of_focus = matches!(purpose, Purpose::Export(Csv | Colmap | Npz | Report | Tiff | Png));
    let side = if is_of_focus { model.active_side() } else { Side::A };
    let burst = model.burst_of(side).map_or("burst", |b| b.burst.name.as_str());
    let stem = Path::new(burst).file_stem().map_or("burst".into(), |s| s.to_string_lossy());
    match purpose {
        Purpose::ExportDatabase => feature_folder(model).map_or_else(String::new, |path| path.display().to_string()),
        Purpose::SaveSession => format!("{stem}.burstscope.toml"),
        Purpose::SaveParams => "params.toml".to_owned(),
        Purpose::Export(kind) => {
            let (content, of_cursor) = (model.document.focused().content, model.document.cursor().kind);
            let what = kind.content().unwrap_or_else(|| content.key(of_cursor));
            let of_figure = (kind == ExportKind::Figure).then(|| model.document.figure.format.extension());
            let extension = of_figure.unwrap_or(kind.extensions()[0]);
            format!("{stem}-{what}.{extension}")
        }
        _ => String::new(),
    }
}

/// Rectangles of the panes in *Two bursts*, with the side for which files dropped there are opened.
pub(super) fn drop_places(model: Read<'_>, widgets: &PaneWidgets) -> Vec<(egui::Rect, Side)> {
    if !model.document.workspace.shows_pair() || model.results.slots.a.burst.is_none() {
        return Vec::new();
    }
    let place = |id| Some((widgets.rect_ui(id)?, model.pane(id)?.side));
    model.document.panes.shown().into_iter().filter_map(place).collect()
}

/// `calibration` is the one that is being set, while its dialog is open.
pub(super) fn purpose_of_dropped(
    paths: &[PathBuf],
    side: Side,
    calibration: Option<&OpenOptions>,
    model: Read<'_>,
) -> Purpose {
    match (paths, calibration) {
        // The bias frame first, then the flat frame and the mask.
        ([_], Some(draft)) if draft.bias.is_none() => Purpose::OpenBias,
        ([_], Some(draft)) if draft.flat.is_none() => Purpose::OpenFlat,
        ([_], Some(_)) => Purpose::OpenMask,
        ([one], _) if one.extension().is_some_and(|e| e == "toml") => {
            let is_session = read_text(one, MAX_SESSION_BYTES).is_ok_and(|text| Session::from_toml(&text).is_ok());
            if is_session { Purpose::RestoreSession } else { Purpose::LoadParams }
        }
        ([_], _) if model.document.workspace == Workspace::Trajectories => {
            // The first file dropped is the estimate, the second the truth; a third replaces the estimate.
            let [estimate, _, truth] = &model.results.poses.compared.read;
            Purpose::OpenTrajectory(if estimate.is_some() && truth.is_none() { Which::Truth } else { Which::Estimate })
        }
        _ => Purpose::OpenFiles(side),
    }
}

/// Change that the chosen files stand for; `None` where they change no document, or cannot be read: a message says so.
pub(super) fn action_of(purpose: Purpose, paths: Vec<PathBuf>, messages: &mut Messages) -> Option<Action> {
    let first = paths.first()?.clone();
    // A name that is typed may be that of a built-in burst, as on the command line.
    let named = first.to_str().filter(|_| !first.exists()).and_then(BurstSource::named);
    let source = || named.unwrap_or(BurstSource::Paths(paths.clone()));
    Some(match purpose {
        Purpose::OpenFolder(side) | Purpose::OpenFiles(side) | Purpose::OpenPath(side) => Action::Open(side, source()),
        Purpose::OpenDataset => Action::OpenDataset(DatasetSource::of_bursts(paths)),
        Purpose::OpenTrajectory(which) => Action::OpenTrajectory(which, first),
        Purpose::FeatureFolder => Action::UseFeatureFolder(first),
        Purpose::OpenGold(side) => Action::OpenGold(side, BurstSource::Paths(paths)),
        Purpose::OpenFeatures(side) => Action::OpenFeatures(side, first),
        Purpose::RestoreSession => {
            let session = read_from(&first, MAX_SESSION_BYTES, Session::from_toml);
            Action::Restore(Box::new(messages.settle(purpose.title(), session)?))
        }
        Purpose::LoadParams => {
            let params = read_from(&first, MAX_SETTINGS_BYTES, SearchParams::from_toml);
            let params = messages.settle(purpose.title(), params)?;
            messages.note(format!("Loaded parameters from {}", first.display()));
            Action::SetSearch(Box::new(params))
        }
        _ => return None,
    })
}

fn read_from<T>(path: &Path, max_bytes: u64, read: fn(&str) -> Result<T, String>) -> Result<T, String> {
    let text = read_text(path, max_bytes).map_err(|error| error.to_string());
    let value = text.and_then(|text| read(&text).map_err(|error| explained(&text, &error)));
    value.map_err(|error| format!("{error}: {}", path.display()))
}

/// Rules for overwriting after the user agreed: any file but those that are open.
pub(super) fn may_replace(path: &Path, model: Read<'_>) -> OutputRules {
    // A file that does not exist is not open either; this avoids listing the files of a large dataset.
    let is_there = std::fs::symlink_metadata(path).is_ok();
    let opened = if is_there { model.opened_files() } else { Vec::new() };
    OutputRules::new(OpenedFiles::of(opened), Overwrite::Force)
}

/// Begins to write a file. The user has agreed to overwriting.
///
/// # Errors
/// Why there is nothing to write, or why it may not be written there.
pub(super) fn write(
    purpose: Purpose,
    path: PathBuf,
    lesson: Option<&Lesson>,
    model: Read<'_>,
    widgets: &PaneWidgets,
    engine: &Engine,
) -> Result<(), String> {
    let rules = may_replace(&path, model);
    let prepared = prepare(purpose, lesson, model, widgets);
    let work = rules.check(&path).map_err(|e| e.to_string()).and(prepared)?;
    engine.task(purpose.title(), move || {
        // The task may have waited, and files changed meanwhile.
        rules.check(&path).map_err(|e| e.to_string())?;
        work(&path)?;
        Ok(format!("Wrote {}", path.display()))
    });
    Ok(())
}

type Work = Box<dyn FnOnce(&Path) -> Result<(), String> + Send>;

fn prepare(purpose: Purpose, lesson: Option<&Lesson>, model: Read<'_>, widgets: &PaneWidgets) -> Result<Work, String> {
    match purpose {
        Purpose::SaveParams => Ok(settings_work(model.asked().to_toml())),
        Purpose::SaveSession => Ok(settings_work(Session::of(model).ok_or(NO_BURST)?.to_toml())),
        Purpose::Export(ExportKind::Csv) => features_work(model, ExportFormat::Csv),
        Purpose::Export(ExportKind::Colmap) => features_work(model, ExportFormat::Colmap),
        Purpose::Export(ExportKind::Npz) => features_work(model, ExportFormat::Npz),
        Purpose::Export(ExportKind::Matches) => matches_work(model),
        Purpose::Export(ExportKind::Methods) => Ok(values_work(methods_table(model))),
        Purpose::Export(ExportKind::Profile) => profile_work(model, widgets),
        Purpose::Export(ExportKind::Sheet) => {
            let text = sheet(lesson.ok_or("no lesson is open; open one first")?);
            Ok(work(move |path| export::write_whole(path, |out| out.write_all(text.as_bytes()))))
        }
        Purpose::Export(ExportKind::CurvesCsv | ExportKind::CurvesSvg) => {
            Ok(values_work(curves_figure(&shown_plots(model))))
        }
        Purpose::Export(ExportKind::Mask) => mask_work(model),
        Purpose::Export(ExportKind::Case) => case_work(model),
        Purpose::Export(ExportKind::Report) => report_work(model),
        Purpose::Export(ExportKind::Film) => {
            let film = model.film_to_export().ok_or("there is no burst; open one first")?;
            let rate = model.document.film.rate;
            Ok(work(move |path| {
                // Nobody was asked whether other pictures with such numbers may be replaced.
                let pictures = film_files(path, film.steps().len()).into_iter().filter(|file| file != path);
                let free = || pictures.clone().try_for_each(|file| OutputRules::default().check(&file));
                film.write(path, rate, &export::rasterise, &free, &Monitor::default())
            }))
        }
        Purpose::Export(ExportKind::Figure) => {
            let figure = figure_of(model, widgets, &model.document.figure)?;
            Ok(work(move |path| export::write_drawing(path, &figure.drawing())))
        }
        Purpose::Export(kind) => picture_work(model, kind),
        _ => Err("nothing is written for this".to_owned()),
    }
}

fn work<E: Display>(write: impl FnOnce(&Path) -> Result<(), E> + Send + 'static) -> Work {
    Box::new(move |path| write(path).map_err(|error| error.to_string()))
}

fn settings_work(toml: String) -> Work {
    let text = written_by() + &toml;
    work(move |path| export::write_text(path, OutputKind::Settings, text))
}

fn case_work(model: Read<'_>) -> Result<Work, String> {
    let open = model.results.slots.a.burst.clone().ok_or(NO_BURST)?;
    let place = model.probed_place().filter(|_| model.document.probe.side == Side::A);
    let answer = model.results.probed.answer.as_ref().filter(|_| place.is_some());
    let note = answer.map_or_else(String::new, |answer| answer.probe.summary.clone());
    let search = model.asked();
    let session = Session::of(model).map(|session| session.for_case().to_toml());
    Ok(work(move |path| -> Result<(), JobError> {
        if path.extension().is_none_or(|ending| ending != CASE_EXTENSION) {
            let why = format!("{}: a case is opened by its ending; name the file .{CASE_EXTENSION}", path.display());
            return Err(JobError::Failed(why));
        }
        let (case, burst) = Case::of(&open.burst, &search, (place, None), &note, &Monitor::default())?;
        let enclosed = Enclosed { session, truth: open.truth(&Monitor::default())? };
        Ok(write_case(path, (&case, &burst), &enclosed, &Monitor::default())?)
    }))
}

fn report_work(model: Read<'_>) -> Result<Work, String> {
    let side = model.active_side();
    let source = model.found_source(side).ok_or("there are no features; press Detect first")?;
    let is_probed = model.document.probe.side == side;
    // The trail of the probe is that of the features on show, unless it lacks one.
    let traced = model.results.probed.traced.clone().filter(|_| is_probed && model.untraced().is_none());
    let pinned = model.places_of(side).map(|(_, place)| place.clone());
    let places = pinned.chain(model.place_to_pin().filter(|_| is_probed)).map(|place| (place.name, place.at));
    let places: Vec<(String, [f32; 2])> = places.collect();
    let calibration = model.calibration_of(side).clone();
    Ok(work(move |path| -> Result<(), JobError> {
        let monitor = Monitor::default();
        let cache = match traced {
            Some(traced) => traced.cache,
            None => Arc::new(source.trail(&monitor)?),
        };
        let OpenBurst { burst, source, .. } = &source.burst;
        let info = Info { name: burst.name.clone(), ..source.info(&calibration, &monitor)? };
        let page = BurstPage::of((&cache, burst, info), &places, &DecoyStudy::default(), &monitor)?;
        Ok(write_page(path, &page, &monitor)?)
    }))
}

fn features_work(model: Read<'_>, format: ExportFormat) -> Result<Work, String> {
    let found = model.found_of(model.active_side()).ok_or("there are no features; press Detect first")?;
    let detection = found.detection.clone();
    // What a verdict hides in the window is not written either; other filters are for looking.
    let Some(verdict) = model.document.filter.verdict else {
        return Ok(work(move |path| format.write(path, &detection, None)));
    };
    let judged = model.results.coherence.of(&detection).cloned();
    let judged = judged.ok_or("the features are still being judged; export them when the table has their verdicts")?;
    Ok(work(move |path| {
        let (detection, verdicts) = kept(&detection, &judged, &[verdict]);
        format.write(path, &detection, Some(&verdicts))
    }))
}

fn matches_work(model: Read<'_>) -> Result<Work, String> {
    let matches = model.results.pair.matches.clone().ok_or(NO_MATCHES)?;
    Ok(work(move |path| {
        let [a, b] = [Side::A, Side::B].map(|side| matches.detection(side));
        export::write_matches_csv(path, &match_rows(&a.features, &b.features, &matches.result))
    }))
}

fn profile_work(model: Read<'_>, widgets: &PaneWidgets) -> Result<Work, String> {
    let line = model.document.measure.line.ok_or("there is no line; draw one with Q first")?;
    let profiles = profiles_of(model, widgets, &line).into_iter();
    let profiles: Vec<_> = profiles.map(|(_, name, samples)| (name, samples)).collect();
    if profiles.is_empty() {
        return Err("the pane with the line is closed; draw another line with Q".to_owned());
    }
    Ok(values_work(export::profiles_table(&profiles)))
}

fn mask_work(model: Read<'_>) -> Result<Work, String> {
    let open = model.results.slots.a.burst.clone().ok_or(NO_BURST)?;
    let outlines = model.document.measure.hidden.clone();
    Ok(work(move |path| {
        let greys = mask_of(&open.burst, &outlines);
        let ((width, height), pixels) = (open.burst.size(), greys.iter().flat_map(|grey| [*grey; 3]));
        export::write_png(path, export::Bitmap::rgb(width, height, &pixels.collect::<Vec<u8>>()))
    }))
}

fn picture_work(model: Read<'_>, kind: ExportKind) -> Result<Work, String> {
    let picture = model.picture().cloned().ok_or("there is no picture; open a burst first")?;
    let (display, features) =
        (model.display_of(model.document.focus()), model.features_of_motion(model.document.focus()).to_vec());
    Ok(match kind {
        ExportKind::Tiff => work(move |path| export::write_tiff(path, &picture.plane)),
        _ => work(move |path| {
            let rgba = picture.rgba(&display, &features);
            let (width, height) = (rgba.width() as usize, rgba.height() as usize);
            export::write_png(path, export::Bitmap::rgba(width, height, rgba.as_raw()))
        }),
    })
}

fn values_work(figure: impl Into<export::Figure>) -> Work {
    let figure = figure.into();
    work(move |path| figure.write(path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::apply::bench::{detected, feature, open};
    use crate::app::apply::{detection, opening};
    use crate::app::results::Model;
    use std::time::Duration;

    fn prepared(purpose: Purpose, model: Read<'_>) -> Result<Work, String> {
        prepare(purpose, None, model, &PaneWidgets::default())
    }

    #[test]
    fn what_is_missing_is_said_with_what_to_do() {
        use ExportKind::*;
        let model = Model::default();
        for kind in [Csv, Colmap, Npz, Png, Tiff, Figure, Matches, Profile, CurvesCsv, CurvesSvg, Report] {
            match prepared(Purpose::Export(kind), Read::of(&model)) {
                // Curves that are not there are a file without lines.
                Ok(_) => assert!(matches!(kind, CurvesCsv | CurvesSvg), "{kind:?}"),
                Err(why) => assert!(why.contains("first") && why.starts_with("there") || why.contains(';'), "{why}"),
            }
        }
        let why = prepared(Purpose::SaveSession, Read::of(&model)).err();
        assert_eq!(why.as_deref(), Some("no burst is open; open one first"));
        let opens = prepared(Purpose::OpenFolder(Side::A), Read::of(&model));
        assert!(opens.is_err(), "nothing is written when something is opened");
    }

    #[test]
    fn what_is_written_is_what_was_there_when_it_was_asked_for() {
        let mut model = Model::default();
        let burst = open((64, 48), 5);
        opening::take_burst(&mut model, burst.clone());
        let params = SearchParams { levels: 3, ..model.document.params.clone() };
        model.document.params = params.clone();
        let grid = Read::of(&model).grid_of(Side::A);
        let features = vec![feature(10.0, 10.0, 4, &grid), feature(30.0, 20.0, 2, &grid)];
        let found = detected(&burst, &params, features);
        detection::take_detection(&mut model, Side::A, found.clone(), Duration::ZERO);
        let home = tempfile::tempdir().expect("a folder");
        let (csv, toml) = (home.path().join("f.csv"), home.path().join("p.toml"));
        let work = [(Purpose::Export(ExportKind::Csv), &csv), (Purpose::SaveParams, &toml)]
            .map(|(purpose, path)| (prepared(purpose, Read::of(&model)).expect("all is there"), path));
        // Later changes do not matter.
        opening::take_burst(&mut model, open((32, 32), 2));
        model.document.params = SearchParams::default();
        for (work, path) in work {
            work(path).expect("written");
        }
        let expected = home.path().join("expected.csv");
        export::write_csv(&expected, &found.detection.features, None).expect("written");
        let read = |path: &Path| std::fs::read_to_string(path).expect("text");
        assert_eq!(read(&csv), read(&expected));
        assert_eq!(SearchParams::from_toml(&read(&toml)).expect("parameters").levels, 3);
        // A folder that is made is fine; a file in place of a folder is not.
        let nowhere = csv.join("p.toml");
        let work = prepared(Purpose::SaveParams, Read::of(&model)).expect("always");
        let why = work(&nowhere).expect_err("that is no folder");
        assert!(why.contains("f.csv"), "{why}");
    }
}
