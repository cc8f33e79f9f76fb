// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays and lights that a shader queries. `trace` that gives an int is OSL's.

use super::host::TraceOptions;
use super::machine::{Machine, Step};
use super::slot::Slot;
use crate::types::Type;
use gnurt_sl_lib::Dual;

/// Calls `with(name, value)` for the remaining pairs of arguments.
pub(super) fn pairs(m: &mut Machine<'_>, args: &[Slot], mut with: impl FnMut(&mut Machine<'_>, &str, &Slot)) {
    for pair in args.chunks_exact(2) {
        let name = m.text(&pair[0]);
        with(m, &name, &pair[1]);
    }
}

/// Whether a ray hits, or its radiance.
pub(super) fn trace(m: &mut Machine<'_>, s: &Step) {
    let [out, p, r, rest @ ..] = &*s.args else { return };
    let (p, r) = (Dual::from_components(m.triple(p)), Dual::from_components(m.triple(r)));
    let mut options = TraceOptions::default();
    pairs(m, rest, |m, name, value| match name {
        "mindist" => options.mindist = m.float(value, 0),
        "maxdist" => options.maxdist = m.float(value, 0),
        "traceset" => options.traceset = m.text(value),
        _ => {}
    });
    if out.ty == Type::INT {
        let hit = m.host.trace(p, r, &options, &m.point);
        m.set_int(out, i32::from(hit));
    } else {
        let incoming = m.host.radiance(p, r, &options, &m.point);
        m.set_triple(out, Dual::from(incoming).components());
    }
}

/// How many lights there are.
pub(super) fn count(m: &mut Machine<'_>, s: &Step) {
    let count = m.host.light_count();
    m.set_int(&s.args[0], count);
}

/// One light of `illuminance`: number, position, then maybe an axis and an angle, then L, Cl, lightdist and
/// lightpdf to be written.
pub(super) fn illuminate(m: &mut Machine<'_>, s: &Step) {
    let [out, light, p, rest @ ..] = &*s.args else { return };
    let (cone, rest) = match rest {
        [axis, angle, rest @ ..] if angle.ty == Type::FLOAT => (Some((axis, angle)), rest),
        _ => (None, rest),
    };
    let [l, cl, distance, pdf, rest @ ..] = rest else { return };
    let (mut category, mut shadowed) = ("".into(), true);
    pairs(m, rest, |m, name, value| match name {
        "category" => category = m.text(value),
        "shadow" => shadowed = m.int(value) != 0,
        _ => {}
    });
    let found = m.host.illuminate(m.int(light), m.triple_value(p), &category, shadowed, &m.point);
    let found = found.filter(|light| {
        let Some((axis, angle)) = cone else { return true };
        let axis = m.triple_value(axis);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let length = dot(axis, axis).sqrt();
        length > 0.0 && dot(axis, light.dir) >= length * m.float(angle, 0).cos()
    });
    m.set_int(out, i32::from(found.is_some()));
    let light = found.unwrap_or_default();
    m.set_triple(l, Dual::from(light.dir).components());
    m.set_triple(cl, Dual::from(light.light).components());
    m.set(distance, 0, light.distance.into());
    m.set(pdf, 0, light.pdf.into());
}
