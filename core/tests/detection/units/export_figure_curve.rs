//! Tests of `export::figure::curve`.
#![allow(unused_imports)]

use burstscope_core::export::sheet::*;
use burstscope_core::export::*;

#[test]
fn the_mark_follows_the_curve_and_all_lies_on_the_sheet() {
    let (size, unit) = ([200.0, 100.0], FigureUnit::Pixel);
    let blank = Drawing { size, unit, shapes: Vec::new(), title: String::new() };
    let centre = |marked: usize| {
        let points = vec![[-1.0, 0.0], [0.0, f32::NAN], [1.0, 3.0]];
        let curve = FigureCurve { points, marked, title: "D".into(), label_x: "slope".into(), ticks_x: Vec::new() };
        let mut drawing = blank.clone();
        draw_curve(&mut drawing, &curve, 10.0);
        assert_eq!(drawing.size, [200.0, 100.0 + curve_height(10.0)]);
        let is_inside = |[x, y]: [f32; 2]| (0.0..=200.0).contains(&x) && (100.0..=drawing.size[1]).contains(&y);
        drawing.shapes.iter().find_map(|shape| match shape {
            FigureShape::Circle { centre, .. } => Some(*centre).filter(|at| is_inside(*at)),
            _ => None,
        })
    };
    let (first, last) = (centre(0).expect("drawn"), centre(2).expect("drawn"));
    assert!(last[0] > first[0] && last[1] < first[1], "to the right and up: {first:?} {last:?}");
    assert_eq!((centre(1), centre(9)), (None, None), "there is nothing to mark");
}
