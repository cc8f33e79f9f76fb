// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves in leaf blocks of eight pieces. Lanes compare the ray with a capsule around each piece. Pieces that it may meet
//! are tested one by one, in double precision, from the vertices that all curves of a geometry share.
//! Source: pieces in place of oriented boxes, which [WBW*14] has in nodes. Space: object.
//! Invariant: a capsule holds all hits of its piece. In lanes it is larger by twice the slack of boxes (`slab.rs`): the
//! rounding of both its ends, seen along the ray, is below half of that. Tests: `tests/curves.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};
use std::sync::Arc;

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::curve::{CurveBasis, CurveForm, CurvePiece, OwnedCurves, RayFrame, Segment};
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::slab::SLACK;
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer, get_floats, put_floats};
use gnurt_accel_core::traversal::{RayKind, RayTraversal};
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, FARTHEST_PLANE, INVALID_ID, Ray};
use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::blocked::{BlockData, BlockKind, Shared};
use crate::node::WIDTH;

/// Eight pieces: capsules around them, and their places on the curves.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct CurveBlock {
    ends: [[[f32; WIDTH]; 3]; 2],
    /// Negative in empty lanes.
    radius: [f32; WIDTH],
    /// Numbers in the object.
    numbers: [u32; WIDTH],
    /// The number of pieces of the curve, then that of this one, in 16 bits each.
    pieces: [u32; WIDTH],
}

/// The parameters between which a piece lies.
fn part(index: u32, count: u32) -> [f64; 2] {
    [f64::from(index) / f64::from(count), f64::from(index + 1) / f64::from(count)]
}

/// A ray, and it in lanes.
#[derive(Clone, Copy)]
pub struct ReadyRay<S: Simd> {
    frame: RayFrame,
    org: [f32x8<S>; 3],
    axes: [[f32x8<S>; 3]; 3],
    slack: f32x8<S>,
}

#[inline(always)]
fn splat<S: Simd>(simd: S, [x, y, z]: [f64; 3]) -> [f32x8<S>; 3] {
    [f32x8::splat(simd, x as f32), f32x8::splat(simd, y as f32), f32x8::splat(simd, z as f32)]
}

/// Points by the axes of a ray. A function: operations in a closure that is not inlined would all be calls.
#[inline(always)]
fn seen<S: Simd>(simd: S, ray: &ReadyRay<S>, [x, y, z]: &[[f32; WIDTH]; 3]) -> [f32x8<S>; 3] {
    let x = f32x8::from_slice(simd, x) - ray.org[0];
    let y = f32x8::from_slice(simd, y) - ray.org[1];
    let z = f32x8::from_slice(simd, z) - ray.org[2];
    let mut seen = ray.org;
    for (row, axis) in seen.iter_mut().zip(&ray.axes) {
        *row = x.mul_add(axis[0], y.mul_add(axis[1], z * axis[2]));
    }
    seen
}

impl CurveBlock {
    /// A lane's curve, and its piece.
    fn segment(&self, lane: usize, shared: &Shared<Self>) -> Option<(Segment, [f64; 2])> {
        let (curves, prim_id) = shared.get(self.numbers[lane])?;
        let [count, index] = [self.pieces[lane] >> 16, self.pieces[lane] & 0xffff];
        Some((curves.segment(prim_id)?, part(index, count)))
    }

    /// Lanes whose capsules the ray may meet within `[near, far]`, as bits.
    #[inline(always)]
    fn capsules<S: Simd>(&self, simd: S, ray: &ReadyRay<S>, [near, far]: [f32; 2]) -> u32 {
        let [a, b] = [seen(simd, ray, &self.ends[0]), seen(simd, ray, &self.ends[1])];
        let radius = f32x8::from_slice(simd, &self.radius) + ray.slack;
        let step = [b[0] - a[0], b[1] - a[1]];
        let square = step[0].mul_add(step[0], step[1] * step[1]).max(f32x8::splat(simd, f32::MIN_POSITIVE));
        let t = (-(a[0].mul_add(step[0], a[1] * step[1])) / square).max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, 1.0));
        let off = [t.mul_add(step[0], a[0]), t.mul_add(step[1], a[1])];
        let is_near = off[0].mul_add(off[0], off[1] * off[1]).simd_le(radius * radius);
        let length = ray.frame.length as f32;
        let is_before = (a[2].min(b[2]) - radius).simd_le(f32x8::splat(simd, far * length));
        let is_behind = (a[2].max(b[2]) + radius).simd_ge(f32x8::splat(simd, near * length));
        let is_there = f32x8::from_slice(simd, &self.radius).simd_ge(f32x8::splat(simd, 0.0));
        (is_near & is_before & is_behind & is_there).to_bitmask() as u32
    }
}

