//! Burstscope as a module of Python: what the package `burstscope` beside this crate is built on. The module is
//! private; the package gives it names, types and documentation.

mod burst;
mod commands;
mod detection;
mod failure;
mod inspection;
mod keywords;
mod lent;
mod matching;
mod parameters;
mod pictures;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _burstscope(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("REVISION", burstscope::detector::feature::REVISION)?;
    module.add("DECODE_WORKER", burstscope::cli::DECODE_WORKER)?;
    module.add_class::<burst::RawBurst>()?;
    module.add_class::<detection::RawDetection>()?;
    module.add_class::<matching::RawMatches>()?;
    module.add_class::<inspection::RawInspection>()?;
    module.add_function(wrap_pyfunction!(burst::check_size, module)?)?;
    module.add_function(wrap_pyfunction!(detection::detect, module)?)?;
    module.add_function(wrap_pyfunction!(detection::step_picture, module)?)?;
    module.add_function(wrap_pyfunction!(detection::motion_field, module)?)?;
    module.add_function(wrap_pyfunction!(matching::match_features, module)?)?;
    module.add_function(wrap_pyfunction!(matching::export_colmap, module)?)?;
    module.add_function(wrap_pyfunction!(inspection::inspect, module)?)?;
    module.add_function(wrap_pyfunction!(pictures::colour_maps, module)?)?;
    module.add_function(wrap_pyfunction!(pictures::encode_picture, module)?)?;
    module.add_function(wrap_pyfunction!(commands::install_decode_worker, module)?)?;
    module.add_function(wrap_pyfunction!(commands::run_command, module)?)?;
    module.add_function(wrap_pyfunction!(commands::synthesise, module)?)?;
    module.add_function(wrap_pyfunction!(commands::write_case, module)?)?;
    module.add_function(wrap_pyfunction!(keywords::keywords_source, module)?)?;
    Ok(())
}
