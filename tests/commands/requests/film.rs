//! Tests of films by what is drawn in their pictures.

use super::{detected, open, params};
use crate::support::*;
use burstscope::detector::Detection;
use burstscope::export::{Drawing, FigureShape};
use burstscope::requests::{Film, Sweep};
use std::sync::Arc;

#[test]
fn sweeps_are_read_as_they_are_typed_and_a_step_shows_its_numbers() {
    assert_eq!("slope-u=-3:3:7".parse(), Ok(Sweep::SlopeU(-3.0, 3.0, 7)));
    for bad in ["", "slope-u", "slope-u=1:2", "slope-u=a:b:c", "slope-u=0:inf:3", "flip=1:2:3", "slope-u=0:1:0"] {
        assert!(bad.parse::<Sweep>().is_err_and(|why| why.contains("give")), "{bad}");
    }
    assert!("slope-v=0:1:9999".parse::<Sweep>().is_err_and(|why| why.contains("give 1 to 1000")));
    let (burst, params, found) = (open(), params(), detected().detection);
    let (sweep, slope) = (Sweep::SlopeU(-1.0, 1.0, 3), Slope::default());
    let film = Film { burst, params, sweep, slope, detection: Some(found.clone()), max_side_px: 48 };
    // Titles are broken to the width of the picture.
    says(texts_of(&film).join(" "), &["slope −1 px/frame: ", "slope 1 px/frame: ", "% of full scale"]);
    let crowded = Detection { features: vec![found.features[0]; 100], ..Detection::clone(&found) };
    let slope = found.features[0].motion().0;
    let film = Film { sweep: Sweep::SlopeU(slope.u, slope.u, 1), slope, detection: Some(Arc::new(crowded)), ..film };
    says(texts_of(&film).join(" "), &[": 2 of 100 features"]);
}

/// Writes the film, and returns what `of` says of each drawing, in any order.
fn of_pictures<T: Send>(film: &Film, of: impl Fn(&Drawing) -> T + Sync) -> Vec<T> {
    let said = Mutex::new(Vec::new());
    let draw = |drawing: &Drawing| {
        said.lock().expect("kept").push(of(drawing));
        Ok(image::RgbaImage::new(drawing.size[0] as u32, drawing.size[1] as u32))
    };
    let folder = folder();
    film.write(&folder.join("film.gif"), 10, &draw, &|| Ok(()), &Monitor::default()).expect("written");
    said.into_inner().expect("kept")
}

#[test]
fn every_sweep_has_its_steps_in_pictures_of_one_size() {
    let film = |sweep: &str| {
        let (burst, params, sweep) = (open(), DetectorParams::default(), sweep.parse().expect("a sweep"));
        Film { burst, params, sweep, slope: Slope::default(), detection: None, max_side_px: 48 }
    };
    // Three octaves of five levels.
    for (text, count) in [("slope-u=-2:2:5", 5), ("slope-v=0:1:2", 2), ("frames", 4), ("scale", 15)] {
        let film = film(text);
        let drawn = of_pictures(&film, |drawing| (drawing.size.map(|x| x as u32), format!("{:?}", drawing.shapes)));
        assert_eq!(drawn.len(), count, "{text}");
        assert!(drawn.iter().all(|(size, _)| *size == <[u32; 2]>::from(film.size())), "{text}");
        assert_eq!(drawn.iter().map(|(_, shapes)| shapes).collect::<BTreeSet<_>>().len(), count, "{text}");
        let draw = |drawing: &Drawing| Ok(image::RgbaImage::new(drawing.size[0] as u32, drawing.size[1] as u32));
        let [first, _] = film.samples(&draw, &Monitor::default()).expect("made");
        assert_eq!(first.dimensions(), film.size(), "{text}");
    }
    let slopes: Vec<f32> = film("slope-u=-2:2:5").steps().iter().map(|step| step.slope.u).collect();
    assert_eq!(slopes, [-2.0, -1.0, 0.0, 1.0, 2.0]);
}

fn texts_of(film: &Film) -> Vec<String> {
    let text = |shape: &FigureShape| match shape {
        FigureShape::Text { text, .. } => Some(text.clone()),
        _ => None,
    };
    of_pictures(film, |drawing| drawing.shapes.iter().filter_map(text).collect::<Vec<_>>()).concat()
}
