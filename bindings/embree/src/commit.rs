// SPDX-License-Identifier: GPL-3.0-or-later
//! Commit: from the draft of a scene to trees over all enabled geometries. Source: Embree's manual.
//! Space: that of the scene. Invariant: ids are those under which geometries were attached; bad primitives
//! are dropped, as by Embree. In a dynamic scene, or if all edits allow a refit, trees follow their geometry.
//! Tests: `tests/c/embree.c`.

use std::borrow::Cow;
use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex};

use gnurt_accel::{
    BuildControl, BuildError, BuildOptions, CurveBasis, CurveForm, Curves, Discs, GeometryKind, Grids,
    Instance, Memory, Motion, MovingQuads, MovingTree, MovingTriangles, ObjectTree, Quads, Quality, Query,
    SceneError, SceneTree, Shape, Spheres, Triangles, UserGeometry,
};

use crate::cells::{Cells, cells_before, grids_of, quads_of_grids};
use crate::cones::Cones;
use crate::cut::{Displace, cut};
use crate::device::Problem;
use crate::ffi_abi::{Code, buffer, quality, scene_flag};
use crate::ffi_callbacks::{Callback, ProgressFunction};
use crate::ffi_catch::Thrown;
use crate::ffi_displace::{Point, displace};
use crate::ffi_memory::View;
use crate::ffi_user::UserPrimitives;
use crate::objects::{
    Committed, Geometry, Kind, Moving, Plan, Scene, SceneSettings, Settings, Shown, ShownInstance,
    StepArrays, Surface, Tree, Uncut, path,
};
use crate::transform::{Columns, IDENTITY};

/// The most cells of grids: two triangles each.
const MOST_CELLS: u32 = (gnurt_accel::MOST_TRIANGLES / 2) as u32;

/// The source of a surface, and its mask.
struct Prepared<'a> {
    surface: &'a Surface,
    arrays: Arrays<'a>,
    mask: u32,
}

/// Lists are by time step.
enum Arrays<'a> {
    Triangles(Vec<Cow<'a, [[f32; 3]]>>, Cow<'a, [[u32; 3]]>),
    Quads(Vec<Cow<'a, [[f32; 3]]>>, Cow<'a, [[u32; 4]]>),
    /// Of one time step.
    Grids(Cow<'a, [[f32; 3]]>, Vec<gnurt_accel::Grid>),
    Spheres(Vec<(Vec<[f32; 3]>, Vec<f32>)>),
    Discs(Vec<DiscArrays<'a>>),
    Curves(Vec<CurveArrays<'a>>),
    Cones(Arc<Cones>),
    User(Arc<UserPrimitives>),
}

/// The arrays of discs.
struct DiscArrays<'a> {
    centers: Vec<[f32; 3]>,
    radii: Vec<f32>,
    normals: Option<Cow<'a, [[f32; 3]]>>,
}

impl DiscArrays<'_> {
    fn discs(&self) -> Discs<'_> {
        Discs { centers: &self.centers, radii: &self.radii, normals: self.normals.as_deref() }
    }
}

/// The arrays of curves.
struct CurveArrays<'a> {
    basis: CurveBasis,
    form: CurveForm,
    vertices: Cow<'a, [[f32; 4]]>,
    indices: Cow<'a, [[u32; 1]]>,
    tangents: Cow<'a, [[f32; 4]]>,
    normals: Cow<'a, [[f32; 3]]>,
    normal_tangents: Cow<'a, [[f32; 3]]>,
    joints: Cow<'a, [[u8; 1]]>,
    is_seen_from_outside: bool,
    pieces: u8,
}

impl CurveArrays<'_> {
    fn curves(&self) -> Curves<'_> {
        Curves {
            tangents: &self.tangents,
            normals: &self.normals,
            normal_tangents: &self.normal_tangents,
            joints: self.joints.as_flattened(),
            is_seen_from_outside: self.is_seen_from_outside,
            pieces: self.pieces,
            ..Curves::new(self.basis, self.form, &self.vertices, self.indices.as_flattened())
        }
    }
}

