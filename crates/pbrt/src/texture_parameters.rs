// SPDX-License-Identifier: GPL-3.0-or-later
//! The statement `Texture`: its kinds, mappings and parameters.
//! Source: the section Textures of the file-format page. Tests: `tests/textures.rs`.

use std::collections::HashMap;
use std::sync::Arc;

use gnurt_scene::Affine;
use gnurt_scene::io::reader::{Access, quoted, resolve};
use gnurt_scene::io::{Error, Oddity, Warnings};
use gnurt_scene::texture::Wrap;

use crate::parameter::{Kind, Parameters};
use crate::spectrum::Spectrum;
use crate::texture::{DEEPEST, Encoding, Image, Input, Mapping, Node, Noise, Texture};

/// Octaves that noise may have.
const MOST_OCTAVES: i32 = 16;

/// The textures of a scene by their names.
#[derive(Default)]
pub(crate) struct Textures {
    /// Of numbers.
    pub(crate) floats: HashMap<String, Arc<Texture>>,
    /// Of colours.
    pub(crate) spectra: HashMap<String, Arc<Texture>>,
}

impl Textures {
    /// The texture of this name.
    fn find(&self, name: &str, is_float: bool, parameters: &Parameters) -> Result<Arc<Texture>, Error> {
        let [list, others] =
            if is_float { [&self.floats, &self.spectra] } else { [&self.spectra, &self.floats] };
        list.get(name).cloned().ok_or_else(|| {
            let kind = if is_float { "float" } else { "spectrum" };
            let problem = format!("no {kind} texture {} is defined before", quoted(name));
            let remedy = match others.contains_key(name) {
                true => format!("that texture is not of type \"{kind}\""),
                false => format!("define it: Texture \"{name}\" \"{kind}\" ..."),
            };
            parameters.location.error(problem, remedy)
        })
    }

    /// A number or a texture of numbers.
    pub(crate) fn float(&self, parameters: &Parameters, name: &str) -> Result<Option<Input>, Error> {
        if let Some(texture) = parameters.texture(name)? {
            return self.find(texture, true, parameters).map(|found| Some(Input::Texture(found)));
        }
        Ok(parameters.float(name)?.map(Input::number))
    }

    /// A colour or a texture of colours.
    pub(crate) fn spectrum(
        &self,
        parameters: &Parameters,
        name: &str,
        access: &Access,
    ) -> Result<Option<Input>, Error> {
        if let Some(texture) = parameters.texture(name)? {
            return self.find(texture, false, parameters).map(|found| Some(Input::Texture(found)));
        }
        Ok(Spectrum::of(parameters, name, access)?.map(|spectrum| Input::Constant(spectrum.value())))
    }
}

/// What a texture is read with.
pub(crate) struct Reading<'a> {
    pub(crate) textures: &'a Textures,
    pub(crate) access: &'a Access,
    /// From the renderer's world to the current space.
    pub(crate) texture_from_world: Affine,
    /// And back.
    pub(crate) world_from_texture: Affine,
    pub(crate) is_float: bool,
}

