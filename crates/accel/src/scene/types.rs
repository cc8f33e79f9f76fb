// SPDX-License-Identifier: GPL-3.0-or-later
//! What scenes are made of. In one file, since scenes hold instances and instances show scenes. Source: [WBS03a].
//! Space: world, unless it says otherwise. Invariant: objects are numbered in the order of the instances on the way to them, so
//! the lowest number is the lowest path. Tests: `tests/instances.rs`, `tests/nested.rs`, `tests/moving_instances.rs`.

use std::sync::Arc;

use gnurt_accel_bvh::BoxIndex;
use gnurt_accel_core::affine::ObjectFromWorld;

use super::exact::Exact;
use super::leaves::Leaves;
use super::path::{MotionPath, Piece};
use crate::{ObjectTree, SharedList};

/// Most scenes that may lie in one another, the outermost included.
pub const DEEPEST_SCENE: u32 = 16;

/// A scene of instances. When some of them move, come or go, [`updated`](Self::updated) makes the next one, which shares
/// with it what did not change.
#[derive(Clone, Debug)]
pub struct SceneTree {
    /// Over the world boxes of instances, relative to a point near them where the scene is far away for its size.
    pub(super) top: BoxIndex,
    /// The place of the only one that can be hit, where there is one only.
    pub(super) only: Option<usize>,
    /// By place in the list that the scene was built from.
    pub(super) slots: SharedList<Slot>,
    /// The same for rays, by place in `top`.
    pub(super) entries: Entries,
    /// The numbers of objects.
    pub(super) leaves: Leaves,
    /// Instances by the depth of what can be seen of them: 0 of objects.
    pub(super) depths: [u32; DEEPEST_SCENE as usize],
    pub(super) dropped: u64,
    /// How many instances move while the shutter is open, or show what does.
    pub(super) moving: u32,
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
    /// of the origin. Of one that moves, at moment 0.
    pub world_from_object: [[f64; 3]; 4],
    /// How it moves while the shutter is open; `None` = it stands still. Counts for rays in the place of `world_from_object`.
    pub motion: Option<Arc<MotionPath>>,
    /// Which rays see it: those whose mask has a bit in common with this one.
    pub mask: u32,
}

/// What there is of an instance.
#[expect(clippy::large_enum_variant, reason = "almost all are placed")]
#[derive(Clone, Debug, Default)]
pub(crate) enum Slot {
    /// None: it was taken out, or never put in.
    #[default]
    Absent,
    /// It cannot be placed.
    Refused,
    PlacedInstance(PlacedInstance),
}

/// An instance made ready for rays.
#[derive(Clone, Debug)]
pub(crate) struct PlacedInstance {
    pub(super) shape: Shape,
    pub(super) mask: u32,
    pub(super) at: At,
}

/// Where an instance is, side by side with what it shows: a ray that enters one of many waits for memory once.
#[derive(Clone, Debug)]
pub(super) enum At {
    /// It stands still.
    Still {
        /// `None` where world and object space are the same.
        object_from_world: Option<ObjectFromWorld>,
        /// The map in double precision.
        exact: Exact,
    },
    /// It moves on a path that has one piece, which is this.
    Piece(Piece, Arc<MotionPath>),
    /// It moves on a longer path.
    Path(Arc<MotionPath>),
}

/// The map into an instance, and the number of what is there.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Entry {
    pub(super) map: ObjectFromWorld,
    pub(super) shown: u32,
}

/// What instances show, and to which rays.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    pub(super) shape: Shape,
    pub(super) mask: u32,
}

/// The instances of a treelet.
#[derive(Debug, Default)]
pub(super) struct TreeletEntries {
    /// By place in the treelet.
    pub(super) list: Vec<Entry>,
    pub(super) shown: Vec<Shown>,
}

/// The instances of a scene, by treelet.
#[derive(Clone, Debug, Default)]
pub(super) struct Entries(pub(super) SharedList<Arc<TreeletEntries>>);
