//! Exported files can be read back: by our own reader, by other libraries, and according to the formats' descriptions.

use crate::prelude::*;
use base64::Engine;
use burstscope_core::export::{
    Bitmap, ColourBar, ExportFormat, FigureMark, FigureMatches, FigureOptions, FigurePanel, FigureWidth, LegendEntry,
    feature_header, lay_out, read_features_csv, write_colmap, write_csv, write_detection, write_drawing, write_npz,
    write_png, write_tiff,
};
use burstscope_core::inspect::result::read_features;
use ndarray::Array2;
use ndarray_npy::NpzReader;

fn feature(seed: u32) -> Feature {
    let x = seed as f32;
    Feature {
        u: 10.1 + x,
        v: 20.7 + 2.0 * x,
        sigma: 1.6 * 1.1f32.powi(seed as i32),
        orientation: 0.3 * x - 3.0,
        slope: Slope::new(1.0 / 3.0 + x, -0.25 * x),
        response: -1e-7 / (1.0 + x),
        snr: if seed == 0 { f32::INFINITY } else { 12.3 + x },
        octave: seed as i32 - 1,
        level: (seed % 3) as i32,
        slope_index: seed as usize,
        at_slope_limit: seed % 2 == 1,
        slope_sigma: 0.125 * x,
        field: if seed == 0 { Slope::default() } else { Slope::new(0.5 - x, 0.75) },
        field_sigma: if seed == 0 { f32::INFINITY } else { 0.0625 },
        layer: seed as i32,
        moves: Moves::ALL[seed as usize % Moves::ALL.len()],
    }
}

fn detection(count: u32) -> Detection {
    let params: DetectorParams = DetectorParams::default();
    Detection {
        features: (0..count).map(feature).collect(),
        descriptors: (0..count).map(descriptor).collect(),
        tally: Tally::default(),
        frame_noise: 0.01,
        noise: Arc::default(),
        field: None,
        noise_gate_factor: 4.5,
        slopes: SlopeGrid::single(Slope::default()),
        frames_used: params.used_frames(5),
        positions: Positions::even(5),
        octaves: 0..3,
        times: StageTimes::default(),
    }
}

fn descriptor(seed: u32) -> Descriptor {
    std::array::from_fn(|i| (i as u32 * 7 + seed * 13) as u8)
}

fn stored(feature: &Feature) -> [f32; 17] {
    Quantity::STORED.map(|quantity| quantity.of(feature).expect("it is stored"))
}

#[test]
fn csv_has_the_exact_header_and_a_row_for_each_feature_and_that_of_earlier_versions_is_read() {
    let (_folder, path) = folder_with("a.csv");
    let features: Vec<Feature> = (0..4).map(feature).collect();
    write_csv(&path, &features, None).expect("written");
    let text = fs::read_to_string(&path).expect("read");
    let mut lines = text.lines();
    let header = "u,v,sigma,orientation,slope_u,slope_v,response,snr,octave,level,at_slope_limit,slope_sigma,field_u,\
                  field_v,field_sigma,layer,motion";
    assert_eq!(lines.next(), Some(header));
    assert_eq!(lines.next(), Some("10.1,20.7,1.6,-3,0.33333334,-0,-0.0000001,inf,-1,0,0,0,,,,,unknown"));
    assert!(text.lines().count() == 5 && text.ends_with('\n'));
    assert_eq!(read_features_csv(&path), Ok(features.iter().map(|f| Feature { slope_index: 0, ..*f }).collect()));
    write_csv(&path, &[], None).expect("written");
    assert_eq!(fs::read_to_string(&path).expect("read"), feature_header() + "\n");
    assert_eq!(read_features_csv(&path), Ok(Vec::new()));
    let by_itself = Feature { slope: Slope::new(9.0, 0.0), slope_sigma: 0.1, field_sigma: 0.1, ..feature(1) };
    write_csv(&path, &[by_itself], None).expect("written");
    let text = fs::read_to_string(&path).expect("read");
    let cut = |columns: usize| {
        let cut = |line: &str| line.split(',').take(columns).collect::<Vec<_>>().join(",") + "\n";
        fs::write(&path, text.lines().map(cut).collect::<String>()).expect("written");
        read_features_csv(&path)
    };
    let found = Feature { slope_index: 0, ..by_itself };
    assert_eq!(cut(16), Ok(vec![Feature { moves: Moves::ByItself, ..found }]), "as its numbers say");
    let (field, field_sigma) = (Slope::default(), f32::INFINITY);
    let unknown = Feature { slope_sigma: 0.0, field, field_sigma, layer: 0, moves: Moves::Unknown, ..found };
    assert_eq!(cut(11), Ok(vec![unknown]));
    fs::write(&path, text.lines().map(|line| line.to_owned() + ",1\n").collect::<String>()).expect("written");
    assert!(read_features_csv(&path).is_err(), "an unknown column");
}

