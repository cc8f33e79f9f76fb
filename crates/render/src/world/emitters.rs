// SPDX-License-Identifier: GPL-3.0-or-later
//! The emissive triangles: all those of all instances together are one light.
//! Space: world. They are searched for again only if an emissive instance moved, came or went, an emissive
//! object was changed, or a material's emission changed. Tests:
//! `crates/render/tests/{lights,commit,shader_emission}.rs`.

use std::ops::Range;
use std::sync::Arc;

use gnurt_accel::threads;
use gnurt_accel::{KeyInterval, SceneTree, SharedList};
use gnurt_scene::RayMask;
use gnurt_shading::lights as shading;

use super::instance::{InstanceSlot, PlacedInstance};
use super::material_table::MaterialTable;
use super::object::WorldObject;
use super::shader_emission::{EmissionShape, ShaderEmission};
use super::transform::Transform;

/// The input of the search for emissive triangles.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub(super) instances: &'a SharedList<InstanceSlot>,
    /// Which numbers their objects.
    pub(super) tree: &'a SceneTree,
    pub(super) materials: &'a MaterialTable,
    pub(super) face_normals: bool,
    pub(super) pool: &'a rayon::ThreadPool,
}

/// All emissive triangles.
#[derive(Default)]
pub(super) struct Emitters {
    pub(super) triangles: Option<Arc<shading::ShapeLights>>,
    /// Object (by its number in the tree over instances), mesh and triangle of each of them, ascending; twice
    /// if both sides emit.
    pub(super) ids: Arc<Vec<[u32; 3]>>,
    /// Instances with an emissive mesh, ascending.
    pub(super) instances: Vec<u32>,
}

/// Triangles that may emit: leaf, mesh and triangle of each, and the data of those whose shaders are queried.
#[derive(Default)]
struct Found {
    triangles: Vec<shading::EmissiveShape>,
    ids: Vec<[u32; 3]>,
    glowing: Vec<Option<EmissionShape>>,
}

/// Instances that a thread asks at a time whether they emit.
const CHUNK: usize = 4096;

/// Emissive instances whose triangles a thread collects at a time.
const TOGETHER: usize = 64;

impl Emitters {
    /// The emitters after a change of the instances of `changed`, ascending; `None` if they are unchanged.
    pub(super) fn after(&self, changed: &[u32], emission_changed: bool, shown: Shown) -> Option<Self> {
        let Shown { instances, materials, pool, .. } = shown;
        let is_emissive = |instance_index: usize| {
            let placed = instances.get(instance_index).and_then(InstanceSlot::placed);
            // Geometry hidden from light rays emits none.
            placed.is_some_and(|placed| {
                placed.mask.meets(RayMask::OTHER) && shows_emitters(&placed.object, materials)
            })
        };
        let now: Vec<u32> = if emission_changed {
            let of_chunk = |n: usize| {
                let end = ((n + 1) * CHUNK).min(instances.len());
                (n * CHUNK..end)
                    .filter(|&instance_index| is_emissive(instance_index))
                    .map(|instance_index| instance_index as u32)
                    .collect::<Vec<_>>()
            };
            pool.install(|| threads::map(true, instances.len().div_ceil(CHUNK), of_chunk)).concat()
        } else {
            let is_changed = |id: &u32| changed.binary_search(id).is_ok();
            let come: Vec<u32> = changed.iter().copied().filter(|&id| is_emissive(id as usize)).collect();
            let stay: Vec<u32> = self.instances.iter().copied().filter(|id| !is_changed(id)).collect();
            if come.is_empty() && stay.len() == self.instances.len() {
                return None;
            }
            let mut now = [stay, come].concat();
            now.sort_unstable();
            now
        };
        if now.is_empty() && self.instances.is_empty() {
            return None;
        }
        Some(Self::of(now, None, shown))
    }

    /// The same emitters at a time of the open shutter.
    pub(super) fn at(&self, time: f32, shown: Shown) -> Self {
        Self::of(self.instances.clone(), Some(time), shown)
    }

