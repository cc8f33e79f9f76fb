// SPDX-License-Identifier: GPL-3.0-or-later
//! A geometry ready for rays: parts of triangles, spheres or curves, and which primitive and which vertices a place on them belongs to.
//! Space: object. Tests: tests/attributes.rs.

use std::sync::{Arc, Mutex};

use glam::Vec3;
use gnurt::scene::{Affine, CurveBasis, MaterialId, Mesh, Primitives as Surfaces};

use super::rates::Rates;
use crate::attribute::{Color, FREE, mix, weighted};
use crate::object::lock;
use crate::transforms::linear;

/// Which primitive a triangle, a sphere or a piece of a curve belongs to.
pub(crate) enum Primitives {
    /// Each is one.
    Own,
    /// Two make one.
    Pairs,
    /// These.
    Listed(Vec<u32>),
    /// That of the placement.
    Placed,
}

/// Which vertices of the program's arrays a vertex of the mesh stands for.
pub(crate) enum Vertices {
    /// The same.
    Own,
    /// One each.
    Listed(Vec<u32>),
    /// A mix of two.
    Mixed(Vec<([u32; 2], f32)>),
    /// A mix of the placement's ends, by the place between them.
    Placed,
    /// None.
    Nothing,
}

/// A place where a part is put.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) object_from_part: Affine,
    pub(crate) primitive: u32,
    /// Vertices of its ends; the same twice for a sphere.
    pub(crate) ends: [u32; 2],
}

/// The form of a part, for its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// That of its vertices.
    Mesh,
    /// The unit sphere.
    Ball,
    /// The unit cylinder.
    Rod,
    /// The unit disc.
    Disc,
}

/// Triangles, spheres or curves, once or in many places.
pub(crate) struct Part {
    mesh: Arc<Mesh>,
    form: Form,
    pub(crate) primitives: Primitives,
    pub(crate) vertices: Vertices,
    /// `None` = once, as they are.
    pub(crate) placements: Option<Vec<Placement>>,
    /// The same triangles of other materials.
    others: Mutex<Vec<Arc<Mesh>>>,
}

impl Part {
    /// A mesh that is there once.
    pub(crate) fn once(mesh: Mesh, primitives: Primitives, vertices: Vertices) -> Self {
        let (mesh, form) = (Arc::new(mesh), Form::Mesh);
        Self { mesh, form, primitives, vertices, placements: None, others: Mutex::default() }
    }

    /// Triangles in many places.
    pub(crate) fn placed(mesh: Arc<Mesh>, form: Form, placements: Vec<Placement>) -> Self {
        let (primitives, vertices) = (Primitives::Placed, Vertices::Placed);
        Self { mesh, form, primitives, vertices, placements: Some(placements), others: Mutex::default() }
    }

