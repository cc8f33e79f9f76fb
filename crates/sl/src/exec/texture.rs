// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures that a shader reads: by two coordinates, or by a direction; volumes, by a place.
//! Source: original; the options are OSL's. Directions are those of pictures over longitude and latitude with y up.

use super::host::{Given, Subimage, TextureOptions};
use super::light::pairs;
use super::machine::{D, Machine, Step};
use super::slot::Slot;
use crate::types::{Base, Type};
use gnurt_sl_lib::Dual;

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
    read(m, s, out, rest, |m, options| m.host.texture(&m.text(file), at, options, &m.point));
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
    read(m, s, out, rest, |m, options| m.host.environment(&m.text(file), way, options, &m.point));
}

/// `texture3d (file, P [, dPdx, dPdy, dPdz], options)`
pub(super) fn texture3d(m: &mut Machine<'_>, s: &Step) {
    let [out, file, p, rest @ ..] = &*s.args else { return };
    let mut place = m.triple(p);
    let rest = match rest {
        [x, y, _, rest @ ..] if x.ty != Type::STRING => {
            let (x, y) = (m.triple_value(x), m.triple_value(y));
            for (k, place) in place.iter_mut().enumerate() {
                *place = Dual::new(place.value, x[k], y[k]);
            }
            rest
        }
        rest => rest,
    };
    read(m, s, out, rest, |m, options| m.host.texture3d(&m.text(file), place, options, &m.point));
}

fn read(
    m: &mut Machine<'_>,
    s: &Step,
    out: &Slot,
    rest: &[Slot],
    ask: impl FnOnce(&Machine<'_>, &TextureOptions) -> Result<[D; 4], String>,
) {
    let mut options = TextureOptions::default();
    let (mut alpha, mut message) = (None, None);
    let mut missing_alpha = None;
    pairs(m, rest, |m, name, value| match name {
        "alpha" => alpha = Some(*value),
        "errormessage" => message = Some(*value),
        "firstchannel" => options.first_channel = m.int(value),
        "fill" => options.fill = m.float(value, 0),
        "missingcolor" => options.missing = Some(m.triple_value(value)),
        "missingalpha" => missing_alpha = Some(m.float(value, 0)),
        "wrap" => options.wrap = std::array::from_fn(|_| m.text(value)),
        "swrap" => options.wrap[0] = m.text(value),
        "twrap" => options.wrap[1] = m.text(value),
        "rwrap" => options.wrap[2] = m.text(value),
        "subimage" if value.ty == Type::STRING => options.subimage = Subimage::Name(m.text(value)),
        "subimage" => options.subimage = Subimage::Number(m.int(value)),
        "width" => options.width = [m.float(value, 0); 2],
        "swidth" => options.width[0] = m.float(value, 0),
        "twidth" => options.width[1] = m.float(value, 0),
        "blur" => options.blur = [m.float(value, 0); 2],
        "sblur" => options.blur[0] = m.float(value, 0),
        "tblur" => options.blur[1] = m.float(value, 0),
        "interp" => options.interpolation = m.text(value),
        _ => {}
    });
    let channels = if out.ty.base == Base::Float { 1 } else { 3 };
    options.channels = channels + usize::from(alpha.is_some());
    let (texel, why) = match ask(m, &options) {
        Ok(texel) => (texel, String::new()),
        Err(why) => {
            // A reason is given once.
            if !why.is_empty() && options.missing.is_none() && missing_alpha.is_none() && message.is_none() {
                let said = m.host.texture_fault(&s.name, &why, &m.place(s.at));
                m.error(said);
            }
            let mut texel = [options.missing.map_or(options.fill, |_| 1.0); 4];
            texel[..3].copy_from_slice(&options.missing.unwrap_or([options.fill; 3]));
            texel[channels] = missing_alpha.unwrap_or(texel[3]);
            (texel.map(D::from), if why.is_empty() { "unknown".to_owned() } else { why })
        }
    };
    for (i, &x) in texel.iter().enumerate().take(channels) {
        m.set(out, i, x);
    }
    if let Some(alpha) = alpha {
        m.set(&alpha, 0, texel[channels]);
    }
    if let Some(message) = message {
        m.set_text(&message, 0, &why);
    }
}

/// `gettextureinfo (file [, s, t], name, value)`
pub(super) fn info(m: &mut Machine<'_>, s: &Step) {
    let [out, file, at @ .., name, value] = &*s.args else { return };
    let at = if let [s, t] = at { Some([m.float(s, 0), m.float(t, 0)]) } else { None };
    let found = match m.host.texture_info(&m.text(file), at, &m.text(name), value.ty) {
        Ok(found) => found,
        Err(why) => {
            let said = m.host.texture_fault("get_texture_info", &why, &m.place(s.at));
            m.error(said);
            None
        }
    };
    let found = found.filter(|data| data.count() <= value.ty.size());
    m.set_int(out, i32::from(found.is_some()));
    if let Some(data) = found {
        m.give(value, &Given::from(data));
    }
}
