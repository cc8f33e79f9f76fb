// SPDX-License-Identifier: GPL-3.0-or-later
//! Light linking: lights that reach some instances only, and lights that only some instances stop.
//! A light sample of a point that its light does not reach counts nothing, and neither does its emission where a ray from
//! such a point finds it. A light with shadows of its own is left to light samples: scattered rays stop at surfaces that
//! do not stop its light. Points in media belong to no instance: all lights reach them.
//! Invariant: worlds without links skip this. Tests: crates/render/tests/light_links.rs.

use std::sync::Arc;

use gnurt_scene::InstanceId;
use gnurt_scene::labels::LightLinks as Described;
use gnurt_shading::lights::LightId;

use crate::world::World;

/// The instance of points in media, and of the camera.
const NOWHERE: u32 = u32::MAX;

/// Sets of instances by light of the light set; set 0 holds all.
#[derive(Debug, Default)]
pub(crate) struct LightLinks {
    /// Lit ones and those that cast shadows.
    of_light: Vec<[u16; 2]>,
    /// Ascending.
    sets: Vec<Vec<InstanceId>>,
}

impl LightLinks {
    /// `None` if all lights reach everything.
    pub(crate) fn new(world: &World) -> Option<Self> {
        let labels = world.labels();
        if !labels.has_links {
            return None;
        }
        let mut made = Self { of_light: Vec::new(), sets: vec![Vec::new()] };
        let mut last = ([u32::MAX; 2], [0; 2]);
        for &[leaf, mesh, _] in world.lights().shape_ids() {
            if last.0 != [leaf, mesh] {
                let instance = world.tree().instance_at(leaf).and_then(|(id, _)| labels.instances.get(&id));
                let material = labels.materials.get(world.material_of(leaf, mesh) as usize);
                let links = [instance, material].into_iter().flatten().find_map(|names| names.links.as_ref());
                last = ([leaf, mesh], made.add(links));
            }
            made.of_light.push(last.1);
        }
        for names in labels.lights.iter().chain([&labels.environment]) {
            let sets = made.add(names.links.as_ref());
            made.of_light.push(sets);
        }
        made.of_light.iter().any(|sets| *sets != [0; 2]).then_some(made)
    }

    fn add(&mut self, links: Option<&Described>) -> [u16; 2] {
        let mut set = |list: Option<&Vec<InstanceId>>| {
            let Some(list) = list else { return 0 };
            let mut sorted = list.clone();
            sorted.sort_unstable();
            sorted.dedup();
            let known = self.sets.iter().skip(1).position(|known| *known == sorted);
            let number = known.map_or(self.sets.len(), |position| position + 1);
            if number == self.sets.len() {
                self.sets.push(sorted);
            }
            u16::try_from(number).unwrap_or(0)
        };
        links.map_or([0; 2], |links| [set(links.lit.as_ref()), set(links.shadows.as_ref())])
    }

    fn holds(&self, set: u16, instance: u32) -> bool {
        set == 0
            || instance == NOWHERE
            || self.sets[set as usize].binary_search(&InstanceId(instance)).is_ok()
    }

    fn sets_of(&self, light: LightId) -> [u16; 2] {
        self.of_light.get(light.0 as usize).copied().unwrap_or_default()
    }

    /// Whether a light reaches points of an instance.
    pub(crate) fn reaches(&self, light: LightId, instance: u32) -> bool {
        self.holds(self.sets_of(light)[0], instance)
    }

    /// The set of instances that stop a light.
    pub(crate) fn blockers(&self, light: LightId) -> u16 {
        self.sets_of(light)[1]
    }

    /// Whether an instance of such a set stops light.
    pub(crate) fn stops(&self, set: u16, instance: u32) -> bool {
        self.holds(set, instance)
    }
}

/// The sets of instances that stop each ray.
#[derive(Clone, Copy)]
pub(crate) struct Blockers<'a> {
    pub(crate) links: &'a LightLinks,
    pub(crate) sets: &'a [u16],
}

/// Where the paths of a wavefront were scattered, and the blockers of light that may be occluded.
pub(crate) struct LinkedPaths {
    pub(crate) links: Arc<LightLinks>,
    from: Vec<u32>,
    next: Vec<u32>,
    pub(crate) blockers: Vec<u16>,
}

impl LinkedPaths {
    pub(crate) fn new(links: Arc<LightLinks>) -> Self {
        Self { links, from: Vec::new(), next: Vec::new(), blockers: Vec::new() }
    }

    /// Begins with paths from the camera.
    pub(crate) fn start(&mut self, count: usize) {
        self.from.clear();
        self.from.resize(count, NOWHERE);
        self.begin_step();
    }

    pub(crate) fn begin_step(&mut self) {
        self.next.clear();
        self.blockers.clear();
    }

    pub(crate) fn end_step(&mut self) {
        std::mem::swap(&mut self.from, &mut self.next);
    }

    /// The next path is path `number`, straight on.
    pub(crate) fn pass(&mut self, number: usize) {
        self.next.push(self.from[number]);
    }

    /// The next path was scattered by an instance; `None` = by a medium.
    pub(crate) fn scatter(&mut self, instance: Option<u32>) {
        self.next.push(instance.unwrap_or(NOWHERE));
    }

    /// Whether the light counts that path `number` found; `is_sampled`: light samples find it, too.
    pub(crate) fn counts(&self, number: usize, light: LightId, is_sampled: bool) -> bool {
        let has_own_shadows = self.links.blockers(light) != 0;
        self.links.reaches(light, self.from[number]) && !(is_sampled && has_own_shadows)
    }
}
