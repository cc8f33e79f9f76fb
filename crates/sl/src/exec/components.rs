// SPDX-License-Identifier: GPL-3.0-or-later
//! The data of closures: nodes of sums, weights and components, each made for many points of a batch at once.
//! A node is identified by its number, counted from 1; 0 is no closure. Its numbers are consecutive in one
//! memory, each either once for all points of the node, or in a row. For other points they are undefined.
//! Invariant: nodes refer only to earlier nodes. Tests: `tests/meaning/more.rs`.

use super::cells::{Cells, LANES, mapped};
use crate::hir::Data;
use crate::types::Type;
use std::fmt;
use std::sync::Arc;

/// One parameter of a closure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClosureParam {
    /// Its name.
    pub name: Arc<str>,
    /// Its type.
    pub ty: Type,
    /// Whether shaders give it by its name, after the others: `"thinfilm_ior", 1.3`.
    pub is_keyword: bool,
}

impl ClosureParam {
    /// A parameter that shaders give by its position.
    #[must_use]
    pub fn new(name: &str, ty: Type) -> Self {
        Self { name: name.into(), ty, is_keyword: false }
    }

    /// A parameter that shaders may give by its name, after all others.
    #[must_use]
    pub fn keyword(name: &str, ty: Type) -> Self {
        Self { name: name.into(), ty, is_keyword: true }
    }
}

/// The declaration of a closure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClosureDecl {
    /// Its name.
    pub name: Arc<str>,
    /// Its parameters: keywords come last.
    pub params: Arc<[ClosureParam]>,
}

impl fmt::Display for ClosureDecl {
    /// As a shader declares it: `diffuse (normal N)`. Keywords are in quotes: `"thinfilm_ior" float`.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} (", self.name)?;
        for (number, param) in self.params.iter().enumerate() {
            out.write_str(if number > 0 { ", " } else { "" })?;
            match param.is_keyword {
                true => write!(out, "\"{}\" {}", param.name, param.ty)?,
                false => write!(out, "{} {}", param.ty, param.name)?,
            }
        }
        out.write_str(")")
    }
}

/// A component of one point by itself.
#[derive(Clone, Debug)]
pub struct Component {
    /// Its name.
    pub name: Arc<str>,
    /// Its parameters' values and keys.
    pub params: Vec<(Option<Arc<str>>, Type, Data)>,
}

/// A component as it was made.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Its index in the list of closures that the program supports: see
    /// [`Host::closures`](super::Host::closures).
    pub kind: u32,
    nodes: &'a Closures,
    first: u32,
}

impl<'a> Part<'a> {
    /// Number `i` of its parameters', which follow each other: three of a colour.
    #[inline]
    #[must_use]
    pub fn cells(&self, i: usize) -> Cells<'a> {
        self.nodes.cells(self.first as usize + i)
    }
}

/// A node. Colours are floats' bits, closures are numbers of nodes.
#[derive(Clone, Copy, Debug)]
pub enum Closure<'a> {
    /// A part of weight 1.
    Component(Part<'a>),
    /// A part times a weight.
    Mul([Cells<'a>; 3], Cells<'a>),
    /// Two parts.
    Add(Cells<'a>, Cells<'a>),
}

#[derive(Clone, Copy, Debug)]
enum What {
    Component(u32),
    Mul,
    Add,
}

/// The kind of a node, and the first of its numbers.
#[derive(Clone, Copy, Debug)]
struct Node {
    what: What,
    first: u32,
}

/// A number of a node: its bits, or which row it has.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Number {
    pub(super) bits: u32,
    is_row: bool,
}

impl Number {
    /// The same for all points.
    pub(super) const fn one(bits: u32) -> Self {
        Self { bits, is_row: false }
    }
}

/// The nodes of a batch.
#[derive(Clone, Debug, Default)]
pub struct Closures {
    nodes: Vec<Node>,
    numbers: Vec<Number>,
    /// Numbers that differ from point to point.
    rows: Vec<[u32; LANES]>,
}

/// Words of a batch's nodes; closures beyond are dropped.
const MOST: usize = 1 << 22;
/// Limit of separate components of one point: sums of sums may have any number.
const MOST_PARTS: usize = 1 << 16;
/// Limit of nodes visited for them.
const MOST_VISITS: usize = 1 << 22;

