// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF materials and their textures.
//! Source: glTF 2.0 section 3.9; KHR_materials_{clearcoat, emissive_strength, ior, sheen, specular, transmission, unlit},
//! KHR_texture_transform.
//!
//! Textures of these extensions are not shown, and say so. A specular factor of 0 without metal makes a surface matte.
//! Unlit surfaces shine with their base colour and scatter nothing. Smooth surfaces that let through all light that they
//! do not mirror are solid glass, tinted by the base colour; other glass is a pane unless KHR_materials_volume gives it
//! a thickness. glTF's v runs downwards, ours upwards: [`uv_from_mesh`].
//! Proof: `tests/gltf.rs::{materials_become_ours, texture_transforms_agree_with_the_extension}`.

use std::collections::HashMap;
use std::sync::Arc;

use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::AlphaMode;
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{self, Index};
use serde_json::Value;

use super::base64::data_uri;
use super::document::Document;
use crate::id::{MaterialId, TextureId};
use crate::io::textures::{Meaning, Pictures};
use crate::io::{Oddity, Warnings, source};
use crate::material::{
    Alpha, Color, Material, NormalMap, Opacity, OpacityChannel, Principled, Surface, TextureRef,
};
use crate::scene::Scene;
use crate::texture::{Filter, Texels, Texture, Wrap};

/// Below this roughness glass is smooth.
const GLASS_ROUGHNESS: f32 = 0.05;
/// From this factor on all light goes through.
const CLEAR: f32 = 0.99;

/// A material of the scene, and which texture coordinates of the mesh it reads.
#[derive(Clone, Copy)]
pub(super) struct AddedMaterial {
    pub(super) id: MaterialId,
    pub(super) texcoord_set: u32,
}

/// Adds the materials of the document and, last, the default one.
pub(super) fn add_all(document: &Document, scene: &mut Scene, warnings: &mut Warnings) -> Vec<AddedMaterial> {
    let default = json::Material::default();
    let materials = document.root.materials.iter().chain([&default]);
    let mut textures = Textures::default();
    let mut added = Vec::new();
    for (i, material) in materials.enumerate() {
        let mut converter =
            Converter { document, scene, textures: &mut textures, warnings, texcoord_set: None };
        let converted = converter.material(i, material);
        let texcoord_set = converter.texcoord_set.unwrap_or(0);
        added.push(AddedMaterial { id: scene.add_material(converted), texcoord_set });
    }
    added
}

struct Converter<'a> {
    document: &'a Document,
    scene: &'a mut Scene,
    textures: &'a mut Textures,
    warnings: &'a mut Warnings,
    /// Set of texture coordinates that the first texture reads.
    texcoord_set: Option<u32>,
}

