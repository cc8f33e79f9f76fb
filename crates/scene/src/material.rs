// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials as plain data.
//! Source: glTF 2.0 section 3.9 and appendix B (metallic-roughness); Wavefront MTL; \[DWBS03\] for shader slots.
//! Conventions: surfaces scatter on both sides; emission leaves the side of the geometric normal only; colours are linear.

use serde::{Deserialize, Serialize};

use crate::detail::{Anisotropy, DiffuseTransmission, Interior, Iridescence, Subsurface};
use crate::id::MediumId;
use crate::layer_textures::LayerTextures;
use crate::medium::{Medium, Phase};
pub use crate::texture::TextureRef;

/// The appearance of a surface: scattering, emission, opacity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// A label; need not be unique.
    pub name: String,
    /// How it scatters light.
    pub surface: Surface,
    /// The colour of `--force-diffuse` instead of the surface; `None` = see [`Material::diffuse_color`]. Set
    /// where the conversion to `surface` loses the file's diffuse colour: an OBJ mirror keeps its `Kd` here,
    /// even if it is black.
    pub diffuse: Option<Color>,
    /// Radiance that leaves the side of the geometric normal, W·sr⁻¹·m⁻², times `emission_texture`.
    pub emission: [f32; 3],
    /// Multiplied to `emission`.
    pub emission_texture: Option<TextureRef>,
    /// Where it lets light straight through.
    pub alpha: Alpha,
    /// Heights that bend its normals.
    pub bump: Option<BumpMap>,
    /// The medium behind it, if the surface closes a body; else the interior of its glass, if it has any.
    pub medium: Option<MediumId>,
}

/// A linear colour, multiplied by a texture where there is one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Color {
    /// Linear red, green and blue, usually in `[0, 1]`.
    pub factor: [f32; 3],
    /// Multiplied to `factor`.
    pub texture: Option<TextureRef>,
}

impl Color {
    /// A colour without a texture.
    #[must_use]
    pub fn constant(factor: [f32; 3]) -> Self {
        Self { factor, texture: None }
    }
}

/// Albedo of a mesh whose file names no material.
pub(crate) const DEFAULT_ALBEDO: f32 = 0.6;

/// Scattering models.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Surface {
    /// Lambertian reflector.
    Matte {
        /// Albedo.
        base_color: Color,
    },
    /// glTF's metal and plastic.
    MetallicRoughness {
        /// Albedo of the dielectric part, normal reflectance of the metal part.
        base_color: Color,
        /// 0 = dielectric, 1 = metal.
        metallic: f32,
        /// Perceptual roughness in `[0, 1]`; alpha = roughness².
        roughness: f32,
        /// Green times roughness, blue times metallic.
        metallic_roughness_texture: Option<TextureRef>,
        /// Index of refraction of the dielectric part, glTF's default is 1.5.
        ior: f32,
        /// Tangent-space normals: red, green along the texture's u and v.
        normal_texture: Option<NormalMap>,
    },
    /// glTF's metal and plastic with its extensions.
    Principled(Box<Principled>),
    /// Rough diffuse reflector.
    RoughMatte {
        /// Albedo.
        base_color: Color,
        /// In `[0, 1]`; 0 is a Lambertian reflector.
        roughness: f32,
    },
    /// Metal by its complex index of refraction.
    Metal {
        /// Index of refraction per channel, > 0.
        eta: [f32; 3],
        /// Extinction coefficient per channel, >= 0.
        k: [f32; 3],
        /// Perceptual roughness in `[0, 1]`.
        roughness: f32,
    },
    /// Rough glass; the geometric normal points out of it.
    RoughDielectric {
        /// Index of refraction inside over outside, > 0.
        ior: f32,
        /// Perceptual roughness in `[0, 1]`.
        roughness: f32,
        /// Tint of the reflection.
        reflectance: [f32; 3],
        /// Tint of the transmission.
        transmittance: [f32; 3],
        /// Whether it is a pane that does not bend light, and has no inside.
        thin: bool,
        /// The interior.
        interior: Interior,
    },
    /// Perfect mirror.
    Mirror {
        /// Reflectance.
        reflectance: Color,
    },
    /// Smooth glass; the geometric normal points out of it.
    Dielectric {
        /// Index of refraction inside over outside, > 0.
        ior: f32,
        /// Tint of the reflection.
        reflectance: [f32; 3],
        /// Tint of the transmission.
        transmittance: [f32; 3],
        /// The interior.
        interior: Interior,
    },
    /// A Lambertian floor that only catches shadow: where it is unshadowed, it shows the background, so that
    /// it is invisible. In pictures with opacity, its opacity is the relative darkening by shadow.
    ShadowCatcher {
        /// Albedo.
        albedo: [f32; 3],
        /// The background, and the radiance of the floor where all light of the environment reaches it:
        /// albedo times irradiance over pi.
        radiance: [f32; 3],
    },
    /// A colour that is seen as it is, from both sides, and lights nothing: KHR_materials_unlit.
    Unlit {
        /// Radiance, W·sr⁻¹·m⁻², times the mesh's colours.
        color: Color,
    },
    /// A shader of the renderer's shader table; the number is its index there.
    Shader(u32),
}

