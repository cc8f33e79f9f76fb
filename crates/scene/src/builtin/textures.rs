// SPDX-License-Identifier: GPL-3.0-or-later
//! Four panels that show textures outside of `[0, 1]` and between texels. From left to right: repeat,
//! mirrored repeat, clamp to edge (bilinear), repeat (nearest).

use super::shapes::{quad, show};
use crate::affine::Affine;
use crate::camera::Camera;
use crate::light::Light;
use crate::material::{Color, Material, Surface, TextureRef};
use crate::scene::Scene;
use crate::texture::{Filter, TexelData, Texels, Texture, Wrap};

const SIZE: u32 = 16;

pub(super) fn scene() -> Scene {
    let mut scene = Scene::new();
    let picture = std::sync::Arc::new(arrow());
    let panels = [
        ("repeat", Wrap::Repeat, Filter::Linear),
        ("mirrored repeat", Wrap::MirroredRepeat, Filter::Linear),
        ("clamp to edge", Wrap::ClampToEdge, Filter::Linear),
        ("nearest", Wrap::Repeat, Filter::Nearest),
    ];
    for (i, (name, wrap, filter)) in panels.into_iter().enumerate() {
        let texture = Texture { name: name.into(), texels: picture.clone(), wrap: [wrap; 2], filter };
        let texture = scene.add_texture(texture);
        // Three copies across, the middle one in the middle.
        let reference =
            TextureRef { uv_from_mesh: [3.0, 0.0, 0.0, 3.0, -1.0, -1.0], ..TextureRef::new(texture) };
        let base_color = Color { factor: [1.0; 3], texture: Some(reference) };
        let material = scene.add_material(Material::of(name, Surface::Matte { base_color }));
        let angle = (i as f32 - 1.5) * -0.22;
        let (s, c) = angle.sin_cos();
        let middle = [(i as f32 - 1.5) * 1.95, 0.0, (i as f32 - 1.5).powi(2) * 0.2];
        let corner = [middle[0] - 0.9 * c, 0.1, middle[2] + 0.9 * s];
        show(&mut scene, name, quad(corner, [1.8 * c, 0.0, -1.8 * s], [0.0, 1.8, 0.0]), material);
    }
    let floor = scene.add_material(Material::matte("floor", [0.5, 0.5, 0.52]));
    show(&mut scene, "floor", quad([-40.0, 0.0, 40.0], [80.0, 0.0, 0.0], [0.0, 0.0, -80.0]), floor);
    scene.add_light(Light::Point { position: [-2.5, 5.0, 5.0], intensity: [62.0, 58.0, 52.0], radius: 0.0 });
    let world_from_light = Affine::IDENTITY;
    scene.add_light(Light::Environment { radiance: [0.32, 0.36, 0.42], texture: None, world_from_light });
    scene.add_camera(Camera {
        name: "front".into(),
        eye: [0.0, 1.5, 9.2],
        target: [0.0, 0.95, 0.0],
        up: [0.0, 1.0, 0.0],
        fov_y: 38.0,
        ..Camera::default()
    });
    scene
}

/// An arrow that points up and to the right, with a red lower and a blue left edge: every orientation is
/// distinguishable.
fn arrow() -> Texels {
    let texel = |x: u32, y: u32| {
        let up = SIZE - 1 - y;
        let (shaft, head) = (x.abs_diff(up) <= 1 && x > 2, (x >= 12 && up >= 6) || (up >= 12 && x >= 6));
        match (x, up) {
            (_, 0) => [200, 40, 30, 255],
            (0, _) => [30, 70, 200, 255],
            _ if (shaft || head) && x < 15 && up < 15 => [30, 30, 34, 255],
            _ => [235, 225, 190, 255],
        }
    };
    let data = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| texel(x, y))).collect();
    Texels { width: SIZE, height: SIZE, data: TexelData::Srgb8(data) }
}
