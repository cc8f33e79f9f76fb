// SPDX-License-Identifier: GPL-3.0-or-later
//! Transforms that change over time, of instances and cameras, and the time that the shutter is open.
//! Source: ANARI 1.1, KHR_INSTANCE_MOTION_TRANSFORM, KHR_INSTANCE_MOTION_SCALE_ROTATION_TRANSLATION, KHR_CAMERA_MOTION_TRANSFORMATION,
//! KHR_CAMERA_SHUTTER. Entries are evenly spaced over `time`; before the first and after the last nothing moves. Matrices, scales and
//! translations are interpolated linearly, rotations along the shorter arc. Tests: tests/motion.rs.

use glam::{DMat4, DQuat, DVec3, Quat};
use gnurt::accel::KeyInterval;
use gnurt::scene::Affine;

use crate::ffi_array::Array;
use crate::object::Snapshot;
use crate::types;

/// When the shutter opens and closes.
pub(crate) type Shutter = [f32; 2];

/// Without a shutter of its own, a camera shows this moment.
pub(crate) const MOMENT: Shutter = [0.5; 2];

/// Transforms over time.
#[derive(Clone)]
pub(crate) struct Motion {
    entries: Entries,
    time: [f32; 2],
}

#[derive(Clone)]
enum Entries {
    Matrices(Vec<[f32; 16]>),
    Parts { scales: Vec<[f32; 3]>, rotations: Vec<[f32; 4]>, translations: Vec<[f32; 3]> },
}

/// The rows of an array of the program; none where it has no elements of that size.
fn rows<const N: usize>(now: &Snapshot, name: &str) -> Vec<[f32; N]> {
    let array = now.object(name, types::ARRAY1D).and_then(|array| Array::of(array)?.rows::<N>());
    array.unwrap_or_default()
}

impl Motion {
    /// The motion of an object; `None` where it has none. Matrices count before scales, rotations and translations.
    pub(crate) fn of(now: &Snapshot) -> Option<Self> {
        let time = now.floats("time", &[types::FLOAT32_BOX1]).unwrap_or([0.0, 1.0]);
        let matrices = rows::<16>(now, "motion.transform");
        if !matrices.is_empty() {
            return Some(Self { entries: Entries::Matrices(matrices), time });
        }
        let (scales, rotations) = (rows::<3>(now, "motion.scale"), rows::<4>(now, "motion.rotation"));
        let translations = rows::<3>(now, "motion.translation");
        let moves = !(scales.is_empty() && rotations.is_empty() && translations.is_empty());
        moves.then_some(Self { entries: Entries::Parts { scales, rotations, translations }, time })
    }

    /// The transform at a time.
    pub(crate) fn at(&self, time: f32) -> Affine {
        let [first, last] = self.time;
        let share =
            if last > first { (time - first) / (last - first) } else { f32::from(u8::from(time > first)) };
        let matrix = match &self.entries {
            Entries::Matrices(all) => between(all, share, [0.0; 16]).map(f64::from),
            Entries::Parts { scales, rotations, translations } => {
                let scale = DVec3::from(between(scales, share, [1.0; 3]).map(f64::from));
                let translation = DVec3::from(between(translations, share, [0.0; 3]).map(f64::from));
                DMat4::from_scale_rotation_translation(scale, turned(rotations, share), translation)
                    .to_cols_array()
            }
        };
        Affine::from_column_major(&matrix)
    }
}

/// The numbers at a share of the time, from those of evenly spaced entries; `none` without entries.
fn between<const N: usize>(all: &[[f32; N]], share: f32, none: [f32; N]) -> [f32; N] {
    let interval = KeyInterval::of(share, all.len());
    match (all.get(interval.key), all.get(interval.next)) {
        (Some(from), Some(to)) => std::array::from_fn(|k| interval.mix(from[k], to[k])),
        _ => none,
    }
}

/// The rotation at a share of the time.
fn turned(all: &[[f32; 4]], share: f32) -> DQuat {
    let interval = KeyInterval::of(share, all.len());
    let unit = |index: usize| {
        let given = Quat::from_array(*all.get(index)?).as_dquat();
        (given.length_squared() > 0.0 && given.is_finite()).then(|| given.normalize())
    };
    match (unit(interval.key), unit(interval.next)) {
        (Some(from), Some(to)) => from.slerp(to, f64::from(interval.weights[1])),
        _ => DQuat::IDENTITY,
    }
}

/// The time at a share of the time that the shutter is open.
pub(crate) fn time_at(shutter: Shutter, share: f32) -> f32 {
    shutter[0] + share * (shutter[1] - shutter[0])
}

/// The shutter of a camera; an error in words where it closes before it opens.
pub(crate) fn shutter(now: &Snapshot) -> Result<Shutter, String> {
    let [opens, closes] = now.floats("shutter", &[types::FLOAT32_BOX1]).unwrap_or(MOMENT);
    if opens <= closes && opens.is_finite() && closes.is_finite() {
        Ok([opens, closes])
    } else {
        Err(format!("parameter 'shutter': {opens} to {closes}: out of range; it must close after it opens"))
    }
}
