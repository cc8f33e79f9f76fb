// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene of `gnurt/rays.h`: what was added, and trees over it. Source: original; include/gnurt/rays.h.
//! Invariant: ids are places in the list of parts, and stay. Proof: `tests/c/rays.c`.

use std::sync::Arc;

use gnurt_accel::{
    BuildOptions, Geometry, GeometryKind, Instance, Motion, MovingTree, ObjectTree, Quads, SceneTree, Shape,
    Spheres, Threads, Triangles, UserGeometry,
};

use crate::ffi_columns::Rows;
use crate::transform::{Columns, IDENTITY};

/// What was added.
#[derive(Clone, Debug)]
pub(crate) enum What {
    Triangles { positions: Rows, indices: Rows },
    Quads { positions: Rows, indices: Rows },
    Spheres { centers: Rows, radii: Rows },
    User(Arc<dyn UserGeometry>),
    Instance { shown: Arc<Built>, place: Columns },
}

/// With its mask.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) what: What,
    pub(crate) mask: u32,
}

/// Trees of a scene without instances, and with them.
#[derive(Debug)]
pub(crate) enum Tree {
    Object(Arc<ObjectTree>),
    Scene(Arc<SceneTree>),
}

/// Runs an expression for either kind of tree, which have methods of the same names.
macro_rules! ask_tree {
    ($built:expr, $tree:ident => $answer:expr) => {
        match &$built.tree {
            $crate::ray_scene::Tree::Object($tree) => $answer,
            $crate::ray_scene::Tree::Scene($tree) => $answer,
        }
    };
}
pub(crate) use ask_tree;

/// A scene that can be asked.
#[derive(Debug)]
pub(crate) struct Built {
    pub(crate) tree: Tree,
    pub(crate) object: Arc<ObjectTree>,
    /// Ids of parts by the tree's numbers of geometries.
    geometries: Vec<u32>,
    /// Ids of parts by the tree's numbers of instances, and what they show; the first are the scene's own surfaces.
    instances: Vec<(u32, Option<Arc<Built>>)>,
}

impl Built {
    /// The ids of a geometry, in the scene that has it, and of the outermost instance.
    pub(crate) fn ids(&self, geom_id: u32, inst_id: u32, leaf_id: u32) -> (u32, u32) {
        let Tree::Scene(tree) = &self.tree else { return (self.geometries[geom_id as usize], u32::MAX) };
        let (id, shown) = &self.instances[inst_id as usize];
        let Some(shown) = shown else { return (self.geometries[geom_id as usize], u32::MAX) };
        let mut scene = shown;
        for inst_id in tree.instance_path(leaf_id).unwrap_or_default().into_iter().skip(1) {
            let Some((_, Some(inner))) = scene.instances.get(inst_id as usize) else { break };
            scene = inner;
        }
        (scene.geometries[geom_id as usize], *id)
    }

    /// The ids of the instances on the way to what was hit, outermost first, each in the scene that has it.
    pub(crate) fn path(&self, leaf_id: u32) -> Vec<u32> {
        let Tree::Scene(tree) = &self.tree else { return Vec::new() };
        let (mut scene, mut path) = (self, Vec::new());
        for inst_id in tree.instance_path(leaf_id).unwrap_or_default() {
            // A scene's own surfaces are no instance of it.
            let Some((id, Some(inner))) = scene.instances.get(inst_id as usize) else { break };
            path.push(*id);
            scene = inner;
        }
        path
    }
}

/// What `gnurt_scene` points to.
#[derive(Debug, Default)]
pub(crate) struct RayScene {
    pub(crate) parts: Vec<Option<Part>>,
    pub(crate) options: BuildOptions,
    pub(crate) moves: bool,
    /// 0 for all processors.
    pub(crate) threads: usize,
    pub(crate) built: Option<Arc<Built>>,
    /// And what it was over: ids, and how many primitives they have.
    moving: Option<(MovingTree, Vec<(u32, usize)>)>,
}

