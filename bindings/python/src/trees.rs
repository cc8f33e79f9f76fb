// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees over the contents of a ray scene. Geometries form one object, with their transforms applied; instances
//! need a scene: object 0 is that of all geometries, the others follow. An instance shows a geometry, or all of
//! another scene. Trees of an earlier state are the start of new ones: unchanged
//! parts are shared, moved ones are refitted (`docs/explanation/moving.md`).
//! Invariant: returned ids are the caller's. Tests: `tests/test_scene.py`.

use std::collections::BTreeMap;
use std::sync::Arc;

use gnurt_accel::doubles::DoubleScene;
use gnurt_accel::{
    BuildOptions, Geometry, Hit, Instance, Motion, MovingTree, ObjectTree, PointHit, SceneTree, Shape,
    Threads,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::double_trees::{DoublePlan, Inner};
use crate::geometries::{Kind, StoredGeometry};
use crate::soups::Soup;

/// The trees for queries.
#[derive(Debug)]
pub(crate) struct Trees {
    /// Of all meshes, transformed.
    all: Part,
    /// Of meshes that instances show, as they are.
    shown: BTreeMap<u32, Part>,
    /// `None` without instances.
    scene: Option<Arc<SceneTree>>,
    /// Of a scene in double precision, which has no others.
    pub(crate) doubles: Option<Arc<DoubleScene>>,
    /// Instances of the scene after the first.
    placed_list: Vec<(u32, PlacedGeometry)>,
    pub(crate) kinds: Kinds,
}

/// What there is in a scene and in scenes that it shows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kinds {
    /// Something besides triangles, so that normals depend on more than the primitive.
    pub(crate) has_others: bool,
    pub(crate) has_curves: bool,
}

impl Kinds {
    fn of(meshes: &[Option<StoredGeometry>], placed_list: &[(u32, PlacedGeometry)]) -> Self {
        let mut kinds = Self::default();
        for geometry in meshes.iter().flatten() {
            kinds.has_others |= geometry.kind != Kind::Triangles;
            kinds.has_curves |= matches!(geometry.kind, Kind::Curves(..));
        }
        for (_, placed) in placed_list {
            if let Shows::Scene(trees) = &placed.shows {
                kinds.has_others |= trees.kinds.has_others;
                kinds.has_curves |= trees.kinds.has_curves;
            }
        }
        kinds
    }
}

/// The contents of an instance.
#[derive(Clone, Debug)]
pub(crate) enum Shows {
    /// A mesh once more.
    Mesh(u32),
    /// Another scene.
    Scene(Arc<Trees>),
}

/// The contents and the transform of an instance.
#[derive(Clone, Debug)]
pub(crate) struct PlacedGeometry {
    pub(crate) shows: Shows,
    pub(crate) placement: [[f64; 3]; 4],
}

/// A tree, and which states of meshes it is over: 0 for a removed one.
#[derive(Clone, Debug)]
struct Part {
    tree: MovingTree,
    states: Vec<u64>,
}

