// SPDX-License-Identifier: GPL-3.0-or-later
//! One camera ray's view of a pixel, and how it differs from another one: at edges, many rays are worth their time.
//! Space: world; linear light. Tests: crates/render/tests/seen.rs.

/// Albedo, normal and split light of a camera ray.
pub(super) type View = [[f32; 3]; 3];

/// The most important difference between camera rays of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Differs {
    #[default]
    Nothing,
    /// Albedo or normal.
    Surface,
    /// The light of lamps and environment that is seen.
    Light,
}

/// The difference between two camera rays of a pixel, in albedo, normal or light.
pub(super) fn differ(a: &View, b: &View) -> Differs {
    // Light has any scale.
    let off = |layer: usize, most: f32, scale: f32| {
        (0..3).any(|k| {
            let (a, b) = (a[layer][k], b[layer][k]);
            (a - b).abs() > most * a.abs().max(b.abs()).max(scale)
        })
    };
    match (off(0, 0.05, 1.0) || off(1, 0.2, 1.0), off(2, 0.05, 0.0)) {
        (_, true) => Differs::Light,
        (true, false) => Differs::Surface,
        (false, false) => Differs::Nothing,
    }
}
