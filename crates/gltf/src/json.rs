// SPDX-License-Identifier: GPL-3.0-or-later
//! glTF's JSON: only the properties that are read.
//! Source: glTF 2.0 section 5 (properties and their defaults) and the KHR extensions that are named here.
//!
//! The root holds its arrays as pieces of text, 16 bytes for each element; an element is parsed when it is
//! used. So a document takes a few times its length at most, and unused elements cost next to nothing.
//! Integers may be written as `1.0` or `1e0`; one out of range is an error, never another number.
//! Tests: `tests/{gltf,broken_files,growth}.rs`.

use std::borrow::Cow;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, IgnoredAny, MapAccess, Visitor};
use serde_json::value::RawValue;

/// Elements of an array, not read yet.
pub(super) type Pieces<'a> = Vec<&'a RawValue>;

/// The document.
#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Root<'a> {
    #[serde(borrow)]
    pub(super) asset: Option<Asset<'a>>,
    #[serde(borrow)]
    pub(super) accessors: Pieces<'a>,
    #[serde(borrow)]
    pub(super) animations: Pieces<'a>,
    #[serde(borrow)]
    pub(super) buffers: Pieces<'a>,
    #[serde(borrow)]
    pub(super) buffer_views: Pieces<'a>,
    #[serde(borrow)]
    pub(super) cameras: Pieces<'a>,
    #[serde(borrow)]
    pub(super) extensions: RootExtensions<'a>,
    /// Contents of any form, written by any program.
    #[serde(borrow)]
    pub(super) extras: Option<&'a RawValue>,
    #[serde(borrow)]
    pub(super) extensions_required: Vec<Text<'a>>,
    #[serde(borrow)]
    pub(super) extensions_used: Vec<Text<'a>>,
    #[serde(borrow)]
    pub(super) images: Pieces<'a>,
    #[serde(borrow)]
    pub(super) materials: Pieces<'a>,
    #[serde(borrow)]
    pub(super) meshes: Pieces<'a>,
    #[serde(borrow)]
    pub(super) nodes: Pieces<'a>,
    #[serde(borrow)]
    pub(super) samplers: Pieces<'a>,
    pub(super) scene: Option<Index>,
    #[serde(borrow)]
    pub(super) scenes: Pieces<'a>,
    #[serde(borrow)]
    pub(super) skins: Pieces<'a>,
    #[serde(borrow)]
    pub(super) textures: Pieces<'a>,
}

impl Root<'_> {
    /// How many elements the arrays have.
    pub(super) fn pieces(&self) -> usize {
        let lights = self.extensions.lights.as_ref().map_or(0, |lights| lights.lights.len());
        let arrays = [
            &self.accessors,
            &self.animations,
            &self.buffers,
            &self.buffer_views,
            &self.cameras,
            &self.images,
            &self.materials,
            &self.meshes,
            &self.nodes,
            &self.samplers,
            &self.scenes,
            &self.skins,
            &self.textures,
        ];
        let variants = self.extensions.variants.as_ref().map_or(0, |variants| variants.variants.len());
        arrays.iter().map(|array| array.len()).sum::<usize>() + lights + 2 * variants
    }
}

/// The part that all versions share.
#[derive(Deserialize)]
pub(super) struct Versioned<'a> {
    #[serde(borrow)]
    pub(super) asset: AnyAsset<'a>,
}

#[derive(Deserialize)]
pub(super) struct AnyAsset<'a> {
    /// A text or, in drafts of the format, a number.
    #[serde(borrow)]
    pub(super) version: &'a RawValue,
}

#[derive(Deserialize)]
pub(super) struct Asset<'a> {
    #[serde(borrow)]
    pub(super) version: Text<'a>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct RootExtensions<'a> {
    #[serde(rename = "KHR_lights_punctual", borrow)]
    pub(super) lights: Option<Lights<'a>>,
    #[serde(rename = "KHR_materials_variants", borrow)]
    pub(super) variants: Option<Variants<'a>>,
}

/// The variants of KHR_materials_variants.
#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Variants<'a> {
    #[serde(borrow)]
    pub(super) variants: Vec<Variant<'a>>,
}

