// SPDX-License-Identifier: GPL-3.0-or-later
//! A group as a back end takes it: regions, and the control between them. Masks are bits, stored in slots.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_sl::exec::{Slot, Step};
use gnurt_sl::ir::SourcePosition as Line;
use std::sync::Arc;

use crate::op::Region;
use crate::term::QuickMap;

/// Which lanes a choice takes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Test {
    /// All if this cell, which is the same for all, is not 0; else none.
    Cell(u32),
    /// Those whose bits are set in this slot.
    Lanes(u32),
}

/// A loop's body, its slots and its condition.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    pub(crate) body_first: bool,
    pub(crate) test: Vec<Node>,
    pub(crate) condition: Test,
    pub(crate) body: Vec<Node>,
    pub(crate) step: Vec<Node>,
    /// Lanes that came here.
    pub(crate) entry: u32,
    /// Lanes that still iterate.
    pub(crate) live: u32,
    /// Lanes that wait for the next iteration.
    pub(crate) waiting: u32,
    /// Lanes that left for good.
    pub(crate) gone: Vec<u32>,
    /// Where lanes are noted that are stopped.
    pub(crate) stopped: u32,
    /// The call that reports it.
    pub(crate) say: u32,
    /// Turns that an iteration counts as.
    pub(crate) turns: u32,
}

/// A loop whose iteration is one region, which ends with the lanes that go on.
#[derive(Clone, Debug)]
pub(crate) struct Tight {
    pub(crate) body_first: bool,
    /// The first test, if it precedes the body.
    pub(crate) before: Vec<Node>,
    /// Body, step and test.
    pub(crate) iteration: Vec<Node>,
    /// Lanes that came here.
    pub(crate) entry: u32,
    /// Lanes that both regions let go on.
    pub(crate) live: u32,
    /// Where lanes are noted that are stopped.
    pub(crate) stopped: u32,
    /// The call that reports it.
    pub(crate) say: u32,
    /// Turns that an iteration counts as.
    pub(crate) turns: u32,
}

/// A step of the running lanes, in order.
#[derive(Clone, Debug)]
pub(crate) enum Node {
    /// Computing.
    Region(Region),
    /// A call out of the code: its number.
    Call(u32),
    /// A choice; slots for the lanes of the second block and for those that have finished the first.
    If { test: Test, yes: Vec<Node>, no: Vec<Node>, other: u32, done: u32 },
    /// A loop.
    Loop(Box<Loop>),
    /// A loop without branches in it.
    Tight(Box<Tight>),
    /// A block that lanes leave by a note in `left`; those in `gone` stay away afterwards as well.
    Frame { body: Vec<Node>, entry: u32, left: u32, gone: Option<u32> },
    /// A block for the lanes that were not here since `flag` was cleared.
    Once { flag: u32, entry: u32, body: Vec<Node> },
    /// A layer's code.
    Layer(u32),
    /// The lanes that run leave, with a note.
    Leave(Option<u32>),
    /// Those of them leave that are set in a slot.
    LeaveSome { lanes: u32, note: Option<u32> },
}

impl Node {
    /// Whether fewer lanes may run after it than before.
    pub(crate) fn leaves(&self) -> bool {
        match self {
            Self::Leave(_) | Self::LeaveSome { .. } | Self::Tight(_) => true,
            Self::If { yes, no, .. } => yes.iter().chain(no).any(Self::leaves),
            Self::Loop(inner) => {
                !inner.gone.is_empty()
                    && (inner.body.iter().any(Self::leaves_for_good) || inner.stopped != u32::MAX)
            }
            Self::Frame { gone, .. } => gone.is_some(),
            _ => false,
        }
    }

    fn leaves_for_good(&self) -> bool {
        match self {
            Self::Leave(note) | Self::LeaveSome { note, .. } => note.is_some(),
            _ => self.leaves(),
        }
    }
}

/// The calls of the code.
#[derive(Clone)]
pub(crate) enum Call {
    /// An operation that the interpreter does, lane by lane.
    Step { layer: usize, step: Arc<Step>, ins: Vec<Slot>, outs: Vec<Slot> },
    /// An operation that the interpreter's machine does for all lanes at once where it can, and else lane by lane.
    Together { layer: usize, step: Arc<Step>, ins: Vec<Slot>, outs: Vec<Slot> },
    /// An operation that makes closures, which the interpreter does for all lanes at once.
    Closure(Box<Making>),
    /// A value of the geometry for a parameter; lanes that got one are noted.
    Userdata { layer: usize, param: usize, given: u32 },
    /// That lanes are stopped in a loop.
    Stopped { layer: usize, at: Line },
}

/// An operation that makes closures.
#[derive(Clone)]
pub(crate) struct Making {
    pub(crate) layer: usize,
    pub(crate) step: Arc<Step>,
    pub(crate) ins: Vec<Slot>,
    pub(crate) outs: Vec<Slot>,
    /// Whether texts that it takes never change.
    pub(crate) is_named: bool,
}

/// A group.
#[derive(Clone, Default)]
pub(crate) struct Program {
    /// The code of each layer, for lanes that have not run it.
    pub(crate) layers: Vec<Layer>,
    /// Calls by number.
    pub(crate) calls: Vec<Call>,
    /// How many masks there are.
    pub(crate) slots: u32,
    /// The masks that are cleared before a batch: of layers and of values that are fetched once.
    pub(crate) flags: Vec<u32>,
    /// By cell, whether it may differ from point to point.
    pub(crate) varying: Vec<bool>,
    /// Symbols that are used, by their first cell, and whether they are written.
    pub(crate) touched: QuickMap<u32, bool>,
}

/// A layer.
#[derive(Clone, Default)]
pub(crate) struct Layer {
    /// Lanes that have run it.
    pub(crate) done: u32,
    /// Lanes that came here.
    pub(crate) entry: u32,
    /// Its code.
    pub(crate) code: Vec<Node>,
}
