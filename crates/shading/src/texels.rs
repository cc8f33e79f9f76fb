// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures read at texture coordinates: nearest texels, bilinear means, and wrapping at edges.
//! Source: docs/reference/textures.md (decode first, then bilinear; texel centres at (i + 0.5) / N; v
//! upwards), glTF 2.0 section 3.8 (wrap modes). Units: linear light. Tests: the tests of `texture`.

use gnurt_image::Texels;

/// Wrapping outside of [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture repeats.
    #[default]
    Repeat,
    /// The picture repeats mirrored.
    Mirror,
    /// The edge's texels go on.
    Clamp,
}

/// The position of coordinates, in texels from the upper left corner.
#[inline]
fn texel_position(texels: &Texels, [u, v]: [f32; 2], wrap: [Wrap; 2]) -> [f32; 2] {
    [fold(u, wrap[0]) * texels.width as f32, (1.0 - fold(v, wrap[1])) * texels.height as f32]
}

/// The texel that contains the coordinates.
pub(crate) fn nearest(texels: &Texels, uv: [f32; 2], wrap: [Wrap; 2]) -> [f32; 4] {
    let [x, y] = texel_position(texels, uv, wrap).map(|x| x as i32);
    texels.texel(wrap_index(x, texels.width, wrap[0]), wrap_index(y, texels.height, wrap[1]))
}

/// Between the four texels whose centres are around the coordinates.
pub(crate) fn bilinear(texels: &Texels, uv: [f32; 2], wrap: [Wrap; 2]) -> [f32; 4] {
    let [x, y] = texel_position(texels, uv, wrap).map(|x| x - 0.5);
    let [column, row] = [floor(x), floor(y)];
    let (fx, fy) = (x - column, y - row);
    let columns = [0, 1].map(|k| wrap_index(column as i32 + k, texels.width, wrap[0]));
    let rows = [0, 1].map(|k| wrap_index(row as i32 + k, texels.height, wrap[1]));
    let [a, b, c, d] = texels.quad(columns, rows);
    std::array::from_fn(|k| {
        let upper = a[k] + fx * (b[k] - a[k]);
        let lower = c[k] + fx * (d[k] - c[k]);
        upper + fy * (lower - upper)
    })
}

/// `x.floor()`, which is a call where the CPU may lack an instruction for it; -0 becomes 0.
#[inline]
fn floor(x: f32) -> f32 {
    /// Numbers from here on have no fraction.
    const WHOLE: f32 = 8_388_608.0;
    if x.abs() < WHOLE {
        let toward_zero = x as i32 as f32;
        if toward_zero > x { toward_zero - 1.0 } else { toward_zero }
    } else {
        x
    }
}

/// Brings a coordinate to [0, 1].
#[inline]
fn fold(x: f32, wrap: Wrap) -> f32 {
    if !x.is_finite() {
        return 0.0;
    }
    match wrap {
        Wrap::Repeat => x - floor(x),
        Wrap::Mirror => {
            let period = x - 2.0 * floor(x * 0.5);
            1.0 - (period - 1.0).abs()
        }
        Wrap::Clamp => x.clamp(0.0, 1.0),
    }
}

/// Brings the index of a neighbour, at most one outside, back into the picture.
#[inline]
fn wrap_index(i: i32, n: u32, wrap: Wrap) -> usize {
    let last = n as i32 - 1;
    let inside = match wrap {
        Wrap::Repeat if i < 0 => last,
        Wrap::Repeat if i > last => 0,
        // The texel before the first is the first again; both ends alike.
        Wrap::Repeat | Wrap::Mirror | Wrap::Clamp => i.clamp(0, last),
    };
    inside as usize
}
