// SPDX-License-Identifier: GPL-3.0-or-later
//! Arithmetic, channels, conditionals and colour models.

use crate::error::Error;
use crate::generator::{Call, Generator};
use crate::parts::{each, from_scalars};
use crate::types::{Ty, Value};

/// Functions of one value, `$` for it.
const ONE: [(&str, &str); 18] = [
    ("absval", "abs($)"),
    ("sign", "sign($)"),
    ("floor", "floor($)"),
    ("ceil", "ceil($)"),
    ("round", "round($)"),
    ("fract", "$ - floor($)"),
    ("sin", "sin($)"),
    ("cos", "cos($)"),
    ("tan", "tan($)"),
    ("asin", "asin($)"),
    ("acos", "acos($)"),
    ("sqrt", "sqrt($)"),
    ("ln", "log($)"),
    ("exp", "exp($)"),
    ("not", "!$"),
    ("dot", "$"),
    ("constant", "$"),
    ("convert", "$"),
];

/// Functions of two values.
const TWO: [(&str, &str); 11] = [
    ("add", "$ + %"),
    ("subtract", "$ - %"),
    ("multiply", "$ * %"),
    ("divide", "$ / %"),
    ("modulo", "mod($, %)"),
    ("power", "pow($, %)"),
    ("min", "min($, %)"),
    ("max", "max($, %)"),
    ("atan2", "atan2($, %)"),
    ("and", "$ && %"),
    ("or", "$ || %"),
];