    /// Widens a box by itself where it stands at `world_from_object`.
    pub(crate) fn extend(&self, world_from_object: &Affine, bounds: &mut Bounds) {
        let Some(placements) = &self.placements else {
            let [x, y, z, _] = world_from_object.columns;
            let mut ball = |vertex: usize, radius: f32| {
                let reach = |k: usize| (x[k] * x[k] + y[k] * y[k] + z[k] * z[k]).sqrt() * f64::from(radius);
                let middle = self.mesh.positions.get(vertex).filter(|_| radius > 0.0);
                if let Some(middle) = middle {
                    bounds.add(world_from_object.point(middle.map(f64::from)), [0, 1, 2].map(reach));
                }
            };
            match &self.mesh.primitives {
                Surfaces::Triangles => {}
                Surfaces::Spheres(radii) => radii.iter().enumerate().for_each(|(i, &radius)| ball(i, radius)),
                Surfaces::Curves(curves) if curves.basis == CurveBasis::Bezier => {
                    let tubes = curves.segments.iter().map(|&first| first as usize);
                    tubes.for_each(|first| {
                        self.extend_by_tube(first, &curves.radii, world_from_object, bounds)
                    });
                }
                Surfaces::Curves(curves) => {
                    let ends = curves.segments.iter().flat_map(|&first| [first, first + 1]);
                    ends.for_each(|vertex| ball(vertex as usize, curves.radii[vertex as usize]));
                }
            }
            // Vertices that no triangle has are none of it.
            let used = self.mesh.indices.iter().flatten().map(|&vertex| self.mesh.positions[vertex as usize]);
            used.for_each(|p| bounds.add(world_from_object.point(p.map(f64::from)), [0.0; 3]));
            return;
        };
        for placement in placements {
            let [x, y, z, middle] = (*world_from_object * placement.object_from_part).columns;
            let length =
                |with: f64| [0, 1, 2].map(|k| (x[k] * x[k] + y[k] * y[k] + with * z[k] * z[k]).sqrt());
            match self.form {
                Form::Ball => bounds.add(middle, length(1.0)),
                Form::Disc => bounds.add(middle, length(0.0)),
                Form::Mesh | Form::Rod => {
                    bounds.add(middle, length(0.0));
                    bounds.add([0, 1, 2].map(|k| middle[k] + z[k]), length(0.0));
                }
            }
        }
    }

    /// Widens a box by the circles at both ends of a straight tube of four vertices.
    fn extend_by_tube(&self, first: usize, radii: &[f32], world_from_object: &Affine, bounds: &mut Bounds) {
        let ends = [first, first + 3];
        let [a, b] = ends.map(|vertex| Vec3::from(self.mesh.positions[vertex]));
        let Some(along) = (b - a).try_normalize() else { return };
        let (x, y) = along.any_orthonormal_pair();
        let matrix = linear(world_from_object);
        let [x, y] = [matrix * x, matrix * y].map(|v| v.to_array().map(f64::from));
        for vertex in ends {
            let radius = f64::from(radii[vertex]);
            let reach = [0, 1, 2].map(|k: usize| radius * (x[k] * x[k] + y[k] * y[k]).sqrt());
            bounds.add(world_from_object.point(self.mesh.positions[vertex].map(f64::from)), reach);
        }
    }

    /// Its triangles.
    pub(crate) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Its triangles of a material.
    pub(crate) fn mesh_of(&self, material: MaterialId) -> Arc<Mesh> {
        if self.mesh.material == material {
            return self.mesh.clone();
        }
        let mut others = lock(&self.others);
        if let Some(known) = others.iter().find(|mesh| mesh.material == material) {
            return known.clone();
        }
        let other = Arc::new(Mesh { material, ..(*self.mesh).clone() });
        others.push(other.clone());
        other
    }

    /// The primitive of a triangle.
    pub(crate) fn primitive(&self, triangle: u32, placement: u32) -> u32 {
        match &self.primitives {
            Primitives::Own => triangle,
            Primitives::Pairs => triangle / 2,
            Primitives::Listed(list) => list.get(triangle as usize).copied().unwrap_or(0),
            Primitives::Placed => placement,
        }
    }
}

/// A box around points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) low: [f64; 3],
    pub(crate) high: [f64; 3],
}

impl Default for Bounds {
    /// Around nothing.
    fn default() -> Self {
        Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] }
    }
}

impl Bounds {
    /// Widens it by a box around a point; axes with infinite or NaN numbers stay as they are.
    pub(crate) fn add(&mut self, p: [f64; 3], around: [f64; 3]) {
        for k in 0..3 {
            if p[k].is_finite() && around[k].is_finite() {
                (self.low[k], self.high[k]) =
                    (self.low[k].min(p[k] - around[k]), self.high[k].max(p[k] + around[k]));
            }
        }
    }

    /// Its corners; `None` around nothing.
    pub(crate) fn corners(&self) -> Option<[[f32; 3]; 2]> {
        let is_there = (0..3).all(|k| self.low[k] <= self.high[k]);
        is_there.then(|| [self.low, self.high].map(|corner| corner.map(|x| x as f32)))
    }
}

