// SPDX-License-Identifier: GPL-3.0-or-later
//! Hashes of texts and positions.

use super::machine::{Machine, Step};
use gnurt_sl_lib::noise as lib;
use gnurt_sl_lib::text;

/// Of a text.
pub(super) fn hash(m: &mut Machine<'_>, s: &Step) {
    let value = text::hash_string(&m.text(&s.args[1]));
    m.set_int(&s.args[0], value);
}

/// A number in [0, 1) that depends on the point and the position in the text.
pub(super) fn random(m: &mut Machine<'_>, s: &Step) {
    let out = s.args[0];
    let (index, line) = (m.point.index as f32, s.at.line as f32);
    for i in 0..out.size as usize {
        let value = lib::hash_floats([index, line, i as f32]) as u32;
        m.set(&out, i, ((value >> 8) as f32 / 16_777_216.0).into());
    }
}