impl Converter<'_> {
    fn material(&mut self, i: usize, from: &json::Material) -> Material {
        let pbr = &from.pbr_metallic_roughness;
        let extensions = from.extensions.as_ref();
        let [r, g, b, a] = pbr.base_color_factor.0;
        let base_texture = self.info(pbr.base_color_texture.as_ref(), Meaning::Color);
        let base_color = Color { factor: [r, g, b].map(positive), texture: base_texture };
        let strength =
            extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |s| s.emissive_strength.0);
        let opacity = Opacity { factor: a, texture: base_texture, channel: OpacityChannel::Alpha };
        let mut material = Material {
            emission: from.emissive_factor.0.map(|e| positive(e * strength)),
            emission_texture: self.info(from.emissive_texture.as_ref(), Meaning::Color),
            alpha: match from.alpha_mode.as_ref() {
                Checked::Valid(AlphaMode::Mask) => {
                    Alpha::Mask { cutoff: from.alpha_cutoff.map_or(0.5, |c| c.0), opacity }
                }
                Checked::Valid(AlphaMode::Blend) => Alpha::Blend { opacity },
                _ => Alpha::Opaque,
            },
            ..Material::of(self.name(i, from), Surface::Matte { base_color })
        };
        if extensions.is_some_and(|e| e.unlit.is_some()) {
            material.emission = base_color.factor;
            material.emission_texture = base_texture;
            material.surface = Surface::Matte { base_color: Color::constant([0.0; 3]) };
            material.diffuse = Some(base_color);
            return material;
        }
        let ior = extensions.and_then(|e| e.ior.as_ref()).map_or(1.5, |i| i.ior.0);
        let ior = if ior > 0.0 && ior.is_finite() { ior } else { 1.5 };
        let roughness = pbr.roughness_factor.0.clamp(0.0, 1.0);
        let layers = self.layers(extensions);
        let plain =
            Principled { transmission: layers.transmission, thin: layers.thin, ..Principled::default() };
        if layers == plain && layers.transmission >= CLEAR && roughness < GLASS_ROUGHNESS {
            material.surface =
                Surface::Dielectric { ior, reflectance: [1.0; 3], transmittance: base_color.factor };
            material.diffuse = Some(base_color);
            return material;
        }
        let matte =
            Principled { specular: 0.0, specular_color: layers.specular_color, ..Principled::default() };
        if layers == matte && pbr.metallic_factor.0 == 0.0 && from.normal_texture.is_none() {
            // What neither mirrors nor conducts is Lambertian, as the material is so far.
            return material;
        }
        let metallic = pbr.metallic_factor.0.clamp(0.0, 1.0);
        let metallic_roughness_texture = self.info(pbr.metallic_roughness_texture.as_ref(), Meaning::Data);
        let normal_texture = from.normal_texture.as_ref().and_then(|normal| {
            let texture = self.texture(normal.index, normal.tex_coord, None, Meaning::Data)?;
            Some(NormalMap { texture, scale: normal.scale })
        });
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

    /// What the extensions add, over glTF's defaults for the rest.
    fn layers(&mut self, extensions: Option<&json::extensions::material::Material>) -> Principled {
        let mut to = Principled::default();
        let Some(extensions) = extensions else {
            return to;
        };
        let unit = |x: f32| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
        if let Some(specular) = &extensions.specular {
            to.specular = unit(specular.specular_factor.0);
            to.specular_color = specular.specular_color_factor.0.map(positive);
        }
        to.transmission = extensions.transmission.as_ref().map_or(0.0, |t| unit(t.transmission_factor.0));
        // The crate has no types for these; numbers that are none count as the extension's defaults.
        let other = |name: &str| extensions.others.get(name);
        let number = |value: &Value| value.as_f64().map_or(0.0, |x| unit(x as f32));
        if let Some(coat) = other("KHR_materials_clearcoat") {
            to.clearcoat = number(&coat["clearcoatFactor"]);
            to.clearcoat_roughness = number(&coat["clearcoatRoughnessFactor"]);
        }
        if let Some(sheen) = other("KHR_materials_sheen") {
            to.sheen_color = [0, 1, 2].map(|c| number(&sheen["sheenColorFactor"][c]));
            to.sheen_roughness = number(&sheen["sheenRoughnessFactor"]);
        }
        let volume = other("KHR_materials_volume");
        to.thin = volume.is_none_or(|volume| number(&volume["thicknessFactor"]) == 0.0);
        if to.transmission == 0.0 {
            to.thin = true;
        }
        let textured = ["KHR_materials_clearcoat", "KHR_materials_sheen"].into_iter().find(|name| {
            let is_texture = |key: &String| key.ends_with("Texture");
            other(name).and_then(Value::as_object).is_some_and(|object| object.keys().any(is_texture))
        });
        if let Some(name) = textured {
            self.warnings.note(Oddity::NotShown, &self.document.path, None, format!("textures of {name}"));
        }
        to
    }

    fn name(&self, i: usize, from: &json::Material) -> String {
        let is_default = i == self.document.root.materials.len();
        let unnamed = || if is_default { "default".to_owned() } else { format!("material {i}") };
        from.name.clone().unwrap_or_else(unnamed)
    }

    fn info(&mut self, info: Option<&Info>, meaning: Meaning) -> Option<TextureRef> {
        let info = info?;
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.texture(info.index, info.tex_coord, transform, meaning)
    }

    fn texture(
        &mut self,
        index: Index<json::Texture>,
        texcoord_set: u32,
        transform: Option<&TextureTransform>,
        meaning: Meaning,
    ) -> Option<TextureRef> {
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(texcoord_set);
        let path = &self.document.path;
        if *self.texcoord_set.get_or_insert(set) != set {
            self.warnings.note(
                Oddity::NotShown,
                path,
                None,
                "second set of texture coordinates in one material",
            );
            return None;
        }
        match self.textures.add(self.document, index, meaning, self.scene) {
            Ok(texture) => Some(TextureRef { texture, uv_from_mesh: uv_from_mesh(transform) }),
            Err(why) => {
                self.warnings.note(
                    Oddity::BadTexture,
                    path,
                    None,
                    format!("textures[{}]: {why}", index.value()),
                );
                None
            }
        }
    }
}

