// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers that record operations: the library's functions, called with these, become operations of a region.
//! So every function of `gnurt-sl-lib` over a `Number` is compiled into the code of a shader, derivatives
//! included, and has the bits of a direct call, without a second text of it.
//! Invariant: one thread records one region at a time.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use gnurt_sl_lib::{Real, UInts};

use crate::op::{Binary, Id, Op, Shift, Unary};

/// A float of each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term(pub(crate) Id);

/// A word of each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits(pub(crate) Id);

/// A yes or no of each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Which(pub(crate) Id);

/// A quick hash for small keys.
#[derive(Default)]
pub(crate) struct Quick(u64);

impl Hasher for Quick {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.write_u64(b.into());
        }
    }

    fn write_u8(&mut self, x: u8) {
        self.write_u64(x.into());
    }

    fn write_u32(&mut self, x: u32) {
        self.write_u64(x.into());
    }

    fn write_u64(&mut self, x: u64) {
        self.0 = (self.0.rotate_left(5) ^ x).wrapping_mul(0x517c_c1b7_2722_0a95);
    }

    fn write_isize(&mut self, x: isize) {
        self.write_u64(x as u64);
    }

    fn write_usize(&mut self, x: usize) {
        self.write_u64(x as u64);
    }
}

pub(crate) type QuickMap<K, V> = HashMap<K, V, BuildHasherDefault<Quick>>;
pub(crate) type QuickSet<K> = HashSet<K, BuildHasherDefault<Quick>>;

#[derive(Default)]
struct Record {
    ops: Vec<Op>,
    known: QuickMap<Op, Id>,
}

thread_local! {
    static RECORD: RefCell<Record> = RefCell::default();
}

/// Takes the record, and starts a new one.
pub(crate) fn take() -> Vec<Op> {
    RECORD.with_borrow_mut(|record| {
        record.known.clear();
        std::mem::take(&mut record.ops)
    })
}

/// How much was recorded.
pub(crate) fn count() -> usize {
    RECORD.with_borrow(|record| record.ops.len())
}

/// The operation of a value.
pub(crate) fn op_of(id: Id) -> Op {
    RECORD.with_borrow(|record| record.ops[id as usize])
}

/// What takes the place of an operation.
enum Simpler {
    Known(Id),
    Other(Op),
}

const ONE: u32 = 1.0_f32.to_bits();
const NEGATIVE_ZERO: u32 = 1 << 31;

/// The same value by less work, bit for bit except for the bits of NaNs.
fn simpler(ops: &[Op], op: Op) -> Simpler {
    let constant = |id: Id| match ops[id as usize] {
        Op::Const(x) => Some(x),
        _ => None,
    };
    match op {
        Op::Binary(what, a, b) => {
            // A constant comes second.
            let (a, b) = if what.commutes() && constant(a).is_some() { (b, a) } else { (a, b) };
            match (what, constant(b)) {
                (Binary::Mul | Binary::Div, Some(ONE)) | (Binary::Add, Some(NEGATIVE_ZERO)) => {
                    return Simpler::Known(a);
                }
                (Binary::Sub | Binary::IntAdd | Binary::IntSub | Binary::Or | Binary::Xor, Some(0)) => {
                    return Simpler::Known(a);
                }
                (Binary::And, Some(u32::MAX)) => return Simpler::Known(a),
                (Binary::Xor, Some(bits)) => {
                    if let Op::Binary(Binary::Xor, inner, by) = ops[a as usize]
                        && constant(by) == Some(bits)
                    {
                        return Simpler::Known(inner);
                    }
                }
                (Binary::And | Binary::Or, None) if a == b => return Simpler::Known(a),
                _ => {}
            }
            Simpler::Other(Op::Binary(what, a, b))
        }
        Op::Choose(mask, yes, no) => {
            // A mask that was turned around.
            let (mask, yes, no) = match ops[mask as usize] {
                Op::Binary(Binary::Xor, inner, ones) if constant(ones) == Some(u32::MAX) => (inner, no, yes),
                _ => (mask, yes, no),
            };
            extreme(ops, mask, yes, no).map_or(Simpler::Other(Op::Choose(mask, yes, no)), Simpler::Other)
        }
        _ => Simpler::Other(op),
    }
}

