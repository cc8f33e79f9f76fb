// SPDX-License-Identifier: GPL-3.0-or-later
//! Code is stored, and made in parallel with the threads that render; the interpreter runs the group
//! meanwhile.
//! Tests: `tests/batches.rs`.

use gnurt_simd::Level;
use gnurt_sl::exec::{Event, Host, Plan, Point, Points, Program, Results, RetainedOutput};
use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use crate::compiled::{Compiled, NoCode};
use crate::fingerprint::fingerprint;

/// Limit of groups with stored code and no users.
const KEPT: usize = 256;
/// Threads that make code at once: the others wait, for scenes may have thousands of groups.
const THREADS: usize = 4;

type Slot = Arc<OnceLock<Result<Compiled, NoCode>>>;

/// Code by group (instance values are part of it) and level.
#[derive(Default)]
pub struct Cache {
    slots: Mutex<HashMap<(u128, Level), Slot>>,
    queue: Arc<Mutex<Queue>>,
}

/// Groups that wait for their code.
#[derive(Default)]
struct Queue {
    waiting: VecDeque<(Arc<Plan>, Level, Slot)>,
    /// Threads that make some.
    threads: usize,
}

/// Whether a warning has been given that no group has code here.
static IS_REPORTED: AtomicBool = AtomicBool::new(false);

/// A group that runs, by code as soon as there is some.
pub struct Job {
    plan: Arc<Plan>,
    slot: Slot,
    /// Whether the reason for missing code has been reported.
    is_reported: AtomicBool,
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cache").finish_non_exhaustive()
    }
}

/// Makes code; a mistake of ours leaves the group to the interpreter.
fn made(plan: Arc<Plan>, level: Level) -> Result<Compiled, NoCode> {
    let work = AssertUnwindSafe(|| Compiled::new(plan, level));
    catch_unwind(work).unwrap_or_else(|_| Err(NoCode::OfGroup("the compiler made a mistake".into())))
}

/// Makes code while requests are pending.
fn work(queue: &Mutex<Queue>) {
    loop {
        let next = queue.lock().ok().and_then(|mut queue| {
            let next = queue.waiting.pop_front();
            queue.threads -= usize::from(next.is_none());
            next
        });
        let Some((plan, level, slot)) = next else { return };
        let _ = slot.set(made(plan, level));
    }
}

impl Cache {
    /// How many groups it has code of, or has it made now.
    #[must_use]
    pub fn count(&self) -> usize {
        self.slots.lock().map_or(0, |slots| slots.len())
    }

    /// The code of a group: found, or made by a thread from now on. Few threads make all code, one group after the other.
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
            Err(_) => {
                let lost = Slot::default();
                let _ = lost.set(Err(NoCode::Here("the list of code is lost".into())));
                lost
            }
        };
        if let Some(slot) = new {
            self.make(plan.clone(), level, slot, key);
        }
        Job { plan, slot, is_reported: AtomicBool::new(false) }
    }

    fn make(&self, plan: Arc<Plan>, level: Level, slot: Slot, key: (u128, Level)) {
        let Ok(mut queue) = self.queue.lock() else {
            let _ = slot.set(Err(NoCode::Here("the list of what waits for code is lost".into())));
            return;
        };
        queue.waiting.push_back((plan, level, slot));
        if queue.threads >= THREADS {
            return;
        }
        queue.threads += 1;
        drop(queue);
        let all = self.queue.clone();
        let Err(why) = std::thread::Builder::new().name("shader code".into()).spawn(move || work(&all))
        else {
            return;
        };
        // Other threads process pending requests; if there are none, the request fails, and the next one
        // tries again.
        let Ok(mut queue) = self.queue.lock() else { return };
        queue.threads -= 1;
        if queue.threads == 0 {
            let left = std::mem::take(&mut queue.waiting);
            drop(queue);
            for (.., slot) in left {
                let _ = slot.set(Err(NoCode::Here(format!("no thread to compile in: {why}"))));
            }
            if let Ok(mut slots) = self.slots.lock() {
                slots.remove(&key);
            }
        }
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
    /// Why there is none and the interpreter runs the group.
    pub fn wait(&self) -> Result<&Compiled, NoCode> {
        self.slot.wait().as_ref().map_err(Clone::clone)
    }
}

impl Program for Job {
    fn run(&self, host: &dyn Host, points: &Points, out: &mut Results) {
        match self.slot.get() {
            // The runner counts stopped points.
            Some(Ok(code)) => code.run_for(&self.plan, host, points, out),
            code => {
                self.plan.run(host, points, out);
                if let Some(Err(why)) = code
                    && !self.is_reported.swap(true, Ordering::Relaxed)
                    // A reason common to all groups is reported for one.
                    && !(matches!(why, NoCode::Here(_)) && IS_REPORTED.swap(true, Ordering::Relaxed))
                {
                    let text =
                        format!("it is interpreted, which is slow, because it has no machine code: {why}");
                    out.events.push((0, Event::Warning(text)));
                }
            }
        }
    }

    fn retained(&self) -> &[RetainedOutput] {
        self.plan.retained()
    }

    fn describe_point(&self, host: &dyn Host, point: &Point) -> Vec<String> {
        self.plan.describe_point(host, point)
    }
}
