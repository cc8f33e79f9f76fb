// SPDX-License-Identifier: GPL-3.0-or-later
//! The instructions of a region, and its register allocation.
//! Source: \[Bel66\] for the choice of a register to evict (the value that is needed last); original code. A
//! region has no branches, so one pass over it is enough. Constants and cells are loaded where they are
//! needed.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use crate::layout::{CellAddress, Layout};
use crate::op::{Binary, Id, Op, Region, Shift, Unary};

use super::asm::{Access, Asm, Code, Gpr, Rm, When, Width};

/// No register and no slot.
const NONE: u32 = u32::MAX;

/// The memory areas of regions other than cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Areas {
    /// Values that found no register, 64 bytes each.
    pub(crate) spills: u32,
    /// Two rows for divisions of whole numbers.
    pub(crate) scratch: u32,
    /// The bit of each lane, 32 bits each.
    pub(crate) lane_bits: u32,
}

struct Emitter<'a> {
    asm: &'a mut Asm,
    layout: &'a mut Layout,
    region: &'a Region,
    width: Width,
    areas: Areas,
    /// The first lane of this part.
    lane: u32,
    /// Indices where each value is used, in order, and where its list starts.
    uses: &'a [u32],
    starts: &'a [u32],
    next: Vec<u32>,
    register: Vec<u32>,
    spilled: Vec<u32>,
    holds: Vec<Option<Id>>,
    /// Cells that the region changes, so that they cannot be loaded again later.
    pinned: &'a [bool],
    /// Rooms that were taken, and those of them that are free again.
    spills: u32,
    free: Vec<u32>,
    locked: u32,
    /// Values that are masks, of AVX-512; their mask registers, 0 for none.
    masks: &'a [bool],
    home: Vec<u8>,
    kept: [Option<Id>; 8],
    kept_locked: u8,
}

