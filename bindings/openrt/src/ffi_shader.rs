// SPDX-License-Identifier: GPL-3.0-or-later
//! Exported calls: shader classes, shaders and their parameters.
//! Tests: tests/c/scene.c, tests/c/errors.c.

use std::ffi::{c_char, c_void};

use crate::ffi::{call, id_functions, procedures};
use crate::ffi_pointers::{array, text, writer};
use crate::state::error::Writer;
use crate::state::ids::RT_INVALID;
use crate::state::parameter::GivenValue;

id_functions! {
    rtGenNewShader() => |context| context.gen_new_shader();
}

procedures! {
    rtBindShaderClass(class: u32) => |context| context.bind_shader_class(class);
    rtBindShader(shader: u32) => |context| context.bind_shader(shader);
    rtDeleteShader(shader: u32) => |context| context.delete_shader(shader);
}

/// # Safety
/// As openrt/rt.h says: both are null or texts.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtGenNewShaderClass(name: *const c_char, file: *const c_char) -> u32 {
    // SAFETY: the caller vouches for the texts.
    let (name, file) = unsafe { (text(name), text(file)) };
    call!(rtGenNewShaderClass(name, file), RT_INVALID, |context| context.gen_new_shader_class(name, file))
}

/// # Safety
/// As openrt/rt.h says: `name` is null or a text.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtParameterHandle(name: *const c_char) -> u32 {
    // SAFETY: the caller vouches for the text.
    let name = unsafe { text(name) };
    call!(rtParameterHandle(name), RT_INVALID, |context| context.parameter_handle(name))
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtGetShaderClassInfoLog() -> *const c_char {
    call!(rtGetShaderClassInfoLog(), std::ptr::null(), |context| context
        .shader_class_info_log()
        .map(|log| log.as_ptr()))
}

procedures! {
    rtParameter1f(handle: u32, x: f32) => |context| context.set_parameter(handle, Some(GivenValue::Floats(&[x])));
    rtParameter2f(handle: u32, x: f32, y: f32) => |context| {
        context.set_parameter(handle, Some(GivenValue::Floats(&[x, y])))
    };
    rtParameter3f(handle: u32, x: f32, y: f32, z: f32) => |context| {
        context.set_parameter(handle, Some(GivenValue::Floats(&[x, y, z])))
    };
    rtParameter4f(handle: u32, x: f32, y: f32, z: f32, w: f32) => |context| {
        context.set_parameter(handle, Some(GivenValue::Floats(&[x, y, z, w])))
    };
    rtParameter16f(
        handle: u32,
        a: f32, b: f32, c: f32, d: f32, e: f32, f: f32, g: f32, h: f32,
        i: f32, j: f32, k: f32, l: f32, m: f32, n: f32, o: f32, p: f32
    ) => |context| {
        context.set_parameter(handle, Some(GivenValue::Floats(&[a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p])))
    };
    rtParameter1i(handle: u32, x: i32) => |context| context.set_parameter(handle, Some(GivenValue::Ints(&[x])));
    rtParameter2i(handle: u32, x: i32, y: i32) => |context| {
        context.set_parameter(handle, Some(GivenValue::Ints(&[x, y])))
    };
    rtParameter3i(handle: u32, x: i32, y: i32, z: i32) => |context| {
        context.set_parameter(handle, Some(GivenValue::Ints(&[x, y, z])))
    };
    rtParameter4i(handle: u32, x: i32, y: i32, z: i32, w: i32) => |context| {
        context.set_parameter(handle, Some(GivenValue::Ints(&[x, y, z, w])))
    };
    rtParameter1d(handle: u32, x: f64) => |context| context.set_parameter(handle, Some(GivenValue::Double(x)));
}

macro_rules! vector_forms {
    ($($name:ident: $count:literal $type:ty as $given:ident;)*) => {$(
        /// # Safety
        /// As openrt/rt.h says: `values` is null or points to as many numbers as the name says.
        #[unsafe(no_mangle)]
        unsafe extern "C-unwind" fn $name(handle: u32, values: *const $type) {
            // SAFETY: the caller vouches for the numbers.
            let values: Option<[$type; $count]> = unsafe { array(values) };
            call!($name(handle, values), (), |context| {
                context.set_parameter(handle, values.as_ref().map(|values| GivenValue::$given(values)))
            });
        }
    )*};
}

vector_forms! {
    rtParameter1fv: 1 f32 as Floats;
    rtParameter2fv: 2 f32 as Floats;
    rtParameter3fv: 3 f32 as Floats;
    rtParameter4fv: 4 f32 as Floats;
    rtParameter16fv: 16 f32 as Floats;
    rtParameter2iv: 2 i32 as Ints;
    rtParameter3iv: 3 i32 as Ints;
    rtParameter4iv: 4 i32 as Ints;
}

/// # Safety
/// As openrt/rt.h says: `value` is null or points to `size` bytes.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtParameterRaw(handle: u32, value: *const c_void, size: u32) {
    let length = size as usize;
    // SAFETY: the caller vouches for the bytes; bytes have no alignment.
    let bytes = (!value.is_null()).then(|| unsafe { std::slice::from_raw_parts(value.cast::<u8>(), length) });
    call!(rtParameterRaw(handle, value, size), (), |context| context
        .set_parameter(handle, bytes.map(GivenValue::Bytes)));
}

/// # Safety
/// As openrt/rt.h says: `string` is null or a text.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtParameterString(handle: u32, string: *const c_char) {
    // SAFETY: the caller vouches for the text.
    let string = unsafe { text(string) };
    call!(rtParameterString(handle, string), (), |context| context
        .set_parameter(handle, string.map(GivenValue::String)));
}

/// # Safety
/// As openrt/rt.h says: `values` is null or has room for the parameter's numbers.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtGetParameterfv(handle: u32, values: *mut f32) {
    // SAFETY: the caller vouches for the room.
    let mut write = unsafe { writer(values) };
    call!(rtGetParameterfv(handle, values), (), |context| context
        .get_parameter(handle, write.as_mut().map(|w| w as Writer<'_, f32>)));
}
