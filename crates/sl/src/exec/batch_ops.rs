// SPDX-License-Identifier: GPL-3.0-or-later
//! Operations answered by the host, done for many points of a batch at once, for engines that have all of
//! them ready.
//! Invariant: every point gets the interpreter's result for it. If that is not guaranteed (texts that differ
//! from point to point, a message), nothing is done, and the caller goes point by point. Tests:
//! crates/jit/tests/batches.rs.

use super::batch::Points;
use super::cells::{Batch, Cells, DualRow, LANES, lanes_of};
use super::machine::{Machine, Step};
use super::rows;
use super::slot::Slot;
use super::texture;
use crate::opcode::Opcode;
use crate::types::{Base, Type};
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::math::vectors;
use gnurt_sl_lib::matrix as mx;

/// Whether [`Machine::run_batched`] may do an operation.
#[must_use]
pub fn queries_in_batches(step: &Step) -> bool {
    let out = step.args.first().map_or(Type::VOID, |out| out.ty);
    match (step.code, step.args.len()) {
        (Opcode::RayType, 2) | (Opcode::Backfacing | Opcode::SurfaceArea, 1) => {
            matches!(out, Type::INT | Type::FLOAT) && step.writes == 1
        }
        (Opcode::CalculateNormal, 2)
        | (Opcode::Transform | Opcode::TransformV | Opcode::TransformN, 3 | 4) => {
            let (middle, value) = (&step.args[1..step.args.len() - 1], step.args[step.args.len() - 1]);
            let has_three =
                |slot: &Slot| slot.ty.base.is_float_based() && !slot.ty.is_array() && slot.size == 3;
            let are_names = middle.iter().all(|name| name.ty == Type::STRING);
            has_three(&step.args[0]) && has_three(&value) && are_names && step.writes == 1
        }
        // A triple of three numbers in a named space.
        (Opcode::Point | Opcode::Vector | Opcode::Normal, 5) => {
            let has_one = |slot: &Slot| matches!(slot.ty, Type::FLOAT | Type::INT);
            out.base.is_triple()
                && !out.is_array()
                && step.args[1].ty == Type::STRING
                && step.args[2..].iter().all(has_one)
                && step.writes == 1
        }
        (Opcode::Blackbody | Opcode::WavelengthColor, 2) => {
            out.base.is_triple()
                && !out.is_array()
                && matches!(step.args[1].ty, Type::FLOAT | Type::INT)
                && step.writes == 1
        }
        (Opcode::Texture, 4..) => out.base.is_float_based() && !out.is_array(),
        _ => false,
    }
}

impl Machine<'_> {
    /// Does an operation for the points of a batch that `lanes` names. False if it must be done one point after the other; nothing is done
    /// then.
    pub fn run_batched(&mut self, step: &Step, lanes: u32, points: &Points, batch: &mut dyn Batch) -> bool {
        match (step.code, &*step.args) {
            (Opcode::RayType, [out, name]) => {
                let Cells::One(text) = batch.get(name.at) else { return false };
                let bit =
                    if name.ty == Type::STRING { self.host.ray_kind(self.strings.text(text)) } else { 0 };
                put_bits(batch, out, lanes, points.ray_kinds.map(|kinds| kinds & bit != 0));
            }
            (Opcode::Backfacing, [out]) => {
                put_bits(batch, out, lanes, std::array::from_fn(|lane| points.backfacing >> lane & 1 != 0));
            }
            (Opcode::SurfaceArea, [out]) => {
                let area = points.surface_area;
                let is_int = out.ty.base == Base::Int;
                put(batch, out, lanes, &area.map(|x| if is_int { x as i32 as u32 } else { x.to_bits() }));
            }
            (Opcode::CalculateNormal, [out, value]) => {
                each_triple(batch, lanes, (out, value), |lane, v| {
                    let [dx, dy] = [v.each_ref().map(|x| x.dx), v.each_ref().map(|x| x.dy)];
                    let normal = vectors::calculatenormal(dx, dy, points.flipped >> lane & 1 != 0);
                    Dual::from(normal).components()
                });
            }
            (
                code @ (Opcode::Transform | Opcode::TransformV | Opcode::TransformN),
                [out, spaces @ .., value],
            ) => {
                let Some(matrix) = self.same_matrix(spaces, lanes, points, batch, false) else {
                    return false;
                };
                let kind = match code {
                    Opcode::TransformV => Type::VECTOR,
                    Opcode::TransformN => Type::NORMAL,
                    _ => Type::POINT,
                };
                let all = rows::triple(batch, |i| (value, i as u32));
                put_transformed(batch, lanes, (out, all), &matrix, kind);
            }
            (Opcode::Point | Opcode::Vector | Opcode::Normal, [out, space, numbers @ ..]) => {
                let Some(matrix) = self.same_matrix(std::slice::from_ref(space), lanes, points, batch, true)
                else {
                    return false;
                };
                let all = rows::triple(batch, |i| (&numbers[i.min(numbers.len() - 1)], 0));
                put_transformed(batch, lanes, (out, all), &matrix, out.ty);
            }
            (code @ (Opcode::Blackbody | Opcode::WavelengthColor), [out, value]) => {
                let colors = self.host.color_system();
                let mut last: Option<(u32, [f32; 3])> = None;
                each_triple(batch, lanes, (out, value), |_, [x, ..]| {
                    // Most shaders ask for one number.
                    let bits = x.value.to_bits();
                    let color = match last {
                        Some((known, color)) if known == bits => color,
                        _ if code == Opcode::Blackbody => colors.blackbody(x.value),
                        _ => colors.wavelength_color(x.value),
                    };
                    last = Some((bits, color));
                    Dual::from(color).components()
                });
            }
            (Opcode::Texture, _) => return texture::textures(self, step, lanes, batch).is_some(),
            _ => return false,
        }
        true
    }
}

