// SPDX-License-Identifier: GPL-3.0-or-later
//! The world: a committed scene that rays can be sent into.
//! Two levels (a tree per object, a top tree over instances) after \[SIP06\], section 6, and \[WBS03a\].
//! Space: world. Invariant: the parts that a hit names exist; errors ended at commit. Its parts are separated
//! by the edits that affect them, immutable and shared: a clone keeps the world as it was.
//! Tests: crates/render/tests/{commit,edits}.rs.

mod areas;
mod beams;
mod bend;
mod camera_masks;
mod casters;
mod check;
mod commit;
mod crowds;
mod dirty;
mod emitters;
mod grid;
mod instance;
mod labels;
mod lights;
mod material_table;
mod materials;
mod media;
mod members;
mod normals;
mod object;
mod object_build;
mod open;
mod shader_emission;
mod strands;
mod surface;
mod table;
#[cfg(test)]
mod tests;
pub(crate) mod textures;
mod top;
mod transform;
mod users;
mod velocity;

use std::collections::HashSet;
use std::ops::Range;
use std::sync::{Arc, Weak};

use gnurt_accel::{Hit, HitBatch, INVALID_ID, Ray, SceneTree, SharedList};
use gnurt_image::WorkingSpace;
use gnurt_scene::ObjectId;
use gnurt_scene::edit::{Cursor, SceneIdentity};
use gnurt_shading::lights::LightSet;
use gnurt_shading::{PixelShader, SampleKey, SceneNames, SurfaceShader};

use crate::many_lights::PluginEmitters;
pub(crate) use bend::Bend;
pub(crate) use casters::PlacedMesh;
use crowds::Crowds;
use dirty::Displaced;
use emitters::Shown;
pub(crate) use grid::GridRay;
use instance::InstanceSlot;
pub(crate) use labels::{Names, WorldLabels, are_called};
pub(crate) use lights::{LightPart, Lights, LightsContent};
pub(crate) use material_table::MaterialTable;
pub(crate) use media::{Inside, Media, MediumEntry};
use object::{ObjectSlot, WorldObject};
use open::Open;
pub(crate) use open::Shutter;
use surface::Leaves;
pub(crate) use surface::{HitLanes, SurfacePoints};
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
    /// By object id.
    objects: Arc<SharedList<ObjectSlot>>,
    crowds: Crowds,
    /// By instance id; trailing instances without geometry are absent.
    instances: Arc<SharedList<InstanceSlot>>,
    tree: Arc<SceneTree>,
    /// By material id.
    materials: Arc<MaterialTable>,
    lights: Arc<Lights>,
    media: Arc<Media>,
    labels: Arc<WorldLabels>,
    /// Names of parts, if some shader requests them.
    names: Option<Arc<SceneNames>>,
    face_normals: bool,
    /// The pixel shader, if pixels show more than the radiance along their rays.
    pixel: Option<Arc<dyn PixelShader>>,
    /// Parts that move during the open shutter; `None` if nothing moves.
    open: Option<Arc<Open>>,
    /// When rays see it.
    shutter: Shutter,
    dropped: Dropped,
    follows: Option<Followed>,
}

/// Identifies a world; keeps none alive.
pub(crate) struct WorldMark {
    instances: Weak<SharedList<InstanceSlot>>,
    tree: Weak<SceneTree>,
    materials: Weak<MaterialTable>,
    lights: Weak<Lights>,
    media: Weak<Media>,
    content: LightsContent,
}

impl WorldMark {
    /// Whether nothing was changed.
    pub(crate) fn is_of(&self, world: &World) -> bool {
        self.instances.as_ptr() == Arc::as_ptr(&world.instances)
            && self.tree.as_ptr() == Arc::as_ptr(&world.tree)
            && self.materials.as_ptr() == Arc::as_ptr(&world.materials)
            && self.lights.as_ptr() == Arc::as_ptr(&world.lights)
            && self.media.as_ptr() == Arc::as_ptr(&world.media)
    }

    /// Whether the lights are unchanged; the lit geometry may differ.
    pub(crate) fn has_lights_of(&self, world: &World) -> bool {
        self.content == world.lights.content
    }
}

/// How far a world has followed its scene.
#[derive(Clone)]
struct Followed {
    identity: SceneIdentity,
    cursor: Cursor,
    options: CommitOptions,
    /// What moved vertices.
    displaced: Displaced,
}

/// Counts of dropped and of all elements.
#[derive(Clone, Copy, Default)]
struct Dropped {
    triangles: usize,
    /// Members of objects, too.
    instances: usize,
}

impl Dropped {
    /// In an object by itself.
    fn of(slot: &ObjectSlot) -> Self {
        let Some(object) = &slot.object else { return Self::default() };
        let instances = object.members.as_ref().map_or(0, |members| members.dropped());
        Self { triangles: object.tree.bad_primitives().total() as usize, instances }
    }
}

