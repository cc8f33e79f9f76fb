// SPDX-License-Identifier: GPL-3.0-or-later
//! Primitives by their numbers: the contents of leaves, for queries from outside. A tree has no map from
//! numbers to leaves; the first query makes it, in one pass over the leaves: 4 bytes a primitive. Invariant:
//! a primitive that lies in several leaves is found in one of them.
//! Tests: `tests/surfaces/normals.rs`.

use gnurt_accel_core::blocks::WIDTH;
use gnurt_accel_core::primitive::Primitive;

use super::locations::Locations;
use super::{Index, ObjectTree, Part};
use crate::{Hit, INVALID_ID};

impl Index {
    /// How many leaf blocks there are, and the numbers of each.
    pub(super) fn numbers(&self, visit: &mut dyn FnMut(usize, &[u32; WIDTH])) -> usize {
        match self {
            Self::Research(index) => index.numbers(visit),
            Self::Bvh(index) => index.numbers(visit),
            Self::Moving(index) => index.first().numbers(visit),
            Self::MovingUser(index) => index.numbers(visit),
            Self::Blocks(index) => index.numbers(visit),
        }
    }

    fn primitive(&self, number: u32, block: usize, lane: usize, time: f32) -> Primitive<'_> {
        match self {
            Self::Research(index) => Primitive::Triangle(index.corners_at(number, block, lane)),
            Self::Bvh(index) => Primitive::Triangle(index.corners_at(block, lane)),
            Self::Moving(index) => Primitive::Triangle(index.corners_at(block, lane, time)),
            Self::MovingUser(index) => index.primitive(block, lane),
            Self::Blocks(index) => index.primitive(block, lane),
        }
    }
}

impl ObjectTree {
    fn locations(&self) -> &Locations {
        self.locations.get_or_init(|| {
            let mut locations = Locations { of_number: Vec::new(), starts: Vec::new() };
            locations
                .of_number
                .resize(self.numbering.starts.last().map_or(0, |&end| end as usize), INVALID_ID);
            let mut start = 0;
            for part in &self.parts {
                locations.starts.push(start as u32);
                let blocks = part.index.numbers(&mut |block, numbers| {
                    for (lane, &number) in numbers.iter().enumerate() {
                        if let Some(location) = locations.of_number.get_mut(number as usize) {
                            *location = (start + block * WIDTH + lane) as u32;
                        }
                    }
                });
                start += blocks * WIDTH;
            }
            locations
        })
    }

    /// A primitive, or half of a quad, at a time, and that as its keys have it; `None` for an untraceable one.
    fn primitive(&self, number: u32, time: f32) -> Option<(Primitive<'_>, f32)> {
        let locations = self.locations();
        let location = *locations.of_number.get(number as usize)?;
        if location == INVALID_ID {
            return None;
        }
        let part = locations.starts.partition_point(|&start| start <= location) - 1;
        let within = (location - locations.starts[part]) as usize;
        let Part { times, index, .. } = &self.parts[part];
        let time = times.local(time).unwrap_or(0.0);
        Some((index.primitive(number, within / WIDTH, within % WIDTH, time), time))
    }

    /// The normal of a hit at a time, in the object's space and of any length: of triangles and quads on the
    /// side from which their vertices go around counter-clockwise, of spheres outwards, if the hit point is
    /// given.
    pub(crate) fn raw_normal(&self, hit: &Hit, at: Option<[f64; 3]>, time: f32) -> Option<[f64; 3]> {
        let geometry = hit.geom_id as usize;
        let &[start, end] = self.numbering.starts.get(geometry..geometry + 2)? else { return None };
        let is_quads = *self.numbering.quads.get(geometry)?;
        let first = if is_quads { hit.prim_id.checked_mul(2)? } else { hit.prim_id };
        let number = start.checked_add(first).filter(|&number| number < end)?;
        let found = if is_quads {
            // Either half where the other is none.
            let half = u32::from(hit.u + hit.v > 1.0);
            self.primitive(number + half, time).or_else(|| self.primitive(number + 1 - half, time))
        } else {
            self.primitive(number, time)
        };
        let (found, time) = found?;
        match found {
            Primitive::Triangle([a, b, c]) => {
                let edge = |p: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
                let (u, v) = (edge(b), edge(c));
                Some([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]])
            }
            Primitive::Sphere(center, _) => at.map(|at| [0, 1, 2].map(|k| at[k] - f64::from(center[k]))),
            Primitive::Disc(_, _, normal) => normal.map(|normal| normal.map(f64::from)),
            Primitive::Curve(curves, prim_id, _) => {
                curves.segment(prim_id)?.normal(f64::from(hit.u), f64::from(hit.v), at)
            }
            Primitive::User(user, prim_id) => user.normal(prim_id, [hit.u, hit.v], at, time),
        }
    }
}
