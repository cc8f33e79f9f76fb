// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of picture files for `gettextureinfo`.
//! Source: OSL's specification, `gettextureinfo`; OpenImageIO's documentation of `get_image_info`, also for names of
//! tiles: without coordinates the properties are those that all tiles share.
//! Tests: `tests/scripts/tiles.rs`.

use gnurt_image::Stored;
use gnurt_sl::hir::Data;
use gnurt_sl::types::{Base, Type};

/// The properties of a picture, without its values.
#[derive(Debug)]
pub(crate) struct TextureInfo {
    /// The file; levels are empty.
    pub(crate) file: Stored,
    /// The mean colour and opacity of its texels, linear.
    pub(crate) mean: [f32; 4],
}

impl TextureInfo {
    /// A property; the mean colour replaces a missing note of the file.
    pub(crate) fn answer(&self, what: &str, ty: Type) -> Option<Data> {
        if let Some(found) = answer(&self.file, what, ty) {
            return Some(found);
        }
        let is_number = ty.base == Base::Float || ty.base.is_triple();
        match what {
            "averagecolor" if is_number && ty.size() <= 4 => {
                Some(Data::Float(self.mean[..ty.size()].to_vec()))
            }
            "averagealpha" if ty == Type::FLOAT => {
                Some(Data::Float(vec![self.file.alpha.map(|_| self.mean[3])?]))
            }
            _ => None,
        }
    }
}

/// The answer that some pictures share; `None` if one has none, or another.
pub(crate) fn common(mut answers: impl Iterator<Item = Option<Data>>) -> Option<Data> {
    let first = answers.next()??;
    answers.all(|other| other.as_ref() == Some(&first)).then_some(first)
}

/// The property of a file.
pub(crate) fn answer(file: &Stored, what: &str, ty: Type) -> Option<Data> {
    let ints = |list: &[i32]| {
        let fits = ty.base == Base::Int && ty.size() == list.len();
        fits.then(|| Data::Int(list.to_vec()))
    };
    // A picture is a single layer of a volume.
    let window = |[left, top, right, bottom]: [i32; 4]| {
        ints(&[left, top, right, bottom]).or_else(|| ints(&[left, top, 0, right, bottom, 0]))
    };
    let text = |text: &str| (ty == Type::STRING).then(|| Data::Str(vec![text.into()]));
    // Colours are those that the file states, or the one that the smallest level has.
    let color = |noted: Option<&str>, from: usize| {
        if ty.base != Base::Float && !ty.base.is_triple() {
            return None;
        }
        let values: Vec<f32> = match noted {
            Some(noted) => noted.split(',').map(|tag| tag.trim().parse().unwrap_or(0.0)).collect(),
            None => {
                let last = file.levels.last().filter(|level| [level.width, level.height] == [1, 1])?;
                (0..file.channels).map(|c| last.values.get(c)).collect()
            }
        };
        let at = |i: usize| values.get(from + i).copied().unwrap_or(0.0);
        Some(Data::Float((0..ty.size()).map(at).collect()))
    };
    let average = file.text("oiio:AverageColor");
    let constant = file.text("oiio:ConstantColor");
    match what {
        "resolution" => {
            let [left, top, right, bottom] = file.window;
            let [width, height] = [right - left + 1, bottom - top + 1];
            ints(&[width, height]).or_else(|| ints(&[width, height, 1]))
        }
        "channels" => ints(&[file.channels as i32])
            .or_else(|| (ty == Type::FLOAT).then(|| Data::Float(vec![file.channels as f32]))),
        "subimages" => ints(&[1]),
        "datawindow" => window(file.window),
        "displaywindow" => window(file.display),
        "type" | "texturetype" | "textureformat" => {
            text(file.text("textureformat").unwrap_or("Plain Texture"))
        }
        "averagecolor" => color(average, 0),
        "averagealpha" if ty == Type::FLOAT => color(average, file.alpha?),
        "constantcolor" => color(Some(constant?), 0),
        "constantalpha" if ty == Type::FLOAT => color(Some(constant?), file.alpha?),
        _ => text(file.text(what)?),
    }
}
