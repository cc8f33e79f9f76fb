// SPDX-License-Identifier: GPL-3.0-or-later
//! What lanes know of a surface: Lambert's reflector and nothing but that. Source: [Lam60].

use crate::materials::color::{Emission, TexturedColor};

/// All there is to know of a surface that is Lambert's reflector everywhere, on both sides, without holes.
#[derive(Clone, Debug)]
pub struct Lambertian {
    /// Share of light that is scattered.
    pub albedo: TexturedColor,
    /// Radiance that leaves its front.
    pub emission: Option<Emission>,
}