#[derive(Deserialize)]
pub(super) struct Variant<'a> {
    #[serde(borrow)]
    pub(super) name: Text<'a>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Lights<'a> {
    #[serde(borrow)]
    pub(super) lights: Pieces<'a>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Accessor<'a> {
    pub(super) buffer_view: Option<Index>,
    #[serde(deserialize_with = "whole")]
    pub(super) byte_offset: u64,
    #[serde(deserialize_with = "whole")]
    pub(super) component_type: u64,
    #[serde(deserialize_with = "whole")]
    pub(super) count: u64,
    pub(super) normalized: bool,
    pub(super) sparse: Option<Sparse>,
    #[serde(rename = "type", borrow)]
    pub(super) shape: Text<'a>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    #[serde(deserialize_with = "whole")]
    pub(super) count: u64,
    pub(super) indices: SparsePart,
    pub(super) values: SparsePart,
}

/// Where the indices or the values of a sparse accessor are.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub(super) buffer_view: Index,
    #[serde(deserialize_with = "whole", default)]
    pub(super) byte_offset: u64,
    /// Of indices only.
    #[serde(deserialize_with = "whole", default)]
    pub(super) component_type: u64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer<'a> {
    #[serde(deserialize_with = "whole")]
    pub(super) byte_length: u64,
    #[serde(default, borrow)]
    pub(super) uri: Option<Text<'a>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView<'a> {
    pub(super) buffer: Index,
    #[serde(deserialize_with = "whole", default)]
    pub(super) byte_offset: u64,
    #[serde(deserialize_with = "whole")]
    pub(super) byte_length: u64,
    #[serde(deserialize_with = "whole", default)]
    pub(super) byte_stride: u64,
    #[serde(default, borrow)]
    pub(super) extensions: BufferViewExtensions<'a>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct BufferViewExtensions<'a> {
    #[serde(rename = "EXT_meshopt_compression", borrow)]
    ext: Option<Meshopt<'a>>,
    #[serde(rename = "KHR_meshopt_compression", borrow)]
    khr: Option<Meshopt<'a>>,
}

impl<'a> BufferViewExtensions<'a> {
    /// How the view is compressed by meshoptimizer, if it is.
    pub(super) fn meshopt(&self) -> Option<&Meshopt<'a>> {
        self.khr.as_ref().or(self.ext.as_ref())
    }
}

/// A compressed view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Meshopt<'a> {
    pub(super) buffer: Index,
    #[serde(deserialize_with = "whole", default)]
    pub(super) byte_offset: u64,
    #[serde(deserialize_with = "whole")]
    pub(super) byte_length: u64,
    #[serde(deserialize_with = "whole")]
    pub(super) byte_stride: u64,
    #[serde(deserialize_with = "whole")]
    pub(super) count: u64,
    #[serde(borrow)]
    pub(super) mode: Text<'a>,
    #[serde(default, borrow)]
    pub(super) filter: Option<Text<'a>>,
}

#[derive(Deserialize)]
pub(super) struct Camera {
    #[serde(default)]
    pub(super) perspective: Option<Perspective>,
    #[serde(default)]
    pub(super) orthographic: Option<Orthographic>,
    #[serde(default)]
    pub(super) extras: Option<serde_json::Value>,
}

#[derive(Deserialize)]
pub(super) struct Orthographic {
    pub(super) ymag: f32,
}

#[derive(Deserialize)]
pub(super) struct Perspective {
    pub(super) yfov: f32,
}

/// A light of KHR_lights_punctual.
#[derive(Deserialize)]
pub(super) struct Light<'a> {
    #[serde(rename = "type", borrow)]
    pub(super) kind: Text<'a>,
    #[serde(default = "white")]
    pub(super) color: [f32; 3],
    #[serde(default = "one")]
    pub(super) intensity: f32,
    #[serde(default)]
    pub(super) spot: Cone,
    #[serde(default)]
    pub(super) extras: Option<serde_json::Value>,
}

/// The light group in `extras`.
pub(super) fn light_group(extras: Option<&serde_json::Value>) -> Option<&str> {
    extras?.get("light_group")?.as_str()
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Cone {
    pub(super) inner_cone_angle: f32,
    pub(super) outer_cone_angle: f32,
}

impl Default for Cone {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: std::f32::consts::FRAC_PI_4 }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image<'a> {
    #[serde(default)]
    pub(super) name: Option<String>,
    #[serde(default, borrow)]
    pub(super) uri: Option<Text<'a>>,
    #[serde(default)]
    pub(super) buffer_view: Option<Index>,
}

