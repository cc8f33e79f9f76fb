// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures that a shader reads: by two coordinates, or by a direction; volumes, by a position. The options
//! are OSL's. Directions are those of pictures over longitude and latitude with y up.

use super::cells::{Batch, Cells, DualRow};
use super::host::{Given, Subimage, TextureOptions};
use super::machine::{D, Machine, Step};
use super::rows;
use super::slot::Slot;
use super::strings::Strings;
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
    let mut direction = m.triple(r);
    let rest = match rest {
        [x, y, rest @ ..] if x.ty != Type::STRING => {
            let (x, y) = (m.triple_value(x), m.triple_value(y));
            for (k, direction) in direction.iter_mut().enumerate() {
                *direction = Dual::new(direction.value, x[k], y[k]);
            }
            rest
        }
        rest => rest,
    };
    read(m, s, out, rest, |m, options| m.host.environment(&m.text(file), direction, options, &m.point));
}

/// `texture3d (file, P [, dPdx, dPdy, dPdz], options)`
pub(super) fn texture3d(m: &mut Machine<'_>, s: &Step) {
    let [out, file, p, rest @ ..] = &*s.args else { return };
    let mut position = m.triple(p);
    let rest = match rest {
        [x, y, _, rest @ ..] if x.ty != Type::STRING => {
            let (x, y) = (m.triple_value(x), m.triple_value(y));
            for (k, position) in position.iter_mut().enumerate() {
                *position = Dual::new(position.value, x[k], y[k]);
            }
            rest
        }
        rest => rest,
    };
    read(m, s, out, rest, |m, options| m.host.texture3d(&m.text(file), position, options, &m.point));
}

/// The options of a texture operation.
struct TextureReport {
    options: TextureOptions,
    /// Where opacity goes, and why there is no picture.
    alpha: Option<Slot>,
    message: Option<Slot>,
    missing_alpha: Option<f32>,
    /// How many channels go to the result.
    channels: usize,
}

impl TextureReport {
    /// From the pairs of names and values after the coordinates; `cell_bits` returns the contents of cells.
    /// `None` if an option is unsupported here.
    fn of(
        strings: &Strings,
        out: &Slot,
        rest: &[Slot],
        cell_bits: &dyn Fn(u32) -> Option<u32>,
    ) -> Option<Self> {
        let text = |slot: &Slot| match slot.ty.base {
            Base::String => cell_bits(slot.at).map(|number| strings.text(number)),
            _ => Some(strings.text(0)),
        };
        let number = |slot: &Slot, i: u32| {
            let cell_bits = cell_bits(slot.at + if slot.size == 1 { 0 } else { i })?;
            Some(if slot.ty.base == Base::Int { cell_bits as i32 as f32 } else { f32::from_bits(cell_bits) })
        };
        let int = |slot: &Slot| match slot.ty.base {
            Base::Int => cell_bits(slot.at).map(|cell_bits| cell_bits as i32),
            _ => number(slot, 0).map(|x| x as i32),
        };
        let mut options = TextureOptions::default();
        let (mut alpha, mut message, mut missing_alpha) = (None, None, None);
        for pair in rest.chunks_exact(2) {
            let [name, value] = pair else { continue };
            match &**text(name)? {
                "alpha" => alpha = Some(*value),
                "errormessage" => message = Some(*value),
                "firstchannel" => options.first_channel = int(value)?,
                "fill" => options.fill = number(value, 0)?,
                "missingcolor" => {
                    options.missing = Some([number(value, 0)?, number(value, 1)?, number(value, 2)?]);
                }
                "missingalpha" => missing_alpha = Some(number(value, 0)?),
                "wrap" => options.wrap.fill(text(value)?.clone()),
                "swrap" => options.wrap[0] = text(value)?.clone(),
                "twrap" => options.wrap[1] = text(value)?.clone(),
                "rwrap" => options.wrap[2] = text(value)?.clone(),
                "subimage" => {
                    options.subimage = match value.ty {
                        Type::STRING => Subimage::Name(text(value)?.clone()),
                        _ => Subimage::Number(int(value)?),
                    }
                }
                "width" => options.width = [number(value, 0)?; 2],
                "swidth" => options.width[0] = number(value, 0)?,
                "twidth" => options.width[1] = number(value, 0)?,
                "blur" => options.blur = [number(value, 0)?; 2],
                "sblur" => options.blur[0] = number(value, 0)?,
                "tblur" => options.blur[1] = number(value, 0)?,
                "colorspace" => options.color_space = text(value)?.clone(),
                "interp" => options.interpolation = text(value)?.clone(),
                _ => {}
            }
        }
        let channels = if out.ty.base == Base::Float { 1 } else { 3 };
        options.channels = channels + usize::from(alpha.is_some());
        options.derivs = out.derivs || alpha.is_some_and(|alpha| alpha.derivs);
        Some(Self { options, alpha, message, missing_alpha, channels })
    }
}

