// SPDX-License-Identifier: GPL-3.0-or-later
//! The targets of `RTCGeometry`, `RTCScene` and `RTCBuffer`. In one file, since scenes hold geometries and
//! geometries show scenes. Source: Embree's manual. Invariant: queries read only [`Committed`], which never
//! changes; edits stay in the mutexes until the next commit. Tests: `tests/c/embree.c`.

use std::collections::BTreeMap;
use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use gnurt_accel::{
    CurveBasis, CurveForm, KeyInterval, MotionPath, MovingTree, ObjectTree, Query, SceneTree, Threads,
    UserGeometry,
};

use crate::cells::{self, Cells, Patches};
use crate::control::{Control, Input};
use crate::device::{Device, Problem};
use crate::ffi_abi::{
    BoundsFunction, DisplacementFunction, FilterFunction, PointFunction, UserFunction, buffer, format,
};
use crate::ffi_callbacks::{Callback, ProgressFunction};
use crate::ffi_memory::{Block, Pointer, View};
use crate::free_ids::FreeIds;
use crate::transform::{self, Columns, IDENTITY};

/// The kind and data of a geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Triangles,
    Quads,
    Grids,
    Subdivision,
    Spheres,
    /// Whether they have normals.
    Discs(bool),
    Curves(CurveBasis, CurveForm),
    /// Straight ones that are cut at right angles.
    Cones,
    User,
    Instance,
    Instances,
}

/// The target of `RTCBuffer`.
#[derive(Debug)]
pub(crate) struct Buffer {
    pub(crate) device: Arc<Device>,
    /// `None` where the program lends the memory.
    pub(crate) block: Option<Arc<Block>>,
    pub(crate) start: Pointer,
    pub(crate) bytes: usize,
}

/// An array that was given to a geometry.
#[derive(Clone, Debug)]
pub(crate) struct Array {
    pub(crate) view: View,
    pub(crate) format: u32,
}

/// Functions that decide on hits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Filters {
    pub(crate) intersect: FilterFunction,
    pub(crate) occluded: FilterFunction,
    /// Whether those of a query's arguments are called, too.
    pub(crate) from_arguments: bool,
}

impl Filters {
    pub(crate) fn any(&self) -> bool {
        self.intersect.is_some() || self.occluded.is_some() || self.from_arguments
    }
}

/// Functions of user geometry.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct UserFunctions {
    pub(crate) bounds: BoundsFunction,
    pub(crate) intersect: UserFunction,
    pub(crate) occluded: UserFunction,
}

/// Faces of a subdivision surface, by vertices or by values of a kind.
#[derive(Clone, Debug)]
pub(crate) struct Topology {
    pub(crate) mode: u32,
    /// As the arrays were at the last commit, once a call has asked for it.
    control: OnceLock<Arc<Control>>,
}

impl Topology {
    /// With a smooth boundary.
    pub(crate) fn new() -> Self {
        Self { mode: 1, control: OnceLock::new() }
    }
}

/// The state that calls edit.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// By type and slot.
    pub(crate) arrays: BTreeMap<(u32, u32), Array>,
    pub(crate) mask: u32,
    pub(crate) quality: u32,
    pub(crate) is_enabled: bool,
    pub(crate) is_committed: bool,
    /// The number of the last edit.
    pub(crate) changed_at: u64,
    pub(crate) filters: Filters,
    pub(crate) user: UserFunctions,
    pub(crate) user_count: u32,
    pub(crate) point: PointFunction,
    pub(crate) scenes: Vec<Arc<Scene>>,
    /// In how many straight pieces bent ribbons that face rays are cut.
    pub(crate) pieces: u8,
    /// Of subdivision surfaces, one or more.
    pub(crate) topologies: Vec<Topology>,
    /// By vertex attribute, where it is not the first one.
    pub(crate) attribute_topologies: BTreeMap<u32, u32>,
    /// The level of edges without one of their own.
    pub(crate) rate: f32,
    pub(crate) displacement: DisplacementFunction,
    /// How many time steps it has.
    pub(crate) steps: u32,
    /// The times of the first step and of the last.
    pub(crate) times: [f32; 2],
    /// Of an instance, by time step.
    pub(crate) instance_matrices: Vec<Columns>,
    /// Whether these were set as quaternions: rotations follow the arc between them, while entries of matrices go straight.
    pub(crate) turns: bool,
    pub(crate) attributes: u32,
}

