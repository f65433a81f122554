//! Tests of the public functions of `export`.

use crate::prelude::*;
use burstscope_core::detector::Motion;
use burstscope_core::export::case::{Case, Enclosed, write_case};
use burstscope_core::export::film::*;
use burstscope_core::export::sheet::*;
use burstscope_core::export::*;
use burstscope_core::files::mark::{Checksum, OutputKind};
use burstscope_core::plane::sample::ProfileSample;
use image::{Rgba, RgbaImage};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{io, io::Write, process::Command};

#[test]
fn a_failing_or_panicking_write_leaves_the_old_file_and_nothing_else() {
    let (folder, path) = folder_with("a.txt");
    write_whole(&path, |w| w.write_all(b"old")).expect("written");
    let full = || Err(io::Error::other("disk full"));
    let error = write_whole(&path, |w| w.write_all(&[b'x'; 1 << 18]).and_then(|()| full()));
    assert_eq!(error, Err(Error::unwritten(&path, &io::Error::other("disk full"))));
    assert_eq!(fs::read(&path).expect("read"), b"old");
    assert_eq!(names(&folder), ["a.txt"]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).expect("set");
        write_whole(&path, |w| w.write_all(b"new")).expect("written");
        let mode = fs::metadata(&path).expect("a file").permissions().mode();
        assert_eq!((mode & 0o777, fs::read(&path).expect("read")), (0o640, b"new".to_vec()), "kept");
    }
    let path = folder.join("new.txt");
    let panicked = std::panic::catch_unwind(|| write_whole(&path, |_| panic!("on purpose")));
    assert!(panicked.is_err());
    assert_eq!(names(&folder), ["a.txt"]);
}

fn encoded(pictures: Vec<RgbaImage>, monitor: &Monitor) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode_film(&mut bytes, (pictures.len(), pictures.into_iter().map(Ok)), 10, monitor).map(|()| bytes)
}

fn pictures() -> Vec<RgbaImage> {
    (0..3u8).map(|t| RgbaImage::from_fn(20, 10, |x, _| Rgba([80 * t, (12 * x) as u8, 9, 255]))).collect()
}

#[test]
fn films_come_back_picture_by_picture_and_last_a_second_at_any_rate() {
    let bytes = encoded(pictures(), &quiet()).expect("encoded");
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&bytes[..]).expect("a GIF");
    for truth in pictures() {
        let frame = decoder.read_next_frame().expect("read").expect("a picture");
        assert_eq!(frame.delay, 10);
        let off = frame.buffer.iter().zip(truth.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off.is_some_and(|off| off <= 4), "{off:?}");
    }
    assert!(decoder.read_next_frame().expect("read").is_none());
    let estimate = |file: &str| estimated_film_bytes(Path::new(file), [&pictures()[0], &pictures()[1]], 3);
    assert!(estimate("a.gif").is_some_and(|about| (0.4..3.0).contains(&(about as f64 / bytes.len() as f64))));
    assert_eq!(estimate("a.mp4"), None);
    for rate in [1, 7, 30, 49, 50] {
        let picture = || Ok(RgbaImage::from_pixel(2, 2, Rgba([1, 2, 3, 255])));
        let (mut bytes, count) = (Vec::new(), usize::from(rate));
        let pictures = (count, (0..count).map(|_| picture()));
        encode_film(&mut bytes, pictures, rate, &quiet()).expect("encoded");
        let mut decoder = gif::DecodeOptions::new().read_info(&bytes[..]).expect("a GIF");
        let mut hundredths = 0;
        while let Some(frame) = decoder.read_next_frame().expect("read") {
            hundredths += frame.delay;
        }
        assert_eq!(hundredths, 100, "{rate} pictures a second");
    }
}

