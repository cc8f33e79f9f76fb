// SPDX-License-Identifier: GPL-3.0-or-later
//! Builds an object's trees: one for each kind of primitive and mask. Space: object.
//! Tests: `tests/brute_force.rs`, `tests/mixed.rs`, `tests/control.rs`.

use std::sync::OnceLock;

use gnurt_accel_bvh::{BvhIndex, Inputs, MotionIndex, MovingUserIndex, Screen};
use gnurt_accel_core::control::Watch;
use gnurt_accel_core::geometry::Numbering;
use gnurt_accel_core::surfaces::Surfaces;

#[cfg(feature = "research")]
use gnurt_accel_core::valid_triangles::ValidTriangles;

use super::kind::{Group, Kind, group_of};
use super::{Index, ObjectTree, Part};
#[cfg(feature = "research")]
use crate::research::ResearchIndex;
use crate::{
    Aabb, BadPrimitives, BuildControl, BuildError, BuildOptions, Geometry, Structure, Threads, TreeStats,
    Triangles,
};

impl ObjectTree {
    /// Builds over triangle meshes. Triangles that cannot be traced are left out and counted; no triangle at all is
    /// fine.
    #[must_use]
    pub fn build(meshes: &[Triangles], options: &BuildOptions, threads: Threads) -> Self {
        let geometries: Vec<Geometry> = meshes.iter().map(|&mesh| mesh.into()).collect();
        Self::build_from(&geometries, options, threads)
    }

    /// The same under control: it may be cancelled, reports progress and memory, and stays within a budget.
    /// The tree does not depend on the control.
    ///
    /// # Errors
    /// `control` stopped it: see [`BuildError`]. Bad triangles are counted without an error.
    pub fn try_build(
        meshes: &[Triangles],
        options: &BuildOptions,
        threads: Threads,
        control: &dyn BuildControl,
    ) -> Result<Self, BuildError> {
        let geometries: Vec<Geometry> = meshes.iter().map(|&mesh| mesh.into()).collect();
        Self::try_build_from(&geometries, options, threads, control)
    }

    /// Builds over geometries of any kinds. Untraceable primitives are dropped and counted; an empty input is
    /// valid.
    ///
    /// Spheres, user geometry and moving meshes always get a BVH; `options.structure` is for static triangles
    /// and quads, and so is `options.memory`: trees with moving boxes are never compact.
    ///
    /// # Panics
    /// If there are too many primitives for one tree (some 900 million):
    /// [`try_build_from`](Self::try_build_from) returns that as an error.
    #[must_use]
    pub fn build_from(geometries: &[Geometry], options: &BuildOptions, threads: Threads) -> Self {
        Self::try_build_from(geometries, options, threads, &()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The same under control, as [`try_build`](Self::try_build). Trees of all but triangles and quads
    /// are built in one go, and their memory is not counted.
    ///
    /// # Errors
    /// That `control` stopped it, or that there are too many primitives: see [`BuildError`].
    pub fn try_build_from(
        geometries: &[Geometry],
        options: &BuildOptions,
        threads: Threads,
        control: &dyn BuildControl,
    ) -> Result<Self, BuildError> {
        let watch = Watch::new(control);
        let numbering = Numbering::new(geometries);
        let mut bad = BadPrimitives { too_many: numbering.too_many, ..BadPrimitives::default() };
        let mut groups: Vec<Group> = Vec::new();
        for group in geometries.iter().map(group_of) {
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        let mut parts = Vec::new();
        let mut stats = TreeStats::default();
        for (kind, mask, times) in groups {
            let in_group = |geometry: &Geometry| group_of(geometry) == (kind, mask, times);
            let (quality, memory) = (options.quality, options.memory);
            let mut triangles = None;
            watch.result()?;
            let index = match kind {
                Kind::Surfaces => {
                    let group_numbers = (0..geometries.len()).filter(|&i| in_group(&geometries[i]));
                    let numbers: usize = group_numbers.map(|i| numbering.range(i).len()).sum();
                    match options.structure {
                        Structure::Bvh => {
                            let each = Screen::bytes_each(quality);
                            watch.take(each * numbers);
                            watch.result()?;
                            let surfaces = Surfaces::new(geometries, &numbering, in_group);
                            let mut screen = Screen::over(surfaces, quality, threads);
                            bad += screen.bad;
                            let count = screen.count();
                            triangles = Some(count as u64);
                            let retained = screen.retained_bytes();
                            watch.give(each * numbers - retained);
                            if count == 0 {
                                continue;
                            }
                            let index = BvhIndex::build(&mut screen, quality, memory, threads, &watch)?;
                            watch.give(retained);
                            Index::Bvh(index)
                        }
                        #[cfg(feature = "research")]
                        _ => {
                            let number = size_of::<u32>();
                            watch.take(number * numbers);
                            watch.result()?;
                            let valid = ValidTriangles::over(geometries, &numbering, in_group, threads);
                            bad += valid.bad;
                            triangles = Some(valid.good.len() as u64);
                            if valid.good.is_empty() {
                                continue;
                            }
                            let index = ResearchIndex::build(&valid, options, threads, &watch)?;
                            watch.give(number * numbers);
                            Index::Research(index)
                        }
                    }
                }
                Kind::Moving(0) => continue,
                Kind::Moving(keys) => {
                    let surfaces = |key| Surfaces::at_key(geometries, &numbering, in_group, key as usize);
                    let surfaces: Vec<Surfaces> = (0..keys).map(surfaces).collect();
                    match MotionIndex::build(&surfaces, &mut bad, quality, threads, &watch)? {
                        Some(index) => Index::Moving(index),
                        None => continue,
                    }
                }
                Kind::MovingUser(keys) => {
                    let inputs = Inputs { geometries, numbering: &numbering, accept: &in_group };
                    match MovingUserIndex::build(&inputs, keys, &mut bad, quality, threads, &watch)? {
                        Some(index) => Index::MovingUser(index),
                        None => continue,
                    }
                }
                Kind::Blocks(sort) => {
                    let inputs = Inputs { geometries, numbering: &numbering, accept: &in_group };
                    Index::Blocks(sort.build(&inputs, &mut bad, quality, memory, threads)?)
                }
            };
            if !index.bounds().is_empty() {
                let measured = index.stats();
                let primitives = triangles.unwrap_or(measured.primitives);
                stats = both(stats, TreeStats { primitives, ..measured });
                parts.push(Part { mask, times, index });
            }
        }
        let bounds = parts.iter().fold(Aabb::EMPTY, |all, part| all.union(&part.index.bounds()));
        watch.result()?;
        watch.finish();
        let groups = geometries.iter().map(|geometry| Some(group_of(geometry))).collect();
        Ok(Self { parts, groups, numbering, bad, bounds, stats, locations: OnceLock::new() })
    }
}

/// The sizes of two trees together.
pub(super) fn both(a: TreeStats, b: TreeStats) -> TreeStats {
    TreeStats {
        primitives: a.primitives + b.primitives,
        nodes: a.nodes + b.nodes,
        leaves: a.leaves + b.leaves,
        empty_leaves: a.empty_leaves + b.empty_leaves,
        references: a.references + b.references,
        depth: a.depth.max(b.depth),
        sah_cost: a.sah_cost + b.sah_cost,
        tree_bytes: a.tree_bytes + b.tree_bytes,
        primitive_bytes: a.primitive_bytes + b.primitive_bytes,
    }
}
