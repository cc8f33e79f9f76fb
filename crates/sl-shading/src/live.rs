// SPDX-License-Identifier: GPL-3.0-or-later
//! Live parameters, which change while shaders run, without compiling: numbers that all threads read from
//! shared memory. The shader requests them like attributes of geometry, whose values are never folded. A
//! picture rendered during a change mixes both values. Tests: `tests/scripts/live.rs`.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// A parameter's numbers; ints as floats.
#[derive(Clone, Debug)]
struct Slot {
    name: String,
    numbers: Arc<[AtomicU32]>,
}

/// Parameters by name. Clones share the numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Live {
    slots: Vec<Slot>,
}

impl Live {
    /// Adds a parameter.
    pub(crate) fn add(&mut self, name: &str, numbers: &[f32]) {
        let numbers = numbers.iter().map(|x| AtomicU32::new(x.to_bits())).collect();
        self.slots.push(Slot { name: name.to_owned(), numbers });
    }

    fn slot(&self, name: &str) -> Option<&Slot> {
        self.slots.iter().find(|slot| slot.name == name)
    }

    /// Whether it is one of them.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.slot(name).is_some()
    }

    /// The numbers of a parameter, if it is one of them.
    pub(crate) fn get(&self, name: &str) -> Option<Vec<f32>> {
        let read = |x: &AtomicU32| f32::from_bits(x.load(Ordering::Relaxed));
        Some(self.slot(name)?.numbers.iter().map(read).collect())
    }

    /// Writes the numbers of a parameter that is one of them; returns whether it is.
    pub(crate) fn set(&self, name: &str, numbers: &[f32]) -> bool {
        let Some(slot) = self.slot(name).filter(|slot| slot.numbers.len() == numbers.len()) else {
            return false;
        };
        slot.numbers.iter().zip(numbers).for_each(|(to, from)| to.store(from.to_bits(), Ordering::Relaxed));
        true
    }
}
