// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves in leaf blocks of eight pieces. Lanes compare the ray with a capsule around each piece. Pieces that it may meet
//! are tested one by one, in double precision, from the vertices that all curves of a geometry share.
//! Source: pieces in place of oriented boxes, which [WBW*14] has in nodes. Space: object.
//! Invariant: a capsule holds all hits of its piece. Tests: `tests/curves.rs` of `gnurt-accel`.

mod block;
mod store;
mod waiting;

use std::ops::Range;
use std::sync::Arc;

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::curve::{CurveBasis, CurvePiece, OwnedCurves, RayFrame, Rough, RoughRay};
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::slab::SLACK;
use gnurt_accel_core::traversal::{RayKind, RayTraversal};
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, FARTHEST_PLANE, INVALID_ID, Ray};
use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::blocked::{BlockKind, Shared};
use crate::node::WIDTH;
pub(crate) use block::{CurveBlock, ReadyRay};
use block::{MOST_STEPS, part, piece_at, splat};
use waiting::MOST_WAIT;
pub(crate) use waiting::Waiting;

impl BlockKind for CurveBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Ok([8, 9]);
    const ANY_ORDER: bool = true;
    const TWO_FIRST: bool = true;
    type Item = CurvePiece;
    type Data = Arc<OwnedCurves>;
    type Waiting = Waiting;
    type Ready<S: Simd> = ReadyRay<S>;

    /// Straight curves lose by it.
    #[inline(always)]
    fn leaves_wait(shared: &Shared<Self>) -> bool {
        shared.first().is_some_and(|curves| curves.basis != CurveBasis::Linear)
    }

    fn is_kind_of(kind: &GeometryKind) -> bool {
        matches!(kind, GeometryKind::Curves(_))
    }

    fn data(kind: &GeometryKind) -> Self::Data {
        match kind {
            GeometryKind::Curves(curves) => Arc::new(OwnedCurves::new(curves)),
            _ => Arc::default(),
        }
    }

    fn items(kind: &GeometryKind, prim_id: u32, bad: &mut BadPrimitives, each: &mut dyn FnMut(CurvePiece)) {
        let GeometryKind::Curves(curves) = kind else { return };
        if let Some(segment) = curves.check(prim_id, bad) {
            segment.pieces([0.0, 1.0], segment.parts(), each);
        }
    }

    fn bounds(piece: &CurvePiece) -> Aabb {
        piece.bounds
    }

    fn empty() -> Self {
        Self {
            ends: [[0; WIDTH]; 2],
            numbers: [INVALID_ID; WIDTH],
            radius: [0; WIDTH],
            origin: [0.0; 3],
            steps: [0; 4],
        }
    }

    fn frame(&mut self, items: &[Option<&CurvePiece>; WIDTH]) {
        self.count_ends(items);
    }

    fn set(&mut self, lane: usize, piece: &CurvePiece, number: u32) {
        self.put(lane, piece, number);
    }

    fn moved(&self, lane: usize, kind: &GeometryKind, prim_id: u32) -> Option<CurvePiece> {
        let GeometryKind::Curves(curves) = kind else { return None };
        let segment = curves.check(prim_id, &mut BadPrimitives::default())?;
        let [index, count] = piece_at(self.place(lane));
        let mut found = None;
        segment.pieces([0.0, 1.0], u32::from(count), |piece| {
            if piece.index == index {
                found = Some(piece);
            }
        });
        found
    }

    fn numbers(&self) -> &[u32; WIDTH] {
        &self.numbers
    }

    #[inline(always)]
    fn ready<S: Simd>(simd: S, ray: &Ray, greatest: f32) -> ReadyRay<S> {
        let frame = RayFrame::new(ray.org.map(f64::from), ray.dir.map(f64::from));
        let away = ray.org[0].abs().max(ray.org[1].abs()).max(ray.org[2].abs());
        let [x, y, z] = frame.axes;
        ReadyRay {
            frame,
            rough: RoughRay {
                org: splat(simd, frame.org),
                axes: [splat(simd, x), splat(simd, y), splat(simd, z)],
                away,
                length: frame.length as f32,
            },
            slack: f32x8::splat(simd, 2.0 * SLACK * (2.0 * greatest + away)),
        }
    }

    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        ready: &ReadyRay<S>,
        shared: &Shared<Self>,
        traversal: &mut RayTraversal,
    ) -> u64 {
        let mut waiting = Waiting::default();
        Self::meet_leaf(std::slice::from_ref(self), 0..1, simd, ready, shared, &mut waiting, traversal)
            + Self::finish(std::slice::from_ref(self), simd, ready, shared, &mut waiting, traversal)
    }

    #[inline(always)]
    fn meet_leaf<S: Simd>(
        blocks: &[Self],
        leaf: Range<usize>,
        simd: S,
        ready: &ReadyRay<S>,
        shared: &Shared<Self>,
        waiting: &mut Waiting,
        traversal: &mut RayTraversal,
    ) -> u64 {
        let (mut before, mut tested) = (waiting.count, 0);
        for index in leaf {
            let block = &blocks[index];
            let (mut bits, starts) = block.capsules(simd, ready, [traversal.ray.t_near, traversal.reach()]);
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
                bits &= bits - 1;
                if waiting.count == MOST_WAIT {
                    tested += waiting.test(simd, MOST_WAIT, blocks, ready, shared, traversal);
                    before = 0;
                }
                block.prefetch(lane, shared);
                let last = waiting.count & (MOST_WAIT - 1);
                waiting.places[last] = (index * WIDTH + lane) as u32;
                waiting.starts[last] = starts.as_array()[lane];
                waiting.count += 1;
            }
        }
        if before > 0 {
            tested += waiting.test(simd, before, blocks, ready, shared, traversal);
        }
        tested
    }

    #[inline(always)]
    fn finish<S: Simd>(
        blocks: &[Self],
        simd: S,
        ready: &ReadyRay<S>,
        shared: &Shared<Self>,
        waiting: &mut Waiting,
        traversal: &mut RayTraversal,
    ) -> u64 {
        waiting.test(simd, waiting.count, blocks, ready, shared, traversal)
    }

    fn near(
        &self,
        lane: usize,
        shared: &Shared<Self>,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    ) {
        if let Some((segment, part)) = self.segment(lane, shared) {
            let (offset, u) = segment.nearest(probe, part);
            nearest.offer(offset, [u, 0.0], self.numbers[lane], slot);
        }
    }

    fn primitive<'a>(&'a self, lane: usize, _: usize, shared: &'a Shared<Self>) -> Primitive<'a> {
        let (curves, prim_id) = shared.of(self.numbers[lane]);
        Primitive::Curve(curves, prim_id, part(self.place(lane)))
    }

    fn is_sound(&self, lane: usize, shared: &Shared<Self>, count: u32) -> bool {
        let (number, radius, place) = (self.numbers[lane], self.radius[lane], self.place(lane));
        let is_size = |x: f32| (0.0..=FARTHEST_PLANE).contains(&x);
        let near = self.origin.iter().all(|x| is_size(x.abs()))
            && (0..4).all(|k| is_size(MOST_STEPS as f32 * self.step(k)));
        if number == INVALID_ID {
            return near && radius == 0;
        }
        let is_curve = shared.get(number).is_some_and(|(curves, prim_id)| {
            curves.view().check(prim_id, &mut BadPrimitives::default()).is_some()
        });
        near && number < count && radius > 0 && (1..16).contains(&place) && is_curve
    }
}

