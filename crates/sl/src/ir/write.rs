// SPDX-License-Identifier: GPL-3.0-or-later
//! Writes the text form, `.oso` version 1.00.
//! The format is OSL's, and its reader takes these files.

use super::flat::Flat;
use super::shader::{Op, Shader, Symbol};
use super::visit::Use;
use crate::format::{escape, general};
use crate::hir::{Data, Meta};
use crate::opcode::Opcode;
use crate::types::{Structs, Type};
use std::fmt::Write as _;

/// The text of a shader. `options` goes into a comment, as OSL's compiler does.
#[must_use]
pub fn write(shader: &Shader, options: &str) -> String {
    let mut out =
        format!("OpenShadingLanguage 1.00\n# Compiled by oslc {}\n# options: {options}\n", crate::VERSION);
    let _ = write!(out, "{} {}", shader.kind, shader.name);
    for meta in &shader.meta {
        out.push('\t');
        metadatum(&mut out, meta, &shader.structs);
    }
    out.push('\n');
    let rows = rows(shader);
    let lives = lives(shader, &rows);
    for (i, symbol) in shader.symbols.iter().enumerate() {
        let (read, written) = lives[i];
        let used = read.is_some() || written.is_some() || symbol.kind.is_param();
        if used || (symbol.ty.struct_id().is_some() && symbol.kind.is_param()) {
            line(&mut out, shader, symbol, lives[i]);
        }
    }
    let mut number = 0;
    for (method, row) in &rows {
        let _ = writeln!(out, "code {method}");
        let mut position = None;
        for flat in row {
            operation(&mut out, shader, &flat.op);
            for jump in &flat.jumps {
                let _ = write!(out, "{} ", jump + number);
            }
            hints(&mut out, shader, &flat.op, &mut position);
        }
        number += row.len();
    }
    out.push_str("\tend\n");
    out
}

type Life = (Option<(usize, usize)>, Option<(usize, usize)>);

/// Code of each default, then the shader's.
fn rows(shader: &Shader) -> Vec<(String, Vec<Flat>)> {
    let mut rows = Vec::new();
    for symbol in shader.symbols.iter().filter(|s| !s.init.is_empty()) {
        let mut row = Vec::new();
        Flat::append(&symbol.init, &mut row);
        rows.push((symbol.name.to_string(), row));
    }
    let mut row = Vec::new();
    Flat::append(&shader.code, &mut row);
    rows.push(("___main___".to_owned(), row));
    rows
}

fn lives(shader: &Shader, rows: &[(String, Vec<Flat>)]) -> Vec<Life> {
    let mut lives: Vec<Life> = vec![(None, None); shader.symbols.len()];
    let widen = |range: &mut Option<(usize, usize)>, from: usize, to: usize| {
        *range = Some(range.map_or((from, to), |(a, b)| (a.min(from), b.max(to))));
    };
    let mut number = 0;
    for (_, row) in rows {
        let mut loops: Vec<(usize, usize)> = Vec::new();
        for (i, flat) in row.iter().enumerate() {
            loops.retain(|&(_, end)| i < end);
            if flat.jumps.len() == 4 {
                loops.push((i, flat.jumps[3]));
            }
            // A symbol used in a loop lives as long as the loop.
            let (from, to) = loops.first().map_or((i, i), |&(a, b)| (a, b));
            for (k, &arg) in flat.op.args.iter().enumerate() {
                let life = &mut lives[arg as usize];
                for (usage, yes) in [(Use::Read, flat.op.is_read(k)), (Use::Write, flat.op.is_written(k))] {
                    if yes {
                        let range = if usage == Use::Read { &mut life.0 } else { &mut life.1 };
                        widen(range, from + number, to + number);
                    }
                }
            }
        }
        number += row.len();
    }
    lives
}

fn values(data: &Data, separator: &str) -> String {
    let items: Vec<String> = match data {
        Data::Int(list) => list.iter().map(ToString::to_string).collect(),
        Data::Float(list) => list.iter().map(|&f| general(f64::from(f), 9)).collect(),
        Data::Str(list) => list.iter().map(|s| format!("\"{}\"", escape(s))).collect(),
    };
    items.join(separator)
}

