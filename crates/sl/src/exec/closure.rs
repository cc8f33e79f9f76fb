// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations that make closures, for one point or for many at once, and their texts.
//! The printed form is OSL's. Tests: `tests/meaning/more.rs`, crates/jit/tests/agreement.rs.

use super::cells::{Cells, LANES};
use super::components::{Closures, Component, Number, Part};
use super::host::Host;
use super::machine::{Machine, Step};
use super::slot::Slot;
use super::strings::Strings;
use crate::format::general;
use crate::hir::Data;
use crate::opcode::Opcode;
use crate::types::{Base, Type};
use std::sync::Arc;

/// Bytes of a closure as a text; one more component may follow.
const LONGEST: usize = 1 << 20;
/// Closures within closures that are printed.
const DEEPEST: usize = 64;
/// The mark of omitted text.
const CUT: &str = "...";

/// Whether an operation makes closures of others, or of numbers.
#[must_use]
pub fn makes_closures(step: &Step) -> bool {
    let out = step.args.first().map_or(Type::VOID, |out| out.ty);
    out == Type::CLOSURE && matches!(step.code, Opcode::Closure | Opcode::Add | Opcode::Mul)
}

/// Does it for one point. A component is none, and there is a message, if the program does not support it.
pub(super) fn closure(m: &mut Machine<'_>, s: &Step) {
    let Some(out) = s.args.first() else { return };
    let Machine { closures, host, strings, memory, .. } = m;
    let number = made(closures, (*host, strings), s, 1, |cell| Cells::One(memory[cell as usize]));
    m.set_bits(out, 0, number.map_or(0, |row| row[0]));
    if number.is_none() {
        let name = s.args.get(1).map_or_else(|| "".into(), |name| m.text(name));
        let (layer, shader) = m.layer_names();
        let source_position = m.source_position(s.at);
        m.error(format!(
            "Closure '{name}' is not supported by the current renderer, called from {source_position} in shader \"{shader}\", layer {} \"{layer}\", group \"{}\"",
            m.layer, m.plan.name
        ));
    }
}

/// The closures of some points; `read` returns the contents of cells. `None` if closures of its name are
/// unknown, or if names differ between points. The result may be among the operands, as in `Ci = layer (coat,
/// Ci)`.
fn made<'c>(
    closures: &mut Closures,
    known: (&dyn Host, &Strings),
    s: &Step,
    lanes: u32,
    read: impl Fn(u32) -> Cells<'c>,
) -> Option<[u32; LANES]> {
    let [_, a, rest @ ..] = &*s.args else { return Some([0; LANES]) };
    if s.code == Opcode::Closure {
        // Without a list of them: this is done for each point.
        let first = closures.next();
        let mut buffer = [0; LANES];
        let decl = resolve(known, (a, rest), &read, |found| {
            let cells = match found {
                None => Cells::One(0),
                Some((cell, Change::Made)) => match read(cell) {
                    Cells::One(cell_bits) => Cells::One(closures.made(cell_bits)),
                    cells @ Cells::Each(_) => {
                        buffer = closures.all_made(cells);
                        Cells::Each(&buffer)
                    }
                },
                Some((cell, change)) => changed(read(cell), change, &mut buffer),
            };
            closures.put(cells);
        });
        return decl.map(|(kind, _)| [closures.component(kind, first); LANES]);
    }
    let [b, ..] = rest else { return Some([0; LANES]) };
    let (a, b) = if a.ty == Type::CLOSURE { (a, b) } else { (b, a) };
    let left = read(a.at);
    Some(if b.ty == Type::CLOSURE {
        closures.sum(lanes, left, read(b.at))
    } else {
        let mut rooms = [[0; LANES]; 3];
        let mut k = 0;
        let weight = rooms.each_mut().map(|buffer| {
            k += 1;
            number(b, k - 1, Kind::Float, &read, buffer)
        });
        closures.times(lanes, weight, left)
    })
}

/// The type of a number.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Float,
    Int,
    Text,
    Closure,
}

