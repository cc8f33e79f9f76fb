// SPDX-License-Identifier: GPL-3.0-or-later
//! Displacement at commit: the meshes of an object with their vertices moved.
//! An object's meshes are cut as its materials require, their vertices are grouped by position, and each group moves by the
//! mean of its offsets. Normals are then those of the moved triangles; hard edges stay hard, and meshes without normals stay
//! flat. Meshes at keys of an open shutter move by the same amounts along their own normals.
//! Space: object. Invariant: vertices at one position stay at one position; meshes that do not move keep their bits.
//! Tests: crates/render/tests/displacement.rs.

mod offsets;
mod places;
mod refine;

use std::sync::Arc;

use glam::Vec3;
use gnurt_scene::displacement::{Displacement, Offset, Refinement};
use gnurt_scene::{Mesh, Scene};
use gnurt_shading::DisplacementShader;

use crate::world::textures::sharp;
use offsets::{Source, offsets};
use places::{Places, face_sums, own_normals};
use refine::Cut;

/// Vertices of an object that may be displaced, after refinement: about 2 GiB while they move.
pub(crate) const MOST_VERTICES: usize = 1 << 24;

/// Passes of refinement: edges become shorter by half in each.
const MOST_PASSES: u8 = 24;

/// The meshes of an object, and those at keys of the open shutter.
pub(crate) struct Meshes {
    pub(crate) meshes: Vec<Arc<Mesh>>,
    /// By mesh; empty for static ones.
    pub(crate) keys: Vec<Vec<Arc<Mesh>>>,
}

/// Moves the vertices of an object's meshes. `shaders` are those of the shader table, `most` is the number of vertices that it may
/// have. Each line of `warnings` names a mesh.
pub(crate) fn displace(
    scene: &Scene,
    shaders: &[Arc<dyn DisplacementShader>],
    most: usize,
    object: &mut Meshes,
    warnings: &mut Vec<String>,
) {
    let given = |mesh: &Arc<Mesh>| scene.displacement(mesh.material);
    if !object.meshes.iter().any(|mesh| given(mesh).is_some()) {
        return;
    }
    for mesh in object.meshes.iter().filter(|mesh| !mesh.has_triangles() && given(mesh).is_some()) {
        let name = &mesh.name;
        warnings.push(format!("mesh '{name}': displacement of curves and spheres is unsupported, left out"));
    }
    // Other primitives stay out of all that follows.
    let chosen: Vec<usize> = (0..object.meshes.len())
        .filter(|&i| object.meshes[i].has_triangles() && is_sound(&object.meshes[i]))
        .collect();
    let moved: Vec<Option<Displacement>> =
        chosen.iter().map(|&i| given(&object.meshes[i]).copied()).collect();
    let Some(of_first) = moved.iter().position(Option::is_some) else { return };
    let name = object.meshes[chosen[of_first]].name.clone();
    let vertices: usize = chosen.iter().map(|&i| object.meshes[i].positions.len()).sum();
    if vertices > most {
        warnings.push(format!(
            "mesh '{name}': not displaced: {vertices} vertices are more than the {most} that an object may displace"
        ));
        return;
    }
    for pass in passes(moved.iter().flatten().map(|displacement| displacement.refinement)) {
        if !refine(object, &chosen, pass, most, &name, warnings) {
            break;
        }
    }
    let flat: Vec<Arc<Mesh>> = chosen.iter().map(|&i| object.meshes[i].clone()).collect();
    let places = Places::of(&flat);
    let old: Vec<Vec3> = flat.iter().flat_map(|mesh| own_normals(mesh)).collect();
    let directions = places.directions(&old);
    let shared = shared_offsets(scene, shaders, &flat, &moved, &places, &directions, warnings);
    let shift = Shift { places: &places, directions: &directions, offsets: &shared };
    let keys = chosen.iter().map(|&i| object.keys.get(i).map_or(0, Vec::len)).max().unwrap_or(0);
    for key in 0..keys {
        let at_key: Vec<Arc<Mesh>> = chosen
            .iter()
            .zip(&flat)
            .map(|(&i, mesh)| {
                let keys = &object.keys[i];
                let at = keys.get(key).or(keys.last()).unwrap_or(mesh);
                if at.positions.len() == mesh.positions.len() { at.clone() } else { mesh.clone() }
            })
            .collect();
        for ((&i, mesh), at_key) in chosen.iter().zip(shift.at_key(&at_key)).zip(&at_key) {
            if let Some(slot) = object.keys[i].get_mut(key)
                && slot.positions.len() == at_key.positions.len()
            {
                *slot = mesh;
            }
        }
    }
    for (&i, mesh) in chosen.iter().zip(shift.opening(&flat)) {
        object.meshes[i] = mesh;
    }
}

