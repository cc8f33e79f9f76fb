// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras that stand somewhere and look along a frame: perspective, parallel, fisheye and panorama, each through a thin lens.
//! Source: [CPC84] (thin lens); equidistant and equirectangular projections are those of cartography. Space: world.
//! A ray through the middle of the lens goes where a pinhole's goes; all rays of one place in the picture meet in one point: on the plane
//! in focus, across the view, or for fisheyes and panoramas on the sphere in focus, the lens facing each ray.
//! Invariant: without a lens the rays do not depend on lens numbers. Tests: `tests`; `crates/render/tests/path.rs` measures the blur.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};

use crate::sampling::{Basis, concentric_disk};
use crate::shader::{CameraSamples, CameraShader};

/// How directions become places in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// A perspective.
    Perspective {
        /// Half the picture's height at distance 1.
        half_height: f32,
    },
    /// Parallel rays that begin in the plane of the eye.
    Parallel {
        /// Half the height of what the picture shows, world units.
        half_height: f32,
    },
    /// Angles to the view are distances from the picture's middle.
    Fisheye {
        /// Angle at the middle of the upper edge, radians.
        half_angle: f32,
    },
    /// Longitudes across, latitudes upwards.
    Panorama,
}

/// A camera that stands somewhere and looks along a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookCamera {
    /// The middle of the lens.
    pub eye: Vec3,
    /// Unit axes, perpendicular to each other: to the right of the picture, up in it, into it.
    pub right: Vec3,
    /// Up in the picture.
    pub up: Vec3,
    /// Into the picture.
    pub forward: Vec3,
    /// How it projects.
    pub look: Look,
    /// Radius of the lens, world units; 0 = a pinhole.
    pub radius: f32,
    /// Distance of what is in focus, world units.
    pub focus: f32,
}

