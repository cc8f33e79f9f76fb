// SPDX-License-Identifier: GPL-3.0-or-later
//! Nodes: the moving ones with their parents, then instances, lights and cameras, on them or on their own.
//! Source: glTF 2.0 section 3.5; KHR_lights_punctual, KHR_node_visibility. Tests: `tests/save.rs`.

use std::collections::HashMap;
use std::path::Path;

use serde_json::{Value, json};

use super::mesh::{body, shown_meshes};
use gnurt_scene::RayMask;
use gnurt_scene::Scene;
use gnurt_scene::affine::Affine;
use gnurt_scene::animation::{Animation, Attachment, LightFactors, LightKind, Local};
use gnurt_scene::camera::Camera;
use gnurt_scene::id::{InstanceId, LightId};
use gnurt_scene::io::writer::leave_out;
use gnurt_scene::io::{Error, Warnings};
use gnurt_scene::labels::Shining;
use gnurt_scene::light::{ConeEdge, Light};

/// Nodes for objects in objects, unfolded, that a file may have.
const MOST_NODES: usize = 1 << 24;

/// The nodes of a file.
#[derive(Default)]
pub(super) struct Nodes {
    pub(super) list: Vec<Value>,
    pub(super) roots: Vec<usize>,
    pub(super) lights: Vec<Value>,
    /// By the animation's nodes.
    pub(super) moving: Vec<usize>,
    /// Nodes with meshes of each set of weights of the animation.
    pub(super) weighted: HashMap<u32, Vec<usize>>,
    /// Written lights by the animation's factors.
    pub(super) light_factors: HashMap<u32, usize>,
    /// The nodes of the animation's skins.
    skinned: Vec<(usize, u32)>,
}

