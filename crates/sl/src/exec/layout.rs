// SPDX-License-Identifier: GPL-3.0-or-later
//! A group laid out in memory, its operations bound to functions. The lazy evaluation of layers follows OSL.

use super::known::fill;
use super::machine::{Copy, Flow, Instruction, LayerPlan, Loop, Param, Plan, Source, Step};
use super::nesting;
use super::run::{POINT_GLOBALS, work_of};
use super::slot::{RetainedOutput, Slot};
use super::strings::Strings;
use super::table::action;
use crate::group::{Group, Layer, Part};
use crate::hir::Data;
use crate::ir::{Block, Node, Op, Shader, SymId, SymbolKind, Use, ops, uses};
use crate::opcode::Opcode;
use crate::passes::{fixed, fold, mark_derivatives, optimise};
use crate::types::{Base, Type};
use std::collections::{HashMap, HashSet};
use std::sync::atomic::AtomicU32;
use std::sync::{Arc, Mutex};

/// How groups are run.
#[derive(Clone, Debug)]
pub struct PlanOptions {
    /// Requested outputs: `name` or `layer.name`; their layers run in any case.
    pub outputs: Vec<String>,
    /// Layers that write globals wait until they are needed.
    pub lazy_globals: bool,
    /// Layers that trace rays wait.
    pub lazy_trace: bool,
    /// Layers that call `error` wait.
    pub lazy_error: bool,
    /// All layers wait.
    pub lazy_layers: bool,
    /// Layers that nothing is connected to wait.
    pub lazy_unconnected: bool,
    /// Parameters that come from the geometry count as connected.
    pub userdata_isconnected: bool,
    /// Prints when a layer starts and ends.
    pub debug_layers: bool,
    /// Layers that may be started by themselves.
    pub entries: Vec<usize>,
    /// Iterations of loops that a point may take before it is stopped.
    pub iterations: u64,
    /// Evaluates known values beforehand, and leaves out unused operations.
    pub optimise: bool,
    /// Leaves out outputs that are neither requested nor connected.
    pub drops_outputs: bool,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            outputs: Vec::new(),
            lazy_globals: true,
            lazy_trace: true,
            lazy_error: true,
            lazy_layers: true,
            lazy_unconnected: true,
            userdata_isconnected: false,
            debug_layers: false,
            entries: Vec::new(),
            iterations: 20_000_000,
            optimise: true,
            drops_outputs: false,
        }
    }
}

/// Cells of a group: each thread that runs it has as many. Networks of a thousand layers have a few millions.
const CELLS: usize = 1 << 24;

const GLOBALS: [(&str, Type); 13] = [
    ("P", Type::POINT),
    ("I", Type::VECTOR),
    ("N", Type::NORMAL),
    ("Ng", Type::NORMAL),
    ("u", Type::FLOAT),
    ("v", Type::FLOAT),
    ("dPdu", Type::VECTOR),
    ("dPdv", Type::VECTOR),
    ("Ps", Type::POINT),
    ("Ci", Type::CLOSURE),
    ("time", Type::FLOAT),
    ("dtime", Type::FLOAT),
    ("dPdtime", Type::VECTOR),
];

/// Additional globals of lights, cameras and pixels, with their initial values.
const GLOBALS_OF_KINDS: [(&str, Type, f32); 9] = [
    ("L", Type::VECTOR, 0.0),
    ("Cl", Type::COLOR, 0.0),
    ("lightdist", Type::FLOAT, 0.0),
    ("lightpdf", Type::FLOAT, 0.0),
    ("xi", Type::FLOAT.array_of(2), 0.0),
    ("raster", Type::POINT, 0.0),
    ("tmin", Type::FLOAT, 0.0),
    ("tmax", Type::FLOAT, 1e30),
    ("weight", Type::COLOR, 1.0),
];

