// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene of `gnurt/rays.h`: its parts, and trees over them. See include/gnurt/rays.h.
//! Invariant: ids are indices of the list of parts, and stay. A committed scene needs no array of the
//! program: parts keep copies, from which later commits build. Tests: `tests/c/rays.c`, `tests/c/edits.c`.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use gnurt_accel::doubles::{DoubleInstance, DoubleMesh, DoubleScene};
use gnurt_accel::{
    BuildOptions, CurveBasis, CurveForm, Curves, Discs, Geometry, GeometryKind, Grid, Grids, Instance,
    Motion, MovingTree, ObjectTree, Quads, SceneTree, Shape, Spheres, Threads, Triangles, UserGeometry,
};

use crate::ffi_columns::{Column, Rows};

/// An affine map: images of the axes, then of the origin.
pub(crate) type Columns = [[f64; 3]; 4];

pub(crate) const IDENTITY: Columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// The kind and data of a part.
#[derive(Clone, Debug)]
pub(crate) enum What {
    /// Positions are kept in one of both precisions.
    Triangles {
        positions: Column<[f32; 3]>,
        doubles: Column<[f64; 3]>,
        indices: Column<[u32; 3]>,
    },
    Quads {
        positions: Column<[f32; 3]>,
        indices: Column<[u32; 4]>,
    },
    Grids {
        positions: Column<[f32; 3]>,
        grids: Vec<Grid>,
    },
    Spheres {
        centers: Column<[f32; 3]>,
        radii: Column<f32>,
    },
    Discs {
        centers: Column<[f32; 3]>,
        radii: Column<f32>,
        /// None of discs that face rays.
        normals: Option<Column<[f32; 3]>>,
    },
    Curves(Box<CurveArrays>),
    User(Primitives),
    Instance {
        shown: Arc<Built>,
        instance_matrix: Columns,
    },
}

impl What {
    /// Copies arrays of the program that were not copied yet.
    fn keep(&mut self, is_double: bool) {
        match self {
            Self::Triangles { positions, doubles, indices } => {
                positions.keep(|rows| if is_double { Vec::new() } else { rows.floats() });
                doubles.keep(|rows| if is_double { rows.doubles() } else { Vec::new() });
                indices.keep(Rows::u32_rows);
            }
            Self::Quads { positions, indices } => {
                positions.keep(Rows::floats);
                indices.keep(Rows::u32_rows);
            }
            Self::Grids { positions, .. } => positions.keep(Rows::floats),
            Self::Spheres { centers, radii } => {
                centers.keep(Rows::floats);
                radii.keep(|rows| rows.floats::<1>().into_iter().map(|[r]| r).collect());
            }
            Self::Discs { centers, radii, normals } => {
                centers.keep(Rows::floats);
                radii.keep(|rows| rows.floats::<1>().into_iter().map(|[r]| r).collect());
                normals.iter_mut().for_each(|normals| normals.keep(Rows::floats));
            }
            Self::Curves(curves) => {
                let CurveArrays { vertices, segments, tangents, normals, normal_tangents, .. } =
                    &mut **curves;
                vertices.keep(Rows::floats);
                segments.keep(|rows| rows.u32_rows::<1>().into_iter().map(|[first]| first).collect());
                tangents.keep(Rows::floats);
                normals.keep(Rows::floats);
                normal_tangents.keep(Rows::floats);
            }
            Self::User(_) | Self::Instance { .. } => {}
        }
    }

    /// As trees are built from it, and how many primitives there are; nothing of an instance.
    fn geometry(&self) -> Option<(GeometryKind<'_>, usize)> {
        Some(match self {
            Self::Triangles { positions, indices, .. } => {
                let (positions, indices) = (positions.retained(), indices.retained());
                (GeometryKind::Triangles(Triangles { positions, indices }), indices.len())
            }
            Self::Quads { positions, indices } => {
                let (positions, indices) = (positions.retained(), indices.retained());
                (GeometryKind::Quads(Quads { positions, indices }), indices.len())
            }
            Self::Grids { positions, grids } => {
                let made = Grids { positions: positions.retained(), grids };
                (GeometryKind::Grids(made), made.cells())
            }
            Self::Spheres { centers, radii } => {
                let (centers, radii) = (centers.retained(), radii.retained());
                (GeometryKind::Spheres(Spheres { centers, radii }), radii.len())
            }
            Self::Discs { centers, radii, normals } => {
                let (centers, radii) = (centers.retained(), radii.retained());
                let normals = normals.as_ref().map(Column::retained);
                (GeometryKind::Discs(Discs { centers, radii, normals }), radii.len())
            }
            Self::Curves(curves) => {
                let made = Curves {
                    tangents: curves.tangents.retained(),
                    normals: curves.normals.retained(),
                    normal_tangents: curves.normal_tangents.retained(),
                    ..Curves::new(
                        curves.basis,
                        curves.form,
                        curves.vertices.retained(),
                        curves.segments.retained(),
                    )
                };
                (GeometryKind::Curves(made), made.indices.len())
            }
            Self::User(user) => {
                let geometry = Arc::clone(&user.geometry);
                let count = geometry.count() as usize;
                (GeometryKind::User(geometry), count)
            }
            Self::Instance { .. } => return None,
        })
    }
}

