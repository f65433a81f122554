//! Light fields: folders of views, arrays, and pictures of all views, opened to the same frames and places.

use super::support::*;
use image::GrayImage;
use ndarray::Array5;

const ROWS: usize = 3;
const COLUMNS: usize = 5;
const SIZE: (usize, usize) = (20, 18);

fn value(row: usize, column: usize, u: usize, v: usize) -> u8 {
    (60 * row + 11 * column + 2 * u + v) as u8
}

fn picture((width, height): (usize, usize), at: impl Fn(usize, usize) -> u8) -> GrayImage {
    GrayImage::from_fn(width as u32, height as u32, |x, y| Luma([at(x as usize, y as usize)]))
}

fn options(views: &str) -> OpenOptions {
    OpenOptions { views: (!views.is_empty()).then(|| views.parse().expect("a choice")), ..OpenOptions::default() }
}

fn open(path: &Path, views: &str) -> Result<Burst, Error> {
    Burst::open_with(&[path.to_owned()], &options(views), &quiet())
}

/// A folder of views whose names `name` makes.
fn views(name: impl Fn(usize, usize) -> String) -> Folder {
    let home = folder();
    for (row, column) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        save(&home.join(name(row, column)), &picture(SIZE, |u, v| value(row, column, u, v)));
    }
    home
}

fn is_whole(burst: &Burst) -> bool {
    let is_view = |k: usize| {
        let at = |u: usize, v: usize| f32::from(value(k / COLUMNS, k % COLUMNS, u, v)) / 255.0;
        let frame = &burst.frames[k];
        frame.size() == SIZE && (0..SIZE.1).all(|v| (0..SIZE.0).all(|u| (frame.at(u, v) - at(u, v)).abs() < 1e-6))
    };
    burst.positions == Positions::grid(ROWS, COLUMNS) && (0..ROWS * COLUMNS).all(is_view)
}

#[test]
fn names_arrays_and_pictures_of_all_views_give_the_same_light_field() {
    let usual = views(|row, column| format!("view_{row:02}_{column:02}.png"));
    let burst = open(&usual, "").expect("a light field");
    assert!(is_whole(&burst) && burst.taken[0].contains("3 rows and 5 columns"), "{:?}", burst.taken);
    assert!(is_whole(&open(&usual, "3x5").expect("a light field")));
    let mut files: Vec<PathBuf> = fs::read_dir(&usual).expect("read").map(|e| e.expect("an entry").path()).collect();
    files.sort_by(|a, b| b.cmp(a));
    let backwards = Burst::open_with(&files, &options(""), &quiet()).expect("a light field");
    assert!(is_whole(&backwards) && backwards.frame_names[0] == "view_00_00.png");
    let others = views(|row, column| format!("shot_{row}_{column}_{}.5.png", 9 - column));
    assert!(is_whole(&open(&others, "names").expect("a light field")));
    assert!(!open(&others, "").expect("a burst").positions.are_views());
    let home = folder();
    let path = |name: &str| home.join(name);
    let all = (COLUMNS * SIZE.0, ROWS * SIZE.1);
    save(&path("tiled.png"), &picture(all, |x, y| value(y / SIZE.1, x / SIZE.0, x % SIZE.0, y % SIZE.1)));
    save(&path("eslf.png"), &picture(all, |x, y| value(y % ROWS, x % COLUMNS, x / COLUMNS, y / ROWS)));
    let array = Array4::from_shape_fn((ROWS, COLUMNS, SIZE.1, SIZE.0), |(t, s, v, u)| value(t, s, u, v));
    write_npy(path("array.npy"), &array).expect("written");
    let colours = Array5::from_shape_fn((ROWS, COLUMNS, SIZE.1, SIZE.0, 3), |(t, s, v, u, _)| value(t, s, u, v));
    write_npy(path("colours.npy"), &colours).expect("written");
    for (name, views) in [
        ("tiled.png", "3x5:tiled"),
        ("eslf.png", "3x5:eslf"),
        ("array.npy", ""),
        ("array.npy", "3x5"),
        ("colours.npy", ""),
    ] {
        let burst = open(&path(name), views).expect("a light field");
        assert!(is_whole(&burst), "{name} {views}: {:?}", burst.positions);
        assert!(burst.frame_names[COLUMNS].ends_with("[1, 0]"), "{:?}", burst.frame_names);
        let info = Info::of(&[path(name)], &options(views), &quiet()).expect("described");
        assert_eq!((info.frames, info.width, info.height, info.views), (15, SIZE.0, SIZE.1, Some([ROWS, COLUMNS])));
        assert!(info.text().contains("views   3 rows × 5 columns"), "{}", info.text());
    }
    let frames = (0..ROWS * COLUMNS).map(|k| {
        let pixels = (0..SIZE.0 * SIZE.1).map(move |i| value(k / COLUMNS, k % COLUMNS, i % SIZE.0, i / SIZE.0));
        ArrayFrame::of_u8(SIZE.0, SIZE.1, pixels.collect::<Vec<_>>().into_iter())
    });
    let arrays = Arrays { frames: frames.collect(), ..Arrays::default() };
    let made = Burst::from_arrays("made", arrays, &options("3x5"), &quiet()).expect("made");
    assert!(is_whole(&made));
}

