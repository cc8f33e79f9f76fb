// SPDX-License-Identifier: GPL-3.0-or-later
//! Nodes: where meshes, cameras and lights stand.
//! Source: glTF 2.0 sections 3.5 and 3.10, KHR_lights_punctual. Transforms are multiplied in double precision.
//! The tree is walked with a list, not by recursion, and each node once: neither depth nor cycles do harm.
//! Cost: O(nodes); memory: that of the way from the root, and a bit for each node. Proof: `tests/gltf.rs::{deep_and_cyclic_trees, cameras_and_lights}`.

use std::collections::HashMap;

use super::document::Document;
use super::json::{self, Index};
use super::material::AddedMaterial;
use super::mesh;
use super::skin::{Pose, joints_of_all_skins};
use crate::affine::Affine;
use crate::camera::Camera;
use crate::id::ObjectId;
use crate::io::{Error, Oddity, Warnings};
use crate::light::Light;
use crate::scene::{Instance, Scene};

/// Bytes that an instance, a camera or a light of the scene takes beside its name.
const PLACED_BYTES: usize = 224;

/// Adds what the nodes of the default scene, or else of all scenes, show.
pub(super) fn add_all(
    document: &Document<'_>,
    materials: &[AddedMaterial],
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<(), Error> {
    let world_from_joint = place_joints(document)?;
    let mut adder =
        Adder { document, materials, world_from_joint: &world_from_joint, objects: HashMap::new(), scene };
    walk(document, warnings, |index, node, world_from_here, warnings| {
        adder.add(index, node, world_from_here, warnings)
    })
}

/// Where the joints of skins stand; those that are not shown stand nowhere in particular.
fn place_joints(document: &Document<'_>) -> Result<HashMap<Index, Affine>, Error> {
    let mut joints = joints_of_all_skins(document)?;
    if !joints.is_empty() {
        // The walk that shows things says what is odd.
        walk(document, &mut Warnings::default(), |index, _, world_from_here, _| {
            if let Some(world_from_joint) = joints.get_mut(&index) {
                *world_from_joint = world_from_here;
            }
            Ok(())
        })?;
    }
    Ok(joints)
}

/// A node on the way from the root to where the walk is: its children that are still to be seen.
struct Ancestor {
    world_from_here: Affine,
    children: std::vec::IntoIter<Index>,
}

/// Calls `visit` with every node that is shown, parents first, and its transform.
fn walk(
    document: &Document<'_>,
    warnings: &mut Warnings,
    mut visit: impl FnMut(Index, &json::Node, Affine, &mut Warnings) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut seen = vec![false; document.root.nodes.len()];
    let roots = Ancestor { world_from_here: Affine::IDENTITY, children: roots(document)?.into_iter() };
    let mut way = vec![roots];
    while let Some(parent) = way.last_mut() {
        let Some(index) = parent.children.next() else {
            way.pop();
            continue;
        };
        let world_from_parent = parent.world_from_here;
        if seen.get(index.value()) == Some(&true) {
            let detail = format!("nodes[{}] stands in the tree twice", index.0);
            warnings.note(Oddity::BadNode, &document.path, None, detail);
            continue;
        }
        let mut node: json::Node = match document.root.nodes.get(index.value()) {
            Some(piece) if piece.get() == "{}" => json::Node::default(),
            _ => document.get(&document.root.nodes, index, "nodes", "node")?,
        };
        seen[index.value()] = true;
        let world_from_here = world_from_parent * local_transform(&node);
        let children = std::mem::take(&mut node.children);
        visit(index, &node, world_from_here, warnings)?;
        if !children.is_empty() {
            way.push(Ancestor { world_from_here, children: children.into_iter() });
        }
    }
    Ok(())
}

/// The first nodes of the default scene; without one, of all scenes; without scenes, all nodes that are no children.
fn roots(document: &Document<'_>) -> Result<Vec<Index>, Error> {
    let root = &document.root;
    let scene = |index| -> Result<json::Scene, Error> { document.get(&root.scenes, index, "scene", "scene") };
    if let Some(index) = root.scene {
        return Ok(scene(index)?.nodes);
    }
    if !root.scenes.is_empty() {
        let mut nodes = Vec::new();
        for k in 0..root.scenes.len() {
            nodes.extend(scene(Index(k as u32))?.nodes);
        }
        return Ok(nodes);
    }
    let mut is_child = vec![false; root.nodes.len()];
    for k in 0..root.nodes.len() {
        let node: json::Children = document.get(&root.nodes, Index(k as u32), "nodes", "node")?;
        for child in node.children {
            if let Some(slot) = is_child.get_mut(child.value()) {
                *slot = true;
            }
        }
    }
    Ok((0..root.nodes.len()).filter(|&i| !is_child[i]).map(|i| Index(i as u32)).collect())
}

fn local_transform(node: &json::Node) -> Affine {
    if let Some(matrix) = &node.matrix {
        return Affine::from_column_major(&matrix.map(f64::from));
    }
    let translation = node.translation.unwrap_or([0.0; 3]).map(f64::from);
    let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let rotation = node.rotation.map_or(Affine::IDENTITY, |q| from_quaternion(q.map(f64::from)));
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
    document: &'a Document<'a>,
    materials: &'a [AddedMaterial],
    world_from_joint: &'a HashMap<Index, Affine>,
    /// Objects of meshes that no node bends; `None` = without triangles.
    objects: HashMap<Index, Option<ObjectId>>,
    scene: &'a mut Scene,
}

impl Adder<'_> {
    fn add(
        &mut self,
        index: Index,
        node: &json::Node,
        world_from_here: Affine,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let place = format!("nodes[{}]", index.0);
        let name = node.name.clone().unwrap_or_else(|| format!("node {}", index.0));
        let light = node.extensions.light.as_ref();
        let things = [node.mesh.is_some(), node.camera.is_some(), light.is_some()];
        let count = things.into_iter().filter(|&there| there).count();
        self.document.hold(count * (PLACED_BYTES + name.len()), &place)?;
        if let Some(mesh) = node.mesh {
            self.add_mesh(&name, node, mesh, world_from_here, warnings)?;
        }
        let root = &self.document.root;
        if let Some(camera) = node.camera {
            let camera: json::Camera = self.document.get(&root.cameras, camera, &place, "camera")?;
            self.add_camera(name, &camera, world_from_here, warnings);
        }
        if let Some(light) = light {
            let lights = root.extensions.lights.as_ref().map_or(&[][..], |lights| &lights.lights);
            let light: json::Light<'_> = self.document.get(lights, light.light, &place, "light")?;
            self.add_light(&light, world_from_here, warnings);
        }
        Ok(())
    }

    /// The object that shows a mesh as its node bends it; `None` if it has no triangles.
    fn object(
        &mut self,
        index: Index,
        node: &json::Node,
        warnings: &mut Warnings,
    ) -> Result<Option<ObjectId>, Error> {
        // A mesh's own weights bend it for every node alike.
        let is_shared = node.skin.is_none() && node.weights.is_none();
        if let Some(&known) = self.objects.get(&index).filter(|_| is_shared) {
            return Ok(known);
        }
        let document = self.document;
        let from: json::Mesh<'_> = document.get(&document.root.meshes, index, "nodes", "mesh")?;
        let before = document.budget().held();
        let pose = Pose::of(document, node, &from, self.world_from_joint)?;
        let for_pose = document.budget().held() - before;
        let meshes = mesh::read(document, index, &from, &pose, self.materials, warnings)?;
        document.budget().release(for_pose as usize);
        let name = from.name.unwrap_or_else(|| format!("mesh {}", index.0));
        document.hold(PLACED_BYTES + name.len(), "meshes")?;
        let ids: Vec<_> = meshes.into_iter().map(|mesh| self.scene.add_mesh(mesh)).collect();
        let object = (!ids.is_empty()).then(|| self.scene.add_object_of(name, ids));
        if is_shared {
            self.objects.insert(index, object);
        }
        Ok(object)
    }

    fn add_mesh(
        &mut self,
        name: &str,
        node: &json::Node,
        mesh: Index,
        world_from_here: Affine,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        // A skinned mesh comes out in world space.
        let world_from_object = if node.skin.is_some() { Affine::IDENTITY } else { world_from_here };
        if world_from_object.inverse().is_none() {
            warnings.note(Oddity::BadNode, &self.document.path, None, name);
            return Ok(());
        }
        let object = self.object(mesh, node, warnings)?;
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

    fn add_camera(
        &mut self,
        name: String,
        camera: &json::Camera,
        world_from_camera: Affine,
        warnings: &mut Warnings,
    ) {
        let Some(perspective) = &camera.perspective else {
            let detail = format!("{name}: not a perspective camera");
            return warnings.note(Oddity::BadCamera, &self.document.path, None, detail);
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
            return warnings.note(Oddity::BadCamera, &self.document.path, None, camera.name);
        }
        self.scene.add_camera(camera);
    }

    fn add_light(&mut self, light: &json::Light<'_>, world_from_light: Affine, warnings: &mut Warnings) {
        let position = world_from_light.point([0.0; 3]).map(|x| x as f32);
        let direction = world_from_light.vector([0.0, 0.0, -1.0]).map(|x| x as f32);
        // Candela and lux as they are, as nits of emission are: docs/decisions/0019.
        let intensity = light.color.map(|c| c * light.intensity);
        let good = intensity.iter().chain(&position).chain(&direction).all(|x| x.is_finite());
        let light = match &*light.kind {
            _ if !good => None,
            "point" => Some(Light::Point { position, intensity }),
            "directional" => Some(Light::Directional { direction, irradiance: intensity }),
            "spot" => {
                let (inner, outer) = (light.spot.inner_cone_angle, light.spot.outer_cone_angle);
                let outer_angle = outer.clamp(1e-3, std::f32::consts::FRAC_PI_2);
                let inner_angle = inner.clamp(0.0, outer_angle * 0.999);
                Some(Light::Spot { position, direction, intensity, inner_angle, outer_angle })
            }
            _ => None,
        };
        match light {
            Some(light) => drop(self.scene.add_light(light)),
            None => warnings.note(
                Oddity::NotShown,
                &self.document.path,
                None,
                "light of an unknown kind or without a place",
            ),
        }
    }
}
