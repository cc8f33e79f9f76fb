// SPDX-License-Identifier: GPL-3.0-or-later
//! Nodes: where meshes, cameras and lights stand.
//! Source: glTF 2.0 sections 3.5 and 3.10, KHR_lights_punctual. Transforms are multiplied in double precision.
//! The tree is walked with a list, not by recursion, and each node once: neither depth nor cycles do harm.
//! Cost: O(nodes). Proof: `tests/gltf.rs::{deep_and_cyclic_trees, cameras_and_lights}`.

use std::collections::HashMap;

use gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};

use super::document::Document;
use super::material::AddedMaterial;
use super::mesh;
use super::skin::Pose;
use crate::affine::Affine;
use crate::camera::Camera;
use crate::id::ObjectId;
use crate::io::{Error, Oddity, Warnings};
use crate::light::Light;
use crate::scene::{Instance, Scene};

/// Adds what the nodes of the default scene, or else of all scenes, show.
pub(super) fn add_all(
    document: &Document,
    materials: &[AddedMaterial],
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<(), Error> {
    let (order, world_from_node) = place_nodes(document, warnings)?;
    let mut adder = Adder {
        document,
        materials,
        world_from_node: &world_from_node,
        objects: HashMap::new(),
        scene,
        warnings,
    };
    for index in order {
        let (node, world_from_here) =
            (&document.root.nodes[index], world_from_node[index].unwrap_or_default());
        adder.add(index, node, world_from_here)?;
    }
    Ok(())
}

/// The nodes that are shown, parents first, and the transforms of all nodes that were reached.
fn place_nodes(
    document: &Document,
    warnings: &mut Warnings,
) -> Result<(Vec<usize>, Vec<Option<Affine>>), Error> {
    let nodes = &document.root.nodes;
    let mut world_from_node: Vec<Option<Affine>> = vec![None; nodes.len()];
    let mut order = Vec::new();
    let mut waiting: Vec<(Index<json::Node>, Affine)> =
        roots(document)?.into_iter().rev().map(|node| (node, Affine::IDENTITY)).collect();
    while let Some((index, world_from_parent)) = waiting.pop() {
        let node = document.get(index, "nodes", "node")?;
        let slot = &mut world_from_node[index.value()];
        if slot.is_some() {
            let detail = format!("nodes[{}] stands in the tree twice", index.value());
            warnings.note(Oddity::BadNode, &document.path, None, detail);
            continue;
        }
        let world_from_here = world_from_parent * local_transform(node);
        *slot = Some(world_from_here);
        order.push(index.value());
        let children = node.children.iter().flatten().rev();
        waiting.extend(children.map(|&child| (child, world_from_here)));
    }
    Ok((order, world_from_node))
}

/// The first nodes of the default scene; without one, of all scenes; without scenes, all nodes that are no children.
fn roots(document: &Document) -> Result<Vec<Index<json::Node>>, Error> {
    let root = &document.root;
    if let Some(index) = root.scene {
        return Ok(document.get(index, "scene", "scene")?.nodes.clone());
    }
    if !root.scenes.is_empty() {
        return Ok(root.scenes.iter().flat_map(|scene| scene.nodes.iter().copied()).collect());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(slot) = is_child.get_mut(child.value()) {
            *slot = true;
        }
    }
    Ok((0..root.nodes.len()).filter(|&i| !is_child[i]).map(|i| Index::new(i as u32)).collect())
}

fn local_transform(node: &json::Node) -> Affine {
    if let Some(matrix) = &node.matrix {
        return Affine::from_column_major(&matrix.map(f64::from));
    }
    let translation = node.translation.unwrap_or([0.0; 3]).map(f64::from);
    let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let rotation = node.rotation.map_or(Affine::IDENTITY, |q| from_quaternion(q.0.map(f64::from)));
    Affine::translation(translation) * rotation * Affine::scale(scale)
}

/// The rotation of a quaternion `x y z w` of any length but zero.
fn from_quaternion(q: [f64; 4]) -> Affine {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return Affine::IDENTITY;
    }
    let [x, y, z, w] = q.map(|x| x / length);
    Affine {
        columns: [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
            [0.0; 3],
        ],
    }
}

struct Adder<'a> {
    document: &'a Document,
    materials: &'a [AddedMaterial],
    world_from_node: &'a [Option<Affine>],
    /// Objects of meshes that nothing bends; `None` = without triangles.
    objects: HashMap<usize, Option<ObjectId>>,
    scene: &'a mut Scene,
    warnings: &'a mut Warnings,
}