/// The way of an instance through these matrices; `None` where it stands still, or cannot be placed.
pub(crate) fn path(matrices: &[Columns], turns: bool, times: [f32; 2]) -> Option<Arc<MotionPath>> {
    if matrices.len() < 2 {
        return None;
    }
    let path = if turns { MotionPath::new(matrices) } else { MotionPath::straight(matrices) };
    Some(Arc::new(path?.within(times)))
}

impl Settings {
    /// Whether there are transforms of an array of instances.
    pub(crate) fn has_maps(&self) -> bool {
        self.arrays.contains_key(&(buffer::TRANSFORM, 0))
    }

    /// Where one of an array of instances is at each time step, and whether rotations follow the arc between these.
    pub(crate) fn maps_of(&self, i: usize) -> Option<(Vec<Columns>, bool)> {
        let mut turns = false;
        let map = |step: u32| {
            let maps = self.arrays.get(&(buffer::TRANSFORM, step))?;
            let size = transform::size(maps.format)?;
            turns |= maps.format == format::QUATERNION;
            let values: Vec<f32> = (0..size).map_while(|k| maps.view.number(i, k)).collect();
            (values.len() == size).then(|| transform::columns(maps.format, &values))
        };
        let maps = (0..self.steps).map(map).collect::<Option<_>>()?;
        Some((maps, turns))
    }

    /// An array; empty where there is none.
    pub(crate) fn array(&self, of: u32, slot: u32) -> View {
        self.arrays.get(&(of, slot)).map_or_else(View::empty, |array| array.view.clone())
    }

    /// The control mesh of a topology.
    ///
    /// # Errors
    /// There is none of the number, or its arrays do not fit together.
    pub(crate) fn control(&self, topology: u32) -> Result<Arc<Control>, Problem> {
        let Some(known) = self.topologies.get(topology as usize) else {
            let count = self.topologies.len();
            return Err(Problem::argument(format!("topology {topology}: there are {count}")));
        };
        if let Some(control) = known.control.get() {
            return Ok(Arc::clone(control));
        }
        let array = |of: u32| self.array(of, 0);
        let (indices, first_indices) = (self.array(buffer::INDEX, topology), array(buffer::INDEX));
        let control = Control::new(&Input {
            mode: known.mode,
            faces: &array(buffer::FACE),
            indices: &indices,
            first_indices: &first_indices,
            vertices: (topology == 0).then(|| array(buffer::VERTEX).len()),
            holes: &array(buffer::HOLE),
            edge_creases: [&array(buffer::EDGE_CREASE_INDEX), &array(buffer::EDGE_CREASE_WEIGHT)],
            vertex_creases: [&array(buffer::VERTEX_CREASE_INDEX), &array(buffer::VERTEX_CREASE_WEIGHT)],
        })?;
        Ok(Arc::clone(known.control.get_or_init(|| Arc::new(control))))
    }

    /// Arrays were written: what was made of them is not used any more.
    pub(crate) fn forget(&mut self) {
        self.topologies.iter_mut().for_each(|topology| topology.control = OnceLock::new());
    }

    /// Something was changed that the program has to commit.
    pub(crate) fn modified(&mut self) {
        self.is_committed = false;
        self.forget();
        self.touched();
    }

    /// Something was changed that scenes see when they are committed.
    pub(crate) fn touched(&mut self) {
        self.changed_at = next_edit_number();
    }
}

/// The next of the numbers that order edits; never 0.
pub(crate) fn next_edit_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// The target of `RTCGeometry`.
#[derive(Debug)]
pub(crate) struct Geometry {
    pub(crate) device: Arc<Device>,
    pub(crate) kind: Kind,
    pub(crate) user_data: AtomicPtr<c_void>,
    settings: RwLock<Settings>,
    /// A subdivision surface as it was cut last, and the number of its last edit then.
    cut: Mutex<Option<(u64, CutSurface)>>,
}