    /// The same emitters after a renumbering of objects.
    pub(super) fn renumbered(&self, before: &SceneTree, now: &SceneTree) -> Self {
        let number = |&[leaf_id, geom_id, prim_id]: &[u32; 3]| {
            let (inst_id, leaf) = before.instance_at(leaf_id).expect("lamps are there");
            [now.first_leaf(inst_id) + leaf, geom_id, prim_id]
        };
        let ids = Arc::new(self.ids.iter().map(number).collect());
        Self { triangles: self.triangles.clone(), ids, instances: self.instances.clone() }
    }

    /// Whether some of them move while the shutter is open.
    pub(super) fn move_in(&self, instances: &SharedList<InstanceSlot>) -> bool {
        let placed = |&id: &u32| instances.get(id as usize).and_then(InstanceSlot::placed);
        let moves = |placed: &PlacedInstance| {
            placed.motion.is_some() || placed.object.bends || placed.object.members_move
        };
        self.triangles.is_some() && self.instances.iter().filter_map(placed).any(moves)
    }

    fn of(emissive: Vec<u32>, time: Option<f32>, shown: Shown) -> Self {
        let emitters: Vec<_> = shown.materials.emitters().flatten().cloned().collect();
        let mut found = Found::of(&emissive, time.unwrap_or(0.0), shown, &emitters);
        let mut shaders: Option<Arc<dyn shading::EmitterShaders>> = None;
        if found.glowing.iter().any(Option::is_some) {
            let slot = |instance_index: usize| shown.instances[emissive[instance_index] as usize].clone();
            let instances = SharedList::new(emissive.len(), false, slot);
            let Shown { face_normals, .. } = shown;
            let triangles = std::mem::take(&mut found.glowing);
            let mut shader_emission =
                ShaderEmission { triangles, instances, emitters: emitters.clone(), time, face_normals };
            let mut is_emissive =
                shown.pool.install(|| shader_emission.probe(&mut found.triangles)).into_iter();
            let mut stays = || is_emissive.next().unwrap_or(false);
            let all = found
                .triangles
                .into_iter()
                .zip(found.ids)
                .zip(std::mem::take(&mut shader_emission.triangles));
            let ((triangles, ids), glowing) = all.filter(|_| stays()).unzip();
            (found.triangles, found.ids, shader_emission.triangles) = (triangles, ids, glowing);
            shaders = Some(Arc::new(shader_emission));
        }
        match shading::ShapeLights::new(found.triangles, emitters, shaders) {
            Some(lights) => {
                Self { triangles: Some(Arc::new(lights)), ids: Arc::new(found.ids), instances: emissive }
            }
            None => Self { instances: emissive, ..Self::default() },
        }
    }
}

impl Found {
    fn of(emissive: &[u32], time: f32, shown: Shown, emitters: &[Arc<shading::Emitter>]) -> Self {
        // Positions among the emitters of those of each material.
        let mut next = 0;
        let range = |some: &[Arc<shading::Emitter>]| {
            let first = next;
            next += some.len();
            first..next
        };
        let ranges: Vec<Range<usize>> = shown.materials.emitters().map(range).collect();
        let of_instance = |instance_index: usize| {
            let inst_id = emissive[instance_index];
            let mut found = Vec::new();
            let Some(instance) = shown.instances[inst_id as usize].placed() else { return found };
            let first = shown.tree.first_leaf(inst_id);
            let whole = (0, &instance.at(time), time);
            each_lamp(&instance.object, whole, shown.materials, &mut |object, leaf, at| {
                for (geom_id, (mesh, keys)) in (0..).zip(object.meshes.iter().zip(&object.keys)) {
                    let range = ranges[mesh.material.index()].clone();
                    let mesh = (&**mesh, &**keys, time);
                    for prim_id in 0..mesh.0.indices.len() {
                        let prim = prim_id as u32;
                        let (ids, met) =
                            ([first + leaf, geom_id, prim], [instance_index as u32, leaf, geom_id, prim]);
                        let of_material = range.clone().map(|i| (i as u32, &*emitters[i]));
                        each_side(at, mesh, prim_id, of_material, |side, by_shader| {
                            let (emitter, is_turned) = (side.emitter, side.is_turned);
                            let queried =
                                by_shader.then_some(EmissionShape { met, inst_id, emitter, is_turned });
                            found.push((side, (ids, queried)));
                        });
                    }
                }
            });
            found
        };
        let of_chunk = |n: usize| {
            let end = ((n + 1) * TOGETHER).min(emissive.len());
            (n * TOGETHER..end).flat_map(of_instance).collect::<Vec<_>>()
        };
        let all = || threads::map(true, emissive.len().div_ceil(TOGETHER), of_chunk);
        let (triangles, (ids, glowing)) = shown.pool.install(all).into_iter().flatten().unzip();
        Self { triangles, ids, glowing }
    }
}

