// SPDX-License-Identifier: GPL-3.0-or-later
//! The key of groups with equal code: 128 bits of everything that determines the code. Over the standard
//! library's hash.
//! Tests: `tests/batches.rs`.

use gnurt_sl::exec::{Instruction, Plan, Program as _, Slot};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Two hashes that begin differently.
struct Both(DefaultHasher, DefaultHasher);

impl Hasher for Both {
    fn finish(&self) -> u64 {
        self.0.finish()
    }

    fn write(&mut self, bytes: &[u8]) {
        self.0.write(bytes);
        self.1.write(bytes);
    }
}

/// Of a group with its values.
pub(crate) fn fingerprint(plan: &Plan) -> u128 {
    let mut hash = Both(DefaultHasher::new(), DefaultHasher::new());
    hash.1.write_u8(1);
    let h = &mut hash;
    (&plan.name, &plan.memory, plan.debug_layers, plan.iterations, &plan.entries).hash(h);
    for number in 0..plan.strings.count() {
        plan.strings.text(number as u32).hash(h);
    }
    for retained in plan.retained() {
        (&retained.name, retained.row, retained.ty).hash(h);
    }
    for layer in &plan.layers {
        (&layer.name, &layer.shader.name, &layer.shader.files, layer.lazy).hash(h);
        (&layer.connected, &layer.constant, layer.slots.len()).hash(h);
        for (symbol, of) in layer.shader.symbols.iter().zip(&layer.slots) {
            (&symbol.name, symbol.kind as u8).hash(h);
            slot(of, h);
        }
        for param in &layer.params {
            (param.symbol, param.source as u8, param.whole).hash(h);
            block(&param.init, h);
        }
        for copy in &layer.copies {
            (copy.layer, copy.from_derivs, copy.to_derivs, copy.to_symbol).hash(h);
            slot(&copy.from, h);
            slot(&copy.to, h);
        }
        block(&layer.code, h);
    }
    u128::from(hash.0.finish()) << 64 | u128::from(hash.1.finish())
}

fn slot(slot: &Slot, h: &mut Both) {
    (slot.at, slot.size, slot.one, slot.ty, slot.derivs).hash(h);
}

fn block(list: &[Instruction], h: &mut Both) {
    list.len().hash(h);
    for instruction in list {
        match instruction {
            Instruction::Do(step) => {
                (0_u8, step.code, step.answer, &step.symbols, step.at.file, step.at.line).hash(h);
                (&step.pulls, step.reads, step.writes).hash(h);
                step.args.iter().for_each(|arg| slot(arg, h));
            }
            Instruction::If { condition, pulls, yes, no } => {
                (1_u8, pulls).hash(h);
                slot(condition, h);
                block(yes, h);
                block(no, h);
            }
            Instruction::Loop(inner) => {
                (2_u8, inner.body_first, &inner.pulls, inner.at.file, inner.at.line).hash(h);
                slot(&inner.condition, h);
                for part in [&inner.init, &inner.test, &inner.body, &inner.step] {
                    block(part, h);
                }
            }
            Instruction::Call(body) => {
                3_u8.hash(h);
                block(body, h);
            }
            Instruction::Leave(flow) => (4_u8, *flow as u8).hash(h),
        }
    }
}