impl Nodes {
    /// The nodes of a scene whose moving instances are all visible.
    pub(super) fn new(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<Self, Error> {
        let mut made = Self::default();
        if let Some(animation) = scene.animation() {
            made.add_moving(animation);
        }
        made.add_instances(scene, path)?;
        made.add_lights(scene, path, warnings);
        for (k, camera) in scene.cameras().iter().enumerate() {
            let moving = scene
                .animation()
                .and_then(|animation| animation.cameras.iter().find(|moving| moving.camera.index() == k));
            let node = json!({ "name": camera.name, "camera": k });
            match moving {
                Some(moving) => _ = made.add_at(node, &moving.attachment),
                None => {
                    if let Some(matrix) = camera_matrix(camera) {
                        made.add(with_matrix(node, &matrix), None);
                    }
                }
            }
        }
        Ok(made)
    }

    fn add(&mut self, node: Value, parent: Option<usize>) -> usize {
        let index = self.list.len();
        match parent {
            None => self.roots.push(index),
            Some(parent) => match self.list[parent]["children"].as_array_mut() {
                Some(children) => children.push(index.into()),
                None => self.list[parent]["children"] = json!([index]),
            },
        }
        self.list.push(node);
        index
    }

    /// Adds a node where something is attached.
    fn add_at(&mut self, node: Value, attachment: &Attachment) -> usize {
        match attachment {
            Attachment::On(parent) => self.add(node, Some(self.moving[*parent as usize])),
            Attachment::Fixed { world_from_node, visible } => {
                self.add(hidden_unless(*visible, with_matrix(node, world_from_node)), None)
            }
        }
    }

    fn add_moving(&mut self, animation: &Animation) {
        for node in &animation.nodes {
            let mut made = json!({ "name": node.name });
            match &node.rest {
                Local::Matrix(matrix) => made = with_matrix(made, matrix),
                Local::Parts(parts) => {
                    made["translation"] = json!(parts.translation.map(|x| x as f32));
                    if let Some(rotation) = parts.rotation {
                        made["rotation"] = json!(rotation.map(|x| x as f32));
                    }
                    made["scale"] = json!(parts.scale.map(|x| x as f32));
                }
            }
            let parent = match &node.parent {
                Attachment::On(parent) => Some(self.moving[*parent as usize]),
                Attachment::Fixed { world_from_node: Affine::IDENTITY, visible: true } => None,
                fixed => Some(self.add_at(json!({}), fixed)),
            };
            let index = self.add(hidden_unless(node.visible, made), parent);
            self.moving.push(index);
        }
    }

    fn add_instances(&mut self, scene: &Scene, path: &Path) -> Result<(), Error> {
        let mut next = 0..;
        let numbers: Vec<Option<usize>> = scene
            .objects()
            .iter()
            .map(|object| shown_meshes(scene, object).next().and_then(|_| next.next()))
            .collect();
        let moving: HashMap<InstanceId, _> = scene
            .animation()
            .map(|animation| animation.instances.iter().map(|moving| (moving.instance, *moving)).collect())
            .unwrap_or_default();
        // Path from the root: the number of its nodes, and their indices.
        let mut stack: Vec<usize> = Vec::new();
        for found in scene.occurrences() {
            if self.list.len() >= MOST_NODES {
                let problem = format!("more than {MOST_NODES} nodes, with objects in objects unfolded");
                return Err(Error::io(path, problem, "glTF has a node for each; leave some out"));
            }
            stack.truncate(found.depth);
            let mut node = json!({ "name": found.name });
            let mut parent = stack.last().copied();
            match moving.get(&found.instance).filter(|_| found.depth == 0) {
                Some(moving) => {
                    parent = Some(self.moving[moving.node as usize]);
                    // Those of skinned meshes do not count.
                    let bends = found.object.meshes.iter().any(|&id| body(scene.animation(), id).is_some());
                    if !moving.has_transform && !bends {
                        node = with_matrix(node, &found.parent_from_object);
                    }
                }
                None => node = with_matrix(node, &found.parent_from_object),
            }
            let number = numbers[found.object_id.index()];
            if let Some(number) = number {
                node["mesh"] = number.into();
                if found.mask != RayMask::ALL {
                    node["extras"] = json!({ "mask": found.mask.0 });
                }
                if found.depth == 0 && scene.labels().holdouts.contains(&found.instance) {
                    node["extras"]["holdout"] = json!(true);
                }
                let sets = scene.labels().trace_sets_of(found.instance);
                if found.depth == 0 && !sets.is_empty() {
                    node["extras"]["traceset"] = json!(sets.join(","));
                }
                if found.depth == 0 {
                    put_into_group(&mut node, scene, Shining::Instance(found.instance));
                }
            }
            let index = self.add(node, parent);
            for (_, body) in shown_meshes(scene, found.object).take(usize::from(number.is_some())) {
                let Some(body) = body else { continue };
                if let Some(set) = body.weights {
                    let nodes = self.weighted.entry(set).or_default();
                    if nodes.last() != Some(&index) {
                        nodes.push(index);
                    }
                }
                self.skinned.extend(body.skin.map(|skin| (index, skin)));
            }
            stack.push(index);
        }
        Ok(())
    }

    /// The skins of an animation, once all nodes are there; `matrices` adds one for each joint.
    pub(super) fn skins(
        &mut self,
        animation: &Animation,
        mut matrices: impl FnMut(&[[f32; 16]]) -> usize,
    ) -> Vec<Value> {
        for (node, skin) in std::mem::take(&mut self.skinned) {
            self.list[node]["skin"] = skin.into();
        }
        let mut skins = Vec::new();
        for skin in &animation.skins {
            let joints: Vec<usize> = skin
                .joints
                .iter()
                .map(|joint| match &joint.attachment {
                    Attachment::On(node) => self.moving[*node as usize],
                    fixed => self.add_at(json!({}), fixed),
                })
                .collect();
            let single = |matrix: &Affine| matrix.to_column_major().map(|x| x as f32);
            let bind: Vec<_> = skin.joints.iter().map(|joint| single(&joint.joint_from_mesh)).collect();
            skins.push(json!({ "joints": joints, "inverseBindMatrices": matrices(&bind) }));
        }
        skins
    }

    fn add_lights(&mut self, scene: &Scene, path: &Path, warnings: &mut Warnings) {
        for (k, light) in scene.lights().iter().enumerate() {
            let moving = scene
                .animation()
                .and_then(|animation| animation.lights.iter().find(|moving| moving.light.index() == k));
            let rest = moving
                .and_then(|moving| scene.animation()?.light_factors.get(moving.factors as usize).copied());
            let (described, matrix) = match light {
                Light::Point { position, intensity, radius } => {
                    leave_out(usize::from(*radius > 0.0), "radius of a light", path, warnings);
                    (punctual("point", *intensity), at(*position, [0.0, 0.0, -1.0]))
                }
                Light::Directional { direction, irradiance, angle } => {
                    leave_out(usize::from(*angle > 0.0), "angle of a directional light", path, warnings);
                    (punctual("directional", *irradiance), at([0.0; 3], *direction))
                }
                Light::Spot { position, direction, intensity, inner_angle, outer_angle, edge, radius } => {
                    leave_out(usize::from(*radius > 0.0), "radius of a light", path, warnings);
                    let is_smooth = *edge == ConeEdge::Smooth;
                    leave_out(usize::from(is_smooth), "smooth edge of a spot", path, warnings);
                    let inner_angle = edge.squared_inner(*inner_angle, *outer_angle);
                    let mut spot = punctual("spot", *intensity);
                    spot["spot"] = json!({ "innerConeAngle": inner_angle, "outerConeAngle": outer_angle });
                    (spot, at(*position, *direction))
                }
                Light::Environment { .. } | Light::Backdrop { .. } => {
                    leave_out(1, "environment light", path, warnings);
                    continue;
                }
            };
            let number = self.lights.len();
            let extension = json!({ "KHR_lights_punctual": { "light": number } });
            let mut node = json!({ "extensions": extension });
            let id = LightId(k as u32);
            put_into_group(&mut node, scene, Shining::Light(id));
            if let Some(name) = scene.labels().lights.get(&id) {
                node["name"] = json!(name);
            }
            self.lights.push(rest.map_or(described, |rest| factors(&rest)));
            match moving {
                Some(moving) => {
                    self.light_factors.entry(moving.factors).or_insert(number);
                    self.add_at(node, &moving.attachment);
                }
                None => _ = self.add(with_matrix(node, &matrix), None),
            }
        }
    }
}

/// Writes the light group of something into the `extras` of its node or material.
pub(super) fn put_into_group(node: &mut Value, scene: &Scene, shining: Shining) {
    if let Some(group) = scene.labels().light_groups.get(&shining) {
        node["extras"]["light_group"] = json!(group);
    }
}

fn with_matrix(mut node: Value, matrix: &Affine) -> Value {
    if *matrix != Affine::IDENTITY {
        node["matrix"] = json!(matrix.to_column_major());
    }
    node
}

fn hidden_unless(visible: bool, mut node: Value) -> Value {
    if !visible {
        node["extensions"] = json!({ "KHR_node_visibility": { "visible": false } });
    }
    node
}

/// A light by the factors that channels drive.
fn factors(rest: &LightFactors) -> Value {
    let kind = match rest.kind {
        LightKind::Point => "point",
        LightKind::Spot => "spot",
        LightKind::Directional => "directional",
    };
    let mut light = json!({ "type": kind, "intensity": rest.intensity, "color": rest.color });
    if rest.kind == LightKind::Spot {
        light["spot"] = json!({ "innerConeAngle": rest.inner_angle, "outerConeAngle": rest.outer_angle });
    }
    light
}

fn punctual(kind: &str, color: [f32; 3]) -> Value {
    let intensity = color.iter().copied().fold(0.0, f32::max);
    let color = if intensity > 0.0 { color.map(|c| c / intensity) } else { [1.0; 3] };
    json!({ "type": kind, "intensity": intensity, "color": color })
}

/// The frame at `position` that faces `direction`.
fn at(position: [f32; 3], direction: [f32; 3]) -> Affine {
    let target = [0, 1, 2].map(|k| position[k] + direction[k]);
    let view = Camera {
        name: String::new(),
        eye: position,
        target,
        up: [0.0, 1.0, 0.0],
        fov_y: 45.0,
        ..Camera::default()
    };
    camera_matrix(&view).unwrap_or_else(|| Affine::translation(position.map(f64::from)))
}

fn camera_matrix(camera: &Camera) -> Option<Affine> {
    let frame = camera.frame()?;
    let back = frame.forward.map(|x| -x);
    Some(Affine { columns: [frame.right, frame.up, back, camera.eye].map(|column| column.map(f64::from)) })
}
