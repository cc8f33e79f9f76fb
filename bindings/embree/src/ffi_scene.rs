// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcNewScene` and its kin. Source: Embree's manual. Tests: `tests/c/embree.c`, `tests/c/joined.c`.

use std::ffi::{c_uint, c_void};
use std::ptr::null_mut;
use std::sync::Arc;

use gnurt_accel::Aabb;

use crate::commit::commit;
use crate::device::Problem;
use crate::ffi_abi::{Bounds, format};
use crate::ffi_callbacks::{Callback, ProgressFunction};
use crate::ffi_handle::{Handle, lend, not_committed, release, retain, shared, with, with_device};
use crate::ffi_memory::Pointer;
use crate::ffi_present::present;
use crate::objects::{Geometry, Scene, Surface, Tree, path, run_query, run_tree};
use crate::transform;

/// A new scene. See Embree's manual, here and below.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewScene(device: Handle) -> Handle {
    // SAFETY: passed on.
    let scene = unsafe { with_device(device, |device| Ok(Some(Arc::new(Scene::new(Arc::clone(device)))))) };
    scene.map_or(null_mut(), lend)
}

/// The device of a scene, counted once more.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetSceneDevice(scene: Handle) -> Handle {
    // SAFETY: passed on.
    let device = unsafe { with::<Scene, _>(scene, |scene| Ok(Some(Arc::clone(&scene.device)))) };
    device.map_or(null_mut(), lend)
}

/// Counts a scene once more.
///
/// # Safety
/// A scene or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcRetainScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { retain::<Scene>(scene) }
}

/// Counts a scene once less.
///
/// # Safety
/// A scene or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcReleaseScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { release::<Scene>(scene) }
}

/// The traversable of a scene: the scene itself.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetSceneTraversable(scene: Handle) -> Handle {
    scene
}

/// Attaches a geometry under the lowest free id.
///
/// # Safety
/// A scene and a geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcAttachGeometry(scene: Handle, geometry: Handle) -> c_uint {
    // SAFETY: passed on.
    let geometry = unsafe { shared::<Geometry>(geometry) };
    let attach = |scene: &Arc<Scene>| {
        let geometry = geometry.ok_or_else(|| Problem::argument("the geometry is a null pointer"))?;
        let id = scene.attach(None, geometry);
        id.map(Some).ok_or_else(|| Problem::operation("all ids are in use"))
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, attach) }.unwrap_or(c_uint::MAX)
}

/// Attaches a geometry under this id.
///
/// # Safety
/// A scene and a geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcAttachGeometryByID(scene: Handle, geometry: Handle, id: c_uint) {
    // SAFETY: passed on.
    let geometry = unsafe { shared::<Geometry>(geometry) };
    let attach = |scene: &Arc<Scene>| {
        let geometry = geometry.ok_or_else(|| Problem::argument("the geometry is a null pointer"))?;
        if id == c_uint::MAX {
            return Err(Problem::argument("RTC_INVALID_GEOMETRY_ID is not a valid id of a geometry"));
        }
        let attached = scene.attach(Some(id), geometry);
        attached
            .map(drop)
            .ok_or_else(|| Problem::operation(format!("geometry {id} is there already: detach it first")))
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, attach) }
}

fn no_geometry(id: c_uint) -> Problem {
    Problem::argument(format!("the scene has no geometry {id}"))
}

/// Takes a geometry out.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcDetachGeometry(scene: Handle, id: c_uint) {
    let detach = |scene: &Arc<Scene>| scene.detach(id).map(drop).ok_or_else(|| no_geometry(id));
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, detach) }
}

/// A geometry of a scene, found without a lock and without counts; null where [`rtcGetGeometry`] must search
/// it.
///
/// # Safety
/// A scene or null, to which nothing is attached meanwhile.
unsafe fn found_at_once<'a>(scene: Handle, id: c_uint) -> Option<&'a Geometry> {
    if scene.is_null() {
        return None;
    }
    // SAFETY: passed on; the program holds the scene during the call.
    let scene = unsafe { &*scene.cast::<Scene>() };
    // SAFETY: it lives as long as the scene is not committed, which is not done meanwhile.
    let committed = if scene.has_all() { present(scene) } else { None };
    committed?.geometry(id).map(|geometry| &**geometry)
}

