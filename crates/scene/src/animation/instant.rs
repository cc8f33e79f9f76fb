// SPDX-License-Identifier: GPL-3.0-or-later
//! The state of an animation at one time: the values of channels, and the transforms of nodes.
//! Source: glTF 2.0 section 3.11. It is computed from the rest pose each time, so it does not depend on
//! earlier poses.
//! Space: world. Tests: `tests/animation.rs`.

use super::body::Bend;
use super::clip::{Clip, FactorPart, LightPart, Target, TexturePart};
use super::local::Local;
use super::model::{Animation, Attachment, LightFactors};
use super::sampler::Sampler;
use crate::affine::Affine;
use crate::factors::{Factors, MappedTexture};

/// Values at one time.
pub(super) struct Instant {
    locals: Vec<Local>,
    visible: Vec<bool>,
    pub(super) weights: Vec<Vec<f32>>,
    pub(super) fields_of_view: Vec<f32>,
    pub(super) lights: Vec<LightFactors>,
    pub(super) materials: Vec<Factors>,
}

/// Where a node is, and whether it is seen.
#[derive(Clone, Copy)]
pub(super) struct NodePose {
    pub(super) world_from_node: Affine,
    pub(super) visible: bool,
}

impl Instant {
    /// Everything at rest.
    pub(super) fn rest(animation: &Animation) -> Self {
        Self {
            locals: animation.nodes.iter().map(|node| node.rest).collect(),
            visible: animation.nodes.iter().map(|node| node.visible).collect(),
            weights: animation.weights.clone(),
            fields_of_view: animation.fields_of_view.clone(),
            lights: animation.light_factors.clone(),
            materials: animation.materials.iter().map(|material| material.factors.clone()).collect(),
        }
    }

    /// Sets all targets of a clip to their values at a time.
    pub(super) fn play(&mut self, clip: &Clip, seconds: f64) {
        for channel in &clip.channels {
            self.set(channel.target, &channel.sampler, seconds);
        }
    }

    fn set(&mut self, target: Target, sampler: &Sampler, seconds: f64) {
        let parts = |locals: &mut [Local], node: u32, set: &dyn Fn(&mut super::Trs)| {
            if let Some(Local::Parts(parts)) = locals.get_mut(node as usize) {
                set(parts);
            }
        };
        match target {
            Target::Translation(node) => {
                parts(&mut self.locals, node, &|parts| parts.translation = vector(sampler, seconds));
            }
            Target::Scale(node) => {
                parts(&mut self.locals, node, &|parts| parts.scale = vector(sampler, seconds));
            }
            Target::Rotation(node) => {
                parts(&mut self.locals, node, &|parts| parts.rotation = Some(sampler.rotation(seconds)));
            }
            Target::Visible(node) => self.visible[node as usize] = sampler.step(seconds)[0] != 0.0,
            Target::Weights(set) => {
                let mut values = vec![0.0; sampler.width()];
                sampler.sample(seconds, &mut values);
                let to = &mut self.weights[set as usize];
                to.iter_mut().zip(values).for_each(|(to, value)| *to = value as f32);
            }
            Target::Weight(set, weight) => {
                self.weights[set as usize][weight as usize] = number(sampler, seconds);
            }
            Target::FieldOfView(angle) => self.fields_of_view[angle as usize] = number(sampler, seconds),
            Target::Light(light, part) => set_light(&mut self.lights[light as usize], part, sampler, seconds),
            Target::Material(material, part) => {
                set_factor(&mut self.materials[material as usize], part, sampler, seconds);
            }
        }
    }

    /// Where all nodes are.
    pub(super) fn node_poses(&self, animation: &Animation) -> Vec<NodePose> {
        let mut node_poses: Vec<NodePose> = Vec::with_capacity(animation.nodes.len());
        for (i, node) in animation.nodes.iter().enumerate() {
            let parent = at(&node.parent, &node_poses);
            node_poses.push(NodePose {
                world_from_node: parent.world_from_node * self.locals[i].affine(),
                visible: parent.visible && self.visible[i],
            });
        }
        node_poses
    }

    /// How a body is bent.
    pub(super) fn bend(&self, animation: &Animation, body: usize, node_poses: &[NodePose]) -> Bend {
        let body = &animation.bodies[body];
        let weights = body.weights.map(|set| self.weights[set as usize].clone());
        let skin = body.skin.map(|skin| &animation.skins[skin as usize]);
        let matrix =
            |joint: &super::Joint| at(&joint.attachment, node_poses).world_from_node * joint.joint_from_mesh;
        Bend {
            weights: weights.unwrap_or_default(),
            joints: skin.map(|skin| skin.joints.iter().map(matrix).collect()).unwrap_or_default(),
            stretches: skin.is_some_and(|skin| skin.stretches),
        }
    }
}

