// SPDX-License-Identifier: GPL-3.0-or-later
//! Single texels of a picture, and what happens at its edges.
//! Source: references/README point 3 (decode first), glTF 2.0 section 3.8 (wrap modes). Units: linear light.
//! Proof: the tests of `texture`.

use std::sync::LazyLock;

use gnurt_image::{TexelData, Texels};

/// What happens outside of [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture goes on from its other edge.
    #[default]
    Repeat,
    /// The picture goes on mirrored.
    Mirror,
    /// The edge's texels go on.
    Clamp,
}

/// Texel number `i`, decoded.
pub(crate) fn texel_of(texels: &Texels, i: usize) -> [f32; 4] {
    match &texels.data {
        TexelData::Srgb8(texels) => {
            let [r, g, b, a] = texels[i];
            let decode = |x: u8| SRGB[usize::from(x)];
            [decode(r), decode(g), decode(b), f32::from(a) / 255.0]
        }
        TexelData::Linear8(texels) => texels[i].map(|x| f32::from(x) / 255.0),
        TexelData::Float(texels) => texels[i],
    }
}

/// Linear value of each sRGB byte.
static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let x = i as f64 / 255.0;
        (if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

/// Brings a coordinate to [0, 1].
pub(crate) fn fold(x: f32, wrap: Wrap) -> f32 {
    if !x.is_finite() {
        return 0.0;
    }
    match wrap {
        Wrap::Repeat => x - x.floor(),
        Wrap::Mirror => {
            let period = x - 2.0 * (x * 0.5).floor();
            1.0 - (period - 1.0).abs()
        }
        Wrap::Clamp => x.clamp(0.0, 1.0),
    }
}

/// Brings the index of a neighbour, at most one outside, back into the picture.
pub(crate) fn wrap_index(i: i64, n: u32, wrap: Wrap) -> usize {
    let n = i64::from(n);
    let inside = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        // The texel before the first is the first again; both ends alike.
        Wrap::Mirror | Wrap::Clamp => i.clamp(0, n - 1),
    };
    inside as usize
}
