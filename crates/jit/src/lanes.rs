// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs machine code for a batch of points, or for two side by side, and executes its calls: those of two batches one after
//! the other. Operations without code run in the interpreter, one lane after the other: the arguments are copied into the
//! machine's memory and the results are copied back.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl::exec::{
    Batch as RunningBatch, Cells, Component, Event, Host, LANES, Machine, Message, Plan, Point, Points,
    Program, Results, RetainedOutput, Slot, Step, lanes_of,
};
use gnurt_sl::hir::Data;
use gnurt_sl::opcode::Opcode;
use gnurt_sl::types::{Base, Type};

use crate::compiled::Compiled;
use crate::ffi_call::{Calls, Line, cell_values, enter};
use crate::inputs;
use crate::layout::{CellAddress, Layout};
use crate::program::{Call, Making};

/// Runs a group for batches of points. One for each thread. Lanes from 16 on are those of the second batch.
pub struct Lanes<'a> {
    code: &'a Compiled,
    memory: Vec<Line>,
    /// Those of its last call, if layers are run one by one.
    held: Vec<Points>,
    /// Of each batch.
    works: Vec<Work<'a>>,
}

/// What is done outside of code for a batch.
struct Work<'a> {
    code: &'a Compiled,
    /// Its first lane in the code's memory.
    first: usize,
    machine: Machine<'a>,
    /// Of each lane; none as long as nothing is done lane by lane.
    messages: Vec<Vec<Message>>,
    events: Vec<(usize, Event)>,
    /// The lane whose point and messages the machine has.
    lane: usize,
    /// Points that were stopped in this batch.
    stopped: u32,
}

impl<'a> Lanes<'a> {
    /// For a group and the world around it.
    #[must_use]
    pub fn new(code: &'a Compiled, host: &'a dyn Host) -> Self {
        Self::of(code, &code.plan, host)
    }

    /// The same for an equivalent plan.
    fn of(code: &'a Compiled, plan: &'a Plan, host: &'a dyn Host) -> Self {
        let pooled = code.memories.lock().ok().and_then(|mut list| list.pop());
        let memory = pooled.unwrap_or_else(|| code.template.clone());
        let work = |first: usize| Work {
            code,
            first,
            machine: Machine::within(plan, host, plan.lend()),
            messages: Vec::new(),
            events: Vec::new(),
            lane: usize::MAX,
            stopped: 0,
        };
        let works = (0..code.lanes()).step_by(LANES).map(work).collect();
        Self { code, memory, held: Vec::new(), works }
    }

    /// Runs the group for some points, at most one for each lane; outputs are then read with
    /// [`output`](Self::output). Earlier messages are dropped.
    pub fn run(&mut self, points: &Points) {
        self.run_all(std::slice::from_ref(points));
    }

    /// The same for two batches, or one.
    ///
    /// # Panics
    /// If there are more points than lanes.
    pub fn run_all(&mut self, points: &[Points]) {
        self.ready(points);
        let Some(last) = self.code.layers.len().checked_sub(1) else { return };
        for layer in 0..last {
            if !self.code.plan.layers[layer].lazy {
                self.enter(layer, points);
            }
        }
        self.enter(last, points);
    }

    /// Points at once, at most.
    #[must_use]
    pub fn width(&self) -> usize {
        self.code.lanes()
    }

    /// Readies for two batches, or one, without running a layer.
    ///
    /// # Panics
    /// If there are more points than lanes.
    pub fn begin(&mut self, points: &[Points]) {
        self.held.clear();
        self.held.extend_from_slice(points);
        self.ready(points);
    }

    fn ready(&mut self, points: &[Points]) {
        let code = self.code;
        let most = code.lanes().min(LANES);
        let fits = points.len() <= self.works.len() && points.iter().all(|points| points.count <= most);
        assert!(fits, "{} batches of points for {} lanes", points.len(), code.lanes());
        for &(start, count) in &code.resets {
            self.memory[start..start + count].copy_from_slice(&code.template[start..start + count]);
        }
        let memory = cell_values(&mut self.memory);
        memory[Layout::FUEL as usize / 4] = code.fuel();
        for &flag in &code.program.flags {
            memory[Layout::slot(flag) as usize / 4] = 0;
        }
        for work in &mut self.works {
            if !code.program.calls.is_empty() {
                work.start();
            }
        }
        for (work, points) in self.works.iter().zip(points) {
            inputs::write(code.level, &code.inputs, points, memory, work.first);
        }
    }

