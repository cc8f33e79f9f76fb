// SPDX-License-Identifier: GPL-3.0-or-later
//! Media of the type `nanovdb`: densities and temperatures from a file.
//! Source: the section Media of the file-format page. Files of OpenVDB are read as well. Tests: tests/volumes.rs.

use gnurt_scene::Affine;
use gnurt_scene::io::Error;
use gnurt_scene::io::reader::{Access, quoted, resolve};
use gnurt_scene::medium::DensityGrid;
use gnurt_scene::volume_cells::{Heat, MOST_VOLUME_BYTES, decode_volume, density_grid, grid_named};

use crate::parameter::Parameters;
use crate::spectrum::radiance_of_black_body;

/// Kelvins up to which nothing shines.
const COLD: f32 = 100.0;

/// The grid of a medium in the space of the file; it has emission if the file has the grid `temperature`.
pub(crate) fn grid(
    parameters: &Parameters,
    file_from_medium: &Affine,
    access: &Access,
) -> Result<DensityGrid, Error> {
    let location = &parameters.location;
    let name = parameters.text("filename")?.ok_or_else(|| {
        location.error("a nanovdb medium has no \"string filename\"", "name the file of its grids")
    })?;
    let brightness = parameters.float_or("Lescale", 1.0)?;
    let offset = parameters.float_or("temperaturecutoff", 0.0)?;
    let offset = parameters.float_or("temperatureoffset", offset)?;
    let scale = parameters.float_or("temperaturescale", 1.0)?;
    let before = access.budget.held();
    let bytes = access.read(&resolve(&location.path, name), MOST_VOLUME_BYTES as u64)?;
    let bad = |why: String| {
        location.error(format!("the volume {}: {why}", quoted(name)), "name a file of NanoVDB or OpenVDB")
    };
    let volume = decode_volume(&bytes, &access.budget).map_err(bad)?;
    drop(bytes);
    access.budget.settle(before);
    let density = grid_named(&volume, "density").map_err(bad)?;
    let temperature = volume.grid("temperature").filter(|_| brightness > 0.0);
    let emission = |number: f32| {
        let kelvin = (number - offset) * scale;
        if kelvin > COLD { radiance_of_black_body(kelvin).map(|c| c * brightness) } else { [0.0; 3] }
    };
    let heat = temperature.map(|grid| Heat { grid, emission: &emission });
    let mut made = density_grid(density, None, heat.as_ref(), Some(&access.budget)).map_err(bad)?;
    made.world_from_unit = *file_from_medium * made.world_from_unit;
    Ok(made)
}
