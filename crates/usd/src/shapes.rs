// SPDX-License-Identifier: GPL-3.0-or-later
//! Shapes without points: cube, sphere, cylinder, cone, capsule, plane, as triangles with smooth normals.
//! Source: UsdGeom's intrinsic shapes. Round shapes have [`AROUND`] sides; their vertices lie on the shape. Texture coordinates run once
//! around. Space: that of the prim. Tests: `tests/shapes.rs`.

use std::f64::consts::{PI, TAU};

use gnurt_scene::{Mesh, ObjectId, Primitives};
use openusd::sdf::Path;

use crate::builder::Builder;
use crate::value;

/// Sides of round shapes.
const AROUND: u32 = 96;
/// Rings of half a circle.
const RINGS: u32 = 48;

type Point = [f64; 3];

/// A mesh under construction.
#[derive(Default)]
pub(crate) struct Shape(Mesh);

impl Shape {
    /// A strip around the z axis: places along it with radius, height, normal's radius and height, and v.
    fn around(&mut self, profile: &[([f64; 4], f64)]) {
        let begin = self.0.positions.len() as u32;
        let columns = AROUND + 1;
        for &([radius, z, normal, up], v) in profile {
            for i in 0..columns {
                let u = f64::from(i) / f64::from(AROUND);
                let (sin, cos) = if i == AROUND { (0.0, 1.0) } else { (TAU * u).sin_cos() };
                self.vertex([radius * cos, radius * sin, z], [normal * cos, normal * sin, up], [u, v]);
            }
        }
        for row in 0..profile.len() as u32 - 1 {
            for i in 0..AROUND {
                let a = begin + row * columns + i;
                let (b, c, d) = (a + 1, a + 1 + columns, a + columns);
                // At a pole one of the two has no area.
                if profile[row as usize].0[0] != 0.0 {
                    self.0.indices.push([a, b, c]);
                }
                if profile[row as usize + 1].0[0] != 0.0 {
                    self.0.indices.push([a, c, d]);
                }
            }
        }
    }

    fn vertex(&mut self, position: Point, normal: Point, uv: [f64; 2]) {
        self.0.positions.push(position.map(|x| x as f32));
        self.0.normals.push(normal.map(|x| x as f32));
        self.0.texcoords.push(uv.map(|x| x as f32));
    }

    fn cap(&mut self, radius: f64, z: f64, up: f64) {
        let begin = self.0.positions.len() as u32;
        self.vertex([0.0, 0.0, z], [0.0, 0.0, up], [0.5, 0.5]);
        for i in 0..AROUND {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(AROUND)).sin_cos();
            self.vertex([radius * cos, radius * sin, z], [0.0, 0.0, up], [0.5 + cos / 2.0, 0.5 + sin / 2.0]);
        }
        for i in 0..AROUND {
            let (a, b) = (begin + 1 + i, begin + 1 + (i + 1) % AROUND);
            self.0.indices.push(if up > 0.0 { [begin, a, b] } else { [begin, b, a] });
        }
    }

    /// The mesh, with z turned to another axis.
    fn along(mut self, axis: char) -> Mesh {
        let rotate = |[x, y, z]: [f32; 3]| match axis {
            'X' => [z, x, y],
            'Y' => [y, z, x],
            _ => [x, y, z],
        };
        self.0.positions.iter_mut().chain(&mut self.0.normals).for_each(|v| *v = rotate(*v));
        self.0
    }
}

/// A ball.
pub(crate) fn sphere(radius: f64) -> Mesh {
    let mut shape = Shape::default();
    shape.around(&arc(radius, 0.0, -PI / 2.0, PI / 2.0, [0.0, 1.0]));
    shape.along('Z')
}

/// A ball without triangles.
pub(crate) fn exact_ball(radius: f64) -> Mesh {
    Mesh {
        positions: vec![[0.0; 3]],
        primitives: Primitives::Spheres(vec![radius as f32]),
        ..Mesh::default()
    }
}

