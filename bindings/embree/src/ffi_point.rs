// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcPointQuery`: primitives near a point, shown to the program. Source: Embree's manual.
//!
//! Primitives within the radius by our own distance, which is exact for triangles and quads; for user
//! geometry the distance to its box. Points, curves and subdivision surfaces are not visited, as by Embree. A query that the
//! program forwards from a user geometry, with its own transforms on the stack, uses the space of the
//! innermost transform, with the greatest growth of lengths there.
//! Tests: `tests/c/embree.c`.

use std::cell::Cell;
use std::collections::HashSet;
use std::ffi::{c_int, c_void};

use crate::ffi_abi::{INVALID, PointArguments, PointContext, PointFunction, PointQuery};
use crate::ffi_callbacks::{call_program, take_thrown};
use crate::ffi_handle::{Handle, not_committed, with};
use crate::located::Located;
use crate::objects::{Committed, Kind, Scene, run_query, run_tree};
use crate::transform::{self, Columns, IDENTITY};

/// Sixteen floats, column by column.
fn matrix(columns: &Columns) -> [f32; 16] {
    std::array::from_fn(|i| match (i % 4, i / 4) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (row, column) => columns[column][row] as f32,
    })
}

/// The opposite map.
fn columns(matrix: &[f32; 16]) -> Columns {
    transform::columns(crate::ffi_abi::format::FLOAT4X4_COLUMNS, matrix)
}

/// The program's query and callback.
struct Visit {
    query: *mut PointQuery,
    context: *mut PointContext,
    function: PointFunction,
    user: *mut c_void,
    /// The map into the innermost of the program's own instances.
    own: Columns,
    changed: bool,
    /// After an exception.
    stopped: Cell<bool>,
}

impl Visit {
    /// Shows a primitive; the radius afterwards, in the world.
    ///
    /// # Safety
    /// The pointers are those of the program's current call.
    unsafe fn show(&mut self, located: &Located, prim_id: u32) -> f64 {
        let Self { query, context, .. } = *self;
        // SAFETY: passed on; only fields are touched, one by one: the program reads and writes them, too.
        unsafe {
            let before = (*context).depth;
            if let Some(shown_instance) = located.shown_instance
                && before == 0
            {
                let outward = located.world_from_object((*query).time);
                (*context).world_from_instance = matrix(&outward);
                (*context).instance_from_world = matrix(&transform::inverse(&outward));
                (*context).inst_id = shown_instance.geom_id;
                (*context).inst_prim_id = shown_instance.prim_id.unwrap_or(INVALID);
                (*context).depth = 1;
            }
            let inward = if before > 0 { self.own } else { columns_of(context) };
            let mut arguments = PointArguments {
                query,
                user: self.user,
                prim_id,
                geom_id: located.surface.geom_id,
                context,
                similarity_scale: transform::similarity(&inward).unwrap_or(0.0) as f32,
            };
            for function in [located.surface.point, self.function].into_iter().flatten() {
                self.changed |= call_program(&self.stopped, || function(&raw mut arguments)).unwrap_or(false);
            }
            if (*context).depth != before {
                (*context).depth = before;
                (*context).inst_id = INVALID;
                (*context).inst_prim_id = INVALID;
            }
            f64::from((*query).radius)
        }
    }
}

/// The map into the instance on the stack.
///
/// # Safety
/// A context.
unsafe fn columns_of(context: *const PointContext) -> Columns {
    // SAFETY: passed on.
    unsafe { if (*context).depth == 0 { IDENTITY } else { columns(&(*context).instance_from_world) } }
}

