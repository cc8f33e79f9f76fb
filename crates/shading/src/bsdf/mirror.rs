// SPDX-License-Identifier: GPL-3.0-or-later
//! Perfect mirrors. Source: [Whi80]. Space: the shading frame. Proof: `tests` of `bsdf`.

use glam::Vec3;

use super::BsdfSample;

pub(super) fn sample(reflectance: Vec3, wo: Vec3) -> Option<BsdfSample> {
    (reflectance != Vec3::ZERO).then_some(BsdfSample {
        wi: Vec3::new(-wo.x, -wo.y, wo.z),
        weight: reflectance,
        pdf: f32::INFINITY,
        delta: true,
        transmitted: false,
    })
}
