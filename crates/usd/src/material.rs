// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials: networks of UsdPreviewSurface as metallic-roughness materials.
//! Source: the specification of UsdPreviewSurface 2.6. Its specular workflow is a dielectric with that reflectance.
//! Other surfaces are named, and shown in grey. Tests: `tests/materials.rs`.

use std::collections::HashMap;

use gnurt_scene::displacement::{Displacement, Offset};
use gnurt_scene::factors::{AlphaMode, Factors, MappedTexture, TextureTransform};
use gnurt_scene::io::reader::{Meaning, Pictures};
use gnurt_scene::material::{Alpha, Color, Material, Opacity, OpacityChannel, Surface, TextureRef};
use gnurt_scene::texture::{Filter, TexcoordSet, Texture, Wrap};
use gnurt_scene::{MaterialId, Scene, ShaderFile};
use openusd::sdf::Path;

use crate::network::Source;
use crate::reader::Reader;
use crate::textures::{Sampled, Textures, combined};
use crate::{mtlx, mtlx_layer};

/// A material, and its needs of meshes.
#[derive(Clone, Debug)]
pub(crate) struct Use {
    pub(crate) id: MaterialId,
    /// The primvar of its texture coordinates, if it reads any.
    pub(crate) texcoords: Option<String>,
    /// Whether colours of the mesh are multiplied to its base colour.
    pub(crate) has_colors: bool,
    /// Whether surfaces of it are displaced.
    pub(crate) is_displaced: bool,
}

/// Materials of a scene, each once.
pub(crate) struct Materials<'a> {
    pub(crate) pictures: Pictures<'a>,
    textures: Textures,
    known: HashMap<String, Use>,
    /// Those of one name, for files that many prims refer to.
    by_name: HashMap<String, Vec<(Material, Option<Displacement>, Use)>>,
}

/// The colour of meshes without material and display colour.
const GREY: [f32; 3] = [0.18; 3];

impl<'a> Materials<'a> {
    pub(crate) fn new(pictures: Pictures<'a>) -> Self {
        Self { pictures, textures: Textures::default(), known: HashMap::new(), by_name: HashMap::new() }
    }

    /// The material of meshes that are bound to none.
    pub(crate) fn unbound(&mut self, scene: &mut Scene, has_colors: bool, has_opacities: bool) -> Use {
        let key = format!("?{has_colors}{has_opacities}");
        let made = || {
            let mut material = Material::matte("", if has_colors { [1.0; 3] } else { GREY });
            if has_opacities {
                let opacity = Opacity { factor: 1.0, texture: None, channel: OpacityChannel::Alpha };
                material.alpha = Alpha::Blend { opacity };
            }
            let has_colors = has_colors || has_opacities;
            Use { id: scene.add_material(material), texcoords: None, has_colors, is_displaced: false }
        };
        self.known.entry(key).or_insert_with(made).clone()
    }

    /// The material at a path.
    pub(crate) fn of(&mut self, reader: &Reader, scene: &mut Scene, prim: &Path) -> Use {
        if let Some(known) = self.known.get(prim.as_str()) {
            return known.clone();
        }
        let made = self.made(reader, scene, prim);
        self.known.insert(prim.as_str().to_owned(), made.clone());
        made
    }

