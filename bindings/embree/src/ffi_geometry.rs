// SPDX-License-Identifier: GPL-3.0-or-later
//! `rtcNewGeometry` and similar functions: settings, callbacks and transforms of geometries. Source: Embree's
//! manual. Arrays are in `ffi_arrays.rs`. Tests: `tests/c/embree.c`.

use std::ffi::{c_uint, c_void};
use std::ptr::null_mut;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use gnurt_accel::{CurveBasis, CurveForm};

use crate::device::{Device, Problem};
use crate::ffi_abi::{BoundsFunction, FilterFunction, PointFunction, UserFunction, format, kind};
use crate::ffi_arrays::is_by_step;
use crate::ffi_handle::{Handle, lend, release, retain, shared, with, with_device};
use crate::ffi_scene::slot_of;
use crate::objects::{Geometry, Kind, Scene, Settings};
use crate::transform;

/// A new geometry. See Embree's manual, here and below.
///
/// # Safety
/// A device.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcNewGeometry(device: Handle, of: c_uint) -> Handle {
    let new = |device: &Arc<Device>| {
        let kind = match of {
            kind::TRIANGLE => Kind::Triangles,
            kind::QUAD => Kind::Quads,
            kind::GRID => Kind::Grids,
            kind::SUBDIVISION => Kind::Subdivision,
            kind::SPHERE_POINT => Kind::Spheres,
            kind::DISC_POINT => Kind::Discs(false),
            kind::ORIENTED_DISC_POINT => Kind::Discs(true),
            kind::CONE_LINEAR_CURVE => Kind::Cones,
            kind::ROUND_LINEAR_CURVE => Kind::Curves(CurveBasis::Linear, CurveForm::Round),
            kind::FLAT_LINEAR_CURVE => Kind::Curves(CurveBasis::Linear, CurveForm::Flat),
            kind::ROUND_BEZIER_CURVE => Kind::Curves(CurveBasis::Bezier, CurveForm::Round),
            kind::FLAT_BEZIER_CURVE => Kind::Curves(CurveBasis::Bezier, CurveForm::Flat),
            kind::NORMAL_ORIENTED_BEZIER_CURVE => Kind::Curves(CurveBasis::Bezier, CurveForm::Oriented),
            kind::ROUND_BSPLINE_CURVE => Kind::Curves(CurveBasis::BSpline, CurveForm::Round),
            kind::FLAT_BSPLINE_CURVE => Kind::Curves(CurveBasis::BSpline, CurveForm::Flat),
            kind::NORMAL_ORIENTED_BSPLINE_CURVE => Kind::Curves(CurveBasis::BSpline, CurveForm::Oriented),
            kind::ROUND_HERMITE_CURVE => Kind::Curves(CurveBasis::Hermite, CurveForm::Round),
            kind::FLAT_HERMITE_CURVE => Kind::Curves(CurveBasis::Hermite, CurveForm::Flat),
            kind::NORMAL_ORIENTED_HERMITE_CURVE => Kind::Curves(CurveBasis::Hermite, CurveForm::Oriented),
            kind::ROUND_CATMULL_ROM_CURVE => Kind::Curves(CurveBasis::CatmullRom, CurveForm::Round),
            kind::FLAT_CATMULL_ROM_CURVE => Kind::Curves(CurveBasis::CatmullRom, CurveForm::Flat),
            kind::NORMAL_ORIENTED_CATMULL_ROM_CURVE => {
                Kind::Curves(CurveBasis::CatmullRom, CurveForm::Oriented)
            }
            kind::USER => Kind::User,
            kind::INSTANCE => Kind::Instance,
            kind::INSTANCE_ARRAY => Kind::Instances,
            _ => {
                return Err(Problem::argument(format!(
                    "geometry type {of} is not supported: triangles, quads, grids, subdivision surfaces, curves, points, user \
                     geometry, instances and arrays of them are (0, 1, 2, 8, 15 to 60, 120, 121, 122)"
                )));
            }
        };
        if kind == Kind::Instances {
            device.has_arrays.store(true, Ordering::Relaxed);
        }
        Ok(Some(Arc::new(Geometry::new(Arc::clone(device), kind))))
    };
    // SAFETY: passed on.
    unsafe { with_device(device, new) }.map_or(null_mut(), lend)
}

