//! Views of a light field as the frames of a burst: their places in the grid of views, by names or in order, and
//! pictures that hold all views of a grid.
//!
//! Rows of views go downwards and columns to the right, as LFToolbox has them, and both directions have one baseline:
//! a thing of disparity d is displaced by d to the right from a view to that of the next column, and by d downwards
//! from a view to that of the next row.

use super::layout::{MAX_SIDE, Tiling, TimesChoice, ViewGrid, ViewsChoice};
use super::options::OpenOptions;
use super::positions::Positions;
use super::reading::RawFrame;
use super::stamps::{Timing, base_name, stem};
use crate::error::{Error, ErrorKind, Result};
use crate::monitor::Monitor;
use crate::plane::Plane;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Positions of the `frames` frames of `files`, which are one file each or all in one: of views, by the choice in
/// `options`, the grid that the file `declares`, or LFToolbox's names; otherwise by times.
///
/// Views named by row and column are brought into the order of their rows.
///
/// # Errors
/// Those of [`Timing::of`]; names without row and column or two that are equal, another number of views, times of views.
pub(super) fn placed(
    files: &mut [PathBuf],
    (frames, declared): (usize, Option<ViewGrid>),
    options: &OpenOptions,
    monitor: &Monitor,
) -> Result<Timing> {
    let grid = |grid: ViewGrid, said: String| {
        let positions = Positions::grid(grid.rows, grid.columns);
        Ok::<_, Error>(Timing { positions, said: (grid.rows > 1).then_some(said) })
    };
    let file = files.first().cloned().unwrap_or_default();
    let refused = |problem: String, remedy: &str| {
        Error::new(ErrorKind::Mismatch, format!("views: {problem}"), remedy).about(&file)
    };
    let has_times = !matches!(options.times, None | Some(TimesChoice::Even));
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
        Some(ViewsChoice::Names) if files.len() != frames => {
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
            None if options.times.is_none() && files.len() == frames => {
                match usual(files).and_then(|places| by_name(files, &places)) {
                    Some(timing) => Ok(timing),
                    None => Timing::of(files, frames, options, monitor),
                }
            }
            None => Timing::of(files, frames, options, monitor),
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
    let is_digit = |c: char| c.is_ascii_digit();
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let mut from = 0;
    while let Some(start) = name[from..].find(is_digit).map(|at| from + at) {
        let end = name[start..].find(|c| !is_digit(c)).map_or(name.len(), |at| start + at);
        runs.push((start, end));
        from = end;
    }
    let pair = |two: &[(usize, usize)]| {
        let [(start, row_end), (column_start, end)] = [two[0], two[1]];
        let is_joined = matches!(&name[row_end..column_start], "_" | "-");
        let number = |range: std::ops::Range<usize>| name[range].parse::<usize>().ok().filter(|n| *n <= MAX_SIDE);
        is_joined.then(|| Some((start, [number(start..row_end)?, number(column_start..end)?], end)))?
    };
    runs.windows(2).filter_map(pair).collect()
}

/// Rows and columns in the `names` of views: of pairs of numbers with the same before them in all names, the first by
/// which all names differ.
///
/// # Errors
/// The first name without one, and what would be right.
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

/// Places of views that are named as LFToolbox does, `view_03_07.png` or `03_07.png`, and fill a grid of several rows
/// and columns.
fn usual(files: &[PathBuf]) -> Option<Vec<[usize; 2]>> {
    let Named { mut places, before, is_followed } = in_names(&names_of(files)).ok()?;
    let before = before.trim_end_matches(['_', '-']).to_lowercase();
    let is_usual = !is_followed && (before.is_empty() || before.ends_with("view"));
    let own = places.clone();
    places.sort_unstable();
    let ([first_row, first_column], [last_row, last_column]) = (*places.first()?, *places.last()?);
    let (rows, columns) = (last_row - first_row + 1, (last_column + 1).checked_sub(first_column)?);
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
    let said = positions.are_views().then_some(said);
    Some(Timing { positions, said })
}

/// Size (columns, rows) of a view of a picture of `size` that holds a grid of them.
///
/// # Errors
/// The sides are no multiples of the numbers of views.
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

/// The views in the picture `frame` of the file `path`, row by row.
///
/// # Errors
/// As [`size_of_view`].
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::burst::reading::FileScale;
    use proptest::prelude::*;

    fn placed_as(names: &[&str], options: &OpenOptions) -> Result<(Timing, Vec<String>), String> {
        let mut files: Vec<PathBuf> = names.iter().map(|name| Path::new("/lf").join(name)).collect();
        let timing =
            placed(&mut files, (names.len(), None), options, &Monitor::default()).map_err(|e| e.to_string())?;
        Ok((timing, names_of(&files)))
    }

    fn by(views: &str) -> OpenOptions {
        OpenOptions { views: Some(views.parse().expect("a choice")), ..OpenOptions::default() }
    }

    #[test]
    fn rows_and_columns_in_usual_names_need_no_option_and_others_do() {
        let plain = OpenOptions::default();
        for names in [
            ["view_03_07.png", "view_03_08.png", "view_04_07.png", "view_04_08.png"],
            ["0_0.png", "0_1.png", "1_0.png", "1_1.png"],
        ] {
            let (timing, _) = placed_as(&names, &plain).expect("placed");
            assert_eq!((timing.positions, timing.said.is_some()), (Positions::grid(2, 2), true), "{names:?}");
        }
        // No full grid, one row, something behind, another word before, an option that says otherwise: frames in time.
        for names in [
            &["0_0.png", "0_1.png", "1_0.png"][..],
            &["view_0_0.png", "view_0_1.png", "view_0_2.png"],
            &["0_0a.png", "0_1a.png", "1_0a.png", "1_1a.png"],
            &["cam_0_0.png", "cam_0_1.png", "cam_1_0.png", "cam_1_1.png"],
        ] {
            let (timing, _) = placed_as(names, &plain).expect("placed");
            assert_eq!(timing, Timing::even(names.len()), "{names:?}");
        }
        let (timing, _) = placed_as(&["0_0.png", "0_1.png", "1_0.png", "1_1.png"], &by("1x4")).expect("placed");
        assert_eq!(timing, Timing::even(4));
        let names = ["out_01_00_-3.5_7.png", "out_00_01_2.5_8.png", "out_00_00_1.5_8.png"];
        let (timing, files) = placed_as(&names, &by("names")).expect("placed");
        assert_eq!(Some(timing.positions), Positions::of_views(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]));
        assert_eq!(files, [names[2], names[1], names[0]]);
    }

    #[test]
    fn what_does_not_fit_is_told_with_a_remedy() {
        let names = ["a.png", "b.png", "c.png"];
        let error = |views: &str| placed_as(&names, &by(views)).expect_err("refused");
        assert!(error("2x2").contains("2x2 are 4 views, but there are 3 frames"), "{}", error("2x2"));
        assert!(error("names").contains("'a.png' has no row and column"), "{}", error("names"));
        let timed = OpenOptions { times: Some(TimesChoice::Names), ..by("3x1") };
        assert!(placed_as(&names, &timed).expect_err("refused").contains("have no times"));
        let path = Path::new("lf.png");
        let grid = ViewGrid::new(3, 4).expect("a grid");
        assert_eq!(size_of_view(path, (40, 30), grid), Ok((10, 10)));
        assert!(size_of_view(path, (41, 30), grid).expect_err("no whole views").to_string().contains("lf.png"));
    }

    #[test]
    fn tiled_and_interleaved_pictures_give_the_same_views() {
        let grid = ViewGrid::new(2, 3).expect("a grid");
        let value = |row: usize, column: usize, u: usize, v: usize| (1000 * row + 100 * column + 10 * v + u) as f32;
        let tiled = Plane::from_fn(3 * 4, 2 * 5, |x, y| value(y / 5, x / 4, x % 4, y % 5));
        let eslf = Plane::from_fn(3 * 4, 2 * 5, |x, y| value(y % 2, x % 3, x / 3, y / 2));
        let scale = FileScale::Data { integer: true, largest: 2000.0 };
        let views = |plane, tiling| {
            views_of(Path::new("a"), &RawFrame::linear(plane, scale), grid, tiling).expect("whole views")
        };
        for views in [views(tiled, Tiling::Tiled), views(eslf, Tiling::Eslf)] {
            for (k, view) in views.iter().enumerate() {
                assert_eq!(view.plane, Plane::from_fn(4, 5, |u, v| value(k / 3, k % 3, u, v)), "view {k}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_name_and_no_text_panics(names in prop::collection::vec("[0-9_v.é٣-]{0,12}", 0..5), text in "\\PC{0,12}") {
            let _ = in_names(&names);
            let _ = text.parse::<ViewsChoice>();
            let files: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            let _ = usual(&files);
        }

        #[test]
        fn names_of_any_grid_are_read(rows in 2usize..6, columns in 2usize..6, from in 0usize..12, width in 1usize..4) {
            let name = |k: usize| format!("view_{:0width$}_{:0width$}.png", from + k / columns, from + k % columns);
            let files: Vec<PathBuf> = (0..rows * columns).map(name).map(PathBuf::from).collect();
            let places = usual(&files).expect("a grid");
            prop_assert!(places.iter().enumerate().all(|(k, at)| *at == [from + k / columns, from + k % columns]));
        }
    }
}
