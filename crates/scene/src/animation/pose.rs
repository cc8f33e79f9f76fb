// SPDX-License-Identifier: GPL-3.0-or-later
//! Poses: a scene at one time. Only differences are edited, so that the log lists exactly the work of the
//! next commit. Two poses at the same time are equal, whatever was shown between them. Tests:
//! `tests/animation.rs`.

use std::sync::Arc;

use super::body::Body;
use super::instant::{Instant, NodePose, at};
use super::model::{Animation, camera_at};
use super::playback::{Playback, Shown};
use crate::check::CheckError;
use crate::scene::Scene;

/// The changes of a scene by a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Posed {
    /// Meshes that were bent.
    pub meshes: usize,
    /// Instances that were moved, shown or hidden.
    pub instances: usize,
    /// Members of objects that were moved.
    pub members: usize,
    /// Cameras.
    pub cameras: usize,
    /// Lights.
    pub lights: usize,
    /// Materials.
    pub materials: usize,
}

impl Scene {
    /// Gives the scene its animation, in place of an earlier one. The current state is taken as the rest
    /// pose.
    ///
    /// # Errors
    /// [`CheckError`] if an index of the animation is out of range, or if lengths of arrays disagree.
    pub fn animate(&mut self, animation: Animation) -> Result<(), CheckError> {
        super::check::check(&animation, self)?;
        self.set_animation(animation);
        Ok(())
    }

    /// Shows the time `seconds` of a clip; the pose is constant before its first and after its last keys.
    /// Values without a channel are at rest. Edits only the differences from the current pose, so that a
    /// commit does no more work than that.
    ///
    /// ```
    /// # use gnurt_scene::Scene;
    /// # let mut scene = Scene::new();
    /// # scene.animate(gnurt_scene::animation::Animation { clips: vec![Default::default()], ..Default::default() }).unwrap();
    /// let posed = scene.pose(0, 1.5);
    /// println!("{} meshes bent, {} instances moved", posed.meshes, posed.instances);
    /// ```
    ///
    /// # Panics
    /// If there is no such clip in [`animation`](Self::animation).
    pub fn pose(&mut self, clip: usize, seconds: f64) -> Posed {
        let animation = self.shared_animation().expect("the scene has an animation");
        let mut instant = Instant::rest(&animation);
        instant.play(&animation.clips[clip], seconds);
        self.show(&animation, &instant)
    }

    /// Shows everything at rest, as no clip drives it. Nothing happens without an animation.
    pub fn rest(&mut self) -> Posed {
        let Some(animation) = self.shared_animation() else { return Posed::default() };
        let instant = Instant::rest(&animation);
        self.show(&animation, &instant)
    }

    fn show(&mut self, animation: &Animation, instant: &Instant) -> Posed {
        let mut playback = std::mem::take(self.playback());
        if !playback.is_begun {
            playback = begin(self, animation);
        }
        let node_poses = instant.node_poses(animation);
        let posed = Posed {
            meshes: show_bodies(self, animation, instant, &node_poses, &mut playback),
            instances: show_instances(self, animation, &node_poses, &mut playback),
            members: show_members(self, animation, &node_poses),
            cameras: show_cameras(self, animation, instant, &node_poses, &playback),
            lights: show_lights(self, animation, instant, &node_poses, &playback),
            materials: show_materials(self, animation, instant, &mut playback),
        };
        *self.playback() = playback;
        posed
    }
}

/// The state before the first pose.
fn begin(scene: &Scene, animation: &Animation) -> Playback {
    Playback {
        is_begun: true,
        bodies: vec![Shown::default(); animation.bodies.len()],
        visible: animation.instances.iter().map(|i| scene.instance(i.instance).visible).collect(),
        cameras: animation.cameras.iter().map(|c| scene.camera(c.camera).clone()).collect(),
        lights: animation.lights.iter().map(|l| scene.light(l.light).clone()).collect(),
        materials: animation.materials.iter().map(|m| m.factors.material()).collect(),
    }
}

