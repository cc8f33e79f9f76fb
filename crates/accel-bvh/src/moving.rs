// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres, discs and curves that move while the shutter is open, in leaf blocks of eight pieces. Lanes compare the ray
//! with a box around the whole way of each piece. Pieces that it may meet are tested one by one, where they are at the
//! ray's time. Triangles have boxes that move with them: `motion.rs`. Space: object.
//! Invariant: shapes go in straight lines from key to key, so a box around a piece at all keys holds it at all times.
//! Tests: `tests/moving_shapes.rs` of `gnurt-accel`.

use std::io::{self, Read, Write};
use std::sync::Arc;

use gnurt_accel_core::collect::Collect;
use gnurt_accel_core::curve::{OwnedCurves, RayFrame, Segment};
use gnurt_accel_core::geometry::GeometryKind;
use gnurt_accel_core::point::{NearestPoint, Probe, on_disc, on_sphere, through_disc};
use gnurt_accel_core::primitive::Primitive;
use gnurt_accel_core::slab::SLACK;
use gnurt_accel_core::store::{LoadError, Reader, StoredRecord, Writer};
use gnurt_accel_core::traversal::RayTraversal;
use gnurt_accel_core::triangle::TriangleHit;
use gnurt_accel_core::{Aabb, BadPrimitives, INVALID_ID, KeyInterval, Ray};
use gnurt_simd::{Simd, f32x8, prelude::*};

use crate::blocked::{BlockData, BlockKind, Shared};
use crate::curves::CurveBlock;
use crate::discs::DiscBlock;
use crate::node::WIDTH;
use crate::spheres::{SphereBlock, roots};

const UNSAVED: &str = "moving spheres, discs and curves cannot be saved";

/// Eight pieces: boxes around their ways, and their places on curves.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub struct MovingBlock {
    /// Lower and upper sides. Empty lanes are inside out.
    rows: [[f32; WIDTH]; 6],
    /// Numbers in the object.
    numbers: [u32; WIDTH],
    /// The number of pieces of the curve, then that of this one, in 16 bits each.
    pieces: [u32; WIDTH],
}

/// A piece on its way into a lane.
pub struct MovingPiece {
    bounds: Aabb,
    pieces: u32,
}

/// The arrays of a geometry at each key, and the times of the first and of the last one.
#[derive(Clone, Debug, Default)]
pub struct MovingShapes {
    keys: Vec<Shapes>,
    range: [f32; 2],
}

#[derive(Clone, Debug)]
enum Shapes {
    Spheres(Vec<([f32; 3], f32)>),
    Discs(Vec<([f32; 3], f32, Option<[f32; 3]>)>),
    Curves(OwnedCurves),
}

/// One shape at one time.
enum Shape {
    Sphere([f32; 3], f32),
    Disc([f32; 3], f32, Option<[f32; 3]>),
    Curve(Segment),
}

impl Shapes {
    fn new(kind: &GeometryKind) -> Option<Self> {
        Some(match kind {
            GeometryKind::Spheres(spheres) => {
                Self::Spheres(spheres.centers.iter().copied().zip(spheres.radii.iter().copied()).collect())
            }
            GeometryKind::Discs(discs) => {
                let normal =
                    |i: usize| discs.normals.map(|normals| normals.get(i).copied().unwrap_or_default());
                let all = discs.centers.iter().zip(discs.radii).enumerate();
                Self::Discs(all.map(|(i, (center, radius))| (*center, *radius, normal(i))).collect())
            }
            GeometryKind::Curves(curves) => Self::Curves(OwnedCurves::new(curves)),
            _ => return None,
        })
    }

    fn shape(&self, prim_id: u32) -> Option<Shape> {
        let i = prim_id as usize;
        Some(match self {
            Self::Spheres(all) => all.get(i).map(|&(center, radius)| Shape::Sphere(center, radius))?,
            Self::Discs(all) => {
                all.get(i).map(|&(center, radius, normal)| Shape::Disc(center, radius, normal))?
            }
            Self::Curves(curves) => Shape::Curve(curves.segment(prim_id)?),
        })
    }

