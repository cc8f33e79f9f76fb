// SPDX-License-Identifier: GPL-3.0-or-later
//! What a pixel stands for, as a cone around its ray: how wide it is at the camera and how fast it widens.
//! Source: [AM21] (ray cones), [Ige99] (what they stand for: differentials). Cones are round and mirrors are taken as flat:
//! a mirrored ray goes on as wide as it came, with the same spread. Space: world; the spread is in units per unit of way.
//! Proof: `tests`; the OpenRT binding's tests/c/mipmaps.c.

use gnurt_accel::RayBatch;
use gnurt_shading::{CameraSamples, CameraShader, SurfaceBatch};

use crate::options::RenderOptions;

/// The cone of a pixel in the middle of the picture, which all pixels take for theirs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cone {
    /// Distance of the origins of two pixels beside each other: 0 in perspective.
    width: f32,
    /// Distance of the ends of their unit directions.
    spread: f32,
}

impl Cone {
    /// The cone of a camera's pixels; nothing if it gives no rays.
    pub(crate) fn of(camera: &dyn CameraShader, options: &RenderOptions) -> Self {
        let (width, height) = (options.width as f32, options.height as f32);
        let mut rays = RayBatch::default();
        let beside = [[0.5, 0.5], [0.5 + 1.0 / width, 0.5], [0.5, 0.5 + 1.0 / height]];
        camera.rays(&CameraSamples::sharp(&beside), width / height, &mut rays);
        if rays.len() < beside.len() {
            return Self::default();
        }
        let distance = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
        let [middle, right, up] = [0, 1, 2].map(|i| rays.get(i));
        let larger = |a: f32, b: f32| Some(a.max(b)).filter(|x| x.is_finite()).unwrap_or(0.0);
        Self {
            width: larger(distance(middle.org, right.org), distance(middle.org, up.org)),
            spread: larger(distance(middle.dir, right.dir), distance(middle.dir, up.dir)),
        }
    }

    /// How wide it is `distance` away from a camera.
    pub(crate) fn width_at(self, distance: f32) -> f32 {
        self.width + self.spread * distance
    }

    /// Writes the widths at points that the rays of `lanes` met. `begin` holds how wide each ray began, if anybody knows
    /// that; rays of depth 0 began at the camera.
    pub(crate) fn widen(self, points: &mut SurfaceBatch, lanes: &[u32], begin: &[f32]) {
        if points.depth > 0 && begin.is_empty() {
            return;
        }
        let from =
            |lane: u32| if points.depth == 0 { Some(self.width) } else { begin.get(lane as usize).copied() };
        let widths =
            lanes.iter().zip(&points.t).map(|(&lane, t)| from(lane).unwrap_or(0.0) + self.spread * t);
        points.footprint.clear();
        points.footprint.extend(widths);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::SceneCamera;

    #[test]
    fn widens_with_the_way() {
        let camera = gnurt_scene::Camera {
            name: String::new(),
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 90.0,
            ..gnurt_scene::Camera::default()
        };
        let camera = SceneCamera::new(&camera).expect("a view");
        let options = RenderOptions { width: 200, height: 100, ..RenderOptions::default() };
        let cone = Cone::of(&camera, &options);
        assert_eq!(cone.width, 0.0, "from one eye");
        assert!(
            (cone.spread - 0.02).abs() < 1e-4,
            "a picture 2 high at distance 1, by 100 rows: {}",
            cone.spread
        );
        let mut points = SurfaceBatch { t: vec![10.0, 5.0], ..SurfaceBatch::default() };
        cone.widen(&mut points, &[1, 0], &[]);
        assert!((points.footprint[0] - 0.2).abs() < 1e-3, "at distance 10: {:?}", points.footprint);
        points.depth = 1;
        cone.widen(&mut points, &[1, 0], &[1.0, 2.0]);
        assert!((points.footprint[0] - 2.2).abs() < 1e-3, "after a mirror: {:?}", points.footprint);
    }
}