/// `texture` for many points at once. None if they must be requested one by one.
pub(super) fn textures(m: &Machine<'_>, step: &Step, lanes: u32, batch: &mut dyn Batch) -> Option<()> {
    let [out, file, at_s, at_t, rest @ ..] = &*step.args else { return None };
    let one = |cell: u32| match batch.get(cell) {
        Cells::One(cell_bits) => Some(cell_bits),
        Cells::Each(_) => None,
    };
    let (changes, rest) = match rest {
        [sx, tx, sy, ty, rest @ ..] if sx.ty != Type::STRING => (Some([[sx, sy], [tx, ty]]), rest),
        rest => (None, rest),
    };
    let TextureReport { options, alpha, message, channels, .. } =
        TextureReport::of(&m.strings, out, rest, &one)?;
    let is_written = |slot: Slot| {
        let mut args = step.args.iter().enumerate();
        slot.ty.base.is_float_based()
            && args.any(|(i, arg)| i < 64 && step.writes >> i & 1 != 0 && arg.at == slot.at)
    };
    if file.ty != Type::STRING || message.is_some() || !alpha.is_none_or(is_written) {
        return None;
    }
    let file = m.strings.text(one(file.at)?);
    let mut coordinates = [DualRow::default(); 2];
    for (k, (position, slot)) in coordinates.iter_mut().zip([at_s, at_t]).enumerate() {
        *position = rows::dual(batch, slot, 0);
        if let Some(changes) = changes {
            position.dx = rows::dual(batch, changes[k][0], 0).value;
            position.dy = rows::dual(batch, changes[k][1], 0).value;
        }
    }
    let mut texels = [DualRow::default(); 4];
    if !m.host.textures(file, lanes, &coordinates, &options, &mut texels) {
        return None;
    }
    for (i, texel) in texels[..channels].iter().enumerate() {
        rows::put(batch, lanes, (out, i as u32), texel);
    }
    if let Some(alpha) = alpha {
        rows::put(batch, lanes, (&alpha, 0), &texels[channels]);
    }
    Some(())
}

fn read(
    m: &mut Machine<'_>,
    s: &Step,
    out: &Slot,
    rest: &[Slot],
    query: impl FnOnce(&Machine<'_>, &TextureOptions) -> Result<[D; 4], String>,
) {
    let known = |cell: u32| m.memory.get(cell as usize).copied();
    let Some(TextureReport { options, alpha, message, missing_alpha, channels }) =
        TextureReport::of(&m.strings, out, rest, &known)
    else {
        return;
    };
    let (texel, why) = match query(m, &options) {
        Ok(texel) => (texel, String::new()),
        Err(why) => {
            // A reason is given once.
            if !why.is_empty() && options.missing.is_none() && missing_alpha.is_none() && message.is_none() {
                let reports = m.host.texture_fault(s.code.name(), &why, &m.source_position(s.at));
                m.error(reports);
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
            let reports = m.host.texture_fault("get_texture_info", &why, &m.source_position(s.at));
            m.error(reports);
            None
        }
    };
    let found = found.filter(|data| data.count() <= value.ty.size());
    m.set_int(out, i32::from(found.is_some()));
    if let Some(data) = found {
        m.give(value, &Given::from(data));
    }
}
