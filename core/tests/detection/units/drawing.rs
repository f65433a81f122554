//! Drawings and tables, and their files.

use crate::prelude::*;
use burstscope_core::export::*;
use image::RgbaImage;

fn drawing(shapes: Vec<FigureShape>) -> Drawing {
    Drawing { size: [60.0, 40.0], unit: FigureUnit::Pixel, shapes, title: String::new() }
}

fn line(from: [f32; 2], to: [f32; 2]) -> FigureShape {
    FigureShape::Line { points: vec![Some(from), Some(to)], style: red().into(), class: "x" }
}

fn red() -> FigureStroke {
    FigureStroke::new([255, 0, 0], 4.0)
}

#[test]
fn pictures_lines_circles_and_the_tints_of_areas_are_where_they_belong() {
    let picture = FigureShape::Picture {
        rect: FigureRect { min: [10.0, 10.0], size: [20.0, 10.0] },
        size: (2, 1),
        rgba: Arc::new(vec![0, 0, 0, 255, 0, 0, 255, 255]),
    };
    let circle = FigureShape::Circle { centre: [45.0, 15.0], radius: 8.0, style: red().into() };
    let image = rasterise(&drawing(vec![picture, line([0.0, 30.0], [60.0, 30.0]), circle])).expect("small");
    assert_eq!(image.dimensions(), (60, 40));
    let pixel = |x: u32, y: u32| image.get_pixel(x, y).0;
    assert_eq!((pixel(15, 15), pixel(25, 15), pixel(5, 5)), ([0, 0, 0, 255], [0, 0, 255, 255], [255; 4]));
    assert_eq!((pixel(30, 30), pixel(30, 25)), ([255, 0, 0, 255], [255; 4]));
    assert_eq!((pixel(53, 15), pixel(45, 15)), ([255, 0, 0, 255], [255; 4]));
    let points = fan([10.0, 20.0], [40.0, 20.0], 10.0).expect("large enough");
    let style = Style { fill: Some(([255, 0, 0], 0.5)), stroke: None };
    let fan = FigureShape::Line { points: points.into_iter().map(Some).collect(), style, class: "fan" };
    let image = rasterise(&drawing(vec![fan])).expect("small");
    let pixel = |x: u32, y: u32| image.get_pixel(x, y).0;
    for (x, y) in [(40, 20), (45, 14), (20, 20)] {
        let [red, green, blue, _] = pixel(x, y);
        assert!(red == 255 && green.abs_diff(127) < 3 && green == blue, "{x} {y}: {:?}", pixel(x, y));
    }
    [(53, 20), (15, 12), (5, 20)].into_iter().for_each(|(x, y)| assert_eq!(pixel(x, y), [255; 4], "{x} {y}"));
}

#[test]
fn a_preview_is_what_a_file_shows_in_no_more_pixels_than_are_asked_for() {
    let of = drawing(vec![line([0.0, 30.0], [60.0, 30.0])]);
    let preview = |most, to_pixels| rasterise_preview(&of, most, to_pixels).expect("small");
    let whole = rasterise(&of).expect("small");
    assert!(preview([60, 40], true) == whole);
    assert!(preview([400, 300], false) == whole, "it is not enlarged");
    let half = preview([30, 300], true);
    assert_eq!(half.dimensions(), (30, 20));
    let [red, green, ..] = half.get_pixel(15, 15).0;
    assert!(red > 250 && green < 5, "the line is as much smaller");
    assert_eq!(half.get_pixel(15, 5).0, [255; 4]);
    let large = Drawing { size: [1e6, 1e5], ..drawing(Vec::new()) };
    for refused in [rasterise(&large), rasterise_preview(&large, [100, 100], true)] {
        assert!(refused.is_err_and(|why| why.contains("smaller scale")), "no file of it would be written");
    }
    let vectors = rasterise_preview(&large, [100, 100], false).expect("vectors have any size");
    assert_eq!(vectors.dimensions(), (100, 10));
}

