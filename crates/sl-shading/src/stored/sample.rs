// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads a level of a picture at a position: the nearest texel, between four, or by cubic B-splines over
//! sixteen. Wrap modes and derivatives are those of OpenImageIO's textures. Cubic B-splines: Sigg and
//! Hadwiger, Fast Third-Order Texture Filtering (GPU Gems 2, 2005). Missing channels are filled; outside of a
//! picture with a black border, filled channels are black as well.

use gnurt_image::{Stored, StoredLevel};

use crate::wrap::Wrap;

/// Of four channels: the value, and its changes with s and t.
pub(super) type Read = [[f32; 3]; 4];

/// How a level is read between its texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    Closest,
    Linear,
    Cubic,
}

/// Which channels are read, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReadOptions {
    pub(super) wrap: [Wrap; 2],
    pub(super) first: usize,
    /// The number of requested channels.
    pub(super) channels: usize,
    /// The value of missing channels.
    pub(super) fill: f32,
}

/// A coordinate as a texel and the remainder.
fn split(x: f32) -> (i32, f32) {
    let whole = x.floor();
    // Outside of the range of ints there is no picture.
    (whole.clamp(-1e9, 1e9) as i32, x - whole)
}

/// The weights of two or four texels and their changes.
fn weights(interpolation: Interpolation, f: f32) -> ([f32; 4], [f32; 4]) {
    let g = 1.0 - f;
    if interpolation == Interpolation::Linear {
        return ([0.0, g, f, 0.0], [0.0, -1.0, 1.0, 0.0]);
    }
    let w = [
        g * g * g / 6.0,
        2.0 / 3.0 - 0.5 * f * f * (2.0 - f),
        2.0 / 3.0 - 0.5 * g * g * (2.0 - g),
        f * f * f / 6.0,
    ];
    let d = [-0.5 * g * g, 0.5 * f * (3.0 * f - 4.0), -0.5 * g * (3.0 * g - 4.0), 0.5 * f * f];
    (w, d)
}

/// The texel of a level at (s, t), t downwards.
pub(super) fn read(
    file: &Stored,
    level: &StoredLevel,
    [s, t]: [f32; 2],
    interpolation: Interpolation,
    read_options: &ReadOptions,
) -> Read {
    let (w, h) = (level.width, level.height);
    let mut out = Read::default();
    let there = file.channels.saturating_sub(read_options.first).min(read_options.channels);
    // The weight of the texels within the picture.
    let mut inside = 0.0;
    let mut add = |x: Option<usize>, y: Option<usize>, weight: [f32; 3]| {
        let (Some(x), Some(y)) = (x, y) else { return };
        inside += weight[0];
        let start = (y * w + x) * file.channels + read_options.first;
        for (c, out) in out.iter_mut().enumerate().take(there) {
            let value = level.values.get(start + c);
            for (out, weight) in out.iter_mut().zip(weight) {
                *out += weight * value;
            }
        }
    };
    if interpolation == Interpolation::Closest {
        let ((i, _), (j, _)) = (split(s * w as f32), split(t * h as f32));
        add(
            read_options.wrap[0].texel(i.into(), w),
            read_options.wrap[1].texel(j.into(), h),
            [1.0, 0.0, 0.0],
        );
    } else {
        let ((i, fs), (j, ft)) = (split(s * w as f32 - 0.5), split(t * h as f32 - 0.5));
        let ((ws, ds), (wt, dt)) = (weights(interpolation, fs), weights(interpolation, ft));
        let columns: [_; 4] =
            std::array::from_fn(|k| read_options.wrap[0].texel(i64::from(i) + k as i64 - 1, w));
        for l in 0..4 {
            let row = read_options.wrap[1].texel(i64::from(j) + l as i64 - 1, h);
            for k in 0..4 {
                if ws[k] != 0.0 || ds[k] != 0.0 {
                    let weight = [ws[k] * wt[l], ds[k] * wt[l] * w as f32, ws[k] * dt[l] * h as f32];
                    if weight != [0.0; 3] {
                        add(columns[k], row, weight);
                    }
                }
            }
        }
    }
    for out in &mut out[there..] {
        out[0] = read_options.fill * inside;
    }
    out
}
