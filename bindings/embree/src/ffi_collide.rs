// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcCollide`: pairs of primitives of two scenes that may meet. Source: Embree's manual.
//!
//! The tree of one scene is asked for what touches the box of each primitive of the other, whichever has fewer. User
//! geometry counts by its boxes, sides included; triangles and quads of the asked tree count themselves, as far as
//! they touch the other's box. Tests: `tests/c/collide.c`.

use std::ffi::{c_uint, c_void};
use std::sync::Arc;

use gnurt_accel::{Aabb, PrimitiveId, Query};

use crate::device::Problem;
use crate::ffi_catch;
use crate::ffi_handle::{Handle, not_committed, shared, with};
use crate::objects::{Committed, Kind, Scene, Surface, Tree};

/// `RTCCollision`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Collision {
    geom_id0: c_uint,
    prim_id0: c_uint,
    geom_id1: c_uint,
    prim_id1: c_uint,
}

/// `RTCCollideFunc`.
pub(crate) type CollideFunction = Option<unsafe extern "C-unwind" fn(*mut c_void, *mut Collision, c_uint)>;

/// The most pairs that one call passes.
const BLOCK: usize = 64;

/// How many primitives a scene has.
///
/// # Errors
/// Something in it has no boxes that could meet.
fn count(committed: &Committed) -> Result<usize, Problem> {
    if matches!(committed.tree, Tree::Scene(_)) {
        return Err(Problem::operation("rtcCollide: a scene shows instances, which collide with nothing"));
    }
    let of_surface = |surface: &Surface| {
        let geom_id = surface.geom_id;
        if surface.moves() {
            let message = format!("rtcCollide: geometry {geom_id} has several time steps");
            return Err(Problem::operation(message));
        }
        match surface.kind {
            Kind::User => Ok(surface.user.as_ref().map_or(0, |user| user.count() as usize)),
            Kind::Triangles | Kind::Quads => Ok(surface.indices.len()),
            kind => Err(Problem::operation(format!(
                "rtcCollide: geometry {geom_id} is {kind:?}; only user geometry, triangles and quads collide"
            ))),
        }
    };
    committed.surfaces.iter().try_fold(0, |sum, surface| Ok(sum + of_surface(surface)?))
}

/// The box of a primitive; `None` where that is none.
fn bounds(surface: &Surface, prim_id: u32) -> Option<Aabb> {
    let i = prim_id as usize;
    let corners = match surface.kind {
        Kind::Triangles => surface.indices.get::<u32, 3>(i)?.to_vec(),
        Kind::Quads => surface.indices.get::<u32, 4>(i)?.to_vec(),
        _ => return surface.user.as_ref().map(|user| user.bounds(prim_id)),
    };
    let mut bounds = Aabb::EMPTY;
    for corner in corners {
        let at = surface.first.vertices.get::<f32, 3>(corner as usize)?;
        if !at.iter().all(|x| x.is_finite()) {
            return None;
        }
        (0..3).for_each(|k| {
            bounds.min[k] = bounds.min[k].min(at[k]);
            bounds.max[k] = bounds.max[k].max(at[k]);
        });
    }
    Some(bounds)
}

/// Calls the function for all pairs, in blocks.
///
/// # Safety
/// The function may be called with the pointer.
unsafe fn collide(
    scenes: [&Committed; 2],
    function: unsafe extern "C-unwind" fn(*mut c_void, *mut Collision, c_uint),
    user: *mut c_void,
) -> Result<(), Problem> {
    let counts = [count(scenes[0])?, count(scenes[1])?];
    let is_swapped = counts[0] < counts[1];
    let [asked, asking] = if is_swapped { [scenes[1], scenes[0]] } else { scenes };
    let Tree::Object(tree) = &asked.tree else { return Ok(()) };
    let query = Query { mask: u32::MAX, ..asked.query };
    let mut block = Vec::with_capacity(BLOCK);
    let pass = |block: &mut Vec<Collision>| -> Result<(), Problem> {
        let (start, pairs) = (block.as_mut_ptr(), block.len() as c_uint);
        // SAFETY: passed on; the block has as many pairs, which the program may write.
        ffi_catch::call(|| unsafe { function(user, start, pairs) })?;
        block.clear();
        Ok(())
    };
    let mut near: Vec<PrimitiveId> = Vec::new();
    for surface in &asking.surfaces {
        let primitives = match &surface.user {
            Some(user) => user.count(),
            None => surface.indices.len() as u32,
        };
        for prim_id in 0..primitives {
            let Some(Aabb { min, max }) = bounds(surface, prim_id) else { continue };
            tree.touching_box(&query, min.map(f64::from), max.map(f64::from), &mut near);
            for other in &near {
                let own = [surface.geom_id, prim_id];
                let other = [asked.surfaces[other.geom_id as usize].geom_id, other.prim_id];
                let [[geom_id0, prim_id0], [geom_id1, prim_id1]] =
                    if is_swapped { [own, other] } else { [other, own] };
                block.push(Collision { geom_id0, prim_id0, geom_id1, prim_id1 });
                if block.len() == BLOCK {
                    pass(&mut block)?;
                }
            }
        }
    }
    if block.is_empty() { Ok(()) } else { pass(&mut block) }
}

/// Passes the program pairs of primitives of two scenes that may meet. See Embree's manual.
///
/// # Safety
/// Two scenes, and a function that may be called with the pointer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcCollide(
    scene: Handle,
    other: Handle,
    function: CollideFunction,
    user: *mut c_void,
) {
    // SAFETY: passed on.
    let other = unsafe { shared::<Scene>(other) };
    let both = |scene: &Arc<Scene>| {
        let other = other.ok_or_else(|| Problem::argument("the second scene is a null pointer"))?;
        let function = function.ok_or_else(|| Problem::argument("the function is a null pointer"))?;
        if !Arc::ptr_eq(&scene.device, &other.device) {
            return Err(Problem::argument("the scenes are of two devices"));
        }
        let [first, second] = [scene, &other].map(|scene| scene.unmodified().ok_or_else(not_committed));
        // SAFETY: passed on.
        unsafe { collide([&*first?, &*second?], function, user) }
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, both) }
}
