// SPDX-License-Identifier: GPL-3.0-or-later
//! Code is stored, and made in parallel with the threads that render; the interpreter runs the group
//! meanwhile.
//! Tests: `tests/batches.rs`.

use gnurt_simd::Level;
use gnurt_sl::exec::{Event, Host, Plan, Point, Points, Program, Results, RetainedOutput};
use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use crate::compiled::{Compiled, NoCode};
use crate::fingerprint::fingerprint;

/// Limit of groups with stored code and no users.
const KEPT: usize = 256;
/// Threads that make code at once: the others wait, for scenes may have thousands of groups.
const THREADS: usize = 4;
/// Pairs of batches that come before code for pairs is made: short previews are not worth it.
const PAIRS: u32 = 16;

type Made = OnceLock<Result<Compiled, NoCode>>;

/// The code of a group.
#[derive(Default)]
struct Codes {
    one: Made,
    /// For two batches at once.
    pair: Made,
    /// Pairs that have come without such code, up to [`PAIRS`].
    pairs: AtomicU32,
}

type Slot = Arc<Codes>;

/// Code that is to be made.
struct Request {
    plan: Arc<Plan>,
    level: Level,
    slot: Slot,
    is_pair: bool,
}

/// Code by group (instance values are part of it) and level.
#[derive(Default)]
pub struct Cache {
    slots: Mutex<HashMap<(u128, Level), Slot>>,
    queue: Arc<Mutex<Queue>>,
}

/// Groups that wait for their code.
#[derive(Default)]
struct Queue {
    waiting: VecDeque<Request>,
    /// Threads that make some.
    threads: usize,
}

/// Whether a warning has been given that no group has code here.
static IS_REPORTED: AtomicBool = AtomicBool::new(false);

/// A group that runs, by code as soon as there is some.
pub struct Job {
    plan: Arc<Plan>,
    level: Level,
    slot: Slot,
    queue: Arc<Mutex<Queue>>,
    /// Whether the reason for missing code has been reported.
    is_reported: AtomicBool,
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cache").finish_non_exhaustive()
    }
}

impl Request {
    /// Makes the code; a mistake of ours leaves the group to the interpreter.
    fn make(self) {
        let Self { plan, level, slot, is_pair } = self;
        let made = catch_unwind(AssertUnwindSafe(|| match slot.one.get() {
            Some(Ok(one)) if is_pair => one.paired(),
            _ => Compiled::new(plan, level),
        }));
        let mistake = |_| Err(NoCode::OfGroup("the compiler made a mistake".into()));
        let _ = slot.place(is_pair).set(made.unwrap_or_else(mistake));
    }

    fn fail(self, why: impl Into<String>) {
        let _ = self.slot.place(self.is_pair).set(Err(NoCode::Here(why.into())));
    }
}

impl Codes {
    fn place(&self, is_pair: bool) -> &Made {
        if is_pair { &self.pair } else { &self.one }
    }
}

/// Makes code while requests are pending.
fn work(queue: &Mutex<Queue>) {
    loop {
        let next = queue.lock().ok().and_then(|mut queue| {
            let next = queue.waiting.pop_front();
            queue.threads -= usize::from(next.is_none());
            next
        });
        let Some(request) = next else { return };
        request.make();
    }
}

impl Cache {
    /// How many groups it has code of, or has it made now.
    #[must_use]
    pub fn count(&self) -> usize {
        self.slots.lock().map_or(0, |slots| slots.len())
    }

    /// Waits until all groups that it has now have their code, or it is known that there is none.
    pub fn wait(&self) {
        let slots: Vec<Slot> =
            self.slots.lock().map_or_else(|_| Vec::new(), |slots| slots.values().cloned().collect());
        slots.iter().for_each(|slot| _ = slot.one.wait());
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
                let _ = lost.one.set(Err(NoCode::Here("the list of code is lost".into())));
                lost
            }
        };
        if let Some(slot) = new
            && !request(&self.queue, Request { plan: plan.clone(), level, slot, is_pair: false })
            && let Ok(mut slots) = self.slots.lock()
        {
            // The next one tries again.
            slots.remove(&key);
        }
        Job { plan, level, slot, queue: self.queue.clone(), is_reported: AtomicBool::new(false) }
    }
}

/// Has code made by a thread. Returns whether there is one, or it is known for good that there is none.
fn request(all: &Arc<Mutex<Queue>>, request: Request) -> bool {
    let Ok(mut queue) = all.lock() else {
        request.fail("the list of what waits for code is lost");
        return true;
    };
    queue.waiting.push_back(request);
    if queue.threads >= THREADS {
        return true;
    }
    queue.threads += 1;
    drop(queue);
    let here = all.clone();
    let Err(why) = std::thread::Builder::new().name("shader code".into()).spawn(move || work(&here)) else {
        return true;
    };
    // Other threads process pending requests; if there are none, the request fails.
    let Ok(mut queue) = all.lock() else { return true };
    queue.threads -= 1;
    if queue.threads > 0 {
        return true;
    }
    let left = std::mem::take(&mut queue.waiting);
    drop(queue);
    left.into_iter().for_each(|request| request.fail(format!("no thread to compile in: {why}")));
    false
}

impl Job {
    /// Whether code was made, or it is known that there is none.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.slot.one.get().is_some()
    }

    /// Whether code for two batches at once was made, or there is none: it is asked for when some pairs have come.
    #[must_use]
    pub fn is_pair_ready(&self) -> bool {
        self.slot.pair.get().is_some()
    }

    /// Waits until there is code.
    ///
    /// # Errors
    /// Why there is none and the interpreter runs the group.
    pub fn wait(&self) -> Result<&Compiled, NoCode> {
        self.slot.one.wait().as_ref().map_err(Clone::clone)
    }

    /// The code for two batches at once, which is made once some pairs have come.
    fn pair(&self) -> Option<&Compiled> {
        if let Some(made) = self.slot.pair.get() {
            return made.as_ref().ok();
        }
        let pays = Compiled::pairs_pay(self.level) && matches!(self.slot.one.get(), Some(Ok(_)));
        if pays && self.slot.pairs.load(Ordering::Relaxed) < PAIRS {
            let come = self.slot.pairs.fetch_add(1, Ordering::Relaxed) + 1;
            if come == PAIRS {
                let (plan, slot) = (self.plan.clone(), self.slot.clone());
                request(&self.queue, Request { plan, level: self.level, slot, is_pair: true });
            }
        }
        None
    }
}

impl Program for Job {
    fn run(&self, host: &dyn Host, points: &Points, out: &mut Results) {
        match self.slot.one.get() {
            // The runner counts stopped points.
            Some(Ok(code)) => {
                code.run_for(&self.plan, host, std::slice::from_ref(points), std::slice::from_mut(out));
            }
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

    fn run_pair(&self, host: &dyn Host, points: &[Points; 2], out: &mut [Results; 2]) {
        match self.pair() {
            Some(code) => code.run_for(&self.plan, host, points, out),
            None => points.iter().zip(out).for_each(|(points, out)| self.run(host, points, out)),
        }
    }

    fn retained(&self) -> &[RetainedOutput] {
        self.plan.retained()
    }

    fn describe_point(&self, host: &dyn Host, point: &Point) -> Vec<String> {
        self.plan.describe_point(host, point)
    }
}
