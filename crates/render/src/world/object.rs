// SPDX-License-Identifier: GPL-3.0-or-later
//! A committed object. Source: original. Space: object.

use std::sync::Arc;

use gnurt_accel::ObjectTree;
use gnurt_scene::Mesh;

/// An object's arrays and the tree over them.
pub(crate) struct WorldObject {
    /// By geometry id: what the scene's meshes were at commit. Shared with the scene until it edits them.
    pub(crate) meshes: Vec<Arc<Mesh>>,
    pub(crate) tree: Arc<ObjectTree>,
}