    fn made(&mut self, reader: &Reader, scene: &mut Scene, prim: &Path) -> Use {
        let name = prim.name().unwrap_or_default().to_owned();
        let varying = reader.varying();
        if let Some(made) = self.of_document(reader, scene, prim, &name) {
            return made;
        }
        let network = match reader.source(prim, "outputs:mtlx:surface") {
            Some(Source::Shader { prim, .. }) => Some(prim),
            _ => None,
        };
        // Preview surfaces are materials of our own, unless their inputs are MaterialX's nodes.
        let is_document = |shader: &Path| {
            let id = reader.shader_id(shader);
            id.starts_with("ND_") && (!id.starts_with("ND_UsdPreviewSurface") || reads_nodes(reader, shader))
        };
        if let Some(shader) = network.filter(is_document) {
            let outputs = ["outputs:mtlx:displacement", "outputs:displacement"];
            let moves = outputs.into_iter().find_map(|output| match reader.source(prim, output) {
                Some(Source::Shader { prim, .. }) => Some(prim),
                _ => None,
            });
            let is_node = |shader: &Path| reader.shader_id(shader).starts_with("ND_displacement");
            if let Some(other) = moves.as_ref().filter(|other| **other != shader && !is_node(other)) {
                let id = reader.shader_id(other);
                reader.unsupported(other, format_args!("displacement by '{id}', left out"));
            }
            return self.of_network(reader, scene, &shader, moves.filter(is_node).as_ref(), name);
        }
        let outputs = ["outputs:surface", "outputs:mtlx:surface"];
        let surface = outputs.into_iter().find_map(|output| match reader.source(prim, output) {
            Some(Source::Shader { prim, .. }) => Some(prim),
            _ => None,
        });
        let mut made = Network { reader, scene, materials: self, texcoords: None, has_colors: false };
        let material = match surface {
            Some(shader) => match &reader.shader_id(&shader)[..] {
                "UsdPreviewSurface" | "ND_UsdPreviewSurface_surfaceshader" => made.preview(&shader, name),
                id => {
                    reader.unsupported(&shader, format_args!("surface by '{id}', shown in grey"));
                    Material::matte(name, GREY)
                }
            },
            None => {
                reader.unsupported(prim, "material without a surface, shown in grey");
                Material::matte(name, GREY)
            }
        };
        let displacement = made.displacement(prim);
        if matches!(reader.source(prim, "outputs:volume"), Some(Source::Shader { .. })) {
            reader.unsupported(prim, "volume");
        }
        let (texcoords, has_colors) = (made.texcoords, made.has_colors);
        let is_displaced = displacement.is_some();
        let mut add = |material: Material| {
            let id = scene.add_material(material);
            if is_displaced {
                scene.set_displacement(id, displacement);
            }
            id
        };
        if reader.varying() != varying {
            return Use { id: add(material), texcoords, has_colors, is_displaced };
        }
        let same = self.by_name.entry(material.name.clone()).or_default();
        let equal = same.iter().find(|(known, moved, user)| {
            let is_same_look = *known == material && *moved == displacement;
            is_same_look && user.texcoords == texcoords && user.has_colors == has_colors
        });
        if let Some((.., known)) = equal {
            return known.clone();
        }
        let made = Use { id: add(material.clone()), texcoords, has_colors, is_displaced };
        same.push((material, displacement, made.clone()));
        made
    }
}

impl Materials<'_> {
    /// The material of a referenced document.
    fn of_document(&self, reader: &Reader, scene: &mut Scene, prim: &Path, name: &str) -> Option<Use> {
        let (file, node) = (reader.word(prim, mtlx_layer::FILE)?, reader.word(prim, mtlx_layer::NODE)?);
        let id = scene.add_material(Material::matte(name, GREY));
        let properties = reader.properties(prim);
        let given = properties.iter().filter_map(|property| {
            let name = property.strip_prefix("inputs:")?.to_owned();
            Some((name, mtlx::parameter(&reader.value(prim, property)?)?))
        });
        let confined_to = reader.confined_to();
        let file = format!("{file}:{node}").into();
        let parameters = given.collect();
        scene.set_shader_file(id, ShaderFile { file, parameters, confined_to, ..ShaderFile::default() });
        // The document is read later: it may displace.
        Some(Use { id, texcoords: Some("st".to_owned()), has_colors: true, is_displaced: false })
    }

    /// The material of a network of MaterialX's nodes.
    fn of_network(
        &mut self,
        reader: &Reader,
        scene: &mut Scene,
        shader: &Path,
        displacement: Option<&Path>,
        name: String,
    ) -> Use {
        let network = mtlx::network(reader, shader, displacement);
        let key = format!("{name}{}", network.text);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let color = ["base_color", "diffuseColor"].iter().find_map(|name| reader.input_vector(shader, name));
        let id = scene
            .add_material(Material::matte(&*name, color.unwrap_or(GREY).map(|c: f32| c.clamp(0.0, 1.0))));
        let read = mtlx::read_pictures(reader, &mut self.pictures, shader, &network);
        let pictures = read.into_iter().map(|(name, texels)| {
            let texture =
                Texture { name: name.clone(), texels, wrap: [Wrap::Repeat; 2], filter: Filter::Linear };
            (name, scene.add_texture(texture))
        });
        let pictures = pictures.collect();
        let file = format!("{}.mtlx", shader.as_str()).into();
        let text = Some(network.text.into());
        scene.set_shader_file(id, ShaderFile { file, text, pictures, ..ShaderFile::default() });
        let texcoords = network.texcoords.or_else(|| Some("st".to_owned()));
        let made = Use { id, texcoords, has_colors: true, is_displaced: displacement.is_some() };
        self.known.insert(key, made.clone());
        made
    }
}

/// Whether an input of a shader comes from a node of MaterialX.
fn reads_nodes(reader: &Reader, shader: &Path) -> bool {
    reader.properties(shader).iter().any(|property| {
        property.starts_with("inputs:")
            && matches!(reader.source(shader, property), Some(Source::Shader { prim, .. })
                if reader.shader_id(&prim).starts_with("ND_"))
    })
}

/// A network that becomes a material.
struct Network<'a, 'b> {
    reader: &'a Reader,
    scene: &'a mut Scene,
    materials: &'a mut Materials<'b>,
    texcoords: Option<String>,
    has_colors: bool,
}