/// The file that a buffer or an image names.
#[derive(Deserialize)]
pub(super) struct Named<'a> {
    #[serde(default, borrow)]
    pub(super) uri: Option<Text<'a>>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Sampler {
    pub(super) mag_filter: Option<Index>,
    pub(super) wrap_s: Option<Index>,
    pub(super) wrap_t: Option<Index>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Texture {
    pub(super) name: Option<String>,
    pub(super) sampler: Option<Index>,
    pub(super) source: Option<Index>,
    pub(super) extensions: TextureExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub(super) webp: Option<TextureSource>,
    #[serde(rename = "KHR_texture_basisu")]
    pub(super) basisu: Option<IgnoredAny>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct TextureSource {
    pub(super) source: Option<Index>,
}

/// How a material reads a texture.
#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub(super) index: Index,
    #[serde(default)]
    pub(super) tex_coord: Index,
    /// Of normal maps only.
    #[serde(default = "one")]
    pub(super) scale: f32,
    #[serde(default)]
    pub(super) extensions: TextureInfoExtensions,
}

#[derive(Deserialize, Clone, Copy, Default)]
#[serde(default)]
pub(super) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<TextureTransform>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct TextureTransform {
    pub(super) offset: [f32; 2],
    pub(super) rotation: f32,
    pub(super) scale: [f32; 2],
    pub(super) tex_coord: Option<Index>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Material<'a> {
    pub(super) name: Option<String>,
    pub(super) pbr_metallic_roughness: MetallicRoughness,
    pub(super) normal_texture: Option<TextureInfo>,
    pub(super) emissive_texture: Option<TextureInfo>,
    pub(super) emissive_factor: [f32; 3],
    #[serde(borrow)]
    pub(super) alpha_mode: Text<'a>,
    pub(super) alpha_cutoff: f32,
    pub(super) extensions: MaterialExtensions,
    /// Contents of any form, written by any program.
    #[serde(borrow)]
    pub(super) extras: Option<&'a RawValue>,
}

impl Root<'_> {
    /// The layers of pictures in `extras`: `{"gnurt": {"outputs": [..]}}`.
    pub(super) fn outputs(&self) -> Vec<String> {
        #[derive(Deserialize)]
        struct Extras {
            gnurt: Wishes,
        }
        #[derive(Deserialize)]
        struct Wishes {
            outputs: Vec<String>,
        }
        let read = |extras: &RawValue| serde_json::from_str::<Extras>(extras.get()).ok();
        self.extras.and_then(read).map_or_else(Vec::new, |extras| extras.gnurt.outputs)
    }
}

/// A file, and names and values of parameters.
pub(super) type NamedShader = (String, Vec<(String, String)>);

/// The shader that `extras` name: `{"gnurt": {"shader": FILE, "parameters": {..}}}`.
pub(super) fn shader_in<'de>(extras: impl Deserializer<'de>) -> Option<NamedShader> {
    #[derive(Deserialize)]
    struct Extras {
        gnurt: Shader,
    }
    #[derive(Deserialize)]
    struct Shader {
        shader: String,
        #[serde(default)]
        parameters: serde_json::Map<String, serde_json::Value>,
    }
    fn text(value: &serde_json::Value) -> String {
        match value {
            serde_json::Value::String(text) => text.clone(),
            serde_json::Value::Bool(value) => u8::from(*value).to_string(),
            serde_json::Value::Array(list) => list.iter().map(text).collect::<Vec<_>>().join(","),
            other => other.to_string(),
        }
    }
    let extras = Extras::deserialize(extras).ok()?;
    let parameters = extras.gnurt.parameters.iter().map(|(name, value)| (name.clone(), text(value)));
    Some((extras.gnurt.shader, parameters.collect()))
}

