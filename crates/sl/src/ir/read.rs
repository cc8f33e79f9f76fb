// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads the text form, `.oso`, as OSL's compiler and ours write it.
//! The format is OSL's.
//! Invariant: no text makes it panic or take memory out of proportion to its length; its results pass
//! [`verify`].

use super::flat::Flat;
use super::shader::{Op, Shader, SourcePosition, SymId, Symbol, SymbolKind};
use super::tokens::{TextToken, line_tokens, parts};
use super::verify::verify;
use crate::hir::{Data, Meta};
use crate::opcode::Opcode;
use crate::parse::unescape;
use crate::types::{Base, Field, Struct, Type};
use std::collections::HashMap;
use std::sync::Arc;

/// A shader from its text.
///
/// # Errors
/// The line and the fault.
pub fn read(text: &str) -> Result<Shader, String> {
    let mut reader = Reader::default();
    let mut head = false;
    for (i, line) in text.lines().enumerate() {
        if line.starts_with("%preprocessed_source") {
            break;
        }
        let list = line_tokens(line);
        if list.is_empty() {
            continue;
        }
        let done = if head { reader.line(&list) } else { reader.head(&list, &mut head) };
        done.map_err(|message| format!("line {}: {message}", i + 1))?;
    }
    if !head || reader.shader.name.is_empty() {
        return Err(
            "not an .oso file: it starts with 'OpenShadingLanguage 1.00' and a shader's type and name".into(),
        );
    }
    reader.finish()
}

#[derive(Default)]
struct Reader {
    shader: Shader,
    names: HashMap<Arc<str>, SymId>,
    structs: HashMap<String, u16>,
    files: HashMap<String, u16>,
    rows: Vec<(String, Vec<Flat>)>,
    ops: usize,
    in_code: bool,
    source_position: SourcePosition,
}

fn plain(line_tokens: &[TextToken], i: usize) -> Result<&str, String> {
    match line_tokens.get(i) {
        Some(TextToken::Plain(keyword)) => Ok(keyword),
        _ => Err(format!("word {} is missing", i + 1)),
    }
}

impl Reader {
    fn head(&mut self, list: &[TextToken], head: &mut bool) -> Result<(), String> {
        let first = plain(list, 0)?;
        if first == "OpenShadingLanguage" {
            let version = plain(list, 1)?;
            let major = version.split('.').next().and_then(|m| m.parse::<u32>().ok());
            return if major == Some(1) {
                Ok(())
            } else {
                Err(format!("unsupported version {version}; 1.00 is valid"))
            };
        }
        if !matches!(
            first,
            "surface" | "displacement" | "volume" | "shader" | "light" | "camera" | "environment" | "pixel"
        ) {
            return Err(format!("'{first}' is not a type of shader"));
        }
        self.shader.kind = first.into();
        self.shader.name = match list.get(1) {
            Some(TextToken::Plain(name) | TextToken::Text(name)) => name.as_str().into(),
            _ => return Err("the shader's name is missing".into()),
        };
        for keyword in list {
            if let TextToken::Hint(name, inner) = keyword
                && name == "meta"
            {
                self.shader.meta.extend(metadatum(inner));
            }
        }
        *head = true;
        Ok(())
    }

    fn line(&mut self, list: &[TextToken]) -> Result<(), String> {
        let first = plain(list, 0)?;
        if first == "code" {
            self.in_code = true;
            self.rows.push((plain(list, 1)?.to_owned(), Vec::new()));
            self.source_position = SourcePosition::default();
            return Ok(());
        }
        if !self.in_code {
            return self.symbol(list);
        }
        if first == "end" {
            return Ok(());
        }
        self.operation(list)
    }

    fn ty(&mut self, list: &[TextToken], at: &mut usize) -> Result<Type, String> {
        let mut keyword = plain(list, *at)?.to_owned();
        *at += 1;
        if keyword == "closure" {
            keyword = plain(list, *at)?.to_owned();
            *at += 1;
            let (_, array) = length(&keyword)?;
            return Ok(Type::CLOSURE.array_of(array));
        }
        if keyword == "struct" {
            keyword = plain(list, *at)?.to_owned();
            *at += 1;
            let (name, array) = length(&keyword)?;
            return Ok(Type::of(Base::Struct(self.structure(name))).array_of(array));
        }
        let (name, array) = length(&keyword)?;
        let base = Base::from_keyword(name)
            .filter(|b| *b != Base::Void)
            .ok_or_else(|| format!("'{name}' is not a type"))?;
        Ok(Type::of(base).array_of(array))
    }