/// A subdivision surface as quads; copies share its memory.
#[derive(Clone, Debug)]
pub(crate) struct CutSurface {
    pub(crate) patches: Arc<Patches>,
    pub(crate) indices: View,
    /// By time step.
    pub(crate) vertices: Vec<View>,
}

impl Geometry {
    pub(crate) fn new(device: Arc<Device>, kind: Kind) -> Self {
        let settings = Settings {
            arrays: BTreeMap::new(),
            mask: 1,
            quality: 1,
            is_enabled: true,
            is_committed: false,
            changed_at: next_edit_number(),
            filters: Filters::default(),
            user: UserFunctions::default(),
            user_count: 0,
            point: None,
            scenes: Vec::new(),
            pieces: 4,
            topologies: vec![Topology::new()],
            attribute_topologies: BTreeMap::new(),
            rate: 2.0,
            displacement: None,
            steps: 1,
            times: [0.0, 1.0],
            instance_matrices: vec![IDENTITY],
            turns: false,
            attributes: 0,
        };
        let user_data = AtomicPtr::new(std::ptr::null_mut());
        Self { device, kind, user_data, settings: RwLock::new(settings), cut: Mutex::default() }
    }

    pub(crate) fn settings(&self) -> RwLockReadGuard<'_, Settings> {
        self.settings.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn edit(&self) -> RwLockWriteGuard<'_, Settings> {
        self.settings.write().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn user_data(&self) -> *mut c_void {
        self.user_data.load(Ordering::Relaxed)
    }

    /// The surface as it was cut after this edit.
    pub(crate) fn cut_at(&self, edit: u64) -> Option<CutSurface> {
        let cut = self.cut.lock().unwrap_or_else(PoisonError::into_inner);
        cut.as_ref().filter(|(then, _)| *then == edit).map(|(_, surface)| surface.clone())
    }

    /// Keeps a cut surface for commits without edits of it.
    pub(crate) fn keep_cut(&self, edit: u64, surface: CutSurface) {
        *self.cut.lock().unwrap_or_else(PoisonError::into_inner) = Some((edit, surface));
    }
}

/// The target of `RTCScene`.
///
/// Locks are taken in this order: `building`, a geometry's settings, a draft. Only the first is held while functions of the program run.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) device: Arc<Device>,
    draft: Mutex<Draft>,
    building: Mutex<Option<Moving>>,
    /// Held by the draft; null before the first commit.
    current: AtomicPtr<Committed>,
    /// Whether geometries came or went since `current` was made.
    list_differs: AtomicBool,
    /// The number of the edit when `current` was made.
    published_at: AtomicU64,
}

/// A surface of a tree: its id, its kind, and how many primitives it has.
pub(crate) type Listed = (u32, Kind, u32);

/// A tree that follows its geometry, and its geometries.
pub(crate) type Moving = (MovingTree, Vec<Listed>);

/// The state that calls edit, and the result of the last commit.
#[derive(Debug)]
struct Draft {
    geometries: BTreeMap<u32, Arc<Geometry>>,
    free: FreeIds,
    settings: SceneSettings,
    /// The number of the last edit of the list or of the settings.
    changed_at: u64,
    committed: Option<Arc<Committed>>,
    /// Queries that run during a new commit, against the rules, still read it.
    before: Option<Arc<Committed>>,
}

/// How a scene is built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SceneSettings {
    pub(crate) quality: u32,
    pub(crate) flags: u32,
    pub(crate) progress: Option<Callback<ProgressFunction>>,
}

/// The input of a commit: the draft at one time.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) geometries: Vec<(u32, Arc<Geometry>)>,
    pub(crate) settings: SceneSettings,
    /// Edits up to here are in it.
    pub(crate) edit_number: u64,
    /// The number of the commit before; 0 where there was none.
    pub(crate) last: u64,
    /// Whether the list or the settings were edited since then.
    is_edited: bool,
}

impl Plan {
    /// Whether the last commit has made something else.
    pub(crate) fn is_modified(&self) -> bool {
        self.is_edited
            || self.geometries.iter().any(|(_, geometry)| {
                let settings = geometry.settings();
                settings.changed_at > self.last
                    || settings
                        .scenes
                        .iter()
                        .any(|shown| shown.published_at.load(Ordering::Acquire) > self.last)
            })
    }
}