impl Surface {
    /// Albedo or normal reflectance; black for glass and for shaders.
    #[must_use]
    pub fn base_color(&self) -> Color {
        match self {
            Self::Matte { base_color } | Self::MetallicRoughness { base_color, .. } => *base_color,
            Self::RoughMatte { base_color, .. } => *base_color,
            Self::Principled(principled) => principled.base_color,
            Self::ShadowCatcher { albedo, .. } => Color::constant(*albedo),
            Self::Mirror { reflectance } => *reflectance,
            Self::Unlit { color } => *color,
            Self::Metal { eta, k, .. } => Color::constant(std::array::from_fn(|c| {
                let (less, more) = ((eta[c] - 1.0).powi(2), (eta[c] + 1.0).powi(2));
                (less + k[c] * k[c]) / (more + k[c] * k[c])
            })),
            Self::Dielectric { .. } | Self::RoughDielectric { .. } | Self::Shader(_) => {
                Color::constant([0.0; 3])
            }
        }
    }

    /// glTF's metal and plastic, with or without its extensions, as the form with all of them; `None` for other models.
    #[must_use]
    pub fn layered(&self) -> Option<Principled> {
        match self {
            Self::Principled(principled) => Some((**principled).clone()),
            Self::MetallicRoughness {
                base_color,
                metallic,
                roughness,
                metallic_roughness_texture,
                ior,
                normal_texture,
            } => Some(Principled {
                base_color: *base_color,
                metallic: *metallic,
                roughness: *roughness,
                metallic_roughness_texture: *metallic_roughness_texture,
                ior: *ior,
                normal_texture: *normal_texture,
                ..Principled::default()
            }),
            _ => None,
        }
    }
}

/// glTF's metal and plastic with its extensions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Principled {
    /// Albedo of the dielectric part, tint of its glass, normal reflectance of the metal part.
    pub base_color: Color,
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Perceptual roughness in `[0, 1]`.
    pub roughness: f32,
    /// Green times roughness, blue times metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normals.
    pub normal_texture: Option<NormalMap>,
    /// KHR_materials_ior: index of refraction of the dielectric part.
    pub ior: f32,
    /// KHR_materials_specular: multiplied to the dielectric part's reflectance, in `[0, 1]`.
    pub specular: f32,
    /// KHR_materials_specular: colour of that reflectance at normal incidence.
    pub specular_color: [f32; 3],
    /// KHR_materials_clearcoat: how much of it there is, in `[0, 1]`.
    pub clearcoat: f32,
    /// KHR_materials_clearcoat: its perceptual roughness.
    pub clearcoat_roughness: f32,
    /// KHR_materials_sheen: its colour; black = none.
    pub sheen_color: [f32; 3],
    /// KHR_materials_sheen: its perceptual roughness.
    pub sheen_roughness: f32,
    /// KHR_materials_transmission: share of the dielectric part's body that is glass, in `[0, 1]`.
    pub transmission: f32,
    /// Whether that glass is a pane that does not bend light, as it is without KHR_materials_volume.
    pub thin: bool,
    /// KHR_materials_volume and KHR_materials_dispersion: the interior of that glass, unless it is thin.
    pub interior: Interior,
    /// KHR_materials_anisotropy, of plastic, metal and glass.
    pub anisotropy: Anisotropy,
    /// KHR_materials_iridescence, on plastic, metal and glass.
    pub iridescence: Iridescence,
    /// KHR_materials_diffuse_transmission, of the dielectric part's body.
    pub diffuse_transmission: DiffuseTransmission,
    /// Light below the surface, of the dielectric part's body.
    pub subsurface: Subsurface,
    /// Textures of the layers.
    pub layer_textures: LayerTextures<TextureRef>,
}

