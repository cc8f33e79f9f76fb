// SPDX-License-Identifier: GPL-3.0-or-later
//! A studio for objects without light: soft light from a plain sky, and a floor that is visible only where it
//! is in shadow.
//! Source: after the habits of product photography: a key light over the camera's left shoulder, as large as a soft box, a weaker one above, and a bright backdrop that goes over into the floor without an edge.
//!
//! The sky is [`BACKDROP`] in all directions, except for the two lights. The floor's albedo is such that it
//! sends back just that where all of the sky reaches it, so that neither its edge nor the horizon is seen.
//! Space: world; +up is an axis. Radiance is linear: at exposure 0 a white matte surface that faces the key
//! light shows about 1. Invariants: the floor lies below everything, and reaches beyond every shadow. Tests:
//! `tests`.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::Bounds;
use crate::scene::material::Surface;
use crate::scene::texture::{Filter, Wrap};
use crate::scene::{Affine, Camera, Light, Material, Mesh, Scene, Texture};
use crate::surroundings::upright;

/// Radiance of the backdrop, and of the floor without shadow.
const BACKDROP: f64 = 0.36;
/// The key light: radiance at its middle, and the angles up to which it is that bright and where it ends, degrees.
const KEY: (f64, [f64; 2]) = (4.0, [14.0, 34.0]);
/// From the scene to the key light: towards the camera, to its left, up.
const TOWARDS_KEY: [f64; 3] = [0.75, 0.65, 1.0];
/// The light above.
const TOP: (f64, [f64; 2]) = (0.5, [10.0, 60.0]);
/// Half the floor's side, in halves of the diagonal of the scene's box.
const REACH: f64 = 14.0;
/// Its distance below the scene, relative to that: geometry in its plane must not flicker.
const GAP: f64 = 2e-4;
/// Columns and rows of the sky.
const SIZE: [u32; 2] = [256, 128];

/// The axis that is up where `up` is, +y unless another one is clearly meant.
pub(super) fn axis_of(up: [f32; 3]) -> [f64; 3] {
    let length = up.iter().map(|x| x * x).sum::<f32>().sqrt();
    let clear = (0..3).find(|&k| up[k].abs() > 0.9 * length).filter(|_| length > 0.0 && length.is_finite());
    let mut axis = [0.0; 3];
    match clear {
        Some(k) => axis[k] = f64::from(up[k].signum()),
        None => axis[1] = 1.0,
    }
    axis
}

/// Adds the studio to a scene; the floor is left out where nothing is above it, or the camera is below it.
pub(super) fn add(scene: &mut Scene, camera: &Camera, bounds: Option<Bounds>, up: [f64; 3]) {
    let world_from_light = upright(up.map(|x| x as f32));
    let sky = Sky { up, key: towards_key(camera, up) };
    let (texture, irradiance) = sky.painted(world_from_light);
    let texture = scene.add_texture(texture);
    scene.add_light(Light::Environment { radiance: [1.0; 3], texture: Some(texture), world_from_light });
    let Some(mesh) = bounds.and_then(|bounds| floor(&bounds, camera, up)) else { return };
    let albedo = [(PI * BACKDROP / irradiance) as f32; 3];
    let surface = Surface::ShadowCatcher { albedo, radiance: [BACKDROP as f32; 3] };
    let material = scene.add_material(Material::of("studio floor", surface));
    let mesh = scene.add_mesh(Mesh { material, ..mesh });
    let object = scene.add_object_of("studio floor", vec![mesh]);
    scene.instantiate(object, Affine::IDENTITY);
}

