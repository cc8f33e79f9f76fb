// SPDX-License-Identifier: GPL-3.0-or-later
//! The names that mattes identify things by: those of the scene; things without a name get one by their number.
//! Tests: crates/render/tests/mattes.rs.

use std::collections::{BTreeMap, BTreeSet};

use gnurt_scene::{Instance, InstanceId, MaterialId, Scene};

use super::kinds::MatteKind;
use super::name::matte_id;

fn or_number(name: &str, what: &str, id: u32) -> String {
    if name.is_empty() { format!("{what} {id}") } else { name.to_owned() }
}

/// Ids of an instance and of its asset.
pub(crate) fn ids_of_instance(scene: &Scene, id: u32, instance: &Instance) -> [u32; 2] {
    let object = scene.objects().get(instance.object.index());
    let asset = or_number(object.map_or("", |object| &object.name), "object", instance.object.0);
    [matte_id(&or_number(&instance.name, "instance", id)), matte_id(&asset)]
}

/// The id of a material.
pub(crate) fn id_of_material(name: &str, id: u32) -> u32 {
    matte_id(&or_number(name, "material", id))
}

/// The names of ids in a scene's mattes of a kind. Of several names with one id, the first counts.
#[must_use]
pub fn matte_names(scene: &Scene, kind: MatteKind, ids: &BTreeSet<u32>) -> BTreeMap<String, u32> {
    let instances = (0..scene.instances().len() as u32).map(InstanceId);
    let names: Box<dyn Iterator<Item = String>> = match kind {
        MatteKind::Object => {
            Box::new(instances.map(|id| or_number(&scene.instance(id).name, "instance", id.0)))
        }
        MatteKind::Asset => Box::new(instances.map(|id| {
            let object = scene.instance(id).object;
            or_number(&scene.object(object).name, "object", object.0)
        })),
        MatteKind::Material => {
            let materials = (0..scene.materials().len() as u32).map(MaterialId);
            Box::new(materials.map(|id| or_number(&scene.material(id).name, "material", id.0)))
        }
    };
    let (mut found, mut named) = (BTreeMap::new(), BTreeSet::new());
    for name in names {
        let id = matte_id(&name);
        if ids.contains(&id) && named.insert(id) {
            found.insert(name, id);
        }
    }
    found
}
