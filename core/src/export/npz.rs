//! Features with their descriptors, and fields of motion, as numpy's `.npz`. Features: `features` `[N, 17]` float32 in
//! the CSV's columns, `descriptors` `[N, 128]` uint8 in UBC order. For empty cells of the CSV, `field_u` and `field_v`
//! are NaN, `field_sigma` infinite, `layer` 0. `motion` is 0 unknown, 1 surroundings, 2 own, 3 edge, 4 ghost.

use super::{atomic::write_marked, csv::FeatureVerdict};
use crate::detector::{Descriptor, Feature, Motion, MotionField, Quantity};
use crate::{error::Result, files::mark::OutputKind};
use ndarray::{Array1, Array2, Array3, ArrayView2};
use ndarray_npy::NpzWriter;
use std::{io, path::Path};

/// Writes a field of motion, a value for each cell of `cell_px`² pixels: `motion` `[rows, columns, 2]` float32 to the
/// right and down and `covariance` `[rows, columns, 3]` (of u, of u with v, of v), pixels per frame; `known` and
/// `layer` `[rows, columns]` uint8; `layers` `[n, 4]` float32, the motions of the layers, their spreads and shares.
pub fn write_field_npz(path: &Path, field: &MotionField) -> Result<()> {
    let (columns, rows) = field.size;
    let floats = |last: usize, of: &dyn Fn(&Motion) -> Vec<f32>| {
        let values = field.motions.iter().flat_map(of).collect();
        Array3::from_shape_vec((rows, columns, last), values).expect("a value for each cell")
    };
    let bytes = |values: Vec<u8>| Array2::from_shape_vec((rows, columns), values).expect("a value for each cell");
    let layers = field.layers.iter().flat_map(|layer| [layer.slope.u, layer.slope.v, layer.spread, layer.share]);
    let layers = Array2::from_shape_vec((field.layers.len(), 4), layers.collect()).expect("four numbers a layer");
    // The motion of a cell may be uncertain along an edge: readers must be able to leave it out.
    let known = field.motions.iter().map(|motion| u8::from(field.is_known(motion))).collect();
    write_marked(path, OutputKind::Features, |out| {
        let mut npz = NpzWriter::new(out);
        let motion = floats(2, &|motion| vec![motion.slope.u, motion.slope.v]);
        npz.add_array("motion", &motion).map_err(io::Error::other)?;
        npz.add_array("covariance", &floats(3, &|motion| motion.covariance.to_vec())).map_err(io::Error::other)?;
        npz.add_array("known", &bytes(known)).map_err(io::Error::other)?;
        npz.add_array("layer", &bytes(field.layer.clone())).map_err(io::Error::other)?;
        npz.add_array("layers", &layers).map_err(io::Error::other)?;
        npz.add_array("cell_px", &ndarray::arr0(field.cell_px as f32)).map_err(io::Error::other)?;
        npz.finish().map(drop).map_err(io::Error::other)
    })
}

/// Writes features and descriptors, one for each feature (it panics if the numbers differ); also without any. Where
/// features were judged, `verdict` `[N]` uint8, 0 real, 1 ghost, 2 alias, 3 duplicate, 4 unclear, and `coherence` `[N]`
/// float32, NaN where frames are too noisy to be compared.
pub fn write_npz(
    path: &Path,
    features: &[Feature],
    descriptors: &[Descriptor],
    verdicts: Option<&[FeatureVerdict]>,
) -> Result<()> {
    assert_eq!(features.len(), descriptors.len(), "each feature has one descriptor");
    let values = |f| Quantity::STORED.into_iter().filter_map(move |quantity| quantity.of(f));
    let rows: Vec<f32> = features.iter().flat_map(values).collect();
    let count = features.len();
    let rows = ArrayView2::from_shape((count, Quantity::STORED.len()), &rows).expect("one row for each");
    let descriptors = ArrayView2::from_shape((count, 128), descriptors.as_flattened()).expect("128 bytes each");
    write_marked(path, OutputKind::Features, |out| {
        let mut npz = NpzWriter::new(out);
        npz.add_array("features", &rows).map_err(io::Error::other)?;
        npz.add_array("descriptors", &descriptors).map_err(io::Error::other)?;
        if let Some(verdicts) = verdicts {
            let codes = Array1::from_iter(verdicts.iter().map(|verdict| verdict.code));
            let coherences = Array1::from_iter(verdicts.iter().map(|verdict| verdict.coherence.unwrap_or(f32::NAN)));
            npz.add_array("verdict", &codes).map_err(io::Error::other)?;
            npz.add_array("coherence", &coherences).map_err(io::Error::other)?;
        }
        npz.finish().map(drop).map_err(io::Error::other)
    })
}
