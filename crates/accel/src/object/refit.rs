// SPDX-License-Identifier: GPL-3.0-or-later
//! An object that has moved: its trees fitted to where its primitives are now. Source: [WBS06] section 4. Space: object.
//! Tests: `tests/refit.rs`.

use std::sync::OnceLock;

use gnurt_accel_bvh::Inputs;
use gnurt_accel_core::geometry::Numbering;
use gnurt_accel_core::surfaces::Surfaces;

use super::build::both;
use super::kind::{Group, Kind, group_of};
use super::{Index, ObjectTree};
use crate::{Aabb, BadPrimitives, Geometry, RefitError, Threads, TreeStats, Triangles};

impl ObjectTree {
    /// Fits the tree to meshes that have moved: other positions, the same numbers of meshes and triangles.
    /// Takes a small part of the time of a build, and gives the same hits; rays are slower the farther former
    /// neighbours have moved apart (see [`cost_growth`](Self::cost_growth)). It reuses the memory of the
    /// tree, which is why it takes it: keep a clone of one that is still queried.
    ///
    /// # Errors
    /// [`RefitError`] where it has to be built again: for other geometry, where triangles can be traced that could not, and
    /// for kd-trees, grids and trees over meshes with several keys.
    ///
    /// ```
    /// use gnurt_accel::{BuildOptions, ObjectTree, Ray, Threads, Triangles};
    ///
    /// let mut positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    /// let mesh = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
    /// let tree = ObjectTree::build(&[mesh], &BuildOptions::default(), Threads::Single);
    /// positions.iter_mut().for_each(|p| p[2] += 0.5);
    /// let mesh = Triangles { positions: &positions, indices: &[[0, 1, 2]] };
    /// let tree = tree.refit(&[mesh], Threads::Single)?;
    /// let hit = tree.intersect(&Ray::new([0.25, 0.5, 1.0], [0.0, 0.0, -1.0])).expect("it is nearer now");
    /// assert_eq!(hit.t, 0.5);
    /// # Ok::<(), gnurt_accel::RefitError>(())
    /// ```
    pub fn refit(self, meshes: &[Triangles], threads: Threads) -> Result<Self, RefitError> {
        let geometries: Vec<Geometry> = meshes.iter().map(|&mesh| mesh.into()).collect();
        self.refit_from(&geometries, threads)
    }

    /// The same for geometries of any kinds: quads with other positions, spheres with other centres and radii, user
    /// geometry with other boxes. Trees over spheres and over user geometry are only refitted if nothing was
    /// dropped from them, and a quad's half that becomes flat needs a build.
    ///
    /// # Errors
    /// As [`refit`](Self::refit).
    pub fn refit_from(mut self, geometries: &[Geometry], threads: Threads) -> Result<Self, RefitError> {
        let numbering = Numbering::new(geometries);
        let groups: Vec<Group> = geometries.iter().map(group_of).collect();
        if numbering != self.numbering || !self.are_groups(&groups) {
            return Err(RefitError::OtherGeometry);
        }
        let mut bad = BadPrimitives { too_many: numbering.too_many, ..BadPrimitives::default() };
        for &group in groups.iter().filter(|&&group| !self.parts.iter().any(|part| part.group() == group)) {
            check_empty(geometries, &numbering, group, &mut bad)?;
        }
        let mut stats = TreeStats::default();
        let mut same_slots = true;
        for part in &mut self.parts {
            let group = part.group();
            let in_group = |geometry: &Geometry| group_of(geometry) == group;
            let mut primitives = None;
            match &mut part.index {
                Index::Moving(_) | Index::MovingUser(_) => return Err(RefitError::Structure),
                Index::Research(index) => {
                    index.refit(&Surfaces::new(geometries, &numbering, in_group), threads)?
                }
                Index::Bvh(index) => {
                    let refitted = index.refit(&Surfaces::new(geometries, &numbering, in_group), threads)?;
                    bad += refitted.bad;
                    same_slots &= refitted.same_slots;
                    primitives = Some(refitted.primitives);
                }
                Index::Blocks(index) => {
                    index.refit(&Inputs { geometries, numbering: &numbering, accept: &in_group }, threads)?
                }
            }
            let measured = part.index.stats();
            let primitives = primitives.unwrap_or(measured.primitives);
            stats = both(stats, TreeStats { primitives, ..measured });
        }
        self.bounds = self.parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.index.bounds()));
        (self.bad, self.stats) = (bad, stats);
        if !same_slots {
            self.locations = OnceLock::new();
        }
        Ok(self)
    }

    /// Whether its structure supports refits.
    pub(crate) fn knows_refits(&self) -> bool {
        self.parts.iter().all(|part| match &part.index {
            Index::Research(index) => index.knows_refits(),
            Index::Moving(_) | Index::MovingUser(_) => false,
            Index::Bvh(_) | Index::Blocks(_) => true,
        })
    }

    /// The expected cost of a ray, relative to that at the build of the trees over triangles: 1 for trees
    /// without a refit, and more for worse boxes.
    #[must_use]
    pub fn cost_growth(&self) -> f64 {
        let growth = |part: &super::Part| match &part.index {
            Index::Bvh(index) => index.decline(),
            Index::Research(index) => index.decline(),
            _ => 1.0,
        };
        self.parts.iter().map(growth).fold(1.0, f64::max)
    }

    /// Whether the trees match the groups of these geometries. Missing data of a loaded tree is filled in.
    pub(super) fn are_groups(&self, groups: &[Group]) -> bool {
        groups.len() == self.groups.len()
            && groups.iter().zip(&self.groups).all(|(now, then)| then.is_none_or(|then| then == *now))
    }
}

/// Whether there is still nothing that a tree would be built for.
fn check_empty(
    geometries: &[Geometry],
    numbering: &Numbering,
    group: Group,
    bad: &mut BadPrimitives,
) -> Result<(), RefitError> {
    let surfaces = Surfaces::new(geometries, numbering, |geometry| group_of(geometry) == group);
    let others = (0..geometries.len()).filter(|&i| group_of(&geometries[i]) == group);
    let is_empty = match group.0 {
        Kind::Surfaces => !surfaces.numbers().flatten().any(|number| surfaces.judge(number, bad)),
        Kind::Moving(_) | Kind::MovingUser(_) | Kind::Blocks(_) => {
            others.map(|i| numbering.range(i).len()).sum::<usize>() == 0
        }
    };
    if is_empty { Ok(()) } else { Err(RefitError::OtherPrimitives) }
}
