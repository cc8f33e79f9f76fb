// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise and hashes: arguments to the library and back.

use super::machine::{D, Machine, Step};
use crate::types::{Base, Type};
use gnurt_sl_lib::noise::{self as lib, GaborOptions, NoiseKind};
use gnurt_sl_lib::text;

fn kind(m: &mut Machine<'_>, s: &Step) -> NoiseKind {
    match &*s.name {
        "snoise" | "psnoise" => NoiseKind::Perlin,
        "cellnoise" => NoiseKind::Cell,
        "hashnoise" => NoiseKind::Hash,
        _ if s.args.get(1).is_some_and(|a| a.ty == Type::STRING) => {
            let name = m.text(&s.args[1]);
            NoiseKind::named(&name).unwrap_or_else(|| {
                let source_position = m.source_position(s.at);
                m.error(format!("noise type \"{name}\" is unknown, called from ({source_position})"));
                NoiseKind::Null
            })
        }
        _ => NoiseKind::UPerlin,
    }
}

fn options(m: &Machine<'_>, s: &Step, first: usize) -> GaborOptions {
    let mut options = GaborOptions::default();
    for pair in s.args.get(first..).unwrap_or(&[]).chunks(2) {
        let [name, value] = pair else { break };
        match &*m.text(name) {
            "anisotropic" => options.anisotropic = m.int(value),
            "do_filter" => options.do_filter = m.int(value) != 0,
            "direction" => options.direction = m.triple_value(value),
            "bandwidth" => options.bandwidth = m.float(value, 0),
            "impulses" => options.impulses = m.float(value, 0),
            _ => {}
        }
    }
    options
}

pub(super) fn noise(m: &mut Machine<'_>, s: &Step) {
    let out = s.args[0];
    let kind = kind(m, s);
    let first = 1 + usize::from(s.args[1].ty == Type::STRING);
    let last = (first..s.args.len()).find(|&i| s.args[i].ty == Type::STRING).unwrap_or(s.args.len());
    let options = options(m, s, last);
    let mut numbers: Vec<D> = Vec::new();
    for slot in &s.args[first..last] {
        numbers.extend((0..slot.size as usize).map(|i| m.dual(slot, i)));
    }
    let periodic = s.name.starts_with('p');
    if numbers.is_empty()
        || numbers.len() > if periodic { 8 } else { 4 }
        || (periodic && !numbers.len().is_multiple_of(2))
    {
        return;
    }
    let (source_position, period) =
        if periodic { numbers.split_at(numbers.len() / 2) } else { (&*numbers, [].as_slice()) };
    let period: Vec<f32> = period.iter().map(|d| d.value).collect();
    let period = periodic.then_some(&*period);
    if out.size >= 3 {
        let value = kind.noise3(source_position, period, &options);
        m.set_triple(&out, value);
    } else {
        let value = kind.noise(source_position, period, &options);
        m.set(&out, 0, value);
    }
}

pub(super) fn hash(m: &mut Machine<'_>, s: &Step) {
    let rest = &s.args[1..];
    let value = match rest.first().map(|a| a.ty.base) {
        Some(Base::String) => text::hash_string(&m.text(&rest[0])),
        Some(Base::Int) if rest.len() == 1 => lib::hash_int(m.int(&rest[0])),
        _ => {
            let mut x: Vec<f32> = Vec::new();
            for slot in rest {
                x.extend((0..slot.size as usize).map(|i| m.float(slot, i)));
            }
            match *x {
                [a] => lib::hash_floats([a]),
                [a, b] => lib::hash_floats([a, b]),
                [a, b, c] => lib::hash_floats([a, b, c]),
                [a, b, c, d, ..] => lib::hash_floats([a, b, c, d]),
                [] => 0,
            }
        }
    };
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
