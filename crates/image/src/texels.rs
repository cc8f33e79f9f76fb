// SPDX-License-Identifier: GPL-3.0-or-later
//! Texels: the picture of a texture, in the form that its file had.
//! Rows from the upper left texel on. Invariant: `data` holds `width * height` values, both at least 1.

use crate::tiles::{TileCache, Tiles};
use crate::{Error, Picture, srgb};

/// Texels in rows, from the upper left one.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// The values.
    pub data: TexelData,
}

/// Texel values in the form that a file had, so that a picture takes no more memory than it must.
#[derive(Clone, Debug, PartialEq)]
pub enum TexelData {
    /// Red, green, blue as sRGB bytes and opacity as a linear byte.
    Srgb8(Vec<[u8; 4]>),
    /// Red, green, blue, opacity as linear bytes (roughness, metalness, OpenRT's byte textures).
    Linear8(Vec<[u8; 4]>),
    /// Red, green, blue, opacity as linear numbers of 16 bits, 65535 = 1: smaller copies of pictures of bytes.
    Linear16(Vec<[u16; 4]>),
    /// Linear floats, unclamped.
    Float(Vec<[f32; 4]>),
    /// Any of these, most of it on the disk.
    Tiled(Tiled),
}

/// Texels in a [`TileCache`].
#[derive(Clone, Debug, PartialEq)]
pub struct Tiled {
    form: Form,
    tiles: Tiles,
}

/// The format of the bytes of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Srgb8,
    Linear8,
    Linear16,
    Float,
}

impl Tiled {
    /// The cache that it is in.
    #[must_use]
    pub fn cache(&self) -> &TileCache {
        self.tiles.cache()
    }

    fn is_float(&self) -> bool {
        self.form == Form::Float
    }

    #[inline]
    fn texel(&self, column: usize, row: usize) -> [f32; 4] {
        self.linear(self.tiles.texel(column, row))
    }

    #[inline]
    fn linear(&self, raw: [u64; 2]) -> [f32; 4] {
        match self.form {
            Form::Srgb8 => from_srgb(bytes(raw)),
            Form::Linear8 => bytes(raw).map(unit),
            Form::Linear16 => numbers(raw).map(unit16),
            Form::Float => floats(raw),
        }
    }

    /// The same in memory.
    fn resident(&self, [width, height]: [usize; 2]) -> TexelData {
        let all = (0..height).flat_map(|y| (0..width).map(move |x| self.tiles.texel(x, y)));
        match self.form {
            Form::Srgb8 => TexelData::Srgb8(all.map(bytes).collect()),
            Form::Linear8 => TexelData::Linear8(all.map(bytes).collect()),
            Form::Linear16 => TexelData::Linear16(all.map(numbers).collect()),
            Form::Float => TexelData::Float(all.map(floats).collect()),
        }
    }
}

fn bytes([texel_bits, _]: [u64; 2]) -> [u8; 4] {
    (texel_bits as u32).to_le_bytes()
}

fn numbers([texel_bits, _]: [u64; 2]) -> [u16; 4] {
    [0, 16, 32, 48].map(|shift| (texel_bits >> shift) as u16)
}

/// An unreadable texel is all ones: white, as other numbers are that.
fn floats([low, high]: [u64; 2]) -> [f32; 4] {
    if [low, high] == [u64::MAX; 2] {
        return [1.0; 4];
    }
    [low, low >> 32, high, high >> 32].map(|bits| f32::from_bits(bits as u32))
}

impl TileCache {
    /// The same picture in tiles of this cache; a tiled one stays unchanged.
    ///
    /// # Errors
    /// [`Error::File`] if the temporary file cannot grow.
    pub fn keep(&self, texels: Texels) -> Result<Texels, Error> {
        let size @ [width, _] = [texels.width, texels.height].map(|n| n as usize);
        let bytes = |all: &[[u8; 4]]| {
            let push = |band: &mut Vec<u8>, row: &[[u8; 4]]| band.extend_from_slice(row.as_flattened());
            self.store(size, 4, |to| {
                all.chunks_exact(width).try_for_each(|row| to.row(|band| push(band, row)))
            })
        };
        let (form, tiles) = match &texels.data {
            TexelData::Srgb8(all) => (Form::Srgb8, bytes(all)?),
            TexelData::Linear8(all) => (Form::Linear8, bytes(all)?),
            TexelData::Linear16(all) => {
                let push = |band: &mut Vec<u8>, row: &[_]| push_numbers(band, row.iter().copied());
                let mut rows = all.chunks_exact(width);
                (
                    Form::Linear16,
                    self.store(size, 8, |to| rows.try_for_each(|row| to.row(|band| push(band, row))))?,
                )
            }
            TexelData::Float(all) => {
                let push = |band: &mut Vec<u8>, row: &[_]| push_floats(band, row.iter().copied());
                let mut rows = all.chunks_exact(width);
                (
                    Form::Float,
                    self.store(size, 16, |to| rows.try_for_each(|row| to.row(|band| push(band, row))))?,
                )
            }
            TexelData::Tiled(_) => return Ok(texels),
        };
        Ok(Texels { data: TexelData::Tiled(Tiled { form, tiles }), ..texels })
    }

