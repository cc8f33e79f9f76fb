// SPDX-License-Identifier: GPL-3.0-or-later
//! Conversion of colours from Rec. 709, in which scenes are described, to the working space of a rendering.
//! Factors, textures and colours of meshes are multiplied first, as their formats say, and converted then.
//! Space: linear light. Tests: crates/render/tests/working_space.rs.

use glam::{Mat3, Vec3};
use gnurt_image::WorkingSpace;

/// A conversion of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColorMap(Option<Mat3>);

impl ColorMap {
    /// The conversion to a working space.
    #[must_use]
    pub fn to(space: WorkingSpace) -> Self {
        Self(space.from_rec709().map(|rows| Mat3::from_cols_array_2d(&rows).transpose()))
    }

    /// A colour in the working space.
    #[inline]
    #[must_use]
    pub fn of(&self, color: Vec3) -> Vec3 {
        self.0.map_or(color, |matrix| matrix * color)
    }

    /// Index of refraction and extinction of a metal: those with the converted extinction and reflectance at normal
    /// incidence.
    #[must_use]
    pub fn metal(&self, eta: Vec3, k: Vec3) -> (Vec3, Vec3) {
        if self.0.is_none() {
            return (eta, k);
        }
        let reflectance = ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
        let (mean, k, r) = (self.of(eta), self.of(k), self.of(reflectance));
        let index = |c: usize| {
            // (eta - 1)^2 + k^2 = r ((eta + 1)^2 + k^2)
            let (k, r) = (k[c], r[c].min(0.999_9));
            let half = (1.0 + r) / (1.0 - r);
            let root = (half * half - 1.0 - k * k).max(0.0).sqrt();
            // Two indices reflect as much; one is about as large as before.
            if (half - root - mean[c]).abs() < (half + root - mean[c]).abs() {
                half - root
            } else {
                half + root
            }
        };
        (Vec3::new(index(0), index(1), index(2)), k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reflectance(eta: Vec3, k: Vec3) -> Vec3 {
        ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
    }

    #[test]
    fn metals_keep_their_colour() {
        let gold = (Vec3::new(0.143, 0.375, 1.442), Vec3::new(3.983, 2.386, 1.603));
        let copper = (Vec3::new(0.200, 0.924, 1.102), Vec3::new(3.912, 2.452, 2.142));
        let map = ColorMap::to(WorkingSpace::AcesCg);
        for (eta, k) in [gold, copper] {
            let (new_eta, new_k) = map.metal(eta, k);
            let off = (reflectance(new_eta, new_k) - map.of(reflectance(eta, k))).abs().max_element();
            assert!(off < 1e-4, "{off}");
            assert!((new_eta - map.of(eta)).abs().max_element() < 0.3, "{new_eta} beside {}", map.of(eta));
            assert_eq!(ColorMap::default().metal(eta, k), (eta, k), "nothing changes in Rec. 709");
        }
    }
}
