// SPDX-License-Identifier: GPL-3.0-or-later
//! Random surfaces for the tests of virtual lights. Space: the unit cube.

use glam::Vec3;
use gnurt_shading::bsdf::{Bsdf, Lobe};
use gnurt_shading::sampling::{sample_pair, uniform_sphere};
use gnurt_shading::{SampleKey, SurfacePoint};

/// Two numbers of surface `n`, from 0 to 1.
pub(super) fn random(seed: u64, n: u32, purpose: u32) -> [f32; 2] {
    sample_pair(seed, SampleKey { pixel: n, sample: 0, branch: 0 }, 0, purpose)
}

/// Matte, at a random position, with a random normal.
pub(super) fn surface(seed: u64, n: u32) -> (SurfacePoint, Bsdf) {
    let ([x, y], [z, _]) = (random(seed, n, 0), random(seed, n, 1));
    let ng = uniform_sphere(random(seed, n, 2));
    let bsdf = Bsdf::new(ng, Lobe::lambert(Vec3::new(0.8, 0.5, 0.3)));
    (SurfacePoint { p: Vec3::new(x, y, z), error: 1e-6, ng, ns: ng, lift: Vec3::ZERO }, bsdf)
}
