// SPDX-License-Identifier: GPL-3.0-or-later
//! Code that was made is kept, and made beside the threads that render; the interpreter runs the group meanwhile.
//! Source: original.
//! Proof: `tests/batches.rs`.

use gnurt_simd::Level;
use gnurt_sl::exec::{Event, Host, Kept, Plan, Point, Points, Program, Results};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use crate::compiled::{Compiled, NoCode};
use crate::fingerprint::fingerprint;

/// Groups whose code is kept though nobody uses it.
const KEPT: usize = 256;

type Slot = Arc<OnceLock<Result<Compiled, NoCode>>>;

/// Code by group (instance values are part of it) and level.
#[derive(Default)]
pub struct Cache {
    slots: Mutex<HashMap<(u128, Level), Slot>>,
}

/// A group that runs, by code as soon as there is some.
pub struct Job {
    plan: Arc<Plan>,
    slot: Slot,
    /// Whether it has been told why there is no code.
    is_told: AtomicBool,
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cache").finish_non_exhaustive()
    }
}

impl Cache {
    /// How many groups it has code of, or has it made now.
    #[must_use]
    pub fn count(&self) -> usize {
        self.slots.lock().map_or(0, |slots| slots.len())
    }

    /// The code of a group: found, or made by a thread of its own from now on.
    #[must_use]
    pub fn start(&self, plan: Arc<Plan>, level: Level) -> Job {
        let key = (fingerprint(&plan), level);
        let mut new = None;
        let slot = match self.slots.lock() {
            Ok(mut slots) => {
                if slots.len() > KEPT {
                    slots.retain(|_, slot| Arc::strong_count(slot) > 1);
                }
                let slot = slots.entry(key).or_insert_with(|| {
                    let slot = Slot::default();
                    new = Some(slot.clone());
                    slot
                });
                slot.clone()
            }
            Err(_) => Slot::default(),
        };
        if let Some(slot) = new {
            let (plan, failed) = (plan.clone(), slot.clone());
            let work = move || drop(slot.set(Compiled::new(plan, level)));
            if let Err(why) = std::thread::Builder::new().name("shader code".into()).spawn(work) {
                let _ = failed.set(Err(NoCode::Here(format!("no thread to compile in: {why}"))));
            }
        }
        Job { plan, slot, is_told: AtomicBool::new(false) }
    }
}

impl Job {
    /// Whether code was made, or it is known that there is none.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.slot.get().is_some()
    }

    /// Waits until there is code.
    ///
    /// # Errors
    /// Why there is none and the interpreter goes on.
    pub fn wait(&self) -> Result<&Compiled, NoCode> {
        self.slot.wait().as_ref().map_err(Clone::clone)
    }
}

impl Program for Job {
    fn run(&self, host: &dyn Host, points: &Points, out: &mut Results) {
        match self.slot.get() {
            // Points that were stopped are counted by who runs it.
            Some(Ok(code)) => code.run_for(&self.plan, host, points, out),
            code => {
                self.plan.run(host, points, out);
                if let Some(Err(NoCode::OfGroup(why))) = code
                    && !self.is_told.swap(true, Ordering::Relaxed)
                {
                    let text = format!("it is interpreted, which is slow, for it has no machine code: {why}");
                    out.events.push((0, Event::Warning(text)));
                }
            }
        }
    }

    fn kept(&self) -> &[Kept] {
        self.plan.kept()
    }

    fn tell(&self, host: &dyn Host, point: &Point) -> Vec<String> {
        self.plan.tell(host, point)
    }
}
