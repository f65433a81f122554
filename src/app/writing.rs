//! What is written to files from the window: prepared from what is on show, then written in the background, whole or not at all.

use super::canvas::View;
use super::canvas::overlay::{ColourBy, ColourScale};
use super::dialogs::{ExportKind, Purpose};
use super::panels::picture::describe;
use super::session::Session;
use super::state::look::RangeClass;
use super::state::pair::{MatchRow, Side};
use super::state::{Found, Model};
use crate::detector::{Feature, Slope};
use crate::engine::Picture;
use crate::export::{self, ExportFormat, FigureOptions, LegendEntry};
use crate::plane::Plane;
use crate::plane::display::to_rgba8;
use std::io::Write;
use std::path::Path;

const NO_MATCHES: &str = "there are no matches; open a second burst and press Match first";

/// Writes a file; the error says what went wrong.
pub type Work = Box<dyn FnOnce(&Path) -> Result<(), String> + Send>;

/// The work of writing what `purpose` names, with everything it needs taken from the model as it is now.
///
/// # Errors
/// What is missing: a detection, a picture, a burst.
pub fn prepare(purpose: Purpose, model: &Model, view: View, view_b: View) -> Result<Work, String> {
    match purpose {
        Purpose::SaveParams => Ok(text_work(model.asked().to_toml())),
        Purpose::SaveSession => {
            let session = Session::of(model, view, view_b).ok_or("no burst is open; open one first")?;
            Ok(text_work(session.to_toml()))
        }
        Purpose::Export(ExportKind::Csv) => features_work(model, ExportFormat::Csv),
        Purpose::Export(ExportKind::Colmap) => features_work(model, ExportFormat::Colmap),
        Purpose::Export(ExportKind::Npz) => features_work(model, ExportFormat::Npz),
        Purpose::Export(ExportKind::Matches) => matches_work(model),
        Purpose::Export(ExportKind::MatchPicture) => match_picture_work(model),
        Purpose::Export(kind) => picture_work(model, kind),
        _ => Err("nothing is written for this".to_owned()),
    }
}

fn text_work(text: String) -> Work {
    Box::new(move |path| export::write_whole(path, |out| out.write_all(text.as_bytes())).map_err(|e| e.to_string()))
}

fn features_work(model: &Model, format: ExportFormat) -> Result<Work, String> {
    let detection = model.found.as_ref().ok_or("there are no features; press Detect first")?.detection.clone();
    Ok(Box::new(move |path| format.write(path, &detection).map_err(|e| e.to_string())))
}

fn matches_work(model: &Model) -> Result<Work, String> {
    let matches = model.pair.matches.clone().ok_or(NO_MATCHES)?;
    Ok(Box::new(move |path| {
        let rows: Vec<export::MatchRow> = matches.rows().map(|row| export_row(&row)).collect();
        export::write_matches_csv(path, &rows).map_err(|e| e.to_string())
    }))
}

fn export_row(row: &MatchRow<'_>) -> export::MatchRow {
    export::MatchRow {
        features: [row.found.a, row.found.b],
        a: [f64::from(row.a.u), f64::from(row.a.v)],
        b: [f64::from(row.b.u), f64::from(row.b.v)],
        distance: row.found.distance,
        ratio: row.found.ratio,
        // Where no geometry was found the error is infinite, as the command writes it.
        verified: row.inlier.map(|inlier| (row.error_px.unwrap_or(f32::INFINITY), inlier)),
    }
}

fn match_picture_work(model: &Model) -> Result<Work, String> {
    let matches = model.pair.matches.clone().ok_or(NO_MATCHES)?;
    let listed = model.pair.listed.clone();
    let side = |side: Side| {
        let picture = model.picture_of(side).cloned().ok_or("there is no picture; open a burst first")?;
        let display = model.look_of(side).display(RangeClass::of(picture.request.kind));
        Ok::<_, String>((picture, display))
    };
    let sides = [side(Side::A)?, side(Side::B)?];
    Ok(Box::new(move |path| {
        let lines: Vec<export::MatchLine> = listed
            .iter()
            .filter_map(|&index| matches.row(index))
            .map(|row| {
                let (inlier, row) = (row.inlier != Some(false), export_row(&row));
                export::MatchLine { a: row.a, b: row.b, inlier }
            })
            .collect();
        let drawn = sides.each_ref().map(|(picture, display)| to_rgba8(&on_image_pixels(picture), display));
        let [a, b] = drawn.each_ref().map(|rgba| {
            let (width, height) = rgba.dimensions();
            export::Picture::rgba(width as usize, height as usize, rgba.as_raw())
        });
        export::write_match_picture(path, a, b, &lines).map_err(|e| e.to_string())
    }))
}

