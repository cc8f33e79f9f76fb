// SPDX-License-Identifier: GPL-3.0-or-later
//! Positions, directions, texture coordinates and attributes of meshes, spaces, time, and normals from heights and maps.

use crate::error::Error;
use crate::generator::{Call, Generator};
use crate::parts::from_scalars;
use crate::types::{Ty, Value, quoted};

/// A geometric property by its kind, space and index.
pub(crate) fn property(
    g: &mut Generator<'_>,
    ty: Ty,
    kind: &str,
    space: &str,
    index: &str,
) -> Result<Value, String> {
    let is_own = matches!(space, "object" | "model" | "");
    let parts = match kind {
        "position" if is_own => vec![g.name("vector", "vector(transform(\"object\", P))")],
        "position" => vec![g.name("vector", "vector(P)")],
        "normal" if is_own => vec![g.name("vector", "normalize(vector(transform(\"object\", N)))")],
        "normal" => vec![g.name("vector", "vector(N)")],
        "tangent" | "bitangent" => {
            let along = if kind == "tangent" { "dPdu" } else { "dPdv" };
            let along = if is_own { format!("transform(\"object\", {along})") } else { along.to_owned() };
            vec![g.name("vector", &format!("normalize({along})"))]
        }
        "texcoord" => texcoord(g, ty, index),
        "viewdirection" if is_own => vec![g.name("vector", "normalize(transform(\"object\", I))")],
        "viewdirection" => vec![g.name("vector", "normalize(I)")],
        _ => return Err(format!("unknown geometric property '{kind}'")),
    };
    Ok(Value::new(ty, parts))
}

/// Texture coordinates of a set.
fn texcoord(g: &mut Generator<'_>, ty: Ty, index: &str) -> Vec<String> {
    let [u, v] = if index == "0" {
        ["u".to_owned(), "v".to_owned()]
    } else {
        // Meshes without the set have the first one.
        let set = g.name("float", "u");
        let set = [set, g.name("float", "v")];
        let both = g.list(2, "");
        g.body.push_str(&format!(
            "    if (getattribute({}, {both})) {{ {} = {both}[0]; {} = {both}[1]; }}\n",
            quoted(&format!("uv{index}")),
            set[0],
            set[1]
        ));
        set
    };
    match ty {
        Ty::Vector3 => vec![g.name("vector", &format!("vector({u}, {v}, 0)"))],
        _ => vec![u, v],
    }
}

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let node = call.category().to_owned();
    let parts = match &*node {
        "position" | "normal" | "tangent" | "bitangent" | "viewdirection" => {
            let space = g.word(call, "space")?;
            let made = property(g, call.out, &node, &space, "0");
            made.map_err(|why| g.fault(call.scope, call.node, why))?.parts
        }
        "texcoord" => {
            let index = index(g, call)?;
            texcoord(g, call.out, &index)
        }
        "geomcolor" => {
            let index = index(g, call)?;
            let (color, alpha) = match &*index {
                "0" => ("color".to_owned(), "alpha".to_owned()),
                index => (format!("color{index}"), format!("alpha{index}")),
            };
            let [found, opacity] = [g.name("color", "0"), g.name("float", "0")];
            // A colour without opacity is opaque.
            g.body.push_str(&format!("    {opacity} = getattribute({}, {found});\n", quoted(&color)));
            match call.out {
                Ty::Float => vec![format!("{found}[0]")],
                Ty::Color4 => {
                    g.body.push_str(&format!("    getattribute({}, {opacity});\n", quoted(&alpha)));
                    vec![found, opacity]
                }
                _ => vec![found],
            }
        }
        "geompropvalue" | "geompropvalueuniform" => attribute(g, call)?,
        "time" => vec!["time".to_owned()],
        "frame" => {
            let frame = g.name("float", "1");
            g.body
                .push_str(&format!("    if (!getattribute(\"frame\", {frame})) {frame} = 1 + time * 24;\n"));
            vec![frame]
        }
        "transformpoint" | "transformvector" | "transformnormal" => {
            let [value, from, to] = [g.arg(call, "in")?, g.arg(call, "fromspace")?, g.arg(call, "tospace")?];
            let kind = &node["transform".len()..];
            let space = |value: Value| match value.text.as_deref() {
                Some("" | "world") => "\"world\"".to_owned(),
                Some("model") => "\"object\"".to_owned(),
                _ => value.first().to_owned(),
            };
            let (from, to) = (space(from), space(to));
            vec![format!("vector(transform({from}, {to}, {kind}({})))", value.first())]
        }
        "heighttonormal" => {
            let [height, scale, at] = [g.arg(call, "in")?, g.arg(call, "scale")?, g.arg(call, "texcoord")?];
            g.needs("gnurt_height_to_normal");
            let height = g.name("float", height.first());
            let at = [0, 1].map(|i: usize| at.parts[i].clone()).map(|x| g.name("float", &x));
            vec![format!("gnurt_height_to_normal({height}, {}, {}, {})", scale.first(), at[0], at[1])]
        }
        "normalmap" => {
            let names = ["in", "scale", "normal", "tangent", "bitangent"];
            let args: Vec<Value> = names.iter().map(|name| g.arg(call, name)).collect::<Result<_, _>>()?;
            let scale = &args[1].parts;
            g.needs("gnurt_mapped_normal");
            let [n, t, b] = [2, 3, 4].map(|i: usize| args[i].first());
            vec![format!(
                "gnurt_mapped_normal({}, {}, {}, {n}, {t}, {b})",
                args[0].first(),
                scale[0],
                scale[scale.len() - 1]
            )]
        }
        _ => return Ok(None),
    };
    Ok(Some(parts))
}

/// The number of a set.
fn index<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<String, Error> {
    let value = g.arg(call, "index")?;
    let text = value.text.clone().unwrap_or_else(|| value.first().to_owned());
    match text.parse::<u32>() {
        Ok(index) => Ok(index.to_string()),
        Err(_) => Err(g.fault(call.scope, call.node, "'index' is not a fixed number")),
    }
}

/// An attribute of the mesh, or its default.
fn attribute<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Vec<String>, Error> {
    let (name, default) = (g.word(call, "geomprop")?, g.arg(call, "default")?);
    let name = quoted(&name);
    let kinds = call.out.parts();
    if kinds.len() == 1 {
        let found = g.name(kinds[0], default.first());
        g.body.push_str(&format!("    getattribute({name}, {found});\n"));
        return Ok(vec![found]);
    }
    let n = default.scalars();
    let list = g.list(n.len(), &n.join(", "));
    g.body.push_str(&format!("    getattribute({name}, {list});\n"));
    Ok(from_scalars(call.out, &(0..n.len()).map(|i| format!("{list}[{i}]")).collect::<Vec<_>>()))
}
