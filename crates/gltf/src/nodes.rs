// SPDX-License-Identifier: GPL-3.0-or-later
//! Nodes: where meshes, cameras and lights are.
//! Source: glTF 2.0 sections 3.5 and 3.10, KHR_lights_punctual, KHR_node_visibility. Transforms are multiplied in double precision.
//! The tree is walked with a list, not by recursion, and each node once: neither depth nor cycles do harm; a cycle is an error.
//! Cost: O(nodes); memory: that of the path from the root, and a bit for each node. Tests:
//! `tests/gltf.rs::{deep_and_cyclic_trees, cameras_and_lights}`.

use std::collections::HashMap;
use std::sync::Arc;

use super::camera;
use super::document::Document;
use super::instancing;
use super::json::{self, Index};
use super::material::AddedMaterial;
use super::mesh;
use super::pointer::WeightsOf;
use super::rig::{Rig, local};
use super::skin::Bending;
use gnurt_scene::RayMask;
use gnurt_scene::ShaderFile;
use gnurt_scene::affine::Affine;
use gnurt_scene::animation::{
    Attachment, Body, LightFactors, LightKind, MovingCamera, MovingInstance, MovingLight, camera_at,
};
use gnurt_scene::id::ObjectId;
use gnurt_scene::io::{Error, Oddity, Warnings, reader as source};
use gnurt_scene::labels::Shining;
use gnurt_scene::motion::Motion;
use gnurt_scene::{Instance, Member, Object, Scene};

/// Bytes of an instance, a camera or a light of the scene, without its name.
const PLACED_BYTES: usize = 224;

/// Adds the contents of the default scene, or of all scenes, and the animation of its moving parts.
pub(super) fn add_all(
    document: &Document<'_>,
    materials: &[AddedMaterial],
    mut rig: Rig<'_>,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<(), Error> {
    if !rig.is_still() {
        // Joints may follow the meshes that they deform. The traversal that adds the nodes gives the
        // warnings.
        walk(document, &mut Warnings::default(), |index, node, parent, world_from_node, _| {
            rig.enter(index, node, parent, world_from_node)
        })?;
    }
    let mut adder = Adder { document, materials, rig, objects: HashMap::new(), scene };
    walk(document, warnings, |index, node, parent, world_from_node, warnings| {
        let attachment = adder.rig.enter(index, node, parent, world_from_node)?;
        adder.add(index, node, NodeAttachment { world_from_node, attachment }, warnings)?;
        Ok(attachment)
    })?;
    adder.rig.finish(adder.scene, warnings)
}

/// Where a node is.
#[derive(Clone, Copy)]
struct NodeAttachment {
    /// At rest.
    world_from_node: Affine,
    attachment: Attachment,
}

/// A node on the path from the root to the current node: its unvisited children.
struct Ancestor {
    /// `None` = the file itself.
    index: Option<Index>,
    attached: NodeAttachment,
    children: std::vec::IntoIter<Index>,
}

/// Calls `visit` for every visible node, parents first, with its parent's transform and its own; `visit`
/// returns its world transform.
fn walk(
    document: &Document<'_>,
    warnings: &mut Warnings,
    mut visit: impl FnMut(Index, &json::Node, Attachment, Affine, &mut Warnings) -> Result<Attachment, Error>,
) -> Result<(), Error> {
    let count = document.root.nodes.len();
    let (mut visited, mut is_above) = (vec![false; count], vec![false; count]);
    let (roots, are_all) = roots(document)?;
    let attachment = Attachment::Fixed { world_from_node: Affine::IDENTITY, visible: true };
    let attached = NodeAttachment { world_from_node: Affine::IDENTITY, attachment };
    let mut stack = vec![Ancestor { index: None, attached, children: roots.into_iter() }];
    while let Some(parent) = stack.last_mut() {
        let Some(index) = parent.children.next() else {
            if let Some(index) = parent.index {
                is_above[index.value()] = false;
            }
            stack.pop();
            continue;
        };
        let parent = parent.attached;
        if visited.get(index.value()) == Some(&true) {
            if is_above[index.value()] {
                return Err(cycle(document, index.value()));
            }
            let detail = format!("nodes[{}] occurs in the tree twice", index.0);
            warnings.note(Oddity::BadNode, &document.path, None, detail);
            continue;
        }
        let mut node: json::Node = match document.root.nodes.get(index.value()) {
            Some(piece) if piece.get() == "{}" => json::Node::default(),
            _ => document.get(&document.root.nodes, index, "nodes", "node")?,
        };
        visited[index.value()] = true;
        let world_from_node = parent.world_from_node * local(&node).affine();
        let children = std::mem::take(&mut node.children);
        let attachment = visit(index, &node, parent.attachment, world_from_node, warnings)?;
        if !children.is_empty() {
            is_above[index.value()] = true;
            let attached = NodeAttachment { world_from_node, attachment };
            stack.push(Ancestor { index: Some(index), attached, children: children.into_iter() });
        }
    }
    match visited.iter().position(|&visited| !visited).filter(|_| are_all) {
        // A node that no root reaches has an ancestor in a cycle.
        Some(index) => Err(cycle(document, index)),
        None => Ok(()),
    }
}

