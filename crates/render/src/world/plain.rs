// SPDX-License-Identifier: GPL-3.0-or-later
//! Shading normals and base colours of what lanes hit, where nothing else is asked for and no texture is in the way: what most
//! frames of a moving camera are made of.
//! Source: as `surface`, of which this is the part that such looks need: no place, no sides, no batch of points.
//! Space: world. Invariant: normals and colours are those of `surface` and `SurfaceShader::albedo`, bit for bit.
//! Proof: crates/render/tests/plain.rs.

use glam::Vec3;
use gnurt_accel::INVALID_ID;
use gnurt_scene::Mesh;
use gnurt_shading::materials::PlainColor;

use super::surface::{geometric_normal, mix3, vertex_color};
use super::{HitLanes, PlacedInstance, World};

/// What the lanes of one mesh have in common.
struct Placed<'w> {
    /// Instance and geometry, as hits name them.
    ids: [u32; 2],
    instance: &'w PlacedInstance,
    mesh: &'w Mesh,
    look: Option<PlainColor>,
    /// The triangle that was hit last.
    facet: Option<Facet>,
}

/// What the lanes of one triangle have in common.
#[derive(Clone, Copy)]
struct Facet {
    prim_id: u32,
    corners: [usize; 3],
    normal: Normal,
}

#[derive(Clone, Copy)]
enum Normal {
    /// Unit, world space.
    Flat(Vec3),
    /// Unit, at the corners, object space.
    Smooth([Vec3; 3]),
}

impl World {
    /// Calls `with(lane, base colour, shading normal)` for lanes whose base colour is plain; the normal is not flipped. Writes the
    /// others that hit something into `others`, as [`sort_by_material`](Self::sort_by_material) does.
    pub(crate) fn plain_looks(
        &self,
        from: HitLanes,
        others: &mut Vec<u64>,
        mut with: impl FnMut(usize, Vec3, Vec3),
    ) {
        others.clear();
        let hits = from.hits;
        let mut last: Option<Placed> = None;
        let ids = hits.prim_id.iter().zip(&hits.inst_id).zip(&hits.geom_id);
        let places = ids.zip(hits.u.iter().zip(&hits.v));
        for (lane, (((&prim_id, &inst_id), &geom_id), (&u, &v))) in places.enumerate() {
            if prim_id == INVALID_ID {
                continue;
            }
            // Neighbours often hit the same mesh, and the same triangle of it.
            let ids = [inst_id, geom_id];
            let placed = match &mut last {
                Some(placed) if placed.ids == ids => placed,
                _ => last.insert(self.placed(ids)),
            };
            let mesh = placed.mesh;
            let Some(look) = placed.look else {
                others.push(u64::from(mesh.material.0) << 32 | lane as u64);
                continue;
            };
            let facet = match placed.facet {
                Some(facet) if facet.prim_id == prim_id => facet,
                _ => *placed.facet.insert(self.facet(placed.instance, mesh, prim_id)),
            };
            let weights = [1.0 - u - v, u, v];
            let normal = match facet.normal {
                Normal::Flat(normal) => normal,
                Normal::Smooth(normals) => {
                    let mixed = (placed.instance.normals * mix3(&normals, weights)).try_normalize();
                    mixed.unwrap_or_else(|| flat_normal(placed.instance, mesh, facet.corners))
                }
            };
            let color = if look.tinted && !mesh.colors.is_empty() {
                let [r, g, b, _] = vertex_color(mesh, facet.corners, weights);
                look.factor * Vec3::new(r, g, b)
            } else {
                look.factor
            };
            with(lane, color, normal);
        }
        others.sort_unstable();
    }

    fn placed(&self, ids: [u32; 2]) -> Placed<'_> {
        let [inst_id, geom_id] = ids;
        let instance = self.instance(inst_id);
        let mesh = &*instance.object.meshes[geom_id as usize];
        Placed { ids, instance, mesh, look: self.material(mesh.material.index()).plain, facet: None }
    }

    #[inline]
    fn facet(&self, instance: &PlacedInstance, mesh: &Mesh, prim_id: u32) -> Facet {
        let corners = mesh.indices[prim_id as usize].map(|i| i as usize);
        let normal = match self.vertex_normals(mesh, corners) {
            Some(normals) => Normal::Smooth(normals),
            None => Normal::Flat(flat_normal(instance, mesh, corners)),
        };
        Facet { prim_id, corners, normal }
    }
}

fn flat_normal(instance: &PlacedInstance, mesh: &Mesh, corners: [usize; 3]) -> Vec3 {
    geometric_normal(instance, &corners.map(|i| Vec3::from(mesh.positions[i])))
}