/// Opens small pictures of these names as one burst: its positions, and its names in their order.
fn named(names: &[&str], views: &str) -> Result<(Positions, Vec<String>), Error> {
    let home = folder();
    names.iter().for_each(|name| save(&home.join(name), &picture((4, 3), |u, v| (u + v) as u8)));
    let files: Vec<PathBuf> = names.iter().map(|name| home.join(name)).collect();
    let burst = Burst::open_with(&files, &options(views), &quiet())?;
    Ok((burst.positions, burst.frame_names))
}

#[test]
fn views_are_told_by_usual_names_pictures_of_all_are_bursts_and_no_light_fields_are_refused() {
    for names in [
        ["view_03_07.png", "view_03_08.png", "view_04_07.png", "view_04_08.png"],
        ["0_0.png", "0_1.png", "1_0.png", "1_1.png"],
    ] {
        assert_eq!(named(&names, "").expect("placed").0, Positions::grid(2, 2), "{names:?}");
    }
    // No full grid, one row, something behind, another word before, an option that says otherwise: frames in time.
    for (names, views) in [
        (&["0_0.png", "0_1.png", "1_0.png"][..], ""),
        (&["view_0_0.png", "view_0_1.png", "view_0_2.png"], ""),
        (&["0_0a.png", "0_1a.png", "1_0a.png", "1_1a.png"], ""),
        (&["cam_0_0.png", "cam_0_1.png", "cam_1_0.png", "cam_1_1.png"], ""),
        (&["0_0.png", "0_1.png", "1_0.png", "1_1.png"], "1x4"),
    ] {
        assert_eq!(named(names, views).expect("placed").0, Positions::even(names.len()), "{names:?}");
    }
    let names = ["out_01_00_-3.5_7.png", "out_00_01_2.5_8.png", "out_00_00_1.5_8.png"];
    let (positions, order) = named(&names, "names").expect("placed");
    assert_eq!(Some(positions), Positions::of_views(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]));
    assert_eq!(order, [names[2], names[1], names[0]]);
    says(named(&["a.png", "b.png", "c.png"], "names").expect_err("refused"), &["'a.png' has no row and column"]);
    let home = folder();
    let all = (COLUMNS * SIZE.0, ROWS * SIZE.1);
    for name in ["a.png", "b.png"] {
        save(&home.join(name), &picture(all, |x, y| value(y / SIZE.1, x / SIZE.0, x % SIZE.0, y % SIZE.1)));
    }
    let input = [home.to_owned()];
    let found = find_bursts(&input, &options("3x5:tiled")).expect("bursts");
    assert_eq!(found.iter().map(|burst| &*burst.name).collect::<Vec<_>>(), ["a", "b"]);
    let usual = views(|row, column| format!("{row}_{column}.png"));
    assert_eq!(open(&usual, "1x15").expect("a burst").positions, Positions::even(15));
    assert!(Info::of(&[usual.to_owned()], &options("1x15"), &quiet()).expect("described").views.is_none());
    let usual = views(|row, column| format!("view_{row}_{column}.png"));
    let refused = |path: &Path, options: &OpenOptions| {
        let opened = Burst::open_with(&[path.to_owned()], options, &quiet());
        let described = Info::of(&[path.to_owned()], options, &quiet());
        let error = opened.expect_err("refused").to_string();
        assert_eq!(described.expect_err("refused").to_string(), error);
        error
    };
    let of = |views: &str| refused(&usual, &options(views));
    assert!(of("4x4").contains("4x4 are 16 views, but there are 15 frames"), "{}", of("4x4"));
    let timed = OpenOptions { times: "names".parse().ok(), ..options("3x5") };
    assert!(refused(&usual, &timed).contains("have no times"));
    let (home, file) = folder_with("odd.png");
    save(&file, &picture((41, 30), |x, _| x as u8));
    assert!(refused(&file, &options("3x5:tiled")).contains("41×30"));
    assert!(refused(&file, &options("3x5")).contains("for one picture of all, such as 9x9:tiled"));
    // Axes of few columns may be colours.
    let array = home.join("few.npy");
    write_npy(&array, &Array4::<u8>::zeros((4, 3, 18, 20))).expect("written");
    assert!(refused(&array, &OpenOptions::default()).contains("--views ROWSxCOLUMNS"));
    assert!(open(&array, "4x3").is_ok());
    let paths: Vec<PathBuf> = vec![file.clone(), file];
    let several = Burst::open_with(&paths, &options("3x5"), &quiet()).expect_err("two files");
    assert!(several.to_string().contains("15 views, but there are 2 frames"), "{several}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn names_of_any_grid_are_read(rows in 2usize..5, columns in 2usize..5, from in 0usize..12, width in 1usize..4) {
        let name = |k: usize| format!("view_{:0width$}_{:0width$}.png", from + k / columns, from + k % columns);
        let names: Vec<String> = (0..rows * columns).map(name).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        prop_assert_eq!(named(&names, "").expect("a grid").0, Positions::grid(rows, columns));
    }

    #[test]
    fn no_name_and_no_text_panics(
        names in prop::collection::btree_set("[0-9_v.é٣-]{1,12}", 1..5),
        text in "\\PC{0,12}",
    ) {
        let names: Vec<String> = names.into_iter().map(|name| format!("{name}.png")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let _ = (named(&names, ""), named(&names, "names"), text.parse::<ViewsChoice>());
    }
}
