// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs a group for a point: layers when they are needed, connections when they are read.
//! The order is OSL's.

use super::host::Point;
use super::machine::{Event, Flow, Instruction, Loop, Machine, Source, Step};
use super::nesting::{LAYER, MOST_NESTED};
use super::scalar::connect;
use super::slot::Slot;
use crate::hir::Data;
use crate::ir::SourcePosition;
use crate::opcode::Opcode;
use crate::types::{Base, Type};

/// Operations of a point, for each iteration that it may take.
const STEPS: u64 = 4;
/// Operations that it may take in any case.
const LEAST: u64 = 4_000_000;
/// Numbers of a result that count as an operation.
const NUMBERS: u32 = 8;
/// Operations that noise counts as.
const NOISE: u32 = 8;

/// Globals that a point gives.
pub(super) const POINT_GLOBALS: [&str; 14] =
    ["P", "I", "N", "Ng", "dPdu", "dPdv", "Ps", "dPdtime", "u", "v", "time", "dtime", "xi", "raster"];

/// How much of a point's work an operation counts as.
pub(super) fn work_of(code: Opcode, args: &[Slot]) -> u32 {
    let size = args.first().map_or(0, |out| out.size);
    size / NUMBERS + if code.is_noise() { NOISE } else { 1 }
}