impl Adder<'_> {
    fn add(&mut self, index: usize, node: &json::Node, world_from_here: Affine) -> Result<(), Error> {
        let name = node.name.clone().unwrap_or_else(|| format!("node {index}"));
        if let Some(mesh) = node.mesh {
            self.add_mesh(&name, node, mesh, world_from_here)?;
        }
        if let Some(camera) = node.camera {
            let camera = self.document.get(camera, &format!("nodes[{index}]"), "camera")?;
            self.add_camera(name, camera, world_from_here);
        }
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(light) = light {
            let lights = self.document.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
            let light = lights.and_then(|l| l.lights.get(light.light.value())).ok_or_else(|| {
                self.document.error(
                    &format!("nodes[{index}]"),
                    format!("light {} does not exist", light.light.value()),
                    "",
                )
            })?;
            self.add_light(light, world_from_here);
        }
        Ok(())
    }

    fn add_mesh(
        &mut self,
        name: &str,
        node: &json::Node,
        mesh: Index<json::Mesh>,
        world_from_here: Affine,
    ) -> Result<(), Error> {
        let from = self.document.get(mesh, "nodes", "mesh")?;
        let pose = Pose::of(self.document, node, from, self.world_from_node)?;
        let world_from_object = if pose.is_skinned() { Affine::IDENTITY } else { world_from_here };
        if world_from_object.inverse().is_none() {
            self.warnings.note(Oddity::BadNode, &self.document.path, None, name);
            return Ok(());
        }
        let known = self.objects.get(&mesh.value()).copied().filter(|_| pose.is_plain());
        let object = match known {
            Some(object) => object,
            None => {
                let meshes = mesh::read(self.document, mesh, &pose, self.materials, self.warnings)?;
                let ids: Vec<_> = meshes.into_iter().map(|mesh| self.scene.add_mesh(mesh)).collect();
                let object_name = from.name.clone().unwrap_or_else(|| format!("mesh {}", mesh.value()));
                let object = (!ids.is_empty()).then(|| self.scene.add_object_of(object_name, ids));
                if pose.is_plain() {
                    self.objects.insert(mesh.value(), object);
                }
                object
            }
        };
        if let Some(object) = object {
            self.scene.add_instance(Instance {
                name: name.to_owned(),
                object,
                world_from_object,
                visible: true,
            });
        }
        Ok(())
    }

    fn add_camera(&mut self, name: String, camera: &json::Camera, world_from_camera: Affine) {
        let Some(perspective) = &camera.perspective else {
            let detail = format!("{name}: not a perspective camera");
            return self.warnings.note(Oddity::BadCamera, &self.document.path, None, detail);
        };
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        let camera = Camera {
            eye: single(world_from_camera.point([0.0; 3])),
            target: single(world_from_camera.point([0.0, 0.0, -1.0])),
            up: single(world_from_camera.vector([0.0, 1.0, 0.0])),
            fov_y: perspective.yfov.to_degrees(),
            name,
        };
        if camera.frame().is_none() || !(camera.fov_y > 0.0 && camera.fov_y < 180.0) {
            return self.warnings.note(Oddity::BadCamera, &self.document.path, None, camera.name);
        }
        self.scene.add_camera(camera);
    }

    fn add_light(&mut self, light: &JsonLight, world_from_light: Affine) {
        let position = world_from_light.point([0.0; 3]).map(|x| x as f32);
        let direction = world_from_light.vector([0.0, 0.0, -1.0]).map(|x| x as f32);
        let intensity = light.color.map(|c| c * light.intensity);
        let good = intensity.iter().chain(&position).chain(&direction).all(|x| x.is_finite());
        let light = match (&light.type_, &light.spot) {
            _ if !good => None,
            (Checked::Valid(LightType::Point), _) => Some(Light::Point { position, intensity }),
            (Checked::Valid(LightType::Directional), _) => {
                Some(Light::Directional { direction, irradiance: intensity })
            }
            (Checked::Valid(LightType::Spot), spot) => {
                let (inner, outer) = spot
                    .as_ref()
                    .map_or((0.0, std::f32::consts::FRAC_PI_4), |s| (s.inner_cone_angle, s.outer_cone_angle));
                let outer_angle = outer.clamp(1e-3, std::f32::consts::FRAC_PI_2);
                let inner_angle = inner.clamp(0.0, outer_angle * 0.999);
                Some(Light::Spot { position, direction, intensity, inner_angle, outer_angle })
            }
            (Checked::Invalid, _) => None,
        };
        match light {
            Some(light) => drop(self.scene.add_light(light)),
            None => self.warnings.note(
                Oddity::NotShown,
                &self.document.path,
                None,
                "light of an unknown kind or without a place",
            ),
        }
    }
}
