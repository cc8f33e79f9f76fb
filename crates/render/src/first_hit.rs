// SPDX-License-Identifier: GPL-3.0-or-later
//! The first hit of a pixel: a point with its ids.
//! Space: world; depths in world units. Tests: crates/render/tests/seen.rs.

use glam::Vec3;
use gnurt_accel::INVALID_ID;

use crate::state::{SavedState, put_f32, put_u32};

/// The first hit of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstHit {
    pub(crate) position: Vec3,
    pub(crate) depth: f32,
    pub(crate) z: f32,
    pub(crate) object: u32,
    pub(crate) instance: u32,
    pub(crate) prim: u32,
    pub(crate) material: u32,
}

pub(crate) const NOTHING: FirstHit = FirstHit {
    position: Vec3::ZERO,
    depth: f32::INFINITY,
    z: f32::INFINITY,
    object: INVALID_ID,
    instance: INVALID_ID,
    prim: INVALID_ID,
    material: INVALID_ID,
};

impl SavedState for FirstHit {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self { position, depth, z, object, instance, prim, material } = self;
        for x in [&mut position.x, &mut position.y, &mut position.z, depth, z] {
            put_f32(x, with);
        }
        for id in [object, instance, prim, material] {
            put_u32(id, with);
        }
    }
}
