// SPDX-License-Identifier: GPL-3.0-or-later
//! Surface shaders of the description's materials. `force_diffuse` replaces each surface by its diffuse
//! colour.
//! Tests: `crates/render/tests/appearance.rs`.

use std::sync::Arc;

use glam::Vec3;
use gnurt_image::Weigh;
use gnurt_scene::material::{Alpha, Color, Opacity, OpacityChannel, Principled, TextureRef};
use gnurt_scene::texture::TexcoordSet;
use gnurt_scene::{Material, Surface, TEXCOORD_1, TextureId};
use gnurt_shading::bsdf::{Film, Principled as Bsdf};
use gnurt_shading::materials as shading;
use gnurt_shading::{AttributeRequest, SurfaceShader};

use super::table::ShaderTable;
use super::textures::Reading;

/// The shader of a material with `emission` and opacity `coverage`; bumps stay unless diffuse surfaces are
/// forced.
pub(super) fn shader(
    from: Reading,
    material: &Material,
    shaders: &ShaderTable,
    force_diffuse: bool,
    emission: Option<shading::Emission>,
    coverage: Option<shading::Coverage>,
) -> Arc<dyn SurfaceShader> {
    let catches = matches!(material.surface, Surface::ShadowCatcher { .. });
    let surface = if force_diffuse && !catches {
        Arc::new(shading::Matte { albedo: color(from, &material.diffuse_color()) })
    } else {
        surface(from, &material.surface, shaders)
    };
    let bump = material.bump.filter(|_| !force_diffuse).map(|bump| shading::BumpMap {
        texture: from.sampler(&bump.texture, Weigh::Alike),
        height: bump.height,
    });
    let attributes = second_texcoords(material);
    if emission.is_none() && coverage.is_none() && bump.is_none() && attributes.is_empty() {
        return surface;
    }
    Arc::new(shading::Material { surface, emission, coverage, bump, attributes })
}

/// The request for the second texture coordinates, if a texture reads them: readers expect it as the first.
fn second_texcoords(material: &Material) -> Vec<AttributeRequest> {
    let reads_them = material.textures().any(|(texture, _)| texture.set == TexcoordSet::Second);
    let request = || AttributeRequest { name: TEXCOORD_1.to_owned(), components: 2, default: vec![0.0; 2] };
    // A shader of its own has requests of its own.
    let is_ours = !matches!(material.surface, Surface::Shader(_));
    (reads_them && is_ours).then(request).into_iter().collect()
}

fn surface(from: Reading, surface: &Surface, shaders: &ShaderTable) -> Arc<dyn SurfaceShader> {
    match surface {
        Surface::Matte { base_color } => Arc::new(shading::Matte { albedo: color(from, base_color) }),
        Surface::MetallicRoughness { ior, .. } => layered(from, surface, *ior),
        Surface::Principled(model) => layered(from, surface, index(model.ior)),
        Surface::RoughMatte { base_color, roughness } => {
            Arc::new(shading::rough_matte(color(from, base_color), roughness.clamp(0.0, 1.0)))
        }
        Surface::Metal { eta, k, roughness } => {
            let (eta, k) = from.map.metal(Vec3::from(*eta).max(Vec3::splat(1e-3)), Vec3::from(*k));
            Arc::new(shading::metal(eta.max(Vec3::splat(1e-3)), k.max(Vec3::ZERO), roughness.clamp(0.0, 1.0)))
        }
        Surface::RoughDielectric { ior, roughness, reflectance, transmittance, thin, interior } => {
            let (ior, tints) = (index(*ior), [reflectance, transmittance].map(|tint| from.color(*tint)));
            let glass = shading::RoughGlass::new(ior, roughness.clamp(0.0, 1.0), tints, *thin);
            Arc::new(glass.with_inside(from.absorption(interior), interior.spread(ior)))
        }
        Surface::Mirror { reflectance } => {
            Arc::new(shading::Mirror { reflectance: color(from, reflectance) })
        }
        Surface::Dielectric { ior, reflectance, transmittance, interior } => Arc::new(shading::Dielectric {
            ior: index(*ior),
            reflectance: from.color(*reflectance),
            transmittance: from.color(*transmittance),
            absorption: from.absorption(interior),
            spread: interior.spread(index(*ior)),
        }),
        Surface::ShadowCatcher { albedo, radiance } => {
            Arc::new(shading::ShadowCatcher { albedo: from.color(*albedo), radiance: from.color(*radiance) })
        }
        Surface::Unlit { color: visible } => Arc::new(shading::Unlit { color: color(from, visible) }),
        Surface::Shader(number) => shaders.surfaces[*number as usize].clone(),
    }
}

/// Metal and plastic, with or without layers.
fn layered(from: Reading, surface: &Surface, ior: f32) -> Arc<dyn SurfaceShader> {
    Arc::new(principled(from, &surface.layered().unwrap_or_default(), ior))
}

/// An index that means nothing bends nothing.
fn index(ior: f32) -> f32 {
    if ior > 0.0 && ior.is_finite() { ior } else { 1.0 }
}

