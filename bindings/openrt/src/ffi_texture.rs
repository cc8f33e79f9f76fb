// SPDX-License-Identifier: GPL-3.0-or-later
//! Exported calls: textures. Tests: tests/c/scene.c.

use std::ffi::c_void;

use crate::ffi::{call, id_functions, procedures};
use crate::state::texture::{ImageDescription, ReadTexels};

id_functions! {
    rtGenTextures(count: i32) => |context| context.gen_textures(count);
}

procedures! {
    rtBindTexture(target: u32, texture: u32) => |context| context.bind_texture(target, texture);
    rtTexParameteri(target: u32, name: u32, value: i32) => |context| {
        context.tex_parameter(target, name, value)
    };
    rtDeleteTexture(texture: u32) => |context| context.delete_texture(texture);
}

/// # Safety
/// As openrt/rt.h says: `texels` is null or points to width * height texels of this format and type.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtTexImage2D(
    target: u32,
    level: i32,
    internal_format: i32,
    width: i32,
    height: i32,
    border: i32,
    format: u32,
    texel_type: u32,
    texels: *const c_void,
) {
    let size = [width, height];
    let description = ImageDescription { target, level, internal_format, size, border, format, texel_type };
    // SAFETY: the caller vouches for the texels, and the state machine requests no more bytes than they have.
    let read = |length| unsafe { std::slice::from_raw_parts(texels.cast::<u8>(), length) };
    let read: Option<ReadTexels> = if texels.is_null() { None } else { Some(&read) };
    call!(
        rtTexImage2D(target, level, internal_format, width, height, border, format, texel_type, texels),
        (),
        |context| context.tex_image(&description, read)
    );
}