impl Scene {
    pub(crate) fn new(device: Arc<Device>) -> Self {
        let draft = Draft {
            geometries: BTreeMap::new(),
            free: FreeIds::default(),
            settings: SceneSettings { quality: 1, flags: 0, progress: None },
            changed_at: next_edit_number(),
            committed: None,
            before: None,
        };
        Self {
            device,
            draft: Mutex::new(draft),
            building: Mutex::default(),
            current: AtomicPtr::default(),
            list_differs: AtomicBool::new(false),
            published_at: AtomicU64::new(0),
        }
    }

    fn draft(&self) -> MutexGuard<'_, Draft> {
        self.draft.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Attaches a geometry under an id, or the lowest free one; `None` where that is taken, or none is free.
    pub(crate) fn attach(&self, id: Option<u32>, geometry: Arc<Geometry>) -> Option<u32> {
        let mut draft = self.draft();
        let id = id.or_else(|| draft.free.lowest())?;
        if draft.geometries.contains_key(&id) {
            return None;
        }
        draft.free.take(id);
        draft.geometries.insert(id, geometry);
        draft.changed_at = next_edit_number();
        self.list_differs.store(true, Ordering::Release);
        Some(id)
    }

    /// Takes a geometry out.
    pub(crate) fn detach(&self, id: u32) -> Option<Arc<Geometry>> {
        let mut draft = self.draft();
        let gone = draft.geometries.remove(&id)?;
        draft.free.give(id);
        draft.changed_at = next_edit_number();
        self.list_differs.store(true, Ordering::Release);
        Some(gone)
    }

    /// A geometry of the draft.
    pub(crate) fn geometry(&self, id: u32) -> Option<Arc<Geometry>> {
        self.draft().geometries.get(&id).cloned()
    }

    pub(crate) fn settings(&self) -> SceneSettings {
        self.draft().settings
    }

    /// Edits settings.
    pub(crate) fn edit(&self, change: impl FnOnce(&mut SceneSettings)) {
        let mut draft = self.draft();
        let before = draft.settings;
        change(&mut draft.settings);
        if (before.quality, before.flags) != (draft.settings.quality, draft.settings.flags) {
            draft.changed_at = next_edit_number();
        }
    }

    /// Lets one commit build at a time.
    pub(crate) fn build(&self) -> MutexGuard<'_, Option<Moving>> {
        self.building.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next commit's input.
    pub(crate) fn plan(&self) -> Plan {
        let draft = self.draft();
        // First: edits during this function count as later.
        let edit_number = next_edit_number();
        let last = draft.committed.as_ref().map_or(0, |committed| committed.edit_number);
        let geometries = draft.geometries.iter().map(|(&id, geometry)| (id, Arc::clone(geometry))).collect();
        let is_edited = draft.changed_at > last;
        Plan { geometries, settings: draft.settings, edit_number, last, is_edited }
    }

    /// Publishes a commit for queries. Returns unneeded data, to be dropped outside of locks.
    pub(crate) fn publish(&self, committed: Committed) -> Option<Arc<Committed>> {
        let committed = Arc::new(committed);
        let mut draft = self.draft();
        self.current.store(Arc::as_ptr(&committed).cast_mut(), Ordering::Release);
        self.list_differs.store(draft.changed_at > committed.edit_number, Ordering::Release);
        self.published_at.store(next_edit_number(), Ordering::Release);
        let before = draft.committed.replace(committed);
        std::mem::replace(&mut draft.before, before)
    }

    /// The result of the last commit, as a counted reference.
    pub(crate) fn committed(&self) -> Option<Arc<Committed>> {
        self.draft().committed.clone()
    }

    /// The same, if the list of geometries and the settings were not edited since.
    pub(crate) fn unmodified(&self) -> Option<Arc<Committed>> {
        let draft = self.draft();
        draft.committed.clone().filter(|committed| draft.changed_at < committed.edit_number)
    }

    /// The same to be read at once: null before the first commit, else it lives as long as the scene is not committed twice.
    #[inline]
    pub(crate) fn current(&self) -> *const Committed {
        self.current.load(Ordering::Acquire)
    }

