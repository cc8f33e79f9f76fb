// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF materials and their textures.
//! Source: glTF 2.0 section 3.9; KHR_materials_{anisotropy, clearcoat, diffuse_transmission, dispersion, emissive_strength,
//! ior, iridescence, pbrSpecularGlossiness, sheen, specular, transmission, unlit, volume, volume_scatter},
//! KHR_texture_transform.
//!
//! The texture of the thickness is not read: it bakes for rasterizers what rays measure. A material reads two
//! sets of texture coordinates at most. [`Factors`] defines how material numbers and textures combine.
//! Tests: `tests/gltf.rs::{materials_become_ours, texture_transforms_agree_with_the_extension,
//! tangents_come_with_normal_maps}`.

use std::collections::HashMap;
use std::sync::Arc;

use super::base64::data_uri;
use super::document::Document;
use super::json::{self, Index, TextureInfo, TextureTransform};
use super::ranges::out_of_range;
use super::specular_glossiness;
use gnurt_scene::Scene;
use gnurt_scene::ShaderFile;
use gnurt_scene::animation::MovingMaterial;
use gnurt_scene::factors::{self, AlphaMode, Factors, MappedTexture};
use gnurt_scene::id::{MaterialId, TextureId};
use gnurt_scene::io::reader::quoted;
use gnurt_scene::io::reader::{Meaning, Pictures};
use gnurt_scene::io::{Error, Oddity, Warnings, reader as source};
use gnurt_scene::labels::Shining;
use gnurt_scene::layer_textures::LayerTextures;
use gnurt_scene::material::{Material, Principled, Surface};
use gnurt_scene::texture::{Filter, TexcoordSet, Texels, Texture, Wrap};

/// A material of the scene, and which texture coordinates of the mesh it reads.
#[derive(Clone, Copy)]
pub(super) struct AddedMaterial {
    pub(super) id: MaterialId,
    pub(super) texcoord_set: u32,
    /// A second set, for some of its textures.
    pub(super) second_set: Option<u32>,
    /// The coordinates along which the tangents of its meshes lie; `None` = nothing reads tangents.
    pub(super) tangents: Option<TexcoordSet>,
}

/// Bytes of a material of the scene, without its name.
const MATERIAL_BYTES: usize = size_of::<Material>() + size_of::<Principled>() + 64;
/// Bytes of a texture of the scene, without its name and its texels.
const TEXTURE_BYTES: usize = 256;

/// The materials of a document.
#[derive(Default)]
pub(super) struct Materials {
    /// By their numbers and, last, the default one.
    pub(super) added: Vec<AddedMaterial>,
    /// Materials that change with time.
    pub(super) moving: Vec<MovingMaterial>,
}

