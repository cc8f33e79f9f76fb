// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of networks: files and how they lie, and pictures made of single channels.
//! Source: the specification of UsdPreviewSurface (UsdUVTexture, UsdTransform2d, UsdPrimvarReader). Both have v upwards.
//! Tests: `tests/materials.rs`.

use std::collections::HashMap;
use std::sync::Arc;

use gnurt_image::udim;
use gnurt_scene::io::Oddity;
use gnurt_scene::io::reader::{Meaning, Pictures};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, Wrap};
use gnurt_scene::{Scene, TextureId};
use openusd::sdf::{AssetPath, Path, Value};

use crate::atlas::{self, Tile};
use crate::network::Source;
use crate::reader::Reader;
use crate::value;

/// Rows of tiles that are searched.
const MOST_ROWS: u32 = 100;

/// A texture that a network reads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sampled {
    pub(crate) texels: Arc<Texels>,
    pub(crate) name: String,
    pub(crate) wrap: [Wrap; 2],
    /// The channel that is read: `rgb`, `r`, `g`, `b` or `a`.
    pub(crate) output: String,
    pub(crate) scale: [f32; 4],
    pub(crate) bias: [f32; 4],
    /// As in `TextureRef`.
    pub(crate) uv_from_mesh: [f32; 6],
    /// The primvar with its coordinates.
    pub(crate) primvar: String,
}

/// Textures of a scene, each once.
#[derive(Default)]
pub(crate) struct Textures {
    known: HashMap<(usize, [Wrap; 2]), TextureId>,
    /// Kept, so that addresses stay those of one picture.
    kept: Vec<Arc<Texels>>,
}

impl Textures {
    /// The texture of a picture.
    pub(crate) fn id(&mut self, scene: &mut Scene, sampled: &Sampled) -> TextureId {
        let key = (Arc::as_ptr(&sampled.texels) as usize, sampled.wrap);
        *self.known.entry(key).or_insert_with(|| {
            self.kept.push(sampled.texels.clone());
            scene.add_texture(Texture {
                name: sampled.name.clone(),
                texels: sampled.texels.clone(),
                wrap: sampled.wrap,
                filter: Filter::Linear,
            })
        })
    }
}

impl Reader {
    /// The texture behind an output of a shader, if it is one that can be read.
    pub(crate) fn sampled(
        &self,
        pictures: &mut Pictures<'_>,
        shader: &Path,
        output: &str,
        meaning: Meaning,
    ) -> Option<Sampled> {
        let asset = match self.source(shader, "inputs:file")? {
            Source::Value(Value::AssetPath(asset)) => asset,
            _ => return None,
        };
        let meaning = match self.input_word(shader, "sourceColorSpace").as_deref() {
            Some("raw") => Meaning::Data,
            Some("sRGB") => Meaning::Color,
            _ => meaning,
        };
        let name = asset.as_str().to_owned();
        let is_tiled = udim::is_tiled(&name);
        let found = match is_tiled {
            false => self.picture(pictures, &asset, meaning).map(|texels| (texels, [1, 1])),
            true => self
                .picture_tiles(pictures, &asset, meaning)
                .and_then(|tiles| atlas::joined(&tiles, &self.files.access.budget))
                .map_err(|why| format!("{name}: {why}")),
        };
        let (texels, tiles) = match found {
            Ok(found) => found,
            Err(fault) => {
                self.note(Oddity::BadTexture, shader, fault);
                return None;
            }
        };
        let wrap = |key: &str| match self.input_word(shader, key).as_deref() {
            Some("clamp") => Wrap::ClampToEdge,
            Some("mirror") => Wrap::MirroredRepeat,
            Some("black") => {
                self.unsupported(shader, format_args!("{key} 'black', shown as 'clamp'"));
                Wrap::ClampToEdge
            }
            _ => Wrap::Repeat,
        };
        let wrap = if is_tiled { [Wrap::ClampToEdge; 2] } else { [wrap("wrapS"), wrap("wrapT")] };
        let (primvar, uv_from_mesh) = self.coordinates(shader);
        // The picture of all tiles is read from 0 to 1.
        let [across, up] = tiles.map(|count| 1.0 / count as f32);
        let uv_from_mesh = chained([across, 0.0, 0.0, up, 0.0, 0.0], uv_from_mesh);
        Some(Sampled {
            texels,
            name,
            wrap,
            output: output.to_owned(),
            scale: self.input_vector(shader, "scale").unwrap_or([1.0; 4]),
            bias: self.input_vector(shader, "bias").unwrap_or([0.0; 4]),
            uv_from_mesh,
            primvar,
        })
    }

