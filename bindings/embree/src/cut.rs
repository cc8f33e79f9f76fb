// SPDX-License-Identifier: GPL-3.0-or-later
//! Subdivision surfaces of a commit, cut to quads: their vertices on the limit surface, at all time steps, moved by the
//! program's function. Space: that of the geometry. Tests: `tests/c/subdivision.c`.

use std::sync::Arc;

use gnurt_accel::Threads;
use gnurt_subdivision::Tessellation;
use rayon::prelude::*;

use crate::cells::{Cells, Patches, encoded};
use crate::control::Control;
use crate::device::Problem;
use crate::ffi_abi::Code;
use crate::ffi_catch::Thrown;
use crate::ffi_displace::Point;
use crate::ffi_memory::View;
use crate::ffi_own::stored;
use crate::objects::{CutSurface, StepArrays, Surface, Uncut};

/// Lets the program move points of a face, by its number, at a time step.
pub(crate) type Displace<'a> = &'a (dyn Fn(u32, u32, &mut [Point]) -> Result<(), Thrown> + Sync);

/// The most quads of a surface: two triangles each.
const MOST_CELLS: u64 = gnurt_accel::MOST_TRIANGLES as u64 / 2;

fn no_memory() -> Problem {
    Problem { code: Code::OutOfMemory, message: "out of memory for a subdivision surface".into() }
}

/// Cuts a surface, whose vertices so far are those of the control mesh; takes what was cut before if nothing was edited since.
///
/// # Errors
/// Too many quads, no memory, or an exception of the program's function.
pub(crate) fn cut(
    surface: &mut Surface,
    uncut: &Uncut,
    displace: Option<Displace>,
    threads: Threads,
) -> Result<(), Problem> {
    let known = surface.geometry.cut_at(uncut.edit);
    let CutSurface { patches, indices, vertices } = match known {
        Some(known) => known,
        None => {
            let made = make(surface, uncut, displace, threads)?;
            surface.geometry.keep_cut(uncut.edit, made.clone());
            made
        }
    };
    let mut steps = vertices.into_iter().map(|vertices| StepArrays { vertices, ..StepArrays::empty() });
    surface.first = steps.next().unwrap_or_else(StepArrays::empty);
    surface.later = steps.collect();
    surface.indices = indices;
    surface.cells = Some(Cells::Patches(patches));
    Ok(())
}

fn make(
    surface: &Surface,
    uncut: &Uncut,
    displace: Option<Displace>,
    threads: Threads,
) -> Result<CutSurface, Problem> {
    let (geom_id, control) = (surface.geom_id, &uncut.control);
    let cage = &control.cage;
    let mut face_of = Vec::with_capacity(cage.faces().corners().len());
    (0..cage.faces().len()).for_each(|face| face_of.extend(cage.faces().range(face).map(|_| face as u32)));
    let level = |corner: usize| {
        let of_edge = control.level(&uncut.levels, corner, face_of[corner] as usize);
        of_edge.unwrap_or(uncut.rate)
    };
    let cut = Tessellation::new(cage, level, MOST_CELLS)
        .map_err(|error| Problem::operation(format!("geometry {geom_id}: {error}")))?;
    let of_step = |(time_step, step): (usize, &StepArrays)| {
        let displace = displace.map(|displace| (displace, time_step as u32));
        let positions = positions(control, &cut, &step.vertices, displace, threads)?;
        stored(&positions).ok_or_else(no_memory)
    };
    let vertices = surface.steps().enumerate().map(of_step).collect::<Result<_, _>>()?;
    let indices = stored(&cut.cells(cage)).ok_or_else(no_memory)?;
    let patches = Arc::new(Patches { control: Arc::clone(control), cut });
    Ok(CutSurface { patches, indices, vertices })
}

/// The vertices of all cells at a time step.
fn positions(
    control: &Control,
    cut: &Tessellation,
    vertices: &View,
    displace: Option<(Displace, u32)>,
    threads: Threads,
) -> Result<Vec<[f32; 3]>, Problem> {
    let of = |patch: usize| of_patch(control, cut, vertices, displace, patch);
    let patches = 0..cut.patches();
    let found: Vec<Vec<(u32, [f32; 3])>> = match threads {
        Threads::Single => patches.map(of).collect::<Result<_, Thrown>>()?,
        Threads::Pool(pool) => {
            pool.install(|| patches.into_par_iter().map(of).collect::<Result<_, Thrown>>())?
        }
    };
    let mut positions = vec![[0.0; 3]; cut.vertices()];
    for (vertex, position) in found.into_iter().flatten() {
        positions[vertex as usize] = position;
    }
    Ok(positions)
}

/// The vertices that are computed with a patch.
fn of_patch(
    control: &Control,
    cut: &Tessellation,
    vertices: &View,
    displace: Option<(Displace, u32)>,
    patch: usize,
) -> Result<Vec<(u32, [f32; 3])>, Thrown> {
    let cage = &control.cage;
    let (numbers, places): (Vec<u32>, Vec<[f64; 2]>) = cut.points(cage, patch).into_iter().unzip();
    let mut fill = |vertex: u32, values: &mut [f64]| {
        let row = vertices.get::<f32, 3>(control.row(vertex)).unwrap_or([f32::NAN; 3]);
        (0..3).for_each(|k| values[k] = f64::from(row[k]));
    };
    let place = cut.place(patch);
    let corners = cage.faces().range(place.face as usize).len();
    let mut points: Vec<Point> = vec![Default::default(); numbers.len()];
    cage.evaluate(place, &places, 3, displace.is_some(), &mut fill, &mut |i, jet| {
        let vector = |of: usize| [0, 1, 2].map(|k| jet[3 * of + k]);
        let at = places[i].map(|x| x as f32);
        let normal = unit(across(vector(1), vector(2)));
        points[i] = (encoded(place.part, corners, at), normal, vector(0).map(|x| x as f32));
    });
    if let Some((displace, time_step)) = displace
        && !points.is_empty()
    {
        displace(control.prim_id(place.face), time_step, &mut points)?;
    }
    Ok(numbers.into_iter().zip(points.into_iter().map(|(_, _, position)| position)).collect())
}

fn across(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f32; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { v.map(|x| (x / length) as f32) } else { [0.0; 3] }
}
