// SPDX-License-Identifier: GPL-3.0-or-later
//! Typed ids, so that the compiler rejects a mesh id in place of a material id.
//! Invariant: an id is the position of its value in the scene's array; values are never removed,
//! only replaced, so an id stays good for the life of its scene.

use serde::{Deserialize, Serialize};

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub struct $name(pub u32);

        impl $name {
            /// The position of the value in the scene's array.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

ids! {
    /// A [`Mesh`](crate::Mesh).
    MeshId,
    /// An [`Object`](crate::Object): one or more meshes that share an acceleration structure.
    ObjectId,
    /// An [`Instance`](crate::Instance) of an object.
    InstanceId,
    /// A [`Material`](crate::Material).
    MaterialId,
    /// A [`Texture`](crate::Texture).
    TextureId,
    /// A [`Light`](crate::Light).
    LightId,
    /// A [`Medium`](crate::Medium).
    MediumId,
    /// A [`Camera`](crate::Camera).
    CameraId,
}
