// SPDX-License-Identifier: GPL-3.0-or-later
//! Mean reflectance of metals. Source: [KC17] (further bounces are coloured by it). Tests: `tests` of `bsdf`.

use glam::Vec3;

use super::fresnel;

/// Fresnel's share per channel, averaged over a cosine-weighted hemisphere.
pub(super) fn average(eta: Vec3, k: Vec3) -> Vec3 {
    const N: usize = 16;
    let middle = |i: usize| (i as f32 + 0.5) / N as f32;
    let channel = |c: usize| -> f32 {
        (0..N).map(|i| fresnel::conductor(middle(i), eta[c], k[c]) * (2.0 * middle(i) / N as f32)).sum()
    };
    Vec3::new(channel(0), channel(1), channel(2)).clamp(Vec3::ZERO, Vec3::ONE)
}
