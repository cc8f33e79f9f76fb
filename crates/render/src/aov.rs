// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers beside the colour: what the camera's rays hit.
//! Source: original; names of layers and channels as EXR files of the field have them.
//! Albedo and normals are means over the samples; position, depths and ids are those of the first sample, because a
//! mean of places or numbers is none. `variance` is that of the colour's mean. `emission` is the part of the colour that no
//! surface scattered: lamps and surroundings that camera rays meet, where the integrator tells (`path`). Space: world. Depth is the distance from the eye, Z the one along the view.

use std::ops::Range;

use glam::Vec3;
use gnurt_accel::INVALID_ID;
use gnurt_image::{Layer, Picture};
use gnurt_shading::Vec3s;

use crate::checkpoint::{Words, word_f32, word_f64, word_u32};
use crate::film::TileFilm;
use crate::integrators::eyelight::MID_GREY;
use crate::tracer::{BatchTracer, Wanted};
use crate::world::HitLanes;

/// The layers of a tile.
#[derive(Clone, Debug)]
pub(crate) struct TileAovs {
    /// Sums over the samples.
    albedo: Vec<[f64; 3]>,
    normal: Vec<[f64; 3]>,
    emission: Vec<[f64; 3]>,
    first: Vec<FirstHit>,
}

/// What the first ray of a pixel hit.
#[derive(Clone, Copy, Debug)]
struct FirstHit {
    position: Vec3,
    depth: f32,
    z: f32,
    object: u32,
    instance: u32,
    prim: u32,
    material: u32,
}

const NOTHING: FirstHit = FirstHit {
    position: Vec3::ZERO,
    depth: f32::INFINITY,
    z: f32::INFINITY,
    object: INVALID_ID,
    instance: INVALID_ID,
    prim: INVALID_ID,
    material: INVALID_ID,
};

impl TileAovs {
    pub(crate) fn new(pixels: usize) -> Self {
        let nothing = || vec![[0.0; 3]; pixels];
        Self { albedo: nothing(), normal: nothing(), emission: nothing(), first: vec![NOTHING; pixels] }
    }

    /// Adds what a sample of each pixel hit, that of `range`. `forward` is the unit direction of view.
    pub(crate) fn add(
        &mut self,
        tracer: &mut BatchTracer,
        camera: HitLanes,
        range: Range<usize>,
        sample: u32,
        forward: Vec3,
    ) {
        let world = tracer.world;
        let first = range.start;
        if !tracer.seen.is_empty() {
            for (sum, lane) in self.emission.iter_mut().zip(range.clone()) {
                let seen = tracer.seen.get(lane);
                (0..3).for_each(|c| sum[c] += f64::from(seen[c]));
            }
        }
        tracer.for_each_surface_in(range, camera, Wanted::Albedo, |_, shader, lanes, points| {
            let mut albedo = Vec3s::splat(lanes.len(), MID_GREY);
            shader.albedo(points, &mut albedo);
            for (k, &lane) in lanes.iter().enumerate() {
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
                        object: world.object_of(instance),
                        instance,
                        prim: points.prim_id[k],
                        material: world.material_of(instance, points.geom_id[k]),
                    };
                }
            }
        });
    }
}

impl Words for TileAovs {
    fn words(&mut self, with: &mut dyn FnMut(&mut u64)) {
        for sums in [&mut self.albedo, &mut self.normal, &mut self.emission] {
            sums.as_flattened_mut().iter_mut().for_each(|x| word_f64(x, with));
        }
        for hit in &mut self.first {
            let FirstHit { position, depth, z, object, instance, prim, material } = hit;
            for x in [&mut position.x, &mut position.y, &mut position.z, depth, z] {
                word_f32(x, with);
            }
            for id in [object, instance, prim, material] {
                word_u32(id, with);
            }
        }
    }
}

/// Adds the layers of all tiles to the picture.
pub(crate) fn add_layers(picture: &mut Picture, tiles: &[TileFilm]) {
    let width = picture.width as usize;
    let pixels = picture.pixel_count();
    let with_layers = || tiles.iter().filter_map(|tile| Some((tile, tile.aovs.as_ref()?)));
    // One plane of the picture, gathered from the tiles.
    let plane = |value: &dyn Fn(&TileFilm, &TileAovs, usize) -> f32, background: f32| {
        let mut plane = vec![background; pixels];
        for (tile, aovs) in with_layers() {
            for (i, [x, y]) in tile.pixels().enumerate() {
                plane[y as usize * width + x as usize] = value(tile, aovs, i);
            }
        }
        plane
    };
    let ids = |value: &dyn Fn(&FirstHit) -> u32| {
        let mut plane = vec![INVALID_ID; pixels];
        for (tile, aovs) in with_layers() {
            for (i, [x, y]) in tile.pixels().enumerate() {
                plane[y as usize * width + x as usize] = value(&aovs.first[i]);
            }
        }
        plane
    };
    let mean = |sum: f64, tile: &TileFilm| (sum / f64::from(tile.samples.max(1))) as f32;
    let albedo = |c: usize| plane(&|tile, aovs, i| mean(aovs.albedo[i][c], tile), 0.0);
    let normal = |c: usize| plane(&|tile, aovs, i| mean(aovs.normal[i][c], tile), 0.0);
    let emission = |c: usize| plane(&|tile, aovs, i| mean(aovs.emission[i][c], tile), 0.0);
    let position = |c: usize| plane(&|_, aovs, i| aovs.first[i].position[c], 0.0);
    let variance = |c: usize| plane(&|tile, _, i| tile.variance(i)[c], 0.0);
    let depth = plane(&|_, aovs, i| aovs.first[i].depth, f32::INFINITY);
    let z = plane(&|_, aovs, i| aovs.first[i].z, f32::INFINITY);
    picture.layers.extend([
        Layer::floats("albedo", [("R", albedo(0)), ("G", albedo(1)), ("B", albedo(2))]),
        Layer::floats("variance", [("R", variance(0)), ("G", variance(1)), ("B", variance(2))]),
        Layer::floats("emission", [("R", emission(0)), ("G", emission(1)), ("B", emission(2))]),
        Layer::floats("N", [("X", normal(0)), ("Y", normal(1)), ("Z", normal(2))]),
        Layer::floats("P", [("X", position(0)), ("Y", position(1)), ("Z", position(2))]),
        Layer::floats("depth", [("Z", depth)]),
        Layer::floats("", [("Z", z)]),
        Layer::ids(
            "id",
            [
                ("object", ids(&|hit| hit.object)),
                ("instance", ids(&|hit| hit.instance)),
                ("prim", ids(&|hit| hit.prim)),
                ("material", ids(&|hit| hit.material)),
            ],
        ),
    ]);
}