fn positive(x: f32) -> f32 {
    if x.is_finite() { x.max(0.0) } else { 0.0 }
}

/// KHR_texture_transform, conjugated by the flip of v: with `v = 1 - w`,
/// `u' = c sx u + s sy v + tx` and `v' = -s sx u + c sy v + ty` become affine in `(u, w)`.
fn uv_from_mesh(transform: Option<&TextureTransform>) -> [f32; 6] {
    let Some(transform) = transform else {
        return [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    };
    let (s, c) = transform.rotation.0.sin_cos();
    let ([sx, sy], [tx, ty]) = (transform.scale.0, transform.offset.0);
    [c * sx, s * sx, -s * sy, c * sy, s * sy + tx, 1.0 - c * sy - ty]
}

/// Textures and pictures that were added already.
#[derive(Default)]
struct Textures {
    added: HashMap<(usize, Meaning), Result<TextureId, String>>,
    embedded: HashMap<(usize, Meaning), Result<Arc<Texels>, String>>,
    pictures: Pictures,
}

impl Textures {
    fn add(
        &mut self,
        document: &Document,
        index: Index<json::Texture>,
        meaning: Meaning,
        scene: &mut Scene,
    ) -> Result<TextureId, String> {
        let key = (index.value(), meaning);
        if let Some(known) = self.added.get(&key) {
            return known.clone();
        }
        let added = self.load(document, index, meaning).map(|texture| scene.add_texture(texture));
        self.added.insert(key, added.clone());
        added
    }

    fn load(
        &mut self,
        document: &Document,
        index: Index<json::Texture>,
        meaning: Meaning,
    ) -> Result<Texture, String> {
        let texture = document.root.get(index).ok_or("does not exist")?;
        let image = document
            .root
            .get(texture.source)
            .ok_or("its image does not exist or needs an unknown extension")?;
        let texels = self.picture(document, texture.source.value(), image, meaning)?;
        let sampler = texture.sampler.and_then(|s| document.root.get(s));
        let wrap = |mode: &Checked<WrappingMode>| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
            _ => Wrap::Repeat,
        };
        let nearest = sampler.is_some_and(|s| s.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
        let external = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
        let name = texture.name.as_deref().or(image.name.as_deref()).or(external);
        Ok(Texture {
            name: name.map_or_else(|| format!("texture {}", index.value()), str::to_owned),
            texels,
            wrap: sampler.map_or([Wrap::Repeat; 2], |s| [wrap(&s.wrap_s), wrap(&s.wrap_t)]),
            filter: if nearest { Filter::Nearest } else { Filter::Linear },
        })
    }

    fn picture(
        &mut self,
        document: &Document,
        index: usize,
        image: &json::Image,
        meaning: Meaning,
    ) -> Result<Arc<Texels>, String> {
        if let Some(uri) = image.uri.as_deref().filter(|uri| !uri.starts_with("data:")) {
            return self.pictures.file(&source::resolve(&document.path, uri), meaning);
        }
        let pictures = &mut self.pictures;
        let load = || match (&image.uri, image.buffer_view) {
            (Some(uri), _) => pictures.decode(&data_uri(uri).ok_or("broken data URI")?, "data URI", meaning),
            (None, Some(view)) => {
                let bytes = document.view(view, "image").map_err(|e| e.problem)?;
                pictures.decode(bytes, "embedded image", meaning)
            }
            (None, None) => Err("an image without data".to_owned()),
        };
        self.embedded.entry((index, meaning)).or_insert_with(load).clone()
    }
}