    fn structure(&mut self, name: &str) -> u16 {
        if let Some(&found) = self.structs.get(name) {
            return found;
        }
        let number = self.shader.structs.0.len().min(usize::from(u16::MAX) - 1) as u16;
        if usize::from(number) == self.shader.structs.0.len() {
            self.shader.structs.0.push(Struct { name: name.to_owned(), scope: 0, fields: Vec::new() });
            self.structs.insert(name.to_owned(), number);
        }
        number
    }

    fn symbol(&mut self, list: &[TextToken]) -> Result<(), String> {
        let keyword = plain(list, 0)?;
        let kind = SymbolKind::from_keyword(keyword)
            .ok_or_else(|| format!("'{keyword}' is not a kind of symbol"))?;
        let mut at = 1;
        let ty = self.ty(list, &mut at)?;
        let name: Arc<str> = plain(list, at)?.into();
        at += 1;
        let mut symbol = Symbol::new(name.clone(), kind, ty);
        let literals: Vec<&TextToken> =
            list[at..].iter().take_while(|w| !matches!(w, TextToken::Hint(..))).collect();
        if ty.struct_id().is_none() && (kind.is_param() || kind == SymbolKind::Const) {
            symbol.value = Some(literal(ty, &literals)?);
        }
        for keyword in &list[at..] {
            let TextToken::Hint(hint, inner) = keyword else { continue };
            match hint.as_str() {
                "meta" => symbol.meta.extend(metadatum(inner)),
                "derivs" => symbol.derivs = true,
                "mystruct" => {
                    if let Some(&owner) = self.names.get(inner.as_str()) {
                        symbol.member_of = Some((owner, 0));
                    }
                }
                "mystructfield" => {
                    if let Some(member) = &mut symbol.member_of {
                        member.1 = inner.parse().unwrap_or(0);
                    }
                }
                "structfields" => self.fields(ty, &parts(inner)),
                "structfieldtypes" => self.field_types(ty, inner.trim_matches('"')),
                _ => {}
            }
        }
        let id = self.shader.symbols.len() as SymId;
        self.shader.symbols.push(symbol);
        self.names.insert(name, id);
        Ok(())
    }

    fn fields(&mut self, ty: Type, names: &[String]) {
        let Some(spec) = ty.struct_id().and_then(|id| self.shader.structs.0.get_mut(usize::from(id))) else {
            return;
        };
        if spec.fields.is_empty() {
            spec.fields = names.iter().map(|n| Field { name: n.clone(), ty: Type::UNKNOWN }).collect();
        }
    }

    fn field_types(&mut self, ty: Type, codes: &str) {
        let Some(spec) = ty.struct_id().and_then(|id| self.shader.structs.0.get_mut(usize::from(id))) else {
            return;
        };
        let mut rest = codes.chars().peekable();
        for field in &mut spec.fields {
            let letter = rest.next().unwrap_or('x');
            if letter == 'S' {
                while rest.next_if(char::is_ascii_digit).is_some() {}
            }
            let base =
                Some(Base::of_letter(letter)).filter(|&base| base != Base::Void).unwrap_or(Base::Unknown);
            let mut array = 0;
            if rest.next_if_eq(&'[').is_some() {
                let mut digits = String::new();
                while let Some(c) = rest.next_if(char::is_ascii_digit) {
                    digits.push(c);
                }
                rest.next_if_eq(&']');
                array = digits.parse().unwrap_or(-1);
            }
            field.ty = Type::of(base).array_of(array);
        }
    }

    fn operation(&mut self, list: &[TextToken]) -> Result<(), String> {
        let name = plain(list, 0)?;
        let code = Opcode::named(name);
        if code == Opcode::Unknown {
            self.shader.unknown.get_or_insert_with(|| name.into());
        }
        let (mut args, mut jumps) = (Vec::new(), Vec::new());
        for keyword in &list[1..] {
            let TextToken::Plain(keyword) = keyword else { continue };
            match self.names.get(keyword.as_str()) {
                Some(&id) => args.push(id),
                None => match keyword.parse::<usize>() {
                    Ok(jump) => jumps.push(jump),
                    Err(_) => return Err(format!("{name}: no symbol '{keyword}'")),
                },
            }
        }
        let mut op = Op { code, args, reads: !1, writes: 1, derivs: 0, at: self.source_position };
        for keyword in list {
            let TextToken::Hint(hint, inner) = keyword else { continue };
            match hint.as_str() {
                "filename" => op.at.file = self.file(inner.trim_matches('"')),
                "line" => op.at.line = inner.parse().unwrap_or(0),
                "argrw" => {
                    (op.reads, op.writes) = (0, 0);
                    for (i, c) in inner.trim_matches('"').chars().enumerate().take(64) {
                        op.reads |= u64::from(matches!(c, 'r' | 'W')) << i;
                        op.writes |= u64::from(matches!(c, 'w' | 'W')) << i;
                    }
                }
                "argderivs" => {
                    let numbers = inner.split(',').filter_map(|n| n.trim().parse::<u32>().ok());
                    op.derivs = numbers.filter(|&n| n < 64).fold(0, |bits, n| bits | 1 << n);
                }
                _ => {}
            }
        }
        self.source_position = op.at;
        let Some((_, row)) = self.rows.last_mut() else { return Err("an operation before 'code'".into()) };
        let start = self.ops - row.len();
        let jumps = jumps.into_iter().map(|j| j.checked_sub(start)).collect::<Option<Vec<_>>>();
        row.push(Flat { op, jumps: jumps.ok_or("a jump out of the block")? });
        self.ops += 1;
        Ok(())
    }

