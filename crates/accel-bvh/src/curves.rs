// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves in leaf blocks of eight pieces. Lanes compare the ray with a capsule around each piece. Pieces that it may meet
//! are tested one by one, in double precision, from the vertices that all curves of a geometry share.
//! Source: pieces in place of oriented boxes, which [WBW*14] has in nodes. Space: object.
//! Invariant: a capsule holds all hits of its piece. In lanes it is larger by twice the slack of boxes (`slab.rs`): the
//! rounding of both its ends, seen along the ray, is below half of that. Tests: `tests/curves.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};
use std::ops::Range;
use std::sync::Arc;

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::curve::{CurveBasis, CurveForm, CurvePiece, OwnedCurves, RayFrame, Segment};
use gnurt_accel_core::float::{least, most};
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::slab::SLACK;
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer, get_floats, put_floats};
use gnurt_accel_core::traversal::{RayKind, RayTraversal};
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, FARTHEST_PLANE, INVALID_ID, Ray};
use gnurt_simd::{Simd, f32x8, prefetch, prelude::*};

use crate::blocked::{BlockData, BlockKind, Shared};
use crate::node::WIDTH;

/// Eight pieces: capsules around them, and their places on the curves. Two cache lines: ends are counted in steps from an
/// origin of the block, and radii allow for what each end moves by that.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct CurveBlock {
    /// By end and lane: three counts of ten bits; the two above them in both ends are the place on the curve, [`place_of`].
    ends: [[u32; WIDTH]; 2],
    /// Numbers in the object.
    numbers: [u32; WIDTH],
    /// In steps of their own; 0 in empty lanes.
    radius: [u8; WIDTH],
    origin: [f32; 3],
    /// By axis, and that of radii: the upper halves of floats.
    steps: [u16; 4],
}

/// Most steps along an axis.
const MOST_STEPS: f64 = 1023.0;

/// The upper half of the least float with no lower half that is not below `x`.
fn half_above(x: f64) -> u16 {
    let bits = (x as f32).next_up().to_bits();
    ((bits + 0xffff) >> 16) as u16
}

/// The place of piece `index` of `count`, a power of two up to 8, in one byte: that of a node in a heap.
fn place_of(index: u8, count: u8) -> u8 {
    count + index
}

/// Index and count of a place.
fn piece_at(place: u8) -> [u8; 2] {
    let count = 1 << place.max(1).ilog2();
    [place.max(1) - count, count]
}

/// The parameters between which a piece lies.
fn part(place: u8) -> [f64; 2] {
    let [index, count] = piece_at(place);
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

/// Counts along axis `k` as floats.
#[inline(always)]
fn counts<S: Simd>(simd: S, words: &[u32; WIDTH], k: u32) -> f32x8<S> {
    let mut floats = [0.0; WIDTH];
    for (float, &word) in floats.iter_mut().zip(words) {
        *float = (word >> (10 * k) & 1023) as i32 as f32;
    }
    f32x8::from_slice(simd, &floats)
}

/// Bytes as floats.
#[inline(always)]
fn bytes<S: Simd>(simd: S, bytes: &[u8; WIDTH]) -> f32x8<S> {
    let mut floats = [0.0; WIDTH];
    for (float, &byte) in floats.iter_mut().zip(bytes) {
        *float = f32::from(byte);
    }
    f32x8::from_slice(simd, &floats)
}

impl CurveBlock {
    /// A lane's curve, and its piece.
    fn segment(&self, lane: usize, shared: &Shared<Self>) -> Option<(Segment, [f64; 2])> {
        let (curves, prim_id) = shared.get(self.numbers[lane])?;
        Some((curves.segment(prim_id)?, part(self.place(lane))))
    }

    /// Points by the axes of a ray. A function: operations in a closure that is not inlined would all be calls.
    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S, ray: &ReadyRay<S>, end: usize) -> [f32x8<S>; 3] {
        let mut from = ray.org;
        for (k, row) in from.iter_mut().enumerate() {
            let origin = f32x8::splat(simd, self.origin[k]) - *row;
            let step = f32x8::splat(simd, self.step(k));
            *row = counts(simd, &self.ends[end], k as u32).mul_add(step, origin);
        }
        let mut seen = from;
        for (row, axis) in seen.iter_mut().zip(&ray.axes) {
            *row = from[0].mul_add(axis[0], from[1].mul_add(axis[1], from[2] * axis[2]));
        }
        seen
    }

    /// Lanes whose capsules the ray may meet within `[near, far]`, as bits, and the least lengths along the ray.
    #[inline(always)]
    fn capsules<S: Simd>(&self, simd: S, ray: &ReadyRay<S>, [near, far]: [f32; 2]) -> (u32, f32x8<S>) {
        let [a, b] = [self.seen(simd, ray, 0), self.seen(simd, ray, 1)];
        let counts = bytes(simd, &self.radius);
        let radius = counts.mul_add(f32x8::splat(simd, self.step(3)), ray.slack);
        // Seen along the ray: it passes beside the chord, before its start or behind its end.
        let step = [b[0] - a[0], b[1] - a[1]];
        let square = step[0].mul_add(step[0], step[1] * step[1]);
        let beside = a[0].mul_sub(step[1], a[1] * step[0]);
        let before = a[0].mul_add(step[0], a[1] * step[1]);
        let behind = -(b[0].mul_add(step[0], b[1] * step[1]));
        let off = before.max(behind).max(beside.abs());
        let is_near = (off * off).simd_le(radius * radius * square);
        let length = ray.frame.length as f32;
        let start = a[2].min(b[2]) - radius;
        let is_before = start.simd_le(f32x8::splat(simd, far * length));
        let is_behind = (a[2].max(b[2]) + radius).simd_ge(f32x8::splat(simd, near * length));
        let is_there = counts.simd_gt(f32x8::splat(simd, 0.0));
        ((is_near & is_before & is_behind & is_there).to_bitmask() as u32, start)
    }

    /// Requests the vertices of a lane's curve, which are about to be read.
    #[inline(always)]
    fn prefetch(&self, lane: usize, shared: &Shared<Self>) {
        if let Some((curves, prim_id)) = shared.get(self.numbers[lane])
            && let Some(&first) = curves.indices.get(prim_id as usize)
        {
            prefetch(&curves.vertices, first as usize);
            prefetch(&curves.vertices, first as usize + 3);
        }
    }
}

