// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras with a position and a frame: perspective, parallel, fisheye and panorama, each through a thin
//! lens.
//! Source: [CPC84] (thin lens); equidistant and equirectangular projections are those of cartography. Space: world.
//! A ray through the middle of the lens equals a pinhole's ray. All rays of one position in the picture meet
//! in one point: on the plane in focus, across the view, or for fisheyes and panoramas on the sphere in
//! focus, where the lens faces each ray.
//! Invariant: without a lens the rays do not depend on lens numbers. Tests: `tests`; `crates/render/tests/path.rs` measures the blur.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};

use crate::camera_projection::CameraProjection;
use crate::sampling::{Basis, concentric_disk};
use crate::shader::{CameraSamples, CameraShader};

/// A camera with a position and a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectiveCamera {
    /// The middle of the lens.
    pub eye: Vec3,
    /// Unit axes, perpendicular to each other: to the right of the picture, up in it, into it.
    pub right: Vec3,
    /// Up in the picture.
    pub up: Vec3,
    /// Into the picture.
    pub forward: Vec3,
    /// How it projects.
    pub projection: CameraProjection,
    /// Radius of the lens, world units; 0 = a pinhole.
    pub radius: f32,
    /// Distance of the focus, world units.
    pub focus: f32,
    /// From the view to the middle of the picture, to the right and up, in heights of the picture: of perspective and parallel
    /// projections.
    pub shift: [f32; 2],
}

impl ProjectiveCamera {
    /// From the view to the middle of the picture, as positions of [`straight`](Self::straight) are.
    fn aside(&self, aspect: f32) -> [f32; 2] {
        match self.projection {
            CameraProjection::Perspective { .. } | CameraProjection::Parallel { .. } => {
                [2.0 * self.shift[0] / aspect, 2.0 * self.shift[1]]
            }
            CameraProjection::Fisheye { .. } | CameraProjection::Panorama => [0.0; 2],
        }
    }

    /// The ray of a position in the picture, (-1, -1) = lower left corner, (1, 1) = upper right one, through
    /// the middle of the lens; and the distance of the focus on it. No direction outside of the image circle.
    fn straight(&self, [x, y]: [f32; 2], aspect: f32) -> (Ray, f32) {
        let dir_of = |dir: Vec3| Ray::new(self.eye.into(), dir.into());
        match self.projection {
            CameraProjection::Perspective { half_height } => {
                let dir = self.forward + self.right * (half_height * aspect) * x + self.up * half_height * y;
                (dir_of(dir.normalize()), self.focus * dir.length())
            }
            CameraProjection::Parallel { half_height } => {
                let origin = self.eye + self.right * (half_height * aspect) * x + self.up * half_height * y;
                (Ray::new(origin.into(), self.forward.into()), self.focus)
            }
            CameraProjection::Fisheye { half_angle } => {
                let (x, y) = (x * aspect, y);
                let distance = x.hypot(y);
                let angle = distance * half_angle;
                if angle > PI {
                    return (dir_of(Vec3::ZERO), self.focus);
                }
                let aside =
                    if distance > 0.0 { (self.right * x + self.up * y) / distance } else { Vec3::ZERO };
                let dir = self.forward * angle.cos() + aside * angle.sin();
                (dir_of(dir.normalize()), self.focus)
            }
            CameraProjection::Panorama => {
                let ((sin_x, cos_x), (sin_y, cos_y)) = ((x * PI).sin_cos(), (y * FRAC_PI_2).sin_cos());
                let dir = (self.forward * cos_x + self.right * sin_x) * cos_y + self.up * sin_y;
                (dir_of(dir.normalize()), self.focus)
            }
        }
    }

    /// The same ray through another point of the lens.
    fn through_lens(&self, ray: Ray, focus: f32, lens: [f32; 2]) -> Ray {
        let (origin, dir) = (Vec3::from(ray.org), Vec3::from(ray.dir));
        let [u, v] = (concentric_disk(lens) * self.radius).to_array();
        let aside = match self.projection {
            CameraProjection::Perspective { .. } | CameraProjection::Parallel { .. } => {
                self.right * u + self.up * v
            }
            CameraProjection::Fisheye { .. } | CameraProjection::Panorama => {
                let Basis { tangent, bitangent, .. } = Basis::around(dir);
                tangent * u + bitangent * v
            }
        };
        let towards = (dir * focus - aside).normalize_or_zero();
        Ray::new((origin + aside).into(), towards.into())
    }

