// SPDX-License-Identifier: GPL-3.0-or-later
//! Samplers: values of pictures, lists and attributes, transformed on the way in and out.
//! Source: ANARI 1.1, KHR_SAMPLER_*. Texel k of n lies at `(k + 0.5) / n`; row 0 is the lowest. Values are decoded before they are
//! interpolated. Tests: tests/attributes.rs, `tests`.

use crate::attribute::{Attribute, Color, Point, mix};
use crate::ffi_array::Array;
use crate::object::Object;
use crate::types;

/// The values beyond the ends of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrap {
    Edge,
    Repeat,
    Mirror,
    Border,
}

impl Wrap {
    fn of(name: Option<&str>) -> Self {
        match name {
            Some("repeat") => Self::Repeat,
            Some("mirrorRepeat") => Self::Mirror,
            Some("clampToBorder") => Self::Border,
            _ => Self::Edge,
        }
    }

    /// The texel of a place that may be beyond the ends; `None` = the border.
    fn texel(self, texel_index: i64, count: usize) -> Option<usize> {
        let count = count as i64;
        let texel = match self {
            Self::Edge => texel_index.clamp(0, count - 1),
            Self::Repeat => texel_index.rem_euclid(count),
            Self::Mirror => {
                let texel_index = texel_index.rem_euclid(2 * count);
                if texel_index < count { texel_index } else { 2 * count - 1 - texel_index }
            }
            Self::Border if (0..count).contains(&texel_index) => texel_index,
            Self::Border => return None,
        };
        Some(texel as usize)
    }
}

/// Texels on a grid of one to three axes.
struct Image {
    dims: [usize; 3],
    texels: Vec<Color>,
    linear: bool,
    wrap: [Wrap; 3],
    border: Color,
}

/// Beyond this many texels from the first, a place is no place.
const FAR: f32 = 1e9;

impl Image {
    fn at(&self, texels: [i64; 3]) -> Color {
        let texel = |axis: usize| self.wrap[axis].texel(texels[axis], self.dims[axis]);
        let [Some(x), Some(y), Some(z)] = [texel(0), texel(1), texel(2)] else { return self.border };
        self.texels.get(x + self.dims[0] * (y + self.dims[1] * z)).copied().unwrap_or(self.border)
    }

    /// The value at coordinates of which (0, 0, 0) is the lower corner and (1, 1, 1) the upper one.
    fn value(&self, coordinates: Color) -> Color {
        let mut first = [0_i64; 3];
        let mut shares = [0.0_f32; 3];
        for axis in 0..3 {
            if self.dims[axis] == 1 && self.wrap[axis] != Wrap::Border {
                continue;
            }
            let texel_index = coordinates[axis] * self.dims[axis] as f32;
            // NaN, too, is the first texel.
            let texel_index = if texel_index.abs() < FAR { texel_index } else { 0.0 };
            let texel_index = if self.linear { texel_index - 0.5 } else { texel_index };
            first[axis] = texel_index.floor() as i64;
            shares[axis] = texel_index - texel_index.floor();
        }
        if !self.linear {
            return self.at(first);
        }
        let along = |y: i64, z: i64| {
            let [a, b] = [0, 1].map(|x| self.at([first[0] + x, first[1] + y, first[2] + z]));
            mix(a, b, shares[0])
        };
        let across =
            |z: i64| if self.dims[1] == 1 { along(0, z) } else { mix(along(0, z), along(1, z), shares[1]) };
        if self.dims[2] == 1 { across(0) } else { mix(across(0), across(1), shares[2]) }
    }
}

/// Where values come from.
enum Source {
    Image(Image),
    Primitive(Vec<Color>, u64),
    Attribute,
}

/// A sampler.
pub(crate) struct Sampler {
    source: Source,
    pub(crate) input: Attribute,
    into: [f32; 16],
    into_offset: Color,
    out: [f32; 16],
    out_offset: Color,
}

const UNIT: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

fn transformed(matrix: &[f32; 16], v: Color, offset: Color) -> Color {
    std::array::from_fn(|row| {
        (0..4).map(|column| matrix[4 * column + row] * v[column]).sum::<f32>() + offset[row]
    })
}

