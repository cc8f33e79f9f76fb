// SPDX-License-Identifier: GPL-3.0-or-later
//! The instructions of a region and its register allocation, for any machine.
//! Source: \[Bel66\] for the choice of a register to evict (the value that is needed last); original code. A
//! region has no branches, so one pass over it is enough. Constants and cells are loaded where they are
//! needed.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use crate::isa::{Areas, Choice, FromMemory, Isa, Source, Width};
use crate::layout::{CellAddress, Layout};
use crate::op::{Binary, Id, Op, Region, Shift};

/// No register and no slot.
const NONE: u32 = u32::MAX;

/// Where a value is.
#[derive(Clone, Copy)]
struct Place {
    /// Its next use among all.
    next: u32,
    /// Its room in memory, or [`NONE`].
    spilled: u32,
    /// Its register, or [`NOWHERE`].
    register: u8,
    /// Its mask register; 0 for none.
    home: u8,
}

/// No register.
const NOWHERE: u8 = u8::MAX;

struct Emitter<'a, I> {
    asm: &'a mut I,
    layout: &'a mut Layout,
    region: &'a Region,
    width: Width,
    areas: Areas,
    /// The first lane of this part.
    lane: u32,
    /// Indices where each value is used, in order; after those of a value comes [`NONE`].
    uses: &'a [u32],
    places: Vec<Place>,
    /// The values in registers; the set of registers that have some, and of all.
    holds: [Id; 32],
    busy: u32,
    all: u32,
    /// Cells that the region changes, so that they cannot be loaded again later.
    pinned: &'a [bool],
    /// Rooms that were taken, and those of them that are free again.
    spills: u32,
    free: Vec<u32>,
    locked: u32,
    /// Cells of a loop that stay in registers, this part's; and the registers of those of all parts.
    carried: Vec<(u32, u8)>,
    taken: u32,
    /// Values that are masks, where there are registers for such.
    masks: &'a [bool],
    kept: [Option<Id>; 8],
    kept_locked: u8,
    /// See [`Carried::live`]; where that mask is.
    live: Option<u32>,
    exec_mask: Option<u8>,
    /// The registers of those masks of all parts.
    taken_masks: u8,
    exec_row: Option<u8>,
}

/// Which values of a region are masks, and only made of such.
fn masks(region: &Region) -> Vec<bool> {
    let mut masks = vec![false; region.ops.len()];
    for (i, op) in region.ops.iter().enumerate() {
        let is = |id: Id| masks[id as usize];
        masks[i] = match *op {
            Op::Exec => true,
            Op::Binary(Binary::Xor, a, b) if region.ops[b as usize] == Op::Const(!0) => is(a),
            Op::Binary(Binary::And | Binary::Or | Binary::Xor, a, b) => is(a) && is(b),
            Op::Binary(what, ..) => what.compares(),
            _ => false,
        };
    }
    masks
}

/// Values that stay in registers from one iteration of a loop to the next, where a region is the loop's iteration.
#[derive(Debug, Default)]
pub(crate) struct Carried {
    /// Some cells of those that it reads and changes.
    cells: Vec<u32>,
    /// The slot of the test that keeps lanes, if the mask of those that run is carried.
    live: Option<u32>,
}

impl Carried {
    /// The mask's register of a part among those for masks.
    fn mask<I: Isa>(&self, width: Width, part: usize) -> Option<u8> {
        self.live.and_then(|_| I::mask_registers(width).nth_back(part)).map(|k| k as u8)
    }

    /// The mask's number among carried rows where it is one.
    fn row<I: Isa>(&self, width: Width) -> Option<usize> {
        self.live.filter(|_| I::mask_registers(width).is_empty()).map(|_| self.cells.len())
    }
}

/// For a loop whose lanes go on by the test of the slot `live`.
pub(crate) fn carried<I: Isa>(layout: &Layout, region: &Region, width: Width, live: u32) -> Carried {
    let is_plain = layout.lanes > 1 && region.tests.len() == 1 && region.tests[0].0 == live;
    Carried { cells: carried_cells::<I>(layout, region, width), live: is_plain.then_some(live) }
}