/// A square below the box, its front upwards.
fn floor(bounds: &Bounds, camera: &Camera, up: [f64; 3]) -> Option<Mesh> {
    let axis = (0..3).find(|&k| up[k] != 0.0)?;
    let half = 0.5 * (0..3).map(|k| (bounds.max[k] - bounds.min[k]).powi(2)).sum::<f64>().sqrt();
    let largest = bounds.corners().into_iter().flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
    // As far below as single precision distinguishes, at least.
    let gap = (GAP * half).max(2e-7 * largest);
    let lowest = if up[axis] > 0.0 { bounds.min[axis] } else { -bounds.max[axis] } - gap;
    let is_above = f64::from(camera.eye[axis]) * up[axis] > lowest;
    let (across, along) = ((axis + 1) % 3, (axis + 2) % 3);
    let center = bounds.center();
    let corner = |s: f64, t: f64| {
        let mut p = [0.0; 3];
        p[axis] = lowest * up[axis];
        p[across] = center[across] + s * REACH * half;
        p[along] = center[along] + t * REACH * half * up[axis];
        p.map(|x| x as f32)
    };
    let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let is_sound = half > 0.0 && positions.iter().flatten().all(|x| x.is_finite() && x.abs() < 1e18);
    let mesh = Mesh {
        name: "studio floor".into(),
        positions,
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    (is_sound && is_above).then_some(mesh)
}

/// Over the camera's left shoulder, from above; unit.
fn towards_key(camera: &Camera, up: [f64; 3]) -> [f64; 3] {
    let ahead = camera.frame().map_or([0.0, 0.0, -1.0], |frame| frame.forward.map(f64::from));
    let flat = less(ahead, up, dot(ahead, up));
    // A camera that faces straight down has its own up direction.
    let ahead = unit(flat).or_else(|| {
        let head = camera.frame().map(|frame| frame.up.map(f64::from))?;
        unit(less(head, up, dot(head, up)))
    });
    let ahead = ahead.unwrap_or_else(|| if up[2] == 0.0 { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] });
    let right = cross(ahead, up);
    let [back, left, high] = TOWARDS_KEY;
    let to = [0, 1, 2].map(|k| high * up[k] - back * ahead[k] - left * right[k]);
    unit(to).unwrap_or(up)
}

/// Radiance of the studio's walls.
struct Sky {
    up: [f64; 3],
    key: [f64; 3],
}

impl Sky {
    /// From a unit direction.
    fn radiance(&self, direction: [f64; 3]) -> f64 {
        let light = |(radiance, [inner, outer]): (f64, [f64; 2]), towards: [f64; 3]| {
            let angle = dot(direction, towards).clamp(-1.0, 1.0).acos().to_degrees();
            let x = ((outer - angle) / (outer - inner)).clamp(0.0, 1.0);
            radiance * x * x * (3.0 - 2.0 * x)
        };
        BACKDROP + light(KEY, self.key) + light(TOP, self.up)
    }