    /// Runs a layer for all points that have not run it.
    pub fn layer(&mut self, layer: usize) {
        let points = std::mem::take(&mut self.held);
        self.enter(layer, &points);
        self.held = points;
    }

    fn enter(&mut self, layer: usize, points: &[Points]) {
        let bits = |(half, points): (usize, &Points)| ((1_u32 << points.count) - 1) << (half * LANES);
        let all = points.iter().enumerate().map(bits).fold(0, |all, bits| all | bits);
        if all == 0 {
            return;
        }
        cell_values(&mut self.memory)[Layout::EXEC as usize / 4] = all;
        let mut batch = Batch { works: &mut self.works, points };
        enter(&self.code.code, self.code.layers[layer], &mut self.memory, &mut batch);
    }

    /// The messages, by lanes in order.
    pub fn take_events(&mut self) -> Vec<(usize, Event)> {
        let mut all = Vec::new();
        for work in &mut self.works {
            all.extend(work.take_events().into_iter().map(|(lane, event)| (work.first + lane, event)));
        }
        all
    }

    /// The batch of a lane.
    fn work(&self, lane: usize) -> &Work<'a> {
        &self.works[lane / LANES]
    }

    /// The value and type of a layer's output, or of `Ci` and other globals that it writes, for a point.
    #[must_use]
    pub fn output(&self, lane: usize, layer: Option<usize>, name: &str) -> Option<(Type, Data)> {
        let plan = &self.code.plan;
        let slot = match (layer, plan.globals.get(name)) {
            (None, Some(slot)) => *slot,
            _ => {
                let code = plan.layers.get(layer?)?;
                code.slots[code.shader.find(name)? as usize]
            }
        };
        let cell_values = self.cell_values(&slot, lane);
        let texts = self.work(lane).machine.texts();
        let data = match slot.ty.base {
            Base::String => Data::Str(cell_values.iter().map(|&w| texts.text(w).clone()).collect()),
            Base::Int | Base::Closure => Data::Int(cell_values.iter().map(|&w| w as i32).collect()),
            _ => Data::Float(cell_values.iter().map(|&w| f32::from_bits(w)).collect()),
        };
        Some((slot.ty, data))
    }

    fn cell_values(&self, slot: &Slot, lane: usize) -> Vec<u32> {
        let at = |cell: u32| {
            let at = match self.code.layout.address(cell) {
                CellAddress::Each(at) => at as usize / 4 + lane,
                CellAddress::One(at) => at as usize / 4,
            };
            self.memory[at / 16].0[at % 16]
        };
        (slot.at..slot.at + slot.size).map(at).collect()
    }

    /// The number of the closure in a point's `Ci`; see [`components`](Self::components).
    #[must_use]
    pub fn ci(&self, lane: usize) -> u32 {
        let slot = self.code.plan.globals.get("Ci");
        slot.map_or(0, |slot| self.cell_values(slot, lane).first().copied().unwrap_or(0))
    }

    /// The components of a point's closure with their weights, in order.
    #[must_use]
    pub fn components(&self, number: u32, lane: usize) -> Vec<([f32; 3], Component)> {
        self.work(lane).machine.components_of(number, lane % LANES)
    }
}

/// Where the values of a batch are: from lane `first` on.
#[derive(Clone, Copy)]
struct Place<'m> {
    layout: &'m Layout,
    first: usize,
}

