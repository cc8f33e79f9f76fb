// SPDX-License-Identifier: GPL-3.0-or-later
//! Values part by part.

use crate::types::{Ty, Value};

/// An expression for each part of a type; arguments of one number are spread.
pub(crate) fn each(out: Ty, args: &[&Value], f: impl Fn(&[&str]) -> String) -> Vec<String> {
    let kinds = out.parts();
    let part = |i: usize, kind: &str| {
        let spread: Vec<String> = args
            .iter()
            .map(|arg| {
                let is_same = arg.parts.len() == kinds.len();
                let (part, own) = if is_same {
                    (&arg.parts[i], arg.ty.parts()[i])
                } else {
                    (&arg.parts[0], arg.ty.parts()[0])
                };
                let is_scalar = matches!(own, "float" | "int");
                match is_scalar && matches!(kind, "color" | "vector") {
                    true => format!("{kind}({part})"),
                    false => part.clone(),
                }
            })
            .collect();
        let spread: Vec<&str> = spread.iter().map(|part| &**part).collect();
        f(&spread)
    };
    kinds.iter().enumerate().map(|(i, kind)| part(i, kind)).collect()
}

/// The parts of a type made of numbers.
pub(crate) fn from_scalars(ty: Ty, n: &[String]) -> Vec<String> {
    match ty {
        Ty::Color3 => vec![format!("color({})", n.join(", "))],
        Ty::Vector3 => vec![format!("vector({})", n.join(", "))],
        Ty::Color4 => vec![format!("color({})", n[..3].join(", ")), n[3].clone()],
        _ => n.to_vec(),
    }
}

fn count(ty: Ty) -> Option<usize> {
    match ty {
        Ty::Float | Ty::Integer | Ty::Boolean => Some(1),
        Ty::Vector2 => Some(2),
        Ty::Color3 | Ty::Vector3 => Some(3),
        Ty::Color4 | Ty::Vector4 => Some(4),
        _ => None,
    }
}

/// A value as another type, where numbers suffice.
pub(crate) fn converted(value: &Value, ty: Ty) -> Option<Vec<String>> {
    let (from, to) = (count(value.ty)?, count(ty)?);
    let mut n = value.scalars();
    match (from, to) {
        (1, to) => n = vec![n[0].clone(); to],
        (3, 4) => n.push("1.0".into()),
        (4, 3) => n.truncate(3),
        (from, to) if from == to => {}
        _ => return None,
    }
    if ty == Ty::Integer || ty == Ty::Boolean {
        return Some(vec![format!("(int) {}", n[0])]);
    }
    Some(from_scalars(ty, &n))
}

/// Numbers of a value in another order: `xyzw`, `rgba`, `0`, `1`.
pub(crate) fn swizzled(value: &Value, channels: &str, ty: Ty) -> Result<Vec<String>, String> {
    let n = value.scalars();
    let pick = |c: char| match c {
        '0' => Ok("0.0".to_owned()),
        '1' => Ok("1.0".to_owned()),
        c => {
            let place = "xyzw".find(c).or_else(|| "rgba".find(c));
            place.and_then(|i| n.get(i)).cloned().ok_or_else(|| format!("no channel '{c}'"))
        }
    };
    let picked: Vec<String> = channels.chars().map(pick).collect::<Result<_, _>>()?;
    match count(ty) {
        Some(wanted) if wanted == picked.len() => Ok(from_scalars(ty, &picked)),
        _ => Err(format!("channels '{channels}' are not a {}", ty.name())),
    }
}
