// SPDX-License-Identifier: GPL-3.0-or-later
//! The island's trees in the wind: each leans away from it and swings about its foot, as gusts pass over the island.
//! A tree is a stiff rod on a spring, and a gust a wave that travels with the wind. Everything comes back after
//! [`SECONDS`], so that pictures can be shown in a loop. Space: +Y up. Tests: `tests/builtin.rs::trees_move_in_the_wind`.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::animation::{
    Animation, Attachment, Channel, Clip, Interpolation, Local, MovingInstance, Node, Sampler, Target, Trs,
};
use crate::builtin::noise::hash;
use crate::id::InstanceId;
use crate::scene::Scene;

/// After so long everything is where it was.
pub(super) const SECONDS: f32 = 4.0;

/// Keys of each tree, the last of which is the first one again.
const KEYS: usize = 25;

/// Where the wind blows to, in the plane of the ground: a unit vector along x and z.
const TO: [f64; 2] = [0.8, 0.6];

/// How far a broad-leaved tree leans, and how far it swings to either side, in radians; conifers are stiffer.
const LEAN: f64 = 0.06;
const SWING: f64 = 0.075;
const STIFF: f64 = 0.6;

/// Waves of gusts over one unit of the island, and a tree's own swings in one loop.
const WAVES: f64 = 0.35;
const OWN_SWINGS: f64 = 4.0;

/// A tree in the wind: its instance, its transform at rest, and whether it is a conifer.
pub(super) type Tree = (InstanceId, Trs, bool);

/// Makes the trees move.
pub(super) fn blow(scene: &mut Scene, trees: &[Tree]) {
    let times: Arc<[f32]> = (0..KEYS).map(|key| SECONDS * key as f32 / (KEYS - 1) as f32).collect();
    let mut animation = Animation::default();
    let mut clip = Clip { name: "wind".into(), ..Clip::default() };
    for (number, (instance, rest, is_conifer)) in (0..).zip(trees) {
        let rotations = (0..KEYS).flat_map(|key| {
            let share = key as f64 / (KEYS - 1) as f64;
            leaning(rest, *is_conifer, number, share).map(|x| x as f32)
        });
        let sampler = Sampler::new(times.clone(), rotations.collect(), 4, Interpolation::Linear);
        let Ok(sampler) = sampler else { continue };
        let node = animation.nodes.len() as u32;
        clip.channels.push(Channel { target: Target::Rotation(node), sampler: Arc::new(sampler) });
        animation.nodes.push(Node {
            name: scene.instance(*instance).name.clone(),
            parent: Attachment::Fixed { world_from_node: crate::affine::Affine::IDENTITY, visible: true },
            rest: Local::Parts(*rest),
            visible: true,
        });
        animation.instances.push(MovingInstance { instance: *instance, node, has_transform: true });
        scene.edit_instance(*instance).world_from_object = rest.affine();
    }
    animation.clips.push(clip);
    scene.animate(animation).unwrap_or_else(|error| panic!("{error}"));
}

/// The rotation of a tree at a fraction of the loop: leaning with the wind, on top of its rest pose.
fn leaning(rest: &Trs, is_conifer: bool, number: i32, share: f64) -> [f64; 4] {
    let random = |seed| f64::from(hash(number, 7, seed));
    let along = TO[0] * rest.translation[0] + TO[1] * rest.translation[2];
    let gust = (TAU * (share - WAVES * along)).sin();
    let own = (TAU * (OWN_SWINGS * share + random(21))).sin();
    let stiffness = if is_conifer { STIFF } else { 1.0 } * (0.8 + 0.4 * random(22));
    let angle = stiffness * (LEAN + SWING * (0.65 * gust + 0.35 * own * (0.6 + 0.4 * gust)));
    // About the axis in the ground across the wind.
    let (sin, cos) = (0.5 * angle).sin_cos();
    let lean = [sin * TO[1], 0.0, -sin * TO[0], cos];
    times(lean, rest.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]))
}

/// Rotation `b`, then `a`.
fn times([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4]) -> [f64; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}
