// SPDX-License-Identifier: GPL-3.0-or-later
//! How a ray along a chain of smooth surfaces changes with its first direction.
//! Source: [Ige99] section 3 (transfer, reflection, refraction). Space: world; both changes are per radian of the first
//! direction along an axis of its frame. Tests: `tests`.

use glam::Vec3;

use crate::world::Bend;

/// Changes of a ray's origin and direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Differential {
    pub(super) org: [Vec3; 2],
    pub(super) dir: [Vec3; 2],
}

impl Differential {
    /// Of rays from one point in directions around the normal to this frame.
    pub(super) fn from_point(frame: [Vec3; 2]) -> Self {
        Self { org: [Vec3::ZERO; 2], dir: frame }
    }

    /// Goes on by `t` along `dir` to a surface with the unit normal `ng`: origins are then on the surface.
    pub(super) fn transfer(&mut self, t: f32, dir: Vec3, ng: Vec3) {
        let along = dir.dot(ng);
        for (org, d) in self.org.iter_mut().zip(self.dir) {
            let moved = *org + d * t;
            *org = moved - dir * (moved.dot(ng) / along);
        }
    }

    /// Mirrors rays along `dir` at a surface whose shading normal is `ns`, and lifts their origins.
    pub(super) fn mirror(&mut self, dir: Vec3, ns: Vec3, bend: &Bend) {
        let along = dir.dot(ns);
        for (org, d) in self.org.iter_mut().zip(&mut self.dir) {
            let turn = bend.normal * *org;
            *d -= 2.0 * ((d.dot(ns) + dir.dot(turn)) * ns + along * turn);
            *org += bend.lift * *org;
        }
    }

    /// Refracts rays along `dir` at a surface whose shading normal against them is `ns`; `eta`: the index before over that behind.
    pub(super) fn refract(&mut self, dir: Vec3, ns: Vec3, eta: f32, bend: &Bend) {
        let before = -dir.dot(ns);
        let behind = (1.0 - eta * eta * (1.0 - before * before)).max(0.0).sqrt();
        let along = eta * before - behind;
        for (org, d) in self.org.iter().zip(&mut self.dir) {
            let turn = bend.normal * *org;
            let change = -(d.dot(ns) + dir.dot(turn)) * (eta - eta * eta * before / behind);
            *d = *d * eta + ns * change + turn * along;
        }
    }
}

/// Where a ray along `dir` is mirrored to.
pub(super) fn mirrored(dir: Vec3, ns: Vec3) -> Vec3 {
    dir - ns * (2.0 * dir.dot(ns))
}

/// Where it is refracted to; `None` if it is not.
pub(super) fn refracted(dir: Vec3, ns: Vec3, eta: f32) -> Option<Vec3> {
    let before = -dir.dot(ns);
    let square = 1.0 - eta * eta * (1.0 - before * before);
    (before > 0.0 && square > 0.0).then(|| dir * eta + ns * (eta * before - square.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat3;

    /// Rays from a point to a ball: the derivatives are differences of rays side by side.
    #[test]
    fn derivatives_are_those_of_rays_side_by_side() {
        let (from, center, radius) = (Vec3::new(0.3, -3.0, 0.4), Vec3::new(0.1, 0.2, 0.0), 1.2_f32);
        let meet = |dir: Vec3| {
            let (o, d) = ((from - center).as_dvec3(), dir.as_dvec3());
            let half = o.dot(d);
            let t = -half - (half * half - o.length_squared() + f64::from(radius * radius)).sqrt();
            let p = from.as_dvec3() + d * t;
            (p.as_vec3(), ((p - center.as_dvec3()) / f64::from(radius)).as_vec3(), t as f32)
        };
        let dir = Vec3::new(-0.05, 1.0, -0.1).normalize();
        let frame: [Vec3; 2] = dir.any_orthonormal_pair().into();
        for refracts in [false, true] {
            let follow = |dir: Vec3| {
                let (p, n, _) = meet(dir);
                (
                    p,
                    if refracts {
                        refracted(dir, n, 1.0 / 1.5).expect("it enters")
                    } else {
                        mirrored(dir, n)
                    },
                )
            };
            let (_, n, t) = meet(dir);
            let turn = (Mat3::IDENTITY - Mat3::from_cols(n * n.x, n * n.y, n * n.z)) * (1.0 / radius);
            let bend = Bend { normal: turn, lift: Mat3::ZERO };
            let mut found = Differential::from_point(frame);
            found.transfer(t, dir, n);
            match refracts {
                true => found.refract(dir, n, 1.0 / 1.5, &bend),
                false => found.mirror(dir, n, &bend),
            }
            let h = 1e-2;
            for (k, &axis) in frame.iter().enumerate() {
                let side = |by: f32| follow((dir + axis * by).normalize());
                let ((p1, d1), (p0, d0)) = (side(h), side(-h));
                let (dp, dd) = ((p1 - p0) / (2.0 * h), (d1 - d0) / (2.0 * h));
                assert!((dp - found.org[k]).length() < 5e-3 * dp.length(), "{dp} {}", found.org[k]);
                assert!((dd - found.dir[k]).length() < 5e-3 * dd.length().max(1.0), "{dd} {}", found.dir[k]);
            }
        }
    }
}