#[test]
fn wrong_pictures_are_refused_and_a_film_of_numbered_ones_that_fails_leaves_none() {
    let mut sizes = pictures();
    sizes.push(RgbaImage::new(3, 3));
    for pictures in [Vec::new(), vec![RgbaImage::new(0, 5)], vec![RgbaImage::new(70_000, 1)], sizes] {
        assert!(encoded(pictures, &quiet()).is_err());
    }
    assert!(encoded(pictures(), &cancelled()).is_err());
    // A picture that cannot be made ends the film.
    let failing = (2, [Ok(pictures().remove(0)), Err(io::Error::other("no picture"))]);
    let error = encode_film(&mut Vec::new(), failing, 10, &quiet());
    assert!(error.is_err_and(|error| error.to_string() == "no picture"));
    assert!(is_film(Path::new("a/b.GIF")));
    assert!(is_film(Path::new("a.mp4")) && !is_film(Path::new("a.apng")) && !is_film(Path::new("gif")));
    let home = folder();
    let names = || names(&home);
    let (path, silent) = (home.join("sweep.png"), Monitor::default());
    let failing = [Ok(pictures().remove(0)), Err(io::Error::other("no picture"))];
    let error = write_film(&path, (2, failing), 10, &silent).expect_err("a picture is missing");
    assert!(error.to_string().contains("no picture") && names().is_empty(), "{error}");
    write_film(&path, (3, pictures().into_iter().map(Ok)), 10, &silent).expect("written");
    assert_eq!(names(), ["sweep-000.png", "sweep-001.png", "sweep-002.png"]);
    for (file, truth) in film_files(&path, 3).iter().zip(pictures()) {
        assert_eq!(image::open(file).expect("a picture").to_rgba8(), truth, "all of its colours");
    }
}

#[needs::program("ffmpeg")]
#[test]
fn an_mp4_comes_back_picture_by_picture_with_even_sides() {
    let (_home, path) = folder_with("-y a:%03d.mp4");
    let colours = [[200, 40, 40], [40, 200, 40], [40, 40, 200], [128; 3]];
    let picture = |[r, g, b]: [u8; 3]| RgbaImage::from_pixel(33, 17, Rgba([r, g, b, 255]));
    let pictures = (4, colours.map(|colour| Ok(picture(colour))));
    write_film(&path, pictures, 10, &quiet()).expect("written");
    assert!(is_ours(&path), "it has its mark");
    let mut decoder = Command::new("ffmpeg");
    decoder.args(["-nostdin", "-v", "error", "-i"]).arg(format!("file:{}", path.display()));
    let decoded = decoder.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "pipe:1"]).output().expect("it starts");
    assert!(decoded.status.success() && decoded.stderr.is_empty(), "{}", String::from_utf8_lossy(&decoded.stderr));
    let frames: Vec<&[u8]> = decoded.stdout.chunks(34 * 18 * 3).collect();
    assert_eq!((frames.len(), decoded.stdout.len()), (4, 4 * 34 * 18 * 3));
    for (frame, colour) in frames.iter().zip(colours) {
        let middle = &frame[3 * (8 * 34 + 16)..][..3];
        assert!(middle.iter().zip(colour).all(|(a, b)| a.abs_diff(b) <= 12), "{middle:?} for {colour:?}");
    }
}

#[needs::program("ffmpeg")]
#[test]
fn an_mp4_that_fails_or_is_cancelled_leaves_nothing() {
    let (home, path) = folder_with("a.mp4");
    let picture = |side| Ok(RgbaImage::new(side, 8));
    for (pictures, monitor, words) in [
        (vec![picture(8), Err(io::Error::other("no picture"))], quiet(), "no picture"),
        (vec![picture(8), picture(9)], quiet(), "one size"),
        (Vec::new(), quiet(), "at least one picture"),
        (vec![picture(8), picture(8)], cancelled(), "cancelled"),
    ] {
        says(write_film(&path, (2, pictures), 10, &monitor).expect_err(words), &[words]);
        assert!(names(&home).is_empty(), "{words}");
    }
}

