// SPDX-License-Identifier: GPL-3.0-or-later
//! Normal maps of MTL, which has no one keyword for them: whether a picture is one, and surfaces that read it.
//! Blender and others write normal maps as `map_Bump`. Heights are grey or of one channel, while the mean normal of a
//! map points away from the surface: (0.5, 0.5, 1) as a colour. Space: texels. Tests: `tests`, `tests/obj.rs::bumps_may_be_normals`.

use crate::material::{Color, NormalMap, Principled, Surface};
use crate::texture::Texels;

/// The largest number of compared texels along an edge.
const MOST_ALONG: u32 = 64;
/// How far the means of red and green may be from the middle.
const SLANT: f32 = 0.12;
/// The least mean of blue, which is 0.85 where normals lean by 45 degrees.
const LEAST_BLUE: f32 = 0.75;

/// Whether a picture of linear values holds normals: its mean is near (0.5, 0.5, 1).
pub(super) fn holds_normals(texels: &Texels) -> bool {
    let [across, down] = [texels.width, texels.height].map(|n| n.min(MOST_ALONG));
    let at = |k: u32, count: u32, size: u32| (u64::from(k) * u64::from(size) / u64::from(count)) as usize;
    let mut sum = [0.0_f32; 3];
    for y in 0..down {
        for x in 0..across {
            let texel = texels.texel(at(x, across, texels.width), at(y, down, texels.height));
            (0..3).for_each(|k| sum[k] += texel[k]);
        }
    }
    let [r, g, b] = sum.map(|x| x / (across * down) as f32);
    (r - 0.5).abs() < SLANT && (g - 0.5).abs() < SLANT && (LEAST_BLUE..=1.0).contains(&b)
}

/// The surface with a normal map; glass, which reads none, comes back as it is.
pub(super) fn with_normals(surface: Surface, normals: NormalMap) -> Result<Surface, Surface> {
    let normals = Some(normals);
    Ok(match surface {
        Surface::Matte { base_color } => Surface::Principled(Box::new(Principled {
            base_color,
            metallic: 0.0,
            specular: 0.0,
            normal_texture: normals,
            ..Principled::default()
        })),
        Surface::Mirror { reflectance } => metal(reflectance, normals),
        Surface::MetallicRoughness {
            base_color,
            metallic,
            roughness,
            metallic_roughness_texture,
            ior,
            ..
        } => Surface::MetallicRoughness {
            base_color,
            metallic,
            roughness,
            metallic_roughness_texture,
            ior,
            normal_texture: normals,
        },
        Surface::Principled(principled) => {
            Surface::Principled(Box::new(Principled { normal_texture: normals, ..*principled }))
        }
        other => return Err(other),
    })
}

fn metal(base_color: Color, normal_texture: Option<NormalMap>) -> Surface {
    Surface::MetallicRoughness {
        base_color,
        metallic: 1.0,
        roughness: 0.0,
        metallic_roughness_texture: None,
        ior: 1.5,
        normal_texture,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::TexelData;

    #[test]
    fn blue_pictures_are_normals() {
        let of = |texel: [u8; 4]| {
            let texels = Texels { width: 3, height: 2, data: TexelData::Linear8(vec![texel; 6]) };
            holds_normals(&texels)
        };
        assert!(of([128, 128, 255, 255]), "a flat map");
        assert!(of([140, 120, 230, 255]), "one that leans");
        for heights in [[128, 128, 128, 255], [255; 4], [0, 0, 0, 255], [0, 0, 255, 255]] {
            assert!(!of(heights), "{heights:?} are heights");
        }
        let large =
            Texels { width: 1000, height: 1, data: TexelData::Linear8(vec![[127, 128, 250, 255]; 1000]) };
        assert!(holds_normals(&large), "every sixteenth texel or so is looked at");
    }
}
