// SPDX-License-Identifier: GPL-3.0-or-later
//! The numbers and textures of a metallic-roughness material, and the material that they make.
//! Source: glTF 2.0 section 3.9 and its extensions. Separate from [`Material`], because the numbers determine
//! which of our surfaces represents them, and because they may change with time. Materials without extensions
//! become metallic-roughness or, where they neither mirror nor conduct, Lambertian; those with specular,
//! clear coat, sheen, transmission and the like become principled. Glass is solid where there is a thickness,
//! else a pane that bends nothing, at every roughness; solid glass that is smooth and lets through all light
//! that it does not mirror is perfectly smooth, tinted by the base colour. glTF's v runs downwards, ours
//! upwards: `uv_from_mesh`.
//! Tests: `tests/gltf.rs::{materials_become_ours, texture_transforms_agree_with_the_extension}`.

use serde::{Deserialize, Serialize};

use crate::detail::{Anisotropy, DiffuseTransmission, Interior, Iridescence};
use crate::id::TextureId;
use crate::layer_textures::LayerTextures;
use crate::material::{
    Alpha, Color, Material, NormalMap, Opacity, OpacityChannel, Principled, Surface, TextureRef,
};
use crate::texture::TexcoordSet;

/// Below this roughness solid glass is perfectly smooth.
const GLASS_ROUGHNESS: f32 = 0.05;
/// From this factor on all light goes through.
const CLEAR: f32 = 0.99;

/// The factors of a glTF material. The defaults are glTF's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Factors {
    /// A label.
    pub name: String,
    /// Linear red, green, blue, and opacity.
    pub base_color: [f32; 4],
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Radiance, times `emission_strength`.
    pub emission: [f32; 3],
    /// KHR_materials_emissive_strength.
    pub emission_strength: f32,
    /// Whether and how the opacity counts.
    pub alpha: AlphaMode,
    /// Smallest opacity that is there.
    pub alpha_cutoff: f32,
    /// KHR_materials_unlit: its colour is seen as it is, nothing lights it.
    pub unlit: bool,
    /// KHR_materials_ior.
    pub ior: f32,
    /// KHR_materials_specular.
    pub specular: f32,
    /// KHR_materials_specular.
    pub specular_color: [f32; 3],
    /// KHR_materials_clearcoat.
    pub clearcoat: f32,
    /// KHR_materials_clearcoat.
    pub clearcoat_roughness: f32,
    /// KHR_materials_sheen.
    pub sheen_color: [f32; 3],
    /// KHR_materials_sheen.
    pub sheen_roughness: f32,
    /// KHR_materials_transmission.
    pub transmission: f32,
    /// KHR_materials_volume: above 0 = solid.
    pub thickness: f32,
    /// KHR_materials_volume: the transmittance over the distance below.
    pub attenuation_color: [f32; 3],
    /// KHR_materials_volume: world units.
    pub attenuation_distance: f32,
    /// KHR_materials_dispersion.
    pub dispersion: f32,
    /// KHR_materials_volume_scatter.
    pub scatter_color: [f32; 3],
    /// KHR_materials_volume_scatter.
    pub scatter_anisotropy: f32,
    /// KHR_materials_anisotropy.
    pub anisotropy: f32,
    /// KHR_materials_anisotropy: radians.
    pub anisotropy_rotation: f32,
    /// KHR_materials_iridescence.
    pub iridescence: f32,
    /// KHR_materials_iridescence.
    pub iridescence_ior: f32,
    /// KHR_materials_iridescence: the greatest, which is that of all without a texture; nanometres.
    pub iridescence_thickness: f32,
    /// KHR_materials_iridescence: where the texture of the thickness is 0; nanometres.
    pub iridescence_least_thickness: f32,
    /// KHR_materials_diffuse_transmission.
    pub diffuse_transmission: f32,
    /// KHR_materials_diffuse_transmission.
    pub diffuse_transmission_color: [f32; 3],
    /// Of the base colour and the opacity.
    pub base_texture: Option<MappedTexture>,
    /// Green times roughness, blue times metallic.
    pub metallic_roughness_texture: Option<MappedTexture>,
    /// Tangent-space normals.
    pub normal_texture: Option<MappedTexture>,
    /// Multiplied to x and y of these normals.
    pub normal_scale: f32,
    /// Direction and strength of the anisotropy.
    pub anisotropy_texture: Option<MappedTexture>,
    /// Multiplied to the emission.
    pub emission_texture: Option<MappedTexture>,
    /// Of the extensions.
    pub layer_textures: LayerTextures<MappedTexture>,
}

/// The use of the opacity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum AlphaMode {
    /// Nothing.
    #[default]
    Opaque,
    /// There or not there.
    Mask,
    /// There for a share of light.
    Blend,
}

/// A texture and how it is moved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MappedTexture {
    /// The texture.
    pub texture: TextureId,
    /// Its transform; `None` = the mesh's coordinates.
    pub transform: Option<TextureTransform>,
    /// The coordinates of the mesh that it reads.
    pub set: TexcoordSet,
}

