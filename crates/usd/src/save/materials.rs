// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials of a scene as networks of UsdPreviewSurface.
//! Properties beyond that surface are left out with a warning. Tests: `tests/save.rs`.

use std::path::Path;

use gnurt_scene::displacement::{Displacement, Offset, Refinement};
use gnurt_scene::io::Warnings;
use gnurt_scene::io::writer::leave_out;
use gnurt_scene::material::{
    Alpha, Color, Material, NormalMap, Opacity, OpacityChannel, Surface, TextureRef,
};
use gnurt_scene::texture::Wrap;
use gnurt_scene::{Scene, Texture};

use super::text::{Text, tuple};

/// Inputs of a preview surface.
struct Preview {
    diffuse: Color,
    metallic: f32,
    roughness: f32,
    /// Green times roughness, blue times metallic.
    details: Option<TextureRef>,
    normals: Option<NormalMap>,
    ior: f32,
    clearcoat: [f32; 2],
    emission: [f32; 3],
    emission_texture: Option<TextureRef>,
}

/// Writes a material and the displacement of its surfaces; its name.
pub(super) fn write(
    (material, displacement): (&Material, Option<&Displacement>),
    scene: &Scene,
    files: &[String],
    text: &mut Text,
) -> String {
    let preview = preview(material);
    let name =
        text.open("def Material", if material.name.is_empty() { "Material" } else { &material.name }, &[]);
    let path = format!("/World/Looks/{name}");
    text.line(format_args!("token outputs:surface.connect = <{path}/Surface.outputs:surface>"));
    let height = displacement.and_then(height);
    if height.is_some() {
        text.line(format_args!("token outputs:displacement.connect = <{path}/Surface.outputs:displacement>"));
    }
    text.open("def Shader", "Surface", &[]);
    text.line("uniform token info:id = \"UsdPreviewSurface\"");
    let mut maps: Vec<Map> = Vec::new();
    let mut input = |text: &mut Text, kind: &str, name: &str, value: String, map: Option<Map>| match map {
        Some(map) => {
            let (shader, output) = (&map.shader, map.output);
            text.line(format_args!("{kind} inputs:{name}.connect = <{path}/{shader}.outputs:{output}>"));
            if !maps.iter().any(|known| known.shader == map.shader) {
                maps.push(map);
            }
        }
        None => text.line(format_args!("{kind} inputs:{name} = {value}")),
    };
    let color = |factor: [f32; 3], texture: Option<TextureRef>, shader: &str| {
        texture.map(|texture| Map {
            shader: shader.to_owned(),
            texture,
            output: "rgb",
            scale: [factor[0], factor[1], factor[2], 1.0],
            bias: [0.0; 4],
            is_color: true,
        })
    };
    let diffuse = preview.diffuse;
    input(
        text,
        "color3f",
        "diffuseColor",
        tuple(diffuse.factor),
        color(diffuse.factor, diffuse.texture, "Color"),
    );
    let detail = |output: &'static str| {
        let scale = [1.0, preview.roughness, preview.metallic, 1.0];
        preview.details.map(|texture| Map {
            shader: "Details".into(),
            texture,
            output,
            scale,
            bias: [0.0; 4],
            is_color: false,
        })
    };
    input(text, "float", "roughness", preview.roughness.to_string(), detail("g"));
    input(text, "float", "metallic", preview.metallic.to_string(), detail("b"));
    if let Some(normals) = preview.normals {
        let s = normals.scale;
        let map = Map {
            shader: "Normals".into(),
            texture: normals.texture,
            output: "rgb",
            scale: [2.0 * s, 2.0 * s, 2.0, 1.0],
            bias: [-s, -s, -1.0, 0.0],
            is_color: false,
        };
        input(text, "normal3f", "normal", String::new(), Some(map));
    }
    if preview.emission != [0.0; 3] {
        let map = color(preview.emission, preview.emission_texture, "Emission");
        input(text, "color3f", "emissiveColor", tuple(preview.emission), map);
    }
    if let Some((opacity, cutoff)) = opacity(material) {
        let map = opacity.texture.map(|texture| Map {
            // One picture for colour and opacity where it is one.
            shader: if preview.diffuse.texture == Some(texture) { "Color".into() } else { "Opacity".into() },
            texture,
            output: if opacity.channel == OpacityChannel::Alpha { "a" } else { "r" },
            scale: match preview.diffuse.texture == Some(texture) {
                true => [diffuse.factor[0], diffuse.factor[1], diffuse.factor[2], 1.0],
                false => [opacity.factor; 4],
            },
            bias: [0.0; 4],
            is_color: opacity.channel == OpacityChannel::Alpha,
        });
        input(text, "float", "opacity", opacity.factor.to_string(), map);
        if let Some(cutoff) = cutoff {
            text.line(format_args!("float inputs:opacityThreshold = {}", cutoff.max(f32::MIN_POSITIVE)));
        }
    }
    if let Some((height, map)) = height {
        input(text, "float", "displacement", height.to_string(), map);
        text.line("token outputs:displacement");
    }
    text.line(format_args!("float inputs:ior = {}", preview.ior));
    if preview.clearcoat[0] > 0.0 {
        text.line(format_args!("float inputs:clearcoat = {}", preview.clearcoat[0]));
        text.line(format_args!("float inputs:clearcoatRoughness = {}", preview.clearcoat[1]));
    }
    text.line("token outputs:surface");
    text.close();
    if !maps.is_empty() {
        text.open("def Shader", "Coordinates", &[]);
        text.line("uniform token info:id = \"UsdPrimvarReader_float2\"");
        text.line("string inputs:varname = \"st\"");
        text.line("float2 outputs:result");
        text.close();
    }
    for map in &maps {
        map.write(
            &path,
            &scene.textures()[map.texture.texture.index()],
            &files[map.texture.texture.index()],
            text,
        );
    }
    text.close();
    name
}

