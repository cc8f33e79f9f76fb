// SPDX-License-Identifier: GPL-3.0-or-later
//! From the numbers of a tree to the program's geometry, and the normal there. Normals are defined by
//! Embree's manual. Space: normals are in the space of the geometry, as Embree has them, and of no certain
//! length.
//! Tests: `tests/c/embree.c`.

use gnurt_accel::{CurveBasis, CurveForm, Curves, Hit, Ray};

use crate::cones::Cone;
use crate::ffi_memory::View;
use crate::ffi_present::present;
use crate::objects::{Committed, Kind, Shown, ShownInstance, StepArrays, Surface, Tree};
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
    /// Whether the arrays are those that the tree was built from: no later commit of a scene that is shown has others.
    #[inline]
    pub(crate) fn is_as_built(&self) -> bool {
        self.arrays.is_some_and(|arrays| std::ptr::eq(arrays, self.surface))
    }

    /// The map from the object to the world at a time, out of all instances.
    pub(crate) fn world_from_object(&self, time: f32) -> Columns {
        let outer = self.shown_instance.map_or(IDENTITY, |shown_instance| shown_instance.at(time));
        self.inner.iter().fold(outer, |all, shown_instance| transform::after(&all, &shown_instance.at(time)))
    }

    /// The point of a hit, in the geometry's space.
    fn point(&self, hit: &Hit, ray: &Ray) -> [f64; 3] {
        let at = [0, 1, 2].map(|k| f64::from(ray.org[k]) + f64::from(hit.t) * f64::from(ray.dir[k]));
        match self.shown_instance {
            None => at,
            Some(_) => transform::point(&transform::inverse(&self.world_from_object(ray.time)), at),
        }
    }

    /// The normal of a curve's hit; of ribbons that face rays the derivative along the curve, as by Embree.
    fn normal_of_curve(&self, basis: CurveBasis, form: CurveForm, hit: &Hit, ray: &Ray) -> Option<[f32; 3]> {
        let surface = self.arrays?;
        let [first] = surface.indices.get::<u32, 1>(hit.prim_id as usize)?;
        fn some<const N: usize>(
            surface: &Surface,
            of: fn(&StepArrays) -> &View,
            first: u32,
            time: f32,
        ) -> Vec<[f32; N]> {
            (0..4).map_while(|i| surface.row(of, first as usize + i, time)).collect()
        }
        let time = ray.time;
        let vertices = some(surface, |step| &step.vertices, first, time);
        let tangents = some(surface, |step| &step.tangents, first, time);
        let normals = some(surface, |step| &step.normals, first, time);
        let normal_tangents = some(surface, |step| &step.normal_tangents, first, time);
        let curves = Curves {
            tangents: &tangents,
            normals: &normals,
            normal_tangents: &normal_tangents,
            ..Curves::new(basis, form, &vertices, &[0])
        };
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        let normal = match form {
            CurveForm::Flat => curves.tangent(0, u),
            _ => curves.normal(0, [u, v], self.point(hit, ray)),
        };
        Some(normal?.map(|x| x as f32))
    }

    /// The normal at a ray's hit, in the geometry's space; zeros for user geometry, which returns its own,
    /// and for removed geometry.
    pub(crate) fn normal(&self, hit: &Hit, ray: &Ray) -> [f32; 3] {
        let Some(surface) = self.arrays else { return [0.0; 3] };
        let Surface { kind, indices, .. } = surface;
        let prim_id = hit.prim_id as usize;
        let corner =
            |i: u32| surface.row::<3>(|step| &step.vertices, i as usize, ray.time).unwrap_or_default();
        match kind {
            // One by one: arrays' `map` is not inlined, which took a quarter of a call.
            Kind::Triangles => {
                let [a, b, c] = indices.get::<u32, 3>(prim_id).unwrap_or_default();
                across(corner(a), corner(b), corner(c))
            }
            Kind::Quads | Kind::Grids | Kind::Subdivision => {
                let [a, b, c, d] = surface.quad(hit.prim_id).unwrap_or_default();
                let (first, second) = ([a, b, d], [c, d, b]);
                let [a, b, c] = if hit.u + hit.v <= 1.0 { first } else { second };
                across(corner(a), corner(b), corner(c))
            }
            Kind::Spheres => {
                let [x, y, z, _] =
                    surface.row::<4>(|step| &step.vertices, prim_id, ray.time).unwrap_or_default();
                let at = self.point(hit, ray);
                [0, 1, 2].map(|k| (at[k] - f64::from([x, y, z][k])) as f32)
            }
            Kind::Discs(true) => {
                surface.row::<3>(|step| &step.normals, prim_id, ray.time).unwrap_or_default()
            }
            Kind::Discs(false) => {
                let rows = transform::inverse(&self.world_from_object(ray.time));
                let [from, to] = [[0.0; 3], ray.dir.map(f64::from)].map(|p| transform::point(&rows, p));
                [0, 1, 2].map(|k| (from[k] - to[k]) as f32)
            }
            Kind::Curves(basis, form) => self.normal_of_curve(*basis, *form, hit, ray).unwrap_or_default(),
            Kind::Cones => {
                let [first] = indices.get::<u32, 1>(prim_id).unwrap_or_default();
                let end = |i: u32| {
                    surface
                        .row::<4>(|step| &step.vertices, first as usize + i as usize, ray.time)
                        .unwrap_or_default()
                };
                let cone = Cone::new([end(0), end(1)]);
                cone.normal(hit.u, self.point(hit, ray)).map(|x| x as f32)
            }
            Kind::User | Kind::Instance | Kind::Instances => [0.0; 3],
        }
    }
}

/// The normal of a triangle, not of unit length.
#[inline]
pub(crate) fn across(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let p = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let q = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}