/// KHR_texture_transform, in glTF's coordinates: v downwards.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextureTransform {
    /// Moved by this, last.
    pub offset: [f32; 2],
    /// Rotation, radians.
    pub rotation: f32,
    /// Scaled by this, first.
    pub scale: [f32; 2],
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] }
    }
}

impl Default for Factors {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            metallic: 1.0,
            roughness: 1.0,
            emission: [0.0; 3],
            emission_strength: 1.0,
            alpha: AlphaMode::Opaque,
            alpha_cutoff: 0.5,
            unlit: false,
            ior: 1.5,
            specular: 1.0,
            specular_color: [1.0; 3],
            clearcoat: 0.0,
            clearcoat_roughness: 0.0,
            sheen_color: [0.0; 3],
            sheen_roughness: 0.0,
            transmission: 0.0,
            thickness: 0.0,
            attenuation_color: [1.0; 3],
            attenuation_distance: f32::INFINITY,
            dispersion: 0.0,
            scatter_color: [0.0; 3],
            scatter_anisotropy: 0.0,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            iridescence: 0.0,
            iridescence_ior: 1.3,
            iridescence_thickness: 400.0,
            iridescence_least_thickness: 100.0,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: [1.0; 3],
            base_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            anisotropy_texture: None,
            emission_texture: None,
            layer_textures: LayerTextures::default(),
        }
    }
}

/// The surfaces that factors may make.
enum Kind {
    Glass(Interior),
    Matte,
    Rough(Box<Principled>),
}

impl Factors {
    /// The values of the extensions, with glTF's defaults for the rest.
    fn layers(&self) -> Principled {
        let transmission = unit(self.transmission);
        Principled {
            specular: unit(self.specular),
            specular_color: self.specular_color.map(positive),
            clearcoat: unit(self.clearcoat),
            clearcoat_roughness: unit(self.clearcoat_roughness),
            sheen_color: self.sheen_color.map(unit),
            sheen_roughness: unit(self.sheen_roughness),
            transmission,
            thin: self.is_thin(),
            interior: self.interior(),
            anisotropy: self.brushed(),
            iridescence: self.film(),
            diffuse_transmission: self.translucence(),
            layer_textures: self.textures_of_layers(),
            ..Principled::default()
        }
    }

    /// Textures of the layers that are there: one that is multiplied to zero has no effect.
    fn textures_of_layers(&self) -> LayerTextures<TextureRef> {
        let mut all = self.layer_textures;
        if unit(self.specular) == 0.0 {
            (all.specular, all.specular_color) = (None, None);
        }
        if unit(self.clearcoat) == 0.0 {
            (all.clearcoat, all.clearcoat_roughness, all.clearcoat_normal) = (None, None, None);
        }
        if unit(self.clearcoat_roughness) == 0.0 {
            all.clearcoat_roughness = None;
        }
        if all.clearcoat_normal.is_none() {
            all.clearcoat_normal_scale = 1.0;
        }
        if self.sheen_color.map(unit) == [0.0; 3] {
            (all.sheen_color, all.sheen_roughness) = (None, None);
        }
        if unit(self.sheen_roughness) == 0.0 {
            all.sheen_roughness = None;
        }
        if unit(self.transmission) == 0.0 {
            all.transmission = None;
        }
        if unit(self.iridescence) == 0.0 {
            (all.iridescence, all.iridescence_thickness) = (None, None);
        }
        if unit(self.diffuse_transmission) == 0.0 {
            (all.diffuse_transmission, all.diffuse_transmission_color) = (None, None);
        }
        all.map(MappedTexture::reference)
    }

    /// Whether all glass of the material is thin.
    fn is_thin(&self) -> bool {
        // Light enters a body that scatters within by diffuse transmission, too.
        let is_waxy = unit(self.diffuse_transmission) > 0.0 && self.scatter_color.iter().any(|&c| c > 0.0);
        unit(self.transmission) == 0.0 && !is_waxy || positive(self.thickness) == 0.0
    }

    /// The interior of the body; the default for materials that light does not enter.
    fn interior(&self) -> Interior {
        if self.is_thin() {
            return Interior::default();
        }
        let distance = self.attenuation_distance;
        Interior {
            attenuation_color: self.attenuation_color.map(unit),
            attenuation_distance: if distance > 0.0 { distance } else { f32::INFINITY },
            dispersion: positive(self.dispersion),
            scatter_color: self.scatter_color.map(unit),
            scatter_anisotropy: self.scatter_anisotropy,
        }
    }

    fn brushed(&self) -> Anisotropy {
        match unit(self.anisotropy) {
            0.0 => Anisotropy::default(),
            strength => Anisotropy {
                strength,
                rotation: if self.anisotropy_rotation.is_finite() { self.anisotropy_rotation } else { 0.0 },
                texture: self.anisotropy_texture.map(|t| t.reference()),
            },
        }
    }

    fn film(&self) -> Iridescence {
        match unit(self.iridescence) {
            0.0 => Iridescence::default(),
            factor => Iridescence {
                factor,
                ior: if self.iridescence_ior >= 1.0 && self.iridescence_ior.is_finite() {
                    self.iridescence_ior
                } else {
                    1.3
                },
                thickness: positive(self.iridescence_thickness),
                least_thickness: positive(self.iridescence_least_thickness),
            },
        }
    }

