// SPDX-License-Identifier: GPL-3.0-or-later
//! All moving parts of a scene: nodes with their parents, the things attached to them, and the clips.
//! Source: after glTF 2.0. Only moving nodes are here; a fixed node is folded into a matrix. Invariants: a
//! node follows its parent in the list; every index is in range. Checked by `Scene::animate`.

use serde::{Deserialize, Serialize};

use crate::affine::Affine;
use crate::camera::Camera;
use crate::factors::Factors;
use crate::id::{CameraId, InstanceId, LightId, MaterialId, ObjectId};
use crate::light::{ConeEdge, Light};

use super::body::Body;
use super::clip::Clip;
use super::local::Local;

/// The moving parts and their motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Animation {
    /// Clips that can be played.
    pub clips: Vec<Clip>,
    /// Nodes that can move, parents first.
    pub nodes: Vec<Node>,
    /// Instances on nodes.
    pub instances: Vec<MovingInstance>,
    /// Members of objects on nodes.
    pub members: Vec<MovingMember>,
    /// Sets of morph weights, at rest.
    pub weights: Vec<Vec<f32>>,
    /// Skins with joints that can move.
    pub skins: Vec<Skin>,
    /// Meshes that bend.
    pub bodies: Vec<Body>,
    /// Vertical angles of view that are driven, at rest: radians.
    pub fields_of_view: Vec<f32>,
    /// Cameras that move, or whose angle is driven.
    pub cameras: Vec<MovingCamera>,
    /// Lights as they are at rest.
    pub light_factors: Vec<LightFactors>,
    /// Lights that move, or whose factors are driven.
    pub lights: Vec<MovingLight>,
    /// Materials whose factors are driven.
    pub materials: Vec<MovingMaterial>,
}

/// A node that can move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// A label.
    pub name: String,
    /// The node or matrix under it.
    pub parent: Attachment,
    /// Where it is on it, at rest.
    pub rest: Local,
    /// Whether it is seen, at rest, with all below it.
    pub visible: bool,
}

/// The attachment of a thing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Attachment {
    /// On a node that can move.
    On(u32),
    /// Where it always is.
    Fixed {
        /// A fixed transform and visibility.
        world_from_node: Affine,
        /// Whether all above it are seen.
        visible: bool,
    },
}

/// An instance that goes with a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovingInstance {
    /// Which.
    pub instance: InstanceId,
    /// Where.
    pub node: u32,
    /// Whether its transform is the node's; a skinned mesh's is the world's, and only its visibility is the
    /// node's.
    pub has_transform: bool,
}

/// A member of an object that follows a node.
///
/// The node's transform becomes the member's transform in the object that holds it. Its visibility depends on
/// the object's instances and the member's mask; the node does not affect it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MovingMember {
    /// The object that holds it.
    pub object: ObjectId,
    /// Its index among the object's members.
    pub member: u32,
    /// Where.
    pub node: u32,
}

/// Joints of a skin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Skin {
    /// Its joints.
    pub joints: Vec<Joint>,
    /// Whether one of them, or an ancestor, stretches at any time.
    pub stretches: bool,
}

/// A joint of a skin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Where it is.
    pub attachment: Attachment,
    /// The inverse of where it was when the mesh was bound to it.
    pub joint_from_mesh: Affine,
}

/// A camera that moves, or whose angle of view is driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovingCamera {
    /// Which.
    pub camera: CameraId,
    /// The node of the camera, which faces -z, with y up.
    pub attachment: Attachment,
    /// Which angle; a number of `Animation::fields_of_view`.
    pub field_of_view: u32,
}

/// A light that moves, or whose factors are driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovingLight {
    /// Which.
    pub light: LightId,
    /// The node of the light, which emits along -z.
    pub attachment: Attachment,
    /// Which factors; a number of `Animation::light_factors`.
    pub factors: u32,
}

/// A material whose factors are driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovingMaterial {
    /// Which.
    pub material: MaterialId,
    /// At rest.
    pub factors: Factors,
}

/// Kinds of light that nodes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LightKind {
    /// To all sides.
    Point,
    /// Into a cone.
    Spot,
    /// From far away.
    Directional,
}

/// Factors of a light, except its position and direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightFactors {
    /// The kind of light.
    pub kind: LightKind,
    /// Linear.
    pub color: [f32; 3],
    /// Multiplied to the colour.
    pub intensity: f32,
    /// Of the full cone, radians.
    pub inner_angle: f32,
    /// Where the cone ends, radians.
    pub outer_angle: f32,
}

impl LightFactors {
    /// The light at a transform; dark if it is invisible; `None` if a number is not finite.
    #[must_use]
    pub fn light(&self, world_from_light: &Affine, visible: bool) -> Option<Light> {
        let position = world_from_light.point([0.0; 3]).map(|x| x as f32);
        let direction = world_from_light.vector([0.0, 0.0, -1.0]).map(|x| x as f32);
        // Candela and lux as they are, as nits of emission are: docs/decisions/0019.
        let intensity = if visible { self.color.map(|c| c * self.intensity) } else { [0.0; 3] };
        let good = intensity.iter().chain(&position).chain(&direction).all(|x| x.is_finite());
        good.then(|| match self.kind {
            LightKind::Point => Light::Point { position, intensity, radius: 0.0 },
            LightKind::Directional => Light::Directional { direction, irradiance: intensity, angle: 0.0 },
            LightKind::Spot => {
                let outer_angle = self.outer_angle.clamp(1e-3, std::f32::consts::FRAC_PI_2);
                let inner_angle = self.inner_angle.clamp(0.0, outer_angle * 0.999);
                Light::Spot {
                    position,
                    direction,
                    intensity,
                    inner_angle,
                    outer_angle,
                    edge: ConeEdge::default(),
                    radius: 0.0,
                }
            }
        })
    }
}

/// A camera like `like` with another transform and another angle of view in radians; `None` if it is invalid.
#[must_use]
pub fn camera_at(like: &Camera, world_from_camera: &Affine, field_of_view: f32) -> Option<Camera> {
    let single = |v: [f64; 3]| v.map(|x| x as f32);
    let camera = Camera {
        eye: single(world_from_camera.point([0.0; 3])),
        target: single(world_from_camera.point([0.0, 0.0, -1.0])),
        up: single(world_from_camera.vector([0.0, 1.0, 0.0])),
        fov_y: field_of_view.to_degrees(),
        ..like.clone()
    };
    camera.fault().is_none().then_some(camera)
}

impl Animation {
    /// Bytes that its arrays hold.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        let channels = self.clips.iter().flat_map(|clip| &clip.channels);
        let joints = self.skins.iter().map(|skin| size_of_val(&skin.joints[..])).sum::<usize>();
        let bodies = self.bodies.iter().map(|body| body.memory_bytes() + body.base.memory_bytes());
        channels.map(|channel| channel.sampler.memory_bytes()).sum::<usize>()
            + size_of_val(&self.nodes[..])
            + joints
            + bodies.sum::<usize>()
    }
}