/// Most pieces that wait.
const MOST_WAIT: usize = 32;

/// Pieces whose capsules are met. They are tested at the next leaf, when their vertices have arrived.
pub struct Waiting {
    count: usize,
    /// Lanes of all blocks.
    places: [u32; MOST_WAIT],
    /// No hit is nearer along the ray.
    starts: [f32; MOST_WAIT],
}

impl Default for Waiting {
    #[inline(always)]
    fn default() -> Self {
        Self { count: 0, places: [0; MOST_WAIT], starts: [0.0; MOST_WAIT] }
    }
}

impl Waiting {
    /// Tests the first pieces. Returns how many were tested.
    #[inline(always)]
    fn test(
        &mut self,
        count: usize,
        blocks: &[CurveBlock],
        frame: &RayFrame,
        shared: &Shared<CurveBlock>,
        traversal: &mut RayTraversal,
    ) -> u64 {
        let mut tested = 0;
        let length = frame.length as f32;
        for i in 0..count.min(MOST_WAIT) {
            let place = self.places[i] as usize;
            if self.starts[i] <= traversal.reach() * length && !traversal.is_done() {
                tested += 1;
                blocks[place / WIDTH].meet_one(place % WIDTH, frame, shared, traversal.slot, traversal);
            }
        }
        for i in count..self.count.min(MOST_WAIT) {
            (self.places[i - count], self.starts[i - count]) = (self.places[i], self.starts[i]);
        }
        self.count -= count;
        tested
    }
}