impl Default for Principled {
    /// glTF's defaults: a white rough metal without layers.
    fn default() -> Self {
        Self {
            base_color: Color::constant([1.0; 3]),
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            ior: 1.5,
            specular: 1.0,
            specular_color: [1.0; 3],
            clearcoat: 0.0,
            clearcoat_roughness: 0.0,
            sheen_color: [0.0; 3],
            sheen_roughness: 0.0,
            transmission: 0.0,
            thin: true,
            interior: Interior::default(),
            anisotropy: Anisotropy::default(),
            iridescence: Iridescence::default(),
            diffuse_transmission: DiffuseTransmission::default(),
            subsurface: Subsurface::default(),
            layer_textures: LayerTextures::default(),
        }
    }
}

/// The meaning of a texture's values to the material that reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureRole {
    /// Colours: bytes are sRGB.
    Color,
    /// Heights, normals, roughness, opacity: bytes are linear.
    Data,
}

/// A normal map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NormalMap {
    /// Tangent-space normals, `2 texel - 1`.
    pub texture: TextureRef,
    /// Multiplied to x and y of the normal.
    pub scale: f32,
}

/// A bump map: heights that bend normals and leave the surface unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BumpMap {
    /// Heights, by their luminance; bytes are linear.
    pub texture: TextureRef,
    /// Height of white above black, in widths of a texel: 1 makes a step from black to white within one texel
    /// a slope of 45 degrees, at any size of the texture on the surface. Below zero: white is a hollow.
    pub height: f32,
}

/// Where a surface is not there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Alpha {
    /// There everywhere.
    #[default]
    Opaque,
    /// There where the opacity (factor times texture's alpha) reaches the cutoff.
    Mask {
        /// Smallest opacity that is there.
        cutoff: f32,
        /// Opacity.
        opacity: Opacity,
    },
    /// Opaque for the fraction of light given by the opacity.
    Blend {
        /// Opacity.
        opacity: Opacity,
    },
}

/// Opacity in `[0, 1]`: a factor, times a channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Opacity {
    /// Multiplied to the texture's value.
    pub factor: f32,
    /// Its texture.
    pub texture: Option<TextureRef>,
    /// Which channel of the texture holds it.
    pub channel: OpacityChannel,
}

/// Where a texture keeps opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum OpacityChannel {
    /// In its alpha (glTF base colour).
    Alpha,
    /// In its red (OBJ's `map_d`).
    Red,
}

impl Material {
    /// A Lambertian reflector.
    #[must_use]
    pub fn matte(name: impl Into<String>, albedo: [f32; 3]) -> Self {
        Self::of(name, Surface::Matte { base_color: Color::constant(albedo) })
    }

    /// A material that scatters like `surface`, gives off nothing and is there everywhere.
    #[must_use]
    pub fn of(name: impl Into<String>, surface: Surface) -> Self {
        Self {
            name: name.into(),
            surface,
            diffuse: None,
            emission: [0.0; 3],
            emission_texture: None,
            alpha: Alpha::Opaque,
            bump: None,
            medium: None,
        }
    }