/// A ball of fewer sides and rings.
pub(crate) fn ball(radius: f64, [sides, rings]: [u32; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        let (sin, cos) = (PI * (f64::from(ring) / f64::from(rings) - 0.5)).sin_cos();
        for side in 0..sides {
            let (y, x) = (TAU * f64::from(side) / f64::from(sides)).sin_cos();
            mesh.positions.push([radius * cos * x, radius * cos * y, radius * sin].map(|x| x as f32));
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let [a, d] = [ring, ring + 1].map(|ring| ring * sides + side);
            let [b, c] = [ring, ring + 1].map(|ring| ring * sides + (side + 1) % sides);
            mesh.indices.extend((ring > 0).then_some([a, b, c]));
            mesh.indices.extend((ring + 1 < rings).then_some([a, c, d]));
        }
    }
    mesh
}

/// A mantle along x of fewer sides, open at its ends.
pub(crate) fn tube(radius: f64, length: f64, sides: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for x in [-length / 2.0, length / 2.0] {
        for side in 0..sides {
            let (z, y) = (TAU * f64::from(side) / f64::from(sides)).sin_cos();
            mesh.positions.push([x, radius * y, radius * z].map(|x| x as f32));
        }
    }
    for side in 0..sides {
        let next = (side + 1) % sides;
        mesh.indices.extend(
            [[side, next + sides, next], [side, side + sides, next + sides]].map(|[a, b, c]| [a, c, b]),
        );
    }
    mesh
}

/// Places on an arc, by latitude.
fn arc(radius: f64, z: f64, from: f64, to: f64, v: [f64; 2]) -> Vec<([f64; 4], f64)> {
    let rings = ((to - from) / PI * f64::from(RINGS)).round() as u32;
    let vertex = |i: u32| {
        let share = f64::from(i) / f64::from(rings);
        let latitude = from + (to - from) * share;
        let (sin, cos) = latitude.sin_cos();
        let cos = if latitude.abs() > PI / 2.0 - 1e-9 { 0.0 } else { cos };
        ([radius * cos, z + radius * sin, cos, sin], v[0] + (v[1] - v[0]) * share)
    };
    (0..=rings).map(vertex).collect()
}

/// A mantle, with or without caps.
pub(crate) fn cylinder([bottom, top]: [f64; 2], height: f64, axis: char, has_caps: bool) -> Mesh {
    let mut shape = Shape::default();
    let slope = (bottom - top) / height;
    let length = slope.hypot(1.0);
    let vertex = |radius: f64, z: f64, v: f64| ([radius, z, 1.0 / length, slope / length], v);
    shape.around(&[vertex(bottom, -height / 2.0, 0.0), vertex(top, height / 2.0, 1.0)]);
    for (radius, z) in [(bottom, -height / 2.0), (top, height / 2.0)] {
        if has_caps && radius > 0.0 {
            shape.cap(radius, z, z.signum());
        }
    }
    shape.along(axis)
}

fn capsule([bottom, top]: [f64; 2], height: f64, axis: char) -> Mesh {
    let mut shape = Shape::default();
    let mut profile = arc(bottom, -height / 2.0, -PI / 2.0, 0.0, [0.0, 0.25]);
    profile.extend(arc(top, height / 2.0, 0.0, PI / 2.0, [0.75, 1.0]));
    shape.around(&profile);
    shape.along(axis)
}

fn cube(size: f64) -> Mesh {
    let mut shape = Shape::default();
    let half = size / 2.0;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let begin = shape.0.positions.len() as u32;
            for [s, t] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
                let (mut position, mut normal) = ([0.0; 3], [0.0; 3]);
                (position[axis], normal[axis]) = (side * half, side);
                position[(axis + 1) % 3] = s * half * side;
                position[(axis + 2) % 3] = t * half;
                shape.vertex(position, normal, [(s + 1.0) / 2.0, (t + 1.0) / 2.0]);
            }
            shape.0.indices.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|i| begin + i)));
        }
    }
    shape.0
}

