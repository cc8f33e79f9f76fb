// SPDX-License-Identifier: GPL-3.0-or-later
//! An object or a scene placed in the world, and rays carried into its space.
//! Source: two levels after [WBS03a].
//! Spaces: rays come in world space and leave in object space; `t` is the same in both, directions keep their scale.
//! The origin is transformed relative to the object's position, split in two floats, so that objects far from
//! the world's origin lose no precision near themselves. Rays with origins in double precision are carried in
//! double precision.
//! Tests: `tests::carries_rays`, `tests/watertight.rs`, `tests/far_away.rs`.

use std::sync::Arc;

use gnurt_accel_core::affine::ObjectFromWorld;

use super::box64::Box64;
use super::exact::{Exact, Stand};
use super::path::{MotionPath, share_of};
use super::types::{At, Instance, PlacedInstance, SceneTree, Shape, Slot};
use crate::{Aabb, ObjectTree};

impl Instance {
    /// An object or a scene with a transform, visible to all rays.
    #[must_use]
    pub fn new(shape: impl Into<Shape>, world_from_object: [[f64; 3]; 4]) -> Self {
        Self { shape: shape.into(), world_from_object, motion: None, mask: u32::MAX }
    }

    /// An object or a scene that moves while the shutter is open, seen by all rays.
    #[must_use]
    pub fn moving(shape: impl Into<Shape>, motion: Arc<MotionPath>) -> Self {
        Self { motion: Some(motion.clone()), ..Self::new(shape, motion.at(0.0)) }
    }

    /// A shape with the identity transform, visible to all rays.
    #[must_use]
    pub fn identity(shape: impl Into<Shape>) -> Self {
        Self::new(shape, IDENTITY)
    }

    /// The same instance, seen by rays whose mask has a bit in common with `mask`.
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }
}

impl From<Arc<ObjectTree>> for Shape {
    fn from(object: Arc<ObjectTree>) -> Self {
        Self::Object(object)
    }
}

impl From<Arc<SceneTree>> for Shape {
    fn from(scene: Arc<SceneTree>) -> Self {
        Self::Scene(scene)
    }
}

impl Shape {
    /// Levels of scenes in this shape.
    pub(super) fn depth(&self) -> u32 {
        match self {
            Self::Object(_) => 0,
            Self::Scene(scene) => scene.depth(),
        }
    }

    /// The same, but 0 where nothing of it can be seen.
    pub(super) fn scene_depth(&self) -> u32 {
        if self.bounds().is_empty() { 0 } else { self.depth() }
    }

    /// How many objects are in it.
    pub(super) fn leaves(&self) -> u32 {
        match self {
            Self::Object(_) => 1,
            Self::Scene(scene) => scene.leaf_count(),
        }
    }

    /// Whether something in it moves while the shutter is open.
    fn moves(&self) -> bool {
        match self {
            Self::Object(object) => object.moves(),
            Self::Scene(scene) => scene.moves(),
        }
    }

    fn bounds(&self) -> Box64 {
        match self {
            Self::Object(object) => Box64::from(object.bounds()),
            Self::Scene(scene) => scene.bounds64(),
        }
    }
}

const IDENTITY: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// The [`Exact::spread`] of turns and scales, for which boxes and the slabs of rays have room: 33 roundings of 2^-24, of which
/// carrying a ray takes up to twelve for each unit.
const TURNED: f64 = 3.01;

impl PlacedInstance {
    /// With its box, in floats and relative to `origin`; `None` where the transform has no inverse in floats, or a value that
    /// is not finite, or where floats cannot hold the box.
    pub(super) fn new(instance: &Instance, origin: [f32; 3]) -> Option<(Self, Aabb)> {
        let columns = &instance.world_from_object;
        let exact = Exact::new(columns)?;
        let object_from_world = if *columns == IDENTITY { None } else { Some(rounded(&exact.stand())?) };
        let at = match &instance.motion {
            None => At::Still { object_from_world, exact },
            Some(path) => match path.only_piece() {
                Some(piece) => At::Piece(piece.clone(), path.clone()),
                None => At::Path(path.clone()),
            },
        };
        let placed = Self { shape: instance.shape.clone(), mask: instance.mask, at };
        let bounds = placed.bounds_from(origin)?;
        Some((placed, bounds))
    }

