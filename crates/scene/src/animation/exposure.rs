// SPDX-License-Identifier: GPL-3.0-or-later
//! What of a scene moves while a shutter is open: the same things at several moments.
//! Source: original. Moments are those of the clip itself, evenly spaced, so that a turn is followed and not its chord, whatever
//! nodes stand on each other; between two of them a renderer goes straight, or along an arc. Of a mesh only as many moments are
//! kept as its way needs. Space and units: those of the scene; seconds. Proof: `tests/animation.rs`.

use std::sync::Arc;

use super::clip::Clip;
use super::model::MovingMember;
use crate::affine::Affine;
use crate::camera::Camera;
use crate::id::{CameraId, InstanceId, LightId, MeshId, ObjectId};
use crate::light::Light;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Things that move while a shutter is open, each at moments evenly spaced from when it opens to when it closes, both ends
/// among them. What a scene shows is the first of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exposure {
    /// Meshes that bend; their vertices go straight from one moment to the next, up to [`Exposure::BEND`].
    pub meshes: Vec<(MeshId, Vec<Arc<Mesh>>)>,
    /// Instances that are seen and moved.
    pub instances: Vec<(InstanceId, Vec<Affine>)>,
    /// Members of objects, by object and place among its members, that are moved.
    pub members: Vec<((ObjectId, u32), Vec<Affine>)>,
    /// Cameras.
    pub cameras: Vec<(CameraId, Vec<Camera>)>,
    /// Lights without extent.
    pub lights: Vec<(LightId, Vec<Light>)>,
    /// Things whose change is not in here, and which stay as they are when the shutter opens: materials that are driven, and
    /// instances that come or go.
    pub held: usize,
}

/// Pieces of the time at least, and at most.
const PIECES: [usize; 2] = [16, 64];

/// Pieces for each key of a clip that lies in the time.
const PER_KEY: usize = 4;

impl Exposure {
    /// How far a mesh's vertex may be from where it is, in parts of the mesh's size.
    pub const BEND: f32 = 1.0 / 4096.0;

    /// Whether nothing moves.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.meshes.is_empty()
            && self.instances.is_empty()
            && self.members.is_empty()
            && self.cameras.is_empty()
            && self.lights.is_empty()
    }
}

/// What a moment shows of what can move.
struct Moment {
    meshes: Vec<Arc<Mesh>>,
    instances: Vec<(Affine, bool)>,
    members: Vec<Option<Affine>>,
    cameras: Vec<Camera>,
    lights: Vec<Light>,
}