impl Machine<'_> {
    /// Runs the group; outputs are then read with [`output`](Self::output).
    pub fn run(&mut self, point: &Point) {
        self.closures.clear();
        self.run_neighbours(point);
    }

    /// The same, keeping the closures of points before.
    pub(super) fn run_neighbours(&mut self, point: &Point) {
        self.begin_neighbours(point);
        let Some(last) = self.plan.layers.len().checked_sub(1) else { return };
        self.trace_layer(last, "enter");
        self.done[last] = true;
        for layer in 0..last {
            if !self.plan.layers[layer].lazy && !self.done[layer] {
                self.layer_once(layer);
            }
        }
        self.layer_body(last);
        self.trace_layer(last, "exit");
    }

    fn trace_layer(&mut self, layer: usize, what: &str) {
        if self.plan.debug_layers {
            let code = &self.plan.layers[layer];
            let (shader, name) = (&code.shader.name, &code.name);
            self.events
                .push(Event::Print(format!("({shader} {name}) {what} layer {layer} {name} {shader}\n")));
        }
    }

    /// Whether the point was stopped: a loop did not end.
    pub(super) fn was_stopped(&self) -> bool {
        self.fuel == 0
    }

    /// Resets the state of the point before.
    pub fn begin(&mut self, point: &Point) {
        self.closures.clear();
        self.begin_neighbours(point);
    }

    fn begin_neighbours(&mut self, point: &Point) {
        self.memory.clone_from(&self.plan.memory);
        self.strings.truncate(self.plan.strings.count());
        self.messages.clear();
        if let Some(unwritten) = &mut self.unwritten {
            unwritten.clear();
        }
        self.reports = 0;
        self.nested = 0;
        self.done.fill(false);
        for list in &mut self.pulled {
            list.fill(false);
        }
        self.fuel = self.plan.iterations;
        self.work = self.plan.iterations.saturating_mul(STEPS).max(LEAST);
        self.point = point.clone();
        self.set_globals();
    }

    fn set_globals(&mut self) {
        let [p, i, n, ng, dpdu, dpdv, ps, dpdtime, u, v, time, dtime, xi, raster] = self.plan.of_points;
        let point = self.point.clone();
        let fixed = |v: [f32; 3]| gnurt_sl_lib::Dual::from(v).components();
        for (slot, value) in [
            (p, point.p.components()),
            (i, point.i.components()),
            (n, fixed(point.n)),
            (ng, fixed(point.ng)),
            (dpdu, fixed(point.dpdu)),
            (dpdv, fixed(point.dpdv)),
            (ps, point.ps.components()),
            (dpdtime, fixed(point.dpdtime)),
        ] {
            if let Some(slot) = slot {
                self.set_triple(&slot, value);
            }
        }
        for (slot, value) in
            [(u, point.u), (v, point.v), (time, point.time.into()), (dtime, point.dtime.into())]
        {
            if let Some(slot) = slot {
                self.set(&slot, 0, value);
            }
        }
        for (slot, values) in [(xi, &point.xi), (raster, &point.raster)] {
            if let Some(slot) = slot {
                values.iter().enumerate().for_each(|(i, &value)| self.set(&slot, i, value.into()));
            }
        }
    }

    /// Runs a layer, if it has not been run for this point.
    pub fn run_layer(&mut self, layer: usize) {
        if self.plan.entries.contains(&layer) {
            self.trace_layer(layer, "checking for already-run");
        }
        if self.done[layer] {
            self.trace_layer(layer, "  taking early exit, already executed");
            return;
        }
        self.layer_once(layer);
    }

    fn layer_once(&mut self, layer: usize) {
        self.done[layer] = true;
        let outer = self.nested;
        self.nested += LAYER + self.plan.layers[layer].depth;
        if self.nested > 2 * MOST_NESTED {
            let name = &self.plan.layers[layer].name;
            let what = "layers wait for each other more deeply than blocks may nest";
            self.error(format!("{what}: layer \"{name}\" is left out"));
            self.nested = outer;
            return;
        }
        self.trace_layer(layer, "enter");
        self.layer_body(layer);
        self.trace_layer(layer, "exit");
        self.nested = outer;
    }

    fn layer_body(&mut self, layer: usize) {
        let outer = std::mem::replace(&mut self.layer, layer);
        let plan = self.plan;
        let code = &plan.layers[layer];
        for param in &code.params {
            match param.source {
                Source::Connected if param.whole => continue,
                Source::Geometry if self.fetch_userdata(layer, param) => continue,
                _ => {}
            }
            if self.block(&param.init) == Flow::Exit {
                break;
            }
        }
        self.block(&code.code);
        self.layer = outer;
    }

    /// Evaluates the connections of parameters.
    fn pull(&mut self, pulls: &[u32]) {
        for &symbol in pulls {
            let layer = self.layer;
            if std::mem::replace(&mut self.pulled[layer][symbol as usize], true) {
                continue;
            }
            let plan = self.plan;
            for copy in plan.layers[layer].copies.iter().filter(|c| c.to_symbol == symbol) {
                if !self.done[copy.layer] {
                    self.run_layer(copy.layer);
                }
                connect(self, copy);
            }
        }
    }

    pub(super) fn block(&mut self, list: &[Instruction]) -> Flow {
        for instruction in list {
            match instruction {
                Instruction::Do(step) => {
                    self.step(step);
                    if self.work == 0 {
                        self.fuel = 0;
                        return self.stop(step.at, "the shader", "operations", STEPS);
                    }
                }
                Instruction::If { condition, pulls, yes, no } => {
                    self.pull(pulls);
                    if self.unwritten.is_some() {
                        self.check_condition(instruction, condition);
                    }
                    let flow = self.block(if self.cell_bits(condition, 0) != 0 { yes } else { no });
                    if flow != Flow::Next {
                        return flow;
                    }
                }
                Instruction::Loop(inner) => match self.iterations(inner) {
                    Flow::Next => {}
                    flow => return flow,
                },
                Instruction::Call(body) => {
                    if self.block(body) == Flow::Exit {
                        return Flow::Exit;
                    }
                }
                Instruction::Leave(flow) => return *flow,
            }
        }
        Flow::Next
    }

    /// Reports that a point is stopped, once.
    fn stop(&mut self, at: SourcePosition, what: &str, unit: &str, each: u64) -> Flow {
        let source_position = self.source_position(at);
        let count = self.plan.iterations.saturating_mul(each);
        self.error(format!("stopped: {what} at {source_position} did not end after {count} {unit}"));
        Flow::Exit
    }

    fn iterations(&mut self, inner: &Loop) -> Flow {
        match self.block(&inner.init) {
            Flow::Next => {}
            flow => return flow,
        }
        let mut skip_test = inner.body_first;
        loop {
            if !std::mem::take(&mut skip_test) {
                match self.block(&inner.test) {
                    Flow::Next => {}
                    flow => return flow,
                }
                self.pull(&inner.pulls);
                if self.cell_bits(&inner.condition, 0) == 0 {
                    return Flow::Next;
                }
            }
            if self.fuel == 0 {
                return self.stop(inner.at, "a loop", "turns", 1);
            }
            self.fuel -= 1;
            match self.block(&inner.body) {
                Flow::Break => return Flow::Next,
                Flow::Next | Flow::Continue => {}
                flow => return flow,
            }
            match self.block(&inner.step) {
                Flow::Next => {}
                flow => return flow,
            }
        }
    }

    #[inline(always)]
    fn step(&mut self, step: &Step) {
        self.work = self.work.saturating_sub(step.work.into());
        if !step.pulls.is_empty() {
            self.pull(&step.pulls);
        }
        if self.unwritten.is_some() {
            self.check_reads(step);
            self.note_writes(step);
        }
        self.perform(self.layer, step);
        if self.checks {
            self.check_results(step);
        }
    }

    /// Reports results of a step that are NaN or infinite.
    fn check_results(&mut self, step: &Step) {
        for (k, slot) in step.args.iter().enumerate().filter(|(k, _)| *k < 64 && step.writes & (1 << k) != 0)
        {
            if slot.ty.base != Base::Float && !slot.ty.base.is_triple() && slot.ty.base != Base::Matrix {
                continue;
            }
            let found = (0..slot.size as usize).map(|i| self.float(slot, i)).find(|x| !x.is_finite());
            if let Some(found) = found {
                let what = if found.is_nan() { "nan" } else { "inf" };
                let name = self.plan.layers[self.layer].shader.symbol(step.symbols[k]).name.clone();
                let source_position = self.source_position(step.at);
                self.error(format!(
                    "Detected {what} value in {name} at {source_position} (op {})",
                    step.code.name()
                ));
            }
        }
    }

    /// The value and type of a layer's output, or of `Ci` and other globals.
    #[must_use]
    pub fn output(&self, layer: Option<usize>, name: &str) -> Option<(Type, Data)> {
        if let (None, Some(slot)) = (layer, self.plan.globals.get(name)) {
            return Some((slot.ty, self.data(slot)));
        }
        let code = self.plan.layers.get(layer?)?;
        let slot = code.slots[code.shader.find(name)? as usize];
        Some((slot.ty, self.data(&slot)))
    }

    /// The number of the closure in `Ci`; see [`components`](Self::components).
    #[must_use]
    pub fn ci(&self) -> u32 {
        self.plan.globals.get("Ci").map_or(0, |slot| self.cell_bits(slot, 0))
    }
}
