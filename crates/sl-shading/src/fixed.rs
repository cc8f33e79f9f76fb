// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces with constant scattering: lobes, emission and transparency are computed once for the front, and once
//! for the back; a shader may ask which one it is. A forward data-flow analysis over cells, after all known values are inserted. Lobes may lie
//! around the points' own normals; the direction of anisotropy is irrelevant for isotropic microfacets. All
//! other arguments of closures must be known, and so must every condition; and the shader may neither query
//! nor print.
//! Invariant: lobes and normals equal the result of running the group at the points. Tests:
//! `tests/scripts/lanes.rs`.

use std::collections::HashMap;

use glam::Vec3;
use gnurt_shading::batch::FacingRows;
use gnurt_shading::bsdf::{ClosureBatch, Lists, Lobes};
use gnurt_shading::{ColorMap, Interior, SurfaceBatch};
use gnurt_simd::Level;
use gnurt_sl::exec::{Instruction, LANES, Plan, Points, Program as _, Results, Slot, Source, Step, lanes_of};
use gnurt_sl::ir::SymbolKind;
use gnurt_sl::opcode::Opcode;
use gnurt_sl::types::{Base, Type};
use gnurt_sl_lib::color::ColorSystem;

use crate::closures::{Known, Shape, all};
use crate::emission_and_opacity::EmissionAndOpacity;
use crate::parts::{Flattened, column};
use crate::properties::Nobody;

/// The closures of all points.
#[derive(Debug)]
pub(crate) struct Fixed {
    front: Side,
    back: Side,
}

/// Seen from one side.
#[derive(Debug)]
struct Side {
    /// In the form of closures.
    lobes: Lobes,
    /// Light that goes straight through.
    through: Vec3,
    /// Lobes of the share of light that is stopped.
    stopped: Lobes,
    emission_and_opacity: EmissionAndOpacity,
    interior: Interior,
}

impl Fixed {
    /// Of a group, if they do.
    pub(crate) fn of(plan: &Plan, colors: &ColorSystem, map: ColorMap) -> Option<Self> {
        if !Walk::is_fixed(plan) {
            return None;
        }
        let mut points = Points { count: 1, ..Points::default() };
        for rows in [&mut points.n, &mut points.ng] {
            rows[2][0] = 1.0;
        }
        let mut results = Results::default();
        let mut flatten_lists = |backfacing| {
            points.backfacing = backfacing;
            plan.run(&Nobody(colors), &points, &mut results);
            if !results.events.is_empty() {
                return None;
            }
            let mut out = ClosureBatch::default();
            out.reset(LANES);
            let mut open = Vec::new();
            let flattened = Flattened::flatten_lists(&points, &results, (&mut out, 0), &mut open, map);
            let is_plain =
                !flattened.is_cut() && flattened.lists.bent() == 0 && flattened.lights.radiance.some == 0;
            let Flattened { mut lists, lights, .. } = flattened;
            let (lobes, through) = (lists.lobes(0), lights.through.get(0));
            let emission_and_opacity = match lights.beside_lobes() {
                0 => EmissionAndOpacity::default(),
                _ => EmissionAndOpacity::of(&mut lists, &lights, 0),
            };
            let interior = Interior {
                absorption: emission_and_opacity.absorption,
                scattering: lights.scattering.get(0),
                anisotropy: lights.anisotropy,
            };
            let stopped = lists.lobes(0);
            is_plain.then_some(Side { lobes, through, stopped, emission_and_opacity, interior })
        };
        Some(Self { front: flatten_lists(0)?, back: flatten_lists(1)? })
    }

    /// The lobes of a point, and its straight transmittance, by closures, for the side of its ray.
    pub(crate) fn at(&self, hits: &SurfaceBatch, i: usize) -> (&Lobes, Vec3) {
        let side = if hits.front(i) { &self.front } else { &self.back };
        (&side.lobes, side.through)
    }

    /// The radiance that the front and the back emit.
    pub(crate) fn emission(&self) -> [Vec3; 2] {
        [&self.front, &self.back].map(|side| side.emission_and_opacity.emission.max(Vec3::ZERO))
    }