/// Adds the materials of the document; `is_driven` tells which change with time.
pub(super) fn add_all(
    document: &Document<'_>,
    is_driven: impl Fn(Index) -> bool,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<Materials, Error> {
    let count = document.root.materials.len();
    document.hold(count * (MATERIAL_BYTES + size_of::<AddedMaterial>()), "materials")?;
    let mut textures = Textures::new(document);
    let mut materials = Materials { added: Vec::with_capacity(count + 1), moving: Vec::new() };
    for i in 0..=count {
        let location = format!("materials[{i}]");
        let material = match document.root.materials.get(i) {
            Some(piece) => document.read(piece, &location)?,
            None => json::Material { name: Some("default".into()), ..json::Material::default() },
        };
        let is_driven = i < count && is_driven(Index(i as u32));
        document.hold(material.name.as_ref().map_or(0, String::len), &location)?;
        let first = texcoord_set_of_light(&material);
        let mut converter =
            Converter { document, scene, textures: &mut textures, warnings, sets: [first, None] };
        let factors = converter.factors(i, &material, is_driven);
        let [texcoord_set, second_set] = converter.sets;
        let texcoord_set = texcoord_set.unwrap_or(0);
        if factors.base_texture.is_some_and(|base| base.set == TexcoordSet::Second)
            && factors.alpha != AlphaMode::Opaque
            && factors.emission_texture.is_some()
        {
            let detail = format!("{location}: opacity of a lamp under a second set of texture coordinates");
            warnings.note(Oddity::StandIn, &document.path, None, detail);
        }
        for wrong in out_of_range(&factors) {
            let detail = format!("{location}: {wrong}");
            warnings.note(Oddity::NumberOutOfRange, &document.path, None, detail);
        }
        if !matches!(&*material.alpha_mode, "OPAQUE" | "MASK" | "BLEND") {
            let detail = format!("{location}: alphaMode {}, shown as OPAQUE", quoted(&material.alpha_mode));
            warnings.note(Oddity::NotShown, &document.path, None, detail);
        }
        let converted = factors.material();
        let tangents = tangents_of(&factors, &converted.surface, is_driven);
        let id = scene.add_material(converted);
        if material.extras_bytes() > 0 {
            document.hold(4 * material.extras_bytes(), &location)?;
        }
        if let Some(group) = material.light_group() {
            scene.labels_mut().set_light_group(Shining::Material(id), &group);
        }
        if let Some((name, parameters)) = material.shader() {
            let file = source::resolve(&document.path, &name);
            let outside = |(problem, remedy): (String, String)| document.error(&location, problem, &remedy);
            document.access.check(&file).map_err(outside)?;
            let confined_to = document.access.confined_to();
            scene.set_shader_file(id, ShaderFile { file, parameters, confined_to, ..ShaderFile::default() });
        }
        materials.added.push(AddedMaterial { id, texcoord_set, second_set, tangents });
        if is_driven {
            document.hold(size_of::<MovingMaterial>() + factors.name.len(), &location)?;
            materials.moving.push(MovingMaterial { material: id, factors });
        }
    }
    Ok(materials)
}

/// The set of texture coordinates that lists of lights read, if the material has a texture that decides it:
/// that of the emission, or else that of the base colour.
fn texcoord_set_of_light(material: &json::Material<'_>) -> Option<u32> {
    let glossy = material.extensions.specular_glossiness.as_ref().and_then(|old| old.diffuse_texture);
    let base = material.pbr_metallic_roughness.base_color_texture.or(glossy);
    let info = material.emissive_texture.or(base)?;
    Some(info.extensions.transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord).0)
}

/// The coordinates whose directions the surface reads, if it reads any.
fn tangents_of(factors: &Factors, surface: &Surface, is_driven: bool) -> Option<TexcoordSet> {
    let (reads_normals, is_brushed) = match surface {
        _ if is_driven => (true, factors.anisotropy > 0.0),
        Surface::MetallicRoughness { .. } => (true, false),
        Surface::Principled(principled) => (true, principled.anisotropy.strength > 0.0),
        _ => (false, false),
    };
    let coat = factors.layer_textures.clearcoat_normal.filter(|_| factors.clearcoat > 0.0);
    let normals = factors.normal_texture.or(coat).filter(|_| reads_normals);
    let brushed = is_brushed.then(|| factors.anisotropy_texture.map_or(TexcoordSet::First, |map| map.set));
    normals.map(|map| map.set).or(brushed)
}

struct Converter<'a, 't> {
    document: &'a Document<'a>,
    scene: &'a mut Scene,
    textures: &'a mut Textures<'t>,
    warnings: &'a mut Warnings,
    /// The file's numbers of the sets of texture coordinates that its textures read.
    sets: [Option<u32>; 2],
}

