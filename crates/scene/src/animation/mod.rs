// SPDX-License-Identifier: GPL-3.0-or-later
//! Animation: the moving parts of a scene and their state at a time.
//! Source: glTF 2.0 sections 3.7.2.2 (morph targets), 3.7.3 (skins), 3.11 and appendix C (animations); KHR_animation_pointer,
//! KHR_node_visibility.
//!
//! ```text
//! Clip (channels: Sampler -> Target) -- instant --> Instant (local transforms, weights, factors)
//!     -- rig: nodes, skins, bodies --> edits of the Scene: instances, meshes, cameras, lights, materials
//! ```
//!
//! A scene holds one [`Animation`] at most; [`Scene::pose`](crate::Scene::pose) edits the scene to show a
//! time of a clip. Unchanged parts are not edited, so they cost a commit nothing. An open shutter is an
//! [`Exposure`]: the moving parts at several times.
//! Space: nodes relative to their parents, cameras and lights in world space. Times are seconds, as files write them.
//! Tests: `tests/animation.rs`, `tests/animated_scenes.rs`.

mod between;
mod body;
mod check;
mod clip;
mod exposure;
mod instant;
mod local;
mod model;
mod playback;
mod pose;
mod sampler;

pub use body::{Bend, Body, Deltas, Influences, Morph};
pub use body::{add_morph, follow_joints, mirrored, reverse_mirrored, stretches};
pub use clip::{Channel, Clip, FactorPart, LightPart, Target, TexturePart};
pub use exposure::Exposure;
pub use local::{Local, Trs};
pub use model::camera_at;
pub use model::{
    Animation, Attachment, Joint, LightFactors, LightKind, MovingCamera, MovingInstance, MovingLight,
    MovingMaterial, MovingMember, Node, Skin,
};
pub(crate) use playback::Playback;
pub use pose::Posed;
pub use sampler::{Interpolation, Sampler, SamplerError};
