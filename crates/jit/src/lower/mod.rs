// SPDX-License-Identifier: GPL-3.0-or-later
//! A group that is ready to run, as a program for lanes: control on masks, computing in regions.
//! `analyse` finds varying and overwritable variables, `native` chooses the operations with code, `values` tracks
//! the contents of cells. The evaluator of `gnurt_sl::exec` records the operations.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

mod analyse;
mod native;
mod values;

use gnurt_sl::exec::{
    Copy, Flow, Instruction, Loop, Plan, Slot, Source, Step, compute, makes_closures, queries_in_batches,
    transfer,
};
use gnurt_sl::ir::SymbolKind;
use gnurt_sl::types::Base;
use std::sync::Arc;

use crate::program::{Call, Layer, Loop as Turns, Making, Node, Program, Test, Tight};
use crate::term::{QuickSet, constant, take};
use native::{Known, Touch, is_honest, touches};
use values::Values;

/// Layers that a group may have: their functions call each other.
const LAYERS: usize = 1000;
/// Cells that are set one by one when a layer starts.
const RESETS: usize = 1 << 14;
/// Blocks may nest this deep.
const DEPTH: usize = 200;
/// Operations of an iteration that counts as more than one turn.
const TURN: usize = 64;
/// Operations of both blocks of a choice that take less time than a branch that is not foreseen.
const CHEAP: u32 = 32;
/// Operations of an iteration that is one region.
const LONG: u32 = 2000;
/// Operations of code; each has some ten bytes, and as much again while it is made.
const SIZE: usize = 2_000_000;

/// The program of a group, for several lanes, however many, or for one.
///
/// # Errors
/// Why the interpreter must run it.
pub(crate) fn program(plan: &Plan, several: bool) -> Result<Program, String> {
    if plan.debug_layers {
        return Err("layers that print their start need the interpreter".into());
    }
    if plan.layers.len() > LAYERS {
        return Err(format!("the group has more than {LAYERS} layers"));
    }
    // Before anything goes through them.
    if let Some(deep) = plan.layers.iter().find(|layer| layer.depth > DEPTH) {
        return Err(format!("blocks are nested more than {DEPTH} deep in layer {}", deep.name));
    }
    let mut cells = vec![false; plan.memory.len()];
    for layer in &plan.layers {
        let mut written = QuickSet::default();
        for list in layer.params.iter().map(|param| &param.init).chain([&layer.code]) {
            note_written(list, &mut written);
        }
        for (id, (slot, symbol)) in layer.slots.iter().zip(&layer.shader.symbols).enumerate() {
            // Parameters whose values are given; files may write to them all the same.
            let is_given = symbol.kind == SymbolKind::Param && layer.constant.get(id) == Some(&true);
            if symbol.kind == SymbolKind::Const || is_given && !written.contains(&slot.at) {
                cells[slot.at as usize..][..slot.cells()].fill(true);
            }
        }
    }
    let known = Known { plan, cells };
    let analysis = analyse::analysis(plan, &known, several);
    let mut lowerer = Lowerer {
        values: Values::new(plan, analysis, &known),
        program: Program::default(),
        nodes: Vec::new(),
        layer: 0,
        blocks: 0,
        depth: 0,
        size: 0,
        pulled: Vec::new(),
        pulls: Vec::new(),
        done: Vec::new(),
        frame: 0,
        exit: 0,
        waiting: None,
    };
    let result = lowerer.layers();
    take();
    result?;
    let mut program = lowerer.program;
    program.varying = lowerer.values.analysis.varying;
    Ok(program)
}

