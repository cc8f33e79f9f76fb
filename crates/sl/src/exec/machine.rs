// SPDX-License-Identifier: GPL-3.0-or-later
//! The machine, the plan that it runs and the steps that plans are made of.
//! Source: original. These types name each other, so they stand together.

use super::components::Closure;
use super::host::{Host, Point};
use super::slot::{Kept, Slot};
use super::strings::Strings;
use crate::ir::{Place, Shader, SymId};
use crate::types::Type;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::regex::Regex;
use std::collections::HashMap;
use std::sync::atomic::AtomicU32;
use std::sync::{Arc, Mutex};

pub(super) type D = Dual<f32>;

/// What an operation does.
#[derive(Clone, Copy)]
pub(super) enum Action {
    /// To each component by itself.
    Map1(fn(D) -> D),
    /// To each pair of components.
    Map2(fn(D, D) -> D),
    /// To each three components.
    Map3(fn(D, D, D) -> D),
    /// To all of it.
    Whole(fn(&mut Machine<'_>, &Step)),
}

/// An operation with its arguments.
pub(super) struct Step {
    pub(super) name: Arc<str>,
    pub(super) action: Action,
    pub(super) args: Box<[Slot]>,
    /// The arguments' symbols.
    pub(super) symbols: Box<[SymId]>,
    pub(super) at: Place,
    /// Connected parameters that it reads.
    pub(super) pulls: Box<[u32]>,
}

/// A step or a block of them.
pub(super) enum Instruction {
    Do(Step),
    If { condition: Slot, pulls: Box<[u32]>, yes: Vec<Instruction>, no: Vec<Instruction> },
    Loop(Box<Loop>),
    Call(Vec<Instruction>),
    Leave(Flow),
}

pub(super) struct Loop {
    pub(super) body_first: bool,
    pub(super) init: Vec<Instruction>,
    pub(super) test: Vec<Instruction>,
    pub(super) condition: Slot,
    pub(super) pulls: Box<[u32]>,
    pub(super) body: Vec<Instruction>,
    pub(super) step: Vec<Instruction>,
    pub(super) at: Place,
}

/// How a block was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    Next,
    Break,
    Continue,
    Return,
    Exit,
}

/// Where a parameter's value comes from, unless its default is worked out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The memory has it.
    Value,
    /// The geometry may have it.
    Geometry,
    /// A connection.
    Connected,
}

pub(super) struct Param {
    pub(super) symbol: SymId,
    pub(super) source: Source,
    /// Whether the connection gives all of it.
    pub(super) whole: bool,
    pub(super) init: Vec<Instruction>,
}

/// A value to fetch along a connection.
pub(super) struct Copy {
    pub(super) layer: usize,
    pub(super) from: Slot,
    /// Cells between value and derivatives if `from` is a part of something larger; 0 otherwise.
    pub(super) from_derivs: u32,
    pub(super) to: Slot,
    pub(super) to_derivs: u32,
    pub(super) to_symbol: SymId,
}

pub(super) struct LayerPlan {
    pub(super) name: Arc<str>,
    pub(super) shader: Arc<Shader>,
    pub(super) slots: Vec<Slot>,
    pub(super) params: Vec<Param>,
    pub(super) copies: Vec<Copy>,
    pub(super) code: Vec<Instruction>,
    pub(super) lazy: bool,
    /// By symbol: bit 0 connected from above, bit 1 to below.
    pub(super) connected: Vec<u8>,
    /// By symbol: whether its value is known before the group runs.
    pub(super) constant: Vec<bool>,
}

/// A group that is ready to run.
pub struct Plan {
    pub(super) name: String,
    pub(super) layers: Vec<LayerPlan>,
    pub(super) globals: HashMap<Arc<str>, Slot>,
    /// Memory at the start of a point.
    pub(super) memory: Vec<u32>,
    pub(super) strings: Strings,
    pub(super) debug_layers: bool,
    pub(super) entries: Vec<usize>,
    /// Turns of loops that a point may take.
    pub(super) turns: u64,
    /// What [`Program`](super::Program) gives back of each point.
    pub(super) kept: Vec<Kept>,
    /// Points that were stopped.
    pub(super) strikes: AtomicU32,
    /// Memories that no batch uses now.
    pub(super) memories: Mutex<Vec<Memory>>,
}

/// What a layer left for others, or asked for in vain.
#[derive(Clone, Debug)]
pub(super) struct Message {
    pub(super) name: Arc<str>,
    pub(super) ty: Type,
    pub(super) words: Option<Vec<u32>>,
    pub(super) layer: usize,
    pub(super) place: String,
}

/// What a shader says.
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

/// Runs groups. One for each thread.
pub struct Machine<'a> {
    pub(super) plan: &'a Plan,
    pub(super) host: &'a dyn Host,
    pub(super) memory: Vec<u32>,
    pub(super) strings: Strings,
    pub(super) closures: Vec<Closure>,
    pub(super) messages: Vec<Message>,
    pub(super) point: Point,
    /// The layer that runs.
    pub(super) layer: usize,
    pub(super) done: Vec<bool>,
    /// By layer and parameter, whether connected values have been fetched.
    pub(super) pulled: Vec<Vec<bool>>,
    /// Steps left for this point.
    pub(super) fuel: u64,
    /// What was said since it was last taken.
    pub events: Vec<Event>,
    /// Regular expressions that were read; none where one is wrong.
    pub(super) regexes: HashMap<Arc<str>, Option<Regex>>,
}

/// What a machine works in, between two uses.
pub(super) struct Memory {
    cells: Vec<u32>,
    strings: Strings,
    done: Vec<bool>,
    pulled: Vec<Vec<bool>>,
    regexes: HashMap<Arc<str>, Option<Regex>>,
}

impl Memory {
    pub(super) fn new(plan: &Plan) -> Self {
        Self {
            cells: plan.memory.clone(),
            strings: plan.strings.clone(),
            done: vec![false; plan.layers.len()],
            pulled: plan.layers.iter().map(|l| vec![false; l.slots.len()]).collect(),
            regexes: HashMap::new(),
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
    pub(super) fn within(plan: &'a Plan, host: &'a dyn Host, memory: Memory) -> Self {
        let Memory { cells, strings, done, pulled, regexes } = memory;
        Self {
            plan,
            host,
            memory: cells,
            strings,
            closures: Vec::new(),
            messages: Vec::new(),
            point: Point::default(),
            layer: 0,
            done,
            pulled,
            fuel: 0,
            events: Vec::new(),
            regexes,
        }
    }

    pub(super) fn into_memory(self) -> Memory {
        let Self { memory, strings, done, pulled, regexes, .. } = self;
        Memory { cells: memory, strings, done, pulled, regexes }
    }
}