/// The textures of the layers of a surface, if it has any.
fn layer_textures(
    reading: Reading,
    from: &Principled,
    specular_base: Vec3,
) -> Option<Box<shading::LayerTextures>> {
    let maps = &from.layer_textures;
    if maps.is_empty() {
        return None;
    }
    let sampler = |map: Option<TextureRef>| map.as_ref().map(|map| reading.sampler(map, Weigh::Alike));
    let channel = |map: Option<TextureRef>, channel: usize| {
        sampler(map).map(|texture| shading::Channel { texture, channel })
    };
    Some(Box::new(shading::LayerTextures {
        specular: channel(maps.specular, 3),
        specular_color: sampler(maps.specular_color),
        specular_base,
        coat: channel(maps.clearcoat, 0),
        coat_roughness: channel(maps.clearcoat_roughness, 1),
        coat_normals: maps.clearcoat_normal.as_ref().map(|map| shading::NormalMap {
            texture: reading.sampler(map, Weigh::Directions),
            scale: maps.clearcoat_normal_scale,
        }),
        sheen_color: sampler(maps.sheen_color),
        sheen_roughness: channel(maps.sheen_roughness, 3),
        transmission: channel(maps.transmission, 0),
        film: channel(maps.iridescence, 0),
        film_thickness: channel(maps.iridescence_thickness, 1)
            .map(|channel| (channel, from.iridescence.least_thickness)),
        translucence: channel(maps.diffuse_transmission, 3),
        beyond: sampler(maps.diffuse_transmission_color),
        map: reading.map,
    }))
}

fn principled(reading: Reading, from: &Principled, ior: f32) -> shading::MetallicRoughness {
    let textures = &from.layer_textures;
    let plain = Bsdf::new(Vec3::ONE, from.metallic, from.roughness, ior);
    let specular = from.specular.clamp(0.0, 1.0);
    let specular_base = (plain.f0 * Vec3::from(from.specular_color)).max(Vec3::ZERO);
    shading::MetallicRoughness {
        base_color: color(reading, &from.base_color),
        metallic: from.metallic,
        roughness: from.roughness,
        metallic_roughness_texture: from
            .metallic_roughness_texture
            .as_ref()
            .map(|t| reading.sampler(t, Weigh::Alike)),
        ior,
        normal_map: from.normal_texture.as_ref().map(|map| shading::NormalMap {
            texture: reading.sampler(&map.texture, Weigh::Directions),
            scale: map.scale,
        }),
        model: Bsdf {
            f0: reading.map.of(specular_base).min(Vec3::ONE) * specular,
            f90: specular,
            coat: from.clearcoat.clamp(0.0, 1.0),
            coat_alpha: from.clearcoat_roughness * from.clearcoat_roughness,
            sheen: reading.layer(from.sheen_color, textures.sheen_color),
            sheen_roughness: from.sheen_roughness.clamp(0.0, 1.0),
            transmission: from.transmission.clamp(0.0, 1.0),
            thin: from.thin,
            film: Film {
                share: from.iridescence.factor.clamp(0.0, 1.0),
                ior: from.iridescence.ior,
                thickness: from.iridescence.thickness,
            },
            spread: from.interior.spread(ior),
            translucence: from.diffuse_transmission.factor.clamp(0.0, 1.0),
            beyond: reading.layer(from.diffuse_transmission.color, textures.diffuse_transmission_color),
            subsurface: from.subsurface.factor.clamp(0.0, 1.0),
            radius: reading.color(from.subsurface.radius),
            scattering: from.subsurface.anisotropy,
            ..plain
        },
        anisotropy: shading::Anisotropy {
            strength: from.anisotropy.strength,
            rotation: from.anisotropy.rotation,
            texture: from.anisotropy.texture.as_ref().map(|t| reading.sampler(t, Weigh::Alike)),
        },
        absorption: reading.absorption(&from.interior),
        layers: layer_textures(reading, from, specular_base),
    }
}

fn color(from: Reading, color: &Color) -> shading::TexturedColor {
    shading::TexturedColor {
        factor: Vec3::from(color.factor),
        texture: color.texture.as_ref().map(|texture| from.colors(texture)),
        map: from.map,
    }
}

/// The emission of a material, if any.
pub(super) fn emission(from: Reading, material: &Material) -> Option<shading::Emission> {
    material.emits().then(|| {
        let factor = Vec3::from(material.emission).max(Vec3::ZERO);
        match &material.emission_texture {
            Some(texture) => {
                let texture = Some(from.sampler(texture, Weigh::Alike));
                shading::Emission { factor, texture, map: from.map }
            }
            None => shading::Emission::constant(from.map.of(factor)),
        }
    })
}

/// Where a material is there; `None` = everywhere.
pub(super) fn coverage(from: Reading, alpha: &Alpha) -> Option<shading::Coverage> {
    let (opacity, cutoff): (&Opacity, _) = match alpha {
        Alpha::Opaque => return None,
        Alpha::Mask { cutoff, opacity } => (opacity, Some(*cutoff)),
        Alpha::Blend { opacity } => (opacity, None),
    };
    Some(shading::Coverage {
        factor: opacity.factor,
        texture: opacity.texture.as_ref().map(|texture| from.sampler(texture, Weigh::Alike)),
        channel: match opacity.channel {
            OpacityChannel::Alpha => shading::OpacityChannel::Alpha,
            OpacityChannel::Red => shading::OpacityChannel::Red,
        },
        cutoff,
    })
}

/// The texture whose alpha is the opacity of a material.
pub(super) fn opacity_texture(alpha: &Alpha) -> Option<TextureId> {
    match alpha {
        Alpha::Mask { opacity, .. } | Alpha::Blend { opacity }
            if opacity.channel == OpacityChannel::Alpha =>
        {
            opacity.texture.map(|reference| reference.texture)
        }
        _ => None,
    }
}

/// All textures that a material names.
pub(super) fn textures_of(material: &Material) -> impl Iterator<Item = TextureId> {
    material.textures().map(|(reference, _)| reference.texture)
}
