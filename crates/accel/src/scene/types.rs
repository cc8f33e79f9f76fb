// SPDX-License-Identifier: GPL-3.0-or-later
//! What scenes are made of. In one file, since scenes hold instances and instances show scenes. Source: [WBS03a].
//! Space: world, unless it says otherwise. Invariant: objects are numbered in the order of the instances on the way to them, so
//! the lowest number is the lowest path. Proof: `tests/instances.rs`, `tests/nested.rs`.

use std::sync::Arc;

use gnurt_accel_bvh::BoxIndex;
use gnurt_accel_core::affine::ObjectFromWorld;

use super::box64::Box64;
use crate::ObjectTree;

/// Most scenes that may lie in one another, the outermost included.
pub const DEEPEST_SCENE: u32 = 16;

/// A scene of instances; cheap to build anew when they move.
#[derive(Debug)]
pub struct SceneTree {
    /// Over the world boxes of instances, relative to a point near them where the scene is far away for its size; built
    /// anew whenever they move.
    pub(super) top: BoxIndex,
    /// Instances that can be hit, in the order of their ids.
    pub(super) placed: Vec<Placed>,
    /// Their maps in double precision.
    pub(super) exact: Vec<Exact>,
    pub(super) bounds64: Box64,
    pub(super) dropped: u64,
    /// Scenes on the longest way down, this one included.
    pub(super) depth: u32,
    /// Objects in all.
    pub(super) leaves: u32,
    /// Whether all instances are objects.
    pub(super) flat: bool,
}

/// What an instance shows.
#[derive(Clone, Debug)]
pub enum Shape {
    /// An object.
    Object(Arc<ObjectTree>),
    /// A scene with instances of its own.
    Scene(Arc<SceneTree>),
}

/// An object or a scene, and where it is.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Shared by all instances of it.
    pub shape: Shape,
    /// Columns of the affine map to the space of the scene that the instance is in: images of the x, y and z axes, then
    /// of the origin.
    pub world_from_object: [[f64; 3]; 4],
    /// Which rays see it: those whose mask has a bit in common with this one.
    pub mask: u32,
}

/// An instance made ready for rays.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(super) shape: Shape,
    /// Its number in the list that the scene was built from.
    pub(crate) inst_id: u32,
    /// The number of its first object among all of the scene.
    pub(super) first_leaf: u32,
    pub(super) mask: u32,
    /// `None` where world and object space are the same.
    pub(crate) object_from_world: Option<ObjectFromWorld>,
}

/// [`ObjectFromWorld`] in double precision, and its inverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exact {
    /// Rows of the linear part of the map into the object.
    pub(super) rows: [[f64; 3]; 3],
    /// Images of the axes, then of the origin.
    pub(super) columns: [[f64; 3]; 4],
}
