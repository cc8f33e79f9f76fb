// SPDX-License-Identifier: GPL-3.0-or-later
//! For tests: a renderer that answers every query with the same value and records its queries.
//! Space: world.

use glam::Vec3;
use gnurt_accel::Ray;

use crate::batch::{SampleKey, SurfaceBatch, Vec3s};
use crate::bsdf::ClosureBatch;
use crate::materials::recursive_radiance;
use crate::shader::{LightBatch, RayRequest, SurfaceShader, Tracer};

/// Answers of a renderer.
pub(super) struct Probe {
    pub(super) lights: Vec<(Vec3, Vec3)>,
    /// Transmittance of shadow rays.
    pub(super) transmittance: Vec3,
    /// Radiance of traced rays.
    pub(super) found: Vec3,
    /// Rays that were traced.
    pub(super) traced: Vec<Ray>,
}

impl Probe {
    /// A scene without lights.
    pub(super) fn dark() -> Self {
        Self { lights: Vec::new(), transmittance: Vec3::ONE, found: Vec3::ZERO, traced: Vec::new() }
    }

    /// A scene with one infinitely distant light.
    pub(super) fn lit(dir: Vec3, radiance: Vec3) -> Self {
        Self { lights: vec![(dir, radiance)], ..Self::dark() }
    }
}

impl Tracer for Probe {
    fn light_count(&self) -> usize {
        self.lights.len()
    }

    fn illuminate(&mut self, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        let (dir, radiance) = self.lights[light];
        out.reset(hits.len());
        out.dir.reset(hits.len(), dir);
        out.radiance.reset(hits.len(), radiance);
    }

    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        transmittance.reset(request.rays.len(), self.transmittance);
    }

    fn trace(&mut self, _depth: u32, request: &RayRequest, radiance: &mut Vec3s) {
        self.traced.extend((0..request.rays.len()).map(|i| request.rays.get(i)));
        radiance.reset(request.rays.len(), self.found);
    }

    fn random(&self, _key: SampleKey, _depth: u32, _purpose: u32) -> [f32; 2] {
        [0.5; 2]
    }
}

/// One point of a floor, normal upwards, seen from above.
pub(super) fn floor() -> SurfaceBatch {
    SurfaceBatch {
        p: Vec3s::splat(1, Vec3::ZERO),
        error: vec![1e-4],
        ng: Vec3s::splat(1, Vec3::Y),
        ns: Vec3s::splat(1, Vec3::Y),
        lift: Vec3s::splat(1, Vec3::ZERO),
        ray_dir: Vec3s::splat(1, Vec3::new(0.0, -1.0, -1.0).normalize()),
        t: vec![1.0],
        texcoord: [vec![0.5], vec![0.5]],
        key: vec![SampleKey::default()],
        ..SurfaceBatch::default()
    }
}

/// Radiance of a shader at the only point of `hits`.
pub(super) fn shade(shader: &dyn SurfaceShader, probe: &mut Probe, hits: &SurfaceBatch) -> Vec3 {
    let mut out = Vec3s::splat(hits.len(), Vec3::ZERO);
    recursive_radiance(probe, hits, shader, &mut ClosureBatch::default(), &mut out);
    out.get(0)
}
