// SPDX-License-Identifier: GPL-3.0-or-later
//! From the numbers of a tree to the program's geometry, and the normal there. Source: original; Embree's manual for what a normal
//! is. Space: normals are in the space of the geometry, as Embree has them, and of no certain length.
//! Proof: `tests/c/embree.c`.

use gnurt_accel::Hit;

use crate::objects::{Committed, Kind, Place, Surface, Tree};
use crate::transform::{self, Columns, IDENTITY};

/// A primitive of the program's.
#[derive(Debug)]
pub(crate) struct Located<'a> {
    pub(crate) surface: &'a Surface,
    /// Where the outermost instance is; `None` where there is none.
    pub(crate) place: Option<&'a Place>,
    /// Places of instances in it, if any.
    inner: Vec<&'a Place>,
}

impl Committed {
    /// What was hit; ids as the tree of this scene gives them.
    #[inline]
    pub(crate) fn locate(&self, geom_id: u32, inst_id: u32, leaf_id: u32) -> Located<'_> {
        let own = |place| Located { surface: &self.surfaces[geom_id as usize], place, inner: Vec::new() };
        match &self.tree {
            Tree::Object(_) => own(None),
            Tree::Scene(tree) => {
                let place = &self.places[inst_id as usize];
                match &place.shown {
                    None => own(None),
                    Some(shown) if matches!(shown.tree, Tree::Object(_)) => Located {
                        surface: &shown.surfaces[geom_id as usize],
                        place: Some(place),
                        inner: Vec::new(),
                    },
                    Some(_) => self.locate_inside(tree.instance_path(leaf_id).unwrap_or_default(), geom_id),
                }
            }
        }
    }

    /// Along the instances of instances.
    #[cold]
    fn locate_inside(&self, path: Vec<u32>, geom_id: u32) -> Located<'_> {
        let (mut scene, mut places) = (self, Vec::new());
        for inst_id in path {
            let place = &scene.places[inst_id as usize];
            let Some(shown) = &place.shown else { break };
            places.push(place);
            scene = shown;
        }
        let surface = &scene.surfaces[geom_id as usize];
        let mut places = places.into_iter();
        Located { surface, place: places.next(), inner: places.collect() }
    }
}

impl Located<'_> {
    /// The way out of all instances.
    pub(crate) fn world_from_object(&self) -> Columns {
        let outer = self.place.map_or(IDENTITY, |place| place.world_from_instance);
        self.inner.iter().fold(outer, |all, place| transform::after(&all, &place.world_from_instance))
    }

    /// The normal where a ray has hit, in the geometry's space; zeros of user geometry, which gives its own.
    #[inline]
    pub(crate) fn normal(&self, hit: &Hit, org: [f32; 3], dir: [f32; 3]) -> [f32; 3] {
        let Surface { kind, vertices, indices, .. } = self.surface;
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
                let at = match self.place {
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
