// SPDX-License-Identifier: GPL-3.0-or-later
//! Exported calls: matrices. Tests: tests/c/scene.c.

use crate::ffi::{call, procedures};
use crate::ffi_pointers::array;
use crate::state::matrix::Matrix;

procedures! {
    rtMatrixMode(mode: u32) => |context| context.matrix_mode(mode);
    rtLoadIdentity() => |context| context.load_matrix(Some(Matrix::IDENTITY));
    rtPushMatrix() => |context| context.push_matrix();
    rtPopMatrix() => |context| context.pop_matrix();
}

/// The calls that come for both precisions: the names, then the C type of their numbers.
macro_rules! for_type {
    ($type:ty: $scale:ident $translate:ident $rotate:ident $load:ident $mult:ident $load_transpose:ident
        $mult_transpose:ident) => {
        procedures! {
            $scale(x: $type, y: $type, z: $type) => |context| {
                context.multiply_matrix(Some(Matrix::scale([x, y, z].map(f64::from))))
            };
            $translate(x: $type, y: $type, z: $type) => |context| {
                context.multiply_matrix(Some(Matrix::translation([x, y, z].map(f64::from))))
            };
            $rotate(degrees: $type, x: $type, y: $type, z: $type) => |context| {
                let axis = [x, y, z].map(f64::from);
                context.multiply_matrix(Some(Matrix::rotation(f64::from(degrees), axis)))
            };
        }

        for_type!(@pointer $load, $type, |context, matrix| context.load_matrix(matrix));
        for_type!(@pointer $mult, $type, |context, matrix| context.multiply_matrix(matrix));
        for_type!(@pointer $load_transpose, $type, |context, matrix| {
            context.load_matrix(matrix.map(Matrix::transposed))
        });
        for_type!(@pointer $mult_transpose, $type, |context, matrix| {
            context.multiply_matrix(matrix.map(Matrix::transposed))
        });
    };
    (@pointer $name:ident, $type:ty, |$context:ident, $matrix:ident| $work:expr) => {
        /// # Safety
        /// As openrt/rt.h says: `elements` is null or points to 16 numbers.
        #[unsafe(no_mangle)]
        unsafe extern "C-unwind" fn $name(elements: *const $type) {
            // SAFETY: the caller vouches for 16 numbers.
            let elements: Option<[$type; 16]> = unsafe { array(elements) };
            let $matrix = elements.map(|elements| Matrix(elements.map(f64::from)));
            call!($name(elements), (), |$context| $work);
        }
    };
}

for_type!(f32: rtScalef rtTranslatef rtRotatef rtLoadMatrixf rtMultMatrixf rtLoadTransposeMatrixf
    rtMultTransposeMatrixf);
for_type!(f64: rtScaled rtTranslated rtRotated rtLoadMatrixd rtMultMatrixd rtLoadTransposeMatrixd
    rtMultTransposeMatrixd);
