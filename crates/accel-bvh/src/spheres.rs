// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres under a wide BVH: leaf blocks of eight, tested in lanes.
//! Source: [HGA19] for the quadratic: the discriminant from the point of the ray that is nearest to the centre, and the
//! root that cancels from the one that does not. Space: object.
//! Invariant: every level does the same roundings in the same order. The error of the test, about ten units of 2^-24
//! across the ray, is within the slack of boxes (`slab.rs`). Tests: `tests/mixed.rs`.

mod store;

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::geometry::{GeometryKind, Numbering};
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{
    Aabb, BadPrimitives, BuildError, Geometry, INVALID_ID, Memory, Quality, Ray, Threads, TreeStats,
};
use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::blocked::Blocked;
use crate::node::{Child, WIDTH};
use crate::node_ray::NodeRay;
use crate::primitives::Primitives;
use crate::walk::walk;

/// Eight spheres. Lanes that are left over have a radius of NaN, which no ray meets.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct SphereBlock {
    pub(crate) center: [[f32; WIDTH]; 3],
    pub(crate) radius: [f32; WIDTH],
    /// Numbers in the object.
    pub(crate) numbers: [u32; WIDTH],
}

/// Tree and spheres.
#[derive(Clone, Debug)]
pub struct SphereIndex(pub(crate) Blocked<SphereBlock>);

/// The spheres that can be traced.
struct Gathered {
    spheres: Vec<([f32; 3], f32)>,
    numbers: Vec<u32>,
}

impl Primitives for Gathered {
    fn count(&self) -> usize {
        self.spheres.len()
    }

    fn bounds(&self, i: usize) -> Aabb {
        let (center, radius) = self.spheres[i];
        sphere_box(center, radius)
    }
}

/// The box around a sphere. One float more on either side covers the rounding.
pub(crate) fn sphere_box(center: [f32; 3], radius: f32) -> Aabb {
    let side = |k: usize, sign: f32| center[k] + sign * radius;
    Aabb { min: [0, 1, 2].map(|k| side(k, -1.0).next_down()), max: [0, 1, 2].map(|k| side(k, 1.0).next_up()) }
}

impl SphereIndex {
    /// Over the spheres of the accepted geometries; untraceable ones are counted.
    ///
    /// # Errors
    /// There are too many.
    pub fn build(
        geometries: &[Geometry],
        numbering: &Numbering,
        accept: impl Fn(&Geometry) -> bool,
        bad: &mut BadPrimitives,
        quality: Quality,
        memory: Memory,
        threads: Threads,
    ) -> Result<Self, BuildError> {
        let mut gathered = Gathered { spheres: Vec::new(), numbers: Vec::new() };
        for (i, geometry) in geometries.iter().enumerate().filter(|(_, geometry)| accept(geometry)) {
            let GeometryKind::Spheres(spheres) = &geometry.kind else { continue };
            let each = spheres.centers.iter().zip(spheres.radii);
            for (number, (&center, &radius)) in numbering.range(i).zip(each) {
                let fault = bad.fault(center.into_iter().chain([radius]));
                match fault {
                    Some(fault) => *fault += 1,
                    None if radius <= 0.0 => bad.zero_area += 1,
                    None => {
                        gathered.spheres.push((center, radius));
                        gathered.numbers.push(number);
                    }
                }
            }
        }
        let block = |indices: &[u32; WIDTH]| {
            let mut block = SphereBlock {
                center: [[0.0; WIDTH]; 3],
                radius: [f32::NAN; WIDTH],
                numbers: [INVALID_ID; WIDTH],
            };
            for (lane, &sphere) in indices.iter().enumerate().filter(|&(_, &sphere)| sphere != INVALID_ID) {
                let (center, radius) = gathered.spheres[sphere as usize];
                for (row, x) in block.center.iter_mut().zip(center) {
                    row[lane] = x;
                }
                block.radius[lane] = radius;
                block.numbers[lane] = gathered.numbers[sphere as usize];
            }
            block
        };
        Ok(Self(Blocked::build(&gathered, quality, memory, threads, block)?))
    }