    /// Rays of a pinhole's perspective, which are most of all: by whole arrays.
    fn pinhole(&self, half_height: f32, positions: &[[f32; 2]], aspect: f32, out: &mut RayBatch) {
        let (right, up) = (self.right * (half_height * aspect), self.up * half_height);
        let [across, above] = self.aside(aspect);
        let forward = self.forward + right * across + up * above;
        let first = out.len();
        let end = first + positions.len();
        let [dx, dy, dz] = &mut out.dir;
        [&mut *dx, &mut *dy, &mut *dz].into_iter().for_each(|array| array.resize(end, 0.0));
        let dirs = dx[first..].iter_mut().zip(&mut dy[first..]).zip(&mut dz[first..]);
        for (((dx, dy), dz), [x, y]) in dirs.zip(positions) {
            let dir = forward + right * (2.0 * x - 1.0) + up * (2.0 * y - 1.0);
            [*dx, *dy, *dz] = dir.normalize().into();
        }
        out.org.iter_mut().zip(self.eye.to_array()).for_each(|(array, x)| array.resize(end, x));
        out.t_near.resize(end, 0.0);
        out.t_far.resize(end, f32::INFINITY);
        if !out.mask.is_empty() {
            out.mask.resize(end, u32::MAX);
        }
    }
}

impl CameraShader for ProjectiveCamera {
    fn projection(&self) -> Option<CameraProjection> {
        Some(self.projection)
    }

