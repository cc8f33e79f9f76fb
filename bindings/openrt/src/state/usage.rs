// SPDX-License-Identifier: GPL-3.0-or-later
//! Which shaders light, see and surround the scene.
//! Source: \[DWBS03\]. Invariant: the ids are of shaders of the right kind; a deleted one still works.
//! Tests: tests/c/scene.c, tests/c/errors.c.

/// The shaders in use, those of surfaces excepted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Usage {
    /// Lights, in the order in which they were added; one may be there more than once.
    pub(crate) lights: Vec<u32>,
    /// The camera; the default one if none.
    pub(crate) camera: Option<u32>,
    /// The environment; black if none.
    pub(crate) environment: Option<u32>,
    /// How pictures are made; `Whitted` with the context's limits if none.
    pub(crate) rendering_object: Option<u32>,
    /// The rendering object in the shading language that computes the colours of pixels; without one, the
    /// radiance along their rays.
    pub(crate) pixel: Option<u32>,
}

impl Usage {
    /// All ids.
    pub(crate) fn ids(&self) -> impl Iterator<Item = u32> + '_ {
        let lights = self.lights.iter().copied();
        lights.chain(self.camera).chain(self.environment).chain(self.rendering_object).chain(self.pixel)
    }
}