impl Material<'_> {
    /// The shader named in `extras`, and its parameters as texts; an object of another form belongs to
    /// another program.
    pub(super) fn shader(&self) -> Option<NamedShader> {
        shader_in(&mut serde_json::Deserializer::from_str(self.extras?.get()))
    }

    /// The light group in `extras`.
    pub(super) fn light_group(&self) -> Option<String> {
        #[derive(Deserialize)]
        struct Extras {
            light_group: String,
        }
        serde_json::from_str::<Extras>(self.extras?.get()).ok().map(|extras| extras.light_group)
    }

    /// Bytes of `extras`.
    pub(super) fn extras_bytes(&self) -> usize {
        self.extras.map_or(0, |extras| extras.get().len())
    }
}

impl Default for Material<'_> {
    fn default() -> Self {
        Self {
            name: None,
            pbr_metallic_roughness: MetallicRoughness::default(),
            normal_texture: None,
            emissive_texture: None,
            emissive_factor: [0.0; 3],
            alpha_mode: Text(Cow::Borrowed("OPAQUE")),
            alpha_cutoff: 0.5,
            extensions: MaterialExtensions::default(),
            extras: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct MetallicRoughness {
    pub(super) base_color_factor: [f32; 4],
    pub(super) base_color_texture: Option<TextureInfo>,
    pub(super) metallic_factor: f32,
    pub(super) roughness_factor: f32,
    pub(super) metallic_roughness_texture: Option<TextureInfo>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_anisotropy")]
    pub(super) anisotropy: Option<Anisotropy>,
    #[serde(rename = "KHR_materials_clearcoat")]
    pub(super) clearcoat: Option<Clearcoat>,
    #[serde(rename = "KHR_materials_diffuse_transmission")]
    pub(super) diffuse_transmission: Option<DiffuseTransmission>,
    #[serde(rename = "KHR_materials_dispersion")]
    pub(super) dispersion: Option<Dispersion>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(super) emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub(super) ior: Option<Ior>,
    #[serde(rename = "KHR_materials_iridescence")]
    pub(super) iridescence: Option<Iridescence>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(super) specular_glossiness: Option<SpecularGlossiness>,
    #[serde(rename = "KHR_materials_sheen")]
    pub(super) sheen: Option<Sheen>,
    #[serde(rename = "KHR_materials_specular")]
    pub(super) specular: Option<Specular>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(super) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_unlit")]
    pub(super) unlit: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_volume")]
    pub(super) volume: Option<Volume>,
    #[serde(rename = "KHR_materials_volume_scatter")]
    pub(super) volume_scatter: Option<VolumeScatter>,
}

/// Fields of a material extension, all with defaults.
macro_rules! extensions {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty = $default:expr),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Deserialize)]
        #[serde(rename_all = "camelCase", default)]
        pub(super) struct $name {
            $(pub(super) $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    )*};
}

