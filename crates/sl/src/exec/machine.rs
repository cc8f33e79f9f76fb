// SPDX-License-Identifier: GPL-3.0-or-later
//! The machine, the plan that it runs and the steps that plans are made of.
//! These types name each other, so they share a file.

use super::components::Closures;
use super::host::{Host, Point};
use super::slot::{RetainedOutput, Slot};
use super::strings::Strings;
use crate::ir::{Shader, SourcePosition, SymId};
use crate::opcode::Opcode;
use crate::types::Type;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::dictionary::Dictionaries;
use gnurt_sl_lib::regex::Regex;
use std::collections::HashMap;
use std::sync::atomic::AtomicU32;
use std::sync::{Arc, Mutex};

pub(super) type D = Dual<f32>;

/// The function of an operation.
pub(super) type Action = fn(&mut Machine<'_>, &Step);

/// An operation with its arguments.
#[derive(Clone)]
pub struct Step {
    /// The operation.
    pub code: Opcode,
    /// How the interpreter does it.
    pub(super) action: Action,
    /// How much of a point's work it counts as.
    pub(super) work: u32,
    /// The answer of operations about their operands: a length, whether they are connected or constant.
    pub answer: i32,
    /// The arguments; a result is the first.
    pub args: Box<[Slot]>,
    /// The arguments' symbols.
    pub symbols: Box<[SymId]>,
    /// Its position in the text.
    pub at: SourcePosition,
    /// Connected parameters that it reads.
    pub pulls: Box<[u32]>,
    /// Arguments that are read, by bits.
    pub reads: u64,
    /// Arguments that are written.
    pub writes: u64,
}

impl Step {
    /// An operation on numbers by itself.
    pub(super) fn of_numbers(code: Opcode, args: Box<[Slot]>) -> Self {
        let (symbols, pulls) = ([].into(), [].into());
        let at = SourcePosition::default();
        Self { code, action: |_, _| {}, work: 1, answer: 0, args, symbols, at, pulls, reads: !1, writes: 1 }
    }
}

/// A step or a block of them.
pub enum Instruction {
    /// An operation.
    Do(Step),
    /// A choice.
    If {
        /// An int.
        condition: Slot,
        /// Connected parameters that this reads.
        pulls: Box<[u32]>,
        /// If it is not 0.
        yes: Vec<Instruction>,
        /// If it is 0.
        no: Vec<Instruction>,
    },
    /// A loop.
    Loop(Box<Loop>),
    /// A function's body; `Return` leaves it.
    Call(Vec<Instruction>),
    /// Leaves a block.
    Leave(Flow),
}

/// A loop.
pub struct Loop {
    /// Whether the body comes before the first test.
    pub body_first: bool,
    /// Done once, before.
    pub init: Vec<Instruction>,
    /// Makes the condition.
    pub test: Vec<Instruction>,
    /// An int.
    pub condition: Slot,
    /// Connected parameters that this reads.
    pub pulls: Box<[u32]>,
    /// The body of each iteration.
    pub body: Vec<Instruction>,
    /// Run after each iteration.
    pub step: Vec<Instruction>,
    /// Its position in the text.
    pub at: SourcePosition,
}

/// How a block was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// By its end.
    Next,
    /// By `break`.
    Break,
    /// By `continue`.
    Continue,
    /// By `return`.
    Return,
    /// By `exit`.
    Exit,
}

/// Where a parameter's value comes from, unless its default is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The memory has it.
    Value,
    /// The geometry may have it.
    Geometry,
    /// A connection.
    Connected,
}

/// A parameter that is more than a value.
pub struct Param {
    /// Its number in the shader.
    pub symbol: SymId,
    /// Where its value comes from.
    pub source: Source,
    /// Whether the connection gives all of it.
    pub whole: bool,
    /// Done once, before.
    pub init: Vec<Instruction>,
}

/// A value to fetch along a connection.
pub struct Copy {
    /// The layer that it comes from.
    pub layer: usize,
    /// The operand.
    pub from: Slot,
    /// Cells between value and derivatives if `from` is a part of something larger; 0 otherwise.
    pub from_derivs: u32,
    /// The result.
    pub to: Slot,
    /// The same for the result.
    pub to_derivs: u32,
    /// The parameter that it is for.
    pub to_symbol: SymId,
}

/// A layer that is ready to run.
pub struct LayerPlan {
    /// Its name.
    pub name: Arc<str>,
    /// Its shader.
    pub shader: Arc<Shader>,
    /// By symbol, where it is.
    pub slots: Vec<Slot>,
    /// Parameters that are more than a value, in order.
    pub params: Vec<Param>,
    /// Values that come along connections.
    pub copies: Vec<Copy>,
    /// Its code.
    pub code: Vec<Instruction>,
    /// Whether it waits until it is needed.
    pub lazy: bool,
    /// How deep its blocks nest, itself counted.
    pub depth: usize,
    /// By symbol: bit 0 connected from above, bit 1 to below.
    pub connected: Vec<u8>,
    /// By symbol: whether its value is known before the group runs.
    pub constant: Vec<bool>,
}