/// Curves with a width, as `gnurt_accel::Curves`.
#[derive(Clone, Debug)]
pub(crate) struct CurveArrays {
    pub(crate) basis: CurveBasis,
    pub(crate) form: CurveForm,
    pub(crate) vertices: Column<[f32; 4]>,
    pub(crate) segments: Column<u32>,
    pub(crate) tangents: Column<[f32; 4]>,
    pub(crate) normals: Column<[f32; 3]>,
    pub(crate) normal_tangents: Column<[f32; 3]>,
}

/// Primitives of the program, and how often its test has thrown an exception.
#[derive(Clone, Debug)]
pub(crate) struct Primitives {
    pub(crate) geometry: Arc<dyn UserGeometry>,
    pub(crate) thrown: Arc<AtomicU64>,
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
macro_rules! query_tree {
    ($built:expr, $tree:ident => $answer:expr) => {
        match &$built.tree {
            $crate::ray_scene::Tree::Object($tree) => $answer,
            $crate::ray_scene::Tree::Scene($tree) => $answer,
        }
    };
}
pub(crate) use query_tree;

/// A scene for queries.
#[derive(Debug)]
pub(crate) struct Built {
    pub(crate) tree: Tree,
    /// Of a scene in double precision, whose tree is empty.
    pub(crate) doubles: Option<Arc<DoubleScene>>,
    pub(crate) object: Arc<ObjectTree>,
    /// Ids of parts by the tree's numbers of geometries.
    geometries: Vec<u32>,
    /// Ids of parts by the tree's numbers of instances, and their contents; the first are the scene's own
    /// surfaces.
    instances: Vec<(u32, Option<Arc<Built>>)>,
    /// Of all user geometry that rays may meet.
    thrown: Vec<Arc<AtomicU64>>,
}

impl Built {
    /// How many exceptions tests of the program have thrown, in all queries of all times.
    pub(crate) fn thrown(&self) -> u64 {
        self.thrown.iter().map(|thrown| thrown.load(Ordering::Relaxed)).sum()
    }