    fn project(&self, p: Vec3, aspect: f32) -> Option<[f32; 2]> {
        let offset = p - self.eye;
        let [x, y, z] = [self.right, self.up, self.forward].map(|axis| offset.dot(axis));
        let project = match self.projection {
            CameraProjection::Perspective { half_height } => {
                // Nothing shows that lies behind.
                if z <= 0.0 {
                    return None;
                }
                [x / (z * half_height * aspect), y / (z * half_height)]
            }
            CameraProjection::Parallel { half_height } => [x / (half_height * aspect), y / half_height],
            CameraProjection::Fisheye { half_angle } => {
                let aside = x.hypot(y);
                let scale = if aside > 0.0 { aside.atan2(z) / (half_angle * aside) } else { 0.0 };
                [x * scale / aspect, y * scale]
            }
            CameraProjection::Panorama => [x.atan2(z) / PI, (y / offset.length()).asin() / FRAC_PI_2],
        };
        let aside = self.aside(aspect);
        let shown = [0, 1].map(|k| 0.5 + 0.5 * (project[k] - aside[k]));
        shown.iter().all(|x| x.is_finite()).then_some(shown)
    }

    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        if let CameraProjection::Perspective { half_height } = self.projection
            && !self.has_lens()
        {
            return self.pinhole(half_height, samples.positions, aspect, out);
        }
        let [across, above] = self.aside(aspect);
        for (i, project) in samples.positions.iter().enumerate() {
            let [x, y] = project.map(|x| 2.0 * x - 1.0);
            let (ray, focus) = self.straight([x + across, y + above], aspect);
            let is_visible = ray.dir != [0.0; 3];
            let bent = self.has_lens() && is_visible;
            out.push(if bent { self.through_lens(ray, focus, samples.lens(i)) } else { ray });
        }
    }

    fn has_lens(&self) -> bool {
        self.radius > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: CameraProjection, radius: f32) -> ProjectiveCamera {
        let (eye, focus) = (Vec3::new(1.0, 2.0, 3.0), 4.0);
        let (right, up, forward) = (Vec3::X, Vec3::Y, Vec3::NEG_Z);
        ProjectiveCamera { eye, right, up, forward, projection, radius, focus, shift: [0.0; 2] }
    }

    const PROJECTIONS: [CameraProjection; 4] = [
        CameraProjection::Perspective { half_height: 0.7 },
        CameraProjection::Parallel { half_height: 1.5 },
        CameraProjection::Fisheye { half_angle: 1.9 },
        CameraProjection::Panorama,
    ];

    fn rays(camera: &ProjectiveCamera, positions: &[[f32; 2]], lens: &[[f32; 2]], aspect: f32) -> Vec<Ray> {
        let mut out = RayBatch::default();
        camera.rays(&CameraSamples { positions, lens, times: &[] }, aspect, &mut out);
        (0..out.len()).map(|i| out.get(i)).collect()
    }

    /// Closed forms of the edges.
    #[test]
    fn places_are_directions() {
        let found = |projection, project: [f32; 2], aspect: f32| {
            let ray = rays(&camera(projection, 0.0), &[project], &[], aspect)[0];
            (Vec3::from(ray.org) - Vec3::new(1.0, 2.0, 3.0), Vec3::from(ray.dir))
        };
        let near = |a: Vec3, b: Vec3| (a - b).length() < 1e-5;
        let (origin, dir) = found(CameraProjection::Parallel { half_height: 1.5 }, [1.0, 0.0], 2.0);
        assert!(near(origin, Vec3::new(3.0, -1.5, 0.0)) && near(dir, Vec3::NEG_Z), "{origin} {dir}");
        let half_sphere = CameraProjection::Fisheye { half_angle: FRAC_PI_2 };
        assert!(near(found(half_sphere, [0.5, 1.0], 1.0).1, Vec3::Y), "straight up at the upper edge");
        assert!(near(found(half_sphere, [0.5, 0.5], 1.0).1, Vec3::NEG_Z), "ahead in the middle");
        assert!(near(found(half_sphere, [1.0, 0.5], 2.0).1, Vec3::Z), "behind, where it is twice as wide");
        assert_eq!(
            found(CameraProjection::Fisheye { half_angle: PI }, [0.0, 0.0], 1.0).1,
            Vec3::ZERO,
            "beyond behind"
        );
        for (project, expected) in [
            ([0.5, 0.5], Vec3::NEG_Z),
            ([0.75, 0.5], Vec3::X),
            ([0.25, 0.5], Vec3::NEG_X),
            ([0.0, 0.5], Vec3::Z),
            ([0.3, 1.0], Vec3::Y),
            ([0.3, 0.0], Vec3::NEG_Y),
        ] {
            let dir = found(CameraProjection::Panorama, project, 2.0).1;
            assert!(near(dir, expected), "{project:?} of a panorama looks along {dir}");
        }
    }

    /// A point on a ray projects back to the ray's position.
    #[test]
    fn points_show_where_their_rays_are() {
        for projection in PROJECTIONS {
            for project in [[0.5, 0.5], [0.2, 0.9], [0.97, 0.4], [0.01, 0.02]] {
                let camera = camera(projection, 0.0);
                let ray = rays(&camera, &[project], &[], 1.25)[0];
                let p = Vec3::from(ray.org) + 3.5 * Vec3::from(ray.dir);
                let [x, y] = camera.project(p, 1.25).expect("it is seen");
                let off = (x - project[0]).hypot(y - project[1]);
                assert!(off < 1e-5, "{projection:?}: {project:?} shows at {x}, {y}");
            }
        }
        let behind = camera(PROJECTIONS[0], 0.0).project(Vec3::new(1.0, 2.0, 4.0), 1.0);
        assert_eq!(behind, None, "perspectives show nothing that lies behind");
    }

    /// All rays of a position meet where the pinhole's ray is in focus, begin within the lens, and fill it.
    #[test]
    fn rays_of_a_place_meet_in_focus() {
        let lens: Vec<[f32; 2]> =
            (0..256).map(|i| [(i % 16) as f32 / 16.0 + 0.03, (i / 16) as f32 / 16.0 + 0.03]).collect();
        for projection in PROJECTIONS {
            for project in [[0.5, 0.5], [0.2, 0.9], [0.97, 0.4]] {
                let sharp = rays(&camera(projection, 0.0), &[project], &[], 1.25)[0];
                let (origin, dir) = (Vec3::from(sharp.org), Vec3::from(sharp.dir));
                let focus = match projection {
                    CameraProjection::Perspective { .. } => 4.0 / -dir.z,
                    _ => 4.0,
                };
                let intersection = origin + dir * focus;
                let bent = rays(&camera(projection, 0.5), &vec![project; lens.len()], &lens, 1.25);
                let mut widest = 0.0_f32;
                for ray in &bent {
                    let (from, along) = (Vec3::from(ray.org), Vec3::from(ray.dir));
                    assert!((along.length() - 1.0).abs() < 1e-5, "{projection:?}: unit");
                    let miss = (intersection - from).cross(along).length();
                    assert!(miss < 1e-5, "{projection:?} {project:?}: misses its focus by {miss}");
                    widest = widest.max(from.distance(origin));
                }
                assert!((0.45..0.50001).contains(&widest), "{projection:?}: the lens is {widest} wide");
                let middle = rays(&camera(projection, 0.5), &[project], &[], 1.25)[0];
                assert!(
                    Vec3::from(middle.dir).distance(dir) < 1e-6,
                    "{projection:?}: its middle is a pinhole"
                );
            }
        }
    }

    /// A shifted picture is another part of the same image.
    #[test]
    fn shifts_show_another_part() {
        for (projection, radius) in [(PROJECTIONS[0], 0.0), (PROJECTIONS[0], 0.5), (PROJECTIONS[1], 0.0)] {
            let plain = camera(projection, radius);
            let shifted = ProjectiveCamera { shift: [0.5, -0.25], ..plain };
            for [x, y] in [[0.5, 0.5], [0.2, 0.9], [1.0, 0.0]] {
                let found = rays(&shifted, &[[x, y]], &[], 1.25)[0];
                let expected = rays(&plain, &[[x + 0.5 / 1.25, y - 0.25]], &[], 1.25)[0];
                let off = Vec3::from(found.dir).distance(expected.dir.into());
                let aside = Vec3::from(found.org).distance(expected.org.into());
                assert!(off.max(aside) < 1e-5, "{projection:?}: {found:?}, not {expected:?}");
                let p = Vec3::from(found.org) + 3.5 * Vec3::from(found.dir);
                let [u, v] = shifted.project(p, 1.25).expect("it is seen");
                assert!((u - x).hypot(v - y) < 1e-5, "{projection:?}: {x}, {y} shows at {u}, {v}");
            }
        }
    }

    #[test]
    fn a_pinholes_arrays_are_its_rays() {
        let camera = camera(PROJECTIONS[0], 0.0);
        for (i, ray) in rays(&camera, &[[0.1, 0.8], [0.6, 0.3]], &[], 1.6).into_iter().enumerate() {
            let (same, _) = camera.straight([[-0.8, 0.6], [0.2, -0.4]][i], 1.6);
            assert!(Vec3::from(ray.dir).distance(same.dir.into()) < 1e-6 && ray.org == same.org, "ray {i}");
        }
    }
}
