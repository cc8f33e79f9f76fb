// SPDX-License-Identifier: GPL-3.0-or-later
//! Light for scenes that have none, and what counts as having some. A camera that stands within the scene gets a lamp there,
//! because walls and roof would stop light from far away; all others stand in a studio (`studio`), or, where only rays are
//! counted, under a key light from over the camera's left shoulder and a grey background.
//! Source: original. Space: world; linear light. A white matte surface that faces the key light shows about 1.
//! Proof: `tests`.

use super::sight::MOST_LOOKED_AT;
use super::{bounds_of, sight};
use crate::image::srgb;
use crate::scene::{Affine, Camera, Light, Material, Mesh, Projection, Scene};

/// Irradiance of the key light.
const KEY: f32 = 2.4;
/// Radiance of the background, from all sides.
const GREY: f32 = 0.25;

/// What glows no brighter than this, white or less, may be a display or a decal, meant to be seen in other light ...
const DECAL: f32 = 1.0;
/// ... and is one if it gives off no more than this in the mean over all surfaces ...
const DIM: f64 = 0.05;
/// ... or if more than this share of all surfaces glow: there is not much to be lit by them.
const MOSTLY: f64 = 0.5;

/// Whether anything gives light: a light, an environment, or surfaces that emit and are used. Surfaces that merely glow, as the
/// displays and labels of things that were modelled to stand in other light, and things that glow all over do not count: radiance
/// of 1 at most, and by a texture, or by a twentieth of that in the mean over the area of everything, or from most of it.
#[must_use]
pub fn shines(scene: &Scene) -> bool {
    !scene.lights().is_empty() || emission(scene).is_some_and(|emission| emission.is_light())
}

/// Whether something glows that is no light.
pub(super) fn glows(scene: &Scene) -> bool {
    emission(scene).is_some()
}

/// What surfaces give off.
struct Emitted {
    /// The most of any material, any channel.
    brightest: f32,
    /// Over the area of everything.
    mean: f64,
    /// Share of that area that glows at all.
    share: f64,
}

impl Emitted {
    fn is_light(&self) -> bool {
        self.brightest > DECAL || (self.mean > DIM && self.share <= MOSTLY)
    }
}

/// `None` if no surface that is used emits.
fn emission(scene: &Scene) -> Option<Emitted> {
    let emits = |mesh: &Mesh| scene.materials().get(mesh.material.index()).filter(|m| m.emits());
    let shining =
        || scene.meshes().iter().filter(|mesh| !mesh.indices.is_empty()).filter_map(|mesh| emits(mesh));
    let brightest = shining().flat_map(|material| material.emission).fold(0.0, f32::max);
    if brightest <= 0.0 {
        return None;
    }
    if brightest > DECAL {
        return Some(Emitted { brightest, mean: f64::INFINITY, share: 0.0 });
    }
    let (mut all, mut light, mut glowing) = (0.0, 0.0, 0.0);
    for found in scene.occurrences().take(MOST_LOOKED_AT) {
        for mesh in found.object.meshes.iter().filter_map(|id| scene.meshes().get(id.index())) {
            let area = area(mesh, &found.world_from_object);
            all += area;
            let material = scene.materials().get(mesh.material.index()).filter(|material| material.emits());
            light += area * material.map_or(0.0, lamp_luminance);
            glowing += if material.is_some() { area } else { 0.0 };
        }
    }
    // Meshes that no instance shows, as in scenes in the making, count for themselves.
    let is_shown = all > 0.0;
    let (mean, share) = if is_shown { (light / all, glowing / all) } else { (f64::INFINITY, 0.0) };
    Some(Emitted { brightest, mean, share })
}

/// Luminance that a material gives off as a lamp: textures of light no brighter than white are displays and labels.
fn lamp_luminance(material: &Material) -> f64 {
    if material.emission_texture.is_some() { 0.0 } else { f64::from(srgb::luminance(material.emission)) }
}

fn area(mesh: &Mesh, to: &Affine) -> f64 {
    let corner = |i: u32| mesh.positions.get(i as usize).map(|p| to.point(p.map(f64::from)));
    let areas = mesh.indices.iter().filter_map(|&[a, b, c]| {
        let (a, b, c) = (corner(a)?, corner(b)?, corner(c)?);
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        Some(0.5 * n.iter().map(|x| x * x).sum::<f64>().sqrt()).filter(|area| area.is_finite())
    });
    areas.sum()
}

/// From the eye to the lamp, in units of the camera's frame: right, up, forward.
const TOWARDS_LAMP: [f64; 3] = [-0.6, 0.7, -0.4];
/// How far the lamp is, as a share of the distance that is typical of the picture.
const LAMP_DISTANCE: f64 = 0.12;
/// Directions whose distances are looked at: columns and rows over a picture of 4:3.
const SIGHTS: [u32; 2] = [8, 6];

