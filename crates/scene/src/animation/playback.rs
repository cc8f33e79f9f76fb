// SPDX-License-Identifier: GPL-3.0-or-later
//! What a scene remembers of the moment that it shows, so that the next one costs only what differs.
//! Two meshes take turns in showing a body: while the one is seen the other is free again, so that arrays that
//! nobody changes are neither copied nor taken anew. Tests: `tests/animation.rs::moments_share_what_stays`.

use std::sync::Arc;

use super::body::Bend;
use crate::camera::Camera;
use crate::light::Light;
use crate::material::Material;
use crate::mesh::Mesh;

/// What was last set; empty before the first moment.
#[derive(Clone, Debug, Default)]
pub(crate) struct Playback {
    /// Whether a moment was shown.
    pub(super) is_begun: bool,
    /// By body.
    pub(super) bodies: Vec<Shown>,
    /// By moving instance.
    pub(super) visible: Vec<bool>,
    /// By moving camera: as it is at rest.
    pub(super) cameras: Vec<Camera>,
    /// By moving light: as it is at rest.
    pub(super) lights: Vec<Light>,
    /// By moving material: what it was set to; another one there is somebody else's.
    pub(super) materials: Vec<Material>,
}

/// A body as the scene shows it.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    pub(super) bend: Option<Bend>,
    /// The mesh that it showed before.
    pub(super) spare: Option<Arc<Mesh>>,
}
