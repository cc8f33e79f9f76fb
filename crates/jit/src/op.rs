// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations on lanes, and their meaning for one lane. A value is 32 bits a lane: a float, a whole number,
//! or a mask of ones or zeros.
//! Invariant: every back end computes the result of [`Op::apply`], bit for bit, except for the bits of NaNs and
//! of [`Unary::ToInt`] where a number is too high.
//! Tests: `tests/agreement.rs`.

/// Number of a value in its region.
pub(crate) type Id = u32;

/// One value of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Op {
    /// The contents of a cell of the memory at the region's start.
    Cell(u32),
    /// The same in all lanes.
    Const(u32),
    /// The mask of the lanes that run.
    Exec,
    /// Of one value.
    Unary(Unary, Id),
    /// Of two values.
    Binary(Binary, Id, Id),
    /// Bits moved by a number below 32.
    Shift(Shift, Id, u8),
    /// The second where the first, a mask, is set, else the third.
    Choose(Id, Id, Id),
}

/// Operations on one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Unary {
    Sqrt,
    Floor,
    Ceil,
    Trunc,
    /// Float to whole number, towards zero; the least one where it is too low. Where it is too high or NaN,
    /// machines differ, and [`term`](crate::term) chooses another value.
    ToInt,
    /// Whole number with sign to the nearest float.
    FromInt,
}

/// Operations on two values. Comparisons give masks; those of floats are false for NaN.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    And,
    Or,
    Xor,
    /// The first where it is less than the second, else the second.
    Min,
    /// The first where it is greater than the second, else the second.
    Max,
    Less,
    AtMost,
    Equal,
    IntAdd,
    IntSub,
    IntMul,
    IntMin,
    IntMax,
    IntGreater,
    IntEqual,
    /// 0 where the divisor is 0.
    IntDiv,
    /// With the sign of the first; 0 where the divisor is 0.
    IntRem,
    /// In [0, second) for positive seconds; 0 where the divisor is 0.
    IntModulo,
    /// Bits moved up by the second, which is below 32.
    Up,
    /// Down, zeros following.
    Down,
    /// Down, the sign following.
    SignedDown,
}

/// Bits moved by a fixed number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shift {
    Up,
    Down,
    /// Up, with the bits that leave at the top coming in below.
    Around,
}

const fn mask(x: bool) -> u32 {
    if x { !0 } else { 0 }
}

impl Unary {
    /// For one lane.
    pub(crate) fn apply(self, a: u32) -> u32 {
        let x = f32::from_bits(a);
        match self {
            Self::Sqrt => x.sqrt().to_bits(),
            Self::Floor => x.floor().to_bits(),
            Self::Ceil => x.ceil().to_bits(),
            Self::Trunc => x.trunc().to_bits(),
            Self::ToInt => {
                let fits = (-2_147_483_648.0..2_147_483_648.0).contains(&x);
                if fits { x as i32 as u32 } else { i32::MIN as u32 }
            }
            Self::FromInt => (a as i32 as f32).to_bits(),
        }
    }
}

impl Binary {
    /// For one lane.
    pub(crate) fn apply(self, a: u32, b: u32) -> u32 {
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        let (i, k) = (a as i32, b as i32);
        match self {
            Self::Add => (x + y).to_bits(),
            Self::Sub => (x - y).to_bits(),
            Self::Mul => (x * y).to_bits(),
            Self::Div => (x / y).to_bits(),
            Self::And => a & b,
            Self::Or => a | b,
            Self::Xor => a ^ b,
            Self::Min => {
                if x < y {
                    a
                } else {
                    b
                }
            }
            Self::Max => {
                if x > y {
                    a
                } else {
                    b
                }
            }
            Self::Less => mask(x < y),
            Self::AtMost => mask(x <= y),
            Self::Equal => mask(x == y),
            Self::IntAdd => a.wrapping_add(b),
            Self::IntSub => a.wrapping_sub(b),
            Self::IntMul => a.wrapping_mul(b),
            Self::IntMin => i.min(k) as u32,
            Self::IntMax => i.max(k) as u32,
            Self::IntGreater => mask(i > k),
            Self::IntEqual => mask(a == b),
            Self::IntDiv => (if k == 0 { 0 } else { i.wrapping_div(k) }) as u32,
            Self::IntRem => (if k == 0 { 0 } else { i.wrapping_rem(k) }) as u32,
            Self::IntModulo => {
                let rest = if k == 0 { 0 } else { i.wrapping_rem(k) };
                (if rest < 0 { rest.wrapping_add(k) } else { rest }) as u32
            }
            Self::Up => a << (b & 31),
            Self::Down => a >> (b & 31),
            Self::SignedDown => (i >> (b & 31)) as u32,
        }
    }