#[test]
fn csv_errors_name_the_file_the_line_and_the_column() {
    let (_folder, path) = folder_with("a.csv");
    says(read_features_csv(&path).expect_err("missing"), &["a.csv"]);
    write_csv(&path, &[feature(1), feature(2)], None).expect("written");
    let mut bytes = fs::read(&path).expect("read");
    let last_line = bytes.len() - 3;
    bytes[last_line] = 0xff;
    fs::write(&path, bytes).expect("written");
    says(read_features_csv(&path).expect_err("not text"), &["line 3: ", "a.csv"]);
    let read = |text: &str| {
        fs::write(&path, text).expect("written");
        read_features_csv(&path)
    };
    let good = "u,v,sigma,orientation,slope_u,slope_v,response,snr,octave,level,at_slope_limit\n\
                1.5,2,3,-0.5,1,0,-0.01,inf,-1,2,1\n4,5,6,0,0,0,0.25,9.5,0,0,0\n";
    assert_eq!(read(good).map(|features| (features.len(), features[0].snr)), Ok((2, f32::INFINITY)));
    assert_eq!(read(&good.replace('\n', "\r\n")), read(good));
    for (text, line, problem) in [
        ("", 1, "header"),
        (&good.replace("sigma", "scale"), 1, "header"),
        (&good.replace("1.5,", "one,"), 2, "u must be a number, not 'one'"),
        (&good.replace(",0,0,0\n", ",0,0\n"), 3, "11 cells, not 10"),
        (&good.replace(",0,0,0\n", ",0,0,yes\n"), 3, "at_slope_limit must be 0 or 1"),
        (&good.replace(",-1,2,", ",-1.5,2,"), 2, "octave must be a whole number"),
        (&format!("{good}\n"), 4, "11 cells, not 1"),
    ] {
        let error = read(text).expect_err(problem).problem;
        assert!(error.starts_with(&format!("line {line}: ")) && error.contains(problem), "{error}");
    }
}

proptest! {
    #[test]
    fn any_number_survives_csv(values in prop::array::uniform8(any::<f32>()), octave: i32, level: i32, limit: bool) {
        let [u, v, sigma, orientation, slope_u, slope_v, response, snr] = values;
        let slope = Slope::new(slope_u, slope_v);
        let octave_level = Feature { octave, level, at_slope_limit: limit, ..feature(0) };
        let feature = Feature { u, v, sigma, orientation, slope, response, snr, ..octave_level };
        let (_folder, path) = folder_with("a.csv");
        write_csv(&path, &[feature], None).expect("written");
        let row = read_features_csv(&path).expect("read")[0];
        let bits = |f: &Feature| stored(f).map(|v| if v.is_nan() { u32::MAX } else { v.to_bits() });
        prop_assert_eq!(bits(&row), bits(&feature));
        prop_assert_eq!((row.octave, row.level), (octave, level));
    }
}