impl Network<'_, '_> {
    /// The displacement of a preview surface. A surface may name itself as displacement without having any.
    fn displacement(&mut self, material: &Path) -> Option<Displacement> {
        let outputs = ["outputs:displacement", "outputs:mtlx:displacement"];
        let shader = outputs.into_iter().find_map(|output| match self.reader.source(material, output) {
            Some(Source::Shader { prim, .. }) => Some(prim),
            _ => None,
        })?;
        let id = self.reader.shader_id(&shader);
        if !id.contains("PreviewSurface") {
            self.reader.unsupported(&shader, format_args!("displacement by '{id}', left out"));
            return None;
        }
        match self.reader.source(&shader, "inputs:displacement")? {
            Source::Value(found) => {
                let height = crate::value::number(&found).filter(|x| *x != 0.0)?;
                Some(Displacement::new(Offset::Constant(height as f32)))
            }
            Source::Shader { .. } => {
                let map = self.map(&shader, "displacement", Meaning::Data)?;
                let channel = crate::textures::channel(&map.output);
                let (scale, bias) = (map.scale[channel], map.bias[channel]);
                let texture = self.reference(&map);
                let height = Offset::Height { texture, channel: channel as u8 };
                Some(match scale == 0.0 {
                    true => Displacement::new(Offset::Constant(bias)),
                    false => Displacement { scale, midlevel: -bias / scale, ..Displacement::new(height) },
                })
            }
        }
    }

    fn preview(&mut self, shader: &Path, name: String) -> Material {
        let reader = self.reader;
        let number =
            |name: &str, fallback: f32| reader.input_number(shader, name).map_or(fallback, |x| x as f32);
        let (diffuse, base_map) = self.color(shader, "diffuseColor", GREY);
        let (emission, emission_map) = self.color(shader, "emissiveColor", [0.0; 3]);
        let is_specular = number("useSpecularWorkflow", 0.0) != 0.0;
        let mut factors = Factors {
            name,
            base_color: [diffuse[0], diffuse[1], diffuse[2], 1.0],
            metallic: if is_specular { 0.0 } else { number("metallic", 0.0) },
            roughness: number("roughness", 0.5),
            emission,
            ior: number("ior", 1.5),
            clearcoat: number("clearcoat", 0.0),
            clearcoat_roughness: number("clearcoatRoughness", 0.01),
            ..Factors::default()
        };
        if factors.clearcoat == 0.0 {
            // Without a coat its roughness says nothing.
            factors.clearcoat_roughness = 0.0;
        }
        if is_specular {
            let (specular, map) = self.color(shader, "specularColor", [0.0; 3]);
            let f0 = ((factors.ior - 1.0) / (factors.ior + 1.0)).powi(2).max(1e-4);
            factors.specular_color = specular.map(|c| c / f0);
            if map.is_some() {
                reader.unsupported(shader, "texture of specularColor");
            }
        }
        for name in ["clearcoat", "clearcoatRoughness", "ior"] {
            if self.map(shader, name, Meaning::Data).is_some() {
                reader.unsupported(shader, format_args!("texture of {name}"));
            }
        }
        factors.base_texture = base_map.as_ref().map(|map| self.mapped(map));
        factors.emission_texture = emission_map.as_ref().map(|map| self.mapped(map));
        self.roughness(shader, &mut factors, is_specular);
        if let Some(map) = self.map(shader, "normal", Meaning::Data) {
            // The scale of the map's bytes is the strength of its bend.
            factors.normal_scale = if map.bias[0] == 0.0 { 1.0 } else { map.scale[0] / 2.0 };
            factors.normal_texture = Some(self.mapped(&map));
        }
        let threshold = number("opacityThreshold", 0.0);
        let opacity = self.opacity(shader, base_map.as_ref());
        if let Some(opacity) = opacity {
            factors.alpha = if threshold > 0.0 { AlphaMode::Mask } else { AlphaMode::Blend };
            factors.base_color[3] = opacity.factor;
        }
        let mut material = factors.material();
        if let Some(opacity) = opacity {
            material.alpha = match threshold > 0.0 {
                true => Alpha::Mask { cutoff: threshold, opacity },
                false => Alpha::Blend { opacity },
            };
        }
        if let Surface::Matte { base_color } = &mut material.surface {
            *base_color = Color { factor: base_color.factor.map(|c| c.clamp(0.0, 1.0)), ..*base_color };
        }
        material
    }

    /// A colour, and the texture that is multiplied to it.
    fn color(&mut self, shader: &Path, name: &str, fallback: [f32; 3]) -> ([f32; 3], Option<Sampled>) {
        if let Some(map) = self.map(shader, name, Meaning::Color) {
            let [r, g, b, _] = map.scale;
            if map.bias[..3] != [0.0; 3] {
                self.reader.unsupported(shader, format_args!("bias of the texture of {name}"));
            }
            return ([r, g, b], Some(map));
        }
        if self.has_colors && name == "diffuseColor" {
            return ([1.0; 3], None);
        }
        (self.reader.input_vector(shader, name).unwrap_or(fallback), None)
    }

