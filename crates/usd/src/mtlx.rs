// SPDX-License-Identifier: GPL-3.0-or-later
//! Networks of MaterialX's nodes, shaders called `ND_*`, as documents in memory.
//! Source: UsdShade. Tests: `tests/mtlx.rs`.

use std::collections::HashMap;
use std::fmt::Write;

use gnurt_image::udim;
use gnurt_scene::io::Oddity;
use gnurt_scene::io::reader::{Meaning, Pictures};
use openusd::sdf::{AssetPath, Path, Value};

use crate::network::Source;
use crate::reader::Reader;
use crate::value;

/// Shaders of a network.
const MOST: usize = 4096;

/// A network as a document.
pub(crate) struct Network {
    pub(crate) text: String,
    /// Its pictures, by the names that the document has for them.
    pub(crate) pictures: Vec<(String, AssetPath, Meaning)>,
    /// The primvar of its texture coordinates.
    pub(crate) texcoords: Option<String>,
}

/// The document of the network behind a surface's shader, and behind a shader of displacement.
pub(crate) fn network(reader: &Reader, surface: &Path, displacement: Option<&Path>) -> Network {
    let mut network = Network { text: String::new(), pictures: Vec::new(), texcoords: None };
    network.text.push_str("<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n");
    let mut numbers = HashMap::from([(surface.as_str().to_owned(), 0_usize)]);
    let mut open = vec![surface.clone()];
    if let Some(displacement) = displacement.filter(|path| *path != surface) {
        numbers.insert(displacement.as_str().to_owned(), 1);
        open.push(displacement.clone());
    }
    while let Some(shader) = open.pop() {
        let id = reader.shader_id(&shader);
        let name = node_name(&shader, numbers[shader.as_str()]);
        let _ = writeln!(network.text, "<node name=\"{name}\" nodedef=\"{}\">", escaped(&id));
        for property in &*reader.properties(&shader) {
            let Some(input) = property.strip_prefix("inputs:") else { continue };
            let at = escaped(input);
            match reader.source(&shader, property) {
                Some(Source::Shader { prim, output }) => {
                    if numbers.len() >= MOST && !numbers.contains_key(prim.as_str()) {
                        reader.unsupported(&shader, format_args!("network of more than {MOST} shaders"));
                        continue;
                    }
                    let next = numbers.len();
                    let number = *numbers.entry(prim.as_str().to_owned()).or_insert_with(|| {
                        open.push(prim.clone());
                        next
                    });
                    let (node, output) = (node_name(&prim, number), escaped(&output));
                    let _ = writeln!(
                        network.text,
                        "<input name=\"{at}\" nodename=\"{node}\" output=\"{output}\"/>"
                    );
                }
                Some(Source::Value(found)) => {
                    let space =
                        reader.metadata(&shader, property, "colorSpace").as_ref().and_then(value::word);
                    let space = space.unwrap_or_default();
                    if id.starts_with("ND_geompropvalue_vector2") && input == "geomprop" {
                        network.texcoords = value::word(&found);
                    }
                    let text = match &found {
                        Value::AssetPath(asset) => network.picture(asset, &space),
                        found => written(found),
                    };
                    match text {
                        Some(text) => {
                            let text = escaped(&text);
                            let space = escaped(&space);
                            let _ = writeln!(
                                network.text,
                                "<input name=\"{at}\" value=\"{text}\" colorspace=\"{space}\"/>"
                            );
                        }
                        None => reader.unsupported(&shader, format_args!("value of the input '{input}'")),
                    }
                }
                None => {}
            }
        }
        network.text.push_str("</node>\n");
    }
    let _ = writeln!(
        network.text,
        "<surfacematerial name=\"material\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" \
         nodename=\"{}\"/>",
        node_name(surface, 0)
    );
    if let Some(displacement) = displacement.filter(|path| *path != surface) {
        let name = node_name(displacement, 1);
        let _ = writeln!(
            network.text,
            "<input name=\"displacementshader\" type=\"displacementshader\" nodename=\"{name}\"/>"
        );
    }
    network.text.push_str("</surfacematerial>\n</materialx>");
    network
}

impl Network {
    /// The name of a picture in the document.
    fn picture(&mut self, asset: &AssetPath, space: &str) -> Option<String> {
        // Colours in spaces other than this are decoded by the document's graphs.
        let meaning = if space == "srgb_texture" { Meaning::Color } else { Meaning::Data };
        let name = match meaning {
            Meaning::Color => format!("{} (sRGB)", asset.as_str()),
            Meaning::Data => asset.as_str().to_owned(),
        };
        if self.pictures.iter().all(|(known, ..)| *known != name) {
            self.pictures.push((name.clone(), asset.clone(), meaning));
        }
        Some(name)
    }
}

/// The pictures of a network that can be read.
pub(crate) fn read_pictures(
    reader: &Reader,
    pictures: &mut Pictures<'_>,
    surface: &Path,
    network: &Network,
) -> Vec<(String, std::sync::Arc<gnurt_scene::texture::Texels>)> {
    let mut read = Vec::new();
    for (name, asset, meaning) in &network.pictures {
        let found = match udim::is_tiled(name) {
            false => reader.picture(pictures, asset, *meaning).map(|texels| vec![(name.clone(), texels)]),
            true => reader.picture_tiles(pictures, asset, *meaning).map(|tiles| {
                tiles.into_iter().map(|(tile, texels)| (udim::tile_name(name, tile), texels)).collect()
            }),
        };
        match found {
            Ok(found) => read.extend(found),
            Err(fault) => reader.note(Oddity::BadTexture, surface, fault),
        }
    }
    read
}

/// A node's name in the document: a prim's own, and its number.
fn node_name(prim: &Path, number: usize) -> String {
    match number {
        0 => prim.name().unwrap_or("surface").to_owned(),
        number => format!("{}_{number}", prim.name().unwrap_or("node")),
    }
}

/// A value as documents write it.
fn written(value: &Value) -> Option<String> {
    let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    match value {
        Value::Bool(flag) => Some(flag.to_string()),
        Value::Matrix3d(matrix) => Some(list(&matrix.0)),
        Value::Matrix4d(matrix) => Some(list(&matrix.0)),
        other => value::word(other).or_else(|| {
            let (_, numbers) = value::floats(other)?;
            Some(numbers.iter().map(f32::to_string).collect::<Vec<_>>().join(", "))
        }),
    }
}

/// The numbers of a value, for a shader's parameter.
pub(crate) fn parameter(value: &Value) -> Option<String> {
    let (_, numbers) = value::floats(value)?;
    Some(numbers.iter().map(f32::to_string).collect::<Vec<_>>().join(","))
}

fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => {}
            c => out.push(c),
        }
    }
    out
}
