// SPDX-License-Identifier: GPL-3.0-or-later
//! What `RTCGeometry`, `RTCScene` and `RTCBuffer` point to. In one file, since scenes hold geometries and geometries show
//! scenes. Source: original; Embree's manual. Invariant: queries read [`Committed`] alone, which never changes; edits wait in the
//! mutexes for the next commit. Proof: `tests/c/embree.c`.

use std::collections::BTreeMap;
use std::ffi::c_void;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use gnurt_accel::{MovingTree, ObjectTree, Query, SceneTree};

use crate::device::Device;
use crate::ffi_abi::{BoundsFunction, FilterFunction, PointFunction, UserFunction};
use crate::ffi_callbacks::{Callback, ProgressFunction};
use crate::ffi_memory::{Block, Pointer, View};
use crate::transform::{Columns, IDENTITY};

/// What a geometry consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Triangles,
    Quads,
    Spheres,
    Lines,
    User,
    Instance,
    Instances,
}

/// What `RTCBuffer` points to.
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
    /// Whether those of a query's arguments are asked, too.
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

/// What calls edit.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// By type and slot.
    pub(crate) arrays: BTreeMap<(u32, u32), Array>,
    pub(crate) mask: u32,
    pub(crate) quality: u32,
    pub(crate) is_enabled: bool,
    pub(crate) is_committed: bool,
    pub(crate) filters: Filters,
    pub(crate) user: UserFunctions,
    pub(crate) user_count: u32,
    pub(crate) point: PointFunction,
    pub(crate) scenes: Vec<Arc<Scene>>,
    pub(crate) place: Columns,
    pub(crate) attributes: u32,
}

/// What `RTCGeometry` points to.
#[derive(Debug)]
pub(crate) struct Geometry {
    pub(crate) device: Arc<Device>,
    pub(crate) kind: Kind,
    pub(crate) user_data: AtomicPtr<c_void>,
    settings: Mutex<Settings>,
}

impl Geometry {
    pub(crate) fn new(device: Arc<Device>, kind: Kind) -> Self {
        let settings = Settings {
            arrays: BTreeMap::new(),
            mask: 1,
            quality: 1,
            is_enabled: true,
            is_committed: false,
            filters: Filters::default(),
            user: UserFunctions::default(),
            user_count: 0,
            point: None,
            scenes: Vec::new(),
            place: IDENTITY,
            attributes: 0,
        };
        let user_data = AtomicPtr::new(std::ptr::null_mut());
        Self { device, kind, user_data, settings: Mutex::new(settings) }
    }

    pub(crate) fn settings(&self) -> MutexGuard<'_, Settings> {
        self.settings.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn user_data(&self) -> *mut c_void {
        self.user_data.load(Ordering::Relaxed)
    }
}

/// What `RTCScene` points to.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) device: Arc<Device>,
    draft: Mutex<Draft>,
    /// Held by the draft; null before the first commit.
    current: AtomicPtr<Committed>,
}

/// A surface of a tree: its id, its kind, and how many primitives it has.
pub(crate) type Listed = (u32, Kind, u32);

/// What calls edit, and what the last commit left.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub(crate) geometries: BTreeMap<u32, Arc<Geometry>>,
    pub(crate) quality: u32,
    pub(crate) flags: u32,
    pub(crate) progress: Option<Callback<ProgressFunction>>,
    pub(crate) moving: Option<(MovingTree, Vec<Listed>)>,
    committed: Option<Arc<Committed>>,
    /// Queries that were under way when the scene was committed anew, against all rules, still read it.
    before: Option<Arc<Committed>>,
}

impl Scene {
    pub(crate) fn new(device: Arc<Device>) -> Self {
        let draft = Mutex::new(Draft { quality: 1, ..Draft::default() });
        Self { device, draft, current: AtomicPtr::default() }
    }

    pub(crate) fn draft(&self) -> MutexGuard<'_, Draft> {
        self.draft.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is asked from now on.
    pub(crate) fn publish(&self, draft: &mut Draft, committed: Committed) {
        let committed = Arc::new(committed);
        self.current.store(Arc::as_ptr(&committed).cast_mut(), Ordering::Release);
        draft.before = draft.committed.replace(committed);
    }

    /// What the last commit made, to be kept.
    pub(crate) fn committed(&self) -> Option<Arc<Committed>> {
        self.draft().committed.clone()
    }

    /// The same to be read at once: null before the first commit, else it lives as long as the scene is not committed twice.
    #[inline]
    pub(crate) fn current(&self) -> *const Committed {
        self.current.load(Ordering::Acquire)
    }
}

/// A scene that can be asked.
#[derive(Debug)]
pub(crate) struct Committed {
    pub(crate) device: Arc<Device>,
    pub(crate) tree: Tree,
    /// By the numbers that the tree has for them.
    pub(crate) surfaces: Vec<Surface>,
    /// Likewise; the first one is where the scene's own surfaces are.
    pub(crate) places: Vec<Place>,
    pub(crate) query: Query,
    /// Whether nobody is to be asked about hits.
    pub(crate) is_plain: bool,
    /// As the memory monitor was told.
    pub(crate) bytes: i64,
}

impl Drop for Committed {
    fn drop(&mut self) {
        self.device.hold(-self.bytes);
    }
}

/// Trees of a scene without instances, and with them.
#[derive(Debug)]
pub(crate) enum Tree {
    Object(Arc<ObjectTree>),
    Scene(Arc<SceneTree>),
}

/// Runs an expression for either kind of tree, which have methods of the same names.
macro_rules! ask {
    ($committed:expr, $tree:ident => $answer:expr) => {
        match &$committed.tree {
            $crate::objects::Tree::Object($tree) => $answer,
            $crate::objects::Tree::Scene($tree) => $answer,
        }
    };
}
pub(crate) use ask;

/// A geometry of a committed scene that has primitives of its own.
#[derive(Debug)]
pub(crate) struct Surface {
    pub(crate) geom_id: u32,
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) kind: Kind,
    /// Vertices, or centres and radii.
    pub(crate) vertices: View,
    pub(crate) indices: View,
    pub(crate) filters: Filters,
    pub(crate) point: PointFunction,
}

/// Where a scene is shown in another.
#[derive(Debug)]
pub(crate) struct Place {
    pub(crate) geom_id: u32,
    /// In an array of instances.
    pub(crate) prim_id: Option<u32>,
    /// `None` for the scene's own surfaces.
    pub(crate) shown: Option<Arc<Committed>>,
    pub(crate) world_from_instance: Columns,
}