/// A group that is ready to run.
pub struct Plan {
    /// Its name.
    pub name: String,
    /// Its layers, earlier ones first.
    pub layers: Vec<LayerPlan>,
    /// Where globals are, by name.
    pub globals: HashMap<Arc<str>, Slot>,
    /// Memory at the start of a point.
    pub memory: Vec<u32>,
    /// The texts that it names.
    pub strings: Strings,
    /// Whether layers print when they start and end.
    pub debug_layers: bool,
    /// Layers that may be started by themselves.
    pub entries: Vec<usize>,
    /// Iterations of loops that a point may take.
    pub iterations: u64,
    /// Where the numbers of a [`Point`] are, in the order of [`POINT_GLOBALS`](super::run::POINT_GLOBALS).
    pub(super) of_points: [Option<Slot>; 14],
    /// The outputs that [`Program`](super::Program) returns for each point.
    pub(super) retained: Vec<RetainedOutput>,
    /// Where they are.
    pub(super) retained_slots: Vec<Slot>,
    /// Points that were stopped.
    pub(super) strikes: AtomicU32,
    /// Memories that no batch uses now.
    pub(super) memories: Mutex<Vec<Memory>>,
}

/// A message of a layer for others, or a failed query.
#[derive(Clone, Debug)]
pub struct Message {
    pub(super) name: Arc<str>,
    pub(super) ty: Type,
    pub(super) cells_bits: Option<Vec<u32>>,
    pub(super) layer: usize,
    pub(super) source_position: String,
}

/// Output of a shader.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// By `printf`.
    Print(String),
    /// By `error`, or by a mistake.
    Error(String),
    /// By `warning`.
    Warning(String),
    /// By `fprintf`: the file's name and the text.
    File(String, String),
}

/// The cells that operations have written, and the number of each operation by its address.
pub(super) struct Unwritten {
    pub(super) written: Vec<bool>,
    pub(super) numbers: HashMap<usize, usize>,
}

/// Runs groups. One for each thread.
pub struct Machine<'a> {
    pub(super) plan: &'a Plan,
    pub(super) host: &'a dyn Host,
    pub(super) memory: Vec<u32>,
    pub(super) strings: Strings,
    pub(super) closures: Closures,
    pub(super) messages: Vec<Message>,
    pub(super) point: Point,
    /// The point's index in its batch.
    pub(super) lane: usize,
    /// The layer that runs.
    pub(super) layer: usize,
    pub(super) done: Vec<bool>,
    /// By layer and parameter, whether connected values have been fetched.
    pub(super) pulled: Vec<Vec<bool>>,
    /// Steps left for this point.
    pub(super) fuel: u64,
    /// Operations left for this point.
    pub(super) work: u64,
    /// Output since the last call.
    pub events: Vec<Event>,
    /// Bytes that this point, or this batch, has reported.
    pub(super) reports: usize,
    /// Nesting depth of the blocks around running layers.
    pub(super) nested: usize,
    /// Regular expressions that were read; none where one is wrong.
    pub(super) regexes: HashMap<Arc<str>, Option<Regex>>,
    /// Dictionaries that were queried.
    pub(super) dictionaries: Dictionaries,
    /// Whether results that are not finite are reported.
    pub(super) checks: bool,
    /// What has been written, if reads of the rest are reported.
    pub(super) unwritten: Option<Box<Unwritten>>,
}

/// The memory of a machine, between two uses.
pub struct Memory {
    cells: Vec<u32>,
    strings: Strings,
    done: Vec<bool>,
    pulled: Vec<Vec<bool>>,
    regexes: HashMap<Arc<str>, Option<Regex>>,
    dictionaries: Dictionaries,
}

impl Memory {
    /// For a group.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        Self {
            cells: plan.memory.clone(),
            strings: plan.strings.clone(),
            done: vec![false; plan.layers.len()],
            pulled: plan.layers.iter().map(|l| vec![false; l.slots.len()]).collect(),
            regexes: HashMap::new(),
            dictionaries: Dictionaries::default(),
        }
    }
}

impl<'a> Machine<'a> {
    /// A machine for a group.
    #[must_use]
    pub fn new(plan: &'a Plan, host: &'a dyn Host) -> Self {
        Self::within(plan, host, Memory::new(plan))
    }

    /// A machine in memory that was made for the same plan.
    #[must_use]
    pub fn within(plan: &'a Plan, host: &'a dyn Host, memory: Memory) -> Self {
        let Memory { cells, strings, done, pulled, regexes, dictionaries } = memory;
        Self {
            plan,
            host,
            memory: cells,
            strings,
            closures: Closures::default(),
            messages: Vec::new(),
            point: Point::default(),
            lane: 0,
            layer: 0,
            done,
            pulled,
            fuel: 0,
            work: 0,
            events: Vec::new(),
            reports: 0,
            nested: 0,
            regexes,
            dictionaries,
            checks: false,
            unwritten: None,
        }
    }

    /// From now on, reports results that are NaN or infinite.
    pub fn check_numbers(&mut self) {
        self.checks = true;
    }

    /// Its memory, for another one.
    #[must_use]
    pub fn into_memory(self) -> Memory {
        let Self { memory, strings, done, pulled, regexes, dictionaries, .. } = self;
        Memory { cells: memory, strings, done, pulled, regexes, dictionaries }
    }
}
