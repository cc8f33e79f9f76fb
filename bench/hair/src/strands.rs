// SPDX-License-Identifier: GPL-3.0-or-later
//! Strands on a ball, as a groom has them, and rays to them. Space: that of the ball, whose radius is 1.

use std::f32::consts::TAU;

use gnurt_accel::{CurveBasis, Ray, RayBatch};

/// Curves of a strand.
const CURVES: usize = 8;

/// Strands: their vertices, and the first vertex of each curve.
pub struct Strands {
    pub vertices: Vec<[f32; 4]>,
    pub indices: Vec<u32>,
}

/// Numbers that look random: a linear congruence, mixed [OEl16].
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ self.0 >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd);
        ((mixed >> 40) as f32) / (1 << 24) as f32
    }

    /// On the unit sphere.
    pub fn direction(&mut self) -> [f32; 3] {
        let (z, angle) = (2.0 * self.unit() - 1.0, TAU * self.unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        [r * angle.cos(), r * angle.sin(), z]
    }
}

fn add(a: [f32; 3], t: f32, b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] + t * b[k])
}

fn unit(a: [f32; 3]) -> [f32; 3] {
    let length = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    a.map(|x| x / length)
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Strands {
    /// Hair of this kind: `fur` stands and bends down, `long` falls in waves.
    pub fn new(kind: &str, count: usize, basis: CurveBasis) -> Self {
        let mut random = Random::new(7);
        // As many vertices more than curves.
        let points = CURVES + if basis == CurveBasis::Linear { 1 } else { 3 };
        let step_order = if basis == CurveBasis::Bezier { 3 } else { 1 };
        let points = if basis == CurveBasis::Bezier { 3 * CURVES + 1 } else { points };
        let (length, fall, wave) = if kind == "long" { (2.0, 0.9, 0.03) } else { (0.5, 0.35, 0.0) };
        let mut strands = Self { vertices: Vec::new(), indices: Vec::new() };
        for _ in 0..count {
            let root = random.direction();
            let stray = random.direction();
            let mut towards = unit(add(root, 0.4, stray));
            let mut at = root;
            let first = strands.vertices.len() as u32;
            let (phase, turns) = (TAU * random.unit(), 2.0 + 2.0 * random.unit());
            let step = length * (0.7 + 0.6 * random.unit()) / (points - 1) as f32;
            let width = 0.001 * (0.7 + 0.6 * random.unit());
            for i in 0..points {
                let along = i as f32 / (points - 1) as f32;
                let side = unit(cross(root, [0.31, 0.52, 0.79]));
                let other = cross(root, side);
                let (sin, cos) = (phase + TAU * turns * along).sin_cos();
                let p = add(add(at, wave * along * cos, side), wave * along * sin, other);
                strands.vertices.push([p[0], p[1], p[2], width * (1.0 - 0.7 * along)]);
                at = add(at, step, towards);
                towards = unit(add(towards, fall * 8.0 / points as f32, [0.0, -1.0, 0.0]));
                // Not through the ball.
                let r = at.iter().map(|x| x * x).sum::<f32>().sqrt();
                if r < 1.0 {
                    at = at.map(|x| x / r);
                }
            }
            strands.indices.extend((0..CURVES as u32).map(|i| first + step_order * i));
        }
        strands
    }
}

/// Rays from a camera, row by row in squares of 8.
pub fn camera(size: u32) -> RayBatch {
    let mut rays = RayBatch::default();
    let eye = [0.5, 0.6, 4.2];
    for block in 0..(size / 8) * (size / 8) {
        let (left, top) = (block % (size / 8) * 8, block / (size / 8) * 8);
        for i in 0..64 {
            let at = |x: u32| (x as f32 + 0.5) / size as f32 * 2.0 - 1.0;
            let (x, y) = (at(left + i % 8), at(top + i / 8));
            let to = [1.5 * x, 1.5 * y - 0.3, 0.0];
            rays.push(Ray::new(eye, add(to, -1.0, eye)));
        }
    }
    rays
}

/// Rays from anywhere around to anywhere within.
pub fn random(count: usize) -> RayBatch {
    let mut random = Random::new(3);
    let ray = |_| {
        let org = random.direction().map(|x| 3.0 * x);
        let (off, r) = (random.direction(), 1.3 * random.unit());
        Ray::new(org, add(off.map(|x| r * x), -1.0, org))
    };
    (0..count).map(ray).collect()
}

/// Rays from the hits of others: to a lamp, or anywhere.
pub fn further(rays: &RayBatch, t: &[f32], to_lamp: bool) -> RayBatch {
    let mut random = Random::new(5);
    let lamp = [3.0, 5.0, 4.0];
    let mut found = RayBatch::default();
    for (i, &t) in t.iter().enumerate().filter(|(_, t)| t.is_finite()) {
        let ray = rays.get(i);
        let at = add(ray.org, t, ray.dir);
        let dir = if to_lamp { add(lamp, -1.0, at) } else { random.direction() };
        let mut ray = Ray::new(at, dir);
        ray.t_near = 0.004 / dir.iter().map(|x| x * x).sum::<f32>().sqrt();
        ray.t_far = if to_lamp { 1.0 } else { f32::INFINITY };
        found.push(ray);
    }
    found
}
