// SPDX-License-Identifier: GPL-3.0-or-later
//! The emissive shapes, triangles and spheres: all those of all instances together are one light.
//! Space: world. Spheres of instances that stretch them, and curves, are none: only scattered rays find their light.
//! They are searched for again only if an emissive instance moved, came or went, an emissive
//! object was changed, or a material's emission changed. Tests:
//! `crates/render/tests/{lights,commit,shader_emission}.rs`.

use std::ops::Range;
use std::sync::Arc;

use glam::{Mat3, Vec3};
use gnurt_accel::threads;
use gnurt_accel::{KeyInterval, SceneTree, SharedList};
use gnurt_scene::{Mesh, Primitives, RayMask};
use gnurt_shading::lights as shading;
use gnurt_shading::lights::Outline;

use super::instance::{InstanceSlot, PlacedInstance};
use super::material_table::MaterialTable;
use super::object::WorldObject;
use super::shader_emission::{EmissionShape, ShaderEmission};
use super::transform::Transform;

/// The input of the search for emissive shapes.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub(super) instances: &'a SharedList<InstanceSlot>,
    /// Which numbers their objects.
    pub(super) tree: &'a SceneTree,
    pub(super) materials: &'a MaterialTable,
    pub(super) face_normals: bool,
    pub(super) pool: &'a rayon::ThreadPool,
}

/// All emissive shapes.
#[derive(Default)]
pub(super) struct Emitters {
    pub(super) shapes: Option<Arc<shading::ShapeLights>>,
    /// Object (by its number in the tree over instances), mesh and primitive of each of them, ascending; twice
    /// if both sides of a triangle emit.
    pub(super) ids: Arc<Vec<[u32; 3]>>,
    /// Instances with an emissive mesh, ascending.
    pub(super) instances: Vec<u32>,
}

/// Shapes that may emit: leaf, mesh and primitive of each, and the data of those whose shaders are queried.
#[derive(Default)]
struct Found {
    shapes: Vec<shading::EmissiveShape>,
    ids: Vec<[u32; 3]>,
    glowing: Vec<Option<EmissionShape>>,
}

/// How far squared lengths in a sphere may differ.
const STRETCHED: f32 = 1e-4;

/// Instances that a thread asks at a time whether they emit.
const CHUNK: usize = 4096;

