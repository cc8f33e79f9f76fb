// SPDX-License-Identifier: GPL-3.0-or-later
//! Where prims are: transform operations in their order, inverses and resets.
//! Source: UsdGeomXformable. The first operation of the order is the outermost. Space: parent. Tests: `tests/transforms.rs`.

use gnurt_scene::Affine;
use openusd::sdf::{Path, Value};

use crate::reader::Reader;
use crate::value;

/// Where a prim is on its parent, or in the world where it resets what its parents say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Local {
    pub(crate) parent_from_prim: Affine,
    pub(crate) resets: bool,
}

impl Reader {
    /// The transform of a prim.
    pub(crate) fn local(&self, prim: &Path) -> Local {
        let mut local = Local { parent_from_prim: Affine::IDENTITY, resets: false };
        let Some(order) = self.uniform(prim, "xformOpOrder").as_ref().and_then(value::words) else {
            return local;
        };
        for name in order {
            if name == "!resetXformStack!" {
                local = Local { parent_from_prim: Affine::IDENTITY, resets: true };
                continue;
            }
            let (name, is_inverse) = match name.strip_prefix("!invert!") {
                Some(name) => (name, true),
                None => (&name[..], false),
            };
            // An operation without a value moves nothing.
            let Some(value) = self.value(prim, name) else { continue };
            let kind = name.strip_prefix("xformOp:").unwrap_or(name).split(':').next().unwrap_or_default();
            let Some(operation) = operation(kind, &value) else {
                self.unsupported(prim, format_args!("transform operation '{name}'"));
                continue;
            };
            let operation = match is_inverse {
                true => operation.inverse(),
                false => Some(operation),
            };
            match operation {
                Some(operation) => local.parent_from_prim = local.parent_from_prim * operation,
                None => self.unsupported(prim, format_args!("inverse of the flat '{name}'")),
            }
        }
        local
    }
}

fn operation(kind: &str, value: &Value) -> Option<Affine> {
    const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let axis = |letter: char| "XYZ".find(letter).map(|k| (k, AXES[k]));
    let alone = |k: usize, x: f64, others: f64| {
        let mut v = [others; 3];
        v[k] = x;
        v
    };
    if let Some(letters) = kind.strip_prefix("rotate") {
        let mut letters = letters.chars();
        return match (letters.next(), letters.next(), letters.next()) {
            (Some(letter), None, None) => {
                Some(Affine::rotation(axis(letter)?.1, value::number(value)?.to_radians()))
            }
            // The first letter's turn is done first.
            (Some(a), Some(b), Some(c)) => {
                let degrees: [f64; 3] = value::vector(value)?;
                [c, b, a].into_iter().try_fold(Affine::IDENTITY, |product, letter| {
                    let (k, direction) = axis(letter)?;
                    Some(product * Affine::rotation(direction, degrees[k].to_radians()))
                })
            }
            _ => None,
        };
    }
    if let Some(letter) = kind.strip_prefix("translate").and_then(|rest| rest.chars().next()) {
        return Some(Affine::translation(alone(axis(letter)?.0, value::number(value)?, 0.0)));
    }
    if let Some(letter) = kind.strip_prefix("scale").and_then(|rest| rest.chars().next()) {
        return Some(Affine::scale(alone(axis(letter)?.0, value::number(value)?, 1.0)));
    }
    match kind {
        "translate" => Some(Affine::translation(value::vector(value)?)),
        "scale" => Some(Affine::scale(value::vector(value)?)),
        "orient" => value::quaternions(value)?.first().copied().map(rotation),
        "transform" => value::matrices(value)?.first().map(Affine::from_column_major),
        _ => None,
    }
}

/// The turn of a quaternion, the real part first; of any length but zero.
pub(crate) fn rotation([w, x, y, z]: [f64; 4]) -> Affine {
    let length = w * w + x * x + y * y + z * z;
    if length == 0.0 || !length.is_finite() {
        return Affine::IDENTITY;
    }
    let s = 2.0 / length;
    Affine {
        columns: [
            [1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)],
            [s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)],
            [s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)],
            [0.0; 3],
        ],
    }
}
