// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers of one point or of sixteen: code over [`Real`] is written once and compiled for both.
//! Space: that of the caller.
//! Invariant: every operation rounds lane by lane as that of `f32` does, and nothing is fused: one point and sixteen, at every
//! CPU level, give the same bits. Everything here is inlined into the functions that
//! `gnurt_simd::dispatch_wide!` enters; loops over lanes are written out, because a closure passed to an
//! adapter of arrays or iterators may become a call.
//! Tests: `tests`, and those of its users.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::Vec3;
use gnurt_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};

/// A float for each point.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f32, Output = Self>
{
    /// Yes or no for each point.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;

    /// How many points.
    const LANES: usize;

    /// `x` for all points; `self` only gives their number.
    fn all(self, x: f32) -> Self;
    /// The number of point `i`.
    fn lane(self, i: usize) -> f32;
    /// As many numbers for each point as the array has, those of point `i` being `f(i)`.
    fn each_of<const N: usize>(self, f: impl FnMut(usize) -> [f32; N]) -> [Self; N];
    /// Square root.
    fn root(self) -> Self;
    /// Without sign.
    fn size(self) -> Self;
    /// The greatest whole number that is no greater.
    fn whole(self) -> Self;
    /// The larger; neither may be NaN.
    fn or_more(self, other: Self) -> Self;
    /// The smaller; neither may be NaN.
    fn or_less(self, other: Self) -> Self;
    /// `self > other`.
    fn above(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn is(self, other: Self) -> Self::Mask;
    /// Neither infinite nor NaN.
    fn is_number(self) -> Self::Mask;
    /// `a` for the points of the mask, else `b`.
    fn pick(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// The points that the bits name.
    fn points(self, bits: u64) -> Self::Mask;
    /// Bits of the points in a mask.
    fn bits(mask: Self::Mask) -> u64;
    /// The next greater number after a finite one.
    fn next_up(self) -> Self;
    /// The next smaller number after a finite one.
    fn next_down(self) -> Self;
    /// Reads a number for each point, from index `at` on; zeros beyond the end.
    fn load(self, from: &[f32], at: usize) -> Self;
    /// Writes a number for each point, from index `at` on.
    fn store(self, to: &mut [f32], at: usize);
    /// Writes the numbers of the points in a mask side by side, from index `at` on; up to the number of
    /// points, elements behind them become undefined.
    fn squeeze(self, mask: Self::Mask, to: &mut [f32], at: usize);

    /// Calls `f` out of line: for rare work of points, so that it is compiled once instead of into every loop
    /// over points. `f` must be `#[inline(always)]`.
    fn outline<T>(self, f: impl FnOnce() -> T) -> T;

    /// The number of each point, that of point `i` being `f(i)`.
    #[inline(always)]
    fn each(self, mut f: impl FnMut(usize) -> f32) -> Self {
        let [each] = self.each_of(
            #[inline(always)]
            |i| [f(i)],
        );
        each
    }

    /// [`each_of`](Self::each_of) the points in a mask; zeros for the others, for which `f` is not called.
    #[inline(always)]
    fn each_where<const N: usize>(self, mask: Self::Mask, mut f: impl FnMut(usize) -> [f32; N]) -> [Self; N] {
        let bits = Self::bits(mask);
        self.each_of(
            #[inline(always)]
            |i| if bits >> i & 1 != 0 { f(i) } else { [0.0; N] },
        )
    }

    /// Whether the mask holds any point.
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        Self::bits(mask) != 0
    }

    /// `self > x`.
    #[inline(always)]
    fn above_all(self, x: f32) -> Self::Mask {
        self.above(self.all(x))
    }

    /// Within `low` and `high`.
    #[inline(always)]
    fn within(self, low: f32, high: f32) -> Self {
        self.or_more(self.all(low)).or_less(self.all(high))
    }

    /// One less it.
    #[inline(always)]
    fn rest(self) -> Self {
        self.all(1.0) - self
    }
}

impl Real for f32 {
    type Mask = bool;

    const LANES: usize = 1;

    #[inline(always)]
    fn all(self, x: f32) -> Self {
        x
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f32 {
        self
    }

    #[inline(always)]
    fn each_of<const N: usize>(self, mut f: impl FnMut(usize) -> [f32; N]) -> [Self; N] {
        f(0)
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn size(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn whole(self) -> Self {
        self.floor()
    }

    #[inline(always)]
    fn or_more(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn or_less(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn above(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn is(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn is_number(self) -> bool {
        self.is_finite()
    }

    #[inline(always)]
    fn pick(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn points(self, bits: u64) -> bool {
        bits & 1 != 0
    }

    #[inline(always)]
    fn bits(mask: bool) -> u64 {
        u64::from(mask)
    }

    #[inline(always)]
    fn next_up(self) -> Self {
        self.next_up()
    }

    #[inline(always)]
    fn next_down(self) -> Self {
        self.next_down()
    }

    #[inline(always)]
    fn load(self, from: &[f32], at: usize) -> Self {
        from.get(at).copied().unwrap_or(0.0)
    }

    #[inline(always)]
    fn store(self, to: &mut [f32], at: usize) {
        to[at] = self;
    }

    #[inline(always)]
    fn squeeze(self, mask: bool, to: &mut [f32], at: usize) {
        if mask {
            to[at] = self;
        }
    }

    #[inline(always)]
    fn outline<T>(self, f: impl FnOnce() -> T) -> T {
        outlined(f)
    }
}

impl<S: Simd> Real for f32x16<S> {
    type Mask = mask32x16<S>;

    const LANES: usize = 16;

    #[inline(always)]
    fn all(self, x: f32) -> Self {
        f32x16::splat(self.token(), x)
    }

    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        self[i]
    }

    #[inline(always)]
    fn each_of<const N: usize>(self, mut f: impl FnMut(usize) -> [f32; N]) -> [Self; N] {
        let (mut rows, mut each) = ([[0.0; 16]; N], [self; N]);
        for i in 0..16 {
            for (row, x) in rows.iter_mut().zip(f(i)) {
                row[i] = x;
            }
        }
        for (each, row) in each.iter_mut().zip(&rows) {
            *each = f32x16::from_slice(self.token(), row);
        }
        each
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn size(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn whole(self) -> Self {
        self.floor()
    }

    #[inline(always)]
    fn or_more(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn or_less(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        self.simd_gt(other)
    }

    #[inline(always)]
    fn is(self, other: Self) -> Self::Mask {
        self.simd_eq(other)
    }

    #[inline(always)]
    fn is_number(self) -> Self::Mask {
        self.is_finite()
    }

    #[inline(always)]
    fn pick(mask: Self::Mask, a: Self, b: Self) -> Self {
        mask.select(a, b)
    }

    #[inline(always)]
    fn points(self, bits: u64) -> Self::Mask {
        mask32x16::from_bitmask(self.token(), bits)
    }

    #[inline(always)]
    fn bits(mask: Self::Mask) -> u64 {
        mask.to_bitmask()
    }

    #[inline(always)]
    fn next_up(self) -> Self {
        next(self, false)
    }

    #[inline(always)]
    fn next_down(self) -> Self {
        next(self, true)
    }

    #[inline(always)]
    fn load(self, from: &[f32], at: usize) -> Self {
        match from.get(at..at + 16) {
            Some(part) => f32x16::from_slice(self.token(), part),
            None => {
                let mut lanes = [0.0; 16];
                for (lane, &x) in lanes.iter_mut().zip(from.get(at..).unwrap_or_default()) {
                    *lane = x;
                }
                f32x16::from_slice(self.token(), &lanes)
            }
        }
    }

    #[inline(always)]
    fn store(self, to: &mut [f32], at: usize) {
        self.store_slice(&mut to[at..at + 16]);
    }

    #[inline(always)]
    fn squeeze(self, mask: Self::Mask, to: &mut [f32], at: usize) {
        self.compress(mask).store_slice(&mut to[at..at + 16]);
    }

    #[inline(always)]
    fn outline<T>(self, f: impl FnOnce() -> T) -> T {
        let simd = self.token();
        // The function itself is compiled without the level's instructions: its body enters them again.
        outlined(
            #[inline(always)]
            move || simd.vectorize(f),
        )
    }
}

#[inline(never)]
fn outlined<T>(f: impl FnOnce() -> T) -> T {
    f()
}

/// The float after a finite one, or the one before if `down`.
#[inline(always)]
fn next<S: Simd>(x: f32x16<S>, down: bool) -> f32x16<S> {
    let simd = x.token();
    let bits: u32x16<S> = x.bitcast();
    let zero = f32x16::splat(simd, 0.0);
    let away = if down { x.simd_lt(zero) } else { x.simd_gt(zero) };
    let stepped = away.select(bits + 1, bits - 1);
    // From zero, to the smallest float of the sign.
    let least = u32x16::splat(simd, if down { 0x8000_0001 } else { 1 });
    x.simd_eq(zero).select(least, stepped).bitcast()
}

/// Three numbers for each point.
#[derive(Clone, Copy, Debug)]
pub struct Vector<R> {
    /// First components.
    pub x: R,
    /// Second components.
    pub y: R,
    /// Third components.
    pub z: R,
}

impl<Q> Vector<Q> {
    /// Changes each component by that of another.
    #[inline(always)]
    pub(crate) fn each_with<P>(&mut self, other: &Vector<P>, mut f: impl FnMut(&mut Q, &P)) {
        f(&mut self.x, &other.x);
        f(&mut self.y, &other.y);
        f(&mut self.z, &other.z);
    }
}

impl<R: Real> Vector<R> {
    /// From its components.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    /// A vector for each point of `like`, from index `at` on; zeros beyond the end.
    #[inline(always)]
    pub fn load(like: R, [x, y, z]: [&[f32]; 3], at: usize) -> Self {
        Self { x: like.load(x, at), y: like.load(y, at), z: like.load(z, at) }
    }

    /// See [`Real::squeeze`].
    #[inline(always)]
    pub fn squeeze(self, mask: R::Mask, [x, y, z]: [&mut [f32]; 3], at: usize) {
        self.x.squeeze(mask, x, at);
        self.y.squeeze(mask, y, at);
        self.z.squeeze(mask, z, at);
    }

    /// The same number in all components.
    #[inline(always)]
    pub fn grey(x: R) -> Self {
        Self { x, y: x, z: x }
    }

    /// The same for all points; `like` only gives their number.
    #[inline(always)]
    pub fn all(like: R, v: Vec3) -> Self {
        Self { x: like.all(v.x), y: like.all(v.y), z: like.all(v.z) }
    }

    /// That of point `i`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x.lane(i), self.y.lane(i), self.z.lane(i))
    }

    /// Each component by a function.
    #[inline(always)]
    pub fn map(self, f: impl Fn(R) -> R) -> Self {
        Self { x: f(self.x), y: f(self.y), z: f(self.z) }
    }

    /// Each pair of components by a function.
    #[inline(always)]
    pub fn with(self, other: Self, f: impl Fn(R, R) -> R) -> Self {
        Self { x: f(self.x, other.x), y: f(self.y, other.y), z: f(self.z, other.z) }
    }

    /// Without signs.
    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(R::size)
    }

    /// The larger of each pair of components.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.with(other, R::or_more)
    }

    /// The smaller of each pair of components.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.with(other, R::or_less)
    }

    /// Dot product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Cross product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Square of the length.
    #[inline(always)]
    pub fn length_squared(self) -> R {
        self.dot(self)
    }

    /// Other colours for the points in the mask, by the number of the point.
    #[inline(always)]
    pub fn each_colour(self, mask: R::Mask, f: impl Fn(usize, Vec3) -> Vec3) -> Self {
        let [x, y, z] = self.x.each_where(
            mask,
            #[inline(always)]
            |i| f(i, self.get(i)).into(),
        );
        Self::pick(mask, Self::new(x, y, z), self)
    }

    /// Divided by its length, as `Vec3::normalize` does it.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        let length = self.length_squared().root();
        self * (length.all(1.0) / length)
    }

    /// Divided by its length; `other` where it has none that is a number.
    #[inline(always)]
    pub fn normalize_or(self, other: Self) -> Self {
        let scale = self.x.all(1.0) / self.length_squared().root();
        Self::pick(scale.is_number() & scale.above_all(0.0), self * scale, other)
    }

    /// Each component over the divisor, as `Vec3 / f32` does it.
    #[inline(always)]
    pub fn over(self, divisor: R) -> Self {
        Self { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }

    /// Largest component.
    #[inline(always)]
    pub fn max_element(self) -> R {
        self.x.or_more(self.y).or_more(self.z)
    }

    /// Sum of the components.
    #[inline(always)]
    pub fn sum(self) -> R {
        self.x + self.y + self.z
    }

    /// Ones less it.
    #[inline(always)]
    pub fn rest(self) -> Self {
        self.map(R::rest)
    }

    /// Points at which all components are finite.
    #[inline(always)]
    pub fn is_finite(self) -> R::Mask {
        self.x.is_number() & self.y.is_number() & self.z.is_number()
    }

    /// Points at which all components are zero.
    #[inline(always)]
    pub fn is_zero(self) -> R::Mask {
        let zero = self.x.all(0.0);
        self.x.is(zero) & self.y.is(zero) & self.z.is(zero)
    }

    /// `a` where `mask` is set, else `b`.
    #[inline(always)]
    pub fn pick(mask: R::Mask, a: Self, b: Self) -> Self {
        Self { x: R::pick(mask, a.x, b.x), y: R::pick(mask, a.y, b.y), z: R::pick(mask, a.z, b.z) }
    }
}

impl From<Vec3> for Vector<f32> {
    fn from(v: Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vector<f32>> for Vec3 {
    fn from(v: Vector<f32>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<R: Real> Add for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<R: Real> Mul for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: R) -> Self {
        Self { x: self.x * scale, y: self.y * scale, z: self.z * scale }
    }
}

impl<R: Real> Neg for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