/// Whether its triangles have vertices, and its arrays are full or empty.
fn is_sound(mesh: &Mesh) -> bool {
    let count = mesh.positions.len();
    let fits = |n: usize| n == 0 || n == count;
    fits(mesh.normals.len())
        && fits(mesh.texcoords.len())
        && fits(mesh.tangents.len())
        && fits(mesh.colors.len())
        && mesh.indices.iter().flatten().all(|&i| (i as usize) < count)
}

/// The passes of refinement for an object with these materials: the longest edge that stays in each, `None` = none does.
fn passes(all: impl Iterator<Item = Refinement>) -> Vec<Option<f32>> {
    let (mut levels, mut longest) = (0, f32::INFINITY);
    for refinement in all {
        match refinement {
            Refinement::Levels(n) => levels = levels.max(n.min(MOST_PASSES)),
            Refinement::Edges(length) if length > 0.0 => longest = longest.min(length),
            Refinement::None | Refinement::Edges(_) => {}
        }
    }
    let mut passes = vec![None; levels.into()];
    if longest.is_finite() {
        passes.extend(std::iter::repeat_n(Some(longest), (MOST_PASSES - levels).into()));
    }
    passes
}

/// One pass of refinement; false if there is nothing to cut, or no room.
fn refine(
    object: &mut Meshes,
    chosen: &[usize],
    longest: Option<f32>,
    most: usize,
    name: &str,
    warnings: &mut Vec<String>,
) -> bool {
    let vertices: usize = chosen.iter().map(|&i| object.meshes[i].positions.len()).sum();
    let room = most - vertices.min(most);
    let cuts: Option<Vec<Cut>> = chosen.iter().map(|&i| Cut::of(&object.meshes[i], longest, room)).collect();
    let cuts = cuts.filter(|cuts| cuts.iter().map(Cut::len).sum::<usize>() <= room);
    let Some(cuts) = cuts else {
        warnings.push(format!(
            "mesh '{name}': refinement for displacement ends at {vertices} vertices: an object may displace {most}"
        ));
        return false;
    };
    for (&i, cut) in chosen.iter().zip(&cuts).filter(|(_, cut)| cut.len() > 0) {
        let before = object.meshes[i].positions.len();
        let mesh = Arc::make_mut(&mut object.meshes[i]);
        cut.grow(mesh);
        cut.cut(mesh, before);
        let indices = mesh.indices.clone();
        for key in &mut object.keys[i] {
            if key.positions.len() == before && is_sound(key) {
                let key = Arc::make_mut(key);
                cut.grow(key);
                key.indices.clone_from(&indices);
            }
        }
    }
    cuts.iter().any(|cut| cut.len() > 0)
}

/// The offset of each vertex: the mean of those at its position that are displaced.
fn shared_offsets(
    scene: &Scene,
    shaders: &[Arc<dyn DisplacementShader>],
    meshes: &[Arc<Mesh>],
    moved: &[Option<Displacement>],
    places: &Places,
    directions: &[Vec3],
    warnings: &mut Vec<String>,
) -> Vec<Vec3> {
    // No number = none is given.
    let mut given = vec![Vec3::NAN; places.vertices()];
    for (i, (mesh, displacement)) in meshes.iter().zip(moved).enumerate() {
        let Some(displacement) = displacement else { continue };
        let source = match displacement.offset {
            Offset::Constant(x) => Source::Constant(x),
            Offset::Height { texture, channel } => {
                Source::Height(sharp(scene, &texture), usize::from(channel.min(3)))
            }
            Offset::Vector { texture, space } => Source::Vector(sharp(scene, &texture), space),
            Offset::Shader(number) => match shaders.get(number as usize) {
                Some(shader) => Source::Shader(shader.clone()),
                None => continue,
            },
        };
        let range = places.of_mesh(i);
        let found = offsets(mesh, i as u32, displacement, &source, &directions[range.clone()]);
        let bad = found.iter().filter(|offset| !offset.is_finite()).count();
        if bad > 0 {
            let name = &mesh.name;
            warnings.push(format!("mesh '{name}': {bad} vertices with infinite displacement stay in place"));
        }
        given[range].copy_from_slice(&found);
        if let Source::Shader(shader) = source {
            for fault in
                shader.faults().into_iter().filter(|fault| !warnings.contains(fault)).collect::<Vec<_>>()
            {
                warnings.push(fault);
            }
        }
    }
    let mut shared = vec![Vec3::ZERO; given.len()];
    for place in places.iter() {
        let offsets = place.iter().map(|&i| given[i as usize]).filter(|offset| offset.is_finite());
        let (sum, count) = offsets.fold((Vec3::ZERO, 0.0_f32), |(sum, count), x| (sum + x, count + 1.0));
        if count > 0.0 {
            place.iter().for_each(|&i| shared[i as usize] = sum / count);
        }
    }
    shared
}

/// Vertices and their ways.
struct Shift<'a> {
    places: &'a Places,
    directions: &'a [Vec3],
    offsets: &'a [Vec3],
}