fn carried_cells<I: Isa>(layout: &Layout, region: &Region, width: Width) -> Vec<u32> {
    let parts = layout.lanes.div_ceil(width.lanes());
    let is_read = |cell: u32| region.reads().any(|c| c == cell);
    // A value that is stored elsewhere or tested must not be overwritten before.
    let is_out = |cell: u32| {
        let mut outs = region.stores.iter().chain(&region.tests);
        outs.any(|&(_, id)| matches!(region.ops[id as usize], Op::Cell(c) if c == cell))
    };
    let cells = region.stores.iter().map(|&(cell, _)| cell);
    let each = cells.filter(|&cell| matches!(layout.address(cell), CellAddress::Each(_)));
    each.filter(|&cell| is_read(cell) && !is_out(cell)).take(I::registers(width) / 3 / parts).collect()
}

/// The register of a carried cell.
fn home<I: Isa>(width: Width, (part, parts): (usize, usize), number: usize) -> u8 {
    (I::registers(width) - 1 - number * parts - part) as u8
}

/// Loads the values that a loop carries, before its first iteration.
pub(crate) fn load_carried<I: Isa>(
    asm: &mut I,
    layout: &Layout,
    carried: &Carried,
    width: Width,
    areas: Areas,
) {
    let parts = layout.lanes.div_ceil(width.lanes());
    for part in 0..parts {
        let lane = (part * width.lanes()) as u32;
        if let Some(k) = carried.mask::<I>(width, part) {
            asm.load_exec_mask(k, lane);
        }
        for (number, &cell) in carried.cells.iter().enumerate() {
            if let CellAddress::Each(at) = layout.address(cell) {
                asm.load(width, home::<I>(width, (part, parts), number), at + 4 * lane);
            }
        }
        if let Some(number) = carried.row::<I>(width) {
            asm.exec(width, home::<I>(width, (part, parts), number), lane, areas);
        }
    }
}

/// Writes the instructions of a region. Returns how many spill slots it needs.
pub(crate) fn region<I: Isa>(
    asm: &mut I,
    layout: &mut Layout,
    region: &Region,
    width: Width,
    areas: Areas,
    carried: &Carried,
) -> u32 {
    let count = region.ops.len();
    let mut starts = vec![0_u32; count + 1];
    // Each list has an end.
    starts[1..].fill(1);
    let outs = region.stores.iter().chain(&region.tests);
    for op in &region.ops {
        op.operands(|id| starts[id as usize + 1] += 1);
    }
    for &(_, id) in outs.clone() {
        starts[id as usize + 1] += 1;
    }
    for i in 0..count {
        starts[i + 1] += starts[i];
    }
    let places: Vec<Place> = starts[..count]
        .iter()
        .map(|&next| Place { next, spilled: NONE, register: NOWHERE, home: 0 })
        .collect();
    let mut uses = vec![NONE; starts[count] as usize];
    let mut put = |id: Id, at: usize| {
        uses[starts[id as usize] as usize] = at as u32;
        starts[id as usize] += 1;
    };
    for (i, op) in region.ops.iter().enumerate() {
        op.operands(|id| put(id, i));
    }
    for (k, &(_, id)) in outs.enumerate() {
        put(id, count + k);
    }
    let changed: Vec<u32> = region.stores.iter().map(|s| s.0).collect();
    let pinned: Vec<bool> =
        region.ops.iter().map(|op| matches!(op, Op::Cell(cell) if changed.contains(cell))).collect();
    let masks =
        if I::mask_registers(width).is_empty() { vec![false; region.ops.len()] } else { masks(region) };
    let mut most = 0;
    let lanes = if width == Width::One { 1 } else { layout.lanes };
    let parts = lanes.div_ceil(width.lanes());
    let home = |part: usize, number: usize| home::<I>(width, (part, parts), number);
    let row = carried.row::<I>(width);
    let rows = carried.cells.len() + usize::from(row.is_some());
    let taken = (0..parts * rows).fold(0, |bits, i| bits | 1 << home(0, 0).wrapping_sub(i as u8));
    for lane in (0..lanes).step_by(width.lanes()) {
        let part = lane / width.lanes();
        let of_part = carried.cells.iter().enumerate().map(|(number, &cell)| (cell, home(part, number)));
        let mut emitter = Emitter {
            carried: of_part.collect(),
            taken,
            asm,
            layout,
            region,
            width,
            areas,
            lane: lane as u32,
            uses: &uses,
            places: places.clone(),
            holds: [NONE; 32],
            busy: 0,
            all: u32::MAX >> (32 - I::registers(width)),
            pinned: &pinned,
            spills: 0,
            free: Vec::new(),
            locked: taken,
            masks: &masks,
            kept: [None; 8],
            kept_locked: 0,
            live: carried.live,
            exec_mask: carried.mask::<I>(width, part),
            taken_masks: (0..parts)
                .filter_map(|part| carried.mask::<I>(width, part))
                .fold(0, |bits, k| bits | 1 << k),
            exec_row: row.map(|number| home(part, number)),
        };
        emitter.emit(lane + width.lanes() >= lanes);
        most = most.max(emitter.spills);
    }
    most
}