/// Sets in how many straight pieces bent ribbons that face rays are cut, or edges of subdivision surfaces without a level.
/// Other curves are not cut here.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryTessellationRate(geometry: Handle, rate: f32) {
    let check = |geometry: &Arc<Geometry>| match geometry.kind {
        Kind::Curves(..) | Kind::Cones => {
            let mut settings = geometry.edit();
            // NaN is one.
            settings.pieces = rate.clamp(1.0, 16.0).max(1.0) as u8;
            settings.modified();
            Ok(())
        }
        Kind::Subdivision => {
            let mut settings = geometry.edit();
            settings.rate = rate.max(1.0);
            settings.modified();
            Ok(())
        }
        kind => Err(Problem::operation(format!(
            "rtcSetGeometryTessellationRate: not for {kind:?}, but curves and subdivision surfaces"
        ))),
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, check) }
}

/// Counts a geometry once more.
///
/// # Safety
/// A geometry or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcRetainGeometry(geometry: Handle) {
    // SAFETY: passed on.
    unsafe { retain::<Geometry>(geometry) }
}

/// Counts a geometry once less.
///
/// # Safety
/// A geometry or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcReleaseGeometry(geometry: Handle) {
    // SAFETY: passed on.
    unsafe { release::<Geometry>(geometry) }
}

/// Edits settings.
///
/// # Safety
/// A geometry.
unsafe fn edit(geometry: Handle, change: impl FnOnce(&mut Settings) -> Result<(), Problem>) {
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, |geometry| change(&mut geometry.edit())) }
}

/// Whether it is seen. Needs no separate commit.
fn enable(settings: &mut Settings, is_enabled: bool) {
    if settings.is_enabled != is_enabled {
        settings.is_enabled = is_enabled;
        settings.touched();
    }
}

/// Edits settings that only some kinds have.
///
/// # Safety
/// A geometry.
unsafe fn edit_only(
    geometry: Handle,
    kinds: &[Kind],
    call: &str,
    change: impl FnOnce(&mut Settings) -> Result<(), Problem>,
) {
    let checked = |geometry: &Arc<Geometry>| {
        if !kinds.contains(&geometry.kind) {
            return Err(Problem::operation(format!("{call}: not for {:?}, but {kinds:?}", geometry.kind)));
        }
        change(&mut geometry.edit())
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, checked) }
}

macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident($($value:ident: $type:ty),*) => $change:expr;)*) => { $(
        $(#[$doc])*
        ///
        /// # Safety
        /// A geometry; callbacks may be called as Embree's manual says.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C-unwind" fn $name(geometry: Handle $(, $value: $type)*) {
            let change: fn(&mut Settings $(, $type)*) = $change;
            // SAFETY: passed on.
            unsafe {
                edit(geometry, |settings| {
                    change(settings $(, $value)*);
                    Ok(())
                });
            }
        }
    )* };
}

setters! {
    /// All changes are made.
    rtcCommitGeometry() => |settings| {
        settings.is_committed = true;
        settings.forget();
        settings.touched();
    };
    /// It is seen.
    rtcEnableGeometry() => |settings| enable(settings, true);
    /// It is not seen.
    rtcDisableGeometry() => |settings| enable(settings, false);
    /// Which rays see it.
    rtcSetGeometryMask(mask: c_uint) => |settings, mask| {
        settings.mask = mask;
        settings.modified();
    };
    /// How many further arrays of vertex data there are.
    rtcSetGeometryVertexAttributeCount(count: c_uint) => |settings, count| {
        settings.attributes = count;
        settings.modified();
    };
    /// Decides on hits.
    rtcSetGeometryIntersectFilterFunction(filter: FilterFunction) => |settings, filter| {
        settings.filters.intersect = filter;
        settings.touched();
    };
    /// Decides on occlusion.
    rtcSetGeometryOccludedFilterFunction(filter: FilterFunction) => |settings, filter| {
        settings.filters.occluded = filter;
        settings.touched();
    };
    /// Whether filters of queries' arguments are called.
    rtcSetGeometryEnableFilterFunctionFromArguments(enable: bool) => |settings, enable| {
        settings.filters.from_arguments = enable;
        settings.touched();
    };
    /// Called for near points.
    rtcSetGeometryPointQueryFunction(function: PointFunction) => |settings, function| {
        settings.point = function;
        settings.touched();
    };
}

