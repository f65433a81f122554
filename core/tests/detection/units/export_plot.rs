//! Tests of `export::plot`.

use burstscope_core::export::sheet::*;
use burstscope_core::export::*;

fn series(points: &[(f64, f64, Option<[f64; 2]>)]) -> Series {
    let points = points.iter().map(|&(x, y, spread)| SeriesPoint { x, y, spread }).collect();
    Series { label: "a < b".into(), colour: "#000000", dashes: "", width: 2.0, points, dot: None }
}

#[test]
fn a_plot_has_room_for_what_it_shows() {
    let all = [series(&[(1.0, 5.0, Some([4.0, 7.0])), (2.0, f64::NAN, None)]), series(&[(1.0, 3.0, None)])];
    assert!((range_from_zero(&all, 1.0).1 - 7.42).abs() < 1e-9);
    assert_eq!(range_from_zero(&[], 1.0), (0.0, 1.06));
}

#[test]
fn lines_break_where_a_value_is_missing_and_names_are_escaped() {
    let spread = Some([0.25, 1.5]);
    let all = [series(&[(0.0, 1.0, None), (1.0, f64::NAN, spread), (2.0, 1.0, spread), (3.0, 2.0, None)])];
    let mut sheet = Sheet::new(300.0, "lines");
    let (range_x, range_y) = ((0.0, 3.0), (0.0, 2.0));
    let plot = Plot { title: "", label_x: "x", label_y: "y", range_x, range_y, has_dots: true, series: &all };
    sheet.plot(Area { x: 60.0, y: 20.0, width: 100.0, height: 100.0 }, &plot);
    assert_eq!(sheet.legend((10.0, 10.0), 50.0, &[all[0].clone(), all[0].clone()]), 50.0, "one under the other");
    let svg = sheet.finish(200.0);
    let path = svg.lines().find(|line| line.starts_with("<path")).expect("a line");
    assert!(path.contains("M60 70M126.667 70L160 20"), "{path}");
    assert_eq!(svg.matches("<circle").count(), 3);
    let bars: Vec<&str> = svg.lines().filter(|line| line.contains("stroke-opacity")).collect();
    let is_from_low_to_high = bars[0].contains(r#"y1="107.5""#) && bars[0].contains(r#"y2="45""#);
    assert!(bars.len() == 1 && is_from_low_to_high, "{bars:?}");
    assert!(svg.contains("a &lt; b") && !svg.contains("NaN"), "{svg}");
}