impl Shift<'_> {
    /// The meshes, moved.
    fn opening(&self, meshes: &[Arc<Mesh>]) -> Vec<Arc<Mesh>> {
        self.moved(meshes, |i, p| p + self.offsets[i])
    }

    /// The same at another time: by as much along the normals then, and sideways.
    fn at_key(&self, meshes: &[Arc<Mesh>]) -> Vec<Arc<Mesh>> {
        let own: Vec<Vec3> = meshes.iter().flat_map(|mesh| own_normals(mesh)).collect();
        let directions = self.places.directions(&own);
        self.moved(meshes, |i, p| {
            let height = self.offsets[i].dot(self.directions[i]);
            let aside = self.offsets[i] - self.directions[i] * height;
            p + directions[i] * height + aside
        })
    }

    fn moved(&self, meshes: &[Arc<Mesh>], to: impl Fn(usize, Vec3) -> Vec3) -> Vec<Arc<Mesh>> {
        let mut made: Vec<Arc<Mesh>> = meshes.to_vec();
        let count = self.places.vertices();
        let mut touched = vec![false; count];
        let (mut old, mut faces, mut now) =
            (vec![Vec3::ZERO; count], vec![Vec3::ZERO; count], vec![Vec3::ZERO; count]);
        for (k, mesh) in made.iter_mut().enumerate() {
            let range = self.places.of_mesh(k);
            let has_normals = !mesh.normals.is_empty();
            if has_normals {
                let sums = face_sums(&mesh.positions, &mesh.indices);
                old[range.clone()].copy_from_slice(&own_normals(mesh));
                faces[range.clone()].copy_from_slice(&sums);
                now[range.clone()].copy_from_slice(&sums);
            }
            if range.clone().all(|i| self.offsets[i] == Vec3::ZERO) {
                continue;
            }
            let mesh = Arc::make_mut(mesh);
            for (i, p) in range.clone().zip(&mut mesh.positions) {
                if self.offsets[i] != Vec3::ZERO {
                    *p = to(i, Vec3::from(*p)).to_array();
                }
            }
            for corners in &mesh.indices {
                let corners = corners.map(|i| range.start + i as usize);
                if corners.iter().any(|&i| self.offsets[i] != Vec3::ZERO) {
                    corners.iter().for_each(|&i| touched[i] = true);
                }
            }
            if has_normals {
                now[range].copy_from_slice(&face_sums(&mesh.positions, &mesh.indices));
            }
        }
        let normals = self.places.smoothed(&old, &faces, &now, &touched);
        for (k, mesh) in made.iter_mut().enumerate() {
            let range = self.places.of_mesh(k);
            let is_same = |i: usize| normals[i] == old[i];
            if mesh.normals.is_empty() || range.clone().all(is_same) {
                continue;
            }
            let mesh = Arc::make_mut(mesh);
            for (i, v) in range.zip(0..) {
                if normals[i] == old[i] {
                    continue;
                }
                mesh.normals[v] = normals[i].to_array();
                if let Some([x, y, z, _]) = mesh.tangents.get_mut(v) {
                    let tangent = Vec3::new(*x, *y, *z);
                    let along = tangent - normals[i] * normals[i].dot(tangent);
                    if tangent != Vec3::ZERO {
                        [*x, *y, *z] = along.normalize_or_zero().to_array();
                    }
                }
            }
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_for_vertices_is_limited() {
        let mut scene = Scene::new();
        let material = scene.add_material(gnurt_scene::Material::matte("", [0.5; 3]));
        let mesh = Mesh {
            name: "leaf".into(),
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            indices: vec![[0, 1, 2]],
            material,
            ..Mesh::default()
        };
        let displaced = |refinement: Refinement, most: usize| {
            let mut scene = scene.clone();
            let displacement = Displacement { refinement, ..Displacement::new(Offset::Constant(1.0)) };
            scene.set_displacement(material, Some(displacement));
            let mut object = Meshes { meshes: vec![Arc::new(mesh.clone())], keys: vec![Vec::new()] };
            let mut warnings = Vec::new();
            displace(&scene, &[], most, &mut object, &mut warnings);
            (object.meshes[0].positions.len(), object.meshes[0].positions[0][2], warnings)
        };
        assert_eq!(displaced(Refinement::Levels(2), 15), (15, 1.0, Vec::new()), "as many as there may be");
        let (vertices, height, warnings) = displaced(Refinement::Levels(20), 15);
        assert_eq!((vertices, height), (15, 1.0), "it ends at the last pass that fits");
        let expected =
            "mesh 'leaf': refinement for displacement ends at 15 vertices: an object may displace 15";
        assert_eq!(warnings, [expected]);
        let (vertices, _, warnings) = displaced(Refinement::Edges(1e-30), 1000);
        assert!(vertices <= 1000 && warnings.len() == 1, "{vertices}: {warnings:?}");
        let (vertices, height, warnings) = displaced(Refinement::None, 2);
        assert_eq!((vertices, height), (3, 0.0), "too many at first: none is moved");
        assert!(warnings[0].contains("'leaf'") && warnings[0].contains("more than the 2"), "{warnings:?}");
    }
}