impl Scene {
    /// What moves between two moments of a clip, in seconds. The scene shows the first of them afterwards, as after
    /// [`pose`](Self::pose). Nothing moves where the second is not after the first.
    ///
    /// Values that jump (STEP) go from one to the other within a piece of the time, of which there are 16 to 64.
    ///
    /// # Panics
    /// If there is no such clip in [`animation`](Self::animation).
    pub fn expose(&mut self, clip: usize, opens: f64, closes: f64) -> Exposure {
        self.pose(clip, opens);
        if closes.partial_cmp(&opens) != Some(std::cmp::Ordering::Greater) {
            return Exposure::default();
        }
        let animation = self.shared_animation().expect("the scene has an animation");
        let pieces = pieces(&animation.clips[clip], opens, closes);
        let mut materials = 0;
        let mut all: Vec<Moment> = Vec::with_capacity(pieces + 1);
        for i in 0..=pieces {
            let share = i as f64 / pieces as f64;
            let posed = self.pose(clip, opens + (closes - opens) * share);
            if i > 0 {
                materials = materials.max(posed.materials);
            }
            let place = |id: InstanceId| (self.instance(id).world_from_object, self.instance(id).visible);
            let in_object = |moving: &MovingMember| {
                let member = self.object(moving.object).members.get(moving.member as usize);
                member.map(|member| member.object_from_member)
            };
            all.push(Moment {
                meshes: animation
                    .bodies
                    .iter()
                    .map(|body| self.meshes()[body.mesh.index()].clone())
                    .collect(),
                instances: animation.instances.iter().map(|moving| place(moving.instance)).collect(),
                members: animation.members.iter().map(in_object).collect(),
                cameras: animation.cameras.iter().map(|moving| self.camera(moving.camera).clone()).collect(),
                lights: animation.lights.iter().map(|moving| self.light(moving.light).clone()).collect(),
            });
        }
        self.pose(clip, opens);
        let mut exposure = Exposure { held: materials, ..Exposure::default() };
        for (i, body) in animation.bodies.iter().enumerate() {
            let of: Vec<Arc<Mesh>> = all.iter().map(|moment| moment.meshes[i].clone()).collect();
            let first = &of[0];
            if of.iter().any(|mesh| !Arc::ptr_eq(mesh, first) && mesh.positions != first.positions) {
                exposure.meshes.push((body.mesh, thinned(of)));
            }
        }
        for (i, moving) in animation.instances.iter().enumerate() {
            let (first, visible) = all[0].instances[i];
            exposure.held += usize::from(all.iter().any(|moment| moment.instances[i].1 != visible));
            if visible && all.iter().any(|moment| moment.instances[i].0 != first) {
                let places = all.iter().map(|moment| moment.instances[i].0).collect();
                exposure.instances.push((moving.instance, places));
            }
        }
        for (i, moving) in animation.members.iter().enumerate() {
            let places: Option<Vec<Affine>> = all.iter().map(|moment| moment.members[i]).collect();
            if let Some(places) = places.filter(|places| places.iter().any(|place| *place != places[0])) {
                exposure.members.push(((moving.object, moving.member), places));
            }
        }
        for (i, moving) in animation.cameras.iter().enumerate() {
            if all.iter().any(|moment| moment.cameras[i] != all[0].cameras[i]) {
                let cameras = all.iter().map(|moment| moment.cameras[i].clone()).collect();
                exposure.cameras.push((moving.camera, cameras));
            }
        }
        for (i, moving) in animation.lights.iter().enumerate() {
            if all.iter().any(|moment| moment.lights[i] != all[0].lights[i]) {
                let lights = all.iter().map(|moment| moment.lights[i].clone()).collect();
                exposure.lights.push((moving.light, lights));
            }
        }
        exposure
    }
}

/// Into how many pieces a time is cut: a power of two.
fn pieces(clip: &Clip, opens: f64, closes: f64) -> usize {
    let within =
        |times: &[f32]| times.iter().filter(|&&t| f64::from(t) > opens && f64::from(t) < closes).count();
    let keys = clip.channels.iter().map(|channel| within(channel.sampler.times())).max().unwrap_or(0);
    let [least, most] = PIECES;
    (PER_KEY * (keys + 1)).next_power_of_two().clamp(least, most)
}

/// As few of the meshes, evenly spaced, as say where the others are.
fn thinned(all: Vec<Arc<Mesh>>) -> Vec<Arc<Mesh>> {
    let pieces = all.len() - 1;
    let mut step = pieces;
    while step > 1 && !is_enough(&all, step) {
        step /= 2;
    }
    all.into_iter().step_by(step).collect()
}

/// Whether every `step`th mesh says where the others are.
fn is_enough(all: &[Arc<Mesh>], step: usize) -> bool {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (k, &x) in all[0].positions.iter().flat_map(|p| p.iter().enumerate()) {
        (low[k], high[k]) = (low[k].min(x), high[k].max(x));
    }
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max);
    let bend = Exposure::BEND * size;
    (0..all.len()).filter(|i| i % step != 0).all(|i| {
        let (from, share) = (i / step * step, (i % step) as f32 / step as f32);
        let ends = all[from].positions.iter().zip(&all[from + step].positions);
        all[i].positions.iter().zip(ends).all(|(is, (from, to))| {
            (0..3).all(|k| {
                let off = (is[k] - (1.0 - share) * from[k] - share * to[k]).abs();
                // What is no number is in no tree either.
                off <= bend || off.is_nan()
            })
        })
    })
}