fn shows_emitters(object: &WorldObject, materials: &MaterialTable) -> bool {
    object.has_material(|material| materials.is_emissive(material))
}

/// Calls `visit` with all objects in one that have emissive triangles, with their transforms at a time, and
/// their numbers from `first` on.
fn each_lamp(
    object: &WorldObject,
    (first, instance_index, time): (u32, &Transform, f32),
    materials: &MaterialTable,
    visit: &mut dyn FnMut(&WorldObject, u32, &Transform),
) {
    if !shows_emitters(object, materials) {
        return;
    }
    let Some(members) = &object.members else { return visit(object, first, instance_index) };
    for (leaf, member, mask) in members.iter() {
        if mask.meets(RayMask::OTHER) {
            let instance_index = member.at(instance_index, time);
            each_lamp(&member.object, (first + leaf, &instance_index, time), materials, visit);
        }
    }
    visit(object, first + members.own_leaf(), instance_index);
}

/// Calls `with` with the sides of a triangle that may emit, in the world, and whether a shader computes their emission.
/// A material has one emitter, of its front or by a shader of both sides, or two, of its front and of its back.
fn each_side<'e>(
    at: &Transform,
    mesh: (&gnurt_scene::Mesh, &[Arc<gnurt_scene::Mesh>], f32),
    prim_id: usize,
    emitters: impl ExactSizeIterator<Item = (u32, &'e shading::Emitter)>,
    mut with: impl FnMut(shading::EmissiveShape, bool),
) {
    let has_both = emitters.len() == 2;
    for (side, of) in emitters.enumerate() {
        let Some(front) = triangle(at, mesh, prim_id, of) else { return };
        if of.1.shader().is_some() {
            with(front.clone(), true);
            with(turned(front), true);
        } else if !has_both || front.brightness > 0.0 {
            // One side of two may be dark.
            with(if side == 0 { front } else { turned(front) }, false);
        }
    }
}

/// A triangle in the world; `None` if it cannot be traced, because absent triangles emit nothing.
fn triangle(
    instance_index: &Transform,
    (mesh, keys, time): (&gnurt_scene::Mesh, &[Arc<gnurt_scene::Mesh>], f32),
    prim_id: usize,
    (emitter, of): (u32, &shading::Emitter),
) -> Option<shading::EmissiveShape> {
    let mut corners = mesh.indices[prim_id].map(|i| i as usize);
    if instance_index.mirrors {
        corners.swap(1, 2);
    }
    let interval = KeyInterval::of(time, keys.len());
    let position = |i: usize| {
        let at = |mesh: &gnurt_scene::Mesh| mesh.positions.get(i).copied();
        let p = match keys {
            [] => at(mesh)?,
            _ => interval.mix3(at(&keys[interval.key])?, at(&keys[interval.next])?),
        };
        Some(instance_index.point(p.into()))
    };
    let p = [position(corners[0])?, position(corners[1])?, position(corners[2])?];
    let area = (p[1] - p[0]).cross(p[2] - p[0]).length();
    if !(area > 0.0 && area.is_finite()) {
        return None;
    }
    let uv = corners.map(|i| mesh.texcoords.get(i).copied().unwrap_or_default());
    let opacity = corners.map(|i| mesh.colors.get(i).map_or(1.0, |color| color[3]));
    let brightness = of.mean_over(&uv, opacity);
    Some(shading::EmissiveShape { p, is_turned: instance_index.mirrors, uv, opacity, emitter, brightness })
}

/// The other side of a triangle.
fn turned(mut front: shading::EmissiveShape) -> shading::EmissiveShape {
    front.p.swap(1, 2);
    front.uv.swap(1, 2);
    front.opacity.swap(1, 2);
    shading::EmissiveShape { is_turned: !front.is_turned, ..front }
}
