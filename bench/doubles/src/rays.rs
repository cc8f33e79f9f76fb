// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays of a camera, and those that follow from what it sees. The classes are those of docs/how-to/measure.md, with four rays of
//! ambient occlusion.

use gnurt_accel::{HitBatch, ObjectTree, Query, Ray, RayBatch, Record};

use crate::mesh::Mesh;

type V3 = [f32; 3];

pub(crate) struct View {
    pub(crate) eye: V3,
    pub(crate) target: V3,
    pub(crate) up: V3,
    pub(crate) degrees: f32,
}

fn minus(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: V3, b: V3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: V3) -> V3 {
    v.map(|x| x / dot(v, v).sqrt())
}

fn along(a: V3, t: f32, d: V3) -> V3 {
    [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]]
}

/// Numbers that are the same in each run: a linear congruential generator, its bits mixed.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 ^ self.0 >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd) >> 20
    }

    fn unit(&mut self) -> f32 {
        (self.bits() & 0xff_ffff) as f32 / 16_777_216.0
    }
}

/// Bits 0, 2 and 4, side by side.
fn even_bits(position: u32) -> u32 {
    position & 1 | position >> 1 & 2 | position >> 2 & 4
}

/// Through pixel centres, in tiles of 8 x 8.
fn primary(view: &View, [right, up]: [V3; 2], size: u32) -> Vec<Ray> {
    let forward = unit(minus(view.target, view.eye));
    let half = (0.5 * view.degrees.to_radians()).tan();
    let at = |pixel: u32| half * (2.0 * (pixel as f32 + 0.5) / size as f32 - 1.0);
    let mut rays = Vec::new();
    let tiles = size / 8;
    for tile in 0..tiles * tiles {
        for position in 0..64 {
            let x = tile % tiles * 8 + even_bits(position);
            let y = tile / tiles * 8 + even_bits(position >> 1);
            rays.push(Ray::new(view.eye, unit(along(along(forward, at(x), right), -at(y), up))));
        }
    }
    rays
}

/// Name, whether any hit will do, and rays.
pub(crate) fn classes(
    mesh: &Mesh,
    view: &View,
    size: u32,
    tree: &ObjectTree,
) -> [(&'static str, bool, Vec<Ray>); 5] {
    let forward = unit(minus(view.target, view.eye));
    let right = unit(cross(forward, view.up));
    let up = cross(right, forward);
    let bound = |pick: fn(f32, f32) -> f32, k: usize| mesh.positions.iter().map(|at| at[k]).reduce(pick);
    let extent = [0, 1, 2].map(|k| bound(f32::max, k).unwrap_or(0.0) - bound(f32::min, k).unwrap_or(0.0));
    let diagonal = dot(extent, extent).sqrt();
    let light = along(along(view.eye, 0.1 * diagonal, up), 0.05 * diagonal, right);
    let seen = primary(view, [right, up], size);
    let mut hits = HitBatch::default();
    let batch: RayBatch = seen.iter().copied().collect();
    tree.intersect_batch(&Query::default(), &batch, &mut hits, &mut Record::default());
    let mut random = Random(1);
    let (mut shadow, mut ao, mut diffuse) = (Vec::new(), Vec::new(), Vec::new());
    for (i, ray) in seen.iter().enumerate() {
        let Some(hit) = hits.get(i) else { continue };
        let [a, b, c] = mesh.indices[hit.prim_id as usize].map(|corner| mesh.positions[corner as usize]);
        let normal = unit(cross(minus(b, a), minus(c, a)));
        let normal = if dot(normal, ray.dir) > 0.0 { normal.map(|x| -x) } else { normal };
        let at = along(along(view.eye, hit.t, ray.dir), 1e-5 * diagonal, normal);
        shadow.push(Ray::new(at, minus(light, at)).within(0.0, 1.0));
        let across = if normal[0].abs() > 0.5 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let x = unit(cross(normal, across));
        let y = cross(normal, x);
        let mut around = || {
            let (u, angle) = (random.unit(), std::f32::consts::TAU * random.unit());
            let (radius, height) = (u.sqrt(), (1.0 - u).max(0.0).sqrt());
            let flat = along([0.0; 3], height, normal);
            unit(along(along(flat, radius * angle.cos(), x), radius * angle.sin(), y))
        };
        diffuse.push(Ray::new(at, around()));
        ao.extend((0..4).map(|_| Ray::new(at, around()).within(0.0, 0.1 * diagonal)));
    }
    let mut shuffled = diffuse.clone();
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, random.bits() as usize % (i + 1));
    }
    [
        ("primary", false, seen),
        ("shadow", true, shadow),
        ("ao", true, ao),
        ("diffuse", false, diffuse),
        ("shuffled", false, shuffled),
    ]
}