impl Closures {
    /// Removes all nodes.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.numbers.clear();
        self.rows.clear();
    }

    #[inline]
    fn cells(&self, number: usize) -> Cells<'_> {
        let number = self.numbers.get(number).copied().unwrap_or_default();
        match self.rows.get(number.bits as usize) {
            Some(row) if number.is_row => Cells::Each(row),
            _ => Cells::One(number.bits),
        }
    }

    /// Node `number`; none for 0.
    #[inline]
    #[must_use]
    pub fn node(&self, number: u32) -> Option<Closure<'_>> {
        let node = self.nodes.get((number as usize).checked_sub(1)?)?;
        let cells = |i: usize| self.cells(node.first as usize + i);
        Some(match node.what {
            What::Component(kind) => Closure::Component(Part { kind, nodes: self, first: node.first }),
            What::Mul => Closure::Mul([cells(0), cells(1), cells(2)], cells(3)),
            What::Add => Closure::Add(cells(0), cells(1)),
        })
    }

    /// Adds a number of the node that is made by [`component`](Self::component) next.
    #[inline]
    pub(super) fn put(&mut self, cells: Cells) {
        let number = self.number(cells);
        self.numbers.push(number);
    }

    /// Adds numbers that are the same for all points; the first of them.
    pub(super) fn put_all(&mut self, numbers: &[Number]) -> u32 {
        self.numbers.extend_from_slice(numbers);
        (self.numbers.len() - numbers.len()) as u32
    }

    /// Another number in the place of one that was added.
    #[inline(always)]
    pub(super) fn replace(&mut self, at: u32, cells: Cells) {
        let number = self.number(cells);
        if let Some(place) = self.numbers.get_mut(at as usize) {
            *place = number;
        }
    }

    #[inline(always)]
    fn number(&mut self, cells: Cells) -> Number {
        match cells {
            Cells::One(bits) => Number::one(bits),
            Cells::Each(row) => {
                // Copied once: `push` does it by way of the stack.
                self.rows.extend_from_slice(std::slice::from_ref(row));
                Number { bits: self.rows.len() as u32 - 1, is_row: true }
            }
        }
    }

    /// How many numbers there are: the first of the node that comes next.
    pub(super) fn next(&self) -> u32 {
        self.numbers.len() as u32
    }

    /// Makes a component of the numbers from `first` on; its number, 0 if there are too many.
    pub(super) fn component(&mut self, kind: u32, first: u32) -> u32 {
        self.add(What::Component(kind), first)
    }

    fn add(&mut self, what: What, first: u32) -> u32 {
        if self.numbers.len() + LANES * self.rows.len() > MOST {
            // Nor are its numbers stored.
            let own = self.numbers.get(first as usize..).unwrap_or(&[]);
            let rows = own.iter().filter(|number| number.is_row).count();
            self.rows.truncate(self.rows.len() - rows);
            self.numbers.truncate(first as usize);
            return 0;
        }
        self.nodes.push(Node { what, first });
        self.nodes.len() as u32
    }

    /// A closure's number, if there is such a closure yet: connections and files may give any number.
    pub(super) fn made(&self, number: u32) -> u32 {
        if number as usize <= self.nodes.len() { number } else { 0 }
    }

    /// The sum of two closures of each of some points.
    pub(super) fn sum(&mut self, lanes: u32, a: Cells, b: Cells) -> [u32; LANES] {
        let (left, right) = (self.all_made(a), self.all_made(b));
        let mut out = [0; LANES];
        let mut is_both = [false; LANES];
        for lane in 0..LANES {
            let (left, right) = (left[lane], right[lane]);
            out[lane] = if left == 0 { right } else { left };
            is_both[lane] = left != 0 && right != 0;
        }
        let both = lanes & bits(is_both);
        if both != 0 {
            let first = self.next();
            self.put(shared(a, both));
            self.put(shared(b, both));
            set(&mut out, is_both, self.add(What::Add, first));
        }
        out
    }

    /// A closure times a colour (floats' bits) of each of some points.
    pub(super) fn times(&mut self, lanes: u32, weight: [Cells; 3], inner: Cells) -> [u32; LANES] {
        let mut out = self.all_made(inner);
        let mut is_weighed = [false; LANES];
        let [x, y, z] = weight;
        if let (Cells::One(x), Cells::One(y), Cells::One(z)) = (x, y, z) {
            let [x, y, z] = [f32::from_bits(x), f32::from_bits(y), f32::from_bits(z)];
            if x == 0.0 && y == 0.0 && z == 0.0 {
                return [0; LANES];
            }
            if x != 1.0 || y != 1.0 || z != 1.0 {
                is_weighed = mapped(&out, |inner| inner != 0);
            }
        } else {
            let [x, y, z] = [row(x), row(y), row(z)];
            for lane in 0..LANES {
                let [x, y, z] = [x[lane], y[lane], z[lane]].map(f32::from_bits);
                let is_black = (x == 0.0) & (y == 0.0) & (z == 0.0);
                let is_plain = (x == 1.0) & (y == 1.0) & (z == 1.0);
                out[lane] = if is_black { 0 } else { out[lane] };
                is_weighed[lane] = (out[lane] != 0) & !is_plain;
            }
        }
        let weighed = lanes & bits(is_weighed);
        if weighed != 0 {
            let first = self.next();
            weight.into_iter().for_each(|cells| self.put(cells));
            self.put(shared(inner, weighed));
            set(&mut out, is_weighed, self.add(What::Mul, first));
        }
        out
    }

    /// [`made`](Self::made) of each point.
    pub(super) fn all_made(&self, numbers: Cells) -> [u32; LANES] {
        let most = self.nodes.len() as u32;
        match numbers {
            Cells::One(number) => [self.made(number); LANES],
            Cells::Each(row) => mapped(row, |number| if number <= most { number } else { 0 }),
        }
    }

    /// The components of a point's closure with their weights, in order: of node `number`; at most the first
    /// 65,536.
    #[must_use]
    pub fn parts(&self, number: u32, lane: usize) -> Vec<([f32; 3], Part<'_>)> {
        let mut out = Vec::new();
        self.each_part(number, lane, |weight, part| {
            out.push((weight, part));
            true
        });
        out
    }

    /// The same one after the other, until `with` ends it.
    pub(super) fn each_part<'a>(
        &'a self,
        number: u32,
        lane: usize,
        mut with: impl FnMut([f32; 3], Part<'a>) -> bool,
    ) {
        let mut open = vec![(number, [1.0_f32; 3])];
        let mut parts = 0;
        for _ in 0..MOST_VISITS {
            let Some((number, w)) = open.pop() else { return };
            match self.node(number) {
                Some(Closure::Component(part)) => {
                    parts += 1;
                    if !with(w, part) || parts == MOST_PARTS {
                        return;
                    }
                }
                Some(Closure::Mul(weight, inner)) => {
                    let of = |k: usize| f32::from_bits(weight[k].at(lane)) * w[k];
                    open.push((inner.at(lane), [of(0), of(1), of(2)]));
                }
                Some(Closure::Add(a, b)) => {
                    open.push((b.at(lane), w));
                    open.push((a.at(lane), w));
                }
                None => {}
            }
        }
    }
}

/// The same numbers, as one if some points agree.
fn shared(cells: Cells<'_>, lanes: u32) -> Cells<'_> {
    let Cells::Each(row) = cells else { return cells };
    let one = row[lanes.trailing_zeros() as usize % LANES];
    if lanes & bits(mapped(row, |number| number != one)) == 0 { Cells::One(one) } else { cells }
}

fn row(cells: Cells) -> [u32; LANES] {
    match cells {
        Cells::One(cell_bits) => [cell_bits; LANES],
        Cells::Each(row) => *row,
    }
}

/// A bit for each point.
fn bits(is: [bool; LANES]) -> u32 {
    is.iter().enumerate().fold(0, |bits, (lane, &is)| bits | u32::from(is) << lane)
}

fn set(out: &mut [u32; LANES], is: [bool; LANES], number: u32) {
    for (out, is) in out.iter_mut().zip(is) {
        *out = if is { number } else { *out };
    }
}