/// Whether a point within the scene's box lies under the open sky: most of five ways up meet nothing.
pub(super) fn is_open(scene: &Scene, eye: [f64; 3], up: [f64; 3]) -> bool {
    let directions: Vec<[f64; 3]> = (0..5)
        .map(|i| {
            // Straight up, and four ways aslant.
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
    sight::distances(scene, eye, &directions).iter().filter(|d| d.is_infinite()).count() >= 3
}

/// The lamp and the background that suit a camera within the scene; `None` if it stands outside, or sees nothing.
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

    let seen = sight::distances(scene, eye, &directions);
    let mut ahead: Vec<f64> = seen[1..].iter().copied().filter(|d| d.is_finite()).collect();
    ahead.sort_by(f64::total_cmp);
    let typical = *ahead.get(ahead.len() / 2)?;
    // Not behind a wall: at most half way to whatever is there.
    let distance = (LAMP_DISTANCE * typical).min(0.5 * seen[0]);
    let position = [0, 1, 2].map(|k| (eye[k] + distance * directions[0][k]) as f32);
    let intensity = f64::from(KEY) * typical * typical;
    (intensity.is_finite() && intensity > 0.0).then_some([
        Light::Point { position, intensity: [intensity.min(f64::from(f32::MAX)) as f32; 3] },
        background(),
    ])
}

fn background() -> Light {
    Light::Environment { radiance: [GREY; 3], texture: None, world_from_light: Affine::IDENTITY }
}

/// The lights that suit `camera` where it stands outside.
#[must_use]
pub fn lit_from(camera: &Camera) -> [Light; 2] {
    let direction = match camera.frame() {
        Some(frame) => [0, 1, 2].map(|k| frame.forward[k] + 0.7 * frame.right[k] - 0.8 * frame.up[k]),
        None => [0.7, -0.8, -1.0],
    };
    [Light::Directional { direction, irradiance: [KEY; 3] }, background()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Mesh};

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
    fn room() -> Scene {
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
        let room = room();
        assert!(lit_within(&room, &camera([-9.0, 0.0, 0.0])).is_none(), "seen from outside");
        let near_corner = [-3.9, 2.95, 1.95];
        for eye in [[-3.0, 0.0, 0.0], near_corner] {
            let lights = lit_within(&room, &camera(eye)).expect("seen from within");
            let [Light::Point { position, intensity }, Light::Environment { .. }] = lights else {
                panic!("a lamp and a background: {lights:?}");
            };
            let bounds = bounds_of(&room).expect("a room");
            assert!(bounds.contains(position.map(f64::from)), "{position:?} is in the room");
            let irradiance = intensity[0] / (4.0 - eye[0]).powi(2);
            assert!((0.3..3.0).contains(&irradiance), "the far wall gets {irradiance}");
        }
        let lights = lit_within(&room, &camera([-3.0, 0.0, 0.0])).expect("seen from within");
        let [Light::Point { position: [x, y, z], .. }, _] = lights else { panic!("a lamp") };
        assert!(x < -3.0 && y > 0.0 && z > 0.0, "behind, left and above: {x} {y} {z}");
    }

    #[test]
    fn the_sky_is_open_or_not() {
        let room = room();
        for up in [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]] {
            assert!(!is_open(&room, [0.0; 3], up), "under a roof");
            assert!(is_open(&room, [0.0, 2.0, 9.0], up), "beside it");
        }
    }

    /// A thing of which a surface of area 1 glows, and one of `other` does not.
    fn thing(glow: [f32; 3], other: f32) -> Scene {
        let mut scene = Scene::new();
        let mut add = |area: f32, emission: [f32; 3]| {
            let size = area.sqrt();
            let mut material = Material::matte("", [0.5; 3]);
            material.emission = emission;
            let material = scene.add_material(material);
            let positions = vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
            let mesh =
                scene.add_mesh(Mesh { positions, indices: vec![[0, 1, 2]], material, ..Mesh::default() });
            let object = scene.add_object_of("", vec![mesh]);
            scene.instantiate(object, Affine::IDENTITY);
        };
        add(1.0, glow);
        add(other, [0.0; 3]);
        scene
    }

    #[test]
    fn what_merely_glows_is_no_light() {
        assert!(!shines(&thing([1.0; 3], 100.0)), "a white display on a thing");
        assert!(glows(&thing([1.0; 3], 100.0)), "but it glows");
        assert!(shines(&thing([1.0; 3], 5.0)), "a large white lamp");
        assert!(!shines(&thing([1.0; 3], 0.2)), "a thing that glows nearly everywhere");
        assert!(shines(&thing([40.0; 3], 1000.0)) && shines(&thing([40.0; 3], 0.1)), "a lamp of any size");
        assert!(!glows(&thing([0.0; 3], 1.0)), "nothing");
    }

    #[test]
    fn emitting_surfaces_are_light() {
        let mut scene = Scene::new();
        let dark = scene.add_material(Material::matte("dark", [0.5; 3]));
        let mut lamp = Material::matte("lamp", [0.5; 3]);
        lamp.emission = [0.0, 1.0, 0.0];
        let lamp = scene.add_material(lamp);
        assert!(!shines(&scene), "a material that nothing is made of gives no light");
        let mesh = Mesh {
            positions: vec![[0.0; 3]; 3],
            indices: vec![[0, 1, 2]],
            material: dark,
            ..Mesh::default()
        };
        let mesh = scene.add_mesh(mesh);
        assert!(!shines(&scene), "a dark surface");
        scene.edit_mesh(mesh).material = lamp;
        assert!(shines(&scene), "a shining one");
    }
}