fn show_bodies(
    scene: &mut Scene,
    animation: &Animation,
    instant: &Instant,
    node_poses: &[NodePose],
    playback: &mut Playback,
) -> usize {
    let mut count = 0;
    for (i, (body, shown)) in animation.bodies.iter().zip(&mut playback.bodies).enumerate() {
        let bend = instant.bend(animation, i, node_poses);
        if shown.bend.as_ref() == Some(&bend) {
            continue;
        }
        let material = scene.mesh(body.mesh).material;
        let mut mesh = shown.spare.take().unwrap_or_else(|| body.base.clone());
        // Other holders of the mesh keep it unchanged.
        let to = Arc::make_mut(&mut mesh);
        body.bend(&bend, to);
        to.material = material;
        shown.spare = Some(scene.meshes()[body.mesh.index()].clone()).filter(|mesh| is_of(mesh, body));
        scene.replace_mesh(body.mesh, mesh);
        shown.bend = Some(bend);
        count += 1;
    }
    count
}

/// Whether a mesh has the arrays of a body, so that it can show it again. One from a file may lack triangles that had no area at rest.
fn is_of(mesh: &crate::mesh::Mesh, body: &Body) -> bool {
    mesh.positions.len() == body.base.positions.len() && mesh.indices == body.base.indices
}

fn show_instances(
    scene: &mut Scene,
    animation: &Animation,
    node_poses: &[NodePose],
    playback: &mut Playback,
) -> usize {
    let mut count = 0;
    for (moving, was_visible) in animation.instances.iter().zip(&mut playback.visible) {
        let node = node_poses[moving.node as usize];
        let instance = scene.instance(moving.instance);
        let moves = moving.has_transform && instance.world_from_object != node.world_from_node;
        // The caller may have hidden it.
        let appears = *was_visible != node.visible;
        if !moves && !appears {
            continue;
        }
        let instance = scene.edit_instance(moving.instance);
        if moves {
            instance.world_from_object = node.world_from_node;
        }
        if appears {
            instance.visible = node.visible;
            *was_visible = node.visible;
        }
        count += 1;
    }
    count
}

fn show_members(scene: &mut Scene, animation: &Animation, node_poses: &[NodePose]) -> usize {
    let mut count = 0;
    for moving in &animation.members {
        let attachment = node_poses[moving.node as usize].world_from_node;
        // The caller may have removed it.
        let member = scene.object(moving.object).members.get(moving.member as usize);
        if member.is_some_and(|member| member.object_from_member != attachment) {
            scene.edit_object(moving.object).members[moving.member as usize].object_from_member = attachment;
            count += 1;
        }
    }
    count
}

fn show_cameras(
    scene: &mut Scene,
    animation: &Animation,
    instant: &Instant,
    node_poses: &[NodePose],
    playback: &Playback,
) -> usize {
    let mut count = 0;
    for (moving, rest) in animation.cameras.iter().zip(&playback.cameras) {
        let angle = instant.fields_of_view[moving.field_of_view as usize];
        let node = at(&moving.attachment, node_poses);
        // A camera without a valid view stays at rest.
        let camera = camera_at(rest, &node.world_from_node, angle).unwrap_or_else(|| rest.clone());
        if *scene.camera(moving.camera) != camera {
            *scene.edit_camera(moving.camera) = camera;
            count += 1;
        }
    }
    count
}

fn show_lights(
    scene: &mut Scene,
    animation: &Animation,
    instant: &Instant,
    node_poses: &[NodePose],
    playback: &Playback,
) -> usize {
    let mut count = 0;
    for (moving, rest) in animation.lights.iter().zip(&playback.lights) {
        let node = at(&moving.attachment, node_poses);
        let light = instant.lights[moving.factors as usize].light(&node.world_from_node, node.visible);
        let light = light.unwrap_or_else(|| rest.clone());
        if *scene.light(moving.light) != light {
            *scene.edit_light(moving.light) = light;
            count += 1;
        }
    }
    count
}

fn show_materials(
    scene: &mut Scene,
    animation: &Animation,
    instant: &Instant,
    playback: &mut Playback,
) -> usize {
    let mut count = 0;
    let shown = animation.materials.iter().zip(&mut playback.materials).zip(&instant.materials);
    for ((moving, was), factors) in shown {
        let material = factors.material();
        // A material that the caller assigned stays.
        if material == *was || *scene.material(moving.material) != *was {
            continue;
        }
        *scene.edit_material(moving.material) = material.clone();
        *was = material;
        count += 1;
    }
    count
}