    /// Whether the commit has the geometries of the draft.
    pub(crate) fn has_all(&self) -> bool {
        !self.list_differs.load(Ordering::Acquire)
    }
}

/// A scene for queries.
#[derive(Debug)]
pub(crate) struct Committed {
    pub(crate) device: Arc<Device>,
    /// Edits up to here are in it.
    pub(crate) edit_number: u64,
    /// All of the scene, in the order of their ids.
    pub(crate) geometries: Vec<(u32, Arc<Geometry>)>,
    pub(crate) tree: Tree,
    /// By the numbers that the tree has for them.
    pub(crate) surfaces: Vec<Surface>,
    /// The shown instances; the first one is that of the scene's own surfaces.
    pub(crate) shown_instances: Vec<ShownInstance>,
    pub(crate) query: Query,
    /// Whether no callback judges hits.
    pub(crate) is_plain: bool,
    /// As reported to the memory monitor.
    pub(crate) bytes: i64,
    /// The scene at the time of the last point query of another time than 0, and that time.
    pub(crate) stopped: Mutex<Option<(f32, Arc<Tree>)>>,
}

impl Committed {
    /// The tree at a time, where something in it moves.
    pub(crate) fn tree_at(&self, time: f32) -> Option<Arc<Tree>> {
        if !run_query!(self, tree => tree.moves()) {
            return None;
        }
        let mut stopped = self.stopped.lock().unwrap_or_else(PoisonError::into_inner);
        match &*stopped {
            Some((then, tree)) if *then == time => Some(Arc::clone(tree)),
            _ => {
                let tree = Arc::new(match &self.tree {
                    Tree::Object(tree) => Tree::Object(tree.at(time)),
                    Tree::Scene(tree) => Tree::Scene(Arc::new(tree.at(time, Threads::Single))),
                });
                *stopped = Some((time, Arc::clone(&tree)));
                Some(tree)
            }
        }
    }

    /// A geometry by its id.
    pub(crate) fn geometry(&self, id: u32) -> Option<&Arc<Geometry>> {
        let all = &self.geometries;
        // Ids without gaps are indices.
        let instance_matrix = match all.get(id as usize) {
            Some((first, _)) if *first == id => id as usize,
            _ => all.binary_search_by_key(&id, |(id, _)| *id).ok()?,
        };
        Some(&all[instance_matrix].1)
    }
}

impl Drop for Committed {
    fn drop(&mut self) {
        // The return value and exceptions of the program's function are ignored here.
        let _ = self.device.report_memory(-self.bytes);
    }
}

/// Trees of a scene without instances, and with them.
#[derive(Debug)]
pub(crate) enum Tree {
    Object(Arc<ObjectTree>),
    Scene(Arc<SceneTree>),
}

/// Runs an expression for either kind of tree, which have methods of the same names.
macro_rules! run_query {
    ($committed:expr, $tree:ident => $answer:expr) => {
        $crate::objects::run_tree!(&$committed.tree, $tree => $answer)
    };
}
pub(crate) use run_query;

/// The same for a tree.
macro_rules! run_tree {
    ($either:expr, $tree:ident => $answer:expr) => {
        match $either {
            $crate::objects::Tree::Object($tree) => $answer,
            $crate::objects::Tree::Scene($tree) => $answer,
        }
    };
}
pub(crate) use run_tree;

/// Arrays of one time step.
#[derive(Clone, Debug)]
pub(crate) struct StepArrays {
    /// Vertices, or centres and radii.
    pub(crate) vertices: View,
    /// By vertex, where curves and discs have them.
    pub(crate) normals: View,
    pub(crate) tangents: View,
    pub(crate) normal_tangents: View,
}

impl StepArrays {
    pub(crate) fn empty() -> Self {
        let [vertices, normals, tangents, normal_tangents] = [(); 4].map(|()| View::empty());
        Self { vertices, normals, tangents, normal_tangents }
    }
}

/// A subdivision surface before it is cut.
#[derive(Debug)]
pub(crate) struct Uncut {
    /// The number of the geometry's last edit.
    pub(crate) edit: u64,
    pub(crate) control: Arc<Control>,
    /// By half edge, or empty.
    pub(crate) levels: View,
    /// The level of edges without one.
    pub(crate) rate: f32,
    pub(crate) displacement: DisplacementFunction,
}

