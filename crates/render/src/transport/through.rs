// SPDX-License-Identifier: GPL-3.0-or-later
//! The media that shadow rays pass: bodies that each ray begins in, and the edges of its path.
//! Space: world. Tests: crates/render/tests/media.rs.

use glam::Vec3;
use gnurt_shading::SampleKey;

use super::flight::{Parts, Random};
use crate::world::{Inside, Media};

/// Media along shadow rays: where each ray begins, and the edges of its path.
#[derive(Clone, Copy)]
pub(crate) struct Through<'a> {
    pub(crate) media: &'a Media,
    pub(crate) inside: &'a [Inside],
    pub(crate) edges: &'a [u32],
}

impl<'a> Through<'a> {
    /// Transmittance over `length` along ray `i`; `layer` distinguishes stretches of one way.
    pub(super) fn left(
        &self,
        parts: &mut Parts<'a>,
        (inside, edges): (Inside, u32),
        (org, dir, length): (Vec3, Vec3, f32),
        (seed, key, layer): (u64, SampleKey, u32),
    ) -> Vec3 {
        self.media.parts(inside, org, dir, parts);
        parts.transmittance(length, &mut Random::of_shadow(seed, key, [edges, layer]))
    }
}