/// A geometry of a scene, which does not count it for the program. Takes no lock for committed geometries:
/// programs call it for each hit.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometry(scene: Handle, id: c_uint) -> Handle {
    // SAFETY: passed on.
    unsafe {
        match found_at_once(scene, id) {
            Some(geometry) => std::ptr::from_ref(geometry).cast_mut().cast(),
            None => rtcGetGeometryThreadSafe(scene, id),
        }
    }
}

/// The same; it may be called from several threads, also while others attach geometries.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryThreadSafe(scene: Handle, id: c_uint) -> Handle {
    let get = |scene: &Arc<Scene>| scene.geometry(id).map(Some).ok_or_else(|| no_geometry(id));
    // SAFETY: passed on.
    let geometry = unsafe { with::<Scene, _>(scene, get) };
    geometry.map_or(null_mut(), |geometry| Arc::as_ptr(&geometry).cast_mut().cast())
}

/// Builds the trees; does nothing without edits since the last build.
///
/// # Safety
/// A scene without concurrent queries if it was edited; arrays and callbacks of its geometries are valid.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcCommitScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, |scene| commit(scene)) }
}

/// Like [`rtcCommitScene`], callable from several threads: one builds, the others return when it is done.
///
/// # Safety
/// As [`rtcCommitScene`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcJoinCommitScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { rtcCommitScene(scene) }
}

/// Sets the function that a build's progress is reported to.
///
/// # Safety
/// A scene, and a function that may be called with the pointer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetSceneProgressMonitorFunction(
    scene: Handle,
    function: Option<ProgressFunction>,
    user: *mut c_void,
) {
    // SAFETY: passed on.
    let callback = unsafe { Callback::new(function, user) };
    // SAFETY: passed on.
    unsafe {
        with::<Scene, _>(scene, |scene| {
            scene.edit(|settings| settings.progress = callback);
            Ok(())
        });
    }
}

/// Sets how carefully trees are built.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetSceneBuildQuality(scene: Handle, quality: c_uint) {
    let set = |scene: &Arc<Scene>| {
        if quality > 2 {
            return Err(Problem::operation(format!(
                "invalid quality {quality} of a scene; valid are 0 (low), 1 (medium) and 2 (high)"
            )));
        }
        scene.edit(|settings| settings.quality = quality);
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, set) }
}

/// Sets flags.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetSceneFlags(scene: Handle, flags: c_uint) {
    let set = |scene: &Arc<Scene>| {
        scene.edit(|settings| settings.flags = flags);
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, set) }
}

/// The flags.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetSceneFlags(scene: Handle) -> c_uint {
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, |scene| Ok(scene.settings().flags)) }
}

fn bounds_of(scene: &Scene, is_null: bool) -> Result<Option<Bounds>, Problem> {
    if is_null {
        return Err(Problem::argument("bounds: a null pointer"));
    }
    let committed = scene.unmodified().ok_or_else(not_committed)?;
    let bounds = run_query!(committed, tree => tree.bounds());
    Ok(Some(Bounds { lower: bounds.min, align0: 0.0, upper: bounds.max, align1: 0.0 }))
}

/// Writes the box around all.
///
/// # Safety
/// A scene, and room for a box.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetSceneBounds(scene: Handle, bounds: *mut Bounds) {
    // SAFETY: passed on.
    if let Some(found) = unsafe { with::<Scene, _>(scene, |scene| bounds_of(scene, bounds.is_null())) } {
        // SAFETY: passed on; programs need not align it.
        unsafe { bounds.write_unaligned(found) }
    }
}

/// Boxes at the times 0 and 1, between which all of the scene is at any time: between them, boxes go straight. One box, twice,
/// where something is an instance, or is not there all the time.
fn linear_bounds_of(scene: &Scene, is_null: bool) -> Result<Option<[Bounds; 2]>, Problem> {
    let Some(all) = bounds_of(scene, is_null)? else { return Ok(None) };
    let committed = scene.unmodified().ok_or_else(not_committed)?;
    let is_always = |surface: &Surface| surface.times[0] <= 0.0 && surface.times[1] >= 1.0;
    if matches!(committed.tree, Tree::Scene(_)) || !committed.surfaces.iter().all(is_always) {
        return Ok(Some([all; 2]));
    }
    let at = |time: f32| match committed.tree_at(time) {
        Some(tree) => run_tree!(&*tree, tree => tree.bounds()),
        None => run_query!(committed, tree => tree.bounds()),
    };
    let [mut start, mut end] = [at(0.0), at(1.0)];
    // Where steps are between, what goes beyond is added to both.
    let inner = committed.surfaces.iter().flat_map(|surface| {
        let ([from, to], steps) = (surface.times, surface.step_count());
        (0..steps).map(move |step| from + (to - from) * step as f32 / (steps.max(2) - 1) as f32)
    });
    for time in inner.filter(|&time| time > 0.0 && time < 1.0) {
        let there = at(time);
        for k in 0..3 {
            let mix = |a: f32, b: f32| a + time * (b - a);
            let below = (mix(start.min[k], end.min[k]) - there.min[k]).max(0.0);
            let above = (there.max[k] - mix(start.max[k], end.max[k])).max(0.0);
            for side in [&mut start, &mut end] {
                side.min[k] -= below;
                side.max[k] += above;
            }
        }
    }
    let bounds = |of: Aabb| Bounds { lower: of.min, align0: 0.0, upper: of.max, align1: 0.0 };
    Ok(Some([bounds(start), bounds(end)]))
}