fn kind(ty: Type) -> Option<Kind> {
    match ty.base {
        Base::Int => Some(Kind::Int),
        Base::String => Some(Kind::Text),
        Base::Closure => Some(Kind::Closure),
        base if base.is_float_based() => Some(Kind::Float),
        _ => None,
    }
}

/// How a word becomes a number of another kind.
#[derive(Clone, Copy, Debug)]
enum Change {
    Nothing,
    FromInt,
    ToInt,
    /// A closure, if there is one of that number.
    Made,
}

/// Where number `i` of a slot is, and how it becomes one of a kind; none if it has none. Single numbers serve
/// for all components.
fn source(slot: &Slot, i: usize, expected: Kind) -> Option<(u32, Change)> {
    let i = if slot.size == 1 { 0 } else { i };
    let found = kind(slot.ty).filter(|_| i < slot.size as usize)?;
    let change = match (expected, found) {
        (Kind::Closure, Kind::Closure) => Change::Made,
        (expected, found) if expected == found => Change::Nothing,
        (Kind::Float, Kind::Int) => Change::FromInt,
        (Kind::Int, Kind::Float) => Change::ToInt,
        _ => return None,
    };
    Some((slot.at + i as u32, change))
}

fn changed<'r, 'c: 'r>(cells: Cells<'c>, change: Change, buffer: &'r mut [u32; LANES]) -> Cells<'r> {
    let of = |cell_bits: u32| match change {
        Change::Nothing | Change::Made => cell_bits,
        Change::FromInt => (cell_bits as i32 as f32).to_bits(),
        Change::ToInt => f32::from_bits(cell_bits) as i32 as u32,
    };
    match (change, cells) {
        (Change::Nothing | Change::Made, cells) => cells,
        (_, Cells::One(cell_bits)) => Cells::One(of(cell_bits)),
        (_, Cells::Each(row)) => {
            *buffer = row.map(of);
            Cells::Each(buffer)
        }
    }
}

/// Number `i` of a slot as one of a kind; zeros where it has none.
fn number<'r, 'c: 'r>(
    slot: &Slot,
    i: usize,
    expected: Kind,
    read: &impl Fn(u32) -> Cells<'c>,
    buffer: &'r mut [u32; LANES],
) -> Cells<'r> {
    source(slot, i, expected).map_or(Cells::One(0), |(cell, change)| changed(read(cell), change, buffer))
}

