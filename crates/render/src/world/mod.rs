// SPDX-License-Identifier: GPL-3.0-or-later
//! The world: a committed scene that rays can be sent into.
//! Source: original; two levels (a tree per object, a top tree over instances) after the paper's section 6 and \[WBS03a\].
//! Space: world. Invariant: whatever a hit names is there; errors ended at commit.
//! Proof: crates/render/tests/commit.rs.

mod commit;
mod flat;
mod instance;
mod lights;
mod materials;
mod object;
mod plain;
mod surface;
mod table;

use std::ops::Range;
use std::sync::{Arc, OnceLock, Weak};

use gnurt_accel::{Hit, HitBatch, INVALID_ID, Ray, SceneTree};
use gnurt_scene::edit::Cursor;
use gnurt_shading::lights::{LightParts, LightSet};
use gnurt_shading::materials::{Lambertian, PlainColor};
use gnurt_shading::{EnvironmentShader, LightShader, SurfaceShader};

use crate::many_lights::ShaderLamps;
pub(crate) use flat::FlatLanes;
pub(crate) use instance::PlacedInstance;
pub(crate) use object::WorldObject;
pub(crate) use surface::HitLanes;
pub use table::{CommitOptions, CommitReport, ShaderTable};

/// Sizes of a world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldStats {
    /// Triangles in memory: each object counts once.
    pub triangles: usize,
    /// Triangles that rays may meet: each instance counts.
    pub instanced_triangles: usize,
    /// Objects with a tree.
    pub objects: usize,
    /// Instances that rays may meet.
    pub instances: usize,
    /// Nodes of all trees.
    pub tree_nodes: usize,
    /// Bytes of all trees, prepared triangles included.
    pub tree_bytes: usize,
    /// Bytes of the meshes' arrays.
    pub array_bytes: usize,
    /// Lights: all emissive triangles together are one.
    pub lights: usize,
}

/// A committed scene. Cheap to clone: a clone is a snapshot that later commits do not touch.
#[derive(Clone, Default)]
pub struct World {
    /// By object id; `None` where no visible instance needs it.
    objects: Arc<Vec<Option<Arc<WorldObject>>>>,
    /// By instance id; `None` where rays meet nothing.
    instances: Arc<Vec<Option<PlacedInstance>>>,
    tree: Arc<SceneTree>,
    shading: Arc<Shading>,
    face_normals: bool,
    follows: Option<Followed>,
}

/// Tells worlds apart; keeps none of them.
pub(crate) struct WorldMark {
    tree: Weak<SceneTree>,
    shading: Weak<Shading>,
}

impl WorldMark {
    pub(crate) fn is_of(&self, world: &World) -> bool {
        self.tree.as_ptr() == Arc::as_ptr(&world.tree) && self.shading.as_ptr() == Arc::as_ptr(&world.shading)
    }
}

/// How far a world has followed its scene.
#[derive(Clone, Copy)]
struct Followed {
    cursor: Cursor,
    options: CommitOptions,
}

/// All shaders of a world.
#[derive(Default)]
pub(crate) struct Shading {
    /// By material id.
    pub(crate) surfaces: Vec<Arc<dyn SurfaceShader>>,
    /// Likewise: those that are Lambert's reflector, as lanes need them.
    pub(crate) lambertian: Vec<Option<Lambertian>>,
    /// Likewise: base colours, where they are plain.
    plain: Vec<Option<PlainColor>>,
    pub(crate) lights: Vec<Arc<dyn LightShader>>,
    /// Which of them are not in the light set, because they only know `illuminate`.
    pub(crate) plugin_lights: Range<usize>,
    pub(crate) environment: Option<Arc<dyn EnvironmentShader>>,
    /// Whether no surface lets light straight through.
    pub(crate) all_opaque: bool,
    /// Whether no surface has holes; one that lets light through by scattering it has none.
    pub(crate) all_solid: bool,
    parts: LightParts,
    /// Built for the first integrator that wants it.
    light_set: OnceLock<LightSet>,
    /// Likewise: where light paths start at lights that only know `illuminate`.
    shader_lamps: OnceLock<ShaderLamps>,
}

