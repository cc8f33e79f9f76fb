// SPDX-License-Identifier: GPL-3.0-or-later
//! `printf` and its kin.
//! The words before messages are OSL's.

use super::machine::{Event, Machine, Step};
use super::slot::Slot;
use crate::hir::Data;
use crate::opcode::Opcode;
use crate::types::Base;
use gnurt_sl_lib::text::{Argument, Format};

/// Bytes of the closures of an array, as texts.
const LONGEST: usize = 1 << 20;

enum Owned {
    Ints(Vec<i32>),
    Floats(Vec<f32>),
    Texts(Vec<String>),
}

fn argument(m: &Machine<'_>, slot: &Slot) -> Owned {
    if slot.ty.base == Base::Closure {
        let mut left = LONGEST;
        let texts = (0..slot.size as usize).map(|i| {
            let text = if left == 0 { String::new() } else { m.closure_text(m.cell_bits(slot, i)) };
            left = left.saturating_sub(text.len());
            text
        });
        return Owned::Texts(texts.collect());
    }
    match m.data(slot) {
        Data::Int(list) => Owned::Ints(list),
        Data::Float(list) => Owned::Floats(list),
        Data::Str(list) => Owned::Texts(list.iter().map(|s| s.to_string()).collect()),
    }
}

fn filled(m: &Machine<'_>, format: &str, args: &[Slot]) -> Result<String, String> {
    let owned: Vec<Owned> = args.iter().map(|a| argument(m, a)).collect();
    let texts: Vec<Vec<&str>> = owned
        .iter()
        .map(|o| match o {
            Owned::Texts(list) => list.iter().map(String::as_str).collect(),
            _ => Vec::new(),
        })
        .collect();
    let args: Vec<Argument<'_>> = owned
        .iter()
        .zip(&texts)
        .map(|(o, texts)| match o {
            Owned::Ints(list) => Argument::Ints(list),
            Owned::Floats(list) => Argument::Floats(list),
            Owned::Texts(_) => Argument::Strings(texts),
        })
        .collect();
    Format::new(format).fill(&args).map_err(|e| e.to_string())
}

pub(super) fn print(m: &mut Machine<'_>, s: &Step) {
    let head = usize::from(matches!(s.code, Opcode::Format | Opcode::Fprintf));
    let (Some(format), Some(args)) = (s.args.get(head), s.args.get(head + 1..)) else { return };
    let format = m.text(format);
    let text = match filled(m, &format, args) {
        Ok(text) => text,
        Err(message) => {
            let source_position = m.source_position(s.at);
            m.error(format!("{message} at {source_position}"));
            return;
        }
    };
    if s.code == Opcode::Format {
        m.set_text(&s.args[0], 0, &text);
        return;
    }
    let (_, shader) = m.layer_names();
    let event = match s.code {
        Opcode::Error => Event::Error(format!("Shader error [{shader}]: {text}")),
        Opcode::Warning => Event::Warning(format!("Shader warning [{shader}]: {text}")),
        Opcode::Fprintf => Event::File(m.text(&s.args[0]).to_string(), text),
        _ => Event::Print(text),
    };
    m.report(event);
}
