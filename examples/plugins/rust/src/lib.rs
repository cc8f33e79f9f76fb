// SPDX-License-Identifier: GPL-3.0-or-later
//! A shader plugin for libOpenRT in Rust: `stripes`, two colours in turn along the texture coordinate s, lit from the eye.
//!
//! | parameter | rate | default | meaning |
//! |---|---|---|---|
//! | color | shader | 1 1 1 | of the first stripe |
//! | width | shader | 0.125 | of a stripe, in s |
//! | other_color | triangle | 0 0 0 | of the second stripe |
//!
//! `ffi.rs` is a wrapper that any plugin can use: this file has no unsafe code. Build it with `cargo build --release`, or
//! `rustc --edition 2024 --crate-type cdylib -O -C panic=abort src/lib.rs -o stripes.so`.
#![deny(unsafe_code)]

#[expect(unsafe_code, reason = "the interface is C's")]
mod ffi;

use ffi::{Batch, Parameter, Rate, Surface};

/// The block per shader, as the host writes it.
#[repr(C)]
#[derive(Clone, Copy)]
struct Stripes {
    color: [f32; 3],
    width: f32,
}

impl Surface for Stripes {
    const NAME: &'static std::ffi::CStr = c"stripes";
    const TRIANGLE_SIZE: u32 = 12;
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::floats(c"color", 3, Rate::Shader, std::mem::offset_of!(Self, color)),
        Parameter::floats(c"width", 1, Rate::Shader, std::mem::offset_of!(Self, width)),
        Parameter::floats(c"other_color", 3, Rate::Triangle, 0),
    ];
    const DEFAULT: Self = Self { color: [1.0; 3], width: 0.125 };

    fn shade(&self, batch: &Batch<'_>, out: [&mut [f32]; 3]) {
        let n = batch.len();
        let mut other = vec![0.0; 3 * n];
        batch.parameter(2, &mut other);
        let [nx, ny, nz] = batch.shading_normals();
        let [dx, dy, dz] = batch.directions();
        let [s, ..] = batch.texture_coordinates();
        for (k, channel) in out.into_iter().enumerate() {
            for i in 0..n {
                let facing = (nx[i] * dx[i] + ny[i] * dy[i] + nz[i] * dz[i]).abs();
                let is_first = (s[i] / self.width).floor() % 2.0 == 0.0;
                channel[i] = facing * if is_first { self.color[k] } else { other[k * n + i] };
            }
        }
    }
}

ffi::module!(Stripes);