impl CurveBlock {
    /// Offers the hits of one piece. A function of its own, so that it is compiled once for each level.
    #[inline(never)]
    pub(super) fn meet_one<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        ready: &ReadyRay<S>,
        shared: &Shared<Self>,
        slot: u32,
        traversal: &mut RayTraversal,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let (t_near, number) = (traversal.ray.t_near, self.numbers[lane]);
                let Some((curves, prim_id)) = shared.get(number) else { return };
                let (curves, place) = (curves.view(), self.place(lane));
                let radius = f32::from(self.radius[lane]) * self.step(3);
                let is_any = matches!(traversal.kind, RayKind::Any);
                let ends = [t_near, traversal.reach()];
                let which = [prim_id, u32::from(place)];
                match curves.meet_roughly(simd, which, radius, &ready.rough, ends, is_any) {
                    Rough::Missed => return,
                    // Where it is does not matter.
                    Rough::Hit => {
                        return traversal.offer(TriangleHit { t: t_near, u: 0.0, v: 0.0 }, number, slot);
                    }
                    Rough::Unknown => {}
                }
                let are_all = matches!(traversal.kind, RayKind::Each(_));
                curves.meet(prim_id, &ready.frame, part(place), &mut |hit| {
                    let (t, u, v) = (hit.t as f32, hit.u as f32, hit.v as f32);
                    if t >= t_near && t <= traversal.reach() {
                        traversal.offer(TriangleHit { t: t + 0.0, u, v }, number, slot);
                    }
                    t < t_near || are_all
                });
            },
        );
    }
}