/// Sets how a geometry's trees are built; `REFIT` lets them follow.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryBuildQuality(geometry: Handle, quality: c_uint) {
    let change = |settings: &mut Settings| {
        if quality > 3 {
            return Err(Problem::operation(format!("invalid quality {quality}; valid are 0 to 3")));
        }
        settings.quality = quality;
        settings.touched();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(geometry, change) }
}

/// Sets how many time steps there are: arrays, boxes or transforms for each, evenly spaced in time.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryTimeStepCount(geometry: Handle, count: c_uint) {
    let change = |settings: &mut Settings| {
        if !(1..=MOST_STEPS).contains(&count) {
            return Err(Problem::operation(format!("{count} time steps: valid are 1 to {MOST_STEPS}")));
        }
        settings.steps = count;
        settings.instance_matrices.resize(count as usize, transform::IDENTITY);
        settings.arrays.retain(|&(of, slot), _| slot < count || !is_by_step(of));
        settings.modified();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(geometry, change) }
}

/// Sets the times of the first step and of the last. The geometry is not seen before and after these.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryTimeRange(geometry: Handle, start: f32, end: f32) {
    let change = |settings: &mut Settings| {
        if start.is_nan() || end.is_nan() || start > end {
            return Err(Problem::argument(format!(
                "times from {start} to {end}: the end is before the start"
            )));
        }
        settings.times = [start, end];
        settings.modified();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(geometry, change) }
}

/// There are no curves whose radius could be scaled; the radii of spheres remain, as they do in Embree
/// without a query's own setting.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryMaxRadiusScale(geometry: Handle, _scale: f32) {
    // SAFETY: passed on.
    unsafe { edit(geometry, |_| Ok(())) }
}

/// Sets a pointer of the program's.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryUserData(geometry: Handle, pointer: *mut c_void) {
    let set = |geometry: &Arc<Geometry>| {
        geometry.user_data.store(pointer, Ordering::Relaxed);
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { with::<Geometry, _>(geometry, set) }
}

/// That pointer.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryUserData(geometry: Handle) -> *mut c_void {
    // SAFETY: passed on.
    let geometry = unsafe { shared::<Geometry>(geometry) };
    geometry.map_or(null_mut(), |geometry| geometry.user_data())
}

/// Sets how many primitives a user geometry has.
///
/// # Safety
/// A geometry.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryUserPrimitiveCount(geometry: Handle, count: c_uint) {
    let change = |settings: &mut Settings| {
        if count as usize > gnurt_accel::MOST_TRIANGLES {
            let most = gnurt_accel::MOST_TRIANGLES;
            return Err(Problem::argument(format!("{count} primitives: a geometry has at most {most}")));
        }
        if settings.user_count != count {
            settings.user_count = count;
            settings.modified();
        }
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit_only(geometry, &[Kind::User], "rtcSetGeometryUserPrimitiveCount", change) }
}

/// Sets the function for boxes of user geometry.
///
/// # Safety
/// A geometry; the function may be called as Embree's manual says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryBoundsFunction(
    geometry: Handle,
    function: BoundsFunction,
    _user: *mut c_void,
) {
    let change = |settings: &mut Settings| {
        settings.user.bounds = function;
        settings.touched();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit_only(geometry, &[Kind::User], "rtcSetGeometryBoundsFunction", change) }
}

/// Sets the test of user geometry for hits.
///
/// # Safety
/// A geometry; the function may be called as Embree's manual says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryIntersectFunction(
    geometry: Handle,
    function: UserFunction,
) {
    let change = |settings: &mut Settings| {
        settings.user.intersect = function;
        settings.touched();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit_only(geometry, &[Kind::User], "rtcSetGeometryIntersectFunction", change) }
}

/// Sets the test of user geometry for occlusion.
///
/// # Safety
/// A geometry; the function may be called as Embree's manual says.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryOccludedFunction(
    geometry: Handle,
    function: UserFunction,
) {
    let change = |settings: &mut Settings| {
        settings.user.occluded = function;
        settings.touched();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit_only(geometry, &[Kind::User], "rtcSetGeometryOccludedFunction", change) }
}

const INSTANCES: [Kind; 2] = [Kind::Instance, Kind::Instances];