/// A choice between the two values that the mask compares, as a minimum or maximum with the same zeros, and the same of both
/// where one is NaN.
fn extreme(ops: &[Op], mask: Id, yes: Id, no: Id) -> Option<Op> {
    let Op::Binary(what @ (Binary::Less | Binary::AtMost), low, high) = ops[mask as usize] else {
        return None;
    };
    let is_number = |id: Id| match ops[id as usize] {
        Op::Const(bits) => !f32::from_bits(bits).is_nan() && f32::from_bits(bits) != 0.0,
        _ => false,
    };
    // Where both are equal, the other one is taken: the same bits, unless they are zeros.
    if what == Binary::AtMost && !is_number(low) && !is_number(high) {
        return None;
    }
    match (what, (yes, no) == (low, high), (yes, no) == (high, low)) {
        (Binary::Less, true, _) => Some(Op::Binary(Binary::Min, low, high)),
        (Binary::Less, _, true) => Some(Op::Binary(Binary::Max, high, low)),
        // `low` where it is at most `high`, else `high`, also for NaN.
        (_, true, _) => Some(Op::Binary(Binary::Min, low, high)),
        (_, _, true) => Some(Op::Binary(Binary::Max, high, low)),
        _ => None,
    }
}

/// Records an operation; one that was recorded before, or whose values are constants, is not recorded again.
#[inline(never)]
pub(crate) fn push(op: Op) -> Id {
    RECORD.with_borrow_mut(|record| {
        let constant = |id: Id| match record.ops[id as usize] {
            Op::Const(x) => Some(x),
            _ => None,
        };
        let folded = match op {
            Op::Unary(what, a) => constant(a).map(|a| what.apply(a)),
            Op::Shift(what, a, by) => constant(a).map(|a| what.apply(a, by)),
            Op::Binary(what, a, b) => constant(a).zip(constant(b)).map(|(a, b)| what.apply(a, b)),
            Op::Choose(m, a, b) => match constant(m) {
                Some(0) => return b,
                Some(u32::MAX) => return a,
                _ if a == b => return a,
                _ => None,
            },
            _ => None,
        };
        let op = match folded {
            Some(bits) => Op::Const(bits),
            None => match simpler(&record.ops, op) {
                Simpler::Known(id) => return id,
                Simpler::Other(op) => op,
            },
        };
        *record.known.entry(op).or_insert_with(|| {
            record.ops.push(op);
            (record.ops.len() - 1) as Id
        })
    })
}

pub(crate) fn constant(bits: u32) -> Id {
    push(Op::Const(bits))
}

pub(crate) fn unary(what: Unary, a: Id) -> Id {
    push(Op::Unary(what, a))
}

pub(crate) fn binary(what: Binary, a: Id, b: Id) -> Id {
    if let (Binary::Div, Op::Const(divisor)) = (what, op_of(b))
        && let Some(inverse) = exact_inverse(divisor)
    {
        return push(Op::Binary(Binary::Mul, a, constant(inverse)));
    }
    push(Op::Binary(what, a, b))
}

/// One over a power of two, where that is a normal number, too: products with it are the quotients, bit for bit.
fn exact_inverse(bits: u32) -> Option<u32> {
    let exponent = bits >> 23 & 0xff;
    let is_power = bits << 9 == 0 && (1..=253).contains(&exponent);
    is_power.then_some(bits & 1 << 31 | (254 - exponent) << 23)
}

macro_rules! operators {
    ($ty:ident, $plain:ty, $bits:expr; $($trait:ident $method:ident $what:ident;)*) => {$(
        impl $trait for $ty {
            type Output = Self;

            #[inline]
            fn $method(self, other: Self) -> Self {
                Self(binary(Binary::$what, self.0, other.0))
            }
        }

        impl $trait<$plain> for $ty {
            type Output = Self;

            #[inline]
            fn $method(self, other: $plain) -> Self {
                Self(binary(Binary::$what, self.0, constant($bits(other))))
            }
        }
    )*};
}

operators! { Term, f32, f32::to_bits; Add add Add; Sub sub Sub; Mul mul Mul; Div div Div; }
operators! { Bits, u32, |x: u32| x; Add add IntAdd; Sub sub IntSub; BitXor bitxor Xor; BitAnd bitand And; BitOr bitor Or; }

impl Neg for Term {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(binary(Binary::Xor, self.0, constant(1 << 31)))
    }
}

impl Shl<u32> for Bits {
    type Output = Self;

    #[inline]
    fn shl(self, by: u32) -> Self {
        Self(push(Op::Shift(Shift::Up, self.0, by as u8)))
    }
}

impl Shr<u32> for Bits {
    type Output = Self;

    #[inline]
    fn shr(self, by: u32) -> Self {
        Self(push(Op::Shift(Shift::Down, self.0, by as u8)))
    }
}

impl BitAnd for Which {
    type Output = Self;

    #[inline]
    fn bitand(self, other: Self) -> Self {
        Self(binary(Binary::And, self.0, other.0))
    }
}

impl BitOr for Which {
    type Output = Self;

    #[inline]
    fn bitor(self, other: Self) -> Self {
        Self(binary(Binary::Or, self.0, other.0))
    }
}