    /// The texture that an input is connected to.
    fn map(&mut self, shader: &Path, name: &str, meaning: Meaning) -> Option<Sampled> {
        let Some(Source::Shader { prim, output }) = self.reader.source(shader, &format!("inputs:{name}"))
        else {
            return None;
        };
        match &self.reader.shader_id(&prim)[..] {
            "UsdUVTexture" => {
                let map = self.reader.sampled(&mut self.materials.pictures, &prim, &output, meaning)?;
                match &self.texcoords {
                    None => self.texcoords = Some(map.primvar.clone()),
                    Some(known) if *known != map.primvar => {
                        let second = &map.primvar;
                        self.reader.unsupported(
                            &prim,
                            format_args!(
                                "texture coordinates '{second}' beside '{known}', those are used for both"
                            ),
                        );
                    }
                    Some(_) => {}
                }
                Some(map)
            }
            id if id.starts_with("UsdPrimvarReader") => {
                let read = self.reader.input_word(&prim, "varname").unwrap_or_default();
                if name == "diffuseColor" && read == "displayColor" {
                    self.has_colors = true;
                } else {
                    self.reader.unsupported(&prim, format_args!("{name} by the primvar '{read}'"));
                }
                None
            }
            id => {
                self.reader.unsupported(&prim, format_args!("{name} by '{id}'"));
                None
            }
        }
    }

    fn reference(&mut self, map: &Sampled) -> TextureRef {
        TextureRef {
            uv_from_mesh: map.uv_from_mesh,
            ..TextureRef::new(self.materials.textures.id(self.scene, map))
        }
    }

    /// A texture as glTF's materials have it: v downwards.
    fn mapped(&mut self, map: &Sampled) -> MappedTexture {
        let texture = self.materials.textures.id(self.scene, map);
        let [a, b, c, d, e, f] = map.uv_from_mesh;
        if [a, b, c, d, e, f] == [1.0, 0.0, 0.0, 1.0, 0.0, 0.0] {
            return MappedTexture { texture, transform: None, set: TexcoordSet::First };
        }
        let (scale, rotation) = ([a.hypot(b), c.hypot(d).copysign(a * d - b * c)], b.atan2(a));
        let (sin, cos) = rotation.sin_cos();
        let offset = [e - sin * scale[1], 1.0 - cos * scale[1] - f];
        let transform = Some(TextureTransform { offset, rotation, scale });
        MappedTexture { texture, transform, set: TexcoordSet::First }
    }

    /// Green and blue of one texture, whatever textures they come from.
    fn roughness(&mut self, shader: &Path, factors: &mut Factors, is_specular: bool) {
        let rough = self.map(shader, "roughness", Meaning::Data);
        let metal = if is_specular { None } else { self.map(shader, "metallic", Meaning::Data) };
        let is_as_is = |map: &Sampled, output: &str| {
            map.output == output
                && map.bias == [0.0; 4]
                && matches!(map.texels.data, gnurt_scene::texture::TexelData::Linear8(_))
        };
        let map = match (&rough, &metal) {
            (None, None) => return,
            (Some(r), Some(m)) if is_as_is(r, "g") && is_as_is(m, "b") && r.name == m.name => {
                (factors.roughness, factors.metallic) = (r.scale[1], m.scale[2]);
                Some(r.clone())
            }
            _ => {
                let parts = [(rough.as_ref(), factors.roughness), (metal.as_ref(), factors.metallic)];
                (factors.roughness, factors.metallic) = (1.0, if is_specular { 0.0 } else { 1.0 });
                combined(parts)
            }
        };
        factors.metallic_roughness_texture = map.map(|map| self.mapped(&map));
    }

    /// The opacity, unless all is there.
    fn opacity(&mut self, shader: &Path, base: Option<&Sampled>) -> Option<Opacity> {
        let Some(map) = self.map(shader, "opacity", Meaning::Data) else {
            let factor = self.reader.input_number(shader, "opacity").unwrap_or(1.0) as f32;
            let opaque = Opacity { factor, texture: None, channel: OpacityChannel::Alpha };
            return (factor < 1.0).then_some(opaque);
        };
        let channel = if map.output == "a" { OpacityChannel::Alpha } else { OpacityChannel::Red };
        // One picture for colour and opacity.
        let shared = base.filter(|base| base.name == map.name && channel == OpacityChannel::Alpha);
        let factor = map.scale[crate::textures::channel(&map.output)];
        let texture = Some(self.reference(shared.unwrap_or(&map)));
        Some(Opacity { factor, texture, channel })
    }
}
