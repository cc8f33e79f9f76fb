// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces over a rectangle of parameters, as rows of quad strips.
//! Units: parameters in [0, 1]. Tests: tests of the shapes.

use crate::sink::{Mode, Sink, Vertex};

/// Most cells along one side.
pub const MOST: u32 = 1 << 15;

/// The number as a count of cells, if it is one: `least` to [`MOST`].
#[must_use]
pub fn cells(count: i32, least: u32) -> Option<u32> {
    u32::try_from(count).ok().filter(|n| (least..=MOST).contains(n))
}

/// Gives `columns * rows` quads of `surface(s, t)`. They are counter-clockwise seen from the side of ds x dt.
pub fn emit(sink: &mut dyn Sink, columns: u32, rows: u32, surface: impl Fn(f64, f64) -> Vertex) {
    let at = |column: u32, row: u32| {
        surface(f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows))
    };
    for row in 0..rows {
        sink.begin(Mode::QuadStrip);
        for column in 0..=columns {
            // The strip's first triangle is (this one, the one above, its right neighbour): from the back, so upper first.
            sink.vertex(at(column, row + 1));
            sink.vertex(at(column, row));
        }
        sink.end();
    }
}