impl LookCamera {
    /// The ray of a place in the picture, (-1, -1) = lower left corner, (1, 1) = upper right one, through the middle of the lens; and the
    /// distance of what is in focus on it. No direction where nothing is seen.
    fn straight(&self, [x, y]: [f32; 2], aspect: f32) -> (Ray, f32) {
        let dir_of = |dir: Vec3| Ray::new(self.eye.into(), dir.into());
        match self.look {
            Look::Perspective { half_height } => {
                let dir = self.forward + self.right * (half_height * aspect) * x + self.up * half_height * y;
                (dir_of(dir.normalize()), self.focus * dir.length())
            }
            Look::Parallel { half_height } => {
                let origin = self.eye + self.right * (half_height * aspect) * x + self.up * half_height * y;
                (Ray::new(origin.into(), self.forward.into()), self.focus)
            }
            Look::Fisheye { half_angle } => {
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
            Look::Panorama => {
                let ((sin_x, cos_x), (sin_y, cos_y)) = ((x * PI).sin_cos(), (y * FRAC_PI_2).sin_cos());
                let dir = (self.forward * cos_x + self.right * sin_x) * cos_y + self.up * sin_y;
                (dir_of(dir.normalize()), self.focus)
            }
        }
    }

    /// The same ray through another place of the lens.
    fn through_lens(&self, ray: Ray, focus: f32, lens: [f32; 2]) -> Ray {
        let (origin, dir) = (Vec3::from(ray.org), Vec3::from(ray.dir));
        let [u, v] = (concentric_disk(lens) * self.radius).to_array();
        let aside = match self.look {
            Look::Perspective { .. } | Look::Parallel { .. } => self.right * u + self.up * v,
            Look::Fisheye { .. } | Look::Panorama => {
                let Basis { tangent, bitangent, .. } = Basis::around(dir);
                tangent * u + bitangent * v
            }
        };
        let towards = (dir * focus - aside).normalize_or_zero();
        Ray::new((origin + aside).into(), towards.into())
    }

    /// Rays of a pinhole's perspective, which are most of all: by whole arrays.
    fn pinhole(&self, half_height: f32, places: &[[f32; 2]], aspect: f32, out: &mut RayBatch) {
        let (right, up) = (self.right * (half_height * aspect), self.up * half_height);
        let first = out.len();
        let end = first + places.len();
        let [dx, dy, dz] = &mut out.dir;
        [&mut *dx, &mut *dy, &mut *dz].into_iter().for_each(|array| array.resize(end, 0.0));
        let dirs = dx[first..].iter_mut().zip(&mut dy[first..]).zip(&mut dz[first..]);
        for (((dx, dy), dz), [x, y]) in dirs.zip(places) {
            let dir = self.forward + right * (2.0 * x - 1.0) + up * (2.0 * y - 1.0);
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

impl CameraShader for LookCamera {
    fn place(&self, p: Vec3, aspect: f32) -> Option<[f32; 2]> {
        let way = p - self.eye;
        let [x, y, z] = [self.right, self.up, self.forward].map(|axis| way.dot(axis));
        let place = match self.look {
            Look::Perspective { half_height } => {
                // Nothing shows that lies behind.
                if z <= 0.0 {
                    return None;
                }
                [x / (z * half_height * aspect), y / (z * half_height)]
            }
            Look::Parallel { half_height } => [x / (half_height * aspect), y / half_height],
            Look::Fisheye { half_angle } => {
                let aside = x.hypot(y);
                let scale = if aside > 0.0 { aside.atan2(z) / (half_angle * aside) } else { 0.0 };
                [x * scale / aspect, y * scale]
            }
            Look::Panorama => [x.atan2(z) / PI, (y / way.length()).asin() / FRAC_PI_2],
        };
        place.iter().all(|x| x.is_finite()).then(|| place.map(|x| 0.5 + 0.5 * x))
    }

    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch) {
        if let Look::Perspective { half_height } = self.look
            && !self.has_lens()
        {
            return self.pinhole(half_height, samples.places, aspect, out);
        }
        for (i, place) in samples.places.iter().enumerate() {
            let (ray, focus) = self.straight(place.map(|x| 2.0 * x - 1.0), aspect);
            let is_seen = ray.dir != [0.0; 3];
            let bent = self.has_lens() && is_seen;
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

    fn camera(look: Look, radius: f32) -> LookCamera {
        let (eye, focus) = (Vec3::new(1.0, 2.0, 3.0), 4.0);
        LookCamera { eye, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, look, radius, focus }
    }

    const LOOKS: [Look; 4] = [
        Look::Perspective { half_height: 0.7 },
        Look::Parallel { half_height: 1.5 },
        Look::Fisheye { half_angle: 1.9 },
        Look::Panorama,
    ];

    fn rays(camera: &LookCamera, places: &[[f32; 2]], lens: &[[f32; 2]], aspect: f32) -> Vec<Ray> {
        let mut out = RayBatch::default();
        camera.rays(&CameraSamples { places, lens, times: &[] }, aspect, &mut out);
        (0..out.len()).map(|i| out.get(i)).collect()
    }

    /// Closed forms of the edges.
    #[test]
    fn places_are_directions() {
        let seen = |look, place: [f32; 2], aspect: f32| {
            let ray = rays(&camera(look, 0.0), &[place], &[], aspect)[0];
            (Vec3::from(ray.org) - Vec3::new(1.0, 2.0, 3.0), Vec3::from(ray.dir))
        };
        let near = |a: Vec3, b: Vec3| (a - b).length() < 1e-5;
        let (origin, dir) = seen(Look::Parallel { half_height: 1.5 }, [1.0, 0.0], 2.0);
        assert!(near(origin, Vec3::new(3.0, -1.5, 0.0)) && near(dir, Vec3::NEG_Z), "{origin} {dir}");
        let half_sphere = Look::Fisheye { half_angle: FRAC_PI_2 };
        assert!(near(seen(half_sphere, [0.5, 1.0], 1.0).1, Vec3::Y), "straight up at the upper edge");
        assert!(near(seen(half_sphere, [0.5, 0.5], 1.0).1, Vec3::NEG_Z), "ahead in the middle");
        assert!(near(seen(half_sphere, [1.0, 0.5], 2.0).1, Vec3::Z), "behind, where it is twice as wide");
        assert_eq!(seen(Look::Fisheye { half_angle: PI }, [0.0, 0.0], 1.0).1, Vec3::ZERO, "beyond behind");
        for (place, wanted) in [
            ([0.5, 0.5], Vec3::NEG_Z),
            ([0.75, 0.5], Vec3::X),
            ([0.25, 0.5], Vec3::NEG_X),
            ([0.0, 0.5], Vec3::Z),
            ([0.3, 1.0], Vec3::Y),
            ([0.3, 0.0], Vec3::NEG_Y),
        ] {
            let dir = seen(Look::Panorama, place, 2.0).1;
            assert!(near(dir, wanted), "{place:?} of a panorama looks along {dir}");
        }
    }

    /// What a ray meets shows where the ray came through.
    #[test]
    fn points_show_where_their_rays_are() {
        for look in LOOKS {
            for place in [[0.5, 0.5], [0.2, 0.9], [0.97, 0.4], [0.01, 0.02]] {
                let camera = camera(look, 0.0);
                let ray = rays(&camera, &[place], &[], 1.25)[0];
                let p = Vec3::from(ray.org) + 3.5 * Vec3::from(ray.dir);
                let [x, y] = camera.place(p, 1.25).expect("it is seen");
                let off = (x - place[0]).hypot(y - place[1]);
                assert!(off < 1e-5, "{look:?}: {place:?} shows at {x}, {y}");
            }
        }
        let behind = camera(LOOKS[0], 0.0).place(Vec3::new(1.0, 2.0, 4.0), 1.0);
        assert_eq!(behind, None, "perspectives show nothing that lies behind");
    }

    /// All rays of a place meet where the pinhole's ray is in focus, begin within the lens, and fill it.
    #[test]
    fn rays_of_a_place_meet_in_focus() {
        let lens: Vec<[f32; 2]> =
            (0..256).map(|i| [(i % 16) as f32 / 16.0 + 0.03, (i / 16) as f32 / 16.0 + 0.03]).collect();
        for look in LOOKS {
            for place in [[0.5, 0.5], [0.2, 0.9], [0.97, 0.4]] {
                let sharp = rays(&camera(look, 0.0), &[place], &[], 1.25)[0];
                let (origin, dir) = (Vec3::from(sharp.org), Vec3::from(sharp.dir));
                let focus = match look {
                    Look::Perspective { .. } => 4.0 / -dir.z,
                    _ => 4.0,
                };
                let meeting = origin + dir * focus;
                let bent = rays(&camera(look, 0.5), &vec![place; lens.len()], &lens, 1.25);
                let mut widest = 0.0_f32;
                for ray in &bent {
                    let (from, along) = (Vec3::from(ray.org), Vec3::from(ray.dir));
                    assert!((along.length() - 1.0).abs() < 1e-5, "{look:?}: unit");
                    let miss = (meeting - from).cross(along).length();
                    assert!(miss < 1e-5, "{look:?} {place:?}: misses its focus by {miss}");
                    widest = widest.max(from.distance(origin));
                }
                assert!((0.45..0.50001).contains(&widest), "{look:?}: the lens is {widest} wide");
                let middle = rays(&camera(look, 0.5), &[place], &[], 1.25)[0];
                assert!(Vec3::from(middle.dir).distance(dir) < 1e-6, "{look:?}: its middle is a pinhole");
            }
        }
    }

    #[test]
    fn a_pinholes_arrays_are_its_rays() {
        let camera = camera(LOOKS[0], 0.0);
        for (i, ray) in rays(&camera, &[[0.1, 0.8], [0.6, 0.3]], &[], 1.6).into_iter().enumerate() {
            let (same, _) = camera.straight([[-0.8, 0.6], [0.2, -0.4]][i], 1.6);
            assert!(Vec3::from(ray.dir).distance(same.dir.into()) < 1e-6 && ray.org == same.org, "ray {i}");
        }
    }
}
