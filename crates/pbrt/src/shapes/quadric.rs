// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres, disks and cylinders, whole or in part, as grids.
//! Source: [PJH23] chapter 6; texture coordinates as there. Vertices lie on the surface; normals are exact.
//! A whole turn has [`COLUMNS`] cells. Tests: `tests/shapes.rs`.

use std::f64::consts::{PI, TAU};

use gnurt_scene::io::Error;
use gnurt_scene::{Mesh, Primitives};

use super::grid::grid;
use crate::parameter::Parameters;

/// Cells of a whole turn, and of half a turn from pole to pole.
const COLUMNS: f64 = 128.0;

fn positive(parameters: &Parameters, name: &str, default: f32) -> Result<f64, Error> {
    let given = parameters.float_or(name, default)?;
    if given > 0.0 && given.is_finite() {
        return Ok(f64::from(given));
    }
    Err(parameters.location.error(format!("\"{name}\" is {given}"), "it must be above 0"))
}

/// The angle of a part of a turn, radians.
fn turn(parameters: &Parameters) -> Result<f64, Error> {
    Ok(f64::from(parameters.float_or("phimax", 360.0)?).clamp(0.0, 360.0).to_radians())
}

/// Cells for a part of `whole`.
fn cells(part: f64, whole: f64, count: f64) -> u32 {
    (count * part / whole).ceil().clamp(1.0, 2.0 * count) as u32
}

/// Leaves out triangles that are a line, at poles and middles.
fn without_lines(mut mesh: Mesh) -> Mesh {
    let positions = &mesh.positions;
    mesh.indices.retain(|&triangle| gnurt_scene::has_area(triangle.map(|i| positions[i as usize])));
    mesh
}

/// Around z: longitude by u from +x to +y, latitude by v upwards. One of radius 1, its radius, and the part that it is.
/// `exact`: a whole one may be without triangles.
pub(super) fn sphere(parameters: &Parameters, exact: bool) -> Result<(Mesh, f64, String), Error> {
    let radius = positive(parameters, "radius", 1.0)?;
    let ends = [parameters.float_or("zmin", -radius as f32)?, parameters.float_or("zmax", radius as f32)?];
    let [a, b] = ends.map(|z| (f64::from(z) / radius).clamp(-1.0, 1.0));
    let [from, to] = [a.min(b), a.max(b)].map(f64::acos);
    let phi = turn(parameters)?;
    if exact && from - to == PI && phi == TAU {
        let mesh =
            Mesh { positions: vec![[0.0; 3]], primitives: Primitives::Spheres(vec![1.0]), ..Mesh::default() };
        return Ok((mesh, radius, "exact sphere".to_owned()));
    }
    let at = |u: f64, v: f64| {
        let ((sin_phi, cos_phi), (sin, cos)) = ((u * phi).sin_cos(), (from + v * (to - from)).sin_cos());
        // Poles are one point.
        let sin = if sin < 1e-9 { 0.0 } else { sin };
        let normal = [sin * cos_phi, sin * sin_phi, cos];
        (normal, normal)
    };
    let mesh = without_lines(grid(cells(phi, TAU, COLUMNS), cells(from - to, PI, COLUMNS / 2.0), at));
    Ok((mesh, radius, format!("sphere {from} {to} {phi}")))
}

/// Square to z, seen from above.
pub(super) fn disk(parameters: &Parameters) -> Result<Mesh, Error> {
    let radius = positive(parameters, "radius", 1.0)?;
    let height = f64::from(parameters.float_or("height", 0.0)?);
    let inner = f64::from(parameters.float_or("innerradius", 0.0)?).clamp(0.0, radius);
    let phi = turn(parameters)?;
    let columns = cells(phi, TAU, COLUMNS);
    // The polygon's area is the disk's.
    let step = phi / f64::from(columns);
    let wider = if step > 0.0 { (step / step.sin()).sqrt() } else { 1.0 };
    let at = |u: f64, v: f64| {
        let (sin, cos) = (u * phi).sin_cos();
        let r = (radius + v * (inner - radius)) * wider;
        ([r * cos, r * sin, height], [0.0, 0.0, 1.0])
    };
    Ok(without_lines(grid(columns, 1, at)))
}

/// Around z.
pub(super) fn cylinder(parameters: &Parameters) -> Result<Mesh, Error> {
    let radius = positive(parameters, "radius", 1.0)?;
    let ends = [parameters.float_or("zmin", -1.0)?, parameters.float_or("zmax", 1.0)?].map(f64::from);
    let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    let phi = turn(parameters)?;
    let at = |u: f64, v: f64| {
        let (sin, cos) = (u * phi).sin_cos();
        ([radius * cos, radius * sin, low + v * (high - low)], [cos, sin, 0.0])
    };
    Ok(without_lines(grid(cells(phi, TAU, COLUMNS), 1, at)))
}
