// SPDX-License-Identifier: GPL-3.0-or-later
//! Points in double precision: the nearest point of a surface, inside or outside, distances.
//! Source: as `inside.rs`: the crossings of a ray are odd inside. Tests: `tests/doubles.rs`.

use gnurt_accel_core::Threads;
use gnurt_accel_core::exact::{InstancePath, Line, Triangle};
use gnurt_accel_core::point::{Probe, on_triangle};
use gnurt_simd::Level;

use super::lines::search;
use super::rays::each;
use super::scene::DoubleScene;
use crate::Side;
use crate::inside::LEAN;

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoublePoint {
    /// How far away it is.
    pub distance: f64,
    /// Its position.
    pub point: [f64; 3],
    /// The weight of the second corner.
    pub u: f64,
    /// The weight of the third corner.
    pub v: f64,
    /// The triangle in its mesh.
    pub prim_id: u32,
    /// The mesh in its scene.
    pub geom_id: u32,
    /// The outermost instance; `INVALID_ID` of a mesh of the queried scene.
    pub inst_id: u32,
    /// For [`DoubleScene::path`].
    pub leaf_id: u32,
}

/// The nearest point so far.
struct Nearest {
    distance: f64,
    offset: [f64; 3],
    uv: [f64; 2],
    leaf: u32,
    ids: [u32; 2],
    is_found: bool,
}

/// The point in the space of a scene, what it may be off by, and the way out.
#[derive(Clone, Copy)]
struct Here<'a> {
    probe: Probe,
    off: f64,
    path: Option<&'a InstancePath<'a>>,
    leaf: u32,
}

fn near(scene: &DoubleScene, point: [f64; 3], here: Here, nearest: &mut Nearest, level: Level) {
    let Here { probe, off, path, leaf } = here;
    let reach = |distance: f64| probe.radius_for(distance) + 4.0 * off;
    scene.index.near(level, probe.point, reach(nearest.distance), &mut |number, corners| {
        let ids = scene.ids(number);
        if scene.masks[ids[0] as usize] & probe.mask != 0 {
            let triangle = Triangle::of_doubles(corners, path);
            let from = triangle.near.map(|at| [0, 1, 2].map(|k| at[k] - point[k]));
            let (offset, uv) = on_triangle(from);
            let distance = length(offset);
            let is_nearer = if nearest.is_found {
                (distance, leaf, ids) < (nearest.distance, nearest.leaf, nearest.ids)
            } else {
                distance <= nearest.distance
            };
            if is_nearer {
                *nearest = Nearest { distance, offset, uv, leaf, ids, is_found: true };
            }
        }
        reach(nearest.distance)
    });
    scene.boxes.near(level, probe.point, reach(nearest.distance), &mut |number| {
        let placed = &scene.instances[number as usize];
        if placed.mask & probe.mask != 0 {
            let columns = &placed.map.columns;
            let [x, y, z, _] = *columns;
            let (inside, off) = placed.map.point_inwards(probe.point, off);
            let path = InstancePath { columns, outer: path };
            let here = Here {
                probe: probe.inside(inside, &[x, y, z]),
                off,
                path: Some(&path),
                leaf: leaf + placed.first_leaf,
            };
            near(&placed.shown, point, here, nearest, level);
        }
        reach(nearest.distance)
    });
}

