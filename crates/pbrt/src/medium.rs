// SPDX-License-Identifier: GPL-3.0-or-later
//! `MakeNamedMedium`: even media, uniform grids and those of files; the measured ones by name; the insides of `subsurface`.
//! Source: the section Media of the file-format page; measured media after [JMLH01].
//! A grid is a box: outside of it nothing is. Where its numbers end it fades out over half a cell, as pbrt's
//! lookup does: it is stored with a rim of zeros. Tests: tests/media.rs.

use std::sync::Arc;

use gnurt_scene::Affine;
use gnurt_scene::io::reader::{Access, quoted};
use gnurt_scene::io::{Error, Oddity, Warnings};
use gnurt_scene::medium::{DensityGrid, Medium, Phase, single_albedo};

use crate::parameter::Parameters;
use crate::spectrum::Spectrum;
use crate::volume_medium;

/// Name; scattering (reduced) and absorption coefficients, 1 over millimetres.
type Measured = (&'static str, [f32; 3], [f32; 3]);

const MEASURED: [Measured; 12] = [
    ("Apple", [2.29, 2.39, 1.97], [0.003, 0.0034, 0.046]),
    ("Chicken1", [0.15, 0.21, 0.38], [0.015, 0.077, 0.19]),
    ("Chicken2", [0.19, 0.25, 0.32], [0.018, 0.088, 0.2]),
    ("Cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163]),
    ("Ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    ("Marble", [2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071]),
    ("Potato", [0.68, 0.7, 0.55], [0.0024, 0.009, 0.12]),
    ("Skimmilk", [0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142]),
    ("Skin1", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    ("Skin2", [1.09, 1.59, 1.79], [0.013, 0.07, 0.145]),
    ("Spectralon", [11.6, 20.4, 14.9], [0.0, 0.0, 0.0]),
    ("Wholemilk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
];

/// What is meant without a name or numbers.
const MILK: ([f32; 3], [f32; 3]) = ([2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]);

/// Both coefficients: by a measured medium's name, by numbers, or the default.
fn coefficients(
    parameters: &Parameters,
    [by_name, scattering, absorption]: [&str; 3],
    default: ([f32; 3], [f32; 3]),
    access: &Access,
    warnings: &mut Warnings,
) -> Result<([f32; 3], [f32; 3]), Error> {
    let mut both = default;
    if let Some(name) = parameters.text(by_name)?.filter(|name| !name.is_empty()) {
        match MEASURED.iter().find(|(known, ..)| *known == name) {
            Some((_, scattering, absorption)) => both = (*scattering, *absorption),
            None => {
                let known: Vec<&str> = MEASURED.iter().map(|(known, ..)| *known).collect();
                let detail = format!("the measured medium {}; known are {}", quoted(name), known.join(", "));
                parameters.location.warn(warnings, Oddity::NotShown, detail);
            }
        }
    }
    let scale = parameters.float_or("scale", 1.0)?;
    let number = |name: &str| Ok(Spectrum::of(parameters, name, access)?.map(|it| it.value()));
    let both = (number(scattering)?.unwrap_or(both.0), number(absorption)?.unwrap_or(both.1));
    Ok((both.0.map(|s| s * scale), both.1.map(|s| s * scale)))
}

/// Radiance of a parameter; scaled as pbrt does it, light of unit luminance for spectra.
fn emission(parameters: &Parameters, access: &Access) -> Result<[f32; 3], Error> {
    Ok(Spectrum::of(parameters, "Le", access)?.map_or([0.0; 3], |spectrum| spectrum.light()))
}

/// A named medium, its grid in the space of the file; `None` (and a warning) for kinds that are not shown.
pub(crate) fn read(
    parameters: &Parameters,
    file_from_medium: &Affine,
    access: &Access,
    warnings: &mut Warnings,
) -> Result<Option<Medium>, Error> {
    let location = &parameters.location;
    let class = parameters.text("type")?.ok_or_else(|| {
        location.error("MakeNamedMedium has no \"string type\"", "give the medium's type: homogeneous, ...")
    })?;
    let phase = Phase { anisotropy: parameters.float_or("g", 0.0)?, ..Phase::default() };
    let names = ["preset", "sigma_s", "sigma_a"];
    let medium = match class {
        "homogeneous" => {
            let (scattering, absorption) = coefficients(parameters, names, MILK, access, warnings)?;
            let scale = parameters.float_or("Lescale", 1.0)?;
            let emission = emission(parameters, access)?.map(|e| e * scale);
            Medium { scattering, absorption, emission, phase, ..Medium::default() }
        }
        "uniformgrid" => {
            let default = ([1.0; 3], [1.0; 3]);
            let (scattering, absorption) = coefficients(parameters, names, default, access, warnings)?;
            let emission = emission(parameters, access)?;
            let grid = Some(Arc::new(grid(parameters, file_from_medium, access)?));
            Medium { scattering, absorption, emission, phase, grid, ..Medium::default() }
        }
        "nanovdb" => {
            let default = ([1.0; 3], [1.0; 3]);
            let (scattering, absorption) = coefficients(parameters, names, default, access, warnings)?;
            let grid = volume_medium::grid(parameters, file_from_medium, access)?;
            // Emission that the grid does not have is none.
            let emission = if grid.emission.is_empty() { [0.0; 3] } else { [1.0; 3] };
            Medium {
                scattering,
                absorption,
                emission,
                phase,
                grid: Some(Arc::new(grid)),
                ..Medium::default()
            }
        }
        "rgbgrid" | "cloud" => {
            parameters.ignore();
            let detail = format!("a medium of the type {}", quoted(class));
            location.warn(warnings, Oddity::NotShown, detail);
            return Ok(None);
        }
        other => {
            let problem = format!("unknown medium {}", quoted(other));
            return Err(
                location.error(problem, "valid are cloud, homogeneous, nanovdb, rgbgrid and uniformgrid")
            );
        }
    };
    match medium.problem() {
        Some(problem) => {
            Err(location.error(format!("the medium makes no sense: {problem}"), "mend its numbers"))
        }
        None => Ok(Some(medium)),
    }
}

fn grid(parameters: &Parameters, file_from_medium: &Affine, access: &Access) -> Result<DensityGrid, Error> {
    let location = &parameters.location;
    let mut inner = [0_u32; 3];
    for (count, name) in inner.iter_mut().zip(["nx", "ny", "nz"]) {
        let given = parameters.int(name)?.unwrap_or(1);
        *count = u32::try_from(given)
            .ok()
            .filter(|&n| (1..=1 << 14).contains(&n))
            .ok_or_else(|| location.error(format!("\"{name}\" of the grid is {given}"), "give 1 to 16384"))?;
    }
    let density = parameters.floats("density").unwrap_or_default();
    let cells = inner.iter().map(|&n| n as usize).product::<usize>();
    if density.len() != cells {
        let problem = format!("\"density\" has {} values for {cells} cells", density.len());
        return Err(location.error(problem, "nx * ny * nz must be the number of densities"));
    }
    let scales = parameters.floats("Lescale").unwrap_or_default();
    if !(scales.len() <= 1 || scales.len() == cells) {
        let problem = format!("\"Lescale\" has {} values for {cells} cells", scales.len());
        return Err(location.error(problem, "give one, or one for each cell"));
    }
    let (low, high) = (parameters.triple_or("p0", [0.0; 3])?, parameters.triple_or("p1", [1.0; 3])?);
    // A rim of zeros.
    let size = inner.map(|n| n + 2);
    let all = size.iter().map(|&n| n as usize).product::<usize>();
    access.budget.hold(all * if scales.is_empty() { 4 } else { 16 }).map_err(|e| location.excess(e))?;
    let mut grid = DensityGrid {
        size,
        density: vec![0.0; all],
        emission: if scales.is_empty() { Vec::new() } else { vec![[0.0; 3]; all] },
        world_from_unit: Affine::IDENTITY,
    };
    let [nx, ny, nz] = inner.map(|n| n as usize);
    for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
        let (from, to) = ((z * ny + y) * nx, ((z + 1) * (ny + 2) + y + 1) * (nx + 2) + 1);
        grid.density[to..to + nx].copy_from_slice(&density[from..from + nx]);
        if !scales.is_empty() {
            let scale = |i: usize| scales.get(from + i).copied().unwrap_or(scales[0]);
            (0..nx).for_each(|i| grid.emission[to + i] = [scale(i); 3]);
        }
    }
    let edge: [f64; 3] = std::array::from_fn(|k| f64::from(high[k]) - f64::from(low[k]));
    let cell: [f64; 3] = std::array::from_fn(|k| edge[k] / f64::from(inner[k]));
    let place = Affine::translation(std::array::from_fn(|k| f64::from(low[k]) - cell[k]))
        * Affine::scale(std::array::from_fn(|k| edge[k] + 2.0 * cell[k]));
    grid.world_from_unit = *file_from_medium * place;
    Ok(grid)
}

/// The inside of a material of the type `subsurface`.
pub(crate) fn subsurface(
    parameters: &Parameters,
    access: &Access,
    warnings: &mut Warnings,
) -> Result<Medium, Error> {
    let phase = Phase { anisotropy: parameters.float_or("g", 0.0)?, ..Phase::default() };
    let reflectance = Spectrum::of(parameters, "reflectance", access)?.map(|it| it.value());
    let (scattering, absorption) = match reflectance {
        Some(color) => {
            let scale = parameters.float_or("scale", 1.0)?;
            let free = Spectrum::of(parameters, "mfp", access)?.map_or([1.0; 3], |it| it.value());
            let extinction = free.map(|free| 1.0 / (free * scale).max(1e-9));
            let scattering: [f32; 3] =
                std::array::from_fn(|c| extinction[c] * single_albedo(color[c], phase.anisotropy));
            (scattering, std::array::from_fn(|c| extinction[c] - scattering[c]))
        }
        None => coefficients(parameters, ["name", "sigma_s", "sigma_a"], MILK, access, warnings)?,
    };
    let medium = Medium { scattering, absorption, phase, ..Medium::default() };
    match medium.problem() {
        Some(problem) => Err(parameters.location.error(problem, "mend the numbers of the material")),
        None => Ok(medium),
    }
}