    /// The medium behind the surface, as its front has it.
    pub(crate) fn interior(&self) -> Interior {
        self.front.interior
    }

    /// The unit normal that the lobes of a point lie around, on the side that its ray came from.
    pub(crate) fn normal(hits: &SurfaceBatch, i: usize) -> Vec3 {
        let ns = hits.facing_ns(i);
        if ns.dot(hits.facing_ng(i)) < 0.0 { -ns } else { ns }
    }

    /// Writes all points.
    pub(crate) fn write(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        for first in (0..hits.len()).step_by(LANES) {
            let count = LANES.min(hits.len() - first);
            let all = (1_u32 << count) - 1;
            let FacingRows { ns: mut normals, ng, back } = hits.facing_rows(first);
            let back = back & all;
            let is_dark = [&self.front, &self.back].map(|side| side.lobes.as_slice().is_empty());
            for i in 0..LANES {
                let [x, y, z] = &mut normals;
                let side = x[i] * ng[0][i] + y[i] * ng[1][i] + z[i] * ng[2][i];
                // As `normal`; unused where there are no lobes.
                let turned = side < 0.0 && !is_dark[(back >> i & 1) as usize];
                let sign = if turned { -1.0 } else { 1.0 };
                (x[i], y[i], z[i]) = (x[i] * sign, y[i] * sign, z[i] * sign);
            }
            let plain = hits.unbent(Level::best(), first, &normals);
            let mut lists = Lists::of(out, first);
            lists.face_all(&normals);
            for lane in lanes_of(all & !plain) {
                let i = first + lane;
                let ns = hits.point(i).bent_normal(column(&normals, lane), -hits.ray_dir.get(i));
                lists.face(lane, ns, |n| n);
            }
            let sides = [(all & !back, &self.front), (back, &self.back)].into_iter();
            for (some, side) in sides.clone().filter(|(some, _)| *some != 0) {
                side.stopped.as_slice().iter().for_each(|lobe| lists.push(some, lobe));
            }
            for (some, side) in sides {
                lanes_of(some).for_each(|lane| {
                    side.emission_and_opacity.write(first + lane, hits.front(first + lane), out);
                });
            }
        }
    }
}

/// Goes through a group until nothing is added.
struct Walk<'p> {
    plan: &'p Plan,
    /// By cell, whether it may differ from point to point.
    varies: Vec<bool>,
    changed: bool,
    fits: bool,
    /// The contents of globals other than `Ci`, by first cell.
    globals: HashMap<u32, &'p str>,
    shapes: &'static [Shape],
}

fn bit(bits: u64, i: usize) -> bool {
    i >= 64 || bits & 1 << i != 0
}

impl<'p> Walk<'p> {
    fn is_fixed(plan: &'p Plan) -> bool {
        let mut this = Self {
            plan,
            varies: vec![false; plan.memory.len()],
            changed: false,
            fits: true,
            globals: HashMap::new(),
            shapes: all().1,
        };
        for (name, slot) in plan.globals.iter().filter(|(_, slot)| slot.ty != Type::CLOSURE) {
            this.globals.insert(slot.at, name);
            this.mark(slot);
        }
        for layer in &plan.layers {
            for param in layer.params.iter().filter(|param| param.source == Source::Geometry) {
                this.mark(&layer.slots[param.symbol as usize]);
            }
        }
        this.changed = true;
        while std::mem::take(&mut this.changed) && this.fits {
            for (number, layer) in plan.layers.iter().enumerate() {
                for copy in &layer.copies {
                    // Derivatives go with the value, wherever they lie.
                    if this.reads(&copy.from) {
                        this.mark(&layer.slots[copy.to_symbol as usize]);
                    }
                }
                layer.params.iter().for_each(|param| this.block(number, &param.init));
                this.block(number, &layer.code);
            }
        }
        this.fits
    }

    fn reads(&self, slot: &Slot) -> bool {
        slot.size > 0 && self.varies[slot.at as usize..][..slot.cells()].contains(&true)
    }

