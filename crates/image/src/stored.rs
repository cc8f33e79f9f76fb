// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture file unconverted: all channels of all its levels, with the stored values and the texts. For
//! tools that need a file's contents; pictures use `Texels`, which handles colours.
//! Invariant: there is at least one level in a file's, and `values` holds `width * height * channels` of them, pixel by pixel from the upper left one.
//! Tests: `tests/{round_trip,broken}.rs`.

use crate::texels::Texels;

/// A picture file's channels, levels and texts.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// Values of a pixel, at least 1.
    pub channels: usize,
    /// Which of them is opacity, if one is.
    pub alpha: Option<usize>,
    /// The picture and its smaller copies, the largest first.
    pub levels: Vec<StoredLevel>,
    /// First and last column and row that have values: left, top, right, bottom.
    pub window: [i32; 4],
    /// First and last column and row that are shown: left, top, right, bottom.
    pub display: [i32; 4],
    /// Other texts of the file, by names: `wrapmodes`, `textureformat`, `DateTime`, `oiio:AverageColor` and
    /// such.
    pub texts: Vec<(String, String)>,
}

/// One size of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredLevel {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Columns and rows of the tiles that it is stored in, if it is.
    pub tile: Option<[usize; 2]>,
    /// The values.
    pub values: StoredValues,
}

/// Values as a file has them.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredValues {
    /// 255 is 1.
    U8(Vec<u8>),
    /// 65535 is 1.
    U16(Vec<u16>),
    /// As they are.
    F32(Vec<f32>),
}

impl StoredValues {
    /// A value; integers as shares of the largest one.
    #[must_use]
    #[inline]
    pub fn get(&self, i: usize) -> f32 {
        match self {
            Self::U8(list) => f32::from(list[i]) * (1.0 / 255.0),
            Self::U16(list) => f32::from(list[i]) * (1.0 / 65535.0),
            Self::F32(list) => list[i],
        }
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::U8(list) => list.len(),
            Self::U16(list) => list.len(),
            Self::F32(list) => list.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Stored {
    /// The description of texels in memory: four channels, without levels.
    #[must_use]
    pub fn of_texels(texels: &Texels) -> Self {
        let plain =
            Self::plain([texels.width as usize, texels.height as usize], 4, StoredValues::F32(Vec::new()));
        Self { levels: Vec::new(), ..plain }
    }

    /// A picture of one size, shown whole.
    pub(crate) fn plain([width, height]: [usize; 2], channels: usize, values: StoredValues) -> Self {
        let window = [0, 0, width as i32 - 1, height as i32 - 1];
        let alpha = if channels == 2 || channels == 4 { Some(channels - 1) } else { None };
        let levels = vec![StoredLevel { width, height, tile: None, values }];
        Self { channels, alpha, levels, window, display: window, texts: Vec::new() }
    }

    /// The file's text of this name.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        self.texts.iter().find(|(known, _)| known == name).map(|(_, text)| &**text)
    }
}