impl std::ops::AddAssign for Dropped {
    fn add_assign(&mut self, more: Self) {
        self.triangles += more.triangles;
        self.instances += more.instances;
    }
}

impl std::ops::SubAssign for Dropped {
    fn sub_assign(&mut self, fewer: Self) {
        self.triangles -= fewer.triangles;
        self.instances -= fewer.instances;
    }
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

    /// The space of its light.
    #[must_use]
    pub fn space(&self) -> WorkingSpace {
        self.follows.as_ref().map_or_else(WorkingSpace::default, |followed| followed.options.space)
    }

    /// Sizes.
    #[must_use]
    pub fn stats(&self) -> WorldStats {
        let top = self.tree.stats();
        let mut stats = WorldStats {
            tree_nodes: top.nodes as usize,
            tree_bytes: (top.tree_bytes + top.primitive_bytes) as usize,
            lights: self.lights.shaders.len(),
            ..WorldStats::default()
        };
        // Shared parts count once: trees by objects in equal poses, structures by poses.
        let mut visible = HashSet::new();
        for object in self.objects.iter().filter_map(|slot| slot.object.as_ref()) {
            let tree = object.tree.stats();
            stats.objects += 1;
            stats.triangles += tree.primitives as usize;
            stats.tree_nodes += tree.nodes as usize;
            if visible.insert(Arc::as_ptr(&object.tree).cast::<()>()) {
                stats.tree_bytes += (tree.tree_bytes + tree.primitive_bytes) as usize;
            }
            if object.tree.is_posed() && visible.insert(object.kind_ptr()) {
                stats.tree_bytes += object.tree.shared_bytes() as usize;
            }
            if let Some(members) = &object.members {
                let inner = members.tree.stats();
                stats.tree_nodes += inner.nodes as usize;
                stats.tree_bytes += (inner.tree_bytes + inner.primitive_bytes) as usize;
            }
            stats.array_bytes += object.meshes.iter().map(|mesh| mesh.memory_bytes()).sum::<usize>();
        }
        for instance in self.instances.iter().filter_map(InstanceSlot::placed) {
            stats.instances += 1;
            stats.instanced_triangles += instance.object.triangles() as usize;
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

    /// The geometric normal at a hit of this world, of unit length, in world space: towards the side from which the triangle's
    /// vertices go around counter-clockwise. Of moving meshes it is the normal when the shutter opens. `None` for spheres, and
    /// for curves whose normals depend on the point.
    #[must_use]
    pub fn normal(&self, hit: &Hit) -> Option<[f32; 3]> {
        self.tree.normal(hit)
    }

    /// The same for a hit at a point in world space, also of spheres and curves, whose normals look outwards.
    #[must_use]
    pub fn normal_at(&self, hit: &Hit, point: [f64; 3]) -> Option<[f32; 3]> {
        self.tree.normal_at(hit, point)
    }

    /// All lights but those of shader plugins, with densities.
    pub(crate) fn light_set(&self) -> &LightSet {
        self.lights.set()
    }

    /// Whether something moves while the shutter is open.
    pub(crate) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Whether the times of rays are still undefined.
    pub(crate) fn needs_times(&self) -> bool {
        self.is_open() && self.shutter == Shutter::Closed
    }

    /// Whether lights move during the open shutter.
    pub(crate) fn lights_move(&self) -> bool {
        self.open.as_ref().is_some_and(|open| open.lights_move())
    }

    /// The same world, whose rays have their own times.
    pub(crate) fn with_times(&self, seed: u64) -> Self {
        Self { shutter: Shutter::Each(seed), ..self.clone() }
    }

    /// The world at the time of a pass.
    pub(crate) fn of_pass(&self, seed: u64, sample: u32, pool: &rayon::ThreadPool) -> Self {
        self.at(open::time_of_pass(seed, sample), pool)
    }

    /// The world at one time of the open shutter, from 0 to 1: all rays use it, and lights are at their
    /// positions then.
    #[must_use]
    pub fn at(&self, time: f32, pool: &rayon::ThreadPool) -> Self {
        let mut world = Self { shutter: Shutter::All(time), ..self.clone() };
        if let Some(open) = self.open.as_ref().filter(|open| open.lights_move()) {
            let emitters = open.lights_move.then(|| self.lights.emitters.at(time, self.shown(pool)));
            world.lights = Arc::new(self.lights.at(open.lights_at(time), emitters));
        }
        world
    }

    /// Where its points are computed.
    pub(crate) fn surface_points(&self) -> SurfacePoints<'_> {
        let shutter = self.is_open().then_some(self.shutter);
        let (instances, leaves) = (&*self.instances, Leaves::Tree(&self.tree));
        let (face_normals, curved) = (self.face_normals, self.materials.read_widths());
        SurfacePoints { instances, leaves, shutter, face_normals, curved, names: self.names.as_ref() }
    }

    /// The input of the search for emissive triangles.
    fn shown<'a>(&'a self, pool: &'a rayon::ThreadPool) -> Shown<'a> {
        Shown {
            instances: &self.instances,
            tree: &self.tree,
            materials: &self.materials,
            face_normals: self.face_normals,
            pool,
        }
    }

    /// The time of a ray with this key.
    #[inline]
    pub(crate) fn time(&self, key: SampleKey) -> f32 {
        self.shutter.time(key)
    }

    /// The common time of all rays, if they have one.
    pub(crate) fn time_of_all(&self) -> f32 {
        match self.shutter {
            Shutter::All(time) => time,
            Shutter::Closed | Shutter::Each(_) => 0.0,
        }
    }

    /// Where light paths start at lights of shader plugins.
    pub(crate) fn plugin_emitters(&self) -> &PluginEmitters {
        self.lights.plugin_emitters(self.bounds())
    }

    /// Identity that distinguishes it from a world of any other commit.
    pub(crate) fn mark(&self) -> WorldMark {
        WorldMark {
            instances: Arc::downgrade(&self.instances),
            tree: Arc::downgrade(&self.tree),
            materials: Arc::downgrade(&self.materials),
            lights: Arc::downgrade(&self.lights),
            media: Arc::downgrade(&self.media),
            content: self.lights.content.clone(),
        }
    }

    pub(crate) fn tree(&self) -> &SceneTree {
        &self.tree
    }

    pub(crate) fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Names and groups of lights and materials.
    /// Names of the scene's parts, if some shader requests them.
    pub(crate) fn names(&self) -> Option<&SceneNames> {
        self.names.as_deref()
    }

    pub(crate) fn labels(&self) -> &WorldLabels {
        &self.labels
    }

    /// Ids of mattes of a hit: object, material, asset.
    pub(crate) fn matte_ids(&self, instance: u32, material: u32) -> [u32; 3] {
        let placed = self.instances.get(instance as usize).and_then(InstanceSlot::placed);
        let [object, asset] = placed.map_or([0; 2], |placed| placed.mattes);
        let material = self.labels.material_mattes.get(material as usize).copied().unwrap_or(0);
        [object, material, asset]
    }

    /// The media that paths fly through.
    pub(crate) fn media(&self) -> &Media {
        &self.media
    }

    pub(crate) fn materials(&self) -> &MaterialTable {
        &self.materials
    }

    /// The pixel shader, if pixels show more than the radiance along their rays.
    pub(crate) fn pixel(&self) -> Option<&dyn PixelShader> {
        self.pixel.as_deref()
    }

    /// The shader of a material.
    pub(crate) fn shader(&self, material: usize) -> &dyn SurfaceShader {
        &*self.materials.get(material).shader
    }

    /// The material of a hit: its index among the surface shaders.
    pub(crate) fn material_of(&self, leaf_id: u32, geom_id: u32) -> u32 {
        self.leaf(leaf_id).0.meshes[geom_id as usize].material.0
    }

    /// Writes the lanes in `range` that hit something in order of their materials: material in the upper half of each word, lane in
    /// the lower one.
    pub(crate) fn sort_by_material(&self, hits: &HitBatch, range: Range<usize>, order: &mut Vec<u64>) {
        order.clear();
        let (mut last, mut material) = ([INVALID_ID; 2], 0);
        let mut in_order = true;
        let lanes = hits.leaf_id[range.clone()].iter().zip(&hits.geom_id[range.clone()]);
        for (lane, (&leaf_id, &geom_id)) in range.zip(lanes) {
            if hits.prim_id[lane] == INVALID_ID {
                continue;
            }
            if last != [leaf_id, geom_id] {
                let next = self.material_of(leaf_id, geom_id);
                in_order &= order.is_empty() || next >= material;
                (last, material) = ([leaf_id, geom_id], next);
            }
            order.push(u64::from(material) << 32 | lane as u64);
        }
        if !in_order {
            order.sort_unstable();
        }
    }

    /// The object of the hit triangle: within the instance, if that holds other objects.
    #[must_use]
    pub fn object_of(&self, hit: &Hit) -> ObjectId {
        self.leaf(hit.leaf_id).1
    }

    /// The object that a leaf of the tree is, and its id.
    pub(crate) fn leaf(&self, leaf_id: u32) -> (&WorldObject, ObjectId) {
        let (instance, leaf) = self.surface_points().instance(leaf_id);
        instance.leaf(leaf)
    }
}