#[test]
fn no_name_leaves_its_folder_twins_are_numbered_and_formats_read_as_they_are_shown() {
    let paths = [("../../etc/passwd", "_.._etc_passwd"), ("..", "burst"), ("", "burst")];
    let names = [("slider-far", "slider-far"), ("a:b?", "a_b_"), (" 夜 1. ", "夜 1")];
    names.into_iter().chain(paths).for_each(|(name, safe)| assert_eq!(safe_file_name(name), safe));
    let mut names = ["a", "A", "a_2", "a:", "a?"].map(str::to_owned);
    make_file_names_unique(names.iter_mut().map(|name| (name, None)));
    assert_eq!(names, ["a", "A_2", "a_2_2", "a:", "a?_2"]);
    // Where it is known, the folder says more than a number; what has no twin keeps its name.
    let paths = ["n1/a.tif", "n2/a/0.png", "n2/a", "n2/b.tif"].map(PathBuf::from);
    let mut names = ["a", "a", "a", "b"].map(str::to_owned);
    make_file_names_unique(names.iter_mut().zip(paths.map(Some)));
    assert_eq!(names, ["n1_a", "n2_a", "n2_a_2", "b"]);
    for format in ExportFormat::ALL {
        assert_eq!(format.to_string().parse(), Ok(format));
        assert_eq!(format.to_string().to_uppercase().parse(), Ok(format));
    }
    let error = "xlsx".parse::<ExportFormat>().expect_err("unknown").to_string();
    assert!(ExportFormat::ALL.iter().all(|f| error.contains(&f.to_string())), "{error}");
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Row {
    content: Checksum,
    values: Vec<f64>,
}

fn record() -> Record<Row> {
    let of = Row { content: Checksum::of(b"3 128\n"), values: vec![0.1, 2.5e-7] };
    Record { made_from: MadeFrom::new(json!({ "levels": 4 })), of }
}

#[test]
fn records_come_back_and_go_and_every_sample_has_a_row_and_names_may_hold_anything() {
    let home = folder();
    let records = Records::of(&home);
    assert_eq!(records.read::<Row>("night"), None);
    records.write("night", &record()).expect("written");
    assert_eq!(records.read("night"), Some(record()));
    assert_eq!(records.read::<Record<String>>("night"), None, "it is no text");
    assert!(record().made_from.is_of_this_program());
    assert_ne!(MadeFrom::new(json!({ "levels": 5 })), record().made_from);
    records.remove("night").expect("removed");
    records.remove("night").expect("it is not there");
    assert_eq!(records.read::<Row>("night"), None);
    let sample = |distance_px, value| ProfileSample { distance_px, u: 1.5, v: 2.0, value };
    let profiles = [
        ("Stack (1.00, 0.00)".to_owned(), vec![sample(0.0, 0.25), sample(1.0, 0.5)]),
        ("a \"b\"".to_owned(), vec![sample(0.0, f32::NAN)]),
    ];
    let text = profiles_table(&profiles).csv();
    let expected = "picture,distance_px,u,v,value\n\"Stack (1.00, 0.00)\",0,1.5,2,0.25\n\"Stack (1.00, 0.00)\",1,1.5,2,0.5\n\"a \"\"b\"\"\",0,1.5,2,\n";
    assert_eq!(text, expected);
}

#[test]
fn every_file_that_is_written_is_known_until_somebody_changes_it() {
    let home = folder();
    let at = |name: &str| home.join(name);
    write_png(&at("a.png"), Bitmap::rgb(2, 1, &[9; 6])).expect("written");
    write_tiff(&at("a.tiff"), &Plane::from_fn(400, 300, |u, v| (u * v) as f32)).expect("written");
    for name in ["a.gif", "film.png"] {
        let pictures = (2, [9, 8].map(|_| Ok(RgbaImage::new(9, 9))));
        write_film(&at(name), pictures, 10, &quiet()).expect("written");
    }
    let unit = burstscope_core::export::FigureUnit::Pixel;
    let drawing = Drawing { title: "a".into(), size: [10.0, 10.0], unit, shapes: Vec::new() };
    write_drawing(&at("a.svg"), &drawing).expect("written");
    let parts = vec![sheet::Sheet::new(80.0, "b").finish(40.0); 2];
    write_drawing(&at("b.svg"), &sheet::stacked("both", parts)).expect("written");
    write_text(&at("p.toml"), OutputKind::Settings, burstscope_core::files::written_by() + "levels = 4\n")
        .expect("written");
    let burst = Burst::from_planes("a", vec![Plane::zeros(9, 9)]);
    let (case, part) = Case::of(&burst, &SearchParams::default(), (None, None), "", &quiet()).expect("nobody cancels");
    write_case(&at("a.burstcase"), (&case, &part), &Enclosed::default(), &quiet()).expect("written");
    write_npz(&at("a.npz"), &[], &[], None).expect("written");
    write_csv(&at("a.csv"), &[], None).expect("written");
    write_matches_csv(&at("m.csv"), &[]).expect("written");
    Figure::from(profiles_table(&[("a \"b\", c".into(), Vec::new())])).write(&at("p.csv")).expect("written");
    fs::write(at("c.csv"), format!("{CURVE_COLUMNS}\n")).expect("written");
    write_colmap_keypoints(&at("a.txt"), &[KEYPOINT], &[[7; 128]]).expect("written");
    let mut known = 0;
    for entry in fs::read_dir(&home).expect("a folder") {
        let path = entry.expect("an entry").path();
        assert!(is_ours(&path), "{}", path.display());
        // A byte of the pixels or the text is changed; then one more comes at the end.
        let bytes = fs::read(&path).expect("read");
        let place = if path.ends_with("a.tiff") { 2000 } else { 60.min(bytes.len() / 2) };
        for changed in
            [[&bytes[..place], &[bytes[place] ^ 1], &bytes[place + 1..]].concat(), [&bytes[..], b"?"].concat()]
        {
            fs::write(&path, &changed).expect("written");
            let is_longer_tiff = path.ends_with("a.tiff") && changed.len() > bytes.len();
            assert_eq!(is_ours(&path), is_longer_tiff, "{}", path.display());
        }
        known += 1;
    }
    assert_eq!(known, 15);
}

const KEYPOINT: ColmapKeypoint = ColmapKeypoint { x: 10.25, y: 0.1, scale: 1.6, orientation: -3.0 };

#[test]
fn files_of_others_are_not_taken_for_ours() {
    let home = folder();
    let at = |name: &str| home.join(name);
    for name in ["a.png", "a.tiff", "a.jpg"] {
        image::GrayImage::from_pixel(8, 8, image::Luma([9])).save(at(name)).expect("written");
        assert!(!is_ours(&at(name)), "{name}");
    }
    let numbers = |first: &str| format!("1 128\n{first} 0.1 1.6 -3{}\n", " 7".repeat(128));
    fs::write(at("x"), numbers("10.25")).expect("written");
    assert!(is_ours(&at("x")), "as this program writes it");
    let texts = ["", "\n", " 128\n", "12 a 128", "0 127\n", "2 128\n", "PK\u{3}\u{4}", "II*\0", "SQLite format 3\0"];
    let more = [
        &numbers("10.250000"),
        "u,v\n1,2\n",
        "u,v,sigma\n",
        "set,plot,curve,x,y,low,high\nmine\n",
        "about Burstscope 0.1.0: # Written by Burstscope 0.1.0\n",
        "# Written by Burstscope 0.1.0\nlevels = 4\n",
        "<svg><!-- Written by Burstscope 0.1.0 --></svg>",
    ];
    for text in texts.into_iter().chain(more) {
        fs::write(at("x"), text).expect("written");
        assert!(!is_ours(&at("x")), "{text:?}");
    }
    assert!(!is_ours(&home) && !is_ours(&at("none")));
}

#[test]
fn a_field_is_read_back_from_pfm_and_tiff_with_its_motions_in_their_places() {
    let motion = |u: f32, v: f32, uu: f32| Motion { slope: Slope::new(u, v), covariance: [uu, 0.0, 0.01] };
    let field = MotionField {
        size: (2, 2),
        cell_px: 8,
        motions: vec![motion(1.5, -2.0, 0.04), motion(0.0, 3.0, 0.25), motion(-1.0, 0.5, 4.0), motion(2.0, 0.0, 0.01)],
        unknown_sigma: 1.0,
        layers: Vec::new(),
        layer: vec![0; 4],
    };
    // The last cells are cut by the border.
    let size = (15, 11);
    let folder = folder();
    let (pfm, tiff) = (folder.join("field.pfm"), folder.join("field.tiff"));
    write_field_pfm(&pfm, &field, size).expect("written");
    write_field_tiff(&tiff, &field, size).expect("written");
    let bytes = fs::read(&pfm).expect("read");
    let samples = bytes.strip_prefix(b"PF\n15 11\n-1.0\n").expect("the header of three lines");
    let read: Vec<f32> = samples.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(read.len(), 3 * 15 * 11, "and nothing after the samples");
    for (row, column) in [(0, 0), (0, 14), (10, 3), (7, 8), (8, 7)] {
        let there = field.at(column as f32, row as f32);
        let start = 3 * ((10 - row) * 15 + column);
        let wanted = [there.slope.u, there.slope.v, there.ellipse().0[0]];
        assert_eq!(read[start..start + 3], wanted, "row {row}, column {column}");
    }
    let mut decoder = tiff::decoder::Decoder::new(fs::File::open(&tiff).expect("opens")).expect("a TIFF");
    let tiff::decoder::DecodingResult::F32(page) = decoder.read_image().expect("an image") else { panic!("no f32") };
    let upside_down: Vec<f32> = read.chunks(3 * 15).rev().flatten().copied().collect();
    assert_eq!(page, upside_down, "the same samples, the first row first");
}

fn series(points: &[(f64, f64, Option<[f64; 2]>)]) -> Series {
    let points = points.iter().map(|&(x, y, spread)| SeriesPoint { x, y, spread }).collect();
    Series::new("a < b", ([0; 3], SOLID), 2.0, points)
}

#[test]
fn a_plot_has_room_for_what_it_shows_and_ticks_are_round_and_inside() {
    let all = [series(&[(1.0, 5.0, Some([4.0, 7.0])), (2.0, f64::NAN, None)]), series(&[(1.0, 3.0, None)])];
    assert!((range_from_zero(&all, 1.0).1 - 7.42).abs() < 1e-9);
    assert_eq!(range_from_zero(&[], 1.0), (0.0, 1.06));
    assert_eq!(ticks((-3.0, 3.0)), [-2.0, 0.0, 2.0]);
    assert_eq!(ticks((0.0, 45.0)), [0.0, 10.0, 20.0, 30.0, 40.0]);
    assert_eq!(ticks((2.0, 2.0)), [2.0]);
    for k in 1..400 {
        let range = (-0.013 * f64::from(k), 0.031 * f64::from(k));
        let ticks = ticks(range);
        assert!((2..=12).contains(&ticks.len()) && ticks.iter().all(|t| *t >= range.0 - 1e-9 && *t <= range.1 + 1e-9));
    }
    assert_eq!((short(-2.0), short(0.25), short(0.000_2)), ("−2".into(), "0.25".into(), "2e−4".into()));
}

#[test]
fn lines_break_where_a_value_is_missing_paragraphs_where_they_are_full_and_documents_stack() {
    let spread = Some([0.25, 1.5]);
    let all = [series(&[(0.0, 1.0, None), (1.0, f64::NAN, spread), (2.0, 1.0, spread), (3.0, 2.0, None)])];
    let mut sheet = Sheet::new(300.0, "lines");
    let (range_x, range_y) = ((0.0, 3.0), (0.0, 2.0));
    let plot = Plot { title: "", label_x: "x", label_y: "y", range_x, range_y, has_dots: true, series: &all };
    sheet.plot(Area { x: 60.0, y: 20.0, width: 100.0, height: 100.0 }, &plot);
    assert_eq!(sheet.legend((10.0, 10.0), 50.0, &[all[0].clone(), all[0].clone()]), 50.0, "one under the other");
    let svg = sheet.finish(200.0).svg();
    says(svg.lines().find(|line| line.starts_with("<path")).expect("a line"), &["M60 70M126.667 70L160 20"]);
    assert_eq!(svg.matches("<circle").count(), 3);
    let bars: Vec<&str> = svg.lines().filter(|line| line.contains("stroke-opacity")).collect();
    let is_from_low_to_high = bars[0].contains(r#"y1="107.5""#) && bars[0].contains(r#"y2="45""#);
    assert!(bars.len() == 1 && is_from_low_to_high, "{bars:?}");
    assert!(svg.contains("a &lt; b") && !svg.contains("NaN"), "{svg}");
    let document = |height: f64| Sheet::new(120.0, "part").finish(height);
    let both = stacked("both", vec![document(50.0), document(70.0)]).svg();
    assert!(both.starts_with("<svg ") && both.contains(r#"width="120" height="120""#), "{both}");
    assert!(both.contains(r#"translate(0 50)"#) && both.matches("</g>").count() == 2, "{both}");
    let mut sheet = Sheet::new(200.0, "a < b");
    let next = sheet.paragraph((0.0, 10.0), 10.0, 60.0, "one two three four five six");
    assert!(next > 30.0);
    let text = sheet.finish(50.0).svg();
    assert!(text.contains("<title>a &lt; b</title>") && text.matches("<text").count() >= 3, "{text}");
}
