// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF materials and their textures.
//! Source: glTF 2.0 section 3.9; KHR_materials_{clearcoat, emissive_strength, ior, sheen, specular, transmission, unlit},
//! KHR_texture_transform.
//!
//! Textures of these extensions are not shown, and say so. A specular factor of 0 without metal makes a surface matte.
//! Unlit surfaces shine with their base colour and scatter nothing. Glass is solid where KHR_materials_volume gives it a
//! thickness, else a pane that bends nothing, at every roughness; solid glass that is smooth and lets through all light that it
//! does not mirror is perfectly smooth, tinted by the base colour. glTF's v runs downwards, ours upwards: [`uv_from_mesh`].
//! Proof: `tests/gltf.rs::{materials_become_ours, texture_transforms_agree_with_the_extension,
//! tangents_come_with_normal_maps}`.

use std::collections::HashMap;
use std::sync::Arc;

use super::base64::data_uri;
use super::document::Document;
use super::json::{self, Index, TextureInfo, TextureTransform};
use crate::id::{MaterialId, TextureId};
use crate::io::textures::{Meaning, Pictures};
use crate::io::{Error, Oddity, Warnings, source};
use crate::material::{
    Alpha, Color, Material, NormalMap, Opacity, OpacityChannel, Principled, Surface, TextureRef,
};
use crate::scene::Scene;
use crate::texture::{Filter, Texels, Texture, Wrap};

/// Below this roughness solid glass is perfectly smooth.
const GLASS_ROUGHNESS: f32 = 0.05;
/// From this factor on all light goes through.
const CLEAR: f32 = 0.99;

/// A material of the scene, and which texture coordinates of the mesh it reads.
#[derive(Clone, Copy)]
pub(super) struct AddedMaterial {
    pub(super) id: MaterialId,
    pub(super) texcoord_set: u32,
    pub(super) has_normal_map: bool,
}

/// Bytes that a material of the scene takes beside its name.
const MATERIAL_BYTES: usize = size_of::<Material>() + size_of::<Principled>() + 64;
/// Bytes that a texture of the scene takes beside its name and its texels.
const TEXTURE_BYTES: usize = 256;

/// Adds the materials of the document and, last, the default one.
pub(super) fn add_all(
    document: &Document<'_>,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<Vec<AddedMaterial>, Error> {
    let count = document.root.materials.len();
    document.hold(count * (MATERIAL_BYTES + size_of::<AddedMaterial>()), "materials")?;
    let mut textures = Textures::new(document);
    let mut added = Vec::with_capacity(count + 1);
    for i in 0..=count {
        let place = format!("materials[{i}]");
        let material = match document.root.materials.get(i) {
            Some(piece) => document.read(piece, &place)?,
            None => json::Material { name: Some("default".into()), ..json::Material::default() },
        };
        document.hold(material.name.as_ref().map_or(0, String::len), &place)?;
        let mut converter =
            Converter { document, scene, textures: &mut textures, warnings, texcoord_set: None };
        let converted = converter.material(i, &material);
        let texcoord_set = converter.texcoord_set.unwrap_or(0);
        let has_normal_map = match &converted.surface {
            Surface::MetallicRoughness { normal_texture, .. } => normal_texture.is_some(),
            Surface::Principled(principled) => principled.normal_texture.is_some(),
            _ => false,
        };
        added.push(AddedMaterial { id: scene.add_material(converted), texcoord_set, has_normal_map });
    }
    Ok(added)
}

struct Converter<'a, 't> {
    document: &'a Document<'a>,
    scene: &'a mut Scene,
    textures: &'a mut Textures<'t>,
    warnings: &'a mut Warnings,
    /// Set of texture coordinates that the first texture reads.
    texcoord_set: Option<u32>,
}