impl World {
    /// An empty world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Lower and upper corner of everything that rays may meet; `None` if there is nothing.
    #[must_use]
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let bounds = self.tree.bounds();
        (!bounds.is_empty()).then_some((bounds.min, bounds.max))
    }

    /// Sizes.
    #[must_use]
    pub fn stats(&self) -> WorldStats {
        let top = self.tree.stats();
        let mut stats = WorldStats {
            tree_nodes: top.nodes as usize,
            tree_bytes: (top.tree_bytes + top.primitive_bytes) as usize,
            lights: self.shading.lights.len(),
            ..WorldStats::default()
        };
        for object in self.objects.iter().flatten() {
            let tree = object.tree.stats();
            stats.objects += 1;
            stats.triangles += tree.primitives as usize;
            stats.tree_nodes += tree.nodes as usize;
            stats.tree_bytes += (tree.tree_bytes + tree.primitive_bytes) as usize;
            stats.array_bytes += object.meshes.iter().map(|mesh| mesh.memory_bytes()).sum::<usize>();
        }
        for instance in self.instances.iter().flatten() {
            stats.instances += 1;
            stats.instanced_triangles += instance.object.tree.stats().primitives as usize;
        }
        stats
    }

    /// The closest hit of one ray.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.tree.intersect(ray)
    }

    /// Whether one ray hits anything at all, see-through surfaces included.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.tree.occluded(ray)
    }

    /// All lights but those of shader plugins, with densities.
    pub(crate) fn light_set(&self) -> &LightSet {
        self.shading.light_set.get_or_init(|| LightSet::new(self.shading.parts.clone()))
    }

    /// Where light paths start at lights of shader plugins.
    pub(crate) fn shader_lamps(&self) -> &ShaderLamps {
        let shading = &*self.shading;
        let lights = &shading.lights[shading.plugin_lights.clone()];
        let environment = shading.environment.as_deref().filter(|_| shading.parts.environment.is_none());
        shading.shader_lamps.get_or_init(|| ShaderLamps::new(lights, environment, self.bounds()))
    }

    /// What tells it from any world that came of another commit.
    pub(crate) fn mark(&self) -> WorldMark {
        WorldMark { tree: Arc::downgrade(&self.tree), shading: Arc::downgrade(&self.shading) }
    }

    pub(crate) fn tree(&self) -> &SceneTree {
        &self.tree
    }

    pub(crate) fn shading(&self) -> &Shading {
        &self.shading
    }

    /// The material of what was hit: its place among the surface shaders.
    pub(crate) fn material_of(&self, inst_id: u32, geom_id: u32) -> u32 {
        self.instance(inst_id).object.meshes[geom_id as usize].material.0
    }

    /// Writes the lanes in `range` that hit something in order of their materials: material in the upper half of each word, lane in
    /// the lower one.
    pub(crate) fn sort_by_material(&self, hits: &HitBatch, range: Range<usize>, order: &mut Vec<u64>) {
        order.clear();
        let (mut last, mut material) = ([INVALID_ID; 2], 0);
        let mut in_order = true;
        let lanes = hits.inst_id[range.clone()].iter().zip(&hits.geom_id[range.clone()]);
        for (lane, (&inst_id, &geom_id)) in range.zip(lanes) {
            if hits.prim_id[lane] == INVALID_ID {
                continue;
            }
            if last != [inst_id, geom_id] {
                let next = self.material_of(inst_id, geom_id);
                in_order &= order.is_empty() || next >= material;
                (last, material) = ([inst_id, geom_id], next);
            }
            order.push(u64::from(material) << 32 | lane as u64);
        }
        if !in_order {
            order.sort_unstable();
        }
    }

    /// The object that an instance shows.
    pub(crate) fn object_of(&self, inst_id: u32) -> u32 {
        self.instance(inst_id).object_id.0
    }

    /// Panics where nothing can be hit; hits name only instances that are there.
    fn instance(&self, inst_id: u32) -> &PlacedInstance {
        self.instances[inst_id as usize].as_ref().expect("hits name instances that are there")
    }
}