    /// The box in floats, relative to `origin`; `None` where they cannot hold it.
    fn bounds_from(&self, origin: [f32; 3]) -> Option<Aabb> {
        let bounds = self.shape.bounds();
        let exact = match &self.at {
            At::Still { exact, .. } => exact,
            At::Piece(_, path) | At::Path(path) => {
                return carry_along(path, &bounds, origin.map(f64::from)).map(|carried| carried.nearest());
            }
        };
        let in_floats = matches!(self.shape, Shape::Object(_)) || bounds == Box64::from(bounds.rounded());
        if self.is_identity() && origin == [0.0; 3] && in_floats {
            return Some(bounds.rounded());
        }
        carry_box(&exact.columns, &bounds, origin.map(f64::from)).map(|carried| carried.nearest())
    }

    /// The factor of its box's slack over that of others, at least 1. A ray that hits it in its space meets its box, too:
    /// rays are rounded there, and the error counts more in the world the more the map is sheared.
    /// Of one that moves, the most sheared of places on its way counts.
    pub(super) fn slack(&self) -> f32 {
        let inner = match &self.shape {
            Shape::Object(_) => 1.0,
            Shape::Scene(scene) => scene.top.slack(),
        };
        let spread = match &self.at {
            At::Still { object_from_world: None, .. } => 0.0,
            At::Still { exact, .. } => exact.spread(),
            At::Piece(_, path) | At::Path(path) => {
                let mut most = 0.0f64;
                path.steps(&self.shape.bounds(), |from, to, _| {
                    for place in [from, to] {
                        most = most.max(Exact::new(place).map_or(0.0, |exact| exact.spread()));
                    }
                });
                most
            }
        };
        inner * (1.0 + 0.5 * (spread - TURNED).max(0.0)) as f32
    }

    /// Whether it moves during an open shutter, or shows something that does.
    pub(super) fn moves(&self) -> bool {
        self.motion().is_some() || self.shape.moves()
    }

    /// How it moves, if it does.
    pub(super) fn motion(&self) -> Option<&MotionPath> {
        match &self.at {
            At::Still { .. } => None,
            At::Piece(_, path) | At::Path(path) => Some(path),
        }
    }

    /// Whether world and object space are the same at all times.
    pub(super) fn is_identity(&self) -> bool {
        matches!(&self.at, At::Still { object_from_world: None, .. })
    }

    /// Its transform at a time.
    pub(super) fn columns(&self, time: f32) -> [[f64; 3]; 4] {
        match &self.at {
            At::Still { exact, .. } => exact.columns,
            At::Piece(_, path) | At::Path(path) => path.at(time),
        }
    }

    /// The same with the inverse; `None` at a time at which the object is flat.
    pub(super) fn exact(&self, time: f32) -> Option<Exact> {
        match &self.at {
            At::Still { exact, .. } => Some(*exact),
            At::Path(path) if !path.is_there(time) => None,
            At::Piece(..) | At::Path(_) => Exact::new(&self.columns(time)),
        }
    }

    /// The same for rays.
    #[inline(always)]
    pub(super) fn stand(&self, time: f32) -> Option<Stand> {
        match &self.at {
            At::Still { exact, .. } => Some(exact.stand()),
            At::Piece(piece, path) => match share_of(time, 1).1 {
                share if share > 0.0 && share < 1.0 => piece.stand(share),
                _ => path.stand(time),
            },
            At::Path(path) => path.stand(time),
        }
    }
}

impl Slot {
    /// The box in floats, relative to `origin`; empty where there is nothing to see.
    pub(super) fn bounds_from(&self, origin: [f32; 3]) -> Aabb {
        match self {
            Self::PlacedInstance(placed) => placed.bounds_from(origin).unwrap_or(Aabb::EMPTY),
            Self::Absent | Self::Refused => Aabb::EMPTY,
        }
    }

    /// Boxes of a moving instance at times evenly spaced from 0 to 1, relative to `origin`: interpolated
    /// between two of them, they enclose it. One more than a power of two; `None` if it is static or
    /// invisible.
    pub(super) fn boxes_at(&self, origin: [f32; 3]) -> Option<Vec<Aabb>> {
        let Self::PlacedInstance(placed) = self else { return None };
        boxes_along(placed.motion()?, &placed.shape.bounds(), origin.map(f64::from))
    }
}

/// The map in floats; `None` where these cannot hold it.
#[inline]
pub(super) fn rounded(stand: &Stand) -> Option<ObjectFromWorld> {
    // Written out for speed: rays through moving instances come here.
    let floats = |v: [f64; 3]| [v[0] as f32, v[1] as f32, v[2] as f32];
    let is_finite = |v: [f32; 3]| v[0].is_finite() & v[1].is_finite() & v[2].is_finite();
    let spans = |v: [f32; 3]| (v[0] != 0.0) | (v[1] != 0.0) | (v[2] != 0.0);
    let [x, y, z] = stand.rows;
    let (x, y, z) = (floats(x), floats(y), floats(z));
    let translation = stand.translation;
    let high = floats(translation);
    let over = |k: usize| (translation[k] - f64::from(high[k])) as f32;
    let low = [over(0), over(1), over(2)];
    let sound = is_finite(x) & is_finite(y) & is_finite(z) & is_finite(high) & is_finite(low);
    (sound && spans(x) && spans(y) && spans(z))
        .then_some(ObjectFromWorld { rows: [x, y, z], translation: [high, low] })
}

