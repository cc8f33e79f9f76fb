// SPDX-License-Identifier: GPL-3.0-or-later
//! Media on the two sides of a surface: absorbing, or none.
//! Source: Beer's law; KHR_materials_volume. Original: the ends of a path segment determine the absorption;
//! paths do not carry it. Rule: light between two points is absorbed by the medium at one of its ends; by the
//! mean of both where the ends disagree. So the result is the same from both ends of a path. A body within
//! another (within glass) sees the glass on a segment if one end is the glass's boundary. A segment without
//! end transmits nothing. Scattering media would belong here, too.
//! Space: world; 1 over world units. Tests: `tests`, crates/render/tests/agreement.rs.

use glam::Vec3;

/// The media on the two sides of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// Absorption coefficient, by colour, 1 over world units.
    pub absorption: Vec3,
    /// Whether it lies on the side that the first ray came from, or beyond.
    pub is_here: bool,
}

impl Medium {
    /// Something behind a surface that is seen from its front or from behind.
    #[must_use]
    pub fn behind(absorption: Vec3, is_front: bool) -> Self {
        Self { absorption, is_here: !is_front }
    }

    /// Absorption on one side.
    #[must_use]
    pub fn on(&self, is_here: bool) -> Vec3 {
        if self.is_here == is_here { self.absorption } else { Vec3::ZERO }
    }
}

/// Transmittance over this distance between two ends with these absorptions.
#[must_use]
pub fn left_after(distance: f32, ends: [Vec3; 2]) -> Vec3 {
    let absorption = match ends {
        [Vec3::ZERO, other] | [other, Vec3::ZERO] => other,
        [a, b] => (a + b) * 0.5,
    };
    let left = |a: f32| if a > 0.0 { (-a * distance).exp() } else { 1.0 };
    Vec3::new(left(absorption.x), left(absorption.y), left(absorption.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_absorbed_by_what_their_ends_say() {
        let (tea, ink) = (Vec3::new(0.1, 0.5, 2.0), Vec3::new(3.0, 0.5, 0.0));
        let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-6;
        assert_eq!(left_after(5.0, [Vec3::ZERO; 2]), Vec3::ONE, "nothing is there");
        assert!(near(left_after(2.0, [tea, Vec3::ZERO]), (-tea * 2.0).exp()), "Beer's law");
        assert_eq!(left_after(2.0, [tea, ink]), left_after(2.0, [ink, tea]), "either way");
        assert!(near(left_after(2.0, [tea, tea]), (-tea * 2.0).exp()), "both ends are of one body");
        let halves = left_after(0.7, [tea, tea]) * left_after(1.3, [tea, tea]);
        assert!(near(halves, left_after(2.0, [tea, tea])), "way by way");
        assert_eq!(
            left_after(f32::INFINITY, [ink, Vec3::ZERO]),
            Vec3::Z,
            "what is not absorbed comes from afar"
        );
        let medium = Medium::behind(tea, true);
        assert_eq!(
            [medium.on(true), medium.on(false)],
            [Vec3::ZERO, tea],
            "seen from the front it lies beyond"
        );
    }
}
