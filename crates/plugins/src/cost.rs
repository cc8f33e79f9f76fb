// SPDX-License-Identifier: GPL-3.0-or-later
//! For tests: cost of shading by a plugin relative to the same built-in shader, on the same batches and
//! lights. Thread CPU time, medians of blocks of calls, interleaved. The bound is asserted only on request:
//! `cargo test --release -p gnurt-plugins cost -- --ignored --nocapture`.

use std::process::Command;
use std::sync::Arc;

use gnurt::shading::classes::{self, Shader as RenderShader, Value, Values};
use gnurt::shading::{
    LightBatch, LightShader, RayRequest, SampleKey, SurfaceBatch, SurfaceShader, Tracer, Vec3s,
};

use crate::ffi_block::PluginBlock;
use crate::frame::PluginFrame;
use crate::frame_state::FrameState;
use crate::load::load;

/// A renderer with lights and no occluders; rays see black.
struct Lights(Vec<Arc<dyn LightShader>>);

impl Tracer for Lights {
    fn light_count(&self) -> usize {
        self.0.len()
    }

    fn illuminate(&mut self, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        out.reset(hits.len());
        self.0[light].illuminate(&hits.p, &hits.ns, &[], out);
    }

    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        transmittance.reset(request.rays.len(), [1.0; 3].into());
    }

    fn trace(&mut self, _depth: u32, request: &RayRequest, radiance: &mut Vec3s) {
        radiance.reset(request.rays.len(), [0.0; 3].into());
    }

    fn random(&self, _key: SampleKey, _depth: u32, _purpose: u32) -> [f32; 2] {
        [0.5; 2]
    }
}

fn lights(count: usize) -> Lights {
    let class = classes::find("SpotLightShader").expect("a built-in class");
    let light = |i: usize| {
        let point = vec![i as f32, 2.0, 5.0];
        match class.make(&Values(vec![Value::Floats(vec![9.0; 3]), Value::Floats(point)])) {
            RenderShader::Light(light) => light,
            _ => panic!("it is a light"),
        }
    };
    Lights((0..count).map(light).collect())
}

/// Points of a wavy floor, seen from above.
fn points(n: usize) -> SurfaceBatch {
    let mut hits = SurfaceBatch { attributes: vec![vec![1.0; n]], ..SurfaceBatch::default() };
    for i in 0..n {
        let (x, y) = ((i % 16) as f32 * 0.1, (i / 16) as f32 * 0.1);
        hits.p.push([x, y, 0.0].into());
        hits.ng.push([0.0, 0.0, 1.0].into());
        let tilt = 0.3 * (7.0 * x).sin();
        hits.ns.push([tilt, 0.0, (1.0 - tilt * tilt).sqrt()].into());
        hits.ray_dir.push([0.0, 0.0, -1.0].into());
        hits.lift.push([0.0; 3].into());
        hits.dp_du.push([0.0; 3].into());
        hits.dp_dv.push([0.0; 3].into());
        hits.color.push([1.0; 3].into());
    }
    let ones = || vec![1.0; n];
    (hits.error, hits.t, hits.u, hits.v, hits.alpha) = (ones(), ones(), ones(), ones(), ones());
    hits.texcoord = [ones(), ones()];
    (hits.prim_id, hits.geom_id, hits.inst_id) = (vec![0; n], vec![0; n], vec![0; n]);
    hits.key = vec![SampleKey::default(); n];
    hits
}

/// DiffuseShader built in, and `diffuse` of examples/plugins/c.
fn both() -> [Arc<dyn SurfaceShader>; 2] {
    let folder = tempfile::tempdir().expect("a folder");
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/");
    let file = folder.path().join("diffuse.so");
    let status = Command::new("cc")
        .args(["-std=c99", "-O3", "-shared", "-fPIC", "-I"])
        .args([
            &format!("{root}../../bindings/openrt/include"),
            &format!("{root}../../examples/plugins/c/diffuse.c"),
            "-o",
        ])
        .arg(&file)
        .status();
    assert!(status.is_ok_and(|status| status.success()), "the plugin is built");
    let class = Arc::new(load("diffuse", &file.display().to_string()).expect("it is sound"));
    let block = PluginBlock::new(&class).expect("no exception");
    let color = [0.75_f32, 0.5, 0.25];
    block.write(0, &color.map(f32::to_ne_bytes).concat());
    let frame = PluginFrame::new([(1, &block)].into_iter(), FrameState::default);
    let built_in = classes::find("DiffuseShader").expect("a built-in class");
    let built_in = built_in.make(&Values(vec![Value::Floats(color.to_vec())]));
    let surface = |made| match made {
        Some(RenderShader::Surface(surface)) => surface,
        _ => panic!("it is a surface"),
    };
    [surface(Some(built_in)), surface(frame.made(1))]
}

/// Seconds of this thread for some calls.
fn seconds(shader: &dyn SurfaceShader, tracer: &mut Lights, hits: &SurfaceBatch, out: &mut Vec3s) -> f64 {
    let now = || {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    };
    let start = now();
    for _ in 0..20 {
        out.reset(hits.len(), [0.0; 3].into());
        shader.radiance().expect("it shades").shade(tracer, hits, out);
    }
    (now() - start) / 20.0
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn plugins_shade_the_same() {
    let [built_in, plugin] = both();
    for n in [1, 5, 16, 64, 100] {
        let (hits, mut tracer) = (points(n), lights(3));
        let shade = |shader: &dyn SurfaceShader, tracer: &mut Lights| {
            let mut out = Vec3s::splat(n, [0.0; 3].into());
            shader.radiance().expect("it shades").shade(tracer, &hits, &mut out);
            out
        };
        let (expected, read_back) = (shade(&*built_in, &mut tracer), shade(&*plugin, &mut tracer));
        assert!(expected.x.iter().all(|&x| x > 0.0), "all is lit");
        assert_eq!(read_back, expected, "{n} lanes, bit for bit");
    }
}

#[test]
#[ignore = "it measures: give it a quiet machine"]
fn plugin_cost() {
    let [built_in, plugin] = both();
    for (n, light_count) in [(64, 1), (64, 3), (256, 1), (256, 3), (256, 8)] {
        let (hits, mut tracer) = (points(n), lights(light_count));
        let mut out = Vec3s::default();
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..2000 {
            times[0].push(seconds(&*built_in, &mut tracer, &hits, &mut out));
            times[1].push(seconds(&*plugin, &mut tracer, &hits, &mut out));
        }
        let [a, b] = times.map(median);
        let per_point = |seconds: f64| seconds * 1e9 / n as f64;
        eprintln!(
            "{n} points, {light_count} lights: built in {:.2} ns, plugin {:.2} ns per point, ratio {:.3}",
            per_point(a),
            per_point(b),
            b / a
        );
        assert!(b < 1.15 * a, "a plugin's shading costs less than 1.15 times as much");
    }
}
