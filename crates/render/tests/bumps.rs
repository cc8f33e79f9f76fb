// SPDX-License-Identifier: GPL-3.0-or-later
//! Bump maps: the light on a slope, and no black rims.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::*;
use gnurt_scene::material::{BumpMap, TextureRef};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, Wrap};
use gnurt_scene::{Light, MaterialId, Scene};

/// A floor of 10 by 10 whose 32 by 32 texels have these heights, one texel's width the unit.
fn bumpy(height: f32, of: impl Fn(usize, usize) -> f32) -> Scene {
    let mut scene = floor(0.5, 5.0);
    let data = TexelData::Float((0..32 * 32).map(|i| [of(i % 32, i / 32); 4]).collect());
    let texels = Arc::new(Texels { width: 32, height: 32, data });
    let (wrap, filter) = ([Wrap::Repeat; 2], Filter::Linear);
    let texture = scene.add_texture(Texture { name: String::new(), texels, wrap, filter });
    scene.edit_material(MaterialId(0)).bump = Some(BumpMap { texture: TextureRef::new(texture), height });
    scene
}

#[test]
fn slopes_face_the_light() {
    let lit_from = |direction| {
        // Rises by 3 / 4 towards +u, which is +x on the floor: its normal is (-0.6, 0, 0.8).
        let mut scene = bumpy(3.0, |x, _| 0.25 * x as f32);
        scene.add_light(Light::Directional { direction, irradiance: [PI as f32; 3], angle: 0.0 });
        radiance_at(&scene, [0.1, 0.1, 5.0], [0.1, 0.1, 0.0], 1)[0]
    };
    assert_close(lit_from([0.0, 0.0, -1.0]), 0.5 * 0.8, 1e-2, "from above");
    assert_close(lit_from([0.6, 0.0, -0.8]), 0.5, 1e-2, "from where it faces");
    assert_close(lit_from([-0.6, 0.0, -0.8]), 0.5 * (0.64 - 0.36), 2e-2, "from the other side");
}

#[test]
fn no_rim_is_black() {
    let mut scene = bumpy(4.0, |x, y| ((x * 7 + y * 13) % 5) as f32 * 0.25);
    scene.add_light(environment([1.0; 3]));
    let picture =
        frame(&scene, &camera([0.0, -6.0, 0.3], [0.0, 0.0, 0.0], 20.0), &options(32, 16, 64)).picture;
    // Below the horizon is floor, above it sky.
    let darkest = picture.color.iter().map(|p| p[0]).fold(f32::INFINITY, f32::min);
    assert!(darkest > 0.1, "grazing views see what faces them: {darkest}");
}