/// Without overflow.
fn length(v: [f64; 3]) -> f64 {
    let size = v[0].abs().max(v[1].abs()).max(v[2].abs());
    if size > 1e-140 && size < 1e140 {
        return (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    }
    v[0].hypot(v[1]).hypot(v[2])
}

impl DoubleScene {
    /// The nearest point of all surfaces within `radius`, its bound included.
    #[must_use]
    pub fn closest_point(&self, point: [f64; 3], radius: f64, mask: u32) -> Option<DoublePoint> {
        if point.iter().any(|x| !x.is_finite()) || radius.is_nan() || radius < 0.0 {
            return None;
        }
        let none = [0; 2];
        let mut nearest =
            Nearest { distance: radius, offset: [0.0; 3], uv: [0.0; 2], leaf: 0, ids: none, is_found: false };
        let here = Here { probe: Probe::new(point, mask), off: 0.0, path: None, leaf: 0 };
        near(self, point, here, &mut nearest, Level::best());
        let Nearest { distance, offset, uv: [u, v], leaf, ids: [geom_id, prim_id], is_found } = nearest;
        is_found.then(|| DoublePoint {
            distance,
            point: [0, 1, 2].map(|k| point[k] + offset[k]),
            u,
            v,
            prim_id,
            geom_id,
            inst_id: self.outermost(leaf),
            leaf_id: leaf,
        })
    }

    /// Whether a point is in a closed mesh, on one, or in none: exactly. NaN and infinite ones are outside.
    #[must_use]
    pub fn side(&self, point: [f64; 3], mask: u32) -> Side {
        let [low, high] = self.bounds();
        if !(0..3).all(|k| low[k] <= point[k] && point[k] <= high[k]) {
            return Side::Outside;
        }
        // The shortest way outwards.
        let paths = [0, 1, 2].map(|k| [(high[k] - point[k], k, 1.0), (point[k] - low[k], k, -1.0)]);
        let shortest = paths.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, axis, along) = shortest.unwrap_or((0.0, 0, 1.0));
        let mut dir = [0.0; 3];
        (dir[axis], dir[(axis + 1) % 3], dir[(axis + 2) % 3]) = (along, LEAN[0], LEAN[1]);
        let line = Line::new(point, dir, 0.0, f64::INFINITY);
        let (mut crossed, mut on) = (Vec::new(), Vec::new());
        search(self, &line, mask, &mut |candidate| {
            if line.starts_on(candidate.triangle) {
                on.push(candidate.leaf);
            }
            if line.crosses(candidate.triangle).is_some() {
                crossed.push(candidate.leaf);
            }
            f64::INFINITY
        });
        crossed.sort_unstable();
        let is_inside =
            crossed.chunk_by(|a, b| a == b).any(|leaf| leaf.len() % 2 == 1 && !on.contains(&leaf[0]));
        match (is_inside, on.is_empty()) {
            (true, _) => Side::Inside,
            (false, false) => Side::Surface,
            (false, true) => Side::Outside,
        }
    }

    /// Whether a point is in a closed mesh or on one.
    #[must_use]
    pub fn contains(&self, point: [f64; 3], mask: u32) -> bool {
        self.side(point, mask) != Side::Outside
    }

    /// The distance to the nearest surface, negative inside of closed meshes; NaN of a point that is not finite.
    #[must_use]
    pub fn signed_distance(&self, point: [f64; 3], mask: u32) -> f64 {
        if point.iter().any(|x| !x.is_finite()) {
            return f64::NAN;
        }
        let nearest = self.closest_point(point, f64::INFINITY, mask);
        let distance = nearest.map_or(f64::INFINITY, |nearest| nearest.distance);
        match self.side(point, mask) {
            Side::Outside => distance,
            Side::Surface => 0.0,
            Side::Inside => -distance,
        }
    }

    /// [`closest_point`](Self::closest_point) of many points.
    #[must_use]
    pub fn closest_points(
        &self,
        points: &[[f64; 3]],
        radius: f64,
        mask: u32,
        threads: Threads,
    ) -> Vec<Option<DoublePoint>> {
        each(points, threads, |point| self.closest_point(*point, radius, mask))
    }

    /// [`contains`](Self::contains) of many points.
    #[must_use]
    pub fn contains_batch(&self, points: &[[f64; 3]], mask: u32, threads: Threads) -> Vec<bool> {
        each(points, threads, |point| self.contains(*point, mask))
    }

    /// [`signed_distance`](Self::signed_distance) of many points.
    #[must_use]
    pub fn signed_distance_batch(&self, points: &[[f64; 3]], mask: u32, threads: Threads) -> Vec<f64> {
        each(points, threads, |point| self.signed_distance(*point, mask))
    }
}