/// Visits near primitives.
///
/// # Safety
/// As [`rtcPointQuery`].
unsafe fn visit(committed: &Committed, visit: &mut Visit) {
    // SAFETY: passed on.
    let PointQuery { point, radius, time } = unsafe { *visit.query };
    let point = transform::point(&visit.own, point.map(f64::from));
    let growth = transform::growth(&visit.own);
    // A grid is one primitive, of which the tree has each cell.
    let mut grids = HashSet::new();
    let mut show = |hit: &gnurt_accel::PointHit| {
        let located = committed.locate(hit.geom_id, hit.inst_id, hit.leaf_id);
        // Embree does not show these: programs do not expect them.
        if matches!(
            located.surface.kind,
            Kind::Spheres | Kind::Discs(_) | Kind::Curves(..) | Kind::Cones | Kind::Subdivision
        ) {
            // SAFETY: passed on.
            return growth * f64::from(unsafe { (*visit.query).radius });
        }
        let (prim_id, _) = located.surface.seen(hit.prim_id, [0.0; 2]);
        if located.surface.kind == Kind::Grids && !grids.insert((hit.leaf_id, hit.geom_id, prim_id)) {
            // SAFETY: passed on.
            return growth * f64::from(unsafe { (*visit.query).radius });
        }
        // SAFETY: passed on.
        growth * unsafe { visit.show(&located, prim_id) }
    };
    let radius = growth * f64::from(radius);
    match if time == 0.0 { None } else { committed.tree_at(time) } {
        Some(stopped) => {
            run_tree!(&*stopped, tree => tree.visit_near(&committed.query, point, radius, &mut show))
        }
        None => run_query!(committed, tree => tree.visit_near(&committed.query, point, radius, &mut show)),
    }
}

/// Shows primitives near a point. See Embree's manual; whether any answer was that the radius has changed.
///
/// # Safety
/// As Embree's headers say: a scene, a query, a context, a function or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcPointQuery(
    scene: Handle,
    query: *mut PointQuery,
    context: *mut PointContext,
    function: PointFunction,
    user: *mut c_void,
) -> bool {
    let query_scene = |scene: &std::sync::Arc<Scene>| {
        let committed = scene.committed().ok_or_else(not_committed)?;
        if query.is_null() || context.is_null() {
            return Err(crate::device::Problem::argument("the query or its context is a null pointer"));
        }
        // SAFETY: passed on.
        unsafe {
            let own = columns_of(context);
            let mut all =
                Visit { query, context, function, user, own, changed: false, stopped: Cell::new(false) };
            visit(&committed, &mut all);
            take_thrown()?;
            Ok(all.changed)
        }
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, query_scene) }
}

/// The same for several points, one by one.
///
/// # Safety
/// As [`rtcPointQuery`]: rows of `N` values, and `N` pointers or null.
unsafe fn packet<const N: usize>(
    valid: *const c_int,
    scene: Handle,
    queries: *mut f32,
    context: *mut PointContext,
    function: PointFunction,
    users: *const *mut c_void,
) -> bool {
    let mut changed = false;
    for i in 0..N {
        // SAFETY: passed on: five rows of `N` values.
        unsafe {
            if *valid.add(i) == 0 {
                continue;
            }
            let row = |row: usize| *queries.add(row * N + i);
            let mut query = PointQuery { point: [row(0), row(1), row(2)], time: row(3), radius: row(4) };
            let user = if users.is_null() { std::ptr::null_mut() } else { *users.add(i) };
            changed |= rtcPointQuery(scene, &raw mut query, context, function, user);
            *queries.add(4 * N + i) = query.radius;
        }
    }
    changed
}

macro_rules! packets {
    ($($name:ident, $traversable:ident: $n:literal;)*) => { $(
        /// The same for several points.
        ///
        /// # Safety
        /// As Embree's headers say.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $name(
            valid: *const c_int,
            scene: Handle,
            queries: *mut f32,
            context: *mut PointContext,
            function: PointFunction,
            users: *const *mut c_void,
        ) -> bool {
            // SAFETY: passed on.
            unsafe { packet::<$n>(valid, scene, queries, context, function, users) }
        }

        /// The same.
        ///
        /// # Safety
        /// As above.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $traversable(
            valid: *const c_int,
            scene: Handle,
            queries: *mut f32,
            context: *mut PointContext,
            function: PointFunction,
            users: *const *mut c_void,
        ) -> bool {
            // SAFETY: passed on.
            unsafe { packet::<$n>(valid, scene, queries, context, function, users) }
        }
    )* };
}

packets! {
    rtcPointQuery4, rtcTraversablePointQuery4: 4;
    rtcPointQuery8, rtcTraversablePointQuery8: 8;
    rtcPointQuery16, rtcTraversablePointQuery16: 16;
}

/// The same; a scene is its own traversable.
///
/// # Safety
/// As [`rtcPointQuery`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcTraversablePointQuery(
    scene: Handle,
    query: *mut PointQuery,
    context: *mut PointContext,
    function: PointFunction,
    user: *mut c_void,
) -> bool {
    // SAFETY: passed on.
    unsafe { rtcPointQuery(scene, query, context, function, user) }
}
