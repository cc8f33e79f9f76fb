// SPDX-License-Identifier: GPL-3.0-or-later
//! The part of the Python package `gnurt` that is compiled: ray queries on numpy arrays, pictures, and the program.
//! See docs/reference/python.md. Tests: `bindings/python/tests`.

mod answers;
mod arrays;
mod described_mesh;
mod described_strands;
mod describing;
mod displacements;
mod double_answers;
mod double_trees;
mod ffi_arrays;
mod frames;
mod geometries;
mod given;
mod hashes;
mod hits;
mod lights;
mod materials;
mod media;
mod moments;
mod pickled;
mod picture;
mod pixels;
mod polygons;
mod pool;
mod program;
mod ray_scene;
mod rays;
mod rendering;
mod retained;
mod scene;
mod scripts;
mod shade;
mod soups;
mod stage;
mod textures;
mod trees;
mod watch;

use pyo3::prelude::*;

/// The contents of `import gnurt`.
#[pymodule]
fn _gnurt(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(program::program, module)?)?;
    module.add_function(wrap_pyfunction!(media::_read_volume, module)?)?;
    module.add_function(wrap_pyfunction!(polygons::_divide_polygons, module)?)?;
    module.add_function(wrap_pyfunction!(hashes::_hash_array, module)?)?;
    module.add_class::<hits::Hits>()?;
    module.add_class::<hits::AllHits>()?;
    module.add_class::<picture::Picture>()?;
    module.add_class::<rendering::Growing>()?;
    module.add_class::<frames::Frames>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<ray_scene::RayScene>()
}
