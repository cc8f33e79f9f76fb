// SPDX-License-Identifier: GPL-3.0-or-later
//! `Volume`: grids of files of OpenVDB and NanoVDB as smoke, and the volume shaders of MaterialX that say how it scatters.
//! Source: UsdVol; MaterialX, Physically Based Shading Nodes (`volume`, `anisotropic_vdf`, `absorption_vdf`).
//! Without such a shader the field `density` is the scattering per unit of the stage, and nothing is absorbed.
//! Space: coefficients are per metre. Tests: `tests/volumes.rs`.

use std::sync::Arc;

use gnurt_image::Grid;
use gnurt_scene::Medium;
use gnurt_scene::io::Oddity;
use gnurt_scene::medium::{Extent, Phase};
use gnurt_scene::volume_cells::{decode_volume, density_grid, grid_named};
use openusd::sdf::{Path, Value};

use crate::builder::{Builder, State};
use crate::network::Source;
use crate::reader::Reader;
use crate::value;

/// Outputs of materials that shade volumes.
const OUTPUTS: [&str; 2] = ["outputs:volume", "outputs:mtlx:volume"];

impl Builder<'_> {
    /// Adds the smoke of a prim.
    pub(crate) fn volume(&mut self, prim: &Path, state: &State) {
        let reader = self.reader;
        if self.is_prototype {
            reader.unsupported(prim, "volume that a point instancer repeats");
            return;
        }
        let Some(field) = density_field(reader, prim) else { return };
        let look = self.bound(prim).and_then(|material| medium_of(reader, &material));
        let medium = match grid(reader, &field) {
            Ok(mut grid) => {
                grid.world_from_unit = state.world_from_parent * grid.world_from_unit;
                let name = prim.as_str().to_owned();
                Medium {
                    name,
                    extent: Extent::Free,
                    grid: Some(Arc::new(grid)),
                    ..look.unwrap_or_else(white)
                }
            }
            Err(why) => {
                reader.note(Oddity::NotShown, &field, why);
                return;
            }
        };
        let unit = reader.metres_per_unit() as f32;
        let per_metre = |coefficients: [f32; 3]| coefficients.map(|x| x / unit);
        let (absorption, scattering) = (per_metre(medium.absorption), per_metre(medium.scattering));
        let medium = Medium { absorption, scattering, ..medium };
        match medium.problem() {
            Some(problem) => reader.unsupported(prim, problem),
            None => {
                self.scene.add_medium(medium);
            }
        }
    }
}

fn white() -> Medium {
    Medium { scattering: [1.0; 3], ..Medium::default() }
}

/// The prim of the field that is shown: `density`, or the only one.
fn density_field(reader: &Reader, prim: &Path) -> Option<Path> {
    let names = reader.properties(prim);
    let fields: Vec<&str> = names.iter().filter_map(|name| name.strip_prefix("field:")).collect();
    let shown = match fields[..] {
        [] => {
            reader.unsupported(prim, "Volume without fields");
            return None;
        }
        [one] => one,
        _ if fields.contains(&"density") => "density",
        _ => {
            let detail = format!("Volume without a field 'density', but {}", fields.join(", "));
            reader.unsupported(prim, detail);
            return None;
        }
    };
    for other in fields.iter().filter(|name| **name != shown) {
        reader.unsupported(prim, format_args!("field '{other}'"));
    }
    let target = reader.targets(prim, &format!("field:{shown}")).into_iter().next();
    if target.is_none() {
        reader.unsupported(prim, format_args!("field '{shown}', which names no prim"));
    }
    target
}

/// The cells of a prim of the type OpenVDBAsset; an error in words.
fn grid(reader: &Reader, field: &Path) -> Result<gnurt_scene::medium::DensityGrid, String> {
    let kind = reader.kind(field);
    if kind != "OpenVDBAsset" {
        return Err(format!("field of the type '{kind}'; OpenVDBAsset is shown"));
    }
    let Some(Value::AssetPath(asset)) = reader.value(field, "filePath") else {
        return Err("OpenVDBAsset without a filePath".into());
    };
    let file = reader.file_of(&asset);
    let budget = &reader.files.access.budget;
    let bytes = reader.files.bytes(&file)?;
    let bad = |why: String| format!("{}: {why}", asset.as_str());
    let volume = decode_volume(&bytes, budget).map_err(bad)?;
    let name = reader.word(field, "fieldName").filter(|name| !name.is_empty());
    let number = reader.value(field, "fieldIndex").as_ref().and_then(value::number).unwrap_or(0.0);
    let is_named = |grid: &&Grid| name.as_deref().is_none_or(|name| grid.name() == name);
    let grid = match volume.grids().iter().filter(is_named).nth(number as usize) {
        Some(grid) => grid,
        None => grid_named(&volume, name.as_deref().unwrap_or_default()).map_err(bad)?,
    };
    density_grid(grid, None, None, Some(budget)).map_err(bad)
}

/// The coefficients that a material gives its volume, per unit of the stage; `None` without a volume shader that is read.
fn medium_of(reader: &Reader, material: &Path) -> Option<Medium> {
    let shader = |prim: &Path, name: &str| match reader.source(prim, name) {
        Some(Source::Shader { prim, .. }) => Some(prim),
        _ => None,
    };
    let volume = OUTPUTS.iter().find_map(|output| shader(material, output))?;
    let id = reader.shader_id(&volume);
    if id != "ND_volume_volumeshader" {
        reader.unsupported(&volume, format_args!("volume by '{id}', shown white"));
        return None;
    }
    if shader(&volume, "inputs:edf").is_some() {
        reader.unsupported(&volume, "emission of a volume");
    }
    let Some(vdf) = shader(&volume, "inputs:vdf") else {
        reader.unsupported(&volume, "volume without a vdf, shown white");
        return None;
    };
    let known = ["absorption", "scattering", "anisotropy"];
    for name in known.iter().filter(|name| shader(&vdf, &format!("inputs:{name}")).is_some()) {
        reader.unsupported(&vdf, format_args!("network on '{name}'"));
    }
    let vector = |name: &str| reader.input_vector(&vdf, name).unwrap_or([0.0; 3]);
    match &reader.shader_id(&vdf)[..] {
        "ND_absorption_vdf" => Some(Medium { absorption: vector("absorption"), ..Medium::default() }),
        "ND_anisotropic_vdf" => {
            let anisotropy = reader.input_number(&vdf, "anisotropy").unwrap_or(0.0) as f32;
            let phase = Phase { anisotropy, ..Phase::default() };
            Some(Medium {
                absorption: vector("absorption"),
                scattering: vector("scattering"),
                phase,
                ..Medium::default()
            })
        }
        id => {
            reader.unsupported(&vdf, format_args!("vdf by '{id}', shown white"));
            None
        }
    }
}