/// A rectangle across z, seen from +z, or from -z.
pub(crate) fn rectangle([width, length]: [f64; 2], faces_back: bool, axis: char) -> Mesh {
    let mut shape = Shape::default();
    let up = if faces_back { -1.0 } else { 1.0 };
    for [s, t] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        // Seen from the back u runs the other way.
        let u = if faces_back { 1.0 - s } else { s };
        shape.vertex([(s - 0.5) * width, (t - 0.5) * length, 0.0], [0.0, 0.0, up], [u, t]);
    }
    shape.0.indices = vec![[0, 1, 2], [0, 2, 3]];
    if faces_back {
        shape.0.indices.iter_mut().for_each(|t| t.swap(1, 2));
    }
    shape.along(axis)
}

/// A disk across z, seen from -z.
pub(crate) fn disk(radius: f64) -> Mesh {
    let mut shape = Shape::default();
    shape.cap(radius, 0.0, -1.0);
    shape.along('Z')
}

impl Builder<'_> {
    /// The object of a shape.
    pub(crate) fn shape(&mut self, prim: &Path, kind: &str) -> Option<ObjectId> {
        let reader = self.reader;
        let number = |name: &str, fallback: f64| reader.number_or(prim, name, fallback).abs();
        let axis = reader.word(prim, "axis").and_then(|axis| axis.chars().next()).unwrap_or('Z');
        let radii = || match (reader.number(prim, "radiusBottom"), reader.number(prim, "radiusTop")) {
            (None, None) => [number("radius", if kind == "Cylinder_1" { 1.0 } else { 0.5 }); 2],
            (bottom, top) => [bottom.unwrap_or(0.5).abs(), top.unwrap_or(0.5).abs()],
        };
        let mut mesh = match kind {
            "Cube" => cube(number("size", 2.0)),
            "Sphere" => sphere(number("radius", 1.0)),
            "Cylinder" => cylinder([number("radius", 1.0); 2], number("height", 2.0), axis, true),
            "Cylinder_1" => cylinder(radii(), number("height", 2.0), axis, true),
            "Cone" => cylinder([number("radius", 1.0), 0.0], number("height", 2.0), axis, true),
            "Capsule" => capsule([number("radius", 0.5); 2], number("height", 1.0), axis),
            "Capsule_1" => capsule(radii(), number("height", 1.0), axis),
            "Plane" => {
                let (width, length) = (number("width", 2.0), number("length", 2.0));
                // Width lies along x, or along z if that is free and x is not; length along what is left.
                rectangle(if axis == 'Z' { [width, length] } else { [length, width] }, false, axis)
            }
            _ => return None,
        };
        let color = |name: &str| {
            let found = reader.value(prim, name)?;
            let (_, values) = value::floats(&found)?;
            (!values.is_empty()).then_some(values)
        };
        let (rgb, opacity) = (color("primvars:displayColor"), color("primvars:displayOpacity"));
        let material = match self.bound(prim) {
            Some(material) => self.materials.of(reader, &mut self.scene, &material),
            None => self.materials.unbound(&mut self.scene, rgb.is_some(), opacity.is_some()),
        };
        if material.has_colors && (rgb.is_some() || opacity.is_some()) {
            let one = |k: usize| rgb.as_ref().and_then(|rgb| rgb.get(k)).copied().unwrap_or(1.0);
            let alpha = opacity.as_ref().map_or(1.0, |opacity| opacity[0]);
            mesh.colors = vec![[one(0), one(1), one(2), alpha]; mesh.positions.len()];
        }
        mesh.material = material.id;
        mesh.name = prim.name().unwrap_or_default().to_owned();
        let mesh = self.add_mesh(mesh)?;
        Some(self.scene.add_object_of(prim.as_str(), vec![mesh]))
    }
}