    /// A picture of floats or of numbers of 16 bits in tiles, whose rows `each_row` makes one by one.
    pub(crate) fn keep_rows(
        &self,
        [width, height]: [u32; 2],
        is_float: bool,
        each_row: impl FnOnce(TakeRow) -> Result<(), Error>,
    ) -> Result<Texels, Error> {
        let size = [width as usize, height as usize];
        let (form, tiles) = if is_float {
            let push = |band: &mut Vec<u8>, row: &[[f64; 4]]| {
                push_floats(band, row.iter().map(|&mean| to_floats(mean)));
            };
            (Form::Float, self.store(size, 16, |to| each_row(&mut |row| to.row(|band| push(band, row))))?)
        } else {
            let push = |band: &mut Vec<u8>, row: &[[f64; 4]]| {
                push_numbers(band, row.iter().map(|&mean| to_numbers(mean)));
            };
            (Form::Linear16, self.store(size, 8, |to| each_row(&mut |row| to.row(|band| push(band, row))))?)
        };
        Ok(Texels { width, height, data: TexelData::Tiled(Tiled { form, tiles }) })
    }
}

/// Takes a row of a smaller copy.
pub(crate) type TakeRow<'a> = &'a mut dyn FnMut(&[[f64; 4]]) -> Result<(), Error>;

fn push_numbers(band: &mut Vec<u8>, row: impl Iterator<Item = [u16; 4]>) {
    row.for_each(|texel| band.extend_from_slice(texel.map(u16::to_le_bytes).as_flattened()));
}

fn push_floats(band: &mut Vec<u8>, row: impl Iterator<Item = [f32; 4]>) {
    row.for_each(|texel| band.extend_from_slice(texel.map(f32::to_le_bytes).as_flattened()));
}

/// A mean as texels of floats have it.
pub(crate) fn to_floats(texel: [f64; 4]) -> [f32; 4] {
    texel.map(|x| x as f32)
}

/// A mean from 0 to 1 as numbers of 16 bits.
pub(crate) fn to_numbers(texel: [f64; 4]) -> [u16; 4] {
    texel.map(|x| (x * 65535.0 + 0.5) as u16)
}

impl Texels {
    /// Bytes that the values take.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        match &self.data {
            TexelData::Srgb8(v) | TexelData::Linear8(v) => size_of_val(&v[..]),
            TexelData::Linear16(v) => size_of_val(&v[..]),
            TexelData::Float(v) => size_of_val(&v[..]),
            TexelData::Tiled(tiled) => tiled.tiles.memory_bytes(),
        }
    }

    /// The same texels, all in memory.
    #[must_use]
    pub fn resident(self) -> Self {
        let [width, height] = [self.width, self.height].map(|n| n as usize);
        match &self.data {
            TexelData::Tiled(tiled) => Self { data: tiled.resident([width, height]), ..self },
            _ => self,
        }
    }

    /// Whether its values are floats, whose colours may be above 1.
    #[must_use]
    pub fn is_float(&self) -> bool {
        match &self.data {
            TexelData::Float(_) => true,
            TexelData::Tiled(tiled) => tiled.is_float(),
            TexelData::Srgb8(_) | TexelData::Linear8(_) | TexelData::Linear16(_) => false,
        }
    }

    /// Red, green, blue and opacity of the texel at a column and a row, linear. Panics outside of the picture.
    #[inline]
    #[must_use]
    pub fn texel(&self, column: usize, row: usize) -> [f32; 4] {
        let i = row * self.width as usize + column;
        match &self.data {
            TexelData::Tiled(tiled) => tiled.texel(column, row),
            TexelData::Srgb8(pixels) => from_srgb(pixels[i]),
            TexelData::Linear8(pixels) => four(pixels[i], unit),
            TexelData::Linear16(pixels) => four(pixels[i], unit16),
            TexelData::Float(pixels) => pixels[i],
        }
    }
}