#[test]
fn a_page_has_the_size_of_the_figure_its_texts_and_a_grey_picture() {
    let home = folder();
    let rect = FigureRect { min: [10.0, 10.0], size: [40.0, 30.0] };
    let rgba = Arc::new([[9, 9, 9, 255], [200, 200, 200, 255]].concat());
    let stroke = FigureStroke { opacity: 0.7, ..FigureStroke::new([213, 94, 0], 0.75) }.dashed([3.0, 2.0]);
    let line = |points, style| FigureShape::Line { points, style, class: "match" };
    let area = Style { fill: Some(([1, 2, 3], 0.2)), stroke: None };
    let over = vec![
        FigureShape::Circle { centre: [30.0, 20.0], radius: 5.0, style: stroke.into() },
        line(vec![Some([0.0, 0.0]), Some([40.0, 30.0]), None, Some([1.0, 1.0])], stroke.into()),
        line(vec![Some([0.0, 0.0]), Some([9.0, 0.0]), Some([9.0, 9.0])], area),
        // Nothing is drawn of what has no size.
        FigureShape::Circle { centre: [30.0, 20.0], radius: 0.0, style: stroke.into() },
        line(Vec::new(), stroke.into()),
    ];
    let text = |face, upwards| {
        let (at, anchor, size, color) = ([10.0, 50.0], Anchor::Middle, 8.0, [0; 3]);
        FigureShape::Text { at, anchor, size, face, color, upwards, text: "σ − × ·".into() }
    };
    let shapes = vec![
        FigureShape::Picture { rect, size: (2, 1), rgba },
        FigureShape::Clipped { rect, round: true, shapes: over },
        FigureShape::Moved { by: [1.0, 2.0], shapes: vec![text(Face::Plain, false), text(Face::Bold, true)] },
        text(Face::Mono, false),
    ];
    for (unit, media) in [(FigureUnit::Point, "[0 0 88 60]"), (FigureUnit::Pixel, "[0 0 66 45]")] {
        let drawing = Drawing { size: [88.0, 60.0], unit, shapes: shapes.clone(), title: "A title".into() };
        let path = home.join("a.pdf");
        write_drawing(&path, &drawing).expect("written");
        let bytes = fs::read(&path).expect("read");
        let says = |text: &str| bytes.windows(text.len()).any(|part| part == text.as_bytes());
        assert!(bytes.starts_with(b"%PDF-1.7") && says("%%EOF"));
        assert!(says(media) && says("/DeviceGray") && says("Ubuntu") && says("Hack") && says("/Font"), "{media}");
    }
}

#[test]
fn what_is_missing_is_said_in_the_picture_and_the_ending_decides_the_file() {
    let rows =
        vec![vec!["A, \"B\"".into(), Cell::Number(98.25, 1)], vec!["C_1 & σ".into(), Cell::of(Some(f64::NAN), 1)]];
    let mut table = Table::new("Numbers", "method,images_pass_percent", rows);
    table.columns[1].0 = ["images".into(), "pass, %".into()];
    table.notes.push("– means missing".into());
    assert_eq!(table.csv(), "method,images_pass_percent\n\"A, \"\"B\"\"\",98.25\nC_1 & σ,\n");
    assert_eq!(table.text(), "method    images pass, %\nA, \"B\"              98.2\nC_1 & σ                –\n");
    says(table.drawing().svg(), &[">98.2<", ">–<", "– means missing"]);
    let latex = table.latex();
    assert!(latex.starts_with("% Numbers\n\\begin{tabular}{lr}\n") && latex.ends_with("% – means missing\n"));
    // A bracket at the begin of a row would be an option of the line break before.
    let row = Table::new("", "a,b", vec![vec!["[1] x*".into(), Cell::Number(2.0, 0)]]).latex();
    assert!(row.contains("\n{$[$}1{$]$} x{$*$} & 2 "), "{row}");
    assert!(latex.contains("method & images pass, \\% \\\\\n") && latex.contains("\nC\\_1 \\& $\\sigma$ & -- \\\\\n"));
    let home = folder();
    let header = "picture,distance_px,u,v,value";
    let row = ["a", "1", "2", "3", "4"].map(Cell::from).to_vec();
    let figure = Figure::from(Table::new("A & b", header, vec![row]));
    let starts: [&[u8]; 5] = [b"%PDF-", b"<svg ", b"\x89PNG", b"picture,", b"% A & b\n"];
    for (format, start) in FigureFormat::ALL.into_iter().zip(starts) {
        let path = home.join(format!("x.{}", format.extension().to_uppercase()));
        figure.write(&path).expect("written");
        let mut bytes = fs::read(&path).expect("read");
        assert!(bytes.starts_with(start) && is_ours(&path), "{format:?}");
        bytes.push(b'x');
        fs::write(&path, bytes).expect("changed");
        assert!(!is_ours(&path), "{format:?}");
    }
    let wrong = figure.write(Path::new("x.txt")).expect_err("no such format");
    assert!(wrong.to_string().contains("end the name in .pdf, .svg, .png, .csv or .tex: x.txt"), "{wrong}");
    says(write_drawing(Path::new("x.csv"), &figure.drawing).expect_err("no numbers"), &[".pdf, .svg or .png"]);
}