impl BlockKind for CurveBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Ok([8, 9]);
    type Item = CurvePiece;
    type Data = Arc<OwnedCurves>;
    type Waiting = Waiting;
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
        Self {
            ends: [[0; WIDTH]; 2],
            numbers: [INVALID_ID; WIDTH],
            radius: [0; WIDTH],
            origin: [0.0; 3],
            steps: [0; 4],
        }
    }

    fn frame(&mut self, items: &[Option<&CurvePiece>; WIDTH]) {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for end in items.iter().flatten().flat_map(|piece| &piece.ends) {
            for k in 0..3 {
                (low[k], high[k]) = (least(low[k], end[k]), most(high[k], end[k]));
            }
        }
        self.origin = low;
        for k in 0..3 {
            self.steps[k] = half_above((f64::from(high[k]) - f64::from(low[k])) / MOST_STEPS);
        }
        let steps = [0, 1, 2].map(|k| f64::from(self.step(k)));
        let (origin, over) = (low.map(f64::from), steps.map(|step| 1.0 / step));
        let mut radii = [0.0; WIDTH];
        for (lane, piece) in items.iter().enumerate() {
            let Some(piece) = piece else { continue };
            // What the ends move counts for the radius.
            let mut farthest = 0.0f64;
            for (words, end) in self.ends.iter_mut().zip(&piece.ends) {
                let (mut word, mut off) = (0, 0.0);
                for k in 0..3 {
                    let x = f64::from(end[k]) - origin[k];
                    let count = (x * over[k] + 0.5).min(MOST_STEPS) as u32;
                    let moved = steps[k] * f64::from(count) - x;
                    off += moved * moved;
                    word |= count << (10 * k);
                }
                words[lane] = word;
                farthest = farthest.max(off);
            }
            radii[lane] = (f64::from(piece.radius) + farthest.sqrt()) * (1.0 + 1e-6);
        }
        let widest = radii.iter().fold(0.0, |all, &radius| if radius > all { radius } else { all });
        self.steps[3] = half_above(widest / 255.0);
        let over = 1.0 / f64::from(self.step(3));
        // Up to the next whole number, and by more than the product rounds.
        self.radius = radii.map(|radius| (radius * over + 1.0 - 1e-9).min(255.0) as u8);
        for (radius, piece) in self.radius.iter_mut().zip(items) {
            *radius = if piece.is_some() { (*radius).max(1) } else { 0 };
        }
    }

    fn set(&mut self, lane: usize, piece: &CurvePiece, number: u32) {
        let place = u32::from(place_of(piece.index, piece.count));
        self.ends[0][lane] |= place >> 2 << 30;
        self.ends[1][lane] |= place << 30;
        self.numbers[lane] = number;
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
        let mut waiting = Waiting::default();
        Self::meet_leaf(std::slice::from_ref(self), 0..1, simd, ready, shared, &mut waiting, traversal)
            + Self::finish(std::slice::from_ref(self), ready, shared, &mut waiting, traversal)
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
                    tested += waiting.test(MOST_WAIT, blocks, &ready.frame, shared, traversal);
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
            tested += waiting.test(before, blocks, &ready.frame, shared, traversal);
        }
        tested
    }

    #[inline(always)]
    fn finish<S: Simd>(
        blocks: &[Self],
        ready: &ReadyRay<S>,
        shared: &Shared<Self>,
        waiting: &mut Waiting,
        traversal: &mut RayTraversal,
    ) -> u64 {
        waiting.test(waiting.count, blocks, &ready.frame, shared, traversal)
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
    /// A step along an axis, or that of radii.
    #[inline(always)]
    fn step(&self, k: usize) -> f32 {
        f32::from_bits(u32::from(self.steps[k]) << 16)
    }

    /// A lane's place on its curve.
    #[inline(always)]
    fn place(&self, lane: usize) -> u8 {
        (self.ends[0][lane] >> 30 << 2 | self.ends[1][lane] >> 30) as u8
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
    const LENGTH: usize = 3 * WIDTH + WIDTH / 4 + 5;

    fn put(&self, data: &mut [u32]) {
        let (words, rest) = data.split_at_mut(3 * WIDTH);
        let (radii, rest) = rest.split_at_mut(WIDTH / 4);
        let (origin, steps) = rest.split_at_mut(3);
        words[..2 * WIDTH].copy_from_slice(self.ends.as_flattened());
        words[2 * WIDTH..].copy_from_slice(&self.numbers);
        for (word, &four) in radii.iter_mut().zip(self.radius.as_chunks().0) {
            *word = u32::from_le_bytes(four);
        }
        put_floats(origin, &self.origin);
        for (word, two) in steps.iter_mut().zip(self.steps.as_chunks().0) {
            let &[low, high] = two;
            *word = u32::from(low) | u32::from(high) << 16;
        }
    }

    fn get(data: &[u32]) -> Self {
        let mut block = Self::empty();
        let (words, rest) = data.split_at(3 * WIDTH);
        let (radii, rest) = rest.split_at(WIDTH / 4);
        let (origin, steps) = rest.split_at(3);
        block.ends.as_flattened_mut().copy_from_slice(&words[..2 * WIDTH]);
        block.numbers.copy_from_slice(&words[2 * WIDTH..]);
        for (four, word) in block.radius.as_chunks_mut().0.iter_mut().zip(radii) {
            *four = word.to_le_bytes();
        }
        get_floats(&mut block.origin, origin);
        for (two, word) in block.steps.as_chunks_mut().0.iter_mut().zip(steps) {
            *two = [*word as u16, (word >> 16) as u16];
        }
        block
    }
}
