// SPDX-License-Identifier: GPL-3.0-or-later
//! Single operations, for engines that run a group by other means and leave some operations to the
//! interpreter. Values are elsewhere: the caller copies an operation's arguments into the machine's memory,
//! and its results back. The caller also switches the current point and its messages.

use super::components::Closures;
use super::host::Point;
use super::machine::{Event, Machine, Memory, Message, Param, Plan, Step};
use super::slot::Slot;
use super::strings::Strings;
use crate::ir::SourcePosition;
use std::sync::atomic::Ordering;

impl Machine<'_> {
    /// Drops all earlier points, and their output.
    pub fn start(&mut self) {
        self.strings.truncate(self.plan.strings.count());
        self.closures.clear();
        self.messages.clear();
        self.events.clear();
        self.reports = 0;
    }

    /// The next point, its index in the batch, and the messages of its layers so far; returns those of the
    /// one before.
    pub fn change_point(&mut self, point: &Point, lane: usize, messages: Vec<Message>) -> Vec<Message> {
        self.point.clone_from(point);
        self.lane = lane;
        std::mem::replace(&mut self.messages, messages)
    }

    /// Executes an operation of a layer, on the contents of the memory.
    pub fn perform(&mut self, layer: usize, step: &Step) {
        self.layer = layer;
        (step.action)(self, step);
    }

    /// Takes a parameter's value from the geometry; whether that has one.
    pub fn fetch_userdata(&mut self, layer: usize, param: &Param) -> bool {
        let code = &self.plan.layers[layer];
        let slot = code.slots[param.symbol as usize];
        let given = self.host.userdata(&code.shader.symbol(param.symbol).name, slot.ty, &self.point);
        if let Some(given) = &given {
            self.give(&slot, given);
        }
        given.is_some()
    }

    /// Reports that a loop of a layer was stopped.
    pub fn report_stopped(&mut self, layer: usize, at: SourcePosition, iterations: u64) {
        self.layer = layer;
        let source_position = self.source_position(at);
        self.error(format!("stopped: a loop at {source_position} did not end after {iterations} turns"));
    }

    /// The cells of all symbols.
    pub fn cells(&mut self) -> &mut [u32] {
        &mut self.memory
    }

    /// The texts that cells name.
    #[must_use]
    pub fn texts(&self) -> &Strings {
        &self.strings
    }

    /// Exchanges the nodes of closures for others.
    pub fn change_closures(&mut self, list: &mut Closures) {
        std::mem::swap(&mut self.closures, list);
    }
}

/// Points of a group that may be stopped before the group is left out altogether.
const STRIKES: u32 = 32;

impl Plan {
    /// Memory for a [`Machine`] of this plan, from those that were [taken back](Self::take_back) if there is
    /// one. It may hold answers of the host that the plan is run for: programs that mean the same do not
    /// share it.
    #[must_use]
    pub fn lend(&self) -> Memory {
        let pooled = self.memories.lock().ok().and_then(|mut list| list.pop());
        pooled.unwrap_or_else(|| Memory::new(self))
    }

    /// Keeps memory for later.
    pub fn take_back(&self, memory: Memory) {
        if let Ok(mut list) = self.memories.lock() {
            list.push(memory);
        }
    }

    /// Whether the group is not run any more, because so many points of it were stopped.
    #[must_use]
    pub fn is_left_out(&self) -> bool {
        self.strikes.load(Ordering::Relaxed) >= STRIKES
    }

    /// Notes that a point was stopped; returns the message of the last allowed one.
    #[must_use]
    pub fn strike(&self) -> Option<Event> {
        let last = self.strikes.fetch_add(1, Ordering::Relaxed) + 1 == STRIKES;
        let text = || format!("group {}: stopped at {STRIKES} points, and left out from now on", self.name);
        last.then(|| Event::Error(text()))
    }

    /// The slot of a stored value.
    #[must_use]
    pub fn place_of(&self, name: &str) -> Option<Slot> {
        self.slot_of(name)
    }
}