/// Emissive instances whose shapes a thread collects at a time.
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
        Self { shapes: self.shapes.clone(), ids, instances: self.instances.clone() }
    }

    /// Whether some of them move while the shutter is open.
    pub(super) fn move_in(&self, instances: &SharedList<InstanceSlot>) -> bool {
        let placed = |&id: &u32| instances.get(id as usize).and_then(InstanceSlot::placed);
        let moves = |placed: &PlacedInstance| {
            placed.motion.is_some() || placed.object.bends || placed.object.members_move
        };
        self.shapes.is_some() && self.instances.iter().filter_map(placed).any(moves)
    }

    fn of(emissive: Vec<u32>, time: Option<f32>, shown: Shown) -> Self {
        let emitters: Vec<_> = shown.materials.emitters().flatten().cloned().collect();
        let mut found = Found::of(&emissive, time.unwrap_or(0.0), shown, &emitters);
        let mut shaders: Option<Arc<dyn shading::EmitterShaders>> = None;
        if found.glowing.iter().any(Option::is_some) {
            let slot = |instance_index: usize| shown.instances[emissive[instance_index] as usize].clone();
            let instances = SharedList::new(emissive.len(), false, slot);
            let Shown { face_normals, .. } = shown;
            let shapes = std::mem::take(&mut found.glowing);
            let mut shader_emission =
                ShaderEmission { shapes, instances, emitters: emitters.clone(), time, face_normals };
            let mut is_emissive = shown.pool.install(|| shader_emission.probe(&mut found.shapes)).into_iter();
            let mut stays = || is_emissive.next().unwrap_or(false);
            let all =
                found.shapes.into_iter().zip(found.ids).zip(std::mem::take(&mut shader_emission.shapes));
            let ((shapes, ids), glowing) = all.filter(|_| stays()).unzip();
            (found.shapes, found.ids, shader_emission.shapes) = (shapes, ids, glowing);
            shaders = Some(Arc::new(shader_emission));
        }
        match shading::ShapeLights::new(found.shapes, emitters, shaders) {
            Some(lights) => {
                Self { shapes: Some(Arc::new(lights)), ids: Arc::new(found.ids), instances: emissive }
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
                    for prim_id in 0..mesh.0.primitive_count() {
                        let prim = prim_id as u32;
                        let (ids, met) =
                            ([first + leaf, geom_id, prim], [instance_index as u32, leaf, geom_id, prim]);
                        let of_material = range.clone().map(|i| (i as u32, &*emitters[i]));
                        each_side(at, mesh, prim_id, of_material, |side, by_shader| {
                            let (emitter, is_turned, outline) = (side.emitter, side.is_turned, side.outline);
                            let queried = by_shader.then_some(EmissionShape {
                                met,
                                inst_id,
                                emitter,
                                is_turned,
                                outline,
                            });
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
        let (shapes, (ids, glowing)) = shown.pool.install(all).into_iter().flatten().unzip();
        Self { shapes, ids, glowing }
    }
}

fn shows_emitters(object: &WorldObject, materials: &MaterialTable) -> bool {
    object.has_material(|material| materials.is_emissive(material))
}

/// Calls `visit` with all objects in one that have emissive shapes, with their transforms at a time, and
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

/// Calls `with` with the sides of a primitive that may emit, in the world, and whether a shader computes their emission.
/// A material has one emitter, of its front or by a shader of both sides, or two, of its front and of its back. Of spheres the
/// outside counts.
fn each_side<'e>(
    at: &Transform,
    mesh: Posed,
    prim_id: usize,
    emitters: impl ExactSizeIterator<Item = (u32, &'e shading::Emitter)>,
    mut with: impl FnMut(shading::EmissiveShape, bool),
) {
    let has_both = emitters.len() == 2;
    for (side, of) in emitters.enumerate() {
        let Some(front) = shape(at, mesh, prim_id, of) else { return };
        let back = turned(&front);
        if of.1.shader().is_some() {
            with(front, true);
            back.into_iter().for_each(|back| with(back, true));
        } else if !has_both || front.brightness > 0.0 {
            // One side of two may be dark.
            let emitting = if side == 0 { Some(front) } else { back };
            emitting.into_iter().for_each(|side| with(side, false));
        }
    }
}

/// A mesh, its keys, and a time.
type Posed<'a> = (&'a Mesh, &'a [Arc<Mesh>], f32);

/// A shape in the world; `None` if it cannot be traced, because absent shapes emit nothing.
fn shape(
    at: &Transform,
    posed: Posed,
    prim_id: usize,
    (emitter, of): (u32, &shading::Emitter),
) -> Option<shading::EmissiveShape> {
    let mesh = posed.0;
    let mut corners = mesh.corners(prim_id)?;
    let is_turned = at.mirrors && mesh.has_triangles();
    if is_turned {
        corners.swap(1, 2);
    }
    let outline = match &mesh.primitives {
        Primitives::Triangles => triangle(at, posed, corners)?,
        Primitives::Spheres(radii) => sphere(at, posed, (prim_id, *radii.get(prim_id)?))?,
        Primitives::Curves(_) => return None,
    };
    let uv = corners.map(|i| mesh.texcoords.get(i).copied().unwrap_or_default());
    let opacity = corners.map(|i| mesh.colors.get(i).map_or(1.0, |color| color[3]));
    let brightness = of.mean_over(&uv, opacity);
    Some(shading::EmissiveShape { outline, is_turned, uv, opacity, emitter, brightness, beam: None })
}

/// A vertex in the world.
fn vertex(at: &Transform, (mesh, keys, time): Posed, i: usize) -> Option<Vec3> {
    let interval = KeyInterval::of(time, keys.len());
    let of = |mesh: &Mesh| mesh.positions.get(i).copied();
    let p = match keys {
        [] => of(mesh)?,
        _ => interval.mix3(of(&keys[interval.key])?, of(&keys[interval.next])?),
    };
    Some(at.point(p.into()))
}

fn triangle(at: &Transform, mesh: Posed, corners: [usize; 3]) -> Option<Outline> {
    let p = [vertex(at, mesh, corners[0])?, vertex(at, mesh, corners[1])?, vertex(at, mesh, corners[2])?];
    let area = (p[1] - p[0]).cross(p[2] - p[0]).length();
    (area > 0.0 && area.is_finite()).then_some(Outline::Triangle(p))
}

/// `None` where the transform makes something else of it. Spheres have no keys.
fn sphere(at: &Transform, mesh: Posed, (prim_id, radius): (usize, f32)) -> Option<Outline> {
    let scale = at.linear.x_axis.length();
    let squares = at.linear.transpose() * at.linear * (1.0 / (scale * scale));
    let (center, radius) = (vertex(at, mesh, prim_id)?, radius * scale);
    let is_sphere = squares.abs_diff_eq(Mat3::IDENTITY, STRETCHED) && center.is_finite();
    (is_sphere && radius > 0.0 && radius.is_finite()).then_some(Outline::Sphere { center, radius })
}

/// The other side of a triangle.
fn turned(front: &shading::EmissiveShape) -> Option<shading::EmissiveShape> {
    let Outline::Triangle([a, b, c]) = front.outline else { return None };
    let ([uv_a, uv_b, uv_c], [opacity_a, opacity_b, opacity_c]) = (front.uv, front.opacity);
    Some(shading::EmissiveShape {
        outline: Outline::Triangle([a, c, b]),
        uv: [uv_a, uv_c, uv_b],
        opacity: [opacity_a, opacity_c, opacity_b],
        is_turned: !front.is_turned,
        ..front.clone()
    })
}
