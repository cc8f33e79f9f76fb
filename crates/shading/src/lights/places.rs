// SPDX-License-Identifier: GPL-3.0-or-later
//! Places of lamps near a point: where techniques aim that need a position, not light.
//! Source: the choice of [EK18], with the power over the squared distance in the leaves. Space: world.
//! Tests: `light_set_tests`.

use glam::Vec3;
use gnurt_image::srgb::luminance;

use super::light_parts::{LightId, LightKind};
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
        let shape = |light: u32| self.parts.shapes.as_ref().and_then(|all| all.shapes.get(light as usize));
        let brightness = |light: u32| {
            let (place, power, least) = match (shape(light), self.kind(LightId(light))) {
                (Some(shape), _) => (shape.p[0], shape.power, shape.area()),
                (None, LightKind::Point(i)) => {
                    let point = &self.parts.points[i as usize];
                    (point.position, luminance(point.intensity.into()), point.radius * point.radius)
                }
                _ => return 0.0,
            };
            let brightness = power / place.distance_squared(p).max(least);
            if brightness.is_finite() { brightness } else { f32::MAX.sqrt() }
        };
        let (light, _) = self.near.tree.choose(p, Vec3::ZERO, choice, brightness)?;
        if let Some(shape) = shape(light) {
            return Some(shape.origin([x, y]));
        }
        match self.kind(LightId(light)) {
            LightKind::Point(i) => Some(self.parts.points[i as usize].position),
            _ => None,
        }
    }
}