impl BlockKind for CurveBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Ok([8, 9]);
    type Item = CurvePiece;
    type Data = Arc<OwnedCurves>;
    type Ready<S: Simd> = ReadyRay<S>;

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
        let (ends, radius) = ([[[0.0; WIDTH]; 3]; 2], [-1.0; WIDTH]);
        Self { ends, radius, numbers: [INVALID_ID; WIDTH], pieces: [0; WIDTH] }
    }

    fn set(&mut self, lane: usize, piece: &CurvePiece, number: u32) {
        for (rows, end) in self.ends.iter_mut().zip(piece.ends) {
            for (row, x) in rows.iter_mut().zip(end) {
                row[lane] = x;
            }
        }
        self.radius[lane] = piece.radius;
        (self.numbers[lane], self.pieces[lane]) =
            (number, u32::from(piece.count) << 16 | u32::from(piece.index));
    }

    fn moved(&self, lane: usize, kind: &GeometryKind, prim_id: u32) -> Option<CurvePiece> {
        let GeometryKind::Curves(curves) = kind else { return None };
        let segment = curves.check(prim_id, &mut BadPrimitives::default())?;
        let mut found = None;
        segment.pieces([0.0, 1.0], self.pieces[lane] >> 16, |piece| {
            if u32::from(piece.index) == self.pieces[lane] & 0xffff {
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
            org: splat(simd, frame.org),
            axes: [splat(simd, x), splat(simd, y), splat(simd, z)],
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
        let RayTraversal { ray, slot, .. } = *traversal;
        let mut bits = self.capsules(simd, ready, [ray.t_near, traversal.reach()]);
        let mut tested = 0;
        while bits != 0 && !traversal.is_done() {
            let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
            bits &= bits - 1;
            tested += 1;
            self.meet_one(lane, &ready.frame, shared, slot, traversal);
        }
        tested
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

    fn primitive<'a>(&'a self, lane: usize, shared: &'a Shared<Self>) -> Primitive<'a> {
        let (curves, prim_id) = shared.of(self.numbers[lane]);
        Primitive::Curve(curves, prim_id, part(self.pieces[lane] & 0xffff, self.pieces[lane] >> 16))
    }

    fn is_sound(&self, lane: usize, shared: &Shared<Self>, count: u32) -> bool {
        let (number, radius) = (self.numbers[lane], self.radius[lane]);
        let near = self.ends.as_flattened().iter().all(|row| row[lane].abs() <= FARTHEST_PLANE);
        if number == INVALID_ID {
            return near && radius < 0.0;
        }
        let [pieces, index] = [self.pieces[lane] >> 16, self.pieces[lane] & 0xffff];
        let is_curve = shared.get(number).is_some_and(|(curves, prim_id)| {
            curves.view().check(prim_id, &mut BadPrimitives::default()).is_some()
        });
        near && number < count && (0.0..=FARTHEST_PLANE).contains(&radius) && index < pieces && is_curve
    }
}

impl CurveBlock {
    /// Offers the hits of one piece. Compiled once: few pieces come here.
    #[inline(never)]
    fn meet_one(
        &self,
        lane: usize,
        frame: &RayFrame,
        shared: &Shared<Self>,
        slot: u32,
        traversal: &mut RayTraversal,
    ) {
        let Some((segment, part)) = self.segment(lane, shared) else { return };
        let (t_near, number) = (traversal.ray.t_near, self.numbers[lane]);
        let are_all = matches!(traversal.kind, RayKind::Each(_));
        segment.meet(frame, part, &mut |hit| {
            let [t, u, v] = [hit.t, hit.u, hit.v].map(|x| x as f32);
            if t >= t_near && t <= traversal.reach() {
                traversal.offer(TriangleHit { t: t + 0.0, u, v }, number, slot);
            }
            t < t_near || are_all
        });
    }
}

impl BlockData for Arc<OwnedCurves> {
    fn memory_bytes(&self) -> usize {
        OwnedCurves::memory_bytes(self)
    }

    fn save(&self, writer: &mut Writer<'_, impl Write>) -> io::Result<()> {
        let flags = self.basis as u64 | (self.form as u64) << 8 | u64::from(self.is_seen_from_outside) << 16;
        let flags = flags | u64::from(self.pieces) << 24;
        writer.number(flags)?;
        writer.list(self.vertices.as_flattened())?;
        writer.list(&self.indices)?;
        writer.list(self.tangents.as_flattened())?;
        writer.list(self.normals.as_flattened())?;
        writer.list(self.normal_tangents.as_flattened())?;
        writer.list(&self.joints.iter().map(|&bits| u32::from(bits)).collect::<Vec<_>>())
    }

    fn load(reader: &mut Reader<'_, impl Read>) -> Result<Self, LoadError> {
        const BASES: [CurveBasis; 5] = [
            CurveBasis::Linear,
            CurveBasis::Bezier,
            CurveBasis::BSpline,
            CurveBasis::CatmullRom,
            CurveBasis::Hermite,
        ];
        const FORMS: [CurveForm; 3] = [CurveForm::Flat, CurveForm::Round, CurveForm::Oriented];
        let flags = reader.number()?;
        let basis = BASES.get(flags as usize & 0xff);
        let form = FORMS.get(flags as usize >> 8 & 0xff);
        let (Some(&basis), Some(&form)) = (basis, form) else {
            return Err(LoadError::Damaged("curves of no kind"));
        };
        let mut floats = || reader.list::<f32>(u32::MAX as usize);
        let vertices = floats()?.as_chunks().0.to_vec();
        let indices = reader.list(u32::MAX as usize)?;
        let mut floats = || reader.list::<f32>(u32::MAX as usize);
        let tangents = floats()?.as_chunks().0.to_vec();
        let normals = floats()?.as_chunks().0.to_vec();
        let normal_tangents = floats()?.as_chunks().0.to_vec();
        let joints: Vec<u32> = reader.list(u32::MAX as usize)?;
        Ok(Self::new(OwnedCurves {
            basis,
            form,
            vertices,
            indices,
            tangents,
            normals,
            normal_tangents,
            joints: joints.into_iter().map(|bits| bits as u8).collect(),
            is_seen_from_outside: flags >> 16 & 1 != 0,
            pieces: (flags >> 24) as u8,
        }))
    }
}

impl StoredRecord for CurveBlock {
    const LENGTH: usize = 9 * WIDTH;

    fn put(&self, data: &mut [u32]) {
        let (ends, rest) = data.split_at_mut(6 * WIDTH);
        let (radii, rest) = rest.split_at_mut(WIDTH);
        let (numbers, pieces) = rest.split_at_mut(WIDTH);
        put_floats(ends, self.ends.as_flattened().as_flattened());
        put_floats(radii, &self.radius);
        numbers.copy_from_slice(&self.numbers);
        pieces.copy_from_slice(&self.pieces);
    }

    fn get(data: &[u32]) -> Self {
        let mut block = Self::empty();
        let (ends, rest) = data.split_at(6 * WIDTH);
        let (radii, rest) = rest.split_at(WIDTH);
        let (numbers, pieces) = rest.split_at(WIDTH);
        get_floats(block.ends.as_flattened_mut().as_flattened_mut(), ends);
        get_floats(&mut block.radius, radii);
        block.numbers.copy_from_slice(numbers);
        block.pieces.copy_from_slice(pieces);
        block
    }
}
