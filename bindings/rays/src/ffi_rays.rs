// SPDX-License-Identifier: GPL-3.0-or-later
//! The calls of `gnurt/rays.h` that make and edit scenes. See include/gnurt/rays.h. Queries are in `ffi_query.rs`.
//! No panic gets past [`called`]. Tests: `tests/c/rays.c`.

use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use gnurt_accel::{
    Aabb, BuildOptions, CurveBasis, CurveForm, Grid, Memory, Quality, Ray, Structure, Threads, UserGeometry,
    UserHit,
};

use crate::ffi_catch;
use crate::ffi_columns::{Access, Array, Column, Rows, aabb};
use crate::ffi_memory::Pointer;
use crate::pools::Workers;
use crate::ray_scene::{Built, Columns, CurveArrays, IDENTITY, Part, Primitives, RayScene, What, query_tree};

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Runs a call: 0, or -1 and a message.
pub(crate) fn called(call: impl FnOnce() -> Result<(), String>) -> c_int {
    let answer = catch_unwind(AssertUnwindSafe(call));
    match answer.unwrap_or_else(|_| Err("an error in libgnurt; the call had no effect".into())) {
        Ok(()) => 0,
        Err(message) => {
            LAST.set(CString::new(message.replace('\0', " ")).unwrap_or_default());
            -1
        }
    }
}

/// Fewer rays than that are answered by the calling thread: waking others takes as long.
const WORTH_THREADS: usize = 64;

/// Runs a job over a number of rays or points with a number of threads: 0 for all processors.
pub(crate) fn with_threads<R>(threads: usize, count: usize, job: impl FnOnce(Threads) -> R) -> R {
    let workers = if count < WORTH_THREADS { Workers::single() } else { Workers::new(threads) };
    job(workers.threads())
}

/// The version of the library.
#[unsafe(no_mangle)]
pub(crate) extern "C-unwind" fn gnurt_rays_version() -> c_int {
    let number = |text: &str| text.parse::<c_int>().unwrap_or(0);
    let [major, minor, patch] =
        [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")];
    10_000 * number(major) + 100 * number(minor) + number(patch)
}

/// The last error of this thread.
#[unsafe(no_mangle)]
pub(crate) extern "C-unwind" fn gnurt_last_error() -> *const c_char {
    LAST.with_borrow(|last| last.as_ptr())
}

/// A new scene. See include/gnurt/rays.h, here and below.
#[unsafe(no_mangle)]
pub(crate) extern "C-unwind" fn gnurt_scene_new() -> *mut RayScene {
    Box::into_raw(Box::default())
}

/// Frees a scene.
///
/// # Safety
/// A scene without other users, or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_scene_free(scene: *mut RayScene) {
    if !scene.is_null() {
        called(|| {
            // SAFETY: made by `gnurt_scene_new`, and not used by anybody else.
            drop(unsafe { Box::from_raw(scene) });
            Ok(())
        });
    }
}

/// Edits a scene.
///
/// # Safety
/// A scene without concurrent users, or null.
unsafe fn edit(scene: *mut RayScene, change: impl FnOnce(&mut RayScene) -> Result<(), String>) -> c_int {
    called(|| {
        // SAFETY: passed on.
        change(unsafe { scene.as_mut() }.ok_or("scene: a null pointer")?)
    })
}

/// The last commit of a scene.
///
/// # Safety
/// A scene without a concurrent edit, or null.
pub(crate) unsafe fn built(scene: *const RayScene) -> Result<Arc<Built>, String> {
    // SAFETY: passed on.
    let scene = unsafe { scene.as_ref() }.ok_or("scene: a null pointer")?;
    scene.built.clone().ok_or_else(|| "scene: it is not committed; call gnurt_commit first".into())
}

/// `gnurt_build`.
#[repr(C)]
pub(crate) struct Build {
    quality: c_int,
    compact: c_int,
    kd: c_int,
    moves: c_int,
    threads: c_uint,
    doubles: c_int,
}