/// Notes the first cells that a block writes.
fn note_written(list: &[Instruction], written: &mut QuickSet<u32>) {
    for instruction in list {
        match instruction {
            Instruction::Do(step) => {
                let is_written = |i: &usize| *i >= 64 || step.writes & 1 << *i != 0;
                written.extend((0..step.args.len()).filter(is_written).map(|i| step.args[i].at));
            }
            Instruction::If { yes, no, .. } => [yes, no].iter().for_each(|part| note_written(part, written)),
            Instruction::Loop(iterations) => {
                let parts = [&iterations.init, &iterations.test, &iterations.body, &iterations.step];
                parts.iter().for_each(|part| note_written(part, written));
            }
            Instruction::Call(body) => note_written(body, written),
            Instruction::Leave(_) => {}
        }
    }
}

struct Lowerer<'p> {
    values: Values<'p>,
    program: Program,
    /// Of the block that is lowered.
    nodes: Vec<Node>,
    layer: usize,
    /// How many blocks were begun.
    blocks: u32,
    depth: usize,
    /// Operations of code so far.
    size: usize,
    /// Parameters that all lanes have fetched that can come here.
    pulled: Vec<u32>,
    /// By parameter of this layer that is fetched somewhere, the mask of lanes that have.
    pulls: Vec<(u32, u32)>,
    /// By layer, the mask of lanes that have run it.
    done: Vec<u32>,
    /// Where lanes are noted that leave the function, and the layer.
    frame: u32,
    exit: u32,
    /// Where lanes wait for the loop's next iteration.
    waiting: Option<u32>,
}