/// Centres and radii.
fn balls(vertices: &View) -> (Vec<[f32; 3]>, Vec<f32>) {
    vertices.rows::<f32, 4>().iter().map(|&[x, y, z, radius]| ([x, y, z], radius)).unzip()
}

impl Prepared<'_> {
    /// Vertices of triangles and quads by time step.
    fn keys(&self) -> Vec<&[[f32; 3]]> {
        match &self.arrays {
            Arrays::Triangles(keys, _) | Arrays::Quads(keys, _) => keys.iter().map(|key| &**key).collect(),
            _ => Vec::new(),
        }
    }

    /// The geometry, with these [`keys`](Self::keys).
    fn geometry<'b>(&'b self, keys: &'b [&'b [[f32; 3]]]) -> gnurt_accel::Geometry<'b> {
        let geometry: gnurt_accel::Geometry<'b> = match &self.arrays {
            Arrays::Triangles(_, indices) => match *keys {
                [positions] => Triangles { positions, indices }.into(),
                _ => MovingTriangles { keys, indices }.into(),
            },
            Arrays::Quads(_, indices) => match *keys {
                [positions] => Quads { positions, indices }.into(),
                _ => MovingQuads { keys, indices }.into(),
            },
            Arrays::Grids(positions, grids) => Grids { positions, grids }.into(),
            Arrays::Spheres(keys) => {
                let spheres =
                    |(centers, radii): &'b (Vec<_>, Vec<_>)| -> Spheres<'b> { Spheres { centers, radii } };
                let culls = self.surface.geometry.device.culls_spheres;
                match &keys[..] {
                    [only] if culls => {
                        gnurt_accel::Geometry::new(GeometryKind::SphereOutsides(spheres(only)))
                    }
                    [only] => spheres(only).into(),
                    _ => {
                        let keys: Vec<Spheres> = keys.iter().map(spheres).collect();
                        match culls {
                            true => gnurt_accel::Geometry::moving_sphere_outsides(&keys),
                            false => gnurt_accel::Geometry::moving_spheres(&keys),
                        }
                    }
                }
            }
            Arrays::Discs(keys) => match &keys[..] {
                [only] => only.discs().into(),
                _ => {
                    let keys: Vec<Discs> = keys.iter().map(DiscArrays::discs).collect();
                    gnurt_accel::Geometry::moving_discs(&keys)
                }
            },
            Arrays::Curves(keys) => match &keys[..] {
                [only] => only.curves().into(),
                _ => {
                    let keys: Vec<Curves> = keys.iter().map(CurveArrays::curves).collect();
                    gnurt_accel::Geometry::moving_curves(&keys)
                }
            },
            Arrays::Cones(cones) => {
                gnurt_accel::Geometry::new(GeometryKind::User(Arc::<Cones>::clone(cones)))
            }
            Arrays::User(user) => {
                gnurt_accel::Geometry::new(GeometryKind::User(Arc::<UserPrimitives>::clone(user)))
            }
        };
        geometry.with_mask(self.mask).within(self.surface.times)
    }

    fn user(&self) -> Option<Arc<UserPrimitives>> {
        match &self.arrays {
            Arrays::User(user) => Some(Arc::clone(user)),
            _ => None,
        }
    }

    fn count(&self) -> usize {
        match &self.arrays {
            Arrays::Triangles(_, indices) => indices.len(),
            Arrays::Quads(_, indices) => indices.len(),
            Arrays::Grids(positions, grids) => Grids { positions, grids }.cells(),
            Arrays::Spheres(keys) => keys[0].1.len(),
            Arrays::Discs(keys) => keys[0].radii.len(),
            Arrays::Curves(keys) => keys[0].indices.len(),
            Arrays::Cones(cones) => cones.count() as usize,
            Arrays::User(user) => user.count() as usize,
        }
    }
}

thread_local! {
    /// Scenes whose commits have called a function of the program on this thread: their addresses.
    static COMMITTING: RefCell<Vec<usize>> = const { RefCell::new(Vec::new()) };
}