    /// Box around all spheres.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    /// Size and shape.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.0.stats()
    }

    /// Offers the ray's hits; it is valid and regular, the tree not empty.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(&self, simd: S, traversal: &mut RayTraversal) {
        let RayTraversal { ray, slot, .. } = *traversal;
        let Blocked { tree, blocks: spheres, greatest, .. } = &self.0;
        let for_nodes = NodeRay::new(simd, ray, *greatest);
        let at = |value: f32| f32x8::splat(simd, value);
        let (org, dir) = (ray.org, ray.dir);
        let square = dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2];
        let over = 1.0 / square;
        let mut tested = 0;
        let visited = walk(
            tree,
            simd,
            Child::node(0),
            &for_nodes,
            traversal.reach(),
            #[inline(always)]
            |blocks| {
                for block in &spheres[blocks] {
                    tested += 1;
                    let row = |values: &[f32; WIDTH]| f32x8::from_slice(simd, values);
                    let radius = row(&block.radius);
                    let from = [
                        at(org[0]) - row(&block.center[0]),
                        at(org[1]) - row(&block.center[1]),
                        at(org[2]) - row(&block.center[2]),
                    ];
                    // The point of the ray nearest to the centre, and the remaining distance across it.
                    let along = from[0] * at(dir[0]) + from[1] * at(dir[1]) + from[2] * at(dir[2]);
                    let nearest = along * at(over);
                    let across = [
                        from[0] - nearest * at(dir[0]),
                        from[1] - nearest * at(dir[1]),
                        from[2] - nearest * at(dir[2]),
                    ];
                    let off = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
                    let left = radius * radius - off;
                    let mut bits = left.simd_ge(at(0.0)).to_bitmask();
                    if bits == 0 {
                        continue;
                    }
                    while bits != 0 {
                        let i = bits.trailing_zeros() as usize & (WIDTH - 1);
                        bits &= bits - 1;
                        for t in roots(ray, [0, 1, 2].map(|k| block.center[k][i]), block.radius[i]) {
                            if t >= ray.t_near && t <= traversal.reach() {
                                traversal.offer(
                                    TriangleHit { t: t + 0.0, u: 0.0, v: 0.0 },
                                    block.numbers[i],
                                    slot,
                                );
                            }
                        }
                    }
                }
                traversal.reach()
            },
        );
        traversal.counters.nodes += u64::from(visited);
        traversal.counters.triangles += tested * WIDTH as u64;
    }
}

/// Both parameters of the hits of a ray with a sphere, ascending: roots of `a t^2 + 2 b t + c`, the one
/// farther from zero first. In double precision: a float loses the distance from the surface of a huge
/// sphere, and few spheres come here.
#[inline(always)]
fn roots(ray: &Ray, center: [f32; 3], radius: f32) -> [f32; 2] {
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let from = |k: usize| f64::from(ray.org[k]) - f64::from(center[k]);
    let (from, dir, r) = ([from(0), from(1), from(2)], ray.dir.map(f64::from), f64::from(radius));
    let (a, b, c) = (dot(dir, dir), dot(from, dir), dot(from, from) - r * r);
    let across = [0, 1, 2].map(|k| from[k] - b / a * dir[k]);
    let root = (a * (r * r - dot(across, across)).max(0.0)).sqrt();
    let q = if b < 0.0 { root - b } else { -root - b };
    // 0 / 0, where a ray starts on the sphere and along it, is no number; the other root is zero, too.
    let (one, two) = ((c / q) as f32, (q / a) as f32);
    [one.min(two), one.max(two)]
}

impl PartialEq for SphereIndex {
    fn eq(&self, other: &Self) -> bool {
        let bits = |index: &Self| {
            index
                .0
                .blocks
                .iter()
                .map(|b| (b.center, b.radius.map(f32::to_bits), b.numbers))
                .collect::<Vec<_>>()
        };
        self.0.tree == other.0.tree && bits(self) == bits(other)
    }
}