    fn memory_bytes(&self) -> usize {
        match self {
            Self::Spheres(all) => size_of_val(&all[..]),
            Self::Discs(all) => size_of_val(&all[..]),
            Self::Curves(curves) => curves.memory_bytes(),
        }
    }
}

impl MovingShapes {
    /// A shape at a time; `None` where it is not seen.
    fn at(&self, prim_id: u32, time: f32) -> Option<Shape> {
        let interval = KeyInterval::within(self.range, time, self.keys.len())?;
        let [from, to] = [interval.key, interval.next].map(|key| self.keys.get(key)?.shape(prim_id));
        let between = |from, to| interval.mix3(from, to);
        Some(match (from?, to?) {
            (Shape::Sphere(a, r), Shape::Sphere(b, s)) => Shape::Sphere(between(a, b), interval.mix(r, s)),
            (Shape::Disc(a, r, n), Shape::Disc(b, s, m)) => {
                let normal = n.zip(m).map(|(n, m)| between(n, m));
                Shape::Disc(between(a, b), interval.mix(r, s), normal)
            }
            (Shape::Curve(a), Shape::Curve(b)) => Shape::Curve(a.mixed(&b, f64::from(interval.weights[1]))),
            (from, _) => from,
        })
    }

    /// The shape at the first key.
    fn first(&self, prim_id: u32) -> Option<Shape> {
        self.keys.first()?.shape(prim_id)
    }
}

/// The parameters between which a piece lies.
fn part(pieces: u32) -> [f64; 2] {
    let [count, index] = [pieces >> 16, pieces & 0xffff].map(f64::from);
    [index / count, (index + 1.0) / count]
}

/// A ray, in lanes, and as curves need it.
#[derive(Clone, Copy)]
pub struct ReadyRay<S: Simd> {
    frame: RayFrame,
    org: [f32x8<S>; 3],
    inverse: [f32x8<S>; 3],
    slack: f32x8<S>,
}

impl MovingBlock {
    /// Lanes whose boxes the ray may meet within `[near, far]`, as bits.
    #[inline(always)]
    fn boxes<S: Simd>(&self, simd: S, ray: &ReadyRay<S>, [near, far]: [f32; 2]) -> u32 {
        let row = |values: &[f32; WIDTH]| f32x8::from_slice(simd, values);
        let (mut enters, mut leaves) = (f32x8::splat(simd, near), f32x8::splat(simd, far));
        for axis in 0..3 {
            let low = (row(&self.rows[axis]) - ray.slack - ray.org[axis]) * ray.inverse[axis];
            let high = (row(&self.rows[3 + axis]) + ray.slack - ray.org[axis]) * ray.inverse[axis];
            enters = enters.max(low.min(high));
            leaves = leaves.min(low.max(high));
        }
        let some = f32x8::splat(simd, 1.0 + 4.0 * f32::EPSILON);
        let is_there = row(&self.rows[0]).simd_le(row(&self.rows[3]));
        (is_there & enters.simd_le(leaves * some)).to_bitmask() as u32
    }

    /// Offers the hits of one piece. Compiled once: few pieces come here.
    #[inline(never)]
    fn meet_one(&self, lane: usize, frame: &RayFrame, shared: &Shared<Self>, traversal: &mut RayTraversal) {
        let RayTraversal { ray, slot, .. } = *traversal;
        let number = self.numbers[lane];
        let Some((shapes, prim_id)) = shared.get(number) else { return };
        let Some(shape) = shapes.at(prim_id, ray.time) else { return };
        let mut offer = |t: f32, u: f32, v: f32| {
            if t >= ray.t_near && t <= traversal.reach() {
                traversal.offer(TriangleHit { t: t + 0.0, u, v }, number, slot);
            }
        };
        match shape {
            Shape::Sphere(center, radius) => {
                let square = across(ray, center);
                if square <= f64::from(radius) * f64::from(radius) {
                    roots(ray, center, radius).into_iter().for_each(|t| offer(t, 0.0, 0.0));
                }
            }
            Shape::Disc(center, radius, normal) => {
                let line = [ray.org.map(f64::from), ray.dir.map(f64::from)];
                if let Some(t) = through_disc(line, center, radius, normal) {
                    offer(t as f32, 0.0, 0.0);
                }
            }
            Shape::Curve(segment) => segment.meet(frame, part(self.pieces[lane]), &mut |hit| {
                offer(hit.t as f32, hit.u as f32, hit.v as f32);
            }),
        }
    }
}

