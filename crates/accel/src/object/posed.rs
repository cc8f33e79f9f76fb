// SPDX-License-Identifier: GPL-3.0-or-later
//! One object in several poses, whose trees share their structure. The shared part is in the `pose` module of
//! `gnurt-accel-bvh`. Space: object. Tests: `tests/poses.rs`.

use gnurt_accel_core::geometry::Numbering;
use gnurt_accel_core::surfaces::Surfaces;

use super::kind::{Group, group_of};
use super::{Index, ObjectTree, Part};
use crate::{Geometry, RefitError, Threads, Triangles};

impl ObjectTree {
    /// A tree over the same meshes in another pose: other positions, the same triangles. It shares with this
    /// one, and with all its other poses, everything that a pose leaves unchanged, and owns 64 bytes for each
    /// node and 12 for each vertex: a sixth of a separate tree, or less. It takes the time of a refit, and
    /// gives the hits of a new tree; rays are some 30 % slower, as in [compact](crate::Memory::Compact)
    /// trees, and slower the more poses differ (see [`cost_growth`](Self::cost_growth)). A pose can be
    /// refitted like any tree.
    ///
    /// The first call on a built tree extracts the shared part.
    ///
    /// # Errors
    /// [`RefitError`] if it needs a build: for meshes with other triangles, for another set of untraceable
    /// triangles, and for structures other than BVHs.
    ///
    /// ```
    /// use gnurt_accel::{BuildOptions, ObjectTree, Ray, Threads, Triangles};
    ///
    /// let mut positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    /// let mesh = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
    /// let upright = ObjectTree::build(&[mesh], &BuildOptions::default(), Threads::Single);
    /// positions[1][2] = 0.5;
    /// let mesh = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
    /// let bent = upright.posed(&[mesh], Threads::Single)?;
    /// let hit = bent.intersect(&Ray::new([0.5, 0.25, 1.0], [0.0, 0.0, -1.0])).expect("it aims at the triangle");
    /// assert_eq!(hit.t, 0.75);
    /// # Ok::<(), gnurt_accel::RefitError>(())
    /// ```
    pub fn posed(&self, meshes: &[Triangles], threads: Threads) -> Result<Self, RefitError> {
        let geometries: Vec<Geometry> = meshes.iter().map(|&mesh| mesh.into()).collect();
        self.posed_from(&geometries, threads)
    }

    /// The same for geometries of any kinds. Trees over spheres and over user geometry are copied.
    ///
    /// # Errors
    /// As [`posed`](Self::posed).
    pub fn posed_from(&self, geometries: &[Geometry], threads: Threads) -> Result<Self, RefitError> {
        let numbering = Numbering::new(geometries);
        let groups: Vec<Group> = geometries.iter().map(group_of).collect();
        if numbering != self.numbering || !self.are_groups(&groups) {
            return Err(RefitError::OtherGeometry);
        }
        let part = |part: &Part| {
            let group = part.group();
            let index = match &part.index {
                Index::Research(_) => return Err(RefitError::Structure),
                Index::Bvh(index) => {
                    let surfaces = Surfaces::new(geometries, &numbering, |other| group_of(other) == group);
                    Index::Bvh(index.without_pose(&surfaces)?)
                }
                other => other.clone(),
            };
            Ok(Part { mask: part.mask, times: part.times, index })
        };
        let parts = self.parts.iter().map(part).collect::<Result<_, _>>()?;
        let (groups, bad, bounds, stats) = (self.groups.clone(), self.bad, self.bounds, self.stats);
        let empty = Self { parts, groups, numbering, bad, bounds, stats, locations: Default::default() };
        empty.refit_from(geometries, threads)
    }

    /// Whether it is one of several poses that share their structure.
    #[must_use]
    pub fn is_posed(&self) -> bool {
        self.parts.iter().any(|part| matches!(&part.index, Index::Bvh(index) if index.is_posed()))
    }

    /// Bytes shared with other poses: [`stats`](Self::stats) excludes them and counts only the pose's own. 0
    /// if it is no pose.
    #[must_use]
    pub fn shared_bytes(&self) -> u64 {
        let shared = |part: &Part| match &part.index {
            Index::Bvh(index) => index.shared_bytes(),
            _ => 0,
        };
        self.parts.iter().map(shared).sum()
    }

    /// Whether it is a pose of these geometries, with vertices just there. Not found out where there are primitives other
    /// than triangles and quads, or some that cannot be traced.
    pub(crate) fn is_pose_of(&self, geometries: &[Geometry]) -> bool {
        let numbering = Numbering::new(geometries);
        let groups: Vec<Group> = geometries.iter().map(group_of).collect();
        let is_here = |part: &Part| {
            let group = part.group();
            let surfaces = Surfaces::new(geometries, &numbering, |other| group_of(other) == group);
            matches!(&part.index, Index::Bvh(index) if index.is_pose_of(&surfaces))
        };
        self.bad.total() == 0
            && numbering == self.numbering
            && self.are_groups(&groups)
            && self.parts.iter().all(is_here)
    }
}
