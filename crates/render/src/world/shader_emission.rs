// SPDX-License-Identifier: GPL-3.0-or-later
//! Shapes that emit by their surfaces' shaders. Queries give the exit radiance, for light samples and
//! paths that start there; earlier queries at some points give the mean emission of each side of each
//! shape. Only this mean is cached, never light itself. Space: world.
//! Invariant: a queried point has the properties of a hit point, except that its cone width is unknown. Sides
//! that were dark at all queried points are no lights: only scattered rays find emission there. Tests:
//! crates/render/tests/shader_emission.rs.

use std::cell::Cell;
use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::threads::{self, Pieces};
use gnurt_accel::{HitBatch, RayBatch, SharedList};
use gnurt_image::srgb::luminance;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::lanes::LANES;
use gnurt_shading::lights::{
    EmissiveShape, Emitter, EmitterPoint, EmitterShaders, LEAST_SHARE, Outline, looking_at,
};
use gnurt_shading::sampling::{Basis, cosine_hemisphere};
use gnurt_shading::{Detail, SampleKey, SurfaceBatch};
use gnurt_simd::Level;

use super::instance::InstanceSlot;
use super::open::Shutter;
use super::surface::{HitLanes, Leaves, SurfacePoints};

/// Number of queried points on each side of all shapes of one surface together; and the limits for one
/// shape.
const PROBES: usize = 1 << 13;
const MOST_PROBES: usize = 64;
const FEWEST_PROBES: usize = 4;

/// Shapes that a thread probes at a time.
const TOGETHER: usize = 64;

/// A shape that may emit.
#[derive(Clone, Copy)]
pub(super) struct EmissionShape {
    /// Instance, object in the instance, mesh, primitive; the instance by its index in
    /// `ShaderEmission::instances`.
    pub(super) met: [u32; 4],
    /// Its instance in the world.
    pub(super) inst_id: u32,
    /// Which emitter it belongs to.
    pub(super) emitter: u32,
    /// Whether a triangle's second corner is the mesh's third.
    pub(super) is_turned: bool,
    pub(super) outline: Outline,
}

/// The evaluation of their emission.
pub(super) struct ShaderEmission {
    /// By number of the emissive shape; `None` = another emitter's.
    pub(super) shapes: Vec<Option<EmissionShape>>,
    /// Instances that have some of them.
    pub(super) instances: SharedList<InstanceSlot>,
    pub(super) emitters: Vec<Arc<Emitter>>,
    /// The time of the open shutter, if something moves.
    pub(super) time: Option<f32>,
    pub(super) face_normals: bool,
}

/// Memory that stays from call to call.
#[derive(Default)]
struct Scratch {
    rays: RayBatch,
    hits: HitBatch,
    keys: Vec<SampleKey>,
    points: SurfaceBatch,
    closures: ClosureBatch,
}

