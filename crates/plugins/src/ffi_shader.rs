// SPDX-License-Identifier: GPL-3.0-or-later
//! Plugins as shaders of the renderer: batches out to C, results back, checked lane by lane.
//! Space: world. Invariant: results that a plugin leaves unwritten, or fills with NaN or infinities, become
//! black, unlit or a ray that hits nothing, and are counted. Tests: bindings/openrt/tests/plugins.rs.

use std::sync::Arc;

use gnurt::accel::{Ray, RayBatch};
use gnurt::scene::TEXCOORD_RQ;
use gnurt::shading::classes::Shader as RenderShader;
use gnurt::shading::{
    AttributeRequest, CameraSamples, CameraShader, EnvironmentShader, LightBatch, LightShader,
    RadianceShader, SurfaceBatch, SurfaceShader, Tracer, Vec3s,
};

use crate::description::Kind;
use crate::ffi_host::Call;
use crate::ffi_lanes::Lanes;
use crate::ffi_rts::{Hits, Rays, ShadeFn, Vec3In, Vec3Out};
use crate::frame_shader::FrameShader;

/// Name of the mesh attribute, two floats per triangle, with its index among those of its object: the low and
/// the high 16 bits.
pub const TRIANGLE_NUMBER: &str = "openrt.triangle_number";

/// A plugin's shader in one frame, and its requests to meshes.
struct PluginShader {
    shader: FrameShader,
    /// One per parameter that varies, in the order of the parameters; third texture coordinates, if there are any; then
    /// the numbers of triangles.
    attributes: Vec<AttributeRequest>,
    /// Where among them the third texture coordinates are.
    third_texcoords: Option<usize>,
}

/// The shader as the renderer takes it.
pub(crate) fn make(shader: FrameShader) -> RenderShader {
    let (kind, mut attributes) = (shader.class().kind, shader.varying());
    let mut third_texcoords = None;
    if kind == Kind::Surface && shader.frame.third_texcoords {
        third_texcoords = Some(attributes.len());
        let (name, default) = (TEXCOORD_RQ.to_owned(), vec![0.0, 1.0]);
        attributes.push(AttributeRequest { name, components: 2, default });
    }
    if kind == Kind::Surface {
        // Less than 0 = the mesh's own numbers.
        let (name, default) = (TRIANGLE_NUMBER.to_owned(), vec![-1.0; 2]);
        attributes.push(AttributeRequest { name, components: 2, default });
    }
    let shader = Arc::new(PluginShader { shader, attributes, third_texcoords });
    match kind {
        Kind::Surface | Kind::RenderingObject => RenderShader::Surface(shader),
        Kind::Environment => RenderShader::Environment(shader),
        Kind::Light => RenderShader::Light(shader),
        Kind::Camera => RenderShader::Camera(shader),
    }
}

/// Arrays of a surface batch, results included.
const SURFACE_ARRAYS: usize = 12 + 3 + 6 + 1 + 4 + 1 + 3;

impl PluginShader {
    /// Calls `shade` or `transmit`.
    fn call_surface(&self, function: ShadeFn, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let n = hits.len();
        if n == 0 {
            return;
        }
        let mut call = Call::of_surface(&self.shader, tracer, hits);
        let mut arrays = call.buffers.arrays(n, SURFACE_ARRAYS);
        let batch = self.hits(hits, &mut arrays);
        call.points_at(batch.p);
        let result = arrays.unwritten_vectors();
        // SAFETY: the function is the class's; batch and result are as openrt/rts.h says and live through the call.
        call.run(|host, ctx| unsafe { function(host, ctx, &raw const batch, result) });
        self.take(&arrays, result, out);
        call.finish();
    }

    /// The batch as plugins see it.
    fn hits(&self, hits: &SurfaceBatch, arrays: &mut Lanes) -> Hits {
        let n = hits.len();
        Hits {
            struct_size: size_of::<Hits>() as u32,
            n: n as u32,
            shader: self.shader.snapshot.pointer(),
            p: arrays.vectors(&hits.p),
            ng: arrays.vectors(&hits.ng),
            ns: arrays.vectors(&hits.ns),
            ray_dir: arrays.vectors(&hits.ray_dir),
            t: arrays.floats(&hits.t),
            b1: arrays.floats(&hits.u),
            b2: arrays.floats(&hits.v),
            color: arrays.vectors(&hits.color),
            texcoord: Vec3In {
                x: arrays.floats(&hits.texcoord[0]),
                y: arrays.floats(&hits.texcoord[1]),
                z: arrays.floats_by(self.third_texcoord(hits)),
            },
            alpha: arrays.floats(&hits.alpha),
            object: arrays.integers(self.api_ids(hits, 0)),
            instance: arrays.integers(self.api_ids(hits, 1)),
            triangle: arrays.integers((0..n).map(triangle_of(hits))),
            depth: arrays.integers(std::iter::repeat_n(hits.depth, n)),
            back: arrays.bytes(backs(&hits.ng, &hits.ray_dir)),
        }
    }