/// The square of the distance of a ray's line from a point.
fn across(ray: &Ray, point: [f32; 3]) -> f64 {
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let (org, dir, point) = (ray.org.map(f64::from), ray.dir.map(f64::from), point.map(f64::from));
    let from = [0, 1, 2].map(|k| org[k] - point[k]);
    let along = dot(from, dir) / dot(dir, dir);
    let off = [0, 1, 2].map(|k| from[k] - along * dir[k]);
    dot(off, off)
}

impl BlockKind for MovingBlock {
    const IN_FILES: Result<[u64; 2], &'static str> = Err(UNSAVED);
    type Item = MovingPiece;
    type Data = Arc<MovingShapes>;
    type Ready<S: Simd> = ReadyRay<S>;

    fn is_kind_of(kind: &GeometryKind) -> bool {
        let GeometryKind::Moving(moving) = kind else { return false };
        let is_shape = |key: &GeometryKind| {
            SphereBlock::is_kind_of(key) || DiscBlock::is_kind_of(key) || CurveBlock::is_kind_of(key)
        };
        moving.keys.first().is_some_and(is_shape)
    }

    fn data(kind: &GeometryKind) -> Self::Data {
        let GeometryKind::Moving(moving) = kind else { return Arc::default() };
        let keys = moving.keys.iter().filter_map(Shapes::new).collect();
        Arc::new(MovingShapes { keys, range: moving.range })
    }

    fn items(kind: &GeometryKind, prim_id: u32, bad: &mut BadPrimitives, each: &mut dyn FnMut(MovingPiece)) {
        let GeometryKind::Moving(moving) = kind else { return };
        let (mut whole, mut segments, mut is_good) = (Aabb::EMPTY, Vec::new(), true);
        for key in moving.keys {
            let mut found = false;
            // A fault at one key is the primitive's fault, once.
            let mut ignored = BadPrimitives::default();
            let bad = if is_good { &mut *bad } else { &mut ignored };
            let mut take = |bounds: Aabb| {
                whole = whole.union(&bounds);
                found = true;
            };
            match key {
                GeometryKind::Curves(curves) => segments.extend(curves.check(prim_id, bad)),
                GeometryKind::Spheres(_) => SphereBlock::items(key, prim_id, bad, &mut |item| {
                    take(SphereBlock::bounds(&item));
                }),
                GeometryKind::Discs(_) => {
                    DiscBlock::items(key, prim_id, bad, &mut |item| take(DiscBlock::bounds(&item)));
                }
                _ => {}
            }
            is_good &= found || matches!(key, GeometryKind::Curves(_));
        }
        if !segments.is_empty() && segments.len() == moving.keys.len() {
            let count = segments.iter().map(Segment::parts).max().unwrap_or(1);
            for index in 0..count {
                let pieces = count << 16 | index;
                let [from, to] = part(pieces);
                let bounds = segments.iter().map(|segment| segment.bounds(from, to));
                each(MovingPiece { bounds: bounds.fold(Aabb::EMPTY, |all, one| all.union(&one)), pieces });
            }
        } else if segments.is_empty() && is_good && !whole.is_empty() {
            each(MovingPiece { bounds: whole, pieces: 1 << 16 });
        }
    }

    fn bounds(piece: &MovingPiece) -> Aabb {
        piece.bounds
    }

    fn empty() -> Self {
        let mut rows = [[f32::MAX; WIDTH]; 6];
        rows[3..].fill([f32::MIN; WIDTH]);
        Self { rows, numbers: [INVALID_ID; WIDTH], pieces: [1 << 16; WIDTH] }
    }

