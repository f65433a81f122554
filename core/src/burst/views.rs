//! Views of a light field as frames: their places in the grid by names or in order, and pictures of all views.
//!
//! Rows of views go downwards and columns to the right, as in LFToolbox, with one baseline: a disparity d is a
//! displacement by d to the right from a column to the next, and by d downwards from a row to the next.

use super::layout::{MAX_SIDE, Tiling, TimesChoice, ViewGrid, ViewsChoice};
use super::times::{base_name, digit_runs, stem};
use super::{options::OpenOptions, positions::Positions, reading::RawFrame, stamps::Timing};
use crate::error::{Error, ErrorKind, Result};
use crate::{monitor::Monitor, plane::Plane};
use std::path::{Path, PathBuf};
use std::{collections::BTreeSet, ops::Range};

/// Positions of the frames of `files`, one each, of which those to be taken stay; or of those taken `in_one` file, with
/// the grid that it declares. Views by the choice in `options`, that grid, or LFToolbox's names, in the order of rows;
/// else by times. An error where names or numbers of views do not fit, or views have times; else as [`Timing::of`].
pub(super) fn placed(
    files: &mut Vec<PathBuf>,
    in_one: Option<(usize, Option<ViewGrid>)>,
    options: &OpenOptions,
    monitor: &Monitor,
) -> Result<Timing> {
    let grid = |grid: ViewGrid, said: String| {
        let positions = Positions::grid(grid.rows, grid.columns);
        Ok::<_, Error>(Timing { said: (grid.rows > 1).then_some(said), ..Timing::at(positions) })
    };
    let has_times = !matches!(options.times, None | Some(TimesChoice::Even));
    let file = files.first().cloned().unwrap_or_default();
    let mut options = options;
    let whole = OpenOptions { take: None, ..options.clone() };
    // Without times the order of names is final, so the part is cut out first.
    if in_one.is_none() && !has_times && options.take.is_some() {
        *files = options.taken(file.parent().unwrap_or(Path::new("")), std::mem::take(files), (1, 1))?;
        options = &whole;
    }
    let (frames, declared) = in_one.unwrap_or((files.len(), None));
    let is_apart = in_one.is_none();
    let refused = |problem: String, remedy: &str| {
        Error::new(ErrorKind::Mismatch, format!("views: {problem}"), remedy).about(&file)
    };
    if has_times && (options.views.is_some() || declared.is_some()) {
        return Err(refused("the views of a light field have no times".to_owned(), "leave out either views or times"));
    }
    match options.views {
        Some(ViewsChoice::Grid(views) | ViewsChoice::Picture(views, _)) if views.count() != frames => {
            let problem = format!("{views} are {} views, but there are {frames} frames", views.count());
            let remedy = "give rows and columns of all views; for one picture of all, such as 9x9:tiled or 9x9:eslf";
            Err(refused(problem, remedy))
        }
        Some(ViewsChoice::Grid(views) | ViewsChoice::Picture(views, _)) => grid(
            views,
            format!("the frames are views of a light field, {} × {} (rows × columns)", views.rows, views.columns),
        ),
        Some(ViewsChoice::Names) if !is_apart => {
            Err(refused("this one file holds all views, so names say no places".to_owned(), "give ROWSxCOLUMNS"))
        }
        Some(ViewsChoice::Names) => {
            let named = in_names(&names_of(files)).map_err(|problem| refused(problem, "give ROWSxCOLUMNS"))?;
            let twice = || refused("two names have the same row and column".to_owned(), "rename one of them");
            by_name(files, &named.places).ok_or_else(twice)
        }
        None => match declared {
            Some(views) => {
                let said = "the axes of the array are taken for those of a light field, [rows, columns] of views";
                grid(views, said.to_owned())
            }
            None => {
                // Names as LFToolbox writes them need no option; other files are frames in time.
                let places = if options.times.is_none() && is_apart { usual(files) } else { None };
                match places.and_then(|places| by_name(files, &places)) {
                    Some(timing) => Ok(timing),
                    None => Timing::of(files, in_one.map(|_| frames), options, monitor),
                }
            }
        },
    }
}

fn names_of(files: &[PathBuf]) -> Vec<String> {
    files.iter().map(|file| base_name(&file.to_string_lossy()).to_owned()).collect()
}

/// Rows and columns that names have, and what stands before them in all.
#[derive(Debug, PartialEq)]
struct Named {
    places: Vec<[usize; 2]>,
    before: String,
    /// Whether something stands behind in any name.
    is_followed: bool,
}

/// Pairs of numbers joined by `_` or `-` in a name: where each begins, row, column, and where it ends.
fn pairs(name: &str) -> Vec<(usize, [usize; 2], usize)> {
    let number = |range: &Range<usize>| name[range.clone()].parse::<usize>().ok().filter(|n| *n <= MAX_SIDE);
    let pair = |two: &[Range<usize>]| {
        let [row, column] = [&two[0], &two[1]];
        let is_joined = matches!(&name[row.end..column.start], "_" | "-");
        is_joined.then(|| Some((row.start, [number(row)?, number(column)?], column.end)))?
    };
    digit_runs(name).windows(2).filter_map(pair).collect()
}

