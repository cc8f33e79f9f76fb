// SPDX-License-Identifier: GPL-3.0-or-later
//! The state of objects in a world. In one file, since objects hold objects. [WBS03a], level by level.
//! Space: object. Numbers of objects in an object are those of the tree over them: [`SceneTree::instance_at`].
//! Tests: crates/render/tests/{commit,nested}.rs.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::{Aabb, MotionPath, MovingTree, ObjectTree, SceneTree, Shape, SharedList};
use gnurt_scene::{Affine, Member, Mesh, ObjectId, RayMask};

use super::areas::Areas;
use super::crowds::Kind;
use super::open::path;
use super::transform::Transform;

/// An object's arrays and the tree over them.
#[derive(Clone)]
pub(crate) struct WorldObject {
    /// By geometry id: the scene's meshes at commit. Shared with the scene until it edits them.
    pub(crate) meshes: Vec<Arc<Mesh>>,
    /// The same at times during the open shutter, by geometry id; empty for static ones.
    pub(crate) keys: Vec<Vec<Arc<Mesh>>>,
    pub(crate) tree: Arc<ObjectTree>,
    /// The same tree, with the data to follow moving meshes.
    pub(super) moving: MovingTree,
    pub(super) motion: gnurt_scene::Motion,
    /// Its topology, possibly shared with others; `None` for objects that must not deform.
    pub(super) kind: Option<Arc<Kind>>,
    /// Objects in it; `None` = there are none.
    pub(super) members: Option<Arc<Members>>,
    /// Materials of its meshes and of all objects in it, ascending.
    pub(super) materials: Arc<[u32]>,
    /// Whether meshes of it, or in it, bend while the shutter is open.
    pub(super) bends: bool,
    /// Whether objects in it move then.
    pub(super) members_move: bool,
    /// Of its meshes, computed at first use.
    pub(super) areas: Areas,
}

impl WorldObject {
    /// Identifies a topology.
    pub(super) fn kind_ptr(&self) -> *const () {
        self.kind.as_ref().map_or(std::ptr::null(), |kind| Arc::as_ptr(kind).cast())
    }

    /// The geometry that rays traverse.
    pub(super) fn shape(&self) -> Shape {
        match &self.members {
            Some(members) => members.tree.clone().into(),
            None => self.tree.clone().into(),
        }
    }

    /// The box around all of it.
    pub(super) fn bounds(&self) -> Aabb {
        self.members.as_ref().map_or_else(|| self.tree.bounds(), |members| members.tree.bounds())
    }

    /// Triangles that rays may meet, those of objects in it as often as they occur.
    pub(super) fn triangles(&self) -> u64 {
        self.members.as_ref().map_or_else(|| self.tree.stats().primitives, |members| members.triangles)
    }

    /// The member that holds number `leaf` of the objects in it, and that object's number there; `None` where it is the object
    /// itself.
    pub(super) fn member_at(&self, leaf: u32) -> Option<(&PlacedMember, u32)> {
        let members = self.members.as_ref()?;
        let (transform, inner) = members.tree.instance_at(leaf)?;
        members.get(transform as usize).map(|member| (member, inner))
    }

    /// Whether some material of its meshes, or of those in it, is one of these.
    pub(super) fn has_material(&self, is_one: impl Fn(usize) -> bool) -> bool {
        self.materials.iter().any(|&material| is_one(material as usize))
    }

    /// The same with members.
    pub(super) fn with_members(mut self, members: Members) -> Self {
        let inner = members.iter().flat_map(|(_, member, _)| member.object.materials.iter().copied());
        let own = self.meshes.iter().map(|mesh| mesh.material.0);
        // Of many members most are of few objects.
        let all: BTreeSet<u32> = own.chain(inner).collect();
        self.bends = bends(&self.keys) || members.iter().any(|(_, member, _)| member.object.bends);
        let moves = |member: &PlacedMember| member.motion.is_some() || member.object.members_move;
        self.members_move = members.iter().any(|(_, member, _)| moves(member));
        (self.materials, self.members) = (all.into_iter().collect(), Some(Arc::new(members)));
        self
    }
}