impl Place<'_> {
    fn get(self, memory: &[u32], cell: u32, lane: usize) -> u32 {
        match self.layout.address(cell) {
            CellAddress::Each(at) => memory[at as usize / 4 + self.first + lane],
            CellAddress::One(at) => memory[at as usize / 4],
        }
    }

    fn set(self, memory: &mut [u32], cell: u32, lane: usize, bits: u32) {
        match self.layout.address(cell) {
            CellAddress::Each(at) => memory[at as usize / 4 + self.first + lane] = bits,
            CellAddress::One(at) => memory[at as usize / 4] = bits,
        }
    }

    fn cells(self, memory: &[u32], cell: u32) -> Cells<'_> {
        self.at(memory, self.number(cell))
    }

    /// Where a cell is, in any batch: twice its word, and one more for a row.
    fn number(self, cell: u32) -> u32 {
        match self.layout.address(cell) {
            CellAddress::One(at) => (at / 4) << 1,
            CellAddress::Each(at) => (at / 4) << 1 | 1,
        }
    }

    /// What is at a place of such a number.
    #[inline(always)]
    fn at(self, memory: &[u32], number: u32) -> Cells<'_> {
        let word = (number >> 1) as usize;
        if number & 1 == 0 {
            return Cells::One(memory[word]);
        }
        memory[word + self.first..].first_chunk().map_or(Cells::One(0), Cells::Each)
    }
}

/// The values of a batch that is run.
struct Held<'m> {
    place: Place<'m>,
    memory: &'m mut [u32],
}

impl RunningBatch for Held<'_> {
    fn get(&self, cell: u32) -> Cells<'_> {
        self.place.cells(self.memory, cell)
    }

    fn put(&mut self, cell: u32, lanes: u32, cell_values: &[u32; LANES]) {
        match self.place.layout.address(cell) {
            CellAddress::One(at) => {
                self.memory[at as usize / 4] = cell_values[lanes.trailing_zeros() as usize % LANES]
            }
            CellAddress::Each(at) => {
                let row = &mut self.memory[at as usize / 4 + self.place.first..][..LANES];
                if lanes == 0xffff {
                    row.copy_from_slice(cell_values);
                    return;
                }
                for (lane, (to, &bits)) in row.iter_mut().zip(cell_values).enumerate() {
                    *to = if lanes >> lane & 1 != 0 { bits } else { *to };
                }
            }
        }
    }
}

impl Compiled {
    /// Runs it for a plan that means the same, which counts the points that were stopped. Each batch has its results.
    pub(crate) fn run_for(&self, plan: &Plan, host: &dyn Host, points: &[Points], out: &mut [Results]) {
        let rows = self.retained.iter().map(|(pooled, _)| pooled.row + pooled.ty.size()).max().unwrap_or(0);
        for out in &mut *out {
            out.events.clear();
            out.closures.clear();
            out.ci = [0; 16];
            out.rows.clear();
            out.rows.resize(rows, [0.0; 16]);
        }
        if plan.is_left_out() {
            return;
        }
        let mut lanes = Lanes::of(self, plan, host);
        for (work, out) in lanes.works.iter_mut().zip(&mut *out) {
            work.machine.change_closures(&mut out.closures);
        }
        lanes.run_all(points);
        let Lanes { mut memory, mut works, .. } = lanes;
        for ((work, points), out) in works.iter_mut().zip(points).zip(out) {
            work.end(cell_values(&mut memory), plan, points, out);
        }
        if let Ok(mut memories) = self.memories.lock() {
            memories.push(memory);
        }
        for work in works {
            plan.take_back(work.machine.into_memory());
        }
    }
}

impl Program for Compiled {
    fn run(&self, host: &dyn Host, points: &Points, out: &mut Results) {
        self.run_for(&self.plan, host, std::slice::from_ref(points), std::slice::from_mut(out));
    }

    fn run_pair(&self, host: &dyn Host, points: &[Points; 2], out: &mut [Results; 2]) {
        if self.lanes() > LANES {
            self.run_for(&self.plan, host, points, out);
            return;
        }
        points.iter().zip(out).for_each(|(points, out)| self.run(host, points, out));
    }

    fn describe_point(&self, host: &dyn Host, point: &Point) -> Vec<String> {
        self.plan.describe_point(host, point)
    }

    fn retained(&self) -> &[RetainedOutput] {
        self.plan.retained()
    }
}

/// The points that are run, while code runs.
struct Batch<'w, 'a> {
    works: &'w mut [Work<'a>],
    points: &'w [Points],
}