/// Sets the scene that an instance shows.
///
/// # Safety
/// A geometry, and a scene or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryInstancedScene(geometry: Handle, scene: Handle) {
    // SAFETY: passed on.
    let scene = unsafe { shared::<Scene>(scene) };
    // Dropped where nothing is locked: the end of a scene is reported to the memory monitor.
    let mut before = Vec::new();
    let change = |settings: &mut Settings| {
        before = std::mem::replace(&mut settings.scenes, scene.into_iter().collect());
        settings.modified();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit_only(geometry, &INSTANCES, "rtcSetGeometryInstancedScene", change) }
    drop(before);
}

/// Sets the scenes that an array of instances shows.
///
/// # Safety
/// A geometry, and an array of this many scenes.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryInstancedScenes(
    geometry: Handle,
    scenes: *const Handle,
    count: usize,
) {
    // SAFETY: passed on.
    let scenes: Option<Vec<Arc<Scene>>> =
        (0..count).map(|i| unsafe { shared::<Scene>(*scenes.add(i)) }).collect();
    let mut before = Vec::new();
    let change = |settings: &mut Settings| {
        let scenes = scenes.ok_or_else(|| Problem::argument("one of the scenes is a null pointer"))?;
        before = std::mem::replace(&mut settings.scenes, scenes);
        settings.modified();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit_only(geometry, &[Kind::Instances], "rtcSetGeometryInstancedScenes", change) }
    drop(before);
}

/// The most time steps of a geometry, as by Embree.
const MOST_STEPS: u32 = 129;

/// Reads and sets where an instance is.
///
/// # Safety
/// A geometry, and a matrix of the format.
unsafe fn set_place(geometry: Handle, time_step: c_uint, of: c_uint, matrix: *const f32, call: &str) {
    let change = |settings: &mut Settings| {
        let steps = settings.steps;
        let Some(place) = settings.instance_matrices.get_mut(time_step as usize) else {
            return Err(Problem::operation(format!("time step {time_step}: there are {steps}")));
        };
        if matrix.is_null() {
            return Err(Problem::argument("the transform is a null pointer"));
        }
        let size = transform::size(of).ok_or_else(|| {
            Problem::argument(format!("invalid format {of:#x} of a matrix; valid are FLOAT3X4 and FLOAT4X4"))
        })?;
        // SAFETY: the caller vouches for as many numbers as the format has.
        let values: Vec<f32> = (0..size).map(|i| unsafe { matrix.add(i).read_unaligned() }).collect();
        *place = transform::columns(of, &values);
        settings.turns = of == format::QUATERNION;
        settings.modified();
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit_only(geometry, &[Kind::Instance], call, change) }
}

/// Sets where an instance is.
///
/// # Safety
/// A geometry, and a matrix of the format.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryTransform(
    geometry: Handle,
    time_step: c_uint,
    of: c_uint,
    matrix: *const f32,
) {
    // SAFETY: passed on.
    unsafe { set_place(geometry, time_step, of, matrix, "rtcSetGeometryTransform") }
}

/// The same, decomposed.
///
/// # Safety
/// A geometry, and a decomposition.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcSetGeometryTransformQuaternion(
    geometry: Handle,
    time_step: c_uint,
    decomposition: *const f32,
) {
    // SAFETY: passed on: a decomposition is 16 floats.
    unsafe {
        let call = "rtcSetGeometryTransformQuaternion";
        set_place(geometry, time_step, format::QUATERNION, decomposition, call);
    }
}

/// Writes where an instance is.
///
/// # Safety
/// A geometry, and room for a matrix of the format.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryTransform(
    geometry: Handle,
    time: f32,
    of: c_uint,
    matrix: *mut f32,
) {
    // SAFETY: passed on.
    unsafe { rtcGetGeometryTransformEx(geometry, 0, time, of, matrix) }
}

/// The same for one of an array.
///
/// # Safety
/// As above.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn rtcGetGeometryTransformEx(
    geometry: Handle,
    prim_id: c_uint,
    time: f32,
    of: c_uint,
    matrix: *mut f32,
) {
    let get = |geometry: &Arc<Geometry>| slot_of(geometry, prim_id, time, of, matrix.is_null()).map(Some);
    // SAFETY: passed on.
    if let Some(values) = unsafe { with::<Geometry, _>(geometry, get) } {
        // SAFETY: passed on; there are as many values as the format has.
        unsafe { values.as_ptr().copy_to_nonoverlapping(matrix, values.len()) }
    }
}
