// SPDX-License-Identifier: GPL-3.0-or-later
//! Ray queries: rays, hits, trees over objects and scenes of instances. Independent of shading, materials,
//! files or pixels.
//! Source: see each file; the outline is \[SIP06\], sections 4 (kd-tree) and 6 (two levels).
//!
//! Build an [`ObjectTree`] over geometry, place it in a [`SceneTree`] any number of times, and query it.
//! docs/reference/queries.md compares the calls with Embree's.
//!
//! ```
//! use std::sync::Arc;
//! use gnurt_accel::{BuildOptions, Instance, ObjectTree, Ray, SceneTree, Threads, Triangles};
//!
//! let mesh = Triangles { positions: &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], indices: &[[0, 1, 2]] };
//! let object = Arc::new(ObjectTree::build(&[mesh], &BuildOptions::default(), Threads::Single));
//! let scene = SceneTree::build(&[Instance::identity(object)], &BuildOptions::default(), Threads::Single);
//! let hit = scene.intersect(&Ray::new([0.25, 0.5, 1.0], [0.0, 0.0, -2.0])).expect("it aims at the triangle");
//! assert_eq!((hit.t, hit.u, hit.v, hit.prim_id), (0.5, 0.25, 0.5, 0));
//! ```
//!
//! # Kinds of geometry
//!
//! Triangles, quads, spheres, discs, curves and implementations of [`UserGeometry`], mixed in one object:
//!
//! ```
//! # use gnurt_accel::*;
//! let quad = Quads {
//!     positions: &[[-9., -1., -9.], [9., -1., -9.], [9., -1., 9.], [-9., -1., 9.]],
//!     indices: &[[0, 1, 2, 3]],
//! };
//! let balls = Spheres { centers: &[[0.0; 3], [3.0, 0.0, 0.0]], radii: &[1.0, 0.5] };
//! let object = ObjectTree::build_from(&[quad.into(), balls.into()], &BuildOptions::default(), Threads::Single);
//! let hit = object.intersect(&Ray::new([3.0, 2.0, 0.0], [0.0, -1.0, 0.0])).expect("a ball is above the quad");
//! assert_eq!((hit.t, hit.geom_id, hit.prim_id), (1.5, 1, 1));
//! ```
//!
//! Curves have a radius at each vertex, a basis and a form; a hit has `u` along and `v` across:
//!
//! ```
//! # use gnurt_accel::*;
//! let vertices = [[0., 0., 0., 0.2], [1., 0., 0., 0.2], [2., 0., 0., 0.2], [3., 0., 0., 0.1]];
//! let hair = Curves::new(CurveBasis::Bezier, CurveForm::Flat, &vertices, &[0]);
//! let object = ObjectTree::build_from(&[hair.into()], &BuildOptions::default(), Threads::Single);
//! let hit = object.intersect(&Ray::new([1.5, 0.0, 4.0], [0.0, 0.0, -1.0])).expect("it aims at the middle");
//! assert_eq!((hit.t, hit.u, hit.v), (4.0, 0.5, 0.0));
//! assert_eq!(object.closest_point([1.5, 2.0, 0.0], 9.0).map(|hit| hit.distance), Some(2.0));
//! ```
//!
//! # Any hit, all hits, some hits
//!
//! ```
//! # use gnurt_accel::*;
//! # let balls = Spheres { centers: &[[0.0; 3], [3.0, 0.0, 0.0]], radii: &[1.0, 0.5] };
//! # let tree = ObjectTree::build_from(&[balls.into()], &BuildOptions::default(), Threads::Single);
//! let (query, ray) = (Query::default(), Ray::new([-2.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
//! assert!(tree.occluded(&ray) && !tree.occluded(&ray.within(0.0, 0.9)));
//!
//! let mut hits = Vec::new();
//! tree.all_hits(&query, &ray, &mut hits); // in order, each once; first_hits stops at n
//! assert_eq!(hits.iter().map(|hit| hit.t).collect::<Vec<_>>(), [1.0, 3.0, 4.5, 5.5]);
//!
//! let leaving = tree.intersect_filtered(&query, &ray, |ray, hit| ray.at(hit.t)[0] > 0.0);
//! assert_eq!(leaving.map(|hit| hit.t), Some(3.0));
//! let other = tree.intersect_ignoring(&query, &ray, hits[0].primitive());
//! assert_eq!(other.map(|hit| hit.t), Some(4.5));
//! ```
//!
//! # Masks
//!
//! A ray sees an instance, and a geometry in it, if its mask and theirs have a bit in common:
//!
//! ```
//! # use gnurt_accel::*;
//! # use std::sync::Arc;
//! # let balls = Spheres { centers: &[[0.0; 3]], radii: &[1.0] };
//! # let ball = Arc::new(ObjectTree::build_from(&[balls.into()], &BuildOptions::default(), Threads::Single));
//! let ball = Instance::identity(ball).with_mask(0b01);
//! let scene = SceneTree::build(&[ball], &BuildOptions::default(), Threads::Single);
//! let ray = Ray::new([-2.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
//! assert!(scene.occluded(&ray.with_mask(0b11)) && !scene.occluded(&ray.with_mask(0b10)));
//! let query = Query { mask: 0b10, ..Query::default() }; // for all rays of a call or a batch
//! assert!(!scene.occluded_with(&query, &ray));
//! ```
//!
//! # Batches
//!
//! Many rays at once are faster, camera and shadow rays by far; the answers are the same, bit for bit:
//!
//! ```
//! # use gnurt_accel::*;
//! # let balls = Spheres { centers: &[[0.0; 3]], radii: &[1.0] };
//! # let tree = ObjectTree::build_from(&[balls.into()], &BuildOptions::default(), Threads::Single);
//! let rays: RayBatch = (0..100).map(|i| Ray::new([0.05 * i as f32, 0.0, 3.0], [0.0, 0.0, -1.0])).collect();
//! let query = Query { coherence: Coherence::Coherent, ..Query::default() };
//! let (mut hits, mut record) = (HitBatch::default(), Record::default());
//! tree.intersect_batch(&query, &rays, &mut hits, &mut record);
//! assert!((0..100).all(|i| hits.get(i) == tree.intersect(&rays.get(i))));
//! ```
//!
//! # Scenes in scenes, and far away
//!
//! Instances show objects or scenes, nested up to [`DEEPEST_SCENE`] levels. Their transforms are in double
//! precision, and a [`Ray64`] has its origin in it, too:
//!
//! ```
//! # use gnurt_accel::*;
//! # use std::sync::Arc;
//! # let balls = Spheres { centers: &[[0.0; 3]], radii: &[1.0] };
//! # let ball = Arc::new(ObjectTree::build_from(&[balls.into()], &BuildOptions::default(), Threads::Single));
//! let at = |x: f64| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 0.0]];
//! let (options, threads) = (BuildOptions::default(), Threads::Single);
//! let balls = [Instance::new(ball.clone(), at(0.0)), Instance::new(ball, at(4.125))];
//! let pair = Arc::new(SceneTree::build(&balls, &options, threads));
//! let scene = SceneTree::try_build(&[Instance::new(pair, at(1e7))], &options, threads, &())?;
//! let hit = scene.intersect(&Ray64::new([1e7 + 9.0, 0.0, 0.0], [-1.0, 0.0, 0.0])).expect("the second ball");
//! assert_eq!((hit.t, scene.instance_path(hit.leaf_id)), (3.875, Some(vec![0, 1])));
//! # Ok::<(), SceneError>(())
//! ```
//!
//! # Nearest points
//!
//! ```
//! # use gnurt_accel::*;
//! # let balls = Spheres { centers: &[[0.0; 3], [5.0, 0.0, 0.0]], radii: &[1.0, 1.0] };
//! # let tree = ObjectTree::build_from(&[balls.into()], &BuildOptions::default(), Threads::Single);
//! let near = tree.closest_point([0.0, 3.0, 0.0], f64::INFINITY).expect("everything is near enough");
//! assert_eq!((near.distance, near.point, near.prim_id), (2.0, [0.0, 1.0, 0.0], 0));
//! assert_eq!(tree.closest_point([0.0, 3.0, 0.0], 1.9), None); // nothing within that radius
//! ```
//!
//! # Moving geometry
//!
//! A tree whose triangles have moved is refitted in a fraction of a build's time ([`ObjectTree::refit`]); [`MovingTree`] does so from
//! frame to frame, and builds again when that pays:
//!
//! ```
//! # use gnurt_accel::*;
//! # use std::sync::Arc;
//! let options = BuildOptions::default();
//! let mut positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
//! fn mesh(positions: &[[f32; 3]]) -> [Geometry<'_>; 1] {
//!     [Triangles { positions, indices: &[[0, 1, 2]] }.into()]
//! }
//! let mut moving = MovingTree::build(&mesh(&positions), &options, Motion::Auto, Threads::Single);
//! let before = Arc::clone(moving.tree());
//! positions.iter_mut().for_each(|p| p[2] = 0.5);
//! assert_eq!(moving.update(&mesh(&positions), &options, Threads::Single), Update::Refitted);
//! let t = |tree: &ObjectTree| tree.intersect(&Ray::new([0.25, 0.5, 1.0], [0.0, 0.0, -1.0])).map(|hit| hit.t);
//! assert_eq!((t(moving.tree()), t(&before)), (Some(0.5), Some(1.0)));
//! ```
//!
//! # An open shutter
//!
//! A ray has a time from 0 to 1, at which it sees moving meshes ([`MovingTriangles`]) and moving instances
//! ([`Instance::moving`]); hits are those of a tree over all geometry at that time:
//!
//! ```
//! # use gnurt_accel::*;
//! # use std::sync::Arc;
//! let (options, threads) = (BuildOptions::default(), Threads::Single);
//! let keys: [&[[f32; 3]]; 2] = [&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], &[[0., 0., 4.], [1., 0., 4.], [0., 1., 4.]]];
//! let mesh = MovingTriangles { keys: &keys, indices: &[[0, 1, 2]] };
//! let object = Arc::new(ObjectTree::build_from(&[mesh.into()], &options, threads));
//! let ray = Ray::new([0.25, 0.25, 9.0], [0.0, 0.0, -1.0]);
//! let t = |tree: &ObjectTree, time: f32| tree.intersect(&ray.with_time(time)).map(|hit| hit.t);
//! assert_eq!((t(&object, 0.0), t(&object, 0.5), t(&object, 1.0)), (Some(9.0), Some(7.0), Some(5.0)));
//!
//! let at = |x: f64| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, 0.0, 0.0]];
//! let path = MotionPath::new(&[at(0.0), at(8.0)]).expect("two locations");
//! let scene = SceneTree::build(&[Instance::moving(object, Arc::new(path))], &options, threads);
//! let surface = scene.intersect(&Ray::new([4.25, 0.25, 9.0], [0.0, 0.0, -1.0]).with_time(0.5));
//! assert_eq!(surface.map(|hit| hit.t), Some(7.0));
//! ```
//!
//! # Crowds
//!
//! Many characters of one kind, each in its own pose, share the structure of one tree: [`ObjectTree::posed`],
//! or [`Crowd`], which also detects equal poses. docs/explanation/moving.md gives the savings.
//!
//! ```
//! # use gnurt_accel::*;
//! let crowd = Crowd::default();
//! let pose = |bend: f32| {
//!     let positions = [[0., 0., 0.], [1., 0., bend], [0., 1., 0.]];
//!     let mesh = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
//!     crowd.pose(&[mesh.into()], &BuildOptions::default(), Threads::Single)
//! };
//! let (upright, bent) = (pose(0.0), pose(0.5));
//! assert!(std::sync::Arc::ptr_eq(&pose(0.5), &bent), "a pose that is there already");
//! let hit = |tree: &ObjectTree| tree.intersect(&Ray::new([0.5, 0.25, 1.0], [0.0, 0.0, -1.0])).map(|hit| hit.t);
//! assert_eq!((hit(&upright), hit(&bent)), (Some(1.0), Some(0.75)));
//! ```
//!
//! # Limits today
//!
//! Queries without a time (nearest points,
//! boxes, balls, insides, normals of single hits) refer to time 0: [`ObjectTree::at`] and [`SceneTree::at`]
//! give a static copy at another one. No subdivision. An object has at most [`MOST_TRIANGLES`]
//! triangles.
#![forbid(unsafe_code)]