    fn mark(&mut self, slot: &Slot) {
        let cells = &mut self.varies[slot.at as usize..][..slot.cells()];
        self.changed |= cells.contains(&false);
        cells.fill(true);
    }

    fn block(&mut self, layer: usize, list: &[Instruction]) {
        for instruction in list {
            match instruction {
                Instruction::Do(step) => self.step(layer, step),
                Instruction::If { condition, yes, no, .. } => {
                    self.fits &= !self.reads(condition);
                    self.block(layer, yes);
                    self.block(layer, no);
                }
                Instruction::Loop(iterations) => {
                    self.fits &= !self.reads(&iterations.condition);
                    for part in [&iterations.init, &iterations.test, &iterations.body, &iterations.step] {
                        self.block(layer, part);
                    }
                }
                Instruction::Call(body) => self.block(layer, body),
                Instruction::Leave(_) => {}
            }
            if !self.fits {
                return;
            }
        }
    }

    fn step(&mut self, layer: usize, step: &Step) {
        let args = &step.args;
        let written = || args.iter().enumerate().filter(|(i, _)| *i < 64 && bit(step.writes, *i));
        if written().any(|(_, slot)| self.globals.contains_key(&slot.at)) {
            self.fits = false;
            return;
        }
        let varies = args.iter().enumerate().any(|(i, slot)| bit(step.reads, i) && self.reads(slot));
        let is_closure = args.first().is_some_and(|out| out.ty == Type::CLOSURE);
        match step.code {
            // Each side has a run of its own.
            Opcode::UseParam | Opcode::Nop | Opcode::End | Opcode::Backfacing => {}
            Opcode::Closure => self.closure(layer, step),
            Opcode::Add | Opcode::Mul if is_closure => self.fits &= !varies,
            // A wrong index is reported: it must be constant.
            code if code.is_indexed() => self.fits &= !varies,
            code => {
                // Named spaces are the renderer's.
                let has_text = args.iter().any(|slot| slot.ty.base == Base::String);
                let is_placed = has_text
                    && matches!(code, Opcode::Point | Opcode::Vector | Opcode::Normal | Opcode::Matrix);
                self.fits &= code.is_pure() && !is_placed;
                if varies {
                    written().for_each(|(_, slot)| self.mark(slot));
                }
            }
        }
    }

    /// A component: all that it takes must be known but the points' normals, and the direction of grain that there is none of.
    fn closure(&mut self, layer: usize, step: &Step) {
        self.fits &= self.is_known_component(layer, step);
    }

    fn is_known_component(&self, layer: usize, step: &Step) -> bool {
        let plan = self.plan;
        let ([_, name, rest @ ..], [_, symbol, ..]) = (&*step.args, &*step.symbols) else { return false };
        if plan.layers[layer].shader.symbol(*symbol).kind != SymbolKind::Const || name.ty != Type::STRING {
            return false;
        }
        let name = &**plan.strings.text(plan.memory[name.at as usize]);
        let Some(index) = all().0.iter().position(|decl| *decl.name == *name) else { return false };
        let shape = &self.shapes[index];
        let normal = match shape.known {
            Known::Layer | Known::Holdout | Known::Debug | Known::AnisotropicVdf | Known::MediumVdf => None,
            Known::Emission | Known::UniformEdf | Known::Transparent => None,
            Known::Radiance => return false,
            _ => match shape.normal() {
                Some(index) => Some(index),
                None => return false,
            },
        };
        let is_own = |slot: &Slot| self.globals.get(&slot.at) == Some(&"N");
        if normal.is_some_and(|index| !rest.get(index).is_some_and(is_own)) {
            return false;
        }
        let alike = shape.anisotropy_slots().filter(|[_, x, y]| match (rest.get(*x), rest.get(*y)) {
            (Some(x), Some(y)) => x.at == y.at,
            _ => false,
        });
        let free = [normal, alike.map(|[along, ..]| along)];
        rest.iter().enumerate().all(|(i, slot)| free.contains(&Some(i)) || !self.reads(slot))
    }
}
