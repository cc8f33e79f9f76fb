// SPDX-License-Identifier: GPL-3.0-or-later
//! Noise: the language's own gradient and cell noise, sums of octaves, and distances to jittered points [Wor96].

use crate::error::Error;
use crate::generator::{Call, Generator};
use crate::parts::each;
use crate::types::{Ty, Value};

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let node = call.category().to_owned();
    let (kind, is_3d) = match &*node {
        "noise2d" | "cellnoise2d" | "fractal2d" | "worleynoise2d" => (&node[..node.len() - 2], false),
        "noise3d" | "cellnoise3d" | "fractal3d" | "worleynoise3d" => (&node[..node.len() - 2], true),
        _ => return Ok(None),
    };
    let place = g.arg(call, if is_3d { "position" } else { "texcoord" })?;
    // A point of three dimensions, or two numbers.
    let at = match is_3d {
        true => format!("point({})", place.first()),
        false => place.parts.join(", "),
    };
    // Beyond three numbers the noise of another place.
    let other = match is_3d {
        true => format!("point({}) + point(19, 73, 29)", place.first()),
        false => format!("{} + 19, {} + 73", place.parts[0], place.parts[1]),
    };
    let elsewhere = match is_3d {
        true => format!("point({}) + point(19, 193, 17)", place.first()),
        false => format!("{} + 19, {} + 193", place.parts[0], place.parts[1]),
    };
    Ok(Some(match kind {
        "noise" => {
            let [amplitude, pivot] = [g.arg(call, "amplitude")?, g.arg(call, "pivot")?];
            let noise = signed(g, call.out, &at, &other);
            each(call.out, &[&noise, &amplitude, &pivot], |a| format!("{} * {} + {}", a[0], a[1], a[2]))
        }
        "cellnoise" => vec![format!("cellnoise({at})")],
        "fractal" => {
            let names = ["octaves", "lacunarity", "diminish", "amplitude"];
            let args: Vec<Value> = names.iter().map(|name| g.arg(call, name)).collect::<Result<_, _>>()?;
            let [octaves, lacunarity, diminish] = [0, 1, 2].map(|i: usize| args[i].first());
            g.needs(if is_3d { "gnurt_fractal3" } else { "gnurt_fractal2" });
            let dimensions = if is_3d { 3 } else { 2 };
            let sum = |kind: &str, at: &str| {
                format!("gnurt_fractal{dimensions}_{kind}({at}, {octaves}, {lacunarity}, {diminish})")
            };
            let noise = match call.out {
                Ty::Float => vec![sum("float", &at)],
                Ty::Vector3 => vec![sum("vector", &at)],
                Ty::Vector2 => vec![sum("float", &at), sum("float", &elsewhere)],
                _ => {
                    let most = g.name("vector", &sum("vector", &at));
                    let last = g.name("float", &sum("float", &elsewhere));
                    vec![format!("{most}[0]"), format!("{most}[1]"), format!("{most}[2]"), last]
                }
            };
            let noise = Value::new(call.out, noise);
            each(call.out, &[&noise, &args[3]], |a| format!("{} * {}", a[0], a[1]))
        }
        _ => {
            let [jitter, style] = [g.arg(call, "jitter")?, g.arg(call, "style")?];
            let at = if is_3d { at } else { format!("point({at}, 0)") };
            g.needs("gnurt_worley");
            let dimensions = if is_3d { 3 } else { 2 };
            let rest = format!("{at}, {}, {}, {dimensions}", jitter.first(), style.first());
            if call.out == Ty::Float {
                vec![format!("gnurt_worley_float({rest})")]
            } else {
                let cell = g.name("point", "0");
                let found = g.name("vector", &format!("gnurt_worley({rest}, {cell})"));
                match call.out {
                    Ty::Vector3 => vec![found],
                    _ => vec![format!("{found}[0]"), format!("{found}[1]")],
                }
            }
        }
    }))
}

/// Noise between -1 and 1 for each number of a type.
fn signed(g: &mut Generator<'_>, ty: Ty, at: &str, other: &str) -> Value {
    let parts = match ty {
        Ty::Float => vec![g.name("float", &format!("snoise({at})"))],
        Ty::Vector3 => vec![g.name("vector", &format!("(vector) snoise({at})"))],
        ty => {
            let most = g.name("vector", &format!("(vector) snoise({at})"));
            let mut parts = vec![format!("{most}[0]"), format!("{most}[1]")];
            if ty == Ty::Vector4 {
                let last = g.name("float", &format!("snoise({other})"));
                parts.extend([format!("{most}[2]"), last]);
            }
            parts
        }
    };
    Value::new(ty, parts)
}
