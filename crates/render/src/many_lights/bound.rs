// SPDX-License-Identifier: GPL-3.0-or-later
//! Split of the light along an edge between virtual lights and rays that the eye's BSDF chooses.
//! Source: [KK06] bounds the geometry term G and gives the rest to rays. Differs: the bound is on the
//! density, per area, with which either end's BSDF would choose the other. For two Lambertian surfaces that
//! is G / pi; on glossy ones it is large at their peaks, too. Both sides of the split use the same function,
//! so no light is lost or counted twice.
//! Tests: crates/render/tests/many_lights.rs.

use std::f32::consts::PI;

use crate::options::RenderOptions;
use crate::world::World;

/// Virtual lights that share the least area over which one may bring its light wholly.
const CROWD: f32 = 3.0;

/// The largest density that virtual lights take wholly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// Per area.
    density: f32,
}

impl Bound {
    /// From a bound on the geometry term G, one over area; infinite = virtual lights bring everything.
    pub(crate) fn on_geometry_term(g: f32) -> Self {
        Self { density: g / PI }
    }

    /// A bound for `vpls` lights within a box: on average there are `CROWD` lights per area where its density begins to
    /// matter, so that no single one is seen.
    pub(crate) fn for_scene([lower, upper]: [[f32; 3]; 2], vpls: u32) -> Self {
        let [x, y, z] = [0, 1, 2].map(|k| upper[k] - lower[k]);
        let area = 2.0 * (x * y + y * z + z * x);
        Self { density: if area > 0.0 { vpls as f32 / (CROWD * area) } else { f32::INFINITY } }
    }

    /// A bound larger by this factor.
    pub(crate) fn times(self, factor: f32) -> Self {
        Self { density: self.density * factor }
    }

    /// The largest density, per area.
    pub(crate) fn density(&self) -> f32 {
        self.density
    }

    /// Share of virtual lights, given the densities per area with which the ends choose each other.
    pub(crate) fn share(&self, pdf_eye: f32, pdf_vpl: f32) -> f32 {
        let pdf = pdf_eye.max(pdf_vpl);
        if pdf > self.density { self.density / pdf } else { 1.0 }
    }
}

/// The bound of the options, or one that suits the scene.
pub(crate) fn bound_of(world: &World, options: &RenderOptions) -> Bound {
    match (options.clamp, world.bounds()) {
        (Some(g), _) => Bound::on_geometry_term(g),
        (None, Some((lower, upper))) => Bound::for_scene([lower, upper], options.vpls),
        (None, None) => Bound::on_geometry_term(f32::INFINITY),
    }
}