/// Rows and columns in the `names` of views: the first pair that differs in all names, with equal text before.
fn in_names(names: &[String]) -> Result<Named, String> {
    let all: Vec<Vec<(usize, [usize; 2], usize)>> = names.iter().map(|name| pairs(stem(name))).collect();
    let count = all.iter().map(Vec::len).min().unwrap_or(0);
    let named = |at: usize| {
        let before = |index: usize| &names[index][..all[index][at].0];
        let places: Vec<[usize; 2]> = all.iter().map(|pairs| pairs[at].1).collect();
        let differ = places.iter().collect::<BTreeSet<_>>().len() == places.len();
        let is_followed = names.iter().zip(&all).any(|(name, pairs)| stem(name).len() > pairs[at].2);
        let is_alike = (0..names.len()).all(|index| before(index) == before(0));
        (differ && is_alike).then(|| Named { places, before: before(0).to_owned(), is_followed })
    };
    (0..count).find_map(named).ok_or_else(|| {
        let odd = all.iter().position(|pairs| pairs.len() == count).unwrap_or(0);
        let name = names.get(odd).map_or("", |name| name);
        format!("the name '{name}' has no row and column of its own; names such as view_03_07.png have them")
    })
}

/// Places of views named as LFToolbox does, `view_03_07.png` or `03_07.png`, that fill a grid of rows and columns.
fn usual(files: &[PathBuf]) -> Option<Vec<[usize; 2]>> {
    let Named { mut places, before, is_followed } = in_names(&names_of(files)).ok()?;
    let before = before.trim_end_matches(['_', '-']).to_lowercase();
    let is_usual = !is_followed && (before.is_empty() || before.ends_with("view"));
    let own = places.clone();
    places.sort_unstable();
    let ([first_row, first_column], [last_row, last_column]) = (*places.first()?, *places.last()?);
    let (rows, columns) = (last_row - first_row + 1, (last_column + 1).checked_sub(first_column)?);
    // Sorted, the places of a full grid count through rows and columns.
    let is_full = places.iter().enumerate().all(|(k, [row, column])| {
        k / columns.max(1) + first_row == *row && k % columns.max(1) + first_column == *column
    });
    (is_usual && rows > 1 && columns > 1 && places.len() == rows * columns && is_full).then_some(own)
}

/// Positions of views at `places` (row, column), and the files in the order of their rows; `None` where two are equal.
fn by_name(files: &mut [PathBuf], places: &[[usize; 2]]) -> Option<Timing> {
    let mut order: Vec<usize> = (0..files.len()).collect();
    order.sort_by_key(|index| places[*index]);
    let sorted: Vec<PathBuf> = order.iter().map(|index| files[*index].clone()).collect();
    let at: Vec<[f64; 2]> =
        order.iter().map(|index| places[*index]).map(|[row, column]| [column as f64, row as f64]).collect();
    let positions = Positions::of_views(&at)?;
    files.clone_from_slice(&sorted);
    let (unevenness, count) = (positions.unevenness(), files.len());
    let said = format!("the names have rows and columns: {unevenness}; --views 1x{count} takes them as frames in time");
    Some(Timing { said: positions.are_views().then_some(said), ..Timing::at(positions) })
}

/// Size (columns, rows) of a view in a picture of `size` that holds a grid; an error unless the sides are multiples.
pub(super) fn size_of_view(path: &Path, (width, height): (usize, usize), grid: ViewGrid) -> Result<(usize, usize)> {
    if width % grid.columns == 0 && height % grid.rows == 0 && width > 0 && height > 0 {
        return Ok((width / grid.columns, height / grid.rows));
    }
    let problem = format!(
        "views: this picture is {width}×{height}, which is no whole number of pixels for each of {} columns and {} rows of views",
        grid.columns, grid.rows
    );
    Err(Error::new(ErrorKind::Mismatch, problem, "give the numbers of views, or crop the picture to whole views")
        .about(path))
}

pub(super) fn views_of(path: &Path, frame: &RawFrame, grid: ViewGrid, tiling: Tiling) -> Result<Vec<RawFrame>> {
    let (width, height) = size_of_view(path, frame.plane.size(), grid)?;
    let view = |k: usize| {
        let (row, column) = (k / grid.columns, k % grid.columns);
        let at = |u: usize, v: usize| match tiling {
            Tiling::Tiled => frame.plane.at(column * width + u, row * height + v),
            Tiling::Eslf => frame.plane.at(u * grid.columns + column, v * grid.rows + row),
        };
        frame.like(Plane::from_fn(width, height, at))
    };
    Ok((0..grid.count()).map(view).collect())
}