    fn translucence(&self) -> DiffuseTransmission {
        match unit(self.diffuse_transmission) {
            0.0 => DiffuseTransmission::default(),
            factor => DiffuseTransmission { factor, color: self.diffuse_transmission_color.map(unit) },
        }
    }

    /// `has_normals`: whether a normal map is used.
    fn kind(&self, has_normals: bool) -> Kind {
        let layers = self.layers();
        let plain = Principled {
            transmission: layers.transmission,
            thin: layers.thin,
            interior: layers.interior,
            ..Principled::default()
        };
        let is_clear =
            layers.transmission >= CLEAR && self.clamped_roughness() < GLASS_ROUGHNESS && !layers.thin;
        if layers == plain && is_clear {
            return Kind::Glass(layers.interior);
        }
        let matte =
            Principled { specular: 0.0, specular_color: layers.specular_color, ..Principled::default() };
        if layers == matte && self.metallic == 0.0 && !has_normals {
            return Kind::Matte;
        }
        Kind::Rough(Box::new(layers))
    }

    /// Roughness that can be.
    fn clamped_roughness(&self) -> f32 {
        self.roughness.clamp(0.0, 1.0)
    }

    /// Whether textures of roughness and normals are used, if there were one of normals.
    #[must_use]
    pub fn reads_roughness_textures(&self, has_normals: bool) -> bool {
        !self.unlit && matches!(self.kind(has_normals), Kind::Rough(_))
    }

    /// The material.
    #[must_use]
    pub fn material(&self) -> Material {
        let [r, g, b, a] = self.base_color;
        let mapped = |texture: Option<MappedTexture>| texture.map(|t| t.reference());
        let base_texture = mapped(self.base_texture);
        let base_color = Color { factor: [r, g, b].map(positive), texture: base_texture };
        let opacity = Opacity { factor: a, texture: base_texture, channel: OpacityChannel::Alpha };
        let mut material = Material {
            emission: self.emission.map(|e| positive(e * self.emission_strength)),
            emission_texture: mapped(self.emission_texture),
            alpha: match self.alpha {
                AlphaMode::Mask => Alpha::Mask { cutoff: self.alpha_cutoff, opacity },
                AlphaMode::Blend => Alpha::Blend { opacity },
                AlphaMode::Opaque => Alpha::Opaque,
            },
            ..Material::of(&self.name[..], Surface::Matte { base_color })
        };
        if self.unlit {
            material.surface = Surface::Unlit { color: base_color };
            material.emission = [0.0; 3];
            material.emission_texture = None;
            return material;
        }
        let ior = if self.ior > 0.0 && self.ior.is_finite() { self.ior } else { 1.5 };
        let layers = match self.kind(self.normal_texture.is_some()) {
            Kind::Glass(interior) => {
                material.surface = Surface::Dielectric {
                    ior,
                    reflectance: [1.0; 3],
                    transmittance: base_color.factor,
                    interior,
                };
                material.diffuse = Some(base_color);
                return material;
            }
            // A material that neither mirrors nor conducts is Lambertian, as it is so far.
            Kind::Matte => return material,
            Kind::Rough(layers) => *layers,
        };
        let roughness = self.clamped_roughness();
        let metallic = self.metallic.clamp(0.0, 1.0);
        let metallic_roughness_texture = mapped(self.metallic_roughness_texture);
        let normal_texture =
            mapped(self.normal_texture).map(|texture| NormalMap { texture, scale: self.normal_scale });
        material.surface = if layers == Principled::default() {
            Surface::MetallicRoughness {
                base_color,
                metallic,
                roughness,
                metallic_roughness_texture,
                ior,
                normal_texture,
            }
        } else {
            Surface::Principled(Box::new(Principled {
                base_color,
                metallic,
                roughness,
                metallic_roughness_texture,
                ior,
                normal_texture,
                ..layers
            }))
        };
        material
    }
}

impl MappedTexture {
    fn reference(self) -> TextureRef {
        TextureRef { texture: self.texture, uv_from_mesh: uv_from_mesh(self.transform), set: self.set }
    }
}

fn unit(x: f32) -> f32 {
    if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 }
}

fn positive(x: f32) -> f32 {
    if x.is_finite() { x.max(0.0) } else { 0.0 }
}

/// KHR_texture_transform, conjugated by the flip of v: with `v = 1 - w`,
/// `u' = c sx u + s sy v + tx` and `v' = -s sx u + c sy v + ty` become affine in `(u, w)`.
fn uv_from_mesh(transform: Option<TextureTransform>) -> [f32; 6] {
    let Some(transform) = transform else {
        return [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    };
    let (s, c) = transform.rotation.sin_cos();
    let ([sx, sy], [tx, ty]) = (transform.scale, transform.offset);
    [c * sx, s * sx, -s * sy, c * sy, s * sy + tx, 1.0 - c * sy - ty]
}