/// A node from which its own children lead back to it.
fn cycle(document: &Document<'_>, index: usize) -> Error {
    document.error(&format!("nodes[{index}]"), "its children lead back to it", "expected a tree of nodes")
}

/// The first nodes of the default scene; without one, of all scenes; without scenes, all nodes that are no children, which then lead to all
/// nodes that there are.
fn roots(document: &Document<'_>) -> Result<(Vec<Index>, bool), Error> {
    let root = &document.root;
    let scene = |index| -> Result<json::Scene, Error> { document.get(&root.scenes, index, "scene", "scene") };
    if let Some(index) = root.scene {
        return Ok((scene(index)?.nodes, false));
    }
    if !root.scenes.is_empty() {
        let mut nodes = Vec::new();
        for k in 0..root.scenes.len() {
            nodes.extend(scene(Index(k as u32))?.nodes);
        }
        return Ok((nodes, false));
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
    Ok(((0..root.nodes.len()).filter(|&i| !is_child[i]).map(|i| Index(i as u32)).collect(), true))
}

struct Adder<'a> {
    document: &'a Document<'a>,
    materials: &'a [AddedMaterial],
    rig: Rig<'a>,
    /// Objects of meshes that no node bends; `None` = without triangles.
    objects: HashMap<Index, Option<ObjectId>>,
    scene: &'a mut Scene,
}