    fn file(&mut self, name: &str) -> u16 {
        if let Some(&found) = self.files.get(name) {
            return found;
        }
        let number = self.shader.files.len().min(usize::from(u16::MAX)) as u16;
        self.shader.files.push(name.into());
        self.files.insert(name.to_owned(), number);
        number
    }

    fn finish(mut self) -> Result<Shader, String> {
        for (method, row) in std::mem::take(&mut self.rows) {
            let block = Flat::nest(&row, 0, row.len(), 0).map_err(|e| format!("code {method}: {e}"))?;
            if method == "___main___" {
                self.shader.code.extend(block);
            } else {
                let id = *self
                    .names
                    .get(method.as_str())
                    .ok_or_else(|| format!("code {method}: no such symbol"))?;
                self.shader.symbols[id as usize].init.extend(block);
            }
        }
        verify(&self.shader)?;
        Ok(self.shader)
    }
}

/// `name[3]`, `name[]`, `name`
fn length(keyword: &str) -> Result<(&str, i32), String> {
    let Some((name, rest)) = keyword.split_once('[') else { return Ok((keyword, 0)) };
    let inner = rest.strip_suffix(']').ok_or_else(|| format!("'{keyword}': ']' is missing"))?;
    if inner.is_empty() {
        return Ok((name, -1));
    }
    let length = inner.parse::<i32>().ok().filter(|&n| n > 0);
    length.map(|n| (name, n)).ok_or_else(|| format!("'{inner}' is not an array's length"))
}

fn literal(ty: Type, line_tokens: &[&TextToken]) -> Result<Data, String> {
    let number = |w: &&TextToken| match w {
        TextToken::Plain(text) => text.parse::<f32>().map_err(|_| format!("'{text}' is not a number")),
        _ => Err("a number is missing".to_owned()),
    };
    Ok(match ty.base {
        Base::String => Data::Str(
            line_tokens
                .iter()
                .map(|w| match w {
                    TextToken::Text(text) => Ok(text.as_str().into()),
                    _ => Err("a text in quotes is missing".to_owned()),
                })
                .collect::<Result<_, String>>()?,
        ),
        Base::Int => Data::Int(
            line_tokens
                .iter()
                .map(|w| match w {
                    TextToken::Plain(text) => text
                        .parse::<i64>()
                        .map(|v| v as i32)
                        .map_err(|_| format!("'{text}' is not an integer")),
                    _ => Err("an integer is missing".to_owned()),
                })
                .collect::<Result<_, String>>()?,
        ),
        base if base.is_float_based() => {
            Data::Float(line_tokens.iter().map(number).collect::<Result<_, String>>()?)
        }
        // The black closure, which is a 0.
        Base::Closure => Data::Int(vec![0; line_tokens.len()]),
        _ => Data::Int(Vec::new()),
    })
}

fn metadatum(inner: &str) -> Option<Meta> {
    let list = parts(inner);
    let (name, array) = length(list.first()?.trim()).ok()?;
    let base = Base::from_keyword(name)?;
    let ty = Type::of(base).array_of(array);
    let rest = list.get(2..)?;
    let value = match base {
        Base::String => Data::Str(rest.iter().map(|t| unescape(t.trim()).into()).collect()),
        Base::Int => Data::Int(rest.iter().map(|t| t.trim().parse().unwrap_or(0)).collect()),
        _ => Data::Float(rest.iter().map(|t| t.trim().parse().unwrap_or(0.0)).collect()),
    };
    Some(Meta { ty, name: list.get(1)?.trim().into(), value })
}