/// The box around all that an object's box passes through, relative to `origin`; `None` where a float cannot hold it.
fn carry_along(motion: &MotionPath, object: &Box64, origin: [f64; 3]) -> Option<Box64> {
    if object.is_empty() {
        return Some(Box64::EMPTY);
    }
    let mut whole = Some(Box64::EMPTY);
    motion.steps(object, |from, to, bulge| {
        let both = [from, to].map(|columns| carry_box(columns, object, origin));
        for carried in both {
            whole = whole.take().zip(carried).map(|(whole, carried)| Box64 {
                min: [0, 1, 2].map(|k| whole.min[k].min(carried.min[k] - bulge)),
                max: [0, 1, 2].map(|k| whole.max[k].max(carried.max[k] + bulge)),
            });
        }
    });
    let is_held = |b: &Box64| b.min.iter().chain(&b.max).all(|&x| (x as f32).is_finite());
    whole.filter(is_held)
}

/// Boxes at keys whose interpolation encloses the path of an object's box, relative to `origin`; `None` if
/// there is nothing visible.
///
/// Between two keys both boxes grow by the object's distance outside of their interpolation, side by side.
fn boxes_along(motion: &MotionPath, object: &Box64, origin: [f64; 3]) -> Option<Vec<Aabb>> {
    if object.is_empty() {
        return None;
    }
    if motion.is_partial() {
        let whole = carry_along(motion, object, origin)?.nearest();
        return Some(vec![whole; 2]);
    }
    let pieces = motion.straight_pieces();
    // By piece: position within it, and box.
    let mut samples: Vec<Vec<(f64, Box64)>> = vec![Vec::new(); pieces];
    let mut held = true;
    motion.steps_of(object, pieces, |piece, ends, bulge| {
        for (share, columns) in ends {
            let Some(mut carried) = carry_box(&columns, object, origin) else {
                held = false;
                return;
            };
            for k in 0..3 {
                (carried.min[k], carried.max[k]) = (carried.min[k] - bulge, carried.max[k] + bulge);
            }
            samples[piece].push((share, carried));
        }
    });
    let mut keys = vec![Box64::EMPTY; pieces + 1];
    for (piece, samples) in samples.iter().enumerate() {
        let ((_, mut from), (_, mut to)) = (*samples.first()?, *samples.last()?);
        let (mut below, mut above) = ([0.0_f64; 3], [0.0_f64; 3]);
        for (share, sample) in samples {
            for k in 0..3 {
                let mix = |from: f64, to: f64| (1.0 - share) * from + share * to;
                below[k] = below[k].max(mix(from.min[k], to.min[k]) - sample.min[k]);
                above[k] = above[k].max(sample.max[k] - mix(from.max[k], to.max[k]));
            }
        }
        for end in [&mut from, &mut to] {
            for k in 0..3 {
                (end.min[k], end.max[k]) = (end.min[k] - below[k], end.max[k] + above[k]);
            }
        }
        keys[piece] = keys[piece].union(&from);
        keys[piece + 1] = keys[piece + 1].union(&to);
    }
    let keys: Vec<Aabb> = keys.iter().map(Box64::nearest).collect();
    let is_held = |b: &Aabb| b.min.iter().chain(&b.max).all(|x| x.is_finite());
    (held && keys.iter().all(is_held)).then_some(keys)
}

