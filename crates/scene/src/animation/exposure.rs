// SPDX-License-Identifier: GPL-3.0-or-later
//! Moving parts of a scene during an open shutter, sampled at several times. The times are those of the clip,
//! evenly spaced, so that a rotation follows its arc instead of its chord for any depth of the node tree. A
//! renderer interpolates between two samples on a line or an arc. A mesh keeps only as many samples as its
//! path needs, and the build holds no more than that. Space and units: those of the scene; seconds. Tests:
//! `tests/animation.rs`, `tests/growth.rs`.

use std::sync::Arc;

use super::clip::Clip;
use super::model::{Animation, MovingMember};
use crate::affine::Affine;
use crate::camera::Camera;
use crate::id::{CameraId, InstanceId, LightId, MeshId, ObjectId};
use crate::light::Light;
use crate::mesh::Mesh;
use crate::scene::Scene;

/// Moving parts during an open shutter, each with samples evenly spaced from its opening to its closing, both
/// included. The scene shows the first sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exposure {
    /// Deforming meshes; their vertices move in straight lines between samples, up to [`Exposure::BEND`].
    pub meshes: Vec<(MeshId, Vec<Arc<Mesh>>)>,
    /// Instances that are seen and moved.
    pub instances: Vec<(InstanceId, Vec<Affine>)>,
    /// Moving members of objects, by object and index among its members.
    pub members: Vec<((ObjectId, u32), Vec<Affine>)>,
    /// Cameras.
    pub cameras: Vec<(CameraId, Vec<Camera>)>,
    /// Lights without extent.
    pub lights: Vec<(LightId, Vec<Light>)>,
    /// Things that change without samples here, and stay as they are at the opening: driven materials, and
    /// instances that appear or disappear.
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

/// The state of all moving parts at one time, except meshes.
#[derive(Clone)]
struct Instant {
    instances: Vec<(Affine, bool)>,
    members: Vec<Option<Affine>>,
    cameras: Vec<Camera>,
    lights: Vec<Light>,
}

/// A mesh at the ends of equal pieces of the time, the fewest that determine it between them.
struct Bends {
    ends: Vec<Arc<Mesh>>,
    /// Ends of pieces of half the length, computed between the others.
    fresh: Vec<Arc<Mesh>>,
    /// How far a vertex may be from where it is.
    tolerance: f32,
    /// Whether all that was seen so far lies near enough.
    is_enough: bool,
    moves: bool,
}

impl Bends {
    fn new(first: Arc<Mesh>) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (k, &x) in first.positions.iter().flat_map(|p| p.iter().enumerate()) {
            (low[k], high[k]) = (low[k].min(x), high[k].max(x));
        }
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max);
        let tolerance = Exposure::BEND * size;
        Self { ends: vec![first], fresh: Vec::new(), tolerance, is_enough: false, moves: false }
    }

    /// Takes the ends of shorter pieces in between the others.
    fn refine(&mut self) {
        let mut fresh = std::mem::take(&mut self.fresh).into_iter();
        if self.ends.len() == 1 {
            self.ends.extend(fresh);
        } else {
            let before = std::mem::take(&mut self.ends);
            self.ends = before.into_iter().flat_map(|end| [Some(end), fresh.next()]).flatten().collect();
        }
        self.is_enough = true;
        let first = &self.ends[0];
        let differs = |mesh: &Arc<Mesh>| !Arc::ptr_eq(mesh, first) && mesh.positions != first.positions;
        self.moves |= self.ends.iter().any(differs);
    }

    /// Compares sample `i`, if pieces have `step` samples.
    fn compare(&mut self, mesh: &Mesh, i: usize, step: usize) {
        let (piece, share) = (i / step, (i % step) as f32 / step as f32);
        let ends = self.ends[piece].positions.iter().zip(&self.ends[piece + 1].positions);
        self.is_enough = mesh.positions.iter().zip(ends).all(|(is, (from, to))| {
            (0..3).all(|k| {
                let off = (is[k] - (1.0 - share) * from[k] - share * to[k]).abs();
                // Vertices that are not finite are in no tree either.
                off <= self.tolerance || off.is_nan()
            })
        });
        self.moves |= !self.is_enough || mesh.positions != self.ends[0].positions;
    }
}

/// The scene and the sampled times of a clip.
struct Shutter<'a> {
    scene: &'a mut Scene,
    animation: &'a Animation,
    clip: usize,
    opens: f64,
    closes: f64,
    pieces: usize,
    /// The samples so far.
    times: Vec<Option<Instant>>,
    /// The largest number of materials that change at one time.
    materials: usize,
}