/// Which closure a name and its arguments make, and its own name; `with` gets the place of each of its numbers
/// in order, none of those that are not given. `None` if the program does not support it, or if names are not
/// the same for all points; `with` gets nothing then.
fn resolve<'h, 'c>(
    (host, strings): (&'h dyn Host, &Strings),
    (name, rest): (&Slot, &[Slot]),
    read: &impl Fn(u32) -> Cells<'c>,
    mut with: impl FnMut(Option<(u32, Change)>),
) -> Option<(u32, &'h Arc<str>)> {
    let text = |slot: &Slot| match (slot.ty.base, slot.size) {
        (Base::String, 1..) => match read(slot.at) {
            Cells::One(cell_bits) => Some(&**strings.text(cell_bits)),
            Cells::Each(_) => None,
        },
        _ => Some(""),
    };
    let name = text(name)?;
    let (kind_of, decl) = host.closures().iter().enumerate().find(|(_, decl)| *decl.name == *name)?;
    let plain = decl.params.iter().take_while(|param| !param.is_keyword).count();
    let pairs = rest.get(plain..).filter(|_| plain < decl.params.len()).unwrap_or(&[]);
    let mut keys = Vec::new();
    for pair in pairs.chunks_exact(2) {
        keys.push((text(&pair[0])?, &pair[1]));
    }
    for (i, param) in decl.params.iter().enumerate() {
        let slot = match param.is_keyword {
            false => rest.get(i),
            true => keys.iter().rfind(|(name, _)| *name == &*param.name).map(|(_, slot)| *slot),
        };
        for k in 0..param.ty.size() {
            // One number is not meant for all of an array's.
            let slot = slot.filter(|slot| k < slot.size as usize);
            with(slot.zip(kind(param.ty)).and_then(|(slot, expected)| source(slot, k, expected)));
        }
    }
    Some((kind_of as u32, &decl.name))
}

/// A component that an operation makes: which one, and where its numbers are.
#[derive(Clone, Debug)]
pub struct Bound {
    kind: u32,
    /// Of the closure, as the program has it: by where it lies it is known again.
    name: Arc<str>,
    /// All numbers, with those that never change.
    numbers: Box<[Number]>,
    /// The others: which one, and where it is.
    open: Box<[(u32, u32, Change)]>,
}

impl Bound {
    /// Of a name and its arguments; none if the program does not support it, or if names are not the same for
    /// all points. Cells that are `fixed` are read now, others by the numbers that `place` gives them.
    fn of<'c>(
        known: (&dyn Host, &Strings),
        closure: (&Slot, &[Slot]),
        read: &impl Fn(u32) -> Cells<'c>,
        fixed: &impl Fn(u32) -> bool,
        place: &impl Fn(u32) -> u32,
    ) -> Option<Self> {
        let (mut numbers, mut open) = (Vec::new(), Vec::new());
        let mut buffer = [0; LANES];
        let (kind, name) = resolve(known, closure, read, |found| {
            let mut number = Number::default();
            if let Some((cell, change)) = found {
                let is_closure = matches!(change, Change::Made);
                match changed(read(cell), change, &mut buffer) {
                    Cells::One(bits) if fixed(cell) && !is_closure => number = Number::one(bits),
                    _ => open.push((numbers.len() as u32, place(cell), change)),
                }
            }
            numbers.push(number);
        })?;
        Some(Self { kind, name: name.clone(), numbers: numbers.into(), open: open.into() })
    }

    /// Makes it; its number. `read` returns what is at a place.
    fn make<'c>(&self, closures: &mut Closures, read: &impl Fn(u32) -> Cells<'c>) -> u32 {
        let first = closures.put_all(&self.numbers);
        let mut buffer = [0; LANES];
        for &(index, place, change) in &self.open {
            let at = first + index;
            match change {
                // Most of them.
                Change::Nothing => closures.replace(at, read(place)),
                Change::Made => match read(place) {
                    Cells::One(cell_bits) => closures.replace(at, Cells::One(closures.made(cell_bits))),
                    cells @ Cells::Each(_) => {
                        buffer = closures.all_made(cells);
                        closures.replace(at, Cells::Each(&buffer));
                    }
                },
                change => closures.replace(at, changed(read(place), change, &mut buffer)),
            }
        }
        closures.component(self.kind, first)
    }
}