impl Machine<'_> {
    /// The matrix between the spaces that an operation names, if it is the same for some points. A single name is the end, or the
    /// start if it goes to the common space.
    fn same_matrix(
        &mut self,
        names: &[Slot],
        lanes: u32,
        points: &Points,
        batch: &dyn Batch,
        to_common: bool,
    ) -> Option<[[f32; 4]; 4]> {
        let text = |name: &Slot| match batch.get(name.at) {
            Cells::One(cell_bits) => Some(self.strings.text(cell_bits).clone()),
            Cells::Each(_) => None,
        };
        let (from, to) = match names {
            [from] if to_common => (text(from)?, "common".into()),
            [to] => ("common".into(), text(to)?),
            [from, to] => (text(from)?, text(to)?),
            _ => return None,
        };
        let is_same = |name: &str| name == "common" || self.host.is_same_space(name, lanes, &points.index);
        if !(is_same(&from) && is_same(&to)) {
            return None;
        }
        self.spaces_at(points.point(lanes.trailing_zeros() as usize), &from, &to)
    }
}

/// Makes three numbers of three numbers of each of some points; `f(point, numbers)`.
fn each_triple(
    batch: &mut dyn Batch,
    lanes: u32,
    (out, value): (&Slot, &Slot),
    f: impl FnMut(usize, [Dual<f32>; 3]) -> [Dual<f32>; 3],
) {
    let all = rows::triple(batch, |i| (value, i as u32));
    put_triples(batch, lanes, (out, all), f);
}

/// The same for numbers that were read.
fn put_triples(
    batch: &mut dyn Batch,
    lanes: u32,
    (out, mut all): (&Slot, [DualRow; 3]),
    mut f: impl FnMut(usize, [Dual<f32>; 3]) -> [Dual<f32>; 3],
) {
    for lane in lanes_of(lanes) {
        let [x, y, z] = &all;
        let found = f(lane, [x.get(lane), y.get(lane), z.get(lane)]);
        for (row, x) in all.iter_mut().zip(found) {
            row.set(lane, x);
        }
    }
    for (i, row) in all.iter().enumerate() {
        rows::put(batch, lanes, (out, i as u32), row);
    }
}

/// Points, vectors or normals in another space. All lanes are done, which compilers make vectors of.
fn put_transformed(
    batch: &mut dyn Batch,
    lanes: u32,
    (out, all): (&Slot, [DualRow; 3]),
    matrix: &mx::Matrix,
    kind: Type,
) {
    let found = match kind {
        Type::POINT => transformed(&all, out.derivs, matrix, mx::transform_point, mx::transform_point),
        // The matrix of normals is the same for all.
        Type::NORMAL => transformed(
            &all,
            out.derivs,
            &mx::transpose(&mx::inverse(matrix)),
            mx::transform_vector,
            mx::transform_vector,
        ),
        _ => transformed(&all, out.derivs, matrix, mx::transform_vector, mx::transform_vector),
    };
    for (i, row) in found.iter().enumerate() {
        rows::put(batch, lanes, (out, i as u32), row);
    }
}

#[inline(always)]
fn transformed(
    [x, y, z]: &[DualRow; 3],
    has_changes: bool,
    matrix: &mx::Matrix,
    dual: impl Fn(&mx::Matrix, [Dual<f32>; 3]) -> [Dual<f32>; 3],
    plain: impl Fn(&mx::Matrix, [f32; 3]) -> [f32; 3],
) -> [DualRow; 3] {
    let mut out = <[DualRow; 3]>::default();
    let [to_x, to_y, to_z] = &mut out;
    if has_changes {
        for lane in 0..LANES {
            let [a, b, c] = dual(matrix, [x.get(lane), y.get(lane), z.get(lane)]);
            to_x.set(lane, a);
            to_y.set(lane, b);
            to_z.set(lane, c);
        }
    } else {
        for lane in 0..LANES {
            let [a, b, c] = plain(matrix, [x.value[lane], y.value[lane], z.value[lane]]);
            (to_x.value[lane], to_y.value[lane], to_z.value[lane]) = (a, b, c);
        }
    }
    out
}

fn put_bits(batch: &mut dyn Batch, out: &Slot, lanes: u32, is: [bool; LANES]) {
    let one = if out.ty.base == Base::Int { 1 } else { 1.0_f32.to_bits() };
    put(batch, out, lanes, &is.map(|is| if is { one } else { 0 }));
}

/// A value without changes.
fn put(batch: &mut dyn Batch, out: &Slot, lanes: u32, cells_bits: &[u32; LANES]) {
    batch.put(out.at, lanes, cells_bits);
    for k in 1..if out.derivs { 3 } else { 1 } {
        batch.put(out.at + k * out.size, lanes, &[0; LANES]);
    }
}