extensions! {
    Anisotropy {
        anisotropy_strength: f32 = 0.0,
        anisotropy_rotation: f32 = 0.0,
        anisotropy_texture: Option<TextureInfo> = None,
    }
    Clearcoat {
        clearcoat_factor: f32 = 0.0,
        clearcoat_texture: Option<TextureInfo> = None,
        clearcoat_roughness_factor: f32 = 0.0,
        clearcoat_roughness_texture: Option<TextureInfo> = None,
        clearcoat_normal_texture: Option<TextureInfo> = None,
    }
    DiffuseTransmission {
        diffuse_transmission_factor: f32 = 0.0,
        diffuse_transmission_texture: Option<TextureInfo> = None,
        diffuse_transmission_color_factor: [f32; 3] = [1.0; 3],
        diffuse_transmission_color_texture: Option<TextureInfo> = None,
    }
    Dispersion { dispersion: f32 = 0.0 }
    EmissiveStrength { emissive_strength: f32 = 1.0 }
    Ior { ior: f32 = 1.5 }
    Iridescence {
        iridescence_factor: f32 = 0.0,
        iridescence_texture: Option<TextureInfo> = None,
        iridescence_ior: f32 = 1.3,
        iridescence_thickness_minimum: f32 = 100.0,
        iridescence_thickness_maximum: f32 = 400.0,
        iridescence_thickness_texture: Option<TextureInfo> = None,
    }
    Sheen {
        sheen_color_factor: [f32; 3] = [0.0; 3],
        sheen_color_texture: Option<TextureInfo> = None,
        sheen_roughness_factor: f32 = 0.0,
        sheen_roughness_texture: Option<TextureInfo> = None,
    }
    Specular {
        specular_factor: f32 = 1.0,
        specular_texture: Option<TextureInfo> = None,
        specular_color_factor: [f32; 3] = [1.0; 3],
        specular_color_texture: Option<TextureInfo> = None,
    }
    SpecularGlossiness {
        diffuse_factor: [f32; 4] = [1.0; 4],
        diffuse_texture: Option<TextureInfo> = None,
        specular_factor: [f32; 3] = [1.0; 3],
        glossiness_factor: f32 = 1.0,
        specular_glossiness_texture: Option<TextureInfo> = None,
    }
    Transmission {
        transmission_factor: f32 = 0.0,
        transmission_texture: Option<TextureInfo> = None,
    }
    Volume {
        thickness_factor: f32 = 0.0,
        thickness_texture: Option<TextureInfo> = None,
        attenuation_color: [f32; 3] = [1.0; 3],
        attenuation_distance: f32 = f32::INFINITY,
    }
    /// KHR_materials_volume_scatter; drafts have no `Factor` in the name.
    VolumeScatter {
        multiscatter_color: [f32; 3] = [0.0; 3],
        multiscatter_color_factor: Option<[f32; 3]> = None,
        multiscatter_color_texture: Option<TextureInfo> = None,
        scatter_anisotropy: f32 = 0.0,
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Mesh<'a> {
    pub(super) name: Option<String>,
    #[serde(borrow)]
    pub(super) primitives: Pieces<'a>,
    pub(super) weights: Vec<f32>,
    /// Contents of any form, written by any program.
    #[serde(borrow)]
    extras: Option<&'a RawValue>,
}

impl Mesh<'_> {
    /// The motion hint of its object, if it is given here.
    pub(super) fn motion(&self) -> Option<String> {
        #[derive(Deserialize)]
        struct Extras {
            gnurt_motion: String,
        }
        let extras = serde_json::from_str(self.extras?.get());
        extras.ok().map(|Extras { gnurt_motion }| gnurt_motion)
    }
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    #[serde(default)]
    pub(super) attributes: Attributes,
    #[serde(default)]
    pub(super) indices: Option<Index>,
    #[serde(default)]
    pub(super) material: Option<Index>,
    #[serde(deserialize_with = "whole", default = "triangles")]
    pub(super) mode: u64,
    #[serde(default)]
    pub(super) targets: Vec<Target>,
    #[serde(default)]
    pub(super) extensions: PrimitiveExtensions,
}

/// The attributes that a morph target moves.
#[derive(Deserialize, Clone, Copy)]
pub(super) struct Target {
    #[serde(rename = "POSITION", default)]
    pub(super) positions: Option<Index>,
    #[serde(rename = "NORMAL", default)]
    pub(super) normals: Option<Index>,
    #[serde(rename = "TANGENT", default)]
    pub(super) tangents: Option<Index>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<Draco>,
    #[serde(rename = "KHR_gaussian_splatting")]
    pub(super) splats: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_variants")]
    pub(super) variants: Option<Mappings>,
}

/// A compressed primitive: its stream, and the unique ids of the attributes in it.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Draco {
    pub(super) buffer_view: Index,
    pub(super) attributes: Attributes,
}

/// The materials of a primitive by variants.
#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Mappings {
    pub(super) mappings: Vec<Mapping>,
}

#[derive(Deserialize)]
pub(super) struct Mapping {
    pub(super) material: Index,
    pub(super) variants: Vec<Index>,
}

