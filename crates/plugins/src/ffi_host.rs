// SPDX-License-Identifier: GPL-3.0-or-later
//! Services of the host for plugins: the functions of `RTShost`, on the renderer's `Tracer`.
//! Space: world. Each takes a whole batch. A ray that leaves a point of its batch starts off the
//! surface as the rays of built-in shaders do, so that a plugin's picture can equal theirs bit for bit.
//! Invariant: no panic crosses to the plugin; it resumes after the callback has returned.
//! Tests: bindings/openrt/tests/plugins.rs (C against built-in, bit for bit).

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use gnurt::accel::Ray;
use gnurt::shading::classes::ParameterRate;
use gnurt::shading::{SurfaceBatch, Tracer};

use crate::ffi_lanes::Buffers;
use crate::ffi_rts::{Ctx, Hits, Host, RTS_ABI, Rays, Vec3In, Vec3Out, read_sized, text};
use crate::ffi_stack;
use crate::frame_shader::FrameShader;
use crate::print_line::print_line;

/// The host's functions.
pub(crate) static HOST: Host = Host {
    struct_size: size_of::<Host>() as u32,
    abi: RTS_ABI,
    param,
    light_count,
    illuminate,
    occluded,
    trace,
    texture,
    scratch,
    log,
};

/// The data of a surface's callback.
pub(crate) struct Surface<'a> {
    pub(crate) tracer: &'a mut (dyn Tracer + 'a),
    pub(crate) hits: &'a SurfaceBatch,
    /// Where the plugin sees the points of `hits`: x, y, z.
    points: [*const f32; 3],
    /// Rays that each lane has sent: no two get the same random numbers.
    sent: Vec<u32>,
}

/// A call of a plugin.
pub(crate) struct Call<'a> {
    pub(crate) shader: &'a FrameShader,
    pub(crate) surface: Option<Surface<'a>>,
    pub(crate) buffers: Buffers,
    panic: Option<Box<dyn Any + Send>>,
}

impl<'a> Call<'a> {
    pub(crate) fn new(shader: &'a FrameShader) -> Self {
        Self { shader, surface: None, buffers: Buffers::take(), panic: None }
    }

    pub(crate) fn of_surface(
        shader: &'a FrameShader,
        tracer: &'a mut (dyn Tracer + 'a),
        hits: &'a SurfaceBatch,
    ) -> Self {
        Self {
            surface: Some(Surface { tracer, hits, points: [std::ptr::null(); 3], sent: Vec::new() }),
            ..Self::new(shader)
        }
    }

    /// Where the plugin sees the points of its batch.
    pub(crate) fn points_at(&mut self, points: Vec3In) {
        if let Some(surface) = &mut self.surface {
            surface.points = [points.x, points.y, points.z];
        }
    }

    /// Calls a plugin's function, which gets this as its context. If an exception leaves it, that is counted.
    pub(crate) fn run(&mut self, work: impl FnOnce(*const Host, *mut Ctx)) {
        let shader = self.shader;
        let mut context = Context { thread: thread(), shader, call: self };
        let ctx = (&raw mut context).cast();
        if shader.class().library.call(|| work(&raw const HOST, ctx)).is_err() {
            shader.faults.add_exception();
        }
        if let Some(panic) = self.panic.take() {
            resume_unwind(panic);
        }
    }

    /// The call is over.
    pub(crate) fn finish(self) {
        self.buffers.give_back();
    }
}

/// The target of an `RTSctx` during a callback.
struct Context<'c, 'a> {
    /// The callback's thread.
    thread: usize,
    shader: &'a FrameShader,
    call: *mut Call<'c>,
}

/// A number of this thread that no other living thread has.
fn thread() -> usize {
    thread_local! {
        static HERE: u8 = const { 0 };
    }
    HERE.with(|here| std::ptr::from_ref(here).addr())
}