impl Plan {
    /// Lays out a group.
    ///
    /// # Errors
    /// An unknown operation, with its position; a group that is too large.
    pub fn new(group: &Group, options: &PlanOptions) -> Result<Self, String> {
        let mut plan = Self {
            name: group.name.clone(),
            layers: Vec::new(),
            globals: HashMap::new(),
            memory: Vec::new(),
            strings: Strings::default(),
            debug_layers: options.debug_layers,
            entries: options.entries.clone(),
            iterations: options.iterations,
            of_points: [None; 14],
            retained: Vec::new(),
            retained_slots: Vec::new(),
            strikes: AtomicU32::new(0),
            memories: Mutex::default(),
        };
        for (name, ty) in GLOBALS {
            let slot = plan.allocate(ty, ty.base != Base::Closure)?;
            plan.globals.insert(name.into(), slot);
        }
        let is_wanted = |number: usize, id: SymId| {
            let layer = &group.layers[number];
            is_requested(layer, &layer.shader.symbol(id).name, options)
        };
        // Layers that are started or shown by themselves stay as they are.
        let is_closed = options.optimise && options.entries.is_empty() && !options.debug_layers;
        let best = is_closed.then(|| optimise(group, &is_wanted, options.drops_outputs));
        let best = best.as_ref().unwrap_or(group);
        let shaders = prepared(best, options.optimise && !is_closed);
        for (number, shader) in shaders.into_iter().enumerate() {
            plan.layer(group, best, number, shader, options)?;
        }
        nesting::bound(&mut plan.layers);
        plan.of_points = POINT_GLOBALS.map(|name| plan.globals.get(name).copied());
        let mut row = 0;
        for name in &options.outputs {
            let Some(slot) = plan.slot_of(name) else { continue };
            if matches!(slot.ty.base, Base::String | Base::Closure) {
                continue;
            }
            plan.retained.push(RetainedOutput { name: name.clone(), ty: slot.ty, row });
            plan.retained_slots.push(slot);
            row += slot.ty.size();
        }
        Ok(plan)
    }

    /// The slot of `layer.name`, of `name` in the last layer that has it, or of a global.
    pub(super) fn slot_of(&self, name: &str) -> Option<Slot> {
        let of = |layer: &LayerPlan, name: &str| {
            let id = layer.shader.find(name).filter(|&id| layer.shader.symbol(id).kind.is_param())?;
            Some(layer.slots[id as usize])
        };
        if let Some((layer, name)) = name.split_once('.')
            && let Some(found) = self.layers.iter().rev().find(|l| *l.name == *layer)
        {
            return of(found, name);
        }
        let found = self.layers.iter().rev().find_map(|layer| of(layer, name));
        found.or_else(|| self.globals.get(name).copied())
    }

    /// How many layers there are.
    #[must_use]
    pub fn layer_count(&self) -> usize {
        self.layers.len()
    }

    fn allocate(&mut self, ty: Type, derivs: bool) -> Result<Slot, String> {
        let slot = Slot::new(self.memory.len(), ty, derivs);
        let end = self.memory.len() + slot.cells();
        if end > CELLS {
            return Err(format!("with it the group has more than {CELLS} numbers; make arrays shorter"));
        }
        self.memory.resize(end, 0);
        Ok(slot)
    }

    /// The slot of a global; those of lights, cameras and pixels get one when they are first named.
    fn global(&mut self, name: &str) -> Result<Option<Slot>, String> {
        if let Some(slot) = self.globals.get(name) {
            return Ok(Some(*slot));
        }
        let Some((name, ty, start)) = GLOBALS_OF_KINDS.iter().find(|known| known.0 == name) else {
            return Ok(None);
        };
        let slot = self.allocate(*ty, true)?;
        fill(&mut self.memory, &slot, &Data::Float(vec![*start; ty.size()]), &mut self.strings);
        self.globals.insert((*name).into(), slot);
        Ok(Some(slot))
    }

