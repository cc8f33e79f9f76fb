// SPDX-License-Identifier: GPL-3.0-or-later
//! Discs in leaf blocks of eight: with normals, or facing each ray. Lanes compare the ray with the spheres around them; the
//! plane is met in double precision. Space: object. Tests: `tests/discs.rs` of `gnurt-accel`.

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe, on_disc, through_disc};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::slab::SLACK;
use gnurt_accel_core::store::{StoredRecord, get_floats, put_floats};
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, LARGEST_COORDINATE, Ray};
use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::blocked::{BlockKind, Shared};
use crate::node::WIDTH;

/// Eight discs. Empty lanes have a radius of NaN, and those that face the ray a normal of zero.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct DiscBlock {
    /// Centres, then normals.
    rows: [[f32; WIDTH]; 6],
    radius: [f32; WIDTH],
    /// Numbers in the object.
    numbers: [u32; WIDTH],
}

/// Centre, radius and normal.
type Disc = ([f32; 3], f32, Option<[f32; 3]>);

impl DiscBlock {
    fn disc(&self, lane: usize) -> Disc {
        let at = |first: usize| [0, 1, 2].map(|k| self.rows[first + k][lane]);
        let normal = at(3);
        (at(0), self.radius[lane], (normal != [0.0; 3]).then_some(normal))
    }
}

impl BlockKind for DiscBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Ok([6, 7]);
    type Item = Disc;
    type Data = ();
    type Waiting = ();
    /// The inverse square of the direction, and by how much spheres are larger.
    type Ready<S: Simd> = [f32x8<S>; 2];

    fn is_kind_of(kind: &GeometryKind) -> bool {
        matches!(kind, GeometryKind::Discs(_))
    }

    fn data(_: &GeometryKind) {}

    fn items(kind: &GeometryKind, prim_id: u32, bad: &mut BadPrimitives, each: &mut dyn FnMut(Disc)) {
        let GeometryKind::Discs(discs) = kind else { return };
        let i = prim_id as usize;
        let (center, radius, normal) = (discs.centers[i], discs.radii[i], discs.normals.map(|all| all[i]));
        match bad.fault(center.into_iter().chain([radius]).chain(normal.into_iter().flatten())) {
            Some(fault) => *fault += 1,
            None if radius <= 0.0 || normal == Some([0.0; 3]) => bad.zero_area += 1,
            None => each((center, radius, normal)),
        }
    }

    /// One float more on either side covers the rounding.
    fn bounds(&(center, radius, normal): &Disc) -> Aabb {
        let normal = normal.map_or([0.0; 3], |normal| normal.map(f64::from));
        let square = normal.iter().map(|x| x * x).sum::<f64>();
        let half = [0, 1, 2].map(|k: usize| {
            // A disc reaches less far along its normal.
            let share = if square > 0.0 { 1.0 - normal[k] * normal[k] / square } else { 1.0 };
            ((f64::from(radius) * share.max(0.0).sqrt()) as f32).next_up()
        });
        Aabb {
            min: [0, 1, 2].map(|k| (center[k] - half[k]).next_down()),
            max: [0, 1, 2].map(|k| (center[k] + half[k]).next_up()),
        }
    }

    fn empty() -> Self {
        Self { rows: [[0.0; WIDTH]; 6], radius: [f32::NAN; WIDTH], numbers: [INVALID_ID; WIDTH] }
    }

    fn set(&mut self, lane: usize, &(center, radius, normal): &Disc, number: u32) {
        let floats = center.into_iter().chain(normal.unwrap_or_default());
        self.rows.iter_mut().zip(floats).for_each(|(row, x)| row[lane] = x);
        (self.radius[lane], self.numbers[lane]) = (radius, number);
    }

    fn numbers(&self) -> &[u32; WIDTH] {
        &self.numbers
    }

    #[inline(always)]
    fn ready<S: Simd>(simd: S, ray: &Ray, greatest: f32) -> [f32x8<S>; 2] {
        let (org, dir) = (ray.org, ray.dir);
        let away = org[0].abs().max(org[1].abs()).max(org[2].abs());
        let square = dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2];
        [f32x8::splat(simd, 1.0 / square), f32x8::splat(simd, SLACK * (2.0 * greatest + away))]
    }

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        [over, slack]: &[f32x8<S>; 2],
        _: &Shared<Self>,
        traversal: &mut RayTraversal,
    ) -> u64 {
        let RayTraversal { ray, slot, .. } = *traversal;
        let at = |value: f32| f32x8::splat(simd, value);
        let row = |values: &[f32; WIDTH]| f32x8::from_slice(simd, values);
        let from = [0, 1, 2].map(
            #[inline(always)]
            |k: usize| at(ray.org[k]) - row(&self.rows[k]),
        );
        let dir = [at(ray.dir[0]), at(ray.dir[1]), at(ray.dir[2])];
        let nearest = (from[0] * dir[0] + from[1] * dir[1] + from[2] * dir[2]) * *over;
        let across = [from[0] - nearest * dir[0], from[1] - nearest * dir[1], from[2] - nearest * dir[2]];
        let off = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
        let reach = row(&self.radius) + *slack;
        let mut bits = off.simd_le(reach * reach).to_bitmask();
        let line = [ray.org.map(f64::from), ray.dir.map(f64::from)];
        while bits != 0 {
            let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
            bits &= bits - 1;
            let (center, radius, normal) = self.disc(lane);
            let Some(t) = through_disc(line, center, radius, normal).map(|t| t as f32) else { continue };
            if t >= ray.t_near && t <= traversal.reach() {
                traversal.offer(TriangleHit { t: t + 0.0, u: 0.0, v: 0.0 }, self.numbers[lane], slot);
            }
        }
        WIDTH as u64
    }

    fn near(&self, lane: usize, _: &Shared<Self>, probe: &Probe, slot: u32, nearest: &mut dyn NearestPoint) {
        let (center, radius, normal) = self.disc(lane);
        nearest.offer(on_disc(probe, center, radius, normal), [0.0; 2], self.numbers[lane], slot);
    }

    fn primitive(&self, lane: usize, _: usize, _: &Shared<Self>) -> Primitive<'_> {
        let (center, radius, normal) = self.disc(lane);
        Primitive::Disc(center, radius, normal)
    }

    fn is_sound(&self, lane: usize, _: &Shared<Self>, count: u32) -> bool {
        let (number, radius) = (self.numbers[lane], self.radius[lane]);
        let near = self.rows.iter().all(|row| row[lane].abs() <= LARGEST_COORDINATE);
        let nothing = number == INVALID_ID && radius.is_nan();
        near && (nothing || number < count && radius > 0.0 && radius <= LARGEST_COORDINATE)
    }
}

impl StoredRecord for DiscBlock {
    const LENGTH: usize = 8 * WIDTH;

    fn put(&self, data: &mut [u32]) {
        let (rows, rest) = data.split_at_mut(6 * WIDTH);
        let (radii, numbers) = rest.split_at_mut(WIDTH);
        put_floats(rows, self.rows.as_flattened());
        put_floats(radii, &self.radius);
        numbers.copy_from_slice(&self.numbers);
    }

    fn get(data: &[u32]) -> Self {
        let mut block = Self::empty();
        let (rows, rest) = data.split_at(6 * WIDTH);
        let (radii, numbers) = rest.split_at(WIDTH);
        get_floats(block.rows.as_flattened_mut(), rows);
        get_floats(&mut block.radius, radii);
        block.numbers.copy_from_slice(numbers);
        block
    }
}