/// Arrays in the form that trees are built from.
enum Arrays {
    Triangles(Vec<[f32; 3]>, Vec<[u32; 3]>),
    Quads(Vec<[f32; 3]>, Vec<[u32; 4]>),
    Spheres(Vec<[f32; 3]>, Vec<f32>),
    User(Arc<dyn UserGeometry>),
}

impl RayScene {
    pub(crate) fn add(&mut self, part: Part) -> u32 {
        self.parts.push(Some(part));
        self.parts.len() as u32 - 1
    }

    /// A part that is there.
    pub(crate) fn part(&mut self, id: u32) -> Result<&mut Part, String> {
        let part = self.parts.get_mut(id as usize).and_then(Option::as_mut);
        part.ok_or_else(|| format!("id: there is no geometry or instance {id}"))
    }

    /// Builds.
    pub(crate) fn commit(&mut self, threads: Threads) -> Result<(), String> {
        let (mut arrays, mut geometries) = (Vec::new(), Vec::new());
        let mut instances = vec![(u32::MAX, None)];
        let mut placed = Vec::new();
        for (id, part) in self.parts.iter().enumerate() {
            let Some(Part { what, mask }) = part else { continue };
            let array = match what {
                What::Triangles { positions, indices } => {
                    Arrays::Triangles(positions.floats(), indices.words()?)
                }
                What::Quads { positions, indices } => Arrays::Quads(positions.floats(), indices.words()?),
                What::Spheres { centers, radii } => {
                    Arrays::Spheres(centers.floats(), radii.floats::<1>().into_iter().map(|[r]| r).collect())
                }
                What::User(user) => Arrays::User(Arc::clone(user)),
                What::Instance { shown, place } => {
                    let shape: Shape = match &shown.tree {
                        Tree::Object(tree) => Arc::clone(tree).into(),
                        Tree::Scene(tree) => Arc::clone(tree).into(),
                    };
                    placed.push(Instance::new(shape, *place).with_mask(*mask));
                    instances.push((id as u32, Some(Arc::clone(shown))));
                    continue;
                }
            };
            arrays.push((array, *mask));
            geometries.push(id as u32);
        }
        let object = self.object(&arrays, &geometries, threads)?;
        let tree = if placed.is_empty() {
            Tree::Object(Arc::clone(&object))
        } else {
            placed.insert(0, Instance::new(Arc::clone(&object), IDENTITY));
            let built = SceneTree::try_build(&placed, &self.options, threads, &());
            Tree::Scene(Arc::new(built.map_err(|error| error.to_string())?))
        };
        self.built = Some(Arc::new(Built { tree, object, geometries, instances }));
        Ok(())
    }

    /// The tree over the scene's own surfaces.
    fn object(
        &mut self,
        arrays: &[(Arrays, u32)],
        ids: &[u32],
        threads: Threads,
    ) -> Result<Arc<ObjectTree>, String> {
        let mut counts = Vec::new();
        let mut geometries = Vec::new();
        for ((array, mask), &id) in arrays.iter().zip(ids) {
            let (kind, count) = match array {
                Arrays::Triangles(positions, indices) => {
                    (GeometryKind::Triangles(Triangles { positions, indices }), indices.len())
                }
                Arrays::Quads(positions, indices) => {
                    (GeometryKind::Quads(Quads { positions, indices }), indices.len())
                }
                Arrays::Spheres(centers, radii) => {
                    (GeometryKind::Spheres(Spheres { centers, radii }), radii.len())
                }
                Arrays::User(user) => (GeometryKind::User(Arc::clone(user)), user.count() as usize),
            };
            geometries.push(Geometry::new(kind).with_mask(*mask));
            counts.push((id, count));
        }
        if self.moves
            && let Some((moving, before)) = &mut self.moving
            && *before == counts
        {
            moving.update(&geometries, &self.options, threads);
            return Ok(Arc::clone(moving.tree()));
        }
        let built = ObjectTree::try_build_from(&geometries, &self.options, threads, &());
        let tree = Arc::new(built.map_err(|error| error.to_string())?);
        self.moving = self.moves.then(|| (MovingTree::of(Arc::clone(&tree), Motion::Auto), counts));
        Ok(tree)
    }
}
