// SPDX-License-Identifier: GPL-3.0-or-later
//! From the numbers of a tree to the program's geometry, and the normal there. Normals are defined by
//! Embree's manual. Space: normals are in the space of the geometry, as Embree has them, and of no certain
//! length.
//! Tests: `tests/c/embree.c`.

use gnurt_accel::Hit;

use crate::ffi_present::present;
use crate::objects::{Committed, Kind, Shown, ShownInstance, Surface, Tree};
use crate::transform::{self, Columns, IDENTITY};

/// A primitive of the program's.
#[derive(Debug)]
pub(crate) struct Located<'a> {
    pub(crate) surface: &'a Surface,
    /// The same as its scene was last committed, for arrays of before may be gone; `None` where it is no longer there.
    arrays: Option<&'a Surface>,
    /// Where the outermost instance is; `None` where there is none.
    pub(crate) shown_instance: Option<&'a ShownInstance>,
    /// The instances that contain it, if any.
    inner: Vec<&'a ShownInstance>,
}

impl Committed {
    /// The hit geometry; ids as the tree of this scene returns them.
    #[inline]
    pub(crate) fn locate(&self, geom_id: u32, inst_id: u32, leaf_id: u32) -> Located<'_> {
        let own = |shown_instance| {
            let surface = &self.surfaces[geom_id as usize];
            Located { surface, arrays: Some(surface), shown_instance, inner: Vec::new() }
        };
        match &self.tree {
            Tree::Object(_) => own(None),
            Tree::Scene(tree) => {
                let shown_instance = &self.shown_instances[inst_id as usize];
                match &shown_instance.shown {
                    None => own(None),
                    Some(shown) if matches!(shown.committed.tree, Tree::Object(_)) => {
                        let surface = &shown.committed.surfaces[geom_id as usize];
                        let arrays = as_it_is_now(shown, surface);
                        Located { surface, arrays, shown_instance: Some(shown_instance), inner: Vec::new() }
                    }
                    Some(_) => self.locate_inside(tree.instance_path(leaf_id).unwrap_or_default(), geom_id),
                }
            }
        }
    }

    /// Along the instances of instances.
    #[cold]
    fn locate_inside(&self, path: Vec<u32>, geom_id: u32) -> Located<'_> {
        let (mut scene, mut last, mut shown_instances) = (self, None, Vec::new());
        for inst_id in path {
            let shown_instance = &scene.shown_instances[inst_id as usize];
            let Some(shown) = &shown_instance.shown else { break };
            shown_instances.push(shown_instance);
            (scene, last) = (&shown.committed, Some(shown));
        }
        let surface = &scene.surfaces[geom_id as usize];
        let arrays = last.map_or(Some(surface), |shown| as_it_is_now(shown, surface));
        let mut shown_instances = shown_instances.into_iter();
        Located { surface, arrays, shown_instance: shown_instances.next(), inner: shown_instances.collect() }
    }
}

/// A surface of a scene that is shown, as that was last committed.
#[inline]
fn as_it_is_now<'a>(shown: &'a Shown, surface: &'a Surface) -> Option<&'a Surface> {
    let now = present(&shown.scene)?;
    if std::ptr::eq(now, &raw const *shown.committed) {
        return Some(surface);
    }
    now.surfaces.iter().find(|other| other.geom_id == surface.geom_id && other.kind == surface.kind)
}

impl Located<'_> {
    /// The map from the object to the world, out of all instances.
    pub(crate) fn world_from_object(&self) -> Columns {
        let outer = self.shown_instance.map_or(IDENTITY, |shown_instance| shown_instance.world_from_instance);
        self.inner
            .iter()
            .fold(outer, |all, shown_instance| transform::after(&all, &shown_instance.world_from_instance))
    }

    /// The normal at a ray's hit, in the geometry's space; zeros for user geometry, which returns its own,
    /// and for removed geometry.
    #[inline]
    pub(crate) fn normal(&self, hit: &Hit, org: [f32; 3], dir: [f32; 3]) -> [f32; 3] {
        let Some(Surface { kind, vertices, indices, .. }) = self.arrays else { return [0.0; 3] };
        let prim_id = hit.prim_id as usize;
        let corner = |i: u32| vertices.get::<f32, 3>(i as usize).unwrap_or_default();
        match kind {
            // One by one: arrays' `map` is not inlined, which took a quarter of a call.
            Kind::Triangles => {
                let [a, b, c] = indices.get::<u32, 3>(prim_id).unwrap_or_default();
                across(corner(a), corner(b), corner(c))
            }
            Kind::Quads => {
                let [a, b, c, d] = indices.get::<u32, 4>(prim_id).unwrap_or_default();
                let (first, second) = ([a, b, d], [c, d, b]);
                let [a, b, c] = if hit.u + hit.v <= 1.0 { first } else { second };
                across(corner(a), corner(b), corner(c))
            }
            Kind::Spheres => {
                let [x, y, z, _] = vertices.get::<f32, 4>(prim_id).unwrap_or_default();
                let at = [0, 1, 2].map(|k| f64::from(org[k]) + f64::from(hit.t) * f64::from(dir[k]));
                let at = match self.shown_instance {
                    None => at,
                    Some(_) => transform::point(&transform::inverse(&self.world_from_object()), at),
                };
                [0, 1, 2].map(|k| (at[k] - f64::from([x, y, z][k])) as f32)
            }
            Kind::Lines => {
                let [first] = indices.get::<u32, 1>(prim_id).unwrap_or_default();
                let [a, b] = [first, first.wrapping_add(1)].map(corner);
                [0, 1, 2].map(|k| b[k] - a[k])
            }
            Kind::User | Kind::Instance | Kind::Instances => [0.0; 3],
        }
    }
}

#[inline]
fn across(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let p = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let q = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}