    fn layer(
        &mut self,
        original: &Group,
        group: &Group,
        number: usize,
        shader: Arc<Shader>,
        options: &PlanOptions,
    ) -> Result<(), String> {
        let layer = &group.layers[number];
        let mut slots = Vec::with_capacity(shader.symbols.len());
        for (id, symbol) in shader.symbols.iter().enumerate() {
            if symbol.kind == SymbolKind::Global
                && let Some(slot) = self.global(&symbol.name)?
            {
                slots.push(slot);
                continue;
            }
            let mut ty = symbol.ty;
            let given = layer.values.get(&(id as SymId)).or(symbol.value.as_ref());
            if ty.array < 0 {
                let count = given.map_or(0, Data::count) / ty.base.components().max(1);
                ty = ty.array_of(i32::try_from(count.max(1)).unwrap_or(1));
            }
            let slot = self.allocate(ty, symbol.derivs && ty.base.is_float_based());
            let slot =
                slot.map_err(|why| format!("shader {}: '{}' ({ty}): {why}", shader.name, symbol.name))?;
            if let Some(data) = given {
                fill(&mut self.memory, &slot, data, &mut self.strings);
            }
            slots.push(slot);
        }
        let mut connected = vec![0_u8; shader.symbols.len()];
        // Parameters whose values connections give all of.
        let mut is_whole = vec![false; shader.symbols.len()];
        let mut copies = Vec::new();
        for c in &original.connections {
            if c.from_layer == number {
                mark(&shader, &mut connected, c.from.symbol, 2);
            }
            if c.to_layer == number {
                mark(&shader, &mut connected, c.to.symbol, 1);
            }
        }
        let mut reads = vec![false; shader.symbols.len()];
        for c in &group.connections {
            if c.to_layer == number {
                reads[c.to.symbol as usize] = true;
                is_whole[c.to.symbol as usize] |= c.to.element.is_none() && c.to.component.is_none();
                let (from, from_derivs) = self.part(c.from_layer, &c.from);
                let (to, to_derivs) = cut(slots[c.to.symbol as usize], &c.to);
                copies.push(Copy {
                    layer: c.from_layer,
                    from,
                    from_derivs,
                    to,
                    to_derivs,
                    to_symbol: c.to.symbol,
                });
            }
        }
        for output in &options.outputs {
            let name = match output.split_once('.') {
                Some((l, name)) if l == &*layer.name => name,
                _ => output,
            };
            if let Some(id) =
                shader.find(name).filter(|&id| shader.symbol(id).kind == SymbolKind::OutputParam)
            {
                connected[id as usize] |= 2;
            }
        }
        if options.userdata_isconnected {
            shader
                .params()
                .filter(|(id, symbol)| symbol.ty.struct_id().is_none() && layer.interpolated(*id))
                .for_each(|(id, _)| connected[id as usize] |= 1);
        }
        let constant = constants(group, number, &shader);
        let binder = Binder {
            shader: &shader,
            slots: &slots,
            reads: &reads,
            connected: &connected,
            constant: &constant,
        };
        let code = binder.block(&shader.code)?;
        let mut params = Vec::new();
        for (id, symbol) in shader.params() {
            if symbol.ty.struct_id().is_some() {
                continue;
            }
            let interpolated = layer.interpolated(id);
            let whole = is_whole[id as usize];
            let source = match (reads[id as usize], interpolated) {
                (true, _) => Source::Connected,
                (_, true) => Source::Geometry,
                _ => Source::Value,
            };
            let init =
                if layer.values.contains_key(&id) { Vec::new() } else { binder.block(&symbol.init)? };
            if source != Source::Value || !init.is_empty() {
                params.push(Param { symbol: id, source, whole, init });
            }
        }
        let lazy = number + 1 != group.layers.len() && waits(group, number, &shader, options);
        self.layers.push(LayerPlan {
            name: layer.name.clone(),
            shader,
            slots,
            params,
            copies,
            code,
            lazy,
            depth: 0,
            connected,
            constant,
        });
        Ok(())
    }

    fn part(&self, layer: usize, part: &Part) -> (Slot, u32) {
        cut(self.layers[layer].slots[part.symbol as usize], part)
    }
}

/// Marks a member's struct as well.
fn mark(shader: &Shader, connected: &mut [u8], id: SymId, bit: u8) {
    let mut at = Some(id);
    while let Some(id) = at {
        connected[id as usize] |= bit;
        at = shader.symbol(id).member_of.map(|m| m.0);
    }
}

