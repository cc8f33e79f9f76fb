// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcNewScene` and its kin. Source: original; Embree's manual. Proof: `tests/c/embree.c`, `tests/c/embree.c`.

use std::ffi::{c_uint, c_void};
use std::ptr::null_mut;
use std::sync::Arc;

use crate::commit::commit;
use crate::device::Problem;
use crate::ffi_abi::{Bounds, format};
use crate::ffi_callbacks::{Callback, ProgressFunction};
use crate::ffi_handle::{Handle, lend, release, retain, shared, with, with_device};
use crate::ffi_trace::not_committed;
use crate::objects::{Geometry, Scene, ask};
use crate::transform;

/// A new scene. See Embree's manual, here and below.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcNewScene(device: Handle) -> Handle {
    // SAFETY: passed on.
    let scene = unsafe { with_device(device, |device| Ok(Some(Arc::new(Scene::new(Arc::clone(device)))))) };
    scene.map_or(null_mut(), lend)
}

/// The device of a scene, counted once more.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetSceneDevice(scene: Handle) -> Handle {
    // SAFETY: passed on.
    let device = unsafe { with::<Scene, _>(scene, |scene| Ok(Some(Arc::clone(&scene.device)))) };
    device.map_or(null_mut(), lend)
}

/// Counts a scene once more.
///
/// # Safety
/// A scene or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcRetainScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { retain::<Scene>(scene) }
}

/// Counts a scene once less.
///
/// # Safety
/// A scene or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcReleaseScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { release::<Scene>(scene) }
}

/// What rays are sent into: the scene itself.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetSceneTraversable(scene: Handle) -> Handle {
    scene
}

/// Attaches a geometry under the lowest free id.
///
/// # Safety
/// A scene and a geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcAttachGeometry(scene: Handle, geometry: Handle) -> c_uint {
    // SAFETY: passed on.
    let geometry = unsafe { shared::<Geometry>(geometry) };
    let attach = |scene: &Arc<Scene>| {
        let geometry = geometry.ok_or_else(|| Problem::argument("the geometry is a null pointer"))?;
        let mut draft = scene.draft();
        let ids = draft.geometries.keys().zip(0..);
        let id = ids.filter(|(id, place)| *id == place).count() as c_uint;
        draft.geometries.insert(id, geometry);
        Ok(Some(id))
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, attach) }.unwrap_or(c_uint::MAX)
}

/// Attaches a geometry under this id.
///
/// # Safety
/// A scene and a geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcAttachGeometryByID(scene: Handle, geometry: Handle, id: c_uint) {
    // SAFETY: passed on.
    let geometry = unsafe { shared::<Geometry>(geometry) };
    let attach = |scene: &Arc<Scene>| {
        let geometry = geometry.ok_or_else(|| Problem::argument("the geometry is a null pointer"))?;
        if id == c_uint::MAX {
            return Err(Problem::argument("RTC_INVALID_GEOMETRY_ID is no id for a geometry"));
        }
        let mut draft = scene.draft();
        if draft.geometries.contains_key(&id) {
            return Err(Problem::operation(format!("geometry {id} is there already: detach it first")));
        }
        draft.geometries.insert(id, geometry);
        Ok(())
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
pub(crate) unsafe extern "C" fn rtcDetachGeometry(scene: Handle, id: c_uint) {
    let detach = |scene: &Arc<Scene>| {
        let gone = scene.draft().geometries.remove(&id);
        gone.map(drop).ok_or_else(|| no_geometry(id))
    };
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, detach) }
}

/// A geometry of a scene, which does not count it for the program.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetGeometry(scene: Handle, id: c_uint) -> Handle {
    let get = |scene: &Arc<Scene>| {
        let geometry = scene.draft().geometries.get(&id).cloned();
        geometry.map(Some).ok_or_else(|| no_geometry(id))
    };
    // SAFETY: passed on.
    let geometry = unsafe { with::<Scene, _>(scene, get) };
    geometry.map_or(null_mut(), |geometry| Arc::as_ptr(&geometry).cast_mut().cast())
}

/// The same; it may be called from several threads.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetGeometryThreadSafe(scene: Handle, id: c_uint) -> Handle {
    // SAFETY: passed on.
    unsafe { rtcGetGeometry(scene, id) }
}

/// Builds what rays are sent into.
///
/// # Safety
/// A scene that nobody asks meanwhile; arrays and callbacks of its geometries are in order.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcCommitScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, |scene| commit(scene)) }
}

/// The same, called from several threads: the first one builds, the others wait and then build nothing.
///
/// # Safety
/// As [`rtcCommitScene`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcJoinCommitScene(scene: Handle) {
    // SAFETY: passed on.
    unsafe { rtcCommitScene(scene) }
}