/// Runs a service on the call of `ctx`. After a panic, without a call, and on another thread than the
/// callback's, the result is `otherwise`.
///
/// # Safety
/// `ctx` is null or was passed by [`Call::run`] to the plugin, whose callback has not returned yet.
unsafe fn serve<T>(ctx: *mut Ctx, otherwise: T, work: impl FnOnce(&mut Call<'_>) -> T) -> T {
    // SAFETY: guaranteed by the caller; a context is never written.
    let Some(context) = (unsafe { ctx.cast::<Context<'_, '_>>().as_ref() }) else { return otherwise };
    if context.thread != thread() {
        context.shader.faults.add_stray();
        return otherwise;
    }
    // SAFETY: `Call::run` uses nothing of the call meanwhile; this is the thread of the callback, which is in this service.
    let call = unsafe { &mut *context.call };
    match catch_unwind(AssertUnwindSafe(|| work(call))) {
        Ok(result) => result,
        Err(panic) => {
            call.panic.get_or_insert(panic);
            otherwise
        }
    }
}

/// Lane `i` of three arrays.
///
/// # Safety
/// The arrays have more than `i` floats.
unsafe fn lane(v: Vec3In, i: usize) -> [f32; 3] {
    // SAFETY: the caller vouches for it; plugins need not align it.
    unsafe { [v.x.add(i).read_unaligned(), v.y.add(i).read_unaligned(), v.z.add(i).read_unaligned()] }
}

/// Writes values to a plugin's array, unless that is null.
///
/// # Safety
/// An array that is not null has room for them and does not overlap them.
unsafe fn put<T: Copy>(array: *mut T, values: &[T]) {
    if !array.is_null() {
        let bytes = size_of_val(values);
        // SAFETY: the caller vouches for the room.
        unsafe { values.as_ptr().cast::<u8>().copy_to_nonoverlapping(array.cast::<u8>(), bytes) };
    }
}

/// Writes `n` times the same.
///
/// # Safety
/// An array that is not null has room for `n`.
unsafe fn fill<T: Copy>(array: *mut T, n: usize, value: T) {
    if !array.is_null() {
        for i in 0..n {
            // SAFETY: the caller vouches for the room.
            unsafe { array.add(i).write_unaligned(value) };
        }
    }
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn param(ctx: *mut Ctx, hits: *const Hits, index: u32, out: *mut f32) {
    // SAFETY: the plugin vouches for its context.
    unsafe {
        serve(ctx, (), |call| {
            let Some(surface) = &call.surface else { return };
            if out.is_null() {
                return;
            }
            let all = surface.hits.len();
            // SAFETY: hits that are not null have their first two members.
            let n = hits.as_ref().map_or(all, |hits| (hits.n as usize).min(all));
            let index = index as usize;
            let Some(p) = call.shader.class().parameters.get(index) else { return };
            if p.description.rate == ParameterRate::Shader {
                for (k, &value) in call.shader.snapshot.numbers(index).iter().enumerate() {
                    // SAFETY: the plugin vouches for count * n floats.
                    fill(out.wrapping_add(k * n), n, value);
                }
            } else if let Some(values) =
                call.shader.attribute(index).and_then(|a| surface.hits.attributes.get(a))
            {
                for (k, values) in values.chunks_exact(all).enumerate() {
                    // SAFETY: as above.
                    put(out.wrapping_add(k * n), &values[..n]);
                }
            }
        });
    }
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn light_count(ctx: *mut Ctx) -> u32 {
    // SAFETY: the plugin vouches for its context.
    unsafe {
        serve(ctx, 0, |call| call.surface.as_ref().map_or(0, |surface| surface.tracer.light_count() as u32))
    }
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn illuminate(
    ctx: *mut Ctx,
    light: u32,
    n: u32,
    p: Vec3In,
    dir: Vec3Out,
    dist: *mut f32,
    radiance: Vec3Out,
    lit: *mut u8,
) {
    let n = n as usize;
    // SAFETY: the plugin vouches for its context and for n lanes of each array; null ones are left out.
    unsafe {
        fill(lit, n, 0);
        serve(ctx, (), |call| {
            let Some(surface) = &mut call.surface else { return };
            let given = [p.x, p.y, p.z];
            let is_missing = given.iter().any(|array| array.is_null());
            if light as usize >= surface.tracer.light_count() || n == 0 || is_missing {
                return;
            }
            let out = &mut call.buffers.light;
            // The batch's own points: a plugin may not change them.
            if surface.hits.len() == n && given == surface.points {
                surface.tracer.illuminate(light as usize, surface.hits, out);
            } else {
                let lanes: Vec<u32> = (0..n).map(|i| (i % surface.hits.len()) as u32).collect();
                let mut points = surface.hits.gather(&lanes);
                (0..n).for_each(|i| points.p.set(i, lane(p, i).into()));
                surface.tracer.illuminate(light as usize, &points, out);
            }
            for (array, values) in
                [(dir.x, &out.dir.x), (dir.y, &out.dir.y), (dir.z, &out.dir.z), (dist, &out.dist)]
            {
                put(array, values);
            }
            let arriving = &out.radiance;
            for (array, values) in
                [(radiance.x, &arriving.x), (radiance.y, &arriving.y), (radiance.z, &arriving.z)]
            {
                put(array, values);
            }
            if !lit.is_null() {
                let lit = std::slice::from_raw_parts_mut(lit, n);
                let colors = arriving.x.iter().zip(&arriving.y).zip(&arriving.z);
                for (lit, ((r, g), b)) in lit.iter_mut().zip(colors) {
                    *lit = u8::from((*r != 0.0) | (*g != 0.0) | (*b != 0.0));
                }
            }
        });
    }
}

/// The purpose of a batch of rays.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Shadow,
    Radiance,
}

/// The plugin's rays as a request; false if there are none.
///
/// # Safety
/// As openrt/rts.h says of `RTSrays`.
unsafe fn request(surface: &mut Surface<'_>, buffers: &mut Buffers, rays: &Rays, purpose: Purpose) -> bool {
    let request = &mut buffers.request;
    request.rays.clear();
    request.parent.clear();
    request.key.clear();
    let hits = surface.hits;
    let missing =
        [rays.org.x, rays.org.y, rays.org.z, rays.dir.x, rays.dir.y, rays.dir.z, rays.tmin, rays.tmax];
    if missing.iter().any(|array| array.is_null()) || hits.is_empty() {
        return false;
    }
    surface.sent.resize(hits.len(), 0);
    for i in 0..rays.n as usize {
        // SAFETY: the plugin vouches for n lanes of each array.
        let (org, dir, t_near, t_far) = unsafe {
            let ends = (rays.tmin.add(i).read_unaligned(), rays.tmax.add(i).read_unaligned());
            (lane(rays.org, i), lane(rays.dir, i), ends.0, ends.1)
        };
        let parent = if rays.parent.is_null() {
            i % hits.len()
        } else {
            // SAFETY: as above. A lane that is not there becomes the last one.
            (unsafe { rays.parent.add(i).read_unaligned() } as usize).min(hits.len() - 1)
        };
        let square = dir.iter().map(|x| x * x).sum::<f32>();
        // Unit directions stay as they are, bit for bit.
        let length = if (square - 1.0).abs() < 1e-5 { 1.0 } else { square.sqrt() };
        let usable = length > 0.0 && length.is_finite();
        let dir = if length == 1.0 || !usable { dir } else { dir.map(|x| x / length) };
        let (t_near, t_far) =
            if usable { ((t_near * length).max(0.0), t_far * length) } else { (t_near, t_far) };
        let ray = if org == <[f32; 3]>::from(hits.p.get(parent)) {
            let ray = if purpose == Purpose::Shadow && t_far.is_finite() {
                hits.spawn_to(parent, dir.into(), t_far)
            } else {
                hits.spawn(parent, dir.into(), t_far)
            };
            ray.within(ray.t_near.max(t_near), ray.t_far)
        } else {
            Ray::new(org, dir).within(t_near, t_far)
        };
        request.rays.push(ray);
        request.parent.push(parent as u32);
        let key = hits.key[parent];
        request.key.push(match purpose {
            Purpose::Shadow => key,
            Purpose::Radiance => {
                let fork = surface.sent[parent];
                surface.sent[parent] += 1;
                key.fork(fork)
            }
        });
    }
    !request.rays.is_empty()
}

/// Answers a plugin's rays; `otherwise` where there is no surface to send them from.
///
/// # Safety
/// As openrt/rts.h says of `occluded` and `trace`.
unsafe fn answer(ctx: *mut Ctx, rays: *const Rays, out: Vec3Out, purpose: Purpose, otherwise: f32) {
    if rays.is_null() {
        return;
    }
    // SAFETY: rays that are not null have as many bytes as they say.
    let rays = unsafe { read_sized(rays) };
    // SAFETY: the plugin vouches for its context and for n lanes of each array.
    unsafe {
        for array in [out.x, out.y, out.z] {
            fill(array, rays.n as usize, otherwise);
        }
        serve(ctx, (), |call| {
            let Some(surface) = &mut call.surface else { return };
            if purpose == Purpose::Radiance && !ffi_stack::is_enough() {
                call.shader.faults.add_untraced(rays.n.into());
                return;
            }
            if !request(surface, &mut call.buffers, &rays, purpose) {
                return;
            }
            let Buffers { request, answer, .. } = &mut call.buffers;
            match purpose {
                Purpose::Shadow => surface.tracer.occluded(request, answer),
                Purpose::Radiance => surface.tracer.trace(surface.hits.depth, request, answer),
            }
            for (array, values) in [(out.x, &answer.x), (out.y, &answer.y), (out.z, &answer.z)] {
                put(array, values);
            }
        });
    }
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn occluded(ctx: *mut Ctx, rays: *const Rays, transmittance: Vec3Out) {
    // SAFETY: the plugin vouches for its arguments.
    unsafe { answer(ctx, rays, transmittance, Purpose::Shadow, 1.0) }
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn trace(ctx: *mut Ctx, rays: *const Rays, radiance: Vec3Out) {
    // SAFETY: the plugin vouches for its arguments.
    unsafe { answer(ctx, rays, radiance, Purpose::Radiance, 0.0) }
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn texture(
    ctx: *mut Ctx,
    texture: u32,
    n: u32,
    s: *const f32,
    t: *const f32,
    rgb: Vec3Out,
    alpha: *mut f32,
) {
    let n = n as usize;
    // SAFETY: the plugin vouches for its context and for n lanes of each array; null ones are left out.
    unsafe {
        for array in [rgb.x, rgb.y, rgb.z, alpha] {
            fill(array, n, 1.0);
        }
        serve(ctx, (), |call| {
            let Some(sampler) = call.shader.frame.textures.get(&texture) else { return };
            if s.is_null() || t.is_null() {
                return;
            }
            for i in 0..n {
                let read_back = sampler.sample([s.add(i).read_unaligned(), t.add(i).read_unaligned()]);
                for (array, value) in [rgb.x, rgb.y, rgb.z, alpha].into_iter().zip(read_back) {
                    fill(array.wrapping_add(if array.is_null() { 0 } else { i }), 1, value);
                }
            }
        });
    }
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn scratch(ctx: *mut Ctx, bytes: usize) -> *mut c_void {
    // SAFETY: the plugin vouches for its context.
    unsafe { serve(ctx, std::ptr::null_mut(), |call| call.buffers.scratch.bytes(bytes).cast()) }
}

thread_local! {
    /// Messages of a `prepare` that runs on this thread.
    static MESSAGES: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
    /// Whether messages are printed.
    static SILENT: RefCell<bool> = const { RefCell::new(false) };
}

/// Runs `work` and returns its messages through `log` without a context. If `aloud`, they are printed as
/// well.
pub(crate) fn collect_log<T>(work: impl FnOnce() -> T, aloud: bool) -> (T, Vec<String>) {
    MESSAGES.set(Some(Vec::new()));
    SILENT.set(!aloud);
    let result = work();
    SILENT.set(false);
    (result, MESSAGES.take().unwrap_or_default())
}

/// # Safety
/// As openrt/rts.h says.
unsafe extern "C" fn log(ctx: *mut Ctx, level: c_int, message: *const c_char) {
    // SAFETY: the plugin vouches for the text.
    let Some(message) = (unsafe { text(message) }) else { return };
    let message = message.to_string_lossy().into_owned();
    let grade = match level {
        i32::MIN..=0 => "",
        1 => "warning: ",
        _ => "error: ",
    };
    if ctx.is_null() {
        let printed = catch_unwind(|| {
            if !SILENT.with_borrow(|silent| *silent) {
                print_line(format_args!("plugin: {grade}{message}"));
            }
            MESSAGES.with_borrow_mut(|messages| messages.as_mut().map(|messages| messages.push(message)));
        });
        // A text that cannot be stored cannot be reported either.
        return drop(printed);
    }
    // SAFETY: the plugin vouches for its context.
    unsafe {
        serve(ctx, (), |call| {
            if call.shader.faults.may_speak() {
                print_line(format_args!("{}: {grade}{message}", call.shader.class().title()));
            }
        });
    }
}