/// The stretch that a part is, and the cells between its value and derivatives if that is not its own size.
fn cut(slot: Slot, part: &Part) -> (Slot, u32) {
    if part.element.is_none() && part.component.is_none() {
        return (slot, 0);
    }
    let offset = part.element.unwrap_or(0) * slot.one + part.component.unwrap_or(0);
    let stride = if slot.derivs { slot.size } else { 0 };
    let mut inner = Slot::new((slot.at + offset) as usize, part.ty, false);
    inner.derivs = false;
    (inner, stride)
}

/// Whether an output is requested, by its name or with its layer's.
fn is_requested(layer: &Layer, name: &str, options: &PlanOptions) -> bool {
    options.outputs.iter().any(|output| {
        output == name || output.split_once('.').is_some_and(|(l, n)| *l == *layer.name && n == name)
    })
}

fn waits(group: &Group, number: usize, shader: &Shader, options: &PlanOptions) -> bool {
    let layer = &group.layers[number];
    let has = |code: Opcode| {
        let mut found = false;
        ops(&shader.code, &mut |op| found |= op.code == code);
        found
    };
    let mut writes_globals = false;
    uses(&shader.code, &mut |id, usage| {
        writes_globals |= usage == Use::Write && shader.symbol(id).kind == SymbolKind::Global;
    });
    let outgoing = group.connections.iter().any(|c| c.from_layer == number);
    let expected = shader
        .params()
        .any(|(_, s)| s.kind == SymbolKind::OutputParam && is_requested(layer, &s.name, options));
    options.lazy_layers
        && (options.lazy_globals || !writes_globals)
        && !expected
        && (outgoing || options.lazy_unconnected)
        && (options.lazy_error || !has(Opcode::Error))
        && (options.lazy_trace || !has(Opcode::Trace))
}

/// Symbols of a layer that connections lead to.
fn fed(group: &Group, number: usize) -> HashSet<SymId> {
    group.connections.iter().filter(|c| c.to_layer == number).map(|c| c.to.symbol).collect()
}

/// The shaders without the parts that their parameters disable, with derivatives of outputs where their
/// connections need them.
fn prepared(group: &Group, folds: bool) -> Vec<Arc<Shader>> {
    let mut shaders: Vec<Arc<Shader>> = group.layers.iter().map(|l| l.shader.clone()).collect();
    for (number, shader) in shaders.iter_mut().enumerate().filter(|_| folds) {
        fold(Arc::make_mut(shader), &fixed(group, number));
    }
    for number in (0..shaders.len()).rev() {
        let pending: Vec<SymId> = group
            .connections
            .iter()
            .filter(|c| c.from_layer == number && shaders[c.to_layer].symbol(c.to.symbol).derivs)
            .map(|c| c.from.symbol)
            .filter(|&id| !shaders[number].symbol(id).derivs)
            .collect();
        if pending.is_empty() {
            continue;
        }
        let shader = Arc::make_mut(&mut shaders[number]);
        for id in pending {
            shader.symbols[id as usize].derivs = true;
        }
        mark_derivatives(shader);
    }
    shaders
}

struct Binder<'a> {
    shader: &'a Shader,
    slots: &'a [Slot],
    /// By symbol, whether connections lead to it.
    reads: &'a [bool],
    connected: &'a [u8],
    constant: &'a [bool],
}

