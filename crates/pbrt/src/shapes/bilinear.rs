// SPDX-License-Identifier: GPL-3.0-or-later
//! `bilinearmesh`: patches between four corners, in the order (0, 0), (1, 0), (0, 1), (1, 1). A parallelogram is two triangles;
//! any other patch is [`STEPS`] by [`STEPS`] cells. Source: [PJH23] 6.6. Tests: `tests/shapes.rs`.

use gnurt_scene::Mesh;
use gnurt_scene::io::Error;

use super::reading::Reading;
use super::triangles::{corners, per_vertex, positions};
use crate::parameter::Parameters;
use crate::transform::{cross, double, single, unit};

/// Cells along each side of a bent patch.
const STEPS: u32 = 8;

fn lerp<const N: usize>(corners: [[f64; N]; 4], u: f64, v: f64) -> [f64; N] {
    let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
    std::array::from_fn(|k| (0..4).map(|i| weights[i] * corners[i][k]).sum())
}

pub(super) fn mesh(parameters: &Parameters, reading: &Reading) -> Result<Mesh, Error> {
    let positions = positions(parameters, "bilinearmesh")?;
    let count = positions.len();
    let indices = match corners(parameters, "indices", 4, count)? {
        Some(indices) => indices,
        None if count == 4 => vec![0, 1, 2, 3],
        None => {
            let problem = "a bilinearmesh of other than four vertices has no \"integer indices\"";
            return Err(parameters.location.error(problem, "give four for each patch"));
        }
    };
    let normals = per_vertex(parameters, "N", parameters.triples("N"), count)?;
    let uvs = per_vertex(parameters, "uv", parameters.pairs("uv"), count)?;
    parameters.ints("faceIndices");
    let mut mesh = Mesh::default();
    for patch in indices.as_chunks::<4>().0 {
        let p = patch.map(|i| double(positions[i as usize]));
        let n = (!normals.is_empty()).then(|| patch.map(|i| double(normals[i as usize])));
        let uv = match uvs.is_empty() {
            true => [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
            false => patch.map(|i| uvs[i as usize].map(f64::from)),
        };
        let largest = p.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let bend = (0..3).map(|k| (p[0][k] - p[1][k] - p[2][k] + p[3][k]).abs()).fold(0.0, f64::max);
        let is_flat = bend <= 1e-6 * largest;
        let steps = if is_flat { 1 } else { STEPS };
        let bytes = ((steps + 1) * (steps + 1) * 32 + steps * steps * 24) as usize;
        reading.access.budget.hold(bytes).map_err(|e| parameters.location.excess(e))?;
        patch_cells(&mut mesh, (p, n, uv), steps);
        reading.access.budget.release(bytes);
    }
    Ok(mesh)
}

type Patch = ([[f64; 3]; 4], Option<[[f64; 3]; 4]>, [[f64; 2]; 4]);

fn patch_cells(mesh: &mut Mesh, (p, n, uv): Patch, steps: u32) {
    let first = mesh.positions.len() as u32;
    let part = |i: u32| f64::from(i) / f64::from(steps);
    for (j, i) in (0..=steps).flat_map(|j| (0..=steps).map(move |i| (j, i))) {
        let (u, v) = (part(i), part(j));
        mesh.positions.push(single(lerp(p, u, v)));
        mesh.texcoords.push(lerp(uv, u, v).map(|x| x as f32));
        let along = |a: usize, b: usize, c: usize, d: usize, t: f64| {
            [0, 1, 2].map(|k| (1.0 - t) * (p[b][k] - p[a][k]) + t * (p[d][k] - p[c][k]))
        };
        let own = cross(along(0, 1, 2, 3, v), along(0, 2, 1, 3, u));
        let normal = n.map_or(own, |n| lerp(n, u, v));
        mesh.normals.push(single(unit(normal).unwrap_or([0.0; 3])));
    }
    let corner = |i: u32, j: u32| first + j * (steps + 1) + i;
    for (j, i) in (0..steps).flat_map(|j| (0..steps).map(move |i| (j, i))) {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        mesh.indices.push([a, b, c]);
        mesh.indices.push([a, c, d]);
    }
}
