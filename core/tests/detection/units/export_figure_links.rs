//! Tests of `export::figure::links`.
#![allow(unused_imports)]

use burstscope_core::export::*;
use serde::{Deserialize, Serialize};

#[test]
fn lines_go_from_place_to_place_and_what_is_out_of_sight_is_left_out() {
    let rows = vec![vec![FigurePanel { origin_image: [9.5, -0.5], ..panel((20, 10)) }; 2]];
    let options = FigureOptions { width: FigureWidth::PxPerPx(2.0), ..FigureOptions::default() };
    let (panels, ends_image) = ([0, 1], [[9.5, -0.5], [29.5, 9.5]]);
    let link = FigureLink { panels, ends_image, color: [1; 3], opacity: 1.0, weight: 1.0, dashed: false };
    let drawn = |links: &[FigureLink]| {
        let matches = FigureMatches { links: links.to_vec(), legend: Vec::new() };
        let (plain, with) =
            (lay_out(&rows, &FigureMatches::default(), &options), lay_out(&rows, &matches, &options));
        let rects: Vec<FigureRect> = pictures(&with.shapes).collect();
        (rects, with.shapes[plain.shapes.len()..].to_vec())
    };
    let (rects, shapes) = drawn(&[link]);
    let [FigureShape::Line { points, .. }, FigureShape::Circle { .. }, FigureShape::Circle { .. }] = &shapes[..]
    else {
        panic!("a line and its ends: {shapes:?}");
    };
    let corner = [rects[1].min[0] + rects[1].size[0], rects[1].min[1] + rects[1].size[1]];
    assert_eq!(points.as_slice(), [rects[0].min, corner]);
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

