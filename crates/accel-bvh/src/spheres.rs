// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres in leaf blocks of eight, tested in lanes.
//! Source: [HGA19] for the quadratic: the discriminant from the point of the ray that is nearest to the centre, and the
//! root that cancels from the one that does not. Space: object.
//! Invariant: every level does the same roundings in the same order. The error of the test, about ten units of 2^-24
//! across the ray, is within the slack of boxes (`slab.rs`). Tests: `tests/mixed.rs`.

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe, on_sphere, through_sphere};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::store::{StoredRecord, get_floats, put_floats};
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, LARGEST_COORDINATE, Ray};
use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::blocked::{BlockKind, Shared};
use crate::node::WIDTH;

/// Eight spheres. Lanes that are left over have a radius of NaN, which no ray meets; spheres that are hit from outside only
/// have a negative one.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct SphereBlock {
    center: [[f32; WIDTH]; 3],
    radius: [f32; WIDTH],
    /// Numbers in the object.
    numbers: [u32; WIDTH],
}

impl SphereBlock {
    fn sphere(&self, lane: usize) -> ([f32; 3], f32) {
        ([0, 1, 2].map(|k: usize| self.center[k][lane]), self.radius[lane].abs())
    }
}

impl BlockKind for SphereBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Ok([3, 5]);
    type Item = ([f32; 3], f32);
    type Data = ();
    type Waiting = ();
    /// The inverse square of the direction.
    type Ready<S: Simd> = f32x8<S>;

    fn is_kind_of(kind: &GeometryKind) -> bool {
        matches!(kind, GeometryKind::Spheres(_) | GeometryKind::SphereOutsides(_))
    }

    fn data(_: &GeometryKind) {}

    fn items(kind: &GeometryKind, prim_id: u32, bad: &mut BadPrimitives, each: &mut dyn FnMut(Self::Item)) {
        let (GeometryKind::Spheres(spheres) | GeometryKind::SphereOutsides(spheres)) = kind else { return };
        let sign = if matches!(kind, GeometryKind::Spheres(_)) { 1.0 } else { -1.0 };
        let (center, radius) = (spheres.centers[prim_id as usize], spheres.radii[prim_id as usize]);
        match bad.fault(center.into_iter().chain([radius])) {
            Some(fault) => *fault += 1,
            None if radius <= 0.0 => bad.zero_area += 1,
            None => each((center, sign * radius)),
        }
    }

    /// One float more on either side covers the rounding.
    fn bounds(&(center, radius): &Self::Item) -> Aabb {
        let side = |k: usize, sign: f32| center[k] + sign * radius.abs();
        Aabb {
            min: [0, 1, 2].map(|k| side(k, -1.0).next_down()),
            max: [0, 1, 2].map(|k| side(k, 1.0).next_up()),
        }
    }

    fn empty() -> Self {
        let (center, radius) = ([[0.0; WIDTH]; 3], [f32::NAN; WIDTH]);
        Self { center, radius, numbers: [INVALID_ID; WIDTH] }
    }

    fn set(&mut self, lane: usize, &(center, radius): &Self::Item, number: u32) {
        for (row, x) in self.center.iter_mut().zip(center) {
            row[lane] = x;
        }
        (self.radius[lane], self.numbers[lane]) = (radius, number);
    }

    fn numbers(&self) -> &[u32; WIDTH] {
        &self.numbers
    }

    #[inline(always)]
    fn ready<S: Simd>(simd: S, ray: &Ray, _: f32) -> f32x8<S> {
        let dir = ray.dir;
        f32x8::splat(simd, 1.0 / (dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]))
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, over: &f32x8<S>, _: &Shared<Self>, traversal: &mut RayTraversal) -> u64 {
        let RayTraversal { ray, slot, .. } = *traversal;
        let at = |value: f32| f32x8::splat(simd, value);
        let row = |values: &[f32; WIDTH]| f32x8::from_slice(simd, values);
        let (org, dir, radius) = (ray.org, ray.dir, row(&self.radius));
        let from = [
            at(org[0]) - row(&self.center[0]),
            at(org[1]) - row(&self.center[1]),
            at(org[2]) - row(&self.center[2]),
        ];
        // The point of the ray nearest to the centre, and the remaining distance across it.
        let along = from[0] * at(dir[0]) + from[1] * at(dir[1]) + from[2] * at(dir[2]);
        let nearest = along * *over;
        let across =
            [from[0] - nearest * at(dir[0]), from[1] - nearest * at(dir[1]), from[2] - nearest * at(dir[2])];
        let off = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
        let left = radius * radius - off;
        let mut bits = left.simd_ge(at(0.0)).to_bitmask();
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
            bits &= bits - 1;
            let (center, radius) = self.sphere(lane);
            let sides = if self.radius[lane] > 0.0 { 2 } else { 1 };
            for t in through_sphere(ray, center, radius).into_iter().take(sides) {
                if t >= ray.t_near && t <= traversal.reach() {
                    traversal.offer(TriangleHit { t: t + 0.0, u: 0.0, v: 0.0 }, self.numbers[lane], slot);
                }
            }
        }
        WIDTH as u64
    }

    fn near(&self, lane: usize, _: &Shared<Self>, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        let (center, radius) = self.sphere(lane);
        let offset = on_sphere(probe, center.map(f64::from), f64::from(radius));
        nearest.offer(offset, [0.0; 2], self.numbers[lane], slot);
    }

    fn primitive(&self, lane: usize, _: usize, _: &Shared<Self>) -> Primitive<'_> {
        let (center, radius) = self.sphere(lane);
        Primitive::Sphere(center, radius)
    }

    fn is_sound(&self, lane: usize, _: &Shared<Self>, count: u32) -> bool {
        let (number, radius) = (self.numbers[lane], self.radius[lane]);
        let near = self.center.iter().all(|row| row[lane].abs() <= LARGEST_COORDINATE);
        let nothing = number == INVALID_ID && radius.is_nan();
        near && (nothing || number < count && radius != 0.0 && radius.abs() <= LARGEST_COORDINATE)
    }
}

impl StoredRecord for SphereBlock {
    const LENGTH: usize = 5 * WIDTH;

    #[inline(always)]
    fn put(&self, data: &mut [u32]) {
        let (centers, rest) = data.split_at_mut(3 * WIDTH);
        let (radii, numbers) = rest.split_at_mut(WIDTH);
        put_floats(centers, self.center.as_flattened());
        put_floats(radii, &self.radius);
        numbers.copy_from_slice(&self.numbers);
    }

    #[inline(always)]
    fn get(data: &[u32]) -> Self {
        let mut block = Self::empty();
        let (centers, rest) = data.split_at(3 * WIDTH);
        let (radii, numbers) = rest.split_at(WIDTH);
        get_floats(block.center.as_flattened_mut(), centers);
        get_floats(&mut block.radius, radii);
        block.numbers.copy_from_slice(numbers);
        block
    }
}
