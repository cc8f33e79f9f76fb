// SPDX-License-Identifier: GPL-3.0-or-later
//! Values between the vertices of a primitive, with first and second derivatives. Source: Embree's manual.
//! Takes no memory but for subdivision surfaces: programs call it for each hit. Tests: `tests/c/embree.c`, `tests/c/grids.c`,
//! `tests/c/subdivision.c`, `tests/c/interpolate.c`.

use gnurt_accel::CurveBasis;
use gnurt_subdivision::Place;

use crate::cells::{decoded, grid_of};
use crate::device::Problem;
use crate::ffi_abi::buffer;
use crate::ffi_memory::View;
use crate::objects::{Kind, Settings};

/// A value, its derivatives by u, v, uu, vv and uv.
pub(crate) type Jet = [f32; 6];

/// Where values are asked for.
#[derive(Clone, Copy)]
pub(crate) struct Query {
    pub(crate) prim_id: u32,
    pub(crate) uv: [f32; 2],
    pub(crate) buffer: u32,
    pub(crate) slot: u32,
    pub(crate) count: u32,
}

/// Corners of a triangle: the one with the remaining weight, and those weighted by u and v; by how much a derivative is of
/// these, by u and by v.
struct Corners {
    of: [u32; 3],
    uv: [f32; 2],
    scale: [f32; 2],
}

impl Corners {
    /// Of the half of a quad that holds a point.
    fn of_quad([a, b, c, d]: [u32; 4], [u, v]: [f32; 2], [columns, rows]: [f32; 2]) -> Self {
        if u + v <= 1.0 {
            Self { of: [a, b, d], uv: [u, v], scale: [columns, rows] }
        } else {
            Self { of: [c, d, b], uv: [1.0 - u, 1.0 - v], scale: [-columns, -rows] }
        }
    }
}

fn view(settings: &Settings, of: u32, slot: u32) -> Result<&View, Problem> {
    let array = settings.arrays.get(&(of, slot)).map(|array| &array.view);
    array.ok_or_else(|| Problem::argument(format!("buffer of type {of} missing in slot {slot}")))
}

/// The rows of a query.
///
/// # Errors
/// There are none.
pub(crate) fn rows<'a>(settings: &'a Settings, query: &Query) -> Result<&'a View, Problem> {
    view(settings, query.buffer, query.slot)
}

/// Calls `each` for all values of these [`rows`].
///
/// # Errors
/// A missing array or primitive, rows that are too narrow, or a kind without values between vertices.
pub(crate) fn interpolate(
    kind: Kind,
    settings: &Settings,
    rows: &View,
    query: Query,
    each: &mut dyn FnMut(usize, Jet),
) -> Result<(), Problem> {
    let Query { prim_id, uv: [u, v], .. } = query;
    let none = || Problem::argument(format!("primitive {prim_id} is out of range"));
    let i = prim_id as usize;
    let corners = match kind {
        Kind::Triangles => {
            let of = view(settings, buffer::INDEX, 0)?.get(i).ok_or_else(none)?;
            Corners { of, uv: [u, v], scale: [1.0; 2] }
        }
        Kind::Quads => {
            Corners::of_quad(view(settings, buffer::INDEX, 0)?.get(i).ok_or_else(none)?, [u, v], [1.0; 2])
        }
        Kind::Grids => {
            let grid = grid_of(view(settings, buffer::GRID, 0)?, i).ok_or_else(none)?;
            let size = grid.cells();
            if size == [0, 0] {
                return Err(Problem::argument(format!("grid {prim_id} has no cell")));
            }
            let find = |x: f32, cells: u32| {
                // NaN is the first.
                let cell = (x * cells as f32).floor().clamp(0.0, (cells - 1) as f32) as u32;
                (cell, x * cells as f32 - cell as f32)
            };
            let ((column, u), (row, v)) = (find(u, size[0]), find(v, size[1]));
            Corners::of_quad(grid.quad(column, row), [u, v], size.map(|cells| cells as f32))
        }
        Kind::Curves(basis, _) => return of_curve(basis, settings, rows, query, each),
        Kind::Cones => return of_curve(CurveBasis::Linear, settings, rows, query, each),
        Kind::Subdivision => return of_surface(settings, rows, query, each),
        kind => return Err(Problem::operation(format!("interpolation is unsupported for {kind:?}"))),
    };
    let Corners { of, uv: [u, v], scale } = corners;
    check(rows, of, query.count)?;
    for k in 0..query.count as usize {
        let [a, b, c] = [at(rows, of[0], k)?, at(rows, of[1], k)?, at(rows, of[2], k)?];
        let value = (1.0 - u - v) * a + u * b + v * c;
        each(k, [value, scale[0] * (b - a), scale[1] * (c - a), 0.0, 0.0, 0.0]);
    }
    Ok(())
}

fn at(rows: &View, row: u32, k: usize) -> Result<f32, Problem> {
    let none = || Problem::argument(format!("value {k} of vertex {row} is not in the buffer"));
    rows.number(row as usize, k).ok_or_else(none)
}

/// All or nothing: rows are as wide as their last value.
fn check(rows: &View, of: impl IntoIterator<Item = u32>, count: u32) -> Result<(), Problem> {
    match count.checked_sub(1) {
        Some(last) => of.into_iter().try_for_each(|row| at(rows, row, last as usize).map(drop)),
        None => Ok(()),
    }
}

