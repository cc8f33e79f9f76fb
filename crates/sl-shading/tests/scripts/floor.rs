// SPDX-License-Identifier: GPL-3.0-or-later
//! A floor that is seen from above, and a renderer that answers every question with the same value.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use gnurt_shading::{LightBatch, RayRequest, SampleKey, SurfaceBatch, SurfaceShader, Tracer, Vec3s};
use gnurt_sl_shading::{Access, Script};

/// Points along x, normals upwards, texture coordinates as far as x.
pub(crate) fn floor(count: usize) -> SurfaceBatch {
    let mut p = Vec3s::splat(count, Vec3::ZERO);
    (0..count).for_each(|i| p.set(i, Vec3::new(i as f32, 0.0, 0.0)));
    SurfaceBatch {
        p,
        error: vec![1e-4; count],
        ng: Vec3s::splat(count, Vec3::Y),
        ns: Vec3s::splat(count, Vec3::Y),
        lift: Vec3s::splat(count, Vec3::ZERO),
        ray_dir: Vec3s::splat(count, Vec3::new(0.0, -1.0, -1.0).normalize()),
        t: vec![1.0; count],
        texcoord: [(0..count).map(|i| i as f32).collect(), vec![0.5; count]],
        dp_du: Vec3s::splat(count, Vec3::X),
        dp_dv: Vec3s::splat(count, -Vec3::Z),
        color: Vec3s::splat(count, Vec3::new(0.25, 0.5, 0.75)),
        alpha: vec![1.0; count],
        prim_id: vec![0; count],
        geom_id: vec![0; count],
        inst_id: vec![0; count],
        leaf_id: vec![0; count],
        key: vec![SampleKey::default(); count],
        u: vec![0.0; count],
        v: vec![0.0; count],
        ..SurfaceBatch::default()
    }
}

/// Answers of a renderer: a light from above, as strong as it says; half of it is in shadow.
pub(crate) struct Probe(pub(crate) f32);

impl Tracer for Probe {
    fn light_count(&self) -> usize {
        1
    }

    fn illuminate(&mut self, _: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        out.reset(hits.len());
        out.dir.reset(hits.len(), Vec3::Y);
        out.radiance.reset(hits.len(), Vec3::splat(self.0));
        out.pdf.fill(0.25);
    }

    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        transmittance.reset(request.rays.len(), Vec3::splat(0.5));
    }

    fn trace(&mut self, _: u32, request: &RayRequest, radiance: &mut Vec3s) {
        radiance.reset(request.rays.len(), Vec3::ZERO);
        (0..request.rays.len()).for_each(|i| radiance.set(i, Vec3::from(request.rays.get(i).dir).abs()));
    }

    fn distances(&mut self, request: &RayRequest, out: &mut Vec<f32>) {
        out.clear();
        out.resize(request.rays.len(), 7.0);
    }

    fn random(&self, _: SampleKey, _: u32, _: u32) -> [f32; 2] {
        [0.5; 2]
    }
}

/// A shader by its text.
pub(crate) fn script(text: &str) -> Script {
    Script::from_text(Path::new("test.osl"), text, &Access::default()).unwrap_or_else(|why| panic!("{why}"))
}

/// A surface by the statements of its body.
pub(crate) fn surface(body: &str) -> Arc<dyn SurfaceShader> {
    script(&format!("surface test () {{ {body} }}")).surface().expect("a surface")
}