impl Reading<'_> {
    fn input(&self, parameters: &Parameters, name: &str, default: f32) -> Result<Input, Error> {
        let given = match self.is_float {
            true => self.textures.float(parameters, name)?,
            false => self.textures.spectrum(parameters, name, self.access)?,
        };
        Ok(given.unwrap_or(Input::number(default)))
    }

    fn number(&self, parameters: &Parameters, name: &str, default: f32) -> Result<Input, Error> {
        Ok(self.textures.float(parameters, name)?.unwrap_or(Input::number(default)))
    }

    /// The texture of a class with these parameters.
    pub(crate) fn read(
        &self,
        class: &str,
        parameters: &Parameters,
        warnings: &mut Warnings,
    ) -> Result<Texture, Error> {
        let location = parameters.location.clone();
        let pair = |[a, b]: [&str; 2], [x, y]: [f32; 2]| -> Result<[Input; 2], Error> {
            Ok([self.input(parameters, a, x)?, self.input(parameters, b, y)?])
        };
        let (node, parts) = match class {
            "constant" => {
                let value = self.input(parameters, "value", 1.0)?;
                (Node::Constant(value.constant().unwrap_or([1.0; 3])), 0)
            }
            "imagemap" => (Node::Image(self.image(parameters)?), 0),
            "ptex" => {
                location.warn(warnings, Oddity::StandIn, "texture \"ptex\", shown as a grey of 0.5");
                parameters.ignore();
                (Node::Constant([0.5; 3]), 0)
            }
            "scale" => {
                let [tex, scale] =
                    [self.input(parameters, "tex", 1.0)?, self.number(parameters, "scale", 1.0)?];
                let depth = tex.depth().max(scale.depth());
                (Node::Scale(tex, scale), depth)
            }
            "mix" => {
                let ends = pair(["tex1", "tex2"], [0.0, 1.0])?;
                let amount = self.number(parameters, "amount", 0.5)?;
                let depth = ends.iter().map(Input::depth).fold(amount.depth(), u32::max);
                (Node::Mix(ends, amount), depth)
            }
            "directionmix" => {
                let ends = pair(["tex1", "tex2"], [0.0, 1.0])?;
                let dir = parameters.triple_or("dir", [0.0, 1.0, 0.0])?;
                let dir = self.world_from_texture.vector(dir.map(f64::from)).map(|x| x as f32);
                let depth = ends[0].depth().max(ends[1].depth());
                (Node::DirectionMix(ends, dir), depth)
            }
            "bilerp" => {
                let mapping = self.mapping(parameters)?;
                let corner = |name: &str, default: f32| -> Result<[f32; 3], Error> {
                    Ok(self.input(parameters, name, default)?.constant().unwrap_or([default; 3]))
                };
                let corners =
                    [corner("v00", 0.0)?, corner("v01", 1.0)?, corner("v10", 0.0)?, corner("v11", 1.0)?];
                (Node::Bilerp(mapping, corners), 0)
            }
            "checkerboard" => {
                let ends = pair(["tex1", "tex2"], [1.0, 0.0])?;
                let depth = ends[0].depth().max(ends[1].depth());
                match parameters.int("dimension")?.unwrap_or(2) {
                    2 => (Node::Checkerboard(self.mapping(parameters)?, ends), depth),
                    3 => (Node::Boxes(self.texture_from_world, ends), depth),
                    other => {
                        return Err(location
                            .error(format!("\"dimension\" {other} of a checkerboard"), "expected 2 or 3"));
                    }
                }
            }
            "dots" => {
                let ends = pair(["inside", "outside"], [1.0, 0.0])?;
                let depth = ends[0].depth().max(ends[1].depth());
                (Node::Dots(self.mapping(parameters)?, ends), depth)
            }
            "fbm" => (Node::Fbm(self.texture_from_world, noise(parameters)?), 0),
            "wrinkled" => (Node::Wrinkled(self.texture_from_world, noise(parameters)?), 0),
            "windy" => (Node::Windy(self.texture_from_world), 0),
            "marble" => {
                let marble = Node::Marble {
                    texture_from_world: self.texture_from_world,
                    noise: noise(parameters)?,
                    scale: parameters.float_or("scale", 1.0)?,
                    variation: parameters.float_or("variation", 0.2)?,
                };
                (marble, 0)
            }
            other => {
                let known = "bilerp, checkerboard, constant, directionmix, dots, fbm, imagemap, marble, mix, scale, \
                             windy, wrinkled";
                let problem = format!("unknown texture class {}", quoted(other));
                return Err(location.error(problem, format!("valid are {known}")));
            }
        };
        let depth = parts + 1;
        if depth > DEEPEST {
            let problem = format!("textures lie in one another more than {DEEPEST} deep");
            return Err(location.error(problem, "make the texture of fewer"));
        }
        Ok(Texture { node, depth, location })
    }

    fn image(&self, parameters: &Parameters) -> Result<Image, Error> {
        let location = &parameters.location;
        let name = parameters.text("filename")?.ok_or_else(|| {
            location.error("an imagemap has no \"string filename\"", "name the file of its picture")
        })?;
        let wrong = |what: &str, found: &str, valid: &str| {
            location.error(
                format!("unknown {what} {} of an imagemap", quoted(found)),
                format!("valid are {valid}"),
            )
        };
        let wrap = match parameters.text("wrap")?.unwrap_or("repeat") {
            "repeat" => Some(Wrap::Repeat),
            "clamp" => Some(Wrap::ClampToEdge),
            "black" => None,
            "octahedralsphere" => Some(Wrap::ClampToEdge),
            other => return Err(wrong("wrap", other, "black, clamp, octahedralsphere and repeat")),
        };
        let nearest = match parameters.text("filter")?.unwrap_or("bilinear") {
            "point" => true,
            "bilinear" | "trilinear" | "EWA" | "ewa" => false,
            other => return Err(wrong("filter", other, "bilinear, EWA, point and trilinear")),
        };
        parameters.find("maxanisotropy", &[Kind::Float]);
        let is_png = name.to_ascii_lowercase().ends_with(".png");
        // Other pictures of bytes are always sRGB.
        let encoding = match parameters.text("encoding")?.filter(|_| is_png).unwrap_or("sRGB") {
            "sRGB" => Encoding::Srgb,
            "linear" => Encoding::Linear,
            other => match other.strip_prefix("gamma ").and_then(|gamma| gamma.trim().parse().ok()) {
                Some(gamma) if gamma > 0.0 => Encoding::Gamma(gamma),
                _ => return Err(wrong("encoding", other, "\"gamma NUMBER\", linear and sRGB")),
            },
        };
        Ok(Image {
            path: resolve(&location.path, name),
            mapping: self.mapping(parameters)?,
            wrap,
            nearest,
            scale: parameters.float_or("scale", 1.0)?,
            invert: parameters.bool_or("invert", false)?,
            encoding,
            is_float: self.is_float,
        })
    }

    fn mapping(&self, parameters: &Parameters) -> Result<Mapping, Error> {
        let number = |name: &str, default: f32| parameters.float_or(name, default);
        Ok(match parameters.text("mapping")?.unwrap_or("uv") {
            "uv" => Mapping::Uv {
                scale: [number("uscale", 1.0)?, number("vscale", 1.0)?],
                offset: [number("udelta", 0.0)?, number("vdelta", 0.0)?],
            },
            "spherical" => Mapping::Spherical(self.texture_from_world),
            "cylindrical" => Mapping::Cylindrical(self.texture_from_world),
            "planar" => Mapping::Planar {
                texture_from_world: self.texture_from_world,
                axes: [
                    parameters.triple_or("v1", [1.0, 0.0, 0.0])?,
                    parameters.triple_or("v2", [0.0, 1.0, 0.0])?,
                ],
                offset: [number("udelta", 0.0)?, number("vdelta", 0.0)?],
            },
            other => {
                let problem = format!("unknown mapping {}", quoted(other));
                return Err(parameters
                    .location
                    .error(problem, "valid are cylindrical, planar, spherical and uv"));
            }
        })
    }
}

fn noise(parameters: &Parameters) -> Result<Noise, Error> {
    let octaves = parameters.int("octaves")?.unwrap_or(8).clamp(0, MOST_OCTAVES);
    Ok(Noise { octaves, roughness: parameters.float_or("roughness", 0.5)? })
}