    /// The third texture coordinate of each lane, divided as the other two are.
    fn third_texcoord<'a>(&self, hits: &'a SurfaceBatch) -> impl Fn(usize) -> f32 + use<'a> {
        let both = self.third_texcoords.and_then(|i| hits.attributes.get(i));
        move |i| both.map_or(0.0, |rq| rq[i] / rq[hits.len() + i])
    }

    /// Ids of objects (0) or instances (1) in the API.
    fn api_ids(&self, hits: &SurfaceBatch, which: usize) -> impl Iterator<Item = u32> {
        let id = move |inst_id: u32| self.shader.frame.ids.get(inst_id as usize).map_or(0, |ids| ids[which]);
        // Neighbours are of one instance most of the time.
        let mut last = hits.inst_id.first().map_or((0, 0), |&inst_id| (inst_id, id(inst_id)));
        hits.inst_id.iter().map(move |&inst_id| {
            if inst_id != last.0 {
                last = (inst_id, id(inst_id));
            }
            last.1
        })
    }

    /// Takes a plugin's colours; invalid ones become black and are counted.
    fn take(&self, arrays: &Lanes, result: Vec3Out, out: &mut Vec3s) {
        // SAFETY: the result is of these arrays, and the plugin's call is over.
        let [x, y, z] = [result.x, result.y, result.z].map(|array| unsafe { arrays.written(array) });
        for (array, values) in [(&mut out.x, x), (&mut out.y, y), (&mut out.z, z)] {
            array.clear();
            array.extend_from_slice(values);
        }
        if [x, y, z].into_iter().all(all_finite) {
            return;
        }
        let is_bad = |i: usize| !(x[i].is_finite() & y[i].is_finite() & z[i].is_finite());
        let bad = (0..x.len()).filter(|&i| is_bad(i));
        self.shader.faults.add(bad.map(|i| out.set(i, [0.0; 3].into())).count() as u64);
    }
}

/// The number of each lane's triangle in its object.
fn triangle_of(hits: &SurfaceBatch) -> impl Fn(usize) -> u32 {
    let numbers = hits.attributes.last().filter(|numbers| numbers.len() == 2 * hits.len());
    move |i| match numbers {
        Some(halves) if halves[i] >= 0.0 => halves[i] as u32 | ((halves[hits.len() + i] as u32) << 16),
        _ => hits.prim_id[i],
    }
}

/// 1 where a normal points in the direction of the ray.
fn backs(ng: &Vec3s, ray_dir: &Vec3s) -> impl Iterator<Item = u8> {
    let x = ng.x.iter().zip(&ray_dir.x).map(|(a, b)| a * b);
    let y = ng.y.iter().zip(&ray_dir.y).map(|(a, b)| a * b);
    let z = ng.z.iter().zip(&ray_dir.z).map(|(a, b)| a * b);
    x.zip(y).zip(z).map(|((x, y), z)| u8::from(x + y + z > 0.0))
}

/// Whether there is neither NaN nor infinity. By bits and without branches: many at a time.
fn all_finite(values: &[f32]) -> bool {
    const EXPONENT: u32 = 0x7F80_0000;
    values.iter().fold(0, |bad, x| bad | u32::from(x.to_bits() & EXPONENT == EXPONENT)) == 0
}

impl RadianceShader for PluginShader {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if let Some(shade) = self.shader.class().calls.shade {
            self.call_surface(shade, tracer, hits, out);
        }
    }
}

impl SurfaceShader for PluginShader {
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        Some(self)
    }

    fn transmit(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        if let Some(transmit) = self.shader.class().calls.transmit {
            self.call_surface(transmit, tracer, hits, out);
        }
    }

    fn is_opaque(&self) -> bool {
        self.shader.class().calls.transmit.is_none()
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.attributes
    }
}