/// How trees are built.
///
/// # Safety
/// A scene and options.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_scene_options(
    scene: *mut RayScene,
    build: *const Build,
) -> c_int {
    let change = |scene: &mut RayScene| {
        // SAFETY: passed on.
        let build = unsafe { build.as_ref() }.ok_or("options: a null pointer")?;
        let quality = match build.quality {
            -1 => Quality::Fast,
            0 => Quality::Medium,
            1 => Quality::High,
            other => return Err(format!("quality: {other}; -1, 0 or 1 is expected")),
        };
        let memory = if build.compact != 0 { Memory::Compact } else { Memory::Fast };
        let structure = if build.kd != 0 { Structure::Kd } else { Structure::Bvh };
        let is_double = build.doubles != 0;
        if is_double && (build.kd != 0 || build.moves != 0) {
            return Err("doubles: there are no kd-trees of them, and none that are refitted".into());
        }
        let options = BuildOptions { quality, memory, structure, ..BuildOptions::default() };
        scene.set_options(options, build.moves != 0, is_double)?;
        scene.threads = build.threads as usize;
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// Adds a part and writes its id.
///
/// # Safety
/// A scene, and room for an id or null.
unsafe fn add(
    scene: *mut RayScene,
    id: *mut u32,
    mask: u32,
    what: impl FnOnce() -> Result<What, String>,
) -> c_int {
    called(|| {
        // First: an added array may be in the scene itself, which is not borrowed otherwise below.
        let what = what()?;
        // SAFETY: passed on.
        let scene = unsafe { scene.as_mut() }.ok_or("scene: a null pointer")?;
        let new = scene.add(Part { what, mask })?;
        if !id.is_null() {
            // SAFETY: passed on.
            unsafe { id.write(new) }
        }
        Ok(())
    })
}

/// Adds triangles.
///
/// # Safety
/// A scene, arrays that are readable until the next commit, room for an id or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_triangles(
    scene: *mut RayScene,
    positions: Array,
    indices: Array,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe {
        add(scene, id, mask, || {
            let rows = Rows::new(&positions, 3, Access::Floats, "positions")?;
            let (positions, doubles) = (Column::Given(rows.clone()), Column::Given(rows));
            let indices = Column::Given(Rows::new(&indices, 3, Access::Indices, "indices")?);
            Ok(What::Triangles { positions, doubles, indices })
        })
    }
}

/// Adds quads.
///
/// # Safety
/// As [`gnurt_add_triangles`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_quads(
    scene: *mut RayScene,
    positions: Array,
    indices: Array,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe {
        add(scene, id, mask, || {
            let positions = Column::Given(Rows::new(&positions, 3, Access::Floats, "positions")?);
            let indices = Column::Given(Rows::new(&indices, 4, Access::Indices, "indices")?);
            Ok(What::Quads { positions, indices })
        })
    }
}

/// Adds grids.
///
/// # Safety
/// As [`gnurt_add_triangles`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_grids(
    scene: *mut RayScene,
    positions: Array,
    grids: Array,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe {
        add(scene, id, mask, || {
            let positions = Column::Given(Rows::new(&positions, 3, Access::Floats, "positions")?);
            let rows = Rows::new(&grids, 4, Access::Indices, "grids")?.u32_rows();
            Ok(What::Grids {
                positions,
                grids: rows.into_iter().enumerate().map(grid).collect::<Result<_, _>>()?,
            })
        })
    }
}

/// The grid of a row: first vertex, stride, columns, rows.
fn grid((row, [first, stride, columns, rows]): (usize, [u32; 4])) -> Result<Grid, String> {
    let size = |size: u32, what: &str| {
        u16::try_from(size)
            .map_err(|_| format!("grids: row {row} has {size} {what} of vertices; {} is the most", u16::MAX))
    };
    Ok(Grid { first, stride, width: size(columns, "columns")?, height: size(rows, "rows")? })
}

/// Adds spheres.
///
/// # Safety
/// As [`gnurt_add_triangles`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_spheres(
    scene: *mut RayScene,
    centers: Array,
    radii: Array,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe {
        add(scene, id, mask, || {
            if centers.count != radii.count {
                return Err(format!("radii: {} for {} centres", radii.count, centers.count));
            }
            let centers = Column::Given(Rows::new(&centers, 3, Access::Floats, "centers")?);
            let radii = Column::Given(Rows::new(&radii, 1, Access::Floats, "radii")?);
            Ok(What::Spheres { centers, radii })
        })
    }
}

/// Adds discs.
///
/// # Safety
/// As [`gnurt_add_triangles`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_discs(
    scene: *mut RayScene,
    centers: Array,
    radii: Array,
    normals: Array,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe {
        add(scene, id, mask, || {
            for (what, array) in [("radii", &radii), ("normals", &normals)] {
                if centers.count != array.count && !(what == "normals" && array.data.is_null()) {
                    return Err(format!("{what}: {} for {} centres", array.count, centers.count));
                }
            }
            let centers = Column::Given(Rows::new(&centers, 3, Access::Floats, "centers")?);
            let radii = Column::Given(Rows::new(&radii, 1, Access::Floats, "radii")?);
            let normals = match normals.data.is_null() {
                true => None,
                false => Some(Column::Given(Rows::new(&normals, 3, Access::Floats, "normals")?)),
            };
            Ok(What::Discs { centers, radii, normals })
        })
    }
}