#[test]
fn a_fan_touches_the_circle_of_its_tip_and_what_is_clipped_ends_at_the_rectangle() {
    let (middle, tip) = ([10.0, 20.0], [40.0, 20.0]);
    let points = fan(middle, tip, 10.0).expect("large enough");
    let bounds = |i: usize| {
        let along = || points.iter().map(|point| point[i]);
        (along().fold(f32::INFINITY, f32::min), along().fold(f32::NEG_INFINITY, f32::max))
    };
    let ((left, right), (top, bottom)) = (bounds(0), bounds(1));
    assert!((left - 10.0).abs() < 1e-3 && (right - 50.0).abs() < 1e-3, "{points:?}");
    assert!((9.0..=10.001).contains(&(0.5 * (bottom - top))), "{points:?}");
    let large = fan(middle, tip, 40.0).expect("large enough");
    let reach = |point: &[f32; 2]| (point[0] - tip[0]).hypot(point[1] - tip[1]);
    assert!(large[0] == tip && large[1..].iter().all(|point| (reach(point) - 40.0).abs() < 1e-3));
    for none in [0.0, 2.9, f32::INFINITY, f32::NAN] {
        assert_eq!(fan(middle, tip, none), None, "{none}");
    }
    let rect = FigureRect { min: [0.0, 0.0], size: [30.0, 40.0] };
    let (anchor, face, color) = (Anchor::End, Face::Bold, [0; 3]);
    let text = |at, upwards| {
        let text = "HEH".into();
        FigureShape::Text { at, anchor, size: 16.0, face, color, upwards, text }
    };
    let clipped = |shapes| FigureShape::Clipped { rect, round: true, shapes };
    let lines = vec![line([0.0, 5.0], [60.0, 5.0])];
    let image = rasterise(&drawing(vec![clipped(lines), text([58.0, 34.0], false)])).expect("small");
    assert_eq!((image.get_pixel(20, 5).0, image.get_pixel(45, 5).0), ([255, 0, 0, 255], [255; 4]));
    let dark = |y: u32| (0..60).filter(|x| image.get_pixel(*x, y).0[0] < 120).count();
    assert!(dark(30) > 3, "letters are drawn");
    assert_eq!((dark(37), dark(15)), (0, 0), "and end at the line that they stand on");
    let column = |image: &RgbaImage, x: u32| (0..40).filter(|y| image.get_pixel(x, *y).0[0] < 120).count();
    assert!(column(&image, 59) == 0 && (50..58).any(|x| column(&image, x) > 3), "a text ends at its place");
    let moved = FigureShape::Moved { by: [10.0, 0.0], shapes: vec![text([20.0, 2.0], true)] };
    let turned = rasterise(&drawing(vec![moved])).expect("small");
    let widest = (0..60).max_by_key(|x| column(&turned, *x)).expect("columns");
    assert!((18..30).contains(&widest) && column(&turned, 31) == 0, "upwards it stands left of it: {widest}");
}

#[test]
fn lines_go_from_place_to_place_and_what_is_out_of_sight_is_left_out() {
    let rows = vec![vec![FigurePanel { origin_image: [9.5, -0.5], ..panel((20, 10)) }; 2]];
    let options = FigureOptions { width: FigureWidth::PxPerPx(2.0), ..FigureOptions::default() };
    let (panels, ends_image) = ([0, 1], [[9.5, -0.5], [29.5, 9.5]]);
    let link = FigureLink { panels, ends_image, color: [1; 3], opacity: 1.0, weight: 1.0, dashed: false };
    let drawn = |links: &[FigureLink]| {
        let matches = FigureMatches { links: links.to_vec(), legend: Vec::new() };
        let (plain, with) = (lay_out(&rows, &FigureMatches::default(), &options), lay_out(&rows, &matches, &options));
        let rects: Vec<FigureRect> = pictures(&with.shapes);
        (rects, with.shapes[plain.shapes.len()..].to_vec())
    };
    let (rects, shapes) = drawn(&[link]);
    let [FigureShape::Line { points, .. }, FigureShape::Circle { .. }, FigureShape::Circle { .. }] = &shapes[..] else {
        panic!("a line and its ends: {shapes:?}");
    };
    let corner = [rects[1].min[0] + rects[1].size[0], rects[1].min[1] + rects[1].size[1]];
    assert_eq!(points.as_slice(), [Some(rects[0].min), Some(corner)]);
    let kinds = |links: &[FigureLink]| {
        let (_, shapes) = drawn(links);
        let lines = shapes.iter().filter(|shape| matches!(shape, FigureShape::Line { .. })).count();
        (lines, shapes.len() - lines)
    };
    assert_eq!(kinds(&[FigureLink { ends_image: [[9.5, -0.5], [5.0, 5.0]], ..link }]), (0, 1), "one end is seen");
    assert_eq!(kinds(&[FigureLink { ends_image: [[f32::NAN, 0.0], [1e20, 5.0]], ..link }]), (0, 0));
    assert_eq!(kinds(&[FigureLink { panels: [0, 7], ..link }]), (0, 1));
    assert_eq!(kinds(&[FigureLink { dashed: true, ..link }]), (1, 2), "dashes are one line");
}