/// This thread is in a commit of a scene, or in a function of the program that one has called.
struct Inside;

impl Inside {
    fn enter(scene: &Scene) -> Self {
        COMMITTING.with_borrow_mut(|scenes| scenes.push(std::ptr::from_ref(scene).addr()));
        Self
    }

    fn is(scene: &Scene) -> bool {
        COMMITTING.with_borrow(|scenes| scenes.contains(&std::ptr::from_ref(scene).addr()))
    }
}

impl Drop for Inside {
    fn drop(&mut self) {
        COMMITTING.with_borrow_mut(|scenes| scenes.pop());
    }
}

/// Builds the draft, and publishes it for queries; does nothing if the last commit has built the same. Of
/// several threads one builds, and the others return after it.
///
/// # Errors
/// An uncommitted geometry, a missing array, or the reason that stopped the build.
pub(crate) fn commit(scene: &Scene) -> Result<(), Problem> {
    if Inside::is(scene) {
        return Err(Problem::operation("the scene is being committed: its commit has called this function"));
    }
    let _inside = Inside::enter(scene);
    let mut building = scene.build();
    let plan = scene.plan();
    if !plan.is_modified() {
        return Ok(());
    }
    // The state left by a panicking build is not used again.
    let mut moving = building.take();
    let committed = build(scene, plan, &mut moving);
    *building = moving;
    let gone = scene.publish(committed?);
    // The memory monitor is called at its end, and may commit.
    drop((building, _inside));
    drop(gone);
    Ok(())
}