/// `gnurt_curves`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct CurvesGiven {
    basis: u32,
    form: u32,
    vertices: Array,
    segments: Array,
    tangents: Array,
    normals: Array,
    normal_tangents: Array,
}

/// Adds curves.
///
/// # Safety
/// As [`gnurt_add_triangles`]; curves, or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_curves(
    scene: *mut RayScene,
    curves: *const CurvesGiven,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe {
        add(scene, id, mask, || {
            let given = curves.as_ref().ok_or("curves: a null pointer")?;
            let basis = match given.basis {
                0 => CurveBasis::Linear,
                1 => CurveBasis::Bezier,
                2 => CurveBasis::BSpline,
                3 => CurveBasis::CatmullRom,
                4 => CurveBasis::Hermite,
                other => return Err(format!("basis: {other}; one of enum gnurt_basis is expected")),
            };
            let form = match given.form {
                0 => CurveForm::Flat,
                1 => CurveForm::Round,
                2 => CurveForm::Oriented,
                other => return Err(format!("form: {other}; one of enum gnurt_form is expected")),
            };
            let (has_tangents, has_normals) = (basis == CurveBasis::Hermite, form == CurveForm::Oriented);
            for (what, array, is_needed) in [
                ("tangents", &given.tangents, has_tangents),
                ("normals", &given.normals, has_normals),
                ("normal_tangents", &given.normal_tangents, has_tangents && has_normals),
            ] {
                let needed = if is_needed { given.vertices.count } else { 0 };
                if array.count != needed {
                    return Err(format!("{what}: {} rows; {needed} are expected", array.count));
                }
            }
            // No rows of any type are fine.
            let rows = |array: &Array, width: usize, what: &str| {
                let array = if array.count == 0 { Array::EMPTY } else { *array };
                Rows::new(&array, width, Access::Floats, what)
            };
            Ok(What::Curves(Box::new(CurveArrays {
                basis,
                form,
                vertices: Column::Given(rows(&given.vertices, 4, "vertices")?),
                segments: Column::Given(Rows::new(&given.segments, 1, Access::Indices, "segments")?),
                tangents: Column::Given(rows(&given.tangents, 4, "tangents")?),
                normals: Column::Given(rows(&given.normals, 3, "normals")?),
                normal_tangents: Column::Given(rows(&given.normal_tangents, 3, "normal_tangents")?),
            })))
        })
    }
}

/// `gnurt_user_ray`.
#[repr(C)]
pub(crate) struct UserRay {
    prim_id: u32,
    org: [f32; 3],
    dir: [f32; 3],
    t_near: f32,
    t_far: f32,
}

/// `gnurt_user_hit`.
#[repr(C)]
pub(crate) struct UserAnswer {
    t: f32,
    u: f32,
    v: f32,
}

/// `gnurt_user`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct User {
    user: *mut c_void,
    count: u32,
    bounds: Option<unsafe extern "C-unwind" fn(*mut c_void, u32, u32, *mut [f32; 6])>,
    intersect: Option<unsafe extern "C-unwind" fn(*mut c_void, usize, *const UserRay, *mut UserAnswer)>,
}

/// A user geometry as trees see it.
#[derive(Debug)]
struct Callbacks {
    user: Pointer,
    intersect: unsafe extern "C-unwind" fn(*mut c_void, usize, *const UserRay, *mut UserAnswer),
    boxes: Vec<Aabb>,
    thrown: Arc<AtomicU64>,
}

impl UserGeometry for Callbacks {
    fn count(&self) -> u32 {
        self.boxes.len() as u32
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        self.boxes[prim_id as usize]
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, hit: &mut dyn FnMut(UserHit)) {
        let Ray { org, dir, t_near, t_far, .. } = *ray;
        let query_ray = UserRay { prim_id, org, dir, t_near, t_far };
        let mut answer = UserAnswer { t: f32::NAN, u: 0.0, v: 0.0 };
        // SAFETY: the program gave the function to be called like this, from any thread.
        let call = || unsafe { (self.intersect)(self.user.0, 1, &raw const query_ray, &raw mut answer) };
        if ffi_catch::call(call).is_err() {
            // The query, maybe that of another thread, reports it.
            self.thrown.fetch_add(1, Ordering::Relaxed);
            return;
        }
        // SAFETY: it is our own value, which the program wrote through a pointer.
        let UserAnswer { t, u, v } = unsafe { (&raw const answer).read_volatile() };
        if !t.is_nan() {
            hit(UserHit { t, u, v });
        }
    }
}