impl Binder<'_> {
    fn pulls(&self, symbols: impl Iterator<Item = SymId>) -> Box<[u32]> {
        symbols.filter(|&id| self.reads[id as usize]).collect()
    }

    fn block(&self, block: &Block) -> Result<Vec<Instruction>, String> {
        block.iter().map(|node| self.node(node)).collect()
    }

    fn node(&self, node: &Node) -> Result<Instruction, String> {
        let slot = |id: SymId| self.slots[id as usize];
        let pull = |id: SymId| self.pulls(std::iter::once(id));
        Ok(match node {
            Node::Op(op) => self.operation(op)?,
            Node::If { condition, yes, no, .. } => Instruction::If {
                condition: slot(*condition),
                pulls: pull(*condition),
                yes: self.block(yes)?,
                no: self.block(no)?,
            },
            Node::Loop { keyword, init, test, condition, body, step, at } => {
                Instruction::Loop(Box::new(Loop {
                    body_first: *keyword == "dowhile",
                    init: self.block(init)?,
                    test: self.block(test)?,
                    condition: slot(*condition),
                    pulls: pull(*condition),
                    body: self.block(body)?,
                    step: self.block(step)?,
                    at: *at,
                }))
            }
            Node::Call { body, .. } => Instruction::Call(self.block(body)?),
        })
    }

    /// The answer of an operation about its operands.
    fn answer(&self, op: &Op) -> i32 {
        let Some(id) = op.args.get(1).map(|&id| id as usize) else { return 0 };
        match op.code {
            Opcode::ArrayLength => self.slots[id].ty.array,
            Opcode::IsConnected => self.connected[id].into(),
            Opcode::IsConstant => self.constant[id].into(),
            _ => 0,
        }
    }

    fn operation(&self, op: &Op) -> Result<Instruction, String> {
        let flow = match op.code {
            Opcode::Break => Some(Flow::Break),
            Opcode::Continue => Some(Flow::Continue),
            Opcode::Return => Some(Flow::Return),
            Opcode::Exit => Some(Flow::Exit),
            _ => None,
        };
        if let Some(flow) = flow {
            return Ok(Instruction::Leave(flow));
        }
        let args: Box<[Slot]> = op.args.iter().map(|&id| self.slots[id as usize]).collect();
        let Some(action) = action(op.code, &args) else {
            let file = self.shader.files.get(usize::from(op.at.file)).map_or("", |f| f);
            let name = match op.code {
                Opcode::Unknown => self.shader.unknown.as_deref().unwrap_or_default(),
                code => code.name(),
            };
            return Err(format!(
                "Parsing shader \"{}\": unknown instruction \"{}\" at {file}:{}",
                self.shader.name, name, op.at.line
            ));
        };
        // An operation about the parameter itself does not evaluate it.
        let pulls =
            if !op.code.is_about_operands() { self.pulls(op.args.iter().copied()) } else { [].into() };
        let symbols = op.args.clone().into();
        Ok(Instruction::Do(Step {
            code: op.code,
            action,
            work: work_of(op.code, &args),
            answer: self.answer(op),
            args,
            symbols,
            at: op.at,
            pulls,
            reads: op.reads,
            writes: op.writes,
        }))
    }
}

/// Symbols whose value is known before the group runs: constant parameters, and values computed from
/// constants alone.
fn constants(group: &Group, number: usize, shader: &Shader) -> Vec<bool> {
    let layer = &group.layers[number];
    let connected = fed(group, number);
    let mut known: Vec<bool> = shader
        .symbols
        .iter()
        .enumerate()
        .map(|(id, s)| {
            let id = id as SymId;
            let fixed = !connected.contains(&id) && !layer.interpolated(id) && !layer.interactive(id);
            match s.kind {
                SymbolKind::Const => true,
                SymbolKind::Param => fixed && (s.init.is_empty() || layer.values.contains_key(&id)),
                SymbolKind::Temp | SymbolKind::Local => true,
                _ => false,
            }
        })
        .collect();
    // A symbol written once, from known values, by a pure operation, is known.
    let mut writes = vec![0_u32; known.len()];
    uses(&shader.code, &mut |id, usage| writes[id as usize] += u32::from(usage == Use::Write));
    for (id, symbol) in shader.symbols.iter().enumerate() {
        if matches!(symbol.kind, SymbolKind::Temp | SymbolKind::Local) {
            known[id] = writes[id] == 1;
        }
    }
    let mut changed = true;
    while std::mem::take(&mut changed) {
        ops(&shader.code, &mut |op| {
            let unknown = op.code.asks()
                || op
                    .args
                    .iter()
                    .enumerate()
                    .any(|(i, &a)| op.is_read(i) && !op.is_written(i) && !known[a as usize]);
            for (i, &arg) in op.args.iter().enumerate() {
                if op.is_written(i) && unknown && std::mem::take(&mut known[arg as usize]) {
                    changed = true;
                }
            }
        });
    }
    known
}