impl Texels {
    /// The texels at two columns of two rows: those of the first row, then those of the second one. Panics outside of the picture.
    #[inline]
    #[must_use]
    pub fn quad(&self, [left, right]: [usize; 2], [upper, lower]: [usize; 2]) -> [[f32; 4]; 4] {
        let (upper_row, lower_row) = (upper * self.width as usize, lower * self.width as usize);
        let [a, b, c, d] = [upper_row + left, upper_row + right, lower_row + left, lower_row + right];
        // The form of the values is tested once for all four.
        match &self.data {
            TexelData::Tiled(tiled) => [
                tiled.texel(left, upper),
                tiled.texel(right, upper),
                tiled.texel(left, lower),
                tiled.texel(right, lower),
            ],
            TexelData::Srgb8(p) => {
                let table = srgb::decoded_bytes();
                [by_table(table, p[a]), by_table(table, p[b]), by_table(table, p[c]), by_table(table, p[d])]
            }
            TexelData::Linear8(p) => [four(p[a], unit), four(p[b], unit), four(p[c], unit), four(p[d], unit)],
            TexelData::Linear16(p) => {
                [four(p[a], unit16), four(p[b], unit16), four(p[c], unit16), four(p[d], unit16)]
            }
            TexelData::Float(p) => [p[a], p[b], p[c], p[d]],
        }
    }

    /// Writes row `row`, linear. Panics outside of the picture.
    pub(crate) fn read_row(&self, row: usize, out: &mut [[f32; 4]]) {
        let width = self.width as usize;
        let from = row * width..(row + 1) * width;
        match &self.data {
            TexelData::Tiled(tiled) => {
                tiled.tiles.row(row, width, |column, raw| out[column] = tiled.linear(raw));
            }
            TexelData::Srgb8(p) => {
                let table = srgb::decoded_bytes();
                out.iter_mut().zip(&p[from]).for_each(|(to, &x)| *to = by_table(table, x));
            }
            TexelData::Linear8(p) => out.iter_mut().zip(&p[from]).for_each(|(to, &x)| *to = four(x, unit)),
            TexelData::Linear16(p) => {
                out.iter_mut().zip(&p[from]).for_each(|(to, &x)| *to = four(x, unit16));
            }
            TexelData::Float(p) => out.copy_from_slice(&p[from]),
        }
    }
}

/// `map`, which is a call for each number where little is optimised.
#[inline(always)]
fn four<T>([r, g, b, a]: [T; 4], of: impl Fn(T) -> f32) -> [f32; 4] {
    [of(r), of(g), of(b), of(a)]
}

#[inline(always)]
fn by_table(table: &[f32; 256], [r, g, b, a]: [u8; 4]) -> [f32; 4] {
    [table[usize::from(r)], table[usize::from(g)], table[usize::from(b)], unit(a)]
}

/// A byte of opacity or of other linear numbers.
#[inline]
fn unit(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}

#[inline]
fn unit16(number: u16) -> f32 {
    f32::from(number) / 65535.0
}

#[inline]
fn from_srgb([r, g, b, a]: [u8; 4]) -> [f32; 4] {
    [srgb::decode_u8(r), srgb::decode_u8(g), srgb::decode_u8(b), unit(a)]
}

impl From<Picture> for Texels {
    /// The picture's colours as floats.
    fn from(picture: Picture) -> Self {
        Self { width: picture.width, height: picture.height, data: TexelData::Float(picture.color) }
    }
}

impl From<Texels> for Picture {
    /// The texels in linear light.
    fn from(texels: Texels) -> Self {
        let texels = texels.resident();
        let color = match texels.data {
            // Nothing stays tiled.
            TexelData::Tiled(_) => Vec::new(),
            TexelData::Srgb8(pixels) => pixels.into_iter().map(from_srgb).collect(),
            TexelData::Linear8(pixels) => pixels.iter().map(|pixel| pixel.map(unit)).collect(),
            TexelData::Linear16(pixels) => pixels.iter().map(|pixel| pixel.map(unit16)).collect(),
            TexelData::Float(pixels) => pixels,
        };
        Self { width: texels.width, height: texels.height, color, ..Self::default() }
    }
}
