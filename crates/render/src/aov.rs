// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of a picture: properties of the camera rays' hits. Names of layers and channels as EXR files
//! of the field have them. Albedo and normals are means over the samples; position, depths and ids are those
//! of the first sample, because their means are meaningless. `variance` is that of the colour's mean.
//! `unscattered` is the unscattered part of the colour, from lights and environment seen by camera rays, if the
//! integrator provides it (`path`). `background` is the background's radiance straight through transparent surfaces and media, and the light that
//! shadow catchers let through. A shadow catcher has the opacity that gives its darkness, with black as its
//! colour; coloured light from other objects is added [PD84]. Space: world. Depth is the distance from the
//! eye, Z the distance along the view.

use std::ops::Range;

use glam::Vec3;
use gnurt_shading::Vec3s;

use crate::behind::Behind;
use crate::first_hit::{FirstHit, NOTHING};
use crate::held::Held;
use crate::seen::TileSeen;
use crate::state::{SavedState, put_f64};
use crate::tracer::{AttributeRequests, BatchTracer, MID_GREY};
use crate::world::HitLanes;

/// The layers of a tile.
#[derive(Clone, Debug)]
pub(crate) struct TileAovs {
    /// Sums over the samples.
    pub(crate) albedo: Vec<[f64; 3]>,
    pub(crate) normal: Vec<[f64; 3]>,
    pub(crate) emission: Vec<[f64; 3]>,
    pub(crate) first: Vec<FirstHit>,
    /// Background radiance of rays without a hit, and their number; holes count by their shares.
    missed: Vec<[f64; 4]>,
    /// The same for shadow catchers, and their radiance without shadow.
    caught: Vec<[f64; 4]>,
    behind: Vec<[f64; 3]>,
    /// What mirrors and glass show, if requested.
    pub(crate) seen: Option<TileSeen>,
}

impl TileAovs {
    pub(crate) fn new(pixels: usize) -> Self {
        Self {
            albedo: vec![[0.0; 3]; pixels],
            normal: vec![[0.0; 3]; pixels],
            first: vec![NOTHING; pixels],
            emission: vec![[0.0; 3]; pixels],
            missed: vec![[0.0; 4]; pixels],
            caught: vec![[0.0; 4]; pixels],
            behind: vec![[0.0; 3]; pixels],
            seen: None,
        }
    }

    /// The background visible through pixel `i`, summed over samples, and its weight.
    pub(crate) fn background(&self, i: usize) -> [f64; 4] {
        let ([.., count], [r, g, b]) = (self.caught[i], self.behind[i]);
        let ratio = |k: usize, behind: f64| if behind > 0.0 { self.caught[i][k] / behind } else { 1.0 };
        let share = [ratio(0, r), ratio(1, g), ratio(2, b)].into_iter().fold(1.0, f64::min).max(0.0);
        // Light that is taken away and given back leaves a rounding.
        let share = if share > 1.0 - 1e-5 { 1.0 } else { share };
        let missed = self.missed[i];
        [missed[0] + share * r, missed[1] + share * g, missed[2] + share * b, missed[3] + share * count]
    }

    /// Adds the hits and radiance of one sample of each pixel in `range`. `forward` is the unit direction of
    /// view.
    pub(crate) fn add(
        &mut self,
        tracer: &mut BatchTracer,
        camera: HitLanes,
        range: Range<usize>,
        sample: u32,
        forward: Vec3,
        radiance: &Vec3s,
    ) {
        if let Some(seen) = &mut self.seen {
            seen.add(tracer, camera, range.clone(), (sample, radiance));
        }
        let world = tracer.world;
        let first = range.start;
        if !tracer.direct.is_empty() {
            for (sum, lane) in self.emission.iter_mut().zip(range.clone()) {
                let direct = tracer.direct.get(lane);
                (0..3).for_each(|c| sum[c] += f64::from(direct[c]));
            }
        }
        let add = |sum: &mut [f64; 4], direct: Vec3, share: f32| {
            let direct = if direct.is_finite() { direct } else { Vec3::ZERO };
            (0..3).for_each(|k| sum[k] += f64::from(direct[k]));
            sum[3] += f64::from(share);
        };
        for lane in range.clone() {
            let hole = Held::of(&tracer.held, lane).share;
            let Behind { light, share } = Behind::of(&tracer.behind, (camera.hits, radiance), lane);
            // The light of a surface with a hole is not of the background.
            add(&mut self.missed[lane - first], light, share + hole);
        }
        tracer.for_each_surface_in(range, camera, AttributeRequests::Sides, |_, shader, lanes, points| {
            let mut albedo = Vec3s::splat(lanes.len(), MID_GREY);
            shader.albedo(points, &mut albedo);
            let backdrop = shader.backdrop();
            for (k, &lane) in lanes.iter().enumerate() {
                if let Some(behind) = backdrop {
                    add(&mut self.caught[lane as usize - first], radiance.get(lane as usize), 1.0);
                    (0..3).for_each(|c| self.behind[lane as usize - first][c] += f64::from(behind[c]));
                }
                let lane = lane as usize - first;
                let sums = [(&mut self.albedo, albedo.get(k)), (&mut self.normal, points.facing_ns(k))];
                for (sums, value) in sums {
                    (0..3).for_each(|c| sums[lane][c] += f64::from(value[c]));
                }
                if sample == 0 {
                    let instance = points.inst_id[k];
                    self.first[lane] = FirstHit {
                        position: points.p.get(k),
                        depth: points.t[k],
                        z: points.t[k] * points.ray_dir.get(k).dot(forward),
                        object: world.leaf(points.leaf_id[k]).1.0,
                        instance,
                        prim: points.prim_id[k],
                        material: world.material_of(points.leaf_id[k], points.geom_id[k]),
                    };
                }
            }
        });
    }
}

impl SavedState for TileAovs {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        for sums in [&mut self.albedo, &mut self.normal, &mut self.emission] {
            sums.as_flattened_mut().iter_mut().for_each(|x| put_f64(x, with));
        }
        for sums in [&mut self.missed, &mut self.caught] {
            sums.as_flattened_mut().iter_mut().for_each(|x| put_f64(x, with));
        }
        self.behind.as_flattened_mut().iter_mut().for_each(|x| put_f64(x, with));
        self.first.iter_mut().for_each(|hit| hit.state(with));
        if let Some(seen) = &mut self.seen {
            seen.state(with);
        }
    }
}
