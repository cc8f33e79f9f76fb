// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures, tiled by hexagons too [Mik22].

use crate::error::Error;
use crate::generator::{Call, Generator, is_linear};
use crate::parts::from_scalars;
use crate::types::{Ty, Value, quoted};

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    match call.category() {
        "image" => image(g, call).map(Some),
        "hextiledimage" | "hextilednormalmap" => hextiled(g, call).map(Some),
        _ => Ok(None),
    }
}

/// The colour space that the language decodes, and the one that a graph decodes after it.
fn decoded(file: &Value, ty: Ty) -> (&'static str, Option<String>) {
    match file.color_space.as_deref().filter(|_| ty.is_color()) {
        Some("srgb_texture") => ("srgb", None),
        Some(space) if !is_linear(space) => ("raw", Some(space.to_owned())),
        _ => ("raw", None),
    }
}

/// Whether a file's name stands for tiles, a file each.
fn is_tiled(file: &str) -> bool {
    ["<UDIM>", "<UVTILE>"].iter().any(|pattern| file.contains(pattern))
}

fn image<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Vec<String>, Error> {
    let [file, default, at] = [g.arg(call, "file")?, g.arg(call, "default")?, g.arg(call, "texcoord")?];
    if file.text.as_deref().is_some_and(str::is_empty) {
        return Ok(default.parts);
    }
    let is_tiled = file.text.as_deref().is_some_and(is_tiled);
    let (u, v) = (g.name("float", &at.parts[0]), g.name("float", &at.parts[1]));
    let mut options = String::new();
    let mut outside = Vec::new();
    for (name, wrap, at) in [("uaddressmode", "swrap", &u), ("vaddressmode", "twrap", &v)] {
        let mode = g.word(call, name)?;
        let is_constant = mode == "constant";
        if is_constant && !is_tiled {
            outside.push(format!("{at} < 0 || {at} > 1"));
        }
        let mode = if is_constant { "clamp" } else { &mode };
        options.push_str(&format!(", \"{wrap}\", {}", quoted(mode)));
    }
    let filter = g.word(call, "filtertype")?;
    options.push_str(&format!(", \"interp\", {}", quoted(&filter)));
    let layer = g.word(call, "layer")?;
    if !layer.is_empty() {
        options.push_str(&format!(", \"subimage\", {}", quoted(&layer)));
    }
    if !g.word(call, "framerange")?.is_empty() {
        g.warn(call, "the frames of a picture are left out");
    }
    let (space, then) = decoded(&file, call.out);
    options.push_str(&format!(", \"colorspace\", \"{space}\""));
    let n = default.scalars();
    let has_alpha = matches!(call.out, Ty::Color4 | Ty::Vector4);
    let mut missing = n.clone();
    while missing.len() < 3 {
        missing.push(missing[0].clone());
    }
    options.push_str(&format!(", \"missingcolor\", color({})", missing[..3].join(", ")));
    let mut alpha = None;
    if has_alpha {
        options.push_str(&format!(", \"missingalpha\", {}", n[3]));
        let name = g.name("float", "1");
        options.push_str(&format!(", \"alpha\", {name}"));
        alpha = Some(name);
    }
    // Tiles are numbered upwards; the language reads each downwards.
    let t = if is_tiled { format!("2 * floor({v}) + 1 - {v}") } else { format!("1 - {v}") };
    let found = g.name("color", &format!("(color) texture({}, {u}, {t}{options})", file.first()));
    if !outside.is_empty() {
        g.body.push_str(&format!(
            "    if ({}) {{ {found} = color({});",
            outside.join(" || "),
            missing[..3].join(", ")
        ));
        if let Some(alpha) = &alpha {
            g.body.push_str(&format!(" {alpha} = {};", n[3]));
        }
        g.body.push_str(" }\n");
    }
    let parts = match call.out {
        Ty::Color3 => vec![found],
        Ty::Color4 => vec![found, alpha.unwrap_or_default()],
        Ty::Float => vec![format!("{found}[0]")],
        out => {
            let mut n: Vec<String> = (0..3).map(|i| format!("{found}[{i}]")).collect();
            n.extend(alpha);
            n.truncate(if out == Ty::Vector2 { 2 } else { 4 });
            from_scalars(out, &n)
        }
    };
    match then {
        Some(space) => Ok(g.in_linear(call.scope, call.node, Value::new(call.out, parts), &space)?.parts),
        None => Ok(parts),
    }
}

fn hextiled<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Vec<String>, Error> {
    let is_normal = call.category() == "hextilednormalmap";
    let [file, default, at] = [g.arg(call, "file")?, g.arg(call, "default")?, g.arg(call, "texcoord")?];
    let file_is_empty = file.text.as_deref().is_some_and(str::is_empty);
    if file_is_empty && !is_normal {
        return Ok(default.parts);
    }
    let names =
        ["tiling", "rotation", "rotationrange", "scale", "scalerange", "offset", "offsetrange", "falloff"];
    let args: Vec<Value> = names.iter().map(|name| g.arg(call, name)).collect::<Result<_, _>>()?;
    let (space, then) = decoded(&file, call.out);
    let contrast =
        if is_normal { "0.5".to_owned() } else { g.arg(call, "falloffcontrast")?.first().to_owned() };
    let weights =
        if is_normal { "color(1)".to_owned() } else { g.arg(call, "lumacoeffs")?.first().to_owned() };
    let (u, v) = (&at.parts[0], &at.parts[1]);
    let numbers: Vec<&str> = args.iter().flat_map(|arg| arg.parts.iter().map(|part| &**part)).collect();
    g.needs("gnurt_hextiled");
    let alpha = g.name("float", "1");
    let call_text = format!(
        "gnurt_hextiled({}, \"{space}\", {u}, {v}, {}, {contrast}, {weights}, {}, {alpha})",
        file.first(),
        numbers.join(", "),
        i32::from(is_normal)
    );
    let found = match file_is_empty {
        true => format!("color({})", default.first()),
        false => g.name("color", &call_text),
    };
    if is_normal {
        let names = ["strength", "flip_g", "normal", "tangent", "bitangent"];
        let a: Vec<Value> = names.iter().map(|name| g.arg(call, name)).collect::<Result<_, _>>()?;
        let flipped = g.name("color", &found);
        g.body.push_str(&format!("    if ({}) {flipped}[1] = 1 - {flipped}[1];\n", a[1].first()));
        g.needs("gnurt_mapped_normal");
        let [strength, n, t, b] = [0, 2, 3, 4].map(|i: usize| a[i].first());
        return Ok(vec![format!(
            "gnurt_mapped_normal(vector({flipped}), {strength}, {strength}, {n}, {t}, {b})"
        )]);
    }
    let parts = if call.out == Ty::Color4 { vec![found, alpha] } else { vec![found] };
    match then {
        Some(space) => Ok(g.in_linear(call.scope, call.node, Value::new(call.out, parts), &space)?.parts),
        None => Ok(parts),
    }
}
