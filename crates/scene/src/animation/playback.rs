// SPDX-License-Identifier: GPL-3.0-or-later
//! The pose that a scene shows, kept so that the next pose costs only its differences. Two meshes alternate
//! in showing a deforming mesh: while one is shown, the other is free again, so that unchanged arrays are
//! neither copied nor allocated again. Tests: `tests/animation.rs::moments_share_what_stays`.

use std::sync::Arc;

use super::body::Bend;
use crate::camera::Camera;
use crate::light::Light;
use crate::material::Material;
use crate::mesh::Mesh;

/// The values set last; empty before the first pose.
#[derive(Clone, Debug, Default)]
pub(crate) struct Playback {
    /// Whether a pose was shown.
    pub(crate) is_begun: bool,
    /// By body.
    pub(super) bodies: Vec<Shown>,
    /// By moving instance.
    pub(super) visible: Vec<bool>,
    /// By moving camera: as it is at rest.
    pub(super) cameras: Vec<Camera>,
    /// By moving light: as it is at rest.
    pub(super) lights: Vec<Light>,
    /// For each moving material, the value set last; another value comes from the caller.
    pub(super) materials: Vec<Material>,
}

/// A body as the scene shows it.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    pub(super) bend: Option<Bend>,
    /// The mesh that it showed before.
    pub(super) spare: Option<Arc<Mesh>>,
}
