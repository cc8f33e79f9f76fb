// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights of a scene as lights of UsdLux, and the pictures of environments.
//! Points are balls that are treated as points, with normalized power. Space: metres. Tests: `tests/save.rs`.

use std::f64::consts::PI;
use std::path::Path;

use gnurt_image::{Picture, PictureFormat, WriteOptions};
use gnurt_scene::io::Error;
use gnurt_scene::texture::Texels;
use gnurt_scene::{Affine, Light};

use super::text::{Text, tuple};
use super::transforms::{frame, write_transform};

/// Writes a light.
pub(super) fn write(light: &Light, name: &str, files: &[String], text: &mut Text) {
    match light {
        Light::Point { position, intensity, radius } => {
            text.open("def SphereLight", name, &[]);
            write_transform(&Affine::translation(position.map(f64::from)), text);
            write_point(*intensity, *radius, text);
            text.close();
        }
        Light::Spot { position, direction, intensity, inner_angle, outer_angle, edge, radius } => {
            text.open("def SphereLight", name, &["prepend apiSchemas = [\"ShapingAPI\"]".to_owned()]);
            write_transform(&towards(*direction, *position), text);
            write_point(*intensity, *radius, text);
            text.line(format_args!("float inputs:shaping:cone:angle = {}", outer_angle.to_degrees()));
            let softness =
                1.0 - edge.squared_inner(*inner_angle, *outer_angle) / outer_angle.max(f32::MIN_POSITIVE);
            text.line(format_args!("float inputs:shaping:cone:softness = {}", softness.clamp(0.0, 1.0)));
            text.close();
        }
        Light::Directional { direction, irradiance, angle } => {
            text.open("def DistantLight", name, &[]);
            write_transform(&towards(*direction, [0.0; 3]), text);
            write_strength(*irradiance, 1.0, text);
            text.line(format_args!("float inputs:angle = {}", angle.to_degrees()));
            text.line("bool inputs:normalize = true");
            text.close();
        }
        Light::Environment { radiance, texture, world_from_light } => {
            text.open("def DomeLight", name, &[]);
            // The middle of a dome's picture lies along +z.
            write_transform(&(*world_from_light * Affine::rotation([0.0, 1.0, 0.0], -PI)), text);
            write_strength(*radiance, 1.0, text);
            if let Some(texture) = texture {
                text.line(format_args!("asset inputs:texture:file = @{}@", files[texture.index()]));
                text.line("token inputs:texture:format = \"latlong\"");
            }
            text.close();
        }
        Light::Backdrop { .. } => {}
    }
}

fn write_point(intensity: [f32; 3], radius: f32, text: &mut Text) {
    if radius > 0.0 {
        text.line(format_args!("float inputs:radius = {radius}"));
    } else {
        text.line("bool treatAsPoint = true");
        text.line("float inputs:radius = 0.01");
    }
    text.line("bool inputs:normalize = true");
    write_strength(intensity, 4.0, text);
}

/// A colour whose largest part is 1, and what it is multiplied by.
fn write_strength(value: [f32; 3], share: f32, text: &mut Text) {
    let most = value.into_iter().fold(0.0, f32::max);
    let color = if most > 0.0 { value.map(|x| x / most) } else { [1.0; 3] };
    text.line(format_args!("color3f inputs:color = {}", tuple(color)));
    text.line(format_args!("float inputs:intensity = {}", most * share));
}

/// A frame that looks along a direction.
fn towards(direction: [f32; 3], origin: [f32; 3]) -> Affine {
    let length = direction.iter().map(|x| x * x).sum::<f32>().sqrt();
    let back = if length > 0.0 { direction.map(|x| -x / length) } else { [0.0, 0.0, 1.0] };
    let helper = if back[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let side = cross(helper, back);
    let size = side.iter().map(|x| x * x).sum::<f32>().sqrt();
    let right = side.map(|x| x / size);
    frame([right, cross(back, right), back], origin)
}

/// A picture with values beyond 1.
pub(super) fn encode(texels: &Texels, path: &Path) -> Result<Vec<u8>, Error> {
    let texels = texels.clone().resident();
    let mut picture = Picture::new(texels.width, texels.height);
    for (i, pixel) in picture.color.iter_mut().enumerate() {
        let (x, y) = (i % texels.width as usize, i / texels.width as usize);
        *pixel = texels.texel(x, y);
    }
    let encoded = gnurt_image::encode(&picture, PictureFormat::EXR, &WriteOptions::default());
    encoded.map_err(|e| Error::io(path, format!("a texture cannot be written: {e}"), ""))
}