mod answers;
mod batch;
mod batch_run;
mod candidates;
mod coherent;
mod crossings;
mod crowd;
pub mod doubles;
mod engine;
mod facing;
mod inside;
mod lists;
mod many;
mod moving;
mod near;
mod object;
mod overlaps;
mod packet;
mod pencil;
mod queries;
mod query;
mod research;
mod scene;
mod shown;
mod slices;
mod sorted;
mod surfaces;
mod target;

pub use crowd::Crowd;
pub use facing::Face;
pub use gnurt_accel_core::threads;
pub use gnurt_accel_core::{
    Aabb, AnyRay, BadPrimitives, BuildControl, BuildError, BuildOptions, Coherence, Counters, CurveBasis,
    CurveForm, Curves, Discs, Geometry, GeometryKind, Grid, Grids, Hit, HitBatch, INVALID_ID, KeyInterval,
    LARGEST_COORDINATE, LoadError, MOST_TRIANGLES, Memory, MovingQuads, MovingTriangles, PointHit,
    PrimitiveId, Quads, Quality, Query, Ray, Ray64, RayBatch, Record, RefitError, SharedList, Spheres,
    Structure, Threads, TreeStats, TriangleTest, Triangles, UserGeometry, UserHit,
};
#[cfg(feature = "research")]
pub use gnurt_accel_kd::{FuzzyError, FuzzyTree};
pub use gnurt_simd::Level;
pub use inside::Side;
pub use lists::Lists;
pub use moving::{Motion, MovingTree, Update};
pub use object::ObjectTree;
pub use packet::Packet;
pub use pencil::Pencil;
pub use scene::{DEEPEST_SCENE, Instance, MotionPath, SceneError, SceneTree, Shape};
pub use slices::{Column, Floats, HitSlices, RaySlices, SliceError, Vectors};

/// The examples of docs/reference/queries.md.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/reference/queries.md")]
mod queries_page {}
