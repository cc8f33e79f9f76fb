// SPDX-License-Identifier: GPL-3.0-or-later
//! Position and axes of a camera whose rays a script makes.
//! Space: world.

/// Position and axes of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFrame {
    /// Where it is.
    pub eye: [f32; 3],
    /// Unit, to the right.
    pub right: [f32; 3],
    /// Unit, upwards.
    pub up: [f32; 3],
    /// Unit, towards the viewer: the camera looks along its opposite.
    pub back: [f32; 3],
    /// Pixels of the picture, across and down.
    pub pixels: [u32; 2],
}
