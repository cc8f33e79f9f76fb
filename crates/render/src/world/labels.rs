// SPDX-License-Identifier: GPL-3.0-or-later
//! Names and groups of what gives off light, and of materials, for light path expressions.
//! Lights are in the order of a light set: points, spots, directional lights.
//! Tests: crates/render/tests/light_layers.rs.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gnurt_scene::labels::{LightLinks, Shining};
use gnurt_scene::{Attribute, InstanceId, Light, LightId, MaterialId, Mesh, Object, Scene};
use gnurt_shading::{AttributeRequest, PixelShader, SceneNames};

use super::material_table::MaterialTable;
use crate::mattes::id_of_material;

/// The names of a scene's parts for shaders that request them; none if no shader does. Shares them with `before` if
/// they are equal.
pub(super) fn names(
    scene: &Scene,
    materials: &MaterialTable,
    pixel: Option<&dyn PixelShader>,
    before: Option<Arc<SceneNames>>,
) -> Option<Arc<SceneNames>> {
    let is_names = |request: &AttributeRequest| request.name == AttributeRequest::IDS;
    let is_requested = materials.shaders().any(|shader| shader.attributes().iter().any(is_names));
    if !is_requested && !pixel.is_some_and(PixelShader::needs_names) {
        return None;
    }
    let sets = scene.labels().trace_sets.iter();
    let is_objects = |request: &AttributeRequest| request.name == AttributeRequest::OBJECTS;
    let asks_objects = materials.shaders().any(|shader| shader.attributes().iter().any(is_objects));
    let objects = || scene.objects().iter().filter(|_| asks_objects);
    let names = SceneNames {
        instances: scene.instances().iter().map(|instance| instance.name.clone()).collect(),
        objects: scene.objects().iter().map(|object| object.name.clone()).collect(),
        materials: scene.materials().iter().map(|material| material.name.clone()).collect(),
        sets: sets.map(|(name, set)| (name.clone(), set.iter().map(|id| id.0).collect())).collect(),
        object_of: match asks_objects {
            true => scene.instances().iter().map(|instance| instance.object.0).collect(),
            false => Vec::new(),
        },
        constants: (0..).zip(objects().map(|object| constants(scene, object))).collect(),
    };
    before.filter(|before| **before == names).or_else(|| Some(Arc::new(names)))
}

/// Attributes that have one value in all meshes of an object.
fn constants(scene: &Scene, object: &Object) -> BTreeMap<String, Vec<f32>> {
    let mut meshes = object.meshes.iter().filter_map(|&id| scene.meshes().get(id.0 as usize));
    let even = |attribute: &Attribute| {
        let mut values = attribute.data.chunks_exact(attribute.components.max(1) as usize);
        let first = values.next()?;
        values.all(|value| value == first).then(|| first.to_vec())
    };
    let of_mesh = |mesh: &Mesh| -> BTreeMap<String, Vec<f32>> {
        mesh.attributes.iter().filter_map(|a| Some((a.name.clone(), even(a)?))).collect()
    };
    let mut found = meshes.next().map(|mesh| of_mesh(mesh)).unwrap_or_default();
    for mesh in meshes {
        if found.is_empty() {
            break;
        }
        let other = of_mesh(mesh);
        found.retain(|name, value| other.get(name) == Some(value));
    }
    found
}

/// Names of one thing, and the group of its light.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Names {
    pub(crate) name: String,
    pub(crate) group: Option<String>,
    pub(crate) links: Option<LightLinks>,
}

impl Names {
    /// Whether it has this name, or a path that ends so.
    pub(crate) fn is(&self, name: &str) -> bool {
        self.name == name || self.name.rsplit('/').next() == Some(name).filter(|name| !name.is_empty())
    }
}

/// Whether something with these names is called so: by a name or its group, of which the first one counts.
pub(crate) fn are_called(label: &str, names: &[&Names]) -> bool {
    let group = names.iter().find_map(|names| names.group.as_deref());
    group == Some(label) || names.iter().any(|names| names.is(label))
}

/// The numbers below `count`, ascending by a key.
fn sorted_by_key<K: Ord>(count: usize, key: impl Fn(usize) -> K) -> Vec<usize> {
    let mut all: Vec<usize> = (0..count).collect();
    all.sort_by_key(|&i| key(i));
    all
}

/// The labels of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorldLabels {
    /// By material id.
    pub(crate) materials: Vec<Names>,
    /// Their ids of mattes.
    pub(crate) material_mattes: Vec<u32>,
    /// Lights without a surface, but the environment.
    pub(crate) lights: Vec<Names>,
    /// Numbers of these in the order of the scene.
    pub(crate) lights_of_scene: Vec<usize>,
    pub(crate) environment: Names,
    /// Instances with an emissive mesh, by id.
    pub(crate) instances: BTreeMap<u32, Names>,
    /// Instances that leave a hole in the picture.
    pub(crate) holdouts: BTreeSet<u32>,
    /// Whether any has links.
    pub(crate) has_links: bool,
}

impl WorldLabels {
    /// `order`: the lights as a light set has them; `emissive`: the instances with an emissive mesh.
    pub(super) fn new(scene: &Scene, order: &[LightId], emissive: &[u32]) -> Self {
        let labels = scene.labels();
        let group = |shining| labels.light_groups.get(&shining).cloned();
        let links = |shining| labels.light_links.get(&shining).cloned();
        let of_light = |&id: &LightId| Names {
            name: labels.lights.get(&id).cloned().unwrap_or_else(|| id.0.to_string()),
            group: group(Shining::Light(id)),
            links: links(Shining::Light(id)),
        };
        let is_environment = |light: &Light| matches!(light, Light::Environment { .. });
        let environment = scene.lights().iter().rposition(is_environment).map(|id| LightId(id as u32));
        let materials = (0..).zip(scene.materials()).map(|(id, material)| Names {
            name: material.name.clone(),
            group: group(Shining::Material(MaterialId(id))),
            links: links(Shining::Material(MaterialId(id))),
        });
        let instances = emissive.iter().map(|&id| {
            let name = scene.instances()[id as usize].name.clone();
            let shining = Shining::Instance(InstanceId(id));
            (id, Names { name, group: group(shining), links: links(shining) })
        });
        let mattes = (0..).zip(scene.materials()).map(|(id, material)| id_of_material(&material.name, id));
        Self {
            materials: materials.collect(),
            material_mattes: mattes.collect(),
            lights: order.iter().map(of_light).collect(),
            lights_of_scene: sorted_by_key(order.len(), |i| order[i]),
            environment: environment.as_ref().map(of_light).unwrap_or_default(),
            instances: instances.collect(),
            holdouts: labels.holdouts.iter().map(|id| id.0).collect(),
            has_links: !labels.light_links.is_empty(),
        }
    }
}
