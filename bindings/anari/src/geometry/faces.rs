// SPDX-License-Identifier: GPL-3.0-or-later
//! Triangles and quadrilaterals; these become two triangles each, along the diagonal of their first corner.
//! Primitives that name a vertex that is not there get no area, so that others keep their numbers. Tests: tests/attributes.rs.

use gnurt::scene::Mesh;

use super::data::{Geometry, Part, Primitives, Vertices};
use super::rates::{Rates, list};
use crate::ffi_array::Array;
use crate::object::Snapshot;
use crate::types;

/// Rows of so many vertices: those of the index array, or the vertices one after the other. And how many of them were wrong,
/// which name the first vertex alone, so that they have no extent.
pub(super) fn indices<const N: usize>(
    now: &Snapshot,
    vertices: usize,
) -> Result<(Vec<[u32; N]>, usize), String> {
    let (rows, wrong) = valid_indices(now, vertices)?;
    Ok((rows.into_iter().map(|row| row.unwrap_or([0; N])).collect(), wrong))
}

/// Rows of an index, `None` for wrong ones.
type Checked<const N: usize> = Vec<Option<[u32; N]>>;

/// The same with `None` for wrong ones.
pub(super) fn valid_indices<const N: usize>(
    now: &Snapshot,
    vertices: usize,
) -> Result<(Checked<N>, usize), String> {
    let mut wrong = 0;
    let Some(array) = now.object("primitive.index", types::ARRAY1D).and_then(|array| Array::of(array)) else {
        let count = u32::try_from(vertices).map_err(|_| format!("{vertices} vertices: too many"))?;
        return Ok((
            (0..count / N as u32).map(|i| Some(std::array::from_fn(|k| i * N as u32 + k as u32))).collect(),
            0,
        ));
    };
    let rows = array.indices::<N>().ok_or_else(|| {
        format!("parameter 'primitive.index': elements of type {}: invalid", types::name(array.element))
    })?;
    let row = |row: [u64; N]| {
        if row.iter().all(|&vertex| vertex < vertices as u64) {
            return Some(row.map(|vertex| vertex as u32));
        }
        wrong += 1;
        None
    };
    Ok((rows.into_iter().map(row).collect(), wrong))
}

/// The vertices.
pub(super) fn positions(now: &Snapshot) -> Result<Vec<[f32; 3]>, String> {
    let array = now.object("vertex.position", types::ARRAY1D).and_then(|array| Array::of(array));
    let array = array.ok_or("parameter 'vertex.position': missing")?;
    let element = types::name(array.element);
    array.rows().ok_or_else(|| format!("parameter 'vertex.position': elements of type {element}: invalid"))
}

/// The warning about primitives with vertices out of range; `None` where there are none.
pub(super) fn reported(wrong: usize, all: usize) -> Option<String> {
    (wrong > 0).then(|| {
        format!(
            "parameter 'primitive.index': {wrong} of {all} primitives: vertex out of range; they are left out"
        )
    })
}

fn three(values: Vec<[f32; 4]>) -> Vec<[f32; 3]> {
    values.into_iter().map(|[x, y, z, _]| [x, y, z]).collect()
}

/// Triangles (`N` = 3) or quadrilaterals (4).
pub(super) fn faces<const N: usize>(now: &Snapshot) -> Result<(Geometry, Option<String>), String> {
    let positions = positions(now)?;
    let (rows, wrong) = indices::<N>(now, positions.len())?;
    let warning = reported(wrong, rows.len());
    // Corners of the primitives' triangles.
    let corners: &[[usize; 3]] = if N == 3 { &[[0, 1, 2]] } else { &[[0, 1, 2], [0, 2, 3]] };
    let primitives = if N == 3 { Primitives::Own } else { Primitives::Pairs };
    let [normals, tangents] = ["normal", "tangent"]
        .map(|name| [list(now, &format!("faceVarying.{name}")), list(now, &format!("vertex.{name}"))]);
    let mut mesh = Mesh::default();
    let by_corner = !normals[0].is_empty() || !tangents[0].is_empty();
    let vertices = if by_corner {
        // Each corner becomes a vertex of its own.
        let of_row: Vec<u32> = rows.iter().flatten().copied().collect();
        mesh.positions = of_row.iter().map(|&vertex| positions[vertex as usize]).collect();
        let pick = |[own, shared]: [Vec<[f32; 4]>; 2]| {
            let missing = own.is_empty() && shared.is_empty();
            let value = |(corner, &vertex): (usize, &u32)| {
                let shared = || shared.get(vertex as usize).copied().unwrap_or_default();
                if own.is_empty() { shared() } else { own.get(corner).copied().unwrap_or_default() }
            };
            if missing { Vec::new() } else { of_row.iter().enumerate().map(value).collect() }
        };
        mesh.normals = three(pick(normals));
        mesh.tangents = sided(pick(tangents));
        let row = |i: usize| corners.iter().map(move |c| c.map(|corner| (i * N + corner) as u32));
        mesh.indices = (0..rows.len()).flat_map(row).collect();
        Vertices::Listed(of_row)
    } else {
        let fit = |mut values: Vec<[f32; 4]>| {
            // Fewer than vertices: zero, which is none.
            if !values.is_empty() {
                values.resize(positions.len(), [0.0; 4]);
            }
            values
        };
        let ([_, normals], [_, tangents]) = (normals, tangents);
        mesh.normals = three(fit(normals));
        mesh.tangents = sided(fit(tangents));
        mesh.positions = positions;
        mesh.indices =
            rows.iter().flat_map(|row| corners.iter().map(|c| c.map(|corner| row[corner]))).collect();
        Vertices::Own
    };
    let parts = vec![Part::once(mesh, primitives, vertices)];
    Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points: Vec::new() }, warning))
}

/// The fourth number of a tangent is a side: of three numbers it is 1 already.
fn sided(tangents: Vec<[f32; 4]>) -> Vec<[f32; 4]> {
    tangents.into_iter().map(|[x, y, z, side]| [x, y, z, if side < 0.0 { -1.0 } else { 1.0 }]).collect()
}