/// Sets the function that is told how far a build is.
///
/// # Safety
/// A scene, and a function that may be called with the pointer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcSetSceneProgressMonitorFunction(
    scene: Handle,
    function: Option<ProgressFunction>,
    user: *mut c_void,
) {
    // SAFETY: passed on.
    let callback = unsafe { Callback::new(function, user) };
    // SAFETY: passed on.
    unsafe {
        with::<Scene, _>(scene, |scene| {
            scene.draft().progress = callback;
            Ok(())
        });
    }
}

/// Sets how carefully trees are built.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcSetSceneBuildQuality(scene: Handle, quality: c_uint) {
    let set = |scene: &Arc<Scene>| {
        if quality > 2 {
            return Err(Problem::operation(format!(
                "{quality} is no quality of a scene: low, medium and high are 0, 1 and 2"
            )));
        }
        scene.draft().quality = quality;
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
pub(crate) unsafe extern "C" fn rtcSetSceneFlags(scene: Handle, flags: c_uint) {
    let set = |scene: &Arc<Scene>| {
        scene.draft().flags = flags;
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
pub(crate) unsafe extern "C" fn rtcGetSceneFlags(scene: Handle) -> c_uint {
    // SAFETY: passed on.
    unsafe { with::<Scene, _>(scene, |scene| Ok(scene.draft().flags)) }
}

fn bounds_of(scene: &Scene) -> Result<Option<Bounds>, Problem> {
    let committed = scene.committed().ok_or_else(not_committed)?;
    let bounds = ask!(committed, tree => tree.bounds());
    Ok(Some(Bounds { lower: bounds.min, align0: 0.0, upper: bounds.max, align1: 0.0 }))
}

/// Writes the box around all.
///
/// # Safety
/// A scene, and room for a box.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetSceneBounds(scene: Handle, bounds: *mut Bounds) {
    // SAFETY: passed on.
    if let Some(found) = unsafe { with::<Scene, _>(scene, |scene| bounds_of(scene)) } {
        // SAFETY: passed on; programs need not align it.
        unsafe { bounds.write_unaligned(found) }
    }
}

/// Writes the box around all at the beginning and at the end of time: here they are one.
///
/// # Safety
/// A scene, and room for two boxes.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetSceneLinearBounds(scene: Handle, bounds: *mut [Bounds; 2]) {
    // SAFETY: passed on.
    if let Some(found) = unsafe { with::<Scene, _>(scene, |scene| bounds_of(scene)) } {
        // SAFETY: passed on.
        unsafe { bounds.write_unaligned([found; 2]) }
    }
}

/// The pointer that was given to a geometry.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetGeometryUserDataFromScene(scene: Handle, id: c_uint) -> *mut c_void {
    // SAFETY: passed on.
    let geometry = unsafe { shared::<Geometry>(rtcGetGeometry(scene, id)) };
    geometry.map_or(null_mut(), |geometry| geometry.user_data())
}

/// The same.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn rtcGetGeometryUserDataFromTraversable(
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
pub(crate) unsafe extern "C" fn rtcGetGeometryTransformFromScene(
    scene: Handle,
    id: c_uint,
    _time: f32,
    of: c_uint,
    matrix: *mut f32,
) {
    let get = |scene: &Arc<Scene>| {
        let geometry = scene.draft().geometries.get(&id).cloned().ok_or_else(|| no_geometry(id))?;
        place_of(&geometry, 0, of).map(Some)
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
pub(crate) unsafe extern "C" fn rtcGetGeometryTransformFromTraversable(
    scene: Handle,
    id: c_uint,
    time: f32,
    of: c_uint,
    matrix: *mut f32,
) {
    // SAFETY: passed on.
    unsafe { rtcGetGeometryTransformFromScene(scene, id, time, of, matrix) }
}

/// Where an instance is, in this format.
pub(crate) fn place_of(geometry: &Geometry, prim_id: u32, of: u32) -> Result<Vec<f32>, Problem> {
    let settings = geometry.settings();
    let place = match settings.arrays.get(&(crate::ffi_abi::buffer::TRANSFORM, 0)) {
        Some(maps) => {
            let size = transform::size(maps.format).unwrap_or_default();
            let values: Vec<f32> = (0..size).map_while(|k| maps.view.number(prim_id as usize, k)).collect();
            if values.len() != size {
                return Err(Problem::argument(format!("there is no instance {prim_id} in the array")));
            }
            transform::columns(maps.format, &values)
        }
        None => settings.place,
    };
    let matrix = if of == format::FLOAT16 { format::FLOAT4X4_COLUMNS } else { of };
    transform::floats(matrix, &place).ok_or_else(|| {
        Problem::argument(format!("{of:#x} is no format of a matrix: FLOAT3X4 or FLOAT4X4 is"))
    })
}