/// Writes the boxes around all at the beginning and at the end of time.
///
/// # Safety
/// A scene, and room for two boxes.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetSceneLinearBounds(scene: Handle, bounds: *mut [Bounds; 2]) {
    // SAFETY: passed on.
    let found = unsafe { with::<Scene, _>(scene, |scene| linear_bounds_of(scene, bounds.is_null())) };
    if let Some(found) = found {
        // SAFETY: passed on.
        unsafe { bounds.write_unaligned(found) }
    }
}

/// The pointer that was given to a geometry.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryUserDataFromScene(
    scene: Handle,
    id: c_uint,
) -> *mut c_void {
    // SAFETY: passed on.
    if let Some(geometry) = unsafe { found_at_once(scene, id) } {
        return geometry.user_data();
    }
    let get = |scene: &Arc<Scene>| {
        let geometry = scene.geometry(id).ok_or_else(|| no_geometry(id))?;
        Ok(Pointer(geometry.user_data()))
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, get) }.0
}

/// The same.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryUserDataFromTraversable(
    scene: Handle,
    id: c_uint,
) -> *mut c_void {
    // SAFETY: passed on.
    unsafe { rtcGetGeometryUserDataFromScene(scene, id) }
}

/// Writes where an instance is.
///
/// # Safety
/// A scene, and room for a matrix of the format.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryTransformFromScene(
    scene: Handle,
    id: c_uint,
    time: f32,
    of: c_uint,
    matrix: *mut f32,
) {
    let get = |scene: &Arc<Scene>| {
        let geometry = scene.geometry(id).ok_or_else(|| no_geometry(id))?;
        slot_of(&geometry, 0, time, of, matrix.is_null()).map(Some)
    };
    // SAFETY: passed on.
    if let Some(values) = unsafe { with::<Scene, _>(scene, get) } {
        // SAFETY: passed on; there are as many values as the format has.
        unsafe { values.as_ptr().copy_to_nonoverlapping(matrix, values.len()) }
    }
}

/// The same.
///
/// # Safety
/// As above.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryTransformFromTraversable(
    scene: Handle,
    id: c_uint,
    time: f32,
    of: c_uint,
    matrix: *mut f32,
) {
    // SAFETY: passed on.
    unsafe { rtcGetGeometryTransformFromScene(scene, id, time, of, matrix) }
}

/// Where an instance is at a time, in this format; an error where the format or the number is invalid.
pub(crate) fn slot_of(
    geometry: &Geometry,
    prim_id: u32,
    time: f32,
    of: u32,
    is_null: bool,
) -> Result<Vec<f32>, Problem> {
    if is_null {
        return Err(Problem::argument("transform: a null pointer"));
    }
    let settings = geometry.settings();
    let (matrices, turns) = match settings.maps_of(prim_id as usize) {
        Some(maps) => maps,
        None if settings.has_maps() => {
            return Err(Problem::argument(format!("instance {prim_id} of the array is out of range")));
        }
        None => (settings.instance_matrices.clone(), settings.turns),
    };
    let place = path(&matrices, turns, settings.times);
    let columns = place.map_or(matrices[0], |path| path.at(time));
    let matrix = if of == format::FLOAT16 { format::FLOAT4X4_COLUMNS } else { of };
    transform::floats(matrix, &columns).ok_or_else(|| {
        Problem::argument(format!("invalid format {of:#x} of a matrix; valid are FLOAT3X4 and FLOAT4X4"))
    })
}
