// SPDX-License-Identifier: GPL-3.0-or-later
//! The origin of a mesh that lies far from the file's: coordinates of maps have more digits than single
//! precision holds. The mesh is stored relative to a point near its first vertex; the instance that shows it
//! holds that point in double precision. Space: that of the file. Tests: `tests`,
//! `tests/solids.rs::far_meshes_keep_their_shape`.

use crate::affine::Affine;

/// Coordinates beyond this have steps of a thousandth or more in single precision.
const FAR: f64 = 16384.0;
/// Origins are multiples of this, so that nothing is rounded by them.
const STEP: f64 = 1024.0;

/// An origin, chosen by the first point.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Origin(Option<[f64; 3]>);

impl Origin {
    /// The file's own, for meshes without a place for another.
    pub(crate) const FIXED: Self = Self(Some([0.0; 3]));

    /// A point relative to the origin.
    #[inline]
    pub(crate) fn place(&mut self, point: [f64; 3]) -> [f32; 3] {
        let near = |x: f64| if x.abs() > FAR && x.is_finite() { (x / STEP).round() * STEP } else { 0.0 };
        let origin = self.0.get_or_insert_with(|| point.map(near));
        [0, 1, 2].map(|k| (point[k] - origin[k]) as f32)
    }

    /// The same for many points.
    pub(crate) fn place_all(&mut self, points: &[[f64; 3]], into: &mut Vec<[f32; 3]>) {
        let Some((first, rest)) = points.split_first() else { return };
        into.push(self.place(*first));
        let origin = self.0.unwrap_or_default();
        into.extend(rest.iter().map(|point| [0, 1, 2].map(|k| (point[k] - origin[k]) as f32)));
    }

    /// Where the mesh is.
    pub(crate) fn file_from_mesh(&self) -> Affine {
        Affine::translation(self.0.unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_points_are_exact() {
        let mut origin = Origin::default();
        assert_eq!(origin.place([500_000.125, 3.0, -4_649_776.25]), [288.125, 3.0, 207.75], "near the first");
        assert_eq!(origin.place([500_001.0, 0.0, -4_649_776.0]), [289.0, 0.0, 208.0], "by the same origin");
        assert_eq!(
            origin.file_from_mesh().point([288.125, 3.0, 207.75]),
            [500_000.125, 3.0, -4_649_776.25],
            "back"
        );
        let mut near = Origin::default();
        assert_eq!(near.place([16_000.0, 0.1, 0.0]), [16_000.0, 0.1, 0.0], "as they are");
        assert_eq!(near.file_from_mesh(), Affine::IDENTITY, "no other place");
        assert_eq!(Origin::FIXED.clone().place([1e6; 3]), [1e6; 3], "fixed");
        assert!(Origin::default().place([f64::NAN, f64::INFINITY, 0.0])[1].is_infinite(), "odd ones stay");
    }
}
