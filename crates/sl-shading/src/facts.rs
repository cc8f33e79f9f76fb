// SPDX-License-Identifier: GPL-3.0-or-later
//! What a surface may do, as far as its group says so once all values that are known are put in: whether light goes straight through,
//! whether it shines, whether it asks for light itself.
//! Source: original. Invariant: what is said not to happen does not. Proof: `tests/scripts/lanes.rs`.

use gnurt_sl::exec::{Instruction, LayerPlan, Plan, Step};
use gnurt_sl::ir::SymbolKind;
use gnurt_sl::types::Base;

use crate::closures::{Known, all};
use crate::lobe::SMOOTH;

/// What a surface may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Facts {
    /// Light goes straight through where nothing is.
    pub(crate) is_holey: bool,
    /// Light goes through smooth glass.
    pub(crate) is_glass: bool,
    /// It gives off light.
    pub(crate) is_lamp: bool,
    /// It works out what it sends back, by rays and lights of its own.
    pub(crate) is_radiance: bool,
}

impl Facts {
    /// Of a group.
    pub(crate) fn of(plan: &Plan) -> Self {
        let mut facts = Self::default();
        for layer in &plan.layers {
            layer.params.iter().for_each(|param| facts.block(plan, layer, &param.init));
            facts.block(plan, layer, &layer.code);
        }
        facts
    }

    fn block(&mut self, plan: &Plan, layer: &LayerPlan, list: &[Instruction]) {
        for instruction in list {
            match instruction {
                Instruction::Do(step) => self.step(plan, layer, step),
                Instruction::If { yes, no, .. } => {
                    self.block(plan, layer, yes);
                    self.block(plan, layer, no);
                }
                Instruction::Loop(turns) => {
                    for part in [&turns.init, &turns.test, &turns.body, &turns.step] {
                        self.block(plan, layer, part);
                    }
                }
                Instruction::Call(body) => self.block(plan, layer, body),
                Instruction::Leave(_) => {}
            }
        }
    }

    fn step(&mut self, plan: &Plan, layer: &LayerPlan, step: &Step) {
        match &*step.name {
            "trace" | "lightcount" | "illuminate" => self.is_radiance = true,
            "closure" => self.closure(plan, layer, step),
            _ => {}
        }
    }

    fn closure(&mut self, plan: &Plan, layer: &LayerPlan, step: &Step) {
        let word = |i: usize, k: usize| {
            let (slot, id) = (step.args.get(i)?, *step.symbols.get(i)?);
            let kind = layer.shader.symbol(id).kind;
            let is_known = kind == SymbolKind::Const
                || kind == SymbolKind::Param && layer.constant.get(id as usize).is_some_and(|&known| known);
            let k = if slot.size == 1 { 0 } else { k };
            (is_known && k < slot.size as usize).then(|| (slot.ty.base, plan.memory[slot.at as usize + k]))
        };
        let Some((Base::String, name)) = word(1, 0) else {
            // Nobody knows.
            *self = Self { is_holey: true, is_glass: true, is_lamp: true, is_radiance: self.is_radiance };
            return;
        };
        let (decls, shapes) = all();
        let name = &**plan.strings.text(name);
        let Some(place) = decls.iter().position(|decl| *decl.name == *name) else { return };
        let number = |parameter: usize, k: usize| {
            word(parameter + 2, k).and_then(|(base, word)| match base {
                Base::Int => Some(word as i32 as f32),
                base if base.is_float_based() => Some(f32::from_bits(word)),
                _ => None,
            })
        };
        let is_black = |parameter: usize| (0..3).all(|k| number(parameter, k).is_some_and(|x| x <= 0.0));
        let is_dull = |x: usize, y: usize| [x, y].iter().any(|&i| number(i, 0).is_some_and(|x| x >= SMOOTH));
        match shapes[place].known {
            Known::Transparent => self.is_holey = true,
            Known::Emission | Known::UniformEdf => self.is_lamp = true,
            Known::Radiance => self.is_radiance = true,
            Known::Refraction => self.is_glass = true,
            Known::Microfacet => self.is_glass |= !(number(6, 0) == Some(0.0) || is_dull(3, 4)),
            Known::Dielectric | Known::Schlick => self.is_glass |= !(is_black(3) || is_dull(4, 5)),
            _ => {}
        }
    }
}
