// SPDX-License-Identifier: GPL-3.0-or-later
//! The numbers of points that a group's code reads, and how they get into its memory: by rows of sixteen, each written by
//! one instruction where there is one, because lanes that are loaded from several stores are waited for.
//! Tests: `tests/agreement.rs`, `tests/chance.rs`.

use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*, u32x16};
use gnurt_sl::exec::{DualRow, LANES, Points, Row, Slot};

use crate::layout::{CellAddress, Layout};
use crate::program::{Call, Node, Program};
use crate::term::QuickSet;

/// A row of numbers of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    P(u8),
    I(u8),
    Ps(u8),
    U,
    V,
    N(u8),
    Ng(u8),
    DPdu(u8),
    DPdv(u8),
    DPdtime(u8),
    Time,
    DTime,
    Xi(u8),
    Raster(u8),
    /// Of values without changes.
    Zeros,
}

/// A row, and the word of memory where it starts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input {
    source: Source,
    /// The number, its change to the right or its change downwards.
    part: u8,
    at: u32,
    /// Whether memory has it for each lane; else the first number is for all.
    is_row: bool,
}

/// The rows of a global that are components of a triple, or the single one.
fn sources(name: &str) -> &'static [Source] {
    use Source as S;
    match name {
        "P" => &[S::P(0), S::P(1), S::P(2)],
        "I" => &[S::I(0), S::I(1), S::I(2)],
        "Ps" => &[S::Ps(0), S::Ps(1), S::Ps(2)],
        "u" => &[S::U],
        "v" => &[S::V],
        "N" => &[S::N(0), S::N(1), S::N(2)],
        "Ng" => &[S::Ng(0), S::Ng(1), S::Ng(2)],
        "dPdu" => &[S::DPdu(0), S::DPdu(1), S::DPdu(2)],
        "dPdv" => &[S::DPdv(0), S::DPdv(1), S::DPdv(2)],
        "dPdtime" => &[S::DPdtime(0), S::DPdtime(1), S::DPdtime(2)],
        "time" => &[S::Time],
        "dtime" => &[S::DTime],
        "xi" => &[S::Xi(0), S::Xi(1)],
        "raster" => &[S::Raster(0), S::Raster(1)],
        _ => &[],
    }
}

impl Source {
    fn has_changes(self) -> bool {
        matches!(self, Self::P(_) | Self::I(_) | Self::Ps(_) | Self::U | Self::V)
    }
}

impl Input {
    /// Those of a global whose cells code reads.
    pub(crate) fn of_global(name: &str, slot: &Slot, layout: &Layout, reads: &QuickSet<u32>) -> Vec<Self> {
        let mut inputs = Vec::new();
        for (i, &source) in sources(name).iter().enumerate() {
            for part in 0..if slot.derivs { 3 } else { 1 } {
                let cell = slot.at + u32::from(part) * slot.size + i as u32;
                if reads.contains(&cell) {
                    let is_constant = part > 0 && !source.has_changes();
                    let source = if is_constant { Source::Zeros } else { source };
                    let (at, is_row) = match layout.address(cell) {
                        CellAddress::Each(at) => (at / 4, true),
                        CellAddress::One(at) => (at / 4, false),
                    };
                    inputs.push(Self { source, part, at, is_row });
                }
            }
        }
        inputs
    }

    #[inline(always)]
    fn row(self, points: &Points) -> &Row {
        const ZEROS: &Row = &[0.0; LANES];
        match self.source {
            Source::P(i) => part(&points.p[usize::from(i)], self.part),
            Source::I(i) => part(&points.i[usize::from(i)], self.part),
            Source::Ps(i) => part(&points.ps[usize::from(i)], self.part),
            Source::U => part(&points.u, self.part),
            Source::V => part(&points.v, self.part),
            Source::N(i) => &points.n[usize::from(i)],
            Source::Ng(i) => &points.ng[usize::from(i)],
            Source::DPdu(i) => &points.dpdu[usize::from(i)],
            Source::DPdv(i) => &points.dpdv[usize::from(i)],
            Source::DPdtime(i) => &points.dpdtime[usize::from(i)],
            Source::Time => &points.time,
            Source::DTime => &points.dtime,
            Source::Xi(i) => &points.xi[usize::from(i)],
            Source::Raster(i) => &points.raster[usize::from(i)],
            Source::Zeros => ZEROS,
        }
    }
}

#[inline(always)]
fn part(row: &DualRow, part: u8) -> &Row {
    match part {
        0 => &row.value,
        1 => &row.dx,
        _ => &row.dy,
    }
}

/// Writes the inputs of a batch into memory, whose lanes start at `first`.
pub(crate) fn write(level: Level, inputs: &[Input], points: &Points, memory: &mut [u32], first: usize) {
    dispatch_wide!(
        level,
        simd => each(inputs, points, memory, first, |row, to| {
            let row: u32x16<_> = f32x16::from_slice(simd, row).bitcast();
            row.store_slice(to);
        }),
        else each(inputs, points, memory, first, |row, to| {
            to.iter_mut().zip(row).for_each(|(to, x)| *to = x.to_bits());
        })
    );
}

#[inline(always)]
fn each(
    inputs: &[Input],
    points: &Points,
    memory: &mut [u32],
    first: usize,
    copy: impl Fn(&Row, &mut [u32; LANES]),
) {
    for input in inputs {
        let row = input.row(points);
        let at = input.at as usize;
        if !input.is_row {
            memory[at] = row[0].to_bits();
        } else if let Some(to) = memory[at + first..].first_chunk_mut() {
            copy(row, to);
        }
    }
}

/// The cells that a program reads.
pub(crate) fn reads(program: &Program) -> QuickSet<u32> {
    let mut cells = QuickSet::default();
    program.layers.iter().for_each(|layer| of_nodes(&layer.code, &mut cells));
    for call in &program.calls {
        let ins = match call {
            Call::Step { ins, .. } | Call::Together { ins, .. } => ins,
            Call::Closure(making) => &making.ins,
            Call::Userdata { .. } | Call::Stopped { .. } => continue,
        };
        ins.iter().for_each(|slot| cells.extend(slot.at..slot.at + slot.cells() as u32));
    }
    cells
}

fn of_nodes(nodes: &[Node], cells: &mut QuickSet<u32>) {
    for node in nodes {
        match node {
            Node::Region(region) => cells.extend(region.reads()),
            Node::If { yes, no, .. } => [yes, no].into_iter().for_each(|part| of_nodes(part, cells)),
            Node::Loop(inner) => {
                [&inner.test, &inner.body, &inner.step].into_iter().for_each(|part| of_nodes(part, cells));
            }
            Node::Tight(inner) => {
                [&inner.before, &inner.iteration].into_iter().for_each(|part| of_nodes(part, cells));
            }
            Node::Frame { body, .. } | Node::Once { body, .. } => of_nodes(body, cells),
            Node::Call(_) | Node::Layer(_) | Node::Leave(_) | Node::LeaveSome { .. } => {}
        }
    }
}
