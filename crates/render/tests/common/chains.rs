// SPDX-License-Identifier: GPL-3.0-or-later
//! All ways of light from a point lamp through a ball of glass, a mesh, to a point: the sum that searches estimate.
//! First directions cover each triangle that faces the point. The two triangles that one meets are solved by Newton's method on
//! their planes, with normals that go on beyond the edges; a solution counts if it is within both.
//! All in f64, by text that shares nothing with the program but the mesh. Space: world; light that the ball mirrors inside is left out.

use std::collections::HashMap;

use glam::{DMat2, DVec2, DVec3};
use gnurt_scene::Mesh;

/// Steps of a solution at most; it ends where it misses by less than this, radians.
const STEPS: usize = 30;
/// Halved steps of one, and pairs of faces for one first direction.
const HALVES: i32 = 8;
const HOPS: usize = 4;
const ARRIVED: f64 = 1e-12;
/// The step of difference quotients, radians.
const STEP: f64 = 1e-6;
/// How far weights of corners may be beyond an edge, by rounding.
const INSIDE: f64 = -1e-10;

/// A triangle and its unit normals.
struct Face {
    p: [DVec3; 3],
    n: [DVec3; 3],
    /// Unit, outwards.
    flat: DVec3,
}

/// A ball of glass.
pub struct Ball {
    faces: Vec<Face>,
    /// By cells of space: the faces that reach into them.
    cells: HashMap<[i32; 3], Vec<usize>>,
    center: DVec3,
    radius: f64,
    ior: f64,
}

/// A way of light.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Unit, from the point.
    pub dir: DVec3,
    /// The triangles where it enters and leaves.
    pub faces: [usize; 2],
    /// Irradiance of the floor per intensity of the lamp, m⁻².
    pub light: f64,
}

/// A ray through both faces.
struct Passed {
    org: DVec3,
    dir: DVec3,
    /// The share of light, and the least weight of a corner.
    light: f64,
    least: f64,
}

impl Ball {
    /// Of a mesh around `center` with this index.
    pub fn new(mesh: &Mesh, center: [f32; 3], ior: f64) -> Self {
        let of = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let center = of(center);
        let face = |corners: &[u32; 3]| {
            let p = corners.map(|vertex| of(mesh.positions[vertex as usize]));
            let n = corners.map(|vertex| of(mesh.normals[vertex as usize]).normalize());
            let flat = (p[1] - p[0]).cross(p[2] - p[0]).normalize();
            Face { p, n, flat: flat * flat.dot(p[0] - center).signum() }
        };
        let faces: Vec<Face> = mesh.indices.iter().map(face).collect();
        let radius = faces[0].p[0].distance(center);
        let mut cells: HashMap<[i32; 3], Vec<usize>> = HashMap::new();
        for (number, face) in faces.iter().enumerate() {
            let mut reached: Vec<[i32; 3]> = face.p.iter().flat_map(|&p| around(p, radius)).collect();
            reached.sort_unstable();
            reached.dedup();
            reached.into_iter().for_each(|cell| cells.entry(cell).or_default().push(number));
        }
        Self { faces, cells, center, radius, ior }
    }

    /// All ways from a lamp to `p`, whose normal is z; `density`: of first directions along an edge.
    pub fn ways(&self, p: DVec3, lamp: DVec3, density: usize) -> Vec<Way> {
        let mut found: HashMap<[usize; 2], Vec<Way>> = HashMap::new();
        for face in &self.faces {
            if face.flat.dot(p - face.p[0]) <= 0.0 {
                continue;
            }
            for (a, b) in (0..density).flat_map(|a| (0..density - a).map(move |b| (a, b))) {
                let weight = |k: usize| (k as f64 + 1.0 / 3.0) / density as f64;
                let target = face.at(&face.p, [weight(a), weight(b)]);
                let Some(way) = self.search(p, (target - p).normalize(), lamp) else { continue };
                let ways = found.entry(way.faces).or_default();
                if ways.iter().all(|known| known.dir.distance(way.dir) > 1e-9) {
                    ways.push(way);
                }
            }
        }
        let mut all: Vec<Way> = found.into_values().flatten().collect();
        all.sort_by_key(|way| way.faces);
        all
    }

    /// The face that a ray meets from within (`side` 1) or from outside (-1).
    fn met(&self, (org, dir): (DVec3, DVec3), side: f64) -> Option<usize> {
        let is_met = |j: usize| {
            let face = &self.faces[j];
            side * face.flat.dot(dir) > 0.0
                && face.meet((org, dir)).is_some_and(|(t, w)| t > 0.0 && least(w) >= INSIDE)
        };
        // About where the sphere is met; the faces there are among those around.
        let (from_center, half) = (org - self.center, (org - self.center).dot(dir));
        let root = (half * half - from_center.length_squared() + self.radius * self.radius).max(0.0).sqrt();
        let cell = cell(org + dir * (side * root - half), self.radius);
        self.cells.get(&cell)?.iter().copied().find(|&j| is_met(j))
    }

    /// The faces where a ray from outside enters and leaves.
    fn follow(&self, ray: (DVec3, DVec3)) -> Option<[usize; 2]> {
        let i = self.met(ray, -1.0)?;
        let (at, inside, _, _) = self.refract(ray, i, 1.0 / self.ior)?;
        Some([i, self.met((at, inside), 1.0).filter(|&j| j != i)?])
    }

