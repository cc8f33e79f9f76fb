// SPDX-License-Identifier: GPL-3.0-or-later
//! A fuzzy kd-tree: parts, their trees, and the tree over them in the current pose. Space: that of the poses.
//! Invariant: hits are those of any tree over the same pose, bit for bit, because triangles are tested where they are; at the same
//! `t` the lowest number counts. Tests: `tests/fuzzy.rs` of `gnurt-accel`.

use std::fmt;

use gnurt_accel_core::float::most;
use gnurt_accel_core::geometry::LARGEST_COORDINATE;
use gnurt_accel_core::nearest::{AnyHit, Closest, Mode, Nearest};
use gnurt_accel_core::triangle::ShearedRay;
use gnurt_accel_core::{Aabb, Hit, Ray, TreeStats};

use super::boxes;
use super::parts::Poses;
use super::rigid::Rigid;
use crate::mailbox::Mailbox;
use crate::node::KdTree;
use crate::slab::RaySlabs;

/// Parts: rays enter most of those that they come near, because boxes of parts overlap.
const MOST_PARTS: usize = 16;

/// Triangles from which the motion of a part is taken.
const FITTED: usize = 256;

/// Boxes are wider than needed by this share of their longest side, so that poses between known ones stay in.
const ROOM: f32 = 0.1;

/// Why poses make no tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FuzzyError {
    /// None is given.
    NoPose,
    /// A pose has another number of vertices than the first, which is the rest.
    Vertices {
        /// Which one, counted from 0.
        pose: usize,
    },
    /// A coordinate is not finite, or greater than [`LARGEST_COORDINATE`].
    Coordinate {
        /// The vertex.
        vertex: usize,
    },
    /// A triangle has a vertex that is not there.
    Index {
        /// The triangle.
        triangle: usize,
    },
}

impl fmt::Display for FuzzyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPose => write!(f, "no pose: at least one is needed"),
            Self::Vertices { pose } => write!(f, "pose {pose}: another number of vertices than at rest"),
            Self::Coordinate { vertex } => {
                write!(f, "vertex {vertex}: coordinates are finite and at most {LARGEST_COORDINATE:e}")
            }
            Self::Index { triangle } => write!(f, "triangle {triangle}: an index is out of range"),
        }
    }
}

impl std::error::Error for FuzzyError {}

/// Triangles that move alike.
#[derive(Clone, Debug)]
struct Part {
    triangles: Vec<u32>,
    /// At rest, around each of them in all poses so far.
    boxes: Vec<Aabb>,
    /// Over these.
    tree: KdTree,
    /// From rest to the current pose.
    motion: Rigid,
    /// Around the triangles in the current pose.
    bounds: Aabb,
}

/// Triangles of one mesh that move among poses.
#[derive(Clone, Debug)]
pub struct FuzzyTree {
    rest: Vec<[f32; 3]>,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    parts: Vec<Part>,
    /// Over the parts in the current pose.
    top: KdTree,
}

impl FuzzyTree {
    /// Over triangles in poses, the first of which is their rest and the current one. By one thread.
    ///
    /// # Errors
    /// See [`FuzzyError`].
    pub fn build(poses: &[&[[f32; 3]]], triangles: &[[u32; 3]]) -> Result<Self, FuzzyError> {
        let Some(&rest) = poses.first() else { return Err(FuzzyError::NoPose) };
        for (pose, positions) in poses.iter().enumerate() {
            judge(positions, rest.len()).map_err(|fault| fault.of_pose(pose))?;
        }
        let is_bad = |row: &[u32; 3]| row.iter().any(|&corner| corner as usize >= rest.len());
        if let Some(triangle) = triangles.iter().position(is_bad) {
            return Err(FuzzyError::Index { triangle });
        }
        let lists = Poses { positions: poses, triangles }.parts(MOST_PARTS);
        let still = Rigid::fit(std::iter::empty());
        let part = |triangles: Vec<u32>| Part {
            boxes: vec![Aabb::EMPTY; triangles.len()],
            triangles,
            tree: boxes::over(std::iter::empty()),
            motion: still,
            bounds: Aabb::EMPTY,
        };
        let mut tree = Self {
            rest: rest.to_vec(),
            positions: rest.to_vec(),
            triangles: triangles.to_vec(),
            parts: lists.into_iter().map(part).collect(),
            top: boxes::over(std::iter::empty()),
        };
        for &positions in poses.iter().rev() {
            tree.positions.copy_from_slice(positions);
            for i in 0..tree.parts.len() {
                tree.pose(i);
            }
        }
        for part in &mut tree.parts {
            part.boxes.iter_mut().for_each(|around| *around = with_room(around));
            part.tree = boxes::over(part.boxes.iter().copied().zip(part.triangles.iter().copied()));
        }
        tree.join();
        Ok(tree)
    }