    fn set(&mut self, lane: usize, piece: &MovingPiece, number: u32) {
        let sides = piece.bounds.min.into_iter().chain(piece.bounds.max);
        self.rows.iter_mut().zip(sides).for_each(|(row, x)| row[lane] = x);
        (self.numbers[lane], self.pieces[lane]) = (number, piece.pieces);
    }

    /// Another way needs another tree.
    fn moved(&self, _lane: usize, _kind: &GeometryKind, _prim_id: u32) -> Option<MovingPiece> {
        None
    }

    fn numbers(&self) -> &[u32; WIDTH] {
        &self.numbers
    }

    #[inline(always)]
    fn ready<S: Simd>(simd: S, ray: &Ray, greatest: f32) -> ReadyRay<S> {
        let away = ray.org[0].abs().max(ray.org[1].abs()).max(ray.org[2].abs());
        let lanes = |[x, y, z]: [f32; 3]| [x, y, z].map(|x| f32x8::splat(simd, x));
        ReadyRay {
            frame: RayFrame::new(ray.org.map(f64::from), ray.dir.map(f64::from)),
            org: lanes(ray.org),
            inverse: lanes(ray.dir.map(|x| 1.0 / x)),
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
        let mut bits = self.boxes(simd, ready, [traversal.ray.t_near, traversal.reach()]);
        let mut tested = 0;
        while bits != 0 && !traversal.is_done() {
            let lane = bits.trailing_zeros() as usize & (WIDTH - 1);
            bits &= bits - 1;
            tested += 1;
            self.meet_one(lane, &ready.frame, shared, traversal);
        }
        tested
    }

    /// Where it is at the first key.
    fn near(
        &self,
        lane: usize,
        shared: &Shared<Self>,
        probe: &Probe,
        slot: u32,
        nearest: &mut dyn NearestPoint,
    ) {
        let number = self.numbers[lane];
        let Some((shapes, prim_id)) = shared.get(number) else { return };
        let (offset, u) = match shapes.first(prim_id) {
            Some(Shape::Sphere(center, radius)) => {
                (on_sphere(probe, center.map(f64::from), f64::from(radius)), 0.0)
            }
            Some(Shape::Disc(center, radius, normal)) => (on_disc(probe, center, radius, normal), 0.0),
            Some(Shape::Curve(segment)) => segment.nearest(probe, part(self.pieces[lane])),
            None => return,
        };
        nearest.offer(offset, [u, 0.0], number, slot);
    }

    /// The one at the first key.
    fn primitive<'a>(&'a self, lane: usize, shared: &'a Shared<Self>) -> Primitive<'a> {
        let (shapes, prim_id) = shared.of(self.numbers[lane]);
        match &shapes.keys[0] {
            Shapes::Spheres(all) => Primitive::Sphere(all[prim_id as usize].0, all[prim_id as usize].1),
            Shapes::Discs(all) => {
                let (center, radius, normal) = all[prim_id as usize];
                Primitive::Disc(center, radius, normal)
            }
            Shapes::Curves(curves) => Primitive::Curve(curves, prim_id, part(self.pieces[lane])),
        }
    }

    fn is_sound(&self, _lane: usize, _shared: &Shared<Self>, _count: u32) -> bool {
        false
    }
}

impl BlockData for Arc<MovingShapes> {
    fn memory_bytes(&self) -> usize {
        self.keys.iter().map(Shapes::memory_bytes).sum()
    }

    fn save(&self, _: &mut Writer<'_, impl Write>) -> io::Result<()> {
        Err(io::Error::new(io::ErrorKind::Unsupported, UNSAVED))
    }

    fn load(_: &mut Reader<'_, impl Read>) -> Result<Self, LoadError> {
        Err(LoadError::Damaged(UNSAVED))
    }
}

impl StoredRecord for MovingBlock {
    const LENGTH: usize = 8 * WIDTH;

    fn put(&self, data: &mut [u32]) {
        let rows = self.rows.as_flattened().iter().map(|x| x.to_bits());
        let rest = self.numbers.iter().chain(&self.pieces).copied();
        data.iter_mut().zip(rows.chain(rest)).for_each(|(word, value)| *word = value);
    }

    fn get(_: &[u32]) -> Self {
        Self::empty()
    }
}