impl Shutter<'_> {
    /// Poses the scene for a time, and keeps all moving parts except meshes.
    fn show(&mut self, i: usize) {
        let share = i as f64 / self.pieces as f64;
        let posed = self.scene.pose(self.clip, self.opens + (self.closes - self.opens) * share);
        self.materials = self.materials.max(posed.materials);
        if self.times[i].is_some() {
            return;
        }
        let scene = &*self.scene;
        let attachment = |id: InstanceId| (scene.instance(id).world_from_object, scene.instance(id).visible);
        let in_object = |moving: &MovingMember| {
            let member = scene.object(moving.object).members.get(moving.member as usize);
            member.map(|member| member.object_from_member)
        };
        let Animation { instances, members, cameras, lights, .. } = self.animation;
        self.times[i] = Some(Instant {
            instances: instances.iter().map(|moving| attachment(moving.instance)).collect(),
            members: members.iter().map(in_object).collect(),
            cameras: cameras.iter().map(|moving| scene.camera(moving.camera).clone()).collect(),
            lights: lights.iter().map(|moving| scene.light(moving.light).clone()).collect(),
        });
    }

    /// The mesh of a body as it is shown.
    fn mesh(&self, body: usize) -> &Arc<Mesh> {
        &self.scene.meshes()[self.animation.bodies[body].mesh.index()]
    }

    /// The deforming meshes, each at the fewest samples that determine the others. Those others are computed
    /// again for each tested length of pieces, so that no more meshes are held at once than are kept.
    fn bends(&mut self) -> Vec<Bends> {
        self.show(0);
        let mut all: Vec<Bends> =
            (0..self.animation.bodies.len()).map(|body| Bends::new(self.mesh(body).clone())).collect();
        let mut step = self.pieces;
        loop {
            let open: Vec<usize> = (0..all.len()).filter(|&body| !all[body].is_enough).collect();
            for i in (step..=self.pieces).step_by(if step == self.pieces { step } else { 2 * step }) {
                self.show(i);
                open.iter().for_each(|&body| all[body].fresh.push(self.mesh(body).clone()));
            }
            open.iter().for_each(|&body| all[body].refine());
            for i in (0..=self.pieces).filter(|i| i % step != 0) {
                let is_seen = self.times[i].is_some();
                if is_seen && !open.iter().any(|&body| all[body].is_enough) {
                    continue;
                }
                self.show(i);
                for &body in open.iter().filter(|&&body| all[body].is_enough).collect::<Vec<_>>() {
                    all[body].compare(self.mesh(body), i, step);
                }
            }
            if all.iter().all(|bends| bends.is_enough) {
                return all;
            }
            step /= 2;
        }
    }
}

impl Scene {
    /// Motion between two times of a clip, in seconds. The scene shows the first of them afterwards, as after
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
        let times = vec![None; pieces + 1];
        let mut shutter =
            Shutter { scene: self, animation: &animation, clip, opens, closes, pieces, times, materials: 0 };
        let bends = shutter.bends();
        let (materials, all) = (shutter.materials, shutter.times.into_iter().flatten().collect::<Vec<_>>());
        self.pose(clip, opens);
        let mut exposure = Exposure { held: materials, ..Exposure::default() };
        for (body, bends) in animation.bodies.iter().zip(bends).filter(|(_, bends)| bends.moves) {
            exposure.meshes.push((body.mesh, bends.ends));
        }
        for (i, moving) in animation.instances.iter().enumerate() {
            let (first, visible) = all[0].instances[i];
            exposure.held += usize::from(all.iter().any(|instant| instant.instances[i].1 != visible));
            if visible && all.iter().any(|instant| instant.instances[i].0 != first) {
                let transforms = all.iter().map(|instant| instant.instances[i].0).collect();
                exposure.instances.push((moving.instance, transforms));
            }
        }
        for (i, moving) in animation.members.iter().enumerate() {
            let transforms: Option<Vec<Affine>> = all.iter().map(|instant| instant.members[i]).collect();
            if let Some(transforms) = transforms
                .filter(|transforms| transforms.iter().any(|attachment| *attachment != transforms[0]))
            {
                exposure.members.push(((moving.object, moving.member), transforms));
            }
        }
        for (i, moving) in animation.cameras.iter().enumerate() {
            if all.iter().any(|instant| instant.cameras[i] != all[0].cameras[i]) {
                let cameras = all.iter().map(|instant| instant.cameras[i].clone()).collect();
                exposure.cameras.push((moving.camera, cameras));
            }
        }
        for (i, moving) in animation.lights.iter().enumerate() {
            if all.iter().any(|instant| instant.lights[i] != all[0].lights[i]) {
                let lights = all.iter().map(|instant| instant.lights[i].clone()).collect();
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