fn panel(size: (usize, usize)) -> FigurePanel {
    let rgba = Arc::new(vec![9; size.0 * size.1 * 4]);
    let (origin_image, marks, title, legend, bar) = ([-0.5, -0.5], Vec::new(), None, Vec::new(), None);
    FigurePanel { size, rgba, origin_image, image_px_per_px: 1.0, marks, title, legend, bar }
}

fn pictures(shapes: &[FigureShape]) -> Vec<FigureRect> {
    let rect = |shape: &FigureShape| match shape {
        FigureShape::Picture { rect, .. } => Some(*rect),
        _ => None,
    };
    shapes.iter().filter_map(rect).collect()
}

#[test]
fn panels_do_not_overlap_and_lie_on_the_sheet() {
    let mut titled = panel((40, 30));
    titled.title = Some("A long title that needs much more room than its picture has".into());
    titled.bar = Some(ColourBar { colors: vec![[1; 3]; 9], low: "0".into(), high: "0.1 of full scale".into() });
    let rows = [vec![panel((20, 60)), titled.clone()], vec![titled, panel((10, 10))]];
    let width = FigureWidth::PxPerPx(2.0);
    let drawing =
        lay_out(&rows, &FigureMatches::default(), &FigureOptions { letters: true, width, ..FigureOptions::default() });
    let rects: Vec<FigureRect> = pictures(&drawing.shapes);
    assert_eq!(rects.len(), 4);
    assert_eq!((rects[0].min[0], rects[1].min[0]), (rects[2].min[0], rects[3].min[0]), "columns are not in line");
    for (i, a) in rects.iter().enumerate() {
        assert!((0..2).all(|k| a.min[k] >= 0.0 && a.min[k] + a.size[k] <= drawing.size[k] + 1e-3));
        let apart =
            |b: &FigureRect| (0..2).any(|k| a.min[k] + a.size[k] <= b.min[k] || b.min[k] + b.size[k] <= a.min[k]);
        assert!(rects[..i].iter().all(apart), "{rects:?}");
    }
    let letters = |letter: &str| {
        drawing.shapes.iter().any(|s| matches!(s, FigureShape::Text { text, .. } if text.starts_with(letter)))
    };
    assert!(letters("(a)") && letters("(d)") && !letters("(e)"));
}

#[test]
fn a_figure_for_print_has_its_width_and_says_once_what_its_panels_share() {
    let bar = ColourBar { colors: vec![[1; 3]; 9], low: "0".into(), high: "1 of full scale".into() };
    let title = Some("A: DSC_0001 · Motion stack · slope (2.40, 0.00) px/frame".to_owned());
    let one = FigurePanel { title, bar: Some(bar), ..panel((1152, 771)) };
    let entry = |mark, label: &str| LegendEntry { mark, color: [1; 3], label: label.to_owned() };
    let legend = vec![entry(LegendMark::Line, "456 inliers"), entry(LegendMark::Dashes, "88 outliers")];
    let matches = FigureMatches { links: Vec::new(), legend };
    for (mm, font_size) in [(88.0, 6.0), (181.0, 8.0)] {
        let width = FigureWidth::Millimetres(mm);
        let options = FigureOptions { width, font_size, letters: true, scale_bar: true, ..FigureOptions::default() };
        let drawing = lay_out(&[vec![one.clone(), one.clone()]], &matches, &options);
        assert!((drawing.size[0] - mm * 72.0 / 25.4).abs() < 0.01, "{:?}", drawing.size);
        assert_eq!(drawing.unit, FigureUnit::Point);
        let rects: Vec<FigureRect> = pictures(&drawing.shapes);
        assert_eq!(rects[0].min[1], rects[1].min[1], "pictures of a row are level");
        let right = rects[1].min[0] + rects[1].size[0];
        assert!((right - drawing.size[0]).abs() < 0.01, "they fill the width");
        let says = |part: &str| {
            let is_said = |shape: &&FigureShape| matches!(shape, FigureShape::Text { text, .. } if text.contains(part));
            drawing.shapes.iter().filter(is_said).count()
        };
        assert_eq!((says("full scale"), says("inliers"), says("outliers"), says("DSC")), (1, 1, 1, 2));
    }
}