/// The world box of an object's box, relative to `origin`: around its eight corners, a little wider than rounding could
/// make it in floats. `None` where a float cannot hold it.
fn carry_box(columns: &[[f64; 3]; 4], object: &Box64, origin: [f64; 3]) -> Option<Box64> {
    if object.is_empty() {
        return Some(Box64::EMPTY);
    }
    let [axes @ .., translation] = columns;
    let mut bounds = Box64::EMPTY;
    for k in 0..3 {
        let at = translation[k] - origin[k];
        let (mut low, mut high, mut size) = (at, at, at.abs());
        for (axis, column) in axes.iter().enumerate() {
            let ends = [object.min[axis], object.max[axis]].map(|x| column[k] * x);
            low += ends[0].min(ends[1]);
            high += ends[0].max(ends[1]);
            size += ends[0].abs().max(ends[1].abs());
        }
        let slack = size * f64::from(f32::EPSILON);
        bounds.min[k] = low - slack;
        bounds.max[k] = high + slack;
    }
    bounds.min.iter().chain(&bounds.max).all(|&x| (x as f32).is_finite()).then_some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;

    #[test]
    fn carries_rays() {
        // Scaled by 2 along x, rotated by a quarter around z, then moved far away.
        let columns = [[0.0, 2.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1e6 + 0.125, 0.3, -7.0]];
        let exact = Exact::new(&columns).expect("invertible");
        let map = rounded(&exact.stand()).expect("in the range of floats");
        let world = Ray::new([1e6 - 1.0, 4.0, -7.0], [0.0, 2.0, 0.0]);
        let object = map.ray(&world);
        assert_eq!(object.dir, [1.0, 0.0, 0.0], "world y is object x, scaled");
        let error = (object.org[0] - 1.85).abs() + (object.org[1] - 1.125).abs() + object.org[2].abs();
        assert!(error < 1e-6, "{:?} is relative to the object's place", object.org);
        let (precise, inside) = exact.stand().ray(&world, &[1e6 - 1.0, 4.0 + 1e-9, -7.0]);
        assert_eq!(precise.dir, object.dir, "directions are those of floats here");
        assert!((inside[0] - 1.85 - 5e-10).abs() < 1e-12, "{inside:?} keeps what floats would lose");
    }

    #[test]
    fn boxes_at_keys_hold_what_moves() {
        let object = Box64 { min: [-1.0, 0.5, -2.0], max: [3.0, 4.0, 1.0] };
        let turned = |angle: f64, size: f64, translation: [f64; 3]| {
            let (s, c) = angle.sin_cos();
            [[c * size, s * size, 0.0], [-s, c, 0.0], [0.0, 0.1, size], translation]
        };
        let spin = |i: i32| turned(2.0 * f64::from(i), 1.0, [f64::from(i), 0.0, 0.0]);
        let paths = [
            (vec![turned(0.3, 1.0, [0.0; 3]), turned(0.3, 1.0, [5.0, 1.0, -30.0])], 1, 1.001),
            (vec![turned(0.0, 1.0, [0.0; 3]), turned(0.1, 1.0, [1.0, 0.0, 0.0])], 1, 1.02),
            ((0..4).map(|i| turned(0.0, 1.0, [0.0, f64::from(i * i), 0.0])).collect(), 4, 1.6),
            (vec![turned(0.0, 1.0, [0.0; 3]), turned(2.9, 3.0, [9.0, 1.0, 0.0])], 8, 1.2),
            ((0..12).map(spin).collect(), 8, 4.0),
        ];
        for (path_keys, pieces, most) in paths {
            let path = MotionPath::new(&path_keys).expect("they have inverses");
            let keys = boxes_along(&path, &object, [0.5; 3]).expect("there is something to see");
            assert_eq!(keys.len(), pieces + 1, "as many as its way needs");
            let (mut area, mut least) = (0.0, 0.0);
            for step in 0..=1000 {
                let time = step as f32 / 1000.0;
                let interval = crate::KeyInterval::of(time, keys.len());
                let (from, to) = (&keys[interval.key], &keys[interval.next]);
                let mixed =
                    Aabb { min: interval.mix3(from.min, to.min), max: interval.mix3(from.max, to.max) };
                let there = carry_box(&path.at(time), &object, [0.5; 3]).expect("near");
                // The slack of the slabs of rays.
                let slack = 1e-6 * f64::from(mixed.greatest());
                for k in 0..3 {
                    let holds = f64::from(mixed.min[k]) - slack <= there.min[k]
                        && there.max[k] <= f64::from(mixed.max[k]) + slack;
                    assert!(holds, "{there:?} at {time} is in {mixed:?}");
                }
                area += mixed.half_area();
                least += there.nearest().half_area();
            }
            assert!(area < most * least, "{pieces} pieces: {} of the least area", area / least);
        }
    }

    #[test]
    fn flat_and_unsound_maps_are_refused() {
        let object = Arc::new(ObjectTree::build(&[], &Default::default(), crate::Threads::Single));
        for (column, value) in [(0, 0.0), (3, f64::NAN), (1, f64::INFINITY), (2, 1e-300)] {
            let mut instance = Instance::identity(Arc::clone(&object));
            instance.world_from_object[column] = [value; 3];
            assert!(
                PlacedInstance::new(&instance, [0.0; 3]).is_none(),
                "{value} in column {column} cannot be undone"
            );
        }
        assert!(
            PlacedInstance::new(&Instance::identity(object), [0.0; 3]).is_some(),
            "an empty object can be placed"
        );
    }
}