/// A geometry of a committed scene that has its own primitives.
#[derive(Debug)]
pub(crate) struct Surface {
    pub(crate) geom_id: u32,
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) kind: Kind,
    /// Of grids: these.
    pub(crate) indices: View,
    /// Where the tree has several quads of one primitive.
    pub(crate) cells: Option<Cells>,
    /// At the first time step.
    pub(crate) first: StepArrays,
    /// At the others.
    pub(crate) later: Vec<StepArrays>,
    /// The times of the first step and of the last.
    pub(crate) times: [f32; 2],
    /// Of each bent ribbon that faces rays.
    pub(crate) pieces: u8,
    /// By curve.
    pub(crate) joints: View,
    pub(crate) filters: Filters,
    pub(crate) point: PointFunction,
    /// The primitives of user geometry, once they are known.
    pub(crate) user: Option<Arc<dyn UserGeometry>>,
}

impl Surface {
    /// Whether there are several time steps.
    pub(crate) fn moves(&self) -> bool {
        self.step_count() > 1
    }

    /// How many time steps there are.
    pub(crate) fn step_count(&self) -> usize {
        self.user.as_ref().map_or(1 + self.later.len(), |user| user.keys() as usize)
    }

    /// The vertices of a quad of the tree.
    #[inline]
    pub(crate) fn quad(&self, number: u32) -> Option<[u32; 4]> {
        match &self.cells {
            Some(Cells::Grids(before)) => {
                let (_, grid, [column, row]) = cells::find(before, &self.indices, number)?;
                Some(grid.quad(column, row))
            }
            _ => self.indices.get(number as usize),
        }
    }

    /// The program's primitive and the parameters there, from those of the tree.
    #[inline]
    pub(crate) fn seen(&self, number: u32, [u, v]: [f32; 2]) -> (u32, [f32; 2]) {
        match &self.cells {
            None => (number, [u, v]),
            Some(cells) => cells.seen(&self.indices, number, [u, v]),
        }
    }

    /// The arrays of all time steps.
    pub(crate) fn steps(&self) -> impl Iterator<Item = &StepArrays> {
        std::iter::once(&self.first).chain(&self.later)
    }

    /// A row of an array at a time.
    #[inline]
    pub(crate) fn row<const N: usize>(
        &self,
        of: impl Fn(&StepArrays) -> &View,
        i: usize,
        time: f32,
    ) -> Option<[f32; N]> {
        if self.later.is_empty() {
            return of(&self.first).get(i);
        }
        let [from, to] = self.times;
        let share = if to > from { (time - from) / (to - from) } else { 0.0 };
        let interval = KeyInterval::of(share, self.later.len() + 1);
        let at = |key: usize| {
            let step = if key == 0 { &self.first } else { self.later.get(key - 1)? };
            of(step).get::<f32, N>(i)
        };
        let (from, to) = (at(interval.key)?, at(interval.next)?);
        Some(std::array::from_fn(|k| interval.mix(from[k], to[k])))
    }
}

/// A scene that is shown in another.
#[derive(Debug)]
pub(crate) struct Shown {
    /// As it was when the other one was committed.
    pub(crate) committed: Arc<Committed>,
    /// As it is now: its program may have committed it since, and freed the arrays of before.
    pub(crate) scene: Arc<Scene>,
}

/// Where a scene is shown in another.
#[derive(Debug)]
pub(crate) struct ShownInstance {
    pub(crate) geom_id: u32,
    /// In an array of instances.
    pub(crate) prim_id: Option<u32>,
    /// `None` for the scene's own surfaces.
    pub(crate) shown: Option<Shown>,
    /// At the first time step.
    pub(crate) world_from_instance: Columns,
    /// Where it has several.
    pub(crate) motion: Option<Arc<MotionPath>>,
}

impl ShownInstance {
    /// Where it is at a time.
    #[inline]
    pub(crate) fn at(&self, time: f32) -> Columns {
        self.motion.as_ref().map_or(self.world_from_instance, |motion| motion.at(time))
    }
}
