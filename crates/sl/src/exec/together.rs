// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations that only a host can answer, done for many points of a batch at once: for code that has all of them at hand.
//! Source: original.
//! Invariant: every point gets what the interpreter gives it by itself. Where that is not sure (texts that differ from point to point,
//! something that is to be said) nothing is done, and the caller goes point by point. Proof: crates/jit/tests/batches.rs.

use super::batch::Points;
use super::cells::{Batch, Cells, LANES};
use super::machine::{Machine, Step};
use super::slot::Slot;
use super::texture;
use crate::types::{Base, Type};

/// Whether [`Machine::together`] may do an operation.
#[must_use]
pub fn asks_together(step: &Step) -> bool {
    let out = step.args.first().map_or(Type::VOID, |out| out.ty);
    match (&*step.name, step.args.len()) {
        ("raytype", 2) | ("backfacing" | "surfacearea", 1) => {
            matches!(out, Type::INT | Type::FLOAT) && step.writes == 1
        }
        ("texture", 4..) => out.base.is_float_based() && !out.is_array(),
        _ => false,
    }
}

impl Machine<'_> {
    /// Does an operation for the points of a batch that `lanes` names. False if it must be done one point after the other; nothing is done
    /// then.
    pub fn together(&mut self, step: &Step, lanes: u32, points: &Points, batch: &mut dyn Batch) -> bool {
        match (&*step.name, &*step.args) {
            ("raytype", [out, name]) => {
                let Cells::One(text) = batch.get(name.at) else { return false };
                let bit =
                    if name.ty == Type::STRING { self.host.ray_kind(self.strings.text(text)) } else { 0 };
                put_bits(batch, out, lanes, points.ray_kinds.map(|kinds| kinds & bit != 0));
            }
            ("backfacing", [out]) => {
                put_bits(batch, out, lanes, std::array::from_fn(|lane| points.backfacing >> lane & 1 != 0));
            }
            ("surfacearea", [out]) => {
                let area = points.surface_area;
                let is_int = out.ty.base == Base::Int;
                put(batch, out, lanes, &area.map(|x| if is_int { x as i32 as u32 } else { x.to_bits() }));
            }
            ("texture", _) => return texture::textures(self, step, lanes, batch).is_some(),
            _ => return false,
        }
        true
    }
}

fn put_bits(batch: &mut dyn Batch, out: &Slot, lanes: u32, is: [bool; LANES]) {
    let one = if out.ty.base == Base::Int { 1 } else { 1.0_f32.to_bits() };
    put(batch, out, lanes, &is.map(|is| if is { one } else { 0 }));
}

/// A value without changes.
fn put(batch: &mut dyn Batch, out: &Slot, lanes: u32, words: &[u32; LANES]) {
    batch.put(out.at, lanes, words);
    for k in 1..if out.derivs { 3 } else { 1 } {
        batch.put(out.at + k * out.size, lanes, &[0; LANES]);
    }
}