    /// As a picture, and the irradiance of a floor under it.
    fn painted(&self, world_from_light: Affine) -> (Texture, f64) {
        let [width, height] = SIZE;
        let (mut texels, mut irradiance) = (Vec::with_capacity((width * height) as usize), 0.0);
        for y in 0..height {
            let theta = (f64::from(y) + 0.5) / f64::from(height) * PI;
            let solid_angle = TAU / f64::from(width) * PI / f64::from(height) * theta.sin();
            for x in 0..width {
                let phi = ((f64::from(x) + 0.5) / f64::from(width) - 0.5) * TAU;
                let in_light = [theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()];
                let radiance = self.radiance(world_from_light.vector(in_light));
                irradiance += radiance * theta.cos().max(0.0) * solid_angle;
                let radiance = radiance as f32;
                texels.push([radiance, radiance, radiance, 1.0]);
            }
        }
        let texels = crate::image::Texels { width, height, data: crate::image::TexelData::Float(texels) };
        let texture = Texture {
            name: "studio".into(),
            texels: Arc::new(texels),
            wrap: [Wrap::Repeat, Wrap::ClampToEdge],
            filter: Filter::Linear,
        };
        (texture, irradiance)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a` minus `b` times a factor.
fn less(a: [f64; 3], b: [f64; 3], times: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - times * b[k])
}

/// `None` if its direction is undefined.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 1e-3 && length.is_finite()).then(|| v.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looking(eye: [f32; 3], target: [f32; 3]) -> Camera {
        Camera { name: String::new(), eye, target, up: [0.0, 1.0, 0.0], fov_y: 40.0, ..Camera::default() }
    }

    #[test]
    fn up_is_an_axis() {
        assert_eq!(axis_of([0.0, 2.0, 0.1]), [0.0, 1.0, 0.0], "almost");
        assert_eq!(axis_of([0.0, 0.0, -3.0]), [0.0, 0.0, -1.0], "upside down");
        for odd in [[0.0; 3], [1.0, 1.0, 1.0], [f32::NAN, 0.0, 0.0], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(axis_of(odd), [0.0, 1.0, 0.0], "{odd:?}");
        }
    }

    #[test]
    fn the_floor_lies_below_and_looks_up() {
        let bounds = Bounds { min: [-1.0, 2.0, -3.0], max: [5.0, 4.0, 1.0] };
        for (axis, sign) in [(0, 1.0), (1, 1.0), (2, 1.0), (0, -1.0), (1, -1.0), (2, -1.0)] {
            let mut up = [0.0; 3];
            up[axis] = sign;
            let mut eye = [0.0; 3];
            eye[axis] = 100.0 * sign as f32;
            let mesh = floor(&bounds, &looking(eye, [1.0; 3]), up).expect("a floor");
            let p = mesh.indices[0].map(|i| mesh.positions[i as usize].map(f64::from));
            let normal = cross(less(p[1], p[0], 1.0), less(p[2], p[0], 1.0));
            assert!(dot(normal, up) > 0.0, "its front is up: {up:?}");
            let height = dot(p[0], up);
            assert!(bounds.corners().iter().all(|&corner| dot(corner, up) > height), "below all: {up:?}");
            eye[axis] = -100.0 * sign as f32;
            assert!(floor(&bounds, &looking(eye, [1.0; 3]), up).is_none(), "not before a camera below it");
        }
        let point = Bounds { min: [1.0; 3], max: [1.0; 3] };
        assert!(
            floor(&point, &looking([0.0, 9.0, 0.0], [1.0; 3]), [0.0, 1.0, 0.0]).is_none(),
            "nothing to stand on it"
        );
    }

    #[test]
    fn the_floor_shows_the_backdrop() {
        let up = [0.0, 1.0, 0.0];
        let camera = looking([2.0, 3.0, 5.0], [0.0; 3]);
        let sky = Sky { up, key: towards_key(&camera, up) };
        let (_, irradiance) = sky.painted(Affine::IDENTITY);
        let albedo = PI * BACKDROP / irradiance;
        assert!((0.2..0.6).contains(&albedo), "a grey floor: {albedo}");
        let facing = |normal: [f64; 3]| {
            // A white surface in the open: the integral over directions, coarsely.
            let mut sum = 0.0;
            for i in 0..20_000 {
                let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 20_000.0;
                let phi = f64::from(i) * 2.399_963;
                let r = (1.0 - z * z).sqrt();
                let d = [r * phi.cos(), r * phi.sin(), z];
                sum += sky.radiance(d) * dot(d, normal).max(0.0) * 2.0 * TAU / 20_000.0;
            }
            sum / PI
        };
        let (lit, away) = (facing(sky.key), facing(sky.key.map(|x| -x)));
        assert!((0.8..1.2).contains(&lit), "white in the key light shows {lit}");
        assert!((2.0..5.0).contains(&(lit / away)), "the other side shows {away}");
    }

    #[test]
    fn the_key_light_is_behind_the_camera() {
        let up = [0.0, 1.0, 0.0];
        for (eye, target) in
            [([0.0, 2.0, 5.0], [0.0; 3]), ([3.0, 1.0, 0.0], [0.0; 3]), ([0.0, 9.0, 0.0], [0.0; 3])]
        {
            let camera = looking(eye, target);
            let frame = camera.frame().expect("a view");
            let key = towards_key(&camera, up);
            assert!((dot(key, key) - 1.0).abs() < 1e-9 && key[1] > 0.5, "from above: {key:?}");
            assert!(dot(key, frame.right.map(f64::from)) < -0.3, "from the left: {key:?}");
            let sky = Sky { up, key };
            // The whole view of a camera of 40 degrees at the scene is plain.
            for (x, y) in [(0.0, 0.0), (0.6, 0.36), (-0.6, 0.36), (0.6, -0.36), (-0.6, -0.36)] {
                let d = [0, 1, 2].map(|k| f64::from(frame.forward[k] + x * frame.right[k] + y * frame.up[k]));
                let d = unit(d).expect("a direction");
                assert_eq!(sky.radiance(d), BACKDROP, "plain at {x} {y} from {eye:?}");
            }
        }
    }

    #[test]
    fn a_scene_gets_sky_and_floor() {
        let mut scene = Scene::new();
        let bounds = Bounds { min: [0.0; 3], max: [1.0; 3] };
        add(&mut scene, &looking([2.0, 3.0, 5.0], [0.0; 3]), Some(bounds), [0.0, 1.0, 0.0]);
        let floor = scene.materials().last().expect("a material");
        assert!(matches!(floor.surface, Surface::ShadowCatcher { .. }), "{floor:?}");
        assert_eq!(
            (scene.instances().len(), scene.lights().len(), scene.textures().len()),
            (1, 1, 1),
            "and a sky"
        );
        let mut empty = Scene::new();
        add(&mut empty, &looking([2.0, 3.0, 5.0], [0.0; 3]), None, [0.0, 1.0, 0.0]);
        assert_eq!((empty.instances().len(), empty.lights().len()), (0, 1), "a sky alone");
    }
}
