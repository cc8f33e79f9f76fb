// SPDX-License-Identifier: GPL-3.0-or-later
//! `trianglemesh` and `plymesh`. A mesh without texture coordinates has those that pbrt makes up for each triangle:
//! (0, 0), (1, 0), (1, 1), if the caller requests them. Tests: `tests/shapes.rs`, `tests/broken.rs`.

use gnurt_scene::io::Error;
use gnurt_scene::io::reader::{read_ply_mesh, read_ply_mesh_from, resolve};
use gnurt_scene::{Attribute, Mesh, Rate};

use super::reading::Reading;
use crate::parameter::{Kind, Parameters};
use crate::sources::{is_packed, unpack};

/// Triples of corners of `count` vertices.
pub(super) fn corners(
    parameters: &Parameters,
    name: &str,
    per_face: usize,
    count: usize,
) -> Result<Option<Vec<u32>>, Error> {
    let Some(indices) = parameters.ints(name) else { return Ok(None) };
    let wrong = |problem: String, remedy: String| {
        let found = parameters.find(name, &[Kind::Integer]);
        found.map_or_else(
            || parameters.location.error(&problem, &remedy),
            |parameter| parameter.error(&problem, &remedy),
        )
    };
    if indices.len() % per_face != 0 {
        let problem = format!("has {} values, not a multiple of {per_face}", indices.len());
        return Err(wrong(problem, format!("give {per_face} for each face")));
    }
    if let Some(bad) = indices.iter().find(|&&i| usize::try_from(i).map_or(true, |i| i >= count)) {
        let problem = format!("has the vertex {bad}, and there are {count}");
        return Err(wrong(problem, format!("vertices are numbered from 0 to {}", count.saturating_sub(1))));
    }
    Ok(Some(indices.iter().map(|&i| i as u32).collect()))
}

/// An attribute for each vertex, or none.
pub(super) fn per_vertex<T: Copy>(
    parameters: &Parameters,
    name: &str,
    given: Option<&[T]>,
    count: usize,
) -> Result<Vec<T>, Error> {
    match given {
        Some(values) if values.len() != count => {
            let problem = format!("\"{name}\" has {} values, and there are {count} vertices", values.len());
            Err(parameters.location.error(problem, "give one for each vertex"))
        }
        Some(values) => Ok(values.to_vec()),
        None => Ok(Vec::new()),
    }
}

/// The vertices of a shape.
pub(super) fn positions<'a>(parameters: &'a Parameters, class: &str) -> Result<&'a [[f32; 3]], Error> {
    parameters.triples("P").ok_or_else(|| {
        parameters
            .location
            .error(format!("a {class} has no \"point3 P\""), "give its vertices: \"point3 P\" [ ... ]")
    })
}

fn uvs(parameters: &Parameters) -> Option<&[[f32; 2]]> {
    if let Some(pairs) = parameters.pairs("uv") {
        return Some(pairs);
    }
    let floats = parameters.floats("uv").or_else(|| parameters.floats("st"))?;
    Some(floats.as_chunks().0)
}

pub(super) fn mesh(parameters: &Parameters, reading: &Reading) -> Result<Mesh, Error> {
    let positions = positions(parameters, "trianglemesh")?.to_vec();
    let count = positions.len();
    let indices = match corners(parameters, "indices", 3, count)? {
        Some(indices) => indices,
        None if count == 3 => vec![0, 1, 2],
        None => {
            let problem = "a trianglemesh of more than three vertices has no \"integer indices\"";
            return Err(parameters.location.error(problem, "give three for each triangle"));
        }
    };
    let mut mesh = Mesh {
        texcoords: per_vertex(parameters, "uv", uvs(parameters), count)?,
        normals: per_vertex(parameters, "N", parameters.triples("N"), count)?,
        indices: indices.as_chunks().0.to_vec(),
        positions,
        ..Mesh::default()
    };
    parameters.triples("S");
    parameters.ints("faceIndices");
    make_up_texcoords(&mut mesh, parameters, reading)?;
    Ok(mesh)
}

pub(super) fn ply(parameters: &Parameters, reading: &mut Reading) -> Result<Mesh, Error> {
    let location = &parameters.location;
    let name = parameters
        .text("filename")?
        .ok_or_else(|| location.error("a plymesh has no \"string filename\"", "name the file of its mesh"))?;
    let path = resolve(&location.path, name);
    let (access, warnings) = (reading.access, &mut *reading.warnings);
    let before = access.budget.held();
    let mut mesh = if is_packed(&path) {
        let packed = access.read(&path, u64::MAX)?;
        let bytes = unpack(&packed, &path, access)?;
        read_ply_mesh_from(&bytes, &path, access, warnings)?
    } else {
        read_ply_mesh(&path, access, warnings)?
    };
    // The caller counts the bytes of the mesh.
    access.budget.settle(before);
    // pbrt reads no colours.
    mesh.colors.clear();
    make_up_texcoords(&mut mesh, parameters, reading)?;
    Ok(mesh)
}

fn make_up_texcoords(mesh: &mut Mesh, parameters: &Parameters, reading: &Reading) -> Result<(), Error> {
    if !mesh.texcoords.is_empty() || !reading.wants_texcoords {
        return Ok(());
    }
    let corners = mesh.indices.len() * 3;
    let bytes = corners * size_of::<[f32; 8]>();
    reading.access.budget.hold(bytes).map_err(|e| parameters.location.excess(e))?;
    let each = |list: &[[f32; 3]]| -> Vec<[f32; 3]> {
        mesh.indices.iter().flatten().map(|&i| list[i as usize]).collect()
    };
    let positions = each(&mesh.positions);
    let normals = if mesh.normals.is_empty() { Vec::new() } else { each(&mesh.normals) };
    mesh.attributes.retain(|attribute: &Attribute| attribute.rate == Rate::Triangle);
    mesh.texcoords = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]].repeat(mesh.indices.len());
    mesh.indices = (0..mesh.indices.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (mesh.positions, mesh.normals) = (positions, normals);
    reading.access.budget.release(bytes);
    Ok(())
}