impl LightShader for PluginShader {
    fn illuminate(&self, p: &Vec3s, _: &Vec3s, _: &[[f32; 2]], out: &mut LightBatch) {
        let Some(function) = self.shader.class().calls.illuminate.filter(|_| !p.is_empty()) else { return };
        let mut call = Call::new(&self.shader);
        let mut arrays = call.buffers.arrays(p.len(), 3 + 3 + 1 + 3 + 1);
        let points = arrays.vectors(p);
        let (dir, dist, radiance) =
            (arrays.unwritten_vectors(), arrays.unwritten(), arrays.unwritten_vectors());
        let lit = arrays.bytes(std::iter::repeat_n(0, p.len()));
        let (block, n) = (self.shader.snapshot.pointer(), p.len() as u32);
        // SAFETY: the function is the class's; all arrays are as openrt/rts.h says and live through the call.
        call.run(|host, ctx| unsafe { function(host, ctx, block, n, points, dir, dist, radiance, lit) });
        // SAFETY: the plugin's call is over.
        let written = |array| unsafe { arrays.written(array) };
        let [dir, radiance] = [dir, radiance].map(|v| [written(v.x), written(v.y), written(v.z)]);
        let dist = written(dist);
        // SAFETY: one byte per lane, all of them written.
        let lit = unsafe { std::slice::from_raw_parts(lit, p.len()) };
        let mut bad = 0;
        for i in (0..p.len()).filter(|&i| lit[i] != 0) {
            let [towards, arriving] = [dir, radiance].map(|v| v.map(|array| array[i]));
            // The distance may be infinite.
            let good = arriving.iter().all(|x| x.is_finite()) && dist[i] >= 0.0;
            match unit(towards).filter(|_| good) {
                Some(towards) => {
                    out.dir.set(i, towards.into());
                    out.dist[i] = dist[i];
                    out.radiance.set(i, arriving.into());
                }
                None => bad += 1,
            }
        }
        self.shader.faults.add(bad);
        call.finish();
    }
}

impl CameraShader for PluginShader {
    fn rays(&self, samples: &CameraSamples, _aspect: f32, out: &mut RayBatch) {
        let (calls, xy) = (self.shader.class().calls, samples.positions);
        if xy.is_empty() || (calls.camera.is_none() && calls.camera_lens.is_none()) {
            return;
        }
        let mut call = Call::new(&self.shader);
        let mut arrays = call.buffers.arrays(xy.len(), 2 + 3 + 6);
        let [x, y] = [0, 1].map(|k| arrays.floats_by(|i| xy[i][k]));
        let (org, dir) = (arrays.unwritten_vectors(), arrays.unwritten_vectors());
        let (block, n) = (self.shader.snapshot.pointer(), xy.len() as u32);
        if let Some(function) = calls.camera_lens {
            let [lens_x, lens_y] = [0, 1].map(|k| arrays.floats_by(|i| samples.lens(i)[k]));
            let time = arrays.floats_by(|i| samples.time(i));
            let run = |host, ctx| {
                // SAFETY: the function is the class's; all arrays are as openrt/rts.h says and live through the call.
                unsafe { function(host, ctx, block, n, x, y, lens_x, lens_y, time, org, dir) }
            };
            call.run(run);
        } else if let Some(function) = calls.camera {
            // SAFETY: as above.
            call.run(|host, ctx| unsafe { function(host, ctx, block, n, x, y, org, dir) });
        }
        // SAFETY: the plugin's call is over.
        let written = |v: Vec3Out| [v.x, v.y, v.z].map(|array| unsafe { arrays.written(array) });
        let (org, dir) = (written(org), written(dir));
        let mut bad = 0;
        for i in 0..xy.len() {
            let org = org.map(|array| array[i]);
            let dir = unit(dir.map(|array| array[i])).filter(|_| org.iter().all(|x| x.is_finite()));
            bad += u64::from(dir.is_none());
            // A ray without direction hits nothing.
            out.push(dir.map_or(Ray::new([0.0; 3], [0.0; 3]), |dir| Ray::new(org, dir)));
        }
        self.shader.faults.add(bad);
        call.finish();
    }

    fn has_lens(&self) -> bool {
        self.shader.class().calls.camera_lens.is_some()
    }
}

impl EnvironmentShader for PluginShader {
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s) {
        let Some(function) = self.shader.class().calls.miss.filter(|_| !dir.is_empty()) else { return };
        let mut call = Call::new(&self.shader);
        let mut arrays = call.buffers.arrays(dir.len(), 3 + 3 + 5);
        let zeros = arrays.floats_by(|_| 0.0);
        let rays = Rays {
            struct_size: size_of::<Rays>() as u32,
            n: dir.len() as u32,
            org: Vec3In { x: zeros, y: zeros, z: zeros },
            dir: arrays.vectors(dir),
            tmin: zeros,
            tmax: arrays.floats_by(|_| f32::INFINITY),
            parent: arrays.integers(0..dir.len() as u32),
            weight: arrays.floats_by(|_| 1.0),
        };
        let result = arrays.unwritten_vectors();
        let block = self.shader.snapshot.pointer();
        // SAFETY: the function is the class's; rays and result are as openrt/rts.h says and live through the call.
        call.run(|host, ctx| unsafe { function(host, ctx, block, &raw const rays, result) });
        self.take(&arrays, result, out);
        call.finish();
    }
}

/// A direction of length 1; `None` if it is none. One that has length 1 already stays as it is.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let square = v.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>();
    if (square - 1.0).abs() < 1e-6 {
        return Some(v);
    }
    let length = square.sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|x| (f64::from(x) / length) as f32))
}