impl Lowerer<'_> {
    fn slot(&mut self) -> u32 {
        self.program.slots += 1;
        self.program.slots - 1
    }

    fn flag(&mut self) -> u32 {
        let slot = self.slot();
        self.program.flags.push(slot);
        slot
    }

    fn flush(&mut self) {
        if let Some(region) = self.values.end() {
            self.size += region.ops.len();
            self.nodes.push(Node::Region(region));
        }
    }

    fn call(&mut self, call: Call) -> u32 {
        self.program.calls.push(call);
        self.program.calls.len() as u32 - 1
    }

    fn layers(&mut self) -> Result<(), String> {
        let plan = self.values.plan;
        self.done = plan.layers.iter().map(|_| 0).collect();
        for number in 0..plan.layers.len() {
            self.done[number] = self.flag();
        }
        for number in 0..plan.layers.len() {
            self.layer = number;
            self.pulls.clear();
            self.pulled.clear();
            let entry = self.slot();
            self.reset()?;
            self.params()?;
            let code = self.frame_of(&plan.layers[number].code)?;
            self.nodes.extend(code);
            let code = std::mem::take(&mut self.nodes);
            self.program.layers.push(Layer { done: self.done[number], entry, code });
        }
        Ok(())
    }

    /// Variables that may be read before they are written are reset at each run of a layer.
    fn reset(&mut self) -> Result<(), String> {
        let plan = self.values.plan;
        let layer = &plan.layers[self.layer];
        let mut count = 0;
        self.values.block = u32::MAX - 1;
        for slot in &layer.slots {
            let due = self.values.analysis.variables.get(&slot.at).is_some_and(|v| !v.clean && v.uses > 0);
            if !due {
                continue;
            }
            count += slot.cells();
            if count > RESETS {
                return Err(format!("variables of a layer have more than {RESETS} numbers"));
            }
            for i in 0..slot.cells() as u32 {
                let start = constant(plan.memory[(slot.at + i) as usize]);
                self.values.set_bits(slot, i, start);
            }
        }
        self.flush();
        Ok(())
    }

    /// Defaults that are worked out, and values of the geometry.
    fn params(&mut self) -> Result<(), String> {
        let plan = self.values.plan;
        let layer = &plan.layers[self.layer];
        let [entry, left] = [self.slot(), self.slot()];
        let outer = std::mem::take(&mut self.nodes);
        (self.frame, self.exit) = (left, left);
        for (number, param) in layer.params.iter().enumerate() {
            match param.source {
                Source::Connected if param.whole => {
                    // Its block is counted all the same.
                    self.skip_blocks(&param.init);
                }
                Source::Geometry => {
                    let given = self.slot();
                    let call = self.call(Call::Userdata { layer: self.layer, param: number, given });
                    self.flush();
                    self.nodes.push(Node::Call(call));
                    let init = self.frame_within(&param.init, left)?;
                    if !init.is_empty() {
                        let [other, done] = [self.slot(), self.slot()];
                        let test = Test::Lanes(given);
                        self.nodes.push(Node::If { test, yes: Vec::new(), no: init, other, done });
                    }
                }
                _ => {
                    let init = self.frame_within(&param.init, left)?;
                    self.nodes.extend(init);
                }
            }
        }
        self.flush();
        let body = std::mem::replace(&mut self.nodes, outer);
        if body.iter().any(Node::leaves) {
            self.nodes.push(Node::Frame { body, entry, left, gone: None });
        } else {
            self.nodes.extend(body);
        }
        Ok(())
    }

    /// A layer's code.
    fn frame_of(&mut self, list: &[Instruction]) -> Result<Vec<Node>, String> {
        let [entry, left] = [self.slot(), self.slot()];
        (self.frame, self.exit) = (left, left);
        let body = self.block(list, None)?;
        Ok(if body.iter().any(Node::leaves) {
            vec![Node::Frame { body, entry, left, gone: None }]
        } else {
            body
        })
    }

    /// A function's body.
    fn frame_within(&mut self, list: &[Instruction], exit: u32) -> Result<Vec<Node>, String> {
        let [entry, left] = [self.slot(), self.slot()];
        let outer = std::mem::replace(&mut self.frame, left);
        let waiting = self.waiting.take();
        let body = self.block(list, None)?;
        self.waiting = waiting;
        self.frame = outer;
        Ok(if body.iter().any(Node::leaves) {
            vec![Node::Frame { body, entry, left, gone: Some(exit) }]
        } else {
            body
        })
    }

    fn skip_blocks(&mut self, list: &[Instruction]) {
        self.blocks += 1;
        for instruction in list {
            match instruction {
                Instruction::If { yes, no, .. } => {
                    self.skip_blocks(yes);
                    self.skip_blocks(no);
                }
                Instruction::Loop(inner) => {
                    for part in [&inner.init, &inner.test, &inner.body, &inner.step] {
                        self.skip_blocks(part);
                    }
                }
                Instruction::Call(body) => self.skip_blocks(body),
                Instruction::Do(_) | Instruction::Leave(_) => {}
            }
        }
    }

    /// The nodes of a block; with a condition, the remaining lanes are tested at its end.
    fn block(
        &mut self,
        list: &[Instruction],
        condition: Option<(&Slot, &[u32], &mut Option<Test>)>,
    ) -> Result<Vec<Node>, String> {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(format!("blocks are nested more than {DEPTH} deep"));
        }
        self.flush();
        let outer = std::mem::take(&mut self.nodes);
        let above = self.values.block;
        let pulled = self.pulled.len();
        self.values.block = self.blocks;
        let base = std::mem::replace(&mut self.values.base, self.blocks);
        self.blocks += 1;
        for (i, instruction) in list.iter().enumerate() {
            self.instruction(instruction)?;
            if let Instruction::Leave(_) = instruction {
                // The rest is never executed, but its blocks are counted.
                for dead in &list[i + 1..] {
                    self.skip_blocks(std::slice::from_ref(dead));
                    self.blocks -= 1;
                }
                break;
            }
        }
        if let Some((slot, pulls, test)) = condition {
            self.fetch(pulls);
            let Self { values, program, .. } = self;
            *test = Some(values.test(slot, || {
                program.slots += 1;
                program.slots - 1
            }));
        }
        self.flush();
        self.pulled.truncate(pulled);
        (self.values.block, self.values.base) = (above, base);
        self.depth -= 1;
        Ok(std::mem::replace(&mut self.nodes, outer))
    }

    fn instruction(&mut self, instruction: &Instruction) -> Result<(), String> {
        match instruction {
            Instruction::Do(step) => self.step(step)?,
            Instruction::If { condition, pulls, yes, no } => {
                self.fetch(pulls);
                if self.values.analysis.varying[condition.at as usize] {
                    if let (Some(a), Some(b)) = (self.weight(yes, false), self.weight(no, false))
                        && a + b <= CHEAP
                        && !self.values.is_long()
                    {
                        return self.choice(condition, yes, no);
                    }
                    if let ([Instruction::Leave(flow)], []) = (&**yes, &**no) {
                        let lanes = self.slot();
                        self.values.test(condition, || lanes);
                        self.flush();
                        self.blocks += 2;
                        if let Some(note) = self.note(*flow) {
                            self.nodes.push(Node::LeaveSome { lanes, note });
                        }
                        return Ok(());
                    }
                }
                let Self { values, program, .. } = self;
                let test = values.test(condition, || {
                    program.slots += 1;
                    program.slots - 1
                });
                self.flush();
                let yes = self.block(yes, None)?;
                let no = self.block(no, None)?;
                let [other, done] = [self.slot(), self.slot()];
                self.nodes.push(Node::If { test, yes, no, other, done });
            }
            Instruction::Loop(inner) => self.iterations(inner)?,
            Instruction::Call(body) => {
                self.flush();
                let nodes = self.frame_within(body, self.exit)?;
                self.nodes.extend(nodes);
            }
            Instruction::Leave(flow) => {
                self.flush();
                self.nodes.extend(self.note(*flow).map(Node::Leave));
            }
        }
        Ok(())
    }

    /// Where lanes are noted that leave in some way; none if they do not.
    fn note(&self, flow: Flow) -> Option<Option<u32>> {
        match flow {
            Flow::Break => Some(None),
            Flow::Continue => Some(self.waiting),
            Flow::Return => Some(Some(self.frame)),
            Flow::Exit => Some(Some(self.exit)),
            Flow::Next => None,
        }
    }

    /// About as many operations as a block takes, if it may be done for all lanes under a mask. Of jumps, it may
    /// have those of a loop's body, at the ends of its inner blocks.
    fn weight(&self, list: &[Instruction], in_body: bool) -> Option<u32> {
        let is_pulled = |pulls: &[u32]| pulls.iter().all(|symbol| self.pulled.contains(symbol));
        let mut sum = 0_u32;
        for instruction in list {
            sum += match instruction {
                Instruction::Do(step) => {
                    let is_plain = self.values.known.is_native(step) && is_pulled(&step.pulls);
                    (is_plain && is_honest(step)).then(|| native::weight(step))?
                }
                Instruction::If { condition: _, pulls, yes, no } if is_pulled(pulls) => {
                    let jumps = |list: &[Instruction]| {
                        let is_jump = |last: &Instruction| {
                            matches!(last, Instruction::Leave(Flow::Break | Flow::Continue))
                        };
                        usize::from(in_body && list.last().is_some_and(is_jump))
                    };
                    let (a, b) = (yes.len() - jumps(yes), no.len() - jumps(no));
                    let inner = self.weight(&yes[..a], in_body)? + self.weight(&no[..b], in_body)?;
                    if in_body && inner > CHEAP {
                        return None;
                    }
                    2 + inner
                }
                _ => return None,
            };
            if sum > LONG {
                return None;
            }
        }
        Some(sum)
    }

    /// Both blocks of a choice, under masks.
    fn choice(&mut self, condition: &Slot, yes: &[Instruction], no: &[Instruction]) -> Result<(), String> {
        let mask = self.values.mask(condition);
        for (mask, list) in [(mask, yes), (!mask, no)] {
            let outer = self.values.open(mask);
            self.straight(list)?;
            self.values.close(outer);
        }
        Ok(())
    }

    /// A block as a part of the region.
    fn straight(&mut self, list: &[Instruction]) -> Result<(), String> {
        let above = std::mem::replace(&mut self.values.block, self.blocks);
        self.blocks += 1;
        for instruction in list {
            match instruction {
                Instruction::Do(step) => self.native(step)?,
                Instruction::If { condition, yes, no, .. } => self.choice(condition, yes, no)?,
                Instruction::Leave(flow) => self.values.leave(*flow == Flow::Break),
                Instruction::Loop(_) | Instruction::Call(_) => return Err("a block that branches".into()),
            }
        }
        self.values.block = above;
        Ok(())
    }

    /// A loop whose iteration is one region, if it can be that. Its first block has been lowered.
    fn tight(&mut self, inner: &Loop) -> Result<bool, String> {
        let parts = [(&inner.test, false), (&inner.body, true), (&inner.step, false)];
        let weights = parts.map(|(part, in_body)| self.weight(part, in_body));
        let is_pulled = inner.pulls.iter().all(|symbol| self.pulled.contains(symbol));
        let is_short = weights.iter().try_fold(0, |sum, weight| Some(sum + (*weight)?));
        let varies = self.values.analysis.varying[inner.condition.at as usize];
        if !varies || !is_pulled || is_short.is_none_or(|sum| sum > LONG) {
            return Ok(false);
        }
        self.flush();
        let outer = std::mem::take(&mut self.nodes);
        let base = std::mem::replace(&mut self.values.base, u32::MAX);
        let [entry, live] = [self.slot(), self.slot()];
        let (first, size) = (self.blocks, self.size);
        if inner.body_first {
            self.skip_blocks(&inner.test);
        } else {
            self.straight(&inner.test)?;
            self.values.end_iteration(&inner.condition, live);
            self.flush();
        }
        let before = std::mem::take(&mut self.nodes);
        self.straight(&inner.body)?;
        self.values.end_body();
        self.straight(&inner.step)?;
        let next = std::mem::replace(&mut self.blocks, first);
        self.straight(&inner.test)?;
        self.blocks = next;
        self.values.end_iteration(&inner.condition, live);
        self.flush();
        let iteration = std::mem::replace(&mut self.nodes, outer);
        self.values.base = base;
        let say = self.call(Call::Stopped { layer: self.layer, at: inner.at });
        let body_first = inner.body_first;
        let (stopped, turns) = (self.exit, 1 + ((self.size - size) / TURN) as u32);
        self.nodes.push(Node::Tight(Box::new(Tight {
            body_first,
            before,
            iteration,
            entry,
            live,
            stopped,
            say,
            turns,
        })));
        Ok(true)
    }

    fn iterations(&mut self, inner: &Loop) -> Result<(), String> {
        if [&inner.init, &inner.test, &inner.step].iter().any(|part| analyse::leaves(part)) {
            return Err("a loop is left from within its condition".into());
        }
        let init = self.block(&inner.init, None)?;
        self.nodes.extend(init);
        if self.tight(inner)? {
            return Ok(());
        }
        let [entry, live, waiting] = [self.slot(), self.slot(), self.slot()];
        let (mut condition, before) = (None, self.size);
        let test = self.block(&inner.test, Some((&inner.condition, &inner.pulls, &mut condition)))?;
        let outer = self.waiting.replace(waiting);
        let body = self.block(&inner.body, None)?;
        self.waiting = outer;
        let step = self.block(&inner.step, None)?;
        let say = self.call(Call::Stopped { layer: self.layer, at: inner.at });
        let mut gone = vec![self.frame];
        if self.exit != self.frame {
            gone.push(self.exit);
        }
        let condition = condition.ok_or("a loop without a condition")?;
        self.nodes.push(Node::Loop(Box::new(Turns {
            body_first: inner.body_first,
            test,
            condition,
            body,
            step,
            entry,
            live,
            waiting,
            gone,
            stopped: self.exit,
            say,
            turns: 1 + ((self.size - before) / TURN) as u32,
        })));
        Ok(())
    }

    fn step(&mut self, step: &Step) -> Result<(), String> {
        if !is_honest(step) {
            return Err(format!("'{}' has undeclared writes", step.code.name()));
        }
        self.fetch(&step.pulls);
        if !self.values.known.is_native(step) {
            let checked = self.values.known.checked(step);
            if let Some((index, count)) = checked {
                // For the other lanes the interpreter reports it, and moves the index.
                let bad = self.slot();
                if self.values.is_long() {
                    self.flush();
                }
                self.values.out_of_range(index, count, bad);
                compute(&mut self.values, step);
                self.flush();
                let call = self.left(step);
                let [other, done] = [self.slot(), self.slot()];
                let yes = vec![Node::Call(call)];
                self.nodes.push(Node::If { test: Test::Lanes(bad), yes, no: Vec::new(), other, done });
                return Ok(());
            }
            self.flush();
            let call = self.left(step);
            self.nodes.push(Node::Call(call));
            return Ok(());
        }
        if self.values.is_long() {
            self.flush();
        }
        self.native(step)
    }

    /// The call of an operation that is left to the interpreter.
    fn left(&mut self, step: &Step) -> u32 {
        touches(step, false, |i, touch| {
            let state = self.program.touched.entry(step.args[i].at).or_default();
            *state |= touch != Touch::Read;
        });
        let constant = |slot: &&Slot| slot.size > 0 && !self.values.known.cells[slot.at as usize];
        let ins: Vec<Slot> = step.args.iter().filter(constant).copied().collect();
        let written = |i: &usize| *i < 64 && step.writes & 1 << *i != 0;
        let outs = (0..step.args.len()).filter(written).map(|i| step.args[i]).collect();
        let (layer, step) = (self.layer, Arc::new(step.clone()));
        let call = if makes_closures(&step) {
            let is_named = ins.iter().all(|slot| slot.ty.base != Base::String);
            Call::Closure(Box::new(Making { layer, step, ins, outs, is_named }))
        } else if queries_in_batches(&step) {
            Call::Together { layer, step, ins, outs }
        } else {
            Call::Step { layer, step, ins, outs }
        };
        self.call(call)
    }

    /// An operation as code, in the region.
    fn native(&mut self, step: &Step) -> Result<(), String> {
        self.size += step.args.first().map_or(0, |out| out.cells());
        if self.size > SIZE {
            return Err(format!("its code has more than {SIZE} operations"));
        }
        touches(step, true, |i, touch| {
            let state = self.program.touched.entry(step.args[i].at).or_default();
            *state |= touch != Touch::Read;
        });
        let mut used: Vec<u32> = Vec::with_capacity(step.args.len());
        touches(step, true, |i, _: Touch| used.push(step.args[i].at));
        for at in used {
            self.values.touch(at);
        }
        compute(&mut self.values, step);
        Ok(())
    }

    /// Evaluates the connections of parameters, for lanes that have not done so.
    fn fetch(&mut self, pulls: &[u32]) {
        for &symbol in pulls {
            if self.pulled.contains(&symbol) {
                continue;
            }
            self.pulled.push(symbol);
            self.flush();
            let flag = match self.pulls.iter().find(|known| known.0 == symbol) {
                Some(known) => known.1,
                None => {
                    let flag = self.flag();
                    self.pulls.push((symbol, flag));
                    flag
                }
            };
            let entry = self.slot();
            let outer = std::mem::take(&mut self.nodes);
            let plan = self.values.plan;
            for copy in plan.layers[self.layer].copies.iter().filter(|c| c.to_symbol == symbol) {
                self.flush();
                self.nodes.push(Node::Layer(copy.layer as u32));
                self.connection(copy);
            }
            self.flush();
            let body = std::mem::replace(&mut self.nodes, outer);
            self.nodes.push(Node::Once { flag, entry, body });
        }
    }

    fn connection(&mut self, copy: &Copy) {
        let whole = self.values.plan.layers[self.layer].slots[copy.to_symbol as usize];
        self.program.touched.insert(whole.at, true);
        transfer(&mut self.values, copy);
    }
}
