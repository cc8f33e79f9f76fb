// SPDX-License-Identifier: GPL-3.0-or-later
//! Velocity of surface points during an open shutter, from moving vertices, members and instances.
//! The derivative of the position by time at fixed barycentric weights, by the product rule through all transforms
//! between object and world.
//! Space: world. Unit of time: the open shutter. At keys it is the velocity behind them.
//! Tests: crates/render/tests/velocity.rs.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};
use gnurt_accel::{KeyInterval, MotionPath};
use gnurt_scene::{Affine, Mesh};

use super::instance::PlacedInstance;
use super::transform::Transform;

/// Position and velocity.
type Moving = (DVec3, DVec3);

/// A moving point of an object in the space that holds it.
fn carried((p, v): Moving, rest: &Transform, motion: Option<&MotionPath>, time: f32) -> Moving {
    let at = |[x, y, z, origin]: [[f64; 3]; 4], p: DVec3, w: f64| {
        DMat3::from_cols(x.into(), y.into(), z.into()) * p + DVec3::from(origin) * w
    };
    // Where it is flat then, it stays: as for the position.
    let moves = |motion: &&MotionPath| Transform::new(&Affine { columns: motion.at(time) }).is_some();
    match motion.filter(moves) {
        Some(motion) => {
            (at(motion.at(time), p, 1.0), at(motion.at(time), v, 0.0) + at(motion.rate(time), p, 1.0))
        }
        None => {
            let linear = rest.linear.as_dmat3();
            (linear * p + rest.origin.as_dvec3(), linear * v)
        }
    }
}

impl PlacedInstance {
    /// The velocity in the world of a moving point of its object number `leaf`.
    fn velocity(&self, leaf: u32, time: f32, point: Moving) -> DVec3 {
        let mut levels = vec![(&self.transform, self.motion.as_deref())];
        let (mut object, mut leaf) = (&*self.object, leaf);
        while let Some((member, inner)) = object.member_at(leaf) {
            levels.push((&member.transform, member.motion.as_deref()));
            (object, leaf) = (&member.object, inner);
        }
        let inner_first = levels.into_iter().rev();
        inner_first.fold(point, |point, (rest, motion)| carried(point, rest, motion, time)).1
    }

    /// The velocity of the point with these barycentric coordinates of a triangle; of curves and spheres that of the
    /// point `p` of the world.
    pub(super) fn velocity_at(
        &self,
        leaf: u32,
        (geom_id, prim_id): (u32, u32),
        [u, v]: [f32; 2],
        p: Vec3,
        time: f32,
    ) -> Vec3 {
        let (object, geom_id) = (self.leaf(leaf).0, geom_id as usize);
        let mesh = &*object.meshes[geom_id];
        let point = match mesh.corners(prim_id as usize).filter(|_| mesh.has_triangles()) {
            Some(corners) => {
                let keys = object.keys.get(geom_id).map_or(&[][..], |keys| &keys[..]);
                let weights = [1.0 - f64::from(u) - f64::from(v), u.into(), v.into()];
                let sum = |sum: Moving, (&vertex, weight): (&usize, f64)| {
                    let (p, v) = vertex_at(mesh, keys, vertex, time);
                    (sum.0 + p * weight, sum.1 + v * weight)
                };
                corners.iter().zip(weights).fold((DVec3::ZERO, DVec3::ZERO), sum)
            }
            None => {
                let Transform { linear, origin, .. } = self.leaf_at(leaf, time);
                (linear.as_dmat3().inverse() * (p.as_dvec3() - origin.as_dvec3()), DVec3::ZERO)
            }
        };
        let velocity = self.velocity(leaf, time, point).as_vec3();
        if velocity.is_finite() { velocity } else { Vec3::ZERO }
    }
}

/// A vertex of a mesh at a time, by its keys if it deforms. Object space.
fn vertex_at(mesh: &Mesh, keys: &[Arc<Mesh>], vertex: usize, time: f32) -> Moving {
    let interval = KeyInterval::of(time, keys.len());
    let at = |key: usize| keys.get(key)?.positions.get(vertex).map(|&p| Vec3::from(p).as_dvec3());
    match (at(interval.key), at(interval.next)) {
        (Some(from), Some(to)) if interval.key != interval.next => {
            let [before, behind] = interval.weights.map(f64::from);
            (from * before + to * behind, (to - from) * (keys.len() - 1) as f64)
        }
        _ => (mesh.positions.get(vertex).map_or(DVec3::ZERO, |&p| Vec3::from(p).as_dvec3()), DVec3::ZERO),
    }
}