/// Primitives of the program, with boxes from its function.
///
/// # Safety
/// Functions that may be called from any thread as long as the scene is used, or null.
unsafe fn primitives(user: *const User) -> Result<Primitives, String> {
    // SAFETY: passed on.
    let User { user, count, bounds, intersect } = *unsafe { user.as_ref() }.ok_or("user: a null pointer")?;
    let (Some(bounds), Some(intersect)) = (bounds, intersect) else {
        return Err("user: bounds or intersect is a null pointer".to_owned());
    };
    if count as usize > gnurt_accel::MOST_TRIANGLES {
        return Err(format!("user: {count} primitives; there can be {}", gnurt_accel::MOST_TRIANGLES));
    }
    let mut boxes = vec![[f32::NAN; 6]; count as usize];
    if count > 0 {
        // SAFETY: passed on; there is room for this many boxes.
        let call = || unsafe { bounds(user, 0, count, boxes.as_mut_ptr()) };
        ffi_catch::call(call).map_err(|thrown| format!("user: bounds: {thrown}"))?;
    }
    let (boxes, thrown) = (boxes.into_iter().map(aabb).collect(), Arc::new(AtomicU64::new(0)));
    let callbacks = Callbacks { user: Pointer(user), intersect, boxes, thrown: Arc::clone(&thrown) };
    Ok(Primitives { geometry: Arc::new(callbacks), thrown })
}

/// Adds primitives of the program's.
///
/// # Safety
/// A scene, functions that may be called from any thread as long as the scene is used, room for an id or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_user(
    scene: *mut RayScene,
    user: *const User,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe { add(scene, id, mask, || Ok(What::User(primitives(user)?))) }
}

