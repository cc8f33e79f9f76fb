// SPDX-License-Identifier: GPL-3.0-or-later
//! Flakes of metallic paint: cells around jittered points, the nearest of those that are there.

use crate::error::Error;
use crate::generator::{Call, Generator, Outputs};
use crate::types::{Ty, Value};

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Outputs, Error> {
    let place = match call.category() {
        "flake3d" => format!("point({})", g.arg(call, "position")?.first()),
        _ => {
            let at = g.arg(call, "texcoord")?;
            format!("point({}, {}, 0)", at.parts[0], at.parts[1])
        }
    };
    let mut a = Vec::new();
    for name in ["size", "roughness", "coverage", "normal", "tangent", "bitangent"] {
        a.push(g.arg(call, name)?.first().to_owned());
    }
    g.needs("gnurt_flake");
    let outputs =
        [("id", Ty::Integer), ("rand", Ty::Float), ("presence", Ty::Float), ("flakenormal", Ty::Vector3)];
    let named: Vec<(String, Value)> = outputs
        .into_iter()
        .map(|(name, ty)| (name.to_owned(), Value::new(ty, vec![g.name(ty.parts()[0], "0")])))
        .collect();
    let names: Vec<&str> = named.iter().map(|(_, value)| value.first()).collect();
    let dimensions = if call.category() == "flake3d" { 3 } else { 2 };
    g.body.push_str(&format!(
        "    gnurt_flake({place}, {dimensions}, {}, {});\n",
        a.join(", "),
        names.join(", ")
    ));
    Ok(named)
}
