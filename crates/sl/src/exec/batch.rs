// SPDX-License-Identifier: GPL-3.0-or-later
//! Sixteen points at a time: input and output of a group that is ready to run, by any engine. The interpreter
//! takes the points one by one; code for lanes may take them all at once. The results are the same. Numbers
//! are in rows, one number of each point side by side. Tests: `tests/meaning/more.rs`.

use super::cells::{DualRow, LANES, Row};
use super::components::Closures;
use super::host::{Host, Point};
use super::machine::Event;
use super::slot::RetainedOutput;
use gnurt_sl_lib::Dual;

/// The points that are shaded: [`Point`] in rows. Space: common.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// How many there are; rows hold anything beyond.
    pub count: usize,
    /// Positions.
    pub p: [DualRow; 3],
    /// Directions of the rays that came here.
    pub i: [DualRow; 3],
    /// Shading normals.
    pub n: [Row; 3],
    /// Geometric normals.
    pub ng: [Row; 3],
    /// First surface parameters.
    pub u: DualRow,
    /// Second surface parameters.
    pub v: DualRow,
    /// Changes of position with `u`.
    pub dpdu: [Row; 3],
    /// Changes of position with `v`.
    pub dpdv: [Row; 3],
    /// Positions that are lit, in light shaders.
    pub ps: [DualRow; 3],
    /// Times.
    pub time: Row,
    /// How long the shutter is open.
    pub dtime: Row,
    /// Motions of the points.
    pub dpdtime: [Row; 3],
    /// Areas of the surfaces.
    pub surface_area: Row,
    /// Bits of the points whose backs are seen.
    pub backfacing: u16,
    /// Bits of the points on mirrored surfaces.
    pub flipped: u16,
    /// Bits of the kinds of each ray.
    pub ray_kinds: [u32; LANES],
    /// Numbers of the points, by which a [`Host`] identifies them.
    pub index: [i32; LANES],
    /// Pairs of random numbers, in lights and cameras.
    pub xi: [Row; 2],
    /// Raster position in pixels, in cameras and pixels.
    pub raster: [Row; 2],
}

fn set3(rows: &mut [Row; 3], lane: usize, v: [f32; 3]) {
    for (row, x) in rows.iter_mut().zip(v) {
        row[lane] = x;
    }
}

fn set_dual3(rows: &mut [DualRow; 3], lane: usize, v: Dual<[f32; 3]>) {
    for (row, x) in rows.iter_mut().zip(v.components()) {
        row.set(lane, x);
    }
}

impl Points {
    /// Writes one of them.
    pub fn set(&mut self, lane: usize, point: &Point) {
        set_dual3(&mut self.p, lane, point.p);
        set_dual3(&mut self.i, lane, point.i);
        set_dual3(&mut self.ps, lane, point.ps);
        self.u.set(lane, point.u);
        self.v.set(lane, point.v);
        set3(&mut self.n, lane, point.n);
        set3(&mut self.ng, lane, point.ng);
        set3(&mut self.dpdu, lane, point.dpdu);
        set3(&mut self.dpdv, lane, point.dpdv);
        set3(&mut self.dpdtime, lane, point.dpdtime);
        (self.time[lane], self.dtime[lane]) = (point.time, point.dtime);
        self.surface_area[lane] = point.surface_area;
        let bit = 1 << lane;
        self.backfacing = self.backfacing & !bit | if point.backfacing { bit } else { 0 };
        self.flipped = self.flipped & !bit | if point.flipped { bit } else { 0 };
        self.ray_kinds[lane] = point.ray_kinds;
        self.index[lane] = point.index;
        for k in 0..2 {
            (self.xi[k][lane], self.raster[k][lane]) = (point.xi[k], point.raster[k]);
        }
    }

    /// One of them.
    #[must_use]
    pub fn point(&self, lane: usize) -> Point {
        let lane = lane % LANES;
        // Written out: mapping arrays becomes calls.
        let triple = |[x, y, z]: &[Row; 3]| [x[lane], y[lane], z[lane]];
        let duals = |[x, y, z]: &[DualRow; 3]| Dual::from_components([x.get(lane), y.get(lane), z.get(lane)]);
        Point {
            p: duals(&self.p),
            i: duals(&self.i),
            n: triple(&self.n),
            ng: triple(&self.ng),
            u: self.u.get(lane),
            v: self.v.get(lane),
            dpdu: triple(&self.dpdu),
            dpdv: triple(&self.dpdv),
            ps: duals(&self.ps),
            time: self.time[lane],
            dtime: self.dtime[lane],
            dpdtime: triple(&self.dpdtime),
            surface_area: self.surface_area[lane],
            backfacing: self.backfacing >> lane & 1 != 0,
            flipped: self.flipped >> lane & 1 != 0,
            ray_kinds: self.ray_kinds[lane],
            index: self.index[lane],
            xi: [self.xi[0][lane], self.xi[1][lane]],
            raster: [self.raster[0][lane], self.raster[1][lane]],
        }
    }
}

/// The results. Memory that can be reused.
#[derive(Debug, Default)]
pub struct Results {
    /// The stored values, by [`RetainedOutput::row`]; ints as floats.
    pub rows: Vec<Row>,
    /// Nodes of the closures of all points.
    pub closures: Closures,
    /// The node that is each point's `Ci`, counted from 1; 0 for none.
    pub ci: [u32; LANES],
    /// The messages, by points.
    pub events: Vec<(usize, Event)>,
}

/// A group that is ready to run.
pub trait Program: Send + Sync {
    /// Runs it for the points of a batch. Earlier contents of `out` are lost.
    fn run(&self, host: &dyn Host, points: &Points, out: &mut Results);

    /// The same for two batches, which may be run together: the results are those of one after the other.
    fn run_pair(&self, host: &dyn Host, points: &[Points; 2], out: &mut [Results; 2]) {
        points.iter().zip(out).for_each(|(points, out)| self.run(host, points, out));
    }

    /// The retained outputs.
    fn retained(&self) -> &[RetainedOutput];

    /// Runs it for one point and describes its parameters and variables, a line each.
    fn describe_point(&self, host: &dyn Host, point: &Point) -> Vec<String>;
}