/// Other primitives of the program's, or the same in other boxes.
///
/// # Safety
/// As [`gnurt_add_user`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_set_user(
    scene: *mut RayScene,
    id: u32,
    user: *const User,
) -> c_int {
    // Before the scene is borrowed for the change: the program's function may query it.
    let mut new = None;
    let found = called(|| {
        // SAFETY: passed on.
        new = Some(unsafe { primitives(user)? });
        Ok(())
    });
    let Some(new) = new else { return found };
    let change = |scene: &mut RayScene| {
        match &mut scene.part(id)?.what {
            What::User(user) => *user = new,
            _ => return Err(format!("id: {id} has no primitives of the program")),
        }
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// Twelve numbers.
///
/// # Safety
/// Twelve numbers, or null.
unsafe fn matrix_at(instance_matrix: *const f64) -> Result<Columns, String> {
    if instance_matrix.is_null() {
        return Err("place: a null pointer".into());
    }
    // SAFETY: passed on.
    let columns: Columns = unsafe { instance_matrix.cast::<Columns>().read_unaligned() };
    if columns.iter().flatten().any(|x| !x.is_finite()) {
        return Err("place: a number is not finite".into());
    }
    Ok(columns)
}

/// Adds another scene as an instance.
///
/// # Safety
/// Two scenes, twelve numbers, room for an id or null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_add_instance(
    scene: *mut RayScene,
    shown: *const RayScene,
    instance_matrix: *const f64,
    mask: u32,
    id: *mut u32,
) -> c_int {
    // SAFETY: passed on.
    unsafe {
        add(scene, id, mask, || {
            let shown = built(shown).map_err(|error| error.replacen("scene", "shown", 1))?;
            Ok(What::Instance { shown, instance_matrix: matrix_at(instance_matrix)? })
        })
    }
}

/// Other positions, or centres.
///
/// # Safety
/// A scene, and an array that is readable until the next commit.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_set_positions(
    scene: *mut RayScene,
    id: u32,
    array: Array,
) -> c_int {
    let change = |scene: &mut RayScene| {
        if let What::Curves(curves) = &mut scene.part(id)?.what {
            // SAFETY: passed on.
            let rows = unsafe { Rows::new(&array, 4, Access::Floats, "positions")? };
            if rows.len() != curves.vertices.len() {
                return Err(format!("positions: {} for {} vertices", rows.len(), curves.vertices.len()));
            }
            curves.vertices = Column::Given(rows);
            return Ok(());
        }
        // SAFETY: passed on.
        let rows = unsafe { Rows::new(&array, 3, Access::Floats, "positions")? };
        let new = Column::Given(rows.clone());
        match &mut scene.part(id)?.what {
            What::Triangles { positions, doubles, .. } => {
                (*positions, *doubles) = (new, Column::Given(rows));
            }
            What::Quads { positions, .. } | What::Grids { positions, .. } => *positions = new,
            What::Spheres { centers, radii } | What::Discs { centers, radii, .. }
                if radii.len() == new.len() =>
            {
                *centers = new;
            }
            What::Spheres { radii, .. } | What::Discs { radii, .. } => {
                return Err(format!("positions: {} for {} radii", new.len(), radii.len()));
            }
            What::Curves(_) | What::User(_) | What::Instance { .. } => {
                return Err(format!("id: {id} has no positions"));
            }
        }
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// Sets an instance's transform.
///
/// # Safety
/// A scene, and twelve numbers.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_set_place(
    scene: *mut RayScene,
    id: u32,
    to: *const f64,
) -> c_int {
    let change = |scene: &mut RayScene| {
        // SAFETY: passed on.
        let to = unsafe { matrix_at(to)? };
        match &mut scene.part(id)?.what {
            What::Instance { instance_matrix, .. } => *instance_matrix = to,
            _ => return Err(format!("id: {id} is not an instance")),
        }
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// Replaces the scene that an instance shows, or updates it.
///
/// # Safety
/// Two scenes.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_set_shown(
    scene: *mut RayScene,
    id: u32,
    new: *const RayScene,
) -> c_int {
    // Before the scene is lent for the change: it may be the same one.
    // SAFETY: passed on.
    let new = unsafe { built(new) };
    let change = |scene: &mut RayScene| {
        let new = new.map_err(|error| error.replacen("scene", "shown", 1))?;
        scene.fits(&What::Instance { shown: Arc::clone(&new), instance_matrix: IDENTITY })?;
        match &mut scene.part(id)?.what {
            What::Instance { shown, .. } => *shown = new,
            _ => return Err(format!("id: {id} is not an instance")),
        }
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// Another mask.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_set_mask(scene: *mut RayScene, id: u32, mask: u32) -> c_int {
    let change = |scene: &mut RayScene| {
        scene.part(id)?.mask = mask;
        Ok(())
    };
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// Takes a part out.
///
/// # Safety
/// A scene.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_remove(scene: *mut RayScene, id: u32) -> c_int {
    let change = |scene: &mut RayScene| scene.remove(id);
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// Builds.
///
/// # Safety
/// A scene without concurrent queries, whose arrays are readable.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_commit(scene: *mut RayScene) -> c_int {
    let change =
        |scene: &mut RayScene| with_threads(scene.threads, usize::MAX, |threads| scene.commit(threads));
    // SAFETY: passed on.
    unsafe { edit(scene, change) }
}

/// `gnurt_facts`.
#[repr(C)]
pub(crate) struct SceneProperties {
    lower: [f32; 3],
    upper: [f32; 3],
    primitives: u64,
    left_out: u64,
    bytes: u64,
}

/// Properties of a committed scene.
///
/// # Safety
/// A scene, and space for the facts.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C-unwind" fn gnurt_scene_facts(
    scene: *const RayScene,
    properties: *mut SceneProperties,
) -> c_int {
    called(|| {
        // SAFETY: passed on.
        let built = unsafe { built(scene)? };
        let (bounds, stats) = (query_tree!(built, tree => tree.bounds()), built.object.stats());
        let (mut bounds, mut stats, mut left_out) = (bounds, stats, built.object.bad_primitives().total());
        if let Some(doubles) = &built.doubles {
            let [min, max] = doubles.bounds();
            // Rounded outwards, unless there is nothing.
            let is_empty = min[0] > max[0];
            let low = |x: f64| if is_empty { x as f32 } else { (x as f32).next_down() };
            let high = |x: f64| if is_empty { x as f32 } else { (x as f32).next_up() };
            bounds = Aabb { min: min.map(low), max: max.map(high) };
            (stats, left_out) = (doubles.stats(), doubles.bad().total());
        }
        if properties.is_null() {
            return Err("facts: a null pointer".into());
        }
        let found = SceneProperties {
            lower: bounds.min,
            upper: bounds.max,
            primitives: stats.primitives,
            left_out,
            bytes: stats.tree_bytes + stats.primitive_bytes,
        };
        // SAFETY: passed on.
        unsafe { properties.write(found) };
        Ok(())
    })
}