    /// Where a ray goes at the plane of a face: point, direction, share of light, and weights of two corners.
    fn refract(&self, ray: (DVec3, DVec3), face: usize, eta: f64) -> Option<(DVec3, DVec3, f64, [f64; 2])> {
        let (face, dir) = (&self.faces[face], ray.1);
        let (t, weights) = face.meet(ray)?;
        let n = face.at(&face.n, weights).normalize();
        let n = if n.dot(dir) > 0.0 { -n } else { n };
        let before = -n.dot(dir);
        let behind = 1.0 - eta * eta * (1.0 - before * before);
        if behind <= 0.0 {
            return None;
        }
        let behind = behind.sqrt();
        // Both polarizations, at an interface whose index before is `eta` times that behind.
        let s = (eta * before - behind) / (eta * before + behind);
        let p = (before - eta * behind) / (before + eta * behind);
        let out = dir * eta + n * (eta * before - behind);
        Some((ray.0 + dir * t, out.normalize(), 1.0 - 0.5 * (s * s + p * p), weights))
    }

    fn through(&self, ray: (DVec3, DVec3), [i, j]: [usize; 2]) -> Option<Passed> {
        let (at, inside, first, a) = self.refract(ray, i, 1.0 / self.ior)?;
        let (org, dir, second, b) = self.refract((at, inside), j, self.ior)?;
        Some(Passed { org, dir, light: first * second, least: least(a).min(least(b)) })
    }

    /// The way that Newton's method finds from a first direction; where a solution of two planes is beyond an edge of their faces,
    /// those that a ray in its direction meets are tried.
    fn search(&self, p: DVec3, mut dir: DVec3, lamp: DVec3) -> Option<Way> {
        for _ in 0..HOPS {
            let (found, is_within) = self.solve((p, dir), self.follow((p, dir))?, lamp)?;
            if is_within {
                return Some(found);
            }
            dir = found.dir;
        }
        None
    }

    /// The way through the planes of two faces that Newton's method finds from a first direction, and whether it is within both.
    fn solve(&self, (p, mut dir): (DVec3, DVec3), faces: [usize; 2], lamp: DVec3) -> Option<(Way, bool)> {
        let mut passed = self.through((p, dir), faces)?;
        for _ in 0..STEPS {
            let (x, y) = passed.dir.any_orthonormal_pair();
            // Where a ray crosses the plane through the lamp that is across this one.
            let cross = |of: &Passed| {
                let t = (lamp - of.org).dot(passed.dir) / of.dir.dot(passed.dir);
                let off = of.org + of.dir * t - lamp;
                DVec2::new(off.dot(x), off.dot(y))
            };
            let (u, v) = dir.any_orthonormal_pair();
            let moved = |step: DVec2| (dir + u * step.x + v * step.y).normalize();
            let slope = |axis: DVec2| {
                let side = |by: f64| self.through((p, moved(axis * by)), faces);
                Some((cross(&side(STEP)?) - cross(&side(-STEP)?)) / (2.0 * STEP))
            };
            let change = DMat2::from_cols(slope(DVec2::X)?, slope(DVec2::Y)?);
            let (off, dist) = (cross(&passed), (lamp - passed.org).dot(passed.dir));
            if off.length() < ARRIVED * dist.abs() {
                let is_within = passed.least >= INSIDE && dist > 0.0 && self.goes_out(&passed, faces, dir);
                let light = dir.z.max(0.0) * passed.light / change.determinant().abs();
                return Some((Way { dir, faces, light }, is_within));
            }
            let step = (change.inverse() * -off).clamp_length_max(0.1);
            let shorter = |k: i32| moved(step * 0.5_f64.powi(k));
            let is_better = |next: &DVec3| {
                self.through((p, *next), faces).is_some_and(|passed| cross(&passed).length() < off.length())
            };
            dir = (0..HALVES).map(shorter).find(is_better)?;
            passed = self.through((p, dir), faces)?;
        }
        None
    }

    /// Whether it enters and leaves by the flat faces, too.
    fn goes_out(&self, passed: &Passed, [i, j]: [usize; 2], dir: DVec3) -> bool {
        self.faces[i].flat.dot(dir) < 0.0 && self.faces[j].flat.dot(passed.dir) > 0.0
    }
}

impl Face {
    fn at(&self, of: &[DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
        of[0] * (1.0 - u - v) + of[1] * u + of[2] * v
    }

    /// Where a ray crosses its plane: distance, and weights of the second and the third corner.
    fn meet(&self, (org, dir): (DVec3, DVec3)) -> Option<(f64, [f64; 2])> {
        let (a, b) = (self.p[1] - self.p[0], self.p[2] - self.p[0]);
        let normal = a.cross(b);
        let t = (self.p[0] - org).dot(normal) / dir.dot(normal);
        let at = org + dir * t - self.p[0];
        let square = normal.length_squared();
        t.is_finite().then(|| (t, [at.cross(b).dot(normal) / square, a.cross(at).dot(normal) / square]))
    }
}

/// The least of all three weights.
fn least([u, v]: [f64; 2]) -> f64 {
    u.min(v).min(1.0 - u - v)
}

/// The cell of a point of a ball of this radius; longer than the edges of faces.
fn cell(p: DVec3, radius: f64) -> [i32; 3] {
    (p * (4.0 / radius)).to_array().map(|x| x.floor() as i32)
}

/// That cell and those around it.
fn around(p: DVec3, radius: f64) -> impl Iterator<Item = [i32; 3]> {
    let [x, y, z] = cell(p, radius);
    (0..27).map(move |k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1])
}
