// SPDX-License-Identifier: GPL-3.0-or-later
//! Exported calls: objects, instances, blocks, and the questions whether an id exists.
//! Tests: tests/c/scene.c.

use crate::ffi::{call, id_functions, procedures};
use crate::ffi_pointers::writer;
use crate::state::error::Writer;

id_functions! {
    rtGenObjects(count: i32) => |context| context.gen_objects(count);
    rtNewObject(id: u32, mode: u32) => |context| context.new_object_either_form(id, mode);
    rtCreateObject(mode: u32) => |context| context.create_object(mode);
    rtInstantiateObject(id: u32) => |context| context.instantiate_object(id);
}

procedures! {
    rtNestObject(object: u32, mask: u32) => |context| context.nest_object(object, mask);
    rtEndObject() => |context| context.end_object();
    rtRemoveObject(id: u32) => |context| context.remove_object(id);
    rtUpdateInstance(instance: u32) => |context| context.update_instance(instance);
    rtInstanceMask(instance: u32, mask: u32) => |context| context.instance_mask(instance, mask);
    rtDeleteInstance(instance: u32) => |context| context.delete_instance(instance);
    rtClearInstances() => |context| context.clear_instances();
    rtBegin(mode: u32) => |context| context.begin(mode);
    rtEnd() => |context| context.end();
}

/// # Safety
/// As openrt/rt.h says: `matrix` is null or has room for 16 numbers.
#[unsafe(no_mangle)]
unsafe extern "C-unwind" fn rtGetInstanceMatrixf(instance: u32, matrix: *mut f32) {
    // SAFETY: the caller vouches for the room.
    let mut write = unsafe { writer(matrix) };
    call!(rtGetInstanceMatrixf(instance, matrix), (), |context| context
        .get_instance_matrix(instance, write.as_mut().map(|w| w as Writer<'_, f32>)));
}

macro_rules! questions {
    ($($name:ident => $question:ident;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C-unwind" fn $name(id: u32) -> u8 {
            call!($name(id), 0, |context| context.$question(id).map(u8::from))
        }
    )*};
}

questions! {
    rtIsObject => is_object;
    rtIsInstance => is_instance;
    rtIsShader => is_shader;
    rtIsTexture => is_texture;
}
