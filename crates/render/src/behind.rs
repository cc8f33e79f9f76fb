// SPDX-License-Identifier: GPL-3.0-or-later
//! The part of a camera ray that sees the background, straight through transparent surfaces and media.
//! Tests: crates/render/tests/opacity.rs.

use glam::Vec3;
use gnurt_accel::{HitBatch, INVALID_ID};
use gnurt_shading::Vec3s;

/// What a camera ray sees of the background.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Behind {
    /// Its part of the ray's light.
    pub(crate) light: Vec3,
    /// The share of light that reaches the eye from there, in [0, 1]: the ray covers the rest.
    pub(crate) share: f32,
}

impl Behind {
    /// That of a lane with this light. Integrators that note none see the background where rays hit nothing.
    pub(crate) fn of(list: &[Self], (hits, radiance): (&HitBatch, &Vec3s), lane: usize) -> Self {
        let noted = list.get(lane).copied();
        noted.unwrap_or_else(|| match hits.prim_id[lane] {
            INVALID_ID => Self { light: radiance.get(lane), share: 1.0 },
            _ => Self::default(),
        })
    }

    /// Begins a batch of camera rays.
    pub(crate) fn begin(list: &mut Vec<Self>, lanes: usize) {
        list.clear();
        list.resize(lanes, Self::default());
    }

    /// Notes that a camera ray leaves the scene with light of this weight.
    pub(crate) fn leave(list: &mut [Self], lane: usize, weight: Vec3) {
        if let Some(behind) = list.get_mut(lane)
            && weight.is_finite()
        {
            behind.share += weight.element_sum() / 3.0;
        }
    }

    /// Adds light of the background to a camera ray's.
    pub(crate) fn add(list: &mut [Self], lane: usize, light: Vec3) {
        if let Some(behind) = list.get_mut(lane) {
            behind.light += light;
        }
    }
}
