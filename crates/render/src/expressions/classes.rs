// SPDX-License-Identifier: GPL-3.0-or-later
//! The events of a world's paths: which class each material and each light is of.
//! A label `'x'` is a name, the last part of a path, or the group of a light; `'@x'` is the group alone, and `'@'` a
//! light without one.
//! Names of emissive surfaces are those of their material and of their instance.
//! Tests: crates/render/tests/light_layers.rs.

use std::collections::HashMap;

use glam::Vec3;
use gnurt_shading::lights::{LightId, LightSet};

use super::events::{Alphabet, End, Lobe, Scatter};
use crate::world::{Names, World};

/// The classes of everything.
#[derive(Debug, Default)]
pub(crate) struct Classes {
    /// By material.
    surfaces: Vec<u16>,
    /// By light of the light set: triangles, points, spots, directional lights, environment.
    lights: Vec<u16>,
    /// By material, for emission that is not in the light set.
    emission: Vec<u16>,
    background: u16,
    unnamed: u16,
}

/// Distinct sets of labels.
#[derive(Default)]
struct Distinct {
    masks: Vec<u64>,
    numbers: HashMap<u64, u16>,
}

impl Distinct {
    fn number(&mut self, mask: u64) -> u16 {
        *self.numbers.entry(mask).or_insert_with(|| {
            self.masks.push(mask);
            self.masks.len() as u16 - 1
        })
    }
}

/// The labels among `labels` that something with these names has, as bits. The first group counts.
fn mask(labels: &[String], names: &[&Names]) -> u64 {
    let group = names.iter().find_map(|names| names.group.as_deref());
    let has = |label: &str| match label.strip_prefix('@') {
        Some("") => group.is_none(),
        Some(only) => group == Some(only),
        None => group == Some(label) || names.iter().any(|names| names.is(label)),
    };
    (0..).zip(labels).filter(|(_, label)| has(label)).fold(0, |bits, (i, _)| bits | 1 << i)
}

impl Classes {
    /// Classes, and the alphabet of their events.
    pub(crate) fn of(world: &World, labels: Vec<String>) -> (Self, Alphabet) {
        let known = world.labels();
        let (mut surfaces, mut lights) = (Distinct::default(), Distinct::default());
        let mut classes = Self { unnamed: lights.number(mask(&labels, &[])), ..Self::default() };
        surfaces.number(0);
        for names in &known.materials {
            let plain = Names { group: None, ..names.clone() };
            // Groups are of lights.
            let own = mask(&labels, &[&plain]) & !mask(&labels, &[&Names::default()]);
            classes.surfaces.push(surfaces.number(own));
            classes.emission.push(lights.number(mask(&labels, &[names])));
        }
        let nothing = Names::default();
        let mut of_mesh = HashMap::new();
        for &[leaf, mesh, _] in world.lights().shape_ids() {
            let class = *of_mesh.entry((leaf, mesh)).or_insert_with(|| {
                let material = known.materials.get(world.material_of(leaf, mesh) as usize);
                let instance = world.tree().instance_at(leaf).and_then(|(id, _)| known.instances.get(&id));
                let names = [instance.unwrap_or(&nothing), material.unwrap_or(&nothing)];
                lights.number(mask(&labels, &names))
            });
            classes.lights.push(class);
        }
        for names in known.lights.iter().chain([&known.environment]) {
            classes.lights.push(lights.number(mask(&labels, &[names])));
        }
        classes.background = lights.number(mask(&labels, &[&known.environment]));
        (classes, Alphabet::new(labels, surfaces.masks, lights.masks))
    }

    /// A surface scatters light.
    pub(crate) fn scatter(&self, material: u32, is_transmitted: bool, lobe: Lobe) -> Scatter {
        Scatter::surface(self.surfaces.get(material as usize).copied().unwrap_or(0), is_transmitted, lobe)
    }

    /// A light of the light set; `lights` is that.
    pub(crate) fn light(&self, light: LightId, lights: &LightSet) -> End {
        let is_environment = lights.has_environment() && light.0 as usize + 1 == lights.len();
        if is_environment {
            return self.background();
        }
        End::light(self.lights.get(light.0 as usize).copied().unwrap_or(self.unnamed))
    }

    /// A ray along `dir` found emission on a primitive: leaf, mesh, number.
    pub(crate) fn surface(&self, lights: &LightSet, ids: [u32; 3], dir: Vec3, material: u32) -> End {
        match lights.shape(ids, dir) {
            Some(shape) => self.light(LightId(shape), lights),
            None => End::emission(self.emission.get(material as usize).copied().unwrap_or(self.unnamed)),
        }
    }

    /// The environment.
    pub(crate) fn background(&self) -> End {
        End::background(self.background)
    }

    /// Emission of media.
    pub(crate) fn medium(&self) -> End {
        End::emission(self.unnamed)
    }

    /// A light of a shader plugin.
    pub(crate) fn plugin(&self) -> End {
        End::light(self.unnamed)
    }
}