impl Machine<'_> {
    /// Does an operation that [makes closures](makes_closures) for some points at once; `read` returns the
    /// contents of cells. `None` if it must be done one point after the other.
    pub fn make_closures<'c>(
        &mut self,
        step: &Step,
        lanes: u32,
        read: impl Fn(u32) -> Cells<'c>,
    ) -> Option<[u32; LANES]> {
        made(&mut self.closures, (self.host, &self.strings), step, lanes, read)
    }

    /// Resolves the component of an operation with constant names; `read` returns the contents of cells, `fixed` whether they
    /// never change, and `place` by which number [`make_component`](Self::make_component) asks for them.
    /// `None` if it is unknown, or if the operation makes none.
    pub fn bind_component<'c>(
        &self,
        step: &Step,
        read: impl Fn(u32) -> Cells<'c>,
        fixed: impl Fn(u32) -> bool,
        place: impl Fn(u32) -> u32,
    ) -> Option<Bound> {
        let [_, name, rest @ ..] = &*step.args else { return None };
        let known = (self.host, &self.strings);
        let bind = || Bound::of(known, (name, rest), &read, &fixed, &place);
        (step.code == Opcode::Closure).then(bind).flatten()
    }

    /// Makes a resolved component, for all points, of what is at its places; none if it was resolved for another program.
    pub fn make_component<'c>(&mut self, bound: &Bound, read: impl Fn(u32) -> Cells<'c>) -> Option<u32> {
        let decl = self.host.closures().get(bound.kind as usize)?;
        Arc::ptr_eq(&decl.name, &bound.name).then(|| bound.make(&mut self.closures, &read))
    }

    /// The components of the point's closure with their weights, in order.
    #[must_use]
    pub fn components(&self, number: u32) -> Vec<([f32; 3], Component)> {
        self.components_of(number, self.lane)
    }

    /// Those of another point of the batch.
    #[must_use]
    pub fn components_of(&self, number: u32, lane: usize) -> Vec<([f32; 3], Component)> {
        let parts = self.closures.parts(number, lane).into_iter();
        parts.filter_map(|(weight, part)| Some((weight, self.describe(&part, lane)?))).collect()
    }

    fn describe(&self, part: &Part<'_>, lane: usize) -> Option<Component> {
        let decl = self.host.closures().get(part.kind as usize)?;
        let mut first = 0;
        let params = decl.params.iter().map(|param| {
            let cells_bits: Vec<u32> =
                (first..first + param.ty.size()).map(|i| part.cells(i).at(lane)).collect();
            first += cells_bits.len();
            let data = match kind(param.ty) {
                Some(Kind::Text) => {
                    Data::Str(cells_bits.iter().map(|&w| self.strings.text(w).clone()).collect())
                }
                Some(Kind::Int | Kind::Closure) => Data::Int(cells_bits.iter().map(|&w| w as i32).collect()),
                _ => Data::Float(cells_bits.iter().map(|&w| f32::from_bits(w)).collect()),
            };
            (param.is_keyword.then(|| param.name.clone()), param.ty, data)
        });
        Some(Component { name: decl.name.clone(), params: params.collect() })
    }

    /// As `printf` shows it. A text beyond the limit of length, or nested in more than 64 others, ends in
    /// three points.
    #[must_use]
    pub fn closure_text(&self, number: u32) -> String {
        let mut out = String::new();
        self.write_closure(&mut out, number, 0);
        out
    }

    fn write_closure(&self, out: &mut String, number: u32, depth: usize) {
        if depth > DEEPEST {
            out.push_str(CUT);
            return;
        }
        let mut is_first = true;
        self.closures.each_part(number, self.lane, |w, part| {
            if out.len() > LONGEST {
                if !out.ends_with(CUT) {
                    out.push_str(CUT);
                }
                return false;
            }
            let Some(component) = self.describe(&part, self.lane) else { return true };
            if !std::mem::take(&mut is_first) {
                out.push_str("\n\t+ ");
            }
            out.push_str(&format!("{} * {} (", triple(&w), component.name));
            for (k, (key, ty, value)) in component.params.iter().enumerate() {
                if k > 0 {
                    out.push_str(", ");
                }
                if let Some(key) = key {
                    out.push_str(&format!("\"{key}\", "));
                }
                let is_array = ty.elements() > 1;
                out.push_str(if is_array { "[" } else { "" });
                self.write_param(out, *ty, value, depth);
                out.push_str(if is_array { "]" } else { "" });
            }
            out.push(')');
            true
        });
    }

    fn write_param(&self, out: &mut String, ty: Type, value: &Data, depth: usize) {
        let cells_bits: Vec<String> = match value {
            Data::Int(list) if ty.base == Base::Closure => {
                for (i, &number) in list.iter().enumerate() {
                    out.push_str(if i > 0 { ", " } else { "" });
                    self.write_closure(out, number as u32, depth + 1);
                }
                return;
            }
            Data::Int(list) => list.iter().map(ToString::to_string).collect(),
            Data::Str(list) => list.iter().map(|s| format!("\"{s}\"")).collect(),
            Data::Float(list) if ty.base.is_triple() => list.chunks(3).map(triple).collect(),
            Data::Float(list) => list.iter().map(|&f| general(f64::from(f), 6)).collect(),
        };
        out.push_str(&cells_bits.join(", "));
    }
}

fn triple(v: &[f32]) -> String {
    let cells_bits: Vec<String> = v.iter().map(|&f| general(f64::from(f), 6)).collect();
    format!("({})", cells_bits.join(", "))
}