/// Materials of meshes, ascending.
pub(super) fn materials_of(meshes: &[Arc<Mesh>]) -> Arc<[u32]> {
    let all: BTreeSet<u32> = meshes.iter().map(|mesh| mesh.material.0).collect();
    all.into_iter().collect()
}

/// Whether some of an object's meshes bend while the shutter is open.
pub(super) fn bends(keys: &[Vec<Arc<Mesh>>]) -> bool {
    keys.iter().any(|keys| !keys.is_empty())
}

/// The state of an object of the scene.
#[derive(Clone, Default)]
pub(super) struct ObjectSlot {
    /// `None` where no visible instance needs it.
    pub(super) object: Option<Arc<WorldObject>>,
    /// Visible instances, and objects in use that hold it.
    pub(super) users: u32,
    /// The objects that it holds, ascending, each once; empty while it is unused.
    pub(super) holds: Arc<[u32]>,
}

/// Objects in an object.
pub(crate) struct Members {
    /// Over them, and over the object's own meshes.
    pub(super) tree: Arc<SceneTree>,
    /// By index in the description's list.
    pub(super) list: SharedList<MemberSlot>,
    /// Triangles that rays may meet, each as often as it occurs.
    pub(super) triangles: u64,
}

/// The state of a member.
#[derive(Clone, Default)]
pub(super) struct MemberSlot {
    /// As the scene has it; `None` before it is made.
    pub(super) from: Option<Member>,
    /// `None` if it flattens, or is not finite.
    pub(super) placed: Option<PlacedMember>,
}

/// An object within another.
#[derive(Clone)]
pub(crate) struct PlacedMember {
    pub(crate) object: Arc<WorldObject>,
    pub(crate) object_id: ObjectId,
    pub(super) transform: Transform,
    /// The greatest coordinates that its points have in the object that holds it.
    reach: Vec3,
    /// Its path during the open shutter; `transform` is its start.
    pub(super) motion: Option<Arc<MotionPath>>,
}

impl PlacedMember {
    /// A member of the scene, with its transforms during the open shutter.
    pub(super) fn new(
        member: &Member,
        objects: &SharedList<ObjectSlot>,
        positions: Option<&[Affine]>,
    ) -> Option<Self> {
        let object = objects.get(member.object.index()).and_then(|slot| slot.object.clone())?;
        let transform = Transform::new(&member.object_from_member)?;
        let reach = reach(&object, &transform);
        let motion = positions.and_then(|positions| path(positions, &object.bounds()));
        Some(Self { object, object_id: member.object, transform, reach, motion })
    }

    /// Its transform at a time, in the world where the object that holds it is at `outer`.
    pub(super) fn at(&self, outer: &Transform, time: f32) -> Transform {
        // Where it is flat then, it stays.
        let moved =
            self.motion.as_ref().and_then(|motion| Transform::new(&Affine { columns: motion.at(time) }));
        match moved {
            Some(transform) => outer.then(&transform, reach(&self.object, &transform)),
            None => outer.then(&self.transform, self.reach),
        }
    }
}

/// The greatest coordinates that points of an object have where it is.
fn reach(object: &WorldObject, transform: &Transform) -> Vec3 {
    let Aabb { min, max } = object.bounds();
    if min[0] > max[0] { Vec3::ZERO } else { transform.reach(min.into(), max.into()) }
}

impl Members {
    /// Members that are left out.
    pub(super) fn dropped(&self) -> usize {
        self.list.iter().filter(|slot| slot.placed.is_none()).count() + self.tree.dropped_instances() as usize
    }

    /// A member, if it is there.
    pub(super) fn get(&self, transform: usize) -> Option<&PlacedMember> {
        self.list.get(transform).and_then(|slot| slot.placed.as_ref())
    }

    /// All present members, with the index of the first object in each, and its visibility mask.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, &PlacedMember, RayMask)> {
        let there = (0..).zip(self.list.iter());
        there.filter_map(|(transform, slot)| {
            let mask = slot.from.map_or(RayMask::ALL, |member| member.mask);
            Some((self.tree.first_leaf(transform), slot.placed.as_ref()?, mask))
        })
    }

    /// The number of the object's own meshes.
    pub(super) fn own_leaf(&self) -> u32 {
        self.tree.first_leaf(self.list.len() as u32)
    }
}