fn metadatum(out: &mut String, meta: &Meta, structs: &Structs) {
    let _ = write!(out, "%meta{{{},{},{}}} ", meta.ty.display(structs), meta.name, values(&meta.value, ","));
}

/// The one-letter codes of a type.
fn code(ty: Type) -> String {
    let letter = ty.base.letters();
    match ty.array {
        0 => letter,
        n if n < 0 => format!("{letter}[]"),
        n => format!("{letter}[{n}]"),
    }
}

fn line(out: &mut String, shader: &Shader, symbol: &Symbol, life: Life) {
    let _ = write!(out, "{}\t{}\t{}", symbol.kind.keyword(), symbol.ty.display(&shader.structs), symbol.name);
    if let Some(value) = symbol.value.as_ref().filter(|_| symbol.ty.struct_id().is_none()) {
        let _ = write!(out, "\t{}\t", values(value, " "));
    } else if symbol.kind.is_param() {
        out.push_str("\t\t");
    }
    out.push('\t');
    for meta in &symbol.meta {
        metadatum(out, meta, &shader.structs);
    }
    let range = |r: Option<(usize, usize)>| r.map_or("2147483647,-1".to_owned(), |(a, b)| format!("{a},{b}"));
    let _ = write!(out, "%read{{{}}} %write{{{}}}", range(life.0), range(life.1));
    if let Some(spec) = symbol.ty.struct_id().and_then(|id| shader.structs.get(id)) {
        let names: Vec<&str> = spec.fields.iter().map(|f| &*f.name).collect();
        let codes: String = spec.fields.iter().map(|f| code(f.ty)).collect();
        let _ = write!(
            out,
            " %struct{{\"{}\"}} %structfields{{{}}} %structfieldtypes{{\"{codes}\"}} %structnfields{{{}}}",
            spec.name,
            names.join(","),
            names.len()
        );
    }
    if let Some((owner, field)) = symbol.member_of.filter(|_| symbol.kind.is_param()) {
        let _ = write!(out, " %mystruct{{{}}} %mystructfield{{{field}}}", shader.symbol(owner).name);
    }
    if symbol.derivs {
        out.push_str(" %derivs");
    }
    if symbol.kind.is_param() && !symbol.init.is_empty() {
        out.push_str(" %initexpr");
    }
    out.push('\n');
}

fn operation(out: &mut String, shader: &Shader, op: &Op) {
    let name = match op.code {
        Opcode::Unknown => shader.unknown.as_deref().unwrap_or_default(),
        code => code.name(),
    };
    let _ = write!(out, "\t{name}");
    if !op.args.is_empty() {
        out.push_str(if name.len() < 8 { "\t\t" } else { "\t" });
    }
    for &arg in &op.args {
        let _ = write!(out, "{} ", shader.symbol(arg).name);
    }
}

fn hints(out: &mut String, shader: &Shader, op: &Op, position: &mut Option<(u16, u32)>) {
    let mut items = Vec::new();
    if op.at.line > 0 {
        let (file, line) = (op.at.file, op.at.line);
        if position.is_none_or(|p| p.0 != file) {
            let name = shader.files.get(usize::from(file)).map_or("", |f| f);
            items.push(format!("%filename{{\"{name}\"}}"));
        }
        if position.is_none_or(|p| p != (file, line)) {
            items.push(format!("%line{{{line}}}"));
        }
        *position = Some((file, line));
    }
    if !op.args.is_empty() {
        let letters: String = (0..op.args.len())
            .map(|i| match (op.is_written(i), op.is_read(i)) {
                (true, true) => 'W',
                (true, false) => 'w',
                (false, true) => 'r',
                (false, false) => '-',
            })
            .collect();
        items.push(format!("%argrw{{\"{letters}\"}}"));
    }
    if op.derivs != 0 {
        let list: Vec<String> =
            (0..64).filter(|i| op.derivs & (1 << i) != 0).map(|i| i.to_string()).collect();
        items.push(format!("%argderivs{{{}}}", list.join(",")));
    }
    if !items.is_empty() {
        let _ = write!(out, "\t{}", items.join(" "));
    }
    out.push('\n');
}
