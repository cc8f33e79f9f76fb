// SPDX-License-Identifier: GPL-3.0-or-later
//! Matrices: those of 3 by 3 are the upper left of ones of 4 by 4. Points are rows.

use crate::error::Error;
use crate::generator::{Call, Generator};
use crate::types::Ty;

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let is_matrix = |ty: Ty| matches!(ty, Ty::Matrix33 | Ty::Matrix44);
    let part = match call.category() {
        node @ ("add" | "subtract") if is_matrix(call.out) => {
            let sign = if node == "add" { "+" } else { "-" };
            let [mut a, mut b] = [g.arg(call, "in1")?, g.arg(call, "in2")?];
            for value in [&mut a, &mut b].into_iter().filter(|value| is_matrix(value.ty)) {
                value.parts = vec![g.name("matrix", value.first())];
            }
            // The last row and column of a matrix of 3 by 3 stay.
            let size = if call.out == Ty::Matrix33 { 3 } else { 4 };
            let one = |i: usize| {
                let (row, column) = (i / 4, i % 4);
                if row.max(column) >= size {
                    return if row == column { "1.0" } else { "0.0" }.to_owned();
                }
                let of = |value: &crate::types::Value| match is_matrix(value.ty) {
                    true => format!("{}[{row}][{column}]", value.first()),
                    false => value.first().to_owned(),
                };
                format!("{} {sign} {}", of(&a), of(&b))
            };
            let numbers: Vec<String> = (0..16).map(one).collect();
            format!("matrix({})", numbers.join(", "))
        }
        node @ ("multiply" | "divide") if is_matrix(call.out) => {
            let [a, b] = [g.arg(call, "in1")?, g.arg(call, "in2")?];
            format!("{} {} {}", a.first(), if node == "multiply" { "*" } else { "/" }, b.first())
        }
        "transpose" => format!("transpose({})", g.arg(call, "in")?.first()),
        "determinant" => format!("determinant({})", g.arg(call, "in")?.first()),
        "invertmatrix" => format!("1 / {}", g.arg(call, "in")?.first()),
        "creatematrix" => {
            let mut rows = Vec::new();
            for (i, name) in ["in1", "in2", "in3", "in4"].iter().enumerate() {
                let mut row = match g.known.input(call.def, name) {
                    Some(_) => g.arg(call, name)?.scalars(),
                    None => vec!["0.0".into(); 3],
                };
                if row.len() == 3 {
                    row.push(if i == 3 { "1.0" } else { "0.0" }.into());
                }
                rows.extend(row);
            }
            format!("matrix({})", rows.join(", "))
        }
        "extract" => {
            // A row.
            let [value, index] = [g.arg(call, "in")?, g.arg(call, "index")?];
            let (m, i) = (g.name("matrix", value.first()), index.first());
            if call.out == Ty::Vector3 {
                return Ok(Some(vec![format!("vector({m}[{i}][0], {m}[{i}][1], {m}[{i}][2])")]));
            }
            return Ok(Some((0..4).map(|column| format!("{m}[{i}][{column}]")).collect()));
        }
        "transformmatrix" => {
            let [value, m] = [g.arg(call, "in")?, g.arg(call, "mat")?];
            let m = m.first();
            match (value.ty, call.def.name()) {
                (Ty::Vector2, _) => {
                    let [x, y] = [&value.parts[0], &value.parts[1]];
                    let turned = g.name("vector", &format!("transform({m}, vector({x}, {y}, 1))"));
                    return Ok(Some(vec![format!("{turned}[0]"), format!("{turned}[1]")]));
                }
                (Ty::Vector3, "ND_transformmatrix_vector3M4") => {
                    format!("transform({m}, {})", value.first())
                }
                (Ty::Vector3, _) => format!("transform({m}, {})", value.first()),
                _ => {
                    let m = g.name("matrix", m);
                    let one = |column: usize| {
                        let terms = value
                            .parts
                            .iter()
                            .enumerate()
                            .map(|(row, x)| format!("{x} * {m}[{row}][{column}]"));
                        terms.collect::<Vec<_>>().join(" + ")
                    };
                    return Ok(Some((0..4).map(one).collect()));
                }
            }
        }
        _ => return Ok(None),
    };
    Ok(Some(vec![part]))
}
