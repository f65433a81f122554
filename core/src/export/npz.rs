//! Features and descriptors as numpy's `.npz`: `features` `[N, 16]` float32 in the CSV's columns, `descriptors` `[N,
//! 128]` uint8 in UBC order.

use super::atomic::write_marked;
use crate::detector::{Descriptor, Feature, Quantity};
use crate::error::Error;
use crate::files::mark::Kind;
use ndarray::ArrayView2;
use ndarray_npy::NpzWriter;
use std::io;
use std::path::Path;

/// Writes features and descriptors, one for each feature (it panics if the numbers differ); also without any.
pub fn write_npz(path: &Path, features: &[Feature], descriptors: &[Descriptor]) -> Result<(), Error> {
    assert_eq!(features.len(), descriptors.len(), "each feature has one descriptor");
    let values = |f| Quantity::STORED.into_iter().filter_map(move |quantity| quantity.of(f));
    let rows: Vec<f32> = features.iter().flat_map(values).collect();
    let count = features.len();
    let rows = ArrayView2::from_shape((count, Quantity::STORED.len()), &rows).expect("one row for each");
    let descriptors = ArrayView2::from_shape((count, 128), descriptors.as_flattened()).expect("128 bytes each");
    write_marked(path, Kind::Features, |out| {
        let mut npz = NpzWriter::new(out);
        npz.add_array("features", &rows).map_err(io::Error::other)?;
        npz.add_array("descriptors", &descriptors).map_err(io::Error::other)?;
        npz.finish().map_err(io::Error::other)?;
        Ok(())
    })
}
