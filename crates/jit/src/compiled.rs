// SPDX-License-Identifier: GPL-3.0-or-later
//! A group as machine code.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_simd::Level;
use gnurt_sl::exec::{Bound, Plan, Program as _, RetainedOutput, Slot};
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock};

use crate::control::{self, Code};
use crate::ffi_call::{Line, cell_values};
use crate::ffi_memory::Executable;
use crate::inputs::{self, Input};
use crate::isa::Isa;
use crate::layout::{CellAddress, Layout};
use crate::program::Program;
use crate::{aarch64, lower, x86};

/// Why there is no machine code, and the interpreter runs a group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoCode {
    /// There is none of any group: the CPU or the system has no means for it.
    Here(String),
    /// The group is beyond a limit, or of a kind that only the interpreter runs.
    OfGroup(String),
}

impl fmt::Display for NoCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Here(why) | Self::OfGroup(why)) = self;
        f.write_str(why)
    }
}

/// A group as machine code for a level, for sixteen points at once, for two times sixteen, or for one.
pub struct Compiled {
    pub(crate) plan: Arc<Plan>,
    /// Of all levels, and of one batch or two.
    pub(crate) program: Arc<Program>,
    pub(crate) layout: Layout,
    pub(crate) code: Executable,
    /// By call, the component of a closure, resolved at first use.
    pub(crate) bounds: Vec<OnceLock<Option<Bound>>>,
    /// Where each layer's code starts.
    pub(crate) layers: Vec<u32>,
    pub(crate) level: Level,
    /// The memory as it starts.
    pub(crate) template: Vec<Line>,
    /// Ranges of it that a batch changes and the next one needs unchanged: start and length in lines.
    pub(crate) resets: Vec<(usize, usize)>,
    /// Numbers of points that it reads, or returns as they are.
    pub(crate) inputs: Vec<Input>,
    /// Memories that no batch uses now.
    pub(crate) memories: Mutex<Vec<Vec<Line>>>,
    /// The retained outputs of each point, and their slots.
    pub(crate) retained: Vec<(RetainedOutput, Slot)>,
    size: usize,
}

impl Compiled {
    /// Compiles a group for the sixteen points of a batch.
    ///
    /// # Errors
    /// Why there is no code.
    pub fn new(plan: Arc<Plan>, level: Level) -> Result<Self, NoCode> {
        Self::with_lanes(plan, level, 16)
    }

