// SPDX-License-Identifier: GPL-3.0-or-later
//! Places of prims as matrices. Tests: `tests/save.rs`.

use gnurt_scene::Affine;

use super::text::Text;

/// A transform as rows.
pub(super) fn write_transform(transform: &Affine, text: &mut Text) {
    if *transform == Affine::IDENTITY {
        return;
    }
    let m = transform.to_column_major();
    let row = |r: usize| format!("({}, {}, {}, {})", m[4 * r], m[4 * r + 1], m[4 * r + 2], m[4 * r + 3]);
    let rows = [0, 1, 2, 3].map(row).join(", ");
    text.line(format_args!("matrix4d xformOp:transform = ({rows})"));
    text.line("uniform token[] xformOpOrder = [\"xformOp:transform\"]");
}

/// A frame that looks along -z.
pub(super) fn frame([right, up, back]: [[f32; 3]; 3], origin: [f32; 3]) -> Affine {
    Affine { columns: [right, up, back, origin].map(|v| v.map(f64::from)) }
}