impl Calls for Batch<'_, '_> {
    fn call(&mut self, memory: &mut [u32], number: u32) {
        for (work, points) in self.works.iter_mut().zip(self.points) {
            let running = memory[Layout::EXEC as usize / 4] >> work.first & 0xffff;
            if running != 0 {
                work.call(memory, number, running, points);
            }
        }
    }
}

impl Work<'_> {
    /// Readies for a batch.
    fn start(&mut self) {
        self.machine.start();
        self.events.clear();
        self.stopped = 0;
        for list in &mut self.messages {
            list.clear();
        }
        self.lane = usize::MAX;
    }

    /// The messages, by its lanes in order.
    fn take_events(&mut self) -> Vec<(usize, Event)> {
        let mut events = std::mem::take(&mut self.events);
        events.sort_by_key(|(lane, _)| *lane);
        events
    }

    fn place(&self) -> Place<'_> {
        Place { layout: &self.code.layout, first: self.first }
    }

    /// Writes the results of its batch.
    fn end(&mut self, memory: &[u32], plan: &Plan, points: &Points, out: &mut Results) {
        out.events.append(&mut self.take_events());
        let place = Place { layout: &self.code.layout, first: self.first };
        if let Some(slot) = plan.globals.get("Ci") {
            for (lane, ci) in out.ci.iter_mut().enumerate().take(points.count) {
                *ci = place.get(memory, slot.at, lane);
            }
        }
        for (pooled, slot) in &self.code.retained {
            for k in 0..pooled.ty.size() {
                let row = &mut out.rows[pooled.row + k];
                for (lane, x) in row.iter_mut().enumerate().take(points.count) {
                    let bits = place.get(memory, slot.at + k as u32, lane);
                    *x = if slot.ty.base == Base::Int { bits as i32 as f32 } else { f32::from_bits(bits) };
                }
            }
        }
        for _ in 0..self.stopped {
            out.events.extend(plan.strike().map(|event| (0, event)));
        }
        self.machine.change_closures(&mut out.closures);
    }

    /// Does a call for some of its lanes.
    fn call(&mut self, memory: &mut [u32], number: u32, running: u32, points: &Points) {
        let work = self;
        let code = work.code;
        let place = Place { layout: &code.layout, first: work.first };
        match &code.program.calls[number as usize] {
            Call::Step { layer, step, ins, outs } => {
                work.one_by_one(memory, (points, running), *layer, step, (ins, outs));
            }
            Call::Together { layer, step, ins, outs } => {
                let mut held = Held { place, memory: &mut *memory };
                if !work.machine.run_batched(step, running, points, &mut held) {
                    work.one_by_one(memory, (points, running), *layer, step, (ins, outs));
                }
            }
            Call::Closure(making) => {
                let Making { layer, step, ins, outs, is_named } = &**making;
                let held = &*memory;
                let read = |cell: u32| place.cells(held, cell);
                let machine = &mut work.machine;
                let bound = code.bounds[number as usize].get_or_init(|| {
                    // Arguments that are not brought are constants.
                    let is_fixed = |cell: u32| {
                        !ins.iter().any(|slot| (slot.at..slot.at + slot.cells() as u32).contains(&cell))
                    };
                    let bind = || machine.bind_component(step, read, is_fixed, |cell| place.number(cell));
                    is_named.then(bind).flatten()
                });
                let at = |number: u32| place.at(held, number);
                let made = bound.as_ref().and_then(|bound| machine.make_component(bound, at));
                let made = made.map(|number| [number; LANES]);
                match made.or_else(|| machine.make_closures(step, running, read)) {
                    Some(made) => Held { place, memory }.put(step.args[0].at, running, &made),
                    // The reason.
                    None => work.one_by_one(memory, (points, running), *layer, step, (ins, outs)),
                }
            }
            Call::Userdata { layer, param, given } => {
                let mut found = 0;
                let param = &code.plan.layers[*layer].params[*param];
                let slot = code.plan.layers[*layer].slots[param.symbol as usize];
                for lane in lanes_of(running) {
                    work.change_lane(points, lane);
                    work.bring(memory, lane, &slot);
                    if work.machine.fetch_userdata(*layer, param) {
                        found |= 1 << lane;
                        work.fetch(memory, lane, &slot);
                    }
                    work.collect_events(lane);
                }
                let word = &mut memory[Layout::slot(*given) as usize / 4];
                *word = *word & !(0xffff << work.first) | found << work.first;
            }
            Call::Stopped { layer, at } => {
                for lane in lanes_of(running) {
                    work.change_lane(points, lane);
                    work.machine.report_stopped(*layer, *at, code.plan.iterations);
                    work.stopped += 1;
                    work.collect_events(lane);
                }
            }
        }
    }

    /// Gives the machine a lane's point and messages.
    fn change_lane(&mut self, points: &Points, lane: usize) {
        if self.lane == lane {
            return;
        }
        self.messages.resize_with(LANES, Vec::new);
        let messages = std::mem::take(&mut self.messages[lane]);
        let before = self.machine.change_point(&points.point(lane), lane, messages);
        if let Some(list) = self.messages.get_mut(self.lane) {
            *list = before;
        }
        self.lane = lane;
    }

    /// Does an operation for each lane of a set of bits by itself.
    fn one_by_one(
        &mut self,
        memory: &mut [u32],
        (points, lanes): (&Points, u32),
        layer: usize,
        step: &Step,
        (ins, outs): (&[Slot], &[Slot]),
    ) {
        for lane in lanes_of(lanes) {
            self.change_lane(points, lane);
            self.step(memory, lane, layer, step, ins, outs);
            self.collect_events(lane);
        }
    }

    fn collect_events(&mut self, lane: usize) {
        if !self.machine.events.is_empty() {
            self.events.extend(self.machine.events.drain(..).map(|event| (lane, event)));
        }
    }

    /// From a lane to the machine.
    fn bring(&mut self, memory: &[u32], lane: usize, slot: &Slot) {
        let place = Place { layout: &self.code.layout, first: self.first };
        let cells = self.machine.cells();
        for cell in slot.at..slot.at + slot.cells() as u32 {
            cells[cell as usize] = place.get(memory, cell, lane);
        }
    }

    /// And back.
    fn fetch(&mut self, memory: &mut [u32], lane: usize, slot: &Slot) {
        let place = Place { layout: &self.code.layout, first: self.first };
        let cells = self.machine.cells();
        for cell in slot.at..slot.at + slot.cells() as u32 {
            place.set(memory, cell, lane, cells[cell as usize]);
        }
    }

    fn step(
        &mut self,
        memory: &mut [u32],
        lane: usize,
        layer: usize,
        step: &Step,
        ins: &[Slot],
        outs: &[Slot],
    ) {
        if let Some((array, part)) = self.element(memory, lane, step) {
            // Only the element is brought, not the array.
            for slot in ins.iter().filter(|slot| slot.at != array.at) {
                self.bring(memory, lane, slot);
            }
            for k in 0..if array.derivs { 3 } else { 1 } {
                let mut part = part;
                part.at += k * array.size;
                self.bring(memory, lane, &part);
            }
            self.machine.perform(layer, step);
            for slot in outs {
                if slot.at != array.at {
                    self.fetch(memory, lane, slot);
                    continue;
                }
                for k in 0..if array.derivs { 3 } else { 1 } {
                    let mut part = part;
                    part.at += k * array.size;
                    self.fetch(memory, lane, &part);
                }
            }
            return;
        }
        for slot in ins {
            self.bring(memory, lane, slot);
        }
        self.machine.perform(layer, step);
        for slot in outs {
            self.fetch(memory, lane, slot);
        }
    }

    /// The array that an operation takes one element of, and that element's cells, if the index is in range.
    fn element(&self, memory: &[u32], lane: usize, step: &Step) -> Option<(Slot, Slot)> {
        let (array, index) = match (step.code, &*step.args) {
            (Opcode::Aref, [_, array, index]) => (array, index),
            (Opcode::Aassign, [array, index, _]) => (array, index),
            _ => return None,
        };
        if index.ty != Type::INT || array.size <= 1 {
            return None;
        }
        let index = self.place().get(memory, index.at, lane) as i32;
        let index = usize::try_from(index).ok().filter(|&i| i < array.ty.elements())?;
        let mut part = *array;
        part.at += index as u32 * array.one;
        part.size = array.one;
        part.derivs = false;
        Some((*array, part))
    }
}