#[test]
fn npz_holds_both_arrays_and_colmap_text_has_its_header_its_offset_and_its_numbers() {
    let (_folder, path) = folder_with("a.npz");
    for count in [0, 1, 5] {
        let Detection { features, descriptors, .. } = detection(count);
        write_npz(&path, &features, &descriptors, None).expect("written");
        let mut npz = NpzReader::new(fs::File::open(&path).expect("opened")).expect("a zip file");
        assert_eq!(npz.names().expect("names"), ["features", "descriptors"]);
        let rows: Array2<f32> = npz.by_name("features").expect("features");
        let bytes: Array2<u8> = npz.by_name("descriptors").expect("descriptors");
        assert_eq!((rows.dim(), bytes.dim()), ((count as usize, 17), (count as usize, 128)));
        // A motion of the field that is unknown is no number.
        let same = |(a, b): (&f32, f32)| *a == b || a.is_nan() && b.is_nan();
        assert!(rows.iter().zip(features.iter().flat_map(stored)).all(same), "{rows}");
        assert!(bytes.iter().eq(descriptors.as_flattened()));
    }
    let (_folder, path) = folder_with("a.txt");
    let Detection { features, descriptors, .. } = detection(3);
    write_colmap(&path, &features, &descriptors).expect("written");
    let text = fs::read_to_string(&path).expect("read");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("3 128"));
    for (feature, descriptor) in features.iter().zip(&descriptors) {
        let line = lines.next().expect("a line for each feature");
        let numbers: Vec<f32> = line.split(' ').map(|n| n.parse().expect("a number")).collect();
        assert_eq!(numbers.len(), 4 + 128);
        // The first pixel's centre, (0, 0) here, is (0.5, 0.5) there.
        assert_eq!(numbers[..4], [feature.u + 0.5, feature.v + 0.5, feature.sigma, feature.orientation]);
        assert!(numbers[4..].iter().zip(descriptor).all(|(n, d)| *n == f32::from(*d)));
        assert!(line.split(' ').skip(4).all(|n| n.parse::<u8>().is_ok()), "descriptors are whole numbers");
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn the_same_features_give_the_same_bytes_in_every_format_under_the_bursts_name() {
    let folder = folder();
    let nine = detection(9);
    let paths =
        ["a", "b"].map(|name| write_detection(&folder, name, &nine, None, &ExportFormat::ALL).expect("written"));
    for (a, b) in paths[0].iter().zip(&paths[1]) {
        assert_eq!(fs::read(a).expect("read"), fs::read(b).expect("read"), "{}", a.display());
    }
    let (_folder, out) = folder_with("out/here");
    let paths = write_detection(&out, "slider-far", &detection(2), None, &ExportFormat::ALL).expect("written");
    assert_eq!(paths, ["slider-far.csv", "slider-far.txt", "slider-far.npz"].map(|n| out.join(n)));
    assert_eq!(names(&out), ["slider-far.csv", "slider-far.npz", "slider-far.txt"]);
    let paths = write_detection(&out, "../a/b", &detection(2), None, &[ExportFormat::Csv]).expect("written");
    assert_eq!(paths[0].parent(), Some(&*out));
}

#[test]
fn a_plane_survives_as_tiff_and_opens_as_a_burst_and_png_keeps_every_byte() {
    let (_folder, path) = folder_with("dog.tiff");
    let plane = Plane::from_fn(31, 17, |u, v| (u as f32 - 15.0) * 1e-4 / (1.0 + v as f32));
    write_tiff(&path, &plane).expect("written");
    assert_eq!(*Burst::open(&path).expect("opens").frames[0], plane);
    says(write_tiff(&path, &Plane::zeros(0, 5)).expect_err("no pixels").problem, &["0×5"]);
    assert!(Burst::open(&path).is_ok(), "the file that was there is untouched");
    let (_folder, path) = folder_with("view.png");
    let pixels: Vec<u8> = (0..5 * 3 * 4).map(|i| (i * 11) as u8).collect();
    write_png(&path, Bitmap::rgba(5, 3, &pixels)).expect("written");
    assert_eq!(image::open(&path).expect("opens").into_rgba8().into_raw(), pixels);
    write_png(&path, Bitmap::rgb(5, 4, &pixels)).expect("written");
    assert_eq!(image::open(&path).expect("opens").into_rgb8().into_raw(), pixels);
    assert!(write_png(&path, Bitmap::rgb(0, 0, &[])).is_err_and(|error| error.problem.contains("0×0")));
}

fn number(node: roxmltree::Node<'_, '_>, name: &str) -> f32 {
    node.attribute(name).and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{name} of {node:?}"))
}

/// A panel of 40 × 30 pixels with two features and a third with invalid numbers.
fn panel(pixels: &[u8]) -> FigurePanel {
    let mark = |u: f32, v: f32, color: [u8; 3]| FigureMark {
        centre: [u, v],
        radius: 3.0,
        orientation: Some(0.0),
        motion: None,
        motion_sigma: 2.0,
        color,
        opacity: 1.0,
        weight: 1.0,
        dashed: false,
    };
    FigurePanel {
        size: (40, 30),
        rgba: Arc::new(pixels.to_vec()),
        origin_image: [-0.5, -0.5],
        image_px_per_px: 1.0,
        marks: vec![
            FigureMark { motion: Some([[0.5, 9.0], [18.5, 0.0]]), ..mark(9.5, 4.5, [255, 0, 0]) },
            mark(f32::NAN, 3.0, [0; 3]),
            FigureMark { opacity: 0.35, dashed: true, ..mark(20.0, 10.0, [0, 0, 255]) },
        ],
        title: None,
        legend: Vec::new(),
        bar: None,
    }
}

#[test]
fn a_figure_is_valid_xml_with_everything_in_its_place() {
    let (_folder, path) = folder_with("figure.svg");
    let pixels: Vec<u8> = (0..40 * 30 * 4).map(|i| if i % 4 == 3 { 255 } else { i as u8 }).collect();
    let legend = vec![
        LegendEntry::square([255, 0, 0], "λ = (2, −1) px/frame".into()),
        LegendEntry::square([0, 0, 255], "a & b".into()),
    ];
    let title = Some("Slope < 3 & \"noise\" \u{7} é".into());
    let width = FigureWidth::PxPerPx(2.0);
    let options = FigureOptions { width, stroke_width: 2.0, ..FigureOptions::default() };
    let one = vec![FigurePanel { title, legend, ..panel(&pixels) }];
    write_drawing(&path, &lay_out(&[one], &FigureMatches::default(), &options)).expect("written");
    let text = fs::read_to_string(&path).expect("read");
    let document = roxmltree::Document::parse(&text).expect("valid XML");
    let all = |tag: &'static str| document.descendants().filter(move |n| n.has_tag_name(tag)).collect::<Vec<_>>();
    let root = document.root_element();
    assert!(root.has_tag_name(("http://www.w3.org/2000/svg", "svg")));
    assert!(number(root, "width") > 200.0, "a small picture's figure is wide enough for its title");
    // The picture, twice as large, with its exact bytes, and space for the title above and the legend below.
    let image = all("image")[0];
    assert_eq!((number(image, "width"), number(image, "height")), (80.0, 60.0));
    let (left, top) = (number(image, "x"), number(image, "y"));
    assert!(top > 14.0 && top + 60.0 + 14.0 < number(root, "height"));
    let href = image.attribute(("http://www.w3.org/1999/xlink", "href")).expect("a link");
    let coded = href.strip_prefix("data:image/png;base64,").expect("an embedded PNG");
    let decoded = base64::engine::general_purpose::STANDARD.decode(coded).expect("Base64");
    assert_eq!(image::load_from_memory(&decoded).expect("a PNG").into_rgba8().into_raw(), pixels);
    // The circles: the first pixel's centre is half a pixel from the corner. The one that is not a number is left out.
    let circles = all("circle");
    assert_eq!(circles.len(), 2);
    let near = |a: f32, b: f32| (a - b).abs() < 2e-3;
    assert!(near(number(circles[0], "cx") - left, 20.0) && near(number(circles[0], "cy") - top, 10.0));
    assert_eq!((number(circles[0], "r"), number(circles[0], "stroke-width")), (6.0, 2.0));
    assert_eq!((circles[0].attribute("stroke"), circles[0].attribute("stroke-dasharray")), (Some("#ff0000"), None));
    assert_eq!((circles[1].attribute("stroke"), number(circles[1], "stroke-opacity")), (Some("#0000ff"), 0.35));
    assert!(circles[1].attribute("stroke-dasharray").is_some());
    // The overlay is clipped to the picture.
    let clip = all("clipPath")[0].first_element_child().expect("a rectangle");
    assert_eq!((number(clip, "width"), number(clip, "height")), (80.0, 60.0));
    // One orientation tick each; an arrow with its barbs only where something moves.
    let paths =
        |class: &str| all("path").into_iter().filter(|p| p.attribute("class") == Some(class)).collect::<Vec<_>>();
    let way = |path: &roxmltree::Node<'_, '_>| -> Vec<f32> {
        let d = path.attribute("d").expect("a way");
        d.split(['M', 'L', ' ']).filter_map(|n| n.parse().ok()).collect()
    };
    let goes = |path: &roxmltree::Node<'_, '_>, expected: [f32; 4]| {
        let numbers = way(path);
        let expected = [expected[0] + left, expected[1] + top, expected[2] + left, expected[3] + top];
        assert!(numbers.len() == 4 && numbers.iter().zip(expected).all(|(a, b)| near(*a, b)), "{numbers:?}");
    };
    assert_eq!(paths("orientation").len(), 2);
    goes(&paths("orientation")[0], [20.0, 10.0, 26.0, 10.0]);
    assert_eq!(paths("motion").len(), 2);
    goes(&paths("motion")[0], [2.0, 19.0, 38.0, 1.0]);
    // Its fan lies below all lines, begins in the middle of the arrow, and is not drawn where there is no arrow.
    let [fan] = paths("fan")[..] else { panic!("one fan") };
    assert_eq!((fan.attribute("fill"), number(fan, "fill-opacity")), (Some("#ff0000"), 0.16));
    assert!(near(way(&fan)[0], left + 20.0) && near(way(&fan)[1], top + 10.0), "{:?}", way(&fan));
    let order = |node| document.descendants().position(|other| other == node);
    assert!(order(fan) < order(circles[0]) && order(fan) > order(image));
    let texts: Vec<_> = all("text").iter().filter_map(|t| t.text().map(str::to_owned)).collect();
    assert_eq!(texts, ["Slope < 3 & \"noise\" \u{fffd} é", "λ = (2, −1) px/frame", "a & b"]);
    // Without features there are no marks.
    let plain = vec![FigurePanel { marks: Vec::new(), ..panel(&pixels) }];
    let plain = lay_out(&[plain], &FigureMatches::default(), &FigureOptions::default());
    write_drawing(&path, &plain).expect("written");
    let text = fs::read_to_string(&path).expect("read");
    let document = roxmltree::Document::parse(&text).expect("valid XML");
    assert!(!document.descendants().any(|n| n.has_tag_name("path") || n.has_tag_name("text")));
    assert_eq!(document.root_element().attribute("viewBox"), Some("0 0 40 30"));
}

#[test]
fn several_panels_have_letters_bars_and_lengths() {
    let (_folder, path) = folder_with("figure.svg");
    let pixels = vec![128u8; 40 * 30 * 4];
    let bar = Some(ColourBar { colors: vec![[0; 3], [255; 3]], low: "0.05".into(), high: "0.1 of full scale".into() });
    let width = FigureWidth::PxPerPx(4.0);
    let options = FigureOptions { letters: true, scale_bar: true, width, ..FigureOptions::default() };
    let first = FigurePanel { bar, title: Some("Frame 3".into()), ..panel(&pixels) };
    let drawing = lay_out(&[vec![first, panel(&pixels)], vec![panel(&pixels)]], &FigureMatches::default(), &options);
    write_drawing(&path, &drawing).expect("written");
    let text = fs::read_to_string(&path).expect("read");
    let document = roxmltree::Document::parse(&text).expect("valid XML");
    let texts: Vec<&str> = document.descendants().filter(|n| n.has_tag_name("text")).filter_map(|t| t.text()).collect();
    for wanted in ["(a) Frame 3", "(b)", "(c)", "0.05", "0.1 of full scale", "5 px"] {
        assert!(texts.contains(&wanted), "{wanted}: {texts:?}");
    }
    // Five image pixels at four figure pixels each.
    let scale = document.descendants().find(|n| n.attribute("class") == Some("scale")).expect("a scale bar");
    let numbers: Vec<f32> =
        scale.attribute("d").expect("a path").split(['M', 'L', ' ']).filter_map(|n| n.parse().ok()).collect();
    assert!((numbers[2] - numbers[0] - 20.0).abs() < 1e-2, "{numbers:?}");
}

proptest! {
    #[test]
    fn any_figure_is_valid_xml(
        title in any::<String>(),
        labels in prop::collection::vec(any::<String>(), 0..4),
        values in prop::array::uniform4(any::<f32>()),
        (scale, on_paper) in any::<(f32, bool)>(),
    ) {
        let (_folder, path) = folder_with("figure.svg");
        let legend = labels.into_iter().map(|label| LegendEntry::square([1, 2, 3], label)).collect();
        let width = if on_paper { FigureWidth::Millimetres(scale) } else { FigureWidth::PxPerPx(scale) };
        let options = FigureOptions { width, letters: true, scale_bar: true, ..FigureOptions::default() };
        let [u, v, sigma, orientation] = values;
        let motion = Some([[u, v], [sigma, orientation]]);
        let mark = FigureMark { centre: [u, v], radius: sigma, orientation: Some(orientation), motion, ..panel(&[]).marks[0] };
        let one = FigurePanel { size: (1, 1), rgba: Arc::new(vec![0; 4]), marks: vec![mark], ..panel(&[]) };
        let one = FigurePanel { title: Some(title.clone()), legend, ..one };
        write_drawing(&path, &lay_out(&[vec![one]], &FigureMatches::default(), &options)).expect("written");
        let text = fs::read_to_string(&path).expect("read");
        prop_assert!(roxmltree::Document::parse(&text).is_ok());
        prop_assert!(!text.contains("NaN") || title.contains("NaN"));
    }
}

#[test]
fn what_cannot_be_written_leaves_everything_as_it_was() {
    let folder = folder();
    let detection = detection(2);
    // A folder in place of the file.
    fs::create_dir(folder.join("a.csv")).expect("made");
    let error = write_detection(&folder, "a", &detection, None, &[ExportFormat::Csv]).expect_err("a folder is there");
    assert!(error.to_string().contains("a.csv"), "{error}");
    assert_eq!(names(&folder), ["a.csv"]);
    // A file in place of the folder.
    fs::write(folder.join("file"), "precious").expect("written");
    let error = write_detection(&folder.join("file"), "a", &detection, None, &[ExportFormat::Npz]);
    assert!(error.as_ref().is_err_and(|error| error.kind == ErrorKind::Unwritten), "{error:?}");
    assert_eq!(fs::read(folder.join("file")).expect("read"), b"precious");
    assert_eq!(names(&folder), ["a.csv", "file"]);
}

#[test]
fn both_formats_come_back_with_the_same_places_and_what_is_neither_is_refused_with_what_would_be_right() {
    let home = folder();
    let slope = Slope::new(1.0, -0.5);
    let at = |u, v| Feature { u, v, sigma: 2.5, orientation: 0.5, slope, ..Feature::default() };
    let features = [at(10.25, 20.5), at(0.0, 3.0)];
    let (csv, text) = (home.join("a.csv"), home.join("a.txt"));
    write_csv(&csv, &features, None).expect("written");
    write_colmap(&text, &features, &[[7; 128]; 2]).expect("written");
    let (a, b) = (read_features(&csv).expect("ours"), read_features(&text).expect("COLMAP's"));
    assert_eq!(a.len(), 2);
    for (a, b) in a.iter().zip(&b) {
        assert_eq!((a.pos_image, a.sigma, a.orientation), (b.pos_image, b.sigma, b.orientation));
    }
    assert_eq!((a[0].slope, b[0].slope), (Some(slope), None));
    says(error_of("x;y;z\n1;2;3\n"), &["x;y;z", "u,v,sigma", "COLMAP"]);
    assert!(error_of("").contains("neither"));
    let header = feature_header();
    assert!(error_of(&format!("{header}\nnan,2,3,0,0,0,0.1,5,0,0,0,0,0,0,inf,0,unknown\n")).contains("two numbers"));
    assert!(error_of(&format!("{header}\n1,2,0,0,0,0,0.1,5,0,0,0,0,0,0,inf,0,unknown\n")).contains("above 0"));
    says(read_features(Path::new("/nowhere/at.all")).expect_err("missing"), &["/nowhere/at.all"]);
}

fn error_of(text: &str) -> String {
    let file = tempfile::NamedTempFile::new().expect("a file");
    fs::write(file.path(), text).expect("written");
    read_features(file.path()).expect_err("refused").to_string()
}
