// SPDX-License-Identifier: GPL-3.0-or-later
//! Spaces by name, and colours.
//! The words are OSL's.

use super::host::Point;
use super::machine::{Machine, Step};
use crate::opcode::Opcode;
use crate::types::Type;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::matrix::{self as mx, Spaces};

type Matrix = [[f32; 4]; 4];

struct Of<'m, 'a>(&'m Machine<'a>);

impl Spaces for Of<'_, '_> {
    fn common_from(&self, space: &str) -> Option<Matrix> {
        self.0.host.common_from(space, &self.0.point)
    }

    fn to_common_inverse(&self, space: &str) -> Option<Matrix> {
        self.0.host.to_common_inverse(space, &self.0.point)
    }
}

impl Machine<'_> {
    fn transform_between(&mut self, s: &Step, from: &str, to: &str) -> Option<Matrix> {
        if let Ok(m) = mx::transform_between(&Of(self), from, to) {
            return Some(m);
        }
        for space in [from, to] {
            if mx::transform_between(&Of(self), space, "common").is_err() {
                self.located_error(s, format!("Unknown transformation \"{space}\""));
            }
        }
        None
    }
}

impl Machine<'_> {
    /// The matrix between two spaces at a point, if both are known; without a message.
    pub(super) fn spaces_at(&mut self, point: Point, from: &str, to: &str) -> Option<Matrix> {
        let own = std::mem::replace(&mut self.point, point);
        let found = mx::transform_between(&Of(self), from, to).ok();
        self.point = own;
        found
    }
}

const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// `point("space", x, y, z)`
pub(super) fn triple(m: &mut Machine<'_>, s: &Step) {
    let (out, rest) = (s.args[0], &s.args[1..]);
    let Some((space, numbers)) = rest.split_first().filter(|(_, numbers)| !numbers.is_empty()) else {
        return;
    };
    let value = [0, 1, 2].map(|i: usize| m.dual(&numbers[i.min(numbers.len() - 1)], 0));
    let space = m.text(space);
    let matrix = m.transform_between(s, &space, "common").unwrap_or(IDENTITY);
    let value = match out.ty {
        Type::POINT => mx::transform_point(&matrix, value),
        Type::NORMAL => mx::transform_normal(&matrix, value),
        _ => mx::transform_vector(&matrix, value),
    };
    m.set_triple(&out, value);
}

/// `color("space", a, b, c)`
pub(super) fn color(m: &mut Machine<'_>, s: &Step) {
    if s.args.len() < 5 {
        return;
    }
    let value = [2, 3, 4].map(|i| m.dual(&s.args[i], 0));
    let from = m.text(&s.args[1]);
    convert(m, s, &from, "rgb", value);
}

pub(super) fn transform_color(m: &mut Machine<'_>, s: &Step) {
    let (from, to) = (m.text(&s.args[1]), m.text(&s.args[2]));
    let value = m.triple(&s.args[3]);
    convert(m, s, &from, &to, value);
}

fn convert(m: &mut Machine<'_>, s: &Step, from: &str, to: &str, value: [Dual<f32>; 3]) {
    let value = match m.host.color_system().transform(from, to, value) {
        Ok(value) => value,
        Err(unknown) => {
            m.located_error(s, unknown.to_string());
            value
        }
    };
    m.set_triple(&s.args[0], value);
}

pub(super) fn matrix(m: &mut Machine<'_>, s: &Step) {
    let (out, rest) = (s.args[0], &s.args[1..]);
    let value = match rest {
        [from, to] if to.ty == Type::STRING => {
            let (from, to) = (m.text(from), m.text(to));
            m.transform_between(s, &from, &to).unwrap_or(IDENTITY)
        }
        [space, numbers @ ..] if !numbers.is_empty() => {
            let given: Matrix = if numbers.len() >= 16 {
                std::array::from_fn(|r| std::array::from_fn(|c| m.float(&numbers[r * 4 + c], 0)))
            } else {
                m.matrix(&numbers[0])
            };
            let space = m.text(space);
            mx::multiply(&m.transform_between(s, &space, "common").unwrap_or(IDENTITY), &given)
        }
        _ => return,
    };
    m.set_matrix(&out, &value);
}

pub(super) fn get_matrix(m: &mut Machine<'_>, s: &Step) {
    let [ok, from, to, out] = &*s.args else { return };
    let (from, to) = (m.text(from), m.text(to));
    let found = m.transform_between(s, &from, &to);
    m.set_matrix(out, &found.unwrap_or(IDENTITY));
    m.set_int(ok, i32::from(found.is_some()));
}

pub(super) fn transform(m: &mut Machine<'_>, s: &Step) {
    let (out, rest) = (s.args[0], &s.args[1..]);
    let Some(value) = rest.last().map(|a| m.triple(a)) else { return };
    let matrix = match rest {
        [matrix, _] if matrix.ty == Type::MATRIX => m.matrix(matrix),
        [to, _] => {
            let to = m.text(to);
            m.transform_between(s, "common", &to).unwrap_or(IDENTITY)
        }
        [from, to, ..] => {
            let (from, to) = (m.text(from), m.text(to));
            m.transform_between(s, &from, &to).unwrap_or(IDENTITY)
        }
        _ => return,
    };
    let value = match s.code {
        Opcode::TransformV => mx::transform_vector(&matrix, value),
        Opcode::TransformN => mx::transform_normal(&matrix, value),
        _ => mx::transform_point(&matrix, value),
    };
    m.set_triple(&out, value);
}

/// Units of length are those of the scene: there is nothing to convert.
pub(super) fn units(m: &mut Machine<'_>, s: &Step) {
    if let Some(value) = s.args.last().map(|a| m.dual(a, 0)) {
        m.set(&s.args[0], 0, value);
    }
}

pub(super) fn blackbody(m: &mut Machine<'_>, s: &Step) {
    let value = m.host.color_system().blackbody(m.float(&s.args[1], 0));
    m.set_triple(&s.args[0], Dual::from(value).components());
}

pub(super) fn wavelength(m: &mut Machine<'_>, s: &Step) {
    let value = m.host.color_system().wavelength_color(m.float(&s.args[1], 0));
    m.set_triple(&s.args[0], Dual::from(value).components());
}

pub(super) fn luminance(m: &mut Machine<'_>, s: &Step) {
    let value = m.host.color_system().luminance(m.triple(&s.args[1]));
    m.set(&s.args[0], 0, value);
}
