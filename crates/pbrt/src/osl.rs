// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures as statements of the shading language: each texture once per shader, its inputs before it.
//! Invariants: a shader has at most [`MOST`] textures; the text is ASCII whatever the file holds; numbers are finite.
//! Tests: `tests/textures.rs`.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use gnurt_scene::texture::Wrap;
use gnurt_scene::{Affine, TextureId};

use crate::material::Material;
use crate::texture::{Encoding, Image, Input, Mapping, Node, Texture};

/// Textures of a shader.
const MOST: usize = 256;

/// The pictures and materials that shaders refer to.
pub(crate) trait Library {
    /// The texture of the scene for a picture, or `None` if it cannot be read.
    fn picture(&mut self, image: &Image, texture: &Texture) -> Option<TextureId>;
    /// Whether some texels of a picture are not opaque.
    fn has_opacity(&self, id: TextureId) -> bool;
    /// That for a picture of normals.
    fn normals(&mut self, path: &Path, material: &Material) -> Option<TextureId>;
    /// The material of a number.
    fn material(&self, number: u32) -> Option<Material>;
}

/// A shader that is being written.
pub(crate) struct Code<'a> {
    pub(crate) text: String,
    pub(crate) pictures: Vec<(String, TextureId)>,
    pub(crate) library: &'a mut dyn Library,
    /// Variables of textures, by their places in memory.
    known: HashMap<*const Texture, String>,
    count: usize,
    /// Materials that were written.
    pub(crate) models: u32,
}

/// A number as the shading language has it.
pub(crate) fn number(x: f32) -> String {
    let x = if x.is_finite() { x } else { 0.0 };
    if x < 0.0 { format!("({x:?})") } else { format!("{x:?}") }
}

/// A colour.
pub(crate) fn color(c: [f32; 3]) -> String {
    let [r, g, b] = c.map(number);
    format!("color ({r}, {g}, {b})")
}

impl<'a> Code<'a> {
    pub(crate) fn new(library: &'a mut dyn Library) -> Self {
        Self {
            text: String::new(),
            pictures: Vec::new(),
            library,
            known: HashMap::new(),
            count: 0,
            models: 0,
        }
    }

    /// The name of a new variable.
    pub(crate) fn name(&mut self, prefix: char) -> String {
        self.count += 1;
        format!("{prefix}{}", self.count)
    }

    /// Adds a statement.
    pub(crate) fn line(&mut self, line: impl AsRef<str>) {
        self.text.push_str("    ");
        self.text.push_str(line.as_ref());
        self.text.push('\n');
    }

    /// A colour as an expression.
    pub(crate) fn color(&mut self, input: &Input) -> String {
        match input {
            Input::Constant(value) => color(*value),
            Input::Texture(texture) => self.texture(texture),
        }
    }

    /// A number as an expression.
    pub(crate) fn float(&mut self, input: &Input) -> String {
        match input {
            Input::Constant(value) => number(value[0]),
            Input::Texture(texture) => format!("{}[0]", self.texture(texture)),
        }
    }

    /// The variable of a texture; all are colours, those of numbers grey.
    fn texture(&mut self, texture: &Arc<Texture>) -> String {
        if let Some(known) = self.known.get(&Arc::as_ptr(texture)) {
            return known.clone();
        }
        let name = self.name('t');
        let expression = match self.known.len() < MOST {
            true => self.expression(&texture.node, texture),
            false => "color (0.5)".into(),
        };
        self.line(format!("color {name} = {expression};"));
        self.known.insert(Arc::as_ptr(texture), name.clone());
        name
    }

    fn expression(&mut self, node: &Node, texture: &Texture) -> String {
        match node {
            Node::Constant(value) => color(*value),
            Node::Image(image) => self.image(image, texture),
            Node::Scale(of, by) => {
                let [of, by] = [self.color(of), self.float(by)];
                format!("{of} * {by}")
            }
            Node::Mix(ends, amount) => {
                let amount = self.float(amount);
                self.mixed(ends, &amount)
            }
            Node::DirectionMix(ends, dir) => {
                let [x, y, z] = dir.map(number);
                let amount = format!("fabs (dot (normalize (N), normalize (vector ({x}, {y}, {z}))))");
                // The first one where the normal lies along the direction.
                let [a, b] = ends;
                self.mixed(&[b.clone(), a.clone()], &amount)
            }
            Node::Bilerp(mapping, corners) => {
                let [s, t] = self.mapped(mapping);
                let [c00, c01, c10, c11] = corners.map(color);
                format!("mix (mix ({c00}, {c10}, {s}), mix ({c01}, {c11}, {s}), {t})")
            }
            Node::Checkerboard(mapping, ends) => {
                let [s, t] = self.mapped(mapping);
                self.mixed(ends, &format!("mod (pbrt_board ({s}) + pbrt_board ({t}), 2)"))
            }
            Node::Boxes(texture_from_world, ends) => {
                let [x, y, z] = self.location(texture_from_world);
                self.mixed(ends, &format!("mod (pbrt_board ({x}) + pbrt_board ({y}) + pbrt_board ({z}), 2)"))
            }
            Node::Dots(mapping, [inside, outside]) => {
                let [s, t] = self.mapped(mapping);
                self.mixed(&[outside.clone(), inside.clone()], &format!("pbrt_dot ({s}, {t})"))
            }
            Node::Fbm(texture_from_world, noise) => {
                let at = self.point(texture_from_world);
                format!("color (pbrt_fbm ({at}, {}, {}))", number(noise.roughness), noise.octaves)
            }
            Node::Wrinkled(texture_from_world, noise) => {
                let at = self.point(texture_from_world);
                format!("color (pbrt_turbulence ({at}, {}, {}))", number(noise.roughness), noise.octaves)
            }
            Node::Windy(texture_from_world) => {
                let at = self.point(texture_from_world);
                format!("color (fabs (pbrt_fbm (0.1 * {at}, 0.5, 3)) * pbrt_fbm ({at}, 0.5, 6))")
            }
            Node::Marble { texture_from_world, noise, scale, variation } => {
                let at = self.point(texture_from_world);
                let at = format!("({} * {at})", number(*scale));
                let fbm = format!("pbrt_fbm ({at}, {}, {})", number(noise.roughness), noise.octaves);
                let height = self.name('f');
                self.line(format!("point {height} = {at};"));
                format!("pbrt_marble ({height}[1] + {} * {fbm})", number(*variation))
            }
        }
    }

