// SPDX-License-Identifier: GPL-3.0-or-later
//! The projections of cameras.
//! Tests: crates/shading/src/projective_camera.rs.

/// The map from directions to positions in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraProjection {
    /// A perspective.
    Perspective {
        /// Half the picture's height at distance 1.
        half_height: f32,
    },
    /// Parallel rays that begin in the plane of the eye.
    Parallel {
        /// Half the height of the visible region, world units.
        half_height: f32,
    },
    /// Angles to the view are distances from the picture's middle.
    Fisheye {
        /// Angle at the middle of the upper edge, radians.
        half_angle: f32,
    },
    /// Longitudes across, latitudes upwards.
    Panorama,
}
