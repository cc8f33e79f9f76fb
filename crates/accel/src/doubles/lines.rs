// SPDX-License-Identifier: GPL-3.0-or-later
//! A line on its way through a scene in double precision, and the scenes in it.
//! Triangles are found in their own space, with a bound of what was lost on the way, and decided in the space of the query, to
//! which their corners are carried without rounding. Tests: `tests/doubles.rs`.

use gnurt_accel_bvh::DoubleLine;
use gnurt_accel_core::exact::{InstancePath, Line, Triangle};
use gnurt_simd::Level;

use super::scene::DoubleScene;

/// A triangle that a line may meet.
pub(super) struct Candidate<'a> {
    /// In the space of the query.
    pub(super) triangle: &'a Triangle<'a>,
    /// Whether the line passes inside.
    pub(super) is_certain: bool,
    pub(super) leaf: u32,
    /// Of the triangle in its scene.
    pub(super) number: u32,
}

/// Calls `meet` with all triangles that the line may meet before its reach; it answers with the new reach.
pub(super) fn search(scene: &DoubleScene, line: &Line, mask: u32, meet: &mut dyn FnMut(Candidate) -> f64) {
    let from = DoubleLine { org: line.org, dir: line.dir, near: line.near, off_org: 0.0, off_dir: 0.0 };
    inside(scene, &from, mask, None, 0, line.far, Level::best(), meet);
}

#[expect(clippy::too_many_arguments, reason = "the state of a recursion")]
fn inside(
    scene: &DoubleScene,
    line: &DoubleLine,
    mask: u32,
    path: Option<&InstancePath>,
    leaf: u32,
    mut reach: f64,
    level: Level,
    meet: &mut dyn FnMut(Candidate) -> f64,
) -> f64 {
    scene.index.search(level, line, reach, &mut |(number, corners, is_certain)| {
        if scene.all_masks & mask != 0 || scene.masks[scene.ids(number)[0] as usize] & mask != 0 {
            let triangle = Triangle::of_doubles(*corners, path);
            reach = meet(Candidate { triangle: &triangle, is_certain, leaf, number });
        }
        reach
    });
    scene.boxes.search(level, line, reach, &mut |number| {
        let placed = &scene.instances[number as usize];
        if placed.mask & mask != 0 && reach > f64::NEG_INFINITY {
            let columns = &placed.map.columns;
            let path = InstancePath { columns, outer: path };
            let (line, leaf) = (placed.map.line(line), leaf + placed.first_leaf);
            reach = inside(&placed.shown, &line, mask, Some(&path), leaf, reach, level, meet);
        }
        reach
    });
    reach
}

/// Calls `with` with the way from a leaf to the space of the query.
pub(super) fn along_path(
    scene: &DoubleScene,
    leaf: u32,
    path: Option<&InstancePath>,
    with: &mut dyn FnMut(Option<&InstancePath>),
) {
    if leaf == 0 {
        return with(path);
    }
    let placed = &scene.instances[scene.placed_at(leaf)];
    let path = InstancePath { columns: &placed.map.columns, outer: path };
    along_path(&placed.shown, leaf - placed.first_leaf, Some(&path), with);
}