    /// The pictures of an asset whose name stands for tiles: those of the tiles 1001 to 2000 that are there.
    pub(crate) fn picture_tiles(
        &self,
        pictures: &mut Pictures<'_>,
        asset: &AssetPath,
        meaning: Meaning,
    ) -> Result<Vec<Tile>, String> {
        let name = self.file_of(asset);
        let mut found = Vec::new();
        for tile in udim::tiles().take_while(|[_, row]| *row < MOST_ROWS) {
            let file = udim::tile_name(&name, tile);
            let picture = match crate::files::split(&file) {
                Some(_) => self.files.bytes(&file).ok().map(|bytes| pictures.decode(&bytes, &file, meaning)),
                None if std::path::Path::new(&file).is_file() => {
                    Some(pictures.file(std::path::Path::new(&file), meaning))
                }
                None => None,
            };
            if let Some(picture) = picture.transpose()? {
                found.push((tile, picture));
            }
        }
        if found.is_empty() { Err("no tile of it was found".into()) } else { Ok(found) }
    }

    /// The file of an asset.
    pub(crate) fn file_of(&self, asset: &AssetPath) -> String {
        let file = asset.resolved_path().map(str::to_owned);
        file.unwrap_or_else(|| self.path.with_file_name(asset.as_str()).to_string_lossy().into_owned())
    }

    /// The picture of an asset: a file, or an entry of a package.
    pub(crate) fn picture(
        &self,
        pictures: &mut Pictures<'_>,
        asset: &AssetPath,
        meaning: Meaning,
    ) -> Result<Arc<Texels>, String> {
        let (name, file) = (asset.as_str(), self.file_of(asset));
        match crate::files::split(&file) {
            Some(_) => self.files.bytes(&file).and_then(|bytes| pictures.decode(&bytes, name, meaning)),
            None => pictures.file(std::path::Path::new(&file), meaning),
        }
    }

    /// The primvar of a texture's coordinates, and what moves them.
    fn coordinates(&self, shader: &Path) -> (String, [f32; 6]) {
        let mut moved = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let mut source = self.source(shader, "inputs:st");
        for _ in 0..8 {
            let Some(Source::Shader { prim, .. }) = source else { break };
            match &self.shader_id(&prim)[..] {
                "UsdTransform2d" => {
                    moved = chained(moved, self.transform_2d(&prim));
                    source = self.source(&prim, "inputs:in");
                }
                id if id.starts_with("UsdPrimvarReader") => {
                    let name = self.source(&prim, "inputs:varname");
                    let name = match &name {
                        Some(Source::Value(found)) => value::word(found),
                        _ => None,
                    };
                    return (name.unwrap_or_else(|| "st".into()), moved);
                }
                id => {
                    self.unsupported(&prim, format_args!("texture coordinates by '{id}'"));
                    break;
                }
            }
        }
        ("st".into(), moved)
    }

    fn transform_2d(&self, shader: &Path) -> [f32; 6] {
        let (sin, cos) = (self.input_number(shader, "rotation").unwrap_or(0.0) as f32).to_radians().sin_cos();
        let [sx, sy] = self.input_vector(shader, "scale").unwrap_or([1.0; 2]);
        let [tx, ty] = self.input_vector(shader, "translation").unwrap_or([0.0; 2]);
        [cos * sx, sin * sx, -sin * sy, cos * sy, tx, ty]
    }
}

/// First `inner`, then `outer`.
fn chained(outer: [f32; 6], inner: [f32; 6]) -> [f32; 6] {
    let [a, b, c, d, e, f] = outer;
    let [p, q, r, s, t, u] = inner;
    [a * p + c * q, b * p + d * q, a * r + c * s, b * r + d * s, a * t + c * u + e, b * t + d * u + f]
}

/// A texture whose green and blue are single channels of two others, or numbers.
pub(crate) fn combined(parts: [(Option<&Sampled>, f32); 2]) -> Option<Sampled> {
    let like = parts.iter().filter_map(|(part, _)| *part).max_by_key(|part| part.texels.width)?;
    let (width, height) = (like.texels.width, like.texels.height);
    let value = |(part, fallback): (Option<&Sampled>, f32), x: u32, y: u32| {
        let Some(part) = part else { return fallback };
        let at = |i: u32, of: u32, to: u32| (u64::from(i) * u64::from(to) / u64::from(of)) as usize;
        let texel = part.texels.texel(at(x, width, part.texels.width), at(y, height, part.texels.height));
        let channel = channel(&part.output);
        texel[channel] * part.scale[channel] + part.bias[channel]
    };
    let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let data = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let data = data.map(|(x, y)| [255, byte(value(parts[0], x, y)), byte(value(parts[1], x, y)), 255]);
    let texels = Texels { width, height, data: TexelData::Linear8(data.collect()) };
    Some(Sampled { texels: Arc::new(texels), ..like.clone() })
}

/// The place of a channel among red, green, blue and opacity.
pub(crate) fn channel(output: &str) -> usize {
    match output {
        "g" => 1,
        "b" => 2,
        "a" => 3,
        _ => 0,
    }
}