impl Converter<'_, '_> {
    /// The factors in the file. Unused textures are not read, unless an animation may use them.
    fn factors(&mut self, i: usize, from: &json::Material<'_>, is_driven: bool) -> Factors {
        let pbr = &from.pbr_metallic_roughness;
        let extensions = &from.extensions;
        let mut to = Factors {
            name: from.name.clone().unwrap_or_else(|| format!("material {i}")),
            base_color: pbr.base_color_factor,
            metallic: pbr.metallic_factor,
            roughness: pbr.roughness_factor,
            emission: from.emissive_factor,
            alpha: match &*from.alpha_mode {
                "MASK" => AlphaMode::Mask,
                "BLEND" => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            alpha_cutoff: from.alpha_cutoff,
            unlit: extensions.unlit.is_some(),
            base_texture: self.info(pbr.base_color_texture.as_ref(), Meaning::Color),
            emission_texture: self.info(from.emissive_texture.as_ref(), Meaning::Color),
            ..Factors::default()
        };
        if let Some(glossy) = &extensions.specular_glossiness {
            specular_glossiness::set_factors(glossy, &mut to);
            to.base_texture = self.info(glossy.diffuse_texture.as_ref(), Meaning::Color);
        }
        if let Some(strength) = &extensions.emissive_strength {
            to.emission_strength = strength.emissive_strength;
        }
        if to.unlit {
            return to;
        }
        if let Some(ior) = &extensions.ior {
            to.ior = ior.ior;
        }
        self.layers(extensions, &mut to, is_driven);
        if let Some(glossy) = &extensions.specular_glossiness {
            self.glossiness(glossy, &mut to);
        }
        if is_driven || to.reads_roughness_textures(from.normal_texture.is_some()) {
            if extensions.specular_glossiness.is_none() {
                let map = pbr.metallic_roughness_texture.as_ref();
                to.metallic_roughness_texture = self.info(map, Meaning::Data);
            }
            to.normal_texture = self.info(from.normal_texture.as_ref(), Meaning::Data);
            to.normal_scale = from.normal_texture.as_ref().map_or(1.0, |normal| normal.scale);
            let brushed = extensions.anisotropy.as_ref().filter(|_| is_driven || to.anisotropy > 0.0);
            to.anisotropy_texture =
                self.info(brushed.and_then(|brushed| brushed.anisotropy_texture.as_ref()), Meaning::Data);
        }
        to
    }

    /// The extensions of a material. Textures of layers that are not there are not read.
    fn layers(&mut self, extensions: &json::MaterialExtensions, to: &mut Factors, is_driven: bool) {
        let is_there = |share: f32| share > 0.0 || is_driven;
        let mut maps = LayerTextures::default();
        if let Some(specular) = &extensions.specular {
            to.specular = specular.specular_factor;
            to.specular_color = specular.specular_color_factor;
            if is_there(to.specular) {
                maps.specular = self.info(specular.specular_texture.as_ref(), Meaning::Data);
                maps.specular_color = self.info(specular.specular_color_texture.as_ref(), Meaning::Color);
            }
        }
        if let Some(transmission) = &extensions.transmission {
            to.transmission = transmission.transmission_factor;
            if is_there(to.transmission) {
                maps.transmission = self.info(transmission.transmission_texture.as_ref(), Meaning::Data);
            }
        }
        if let Some(coat) = &extensions.clearcoat {
            to.clearcoat = coat.clearcoat_factor;
            to.clearcoat_roughness = coat.clearcoat_roughness_factor;
            if is_there(to.clearcoat) {
                maps.clearcoat = self.info(coat.clearcoat_texture.as_ref(), Meaning::Data);
                maps.clearcoat_roughness =
                    self.info(coat.clearcoat_roughness_texture.as_ref(), Meaning::Data);
                maps.clearcoat_normal = self.info(coat.clearcoat_normal_texture.as_ref(), Meaning::Data);
                maps.clearcoat_normal_scale =
                    coat.clearcoat_normal_texture.as_ref().map_or(1.0, |normal| normal.scale);
            }
        }
        if let Some(sheen) = &extensions.sheen {
            to.sheen_color = sheen.sheen_color_factor;
            to.sheen_roughness = sheen.sheen_roughness_factor;
            if is_there(to.sheen_color.into_iter().fold(0.0, f32::max)) {
                maps.sheen_color = self.info(sheen.sheen_color_texture.as_ref(), Meaning::Color);
                maps.sheen_roughness = self.info(sheen.sheen_roughness_texture.as_ref(), Meaning::Data);
            }
        }
        if let Some(volume) = &extensions.volume {
            to.thickness = volume.thickness_factor;
            to.attenuation_color = volume.attenuation_color;
            to.attenuation_distance = volume.attenuation_distance;
        }
        if let Some(scatter) = &extensions.volume_scatter {
            to.scatter_color = scatter.multiscatter_color_factor.unwrap_or(scatter.multiscatter_color);
            to.scatter_anisotropy = scatter.scatter_anisotropy;
            if scatter.multiscatter_color_texture.is_some() {
                let detail = "texture of KHR_materials_volume_scatter";
                self.warnings.note(Oddity::NotShown, &self.document.path, None, detail);
            }
        }
        if let Some(dispersion) = &extensions.dispersion {
            to.dispersion = dispersion.dispersion;
        }
        if let Some(brushed) = &extensions.anisotropy {
            to.anisotropy = brushed.anisotropy_strength;
            to.anisotropy_rotation = brushed.anisotropy_rotation;
        }
        if let Some(film) = &extensions.iridescence {
            to.iridescence = film.iridescence_factor;
            to.iridescence_ior = film.iridescence_ior;
            to.iridescence_thickness = film.iridescence_thickness_maximum;
            to.iridescence_least_thickness = film.iridescence_thickness_minimum;
            if is_there(to.iridescence) {
                maps.iridescence = self.info(film.iridescence_texture.as_ref(), Meaning::Data);
                maps.iridescence_thickness =
                    self.info(film.iridescence_thickness_texture.as_ref(), Meaning::Data);
            }
        }
        if let Some(through) = &extensions.diffuse_transmission {
            to.diffuse_transmission = through.diffuse_transmission_factor;
            to.diffuse_transmission_color = through.diffuse_transmission_color_factor;
            if is_there(to.diffuse_transmission) {
                maps.diffuse_transmission =
                    self.info(through.diffuse_transmission_texture.as_ref(), Meaning::Data);
                maps.diffuse_transmission_color =
                    self.info(through.diffuse_transmission_color_texture.as_ref(), Meaning::Color);
            }
        }
        to.layer_textures = maps;
    }

    /// The texture of specular colour and glossiness: colours of the reflection, and a roughness.
    fn glossiness(&mut self, from: &json::SpecularGlossiness, to: &mut Factors) {
        let Some(info) = &from.specular_glossiness_texture else { return };
        to.layer_textures.specular_color = self.info(Some(info), Meaning::Color);
        let rough = to.layer_textures.specular_color.map(|map| {
            let texture = self.textures.roughness(info.index, from.glossiness_factor, self.scene);
            texture.map(|texture| MappedTexture { texture, ..map })
        });
        match rough {
            Some(Ok(map)) => (to.roughness, to.metallic_roughness_texture) = (1.0, Some(map)),
            Some(Err(why)) => {
                let detail = format!("textures[{}]: {why}", info.index.0);
                self.warnings.note(Oddity::BadTexture, &self.document.path, None, detail);
            }
            None => {}
        }
    }

    fn info(&mut self, info: Option<&TextureInfo>, meaning: Meaning) -> Option<MappedTexture> {
        let info = info?;
        self.texture(info.index, info.tex_coord, info.extensions.transform.as_ref(), meaning)
    }

    fn texture(
        &mut self,
        index: Index,
        texcoord_set: Index,
        transform: Option<&TextureTransform>,
        meaning: Meaning,
    ) -> Option<MappedTexture> {
        let Index(set) = transform.and_then(|t| t.tex_coord).unwrap_or(texcoord_set);
        let path = &self.document.path;
        let [first, second] = &mut self.sets;
        let set = if *first.get_or_insert(set) == set {
            TexcoordSet::First
        } else if *second.get_or_insert(set) == set {
            TexcoordSet::Second
        } else {
            let detail = "third set of texture coordinates in one material";
            self.warnings.note(Oddity::NotShown, path, None, detail);
            return None;
        };
        let transform = transform.map(|from| factors::TextureTransform {
            offset: from.offset,
            rotation: from.rotation,
            scale: from.scale,
        });
        match self.textures.add(index, meaning, self.scene) {
            Ok(texture) => Some(MappedTexture { texture, transform, set }),
            Err(why) => {
                self.warnings.note(Oddity::BadTexture, path, None, format!("textures[{}]: {why}", index.0));
                None
            }
        }
    }
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

    /// The roughness of a texture with glossiness in its alpha, each time a texture of its own.
    fn roughness(&mut self, index: Index, glossiness: f32, scene: &mut Scene) -> Result<TextureId, String> {
        let glossy = self.load(index, Meaning::Data)?;
        let bytes = specular_glossiness::roughness_bytes(&glossy.texels);
        self.document.hold(bytes, "textures").map_err(|e| e.problem)?;
        self.document.work(bytes, "textures").map_err(|e| e.problem)?;
        let texels = specular_glossiness::roughness(&glossy.texels, glossiness);
        Ok(scene.add_texture(Texture { texels, ..glossy }))
    }

    fn load(&mut self, index: Index, meaning: Meaning) -> Result<Texture, String> {
        let (document, root) = (self.document, &self.document.root);
        let piece = root.textures.get(index.value()).ok_or("does not exist")?;
        let texture: json::Texture = document.read(piece, "texture").map_err(|e| e.problem)?;
        // A WebP is used only if there is no other version of the picture.
        let source = texture.source.or(texture.extensions.webp.and_then(|webp| webp.source));
        let missing = "its image does not exist or needs an unknown extension";
        let compressed = "its picture is KTX2 (KHR_texture_basisu), which is not read; write the file with PNG, JPEG or WebP";
        let source = source.ok_or(if texture.extensions.basisu.is_some() { compressed } else { missing })?;
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