impl Converter<'_, '_> {
    fn material(&mut self, i: usize, from: &json::Material<'_>) -> Material {
        let pbr = &from.pbr_metallic_roughness;
        let extensions = &from.extensions;
        let [r, g, b, a] = pbr.base_color_factor;
        let base_texture = self.info(pbr.base_color_texture.as_ref(), Meaning::Color);
        let base_color = Color { factor: [r, g, b].map(positive), texture: base_texture };
        let strength = extensions.emissive_strength.as_ref().map_or(1.0, |s| s.emissive_strength);
        let opacity = Opacity { factor: a, texture: base_texture, channel: OpacityChannel::Alpha };
        let mut material = Material {
            emission: from.emissive_factor.map(|e| positive(e * strength)),
            emission_texture: self.info(from.emissive_texture.as_ref(), Meaning::Color),
            alpha: match &*from.alpha_mode {
                "MASK" => Alpha::Mask { cutoff: from.alpha_cutoff, opacity },
                "BLEND" => Alpha::Blend { opacity },
                _ => Alpha::Opaque,
            },
            ..Material::of(self.name(i, from), Surface::Matte { base_color })
        };
        if extensions.unlit.is_some() {
            material.emission = base_color.factor;
            material.emission_texture = base_texture;
            material.surface = Surface::Matte { base_color: Color::constant([0.0; 3]) };
            material.diffuse = Some(base_color);
            return material;
        }
        let ior = extensions.ior.as_ref().map_or(1.5, |i| i.ior);
        let ior = if ior > 0.0 && ior.is_finite() { ior } else { 1.5 };
        let roughness = pbr.roughness_factor.clamp(0.0, 1.0);
        let layers = self.layers(extensions);
        let plain =
            Principled { transmission: layers.transmission, thin: layers.thin, ..Principled::default() };
        let is_clear = layers.transmission >= CLEAR && roughness < GLASS_ROUGHNESS && !layers.thin;
        if layers == plain && is_clear {
            material.surface =
                Surface::Dielectric { ior, reflectance: [1.0; 3], transmittance: base_color.factor };
            material.diffuse = Some(base_color);
            return material;
        }
        let matte =
            Principled { specular: 0.0, specular_color: layers.specular_color, ..Principled::default() };
        if layers == matte && pbr.metallic_factor == 0.0 && from.normal_texture.is_none() {
            // What neither mirrors nor conducts is Lambertian, as the material is so far.
            return material;
        }
        let metallic = pbr.metallic_factor.clamp(0.0, 1.0);
        let metallic_roughness_texture = self.info(pbr.metallic_roughness_texture.as_ref(), Meaning::Data);
        let normal_texture = from.normal_texture.as_ref().and_then(|normal| {
            Some(NormalMap { texture: self.info(Some(normal), Meaning::Data)?, scale: normal.scale })
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
    fn layers(&mut self, extensions: &json::MaterialExtensions) -> Principled {
        let mut to = Principled::default();
        let unit = |x: f32| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
        let mut textured = Vec::new();
        if let Some(specular) = &extensions.specular {
            to.specular = unit(specular.specular_factor);
            to.specular_color = specular.specular_color_factor.map(positive);
            if specular.specular_texture.is_some() || specular.specular_color_texture.is_some() {
                textured.push("KHR_materials_specular");
            }
        }
        if let Some(transmission) = &extensions.transmission {
            to.transmission = unit(transmission.transmission_factor);
            if transmission.transmission_texture.is_some() {
                textured.push("KHR_materials_transmission");
            }
        }
        if let Some(coat) = &extensions.clearcoat {
            to.clearcoat = unit(coat.clearcoat_factor);
            to.clearcoat_roughness = unit(coat.clearcoat_roughness_factor);
            let textures =
                [coat.clearcoat_texture, coat.clearcoat_roughness_texture, coat.clearcoat_normal_texture];
            if textures.iter().any(Option::is_some) {
                textured.push("KHR_materials_clearcoat");
            }
        }
        if let Some(sheen) = &extensions.sheen {
            to.sheen_color = sheen.sheen_color_factor.map(unit);
            to.sheen_roughness = unit(sheen.sheen_roughness_factor);
            if sheen.sheen_color_texture.is_some() || sheen.sheen_roughness_texture.is_some() {
                textured.push("KHR_materials_sheen");
            }
        }
        to.thin = extensions.volume.as_ref().is_none_or(|volume| unit(volume.thickness_factor) == 0.0);
        if to.transmission == 0.0 {
            to.thin = true;
        }
        for name in textured {
            self.warnings.note(Oddity::NotShown, &self.document.path, None, format!("textures of {name}"));
        }
        to
    }

    fn name(&self, i: usize, from: &json::Material<'_>) -> String {
        from.name.clone().unwrap_or_else(|| format!("material {i}"))
    }

    fn info(&mut self, info: Option<&TextureInfo>, meaning: Meaning) -> Option<TextureRef> {
        let info = info?;
        self.texture(info.index, info.tex_coord, info.extensions.transform.as_ref(), meaning)
    }

    fn texture(
        &mut self,
        index: Index,
        texcoord_set: Index,
        transform: Option<&TextureTransform>,
        meaning: Meaning,
    ) -> Option<TextureRef> {
        let Index(set) = transform.and_then(|t| t.tex_coord).unwrap_or(texcoord_set);
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
        match self.textures.add(index, meaning, self.scene) {
            Ok(texture) => Some(TextureRef { texture, uv_from_mesh: uv_from_mesh(transform) }),
            Err(why) => {
                self.warnings.note(Oddity::BadTexture, path, None, format!("textures[{}]: {why}", index.0));
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
    let (s, c) = transform.rotation.sin_cos();
    let ([sx, sy], [tx, ty]) = (transform.scale, transform.offset);
    [c * sx, s * sx, -s * sy, c * sy, s * sy + tx, 1.0 - c * sy - ty]
}

/// Textures and pictures that were added already.
struct Textures<'a> {
    document: &'a Document<'a>,
    added: HashMap<(Index, Meaning), Result<TextureId, String>>,
    embedded: HashMap<(Index, Meaning), Result<Arc<Texels>, String>>,
    pictures: Pictures<'a>,
}

impl<'a> Textures<'a> {
    fn new(document: &'a Document<'a>) -> Self {
        let pictures = Pictures::new(document.access);
        Self { document, added: HashMap::new(), embedded: HashMap::new(), pictures }
    }

    fn add(&mut self, index: Index, meaning: Meaning, scene: &mut Scene) -> Result<TextureId, String> {
        let key = (index, meaning);
        if let Some(known) = self.added.get(&key) {
            return known.clone();
        }
        let added = self.load(index, meaning).map(|texture| scene.add_texture(texture));
        self.added.insert(key, added.clone());
        added
    }

    fn load(&mut self, index: Index, meaning: Meaning) -> Result<Texture, String> {
        let (document, root) = (self.document, &self.document.root);
        let piece = root.textures.get(index.value()).ok_or("does not exist")?;
        let texture: json::Texture = document.read(piece, "texture").map_err(|e| e.problem)?;
        // A WebP that stands beside another picture of the same is as good as that.
        let source = texture.source.or(texture.extensions.webp.and_then(|webp| webp.source));
        let missing = "its image does not exist or needs an unknown extension";
        let source = source.ok_or(missing)?;
        let piece = root.images.get(source.value()).ok_or(missing)?;
        let image: json::Image<'_> = document.read(piece, "image").map_err(|e| e.problem)?;
        let texels = self.picture(source, &image, meaning)?;
        let sampler = texture.sampler.and_then(|sampler| root.samplers.get(sampler.value()));
        let sampler: json::Sampler = match sampler {
            Some(piece) => document.read(piece, "sampler").map_err(|e| e.problem)?,
            None => json::Sampler::default(),
        };
        let external = image.uri.as_deref().filter(|uri| !uri.starts_with("data:"));
        let name = texture.name.as_deref().or(image.name.as_deref()).or(external);
        let name = name.map_or_else(|| format!("texture {}", index.0), str::to_owned);
        document.hold(TEXTURE_BYTES + name.len(), "textures").map_err(|e| e.problem)?;
        Ok(Texture {
            name,
            texels,
            wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)],
            filter: if sampler.mag_filter == Some(NEAREST) { Filter::Nearest } else { Filter::Linear },
        })
    }

    fn picture(
        &mut self,
        index: Index,
        image: &json::Image<'_>,
        meaning: Meaning,
    ) -> Result<Arc<Texels>, String> {
        let document = self.document;
        if let Some(uri) = image.uri.as_deref().filter(|uri| !uri.starts_with("data:")) {
            return self.pictures.file(&source::resolve(&document.path, uri), meaning);
        }
        let pictures = &mut self.pictures;
        let name = format!("images[{}]", index.0);
        let load = || match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                document.hold(uri.len(), &name).map_err(|e| e.problem)?;
                let bytes = data_uri(uri).ok_or("broken data URI")?;
                let decoded = pictures.decode(&bytes, &name, meaning);
                document.budget().release(uri.len());
                decoded
            }
            (None, Some(view)) => {
                let (_, bytes) = document.view(view, "image").map_err(|e| e.problem)?;
                pictures.decode(bytes, &name, meaning)
            }
            (None, None) => Err("an image without data".to_owned()),
        };
        self.embedded.entry((index, meaning)).or_insert_with(load).clone()
    }
}

/// glTF's number for a texture that is not interpolated.
const NEAREST: Index = Index(9728);

fn wrap(mode: Option<Index>) -> Wrap {
    match mode {
        Some(Index(33071)) => Wrap::ClampToEdge,
        Some(Index(33648)) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    }
}
