// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures that a shader reads: by two coordinates, or by a direction.
//! Source: original; the options are OSL's. Directions are those of pictures over longitude and latitude with y up.

use super::host::{Given, TextureOptions};
use super::light::pairs;
use super::machine::{D, Machine, Step};
use super::slot::Slot;
use crate::hir::Data;
use crate::types::{Base, Type};
use gnurt_sl_lib::Dual;
use std::f32::consts::PI;

/// `texture (file, s, t [, dsdx, dtdx, dsdy, dtdy], options)`
pub(super) fn texture(m: &mut Machine<'_>, s: &Step) {
    let [out, file, at_s, at_t, rest @ ..] = &*s.args else { return };
    let mut at = [m.dual(at_s, 0), m.dual(at_t, 0)];
    let rest = match rest {
        [sx, tx, sy, ty, rest @ ..] if sx.ty != Type::STRING => {
            let [sx, tx, sy, ty] = [sx, tx, sy, ty].map(|slot| m.float(slot, 0));
            at = [Dual::new(at[0].value, sx, sy), Dual::new(at[1].value, tx, ty)];
            rest
        }
        rest => rest,
    };
    read(m, s, (out, file), at, rest);
}

/// `environment (file, R [, dRdx, dRdy], options)`
pub(super) fn environment(m: &mut Machine<'_>, s: &Step) {
    let [out, file, r, rest @ ..] = &*s.args else { return };
    let mut way = m.triple(r);
    let rest = match rest {
        [x, y, rest @ ..] if x.ty != Type::STRING => {
            let (x, y) = (m.triple_value(x), m.triple_value(y));
            for (k, way) in way.iter_mut().enumerate() {
                *way = Dual::new(way.value, x[k], y[k]);
            }
            rest
        }
        rest => rest,
    };
    let [x, y, z] = way;
    let place = |x: f32, y: f32, z: f32| [(-x).atan2(z) / (2.0 * PI) + 0.5, 0.5 - y.atan2(x.hypot(z)) / PI];
    let here = place(x.value, y.value, z.value);
    let step = |dx: f32, dy: f32, dz: f32| {
        let there = place(x.value + dx, y.value + dy, z.value + dz);
        // The shorter way around.
        let turn = there[0] - here[0];
        [turn - turn.round(), there[1] - here[1]]
    };
    let (right, down) = (step(x.dx, y.dx, z.dx), step(x.dy, y.dy, z.dy));
    let at = [0, 1].map(|k: usize| Dual::new(here[k], right[k], down[k]));
    read(m, s, (out, file), at, rest);
}

fn read(m: &mut Machine<'_>, s: &Step, (out, file): (&Slot, &Slot), at: [D; 2], rest: &[Slot]) {
    let mut options = TextureOptions::default();
    let (mut alpha, mut message) = (None, None);
    let mut missing_alpha = 1.0;
    pairs(m, rest, |m, name, value| match name {
        "alpha" => alpha = Some(*value),
        "errormessage" => message = Some(*value),
        "firstchannel" => options.first_channel = m.int(value),
        "fill" => options.fill = m.float(value, 0),
        "missingcolor" => options.missing = Some(m.triple_value(value)),
        "missingalpha" => missing_alpha = m.float(value, 0),
        "wrap" => options.wrap = [m.text(value), m.text(value)],
        "swrap" => options.wrap[0] = m.text(value),
        "twrap" => options.wrap[1] = m.text(value),
        "width" => options.width = [m.float(value, 0); 2],
        "swidth" => options.width[0] = m.float(value, 0),
        "twidth" => options.width[1] = m.float(value, 0),
        "blur" => options.blur = [m.float(value, 0); 2],
        "sblur" => options.blur[0] = m.float(value, 0),
        "tblur" => options.blur[1] = m.float(value, 0),
        "interp" => options.interpolation = m.text(value),
        _ => {}
    });
    let file = m.text(file);
    let (texel, why) = match m.host.texture(&file, at, &options, &m.point) {
        Ok(texel) => (texel, String::new()),
        Err(why) => {
            if options.missing.is_none() && message.is_none() {
                let place = m.place(s.at);
                m.error(format!("{why} ({place})"));
            }
            let [r, g, b] = options.missing.unwrap_or([0.0; 3]);
            ([r, g, b, missing_alpha], why)
        }
    };
    let channels = if out.ty.base == Base::Float { 1 } else { 3 };
    for (i, &x) in texel.iter().enumerate().take(channels) {
        m.set(out, i, x.into());
    }
    if let Some(alpha) = alpha {
        m.set(&alpha, 0, texel[channels].into());
    }
    if let Some(message) = message {
        m.set_text(&message, 0, &why);
    }
}

/// `gettextureinfo (file, name, value)`
pub(super) fn info(m: &mut Machine<'_>, s: &Step) {
    let [out, file, .., name, value] = &*s.args else { return };
    let (file, name) = (m.text(file), m.text(name));
    let size = m.host.texture_size(&file);
    let found: Option<Vec<i32>> = match (&*name, size) {
        ("exists", _) => Some(vec![i32::from(size.is_some())]),
        ("resolution", Some([w, h, _])) => Some(vec![w, h]),
        ("channels", Some([_, _, channels])) => Some(vec![channels]),
        _ => None,
    };
    let fits = found.as_ref().is_some_and(|list| list.len() <= value.ty.size());
    if let (true, Some(list)) = (fits, found) {
        m.give(value, &Given::from(Data::Int(list)));
    }
    m.set_int(out, i32::from(fits));
}