fn build(scene: &Scene, plan: Plan, moving: &mut Option<Moving>) -> Result<Committed, Problem> {
    let (mut surfaces, mut masks, mut users) = (Vec::new(), Vec::new(), Vec::new());
    let mut uncut = Vec::new();
    let mut shown_instances = vec![ShownInstance {
        geom_id: 0,
        prim_id: None,
        shown: None,
        world_from_instance: IDENTITY,
        motion: None,
    }];
    let mut instances: Vec<Instance> = Vec::new();
    // Geometries of the quality REFIT, and whether others were edited since the last commit.
    let (mut refits, mut others_differ) = (0, false);
    for &(geom_id, ref geometry) in &plan.geometries {
        let settings = geometry.settings();
        if !settings.is_enabled {
            continue;
        }
        if !settings.is_committed {
            return Err(Problem::operation(format!(
                "geometry {geom_id} is not committed: call rtcCommitGeometry"
            )));
        }
        if matches!(geometry.kind, Kind::Instance | Kind::Instances) {
            add_instances(geom_id, geometry, &settings, scene, &mut shown_instances, &mut instances)?;
            continue;
        }
        let follows = settings.quality == quality::REFIT;
        refits += u32::from(follows);
        others_differ |= !follows && settings.changed_at > plan.last;
        users.push((geometry.kind == Kind::User).then(|| {
            let Settings { user, filters, user_count, steps, .. } = *settings;
            (user, filters, user_count, steps)
        }));
        uncut.push(match geometry.kind {
            Kind::Subdivision => Some(Uncut {
                edit: settings.changed_at,
                control: settings.control(0).map_err(|problem| problem.of_geometry(geom_id))?,
                levels: settings.array(buffer::LEVEL, 0),
                rate: settings.rate,
                displacement: settings.displacement,
            }),
            _ => None,
        });
        surfaces.push(surface(geom_id, geometry, &settings)?);
        masks.push(settings.mask);
    }
    // From here on functions of the program may query settings, and edit them: nothing is locked but commits
    // of this scene.
    for (surface, uncut) in surfaces.iter_mut().zip(&uncut) {
        let Some(uncut) = uncut else { continue };
        let geometry = Arc::clone(&surface.geometry);
        let displace = |prim_id: u32, time_step: u32, points: &mut [Point]| {
            // The threads of this are in the commit as well.
            let _inside = Inside::enter(scene);
            displace(uncut.displacement, &geometry, prim_id, time_step, points)
        };
        let displace: Option<Displace> = uncut.displacement.is_some().then_some(&displace);
        let workers = scene.device.workers(16 * uncut.control.faces() as usize);
        cut(surface, uncut, displace, workers.threads())?;
    }
    let mut prepared = Vec::new();
    for ((surface, &mask), user) in surfaces.iter().zip(&masks).zip(users) {
        let arrays = match (surface.kind, user) {
            (_, Some((functions, filters, count, steps))) => {
                let geometry = Arc::clone(&surface.geometry);
                let user = UserPrimitives::new(geometry, surface.geom_id, functions, filters, count, steps)?;
                Arrays::User(Arc::new(user))
            }
            (Kind::Grids, None) if !surface.moves() => {
                Arrays::Grids(surface.first.vertices.rows(), grids_of(&surface.indices))
            }
            (Kind::Grids, None) => {
                let keys = surface.steps().map(|step| step.vertices.rows()).collect();
                Arrays::Quads(keys, Cow::Owned(quads_of_grids(&surface.indices)))
            }
            (Kind::Quads | Kind::Subdivision, None) => {
                let keys = surface.steps().map(|step| step.vertices.rows()).collect();
                Arrays::Quads(keys, surface.indices.rows())
            }
            (Kind::Spheres, None) => {
                Arrays::Spheres(surface.steps().map(|step| balls(&step.vertices)).collect())
            }
            (Kind::Discs(has_normals), None) => {
                let discs = surface.steps().map(|step| {
                    let (centers, radii) = balls(&step.vertices);
                    DiscArrays { centers, radii, normals: has_normals.then(|| step.normals.rows()) }
                });
                Arrays::Discs(discs.collect())
            }
            (Kind::Cones, None) => {
                let steps = surface.steps().map(|step| step.vertices.clone()).collect();
                let (indices, flags) = (surface.indices.clone(), surface.joints.clone());
                let cones = Cones::new(steps, surface.times, indices, flags, scene.device.culls_curves);
                Arrays::Cones(Arc::new(cones))
            }
            (Kind::Curves(basis, form), None) => {
                let curves = surface.steps().map(|step| CurveArrays {
                    basis,
                    form,
                    vertices: step.vertices.rows(),
                    indices: surface.indices.rows(),
                    tangents: step.tangents.rows(),
                    normals: step.normals.rows(),
                    normal_tangents: step.normal_tangents.rows(),
                    joints: surface.joints.rows(),
                    is_seen_from_outside: basis == CurveBasis::Linear || scene.device.culls_curves,
                    pieces: surface.pieces,
                });
                Arrays::Curves(curves.collect())
            }
            _ => {
                let keys = surface.steps().map(|step| step.vertices.rows()).collect();
                Arrays::Triangles(keys, surface.indices.rows())
            }
        };
        prepared.push(Prepared { surface, arrays, mask });
    }
    let is_dynamic = plan.settings.flags & scene_flag::DYNAMIC != 0;
    let follow = Follow { moves: is_dynamic || refits > 0, may_refit: is_dynamic || !others_differ };
    let control = Control::new(scene, plan.settings.progress);
    let object = build_object(&plan.settings, &control, moving, &prepared, follow)?;
    let users: Vec<Option<Arc<UserPrimitives>>> = prepared.iter().map(Prepared::user).collect();
    drop((prepared, control));
    for (surface, user) in surfaces.iter_mut().zip(users) {
        surface.user = user.map(|user| user as Arc<dyn UserGeometry>);
    }
    let options = options_of(&plan.settings);
    let tree = if instances.is_empty() {
        Tree::Object(object)
    } else {
        instances.insert(0, Instance::identity(object));
        let workers = scene.device.workers(instances.len());
        let control = Control::new(scene, plan.settings.progress);
        let built = SceneTree::try_build(&instances, &options, workers.threads(), &control);
        let built = match built {
            // An instance that cannot be placed is invisible, as by Embree.
            Err(SceneError::Build(error)) => return Err(control.problem(&error)),
            Err(SceneError::TooDeep { inst_id }) => {
                let geom_id = shown_instances[inst_id as usize].geom_id;
                return Err(Problem::operation(format!(
                    "geometry {geom_id}: scenes are nested more than {} levels deep",
                    gnurt_accel::DEEPEST_SCENE
                )));
            }
            Err(_) => SceneTree::build(&instances, &options, workers.threads()),
            Ok(built) => built,
        };
        Tree::Scene(Arc::new(built))
    };
    let bytes = match &tree {
        Tree::Object(tree) => held(tree.stats()),
        Tree::Scene(tree) => {
            held(tree.stats()) + shown_instances.len() as i64 * size_of::<ShownInstance>() as i64
        }
    };
    let is_plain = surfaces.iter().all(|surface| !surface.filters.any() && surface.kind != Kind::User)
        && shown_instances
            .iter()
            .filter_map(|shown_instance| shown_instance.shown.as_ref())
            .all(|shown| shown.committed.is_plain);
    let device = Arc::clone(&scene.device);
    let query = Query { level: device.level, ..Query::default() };
    let allowed = device.report_memory(bytes);
    let Plan { edit_number, geometries, .. } = plan;
    // Gives the bytes back where it is dropped.
    let committed = Committed {
        device,
        edit_number,
        geometries,
        tree,
        surfaces,
        shown_instances,
        query,
        is_plain,
        bytes,
        stopped: Mutex::default(),
    };
    match allowed {
        Ok(true) => Ok(committed),
        Ok(false) => {
            let message = format!("the memory monitor has rejected {bytes} bytes");
            Err(Problem { code: Code::OutOfMemory, message })
        }
        Err(thrown) => Err(thrown.into()),
    }
}

