// SPDX-License-Identifier: GPL-3.0-or-later
//! Blends and Porter and Duff's operations [PD84] on colours, whose fourth number is opacity.

use crate::error::Error;
use crate::generator::{Call, Generator};
use crate::parts::each;
use crate::types::Value;

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let node = call.category().to_owned();
    let parts = match &*node {
        "plus" | "minus" | "difference" | "burn" | "dodge" | "screen" => {
            let [f, b, mix] = [g.arg(call, "fg")?, g.arg(call, "bg")?, g.arg(call, "mix")?];
            let form = |f: &str, b: &str| match &*node {
                "plus" => format!("({b} + {f})"),
                "minus" => format!("({b} - {f})"),
                "difference" => format!("abs({b} - {f})"),
                "screen" => format!("(1.0 - (1.0 - {f}) * (1.0 - {b}))"),
                _ => format!("gnurt_{node}({f}, {b})"),
            };
            if node == "burn" || node == "dodge" {
                g.needs(if node == "burn" { "gnurt_burn" } else { "gnurt_dodge" });
            }
            each(call.out, &[&f, &b, &mix], |a| {
                format!("{} * {} + (1.0 - {}) * {}", a[2], form(a[0], a[1]), a[2], a[1])
            })
        }
        "inside" | "outside" => {
            let [value, mask] = [g.arg(call, "in")?, g.arg(call, "mask")?];
            let form = |a: &[&str]| match &*node {
                "inside" => format!("{} * {}", a[0], a[1]),
                _ => format!("{} * (1.0 - {})", a[0], a[1]),
            };
            each(call.out, &[&value, &mask], form)
        }
        "in" | "mask" | "matte" | "out" | "over" | "disjointover" => over(g, call, &node)?,
        "premult" | "unpremult" => {
            let value = g.arg(call, "in")?;
            let [color, alpha] = [&value.parts[0], &value.parts[1]];
            let color = match &*node {
                "premult" => format!("{color} * {alpha}"),
                _ => format!("({alpha} == 0 ? {color} : {color} / {alpha})"),
            };
            vec![color, alpha.clone()]
        }
        _ => return Ok(None),
    };
    Ok(Some(parts))
}

fn over<'a>(g: &mut Generator<'a>, call: &Call<'a>, node: &str) -> Result<Vec<String>, Error> {
    let [f, b, mix] = [g.arg(call, "fg")?, g.arg(call, "bg")?, g.arg(call, "mix")?];
    let [[f_color, f_alpha], [b_color, b_alpha]] =
        [&f, &b].map(|value: &Value| [&value.parts[0], &value.parts[1]]);
    let (color, alpha) = match node {
        "in" => (format!("{f_color} * {b_alpha}"), format!("{f_alpha} * {b_alpha}")),
        "mask" => (format!("{b_color} * {f_alpha}"), format!("{b_alpha} * {f_alpha}")),
        "matte" => (
            format!("{f_color} * {f_alpha} + {b_color} * (1.0 - {f_alpha})"),
            format!("{f_alpha} + {b_alpha} * (1.0 - {f_alpha})"),
        ),
        "out" => (format!("{f_color} * (1.0 - {b_alpha})"), format!("{f_alpha} * (1.0 - {b_alpha})")),
        "over" => (
            format!("{f_color} + {b_color} * (1.0 - {f_alpha})"),
            format!("{f_alpha} + {b_alpha} * (1.0 - {f_alpha})"),
        ),
        _ => {
            let sum = g.name("float", &format!("{f_alpha} + {b_alpha}"));
            let share = g.name(
                "float",
                &format!("({sum} <= 1.0 || {b_alpha} <= 0 ? 1.0 : (1.0 - {f_alpha}) / {b_alpha})"),
            );
            (format!("{f_color} + {b_color} * {share}"), format!("min({sum}, 1.0)"))
        }
    };
    let m = mix.first();
    Ok(vec![
        format!("({color}) * {m} + {b_color} * (1.0 - {m})"),
        format!("({alpha}) * {m} + {b_alpha} * (1.0 - {m})"),
    ])
}