/// Either kind of tree.
pub(crate) enum Target<'a> {
    Object(&'a ObjectTree),
    Scene(&'a SceneTree),
}

/// Runs an expression for either kind of tree, which have methods of the same names.
macro_rules! run_query {
    ($trees:expr, $tree:ident => $answer:expr) => {
        match $trees.target() {
            $crate::trees::Target::Object($tree) => $answer,
            $crate::trees::Target::Scene($tree) => $answer,
        }
    };
}
pub(crate) use run_query;

/// Arrays of all that is to be built, taken out of Python.
pub(crate) struct Plan {
    before: Option<Arc<Trees>>,
    all: BuildRequest,
    shown: BTreeMap<u32, BuildRequest>,
    doubles: Option<DoublePlan>,
    placed_list: Vec<(u32, PlacedGeometry)>,
    kinds: Kinds,
}

/// Meshes that one tree is over.
struct BuildRequest {
    states: Vec<u64>,
    /// `None` if the tree before is over the same.
    soups: Option<Vec<Soup>>,
}

impl BuildRequest {
    fn new(
        states: Vec<u64>,
        before: Option<&Part>,
        soups: impl FnOnce() -> PyResult<Vec<Soup>>,
    ) -> PyResult<Self> {
        let is_same = before.is_some_and(|part| part.states == states);
        Ok(Self { states, soups: if is_same { None } else { Some(soups()?) } })
    }
}

impl Plan {
    /// Trees for these meshes and instances, from those of an earlier state if there are any.
    pub(crate) fn new(
        py: Python<'_>,
        meshes: &[Option<StoredGeometry>],
        placed_list: Vec<(u32, PlacedGeometry)>,
        before: Option<Arc<Trees>>,
        is_double: bool,
    ) -> PyResult<Self> {
        let kinds = Kinds::of(meshes, &placed_list);
        if is_double {
            let doubles =
                Some(DoublePlan::new(py, meshes, placed_list.iter().map(PlacedGeometry::double).collect())?);
            let all = BuildRequest { states: Vec::new(), soups: None };
            return Ok(Self { before: None, all, shown: BTreeMap::new(), doubles, placed_list, kinds });
        }
        // A removed geometry keeps its number.
        let at_place = |geometry: &Option<StoredGeometry>| {
            geometry.as_ref().map_or_else(|| Ok(Soup::empty()), |geometry| Soup::placed(py, geometry))
        };
        let states = meshes.iter().map(|mesh| mesh.as_ref().map_or(0, |mesh| mesh.state)).collect();
        let all = BuildRequest::new(states, before.as_ref().map(|trees| &trees.all), || {
            meshes.iter().map(at_place).collect()
        })?;
        let mut shown = BTreeMap::new();
        for (_, placed_list) in &placed_list {
            let Shows::Mesh(geom_id) = &placed_list.shows else { continue };
            let Some(Some(mesh)) = meshes.get(*geom_id as usize) else { continue };
            if !shown.contains_key(geom_id) {
                let before = before.as_ref().and_then(|trees| trees.shown.get(geom_id));
                let request = BuildRequest::new(vec![mesh.shape], before, || Ok(vec![Soup::new(py, mesh)?]))?;
                shown.insert(*geom_id, request);
            }
        }
        Ok(Self { before, all, shown, doubles: None, placed_list, kinds })
    }

    /// Builds; without the interpreter.
    pub(crate) fn build(self, threads: Threads) -> PyResult<Trees> {
        let Self { before, all, shown, doubles, placed_list, kinds } = self;
        let all = Part::new(all, before.as_ref().map(|trees| &trees.all), threads)?;
        let part = |(id, request): (u32, BuildRequest)| {
            let before = before.as_ref().and_then(|trees| trees.shown.get(&id));
            Ok((id, Part::new(request, before, threads)?))
        };
        let shown = shown.into_iter().map(part).collect::<PyResult<BTreeMap<u32, Part>>>()?;
        let doubles = doubles.map(|plan| plan.build(threads)).transpose()?;
        let mut trees = Trees { all, shown, scene: None, doubles, placed_list, kinds };
        if trees.doubles.is_none() && !trees.placed_list.is_empty() {
            trees.scene = Some(Arc::new(trees.top(before.as_deref(), threads)?));
        }
        Ok(trees)
    }
}

impl Part {
    fn new(request: BuildRequest, before: Option<&Self>, threads: Threads) -> PyResult<Self> {
        let BuildRequest { states, soups } = request;
        let soups = match (soups, before) {
            (None, Some(before)) => return Ok(before.clone()),
            (soups, _) => soups.unwrap_or_default(),
        };
        let options = BuildOptions::default();
        let geometries: Vec<Geometry> = soups.iter().map(Soup::geometry).collect();
        // Geometries under the same numbers have the same primitives: they can only have moved.
        let numbers = |states: &[u64]| states.iter().map(|state| *state != 0).collect::<Vec<bool>>();
        if let Some(before) = before.filter(|before| numbers(&before.states) == numbers(&states)) {
            let mut tree = before.tree.clone();
            tree.update(&geometries, &options, threads);
            return Ok(Self { tree, states });
        }
        let tree = ObjectTree::try_build_from(&geometries, &options, threads, &())
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok(Self { tree: MovingTree::of(Arc::new(tree), Motion::Auto), states })
    }
}

impl Trees {
    /// As `instance_path`, in double precision.
    fn double_path(
        &self,
        scene: &DoubleScene,
        geom_id: u32,
        leaf_id: u32,
        mut visit: impl FnMut(u32),
    ) -> u32 {
        let mut trees = self;
        for at in scene.path(leaf_id) {
            let Some((id, placed)) = trees.placed_list.get(at as usize) else { return u32::MAX };
            visit(*id);
            match &placed.shows {
                Shows::Mesh(geom_id) => return *geom_id,
                Shows::Scene(inner) => trees = inner,
            }
        }
        geom_id
    }
}

impl PlacedGeometry {
    /// For a scene in double precision.
    fn double((_, placed): &(u32, Self)) -> (Inner, [[f64; 3]; 4]) {
        let inner = match &placed.shows {
            Shows::Mesh(geom_id) => Inner::Mesh(*geom_id),
            Shows::Scene(trees) => Inner::Scene(trees.doubles.clone()),
        };
        (inner, placed.placement)
    }
}

impl Trees {
    /// The tree over all instances: that of an earlier state with the changes, if the number of instances is
    /// the same.
    fn top(&self, before: Option<&Self>, threads: Threads) -> PyResult<SceneTree> {
        let before = before.filter(|before| before.placed_list.len() == self.placed_list.len());
        if let Some((before, scene)) = before.and_then(|before| Some((before, before.scene.as_ref()?))) {
            let has_changed = |i: &usize| {
                !is_same(&self.shape(*i), &before.shape(*i))
                    || i.checked_sub(1)
                        .is_some_and(|i| self.placed_list[i].1.placement != before.placed_list[i].1.placement)
            };
            let changed: Vec<_> = (0..=self.placed_list.len())
                .filter(has_changed)
                .map(|i| (i as u32, Some(self.instance(i))))
                .collect();
            return Ok(scene.updated(self.placed_list.len() + 1, &changed, threads));
        }
        let instances: Vec<Instance> = (0..=self.placed_list.len()).map(|i| self.instance(i)).collect();
        SceneTree::try_build(&instances, &BuildOptions::default(), threads, &())
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The contents of the scene's instance `i`: the first shows all meshes.
    fn shape(&self, i: usize) -> Shape {
        let mesh = |part: &Part| part.tree.tree().clone().into();
        match i.checked_sub(1).map(|i| &self.placed_list[i].1.shows) {
            None => mesh(&self.all),
            Some(Shows::Mesh(geom_id)) => mesh(self.shown.get(geom_id).unwrap_or(&self.all)),
            Some(Shows::Scene(trees)) => match &trees.scene {
                Some(scene) => scene.clone().into(),
                None => mesh(&trees.all),
            },
        }
    }

    fn instance(&self, i: usize) -> Instance {
        let shape = self.shape(i);
        match i.checked_sub(1) {
            None => Instance::identity(shape),
            Some(i) => Instance::new(shape, self.placed_list[i].1.placement),
        }
    }

    /// Whether instances show scenes that have these trees: some instances' numbers, ascending, and those.
    pub(crate) fn show(&self, scenes: &[(u32, Arc<Self>)]) -> bool {
        let of = |(id, placed_list): &(u32, PlacedGeometry)| match &placed_list.shows {
            Shows::Mesh(_) => None,
            Shows::Scene(trees) => Some((*id, Arc::as_ptr(trees))),
        };
        self.placed_list.iter().filter_map(of).eq(scenes.iter().map(|(id, trees)| (*id, Arc::as_ptr(trees))))
    }

    pub(crate) fn target(&self) -> Target<'_> {
        match &self.scene {
            Some(scene) => Target::Scene(scene),
            None => Target::Object(self.all.tree.tree()),
        }
    }

    /// The geometry, or -1, of a result with these numbers; calls `visit` with the instances that contain it,
    /// outermost first.
    fn instance_path(&self, [geom_id, inst_id, leaf_id]: [u32; 3], mut visit: impl FnMut(u32)) -> u32 {
        if let Some(scene) = &self.doubles {
            return self.double_path(scene, geom_id, leaf_id, visit);
        }
        let (mut trees, mut inst_id, mut leaf) = (self, inst_id, leaf_id);
        loop {
            let Some(scene) = trees.scene.as_ref().filter(|_| inst_id != 0 && inst_id != u32::MAX) else {
                return geom_id;
            };
            let Some((id, placed_list)) = trees.placed_list.get(inst_id as usize - 1) else {
                return u32::MAX;
            };
            visit(*id);
            match &placed_list.shows {
                Shows::Mesh(geom_id) => return *geom_id,
                Shows::Scene(inner) => {
                    (trees, leaf) = (inner, leaf - scene.first_leaf(inst_id));
                    let found = inner.scene.as_ref().and_then(|scene| scene.instance_at(leaf));
                    inst_id = found.map_or(0, |(inst_id, _)| inst_id);
                }
            }
        }
    }

    /// Geometry and outermost instance, or -1, of an answer in which the trees gave these.
    pub(crate) fn ids(&self, ids: [u32; 3]) -> (u32, u32) {
        let mut outermost = u32::MAX;
        let geom_id = self.instance_path(ids, |id| {
            if outermost == u32::MAX {
                outermost = id;
            }
        });
        (geom_id, outermost)
    }

    /// Instances along the path to the hit, outermost first, then -1.
    pub(crate) fn path(&self, ids: [u32; 3], path: &mut [u32]) {
        path.fill(u32::MAX);
        let mut rest = path.iter_mut();
        self.instance_path(ids, |id| {
            if let Some(placement) = rest.next() {
                *placement = id;
            }
        });
    }

    /// The deepest nesting of instances, one at least; 16 at most.
    pub(crate) fn levels(&self) -> usize {
        if let Some(scene) = &self.doubles {
            return scene.levels().max(1) as usize;
        }
        self.scene.as_ref().map_or(1, |scene| scene.depth() as usize)
    }

    /// Unit normal of a triangle that was hit; zeros where there is none.
    pub(crate) fn normal(&self, [prim_id, geom_id, inst_id, leaf_id]: [u32; 4]) -> [f32; 3] {
        if prim_id == u32::MAX {
            return [0.0; 3];
        }
        let hit = Hit { t: 0.0, u: 0.0, v: 0.0, prim_id, geom_id, inst_id, leaf_id };
        run_query!(self, tree => tree.normal(&hit)).unwrap_or_default()
    }

    /// Unit normal at a nearest point; zeros where there is none.
    pub(crate) fn normal_at(&self, found: &PointHit) -> [f32; 3] {
        let PointHit { u, v, prim_id, geom_id, inst_id, leaf_id, .. } = *found;
        let hit = Hit { t: 0.0, u, v, prim_id, geom_id, inst_id, leaf_id };
        run_query!(self, tree => tree.normal_at(&hit, found.point)).unwrap_or_default()
    }
}

/// Whether two shapes are one.
fn is_same(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Object(a), Shape::Object(b)) => Arc::ptr_eq(a, b),
        (Shape::Scene(a), Shape::Scene(b)) => Arc::ptr_eq(a, b),
        _ => false,
    }
}
