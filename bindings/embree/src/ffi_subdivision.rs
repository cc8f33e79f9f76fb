// SPDX-License-Identifier: GPL-3.0-or-later
//! Calls of subdivision surfaces: topologies, displacement, half edges. Source: Embree's manual.
//! Tests: `tests/c/subdivision.c`.

use std::ffi::c_uint;
use std::sync::Arc;

use crate::control::{Control, MODES};
use crate::device::Problem;
use crate::ffi_abi::{DisplacementFunction, INVALID};
use crate::ffi_handle::{Handle, with};
use crate::objects::{Geometry, Kind, Settings, Topology};

/// That a geometry is a subdivision surface, as a call needs it.
fn check_kind(geometry: &Geometry, call: &str) -> Result<(), Problem> {
    match geometry.kind {
        Kind::Subdivision => Ok(()),
        kind => Err(Problem::operation(format!("{call}: not for {kind:?}, but subdivision surfaces"))),
    }
}

/// Edits a subdivision surface.
///
/// # Safety
/// A geometry.
unsafe fn edit(geometry: Handle, call: &str, change: impl FnOnce(&mut Settings) -> Result<(), Problem>) {
    let edit = |geometry: &Arc<Geometry>| {
        check_kind(geometry, call)?;
        let mut settings = geometry.edit();
        change(&mut settings)?;
        settings.modified();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, edit) }
}

fn no_topology(topology: c_uint, settings: &Settings) -> Problem {
    let count = settings.topologies.len();
    Problem::operation(format!("topology {topology}: there are {count} (rtcSetGeometryTopologyCount)"))
}

/// Sets how many topologies there are. See Embree's manual, here and below.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryTopologyCount(geometry: Handle, count: c_uint) {
    /// Each has an index buffer: more are a mistake.
    const MOST: c_uint = 1 << 16;
    let change = |settings: &mut Settings| {
        if !(1..=MOST).contains(&count) {
            return Err(Problem::operation(format!("{count} topologies: valid are 1 to {MOST}")));
        }
        settings.topologies.resize_with(count as usize, Topology::new);
        settings.arrays.retain(|&(of, slot), _| of != crate::ffi_abi::buffer::INDEX || slot < count);
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(geometry, "rtcSetGeometryTopologyCount", change) }
}

/// Sets how a topology treats its boundary, or that it is flat.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometrySubdivisionMode(
    geometry: Handle,
    topology: c_uint,
    mode: c_uint,
) {
    let change = |settings: &mut Settings| {
        if !MODES.contains(&mode) {
            return Err(Problem::argument(format!("invalid subdivision mode {mode}; valid are 0 to 4")));
        }
        let Some(known) = settings.topologies.get_mut(topology as usize) else {
            return Err(no_topology(topology, settings));
        };
        known.mode = mode;
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(geometry, "rtcSetGeometrySubdivisionMode", change) }
}

/// Sets the topology that a vertex attribute has.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryVertexAttributeTopology(
    geometry: Handle,
    attribute: c_uint,
    topology: c_uint,
) {
    let change = |settings: &mut Settings| {
        if attribute >= settings.attributes {
            let count = settings.attributes;
            return Err(Problem::operation(format!(
                "vertex attribute {attribute}: there are {count} (rtcSetGeometryVertexAttributeCount)"
            )));
        }
        if topology as usize >= settings.topologies.len() {
            return Err(no_topology(topology, settings));
        }
        settings.attribute_topologies.insert(attribute, topology);
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(geometry, "rtcSetGeometryVertexAttributeTopology", change) }
}

/// Sets the function that moves points; null for none.
///
/// # Safety
/// A geometry, and a function that may be called during commits.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryDisplacementFunction(
    geometry: Handle,
    function: DisplacementFunction,
) {
    let change = |settings: &mut Settings| {
        settings.displacement = function;
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(geometry, "rtcSetGeometryDisplacementFunction", change) }
}

/// Asks the control mesh of a topology; `RTC_INVALID_GEOMETRY_ID` after an error.
///
/// # Safety
/// A geometry.
unsafe fn ask(
    geometry: Handle,
    call: &str,
    topology: c_uint,
    of: fn(&Control) -> u32,
    number: c_uint,
    answer: impl FnOnce(&Control) -> u32,
) -> c_uint {
    let ask = |geometry: &Arc<Geometry>| {
        check_kind(geometry, call)?;
        let control = geometry.settings().control(topology)?;
        let count = of(&control);
        if number >= count {
            return Err(Problem::argument(format!("{call}: number {number} of {count}")));
        }
        Ok(Some(answer(&control)))
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, ask) }.unwrap_or(INVALID)
}

/// The first half edge of a face.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryFirstHalfEdge(geometry: Handle, face: c_uint) -> c_uint {
    let first = |control: &Control| control.half_edges_of(face).start;
    // SAFETY: passed on.
    unsafe { ask(geometry, "rtcGetGeometryFirstHalfEdge", 0, Control::faces, face, first) }
}

macro_rules! of_half_edges {
    ($($(#[$doc:meta])* $name:ident => $answer:expr;)*) => { $(
        $(#[$doc])*
        ///
        /// # Safety
        /// A geometry.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $name(geometry: Handle, half_edge: c_uint) -> c_uint {
            let answer: fn(&Control, u32) -> u32 = $answer;
            let answer = |control: &Control| answer(control, half_edge);
            // SAFETY: passed on.
            unsafe { ask(geometry, stringify!($name), 0, Control::half_edges, half_edge, answer) }
        }
    )* };
}

of_half_edges! {
    /// The face of a half edge.
    rtcGetGeometryFace => |control, half_edge| control.face_of(half_edge);
    /// The next half edge of its face.
    rtcGetGeometryNextHalfEdge => |control, half_edge| {
        let all = control.half_edges_of(control.face_of(half_edge));
        if half_edge + 1 == all.end { all.start } else { half_edge + 1 }
    };
    /// The one before.
    rtcGetGeometryPreviousHalfEdge => |control, half_edge| {
        let all = control.half_edges_of(control.face_of(half_edge));
        if half_edge == all.start { all.end - 1 } else { half_edge - 1 }
    };
}

/// The half edge behind a half edge; itself where there is none, or more than one.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryOppositeHalfEdge(
    geometry: Handle,
    topology: c_uint,
    half_edge: c_uint,
) -> c_uint {
    let (call, opposite) =
        ("rtcGetGeometryOppositeHalfEdge", |control: &Control| control.opposite(half_edge));
    // SAFETY: passed on.
    unsafe { ask(geometry, call, topology, Control::half_edges, half_edge, opposite) }
}