impl Sampler {
    /// The sampler of an object; an error in words where it has no values.
    pub(crate) fn new(object: &Object) -> Result<Self, String> {
        let now = object.committed();
        let texels = |name: &str, kind| {
            let array = now.object(name, kind).and_then(|array| Array::of(array));
            array.ok_or_else(|| format!("parameter '{name}': missing, the sampler has no values"))
        };
        let colors = |array: &Array, name: &str| {
            array.colors().ok_or_else(|| {
                format!("parameter '{name}': elements of type {}: invalid", types::name(array.element))
            })
        };
        let image = |kind| {
            let array = texels("image", kind)?;
            let texels = colors(array, "image")?;
            let mut dims = array.dims.map(|n| n as usize);
            if kind == types::ARRAY1D {
                dims[0] = texels.len();
            }
            if texels.is_empty() {
                return Err("parameter 'image': no texels".to_owned());
            }
            let wrap = |name: &str| Wrap::of(now.text(name));
            let wraps = match kind {
                types::ARRAY1D => [wrap("wrapMode"), Wrap::Edge, Wrap::Edge],
                types::ARRAY2D => [wrap("wrapMode1"), wrap("wrapMode2"), Wrap::Edge],
                _ => [wrap("wrapMode1"), wrap("wrapMode2"), wrap("wrapMode3")],
            };
            let border = now.color("borderColor").unwrap_or([0.0; 4]);
            let linear = now.text("filter") != Some("nearest");
            Ok(Source::Image(Image { dims, texels, linear, wrap: wraps, border }))
        };
        let source = match object.subtype.as_str() {
            "image1D" => image(types::ARRAY1D)?,
            "image2D" => image(types::ARRAY2D)?,
            "image3D" => image(types::ARRAY3D)?,
            "primitive" => {
                let values = colors(texels("array", types::ARRAY1D)?, "array")?;
                Source::Primitive(values, now.u64("inOffset").unwrap_or(0))
            }
            "transform" => Source::Attribute,
            other => return Err(format!("subtype '{other}': unsupported")),
        };
        let name = now.text("inAttribute").unwrap_or("attribute0");
        let input = Attribute::named(name)
            .ok_or_else(|| format!("parameter 'inAttribute': '{name}': unknown attribute"))?;
        let into = now.mat4("inTransform").unwrap_or(UNIT);
        let old = if object.subtype == "transform" { now.mat4("transform") } else { None };
        let out = now.mat4("outTransform").or(old).unwrap_or(UNIT);
        let [into_offset, out_offset] =
            ["inOffset", "outOffset"].map(|name| now.color(name).unwrap_or([0.0; 4]));
        Ok(Self { source, input, into, into_offset, out, out_offset })
    }

    /// The value at a point.
    pub(crate) fn value(&self, point: &dyn Point) -> Color {
        let value = match &self.source {
            Source::Primitive(values, offset) => {
                let texel_index = usize::try_from(offset.saturating_add(u64::from(point.primitive()))).ok();
                return texel_index
                    .and_then(|texel_index| values.get(texel_index))
                    .copied()
                    .unwrap_or(crate::attribute::NOTHING);
            }
            Source::Attribute => point.attribute(self.input),
            Source::Image(image) => {
                image.value(transformed(&self.into, point.attribute(self.input), self.into_offset))
            }
        };
        transformed(&self.out, value, self.out_offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(linear: bool, wrap: Wrap) -> Image {
        let texels = [0.0, 1.0, 2.0, 3.0].map(|x| [x, 0.0, 0.0, 1.0]).to_vec();
        Image { dims: [4, 1, 1], texels, linear, wrap: [wrap, Wrap::Edge, Wrap::Edge], border: [9.0; 4] }
    }

    #[test]
    fn texels_lie_in_the_middle_of_their_cells() {
        let value = |linear, wrap, x: f32| image(linear, wrap).value([x, 0.0, 0.0, 1.0])[0];
        for (k, x) in [0.125, 0.375, 0.625, 0.875].into_iter().enumerate() {
            assert!((value(true, Wrap::Edge, x) - k as f32).abs() < 1e-6, "texel {k}");
        }
        assert!((value(true, Wrap::Edge, 0.5) - 1.5).abs() < 1e-6, "between two");
        assert_eq!(value(false, Wrap::Edge, 0.49), 1.0, "nearest");
        assert_eq!(value(true, Wrap::Edge, -3.0), 0.0, "the edge goes on");
        assert!((value(true, Wrap::Repeat, 1.125)).abs() < 1e-5, "again from its start");
        assert!((value(true, Wrap::Mirror, 1.125) - 3.0).abs() < 1e-5, "back from its end");
        assert_eq!(value(false, Wrap::Border, 1.5), 9.0, "the border");
        assert_eq!(
            value(true, Wrap::Repeat, f32::NAN),
            value(true, Wrap::Repeat, 0.0),
            "no place is the first"
        );
    }
}