    /// The ids of a geometry, in the scene that has it, and of the outermost instance.
    pub(crate) fn ids(&self, geom_id: u32, inst_id: u32, leaf_id: u32) -> (u32, u32) {
        if let Some(doubles) = &self.doubles {
            let (path, scene) = self.double_path(doubles, leaf_id);
            return (scene.geometries[geom_id as usize], path.first().copied().unwrap_or(u32::MAX));
        }
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

    /// The ids of the instances on the way to a leaf in double precision, and the scene there.
    fn double_path(&self, doubles: &DoubleScene, leaf_id: u32) -> (Vec<u32>, &Self) {
        let (mut scene, mut path) = (self, Vec::new());
        for at in doubles.path(leaf_id) {
            let Some((id, Some(inner))) = scene.instances.get(at as usize + 1) else { break };
            path.push(*id);
            scene = inner;
        }
        (path, scene)
    }

    /// The ids of the instances along the path to the hit, outermost first, each in its own scene.
    pub(crate) fn path(&self, leaf_id: u32) -> Vec<u32> {
        if let Some(doubles) = &self.doubles {
            return self.double_path(doubles, leaf_id).0;
        }
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

/// The target of `gnurt_scene`.
#[derive(Debug, Default)]
pub(crate) struct RayScene {
    parts: Vec<Option<Part>>,
    options: BuildOptions,
    moves: bool,
    /// Whether positions, instances and answers are in double precision.
    is_double: bool,
    /// 0 for all processors.
    pub(crate) threads: usize,
    pub(crate) built: Option<Arc<Built>>,
    /// Whether the scene's own surfaces, or how trees are built, were edited since.
    is_edited: bool,
    /// And its geometry: ids, and their numbers of primitives.
    moving: Option<(MovingTree, Vec<(u32, usize)>)>,
}

impl RayScene {
    /// # Errors
    /// That the scene is of another precision.
    pub(crate) fn add(&mut self, part: Part) -> Result<u32, String> {
        self.fits(&part.what)?;
        self.is_edited |= !matches!(part.what, What::Instance { .. });
        self.parts.push(Some(part));
        Ok(self.parts.len() as u32 - 1)
    }

    /// Whether a part is of the scene's precision.
    pub(crate) fn fits(&self, what: &What) -> Result<(), String> {
        match what {
            What::Triangles { .. } => Ok(()),
            What::Instance { shown, .. } if shown.doubles.is_some() != self.is_double => {
                Err("shown: one scene is in double precision, and the other is not".into())
            }
            What::Instance { .. } => Ok(()),
            _ if self.is_double => Err("scene: in double precision it takes triangles and instances".into()),
            _ => Ok(()),
        }
    }

    /// A part that is there, to be edited.
    pub(crate) fn part(&mut self, id: u32) -> Result<&mut Part, String> {
        let part = self.parts.get_mut(id as usize).and_then(Option::as_mut);
        let part = part.ok_or_else(|| format!("id: geometry or instance {id} does not exist"))?;
        self.is_edited |= !matches!(part.what, What::Instance { .. });
        Ok(part)
    }

    /// Takes a part out.
    pub(crate) fn remove(&mut self, id: u32) -> Result<(), String> {
        self.part(id)?;
        self.parts[id as usize] = None;
        Ok(())
    }

    /// How trees are built, whether they are to follow, and the precision.
    pub(crate) fn set_options(
        &mut self,
        options: BuildOptions,
        moves: bool,
        is_double: bool,
    ) -> Result<(), String> {
        if is_double != self.is_double && !self.parts.is_empty() {
            return Err("doubles: the scene has geometries or instances; set it before".into());
        }
        (self.options, self.moves, self.is_double, self.is_edited) = (options, moves, is_double, true);
        Ok(())
    }

    /// Builds. Arrays of the program are not read again afterwards.
    pub(crate) fn commit(&mut self, threads: Threads) -> Result<(), String> {
        let is_double = self.is_double;
        self.parts.iter_mut().flatten().for_each(|part| part.what.keep(is_double));
        if is_double {
            return self.commit_doubles(threads);
        }
        let (mut geometries, mut thrown) = (Vec::new(), Vec::new());
        let mut instances = vec![(u32::MAX, None)];
        let mut placed_instances = Vec::new();
        for (id, part) in self.parts.iter().enumerate() {
            let Some(Part { what, mask }) = part else { continue };
            match what {
                What::Instance { shown, instance_matrix } => {
                    let shape: Shape = match &shown.tree {
                        Tree::Object(tree) => Arc::clone(tree).into(),
                        Tree::Scene(tree) => Arc::clone(tree).into(),
                    };
                    placed_instances.push(Instance::new(shape, *instance_matrix).with_mask(*mask));
                    thrown.extend(shown.thrown.iter().cloned());
                    instances.push((id as u32, Some(Arc::clone(shown))));
                    continue;
                }
                What::User(user) => thrown.push(Arc::clone(&user.thrown)),
                _ => {}
            }
            geometries.push(id as u32);
        }
        thrown.sort_unstable_by_key(|thrown| Arc::as_ptr(thrown).addr());
        thrown.dedup_by(|a, b| Arc::ptr_eq(a, b));
        let object = match &self.built {
            Some(built) if !self.is_edited => Arc::clone(&built.object),
            _ => self.object(threads)?,
        };
        let tree = if placed_instances.is_empty() {
            Tree::Object(Arc::clone(&object))
        } else {
            placed_instances.insert(0, Instance::new(Arc::clone(&object), IDENTITY));
            let built = SceneTree::try_build(&placed_instances, &self.options, threads, &());
            Tree::Scene(Arc::new(built.map_err(|error| error.to_string())?))
        };
        self.built = Some(Arc::new(Built { tree, doubles: None, object, geometries, instances, thrown }));
        self.is_edited = false;
        Ok(())
    }

    /// The same in double precision, built again.
    fn commit_doubles(&mut self, threads: Threads) -> Result<(), String> {
        let (mut geometries, mut meshes) = (Vec::new(), Vec::new());
        let (mut instances, mut placed) = (vec![(u32::MAX, None)], Vec::new());
        for (id, part) in self.parts.iter().enumerate() {
            let Some(Part { what, mask }) = part else { continue };
            match what {
                What::Triangles { doubles, indices, .. } => {
                    let (positions, indices) = (doubles.retained(), indices.retained());
                    meshes.push(DoubleMesh { positions, indices, mask: *mask });
                    geometries.push(id as u32);
                }
                What::Instance { shown, instance_matrix } => {
                    let Some(doubles) = &shown.doubles else { continue };
                    let (shown, placement) = (Arc::clone(shown), *instance_matrix);
                    placed.push(DoubleInstance { shown: Arc::clone(doubles), placement, mask: *mask });
                    instances.push((id as u32, Some(shown)));
                }
                _ => {}
            }
        }
        let scene = DoubleScene::build(&meshes, &placed, &self.options, threads);
        let doubles = Some(Arc::new(scene.map_err(|error| error.to_string())?));
        let object = Arc::new(ObjectTree::build(&[], &self.options, Threads::Single));
        let tree = Tree::Object(Arc::clone(&object));
        self.built =
            Some(Arc::new(Built { tree, doubles, object, geometries, instances, thrown: Vec::new() }));
        self.is_edited = false;
        Ok(())
    }

    /// The tree over the scene's own surfaces.
    fn object(&mut self, threads: Threads) -> Result<Arc<ObjectTree>, String> {
        let mut counts = Vec::new();
        let mut geometries = Vec::new();
        for (id, part) in self.parts.iter().enumerate() {
            let Some(Part { what, mask }) = part else { continue };
            let Some((kind, count)) = what.geometry() else { continue };
            geometries.push(Geometry::new(kind).with_mask(*mask));
            counts.push((id as u32, count));
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