/// Where something is.
pub(super) fn at(attachment: &Attachment, node_poses: &[NodePose]) -> NodePose {
    match *attachment {
        Attachment::On(node) => node_poses[node as usize],
        Attachment::Fixed { world_from_node, visible } => NodePose { world_from_node, visible },
    }
}

fn vector(sampler: &Sampler, seconds: f64) -> [f64; 3] {
    let mut value = [0.0; 3];
    sampler.sample(seconds, &mut value);
    value
}

fn numbers<const N: usize>(sampler: &Sampler, seconds: f64) -> [f32; N] {
    let mut value = [0.0; N];
    sampler.sample(seconds, &mut value);
    value.map(|x| x as f32)
}

fn number(sampler: &Sampler, seconds: f64) -> f32 {
    let [value] = numbers(sampler, seconds);
    value
}

fn set_light(light: &mut LightFactors, part: LightPart, sampler: &Sampler, seconds: f64) {
    match part {
        LightPart::Color => light.color = numbers(sampler, seconds),
        LightPart::Intensity => light.intensity = number(sampler, seconds),
        LightPart::InnerAngle => light.inner_angle = number(sampler, seconds),
        LightPart::OuterAngle => light.outer_angle = number(sampler, seconds),
    }
}

fn set_factor(to: &mut Factors, part: FactorPart, sampler: &Sampler, seconds: f64) {
    use FactorPart as P;
    let single = match part {
        P::BaseColor => return to.base_color = numbers(sampler, seconds),
        P::Emission => return to.emission = numbers(sampler, seconds),
        P::SpecularColor => return to.specular_color = numbers(sampler, seconds),
        P::SheenColor => return to.sheen_color = numbers(sampler, seconds),
        P::AttenuationColor => return to.attenuation_color = numbers(sampler, seconds),
        P::DiffuseTransmissionColor => {
            return to.diffuse_transmission_color = numbers(sampler, seconds);
        }
        P::AnisotropyTexture(part) => {
            return set_texture(&mut to.anisotropy_texture, part, sampler, seconds);
        }
        P::BaseTexture(part) => return set_texture(&mut to.base_texture, part, sampler, seconds),
        P::MetallicRoughnessTexture(part) => {
            return set_texture(&mut to.metallic_roughness_texture, part, sampler, seconds);
        }
        P::NormalTexture(part) => return set_texture(&mut to.normal_texture, part, sampler, seconds),
        P::EmissionTexture(part) => return set_texture(&mut to.emission_texture, part, sampler, seconds),
        P::Metallic => &mut to.metallic,
        P::Roughness => &mut to.roughness,
        P::EmissionStrength => &mut to.emission_strength,
        P::AlphaCutoff => &mut to.alpha_cutoff,
        P::NormalScale => &mut to.normal_scale,
        P::Ior => &mut to.ior,
        P::Specular => &mut to.specular,
        P::Clearcoat => &mut to.clearcoat,
        P::ClearcoatRoughness => &mut to.clearcoat_roughness,
        P::SheenRoughness => &mut to.sheen_roughness,
        P::Transmission => &mut to.transmission,
        P::Thickness => &mut to.thickness,
        P::AttenuationDistance => &mut to.attenuation_distance,
        P::Dispersion => &mut to.dispersion,
        P::Anisotropy => &mut to.anisotropy,
        P::AnisotropyRotation => &mut to.anisotropy_rotation,
        P::Iridescence => &mut to.iridescence,
        P::IridescenceIor => &mut to.iridescence_ior,
        P::IridescenceThickness => &mut to.iridescence_thickness,
        P::DiffuseTransmission => &mut to.diffuse_transmission,
    };
    *single = number(sampler, seconds);
}

fn set_texture(to: &mut Option<MappedTexture>, part: TexturePart, sampler: &Sampler, seconds: f64) {
    let Some(texture) = to else { return };
    let transform = texture.transform.get_or_insert_default();
    match part {
        TexturePart::Offset => transform.offset = numbers(sampler, seconds),
        TexturePart::Rotation => transform.rotation = number(sampler, seconds),
        TexturePart::Scale => transform.scale = numbers(sampler, seconds),
    }
}
