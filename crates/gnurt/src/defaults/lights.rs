// SPDX-License-Identifier: GPL-3.0-or-later
//! Light for scenes that have none (`own_light`). A camera within the scene gets a light there, because walls
//! and roof would block distant light. All others get a studio (`studio`), or, if only rays are counted, a
//! key light from over the camera's left shoulder and a grey background.
//! Space: world; linear light. A white matte surface that faces the key light shows about 1.
//! Tests: `tests`.

use super::{bounds_of, distance_rays};
use crate::scene::{Affine, Camera, Light, Projection, Scene};

/// Irradiance of the key light.
const KEY: f32 = 2.4;
/// Radiance of the background, from all sides.
const GREY: f32 = 0.25;

/// From the eye to the light, in units of the camera's frame: right, up, forward.
const TOWARDS_LAMP: [f64; 3] = [-0.6, 0.7, -0.4];
/// Distance of the light, as a share of the typical distance of the picture.
const LAMP_DISTANCE: f64 = 0.12;
/// Directions of the measured distances: columns and rows over a picture of 4:3.
const SIGHTS: [u32; 2] = [8, 6];

/// Whether a point within the scene's box is under the open sky: most of five upward rays hit nothing.
pub(super) fn is_open(scene: &Scene, eye: [f64; 3], up: [f64; 3]) -> bool {
    let directions: Vec<[f64; 3]> = (0..5)
        .map(|i| {
            // Straight up, and four oblique directions.
            let mut v = up;
            for (k, x) in (0..3)
                .filter(|&k| up[k] == 0.0)
                .zip([[0.0; 2], [0.6, 0.3], [-0.3, 0.6], [-0.6, -0.3], [0.3, -0.6]][i])
            {
                v[k] = x;
            }
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            v.map(|x| x / length)
        })
        .collect();
    distance_rays::distances(scene, eye, &directions).iter().filter(|d| d.is_infinite()).count() >= 3
}

/// The light and the background that suit a camera within the scene; `None` if it is outside, or sees
/// nothing.
#[must_use]
pub fn lit_within(scene: &Scene, camera: &Camera) -> Option<[Light; 2]> {
    let (frame, eye) = (camera.frame()?, camera.eye.map(f64::from));
    bounds_of(scene)?.contains(eye).then_some(())?;
    let toward = |[x, y, z]: [f64; 3]| {
        let axis = |k: usize| [frame.right[k], frame.up[k], frame.forward[k]].map(f64::from);
        let v = [0, 1, 2].map(axis).map(|a| a[0] * x + a[1] * y + a[2] * z);
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    };
    let half_height = match camera.projection {
        Projection::Perspective => f64::from(camera.fov_y.to_radians() / 2.0).tan(),
        _ => 1.0,
    };
    let [columns, rows] = SIGHTS;
    let centre = |i: u32, n: u32| (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
    let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| (centre(x, columns), centre(y, rows))));
    let mut directions = vec![toward(TOWARDS_LAMP)];
    directions.extend(pixels.map(|(x, y)| toward([x * half_height * 4.0 / 3.0, y * half_height, 1.0])));

    let measured = distance_rays::distances(scene, eye, &directions);
    let mut ahead: Vec<f64> = measured[1..].iter().copied().filter(|d| d.is_finite()).collect();
    ahead.sort_by(f64::total_cmp);
    let typical = *ahead.get(ahead.len() / 2)?;
    // Not behind a wall: at most half-way to the surface in that direction.
    let distance = (LAMP_DISTANCE * typical).min(0.5 * measured[0]);
    let position = [0, 1, 2].map(|k| (eye[k] + distance * directions[0][k]) as f32);
    let intensity = f64::from(KEY) * typical * typical;
    (intensity.is_finite() && intensity > 0.0).then_some([
        Light::Point { position, intensity: [intensity.min(f64::from(f32::MAX)) as f32; 3], radius: 0.0 },
        background(),
    ])
}

fn background() -> Light {
    Light::Environment { radiance: [GREY; 3], texture: None, world_from_light: Affine::IDENTITY }
}

/// The lights that suit `camera` outside of the scene.
#[must_use]
pub fn lit_from(camera: &Camera) -> [Light; 2] {
    let direction = match camera.frame() {
        Some(frame) => [0, 1, 2].map(|k| frame.forward[k] + 0.7 * frame.right[k] - 0.8 * frame.up[k]),
        None => [0.7, -0.8, -1.0],
    };
    [Light::Directional { direction, irradiance: [KEY; 3], angle: 0.0 }, background()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Mesh;

    #[test]
    fn light_comes_over_the_left_shoulder() {
        let camera = Camera {
            name: String::new(),
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 45.0,
            ..Camera::default()
        };
        let [Light::Directional { direction: [x, y, z], .. }, Light::Environment { .. }] = lit_from(&camera)
        else {
            panic!("a key light and a background");
        };
        assert!(x > 0.0 && y < 0.0 && z < 0.0, "to the right, down and into the picture: {x} {y} {z}");
    }

    /// A room of 8 x 6 x 4, closed.
    fn interior() -> Scene {
        let mut scene = Scene::new();
        let positions = (0..8_u32)
            .map(|i| {
                let pick = |bit: u32, half: f32| if i >> bit & 1 == 0 { -half } else { half };
                [pick(0, 4.0), pick(1, 3.0), pick(2, 2.0)]
            })
            .collect();
        let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let indices = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = scene.add_mesh(Mesh { positions, indices, ..Mesh::default() });
        let object = scene.add_object_of("room", vec![mesh]);
        scene.instantiate(object, Affine::IDENTITY);
        scene
    }

    #[test]
    fn rooms_are_lit_from_within() {
        let camera = |eye: [f32; 3]| Camera {
            name: String::new(),
            eye,
            target: [4.0, 0.0, 0.0],
            up: [0.0, 0.0, 1.0],
            fov_y: 45.0,
            ..Camera::default()
        };
        let interior = interior();
        assert!(lit_within(&interior, &camera([-9.0, 0.0, 0.0])).is_none(), "seen from outside");
        let near_corner = [-3.9, 2.95, 1.95];
        for eye in [[-3.0, 0.0, 0.0], near_corner] {
            let lights = lit_within(&interior, &camera(eye)).expect("seen from within");
            let [Light::Point { position, intensity, radius: 0.0 }, Light::Environment { .. }] = lights
            else {
                panic!("a lamp and a background: {lights:?}");
            };
            let bounds = bounds_of(&interior).expect("a room");
            assert!(bounds.contains(position.map(f64::from)), "{position:?} is in the room");
            let irradiance = intensity[0] / (4.0 - eye[0]).powi(2);
            assert!((0.3..3.0).contains(&irradiance), "the far wall gets {irradiance}");
        }
        let lights = lit_within(&interior, &camera([-3.0, 0.0, 0.0])).expect("seen from within");
        let [Light::Point { position: [x, y, z], .. }, _] = lights else { panic!("a lamp") };
        assert!(x < -3.0 && y > 0.0 && z > 0.0, "behind, left and above: {x} {y} {z}");
    }

    #[test]
    fn the_sky_is_open_or_not() {
        let interior = interior();
        for up in [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]] {
            assert!(!is_open(&interior, [0.0; 3], up), "under a roof");
            assert!(is_open(&interior, [0.0, 2.0, 9.0], up), "beside it");
        }
    }
}