impl Adder<'_> {
    fn add(
        &mut self,
        index: Index,
        node: &json::Node,
        attached: NodeAttachment,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let attachment = format!("nodes[{}]", index.0);
        let name = node.name.clone().unwrap_or_else(|| format!("node {}", index.0));
        let light = node.extensions.light.as_ref();
        let things = [node.mesh.is_some(), node.camera.is_some(), light.is_some()];
        let count = things.into_iter().filter(|&there| there).count();
        self.document.hold(count * (PLACED_BYTES + name.len()), &attachment)?;
        if let Some(mesh) = node.mesh {
            self.add_mesh(&name, index, node, mesh, attached, warnings)?;
        }
        let root = &self.document.root;
        if let Some(camera) = node.camera {
            let from: json::Camera = self.document.get(&root.cameras, camera, &attachment, "camera")?;
            if let Some(extras) = &from.extras {
                self.document.hold(4 * extras.to_string().len(), &attachment)?;
            }
            self.add_camera(&name, camera, &from, attached, warnings);
        }
        if let Some(light) = light {
            let lights = root.extensions.lights.as_ref().map_or(&[][..], |lights| &lights.lights);
            let from: json::Light<'_> = self.document.get(lights, light.light, &attachment, "light")?;
            self.add_light((name, node), light.light, &from, attached, warnings);
        }
        Ok(())
    }

    /// The object that shows a mesh as its node bends it; `None` if it has no triangles.
    fn object(
        &mut self,
        at: Index,
        node: &json::Node,
        index: Index,
        warnings: &mut Warnings,
    ) -> Result<Option<ObjectId>, Error> {
        let is_own = node.weights.is_some() || self.rig.drafts.drives_weights(WeightsOf::Node(at));
        // A mesh's own weights bend it for every node alike.
        let is_shared = node.skin.is_none() && !is_own;
        if let Some(&known) = self.objects.get(&index).filter(|_| is_shared) {
            return Ok(known);
        }
        let document = self.document;
        let from: json::Mesh<'_> = document.get(&document.root.meshes, index, "nodes", "mesh")?;
        let weights_of = if is_own { WeightsOf::Node(at) } else { WeightsOf::Mesh(index) };
        let before = document.budget().held();
        let skin = node.skin.map(|skin| Ok((skin, self.rig.skin(skin, warnings)?))).transpose()?;
        let for_skin = document.budget().held() - before;
        let rest = node.weights.as_ref().unwrap_or(&from.weights);
        let skin_and_rest = skin.as_ref().map(|(_, skin)| skin);
        let bending = Bending::new(rest, skin_and_rest, self.rig.drafts.drives_weights(weights_of));
        let meshes = mesh::read(document, index, &from, &bending, self.materials, warnings)?;
        document.budget().release(for_skin as usize);
        let motion = from.motion();
        let name = from.name.unwrap_or_else(|| format!("mesh {}", index.0));
        document.hold(PLACED_BYTES + name.len(), "meshes")?;
        let targets = meshes.iter().filter_map(|(_, parts)| parts.as_ref()).map(|parts| parts.morphs.len());
        let targets = targets.max().unwrap_or(0);
        let mut ids = Vec::with_capacity(meshes.len());
        for (mesh, parts) in meshes {
            let mesh = self.scene.add_mesh(mesh);
            ids.push(mesh);
            let Some(parts) = parts else { continue };
            document.hold(size_of::<Body>(), "meshes")?;
            let weights = match parts.morphs.is_empty() {
                true => None,
                false => Some(self.rig.add_weights(weights_of, rest, targets)?),
            };
            let skin = match (&parts.influences, &skin) {
                (Some(_), Some((index, (skin, _)))) => Some(self.rig.add_skin(*index, skin)?),
                _ => None,
            };
            let (morphs, influences) = (parts.morphs, parts.influences);
            let base = Arc::new(parts.base);
            self.rig.made.bodies.push(Body { mesh, base, morphs, weights, influences, skin });
        }
        let motion =
            motion.map_or(Ok(Motion::Auto), |motion_name| motion_name.parse()).unwrap_or_else(|unknown| {
                let detail = format!("meshes[{}].extras.gnurt_motion: {unknown}", index.0);
                warnings.note(Oddity::NotShown, &document.path, None, detail);
                Motion::Auto
            });
        let object = (!ids.is_empty())
            .then(|| self.scene.add_object(Object { name, meshes: ids, motion, ..Object::default() }));
        if is_shared {
            self.objects.insert(index, object);
        }
        Ok(object)
    }

    fn add_mesh(
        &mut self,
        name: &str,
        index: Index,
        node: &json::Node,
        mesh: Index,
        attached: NodeAttachment,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        // A skinned mesh comes out in world space.
        let has_transform = node.skin.is_none();
        let world_from_object = if has_transform { attached.world_from_node } else { Affine::IDENTITY };
        let moves = matches!(attached.attachment, Attachment::On(_));
        // A node that is flat at rest may get volume later.
        if world_from_object.inverse().is_none() && !moves {
            warnings.note(Oddity::BadNode, &self.document.path, None, name);
            return Ok(());
        }
        let object = self.object(index, node, mesh, warnings)?;
        let object = object.map(|object| self.repeated(name, index, node, object, warnings)).transpose()?;
        if let Some(object) = object {
            let visible = self.rig.is_visible(attached.attachment);
            let name = name.to_owned();
            let mask = self.ray_mask(&name, node, warnings);
            let instance =
                self.scene.add_instance(Instance { name, object, world_from_object, visible, mask });
            let holdout = node.extras.as_ref().and_then(|extras| extras.get("holdout"));
            if holdout.and_then(serde_json::Value::as_bool) == Some(true) {
                self.scene.labels_mut().holdouts.insert(instance);
            }
            if let Some(sets) = node.extras.as_ref().and_then(|extras| extras.get("traceset")) {
                let names = sets.as_str().ok_or_else(|| format!("{sets} is not a text with names"));
                let labels = self.scene.labels_mut();
                let added = names.and_then(|names| labels.add_to_trace_sets(instance, names));
                if let Err(why) = added {
                    let name = &self.scene.instance(instance).name;
                    let detail = format!("{name}: extras.traceset: {why}");
                    warnings.note(Oddity::BadNode, &self.document.path, None, detail);
                }
            }
            if let Some(group) = json::light_group(node.extras.as_ref()) {
                self.scene.labels_mut().set_light_group(Shining::Instance(instance), group);
            }
            if let Attachment::On(node) = attached.attachment {
                self.rig.made.instances.push(MovingInstance { instance, node, has_transform });
            }
        }
        Ok(())
    }

    /// The object that shows `object` in all instances of a node: one made of others, if there are several.
    fn repeated(
        &mut self,
        name: &str,
        index: Index,
        node: &json::Node,
        object: ObjectId,
        warnings: &mut Warnings,
    ) -> Result<ObjectId, Error> {
        let Some(from) = &node.extensions.instances else { return Ok(object) };
        if node.skin.is_some() {
            let detail = format!("{name}: EXT_mesh_gpu_instancing of a skinned mesh, shown once");
            warnings.note(Oddity::NotShown, &self.document.path, None, detail);
            return Ok(object);
        }
        let Some(copies) = instancing::copies(self.document, from, index)? else { return Ok(object) };
        let members = copies.into_iter().map(|attachment| Member::new(object, attachment)).collect();
        Ok(self.scene.add_object_of_members(name, members))
    }

    /// The visibility mask in a node's `extras`.
    fn ray_mask(&self, name: &str, node: &json::Node, warnings: &mut Warnings) -> RayMask {
        let Some(mask) = node.extras.as_ref().and_then(|extras| extras.get("mask")) else {
            return RayMask::ALL;
        };
        // Programs write whole numbers as floats, too.
        let whole =
            mask.as_f64().filter(|mask| mask.fract() == 0.0 && (0.0..=u32::MAX.into()).contains(mask));
        whole.map_or_else(
            || {
                let detail = format!("{name}: extras.mask is {mask}, not a number of 0 to 4294967295");
                warnings.note(Oddity::BadNode, &self.document.path, None, detail);
                RayMask::ALL
            },
            |mask| RayMask(mask as u32),
        )
    }

    fn add_camera(
        &mut self,
        name: &str,
        index: Index,
        from: &json::Camera,
        attached: NodeAttachment,
        warnings: &mut Warnings,
    ) {
        let path = &self.document.path;
        let described = camera::described(name, from, |what| {
            warnings.note(Oddity::CameraExtras, path, None, what);
        });
        let described = match described {
            Ok(described) => described,
            Err(why) => return warnings.note(Oddity::BadCamera, path, None, why),
        };
        let yfov = described.fov_y.to_radians();
        let Some(camera) = camera_at(&described, &attached.world_from_node, yfov) else {
            return warnings.note(Oddity::BadCamera, path, None, name);
        };
        let camera = self.scene.add_camera(camera);
        if let Some((file, parameters)) = from.extras.as_ref().and_then(json::shader_in) {
            let (access, file) = (&self.document.access, source::resolve(path, &file));
            match access.check(&file) {
                Ok(()) => {
                    let confined_to = access.confined_to();
                    self.scene.set_camera_file(
                        camera,
                        ShaderFile { file, parameters, confined_to, ..ShaderFile::default() },
                    );
                }
                Err((problem, _)) => {
                    warnings.note(Oddity::CameraExtras, path, None, format!("{name}: {problem}"))
                }
            }
        }
        if self.rig.drafts.drives_angle(index) || matches!(attached.attachment, Attachment::On(_)) {
            let field_of_view = self.rig.add_angle(index, yfov);
            self.rig.made.cameras.push(MovingCamera {
                camera,
                attachment: attached.attachment,
                field_of_view,
            });
        }
    }

    fn add_light(
        &mut self,
        (name, node): (String, &json::Node),
        index: Index,
        from: &json::Light<'_>,
        attached: NodeAttachment,
        warnings: &mut Warnings,
    ) {
        let kind = match &*from.kind {
            "point" => Some(LightKind::Point),
            "directional" => Some(LightKind::Directional),
            "spot" => Some(LightKind::Spot),
            _ => None,
        };
        let factors = kind.map(|kind| LightFactors {
            kind,
            color: from.color,
            intensity: from.intensity,
            inner_angle: from.spot.inner_cone_angle,
            outer_angle: from.spot.outer_cone_angle,
        });
        let visible = self.rig.is_visible(attached.attachment);
        let light =
            factors.and_then(|factors| Some((factors, factors.light(&attached.world_from_node, visible)?)));
        let Some((factors, light)) = light else {
            let detail = "light of an unknown kind or without a position";
            return warnings.note(Oddity::NotShown, &self.document.path, None, detail);
        };
        let moves = self.rig.drafts.drives_light(index) || matches!(attached.attachment, Attachment::On(_));
        if !visible && !moves {
            return;
        }
        let light = self.scene.add_light(light);
        let group =
            json::light_group(node.extras.as_ref()).or_else(|| json::light_group(from.extras.as_ref()));
        let labels = self.scene.labels_mut();
        group.iter().for_each(|group| labels.set_light_group(Shining::Light(light), group));
        if node.name.is_some() {
            labels.lights.insert(light, name);
        }
        if moves {
            let factors = self.rig.add_light(index, factors);
            self.rig.made.lights.push(MovingLight { light, attachment: attached.attachment, factors });
        }
    }
}