    /// Compiles a group for two batches at once. Their instructions overlap, so that both take little more time than one does
    /// where its operations wait for each other. For one batch the code of [`new`](Self::new) is faster.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn pair(plan: Arc<Plan>, level: Level) -> Result<Self, NoCode> {
        Self::with_lanes(plan, level, 32)
    }

    /// Whether code for two batches at once is faster than twice that for one, as measured.
    #[must_use]
    pub fn pairs_pay(level: Level) -> bool {
        level == Level::Avx512
    }

    /// The same group for two batches at once; sooner made than by [`pair`](Self::pair).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn paired(&self) -> Result<Self, NoCode> {
        let lanes = if self.lanes() == 1 { 1 } else { 32 };
        Self::encoded(self.plan.clone(), self.program.clone(), self.level, lanes)
    }

    /// The same code for another level; sooner made than from the group.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn for_level(&self, level: Level) -> Result<Self, NoCode> {
        Self::encoded(self.plan.clone(), self.program.clone(), level, self.lanes())
    }

    /// Compiles a group for one point at a time, to compare with.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn scalar(plan: Arc<Plan>, level: Level) -> Result<Self, NoCode> {
        Self::with_lanes(plan, level, 1)
    }

    /// Whether this machine can run code for a level.
    #[must_use]
    pub fn can(level: Level) -> bool {
        cfg!(all(any(target_arch = "x86_64", target_arch = "aarch64"), any(unix, windows)))
            && matches!(level, Level::Avx2 | Level::Avx512 | Level::Neon)
            && level.is_available()
    }

    fn with_lanes(plan: Arc<Plan>, level: Level, lanes: usize) -> Result<Self, NoCode> {
        Self::check(level)?;
        let program = lower::program(&plan, lanes > 1).map_err(NoCode::OfGroup)?;
        Self::encoded(plan, Arc::new(program), level, lanes)
    }

    fn check(level: Level) -> Result<(), NoCode> {
        let why = || format!("machine code is unsupported for {level}; valid are avx2, avx512 and neon");
        if Self::can(level) { Ok(()) } else { Err(NoCode::Here(why())) }
    }

    fn encoded(plan: Arc<Plan>, program: Arc<Program>, level: Level, lanes: usize) -> Result<Self, NoCode> {
        Self::check(level)?;
        let made = match level {
            Level::Neon => encoded::<aarch64::Asm>(&program, lanes, level),
            _ => encoded::<x86::Asm>(&program, lanes, level),
        };
        let (layout, made) = made.map_err(NoCode::OfGroup)?;
        let code = Executable::new(&made.bytes).map_err(NoCode::Here)?;
        let mut template = vec![Line([0; 16]); layout.lines()];
        layout.start(&plan.memory, cell_values(&mut template));
        let mut this = Self {
            bounds: program.calls.iter().map(|_| OnceLock::new()).collect(),
            program,
            layout,
            code,
            layers: made.layers,
            level,
            template,
            resets: Vec::new(),
            inputs: Vec::new(),
            memories: Mutex::default(),
            retained: Vec::new(),
            size: made.bytes.len(),
            plan,
        };
        this.find_resets();
        let retained = this.plan.retained().iter();
        this.retained = retained.filter_map(|k| Some((k.clone(), this.plan.place_of(&k.name)?))).collect();
        this.find_inputs();
        Ok(this)
    }

    fn find_inputs(&mut self) {
        let mut reads = inputs::reads(&self.program);
        let is_written = |slot: &Slot| self.program.touched.get(&slot.at).is_some_and(|&written| written);
        let all = |slot: &Slot| slot.at..slot.at + slot.cells() as u32;
        // Lanes that do not run keep their parts of written globals, and globals that no operation reads may be results.
        self.plan.globals.values().filter(|slot| is_written(slot)).for_each(|slot| reads.extend(all(slot)));
        self.retained.iter().for_each(|(_, slot)| reads.extend(all(slot)));
        let mut globals: Vec<(&Arc<str>, &Slot)> = self.plan.globals.iter().collect();
        globals.sort_by_key(|(_, slot)| slot.at);
        let of = |(name, slot): (&Arc<str>, &Slot)| Input::of_global(name, slot, &self.layout, &reads);
        self.inputs = globals.into_iter().flat_map(of).collect();
    }

    fn find_resets(&mut self) {
        let mut lines: Vec<usize> = Vec::new();
        let mut add = |slot: &Slot| {
            for cell in slot.at..slot.at + slot.cells() as u32 {
                match self.layout.address(cell) {
                    CellAddress::Each(at) => {
                        lines.extend((0..self.layout.lanes).step_by(16).map(|i| (at as usize + 4 * i) / 64))
                    }
                    CellAddress::One(at) => lines.push(at as usize / 64),
                }
            }
        };
        for (number, layer) in self.plan.layers.iter().enumerate() {
            for (id, symbol) in layer.shader.symbols.iter().enumerate() {
                let slot = &layer.slots[id];
                let computed = layer.params.iter().any(|p| p.symbol as usize == id);
                let written = self.program.touched.get(&slot.at).is_some_and(|&w| w);
                if symbol.kind.is_param() && slot.size > 0 && (written || computed) {
                    add(slot);
                }
            }
            let _ = number;
        }
        for slot in self.plan.globals.values() {
            if self.program.touched.get(&slot.at).is_some_and(|&w| w) {
                add(slot);
            }
        }
        lines.sort_unstable();
        lines.dedup();
        for line in lines {
            match self.resets.last_mut() {
                Some((start, count)) if *start + *count == line => *count += 1,
                _ => self.resets.push((line, 1)),
            }
        }
    }

    /// The group that it was made of.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// The level that it is for.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Points at once.
    #[must_use]
    pub fn lanes(&self) -> usize {
        self.layout.lanes
    }

    /// Iterations of loops in a batch: the sum over its points, because each may run its own while the others
    /// wait.
    pub(crate) fn fuel(&self) -> u32 {
        self.plan.iterations.saturating_mul(self.lanes() as u64).min(i32::MAX as u64) as u32
    }

    /// Bytes of machine code.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// How many operations the interpreter does for it, lane by lane.
    #[must_use]
    pub fn calls(&self) -> usize {
        self.program.calls.iter().filter(|call| matches!(call, crate::program::Call::Step { .. })).count()
    }
}

/// The layout and the code of a program, for a kind of machine.
fn encoded<I: Isa>(program: &Program, lanes: usize, level: Level) -> Result<(Layout, Code), String> {
    let mut layout = Layout::new(lanes, program.slots, &program.varying, I::copies(level))?;
    let code = control::code::<I>(program, &mut layout, level)?;
    Ok((layout, code))
}