/// A geometry.
#[derive(Default)]
pub(crate) struct Geometry {
    pub(crate) parts: Vec<Part>,
    pub(crate) attributes: [Rates; FREE],
    /// Numbers of the primitives for people; empty = from 0 on.
    pub(crate) ids: Vec<u32>,
    /// The vertices, where ends of placements need them.
    pub(crate) points: Vec<[f32; 3]>,
}

/// A place on a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub(crate) part: u32,
    pub(crate) triangle: u32,
    /// Weights of its corners as [`Mesh::corners`] has them.
    pub(crate) weights: [f32; 3],
    /// Its primitive.
    pub(crate) primitive: u32,
    pub(crate) ends: [u32; 2],
    /// Object space.
    pub(crate) position: [f32; 3],
}

impl Geometry {
    /// The number of a primitive for people.
    pub(crate) fn id(&self, primitive: u32) -> u32 {
        self.ids.get(primitive as usize).copied().unwrap_or(primitive)
    }

    /// The value of an attribute; `None` where the geometry has no such attribute.
    pub(crate) fn attribute(&self, which: usize, spot: &Spot) -> Option<Color> {
        let rates = &self.attributes[which];
        let part = self.parts.get(spot.part as usize)?;
        if let Some(value) = corners(rates, part, spot) {
            return Some(value);
        }
        if !rates.vertex.is_empty()
            && let Some(value) = self.of_vertices(rates, part, spot)
        {
            return Some(value);
        }
        rates.primitive.get(spot.primitive as usize).copied().or(rates.constant)
    }

    fn of_vertices(&self, rates: &Rates, part: &Part, spot: &Spot) -> Option<Color> {
        let value = |vertex: u32| rates.vertex.get(vertex as usize).copied();
        let of_triangle = |value: &dyn Fn(u32) -> Option<Color>| {
            let [a, b, c] = part.mesh.corners(spot.triangle as usize)?.map(|vertex| vertex as u32);
            Some(weighted([value(a)?, value(b)?, value(c)?], spot.weights))
        };
        match &part.vertices {
            Vertices::Own => of_triangle(&value),
            Vertices::Listed(list) => of_triangle(&|corner| value(*list.get(corner as usize)?)),
            Vertices::Mixed(list) => of_triangle(&|corner| {
                let ([a, b], share) = *list.get(corner as usize)?;
                Some(mix(value(a)?, value(b)?, share))
            }),
            Vertices::Placed => {
                let [a, b] = spot.ends;
                if a == b {
                    return value(a);
                }
                Some(mix(value(a)?, value(b)?, self.between(spot)))
            }
            Vertices::Nothing => None,
        }
    }

    /// How far a place lies from the first end towards the second one, from 0 to 1.
    fn between(&self, spot: &Spot) -> f32 {
        let end = |k: usize| self.points.get(spot.ends[k] as usize).map(|&p| Vec3::from(p));
        let (Some(a), Some(b)) = (end(0), end(1)) else { return 0.0 };
        let axis = b - a;
        let share = (Vec3::from(spot.position) - a).dot(axis) / axis.length_squared();
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// The value of an attribute that each corner has.
fn corners(rates: &Rates, part: &Part, spot: &Spot) -> Option<Color> {
    let (first, corners) = match part.primitives {
        Primitives::Own => (3 * spot.triangle as usize, [0, 1, 2]),
        Primitives::Pairs if spot.triangle.is_multiple_of(2) => (2 * spot.triangle as usize, [0, 1, 2]),
        Primitives::Pairs => (2 * (spot.triangle as usize - 1), [0, 2, 3]),
        _ => return None,
    };
    let [a, b, c] = corners.map(|corner| rates.corner.get(first + corner).copied());
    Some(weighted([a?, b?, c?], spot.weights))
}