    /// Moves the triangles to another pose. Returns how many trees of parts were built again, because triangles have left their
    /// boxes: none in poses that were given to [`build`](Self::build). After an error the tree is as before.
    ///
    /// # Errors
    /// That there are other vertices, or coordinates that are not finite.
    pub fn update(&mut self, positions: &[[f32; 3]]) -> Result<usize, FuzzyError> {
        judge(positions, self.positions.len()).map_err(|fault| fault.of_pose(0))?;
        self.positions.copy_from_slice(positions);
        let mut rebuilt = 0;
        for i in 0..self.parts.len() {
            let grown = self.pose(i);
            if !grown.is_empty() {
                let part = &mut self.parts[i];
                grown.into_iter().for_each(|i| part.boxes[i] = with_room(&part.boxes[i]));
                part.tree = boxes::over(part.boxes.iter().copied().zip(part.triangles.iter().copied()));
                rebuilt += 1;
            }
        }
        self.join();
        Ok(rebuilt)
    }

    /// Takes a part's motion and bounds from the positions, and lets boxes grow that are too small. Returns which did.
    fn pose(&mut self, part: usize) -> Vec<usize> {
        let Self { rest, positions, triangles, parts, .. } = self;
        let Part { triangles: own, boxes, motion, bounds, .. } = &mut parts[part];
        let corners = |&number: &u32| triangles[number as usize].map(|corner| corner as usize);
        let fitted = own.iter().step_by(own.len().div_ceil(FITTED).max(1));
        *motion = Rigid::fit(fitted.flat_map(corners).map(|corner| [rest[corner], positions[corner]]));
        *bounds = Aabb::EMPTY;
        let mut grown = Vec::new();
        for (i, (number, around)) in own.iter().zip(boxes).enumerate() {
            let mut now = Aabb::EMPTY;
            for corner in corners(number) {
                let posed = positions[corner];
                *bounds = bounds.union(&Aabb { min: posed, max: posed });
                let at = motion.at_rest(posed).map(|x| x as f32);
                now = now.union(&Aabb { min: at.map(f32::next_down), max: at.map(f32::next_up) });
            }
            let is_in = (0..3).all(|k| around.min[k] <= now.min[k] && now.max[k] <= around.max[k]);
            if !is_in {
                *around = around.union(&now);
                grown.push(i);
            }
        }
        grown
    }

    fn join(&mut self) {
        self.top = boxes::over(self.parts.iter().map(|part| part.bounds).zip(0..));
    }