fn held(stats: gnurt_accel::TreeStats) -> i64 {
    (stats.tree_bytes + stats.primitive_bytes) as i64
}

/// Arrays of a geometry, as they are now.
fn surface(geom_id: u32, geometry: &Arc<Geometry>, settings: &Settings) -> Result<Surface, Problem> {
    let array = |of: u32, slot: u32, name: &str| -> Result<View, Problem> {
        let array = settings.arrays.get(&(of, slot));
        array.map(|array| array.view.clone()).ok_or_else(|| {
            let at = if settings.steps > 1 { format!(" for time step {slot}") } else { String::new() };
            Problem::operation(format!(
                "geometry {geom_id} has no {name} buffer{at}: set one, then commit it"
            ))
        })
    };
    let kind = geometry.kind;
    let mut cells = None;
    // No setting means no primitives, which is no error with Embree either.
    let is_empty =
        settings.arrays.is_empty() || matches!(kind, Kind::User | Kind::Instance | Kind::Instances);
    let step = |slot: u32| -> Result<StepArrays, Problem> {
        Ok(StepArrays {
            vertices: if is_empty { View::empty() } else { array(buffer::VERTEX, slot, "vertex")? },
            normals: settings.array(buffer::NORMAL, slot),
            tangents: settings.array(buffer::TANGENT, slot),
            normal_tangents: settings.array(buffer::NORMAL_DERIVATIVE, slot),
        })
    };
    let first = step(0)?;
    let indices = match kind {
        Kind::Triangles | Kind::Quads | Kind::Curves(..) | Kind::Cones if !is_empty => {
            array(buffer::INDEX, 0, "index")?
        }
        Kind::Subdivision if !is_empty => {
            array(buffer::FACE, 0, "face")?;
            array(buffer::INDEX, 0, "index")?
        }
        Kind::Grids if !is_empty => array(buffer::GRID, 0, "grid")?,
        _ => View::empty(),
    };
    if kind == Kind::Grids {
        let before = cells_before(&indices);
        let before = before.filter(|before| before.last().is_none_or(|&all| all <= MOST_CELLS));
        cells = Some(Cells::Grids(before.ok_or_else(|| {
            Problem::operation(format!("geometry {geom_id}: its grids have more than {MOST_CELLS} cells"))
        })?));
    }
    let later = (1..settings.steps).map(step).collect::<Result<Vec<_>, _>>()?;
    if let Some(wrong) = later.iter().position(|step| step.vertices.len() != first.vertices.len()) {
        let (step, count) = (wrong + 1, later[wrong].vertices.len());
        return Err(Problem::operation(format!(
            "geometry {geom_id}: time step {step} has {count} vertices, the first one {}",
            first.vertices.len()
        )));
    }
    let Settings { filters, point, times, .. } = *settings;
    Ok(Surface {
        geom_id,
        geometry: Arc::clone(geometry),
        kind,
        indices,
        cells,
        first,
        later,
        times,
        pieces: settings.pieces,
        joints: settings.array(buffer::FLAGS, 0),
        filters,
        point,
        user: None,
    })
}

