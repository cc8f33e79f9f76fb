// SPDX-License-Identifier: GPL-3.0-or-later
//! The types of scenes. In one file, since scenes hold instances and instances show scenes. Source: [WBS03a].
//! Space: world, unless stated otherwise. Invariant: objects are numbered in the order of the instances on
//! the path to them, so the lowest number is the lowest path. Tests: `tests/instances.rs`, `tests/nested.rs`,
//! `tests/moving_instances.rs`.

use std::sync::Arc;

use gnurt_accel_bvh::BoxIndex;
use gnurt_accel_core::affine::ObjectFromWorld;

use super::exact::Exact;
use super::leaves::Leaves;
use super::path::{MotionPath, Piece};
use crate::{ObjectTree, SharedList};

/// The largest number of levels of scenes, the outermost included.
pub const DEEPEST_SCENE: u32 = 16;

/// A scene of instances. After some of them moved, came or went, [`updated`](Self::updated) makes the next
/// one, which shares unchanged parts with it.
#[derive(Clone, Debug)]
pub struct SceneTree {
    /// Over the world boxes of instances, relative to a point near them where the scene is far away for its size.
    pub(super) top: BoxIndex,
    /// The index of the only instance that can be hit, if there is just one.
    pub(super) only: Option<usize>,
    /// By index in the list of the build.
    pub(super) slots: SharedList<Slot>,
    /// The same for rays, by place in `top`.
    pub(super) entries: Entries,
    /// The numbers of objects.
    pub(super) leaves: Leaves,
    /// Instances by the depth of their visible part: 0 for objects.
    pub(super) depths: [u32; DEEPEST_SCENE as usize],
    pub(super) dropped: u64,
    /// Number of instances that move during an open shutter, or show something that does.
    pub(super) moving: u32,
}

/// The object or scene that an instance shows.
#[derive(Clone, Debug)]
pub enum Shape {
    /// An object.
    Object(Arc<ObjectTree>),
    /// A scene with its own instances.
    Scene(Arc<SceneTree>),
}

/// An object or a scene, and where it is.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Shared by all instances of it.
    pub shape: Shape,
    /// Columns of the affine map to the space of the scene that the instance is in: images of the x, y and z axes, then
    /// of the origin. For a moving one, at time 0.
    pub world_from_object: [[f64; 3]; 4],
    /// Its motion during an open shutter; `None` = static. Replaces `world_from_object` for rays.
    pub motion: Option<Arc<MotionPath>>,
    /// Which rays see it: those whose mask has a bit in common with this one.
    pub mask: u32,
}

/// The state of an instance.
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

/// The transform of an instance, adjacent to its shape: a ray that enters one of many waits for memory once.
#[derive(Clone, Debug)]
pub(super) enum At {
    /// Static.
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

/// The map into an instance, and the number of its [`Shown`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Entry {
    pub(super) map: ObjectFromWorld,
    pub(super) shown: u32,
}

/// A shape of instances, and the mask of the rays that see it.
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