/// The accessors of a primitive's vertices, or their ids in a compressed stream.
#[derive(Default)]
pub(super) struct Attributes {
    pub(super) positions: Option<Index>,
    pub(super) normals: Option<Index>,
    pub(super) tangents: Option<Index>,
    pub(super) colors: Option<Index>,
    /// Sets of joints of a skin and of their weights, by their numbers.
    pub(super) joints: Vec<(u32, Index)>,
    pub(super) weights: Vec<(u32, Index)>,
    /// Sets of texture coordinates by their numbers.
    pub(super) texcoords: Vec<(u32, Index)>,
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AttributesVisitor;
        impl<'de> Visitor<'de> for AttributesVisitor {
            type Value = Attributes;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("accessors by the names of attributes")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Attributes, A::Error> {
                let mut found = Attributes::default();
                while let Some(Text(name)) = map.next_key()? {
                    let slot = match &*name {
                        "POSITION" => &mut found.positions,
                        "NORMAL" => &mut found.normals,
                        "TANGENT" => &mut found.tangents,
                        "COLOR_0" => &mut found.colors,
                        other => {
                            let sets = [
                                ("TEXCOORD_", &mut found.texcoords),
                                ("JOINTS_", &mut found.joints),
                                ("WEIGHTS_", &mut found.weights),
                            ];
                            let mut sets = sets.into_iter().filter_map(|(name, list)| {
                                Some((other.strip_prefix(name)?.parse().ok()?, list))
                            });
                            match sets.next() {
                                Some((set, list)) => list.push((set, map.next_value()?)),
                                None => drop(map.next_value::<IgnoredAny>()?),
                            }
                            continue;
                        }
                    };
                    *slot = Some(map.next_value()?);
                }
                Ok(found)
            }
        }
        deserializer.deserialize_map(AttributesVisitor)
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Node {
    pub(super) camera: Option<Index>,
    pub(super) children: Vec<Index>,
    pub(super) extensions: NodeExtensions,
    pub(super) extras: Option<serde_json::Value>,
    pub(super) matrix: Option<[f32; 16]>,
    pub(super) mesh: Option<Index>,
    pub(super) name: Option<String>,
    pub(super) rotation: Option<[f32; 4]>,
    pub(super) scale: Option<[f32; 3]>,
    pub(super) skin: Option<Index>,
    pub(super) translation: Option<[f32; 3]>,
    pub(super) weights: Option<Vec<f32>>,
}

/// The children of a node.
#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Children {
    pub(super) children: Vec<Index>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) light: Option<NodeLight>,
    #[serde(rename = "KHR_node_visibility")]
    pub(super) visibility: Option<NodeVisibility>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instances: Option<NodeInstances>,
}

/// EXT_mesh_gpu_instancing.
#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct NodeInstances {
    pub(super) attributes: InstanceAttributes,
}

/// Of each instance. Other attributes, for the shaders of the file's maker, are ignored.
#[derive(Deserialize, Default)]
#[serde(rename_all = "UPPERCASE", default)]
pub(super) struct InstanceAttributes {
    pub(super) translation: Option<Index>,
    pub(super) rotation: Option<Index>,
    pub(super) scale: Option<Index>,
}

/// KHR_node_visibility.
#[derive(Deserialize)]
#[serde(default)]
pub(super) struct NodeVisibility {
    pub(super) visible: bool,
}

impl Default for NodeVisibility {
    fn default() -> Self {
        Self { visible: true }
    }
}

#[derive(Deserialize)]
pub(super) struct NodeLight {
    pub(super) light: Index,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Scene {
    pub(super) nodes: Vec<Index>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    #[serde(default)]
    pub(super) inverse_bind_matrices: Option<Index>,
    pub(super) joints: Vec<Index>,
}

/// An index of one of the root's arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Index(pub(super) u32);

impl Index {
    pub(super) fn value(self) -> usize {
        self.0 as usize
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let number = whole(deserializer)?;
        u32::try_from(number)
            .map(Self)
            .map_err(|_| D::Error::custom(format_args!("index {number} is beyond 32 bits")))
    }
}

/// A string, borrowed where it has no escapes.
#[derive(Deserialize, Clone, Debug, Default, PartialEq)]
pub(super) struct Text<'a>(#[serde(borrow)] pub(super) Cow<'a, str>);

impl std::ops::Deref for Text<'_> {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

/// A whole number, in any notation.
fn whole<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    struct WholeVisitor;
    impl Visitor<'_> for WholeVisitor {
        type Value = u64;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a whole number that is not negative")
        }

        fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<u64, E> {
            Ok(number)
        }

        fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<u64, E> {
            // Up to 2^53 every whole number is itself.
            match number.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&number) {
                true => Ok(number as u64),
                false => Err(E::invalid_value(serde::de::Unexpected::Float(number), &self)),
            }
        }
    }
    deserializer.deserialize_u64(WholeVisitor)
}

fn one() -> f32 {
    1.0
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn triangles() -> u64 {
    4
}