/// The weights of four vertices, or of two; and of their first and second derivatives.
fn weights(basis: CurveBasis, t: f32) -> [[f32; 4]; 3] {
    let s = 1.0 - t;
    match basis {
        CurveBasis::Linear => [[s, t, 0.0, 0.0], [-1.0, 1.0, 0.0, 0.0], [0.0; 4]],
        CurveBasis::Bezier => [
            [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t],
            [-3.0 * s * s, 3.0 * s * s - 6.0 * t * s, 6.0 * t * s - 3.0 * t * t, 3.0 * t * t],
            [6.0 * s, 6.0 * (t - 2.0 * s), 6.0 * (s - 2.0 * t), 6.0 * t],
        ],
        CurveBasis::BSpline => [
            [s * s * s, 4.0 - 6.0 * t * t + 3.0 * t * t * t, 4.0 - 6.0 * s * s + 3.0 * s * s * s, t * t * t]
                .map(|x| x / 6.0),
            [-0.5 * s * s, 1.5 * t * t - 2.0 * t, 2.0 * s - 1.5 * s * s, 0.5 * t * t],
            [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
        ],
        CurveBasis::CatmullRom => [
            [
                -t * s * s,
                2.0 - 5.0 * t * t + 3.0 * t * t * t,
                2.0 - 5.0 * s * s + 3.0 * s * s * s,
                -s * t * t,
            ]
            .map(|x| 0.5 * x),
            [2.0 * t * s - s * s, 9.0 * t * t - 10.0 * t, 10.0 * s - 9.0 * s * s, t * t - 2.0 * t * s]
                .map(|x| 0.5 * x),
            [2.0 - 3.0 * t, 9.0 * t - 5.0, 9.0 * s - 5.0, 2.0 - 3.0 * s],
        ],
        // Of the first vertex and its tangent, of the second and its own.
        CurveBasis::Hermite => [
            [(1.0 + 2.0 * t) * s * s, t * s * s, t * t * (3.0 - 2.0 * t), -t * t * s],
            [-6.0 * t * s, s * (1.0 - 3.0 * t), 6.0 * t * s, t * (3.0 * t - 2.0)],
            [12.0 * t - 6.0, 6.0 * t - 4.0, 6.0 - 12.0 * t, 6.0 * t - 2.0],
        ],
    }
}

/// Along a curve; nothing changes across.
fn of_curve(
    basis: CurveBasis,
    settings: &Settings,
    rows: &View,
    Query { prim_id, uv: [t, _], buffer: of, slot, count }: Query,
    each: &mut dyn FnMut(usize, Jet),
) -> Result<(), Problem> {
    let indices = settings.array(buffer::INDEX, 0);
    let none = || Problem::argument(format!("primitive {prim_id} is out of range"));
    let first: u32 = indices.number(prim_id as usize, 0).ok_or_else(none)?;
    let tangents = match (basis, of) {
        (CurveBasis::Hermite, buffer::VERTEX) => settings.array(buffer::TANGENT, slot),
        (CurveBasis::Hermite, buffer::NORMAL) => settings.array(buffer::NORMAL_DERIVATIVE, slot),
        (CurveBasis::Hermite, _) => {
            let message =
                format!("buffers of type {of} of Hermite curves have no tangents to interpolate by");
            return Err(Problem::operation(message));
        }
        _ => View::empty(),
    };
    let sources = match basis {
        CurveBasis::Linear => vec![(rows, 0), (rows, 1)],
        CurveBasis::Hermite => vec![(rows, 0), (&tangents, 0), (rows, 1), (&tangents, 1)],
        _ => (0..4).map(|i| (rows, i)).collect(),
    };
    for &(rows, i) in &sources {
        check(rows, [first.saturating_add(i)], count)?;
    }
    let weights = weights(basis, t);
    for k in 0..count as usize {
        let mut sums = [0.0; 3];
        for (i, &(rows, row)) in sources.iter().enumerate() {
            let x = at(rows, first + row, k)?;
            (0..3).for_each(|of| sums[of] += weights[of][i] * x);
        }
        each(k, [sums[0], sums[1], 0.0, sums[2], 0.0, 0.0]);
    }
    Ok(())
}

/// On the limit of a subdivision surface, without displacement.
fn of_surface(
    settings: &Settings,
    rows: &View,
    Query { prim_id, uv, buffer: of, slot, count }: Query,
    each: &mut dyn FnMut(usize, Jet),
) -> Result<(), Problem> {
    let topology = match of {
        buffer::VERTEX_ATTRIBUTE => settings.attribute_topologies.get(&slot).copied().unwrap_or(0),
        _ => 0,
    };
    let control = settings.control(topology)?;
    if prim_id >= control.faces() {
        return Err(Problem::argument(format!("primitive {prim_id} is out of range")));
    }
    let face = control
        .face(prim_id)
        .ok_or_else(|| Problem::argument(format!("face {prim_id} is a hole, or not valid")))?;
    let corners = control.cage.faces().range(face as usize).len();
    let (part, at_part) = decoded(corners, uv);
    let width = count as usize;
    let mut missing = None;
    let mut fill = |vertex: u32, values: &mut [f64]| {
        let row = control.row(vertex) as u32;
        for (k, value) in values.iter_mut().enumerate() {
            match at(rows, row, k) {
                Ok(x) => *value = f64::from(x),
                Err(problem) => missing = Some(problem),
            }
        }
    };
    let mut jets = Vec::new();
    let mut keep = |_: usize, jet: &[f64]| jets = jet.to_vec();
    control.cage.evaluate(Place { face, part }, &[at_part], width, true, &mut fill, &mut keep);
    if let Some(problem) = missing {
        return Err(problem);
    }
    for k in 0..width {
        each(k, std::array::from_fn(|of| jets[of * width + k] as f32));
    }
    Ok(())
}