pub(crate) fn emit<'a>(g: &mut Generator<'a>, call: &Call<'a>) -> Result<Option<Vec<String>>, Error> {
    let (node, out) = (call.category().to_owned(), call.out);
    if out.is_closure() || matches!(out, Ty::Matrix33 | Ty::Matrix44 | Ty::Displacement) && !is_choice(&node)
    {
        return Ok(None);
    }
    let find =
        |table: &[(&str, &'static str)]| table.iter().find(|(name, _)| *name == node).map(|(_, form)| *form);
    if let Some(form) = find(&ONE) {
        let value = g.arg(call, if node == "constant" { "value" } else { "in" })?;
        if out.is_text() {
            return Ok(Some(vec![value.first().to_owned()]));
        }
        let to_int = out == Ty::Integer && value.ty == Ty::Float;
        let parts = each(out, &[&value], |a| {
            let made = form.replace('$', a[0]);
            if to_int { format!("(int) {made}") } else { made }
        });
        return Ok(Some(parts));
    }
    if let Some(form) = find(&TWO) {
        let (first, second) = if node == "atan2" { ("iny", "inx") } else { ("in1", "in2") };
        let [a, b] = [g.arg(call, first)?, g.arg(call, second)?];
        // Vectors raised by colours would have no type.
        return Ok(Some(each(out, &[&a, &b], |x| form.replace('$', x[0]).replace('%', x[1]))));
    }
    let parts = match &*node {
        "invert" => {
            let [amount, value] = [g.arg(call, "amount")?, g.arg(call, "in")?];
            each(out, &[&amount, &value], |a| format!("{} - {}", a[0], a[1]))
        }
        "clamp" => {
            let [value, low, high] = [g.arg(call, "in")?, g.arg(call, "low")?, g.arg(call, "high")?];
            each(out, &[&value, &low, &high], |a| format!("max(min({}, {}), {})", a[0], a[2], a[1]))
        }
        "smoothstep" => {
            let [value, low, high] = [g.arg(call, "in")?, g.arg(call, "low")?, g.arg(call, "high")?];
            each(out, &[&value, &low, &high], |a| format!("smoothstep({}, {}, {})", a[1], a[2], a[0]))
        }
        "remap" => {
            let names = ["in", "inlow", "inhigh", "outlow", "outhigh"];
            let args: Vec<Value> = names.iter().map(|name| g.arg(call, name)).collect::<Result<_, _>>()?;
            let args: Vec<&Value> = args.iter().collect();
            each(out, &args, |a| {
                format!("{} + ({} - {}) * ({} - {}) / ({} - {})", a[3], a[0], a[1], a[4], a[3], a[2], a[1])
            })
        }
        "mix" => {
            let [fg, bg, mix] = [g.arg(call, "fg")?, g.arg(call, "bg")?, g.arg(call, "mix")?];
            each(out, &[&bg, &fg, &mix], |a| format!("{} * (1.0 - {}) + {} * {}", a[0], a[2], a[1], a[2]))
        }
        "ramplr" | "ramptb" | "splitlr" | "splittb" => ramp(g, call, &node)?,
        "dotproduct" => {
            let [a, b] = [g.arg(call, "in1")?, g.arg(call, "in2")?];
            vec![dot(&a, &b)]
        }
        "magnitude" => {
            let a = g.arg(call, "in")?;
            vec![format!("sqrt({})", dot(&a, &a))]
        }
        "normalize" => {
            let a = g.arg(call, "in")?;
            if out == Ty::Vector3 {
                vec![format!("normalize({})", a.first())]
            } else {
                let length = g.name("float", &format!("sqrt({})", dot(&a, &a)));
                each(out, &[&a], |a| format!("({length} > 0 ? {} / {length} : 0.0)", a[0]))
            }
        }
        "crossproduct" => {
            let [a, b] = [g.arg(call, "in1")?, g.arg(call, "in2")?];
            vec![format!("cross({}, {})", a.first(), b.first())]
        }
        "rotate2d" => {
            let [value, amount] = [g.arg(call, "in")?, g.arg(call, "amount")?];
            let [x, y] = [&value.parts[0], &value.parts[1]];
            let angle = g.name("float", &format!("radians({})", amount.first()));
            let [c, s] =
                [g.name("float", &format!("cos({angle})")), g.name("float", &format!("sin({angle})"))];
            vec![format!("{c} * {x} + {s} * {y}"), format!("{c} * {y} - {s} * {x}")]
        }
        "rotate3d" => {
            let [value, amount, axis] = [g.arg(call, "in")?, g.arg(call, "amount")?, g.arg(call, "axis")?];
            g.needs("gnurt_turned");
            vec![format!("gnurt_turned({}, {}, {})", value.first(), amount.first(), axis.first())]
        }
        "combine2" | "combine3" | "combine4" => {
            let mut n = Vec::new();
            for name in ["in1", "in2", "in3", "in4"] {
                if g.known.input(call.def, name).is_some() {
                    n.extend(g.arg(call, name)?.scalars());
                }
            }
            from_scalars(out, &n)
        }
        "extract" => {
            let [value, index] = [g.arg(call, "in")?, g.arg(call, "index")?];
            if matches!(value.ty, Ty::Matrix33 | Ty::Matrix44) {
                return Ok(None);
            }
            let (n, index) = (value.scalars(), index.first().to_owned());
            match index.parse::<usize>() {
                Ok(i) => vec![n[i.min(n.len() - 1)].clone()],
                // Parameters are known to the compiler, which drops the choice.
                Err(_) => vec![chosen(&n, &index)],
            }
        }
        "ifgreater" | "ifgreatereq" | "ifequal" => {
            // Without values the comparison is the result.
            let names: &[&str] = match g.known.input(call.def, "in1") {
                Some(_) => &["value1", "value2", "in1", "in2"],
                None => &["value1", "value2"],
            };
            let args: Vec<Value> = names.iter().map(|name| g.arg(call, name)).collect::<Result<_, _>>()?;
            let sign = match &*node {
                "ifgreater" => ">",
                "ifgreatereq" => ">=",
                _ => "==",
            };
            let test = g.name("int", &format!("{} {sign} {}", args[0].first(), args[1].first()));
            match &args[2..] {
                [yes, no] => each(out, &[yes, no], |a| format!("({test} ? {} : {})", a[0], a[1])),
                _ => vec![test],
            }
        }
        "luminance" => {
            let [value, weights] = [g.arg(call, "in")?, g.arg(call, "lumacoeffs")?];
            let [color, weights] = [value.scalars(), weights.scalars()];
            let sum =
                (0..3).map(|i| format!("{} * {}", color[i], weights[i])).collect::<Vec<_>>().join(" + ");
            let mut parts = vec![format!("color({sum})")];
            parts.extend(value.parts.get(1).cloned());
            parts
        }
        "rgbtohsv" | "hsvtorgb" => {
            let value = g.arg(call, "in")?;
            let (from, to) = if node == "rgbtohsv" { ("rgb", "hsv") } else { ("hsv", "rgb") };
            let mut parts = vec![format!("transformc(\"{from}\", \"{to}\", {})", value.first())];
            parts.extend(value.parts.get(1).cloned());
            parts
        }
        _ => return Ok(None),
    };
    Ok(Some(parts))
}

/// Nodes that pass one of their inputs on, of any type.
fn is_choice(node: &str) -> bool {
    matches!(node, "ifgreater" | "ifgreatereq" | "ifequal" | "dot" | "constant")
}

/// One of several by an index.
fn chosen(n: &[String], index: &str) -> String {
    let mut out = n[n.len() - 1].clone();
    for (i, number) in n.iter().enumerate().rev().skip(1) {
        out = format!("({index} <= {i} ? {number} : {out})");
    }
    out
}

/// The inner product.
pub(crate) fn dot(a: &Value, b: &Value) -> String {
    if a.ty == Ty::Vector3 {
        return format!("dot({}, {})", a.first(), b.first());
    }
    let both = a.scalars().into_iter().zip(b.scalars());
    both.map(|(a, b)| format!("{a} * {b}")).collect::<Vec<_>>().join(" + ")
}

/// Ramps and splits along a texture coordinate.
fn ramp<'a>(g: &mut Generator<'a>, call: &Call<'a>, node: &str) -> Result<Vec<String>, Error> {
    let is_across = node.ends_with("lr");
    let (low, high) = if is_across { ("valuel", "valuer") } else { ("valueb", "valuet") };
    let [low, high, at] = [g.arg(call, low)?, g.arg(call, high)?, g.arg(call, "texcoord")?];
    let at = at.parts[usize::from(!is_across)].clone();
    let share = if node.starts_with("ramp") {
        g.name("float", &format!("clamp({at}, 0.0, 1.0)"))
    } else {
        let center = g.arg(call, "center")?;
        g.needs("gnurt_edge");
        g.name("float", &format!("gnurt_edge({}, {at})", center.first()))
    };
    let share = Value::new(Ty::Float, vec![share]);
    Ok(each(call.out, &[&low, &high, &share], |a| {
        format!("{} * (1.0 - {}) + {} * {}", a[0], a[2], a[1], a[2])
    }))
}
