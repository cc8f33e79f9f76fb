// SPDX-License-Identifier: GPL-3.0-or-later
//! Places of lamps near a point: where techniques aim that need a position, not light.
//! Source: the choice of [EK18], with the power over the squared distance in the leaves. Space: world.
//! Tests: `light_set_tests`.

use glam::Vec3;

use super::light_set::LightSet;

impl LightSet {
    /// The number of lights with a position.
    #[must_use]
    pub fn near_count(&self) -> usize {
        self.parts.finite_count()
    }

    /// Where a light that is likely to matter at `p` sends its light from: a place on it, or the middle of a sphere or a disc. By three
    /// numbers in [0, 1): one for the choice, two for the place. `None` if no light has a position. Lamps count whatever side of them `p` sees.
    #[must_use]
    pub fn near_place(&self, p: Vec3, [choice, x, y]: [f32; 3]) -> Option<Vec3> {
        let shapes = self.parts.shapes.as_ref().map_or(&[][..], |all| &all.shapes);
        let point = |light: u32| &self.parts.points[light as usize - shapes.len()];
        let brightness = |light: u32| {
            let (place, power, least) = match shapes.get(light as usize) {
                Some(shape) => (shape.p[0], shape.power, shape.area()),
                None => (point(light).position, point(light).power(), point(light).radius.powi(2)),
            };
            let brightness = power / place.distance_squared(p).max(least);
            if brightness.is_finite() { brightness } else { f32::MAX.sqrt() }
        };
        let (light, _) = self.near.tree.choose(p, Vec3::ZERO, choice, brightness)?;
        Some(match shapes.get(light as usize) {
            Some(shape) => shape.origin([x, y]),
            None => point(light).position,
        })
    }
}