/// Instances of a geometry's scene or scenes.
fn add_instances(
    geom_id: u32,
    geometry: &Geometry,
    settings: &Settings,
    scene: &Scene,
    shown_instances: &mut Vec<ShownInstance>,
    instances: &mut Vec<Instance>,
) -> Result<(), Problem> {
    let mut add = |prim_id: Option<u32>,
                   shown: usize,
                   keys: &[Columns],
                   turns: bool|
     -> Result<(), Problem> {
        let Some(child) = settings.scenes.get(shown) else {
            return Err(Problem::operation(format!(
                "geometry {geom_id} shows scene {shown}, which was not set"
            )));
        };
        if std::ptr::eq(Arc::as_ptr(child), scene) {
            return Err(Problem::operation(format!("geometry {geom_id} shows the scene that it is in")));
        }
        let committed = child.committed().ok_or_else(|| {
            Problem::operation(format!(
                "geometry {geom_id} shows a scene that is not committed: call rtcCommitScene"
            ))
        })?;
        let shape: Shape = match &committed.tree {
            Tree::Object(tree) => Arc::clone(tree).into(),
            Tree::Scene(tree) => Arc::clone(tree).into(),
        };
        let motion = path(keys, turns, settings.times);
        let instance = match &motion {
            Some(motion) => Instance::moving(shape, Arc::clone(motion)),
            None => Instance::new(shape, keys[0]),
        };
        instances.push(instance.with_mask(settings.mask));
        let shown = Some(Shown { committed, scene: Arc::clone(child) });
        shown_instances.push(ShownInstance { geom_id, prim_id, shown, world_from_instance: keys[0], motion });
        Ok(())
    };
    if geometry.kind == Kind::Instance {
        return add(None, 0, &settings.instance_matrices, settings.turns);
    }
    let Some(maps) = settings.arrays.get(&(buffer::TRANSFORM, 0)) else {
        return Err(Problem::operation(format!("geometry {geom_id} has no transform buffer")));
    };
    let indices = settings.arrays.get(&(buffer::INDEX, 0));
    for i in 0..maps.view.len() {
        let (keys, turns) = settings.maps_of(i).unwrap_or_else(|| (vec![IDENTITY], false));
        let shown = indices.map_or(Some(0), |indices| indices.view.number::<u32>(i, 0));
        // Those without an index, or with that of nothing, are not there.
        if let Some(shown) = shown.filter(|&shown| shown != u32::MAX) {
            add(Some(i as u32), shown as usize, &keys, turns)?;
        }
    }
    Ok(())
}

fn options_of(settings: &SceneSettings) -> BuildOptions {
    let quality = match settings.quality {
        quality::LOW => Quality::Fast,
        quality::HIGH => Quality::High,
        _ => Quality::Medium,
    };
    let is_compact = settings.flags & scene_flag::COMPACT != 0;
    let memory = if is_compact { Memory::Compact } else { Memory::Fast };
    BuildOptions { quality, memory, ..BuildOptions::default() }
}

/// How a tree follows its geometry.
#[derive(Clone, Copy)]
struct Follow {
    /// Whether it is stored, to be refitted by later commits.
    moves: bool,
    /// Whether all that was edited since the last commit may be refitted.
    may_refit: bool,
}