fn picture_work(model: &Model, kind: ExportKind) -> Result<Work, String> {
    let picture = model.picture.clone().ok_or("there is no picture; open a burst first")?;
    let display = model.look.display(RangeClass::of(picture.request.kind));
    Ok(match kind {
        ExportKind::Tiff => Box::new(move |path| export::write_tiff(path, &picture.plane).map_err(|e| e.to_string())),
        ExportKind::Png => Box::new(move |path| {
            let rgba = to_rgba8(&picture.plane, &display);
            let (width, height) = picture.plane.size();
            export::write_png(path, export::Picture::rgba(width, height, rgba.as_raw())).map_err(|e| e.to_string())
        }),
        _ => {
            let figure = Figure::of(model, &picture);
            Box::new(move |path| {
                let plane = on_image_pixels(&picture);
                let rgba = to_rgba8(&plane, &display);
                let (width, height) = plane.size();
                let under = export::Picture::rgba(width, height, rgba.as_raw());
                let colour = |f: &Feature| rgb(figure.scale.colour(f));
                export::write_svg(path, under, &figure.features, colour, &figure.options).map_err(|e| e.to_string())
            })
        }
    })
}

/// What lies over the picture in a figure.
struct Figure {
    features: Vec<Feature>,
    scale: ColourScale,
    options: FigureOptions,
}

impl Figure {
    fn of(model: &Model, picture: &Picture) -> Self {
        let scale = ColourScale::of(model.colour_by, model.features());
        let shown = model.look.overlay;
        let listed: Vec<Feature> = model.listed.iter().filter_map(|&i| model.features().get(i).copied()).collect();
        let used = model.found.as_ref().map_or(0, |f| f.detection.frames_used.len());
        let motion_frames = if model.look.motion_vectors { used.saturating_sub(1) as f32 / 2.0 } else { 0.0 };
        let legend = match &model.found {
            Some(found) if shown && model.look.legend => legend(&scale, found),
            _ => Vec::new(),
        };
        let options = FigureOptions {
            orientation: model.look.orientations,
            motion_frames,
            title: Some(describe(picture)),
            legend,
            ..FigureOptions::default()
        };
        Self { features: if shown { listed } else { Vec::new() }, scale, options }
    }
}

/// Entries that show the colours of the slopes of the grid that have features (at most a dozen), or of five steps through the range.
fn legend(scale: &ColourScale, found: &Found) -> Vec<LegendEntry> {
    const MOST: usize = 12;
    let Some(sample) = found.detection.features.first().copied() else { return Vec::new() };
    let entry = |feature: Feature, label: String| LegendEntry { color: rgb(scale.colour(&feature)), label };
    if scale.by == ColourBy::SlopeDirection {
        let grid = found.detection.slopes;
        let mut used: Vec<usize> = found.detection.features.iter().map(|f| f.slope_index).collect();
        used.sort_unstable();
        used.dedup();
        let every = used.len().div_ceil(MOST).max(1);
        return used
            .into_iter()
            .step_by(every)
            .map(|i| {
                let slope = grid.slope(i);
                entry(Feature { slope, ..sample }, format!("({:.2}, {:.2}) px/frame", slope.u, slope.v))
            })
            .collect();
    }
    (0..5)
        .map(|step| {
            let x = scale.min + (scale.max - scale.min) * step as f32 / 4.0;
            let feature = match scale.by {
                ColourBy::SlopeU => Feature { slope: Slope::new(x, 0.0), ..sample },
                ColourBy::SlopeV => Feature { slope: Slope::new(0.0, x), ..sample },
                ColourBy::Scale => Feature { sigma: x, ..sample },
                ColourBy::Response | ColourBy::SlopeDirection => Feature { response: x, ..sample },
            };
            entry(feature, format!("{} {}", super::canvas::number(x, 3), scale.by.unit()))
        })
        .collect()
}

/// The picture on the pixels of the input image, so that features lie where they belong.
fn on_image_pixels(picture: &Picture) -> Plane {
    let step = picture.request.kind.input_px_per_pixel();
    let (width, height) = picture.request.burst.burst.size();
    if picture.plane.size() == (width, height) && step == 1.0 {
        return (*picture.plane).clone();
    }
    let last = |n: usize| n.saturating_sub(1);
    let (last_u, last_v) = (last(picture.plane.width()), last(picture.plane.height()));
    Plane::from_fn(width, height, |u, v| {
        let nearest = |x: usize, most: usize| ((x as f32 / step).round() as usize).min(most);
        picture.plane.at(nearest(u, last_u), nearest(v, last_v))
    })
}

fn rgb(colour: egui::Color32) -> [u8; 3] {
    [colour.r(), colour.g(), colour.b()]
}
