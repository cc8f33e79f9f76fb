// SPDX-License-Identifier: GPL-3.0-or-later
//! Fitting trees over spheres and user geometry. Source: [WBS06] section 4. Space: object.
//! Invariant: a tree that left something out when it was built, or would now, is not refitted. Tests: `tests/refit.rs` of
//! `gnurt-accel`.

use std::sync::Arc;

use gnurt_accel_core::geometry::{GeometryKind, Numbering, geometry_of};
use gnurt_accel_core::{Aabb, BadPrimitives, Geometry, INVALID_ID, RefitError, Threads};
use rayon::prelude::*;

use crate::blocked::Blocked;
use crate::node::WIDTH;
use crate::spheres::{SphereBlock, SphereIndex, sphere_box};
use crate::user::UserIndex;

impl<B: Send> Blocked<B> {
    /// Fits blocks by `fit`, which answers with their boxes, then the nodes.
    fn refit(
        &mut self,
        threads: Threads,
        fit: impl Fn(&mut B) -> Result<Aabb, RefitError> + Send + Sync,
    ) -> Result<(), RefitError> {
        let Self { tree, blocks, .. } = self;
        let cost = threads.run(|parallel| {
            let boxes: Result<Vec<Aabb>, RefitError> = match parallel {
                true => blocks.par_iter_mut().with_min_len(64).map(fit).collect(),
                false => blocks.iter_mut().map(fit).collect(),
            };
            Ok(tree.refit(&boxes?, parallel, &mut Vec::new()))
        })?;
        self.refitted(cost);
        Ok(())
    }
}

/// Whether a tree over this many primitives holds all those of the accepted geometries.
fn holds_all(
    held: u64,
    geometries: &[Geometry],
    numbering: &Numbering,
    accept: impl Fn(&Geometry) -> bool,
) -> Result<(), RefitError> {
    let counts = geometries.iter().enumerate().filter(|(_, geometry)| accept(geometry));
    let count: usize = counts.map(|(i, _)| numbering.range(i).len()).sum();
    if count as u64 == held { Ok(()) } else { Err(RefitError::OtherPrimitives) }
}

impl SphereIndex {
    /// Fits the tree to spheres that have moved or have other radii.
    ///
    /// # Errors
    /// That it has to be built again. It is of no use then.
    pub fn refit(
        &mut self,
        geometries: &[Geometry],
        numbering: &Numbering,
        accept: impl Fn(&Geometry) -> bool,
        threads: Threads,
    ) -> Result<(), RefitError> {
        holds_all(self.stats().primitives, geometries, numbering, accept)?;
        let fit = |block: &mut SphereBlock| {
            let mut all = Aabb::EMPTY;
            for lane in (0..WIDTH).filter(|&lane| block.numbers[lane] != INVALID_ID) {
                let number = block.numbers[lane];
                let geometry = geometry_of(&numbering.starts, number);
                let within = (number - numbering.starts[geometry]) as usize;
                let GeometryKind::Spheres(spheres) = &geometries[geometry].kind else {
                    return Err(RefitError::OtherGeometry);
                };
                let (center, radius) = (spheres.centers[within], spheres.radii[within]);
                let coordinates = center.into_iter().chain([radius]);
                if BadPrimitives::default().fault(coordinates).is_some() || radius <= 0.0 {
                    return Err(RefitError::OtherPrimitives);
                }
                for (row, x) in block.center.iter_mut().zip(center) {
                    row[lane] = x;
                }
                block.radius[lane] = radius;
                all = all.union(&sphere_box(center, radius));
            }
            Ok(all)
        };
        self.0.refit(threads, fit)
    }
}

impl UserIndex {
    /// Fits the tree to user geometry with new boxes, or to others with the same number of primitives.
    ///
    /// # Errors
    /// That it has to be built again. It is of no use then.
    pub fn refit(
        &mut self,
        geometries: &[Geometry],
        numbering: &Numbering,
        accept: impl Fn(&Geometry) -> bool,
        threads: Threads,
    ) -> Result<(), RefitError> {
        holds_all(self.stats().primitives, geometries, numbering, &accept)?;
        let users = geometries.iter().enumerate().filter(|(_, geometry)| accept(geometry));
        self.geometries = users
            .filter_map(|(i, geometry)| match &geometry.kind {
                GeometryKind::User(user) => Some((numbering.starts[i], Arc::clone(user))),
                _ => None,
            })
            .collect();
        let Self { over, geometries } = self;
        let fit = |block: &mut [u32; WIDTH]| {
            let mut all = Aabb::EMPTY;
            for &number in block.iter().filter(|&&number| number != INVALID_ID) {
                let at = geometries.partition_point(|(start, _)| *start <= number) - 1;
                let (start, user) = &geometries[at];
                let bounds = user.bounds(number - start);
                let coordinates = bounds.min.into_iter().chain(bounds.max);
                if bounds.is_empty() || BadPrimitives::default().fault(coordinates).is_some() {
                    return Err(RefitError::OtherPrimitives);
                }
                all = all.union(&bounds);
            }
            Ok(all)
        };
        over.refit(threads, fit)
    }
}
