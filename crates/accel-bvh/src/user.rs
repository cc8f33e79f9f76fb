// SPDX-License-Identifier: GPL-3.0-or-later
//! User geometry in leaf blocks of eight, tested one by one by the caller's code.
//! Space: object. Tests: `tests/mixed.rs`.

use std::io::{self, Read, Write};
use std::sync::Arc;

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer};
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, Ray, UserGeometry};
use gnurt_simd::Simd;

use crate::blocked::{BlockData, BlockKind, Shared, lanes};
use crate::node::WIDTH;

/// Numbers in the object.
#[derive(Clone, Debug)]
pub struct UserBlock(pub(crate) [u32; WIDTH]);

impl BlockKind for UserBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Err("user geometry cannot be saved");
    type Item = Aabb;
    type Data = Arc<dyn UserGeometry>;
    type Waiting = ();
    type Ready<S: Simd> = ();

    fn is_kind_of(kind: &GeometryKind) -> bool {
        matches!(kind, GeometryKind::User(_))
    }

    fn data(kind: &GeometryKind) -> Self::Data {
        match kind {
            GeometryKind::User(user) => Arc::clone(user),
            _ => unreachable!("a geometry of another kind"),
        }
    }

    fn items(kind: &GeometryKind, prim_id: u32, bad: &mut BadPrimitives, each: &mut dyn FnMut(Aabb)) {
        let GeometryKind::User(user) = kind else { return };
        let bounds = user.bounds(prim_id);
        if bounds.is_empty() {
            bad.zero_area += 1;
        } else if let Some(fault) = bad.fault(bounds.min.into_iter().chain(bounds.max)) {
            *fault += 1;
        } else {
            each(bounds);
        }
    }

    fn bounds(item: &Aabb) -> Aabb {
        *item
    }

    fn empty() -> Self {
        Self([INVALID_ID; WIDTH])
    }

    fn set(&mut self, lane: usize, _: &Aabb, number: u32) {
        self.0[lane] = number;
    }

    fn numbers(&self) -> &[u32; WIDTH] {
        &self.0
    }

    #[inline(always)]
    fn ready<S: Simd>(_: S, _: &Ray, _: f32) {}

    #[inline(always)]
    fn meet<S: Simd>(&self, _: S, (): &(), shared: &Shared<Self>, traversal: &mut RayTraversal) -> u64 {
        self.test(shared, traversal)
    }

    fn near(
        &self,
        lane: usize,
        shared: &Shared<Self>,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    ) {
        let (user, prim_id) = shared.of(self.0[lane]);
        if let Some(found) = user.closest_point(prim_id, probe.point.map(|x| x as f32)) {
            nearest.offer(probe.offset(found.map(f64::from)), [0.0; 2], self.0[lane], slot);
        }
    }

    fn primitive<'a>(&'a self, lane: usize, _: usize, shared: &'a Shared<Self>) -> Primitive<'a> {
        let (user, prim_id) = shared.of(self.0[lane]);
        Primitive::User(&**user, prim_id)
    }

    fn is_sound(&self, _: usize, _: &Shared<Self>, _: u32) -> bool {
        false
    }
}

impl UserBlock {
    /// Calls the tests of its primitives. Returns how many there were.
    #[inline(never)]
    pub(crate) fn test(&self, shared: &Shared<Self>, traversal: &mut RayTraversal) -> u64 {
        let RayTraversal { ray, slot, .. } = *traversal;
        let mut tested = 0;
        for (_, number) in lanes(self) {
            if traversal.is_done() {
                break;
            }
            tested += 1;
            let (user, prim_id) = shared.of(number);
            let visits = Ray { t_far: traversal.reach(), ..*ray };
            user.intersect(prim_id, &visits, &mut |hit| {
                if hit.t >= ray.t_near && hit.t <= traversal.reach() {
                    let triangle_hit = TriangleHit { t: hit.t + 0.0, u: hit.u, v: hit.v };
                    traversal.offer(triangle_hit, number, slot);
                }
            });
        }
        tested
    }
}

impl BlockData for Arc<dyn UserGeometry> {
    fn save(&self, _: &mut Writer<'_, impl Write>) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn load(_: &mut Reader<'_, impl Read>) -> Result<Self, LoadError> {
        Err(LoadError::Damaged("user geometry in a file"))
    }
}

impl StoredRecord for UserBlock {
    const LENGTH: usize = WIDTH;

    fn put(&self, data: &mut [u32]) {
        data.copy_from_slice(&self.0);
    }

    fn get(data: &[u32]) -> Self {
        let mut block = Self::empty();
        block.0.copy_from_slice(data);
        block
    }
}