/// The displacement as a preview surface has it: a height, or a texture of heights.
fn height(displacement: &Displacement) -> Option<(f32, Option<Map>)> {
    let Displacement { offset, scale, midlevel, .. } = *displacement;
    match offset {
        Offset::Constant(x) => Some(((x - midlevel) * scale, None)),
        Offset::Height { texture, channel } => {
            let output = *["r", "g", "b", "a"].get(usize::from(channel))?;
            let (scale, bias) = ([scale; 4], [-midlevel * scale; 4]);
            let map = Map { shader: "Height".into(), texture, output, scale, bias, is_color: false };
            Some((0.0, Some(map)))
        }
        Offset::Vector { .. } | Offset::Shader(_) => None,
    }
}

/// A texture that an input reads.
struct Map {
    shader: String,
    texture: TextureRef,
    output: &'static str,
    scale: [f32; 4],
    bias: [f32; 4],
    is_color: bool,
}

impl Map {
    fn write(&self, path: &str, texture: &Texture, file: &str, text: &mut Text) {
        let [a, b, c, d, e, f] = self.texture.uv_from_mesh;
        let is_moved = [a, b, c, d, e, f] != [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let coordinates = match is_moved {
            true => format!("{path}/{}Place", self.shader),
            false => format!("{path}/Coordinates"),
        };
        if is_moved {
            text.open("def Shader", &format!("{}Place", self.shader), &[]);
            text.line("uniform token info:id = \"UsdTransform2d\"");
            text.line(format_args!("float2 inputs:in.connect = <{path}/Coordinates.outputs:result>"));
            let scale = [a.hypot(b), c.hypot(d).copysign(a * d - b * c)];
            text.line(format_args!("float inputs:rotation = {}", b.atan2(a).to_degrees()));
            text.line(format_args!("float2 inputs:scale = {}", tuple(scale)));
            text.line(format_args!("float2 inputs:translation = {}", tuple([e, f])));
            text.line("float2 outputs:result");
            text.close();
        }
        text.open("def Shader", &self.shader, &[]);
        text.line("uniform token info:id = \"UsdUVTexture\"");
        text.line(format_args!("asset inputs:file = @{file}@"));
        text.line(format_args!("float2 inputs:st.connect = <{coordinates}.outputs:result>"));
        for (name, wrap) in ["wrapS", "wrapT"].into_iter().zip(texture.wrap) {
            let word = match wrap {
                Wrap::Repeat => "repeat",
                Wrap::MirroredRepeat => "mirror",
                Wrap::ClampToEdge => "clamp",
            };
            text.line(format_args!("token inputs:{name} = \"{word}\""));
        }
        let space = if self.is_color { "sRGB" } else { "raw" };
        text.line(format_args!("token inputs:sourceColorSpace = \"{space}\""));
        if self.scale != [1.0; 4] {
            text.line(format_args!("float4 inputs:scale = {}", tuple(self.scale)));
        }
        if self.bias != [0.0; 4] {
            text.line(format_args!("float4 inputs:bias = {}", tuple(self.bias)));
        }
        for output in
            ["float3 outputs:rgb", "float outputs:r", "float outputs:g", "float outputs:b", "float outputs:a"]
        {
            text.line(output);
        }
        text.close();
    }
}

fn preview(material: &Material) -> Preview {
    let plain = Preview {
        diffuse: material.surface.base_color(),
        metallic: 0.0,
        roughness: 1.0,
        details: None,
        normals: None,
        ior: 1.5,
        clearcoat: [0.0; 2],
        emission: material.emission,
        emission_texture: material.emission_texture,
    };
    match &material.surface {
        Surface::MetallicRoughness {
            metallic,
            roughness,
            metallic_roughness_texture,
            ior,
            normal_texture,
            ..
        } => Preview {
            metallic: *metallic,
            roughness: *roughness,
            details: *metallic_roughness_texture,
            normals: *normal_texture,
            ior: *ior,
            ..plain
        },
        Surface::Principled(p) => Preview {
            metallic: p.metallic,
            roughness: p.roughness,
            details: p.metallic_roughness_texture,
            normals: p.normal_texture,
            ior: p.ior,
            clearcoat: [p.clearcoat, p.clearcoat_roughness],
            ..plain
        },
        Surface::Metal { roughness, .. } => Preview { metallic: 1.0, roughness: *roughness, ..plain },
        Surface::Mirror { .. } => Preview { metallic: 1.0, roughness: 0.0, ..plain },
        Surface::Dielectric { ior, .. } => Preview { roughness: 0.0, ior: *ior, ..plain },
        Surface::RoughDielectric { ior, roughness, .. } => {
            Preview { roughness: *roughness, ior: *ior, ..plain }
        }
        Surface::Unlit { color } => Preview {
            diffuse: Color::constant([0.0; 3]),
            emission: color.factor,
            emission_texture: color.texture,
            ..plain
        },
        _ => plain,
    }
}

/// The opacity, and the least that is there.
fn opacity(material: &Material) -> Option<(Opacity, Option<f32>)> {
    const GLASS: Opacity = Opacity { factor: 0.1, texture: None, channel: OpacityChannel::Alpha };
    match material.alpha {
        Alpha::Blend { opacity } => Some((opacity, None)),
        Alpha::Mask { cutoff, opacity } => Some((opacity, Some(cutoff))),
        Alpha::Opaque if is_glass(material) => Some((GLASS, None)),
        Alpha::Opaque => None,
    }
}

fn is_glass(material: &Material) -> bool {
    matches!(material.surface, Surface::Dielectric { .. } | Surface::RoughDielectric { .. })
}

/// Warns of properties that a preview surface does not have.
pub(super) fn leave_out_layers(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let mut count_displaced = |is: &dyn Fn(&Displacement) -> bool, what: &str| {
        leave_out(scene.displacements().filter(|(_, one)| is(one)).count(), what, path, warnings);
    };
    count_displaced(&|one| height(one).is_none(), "displacement by vectors or a shader");
    count_displaced(&|one| one.refinement != Refinement::None, "refinement of displaced meshes");
    let mut count = |is: &dyn Fn(&Material) -> bool, what: &str| {
        leave_out(scene.materials().iter().filter(|material| is(material)).count(), what, path, warnings);
    };
    count(&is_glass, "glass, written as a transparent surface");
    count(&|m| matches!(m.surface, Surface::Unlit { .. }), "unlit colour, written as a lamp");
    count(&|m| m.bump.is_some(), "bump map");
    let principled = |is: fn(&gnurt_scene::material::Principled) -> bool| move |m: &Material| matches!(&m.surface, Surface::Principled(p) if is(p));
    count(&principled(|p| p.transmission > 0.0), "transmission");
    count(&principled(|p| p.sheen_color != [0.0; 3]), "sheen");
    count(&principled(|p| p.specular != 1.0 || p.specular_color != [1.0; 3]), "specular weight and colour");
    count(&principled(|p| p.anisotropy.strength > 0.0), "anisotropy");
    count(&principled(|p| p.iridescence.factor > 0.0), "thin film");
    count(&principled(|p| p.diffuse_transmission.factor > 0.0), "diffuse transmission");
    count(&principled(|p| p.subsurface.factor > 0.0), "light below the surface, written as diffuse");
}
