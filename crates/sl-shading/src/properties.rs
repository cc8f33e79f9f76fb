// SPDX-License-Identifier: GPL-3.0-or-later
//! Properties of a surface, derived from its group after all known values are inserted: transparency,
//! emission, and queries for light.
//! Invariant: excluded properties never occur. Tests: `tests/scripts/lanes.rs`.

use std::collections::HashSet;

use gnurt_sl::exec::{ClosureDecl, Host, Instruction, Machine, Plan, Step};
use gnurt_sl::ir::SymbolKind;
use gnurt_sl::opcode::Opcode;
use gnurt_sl::types::{Base, Type};
use gnurt_sl_lib::color::ColorSystem;

use crate::closures::{Known, all};
use crate::lobe::SMOOTH;

/// Properties of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Properties {
    /// Light goes straight through where nothing is.
    pub(crate) is_holey: bool,
    /// Light goes through smooth glass.
    pub(crate) is_glass: bool,
    /// There may be a medium behind it.
    pub(crate) has_medium: bool,
    /// It may leave holes in the picture.
    pub(crate) has_holes: bool,
    /// It gives off light.
    pub(crate) is_light: bool,
    /// It computes its radiance by its own rays and light loops.
    pub(crate) is_radiance: bool,
    /// Its closures depend on rays that it traces.
    pub(crate) is_traced: bool,
    /// They depend on the number of bounces before.
    pub(crate) reads_bounces: bool,
}

impl Properties {
    /// Of a group.
    pub(crate) fn of(plan: &Plan, colors: &ColorSystem) -> Self {
        read(plan, colors).0
    }
}

/// The tags of a group's `debug` closures that are known beforehand.
pub(crate) fn debug_tags(plan: &Plan, colors: &ColorSystem) -> Vec<String> {
    read(plan, colors).1
}

fn read(plan: &Plan, colors: &ColorSystem) -> (Properties, Vec<String>) {
    let host = Nobody(colors);
    let mut reader = Reader {
        properties: Properties::default(),
        plan,
        machine: Machine::new(plan, &host),
        known: HashSet::new(),
        tags: Vec::new(),
    };
    for (number, layer) in plan.layers.iter().enumerate() {
        layer.params.iter().for_each(|param| reader.block(number, &param.init, true));
        reader.block(number, &layer.code, false);
    }
    (reader.properties, reader.tags)
}

/// A world without anything but closures.
pub(crate) struct Nobody<'a>(pub(crate) &'a ColorSystem);

impl Host for Nobody<'_> {
    fn closures(&self) -> &[ClosureDecl] {
        all().0
    }

    fn color_system(&self) -> &ColorSystem {
        self.0
    }
}

/// Traverses a group, and evaluates values that depend on known ones only.
struct Reader<'a> {
    properties: Properties,
    plan: &'a Plan,
    machine: Machine<'a>,
    /// First cells of the evaluated values.
    known: HashSet<u32>,
    /// Tags of `debug` closures.
    tags: Vec<String>,
}

impl Reader<'_> {
    /// `is_inner` = it may not be run.
    fn block(&mut self, layer: usize, list: &[Instruction], is_inner: bool) {
        for instruction in list {
            match instruction {
                Instruction::Do(step) => self.step(layer, step, is_inner),
                Instruction::If { yes, no, .. } => {
                    self.block(layer, yes, true);
                    self.block(layer, no, true);
                }
                Instruction::Loop(iterations) => {
                    for part in [&iterations.init, &iterations.test, &iterations.body, &iterations.step] {
                        self.block(layer, part, true);
                    }
                }
                Instruction::Call(body) => self.block(layer, body, true),
                Instruction::Leave(_) => {}
            }
        }
    }

    fn step(&mut self, number: usize, step: &Step, is_inner: bool) {
        match step.code {
            // The radiance of a ray, not whether it hits.
            Opcode::Trace if step.args.first().is_none_or(|out| out.ty != Type::INT) => {
                self.properties.is_radiance = true;
            }
            Opcode::Trace => self.properties.is_traced = true,
            Opcode::LightCount | Opcode::Illuminate => self.properties.is_radiance = true,
            Opcode::Closure => self.closure(number, step),
            _ => {
                let layer = &self.plan.layers[number];
                // A value written once, before all reads in every run: in inner blocks only temporaries are
                // sure to be.
                let is_plain = |id: u32| {
                    let kind = layer.shader.symbol(id).kind;
                    let is_constant = layer.constant.get(id as usize).is_some_and(|&known| known);
                    is_constant && (kind == SymbolKind::Temp || kind == SymbolKind::Local && !is_inner)
                };
                if step.writes == 1 && step.symbols.first().is_some_and(|&id| is_plain(id)) {
                    self.machine.perform(number, step);
                    self.known.insert(step.args[0].at);
                }
            }
        }
    }

    fn closure(&mut self, number: usize, step: &Step) {
        let Self { plan, machine, known, properties, tags } = self;
        let (layer, cells) = (&plan.layers[number], &*machine.cells());
        let bits_of = |i: usize, k: usize| {
            let (slot, id) = (step.args.get(i)?, *step.symbols.get(i)?);
            let kind = layer.shader.symbol(id).kind;
            let is_known = kind == SymbolKind::Const
                || kind == SymbolKind::Param && layer.constant.get(id as usize).is_some_and(|&known| known)
                || known.contains(&slot.at);
            let k = if slot.size == 1 { 0 } else { k };
            (is_known && k < slot.size as usize).then(|| (slot.ty.base, cells[slot.at as usize + k]))
        };
        let Some((Base::String, name)) = bits_of(1, 0) else {
            // Unknown.
            *properties = Properties {
                is_holey: true,
                is_glass: true,
                has_medium: true,
                has_holes: true,
                is_light: true,
                ..*properties
            };
            return;
        };
        let (decls, shapes) = all();
        let name = &**plan.strings.text(name);
        let Some(index) = decls.iter().position(|decl| *decl.name == *name) else { return };
        let number = |parameter: usize, k: usize| {
            bits_of(parameter + 2, k).and_then(|(base, bits_of)| match base {
                Base::Int => Some(bits_of as i32 as f32),
                base if base.is_float_based() => Some(f32::from_bits(bits_of)),
                _ => None,
            })
        };
        let is_black = |parameter: usize| (0..3).all(|k| number(parameter, k).is_some_and(|x| x <= 0.0));
        let is_dull = |x: usize, y: usize| [x, y].iter().any(|&i| number(i, 0).is_some_and(|x| x >= SMOOTH));
        match shapes[index].known {
            Known::AnisotropicVdf | Known::MediumVdf => properties.has_medium = true,
            Known::Holdout => properties.has_holes = true,
            Known::Debug => {
                if let Some((Base::String, tag)) = bits_of(2, 0) {
                    let tag = plan.strings.text(tag).to_string();
                    if !tags.contains(&tag) {
                        tags.push(tag);
                    }
                }
            }
            Known::Transparent => properties.is_holey = true,
            Known::Emission | Known::UniformEdf => properties.is_light = true,
            Known::Radiance => properties.is_radiance = true,
            Known::Refraction => properties.is_glass = true,
            Known::Microfacet => properties.is_glass |= !(number(6, 0) == Some(0.0) || is_dull(3, 4)),
            Known::Dielectric | Known::Schlick => properties.is_glass |= !(is_black(3) || is_dull(4, 5)),
            _ => {}
        }
    }
}