/// Which values of a region are masks, and only made of such.
fn masks(region: &Region, width: Width) -> Vec<bool> {
    let mut masks = vec![false; region.ops.len()];
    for (i, op) in region.ops.iter().enumerate().filter(|_| width == Width::Sixteen) {
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

/// Writes the instructions of a region. Returns how many spill slots it needs.
pub(crate) fn region(asm: &mut Asm, layout: &mut Layout, region: &Region, width: Width, areas: Areas) -> u32 {
    let live = region.live();
    let count = region.ops.len();
    let mut starts = vec![0_u32; count + 1];
    let outs = region.stores.iter().chain(&region.tests);
    for (i, op) in region.ops.iter().enumerate() {
        if live[i] {
            op.operands(|id| starts[id as usize + 1] += 1);
        }
    }
    for &(_, id) in outs.clone() {
        starts[id as usize + 1] += 1;
    }
    for i in 0..count {
        starts[i + 1] += starts[i];
    }
    let mut fill = starts.clone();
    let mut uses = vec![0_u32; starts[count] as usize];
    let mut put = |id: Id, at: usize| {
        uses[fill[id as usize] as usize] = at as u32;
        fill[id as usize] += 1;
    };
    for (i, op) in region.ops.iter().enumerate() {
        if live[i] {
            op.operands(|id| put(id, i));
        }
    }
    for (k, &(_, id)) in outs.enumerate() {
        put(id, count + k);
    }
    let changed: Vec<u32> = region.stores.iter().map(|s| s.0).collect();
    let pinned: Vec<bool> =
        region.ops.iter().map(|op| matches!(op, Op::Cell(cell) if changed.contains(cell))).collect();
    let masks = masks(region, width);
    let mut most = 0;
    let lanes = if width == Width::One { 1 } else { layout.lanes };
    for lane in (0..lanes).step_by(width.lanes()) {
        let mut emitter = Emitter {
            asm,
            layout,
            region,
            width,
            areas,
            lane: lane as u32,
            uses: &uses,
            starts: &starts,
            next: starts[..count].to_vec(),
            register: vec![NONE; count],
            spilled: vec![NONE; count],
            holds: vec![None; width.registers()],
            pinned: &pinned,
            spills: 0,
            free: Vec::new(),
            locked: 0,
            masks: &masks,
            home: vec![0; count],
            kept: [None; 8],
            kept_locked: 0,
        };
        emitter.emit(&live, lane + width.lanes() >= lanes);
        most = most.max(emitter.spills);
    }
    most
}

impl Emitter<'_> {
    fn emit(&mut self, live: &[bool], last: bool) {
        // Constants and cells are loaded where they are needed, but cells that change are loaded before they do.
        for (i, &needed) in live.iter().enumerate() {
            if needed && self.pinned[i] {
                self.ensure(i as Id);
            }
        }
        self.locked = 0;
        for (i, &needed) in live.iter().enumerate() {
            if needed && !matches!(self.region.ops[i], Op::Cell(_) | Op::Const(_) | Op::Exec) {
                self.operation(i as Id);
                (self.locked, self.kept_locked) = (0, 0);
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
            self.used(id);
            self.locked = 0;
        }
        for k in 0..self.region.tests.len() {
            let (slot, id) = self.region.tests[k];
            if self.masks[id as usize] {
                let k = self.ensure_mask(id);
                self.asm.mask_to_eax(k);
            } else {
                let reg = self.ensure(id);
                self.asm.signs(self.width, reg);
            }
            let at = Layout::slot(slot);
            if self.lane > 0 {
                // A word that is stored in bytes is read late.
                self.asm.raw(&[0xc1, 0xe0, 0x08]); // shl eax, 8
                self.asm.access(Access::OrInto, Gpr::Eax, at);
            } else {
                self.asm.access(Access::Store, Gpr::Eax, at);
            }
            self.used(id);
            (self.locked, self.kept_locked) = (0, 0);
        }
    }

    /// The index of the next use of a value.
    fn next_use(&self, id: Id) -> u32 {
        let at = self.next[id as usize];
        if at < self.starts[id as usize + 1] { self.uses[at as usize] } else { NONE }
    }

    /// One use of a value is done; its register is free after the last one.
    fn used(&mut self, id: Id) {
        self.next[id as usize] += 1;
        if self.next_use(id) == NONE {
            let reg = std::mem::replace(&mut self.register[id as usize], NONE);
            if reg != NONE {
                self.holds[reg as usize] = None;
            }
            let area = self.spilled[id as usize];
            if area != NONE {
                self.free.push(area);
            }
            let k = std::mem::take(&mut self.home[id as usize]);
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
        let free = |e: &Self, r: usize| e.holds[r].is_none() && e.locked & 1 << r == 0;
        if let Some(r) = (0..self.holds.len()).find(|&r| free(self, r)) {
            self.locked |= 1 << r;
            return r as u8;
        }
        let (mut best, mut far) = (0, 0);
        for r in 0..self.holds.len() {
            if let (Some(id), 0) = (self.holds[r], self.locked & 1 << r) {
                // A value that can be loaded again costs less.
                let next = u64::from(self.next_use(id)) * 2 + u64::from(self.can_reload(id));
                if next >= far {
                    (best, far) = (r, next);
                }
            }
        }
        if let Some(id) = self.holds[best].take() {
            self.register[id as usize] = NONE;
            let is_kept = self.home[id as usize] != 0;
            if !is_kept && !self.can_reload(id) && self.spilled[id as usize] == NONE {
                let area = self.free.pop().unwrap_or_else(|| {
                    self.spills += 1;
                    self.spills - 1
                });
                self.spilled[id as usize] = area;
                self.store_whole(best as u8, self.areas.spills + 64 * area);
            }
        }
        self.locked |= 1 << best;
        best as u8
    }

    /// All bits of a register, of which some lanes may not count.
    fn store_whole(&mut self, reg: u8, at: u32) {
        self.asm.lanes(self.width, Code(0, 1, 0x11), reg, 0, Rm::Mem(at));
    }

    fn hold(&mut self, id: Id, reg: u8) {
        self.register[id as usize] = reg.into();
        self.holds[reg as usize] = Some(id);
        self.locked |= 1 << reg;
    }

    /// The register of a value, which stays there while the operation is made.
    fn ensure(&mut self, id: Id) -> u8 {
        let reg = self.register[id as usize];
        if reg != NONE {
            self.locked |= 1 << reg;
            return reg as u8;
        }
        let reg = self.take();
        if self.home[id as usize] != 0 {
            self.asm.spread_mask(reg, self.home[id as usize]);
        } else if self.spilled[id as usize] != NONE {
            let at = self.areas.spills + 64 * self.spilled[id as usize];
            self.asm.lanes(self.width, Code(0, 1, 0x10), reg, 0, Rm::Mem(at));
        } else {
            match self.region.ops[id as usize] {
                Op::Const(0) => self.asm.lanes(self.width, XOR, reg, reg, Rm::Reg(reg)),
                Op::Const(bits) => {
                    let at = self.layout.constant(bits);
                    match self.width {
                        Width::Sixteen => self.asm.load_each(self.width, reg, at),
                        _ => self.asm.lanes(self.width, Code(0, 1, 0x10), reg, 0, Rm::Mem(at)),
                    }
                }
                Op::Cell(cell) => match self.layout.address(cell) {
                    CellAddress::Each(at) => self.asm.load(self.width, reg, at + 4 * self.lane),
                    CellAddress::One(at) => self.asm.load_each(self.width, reg, at),
                },
                Op::Exec => self.exec(reg),
                _ => unreachable!("what is computed has a register or a room"),
            }
        }
        self.hold(id, reg);
        reg
    }

    /// A mask register: a free one, or the one whose mask is needed last. The first is for work.
    fn take_mask(&mut self) -> u8 {
        let is_open = |e: &Self, k: usize| e.kept_locked & 1 << k == 0;
        let free = (2..8).find(|&k| self.kept[k].is_none() && is_open(self, k));
        let k = free.unwrap_or_else(|| {
            let next = |k: usize| self.kept[k].map_or(0, |id| self.next_use(id));
            (2..8).filter(|&k| is_open(self, k)).max_by_key(|&k| next(k)).unwrap_or(2)
        });
        if let Some(id) = self.kept[k].take() {
            let is_elsewhere = self.register[id as usize] != NONE || self.spilled[id as usize] != NONE;
            if !is_elsewhere && self.region.ops[id as usize] != Op::Exec {
                let reg = self.take();
                self.asm.spread_mask(reg, k as u8);
                self.hold(id, reg);
            }
            self.home[id as usize] = 0;
        }
        self.kept_locked |= 1 << k;
        k as u8
    }

    fn keep(&mut self, id: Id, k: u8) {
        self.home[id as usize] = k;
        self.kept[k as usize] = Some(id);
        self.kept_locked |= 1 << k;
    }

    /// The mask register of a mask, which stays there while the operation is made.
    fn ensure_mask(&mut self, id: Id) -> u8 {
        let home = self.home[id as usize];
        if home != 0 {
            self.kept_locked |= 1 << home;
            return home;
        }
        let k = self.take_mask();
        let is_elsewhere = self.register[id as usize] != NONE || self.spilled[id as usize] != NONE;
        if self.region.ops[id as usize] == Op::Exec && !is_elsewhere {
            self.asm.load_mask(k, Layout::EXEC);
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
            let number = match what {
                Binary::And => 0x41,
                Binary::Or => 0x45,
                _ => 0x47,
            };
            let k = self.take_mask();
            self.asm.masks(number, k, first, second);
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

    fn exec(&mut self, reg: u8) {
        let at = Layout::EXEC;
        if self.width == Width::Sixteen {
            self.asm.load_mask(1, at);
            self.asm.spread_mask(reg, 1);
            return;
        }
        let bits = self.areas.lane_bits + 4 * self.lane;
        let long = Width::Eight;
        self.asm.lanes(long, Code(1, 2, 0x18), reg, 0, Rm::Mem(at));
        self.asm.lanes(long, AND, reg, reg, Rm::Mem(bits));
        self.asm.lanes(long, Code(1, 1, 0x76), reg, reg, Rm::Mem(bits));
    }

    /// A value as a second source: in memory where that serves.
    fn source(&mut self, id: Id) -> Rm {
        let here = self.register[id as usize];
        if here == NONE && self.spilled[id as usize] == NONE && self.width != Width::One {
            match self.region.ops[id as usize] {
                Op::Const(bits) if bits != 0 => {
                    let at = self.layout.constant(bits);
                    return if self.width == Width::Sixteen { Rm::Each(at) } else { Rm::Mem(at) };
                }
                Op::Cell(cell) if !self.pinned[id as usize] && self.uses_left(id) == 1 => {
                    match self.layout.address(cell) {
                        CellAddress::Each(at) => return Rm::Mem(at + 4 * self.lane),
                        CellAddress::One(at) if self.width == Width::Sixteen => return Rm::Each(at),
                        CellAddress::One(_) => {}
                    }
                }
                _ => {}
            }
        }
        Rm::Reg(self.ensure(id))
    }

    fn uses_left(&self, id: Id) -> u32 {
        self.starts[id as usize + 1] - self.next[id as usize]
    }

    /// Whether a value is better read from memory than from a register.
    fn is_constant(&self, id: Id) -> bool {
        matches!(self.region.ops[id as usize], Op::Const(bits) if bits != 0)
            && self.register[id as usize] == NONE
    }

    fn operation(&mut self, id: Id) {
        let width = self.width;
        match self.region.ops[id as usize] {
            Op::Cell(_) | Op::Const(_) | Op::Exec => {}
            Op::Unary(what, a) => {
                let (code, round) = match what {
                    Unary::Sqrt => (Code(0, 1, 0x51), None),
                    Unary::Floor => (Code(1, 3, 0x08), Some(9)),
                    Unary::Ceil => (Code(1, 3, 0x08), Some(10)),
                    Unary::Trunc => (Code(1, 3, 0x08), Some(11)),
                    Unary::ToInt => (Code(2, 1, 0x5b), None),
                    Unary::FromInt => (Code(0, 1, 0x5b), None),
                };
                let a_at = self.source(a);
                self.used(a);
                let to = self.result(&[a_at]);
                self.asm.lanes(width, code, to, 0, a_at);
                if let Some(mode) = round {
                    self.asm.raw(&[mode]);
                }
                self.hold(id, to);
            }
            Op::Shift(what, a, by) => {
                let a_at = Rm::Reg(self.ensure(a));
                let number = match what {
                    Shift::Up => 6,
                    Shift::Down => 2,
                    Shift::Around => 1,
                };
                let code = Code(1, 1, 0x72);
                if what == Shift::Around && width != Width::Sixteen {
                    // Both ways, for want of an instruction.
                    let high = self.take();
                    self.asm.lanes(width, code, 6, high, a_at);
                    self.asm.raw(&[by]);
                    self.used(a);
                    let to = self.result(&[a_at]);
                    self.asm.lanes(width, code, 2, to, a_at);
                    self.asm.raw(&[32 - by]);
                    self.asm.lanes(width, OR, to, to, Rm::Reg(high));
                    self.hold(id, to);
                    return;
                }
                self.used(a);
                let to = self.result(&[a_at]);
                self.asm.lanes(width, code, number, to, a_at);
                self.asm.raw(&[by]);
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
    fn result(&mut self, sources: &[Rm]) -> u8 {
        for source in sources {
            if let Rm::Reg(r) = *source
                && self.holds[r as usize].is_none()
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
            let (code, order) = comparison(what);
            self.asm.lanes(width, code, k, first, second);
            self.asm.raw(order.as_slice());
            self.keep(id, k);
            return;
        }
        let to = self.result(&[Rm::Reg(first), second]);
        if what.compares() {
            let (code, order) = comparison(what);
            self.asm.lanes(width, code, to, first, second);
            self.asm.raw(order.as_slice());
        } else {
            self.asm.lanes(width, code(what), to, first, second);
        }
        self.hold(id, to);
    }

    fn choose(&mut self, id: Id, m: Id, a: Id, b: Id) {
        if self.masks[m as usize] {
            let k = self.ensure_mask(m);
            let (no, yes) = (self.ensure(b), self.source(a));
            for x in [m, a, b] {
                self.used(x);
            }
            let to = self.result(&[Rm::Reg(no), yes]);
            self.asm.blend(to, k, yes, no);
            self.hold(id, to);
            return;
        }
        let mask = self.ensure(m);
        if self.width == Width::Sixteen {
            let (yes, no) = (self.ensure(a), self.source(b));
            for x in [m, a, b] {
                self.used(x);
            }
            let free = self.holds[mask as usize].is_none() && mask != yes && no != Rm::Reg(mask);
            let to = if free { mask } else { self.take() };
            if to != mask {
                self.asm.lanes(self.width, Code(0, 1, 0x28), to, 0, Rm::Reg(mask));
            }
            // The mask's bits choose between the other two.
            self.asm.lanes(self.width, Code(1, 3, 0x25), to, yes, no);
            self.asm.raw(&[0xca]);
            self.hold(id, to);
            return;
        }
        let no = self.ensure(b);
        let yes = self.source(a);
        for x in [m, a, b] {
            self.used(x);
        }
        let to = self.result(&[Rm::Reg(no), yes, Rm::Reg(mask)]);
        self.asm.lanes(self.width, Code(1, 3, 0x4a), to, no, yes);
        self.asm.raw(&[mask << 4]);
        self.hold(id, to);
    }

    /// Lane by lane, as the CPU has no division of whole numbers in lanes.
    fn divide(&mut self, id: Id, what: Binary, a: Id, b: Id) {
        let (first, second) = (self.ensure(a), self.ensure(b));
        let (x, y) = (self.areas.scratch, self.areas.scratch + 64);
        self.store_whole(first, x);
        self.store_whole(second, y);
        self.used(a);
        self.used(b);
        let indexed = |asm: &mut Asm, number: u8, reg: u8, at: u32| {
            asm.raw(&[number, 0x84 | reg << 3, 0x8b]);
            asm.raw(&at.to_le_bytes());
        };
        let asm = &mut *self.asm;
        let (top, special, done) = (asm.label(), asm.label(), asm.label());
        asm.raw(&[0x31, 0xc9]); // xor ecx, ecx
        asm.bind(top);
        indexed(asm, 0x8b, 0, x); // mov eax, [rbx+rcx*4+x]
        indexed(asm, 0x8b, 7, y); // mov edi, [rbx+rcx*4+y]
        asm.raw(&[0x8d, 0x57, 0x01]); // lea edx, [rdi+1]
        asm.raw(&[0x83, 0xfa, 0x01]); // cmp edx, 1
        asm.jump_if(When::AtMost, special);
        asm.raw(&[0x99, 0xf7, 0xff]); // cdq; idiv edi
        match what {
            Binary::IntDiv => {}
            Binary::IntRem => asm.raw(&[0x89, 0xd0]), // mov eax, edx
            _ => {
                asm.raw(&[0x89, 0xd0]);
                asm.raw(&[0x85, 0xc0, 0x79, 0x02]); // test eax, eax; jns over
                asm.raw(&[0x01, 0xf8]); // add eax, edi
            }
        }
        asm.jump(done);
        asm.bind(special);
        if what == Binary::IntDiv {
            // By 0 it is 0, by -1 the negative.
            asm.raw(&[0xf7, 0xd8, 0x21, 0xf8]); // neg eax; and eax, edi
        } else {
            asm.raw(&[0x31, 0xc0]); // xor eax, eax
        }
        asm.bind(done);
        indexed(asm, 0x89, 0, x); // mov [rbx+rcx*4+x], eax
        asm.raw(&[0xff, 0xc1]); // inc ecx
        asm.raw(&[0x83, 0xf9, self.width.lanes() as u8]); // cmp ecx, lanes
        asm.jump_if(When::NotZero, top);
        let to = self.take();
        self.asm.load(self.width, to, x);
        self.hold(id, to);
    }
}

const AND: Code = Code(1, 1, 0xdb);
const OR: Code = Code(1, 1, 0xeb);
const XOR: Code = Code(1, 1, 0xef);

/// A comparison, and the order that follows it for floats.
fn comparison(what: Binary) -> (Code, Option<u8>) {
    match what {
        Binary::IntEqual => (Code(1, 1, 0x76), None),
        Binary::IntGreater => (Code(1, 1, 0x66), None),
        Binary::Equal => (Code(0, 1, 0xc2), Some(0)),
        Binary::Less => (Code(0, 1, 0xc2), Some(1)),
        _ => (Code(0, 1, 0xc2), Some(2)),
    }
}

fn code(what: Binary) -> Code {
    match what {
        Binary::Add => Code(0, 1, 0x58),
        Binary::Sub => Code(0, 1, 0x5c),
        Binary::Mul => Code(0, 1, 0x59),
        Binary::Div => Code(0, 1, 0x5e),
        Binary::And => AND,
        Binary::Or => OR,
        Binary::Xor => XOR,
        Binary::IntAdd => Code(1, 1, 0xfe),
        Binary::IntSub => Code(1, 1, 0xfa),
        Binary::IntMul => Code(1, 2, 0x40),
        Binary::IntMin => Code(1, 2, 0x39),
        Binary::IntMax => Code(1, 2, 0x3d),
        Binary::Up => Code(1, 2, 0x47),
        Binary::Down => Code(1, 2, 0x45),
        Binary::SignedDown => Code(1, 2, 0x46),
        _ => unreachable!("made elsewhere"),
    }
}