thread_local! {
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

impl EmitterShaders for ShaderEmission {
    fn radiance(&self, requests: &[EmitterPoint], out: &mut [Vec3]) {
        let emissions: Vec<Option<EmissionShape>> =
            requests.iter().map(|at| self.shapes[at.shape as usize]).collect();
        let emitter_of = |i: usize| emissions[i].map(|shader_emission| shader_emission.emitter);
        let mut left: Vec<usize> = (0..requests.len()).filter(|&i| emissions[i].is_some()).collect();
        while let Some(emitter) = left.first().and_then(|&i| emitter_of(i)) {
            let (these, others) =
                left.iter().partition::<Vec<usize>, _>(|&&i| emitter_of(i) == Some(emitter));
            let emitter_points: Vec<(EmissionShape, EmitterPoint)> =
                these.iter().filter_map(|&i| Some((emissions[i]?, requests[i]))).collect();
            self.query(emitter, &emitter_points, |k, radiance| out[these[k]] = radiance);
            left = others;
        }
    }
}

impl ShaderEmission {
    /// Calls `with(k, radiance)` for each of the points, which have one shader.
    pub(super) fn query(
        &self,
        emitter: u32,
        emitter_points: &[(EmissionShape, EmitterPoint)],
        mut with: impl FnMut(usize, Vec3),
    ) {
        let Some(shader) = self.emitters[emitter as usize].shader() else { return };
        let mut scratch = SCRATCH.take().unwrap_or_default();
        for (block, some) in emitter_points.chunks(LANES).enumerate() {
            let Scratch { rays, hits, keys, points, closures } = &mut *scratch;
            rays.clear();
            hits.reset(some.len());
            keys.clear();
            let mut leaves = [[0; 2]; LANES];
            for (i, (shader_emission, at)) in some.iter().enumerate() {
                let [u, v] =
                    if shader_emission.is_turned { [at.position[1], at.position[0]] } else { at.position };
                (hits.u[i], hits.v[i], hits.t[i]) = (u, v, at.distance);
                let [position, leaf, geom_id, prim_id] = shader_emission.met;
                (hits.leaf_id[i], leaves[i]) = (i as u32, [position, leaf]);
                [hits.inst_id[i], hits.geom_id[i], hits.prim_id[i]] =
                    [shader_emission.inst_id, geom_id, prim_id];
                rays.push(gnurt_accel::Ray::new(shader_emission.origin(at).into(), at.dir.into()));
                keys.push(SampleKey::default());
            }
            // As rays do that some surface has scattered.
            let from = HitLanes { rays, keys, hits, cones: None, depth: 1 };
            let lanes: [u32; LANES] = std::array::from_fn(|i| i as u32);
            let shutter = self.time.map(Shutter::All);
            let (instances, leaves) = (&self.instances, Leaves::Listed(&leaves));
            let world = SurfacePoints {
                instances,
                leaves,
                shutter,
                face_normals: self.face_normals,
                curved: false,
                names: None,
            };
            let how = (Level::default(), 0.0);
            world.surface_points(how, from, &lanes[..some.len()], Detail::Full, shader.attributes(), points);
            closures.reset(some.len());
            shader.evaluate(points, closures);
            for i in 0..some.len() {
                let radiance = closures.emission(i);
                with(
                    block * LANES + i,
                    if radiance.is_finite() { radiance.max(Vec3::ZERO) } else { Vec3::ZERO },
                );
            }
        }
        SCRATCH.set(Some(scratch));
    }

    /// Sets the brightness of the shapes with shaders, and returns which of all shapes emit: sides that
    /// were dark at all queried points do not.
    pub(super) fn probe(&self, shapes: &mut [EmissiveShape]) -> Vec<bool> {
        // For each emitter, both sides: how many shapes, area, brightness by area.
        let mut sides = vec![[(0_usize, 0.0_f64, 0.0_f64); 2]; self.emitters.len()];
        let side_of = |i: usize| {
            self.shapes[i].map(|shader_emission| (shader_emission.emitter as usize, self.is_back(i)))
        };
        for (emitter, back) in (0..shapes.len()).filter_map(side_of) {
            sides[emitter][usize::from(back)].0 += 1;
        }
        let pieces = Pieces::new(shapes, TOGETHER);
        threads::for_each(true, pieces.count(), &|n| {
            for (i, shape) in (n * TOGETHER..).zip(pieces.lock(n).iter_mut()) {
                let Some((emitter, back)) = side_of(i) else { continue };
                let probes = (PROBES / sides[emitter][usize::from(back)].0).clamp(FEWEST_PROBES, MOST_PROBES);
                let (mean, dark) = self.mean_of(i, shape, probes);
                shape.brightness = mean;
                let count = sides[emitter][usize::from(back)].0;
                if let Some((beam, mean)) = self.beam_of(i, shape, (count, dark)) {
                    (shape.brightness, shape.beam) = (mean, Some(Arc::new(beam)));
                }
            }
        });
        for (i, shape) in shapes.iter().enumerate() {
            if let Some((emitter, back)) = side_of(i) {
                let (_, whole, bright) = &mut sides[emitter][usize::from(back)];
                *whole += shape.outline.area();
                *bright += shape.outline.area() * f64::from(shape.brightness);
            }
        }
        for (i, shape) in shapes.iter_mut().enumerate() {
            if let Some((emitter, back)) = side_of(i) {
                let (_, whole, bright) = sides[emitter][usize::from(back)];
                shape.brightness = shape.brightness.max(LEAST_SHARE * (bright / whole) as f32);
            }
        }
        (0..).zip(&*shapes).map(|(i, shape)| side_of(i).is_none() || shape.brightness > 0.0).collect()
    }

    /// Whether shape `i` is the back of its predecessor.
    fn is_back(&self, i: usize) -> bool {
        let met = |i: usize| self.shapes[i].map(|shader_emission| shader_emission.met);
        i > 0 && met(i) == met(i - 1)
    }

    /// Mean brightness over all positions and, by their cosines, all directions; and the share of those that were dark.
    fn mean_of(&self, number: usize, shape: &EmissiveShape, probes: usize) -> (f32, f32) {
        let Some(shader_emission) = self.shapes[number] else { return (0.0, 1.0) };
        let probe = |i: usize| {
            let position = shape.outline.place(looking_at(i as u32));
            let normal = shape.outline.normal_at(position);
            // Of all directions to all parts of the shape.
            let [a, b] = looking_at((i * 7 + 3) as u32);
            let dir = -Basis::around(normal).to_world(cosine_hemisphere([b, a])).normalize();
            (shader_emission, EmitterPoint { shape: number as u32, position, dir, distance: 1.0 })
        };
        let emitter_points: Vec<_> = (0..probes).map(probe).collect();
        let (mut sum, mut dark) = (0.0, 0_u16);
        self.query(shader_emission.emitter, &emitter_points, |_, radiance| {
            let bright = luminance(radiance.into());
            sum += bright;
            dark += u16::from(bright <= 0.0);
        });
        let mean = sum / probes as f32;
        (if mean.is_finite() { mean } else { 0.0 }, f32::from(dark) / probes as f32)
    }
}

impl EmissionShape {
    /// Where a ray to a point of it begins. Triangles take no more of a ray than its direction.
    fn origin(&self, at: &EmitterPoint) -> Vec3 {
        match self.outline {
            Outline::Triangle(_) => Vec3::ZERO,
            Outline::Sphere { .. } => self.outline.point(at.position) - at.dir * at.distance,
        }
    }
}