impl<I: Isa> Emitter<'_, I> {
    /// No register is in use but those of carried values.
    fn unlock(&mut self) {
        self.locked = self.taken;
        self.kept_locked = self.taken_masks;
    }

    fn emit(&mut self, last: bool) {
        self.unlock();
        if let Some(k) = self.exec_mask {
            let exec = self.region.ops.iter().zip(&mut self.places).find(|(op, _)| **op == Op::Exec);
            exec.into_iter().for_each(|(_, place)| place.home = k);
        }
        // Constants and cells are loaded where they are needed, but cells that change are loaded before they do.
        for i in 0..self.pinned.len() {
            if self.pinned[i] {
                self.ensure(i as Id);
                self.unlock();
            }
        }
        for i in 0..self.region.ops.len() {
            if !matches!(self.region.ops[i], Op::Cell(_) | Op::Const(_) | Op::Exec) {
                self.operation(i as Id);
                self.unlock();
            }
        }
        for k in 0..self.region.stores.len() {
            let (cell, id) = self.region.stores[k];
            let reg = self.ensure(id);
            match self.layout.address(cell) {
                CellAddress::Each(at) => self.asm.store(self.width, reg, at + 4 * self.lane),
                // All lanes of it are the same; later parts still read the old one.
                CellAddress::One(at) if last => self.asm.store_one(self.width, reg, at),
                CellAddress::One(_) => {}
            }
            if let Some(&(_, home)) = self.carried.iter().find(|c| c.0 == cell) {
                self.asm.copy(self.width, home, reg);
            }
            self.used(id);
            self.unlock();
        }
        for k in 0..self.region.tests.len() {
            let (slot, id) = self.region.tests[k];
            let at = Layout::slot(slot);
            let keeps = self.live == Some(slot);
            let exec_mask = self.exec_mask.filter(|_| keeps);
            if self.masks[id as usize] || exec_mask.is_some() {
                let k = self.ensure_mask(id);
                if let Some(exec) = exec_mask {
                    self.asm.combine_masks(Binary::And, exec, exec, k);
                }
                self.asm.write_mask(k, self.lane, at);
            } else {
                let reg = self.ensure(id);
                if let Some(exec) = self.exec_row.filter(|_| keeps) {
                    // The test is in signs.
                    let all = self.take();
                    self.asm.zero(self.width, all);
                    self.asm.binary(self.width, Binary::IntGreater, all, all, Source::Reg(reg));
                    self.asm.binary(self.width, Binary::And, exec, exec, Source::Reg(all));
                }
                self.asm.write_test(self.width, reg, self.lane, at, self.areas);
            }
            self.used(id);
            self.unlock();
        }
    }

    /// The index of the next use of a value.
    fn next_use(&self, id: Id) -> u32 {
        self.uses[self.places[id as usize].next as usize]
    }

    /// One use of a value is done; its register is free after the last one.
    fn used(&mut self, id: Id) {
        let place = &mut self.places[id as usize];
        place.next += 1;
        if self.uses[place.next as usize] == NONE {
            let reg = std::mem::replace(&mut place.register, NOWHERE);
            if reg != NOWHERE {
                self.busy &= !(1 << reg);
            }
            if place.spilled != NONE {
                self.free.push(place.spilled);
            }
            let k = std::mem::take(&mut place.home);
            if k != 0 {
                self.kept[k as usize] = None;
            }
        }
    }

    /// Whether a value can be loaded again from where it came.
    fn can_reload(&self, id: Id) -> bool {
        match self.region.ops[id as usize] {
            Op::Const(_) | Op::Exec => true,
            Op::Cell(_) => !self.pinned[id as usize],
            _ => false,
        }
    }

    /// A free register; if there is none, the one whose value is needed last is spilled.
    fn take(&mut self) -> u8 {
        let open = self.all & !self.locked;
        let free = (open & !self.busy).trailing_zeros();
        if free < 32 {
            self.locked |= 1 << free;
            return free as u8;
        }
        let (mut best, mut far, mut rest) = (0, 0, open);
        while rest != 0 {
            let r = rest.trailing_zeros();
            rest &= rest - 1;
            // A value that can be loaded again costs less.
            let id = self.holds[r as usize];
            let next = u64::from(self.next_use(id)) * 2 + u64::from(self.can_reload(id));
            if next >= far {
                (best, far) = (r as u8, next);
            }
        }
        debug_assert!(open != 0, "an operation needs all registers");
        let id = self.holds[usize::from(best)];
        self.busy &= !(1 << best);
        self.locked |= 1 << best;
        let reloads = self.can_reload(id);
        let place = &mut self.places[id as usize];
        place.register = NOWHERE;
        if place.home == 0 && !reloads && place.spilled == NONE {
            place.spilled = self.free.pop().unwrap_or_else(|| {
                self.spills += 1;
                self.spills - 1
            });
            self.asm.save(self.width, best, self.areas.spills + 64 * place.spilled);
        }
        best
    }

    fn hold(&mut self, id: Id, reg: u8) {
        self.places[id as usize].register = reg;
        self.holds[reg as usize] = id;
        self.busy |= 1 << reg;
        self.locked |= 1 << reg;
    }

    /// The register of a value, which stays there while the operation is made.
    fn ensure(&mut self, id: Id) -> u8 {
        let Place { register, spilled, home: mask, .. } = self.places[id as usize];
        if register != NOWHERE {
            self.locked |= 1 << register;
            return register;
        }
        if let Op::Cell(cell) = self.region.ops[id as usize]
            && let Some(&(_, home)) = self.carried.iter().find(|c| c.0 == cell)
        {
            return home;
        }
        if let (Op::Exec, Some(home)) = (self.region.ops[id as usize], self.exec_row) {
            return home;
        }
        let reg = self.take();
        if mask != 0 {
            self.asm.spread_mask(reg, mask);
        } else if spilled != NONE {
            self.asm.restore(self.width, reg, self.areas.spills + 64 * spilled);
        } else {
            match self.region.ops[id as usize] {
                Op::Const(0) => self.asm.zero(self.width, reg),
                Op::Const(bits) => self.asm.load_constant(self.width, reg, self.layout.constant(bits)),
                Op::Cell(cell) => match self.layout.address(cell) {
                    CellAddress::Each(at) => self.asm.load(self.width, reg, at + 4 * self.lane),
                    CellAddress::One(at) => self.asm.load_each(self.width, reg, at),
                },
                Op::Exec => self.asm.exec(self.width, reg, self.lane, self.areas),
                _ => unreachable!("what is computed has a register or a room"),
            }
        }
        self.hold(id, reg);
        reg
    }

    /// Whether a value has a register or a room.
    fn is_elsewhere(&self, id: Id) -> bool {
        let place = self.places[id as usize];
        place.register != NOWHERE || place.spilled != NONE
    }

    /// A mask register: a free one, or the one whose mask is needed last.
    fn take_mask(&mut self) -> u8 {
        let mut all = I::mask_registers(self.width);
        let is_open = |e: &Self, k: usize| e.kept_locked & 1 << k == 0;
        let free = all.clone().find(|&k| self.kept[k].is_none() && is_open(self, k));
        let k = free.unwrap_or_else(|| {
            let next = |k: usize| self.kept[k].map_or(0, |id| self.next_use(id));
            let open = all.clone().filter(|&k| is_open(self, k));
            open.max_by_key(|&k| next(k)).or(all.next()).unwrap_or_default()
        });
        if let Some(id) = self.kept[k].take() {
            if !self.is_elsewhere(id) && self.region.ops[id as usize] != Op::Exec {
                let reg = self.take();
                self.asm.spread_mask(reg, k as u8);
                self.hold(id, reg);
            }
            self.places[id as usize].home = 0;
        }
        self.kept_locked |= 1 << k;
        k as u8
    }

    fn keep(&mut self, id: Id, k: u8) {
        self.places[id as usize].home = k;
        self.kept[k as usize] = Some(id);
        self.kept_locked |= 1 << k;
    }

    /// The mask register of a mask, which stays there while the operation is made.
    fn ensure_mask(&mut self, id: Id) -> u8 {
        let home = self.places[id as usize].home;
        if home != 0 {
            self.kept_locked |= 1 << home;
            return home;
        }
        let k = self.take_mask();
        if self.region.ops[id as usize] == Op::Exec && !self.is_elsewhere(id) {
            self.asm.load_exec_mask(k, self.lane);
        } else {
            let reg = self.ensure(id);
            self.asm.gather_mask(k, reg);
        }
        self.keep(id, k);
        k
    }

    /// Masks of masks.
    fn combine(&mut self, id: Id, what: Binary, a: Id, b: Id) {
        let first = self.ensure_mask(a);
        if self.masks[b as usize] {
            let second = self.ensure_mask(b);
            self.used(a);
            self.used(b);
            let k = self.take_mask();
            self.asm.combine_masks(what, k, first, second);
            self.keep(id, k);
        } else {
            // The other has all bits set.
            self.used(a);
            self.used(b);
            let k = self.take_mask();
            self.asm.not_mask(k, first);
            self.keep(id, k);
        }
    }

    /// A value as a last source: in memory where that serves.
    fn source(&mut self, id: Id) -> Source {
        let from = I::from_memory(self.width);
        if !self.is_elsewhere(id) && from != FromMemory::Nothing {
            match self.region.ops[id as usize] {
                Op::Const(bits) if bits != 0 => {
                    let at = self.layout.constant(bits);
                    return if from == FromMemory::All { Source::Each(at) } else { Source::Mem(at) };
                }
                Op::Cell(cell) if !self.pinned[id as usize] && self.is_last_use(id) => {
                    match self.layout.address(cell) {
                        CellAddress::Each(at) => return Source::Mem(at + 4 * self.lane),
                        CellAddress::One(at) if from == FromMemory::All => return Source::Each(at),
                        CellAddress::One(_) => {}
                    }
                }
                _ => {}
            }
        }
        Source::Reg(self.ensure(id))
    }

    fn is_last_use(&self, id: Id) -> bool {
        self.uses[self.places[id as usize].next as usize + 1] == NONE
    }

    /// Whether a value is better read from memory than from a register.
    fn is_constant(&self, id: Id) -> bool {
        matches!(self.region.ops[id as usize], Op::Const(bits) if bits != 0)
            && self.places[id as usize].register == NOWHERE
    }

    fn operation(&mut self, id: Id) {
        let width = self.width;
        match self.region.ops[id as usize] {
            Op::Cell(_) | Op::Const(_) | Op::Exec => {}
            Op::Unary(what, a) => {
                let a_at = self.source(a);
                self.used(a);
                let to = self.result(&[a_at]);
                self.asm.unary(width, what, to, a_at);
                self.hold(id, to);
            }
            Op::Shift(Shift::Around, a, by) if !I::rotates(width) => {
                // Both ways, for want of an instruction.
                let from = self.ensure(a);
                let high = self.take();
                self.asm.shift(width, Shift::Up, high, from, by);
                self.used(a);
                let to = self.result(&[Source::Reg(from)]);
                self.asm.shift(width, Shift::Down, to, from, 32 - by);
                self.asm.binary(width, Binary::Or, to, to, Source::Reg(high));
                self.hold(id, to);
            }
            Op::Shift(what, a, by) => {
                let from = self.ensure(a);
                self.used(a);
                let to = self.result(&[Source::Reg(from)]);
                self.asm.shift(width, what, to, from, by);
                self.hold(id, to);
            }
            Op::Binary(what @ (Binary::IntDiv | Binary::IntRem | Binary::IntModulo), a, b) => {
                self.divide(id, what, a, b);
            }
            Op::Binary(what, a, b) if self.masks[id as usize] && !what.compares() => {
                self.combine(id, what, a, b);
            }
            Op::Binary(what, a, b) => self.binary(id, what, a, b),
            Op::Choose(m, a, b) => self.choose(id, m, a, b),
        }
    }

    /// A register for a result: one that a source has left, or another. Sources that are still needed keep theirs.
    fn result(&mut self, sources: &[Source]) -> u8 {
        for source in sources {
            if let Source::Reg(r) = *source
                && self.busy & 1 << r == 0
                && self.taken & 1 << r == 0
            {
                return r;
            }
        }
        self.take()
    }

    fn binary(&mut self, id: Id, what: Binary, mut a: Id, mut b: Id) {
        if what.commutes() && self.is_constant(a) && !self.is_constant(b) {
            std::mem::swap(&mut a, &mut b);
        }
        let width = self.width;
        let first = self.ensure(a);
        let second = self.source(b);
        self.used(a);
        self.used(b);
        if what.compares() && self.masks[id as usize] {
            let k = self.take_mask();
            self.asm.compare(width, what, k, first, second);
            self.keep(id, k);
            return;
        }
        let to = self.result(&[Source::Reg(first), second]);
        self.asm.binary(width, what, to, first, second);
        self.hold(id, to);
    }

    fn choose(&mut self, id: Id, m: Id, a: Id, b: Id) {
        if self.masks[m as usize] {
            let k = self.ensure_mask(m);
            let (no, yes) = (self.ensure(b), self.source(a));
            for x in [m, a, b] {
                self.used(x);
            }
            let to = self.result(&[Source::Reg(no), yes]);
            self.asm.choose_by_mask(self.width, to, k, yes, no);
            self.hold(id, to);
            return;
        }
        let mask = self.ensure(m);
        if I::choice(self.width) == Choice::IntoMask {
            let (yes, no) = (self.ensure(a), self.source(b));
            for x in [m, a, b] {
                self.used(x);
            }
            let is_ours = self.taken & 1 << mask == 0;
            let free = is_ours && self.busy & 1 << mask == 0 && mask != yes && no != Source::Reg(mask);
            let to = if free { mask } else { self.take() };
            if to != mask {
                self.asm.copy(self.width, to, mask);
            }
            self.asm.choose_into_mask(self.width, to, yes, no);
            self.hold(id, to);
            return;
        }
        let no = self.ensure(b);
        let yes = self.source(a);
        for x in [m, a, b] {
            self.used(x);
        }
        let to = self.result(&[Source::Reg(no), yes, Source::Reg(mask)]);
        self.asm.choose(self.width, to, mask, yes, no);
        self.hold(id, to);
    }

    fn divide(&mut self, id: Id, what: Binary, a: Id, b: Id) {
        let (first, second) = (self.ensure(a), self.ensure(b));
        self.asm.divide(self.width, what, first, second, self.areas);
        self.used(a);
        self.used(b);
        let to = self.take();
        self.asm.quotient(self.width, to, self.areas);
        self.hold(id, to);
    }
}
