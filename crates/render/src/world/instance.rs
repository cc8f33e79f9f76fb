// SPDX-License-Identifier: GPL-3.0-or-later
//! An object put somewhere: single-precision transforms for shading. Source: original.
//! Invariant: the transform of a placed instance has an inverse.

use std::sync::Arc;

use glam::{DMat3, Mat3, Vec3};
use gnurt_accel::{MotionPath, SharedList};
use gnurt_scene::{Affine, Instance, ObjectId, RayMask};

use super::object::{ObjectSlot, WorldObject};
use super::open::path;

/// An instance as shading needs it.
#[derive(Clone)]
pub(crate) struct PlacedInstance {
    pub(crate) object: Arc<WorldObject>,
    pub(crate) object_id: ObjectId,
    /// Which rays see it.
    pub(crate) mask: RayMask,
    /// Linear part of `world_from_object`.
    pub(crate) linear: Mat3,
    /// Where the object's origin is in the world.
    pub(crate) origin: Vec3,
    /// Transforms normals; unit length is lost, their side is kept also where `linear` mirrors.
    pub(crate) normals: Mat3,
    /// Whether `linear` mirrors: triangles wind the other way round in the world.
    pub(crate) mirrors: bool,
    /// Its way while the shutter is open; all the above is where it is at first.
    pub(crate) motion: Option<Arc<MotionPath>>,
}

/// What there is of an instance of the scene.
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
    /// An instance as the scene has it, if it shows an object that is there; and its places while the shutter is open.
    pub(super) fn new(
        instance: &Instance,
        objects: &SharedList<ObjectSlot>,
        places: Option<&[Affine]>,
    ) -> Self {
        let object = objects.get(instance.object.index()).and_then(|slot| slot.object.clone());
        let Some(object) = object.filter(|_| instance.visible) else { return Self::Hidden };
        match PlacedInstance::new(object, instance.object, &instance.world_from_object, instance.mask) {
            Some(placed) => {
                let motion = places.and_then(|places| path(places, &placed.object.tree.bounds()));
                Self::Placed(PlacedInstance { motion, ..placed })
            }
            None => Self::Dropped(instance.object),
        }
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
    /// `None` if the transform flattens or is not finite, in double or single precision.
    pub(crate) fn new(
        object: Arc<WorldObject>,
        object_id: ObjectId,
        world_from_object: &Affine,
        mask: RayMask,
    ) -> Option<Self> {
        world_from_object.inverse()?;
        let [x, y, z, origin] = world_from_object.columns;
        let linear = DMat3::from_cols(x.into(), y.into(), z.into());
        // Only directions matter: scaled to the size of 1 so that nothing overflows.
        let normals = {
            let inverse = linear.inverse().transpose();
            let largest = inverse.to_cols_array().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            inverse * (1.0 / largest)
        };
        let placed = Self {
            object,
            object_id,
            mask,
            linear: linear.as_mat3(),
            origin: Vec3::from(origin.map(|x| x as f32)),
            normals: normals.as_mat3(),
            mirrors: linear.determinant() < 0.0,
            motion: None,
        };
        let finite = placed.linear.is_finite() && placed.origin.is_finite() && placed.normals.is_finite();
        finite.then_some(placed)
    }

    /// Where it is at a moment, if it moves and has a place then.
    pub(crate) fn at(&self, time: f32) -> Option<Self> {
        let columns = self.motion.as_ref()?.at(time);
        Self::new(self.object.clone(), self.object_id, &Affine { columns }, self.mask)
    }

    /// A point of the object in the world.
    pub(crate) fn point(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.origin
    }
}