    /// Whether the order of the two does not matter, except for NaNs.
    pub(crate) const fn commutes(self) -> bool {
        matches!(
            self,
            Self::Add
                | Self::Mul
                | Self::And
                | Self::Or
                | Self::Xor
                | Self::IntAdd
                | Self::IntMul
                | Self::IntMin
                | Self::IntMax
                | Self::Equal
                | Self::IntEqual
        )
    }

    /// Whether a mask comes out.
    pub(crate) const fn compares(self) -> bool {
        matches!(self, Self::Less | Self::AtMost | Self::Equal | Self::IntGreater | Self::IntEqual)
    }
}

impl Shift {
    /// For one lane.
    pub(crate) const fn apply(self, a: u32, by: u8) -> u32 {
        match self {
            Self::Up => a << (by & 31),
            Self::Down => a >> (by & 31),
            Self::Around => a.rotate_left(by as u32),
        }
    }
}

impl Op {
    /// Calls `visit` with the values that it takes.
    pub(crate) fn operands(self, mut visit: impl FnMut(Id)) {
        match self {
            Self::Cell(_) | Self::Const(_) | Self::Exec => {}
            Self::Unary(_, a) | Self::Shift(_, a, _) => visit(a),
            Self::Binary(_, a, b) => {
                visit(a);
                visit(b);
            }
            Self::Choose(a, b, c) => {
                visit(a);
                visit(b);
                visit(c);
            }
        }
    }

    /// The same operation on other values.
    fn with_operands(self, of: impl Fn(Id) -> Id) -> Self {
        match self {
            Self::Cell(_) | Self::Const(_) | Self::Exec => self,
            Self::Unary(what, a) => Self::Unary(what, of(a)),
            Self::Shift(what, a, by) => Self::Shift(what, of(a), by),
            Self::Binary(what, a, b) => Self::Binary(what, of(a), of(b)),
            Self::Choose(m, a, b) => Self::Choose(of(m), of(a), of(b)),
        }
    }
}

/// Operations in a row, without branches: loads at the start, computations, and stores at the end.
/// Invariant: each operation is needed for a store or a test.
#[derive(Clone, Debug, Default)]
pub(crate) struct Region {
    /// In order; each takes earlier ones.
    pub(crate) ops: Vec<Op>,
    /// Cells and their new contents.
    pub(crate) stores: Vec<(u32, Id)>,
    /// Mask slots and the masks that they hold afterwards.
    pub(crate) tests: Vec<(u32, Id)>,
}

impl Region {
    /// Of recorded operations, without those that nothing needs.
    pub(crate) fn of(recorded: &[Op], mut stores: Vec<(u32, Id)>, mut tests: Vec<(u32, Id)>) -> Self {
        // First whether each is needed, then its new number.
        let mut numbers = vec![0; recorded.len()];
        for &(_, id) in stores.iter().chain(&tests) {
            numbers[id as usize] = 1;
        }
        let mut count = 0;
        for (i, op) in recorded.iter().enumerate().rev() {
            if numbers[i] != 0 {
                count += 1;
                op.operands(|id| numbers[id as usize] = 1);
            }
        }
        let mut ops = Vec::with_capacity(count);
        for (op, number) in recorded.iter().zip(0..) {
            if numbers[number] != 0 {
                let made = op.with_operands(|id| numbers[id as usize]);
                numbers[number] = ops.len() as Id;
                ops.push(made);
            }
        }
        stores.iter_mut().chain(&mut tests).for_each(|(_, id)| *id = numbers[*id as usize]);
        Self { ops, stores, tests }
    }

    /// The cells that it reads.
    pub(crate) fn reads(&self) -> impl Iterator<Item = u32> {
        self.ops.iter().filter_map(|op| match op {
            Op::Cell(cell) => Some(*cell),
            _ => None,
        })
    }
}