impl Not for Which {
    type Output = Self;

    #[inline]
    fn not(self) -> Self {
        Self(binary(Binary::Xor, self.0, constant(!0)))
    }
}

impl UInts for Bits {
    type Mask = Which;

    fn constant(self, x: u32) -> Self {
        Self(constant(x))
    }

    fn equal(self, x: u32) -> Which {
        Which(binary(Binary::IntEqual, self.0, constant(x)))
    }

    fn below(self, x: u32) -> Which {
        // Without signs: both moved by half of the range.
        let moved = binary(Binary::Xor, self.0, constant(1 << 31));
        Which(binary(Binary::IntGreater, constant(x ^ (1 << 31)), moved))
    }

    fn pick(mask: Which, a: Self, b: Self) -> Self {
        Self(push(Op::Choose(mask.0, a.0, b.0)))
    }

    fn bit_of(self, bits: u32) -> Self {
        Self(binary(Binary::Down, constant(bits), self.0)) & 1
    }

    fn wrapped(self, period: Self) -> Self {
        Self(binary(Binary::IntModulo, self.0, period.0))
    }

    fn rotated(self, by: u32) -> Self {
        Self(push(Op::Shift(Shift::Around, self.0, by as u8)))
    }

    fn signed_max(self, other: Self) -> Self {
        Self(binary(Binary::IntMax, self.0, other.0))
    }

    fn signed_min(self, other: Self) -> Self {
        Self(binary(Binary::IntMin, self.0, other.0))
    }

    fn above(self, other: Self) -> Which {
        Which(binary(Binary::IntGreater, self.0, other.0))
    }

    fn same(self, other: Self) -> Which {
        Which(binary(Binary::IntEqual, self.0, other.0))
    }

    fn product(self, other: Self) -> Self {
        Self(binary(Binary::IntMul, self.0, other.0))
    }

    fn quotient(self, other: Self) -> Self {
        Self(binary(Binary::IntDiv, self.0, other.0))
    }

    fn remainder(self, other: Self) -> Self {
        Self(binary(Binary::IntRem, self.0, other.0))
    }

    fn moved_up(self, by: Self) -> Self {
        Self(binary(Binary::Up, self.0, (by & 31).0))
    }

    fn moved_down(self, by: Self) -> Self {
        Self(binary(Binary::SignedDown, self.0, (by & 31).0))
    }
}

impl Real for Term {
    type UInts = Bits;
    type Mask = Which;

    fn of(self, x: f32) -> Self {
        Self(constant(x.to_bits()))
    }

    fn less(self, other: Self) -> Which {
        Which(binary(Binary::Less, self.0, other.0))
    }

    fn at_most(self, other: Self) -> Which {
        Which(binary(Binary::AtMost, self.0, other.0))
    }

    fn equal(self, other: Self) -> Which {
        Which(binary(Binary::Equal, self.0, other.0))
    }

    fn choose(mask: Which, a: Self, b: Self) -> Self {
        Self(push(Op::Choose(mask.0, a.0, b.0)))
    }

    fn abs(self) -> Self {
        Self(binary(Binary::And, self.0, constant(!(1 << 31))))
    }

    fn sqrt(self) -> Self {
        Self(unary(Unary::Sqrt, self.0))
    }

    fn floor(self) -> Self {
        Self(unary(Unary::Floor, self.0))
    }

    fn ceil(self) -> Self {
        Self(unary(Unary::Ceil, self.0))
    }

    fn trunc(self) -> Self {
        Self(unary(Unary::Trunc, self.0))
    }

    fn copysign(self, sign: Self) -> Self {
        let sign = binary(Binary::And, sign.0, constant(1 << 31));
        Self(binary(Binary::Or, self.abs().0, sign))
    }

    fn bits(self) -> Bits {
        Bits(self.0)
    }

    fn from_bits(bits: Bits) -> Self {
        Self(bits.0)
    }

    fn to_int(self) -> Bits {
        let cut = unary(Unary::ToInt, self.0);
        let too_high = binary(Binary::AtMost, constant(2_147_483_648.0_f32.to_bits()), self.0);
        let cut = push(Op::Choose(too_high, constant(i32::MAX as u32), cut));
        Bits(binary(Binary::And, cut, binary(Binary::Equal, self.0, self.0)))
    }

    fn from_int(x: Bits) -> Self {
        Self(unary(Unary::FromInt, x.0))
    }

    fn from_unsigned(x: Bits) -> Self {
        // Both halves are exact; their sum is rounded once.
        Self::from_int(x >> 16) * 65536.0 + Self::from_int(x & 0xffff)
    }

    fn outline<T>(work: impl FnOnce() -> T) -> T {
        work()
    }
}