    fn mixed(&mut self, ends: &[Input; 2], amount: &str) -> String {
        let [a, b] = [self.color(&ends[0]), self.color(&ends[1])];
        format!("mix ({a}, {b}, color ({amount}))")
    }

    /// Coordinates of the place in a space, as variables.
    fn location(&mut self, to: &Affine) -> [String; 3] {
        let point = self.point(to);
        [0, 1, 2].map(|k| format!("{point}[{k}]"))
    }

    /// The place in a space, as a variable.
    fn point(&mut self, to: &Affine) -> String {
        let name = self.name('p');
        let row = |k: usize| {
            let [a, b, c, d] = to.columns.map(|column| number(column[k] as f32));
            format!("{a} * P[0] + {b} * P[1] + {c} * P[2] + {d}")
        };
        self.line(format!("point {name} = point ({}, {}, {});", row(0), row(1), row(2)));
        name
    }

    /// Texture coordinates, as expressions; t upwards.
    fn mapped(&mut self, mapping: &Mapping) -> [String; 2] {
        match mapping {
            Mapping::Uv { scale, offset } => {
                let [[a, b], [c, d]] = [scale, offset].map(|pair| pair.map(number));
                [format!("({a} * u + {c})"), format!("({b} * v + {d})")]
            }
            Mapping::Spherical(to) => {
                let [x, y, z] = self.location(to);
                let [s, t] = [self.name('f'), self.name('f')];
                self.line(format!("float {s} = acos (clamp ({z} / max (length (point ({x}, {y}, {z})), 1e-12), -1, 1)) / M_PI;"));
                self.line(format!("float {t} = atan2 ({y}, {x}) / M_2PI; {t} = {t} < 0 ? {t} + 1 : {t};"));
                [s, t]
            }
            Mapping::Cylindrical(to) => {
                let [x, y, z] = self.location(to);
                let s = self.name('f');
                self.line(format!("float {s} = (M_PI + atan2 ({y}, {x})) / M_2PI;"));
                [s, z]
            }
            Mapping::Planar { texture_from_world, axes, offset } => {
                let [x, y, z] = self.location(texture_from_world);
                let along = |k: usize| {
                    let [a, b, c] = axes[k].map(number);
                    format!("({a} * {x} + {b} * {y} + {c} * {z} + {})", number(offset[k]))
                };
                [along(0), along(1)]
            }
        }
    }

    fn image(&mut self, image: &Image, texture: &Texture) -> String {
        let Some(id) = self.library.picture(image, texture) else {
            // pbrt draws nothing at all without the picture; the reader has warned.
            return "color (1)".into();
        };
        let picture = match self.pictures.iter().find(|(_, known)| *known == id) {
            Some((name, _)) => name.clone(),
            None => {
                let name = format!("picture{}", id.0);
                self.pictures.push((name.clone(), id));
                name
            }
        };
        let [s, t] = self.mapped(&image.mapping);
        let wrap = match image.wrap {
            Some(Wrap::Repeat) => "periodic",
            Some(Wrap::MirroredRepeat) => "mirror",
            Some(Wrap::ClampToEdge) => "clamp",
            None => "black",
        };
        let mut options = format!(", \"wrap\", \"{wrap}\"");
        if image.nearest {
            options += ", \"interp\", \"closest\"";
        }
        let read = format!("texture (\"{picture}\", {s}, 1 - {t}{options}");
        let mut shown = match (image.is_float, image.is_float && self.library.has_opacity(id)) {
            (true, true) => {
                let [opacity, all] = [self.name('f'), self.name('c')];
                self.line(format!("float {opacity} = 0;"));
                self.line(format!("color {all} = {read}, \"alpha\", {opacity});"));
                format!("color ({opacity})")
            }
            (true, false) => format!("color (pbrt_mean ({read})))"),
            (false, _) => format!("color ({read}))"),
        };
        if let Encoding::Gamma(gamma) = image.encoding {
            let gamma = number(gamma);
            shown = format!("pow ({shown}, {gamma})");
        }
        if image.scale != 1.0 {
            let _ = write!(shown, " * {}", number(image.scale));
        }
        if image.invert { format!("max (color (1) - {shown}, color (0))") } else { shown }
    }
}
