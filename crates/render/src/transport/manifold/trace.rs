// SPDX-License-Identifier: GPL-3.0-or-later
//! A chain that is followed from a point: mirrored or refracted at one smooth surface after the other.
//! A new chain chooses as it goes, by the share of light, and where it ends; one that is followed again makes the same turns.
//! Source: [HDF15] section 3 (chains from a seed ray), [ZGJ20] section 4. Space: world. Tests: crates/render/tests/caustics.rs.

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::bsdf::left_after;
use gnurt_shading::{SampleKey, SurfacePoint};

use super::differential::Differential;
use super::smooth::SmoothPoint;
use crate::transport::flight::Random;

/// Smooth surfaces of a chain at most.
pub(crate) const MOST: usize = 4;
/// Chances that a chain ends before the next surface: in the open, and within glass, where lamps are rare.
const ENDS: [f32; 2] = [0.5, 0.1];
/// The least chance of one of two turns.
const LEAST: f32 = 0.1;
/// Square of how far a unit direction may be off that still counts as unbent; that of `transport::panes`.
const UNBENT: f32 = 1e-10;

/// The turns of a chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Turns {
    pub(super) count: usize,
    /// Bit by bit: whether it goes through.
    pub(super) through: u32,
}

impl Turns {
    fn is_through(self, at: usize) -> bool {
        self.through >> at & 1 != 0
    }

    /// The same with another one.
    fn and(self, is_through: bool) -> Self {
        Self { count: self.count + 1, through: self.through | u32::from(is_through) << self.count }
    }

    /// Whether these are the first ones of others.
    pub(super) fn begin(self, all: Self) -> bool {
        self.count <= all.count && self.through == all.through & ((1 << self.count) - 1)
    }
}

/// Where a chain leaves its last surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Last {
    pub(super) point: SurfacePoint,
    pub(super) inst_id: u32,
    pub(super) transmitted: bool,
    /// Absorption behind it.
    pub(super) absorption: Vec3,
}

/// A chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trace {
    /// Unit, where it began, and the axes around that.
    pub(super) dir: Vec3,
    pub(super) frame: [Vec3; 2],
    /// The turns to make; `None` = any, up to this number.
    planned: Option<Turns>,
    most: usize,
    /// Those that were made.
    pub(super) turns: Turns,
    /// Materials of its surfaces.
    pub(super) materials: [u32; MOST],
    /// Which primitives they were: leaf, mesh, primitive.
    pub(super) met: [[u32; 3]; MOST],
    /// The next ray, how it changes, and the key of surfaces that are there in part.
    pub(super) ray: Ray,
    pub(super) key: SampleKey,
    pub(super) layers: u32,
    /// Where the ray leaves for good: transparent surfaces do not count.
    pub(super) org: Vec3,
    /// Unit, where it goes.
    pub(super) heading: Vec3,
    pub(super) change: Differential,
    /// The share of light that is left.
    pub(super) light: Vec3,
    /// Absorption at the start of its ray.
    absorption: Vec3,
    /// Whether it went through all surfaces without being bent.
    pub(super) is_straight: bool,
    pub(super) last: Option<Last>,
}

/// What a chain does at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goes {
    On,
    /// It has made all its turns.
    Ended,
    /// It cannot make the next turn.
    Lost,
}

impl Trace {
    /// One that begins with `ray`, with absorption there.
    pub(super) fn new(
        ray: Ray,
        key: SampleKey,
        absorption: Vec3,
        planned: Option<Turns>,
        most: usize,
    ) -> Self {
        let dir = Vec3::from(ray.dir);
        let frame = dir.any_orthonormal_pair().into();
        Self {
            dir,
            frame,
            planned,
            most,
            turns: Turns::default(),
            materials: [0; MOST],
            met: [[0; 3]; MOST],
            ray,
            key,
            layers: 0,
            org: ray.org.into(),
            heading: dir,
            change: Differential::from_point(frame),
            light: Vec3::ONE,
            absorption,
            is_straight: true,
            last: None,
        }
    }

    /// Whether it chooses its turns.
    pub(super) fn is_new(&self) -> bool {
        self.planned.is_none()
    }

    /// The turns to make when it is followed again.
    pub(super) fn planned_or_made(&self) -> Turns {
        self.planned.unwrap_or(self.turns)
    }

    /// It met nothing to turn at: new chains end there if they have turned.
    pub(super) fn leaves(&self) -> Goes {
        if self.is_new() && self.turns.count > 0 { Goes::Ended } else { Goes::Lost }
    }

    /// Turns at a point; `of`: instance, material, primitive, and whether the ray came from the front.
    pub(super) fn turn(
        &mut self,
        at: &SmoothPoint,
        (inst_id, material, met, front): (u32, u32, [u32; 3], bool),
        random: &mut Random,
    ) -> Goes {
        let is_through = match self.planned {
            Some(planned) => planned.is_through(self.turns.count),
            None => choose(at, random),
        };
        let Some((wi, weight)) = at.branches[usize::from(is_through)] else { return Goes::Lost };
        let Some(ray) = at.point.scatter_ray(wi, is_through, f32::INFINITY) else { return Goes::Lost };
        let dir = self.heading;
        self.change.transfer((at.point.p - self.org).length(), dir, at.point.ng);
        match is_through {
            true => self.change.refract(dir, at.point.ns, at.eta, &at.bend),
            false => self.change.mirror(dir, at.point.ns, &at.bend),
        }
        let here = at.bsdf.medium().on(true);
        self.light *= weight * left_after((at.point.p - self.org).length(), [self.absorption, here]);
        self.absorption = at.bsdf.medium().on(!is_through);
        self.is_straight &= is_through && wi.distance_squared(dir) <= UNBENT;
        self.materials[self.turns.count] = material;
        self.met[self.turns.count] = met;
        self.turns = self.turns.and(is_through);
        (self.ray, self.heading, self.org) = (ray, wi, ray.org.into());
        self.last =
            Some(Last { point: at.point, inst_id, transmitted: is_through, absorption: self.absorption });
        let ends = match self.planned {
            Some(planned) => self.turns.count == planned.count,
            None => {
                let is_inside = front == is_through;
                self.turns.count >= self.most || random.next() < ENDS[usize::from(is_inside)]
            }
        };
        if ends { Goes::Ended } else { Goes::On }
    }
}

/// Whether a new chain goes through: by the shares of light.
fn choose(at: &SmoothPoint, random: &mut Random) -> bool {
    let [mirrored, through] =
        at.branches.map(|branch| branch.map_or(0.0, |(_, weight)| weight.element_sum()));
    let chance = match (mirrored > 0.0, through > 0.0) {
        (true, true) => (through / (mirrored + through)).clamp(LEAST, 1.0 - LEAST),
        (false, _) => 1.0,
        (true, false) => 0.0,
    };
    random.next() < chance
}