/// The tree over the scene's own surfaces.
fn build_object(
    settings: &SceneSettings,
    control: &Control,
    moving: &mut Option<Moving>,
    prepared: &[Prepared],
    follow: Follow,
) -> Result<Arc<ObjectTree>, Problem> {
    let keys: Vec<Vec<&[[f32; 3]]>> = prepared.iter().map(Prepared::keys).collect();
    let geometries: Vec<gnurt_accel::Geometry> =
        prepared.iter().zip(&keys).map(|(one, keys)| one.geometry(keys)).collect();
    let primitives: usize = prepared.iter().map(Prepared::count).sum();
    let shape =
        prepared.iter().map(|one| (one.surface.geom_id, one.surface.kind, one.count() as u32)).collect();
    let (options, workers) = (options_of(settings), control.scene.device.workers(primitives));
    if follow.moves
        && follow.may_refit
        && let Some((tree, before)) = moving
        && *before == shape
    {
        // A refit takes no unreported memory, and is over before it could be stopped halfway.
        control.progress(0.0);
        if !control.keep_going() {
            return Err(control.problem(&BuildError::Cancelled));
        }
        tree.update(&geometries, &options, workers.threads());
        control.progress(1.0);
        return Ok(Arc::clone(tree.tree()));
    }
    let built = ObjectTree::try_build_from(&geometries, &options, workers.threads(), control);
    let tree = Arc::new(built.map_err(|error| control.problem(&error))?);
    // A function that has thrown at the end of the build has not stopped it.
    if !control.keep_going() {
        return Err(control.problem(&BuildError::Cancelled));
    }
    *moving = follow.moves.then(|| (MovingTree::of(Arc::clone(&tree), Motion::Auto), shape));
    Ok(tree)
}

/// The program's callbacks during the build of a tree.
struct Control<'a> {
    scene: &'a Scene,
    progress: Option<Callback<ProgressFunction>>,
    /// Bytes that were reported to the memory monitor.
    reported: AtomicI64,
    /// Whether the memory monitor has refused memory.
    refused: AtomicBool,
    cancelled: AtomicBool,
    thrown: AtomicBool,
}

impl<'a> Control<'a> {
    fn new(scene: &'a Scene, progress: Option<Callback<ProgressFunction>>) -> Self {
        let no = || AtomicBool::new(false);
        let reported = AtomicI64::new(0);
        Self { scene, progress, reported, refused: no(), cancelled: no(), thrown: no() }
    }

    fn problem(&self, error: &BuildError) -> Problem {
        if self.thrown.load(Ordering::Relaxed) {
            return Thrown.into();
        }
        let code = match error {
            _ if self.refused.load(Ordering::Relaxed) => Code::OutOfMemory,
            BuildError::Cancelled => Code::Cancelled,
            BuildError::OutOfMemory { .. } => Code::OutOfMemory,
            _ => Code::InvalidOperation,
        };
        Problem { code, message: error.to_string() }
    }
}

impl Drop for Control<'_> {
    fn drop(&mut self) {
        // The return value and exceptions of the program's function are ignored here.
        let _ = self.scene.device.report_memory(-self.reported.load(Ordering::Relaxed));
    }
}

impl BuildControl for Control<'_> {
    fn keep_going(&self) -> bool {
        ![&self.refused, &self.cancelled, &self.thrown].iter().any(|no| no.load(Ordering::Relaxed))
    }

    fn progress(&self, done: f32) {
        let Some(progress) = &self.progress else { return };
        // The build's threads are in the commit as well.
        let _inside = Inside::enter(self.scene);
        match progress.call(f64::from(done)) {
            Ok(true) => {}
            Ok(false) => self.cancelled.store(true, Ordering::Relaxed),
            Err(Thrown) => self.thrown.store(true, Ordering::Relaxed),
        }
    }

    fn memory(&self, bytes: u64) {
        let more = bytes as i64 - self.reported.swap(bytes as i64, Ordering::Relaxed);
        let _inside = Inside::enter(self.scene);
        match self.scene.device.report_memory(more) {
            Ok(true) => {}
            Ok(false) => self.refused.store(true, Ordering::Relaxed),
            Err(Thrown) => self.thrown.store(true, Ordering::Relaxed),
        }
    }
}
