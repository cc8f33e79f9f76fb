// SPDX-License-Identifier: GPL-3.0-or-later
//! A placed object, and the parts of it that a hit names.
//! Invariant: the transform of a placed instance has an inverse.

use std::sync::Arc;

use gnurt_accel::{MotionPath, SharedList};
use gnurt_scene::{Affine, Instance, ObjectId, RayMask};

use super::object::{ObjectSlot, WorldObject};
use super::open::path;
use super::transform::Transform;

/// An instance as shading needs it.
#[derive(Clone)]
pub(crate) struct PlacedInstance {
    pub(crate) object: Arc<WorldObject>,
    pub(crate) object_id: ObjectId,
    /// Which rays see it.
    pub(crate) mask: RayMask,
    pub(crate) transform: Transform,
    /// Its path during the open shutter; `transform` is its start.
    pub(crate) motion: Option<Arc<MotionPath>>,
    /// Ids of mattes: its own, and that of its asset.
    pub(crate) mattes: [u32; 2],
}

/// The state of an instance of the scene.
#[derive(Clone, Default)]
pub(super) enum InstanceSlot {
    /// Rays do not meet it.
    #[default]
    Hidden,
    /// They would, but its transform flattens or is not finite.
    Dropped(ObjectId),
    Placed(PlacedInstance),
}

impl InstanceSlot {
    /// An instance of the scene, if its object exists; with its transforms during the open shutter, and its ids of mattes.
    pub(super) fn new(
        instance: &Instance,
        objects: &SharedList<ObjectSlot>,
        transforms: Option<&[Affine]>,
        mattes: [u32; 2],
    ) -> Self {
        let object = objects.get(instance.object.index()).and_then(|slot| slot.object.clone());
        let Some(object) = object.filter(|_| instance.visible) else { return Self::Hidden };
        let Some(transform) = Transform::new(&instance.world_from_object) else {
            return Self::Dropped(instance.object);
        };
        let motion = transforms.and_then(|transforms| path(transforms, &object.bounds()));
        Self::Placed(PlacedInstance {
            object,
            object_id: instance.object,
            mask: instance.mask,
            transform,
            motion,
            mattes,
        })
    }

    pub(super) fn placed(&self) -> Option<&PlacedInstance> {
        match self {
            Self::Placed(placed) => Some(placed),
            Self::Hidden | Self::Dropped(_) => None,
        }
    }

    /// The object that it needs.
    pub(super) fn object(&self) -> Option<ObjectId> {
        match self {
            Self::Hidden => None,
            Self::Dropped(object) => Some(*object),
            Self::Placed(placed) => Some(placed.object_id),
        }
    }

    pub(super) fn is_dropped(&self) -> bool {
        matches!(self, Self::Dropped(_))
    }
}

impl PlacedInstance {
    /// Its transform at a time.
    pub(crate) fn at(&self, time: f32) -> Transform {
        // Where it is flat then, it stays.
        let moved =
            self.motion.as_ref().and_then(|motion| Transform::new(&Affine { columns: motion.at(time) }));
        moved.unwrap_or(self.transform)
    }

    /// The transform of its object number `leaf` at a time.
    pub(crate) fn leaf_at(&self, leaf: u32, time: f32) -> Transform {
        let (mut object, mut leaf, mut transform) = (&*self.object, leaf, self.at(time));
        while let Some((member, inner)) = object.member_at(leaf) {
            transform = member.at(&transform, time);
            (object, leaf) = (&member.object, inner);
        }
        transform
    }

    /// Number `leaf` of the objects that it shows, and its id.
    pub(crate) fn leaf(&self, leaf: u32) -> (&WorldObject, ObjectId) {
        let (mut object, mut id, mut leaf) = (&*self.object, self.object_id, leaf);
        while let Some((member, inner)) = object.member_at(leaf) {
            (object, id, leaf) = (&member.object, member.object_id, inner);
        }
        (object, id)
    }
}