    /// How many parts there are.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Size of all trees; of the shape only leaves and nodes.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        let trees = || self.parts.iter().map(|part| &part.tree).chain([&self.top]);
        let nodes = || trees().flat_map(|tree| &tree.nodes);
        let of_parts = |part: &Part| size_of_val(&part.triangles[..]) + size_of_val(&part.boxes[..]);
        let vertices = size_of_val(&self.rest[..]) + size_of_val(&self.positions[..]);
        let listed = self.parts.iter().map(of_parts).sum::<usize>();
        TreeStats {
            primitives: self.triangles.len() as u64,
            nodes: nodes().count() as u64,
            leaves: nodes().filter(|node| node.is_leaf()).count() as u64,
            tree_bytes: trees().map(KdTree::memory_bytes).sum::<usize>() as u64,
            primitive_bytes: (vertices + listed + size_of_val(&self.triangles[..])) as u64,
            ..TreeStats::default()
        }
    }

    /// The closest hit; a direction of any length.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let (nearest, scale) = self.search::<Closest>(ray)?;
        let t = if scale == 1.0 { nearest.t } else { (f64::from(nearest.t) * scale) as f32 };
        let Nearest { u, v, number, .. } = nearest;
        Some(Hit { t, u, v, prim_id: number, geom_id: 0, inst_id: 0, leaf_id: 0 })
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.search::<AnyHit>(ray).is_some()
    }

    /// The best hit, and the factor of its parameter.
    fn search<M: Mode>(&self, ray: &Ray) -> Option<(Nearest, f64)> {
        if !ray.is_sound() || self.parts.is_empty() {
            return None;
        }
        let (ray, scale) = if ray.is_regular() { (*ray, 1.0) } else { ray.regular() };
        let mut nearest = Nearest::none(ray.t_far);
        let (mut entered, single) = (0u64, ShearedRay::new(&ray));
        let slabs = RaySlabs::new(&ray, &self.top.bounds, self.top.bounds.greatest());
        self.top.walk(&slabs, ray.t_near, ray.t_far, |leaf| {
            for &part in self.top.leaf_items(leaf) {
                if entered >> part & 1 == 0 && nearest.t > f32::NEG_INFINITY {
                    entered |= 1 << part;
                    self.search_part::<M>(&self.parts[part as usize], &ray, &single, &mut nearest);
                }
            }
            nearest.t
        });
        nearest.is_hit().then_some((nearest, scale))
    }

    #[inline]
    fn search_part<M: Mode>(&self, part: &Part, ray: &Ray, single: &ShearedRay, nearest: &mut Nearest) {
        let org = part.motion.at_rest(ray.org).map(|x| x as f32);
        let dir = part.motion.turn_back(ray.dir.map(f64::from)).map(|x| x as f32);
        let mut slabs =
            RaySlabs::new(&Ray { org, dir, ..*ray }, &part.tree.bounds, part.tree.bounds.greatest());
        // The test rounds along the axes of the pose: at rest that is a vector in any direction, up to the root of 3 as long
        // along one axis, and so is the distance. The ray is rounded, too.
        slabs.slack = slabs.slack.map(|slack| 4.0 * slack);
        let mut mailbox = Mailbox::<64>::EMPTY;
        part.tree.walk(&slabs, ray.t_near, nearest.t, |leaf| {
            for &number in part.tree.leaf_items(leaf) {
                if mailbox.has(number) {
                    continue;
                }
                let corners = self.triangles[number as usize].map(|corner| self.positions[corner as usize]);
                if let Some(hit) = single.meet(&corners, !M::ANY, ray.t_near, nearest.t) {
                    nearest.offer::<M>(hit, number, 0);
                    if M::ANY {
                        break;
                    }
                }
            }
            nearest.t
        });
    }
}

fn with_room(around: &Aabb) -> Aabb {
    let [x, y, z] = around.extent();
    let room = ROOM * most(most(x as f32, y as f32), z as f32);
    Aabb { min: around.min.map(|x| x - room), max: around.max.map(|x| x + room) }
}

/// The fault of a pose.
enum Fault {
    Count,
    Vertex(usize),
}

impl Fault {
    fn of_pose(self, pose: usize) -> FuzzyError {
        match self {
            Self::Count => FuzzyError::Vertices { pose },
            Self::Vertex(vertex) => FuzzyError::Coordinate { vertex },
        }
    }
}

fn judge(positions: &[[f32; 3]], count: usize) -> Result<(), Fault> {
    if positions.len() != count {
        return Err(Fault::Count);
    }
    // NaN is not in the range.
    let is_good = |at: &[f32; 3]| at.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
    positions.iter().position(|at| !is_good(at)).map_or(Ok(()), |vertex| Err(Fault::Vertex(vertex)))
}
