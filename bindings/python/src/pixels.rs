// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixels of numpy arrays, for textures and pictures. Tests: `tests/test_textures.py`, `tests/test_pickles.py`.

use gnurt::scene::texture::{TexelData, Texels};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{array, of_type};
use crate::ffi_arrays::Rows;

/// Texels of an array: (height, width) or (height, width, 1 to 4); bytes, or floats in linear light.
pub(crate) fn texels(source: &Bound<'_, PyAny>, is_color: bool) -> PyResult<Texels> {
    let found = array("source", source)?;
    let shape: Vec<usize> = found.getattr("shape")?.extract()?;
    let side = |n: usize| u32::try_from(n).ok().filter(|n| (1..=1 << 20).contains(n));
    let (Some((height, width)), channels) = (match shape[..] {
        [height, width] => (side(height).zip(side(width)), 1),
        [height, width, channels @ 1..=4] => (side(height).zip(side(width)), channels),
        _ => (None, 0),
    }) else {
        return Err(PyValueError::new_err(format!(
            "source: expected an array of shape (height, width) or (height, width, 1 to 4), not {}",
            found.getattr("shape")?
        )));
    };
    let is_bytes = found.getattr("dtype")?.getattr("name")?.extract::<String>()? == "uint8";
    let flat = found.call_method1("reshape", (-1, channels))?;
    let count = width as usize * height as usize;
    let gaps = || PyValueError::new_err("source: its memory cannot be read");
    let data = if is_bytes {
        let rows = Rows::<u8>::new(&of_type(&flat, "uint8")?)?.ok_or_else(gaps)?;
        let all = spread(rows.all(), channels, count, u8::MAX);
        if is_color { TexelData::Srgb8(all) } else { TexelData::Linear8(all) }
    } else {
        let rows = Rows::<f32>::new(&of_type(&flat, "float32")?)?.ok_or_else(gaps)?;
        TexelData::Float(spread(rows.all(), channels, count, 1.0))
    };
    Ok(Texels { width, height, data })
}

/// Grey becomes three equal channels, opacity that is missing is full.
fn spread<T: Copy>(all: &[T], channels: usize, count: usize, full: T) -> Vec<[T; 4]> {
    let texel = |row: &[T]| match *row {
        [grey] => [grey, grey, grey, full],
        [grey, opacity] => [grey, grey, grey, opacity],
        [r, g, b] => [r, g, b, full],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [full; 4],
    };
    all.chunks_exact(channels).take(count).map(texel).collect()
}