    /// The albedo of the Lambertian reflector that `--force-diffuse` makes of it: `diffuse`, or else the surface's base
    /// colour; black for glass and for shaders.
    #[must_use]
    pub fn diffuse_color(&self) -> Color {
        self.diffuse.unwrap_or(self.surface.base_color())
    }

    /// All textures that it reads, with the meaning of their values. A texture that is read twice occurs
    /// twice.
    pub fn textures(&self) -> impl Iterator<Item = (TextureRef, TextureRole)> + use<> {
        use TextureRole::{Color as Colors, Data};
        let base = self.surface.base_color().texture;
        let [clamped_roughness, normals, brushed] = match &self.surface {
            Surface::MetallicRoughness { metallic_roughness_texture, normal_texture, .. } => {
                [*metallic_roughness_texture, normal_texture.map(|map| map.texture), None]
            }
            Surface::Principled(p) => {
                let normals = p.normal_texture.map(|map| map.texture);
                [p.metallic_roughness_texture, normals, p.anisotropy.texture]
            }
            _ => [None; 3],
        };
        let (opacity, of_opacity) = match self.alpha {
            Alpha::Opaque => (None, Data),
            Alpha::Mask { opacity, .. } | Alpha::Blend { opacity } => match opacity.channel {
                OpacityChannel::Alpha => (opacity.texture, Colors),
                OpacityChannel::Red => (opacity.texture, Data),
            },
        };
        let all = [
            (base, Colors),
            (self.diffuse.and_then(|diffuse| diffuse.texture), Colors),
            (self.emission_texture, Colors),
            (opacity, of_opacity),
            (clamped_roughness, Data),
            (normals, Data),
            (brushed, Data),
            (self.bump.map(|bump| bump.texture), Data),
        ];
        let layers = match &self.surface {
            Surface::Principled(p) => p.layer_textures,
            _ => LayerTextures::default(),
        };
        let of_layers = layers.colors().map(|texture| (texture, Colors));
        let of_layers = of_layers.chain(layers.data().map(|texture| (texture, Data)));
        all.into_iter().filter_map(|(texture, role)| Some((texture?, role))).chain(of_layers)
    }

    /// The interior of its glass, or of its translucent body; `None` if it is thin or opaque.
    #[must_use]
    pub fn interior(&self) -> Option<&Interior> {
        match &self.surface {
            Surface::Dielectric { interior, .. } | Surface::RoughDielectric { interior, thin: false, .. } => {
                Some(interior)
            }
            Surface::Principled(p)
                if !p.thin && (p.transmission > 0.0 || p.diffuse_transmission.factor > 0.0) =>
            {
                Some(&p.interior)
            }
            _ => None,
        }
    }

    /// Whether light is scattered behind it by its interior.
    #[must_use]
    pub fn scatters_within(&self) -> bool {
        self.interior().is_some_and(|interior| interior.scattering() != [0.0; 3])
    }

    /// The medium of its interior; `None` if that is clear.
    #[must_use]
    pub fn interior_medium(&self) -> Option<Medium> {
        let interior = self.interior()?;
        let (extinction, scattering) = (interior.absorption(), interior.scattering());
        (extinction != [0.0; 3]).then(|| Medium {
            name: self.name.clone(),
            absorption: std::array::from_fn(|c| extinction[c] - scattering[c]),
            scattering,
            phase: Phase { anisotropy: interior.anisotropy(), ..Phase::default() },
            ..Medium::default()
        })
    }

    /// An invisible boundary of a medium: light goes straight through.
    #[must_use]
    pub fn boundary(name: impl Into<String>, medium: MediumId) -> Self {
        let nothing = Opacity { factor: 0.0, texture: None, channel: OpacityChannel::Alpha };
        let alpha = Alpha::Blend { opacity: nothing };
        Self { alpha, medium: Some(medium), ..Self::matte(name, [0.0; 3]) }
    }

    /// Whether it gives off light anywhere.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&e| e > 0.0)
    }
}
